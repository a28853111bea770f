"""Pages of runs, written once, in a browser, and their scripts without one."""

from __future__ import annotations

import pytest

from renders.player import write_player
from renders.story import story_of
from renders.style import Style
from tests.renders.page_scripts import Scripts


@pytest.fixture(scope="module")
def files(run, tmp_path_factory):
    """Write the page of a run of the paper's case, or of another built-in one."""
    folder = tmp_path_factory.mktemp("player")

    def write(name="paper", theme="light", *changes):
        file = folder / f"{'-'.join((name, theme, *changes))}.html"
        if not file.exists():
            write_player(story_of([run(name, *changes)], Style(theme=theme)), file)
        return file

    return write


@pytest.fixture
def player(page, files):
    """The paper's run in a browser."""
    page.goto(files().as_uri())
    return page


@pytest.fixture(scope="module")
def story(run):
    return story_of([run("paper")])


@pytest.fixture(scope="module")
def scripts(story):
    return Scripts(story)

"""Pages of runs, written once."""

from __future__ import annotations

import pytest

from oblique_impact.renders.player import write_player
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style


@pytest.fixture(scope="session")
def files(run, tmp_path_factory):
    """Write the page of a run of the paper's case, or of another built-in one."""
    folder = tmp_path_factory.mktemp("player")

    def write(name="paper", theme="light", *changes):
        file = folder / f"{'-'.join((name, theme, *changes))}.html"
        if not file.exists():
            write_player(story_of([run(name, *changes)], Style(theme=theme)), file)
        return file

    return write


@pytest.fixture(scope="session")
def folder(run, tmp_path_factory):
    """The paper's case as a run leaves it."""
    return run("paper").save(tmp_path_factory.mktemp("runs") / "paper")


@pytest.fixture(scope="module")
def story(run):
    return story_of([run("paper")])

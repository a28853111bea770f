"""Pages of runs, written once, in a browser, and their scripts without one."""

from __future__ import annotations

from typing import Any

import pytest

from oblique_impact.renders.player import write_player
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style
from tests.conftest import watched
from tests.renders.browsing import seek
from tests.renders.page_scripts import Scripts

#: all that a reader can choose; time is not among it
_CHOICES = """[document.documentElement.dataset.theme, player.now().playing, scrollX, scrollY, location.hash,
    document.activeElement.tagName, ...["by", "x", "y"].map(name => player.zoom[name]),
    ...[...document.querySelectorAll("select, input[type=checkbox], [role=tab]")].map(
        e => `${e.id} ${e.value} ${e.checked} ${e.disabled} ${e.ariaSelected}`)]"""


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


class Tab:
    """A page of the browser that the tests of a module open again: a new one takes most of a second."""

    def __init__(self, browser: Any) -> None:
        self.page, self.faults = watched(browser)
        self.untouched = False  # it has the paper's run as it opens, but for the time

    def open(self, file: Any) -> Any:
        self.page.mouse.move(0, 0)
        self.page.goto("about:blank")
        self.page.goto(file.as_uri())
        return self.page

    def check(self) -> None:
        faults, self.faults[:] = self.faults[:], []
        assert faults == []


@pytest.fixture(scope="module")
def tab(browser):
    tab = Tab(browser)
    yield tab
    tab.page.close()


@pytest.fixture
def player(tab, files):
    """The paper's run in a browser."""
    tab.untouched = False
    yield tab.open(files())
    tab.check()


@pytest.fixture
def opened(tab, files):
    """The paper's run in a browser, for those who change nothing but the time."""
    page = tab.page if tab.untouched else tab.open(files())
    tab.untouched = False
    before = page.evaluate(_CHOICES)
    seek(page, 0.0)
    yield page
    assert page.evaluate(_CHOICES) == before
    tab.check()
    tab.untouched = True


@pytest.fixture(scope="module")
def story(run):
    return story_of([run("paper")])


@pytest.fixture(scope="module")
def scripts(story):
    return Scripts(story)

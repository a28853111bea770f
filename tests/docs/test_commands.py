"""Commands in the documentation: the parser takes them, and what they name exists. Nothing is executed."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from oblique_impact import Scenario
from oblique_impact.command_line.application import application
from oblique_impact.scenario.scenario import builtin_text
from oblique_impact.validation.studies.design import load_plan
from oblique_impact.validation.studies.series import is_study, load_study

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.glob("*.md")), *sorted(DOCS.glob("howto/*.md"))]
PAGES += [*sorted(DOCS.glob("theory/*.md")), *sorted(DOCS.glob("studies/*.md"))]
COMMANDS = application().commands


def blocks(page: Path, language: str) -> list[str]:
    """Code blocks of a page in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


def command_lines(page: Path) -> list[list[str]]:
    """Words of the command lines of this program, in shell blocks and in the text."""
    shell = "".join(blocks(page, "sh")).replace("\\\n", " ").splitlines()
    lines = [shlex.split(line, comments=True) for line in shell]
    lines += [
        shlex.split(found) for found in re.findall(r"`(oblique-impact [a-z][^`]*)`", page.read_text("utf-8"))
    ]
    return [words for words in lines if words[:1] == ["oblique-impact"]]


def parse(words: list[str]) -> dict:
    """Let the parser take a command line; returns what it understood."""
    with COMMANDS[words[1]].make_context(words[1], words[2:]) as context:
        return dict(context.params)


def files_of(page: Path) -> dict[str, str]:
    """Scenario files that a page tells the reader to write: by `init`, or as blocks that begin with a name."""
    found = {}
    for words in command_lines(page):
        if words[1] == "init" and len(words) > 2:
            understood = parse(words)
            found[str(understood["file"])] = builtin_text(understood["base"])
    for text in blocks(page, "toml"):
        if name := re.match(r"# (\S+\.toml)\n", text):
            found[name[1]] = text
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_are_understood_and_name_what_exists(page, monkeypatch):
    files = files_of(page)
    for words in command_lines(page):
        if len(words) == 2:  # a mention of a command
            assert words[1] in COMMANDS
            continue
        understood = parse(words)
        if scenario := understood.get("scenario"):
            changes = understood.get("changes") or []
            monkeypatch.chdir(ROOT)  # of files of the checkout
            if scenario in files:
                Scenario.from_toml(files[scenario], changes)
            elif is_study(scenario):
                assert all(series.changed(changes, ()).runs() for series in load_study(scenario).series)
            else:
                Scenario.load(scenario, changes)
        if (source := understood.get("source")) and source not in files:
            monkeypatch.chdir(ROOT)
            load_plan(source)


@pytest.mark.parametrize("page", [ROOT / "README.md", ROOT / "CONTRIBUTING.md"], ids=lambda p: p.stem)
def test_links_lead_to_files(page):
    """Those of the pages are checked by the build."""
    for target in re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8")):
        assert target.startswith("https://") or (page.parent / target).is_file(), target

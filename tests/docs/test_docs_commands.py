"""Commands in the documentation: the parser takes them, and what they name exists. Nothing is executed."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
import typer

from oblique_impact import Scenario
from oblique_impact.command_line.application import application
from oblique_impact.scenario.scenario import builtin_text
from oblique_impact.validation.checks.registry import all_checks
from oblique_impact.validation.quantities import quantity
from oblique_impact.validation.refinement.shipped import STUDIES
from oblique_impact.validation.sweeps.plan import load_plan, make_plan

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.glob("*.md")), *sorted(DOCS.glob("howto/*.md"))]
PAGES += sorted(DOCS.glob("theory/*.md"))
COMMANDS = typer.main.get_command(application()).commands
OURS = {"mine"}  # a group of checks that the how-to has just written


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


def lines_of(page: Path) -> list[list[str]]:
    """Words of every command line in the shell blocks of a page."""
    text = "".join(blocks(page, "sh")).replace("\\\n", " ")
    return [words for line in text.splitlines() if (words := shlex.split(line, comments=True))]


def inline(page: Path) -> list[list[str]]:
    """Words of the command lines of this program that stand in the text."""
    text = page.read_text(encoding="utf-8")
    return [shlex.split(found) for found in re.findall(r"`(oblique-impact [a-z][^`]*)`", text)]


def parse(words: list[str]) -> dict:
    """Let the parser take a command line; returns what it understood."""
    assert words[1] in COMMANDS, words
    with COMMANDS[words[1]].make_context(words[1], words[2:]) as context:
        return dict(context.params)


def files_of(page: Path) -> dict[str, str]:
    """Files that a page tells the reader to write: by `init`, or as TOML blocks that begin with their name."""
    found = {}
    for words in lines_of(page):
        if words[:2] == ["oblique-impact", "init"]:
            understood = parse(words)
            found[str(understood["file"])] = builtin_text(understood["base"])
    for text in blocks(page, "toml"):
        name = re.match(r"# (\S+\.toml)\n", text)
        if name:
            found[name[1]] = text
    return found


def check_values(understood: dict, files: dict[str, str]) -> None:
    """Scenarios, keys, quantities, studies and checks that a command names exist."""
    scenario = understood.get("scenario")
    if scenario:
        changes = understood.get("changes") or []
        if scenario in files:
            Scenario.from_toml(files[scenario], changes)
        else:
            Scenario.builtin(scenario, changes)
    for name in understood.get("quantities") or []:
        quantity(name)
    if understood.get("base"):
        Scenario.builtin(understood["base"])
    if understood.get("study"):
        assert understood["study"] in STUDIES
    if understood.get("source"):  # of a sweep
        source = understood["source"]
        assert (make_plan(files[source]) if source in files else load_plan(source)).design.size > 1
    if understood.get("only"):
        checks = all_checks()
        assert set(understood["only"]) <= set(checks) | {check.group for check in checks.values()} | OURS


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_are_understood_and_name_what_exists(page):
    files = files_of(page)
    for words in [*lines_of(page), *inline(page)]:
        if words[0] == "oblique-impact" and len(words) == 2:  # a mention of a command
            assert words[1] in COMMANDS
        elif words[0] == "oblique-impact":
            check_values(parse(words), files)
        elif words[0] == "make":
            assert re.search(rf"^{words[1]}:", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
        elif words[0] == "python":
            assert (ROOT / words[1]).is_file(), words
        else:
            assert words[0] in {"cut", "source", "pip", "dask", "jupyter"}, (
                f"{page.name}: a command of a new kind: {words}"
            )


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_options_in_the_text_exist(page):
    known = {option for command in COMMANDS.values() for parameter in command.params for option in parameter.opts}
    for mentioned in re.findall(r"`(--[a-z][^`]*)`", page.read_text(encoding="utf-8")):
        assert {word for word in shlex.split(mentioned) if word.startswith("--")} <= known | {"--help"}, mentioned


@pytest.mark.parametrize("page", [p for p in PAGES if p.parent.name in ("howto", "docs")], ids=lambda p: p.stem)
def test_what_a_command_reads_was_written_by_one_before(page):
    """A reader who types the lines of a page from the top finds every run that they read."""
    written = {"out/paper"}  # by the first run, on which every how-to may build
    for words in lines_of(page):
        if words[0] != "oblique-impact":
            continue
        understood = parse(words)
        for name in ("history", "histories", "left", "right"):
            value = understood.get(name) or []
            for source in value if isinstance(value, (list, tuple)) else [value]:
                assert str(source) in written, f"{page.name}: {' '.join(words)}"
        if understood.get("out"):
            written.add(str(understood["out"]))


@pytest.mark.parametrize("page", [ROOT / "README.md", ROOT / "CONTRIBUTING.md"], ids=lambda p: p.stem)
def test_links_lead_to_files(page):
    """Those of the pages are checked by the build."""
    for target in re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8")):
        assert target.startswith("https://") or (page.parent / target).is_file(), target


def test_first_run_prints_what_its_page_shows(run, capsys):
    """The same lines; numbers as far as they are the same on every machine."""
    from oblique_impact.command_line.run import summary_lines

    print("\n".join(summary_lines(run("paper"), Path("out/paper"), False)))
    printed = capsys.readouterr().out.splitlines()
    shown = blocks(DOCS / "first-run.md", "text")[0].splitlines()
    assert printed[:5] == shown[:5]
    assert printed[5].partition(", scheme")[0] == shown[5].partition(", scheme")[0]
    assert printed[7] == shown[7]


def test_wrong_commands_would_be_noticed():
    with pytest.raises(Exception, match="No such option"):
        parse(["oblique-impact", "run", "paper", "--nosuch", "1"])
    with pytest.raises(Exception, match=r"contact\.mu_static"):
        check_values(parse(["oblique-impact", "run", "paper", "--set", "contact.mu_static=-1"]), {})

"""CONTRIBUTING.md leads through the code: every file, function and class that it names is there."""

from __future__ import annotations

import ast
import re
import tomllib
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest

from oblique_impact import Scenario
from oblique_impact.scenario.user_defined import KINDS

ROOT = Path(__file__).parents[2]
PAGE = "CONTRIBUTING.md"
PACKAGES = ("oblique_impact", "modal", "fem_beam", "validation", "renders")
#: words that are names of other programs' things: a directive of Sphinx, a function of Python
FOREIGN = {"equation", "print"}


def named(text: str) -> set[str]:
    """What stands in backticks and is a file, a folder or a name; commands and code are left out."""
    return {word for word in re.findall(r"`([^`\n]+)`", text) if re.fullmatch(r"@?[\w.*][\w./*-]*", word)}


def is_path(word: str) -> bool:
    return "/" in word or re.search(r"\.(py|md|toml|rst)$", word) is not None


def exists(path: str) -> bool:
    """Whether a file, a folder (with "/" at its end) or a pattern is in the project, or in its core."""
    places = (ROOT, ROOT / "oblique_impact")
    return any(
        found.is_dir() or not path.endswith("/") for place in places for found in place.glob(path.rstrip("/"))
    )


@cache
def defined() -> set[str]:
    """Names that the packages define: functions, classes, their members as Class.member, and constants."""
    found: set[str] = set()
    for package in PACKAGES:
        for file in (ROOT / package).rglob("*.py"):
            tree = ast.parse(file.read_text(encoding="utf-8"))
            found |= members(tree)
            for node in tree.body:
                if isinstance(node, ast.ClassDef):
                    inside = members(node)
                    found |= inside | {f"{node.name}.{name}" for name in inside}
    return found


def members(scope: ast.Module | ast.ClassDef) -> set[str]:
    found = set()
    for node in scope.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            found |= {part.id for target in targets for part in ast.walk(target) if isinstance(part, ast.Name)}
    return found


def importable(name: str) -> bool:
    """Whether a dotted name leads from one of the packages to a module or to something in it."""
    package, *rest = name.split(".")
    if package not in PACKAGES:
        return False
    thing = import_module(package)
    for part in rest:
        if not hasattr(thing, part):
            return False
        thing = getattr(thing, part)
    return True


@cache
def other_names() -> set[str]:
    """Keys of a scenario, and groups of entry points."""
    data = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    keys = {
        f"{section}.{key}"
        for section, field in Scenario.model_fields.items()
        for key in getattr(field.annotation, "model_fields", {})
    }
    return keys | set(data["project"]["entry-points"]) | {f"oblique_impact.{kind}" for kind in KINDS}


def missing(text: str) -> list[str]:
    """Names in a text that lead nowhere."""
    found = []
    for word in sorted(named(text)):
        name = word.removeprefix("@")
        there = exists(name) if is_path(name) else name in FOREIGN | defined() | other_names() or importable(name)
        if not there:
            found.append(word)
    return found


def test_what_the_page_names_is_there():
    text = (ROOT / PAGE).read_text(encoding="utf-8")
    assert len(named(text)) > 100
    assert missing(text) == []


@pytest.mark.parametrize(
    "word",
    [
        "Beam.modle",
        "marching/loops.py",
        "contact/nowhere/",
        "simulat",
        "@jitible",
        "modal.operators",
        "solver.stik",
    ],
)
def test_a_name_that_leads_nowhere_is_found(word):
    text = (ROOT / PAGE).read_text(encoding="utf-8")
    assert missing(f"{text}\n`{word}`") == [word]


def test_every_room_stands_in_the_table():
    text = (ROOT / PAGE).read_text(encoding="utf-8").partition("## The rooms")[2].partition("\n## ")[0]
    core = ROOT / "oblique_impact"
    rooms = {f"{path.parent.name}/" for path in core.glob("*/__init__.py")}
    rooms |= {path.name for path in core.glob("*.py") if not path.name.startswith("_")}
    assert rooms == {word for word in named(text) if (core / word).exists()}


def test_links_lead_to_files():
    text = (ROOT / PAGE).read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#]+)\)", text):
        assert (ROOT / target).is_file(), target

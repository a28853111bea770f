"""What made a result: version, commit, digest of the numeric source, and user-defined parts with theirs.

Two results with the same digests were computed by the same formulas, whatever the version says.
"""

from __future__ import annotations

import hashlib
import inspect
import subprocess
import sys
from collections.abc import Iterable
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from types import CodeType
from typing import TYPE_CHECKING, Any, TypedDict

from oblique_impact.scenario.user_defined import Choice, load

if TYPE_CHECKING:
    from oblique_impact.scenario.scenario import Scenario

#: packages whose source decides about the numbers of a run
NUMERIC_PACKAGES = ("oblique_impact", "modal", "fem_beam")
_DIGITS = 16


class Provenance(TypedDict, total=False):
    """What made a result; a part without a commit or without user-defined parts lacks that entry."""

    version: str
    commit: str
    numeric_source: str
    user_defined: dict[str, str]


def provenance(scenario: Scenario | None = None) -> Provenance:
    """Return what makes the results of this process; the user-defined parts are those that `scenario` names."""
    return with_parts([] if scenario is None else named_in(scenario))


def with_parts(named: Iterable[tuple[str, str]]) -> Provenance:
    """Return the same; the user-defined parts are those among `named` pairs of key and name."""
    made: Provenance = {"version": package_version(), "numeric_source": source_digest(NUMERIC_PACKAGES)}
    known = commit()
    if known:
        made["commit"] = known
    parts = part_digests(named)
    if parts:
        made["user_defined"] = parts
    return made


def described(made: Provenance) -> str:
    """Return a provenance in one line, for the head of a report and the metadata of a picture."""
    words = [f"oblique-impact {made.get('version', 'of an unknown version')}"]
    words += [f"commit {made['commit']}"] if "commit" in made else []
    words += [f"numeric source {made['numeric_source']}"] if "numeric_source" in made else []
    words += [f"{name} ({digest})" for name, digest in made.get("user_defined", {}).items()]
    return ", ".join(words)


def package_version() -> str:
    """Return the version that is installed, "unknown" if it runs from a folder that is not."""
    try:
        return version("oblique-impact")
    except PackageNotFoundError:
        return "unknown"


@cache
def source_digest(packages: tuple[str, ...]) -> str:
    """Return the digest of all Python files of the packages, by their names and contents."""
    digest = hashlib.sha256()
    for package in packages:
        spec = find_spec(package)
        for folder in sorted(spec.submodule_search_locations or () if spec else ()):
            add_files(digest, Path(folder), Path(folder).rglob("*.py"))
    return digest.hexdigest()[:_DIGITS]


def add_files(digest: Any, folder: Path, files: Iterable[Path]) -> None:
    """Add names, relative to `folder`, and contents of files to a digest, sorted by name."""
    for file in sorted(files):
        digest.update(file.relative_to(folder).as_posix().encode())
        digest.update(file.read_bytes())


@cache
def commit() -> str:
    """Return the commit of the checkout that runs, with "-dirty" if files differ from it; "" if there is none."""
    top = Path(__file__).parents[2]
    if not (top / ".git").exists():
        return ""
    words = ["git", "-C", str(top), "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
    try:
        found = subprocess.run(words, capture_output=True, text=True, timeout=5.0, check=True)
    except (OSError, subprocess.SubprocessError):
        return ""
    return found.stdout.strip()


@cache
def part_keys() -> dict[str, Choice]:
    """Return the keys "section.key" of a scenario that may name a user-defined part, with what they may name."""
    from oblique_impact.scenario.scenario import Scenario

    sections = {
        name: getattr(field.annotation, "model_fields", {}) for name, field in Scenario.model_fields.items()
    }
    return {
        f"{section}.{key}": choice
        for section, fields in sections.items()
        for key, field in fields.items()
        for choice in field.metadata
        if isinstance(choice, Choice)
    }


def named_in(scenario: Scenario) -> list[tuple[str, str]]:
    """Return the keys that name parts of a scenario, built-in or user-defined, with the names."""
    return [(key, getattr(getattr(scenario, key.partition(".")[0]), key.partition(".")[2])) for key in part_keys()]


def part_digests(named: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Return the digests of the user-defined parts among `named` pairs of key and name, by "key: name"."""
    found = {}
    for key, name in named:
        choice = part_keys()[key]
        part = None if name in choice.built_in else load(choice.kind, name)
        if part is not None and _module(part).partition(".")[0] not in NUMERIC_PACKAGES:
            found[f"{key}: {name}"] = part_digest(part)
    return found


def _module(part: Any) -> str:
    """Return the name of the module that a part is, or stands in."""
    return str(part.__name__ if inspect.ismodule(part) else part.__module__)


def part_digest(part: Any) -> str:
    """Return the digest of a class or module: of its file, or of its source if it has no file."""
    return hashlib.sha256(_source(part).encode()).hexdigest()[:_DIGITS]


def _source(part: Any) -> str:
    module = sys.modules.get(_module(part))
    try:
        return inspect.getsource(part if module is None or module.__name__ == "__main__" else module)
    except (OSError, TypeError):  # typed at a prompt
        functions = [value for value in vars(part).values() if inspect.isfunction(value)]
        return repr([_compiled(function.__code__) for function in functions])


def _compiled(code: CodeType) -> tuple[Any, ...]:
    """Return what a function does, without the places in memory that its representation holds."""
    constants = [_compiled(value) if isinstance(value, CodeType) else repr(value) for value in code.co_consts]
    return code.co_name, code.co_code, code.co_names, constants

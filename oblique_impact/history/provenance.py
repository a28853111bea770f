"""What made a result: version, commit, digest of the numeric source, and user-defined parts with theirs.

Two results with the same digests were computed by the same formulas, whatever the version says.
"""

from __future__ import annotations

import hashlib
import inspect
import subprocess
import sys
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

from oblique_impact.scenario.user_defined import Choice, load

if TYPE_CHECKING:
    from oblique_impact.scenario.scenario import Scenario

#: packages whose source decides about the numbers of a run
NUMERIC_PACKAGES = ("oblique_impact", "oblique_impact.modal", "oblique_impact.fem_beam")
#: sub-packages that lie in a wheel inside of `oblique_impact`, in a checkout beside it: digested by themselves
_APART = ("modal", "fem_beam", "renders", "validation")
_DIGITS = 16


class Provenance(TypedDict, total=False):
    """What made a result; a part without a commit or without user-defined parts lacks that entry."""

    version: str
    commit: str
    numeric_source: str
    user_defined: dict[str, str]


def provenance(named: Iterable[tuple[str, str]] = ()) -> Provenance:
    """Return what makes the results of this process; user-defined parts are those among pairs of key and name."""
    made: Provenance = {"version": package_version(), "numeric_source": source_digest(NUMERIC_PACKAGES)}
    known, parts = commit(), part_digests(named)
    if known:
        made["commit"] = known
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
    return versions("oblique-impact").get("oblique-impact", "unknown")


def versions(*packages: str) -> dict[str, str]:
    """Return the versions of those packages that are installed."""
    found = {name: _version(name) for name in packages}
    return {name: known for name, known in found.items() if known}


@cache
def _version(package: str) -> str:
    """Return the version of a package, "" if it is not installed; its metadata take a millisecond to read."""
    with suppress(PackageNotFoundError):
        return version(package)
    return ""


@cache
def source_digest(packages: tuple[str, ...]) -> str:
    """Return the digest of all Python files of the packages, by their names and contents."""
    digest = hashlib.sha256()
    for package in packages:
        spec = find_spec(package)
        for folder in sorted(spec.submodule_search_locations or () if spec else ()):
            for file in sorted(Path(folder).rglob("*.py")):
                if file.relative_to(folder).parts[0] in _APART:
                    continue
                digest.update(file.relative_to(folder).as_posix().encode())
                digest.update(file.read_bytes())
    return digest.hexdigest()[:_DIGITS]


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

    return {
        f"{section}.{key}": choice
        for section, fields in Scenario.model_fields.items()
        for key, field in getattr(fields.annotation, "model_fields", {}).items()
        for choice in field.metadata
        if isinstance(choice, Choice)
    }


def named_in(scenario: Scenario) -> list[tuple[str, str]]:
    """Return the keys that name parts of a scenario, built-in or user-defined, with the names."""
    return [(key, attrgetter(key)(scenario)) for key in part_keys()]


def part_digests(named: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Return the digests of the user-defined parts among `named` pairs of key and name, by "key: name"."""
    found = {}
    for key, name in named:
        choice = part_keys()[key]
        part = None if name in choice.built_in else load(choice.kind, name)
        if part is not None and _module(part).partition(".")[0] != "oblique_impact":
            found[f"{key}: {name}"] = part_digest(part)
    return found


def _module(part: Any) -> str:
    """Return the name of the module that a part is, or stands in."""
    return str(part.__name__ if inspect.ismodule(part) else part.__module__)


def part_digest(part: Any) -> str:
    """Return the digest of a class or module: of its file, or of its source or functions if it has no file.

    Of a package it is that of all its files.
    """
    if hasattr(part, "__path__"):
        return source_digest((part.__name__,))
    module = sys.modules.get(_module(part))
    try:
        source = inspect.getsource(part if module is None or module.__name__ == "__main__" else module)
    except (OSError, TypeError):  # typed at a prompt
        codes = [value.__code__ for value in vars(part).values() if inspect.isfunction(value)]
        # nested functions are left out: their representation holds places in memory
        constants = ([k for k in code.co_consts if not inspect.iscode(k)] for code in codes)
        source = repr([(c.co_name, c.co_code, c.co_names, k) for c, k in zip(codes, constants, strict=True)])
    return hashlib.sha256(source.encode()).hexdigest()[:_DIGITS]

"""Provenance of a result: version, commit, and a digest of the numeric source.

Two results with the same digest were computed by the same formulas, whatever the version says.
"""

from __future__ import annotations

import hashlib
import subprocess
from collections.abc import Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

#: packages whose source determines the numbers of a run
NUMERIC_PACKAGES = ("oblique_impact", "oblique_impact.modal", "oblique_impact.fem_beam")
#: sub-packages that are inside of `oblique_impact` in a wheel, but beside it in a checkout: digested separately
_SEPARATE = ("modal", "fem_beam", "renders", "validation")
_DIGITS = 16


def provenance() -> dict[str, str]:
    """Return the provenance of this process: `version`, `numeric_source`, in a checkout its `commit`."""
    made = {"version": package_version(), "numeric_source": source_digest(NUMERIC_PACKAGES)}
    return {**made, "commit": commit()} if commit() else made


def provenance_line(made: Mapping[str, str]) -> str:
    """Return a provenance in one line, for the head of a report and the metadata of a picture."""
    parts = [f"oblique-impact {made.get('version', 'of an unknown version')}"]
    parts += [f"commit {made['commit']}"] if "commit" in made else []
    parts += [f"numeric source {made['numeric_source']}"] if "numeric_source" in made else []
    return ", ".join(parts)


def package_version() -> str:
    """Return the installed version, "unknown" if the program runs from a folder that is not installed."""
    return versions("oblique-impact").get("oblique-impact", "unknown")


@cache
def versions(*packages: str) -> dict[str, str]:
    """Return the versions of those packages that are installed."""
    found = {}
    for name in packages:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


@cache
def source_digest(packages: tuple[str, ...]) -> str:
    """Return the digest of all Python files of the packages, by their names and contents."""
    digest = hashlib.sha256()
    for package in packages:
        spec = find_spec(package)
        for folder in sorted(spec.submodule_search_locations or () if spec else ()):
            for file in sorted(Path(folder).rglob("*.py")):
                if file.relative_to(folder).parts[0] in _SEPARATE:
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
    command = ["git", "-C", str(top), "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
    try:
        found = subprocess.run(command, capture_output=True, text=True, timeout=5.0, check=True)
    except (OSError, subprocess.SubprocessError):
        return ""
    return found.stdout.strip()

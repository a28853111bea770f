"""What installed packages add by the entry points of their metadata: discretizations, laws, commands, drawings."""

from __future__ import annotations

from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from oblique_impact.errors import InputError


@cache
def installed(kind: str) -> dict[str, EntryPoint]:
    """Return the entry points of the group ``oblique_impact.KIND`` by their names; nothing is imported."""
    return {point.name: point for point in _all().select(group=f"oblique_impact.{kind}")}


@cache
def _all() -> Any:
    """Return those of all packages: to look at one group takes as long."""
    return entry_points()


def load(point: EntryPoint) -> Any:
    """Import what an entry point names; raises InputError, in one line, if its package is broken."""
    try:
        return point.load()
    except Exception as error:  # whatever a broken package raises
        raise InputError(f"{point.name} ({point.value}): cannot be loaded: {reason(error)}") from None


def reason(error: BaseException) -> str:
    """Return what an exception says in one line of at most 200 characters."""
    return " ".join(str(error).split())[:200] or type(error).__name__

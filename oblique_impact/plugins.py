"""Discretizations found by name: packages register themselves, none is imported here.

A discretization is a module with ``build_operators(scenario) -> BeamOperators`` and
``spectrum(scenario) -> SpinningBeam``, registered under the entry point group
``oblique_impact.discretizations``.
"""

from __future__ import annotations

from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

ENTRY_POINT_GROUP = "oblique_impact.discretizations"


@cache
def _installed() -> dict[str, EntryPoint]:
    return {point.name: point for point in entry_points(group=ENTRY_POINT_GROUP)}


def discretization_names() -> list[str]:
    """Return the names of the installed discretizations."""
    return sorted(_installed())


def discretization(name: str) -> Any:
    """Load the module of an installed discretization; raises KeyError for an unknown name."""
    return _installed()[name].load()

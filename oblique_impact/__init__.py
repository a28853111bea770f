"""Simulation of a flexible beam that strikes a slope: floating frame, hybrid contact, marching schemes.

`Scenario`             what to simulate (`Scenario.builtin`, `Scenario.load`)
`simulate`             run it: returns a `History`
`natural_frequencies`  of the spinning beam: returns `Frequencies`
`frequencies_at_rest`  of a scenario about its equilibrium, contacts closed: returns `VibrationModes`
`builtin_cases`        the built-in scenarios, and what happens in each
`start_scenario`       write a scenario file with every key explained, to start from
`History`              labelled samples, event log, summary; `save` and `load`
`scenario_schema`      the JSON Schema of scenario files, for editors
`simulate_system`      run a small user-defined system through the same contact states
`EventScheme`, ...     the built-in schemes, for these

Checks, comparisons and studies are in `oblique_impact.validation`, pictures and exports in
`oblique_impact.renders`.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from oblique_impact.api import *  # noqa: F403


def __getattr__(name: str) -> Any:
    """Return a sub-package, or a public name of `oblique_impact.api` (PEP 562).

    Numba, SciPy and xarray take a second to import, which the command line's help does not need.
    """
    if name.startswith("__") and name != "__all__":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if find_spec(f"{__name__}.{name}"):
        return import_module(f"{__name__}.{name}")
    return getattr(import_module("oblique_impact.api"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *import_module("oblique_impact.api").__all__})

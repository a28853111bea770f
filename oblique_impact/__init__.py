"""A flexible beam strikes a rigid slope: floating frame, hybrid contact, marching schemes.

`Scenario`             what to simulate (`Scenario.builtin`, `Scenario.load`)
`simulate`             run it: returns a `History`
`natural_frequencies`  of the spinning beam: returns `Frequencies`
`History`              labelled samples, event log, summary; `save` and `load`
`concatenate`          histories of consecutive spans joined to one
`simulate_system`      run a small user-defined system through the same contact states

Checks, comparisons and studies are in `validation`, pictures and exports in `renders`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from oblique_impact.beam.frequencies import Frequencies, natural_frequencies
    from oblique_impact.errors import InputError, Interrupted, Outcome
    from oblique_impact.history.concatenation import concatenate
    from oblique_impact.history.history import History
    from oblique_impact.kernels.system import MechanicalSystem
    from oblique_impact.progress import Progress
    from oblique_impact.scenario.scenario import Scenario
    from oblique_impact.simulation import simulate, simulate_system

#: public names and their modules, imported on first use so that the command line starts quickly
_HOME = {
    "Frequencies": "beam.frequencies",
    "History": "history.history",
    "InputError": "errors",
    "Interrupted": "errors",
    "MechanicalSystem": "kernels.system",
    "Outcome": "errors",
    "Progress": "progress",
    "Scenario": "scenario.scenario",
    "concatenate": "history.concatenation",
    "natural_frequencies": "beam.frequencies",
    "simulate": "simulation",
    "simulate_system": "simulation",
}
__all__ = [
    "Frequencies",
    "History",
    "InputError",
    "Interrupted",
    "MechanicalSystem",
    "Outcome",
    "Progress",
    "Scenario",
    "concatenate",
    "natural_frequencies",
    "simulate",
    "simulate_system",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})

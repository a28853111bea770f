"""A flexible beam strikes a rigid slope: floating frame, hybrid contact, marching schemes.

`Scenario`             what to simulate (`Scenario.builtin`, `Scenario.load`)
`simulate`             run it: returns a `History`
`natural_frequencies`  of the spinning beam: returns `Frequencies`
`History`              labelled samples, event log, summary; `save` and `load`
`Draft`                a history that is written while its run goes on
`concatenate`          histories of consecutive spans joined to one
`simulate_system`      run a small system of one's own through the same contact states

Checks, comparisons and studies are in `validation`, pictures and exports in `renders`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from oblique_impact.lazy import lazy_names

__all__ = [
    "Draft",
    "Frequencies",
    "History",
    "InputError",
    "MechanicalSystem",
    "Outcome",
    "Progress",
    "Scenario",
    "concatenate",
    "natural_frequencies",
    "simulate",
    "simulate_system",
]

if TYPE_CHECKING:
    from oblique_impact.draft import Draft
    from oblique_impact.errors import InputError, Outcome
    from oblique_impact.history import History
    from oblique_impact.joining import concatenate
    from oblique_impact.progress import Progress
    from oblique_impact.scenario import Scenario
    from oblique_impact.simulate import simulate, simulate_system
    from oblique_impact.spectrum import Frequencies, natural_frequencies
    from oblique_impact.system import MechanicalSystem

lazy_names(
    __name__,
    {
        "Draft": "draft",
        "Frequencies": "spectrum",
        "History": "history",
        "InputError": "errors",
        "MechanicalSystem": "system",
        "Outcome": "errors",
        "Progress": "progress",
        "Scenario": "scenario",
        "concatenate": "joining",
        "natural_frequencies": "spectrum",
        "simulate": "simulate",
        "simulate_system": "simulate",
    },
)

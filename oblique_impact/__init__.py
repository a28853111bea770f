"""A flexible beam strikes a rigid slope: floating frame, hybrid contact, marching schemes.

`Scenario`             what to simulate (`Scenario.builtin`, `Scenario.load`)
`simulate`             run it: returns a `History`
`natural_frequencies`  of the spinning beam: returns `Frequencies`
`builtin_cases`        the built-in scenarios, and what happens in each
`start_scenario`       write a scenario file with every key explained, to start from
`History`              labelled samples, event log, summary; `save` and `load`
`concatenate`          histories of consecutive spans joined to one
`scenario_schema`      what a scenario file may hold, for editors
`simulate_system`      run a small user-defined system through the same contact states

Checks, comparisons and studies are in `validation`, pictures and exports in `renders`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from oblique_impact.public import on_first_use

if TYPE_CHECKING:
    from oblique_impact.beam.frequencies import Frequencies, natural_frequencies
    from oblique_impact.errors import InputError, Interrupted, Outcome
    from oblique_impact.history.concatenation import concatenate
    from oblique_impact.history.history import History
    from oblique_impact.kernels.system import MechanicalSystem
    from oblique_impact.progress import Progress
    from oblique_impact.scenario.scenario import Scenario
    from oblique_impact.scenario.schema import scenario_schema
    from oblique_impact.scenario.starting import BuiltinCase, builtin_cases, start_scenario
    from oblique_impact.simulation import simulate, simulate_system

__all__ = [
    "BuiltinCase",
    "Frequencies",
    "History",
    "InputError",
    "Interrupted",
    "MechanicalSystem",
    "Outcome",
    "Progress",
    "Scenario",
    "builtin_cases",
    "concatenate",
    "natural_frequencies",
    "scenario_schema",
    "simulate",
    "simulate_system",
    "start_scenario",
]

__getattr__, __dir__ = on_first_use(
    __name__,
    {
        "beam.frequencies": "Frequencies natural_frequencies",
        "errors": "InputError Interrupted Outcome",
        "history.concatenation": "concatenate",
        "history.history": "History",
        "kernels.system": "MechanicalSystem",
        "progress": "Progress",
        "scenario.scenario": "Scenario",
        "scenario.schema": "scenario_schema",
        "scenario.starting": "BuiltinCase builtin_cases start_scenario",
        "simulation": "simulate simulate_system",
    },
)

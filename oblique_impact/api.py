"""Public names of the package, for ``from oblique_impact import ...``."""

from __future__ import annotations

from oblique_impact.beam.frequencies import Frequencies, natural_frequencies
from oblique_impact.errors import FileWarning, InputError, Interrupted, Outcome, SimulationWarning
from oblique_impact.history.history import History
from oblique_impact.kernels.system import MechanicalSystem
from oblique_impact.marching.event import EventScheme
from oblique_impact.marching.fixed_step import FixedStepScheme
from oblique_impact.marching.generalized_alpha import GeneralizedAlphaScheme
from oblique_impact.marching.scheme import Scheme
from oblique_impact.marching.time_stepping import TimeSteppingScheme
from oblique_impact.progress import Progress
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.schema import scenario_schema
from oblique_impact.scenario.starting import BuiltinCase, builtin_cases, start_scenario
from oblique_impact.simulation import simulate, simulate_system
from oblique_impact.vibration import VibrationModes, frequencies_at_rest

__all__ = [
    "BuiltinCase",
    "EventScheme",
    "FileWarning",
    "FixedStepScheme",
    "Frequencies",
    "GeneralizedAlphaScheme",
    "History",
    "InputError",
    "Interrupted",
    "MechanicalSystem",
    "Outcome",
    "Progress",
    "Scenario",
    "Scheme",
    "SimulationWarning",
    "TimeSteppingScheme",
    "VibrationModes",
    "builtin_cases",
    "frequencies_at_rest",
    "natural_frequencies",
    "scenario_schema",
    "simulate",
    "simulate_system",
    "start_scenario",
]

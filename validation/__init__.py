"""Checks against independent references, comparisons of runs, and studies of many runs.

`validate`   every check against something outside the program: a list of `Result`
`compare`    two histories, events aligned: a `Comparison`
`refine`     elements, modes, steps, stiffness or tolerances, and what converges: a `StudyResult`
`predictability`  which macro-collisions depend on the initial angle beyond measurement: a `Predictability`
`small_deflection`  the floating frame against the exact beam: a `SmallDeflection`
`reproduce`  the paper's figures and claims: a `Reproduction`
`sweep`      a scenario over axes of its keys (`SweepFile`): a `SweepResult`
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from oblique_impact.validation.comparison import Comparison, compare
    from oblique_impact.validation.paper.claims import Reproduction
    from oblique_impact.validation.paper.command import reproduce
    from oblique_impact.validation.studies.design import (
        AxisSection,
        HypercubeSection,
        SweepFile,
        TableSection,
    )
    from oblique_impact.validation.studies.ladders import StudyResult
    from oblique_impact.validation.studies.predictability import Predictability, predictability
    from oblique_impact.validation.studies.refinement import refine
    from oblique_impact.validation.studies.small_deflection import SmallDeflection, small_deflection
    from oblique_impact.validation.studies.sweep import SweepResult, sweep
    from oblique_impact.validation.suite import Result, validate

__all__ = [
    "AxisSection",
    "Comparison",
    "HypercubeSection",
    "Predictability",
    "Reproduction",
    "Result",
    "SmallDeflection",
    "StudyResult",
    "SweepFile",
    "SweepResult",
    "TableSection",
    "compare",
    "predictability",
    "refine",
    "reproduce",
    "small_deflection",
    "sweep",
    "validate",
]

#: modules with these names, imported on first use: `run` on the command line should not wait for pandas and joblib
_MODULES = (
    "comparison",
    "suite",
    "studies.design",
    "studies.predictability",
    "studies.refinement",
    "studies.small_deflection",
    "studies.sweep",
    "paper.command",
)


def __getattr__(name: str) -> Any:
    if name in __all__:
        for module in _MODULES:
            found = vars(import_module(f"{__name__}.{module}")).get(name)
            if found is not None:
                return found
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

"""Checks against independent references, comparisons of runs, and studies of many runs.

`validate`   every check against something outside the program: a list of `Result`
`compare`    two histories, events aligned: a `Comparison`
`refine`     elements, modes, steps, stiffness or tolerances, and what converges: a `StudyResult`
`predictability`  which macro-collisions depend on the initial angle beyond measurement: a `Predictability`
`small_deflection`  the floating frame against the exact beam: a `SmallDeflection`
`fit`        keys of a scenario from measured data: a `FitResult`
`reproduce`  the paper's figures and claims: a `Reproduction`
`sweep`      a scenario over axes of its keys (`SweepFile`): a `SweepResult`
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from oblique_impact.validation.comparison import Comparison as Comparison
    from oblique_impact.validation.comparison import compare as compare
    from oblique_impact.validation.paper.command import Reproduction as Reproduction
    from oblique_impact.validation.paper.command import reproduce as reproduce
    from oblique_impact.validation.studies.design import AxisSection as AxisSection
    from oblique_impact.validation.studies.design import HypercubeSection as HypercubeSection
    from oblique_impact.validation.studies.design import SweepFile as SweepFile
    from oblique_impact.validation.studies.design import TableSection as TableSection
    from oblique_impact.validation.studies.fitting import FitResult as FitResult
    from oblique_impact.validation.studies.fitting import fit as fit
    from oblique_impact.validation.studies.ladders import StudyResult as StudyResult
    from oblique_impact.validation.studies.predictability import Predictability as Predictability
    from oblique_impact.validation.studies.predictability import predictability as predictability
    from oblique_impact.validation.studies.refinement import refine as refine
    from oblique_impact.validation.studies.small_deflection import SmallDeflection as SmallDeflection
    from oblique_impact.validation.studies.small_deflection import small_deflection as small_deflection
    from oblique_impact.validation.studies.sweep import SweepResult as SweepResult
    from oblique_impact.validation.studies.sweep import sweep as sweep
    from oblique_impact.validation.suite import Result as Result
    from oblique_impact.validation.suite import validate as validate

# pandas, joblib and matplotlib take a second to load: a command that needs none of them does not wait
_MODULES = {
    "comparison": ("Comparison", "compare"),
    "paper.command": ("Reproduction", "reproduce"),
    "studies.design": ("AxisSection", "HypercubeSection", "SweepFile", "TableSection"),
    "studies.fitting": ("FitResult", "fit"),
    "studies.ladders": ("StudyResult",),
    "studies.predictability": ("Predictability", "predictability"),
    "studies.refinement": ("refine",),
    "studies.small_deflection": ("SmallDeflection", "small_deflection"),
    "studies.sweep": ("SweepResult", "sweep"),
    "suite": ("Result", "validate"),
}
_HOMES = {name: module for module, names in _MODULES.items() for name in names}
__all__ = [*_HOMES]


def __getattr__(name: str) -> Any:
    """Import what is asked for when it is first used (PEP 562)."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)

"""Holding results against each other and against references, and studies of many runs.

`validate`   every check against something outside the program: a list of `Result`
`compare`    two histories, events aligned: a `Comparison`
`refine`     elements, modes, steps or tolerances, and what converges: a `StudyResult`
`predictability`  shadow runs, and which macro-collisions mean anything: a `Predictability`
`small_deflection`  the floating frame against the exact beam: a `SmallDeflection`
`reproduce`  the paper's figures and claims: a `Reproduction`
`sweep`      a scenario over axes of its keys (`SweepFile`): a `SweepResult`

What a call needs is imported when its name is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from oblique_impact.public import on_first_use

__all__ = [
    "AxisSection",
    "Comparison",
    "HypercubeSection",
    "Predictability",
    "Reproduction",
    "Result",
    "SampledSection",
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

if TYPE_CHECKING:
    from oblique_impact.validation.comparison import Comparison, compare
    from oblique_impact.validation.refinement.command import refine
    from oblique_impact.validation.refinement.growth import Predictability
    from oblique_impact.validation.refinement.predictability import predictability
    from oblique_impact.validation.refinement.study import StudyResult
    from oblique_impact.validation.paper.command import reproduce
    from oblique_impact.validation.paper.reproduction import Reproduction
    from oblique_impact.validation.small_deflection.command import small_deflection
    from oblique_impact.validation.small_deflection.errors import SmallDeflection
    from oblique_impact.validation.suite import Result, validate
    from oblique_impact.validation.sweeps.command import SweepResult, sweep
    from oblique_impact.validation.sweeps.design import AxisSection, HypercubeSection, SampledSection, TableSection
    from oblique_impact.validation.sweeps.plan import SweepFile

__getattr__, __dir__ = on_first_use(
    __name__,
    {
        "absolute.deflection_errors": "SmallDeflection",
        "absolute.small_deflection": "small_deflection",
        "comparison": "Comparison compare",
        "refinement.command": "refine",
        "refinement.growth": "Predictability",
        "refinement.predictability": "predictability",
        "refinement.study": "StudyResult",
        "paper.command": "reproduce",
        "paper.reproduction": "Reproduction",
        "suite": "Result validate",
        "sweeps.command": "SweepResult sweep",
        "sweeps.design": "AxisSection HypercubeSection SampledSection TableSection",
        "sweeps.plan": "SweepFile",
    },
)

"""Holding results against each other and against references, and studies of many runs.

`validate`   every check against something outside the program: a list of `Result`
`compare`    two histories, events aligned: a `Comparison`
`refine`     elements, modes, steps or tolerances, and what converges: a `StudyResult`
`reproduce`  the paper's figures and claims: a `Reproduction`
`sweep`      a scenario over axes of its keys (`SweepFile`): a `SweepResult`

What a call needs is imported when its name is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from oblique_impact.lazy import lazy_names

__all__ = [
    "AxisSection",
    "Comparison",
    "HypercubeSection",
    "Reproduction",
    "Result",
    "SampledSection",
    "StudyResult",
    "SweepFile",
    "SweepResult",
    "TableSection",
    "compare",
    "refine",
    "reproduce",
    "sweep",
    "validate",
]

if TYPE_CHECKING:
    from validation.contrast import Comparison
    from validation.differences import compare
    from validation.refinement.command import refine
    from validation.refinement.study import StudyResult
    from validation.reproduction.command import Reproduction, reproduce
    from validation.suite import Result, validate
    from validation.sweep.command import SweepResult, sweep
    from validation.sweep.plan import AxisSection, HypercubeSection, SampledSection, SweepFile, TableSection

lazy_names(
    __name__,
    {
        "AxisSection": "sweep.plan",
        "Comparison": "contrast",
        "HypercubeSection": "sweep.plan",
        "Reproduction": "reproduction.command",
        "Result": "suite",
        "SampledSection": "sweep.plan",
        "StudyResult": "refinement.study",
        "SweepFile": "sweep.plan",
        "SweepResult": "sweep.command",
        "TableSection": "sweep.plan",
        "compare": "differences",
        "refine": "refinement.command",
        "reproduce": "reproduction.command",
        "sweep": "sweep.command",
        "validate": "suite",
    },
)

"""Holding results against each other and against references, and studies of many runs.

`validate`   every check against something outside the program: a list of `Result`
`compare`    two histories, events aligned: a `Comparison`
`refine`     elements, modes, steps or tolerances, and what converges: a `StudyResult`
`reproduce`  the paper's figures and claims: a `Reproduction`
`sweep`      a scenario over axes of its keys (`SweepFile`): a `SweepResult`

What a call needs is imported when its name is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

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
    from validation.comparison import Comparison, compare
    from validation.refinement.command import refine
    from validation.refinement.study import StudyResult
    from validation.reproduction.command import Reproduction, reproduce
    from validation.suite import Result, validate
    from validation.sweeps.command import SweepResult, sweep
    from validation.sweeps.design import AxisSection, HypercubeSection, SampledSection, TableSection
    from validation.sweeps.plan import SweepFile

#: public names and their modules, imported on first use
_HOME = {
    "AxisSection": "sweeps.design",
    "Comparison": "comparison",
    "HypercubeSection": "sweeps.design",
    "Reproduction": "reproduction.command",
    "Result": "suite",
    "SampledSection": "sweeps.design",
    "StudyResult": "refinement.study",
    "SweepFile": "sweeps.plan",
    "SweepResult": "sweeps.command",
    "TableSection": "sweeps.design",
    "compare": "comparison",
    "refine": "refinement.command",
    "reproduce": "reproduction.command",
    "sweep": "sweeps.command",
    "validate": "suite",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})

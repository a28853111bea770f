"""Everything the report is made of: runs, verdicts, pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from validation.reproduction.claims import Judged
from validation.reproduction.measures import Trio
from validation.reproduction.pictures import Plot
from validation.reproduction.runs import Run
from validation.reproduction.unsaid import Robustness, Studied


@dataclass(frozen=True)
class Material:
    """Everything the report is made of."""

    trios: dict[str, Trio]  # the paper's case, by scheme
    runs: dict[str, Run]  # all named runs
    judged: Sequence[Judged]
    studied: Sequence[Studied]
    grid: Sequence[Robustness]
    threshold: tuple[float, Sequence[tuple[float, str]]]  # ratio, (coefficient, what happened)


@dataclass(frozen=True)
class Drawings:
    """All pictures as SVG text: the paper's figures by number, the diagrams by name."""

    figures: Sequence[tuple[Plot, str]]
    choices: str
    curves: dict[str, str]
    robustness: str
    sticking: dict[str, str]

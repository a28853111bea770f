"""What a claim of the paper is, how it is judged, and how the verdicts of two schemes become one.

A claim is judged by a rule on numbers of our runs; the rule is printed in the report.  It is judged twice,
on the fixed-step runs (the algorithm as printed) and on the event-located ones (the same equations, solved):
reproduced by both is reproduced, by neither at all is not reproduced, anything between is partly reproduced.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from oblique_impact.validation.report.document import number
from oblique_impact.validation.reproduction.measures import Trio
from oblique_impact.validation.reproduction.runs import MissingError

REPRODUCED, PARTLY, NOT = "reproduced", "partly", "not reproduced"
VERDICTS = (REPRODUCED, PARTLY, NOT)


class Finding(NamedTuple):
    """What one set of runs says about a claim: verdict, the numbers behind it, and these as text."""

    verdict: str
    numbers: dict[str, float]
    text: str


Rule = Callable[[Trio], Finding]


@dataclass(frozen=True)
class Claim:
    """One claim of the paper: where, what it says, the rule in words and as a function.

    `case` names the runs it is judged on: those of the paper's case, or of a scenario that sticks.
    """

    id: str
    place: str
    statement: str
    rule: str
    apply: Rule
    case: str = "paper"

    def judge(self, trio: Trio) -> Finding:
        """Apply the rule; not reproduced where the runs lack what the claim is about."""
        try:
            return self.apply(trio)
        except MissingError as missing:
            return Finding(NOT, {}, str(missing))


class Claims(list[Claim]):
    """Claims in the order of the paper."""

    def add(self, id: str, place: str, statement: str, rule: str, case: str = "paper") -> Callable[[Rule], Rule]:
        """Make a function the rule of a claim; the arguments are those of `Claim`."""

        def ruled_by(apply: Rule) -> Rule:
            self.append(Claim(id, place, statement, rule, apply, case))
            return apply

        return ruled_by


@dataclass(frozen=True)
class Judged:
    """A claim with what each scheme found."""

    claim: Claim
    findings: dict[str, Finding]

    @property
    def verdict(self) -> str:
        """Return the verdict of both schemes together: the common one, else partly."""
        verdicts = {finding.verdict for finding in self.findings.values()}
        return verdicts.pop() if len(verdicts) == 1 else PARTLY


def verdict(reproduced: bool, partly: bool = False) -> str:
    """Return the verdict of a rule that has a middle ground or none."""
    return REPRODUCED if reproduced else PARTLY if partly else NOT


def graded(value: float, good: float, fair: float) -> str:
    """Verdict of a number that should be small: at most `good`, at most `fair`, or more (NaN: more)."""
    return verdict(value <= good, value <= fair)


def milliseconds(seconds: float) -> str:
    """Return a time for reading."""
    return f"{number(1e3 * seconds, 3)} ms"


def moment(seconds: float) -> str:
    """Return a point of time for reading."""
    return f"{seconds:.4f} s" if seconds == seconds else "–"

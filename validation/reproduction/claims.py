"""What a claim of the paper is, how it is judged, and how the verdicts of two schemes become one.

A claim is judged by a rule on numbers of our runs; the rule is printed in the report.  It is judged twice,
on the fixed-step runs (the algorithm as printed) and on the event-located ones (the same equations, solved):
reproduced by both is reproduced, by neither at all is not reproduced, anything between is partly reproduced.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from validation.report.document import number
from validation.reproduction.measures import Trio

REPRODUCED, PARTLY, NOT = "reproduced", "partly", "not reproduced"
VERDICTS = (REPRODUCED, PARTLY, NOT)


class Finding(NamedTuple):
    """What one set of runs says about a claim: verdict, the numbers behind it, and these as text."""

    verdict: str
    numbers: dict[str, float]
    text: str


@dataclass(frozen=True)
class Claim:
    """One claim of the paper: where, what it says, the rule, and the function that applies the rule.

    `case` names the runs it is judged on: those of the paper's case, or of a scenario that sticks.
    """

    id: str
    place: str
    statement: str
    rule: str
    judge: Callable[[Trio], Finding]
    case: str = "paper"


Judge = Callable[[Trio], Finding]


class Claims(list[Claim]):
    """Claims in the order of the paper."""

    def add(self, id: str, place: str, statement: str, rule: str, case: str = "paper") -> Callable[[Judge], Judge]:
        """Make a function the judge of a claim; the arguments are those of `Claim`."""

        def judged_by(judge: Judge) -> Judge:
            self.append(Claim(id, place, statement, rule, judge, case))
            return judge

        return judged_by


@dataclass(frozen=True)
class Judged:
    """A claim with what each scheme found."""

    claim: Claim
    findings: dict[str, Finding]

    @property
    def verdict(self) -> str:
        """Return the verdict of both schemes together."""
        return combined([finding.verdict for finding in self.findings.values()])


def combined(verdicts: list[str]) -> str:
    """Put verdicts of several sets of runs together: the common one, else partly."""
    return verdicts[0] if len(set(verdicts)) == 1 else PARTLY


def graded(value: float, good: float, fair: float) -> str:
    """Verdict of a number that should be small: at most `good`, at most `fair`, or more (NaN: more)."""
    if value <= good:
        return REPRODUCED
    return PARTLY if value <= fair else NOT


def yes(condition: bool) -> str:
    """Verdict of a rule without middle ground."""
    return REPRODUCED if condition else NOT


def milliseconds(seconds: float) -> str:
    """Return a time for reading."""
    return f"{number(1e3 * seconds, 3)} ms"


def moment(seconds: float) -> str:
    """Return a point of time for reading."""
    return f"{seconds:.4f} s" if seconds == seconds else "–"


def missing(what: str) -> Finding:
    """Return the finding where the runs lack what the claim is about."""
    return Finding(NOT, {}, what)


def judge(claims: list[Claim], trios: dict[str, dict[str, Trio]]) -> list[Judged]:
    """Judge every claim on each scheme's runs; `trios` by case and scheme."""
    return [
        Judged(claim, {scheme: claim.judge(trio) for scheme, trio in trios[claim.case].items()})
        for claim in claims
    ]

"""What each choice that the paper leaves open does to the first and the second macro-collision."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import NamedTuple

from oblique_impact.validation.reproduction import energies, forces, motions
from oblique_impact.validation.reproduction.cases import MODELS, Case, Combination, Variant, case_key
from oblique_impact.validation.reproduction.claims import Claim
from oblique_impact.validation.reproduction.measures import Trio, longest
from oblique_impact.validation.reproduction.runs import Run, run_case

NAN = float("nan")
#: every claim, in the order of the paper's figures
ALL_CLAIMS: list[Claim] = [*forces.CLAIMS, *energies.CLAIMS, *motions.CLAIMS]


@dataclass(frozen=True)
class CollisionRow:
    """What happens in one macro-collision (SI units); NaN where there is nothing to tell."""

    start: float = NAN
    end: float = NAN
    contacts: int = 0
    normal_impulse: float = NAN
    tangential_impulse: float = NAN
    peak_force: float = NAN
    reversals: int = 0
    reversal: float = NAN  # the one nearest to 0.325 s (first) or the first one (second)
    sticks: int = 0
    stick_time: float = 0.0
    longest_stick_start: float = NAN
    energy_left: float = NAN


@dataclass(frozen=True)
class Studied:
    """One line of the study: a variant with its scheme, its run, and both macro-collisions."""

    variant: Variant
    scheme: str
    run: Run

    @cached_property
    def collisions(self) -> tuple[CollisionRow, CollisionRow]:
        """The first and the second macro-collision."""
        return _collision(self.run, 1), _collision(self.run, 2)

    @property
    def label(self) -> str:
        """Value of the choice, with * for the one that is assumed elsewhere."""
        return f"{self.variant.label} *" if self.variant.assumed else self.variant.label

    def flat(self) -> dict[str, str | bool | float]:
        """Return everything by name, for JSON and CSV."""
        variant, run = self.variant, self.run
        return {
            "choice": variant.choice,
            "variant": variant.label,
            "assumed": variant.assumed,
            "scheme": self.scheme,
            "model": str(run.scenario.contact.friction),
            "outcome": run.history.outcome.label,
            **{
                f"{name}_{key}": value
                for name, row in zip(("first", "second"), self.collisions, strict=True)
                for key, value in asdict(row).items()
            },
        }


def _collision(run: Run, number: int) -> CollisionRow:
    if len(run.macros) < number:
        return CollisionRow()
    macro = run.macro(number)
    reversals, sticks = run.reversals_in(macro), run.sticks_in(macro)
    wanted = motions.REVERSAL if number == 1 else macro.start
    # total energy (J) in the flight that follows, or at the end
    until = run.macros[number].start if len(run.macros) > number else run.end_time
    return CollisionRow(
        **asdict(macro),
        reversals=len(reversals),
        reversal=min(reversals, key=lambda time: abs(time - wanted), default=NAN),
        sticks=len(sticks),
        stick_time=sum(stick.duration for stick in sticks),
        longest_stick_start=longest(sticks)[0],
        energy_left=run.at("energy", 0.5 * (macro.end + until)),
    )


class Robustness(NamedTuple):
    """The verdicts of one combination of open choices, by claim, and what its second macro-collision is like.

    `second` holds first touch, last release, start and duration of the longest stick (s) of the hybrid model.
    """

    combination: Combination
    verdicts: dict[str, str]
    outcomes: tuple[str, ...]
    second: tuple[float, float, float, float]


def judge_combination(combination: Combination) -> Robustness:
    """Run the three models with one combination of open choices and judge the claims about the paper's case."""
    runs = [
        run_case(Case(case_key("grid", combination.scheme, model), combination.scenario(model)))
        for model in MODELS
    ]
    trio = Trio(*runs)
    verdicts = {claim.id: claim.judge(trio).verdict for claim in ALL_CLAIMS if claim.case == "paper"}
    second = (NAN, NAN, NAN, 0.0)
    for macro in trio.hybrid.macros[1:2]:
        second = (macro.start, macro.end, *longest(trio.hybrid.sticks_in(macro)))
    return Robustness(combination, verdicts, tuple(run.history.outcome.label for run in runs), second)

"""What each choice that the paper leaves open does to the first and the second macro-collision."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import NamedTuple

from oblique_impact.contact.state import State
from validation.reproduction import energies, forces, motions
from validation.reproduction.cases import MODELS, Case, Combination, Variant, case_key
from validation.reproduction.claims import Claim
from validation.reproduction.measures import Trio, longest_stick
from validation.reproduction.runs import Macro, Run, run_case, stays

NAN = float("nan")


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


class Studied(NamedTuple):
    """One line of the study: a variant with its scheme, its run, and both macro-collisions."""

    variant: Variant
    scheme: str
    run: Run
    first: CollisionRow
    second: CollisionRow

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
            "outcome": run.outcome,
            **{f"first_{key}": value for key, value in asdict(self.first).items()},
            **{f"second_{key}": value for key, value in asdict(self.second).items()},
        }


def study(variant: Variant, scheme: str, run: Run) -> Studied:
    """Put a variant's run into a line of the table."""
    return Studied(variant, scheme, run, _collision(run, 1), _collision(run, 2))


def _collision(run: Run, number: int) -> CollisionRow:
    macro = run.macro(number)
    if macro is None:
        return CollisionRow()
    reversals, sticks = run.reversals_in(macro), run.sticks_in(macro)
    if not reversals:
        reversal = NAN
    else:
        reversal = min(reversals, key=lambda t: abs(t - motions.REVERSAL)) if number == 1 else reversals[0]
    return CollisionRow(
        macro.start,
        macro.end,
        macro.contacts,
        macro.normal_impulse,
        macro.tangential_impulse,
        macro.peak_force,
        len(reversals),
        reversal,
        len(sticks),
        sum(stick.duration for stick in sticks),
        longest_stick(run, macro)[0],
        _energy_after(run, macro, number),
    )


def _energy_after(run: Run, macro: Macro, number: int) -> float:
    """Total energy (J) in the flight that follows a macro-collision, or at the end."""
    following = run.macro(number + 1)
    until = following.start if following else run.end_time
    return float(run.at("energy", 0.5 * (macro.end + until)))


def contact_spans(run: Run, macro: Macro) -> list[tuple[float, float, State]]:
    """Stays in contact during a macro-collision: begin, end (s) and state; a rebound has no length."""
    inside = [event for event in run.events if macro.start <= event.time <= macro.end]
    return [
        (event.time, end if event.state != State.FREE else event.time, event.state)
        for event, end in stays(inside, macro.end)
        if event.state != State.FREE or event.kind.impulsive
    ]


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
    verdicts = {claim.id: claim.judge(trio).verdict for claim in paper_claims()}
    macro = trio.hybrid.macro(2)
    second = (macro.start, macro.end, *longest_stick(trio.hybrid, macro)) if macro else (NAN, NAN, NAN, 0.0)
    return Robustness(combination, verdicts, tuple(run.outcome for run in runs), second)


def paper_claims() -> list[Claim]:
    """Return the claims that are judged on the paper's own case."""
    return [claim for claim in all_claims() if claim.case == "paper"]


def all_claims() -> list[Claim]:
    """Return every claim, in the order of the paper's figures."""
    return [*forces.CLAIMS, *energies.CLAIMS, *motions.CLAIMS]

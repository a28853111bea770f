"""The paper's claims, each with the rule by which it is judged.

A rule is a function of the runs of the three friction models.  Each claim is judged twice: on the fixed-step runs
(the algorithm as printed) and on the event-located ones (the same equations, solved).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np

from oblique_impact.contact.state import State
from oblique_impact.validation.paper.measures import (
    NAN,
    REVERSAL,
    STICK,
    MissingError,
    Models,
    between,
    existing,
    flight_ranges,
    force_difference,
    increasing,
    inside,
    largest_difference,
    longest,
    macro,
    macros,
    reversals,
    sampled,
    stays,
    stick_share,
    sticks,
    value_at,
    values,
)
from oblique_impact.validation.report import number

REPRODUCED, PARTLY, NOT = VERDICTS = ("reproduced", "partly", "not reproduced")

_POINT = ("tip_x", "tip_vx", "tip_y", "tip_vy")


class Finding(NamedTuple):
    """What a rule finds in one set of runs: verdict, the numbers behind it (SI units), and these as text."""

    verdict: str
    numbers: dict[str, float]
    text: str


Rule = Callable[[Models], Finding]


@dataclass(frozen=True)
class Claim:
    """One claim of the paper: where, what it says, the rule in words and as a function.

    `case` is the group of the runs it is judged on, see ``cases``.
    """

    id: str
    place: str
    statement: str
    rule: str
    apply: Rule
    case: str = "paper"

    def judge(self, models: Models) -> Finding:
        """Apply the rule; not reproduced where the runs lack what the claim is about."""
        try:
            return self.apply(models)
        except MissingError as missing:
            return Finding(NOT, {}, str(missing))


@dataclass(frozen=True)
class Judged:
    """A claim, what each scheme found, and how many combinations of open choices give which verdict.

    There are no combinations for claims about other cases than the paper's.
    """

    claim: Claim
    findings: Mapping[str, Finding]
    combinations: Mapping[str, int] | None = None

    @property
    def verdict(self) -> str:
        """The verdict that both schemes share, else partly."""
        verdicts = {finding.verdict for finding in self.findings.values()}
        return verdicts.pop() if len(verdicts) == 1 else PARTLY

    @property
    def discriminates(self) -> bool:
        """Whether some combination of open choices does not reproduce the claim: else it tells nothing of them."""
        return self.combinations is None or self.combinations[REPRODUCED] < sum(self.combinations.values())


#: the claims in the order of the paper's figures
CLAIMS: list[Claim] = []


def claim(place: str, id: str = "", case: str = "paper") -> Callable[[Rule], Rule]:
    """Make a function the rule of a claim.

    Its docstring says what the paper claims, and behind an empty line the rule in words; its name is the id.
    """

    def add(apply: Rule) -> Rule:
        statement, rule = (" ".join(part.split()) for part in str(apply.__doc__).split("\n\n"))
        CLAIMS.append(Claim(id or apply.__name__.replace("_", "-"), place, statement, rule, apply, case))
        return apply

    return add


def verdict(reproduced: bool, partly: bool = False) -> str:
    """Return the verdict of a rule that has a middle ground or none."""
    return REPRODUCED if reproduced else PARTLY if partly else NOT


def graded(value: float, good: float, fair: float) -> str:
    """Return the verdict of a number that should be small: at most `good`, at most `fair`, or more (NaN: more)."""
    return verdict(value <= good, value <= fair)


def milliseconds(seconds: float) -> str:
    """Format a duration for reading."""
    return f"{number(1e3 * seconds, 3)} ms"


def instant(seconds: float) -> str:
    """Format a point of time for reading."""
    return f"{seconds:.4f} s" if seconds == seconds else "–"


# --- impacts and their forces (Figs. 2 and 3)


def _differences(models: Models, name: str) -> list[float]:
    """Return the largest difference of any two models in macro-collisions 1 to 3; two of them have friction."""
    pairs = [(models.hybrid, models.modified)] if name == "lambda_tau" else list(combinations(models, 2))
    return [max(force_difference(a, b, name, k) for a, b in pairs) for k in (1, 2, 3)]


def _of_three(verdict: str, found: list[float], what: str, scale: float = 1.0, unit: str = "") -> Finding:
    """Return the finding about a number of macro-collisions 1 to 3."""
    numbers = {f"collision_{k}": value for k, value in enumerate(found, start=1)}
    return Finding(verdict, numbers, f"{what} 1, 2, 3: {', '.join(number(scale * v, 3) for v in found)}{unit}")


def _growing(found: list[float]) -> str:
    """Judge whether a number grows with every macro-collision that the runs share."""
    return verdict(increasing(existing(found)), found[1] > found[0])


@claim("Sec. 7, Fig. 2")
def first_collision(models: Models) -> Finding:
    """The first macro-collision occurs at t ≈ 0.325 s.

    reproduced: 0.325 s lies in the hybrid model's first macro-collision, at most 2 ms from its middle; partly: it
    lies in it
    """
    first = macro(models.hybrid, 1)
    start, end, middle = first.start, first.end, 0.5 * (first.start + first.end)
    contained = start <= REVERSAL <= end
    text = f"{instant(start)} to {instant(end)}, middle {instant(middle)}"
    numbers = {"start": start, "end": end, "middle": middle}
    return Finding(verdict(contained and abs(middle - REVERSAL) <= 2e-3, contained), numbers, text)


@claim("Sec. 7, Fig. 2")
def friction_coincides(models: Models) -> Finding:
    """The friction of the hybrid and of the modified Coulomb model generally coincide during the first collision.

    D₁ = ∫|a − b| dt / ∫(|a| + |b|) dt over the first macro-collision; reproduced: D₁ ≤ 0.1; partly: ≤ 0.3
    """
    first = _differences(models, "lambda_tau")[0]
    return Finding(graded(first, 0.1, 0.3), {"difference": first}, f"difference {number(first, 3)}")


@claim("Sec. 7, Fig. 2")
def friction_slight_difference(models: Models) -> Finding:
    """Some slight differences still exist between them.

    reproduced: D₁ > 10⁻⁶
    """
    first = _differences(models, "lambda_tau")[0]
    return Finding(verdict(first > 1e-6), {"difference": first}, f"difference {number(first, 3)}")


@claim("Sec. 7, Fig. 2")
def friction_drifts_apart(models: Models) -> Finding:
    """The differences increase gradually in subsequent collisions.

    D as above for macro-collisions 1, 2, 3, as far as both runs have them; reproduced: it grows with each; partly:
    D₁ < D₂
    """
    found = _differences(models, "lambda_tau")
    return _of_three(_growing(found), found, "differences in collisions")


@claim("Sec. 7, Fig. 3")
def normal_coincides(models: Models) -> Finding:
    """The normal forces of the three models agree fairly well during the first macro-collision.

    largest D₁ of the three pairs; reproduced: ≤ 0.1; partly: ≤ 0.3
    """
    first = _differences(models, "lambda_n")[0]
    return Finding(graded(first, 0.1, 0.3), {"difference": first}, f"largest difference {number(first, 3)}")


@claim("Sec. 7, Fig. 3")
def normal_separates(models: Models) -> Finding:
    """The curves of the normal force become separated during subsequent collisions.

    largest D of the three pairs in macro-collisions 2 and 3, as far as all runs have them; reproduced: each is at
    least 0.3 and larger than D₁; partly: one is
    """
    found = _differences(models, "lambda_n")
    holds = [value >= 0.3 and value > found[0] for value in existing(found)[1:]]
    return _of_three(verdict(bool(holds) and all(holds), any(holds)), found, "differences in collisions")


@claim("Sec. 7, Fig. 3")
def impact_times_spread(models: Models) -> Finding:
    """The differences between the times of impact are slight at first and become increasingly obvious.

    spread of the three models' first touches in macro-collisions 1, 2, 3, as far as all have them; reproduced: it
    grows with each; partly: from the first to the second
    """
    starts = [[macro.start for macro in macros(run)[:3]] + [NAN] * 3 for run in models]
    spread = [float(np.ptp([own[k] for own in starts])) for k in range(3)]
    return _of_three(_growing(spread), spread, "spread of the first touches", 1e3, " ms")


@claim("Sec. 4.2")
def no_motion_across(models: Models) -> Finding:
    """During the collision the displacement, velocity and acceleration of the impact point across the slope are
    always zero.

    largest |Z_n| in contact; reproduced: ≤ 10⁻⁹ m; partly: ≤ 10⁻⁵ m
    """
    closed = values(models.hybrid, "state") != State.FREE
    if not closed.any():
        raise MissingError("no contact")
    gap, speed = (float(np.max(np.abs(values(models.hybrid, name)[closed]))) for name in ("gap", "gap_rate"))
    text = f"largest |Z_n| {number(1e3 * gap, 3)} mm, |Z_n'| {number(speed, 3)} m/s"
    return Finding(graded(gap, 1e-9, 1e-5), {"gap": gap, "gap_rate": speed}, text)


@claim("Secs. 7, 8")
def friction_matters(models: Models) -> Finding:
    """The influence of the tangential friction force cannot be ignored.

    reproduced: friction shifts the first touch of the second macro-collision by at least 1 ms
    """
    shift = macro(models.hybrid, 2).start - macro(models.frictionless, 2).start
    text = f"second touch {milliseconds(abs(shift))} {'earlier' if shift < 0.0 else 'later'} with friction"
    return Finding(verdict(abs(shift) >= 1e-3), {"shift": shift}, text)


# --- energies (Figs. 4 to 7)


@claim("Sec. 7, Fig. 4")
def energy_constant_before(models: Models) -> Finding:
    """During the initial collision-free stage the total mechanical energy remains constant.

    largest relative change up to the first touch; reproduced: ≤ 10⁻⁶; partly: ≤ 10⁻³
    """
    energy = values(models.hybrid, "energy")[inside(models.hybrid, 0.0, models.before_contact)]
    drift = float(np.max(np.abs(energy / energy[0] - 1.0)))
    text = f"{number(float(energy[0]))} J, relative drift {number(drift, 2)}"
    return Finding(graded(drift, 1e-6, 1e-3), {"initial": float(energy[0]), "drift": drift}, text)


@claim("Sec. 7, Fig. 4")
def considerable_loss(models: Models) -> Finding:
    """The collision can cause considerable loss of energy.

    reproduced: the first macro-collision takes at least 10 % of the total mechanical energy
    """
    time = between(models, 1)
    if time is None:
        raise MissingError("no flight after the first collision")
    initial = float(values(models.hybrid, "energy")[0])
    loss = initial - value_at(models.hybrid, "energy", time)
    text = f"{number(loss, 4)} J, {number(100.0 * loss / initial, 3)} % of the total"
    return Finding(verdict(loss / initial >= 0.1), {"loss": loss, "share": loss / initial}, text)


def _ordering(models: Models, holds: Callable[[float, float, float], bool]) -> Finding:
    """Judge a relation of the total energies in flight after the first two collisions, and at the end."""
    numbers: dict[str, float] = {}
    held, parts = [], []
    times = {"after collision 1": between(models, 1), "after collision 2": between(models, 2), "end": models.end}
    for name, time in times.items():
        if time is None:
            continue
        energies = [value_at(run, "energy", time) for run in models]
        numbers |= {f"{model} {name}": v for model, v in zip(models._fields, energies, strict=True)}
        held.append(holds(*energies))
        row = " / ".join(number(value, 5) for value in energies)
        parts.append(f"{name} {row} J {'✓' if held[-1] else '✗'}")
    return Finding(verdict(all(held), any(held)), numbers, "; ".join(parts))


@claim("Sec. 7, Fig. 4")
def hybrid_loses_most(models: Models) -> Finding:
    """The energy loss calculated using the hybrid model is the largest.

    total energy of hybrid / frictionless / modified Coulomb in flight after collisions 1 and 2 and at the end;
    reproduced: the hybrid model's is the smallest each time; partly: at least once
    """
    return _ordering(models, lambda hybrid, frictionless, modified: hybrid < min(frictionless, modified))


@claim("Sec. 7, Fig. 4")
def frictionless_loses_least(models: Models) -> Finding:
    """The energy loss calculated using the nontangential friction model is the smallest.

    as above; reproduced: the frictionless model's energy is the largest each time; partly: at least once
    """
    return _ordering(models, lambda hybrid, frictionless, modified: frictionless > max(hybrid, modified))


@claim("Sec. 7, Fig. 4")
def friction_dissipates(models: Models) -> Finding:
    """Tangential friction can cause some energy loss to the system.

    reproduced: the work taken by friction in the hybrid model is positive
    """
    energy = models.hybrid.balance
    work, whole = energy["lost_friction"], energy["initial"] - energy["final"]
    text = f"{number(1e3 * work, 4)} mJ, {number(100.0 * work / whole, 3)} % of what is lost in the run"
    return Finding(verdict(work > 0.0), {"friction": work, "lost": whole}, text)


@claim("Sec. 7, Figs. 5–7")
def exchange_before(models: Models) -> Finding:
    """During the initial stage kinetic and gravitational energy convert mutually; elastic energy is tiny.

    largest elastic energy over the change of gravitational energy; reproduced: ≤ 10⁻³; partly: ≤ 10⁻²
    """
    before = inside(models.hybrid, 0.0, models.before_contact)
    exchanged = float(np.ptp(values(models.hybrid, "energy_gravity")[before]))
    elastic = float(np.max(values(models.hybrid, "energy_elastic")[before]))
    text = f"{number(exchanged, 4)} J exchanged, elastic at most {number(elastic, 2)} J"
    return Finding(graded(elastic / exchanged, 1e-3, 1e-2), {"exchanged": exchanged, "elastic": elastic}, text)


@claim("Sec. 7, Figs. 5–7")
def elastic_after(models: Models) -> Finding:
    """After the collision the elastic potential energy is no longer zero.

    reproduced: its largest value in the first macro-collision is at least 100 times that before
    """
    first, elastic = macro(models.hybrid, 1), values(models.hybrid, "energy_elastic")
    before = float(np.max(elastic[inside(models.hybrid, 0.0, models.before_contact)]))
    after = float(np.max(elastic[inside(models.hybrid, first.start, first.end)]))
    text = f"largest {number(before, 2)} J before, {number(after, 4)} J in the first collision"
    return Finding(verdict(after >= 100.0 * before), {"before": before, "after": after}, text)


@claim("Sec. 7, Figs. 5–7")
def all_parts_smaller(models: Models) -> Finding:
    """After the first macro-collision the kinetic, gravitational and elastic energies of the hybrid model are all
    smaller than those of the other two.

    from the end of the first macro-collision to the end of the run; reproduced: each is the smallest for at least
    95 % of the time; partly: the mean over time of each is the smallest
    """
    start = max(macro(run, 1).end for run in models)
    numbers: dict[str, float] = {}
    shares, smallest, texts = [], [], []
    for part in ("kinetic", "gravity", "elastic"):
        energies = sampled(models, f"energy_{part}", start, models.end)
        means = energies.mean(axis=1).tolist()
        shares.append(float(np.mean(energies[0] < energies[1:].min(axis=0))))
        smallest.append(means[0] < min(means[1:]))
        numbers[f"{part} share"] = shares[-1]
        numbers |= {f"{part} mean {model}": mean for model, mean in zip(models._fields, means, strict=True)}
        mean = "smallest" if smallest[-1] else "not"
        texts.append(f"{part} {number(100.0 * shares[-1], 3)} % of the time, mean {mean}")
    return Finding(verdict(min(shares) >= 0.95, all(smallest)), numbers, "; ".join(texts))


# --- motion of the impact point, slip and stick (Figs. 8 to 16)


@claim("Sec. 7, Figs. 8–13")
def same_before(models: Models) -> Finding:
    """The curves obtained using the three models are all the same before collision.

    largest difference relative to each curve's largest value; reproduced: ≤ 10⁻⁹; partly: ≤ 10⁻⁶
    """
    worst = largest_difference(models, (*_POINT, "theta", "theta_dot", "slip"), models.before_contact)
    text = f"largest relative difference {number(worst, 2)}"
    return Finding(graded(worst, 1e-9, 1e-6), {"difference": worst}, text)


@claim("Sec. 7, Figs. 10–13")
def different_after(models: Models) -> Finding:
    """After the impact the curves no longer coincide well, owing to friction.

    reproduced: the largest relative difference reaches 1 %
    """
    before, after = (largest_difference(models, _POINT, end) for end in (models.before_contact, models.end))
    text = f"largest relative difference {number(before, 2)} before, {number(after, 2)} after"
    return Finding(verdict(after >= 0.01 and after > before), {"before": before, "after": after}, text)


@claim("Sec. 7, Figs. 10–13")
def similar_after(models: Models) -> Finding:
    """The varying tendencies of the curves are generally similar.

    smallest correlation coefficient with the hybrid model after the first macro-collision, inertial displacements
    and velocities; reproduced: ≥ 0.9; partly: ≥ 0.5
    """
    start = max(macro(run, 1).end for run in models)
    courses = {name: sampled(models, name, start, models.end) for name in _POINT}
    found = {name: float(np.min(np.asarray(np.corrcoef(course))[0])) for name, course in courses.items()}
    pairs = zip(("x", "x'", "y", "y'"), found.values(), strict=True)
    text = ", ".join(f"{name} {number(value, 3)}" for name, value in pairs)
    numbers = {f"correlation {name}": value for name, value in found.items()}
    return Finding(graded(-min(found.values()), -0.9, -0.5), numbers, text)


@claim("Sec. 7, Fig. 14")
def maximum_before(models: Models) -> Finding:
    """The tangential displacement first increases to its maximum and then decreases during the initial
    collision-free stage.

    reproduced: it rises and falls by more than 1 mm before the first touch
    """
    before = inside(models.hybrid, 0.0, models.before_contact)
    slip, times = values(models.hybrid, "slip")[before], values(models.hybrid, "time")[before]
    top = int(np.argmax(slip))
    first, most, last, when = float(slip[0]), float(slip[top]), float(slip[-1]), float(times[top])
    numbers = {"time": when, "maximum": most, "rise": most - first, "fall": most - last}
    text = f"from {number(first, 4)} up to {number(most, 4)} m at {instant(when)}, down to {number(last, 4)} m"
    return Finding(verdict(min(most - first, most - last) > 1e-3), numbers, text)


@claim("Sec. 7, Fig. 14")
def changes_shrink(models: Models) -> Finding:
    """After collision the change in displacement becomes smaller with the number of collisions.

    largest minus smallest tangential position in each flight; reproduced: it falls from flight to flight; partly:
    it is largest before the first collision
    """
    ranges = flight_ranges(models.hybrid, "slip")
    if len(ranges) < 3:
        raise MissingError("fewer than three flights")
    numbers = {f"flight_{k}": value for k, value in enumerate(ranges)}
    text = f"change per flight {', '.join(number(1e3 * value, 3) for value in ranges)} mm"
    return Finding(verdict(increasing(ranges[::-1]), ranges[0] > max(ranges[1:])), numbers, text)


def _share_of_stick(models: Models, first: bool) -> tuple[dict[str, float], str]:
    """Return numbers and text about stick in the hybrid model's first macro-collision, or in all others."""
    run = models.hybrid
    among = [macro(run, 1)] if first else macros(run)[1:]
    found = [stay for macro in among for stay in sticks(run, macro)]
    total, share = sum(stay.duration for stay in found), stick_share(run, among)
    numbers = {"sticks": float(len(found)), "duration": total, "share": share}
    if not found:
        return numbers, "no stick"
    numbers["fastest"] = fastest = max(abs(stay.slip_rate) for stay in found)
    part = f"{number(1e6 * total, 3)} µs in all, {number(100.0 * share, 3)} % of the contact"
    speed = f"slip velocity as they begin up to {number(1e3 * fastest, 3)} mm/s"
    return numbers, f"{len(found)} stays judged as stick, {part}; {speed}"


@claim("Sec. 7, Figs. 14, 15")
def slip_only_first(models: Models) -> Finding:
    """Only slip occurs during the first macro-collision; the impact point keeps sliding.

    time in the state stick over time in contact; reproduced: 0; partly: ≤ 1 %
    """
    numbers, text = _share_of_stick(models, first=True)
    return Finding(graded(numbers["share"], 0.0, 0.01), numbers, text)


@claim("Sec. 7, Fig. 15")
def direction_changes(models: Models) -> Finding:
    """The direction of slip changes at t ≈ 0.325 s.

    the reversal in contact nearest to 0.325 s; reproduced: within 0.5 ms; partly: within 3 ms
    """
    times = reversals(models.hybrid, macro(models.hybrid, 1))
    if not times:
        raise MissingError("no reversal in contact")
    nearest = min(times, key=lambda time: abs(time - REVERSAL))
    text = f"reversals at {', '.join(map(instant, times))}"
    numbers = {"nearest": nearest, "reversals": float(len(times))}
    return Finding(graded(abs(nearest - REVERSAL), 5e-4, 3e-3), numbers, text)


@claim("Sec. 7, Fig. 14")
def sticks_later(models: Models) -> Finding:
    """Stick and slip both occur during subsequent collisions.

    time in the state stick over time in contact after the first macro-collision; reproduced: at least 1 %; partly:
    more than 0
    """
    macro(models.hybrid, 2)
    numbers, text = _share_of_stick(models, first=False)
    return Finding(verdict(0.01 <= numbers["share"] < 1.0, numbers["share"] > 0.0), numbers, text)


@claim("Sec. 7, Fig. 16")
def slips_at_first(models: Models) -> Finding:
    """The impact point remains in the slip state during the initial stage of the second macro-collision.

    reproduced: the first state of contact in it is slip
    """
    second = macro(models.hybrid, 2)
    closed = [stay.state for stay in stays(models.hybrid, second) if stay.state != State.FREE]
    if not closed:
        return Finding(NOT, {"start": second.start}, f"from {instant(second.start)}: rebounds only")
    text = f"from {instant(second.start)}, first state {closed[0].name.lower()}"
    return Finding(verdict(closed[0] == State.SLIP), {"start": second.start, "state": float(closed[0])}, text)


@claim("Sec. 7, Fig. 16")
def second_collision(models: Models) -> Finding:
    """The second macro-collision is under way at t ≈ 0.699 s.

    reproduced: 0.699 s lies in the hybrid model's second macro-collision; partly: at most 5 ms away
    """
    second = macro(models.hybrid, 2)
    off = max(second.start - STICK, STICK - second.end, 0.0)
    text = f"{instant(second.start)} to {instant(second.end)}, {milliseconds(off)} away"
    return Finding(graded(off, 0.0, 5e-3), {"start": second.start, "end": second.end, "off": off}, text)


@claim("Sec. 7, Fig. 16", id="stick-at-0.699")
def stick_at(models: Models) -> Finding:
    """It changes to the stick state at t ≈ 0.699 s.

    the longest stay in the state stick of the second macro-collision, if it lasts 0.1 ms; reproduced: it begins
    within 2 ms of 0.699 s; partly: within 5 ms
    """
    start, duration = longest(sticks(models.hybrid, macro(models.hybrid, 2)))
    text = f"longest stay judged as stick from {instant(start)}, {number(1e6 * duration, 3)} µs"
    off = abs(start - STICK) if duration >= 1e-4 else NAN
    numbers = {"start": start, "duration": duration}
    return Finding(graded(off, 2e-3, 5e-3), numbers, text if duration else "no stick")


@claim("Sec. 7, Fig. 16")
def stick_to_the_end(models: Models) -> Finding:
    """It remains viscous (sticking) until the second macro-collision ends.

    reproduced: the last release of the second macro-collision is out of the state stick
    """
    second = macro(models.hybrid, 2)
    last = max((stay.end for stay in sticks(models.hybrid, second)), default=NAN)
    left = second.end - last
    text = "no stick" if np.isnan(last) else f"last stick ends {milliseconds(left)} before the last release"
    return Finding(verdict(left < 1e-6), {"end": second.end, "last_stick_end": last}, text)


@claim("Sec. 7, Fig. 2", case="sticking")
def modified_cannot_stick(models: Models) -> Finding:
    """The modified Coulomb model cannot reflect the static stage of friction.

    scenario sticking, second half of the hybrid model's longest stick: the modified Coulomb model's tip moves at
    least 1,000 times as far as the hybrid model's, which moves at most 10⁻⁸ m (reproduced) or 10⁻⁴ m (partly)
    """
    begin, duration = longest(sticks(models.hybrid))
    if not duration:
        raise MissingError("the hybrid model does not stick here")
    # the second half of it: what slipped before the stick has come to rest in both models
    start, end = begin + 0.5 * duration, begin + duration
    pair = models.hybrid, models.modified
    held, crept = (float(np.ptp(values(run, "slip")[inside(run, start, end)])) for run in pair)
    moved = f"hybrid moves {number(held, 2)} m, modified Coulomb {number(crept, 2)} m"
    apart = crept >= 1e3 * held
    numbers = {"hybrid": held, "modified": crept}
    text = f"{instant(start)} to {instant(end)}: {moved}"
    return Finding(verdict(apart and held <= 1e-8, apart and held <= 1e-4), numbers, text)


@claim("Sec. 7, Fig. 2", case="rough")
def states_interchange(models: Models) -> Finding:
    """Stick and slip can interchange when the hybrid model is used.

    the paper's slope with μ = 12 (three mean-axis modes); reproduced: slip goes over into stick and stick into
    slip, with at least 1 ms of stick
    """
    pairs = list(pairwise(event.state for event in models.hybrid.events))
    held, freed = pairs.count((State.SLIP, State.STICK)), pairs.count((State.STICK, State.SLIP))
    total = sum(stay.duration for stay in sticks(models.hybrid))
    text = f"{held} times slip to stick, {freed} times stick to slip, {milliseconds(total)} of stick"
    numbers = {"to_stick": float(held), "to_slip": float(freed), "stick_time": total}
    return Finding(verdict(held > 0 and freed > 0 and total >= 1e-3), numbers, text)

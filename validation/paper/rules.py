"""The paper's claims in the order of its figures, each with the function that judges it.

Its docstring is the rule in words, as reports show it.  It takes the runs of the three friction models, and
returns a verdict with what it found in words.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from oblique_impact.contact.state import State
from oblique_impact.history.history import History
from oblique_impact.validation.paper.measures import (
    NAN,
    REVERSAL,
    STICK,
    MissingError,
    Models,
    Span,
    collision,
    collisions,
    force_difference,
    in_flight,
    longest,
    reversals,
    sampled,
    stays,
    sticks,
    within,
)
from oblique_impact.validation.report import number

REPRODUCED, PARTLY, NOT = VERDICTS = ("reproduced", "partly", "not reproduced")
POINT = ("tip_x", "tip_vx", "tip_y", "tip_vy")
#: a verdict, and the numbers behind it in words
Finding = tuple[str, str]
Rule = Callable[[Models], Finding]


@dataclass(frozen=True)
class Claim:
    """One claim: its place in the paper and sentence, the rule in words, the group of ``cases`` to judge it on."""

    id: str
    place: str
    paper: str
    rule: str
    case: str
    function: Rule

    def judge(self, models: Models) -> Finding:
        """Apply the rule; not reproduced where the runs lack what the claim is about."""
        try:
            return self.function(models)
        except MissingError as missing:
            return NOT, str(missing)


#: the claims in the order of the paper's figures
CLAIMS: list[Claim] = []


def claim(place: str, paper: str, case: str = "paper", id: str = "") -> Callable[[Rule], Rule]:
    """Return the decorator that makes a function the rule of a claim, which has its name."""
    # all figures are of this section
    place = f"Sec. 7, {place}" if place.startswith("Fig") else place

    def add(rule: Rule) -> Rule:
        words = " ".join((rule.__doc__ or "").split())
        CLAIMS.append(Claim(id or rule.__name__.replace("_", "-"), place, paper, words, case, rule))
        return rule

    return add


def verdict(reproduced: bool, partly: bool = False) -> str:
    """Return the verdict of a rule that has a middle ground or none."""
    return REPRODUCED if reproduced else PARTLY if partly else NOT


def graded(value: float, good: float, fair: float) -> str:
    """Return the verdict of a number that should be small: at most `good`, at most `fair`, or more (NaN: more)."""
    return verdict(value <= good, value <= fair)


# --- impacts and their forces (Figs. 2 and 3)


def differences(models: Models, name: str) -> list[float]:
    """Return the largest difference of any two models in macro-collisions 1 to 3; two of them have friction."""
    pairs = [(models.hybrid, models.modified)] if name == "lambda_tau" else list(combinations(models, 2))
    return [max(force_difference(a, b, name, k) for a, b in pairs) for k in (1, 2, 3)]


def in_words(found: list[float]) -> str:
    """Return values in macro-collisions 1 to 3, "–" where the runs do not share one."""
    return "1, 2, 3: " + ", ".join(number(value, 3) for value in found)


def growth(found: list[float]) -> str:
    """Judge whether a number grows with every macro-collision that the runs share; NaN where they do not."""
    first, second, third = found
    return verdict(first < second and not third <= second, first < second)


@claim("Fig. 2", "The first macro-collision occurs at t ≈ 0.325 s.")
def first_collision(models: Models) -> Finding:
    """reproduced: 0.325 s lies in the hybrid model's first macro-collision, at most 2 ms from its middle; partly:
    it lies in it"""
    start, end = collision(models.hybrid, 1)
    middle, contained = 0.5 * (start + end), start <= REVERSAL <= end
    text = f"{start:.4f} s to {end:.4f} s, middle {middle:.4f} s"
    return verdict(contained and abs(middle - REVERSAL) <= 2e-3, contained), text


@claim(
    "Fig. 2",
    "The friction of the hybrid and of the modified Coulomb model generally coincide during the first collision.",
)
def friction_coincides(models: Models) -> Finding:
    """D₁ = ∫|a − b| dt / ∫(|a| + |b|) dt over the first macro-collision; reproduced: D₁ ≤ 0.1; partly: ≤ 0.3"""
    first = differences(models, "lambda_tau")[0]
    return graded(first, 0.1, 0.3), f"difference {number(first, 3)}"


@claim("Fig. 2", "Some slight differences still exist between them.")
def friction_slight_difference(models: Models) -> Finding:
    """reproduced: D₁ > 10⁻⁶"""
    first = differences(models, "lambda_tau")[0]
    return verdict(first > 1e-6), f"difference {number(first, 3)}"


@claim("Fig. 2", "The differences increase gradually in subsequent collisions.")
def friction_drifts_apart(models: Models) -> Finding:
    """D as above for macro-collisions 1, 2, 3, as far as both runs have them; reproduced: it grows with each;
    partly: D₁ < D₂"""
    found = differences(models, "lambda_tau")
    return growth(found), f"differences in collisions {in_words(found)}"


@claim("Fig. 3", "The normal forces of the three models agree fairly well during the first macro-collision.")
def normal_coincides(models: Models) -> Finding:
    """largest D₁ of the three pairs; reproduced: ≤ 0.1; partly: ≤ 0.3"""
    first = differences(models, "lambda_n")[0]
    return graded(first, 0.1, 0.3), f"largest difference {number(first, 3)}"


@claim("Fig. 3", "The curves of the normal force become separated during subsequent collisions.")
def normal_separates(models: Models) -> Finding:
    """largest D of the three pairs in macro-collisions 2 and 3, as far as all runs have them; reproduced: each is
    at least 0.3 and larger than D₁; partly: one is"""
    first, *later = found = differences(models, "lambda_n")
    holds = [value >= 0.3 and value > first for value in later if not np.isnan(value)]
    return verdict(bool(holds) and all(holds), any(holds)), f"differences in collisions {in_words(found)}"


@claim(
    "Fig. 3", "The differences between the times of impact are slight at first and become increasingly obvious."
)
def impact_times_spread(models: Models) -> Finding:
    """spread of the three models' first touches in macro-collisions 1, 2, 3, as far as all have them; reproduced:
    it grows with each; partly: from the first to the second"""
    starts = [([start for start, _ in collisions(run)] + 3 * [NAN])[:3] for run in models]
    found = np.ptp(starts, axis=0)
    return growth(found.tolist()), f"spread of the first touches {in_words((1e3 * found).tolist())} ms"


@claim(
    "Sec. 4.2",
    "During the collision the displacement, velocity and acceleration of the impact point across the slope "
    "are always zero.",
)
def no_motion_across(models: Models) -> Finding:
    """largest |Z_n| in contact; reproduced: ≤ 10⁻⁹ m; partly: ≤ 10⁻⁵ m"""
    closed = models.hybrid["state"].values != State.FREE
    if not closed.any():
        raise MissingError("no contact")
    gap, speed = (float(np.max(np.abs(models.hybrid[name].values[closed]))) for name in ("gap", "gap_rate"))
    return graded(gap, 1e-9, 1e-5), f"largest |Z_n| {number(1e3 * gap, 3)} mm, |Z_n'| {number(speed, 3)} m/s"


@claim("Secs. 7, 8", "The influence of the tangential friction force cannot be ignored.")
def friction_matters(models: Models) -> Finding:
    """reproduced: friction shifts the first touch of the second macro-collision by at least 1 ms"""
    shift = collision(models.hybrid, 2)[0] - collision(models.frictionless, 2)[0]
    order = "earlier" if shift < 0.0 else "later"
    text = f"second touch {number(1e3 * abs(shift), 3)} ms {order} with friction"
    return verdict(abs(shift) >= 1e-3), text


# --- energies (Figs. 4 to 7)


@claim("Fig. 4", "During the initial collision-free stage the total mechanical energy remains constant.")
def energy_constant_before(models: Models) -> Finding:
    """largest relative change up to the first touch; reproduced: ≤ 10⁻⁶; partly: ≤ 10⁻³"""
    energy = models.before("energy")
    drift = float(np.max(np.abs(energy / energy[0] - 1.0)))
    return graded(drift, 1e-6, 1e-3), f"{number(float(energy[0]))} J, relative drift {number(drift, 2)}"


@claim("Fig. 4", "The collision can cause considerable loss of energy.")
def considerable_loss(models: Models) -> Finding:
    """reproduced: the first macro-collision takes at least 10 % of the total mechanical energy"""
    time = in_flight(models, 1)
    if time is None:
        raise MissingError("no flight after the first collision")
    initial = float(models.hybrid["energy"].values[0])
    loss = initial - float(models.hybrid.at(time)["energy"])
    text = f"{number(loss, 4)} J, {number(100.0 * loss / initial, 3)} % of the total"
    return verdict(loss / initial >= 0.1), text


def ordering(models: Models, holds: Callable[[float, float, float], bool]) -> Finding:
    """Judge a relation of the total energies in flight after the first two collisions, and at the end."""
    held, parts = [], []
    times = {f"after collision {k}": in_flight(models, k) for k in (1, 2)}
    for name, time in {**times, "end": models.end}.items():
        if time is None:
            continue
        energies = [float(run.at(time)["energy"]) for run in models]
        held.append(holds(*energies))
        row = " / ".join(number(value, 5) for value in energies)
        parts.append(f"{name} {row} J {'✓' if held[-1] else '✗'}")
    return verdict(all(held), any(held)), "; ".join(parts)


@claim("Fig. 4", "The energy loss calculated using the hybrid model is the largest.")
def hybrid_loses_most(models: Models) -> Finding:
    """total energy of hybrid / frictionless / modified Coulomb in flight after collisions 1 and 2 and at the end;
    reproduced: the hybrid model's is the smallest each time; partly: at least once"""
    return ordering(models, lambda hybrid, frictionless, modified: hybrid < min(frictionless, modified))


@claim("Fig. 4", "The energy loss calculated using the nontangential friction model is the smallest.")
def frictionless_loses_least(models: Models) -> Finding:
    """as above; reproduced: the frictionless model's energy is the largest each time; partly: at least once"""
    return ordering(models, lambda hybrid, frictionless, modified: frictionless > max(hybrid, modified))


@claim("Fig. 4", "Tangential friction can cause some energy loss to the system.")
def friction_dissipates(models: Models) -> Finding:
    """reproduced: the work taken by friction in the hybrid model is positive"""
    energy = models.hybrid.balance
    work, whole = energy["lost_friction"], energy["initial"] - energy["final"]
    text = f"{number(1e3 * work, 4)} mJ, {number(100.0 * work / whole, 3)} % of what is lost in the run"
    return verdict(work > 0.0), text


@claim(
    "Figs. 5–7",
    "During the initial stage kinetic and gravitational energy convert mutually; elastic energy is tiny.",
)
def exchange_before(models: Models) -> Finding:
    """largest elastic energy over the change of gravitational energy; reproduced: ≤ 10⁻³; partly: ≤ 10⁻²"""
    exchanged = float(np.ptp(models.before("energy_gravity")))
    elastic = float(np.max(models.before("energy_elastic")))
    text = f"{number(exchanged, 4)} J exchanged, elastic at most {number(elastic, 2)} J"
    return graded(elastic / exchanged, 1e-3, 1e-2), text


@claim("Figs. 5–7", "After the collision the elastic potential energy is no longer zero.")
def elastic_after(models: Models) -> Finding:
    """reproduced: its largest value in the first macro-collision is at least 100 times that before"""
    before = float(np.max(models.before("energy_elastic")))
    after = float(np.max(within(models.hybrid, "energy_elastic", *collision(models.hybrid, 1))))
    text = f"largest {number(before, 2)} J before, {number(after, 4)} J in the first collision"
    return verdict(after >= 100.0 * before), text


@claim(
    "Figs. 5–7",
    "After the first macro-collision the kinetic, gravitational and elastic energies of the hybrid model "
    "are all smaller than those of the other two.",
)
def all_parts_smaller(models: Models) -> Finding:
    """from the end of the first macro-collision to the end of the run; reproduced: each is the smallest for at
    least 95 % of the time; partly: the mean over time of each is the smallest"""
    shares, smallest, texts = [], [], []
    for part in ("kinetic", "gravity", "elastic"):
        energies = sampled(models, f"energy_{part}", models.after_first, models.end)
        means = energies.mean(axis=1).tolist()
        shares.append(float(np.mean(energies[0] < energies[1:].min(axis=0))))
        smallest.append(means[0] < min(means[1:]))
        mean = "smallest" if smallest[-1] else "not"
        texts.append(f"{part} {number(100.0 * shares[-1], 3)} % of the time, mean {mean}")
    return verdict(min(shares) >= 0.95, all(smallest)), "; ".join(texts)


# --- motion of the impact point, slip and stick (Figs. 8 to 16)


def largest_difference(models: Models, names: tuple[str, ...], end: float) -> float:
    """Return the largest difference of any two runs up to `end`, relative to each variable's largest value."""
    courses = [sampled(models, name, 0.0, end) for name in names]
    return max(float(np.max(np.ptp(v, axis=0))) / (float(np.max(np.abs(v))) or 1.0) for v in courses)


@claim("Figs. 8–13", "The curves obtained using the three models are all the same before collision.")
def same_before(models: Models) -> Finding:
    """largest difference relative to each curve's largest value; reproduced: ≤ 10⁻⁹; partly: ≤ 10⁻⁶"""
    worst = largest_difference(models, (*POINT, "theta", "theta_dot", "slip"), models.before_contact)
    return graded(worst, 1e-9, 1e-6), f"largest relative difference {number(worst, 2)}"


@claim("Figs. 10–13", "After the impact the curves no longer coincide well, owing to friction.")
def different_after(models: Models) -> Finding:
    """reproduced: the largest relative difference reaches 1 %"""
    before, after = (largest_difference(models, POINT, end) for end in (models.before_contact, models.end))
    text = f"largest relative difference {number(before, 2)} before, {number(after, 2)} after"
    return verdict(after >= 0.01 and after > before), text


@claim("Figs. 10–13", "The varying tendencies of the curves are generally similar.")
def similar_after(models: Models) -> Finding:
    """smallest correlation coefficient with the hybrid model after the first macro-collision, inertial
    displacements and velocities; reproduced: ≥ 0.9; partly: ≥ 0.5"""
    courses = (sampled(models, name, models.after_first, models.end) for name in POINT)
    smallest = [float(np.asarray(np.corrcoef(course))[0].min()) for course in courses]
    pairs = zip(("x", "x'", "y", "y'"), smallest, strict=True)
    text = ", ".join(f"{name} {number(value, 3)}" for name, value in pairs)
    return graded(-min(smallest), -0.9, -0.5), text


@claim(
    "Fig. 14",
    "The tangential displacement first increases to its maximum and then decreases during the initial "
    "collision-free stage.",
)
def maximum_before(models: Models) -> Finding:
    """reproduced: it rises and falls by more than 1 mm before the first touch"""
    slip, times = (models.before(name) for name in ("slip", "time"))
    first, most, last, when = map(float, (slip[0], slip.max(), slip[-1], times[slip.argmax()]))
    text = f"from {number(first, 4)} up to {number(most, 4)} m at {when:.4f} s, down to {number(last, 4)} m"
    return verdict(min(most - first, most - last) > 1e-3), text


@claim("Fig. 14", "After collision the change in displacement becomes smaller with the number of collisions.")
def changes_shrink(models: Models) -> Finding:
    """largest minus smallest tangential position in each flight; reproduced: it falls from flight to flight;
    partly: it is largest before the first collision"""
    run, found = models.hybrid, collisions(models.hybrid)
    flights = zip([0.0, *(end for _, end in found)], [*(start for start, _ in found), run.end_time], strict=True)
    # the end of the run may cut the last flight, or leave none
    ranges = [float(np.ptp(within(run, "slip", start, end))) for start, end in flights if end > start]
    if len(ranges) < 3:
        raise MissingError("fewer than three flights")
    falls = all(before > after for before, after in pairwise(ranges))
    text = f"change per flight {', '.join(number(1e3 * value, 3) for value in ranges)} mm"
    return verdict(falls, ranges[0] > max(ranges[1:])), text


def share_of_stick(run: History, among: list[Span]) -> tuple[float, str]:
    """Return the part of the time in contact that some macro-collisions stick, and that in words."""
    contact = sum(stay.duration for during in among for stay in stays(run, during))
    found = [stay for during in among for stay in sticks(run, during)]
    if not found:
        return 0.0, "no stick"
    total, fastest = sum(stay.duration for stay in found), max(abs(stay.slip_rate) for stay in found)
    share = total / contact if contact > 0.0 else 0.0
    part = f"{number(1e6 * total, 3)} µs in all, {number(100.0 * share, 3)} % of the contact"
    speed = f"slip velocity as they begin up to {number(1e3 * fastest, 3)} mm/s"
    return share, f"{len(found)} stays judged as stick, {part}; {speed}"


@claim("Figs. 14, 15", "Only slip occurs during the first macro-collision; the impact point keeps sliding.")
def slip_only_first(models: Models) -> Finding:
    """time in the state stick over time in contact; reproduced: 0; partly: ≤ 1 %"""
    share, text = share_of_stick(models.hybrid, [collision(models.hybrid, 1)])
    return graded(share, 0.0, 0.01), text


@claim("Fig. 15", "The direction of slip changes at t ≈ 0.325 s.")
def direction_changes(models: Models) -> Finding:
    """the reversal in contact nearest to 0.325 s; reproduced: within 0.5 ms; partly: within 3 ms"""
    times = reversals(models.hybrid, collision(models.hybrid, 1))
    if not times:
        raise MissingError("no reversal in contact")
    off = min(abs(time - REVERSAL) for time in times)
    return graded(off, 5e-4, 3e-3), f"reversals at {', '.join(f'{time:.4f} s' for time in times)}"


@claim("Fig. 14", "Stick and slip both occur during subsequent collisions.")
def sticks_later(models: Models) -> Finding:
    """time in the state stick over time in contact after the first macro-collision; reproduced: at least 1 %;
    partly: more than 0"""
    collision(models.hybrid, 2)  # there are later ones
    share, text = share_of_stick(models.hybrid, collisions(models.hybrid)[1:])
    return verdict(0.01 <= share < 1.0, share > 0.0), text


@claim(
    "Fig. 16", "The impact point remains in the slip state during the initial stage of the second macro-collision."
)
def slips_at_first(models: Models) -> Finding:
    """reproduced: the first state of contact in it is slip"""
    start, _ = second = collision(models.hybrid, 2)
    closed = stays(models.hybrid, second)
    if not closed:
        return NOT, f"from {start:.4f} s: rebounds only"
    state = closed[0].state
    return verdict(state == State.SLIP), f"from {start:.4f} s, first state {state.name.lower()}"


@claim("Fig. 16", "The second macro-collision is under way at t ≈ 0.699 s.")
def second_collision(models: Models) -> Finding:
    """reproduced: 0.699 s lies in the hybrid model's second macro-collision; partly: at most 5 ms away"""
    start, end = collision(models.hybrid, 2)
    off = max(start - STICK, STICK - end, 0.0)
    return graded(off, 0.0, 5e-3), f"{start:.4f} s to {end:.4f} s, {number(1e3 * off, 3)} ms away"


@claim("Fig. 16", "It changes to the stick state at t ≈ 0.699 s.", id="stick-at-0.699")
def stick_at_0_699(models: Models) -> Finding:
    """the longest stay in the state stick of the second macro-collision, if it lasts 0.1 ms; reproduced: it begins
    within 2 ms of 0.699 s; partly: within 5 ms"""
    start, duration = longest(sticks(models.hybrid, collision(models.hybrid, 2)))
    off = abs(start - STICK) if duration >= 1e-4 else NAN
    text = f"longest stay judged as stick from {start:.4f} s, {number(1e6 * duration, 3)} µs"
    return graded(off, 2e-3, 5e-3), text if duration else "no stick"


@claim("Fig. 16", "It remains viscous (sticking) until the second macro-collision ends.")
def stick_to_the_end(models: Models) -> Finding:
    """reproduced: the last release of the second macro-collision is out of the state stick"""
    _, end = second = collision(models.hybrid, 2)
    left = end - max((stay.end for stay in sticks(models.hybrid, second)), default=NAN)
    text = "no stick" if np.isnan(left) else f"last stick ends {number(1e3 * left, 3)} ms before the last release"
    return verdict(left < 1e-6), text


@claim("Fig. 2", "The modified Coulomb model cannot reflect the static stage of friction.", case="sticking")
def modified_cannot_stick(models: Models) -> Finding:
    """scenario sticking, second half of the hybrid model's longest stick: the modified Coulomb model's tip moves
    at least 1,000 times as far as the hybrid model's, which moves at most 10⁻⁸ m (reproduced) or 10⁻⁴ m
    (partly)"""
    begin, duration = longest(sticks(models.hybrid))
    if not duration:
        raise MissingError("the hybrid model does not stick here")
    # the second half of it: what slipped before the stick has come to rest in both models
    start, end = begin + 0.5 * duration, begin + duration
    held, crept = (float(np.ptp(within(run, "slip", start, end))) for run in (models.hybrid, models.modified))
    apart = crept >= 1e3 * held
    moves = f"hybrid moves {number(held, 2)} m, modified Coulomb {number(crept, 2)} m"
    return verdict(apart and held <= 1e-8, apart and held <= 1e-4), f"{start:.4f} s to {end:.4f} s: {moves}"


@claim("Fig. 2", "Stick and slip can interchange when the hybrid model is used.", case="rough")
def states_interchange(models: Models) -> Finding:
    """the paper's slope with μ = 12 (three mean-axis modes); reproduced: slip goes over into stick and stick into
    slip, with at least 1 ms of stick"""
    pairs = list(pairwise(event.state for event in models.hybrid.events))
    held, freed = pairs.count((State.SLIP, State.STICK)), pairs.count((State.STICK, State.SLIP))
    total = sum(stay.duration for stay in sticks(models.hybrid))
    text = f"{held} times slip to stick, {freed} times stick to slip, {number(1e3 * total, 3)} ms of stick"
    return verdict(held > 0 and freed > 0 and total >= 1e-3), text

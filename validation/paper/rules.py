"""The rules of the claims of `claims.toml`: a function for each, named as the claim is, that judges it.

It takes the runs of the three friction models, and returns a verdict with what it found in words.  `MissingError`
says that they lack what the claim is about.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations, pairwise

import numpy as np

from oblique_impact.contact.state import State
from oblique_impact.validation.paper.measures import (
    NAN,
    REVERSAL,
    STICK,
    MissingError,
    Models,
    collision,
    collisions,
    force_difference,
    in_flight,
    longest,
    reversals,
    sampled,
    share_of_stick,
    stays,
    sticks,
    within,
)
from oblique_impact.validation.report import number

REPRODUCED, PARTLY, NOT = VERDICTS = ("reproduced", "partly", "not reproduced")
POINT = ("tip_x", "tip_vx", "tip_y", "tip_vy")
#: a verdict, and the numbers behind it in words
Finding = tuple[str, str]


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


def first_collision(models: Models) -> Finding:
    start, end = collision(models.hybrid, 1)
    middle, contained = 0.5 * (start + end), start <= REVERSAL <= end
    text = f"{start:.4f} s to {end:.4f} s, middle {middle:.4f} s"
    return verdict(contained and abs(middle - REVERSAL) <= 2e-3, contained), text


def friction_coincides(models: Models) -> Finding:
    first = differences(models, "lambda_tau")[0]
    return graded(first, 0.1, 0.3), f"difference {number(first, 3)}"


def friction_slight_difference(models: Models) -> Finding:
    first = differences(models, "lambda_tau")[0]
    return verdict(first > 1e-6), f"difference {number(first, 3)}"


def friction_drifts_apart(models: Models) -> Finding:
    found = differences(models, "lambda_tau")
    return growth(found), f"differences in collisions {in_words(found)}"


def normal_coincides(models: Models) -> Finding:
    first = differences(models, "lambda_n")[0]
    return graded(first, 0.1, 0.3), f"largest difference {number(first, 3)}"


def normal_separates(models: Models) -> Finding:
    first, *later = found = differences(models, "lambda_n")
    holds = [value >= 0.3 and value > first for value in later if not np.isnan(value)]
    return verdict(bool(holds) and all(holds), any(holds)), f"differences in collisions {in_words(found)}"


def impact_times_spread(models: Models) -> Finding:
    starts = [([start for start, _ in collisions(run)] + 3 * [NAN])[:3] for run in models]
    found = np.ptp(starts, axis=0)
    return growth(found.tolist()), f"spread of the first touches {in_words((1e3 * found).tolist())} ms"


def no_motion_across(models: Models) -> Finding:
    closed = models.hybrid["state"].values != State.FREE
    if not closed.any():
        raise MissingError("no contact")
    gap, speed = (float(np.max(np.abs(models.hybrid[name].values[closed]))) for name in ("gap", "gap_rate"))
    return graded(gap, 1e-9, 1e-5), f"largest |Z_n| {number(1e3 * gap, 3)} mm, |Z_n'| {number(speed, 3)} m/s"


def friction_matters(models: Models) -> Finding:
    shift = collision(models.hybrid, 2)[0] - collision(models.frictionless, 2)[0]
    order = "earlier" if shift < 0.0 else "later"
    text = f"second touch {number(1e3 * abs(shift), 3)} ms {order} with friction"
    return verdict(abs(shift) >= 1e-3), text


# --- energies (Figs. 4 to 7)


def energy_constant_before(models: Models) -> Finding:
    energy = within(models.hybrid, "energy", 0.0, models.before_contact)
    drift = float(np.max(np.abs(energy / energy[0] - 1.0)))
    return graded(drift, 1e-6, 1e-3), f"{number(float(energy[0]))} J, relative drift {number(drift, 2)}"


def considerable_loss(models: Models) -> Finding:
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


def hybrid_loses_most(models: Models) -> Finding:
    return ordering(models, lambda hybrid, frictionless, modified: hybrid < min(frictionless, modified))


def frictionless_loses_least(models: Models) -> Finding:
    return ordering(models, lambda hybrid, frictionless, modified: frictionless > max(hybrid, modified))


def friction_dissipates(models: Models) -> Finding:
    energy = models.hybrid.balance
    work, whole = energy["lost_friction"], energy["initial"] - energy["final"]
    text = f"{number(1e3 * work, 4)} mJ, {number(100.0 * work / whole, 3)} % of what is lost in the run"
    return verdict(work > 0.0), text


def exchange_before(models: Models) -> Finding:
    exchanged = float(np.ptp(within(models.hybrid, "energy_gravity", 0.0, models.before_contact)))
    elastic = float(np.max(within(models.hybrid, "energy_elastic", 0.0, models.before_contact)))
    text = f"{number(exchanged, 4)} J exchanged, elastic at most {number(elastic, 2)} J"
    return graded(elastic / exchanged, 1e-3, 1e-2), text


def elastic_after(models: Models) -> Finding:
    before = float(np.max(within(models.hybrid, "energy_elastic", 0.0, models.before_contact)))
    after = float(np.max(within(models.hybrid, "energy_elastic", *collision(models.hybrid, 1))))
    text = f"largest {number(before, 2)} J before, {number(after, 4)} J in the first collision"
    return verdict(after >= 100.0 * before), text


def all_parts_smaller(models: Models) -> Finding:
    start = max(collision(run, 1)[1] for run in models)
    shares, smallest, texts = [], [], []
    for part in ("kinetic", "gravity", "elastic"):
        energies = sampled(models, f"energy_{part}", start, models.end)
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


def same_before(models: Models) -> Finding:
    worst = largest_difference(models, (*POINT, "theta", "theta_dot", "slip"), models.before_contact)
    return graded(worst, 1e-9, 1e-6), f"largest relative difference {number(worst, 2)}"


def different_after(models: Models) -> Finding:
    before, after = (largest_difference(models, POINT, end) for end in (models.before_contact, models.end))
    text = f"largest relative difference {number(before, 2)} before, {number(after, 2)} after"
    return verdict(after >= 0.01 and after > before), text


def similar_after(models: Models) -> Finding:
    start = max(collision(run, 1)[1] for run in models)
    courses = (sampled(models, name, start, models.end) for name in POINT)
    smallest = [float(np.asarray(np.corrcoef(course))[0].min()) for course in courses]
    pairs = zip(("x", "x'", "y", "y'"), smallest, strict=True)
    text = ", ".join(f"{name} {number(value, 3)}" for name, value in pairs)
    return graded(-min(smallest), -0.9, -0.5), text


def maximum_before(models: Models) -> Finding:
    slip, times = (within(models.hybrid, name, 0.0, models.before_contact) for name in ("slip", "time"))
    first, most, last, when = map(float, (slip[0], slip.max(), slip[-1], times[slip.argmax()]))
    text = f"from {number(first, 4)} up to {number(most, 4)} m at {when:.4f} s, down to {number(last, 4)} m"
    return verdict(min(most - first, most - last) > 1e-3), text


def changes_shrink(models: Models) -> Finding:
    run, found = models.hybrid, collisions(models.hybrid)
    flights = zip([0.0, *(end for _, end in found)], [*(start for start, _ in found), run.end_time], strict=True)
    # the end of the run may cut the last flight, or leave none
    ranges = [float(np.ptp(within(run, "slip", start, end))) for start, end in flights if end > start]
    if len(ranges) < 3:
        raise MissingError("fewer than three flights")
    falls = all(before > after for before, after in pairwise(ranges))
    text = f"change per flight {', '.join(number(1e3 * value, 3) for value in ranges)} mm"
    return verdict(falls, ranges[0] > max(ranges[1:])), text


def slip_only_first(models: Models) -> Finding:
    share, text = share_of_stick(models.hybrid, [collision(models.hybrid, 1)])
    return graded(share, 0.0, 0.01), text


def direction_changes(models: Models) -> Finding:
    times = reversals(models.hybrid, collision(models.hybrid, 1))
    if not times:
        raise MissingError("no reversal in contact")
    off = min(abs(time - REVERSAL) for time in times)
    return graded(off, 5e-4, 3e-3), f"reversals at {', '.join(f'{time:.4f} s' for time in times)}"


def sticks_later(models: Models) -> Finding:
    collision(models.hybrid, 2)  # there are later ones
    share, text = share_of_stick(models.hybrid, collisions(models.hybrid)[1:])
    return verdict(0.01 <= share < 1.0, share > 0.0), text


def slips_at_first(models: Models) -> Finding:
    start, _ = second = collision(models.hybrid, 2)
    closed = stays(models.hybrid, second)
    if not closed:
        return NOT, f"from {start:.4f} s: rebounds only"
    state = closed[0].state
    return verdict(state == State.SLIP), f"from {start:.4f} s, first state {state.name.lower()}"


def second_collision(models: Models) -> Finding:
    start, end = collision(models.hybrid, 2)
    off = max(start - STICK, STICK - end, 0.0)
    return graded(off, 0.0, 5e-3), f"{start:.4f} s to {end:.4f} s, {number(1e3 * off, 3)} ms away"


def stick_at_0_699(models: Models) -> Finding:
    start, duration = longest(sticks(models.hybrid, collision(models.hybrid, 2)))
    off = abs(start - STICK) if duration >= 1e-4 else NAN
    text = f"longest stay judged as stick from {start:.4f} s, {number(1e6 * duration, 3)} µs"
    return graded(off, 2e-3, 5e-3), text if duration else "no stick"


def stick_to_the_end(models: Models) -> Finding:
    _, end = second = collision(models.hybrid, 2)
    left = end - max((stay.end for stay in sticks(models.hybrid, second)), default=NAN)
    text = "no stick" if np.isnan(left) else f"last stick ends {number(1e3 * left, 3)} ms before the last release"
    return verdict(left < 1e-6), text


def modified_cannot_stick(models: Models) -> Finding:
    begin, duration = longest(sticks(models.hybrid))
    if not duration:
        raise MissingError("the hybrid model does not stick here")
    # the second half of it: what slipped before the stick has come to rest in both models
    start, end = begin + 0.5 * duration, begin + duration
    held, crept = (float(np.ptp(within(run, "slip", start, end))) for run in (models.hybrid, models.modified))
    apart = crept >= 1e3 * held
    moves = f"hybrid moves {number(held, 2)} m, modified Coulomb {number(crept, 2)} m"
    return verdict(apart and held <= 1e-8, apart and held <= 1e-4), f"{start:.4f} s to {end:.4f} s: {moves}"


def states_interchange(models: Models) -> Finding:
    pairs = list(pairwise(event.state for event in models.hybrid.events))
    held, freed = pairs.count((State.SLIP, State.STICK)), pairs.count((State.STICK, State.SLIP))
    total = sum(stay.duration for stay in sticks(models.hybrid))
    text = f"{held} times slip to stick, {freed} times stick to slip, {number(1e3 * total, 3)} ms of stick"
    return verdict(held > 0 and freed > 0 and total >= 1e-3), text

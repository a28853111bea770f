"""Claims about the motion of the impact point, slip and stick (paper, Figs. 8 to 16)."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from oblique_impact.contact.state import State
from oblique_impact.history.summary import MacroCollision
from oblique_impact.validation.report.document import number
from oblique_impact.validation.reproduction.claims import Claims, Finding, graded, milliseconds, moment, verdict
from oblique_impact.validation.reproduction.measures import (
    Trio,
    flight_ranges,
    largest_difference,
    longest,
    sampled,
    stick_share,
)
from oblique_impact.validation.reproduction.runs import MissingError, Run

CLAIMS = Claims()

REVERSAL, STICK = 0.325, 0.699  # s, in the paper
_POINT = ("tip_x", "tip_vx", "tip_y", "tip_vy")


@CLAIMS.add(
    "same-before",
    "Sec. 7, Figs. 8–13",
    "The curves obtained using the three models are all the same before collision.",
    "largest difference relative to each curve's largest value; reproduced: ≤ 10⁻⁹; partly: ≤ 10⁻⁶",
)
def same_before(trio: Trio) -> Finding:
    worst = largest_difference(trio, (*_POINT, "theta", "theta_dot", "slip"), trio.before_contact)
    text = f"largest relative difference {number(worst, 2)}"
    return Finding(graded(worst, 1e-9, 1e-6), {"difference": worst}, text)


@CLAIMS.add(
    "different-after",
    "Sec. 7, Figs. 10–13",
    "After the impact the curves no longer coincide well, owing to friction.",
    "reproduced: the largest relative difference reaches 1 %",
)
def different_after(trio: Trio) -> Finding:
    before, after = (largest_difference(trio, _POINT, end) for end in (trio.before_contact, trio.end))
    text = f"largest relative difference {number(before, 2)} before, {number(after, 2)} after"
    return Finding(verdict(after >= 0.01 and after > before), {"before": before, "after": after}, text)


@CLAIMS.add(
    "similar-after",
    "Sec. 7, Figs. 10–13",
    "The varying tendencies of the curves are generally similar.",
    "smallest correlation coefficient with the hybrid model after the first macro-collision, inertial "
    "displacements and velocities; reproduced: ≥ 0.9; partly: ≥ 0.5",
)
def similar_after(trio: Trio) -> Finding:
    start = max(run.macros[0].end for run in trio)
    found = {
        name: float(np.min(np.asarray(np.corrcoef(sampled(trio, name, start, trio.end)))[0])) for name in _POINT
    }
    worst = min(found.values())
    text = ", ".join(
        f"{name} {number(v, 3)}" for name, v in zip(("x", "x'", "y", "y'"), found.values(), strict=True)
    )
    return Finding(graded(-worst, -0.9, -0.5), {f"correlation {k}": v for k, v in found.items()}, text)


@CLAIMS.add(
    "maximum-before",
    "Sec. 7, Fig. 14",
    "The tangential displacement first increases to its maximum and then decreases during the initial "
    "collision-free stage.",
    "reproduced: it rises and falls by more than 1 mm before the first touch",
)
def maximum_before(trio: Trio) -> Finding:
    run = trio.hybrid
    inside = run["time"] <= trio.before_contact
    slip, times = run["slip"][inside], run["time"][inside]
    top = int(np.argmax(slip))
    rise, fall = float(slip[top] - slip[0]), float(slip[top] - slip[-1])
    numbers = {"time": float(times[top]), "maximum": float(slip[top]), "rise": rise, "fall": fall}
    text = (
        f"from {number(float(slip[0]), 4)} up to {number(float(slip[top]), 4)} m at {moment(float(times[top]))}, "
        f"down to {number(float(slip[-1]), 4)} m"
    )
    return Finding(verdict(rise > 1e-3 and fall > 1e-3), numbers, text)


@CLAIMS.add(
    "changes-shrink",
    "Sec. 7, Fig. 14",
    "After collision the change in displacement becomes smaller with the number of collisions.",
    "largest minus smallest tangential position in each flight; reproduced: it falls from flight to flight; "
    "partly: it is largest before the first collision",
)
def changes_shrink(trio: Trio) -> Finding:
    ranges = flight_ranges(trio.hybrid, "slip")
    numbers = {f"flight_{k}": value for k, value in enumerate(ranges)}
    text = "change per flight " + ", ".join(number(1e3 * value, 3) for value in ranges) + " mm"
    if len(ranges) < 3:
        raise MissingError("fewer than three flights")
    falling = all(a > b for a, b in pairwise(ranges))
    return Finding(verdict(falling, ranges[0] > max(ranges[1:])), numbers, text)


def _stick_text(run: Run, macros: list[MacroCollision]) -> tuple[dict[str, float], str]:
    sticks = [stick for macro in macros for stick in run.sticks_in(macro)]
    total = sum(stick.duration for stick in sticks)
    share = stick_share(run, macros)
    numbers = {"sticks": float(len(sticks)), "duration": total, "share": share}
    if not sticks:
        return numbers, "no stick"
    fastest = max(abs(stick.slip_rate) for stick in sticks)
    numbers["fastest"] = fastest
    part = f"{number(1e6 * total, 3)} µs in all, {number(100.0 * share, 3)} % of the contact"
    speed = f"slip velocity as they begin up to {number(1e3 * fastest, 3)} mm/s"
    text = f"{len(sticks)} stays judged as stick, {part}; {speed}"
    return numbers, text


@CLAIMS.add(
    "slip-only-first",
    "Sec. 7, Figs. 14, 15",
    "Only slip occurs during the first macro-collision; the impact point keeps sliding.",
    "time in the state stick over time in contact; reproduced: 0; partly: ≤ 1 %",
)
def slip_only_first(trio: Trio) -> Finding:
    numbers, text = _stick_text(trio.hybrid, [trio.hybrid.macro(1)])
    return Finding(graded(numbers["share"], 0.0, 0.01), numbers, text)


@CLAIMS.add(
    "direction-changes",
    "Sec. 7, Fig. 15",
    "The direction of slip changes at t ≈ 0.325 s.",
    "the reversal in contact nearest to 0.325 s; reproduced: within 0.5 ms; partly: within 3 ms",
)
def direction_changes(trio: Trio) -> Finding:
    times = trio.hybrid.reversals_in(trio.hybrid.macro(1))
    if not times:
        raise MissingError("no reversal in contact")
    nearest = min(times, key=lambda time: abs(time - REVERSAL))
    text = "reversals at " + ", ".join(moment(time) for time in times)
    numbers = {"nearest": nearest, "reversals": float(len(times))}
    return Finding(graded(abs(nearest - REVERSAL), 5e-4, 3e-3), numbers, text)


@CLAIMS.add(
    "sticks-later",
    "Sec. 7, Fig. 14",
    "Stick and slip both occur during subsequent collisions.",
    "time in the state stick over time in contact after the first macro-collision; reproduced: at least 1 %; "
    "partly: more than 0",
)
def sticks_later(trio: Trio) -> Finding:
    trio.hybrid.macro(2)
    numbers, text = _stick_text(trio.hybrid, trio.hybrid.macros[1:])
    return Finding(verdict(0.01 <= numbers["share"] < 1.0, numbers["share"] > 0.0), numbers, text)


@CLAIMS.add(
    "slips-at-first",
    "Sec. 7, Fig. 16",
    "The impact point remains in the slip state during the initial stage of the second macro-collision.",
    "reproduced: the first state of contact in it is slip",
)
def slips_at_first(trio: Trio) -> Finding:
    macro = trio.hybrid.macro(2)
    closed = [stay.state for stay in trio.hybrid.stays_in(macro) if stay.state != State.FREE]
    if not closed:
        return Finding(verdict(False), {"start": macro.start}, f"from {moment(macro.start)}: rebounds only")
    text = f"from {moment(macro.start)}, first state {closed[0].name.lower()}"
    return Finding(verdict(closed[0] == State.SLIP), {"start": macro.start, "state": float(closed[0])}, text)


@CLAIMS.add(
    "second-collision",
    "Sec. 7, Fig. 16",
    "The second macro-collision is under way at t ≈ 0.699 s.",
    "reproduced: 0.699 s lies in the hybrid model's second macro-collision; partly: at most 5 ms away",
)
def second_contains(trio: Trio) -> Finding:
    macro = trio.hybrid.macro(2)
    off = max(macro.start - STICK, STICK - macro.end, 0.0)
    text = f"{moment(macro.start)} to {moment(macro.end)}, {milliseconds(off)} away"
    return Finding(graded(off, 0.0, 5e-3), {"start": macro.start, "end": macro.end, "off": off}, text)


@CLAIMS.add(
    "stick-at-0.699",
    "Sec. 7, Fig. 16",
    "It changes to the stick state at t ≈ 0.699 s.",
    "the longest stay in the state stick of the second macro-collision, if it lasts 0.1 ms; reproduced: it "
    "begins within 2 ms of 0.699 s; partly: within 5 ms",
)
def sticks_at(trio: Trio) -> Finding:
    start, duration = longest(trio.hybrid.sticks_in(trio.hybrid.macro(2)))
    text = f"longest stay judged as stick from {moment(start)}, {number(1e6 * duration, 3)} µs"
    off = abs(start - STICK) if duration >= 1e-4 else float("nan")
    numbers = {"start": start, "duration": duration}
    return Finding(graded(off, 2e-3, 5e-3), numbers, text if duration else "no stick")


@CLAIMS.add(
    "stick-to-the-end",
    "Sec. 7, Fig. 16",
    "It remains viscous (sticking) until the second macro-collision ends.",
    "reproduced: the last release of the second macro-collision is out of the state stick",
)
def sticks_to_the_end(trio: Trio) -> Finding:
    macro = trio.hybrid.macro(2)
    sticks = trio.hybrid.sticks_in(macro)
    last = sticks[-1].end if sticks else float("nan")
    text = f"last stick ends {milliseconds(macro.end - last)} before the last release" if sticks else "no stick"
    return Finding(
        verdict(bool(sticks) and macro.end - last < 1e-6), {"end": macro.end, "last_stick_end": last}, text
    )


@CLAIMS.add(
    "modified-cannot-stick",
    "Sec. 7, Fig. 2",
    "The modified Coulomb model cannot reflect the static stage of friction.",
    "scenario sticking, second half of the hybrid model's longest stick: the modified Coulomb model's tip "
    "moves at least 1,000 times as far as the hybrid model's, which moves at most 10⁻⁸ m (reproduced) or "
    "10⁻⁴ m (partly)",
    case="sticking",
)
def cannot_stick(trio: Trio) -> Finding:
    begin, duration = longest(trio.hybrid.sticks)
    if not duration:
        raise MissingError("the hybrid model does not stick here")
    # the second half of it: what slipped before the stick has come to rest in both models
    start, end = begin + 0.5 * duration, begin + duration
    held, crept = (float(np.ptp(run["slip"][run.inside(start, end)])) for run in (trio.hybrid, trio.modified))
    moved = f"hybrid moves {number(held, 2)} m, modified Coulomb {number(crept, 2)} m"
    text = f"{moment(start)} to {moment(end)}: {moved}"
    apart = crept >= 1e3 * held
    return Finding(
        verdict(apart and held <= 1e-8, apart and held <= 1e-4), {"hybrid": held, "modified": crept}, text
    )


@CLAIMS.add(
    "states-interchange",
    "Sec. 7, Fig. 2",
    "Stick and slip can interchange when the hybrid model is used.",
    "the paper's slope with μ = 12 (three mean-axis modes); reproduced: slip goes over into stick and stick "
    "into slip, with at least 1 ms of stick",
    case="rough",
)
def states_interchange(trio: Trio) -> Finding:
    states = [event.state for event in trio.hybrid.history.events]
    held = sum(a == State.SLIP and b == State.STICK for a, b in pairwise(states))
    freed = sum(a == State.STICK and b == State.SLIP for a, b in pairwise(states))
    total = sum(stick.duration for stick in trio.hybrid.sticks)
    text = f"{held} times slip to stick, {freed} times stick to slip, {milliseconds(total)} of stick"
    numbers = {"to_stick": float(held), "to_slip": float(freed), "stick_time": total}
    return Finding(verdict(held > 0 and freed > 0 and total >= 1e-3), numbers, text)

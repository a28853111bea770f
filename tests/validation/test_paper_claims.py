"""The rules of the paper's claims: what they find in runs made by hand, on either side of their limits."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from oblique_impact import History, Scenario
from oblique_impact.contact.log import Event
from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.history.summary import MacroCollision
from oblique_impact.validation.paper import command
from oblique_impact.validation.paper.command import judge_claims
from oblique_impact.validation.paper.measures import MODELS, Models, in_flight
from oblique_impact.validation.paper.rules import CLAIMS, NOT, PARTLY, REPRODUCED

BY_ID = {claim.id: claim for claim in CLAIMS}
MACROS = ((0.3, 0.34), (0.68, 0.71))
THREE = (*MACROS, (0.9, 0.95))
POINT = ("tip_x", "tip_vx", "tip_y", "tip_vy")
PARTS = ("energy_kinetic", "energy_elastic", "energy_gravity")
NAMES = (
    *("gap", "slip", "gap_rate", "slip_rate", "lambda_n", "lambda_tau", "theta", "theta_dot", "state", "energy"),
    *(*POINT, *PARTS),
)


def event(time, kind, state, slip_rate=0.0):
    return Event(time, EventKind(kind), 0.0, 0.0, 0.0, slip_rate, 0.0, State[state])


def made(events=(), macros=MACROS, **courses):
    """A run of 1 s with given courses, or numbers, on a millisecond grid; what is not given is zero."""
    time = np.linspace(0.0, 1.0, 1001)
    data = {name: np.zeros_like(time) for name in NAMES}
    data |= {
        name: course(time) if callable(course) else np.full_like(time, course) for name, course in courses.items()
    }
    summary = {
        "outcome": "completed",
        "end_time": 1.0,
        "energy": {"initial": 3.0, "final": 1.0, "lost_friction": 0.1},
        "macro_collisions": [vars(MacroCollision(*macro, 2, 1.0, 0.1, 100.0)) for macro in macros],
    }
    samples = xr.Dataset({name: ("time", values) for name, values in data.items()}, {"time": time})
    return History(samples, list(events), summary, Scenario())


def hybrid(*events, macros=MACROS, **courses):
    """The hybrid model is as given, the others do nothing."""
    return Models(made(events, macros, **courses), made(), made())


def three(macros=MACROS, **courses):
    """Runs of the three models, each with its own course of some variables."""
    own = zip(*courses.values(), strict=True)
    return Models(*(made(macros=macros, **dict(zip(courses, values, strict=True))) for values in own))


def touching(*second):
    """Runs of the three models that differ in when they touch the slope for the second time."""
    return Models(*(made(macros=[MACROS[0], (start, 0.71)]) for start in second))


def touched(*starts):
    """Runs of the three models whose second and third macro-collisions begin at different times."""
    return Models(*(made(macros=[MACROS[0], (second, 0.71), (third, 0.95)]) for second, third in starts))


def slip_in_second(*more):
    """The hybrid model slips in the second macro-collision until something else happens at some times."""
    later = [event(time, kind, kind.upper()) for time, kind in more]
    return hybrid(event(0.68, "impact", "SLIP"), *later, event(0.71, "release", "FREE"))


def in_first(*more):
    return hybrid(event(0.3, "impact", "SLIP"), *more, event(0.34, "release", "FREE"))


def pulse(centre, height=1.0):
    return lambda t: np.where(np.abs(t - centre) < 0.005, height, 0.0)


def pulses(*heights):
    """A force in each of three macro-collisions."""
    return lambda t: sum(pulse(c, h)(t) for h, c in zip(heights, (0.31, 0.69, 0.92), strict=True))


def after(level, before=3.0, since=0.3):
    return lambda t: np.where(t < since, before, level)


def levels(*values):
    """3 J, and less after the first and the second collision and at the end."""
    return lambda t: np.select([t < 0.3, t < 0.68, t < 0.95], [3.0, *values[:2]], values[2])


def lagging(coefficient):
    """Three periods of a sine after the first collision, late by the phase of this cosine."""
    return lambda t: np.sin(6.0 * np.pi * (t - 0.34) / 0.66 - np.arccos(coefficient))


def correlated(coefficient):
    return three(**dict.fromkeys(POINT, (lagging(1.0), lagging(1.0), lagging(coefficient))))


def parts(course):
    return three(**dict.fromkeys(PARTS, (course, 2.0, 2.0)))


def holding(held, crept):
    """The hybrid model sticks from 0.2 to 0.6 s; how fast (m/s) the tips of two models move in its second half."""
    stuck = [event(0.2, "stick", "STICK"), event(0.6, "release", "FREE")]
    return Models(*(made(stuck, slip=lambda t, v=v: np.where(t < 0.39, t, v * t)) for v in (held, 1.0, crept)))


EARLY, LATE = pulse(0.31), pulse(0.33)
ENERGIES = three(energy=(levels(2.5, 1.0, 0.5), levels(2.75, 0.75, 0.875), levels(2.625, 1.5, 0.625)))
STUCK_FOR_300_US = in_first(
    *(event(0.31, "stick", "STICK", -0.02), event(0.3101, "slip", "SLIP")),
    *(event(0.32, "stick", "STICK", 0.01), event(0.3202, "slip", "SLIP")),
)
CHANGING = [event(0.2, "impact", "SLIP"), event(0.3, "stick", "STICK"), event(0.304, "slip", "SLIP")]

# claim, verdict, runs: on either side of what the rules say
RULES = [
    ("first-collision", REPRODUCED, hybrid(macros=[(0.31, 0.34)])),  # centred on 0.325 s
    ("first-collision", PARTLY, hybrid()),
    ("first-collision", NOT, hybrid(macros=[(0.4, 0.41)])),
    # a force that is larger by x differs by x/(2 + x)
    ("friction-coincides", REPRODUCED, three(lambda_tau=(EARLY, 0.0, pulse(0.31, 1.2)))),
    ("friction-coincides", PARTLY, three(lambda_tau=(EARLY, 0.0, pulse(0.31, 1.25)))),
    ("friction-coincides", NOT, three(lambda_tau=(EARLY, EARLY, LATE))),
    ("friction-slight-difference", REPRODUCED, three(lambda_tau=(EARLY, 0.0, pulse(0.31, 1.000003)))),
    ("friction-slight-difference", NOT, three(lambda_tau=(EARLY, LATE, EARLY))),
    ("friction-drifts-apart", REPRODUCED, three(THREE, lambda_tau=(pulses(1, 1, 1), 0.0, pulses(1, 3, 4)))),
    ("friction-drifts-apart", PARTLY, three(THREE, lambda_tau=(pulses(1, 1, 1), 0.0, pulses(1, 3, 2)))),
    ("friction-drifts-apart", NOT, three(THREE, lambda_tau=(pulses(1, 1, 1), 0.0, pulses(3, 2, 1)))),
    ("normal-coincides", PARTLY, three(lambda_n=(EARLY, EARLY, pulse(0.31, 1.25)))),
    ("normal-coincides", NOT, three(lambda_n=(EARLY, LATE, EARLY))),
    ("normal-separates", REPRODUCED, three(THREE, lambda_n=(pulses(1, 1, 1), pulses(1, 3, 2), pulses(1, 1, 1)))),
    ("normal-separates", PARTLY, three(THREE, lambda_n=(pulses(1, 1, 1), pulses(1, 3, 1.5), pulses(1, 1, 1)))),
    ("impact-times-spread", REPRODUCED, touched((0.68, 0.9), (0.69, 0.92), (0.685, 0.902))),
    ("impact-times-spread", PARTLY, touched((0.68, 0.9), (0.69, 0.905), (0.685, 0.902))),
    ("no-motion-across", REPRODUCED, hybrid(state=1.0, gap=0.9e-9)),
    ("no-motion-across", PARTLY, hybrid(state=1.0, gap=-1.1e-9)),
    ("no-motion-across", NOT, hybrid(state=1.0, gap=1.1e-5)),
    ("no-motion-across", NOT, hybrid()),  # no contact
    ("friction-matters", REPRODUCED, touching(0.6811, 0.68, 0.68)),
    ("friction-matters", NOT, touching(0.6809, 0.68, 0.60)),
    ("energy-constant-before", REPRODUCED, hybrid(energy=lambda t: np.where(t < 0.3, 3.0 + 9e-6 * t, 1.0))),
    ("energy-constant-before", PARTLY, hybrid(energy=lambda t: 3.0 + 1.2e-5 * t)),
    ("energy-constant-before", NOT, hybrid(energy=lambda t: 3.0 - t)),
    ("considerable-loss", REPRODUCED, hybrid(energy=after(2.69))),
    ("considerable-loss", NOT, hybrid(energy=after(2.71))),
    ("considerable-loss", NOT, hybrid(energy=after(1.0, since=0.7))),  # lost in the second one
    ("hybrid-loses-most", REPRODUCED, three(energy=(after(1.0), after(2.0), after(1.5)))),
    ("hybrid-loses-most", PARTLY, ENERGIES),
    ("hybrid-loses-most", NOT, three(energy=(after(1.6), after(2.0), after(1.5)))),
    ("frictionless-loses-least", REPRODUCED, three(energy=(after(1.0), after(2.0), after(1.5)))),
    ("frictionless-loses-least", PARTLY, ENERGIES),
    ("frictionless-loses-least", NOT, three(energy=(after(1.0), after(0.5), after(1.5)))),
    ("friction-dissipates", REPRODUCED, hybrid()),
    ("exchange-before", REPRODUCED, hybrid(energy_gravity=lambda t: t, energy_elastic=0.9e-3 * 0.299)),
    ("exchange-before", PARTLY, hybrid(energy_gravity=lambda t: -t, energy_elastic=1.1e-3 * 0.299)),
    ("exchange-before", NOT, hybrid(energy_gravity=lambda t: t, energy_elastic=1.1e-2 * 0.299)),
    ("elastic-after", REPRODUCED, hybrid(energy_elastic=after(101.0, 1.0))),
    ("elastic-after", NOT, hybrid(energy_elastic=after(99.0, 1.0))),
    ("all-parts-smaller", REPRODUCED, parts(after(1.0, since=0.34 + 0.04 * 0.66))),
    ("all-parts-smaller", PARTLY, parts(after(1.0, since=0.34 + 0.06 * 0.66))),
    ("all-parts-smaller", NOT, three(energy_kinetic=(after(3.0), after(2.0), after(2.0)))),
    ("same-before", REPRODUCED, three(theta=(1.0, 1.0, 1.0 + 0.9e-9))),
    ("same-before", PARTLY, three(theta=(1.0, 1.0, 1.0 + 1.1e-9))),
    ("same-before", NOT, three(slip=(1.0, 1.0, 1.01))),
    ("different-after", REPRODUCED, three(tip_x=(1.0, 1.0, after(1.011, 1.0)))),
    ("different-after", NOT, three(tip_x=(1.0, 1.0, after(1.009, 1.0)))),
    ("similar-after", REPRODUCED, correlated(0.91)),
    ("similar-after", PARTLY, correlated(0.89)),
    ("similar-after", NOT, correlated(0.49)),
    ("maximum-before", REPRODUCED, hybrid(slip=lambda t: -0.05 * (t - 0.15) ** 2)),  # 1.1 mm up and down
    ("maximum-before", NOT, hybrid(slip=lambda t: -0.04 * (t - 0.15) ** 2)),
    ("changes-shrink", REPRODUCED, hybrid(slip=lambda t: np.exp(-3.0 * t))),
    ("changes-shrink", PARTLY, hybrid(slip=lambda t: np.select([t < 0.3, t < 0.705], [2.0 * t, t], 1.2 * t))),
    ("slip-only-first", REPRODUCED, in_first()),
    ("slip-only-first", PARTLY, STUCK_FOR_300_US),
    ("slip-only-first", NOT, in_first(event(0.31, "stick", "STICK"))),
    ("direction-changes", REPRODUCED, in_first(event(0.3254, "reversal", "SLIP"))),
    ("direction-changes", PARTLY, in_first(event(0.3276, "reversal", "SLIP"), event(0.33, "reversal", "SLIP"))),
    ("direction-changes", NOT, in_first(event(0.3281, "reversal", "SLIP"))),
    ("direction-changes", NOT, in_first()),
    ("sticks-later", REPRODUCED, slip_in_second((0.7, "stick"), (0.7006, "slip"))),
    ("sticks-later", PARTLY, slip_in_second((0.7, "stick"), (0.70015, "slip"))),
    ("sticks-later", NOT, STUCK_FOR_300_US),
    ("slips-at-first", REPRODUCED, slip_in_second()),
    ("slips-at-first", NOT, hybrid(event(0.68, "impact", "STICK"))),
    ("slips-at-first", NOT, hybrid(event(0.68, "rebound", "FREE"))),
    ("second-collision", REPRODUCED, hybrid()),
    ("second-collision", PARTLY, touching(0.7039, 0.68, 0.68)),
    ("second-collision", PARTLY, hybrid(macros=[MACROS[0], (0.68, 0.6941)])),
    ("second-collision", NOT, touching(0.7041, 0.68, 0.68)),
    ("stick-at-0.699", REPRODUCED, slip_in_second((0.7009, "stick"))),
    ("stick-at-0.699", PARTLY, slip_in_second((0.7011, "stick"))),
    ("stick-at-0.699", NOT, slip_in_second((0.7041, "stick"))),
    ("stick-at-0.699", NOT, slip_in_second((0.699, "stick"), (0.69901, "slip"))),  # too short
    ("stick-to-the-end", REPRODUCED, slip_in_second((0.699, "stick"))),
    ("stick-to-the-end", NOT, slip_in_second((0.699, "stick"), (0.7, "slip"))),
    ("modified-cannot-stick", REPRODUCED, holding(1e-9, 0.5)),
    ("modified-cannot-stick", PARTLY, holding(1e-6, 0.5)),
    ("modified-cannot-stick", NOT, holding(1e-9, 0.5e-6)),
    ("states-interchange", REPRODUCED, hybrid(*CHANGING)),
    ("states-interchange", NOT, slip_in_second()),
]


@pytest.mark.parametrize(("claim", "verdict", "runs"), RULES, ids=[f"{rule[0]}: {rule[1]}" for rule in RULES])
def test_rules_can_hold_and_fail(claim, verdict, runs):
    assert BY_ID[claim].judge(runs)[0] == verdict


def test_every_claim_is_tested_and_says_its_place_and_rule():
    assert {rule[0] for rule in RULES} == BY_ID.keys()
    assert len(CLAIMS) == len(BY_ID) == 31
    assert all(claim.rule and claim.paper.endswith(".") and "Sec" in claim.place for claim in CLAIMS)


def test_verdicts_of_two_schemes_combine_and_those_of_all_combinations_are_counted(monkeypatch):
    """First touches 1.1 and 0.9 ms apart: with friction that matters in the fixed-step runs alone."""
    chosen = ("friction-matters", "first-collision", "states-interchange")
    monkeypatch.setattr(command, "CLAIMS", [BY_ID[name] for name in chosen])
    apart = {"fixed-step": touching(0.6811, 0.68, 0.68), "event": touching(0.6809, 0.68, 0.68)}
    runs = {}
    for scheme, models in apart.items():
        runs |= {f"paper/{scheme}/{name}": run for name, run in zip(MODELS, models, strict=True)}
        runs[f"rough/{scheme}/hybrid"] = hybrid(*CHANGING).hybrid
    combined = pd.DataFrame({"friction-matters": [REPRODUCED, NOT], "first-collision": 2 * [REPRODUCED]})
    found = judge_claims(runs, combined)
    assert found.loc["friction-matters", ["verdict_fixed_step", "verdict_event"]].tolist() == [REPRODUCED, NOT]
    counts = [f"combinations_{name}" for name in ("reproduced", "partly", "not_reproduced")]
    assert found.loc["friction-matters", ["verdict", *counts, "discriminates"]].tolist() == [PARTLY, 1, 0, 1, True]
    assert found.loc["first-collision", ["verdict", *counts, "discriminates"]].tolist() == [PARTLY, 2, 0, 0, False]
    # judged on a scenario that sticks
    assert found.loc["states-interchange", ["verdict", *counts, "discriminates"]].tolist() == [
        *(REPRODUCED, None, None, None, True),
    ]


def test_runs_are_compared_in_the_middle_of_the_flight_that_all_have():
    """The last of three leaves the slope at 0.36 s, the first touches it again at 0.66 s; the run ends at 1 s."""
    late, early = made(macros=[(0.3, 0.36), (0.68, 0.71)]), made(macros=[(0.3, 0.34), (0.66, 0.7)])
    models = Models(late, early, made())
    assert [in_flight(models, k) for k in (1, 2, 3)] == [pytest.approx(0.51), pytest.approx(0.855), None]
    assert in_flight(hybrid(macros=[(0.3, 0.69)]), 1) is None

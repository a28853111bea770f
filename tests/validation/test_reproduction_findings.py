"""What each claim's rule says of runs made by hand: the verdict, the numbers by their names, the text."""

from __future__ import annotations

import re

import numpy as np
import pytest

from oblique_impact.validation.reproduction.claims import NOT, PARTLY, REPRODUCED

from .test_reproduction import (
    CLAIMS,
    EARLY,
    LATE,
    MACROS,
    after,
    constant,
    event,
    hybrid,
    made,
    pulse,
    scaled,
    slip_in_second,
    three,
    touching,
    trio,
)

THREE_MACROS = [*MACROS, (0.9, 0.95)]


def pulses(*heights):
    """A force in each of three macro-collisions."""
    return lambda t: sum(h * pulse(centre)(t) for h, centre in zip(heights, (0.31, 0.69, 0.92), strict=True))


def forced(name, *courses):
    return trio(*(made(macros=THREE_MACROS, **{name: course}) for course in courses))


def touched(*starts):
    """Runs of the three models whose second and third macro-collisions begin at other times."""
    return trio(*(made(macros=[MACROS[0], (second, 0.71), (third, 0.95)]) for second, third in starts))


def levels(*values):
    """3 J, and less after the first and the second collision and at the end."""
    return lambda t: np.select([t < 0.3, t < 0.68, t < 0.95], [3.0, *values[:2]], values[2])


def lagging(coefficient):
    """Three periods of a sine after the first collision, late by the phase of this cosine."""
    return lambda t: np.sin(6.0 * np.pi * (t - 0.34) / 0.66 - np.arccos(coefficient))


def first_only(inside, outside):
    return lambda t: np.where((t >= 0.3) & (t <= 0.34), inside, outside)


def in_first(*more):
    return trio(made([event(0.3, "impact", "SLIP"), *more, event(0.34, "release", "FREE")]))


def holding(held, crept):
    """The hybrid model sticks from 0.2 to 0.6 s; how fast (m/s) the tips of the two models move."""
    stays = [event(0.2, "stick", "STICK"), event(0.6, "release", "FREE")]
    # in the first half of the stick both move far
    return trio(*(made(stays, slip=lambda t, v=v: np.where(t < 0.39, t, v * t)) for v in (held, 1.0, crept)))


def of_models(name, *values):
    return {name.format(model): v for model, v in zip(("hybrid", "frictionless", "modified"), values, strict=True)}


ENERGIES = three(energy=(levels(2.5, 1.0, 0.5), levels(2.75, 0.75, 0.875), levels(2.625, 1.5, 0.625)))
ORDER = (
    of_models("{} after collision 1", 2.5, 2.75, 2.625)
    | of_models("{} after collision 2", 1.0, 0.75, 1.5)
    | of_models("{} end", 0.5, 0.875, 0.625)
)
ORDERED = (
    "after collision 1 2.5 / 2.75 / 2.625 J ✓; after collision 2 1 / 0.75 / 1.5 J ✗; end 0.5 / 0.875 / 0.625 J ✓"
)
PARTS = three(
    kinetic=(constant(1.0), constant(2.0), constant(4.0)),
    gravity=(constant(3.0), constant(2.0), constant(5.0)),
    elastic=(lambda t: 7.0 + 10.0 * (0.505 - t), constant(7.0), constant(9.0)),
)
MEANS = {"kinetic share": 1.0, "gravity share": 0.0, "elastic share": 0.75}
MEANS |= of_models("kinetic mean {}", 1.0, 2.0, 4.0)
MEANS |= of_models("gravity mean {}", 3.0, 2.0, 5.0)
MEANS |= of_models("elastic mean {}", 5.35, 7.0, 9.0)
FLIGHTS = hybrid(slip=lambda t: np.select([t < 0.3, t < 0.705], [2.0 * t, t], 1.2 * t))
STICKS = in_first(
    event(0.31, "stick", "STICK", -0.02),
    event(0.3101, "slip", "SLIP"),
    event(0.32, "stick", "STICK", 0.01),
    event(0.3202, "slip", "SLIP"),
)
CORRELATED = three(
    **{
        name: (lagging(1.0), lagging(1.0), lagging(value))
        for name, value in (("tip_x", 0.95), ("tip_vx", 0.6), ("tip_y", 0.8), ("tip_vy", 0.98))
    }
)
CORRELATIONS = {"tip_x": 0.95, "tip_vx": 0.6, "tip_y": 0.8, "tip_vy": 0.98}
CHANGING = [
    event(0.2, "impact", "SLIP"),
    event(0.3, "stick", "STICK"),
    event(0.304, "slip", "SLIP"),
    event(0.31, "stick", "STICK"),
    event(0.32, "release", "FREE"),
]


def spread(*values):
    return {f"collision_{k}": value for k, value in enumerate(values, start=1)}


# claim, runs, verdict, numbers, text
FINDINGS = [
    (
        "first-collision",
        trio(made(macros=[(0.31, 0.34)])),
        REPRODUCED,
        {"start": 0.31, "end": 0.34, "middle": 0.325},
        "0.3100 s to 0.3400 s, middle 0.3250 s",
    ),
    ("first-collision", trio(made(macros=[])), NOT, {}, "no collision"),
    (
        "friction-coincides",
        three(lambda_tau=(EARLY, LATE, scaled(1.25))),
        PARTLY,
        {"difference": 1.0 / 9.0},
        "difference 0.111",
    ),
    (
        "friction-slight-difference",
        three(lambda_tau=(EARLY, LATE, scaled(1.25))),
        REPRODUCED,
        {"difference": 1.0 / 9.0},
        "difference 0.111",
    ),
    (
        "friction-drifts-apart",
        forced("lambda_tau", pulses(1.0, 1.0, 1.0), pulses(9.0, 1.0, 1.0), pulses(1.0, 3.0, 2.0)),
        PARTLY,
        spread(0.0, 0.5, 1.0 / 3.0),
        "differences in collisions 1, 2, 3: 0, 0.5, 0.333",
    ),
    (
        "friction-drifts-apart",
        forced("lambda_tau", pulses(1.0, 1.0, 1.0), pulses(1.0, 1.0, 1.0), pulses(1.0, 3.0, 4.0)),
        REPRODUCED,
        spread(0.0, 0.5, 0.6),
        "differences in collisions 1, 2, 3: 0, 0.5, 0.6",
    ),
    (
        "normal-coincides",
        three(lambda_n=(scaled(1.1), EARLY, scaled(1.25))),
        PARTLY,
        {"difference": 1.0 / 9.0},
        "largest difference 0.111",
    ),
    (
        "normal-separates",
        forced("lambda_n", pulses(1.0, 1.0, 1.0), pulses(1.0, 3.0, 2.0), pulses(1.0, 1.0, 1.0)),
        REPRODUCED,
        spread(0.0, 0.5, 1.0 / 3.0),
        "differences in collisions 1, 2, 3: 0, 0.5, 0.333",
    ),
    (
        "normal-separates",
        forced("lambda_n", pulses(1.0, 1.0, 1.0), pulses(1.0, 3.0, 1.5), pulses(1.0, 1.0, 1.0)),
        PARTLY,
        spread(0.0, 0.5, 0.2),
        "differences in collisions 1, 2, 3: 0, 0.5, 0.2",
    ),
    (
        "impact-times-spread",
        touched((0.68, 0.9), (0.69, 0.905), (0.685, 0.902)),
        PARTLY,
        spread(0.0, 0.01, 0.005),
        "spread of the first touches 1, 2, 3: 0, 10, 5 ms",
    ),
    (
        "no-motion-across",
        hybrid(state=first_only(1.0, 0.0), gap=first_only(-1e-4, 5.0), gap_rate=first_only(-0.02, 5.0)),
        NOT,
        {"gap": 1e-4, "gap_rate": 0.02},
        "largest |Z_n| 0.1 mm, |Z_n'| 0.02 m/s",
    ),
    ("no-motion-across", trio(), NOT, {}, "no contact"),
    (
        "friction-matters",
        touching(0.677, 0.68, 0.6),
        REPRODUCED,
        {"shift": -0.003},
        "second touch 3 ms earlier with friction",
    ),
    (
        "energy-constant-before",
        hybrid(energy=lambda t: np.select([t < 0.2, t < 0.3], [3.0, 3.0 - 3e-5], 1.0)),
        PARTLY,
        {"initial": 3.0, "drift": 1e-5},
        "3 J, relative drift 1 × 10⁻⁵",
    ),
    (
        "considerable-loss",
        hybrid(energy=after(2.25)),
        REPRODUCED,
        {"loss": 0.75, "share": 0.25},
        "0.75 J, 25 % of the total",
    ),
    ("hybrid-loses-most", ENERGIES, PARTLY, ORDER, ORDERED),
    ("frictionless-loses-least", ENERGIES, PARTLY, ORDER, ORDERED),
    (
        "friction-dissipates",
        trio(),
        REPRODUCED,
        {"friction": 0.1, "lost": 2.0},
        "100 mJ, 5 % of what is lost in the run",
    ),
    (
        "exchange-before",
        hybrid(gravity=lambda t: 2.0 - t, elastic=constant(2e-3)),
        PARTLY,
        {"exchanged": 0.299, "elastic": 2e-3},
        "0.299 J exchanged, elastic at most 0.002 J",
    ),
    (
        "elastic-after",
        hybrid(elastic=lambda t: np.select([t < 0.3, t <= 0.34], [0.01, 2.0], 50.0)),
        REPRODUCED,
        {"before": 0.01, "after": 2.0},
        "largest 0.01 J before, 2 J in the first collision",
    ),
    (
        "all-parts-smaller",
        PARTS,
        NOT,
        MEANS,
        "kinetic 100 % of the time, mean smallest; gravity 0 % of the time, mean not; "
        "elastic 75 % of the time, mean smallest",
    ),
    (
        "same-before",
        three(theta=(constant(1.0), constant(1.0), constant(1.0 + 1e-7))),
        PARTLY,
        {"difference": 1e-7},
        "largest relative difference 1 × 10⁻⁷",
    ),
    (
        "different-after",
        three(tip_x=(constant(1.0), constant(1.0), lambda t: np.where(t < 0.32, 1.001, 1.25))),
        REPRODUCED,
        {"before": 0.001 / 1.001, "after": 0.2},
        "largest relative difference 0.001 before, 0.2 after",
    ),
    (
        "similar-after",
        CORRELATED,
        PARTLY,
        {f"correlation {name}": value for name, value in CORRELATIONS.items()},
        "x 0.95, x' 0.6, y 0.8, y' 0.98",
    ),
    (
        "maximum-before",
        hybrid(slip=lambda t: 1.0 - 10.0 * (t - 0.2) ** 2),
        REPRODUCED,
        {"time": 0.2, "maximum": 1.0, "rise": 0.4, "fall": 0.09801},
        "from 0.6 up to 1 m at 0.2000 s, down to 0.902 m",
    ),
    (
        "changes-shrink",
        FLIGHTS,
        PARTLY,
        {"flight_0": 0.598, "flight_1": 0.34, "flight_2": 0.348},
        "change per flight 598, 340, 348 mm",
    ),
    (
        "slip-only-first",
        STICKS,
        PARTLY,
        {"sticks": 2.0, "duration": 3e-4, "share": 0.0075, "fastest": 0.02},
        "2 stays judged as stick, 300 µs in all, 0.75 % of the contact; slip velocity as they begin up to 20 mm/s",
    ),
    ("slip-only-first", in_first(), REPRODUCED, {"sticks": 0.0, "duration": 0.0, "share": 0.0}, "no stick"),
    (
        "direction-changes",
        in_first(event(0.3236, "reversal", "SLIP"), event(0.329, "reversal", "SLIP")),
        PARTLY,
        {"nearest": 0.3236, "reversals": 2.0},
        "reversals at 0.3236 s, 0.3290 s",
    ),
    ("direction-changes", in_first(), NOT, {}, "no reversal in contact"),
    (
        "sticks-later",
        slip_in_second((0.7, "stick"), (0.7006, "slip")),
        REPRODUCED,
        {"sticks": 1.0, "duration": 6e-4, "share": 0.02, "fastest": 0.0},
        "1 stays judged as stick, 600 µs in all, 2 % of the contact; slip velocity as they begin up to 0 mm/s",
    ),
    ("sticks-later", STICKS, NOT, {"sticks": 0.0, "duration": 0.0, "share": 0.0}, "no stick"),
    (
        "sticks-later",
        slip_in_second((0.7, "stick"), (0.70015, "slip")),
        PARTLY,
        {"sticks": 1.0, "duration": 1.5e-4, "share": 0.005, "fastest": 0.0},
        "1 stays judged as stick, 150 µs in all, 0.5 % of the contact; slip velocity as they begin up to 0 mm/s",
    ),
    (
        "slips-at-first",
        trio(made([event(0.68, "impact", "STICK")])),
        NOT,
        {"start": 0.68, "state": 2.0},
        "from 0.6800 s, first state stick",
    ),
    (
        "slips-at-first",
        trio(made([event(0.68, "rebound", "FREE")])),
        NOT,
        {"start": 0.68},
        "from 0.6800 s: rebounds only",
    ),
    (
        "second-collision",
        touching(0.7039, 0.68, 0.68),
        PARTLY,
        {"start": 0.7039, "end": 0.71, "off": 0.0049},
        "0.7039 s to 0.7100 s, 4.9 ms away",
    ),
    (
        "second-collision",
        trio(made(macros=[MACROS[0], (0.68, 0.6975)])),
        PARTLY,
        {"start": 0.68, "end": 0.6975, "off": 0.0015},
        "0.6800 s to 0.6975 s, 1.5 ms away",
    ),
    ("second-collision", trio(made(macros=MACROS[:1])), NOT, {}, "no second collision"),
    (
        "stick-at-0.699",
        slip_in_second((0.69, "stick"), (0.6901, "slip"), (0.7, "stick"), (0.70025, "slip")),
        REPRODUCED,
        {"start": 0.7, "duration": 2.5e-4},
        "longest stay judged as stick from 0.7000 s, 250 µs",
    ),
    ("stick-at-0.699", slip_in_second(), NOT, {"start": np.nan, "duration": 0.0}, "no stick"),
    (
        "stick-to-the-end",
        slip_in_second((0.69, "stick"), (0.7, "slip")),
        NOT,
        {"end": 0.71, "last_stick_end": 0.7},
        "last stick ends 10 ms before the last release",
    ),
    ("stick-to-the-end", slip_in_second(), NOT, {"end": 0.71, "last_stick_end": np.nan}, "no stick"),
    (
        "modified-cannot-stick",
        holding(1e-9, 0.5),
        REPRODUCED,
        {"hybrid": 2e-10, "modified": 0.1},
        "0.4000 s to 0.6000 s: hybrid moves 2 × 10⁻¹⁰ m, modified Coulomb 0.1 m",
    ),
    (
        "modified-cannot-stick",
        holding(1e-6, 0.5),
        PARTLY,
        {"hybrid": 2e-7, "modified": 0.1},
        "0.4000 s to 0.6000 s: hybrid moves 2 × 10⁻⁷ m, modified Coulomb 0.1 m",
    ),
    (
        "modified-cannot-stick",
        holding(1e-9, 0.5e-6),
        NOT,
        {"hybrid": 2e-10, "modified": 1e-7},
        "0.4000 s to 0.6000 s: hybrid moves 2 × 10⁻¹⁰ m, modified Coulomb 1 × 10⁻⁷ m",
    ),
    ("modified-cannot-stick", trio(), NOT, {}, "the hybrid model does not stick here"),
    (
        "states-interchange",
        trio(made(CHANGING)),
        REPRODUCED,
        {"to_stick": 2.0, "to_slip": 1.0, "stick_time": 0.014},
        "2 times slip to stick, 1 times stick to slip, 14 ms of stick",
    ),
]


@pytest.mark.parametrize(
    ("claim", "runs", "verdict", "numbers", "text"), FINDINGS, ids=[f"{f[0]}: {f[2]}" for f in FINDINGS]
)
def test_a_finding_has_its_verdict_its_numbers_and_its_text(claim, runs, verdict, numbers, text):
    found = CLAIMS[claim].judge(runs)
    assert (found.verdict, found.text) == (verdict, text)
    assert found.numbers.keys() == numbers.keys()
    for name, value in numbers.items():
        assert found.numbers[name] == pytest.approx(value, rel=1e-3, abs=1e-12, nan_ok=True), name


# claim: its place in the paper, the numbers in its statement, the numbers in its rule
SAID = {
    "first-collision": ("Sec. 7, Fig. 2", "0.325 s", "0.325 s, 2 ms"),
    "friction-coincides": ("Sec. 7, Fig. 2", "", "0.1, 0.3"),
    "friction-slight-difference": ("Sec. 7, Fig. 2", "", "10⁻⁶"),
    "friction-drifts-apart": ("Sec. 7, Fig. 2", "", "1, 2, 3"),
    "normal-coincides": ("Sec. 7, Fig. 3", "", "0.1, 0.3"),
    "normal-separates": ("Sec. 7, Fig. 3", "", "2, 3, 0.3"),
    "impact-times-spread": ("Sec. 7, Fig. 3", "", "1, 2, 3"),
    "no-motion-across": ("Sec. 4.2", "", "10⁻⁹ m, 10⁻⁵ m"),
    "friction-matters": ("Secs. 7, 8", "", "1 ms"),
    "energy-constant-before": ("Sec. 7, Fig. 4", "", "10⁻⁶, 10⁻³"),
    "considerable-loss": ("Sec. 7, Fig. 4", "", "10 %"),
    "hybrid-loses-most": ("Sec. 7, Fig. 4", "", "1, 2"),
    "frictionless-loses-least": ("Sec. 7, Fig. 4", "", ""),
    "friction-dissipates": ("Sec. 7, Fig. 4", "", ""),
    "exchange-before": ("Sec. 7, Figs. 5–7", "", "10⁻³, 10⁻²"),
    "elastic-after": ("Sec. 7, Figs. 5–7", "", "100"),
    "all-parts-smaller": ("Sec. 7, Figs. 5–7", "", "95 %"),
    "same-before": ("Sec. 7, Figs. 8–13", "", "10⁻⁹, 10⁻⁶"),
    "different-after": ("Sec. 7, Figs. 10–13", "", "1 %"),
    "similar-after": ("Sec. 7, Figs. 10–13", "", "0.9, 0.5"),
    "maximum-before": ("Sec. 7, Fig. 14", "", "1 mm"),
    "changes-shrink": ("Sec. 7, Fig. 14", "", ""),
    "slip-only-first": ("Sec. 7, Figs. 14, 15", "", "0, 1 %"),
    "direction-changes": ("Sec. 7, Fig. 15", "0.325 s", "0.325 s, 0.5 ms, 3 ms"),
    "sticks-later": ("Sec. 7, Fig. 14", "", "1 %, 0"),
    "slips-at-first": ("Sec. 7, Fig. 16", "", ""),
    "second-collision": ("Sec. 7, Fig. 16", "0.699 s", "0.699 s, 5 ms"),
    "stick-at-0.699": ("Sec. 7, Fig. 16", "0.699 s", "0.1 ms, 2 ms, 0.699 s, 5 ms"),
    "stick-to-the-end": ("Sec. 7, Fig. 16", "", ""),
    "modified-cannot-stick": ("Sec. 7, Fig. 2", "", "1,000, 10⁻⁸ m, 10⁻⁴ m"),
    "states-interchange": ("Sec. 7, Fig. 2", "", "12, 1 ms"),
}


def numbers_in(text):
    found = re.findall(r"(?<![\w₁])(10[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+|[\d.,]*\d)((?: (?:s|ms|mm|m|%))?)(?![\w])", text)
    return ", ".join(f"{value}{unit}" for value, unit in found)


def test_every_claim_names_its_place_and_the_numbers_that_it_is_judged_by():
    found = {name: (c.place, numbers_in(c.statement), numbers_in(c.rule)) for name, c in CLAIMS.items()}
    assert found == SAID


def test_every_claim_has_a_finding_here():
    assert {finding[0] for finding in FINDINGS} == CLAIMS.keys()

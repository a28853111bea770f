"""The reproduction of the paper: its rules can fail, its numbers are right, its curves lose no peak."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
import xarray as xr

from oblique_impact import History, Scenario
from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.history.sample_times import jumps
from oblique_impact.history.summary import MacroCollision
from oblique_impact.marching.records import Event
from oblique_impact.validation.reference_values import VALUES
from oblique_impact.validation.reproduction.cases import (
    Case,
    combinations,
    main_cases,
    paper,
    threshold_cases,
    variant_cases,
)
from oblique_impact.validation.reproduction.claims import (
    NOT,
    PARTLY,
    REPRODUCED,
    Finding,
    Judged,
    graded,
    milliseconds,
    moment,
)
from oblique_impact.validation.reproduction.material import Material
from oblique_impact.validation.reproduction.measures import (
    Trio,
    between,
    existing,
    flight_ranges,
    force_difference,
    increasing,
    longest,
    stick_share,
)
from oblique_impact.validation.reproduction.pictures import PLOTS, draw, summary
from oblique_impact.validation.reproduction.runs import Run, Stay, run_case
from oblique_impact.validation.reproduction.stick_pages import why
from oblique_impact.validation.reproduction.sticking import StickCheck, friction_ratio
from oblique_impact.validation.reproduction.unsaid import ALL_CLAIMS, Robustness, Studied, _collision

CLAIMS = {claim.id: claim for claim in ALL_CLAIMS}
MACROS = ((0.3, 0.34), (0.68, 0.71))
NAMES = (
    *("gap", "slip", "gap_rate", "slip_rate", "lambda_n", "lambda_tau", "theta", "theta_dot", "state"),
    *("tip_x", "tip_y", "tip_vx", "tip_vy", "kinetic", "elastic", "gravity", "energy"),
)


def event(time, kind, state, slip_rate=0.0, impulse=0.0):
    return Event(time, EventKind(kind), impulse, 0.0, 0.0, slip_rate, 0.0, State[state])


def made(events=(), macros=MACROS, **arrays):
    """A run with given samples on a millisecond grid; what is not given is zero."""
    time = np.linspace(0.0, 1.0, 1001)
    data = {name: np.zeros_like(time) for name in NAMES}
    data |= {name: np.broadcast_to(np.asarray(values(time)), time.shape) for name, values in arrays.items()}
    samples = xr.Dataset({name: ("time", values) for name, values in data.items()}, {"time": time})
    summary = {
        "energy": {"initial": 3.0, "final": 1.0, "lost_friction": 0.1},
        "macro_collisions": [vars(MacroCollision(*macro, 2, 1.0, 0.1, 100.0)) for macro in macros],
    }
    return Run("made", History(samples, list(events), summary, Scenario()), [])


def trio(hybrid=None, frictionless=None, modified=None):
    other = made()
    return Trio(hybrid or other, frictionless or other, modified or other)


def three(**courses):
    """Runs of the three models, each with its own course of some variables."""
    return Trio(*(made(**dict(zip(courses, own, strict=True))) for own in zip(*courses.values(), strict=True)))


def hybrid(**course):
    return trio(made(**course))


def slip_in_second(*more):
    """The hybrid model slips in the second macro-collision until something else happens at some times."""
    later = [event(time, kind, kind.upper()) for time, kind in more]
    return trio(made([event(0.68, "impact", "SLIP"), *later, event(0.71, "release", "FREE")]))


def reversing(time):
    return trio(made([event(time, "reversal", "SLIP")]))


# --- rules ------------------------------------------------------------------------------------------------


def pulse(centre, width=0.005):
    return lambda t: np.where(np.abs(t - centre) < width, 1.0, 0.0)


def after(level, before=3.0):
    return lambda t: np.where(t < 0.3, before, level)


def until(time, level):
    """3 J until some time, and less from then on."""
    return lambda t: np.where(t < time, 3.0, level)


def touching(*second):
    """Runs of the three models that differ in when they touch the slope for the second time."""
    return Trio(*(made(macros=[MACROS[0], (start, 0.71)]) for start in second))


def scaled(factor):
    return lambda t: factor * EARLY(t)


def correlated(coefficient):
    """Three periods of a sine after the first collision; one model lags by the phase of this cosine."""

    def wave(phase):
        return lambda t: np.sin(6.0 * np.pi * (t - 0.34) / 0.66 - phase)

    courses = wave(0.0), wave(0.0), wave(np.arccos(coefficient))
    return three(**dict.fromkeys(("tip_x", "tip_vx", "tip_y", "tip_vy"), courses))


def parts(course):
    return three(**dict.fromkeys(("kinetic", "elastic", "gravity"), (course, constant(2.0), constant(2.0))))


def constant(value):
    return lambda t: value


ZERO, EARLY, LATE = constant(0.0), pulse(0.31), pulse(0.33)
STUCK_IN_FIRST = [event(0.3, "impact", "SLIP"), event(0.31, "stick", "STICK"), event(0.34, "release", "FREE")]
RULES = [
    ("first-collision", PARTLY, trio()),
    ("first-collision", REPRODUCED, trio(made(macros=[(0.31, 0.34)]))),  # centred on 0.325 s
    ("first-collision", NOT, trio(made(macros=[(0.4, 0.41)]))),
    ("first-collision", NOT, trio(made(macros=[]))),
    ("friction-coincides", REPRODUCED, three(lambda_tau=(EARLY, ZERO, EARLY))),
    ("friction-coincides", NOT, three(lambda_tau=(EARLY, ZERO, LATE))),
    ("friction-slight-difference", NOT, three(lambda_tau=(EARLY, ZERO, EARLY))),
    ("normal-coincides", NOT, three(lambda_n=(EARLY, LATE, EARLY))),
    ("no-motion-across", NOT, hybrid(state=constant(1.0), gap=constant(1e-4))),
    ("no-motion-across", REPRODUCED, hybrid(state=constant(1.0), gap=constant(1e-12))),
    ("no-motion-across", REPRODUCED, hybrid(state=constant(1.0), gap=constant(0.9e-9))),
    ("no-motion-across", PARTLY, hybrid(state=constant(1.0), gap=constant(1.1e-9))),
    ("no-motion-across", NOT, trio()),  # no contact
    # on either side of what the rules say; a force that is larger by x differs by x/(2 + x)
    ("friction-coincides", REPRODUCED, three(lambda_tau=(EARLY, ZERO, scaled(1.2)))),
    ("friction-coincides", PARTLY, three(lambda_tau=(EARLY, ZERO, scaled(1.25)))),
    ("friction-coincides", NOT, three(lambda_tau=(EARLY, ZERO, scaled(1.9)))),
    ("friction-slight-difference", REPRODUCED, three(lambda_tau=(EARLY, ZERO, scaled(1.000003)))),
    ("friction-slight-difference", NOT, three(lambda_tau=(EARLY, ZERO, scaled(1.000001)))),
    ("normal-coincides", REPRODUCED, three(lambda_n=(EARLY, EARLY, scaled(1.2)))),
    ("normal-coincides", PARTLY, three(lambda_n=(EARLY, EARLY, scaled(1.25)))),
    ("friction-matters", REPRODUCED, touching(0.6811, 0.68, 0.68)),
    ("friction-matters", REPRODUCED, touching(0.68, 0.6811, 0.68)),
    ("friction-matters", NOT, touching(0.6809, 0.68, 0.68)),
    ("energy-constant-before", REPRODUCED, hybrid(energy=lambda t: 3.0 * (1.0 + 3e-6 * t))),
    ("energy-constant-before", PARTLY, hybrid(energy=lambda t: 3.0 * (1.0 + 4e-6 * t))),
    ("considerable-loss", REPRODUCED, hybrid(energy=after(2.69))),
    ("considerable-loss", NOT, hybrid(energy=after(2.71))),
    ("considerable-loss", NOT, hybrid(energy=until(0.7, 1.0))),  # lost in the second one
    ("hybrid-loses-most", PARTLY, three(energy=(until(0.7, 1.0), after(2.0), after(1.5)))),
    ("exchange-before", REPRODUCED, hybrid(gravity=lambda t: t, elastic=constant(0.9e-3 * 0.299))),
    ("exchange-before", PARTLY, hybrid(gravity=lambda t: t, elastic=constant(1.1e-3 * 0.299))),
    ("exchange-before", NOT, hybrid(gravity=lambda t: t, elastic=constant(1.1e-2 * 0.299))),
    ("same-before", REPRODUCED, three(theta=(constant(1.0), constant(1.0), constant(1.0 + 0.9e-9)))),
    ("same-before", PARTLY, three(theta=(constant(1.0), constant(1.0), constant(1.0 + 1.1e-9)))),
    ("different-after", REPRODUCED, three(tip_x=(constant(1.0), constant(1.0), after(1.011, 1.0)))),
    ("different-after", NOT, three(tip_x=(constant(1.0), constant(1.0), after(1.009, 1.0)))),
    ("similar-after", REPRODUCED, correlated(0.91)),
    ("similar-after", PARTLY, correlated(0.89)),
    ("similar-after", NOT, correlated(0.49)),
    ("maximum-before", REPRODUCED, hybrid(slip=lambda t: -0.05 * (t - 0.15) ** 2)),  # 1.1 mm up and down
    ("maximum-before", NOT, hybrid(slip=lambda t: -0.04 * (t - 0.15) ** 2)),
    ("direction-changes", REPRODUCED, reversing(0.3254)),
    ("direction-changes", PARTLY, reversing(0.3256)),
    ("direction-changes", NOT, reversing(0.3281)),
    ("stick-at-0.699", REPRODUCED, slip_in_second((0.7009, "stick"))),
    ("stick-at-0.699", PARTLY, slip_in_second((0.7011, "stick"))),
    ("stick-at-0.699", NOT, slip_in_second((0.7041, "stick"))),
    ("second-collision", PARTLY, touching(0.7039, 0.68, 0.68)),
    ("second-collision", NOT, touching(0.7041, 0.68, 0.68)),
    ("elastic-after", REPRODUCED, hybrid(elastic=after(101.0, 1.0))),
    ("elastic-after", NOT, hybrid(elastic=after(99.0, 1.0))),
    ("all-parts-smaller", REPRODUCED, parts(until(0.34 + 0.04 * 0.66, 1.0))),
    ("all-parts-smaller", PARTLY, parts(until(0.34 + 0.06 * 0.66, 1.0))),
    ("friction-matters", NOT, trio()),
    ("energy-constant-before", NOT, hybrid(energy=lambda t: 3.0 + t)),
    ("energy-constant-before", REPRODUCED, hybrid(energy=constant(3.0))),
    ("considerable-loss", NOT, hybrid(energy=constant(3.0))),
    ("considerable-loss", REPRODUCED, hybrid(energy=after(2.0))),
    ("hybrid-loses-most", REPRODUCED, three(energy=(after(1.0), after(2.0), after(1.5)))),
    ("hybrid-loses-most", NOT, three(energy=(after(1.6), after(2.0), after(1.5)))),
    ("frictionless-loses-least", REPRODUCED, three(energy=(after(1.0), after(2.0), after(1.5)))),
    ("frictionless-loses-least", NOT, three(energy=(after(1.0), after(0.5), after(1.5)))),
    (
        "all-parts-smaller",
        REPRODUCED,
        three(**dict.fromkeys(("kinetic", "elastic", "gravity"), (after(1.0), after(2.0), after(2.0)))),
    ),
    ("all-parts-smaller", NOT, three(kinetic=(after(3.0), after(2.0), after(2.0)))),
    ("maximum-before", NOT, hybrid(slip=lambda t: t)),
    ("maximum-before", REPRODUCED, hybrid(slip=lambda t: -((t - 0.2) ** 2))),
    ("changes-shrink", REPRODUCED, hybrid(slip=lambda t: np.exp(-3.0 * t))),
    ("changes-shrink", NOT, hybrid(slip=lambda t: np.exp(3.0 * t))),
    ("same-before", NOT, hybrid(theta=lambda t: 1.0 + t)),
    ("different-after", NOT, trio()),
    ("slip-only-first", REPRODUCED, trio()),
    ("slip-only-first", NOT, trio(made(STUCK_IN_FIRST))),
    ("direction-changes", REPRODUCED, reversing(0.3252)),
    ("direction-changes", PARTLY, reversing(0.3236)),
    ("direction-changes", NOT, reversing(0.335)),
    ("sticks-later", NOT, slip_in_second()),
    ("stick-at-0.699", REPRODUCED, slip_in_second((0.6995, "stick"))),
    ("stick-at-0.699", NOT, slip_in_second((0.69, "stick"))),
    ("stick-at-0.699", NOT, slip_in_second((0.699, "stick"), (0.69901, "slip"))),  # too short
    ("stick-to-the-end", REPRODUCED, slip_in_second((0.699, "stick"))),
    ("stick-to-the-end", NOT, slip_in_second((0.699, "stick"), (0.7, "slip"))),
    ("slips-at-first", REPRODUCED, slip_in_second()),
    ("slips-at-first", NOT, trio(made([event(0.68, "impact", "STICK")]))),
    ("second-collision", REPRODUCED, trio()),
    ("second-collision", NOT, trio(made(macros=[MACROS[0], (0.6, 0.61)]))),
    ("modified-cannot-stick", NOT, trio()),
    ("states-interchange", NOT, slip_in_second()),
]


@pytest.mark.parametrize(("claim", "verdict", "runs"), RULES, ids=[f"{rule[0]}: {rule[1]}" for rule in RULES])
def test_rules_can_hold_and_fail(claim, verdict, runs):
    assert CLAIMS[claim].judge(runs).verdict == verdict


def test_what_a_rule_found_is_written_with_its_unit_and_side():
    earlier, later = (CLAIMS["friction-matters"].judge(touching(time, 0.68, 0.68)).text for time in (0.677, 0.683))
    assert earlier == "second touch 3 ms earlier with friction"
    assert later == "second touch 3 ms later with friction"
    spread = CLAIMS["impact-times-spread"].judge(touching(0.68, 0.69, 0.685))
    assert spread.text == "spread of the first touches 1, 2, 3: 0, 10, – ms"
    assert spread.numbers["collision_2"] == pytest.approx(0.01)
    assert CLAIMS["considerable-loss"].judge(hybrid(energy=after(2.25))).text == "0.75 J, 25 % of the total"
    work = CLAIMS["friction-dissipates"].judge(trio()).text
    assert work == "100 mJ, 5 % of what is lost in the run"


def test_times_are_written_in_their_unit():
    assert (milliseconds(0.0123), moment(0.69904)) == ("12.3 ms", "0.6990 s")


def test_verdicts_of_two_schemes_combine():
    for verdicts, expected in (((0, 0), 0), ((2, 2), 2), ((0, 2), 1), ((1, 2), 1), ((0, 1), 1)):
        order = (REPRODUCED, PARTLY, NOT)
        found = {str(k): Finding(order[verdict], {}, "") for k, verdict in enumerate(verdicts)}
        assert Judged(None, found).verdict == order[expected]
    assert [graded(x, 1.0, 2.0) for x in (1.0, 1.5, 2.5, float("nan"))] == [REPRODUCED, PARTLY, NOT, NOT]


def test_claims_that_every_choice_reproduces_do_not_discriminate():
    always, mostly = ("friction-coincides", "reproduced"), ("friction-matters", "reproduced")
    grid = [
        Robustness(None, dict([always, mostly]), (), (0.0,) * 4),
        Robustness(None, dict([always, (mostly[0], "not reproduced")]), (), (0.0,) * 4),
    ]
    found = [Judged(claim, {}) for claim in ALL_CLAIMS]
    material = Material({}, {}, found, [], grid, (0.0, []))
    assert material.counts(mostly[0]) == {"reproduced": 1, "partly": 0, "not reproduced": 1}
    assert material.counts("states-interchange") == {}  # judged on a scenario that sticks
    assert [judged.claim.id for judged in found if not material.discriminates(judged.claim.id)] == [always[0]]
    assert material.undiscriminating == 1


def test_claims_have_names_of_their_own_and_say_their_rule():
    assert len(CLAIMS) == len(ALL_CLAIMS)
    assert all(claim.rule and claim.statement.endswith(".") and "Sec" in claim.place for claim in ALL_CLAIMS)
    assert {claim.case for claim in ALL_CLAIMS} == {"paper", "sticking", "rough"}


# --- measures ---------------------------------------------------------------------------------------------


def test_force_difference_is_zero_for_the_same_and_one_without_overlap():
    one, same, other = (made(lambda_n=pulse(centre)) for centre in (0.31, 0.31, 0.33))
    assert force_difference(one, same, "lambda_n", 1) == 0.0
    assert force_difference(one, other, "lambda_n", 1) == pytest.approx(1.0)
    double = made(lambda_n=lambda t: 2.0 * pulse(0.31)(t))
    assert force_difference(one, double, "lambda_n", 1) == pytest.approx(1.0 / 3.0)
    assert np.isnan(force_difference(one, made(), "lambda_tau", 1))
    assert np.isnan(force_difference(one, other, "lambda_n", 3))


def test_small_measures():
    sticks = [Stay(start, end, State.STICK, 0.0) for start, end in ((0.1, 0.2), (0.3, 0.7), (0.8, 0.9))]
    assert longest(sticks) == pytest.approx((0.3, 0.4))
    assert existing([1.0, 2.0, float("nan"), 3.0]) == [1.0, 2.0]
    assert increasing([1.0, 2.0, 3.0])
    assert not increasing([1.0, 1.0])
    assert not increasing([1.0])
    run = made(slip=lambda t: t)
    assert flight_ranges(run, "slip") == pytest.approx([0.3, 0.34, 0.29], abs=1e-9)


def test_runs_are_compared_in_the_middle_of_the_flight_that_all_have():
    """The last of three leaves the slope at 0.36 s, the first touches it again at 0.66 s; the run ends at 1 s."""
    late, early = made(macros=[(0.3, 0.36), (0.68, 0.71)]), made(macros=[(0.3, 0.34), (0.66, 0.7)])
    assert [between(trio(late, early), k) for k in (1, 2, 3)] == [pytest.approx(0.51), pytest.approx(0.855), None]
    assert between(trio(made(macros=[(0.3, 0.69)])), 1) is None


def test_the_energy_that_is_left_is_that_of_the_flight_that_follows():
    run = made(energy=lambda t: t)  # flights from 0.34 to 0.68 s, and from 0.71 to 1 s
    assert [_collision(run, k).energy_left for k in (1, 2)] == pytest.approx([0.51, 0.855])


def test_time_in_contact_and_share_of_stick():
    first = [event(0.3, "impact", "SLIP"), event(0.31, "stick", "STICK"), event(0.32, "release", "FREE")]
    again = [event(0.33, "impact", "SLIP"), event(0.34, "release", "FREE")]
    run = made([*first, *again, event(0.5, "rebound", "FREE")])
    assert stick_share(run, run.macros[:1]) == pytest.approx(1.0 / 3.0)
    assert [(stay.start, stay.end, stay.state.name) for stay in run.stays] == [
        (0.3, 0.31, "SLIP"),
        (0.31, 0.32, "STICK"),
        (0.33, 0.34, "SLIP"),
        (0.5, 0.5, "FREE"),
    ]
    assert len(run.stays_in(run.macro(1))) == 3


# --- pictures ---------------------------------------------------------------------------------------------


def test_all_figures_of_the_paper_are_there():
    assert {plot.number for plot in PLOTS} >= {str(n) for n in range(2, 17)}
    assert len({plot.name for plot in PLOTS}) == len(PLOTS)


def test_a_figure_has_its_unit_and_its_numbers_are_in_si():
    """Figure 14a: the position along the slope is drawn in mm, and told in m."""
    plot = next(plot for plot in PLOTS if plot.number == "14a")
    runs = {"fixed-step": three(slip=(np.square, np.sin, np.cos)), "event": hybrid(slip=np.sin)}
    first = summary(plot, runs)[0]
    assert (first["unit"], first["model"], first["scheme"]) == ("m", "hybrid", "fixed-step")
    assert (first["minimum"], first["maximum"], first["maximum_time"]) == (pytest.approx(0.09), 1.0, 1.0)
    assert first["mean"] == pytest.approx((1.0 - 0.3**3) / 3.0 / 0.7, rel=1e-5)
    svg = draw(plot, runs)
    assert "(mm)" in svg
    assert "<!-- time (s) -->" in svg


# --- cases ------------------------------------------------------------------------------------------------


def test_every_choice_has_one_assumed_value_and_others():
    names = {(v.choice, v.label, v.assumed) for v, _, _ in variant_cases()}
    assumed = Counter(choice for choice, _, ours in names if ours)
    others = Counter(choice for choice, _, ours in names if not ours)
    assert set(assumed) == set(others)
    assert set(assumed.values()) == {1}
    keys = [case.key for _, _, case in variant_cases()]
    assert len(keys) == len(set(keys))


def test_combinations_are_all_different():
    grid = combinations()
    scenarios = {point.scenario("hybrid").to_toml() for point in grid}
    assert len(scenarios) == len(grid) == 48


def test_fixed_step_is_as_printed():
    """The steps and Baumgarte's parameters of the paper, Sec. 7."""
    solver = main_cases()[0].scenario.solver
    assert solver.scheme == "fixed-step"
    assert (solver.free_step, solver.contact_step) == (1e-4, 1e-6)
    assert solver.baumgarte == (10.0, 1000.0)


# --- against the simulation -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def located():
    return run_case(Case("paper", paper("event", output_interval=1e-5, end_time=0.34), sticking=True))


def test_rates_in_the_floating_frame_are_derivatives(located):
    # one contact without a jump; its reversal has two samples
    inside = np.flatnonzero(located.inside(0.3222, 0.3268) & ~np.append(jumps(located["time"]), False))
    time = located["time"][inside]
    for name in ("shortening", "deflection"):
        rate = np.gradient(located[name][inside], time)
        exact = located[f"{name}_rate"][inside]
        assert np.max(np.abs(rate - exact)[2:-2]) < 1e-3 * np.max(np.abs(exact))


def test_jam_angle_of_the_rigid_bar(located):
    """In contact the line from pin to tip has the angle of the rigid bar: cot of it is its jam coefficient.

    The bent beam is up to 1 mm shorter, and cot b of a point on the slope falls with its distance from the pin.
    """
    for check in located.checks:
        assert check.cotangent == pytest.approx(VALUES["6d"]["jam_mu"], rel=2e-3)


def test_sticking_solution_at_the_reversals_is_far_outside_of_the_cone(located):
    first, second = located.checks
    assert first.time == pytest.approx(0.3235971200, abs=1e-8)  # theory, Sec. 8
    assert second.time == pytest.approx(0.3299378327, abs=1e-8)
    assert first.ratio > 30.0 * 0.3
    assert second.ratio == float("inf")  # it would pull
    assert abs(first.slip_rate) < 1e-9


def test_threshold_of_stick_is_where_the_ratio_says(located):
    below, above = (run_case(case) for case in threshold_cases(located.checks[0].ratio))
    time = located.checks[0].time
    kinds = [next(c.kind for c in run.checks if abs(c.time - time) < 1e-9) for run in (below, above)]
    assert kinds == ["reversal", "stick"]


def test_sticking_scenario_sticks_inside_of_the_cone():
    scenario = Scenario.builtin("sticking")
    run = run_case(Case("sticking", scenario, sticking=True))
    stuck = run["state"] == State.STICK
    assert stuck.any()
    ratio = np.abs(run["stick_tangential"][stuck]) / run["stick_normal"][stuck]
    assert np.max(ratio) <= scenario.contact.mu_static * (1.0 + 1e-9)
    begun = [check for check in run.checks if check.kind == "stick"]
    assert all(check.ratio <= scenario.contact.mu_static and abs(check.slip_rate) < 1e-9 for check in begun)
    assert run.sticks[-1].end == run.end_time


def test_stays_judged_stick_by_the_printed_rule_move():
    """Without the tip's shortening in the contact rows short sticks occur (theory, Sec. 4), at full speed."""
    run = run_case(
        Case(
            "x",
            paper("fixed-step", contact__shortening=False, solver__stick="force", end_time=0.34),
            sticking=True,
        )
    )
    starts = [stick.start for stick in run.sticks]
    for expected in (0.3232, 0.3250, 0.3268):
        assert min(abs(start - expected) for start in starts) < 1e-4
    fastest = max(run.sticks, key=lambda stick: abs(stick.slip_rate))
    assert abs(fastest.slip_rate) > 0.2
    judged = {check.time: check.judged_ratio for check in run.checks if check.kind == "stick"}
    assert judged
    assert all(ratio <= 0.3 * (1.0 + 1e-6) for ratio in judged.values())


def test_ratio_and_reasons():
    assert friction_ratio(2.0, -1.0) == 0.5
    assert friction_ratio(-2.0, 1.0) == float("inf")
    assert np.isnan(friction_ratio(float("nan"), 1.0))
    at = StickCheck(0.3, "reversal", 0.0, 1.0, 5.0, 1.0, 5.0, 10.7)
    assert why(at, 5.0, 0.3) == "cannot: 5 > 0.3"
    assert "pull" in why(at, float("inf"), 0.3)
    assert "no force" in why(at, float("nan"), 0.3)
    assert "moves" in why(at._replace(kind="stick", slip_rate=0.05), 0.1, 0.3)
    assert why(at._replace(kind="stick"), 0.1, 0.3).startswith("sticks")


def test_a_line_of_the_study():
    variant, scheme, case = next(iter(variant_cases()))
    row = Studied(variant, scheme, run_case(case)).flat()
    assert row["choice"] == "number of modes"
    assert 0.31 < row["first_start"] < row["first_end"] < row["second_start"]
    assert row["first_normal_impulse"] > 0.0

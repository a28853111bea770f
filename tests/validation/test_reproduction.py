"""The reproduction of the paper: its rules can fail, its numbers are right, its curves lose no peak."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from oblique_impact import Scenario
from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.history.sample_times import jumps
from oblique_impact.marching.records import Event
from validation.reference_values import VALUES
from validation.reproduction import energies, forces, motions
from validation.reproduction.cases import Case, combinations, main_cases, paper, threshold_cases, variant_cases
from validation.reproduction.claims import (
    NOT,
    PARTLY,
    REPRODUCED,
    Claim,
    Finding,
    Judged,
    combined,
    graded,
    judge,
    milliseconds,
    moment,
)
from validation.reproduction.material import Material
from validation.reproduction.measures import (
    Trio,
    existing,
    flight_ranges,
    force_difference,
    increasing,
    smallest_share,
    stick_share,
)
from validation.reproduction.pictures import PLOTS, thinned
from validation.reproduction.runs import Macro, Run, run_case
from validation.reproduction.stick_pages import why
from validation.reproduction.sticking import StickCheck, friction_ratio
from validation.reproduction.unsaid import Robustness, all_claims, contact_spans, study

MACROS = (Macro(0.3, 0.34, 2, 1.0, 0.1, 100.0), Macro(0.68, 0.71, 2, 1.0, 0.1, 100.0))
NAMES = (
    *("gap", "slip", "gap_rate", "slip_rate", "lambda_n", "lambda_tau", "theta", "theta_dot"),
    *("tip_x", "tip_y", "tip_vx", "tip_vy", "kinetic", "elastic", "gravity", "energy"),
)


def event(time, kind, state, slip_rate=0.0, impulse=0.0):
    return Event(time, EventKind(kind), impulse, 0.0, 0.0, slip_rate, 0.0, State[state])


def made(events=(), macros=MACROS, **arrays):
    """A run with given samples on a millisecond grid; what is not given is zero."""
    time = np.linspace(0.0, 1.0, 1001)
    data = {name: np.zeros_like(time) for name in NAMES} | {"time": time, "state": np.zeros_like(time)}
    data |= {name: np.broadcast_to(np.asarray(values(time)), time.shape) for name, values in arrays.items()}
    ledger = {"initial": 3.0, "final": 1.0, "lost_friction": 0.1}
    return Run("made", Scenario(), "completed", data, list(events), list(macros), ledger, [])


def trio(hybrid=None, frictionless=None, modified=None):
    other = made()
    return Trio(hybrid or other, frictionless or other, modified or other)


def slip_in_second(*more):
    return [event(0.68, "impact", "SLIP"), *more, event(0.71, "release", "FREE")]


# --- rules ------------------------------------------------------------------------------------------------


def pulse(centre, width=0.005):
    return lambda t: np.where(np.abs(t - centre) < width, 1.0, 0.0)


def after(level):
    return lambda t: np.where(t < 0.3, 3.0, level)


RULES = {
    "first collision around 0.325 s": (forces.first_collision, trio(), PARTLY),
    "... centred on it": (forces.first_collision, trio(made(macros=[Macro(0.31, 0.34, 1, 1, 0, 1)])), REPRODUCED),
    "... elsewhere": (forces.first_collision, trio(made(macros=[Macro(0.4, 0.41, 1, 1, 0, 1)])), NOT),
    "equal friction": (
        forces.friction_coincides,
        trio(made(lambda_tau=pulse(0.32)), modified=made(lambda_tau=pulse(0.32))),
        REPRODUCED,
    ),
    "other friction": (
        forces.friction_coincides,
        trio(made(lambda_tau=pulse(0.31)), modified=made(lambda_tau=pulse(0.33))),
        NOT,
    ),
    "no difference at all": (
        forces.friction_differs_slightly,
        trio(made(lambda_tau=pulse(0.32)), modified=made(lambda_tau=pulse(0.32))),
        NOT,
    ),
    "normal forces apart at once": (
        forces.normal_coincides,
        trio(made(lambda_n=pulse(0.31)), made(lambda_n=pulse(0.33)), made(lambda_n=pulse(0.31))),
        NOT,
    ),
    "penetration": (forces.no_motion_across, trio(made(state=lambda t: 1.0, gap=lambda t: 1e-4)), NOT),
    "closed contact": (forces.no_motion_across, trio(made(state=lambda t: 1.0, gap=lambda t: 1e-12)), REPRODUCED),
    "friction without effect": (forces.friction_matters, trio(), NOT),
    "energy that grows": (energies.constant_before, trio(made(energy=lambda t: 3.0 + t)), NOT),
    "energy that stays": (energies.constant_before, trio(made(energy=lambda t: 3.0)), REPRODUCED),
    "no loss": (energies.considerable_loss, trio(made(energy=lambda t: 3.0)), NOT),
    "loss": (energies.considerable_loss, trio(made(energy=after(2.0))), REPRODUCED),
    "hybrid lowest": (
        energies.hybrid_loses_most,
        trio(made(energy=after(1.0)), made(energy=after(2.0)), made(energy=after(1.5))),
        REPRODUCED,
    ),
    "hybrid not lowest": (
        energies.hybrid_loses_most,
        trio(made(energy=after(1.6)), made(energy=after(2.0)), made(energy=after(1.5))),
        NOT,
    ),
    "frictionless highest": (
        energies.frictionless_loses_least,
        trio(made(energy=after(1.0)), made(energy=after(2.0)), made(energy=after(1.5))),
        REPRODUCED,
    ),
    "frictionless lowest": (
        energies.frictionless_loses_least,
        trio(made(energy=after(1.0)), made(energy=after(0.5)), made(energy=after(1.5))),
        NOT,
    ),
    "parts smaller": (
        energies.all_parts_smaller,
        trio(
            *(made(kinetic=after(level), elastic=after(level), gravity=after(level)) for level in (1.0, 2.0, 2.0))
        ),
        REPRODUCED,
    ),
    "one part larger": (
        energies.all_parts_smaller,
        trio(made(kinetic=after(3.0)), made(kinetic=after(2.0)), made(kinetic=after(2.0))),
        NOT,
    ),
    "no maximum": (motions.maximum_before, trio(made(slip=lambda t: t)), NOT),
    "maximum": (motions.maximum_before, trio(made(slip=lambda t: -((t - 0.2) ** 2))), REPRODUCED),
    "ranges fall": (motions.changes_shrink, trio(made(slip=lambda t: np.exp(-3.0 * t))), REPRODUCED),
    "ranges grow": (motions.changes_shrink, trio(made(slip=lambda t: np.exp(3.0 * t))), NOT),
    "different before": (motions.same_before, trio(made(theta=lambda t: 1.0 + t)), NOT),
    "never different": (motions.different_after, trio(), NOT),
    "no stick in the first": (motions.slip_only_first, trio(), REPRODUCED),
    "stick in the first": (
        motions.slip_only_first,
        trio(made([event(0.3, "impact", "SLIP"), event(0.31, "stick", "STICK"), event(0.34, "release", "FREE")])),
        NOT,
    ),
    "reversal at 0.325 s": (
        motions.direction_changes,
        trio(made([event(0.3252, "reversal", "SLIP")])),
        REPRODUCED,
    ),
    "reversal nearby": (motions.direction_changes, trio(made([event(0.3236, "reversal", "SLIP")])), PARTLY),
    "reversal elsewhere": (motions.direction_changes, trio(made([event(0.335, "reversal", "SLIP")])), NOT),
    "no later stick": (motions.sticks_later, trio(made(slip_in_second())), NOT),
    "stick at 0.699 s": (
        motions.sticks_at,
        trio(made(slip_in_second(event(0.6995, "stick", "STICK")))),
        REPRODUCED,
    ),
    "stick too early": (motions.sticks_at, trio(made(slip_in_second(event(0.69, "stick", "STICK")))), NOT),
    "stick too short": (
        motions.sticks_at,
        trio(made(slip_in_second(event(0.699, "stick", "STICK"), event(0.69901, "slip", "SLIP")))),
        NOT,
    ),
    "stick to the end": (
        motions.sticks_to_the_end,
        trio(made(slip_in_second(event(0.699, "stick", "STICK")))),
        REPRODUCED,
    ),
    "slip at the end": (
        motions.sticks_to_the_end,
        trio(made(slip_in_second(event(0.699, "stick", "STICK"), event(0.7, "slip", "SLIP")))),
        NOT,
    ),
    "starts with slip": (motions.slips_at_first, trio(made(slip_in_second())), REPRODUCED),
    "starts with stick": (motions.slips_at_first, trio(made([event(0.68, "impact", "STICK")])), NOT),
    "second collision there": (motions.second_contains, trio(), REPRODUCED),
    "second collision before": (
        motions.second_contains,
        trio(made(macros=[MACROS[0], Macro(0.6, 0.61, 1, 1, 0, 1)])),
        NOT,
    ),
    "nothing sticks": (motions.cannot_stick, trio(), NOT),
    "nothing interchanges": (motions.states_interchange, trio(made(slip_in_second())), NOT),
}


@pytest.mark.parametrize("name", RULES)
def test_rules_can_hold_and_fail(name):
    rule, runs, verdict = RULES[name]
    assert rule(runs).verdict == verdict


def test_times_are_written_in_their_unit():
    assert (milliseconds(0.0123), moment(0.69904)) == ("12.3 ms", "0.6990 s")


def test_verdicts_of_two_schemes_combine():
    assert combined([REPRODUCED, REPRODUCED]) == REPRODUCED
    assert combined([NOT, NOT]) == NOT
    assert combined([REPRODUCED, NOT]) == combined([PARTLY, NOT]) == combined([REPRODUCED, PARTLY]) == PARTLY
    assert [graded(x, 1.0, 2.0) for x in (1.0, 1.5, 2.5, float("nan"))] == [REPRODUCED, PARTLY, NOT, NOT]


def test_a_claim_is_judged_on_its_own_case():
    claim = Claim("c", "", "", "", lambda runs: Finding(REPRODUCED if runs == "b" else NOT, {}, ""), case="two")
    judged = judge([claim], {"one": {"s": "a"}, "two": {"s": "b"}})
    assert judged[0].verdict == REPRODUCED


def test_claims_that_every_choice_reproduces_do_not_discriminate():
    always, mostly = ("friction-coincides", "reproduced"), ("friction-matters", "reproduced")
    grid = [
        Robustness(None, dict([always, mostly]), (), (0.0,) * 4),
        Robustness(None, dict([always, (mostly[0], "not reproduced")]), (), (0.0,) * 4),
    ]
    found = [Judged(claim, {}) for claim in all_claims()]
    material = Material({}, {}, found, [], grid, (0.0, []))
    assert material.counts(mostly[0]) == {"reproduced": 1, "partly": 0, "not reproduced": 1}
    assert material.counts("states-interchange") == {}  # judged on a scenario that sticks
    assert [judged.claim.id for judged in found if not material.discriminates(judged.claim.id)] == [always[0]]
    assert material.undiscriminating == 1


def test_claims_have_names_of_their_own_and_say_their_rule():
    claims = all_claims()
    assert len({claim.id for claim in claims}) == len(claims)
    assert all(claim.rule and claim.statement.endswith(".") and "Sec" in claim.place for claim in claims)
    assert {claim.case for claim in claims} == {"paper", "sticking", "rough"}


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
    assert existing([1.0, 2.0, float("nan"), 3.0]) == [1.0, 2.0]
    assert increasing([1.0, 2.0, 3.0])
    assert not increasing([1.0, 1.0])
    assert not increasing([1.0])
    run = made(slip=lambda t: t)
    assert flight_ranges(run, "slip") == pytest.approx([0.3, 0.34, 0.29], abs=1e-9)
    assert smallest_share(run, [made(slip=lambda t: 0.5)], "slip", 0.0, 1.0) == pytest.approx(0.5, abs=1e-4)


def test_time_in_contact_and_share_of_stick():
    first = [event(0.3, "impact", "SLIP"), event(0.31, "stick", "STICK"), event(0.32, "release", "FREE")]
    again = [event(0.33, "impact", "SLIP"), event(0.34, "release", "FREE")]
    run = made([*first, *again])
    assert run.contact_time(MACROS[0]) == pytest.approx(0.03)
    assert stick_share(run, [MACROS[0]]) == pytest.approx(1.0 / 3.0)
    spans = contact_spans(run, MACROS[0])
    assert [(round(a, 3), round(b, 3), s.name) for a, b, s in spans] == [
        (0.3, 0.31, "SLIP"),
        (0.31, 0.32, "STICK"),
        (0.33, 0.34, "SLIP"),
    ]


# --- pictures ---------------------------------------------------------------------------------------------


def test_thinned_curves_keep_their_peaks_ends_and_jumps():
    times = np.linspace(0.0, 1.0, 50_001)
    values = np.sin(40.0 * times)
    values[31_337] = 9.0
    times[20_001] = times[20_000]  # a jump: two samples at one time
    values[20_000], values[20_001] = -5.0, 5.0
    t, v = thinned(times, values, 0.0, 1.0)
    assert t.size < 2_000
    assert v.max() == 9.0
    assert v.min() == -5.0
    assert t[0] == 0.0
    assert t[-1] == 1.0
    assert np.all(np.diff(t) >= 0.0)
    assert np.count_nonzero(t == times[20_000]) == 2


def test_all_figures_of_the_paper_are_there():
    assert {plot.number for plot in PLOTS} >= {str(n) for n in range(2, 17)}
    assert len({plot.name for plot in PLOTS}) == len(PLOTS)


# --- cases ------------------------------------------------------------------------------------------------


def test_every_choice_has_one_assumed_value_and_others():
    names = {(v.choice, v.label, v.assumed) for v, _, _ in variant_cases()}
    assumed = Counter(choice for choice, _, ours in names if ours)
    others = Counter(choice for choice, _, ours in names if not ours)
    assert set(assumed) == set(others)
    assert set(assumed.values()) == {1}
    keys = [case.key for _, _, case in variant_cases()]
    assert len(keys) == len(set(keys))


def test_assumed_values_are_the_papers_case():
    for variant, scheme, case in variant_cases():
        if variant.assumed:
            model = case.scenario.contact.friction
            assert case.scenario == paper(scheme, model)


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
    row = study(variant, scheme, run_case(case)).flat()
    assert row["choice"] == "number of modes"
    assert 0.31 < row["first_start"] < row["first_end"] < row["second_start"]
    assert row["first_normal_impulse"] > 0.0

"""Long steps of flights: weights against closed forms, motions and events against those of Runge-Kutta steps."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from oblique_impact import Scenario, simulate
from oblique_impact.beam.normal_modes import normal_modes
from oblique_impact.kernels.system import NormalModes
from oblique_impact.marching import leaps
from oblique_impact.marching.equations import SUPPLIED, derivative
from oblique_impact.marching.loop import Run, _Pace
from oblique_impact.marching.scheme import Leg
from oblique_impact.problem import beam_of, beam_problem

INTERVAL = 1e-3
#: rigid, slow, critically damped, fast and overdamped modes
MODES = NormalModes(
    np.eye(5),
    np.eye(5),
    np.array([0.0, 4.0, 100.0**2, 3000.0**2, 500.0**2]),
    np.array([0.0, 0.1, 200.0, 50.0, 4000.0]),
)
CASES = {
    "mean-axis": [],
    "damped": ["beam.kelvin_voigt=1e-5", "beam.mass_proportional=0.5"],
    "tangent": ["discretization.frame=tangent", "discretization.modes=8"],
    "full": ["discretization.modes=6", "discretization.kinetics=full"],
    "elements": ["discretization.method=fem", "discretization.elements=24"],
    "samples far apart": ["solver.output_interval=3e-3"],
    "samples close": ["solver.output_interval=7e-6"],
}


def test_weights_are_those_of_oscillators_under_a_polynomial():
    tables = leaps.new_leaps(MODES, INTERVAL)
    powers = np.array([1.0, -2.0, 0.5, 3.0])
    for level, h in enumerate(tables.lengths):
        tables.force[0] = np.polynomial.polynomial.polyval(tables.nodes, powers)
        tables.state[:] = [[0.3, -0.2, 0.1, 1e-3, 0.05], [1.0, 2.0, -3.0, 4.0, -5.0]]
        leaps._at(tables, level, leaps.POINTS - 2, 0, tables.ends)
        for k in range(5):

            def rates(t, y, k=k, h=h):
                f = np.polynomial.polynomial.polyval(t / h, powers)
                return [y[1], f - MODES.damping[k] * y[1] - MODES.stiffness[k] * y[0]]

            start = tables.state[:, k]
            exact = solve_ivp(rates, (0.0, h), start, "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
            np.testing.assert_allclose(tables.ends[:, k], exact, rtol=1e-9, atol=1e-10)
        inside = 2 ** max(round(np.log2(h / INTERVAL)), 0)
        np.testing.assert_allclose(tables.areas[level, leaps.POINTS - 2].sum(), h, rtol=1e-13)
        for m in range(1, inside):
            row = leaps.POINTS - 2 + m
            np.testing.assert_allclose(tables.areas[level, row].sum(), h * m / inside, rtol=1e-12)


def test_normal_modes_decouple_the_beam_at_rest():
    model = beam_of(Scenario.builtin("many-modes", ["beam.kelvin_voigt=1e-4"])).model
    modes = normal_modes(model)
    np.testing.assert_allclose(modes.projection @ modes.shapes, np.eye(17), atol=1e-12)
    assert modes.stiffness[0] < 1e-3 * modes.stiffness[1]
    np.testing.assert_allclose(modes.damping[1:], 1e-4 * modes.stiffness[1:], rtol=1e-9)


def without_leaps(monkeypatch):
    from oblique_impact.marching import event

    monkeypatch.setattr(event, "WORTHWHILE", np.inf)


@pytest.mark.parametrize("case", CASES)
def test_motions_are_those_of_small_steps(case, monkeypatch):
    """Up to the second contact, with the vibrations of the first one: of all of q, and the samples."""
    scenario = Scenario.builtin("many-modes", ["end_time=0.3178", *CASES[case]])
    monkeypatch.setattr("oblique_impact.marching.event.WORTHWHILE", 100.0)
    long = simulate(scenario)
    without_leaps(monkeypatch)
    # at the limit of their stability the short steps leave noise in damped modes, as large as the tolerance
    short = simulate(scenario.replace(solver__tolerance=1e-12))
    assert long.summary["steps"] < 0.5 * short.summary["steps"]
    assert [e.kind for e in long.events] == [e.kind for e in short.events]
    np.testing.assert_allclose([e.time for e in long.events], [e.time for e in short.events], rtol=0, atol=2e-11)
    assert long["time"].size == short["time"].size
    np.testing.assert_allclose(long["time"], short["time"], rtol=0, atol=2e-11)
    between = slice(0, long["time"].size - 4)
    for name, close in (("q", 5e-10), ("qd", 1e-6), ("energy_kinetic", 1e-8)):
        np.testing.assert_allclose(long[name][between], short[name][between], rtol=0, atol=close)
    energy = long.summary["energy"], short.summary["energy"]
    assert energy[0]["lost_damping"] == pytest.approx(energy[1]["lost_damping"], rel=1e-7, abs=1e-12)
    assert abs(energy[0]["unaccounted"]) < 1e-10


def test_no_contact_is_leapt_over(monkeypatch):
    """Sixteen modes on the rigid stop touch it 48 times within 0.4 s, some for a microsecond."""
    scenario = Scenario.builtin("many-modes", ["end_time=0.4"])
    long = simulate(scenario)
    without_leaps(monkeypatch)
    short = simulate(scenario)
    assert len(long.events) == len(short.events) > 40
    np.testing.assert_allclose([e.time for e in long.events], [e.time for e in short.events], rtol=0, atol=1e-8)
    assert float(long["gap"].min()) > -1e-11
    assert long.summary["steps"] < 0.2 * short.summary["steps"]


def test_a_leap_is_as_short_as_the_largest_speed_in_it_asks():
    """The gap rate known before it may be that of a turning point."""
    scenario = Scenario.builtin("many-modes", ["initial.angle=0.25", "initial.angular_velocity=1.0"])
    run = Run(beam_problem(beam_of(scenario)))
    problem, s, y = run.problem, run._scratch, run._y
    leg = Leg(1.0, problem.output_interval, 1000)
    flight = leaps.Flight(problem.system, run._phase, leg, 1e-6, s, s.tables)
    _, c = derivative(problem.system, run._phase, 0.0, y, s.work, s.K[0])
    for gap in (1e-4, 2e-4, 1.0):
        highest = s.tables.lengths.size - 1
        level, after = leaps.try_leap(flight, leaps.Position(0.0, gap, 0.0, 0, 0), y.copy(), highest, 1e-6)
        assert level >= 0
        assert gap > 2.0 * after.t * c.gap_rate
        derivative(problem.system, run._phase, 0.0, y, s.work, s.K[0])


@pytest.mark.parametrize(
    ("spin", "tolerance", "wanted"),
    [
        (3.0, 1e-4, 1),
        (3.0, 1e-5, 1),
        (3.0, 1e-6, 2),
        (3.0, 1e-8, 2),
        (3.0, 1e-9, 3),
        (60.0, 0.03, 1),
        (60.0, 5e-3, 2),
    ],
)
def test_rounds_end_when_another_one_would_change_nothing(spin, tolerance, wanted, monkeypatch):
    """How fast they contract is known from the rounds of this leap or of the one before."""
    run = Run(beam_problem(beam_of(Scenario.builtin("many-modes", [f"initial.angular_velocity={spin}"]))))
    problem, s, y = run.problem, run._scratch, run._y
    y[2:17] = 1e-3 * np.array([1.0, 0.3, -0.1, 0.03, *[1e-2 * (-1) ** k for k in range(11)]])
    flight = leaps.Flight(problem.system, run._phase, Leg(1.0, 1e-4, 1000), tolerance, s, s.tables)
    calls, level = [], s.tables.lengths.size - 1

    def counted(*arguments):
        calls.append(arguments)
        return derivative(*arguments)

    def leap(t, y):
        derivative(problem.system, run._phase, t, y, s.work, s.K[0])
        calls.clear()
        error, _ = leaps._leap(flight, t, y, level)
        assert np.isfinite(error)
        return s.y_new.copy(), len(calls) // (leaps.POINTS - 1)

    monkeypatch.setattr(leaps, "derivative", counted)
    h = s.tables.lengths[level]
    first, alone = leap(0.0, y)
    second, rounds = leap(h, first)
    # one round alone shows nothing; they contract by factors of 10,000 and of 30
    assert (alone, rounds) == (2, wanted)
    settled = 2.0 * leaps._SETTLED
    monkeypatch.setattr(leaps, "_SETTLED", 1e-8)
    for t, before, found in ((0.0, y, first), (h, first, second)):
        s.tables.memory[:] = np.inf
        exact, _ = leap(t, before)  # in as many rounds as it takes
        s.tables.ends[:] = (found - exact)[:34].reshape(2, 17) @ s.tables.projection.T
        assert leaps._norm(s.tables, before, s.scales, tolerance) < settled


def test_powers_are_those_of_the_motion(monkeypatch):
    """Of a driven beam: one round has its motion, but the powers are those of the motion before the round."""
    run = Run(beam_problem(beam_of(Scenario.builtin("spin-up"))))
    problem, s, y = run.problem, run._scratch, run._y
    flight = leaps.Flight(problem.system, run._phase, Leg(15.0, 0.01, 1000), 1e-9, s, s.tables)
    highest, supplied = s.tables.lengths.size - 1, 2 * problem.q0.size + SUPPLIED
    h = s.tables.lengths[highest]

    def leap(t, y):
        derivative(problem.system, run._phase, t, y, s.work, s.K[0])
        assert np.isfinite(leaps._leap(flight, t, y, highest)[0])
        return s.y_new.copy()

    before = y
    for k in range(3):
        y, before = leap(k * h, y), y
    s.tables.memory[:] = np.inf
    monkeypatch.setattr(leaps, "_SETTLED", 1e-8)
    assert y[supplied] == pytest.approx(leap(2 * h, before)[supplied], rel=1e-9)


@pytest.mark.parametrize("case", ["many-modes", "paper"])
def test_where_legs_end_changes_nothing(monkeypatch, case):
    """They end by the clock; a run is the same to the last bit on a machine that has other work to do."""
    scenario = Scenario.builtin(case, ["end_time=0.35"])
    whole = simulate(scenario)
    monkeypatch.setattr(_Pace, "_FIRST", 7)
    monkeypatch.setattr(_Pace, "learn", lambda *arguments: None)
    parts = simulate(scenario)
    assert parts.summary["steps"] == whole.summary["steps"]
    assert [e.time for e in parts.events] == [e.time for e in whole.events]
    np.testing.assert_array_equal(parts["q"], whole["q"])


def test_two_modes_do_without():
    assert simulate(Scenario.builtin("paper")).summary["steps"] > 7000

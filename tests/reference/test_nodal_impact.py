"""The full nodal model at rigid and elastic stops against exact laws and a geometrically exact code."""

from dataclasses import replace

import numpy as np
import pytest

import fem_beam
from oblique_impact import Outcome, Scenario, simulate
from oblique_impact.friction import Frictionless
from oblique_impact.integrators.base import Tolerances
from oblique_impact.marching import Run
from oblique_impact.nodal import FullBeam
from oblique_impact.simulate import full_beam_problem
from oblique_impact.system import LAMBDA_N
from oblique_impact.transitions import ContactMachine, EventKind, NewtonImpact, Transition

NODAL = (
    "solver.scheme=generalized-alpha",
    "discretization.method=fem",
    "discretization.modes=0",
    "discretization.frame=mean-axis",
)
# Benchmarks 5: a hinged beam with E I, m as below, turning as a rigid one, whose tip meets a stop at 3.77 m/s
BENDING, MASS, LENGTH, SPEED = 541.27, 0.86874, 1.0, 3.77
WAVE = np.sqrt(BENDING / MASS)  # c (m^2/s)
TURNING = (
    f"beam.density={MASS / 3.14e-4}",
    f"beam.youngs_modulus={BENDING / 7.85e-9}",
    "gravity=0.0",
    "slope.origin=[0.0, 0.0]",
    "slope.angle=0.0",
    "initial.angle=0.0",
    f"initial.angular_velocity={-SPEED}",
    "contact.friction=frictionless",
)


class HeldTip(ContactMachine):
    """A stop that also pulls: the tip stays where it meets it."""

    def touch(self, probe):
        return Transition(self._slide(0.0, 1), EventKind.IMPACT, self.impact.impulse(probe.instant, 0.0))


def held_tip(elements, step, rho, end_time):
    """Times, impulse and force of a beam whose tip is held from t = 0 on."""
    overrides = [
        *NODAL,
        *TURNING,
        f"discretization.elements={elements}",
        f"solver.free_step={step}",
        f"solver.contact_step={step}",
        f"solver.rho_infinity={rho}",
        f"solver.output_interval={step}",
        f"end_time={end_time}",
    ]
    scenario = Scenario.builtin("paper", overrides)
    problem = full_beam_problem(FullBeam(scenario, fem_beam.build_nodal(scenario)))
    machine = HeldTip(Frictionless(), NewtonImpact(), tolerances=Tolerances(force=np.inf))
    record = Run(replace(problem, machine=machine)).execute()
    assert record.outcome is Outcome.COMPLETED
    times = np.concatenate([s.times for s in record.segments])
    impulse = np.concatenate([s.states[:, 2 * problem.q0.size] for s in record.segments])
    force = np.concatenate([s.observation.scalars[:, LAMBDA_N] for s in record.segments])
    return times, impulse + record.events[0].normal_impulse, force


def exact_impulse(t):
    """Benchmark 5b: J(t) = (2 m L v0/pi^2) sum (1 - cos n^2 w1 t)/n^2, w1 = pi^2 c/L^2."""
    n = np.arange(1, 40_001)
    terms = (1.0 - np.cos(n**2 * np.pi**2 * WAVE / LENGTH**2 * t)) / n**2
    return 2.0 * MASS * LENGTH * SPEED / np.pi**2 * terms.sum()


def test_series_has_its_closed_values():
    """J = m L v0/4 and m L v0/2 after a quarter and half of the first period."""
    period = 2.0 / np.pi * LENGTH**2 / WAVE
    assert exact_impulse(period / 4.0) == pytest.approx(MASS * LENGTH * SPEED / 4.0, rel=1e-4)
    assert exact_impulse(period / 2.0) == pytest.approx(MASS * LENGTH * SPEED / 2.0, rel=1e-4)


@pytest.mark.parametrize("elements", [32, 64, 128])
@pytest.mark.parametrize("rho", [0.0, 0.5])
def test_impulse_on_a_rigid_stop(elements, rho):
    """Benchmark 5b with the step of theory Sec. 7a, 0.4 h^2/c."""
    step = 0.4 * (LENGTH / elements) ** 2 / WAVE
    times, impulse, _ = held_tip(elements, step, rho, 2.05e-3)
    for t in (1e-3, 2e-3):
        assert np.interp(t, times, impulse) == pytest.approx(exact_impulse(t), rel=0.02)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8])
def test_impulse_on_a_rigid_stop_at_any_dissipation(rho):
    step = 0.4 * (LENGTH / 128) ** 2 / WAVE
    times, impulse, _ = held_tip(128, step, rho, 2.05e-3)
    for t in (1e-3, 2e-3):
        assert np.interp(t, times, impulse) == pytest.approx(exact_impulse(t), rel=0.02)


@pytest.mark.parametrize(("rho", "opens", "closes"), [(0.0, 5, 1.4), (0.5, 8, 1.15), (0.8, 77, 1.07)])
@pytest.mark.parametrize("elements", [64, 128])
def test_window_of_the_pointwise_force(elements, rho, opens, closes):
    """Benchmark 5d: F = (E I)^(1/4) m^(3/4) v0/sqrt(2 pi t) within 5 % from `opens` dt to `closes` L (dt/c)^.5."""
    step = 0.6 * (LENGTH / elements) ** 2 / WAVE  # at least 0.4 h^2/c
    times, _, force = held_tip(elements, step, rho, 2e-3)
    window = (times > opens * step) & (times < closes * LENGTH * np.sqrt(step / WAVE))
    assert window.sum() > 2 or rho == 0.8
    law = BENDING**0.25 * MASS**0.75 * SPEED / np.sqrt(2.0 * np.pi * times[window])
    np.testing.assert_allclose(force[window], law, rtol=0.05)


@pytest.mark.parametrize("elements", [16, 64, 256])
def test_effective_mass_of_the_tip(elements):
    """Benchmark 5c: the first impulse is 0.0722100668 m h v0, its energy half of that times v0."""
    scenario = Scenario.builtin(
        "paper",
        [*NODAL, *TURNING, f"discretization.elements={elements}", "end_time=1e-9", "solver.free_step=1e-9"],
    )
    event = simulate(scenario).events[0]
    effective = 0.0722100668103 * MASS * LENGTH / elements
    assert event.normal_impulse == pytest.approx(effective * SPEED, rel=1e-8)
    assert event.energy_loss == pytest.approx(0.5 * effective * SPEED**2, rel=1e-8)


@pytest.fixture(scope="module")
def on_a_spring(run):
    return run(
        "paper",
        *NODAL,
        "contact.normal=spring",
        "contact.friction=frictionless",
        "solver.free_step=1e-5",
        "solver.contact_step=2e-6",
        "solver.rho_infinity=0.9",
        "solver.output_interval=1e-5",
        "end_time=0.87",
    )


def test_paper_beam_on_a_spring(on_a_spring):
    """Theory Sec. 7a: a geometrically exact extensible code at k = 1e6 N/m; 32 elements."""
    first, second = on_a_spring.summary["macro_collisions"][:2]
    assert first["normal_impulse"] == pytest.approx(2.140259, rel=1e-3)
    assert first["peak_force"] == pytest.approx(924.45, rel=5e-3)
    assert second["start"] == pytest.approx(0.86535, abs=2e-3)
    starts = [e.time for e in on_a_spring.events if e.kind is EventKind.IMPACT][:5]
    ends = [e.time for e in on_a_spring.events if e.kind is EventKind.RELEASE][:5]
    assert starts == pytest.approx([0.317147, 0.320816, 0.324809, 0.326045, 0.328510], abs=2e-5)
    assert ends == pytest.approx([0.320131, 0.321611, 0.325811, 0.326719, 0.329274], abs=2e-5)


def test_ledger_names_the_loss_of_the_scheme(on_a_spring):
    energy = on_a_spring.summary["energy"]
    assert energy["lost_impact"] == energy["lost_friction"] == 0.0
    assert energy["lost_scheme"] > 1e-6  # rho 0.9 takes some of what the impact excites
    # the work of the geometric terms and of the spring is sampled to second order: 2e-6 of the energy
    assert abs(energy["unaccounted"]) < 0.05 * energy["lost_scheme"]


@pytest.mark.parametrize("friction", ["frictionless", "hybrid", "modified-coulomb"])
@pytest.mark.parametrize("rho", [0.0, 0.8])
def test_rigid_stop_does_not_drift(run, friction, rho):
    history = run(
        "paper",
        *NODAL,
        "discretization.elements=16",
        f"contact.friction={friction}",
        f"solver.rho_infinity={rho}",
        "solver.free_step=1e-5",
        "solver.output_interval=1e-6",
        "end_time=0.333",
    )
    assert history.outcome is Outcome.COMPLETED
    closed = history["state"].values > 0
    assert closed.sum() > 1000
    assert np.abs(history["gap"].values[closed]).max() < 1e-9
    assert history["gap"].values.min() > -1e-9
    energy = history.summary["energy"]
    assert abs(energy["unaccounted"]) < 1e-4
    assert energy["lost_friction"] >= 0.0
    # a rigid stop has no limit in the number of modes; the impulse of the first collision settles near 1.87 N s
    assert 1.8 < history.summary["macro_collisions"][0]["normal_impulse"] < 1.95


def test_sticking_on_a_rigid_stop_holds_both_constraints(run):
    """mu = 12: nine sticks in one collision; neither gap nor slip drifts while the tip sticks."""
    history = run(
        "paper",
        *NODAL,
        "discretization.elements=3",
        "contact.mu_static=12.0",
        "contact.mu_kinetic=12.0",
        "solver.free_step=1e-5",
        "solver.output_interval=1e-5",
        "end_time=0.34",
    )
    assert history.outcome is Outcome.COMPLETED
    assert [event.kind for event in history.events].count(EventKind.STICK) >= 8
    state, slip, gap = (history[name].values for name in ("state", "slip", "gap"))
    sticks = np.flatnonzero(state == 2)
    assert sticks.size > 100
    for stick in np.split(sticks, np.flatnonzero(np.diff(sticks) > 1) + 1):
        assert np.ptp(slip[stick]) < 1e-9
        assert np.abs(gap[stick]).max() < 1e-9
        tangential, normal = (history[name].values[stick] for name in ("lambda_tau", "lambda_n"))
        assert np.all(np.abs(tangential) <= 12.0 * normal * (1.0 + 1e-6) + 1e-6)


def test_both_schemes_stick_alike(run):
    """The built-in case with a long stick, three modes: the same events, their times within the step's error."""
    alpha = run("sticking", "solver.scheme=generalized-alpha", "solver.free_step=1e-5")
    event = run("sticking")
    assert [e.kind for e in alpha.events] == [e.kind for e in event.events]
    assert EventKind.STICK in {e.kind for e in alpha.events}
    np.testing.assert_allclose([e.time for e in alpha.events], [e.time for e in event.events], atol=2e-6)

"""Located events on closed-form motions, and no event lost inside a step; orders are checked by `validation`."""

import math

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from scipy.integrate import DOP853, solve_ivp
from scipy.special import ellipj, ellipk, ellipkinc

from oblique_impact import MechanicalSystem, simulate_system
from oblique_impact.contact.impacts import NewtonImpact
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.kernels.system import ContactRows
from oblique_impact.marching import dop853_table
from oblique_impact.marching.event import EventScheme
from oblique_impact.marching.fixed_step import FixedStepScheme
from oblique_impact.marching.generalized_alpha import GeneralizedAlphaScheme
from oblique_impact.validation.small_systems import Particle
from tests.systems import Block, Prescribed


def test_samples_are_multiples_of_the_interval_and_the_two_sides_of_events():
    for scheme in (EventScheme(1e-10), FixedStepScheme(1e-2, 1e-3)):
        history = simulate_system(
            Particle(above=-9.8), [0.0, 0.3], [1.0, 0.0], 0.5, scheme=scheme, output_interval=0.02
        )
        time = history["time"].values
        assert np.all(np.diff(time) > 0.0)
        events = np.array([event.time for event in history.events])
        assert np.isin(events, time).all()
        assert np.isin(np.nextafter(events, 1.0), time).all()
        grid = np.setdiff1d(time, [*events, *np.nextafter(events, 1.0)])
        assert np.allclose(grid, 0.02 * np.arange(26)[np.isin(np.arange(26), np.round(grid / 0.02))], atol=1e-15)
        assert grid.size >= 25


def test_the_coefficients_are_those_of_scipy():
    a = np.zeros((16, 16))
    a[:12, :12], a[12, :12], a[13:] = DOP853.A, DOP853.B, DOP853.A_EXTRA
    assert np.array_equal(dop853_table.A, a)
    assert np.array_equal(dop853_table.C, [*DOP853.C, 1.0, *DOP853.C_EXTRA])
    for name in ("E3", "E5", "D"):
        assert np.array_equal(getattr(dop853_table, name), getattr(DOP853, name))


# Located events ------------------------------------------------------------------------------------------------


class Pendulum(MechanicalSystem):
    """theta'' = -sin theta against a stop at angle -stop."""

    size = 1

    def __init__(self, stop):
        self.stop = stop

    def mass_matrix(self, t, q):
        return np.eye(1)

    def forces(self, t, q, qd):
        return -np.sin(q)

    def contact(self, t, q, qd):
        return ContactRows(q[0] + self.stop, 0.0, qd[0], 0.0, np.ones(1), np.zeros(1))

    def energy(self, t, q, qd):
        return 0.5 * float(qd[0]) ** 2, 0.0, 1.0 - math.cos(q[0])


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10, 1e-12])
def test_pendulum_between_bounces(tolerance):
    """From rest at 2.5 rad to an elastic stop at -1: quarter periods and elliptic integrals."""
    k = math.sin(1.25)
    to_stop = ellipk(k * k) + ellipkinc(math.asin(math.sin(0.5) / k), k * k)
    history = simulate_system(
        Pendulum(1.0), [2.5], [0.0], 3.1 * to_stop, impact_law=NewtonImpact(1.0), scheme=EventScheme(tolerance)
    )
    error = max(10.0 * tolerance, 1e-11)
    assert [event.time for event in history.events] == pytest.approx([to_stop, 3.0 * to_stop], abs=error)
    speed = math.sqrt(2.0 * (math.cos(1.0) - math.cos(2.5)))
    assert [event.normal_velocity for event in history.events] == pytest.approx([-speed] * 2, rel=error)
    early = history["time"].values < to_stop
    _, cn, dn, _ = ellipj(history["time"].values[early], k * k)
    error = np.abs(history["q"].values[early, 0] - 2.0 * np.arcsin(k * cn / dn)).max()
    # a tolerance that changed nothing would show here
    assert 1e-5 * tolerance < error < max(tolerance, 1e-11)


# Nothing lost inside a step ------------------------------------------------------------------------------------

# A first step is 1/1000 of the output interval and s'' = 0 is integrated without error: one step covers it all.
END = 1.5


def first_event(system):
    """First event of a slow variable that would run from 0 to END at 1 m/s in a single step."""
    history = simulate_system(system, [0.0], [1.0], END, impact_law=NewtonImpact(1.0), output_interval=1e3 * END)
    if not history.events:
        assert history.summary["steps"] == 1
        return None
    return history.events[0]


def polynomial_gap(roots):
    gap = Polynomial.fromroots(roots)
    return Prescribed(gap, gap.deriv(), gap.deriv(2))


@pytest.mark.parametrize("width", [0.1, 1e-2, 1e-4])
@pytest.mark.parametrize("places", [(0.02, 0.3), (0.1, 0.55), (0.2, 0.76), (0.28, 0.78), (0.51, 0.9)])
def test_of_two_dips_inside_a_step_the_first_is_found(places, width):
    roots = END * np.array([places[0], places[0] + width, places[1], places[1] + width])
    event = first_event(polynomial_gap(np.sort(roots)))
    # a dip of width d and depth d^2 is crossed at a slope of d: rounding of the gap counts as much as 1e-15/d
    assert event.time == pytest.approx(roots[0], abs=max(1e-11, 1e-14 / width))


@pytest.mark.parametrize("depth", [1e-2, 1e-5, 1e-8])
def test_a_shallow_dip_that_reaches_zero_is_an_event(depth):
    for place in np.linspace(0.12, END, 23):
        parabola = Prescribed(
            lambda s, p=place: (s - p) ** 2 - depth, lambda s, p=place: 2.0 * (s - p), lambda s: 2.0
        )
        assert first_event(parabola).time == pytest.approx(place - math.sqrt(depth), abs=1e-11)


class Table(MechanicalSystem):
    """A ball over a table that moves up at 2 m/s."""

    size = 1

    def mass_matrix(self, t, q):
        return np.eye(1)

    def forces(self, t, q, qd):
        return np.array([-9.8])

    def contact(self, t, q, qd):
        return ContactRows(q[0] - 2.0 * t, 0.0, qd[0] - 2.0, 0.0, np.ones(1), np.zeros(1))

    def energy(self, t, q, qd):
        return 0.5 * float(qd[0]) ** 2, 0.0, 9.8 * float(q[0])


def test_moving_table_balances_its_energy():
    """An elastic table moving up at 2 m/s returns a ball that falls at 3 m/s at 7 m/s."""
    history = simulate_system(Table(), [0.0], [-3.0], 0.01, impact_law=NewtonImpact(1.0), output_interval=1e-3)
    assert history.events[0].time == 0.0
    assert float(history["qd"][1, 0]) == pytest.approx(7.0, rel=1e-12)
    energy = history.summary["energy"]
    assert energy["lost_impact"] == pytest.approx(0.0, abs=1e-12)
    assert energy["supplied"] == pytest.approx(0.5 * (49.0 - 9.0), rel=1e-12)
    assert abs(energy["unaccounted"]) < 1e-11


class Shaken(MechanicalSystem):
    """A mass of 0.5 kg on a spring in a box that is moved as X = 0.2 sin(3 t); its oil is thick to one side.

    m q'' = -k q - c (1 + 10^4 q^2) q' - m X'', k = 40 N/m; the box does the work of m (q'' + X'') X'.
    """

    size, mass, stiffness = 1, 0.5, 40.0

    def __init__(self, damping):
        self.damping = damping

    def box(self, t):
        return 0.6 * math.cos(3.0 * t), -1.8 * math.sin(3.0 * t)

    def mass_matrix(self, t, q):
        return self.mass * np.eye(1)

    def forces(self, t, q, qd):
        return -self.stiffness * q - self.damping_matrix(t, q)[0] * qd - self.mass * self.box(t)[1]

    def contact(self, t, q, qd):
        return ContactRows(q[0] + 10.0, 0.0, qd[0], 0.0, np.ones(1), np.zeros(1))

    def energy(self, t, q, qd):
        kinetic = 0.5 * self.mass * float(qd[0] + self.box(t)[0]) ** 2
        return kinetic, 0.5 * self.stiffness * float(q[0]) ** 2, 0.0

    def damping_power(self, t, q, qd):
        return float(self.damping_matrix(t, q)[0, 0] * qd[0] ** 2)

    def supplied_power(self, t, q, qd, qdd):
        speed, acceleration = self.box(t)
        return self.mass * float(qdd[0] + acceleration) * speed

    def stiffness_matrix(self, t, q):
        return self.stiffness * np.eye(1)

    def damping_matrix(self, t, q):
        return self.damping * (1.0 + 1e4 * q[0] ** 2) * np.eye(1)


def shaken(damping, scheme):
    """Where the mass is after a second from 0.1 m, and the work that is supplied, lost and unaccounted."""
    options = {"contact_law": ElasticStop(1.0), "scheme": scheme, "output_interval": 0.5}
    history = simulate_system(Shaken(damping), [0.1], [0.0], 1.0, **options)
    energy = history.balance
    return float(history["q"][-1, 0]), energy["supplied"], energy["lost_damping"], energy["unaccounted"]


@pytest.mark.parametrize(("damping", "step", "order"), [(0.2, 2e-3, 1.8), (20.0, 2e-2, 1.1)])
def test_what_a_shaken_box_does_and_its_oil_takes_is_the_energy_of_the_mass(damping, step, order):
    """The work depends on q'', the damping on q; SciPy's DOP853 says where the mass is and what is done.

    Thick oil stops the mass within 0.25 ms, which no step of 20 ms takes without the damping matrix; what is lost
    in so short a time is then not of the second order.
    """
    system = Shaken(damping)

    def rates(t, y):
        qd = y[1:2]
        qdd = system.forces(t, y[:1], qd) / system.mass
        return [qd[0], qdd[0], system.supplied_power(t, y[:1], qd, qdd), system.damping_power(t, y[:1], qd)]

    end = solve_ivp(rates, (0.0, 1.0), [0.1, 0.0, 0.0, 0.0], "DOP853", rtol=1e-12, atol=1e-14).y[[0, 2, 3], -1]
    found = shaken(damping, EventScheme(1e-12))
    assert found[:3] == pytest.approx(end, abs=1e-9)
    assert abs(found[3]) < 1e-10
    errors = []
    for h in (step, step / 2.0, step / 4.0):
        found = shaken(damping, GeneralizedAlphaScheme(h, h))
        errors.append(np.abs(np.subtract(found, [*end, 0.0])))
    assert np.all(errors[0] < 1e-4)
    assert np.all(np.log2(np.divide(errors[:-1], errors[1:])) > [1.8, 1.8, order, 1.8])


# Starts and flights shorter than a step ------------------------------------------------------------------------


@pytest.mark.parametrize("gap", [-1e-18, 0.0, 1e-18])
def test_a_flight_that_starts_at_rounding_below_zero_and_falls_hits(gap):
    """y'' = 1e-6 - t lifts the block by 7e-19 m, then it falls: it must not go through the plane."""
    block = Block(lambda t, q, qd: (0.0, 1e-6 - t))
    history = simulate_system(block, [0.0, gap], [0.0, 0.0], 1e-2, output_interval=1e-3)
    assert history.events[0].kind.value == "impact"
    # the gap tolerance, 1e-12 m, is used up after (6e-12)^(1/3) s
    assert history.events[0].time <= 1.01 * 6e-12 ** (1 / 3)
    assert float(history["gap"].min()) >= -1.01e-12


def test_breakpoints():
    """A force that starts to grow at a breakpoint between two steps: both schemes must stop there."""
    start = 0.2345
    block = Block(lambda t, q, qd: (max(t - start, 0.0), 0.0))
    for scheme in (EventScheme(1e-10), FixedStepScheme(1e-2, 1e-2)):
        history = simulate_system(
            block, [0.0, 1.0], [1.0, 0.0], 1.0, scheme=scheme, breakpoints=(start,), output_interval=0.1
        )
        time = history["time"].values
        assert time[-1] == 1.0
        assert float(history["slip"][-1]) == pytest.approx(1.0 + (1.0 - start) ** 3 / 6.0, abs=1e-12)
        speed = 1.0 + 0.5 * np.maximum(time - start, 0.0) ** 2
        assert history["slip_rate"].values == pytest.approx(speed, abs=1e-12)

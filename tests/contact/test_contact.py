"""Contact forces and impulses against dense linear algebra and closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from oblique_impact.contact.forces import MASS_NOT_POSITIVE, NO_SLIDING_SOLUTION, OK, accelerate, guards_of
from oblique_impact.contact.friction import Branch
from oblique_impact.contact.impacts import newton_impulse, routh_impulse
from oblique_impact.contact.state import Baumgarte, Instant, Phase, State, Stick, Surface
from oblique_impact.kernels.system import ContactRows, MechanicalSystem
from oblique_impact.marching.sampling import contact_problem

OPEN = Phase()
STABILIZED = Baumgarte(20.0, 1e4)


def sliding(intercept, slope=0.0, lower=-np.inf, upper=np.inf, **others):
    return Phase(int(State.SLIP), friction=Branch(intercept, slope, lower, upper), **others)


def sticking(static=0.3, slip=0.0, **others):
    return Phase(int(State.STICK), stick=Stick(static, slip), **others)


class Random(MechanicalSystem):
    """A dense system with arbitrary mass, forces and contact rows."""

    def __init__(self, size, seed):
        rng = np.random.default_rng(seed)
        self.size = size
        root = rng.normal(size=(size, size))
        self.M = root @ root.T + 0.5 * np.eye(size)
        self.Q = rng.normal(size=size)
        self.normal, self.tangential = rng.normal(size=(2, size))
        self.biases = rng.normal(size=2)
        self.kinematics = 1e-3 * rng.normal(size=4)

    def mass_matrix(self, t, q):
        return self.M

    def forces(self, t, q, qd):
        return self.Q

    def contact(self, t, q, qd):
        return ContactRows(*self.kinematics, self.normal, self.tangential, *self.biases)

    def energy(self, t, q, qd):
        return 0.0, 0.0, 0.0


def solve(system, phase):
    """Status, contact with its forces and acceleration."""
    work, zero = system.new_workspace(), np.zeros(system.size)
    status, instant = accelerate(system, phase, 0.0, zero, zero, work)
    return status, instant, work.vectors.acceleration


def forces(instant):
    return [instant.normal_force, instant.tangential_force]


def stabilized(system, phase):
    """Right-hand sides of both constraints, with Baumgarte's terms."""
    gap, slip, gap_rate, slip_rate = system.kinematics
    damping, stiffness = phase.stabilization
    normal = damping * gap_rate + stiffness * gap
    tangential = damping * slip_rate + stiffness * (slip - phase.stick.slip)
    return np.array([-system.biases[0] - normal, -system.biases[1] - tangential])


SYSTEMS = [(size, seed) for size in (2, 3, 7) for seed in range(6)]


def kkt(system, rows, push, right):
    """Solve M q'' - push^T lambda = Q, rows q'' = right: acceleration and multipliers."""
    matrix = np.block([[system.M, -push.T], [rows, np.zeros((len(rows), len(rows)))]])
    return np.split(np.linalg.solve(matrix, np.concatenate([system.Q, right])), [system.size])


@pytest.mark.parametrize(("size", "seed"), SYSTEMS)
def test_forces_and_accelerations_solve_the_dense_system_or_say_painleve(size, seed):
    system = Random(size, seed)
    status, instant, acceleration = solve(system, OPEN)
    assert (status, forces(instant)) == (OK, [0.0, 0.0])
    assert_allclose(acceleration, np.linalg.solve(system.M, system.Q), rtol=1e-11, atol=1e-12)

    phase, rows = sticking(slip=2e-3, stabilization=STABILIZED), np.stack([system.normal, system.tangential])
    status, instant, acceleration = solve(system, phase)
    expected, multipliers = kkt(system, rows, rows, stabilized(system, phase))
    assert status == OK
    assert_allclose(acceleration, expected, rtol=1e-9, atol=1e-9)
    assert_allclose(forces(instant), multipliers, rtol=1e-9)

    phase = sliding(-0.8, 40.0, stabilization=STABILIZED)
    ratio = -0.8 + 40.0 * system.kinematics[3]
    status, instant, acceleration = solve(system, phase)
    push = system.normal + ratio * system.tangential
    if system.normal @ np.linalg.solve(system.M, push) <= 0.0:
        assert status == NO_SLIDING_SOLUTION
        return
    expected, multipliers = kkt(system, rows[:1], push[None], stabilized(system, phase)[:1])
    assert status == OK
    assert_allclose(acceleration, expected, rtol=1e-8, atol=1e-8)
    assert_allclose(forces(instant), [multipliers[0], ratio * multipliers[0]], rtol=1e-8)


def test_no_force_without_a_definite_mass():
    system = Random(3, 0)
    system.M = system.M - 2.0 * np.linalg.eigvalsh(system.M)[0] * np.eye(3)
    assert np.linalg.eigvalsh(system.M)[0] < 0.0
    for phase in (OPEN, sliding(0.0), sticking()):
        assert solve(system, phase)[0] == MASS_NOT_POSITIVE


def instant_from(system):
    zero = np.zeros(system.size)
    defined, _, instant = contact_problem(system, 0.0, zero, zero, system.new_workspace())
    assert defined
    return instant


@pytest.mark.parametrize(("size", "seed"), SYSTEMS[:6])
def test_guards_are_positive_inside_their_state(size, seed):
    system = Random(size, seed)
    slip_rate = system.kinematics[3]

    def guards(phase):
        instant = solve(system, phase)[1]
        return guards_of(phase, instant), instant

    free, c = guards(OPEN)
    assert_allclose(free, [c.gap, 1.0, 1.0, 1.0, 1.0])
    below = guards(Phase(surface=Surface(side=-1.0)))[0]  # the line of the slope, beyond an end
    assert_allclose(below, [-c.gap, 1.0, 1.0, 1.0, 1.0])
    assert_allclose(guards(Phase(surface=Surface(enabled=False)))[0], np.ones(5))
    slip, c = guards(sliding(0.1, 2.0, -0.5, 0.25))
    definite = 1.0 + (0.1 + 2.0 * slip_rate) * c.a_nt / c.a_nn
    assert c.slip_rate == slip_rate
    assert_allclose(slip, [c.normal_force, slip_rate + 0.5, 0.25 - slip_rate, definite, 1.0], rtol=1e-6)
    stick, c = guards(sticking(0.6))
    room, tangential = 0.6 * c.normal_force, c.tangential_force
    assert_allclose(stick, [c.normal_force, room - tangential, room + tangential, 1.0, 1.0])
    for phase in (sliding(0.0), sticking(0.6)):
        for first, last in ((c.slip - 0.1, c.slip + 0.2), (c.slip + 0.1, c.slip + 0.2)):
            ends = guards(phase._replace(surface=Surface(first=first, last=last)))[0].end
            assert (ends > 0.0) == (first < c.slip < last)


# Impulses ---------------------------------------------------------------------------------------------------


def kinetic_loss(system, velocity, impulse):
    """Loss of 1/2 v M v under the velocity jump of an impulse, by dense algebra."""
    push = impulse.normal * system.normal + impulse.tangential * system.tangential
    after = velocity + np.linalg.solve(system.M, push)
    return 0.5 * velocity @ system.M @ velocity - 0.5 * after @ system.M @ after, after


def approaching(size, seed):
    """A system whose contact closes, with its generalized velocity."""
    system = Random(size, seed)
    velocity = np.random.default_rng(seed + 100).normal(size=size)
    if system.normal @ velocity > 0.0:
        velocity = -velocity
    system.kinematics = [0.0, 0.0, system.normal @ velocity, system.tangential @ velocity]
    return system, velocity


@pytest.mark.parametrize(("size", "seed"), SYSTEMS)
@pytest.mark.parametrize("restitution", [0.0, 0.3, 1.0])
def test_newton_impulse(size, seed, restitution):
    system, velocity = approaching(size, seed)
    instant = instant_from(system)
    impulse = newton_impulse(instant, restitution)
    loss, after = kinetic_loss(system, velocity, impulse)
    assert impulse.tangential == 0.0
    assert system.normal @ after == pytest.approx(-restitution * instant.gap_rate, abs=1e-11)
    assert impulse.energy_loss == pytest.approx(loss, rel=1e-9, abs=1e-10)
    # closed form: 1/2 m_eff (1 - e^2) v^2
    closed = 0.5 * (1.0 - restitution**2) * instant.gap_rate**2 / instant.a_nn
    assert impulse.energy_loss == pytest.approx(closed, rel=1e-10, abs=1e-12)


@pytest.mark.parametrize(
    ("a_nt", "mu", "expected"), [(0.5, 0.6, "sticks"), (0.5, 0.2, "reverses"), (-0.5, 0.2, "on")]
)
def test_routh_after_the_slip_has_stopped(a_nt, mu, expected):
    """Slip -0.1 in, a_nn = a_tt = 1: the path by hand, piece by piece."""
    gap_rate, slip_rate = -1.0, -0.1
    impulse = routh_impulse(Instant(0.0, 0.0, gap_rate, slip_rate, 1.0, a_nt, 1.0, -9.8, 0.0), 0.0, mu)
    slip_growth, gap_growth = a_nt + mu, 1.0 + mu * a_nt
    if expected == "on":
        # friction and coupling work against each other: a_nt + mu < 0, the slip grows in its direction
        assert slip_growth < 0.0
        normal = 1.0 / gap_growth
        assert impulse.normal == pytest.approx(normal, rel=1e-14)
        assert impulse.tangential == pytest.approx(mu * normal, rel=1e-14)
        return
    first = 0.1 / slip_growth
    ratio = -a_nt if expected == "sticks" else -mu
    second = (1.0 - gap_growth * first) / (1.0 + ratio * a_nt)
    assert impulse.normal == pytest.approx(first + second, rel=1e-14)
    assert impulse.tangential == pytest.approx(mu * first + ratio * second, rel=1e-14)
    slip_after = slip_rate + a_nt * impulse.normal + impulse.tangential
    assert slip_after == pytest.approx(0.0 if expected == "sticks" else (a_nt - mu) * second, abs=1e-14)


@pytest.mark.parametrize(("size", "seed"), SYSTEMS)
@pytest.mark.parametrize("restitution", [0.0, 0.6])
def test_routh_stays_in_the_cone_and_loses_energy(size, seed, restitution):
    system, velocity = approaching(size, seed)
    impulse = routh_impulse(instant_from(system), restitution, 0.2)
    loss, after = kinetic_loss(system, velocity, impulse)
    assert abs(impulse.tangential) <= 0.2 * impulse.normal * (1.0 + 1e-12)
    assert impulse.energy_loss == pytest.approx(loss, rel=1e-9, abs=1e-10)
    assert loss >= -1e-12
    assert system.normal @ after >= -1e-12


def test_routh_passes_a_painleve_configuration():
    """a_nn - mu a_nt < 0: sliding drives the bodies together, but the slip stops before compression ends."""
    instant = Instant(0.0, 0.0, -1.0, 1.0, 1.0, 0.8, 1.0, -9.8, 0.0)
    impulse = routh_impulse(instant, 0.0, 1.5)
    first = 1.0 / (1.5 * 1.0 - 0.8)  # until the slip stops; then |a_nt| < mu a_tt: it sticks
    second = (1.0 + (1.5 * 0.8 - 1.0) * first) / (1.0 - 0.8**2)
    assert impulse.normal == pytest.approx(first + second, rel=1e-14)
    assert impulse.tangential == pytest.approx(-1.5 * first - 0.8 * second, rel=1e-14)

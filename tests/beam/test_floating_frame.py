"""The beam's mass matrix, forces and contact rows against energies and kinematics, by differentiation alone."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from oblique_impact import Scenario
from oblique_impact.beam.beam import Beam
from oblique_impact.beam.operators import build_operators
from oblique_impact.contact.forces import touched
from oblique_impact.kernels.workspace import SUPPLY, dot

PIN = {}
HUB = {"root__kind": "hub", "root__inertia": 0.02, "root__torque": 1.7}
HUB_RADIUS = {**HUB, "root__hub_radius": 0.15}
DRIVEN = {
    "root__kind": "driven",
    "root__profile": "spin-up",
    "root__spin_rate": 5.0,
    "root__spin_up_time": 0.5,
    "root__hub_radius": 0.15,
}
CASES = {
    f"{kinetics}, {frame}, {name}": {
        "discretization__kinetics": kinetics,
        "discretization__frame": frame,
        "discretization__modes": 3,
        **root,
    }
    for kinetics in ("zeroth-order", "first-order", "full")
    for frame, name, root in [
        ("tangent", "pin", PIN),
        ("mean-axis", "pin", PIN),
        ("tangent", "hub", HUB),
        ("mean-axis", "hub", HUB),
        ("tangent", "hub radius", HUB_RADIUS),
        ("tangent", "driven", DRIVEN),
    ]
}
FREE = [name for name in CASES if not name.endswith("driven")]
T = 0.2  # s, in the middle of the spin-up


def beam_of(name, **changes):
    scenario = Scenario().replace(**{"contact__point": 0.8, **CASES[name], **changes})
    return Beam(scenario, build_operators(scenario))


def states(beam, seed=0, size=3e-3):
    """Random q and q': deflections of centimetres, turning at some rad/s."""
    rng = np.random.default_rng(seed)
    for _ in range(3):
        q, qd = size * rng.normal(size=beam.size), 1.0 * rng.normal(size=beam.size)
        q[0], qd[0] = rng.uniform(-3.0, 3.0), rng.uniform(-6.0, 6.0)
        yield q, qd


def evaluated(beam, q, qd, t=T):
    """The filled arrays and the numbers of an evaluation."""
    work = beam.model.new_workspace()
    return work, beam.model.evaluate(t, q, qd, work)


def kinetic(beam, q, qd):
    return float(beam.energies(q[None], qd[None]).kinetic[0])


def potential(beam, q):
    parts = beam.energies(q[None], np.zeros((1, q.size)))
    return float(parts.elastic[0] + parts.gravity[0])


def mass_from_energy(beam, q):
    """T is a quadratic form of q': polarization gives its matrix without any truncation error."""
    n = beam.size
    unit = np.eye(n)
    single = np.array([kinetic(beam, q, row) for row in unit])
    return np.array(
        [[kinetic(beam, q, unit[i] + unit[j]) - single[i] - single[j] for j in range(n)] for i in range(n)]
    )


def gradient(function, x, step):
    """Central differences of order 6."""
    weights = {1: 3 / 4, 2: -3 / 20, 3: 1 / 60}
    rows = []
    for i in range(x.size):
        shift = np.zeros(x.size)
        shift[i] = step
        rows.append(
            sum(w * (function(x + k * shift) - function(x - k * shift)) for k, w in weights.items()) / step
        )
    return np.array(rows)


@pytest.mark.parametrize("name", FREE)
def test_mass_matrix_is_the_hessian_of_the_kinetic_energy(name):
    beam = beam_of(name)
    for q, qd in states(beam):
        M = evaluated(beam, q, qd)[0].mass
        assert_allclose(M, mass_from_energy(beam, q), rtol=1e-11, atol=1e-13)
        assert kinetic(beam, q, qd) == pytest.approx(0.5 * qd @ M @ qd, rel=1e-12)


@pytest.mark.parametrize("name", FREE)
def test_forces_are_lagranges_equations(name):
    """M q'' = Q with Q = dT/dq - (dM/dt) q' - dV/dq + torque (theta' + phi'(0) B')."""
    beam = beam_of(name)
    for q, qd in states(beam):
        Q = evaluated(beam, q, qd)[0].forces
        derivatives = gradient(lambda x: mass_from_energy(beam, x), q, 1e-3)
        rate = np.einsum("kij,k->ij", derivatives, qd)
        slope = np.concatenate([[1.0], beam.operators.root_slope])
        torque = beam.scenario.root.torque * slope
        expected = 0.5 * np.einsum("kij,i,j->k", derivatives, qd, qd) - rate @ qd
        expected += torque - gradient(lambda x: potential(beam, x), q, 1e-3)
        scale = np.abs(beam.operators.K @ q[1:]).max() + np.abs(expected).max()
        assert_allclose(Q, expected, atol=1e-9 * scale)


@pytest.mark.parametrize("name", [name for name in CASES if name.endswith("driven")])
def test_driven_root_is_the_free_beam_with_its_first_row_replaced(name):
    beam = beam_of(name)
    free = beam_of(name.replace("driven", "hub radius"), root__inertia=0.0, root__torque=0.0)
    _, angle_rate, acceleration = beam.motion.at(T)
    for q, qd in states(beam):
        qd[0] = angle_rate
        (driven, e), (loose, _) = evaluated(beam, q, qd), evaluated(free, q, qd)
        held, swinging = touched(beam.model, 0, T, q, qd, driven), touched(free.model, 0, T, q, qd, loose)
        M, Q = loose.mass, loose.forces
        solution = np.linalg.solve(driven.mass, driven.forces)
        assert solution[0] == pytest.approx(acceleration, rel=1e-14)
        assert_allclose(M[1:, 0] * acceleration + M[1:, 1:] @ solution[1:], Q[1:], rtol=1e-9, atol=1e-9)
        # the contact moves with the prescribed coordinate: same rates, its acceleration in the bias
        for which, bias in (("normal", "gap_bias"), ("tangential", "slip_bias")):
            total = getattr(swinging, which) @ solution + getattr(swinging.contact, bias)
            assert getattr(held, which)[0] == 0.0
            found = getattr(held, which) @ solution + getattr(held.contact, bias)
            assert found == pytest.approx(total, rel=1e-10)
        for name in ("gap", "slip", "gap_rate", "slip_rate"):
            assert getattr(held.contact, name) == pytest.approx(getattr(swinging.contact, name), rel=1e-14)
        # the driver's torque is what the row of theta lacks
        power = (M[0] @ solution - Q[0]) * angle_rate
        assert e.supplied_power + dot(driven.vectors[SUPPLY], solution) == pytest.approx(power, rel=1e-10)


def test_full_mass_matrix_is_positive_where_the_first_order_is_not():
    """B^T C B beyond the clamped inertia: the Gram matrix of the full form stays positive definite."""
    first, full = beam_of("first-order, tangent, pin"), beam_of("full, tangent, pin")
    q = np.array([0.3, 0.0, 0.0, 0.012])
    lowest = [np.linalg.eigvalsh(evaluated(b, q, np.zeros(4))[0].mass)[0] for b in (first, full)]
    assert lowest[0] < 0.0 < lowest[1]


# The prescribed rotation ---------------------------------------------------------------------------------------


def motion(profile, rate=5.0, time=0.5):
    scenario = Scenario().replace(
        root__kind="driven", root__profile=profile, root__spin_rate=rate, root__spin_up_time=time
    )
    return Beam(scenario, build_operators(scenario)).motion


def test_drive_profiles():
    assert motion("hold", 0.0, 0.0).at(3.0) == (0.0, 0.0, 0.0)
    assert motion("constant-speed", 5.0, 0.0).at(0.3) == (1.5, 5.0, 0.0)
    spin_up = motion("spin-up")
    assert spin_up.at(0.0) == pytest.approx((0.0, 0.0, 0.0), abs=1e-16)
    for t in (0.5, 0.7, 3.0):
        # the mean speed of the spin-up is half the final one
        assert spin_up.at(t) == pytest.approx((5.0 * (t - 0.25), 5.0, 0.0), rel=1e-14)
    # the middle, by hand: theta_dot = (w/T) (T/2 - 0), theta = (w/T) (T^2/8 - 2 (T/2 pi)^2)
    middle = 10.0 * (0.25**2 / 2.0 - 2.0 * (0.25 / math.pi) ** 2)
    assert spin_up.at(0.25) == pytest.approx((middle, 2.5, 20.0), rel=1e-14)

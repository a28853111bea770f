"""Damping by mass and by mode: that of the elastic modes of the beam with its root, in every frame.

References are computed in nodal deflections and slopes seen from axes that do not turn, with own elements.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.linalg import eigh

from oblique_impact import Scenario, simulate
from tests.history.recomputed import hermite

LENGTH, MASS, BENDING = 1.0, 2766.7 * 3.14e-4, 68.952e9 * 7.85e-9  # m, kg/m, N m^2: the paper's beam
BY_MASS = "beam.mass_proportional=24"
DAMPED = f"{BY_MASS} beam.modal_damping_ratio=0.03 beam.kelvin_voigt=2e-5"
HUB = "root.kind=hub root.inertia=0.05"
TANGENT = {
    "pin": "root.kind=pin",
    "hub": HUB,
    "hub with a radius": f"{HUB} root.hub_radius=0.2",
    "held": "root.kind=driven root.profile=hold",
}
MEAN_AXIS = {f"{root}, mean axis": f"{TANGENT[root]} discretization.frame=mean-axis" for root in ("pin", "hub")}
ROOTS = TANGENT | MEAN_AXIS
FEM, FULL = "discretization.method=fem", "discretization.kinetics=full"
ZEROTH = "discretization.kinetics=zeroth-order"
NODAL = f"{FEM} discretization.modes=0 discretization.elements=8"


def flight(*keys):
    """The paper's beam by itself, straight and at rest."""
    still = "contact.enabled=false gravity=0 initial.angle=0.4 initial.angular_velocity=0 discretization.modes=8"
    return Scenario.builtin("paper", " ".join([still, *keys]).split())


class Elements:
    """Uniform elements on a root: M, K of the free degrees of freedom, damping C that leaves the swing alone."""

    def __init__(self, scenario, elements):
        root, beam = scenario.root, scenario.beam
        self.nodes, (z, w) = np.linspace(0.0, LENGTH, elements + 1), legendre.leggauss(4)
        x = (self.nodes[:-1, None] + 0.5 / elements * (1.0 + z)).ravel()
        weights = np.tile(0.5 / elements * w, elements)
        values, curvatures = hermite(self.nodes, x, 0), hermite(self.nodes, x, 2)
        M, K = MASS * (values.T * weights) @ values, BENDING * (curvatures.T * weights) @ curvatures
        M[1, 1] += root.inertia
        self.free = np.eye(len(M))
        self.free[0, 1] = root.hub_radius  # as its hub turns, the root moves across
        self.free = self.free[:, 2 if root.kind == "driven" else 1 :]
        self.M, K = (self.free.T @ matrix @ self.free for matrix in (M, K))
        squares, modes = eigh(K, self.M)
        elastic = squares > 1e-6 * squares[1]
        self.frequencies, self.modes = np.sqrt(squares[elastic]), modes[:, elastic]  # of the modal mass 1
        rates = beam.mass_proportional + 2.0 * beam.modal_damping_ratio * self.frequencies
        rates = rates + beam.kelvin_voigt * self.frequencies**2
        share = self.M @ self.modes
        self.C = (share * rates) @ share.T
        one, scale = np.eye(len(K)), self.frequencies[2]
        forces = np.linalg.solve(self.M, np.hstack([K / scale, self.C]))
        found = np.linalg.eigvals(np.block([[0.0 * one, scale * one], [-forces]]))
        found = found[found.imag > 0.1 * self.frequencies[0]]
        self.eigenvalues = found[np.argsort(found.imag)]  # 1/s, upper half plane, ascending


def eigenvalues(q, qd, step):
    """Eigenvalues (1/s) of a free decay, ascending: of the matrix that takes a sample (n,) to the next one."""
    states = np.hstack([q, step * qd])
    states = states / np.abs(states).max(axis=0)
    found = np.log(np.linalg.eigvals(np.linalg.lstsq(states[:-1], states[1:])[0])) / step
    found = found[found.imag > 0.0]
    return found[np.argsort(found.imag)]


REDUCED = ROOTS | {
    "pin, elements": f"{TANGENT['pin']} {FEM} discretization.elements=24",
    "hub, elements": f"{TANGENT['hub']} {FEM} discretization.elements=24",
    "pin, full": f"{TANGENT['pin']} {FULL}",
    "hub with a radius, full": f"{TANGENT['hub with a radius']} {FULL}",
    "pin, mean axis, full": f"{ROOTS['pin, mean axis']} {FULL}",
    "pin, zeroth order": f"{TANGENT['pin']} {ZEROTH}",
}


@pytest.mark.parametrize("case", REDUCED)
def test_free_vibrations_decay_like_the_modes_of_the_beam_with_its_root(case):
    scenario = flight(REDUCED[case], DAMPED, "end_time=0.05 solver.output_interval=1e-4")
    rates = 1e-4 * (-1.0) ** np.arange(9)
    rates[0] = 0.0
    history = simulate(scenario, initial_state=(np.eye(1, 9)[0] * 0.4, rates))
    found = eigenvalues(history["q"].values[:, 1:], history["qd"].values[:, 1:], 1e-4)[:3]
    exact = Elements(scenario, 24).eigenvalues[:3]
    np.testing.assert_allclose(found.real, exact.real, rtol=1e-4)
    np.testing.assert_allclose(found.imag, exact.imag, rtol=1e-4)


SCHEMES = {
    "generalized-alpha": "solver.rho_infinity=1",
    # a scheme of contacts, which here are out of reach
    "time-stepping": "contact.enabled=true contact.where=anywhere contact.grid=8 slope.origin=[0,-5]",
}


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("root", ["pin", "hub"])
def test_all_nodes_decay_like_the_modes_of_the_beam_with_its_root(root, scheme):
    steps = f"solver.scheme={scheme} solver.free_step=1e-5 solver.output_interval=1e-4 end_time=0.05"
    scenario = flight(MEAN_AXIS[f"{root}, mean axis"], BY_MASS, NODAL, steps, SCHEMES[scheme])
    own = Elements(scenario, 8)
    rates = np.append(0.0, 1e-4 * own.modes[:, :3].sum(axis=1))
    history = simulate(scenario, initial_state=(np.zeros(rates.size), rates))
    rigid = np.column_stack([own.nodes, np.ones(9)]).ravel()[1:]
    share = own.M @ own.modes[:, :3]
    z, zd = ((q[:, 1:] + np.outer(q[:, 0], rigid)) @ share for q in (history["q"].values, history["qd"].values))
    for k, exact in enumerate(own.eigenvalues[:3]):
        (found,) = eigenvalues(z[:, k : k + 1], zd[:, k : k + 1], 1e-4)
        assert (found.real, found.imag) == pytest.approx((exact.real, exact.imag), rel=2e-4)


SWINGS = {root: f"{keys} beam.modal_damping_ratio=0.03" for root, keys in ROOTS.items() if root != "held"}


@pytest.mark.parametrize(
    "keys", [*SWINGS.values(), f"{ROOTS['hub, mean axis']} {NODAL}"], ids=[*SWINGS, "all nodes"]
)
def test_a_swing_is_not_damped(keys):
    swing = "initial.angular_velocity=6 end_time=0.1 solver.output_interval=1e-2"
    history = simulate(flight(keys, BY_MASS, swing))
    energy = history.summary["energy"]
    assert history["theta_dot"].values == pytest.approx(6.0, rel=1e-12)
    assert abs(energy["lost_damping"]) < 1e-14 * energy["kinetic"]


@pytest.mark.parametrize("frame", ["pin", "pin, mean axis"])
def test_a_pin_carries_no_moment(frame):
    """In a decay from a deflection of a twentieth of the length, with a swing besides."""
    scenario = flight(ROOTS[frame], FULL, DAMPED, "discretization.modes=3 end_time=0.03")
    history = simulate(
        scenario, initial_state=(np.array([0.4, 0.025, 0.002, 0.0]), np.array([5.0, 0.0, 0.0, 0.0]))
    )
    assert np.abs(history["uy"].values).max() > 0.04
    moment = history.section_forces()["moment"].values
    assert np.abs(moment[:, [0, -1]]).max() < 1e-11 * np.abs(moment).max()

"""The full nodal beam against the same beam in all its modes, and its banded algebra against dense."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from oblique_impact import Scenario, fem_beam
from oblique_impact.beam.beam import Beam, FullBeam
from oblique_impact.contact.forces import touch_contacts, touched
from oblique_impact.contact.state import DIRECTION, RESPONSE, SLIDING, Candidate, Contacts
from oblique_impact.fem_beam.reduction import eigenmodes
from oblique_impact.kernels.workspace import FREE_ACCELERATION, SUPPLY

KINEMATICS = ("gap", "slip", "gap_rate", "slip_rate", "gap_bias", "slip_bias")

SPIN_UP = {"root__kind": "driven", "root__profile": "spin-up", "root__spin_rate": 4.0, "root__spin_up_time": 0.3}
ROOTS = {
    "pin": {},
    "hub": {"root__kind": "hub", "root__inertia": 0.05, "root__torque": 1.3},
    "hub of a radius": {
        "root__kind": "hub",
        "root__inertia": 0.05,
        "root__torque": 1.3,
        "root__hub_radius": 0.2,
    },
    "hub on a spring": {
        "root__kind": "hub",
        "root__inertia": 0.05,
        "root__stiffness": 300.0,
        "root__damping": 2.0,
        "root__hub_radius": 0.2,
    },
    "hub on a spring, at the axis": {"root__kind": "hub", "root__inertia": 0.05, "root__stiffness": 300.0},
    "held": {"root__kind": "driven"},
    "yielding": SPIN_UP | {"root__stiffness": 500.0, "root__damping": 3.0, "root__hub_radius": 0.15},
    "yielding, at the axis": {"root__kind": "driven", "root__stiffness": 500.0},
    "driven": SPIN_UP | {"root__hub_radius": 0.15},
}
BASE = {"base__acceleration": 3.0, "base__frequency": 7.0, "base__direction": 0.7}
TIME = 0.04  # s, of the states
SHAPES = {
    "uniform": {},
    "tapered": {
        "beam__area": [[0.0, 4e-4], [0.4, 3e-4], [1.0, 1.5e-4]],
        "beam__second_moment": [[0.0, 9e-9], [1.0, 4e-9]],
        "beam__tip_mass": 0.07,
        "discretization__grading": 3.0,
    },
    "face": {"contact__surface": "section", "contact__point": 0.7, "beam__outer_fibre": 0.03},
}


def scenario_of(root="pin", shape="uniform", **changes):
    base = {
        "discretization__method": "fem",
        "discretization__modes": 0,
        "discretization__elements": 5,
        "beam__kelvin_voigt": 1e-5,
        "beam__mass_proportional": 0.3,
    }
    return Scenario().replace(**(base | BASE | ROOTS[root] | SHAPES[shape] | changes))


def closed(size):
    """One contact that slides."""
    return Contacts.new([Candidate(state=SLIDING)], size, packed=False)


class Pair:
    """One random state of a nodal beam, and the same state in all the modes of its mesh."""

    def __init__(self, scenario, seed=0):
        self.driven = scenario.root.kind == "driven"
        self.full = FullBeam(scenario, fem_beam.build_nodal(scenario))
        self.modal = Beam(scenario, fem_beam.build_operators(scenario))
        yields, mean_axis = (
            self.driven and scenario.root.stiffness > 0.0,
            scenario.discretization.frame == "mean-axis",
        )
        root = "yielding" if yields else "hinged" if mean_axis else "clamped"
        modes = eigenmodes(fem_beam.NodalBeam.from_scenario(scenario), root, None)
        modes = modes if yields else modes[1:]  # the angle of the drive, in front, has no part in them
        self.T = np.column_stack([self.full.operators.rigid, modes])
        rng = np.random.default_rng(seed)
        scale = 1e-3 / np.arange(1, modes.shape[1] + 1) ** 2
        self.q = np.concatenate([[0.5], scale * rng.normal(size=scale.size)])
        self.qd = np.concatenate([[-3.0], 1e3 * scale * rng.normal(size=scale.size)])
        self.W, self.Wd = self.T @ self.q, self.T @ self.qd
        self.work, self.dense = self.full.model.new_workspace(), self.modal.model.new_workspace()
        self.found = self.full.model.evaluate(TIME, self.W, self.Wd, self.work)
        self.expected = self.modal.model.evaluate(TIME, self.q, self.qd, self.dense)
        self.contacts, self.modal_contacts = closed(self.W.size), closed(self.q.size)
        assert touch_contacts(self.full.model, self.contacts, TIME, self.W, self.Wd, self.work) == 1
        assert touch_contacts(self.modal.model, self.modal_contacts, TIME, self.q, self.qd, self.dense) == 1


@pytest.fixture(params=[(root, shape) for root in ROOTS for shape in SHAPES], ids="-".join)
def pair(request):
    return Pair(scenario_of(*request.param))


def test_kinematics_and_forces(pair):
    assert pair.found.damping_power == pytest.approx(pair.expected.damping_power, rel=1e-10, abs=1e-12)
    found, rows, free = pair.contacts.of(0), pair.contacts.rows[DIRECTION, 0] @ pair.T, 1 if pair.driven else 0
    if pair.driven:  # the nodes are carried along by a turn that is prescribed
        turning = pair.full.motion.at(TIME).acceleration * rows[:, 0]
        found.gap_bias, found.slip_bias = found.gap_bias + turning[0], found.slip_bias + turning[1]
    for name in KINEMATICS:
        expected = getattr(pair.modal_contacts.of(0), name)
        assert getattr(found, name) == pytest.approx(expected, rel=1e-10, abs=1e-12), name
    assert_allclose(rows[:, free:], pair.modal_contacts.rows[DIRECTION, 0][:, free:], atol=1e-12)
    if not pair.driven:
        forces = pair.T.T @ pair.work.forces
        assert_allclose(forces, pair.dense.forces, atol=1e-9 * np.abs(forces).max())


def test_accelerations_and_responses(pair):
    assert pair.full.model.solve_mass(pair.found.rank_one, pair.work, pair.contacts, True)
    assert pair.modal.model.solve_mass(pair.expected.rank_one, pair.dense, pair.modal_contacts, True)
    found = np.vstack([pair.work.vectors[FREE_ACCELERATION], pair.contacts.rows[RESPONSE, 0]])
    modal = np.vstack([pair.dense.vectors[FREE_ACCELERATION], pair.modal_contacts.rows[RESPONSE, 0]])
    for one, expected in zip(found, modal @ pair.T.T, strict=True):
        assert_allclose(one, expected, atol=1e-9 * np.abs(expected).max())
    assert pair.full.model.definiteness(pair.found.rank_one, pair.work) > 0.9
    powers = []
    for evaluated, work in ((pair.found, pair.work), (pair.expected, pair.dense)):
        v = work.vectors
        powers.append(evaluated.supplied_power + v[SUPPLY] @ v[FREE_ACCELERATION])
    assert powers[0] == pytest.approx(powers[1], rel=1e-10)
    assert powers[0] != 0.0


def test_energies(pair):
    found = pair.full.energies(pair.full.split(pair.W[None]), pair.full.split(pair.Wd[None]))
    expected = pair.modal.energies(pair.q[None], pair.qd[None])
    assert_allclose(np.array(found), np.array(expected), rtol=1e-11)
    assert_allclose(pair.full.split(pair.W)[0], 0.5, rtol=1e-13)
    assert_allclose(pair.full.split(pair.W)[1:], pair.T[:, 1:] @ pair.q[1:], atol=1e-15)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"shape": "face"},
        {"contact__shortening": False, "contact__point": 0.7},
        {"contact__point_inertia": "none", "root": "hub"},
    ],
    ids=str,
)
def test_rows_rates_and_biases_are_derivatives_of_gap_and_slip(changes):
    """By differences of fourth order along random velocities, without acceleration, and along each coordinate."""
    full = FullBeam(scenario_of(**changes), fem_beam.build_nodal(scenario_of(**changes)))
    model, rng, h = full.model, np.random.default_rng(5), 1e-4
    size, work = full.size, full.model.new_workspace()
    W = 0.4 * full.operators.rigid + 0.02 * rng.normal(size=size)
    Wd = -3.0 * full.operators.rigid + rng.normal(size=size)

    def at(t, velocity):
        e, *rows = touched(model, 0, TIME, W + t * velocity, velocity, work)
        return np.array([e.gap, e.slip, e.gap_rate, e.slip_rate]), [e.gap_bias, e.slip_bias], np.array(rows)

    def difference(velocity):
        values = {n: at(n * h, velocity)[0] for n in (-2, -1, 1, 2)}
        return (8.0 * (values[1] - values[-1]) - (values[2] - values[-2])) / (12.0 * h)

    now, biases, rows = at(0.0, Wd)
    assert_allclose(now[2:], rows @ Wd, rtol=1e-10)
    assert_allclose(difference(Wd), [*now[2:], *biases], rtol=1e-7, atol=1e-7)
    assert_allclose(rows, np.array([difference(unit)[:2] for unit in np.eye(size)]).T, rtol=1e-8, atol=1e-9)


def test_places_that_touch_obstacles_move_as_in_all_modes():
    """Points of the beam on a side, the corner at its end, and a peg."""
    obstacles = (
        {"kind": "side", "origin": [0.1, -0.05], "angle": 0.2, "extent": [0.0, 0.6]},
        {"kind": "point", "origin": [0.55, -0.04], "radius": 0.01},
    )
    anywhere = {"contact__where": "anywhere", "contact__normal": "spring", "contact__grid": 3}
    pair = Pair(scenario_of(**SHAPES["tapered"], **anywhere, slope__enabled=False, obstacles=obstacles))
    count = len(pair.modal.candidates)
    assert count >= 5
    for i in range(count):
        found, *rows = touched(pair.full.model, i, TIME, pair.W, pair.Wd, pair.work)
        expected, *modal_rows = touched(pair.modal.model, i, TIME, pair.q, pair.qd, pair.dense)
        for name in KINEMATICS:
            assert getattr(found, name) == pytest.approx(getattr(expected, name), rel=1e-10, abs=1e-12), name
        assert_allclose(np.array(rows) @ pair.T, modal_rows, atol=1e-12)

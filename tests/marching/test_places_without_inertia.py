"""Contact places without inertia in time-stepping: against located events, the limit, balances, laws."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.beam.operators import build_operators
from oblique_impact.beam.residual_flexibility import flexibility_along
from oblique_impact.contact.compliance import Compliance
from oblique_impact.contact.friction import FrictionCurve
from oblique_impact.history.history import History
from oblique_impact.validation.runs import NEAR

MASSLESS, MEAN_AXIS = "contact.point_inertia=none", "discretization.frame=mean-axis"


@cache
def slap(*keys: str) -> History:
    """Let a beam slap onto a table."""
    return simulate(Scenario.builtin("slap", list(keys)))


def impulse(history: History) -> float:
    """Impulse (N s) of all contacts."""
    return sum(c.normal_impulse for c in history.contacts)


# --- on modes


@cache
def on_the_slope(*keys: str) -> tuple[float, ...]:
    """Impulse and energy of the first collision of the damped paper's beam, end of its first contact."""
    found = simulate(Scenario.builtin("damped", [*NEAR, "end_time=0.0179", *keys]))
    assert len(found.contacts) == 5
    return impulse(found), found.total_energy.values[-1], found.contacts[0].end


@pytest.mark.parametrize("friction", ["frictionless", "hybrid"])
def test_a_free_end_strikes_as_its_located_contacts_do(friction):
    """One place is the residual flexibility of the event scheme, which lets it relax at once as it opens."""
    located = on_the_slope(f"contact.friction={friction}")
    keys = "contact.where=anywhere", "solver.scheme=time-stepping", f"contact.friction={friction}"
    apart = []
    for step in (4e-6, 1e-6):
        found = on_the_slope(*keys, f"solver.contact_step={step}", f"solver.free_step={step}")
        apart.append(np.abs(np.subtract(found, located)))
    assert apart[1][:2] == pytest.approx([0.0, 0.0], abs=5e-5)
    assert apart[1][2] == pytest.approx(0.0, abs=1e-5)
    assert apart[1][0] < 0.3 * apart[0][0]


@pytest.mark.parametrize(
    ("law", "keys"),
    [
        (None, ("contact.friction=modified-coulomb", "contact.regularization=[0.05,0.5]")),
        (FrictionCurve(((0.0, 0.0), (2.0, 0.8))), ()),
        (FrictionCurve(((0.0, 0.5), (0.2, 0.2), (1.0, 0.6)), static=0.55), ()),
    ],
    ids=["modified-coulomb", "viscous", "stick-and-slip"],
)
def test_friction_that_depends_on_the_slip_velocity_is_that_of_located_events(law, keys):
    """What friction takes is of the first order of the step, with laws of one's own too."""

    def lost(*more: str) -> float:
        scenario = Scenario.builtin("damped", ["end_time=0.335", *keys, *more])
        return simulate(scenario, friction=law).balance["lost_friction"]

    steps = "contact.where=anywhere", "solver.scheme=time-stepping"
    located, apart = lost(), []
    for step in (4e-6, 1e-6):
        found = lost(*steps, f"solver.contact_step={step}", f"solver.free_step={step}")
        apart.append(abs(found - located))
    assert apart[0] < 4e-4
    assert apart[1] < 0.35 * apart[0]


def test_the_flexibility_left_out_between_places_is_that_of_the_higher_modes():
    places = np.array([0.2, 0.5, 0.55, 1.0])
    few, many = (
        build_operators(Scenario.builtin("paper", [MEAN_AXIS, f"discretization.modes={n}"])) for n in (4, 90)
    )
    shapes = many.along.derivative(places, 0)[:, 4:]
    higher = shapes @ np.linalg.solve(many.K[4:, 4:], shapes.T)
    nothing = np.zeros(4)
    behind = Compliance.between(
        places, nothing, nothing, nothing, nothing, flexibility_along(few, False), 0.0, None
    )
    found = np.array([[behind.flexibility(0, x, 1, y) for y in places] for x in places])
    assert found == pytest.approx(higher, abs=1e-3 * np.diag(found).min())
    assert np.linalg.eigvalsh(found).min() > 0.0


# --- the limit


@pytest.mark.parametrize("model", [(), ("discretization.modes=16", MEAN_AXIS)], ids=["nodes", "modes"])
@pytest.mark.parametrize("friction", ["frictionless", "hybrid"])
def test_a_damped_slap_has_the_limit_of_plastic_impacts(model, friction):
    keys = "solver.contact_step=2.5e-6", f"contact.friction={friction}"
    plastic, found = slap(*keys), slap(*keys, MASSLESS, *model)
    assert impulse(found) == pytest.approx(impulse(plastic), rel=1e-3)
    losses = []
    for history in (plastic, found):
        after = min(c.start for c in history.contacts) + 12e-3
        energy = history.total_energy.values
        losses.append(energy[0] - np.interp(after, history["time"].values, energy))
    assert losses[1] == pytest.approx(losses[0], rel=3e-3)
    assert found.balance["lost_friction"] == pytest.approx(plastic.balance["lost_friction"], rel=0.15)
    assert abs(found.balance["unaccounted"]) < 1e-7 * found.balance["initial"]


def test_impulse_and_what_closing_takes_converge_with_the_step():
    mesh = MASSLESS, "contact.grid=8", "discretization.elements=8", "end_time=0.38"
    found = [slap(*mesh, f"solver.contact_step={4e-6 / 2**k}") for k in range(4)]
    apart = np.abs(np.diff([impulse(history) for history in found]))
    assert (apart[1:] < 0.5 * apart[:-1]).all()
    assert apart[-1] < 1e-5 * impulse(found[-1])
    lost = np.array([history.balance["lost_impact"] for history in found])
    assert lost.min() > 0.0
    assert np.log2(lost[0] / lost[-1]) / 3.0 == pytest.approx(1.0, abs=0.4)


# --- laws and balances


@pytest.fixture(
    scope="module",
    params=[
        ("discretization.modes=0",),
        ("discretization.modes=0", "root.kind=hub", "root.inertia=0.05"),
        ("discretization.modes=6", MEAN_AXIS),
        pytest.param(
            ("discretization.modes=3", "discretization.kinetics=full", "beam.kelvin_voigt=0"),
            marks=pytest.mark.slow,
        ),
        ("discretization.modes=0", "contact.friction=modified-coulomb"),
    ],
    ids=["nodes", "hub", "modes", "full-undamped", "modified-coulomb"],
)
def rubbed(request) -> History:
    """A tapered beam falls onto a rough table, with a sample of every step."""
    keys = MASSLESS, "contact.friction=hybrid", "contact.grid=8", "discretization.elements=8", "end_time=0.02"
    steps = "solver.free_step=5e-6", "solver.contact_step=5e-6", "solver.output_interval=5e-6"
    start = "initial.angle=0", "initial.angular_velocity=-3", "beam.area=[[0,4e-4],[0.55,3e-4],[1,2e-4]]"
    found = slap(*keys, *steps, *start, *request.param)
    assert len(found.contacts) > 4
    return found


def test_energy_and_impulses_add_up(rubbed):
    assert rubbed.outcome.label == "completed"
    assert abs(rubbed.balance["unaccounted"]) < 1e-7
    assert rubbed.balance["lost_friction"] > 1e-5
    assert min(c.energy_loss for c in rubbed.contacts) > -1e-9
    lost = sum(c.energy_loss for c in rubbed.contacts)
    assert lost == pytest.approx(rubbed.balance["lost_impact"] + rubbed.balance["lost_friction"], rel=1e-9)
    pushed = 5e-6 * rubbed["contact_lambda_n"].values.sum()
    assert pushed == pytest.approx(impulse(rubbed), rel=1e-9)
    assert pushed == pytest.approx(sum(e.normal_impulse for e in rubbed.events), rel=1e-9)


def test_places_push_within_the_cone_and_do_not_pass_through(rubbed):
    state = rubbed["contact_state"].values
    normal, along = rubbed["contact_lambda_n"].values, rubbed["contact_lambda_tau"].values
    assert (normal[state != 0] > 0.0).all()
    assert (normal[state == 0] == 0.0).all()
    assert (np.abs(along) <= 0.3 * normal * (1.0 + 1e-9)).all()
    if rubbed.scenario.is_nodal:  # of modes it is the coordinates that pass, by what they leave out
        assert rubbed["contact_gap"].values.min() > -1e-9


def test_velocities_are_those_of_the_motion(rubbed):
    """Also of nodes, which have no inertia to carry a velocity from one step to the next."""
    time, y, rate = (rubbed[name].values for name in ("time", "tip_y", "tip_vy"))
    moved = (y[2:] - y[:-2]) / (time[2:] - time[:-2])
    assert np.sqrt(np.mean((moved - rate[1:-1]) ** 2)) < 0.1 * np.sqrt(np.mean(moved**2))

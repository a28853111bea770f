"""The exact beam on rigid obstacles: energy, the limit of stiff springs, friction, restitution, section forces."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import History, Scenario, simulate
from oblique_impact.contact.state import State
from oblique_impact.fem_beam.exact.exact_system import beam_of

RIGID = (
    "discretization.method=absolute",
    "discretization.elements=24",
    "discretization.frame=mean-axis",
    "beam.kelvin_voigt=1e-4",
    "solver.free_step=2e-5",
    "solver.contact_step=4e-6",
    "solver.output_interval=1e-4",
)
#: just above the slope, straight and fast
STRIKING = ("initial.angle=0.2214", "initial.angular_velocity=-3.786", "end_time=0.012")
PEG = (
    "contact.where=anywhere",
    "slope.enabled=false",
    'obstacles=[{kind="point",origin=[0.6,0.0],radius=0.01}]',
    "discretization.frame=tangent",
)
HUB = ("root.kind=hub", "root.inertia=0.01", "root.hub_radius=0.05", "end_time=0.05")
#: a peg that presses on the first element
AT_ROOT = (*PEG, 'obstacles=[{kind="point",origin=[0.075,0.0],radius=0.002}]')


def struck(*words: str, name: str = "paper") -> History:
    if any(word.startswith("root.kind=driven") for word in words):
        words = (*words, "initial.angular_velocity=0")
    return simulate(Scenario.builtin(name, [*RIGID, *STRIKING, *words]))


@pytest.mark.parametrize(
    "words",
    [
        (),
        ("contact.friction=frictionless", "contact.restitution=0.7"),
        ("contact.mu_static=2", "contact.mu_kinetic=2"),
        ("contact.friction=modified-coulomb",),
        ("root.kind=hub", "root.inertia=0.1", "root.torque=-20"),
        (
            *PEG,
            "root.kind=driven",
            "root.profile=constant-speed",
            "root.spin_rate=-4",
            "root.hub_radius=0.05",
            "initial.angle=0.15",
            "end_time=0.1",
        ),
        # the peg presses on the element that is moved
        (
            *PEG,
            "root.kind=driven",
            "root.spin_rate=-4",
            "root.spin_up_time=0.01",
            "root.profile=spin-up",
            "end_time=0.15",
            "initial.angle=0.15",
            'obstacles=[{kind="point",origin=[0.03,0.0],radius=0.002}]',
        ),
        ("forces=[{place=0.7,force=-30.0},{place=0.43,force=20.0,frequency=300,direction=1.0}]",),
        (*PEG, *HUB, "initial.angle=0.1"),
        (*PEG, *HUB, "initial.angle=0.1", "root.stiffness=100", "root.damping=0.5"),
        (*AT_ROOT, *HUB, "initial.angle=0.1", "root.stiffness=100"),
        (
            *AT_ROOT,
            "root.kind=driven",
            "root.profile=constant-speed",
            "root.spin_rate=-4",
            "root.hub_radius=0.05",
            "root.stiffness=300",
            "root.damping=0.1",
            "initial.angle=0.1",
            "end_time=0.05",
        ),
        (
            "contact.where=anywhere",
            "slope.angle=0",
            "slope.origin=[0,0]",
            "root.kind=free",
            "initial.position=[0,0.25]",
            "initial.velocity=[0.5,-2]",
            "initial.angle=-0.5",
            "initial.angular_velocity=1",
            "contact.restitution=0.5",
            "end_time=0.1",
        ),
    ],
    ids=[
        "stick",
        "restitution",
        "rough",
        "modified coulomb",
        "hub",
        "driven",
        "driven at its root",
        "forces on the beam",
        "hub with a radius",
        "hub on a spring",
        "hub, at its root",
        "clamp that yields",
        "free",
    ],
)
def test_energy_is_accounted_for(words):
    history = struck(*words)
    energy = history.summary["energy"]
    assert any(event.kind.value == "impact" for event in history.events)
    size = max(abs(energy["initial"]), abs(energy["supplied"]), energy["final"])
    assert abs(energy["unaccounted"]) < 1e-10 * size
    assert energy["lost_scheme"] == 0.0
    assert np.all(history["contact_gap"].values > -1e-8)


def test_it_is_the_limit_of_stiff_springs():
    """Springs take other steps, located ones; their contacts tend to the rigid one with the compliance."""
    words = ("contact.friction=frictionless", "beam.kelvin_voigt=1e-3", "solver.contact_step=1e-6")
    rigid = struck(*words).summary["macro_collisions"][0]["normal_impulse"]
    errors = []
    for stiffness in (1e5, 1e6, 1e9):
        spring = struck(*words, "contact.normal=spring", f"contact.stiffness={stiffness}")
        errors.append(spring.summary["macro_collisions"][0]["normal_impulse"] / rigid - 1.0)
    assert abs(errors[0]) > 7.0 * abs(errors[1])
    assert abs(errors[2]) < 3e-5


@pytest.mark.parametrize("words", [(), ("masses=[{place=0.3,mass=0.2}]", "forces=[{place=0.8,force=-30.0}]")])
def test_a_beam_that_starts_at_rest_on_a_peg_stays_there(words):
    at_rest = "initial.state=equilibrium", "initial.angle=-0.01", "initial.angular_velocity=0", "end_time=0.02"
    history = struck(*PEG, 'obstacles=[{kind="point",origin=[0.5,-0.02],radius=0.01}]', *at_rest, *words)
    assert history["contact_lambda_n"].values.min() > 1.0
    assert np.ptp(history["q"].values, axis=0).max() < 1e-12
    assert np.ptp(history["contact_lambda_n"].values) < 1e-8 * history["contact_lambda_n"].values.max()


def test_a_plastic_impact_stays_closed_and_restitution_opens_it():
    plastic, elastic = (struck("contact.friction=frictionless", f"contact.restitution={e}") for e in (0.0, 0.9))
    assert len(elastic.contacts) > 2 * len(plastic.contacts)
    assert elastic.summary["energy"]["lost_impact"] < plastic.summary["energy"]["lost_impact"]


def test_a_bar_that_strikes_a_rigid_floor_keeps_its_momenta_but_for_the_impulses():
    """Those of the floor, and their moments about the origin; a bar that rebounds goes on as a free body."""
    words = ["gravity=0", "contact.friction=frictionless", "initial.angular_velocity=0", "end_time=0.05"]
    history = struck(
        "contact.where=anywhere", "contact.grid=1", "slope.angle=0", "slope.origin=[0,0]", "root.kind=free",
        "initial.position=[0,0.25]", "initial.velocity=[0.5,-2]", "initial.angle=-0.5", *words,
    )  # fmt: skip
    beam = beam_of(history.scenario)
    v, q = history["qd"].values, history["q"].values
    momentum = (
        v @ (beam.M @ np.tile([1.0, 0.0, 0.0], beam.x.size)),
        v @ (beam.M @ np.tile([0.0, 1.0, 0.0], beam.x.size)),
    )
    impulse = sum(contact.normal_impulse for contact in history.contacts)
    assert impulse > 0.1
    assert np.ptp(momentum[0]) < 1e-12
    assert momentum[1][-1] - momentum[1][0] == pytest.approx(impulse, rel=1e-9)
    apart = history["time"].values > max(contact.end for contact in history.contacts) + 1e-4
    turning = np.array([beam.angular_momentum(*state) for state in zip(q[apart], v[apart], strict=True)])
    assert np.ptp(turning) < 1e-10


def test_friction_keeps_to_its_cone():
    history = struck("contact.mu_static=0.4", "contact.mu_kinetic=0.3")
    normal, tangential = history["contact_lambda_n"].values, history["contact_lambda_tau"].values
    states, rates = history["contact_state"].values, history["contact_slip_rate"].values
    assert np.all(np.abs(tangential) <= 0.4 * normal * (1.0 + 1e-9))
    slips = (states == int(State.SLIP)) & (np.abs(rates) > 1e-3) & (normal > 1.0)
    assert slips.any()
    np.testing.assert_allclose(tangential[slips], -0.3 * np.sign(rates[slips]) * normal[slips], rtol=1e-6)


def test_section_forces_are_in_balance_with_the_contact():
    """The shear force next to a pin turns the beam about its tip, and jumps at a peg by its force."""
    history = struck(
        "contact.friction=frictionless", "root.kind=driven", "root.profile=hold", "initial.angular_velocity=0",
        *PEG, "initial.angle=0.0169", "end_time=0.6", "solver.contact_step=2e-5", "solver.free_step=1e-4",
        "beam.kelvin_voigt=2e-3", "solver.output_interval=1e-2", "discretization.elements=16",
        "gravity=98",
    )  # fmt: skip
    forces, last = history.section_forces(), -1
    shear, x = forces["shear"].values[last], forces["station"].values
    weight = 98.0 * history.scenario.beam.length * 0.868744
    pressed, place = (history[f"contact_{name}"].values[last, 0] for name in ("lambda_n", "place"))
    assert pressed > 0.3 * weight
    inner, outer = (int(np.searchsorted(x, place)) + k for k in (-1, 0))
    between = weight * (x[outer] - x[inner])
    assert abs(abs(shear[outer] - shear[inner]) - (pressed - between)) < 0.02 * pressed
    # nothing but the weight behind it bends the part behind the peg
    behind = 1.0 - x[outer]
    assert abs(forces["moment"].values[last, outer]) == pytest.approx(0.5 * weight * behind**2, rel=0.02)

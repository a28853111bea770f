"""Several contacts in the event scheme: against one contact, balances of their own, and outcomes by name."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.history.history import History

PEGS = ({"kind": "point", "origin": [0.4, -0.02]}, {"kind": "point", "origin": [0.7, -0.036]})
#: on a ray from the pin
LEVEL = ({"kind": "point", "origin": [0.4, 0.0]}, {"kind": "point", "origin": [0.7, 0.0]})
TABLES = ({"kind": "side", "origin": [0.0, -0.15]}, {"kind": "side", "origin": [0.0, 0.15], "angle": np.pi})


def run(*keys: str, obstacles=(), **sections) -> History:
    """Run the paper's beam, everywhere in contact, among obstacles."""
    given = Scenario.builtin("paper", list(keys)).model_dump(mode="json", exclude_unset=True)
    given["obstacles"] = list(obstacles)
    defaults = {"contact": {"where": "anywhere"}, "slope": {"enabled": False}}
    for name, values in (defaults | sections).items():
        given[name] = {**given.get(name, {}), **values}
    return simulate(Scenario.from_dict(given))


MEAN_AXIS = ("discretization.frame=mean-axis", "discretization.modes=4", "end_time=0.45")


@pytest.fixture(scope="module")
def pegs() -> History:
    """The beam falls onto two pegs, with friction."""
    return run(*MEAN_AXIS, "solver.output_interval=1e-5", obstacles=PEGS)


def test_one_contact_of_several_is_the_contact_of_the_paper():
    alone = simulate(Scenario.builtin("paper", ["end_time=0.5"]))
    several = run("end_time=0.5", slope={"enabled": True})
    assert [e.kind for e in several.events] == [e.kind for e in alone.events]
    for a, b in zip(several.events, alone.events, strict=True):
        assert a.time == pytest.approx(b.time, abs=1e-9)
        assert a.normal_impulse == pytest.approx(b.normal_impulse, rel=1e-6, abs=1e-12)
    assert float(several["theta"][-1]) == pytest.approx(float(alone["theta"][-1]), abs=1e-8)


@pytest.mark.parametrize(
    "keys",
    [
        MEAN_AXIS,
        (*MEAN_AXIS, "contact.normal=spring", "contact.damping=0.1"),
        (*MEAN_AXIS, "contact.surface=section"),
        (*MEAN_AXIS, "contact.friction=modified-coulomb"),
        (*MEAN_AXIS, "contact.mu_static=0.6", "contact.mu_kinetic=0.2"),
        ("discretization.method=fem", "discretization.elements=16", "discretization.modes=3", "end_time=0.45"),
        # compiles kernels of its own
        pytest.param(
            ("discretization.kinetics=full", "discretization.modes=2", "end_time=0.42"), marks=pytest.mark.slow
        ),
        (
            "root.kind=driven",
            "root.profile=spin-up",
            "root.spin_rate=-2.0",
            "root.spin_up_time=0.2",
            "end_time=0.6",
        ),
        ("root.kind=hub", "root.inertia=0.01", "root.hub_radius=0.05", "root.torque=-1.0", "end_time=0.4"),
        (*MEAN_AXIS, "contact.restitution=0.5"),
        (*MEAN_AXIS, "discretization.kinetics=zeroth-order"),
        (*MEAN_AXIS, "discretization.kinetics=zeroth-order", "contact.surface=section"),
    ],
    ids=[
        *("rigid", "elastic", "face", "smooth friction", "two coefficients", "elements", "full", "driven", "hub"),
        *("bouncing", "zeroth order", "zeroth order, face"),
    ],
)
def test_the_energy_of_several_contacts_is_accounted_for(keys):
    found = run(*keys, obstacles=PEGS)
    assert found.outcome.label == "completed"
    assert found.events
    scale = max(abs(found.balance["initial"]), abs(found.balance["final"]))
    assert abs(found.balance["unaccounted"]) < 1e-9 * scale


def test_impulses_of_contacts_add_up_to_those_of_the_run(pegs):
    lost = sum(c.energy_loss for c in pegs.contacts)
    assert lost == pytest.approx(pegs.balance["lost_impact"] + pegs.balance["lost_friction"], rel=1e-9)
    total = sum(m["normal_impulse"] for m in pegs.macro_collisions)
    assert sum(c.normal_impulse for c in pegs.contacts) == pytest.approx(total, rel=1e-12)
    assert sum(e.normal_impulse for e in pegs.events) == pytest.approx(total, rel=1e-9)


def test_forces_at_their_places_turn_the_beam(pegs):
    """The angular momentum about the pin changes by the moments of weight, contact forces and impacts."""
    scenario, time = pegs.scenario, pegs["time"].values
    beam = scenario.beam
    x = pegs["station"].values
    mass = beam.density * beam.area
    along, across = x + pegs["ux"].values, pegs["uy"].values
    spin = pegs["theta_dot"].values[:, None]
    vx, vy = pegs["ux_dot"].values - spin * across, pegs["uy_dot"].values + spin * along
    momentum = mass * np.trapezoid(along * vy - across * vx, x, axis=1)
    theta = pegs["theta"].values
    lever = np.trapezoid(along * np.cos(theta)[:, None] - across * np.sin(theta)[:, None], x, axis=1)
    moments = pegs["contact_x"] * pegs["contact_fy"] - pegs["contact_y"] * pegs["contact_fx"]
    finite = np.where(pegs["contact_state"] != 0, moments, 0.0).sum(axis=1) - mass * scenario.gravity * lever
    gained = np.trapezoid(finite, time)
    for event in pegs.events:
        if event.kind.impulsive:
            # of a point on the axis, whose distance from the pin is its place but for the foreshortening
            gained += event.place * event.normal_impulse
    # of stations and of places: squares of slopes
    assert momentum[-1] - momentum[0] == pytest.approx(gained, rel=2e-3)


def test_a_contact_pushes_at_its_obstacle_and_nowhere_else(pegs):
    for i, peg in enumerate(PEGS):
        closed = pegs["contact_state"].values[:, i] != 0
        assert closed.any()
        assert pegs["contact_x"].values[closed, i] == pytest.approx(peg["origin"][0], abs=1e-9)
        assert pegs["contact_y"].values[closed, i] == pytest.approx(peg["origin"][1], abs=1e-9)
        assert (pegs["contact_lambda_n"].values[closed, i] > -1e-6).all()
        assert (pegs["contact_lambda_n"].values[~closed, i] == 0.0).all()
        assert (pegs["contact_gap"].values[:, i] > -1e-9).all()


def test_friction_of_each_contact_is_that_of_its_slip(pegs):
    state, slip = pegs["contact_state"].values, pegs["contact_slip_rate"].values
    normal, along = pegs["contact_lambda_n"].values, pegs["contact_lambda_tau"].values
    slides = (state == 1) & (np.abs(slip) > 1e-9)
    assert along[slides] == pytest.approx(-0.3 * normal[slides] * np.sign(slip[slides]), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("friction", ["hybrid", "frictionless"])
@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_each_impact_of_several_contacts_has_newtons_restitution(restitution, friction):
    """It takes P (1 - e) v/2 at the gap rate -v, or the whole P v/2 where bounces have accumulated."""
    keys = (*MEAN_AXIS, f"contact.restitution={restitution}", f"contact.friction={friction}")
    found = run(*keys, obstacles=PEGS)
    struck = [e for e in found.events if e.kind.impulsive and e.normal_impulse > 0.0]
    assert {e.obstacle for e in struck} == {1, 2}
    assert min(e.energy_loss for e in struck) >= 0.0
    whole = [(e.energy_loss, -0.5 * e.normal_velocity * e.normal_impulse) for e in struck]
    shares = [loss / most for loss, most in whole if most > 1e-9]  # others were at rest
    assert all(min(abs(share - 1.0 + restitution), abs(share - 1.0)) < 1e-9 for share in shares)
    if restitution == 1.0 and friction == "frictionless":
        assert found.balance["final"] == pytest.approx(found.balance["initial"], rel=1e-9)
        assert found.balance["lost_impact"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("friction", ["hybrid", "frictionless"])
@pytest.mark.parametrize("restitution", [0.0, 0.3])
def test_a_beam_that_bounces_between_two_pegs_comes_to_rest_on_both(restitution, friction):
    """Its impacts alternate, ever slower, until no bounce can be told from a closed contact."""
    keys = "discretization.frame=mean-axis discretization.modes=2 end_time=0.6 solver.output_interval=1e-3 "
    keys += f"contact.restitution={restitution} contact.friction={friction}"
    found = run(*keys.split(), obstacles=LEVEL, initial={"angle": 0.3, "angular_velocity": -2.0})
    assert found.outcome.label == "completed"
    assert len(found.events) < 400
    assert (found["contact_state"].values[-1] != 0).all()
    assert found.balance["kinetic"] < 1e-3 * found.balance["initial"]
    assert abs(found.balance["unaccounted"]) < 1e-9 * found.balance["initial"]
    assert found["contact_gap"].values.min() > -1e-11


def test_a_beam_between_two_tables_strikes_both():
    start = {"angle": 0.0, "angular_velocity": 3.0}
    found = run(*MEAN_AXIS, "end_time=0.6", obstacles=TABLES, initial=start)
    struck = [event.obstacle for event in found.events if event.kind.impulsive]
    assert struck[0] == 2
    assert 1 in struck
    assert (found["gap"] > -1e-9).all()
    assert abs(found.balance["unaccounted"]) < 1e-9


def test_a_beam_that_falls_across_the_end_of_a_side_is_struck_by_its_corner():
    """The ledge ends inside of the span: its corner meets the beam, at a place that slides along it."""
    found = run(*MEAN_AXIS, slope={"enabled": True, "extent": [0.0, 0.3075]})
    (corner,) = (end for end in found.scenario.slope_side.ends if end[0] > 0.5)
    closed = found["contact_state"].values != 0
    assert closed.any()
    for name, where in zip(("contact_x", "contact_y"), corner, strict=True):
        assert found[name].values[closed] == pytest.approx(where, abs=1e-9)
    places = found["contact_place"].values[closed]
    assert 0.55 < places.min() < places.max() < 0.65


def test_peaks_of_elastic_contacts_are_found_between_samples():
    """Nothing damps the springs, so that each has stored F^2/2k at its largest force; in flight none is deep."""
    keys = (*MEAN_AXIS, "contact.normal=spring", "contact.residual_flexibility=false")
    fine, coarse = (run(*keys, f"solver.output_interval={h}", obstacles=PEGS) for h in (1e-5, 2e-3))
    assert len(fine.contacts) == len(coarse.contacts) > 2
    for a, b in zip(fine.contacts, coarse.contacts, strict=True):
        assert b.peak_force == pytest.approx(a.peak_force, rel=1e-6)
        for contact in (a, b):
            assert contact.peak_energy == pytest.approx(0.5 * contact.peak_force**2 / 1e6, rel=1e-6)
    forces = fine["contact_lambda_n"].values.max(axis=1)
    assert fine["depth"].values == pytest.approx(forces / 1e6, rel=1e-9, abs=1e-15)


def test_what_friction_and_stop_take_from_a_tip_that_slides_off_is_that_of_its_contact():
    """It leaves the inner end of a soft side, whose corner holds the beam, and comes back above it."""
    side = {"kind": "side", "origin": [0.0, -0.05], "extent": [0.99865, 1.2], "stiffness": 1e4}
    keys = (*MEAN_AXIS, "contact.normal=spring", "contact.grid=1", "end_time=0.06", "solver.output_interval=1e-4")
    keys = (*keys, "contact.residual_flexibility=false")  # the spring alone
    found = run(*keys, obstacles=[side], initial={"angle": -0.04, "angular_velocity": -1.0})
    assert [end["how"] for end in found.summary["slope_ends"]] == ["slides off", "comes back"]
    tip, corner = found.contacts
    assert (tip.obstacle, corner.obstacle) == (1, 1)
    assert tip.end == found.summary["slope_ends"][0]["time"]
    # it is deepest as it slides off: what the spring has stored is lost
    assert found.balance["lost_damping"] == pytest.approx(tip.peak_energy, rel=1e-9)
    lost = found.balance["lost_damping"] + found.balance["lost_friction"]
    assert tip.energy_loss + corner.energy_loss == pytest.approx(lost, rel=1e-9)


PEG = {"kind": "point", "origin": [0.5, 0.0]}


@pytest.mark.parametrize("friction", ["hybrid", "frictionless"])
def test_of_two_rigid_pegs_at_one_place_one_carries_the_force_of_a_single_one(friction):
    keys = (*MEAN_AXIS, f"contact.friction={friction}")
    one, two = run(*keys, obstacles=[PEG]), run(*keys, obstacles=[PEG, PEG])
    assert two.outcome.label == one.outcome.label == "completed"
    assert len(one.events) >= 4
    assert [(e.kind, e.state, e.obstacle) for e in two.events] == [(e.kind, e.state, 1) for e in one.events]
    for a, b in zip(two.events, one.events, strict=True):
        assert a.time == pytest.approx(b.time, abs=1e-12)
        assert a.normal_impulse == pytest.approx(b.normal_impulse, rel=1e-9, abs=1e-12)
    assert (two["contact_lambda_n"].values[:, 1] == 0.0).all()
    assert two.balance["final"] == pytest.approx(one.balance["final"], rel=1e-9)


def on_one_ray(beyond: float, *keys: str) -> History:
    """A straight beam without weight swings onto two pegs of its ray; the outer one is higher by this much."""
    pegs = [{"kind": "point", "origin": [0.4, 0.0]}, {"kind": "point", "origin": [0.7, beyond]}]
    start = {"angle": 0.3, "angular_velocity": -2.0}
    straight = ("gravity=0", "discretization.frame=mean-axis", "end_time=0.3")
    return run(*straight, *keys, obstacles=pegs, initial=start)


def test_impacts_within_the_tolerance_of_location_are_one_problem():
    """Which of two pegs is struck first by a picometre is rounding, and decides nothing."""
    together, *others = (on_one_ray(beyond) for beyond in (0.0, 1e-12, -1e-12))
    first = [event for event in together.events if event.time == together.events[0].time]
    assert [(event.obstacle, event.kind.value) for event in first] == [(1, "rebound"), (2, "rebound")]
    for other in others:
        assert float(other["theta"][-1]) == pytest.approx(float(together["theta"][-1]), abs=1e-8)
        for event in first:
            (same,) = (e for e in other.events[:2] if e.obstacle == event.obstacle)
            assert same.normal_impulse == pytest.approx(event.normal_impulse, rel=1e-9)


def test_an_impact_with_friction_is_that_of_a_contact_alone_or_has_a_name():
    """Routh's method knows one contact: beside another that is closed the run ends, and keeps what it has."""
    routh = ("contact.impact=routh", "end_time=0.5")
    alone, listed = simulate(Scenario.builtin("paper", routh)), run(*routh, slope={"enabled": True})
    assert [e.kind for e in listed.events] == [e.kind for e in alone.events]
    for a, b in zip(listed.events, alone.events, strict=True):
        assert a.tangential_impulse == pytest.approx(b.tangential_impulse, rel=1e-6, abs=1e-12)
    ended = on_one_ray(0.0, "contact.impact=routh")
    assert ended.outcome.label == "impact-of-several"
    assert ended["time"][-1] == pytest.approx(0.15, abs=1e-9)


def at_rest(*keys: str) -> History:
    """The beam lies straight and level on its pin and two pegs, damped so that it sags and stays."""
    pegs = [{"kind": "point", "origin": [x, -1e-3], "radius": 1e-3} for x in (0.5, 0.9)]
    settle = ("discretization.frame=mean-axis", "beam.modal_damping_ratio=0.9", "end_time=0.05")
    return run(*settle, *keys, obstacles=pegs, initial={"angle": 0.0})


def test_axial_forces_of_sticking_pegs_on_a_straight_beam_are_redundant():
    """The beam does not stretch: how its pegs share an axial force is statically indeterminate."""
    assert at_rest().outcome.label == "redundant-constraints"
    assert at_rest("contact.normal=spring").outcome.label == "redundant-constraints"


def test_three_rigid_pegs_that_an_impact_closes_on_two_degrees_of_freedom_are_redundant():
    pegs = [{"kind": "point", "origin": [x, -0.05 * x]} for x in (0.3, 0.6, 0.9)]
    keys = ("discretization.modes=1", "contact.friction=frictionless")
    found = run(*MEAN_AXIS, *keys, obstacles=pegs)
    assert found.outcome.label == "redundant-constraints"
    assert found.events


def test_all_nodes_of_a_mesh_meet_pegs_as_all_its_modes_do():
    mesh = "discretization.method=fem", "discretization.elements=4", "contact.normal=spring", "end_time=0.4"
    keys = (*mesh, "contact.stiffness=2e5", "contact.mu_static=0.3", "contact.mu_kinetic=0.3")
    # between nodes the modes leave out what an element bends by itself, which nodes have not
    whole = "discretization.modes=8", "contact.residual_flexibility=false"
    modes = run(*keys, "discretization.frame=mean-axis", *whole, obstacles=PEGS)
    steps = "solver.free_step=4e-6", "solver.contact_step=4e-6"
    nodes = run(*keys, *steps, "discretization.modes=0", obstacles=PEGS)
    assert [(e.kind, e.obstacle) for e in nodes.events] == [(e.kind, e.obstacle) for e in modes.events]
    for a, b in zip(nodes.events, modes.events, strict=True):
        assert a.time == pytest.approx(b.time, abs=1e-6)
        assert a.place == pytest.approx(b.place, abs=1e-8)
    for a, b in zip(nodes.contacts, modes.contacts, strict=True):
        assert a.normal_impulse == pytest.approx(b.normal_impulse, abs=2e-4)
        assert a.peak_force == pytest.approx(b.peak_force, rel=2e-3)
        assert (a.first_place, a.last_place) == pytest.approx((b.first_place, b.last_place), abs=1e-7)
    assert abs(nodes.balance["unaccounted"]) < 1e-6 * nodes.balance["initial"]
    assert nodes.balance["lost_friction"] == pytest.approx(modes.balance["lost_friction"], rel=1e-4)
    lost = sum(contact.energy_loss for contact in nodes.contacts)
    assert lost == pytest.approx(nodes.balance["lost_friction"], rel=1e-9)


def test_a_beam_that_sticks_to_a_corner_rolls_on_it_whatever_the_stabilization():
    """The corner is pressed into the beam's face: the place that it touches moves though nothing slips."""
    corner = {"kind": "side", "origin": [0.19, -0.08], "angle": 0.05, "extent": [0.0, 0.6], "stiffness": 9e4}
    start = {"angle": 0.4, "angular_velocity": -0.9}
    keys = "discretization.frame=mean-axis discretization.modes=6 contact.normal=spring contact.surface=section "
    keys += "beam.outer_fibre=0.01 contact.mu_static=0.7 contact.mu_kinetic=0.7 end_time=0.25"
    runs = [
        run(*keys.split(), f"solver.baumgarte=[{rate}, {rate}]", obstacles=[corner], initial=start)
        for rate in (0.0, 500.0)
    ]
    for found in runs:
        stuck = found["contact_state"].values == 2
        assert stuck.any()
        assert np.abs(found["contact_slip_rate"].values[stuck]).max() < 1e-10
    for a, b in zip(runs[0].events, runs[1].events, strict=True):
        assert (a.kind, a.state) == (b.kind, b.state)
        assert a.time == pytest.approx(b.time, abs=1e-10)

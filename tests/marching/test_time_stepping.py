"""Time-stepping: many places at once against another program, events by another scheme, balances."""

from __future__ import annotations

from functools import cache
from math import sqrt

import numpy as np
import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.contact.friction import Coulomb, FrictionCurve, ModifiedCoulomb
from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.history.history import History
from tests.marching.linear_beam import fall
from tests.marching.test_several import PEGS

STEPS = "solver.scheme=time-stepping"
INERTIA = pytest.mark.parametrize("inertia", ["kept", "none"])


@cache
def built_in(case: str, *keys: str) -> History:
    """Run a built-in case."""
    return simulate(Scenario.builtin(case, list(keys)))


# --- a beam that lies down on a table


@INERTIA
def test_a_slap_loses_the_energy_that_it_loses_by_linear_kinematics(inertia):
    found = built_in("slap", "solver.contact_step=2.5e-6", f"contact.point_inertia={inertia}")
    drop = 0.5 * found.scenario.beam.length * (np.sin(found.scenario.initial.angle) + 0.02)
    mass = Sections.from_scenario(found.scenario).mass
    speed = sqrt(2.0 * mass * found.scenario.gravity * drop / (mass / 3.0))
    wanted = fall(64, 2.5e-6, 12e-3, -0.02, -speed, 0.02, 1.0, massless=inertia == "none")
    assert wanted.lost == pytest.approx(1.064, rel=1e-3)
    assert sum(c.normal_impulse for c in found.contacts) == pytest.approx(wanted.impulse, rel=1e-3)
    first = min(c.start for c in found.contacts)
    lost = found.total_energy.values[0] - np.interp(first + 12e-3, found["time"].values, found.total_energy.values)
    assert lost == pytest.approx(wanted.lost, rel=5e-3)
    assert min(c.first_place for c in found.contacts) == wanted.zone


@INERTIA
@pytest.mark.parametrize("edge", [1.0, 0.61])
def test_a_small_slap_is_that_of_linear_kinematics(edge, inertia):
    """Of a fall ten times as slow the kinematics differ a hundred times less."""
    side = {"kind": "side", "origin": [0.0, -0.002]} | ({"extent": [0.0, edge]} if edge < 1.0 else {})
    given = Scenario.builtin("slap", ["contact.grid=16", "discretization.elements=16"])
    given = given.replace(
        obstacles=[side],
        end_time=0.012,
        initial__angle=0.0,
        initial__angular_velocity=-0.4,
        contact__point_inertia=inertia,
        solver__free_step=5e-6,
        solver__output_interval=1e-3,
    )
    found, wanted = simulate(given), fall(16, 5e-6, 0.012, 0.0, -0.4, 0.002, edge, massless=inertia == "none")
    assert wanted.impulse > 0.1
    assert sum(c.normal_impulse for c in found.contacts) == pytest.approx(wanted.impulse, rel=1e-4)
    assert found.total_energy.values[0] - found.total_energy.values[-1] == pytest.approx(wanted.lost, rel=1e-3)
    assert min(c.first_place for c in found.contacts) == pytest.approx(wanted.zone, abs=1e-5)


@pytest.mark.parametrize("friction", ["frictionless", "hybrid"])
def test_all_nodes_of_a_mesh_lie_down_as_all_its_modes_do(friction):
    mesh = "contact.grid=8", "discretization.elements=8", "solver.contact_step=1e-5", "end_time=0.39"
    keys = (*mesh, f"contact.friction={friction}")
    nodes = built_in("slap", *keys)
    modes = built_in("slap", *keys, "discretization.modes=16", "discretization.frame=mean-axis")
    assert [(e.kind, e.place) for e in nodes.events] == [(e.kind, e.place) for e in modes.events]
    assert len(nodes.events) > 20
    for a, b in zip(nodes.contacts, modes.contacts, strict=True):
        assert (a.start, a.end) == pytest.approx((b.start, b.end), abs=1e-12)
        assert a.normal_impulse == pytest.approx(b.normal_impulse, abs=1e-9)
        assert a.tangential_impulse == pytest.approx(b.tangential_impulse, abs=1e-9)
    assert nodes.balance["final"] == pytest.approx(modes.balance["final"], rel=1e-9)


@INERTIA
def test_a_damped_beam_comes_to_rest_on_a_table(inertia):
    """The free length between the pin and where it lies is (24 EI d/w)^(1/4), with a force of w a/2 at its end."""
    keys = f"contact.grid=32 contact.point_inertia={inertia} discretization.elements=32 beam.mass_proportional=60 "
    keys += "beam.youngs_modulus=68.952e7 initial.angle=0 end_time=1 solver.contact_step=1e-4 "
    keys += "solver.output_interval=1e-2 obstacles=[{kind='side',origin=[0,-0.002]}]"
    given = Scenario.builtin("slap", keys.split())
    found = simulate(given)
    weight = Sections.from_scenario(given).mass * given.gravity
    free = (24.0 * given.beam.youngs_modulus * given.beam.second_moment * 0.002 / weight) ** 0.25
    force, places = found["contact_lambda_n"].values[-1], found["contact_place"].values[-1]
    assert force.sum() == pytest.approx(weight * (1.0 - 0.5 * free), rel=1e-3)
    assert places[force > 0.0].min() == pytest.approx(free, abs=1.0 / 32)
    assert found["contact_gap"].values[-1].min() > -1e-9


# --- against located events


@cache
def on_pegs(*keys: str) -> History:
    """The beam falls onto two pegs without friction, until the first collision is over."""
    common = "discretization.modes=4", "end_time=0.388", "contact.friction=frictionless"
    return simulate(Scenario.builtin("two-pegs", [*common, *keys]))


def test_events_and_impulses_are_those_of_the_event_scheme_to_second_order():
    located = on_pegs()
    ends = [max(c.end for c in located.contacts if c.obstacle == peg) for peg in (1, 2)]
    apart = []
    for step in (1e-5, 2.5e-6):
        found = on_pegs(STEPS, f"solver.contact_step={step}", f"solver.free_step={step}")
        times, impulses = [], []
        for peg in (1, 2):
            own = [c for c in found.contacts if c.obstacle == peg]
            wanted = [c for c in located.contacts if c.obstacle == peg]
            assert own[0].start == pytest.approx(wanted[0].start, abs=200.0 * step**2)
            times.append(max(c.end for c in own) - ends[peg - 1])
            impulses.append(sum(c.normal_impulse for c in own) - sum(c.normal_impulse for c in wanted))
        assert np.max(np.abs(times)) < 0.02 * step
        assert np.max(np.abs(impulses)) < 10.0 * step
        lost = found.balance["lost_impact"] - located.balance["lost_impact"]
        apart.append(np.max(np.abs([*impulses, lost])))
    assert apart[1] < 0.1 * apart[0]


def test_the_friction_of_an_impact_is_that_of_the_tip_at_rest_on_the_slope():
    """It is slow: a gap that a step leaves open would turn it, and with it the largest force of all."""
    keys = ["discretization.method=fem", "discretization.modes=0", "contact.where=anywhere", "contact.grid=1"]
    keys += ["contact.point_inertia=kept", "contact.friction=hybrid", "end_time=0.33", STEPS]
    keys += ["solver.free_step=1e-5"]
    impulses = []
    for step in (2e-6, 1.3e-6, 1e-6):
        found = simulate(Scenario.builtin("damped", [*keys, f"solver.contact_step={step}"]))
        impulses.append(found.summary["macro_collisions"][0]["normal_impulse"])
    assert impulses == pytest.approx([1.81436] * 3, abs=5e-6)


def test_an_impact_of_one_contact_has_the_friction_of_rouths():
    """Three contacts of a mass at the tip, which do not end within a step."""
    keys = "discretization.method=fem discretization.frame=mean-axis discretization.modes=6 beam.tip_mass=0.05 "
    keys += "beam.kelvin_voigt=1e-4 end_time=0.35"
    routh = built_in("paper", *keys.split(), "contact.impact=routh")
    found = built_in("paper", *keys.split(), STEPS, "solver.free_step=1e-5")
    a, b = found.macro_collisions[0], routh.macro_collisions[0]
    assert a["contacts"] == b["contacts"]
    assert (a["start"], a["end"]) == pytest.approx((b["start"], b["end"]), abs=2e-6)
    assert a["normal_impulse"] == pytest.approx(b["normal_impulse"], rel=1e-4)
    assert a["tangential_impulse"] == pytest.approx(b["tangential_impulse"], rel=2e-3)


def test_bounces_are_those_of_the_event_scheme_to_first_order():
    """Each contact leaves at half the speed that it comes with, in the step after the one that closes it."""
    keys = "discretization.modes=4", "contact.friction=frictionless", "beam.kelvin_voigt=0", "end_time=0.386"
    given = Scenario.builtin("two-pegs", [*keys, "contact.restitution=0.5"]).replace(obstacles=list(PEGS))
    located, energies = simulate(given), []
    for step in (1e-5, 2.5e-6):
        steps = {"solver__contact_step": step, "solver__free_step": step}
        found = simulate(given.replace(solver__scheme="time-stepping", **steps))
        assert abs(found.balance["unaccounted"]) < 1e-8 * located.total_energy.values[0] * (step / 2.5e-6)
        assert len(found.contacts) == len(located.contacts) > 4
        for peg in (1, 2):
            own = sorted((c for c in found.contacts if c.obstacle == peg), key=lambda c: c.start)
            wanted = sorted((c for c in located.contacts if c.obstacle == peg), key=lambda c: c.start)
            for a, b in zip(own, wanted, strict=True):
                assert 0.25 * step < a.end - a.start < 3.0 * step
                assert a.start == pytest.approx(b.start, abs=20.0 * step)
                assert a.normal_impulse == pytest.approx(b.normal_impulse, abs=500.0 * step)
                assert a.energy_loss == pytest.approx(b.energy_loss, abs=1000.0 * step)
                assert a.energy_loss > 0.0
        energies.append(found.balance["final"] - located.balance["final"])
    assert abs(energies[1]) < abs(energies[0]) < 5e-3


def test_a_beam_that_rubs_on_a_peg_turns_its_slip_when_located_events_do():
    """Impulses that close a contact have friction here alone: the motion after them differs by a thousandth."""
    # the second one is out of reach: kernels are those of two contacts
    pegs = [{"kind": "point", "origin": [0.5, y]} for y in (0.0, -5.0)]
    given = Scenario.builtin("two-pegs", ["discretization.modes=4", "end_time=0.39"]).replace(obstacles=pegs)
    located = simulate(given)
    found = simulate(given.replace(solver__scheme="time-stepping", solver__free_step=1e-5))
    assert [(e.kind, e.state) for e in found.events] == [(e.kind, e.state) for e in located.events]
    assert sum(e.kind is EventKind.REVERSAL for e in found.events) == 10
    for a, b in zip(found.events, located.events, strict=True):
        assert a.time == pytest.approx(b.time, abs=1e-5)
        if a.kind is EventKind.RELEASE:
            assert a.normal_impulse == pytest.approx(b.normal_impulse, rel=1e-3)
            assert a.tangential_impulse == pytest.approx(b.tangential_impulse, rel=2e-2)
            assert a.energy_loss == pytest.approx(b.energy_loss, rel=2e-2)


def test_no_contact_gains_energy_where_an_impact_jams():
    """On the steep rough slope of the case an impact sticks at once."""
    keys = "contact.where=anywhere", "contact.grid=1", STEPS, "solver.contact_step=1e-5", "solver.free_step=1e-5"
    keys += ("obstacles=[{kind='side', origin=[0, -5]}]",)  # out of reach: kernels are those of two contacts
    found = built_in("sticking", *keys, "end_time=0.6")
    assert found["contact_state"].values[-1, 0] == 2
    assert min(c.energy_loss for c in found.contacts) > -1e-6
    assert found.balance["lost_friction"] > 0.0
    assert abs(found.balance["unaccounted"]) < 1e-6


# --- balances, laws and states


@pytest.fixture(scope="module")
def rubbed() -> History:
    """The beam falls onto two pegs with friction."""
    keys = ["discretization.modes=4", "end_time=0.39", "solver.output_interval=2e-5", STEPS]
    steps = ["solver.contact_step=5e-6", "solver.free_step=2e-5"]
    given = Scenario.builtin("two-pegs", [*keys, *steps])
    return simulate(given.replace(obstacles=list(PEGS)))


def test_the_energy_and_the_impulses_of_all_contacts_add_up(rubbed):
    assert rubbed.outcome.label == "completed"
    assert abs(rubbed.balance["unaccounted"]) < 1e-6
    assert rubbed.balance["lost_impact"] > 0.5
    assert rubbed.balance["lost_friction"] > 1e-3
    lost = sum(c.energy_loss for c in rubbed.contacts)
    assert lost == pytest.approx(rubbed.balance["lost_impact"] + rubbed.balance["lost_friction"], rel=1e-9)
    for name in ("normal_impulse", "tangential_impulse"):
        total = sum(getattr(c, name) for c in rubbed.contacts)
        assert sum(getattr(e, name) for e in rubbed.events) == pytest.approx(total, rel=1e-9)


def test_contacts_push_and_rub_by_their_laws(rubbed):
    state, slip = rubbed["contact_state"].values, rubbed["contact_slip_rate"].values
    normal, along = rubbed["contact_lambda_n"].values, rubbed["contact_lambda_tau"].values
    slides = (state == 1) & (np.abs(slip) > 1e-3)
    assert slides.any()
    assert along[slides] == pytest.approx(-0.3 * normal[slides] * np.sign(slip[slides]), rel=1e-9)
    assert (normal[state != 0] > 0.0).all()
    assert (normal[state == 0] == 0.0).all()
    assert (np.abs(along) <= 0.3 * normal * (1.0 + 1e-9)).all()
    assert rubbed["contact_gap"].values.min() > -1e-6


@INERTIA
def test_momentum_and_energy_balance_in_every_step(inertia):
    """Without weight and damping the forces alone turn the beam about its pin, and take its energy."""
    step = 1e-5  # of which those that aim at a contact take parts, each of them a sample
    keys = "gravity=0", "beam.kelvin_voigt=0", "initial.angle=0", "initial.angular_velocity=-4", "end_time=0.02"
    mesh = "contact.grid=8", "discretization.elements=8", f"solver.contact_step={step}", f"solver.free_step={step}"
    keys = (*keys, f"contact.point_inertia={inertia}")
    found = built_in("slap", *keys, *mesh, f"solver.output_interval={0.1 * step}")
    force, gap = found["contact_lambda_n"].values, found["contact_gap"].values
    assert (force > 0.0).sum() > 100
    # of the mean axis, in which the beam has no momentum; mean velocities of 8 elements have a little less of it
    means = 1.0 - 0.25 / 8**2 if inertia == "none" else 1.0
    turned = means * Sections.from_scenario(found.scenario).mass / 3.0
    moments = np.diff(found["time"].values) * (force * found["contact_place"].values).sum(axis=1)[1:]
    gained = turned * np.diff(found["theta_dot"].values)
    work = (force[1:] * np.diff(gap, axis=0)).sum(axis=1)
    # but for the second order of angles and deflections
    assert gained == pytest.approx(moments, abs=5e-4 * moments.max())
    assert np.diff(found.total_energy.values) == pytest.approx(work, abs=5e-7)
    assert abs(found.balance["unaccounted"]) < 1e-7


def test_a_beam_at_rest_sticks_to_its_pegs_and_carries_its_weight():
    """How two pegs share an axial force is not determined: the event scheme ends there, impulses exist."""
    pegs = [{"kind": "point", "origin": [x, -1e-3], "radius": 1e-3} for x in (0.5, 0.9)]
    keys = ["beam.kelvin_voigt=0", "beam.modal_damping_ratio=0.9", "initial.angle=0", "end_time=0.05", STEPS]
    found = simulate(Scenario.builtin("two-pegs", [*keys, "solver.contact_step=1e-5"]).replace(obstacles=pegs))
    assert found.outcome.label == "completed"
    weight = Sections.from_scenario(found.scenario).mass * found.scenario.gravity
    forces, places = found["contact_lambda_n"].values[-1], found["contact_place"].values[-1]
    assert forces @ places == pytest.approx(0.5 * weight * found.scenario.beam.length, rel=1e-5)
    assert (found["contact_state"].values[-1] == 2).all()
    assert len(found.events) < 50
    assert np.abs(found["contact_slip_rate"].values[-1]).max() < 1e-12


def test_a_tip_that_has_fallen_past_a_table_is_not_lifted_by_it():
    """The free end falls past the end of the table; the corner alone holds the beam."""
    found = built_in("edge", "contact.grid=8", "discretization.elements=8", "solver.contact_step=2e-5")
    assert (found["contact_place"].values[found["contact_state"].values != 0] < 0.62).all()
    assert found["tip_y"].values.min() < -0.02


# --- friction laws


def test_a_law_without_a_stick_state_slips_by_nothing_where_coulombs_sticks():
    """On a beam at rest on two pegs acts what its law says at zero slip: of a regularized one nothing."""
    pegs = [{"kind": "point", "origin": [x, -1e-3], "radius": 1e-3} for x in (0.5, 0.9)]
    keys = "contact.grid=8 discretization.elements=8 initial.angle=0 end_time=0.02 contact.friction=hybrid "
    keys += "solver.contact_step=1e-5 solver.free_step=1e-5 beam.kelvin_voigt=1e-3"
    given = Scenario.builtin("slap", keys.split()).replace(obstacles=pegs)
    laws = Coulomb(0.3, 0.3), FrictionCurve(((0.0, 0.3),), 0.3), FrictionCurve(((0.0, 0.3),)), ModifiedCoulomb(0.3)
    rests, own, slips, smooth = (
        [r["contact_state"].values, r["contact_lambda_tau"].values]
        for r in (simulate(given, friction=law) for law in laws)
    )
    assert (rests[0][-1] == State.STICK).all()
    assert (np.array(own) == np.array(rests)).all()
    assert not (slips[0] == State.STICK).any()
    assert slips[1] == pytest.approx(rests[1], abs=0.2)
    assert np.abs(slips[1]).max() > 0.1
    assert not (smooth[0] == State.STICK).any()
    assert not smooth[1].any()


# --- one point, none, driven roots


@pytest.mark.parametrize(
    "keys",
    [
        "contact.surface=section beam.outer_fibre=0.01",
        "contact.axial_flexibility=true",
        "contact.point_inertia=none beam.kelvin_voigt=1e-5 discretization.frame=mean-axis discretization.modes=6",
        "contact.point_inertia=none beam.kelvin_voigt=1e-5 discretization.method=fem discretization.modes=0 "
        "discretization.elements=8",
    ],
    ids=["surface", "stretching", "no inertia, modes", "no inertia, nodes"],
)
def test_one_point_at_the_tip_is_the_free_end_alone(keys):
    common = *keys.split(), STEPS, "solver.contact_step=5e-6", "solver.free_step=5e-5", "end_time=0.33"
    point = built_in("paper", *common)
    anywhere = built_in("paper", *common, "contact.where=anywhere", "contact.grid=1")
    assert len(point.events) > 2
    assert [e.time for e in point.events] == [e.time for e in anywhere.events]
    assert np.array_equal(point["q"].values[-1], anywhere["q"].values[-1])


def test_a_point_inside_the_span_touches_as_by_located_events():
    keys = "contact.point=0.7 slope.origin=[0.1,0] contact.surface=section contact.shortening=false end_time=0.31 "
    keys += "beam.outer_fibre=0.01 beam.kelvin_voigt=1e-4 contact.friction=frictionless"
    located = built_in("paper", *keys.split())
    found = built_in("paper", *keys.split(), STEPS, "solver.free_step=1e-5")
    assert [e.kind for e in found.events] == [e.kind for e in located.events]
    assert [e.time for e in found.events] == pytest.approx([e.time for e in located.events], abs=1e-7)
    (a,), (b,) = found.contacts, located.contacts
    assert a.normal_impulse == pytest.approx(b.normal_impulse, rel=1e-5)


DRIVEN = "root.kind=driven initial.angle=0.5 beam.kelvin_voigt=1e-4 discretization.modes=3 "
SPUN_UP = f"{DRIVEN} root.profile=spin-up root.spin_rate=-2 root.spin_up_time=0.3 end_time=0.4"


@pytest.mark.parametrize("friction", ["frictionless", "hybrid"])
def test_what_a_driven_root_supplies_is_the_energy_and_all_losses(friction):
    """The root presses the beam onto the slope with some forty times the energy that it begins with."""
    keys = *SPUN_UP.split(), f"contact.friction={friction}"
    located = built_in("paper", *keys)
    found = built_in("paper", *keys, STEPS, "solver.free_step=1e-5", "solver.contact_step=1e-5")
    assert found.balance["supplied"] == pytest.approx(located.balance["supplied"], rel=3e-5)
    assert found.balance["supplied"] > 10.0 * found.balance["initial"]
    assert abs(found.balance["unaccounted"]) < 1e-8 * found.balance["final"]
    assert [e.kind for e in found.events] == [e.kind for e in located.events]
    late = 1e-7 if friction == "frictionless" else 5e-5  # impacts have friction here alone
    assert [e.time for e in found.events] == pytest.approx([e.time for e in located.events], abs=late)
    for name in ("tip_x", "tip_y"):
        assert found[name].values[-1] == pytest.approx(located[name].values[-1], abs=1e-6)


@pytest.mark.parametrize(
    "keys",
    ["end_time=0.3", f"{SPUN_UP} end_time=0.2", f"{DRIVEN} end_time=0.1 base.acceleration=30 base.frequency=20"],
    ids=["pin", "spin-up", "held and shaken"],
)
def test_a_free_run_is_of_second_order(keys):
    keys = *keys.split(), "contact.enabled=false"
    exact, apart = built_in("paper", *keys, "solver.tolerance=1e-12"), []
    for step in (1e-5, 5e-6):
        found = built_in("paper", *keys, STEPS, f"solver.free_step={step}")
        apart.append(np.hypot(*(found[name].values[-1] - exact[name].values[-1] for name in ("tip_x", "tip_y"))))
        assert abs(found.balance["unaccounted"]) < 1e-8 * abs(found.balance["final"])
    assert apart[0] < 5e-8
    assert apart[0] / apart[1] == pytest.approx(4.0, rel=0.05)

"""Contact anywhere along the exact beam: kinematics of a point on it, balances, one contact, a corner."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest

from oblique_impact import History, Outcome, Scenario, simulate
from oblique_impact.beam.beam import Energies
from oblique_impact.contact.state import State
from oblique_impact.fem_beam.exact import ElasticSections, ExactBeam, exact_problem
from oblique_impact.fem_beam.exact import simulate as simulate_exact
from oblique_impact.fem_beam.exact.exact_system import beam_of
from oblique_impact.fem_beam.exact.stop import place_of, point_on_beam, take_rows
from oblique_impact.history.samples import LAMBDA_N, gather
from oblique_impact.marching.loop import Run
from oblique_impact.marching.records import Record
from oblique_impact.validation.runs import NEAR

PEGS = ({"kind": "point", "origin": [0.4, -2e-3]}, {"kind": "point", "origin": [0.72, -4e-3], "radius": 1e-3})
EXACT = (
    "discretization.method=absolute",
    "contact.normal=spring",
    "discretization.elements=10",
    "solver.free_step=1e-4",
    "solver.contact_step=2e-5",
)


def run(*keys: str, obstacles=PEGS) -> History:
    """Run the paper's beam from the horizontal, everywhere in contact, among obstacles."""
    return simulate(scenario(*keys, obstacles=obstacles))


def scenario(*keys: str, obstacles=PEGS) -> Scenario:
    words = ["initial.angle=0", "initial.angular_velocity=-1", "end_time=0.02", *EXACT]
    words += ["contact.where=anywhere", f"slope.enabled={'false' if obstacles else 'true'}", *keys]
    items = [", ".join(f"{key} = {json.dumps(value)}" for key, value in item.items()) for item in obstacles]
    return Scenario.builtin("paper", [*words, f"obstacles=[{', '.join(f'{{{item}}}' for item in items)}]"])


# --- a point on the beam

BEAM = ExactBeam(np.array([0.0, 0.1, 0.35, 0.6, 1.0]), ElasticSections.uniform(1e4, 1e4, 500.0, 1.0))


def bent(seed: int) -> np.ndarray:
    return BEAM.straight(0.4) + 5e-3 * np.random.default_rng(seed).normal(size=BEAM.size)


def point_at(q: np.ndarray, along: float, below: float = 0.01, side: float = 1.0) -> Any:
    """A peg below the beam, near the place `along`."""
    r = np.interp(along, BEAM.x, q[0::3]) + 1j * np.interp(along, BEAM.x, q[1::3])
    return point_on_beam(r.real, r.imag - below, 2e-3, 5e-3, side)


@pytest.mark.parametrize("along", [0.05, 0.3499, 0.5, 0.97, 1.05])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_point_moves_on_the_beam_as_its_rows_say(along, side):
    """The gap changes by its row times the step, also across elements; its rate is the derivative of the gap."""
    q, beam = bent(1), BEAM.data
    point = point_at(q, along, side=side)
    v = np.random.default_rng(2).normal(size=BEAM.size)
    normal, tangential = np.zeros((2, BEAM.size))
    for size in (1e-1, 1e-3):
        take_rows(beam, point, q, q + size * v, normal, tangential)
        ends = [place_of(beam, point, q + part * v, v) for part in (0.0, size)]
        assert normal @ (size * v) == pytest.approx(ends[1].gap - ends[0].gap, rel=1e-11)
    at, ahead, behind = (place_of(beam, point, q + h * v, v) for h in (0.0, 1e-6, -1e-6))
    assert at.gap_rate == pytest.approx((ahead.gap - behind.gap) / 2e-6, rel=1e-6)
    # the middle of a step decides: its rows are those of the rate but for the square of the step
    take_rows(beam, point, q - 1e-5 * v, q + 1e-5 * v, normal, tangential)
    assert normal @ v == pytest.approx(at.gap_rate, rel=1e-6)
    assert tangential @ v == pytest.approx(at.slip_rate, rel=1e-6)


# --- runs


def test_one_contact_of_several_is_that_of_one_point():
    """A side without ends and the tip: the same events to the last digit."""
    words = ["discretization.elements=8", *NEAR, "end_time=0.004"]
    words += ["contact.mu_static=0.1", "contact.mu_kinetic=0.1"]
    alone = simulate(Scenario.builtin("paper", [*EXACT, *words]))
    several = run(*words, "contact.grid=1", obstacles=())
    assert len(alone.events) > 3
    assert [(e.time, e.kind) for e in several.events] == [(e.time, e.kind) for e in alone.events]
    assert [c.normal_impulse for c in several.contacts] == [c.normal_impulse for c in alone.contacts]
    assert np.array_equal(several["lambda_n"], alone["lambda_n"])
    assert np.array_equal(several["contact_lambda_tau"][:, 0], alone["lambda_tau"])


@pytest.mark.parametrize(
    "keys",
    [
        ("contact.mu_static=0.6", "contact.mu_kinetic=0.2"),
        ("contact.surface=section", "contact.mu_static=1", "contact.mu_kinetic=1"),
        ("contact.friction=modified-coulomb", "contact.regularization=[0.02, 0.2]"),
        ("contact.friction=frictionless", "contact.damping=0.1"),
        ("root.kind=driven", "root.profile=constant-speed", "root.spin_rate=-1", "root.hub_radius=0.02"),
        ("root.kind=hub", "root.inertia=0.01", "root.torque=-1", "beam.kelvin_voigt=1e-5"),
    ],
    ids=["friction", "face", "smoothed friction", "damped stop", "driven", "hub"],
)
def test_the_energy_of_several_contacts_is_accounted_for(keys):
    depth = 0.01 if "contact.surface=section" in keys else 0.0
    low = [{**peg, "origin": [peg["origin"][0], peg["origin"][1] - depth]} for peg in PEGS]
    start = ["initial.angular_velocity=0"] if "root.kind=driven" in keys else []
    found = run("end_time=0.03", *start, *keys, obstacles=low)
    assert found.outcome.label == "completed"
    assert {contact.obstacle for contact in found.contacts} == {1, 2}
    assert abs(found.balance["unaccounted"]) < 1e-11 * max(map(abs, (found.balance["initial"], 1.0)))
    lost = sum(contact.energy_loss for contact in found.contacts)
    if "beam.kelvin_voigt=1e-5" not in keys:
        assert lost == pytest.approx(found.balance["lost_friction"] + found.balance["lost_damping"], rel=1e-9)


@pytest.fixture(scope="module")
def pegs() -> History:
    """The beam falls onto two pegs, with friction."""
    return run("solver.output_interval=2e-5", "contact.mu_static=0.6", "contact.mu_kinetic=0.3")


def test_forces_at_their_places_turn_the_beam(pegs):
    """The angular momentum about the pin changes by the moments of weight and contact forces."""
    beam = beam_of(pegs.scenario)
    q, v, time = pegs["q"].values, pegs["qd"].values, pegs["time"].values
    momentum = [beam.angular_momentum(a, b) for a, b in zip(q, v, strict=True)]
    weight = beam.weight(pegs.scenario.gravity)
    moment = (pegs["contact_x"] * pegs["contact_fy"] - pegs["contact_y"] * pegs["contact_fx"]).values.sum(axis=1)
    moment += [beam.turning(a, 1.0) @ weight for a in q]
    gained = np.trapezoid(moment, time)
    assert momentum[-1] - momentum[0] == pytest.approx(gained, rel=1e-4)


def test_a_contact_pushes_at_its_obstacle_as_its_spring_and_coulomb_say(pegs):
    state, slip = pegs["contact_state"].values, pegs["contact_slip_rate"].values
    gap, normal, along = (pegs[f"contact_{name}"].values for name in ("gap", "lambda_n", "lambda_tau"))
    closed = state != State.FREE
    assert closed.any(axis=0).all()
    assert normal == pytest.approx(np.where(closed, np.maximum(0.0, -1e6 * gap), 0.0), abs=1e-6)
    slides, sticks = state == State.SLIP, state == State.STICK
    assert np.abs(along[slides]) == pytest.approx(0.3 * normal[slides], abs=1e-9)
    # a velocity that is left by the step in which stick ends, on 500 N
    assert np.max(along[slides] * slip[slides]) < 1e-4
    assert sticks.any(axis=0).all()
    assert (sticks.sum(axis=1) == 2).any()
    assert np.abs(slip[sticks]).max() < 1e-6
    assert np.all(np.abs(along[sticks]) <= 0.6 * normal[sticks] + 1e-9)
    for i, peg in enumerate(PEGS):
        away = np.hypot(pegs["contact_x"][:, i] - peg["origin"][0], pegs["contact_y"][:, i] - peg["origin"][1])
        radius = peg.get("radius", 0.0)
        assert away.values[closed[:, i]] == pytest.approx(np.abs(radius + gap[closed[:, i], i]), abs=1e-9)
    impulses = [[c.normal_impulse for c in pegs.contacts if c.obstacle == number] for number in (1, 2)]
    found = np.trapezoid(normal, pegs["time"].values, axis=0)
    assert [sum(each) for each in impulses] == pytest.approx(found, rel=1e-2)


def test_variables_are_those_of_modes(pegs):
    given = scenario("end_time=0.005").adapted(discretization__method="modal", solver__scheme="event")
    modes = simulate(given)
    assert set(pegs) | {"qdd"} == set(modes)
    for name in set(modes) - {"qdd"}:
        assert pegs[name].dims == modes[name].dims, name
        assert str(pegs[name].attrs) == str(modes[name].attrs), name
    here, there = pegs.events[0], modes.events[0]
    assert here.obstacle == there.obstacle
    assert here.time == pytest.approx(there.time, rel=1e-3)
    assert here.place == pytest.approx(there.place, abs=1e-5)


def test_points_of_the_beam_get_nodes_and_meet_a_side():
    """A flat table just below the beam: the places of contact.grid touch it and nothing else does."""
    found = run(
        "contact.grid=3",
        "discretization.elements=8",
        "contact.stiffness=1e5",
        "end_time=0.01",
        obstacles=[{"kind": "side", "origin": [0.0, -1e-3]}],
    )
    assert {round(event.place, 12) for event in found.events} == {round(1 / 3, 12), round(2 / 3, 12), 1.0}
    assert abs(found.balance["unaccounted"]) < 1e-11


def thrown(speed: float, extent: list[float]) -> Thrown:
    """A soft bar that lies on a table is thrown lengthwise (m/s)."""
    table = {"kind": "side", "origin": [0.0, -1e-6], "extent": extent, "stiffness": 1e4}
    keys = ("initial.angular_velocity=0", "end_time=0.008", "contact.friction=frictionless", "contact.grid=1")
    given = scenario(*keys, "solver.output_interval=1e-3", obstacles=[table])
    beam = beam_of(given, replace(ElasticSections.of(given), axial=lambda x: 1e5 + 0.0 * x))
    problem = exact_problem(given, beam)
    problem.qd0[0::3] += speed * beam.x
    record = Run(problem).execute()

    def energies(time: np.ndarray, q: np.ndarray, v: np.ndarray) -> Energies:
        return Energies(beam.kinetic_energy(v), beam.elastic_energy(q), -q @ beam.weight(given.gravity))

    found = gather(record.segments, beam.size, energies)
    return Thrown(
        record,
        np.concatenate([segment.times for segment in record.segments]),
        found.contacts[:, :, LAMBDA_N],
        found.kinetic + found.elastic + found.gravity,
    )


class Thrown(NamedTuple):
    """A run with the normal forces (N) of its contacts and the energy (J) of the beam at its samples."""

    record: Record
    times: np.ndarray
    normal: np.ndarray
    energy: np.ndarray


def test_the_tip_slides_over_an_edge_onto_its_corner_and_back():
    """The force has no jump, and no energy is lost."""
    march = thrown(0.4, [0.9, 1.0003])
    record = march.record
    assert [passage.how.value for passage in record.passages] == ["slides off", "slides off"]
    off, back = record.passages
    assert off.place == pytest.approx(1.0003, abs=1e-8)  # of the tip on the side
    assert back.place == pytest.approx(-1.0, abs=1e-12)  # of the corner on the beam
    for passage in record.passages:
        assert [event.kind.value for event in record.events if event.time == passage.time] == ["release", "impact"]
        before, after = march.normal[march.times == passage.time].sum(axis=1)
        assert before > 0.05
        assert after == pytest.approx(before, rel=1e-6)
    corner = [contact for contact in record.contacts if contact.start == off.time]
    assert [contact.end for contact in corner] == [back.time]
    assert corner[0].first_place == pytest.approx(1.0003 / 1.0007, abs=5e-4)
    springs = 0.5 * np.sum(march.normal**2, axis=1) / 1e4
    assert np.ptp(march.energy + springs) < 1e-11
    assert [contact.energy_loss for contact in record.contacts] == pytest.approx([0.0] * 4, abs=1e-11)


def test_section_forces_jump_where_pegs_push_as_those_of_modes_do():
    """Two pegs inside of elements, where the beam hardly bends; damped, so that few modes are enough."""
    low = [{"kind": "point", "origin": [x, -x / 500], "stiffness": 1e5} for x in (0.43, 0.77)]
    words = ["contact.friction=frictionless", "initial.angular_velocity=-0.2", "beam.kelvin_voigt=1e-4"]
    words += ["discretization.frame=mean-axis", "end_time=0.0125", "solver.output_interval=5e-4"]
    in_modes = scenario(*words, obstacles=low).adapted(
        discretization__method="modal", solver__scheme="event", discretization__modes=16
    )
    known = simulate(in_modes)
    given = scenario(*words, "discretization.elements=16", obstacles=low)
    found = simulate_exact(given, sections=ElasticSections.bernoulli_euler(given))
    forces = [history.section_forces() for history in (found, known)]
    for time in (0.0105, 0.0115):
        assert (found.at(time)["contact_lambda_n"] > 10.0).all()
        here, there = (each.sel(time=time, method="nearest") for each in forces)
        for name, share in (("moment", 3e-3), ("shear", 3e-3), ("axial_force", 1e-2)):
            scale = float(np.abs(there[name]).max())
            assert float(np.abs(here[name] - there[name]).max()) < share * scale, name


def test_the_end_of_stick_on_a_peg_is_located_inside_of_a_step():
    """Its time converges with at least the second order of the step: it is no multiple of one."""
    words = ["contact.mu_static=0.6", "contact.mu_kinetic=0.3", "beam.kelvin_voigt=1e-5", "end_time=0.0058"]
    words += ["discretization.elements=8", "solver.output_interval=1e-3"]
    ends = []
    for step in (4e-5, 2e-5, 1e-5):
        found = run(*words, f"solver.free_step={step}", f"solver.contact_step={step}")
        ends.append([event.time for event in found.events if event.kind.value == "slip"])
    (coarse,), (middle,), (fine,) = ends
    assert 0.0 < abs(fine - middle) < 0.3 * abs(middle - coarse)
    assert abs(fine - middle) < 3e-7


def test_stick_on_a_peg_begins_and_ends_by_the_force_that_holds_the_place():
    """The tangent turns with the beam that falls onto the peg: to hold the place is not to keep its velocity."""
    words = [
        "discretization.method=absolute",
        "discretization.elements=4",
        "contact.where=anywhere",
        "contact.normal=spring",
        "contact.stiffness=1e5",
        "beam.tip_mass=0.05",
        "initial.angle=0.32",
        "initial.angular_velocity=-4",
        "slope.enabled=false",
        'obstacles=[{kind="point",origin=[0.386,0.106],radius=0.02},{kind="point",origin=[0.767,0.229],radius=0.02}]',
        "solver.free_step=2e-5",
        "solver.contact_step=2e-6",
        "solver.output_interval=2e-6",
        "end_time=0.004",
    ]
    history = simulate(Scenario.builtin("paper", words))
    assert history.outcome is Outcome.COMPLETED
    states = history["contact_state"].values
    pressed, rubbed = history["contact_lambda_n"].values, np.abs(history["contact_lambda_tau"].values)
    ends = []
    for i in range(states.shape[1]):
        last = np.flatnonzero((states[:-1, i] == State.STICK) & (states[1:, i] == State.SLIP))
        ends += [rubbed[k, i] / pressed[k, i] for k in last if pressed[k, i] > 1.0]
    assert len(ends) >= 2
    # at the edge of its cone, but for what the forces change in a sample
    assert min(ends) > 0.3 * 0.97

"""The beam in absolute coordinates as a discretization: contact states, history, balance, outcomes, refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oblique_impact import History, Outcome, Scenario, simulate
from oblique_impact.beam_problem import Parts
from oblique_impact.contact.friction import FrictionCurve
from oblique_impact.contact.state import SLIDING, Candidate, State
from oblique_impact.fem_beam.exact import ElasticSections, ExactBeam, Stage, advance
from oblique_impact.fem_beam.exact import simulate as simulate_absolute
from oblique_impact.fem_beam.exact.stop import node_on_side, place_of, take_rows
from oblique_impact.validation.runs import NEAR

ABSOLUTE = ("discretization.method=absolute", "contact.normal=spring")
#: just above the slope, in steps that a test can afford
QUICK = (
    *ABSOLUTE,
    *NEAR,
    "discretization.elements=12",
    "solver.contact_step=1e-5",
    "solver.output_interval=1e-4",
    "end_time=0.006",
)


@pytest.fixture(scope="module")
def smooth() -> History:
    return simulate(Scenario.builtin("paper", [*QUICK, "contact.friction=frictionless"]))


def test_energy_is_kept_to_rounding(smooth):
    assert [event.kind.value for event in smooth.events][:4] == ["impact", "release", "impact", "release"]
    energy = smooth.summary["energy"]
    assert abs(energy["unaccounted"]) < 1e-11 * energy["initial"]
    assert energy["lost_friction"] == energy["lost_damping"] == energy["lost_scheme"] == 0.0
    flying = smooth["state"].values == int(State.FREE)
    total = smooth.total_energy.values[flying]
    assert np.ptp(total) < 1e-11 * total[0]


def test_variables_are_those_of_the_nodal_model_with_another_mechanics():
    """A falling beam, smooth enough to compare: the same names, dimensions, frames and signs."""
    words = ["contact.enabled=false", "end_time=0.2", "discretization.frame=mean-axis", "initial.angle=0.3"]
    nodal = ["discretization.method=fem", "discretization.modes=0", "solver.free_step=2e-5"]
    words += ["beam.kelvin_voigt=1e-3", "discretization.elements=12", "solver.output_interval=1e-2"]
    words += ["root.kind=hub", "root.inertia=0.1", "root.torque=1"]
    scenario = Scenario.builtin("paper", [*words, "discretization.method=absolute"])
    found = simulate_absolute(scenario, sections=replace(ElasticSections.of(scenario), rotary=lambda x: 0.0 * x))
    known = simulate(Scenario.builtin("paper", [*words, *nodal]))
    now, then = (history.data.merge(history.section_forces()) for history in (found, known))
    then = then.drop_vars("qdd")  # of which the others compute what files leave out
    assert set(now.variables) >= set(then.variables)
    for name in then.variables:
        assert now[name].dims == then[name].dims, name
        assert str(now[name].attrs) == str(then[name].attrs), name
    now, then = now.isel(time=-1), then.isel(time=-1)
    shares = {
        "theta": 1e-5,
        "tip_vy": 1e-4,
        "uy": 2e-3,
        "energy_elastic": 5e-3,
        "moment": 2e-3,
        "axial_force": 5e-3,
    }
    for name, share in shares.items():
        scale = float(np.abs(then[name]).max())
        assert float(np.abs(now[name] - then[name]).max()) < share * scale, name


def test_a_place_in_the_section_moves_as_its_rows_say():
    """However far the section turns within a step; and the rates are those rows in the limit of a short step."""
    beam = ExactBeam(np.array([0.0, 1.0]), ElasticSections.uniform(1e7, 1e7, 500.0, 1.0))
    point = node_on_side(2, 0.3, 0.02, 0.1, fibre=-0.04)
    q0, q1, normal, tangential = np.zeros((4, beam.size))
    q0[-3:], q1[-3:] = (0.3, 0.2, 0.5), (0.35, 0.1, 1.9)
    places = [place_of(beam.data, point, q, q) for q in (q0, q1)]
    ends = take_rows(beam.data, point, q0, q1, normal, tangential)
    assert ends[:2] == pytest.approx([place.gap for place in places], rel=1e-13)
    assert normal @ (q1 - q0) == pytest.approx(places[1].gap - places[0].gap, rel=1e-13)
    assert tangential @ (q1 - q0) == pytest.approx(places[1].slip - places[0].slip, rel=1e-13)
    v = np.random.default_rng(1).normal(size=beam.size)
    ahead, behind = (place_of(beam.data, point, q0 + h * v, v) for h in (1e-5, -1e-5))
    now = place_of(beam.data, point, q0, v)
    assert now.gap_rate == pytest.approx((ahead.gap - behind.gap) / 2e-5, rel=1e-8)
    assert now.slip_rate == pytest.approx((ahead.slip - behind.slip) / 2e-5, rel=1e-8)


def test_contact_on_the_face_keeps_the_balance_and_is_that_of_the_floating_frame():
    """With friction, slip and stick: the force turns the section, and its work is that of the rows."""
    face = [
        *QUICK,
        "contact.surface=section",
        "contact.mu_static=2",
        "contact.mu_kinetic=2",
        "initial.angle=0.2318",
    ]
    rough = simulate(Scenario.builtin("paper", face))
    kinds = {event.kind.value for event in rough.events}
    assert {"impact", "stick", "slip"} <= kinds
    energy = rough.summary["energy"]
    assert energy["lost_friction"] > 1e-3
    assert abs(energy["unaccounted"]) < 1e-10 * energy["initial"]
    for event in rough.events:
        if event.kind.value in ("impact", "release"):
            assert abs(float(rough.at(event.time)["gap"])) < 1e-12
    frictionless = [line for line in face if "mu_" not in line] + ["contact.friction=frictionless"]
    exact = simulate(Scenario.builtin("paper", frictionless)).contacts[0]
    floating = [line for line in frictionless if not line.startswith(("discretization.", "solver.contact_step"))]
    floating += ["discretization.modes=12", "discretization.frame=mean-axis"]
    reduced = simulate(Scenario.builtin("paper", floating)).contacts[0]
    assert exact.start == pytest.approx(reduced.start, abs=2e-6)
    assert exact.normal_impulse == pytest.approx(reduced.normal_impulse, rel=0.02)  # shear and extension


# --- friction laws whose force depends on the slip velocity

#: a light touch on a soft stop: deflections of 2e-4 of the length
TOUCH = (
    "contact.normal=spring",
    "contact.stiffness=1e5",
    "initial.angle=0.2214",
    "initial.angular_velocity=-0.5",
    "end_time=0.0074",
    "discretization.frame=mean-axis",
    "discretization.elements=16",
    "solver.output_interval=1e-4",
)
MODIFIED = ("contact.friction=modified-coulomb", "contact.regularization=[0.005, 0.05]")
SMOOTHED = FrictionCurve(((0.0, 0.0), (0.005, 0.0), (0.05, 0.3)))
WEAKER_FAST = FrictionCurve(((0.0, 0.0), (0.02, 0.4), (0.1, 0.25)))
STRIBECK = FrictionCurve(((0.0, 0.3), (0.02, 0.1), (0.1, 0.25)), static=0.3)


def touch(*keys: str, friction: FrictionCurve | None = None, stiffer: float = 1.0) -> History:
    """Run the exact beam without shear and rotary inertia, along its axis as much stiffer as given."""
    steps = "solver.free_step=1e-5", "solver.contact_step=1e-5"
    scenario = Scenario.builtin("paper", [*TOUCH, "discretization.method=absolute", *steps, *keys])
    sections = ElasticSections.bernoulli_euler(scenario)
    stiff = replace(sections, axial=lambda x: stiffer * sections.axial(x))
    return simulate_absolute(scenario, sections=stiff, parts=Parts(friction=friction))


def coefficient(law: FrictionCurve, speed: np.ndarray) -> np.ndarray:
    return np.interp(speed, *zip(*law.points, strict=True))


@pytest.mark.parametrize("law", [SMOOTHED, WEAKER_FAST], ids=["modified-coulomb", "curve"])
def test_friction_over_slip_velocity_is_that_of_the_floating_frame(law):
    """Both are in the smoothed part of their laws, which 12 modes find to 2e-3 beside 20.

    100 times as stiff along its axis, the exact beam is off by 2e-4 of what it tends to.
    """
    keys, own = (MODIFIED, None) if law is SMOOTHED else ((), law)
    elements = [*TOUCH, *keys, "discretization.method=fem", "discretization.modes=20"]
    known, found = (
        simulate(Scenario.builtin("paper", elements), friction=own),
        touch(*keys, friction=own, stiffer=100),
    )
    assert found.balance["lost_friction"] == pytest.approx(known.balance["lost_friction"], rel=5e-4)
    (here,), (there,) = found.contacts, known.contacts
    assert here.end == pytest.approx(there.end, abs=1e-6)
    assert here.normal_impulse == pytest.approx(there.normal_impulse, rel=5e-5)
    largest = max(mu for _, mu in law.points) * there.normal_impulse
    assert here.tangential_impulse == pytest.approx(there.tangential_impulse, abs=1e-3 * largest)
    assert [event.kind for event in found.events] == [event.kind for event in known.events]


@pytest.mark.parametrize("law", [SMOOTHED, WEAKER_FAST, STRIBECK], ids=["modified-coulomb", "curve", "with stick"])
def test_friction_over_slip_velocity_keeps_the_balance_and_its_law(law):
    """Steps end at the kinks of the law, and each sample is on its curve."""
    found = touch(friction=law)
    assert abs(found.balance["unaccounted"]) < 1e-12 * found.balance["initial"]
    assert sum(contact.energy_loss for contact in found.contacts) == pytest.approx(found.balance["lost_friction"])
    state, rate = found["state"].values, found["slip_rate"].values
    slides, sticks = state == State.SLIP, state == State.STICK
    normal, along = found["lambda_n"].values, found["lambda_tau"].values
    due = -np.sign(rate) * coefficient(law, np.abs(rate)) * normal
    moves = slides & (np.abs(rate) > 1e-9)
    assert along[moves] == pytest.approx(due[moves], abs=1e-7)
    assert sticks.any() == (law.static is not None)
    assert np.all(np.abs(along[sticks]) <= 0.3 * normal[sticks] * (1.0 + 1e-9))
    kink = law.points[1][0]
    assert np.abs(rate[slides] + kink).min() < 1e-10


def test_newtons_iterations_know_the_slope_of_friction():
    """On a drag that is as large as the inertia of a step they square their errors as on none."""
    beam = ExactBeam(np.array([0.0, 0.5, 1.0]), ElasticSections.uniform(1e7, 1e7, 500.0, 1.0))
    point = node_on_side(4, 0.1)
    q = beam.straight(0.1)
    q[-2] -= 1e-3
    v = beam.turning(q, -0.5)
    v[0::3] += 0.3 * beam.x
    counts = []
    for slope in (0.0, -100.0):
        contact = Candidate(state=SLIDING, compliant=1, stiffness=1e6, slope=slope)
        step = advance(beam, Stage(q, v), 1e-5, 0.0 * q, held=np.zeros(2), contacts=[(point, contact)])
        counts.append(len(step.increments))
    assert max(counts) <= 4, counts


# --- the length of steps


def test_steps_in_contact_are_chosen_by_their_error():
    """The error is their number's power -2, and their number the tolerance's power -1/3."""
    words = [*ABSOLUTE, *NEAR, "discretization.elements=12", "contact.friction=frictionless", "end_time=0.006"]
    words += ["beam.kelvin_voigt=1e-5", "solver.output_interval=1e-3"]
    bounds = ["solver.contact_step=1e-7", "solver.free_step=1e-3"]
    impulses, counts = [], []
    for tolerance in (1e-7, 1e-8, 1e-9, 1e-12):
        found = simulate(Scenario.builtin("paper", [*words, *bounds, f"solver.tolerance={tolerance}"]))
        assert abs(found.balance["unaccounted"]) < 1e-11
        impulses.append(found.contacts[0].normal_impulse)
        counts.append(found.summary["steps"])
    errors = np.abs(np.array(impulses[:-1]) / impulses[-1] - 1.0)
    assert errors[-1] < 1e-4
    orders = np.log(errors[:-1] / errors[1:]) / np.log(np.divide(counts[1:-1], counts[:-2]))
    assert np.all((orders > 1.6) & (orders < 2.6)), (errors, counts)
    assert 1.7 < counts[2] / counts[1] < 2.5
    bounded = simulate(Scenario.builtin("paper", [*words, "solver.contact_step=1e-4", "solver.free_step=1e-4"]))
    assert bounded.summary["steps"] < 80


def test_a_gap_that_closes_and_opens_within_a_step_is_found():
    """The tip of a turning beam grazes a ceiling for three milliseconds, in steps of up to ten."""
    ceiling = ["slope.origin=[0, 0.999999]", f"slope.angle={np.pi}", f"initial.angle={0.5 * np.pi - 0.02}"]
    words = [*ABSOLUTE, "contact.friction=frictionless", "discretization.elements=2", *ceiling, "gravity=0"]
    words += ["initial.angular_velocity=1", "end_time=0.04", "solver.output_interval=0.04"]
    steps = ["solver.contact_step=1e-3", "solver.free_step=1e-2", "solver.tolerance=1e-2"]
    found = simulate(Scenario.builtin("paper", [*words, *steps]))
    assert found.summary["rejected_steps"] > 0
    assert found.contacts[0].start == pytest.approx(0.02 - np.sqrt(2e-6), abs=5e-5)


# --- forces along the beam


HELD = ("discretization.method=absolute", "contact.enabled=false", "beam.kelvin_voigt=1e-4", "initial.angle=-0.5")


@pytest.mark.parametrize("step", [2e-3, 2e-4])
def test_the_axial_force_at_rest_is_the_weight_in_every_sample(step):
    """A held beam that hangs down by 0.5 rad carries what is outside of each section; its swaying adds 1e-3."""
    words = [*HELD, "root.kind=driven", "discretization.elements=8", f"solver.free_step={step}", "end_time=0.06"]
    history = simulate(Scenario.builtin("paper", [*words, "solver.output_interval=2e-3"]))
    beam, x = Scenario.from_toml(history.scenario_toml).beam, history["station"].values
    weight = 9.8 * beam.density * beam.area * (beam.length - x) * np.sin(0.5)
    settled = history.section_forces()["axial_force"].values[15:]  # after the axial vibration of the release
    assert np.abs(settled - weight).max() < 5e-3 * weight[0]


# --- what a person meets


def test_frequencies_are_refused_in_one_line(refused):
    assert 'use "fem" or "modal"' in refused("modes", "paper", *(w for c in ABSOLUTE for w in ("--set", c)))


def test_a_step_that_does_not_converge_ends_the_run_by_name():
    """A beam as soft as a thread, hurled at the stop, in steps of a tenth of a second."""
    words = [*QUICK, "beam.youngs_modulus=1e7", "solver.free_step=0.1", "solver.contact_step=0.1", "end_time=1"]
    history = simulate(Scenario.builtin("paper", [*words, "solver.output_interval=0.1", "initial.angle=1.2"]))
    assert history.outcome is Outcome.NOT_CONVERGED
    assert "free_step" in history.summary["message"]
    assert np.isfinite(history["theta"].values).all()


@pytest.mark.parametrize(
    "extreme", ["beam.youngs_modulus=1e-300", "beam.density=1e30", "initial.angular_velocity=1e30", "gravity=1e6"]
)
def test_extreme_numbers_end_by_a_name(extreme):
    """No warning, no traceback, no endless loop; whatever can be computed is finite or said to have diverged."""
    words = [*ABSOLUTE, extreme, "discretization.elements=2", "end_time=0.01", "solver.contact_step=1e-4"]
    history = simulate(Scenario.builtin("paper", [*words, "solver.output_interval=1e-3"]))
    assert history.outcome in set(Outcome)
    assert len(history["time"]) > 0

"""Starts at rest of the beam in absolute coordinates: closed forms, runs that stay there, plucked beams."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

from oblique_impact import InputError, Scenario, simulate
from oblique_impact.fem_beam.exact import ElasticSections, ExactBeam
from oblique_impact.fem_beam.exact import simulate as simulate_absolute
from oblique_impact.fem_beam.exact.exact_rest import ExactBalance, find_rest
from oblique_impact.fem_beam.exact.exact_system import beam_of

REST = ["discretization.elements=8", "initial.state=equilibrium", "end_time=0.02", "solver.output_interval=1e-3"]
CLAMPED = ["root.kind=driven", "initial.angle=0"]
FREE = ["contact.enabled=false"]
PEGS = [
    "contact.normal=spring",
    "contact.where=anywhere",
    "slope.enabled=false",
    "obstacles=[{kind='point',origin=[0.6,0.005],radius=0.008},{kind='point',origin=[0.9,-0.005],radius=0.01}]",
]
BED = [
    *PEGS[:3],
    "obstacles=[{origin=[0.6,0],extent=[-0.15,0.13],bedding=1e6}]",
    "contact.grid=8",
    "initial.angle=0",
]
STIFF = 68.952e9 * 7.85e-9  # E I, N m^2


def absolute(*words: str) -> Scenario:
    return Scenario.builtin("paper", [*REST, *words, "discretization.method=absolute"])


def elastica(load: float) -> tuple[float, float, float]:
    """Rotation and place of the tip of a clamped beam, L = 1, under a dead load F L^2/(E I) across its first axis.

    Bisshopp and Drucker, Large deflection of cantilever beams, Q. Appl. Math. 3 (1945).
    """

    def amplitude(tip: float) -> tuple[float, float]:
        k = math.sqrt(0.5 * (1.0 + math.sin(tip)))
        return k * k, math.asin(1.0 / (math.sqrt(2.0) * k))

    root = math.sqrt(load)
    tip = brentq(
        lambda at: ellipk(amplitude(at)[0]) - ellipkinc(amplitude(at)[1], amplitude(at)[0]) - root,
        1e-9,
        1.57,
        xtol=1e-14,
    )
    square, begin = amplitude(tip)
    along = math.sqrt(2.0 * math.sin(tip)) / root
    return tip, along, 1.0 - 2.0 / root * (ellipe(square) - ellipeinc(begin, square))


@pytest.mark.parametrize("load", [1.0, 10.0])
def test_a_dead_load_bends_a_clamped_beam_into_the_elastica(load):
    """With the fourth power of the elements' size; at a load of 10 the tip turns by 82 degrees."""
    errors, known = [], elastica(load)
    for elements in (4, 8, 16):
        words = f"forces=[{{force={load * STIFF},direction={math.pi / 2}}}]", "gravity=0"
        scenario = absolute(*FREE, *CLAMPED, *words, f"discretization.elements={elements}")
        rigid = ElasticSections.uniform(1e9 * STIFF, 1e9 * STIFF, STIFF, 1.0)
        balance, found = find_rest(scenario, beam_of(scenario, rigid))
        x, y, phi = balance.beam.nodes(found.q)[-3:]
        errors.append(np.abs(np.array([phi, x, y]) - known))
    assert np.all(errors[-1] < 2e-6)
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 3.7)


@pytest.mark.parametrize("radius", [0.0, 0.2])
def test_forces_at_rest_have_their_derivatives(radius):
    """In a state that is far from straight, with a follower, masses, a hub's radius, pegs, and a face."""
    words = [
        *PEGS,
        "contact.surface=section",
        "forces=[{place=0.73,force=900},{force=200,direction=1}]",
        "masses=[{place=0.4,mass=2}]",
        "initial.angle=0.1",
    ]
    scenario = absolute(*words)
    own = beam_of(scenario)
    balance = ExactBalance(scenario, ExactBeam(own.ends, own.sections, scenario.point_masses, 0.0, radius))
    rng = np.random.default_rng(3)
    z = balance.beam.start + 0.02 * rng.normal(size=balance.beam.size)
    closed = np.ones(balance.count, dtype=bool)

    def pushed(at: np.ndarray) -> np.ndarray:
        point = balance.at(at, 0.0 * at, closed)
        return point.load + point.pressing @ point.rows[:, 0]

    pressing = balance.at(z, 0.0 * z, closed).pressing
    tangent = balance.beam.rest_stiffness(z) + balance.linearize(z, closed, pressing).stiffness
    for _ in range(5):
        move = rng.normal(size=z.size)
        ahead, behind = pushed(z + 1e-6 * move), pushed(z - 1e-6 * move)
        assert tangent @ move == pytest.approx(
            (behind - ahead) / 2e-6, rel=2e-6, abs=1e-6 * np.abs(tangent @ move).max()
        )


RESTING = {
    "follower": [*FREE, *CLAMPED, "forces=[{force=2000}]", "masses=[{place=0.3,mass=1}]"],
    "pegs": [*PEGS, *CLAMPED],
    "bed": BED,
    "pin on the slope": ["contact.normal=spring", "initial.angle=0.4"],
    "hub": ["contact.normal=spring", "root.kind=hub", "root.inertia=0.1", "root.torque=-2", "initial.angle=0.4"],
    "face": ["contact.normal=spring", "contact.surface=section", "contact.damping=0.3", "initial.angle=0.4"],
    "hanging": [*FREE, "initial.angle=-1.2"],
}


@pytest.mark.parametrize("name", RESTING)
def test_a_run_that_starts_at_rest_stays_there(name):
    history = simulate(absolute(*RESTING[name]))
    assert history.outcome.label == "completed"
    q, forces = history["q"].values, history["contact_lambda_n"].values
    assert np.abs(q - q[0]).max() < 2e-13
    assert np.abs(forces - forces[0]).max() <= 1e-9 * max(1.0, forces.max())
    assert np.abs(history["contact_lambda_tau"].values).max() < 1e-6
    assert np.ptp(history["contact_state"].values, axis=0).max() == 0
    moment = history.section_forces()["moment"].values
    assert np.abs(moment - moment[0]).max() < 1e-7 * max(1.0, np.abs(moment).max())


@pytest.mark.parametrize("name", ["pegs", "bed", "pin on the slope", "hub"])
def test_small_deflections_at_rest_are_those_of_all_nodes(name):
    words = [word for word in RESTING[name] if "end_time" not in word] + ["end_time=1e-3"]
    scenario = absolute(*words)
    now = simulate_absolute(scenario, sections=ElasticSections.bernoulli_euler(scenario))
    nodal = ["discretization.method=fem", "discretization.modes=0", "discretization.frame=tangent"]
    frame = nodal if "root.kind=driven" in words else nodal[:2]
    then = simulate(Scenario.builtin("paper", [*REST, *words, *frame]))
    pressed = then["contact_lambda_n"].values[0]
    assert pressed.max() > 1.0
    assert now["contact_lambda_n"].values[0] == pytest.approx(pressed, rel=2e-3, abs=1e-6 * pressed.max())
    moment, known = (history.section_forces()["moment"].values[0] for history in (now, then))
    assert moment == pytest.approx(known, abs=5e-3 * np.abs(known).max())


def test_a_plucked_beam_is_let_go_with_the_energy_that_bent_it():
    """At the tip by a deflection, the force of which is 3 E I w/L^3; the run keeps the energy."""
    words = [*FREE, *CLAMPED, "gravity=0", "initial.state=plucked", "initial.place=1"]
    history = simulate(absolute(*words, "initial.deflection=0.001", "end_time=0.05"))
    assert float(history["tip_y"][0]) == pytest.approx(0.001, rel=1e-12)
    assert float(history["energy_elastic"][0]) == pytest.approx(1.5 * STIFF * 1e-6, rel=1e-3)  # it shears besides
    assert abs(history.summary["energy"]["unaccounted"]) < 1e-12 * float(history["energy_elastic"][0])
    assert float(history["tip_y"].min()) < -0.0009
    force = simulate(absolute(*words, f"initial.force={10 * STIFF}", "end_time=1e-4"))
    tip, along, across = elastica(10.0)
    # it stretches and shears by 3e-4 besides
    assert float(force["tip_x"][0]) == pytest.approx(along, abs=5e-4)
    assert float(force["tip_y"][0]) == pytest.approx(across, abs=5e-4)
    assert float(force["q"][0, -1]) == pytest.approx(tip, abs=5e-4)


def test_a_plucked_beam_lets_go_of_its_contacts_by_their_forces():
    history = simulate(absolute(*PEGS, *CLAMPED, "initial.state=plucked", "initial.place=1", "initial.force=60"))
    assert history.outcome.label == "completed"
    at_rest = simulate(absolute(*PEGS, *CLAMPED))["contact_lambda_n"].values[0]
    held = history["contact_lambda_n"].values[0]
    assert held[1] < at_rest[1]  # lifted off the lower peg
    assert abs(history.summary["energy"]["unaccounted"]) < 1e-11 * history.summary["energy"]["elastic"]


def test_a_beam_that_nothing_holds_is_refused_in_one_line():
    with pytest.raises(InputError, match="nothing holds the beam") as error:
        simulate(absolute(*FREE, "root.kind=hub", "root.inertia=0.1", "root.torque=100"))
    assert "\n" not in str(error.value)

"""Runs that start in equilibrium or plucked: closed forms, section forces, and rest in every scheme."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from oblique_impact import InputError, Scenario, simulate
from oblique_impact.beam_problem import beam_of
from oblique_impact.contact.stops import ContactLaw
from oblique_impact.resting import Rest, state_at_rest

LENGTH, GRAVITY = 1.0, 9.8
STIFFNESS = 68.952e9 * 7.85e-9  # N m^2
WEIGHT = 3.14e-4 * 2766.7 * GRAVITY  # N/m
NODAL = {"method": "fem", "elements": 8, "modes": 0}
MODELS = {
    "modes": {"modes": 12},
    "mean axis": {"modes": 12, "frame": "mean-axis"},
    "reduced": {"method": "fem", "elements": 8, "modes": 8},
    "nodal": NODAL,
}


def cantilever(**sections):
    """A clamped horizontal beam in equilibrium, without contact unless the sections say so."""
    plain = {
        "end_time": 2e-3,
        "root": {"kind": "driven"},
        "contact": {"enabled": False},
        "discretization": MODELS["modes"],
        "solver": {"output_interval": 1e-4},
    }
    initial = {"angle": 0.0, "state": "equilibrium"} | sections.pop("initial", {})
    return Scenario.from_dict(plain | sections | {"initial": initial})


def at_rest(scenario: Scenario) -> tuple[np.ndarray, np.ndarray, Rest]:
    """Stations (m), deflections there (m) and what is at rest."""
    beam = beam_of(scenario)
    found = state_at_rest(beam)
    stations = beam.operators.stations
    return stations.points, stations.values @ beam.split(found.q)[1:], found


def stop(kind, height, **keys):
    """A stop under the tip, so high (m) above the straight beam."""
    given = {"rigid": {}, "spring": {"normal": "spring", "stiffness": 1e4}}[kind]
    return {"contact": given | keys, "slope": {"origin": [LENGTH, height], "angle": 0.0}}


@pytest.mark.parametrize("model", ["modes", "reduced", "nodal"])
def test_a_cantilever_bends_under_its_weight(model):
    x, w, _ = at_rest(cantilever(discretization=MODELS[model]))
    exact = -WEIGHT * x**2 * (x**2 - 4 * LENGTH * x + 6 * LENGTH**2) / (24 * STIFFNESS)
    # between nodes cubics are off by w h^4/(384 E I)
    assert w == pytest.approx(exact, abs=1.1 * WEIGHT / 8**4 / (384 * STIFFNESS) if model == "nodal" else 2e-7)


@pytest.mark.parametrize("model", ["modes", "reduced", "nodal"])
@pytest.mark.parametrize("kind", ["rigid", "spring"])
def test_a_propped_cantilever_rests_on_its_stop(model, kind):
    """The tip's weight deflection w0 and flexibility c, the stop 1/k: F = (w0 + height)/(c + 1/k)."""
    height, c = 1e-3, LENGTH**3 / (3 * STIFFNESS)
    keys = stop(kind, height) | {"discretization": MODELS[model]}
    force = (WEIGHT * LENGTH**4 / (8 * STIFFNESS) + height) / (c + (1e-4 if kind == "spring" else 0.0))
    found = at_rest(cantilever(**keys))[2]
    # the modes alone are stiffer than the beam by what they leave out; behind a spring it is there
    close = 1e-5 if model == "nodal" or kind == "spring" else 1e-3
    assert found.forces == pytest.approx([force], rel=close)


def test_no_weight_and_no_reach_leave_the_beam_straight():
    _, w, found = at_rest(cantilever(**stop("rigid", 0.0), gravity=0.0))
    assert np.abs(w).max() < 1e-15
    assert found.closed == []


@pytest.mark.parametrize("how", ["deflection", "force"])
def test_a_plucked_cantilever_has_the_shape_of_its_hold(how):
    """A force F at a: w = F x^2 (3 a - x)/(6 E I) up to there, a tangent beyond it."""
    a, delta = 0.6, 2e-3
    force = 3 * STIFFNESS * delta / a**3
    initial = {"state": "plucked", "place": a, how: {"deflection": delta, "force": force}[how]}
    x, w, _ = at_rest(cantilever(initial=initial, gravity=0.0, discretization=NODAL | {"elements": 10}))
    inside = np.minimum(x, a)
    exact = force * inside**2 * (3 * a - inside) / (6 * STIFFNESS)
    exact += force * a**2 / (2 * STIFFNESS) * np.maximum(x - a, 0.0)
    assert w == pytest.approx(exact, abs=1e-5 * delta)


def test_a_hold_counts_from_where_the_beam_rests_without_it():
    initial = {"state": "plucked", "place": LENGTH, "deflection": 1e-3}
    _, w, _ = at_rest(cantilever(initial=initial))
    _, sagging, _ = at_rest(cantilever())
    assert w[-1] - sagging[-1] == pytest.approx(1e-3, rel=1e-4)


def test_a_plucked_beam_is_let_go_at_rest_and_swings_about_its_equilibrium():
    initial = {"state": "plucked", "place": LENGTH, "force": 1.0}
    held = cantilever(initial=initial, gravity=0.0, end_time=0.4)
    history = simulate(held)
    tip = history["deflection"].values
    assert not history["qd"].values[0].any()
    period = 2 * np.pi / 3.516015 * np.sqrt(3.14e-4 * 2766.7 / STIFFNESS)
    half = int(np.argmin(np.abs(history["time"].values - 0.5 * period)))
    assert tip[half] == pytest.approx(-tip[0], rel=0.05)  # higher modes are not in phase


SCHEMES = {
    "event": MODELS["modes"] | {"modes": 4},
    "fixed-step": MODELS["modes"] | {"modes": 4},
    "generalized-alpha": NODAL,
    "time-stepping": NODAL,
    "time-stepping, modes": {"modes": 4},
}


@pytest.mark.parametrize("name", SCHEMES)
@pytest.mark.parametrize("kind", ["rigid", "spring", "damped"])
def test_a_beam_in_equilibrium_stays_at_rest_with_its_section_forces(name, kind):
    scheme = name.partition(",")[0]
    if kind == "rigid" and scheme == "generalized-alpha":
        pytest.skip("elastic stops alone")
    keys = stop("spring", 2e-3, damping=0.5) if kind == "damped" else stop(kind, 2e-3)
    steps = {} if scheme == "event" else {"free_step": 2e-5, "contact_step": 2e-5}
    keys |= {"discretization": SCHEMES[name], "beam": {"kelvin_voigt": 1e-5}}
    history = simulate(cantilever(**keys, solver={"scheme": scheme, "output_interval": 1e-4} | steps))
    force = history["lambda_n"].values
    # located events take steps as long as their tolerance allows
    rest, moved = (1e-8, 1e-11) if scheme == "event" else (1e-12, 1e-14)
    assert np.abs(history["tip_vy"].values).max() < rest
    assert np.abs(history["q"].values - history["q"].values[0]).max() < moved
    assert force == pytest.approx(np.full(force.size, force[0]), rel=1e-8)
    sections = history.section_forces()
    shear, moment = sections["shear"].values, sections["moment"].values
    # the support carries what the stop does not, from the first sample on
    assert shear[:, 0] == pytest.approx(np.full(force.size, WEIGHT * LENGTH - force[0]), abs=1e-4)
    assert moment[:, 0] == pytest.approx(
        np.full(force.size, LENGTH * force[0] - 0.5 * WEIGHT * LENGTH**2), abs=1e-4
    )
    assert abs(history.balance["unaccounted"]) < 1e-12


def test_a_pendulum_comes_to_hang_and_a_beam_falls_on_the_slope():
    hanging = Scenario.builtin("paper", ["contact.enabled=false", "initial.state=equilibrium"])
    assert at_rest(hanging)[2].q[0] == pytest.approx(-np.pi / 2, abs=1e-9)
    lying = at_rest(Scenario.builtin("paper", ["initial.state=equilibrium"]))[2]
    assert lying.closed == [0]
    assert abs(lying.gaps[0]) < 1e-14


def test_a_beam_is_bent_over_a_peg_and_a_side_that_it_begins_inside_of():
    """A peg of 10 mm radius 5 mm under a straight weightless beam presses at its middle with 3 E I w/a^3."""
    given = {
        "gravity": 0.0,
        "slope": {"enabled": False},
        "contact": {"where": "anywhere"},
        "discretization": MODELS["modes"] | {"modes": 16},
    }
    peg = {"kind": "point", "origin": [0.5, -0.005], "radius": 0.01}
    found = at_rest(cantilever(**given, obstacles=[peg]))[2]
    assert found.forces == pytest.approx([3 * STIFFNESS * 0.005 / 0.5**3], rel=0.03)  # of sixteen modes
    side = {"kind": "side", "origin": [0.9, 0.004], "angle": 0.0, "extent": [-0.05, 0.2]}
    both = at_rest(cantilever(**given, obstacles=[side]))[2]
    assert (both.forces >= 0.0).all()
    assert both.forces.max() > 0.0
    assert both.gaps[both.closed] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("model", ["modes", "nodal"])
def test_two_pegs_that_press_on_a_straight_beam_from_both_sides_hold_it_straight(model):
    """Nothing bends: the search has no step to take, and each peg has its spring times what it is inside of."""
    pegs = [{"kind": "point", "origin": [0.5, side * 0.009], "radius": 0.01} for side in (-1.0, 1.0)]
    held = cantilever(
        gravity=0.0,
        slope={"enabled": False},
        contact={"where": "anywhere", "normal": "spring", "stiffness": 1e3, "friction": "frictionless"},
        discretization=MODELS[model],
        obstacles=pegs,
    )
    _, deflections, found = at_rest(held)
    assert found.closed == [0, 1]
    assert found.forces == pytest.approx([1.0, 1.0], rel=1e-9)
    assert deflections == pytest.approx(0.0, abs=1e-15)


REFUSED = [
    ("contact.enabled=false gravity=0", "there is no equilibrium that is stable: nothing holds the beam"),
    ("root.kind=hub root.torque=100 contact.enabled=false", "no equilibrium is found"),
]


@pytest.mark.parametrize(("keys", "words"), REFUSED)
def test_a_beam_that_nothing_holds_is_refused_in_one_line(keys, words):
    scenario = Scenario.builtin("paper", [*keys.split(), "initial.state=equilibrium"])
    with pytest.raises(InputError, match=rf'^initial.state = "equilibrium": {words}'):
        simulate(scenario)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"state": "plucked", "deflection": 0.1}, "initial.place = 0.0: should be greater than 0"),
        ({"state": "plucked", "place": 0.5}, "initial.deflection = 0.0: one of deflection and force"),
        ({"state": "plucked", "place": 2.0, "force": 1.0}, "initial.place = 2.0: should be on the beam"),
        ({"state": "equilibrium", "angular_velocity": 1.0}, "initial.angular_velocity = 1.0: has no effect"),
        ({"place": 0.5}, "initial.place = 0.5: has no effect"),
    ],
)
def test_keys_of_the_start_that_do_not_fit_are_refused(keys, words):
    with pytest.raises(InputError) as error:
        Scenario.from_dict({"initial": keys})
    assert str(error.value).startswith(words)


def test_a_root_that_turns_does_not_start_at_rest():
    turning = ["root.kind=driven", "root.profile=constant-speed", "root.spin_rate=1"]
    with pytest.raises(InputError, match=r'^initial\.state = "equilibrium": should be'):
        Scenario.builtin("paper", [*turning, "initial.state=equilibrium"])


@dataclass(frozen=True)
class Hertzian(ContactLaw):
    """A Hertzian stop, k d^1.5."""

    stiffness: float = 1e8  # N/m^1.5

    @staticmethod
    def normal_force(depth, rate, stiffness):
        return stiffness * depth**1.5


def test_a_stop_of_any_law_is_at_rest():
    keys = stop("spring", 2e-3, residual_flexibility=False) | {"discretization": {"modes": 4}}
    history = simulate(cantilever(**keys), contact_law=Hertzian())
    force, gap = history["lambda_n"].values, history["gap"].values
    assert force == pytest.approx(np.full(force.size, force[0]), rel=1e-8)
    assert (force[0] / 1e8) ** (2 / 3) == pytest.approx(-gap[0], rel=1e-9)
    assert np.abs(np.diff(history["q"].values, axis=0)).max() < 1e-11


@pytest.mark.parametrize("scheme", ["event", "time-stepping", "generalized-alpha"])
def test_a_stop_with_axial_flexibility_holds_no_friction(scheme):
    steps = {} if scheme == "event" else {"free_step": 2e-5, "contact_step": 2e-5}
    keys = stop("spring", 2e-3, axial_flexibility=True) | {"discretization": {"modes": 4}}
    history = simulate(cantilever(**keys, solver={"scheme": scheme, "output_interval": 1e-4} | steps))
    assert np.abs(history["lambda_tau"].values).max() < 1e-7
    assert np.abs(history["tip_vy"].values).max() < 1e-8

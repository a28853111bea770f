"""Contact along outlines: an arc of chords and a peg, a hollow, what lies behind, a piece and a side."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.errors import Outcome

RADIUS, TOP = 0.2, (0.5, -1e-3)  # m, of a peg under the beam


def arc(chords: int) -> list[list[float]]:
    """Points on the upper part of the peg, one at its top."""
    angles = np.linspace(0.72 * np.pi, 0.28 * np.pi, chords + 1)
    return [[TOP[0] + RADIUS * math.cos(a), TOP[1] - RADIUS + RADIUS * math.sin(a)] for a in angles]


def turned_onto(obstacle):
    """A clamp bends the beam over an obstacle as it turns: energy and impulse over time, loss of friction."""
    history = simulate(
        Scenario.from_dict(
            {
                "end_time": 0.25,
                "gravity": 0.0,
                "initial": {"angle": 0.0},
                "root": {"kind": "driven", "profile": "spin-up", "spin_rate": -0.8, "spin_up_time": 0.1},
                "beam": {"kelvin_voigt": 1e-3},
                "slope": {"enabled": False},
                "contact": {"where": "anywhere", "mu_static": 0.3, "mu_kinetic": 0.3}
                | ({} if obstacle["kind"] == "point" else {"grid": 1}),
                "discretization": {"modes": 3},
                "obstacles": [obstacle],
            }
        )
    )
    assert history.outcome is Outcome.COMPLETED
    assert abs(history.balance["unaccounted"]) < 1e-11
    time, force = history["time"].values, history["lambda_n"].values
    passed = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(time))])
    times, last = np.unique(time, return_index=True)
    even = np.linspace(0.1, 0.25, 400)
    energy, impulse = (np.interp(even, times, of[last]) for of in (history["energy_elastic"].values, passed))
    return energy, impulse, history.balance["lost_friction"]


def test_an_arc_of_chords_tends_to_a_peg_at_second_order():
    """With friction: the energy at any time; the force, which jumps from corner to corner, in its mean."""
    peg = turned_onto({"kind": "point", "origin": [TOP[0], TOP[1] - RADIUS], "radius": RADIUS})
    apart, means = {}, {}
    for chords in (32, 128):
        found = turned_onto({"kind": "polyline", "points": arc(chords)})
        apart[chords] = np.max(np.abs(found[0] - peg[0])) / peg[0][-1]
        means[chords] = abs(np.mean(found[1] - peg[1])) / peg[1][-1]
    assert apart[32] / apart[128] > 12.0  # sixteen times
    assert apart[128] < 1.0e-4
    assert means[128] < 3e-5 < means[32]
    # the slip is 1.5 mm, in which the height of a chord counts
    assert found[2] == pytest.approx(peg[2], rel=4e-3)


MODELS = {
    "modes": {"modes": 3},
    "nodes": {"method": "fem", "elements": 4, "modes": 0},
    "exact": {"method": "absolute", "elements": 4},
}


def fallen(points, model, scheme, normal, **changes):
    """A pinned beam of 1 m that falls from the horizontal onto an outline, with friction."""
    spring = {"stiffness": 2e3} if normal == "spring" else {}
    steps = {} if scheme == "event" else {"free_step": 2e-5, "contact_step": 2e-5}
    given = {
        "end_time": 0.32,
        "initial": {"angle": 0.0},
        "beam": {"kelvin_voigt": 1e-5},
        "slope": {"enabled": False},
        "contact": {"where": "anywhere", "normal": normal, "grid": 2, "mu_static": 0.3, "mu_kinetic": 0.3}
        | spring,
        "discretization": MODELS[model],
        "solver": {"scheme": scheme} | steps,
        "obstacles": [{"kind": "polyline", "points": points}],
    }
    return simulate(Scenario.from_dict(given | changes))


#: where its tip arrives, at the bottom of a V
BOTTOM = [math.cos(-0.45), math.sin(-0.45)]
HOLLOW = [[0.5, -0.36], BOTTOM, [BOTTOM[0] + 0.2, BOTTOM[1] + 0.2]]
UNACCOUNTED = {"event": 1e-11, "generalized-alpha": 1e-6, "time-stepping": 1e-5}


@pytest.mark.filterwarnings("ignore")  # of few modes, elements and friction without axial flexibility
@pytest.mark.parametrize(
    ("model", "scheme", "normal"),
    [
        ("modes", "event", "rigid"),
        ("modes", "event", "spring"),
        ("modes", "time-stepping", "rigid"),
        ("nodes", "generalized-alpha", "spring"),
        ("exact", "time-stepping", "rigid"),
        ("exact", "time-stepping", "spring"),
    ],
)
def test_a_tip_falls_into_a_hollow_and_not_through_it(model, scheme, normal):
    history = fallen(HOLLOW, model, scheme, normal)
    assert history.outcome is Outcome.COMPLETED
    assert abs(history.balance["unaccounted"]) < UNACCOUNTED[scheme]
    tip = history["tip_x"].values + 1j * history["tip_y"].values
    clear = history.scenario.outlines[1].distance(tip)
    places, pushes = history["contact_place"].values[0], np.nan_to_num(history["contact_lambda_n"].values)
    at_tip = pushes[:, np.isclose(places, 1.0) & (history["contact_slip"].values[0] != -places)]
    if normal == "rigid":
        assert clear.min() > -1e-8
        return
    # soft walls are pressed in by 38 mm: both push, the shares of which are their own depths
    k = int(np.argmax(pushes.sum(axis=1)))
    assert clear[k] == pytest.approx(-0.038, abs=1e-3)
    assert (at_tip[k] > 0.0).sum() == 2
    depths = [-side.slip_and_gap(tip[k]).imag for side in history.scenario.sides]
    if model == "nodes":  # of modes a residual flexibility yields besides
        assert at_tip[k] == pytest.approx(2e3 * np.array(depths), rel=1e-9)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    ("scheme", "normal"), [("event", "rigid"), ("event", "spring"), ("time-stepping", "rigid")]
)
def test_a_piece_is_a_side_and_a_solid_is_its_upper_side(scheme, normal):
    """The other sides and corners of a block are in nobody's way."""
    side = {"kind": "side", "origin": [0.3, -0.1], "angle": -0.2, "extent": [0.0, 0.4]}
    end = 0.3 + 0.4 * math.cos(-0.2), -0.1 + 0.4 * math.sin(-0.2)
    top = [[0.3, -0.1], list(end)]
    block = [*top, [end[0], -0.5], [0.3, -0.5], top[0]]
    wanted, piece, whole = (
        fallen([], "modes", scheme, normal, end_time=0.2, obstacles=[obstacle])
        for obstacle in (side, {"kind": "polyline", "points": top}, {"kind": "polyline", "points": block})
    )
    assert wanted.events
    for found, exact in ((piece, 1e-9), (whole, 1e-6)):  # steps of error control differ
        times = [(event.kind, pytest.approx(event.time, abs=exact)) for event in wanted.events[:4]]
        assert [(event.kind, event.time) for event in found.events[:4]] == times
        assert found["tip_y"].values[-1] == pytest.approx(wanted["tip_y"].values[-1], abs=1e-3 * exact**0.5)
        assert np.nanmin(found["clearance"]) == pytest.approx(np.nanmin(wanted["clearance"]), abs=1e-4)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("model", ["modes", "exact"])
def test_a_beam_rests_on_a_block_as_on_its_upper_side(model):
    rest = {"initial": {"angle": 0.0, "state": "equilibrium"}, "end_time": 0.01}
    top = [[0.7, -1e-4], [1.2, -1e-4]]
    scheme = "event" if model == "modes" else "time-stepping"
    forces = []
    for points in (top, [*top, [1.2, -0.01], [0.7, -0.01], top[0]]):
        history = fallen(points, model, scheme, "spring", **rest)
        forces.append(history["lambda_n"].values[0])
        assert history["lambda_n"].values[-1] == pytest.approx(forces[-1], rel=1e-6)
    assert forces[0] == pytest.approx(forces[1], rel=1e-6)
    assert forces[0] > 3.0


@pytest.mark.filterwarnings("ignore")
def test_a_run_goes_on_where_it_is_pressed_into_a_block():
    """From a state in which the beam is in the solid by 1 mm, 0.7 m behind the line of its wall."""
    top = [[0.7, -1e-4], [1.2, -1e-4]]
    block = [*top, [1.2, -0.01], [0.7, -0.01], top[0]]
    rest = {"initial": {"angle": 0.0, "state": "equilibrium"}, "end_time": 0.01}
    before = fallen(block, "modes", "event", "spring", **rest)
    moving = before.scenario.replace(initial={"angle": 0.0})
    assert simulate(moving, initial_state=before)["lambda_n"].values == pytest.approx(before["lambda_n"].values[0])
    # coordinates alone do not say on which side of a corner the beam is, which is deeper than its own place
    state = before["q"].values[-1], before["qd"].values[-1]
    line = moving.replace(obstacles=[{"kind": "polyline", "points": top}])
    on_block, on_line = (simulate(s, initial_state=state)["lambda_n"].values for s in (moving, line))
    assert on_line[0] > 2.0
    assert on_block == pytest.approx(on_line, rel=1e-6)


def test_a_reed_lies_on_its_lay_as_far_as_its_force_has_the_moment_for():
    """Bent to the lay it takes the moment EI/R: up to EI/(R F) before the tip, and at the clamp."""
    history = simulate(Scenario.builtin("reed", ["end_time=0.08"]))
    assert abs(history.balance["unaccounted"]) < 1e-10
    length, bending, radius, chord = 0.1, 2.1e11 * 0.01 * 0.0005**3 / 12.0, 0.8, 0.008
    slow = history["time"].values > 0.06  # its swing is damped out
    force = 1.2 * history["time"].values[slow] / 0.08
    pushes = np.nan_to_num(history["contact_lambda_n"].values[slow])
    places = history["contact_place"].values[slow]
    last = np.where(pushes > 0.0, places, 0.0).max(axis=1)
    # the reed leaves the lay at a corner, between chords
    assert np.all(np.abs(last - (length - bending / (radius * force))) < 1.1 * chord)
    assert last[-1] > last[0] + 0.9 * chord
    weight = 7800.0 * 0.01 * 0.0005 * 9.8 * length
    moment = force * length + 0.5 * weight * length - bending / radius
    assert np.mean((pushes * places).sum(axis=1)) == pytest.approx(np.mean(moment), rel=2.5e-3)


@pytest.mark.filterwarnings("ignore::oblique_impact.errors.SimulationWarning")
def test_corners_that_add_up_are_warned_of():
    """With chords shorter than the stretch that is pressed in the force depends on their number."""

    contact = {"where": "anywhere", "normal": "spring", "stiffness": 2e3, "friction": "frictionless"}

    def warnings_and_force(obstacle, **grid):
        history = fallen([], "modes", "event", "", obstacles=[obstacle], contact=contact | grid)
        found = [text for text in history.summary["warnings"] if "stiffnesses add up" in text]
        return found, float(history["lambda_n"].max())

    (warning,), many = warnings_and_force({"kind": "polyline", "points": arc(64)}, grid=1)
    assert warning.startswith("obstacle 1 is touched at ")
    assert "obstacles.1.bedding" in warning
    none, few = warnings_and_force({"kind": "polyline", "points": arc(4)}, grid=1)
    assert not none
    peg = {"kind": "point", "origin": [TOP[0], TOP[1] - RADIUS], "radius": RADIUS}
    assert warnings_and_force(peg) == ([], pytest.approx(few, rel=0.02))
    assert many > 1.2 * few

"""Frequencies and damping ratios about the equilibrium, with the contacts that are closed there: closed forms."""

from __future__ import annotations

import json
import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import brentq

from oblique_impact import InputError, Scenario, frequencies_at_rest, natural_frequencies, simulate

STIFFNESS, MASS = 68.952e9 * 7.85e-9, 3.14e-4 * 2766.7  # N m^2, kg/m
UNIT = math.sqrt(STIFFNESS / MASS)  # rad/s, of a beam of 1 m
NODAL = {"method": "fem", "elements": 32, "modes": 0}


def clamped(**sections):
    """A weightless clamped horizontal beam."""
    plain = {"gravity": 0.0, "root": {"kind": "driven"}, "initial": {"angle": 0.0}, "contact": {"enabled": False}}
    return Scenario.from_dict(plain | {"discretization": NODAL} | sections)


def propped(height=1e-5, **contact):
    """A stop under the tip, a little above the straight beam, without friction."""
    slope = {"origin": [1.0, height], "angle": 0.0}
    return {"contact": contact, "slope": slope, "initial": {"angle": 0.0, "state": "equilibrium"}}


def roots(equation, count, first=0.5):
    """The lowest roots of an equation."""
    x = np.arange(first, 3.5 * (count + 1), 0.01)
    return np.array([brentq(equation, a, b) for a, b in pairwise(x) if equation(a) * equation(b) < 0.0][:count])


def test_a_rigid_stop_props_a_cantilever():
    found = frequencies_at_rest(clamped(**propped()), 3)
    exact = roots(lambda x: np.sin(x) * np.cosh(x) - np.cos(x) * np.sinh(x), 3, first=2.0) ** 2 * UNIT
    assert found.frequencies == pytest.approx(exact, rel=1e-5)
    assert found.closed == ((0, 1.0),)
    assert not found.damping.any()


@pytest.mark.parametrize(("discretization", "close"), [({"modes": 12}, 1e-7), ({"modes": 3}, 1e-5), (NODAL, 1e-6)])
def test_a_spring_is_in_series_with_what_the_modes_leave_out(discretization, close):
    """1 + cos x cosh x = -k L^3/(E I x^3) (cosh x sin x - sinh x cos x)."""
    spring, damping = 3e3, 0.1
    scenario = clamped(
        **propped(normal="spring", stiffness=spring, damping=damping), discretization=discretization
    )
    found = frequencies_at_rest(scenario, 2)

    def equation(x):
        bent = np.cosh(x) * np.sin(x) - np.sinh(x) * np.cos(x)
        return x**3 * (1.0 + np.cos(x) * np.cosh(x)) + spring / STIFFNESS * bent

    assert found.frequencies == pytest.approx(roots(equation, 2) ** 2 * UNIT, rel=close)
    assert found.damping[0] > 0.0  # of Hunt and Crossley's stop under its force


def test_kelvin_voigt_damping_grows_with_the_frequency():
    found = frequencies_at_rest(clamped(beam={"kelvin_voigt": 1e-5}), 4)
    assert found.damping == pytest.approx(0.5e-5 * found.frequencies, rel=1e-7)
    assert found.frequencies == pytest.approx(natural_frequencies(clamped(), count=4).chordwise[0], rel=1e-9)


def test_a_stiff_beam_on_a_pin_is_a_pendulum():
    rod = Scenario.builtin("paper", ["beam.youngs_modulus=1e16", "contact.enabled=false", "initial.angle=-1.5"])
    assert frequencies_at_rest(rod, 1).frequencies == pytest.approx([math.sqrt(1.5 * 9.8)], rel=1e-9)


def test_a_clamp_that_yields_and_its_dashpot():
    """One bar, rigid, on a clamp c with a dashpot d: omega^2 = 3 c/m, zeta = d omega/(2 c)."""
    rod = clamped(
        beam={"youngs_modulus": 1e15},
        root={"kind": "driven", "stiffness": 20.0, "damping": 0.01},
        discretization={"method": "fem", "elements": 4, "modes": 0},
    )
    found = frequencies_at_rest(rod, 1)
    exact = math.sqrt(3.0 * 20.0 / MASS)
    assert found.frequencies == pytest.approx([exact], rel=1e-6)
    assert found.damping == pytest.approx([0.01 * exact / 40.0], rel=1e-5)
    bent = clamped(root={"kind": "driven", "stiffness": 200.0}, beam={"youngs_modulus": 68.952e9})
    chordwise = natural_frequencies(bent, count=3).chordwise[0]
    assert frequencies_at_rest(bent, 3).frequencies == pytest.approx(chordwise, rel=1e-9)


def test_a_dashpot_that_couples_modes_takes_what_the_marched_run_loses():
    """The ratio of the first mode is that of the decay of a plucked run."""
    given = propped(height=1e-3, normal="spring", stiffness=3e3, linear_damping=5.0, friction="frictionless")
    scenario = clamped(**given, discretization={"modes": 4}, end_time=0.3)
    found = frequencies_at_rest(scenario, 1)
    initial = {"angle": 0.0, "state": "plucked", "place": 1.0, "deflection": 1e-5}
    run = simulate(clamped(**given | {"initial": initial}, discretization={"modes": 4}, end_time=0.3))
    tip = run["deflection"].values
    rest = simulate(scenario)["deflection"].values[0]
    late = run["time"].values > 0.05
    t, swing = run["time"].values[late], (tip - rest)[late]
    peaks = (
        np.flatnonzero((np.abs(swing[1:-1]) >= np.abs(swing[:-2])) & (np.abs(swing[1:-1]) > np.abs(swing[2:]))) + 1
    )
    rate = -np.polyfit(t[peaks], np.log(np.abs(swing[peaks])), 1)[0]
    ratio, omega = float(found.damping[0]), float(found.frequencies[0])
    assert rate == pytest.approx(ratio * omega, rel=2e-2)
    crossings = np.flatnonzero(np.diff(np.sign(swing)) != 0)
    half = np.diff(t[crossings]).mean()
    assert math.pi / half == pytest.approx(omega * math.sqrt(1.0 - ratio**2), rel=2e-3)


def test_stuck_contacts_hold_a_beam_along_its_stop():
    """On a slope that is inclined to it the tip of a beam that sticks cannot turn about its pin: fewer motions."""
    lying = Scenario.builtin("paper")
    free, stuck = (frequencies_at_rest(lying, friction=friction) for friction in ("free", "stuck"))
    assert free.frequencies.size - stuck.frequencies.size == 1
    assert stuck.frequencies[0] > free.frequencies[0]
    with pytest.raises(InputError, match=r'^contact\.friction = "frictionless": should be "hybrid"'):
        frequencies_at_rest(lying.replace(contact__friction="frictionless"), friction="stuck")


@pytest.mark.parametrize("stiffness", [1e6, 1e9])
@pytest.mark.parametrize("axial", [False, True])
def test_two_faces_that_stick_at_one_place_hold_the_section(axial, stiffness):
    """Jaws at the end of a strip are a hinge without friction, a clamp with: (4.730041/3.926602)^2 times as fast.

    They stretch the axis alike, which a straight one answers with nothing; against each other they turn the
    section.
    """
    jaws = ",".join(
        f"{{kind='point', origin=[0.249, {side * (5e-4 - 1.0 / stiffness)}], stiffness={stiffness}}}"
        for side in (1.0, -1.0)
    )
    resting = "base.acceleration=0", "base.frequency=0", "gravity=0", "initial.angle=0"
    pressed = "initial.state=equilibrium", "slope.enabled=false", "contact.where=anywhere"
    faces = "contact.surface=section", "contact.friction=hybrid"
    nodes = "discretization.method=fem", "discretization.modes=0", "discretization.elements=16"
    stretching = f"contact.axial_flexibility={str(axial).lower()}"
    strip = Scenario.builtin("shaken", [*resting, *pressed, *faces, *nodes, stretching, f"obstacles=[{jaws}]"])
    free, stuck = (frequencies_at_rest(strip, 1, friction).frequencies[0] for friction in ("free", "stuck"))
    # the jaws are at 0.996 of the length, and press a little
    assert free * 0.25**2 / math.sqrt(0.35 / 0.157) == pytest.approx(3.926602**2, rel=1e-2)
    assert stuck * 0.25**2 / math.sqrt(0.35 / 0.157) == pytest.approx(4.730041**2, rel=2e-2)


def test_the_command_prints_the_modes_and_draws_them(tmp_path, cli):
    code, printed, _ = cli("modes", "elastic-stop", "--closed", "--json", "--out", tmp_path)
    assert code == 0
    found = json.loads(printed)
    assert list(found) == ["frequencies", "damping", "closed"]
    assert found["closed"] == [{"obstacle": 0, "place": 1.0}]
    # nearly hinged at both ends
    assert found["frequencies"][0] == pytest.approx(math.pi**2 * UNIT, rel=0.02)
    assert (tmp_path / "mode-shapes.png").stat().st_size > 10_000
    for options, words in (
        (("--closed", "--speeds", "1"), "--speeds 1: does not apply together with --closed"),
        (("--friction", "stuck"), "--friction stuck: only with --closed"),
        (("--closed", "--friction", "wet"), "--friction wet: should be free or stuck"),
    ):
        code, _, error = cli("modes", "elastic-stop", *options)
        assert code == 2
        assert words in error


def under_axial_load(load, count):
    """Frequencies (rad/s) of a cantilever whose tip is pressed along the beam by a force fixed in space.

    E I w'''' + P w'' = m omega^2 w with w = w' = 0 at the clamp, w'' = w''' + P/(E I) w' = 0 at the tip.
    """

    def equation(x):
        half = math.sqrt(0.25 * load**2 + x * x)
        a, b = math.sqrt(half - 0.5 * load), math.sqrt(half + 0.5 * load)
        sh, ch, s, c = math.sinh(a), math.cosh(a), math.sin(b), math.cos(b)
        # of cosh a x - cos b x and sinh a x/a - sin b x/b
        bent = [a * a * ch + b * b * c, a * sh + b * s]
        sheared = [a**3 * sh - b**3 * s + load * (a * sh + b * s), a * a * ch + b * b * c + load * (ch - c)]
        return bent[0] * sheared[1] - bent[1] * sheared[0]

    x = np.arange(0.01, 40.0, 0.01)
    found = [brentq(equation, a, b) for a, b in pairwise(x) if equation(a) * equation(b) < 0.0]
    return np.array(found[:count]) * UNIT


@pytest.mark.parametrize(
    ("discretization", "close"),
    [({"modes": 24}, 1e-5), ({"method": "fem", "elements": 32, "modes": 24}, 1e-5), (NODAL, 1e-6)],
)
@pytest.mark.parametrize("load", [-5.0, 1.5])  # over E I/L^2: pulled, and pressed with 0.6 of what buckles it
def test_a_force_fixed_in_space_along_the_beam_moves_its_frequencies(discretization, close, load):
    pressed = {"force": load * STIFFNESS, "direction": 0.3 - math.pi}
    scenario = clamped(initial={"angle": 0.3}, forces=[pressed], discretization=discretization)
    found = frequencies_at_rest(scenario, 2)
    assert found.frequencies == pytest.approx(under_axial_load(load, 2), rel=close)


def test_a_cantilever_has_no_frequency_left_where_it_buckles():
    """f1^2 falls to 0 at pi^2 E I/(4 L^2), in proportion to what is left; beyond it the straight beam falls."""
    euler = 0.25 * math.pi**2 * STIFFNESS
    scenario = clamped(forces=[{"force": euler, "direction": math.pi}])
    squares = [
        frequencies_at_rest(scenario.replace(forces__1__force=part * euler), 1).frequencies[0] ** 2
        for part in (0.999, 0.9999)
    ]
    assert squares[0] / squares[1] == pytest.approx(10.0, rel=1e-3)
    with pytest.raises(InputError, match=r'^initial\.state = "equilibrium": there is no equilibrium'):
        frequencies_at_rest(scenario.replace(forces__1__force=1.001 * euler), 1)


def test_a_stiff_beam_that_a_force_fixed_in_space_pulls_is_a_pendulum():
    """A force F at x_f swings a rod on its pin about its own direction: omega^2 = F x_f/(m L^3/3)."""
    rod = Scenario.builtin("paper", ["beam.youngs_modulus=1e16", "contact.enabled=false", "initial.angle=0.2"])
    rod = rod.replace(gravity=0.0, forces=[{"force": 5.0, "place": 0.6, "direction": 0.5}])
    assert frequencies_at_rest(rod, 1).frequencies == pytest.approx([math.sqrt(5.0 * 0.6 * 3.0 / MASS)], rel=1e-8)


@pytest.mark.parametrize("model", [{"modes": 3}, {"method": "fem", "elements": 4, "modes": 0}])
def test_a_run_swings_with_the_frequencies_of_the_pressed_and_bent_beam(model):
    """A beam that a force fixed in space has pushed aside and along: the marched model, plucked a little."""
    forces = [{"force": 1.2 * STIFFNESS, "direction": math.pi + 0.1}]
    still = {"forces": forces, "discretization": model}
    (omega,) = frequencies_at_rest(clamped(**still), 1).frequencies
    solver = {"free_step": 1e-3} if "method" in model else {"output_interval": 1e-3}
    still |= {"solver": solver, "end_time": 8.0 * math.pi / omega}
    start = {"angle": 0.0, "state": "plucked", "place": 1.0}
    left, right = (simulate(clamped(**still, initial=start | {"deflection": w})) for w in (1e-5, -1e-5))
    swing, times = left["deflection"].values - right["deflection"].values, left["time"].values
    shapes = np.stack([np.cos(omega * times), np.sin(omega * times)], axis=1)
    (cos, sin), *_ = np.linalg.lstsq(shapes, swing, rcond=None)
    assert cos == pytest.approx(2e-5, rel=0.1)
    assert abs(sin) < 0.02 * cos  # what a frequency 0.2 % off would be

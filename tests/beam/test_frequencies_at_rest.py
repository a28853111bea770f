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
    with pytest.raises(InputError, match=r'^contact\.friction = \'frictionless\': should be "hybrid"'):
        frequencies_at_rest(lying.replace(contact__friction="frictionless"), friction="stuck")


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

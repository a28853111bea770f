"""Items 3: the spin-up of a flexible beam of Simo and Vu-Quoc (J. Appl. Mech. 53, 1986, 855-863)."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from mpmath import mp
from scipy.interpolate import CubicSpline

from oblique_impact import History, Outcome, Scenario, simulate
from oblique_impact.beam.operators import SpinningBeam, build_operators, discretization
from validation.reference_values import VALUES

TABLE, MINIMUM, AT_REST = VALUES["3-SVQ-table"], VALUES["3-SVQ-min"], VALUES["3-SVQ-w1"]
GUESSES = 4.5, 27.6, 71.0  # of the chordwise frequencies at full speed (rad/s), where the search for them begins
UNIT = np.sqrt(1.4e4 / 1.2) / 100.0  # sqrt(EI/(m L^4)) (rad/s)
CASES = [("modal", 12, 32), ("fem", 12, 16), ("fem", 12, 32)]


@cache
def spin_up(method: str = "modal", modes: int = 12, elements: int = 32, kinetics: str = "first-order") -> History:
    overrides = (f"method={method}", f"modes={modes}", f"elements={elements}", f"kinetics={kinetics}")
    return simulate(Scenario.builtin("spin-up", [f"discretization.{each}" for each in overrides]))


def deflection(history: History) -> CubicSpline:
    """Tip deflection between samples 0.01 s apart (a cubic misses it by less than 1e-8 m)."""
    time, first = np.unique(history["time"].values, return_index=True)
    return CubicSpline(time, history["deflection"].values[first])


def extrema(curve: CubicSpline) -> tuple[np.ndarray, np.ndarray]:
    """Times and values where the curve is level."""
    times = curve.derivative().roots(extrapolate=False)
    return times, curve(times)


@pytest.mark.parametrize(("method", "modes", "elements"), CASES)
def test_tip_deflection_follows_the_table(method, modes, elements):
    curve = deflection(spin_up(method, modes, elements))
    np.testing.assert_allclose(curve(list(TABLE)), list(TABLE.values()), rtol=0.0, atol=1e-6)


@pytest.mark.parametrize(("method", "modes", "elements"), CASES)
def test_minimum_and_its_time(method, modes, elements):
    times, values = extrema(deflection(spin_up(method, modes, elements)))
    lowest = np.argmin(values)
    assert values[lowest] == pytest.approx(MINIMUM["w_min"], abs=1e-6)
    # the curve is flat there: an error of 1e-6 m allows sqrt(2e-6 / w'') = 2 ms; measured 1e-6 s
    assert times[lowest] == pytest.approx(MINIMUM["t"], abs=5e-6)


def test_minimum_is_that_of_the_geometrically_exact_beam():
    """The first-order equations neglect terms of relative size (w/L)^2 = 3e-3."""
    minimum, time = VALUES["3-SVQ-GE"]["w_min"], VALUES["3-SVQ-GE"]["t"]
    times, values = extrema(deflection(spin_up()))
    assert values.min() == pytest.approx(minimum, rel=3e-3)
    assert times[np.argmin(values)] == pytest.approx(time, rel=3e-3)


@pytest.mark.parametrize(("method", "modes", "elements"), CASES)
def test_steady_vibration(method, modes, elements):
    times, values = extrema(deflection(spin_up(method, modes, elements)))
    steady = times > 15.0
    # three digits are certain
    assert np.abs(values[steady]).max() == pytest.approx(VALUES["3-SVQ-amp"], rel=5e-4)
    # three maxima, two periods of the first mode; the second, thousands of times smaller, shifts them a little
    highest = times[steady & (values > 0.0)]
    cycles = (highest[-1] - highest[0]) * UNIT * series_frequency(6.0 / UNIT, GUESSES[0] / UNIT) / (2.0 * np.pi)
    assert cycles == pytest.approx(2.0, rel=1e-3)


@pytest.mark.parametrize("modes", list(VALUES["3-SVQ-min-modes"]))
def test_minimum_by_number_of_modes(modes):
    _, values = extrema(deflection(spin_up(modes=modes)))
    assert values.min() == pytest.approx(VALUES["3-SVQ-min-modes"][modes], abs=0.51e-6)


def test_frequencies_of_twelve_modes_at_full_speed():
    """Those of 12 modes lie above the exact ones (Rayleigh and Ritz), by up to 2e-6 of them."""
    scenario = Scenario.builtin("spin-up", ["discretization.modes=12"])
    o, spin = build_operators(scenario), scenario.root.spin_rate
    beam = SpinningBeam(o.K, o.M1, o.C, hinged=False)
    np.testing.assert_allclose(beam.chordwise(0.0, 1), AT_REST, rtol=1e-8)
    excess = beam.chordwise(spin, 3) / [UNIT * series_frequency(spin / UNIT, g / UNIT) for g in GUESSES] - 1.0
    assert np.all((excess > -1e-10) & (excess < 2.5e-6)), excess


def series_frequency(eta: float, guess: float) -> float:
    """Chordwise frequency of the clamped beam next to `guess`, by the power series of its shape, in 40 digits.

    w_xxxx = omega_f^2 w + eta^2 ((1 - x^2)/2 w_x)_x, clamped at 0, free at 1; omega_c^2 = omega_f^2 - eta^2.
    """

    def tip(square: mp.mpf) -> mp.mpf:
        ends = []
        for start in (2, 3):
            a = [mp.mpf(0)] * 160
            a[start] = mp.mpf(1)
            for n in range(156):
                tension = (n + 2) * (n + 1) * a[n + 2] / 2 - n * (n + 1) * a[n] / 2
                a[n + 4] = (square * a[n] + eta**2 * tension) / ((n + 1) * (n + 2) * (n + 3) * (n + 4))
            ends.append([sum(n * (n - 1) * (n - 2) ** k * c for n, c in enumerate(a)) for k in (0, 1)])
        return ends[0][0] * ends[1][1] - ends[0][1] * ends[1][0]

    with mp.workdps(40):
        square = mp.findroot(tip, (guess**2 + eta**2, (guess**2 + eta**2) * (1 + 1e-6)))
        return float(mp.sqrt(square - eta**2))


@pytest.mark.parametrize(("method", "accuracy"), [("modal", 1e-8), ("fem", 2e-7)])
def test_frequencies_at_rest_and_at_full_speed(method, accuracy):
    scenario = Scenario.builtin("spin-up", [f"discretization.method={method}", "discretization.elements=64"])
    beam, spin = discretization(method).spectrum(scenario), scenario.root.spin_rate
    exact = [UNIT * series_frequency(spin / UNIT, guess / UNIT) for guess in GUESSES]
    # elements: (beta h)^4/1440 = 1.6e-7 for the third mode; modes: see the spinning beam
    np.testing.assert_allclose(beam.chordwise(0.0, 1), AT_REST, rtol=accuracy)
    np.testing.assert_allclose(beam.chordwise(spin, 3), exact, rtol=accuracy)


@pytest.mark.parametrize("modes", [1, 8])
def test_zeroth_order_kinetics_fail(modes):
    """Without foreshortening the rotating beam softens: unstable above its first frequency (Kane et al. 1987)."""
    history = spin_up(modes=modes, kinetics="zeroth-order")
    spin, tip = history["theta_dot"].values, history["deflection"].values
    length = Scenario.builtin("spin-up").beam.length
    assert history.outcome is Outcome.DIVERGED
    beyond = np.abs(tip) > length
    assert beyond.any()
    assert spin[np.argmax(beyond)] > AT_REST
    # at full speed the deflection grows like exp(sqrt(Omega^2 - omega_1^2) t)
    full = (history["time"].values > 15.0) & np.isfinite(tip)
    rate = np.polyfit(history["time"].values[full], np.log(np.abs(tip[full])), 1)[0]
    assert rate == pytest.approx(np.sqrt(6.0**2 - AT_REST**2), rel=1e-3)
    # the first-order model of the same modes stays where the paper's authors find it
    assert np.abs(spin_up(modes=modes)["deflection"].values).max() < 0.06 * length

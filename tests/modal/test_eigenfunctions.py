"""Eigenfunctions of the uniform beam: boundary conditions, and the textbook formula in long arithmetic."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp

from oblique_impact.modal import Eigenfunctions

FAMILIES = ["clamped-free", "hinged-free"]
MODES, LENGTH = 60, 2.5


@pytest.mark.parametrize("hub", [0.0, 1e-6, 0.02, 1.0, 1e4, 1e20])
@pytest.mark.parametrize("radius", [0.0, 0.3])
def test_sixty_eigenfunctions_turn_with_their_hub(hub, radius):
    """Deflection and moment of the hub at the root, a free tip; orthonormal in the mass of beam and hub."""
    shapes = Eigenfunctions("hub-free", MODES, LENGTH, hub, radius)
    ends, b = np.array([0.0, LENGTH]), shapes.roots
    root, tip = np.stack([shapes.derivative(ends, k) / (b / LENGTH) ** k for k in range(4)], axis=1)
    np.testing.assert_allclose(root[0], radius * b * root[1], atol=1e-12)
    moment = root[2] - radius * b * root[3] + hub * b**3 * root[1]
    np.testing.assert_allclose(moment / (1.0 + radius * b), 0.0, atol=1e-12)
    np.testing.assert_allclose(tip[2:], 0.0, atol=1e-12)
    nodes, weights = np.polynomial.legendre.leggauss(300)
    values = shapes.derivative(0.5 * LENGTH * (1.0 + nodes), 0)
    slope = shapes.derivative(np.zeros(1), 1)[0] * LENGTH
    mass = 0.5 * (values.T * weights) @ values + hub * np.outer(slope, slope)
    np.testing.assert_allclose(mass, np.eye(MODES), atol=1e-11)
    assert np.all(tip[0] > 0.0)


def exact_shape(family: str, mode: int, x: str, order: int) -> float:
    """Textbook formula (Blevins 1979) scaled to the tip value 2, for length 1, in 100 digits.

    The differences of cosh and sinh cancel like exp(-b), which takes 83 digits for mode 60.
    """
    clamped = family == "clamped-free"
    with mp.workdps(100):
        guess = (mp.mpf(mode) - 0.5) * mp.pi if clamped else (mp.mpf(mode) + 0.25) * mp.pi
        if clamped:
            b = mp.findroot(lambda y: mp.cos(y) + mp.sech(y), guess)
            s = (mp.cosh(b) + mp.cos(b)) / (mp.sinh(b) + mp.sin(b))
            raw = lambda z: mp.cosh(z) - mp.cos(z) - s * (mp.sinh(z) - mp.sin(z))  # noqa: E731
        else:
            b = mp.findroot(lambda y: mp.sin(y) - mp.cos(y) * mp.tanh(y), guess)
            raw = lambda z: mp.sin(z) + mp.sin(b) / mp.sinh(b) * mp.sinh(z)  # noqa: E731
        value = mp.diff(raw, b * mp.mpf(x), order) * b**order
        return float(2 * value / raw(b))


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("mode", [1, 12, 60])
@pytest.mark.parametrize("order", [0, 1, 2])
def test_eigenfunctions_agree_with_the_textbook_formula_in_long_arithmetic(family, mode, order):
    places = ["0.07", "0.5", "0.93"]
    shapes = Eigenfunctions(family, mode, 1.0)
    computed = shapes.derivative(np.array([float(x) for x in places]), order)[:, -1]
    exact = [exact_shape(family, mode, x, order) for x in places]
    # the phase b x carries an error of one unit in the last place: b eps = 4e-14 at mode 60
    np.testing.assert_allclose(computed, exact, atol=1e-12 * shapes.roots[-1] ** order)

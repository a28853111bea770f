"""Eigenfunctions of the uniform beam with its hub: boundary conditions, and orthogonality in mass."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact.modal import Eigenfunctions

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

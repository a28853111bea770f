"""The cubic Hermite element in local coordinates."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.polynomial import Polynomial
from skfem import ElementLineHermite
from skfem.element import DiscreteField

_Z = Polynomial([0.0, 1.0])
#: deflection and slope at the left end, then at the right one, over z in [0, 1] on an element of unit length
_SHAPES = (1 - 3 * _Z**2 + 2 * _Z**3, _Z * (1 - _Z) ** 2, 3 * _Z**2 - 2 * _Z**3, _Z**3 - _Z**2)


class LocalHermite(ElementLineHermite):  # type: ignore[misc]
    """scikit-fem's Hermite element, evaluated in each element's own coordinate.

    The parent inverts a Vandermonde matrix of the powers of the global x, which costs digits like
    (length/h)^3: 1e-9 of the stiffness at h = 0.01 length, all of it at h = 1e-5 length.  In the local
    coordinate z = (x - a)/h nothing cancels, whatever the size of the element.
    """

    def gbasis(self, mapping: Any, X: Any, i: int, tind: Any = None) -> tuple[DiscreteField]:
        """Shape function i with its first two derivatives at local points X, (1, nq) or (1, elements, nq)."""
        nodes, cells = mapping.mesh.p[0], mapping.mesh.t
        width = nodes[cells[1]] - nodes[cells[0]]
        h = (width if tind is None else width[tind])[:, None]
        z = X[0] * np.ones_like(h)
        scale = h if i % 2 else np.ones_like(h)  # slopes are degrees of freedom too
        value, slope, curvature = (scale / h**k * _SHAPES[i].deriv(k)(z) for k in range(3))
        return (DiscreteField(value=value, grad=slope[None], hess=curvature[None, None]),)

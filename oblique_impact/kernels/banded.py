"""Symmetric banded algebra with three diagonals on either side, as cubic Hermite elements give it.

Matrices are kept by diagonals, bands[b, 3 + k, i] being the entry (i, i + k) of matrix b; factors by rows,
(n + 3, 4) with zeros behind the last one.
"""

from __future__ import annotations

from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.workspace import Array

HALF_BANDWIDTH = 3


@jitable
def _band_row(bands: Array, which: int, x: Array, i: int, first: int, end: int) -> float:
    total = 0.0
    for j in range(first, end):
        total += bands[which, HALF_BANDWIDTH + j - i, i] * x[j]
    return total


@jitable
def band_multiply(bands: Array, which: int, x: Array, product: Array) -> None:
    """bands[which] times x (n,) into `product` (n,)."""
    n = x.shape[0]
    for i in range(n - 2 * HALF_BANDWIDTH):  # contiguous in i: this loop runs four or eight rows at a time
        product[i + 3] = (
            bands[which, 0, i + 3] * x[i]
            + bands[which, 1, i + 3] * x[i + 1]
            + bands[which, 2, i + 3] * x[i + 2]
            + bands[which, 3, i + 3] * x[i + 3]
            + bands[which, 4, i + 3] * x[i + 4]
            + bands[which, 5, i + 3] * x[i + 5]
            + bands[which, 6, i + 3] * x[i + 6]
        )
    if n < 2 * HALF_BANDWIDTH + 1:
        for i in range(n):
            product[i] = _band_row(bands, which, x, i, max(0, i - HALF_BANDWIDTH), min(n, i + HALF_BANDWIDTH + 1))
        return
    # the rows at the ends have fixed lengths, so that these loops unroll
    product[0] = _band_row(bands, which, x, 0, 0, 4)
    product[1] = _band_row(bands, which, x, 1, 0, 5)
    product[2] = _band_row(bands, which, x, 2, 0, 6)
    product[n - 3] = _band_row(bands, which, x, n - 3, n - 6, n)
    product[n - 2] = _band_row(bands, which, x, n - 2, n - 5, n)
    product[n - 1] = _band_row(bands, which, x, n - 1, n - 4, n)


@jitable
def factor_band(bands: Array, first: int, a: float, second: int, b: float, factors: Array) -> bool:
    """L D L^T of a bands[first] + b bands[second], by rows [1/D, L(i,i-1), L(i,i-2), L(i,i-3)].

    False if the sum is not positive definite.
    """
    n = bands.shape[2]
    for i in range(n):
        low = max(0, i - HALF_BANDWIDTH)
        for j in range(low, i + 1):
            at = HALF_BANDWIDTH + j - i
            entry = a * bands[first, at, i] + b * bands[second, at, i]
            for m in range(low, j):
                # rows keep L; D is the inverse of what is stored in front
                if j - m <= HALF_BANDWIDTH:
                    entry -= factors[i, i - m] * factors[j, j - m] / factors[m, 0]
            if j < i:
                factors[i, i - j] = entry * factors[j, 0]
            else:
                if not entry > 0.0:
                    return False
                factors[i, 0] = 1.0 / entry
    return True


@jitable
def solve_band(factors: Array, columns: Array) -> None:
    """Solve in place for three right-hand sides side by side, nearly as quick as for one.

    The recurrences run in registers: their latency, not the arithmetic, is what a solve costs.
    """
    n = columns.shape[0] - HALF_BANDWIDTH
    a0, a1, a2, b0, b1, b2, c0, c1, c2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        near, middle, far = factors[i, 1], factors[i, 2], factors[i, 3]
        x0 = (columns[i, 0] - far * a0 - middle * b0) - near * c0
        x1 = (columns[i, 1] - far * a1 - middle * b1) - near * c1
        x2 = (columns[i, 2] - far * a2 - middle * b2) - near * c2
        a0, a1, a2, b0, b1, b2, c0, c1, c2 = b0, b1, b2, c0, c1, c2, x0, x1, x2
        columns[i, 0], columns[i, 1], columns[i, 2] = (
            x0 * factors[i, 0],
            x1 * factors[i, 0],
            x2 * factors[i, 0],
        )
    a0, a1, a2, b0, b1, b2, c0, c1, c2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for reverse in range(n):
        i = n - 1 - reverse
        near, middle, far = factors[i + 1, 1], factors[i + 2, 2], factors[i + 3, 3]
        x0 = (columns[i, 0] - far * a0 - middle * b0) - near * c0
        x1 = (columns[i, 1] - far * a1 - middle * b1) - near * c1
        x2 = (columns[i, 2] - far * a2 - middle * b2) - near * c2
        a0, a1, a2, b0, b1, b2, c0, c1, c2 = b0, b1, b2, c0, c1, c2, x0, x1, x2
        columns[i, 0], columns[i, 1], columns[i, 2] = x0, x1, x2

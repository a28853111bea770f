"""Symmetric banded algebra with three diagonals on either side, as cubic Hermite elements give it.

Matrices are kept by their upper diagonals, bands[b, k, i] being the entries (i, i + k) and (i + k, i) of matrix b,
so that the memory that a step reads is half as large; factors by rows, (n + 3, 4) with zeros behind the last one.
"""

from __future__ import annotations

from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.workspace import Array

HALF_BANDWIDTH = 3


@jitable
def _band_row(bands: Array, which: int, x: Array, i: int, first: int, end: int) -> float:
    total = 0.0
    for j in range(first, end):
        total += bands[which, abs(j - i), min(i, j)] * x[j]
    return total


@jitable
def band_multiply(bands: Array, which: int, x: Array, product: Array) -> None:
    """bands[which] times x (n,) into `product` (n,)."""
    n = x.shape[0]
    for i in range(n - 2 * HALF_BANDWIDTH):  # contiguous in i: this loop runs four or eight rows at a time
        product[i + 3] = (
            bands[which, 3, i] * x[i]
            + bands[which, 2, i + 1] * x[i + 1]
            + bands[which, 1, i + 2] * x[i + 2]
            + bands[which, 0, i + 3] * x[i + 3]
            + bands[which, 1, i + 3] * x[i + 4]
            + bands[which, 2, i + 3] * x[i + 5]
            + bands[which, 3, i + 3] * x[i + 6]
        )
    ends = min(n, HALF_BANDWIDTH)
    for i in range(ends):
        product[i] = _band_row(bands, which, x, i, 0, min(n, i + HALF_BANDWIDTH + 1))
    for i in range(max(ends, n - HALF_BANDWIDTH), n):
        product[i] = _band_row(bands, which, x, i, i - HALF_BANDWIDTH, n)


@jitable
def factor_band(
    bands: Array, first: int, a: float, second: int, b: float, at: int, more: float, factors: Array
) -> bool:
    """L D L^T of a bands[first] + b bands[second], by rows [1/D, L(i,i-1), L(i,i-2), L(i,i-3)].

    The diagonal entry `at` has `more` besides.  False if the sum is not positive definite.
    """
    n = bands.shape[2]
    for i in range(n):
        low = max(0, i - HALF_BANDWIDTH)
        for j in range(low, i + 1):
            entry = a * bands[first, i - j, j] + b * bands[second, i - j, j]
            if i == j == at:
                entry += more
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
def solve_band(factors: Array, x: Array) -> None:
    """Solve in place for one right-hand side x (n,)."""
    n = x.shape[0]
    a, b, c = 0.0, 0.0, 0.0
    for i in range(n):
        value = (x[i] - factors[i, 3] * a - factors[i, 2] * b) - factors[i, 1] * c
        a, b, c = b, c, value
        x[i] = value * factors[i, 0]
    a, b, c = 0.0, 0.0, 0.0
    for reverse in range(n):
        i = n - 1 - reverse
        value = (x[i] - factors[i + 3, 3] * a - factors[i + 2, 2] * b) - factors[i + 1, 1] * c
        a, b, c = b, c, value
        x[i] = value


@jitable
def solve_band_columns(factors: Array, columns: Array) -> None:
    """Solve in place for three right-hand sides side by side, columns (n + 3, 4), far quicker than one by one.

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

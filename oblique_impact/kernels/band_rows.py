"""Solving equations with a band matrix that need not be symmetric, kept by rows.

The band is that of quadratic elements with three unknowns a node.  rows[i, 8 + j - i] is the entry (i, j), rows
(n + 8, 17), with zeros behind the last row, so that the loops need no special case and have a fixed length.

Pivots are not sought: the matrices are those of mechanics, definite but for a small part.  A step's equations are
solved again for what is left of them, so that a digit lost here costs an iteration.
"""

from __future__ import annotations

import numpy as np

from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import Array

#: diagonals on either side of the main one
BANDWIDTH = 8


def new_rows(n: int) -> Array:
    """Allocate a matrix (n, n)."""
    return np.zeros((n + BANDWIDTH, 2 * BANDWIDTH + 1))


@jitable
def factor_rows(rows: Array, first: int) -> bool:
    """L U in the place of the matrix without its first rows and columns; False if a pivot is 0 or no number.

    The main diagonal holds the inverses of that of U; that of L is 1.
    """
    for k in range(first, rows.shape[0] - BANDWIDTH):
        pivot = rows[k, BANDWIDTH]
        if not abs(pivot) > 0.0:
            return False
        inverse = 1.0 / pivot
        rows[k, BANDWIDTH] = inverse
        for down in range(1, BANDWIDTH + 1):
            share = rows[k + down, BANDWIDTH - down] * inverse
            rows[k + down, BANDWIDTH - down] = share
            for right in range(1, BANDWIDTH + 1):
                rows[k + down, BANDWIDTH - down + right] -= share * rows[k, BANDWIDTH + right]
    return True


@inlined
def _before(rows: Array, i: int, x: Array, width: int) -> float:
    """Return the product of L's row with the entries of x before it."""
    total = 0.0
    for k in range(width, 0, -1):  # the latest entry last: the next ones wait for it
        total += rows[i, BANDWIDTH - k] * x[i - k]
    return total


@inlined
def _behind(rows: Array, i: int, x: Array, width: int) -> float:
    """Return the product of U's row with the entries of x behind it."""
    total = 0.0
    for k in range(width, 0, -1):
        total += rows[i, BANDWIDTH + k] * x[i + k]
    return total


@jitable
def solve_rows_of(rows: Array, first: int, x: Array) -> None:
    """Solve in place for x (n,) with these factors; its first entries, which have no equations, become 0."""
    n = x.shape[0]
    for i in range(first):
        x[i] = 0.0
    middle = min(first + BANDWIDTH, n)
    for i in range(first, middle):
        x[i] -= _before(rows, i, x, i - first)
    for i in range(middle, n):
        x[i] -= _before(rows, i, x, BANDWIDTH)
    middle = max(first, n - BANDWIDTH)
    for i in range(n - 1, middle - 1, -1):
        x[i] = (x[i] - _behind(rows, i, x, n - 1 - i)) * rows[i, BANDWIDTH]
    for i in range(middle - 1, first - 1, -1):
        x[i] = (x[i] - _behind(rows, i, x, BANDWIDTH)) * rows[i, BANDWIDTH]

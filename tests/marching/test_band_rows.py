"""Band matrices by rows against SciPy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import solve

from oblique_impact.kernels.band_rows import BANDWIDTH, factor_rows, new_rows, solve_rows_of


@pytest.mark.parametrize("n", [9, 10, 21])
@pytest.mark.parametrize("first", [0, 3])
def test_equations_are_solved_without_the_first_unknowns(n, first):
    rng = np.random.default_rng(n)
    near = np.abs(np.subtract.outer(np.arange(n), np.arange(n))) <= BANDWIDTH
    matrix = near * rng.normal(size=(n, n)) + 10.0 * np.eye(n)
    rows, x = new_rows(n), rng.normal(size=n)
    for i in range(n):
        for j in range(max(0, i - BANDWIDTH), min(n, i + BANDWIDTH + 1)):
            rows[i, BANDWIDTH + j - i] = matrix[i, j]
    known = np.concatenate([np.zeros(first), solve(matrix[first:, first:], x[first:])])
    assert factor_rows(rows, first)
    solve_rows_of(rows, first, x)
    assert x == pytest.approx(known, rel=1e-12, abs=1e-14)


def test_a_singular_matrix_has_no_factors():
    assert not factor_rows(new_rows(9), 0)

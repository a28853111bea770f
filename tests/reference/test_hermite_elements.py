"""Items 1.3 and 1.4: frequency errors of cubic Hermite elements."""

from __future__ import annotations

import numpy as np
import pytest

from fem_beam import build_operators
from validation.beams import unit_beam
from validation.reference_values import VALUES

FRAMES = {"c": "tangent", "h": "mean-axis"}
ROOTS = {"c": np.array(VALUES["1.1"][:3]), "h": np.array(VALUES["1.2"][:3])}
MESHES = [("c", 4), ("c", 8), ("c", 16), ("c", 32), ("h", 8), ("h", 16)]


def frequency_errors(root: str, elements: int) -> np.ndarray:
    """Relative errors of the first three elastic frequencies."""
    scenario = unit_beam(method="fem", frame=FRAMES[root], modes=3, elements=elements)
    return build_operators(scenario).natural_frequencies() / ROOTS[root] ** 2 - 1.0


@pytest.mark.parametrize(("root", "elements"), MESHES)
def test_frequency_errors_are_those_of_forty_digits(root, elements):
    # 2e-13 absolute is the rounding of the frequency itself, 2.4e-5 of the smallest error here (8.2e-9)
    np.testing.assert_allclose(
        frequency_errors(root, elements), VALUES[f"1.4-{root}{elements}"], rtol=1e-8, atol=2e-13
    )


@pytest.mark.parametrize("root", ["c", "h"])
def test_frequencies_converge_at_order_four(root):
    coarse, fine = frequency_errors(root, 16), frequency_errors(root, 32)
    order = np.log2(coarse / fine)
    assert np.all((order > 3.9) & (order < 4.1)), order
    # the asymptotic error (item 1.3), up to the next term of relative size (beta h)^2
    ceiling = VALUES["1.3"] * (ROOTS[root] / 32) ** 4
    assert np.all(np.abs(fine / ceiling - 1.0) < (ROOTS[root] / 32) ** 2)

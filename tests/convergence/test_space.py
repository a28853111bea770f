"""Finite elements approach the assumed modes at order 4 (theory Sec. 6: same spectral content)."""

from __future__ import annotations

import numpy as np
import pytest

from validation.runs import contact_times

MEAN_AXIS = ("discretization.frame=mean-axis", "discretization.modes=6", "end_time=0.335")


@pytest.fixture(scope="module")
def differences(run):
    reference = contact_times(run("paper", *MEAN_AXIS))
    found = {}
    for elements in (32, 64, 128, 256):
        history = run("paper", *MEAN_AXIS, "discretization.method=fem", f"discretization.elements={elements}")
        found[elements] = np.abs(contact_times(history) - reference).max()
    return found


@pytest.mark.parametrize("elements", [32, 64, 128])
def test_each_doubling_divides_the_difference_by_sixteen(differences, elements):
    assert 15.0 < differences[elements] / differences[2 * elements] < 16.5


def test_difference_at_128_elements(differences):
    assert differences[128] < 3e-8

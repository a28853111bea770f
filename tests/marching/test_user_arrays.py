"""Arrays from user code: views, other orders and other types are computed right, or refused in one line."""

import numpy as np
import pytest

from oblique_impact import InputError, MechanicalSystem, simulate_system
from oblique_impact.kernels.system import ContactRows


def column(values):
    """Return the same numbers as a column of a matrix."""
    wide = np.full((np.size(values), 3), np.nan)
    wide[:, 1] = values
    return wide[:, 1]


def backwards(values):
    return np.array(values)[::-1].copy()[::-1]


class Puck(MechanicalSystem):
    """A mass that slides on the ground; arrays as `make` returns them."""

    size = 2

    def __init__(self, make=np.asarray, mass=None):
        self.make, self.mass = make, np.eye(2) if mass is None else mass

    def mass_matrix(self, t, q):
        return self.mass

    def forces(self, t, q, qd):
        return self.make([-1, -10])

    def contact(self, t, q, qd):
        return ContactRows(q[1], q[0], qd[1], qd[0], self.make([0, 1]), self.make([1, 0]))

    def energy(self, t, q, qd):
        return 0.5 * float(qd @ qd), 0.0, 10.0 * q[1]


@pytest.mark.parametrize("make", [column, backwards, list, lambda v: np.array(v, dtype=np.int8)])
def test_a_system_may_return_views_integers_and_lists(make):
    states = [make([0, 0]), make([3, 0])]
    history = simulate_system(Puck(make, np.asfortranarray(np.eye(2, dtype=np.float32))), *states, 0.5)
    assert float(history["q"][-1, 0]) == pytest.approx(3.0 * 0.5 - 0.5 * 0.5**2, abs=1e-12)


@pytest.mark.parametrize(
    ("system", "named"),
    [
        (Puck(mass=np.ones(2)), "mass_matrix"),
        (Puck(lambda v: np.array(v) + 0j), "forces"),
        (Puck(lambda v: np.array([v])), "forces"),
    ],
)
def test_a_system_that_returns_other_shapes_or_complex_numbers_is_refused(system, named):
    with pytest.raises(InputError, match=named):
        simulate_system(system, [0.0, 0.0], [3.0, 0.0], 0.1)
    with pytest.raises(InputError, match="q0"):
        simulate_system(Puck(), [0.0, 0.0, 0.0], [3.0, 0.0], 0.1)

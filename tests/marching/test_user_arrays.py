"""Arrays from user code: views, other orders and other types are computed right, or refused in one line."""

import numpy as np
import pytest

from oblique_impact import InputError, MechanicalSystem, simulate_system
from oblique_impact.kernels.system import ContactRows
from oblique_impact.scenario.sections import SolverSection
from tests.refusals import refused_in_one_line
from tests.systems import RungeKutta


def column(values):
    """Return the same numbers as a column of a matrix."""
    wide = np.full((np.size(values), 3), np.nan)
    wide[:, 1] = values
    return wide[:, 1]


def backwards(values):
    return np.array(values)[::-1].copy()[::-1]


def integrated(returned=np.asarray, asked=np.asarray):
    """Return q of a mass that slides and stops, by an integrator that returns and asks with other arrays."""

    class Other(RungeKutta):
        def step(self, rates, t, y, h):
            end = super().step(lambda s, z: rates(s, asked(z)), t, y.copy(), h)
            y[:] = np.nan  # it may work in place
            return returned(end)

    scheme = Other(SolverSection(free_step=5e-3, contact_step=5e-3))
    return simulate_system(Puck(), [0.0, 0.0], [3.0, 0.0], 0.5, scheme=scheme)["q"]


@pytest.mark.parametrize("view", [column, backwards, lambda y: np.asarray(y, dtype=np.longdouble), list])
def test_what_an_integrator_hands_over_may_be_a_view_or_of_another_type(view):
    for found in (integrated(returned=view), integrated(asked=view)):
        np.testing.assert_array_equal(found, integrated())


def test_an_integrator_may_return_its_own_buffer():
    kept = np.zeros(11)  # two coordinates, two velocities, seven quadratures

    def buffered(end):
        kept[:] = end
        return kept

    np.testing.assert_array_equal(integrated(buffered), integrated())


@pytest.mark.parametrize("wrong", [lambda y: y[:-1], lambda y: y + 0j, lambda y: y[None], lambda y: "y"])
@pytest.mark.parametrize("where", ["returned", "asked"])
def test_what_is_no_state_is_refused_in_one_line(wrong, where):
    with refused_in_one_line("Other"):
        integrated(**{where: wrong})


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

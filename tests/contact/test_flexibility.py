"""Flexibility behind contact rows, across the beam and along it: its balance of energy, how places share it."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact.contact.flexibility import Flexibility, end_step, push_places, take_places

CLOSED = np.array([2, 0, 1])


@pytest.mark.parametrize("step", [1e-6, 1e-4], ids=["resolves", "does not resolve"])
def test_work_of_contact_forces_is_held_or_taken_by_damping_and_scheme(step):
    """The mid-point rule takes nothing where the step resolves the relaxation."""
    rng = np.random.default_rng(1)
    root = rng.normal(size=(3, 3))
    matrix = root @ root.T
    y = Flexibility.across(matrix, 1e-5, np.array([0.2, -0.4, 0.0]), np.array([0.0, 0.0, -1.0]))
    take_places(y, 0.3, np.zeros((3, 3)))
    for _ in range(5):
        impulses = rng.normal(size=6)
        force = np.sum(y.toward[CLOSED] * impulses.reshape(3, 2), axis=1) / step
        push_places(y, step, impulses, CLOSED, 3)
        work = force @ y.moved[CLOSED]
        damping, scheme, held = end_step(y, step)
        assert work == pytest.approx(held + damping + scheme, rel=1e-12)
        assert damping > 0.0
        assert scheme == pytest.approx(0.0, abs=1e-12 * damping) if step < 1e-5 else scheme > 0.0
        np.testing.assert_allclose(y.displaced, matrix @ y.pressed, rtol=1e-12)


def test_a_force_along_one_tangent_moves_the_material_along_others():
    """A bar on its root, of 2e-8 m/N; the second tangent points to the root, the third place slides."""
    table, force, step = np.array([[0.0, 1.0], [0.0, 2e-8]]), 5.0, 1e-5
    y = Flexibility.along(table, np.array([0.3, 0.8, np.nan]), np.array([1.0, -1.0, 1.0]))
    take_places(y, 0.0, np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, -0.6, 0.0]]))
    push_places(y, step, np.array([0.0, force * step]), np.array([1]), 1)
    np.testing.assert_allclose(y.toward[:, 1] * y.moved, force * 2e-8 * np.array([-0.3, 0.8, -0.6]), rtol=1e-12)
    assert np.all(y.toward[:, 0] == 0.0)

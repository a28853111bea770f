"""Complementarity problems of several contacts, against their definition and by trying all cases."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from oblique_impact.contact.complementarity import (
    Candidate,
    NoSolutionError,
    contact_forces,
    lemke,
    plastic_impulses,
)
from oblique_impact.errors import Outcome, RunEnded

SEEDS = range(40)


def by_trying(matrix: np.ndarray, vector: np.ndarray) -> list[np.ndarray]:
    """Return all solutions of a problem that is not degenerate."""
    found = []
    for chosen in product([False, True], repeat=len(vector)):
        z = np.zeros(len(vector))
        on = np.array(chosen)
        if on.any():
            z[on] = np.linalg.solve(matrix[np.ix_(on, on)], -vector[on])
        if (z >= 0.0).all() and ((matrix @ z + vector)[~on] >= 0.0).all():
            found.append(z)
    return found


@pytest.mark.parametrize("seed", SEEDS)
def test_a_positive_definite_problem_has_its_one_solution(seed):
    random = np.random.default_rng(seed)
    factor = random.normal(size=(5, 5))
    matrix, vector = factor @ factor.T + 0.1 * np.eye(5), random.normal(size=5)
    (expected,) = by_trying(matrix, vector)
    assert lemke(matrix, vector) == pytest.approx(expected, rel=1e-9, abs=1e-11)


def test_a_problem_on_which_simple_pivoting_cycles_is_solved():
    """Murty's example: without a rule for ties, rows of zeros are exchanged for ever."""
    matrix = np.array([[1.0, 2.0, 0.0], [0.0, 1.0, 2.0], [2.0, 0.0, 1.0]])
    z = lemke(matrix, -np.ones(3))
    assert z == pytest.approx(np.full(3, 1.0 / 3.0))


def test_redundant_contacts_have_forces_with_the_right_sum():
    z = lemke(np.ones((3, 3)), -np.ones(3))
    assert z.sum() == pytest.approx(1.0)


def test_a_problem_without_a_solution_ends_in_a_ray():
    with pytest.raises(NoSolutionError):
        lemke(np.array([[-1.0]]), np.array([-1.0]))


def beam_like(random: np.random.Generator, contacts: int, coordinates: int = 9) -> np.ndarray:
    """Return a Delassus matrix (n, 2, n, 2) of random rows."""
    rows = random.normal(size=(2 * contacts, coordinates))
    return (rows @ rows.T).reshape(contacts, 2, contacts, 2)


@pytest.mark.parametrize("seed", SEEDS)
def test_forces_obey_the_laws_of_contact_and_friction(seed):
    random = np.random.default_rng(seed)
    delassus, free = beam_like(random, 3), random.normal(size=(3, 2))
    candidates = [
        Candidate(slip, -0.2 * slip, 0.25, push)
        for slip, push in zip(random.integers(-1, 2, 3), random.choice([None, None, 2.0], 3), strict=True)
    ]
    forces, accelerations = contact_forces(delassus, free, candidates)
    assert accelerations == pytest.approx(free + np.tensordot(delassus, forces, axes=2), abs=1e-9)
    for c, (normal, tangential), (gap, slip) in zip(candidates, forces, accelerations, strict=True):
        if c.push is None:
            assert normal >= 0.0
            assert gap >= -1e-10
            assert normal * gap == pytest.approx(0.0, abs=1e-9)
        else:
            assert normal == c.push
        if c.slip != 0:
            assert tangential == pytest.approx(c.ratio * normal)
        elif abs(slip) > 1e-10:
            assert tangential == pytest.approx(-c.static * normal * np.sign(slip), abs=1e-9)
        else:
            assert abs(tangential) <= c.static * normal + 1e-9


def test_a_rod_that_friction_drives_into_the_ground_is_painleve():
    """One sliding contact with A_nn + r A_nt < 0 that accelerates downwards (Painleve 1895)."""
    delassus = np.array([[1.0, 3.0], [3.0, 10.0]]).reshape(1, 2, 1, 2)
    with pytest.raises(RunEnded) as ended:
        contact_forces(delassus, np.array([[-1.0, 0.0]]), [Candidate(1, -0.5, 0.5, None)])
    assert ended.value.outcome is Outcome.PAINLEVE


@pytest.mark.parametrize("seed", SEEDS)
def test_a_plastic_impact_only_pushes_and_loses_the_least_energy_that_it_can(seed):
    """Moreau: the velocities after are the nearest admissible ones in the metric of kinetic energy."""
    random = np.random.default_rng(seed)
    rows, before = random.normal(size=(3, 6)), random.normal(size=6)
    impulses = plastic_impulses(rows @ rows.T, rows @ before)
    after = before + rows.T @ impulses
    assert (impulses >= 0.0).all()
    assert (rows @ after >= -1e-9).all()
    for other in random.normal(size=(50, 6)):
        admissible = other + rows.T @ plastic_impulses(rows @ rows.T, rows @ other)
        assert np.sum((admissible - before) ** 2) >= np.sum((after - before) ** 2) - 1e-9

"""Complementarity problems of several contacts, against their definition and by trying all cases."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from oblique_impact.contact.complementarity import (
    Closed,
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
        Closed(slip, -0.2 * slip, 0.25, push)
        for slip, push in zip(random.integers(-1, 2, 3), random.choice([None, None, 2.0], 3), strict=True)
    ]
    forces, accelerations, _ = contact_forces(delassus, free, candidates)
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
        contact_forces(delassus, np.array([[-1.0, 0.0]]), [Closed(1, -0.5, 0.5, None)])
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


def by_all_states(delassus: np.ndarray, free: np.ndarray, candidates: list[Closed]) -> list[np.ndarray]:
    """Return the motions (n, 2) that contacts can have, by solving for each of them open, sliding and at rest."""
    n, found = len(candidates), list[np.ndarray]()
    matrix = delassus.reshape(2 * n, 2 * n)
    states = [("open", "slides") if c.slip else ("open", "sticks", "forwards", "backwards") for c in candidates]
    for state in product(*states):
        equations, right = np.eye(2 * n), np.zeros(2 * n)
        for i, (own, c) in enumerate(zip(state, candidates, strict=True)):
            ratio = {"slides": c.ratio, "forwards": -c.static, "backwards": c.static}.get(own, 0.0)
            if own != "open":
                equations[2 * i], right[2 * i] = matrix[2 * i], -free[i, 0]
            if own == "sticks":
                equations[2 * i + 1], right[2 * i + 1] = matrix[2 * i + 1], -free[i, 1]
            else:
                equations[2 * i + 1, 2 * i] -= ratio
        forces = np.linalg.solve(equations, right)
        motion = (free.ravel() + matrix @ forces).reshape(n, 2)
        normal, tangential = forces.reshape(n, 2).T
        agrees = (normal >= -1e-9).all() and (motion[:, 0] >= -1e-9).all()
        for own, c, held, rubbed, slip in zip(state, candidates, normal, tangential, motion[:, 1], strict=True):
            agrees &= own != "sticks" or abs(rubbed) <= c.static * held + 1e-9
            agrees &= own != "forwards" or slip >= -1e-9
            agrees &= own != "backwards" or slip <= 1e-9
        if agrees and not any(np.allclose(motion, other, atol=1e-6) for other in found):
            found.append(motion)
    return found


@pytest.mark.parametrize("friction", [0.6, 2.0, 5.0])
def test_painleve_is_named_where_no_state_solves_the_problem_and_only_there(friction):
    """Of the solutions that trying all states finds, that with the fewest closed contacts is returned."""
    random, named, several = np.random.default_rng(0), 0, 0
    for _ in range(150):
        n = int(random.integers(1, 4))
        delassus, free = beam_like(random, n), 3.0 * random.normal(size=(n, 2))
        slips = random.integers(-1, 2, n)
        candidates = [Closed(int(slip), -friction * float(slip), friction, None) for slip in slips]
        motions = by_all_states(delassus, free, candidates)
        if not motions:
            named += 1
            with pytest.raises(RunEnded) as ended:
                contact_forces(delassus, free, candidates)
            assert ended.value.outcome is Outcome.PAINLEVE
            continue
        found = contact_forces(delassus, free, candidates)
        closed = [np.count_nonzero(np.abs(motion[:, 0]) < 1e-9) for motion in motions]
        assert np.count_nonzero(found.forces[:, 0]) == min(closed)
        assert any(np.allclose(found.accelerations, motion, atol=1e-6) for motion in motions)
        assert found.several == (len(motions) > 1)
        several += found.several
    assert several > 0 or friction < 1.0
    assert named > 0 or friction < 1.0


def test_two_contacts_open_where_lemke_ends_in_a_ray():
    """The gaps grow without forces: that solves the problem, and so do two contacts that slide."""
    rows = [[9.7, 2.2, 0.7, -5.2], [2.2, 2.9, 0.5, -0.3], [0.7, 0.5, 1.7, -0.6], [-5.2, -0.3, -0.6, 3.4]]
    delassus, free = np.array(rows).reshape(2, 2, 2, 2), np.array([[0.9, 7.5], [0.1, -0.6]])
    candidates = [Closed(0, 0.0, 5.0, None), Closed(-1, 5.0, 5.0, None)]
    found = contact_forces(delassus, free, candidates)
    assert not found.forces.any()
    assert found.accelerations == pytest.approx(free)
    assert found.several
    assert len(by_all_states(delassus, free, candidates)) == 2


def test_redundant_contacts_at_rest_have_one_motion():
    """Two contacts at one place share their forces as they like: that is no other motion."""
    delassus = np.kron(np.ones((2, 2)), np.array([[2.0, 0.3], [0.3, 1.0]])).reshape(2, 2, 2, 2)
    rests = Closed(0, 0.0, 1.0, None)
    found = contact_forces(delassus, np.array([[-1.0, 0.2]] * 2), [rests, rests])
    assert not found.several
    assert found.accelerations == pytest.approx(np.zeros((2, 2)), abs=1e-12)

"""Contacts by complementarity: random problems against the laws that they solve and against trying all states."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
import pytest

from oblique_impact.contact.complementarity import (
    OPEN,
    STUCK,
    Closed,
    ContactProblem,
    contact_forces,
    plastic_impulses,
    solve_contacts,
)
from oblique_impact.errors import Outcome, RunEnded

#: rounding, of the terms of a rate or of the largest force
SMALL = 1e-8
#: 10,000 problems, by their number of contacts
COUNTS = {1: 2_000, 2: 4_000, 3: 2_500, 4: 1_500}


class Problems(NamedTuple):
    """N problems of n contacts: at rest or sliding, on rigid stops or on compliant ones of known force."""

    delassus: np.ndarray  # (N, 2 n, 2 n)
    free: np.ndarray  # (N, 2 n)
    slip: np.ndarray  # (N, n) direction of slip of one that slides, 0 at rest
    ratio: np.ndarray  # (N, n) lambda_tau / lambda_n of one that slides
    static: np.ndarray  # (N, n)
    push: np.ndarray  # (N, n) NaN of a rigid one

    def candidates(self, i: int) -> list[Closed]:
        """The contacts of problem i."""
        pushes = [None if np.isnan(push) else float(push) for push in self.push[i]]
        numbers = zip(self.slip[i].tolist(), self.ratio[i].tolist(), self.static[i].tolist(), pushes, strict=True)
        return [Closed(*one) for one in numbers]


def random_problems(seed: int, count: int, n: int, pinned: bool, singular: bool) -> Problems:
    """Problems of a mechanical system, of few coordinates if `singular`; `pinned`: some of each kind."""
    random = np.random.default_rng(seed)
    coordinates = n + 1 if singular else 2 * n + 3
    rows, pull = random.normal(size=(count, 2 * n, coordinates)), random.normal(size=(count, coordinates, 1))
    static = random.uniform(0.0, 5.0, (count, n)) * (random.random((count, n)) < 0.95)
    slip = random.integers(-1, 2, (count, n)) * pinned
    push = np.where(random.random((count, n)) < 0.2 * pinned, random.uniform(0.0, 3.0, (count, n)), np.nan)
    ratio = -slip * static * random.uniform(0.5, 1.0, (count, n))
    return Problems(rows @ rows.transpose(0, 2, 1), (rows @ pull)[:, :, 0], slip, ratio, static, push)


def rates(p: Problems, forces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rates (N, 2 n) with forces (N, 2 n), and their rounding."""
    terms = np.abs(p.free) + (np.abs(p.delassus) @ np.abs(forces)[:, :, None])[:, :, 0]
    return p.free + (p.delassus @ forces[:, :, None])[:, :, 0], SMALL * terms


def obeys(p: Problems, forces: np.ndarray) -> np.ndarray:
    """Whether forces (N, 2 n) obey the laws of contact and friction, (N,)."""
    motion, terms = rates(p, forces)
    small, rigid = SMALL * (1.0 + np.abs(forces).max(axis=1, keepdims=True)), np.isnan(p.push)
    normal, along, gap, slip = forces[:, ::2], forces[:, 1::2], motion[:, ::2], motion[:, 1::2]
    opens, slips = gap > terms[:, ::2], np.abs(slip) > terms[:, 1::2]
    contact = (normal >= -small) & (gap >= -terms[:, ::2]) & (~opens | (normal <= small))
    cone = np.abs(along) <= p.static * normal + small
    rests = cone & (~slips | (np.abs(along + p.static * normal * np.sign(slip)) <= small))
    friction = np.where(p.slip == 0, rests, np.abs(along - p.ratio * normal) <= small)
    return np.all(np.where(rigid, contact, np.abs(normal - p.push) <= small) & friction, axis=1)


class Found(NamedTuple):
    """What trying all states finds of N problems."""

    exists: np.ndarray  # (N,)
    several: np.ndarray  # (N,) whether there are different motions
    fewest: np.ndarray  # (N,) least number of contacts that push
    motions: np.ndarray  # (S, N, 2 n) of all states, NaN of those that solve nothing


def by_trying(p: Problems) -> Found:
    """Solve the linear equations of every state of every contact: open, sticking, slipping in two directions."""
    count, n = p.slip.shape
    motions, pushing = [], []
    for states in np.array(list(product(range(4), repeat=n))):
        possible = (np.isnan(p.push) | (states != 0)) & ((p.slip == 0) | (states <= 1))
        chosen = np.flatnonzero(possible.all(axis=1))
        own = Problems(*(numbers[chosen] for numbers in p))
        closed, sticks = np.isnan(own.push) & (states != 0), (own.slip == 0) & (states == 1)
        ratio = np.where(own.slip != 0, own.ratio, own.static * np.array([0.0, 0.0, -1.0, 1.0])[states])
        unit = np.broadcast_to(np.eye(2 * n), own.delassus.shape)
        normal = np.where(closed[:, :, None], own.delassus[:, ::2], unit[:, ::2])
        slides = unit[:, 1::2] - (ratio * (states != 0))[:, :, None] * unit[:, ::2]
        along = np.where(sticks[:, :, None], own.delassus[:, 1::2], slides)
        pushes = np.where(closed, -own.free[:, ::2], np.nan_to_num(own.push))
        equations = np.stack([normal, along], axis=2).reshape(unit.shape)
        right = np.stack([pushes, np.where(sticks, -own.free[:, 1::2], 0.0)], axis=2).reshape(-1, 2 * n, 1)
        determined = np.linalg.cond(equations, 1) < 1e10
        forces = np.linalg.solve(np.where(determined[:, None, None], equations, unit), right)[:, :, 0]
        solves = determined & obeys(own, forces)
        push = forces[:, ::2] > SMALL * (1.0 + np.abs(forces).max(axis=1, keepdims=True))
        motions.append(np.full((count, 2 * n), np.nan))
        motions[-1][chosen[solves]] = rates(own, forces)[0][solves]
        pushing.append(np.full(count, n + 1))
        pushing[-1][chosen[solves]] = np.sum(push | ~np.isnan(own.push), axis=1)[solves]
    found = np.array(motions)
    exists = ~np.isnan(found[:, :, 0]).all(axis=0)
    least, most = np.fmin.reduce(found), np.fmax.reduce(found)
    apart = most - least > 1e-5 * (1.0 + np.maximum(np.abs(least), np.abs(most)))
    return Found(exists, apart.any(axis=1), np.min(pushing, axis=0), found)


@pytest.mark.parametrize("singular", [False, True])
@pytest.mark.parametrize("n", COUNTS)
def test_forces_are_those_that_trying_all_states_finds(n, singular):
    """Painleve is named where there are none and only there; of several motions one with the fewest contacts."""
    p = random_problems(n, COUNTS[n] // 2, n, True, singular)
    tried, forces, motion = by_trying(p), np.zeros(p.free.shape), np.zeros(p.free.shape)
    several, outcomes = np.zeros(len(forces), dtype=bool), [Outcome.COMPLETED] * len(forces)
    for i in range(len(forces)):
        shape = (n, 2, n, 2)
        try:
            found = contact_forces(p.delassus[i].reshape(shape), p.free[i].reshape(n, 2), p.candidates(i))
        except RunEnded as ended:
            outcomes[i] = ended.outcome
            continue
        forces[i], motion[i], several[i] = found.forces.ravel(), found.accelerations.ravel(), found.several
    exists = np.array([outcome is Outcome.COMPLETED for outcome in outcomes])
    assert set(outcomes) == {Outcome.COMPLETED, Outcome.PAINLEVE}
    assert (exists == tried.exists).all()
    assert 10 < np.count_nonzero(tried.several) < np.count_nonzero(exists) < len(exists) - 10
    assert obeys(p, forces)[exists].all()
    assert (several == tried.several)[exists].all()
    assert (np.count_nonzero(forces[:, ::2], axis=1) == tried.fewest)[exists].all()
    apart = np.abs(tried.motions - motion).max(axis=2) / (1.0 + np.abs(motion).max(axis=1))
    assert np.nanmin(apart[:, exists], axis=0).max() < 1e-6


@pytest.mark.parametrize("guessed", [False, True])
@pytest.mark.parametrize("singular", [False, True])
@pytest.mark.parametrize("n", [1, 2, 5])
def test_impulses_of_a_step_exist_and_obey_the_laws(n, singular, guessed):
    """On velocities no contact is pinned: impulses exist for any friction, whatever states are tried first."""
    count = 400 // n
    p, states = random_problems(n, count, n, False, singular), np.random.default_rng(0).integers(-1, 3, (count, n))
    forces, state = np.zeros(p.free.shape), np.zeros(p.slip.shape)
    for i in range(count):
        one = ContactProblem.new(n)
        one.delassus[:], one.rates[:] = p.delassus[i], p.free[i]
        one.friction[:], one.states[:] = p.static[i], states[i]
        assert solve_contacts(one, n, guessed)
        forces[i], state[i] = one.forces, one.states
    assert obeys(p, forces).all()
    motion, terms = rates(p, forces)
    assert (forces[:, ::2][state == OPEN] == 0.0).all()
    assert (np.abs(motion[:, 1::2]) <= terms[:, 1::2])[state == STUCK].all()
    assert (motion[:, 1::2] * state >= -terms[:, 1::2])[np.abs(state) == 1].all()


@pytest.mark.parametrize("n", [1, 3, 5])
def test_without_friction_a_guess_leads_to_the_impulses_of_a_plastic_impact(n):
    p, states = random_problems(n, 100, n, False, False), np.random.default_rng(0).integers(0, 2, (100, n))
    for delassus, rate, state in zip(p.delassus, p.free, states, strict=True):
        one = ContactProblem.new(n, rubs=False)
        one.delassus[::2, ::2], one.rates[::2], one.states[:] = delassus[::2, ::2], rate[::2], state
        assert solve_contacts(one, n, True)
        assert one.forces[::2] == pytest.approx(plastic_impulses(delassus[::2, ::2], rate[::2]), abs=1e-9)
        assert (one.forces[1::2] == 0.0).all()


@pytest.mark.parametrize("seed", range(40))
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


def test_a_problem_on_which_simple_pivoting_cycles_is_solved():
    """Murty's example: without a rule for ties, rows of zeros are exchanged for ever."""
    matrix = np.array([[1.0, 2.0, 0.0], [0.0, 1.0, 2.0], [2.0, 0.0, 1.0]])
    assert plastic_impulses(matrix, -np.ones(3)) == pytest.approx(np.full(3, 1.0 / 3.0))


def test_a_problem_without_a_solution_has_a_name():
    with pytest.raises(RunEnded) as ended:
        plastic_impulses(np.array([[-1.0]]), np.array([-1.0]))
    assert ended.value.outcome is Outcome.REDUNDANT_CONSTRAINTS


def test_a_rod_that_friction_drives_into_the_ground_is_painleve():
    """One sliding contact with A_nn + r A_nt < 0 that accelerates downwards (Painleve 1895)."""
    delassus = np.array([[1.0, 3.0], [3.0, 10.0]]).reshape(1, 2, 1, 2)
    with pytest.raises(RunEnded) as ended:
        contact_forces(delassus, np.array([[-1.0, 0.0]]), [Closed(1, -0.5, 0.5, None)])
    assert ended.value.outcome is Outcome.PAINLEVE


def test_two_contacts_open_where_lemke_ends_in_a_ray():
    """The gaps grow without forces: that solves the problem, and so do two contacts that slide."""
    rows = [[9.7, 2.2, 0.7, -5.2], [2.2, 2.9, 0.5, -0.3], [0.7, 0.5, 1.7, -0.6], [-5.2, -0.3, -0.6, 3.4]]
    delassus, free = np.array(rows).reshape(2, 2, 2, 2), np.array([[0.9, 7.5], [0.1, -0.6]])
    found = contact_forces(delassus, free, [Closed(0, 0.0, 5.0, None), Closed(-1, 5.0, 5.0, None)])
    assert not found.forces.any()
    assert found.accelerations == pytest.approx(free)
    assert found.several


def test_redundant_contacts_share_what_one_would_carry_and_have_one_motion():
    """Contacts at one place share their forces as they like: that is no other motion."""
    delassus = np.kron(np.ones((4, 4)), np.array([[2.0, 0.3], [0.3, 1.0]]))
    found = contact_forces(
        delassus.reshape(4, 2, 4, 2), np.array([[-1.0, 0.2]] * 4), [Closed(0, 0.0, 1.0, None)] * 4
    )
    assert not found.several
    assert found.accelerations == pytest.approx(np.zeros((4, 2)), abs=1e-12)
    alone = np.linalg.solve(delassus[:2, :2], [1.0, -0.2])
    assert found.forces.sum(axis=0) == pytest.approx(alone)

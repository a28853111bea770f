"""Impulses of several contacts over a step, against the laws that they solve and the problem without friction."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact.contact.complementarity import plastic_impulses
from oblique_impact.contact.impulses import ImpulseProblem, solve_impulses

CONTACTS = 5


def problem(seed: int, friction: float, coordinates: int = 12, guess: bool = False) -> ImpulseProblem:
    """Return a random problem, `coordinates` the number of columns of its rows."""
    random = np.random.default_rng(seed)
    found = ImpulseProblem.new(CONTACTS, friction > 0.0)
    rows = random.normal(size=(2 * CONTACTS, coordinates))
    if friction == 0.0:
        rows[1::2] = 0.0
    found.delassus[:], found.rates[:] = rows @ rows.T, rows @ random.normal(size=coordinates)
    found.friction[:] = friction
    if guess:
        found.states[:] = random.integers(-1, 3 if friction else 2, size=CONTACTS)
    return found


@pytest.mark.parametrize("guess", [False, True])
@pytest.mark.parametrize("coordinates", [12, 4])
@pytest.mark.parametrize("seed", range(30))
def test_impulses_and_velocities_obey_the_laws_of_contact_and_friction(seed, coordinates, guess):
    p = problem(seed, 0.4, coordinates, guess)
    assert solve_impulses(p, CONTACTS, True)
    normal, along = p.impulses[::2], p.impulses[1::2]
    after = p.rates + p.delassus @ p.impulses
    opening, slip = after[::2], after[1::2]
    small = 1e-7 * (1.0 + np.abs(p.impulses).max())
    assert normal.min() > -small
    assert opening.min() > -small
    assert np.abs(normal * opening).max() < small
    assert (np.abs(along) <= 0.4 * normal + small).all()
    slides = (np.abs(slip) > small) & (normal > small)
    assert along[slides] == pytest.approx(-0.4 * normal[slides] * np.sign(slip[slides]), abs=small)


@pytest.mark.parametrize("seed", range(30))
def test_without_friction_they_are_those_of_a_plastic_impact(seed):
    p = problem(seed, 0.0, guess=seed % 2 == 0)
    assert solve_impulses(p, CONTACTS, False)
    assert p.impulses[::2] == pytest.approx(plastic_impulses(p.delassus[::2, ::2], p.rates[::2]), abs=1e-9)
    assert (p.impulses[1::2] == 0.0).all()


def test_contacts_at_one_place_share_what_one_would_carry():
    p = problem(0, 0.3)
    p.delassus[:] = np.tile([[2.0, 0.1], [0.1, 1.0]], (CONTACTS, CONTACTS))
    p.rates[:] = np.tile([-1.0, 0.01], CONTACTS)
    assert solve_impulses(p, CONTACTS, True)
    assert p.rates[:2] + p.delassus[:2] @ p.impulses == pytest.approx([0.0, 0.0], abs=1e-12)

"""Friction laws: the branches against the law they cut into straight pieces."""

from math import inf

import numpy as np
import pytest

from oblique_impact.contact.friction import Coulomb, Frictionless, ModifiedCoulomb

MODIFIED = ModifiedCoulomb(kinetic=0.4, v0=1e-3, v1=1e-2)


def ratio(law, v, direction=1):
    branch = law.branch(v, direction)
    return branch.intercept + branch.slope * v


def modified_coulomb(v, mu, v0, v1):
    """The law as the theory page states it: -mu c_d(|v|) sign(v)."""
    return -mu * np.sign(v) * np.clip((abs(v) - v0) / (v1 - v0), 0.0, 1.0)


def test_coulomb_opposes_the_slip_and_knows_its_cone():
    law = Coulomb(static=0.5, kinetic=0.3)
    assert law.static == 0.5
    assert law.branch(2.0, -1) == (-0.3, 0.0, 0.0, inf)
    assert law.branch(-2.0, 1) == (0.3, 0.0, -inf, 0.0)
    for zero in (0.0, -0.0):
        assert law.branch(zero, 1) == (-0.3, 0.0, 0.0, inf)
        assert law.branch(zero, -1) == (0.3, 0.0, -inf, 0.0)


@pytest.mark.parametrize("v", [-3.0, -1e-2, -6e-3, -1e-3, -2e-4, 0.0, 2e-4, 1e-3, 3.1e-3, 1e-2, 0.02, 7.0])
@pytest.mark.parametrize("direction", [1, -1])
def test_modified_coulomb_is_the_stated_law(v, direction):
    assert ratio(MODIFIED, v, direction) == pytest.approx(modified_coulomb(v, 0.4, 1e-3, 1e-2), abs=1e-15)


@pytest.mark.parametrize("law", [Coulomb(0.5, 0.3), MODIFIED, ModifiedCoulomb(0.4, 0.0, 1e-2), Frictionless()])
def test_branches_tile_the_line(law):
    """From far below to far above, each branch begins where the last one ends."""
    branch = law.branch(-1e9, 1)
    assert branch.lower == -inf
    for _ in range(10):
        if branch.upper == inf:
            break
        kink = branch.upper
        following = law.branch(kink, 1)
        assert following.lower == kink == law.branch(kink, -1).upper
        branch = following
    assert branch.upper == inf
    for v in np.linspace(-0.03, 0.03, 1001):
        inside = law.branch(v, 1)
        assert inside.lower <= v <= inside.upper

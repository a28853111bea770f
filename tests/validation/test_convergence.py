"""Observed order, limit, grid convergence index and verdict, on sequences made for them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oblique_impact.validation.studies.convergence import (
    CONVERGED,
    CONVERGING,
    NO_VERDICT,
    NOT_CONFIRMED,
    NOT_CONVERGING,
    SAFETY,
    analyse,
    grid_convergence_index,
    observed_order,
    richardson_limit,
)

UNIFORM = np.array([0.4, 0.2, 0.1, 0.05, 0.025])
UNEVEN = np.array([0.4, 0.31, 0.14, 0.1, 0.03])
STEEP = np.array([0.8, 0.1, 0.08, 0.07])  # ln r32 > 2 ln r21: the plain fixed-point iteration runs away


def power(h, order, limit=2.0, factor=0.7):
    return limit + factor * h**order


@pytest.mark.parametrize("h", [UNIFORM, UNEVEN, STEEP], ids=["uniform", "uneven", "steep"])
@pytest.mark.parametrize("order", [-0.5, 0.5, 4.0, 7.5])
def test_power_laws_give_their_order_and_limit(h, order):
    """Differences that grow have a negative order."""
    f = power(h, order)
    found = observed_order(f[1] - f[0], f[2] - f[1], h[0] / h[1], h[1] / h[2])
    assert found == pytest.approx(order, rel=1e-9)
    if order > 0.0:
        assert richardson_limit(f[2], f[2] - f[1], h[1] / h[2], found) == pytest.approx(2.0, abs=1e-10)


def test_published_example_of_the_grid_convergence_index():
    """Celik et al. 2008, table 1: phi = 6.063, 5.972, 5.863; r21 = 1.5, r32 = 1.333; p = 1.53, GCI 2.2 %.

    N = 18000, 8000, 4500 cells in two dimensions; extrapolated 6.1685.
    """
    fine, middle, coarse, r21, r32 = 6.063, 5.972, 5.863, 1.5, 1.333
    p = observed_order(middle - coarse, fine - middle, r32, r21)
    assert p == pytest.approx(1.53, abs=0.01)
    assert richardson_limit(fine, fine - middle, r21, p) == pytest.approx(6.1685, abs=2e-3)
    assert grid_convergence_index(fine - middle, r21, p) / fine == pytest.approx(0.022, abs=5e-4)


@pytest.mark.parametrize("h", [UNIFORM, UNEVEN], ids=["uniform", "uneven"])
def test_a_power_law_converges_at_its_order(h):
    found = analyse(h, power(h, 4.0), tolerance=1e-12)
    assert (found.verdict, found.order) == ("converging", pytest.approx(4.0, abs=5e-3))
    assert found.order == pytest.approx(4.0, rel=1e-6)
    assert found.limit == pytest.approx(2.0, abs=1e-9)
    # the index bounds the true error by its safety factor
    assert found.uncertainty == pytest.approx(SAFETY * 0.7 * h[-1] ** 4, rel=1e-6)


def test_within_the_tolerance_relative_to_the_finest_value_or_a_scale_it_has_converged():
    found = analyse(UNIFORM, power(UNIFORM, 2.0), tolerance=1e-3)
    assert (found.verdict, found.order) == ("converged", pytest.approx(2.0, abs=5e-3))
    small = power(UNIFORM, 2.0, limit=0.0, factor=1e-6)
    assert analyse(UNIFORM, small, tolerance=1e-3).verdict == CONVERGING
    assert analyse(UNIFORM, small, tolerance=1e-3, scale=1.0).verdict == CONVERGED
    # from 161 to 1.625: the uncertainty 1.25 (1.875/3) is half of the finest value, 5e-3 of the first
    found = analyse(UNIFORM, power(UNIFORM, 2.0, limit=1.0, factor=1000.0), tolerance=0.1)
    assert found.uncertainty == pytest.approx(0.78125)
    assert found.verdict == CONVERGING


def test_three_levels_need_a_declared_order():
    h = UNIFORM[:3]
    f = power(h, 2.0)
    alone = analyse(h, f, tolerance=1e-6)
    assert alone.verdict == NOT_CONFIRMED
    assert "2.00" in alone.reason
    assert math.isnan(alone.limit)
    found = analyse(h, f, tolerance=1e-6, declared=2.0)
    assert (found.verdict, found.order) == ("converging", pytest.approx(2.0, abs=5e-3))
    assert analyse(h, f, tolerance=1e-6, declared=4.0).verdict == NOT_CONFIRMED


def test_shrinking_oscillation_is_judged_by_its_swing():
    f = 1.0 + 0.1 * (-0.5) ** np.arange(5)
    found = analyse(UNIFORM, f, tolerance=1e-3)
    assert found.verdict == NOT_CONFIRMED
    assert "alternate" in found.reason
    assert found.uncertainty == pytest.approx(SAFETY * abs(f[-2] - f[-3]))
    assert abs(f[-1] - 1.0) < found.uncertainty
    assert analyse(UNIFORM, f, tolerance=0.1).verdict == "converged"


@pytest.mark.parametrize(
    "values",
    [
        UNIFORM**-0.5,
        np.log(UNIFORM),
        [1.0, 1.1, 0.9, 1.2, 0.8],
        [0.0, 1.0, 0.0, 1.0, 0.0],
        [1.0, 1.0, 1.0, 1.0, 2.0],
        # within 2e-4 of one value, but each difference is twice the one before
        1.0 + 2e-5 * 2.0 ** np.arange(5),
        # impulses whose last difference happens to be smaller than the one before it
        [1.864, 1.854, 1.886, 1.890, 1.869],
    ],
    ids=["root", "logarithm", "growing swing", "steady swing", "late jump", "small", "scatter"],
)
def test_what_does_not_converge_is_called_that(values):
    found = analyse(UNIFORM, values)
    assert found.verdict == NOT_CONVERGING
    assert math.isnan(found.limit)


def test_stagnation_at_rounding_keeps_the_order_of_the_levels_above_it():
    rng = np.random.default_rng(1)
    h = 0.1 / 2.0 ** np.arange(9)
    f = 1.0 + h**6 + 2e-14 * rng.standard_normal(9)
    found = analyse(h, f, tolerance=1e-9)
    assert found.verdict == CONVERGED
    assert found.order == pytest.approx(6.0, abs=0.1)
    assert "until the noise is reached" in found.reason
    assert found.uncertainty >= found.noise


def test_differences_within_the_noise_tell_no_order():
    """A power law whose differences are all below what a tighter tolerance changes; and counts that are equal."""
    found = analyse(UNIFORM, power(UNIFORM, 2.0, factor=1e-6), tolerance=1e-3, noise=1e-5)
    assert found.verdict == "converged"
    assert math.isnan(found.order)
    assert found.uncertainty == 1e-5
    assert analyse(UNIFORM, power(UNIFORM, 2.0, factor=1e-6), tolerance=1e-6, noise=1e-5).verdict == NOT_CONFIRMED
    assert analyse(UNIFORM, [7.0, 5.0, 5.0, 5.0, 5.0]).verdict == "converged"


def test_gaps_are_named_and_do_not_stop_the_rest():
    nan = math.nan
    h = np.append(UNIFORM, 0.0125)
    f = power(h, 2.0)
    f[1] = nan
    found = analyse(h, f, tolerance=1e-9)
    assert found.order == pytest.approx(2.0)
    assert found.levels["difference"].isna().tolist() == [True, True, True, False, False, False]
    f[-1] = nan
    assert (analyse(h, f).verdict, analyse(h, f).reason) == (NO_VERDICT, "the finest level does not have it")
    f = power(h, 2.0)
    f[-3] = nan
    found = analyse(h, f)
    assert found.verdict == NO_VERDICT
    assert "three successive levels" in found.reason

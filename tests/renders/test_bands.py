"""Fast vibrations as bands: they contain all samples, and what is slow is the curve itself."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact.renders.bands import PERIOD, drawn


def swinging(period):
    """A curve with a period in pixels, and a slow course below it."""
    x = np.linspace(0.0, 400.0, 8000)
    return x, 5.0 * np.sin(2.0 * np.pi * x / period) + 0.02 * x


@pytest.mark.parametrize("period", [0.8, 2.0, 4.0, 5.5])
def test_the_band_contains_all_samples_and_the_line_is_their_mean(period):
    x, y = swinging(period)
    shown = drawn(x, y, 0.1)
    (band,) = shown.bands
    assert band.x[0] < 2.0 * PERIOD
    assert band.x[-1] > 400.0 - 2.0 * PERIOD
    inside = (x >= band.x[0]) & (x <= band.x[-1])
    assert np.all(np.interp(x[inside], band.x, band.low) <= y[inside])
    assert np.all(np.interp(x[inside], band.x, band.high) >= y[inside])
    # not much more than them either
    assert np.max(band.high - band.low) < 10.0 + 0.02 * 3.0 * PERIOD
    middle = (shown.x > 20.0) & (shown.x < 380.0)
    np.testing.assert_allclose(shown.y[middle], 0.02 * shown.x[middle], atol=0.5)


@pytest.mark.parametrize("period", [7.0, 300.0])
def test_a_slow_curve_is_the_curve(period):
    x, y = swinging(period)
    shown = drawn(x, y, 0.1)
    assert shown.bands == []
    np.testing.assert_array_equal([shown.x, shown.y], [x, y])


def test_rounding_and_jumps_are_no_vibration():
    noise = 1e-9 * np.random.default_rng(1).standard_normal(4000)
    x = np.sort(np.concatenate([np.linspace(0.0, 300.0, 3998), [150.0, 150.0]]))
    steps = np.floor(x / 100.0)
    assert drawn(x, steps + noise, 0.01).bands == []
    assert drawn(x[:1], steps[:1], 0.01).y.size == 1

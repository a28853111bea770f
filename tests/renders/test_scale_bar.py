"""Scale bars: of a round length with its unit, not longer than there is room."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact.renders.scale_bar import ScaleBar, scale_bar

LENGTHS = {"m": 1.0, "mm": 1e-3, "µm": 1e-6}


def test_lengths_are_round_and_have_their_unit():
    for metre in np.geomspace(1e-2, 1e7, 40):
        bar = scale_bar(np.array([metre, -0.1 * metre]), 120.0)
        number, unit = bar.text.split()
        assert float(number) * LENGTHS[unit] == pytest.approx(bar.length, rel=1e-12)
        mantissa = bar.length / 10.0 ** np.floor(np.log10(bar.length) + 1e-9)
        assert round(mantissa, 9) in (1.0, 2.0, 5.0)
        assert 0.4 * 120.0 <= np.linalg.norm(bar.across) <= 120.0 * (1.0 + 1e-9)
    names = [(2.0, "2 m"), (0.1, "0.1 m"), (0.05, "50 mm"), (1e-3, "1 mm"), (2e-4, "200 µm")]
    assert [ScaleBar(length, np.zeros(2)).text for length, _ in names] == [text for _, text in names]

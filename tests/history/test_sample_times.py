"""Times of samples: each names one sample; both sides of a jump stay next to each other."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from oblique_impact.history.sample_times import ascending, first_sample, last_sample

GIVEN = np.array([0.0, 0.0, 0.1, 0.2, 0.2, 0.2, 0.3])


def test_samples_at_an_instant():
    times = ascending(GIVEN)
    assert last_sample(times, [0.0, 0.1, 0.2, 0.25, 0.3, 9.0, -1.0]).tolist() == [1, 2, 5, 5, 6, 6, -1]
    assert first_sample(times, [0.0, 0.1, 0.2, 0.3]).tolist() == [0, 2, 3, 6]
    assert int(last_sample(times, 0.2)) == 5


@given(st.lists(st.integers(0, 5), min_size=1, max_size=30), st.floats(0.0, 1e3))
def test_any_times_in_order_become_unique(numbers, start):
    times = start + 0.1 * np.sort(np.array(numbers, dtype=float))
    found = ascending(times)
    assert np.all(np.diff(found) > 0.0)
    np.testing.assert_allclose(found, times, rtol=1e-14, atol=1e-300)
    for time in np.unique(times):
        same = np.flatnonzero(times == time)
        assert (int(first_sample(found, time)), int(last_sample(found, time))) == (same[0], same[-1])

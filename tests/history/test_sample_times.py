"""Times of samples: each names one sample; both sides of a jump stay next to each other."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from oblique_impact.history.sample_times import ascending, first_sample, jumps, last_sample, pieces

GIVEN = np.array([0.0, 0.0, 0.1, 0.2, 0.2, 0.2, 0.3])
LEFT = np.array([True, False, False, True, True, False])


def after(time, count=1):
    for _ in range(count):
        time = np.nextafter(time, np.inf)
    return time


def test_equal_times_become_neighbours():
    found = ascending(GIVEN)
    assert found.tolist() == [0.0, after(0.0), 0.1, 0.2, after(0.2), after(0.2, 2), 0.3]
    assert GIVEN[1] == 0.0  # the times that were given are left alone
    np.testing.assert_array_equal(jumps(found), LEFT)
    assert [piece.tolist() for piece in pieces(found)] == [[0], [1, 2, 3], [4], [5, 6]]


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

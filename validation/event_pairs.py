"""Event logs side by side: which events are the same, and how far apart these are."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from oblique_impact.marching.records import Event


@dataclass(frozen=True)
class EventPair:
    """One event of either history, or of one of them only; differences are right minus left, None without both."""

    left: Event | None
    right: Event | None

    @property
    def time_difference(self) -> float | None:
        """Of the times (s)."""
        return self._difference(lambda event: event.time)

    @property
    def impulse_difference(self) -> float | None:
        """Of the normal impulses (N s)."""
        return self._difference(lambda event: event.normal_impulse)

    def _difference(self, value: Callable[[Event], float]) -> float | None:
        return value(self.right) - value(self.left) if self.left and self.right else None

    @property
    def event(self) -> Event:
        """The one of the left history, or if it has none of the right one."""
        found = self.left or self.right
        assert found is not None
        return found

    @property
    def kind(self) -> str:
        """What happens."""
        return f"{self.event.kind.value} -> {self.event.state.name.lower()}"

    def cells(self) -> list[str]:
        """Return both times, their difference and both impulses as text."""
        difference = self.time_difference
        return [
            *("-" if event is None else f"{event.time:.9f}" for event in (self.left, self.right)),
            "" if difference is None else f"{difference:+.1e}",
            *(_impulse(event) for event in (self.left, self.right)),
        ]


def _impulse(event: Event | None) -> str:
    if event is None:
        return "-"
    return f"{event.normal_impulse:.8f}" if event.normal_impulse else ""


def pair_events(left: Sequence[Event], right: Sequence[Event], max_shift: float = np.inf) -> list[EventPair]:
    """Align two event logs: the longest common sequence of kinds and states that is closest in time.

    Events further apart than `max_shift` (s) are not a pair.
    """
    times = [[event.time for event in events] for events in (left, right)]
    kinds = [[(event.kind, event.state) for event in events] for events in (left, right)]
    places = align(times[0], times[1], kinds[0], kinds[1], max_shift)
    return [EventPair(None if i is None else left[i], None if j is None else right[j]) for i, j in places]


def largest_difference(pairs: Sequence[EventPair]) -> float:
    """Largest difference of paired event times (s); infinity if an event has no partner."""
    differences = [pair.time_difference for pair in pairs]
    return max((float("inf") if d is None else abs(d) for d in differences), default=0.0)


def align(
    left: Sequence[float],
    right: Sequence[float],
    left_kinds: Sequence[Hashable],
    right_kinds: Sequence[Hashable],
    max_shift: float = np.inf,
) -> list[tuple[int | None, int | None]]:
    """Pair two sequences of instants in order: as many pairs as possible, and of these the closest in time.

    Parameters
    ----------
    left, right : sequence of float
        Times (s), ascending.
    left_kinds, right_kinds : sequence
        Only instants of one kind make a pair.
    max_shift : float
        Instants further apart (s) are not a pair.

    Returns
    -------
    list of tuple
        Indices (left, right) in the order of time, None where one has no partner: the longest common subsequence
        with the smallest sum of time differences.
    """
    same = np.array([[a == b for b in right_kinds] for a in left_kinds], dtype=bool).reshape(len(left), len(right))
    apart = np.abs(np.subtract.outer(np.asarray(left, dtype=float), np.asarray(right, dtype=float)))
    largest = float(np.max(apart, initial=0.0)) or 1.0
    # all time differences together count less than one pair
    gain = 1.0 - apart / largest / (2.0 * max(1, min(apart.shape)))
    gain[~same | (apart > max_shift)] = -np.inf
    score = np.zeros((len(left) + 1, len(right) + 1))
    for i in range(len(left)):
        score[i + 1, 1:] = np.maximum.accumulate(np.maximum(score[i, 1:], score[i, :-1] + gain[i]))
    places: list[tuple[int | None, int | None]] = []
    i, j = apart.shape
    while i or j:  # read the pairs off the table, last to first; of two without a partner the later one first
        skip_left = i > 0 and score[i, j] == score[i - 1, j]
        skip_right = j > 0 and score[i, j] == score[i, j - 1]
        if skip_left and not (skip_right and right[j - 1] > left[i - 1]):
            i -= 1
            places.append((i, None))
        elif skip_right:
            j -= 1
            places.append((None, j))
        else:
            i, j = i - 1, j - 1
            places.append((i, j))
    return places[::-1]

"""Event logs side by side: which events are the same, and how far apart these are."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import numpy as np
import pandas as pd

from oblique_impact.history.events import Event


def pair_events(left: Sequence[Event], right: Sequence[Event], max_shift: float = np.inf) -> pd.DataFrame:
    """Align two event logs: the longest common sequence of kinds and states that is closest in time.

    Parameters
    ----------
    left, right : sequence of Event
        In the order of time.
    max_shift : float
        Events further apart (s) are not a pair.

    Returns
    -------
    DataFrame
        A row for each event, in the order of time: kind, state after it, times (s) and normal impulses (N s) of
        both, and their differences, right minus left; NaN without a partner.
    """
    times = [[event.time for event in events] for events in (left, right)]
    kinds = [[(event.kind, event.state) for event in events] for events in (left, right)]
    rows = []
    for i, j in align(times[0], times[1], kinds[0], kinds[1], max_shift):
        one, other = None if i is None else left[i], None if j is None else right[j]
        event = one or other
        assert event is not None
        row: dict[str, object] = {"kind": event.kind.value, "state": event.state.name.lower()}
        for side, found in (("left", one), ("right", other)):
            row |= {f"{side}_time": found.time, f"{side}_impulse": found.normal_impulse} if found else {}
        rows.append(row)
    numbers = ["left_time", "left_impulse", "right_time", "right_impulse"]
    pairs = pd.DataFrame(rows, columns=["kind", "state", *numbers]).astype(dict.fromkeys(numbers, float))
    for name in ("time", "impulse"):
        pairs[f"{name}_difference"] = pairs[f"right_{name}"] - pairs[f"left_{name}"]
    return pairs


def largest_difference(pairs: pd.DataFrame) -> float:
    """Return the largest difference of paired event times (s); infinity if an event has no partner."""
    return float(pairs["time_difference"].abs().fillna(np.inf).max()) if len(pairs) else 0.0


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

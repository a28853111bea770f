"""Two histories side by side: which events they share and how far apart these are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oblique_impact.history.history import History
from oblique_impact.marching.records import Event
from validation.alignment import align

Array = NDArray[np.float64]

#: digits of the distance of two graphs
GRAPH_DIGITS = 1e-4


@dataclass(frozen=True)
class EventPair:
    """One event of either history, or of one of them only."""

    left: Event | None
    right: Event | None

    @property
    def time_difference(self) -> float | None:
        """Right minus left (s); None for an event that only one history has."""
        return self._difference(lambda event: event.time)

    @property
    def impulse_difference(self) -> float | None:
        """Normal impulse, right minus left (N s)."""
        return self._difference(lambda event: event.normal_impulse)

    @property
    def normal_velocity_difference(self) -> float | None:
        """Gap rate just before the event, right minus left (m/s)."""
        return self._difference(lambda event: event.normal_velocity)

    @property
    def tangential_velocity_difference(self) -> float | None:
        """Slip velocity just after the event, right minus left (m/s)."""
        return self._difference(lambda event: event.tangential_velocity)

    def _difference(self, value: Callable[[Event], float]) -> float | None:
        return value(self.right) - value(self.left) if self.left and self.right else None


def compare_events(left: History, right: History, max_shift: float = np.inf) -> list[EventPair]:
    """Align the event logs of two histories; see `pair_events`."""
    return pair_events(left.events, right.events, max_shift)


def pair_events(left: Sequence[Event], right: Sequence[Event], max_shift: float = np.inf) -> list[EventPair]:
    """Align two event logs: the longest common sequence of kinds and states that is closest in time.

    Events further apart than `max_shift` (s) are not a pair.
    """
    times = [[event.time for event in events] for events in (left, right)]
    kinds = [[(event.kind, event.state) for event in events] for events in (left, right)]
    places = align(times[0], times[1], kinds[0], kinds[1], max_shift)
    return [EventPair(None if i is None else left[i], None if j is None else right[j]) for i, j in places]


def largest_difference(pairs: list[EventPair]) -> float:
    """Largest difference of paired event times (s); infinity if an event has no partner."""
    differences = [pair.time_difference for pair in pairs]
    return max((float("inf") if d is None else abs(d) for d in differences), default=0.0)


def markdown_table(pairs: list[EventPair], left_name: str, right_name: str) -> str:
    """Event table as Markdown."""
    header = (
        f"| # | event | {left_name} t (s) | {right_name} t (s) | difference (s) | "
        f"{left_name} impulse (N s) | {right_name} impulse (N s) |"
    )
    lines = [header, "| --: | --- | --: | --: | --: | --: | --: |"]
    lines += [f"| {' | '.join(row)} |" for row in table_rows(pairs)]
    return "\n".join(lines) + "\n"


def table_rows(pairs: list[EventPair]) -> list[list[str]]:
    """Cells of the event table."""
    return [_row(number, pair) for number, pair in enumerate(pairs, start=1)]


def _row(number: int, pair: EventPair) -> list[str]:
    shown = pair.left or pair.right
    assert shown is not None
    difference = pair.time_difference
    return [
        str(number),
        f"{shown.kind.value} -> {shown.state.name.lower()}",
        _cell(pair.left, lambda e: f"{e.time:.9f}"),
        _cell(pair.right, lambda e: f"{e.time:.9f}"),
        "" if difference is None else f"{difference:+.1e}",
        _cell(pair.left, _impulse),
        _cell(pair.right, _impulse),
    ]


def _impulse(event: Event) -> str:
    return f"{event.normal_impulse:.8f}" if event.normal_impulse else ""


def _cell(event: Event | None, text: Callable[[Event], str]) -> str:
    return "-" if event is None else text(event)


def contact_times(history: History) -> Array:
    """Start and end (s) of every contact; a rebound is a contact of no length.

    Whether a last, grazing contact is a rebound or lasts a microsecond depends on the mesh; its times
    converge all the same.
    """
    times: list[float] = []
    opened = 0.0
    for event in history.events:
        kind = event.kind.value
        if kind == "impact":
            opened = event.time
        elif kind == "release":
            times += [opened, event.time]
        elif kind == "rebound":
            times += [event.time, event.time]
    return np.array(times)


def hausdorff_distance(a: Array, b: Array) -> float:
    """Hausdorff distance of two polylines, (points, 2) each: the right distance for curves with jumps.

    Two curves that jump at slightly different times are close as sets though not at any one time.  Distances
    are taken from the vertices of each to the segments of the other.
    """
    return max(_directed(a, b), _directed(b, a))


def _directed(points: Array, line: Array, block: int = 256) -> float:
    """Largest distance of `points` from the segments of `line`."""
    start, along = line[:-1], np.diff(line, axis=0)
    square = np.maximum(np.einsum("ij,ij->i", along, along), np.finfo(float).tiny)
    largest = 0.0
    for k in range(0, len(points), block):
        offset = points[k : k + block, None] - start[None]
        part = np.clip(np.einsum("pij,ij->pi", offset, along) / square, 0.0, 1.0)
        gap = offset - part[..., None] * along
        largest = max(largest, float(np.sqrt(np.einsum("pij,pij->pi", gap, gap).min(axis=1).max())))
    return largest


def graph_distance(a: Array, b: Array) -> float:
    """Hausdorff distance of two graphs, (points, 2) each with abscissas that do not descend.

    The same as `hausdorff_distance` but for `GRAPH_DIGITS` of itself, and much sooner: the distance along the
    ordinate, and those of other points, bound how far a point can be, so that few are searched, each near to it.
    """
    return max(_directed_graph(a, b), _directed_graph(b, a))


def _directed_graph(points: Array, line: Array) -> float:
    x = line[:, 0]
    bound = _distance_at(points, line)
    largest = 0.0
    while True:
        k = int(np.argmax(bound))
        if bound[k] <= largest * (1.0 + GRAPH_DIGITS):
            return largest
        start = max(int(np.searchsorted(x, points[k, 0] - bound[k], side="left")) - 1, 0)
        stop = int(np.searchsorted(x, points[k, 0] + bound[k], side="right")) + 1
        start = min(start, len(line) - 2)
        found = min(float(bound[k]), _directed(points[k : k + 1], line[start : max(stop, start + 2)]))
        largest = max(largest, found)
        # no point is further from the line than this one and the way to it together
        bound = np.minimum(bound, found + np.hypot(*(points - points[k]).T))


def _distance_at(points: Array, line: Array) -> Array:
    """Distance of each point from the line at its own abscissa, or from the end of the line next to it."""
    x, y = line[:, 0], line[:, 1]
    at = np.clip(points[:, 0], x[0], x[-1])
    last = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(line) - 2)
    width = x[last + 1] - x[last]
    part = np.divide(at - x[last], width, out=np.zeros(len(at)), where=width > 0.0)
    return np.asarray(np.hypot(points[:, 0] - at, points[:, 1] - (y[last] + part * (y[last + 1] - y[last]))))

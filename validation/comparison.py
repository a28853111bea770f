"""Two histories side by side: which events they share and how far apart these are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from difflib import SequenceMatcher

import numpy as np
from numpy.typing import NDArray

from oblique_impact.history import History
from oblique_impact.marching import Event

Array = NDArray[np.float64]


@dataclass(frozen=True)
class EventPair:
    """One event of either history, or of one of them only."""

    left: Event | None
    right: Event | None

    @property
    def time_difference(self) -> float | None:
        """Right minus left (s); None for an event that only one history has."""
        return self.right.time - self.left.time if self.left and self.right else None


def compare_events(left: History, right: History) -> list[EventPair]:
    """Align two event logs by the longest common sequence of kinds and states."""
    a, b = left.events, right.events
    kinds_a, kinds_b = ([f"{e.kind.value} {e.state.name}" for e in events] for events in (a, b))
    pairs: list[EventPair] = []
    for tag, i1, i2, j1, j2 in SequenceMatcher(None, kinds_a, kinds_b, autojunk=False).get_opcodes():
        if tag == "equal":
            pairs += [EventPair(x, y) for x, y in zip(a[i1:i2], b[j1:j2], strict=True)]
        else:
            pairs += [EventPair(x, None) for x in a[i1:i2]] + [EventPair(None, y) for y in b[j1:j2]]
    return pairs


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

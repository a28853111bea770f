"""What shadow runs say: by how much the times of a run grow apart, and the verdict on each macro-collision.

By how much a time t of a run differs from that of a shadow, whose initial angle is another by d, is its growth:

    growth = max |t(theta_0 + d) - t(theta_0)| / (|d| T),   T the time of the first touch-down

A macro-collision whose start has a growth of at most 10 is predictable; from 1000 on it is not: rounding moves it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import Outcome
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.measuring import FAILURES, Row

Array = NDArray[np.float64]

PREDICTABLE, SENSITIVE, UNPREDICTABLE, UNKNOWN = "predictable", "sensitive", "not predictable", "no verdict"
#: growths that part the verdicts
SMALL, LARGE = 10.0, 1e3
#: whose times are followed
MOST_COLLISIONS, MOST_EVENTS = 20, 400


@dataclass(frozen=True)
class Case:
    """A scenario whose predictability is asked for, with a name and words for the report."""

    name: str
    scenario: Scenario
    text: str = ""


@dataclass(frozen=True)
class Collision:
    """What the shadows say of one macro-collision.

    Attributes
    ----------
    number : int
        From 1.
    start, impulse : float
        Of the unperturbed run (s, N s).
    contacts : tuple of int
        The fewest and the most among the runs.
    spread : tuple of float
        Largest difference of the start (s), by perturbation.
    impulse_spread : tuple of float
        Largest difference of the impulse (N s), by perturbation.
    growth : float
        Of the start; infinite if the physics stopped a shadow before it, NaN without shadows.
    lower_bound : bool
        Whether `growth` is no more than a lower bound, as a shadow came to its end before this macro-collision.
    verdict : str
        "predictable", "sensitive", "not predictable" or "no verdict".
    """

    number: int
    start: float
    impulse: float
    contacts: tuple[int, int]
    spread: tuple[float, ...]
    impulse_spread: tuple[float, ...]
    growth: float
    lower_bound: bool
    verdict: str


@dataclass(frozen=True)
class CaseResult:
    """Shadows of one case.

    Attributes
    ----------
    offsets : ndarray, shape (shadows,)
        Of the initial angle (rad).
    amplitudes : ndarray, shape (shadows,)
        Perturbation (rad) to which each shadow belongs: the smallest that its offset does not exceed.
    events : ndarray, shape (events,)
        Times of the unperturbed run (s).
    shadows : ndarray, shape (shadows, events)
        The same of the shadows; NaN where one has fewer.
    growth : ndarray, shape (events,)
        Of each event's time, bounds and infinities as for a `Collision`.
    unit_time : float
        T (s).
    rows : tuple of Row
        Of the unperturbed run and the shadows.
    failed : tuple of (float, Row)
        Offsets and rows of the shadows that failed; nothing else here knows of them.
    """

    case: Case
    perturbations: tuple[float, ...]
    offsets: Array
    amplitudes: Array
    events: Array
    shadows: Array
    growth: Array
    collisions: tuple[Collision, ...]
    unit_time: float
    rows: tuple[Row, ...]
    failed: tuple[tuple[float, Row], ...]

    @property
    def horizon(self) -> float:
        """Time (s) of the last event before the first one that is not predictable; infinite if all are."""
        if not self.offsets.size:
            return math.nan
        lost = np.flatnonzero(self.growth >= LARGE)
        if not lost.size:
            return math.inf
        return float(self.events[lost[0] - 1]) if lost[0] else 0.0

    @property
    def remarks(self) -> list[str]:
        """Say why there are no collisions, which shadows are left out, and what the run warns of."""
        row, said = self.rows[0], []
        if row["outcome"] in FAILURES:
            said.append(f"the unperturbed run failed: {row['outcome']}: {row['message']}")
        elif not self.collisions:
            words = ": ".join(filter(None, (row["outcome"], row["message"])))
            said.append(f"no contact until {row['stopped_at']:.6g} s: {words}")
        said += [
            f"shadow at {offset:g} rad left out: {row['outcome']}: {row['message']}" for offset, row in self.failed
        ]
        return said + [f"warning: {warning}" for warning in self.rows[0]["warnings"]]


@dataclass(frozen=True)
class Predictability:
    """A predictability study; `report` is its page, if one was written."""

    name: str
    cases: tuple[CaseResult, ...]
    seconds: float
    report: Path | None = None


def judge(case: Case, perturbations: tuple[float, ...], offsets: Array, rows: Sequence[Row]) -> CaseResult:
    """Judge a case by its rows, that of the unperturbed run first."""
    pairs = list(zip(offsets.tolist(), rows[1:], strict=True))
    failed = tuple(pair for pair in pairs if pair[1]["outcome"] in FAILURES)
    pairs = [pair for pair in pairs if pair[1]["outcome"] not in FAILURES]
    offsets, rows = np.array([offset for offset, _ in pairs]), (rows[0], *(row for _, row in pairs))
    amplitudes = np.array([min(d for d in perturbations if abs(offset) <= d * (1.0 + 1e-9)) for offset in offsets])
    events = _columns(rows, "event", MOST_EVENTS)
    events = events[:, np.isfinite(events[0])]
    unit = float(events[0, 0]) if events.size and events[0, 0] > 0.0 else case.scenario.end_time
    scale = np.abs(offsets)[:, None] * unit
    collisions = _collisions(rows, scale, [amplitudes == d for d in perturbations])
    growth = _largest(_shifts(rows, events) / scale)
    return CaseResult(
        *(case, perturbations, offsets, amplitudes, events[0], events[1:], growth, collisions, unit, rows, failed)
    )


def _collisions(rows: Sequence[Row], scale: Array, groups: Sequence[NDArray[np.bool_]]) -> tuple[Collision, ...]:
    """Judge the macro-collisions: a shift by `scale` (shadows, 1) is a growth of 1; a spread for each group."""
    starts = _columns(rows, "start", MOST_COLLISIONS)
    starts = starts[:, np.isfinite(starts[0])]
    count = starts.shape[1]
    impulses, contacts = (_columns(rows, f"collision_{kind}", count) for kind in ("impulse", "contacts"))
    shifts, changes = _shifts(rows, starts), np.abs(impulses[1:] - impulses[0])
    growth = _largest(shifts / scale)
    bounded = np.isnan(starts[1:]).any(axis=0) & np.isfinite(growth)
    found = []
    for n in range(count):
        known = contacts[np.isfinite(contacts[:, n]), n]
        found.append(
            Collision(
                n + 1,
                float(starts[0, n]),
                float(impulses[0, n]),
                (int(known.min()), int(known.max())) if known.size else (0, 0),
                tuple(float(_largest(shifts[group, n])) for group in groups),
                tuple(float(_largest(changes[group, n])) for group in groups),
                float(growth[n]),
                bool(bounded[n]),
                verdict_of(float(growth[n]), bool(bounded[n])),
            )
        )
    return tuple(found)


def _columns(rows: Sequence[Row], kind: str, most: int) -> Array:
    """Return the quantities "kind:1" to "kind:most", (runs, most); NaN where a run has fewer."""
    return np.array([[row["values"].get(f"{kind}:{n}", math.nan) for n in range(1, most + 1)] for row in rows])


def _shifts(rows: Sequence[Row], times: Array) -> Array:
    """Return how far each shadow moves the times of the first run, (shadows, n) from (runs, n).

    One that came to its end without such a time would have had it later, which is a lower bound.  One that the
    physics stopped will never have it.
    """
    ends = [row["stopped_at"] if row["outcome"] == Outcome.COMPLETED.label else math.inf for row in rows[1:]]
    least = np.array(ends)[:, None] - times[0]
    return np.asarray(np.where(np.isnan(times[1:]), least, np.abs(times[1:] - times[0])))


def _largest(values: Array) -> Array:
    """Return the largest of all shadows, NaN where there are none."""
    return np.asarray(np.max(values, axis=0) if len(values) else np.full(values.shape[1:], math.nan))


def verdict_of(growth: float, lower_bound: bool = False) -> str:
    """Return the verdict on a growth; from a lower bound only that something is not predictable."""
    if growth >= LARGE:
        return UNPREDICTABLE
    if lower_bound or math.isnan(growth):
        return UNKNOWN
    return PREDICTABLE if growth <= SMALL else SENSITIVE

"""Two histories compared: their events, everything they sampled, their collisions."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import InputError
from oblique_impact.history.history import History, require_history
from oblique_impact.history.sample_times import jumps
from validation.alignment import SAME, Clock, Sampling, align, clock, deviation
from validation.comparison import EventPair, graph_distance, pair_events
from validation.contrast import Comparison, Measure, VariableDifference

Array = NDArray[np.float64]

#: events further apart than this part of the common span are not the same event
MAX_SHIFT = 0.1
#: a jump is a change by more than this part of the scale between two samples next to each other
JUMP = 1e-6
_COORDINATES = ("q", "qd")
_COLLISION = {
    "start": "s",
    "end": "s",
    "contacts": "1",
    "normal_impulse": "N s",
    "tangential_impulse": "N s",
    "peak_force": "N",
}
_ENERGIES = ("final", "lost_impact", "lost_friction", "lost_damping", "lost_scheme")


def compare(
    left: History,
    right: History,
    variables: Sequence[str] | None = None,
    *,
    names: tuple[str, str] = ("left", "right"),
    max_shift: float | None = None,
) -> Comparison:
    """Compare two histories, with their events aligned.

    They may have other output intervals, other discretizations (the beam's variables are taken at common stations)
    and other end times: what both cover is compared.  Differences are taken at equal times, and besides them on a
    clock in which shared events coincide, so that an impact a little later does not hide everything else.  Both
    are exact for courses that are linear between their samples.

    Parameters
    ----------
    left, right : History
        Of beams or of user-defined systems.
    variables : sequence of str, optional
        Names of the variables to compare; default: all that both have.
    names : tuple of str
        What the two are called, in tables.
    max_shift : float, optional
        Events of one kind that are further apart (s) are not the same event; default: a tenth of the common span.

    Returns
    -------
    Comparison
        ``print`` it, or see its `table`, `events`, `variables` and `measures`.

    Raises
    ------
    InputError
        In one line, if the histories have no time in common, or a variable is unknown or not comparable.

    Examples
    --------
    >>> from oblique_impact import Scenario, simulate
    >>> from validation import compare
    >>> paper = Scenario.builtin("paper").replace(end_time=0.33)
    >>> found = compare(simulate(paper), simulate(paper.replace(discretization__method="fem")))
    >>> len(found.only_left), found.largest_shift < 1e-6, found["theta"].aligned.rms < 1e-6
    (0, True, True)
    """
    for history in (left, right):
        require_history(history, "compare")
    span = _common_span(left, right)
    length = span[1] - span[0]
    limit = MAX_SHIFT * length if max_shift is None else float(max_shift)
    if not limit >= 0.0:
        raise InputError(f"max_shift = {limit}: should be a time in s, 0 or more")
    pairs = pair_events(_inside(left, span), _inside(right, span), limit)
    wanted, skipped = _chosen(left, right, variables)
    grids = _Grids(left, right, span, _clock(left, right, pairs, length))
    return Comparison(
        names,
        (left.outcome.label, right.outcome.label),
        span,
        limit,
        tuple(pairs),
        {name: grids.difference(name) for name in wanted},
        tuple(_measures(left, right, span, limit)),
        grids.disagreement(),
        skipped,
    )


class _Grids:
    """Both histories sampled on the union of their instants, at equal and at corresponding times."""

    def __init__(self, left: History, right: History, span: tuple[float, float], clock: Clock) -> None:
        self._both, self._span = (left, right), span
        self._times = _times(left), _times(right)
        self._plain = _sampled(*self._times, span)
        a, b = clock.of_left(self._times[0]), clock.of_right(self._times[1])
        self._aligned = _sampled(a, b, (max(a[0], b[0]), min(a[-1], b[-1])))

    def difference(self, name: str) -> VariableDifference:
        """Measure one variable."""
        values, weights = self._values(name)
        scale = self._scale(values)
        plain, aligned = (
            deviation(grid, samplings[0](values[0]), samplings[1](values[1]), weights)
            for grid, samplings in (self._plain, self._aligned)
        )
        unit = str(self._both[0][name].attrs.get("units", "1"))
        return VariableDifference(name, unit, scale, plain, aligned, self._hausdorff(values, scale))

    def disagreement(self) -> float:
        """Part of the aligned time in which the contact states differ."""
        grid, samplings = self._aligned
        if grid.size < 2:
            return 0.0
        # the state of a phase is that of the sample in which it begins
        states = [s(h["state"].values.astype(float))[0] for s, h in zip(samplings, self._both, strict=True)]
        return float(np.diff(grid) @ (states[0] != states[1]) / (grid[-1] - grid[0]))

    def _values(self, name: str) -> tuple[list[Array], Array | None]:
        """Values of both on common stations, and the weights of these in a mean along the beam."""
        values = [np.asarray(history[name].values, dtype=float) for history in self._both]
        if "station" not in self._both[0][name].dims:
            return values, None
        stations = [np.asarray(history["station"].values, dtype=float) for history in self._both]
        common = np.union1d(*stations)
        common = common[(common >= max(s[0] for s in stations)) & (common <= min(s[-1] for s in stations))]
        # points closer than rounding are one
        common = common[np.concatenate([[True], np.diff(common) > SAME * (common[-1] or 1.0)])]
        widths = np.concatenate([[0.0], np.diff(common), [0.0]])
        weights = 0.5 * (widths[1:] + widths[:-1])
        return [_along(s, v, common) for s, v in zip(stations, values, strict=True)], weights / weights.sum()

    def _scale(self, values: Sequence[Array]) -> float:
        inside = [v[(t >= self._span[0]) & (t <= self._span[1])] for t, v in zip(self._times, values, strict=True)]
        finite = np.concatenate([v[np.isfinite(v)] for v in inside])
        if not finite.size:
            return 0.0
        return float(np.ptp(finite)) or float(np.max(np.abs(finite)))

    def _hausdorff(self, values: Sequence[Array], scale: float) -> float | None:
        if values[0].ndim > 1 or scale == 0.0 or not all(np.isfinite(v).all() for v in values):
            return None
        if not any(_jumps(t, v, scale) for t, v in zip(self._times, values, strict=True)):
            return None
        grid, samplings = self._plain
        return graph_distance(*(_graph(grid, s(v), scale) for s, v in zip(samplings, values, strict=True)))


def _sampled(left: Array, right: Array, span: tuple[float, float]) -> tuple[Array, tuple[Sampling, Sampling]]:
    """Return the instants of both courses inside of `span`, and how to sample either there."""
    start, end = span
    times = np.union1d(left, right)
    grid = np.unique(np.concatenate([[start], times[(times > start) & (times < end)], [end]]))
    return grid, (Sampling(left, grid), Sampling(right, grid))


def _graph(grid: Array, limits: tuple[Array, Array], scale: float) -> Array:
    """Return the graph (points, 2) with its jumps, relative to span and scale."""
    time = (np.repeat(grid, 2)[1:-1] - grid[0]) / (grid[-1] - grid[0])
    return np.stack([time, np.stack(limits, axis=1).ravel() / scale], axis=1)


def _jumps(times: Array, values: Array, scale: float) -> bool:
    return bool(np.any(jumps(times) & (np.abs(np.diff(values)) > JUMP * scale)))


def _along(stations: Array, values: Array, at: Array) -> Array:
    """Interpolate values (samples, stations) along the beam."""
    if stations.size == at.size and np.array_equal(stations, at):
        return values
    k = np.clip(np.searchsorted(stations, at, side="right") - 1, 0, stations.size - 2)
    part = (at - stations[k]) / (stations[k + 1] - stations[k])
    with np.errstate(invalid="ignore"):
        return np.asarray(values[:, k] + part * (values[:, k + 1] - values[:, k]))


def _times(history: History) -> Array:
    return np.asarray(history["time"].values, dtype=float)


def _common_span(left: History, right: History) -> tuple[float, float]:
    times = _times(left), _times(right)
    start, end = max(float(t[0]) for t in times), min(float(t[-1]) for t in times)
    if min(t.size for t in times) < 2 or not start < end:
        covered = " and ".join(f"{t[0]:g} to {t[-1]:g} s" for t in times)
        raise InputError(f"compare: the histories have no time in common: {covered}")
    return start, end


def _inside(history: History, span: tuple[float, float]) -> list[Any]:
    return [event for event in history.events if span[0] <= event.time <= span[1]]


def _clock(left: History, right: History, pairs: Sequence[EventPair], length: float) -> Clock:
    """Let shared events coincide, and the beginnings if they are the same."""
    begins = float(left["time"].values[0]), float(right["time"].values[0])
    shared = [(pair.left.time, pair.right.time) for pair in pairs if pair.left and pair.right]
    together = abs(begins[1] - begins[0]) <= SAME * length
    return clock([begins, *shared] if together else shared, length)


def _chosen(left: History, right: History, wanted: Sequence[str] | None) -> tuple[list[str], dict[str, str]]:
    """Names of the variables to compare, and why others are not; what is asked for has to be possible."""
    every = dict.fromkeys([*map(str, left.data.data_vars), *map(str, right.data.data_vars)])
    why = {name: _obstacle(left, right, name) for name in every}
    for name in wanted or ():
        if name not in every:
            raise InputError(f"variables: {name!r}: should be among {', '.join(every)}")
        if why[name]:
            raise InputError(f"variables: {name!r}: {why[name]}")
    names = [name for name in (every if wanted is None else wanted) if not why[name]]
    return names, {name: reason for name, reason in why.items() if reason}


def _obstacle(left: History, right: History, name: str) -> str:
    """Why a variable cannot be compared, "" if it can."""
    if name == "state":
        return "contact states are compared as state_disagreement"
    for history, side in ((left, "left"), (right, "right")):
        if name not in history.data.data_vars:
            return f"the {side} history does not have it"
    if left[name].dims != right[name].dims:
        return "other dimensions"
    if name in _COORDINATES and _model(left) != _model(right):
        return "coordinates of other shape functions"
    sizes = [{d: n for d, n in h[name].sizes.items() if d not in ("time", "station")} for h in (left, right)]
    return "" if sizes[0] == sizes[1] else "other numbers of coordinates"


def _model(history: History) -> Any:
    """Return what decides the meaning of the coordinates."""
    sections = tomllib.loads(history.scenario_toml)
    return sections.get("discretization")


def _measures(left: History, right: History, span: tuple[float, float], limit: float) -> list[Measure]:
    rows = [history.summary.get("macro_collisions", []) for history in (left, right)]
    begins = [[float(m["start"]) for m in found] for found in rows]
    places = align(begins[0], begins[1], [""] * len(begins[0]), [""] * len(begins[1]), limit)
    measures: list[Measure] = []
    number = 0
    for i, j in places:
        both = (None if i is None else rows[0][i]), (None if j is None else rows[1][j])
        # one that goes on after the shorter history is cut there
        if any(m is not None and not span[0] <= m["start"] <= m["end"] <= span[1] for m in both):
            continue
        number += 1
        for key, unit in _COLLISION.items():
            pair = [None if m is None else float(m[key]) for m in both]
            measures.append(Measure(f"collision {number}: {key.replace('_', ' ')}", unit, pair[0], pair[1]))
    ends = [float(_times(history)[-1]) for history in (left, right)]
    if abs(ends[1] - ends[0]) <= SAME * (span[1] - span[0]):
        energies = [history.summary.get("energy", {}) for history in (left, right)]
        for key in _ENERGIES:
            values = [None if key not in energy else float(energy[key]) for energy in energies]
            measures.append(Measure(f"energy: {key.replace('_', ' ')}", "J", values[0], values[1]))
    return measures

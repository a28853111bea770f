"""How far the whole beam stays from the slope, or passes below it: only one point of it is in contact.

Distances are those of the axis, positive on the free side; pictures draw the surface one radius lower.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.beam.operators import Array
from oblique_impact.contact.state import State
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.sections import SlopeSection

if TYPE_CHECKING:
    from oblique_impact.beam.reduced import Beam

Indices = NDArray[np.int64]

#: depth below the contact point, over the length, that is worth a warning: less than pictures show, more than the
#: kinematics of second order leave out (an eighth of the fourth power of the bending slope: 1e-5 at 0.1 rad)
NOTICEABLE = 1e-4
#: distances this close, over the length, are equal: of a touch the first instant is told
EQUAL = 1e-9
BLOCK = 1024  # samples that are processed at a time: larger arrays leave the cache
_HALVINGS = 24  # of a cell between two stations, until a place in it is known


class Axis(NamedTuple):
    """The axis in the frame of the slope, arrays of one shape: coordinates (m) and their derivatives in x."""

    along: Array  # from slope.origin
    height: Array
    along_slope: Array
    height_slope: Array


_Function = Callable[[Axis], Array]


def beam_clearance(beam: Beam, q: Array, ux: Array, uy: Array) -> tuple[Array, Array]:
    """Smallest signed distance (m) of the axis from the slope, and the arc length (m) where it is.

    Between two stations the axis is the cubic through both ends and their tangents, as in a Hermite element: the
    distance does not depend on the stations.

    Parameters
    ----------
    beam : Beam
        With its slope.
    q : ndarray, shape (samples, n + 1)
        Coordinates.
    ux, uy : ndarray, shape (samples, stations)
        Displacements (m) in the floating frame.

    Returns
    -------
    tuple of ndarray, each of shape (samples,)
        NaN where the motion is.
    """
    found = np.empty((2, len(q)))
    for start in range(0, len(q), BLOCK):
        part = slice(start, start + BLOCK)
        found[:, part] = _clearance(beam, q[part], ux[part], uy[part])
    return found[0], found[1]


def _clearance(beam: Beam, q: Array, ux: Array, uy: Array) -> tuple[Array, Array]:
    """Clearance of some samples."""
    x, slope = beam.operators.stations.points, beam.scenario.slope
    with np.errstate(invalid="ignore", over="ignore"):
        bending = np.asarray(beam.operators.stations.slopes @ q[:, 1:].T).T
        turn = (q[:, 0] - slope.angle)[:, None]
        c, s = np.cos(turn), np.sin(turn)
        (x0, y0), ca, sa = slope.origin, np.cos(slope.angle), np.sin(slope.angle)
        arm, stretch = beam.operators.hub_radius + x + ux, 1.0 - 0.5 * beam.foreshortening * bending**2
        axis = Axis(
            arm * c - uy * s - (x0 * ca + y0 * sa),
            arm * s + uy * c - (y0 * ca - x0 * sa),
            stretch * c - bending * s,
            stretch * s + bending * c,
        )
        return nearest(x, axis, slope)


def signed_distance(slope: SlopeSection, along: Array, height: Array) -> Array:
    """Distance (m) of points from the slope: negative below it, beyond its ends that from the nearer end."""
    if not slope.extent:
        return height
    beyond = np.maximum(slope.extent[0] - along, along - slope.extent[1])
    return np.where(beyond > 0.0, np.hypot(beyond, height), height)


def nearest(x: Array, axis: Axis, slope: SlopeSection) -> tuple[Array, Array]:
    """Smallest distance (m) of each sample's axis, known at the stations x (m), and its place (m).

    Besides the stations these places count: where the height has an extremum, and, at an end of the slope, where
    the axis crosses it and where it comes closest to the edge.
    """
    samples = np.arange(axis.height.shape[0])
    distance = signed_distance(slope, axis.along, axis.height)
    station = np.argmin(distance, axis=1)
    rows, found, places = [samples], [distance[samples, station]], [x[station]]
    for guide, measure in _candidates(slope):
        falls = guide(axis) < 0.0
        row, cell = np.nonzero(falls[:, :-1] != falls[:, 1:])
        place, there = _root(guide, x, axis, row, cell)
        rows.append(row)
        found.append(measure(there))
        places.append(place)
    row, value, place = (np.concatenate(parts) for parts in (rows, found, places))
    order = np.lexsort((value, row))
    first = order[np.searchsorted(row[order], samples)]
    return value[first], place[first]


def _candidates(slope: SlopeSection) -> list[tuple[_Function, _Function]]:
    """Functions that are zero where the smallest distance may be, each with the distance there."""

    def crossing(end: float) -> _Function:
        return lambda axis: axis.along - end

    def closest(end: float) -> _Function:
        return lambda axis: (axis.along - end) * axis.along_slope + axis.height * axis.height_slope

    def distance(axis: Axis) -> Array:
        return signed_distance(slope, axis.along, axis.height)

    found: list[tuple[_Function, _Function]] = [(lambda axis: axis.height_slope, distance)]
    for end in slope.extent:
        # on the edge itself the distance jumps: what counts is whether the axis passes below it
        found += [(crossing(end), lambda axis: axis.height), (closest(end), distance)]
    return found


def _root(guide: _Function, x: Array, axis: Axis, row: Indices, cell: Indices) -> tuple[Array, Axis]:
    """Places (m) in cells of the stations where `guide` changes its sign, and the axis there."""
    left, right = (Axis(*(values[row, cell + side] for values in axis)) for side in (0, 1))
    length = x[cell + 1] - x[cell]
    low, high = np.zeros(row.size), np.ones(row.size)
    falls = guide(left) < 0.0
    for _ in range(_HALVINGS):
        part = 0.5 * (low + high)
        before = (guide(_between(left, right, length, part)) < 0.0) == falls
        low, high = np.where(before, part, low), np.where(before, high, part)
    part = 0.5 * (low + high)
    return x[cell] + part * length, _between(left, right, length, part)


def _between(left: Axis, right: Axis, length: Array, part: Array) -> Axis:
    """Axis at a part of each cell by Hermite's cubics."""

    def cubic(a: Array, b: Array, rise_a: Array, rise_b: Array) -> tuple[Array, Array]:
        rise_a, rise_b, step = length * rise_a, length * rise_b, b - a
        square, cube = 3.0 * step - 2.0 * rise_a - rise_b, rise_a + rise_b - 2.0 * step
        value = a + part * (rise_a + part * (square + part * cube))
        return value, (rise_a + part * (2.0 * square + 3.0 * part * cube)) / length

    along, along_slope = cubic(left.along, right.along, left.along_slope, right.along_slope)
    height, height_slope = cubic(left.height, right.height, left.height_slope, right.height_slope)
    return Axis(along, height, along_slope, height_slope)


def closest(variables: Mapping[str, Array], length: float) -> dict[str, float] | None:
    """Where and when the beam comes closest to the slope, or passes deepest below it: distance, x (m), time (s).

    It is the first instant at which the distance is the smallest one of the run.  None without contact.
    """
    if "clearance" not in variables:
        return None
    distance = np.asarray(variables["clearance"])
    if not np.isfinite(distance).any():
        return None
    first = int(np.argmax(distance <= np.nanmin(distance) + EQUAL * length))
    found = {"distance": distance, "x": variables["clearance_at"], "time": variables["time"]}
    return {name: float(values[first]) for name, values in found.items()}


def slope_warnings(scenario: Scenario, variables: Mapping[str, Array], events: Sequence[float]) -> list[str]:
    """Say where the beam passes below the slope, and where it is in contact beyond the slope's ends.

    The depth of the contact point, in an elastic stop or after a fixed step, is no passing; `events` are the times
    (s) of the transitions.
    """
    if "clearance" not in variables:
        return []
    return [*_passing(scenario, variables), *_beyond(scenario, variables, events)]


def _passing(scenario: Scenario, variables: Mapping[str, Array]) -> list[str]:
    slope = scenario.slope
    (x0, y0), c, s = slope.origin, np.cos(slope.angle), np.sin(slope.angle)
    height = (variables["tip_y"] - y0) * c - (variables["tip_x"] - x0) * s
    deeper = np.nan_to_num(np.minimum(height, 0.0) - variables["clearance"], nan=0.0, posinf=0.0)
    k = int(np.argmax(deeper))
    if deeper[k] <= NOTICEABLE * scenario.beam.length:
        return []
    depth, x = -float(variables["clearance"][k]), float(variables["clearance_at"][k])
    return [
        f"passes {two_digits(1e3 * depth)} mm below the slope at x = {x:.3g} m; "
        f"only x = {scenario.contact.point:g} m is in contact"
    ]


def _beyond(scenario: Scenario, variables: Mapping[str, Array], events: Sequence[float]) -> list[str]:
    extent, along = scenario.slope.extent, variables["slip"]
    if not extent:
        return []
    touches = (variables["state"] != State.FREE) | np.isin(variables["time"], events)
    room = NOTICEABLE * scenario.beam.length
    outside = touches & ((along < extent[0] - room) | (along > extent[1] + room))
    if not outside.any():
        return []
    place = float(along[np.argmax(outside)])
    return [
        f"x = {scenario.contact.point:g} m is in contact {place:.4g} m along the slope, outside of slope.extent = "
        f"[{extent[0]:g}, {extent[1]:g}]: its contact does not know of the ends"
    ]


def two_digits(value: float) -> str:
    """Return a number with two significant digits, without an exponent."""
    rounded = float(f"{value:.1e}")
    return f"{rounded:.{max(0, 1 - math.floor(math.log10(abs(rounded)))) if rounded else 0}f}"

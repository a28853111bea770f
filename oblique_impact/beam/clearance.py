"""Clearance of the whole beam from the slope, of which only one point is in contact.

Distances are those of the axis, positive on the free side; pictures draw the surface half the beam's depth lower.
With `contact.surface = "section"` they are those of the beam's face that looks at the slope.  Points are complex
numbers here, z = place along the slope from its origin + i height above it (m).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.operators import Array
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.sections import SlopeSection

if TYPE_CHECKING:
    from oblique_impact.beam.beam import Beam

Indices = NDArray[np.int64]
Points = NDArray[np.complex128]
_Function = Callable[[Points, Points], Array]

#: depth below the contact point, over the length, that gives a warning: less than pictures show, more than the
#: kinematics of second order leave out (an eighth of the fourth power of the bending slope: 1e-5 at 0.1 rad)
NOTICEABLE = 1e-4
#: difference of distances, over the length, that is rounding: of equal ones the first instant counts
EQUAL = 1e-9
BLOCK = 1024  # samples that are processed at a time: larger arrays leave the cache
_HALVINGS = 12  # of a cell between two stations; a chord over so short a part of it errs by its square


def beam_clearance(beam: Beam, q: Array, ux: Array, uy: Array) -> tuple[Array, Array]:
    """Smallest signed distance (m) of the beam from the slope, and the arc length (m) where it is.

    It is that of the axis, or of the face.  Between two stations either is the cubic through both ends and their
    tangents, as in a Hermite element: the distance does not depend on the stations.

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
    stations, slope = beam.operators.stations, beam.scenario.slope
    with np.errstate(invalid="ignore", over="ignore"):
        bending = np.asarray(stations.slopes @ q[:, 1:].T).T
        turn = np.exp(1j * (q[:, :1] - slope.angle))
        z = turn * (beam.operators.sections.hub_radius + stations.points + ux + 1j * uy)
        tangent = turn * (1.0 - 0.5 * beam.foreshortening * bending**2 + 1j * bending)
        if beam.scenario.contact_fibre != 0.0:
            curvature = np.asarray(stations.curvatures @ q[:, 1:].T).T
            turned = tangent, turn * curvature * (1j - beam.foreshortening * bending)
            z, tangent = facing_surface(beam.scenario, stations.points, (z, tangent), turned)
        height, along = slope.offsets
        return smallest_distance(stations.points, z - (along + 1j * height), tangent, slope)


def facing_surface(
    scenario: Scenario, x: Array, axis: tuple[Points, Points], turn: tuple[Points, Points]
) -> tuple[Points, Points]:
    """Return the face of the beam on the side of the slope, and its derivative in x, at the stations x (m).

    `axis` is that of the beam and `turn` the direction, of length 1, that its sections have turned to from that of
    the axis, each with its derivative in x and of shape (samples, stations).
    """
    fibre = np.copysign(Sections.from_scenario(scenario).fibre_distance(x), scenario.contact_fibre)
    rise = np.gradient(fibre, x, edge_order=2)
    return axis[0] + 1j * fibre * turn[0], axis[1] + 1j * (rise * turn[0] + fibre * turn[1])


def smallest_distance(x: Array, z: Points, tangent: Points, slope: SlopeSection) -> tuple[Array, Array]:
    """Smallest distance (m) of each sample's axis, and its place (m).

    The axis is known at the stations x (m), with its derivative in x: z and tangent (samples, stations).  Besides
    the stations these places count: where the height has an extremum, and, at an end of the slope, where the axis
    crosses it and where it comes closest to the edge.
    """
    samples = np.arange(z.shape[0])
    distance = _distance(slope, z)
    station = np.argmin(distance, axis=1)
    rows, found, places = [samples], [distance[samples, station]], [x[station]]
    # functions that are zero at such places; where the axis crosses an end of the slope the distance jumps:
    # there the height counts
    guides: list[tuple[_Function, bool]] = [(lambda z, tangent: tangent.imag, False)]
    for end in slope.extent:
        guides.append((lambda z, tangent, end=end: z.real - end, True))  # type: ignore[misc]
        guides.append((lambda z, tangent, end=end: ((z - end) * tangent.conj()).real, False))  # type: ignore[misc]
    for guide, on_edge in guides:
        falls = guide(z, tangent) < 0.0
        row, cell = np.nonzero(falls[:, :-1] != falls[:, 1:])
        place, point = _root(guide, x, z, tangent, row, cell)
        rows.append(row)
        found.append(point.imag if on_edge else _distance(slope, point))
        places.append(place)
    row, value, place = (np.concatenate(parts) for parts in (rows, found, places))
    order = np.lexsort((value, row))
    first = order[np.searchsorted(row[order], samples)]
    return value[first], place[first]


def _distance(slope: SlopeSection, z: Points) -> Array:
    """Distance (m) of points from the slope: negative below it, beyond its ends that from the nearer end."""
    if not slope.extent:
        return z.imag
    beyond = np.maximum(slope.extent[0] - z.real, z.real - slope.extent[1])
    return np.where(beyond > 0.0, np.hypot(beyond, z.imag), z.imag)


def _root(
    guide: _Function, x: Array, z: Points, tangent: Points, row: Indices, cell: Indices
) -> tuple[Array, Points]:
    """Places (m) in cells of the stations where `guide` changes its sign, and the points of the axis there.

    The axis is Hermite's cubic of each cell; `part` of the cell, 0 to 1, is bisected, and a chord ends it.
    """
    length, start, step = x[cell + 1] - x[cell], z[row, cell], z[row, cell + 1] - z[row, cell]
    first, last = length * tangent[row, cell], length * tangent[row, cell + 1]
    square, cube = 3.0 * step - 2.0 * first - last, first + last - 2.0 * step

    def at(part: Array) -> tuple[Points, Array]:
        point = start + part * (first + part * (square + part * cube))
        return point, guide(point, first + part * (2.0 * square + 3.0 * part * cube))

    falls = guide(start, first) < 0.0
    low, high = np.zeros(row.size), np.ones(row.size)
    for _ in range(_HALVINGS):
        part = 0.5 * (low + high)
        before = (at(part)[1] < 0.0) == falls
        low, high = np.where(before, part, low), np.where(before, high, part)
    (_, one), (_, other) = at(low), at(high)
    part = low + (high - low) * one / (one - other)
    return x[cell] + part * length, at(part)[0]


def closest(variables: Mapping[str, Array], length: float) -> dict[str, float] | None:
    """Return the smallest distance (m) of a run from the slope, its place x (m) and its first time (s).

    Negative below the slope.  None if contact is disabled.
    """
    distance = np.asarray(variables.get("clearance", np.nan))
    if not np.isfinite(distance).any():
        return None
    first = int(np.argmax(distance <= np.nanmin(distance) + EQUAL * length))
    found = {"distance": distance, "x": variables["clearance_at"], "time": variables["time"]}
    return {name: float(values[first]) for name, values in found.items()}


def slope_warnings(
    scenario: Scenario, variables: Mapping[str, Array], passages: Sequence[Mapping[str, Any]]
) -> list[str]:
    """Return warnings if the beam passes below the slope, or its contact point leaves the slope at an end.

    The depth of the contact point itself, in an elastic stop or after a fixed step, does not count, unless it is
    below the line of the slope beyond an end.  `passages` are those of the summary's `slope_ends`.
    """
    if "clearance" not in variables:
        return []
    slope, point, tolerance = scenario.slope, scenario.contact.point, NOTICEABLE * scenario.beam.length
    warnings = []
    c, s = np.cos(slope.angle), np.sin(slope.angle)
    height = variables["tip_y"] * c - variables["tip_x"] * s - slope.offsets[0]
    past = np.full(height.shape, bool(slope.extent) and bool(height[0] < -tolerance))
    for passage in passages:
        past[variables["time"] > passage["time"]] = passage["how"] != "comes back"
    deeper = np.where(past, 0.0, np.minimum(height, 0.0)) - variables["clearance"]
    k = int(np.argmax(np.nan_to_num(deeper, nan=0.0, posinf=0.0)))
    if deeper[k] > tolerance:
        depth, x = -1e3 * variables["clearance"][k], variables["clearance_at"][k]
        digits = np.format_float_positional(depth, 2, unique=False, fractional=False, trim="-")
        why = f"x = {point:g} m has passed an end of it" if past[k] else f"only x = {point:g} m is in contact"
        warnings.append(f"passes {digits} mm below the slope at x = {x:.3g} m; {why}")
    left = [passage for passage in passages if passage["how"] != "comes back"]
    if left:
        passage, (first, last) = left[0], slope.extent
        more = f" (the first of {len(left)} in slope_ends)" if len(left) > 1 else ""
        warnings.append(
            f"x = {point:g} m {passage['how']} slope.extent = [{first:g}, {last:g}] at "
            f"t = {passage['time']:.6g} s, {passage['place']:.6g} m along the slope{more}: "
            "contact with the end itself is left out"
        )
    return warnings

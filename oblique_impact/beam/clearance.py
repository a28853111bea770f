"""Clearance of the whole beam from the slope and the other obstacles, wherever it can touch them.

Distances are those of the axis, positive on the free side; pictures draw the surface half the beam's depth lower.
With `contact.surface = "section"` they are those of the beam's face that looks at the obstacle.  Points are
complex numbers here, z = x + i y (m).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.operators import Array
from oblique_impact.contact.state import State
from oblique_impact.scenario.obstacles import ObstaclePoint, Side
from oblique_impact.scenario.scenario import Scenario

if TYPE_CHECKING:
    from oblique_impact.beam.beam import Beam

Indices = NDArray[np.int64]
Points = NDArray[np.complex128]
_Function = Callable[[Points, Points], Array]
Curve = tuple[Points, Points]  # points at the stations and their derivative in x, each (samples, stations)

#: depth below the contact point, over the length, that gives a warning: less than pictures show, more than the
#: kinematics of second order leave out (an eighth of the fourth power of the bending slope: 1e-5 at 0.1 rad)
NOTICEABLE = 1e-4
#: difference of distances, over the length, that is rounding: of equal ones the first instant counts
EQUAL = 1e-9
BLOCK = 1024  # samples that are processed at a time: larger arrays leave the cache
_HALVINGS = 12  # of a cell between two stations; a chord over so short a part of it errs by its square


def beam_clearance(beam: Beam, q: Array, ux: Array, uy: Array) -> tuple[Array, Array, Indices]:
    """Smallest signed distance (m) of the beam from the obstacles, the arc length (m) where it is, and from which.

    It is that of the axis, or of the face.  Between two stations either is the cubic through both ends and their
    tangents, as in a Hermite element: the distance does not depend on the stations.

    Parameters
    ----------
    beam : Beam
        With its obstacles.
    q : ndarray, shape (samples, n + 1)
        Coordinates.
    ux, uy : ndarray, shape (samples, stations)
        Displacements (m) in the floating frame.

    Returns
    -------
    tuple of ndarray, each of shape (samples,)
        Distance and arc length, NaN where the motion is, and the nearest obstacle: the slope is 0.
    """
    found, obstacle = np.empty((2, len(q))), np.empty(len(q), dtype=np.int64)
    for start in range(0, len(q), BLOCK):
        part = slice(start, start + BLOCK)
        found[0, part], found[1, part], obstacle[part] = _clearance(beam, q[part], ux[part], uy[part])
    return found[0], found[1], obstacle


def _clearance(beam: Beam, q: Array, ux: Array, uy: Array) -> tuple[Array, Array, Indices]:
    """Clearance of some samples."""
    stations, section = beam.operators.stations, None
    with np.errstate(invalid="ignore", over="ignore"):
        bending = np.asarray(stations.slopes @ q[:, 1:].T).T
        turn = np.exp(1j * q[:, :1])
        z = turn * (beam.operators.sections.hub_radius + stations.points + ux + 1j * uy)
        tangent = turn * (1.0 - 0.5 * beam.foreshortening * bending**2 + 1j * bending)
        if beam.scenario.contact.surface == "section":
            curvature = np.asarray(stations.curvatures @ q[:, 1:].T).T
            section = tangent, turn * curvature * (1j - beam.foreshortening * bending)
        return smallest_distance(beam.scenario, stations.points, (z, tangent), section)


def smallest_distance(
    scenario: Scenario, x: Array, axis: Curve, section: Curve | None = None
) -> tuple[Array, Array, Indices]:
    """Smallest distance (m) of each sample's beam from the obstacles, its place (m) and the nearest obstacle.

    The axis is known at the stations x (m); `section` is the direction, of length 1, that the sections have turned
    to from that of the axis, with its derivative in x: given, the distance is that of the face.  Below a side it
    is negative, and from a peg where the axis, or the face, is inside of it.
    """
    numbers, found = list[int](), list[tuple[Array, Array]]()
    for side in scenario.sides:
        numbers.append(side.obstacle)
        found.append(_from_side(side, x, axis if section is None else _facing(scenario, side, x, axis, section)))
    for point in scenario.obstacle_points:
        if not point.corner:  # which belongs to its side
            numbers.append(point.obstacle)
            found.append(_from_point(scenario, point, x, axis))
    distance, place = (np.array(each) for each in zip(*found, strict=True))
    nearest = np.argmin(np.nan_to_num(distance, nan=np.inf), axis=0)
    samples = np.arange(nearest.size)
    return distance[nearest, samples], place[nearest, samples], np.array(numbers)[nearest]


def _facing(scenario: Scenario, side: Side, x: Array, axis: Curve, section: Curve) -> Curve:
    """Return the face of the beam that looks at a side."""
    facing = -np.copysign(1.0, np.cos(scenario.initial.angle - side.angle))
    fibre = facing * Sections.from_scenario(scenario).fibre_distance(x)
    rise = np.gradient(fibre, x, edge_order=2)
    return axis[0] + 1j * fibre * section[0], axis[1] + 1j * (rise * section[0] + fibre * section[1])


def _from_side(side: Side, x: Array, curve: Curve) -> tuple[Array, Array]:
    """Distance (m) from a side and its place (m).

    Besides the stations these places count: where the height has an extremum, and, at an end of the side, where
    the curve crosses it and where it comes closest to the corner.
    """
    height, along = side.offsets
    turn = np.exp(-1j * side.angle)

    def distance(z: Points) -> Array:
        return _distance(side.extent, z)

    # functions that are zero at such places, each with what counts there; where the axis crosses an end of the
    # side the distance jumps: there the height counts
    guides: list[tuple[_Function, Callable[[Points], Array]]] = [(lambda z, tangent: tangent.imag, distance)]
    for end in side.extent:
        guides.append((lambda z, tangent, end=end: z.real - end, np.imag))  # type: ignore[misc]
        guides.append((lambda z, tangent, end=end: _ahead(z - end, tangent), distance))  # type: ignore[misc]
    return _smallest(x, (turn * curve[0] - (along + 1j * height), turn * curve[1]), distance, guides)


def _from_point(scenario: Scenario, point: ObstaclePoint, x: Array, axis: Curve) -> tuple[Array, Array]:
    """Distance (m) from a point and its place (m)."""
    centre = point.x + 1j * point.y
    distance, place = _smallest(x, (axis[0] - centre, axis[1]), np.abs, [(_ahead, np.abs)])
    depth = (
        Sections.from_scenario(scenario).fibre_distance(place) if scenario.contact.surface == "section" else 0.0
    )
    return distance - point.radius - depth, place


def _ahead(z: Points, tangent: Points) -> Array:
    """Return how far z lies along the tangent, times its length: 0 where a curve is closest to the origin."""
    return np.asarray((z * tangent.conj()).real)


def _smallest(
    x: Array,
    curve: Curve,
    distance: Callable[[Points], Array],
    guides: Sequence[tuple[_Function, Callable[[Points], Array]]],
) -> tuple[Array, Array]:
    """Smallest distance (m) at the stations and where a guide is zero, and its place (m)."""
    samples, (z, tangent) = np.arange(curve[0].shape[0]), curve
    at_stations = distance(z)
    station = np.argmin(at_stations, axis=1)
    found = [(samples, at_stations[samples, station], x[station])]
    for guide, value in guides:
        falls = guide(z, tangent) < 0.0
        row, cell = np.nonzero(falls[:, :-1] != falls[:, 1:])
        place, point = _root(guide, x, z, tangent, row, cell)
        found.append((row, value(point), place))
    row, smallest, place = (np.concatenate(parts) for parts in zip(*found, strict=True))
    order = np.lexsort((smallest, row))
    first = order[np.searchsorted(row[order], samples)]
    return smallest[first], place[first]


def _distance(extent: tuple[float, ...], z: Points) -> Array:
    """Distance (m) of points from a side, z = place along it + i height; beyond its ends that from the nearer."""
    if not extent:
        return z.imag
    beyond = np.maximum(extent[0] - z.real, z.real - extent[1])
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

    def at(part: Array) -> Curve:
        point = start + part * (first + part * (square + part * cube))
        return point, first + part * (2.0 * square + 3.0 * part * cube)

    falls = guide(start, first) < 0.0
    low, high = np.zeros(row.size), np.ones(row.size)
    for _ in range(_HALVINGS):
        part = 0.5 * (low + high)
        before = (guide(*at(part)) < 0.0) == falls
        low, high = np.where(before, part, low), np.where(before, high, part)
    one, other = guide(*at(low)), guide(*at(high))
    part = low + (high - low) * one / (one - other)
    return x[cell] + part * length, at(part)[0]


def closest(variables: Mapping[str, Array], length: float) -> dict[str, float] | None:
    """Return the smallest distance (m) of a run from the obstacles, its place x (m) and its first time (s).

    Negative below the slope; of several obstacles the nearest too.  None if contact is disabled.
    """
    distance = np.asarray(variables.get("clearance", np.nan))
    if not np.isfinite(distance).any():
        return None
    first = int(np.argmax(distance <= np.nanmin(distance) + EQUAL * length))
    found = {"distance": distance, "x": variables["clearance_at"], "time": variables["time"]}
    if "clearance_obstacle" in variables:
        found["obstacle"] = variables["clearance_obstacle"]
    return {name: values[first].item() for name, values in found.items()}


def slope_warnings(
    scenario: Scenario, variables: Mapping[str, Array], passages: Sequence[Mapping[str, Any]]
) -> list[str]:
    """Return warnings if the beam passes below a side or through a peg, or its one contact point leaves the slope.

    The depth of the contact point itself, in an elastic stop or after a fixed step, does not count, unless it is
    below the line of the slope beyond an end.  `passages` are those of the summary's `slope_ends`.
    """
    if "clearance" not in variables:
        return []
    if scenario.contact.where == "anywhere":
        return _passes_between(scenario, variables) + _passes_through_pegs(scenario, variables)
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
        why = f"x = {point:g} m has passed an end of it" if past[k] else f"only x = {point:g} m is in contact"
        warnings.append(f"{_passage(variables, k, 'the slope')}; {why}")
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


def _passes_between(scenario: Scenario, variables: Mapping[str, Array]) -> list[str]:
    """Return a warning if the beam passes below a side between the places that can touch it."""
    distance, obstacle = variables["clearance"], variables["clearance_obstacle"]
    pressed = (variables["contact_state"] != State.FREE) & (variables["contact_obstacle"] == obstacle[:, None])
    depth = np.where(pressed, np.minimum(variables["contact_gap"], 0.0), 0.0).min(axis=1)
    # below the end of a side an axis at up to 60 degrees to it is up to twice as deep as the corner presses in
    deeper = np.where(np.isin(obstacle, [side.obstacle for side in scenario.sides]), 2.0 * depth - distance, 0.0)
    k = int(np.argmax(np.nan_to_num(deeper, nan=0.0, posinf=0.0)))
    if not deeper[k] > NOTICEABLE * scenario.beam.length:
        return []
    name, grid = f"obstacle {obstacle[k]}" if obstacle[k] else "the slope", scenario.contact.grid
    return [f"{_passage(variables, k, name)}; sides touch it at the ends of contact.grid = {grid} parts alone"]


def _passes_through_pegs(scenario: Scenario, variables: Mapping[str, Array]) -> list[str]:
    """Return a warning for each peg that the beam comes to from behind: round its own end, without contact."""
    warnings, least = list[str](), NOTICEABLE * scenario.beam.length
    for point in scenario.obstacle_points:
        if point.corner:  # which belongs to its side
            continue
        i = int(np.argmax(variables["contact_obstacle"] == point.obstacle))
        place, reach = variables["contact_place"][:, i], point.radius + scenario.half_depth
        across = variables["contact_gap"][:, i] + reach  # of the axis from the centre, negative behind it
        # where a contact opens or closes within a step, its last sample of flight may be inside of the peg
        closed = np.pad(variables["contact_state"][:, i] != State.FREE, 1)
        flies = ~(closed[:-2] | closed[1:-1] | closed[2:]) & (place >= 0.0) & (place <= scenario.beam.length)
        passes = flies & (across < -least) & (across > least - reach)
        far = np.flatnonzero(np.abs(across) > least)  # nearer to a peg without a radius it may only touch it
        flies_on = flies[far[:-1]] & (np.diff(np.cumsum(~flies)[far]) == 0)
        passes[far[1:]] |= flies_on & (across[far[:-1]] < 0.0) & (across[far[1:]] > 0.0)
        if passes.any():
            warnings.append(
                f"passes through obstacle {point.obstacle} at t = {variables['time'][np.argmax(passes)]:.6g} s: "
                "a peg touches only that side of the beam which faces it at the start"
            )
    return warnings


def _passage(variables: Mapping[str, Array], sample: int, obstacle: str) -> str:
    """Return how deep and where the beam is below an obstacle, as text."""
    depth, x = -1e3 * variables["clearance"][sample], variables["clearance_at"][sample]
    digits = np.format_float_positional(depth, 2, unique=False, fractional=False, trim="-")
    return f"passes {digits} mm below {obstacle} at x = {x:.3g} m"

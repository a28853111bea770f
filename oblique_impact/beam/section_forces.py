"""Results along the beam: displacements, section forces and stress, from sampled motions.

Section forces follow from the equilibrium of the accelerated part of the beam outside of a section, in
the deformed configuration.  For an axially rigid beam that is the only way to the axial force, a
reaction.  For the bending moment it is the accurate way: E I Phi'' B converges slowly near a point load and in the
derivatives that the shear takes, while the integrals of the inertia forces do not (for assumed modes this
is the mode-acceleration method: Williams 1945; Bisplinghoff, Ashley, Halfman, Aeroelasticity, 1955, Sec. 10-6).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.beam.beam import Beam
from oblique_impact.beam.bent_beam import BentBeam, direction_of
from oblique_impact.beam.operators import Array, Matrix, cumulative_weights
from oblique_impact.beam.shaking import base_acceleration, direction_in_frame

Complex = NDArray[np.complex128]

#: quadrature points times samples in one block: larger arrays leave the cache
_BLOCK_SIZE = 32_000

#: a load so close to a station (over the length) is at it: places of contacts are known to rounding
_SAME_PLACE = 1e-9
_SUMS = 10


class Fields(NamedTuple):
    """Results along the beam, each of shape (samples, stations), in the floating frame.

    A positive moment bends the beam like a positive E I u_y''.  The stress is that of bending alone, at the
    outer fibre on the side of negative y; the opposite fibre has the opposite one.
    """

    ux: Array  # m
    uy: Array  # m
    ux_dot: Array  # m/s, rates of these coordinates in the frame
    uy_dot: Array  # m/s
    moment: Array  # N m
    shear: Array  # N, d(moment)/dx
    axial_force: Array  # N, along the frame's x axis, tension positive
    bending_stress: Array  # Pa


class PointLoads(NamedTuple):
    """Forces of contacts on the beam, each array of shape (samples, contacts).

    Place and position of a force of 0 are not read and may be NaN.
    """

    place: Array  # m along the beam
    x: Array  # m, inertial: where the force acts, on the axis or on the face
    y: Array
    fx: Array  # N, inertial
    fy: Array


NO_LOADS = PointLoads(*(np.zeros((0, 0)) for _ in PointLoads._fields))


class Motion(NamedTuple):
    """Sampled motion: times (samples,), q, q', q'' (samples, n + 1) and forces of contacts."""

    time: Array
    q: Array
    qd: Array
    qdd: Array
    loads: PointLoads = NO_LOADS


class _Points(NamedTuple):
    """The points of the quadrature, panel after panel."""

    arms: Array  # (nq,) m, from the axis of rotation
    weights: Array  # (nq,) m
    masses: Array  # (nq,) kg
    inside: Array  # (order, order) integrals inside of a unit panel
    foreshortening: float


def fields_along(beam: Beam, motion: Motion, block: int | None = None) -> Fields:
    """Results at the stations for each sample of a motion.

    Parameters
    ----------
    beam : Beam
        The discretized beam; its tables are only multiplied with, so they may be sparse.
    motion : Motion
        Samples.  Where q'' is NaN the section forces are NaN.
    block : int, optional
        Samples processed at a time; default: so many that the arrays stay in the cache.

    Returns
    -------
    Fields
        Section forces at a station that carries a point force are those just inboard of it.
    """
    table, sections = beam.operators.stations.quadrature, beam.operators.sections
    points = _Points(
        sections.hub_radius + table.points,
        table.weights,
        sections.mass_per_length(table.points) * table.weights,
        cumulative_weights(table.order),
        beam.foreshortening,
    )
    stations = beam.operators.stations.points.size
    result = Fields(*(np.empty((motion.time.size, stations)) for _ in Fields._fields))
    for part in _blocks(motion.time.size, table.points.size, block):
        loads = PointLoads(*(values[part] for values in motion.loads))
        rows_of_block = Motion(motion.time[part], motion.q[part], motion.qd[part], motion.qdd[part], loads)
        for whole, rows in zip(result, _block(beam, rows_of_block, points), strict=True):
            whole[part] = rows.T
    return result


def bent_beam(beam: Beam, q: Array, qd: Array) -> BentBeam:
    """Return the bent beam at the stations, of coordinates and velocities (samples, n + 1)."""
    stations = beam.operators.stations
    table = stations.quadrature
    weights = table.weights.reshape(-1, 1, table.order)
    u, rate = np.empty((2, len(q), stations.points.size), dtype=complex)
    for part in _blocks(len(q), table.points.size):
        B, Bd = q[part, 1:].T, qd[part, 1:].T
        slopes, rates = np.asarray(table.slopes @ B), np.asarray(table.slopes @ Bd)
        sums = np.zeros((table.points.size // table.order + 1, 2, B.shape[1]))
        foreshortening = -beam.foreshortening * np.stack([0.5 * slopes * slopes, slopes * rates], axis=1)
        _add_panels(weights, foreshortening, sums[1:])
        u.real[part], rate.real[part] = np.moveaxis(sums[stations.cells // table.order].T, 1, 0)
        u.imag[part], rate.imag[part] = np.asarray(stations.values @ B).T, np.asarray(stations.values @ Bd).T
    slope, slope_rate = (np.asarray(stations.slopes @ of.T[1:]).T for of in (q, qd))
    direction = direction_of(slope, beam.foreshortening)
    turning = (1j - beam.foreshortening * slope) * slope_rate
    arms = beam.operators.sections.hub_radius + stations.points
    return BentBeam(q[:, :1], arms, u, qd[:, :1], rate, direction, turning)


def _blocks(samples: int, points: int, block: int | None = None) -> Iterator[slice]:
    """Return blocks of samples, so small that arrays over them and the quadrature points stay in the cache."""
    block = block or max(1, _BLOCK_SIZE // points)
    return (slice(start, start + block) for start in range(0, samples, block))


def _block(beam: Beam, motion: Motion, points: _Points) -> Fields:
    """Fields of some samples, (stations, samples)."""
    o, stations = beam.operators, beam.operators.stations
    sections, x = o.sections, o.stations.points
    B = np.stack([motion.q[:, 1:].T, motion.qd[:, 1:].T, motion.qdd[:, 1:].T], axis=1)
    spin, spin_rate = spins = np.stack([motion.qd[:, 0], motion.qdd[:, 0]])
    whole, inner, shortening = _sums(beam, points, spins, B)
    ux, ux_dot = inner[:2]
    mx, mx1, mx2, my, my1, my2, turned = whole[3:, None] - inner[3:]  # of the part outside of each station
    along, across = _weights(beam, motion)
    mass = np.append(np.cumsum(points.masses[::-1])[::-1], 0.0)[stations.cells, None]
    mass = mass + _outside(beam, x, sections.places) @ sections.point_masses[:, None]
    axial = spin_rate * my + 2.0 * spin * my1 + spin**2 * mx - mx2 - mass * along
    transverse = spin**2 * my - spin_rate * mx - 2.0 * spin * mx1 - my2 - mass * across
    moment = my * along - mx * across - turned
    uy, uy_dot, slope = stations.values @ B[:, 0], stations.values @ B[:, 1], stations.slopes @ B[:, 0]
    for place, point, force in (*_in_frame(motion), *_applied_forces(beam, motion, shortening)):
        outside = _outside(beam, x, place)
        moment += outside * (point.real * force.imag - point.imag * force.real)
        axial += outside * force.real
        transverse += outside * force.imag
    arms = sections.hub_radius + x[:, None] + ux
    moment += uy * axial - arms * transverse
    shear = slope * axial - (1.0 - 0.5 * beam.foreshortening * slope**2) * transverse
    modulus = (sections.fibre_distance(x) / sections.second_moment(x))[:, None]
    return Fields(ux, uy, ux_dot, uy_dot, moment, shear, axial, modulus * moment)


def _outside(beam: Beam, x: Array, places: Array) -> Array:
    """Whether places (k,) are outside of stations x (stations,) or at them, 1 or 0: (stations, k)."""
    return np.asarray(x[:, None] <= places + _SAME_PLACE * beam.operators.sections.length, dtype=float)


def _weights(beam: Beam, motion: Motion) -> Array:
    """Weight of a unit mass against x and y of the frame (m/s^2), with the inertia force by a shaken base."""
    shaking, sine, cosine = beam.shaking, np.sin(motion.q[:, 0]), np.cos(motion.q[:, 0])
    weights = beam.scenario.gravity * np.stack([sine, cosine])
    if shaking is not None:
        accelerations = np.array([base_acceleration(shaking, t) for t in motion.time.tolist()])
        weights += accelerations * np.stack(direction_in_frame(shaking, cosine, sine))
    return weights


def _applied_forces(beam: Beam, motion: Motion, ux: Array) -> Iterator[tuple[Array, Complex, Complex]]:
    """Yield the forces on the beam like contacts; u_x (m) where they act, (k, samples)."""
    forces, o, B = beam.forces, beam.operators, motion.q[:, 1:].T
    if forces is None:
        return
    places, theta = forces.places, motion.q[:, 0]
    uy, slopes = o.rows_at(places, 0) @ B, o.rows_at(places, 1) @ B
    for k, place in enumerate(places):
        point = o.sections.hub_radius + place + ux[k] + 1j * uy[k]
        yield np.full(theta.size, place), point, forces.in_frame(k, motion.time, theta, slopes[k])


def _sums(beam: Beam, points: _Points, spins: Array, B: Array) -> tuple[Array, Array, Array]:
    """Return the sums over masses: over the whole beam with its point masses, and up to the stations.

    They are u_x and two derivatives; sums of m x and of m y with two derivatives each, of m times
    :func:`_turning`; each (10, samples) or (10, stations, samples).  Third is u_x at the k forces, (k, samples).
    """
    stations, sections = beam.operators.stations, beam.operators.sections
    table, samples = stations.quadrature, B.shape[2]
    sums = np.zeros((table.points.size // table.order + 1, _SUMS, samples))
    x, y = _axial_along(points, _applied(table.slopes, B), sums), _applied(table.values, B)
    at_x, at_y = sums[beam.panels_before(sections.places), :3], _applied(beam.at_masses, B)  # of the point masses
    at_x[:, 0] += sections.hub_radius + sections.places[:, None]
    slopes = beam.operators.rows_at(sections.places, 1)
    turns = spins[1] + slopes @ B[:, 2]  # their angular accelerations
    slowed = beam.slowed(B[:, 1])
    if slowed is not None:
        # a load like that of inertia; Kelvin-Voigt damping is part of the bending moment
        swing = _swing(beam, np.append(x[:, 0], at_x[:, 0], axis=0), slowed)
        loads = beam.deflections(slowed) - np.outer(beam.masses[0], swing)
        y[:, 2] += loads[: len(y)]
        at_y[:, 2] += loads[len(y) :]
        turns += slopes @ slowed - swing
    on_spring = beam.slowed_on_spring(spins[0], B[:, 1])
    if on_spring is not None:  # as the hub turns, too
        loads = beam.deflections(on_spring[1:]) + np.outer(beam.masses[0], on_spring[0])
        y[:, 2] += loads[: len(y)]
        at_y[:, 2] += loads[len(y) :]
        turns += slopes @ on_spring[1:] + on_spring[0]
    _add_masses(points, spins, x, y, sums)
    whole, inner = sums[-1].copy(), sums[stations.cells // table.order]
    inside = 1.0 - _outside(beam, stations.points, sections.places)
    for k, (_, mass, inertia) in enumerate(sections.masses):
        turned = mass * _turning(at_x[k], at_y[k], *spins) + inertia * turns[k]
        share = np.concatenate([mass * at_x[k], mass * at_y[k], turned[None]])
        whole[3:] += share
        inner[:, 3:] += inside[:, k, None, None] * share
    loaded = beam.forces.places if beam.forces is not None else np.zeros(0)
    return whole, np.moveaxis(inner, 1, 0), sums[beam.panels_before(loaded), 0]


def _swing(beam: Beam, X: Array, B: Array) -> Array:
    """Rotation (samples,) that takes from deflections B (n, samples) the moment of beam and hub about their axis.

    X (points, samples) are the positions of the points of mass along the frame.  A driven root does not turn.
    """
    if beam.scenario.root.kind == "driven":
        return np.zeros(B.shape[1])
    (arms, masses), (inertias, slopes) = beam.masses, beam.operators.turning
    X = masses[:, None] * X
    turn = np.einsum("is,is->s", X, beam.deflections(B)) + inertias @ (slopes @ B)
    return np.asarray(turn / (arms @ X + inertias.sum()))


def _turning(x: Array, y: Array, spin: Array, spin_rate: Array) -> Array:
    """Moment about the axis of rotation that accelerates a unit mass; x and y with their two derivatives.

    The accelerations in the frame are a_a = x'' - theta'' y - 2 theta' y' - theta'^2 x and
    a_t = y'' + theta'' x + 2 theta' x' - theta'^2 y (primes are time derivatives); this is x a_t - y a_a.
    """
    across = x[0] * y[2] - y[0] * x[2] + spin_rate * (x[0] * x[0] + y[0] * y[0])
    found: Array = across + 2.0 * spin * (x[0] * x[1] + y[0] * y[1])
    return found


def _axial_along(points: _Points, slopes: Array, sums: Array) -> Array:
    """Positions r + x + u_x of the points, with two derivatives, (nq, 3, samples); u_x at the ends of the panels.

    `slopes` (nq, 3, samples) are those of the axis with two derivatives; `sums` (panels + 1, 10, samples), zero,
    take u_x.
    """
    order, (count, _, samples) = len(points.inside), slopes.shape
    s, s1, s2 = slopes.swapaxes(0, 1)
    # what u_x and its derivatives are integrals of
    rates = -points.foreshortening * np.stack([0.5 * s * s, s * s1, s1 * s1 + s * s2], axis=1)
    panels = rates.reshape(-1, order, 3 * samples)
    weights = points.weights.reshape(-1, 1, order)
    _add_panels(weights, rates, sums[1:, :3])
    inside = weights.sum(axis=2)[:, :, None] * points.inside
    shortened = (inside @ panels).reshape(-1, order, 3, samples) + sums[:-1, None, :3]
    x: Array = shortened.reshape(count, 3, samples)
    x[:, 0] += points.arms[:, None]
    return x


def _add_masses(points: _Points, spins: Array, x: Array, y: Array, sums: Array) -> None:
    """Add up m x and m y, each (nq, 3, samples) with two derivatives, and m times :func:`_turning`.

    `spins` (2, samples) are theta' and theta''.
    """
    turned = _turning(x.swapaxes(0, 1), y.swapaxes(0, 1), *spins)[:, None]
    masses = points.masses.reshape(-1, 1, len(points.inside))
    for part, columns in ((x, slice(3, 6)), (y, slice(6, 9)), (turned, slice(9, 10))):
        _add_panels(masses, part, sums[1:, columns])


def _add_panels(weights: Array, values: Array, sums: Array) -> None:
    """Add up values (nq, ...) times weights (panels, 1, order) to the ends of the panels, `sums` (panels, ...)."""
    panels, _, order = weights.shape
    np.cumsum((weights @ values.reshape(panels, order, -1)).reshape(sums.shape), axis=0, out=sums)


def _in_frame(motion: Motion) -> Iterator[tuple[Array, Complex, Complex]]:
    """Yield place (m), position (m) and force (N) of each load in the frame, x + i y, each (samples,)."""
    turn = np.exp(-1j * motion.q[:, 0])
    for place, x, y, fx, fy in zip(*(values.T for values in motion.loads), strict=True):
        force = fx + 1j * fy
        yield place, turn * np.where(force == 0.0, 0.0, x + 1j * y), turn * force


def _applied(table: Matrix, B: Array) -> Array:
    """Apply a table (points, n) to coordinates and their derivatives (n, 3, samples) -> (points, 3, samples)."""
    return np.asarray(table @ B.reshape(len(B), -1)).reshape(-1, *B.shape[1:])

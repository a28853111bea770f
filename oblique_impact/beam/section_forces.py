"""Results along the beam: displacements, section forces and stress, from sampled motions.

Section forces follow from the equilibrium of the accelerated part of the beam outside of a section, in
the deformed configuration.  For an axially rigid beam that is the only way to the axial force, a
reaction.  For the bending moment it is the accurate way: E I Phi'' B converges slowly near a point load and in the
derivatives that the shear takes, while the integrals of the inertia forces do not (for assumed modes this
is the mode-acceleration method: Williams 1945; Bisplinghoff, Ashley, Halfman, Aeroelasticity, 1955, Sec. 10-6).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.beam.operators import Array, ShapeTable, cumulative
from oblique_impact.beam.reduced import Beam

Indices = NDArray[np.int64]

BLOCK = 64  # samples that are processed at a time: larger arrays leave the cache


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


class Motion(NamedTuple):
    """Sampled motion: times (samples,), q, q', q'' (samples, n + 1) and contact forces (samples,)."""

    time: Array
    q: Array
    qd: Array
    qdd: Array
    normal_force: Array
    tangential_force: Array


class _Bending(NamedTuple):
    """At the points of the quadrature, (nq, samples): slope and its rate, axial displacement and its rate."""

    slopes: Array
    slope_rates: Array  # 1/s
    ux: Array  # m
    ux_dot: Array  # m/s


class _Tip(NamedTuple):
    """Displacements (m) of the tip and their rates (m/s), (samples,)."""

    ux: Array
    uy: Array
    ux_dot: Array
    uy_dot: Array


class _Forces(NamedTuple):
    """Forces on the points of the quadrature and, as the last row, on the tip: (nq + 1, samples)."""

    x: Array  # position in the frame (m)
    y: Array
    axial: Array  # N
    transverse: Array  # N


def fields_along(beam: Beam, motion: Motion, block: int = BLOCK) -> Fields:
    """Results at the stations for each sample of a motion.

    Parameters
    ----------
    beam : Beam
        The discretized beam; its tables are only multiplied with, so they may be sparse.
    motion : Motion
        Samples.  Where q'' is NaN the section forces are NaN.
    block : int
        Samples processed at a time: the working memory is a dozen arrays (quadrature points, block).

    Returns
    -------
    Fields
        Section forces at a station that carries a point force are those just inboard of it.
    """
    samples, stations = motion.time.size, beam.operators.stations.points.size
    result = Fields(*(np.empty((samples, stations)) for _ in Fields._fields))
    for start in range(0, samples, block):
        part = slice(start, start + block)
        for whole, rows in zip(result, _block(beam, Motion(*(v[part] for v in motion))), strict=True):
            whole[part] = rows
    return result


def curvature_moment(beam: Beam, q: Array) -> Array:
    """Bending moment E I u_y'' (N m) of the shapes at the stations, (samples, stations), from q (samples, n + 1).

    It converges to the moment of equilibrium in smooth motion, without the share of the material's damping.
    """
    stations = beam.operators.stations
    stiffness = beam.operators.sections.bending_stiffness(stations.points)
    return np.asarray(stiffness * (q[:, 1:] @ stations.curvatures.T))


def _block(beam: Beam, motion: Motion) -> Fields:
    o, stations = beam.operators, beam.operators.stations
    table, sections, cells = stations.quadrature, o.sections, stations.cells
    B = motion.q[:, 1:].T
    Bd = motion.qd[:, 1:].T
    slopes, slope_rates = table.slopes @ B, table.slopes @ Bd
    shortening, rate = -0.5 * beam.foreshortening * slopes**2, -beam.foreshortening * slopes * slope_rates
    ux, uy = _inboard(table, shortening, cells), stations.values @ B
    ux_dot, uy_dot = _inboard(table, rate, cells), stations.values @ Bd
    bending = _Bending(slopes, slope_rates, cumulative(table, shortening), cumulative(table, rate))
    tip = _Tip(ux[-1], uy[-1], ux_dot[-1], uy_dot[-1])
    forces = _forces(beam, motion, bending, tip)
    axial, transverse = _outboard(forces.axial, cells), _outboard(forces.transverse, cells)
    moment = _outboard(forces.x * forces.transverse - forces.y * forces.axial, cells)
    contact_axial, contact_transverse = _contact_force(beam, motion)
    at = int(np.argmin(np.abs(stations.points - o.contact_point)))
    inside = (np.arange(stations.points.size) <= at)[:, None]
    arms = sections.hub_radius + stations.points[:, None] + ux
    moment += inside * (arms[at] * contact_transverse - uy[at] * contact_axial)
    axial += inside * contact_axial
    transverse += inside * contact_transverse
    moment += uy * axial - arms * transverse
    slope = stations.slopes @ B
    shear = slope * axial - (1.0 - 0.5 * beam.foreshortening * slope**2) * transverse
    x = stations.points
    modulus = sections.fibre_distance(x) / sections.second_moment(x)
    return Fields(ux.T, uy.T, ux_dot.T, uy_dot.T, moment.T, shear.T, axial.T, modulus * moment.T)


def _forces(beam: Beam, motion: Motion, bending: _Bending, tip: _Tip) -> _Forces:
    """Gravity, inertia and external damping on the points of the quadrature and on the tip mass.

    Accelerations in the frame: a_a = x'' - theta'' y - 2 theta' y' - theta'^2 x and
    a_t = y'' + theta'' x + 2 theta' x' - theta'^2 y (primes are time derivatives).
    """
    o, s = beam.operators, beam.operators.sections
    table = o.stations.quadrature
    B, Bd, Bdd = (v[:, 1:].T for v in (motion.q, motion.qd, motion.qdd))
    (theta, spin, spin_rate), kept = (v[:, 0] for v in (motion.q, motion.qd, motion.qdd)), beam.foreshortening
    acceleration = -kept * (bending.slope_rates**2 + bending.slopes * (table.slopes @ Bdd))

    def with_tip(values: Array, last: Array) -> Array:
        return np.concatenate([values, np.reshape(last, (1, -1))])

    x = s.hub_radius + with_tip(table.points[:, None] + bending.ux, s.length + tip.ux)
    y = with_tip(table.values @ B, tip.uy)
    x_rate = with_tip(bending.ux_dot, tip.ux_dot)
    y_rate = with_tip(table.values @ Bd, tip.uy_dot)
    axial = with_tip(cumulative(table, acceleration), table.weights @ acceleration)
    axial += -spin_rate * y - 2.0 * spin * y_rate - spin**2 * x
    transverse = with_tip(table.values @ Bdd, o.stations.values[-1:] @ Bdd)
    transverse += spin_rate * x + 2.0 * spin * x_rate - spin**2 * y
    # damping proportional to mass is a load from outside; the other kinds act inside, as a share of the moment
    transverse += beam.scenario.beam.mass_proportional * y_rate
    gravity = beam.scenario.gravity
    masses = np.append(s.mass_per_length(table.points) * table.weights, s.tip_mass)[:, None]
    return _Forces(
        x, y, -masses * (axial + gravity * np.sin(theta)), -masses * (transverse + gravity * np.cos(theta))
    )


def _contact_force(beam: Beam, motion: Motion) -> tuple[Array, Array]:
    """Axial and transverse components (N) of the contact force in the frame, each (samples,)."""
    angle = motion.q[:, 0] - beam.scenario.slope.angle
    c, s = np.cos(angle), np.sin(angle)
    normal, tangential = motion.normal_force, motion.tangential_force
    return normal * s + tangential * c, normal * c - tangential * s


def _inboard(table: ShapeTable, integrand: Array, cells: Indices) -> Array:
    """Integrals from the root to the stations: (nq, samples) -> (stations, samples)."""
    between = np.add.reduceat(table.weights[:, None] * integrand, cells[:-1], axis=0)
    return np.concatenate([np.zeros_like(between[:1]), np.cumsum(between, axis=0)])


def _outboard(forces: Array, cells: Indices) -> Array:
    """Add up from the tip, the last row, inwards to the stations: (nq + 1, samples) -> (stations, samples)."""
    between = np.add.reduceat(forces, cells, axis=0)
    return np.asarray(np.cumsum(between[::-1], axis=0)[::-1])

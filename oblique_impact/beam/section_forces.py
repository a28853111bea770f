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

from oblique_impact.beam.beam import Beam
from oblique_impact.beam.operators import Array, ShapeTable

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


class _Points(NamedTuple):
    """A coordinate of the points of mass, its rate and its acceleration in the frame: (nq + 1, samples)."""

    place: Array  # m
    rate: Array
    acceleration: Array


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


def _block(beam: Beam, motion: Motion) -> Fields:
    o, stations, kept = beam.operators, beam.operators.stations, beam.foreshortening
    table, cells, sections = stations.quadrature, stations.cells, o.sections
    B, Bd, Bdd = (v[:, 1:].T for v in (motion.q, motion.qd, motion.qdd))
    slopes, rates = table.slopes @ B, table.slopes @ Bd
    # -u_x' of the axis, its rate and its acceleration
    shortening = 0.5 * kept * slopes**2, kept * slopes * rates, kept * (rates**2 + slopes * (table.slopes @ Bdd))
    ux, ux_dot = (-_inboard(table, values, cells) for values in shortening[:2])
    uy, uy_dot = stations.values @ B, stations.values @ Bd
    x, y = _Points(*(-beam.integrals(v) for v in shortening)), _Points(*map(beam.deflections, (B, Bd, Bdd)))
    x.place[:] += beam.masses[0][:, None]
    forces = _forces(beam, motion, x, y)
    axial, transverse = (_outboard(force, cells) for force in forces)
    moment = _outboard(x.place * forces[1] - y.place * forces[0], cells)
    contact_axial, contact_transverse = _contact_force(beam, motion)
    at = int(np.argmin(np.abs(stations.points - o.contact_point)))
    inside = (np.arange(stations.points.size) <= at)[:, None]
    arms = sections.hub_radius + stations.points[:, None] + ux
    moment += inside * (arms[at] * contact_transverse - uy[at] * contact_axial)
    axial += inside * contact_axial
    transverse += inside * contact_transverse
    moment += uy * axial - arms * transverse
    slope = stations.slopes @ B
    shear = slope * axial - (1.0 - 0.5 * kept * slope**2) * transverse
    modulus = sections.fibre_distance(stations.points) / sections.second_moment(stations.points)
    return Fields(ux.T, uy.T, ux_dot.T, uy_dot.T, moment.T, shear.T, axial.T, modulus * moment.T)


def _forces(beam: Beam, motion: Motion, x: _Points, y: _Points) -> tuple[Array, Array]:
    """Axial and transverse forces (N) of gravity, inertia and external damping on the points of mass.

    Accelerations in the frame: a_a = x'' - theta'' y - 2 theta' y' - theta'^2 x and
    a_t = y'' + theta'' x + 2 theta' x' - theta'^2 y (primes are time derivatives).
    """
    theta, spin, spin_rate = (v[:, 0] for v in (motion.q, motion.qd, motion.qdd))
    axial = x.acceleration - spin_rate * y.place - 2.0 * spin * y.rate - spin**2 * x.place
    transverse = y.acceleration + spin_rate * x.place + 2.0 * spin * x.rate - spin**2 * y.place
    # damping proportional to mass is a load from outside; the other kinds act inside, as a share of the moment
    transverse += beam.scenario.beam.mass_proportional * y.rate
    masses, gravity = beam.masses[1][:, None], beam.scenario.gravity
    return -masses * (axial + gravity * np.sin(theta)), -masses * (transverse + gravity * np.cos(theta))


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

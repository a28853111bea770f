"""Samples of a run, and the variables of a history computed from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from oblique_impact.beam.beam import Beam, Energies
from oblique_impact.beam.bent_beam import direction_of
from oblique_impact.beam.clearance import clearance_along
from oblique_impact.beam.section_forces import Motion, PointLoads, bent_beam, fields_along
from oblique_impact.contact.state import OBSERVED, State
from oblique_impact.contact.stops import elastic_stop
from oblique_impact.history.sample_times import ascending
from oblique_impact.history.variables import RATES_ALONG, SECTION_FORCES
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.records import Segment

#: an array of any kind of number with a row for each sample
Column = np.ndarray[Any, Any]

#: columns of `Samples.scalars`
GAP, SLIP, GAP_RATE, SLIP_RATE, LAMBDA_N, LAMBDA_T = range(len(OBSERVED))


class Samples(NamedTuple):
    """Samples of a run, each array with one row for each; d coordinates."""

    time: Array  # s
    q: Array  # (samples, d)
    qd: Array
    qdd: Array
    quadratures: Array  # integrals over time of forces and powers: see `oblique_impact.marching.equations`
    state: Column  # of int8, see `oblique_impact.contact.state.State`
    scalars: Array  # (samples, 6), see `oblique_impact.contact.state.OBSERVED`
    kinetic: Array  # J
    elastic: Array
    gravity: Array
    stored: Array  # J, in elastic stops and the flexibility behind the contacts
    stretched: Array  # J, in the axial flexibility behind the friction, which is taken to have lost it
    depth: Array  # m, compression of the stop itself
    contacts: Array  # (samples, n, 6) the scalars of each of n contacts
    compressed: Array  # (samples, n) m, compressions of stops at rest
    each: Column  # (samples, n) of int8, their states

    def variables(self) -> dict[str, Column]:
        """Return the variables of a history that every system has."""
        k, each = self.scalars, self.contacts
        return {
            "time": self.time,
            "q": self.q,
            "qd": self.qd,
            "gap": k[:, GAP],
            "slip": k[:, SLIP],
            "gap_rate": k[:, GAP_RATE],
            "slip_rate": k[:, SLIP_RATE],
            "depth": self.depth,
            "lambda_n": k[:, LAMBDA_N],
            "lambda_tau": k[:, LAMBDA_T],
            "state": self.state,
            "energy_kinetic": self.kinetic,
            "energy_elastic": self.elastic,
            "energy_gravity": self.gravity,
            "energy_contact": self.stored + self.stretched,
            "contact_gap": each[:, :, GAP],
            "contact_slip": each[:, :, SLIP],
            "contact_slip_rate": each[:, :, SLIP_RATE],
            "contact_lambda_n": each[:, :, LAMBDA_N],
            "contact_lambda_tau": each[:, :, LAMBDA_T],
            "contact_state": self.each,
        }


def gather(
    segments: Sequence[Segment],
    size: int,
    energies: Callable[[Array, Array, Array], Energies],
    transform: Callable[[Array], Array] | None = None,
) -> Samples:
    """Concatenate the samples of at least one segment.

    Each has `size` coordinates that were marched; `energies` takes times (samples,), coordinates and velocities
    (samples, size); `transform` maps coordinates linearly to those of the samples.
    """
    states = np.concatenate([s.states for s in segments])
    time = np.concatenate([s.times for s in segments])
    scalars = np.concatenate([s.nearest for s in segments])
    q, qd = states[:, :size], states[:, size : 2 * size]
    qdd = np.concatenate([s.observation.qdd for s in segments])
    if transform is not None:
        q, qd, qdd = transform(q), transform(qd), transform(qdd)
    found, depth = energies(time, q, qd), np.concatenate([s.depth for s in segments])
    stored, stretched = (np.concatenate([getattr(s, name) for s in segments]) for name in ("stored", "stretched"))
    contacts = np.concatenate([s.observation.contacts for s in segments])
    compressed = np.concatenate([s.observation.column("rest_compression") for s in segments])
    each = np.concatenate([s.each for s in segments])
    state, quadratures = each.max(axis=1), states[:, 2 * size :]
    return Samples(
        ascending(time),
        q,
        qd,
        qdd,
        quadratures,
        state,
        scalars,
        *found,
        stored,
        stretched,
        depth,
        contacts,
        compressed,
        each,
    )


def beam_variables(beam: Beam, samples: Samples, of_scenario: bool = True) -> dict[str, Column]:
    """Return the variables of the history of a beam, but for its :func:`section_forces`.

    Rates along it are left out too, and accelerations there, where both follow from few coordinates of the beam
    `of_scenario`, of which no part is user-defined.
    """
    s = samples
    bent, o = bent_beam(beam, s.q, s.qd), beam.operators
    touch = int(np.argmin(np.abs(o.stations.points - o.contact_point)))
    found = {**s.variables(), **bent.variables(touch, beam.scenario.contact_fibre), "station": o.stations.points}
    found |= _of_contacts(beam, s, found["tip_x"] + 1j * found["tip_y"])
    if of_scenario and s.q.shape[1] <= o.stations.points.size:
        found = {name: values for name, values in found.items() if name not in RATES_ALONG} | {"qdd": s.qdd}
    if beam.scenario.contact.enabled:
        on_side = [place.on_side for place in beam.candidates]
        found |= clearance_along(beam.scenario, o.sections, bent, found, on_side)
    return found


def section_forces(beam: Beam, qdd: Array, variables: Mapping[str, Column]) -> dict[str, Column]:
    """Return section forces and stress at stations, from accelerations (samples, d) and :func:`beam_variables`."""
    loads = PointLoads(*(variables[f"contact_{name}"] for name in PointLoads._fields))
    fields = fields_along(beam, Motion(variables["time"], variables["q"], variables["qd"], qdd, loads))
    return _places(variables) | {name: getattr(fields, name) for name in SECTION_FORCES}


def rates_along(beam: Beam, variables: Mapping[str, Column]) -> dict[str, Column]:
    """Return the rates of the displacements at stations, from coordinates and velocities."""
    rate = np.asarray(bent_beam(beam, variables["q"], variables["qd"]).rate)
    return _places(variables) | {"ux_dot": rate.real, "uy_dot": rate.imag}


def _places(variables: Mapping[str, Column]) -> dict[str, Column]:
    return {name: variables[name] for name in ("time", "station")}


def _of_contacts(beam: Beam, samples: Samples, contact_point: Column) -> dict[str, Column]:
    """Return the variables of n contacts of a beam with its contact point at x + i y (samples,) in m.

    A point r of the beam on a side has n.r = gap + c_n and t.r = slip + c_t; at an obstacle point c the beam's
    face is at c + (gap + radius) n, with the normal n of the axis.
    """
    o, places, numbers = beam.operators, beam.candidates, samples.contacts
    gap, slip = numbers[:, :, GAP], numbers[:, :, SLIP]
    place, points, normals = -slip, np.empty(gap.shape, dtype=complex), np.empty(gap.shape, dtype=complex)
    theta, B = samples.q[:, 0], samples.q[:, 1:]
    for i, at in enumerate(places):
        if at.on_side:
            place[:, i] = at.numbers[0]
            normals[:, i] = 1j * np.exp(1j * at.numbers[1])
            points[:, i] = normals[:, i] * (gap[:, i] + at.numbers[2] - 1j * (slip[:, i] + at.numbers[3]))
            continue
        assert o.along is not None
        x = np.clip(place[:, i], 0.0, o.sections.length)
        tangent = np.exp(1j * theta) * direction_of(np.einsum("sn,sn->s", o.along.derivative(x, 1), B))
        side, (cx, cy) = at.numbers[4], at.numbers[:2]
        normals[:, i] = 1j * side * tangent / np.abs(tangent)
        points[:, i] = cx + 1j * cy + (gap[:, i] + at.radius) * normals[:, i]
    if not beam.scenario.touches_anywhere:  # gap and slip may leave out the shortening of the contact point
        points = contact_point[:, None]
    along = np.array([1.0 if at.on_side else at.numbers[4] for at in places])
    tangential = numbers[:, :, LAMBDA_T].copy()
    for i, at in enumerate(places):
        if at.cell:
            bed = elastic_stop(at.stiffness, 0.0, at.extent, at.cell)
            pushes = bed.end_pushes(samples.compressed[:, i], slip[:, i])
            tangential[:, i] += np.where(samples.each[:, i] != State.FREE, pushes, 0.0)
    force = normals * (numbers[:, :, LAMBDA_N] - 1j * along * tangential)
    return contact_variables([at.obstacle for at in places], place, points, force)


def contact_variables(obstacles: Sequence[int], place: Column, points: Column, force: Column) -> dict[str, Column]:
    """Return the variables of n contacts of a beam with obstacles (n,), each (samples, n).

    They are at places along the beam (m) and at points x + i y (m), the force is that on the beam (N).
    """
    return {
        "contact_obstacle": np.array(obstacles, dtype=np.int16),
        "contact_place": place,
        "contact_x": points.real,
        "contact_y": points.imag,
        "contact_fx": force.real,
        "contact_fy": force.imag,
    }

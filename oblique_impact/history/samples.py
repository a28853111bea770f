"""Samples of a run, and the variables of a history computed from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from oblique_impact.beam.beam import Beam, Energies
from oblique_impact.beam.clearance import beam_clearance, slope_warnings
from oblique_impact.beam.section_forces import Motion, displacements_along, fields_along
from oblique_impact.beam.small_deflection import deflection_warnings, largest_motion
from oblique_impact.contact.state import Instant
from oblique_impact.history.sample_times import ascending
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.records import Segment

#: an array of any kind of number with a row for each sample
Column = np.ndarray[Any, Any]

#: columns of `Samples.scalars`
GAP, SLIP, GAP_RATE, SLIP_RATE = range(4)
LAMBDA_N, LAMBDA_T = Instant._fields.index("normal_force"), Instant._fields.index("tangential_force")


class Samples(NamedTuple):
    """Samples of a run, each array with one row for each; d coordinates."""

    time: Array  # s
    q: Array  # (samples, d)
    qd: Array
    qdd: Array
    quadratures: Array  # integrals over time of forces and powers: see `oblique_impact.marching.equations`
    state: Column  # of int8, see `oblique_impact.contact.state.State`
    scalars: Array  # see `oblique_impact.contact.state.Instant`
    kinetic: Array  # J
    elastic: Array
    gravity: Array
    depth: Array  # m, compression of the stop itself

    def variables(self) -> dict[str, Column]:
        """Return the variables of a history that every system has."""
        k = self.scalars
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
    state = np.repeat(np.array([s.state for s in segments], dtype=np.int8), [s.times.size for s in segments])
    scalars = np.concatenate([s.observation.instants for s in segments])
    q, qd = states[:, :size], states[:, size : 2 * size]
    qdd = np.concatenate([s.observation.qdd for s in segments])
    if transform is not None:
        q, qd, qdd = transform(q), transform(qd), transform(qdd)
    found, depth = energies(time, q, qd), np.concatenate([s.depth for s in segments])
    return Samples(ascending(time), q, qd, qdd, states[:, 2 * size :], state, scalars, *found, depth)


def beam_variables(beam: Beam, samples: Samples, section_forces: bool = True) -> dict[str, Column]:
    """Return the variables of the history of a beam, along it only displacements without `section_forces`."""
    s = samples
    found = {**s.variables(), **_at_the_contact(beam, s), "station": beam.operators.stations.points}
    if section_forces:
        forces = s.scalars[:, LAMBDA_N], s.scalars[:, LAMBDA_T]
        found |= fields_along(beam, Motion(s.time, s.q, s.qd, s.qdd, *forces))._asdict()
    else:
        along = displacements_along(beam, s.q, s.qd)
        found |= dict(zip(("ux", "uy", "ux_dot", "uy_dot"), along, strict=True))
    if beam.scenario.contact.enabled:
        found["clearance"], found["clearance_at"] = beam_clearance(beam, s.q, found["ux"], found["uy"])
    return found


def _at_the_contact(beam: Beam, samples: Samples) -> dict[str, Array]:
    """Return the variables of the frame and the contact point of a beam; the deflection is that of the axis."""
    o, fibre = beam.operators, beam.scenario.contact_fibre
    radius = o.sections.hub_radius + o.contact_point
    theta, B, Bd = samples.q[:, 0], samples.q[:, 1:], samples.qd[:, 1:]
    HB = beam.foreshortening * (B @ o.contact_shortening)
    ux, ux_rate = -0.5 * np.einsum("si,si->s", HB, B), -np.einsum("si,si->s", HB, Bd)
    uy, uy_rate = B @ o.contact_shape, Bd @ o.contact_shape
    spin, sine, cosine = samples.qd[:, 0], np.sin(theta), np.cos(theta)
    # the section there is turned by phi, and the contact point at the height `fibre` in it
    phi, phi_rate = B @ o.contact_slope, Bd @ o.contact_slope
    arm, lift = radius + ux - fibre * phi, uy + fibre * (1.0 - 0.5 * beam.foreshortening * phi**2)
    axial = ux_rate - fibre * phi_rate - spin * lift
    transverse = uy_rate - fibre * beam.foreshortening * phi * phi_rate + spin * arm
    return {
        "theta": theta,
        "theta_dot": spin,
        "tip_x": arm * cosine - lift * sine,
        "tip_y": arm * sine + lift * cosine,
        "tip_vx": axial * cosine - transverse * sine,
        "tip_vy": axial * sine + transverse * cosine,
        "deflection": uy,
        "shortening": ux,
    }


def range_warnings(beam: Beam, variables: Mapping[str, Array], passages: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return warnings about ranges of validity; `passages` are those of the summary's `slope_ends`."""
    touched = bool(np.any(variables["state"] > 0))
    return [
        *slope_warnings(beam.scenario, variables, passages),
        *deflection_warnings(beam.scenario, largest_motion(beam, variables), touched),
    ]

"""What the record of a run becomes: labelled variables and a summary."""

from __future__ import annotations

import platform
from collections.abc import Callable, Sequence
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
import xarray as xr

from oblique_impact.beam import Beam, Energies
from oblique_impact.contact import State
from oblique_impact.fields import Fields, Motion
from oblique_impact.history import labelled
from oblique_impact.ledger import balance, macro_collisions
from oblique_impact.marching import Record, Segment
from oblique_impact.stops import Stop
from oblique_impact.system import GAP, GAP_RATE, LAMBDA_N, LAMBDA_T, SLIP, SLIP_RATE, Array

_REPORTED_PACKAGES = ("oblique-impact", "numpy", "scipy", "numba", "scikit-fem", "xarray")


class Samples:
    """All samples of a record in one piece."""

    def __init__(self, segments: Sequence[Segment], size: int) -> None:
        states = np.concatenate([s.states for s in segments])
        self.time = np.concatenate([s.times for s in segments])
        self.q, self.qd = states[:, :size].copy(), states[:, size : 2 * size].copy()
        self.quadratures = states[:, 2 * size :]
        self.state = np.concatenate([np.full(s.times.size, s.state, dtype=np.int8) for s in segments])
        self.qdd = np.concatenate([s.observation.qdd for s in segments])
        self.scalars = np.concatenate([s.observation.scalars for s in segments])

    def transform(self, linear: Callable[[Array], Array]) -> None:
        """Replace the coordinates by a linear map of them."""
        self.q, self.qd, self.qdd = linear(self.q), linear(self.qd), linear(self.qdd)

    def motion(self) -> Motion:
        """Return the samples as the beam's post-processing takes them."""
        return Motion(self.time, self.q, self.qd, self.qdd, self.scalars[:, LAMBDA_N], self.scalars[:, LAMBDA_T])

    def dataset(self, energies: Energies) -> xr.Dataset:
        """Variables that every system has."""
        k, one, each = self.scalars, ("time",), ("time", "coordinate")
        state = labelled(self.state, one, "1", "contact state")
        state.attrs["flag_values"] = np.array([int(s) for s in State], dtype=np.int8)
        state.attrs["flag_meanings"] = " ".join(s.name.lower() for s in State)
        return xr.Dataset(
            {
                "q": labelled(self.q, each, "m or rad", "generalized coordinates"),
                "qd": labelled(self.qd, each, "m/s or rad/s", "generalized velocities"),
                "gap": labelled(k[:, GAP], one, "m", "normal gap"),
                "slip": labelled(k[:, SLIP], one, "m", "tangential position on the slope"),
                "gap_rate": labelled(k[:, GAP_RATE], one, "m/s", "gap rate"),
                "slip_rate": labelled(k[:, SLIP_RATE], one, "m/s", "slip velocity"),
                "lambda_n": labelled(k[:, LAMBDA_N], one, "N", "normal contact force"),
                "lambda_tau": labelled(k[:, LAMBDA_T], one, "N", "tangential contact force"),
                "state": state,
                "energy_kinetic": labelled(energies.kinetic, one, "J", "kinetic energy"),
                "energy_elastic": labelled(energies.elastic, one, "J", "elastic energy"),
                "energy_gravity": labelled(energies.gravity, one, "J", "gravity energy"),
            },
            coords={"time": labelled(self.time, one, "s", "time")},
        )


def beam_variables(beam: Beam, samples: Samples, fields: Fields) -> xr.Dataset:
    """Variables that a beam has besides: its frame, its contact point, and the results along it."""
    o = beam.operators
    radius = o.hub_radius + o.contact_point
    theta, B, Bd = samples.q[:, 0], samples.q[:, 1:], samples.qd[:, 1:]
    flat = 0.0 if beam.scenario.discretization.kinetics == "zeroth-order" else 1.0
    HB = flat * (B @ o.contact_shortening)
    ux, ux_rate = -0.5 * np.einsum("si,si->s", HB, B), -np.einsum("si,si->s", HB, Bd)
    uy, uy_rate = B @ o.contact_shape, Bd @ o.contact_shape
    spin, sine, cosine = samples.qd[:, 0], np.sin(theta), np.cos(theta)
    axial, transverse = ux_rate - spin * uy, uy_rate + spin * (radius + ux)
    arm = radius + ux
    one, along = ("time",), ("time", "station")
    return xr.Dataset(
        {
            "theta": labelled(theta, one, "rad", "angle of the floating frame"),
            "theta_dot": labelled(spin, one, "rad/s", "angular velocity of the floating frame"),
            "tip_x": labelled(arm * cosine - uy * sine, one, "m", "contact point, inertial x"),
            "tip_y": labelled(arm * sine + uy * cosine, one, "m", "contact point, inertial y"),
            "tip_vx": labelled(axial * cosine - transverse * sine, one, "m/s", "contact point velocity, x"),
            "tip_vy": labelled(axial * sine + transverse * cosine, one, "m/s", "contact point velocity, y"),
            "deflection": labelled(uy, one, "m", "transverse deflection of the contact point"),
            "shortening": labelled(ux, one, "m", "axial displacement of the contact point (foreshortening)"),
            "ux": labelled(fields.ux, along, "m", "axial displacement in the floating frame"),
            "uy": labelled(fields.uy, along, "m", "transverse displacement in the floating frame"),
            "ux_dot": labelled(fields.ux_dot, along, "m/s", "rate of ux in the floating frame"),
            "uy_dot": labelled(fields.uy_dot, along, "m/s", "rate of uy in the floating frame"),
            "moment": labelled(fields.moment, along, "N m", "bending moment"),
            "shear": labelled(fields.shear, along, "N", "shear force, slope of the bending moment"),
            "axial_force": labelled(fields.axial_force, along, "N", "axial force, tension positive"),
            "bending_stress": labelled(fields.bending_stress, along, "Pa", "bending stress at the outer fibre"),
        },
        coords={"station": labelled(o.stations.points, ("station",), "m", "arc length from the root")},
    )


def summarize(
    record: Record, samples: Samples, energies: Energies, wall: float, stop: Stop | None
) -> dict[str, Any]:
    """Return summary.json of a run that took `wall` seconds (without a beam's warnings)."""
    parts = [float(e[-1]) for e in energies]
    stored = stop.energy(float(samples.scalars[-1, GAP])) if stop and samples.state[-1] != State.FREE else 0.0
    ledger = balance(
        float(sum(e[0] for e in energies)),
        (parts[0], parts[1], parts[2], stored),
        samples.quadratures[-1],
        record.events,
    )
    return {
        "outcome": record.outcome.label,
        "message": record.outcome.sentence,
        "end_time": float(samples.time[-1]),
        "macro_collisions": [asdict(m) for m in macro_collisions(record.contacts)],
        "events": len(record.events),
        "energy": ledger.as_dict(),
        "steps": record.steps,
        "rejected_steps": record.rejected,
        "wall_time": wall,
        "versions": {"python": platform.python_version(), **_versions()},
    }


def _versions() -> dict[str, str]:
    found = {}
    for name in _REPORTED_PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def warnings_of(beam: Beam, samples: Samples) -> list[str]:
    """Say where the model leaves its range of validity."""
    largest = float(np.max(np.abs(samples.q[:, 1:] @ beam.operators.stations.values.T), initial=0.0))
    length = beam.scenario.beam.length
    if largest > 0.1 * length:
        return [
            f"largest deflection {largest:.3g} m is more than a tenth of the length: "
            "the small-deflection model is stretched beyond its range"
        ]
    return []

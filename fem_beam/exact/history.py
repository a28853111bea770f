"""The history of a run in absolute coordinates: the variables of all methods, in the scenario's floating frame."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.interpolate import KroghInterpolator

from oblique_impact.beam.base_motion import BaseMotion
from oblique_impact.beam.clearance import smallest_distance
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.operators import station_points
from oblique_impact.contact.state import Instant, State
from oblique_impact.fem_beam.exact.beam import NODE, Complex, ExactBeam
from oblique_impact.fem_beam.exact.run import Run
from oblique_impact.fem_beam.exact.sections import Array, ElasticSections
from oblique_impact.history.history import History, beam_history
from oblique_impact.history.sample_times import ascending
from oblique_impact.history.samples import GAP, Column, Samples
from oblique_impact.marching.loop import Status
from oblique_impact.scenario.scenario import Scenario

#: samples that are processed at a time
_BLOCK = 512
#: Gauss points through which section forces are read at a station
_NEAREST = 4
#: iterations for the mean axis with a hub: the angle is small, each squares the error
_NEWTON = 6


def simulate(
    scenario: Scenario,
    on_progress: Callable[[Status], None] | None = None,
    sections: ElasticSections | None = None,
    motion: BaseMotion | None = None,
) -> History:
    """Run a scenario with the beam in absolute coordinates and return its history, whatever the outcome.

    Coordinates `q` are places (m) and rotation (rad) of the nodes, [x, y, phi] node by node from the root; all
    other variables mean what they mean for every method: `theta` is the rotation of the first section in the
    tangent frame, or that of the mean axis, and displacements are those in this frame.  `sections` and the
    `motion` of a driven root replace those of the scenario.
    """
    # overflow in a step is handled: the iterations do not converge
    with np.errstate(all="ignore"):
        run, started = Run(scenario, on_progress, sections, motion), time.perf_counter()
        run.execute()
        wall = time.perf_counter() - started
        return _Frame(run).history(wall)


class _Stations(NamedTuple):
    """Matrices from nodes to values and slopes, and from Gauss points to section forces, at output stations."""

    x: Array
    values: Array  # (stations, nodes)
    slopes: Array
    recovery: Array  # (stations, Gauss points)


def stations_of(beam: ExactBeam, x: Array, point: float) -> _Stations:
    """Read the elements at places x (m).

    Section forces are polynomials through the nearest Gauss points, where they are most accurate, on the near side
    of the contact point: there the shear force jumps.
    """
    values, slopes = np.zeros((2, x.size, beam.x.size))
    gauss = beam.points.ravel()
    recovery = np.zeros((x.size, gauss.size))
    for row, place in enumerate(x):
        e = max(0, int(np.searchsorted(beam.ends, place * (1.0 - 1e-12))) - 1)
        nodes = np.arange(2 * e, 2 * e + 3)
        shapes = _lagrange(beam.x[nodes])
        values[row, nodes], slopes[row, nodes] = shapes(place), shapes.derivative(place)
        inboard = place <= point * (1.0 + 1e-12)
        side = np.flatnonzero((gauss < point) == inboard)
        chosen = side[np.sort(np.argsort(np.abs(gauss[side] - place), kind="stable")[:_NEAREST])]
        recovery[row, chosen] = _lagrange(gauss[chosen])(place)
    return _Stations(x, values, slopes, recovery)


def _lagrange(nodes: Array) -> KroghInterpolator:
    """Lagrange polynomials of some nodes."""
    return KroghInterpolator(nodes, np.eye(nodes.size))


class _Frame:
    """The samples of a run, seen from the floating frame of its scenario."""

    def __init__(self, run: Run) -> None:
        self.run, self.scenario, self.beam = run, run.scenario, run.beam
        self.q = np.array([sample.stage.q for sample in run.samples])
        self.v = np.array([sample.stage.v for sample in run.samples])
        self.time = ascending(np.array([sample.time for sample in run.samples]))
        s = self.scenario
        self.sections = Sections.from_scenario(s)
        self.stations = stations_of(self.beam, station_points(s.beam.length, s.contact.point), s.contact.point)

    def history(self, wall: float) -> History:
        """Return the history; `wall` is the time of the marching (s)."""
        samples = self._samples()
        variables = {**samples.variables(), **self._at_the_contact(), **self._along(), "station": self.stations.x}
        return beam_history(self.scenario, self.run.record, samples, variables, self.section_forces, wall)

    def _samples(self) -> Samples:
        run = self.run
        instants = [
            Instant(*sample.place)._replace(
                normal_force=sample.normal_force, tangential_force=sample.tangential_force
            )
            for sample in run.samples
        ]
        quadratures = np.zeros((len(run.samples), len(run.totals)))
        quadratures[-1] = run.totals
        state = np.array([int(sample.state) for sample in run.samples], dtype=np.int8)
        weight = self.beam.weight(self.scenario.gravity)
        energies = self.beam.kinetic_energy(self.v), self.beam.elastic_energy(self.q), -self.q @ weight
        none, scalars = np.zeros((len(run.samples), 0)), np.array(instants)
        depth = np.where(state == State.FREE, 0.0, np.maximum(0.0, -scalars[:, GAP]))
        return Samples(self.time, self.q, self.v, none, quadratures, state, scalars, *energies, depth)

    @cached_property
    def frame(self) -> tuple[Array, Array]:
        """Angle (rad) and angular velocity (rad/s) of the floating frame at the samples."""
        if self.scenario.discretization.frame == "tangent":
            return self.q[:, 2], self.v[:, 2]
        # the mean axis: int m (r + x) u_y dx = 0 with the turn of the hub, + J_h (phi(0) - theta)
        static = (self.beam.M[::NODE, ::NODE] @ (self.beam.radius + self.beam.x)).astype(complex)
        sums, rates = _complex(self.q) @ static, _complex(self.v) @ static
        near, hub = self.q[:, 2::NODE].mean(axis=1), self.sections.hub_inertia
        theta = near + np.angle(sums * np.exp(-1j * near))
        for _ in range(_NEWTON if hub > 0.0 else 0):
            turned = sums * np.exp(-1j * theta)
            theta = theta + (turned.imag + hub * (self.q[:, 2] - theta)) / (turned.real + hub)
        turned, turning = sums * np.exp(-1j * theta), rates * np.exp(-1j * theta)
        return theta, (turning.imag + hub * self.v[:, 2]) / (turned.real + hub)

    def _displacement(self, weights: Array, x: Array) -> tuple[Complex, Complex]:
        """Displacements u_x + i u_y (m) and their rates in the frame, of places that `weights` take from nodes."""
        theta, spin = (values[:, None] for values in self.frame)
        r = np.exp(-1j * theta) * (_complex(self.q) @ weights.T)
        rate = np.exp(-1j * theta) * (_complex(self.v) @ weights.T) - 1j * spin * r
        return r - (self.beam.radius + x), rate

    def _at_the_contact(self) -> dict[str, Column]:
        node = self.run.slope.node
        unit = np.eye(1, self.beam.x.size, node)
        u, _ = self._displacement(unit, self.beam.x[node : node + 1])
        # of the contact point in the section
        lever = 1j * self.run.slope.fibre * np.exp(1j * self.q[:, NODE * node + 2])
        place = _complex(self.q)[:, node] + lever
        velocity = _complex(self.v)[:, node] + 1j * self.v[:, NODE * node + 2] * lever
        theta, spin = self.frame
        return {
            "theta": theta,
            "theta_dot": spin,
            "tip_x": place.real,
            "tip_y": place.imag,
            "tip_vx": velocity.real,
            "tip_vy": velocity.imag,
            "deflection": u[:, 0].imag,
            "shortening": u[:, 0].real,
        }

    def _along(self) -> dict[str, Column]:
        """Displacements along the beam, each (samples, stations), and the distance from the slope."""
        t = self.stations
        u, rate = self._displacement(t.values, t.x)
        found: dict[str, Column] = {"ux": u.real, "uy": u.imag, "ux_dot": rate.real, "uy_dot": rate.imag}
        if self.scenario.contact.enabled:
            places, section = _complex(self.q), None
            if self.scenario.contact.surface == "section":
                phi = self.q[:, 2::NODE]
                turn = np.exp(1j * (phi @ t.values.T))
                section = turn, 1j * (phi @ t.slopes.T) * turn
            axis = places @ t.values.T, places @ t.slopes.T
            found["clearance"], found["clearance_at"], _ = smallest_distance(self.scenario, t.x, axis, section)
        return found

    def section_forces(self) -> dict[str, Column]:
        """Section forces and bending stress, each (samples, stations), of samples at stations."""
        with np.errstate(all="ignore"):  # as in the run, which may have diverged
            parts = [self._section_forces(slice(k, k + _BLOCK)) for k in range(0, len(self.q), _BLOCK)]
        found: dict[str, Column] = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        x = self.stations.x
        modulus = self.sections.fibre_distance(x) / self.sections.second_moment(x)
        return found | {"bending_stress": modulus * found["moment"], "time": self.time, "station": x}

    def _section_forces(self, part: slice) -> dict[str, Array]:
        """Moment, its slope along the beam, and the force along the frame's axis, of some samples.

        M' = -Im(conj(r') f) with the force f = exp(i phi) (N + i Q) in the inertial frame; the moment that turns
        the sections themselves is left out.
        """
        kept = [sample.forces for sample in self.run.samples[part]]
        fields, samples = self.beam.fields(self.q[part]), len(kept)
        force = np.exp(1j * fields.rotation) * np.array([forces.force for forces in kept])
        shear = -np.imag(fields.tangent.conj() * force)
        axial = np.real(np.exp(-1j * self.frame[0][part, None, None]) * force)
        moment = np.array([forces.moment for forces in kept])
        by_name = {"moment": moment, "shear": shear, "axial_force": axial}
        return {name: f.reshape(samples, -1) @ self.stations.recovery.T for name, f in by_name.items()}


def _complex(q: Array) -> Complex:
    """Places (samples, nodes) as complex numbers."""
    return q[:, 0::NODE] + 1j * q[:, 1::NODE]

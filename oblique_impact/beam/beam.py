"""The beam of a scenario, reduced or in all its nodes: its compiled model, energies and residual flexibility."""

from __future__ import annotations

from dataclasses import asdict
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import block_diag, eigh
from scipy.sparse import issparse

from oblique_impact.beam import floating_frame, nodal_frame
from oblique_impact.beam.axis import PLACE, Places, ShapeFunctions, place_record
from oblique_impact.beam.base_motion import BaseMotion, SpinUp, base_motion_of
from oblique_impact.beam.bent_beam import BentBeam
from oblique_impact.beam.floating_frame import BeamModel, FullBeamModel
from oblique_impact.beam.hermite import HermiteShapes
from oblique_impact.beam.nodal_frame import NodalModel, NodalPlaces
from oblique_impact.beam.operators import Array, BeamOperators, Matrix, cumulative
from oblique_impact.beam.point_forces import NO_FORCES, PointForces, force_in_frame, forces_of
from oblique_impact.beam.residual_flexibility import FlexibilityAlong, flexibility_along, residual_flexibility
from oblique_impact.beam.shaking import STILL, Shaking, shaking_of, weight_in_frame
from oblique_impact.contact.compliance import Compliance
from oblique_impact.errors import InputError
from oblique_impact.kernels.banded import HALF_BANDWIDTH
from oblique_impact.kernels.workspace import VECTORS, own_numbers, record_of
from oblique_impact.scenario.consistency import TOUCHING
from oblique_impact.scenario.scenario import Scenario

_STIFFENED = 1e-3  # of the mass, small against it and far above rounding
_TABLE = 257  # places at which the axial flexibility of a beam that is not uniform is known
_ROOTS = {"pin": floating_frame.PIN, "hub": floating_frame.HUB, "driven": floating_frame.DRIVEN}


class ContactPlace(NamedTuple):
    """A place where a beam can touch an obstacle."""

    obstacle: int  # the slope is 0, the others count from 1
    on_side: bool  # a point of the beam on a side; else a point of an obstacle on the beam
    numbers: tuple[float, ...]  # (6,) see `oblique_impact.beam.axis.place_record`
    extent: tuple[float, ...]  # m, of the slip
    stiffness: float  # N/m, of an elastic stop
    radius: float = 0.0  # m, of a peg
    cell: float = 0.0  # m, of the beam that bears on a bedding; the stiffness is that of the bed under all of it
    behind: bool = False  # whether a point of the beam starts behind the line of a side of an outline


def contact_places(scenario: Scenario, foreshortening: float = 1.0) -> list[ContactPlace]:
    """Return the places that a run follows, at least one: the contact point over the slope, or of the whole beam.

    Of the whole beam they are its points on each side and each obstacle point on it; without contact it is the
    contact point, which never touches.  `foreshortening` is 0 where terms of second order are left out.
    """
    s, found = scenario, list[ContactPlace]()
    if not s.touches_anywhere:
        fibre = s.contact_fibre
        numbers = s.contact.point, s.slope.angle, *s.slope.offsets, fibre, foreshortening * fibre
        return [ContactPlace(0, True, numbers, s.slope.extent, s.contact.stiffness)]
    length, reach, outlines = s.beam.length, s.root.hub_radius, s.outlines
    for side in s.sides:
        for place in s.beam_points:
            fibre = side.facing(s.initial.angle) * s.half_depth_at(place)
            numbers = place, side.angle, *side.offsets, fibre, foreshortening * fibre
            cell = s.cell_on(side, place)
            stiffness = side.bedding * sum(cell) if side.bedding else side.stiffness
            extent, behind = side.lengthened(cell).extent, False
            if side.obstacle in outlines:  # in none of which it is
                gap, _ = side.gap_and_place(reach + place, s.initial.angle, s.half_depth_at(place), s.root_axis)
                behind = gap < -TOUCHING * length
            found.append(
                ContactPlace(side.obstacle, True, numbers, extent, stiffness, cell=sum(cell), behind=behind)
            )
    preloaded = s.preloaded_sides
    for point in s.obstacle_points:
        seen = point.seen_from(s.root_axis, s.initial.angle)
        depth = s.half_depth_at(float(np.clip(seen.real - reach, 0.0, length)))
        sense = -np.copysign(1.0, seen.imag)
        if point.corner and point.obstacle in preloaded:
            sense = preloaded[point.obstacle]
        numbers = point.x, point.y, point.radius + depth, depth, sense, 0.0
        found.append(ContactPlace(point.obstacle, False, numbers, (-length, 0.0), point.stiffness, point.radius))
    return found


class Energies(NamedTuple):
    """Energies (J), each of shape (samples,)."""

    kinetic: Array
    elastic: Array
    gravity: Array


class ElasticModes(NamedTuple):
    """Elastic modes of the beam with its root, and how fast damping by mass and by mode takes their velocities.

    A root that is free to turn does so in these modes, by theta = -c.B/J with coupling c and inertia J of beam and
    hub: in the mass [J, c; c^T, M_B] they are orthogonal to the swing, which is theta alone.  Their mass is then
    M_B - c c^T/J in the rows of B and nothing in that of theta, in any frame: the swing is not damped.  On a
    spring to the ground it is, by mode, see `Beam._modes_on_spring`.
    """

    mass: Array  # (n, n) kg
    modes: Array  # (n, n) of the modal mass 1
    rates: Array  # (n,) 1/s, mass_proportional + 2 modal_damping_ratio omega

    @classmethod
    def of(cls, scenario: Scenario, operators: BeamOperators) -> ElasticModes:
        """Take the modes of dense operators."""
        beam, o = scenario.beam, operators
        mass = o.elastic_mass
        if scenario.root.kind != "driven":
            mass = mass - np.outer(o.coupling, o.coupling) / o.inertia
        squares, modes = eigh(o.stiffness, mass)
        ratio = 0.0 if _is_on_spring(scenario) else beam.modal_damping_ratio
        return cls(mass, modes, beam.mass_proportional + 2.0 * ratio * np.sqrt(np.maximum(squares, 0.0)))

    def damping_matrix(self) -> Array:
        """Return the matrix (n, n) of this damping."""
        share = self.mass @ self.modes
        return np.asarray((share * self.rates) @ share.T)

    def slowed(self, velocities: Array) -> Array:
        """Return the rates (n, samples) by which this damping slows velocities (n, samples)."""
        return np.asarray((self.modes * self.rates) @ (self.modes.T @ (self.mass @ velocities)))


def _is_on_spring(s: Scenario) -> bool:
    """Whether a hub is on a spring to the ground."""
    return s.root.kind == "hub" and s.root.stiffness > 0.0


class Beam:
    """A discretized beam with its root, load and slope, in the coordinates q = [theta, B] of its floating frame.

    Parameters
    ----------
    scenario : Scenario
        What to simulate.
    operators : BeamOperators
        The discretization's operators for the same scenario.
    motion : BaseMotion, optional
        How the root turns if it is driven; by default as the scenario says.
    """

    def __init__(self, scenario: Scenario, operators: BeamOperators, motion: BaseMotion | None = None) -> None:
        self.scenario, self.operators = scenario, operators
        self.motion = motion or base_motion_of(scenario.root)

    @property
    def size(self) -> int:
        """Coordinates that are marched."""
        return self.operators.size + 1

    @property
    def mass(self) -> float:
        """Mass (kg), point masses included."""
        return self.operators.sections.mass

    @property
    def foreshortening(self) -> float:
        """1, or 0 in zeroth-order kinetics, which leave the foreshortening out."""
        return 0.0 if self.scenario.discretization.kinetics == "zeroth-order" else 1.0

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times (s) at which the motion of root or base or a force is not smooth."""
        given = (self.motion, self.shaking, self.forces)
        return tuple(time for part in given if part is not None for time in part.breakpoints)

    @cached_property
    def shaking(self) -> Shaking | None:
        """How the base is shaken; None if it stands still."""
        return shaking_of(self.scenario)

    @cached_property
    def forces(self) -> PointForces | None:
        """Forces on the beam; None if there are none."""
        return forces_of(self.scenario, self.foreshortening)

    @cached_property
    def model(self) -> BeamModel | NodalModel:
        """The compiled model, a :class:`~oblique_impact.kernels.system.System`."""
        s, o, kept = self.scenario, self.operators, self.foreshortening
        frame = floating_frame
        full = s.discretization.kinetics == "full"
        inverse = np.linalg.inv(o.elastic_mass)
        matrices = {
            frame.ELASTIC_MASS: o.elastic_mass,
            frame.SPIN_STIFFNESS: o.M1 - kept * o.C,
            frame.STIFFNESS: o.stiffness,
            frame.DAMPING: self._damping_matrix(),
            frame.GRAVITY_STIFFNESS: kept * o.D,
            frame.MASS_INVERSE: 0.5 * (inverse + inverse.T),
        }
        vectors = {
            frame.COUPLING: o.coupling,
            frame.LOAD: o.P,
            frame.ROOT_SLOPE: o.root_slope,
            frame.FOLLOWING: -inverse @ o.coupling * (s.root.kind != "driven"),
        }
        numbers = {
            "root": _ROOTS[s.root.kind],
            "inertia": o.inertia,
            "static_moment": o.Sm,
            "gravity": s.gravity,
            "hub_radius": s.root.hub_radius,
            "torque": self._torque,
            **(asdict(self.motion) if isinstance(self.motion, SpinUp) else {}),
        }
        return (FullBeamModel if full else BeamModel)(
            numbers=record_of(frame.BEAM_NUMBERS, numbers),
            matrices=np.array([matrices[k] for k in sorted(matrices)]),
            vectors=np.array([vectors[k] for k in sorted(vectors)]),
            places=self._places(),
            drive=self.motion.drive,
            shaking=self.shaking or STILL,
            quadrature=self._quadrature() if full else None,
            ground=self._ground(),
            loads=self._loads(),
        )

    def _loads(self) -> floating_frame.Loads:
        """Return the forces on the beam with the shape functions where they act."""
        tables = [np.vstack([shortening, values, slopes]) for values, slopes, shortening in self._shapes_at_forces]
        n = self.operators.P.size
        return floating_frame.Loads(
            self.forces or NO_FORCES, Places(self._loaded_places, np.array(tables).reshape(-1, n + 2, n), None)
        )

    @cached_property
    def _shapes_at_forces(self) -> list[tuple[Array, Array, Array]]:
        """Shape functions, slopes (n,) and H (n, n) at the places of forces."""
        return [self._along.at(place) for place in self.forces.places] if self.forces is not None else []

    @property
    def _loaded_places(self) -> Any:
        """Records of the places of forces, on the axis."""
        places = (self.forces or NO_FORCES).places
        found = [place_record(True, (place, *np.zeros(5)), self.foreshortening) for place in places]
        return np.array(found, PLACE).view(np.recarray)

    def _ground(self) -> floating_frame.GroundSpring:
        """Spring and dashpot between hub and ground."""
        root, turn = self.scenario.root, np.append(1.0, self.operators.root_slope)
        if root.kind != "hub" or root.stiffness == root.damping == 0.0:
            return floating_frame.NO_GROUND
        share, damping = np.outer(turn, turn), np.zeros((turn.size, turn.size))
        if self._modes_on_spring is not None:
            damping = self._modes_on_spring.damping_matrix()
        return floating_frame.GroundSpring(
            root.stiffness * share, root.damping * share + damping, self.scenario.initial.angle
        )

    def _quadrature(self) -> floating_frame.Quadrature:
        """Points of the beam for the exact kinetic energy."""
        slopes, (inertias, turned) = self.operators.stations.quadrature.slopes, self.operators.turning
        shortening = self.integrals(slopes[:, :, None] * slopes[:, None])
        shapes = self.deflections(np.eye(self.operators.size))
        return floating_frame.Quadrature(
            self.masses, shapes, shortening, inertias, np.insert(turned, 0, 1.0, axis=1)
        )

    @property
    def _torque(self) -> float:
        """Torque (N m) on the hub."""
        return self.scenario.root.torque if self.scenario.root.kind == "hub" else 0.0

    @cached_property
    def candidates(self) -> list[ContactPlace]:
        """Places that a run follows, see :func:`contact_places`."""
        return contact_places(self.scenario, self.foreshortening)

    @cached_property
    def compliance(self) -> Compliance | None:
        """Compliance of the beam between all places of contact, without mass; None if it has none."""
        s, sides = self.scenario, np.array([place.on_side for place in self.candidates])
        across, along = self._residual_flexibility(), self._axial_flexibility()
        if across is None and along is None:
            return None
        numbers = np.array([place.numbers for place in self.candidates])
        senses = np.where(sides & (np.cos(numbers[:, 1] - s.initial.angle) < 0.0), -1.0, 1.0)
        places, angles, fibres = numbers[:, 0], numbers[:, 1], np.where(sides, numbers[:, 4], 0.0)
        return Compliance.between(
            np.where(sides, places, np.nan),
            np.ascontiguousarray(angles),
            np.where(sides, 0.0, numbers[:, 4]),
            fibres,
            senses,
            across,
            s.beam.kelvin_voigt,
            along,
        )

    def _residual_flexibility(self) -> FlexibilityAlong | None:
        """Flexibility that the modes leave out; None where there is none, or rigid stops do not see it."""
        c = self.scenario.contact
        if not c.enabled or not ((c.normal == "spring" and c.residual_flexibility) or c.point_inertia == "none"):
            return None
        return self._left_out if self.residual_compliance > 0.0 else None

    @property
    def _left_out(self) -> FlexibilityAlong:
        o, clamped = self.operators, self.scenario.discretization.frame == "tangent"
        if o.along is None:
            return FlexibilityAlong.at(o.contact_point, residual_flexibility(o, clamped))
        return flexibility_along(o, clamped)

    def _axial_flexibility(self) -> Array | None:
        """Places (m) and axial flexibility (m/N) up to them, (2, k); None if it is left out."""
        sections = self.operators.sections
        if not self.scenario.contact.axial_flexibility:
            return None
        x = np.linspace(0.0, sections.length, 2 if sections.area.x.size == 2 else _TABLE)
        return np.array([x, sections.axial_flexibility(x)])

    @cached_property
    def _elastic_modes(self) -> ElasticModes:
        return ElasticModes.of(self.scenario, self.operators)

    def _damping_matrix(self) -> Array:
        """Damping matrix (n, n) of B: Kelvin-Voigt, by mass and by mode."""
        beam, o, root = self.scenario.beam, self.operators, self.scenario.root
        matrix = beam.kelvin_voigt * o.K
        if root.kind == "driven" and root.damping > 0.0:  # the dashpot of the clamp
            matrix = matrix + root.damping * np.outer(o.root_slope, o.root_slope)
        if beam.mass_proportional > 0.0 or beam.modal_damping_ratio > 0.0:
            matrix = matrix + self._elastic_modes.damping_matrix()
        return np.ascontiguousarray(matrix)

    @cached_property
    def _modes_on_spring(self) -> ElasticModes | None:
        """Modes of a hub on a spring with its beam, in [theta, B], damped by mode; None where there are none."""
        s, o = self.scenario, self.operators
        if not (_is_on_spring(s) and s.beam.modal_damping_ratio > 0.0):
            return None
        turn = np.append(1.0, o.root_slope)
        mass = np.block([[np.array([[o.inertia]]), o.coupling[None]], [o.coupling[:, None], o.elastic_mass]])
        squares, modes = eigh(block_diag(0.0, o.K) + s.root.stiffness * np.outer(turn, turn), mass)
        return ElasticModes(mass, modes, 2.0 * s.beam.modal_damping_ratio * np.sqrt(np.maximum(squares, 0.0)))

    def slowed_on_spring(self, spin: Array, Bd: Array) -> Array | None:
        """Rates of [theta', B'] (n + 1, samples) by which damping by mode slows a hub on a spring, or None."""
        if self._modes_on_spring is None:
            return None
        return self._modes_on_spring.slowed(np.concatenate([spin[None], Bd]))

    def slowed(self, Bd: Array) -> Array | None:
        """Rates of B' (n, samples) by which damping by mass and by mode slows elastic modes; None without it.

        Without that by mode of a hub on a spring, see `slowed_on_spring`.
        """
        beam = self.scenario.beam
        if beam.modal_damping_ratio > 0.0 and not _is_on_spring(self.scenario):
            return self._elastic_modes.slowed(Bd)
        return beam.mass_proportional * Bd if beam.mass_proportional > 0.0 else None

    def _places(self) -> Places:
        """Places of contact as kernels read them."""
        o, places = self.operators, self.candidates
        tables, each = np.zeros((len(places), o.size + 2, o.size)), self._place_records()
        for k, place in enumerate(places):
            if not place.on_side:
                continue
            if place.numbers[0] == o.contact_point:
                tables[k] = np.vstack([o.contact_shortening, o.contact_shape, o.contact_slope])
            else:
                values, slopes, shortening = self._along.at(place.numbers[0])
                tables[k] = np.vstack([shortening, values, slopes])
        return Places(each, tables, None if all(place.on_side for place in places) else self._along.fitted())

    @property
    def _along(self) -> ShapeFunctions:
        """Shape functions at any place."""
        if self.operators.along is None:
            raise InputError(
                "discretization: contact anywhere and forces need shape functions anywhere, BeamOperators.along"
            )
        return self.operators.along

    def _place_records(self) -> Any:
        """Return records of the places of contact."""
        kept = self.foreshortening if self.scenario.contact.shortening else 0.0
        records = [place_record(place.on_side, place.numbers, kept) for place in self.candidates]
        return np.array(records).view(np.recarray)

    @property
    def residual_compliance(self) -> float:
        """Largest residual compliance (m/N) at places of contact, across the beam; 0 if the modes have all of one.

        An obstacle's point is taken to be where it meets the straight beam.
        """
        s, found = self.scenario, list[float]()
        for place in self.candidates:
            x, y, distance = place.numbers[:3]
            beside = float(np.sqrt(max(x * x + y * y - distance * distance, 0.0))) - s.root.hub_radius
            at = x if place.on_side else float(np.clip(beside, 0.0, s.beam.length))
            found.append(self.residual_compliance_at(at))
        return min(found) and max(found)

    def residual_compliance_at(self, place: float) -> float:
        """Return the residual compliance (m/N) at a place (m) of a beam in modes, transverse to it."""
        clamped = self.scenario.discretization.frame == "tangent"
        return float(residual_flexibility(self.operators, clamped, place)[0, 0])

    def initial_state(self) -> tuple[Array, Array]:
        """Return coordinates and velocities at t = 0: the undeformed beam at its initial angle and speed."""
        q, qd = np.zeros(self.size), np.zeros(self.size)
        q[0], qd[0] = self.scenario.initial.angle, self._initial_speed
        return q, qd

    @property
    def _initial_speed(self) -> float:
        """Angular velocity (rad/s) at t = 0."""
        driven = self.scenario.root.kind == "driven"
        return self.motion.at(0.0).speed if driven else self.scenario.initial.angular_velocity

    def rest_stiffness(self, q: Array) -> Array:
        """Return the tangent stiffness (d, d) at rest and t = 0, in the coordinates q (d,) that are marched.

        These are the second derivatives of elastic energy, weight and forces fixed in space, with a shaken base of
        the inertia force too,

            V = 1/2 B^T K B + 1/2 k (theta + Phi'(0) B - theta_0)^2
                + g (sin theta (Sm - 1/2 B^T D B) + cos theta P.B)
                - F_x (r + x_f - 1/2 B^T H_f B) - F_y Phi(x_f).B

        with each force in the axes of the frame, which turn under it.  Forces across the beam have no potential:
        what they change as they turn with it is left out.
        """
        o, kept, found = self.operators, self.foreshortening, np.zeros((self.operators.size + 1,) * 2)
        theta, B = (part := self.split(q))[0], part[1:]
        g, c, s = weight_in_frame(self.shaking or STILL, self.scenario.gravity, 0.0, theta)
        heavy = kept * np.asarray(o.D @ B)
        found[0, 0] = -g * (s * (o.Sm - 0.5 * B @ heavy) + c * (o.P @ B))
        found[0, 1:] = found[1:, 0] = -g * (c * heavy + s * o.P)
        found[1:, 1:] = as_dense(o.stiffness) - g * s * kept * as_dense(o.D)
        if _is_on_spring(self.scenario):
            turn = np.append(1.0, o.root_slope)
            found += self.scenario.root.stiffness * np.outer(turn, turn)
        if self.forces is not None:
            self._add_forces_fixed_in_space(self.forces, theta, B, found)
        return self._marched(found)

    def _add_forces_fixed_in_space(self, forces: PointForces, theta: float, B: Array, stiffness: Array) -> None:
        for i, (values, _, shortening) in enumerate(self._shapes_at_forces):
            if forces.each[i].follows:
                continue
            fx, fy = force_in_frame(forces, i, 0.0, theta, 0.0)
            bent = self.foreshortening * shortening @ B
            along = self.scenario.root.hub_radius + forces.each[i].x - 0.5 * B @ bent
            stiffness[0, 0] += fx * along + fy * (values @ B)
            stiffness[0, 1:] += fx * values + fy * bent
            stiffness[1:, 0] += fx * values + fy * bent
            stiffness[1:, 1:] += fx * self.foreshortening * shortening

    def held_stiffness(self, spring: float) -> Array:
        """Return the stiffness (d, d) of a weightless beam whose frame is on a spring (N m/rad)."""
        return self._marched(block_diag(spring, as_dense(self.operators.stiffness)))

    def _marched(self, matrix: Array) -> Array:
        """Return a matrix over [theta, B] (n + 1, n + 1) as one over the coordinates that are marched."""
        return matrix

    def split(self, q: Array) -> Array:
        """Return [theta, B] (..., n + 1) of the coordinates that are marched."""
        return q

    def joined(self, q: Array) -> Array:
        """Return the coordinates that are marched of [theta, B] (n + 1,)."""
        return q

    def state_of(self, q: Any, qd: Any) -> tuple[Array, Array]:
        """Return coordinates and velocities at t = 0 of [theta, B] and their rates, each (n + 1,).

        The speed of a driven root is that of its motion.  Raises InputError for a wrong shape.
        """
        shape = self.split(self.initial_state()[0]).shape
        q, qd = (
            own_numbers(np.asarray(part), shape, f"initial_state, {name}") for part, name in ((q, "q"), (qd, "qd"))
        )
        if self.scenario.root.kind == "driven":
            qd[0] = self.motion.at(0.0).speed
        return self.joined(q), self.joined(qd)

    @cached_property
    def masses(self) -> Array:
        """Arms r + x (m) and masses (kg) of the nq points of the quadrature and, last, of the k point masses.

        Of the shape (2, nq + k).
        """
        table, s = self.operators.stations.quadrature, self.operators.sections
        masses = np.append(s.mass_per_length(table.points) * table.weights, s.point_masses)
        return np.stack([s.hub_radius + np.append(table.points, s.places), masses])

    def deflections(self, B: Array) -> Array:
        """Deflections (nq + k, samples) of the points of mass, of elastic coordinates B (n, samples)."""
        return np.concatenate([self.operators.stations.quadrature.values @ B, self.at_masses @ B])

    @cached_property
    def at_masses(self) -> Array:
        """Shape functions at the point masses, (k, n)."""
        return self.operators.rows_at(self.operators.sections.places, 0)

    def panels_before(self, places: Array) -> Any:
        """How many panels of the quadrature lie before each place (k,), which is an end of one."""
        table = self.operators.stations.quadrature
        return np.searchsorted(table.points, places) // table.order

    def relative_deflection(self, q: Array) -> Array:
        """Largest deflection along the beam over its length, (samples,), of coordinates q (samples, d)."""
        along = self.split(q)[:, 1:] @ self.operators.stations.values.T
        return np.asarray(np.max(np.abs(along), axis=1) / self.scenario.beam.length)

    def integrals(self, integrand: Array) -> Array:
        """Integrals from the root to the points of mass: (nq, ...) -> (nq + k, ...)."""
        table = self.operators.stations.quadrature
        to_masses = [
            np.tensordot(table.weights[:last], integrand[:last], axes=1)
            for last in self.panels_before(self.operators.sections.places) * table.order
        ]
        return np.concatenate([cumulative(table, integrand), *(total[None] for total in to_masses)])

    def energies(self, q: Array, qd: Array) -> Energies:
        """Energies of samples [theta, B] and their rates (samples, n + 1), kinetic energy in the chosen order."""
        o, kept = self.operators, self.foreshortening
        theta, B, spin, Bd = q[:, 0], q[:, 1:], qd[:, 0], qd[:, 1:]
        height = np.sin(theta) * (o.Sm - 0.5 * kept * _quadratic(B, o.D)) + np.cos(theta) * (B @ o.P)
        if self.scenario.discretization.kinetics == "full":
            kinetic = self._full_kinetic(q, qd)
        else:
            inertia = o.J + _quadratic(B, o.M1 - kept * o.C)
            kinetic = 0.5 * inertia * spin**2 + spin * (Bd @ o.S) + 0.5 * _quadratic(Bd, o.M1)
        inertias, slopes = o.turning
        turning = 0.5 * (spin[:, None] + Bd @ slopes.T) ** 2 @ inertias
        elastic = 0.5 * _quadratic(B, o.stiffness)
        if _is_on_spring(self.scenario):
            turned = theta + B @ o.root_slope - self.scenario.initial.angle
            elastic += 0.5 * self.scenario.root.stiffness * turned**2
        return Energies(kinetic + turning, elastic, self.scenario.gravity * height)

    def _full_kinetic(self, q: Array, qd: Array) -> Array:
        slopes = self.operators.stations.quadrature.slopes
        B, Bd, spin, (arms, masses) = q[:, 1:].T, qd[:, 1:].T, qd[:, 0], self.masses
        slope, slope_rate = slopes @ B, slopes @ Bd
        u = -0.5 * self.integrals(slope**2) + 1j * self.deflections(B)
        rate = -self.integrals(slope * slope_rate) + 1j * self.deflections(Bd)
        velocity = BentBeam(q[:, 0], arms[:, None], u, spin, rate).velocity()
        return np.asarray(0.5 * masses @ (velocity.real**2 + velocity.imag**2))


class FullBeam(Beam):
    """A beam in all its nodes, in its total transverse coordinates W (n,); first-order kinetics.

    The operators are banded ones of the slope of the root and of deflection and slope node by node, from
    ``oblique_impact.fem_beam.build_nodal``.
    """

    @property
    def size(self) -> int:
        """Coordinates that are marched."""
        return self.operators.size

    @property
    def residual_compliance(self) -> float:
        """Compliance (m/N) of the contact point's deflection, if it is condensed."""
        return self.operators.left_out

    @property
    def _left_out(self) -> FlexibilityAlong:
        """Flexibility of the contact point, which is condensed."""
        return FlexibilityAlong.at(self.operators.contact_point, np.diag([self.operators.left_out, 0.0]))

    @cached_property
    def model(self) -> NodalModel:
        """The compiled model, a :class:`~oblique_impact.kernels.system.System`."""
        s, o, frame, rigid = self.scenario, self.operators, nodal_frame, self.operators.rigid
        bands = np.zeros((4, HALF_BANDWIDTH + 1, self.size))
        for which, matrix in (
            (frame.MASS_BAND, o.elastic_mass),
            (frame.STIFFNESS_BAND, o.K),
            (frame.SPIN_BAND, o.M1 - o.C),
            (frame.GRAVITY_BAND, o.D),
        ):
            for k in range(HALF_BANDWIDTH + 1):
                diagonal = matrix.diagonal(k)
                bands[which, k, : diagonal.size] = diagonal
        vectors = np.zeros((8, self.size))
        vectors[frame.COUPLING], vectors[frame.LOAD], vectors[frame.RIGID] = o.coupling, o.P, rigid
        vectors[frame.GRAVITY_RIGID], vectors[frame.FRAME] = o.D @ rigid, self._frame
        if s.root.kind == "driven":
            near = min(HALF_BANDWIDTH + 1, self.size)
            for row, which in ((frame.ROOT_MASS, frame.MASS_BAND), (frame.ROOT_STIFFNESS, frame.STIFFNESS_BAND)):
                vectors[row, :near] = bands[which, :near, 0]
                bands[which, :, 0] = 0.0
            bands[frame.MASS_BAND, 0, 0] = o.inertia  # that of the prescribed coordinate is of no effect
        factored, massless = bands, nodal_frame.WITH_INERTIA
        if o.means is not None:
            held = o.sections.hub_inertia > 0.0 or s.discretization.frame == "tangent"
            massless = frame.mean_velocities(o.means.toarray(), held, self._yields)
            # a little stiffness makes the mass definite: for the acceleration from which a run starts
            factored = bands.copy()
            deflections = bands[:, 0, 1 + self._yields :: 2].sum(axis=1)
            share = _STIFFENED * deflections[frame.MASS_BAND] / deflections[frame.STIFFNESS_BAND]
            factored[frame.MASS_BAND] += share * bands[frame.STIFFNESS_BAND]
        mass_factor, vectors[frame.FRAME_RESPONSE] = frame.factored_mass(factored, self._frame)
        numbers = {
            "root": _ROOTS[s.root.kind],
            "yields": self._yields,
            "inertia": o.inertia,
            "static_moment": o.Sm,
            "gravity": s.gravity,
            "torque": self._torque,
            "kelvin_voigt": s.beam.kelvin_voigt,
            "mass_proportional": s.beam.mass_proportional,
            "hub_radius": s.root.hub_radius,
            "root_stiffness": s.root.stiffness,
            "root_damping": s.root.damping,
            "rest_angle": s.initial.angle,
            **(asdict(self.motion) if isinstance(self.motion, SpinUp) else {}),
        }
        return NodalModel(
            numbers=record_of(frame.NODAL_NUMBERS, numbers),
            bands=bands,
            mass_factor=mass_factor,
            vectors=vectors,
            places=self._nodal_places(self._place_records()),
            drive=self.motion.drive,
            massless=massless,
            shaking=self.shaking or STILL,
            loads=nodal_frame.NodalLoads(self.forces or NO_FORCES, self._nodal_places(self._loaded_places)),
        )

    @property
    def _yields(self) -> bool:
        """Whether the slope of the root is a coordinate of its own, behind the angle of a driven root."""
        return self.operators.sections.clamp_stiffness > 0.0

    @cached_property
    def _frame(self) -> Array:
        """Vector a (n,) of the frame's angle a.W: that of beam and hub as a whole, or the first coordinate."""
        if self.scenario.discretization.frame == "mean-axis":
            return np.asarray(self.operators.coupling / self.operators.inertia)
        return np.asarray(np.eye(1, self.size)[0])

    def _nodal_places(self, each: Any) -> NodalPlaces:
        """Places of contact or of forces as kernels read them, from their records."""
        o, edges = self.operators, self._along.edges
        size = 2 * edges.size + 1
        return NodalPlaces(
            HermiteShapes.on(edges),
            each,
            np.zeros(size),
            np.zeros(size),
            np.zeros((VECTORS, size)),
            np.ascontiguousarray(o.contact_shape) if o.left_out > 0.0 else np.zeros(0),
        )

    def initial_state(self) -> tuple[Array, Array]:
        """Return W and W' at t = 0: the undeformed beam at its initial angle and speed."""
        rigid = self.operators.rigid
        return self.scenario.initial.angle * rigid, self._initial_speed * rigid

    def _marched(self, matrix: Array) -> Array:
        """Return a matrix over [theta, B] (n + 1, n + 1) as one over W (n, n)."""
        bent = np.eye(self.size) - np.outer(self.operators.rigid, self._frame)
        parts = np.concatenate([self._frame[None], bent])
        return np.asarray(parts.T @ matrix @ parts)

    def split(self, q: Array) -> Array:
        """Return [theta, B] (..., n + 1) of W (..., n)."""
        theta = (q @ self._frame)[..., None]
        return np.concatenate([theta, q - theta * self.operators.rigid], axis=-1)

    def joined(self, q: Array) -> Array:
        """Return W (n,) of [theta, B] (n + 1,)."""
        return np.asarray(q[1:] + q[0] * self.operators.rigid)


def as_dense(matrix: Matrix) -> Array:
    """Return a matrix of operators as a dense one."""
    return np.asarray(matrix.toarray() if issparse(matrix) else matrix)


def _quadratic(rows: Array, matrix: Matrix) -> Array:
    """Row-wise v^T A v, (samples,)."""
    return np.asarray(np.einsum("si,si->s", rows @ matrix, rows))

"""The history of a run in absolute coordinates: the variables of all methods, in the scenario's floating frame."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from oblique_impact.beam.base_motion import BaseMotion, base_motion_of
from oblique_impact.beam.beam import Energies
from oblique_impact.beam.bent_beam import OF_A_FREE_BEAM, BentBeam
from oblique_impact.beam.clearance import clearance_along
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.operators import station_points
from oblique_impact.beam_problem import Parts
from oblique_impact.contact.state import State
from oblique_impact.fem_beam.exact.elastic_sections import Array, ElasticSections
from oblique_impact.fem_beam.exact.exact_beam import Complex, ExactBeam
from oblique_impact.fem_beam.exact.exact_run import exact_problem
from oblique_impact.fem_beam.exact.exact_scheme import Recorder
from oblique_impact.fem_beam.exact.exact_system import ExactModel, beam_of, placed_forces
from oblique_impact.fem_beam.exact.point_loads import COLUMNS, point_force, take_point_forces
from oblique_impact.fem_beam.exact.step_forces import NODE
from oblique_impact.fem_beam.exact.stop import place_of
from oblique_impact.history.history import History, beam_history
from oblique_impact.history.samples import LAMBDA_N, LAMBDA_T, Column, Samples, contact_variables, gather
from oblique_impact.kernels.compiling import clock
from oblique_impact.kernels.jit import by_reference, kernel
from oblique_impact.marching.loop import Run
from oblique_impact.progress import Status
from oblique_impact.scenario.model import ON_NODE
from oblique_impact.scenario.scenario import Scenario

#: samples that are processed at a time
_BLOCK = 512
#: Gauss points through which section forces are read at a station
_NEAREST = 4
#: rad, the last step of Newton's method for the mean axis with a hub, whose error is its square, and most steps
_ANGLE, _NEWTON = 1e-10, 40


def simulate(
    scenario: Scenario,
    on_progress: Callable[[Status], None] | None = None,
    sections: ElasticSections | None = None,
    parts: Parts = Parts(),
) -> History:
    """Run a scenario with the beam in absolute coordinates and return its history, whatever the outcome.

    Coordinates `q` are places (m) and rotation (rad) of the nodes, [x, y, phi] node by node from the root; all
    other variables mean what they mean for every method: `theta` is the angle of a driven root, else the rotation
    of the first section in the tangent frame, or that of the mean axis, and displacements are those in this frame.
    `sections`, and friction and base motion of `parts`, replace those of the scenario.
    """
    # overflow in a step is handled: the iterations do not converge
    with np.errstate(all="ignore"), clock() as marching:
        beam = beam_of(scenario, sections)
        run = Run(exact_problem(scenario, beam, parts), on_progress)
        run.execute()
        motion = parts.base_motion or base_motion_of(scenario.root)
        return _Frame(run, scenario, beam, motion).history(marching.seconds)


class _Forces(NamedTuple):
    """Mean forces of steps at samples.

    Forces N + i Q (N) in the rotated sections and moments (N m) at Gauss points, each (samples, elements, 2), and
    the reactions (N) of contacts that stick (samples, n).
    """

    force: Complex
    moment: Array
    reactions: Array


class _Places(NamedTuple):
    """Contacts at samples, each (samples, n), see :class:`~oblique_impact.fem_beam.exact.stop.Place`."""

    gap: Array
    slip: Array
    x: Array
    normal: Complex
    tangent: Complex
    point: Complex


@kernel("the places of contact")
def _find_places(model: ExactModel, q: Array, v: Array, lengths: Array, vectors: Complex) -> None:
    """Put lengths (3, samples, n) and vectors (3, samples, n) of places into arrays."""
    model = by_reference(model)
    for k in range(q.shape[0]):
        for i in range(lengths.shape[2]):
            at = place_of(model.beam, model.touchings[i], q[k], v[k])
            lengths[0, k, i], lengths[1, k, i], lengths[2, k, i] = at.gap, at.slip, at.x
            vectors[0, k, i], vectors[1, k, i], vectors[2, k, i] = at.normal, at.tangent, at.point


def _places_of(model: ExactModel, q: Array, v: Array) -> _Places:
    """Return the contacts at states q, v (samples, 3 n)."""
    shape = 3, len(q), len(model.touchings)
    lengths, vectors = np.zeros(shape), np.zeros(shape, dtype=complex)
    _find_places(model, np.ascontiguousarray(q), np.ascontiguousarray(v), lengths, vectors)
    return _Places(*lengths, *vectors)


class _Stations(NamedTuple):
    """The matrix from nodes to values at output stations."""

    x: Array
    values: Array  # (stations, nodes)


def stations_of(beam: ExactBeam, x: Array) -> _Stations:
    """Read the elements at places x (m)."""
    values = np.zeros((x.size, beam.x.size))
    for row, place in enumerate(x):
        first, shapes = beam.row_at(float(place))
        values[row, first : first + 3] = shapes
    return _Stations(x, values)


def recovery(beam: ExactBeam, x: Array, without: frozenset[int], masses: Array) -> Array:
    """Return the matrix (stations, Gauss points) from section forces that are smooth to those at places x (m).

    They are polynomials through the nearest Gauss points, where section forces are most accurate, other than those
    of the elements `without`, and on the same side of `masses`, the places (m) of those inside the span, where
    section forces jump.
    """
    gauss, found = beam.points.ravel(), np.zeros((x.size, beam.points.size))
    allowed = np.array([e for e in range(len(beam.points)) if e not in without])
    points = (2 * allowed[:, None] + [0, 1]).ravel()
    sides = np.searchsorted(masses, gauss[points])
    for row, place in enumerate(x):
        beside = points[sides == np.searchsorted(masses, place - ON_NODE * beam.ends[-1])]
        own = beside if beside.size else points  # of two masses in one element: nothing is between them
        nearest = np.argsort(np.abs(gauss[own] - place), kind="stable")[:_NEAREST]
        chosen = own[np.sort(nearest)]
        found[row, chosen] = _lagrange(gauss[chosen])(place)
    return found


def _lagrange(nodes: Array) -> Any:
    """Lagrange polynomials of some nodes."""
    from scipy.interpolate import KroghInterpolator  # a fifth of a second, which reading its kernels would cost

    return KroghInterpolator(nodes, np.eye(nodes.size))


class _Frame:
    """The samples of a run, seen from the floating frame of its scenario."""

    def __init__(self, run: Run, scenario: Scenario, beam: ExactBeam, motion: BaseMotion) -> None:
        self.record, self.pairs, self.scenario, self.beam = run.record, run.pairs, scenario, beam
        self.motion = motion
        s, weight = self.scenario, self.beam.weight(self.scenario.gravity)
        samples = gather(
            run.record.segments,
            self.beam.size,
            lambda time, q, v: Energies(self.beam.kinetic_energy(v), self._elastic_energy(time, q), -q @ weight),
        )
        self.q, self.v, self.states = samples.q, samples.qd, samples.each
        self.places = _places_of(run.problem.system, self.q, self.v)
        if run.problem.scheme.decides:
            self.forces, self.samples = self._forces_of_last_steps(samples), samples
        else:
            self.forces = self._kept_forces(run)
            self.samples = self._with_stick(samples, run.decision.friction.static or 0.0)
        self.sections = Sections.from_scenario(s)
        self.stations = stations_of(self.beam, station_points(s.beam.length, s.contact.point))
        self._recoveries: dict[frozenset[int], Array] = {}

    def _forces_of_last_steps(self, samples: Samples) -> _Forces:
        """Return the mean forces of the steps that end at the samples, as contact forces are."""
        n, viscosity = len(self.pairs), self.scenario.beam.kelvin_voigt
        length = np.concatenate([segment.step for segment in self.record.segments])
        begins = ~(length > 0.0)  # no step has been taken
        h = np.where(begins, 1.0, length)[:, None]
        moved = h * (self.v - 0.5 * h * samples.qdd)
        moved[:, 2::NODE] = 2.0 * np.arctan(0.5 * moved[:, 2::NODE])
        before = self.q - moved
        found = self.beam.mean_resultants(before, self.q, viscosity / h[:, :, None])
        at_once = self.beam.resultants(self.q[begins], self.v[begins], viscosity)
        found.force[begins], found.moment[begins] = at_once
        return _Forces(*found, np.zeros((len(h), n)))

    def _root_turn(self, time: Array) -> tuple[Array, Array]:
        """Prescribed angle (rad) of a driven root and its rate (rad/s); the angle at rest of a hub's spring."""
        if self.scenario.root.kind != "driven":
            return np.full(time.shape, self.scenario.initial.angle), np.zeros(time.shape)
        turns = [self.motion.at(t) for t in time.tolist()]
        angles = self.scenario.initial.angle + np.array([turn.angle for turn in turns])
        return angles, np.array([turn.speed for turn in turns])

    def _elastic_energy(self, time: Array, q: Array) -> Array:
        """Strain energy of the beam and of the spring at its root (J)."""
        twist = q[:, 2] - self._root_turn(time)[0]
        return self.beam.elastic_energy(q) + 0.5 * self.scenario.root.stiffness * twist**2

    def _kept_forces(self, run: Run) -> _Forces:
        """Return the forces of steps at the samples; at the last of one time, those of the steps behind it."""
        recorder: Recorder = run.prepared.own
        recorder.take_log()
        averages = recorder.averages
        averages.cut()
        time = np.concatenate([segment.times for segment in run.record.segments]).tolist()
        found = np.zeros((len(time), 3 * self.beam.points.size + len(self.pairs)))
        for k, (before, now, after) in enumerate(zip([None, *time], time, [*time[1:], None], strict=False)):
            begins = before == now != after
            kept, other = averages.before.get(now), averages.after.get(now)
            forces = other if begins or kept is None else kept
            if forces is None:
                at_once = self.beam.resultants(self.q[k], self.v[k], self.scenario.beam.kelvin_voigt)
                parts = at_once.force.real, at_once.force.imag, at_once.moment
                forces = np.concatenate([*(part.ravel() for part in parts), np.zeros(len(self.pairs))])
            found[k] = forces
        points = self.beam.points.shape
        inner, reactions = np.split(found, [3 * self.beam.points.size], axis=1)
        normal, shear, moment = np.moveaxis(inner.reshape(len(time), 3, *points), 1, 0)
        return _Forces(normal + 1j * shear, moment, reactions)

    def _with_stick(self, samples: Samples, static: float) -> Samples:
        """Give sticking contacts the forces of the steps around a sample, in the cone of the `static` coefficient.

        Stick ends where the mean of a step is at the edge of the cone: at its end it would be beyond.
        """
        contacts, scalars = samples.contacts.copy(), samples.scalars.copy()
        edge = static * contacts[:, :, LAMBDA_N]
        held = np.clip(self.forces.reactions, -edge, edge)
        contacts[:, :, LAMBDA_T] = np.where(samples.each == State.STICK, held, contacts[:, :, LAMBDA_T])
        scalars[:, LAMBDA_T] = contacts[:, :, LAMBDA_T].sum(axis=1)
        return samples._replace(contacts=contacts, scalars=scalars)

    def history(self, wall: float) -> History:
        """Return the history; `wall` is the time of the marching (s)."""
        bent, touch = self._bent, int(np.argmin(np.abs(self.stations.x - self.scenario.contact.point)))
        variables = {
            **self.samples.variables(),
            **bent.variables(touch, self.scenario.contact_fibre),
            **self._of_contacts(),
            "station": self.stations.x,
        }
        if self.scenario.root.is_free:
            origin, drift = self.origin
            values = origin.real, origin.imag, drift.real, drift.imag
            variables |= dict(zip(OF_A_FREE_BEAM, values, strict=True))
        if self.scenario.contact.enabled:
            on_side = [pair.on_side for pair in self.pairs]
            variables |= clearance_along(self.scenario, self.sections, bent, variables, on_side)
        return beam_history(self.scenario, self.record, self.samples, variables, self.section_forces, wall)

    @cached_property
    def _end_pushes(self) -> Array:
        """Forces (N) along the slide at ends of beddings, (samples, n)."""
        found = np.zeros(self.places.gap.shape)
        for i, pair in enumerate(self.pairs):
            if pair.contact_law is not None:
                compressed = np.maximum(-self.places.gap[:, i], 0.0)
                found[:, i] = pair.contact_law.end_pushes(compressed, self.places.slip[:, i])
        return np.where(self.states != State.FREE, found, 0.0)

    @cached_property
    def _contact_forces(self) -> Complex:
        """Forces (N) of the contacts on the beam, (samples, n)."""
        contacts, places = self.samples.contacts, self.places
        normal, along = contacts[:, :, LAMBDA_N], contacts[:, :, LAMBDA_T] + self._end_pushes
        return np.asarray(normal * places.normal + along * places.tangent)

    @cached_property
    def _applied_forces(self) -> tuple[Array, Complex]:
        """Places (k,) in m of the forces on the beam, and their values (samples, k) in N, x + i y."""
        forces = placed_forces(self.scenario, self.beam)
        if forces is None:
            return np.zeros(0), np.zeros((len(self.q), 0), dtype=complex)
        taken = np.zeros((len(forces.first), COLUMNS))
        found = np.zeros((len(self.q), len(forces.first)), dtype=complex)
        for k, t in enumerate(self.samples.time.tolist()):
            take_point_forces(forces, t, taken)
            found[k] = [point_force(force, self.q[k]) for force in taken]
        return forces.each.places, found

    def _of_contacts(self) -> dict[str, Column]:
        """Return the variables of n contacts, each (samples, n)."""
        obstacles = [pair.obstacle for pair in self.pairs]
        return contact_variables(obstacles, self.places.x, self.places.point, self._contact_forces)

    @cached_property
    def frame(self) -> tuple[Array, Array]:
        """Angle (rad) and angular velocity (rad/s) of the floating frame at the samples."""
        if self.scenario.root.kind == "driven" and self.scenario.root.stiffness > 0.0:
            return self._root_turn(self.samples.time)
        if self.scenario.discretization.frame == "tangent":
            return self.q[:, 2], self.v[:, 2]
        # the mean axis: int m (r + x) u_y dx = 0 with the turns of hub and point masses, + sum J (phi - theta)
        arms = self.beam.radius + self.beam.x
        if self.scenario.root.is_free:  # about the centre of mass
            arms = arms - self._masses @ arms / self._masses.sum()
        static = (self.beam.M[::NODE, ::NODE] @ arms).astype(complex)
        sums, rates = _complex(self.q) @ static, _complex(self.v) @ static
        near, inertia, turning = self.q[:, 2::NODE].mean(axis=1), *self._turning
        theta = near + np.angle(sums * np.exp(-1j * near))
        turns, turn_rates = self.q[:, 2::NODE] @ turning, self.v[:, 2::NODE] @ turning
        left = np.full(theta.shape, np.inf if inertia > 0.0 else 0.0)
        for _ in range(_NEWTON):
            # from the mean axis of the beam alone to a first section less than a right angle away the equation is
            # convex, and each step goes on towards the root; an angle that is not found is no number
            if np.all(left <= _ANGLE):
                break
            turned = sums * np.exp(-1j * theta)
            step = (turned.imag + turns - inertia * theta) / (turned.real + inertia)
            theta, left = theta + step, np.abs(step)
        theta = np.where(left <= _ANGLE, theta, np.nan)
        turned, spinning = sums * np.exp(-1j * theta), rates * np.exp(-1j * theta)
        return theta, (spinning.imag + turn_rates) / (turned.real + inertia)

    @property
    def _turning(self) -> tuple[float, Array]:
        """Moments of inertia (kg m^2) of hub and point masses about their own centres: sum, and row over nodes."""
        row = np.zeros(self.beam.x.size)
        row[0] = self.sections.hub_inertia
        for point in self.sections.masses:
            first, shapes = self.beam.row_at(point.place)
            row[first : first + 3] += point.inertia * shapes
        return float(row.sum()), row

    @cached_property
    def origin(self) -> tuple[Complex, Complex]:
        """Place (m) and velocity (m/s) of the frame's origin at the samples: those of the root's axis.

        Of a beam that nothing holds the first section is there, in the mean-axis frame the undeformed beam's whose
        centre of mass is that of the bent one.
        """
        if not self.scenario.root.is_free:
            return np.zeros(len(self.q), dtype=complex), np.zeros(len(self.q), dtype=complex)
        places, rates = _complex(self.q), _complex(self.v)
        if self.scenario.discretization.frame == "tangent":
            return places[:, 0], rates[:, 0]
        mass, (theta, spin) = self._masses, self.frame
        centre, velocity = places @ mass / mass.sum(), rates @ mass / mass.sum()
        arm = np.exp(1j * theta) * float(self.beam.x @ mass / mass.sum())
        return centre - arm, velocity - 1j * spin * arm

    @cached_property
    def _masses(self) -> Array:
        """Masses (kg) of the nodes, for sums that are linear in their places."""
        return np.asarray(self.beam.M[::NODE, ::NODE].sum(axis=0)).ravel()

    @property
    def _bent(self) -> BentBeam:
        """The beam at the stations, seen from the frame."""
        theta, spin = (values[:, None] for values in self.frame)
        origin, drift = (values[:, None] for values in self.origin)
        back, to_stations = np.exp(-1j * theta), self.stations.values.T
        place = back * (_complex(self.q) @ to_stations - origin)
        rate = back * (_complex(self.v) @ to_stations - drift) - 1j * spin * place
        phi, phi_rate = (values[:, 2::NODE] @ to_stations for values in (self.q, self.v))
        arms, direction = self.beam.radius + self.stations.x, np.exp(1j * (phi - theta))
        turning = 1j * (phi_rate - spin) * direction
        return BentBeam(theta, arms, place - arms, spin, rate, direction, turning, origin, drift)

    def section_forces(self) -> dict[str, Column]:
        """Section forces and bending stress, each (samples, stations), of samples at stations."""
        with np.errstate(all="ignore"):  # as in the run, which may have diverged
            parts = [self._section_forces(slice(k, k + _BLOCK)) for k in range(0, len(self.q), _BLOCK)]
        found: dict[str, Column] = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        x = self.stations.x
        modulus = self.sections.fibre_distance(x) / self.sections.second_moment(x)
        return found | {"bending_stress": modulus * found["moment"], "time": self.samples.time, "station": x}

    def _section_forces(self, part: slice) -> dict[str, Array]:
        """Moment, its slope along the beam, and the force along the frame's axis, of some samples.

        M' = -Im(conj(r') f) with the force f = exp(i phi) (N + i Q) in the inertial frame; the moment that turns
        the sections themselves is left out.  What contact forces add is taken out before the rest, which is
        smooth, is carried from Gauss points to stations.
        """
        fields, theta = self.beam.fields(self.q[part]), self.frame[0][part, None, None]
        force, samples = np.exp(1j * fields.rotation) * self.forces.force[part], len(theta)
        by_name = {
            "moment": self.forces.moment[part],
            "shear": -np.imag(fields.tangent.conj() * force),
            "axial_force": np.real(np.exp(-1j * theta) * force),
        }
        tangents = fields.tangent.reshape(samples, -1)
        inside, outside = (self._of_loads(part, x, tangents) for x in (self.beam.points.ravel(), self.stations.x))
        found = {name: np.empty((samples, self.stations.x.size)) for name in by_name}
        loaded = [self._loaded(*each) for each in zip(self.states[part], self.places.x[part], strict=True)]
        for elements in set(loaded):
            rows = np.array([each == elements for each in loaded])
            smooth = self._recovery(elements).T
            for name, values in by_name.items():
                taken = values.reshape(samples, -1)[rows] - inside[name][rows]
                found[name][rows] = taken @ smooth + outside[name][rows]
        return found

    def _loaded(self, states: Column, places: Array) -> frozenset[int]:
        """Return the elements that a point pushes inside of them: there section forces cannot jump."""
        ends, contacts = self.beam.ends[1:-1], zip(self.pairs, states, places, strict=True)
        pushed = [x for pair, state, x in contacts if state != State.FREE and not pair.on_side]
        fixed = [*self.scenario.inner_forces, *self._inner_masses]
        pushed += [x for x in fixed if np.min(np.abs(ends - x), initial=np.inf) > ON_NODE * self.beam.ends[-1]]
        return frozenset(int(np.searchsorted(ends, x)) for x in pushed)

    @cached_property
    def _inner_masses(self) -> Array:
        """Places (m) of point masses inside the span."""
        places = np.unique(self.sections.places)
        return places[places < self.scenario.beam.length]

    def _recovery(self, without: frozenset[int]) -> Array:
        if without not in self._recoveries:
            self._recoveries[without] = recovery(self.beam, self.stations.x, without, self._inner_masses)
        return self._recoveries[without]

    def _of_loads(self, part: slice, x: Array, tangents: Complex) -> dict[str, Array]:
        """Return what forces of contacts and others add at places x (m) between them and the root.

        `tangents` (samples, points) are those of the axis at Gauss's points.
        """
        beam, theta, axis = self.beam, self.frame[0][part], _complex(self.q[part])
        found = {name: np.zeros((len(theta), x.size)) for name in ("moment", "shear", "axial_force")}
        applied_at, applied = self._applied_forces
        places = np.concatenate([self.places.x, np.broadcast_to(applied_at, applied.shape)], axis=1)[part]
        # of a force on the axis there is no couple
        points = np.concatenate([self.places.point, np.full(applied.shape, np.nan)], axis=1)[part]
        loads = np.concatenate([self._contact_forces, applied], axis=1)[part]
        rows = zip(places, points, loads, strict=True)
        for row, contacts in enumerate(rows):
            for place, point, load in zip(*contacts, strict=True):
                if load == 0.0:
                    continue
                before = x <= place * (1.0 + 1e-12)
                shear = -(np.interp(place, beam.points.ravel(), tangents[row]).conjugate() * load).imag
                couple = 0.0
                if not np.isnan(point):
                    couple = ((point - np.interp(place, beam.x, axis[row])).conjugate() * load).imag
                found["shear"][row] += shear * before
                found["axial_force"][row] += (np.exp(-1j * theta[row]) * load).real * before
                found["moment"][row] += (couple - shear * (place - x)) * before
        return found


def _complex(q: Array) -> Complex:
    """Places (samples, nodes) as complex numbers."""
    return q[:, 0::NODE] + 1j * q[:, 1::NODE]

"""The deformed beam as a centreline and a swept tube with its results, from a history alone.

A deformation factor magnifies the deviation of the axis from the straight line through pin and contact point and
nothing else, so that both stay where they are.  A thickness magnifies the cross-sections.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from oblique_impact.beam.beam import contact_places
from oblique_impact.beam.bent_beam import OF_A_FREE_BEAM, BentBeam
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.point_forces import force_value, forces_of
from oblique_impact.contact.state import State
from oblique_impact.errors import InputError
from oblique_impact.history.history import History
from oblique_impact.history.sample_times import first_sample, last_sample
from oblique_impact.history.variables import SECTION_FORCES
from oblique_impact.renders.outlines import SIDES, Solid, has_corners, solid_of
from oblique_impact.scenario.model import PointMass
from oblique_impact.scenario.obstacles import ObstaclePoint

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

#: deformation factors to choose from, and how much of the length the largest deviation may become
_FACTORS, _VISIBLE = (1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 30.0, 50.0, 100.0), 0.06
#: of the beam's length: pegs that are no farther apart, as on both sides of the beam, are seen together close by
_BESIDE = 0.05

#: results along the beam that the surface carries, with their units
QUANTITIES = {
    "elastic_displacement": "m",
    "velocity": "m/s",
    "section_rotation": "rad",
    "moment": "N m",
    "shear": "N",
    "axial_force": "N",
    "bending_stress": "Pa",
    "axial_stress": "Pa",
}
#: variables of a history that are such a result
_VARIABLES = ("moment", "shear", "axial_force")


def contact_gap(history: History) -> Array:
    """Return the gap (m) of the contact point itself, (samples,); on a compliant stop its compression, negative.

    The variable `gap` is that of the coordinates: what they leave out of the contact point is not in it.
    """
    gap, scenario = np.asarray(history["gap"].values, dtype=float), history.scenario
    if "depth" not in history or scenario is None:
        return gap
    # a point without inertia rests on a rigid stop, through the flexibility that the coordinates leave out
    resting = scenario.contact.point_inertia == "none" and scenario.solver.scheme != "time-stepping"
    if scenario.contact.normal == "rigid" and not resting:
        return gap
    return np.where(history["state"].values == State.FREE, gap, -history["depth"].values)


class Zone(NamedTuple):
    """The part of the beam from the first to the last place that is in contact with one obstacle."""

    obstacle: int  # the slope is 0, the others count from 1
    first: float  # m along the beam
    last: float
    side: float  # of the beam that touches, seen along it: 1 the left, -1 the right


class BeamGeometry:
    """Shapes of the beam at the samples of a history.

    The deformation factor is chosen from the largest deviation of the run if none is given; the beam is drawn
    `thickness` times as thick as it is, with so many `sides` around.  Samples are numbers that may lie between
    two: there everything is linear.

    Raises InputError if the history is not one of a beam or the factor is not positive and finite.
    """

    def __init__(
        self, history: History, factor: float | None = None, thickness: float = 1.0, sides: int = SIDES
    ) -> None:
        if history.scenario is None:
            raise InputError("history: it is not one of a beam")
        for name in ("theta", "ux_dot", "lambda_n"):
            if name not in history:
                raise InputError(f"history: has no variable {name!r}: it is not one of a beam")
        if factor is not None and not 0.0 < factor < np.inf:
            raise InputError(f"--deformation {factor}: should be a positive number")
        self.history, self.thickness, self.sides = history, thickness, sides
        self.scenario = history.scenario
        self.sections = Sections.from_scenario(self.scenario)
        self._values: dict[str, Array] = {}
        self._last_axis: tuple[float, Array] = np.nan, np.zeros((0, 3))
        self._places = contact_places(self.scenario)
        found, asked = history.data.sizes["contact"], len(self._places)
        if found != asked:
            raise InputError(f"history: has {found} contacts, where its scenario has {asked}")
        self.times, self.stations = self.values("time"), self.values("station")
        #: number of the station at the contact point
        self.touch = int(np.argmin(np.abs(self.stations - self.scenario.contact.point)))
        self.factor = self._fitting_factor() if factor is None else float(factor)

    def values(self, name: str) -> Array:
        """Return a variable of the history, (samples, ...)."""
        if name not in self._values:  # xarray takes long for single samples
            data = self.history.section_forces() if name in SECTION_FORCES else self.history
            self._values[name] = np.asarray(data[name].values, dtype=float)
        return self._values[name]

    def value(self, name: str, k: float | Integers) -> Array:
        """Return a variable of the history at sample k, or at several samples."""
        return _between(self.values(name), k)

    def index(self, time: float) -> float:
        """Return the number of the sample at a time (s), at a jump that of its right side."""
        times = self.times
        k = int(last_sample(times, time))
        if k < 0 or k >= times.size - 1:
            return float(np.clip(k, 0, times.size - 1))
        # the right side of a jump stands a little after the time of the event
        return float(k + max(time - times[k], 0.0) / (times[k + 1] - times[k]))

    def beside(self, k: float) -> str:
        """Return in words which side of a jump sample k is; empty where there is none."""
        return self._sides.get(k, "")

    @cached_property
    def _sides(self) -> dict[float, str]:
        found: dict[float, str] = {}
        for event in self.history.events:
            left, right = (int(find(self.times, event.time)) for find in (first_sample, last_sample))
            if left < right:
                found.setdefault(left, f"just before the {event.kind.value}")
                found[right] = f"just after the {event.kind.value}"
        return found

    @cached_property
    def true(self) -> BeamGeometry:
        """The same beam without magnification."""
        return self if self.factor == self.thickness == 1.0 else BeamGeometry(self.history, 1.0, 1.0, self.sides)

    def _fitting_factor(self) -> float:
        """Return the round number that shows the largest deviation of the run from the chord.

        Of a beam that touches elsewhere it is 1: magnified, it would not touch what it touches.
        """
        if not self.at_point:
            return 1.0
        axes = np.stack([self.stations + self.values("ux"), self.values("uy")], axis=-1)
        largest = float(np.nanmax(np.linalg.norm(axes - self.chord(axes), axis=-1), initial=0.0))
        wanted = _VISIBLE * self.scenario.beam.length / max(largest, 1e-300)
        return max(f for f in _FACTORS if f <= max(wanted, 1.0))

    # Sizes ----------------------------------------------------------------------------------------------------

    @cached_property
    def radii(self) -> Array:
        """Drawn distance (m) of the outer fibre from the axis at the stations, the radius of a round beam."""
        return np.asarray(self.thickness * self.sections.fibre_distance(self.stations))

    @cached_property
    def mass_radius(self) -> float:
        """Radius (m) of the sphere that masses at the tip are drawn as, of the beam's density; 0 without one."""
        return self.sphere(self.scenario.beam.length)

    def sphere(self, place: float) -> float:
        """Radius (m) of the sphere of the point masses at a place (m), of the beam's density; 0 without one."""
        mass = sum(point.mass for point in self.sections.masses if point.place == place)
        radius = self.thickness * float(np.cbrt(0.75 * mass / self.sections.density / np.pi))
        return max(radius, self.thickness * float(self.sections.fibre_distance(place))) if mass > 0.0 else 0.0

    @cached_property
    def touch_radius(self) -> float:
        """Distance (m) of the beam's face from its axis at the contact point, or the radius of a mass there."""
        point = self.scenario.contact.point
        at_tip = point == self.scenario.beam.length
        radius = self.thickness * float(self.sections.fibre_distance(point))
        return max(radius, self.mass_radius if at_tip else 0.0)

    @property
    def slope_depth(self) -> float:
        """Distance (m) of the drawn surface of the slope below its line.

        It is half the drawn depth of the beam where contact is on the axis, so that the beam's face touches the
        surface; else what the beam is drawn too deep.
        """
        deep = 0.0 if self.scenario.contact.surface == "axis" else self.touch_radius / self.thickness
        return self.touch_radius - deep

    @property
    def flat_end(self) -> bool:
        """Whether the beam ends in a plane: one with corners, or one that touches with its edge; not in a mass."""
        s = self.scenario
        edge = s.contact_fibre != 0.0 and s.contact.point == s.beam.length
        return self.mass_radius == 0.0 and (edge or has_corners(s.beam.section.shape))

    @cached_property
    def half_width(self) -> float:
        """Largest extent (m) of the beam out of the plane of motion, to one side."""
        return float(self.solid.offsets[:, 2].max())

    @cached_property
    def near_edge(self) -> Array:
        """Distance (m) of the beam's near edge from the plane of motion, at the stations; 0 for a round beam."""
        rings = self.solid.offsets[: self.sides * self.stations.size, 2].reshape(-1, self.sides)
        return np.asarray(rings.max(axis=1) * has_corners(self.scenario.beam.section.shape))

    @property
    def outer_point(self) -> str:
        """Name of the far end of the chord."""
        at_tip = self.touch == self.stations.size - 1
        return "tip" if at_tip and not self.scenario.contact.enabled else "contact point"

    @cached_property
    def clamped(self) -> bool:
        """Whether the root stands still: it is driven, and does not turn in the run."""
        return self.scenario.root.kind == "driven" and float(np.ptp(self.values("theta"))) == 0.0

    @property
    def inner_point(self) -> str:
        """Name of the near end of the chord."""
        return {"driven": "root", "free": "first end"}.get(self.scenario.root.kind, self.scenario.root.kind)

    def deflection_words(self, factor: float) -> str:
        """Return in words how deflections are drawn that are magnified by a factor."""
        if factor == 1.0:
            return "deflection drawn true to scale"
        return f"deflection drawn ×{factor:g} about the line from {self.inner_point} to {self.outer_point}"

    @cached_property
    def slope_axes(self) -> Array:
        """Unit vectors up along the slope and out of it (2, 2), in the inertial frame."""
        c, s = np.cos(self.scenario.slope.angle), np.sin(self.scenario.slope.angle)
        return np.array([(c, s), (-s, c)])

    # Contact --------------------------------------------------------------------------------------------------

    @property
    def at_point(self) -> bool:
        """Whether nothing of the beam can touch but the contact point, the outer end of the chord, the slope."""
        place, *others = self._places
        return place.obstacle == 0 and place.numbers[0] == self.scenario.contact.point and not others

    def contact_point(self, k: float) -> Array:
        """Return the inertial position (2,) of the contact point, on the axis or on the beam's face."""
        return np.array([self.value("tip_x", k), self.value("tip_y", k)])

    def contact_place(self, k: float) -> Array:
        """Return the one of `near_places` (3,) that is `close_contact`."""
        return np.asarray(self.near_places(k)[self.close_contact(k)])

    def near_places(self, k: float) -> Array:
        """Return the near ends (contacts, 3) of the lines across the beam along which it touches what is drawn."""
        depth = np.interp(self.value("contact_place", k), self.stations, self.near_edge)
        return np.column_stack([self.contact_places(k), depth])

    def contact_places(self, k: float) -> Array:
        """Return where the beam's face touches the drawn obstacles, or would, (contacts, 2)."""
        points = np.stack([self.value("contact_x", k), self.value("contact_y", k)], axis=1)
        return np.asarray(points - self.slope_depth * self.contact_normals(k))

    def contact_normals(self, k: float) -> Array:
        """Return the normals of the contacts (contacts, 2), those of points across the drawn axis."""
        across, along = self._directions(self.centreline(k)[:, :2])[1], self.value("contact_place", k)
        found = np.array([np.interp(along, self.stations, part) for part in across.T]).T
        for i, place in enumerate(self._places):
            angle, side = place.numbers[1], place.numbers[4]
            found[i] = (-np.sin(angle), np.cos(angle)) if place.on_side else side * found[i]
        return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))

    def side_of(self, point: ObstaclePoint) -> float:
        """Return on which side of a point the beam is, seen along it: 1 on its left, -1 on its right."""
        seen = point.seen_from(self.scenario.root_axis, self.scenario.initial.angle)
        return float(-np.copysign(1.0, seen.imag))

    @cached_property
    def main_contact(self) -> int:
        """Number of the contact that pushes most in the run."""
        return int(np.argmax(np.nansum(np.abs(self.values("contact_lambda_n")), axis=0)))

    def close_contact(self, k: float) -> int:
        """Return the number of the contact that is shown from close by at sample k.

        It is the main one.  Where the beam can touch its obstacle at several places, or other sides, or a peg
        beside it, it is one of those that are closed until that opens, then the one that pushes most; in flight
        the last one.
        """
        return int(self._close_contacts[int(k)])

    @cached_property
    def _close_contacts(self) -> Integers:
        shown = np.full(self.times.size, self.main_contact)
        obstacles, on_sides = self.values("contact_obstacle"), np.array([place.on_side for place in self._places])
        own = (obstacles == obstacles[self.main_contact]) | (on_sides & on_sides[self.main_contact])
        points = np.array([complex(*place.numbers[:2]) for place in self._places])
        away = np.abs(points - points[self.main_contact])
        own |= ~on_sides & ~on_sides[self.main_contact] & (away < _BESIDE * self.scenario.beam.length)
        if np.count_nonzero(own) == 1:
            return shown
        closed = (self.values("contact_state") != State.FREE) & own
        strongest = np.where(closed, np.nan_to_num(self.values("contact_lambda_n")), -1.0).argmax(axis=1)
        touching = closed.any(axis=1)
        now = int(strongest[touching.argmax()]) if touching.any() else self.main_contact
        for k in range(self.times.size):
            if touching[k] and not closed[k, now]:
                now = int(strongest[k])
            shown[k] = now
        return shown

    def pushes(self, k: float) -> Array:
        """Return the force of each contact on the beam in the inertial frame (N), (contacts, 2)."""
        force = np.stack([self.value("contact_fx", k), self.value("contact_fy", k)], axis=1)
        # time-stepping has no sample at an event: what is open at a sample pushes from the next one on
        return np.asarray(np.nan_to_num(force) * self.closed(k)[:, None])

    def closed(self, k: float) -> NDArray[np.bool_]:
        """Return which contacts are closed at sample k, between two samples at the one before."""
        return np.asarray(self.values("contact_state")[int(k)] != State.FREE)

    @cached_property
    def zoned(self) -> list[int]:
        """The obstacles that have a `Zone` where the beam touches them: none where a single point of it can."""
        return [] if self.at_point else sorted({place.obstacle for place in self._places})

    def zones(self, k: float) -> list[Zone]:
        """Return where the beam touches its `zoned` obstacles at sample k, by obstacle."""
        closed = np.flatnonzero(self.closed(k))
        obstacles, places = self.values("contact_obstacle")[closed], self.value("contact_place", k)[closed]
        theta = float(self.value("theta", k))
        lifts = self.contact_normals(k)[closed] @ (-np.sin(theta), np.cos(theta))
        return [
            Zone(int(o), float(places[own].min()), float(places[own].max()), -float(np.sign(lifts[own][0])))
            for o, own in ((o, obstacles == o) for o in self.zoned if o in obstacles)
        ]

    def masses(self, k: float) -> Array:
        """Return where the inner masses are drawn at sample k, (masses, 3)."""
        return self.on_axis([point.place for point in self.inner_masses], k)

    @cached_property
    def inner_masses(self) -> list[PointMass]:
        """Point masses inside of the span, one at each place; those at the tip are part of the beam's shape."""
        inner = {point.place: point for point in self.sections.masses if point.place < self.scenario.beam.length}
        return list(inner.values())

    def disc(self, place: float) -> float:
        """Radius (m) of the disc of the point masses at a place (m); those without mass, which turn alone, too."""
        return self.sphere(place) or self.thickness * float(self.sections.fibre_distance(place))

    def applied_forces(self, k: float) -> tuple[Array, Array]:
        """Return places (forces, 3) and values (forces, 2) in the inertial frame (N) of forces on the beam."""
        forces = forces_of(self.scenario)
        if forces is None:
            return np.zeros((0, 3)), np.zeros((0, 2))
        theta, time = np.atleast_1d(self.value("theta", k)), np.atleast_1d(self.value("time", k))
        slopes = np.interp(forces.places, self.stations, self.along("section_rotation", k))
        found = [forces.in_frame(i, time, theta, slope[None])[0] for i, slope in enumerate(slopes)]
        if self.scenario.is_absolute:  # where a force across the beam turns as far as its section
            bent = self._bent(k)
            tangents = np.interp(forces.places, self.stations, self._derivative @ (bent.arms + bent.u))
            turned = 1j * tangents / np.abs(tangents)
            values = [force_value(forces, i, float(time[0])) for i in range(slopes.size)]
            found = [
                v * t if of.follows else f for v, t, of, f in zip(values, turned, forces.each, found, strict=True)
            ]
        return self.on_axis(forces.places, k), _components(np.exp(1j * theta[0]) * np.array(found))

    @cached_property
    def peak_applied(self) -> float:
        """Largest force on the beam (N); 0 if there is none."""
        return max((item.largest for item in self.scenario.acting_forces), default=0.0)

    def on_axis(self, places: Array | list[float], k: float) -> Array:
        """Return points of the drawn axis at places (m), (places, 3)."""
        axis = self.centreline(k)
        return np.column_stack([np.interp(places, self.stations, part) for part in axis.T])

    def contact_forces(self, k: float) -> tuple[Array, Array]:
        """Return normal and tangential force (2,) of the slope on the beam in the inertial frame (N)."""
        tangent, normal = self.slope_axes
        return self.value("lambda_n", k) * normal, self.value("lambda_tau", k) * tangent

    def contact_force(self, k: float) -> Array:
        """Return the force (3,) of slope and obstacles on the beam in the inertial frame (N)."""
        return np.append(self.pushes(k).sum(axis=0), 0.0)

    @cached_property
    def peak_force(self) -> float:
        """Largest resultant of the contact force (N) that float32 can hold; 0 if there is none."""
        size = np.hypot(self.values("contact_fx"), self.values("contact_fy"))
        return float(np.max(size[size < np.finfo(np.float32).max], initial=0.0))

    def force_text(self, force: float) -> str:
        """Return a contact force (N) with three digits, or all whole ones; empty if it is small in this run."""
        if not force > 1e-3 * self.peak_force:
            return ""
        return f"{force:.0f} N" if force >= 100.0 else f"{force:#.3g} N"

    def close_gap(self, k: float) -> tuple[float, float]:
        """Return the gap (m) of the `close_contact` at sample k, and the one that is drawn.

        On a compliant stop the coordinates, which are drawn, leave out a part of the beam's own flexibility.
        """
        gap, drawn = (
            _between(gaps, k)[self.close_contact(k)] for gaps in (self._gaps, self.values("contact_gap"))
        )
        return float(gap), float(drawn)

    def close_values(self, name: str) -> Array:
        """Return the `gap` (m) or the `slip_rate` (m/s) of the `close_contact`, (samples,)."""
        values = self._gaps if name == "gap" else self.values(f"contact_{name}")
        return np.take_along_axis(values, self._close_contacts[:, None], axis=1)[:, 0]

    @cached_property
    def _gaps(self) -> Array:
        """Gaps (m) of the contacts, (samples, contacts), that of a single one as `contact_gap` has it."""
        return contact_gap(self.history)[:, None] if len(self._places) == 1 else self.values("contact_gap")

    # Axis -----------------------------------------------------------------------------------------------------

    def stations_at(self, k: float | Integers) -> Array:
        """Return the true axis in the inertial frame at sample k, (stations, 2), or at several, (samples, ...)."""
        return _components(self._bent(k).point())

    def _bent(self, k: float | Integers) -> BentBeam:
        """Return the axis at sample k, or at several."""
        names: tuple[str, ...] = ("theta", "theta_dot", "ux", "uy", "ux_dot", "uy_dot")
        if self.scenario.root.is_free:
            names += OF_A_FREE_BEAM
        sample = {"station": self.stations} | {name: self.value(name, k) for name in names}
        return BentBeam.of_history(self.scenario, sample)

    def centreline(self, k: float) -> Array:
        """Return the drawn axis at sample k, (stations, 3), to be read only."""
        last, axis = self._last_axis
        if last != k:  # a frame asks for it a dozen times
            axis = np.insert(self.magnify(self.stations_at(k), self.factor), 2, 0.0, axis=1)
            self._last_axis = k, axis
        return axis

    def chord(self, axes: Array) -> Array:
        """Return the stations on the lines through root and contact point of axes, both (..., stations, 2)."""
        root, touch = axes[..., :1, :], axes[..., self.touch, None, :]
        return np.asarray(root + (self.stations / self.stations[self.touch])[:, None] * (touch - root))

    def magnify(self, axes: Array, factor: float) -> Array:
        """Return axes (..., stations, 2) with their deviations from the chord times a factor."""
        if factor == 1.0:
            return axes
        chord = self.chord(axes)
        return np.asarray(chord + factor * (axes - chord))

    # Surface --------------------------------------------------------------------------------------------------

    @cached_property
    def solid(self) -> Solid:
        """Points of the tube beside its axis, and its faces."""
        radii, mass_radius = self.radii / self.thickness, self.mass_radius / self.thickness
        solid = solid_of(self.scenario.beam, self.stations, radii, mass_radius, self.flat_end, self.sides)
        return solid._replace(offsets=self.thickness * solid.offsets)

    def tube(self, k: float) -> tuple[Array, Array]:
        """Return points and outward normals (np, 3) of the tube at sample k; its rings turn with the sections."""
        solid, axis = self.solid, self.centreline(k)[:, :2]
        tangent, normal = self._directions(axis)

        def turned(vectors: Array) -> Array:
            plane = vectors[:, :1] * tangent[solid.rings] + vectors[:, 1:2] * normal[solid.rings]
            return np.concatenate([plane, vectors[:, 2:]], axis=1)

        points = turned(solid.offsets)
        points[:, :2] += axis[solid.rings]
        return points, turned(solid.directions)

    def face(self, k: float, side: float) -> Array:
        """Return the outer fibre (stations, 2) at sample k on a side of the axis, 1 its left or -1 its right."""
        axis = self.centreline(k)[:, :2]
        return np.asarray(axis + side * self.radii[:, None] * self._directions(axis)[1])

    def _directions(self, axis: Array) -> tuple[Array, Array]:
        """Return the unit vectors along a drawn axis (stations, 2) and to its left."""
        tangent = self._derivative @ axis
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        return tangent, np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)

    def outline(self, k: float) -> Array:
        """Return the outline (points, 2) of the tube at sample k: along one side, around the tip and back."""
        points = self.tube(k)[0][:, :2]
        rings = points[:-2].reshape(-1, self.sides, 2)
        return np.concatenate([rings[:, 0], points[-2:-1], rings[::-1, self.sides // 2]])

    # Results --------------------------------------------------------------------------------------------------

    def result(self, name: str, k: float) -> Array:
        """Return one of `QUANTITIES` at the points of the tube, (np, ...), at sample k.

        Stresses follow the height in the section.
        """
        rings, heights = self.solid.rings, self.solid.offsets[:, 1]
        if not name.endswith("_stress"):
            return np.asarray(self.along(name, k)[rings])
        # the history has the bending stress at the outer fibre on the side of negative heights
        stress = -(self.value("bending_stress", k) / self.radii)[rings] * heights
        if name == "axial_stress":
            stress += (self.along("axial_force", k) / self.sections.area(self.stations))[rings]
        return np.asarray(stress)

    def along(self, name: str, k: float) -> Array:
        """Return one of `QUANTITIES` but the stresses on the axis, (stations,), at sample k.

        Vectors, (stations, 3), are in the inertial frame.  The elastic displacement is that from the straight beam
        in the floating frame, the section's rotation that against this frame.
        """
        if name in _VARIABLES:
            return self.value(name, k)
        bent = self._bent(k)
        if name == "section_rotation":
            return np.asarray(self._derivative @ bent.u.imag)
        vector = bent.velocity() if name == "velocity" else np.exp(1j * bent.theta) * bent.u
        return np.insert(_components(vector), 2, 0.0, axis=1)

    def at_fibres(self, name: str, samples: Integers | slice = slice(None)) -> tuple[Array, Array]:
        """Return a scalar result at the lower and at the upper fibre of the stations, (samples, stations) each."""
        if name == "section_rotation":
            rotation = self.values("uy")[samples] @ self._derivative.T
            return rotation, rotation
        if name in _VARIABLES:
            return self.values(name)[samples], self.values(name)[samples]
        bending, mean = self.values("bending_stress")[samples], np.zeros(1)
        if name == "axial_stress":
            mean = self.values("axial_force")[samples] / self.sections.area(self.stations)
        return mean + bending, mean - bending

    @cached_property
    def _derivative(self) -> Array:
        """Derivatives (1/m) at the stations of the cubic splines that are 1 at one of them and 0 at the others."""
        return np.asarray(CubicSpline(self.stations, np.eye(self.stations.size))(self.stations, 1))


def _between(values: Array, k: float | Integers) -> Array:
    """Return the values (samples, ...) at sample k, or at several."""
    if isinstance(k, np.ndarray):
        return values[k]
    low = int(k)
    if k == low:
        return np.asarray(values[low])
    return np.asarray(values[low] + (k - low) * (values[low + 1] - values[low]))


def _components(vectors: NDArray[np.complex128]) -> Array:
    """Return the components (..., 2) of x + i y."""
    return np.stack([vectors.real, vectors.imag], axis=-1)

"""The deformed beam as a centreline and a swept tube with its results, from a history alone.

Between the stations of a history the displacements follow cubic splines; the stations themselves are met
exactly.  A deformation factor magnifies the deviation of the axis from the straight line through pin and
contact point and nothing else, so that both stay where they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from oblique_impact.beam.cross_sections import Sections
from oblique_impact.contact.state import State
from oblique_impact.errors import InputError
from oblique_impact.history.history import History
from oblique_impact.history.sample_times import last_sample
from oblique_impact.problem import contact_law_of
from oblique_impact.renders.outlines import SIDES, Solid, has_corners, solid_of
from oblique_impact.scenario.scenario import Scenario

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

BETWEEN = 1  # rings between two stations
CAP_RINGS = 6  # of the hemispherical tip cap; twice as many of a mass
_FACTORS = (1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 30.0, 50.0, 100.0)
_SMOOTH = 1e100  # what is larger, or no number, has no spline
_VISIBLE = 0.06  # of the length: what a deviation is magnified to

#: results along the beam that the surface carries, with their units
QUANTITIES = {
    "elastic_displacement": "m",
    "velocity": "m/s",
    "section_rotation": "rad",
    "bending_moment": "N m",
    "shear_force": "N",
    "axial_force": "N",
    "bending_stress": "Pa",
    "axial_stress": "Pa",
}


#: variables of a history that pictures, pages and exports are made from
NEEDED = (
    *("time", "station", "state", "theta", "theta_dot", "ux", "uy", "ux_dot", "uy_dot"),
    *("tip_x", "tip_y", "tip_vx", "tip_vy"),
    *(
        "moment",
        "shear",
        "axial_force",
        "bending_stress",
        "lambda_n",
        "lambda_tau",
        "gap",
        "gap_rate",
        "slip_rate",
    ),
    *("deflection", "energy_kinetic", "energy_elastic", "energy_gravity"),
)


@dataclass(frozen=True)
class Surface:
    """Points and outward normals (np, 3) of the tube at one sample and its results there."""

    points: Array
    normals: Array
    arrays: dict[str, Array]


def contact_gap(history: History) -> Array:
    """Gap (m) of the contact point itself, (samples,): in contact with a compliant stop its compression, negative.

    The variable `gap` is that of the coordinates: what they leave out of the contact point is not in it.
    """
    gap = np.asarray(history["gap"].values, dtype=float)
    if "depth" not in history or contact_law_of(Scenario.from_toml(history.scenario_toml)) is None:
        return gap
    return np.where(history["state"].values == State.FREE, gap, -history["depth"].values)


def _between(values: Array, k: float) -> Array:
    """Return the values (samples, ...) at the fractional sample k."""
    low = int(k)
    if k == low:
        return np.asarray(values[low])
    return np.asarray(values[low] + (k - low) * (values[low + 1] - values[low]))


class BeamGeometry:
    """Shapes of the beam at the samples of a history, which has the variables `NEEDED`.

    The deformation factor is chosen from the largest deviation of the run if none is given.  Raises InputError if
    the history lacks a variable (it is not one of a beam) or the factor is not positive and finite.
    """

    def __init__(self, history: History, factor: float | None = None) -> None:
        missing = [name for name in NEEDED if name not in history.data.variables]
        if missing:
            raise InputError(
                f"history: has no variable {missing[0]!r}: it is not one of a beam, or of another version"
            )
        if factor is not None and not 0.0 < factor < np.inf:
            raise InputError(f"--deformation {factor}: should be a positive number")
        self.history = history
        self.scenario = Scenario.from_toml(history.scenario_toml)
        self.sections = Sections.from_scenario(self.scenario)
        self._given = factor
        self._read: dict[str, Array] = {}

    @cached_property
    def times(self) -> Array:
        """Times (s) of the samples, ascending."""
        return self._values("time")

    @cached_property
    def stations(self) -> Array:
        """Arc lengths (m) of the stations."""
        return self._values("station")

    @cached_property
    def places(self) -> Array:
        """Arc lengths (m) of the rings: the stations and `BETWEEN` places between two."""
        parts = np.arange(BETWEEN + 1) / (BETWEEN + 1)
        inner = self.stations[:-1, None] + parts * np.diff(self.stations)[:, None]
        return np.append(inner.ravel(), self.stations[-1])

    @cached_property
    def factor(self) -> float:
        """Deformation factor: as given, or the round number that shows the largest deviation of the run."""
        if self._given is not None:
            return float(self._given)
        wanted = _VISIBLE * self.scenario.beam.length / max(self._largest_deviation(), 1e-300)
        return max(f for f in _FACTORS if f <= max(wanted, 1.0))

    @cached_property
    def true(self) -> BeamGeometry:
        """The same beam without magnification."""
        return self if self.factor == 1.0 else BeamGeometry(self.history, 1.0)

    @cached_property
    def radii(self) -> Array:
        """Distance (m) of the outer fibre from the axis at the rings, the radius of a round beam."""
        return np.asarray(self.sections.fibre_distance(self.places) * np.ones_like(self.places))

    @cached_property
    def touch_radius(self) -> float:
        """Distance (m) of the beam's face from its axis at the contact point, or the radius of a mass there."""
        point = self.scenario.contact.point
        at_tip = point == self.scenario.beam.length
        return max(float(self.sections.fibre_distance(point)), self.mass_radius if at_tip else 0.0)

    @property
    def slope_depth(self) -> float:
        """How far (m) the drawn surface of the slope lies below its line.

        Where contact is on the axis that is half the depth of the beam: so its face touches what is drawn.
        """
        return self.touch_radius if self.scenario.contact.surface == "axis" else 0.0

    @cached_property
    def mass_radius(self) -> float:
        """Radius (m) of the sphere that a mass at the tip is drawn as, of the beam's density; 0 without one."""
        volume = self.sections.tip_mass / self.sections.density
        return max(float(np.cbrt(0.75 * volume / np.pi)), float(self.radii[-1])) if volume > 0.0 else 0.0

    @property
    def flat_end(self) -> bool:
        """Whether the beam ends in a plane: one with corners, or one that touches with its edge; not in a mass."""
        s = self.scenario
        edge = s.contact_fibre != 0.0 and s.contact.point == s.beam.length
        return self.mass_radius == 0.0 and (edge or has_corners(s.beam.section.shape))

    @cached_property
    def half_width(self) -> float:
        """Largest extent (m) of the beam out of the plane of motion, to one side."""
        return float(self._solid.offsets[:, 2].max())

    @property
    def _cap_rings(self) -> int:
        return 2 * CAP_RINGS if self.mass_radius > 0.0 else CAP_RINGS

    @cached_property
    def slope_axes(self) -> Array:
        """Unit vectors up along the slope and out of it (2, 2), in the inertial frame."""
        c, s = np.cos(self.scenario.slope.angle), np.sin(self.scenario.slope.angle)
        return np.array([(c, s), (-s, c)])

    def index(self, time: float) -> float:
        """Fractional number of the sample at a time (s): between two samples everything is interpolated linearly.

        At a jump it is that of the right-hand value; times outside of the run give its first or last sample.
        """
        times = self.times
        k = int(last_sample(times, time))
        if k < 0 or k >= times.size - 1:
            return float(np.clip(k, 0, times.size - 1))
        # the right side of a jump stands a little after the time of the event
        return float(k + max(time - times[k], 0.0) / (times[k + 1] - times[k]))

    def value(self, name: str, k: float) -> Array:
        """Values of a variable of the history at the fractional sample k."""
        return _between(self._values(name), k)

    def gap(self, k: float) -> float:
        """Gap (m) of the contact point itself at the fractional sample k, see `contact_gap`."""
        return float(_between(self._gap, k))

    # Axis -----------------------------------------------------------------------------------------------------

    def stations_at(self, k: float) -> Array:
        """Inertial positions (stations, 2) of the axis at sample k, without magnification."""
        x = self.scenario.root.hub_radius + self.stations + self.value("ux", k)
        return _turned(self.value("theta", k), x, self.value("uy", k))

    def stations_of(self, samples: NDArray[np.int64]) -> Array:
        """Inertial positions (samples, stations, 2) of the axis at several samples, without magnification."""
        x = self.scenario.root.hub_radius + self.stations + self._values("ux")[samples]
        return _turned(self._values("theta")[samples][:, None], x, self._values("uy")[samples])

    def contact_point(self, k: float) -> Array:
        """Inertial position (2,) of the contact point, on the axis or on the beam's face."""
        on_axis, low = np.asarray(self.stations_at(k)[self._touch]), int(k)
        if self.scenario.contact_fibre == 0.0:
            return on_axis
        part, high = k - low, min(low + 1, self.times.size - 1)
        across = (1.0 - part) * self._fibre[low] + part * self._fibre[high]
        return on_axis + _turned(self.value("theta", k), across.real, across.imag)

    def contact_place(self, k: float) -> Array:
        """Return where the beam touches the drawn slope (3,)."""
        return np.append(self.contact_point(k) - self.slope_depth * self.slope_axes[1], 0.0)

    def contact_forces(self, k: float) -> tuple[Array, Array]:
        """Return normal and tangential force (2,) of the slope on the beam in the inertial frame (N)."""
        tangent, normal = self.slope_axes
        return self.value("lambda_n", k) * normal, self.value("lambda_tau", k) * tangent

    @cached_property
    def peak_force(self) -> float:
        """Largest resultant of the contact force (N) that float32 can hold; 0 if there is none."""
        size = np.hypot(self._values("lambda_n"), self._values("lambda_tau"))
        return float(np.max(size[size < np.finfo(np.float32).max], initial=0.0))

    def centreline(self, k: float) -> Array:
        """Return the drawn axis at the rings, (rings, 3); the stations are every `BETWEEN` + 1 of them."""
        return _flat(self._drawn_axis(k))

    def _drawn_axis(self, k: float) -> Array:
        """Return the drawn axis at the rings, (rings, 2)."""
        true = self._axis(k)
        if self.factor == 1.0:
            return true
        chord = self._chord(k)
        return np.asarray(chord + self.factor * (true - chord))

    @cached_property
    def _touch(self) -> int:
        """Number of the station at the contact point."""
        return int(np.argmin(np.abs(self.stations - self.scenario.contact.point)))

    @cached_property
    def _fibre(self) -> NDArray[np.complex128]:
        """From the axis to the contact point (m) at the samples, in the floating frame."""
        arm = self.scenario.root.hub_radius + self.stations[self._touch] + self._values("ux")[:, self._touch]
        tip = self._values("tip_x") + 1j * self._values("tip_y")
        return np.asarray(
            tip * np.exp(-1j * self._values("theta")) - arm - 1j * self._values("uy")[:, self._touch]
        )

    def _axis(self, k: float) -> Array:
        """Return the true axis at the rings, (rings, 2)."""
        ux, uy = (self._between(name, k) for name in ("ux", "uy"))
        x = self.scenario.root.hub_radius + self.places + ux
        return _turned(self.value("theta", k), x, uy)

    def _chord(self, k: float) -> Array:
        """Straight line through the root and the contact point, at the rings (rings, 2)."""
        ends = self.stations_at(k)
        return np.asarray(
            ends[0] + (self.places / self.stations[self._touch])[:, None] * (ends[self._touch] - ends[0])
        )

    def _largest_deviation(self) -> float:
        """Largest distance (m) of the axis from that line, over all samples and stations."""
        x, y = self.stations + self._values("ux"), self._values("uy")
        part = self.stations / self.stations[self._touch]
        dx, dy = (v - v[:, :1] - part * (v[:, self._touch, None] - v[:, :1]) for v in (x, y))
        return float(np.nanmax(np.hypot(dx, dy), initial=0.0))

    # Tube -----------------------------------------------------------------------------------------------------

    @cached_property
    def faces(self) -> Faces:
        """Triangles and quadrilaterals of the tube in VTK's form (3 or 4, then points), wound outward."""
        rings = self.places.size + self._cap_rings - 1
        i, j = np.arange(rings - 1)[:, None], np.arange(SIDES)[None]
        a, b = i * SIDES + j, i * SIDES + (j + 1) % SIDES
        quads = np.stack([np.full_like(a, 4), a, b, b + SIDES, a + SIDES], axis=-1).reshape(-1)
        last, side = (rings - 1) * SIDES, np.arange(SIDES)
        pole, centre = rings * SIDES, rings * SIDES + 1
        tip = np.stack([np.full(SIDES, 3), last + side, last + (side + 1) % SIDES, np.full(SIDES, pole)], axis=-1)
        root = np.stack([np.full(SIDES, 3), np.full(SIDES, centre), (side + 1) % SIDES, side], axis=-1)
        return np.concatenate([quads, tip.reshape(-1), root.reshape(-1)])

    @cached_property
    def _solid(self) -> Solid:
        beam = self.scenario.beam
        return solid_of(beam, self.places, self.radii, self.mass_radius, self._cap_rings, self.flat_end)

    @cached_property
    def _template(self) -> tuple[NDArray[np.int64], Array]:
        """Per point of the solid: its ring, and its offsets (m) along the axis, across it, and out of the plane.

        The rings, those of the tip, its pole, and the centre of the root.
        """
        return self._solid.rings, self._solid.offsets

    @cached_property
    def _directions(self) -> Array:
        """Outward normals of the solid at its points, along the axis, across it, and out of the plane."""
        return self._solid.directions

    def surface(self, k: float) -> Surface:
        """Tube at sample k with all results."""
        return Surface(*self.tube(k), {name: self.result(name, k) for name in QUANTITIES})

    def tube(self, k: float) -> tuple[Array, Array]:
        """Points and outward normals (np, 3) of the tube at sample k, whose rings are turned as the sections."""
        rings, offsets = self._template
        axis = self._drawn_axis(k)
        tangent = np.gradient(axis, self.places, axis=0, edge_order=2)
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)

        def turned(vectors: Array) -> Array:
            plane = vectors[:, :1] * tangent[rings] + vectors[:, 1:2] * normal[rings]
            return np.concatenate([plane, vectors[:, 2:]], axis=1)

        points = turned(offsets)
        points[:, :2] += axis[rings]
        return points, turned(self._directions)

    def result(self, name: str, k: float) -> Array:
        """Values (np, ...) of one of `QUANTITIES` at the points of the tube at sample k.

        Stresses follow the height in the section.
        """
        rings, offsets = self._template
        if not name.endswith("_stress"):
            return np.asarray(self._result_along(name, k)[rings])
        stress = -(self._result_along("bending_moment", k) / self._second_moments)[rings] * offsets[:, 1]
        if name == "axial_stress":
            stress += (self._result_along("axial_force", k) / self._areas)[rings]
        return np.asarray(stress)

    @cached_property
    def _second_moments(self) -> Array:
        """Second moments of area (m^4) at the rings."""
        return self.sections.second_moment(self.places)

    @cached_property
    def _areas(self) -> Array:
        """Areas (m^2) at the rings."""
        return self.sections.area(self.places)

    def outline(self, k: float) -> Array:
        """Outline (points, 2) of the tube at sample k in the plane: along one side, around the tip and back."""
        points = self.tube(k)[0][:, :2]
        sides = points[:-2].reshape(-1, SIDES, 2)
        return np.concatenate([sides[:, 0], points[-2:-1], sides[::-1, SIDES // 2]])

    def along(self, k: float) -> dict[str, Array]:
        """Results on the axis at the rings: vectors (rings, 3) in the inertial frame, scalars (rings,).

        The elastic displacement is that from the straight beam in the floating frame, the section's rotation that
        against this frame.
        """
        return {name: self._result_along(name, k) for name in QUANTITIES if not name.endswith("_stress")}

    def _result_along(self, name: str, k: float) -> Array:
        if name == "elastic_displacement":
            return _flat(_turned(self.value("theta", k), *(self._between(n, k) for n in ("ux", "uy"))))
        if name == "velocity":
            theta, spin = self.value("theta", k), self.value("theta_dot", k)
            ux, uy, u_rate, v_rate = (self._between(n, k) for n in ("ux", "uy", "ux_dot", "uy_dot"))
            arm = self.scenario.root.hub_radius + self.places + ux
            return _flat(_turned(theta, u_rate - spin * uy, v_rate + spin * arm))
        if name == "section_rotation":
            return np.asarray(self._splines[1] @ self.value("uy", k))
        if name == "bending_moment":
            return self._between("moment", k)
        return self._linear({"shear_force": "shear"}.get(name, name), k)

    # Samples --------------------------------------------------------------------------------------------------

    def _values(self, name: str) -> Array:
        if name not in self._read:
            self._read[name] = np.asarray(self.history[name].values, dtype=float)
        return self._read[name]

    @cached_property
    def _gap(self) -> Array:
        return contact_gap(self.history)

    @cached_property
    def _splines(self) -> tuple[Array, Array]:
        """Splines that are 1 at a station, 0 at others: values and derivatives (rings, stations) there."""
        splines = CubicSpline(self.stations, np.eye(self.stations.size))
        return splines(self.places), splines(self.places, 1)

    def _between(self, name: str, k: float) -> Array:
        """Values of a smooth variable at the rings; the stations exactly."""
        values = self.value(name, k)
        if not np.all(np.abs(values) < _SMOOTH):
            return self._linear(name, k)
        found = self._splines[0] @ values
        found[:: BETWEEN + 1] = values
        return np.asarray(found)

    def _linear(self, name: str, k: float) -> Array:
        """Values of a variable that may jump at a station."""
        return np.asarray(np.interp(self.places, self.stations, self.value(name, k)))


def _turned(theta: Array | float, x: Array, y: Array) -> Array:
    """Components (..., 2) in the inertial frame of (x, y) in a frame turned by theta."""
    c, s = np.cos(theta), np.sin(theta)
    return np.stack([x * c - y * s, x * s + y * c], axis=-1)


def _flat(plane: Array) -> Array:
    return np.concatenate([plane, np.zeros((*plane.shape[:-1], 1))], axis=-1)

"""Sections of a scenario: each key with its unit, range, default and meaning, and the checks within a section.

Checks across sections are in :mod:`oblique_impact.scenario.consistency`.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    PlainSerializer,
    PlainValidator,
    WithJsonSchema,
    field_validator,
    model_validator,
)

from oblique_impact.scenario.materials import MATERIAL_PROPERTIES
from oblique_impact.scenario.obstacles import Side
from oblique_impact.scenario.polylines import MAX_POINTS, Outline, Pairs, check_points, outline_of
from oblique_impact.scenario.section import InputSection, key
from oblique_impact.scenario.shapes import SHAPE_PROPERTIES, SHAPES, SIZES, at_x, size_conflict, value_at
from oblique_impact.scenario.tables import LARGEST, Size, Table, Tabulated
from oblique_impact.scenario.units import Unit

MAX_MODES = 100
MAX_ELEMENTS = 4096
MAX_GRADING = 1e4
MAX_GRID = 1024
#: parts of a beam in modes at whose ends it can touch sides
PARTS = 16
MAX_ROWS = 10_000
Positive = Annotated[float, Field(gt=0.0, le=LARGEST)]
NonNegative = Annotated[float, Field(ge=0.0, le=LARGEST)]
Finite = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Angle = Annotated[float, Field(ge=-2.0 * math.pi, le=2.0 * math.pi), Unit("rad")]
Pair = Annotated[tuple[Finite, Finite], Field(strict=False)]


def _first_and_last(extent: tuple[float, ...]) -> tuple[float, ...]:
    if extent and not (len(extent) == 2 and extent[0] < extent[1]):
        raise ValueError("[first, last] in m with first less than last, or [] without ends")
    return extent


Extent = Annotated[tuple[Finite, ...], Unit("m"), Field(strict=False), AfterValidator(_first_and_last)]


def _no_path(points: Any) -> Any:
    if isinstance(points, str):
        raise ValueError("a list of points [x, y]; a file of them is read with a scenario file or by --set")
    return points


def _outline(points: Pairs) -> Pairs:
    if points:
        check_points(points)
    return points


_POINT = {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}}
Points = Annotated[
    tuple[Pair, ...],
    Field(strict=False),
    AfterValidator(_outline),
    WithJsonSchema({"anyOf": [{"type": "array", "items": _POINT, "maxItems": MAX_POINTS}, {"type": "string"}]}),
    Unit("m"),
    BeforeValidator(_no_path),
]


class CrossSection(InputSection):
    """The cross-section by its shape; sizes are numbers, or tables [[x, value], ...] from x = 0 to the length."""

    shape: Literal["", "rectangle", "circle", "tube", "i-beam"] = key(
        "",
        "shape of the cross-section, which gives area, second moment and outer fibre; none: they are given",
    )
    width: Annotated[Size, Unit("m")] = key(0.0, "size across the plane of motion (rectangle, i-beam)")
    height: Annotated[Size, Unit("m")] = key(0.0, "size in the plane of motion (rectangle, i-beam)")
    diameter: Annotated[Size, Unit("m")] = key(0.0, "outer diameter (circle, tube)")
    thickness: Annotated[Size, Unit("m")] = key(0.0, "thickness of the wall (tube)")
    flange_thickness: Annotated[Size, Unit("m")] = key(0.0, "thickness of each of the two flanges (i-beam)")
    web_thickness: Annotated[Size, Unit("m")] = key(0.0, "thickness of the web (i-beam)")

    def conflicts(self) -> Iterator[tuple[str, str]]:
        """Yield sizes of other shapes, and those that are missing or impossible."""
        named = f'beam.section.shape = "{self.shape}"'
        sizes = SHAPES[self.shape].sizes if self.shape else ()
        for size in SIZES:
            is_given = getattr(self, size) != 0.0
            if is_given and size not in sizes:
                yield size, f"is no size of {named}, which takes {', '.join(sizes) or 'none; name a shape'}"
            if size in sizes and not is_given:
                yield size, f"should be greater than 0 for {named}"
        if wrong := size_conflict(self):
            yield "shape", f"these sizes are not possible: {wrong}"


class BeamSection(InputSection):
    """The beam; `area` and `second_moment` are numbers, or tables [[x, value], ...] from x = 0 to the length."""

    length: Annotated[Positive, Unit("m")] = key(1.0, "length of the undeformed axis")
    area: Annotated[Tabulated, Unit("m^2")] = key(3.14e-4, "area of the cross-section")
    second_moment: Annotated[Tabulated, Unit("m^4")] = key(7.85e-9, "second moment of area of the cross-section")
    density: Annotated[Positive, Unit("kg/m^3")] = key(2766.7, "mass per volume")
    youngs_modulus: Annotated[Positive, Unit("Pa")] = key(68.952e9, "Young's modulus")
    material: Literal["", "steel", "stainless-steel", "aluminium", "titanium", "brass", "copper"] = key(
        "", "a material by its name, which gives density and Young's modulus; none: they are given"
    )
    kelvin_voigt: Annotated[NonNegative, Unit("s")] = key(
        0.0, "Kelvin-Voigt damping: the damping matrix is kelvin_voigt K"
    )
    mass_proportional: Annotated[NonNegative, Unit("1/s")] = key(
        0.0, "mass-proportional damping: each elastic mode decays at half of it, the swing does not"
    )
    modal_damping_ratio: Annotated[float, Field(ge=0.0, lt=1.0)] = key(
        0.0, "damping ratio of each elastic mode of the beam on its pin, with its hub, held, or on root.stiffness"
    )
    tip_mass: Annotated[NonNegative, Unit("kg")] = key(0.0, "point mass at x = length")
    outer_fibre: Annotated[Size, Unit("m")] = key(
        0.0, "distance of the outer fibre from the axis, for the bending stress; 0: circular sections"
    )
    section: CrossSection = CrossSection()

    def conflicts(self) -> Iterator[tuple[str, str]]:
        """Yield keys that follow from shape or material and are given too, and tables that end elsewhere."""
        shape = "section.shape", self.section.shape, SHAPE_PROPERTIES
        for name, named, followers in (shape, ("material", self.material, MATERIAL_PROPERTIES)):
            for follower in followers if named else ():
                if follower in self.model_fields_set:
                    yield follower, f'follows from beam.{name} = "{named}"; give one of the two'
        for name, table in self.tables().items():
            if table[-1][0] != self.length:
                end = f"should end at x = beam.length = {self.length}, not at {table[-1][0]}"
                yield name, f"{end}; a new length needs new tables"

    def tables(self) -> dict[str, Table]:
        """Return the keys of this section that are given as tables over x."""
        values = {f"section.{size}": getattr(self.section, size) for size in SIZES}
        values |= {name: getattr(self, name) for name in SHAPE_PROPERTIES}
        return {name: value for name, value in values.items() if isinstance(value, tuple)}

    def fibre_distance(self, x: float) -> float:
        """Return the distance (m) of the outer fibre from the axis at x (m); sqrt(A/pi) if none is given."""
        if self.section.shape:
            return float(value_at(self.section, "outer_fibre", x))
        value = float(at_x(self.outer_fibre or self.area, x))
        return value if self.outer_fibre else math.sqrt(value / math.pi)


class RootSection(InputSection):
    """The support of the beam at x = 0."""

    kind: Literal["pin", "hub", "driven", "free"] = key(
        "pin",
        "a frictionless pin, a hub with inertia and torque, a root whose angle is prescribed, or `free`: nothing "
        'holds the beam (`discretization.method = "absolute"` alone)',
    )
    hub_radius: Annotated[NonNegative, Unit("m")] = key(0.0, "distance of the root from the axis of rotation")
    inertia: Annotated[NonNegative, Unit("kg m^2")] = key(0.0, "moment of inertia of the hub")
    torque: Annotated[Finite, Unit("N m")] = key(0.0, "torque on the hub")
    stiffness: Annotated[NonNegative, Unit("N m/rad")] = key(
        0.0,
        "rotational spring, of a hub to the ground (0: none), of a driven root's clamp that yields (0: rigid); "
        "unstrained at initial.angle and at the prescribed angle",
    )
    damping: Annotated[NonNegative, Unit("N m s/rad")] = key(0.0, "rotational dashpot beside root.stiffness")
    profile: Literal["hold", "constant-speed", "spin-up"] = key("hold", "prescribed rotation of a driven root")
    spin_rate: Annotated[Finite, Unit("rad/s")] = key(
        0.0, "angular velocity of a driven root, the final one of a spin-up"
    )
    spin_up_time: Annotated[NonNegative, Unit("s")] = key(0.0, "duration of a spin-up")

    def conflicts(self) -> Iterator[tuple[str, str]]:
        """Yield a radius of a pin, and a spin-up without its time."""
        if self.hub_radius > 0.0 and self.kind in ("pin", "free"):
            named = "a pin" if self.kind == "pin" else "a free root"
            yield "hub_radius", f'{named} has radius 0; use root.kind = "hub" or "driven"'
        if self.profile == "spin-up" and self.spin_up_time == 0.0:
            yield "spin_up_time", "should be greater than 0 for a spin-up"

    @property
    def is_moved(self) -> bool:
        """Whether the rotation of the root is prescribed, or the root is off the axis."""
        return self.kind == "driven" or self.hub_radius > 0.0

    @property
    def is_free(self) -> bool:
        """Whether nothing holds the beam."""
        return self.kind == "free"


class InitialSection(InputSection):
    """The beam at t = 0."""

    angle: Angle = key(math.pi / 4, "angle of the beam from the horizontal")
    angular_velocity: Annotated[Finite, Unit("rad/s")] = key(0.0, "angular velocity of the undeformed beam")
    position: Annotated[Pair, Unit("m")] = key(
        (0.0, 0.0), "place [x, y] of the middle of a beam that nothing holds, half of its length from either end"
    )
    velocity: Annotated[Pair, Unit("m/s")] = key(
        (0.0, 0.0), "velocity [vx, vy] of the middle of a beam that nothing holds"
    )
    state: Literal["undeformed", "equilibrium", "plucked"] = key(
        "undeformed",
        "the undeformed beam; the beam at rest under weight, torque, springs and contacts without friction, found "
        "from `angle` (`equilibrium`); or such a one that is held at `place` by `deflection` or `force` and "
        "released at t = 0 (`plucked`)",
    )
    place: Annotated[NonNegative, Unit("m")] = key(0.0, "where a plucked beam is held, along it from its root")
    deflection: Annotated[Finite, Unit("m")] = key(
        0.0,
        "how far a plucked beam is held at `place`, across its axis from where it rests without; left positive",
    )
    force: Annotated[Finite, Unit("N")] = key(
        0.0, "force that holds a plucked beam at `place`, across its axis where it rests without; left positive"
    )

    def conflicts(self) -> Iterator[tuple[str, str]]:
        """Yield what a plucked beam lacks, or has twice."""
        if self.state != "plucked":
            return
        plucked = 'of a beam with state = "plucked"'
        if self.place == 0.0:
            yield "place", f"should be greater than 0 {plucked}"
        if (self.deflection == 0.0) == (self.force == 0.0):
            yield "deflection", f"one of deflection and force should not be 0 {plucked}"


class MassSection(InputSection):
    """A point mass on the axis of the beam, which turns with the section that carries it; any number of them."""

    followers = frozenset({"place"})

    place: Annotated[Positive, Unit("m")] = key(1.0, "place along the beam; not given: the beam's length")
    mass: Annotated[NonNegative, Unit("kg")] = key(0.0, "mass, without extent")
    inertia: Annotated[NonNegative, Unit("kg m^2")] = key(
        0.0, "moment of inertia about its own centre, across the plane of motion"
    )

    @property
    def has_inertia(self) -> bool:
        """Whether it changes anything."""
        return self.mass > 0.0 or self.inertia > 0.0


def _ascends_in_time(rows: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    if len(rows) == 1 or any(b[0] <= a[0] for a, b in pairwise(rows)):
        raise ValueError("two or more rows [time, value] with strictly ascending times, or [] for none")
    return rows


# rows of time and of what changes with it
OverTime = Annotated[tuple[Pair, ...], Field(strict=False, max_length=MAX_ROWS), AfterValidator(_ascends_in_time)]


def _extremes(amplitude: float, table: tuple[tuple[float, float], ...]) -> tuple[float, float]:
    """Return the least and the largest value over time, harmonic or of a table."""
    values = [value for _, value in table] or [-abs(amplitude), abs(amplitude)]
    return min(values), max(values)


_ACROSS, _WHOLE_TURN = "across", 2.0 * math.pi


def _across_or_angle(value: Any) -> str | float:
    if value == _ACROSS:
        return _ACROSS
    number = value if isinstance(value, int | float) and not isinstance(value, bool) else math.nan
    if not -_WHOLE_TURN <= number <= _WHOLE_TURN:
        degrees = f'; for degrees write "{value} deg"' if math.isfinite(number) else ""
        raise ValueError(f'"{_ACROSS}", or an angle of -{_WHOLE_TURN:.6g} to {_WHOLE_TURN:.6g} rad{degrees}')
    return float(number)


# across the bent beam, or an angle fixed in space
Direction = Annotated[
    str | float,
    PlainValidator(_across_or_angle),
    PlainSerializer(lambda value: value, return_type=Any),
    WithJsonSchema(
        {"anyOf": [{"type": "number", "minimum": -_WHOLE_TURN, "maximum": _WHOLE_TURN}, {"enum": [_ACROSS]}]}
    ),
    Unit("rad", words=(_ACROSS,)),
]


class ForceSection(InputSection):
    """A force on the axis of the beam: constant, harmonic, a sweep, or a table over time; any number of them."""

    followers = frozenset({"place"})

    place: Annotated[Positive, Unit("m")] = key(1.0, "place along the beam; not given: the beam's length")
    force: Annotated[Finite, Unit("N")] = key(
        0.0,
        "the force, constant, or with `frequency` or `sweep_rate` its amplitude: force sin(2 pi (frequency t + "
        "sweep_rate t^2/2))",
    )
    frequency: Annotated[NonNegative, Unit("Hz")] = key(0.0, "frequency of the force, of a sweep at t = 0")
    sweep_rate: Annotated[Finite, Unit("Hz/s")] = key(0.0, "rate at which the frequency changes")
    direction: Direction = key(
        _ACROSS,
        "direction of the force: across the axis of the bent beam at its place, to the left seen from the root, "
        "with which it turns, or an angle from the horizontal, fixed in space",
    )
    table: Annotated[OverTime, Unit("N", over="s")] = key(
        (),
        "force over time in place of a constant or harmonic one, rows [time in s, force], linear between them and "
        "constant before the first and after the last",
    )

    def conflicts(self) -> Iterator[tuple[str, str]]:
        """Yield keys that a table replaces."""
        for name in ("force", "frequency", "sweep_rate") if self.table else ():
            if getattr(self, name) != 0.0:
                yield name, "a table is given too; give one of the two"

    @property
    def acts(self) -> bool:
        """Whether there is a force at any time."""
        return self.largest > 0.0

    @property
    def largest(self) -> float:
        """The largest magnitude (N) over time."""
        return max(map(abs, _extremes(self.force, self.table)))

    @property
    def is_across(self) -> bool:
        """Whether it turns with the beam."""
        return self.direction == _ACROSS


class BaseSection(InputSection):
    """A base that is shaken: root and obstacles move with it, and all motion is relative to it."""

    acceleration: Annotated[Finite, Unit("m/s^2")] = key(
        0.0,
        "amplitude of the base's acceleration, acceleration sin(2 pi (frequency t + sweep_rate t^2/2)); 0: it "
        "stands still",
    )
    frequency: Annotated[NonNegative, Unit("Hz")] = key(0.0, "frequency of the acceleration, of a sweep at t = 0")
    sweep_rate: Annotated[Finite, Unit("Hz/s")] = key(0.0, "rate at which the frequency changes")
    direction: Angle = key(math.pi / 2, "direction of the acceleration from the horizontal; pi/2 is upwards")
    table: Annotated[OverTime, Unit("m/s^2", over="s")] = key(
        (),
        "acceleration over time in place of the harmonic one, rows [time in s, acceleration], linear "
        "between them and constant before the first and after the last",
    )

    def conflicts(self) -> Iterator[tuple[str, str]]:
        """Yield keys that a table replaces, and an acceleration without a frequency."""
        for name in ("acceleration", "frequency", "sweep_rate") if self.table else ():
            if getattr(self, name) != 0.0:
                yield name, "base.table is given too; give one of the two"
        if self.acceleration != 0.0 and self.frequency == self.sweep_rate == 0.0:
            yield "frequency", "should be greater than 0 with base.acceleration, or base.sweep_rate not 0"

    @property
    def is_shaken(self) -> bool:
        """Whether the base moves."""
        return any(self.extremes)

    @property
    def extremes(self) -> tuple[float, float]:
        """Least and largest acceleration (m/s^2) in the direction."""
        return _extremes(self.acceleration, self.table)


class SlopeSection(InputSection):
    """The rigid slope: a line through `origin` inclined by `angle`; the free side is on its left."""

    enabled: bool = key(
        True, 'whether there is a slope; false: only the obstacles, with `contact.where = "anywhere"`'
    )
    origin: Annotated[Pair, Unit("m")] = key((0.3, 0.0), "a point of the slope, [x, y] from the axis of the root")
    angle: Angle = key(math.pi / 10, "inclination of the slope from the horizontal")
    extent: Extent = key(
        (),
        "where the slope begins and ends, [first, last] along it from `origin`; [] is unbounded. Contact ends "
        "where the contact point slides beyond an end, and beyond it the point falls past the slope",
    )

    @property
    def offsets(self) -> tuple[float, float]:
        """Height c_n of `origin` above the root's axis across the slope, and its place c_t along it (m)."""
        return Side(0, self.origin, self.angle, self.extent, 0.0).offsets


class ObstacleSection(InputSection):
    """An obstacle besides the slope: a straight side, with or without ends, a point, or an outline; any number."""

    followers = frozenset({"stiffness"})

    kind: Literal["side", "point", "polyline"] = key(
        "side",
        "a straight side, solid on its right as the slope is, a point (a corner or a peg), or an outline of "
        "straight sides through `points`",
    )
    origin: Annotated[Pair, Unit("m")] = key(
        (0.0, 0.0),
        "a place on the side, the centre of the point, or where [0, 0] of an outline is, [x, y] from the axis of "
        "the root",
    )
    angle: Angle = key(
        0.0,
        "inclination of the side from the horizontal; pi turns its solid up. An outline is turned by it about "
        "`origin`",
    )
    points: Points = key(
        (),
        "points of the outline, [[x, y], ...], solid on its right; it is the whole solid, clockwise, if the last "
        "point is the first. A text is a file of them beside the scenario file, two columns x,y in m (`lay.csv`)",
    )
    extent: Extent = key(
        (),
        "ends of the side, [first, last] along it from `origin`; [] is unbounded. Each end is a "
        "corner that the beam can touch at any place",
    )
    radius: Annotated[NonNegative, Unit("m")] = key(0.0, "radius of the peg (a point); 0 is a corner")
    stiffness: Annotated[Positive, Unit("N/m")] = key(
        1e6, 'stiffness where it is touched, with `contact.normal = "spring"`; not given: `contact.stiffness`'
    )
    bedding: Annotated[NonNegative, Unit("N/m^2")] = key(
        0.0,
        "stiffness of a bed over the length of the side, in place of `stiffness`. Each place of `contact.grid` "
        "bears on as much of it as lies under its own part of the beam; the ends of the side are no corners then",
    )

    def conflicts(self) -> Iterator[tuple[str, str]]:
        """Yield points that an outline lacks."""
        if self.kind == "polyline" and not self.points:
            yield "points", 'should be at least two points [x, y] with kind = "polyline"'

    @property
    def outline(self) -> Outline | None:
        """The outline of a polyline, where it lies."""
        return outline_of(self.points, self.origin, self.angle) if self.kind == "polyline" else None


class ContactSection(InputSection):
    """The contact between the beam and the slope, at the beam's point `point`, or with all obstacles anywhere."""

    followers = frozenset({"point", "grid"})

    enabled: bool = key(True, "whether slope and obstacles are touched; false: free motion")
    where: Literal["point", "anywhere"] = key(
        "point",
        "where the beam is touched: its place `point` by the slope (`point`), or free end and grid by every "
        "side, and any place of the beam by pegs and corners (`anywhere`)",
    )
    grid: Annotated[int, Field(ge=1, le=MAX_GRID)] = key(
        PARTS,
        'number of equal parts of the beam at whose ends it can touch sides, with `where = "anywhere"`; 1: its '
        "free end alone, or both ends of a beam that nothing holds; not given: the elements of a beam in all its "
        "nodes or in absolute coordinates, "
        f"{PARTS} of one in modes. Pegs and corners touch it at any place whatever the grid",
    )
    point: Annotated[Positive, Unit("m")] = key(
        1.0, "place of the contact point along the beam; not given: the beam's length"
    )
    surface: Literal["axis", "section"] = key(
        "axis",
        "where in the section at `point` the beam touches: at its axis, so that a slope is drawn half the beam's "
        "depth below its place, or at its outer fibre on the side of the slope",
    )
    normal: Literal["rigid", "spring"] = key("rigid", "a rigid stop or an elastic one")
    stiffness: Annotated[Positive, Unit("N/m")] = key(1e6, "stiffness of an elastic stop")
    damping: Annotated[NonNegative, Unit("s/m")] = key(
        0.0, "Hunt-Crossley damping of an elastic stop: its force is stiffness d (1 + damping d') at the depth d"
    )
    linear_damping: Annotated[NonNegative, Unit("N s/m")] = key(
        0.0, "linear damping of a closed elastic stop, a dashpot beside its spring; it never pulls"
    )
    impact: Literal["newton", "routh"] = key(
        "newton",
        "impact on a rigid stop: without friction (Newton), or with the friction law (Routh), as in time-stepping",
    )
    restitution: Annotated[float, Field(ge=0.0, le=1.0)] = key(
        0.0,
        "coefficient of restitution of an impact on a rigid stop, Newton's, in Moreau's form of several contacts, "
        "or (Routh) Poisson's",
    )
    point_inertia: Literal["kept", "none"] = key(
        "kept",
        "whether the contact point has the inertia of the discretization, with impacts on a rigid stop, or "
        "`none`: it rests on the stop through the residual flexibility of the discretization, without impacts",
    )
    residual_flexibility: bool = key(
        True,
        "whether the static flexibility of the truncated modes is in series with elastic stops, between all "
        "places of contact",
    )
    shortening: bool = key(
        True, "whether gap and slip include the foreshortening of the beam up to the contact point"
    )
    friction: Literal["frictionless", "hybrid", "modified-coulomb"] = key("hybrid", "the tangential law")
    axial_flexibility: bool = key(
        False,
        "whether the static axial flexibility x/(E A) of the beam between its root and the place of contact "
        "stands, without mass, behind the friction there: a contact that sticks is then elastic along the beam",
    )
    mu_static: NonNegative = key(0.3, "static coefficient of friction")
    mu_kinetic: NonNegative = key(0.3, "kinetic coefficient of friction")
    regularization: Annotated[tuple[NonNegative, NonNegative], Field(strict=False), Unit("m/s")] = key(
        (1e-3, 1e-2),
        "slip velocities v0 < v1 of the modified Coulomb law, between which it grows from 0 to its full force",
    )

    @field_validator("regularization")
    @classmethod
    def _ascends(cls, speeds: tuple[float, float]) -> tuple[float, float]:
        if not speeds[0] < speeds[1]:
            raise ValueError("[v0, v1] in m/s with v0 less than v1")
        return speeds

    def conflicts(self) -> Iterator[tuple[str, str]]:
        """Yield keys of laws that do not fit together."""
        if self.friction == "hybrid" and self.mu_static < self.mu_kinetic:
            yield "mu_static", f"should be at least contact.mu_kinetic = {self.mu_kinetic}"
        if self.point_inertia == "none" and (self.restitution > 0.0 or self.impact != "newton"):
            without = '"none" has no impacts'
            yield "point_inertia", f'should be "kept" with contact.restitution or contact.impact: {without}'


class DiscretizationSection(InputSection):
    """The discretization of the beam."""

    method: Literal["modal", "fem", "absolute"] = key(
        "modal",
        "assumed modes (`modal`), Hermite finite elements (`fem`), or a geometrically exact beam in absolute "
        "coordinates (`absolute`, which has neither `kinetics` nor `modes`)",
    )
    frame: Literal["tangent", "mean-axis"] = key(
        "tangent",
        "the floating frame: tangent to the root (clamped shapes), or the mean axis (shapes that rotate at "
        "the root), which is the default of the full nodal model",
    )
    kinetics: Literal["zeroth-order", "first-order", "full"] = key(
        "first-order", "order of the kinetic energy in the elastic coordinates"
    )
    modes: Annotated[int, Field(ge=0, le=MAX_MODES)] = key(
        2, "number of modes; finite elements are reduced to so many of their own modes, 0: the full nodal model"
    )
    elements: Annotated[int, Field(ge=1, le=MAX_ELEMENTS)] = key(32, "number of finite elements")
    mesh: str = key(
        "",
        "a file with line elements on an axis, in any format that meshio reads (`beam.msh`), whose nodes "
        "take the place of those that follow from `elements` and `grading`",
    )
    nodes: Annotated[tuple[NonNegative, ...], Field(strict=False, max_length=MAX_ELEMENTS + 1), Unit("m")] = key(
        (), "places of the nodes, ascending from 0 to the length of the beam; none: from `elements` and `grading`"
    )
    grading: Annotated[float, Field(ge=1.0, le=MAX_GRADING)] = key(
        1.0, "largest over smallest element, of a mesh that is graded towards the contact point"
    )

    @model_validator(mode="before")
    @classmethod
    def _count_elements(cls, data: Any) -> Any:
        nodes = data.get("nodes") if isinstance(data, dict) else None
        return {"elements": len(nodes) - 1} | data if isinstance(nodes, list | tuple) and len(nodes) > 1 else data

    @field_validator("nodes")
    @classmethod
    def _ascend(cls, nodes: tuple[float, ...]) -> tuple[float, ...]:
        if any(b <= a for a, b in pairwise(nodes)):
            raise ValueError("ascending")
        return nodes

    def conflicts(self) -> Iterator[tuple[str, str]]:
        """Yield keys that the method, the mesh or the nodal model does not take."""
        if self.mesh:
            yield "mesh", "is read with a scenario file or by --set; give discretization.nodes"
        if self.method == "modal" and self.modes < 1:
            yield "modes", f"should be 1 to {MAX_MODES} for the modal method"
        if self.method == "fem" and self.modes > 2 * self.elements:
            yield "modes", f"should be at most the {2 * self.elements} modes of the mesh"
        if self.nodes and self.elements != len(self.nodes) - 1:
            yield "elements", f"the mesh has {len(self.nodes) - 1} elements; leave this key out"
        if self.nodes and self.grading != 1.0:
            yield "grading", "the mesh is graded as it is; leave this key out"
        instead = "or keep modes: discretization.modes >= 1"
        if self.is_nodal and self.kinetics != "first-order":
            yield "kinetics", f'the full nodal model is "first-order"; {instead}'

    @property
    def is_nodal(self) -> bool:
        """Whether this is the full nodal model: finite elements, nothing reduced."""
        return self.method == "fem" and self.modes == 0

    @property
    def in_modes(self) -> bool:
        """Whether the beam is one of `modes` modes, not of all its nodes."""
        return not self.is_nodal and self.method != "absolute"

    @property
    def contact_parts(self) -> int:
        """Parts of the beam at whose ends it can touch sides, unless `contact.grid` says how many."""
        return PARTS if self.in_modes else min(self.elements, MAX_GRID)


class SolverSection(InputSection):
    """The marching scheme, its steps and tolerances."""

    scheme: Literal["event", "fixed-step", "generalized-alpha", "time-stepping"] = key(
        "event",
        "adaptive with located events, the paper's fixed steps, implicit generalized-alpha on elastic stops, or "
        "time-stepping, for rigid contacts, one or many (of the full nodal model these two are the default), and "
        "in absolute coordinates, whose energy it keeps, on elastic stops with located events",
    )
    tolerance: Annotated[float, Field(ge=1e-13, le=1e-2)] = key(
        1e-10,
        "relative tolerance of a step (event; in absolute coordinates of one near obstacles), of the iterations "
        "(generalized-alpha, time-stepping)",
    )
    free_step: Annotated[Positive, Unit("s")] = key(
        1e-4, "step in flight (all but event); time-stepping takes longer ones where they err less"
    )
    contact_step: Annotated[Positive, Unit("s")] = key(
        1e-6, "step in contact (all but event); in absolute coordinates the shortest one"
    )
    rho_infinity: Annotated[float, Field(ge=0.0, le=1.0)] = key(
        0.8, "spectral radius of generalized-alpha at infinite frequency"
    )
    baumgarte: Annotated[tuple[NonNegative, NonNegative], Field(strict=False), Unit("1/s")] = key(
        (10.0, 1000.0), "Baumgarte's parameters [chi, beta] of the contact constraints"
    )
    baumgarte_form: Literal["squared", "plain"] = key(
        "squared",
        "how Baumgarte's parameters are read, `squared`: Z'' + 2 chi Z' + beta^2 Z = 0; "
        "`plain`: Z'' + chi Z' + beta Z = 0",
    )
    stick: Literal["projection", "force"] = key(
        "projection",
        "fixed-step: contact sticks where the force that holds it lies in the friction cone and can stop "
        "the slip within a step (`projection`), or where it lies in the cone whatever the slip velocity is "
        "(`force`, as the paper)",
    )
    output_interval: Annotated[Positive, Unit("s")] = key(
        1e-4, "interval of the samples; events are always kept exactly"
    )

    @field_validator("scheme", mode="before")
    @classmethod
    def _earlier_scheme(cls, scheme: Any) -> Any:
        """Read the name that the scheme of absolute coordinates has in files of version 0.2."""
        if scheme != "energy-consistent":
            return scheme
        _notice('solver.scheme = "energy-consistent" is now called "time-stepping"')
        return "time-stepping"

    @field_validator("stick", mode="before")
    @classmethod
    def _earlier_name(cls, stick: Any) -> Any:
        """Read the name that files of version 0.2 have."""
        return "projection" if stick == "arrest" else stick


@cache
def _notice(line: str) -> None:
    # without a handler, logging writes it to standard error
    logging.getLogger(__name__).warning("oblique-impact: %s", line)

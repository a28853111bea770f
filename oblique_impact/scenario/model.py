"""The keys of a scenario with their defaults, those that follow others, and quantities derived from them."""

from __future__ import annotations

import cmath
import math
from typing import Annotated, Any, NamedTuple

from pydantic import AfterValidator, Field, ValidationInfo, field_validator

from oblique_impact.scenario.materials import MATERIAL_PROPERTIES, MATERIALS
from oblique_impact.scenario.messages import plain_text
from oblique_impact.scenario.obstacles import ObstaclePoint, Side
from oblique_impact.scenario.polylines import Outline
from oblique_impact.scenario.section import InputSection, key
from oblique_impact.scenario.sections import (
    BaseSection,
    BeamSection,
    ContactSection,
    DiscretizationSection,
    ForceSection,
    InitialSection,
    MassSection,
    ObstacleSection,
    Positive,
    RootSection,
    SlopeSection,
    SolverSection,
)
from oblique_impact.scenario.shapes import SHAPE_PROPERTIES, shape_property
from oblique_impact.scenario.units import Unit

MAX_OBSTACLES = 100
MAX_MASSES = 100
MAX_FORCES = 100
#: distance (over the beam's length) at which a node of a given mesh is at a point
ON_NODE = 1e-9


class PointMass(NamedTuple):
    """A point mass on the axis of the beam."""

    place: float  # m along the beam
    mass: float  # kg
    inertia: float = 0.0  # kg m^2, about its own centre


class ScenarioModel(InputSection):
    """Sections and keys of a scenario, see :class:`oblique_impact.scenario.scenario.Scenario`."""

    first_item = 1  # obstacles count from 1, as in events, and so do masses and forces

    title: Annotated[str, Field(max_length=200), AfterValidator(plain_text)] = key(
        "", "title of the run in pictures, films and pages"
    )
    end_time: Annotated[Positive, Unit("s")] = key(1.0, "duration of the run")
    gravity: Annotated[float, Field(ge=0.0, le=1e6), Unit("m/s^2")] = key(
        9.8, "acceleration of gravity, downwards"
    )
    beam: BeamSection = BeamSection()
    root: RootSection = RootSection()
    initial: InitialSection = InitialSection()
    masses: Annotated[tuple[MassSection, ...], Field(strict=False, max_length=MAX_MASSES)] = key(
        (), "point masses on the beam, each a table [[masses]] further below; [] is none"
    )
    forces: Annotated[tuple[ForceSection, ...], Field(strict=False, max_length=MAX_FORCES)] = key(
        (), "forces on the beam, each a table [[forces]] further below; [] is none"
    )
    base: BaseSection = BaseSection()
    slope: SlopeSection = SlopeSection()
    discretization: DiscretizationSection = DiscretizationSection()
    contact: ContactSection = ContactSection()
    obstacles: Annotated[tuple[ObstacleSection, ...], Field(strict=False, max_length=MAX_OBSTACLES)] = key(
        (), "obstacles besides the slope, each a table [[obstacles]] further below; [] is none"
    )
    solver: SolverSection = SolverSection()

    # --- keys derived from others unless they are given

    @field_validator("beam")
    @classmethod
    def _shape_and_material(cls, beam: BeamSection) -> BeamSection:
        found: dict[str, Any] = {}
        if beam.section.shape:
            found |= {name: shape_property(beam.section, name) for name in SHAPE_PROPERTIES}
        if beam.material:
            found |= {name: getattr(MATERIALS[beam.material], name) for name in MATERIAL_PROPERTIES}
        return beam.with_defaults(**found)

    @field_validator("contact")
    @classmethod
    def _contact_of_beam(cls, contact: ContactSection, info: ValidationInfo) -> ContactSection:
        known = {"beam", "discretization"} <= info.data.keys()
        return contact.with_defaults(**_contact_defaults(contact.where, **info.data)) if known else contact

    @field_validator("obstacles")
    @classmethod
    def _stiffness_of_contact(
        cls, items: tuple[ObstacleSection, ...], info: ValidationInfo
    ) -> tuple[ObstacleSection, ...]:
        contact = info.data.get("contact", ContactSection())
        return tuple(item.with_defaults(stiffness=contact.stiffness) for item in items)

    @field_validator("masses", "forces")
    @classmethod
    def _at_the_tip(cls, items: tuple[InputSection, ...], info: ValidationInfo) -> tuple[InputSection, ...]:
        beam = info.data.get("beam", BeamSection())
        return tuple(item.with_defaults(place=beam.length) for item in items)

    @field_validator("obstacles", "masses", "forces", mode="before")
    @classmethod
    def _list_of_sections(cls, items: Any, info: ValidationInfo) -> Any:
        if not isinstance(items, list | tuple):
            raise ValueError(f"a list of {info.field_name}; in a file each is a table [[{info.field_name}]]")
        return items

    @field_validator("discretization")
    @classmethod
    def _frame_of_method(
        cls, discretization: DiscretizationSection, info: ValidationInfo
    ) -> DiscretizationSection:
        root = info.data.get("root", RootSection())
        turns = root.is_free or (discretization.is_nodal and not root.is_moved)
        return discretization.with_defaults(frame="mean-axis" if turns else "tangent")

    @field_validator("solver")
    @classmethod
    def _scheme_of_discretization(cls, solver: SolverSection, info: ValidationInfo) -> SolverSection:
        discretization = info.data.get("discretization", DiscretizationSection())
        if discretization.method == "absolute":
            return solver.with_defaults(scheme="time-stepping")
        if not discretization.is_nodal:
            return solver.with_defaults(scheme="event")
        contact = info.data.get("contact", ContactSection())
        rests = contact.point_inertia == "none" and contact.where == "point"  # its stop is elastic then
        strikes = contact.enabled and contact.normal == "rigid" and not rests
        return solver.with_defaults(scheme="time-stepping" if strikes else "generalized-alpha")

    def default_of(self, name: str) -> Any:
        """Return the value that "section.key" has in this scenario where it is not given."""
        section, _, inner = name.rpartition(".")
        if section == "contact" and inner in ("point", "grid"):
            return _contact_defaults(self.contact.where, self.beam, self.discretization)[inner]
        if section.startswith("obstacles.") and inner == "stiffness":
            return self.contact.stiffness
        if section.startswith(("masses.", "forces.")) and inner == "place":
            return self.beam.length
        if name == "discretization.elements" and self.discretization.nodes:
            return len(self.discretization.nodes) - 1
        return type(self.value_of(section) if section else self).model_fields[inner].default

    # --- derived quantities

    @property
    def is_nodal(self) -> bool:
        """Whether the full nodal model is marched: finite elements, nothing reduced."""
        return self.discretization.is_nodal

    @property
    def is_absolute(self) -> bool:
        """Whether the beam is the geometrically exact one in absolute coordinates."""
        return self.discretization.method == "absolute"

    @property
    def point_masses(self) -> tuple[PointMass, ...]:
        """Point masses by place, ascending; `beam.tip_mass` is one at the tip."""
        found = [PointMass(item.place, item.mass, item.inertia) for item in self.masses if item.has_inertia]
        tip = [PointMass(self.beam.length, self.beam.tip_mass)] if self.beam.tip_mass > 0.0 else []
        return tuple(sorted([*found, *tip]))

    @property
    def acting_forces(self) -> tuple[ForceSection, ...]:
        """The forces that are not 0 at all times."""
        return tuple(item for item in self.forces if item.acts)

    @property
    def inner_forces(self) -> list[float]:
        """Places (m) of forces inside the span, ascending."""
        return sorted({item.place for item in self.acting_forces if item.place < self.beam.length})

    @property
    def largest_gravity(self) -> float:
        """The largest acceleration of gravity (m/s^2) that is felt on a shaken base."""
        c, s = math.cos(self.base.direction), math.sin(self.base.direction)
        return max(math.hypot(a * c, self.gravity + a * s) for a in self.base.extremes)

    @property
    def contact_fibre(self) -> float:
        """Transverse coordinate (m) of the contact point in its section: 0 on the axis, negative below it."""
        if self.contact.surface == "axis":
            return 0.0
        return self.slope_side.facing(self.initial.angle) * self.half_depth

    @property
    def half_depth(self) -> float:
        """Distance (m) from the beam's axis to where it touches, at the contact point, see `half_depth_at`."""
        return self.half_depth_at(self.contact.point)

    def half_depth_at(self, x: float) -> float:
        """Distance (m) from the axis to where the beam touches at x (m): to the outer fibre, or 0."""
        return self.beam.fibre_distance(x) if self.contact.surface == "section" else 0.0

    @property
    def root_axis(self) -> complex:
        """Place x + i y (m) of the axis of the root at t = 0: that of the first section of a free beam."""
        if not self.root.is_free:
            return 0j
        return complex(*self.initial.position) - 0.5 * self.beam.length * cmath.exp(1j * self.initial.angle)

    @property
    def reach(self) -> float:
        """Largest distance (m) from the origin that the beam can reach; of a free one, if nothing stops it."""
        reach, t = self.beam.length + self.root.hub_radius, self.end_time
        if not self.root.is_free:
            return reach
        flown = math.hypot(*self.initial.velocity) * t + 0.5 * self.largest_gravity * t * t
        return reach + math.hypot(*self.initial.position) + flown

    @property
    def initial_gap(self) -> float:
        """Gap of the undeformed beam at t = 0 (m)."""
        return self._initial_gap_and_slip[0]

    @property
    def initial_slip(self) -> float:
        """Place of the contact point along the slope at t = 0 (m from its origin)."""
        return self._initial_gap_and_slip[1]

    @property
    def _initial_gap_and_slip(self) -> tuple[float, float]:
        reach = self.root.hub_radius + self.contact.point
        return self.slope_side.gap_and_place(reach, self.initial.angle, self.half_depth, self.root_axis)

    @property
    def slope_side(self) -> Side:
        """The slope as a side, whether it is enabled or not."""
        slope = self.slope
        return Side(0, slope.origin, slope.angle, slope.extent, self.contact.stiffness)

    @property
    def sides(self) -> list[Side]:
        """Straight sides that the beam can touch: the slope (0) if it is enabled, then those of the obstacles.

        Whether contact is enabled is not asked.  With ``contact.where = "point"`` it is the slope alone.
        """
        others = list[Side]()
        for number, item in enumerate(self.obstacles, start=1):
            if item.kind == "side":
                others.append(Side(number, item.origin, item.angle, item.extent, item.stiffness, item.bedding))
            elif item.outline is not None:
                others += item.outline.sides(number, item.stiffness, item.bedding)
        return [self.slope_side, *others] if self.slope.enabled else others

    @property
    def outlines(self) -> dict[int, Outline]:
        """Outlines by the numbers of their obstacles."""
        each = {number: item.outline for number, item in enumerate(self.obstacles, start=1)}
        return {number: outline for number, outline in each.items() if outline is not None}

    @property
    def preloaded_sides(self) -> dict[int, float]:
        """Sides, by obstacle, that the undeformed beam is inside of, and on which side of their ends it rests.

        That is 1 where the beam is on the left of them, seen along it, and -1 on the right.  Only a beam that
        begins at rest may be bent away from them, and from no outline.
        """
        if self.initial.state == "undeformed" or not self.touches_anywhere:
            return {}
        angle, found = self.initial.angle, dict[int, float]()
        for side in self.sides:
            if side.obstacle in self.outlines:
                continue
            for x in self.beam_points:
                gap, along = side.gap_and_place(self.root.hub_radius + x, angle, self.half_depth, self.root_axis)
                if gap < 0.0 and side.lengthened(self.cell_on(side, x)).is_beside(along):
                    found[side.obstacle] = math.copysign(1.0, math.cos(angle - side.angle))
        return found

    @property
    def obstacle_points(self) -> list[ObstaclePoint]:
        """Pegs, and corners at the ends of sides, by obstacle; none with ``contact.where = "point"``.

        A side with a bedding has no corners: a bed gives way to a point.
        """
        if self.contact.where == "point":
            return []
        ends = [
            ObstaclePoint(side.obstacle, x, y, 0.0, side.stiffness, corner=True)
            for side in self.sides
            if not side.bedding
            for is_corner, (x, y) in zip(side.corners, side.ends, strict=False)
            if is_corner
        ]
        pegs = [
            ObstaclePoint(number, *item.origin, item.radius, item.stiffness, corner=False)
            for number, item in enumerate(self.obstacles, start=1)
            if item.kind == "point"
        ]
        return sorted([*ends, *pegs], key=lambda point: point.obstacle)

    @property
    def beam_points(self) -> tuple[float, ...]:
        """Places (m along the beam) that can touch sides, ascending: the contact point, or the contact grid.

        Of a beam that nothing holds the first section is one too.
        """
        if self.contact.where == "point":
            return (self.contact.point,)
        parts, first = self.contact.grid, 0 if self.root.is_free else 1
        return tuple(self.beam.length * (number / parts) for number in range(first, parts + 1))

    def cell_on(self, side: Side, place: float) -> tuple[float, float]:
        """Return how far (m) the cell of a place on the beam reaches along a side, before the place and after it.

        The cells of the contact grid, which end half way to the next place, bear on a bedding; (0, 0) without one.
        """
        if not side.bedding:
            return 0.0, 0.0
        half = 0.5 * self.beam.length / self.contact.grid
        inner, outer = half if place > 0.0 else 0.0, half if place < self.beam.length else 0.0
        return (inner, outer) if math.cos(self.initial.angle - side.angle) > 0.0 else (outer, inner)

    @property
    def touches_anywhere(self) -> bool:
        """Whether the whole beam can touch, not its contact point alone; never without contact."""
        return self.contact.where == "anywhere" and self.contact.enabled

    @property
    def taken_defaults(self) -> list[str]:
        """Lines about keys that were not given although results depend on them: `contact.grid`."""
        grid, is_given = self.contact.grid, "grid" in self.contact.model_fields_set
        if is_given or not (self.touches_anywhere and self.sides):
            return []
        words = f"sides touch the beam at the ends of {grid} equal parts; 1: at its free end alone"
        return [f"contact.grid = {grid} is not given: {words}"]

    @property
    def takes_contact_stiffness(self) -> bool:
        """Whether the slope or an obstacle without a stiffness or a bedding of its own can be touched."""
        if self.contact.where == "point" or self.slope.enabled:
            return True
        return any(not item.bedding and "stiffness" not in item.model_fields_set for item in self.obstacles)

    @property
    def rubs(self) -> bool:
        """Whether its contacts have friction."""
        c = self.contact
        return c.friction != "frictionless" and max(c.mu_static, c.mu_kinetic) > 0.0

    @property
    def holds_constraints(self) -> bool:
        """Whether a contact is held without any flexibility, across its stop or, where it sticks, along it."""
        c = self.contact
        sticks = c.friction == "hybrid" and not c.axial_flexibility
        return sticks or (c.normal == "rigid" and c.point_inertia == "kept")

    @property
    def fixed_places(self) -> set[float]:
        """Places (m along the beam) behind its root where a mesh has a node in any case."""
        return {self.contact.point, self.beam.length, *self.contact_nodes} - {0.0}

    @property
    def contact_nodes(self) -> tuple[float, ...]:
        """Places (m along the beam) where the exact beam needs nodes besides contact.point: those on sides."""
        if not self.is_absolute or not self.sides:
            return ()
        near = ON_NODE * self.beam.length
        return tuple(x for x in self.beam_points if abs(x - self.contact.point) > near)


def _contact_defaults(
    where: str, beam: BeamSection, discretization: DiscretizationSection, **_: object
) -> dict[str, float | int]:
    """Return the values of the keys of contact that follow others: those at the tip, and all along the beam."""
    return {"point": beam.length, "grid": discretization.contact_parts if where == "anywhere" else 1}

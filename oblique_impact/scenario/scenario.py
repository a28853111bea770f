"""The scenario of a simulation: a frozen, validated model in SI units; TOML files; the built-in cases."""

from __future__ import annotations

import math
import os.path
import re
from collections.abc import Collection, Iterator
from contextvars import ContextVar
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Self

import tomlkit
from pydantic import AfterValidator, ConfigDict, Field, ValidationInfo, field_validator, model_validator

from oblique_impact.errors import InputError
from oblique_impact.files import read_text
from oblique_impact.scenario import consistency, effects
from oblique_impact.scenario.comments import commented, listing
from oblique_impact.scenario.materials import MATERIAL_PROPERTIES, MATERIALS
from oblique_impact.scenario.mesh_file import take_mesh
from oblique_impact.scenario.messages import did_you_mean, plain_text, refused, short
from oblique_impact.scenario.obstacles import ObstaclePoint, Side
from oblique_impact.scenario.section import InputSection, key
from oblique_impact.scenario.sections import (
    BaseSection,
    BeamSection,
    ContactSection,
    DiscretizationSection,
    InitialSection,
    ObstacleSection,
    Positive,
    RootSection,
    SlopeSection,
    SolverSection,
)
from oblique_impact.scenario.shapes import SHAPE_PROPERTIES, shape_property
from oblique_impact.scenario.toml import apply_change, drop_key, flat_keys, parse_toml, set_key
from oblique_impact.scenario.units import Unit

#: bytes; a scenario file has a hundred lines, and tables of a thousand
MAX_FILE = 1_000_000
#: table of a resolved file: values that were not given and follow other keys
DERIVED = "derived"
MAX_OBSTACLES = 100
#: whether a resolved file is read, which holds keys without effect too (an argument would not reach validators)
_HOLDS_EVERY_KEY = ContextVar("_HOLDS_EVERY_KEY", default=False)
#: keys whose values may be derived from others; obstacles have their stiffness besides
FOLLOWERS = (
    "contact.point",
    "contact.grid",
    "discretization.frame",
    "solver.scheme",
    *(f"beam.{name}" for name in (*SHAPE_PROPERTIES, *MATERIAL_PROPERTIES)),
)


def _with_derived(schema: dict[str, Any]) -> None:
    """Add the table of derived values of resolved files to the schema, which has the meanings of keys itself."""
    schema["description"] = str(Scenario.__doc__).partition("\n\n")[0]
    names = {name: {"description": "of a resolved file: follows other keys"} for name in FOLLOWERS}
    schema["properties"][DERIVED] = {
        "type": "object",
        "properties": names,
        "patternProperties": {r"^obstacles\.[1-9][0-9]*\.stiffness$": names["contact.point"]},
        "additionalProperties": False,
    }


class Scenario(InputSection):
    """One simulation, in SI units.

    Sections and keys are those of the scenario file, with these defaults, which are the paper's case:

        {keys}

    Examples
    --------
    >>> Scenario.builtin("paper").beam.length
    1.0
    """

    model_config = ConfigDict(validate_default=True, title="oblique-impact", json_schema_extra=_with_derived)
    first_item = 1  # obstacles count from 1, as in events

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

    @field_validator("obstacles", mode="before")
    @classmethod
    def _list_of_obstacles(cls, items: Any) -> Any:
        if not isinstance(items, list | tuple):
            raise ValueError("a list of obstacles; in a file each is a table [[obstacles]]")
        return items

    @field_validator("discretization")
    @classmethod
    def _frame_of_method(cls, discretization: DiscretizationSection) -> DiscretizationSection:
        return discretization.with_defaults(frame="mean-axis" if discretization.is_nodal else "tangent")

    @field_validator("solver")
    @classmethod
    def _scheme_of_discretization(cls, solver: SolverSection, info: ValidationInfo) -> SolverSection:
        discretization = info.data.get("discretization", DiscretizationSection())
        if discretization.method == "absolute":
            return solver.with_defaults(scheme="energy-consistent")
        return solver.with_defaults(scheme="generalized-alpha" if discretization.is_nodal else "event")

    # --- unknown and inconsistent keys

    @model_validator(mode="before")
    @classmethod
    def _keys_of_other_sections(cls, data: Any) -> Any:
        """Raise InputError for a key of another section, and name that section."""
        if not isinstance(data, dict):
            return data
        sections = _sections()
        homes = {inner: name for name, section in sections.items() for inner in section.model_fields}
        given = [("", data), *((name, data.get(name)) for name in sections)]
        for name, inside in given:
            if not isinstance(inside, dict):
                continue
            known = sections[name].model_fields if name else cls.model_fields
            for inner in inside:
                if inner not in known and inner in homes and not did_you_mean(inner, known):
                    meant = f"unknown key; did you mean {homes[inner]}.{inner}?"
                    raise refused(f"{name}.{inner}" if name else inner, inside[inner], meant)
        return data

    def conflicts(self) -> Iterator[tuple[str, str]]:
        """Yield keys of different sections that do not fit together, see `oblique_impact.scenario.consistency`."""
        return consistency.conflicts(self)

    @model_validator(mode="after")
    def _keys_act(self) -> Self:
        for name, words in effects.without_effect(self) if not _HOLDS_EVERY_KEY.get() else ():
            raise refused(name, self.value_of(name), words)
        return self

    def default_of(self, name: str) -> Any:
        """Return the value that "section.key" has in this scenario where it is not given."""
        section, _, inner = name.rpartition(".")
        if section == "contact" and inner in ("point", "grid"):
            return _contact_defaults(self.contact.where, self.beam, self.discretization)[inner]
        if section.startswith("obstacles.") and inner == "stiffness":
            return self.contact.stiffness
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
        return self.slope_side.gap_and_place(reach, self.initial.angle, self.half_depth)

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
        others = [
            Side(number, item.origin, item.angle, item.extent, item.stiffness, item.bedding)
            for number, item in enumerate(self.obstacles, start=1)
            if item.kind == "side"
        ]
        return [self.slope_side, *others] if self.slope.enabled else others

    @property
    def obstacle_points(self) -> list[ObstaclePoint]:
        """Pegs and both ends of sides with an extent, by obstacle; none with ``contact.where = "point"``.

        A side with a bedding has no corners: a bed gives way to a point.
        """
        if self.contact.where == "point":
            return []
        ends = [
            ObstaclePoint(side.obstacle, x, y, 0.0, side.stiffness, corner=True)
            for side in self.sides
            if not side.bedding
            for x, y in side.ends
        ]
        pegs = [
            ObstaclePoint(number, *item.origin, item.radius, item.stiffness, corner=False)
            for number, item in enumerate(self.obstacles, start=1)
            if item.kind == "point"
        ]
        return sorted([*ends, *pegs], key=lambda point: point.obstacle)

    @property
    def beam_points(self) -> tuple[float, ...]:
        """Places (m along the beam) that can touch sides, ascending: the contact point, or the contact grid."""
        if self.contact.where == "point":
            return (self.contact.point,)
        parts = self.contact.grid
        return tuple(self.beam.length * (number / parts) for number in range(1, parts + 1))

    def cell_on(self, side: Side, place: float) -> tuple[float, float]:
        """Return how far (m) the cell of a place on the beam reaches along a side, before the place and after it.

        The cells of the contact grid, which end half way to the next place, bear on a bedding; (0, 0) without one.
        """
        if not side.bedding:
            return 0.0, 0.0
        half = 0.5 * self.beam.length / self.contact.grid
        inner, outer = half, half if place < self.beam.length else 0.0
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
    def holds_constraints(self) -> bool:
        """Whether a contact is held without any flexibility, across its stop or, where it sticks, along it."""
        c = self.contact
        sticks = c.friction == "hybrid" and not c.axial_flexibility
        return sticks or (c.normal == "rigid" and c.point_inertia == "kept")

    @property
    def fixed_places(self) -> set[float]:
        """Places (m along the beam) behind its root where a mesh has a node in any case."""
        return {self.contact.point, self.beam.length, *self.contact_nodes}

    @property
    def contact_nodes(self) -> tuple[float, ...]:
        """Places (m along the beam) where the exact beam needs nodes besides contact.point: those on sides."""
        if not self.is_absolute or not self.sides:
            return ()
        near = consistency.ON_NODE * self.beam.length
        return tuple(x for x in self.beam_points if abs(x - self.contact.point) > near)

    # --- files

    @classmethod
    def from_toml(
        cls,
        text: str,
        overrides: list[str] | None = None,
        name: str = "scenario file",
        folder: Path | None = None,
        is_own: bool = True,
    ) -> Scenario:
        """Read a scenario file's text; `overrides` are strings "section.key=value", `name` begins its errors.

        A file that the text names is read if the `folder` is given that its path begins in; those that `overrides`
        name begin in the present one.  Keys without effect are refused, but those of a resolved file, which holds
        every key, and of a text that is not the user's own are left out: there `overrides` alone are meant.
        """
        data = parse_toml(text, name)
        resolved = DERIVED in data
        _drop_derived(data)
        changed = [apply_change(data, item) for item in overrides or []]
        try:
            if folder is not None:
                take_mesh(data, Path() if "discretization.mesh" in changed else folder)
            if resolved or not is_own:
                _drop_without_effect(data, changed)
            return cls.from_dict(data)
        except InputError as error:
            of_file = name and not any(str(error).startswith(key) for key in changed)
            raise InputError(f"{name}: {error}" if of_file else str(error)) from None

    @classmethod
    def builtin(cls, name: str, overrides: list[str] | None = None) -> Scenario:
        """Return the built-in case `name` (see `builtin_names`)."""
        if name not in builtin_names():
            known = f"{', '.join(builtin_names())}{did_you_mean(name, builtin_names())}"
            raise refused("scenario", name, f"built-in scenarios are {known}")
        return cls.from_toml(builtin_text(name), overrides, name="", folder=Path(), is_own=False)

    @classmethod
    def load(cls, source: str, overrides: list[str] | None = None) -> Scenario:
        """Return a built-in case by name, or read the scenario file at path `source`."""
        if source in builtin_names():
            return cls.builtin(source, overrides)
        path = Path(source)
        if not os.path.isfile(path):
            known, inside = builtin_names(), path / "scenario.toml"
            meant = f"; did you mean {inside}?" if os.path.isfile(inside) else did_you_mean(source, known)
            words = f"neither a file nor a built-in scenario ({', '.join(known)}){meant}"
            raise InputError(f"scenario = {source!r:.500}: {words}")
        try:
            text = read_text(path, MAX_FILE)
        except (OSError, ValueError) as error:
            raise InputError(f"scenario = {source!r}: cannot be read: {error}") from None
        return cls.from_toml(text, overrides, source, path.parent)

    def replace(self, **values: Any) -> Scenario:
        """Return a copy with changed keys, "section__key=value" or "key=value"; validated again.

        Keys that were not given and follow others (the contact point is at the tip) go on following them.
        """
        data = self.model_dump(mode="json", exclude_unset=True)
        for name, value in values.items():
            set_key(data, name.split("__"), value, name)
        return Scenario.from_dict(data)

    def adapted(self, required: Collection[str] | None = None, /, **values: Any) -> Scenario:
        """Return a copy with changed keys as of `replace`, from which keys that have no effect then are left out.

        Those that are `required` ("section.key") have to act; by default all that are changed.
        """
        data = self.model_dump(mode="json", exclude_unset=True)
        for name, value in values.items():
            set_key(data, name.split("__"), value, name)
        changed = [name.replace("__", ".") for name in values]
        _drop_without_effect(data, changed if required is None else required)
        return Scenario.from_dict(data)

    def to_toml(self) -> str:
        """Return the fully resolved scenario file, a comment above each key with its meaning, unit and range.

        Its table `derived` lists the values that follow other keys.
        """
        data = self.model_dump(mode="json")
        flat = flat_keys(data)
        # sizes of other shapes are left out
        data["beam"]["section"] = {key: value for key, value in data["beam"]["section"].items() if value}
        derived = tomlkit.dumps({DERIVED: {path: flat[path] for path in self._derived_keys()}})
        return f"{commented(Scenario, data)}\n# not given: these values follow other keys\n{derived}"

    def _derived_keys(self) -> list[str]:
        """Return the keys of this scenario whose values are derived from others."""
        keys = ["discretization.frame", "contact.point", "contact.grid", "solver.scheme"]
        keys += [f"obstacles.{number}.stiffness" for number in range(1, len(self.obstacles) + 1)]
        if self.beam.section.shape:
            keys += [f"beam.{name}" for name in SHAPE_PROPERTIES]
        if self.beam.material:
            keys += [f"beam.{name}" for name in MATERIAL_PROPERTIES]
        given = set(self.given())
        return [key for key in keys if key not in given]


if Scenario.__doc__:  # python -OO leaves none
    Scenario.__doc__ = Scenario.__doc__.replace("{keys}", "\n        ".join(listing(Scenario)))


def _sections() -> dict[str, type[InputSection]]:
    """Return the sections of a scenario by their names."""
    found = {name: field.annotation for name, field in Scenario.model_fields.items()}
    return {name: a for name, a in found.items() if isinstance(a, type) and issubclass(a, InputSection)}


def _contact_defaults(
    where: str, beam: BeamSection, discretization: DiscretizationSection, **_: object
) -> dict[str, float | int]:
    """Return the values of the keys of contact that follow others: those at the tip, and all along the beam."""
    return {"point": beam.length, "grid": discretization.contact_parts if where == "anywhere" else 1}


def _drop_derived(data: dict[str, Any]) -> None:
    """Remove the values that a file lists as derived, so that they follow other keys again.

    A value that is not the listed one was changed by hand since, and stays.  Raises InputError.
    """
    listed = data.pop(DERIVED, {})
    known = [*FOLLOWERS, "obstacles.N.stiffness"]
    if not isinstance(listed, dict) or not {re.sub(r"\.[1-9]\d*\.", ".N.", name) for name in listed} <= set(known):
        raise refused(DERIVED, listed, f"should be a table of {', '.join(known)}")
    flat = flat_keys(data)
    for name, value in listed.items():
        if name in flat and flat[name] == value:
            drop_key(data, name)


def _drop_without_effect(data: dict[str, Any], kept: Collection[str]) -> None:
    """Remove keys without effect, but those that are `kept`: a resolved file holds every key.

    Raises InputError.
    """
    token = _HOLDS_EVERY_KEY.set(True)
    try:
        found = Scenario.from_dict(data)
    finally:
        _HOLDS_EVERY_KEY.reset(token)
    for name, _ in effects.without_effect(found):
        if name not in kept:
            drop_key(data, name)


def require_scenario(value: object, where: str) -> Scenario:
    """Return a value if it is a Scenario; else raise InputError, in one line that begins with `where`."""
    if not isinstance(value, Scenario):
        makers = "Scenario.builtin(NAME), Scenario.load(FILE) and Scenario(...) make one"
        raise InputError(f"{where}: scenario = {short(value)}: should be a Scenario; {makers}")
    return value


def builtin_names() -> list[str]:
    """Return the names of the built-in scenarios, `paper` first."""
    names = sorted(p.name[:-5] for p in _builtin_folder().iterdir() if p.name.endswith(".toml"))
    return ["paper", *(name for name in names if name != "paper")]


def builtin_text(name: str) -> str:
    """Return the text of the file of a built-in scenario."""
    text: str = (_builtin_folder() / f"{name}.toml").read_text(encoding="utf-8")
    return text


def _builtin_folder() -> Any:
    return resources.files("oblique_impact.scenario") / "cases"

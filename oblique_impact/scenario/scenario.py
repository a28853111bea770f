"""The scenario of a simulation: a frozen, validated model in SI units; TOML files; the built-in cases."""

from __future__ import annotations

import os.path
import re
from collections.abc import Collection, Iterator
from contextvars import ContextVar
from importlib import resources
from pathlib import Path
from typing import Any, Self

import tomlkit
from pydantic import ConfigDict, model_validator

from oblique_impact.errors import InputError
from oblique_impact.files import read_text
from oblique_impact.scenario import consistency, effects
from oblique_impact.scenario.comments import commented, listing
from oblique_impact.scenario.materials import MATERIAL_PROPERTIES
from oblique_impact.scenario.mesh_file import take_mesh
from oblique_impact.scenario.messages import did_you_mean, refused, short
from oblique_impact.scenario.model import ScenarioModel
from oblique_impact.scenario.polylines import take_points
from oblique_impact.scenario.section import InputSection
from oblique_impact.scenario.shapes import SHAPE_PROPERTIES
from oblique_impact.scenario.toml import apply_change, drop_key, flat_keys, parse_toml, set_key

#: bytes; a scenario file has a hundred lines, and tables of a thousand
MAX_FILE = 1_000_000
#: table of a resolved file: values that were not given and follow other keys
DERIVED = "derived"
#: whether a resolved file is read, which holds keys without effect too (an argument would not reach validators)
_HOLDS_EVERY_KEY = ContextVar("_HOLDS_EVERY_KEY", default=False)
#: key of the items of a list of sections whose value may be derived from others
ITEM_FOLLOWERS = {"obstacles": "stiffness", "masses": "place", "forces": "place"}
#: keys whose values may be derived from others
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
        "patternProperties": {
            rf"^{items}\.[1-9][0-9]*\.{key}$": names["contact.point"] for items, key in ITEM_FOLLOWERS.items()
        },
        "additionalProperties": False,
    }


class Scenario(ScenarioModel):
    """One simulation, in SI units.

    Sections and keys are those of the scenario file, with these defaults, which are the paper's case:

        {keys}

    Examples
    --------
    >>> Scenario.builtin("paper").beam.length
    1.0
    """

    model_config = ConfigDict(validate_default=True, title="oblique-impact", json_schema_extra=_with_derived)
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
        every key, and of a text that is not the user's own are left out: there `overrides` alone are meant.  A
        material or shape among them takes the place of the numbers in the text that it gives.
        """
        data = parse_toml(text, name)
        resolved = DERIVED in data
        _drop_derived(data)
        changed = [apply_change(data, item) for item in overrides or []]
        _drop_replaced(data, changed)
        try:
            if folder is not None:
                take_mesh(data, Path() if "discretization.mesh" in changed else folder)
                take_points(data, folder, changed)
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
            raise InputError(f'scenario = "{source:.500}": {words}')
        try:
            text = read_text(path, MAX_FILE)
        except (OSError, ValueError) as error:
            raise InputError(f'scenario = "{source}": cannot be read: {error}') from None
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
        for items, key in ITEM_FOLLOWERS.items():
            keys += [f"{items}.{number}.{key}" for number in range(1, len(getattr(self, items)) + 1)]
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


def _drop_derived(data: dict[str, Any]) -> None:
    """Remove the values that a file lists as derived, so that they follow other keys again.

    A value that is not the listed one was changed by hand since, and stays.  Raises InputError.
    """
    listed = data.pop(DERIVED, {})
    known = [*FOLLOWERS, *(f"{items}.N.{key}" for items, key in ITEM_FOLLOWERS.items())]
    if not isinstance(listed, dict) or not {re.sub(r"\.[1-9]\d*\.", ".N.", name) for name in listed} <= set(known):
        raise refused(DERIVED, listed, f"should be a table of {', '.join(known)}")
    flat = flat_keys(data)
    for name, value in listed.items():
        if name in flat and flat[name] == value:
            drop_key(data, name)


def _drop_replaced(data: dict[str, Any], changed: Collection[str]) -> None:
    """Remove the numbers of a beam that follow from a material or shape that is `changed`, but changed ones."""
    givers = {"beam.material": MATERIAL_PROPERTIES, "beam.section": SHAPE_PROPERTIES}
    givers["beam.section.shape"] = SHAPE_PROPERTIES
    flat = flat_keys(data)
    for giver in givers.keys() & set(changed):
        if flat.get("beam.section.shape" if giver == "beam.section" else giver):
            for name in (f"beam.{follower}" for follower in givers[giver]):
                if name in flat and name not in changed:
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

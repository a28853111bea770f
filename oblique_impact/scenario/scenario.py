"""What to simulate: frozen, validated models in SI units; TOML in and out; the built-in cases."""

from __future__ import annotations

import os.path
from importlib import resources
from pathlib import Path
from typing import Any

import tomli_w
from pydantic import model_validator

from oblique_impact.errors import InputError
from oblique_impact.files import read_text
from oblique_impact.scenario.derived import TABLE, derive, derived_values, drop_derived_values
from oblique_impact.scenario.mesh_file import take_mesh
from oblique_impact.scenario.messages import did_you_mean, short
from oblique_impact.scenario.rules import check
from oblique_impact.scenario.schema import commented
from oblique_impact.scenario.sections import ScenarioKeys
from oblique_impact.scenario.toml import apply_change, flat_keys, parse_toml, set_key, with_line

#: bytes; a scenario file has a hundred lines, and tables of a thousand
MAX_FILE = 1_000_000


class Scenario(ScenarioKeys):
    """One simulation, in SI units.

    Sections and defaults are those of the scenario file; the defaults are the paper's case.

    Examples
    --------
    >>> Scenario.builtin("paper").beam.length
    1.0
    """

    @model_validator(mode="after")
    def _consistent(self) -> Scenario:
        derive(self)
        check(self)
        return self

    @classmethod
    def from_toml(
        cls,
        text: str,
        overrides: list[str] | None = None,
        name: str = "scenario file",
        folder: Path | None = None,
    ) -> Scenario:
        """Read a scenario file's text; `overrides` are strings "section.key=value", `name` begins its errors.

        A file that the text names is read if the `folder` is given that its path begins in; those that `overrides`
        name begin in the present one.
        """
        data = parse_toml(text, name)
        changed: set[str] = set()
        try:
            drop_derived_values(data)
            changed.update(apply_change(data, item) for item in overrides or [])
            if folder is not None:
                take_mesh(data, Path() if "discretization.mesh" in changed else folder)
            return cls.from_dict(data)
        except InputError as error:
            raise with_line(error, text, name, changed) from None

    @classmethod
    def builtin(cls, name: str, overrides: list[str] | None = None) -> Scenario:
        """Return the built-in case `name` (see `builtin_names`)."""
        if name not in builtin_names():
            known = f"{', '.join(builtin_names())}{did_you_mean(name, builtin_names())}"
            raise InputError(f"scenario = {short(name)}: built-in scenarios are {known}")
        return cls.from_toml(builtin_text(name), overrides, name="", folder=Path())

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
        data, whole = self.model_dump(mode="json", exclude_unset=True), self.model_dump(mode="json")
        for name, value in values.items():
            set_key(whole, name.split("__"), value, name)  # which knows what is no section
            set_key(data, name.split("__"), value, name)
        return Scenario.from_dict(data)

    def to_toml(self) -> str:
        """Return the fully resolved scenario file, a comment above each key with its meaning, unit and range.

        Its table `derived` lists the values that follow other keys.
        """
        data = self._with_derived()
        data["parameters"] = {part: numbers for part, numbers in data["parameters"].items() if numbers}
        # sizes of other shapes are left out
        data["beam"]["section"] = {key: value for key, value in data["beam"]["section"].items() if value}
        followers = tomli_w.dumps({TABLE: data[TABLE]})
        return f"{commented(data)}\n# not given: these values follow other keys\n{followers}"

    def _with_derived(self) -> dict[str, Any]:
        """Return the data of a resolved file."""
        data = self.model_dump(mode="json")
        flat = flat_keys(data)
        return {**data, TABLE: {path: flat[path] for path in derived_values(self)}}


def require_scenario(value: object, where: str) -> Scenario:
    """Return a value if it is a scenario; else raises InputError, in one line that begins with `where`."""
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

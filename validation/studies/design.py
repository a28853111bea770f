"""Sweep files: a scenario over axes, tables and samples of its keys; all combinations, in a fixed order."""

from __future__ import annotations

import itertools
import json
import math
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
import tomli_w
from pydantic import AfterValidator, Field, model_validator
from scipy.stats import qmc

from oblique_impact.errors import InputError
from oblique_impact.files import read_text
from oblique_impact.scenario.effects import idle
from oblique_impact.scenario.messages import did_you_mean, plain_text, refused, short
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.schema import key_schemas, label_of, schema_of, unit_of_key
from oblique_impact.scenario.section import InputSection
from oblique_impact.scenario.toml import flat_keys, parse_toml
from oblique_impact.scenario.units import Unit
from oblique_impact.validation.studies.periodic import PeriodicSection, drive_period
from oblique_impact.validation.studies.quantities import Quantity, default_quantities, quantity
from oblique_impact.validation.studies.study import StudyRun

MAX_RUNS = 100_000
#: what a sweep of periodic responses is asked for if the user names nothing
RESPONSE = ("period", "impacts_per_period", "max:bending_stress")

#: two numbers, or texts with a unit
Range = Annotated[tuple[Any, Any], Field(strict=False)]
Keys = Annotated[list[str], Field(min_length=1)]
Values = Annotated[list[Any], Field(min_length=1, max_length=MAX_RUNS)]


def _default(key: str) -> Any:
    """Return the default value of a key, of an obstacle too."""
    return (schema_of(key) or {})["default"]


def check_keys(keys: Iterable[str], where: str) -> None:
    """Raise InputError for the first that is no key of a scenario."""
    for key in keys:
        if schema_of(key) is None:
            section = f"{key.rpartition('.')[0]}."
            inside = [known.removeprefix(section) for known in key_schemas() if known.startswith(section)]
            words = f"[{section[:-1]}] has {', '.join(inside)}" if inside else "known are those of a scenario file"
            raise refused(where, key, f"not a key of a scenario; {words}{did_you_mean(key, key_schemas())}")


def si_value(key: str, value: Any) -> Any:
    """Return a value whose texts with a unit are numbers in SI units; raises InputError."""
    schema = schema_of(key) or {}
    words = tuple(word for one in schema.get("anyOf", ()) for word in one.get("enum", ()))
    unit = schema.get("unit", "1")
    try:
        return value if unit == "1" else Unit(unit, words=words).convert(value)
    except ValueError as error:
        raise refused(key, value, f"should be {error}") from None


class AxisSection(InputSection):
    """One direction of a sweep: its keys and their values.

    `key`, or `keys` that take the same value, have `values`, or `count` values in a `range`, linear or log spaced;
    in a sample they are spread over a `range`.
    """

    key: str | None = None
    keys: Keys | None = None
    values: Values | None = None
    range: Range | None = None
    count: Annotated[int, Field(ge=2, le=MAX_RUNS)] | None = None
    spacing: Literal["linear", "log"] | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.key is None) == (self.keys is None):
            raise InputError("key: takes key, or keys that have the same value; exactly one of them")
        check_keys(self.names, "key" if self.keys is None else "keys")
        if (self.values is None) == (self.range is None):
            both = "not both" if self.range is not None else "one of them is needed"
            raise InputError(f"values: takes values, or range; {both}")
        if self.range is None and (self.count, self.spacing) != (None, None):
            raise InputError("count and spacing: only with range, not with values")
        self.rows()
        return self

    @property
    def names(self) -> tuple[str, ...]:
        """The keys."""
        return tuple(self.keys or ()) if self.key is None else (self.key,)

    @property
    def label(self) -> str:
        """Keys as one name."""
        return " = ".join(self.names)

    @property
    def words(self) -> str:
        """Meanings of the keys, for axes and tables."""
        return " = ".join(label_of(name) for name in self.names)

    @property
    def unit(self) -> str:
        """SI unit, "1" for numbers without one, "" for words and switches."""
        return unit_of_key(self.names[0])

    @property
    def whole(self) -> bool:
        """Whether the values are whole numbers."""
        return type(_default(self.names[0])) is int

    def ends(self) -> tuple[Any, Any]:
        """Return the two ends of the range in SI units, numbers or places [x, y]; raises InputError."""
        given = self.range or ()
        kinds = {type(_default(key)) for key in self.names}
        place = kinds == {list} and all(len(_default(key)) == 2 for key in self.names)
        if kinds not in ({float}, {int}) and not (place and self.count and self.spacing != "log"):
            words = "is for keys that are all floats or all integers, linear ones with a count for places too"
            raise refused("range", list(given), f"{words}; use values")
        start, stop = (si_value(self.names[0], end) for end in given)
        numbers = [*start, *stop] if place and type(start) is type(stop) is list else [start, stop]
        if (
            not all(type(end) in (int, float) and abs(end) <= 1e30 for end in numbers)
            or len(numbers) != 2 + 2 * place
        ):
            wanted = "places [x, y]" if place else "finite numbers, or texts with a unit"
            raise refused("range", list(given), f"should be two {wanted}")
        if start == stop:
            raise refused("range", list(given), "the two ends should differ")
        if self.spacing == "log" and not (start > 0.0 and stop > 0.0):
            raise refused("range", list(given), "both should be greater than 0 for log spacing")
        return start, stop

    def rows(self) -> list[tuple[Any, ...]]:
        """Return its values, a row each; raises InputError."""
        if self.range is None:
            return [(si_value(self.names[0], value),) for value in self.values or ()]
        spread = np.geomspace if self.spacing == "log" else np.linspace
        values = spread(*self.ends(), self.count or 2).tolist()
        for value in values if self.whole else ():
            if not math.isclose(value, round(value)):
                raise InputError(f"range: {self.names[0]} = {value:.6g}: should be a whole number; use values")
        return [(round(value) if self.whole else value,) for value in values]

    def spread(self, parts: np.ndarray) -> list[Any]:
        """Return the values at parts of the range from 0 to 1."""
        start, stop = self.ends()
        if self.whole:
            low, high = sorted((round(start), round(stop)))
            values = np.minimum(low + (parts * (high - low + 1)).astype(int), high)
        else:
            values = start * (stop / start) ** parts if self.spacing == "log" else start + parts * (stop - start)
        found: list[Any] = values.tolist()
        return found


class HypercubeSection(InputSection):
    """A sample of `samples` points of a hypercube, the same ones for the same `seed`."""

    samples: Annotated[int, Field(ge=1, le=MAX_RUNS)]
    seed: Annotated[int, Field(ge=0, lt=2**63)]
    axes: Annotated[list[AxisSection], Field(min_length=1)]

    @model_validator(mode="after")
    def _check(self) -> Self:
        if any(axis.range is None or axis.count for axis in self.axes):
            raise InputError("axes: of a sample each takes a range, and no count")
        return self

    def rows(self, sampler: type[qmc.QMCEngine]) -> list[tuple[Any, ...]]:
        """Return the points, a value for each of the axes."""
        points = sampler(len(self.axes), seed=np.random.default_rng(self.seed)).random(self.samples)
        return list(zip(*(axis.spread(p) for axis, p in zip(self.axes, points.T, strict=True)), strict=True))


class TableSection(InputSection):
    """Rows of values for `keys`."""

    keys: Keys
    rows: Annotated[list[Annotated[list[Any], Field(min_length=1)]], Field(min_length=1, max_length=MAX_RUNS)]

    @model_validator(mode="after")
    def _check(self) -> Self:
        check_keys(self.keys, "keys")
        for number, row in enumerate(self.rows):
            if len(row) != len(self.keys):
                raise refused(f"rows.{number}", row, f"should have one value a key, {len(self.keys)}")
        return self


class SweepFile(InputSection):
    """A sweep file; all blocks (axes, table, Latin hypercube, Sobol sequence) are combined with each other."""

    title: Annotated[str, AfterValidator(plain_text)] = ""
    description: str = ""
    scenario: str = "paper"
    changes: dict[str, Any] = Field(default_factory=dict)
    quantities: Annotated[list[str], Field(min_length=1)] | None = None
    histories: bool = False
    axes: Annotated[list[AxisSection], Field(min_length=1)] | None = None
    periodic: PeriodicSection | None = None
    table: TableSection | None = None
    latin_hypercube: HypercubeSection | None = None
    sobol: HypercubeSection | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        """Refuse too many runs, or none, before they are made."""
        check_keys(flat_keys(self.changes), "changes")
        if self.sobol and self.sobol.samples & (self.sobol.samples - 1):
            raise InputError(f"sobol.samples = {self.sobol.samples}: should be a power of 2")
        for number, axis in enumerate(self.axes or ()):
            if axis.range and axis.count is None:
                raise InputError(
                    f"axes.{number}.count: missing; how many values from {' to '.join(map(str, axis.range))}?"
                )
        sizes = [len(rows) for _, rows in self.blocks()]
        if self.periodic and (len(sizes) != len(self.axes or ()) or not sizes):
            raise InputError("periodic: takes [[axes]] alone; steady states are continued along the last of them")
        sizes += [len(self.periodic.directions)] if self.periodic else []
        if not sizes:
            raise InputError("nothing to sweep over; give [[axes]], [table], [latin_hypercube] or [sobol]")
        if math.prod(sizes) > MAX_RUNS:
            product = " x ".join(str(size) for size in sizes)
            raise InputError(f"{product} = {short(math.prod(sizes))} runs; at most {MAX_RUNS} are allowed")
        return self

    def blocks(self) -> list[tuple[list[AxisSection], list[tuple[Any, ...]]]]:
        """Return the directions of each block, and its rows with a value for each of them; raises InputError."""
        found = [([axis], axis.rows()) for axis in self.axes or ()]
        if self.table:
            columns = zip(self.table.keys, zip(*self.table.rows, strict=True), strict=True)
            rows = [tuple(map(si_value, self.table.keys, row)) for row in self.table.rows]
            found.append(([AxisSection(key=key, values=list(values)) for key, values in columns], rows))
        for cube, sampler in ((self.latin_hypercube, qmc.LatinHypercube), (self.sobol, qmc.Sobol)):
            if cube:
                found.append((cube.axes, cube.rows(sampler)))
        return found


@dataclass(frozen=True)
class Plan:
    """A sweep that can run."""

    #: as it was written
    file: SweepFile
    #: the scenario that is changed
    base: Scenario
    #: values of keys that hold for all runs
    changes: dict[str, Any]
    #: what changes from run to run
    directions: tuple[AxisSection, ...]
    #: all combinations, the last block changing fastest; "run" counts them from 1
    runs: tuple[StudyRun, ...] = field(repr=False)

    @property
    def grid(self) -> bool:
        """Whether it consists of axes alone."""
        return not (self.file.table or self.file.latin_hypercube or self.file.sobol)

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Quantities that are measured in each run."""
        return tuple(quantity(name) for name in self.runs[0].quantities)

    @property
    def impossible(self) -> list[StudyRun]:
        """Runs whose values do not fit together; they become rows that say why."""
        return [run for run in self.runs if run.scenario is None]

    def to_toml(self) -> str:
        """Return the sweep file of this plan; its scenario lies beside it as scenario.toml."""
        data = self.file.model_dump(mode="json", exclude_none=True) | {"scenario": "scenario.toml"}
        return tomli_w.dumps({**data, "quantities": list(self.runs[0].quantities)})


def load_plan(source: str | os.PathLike[str], base: Scenario | None = None) -> Plan:
    """Read a sweep file; `base` takes the place of its scenario.

    Raises InputError, in one line that names the key, its value and what is allowed.
    """
    name, path = os.fspath(source), Path(source)
    if not os.path.isfile(path):
        raise refused(
            "sweep", name, "not a file; sweeps to start from are in docs/studies, and in the documentation"
        )
    data = read_toml(path, "sweep")
    try:
        return plan_of(SweepFile.from_dict(data), path.parent, base)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def read_toml(path: Path, what: str) -> dict[str, Any]:
    """Read a TOML file; raises InputError in one line, which calls a file that cannot be read `what`."""
    try:
        text = read_text(path)
    except (OSError, ValueError) as error:
        raise refused(what, str(path), f"cannot be read: {short(str(error))}") from None
    return parse_toml(text, str(path))


def scenario_beside(name: str, folder: Path) -> Scenario:
    """Load the scenario that a file in `folder` names: one beside it, a built-in one or one by its path."""
    beside = folder / name
    return Scenario.load(str(beside) if beside.suffix == ".toml" and beside.is_file() else name)


def make_plan(text: str) -> Plan:
    """Return the plan of a sweep file's text; raises InputError."""
    return plan_of(SweepFile.from_dict(parse_toml(text, "sweep file")))


def plan_of(file: SweepFile, folder: Path = Path(), base: Scenario | None = None) -> Plan:
    """Check a sweep, and make its runs; `base` takes the place of the scenario that it names.

    Raises InputError for what cannot be, or if no run is possible.
    """
    base = base or scenario_beside(file.scenario, folder)
    changes, blocks = flat_keys(file.changes), file.blocks()
    directions = tuple(itertools.chain(*(directions for directions, _ in blocks)))
    keys = [*changes, *(key for direction in directions for key in direction.names)]
    for key in keys:
        if keys.count(key) > 1:
            raise InputError(f"{key} is set twice; once in changes, or in one of the blocks")
    made: list[tuple[dict[str, Any], Scenario | None, str]] = []
    for parts in itertools.product(*(rows for _, rows in blocks)):
        row = zip(directions, itertools.chain(*parts), strict=True)
        values = {key: value for direction, value in row for key in direction.names}
        changed = {key.replace(".", "__"): value for key, value in {**changes, **values}.items()}
        try:
            found = base.adapted(values, **changed)
            if file.periodic:
                drive_period(found)
        except InputError as error:
            made.append((values, None, str(error)))
        else:
            # as the scenario holds them
            made.append(({key: found.value_of(key) for key in values}, found, ""))
    possible = [scenario for _, scenario, _ in made if scenario]
    if not possible:
        raise InputError(made[0][2] + (" (and no other run is possible)" if len(made) > 1 else ""))
    for key in keys:
        words = [idle(scenario, key) for scenario in possible]
        if all(words):
            raise refused(key, possible[0].value_of(key), words[0])
    default = RESPONSE if file.periodic else default_quantities(possible[0])
    # by its period a picture tells steady states apart
    wanted = tuple(dict.fromkeys([*(file.quantities or default), *(["period"] if file.periodic else [])]))
    longest = max(scenario.end_time for scenario in possible)
    try:
        for name in wanted:
            quantity(name, longest)
    except InputError as error:
        raise InputError(f"quantities: {str(error).removeprefix('--quantity ')}") from None
    lists = {key for values, *_ in made for key, value in values.items() if isinstance(value, list | tuple)}
    texts = {
        key
        for values, *_ in made
        for key, value in values.items()
        if isinstance(value, str) and isinstance(_default(key), str)
    }
    runs = []
    for number, (values, scenario, fault) in enumerate(made, start=1):
        labels = {key: _entry(key, value, key in lists, key in texts) for key, value in values.items()}
        runs.append(StudyRun({"run": number, **labels}, scenario, wanted, fault))
    if file.periodic:
        runs = _continued(runs, len(blocks[-1][1]), file.periodic)
    return Plan(file, base, changes, directions, tuple(runs))


def _continued(runs: Sequence[StudyRun], count: int, periodic: PeriodicSection) -> list[StudyRun]:
    """Return the runs up and down the last axis, which has `count` values, each going on from the one before."""
    found = list[StudyRun]()
    for first in range(0, len(runs), count):
        for direction in periodic.directions:
            branch = runs[first : first + count]
            for number, run in enumerate(branch if direction == "up" else branch[::-1]):
                labels = {**run.labels, "run": len(found) + 1, "direction": direction}
                found.append(replace(run, labels=labels, periodic=periodic, continued=number > 0))
    return found


def _entry(key: str, value: Any, as_json: bool, as_text: bool) -> Any:
    """Return a value for a column of one type, as parquet has it.

    Where some values are lists, all are JSON, and where some are words, as of a direction, all are texts.
    """
    if as_json or as_text:
        return json.dumps(value) if as_json else str(value)
    # a text that no scenario takes is no number
    return math.nan if isinstance(value, str) and not isinstance(_default(key), str) else value

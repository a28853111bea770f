"""Measured data: a CSV file whose header names quantities with units, and what a run says of each of them.

The first line names the columns, each as NAME [UNIT] or NAME (UNIT), with commas between them, or with semicolons
or tabs, where numbers may have decimal commas; lines that begin with # are comments, an empty cell is a
value that was not measured.  With a column `time` the others are series,

    time [ms], displacement@0.1 m [mm], strain@30 mm [um/m], theta [deg]

of sensors (:func:`~oblique_impact.history.sensors.sensor_reading`) or of variables of a history; without one
they are quantities of the whole run, as in :mod:`~oblique_impact.validation.studies.quantities`, and
each line is one repetition of the measurement:

    start:1 [ms], start:2 [ms], impulse [N s], impulse +- [N s], restitution

Natural frequencies and damping ratios about the equilibrium, as of `modes --closed`, stand among columns of both
kinds, and in a table of rows, one for each value; a line without a deviation has none:

    quantity, value, deviation
    frequency:1 [Hz], 8.21, 0.02
    damping:1, 0.0041, 0.0003

NAME +- is the standard deviation of the values of NAME.  A table that `export` has written is read as well, but
for what nobody measures: coordinates, states, clearances, and what belongs to one of several contacts.
"""

from __future__ import annotations

import csv
import io
import math
import os
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import read_text
from oblique_impact.history.history import History
from oblique_impact.history.interpolation import series_at
from oblique_impact.history.sensors import SENSORS, sensor_reading
from oblique_impact.history.variables import VARIABLES as EXPORTED
from oblique_impact.scenario.messages import did_you_mean, short
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.units import Unit
from oblique_impact.simulation import compute_history as simulate
from oblique_impact.validation.studies.quantities import (
    VARIABLES,
    GapError,
    UnknownQuantityError,
    quantity,
    quantity_table,
)
from oblique_impact.vibration import VibrationModes, frequencies_at_rest

Array = NDArray[np.float64]

_TIME, _SPREAD = "time", " +-"
#: quantities at rest, by their mode, and their units
_MODES = {"frequency": "Hz", "damping": "1"}
_OF_MODE = re.compile(r"(frequency|damping):([1-9]\d*)")
_MOST_MODES = 100
_ROWS = "quantity", "value", "deviation"
_HEADING = re.compile(r"\s*([^\[\]()]+?)\s*(?:\[([^\[\]]*)\]|\((.*)\))?\s*")


class Reading(NamedTuple):
    """How a run is asked for a column."""

    #: SI unit
    unit: str
    #: takes a run and times (n,) in s, returns what the run says (n,); raises GapError
    read: Callable[[Any, Array], Array]
    #: whether no run is needed, but the scenario alone
    at_rest: bool = False


class Unrun(NamedTuple):
    """A scenario in the place of its run, where nothing is asked that needs one."""

    scenario: Scenario


@dataclass(frozen=True)
class Measured:
    """Measured values in SI units, and how a run is asked for them."""

    #: a row for each value, column by column: `column`, `unit`, `time` (s; NaN of a quantity of the whole run),
    #: `measured`, `deviation` (standard deviation; NaN where the file has none)
    table: pd.DataFrame
    #: by column
    readings: Mapping[str, Reading]

    def predict(self, run: History | Unrun, shift: float = 0.0) -> Array:
        """Return what a run says of each value (n,), of series `shift` (s) later; raises GapError without one."""
        if isinstance(run, History):
            reached = run["time"].values[-1]
            if self.table["time"].max() + shift > reached and run.outcome is not Outcome.COMPLETED:
                raise GapError(f"ended at {reached:.4g} s: {run.outcome.label}")
        times = self.table.groupby("column", sort=False)["time"]
        return np.concatenate([self.readings[str(name)].read(run, of.to_numpy() + shift) for name, of in times])

    def run(self, scenario: Scenario) -> History | Unrun:
        """Return the run of a scenario, if one is asked for."""
        return simulate(scenario) if self.needs_run else Unrun(scenario)

    @property
    def needs_run(self) -> bool:
        """Whether something is asked that the scenario alone does not tell."""
        return not all(reading.at_rest for reading in self.readings.values())

    @property
    def needs_times_alone(self) -> bool:
        """Whether a run has to reach the last of the series only."""
        of_run = [name for name, reading in self.readings.items() if not reading.at_rest]
        return bool(self.table["time"][self.table["column"].isin(of_run)].notna().all()) and bool(of_run)


class Experiment(NamedTuple):
    """A scenario with what was measured of it."""

    name: str
    scenario: Scenario
    measured: Measured


@dataclass(frozen=True)
class Campaign:
    """Experiments that determine keys together."""

    experiments: tuple[Experiment, ...]

    @cached_property
    def table(self) -> pd.DataFrame:
        """The tables of all, one below the other; `scenario` is the number of the experiment."""
        tables = [one.measured.table.assign(scenario=k) for k, one in enumerate(self.experiments, start=1)]
        return pd.concat(tables, ignore_index=True)

    @property
    def has_deviations(self) -> bool:
        """Whether the files have standard deviations."""
        return bool(self.table["deviation"].notna().all())

    def first_deviations(self) -> Array:
        """Return standard deviations (n,) to begin with: of the files, or the scatter about means of columns."""
        if self.has_deviations:
            return np.asarray(self.table["deviation"])
        values = self.table["measured"].to_numpy()
        means = self.table.groupby(["scenario", "column"])["measured"].transform("mean")
        scatter = values - means.to_numpy()
        return self._by_unit(lambda own: max(np.std(scatter[own]), 1e-2 * np.abs(values[own]).max()) or 1.0)

    def deviations_from(self, misfit: Array, fitted: int) -> Array:
        """Return standard deviations (n,) from run - measured (n,), with so many fitted keys."""
        values, left = np.abs(self.table["measured"].to_numpy()), 1.0 - fitted / misfit.size
        # of data without noise the error of the run is left
        return self._by_unit(
            lambda own: max(math.sqrt(np.mean(misfit[own] ** 2) / left), 1e-9 * values[own].max(), 1e-300)
        )

    def _by_unit(self, deviation: Callable[[NDArray[np.intp]], float]) -> Array:
        """Return the standard deviation of all values of a unit for each value (n,); it is given their numbers."""
        found = np.empty(len(self.table))
        for own in self.table.groupby("unit").indices.values():
            found[own] = deviation(own)
        return found


def read_measured(path: str | os.PathLike[str], scenario: Scenario) -> Measured:
    """Read a file of measured data for a scenario, whose length and duration bound places and times.

    Raises InputError, in one line, for what cannot be read, unknown names, wrong units and missing numbers.
    """
    try:
        text = read_text(Path(path))
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    # a comment stays an empty line, so that lines keep their numbers
    text = "".join("\n" if line.lstrip().startswith("#") else line for line in io.StringIO(text))
    try:
        header, rows, lines = _as_columns(*_rows(text))
        readings, names, factors = _readings(header, scenario)
        values = pd.DataFrame(_numbers(names, rows, lines) * factors, columns=names)
        return _measured(values.loc[:, np.isfinite(factors)], readings, scenario.end_time)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _rows(text: str) -> tuple[list[str], list[list[str]], list[int]]:
    """Return the cells of the header and of the other rows, and the lines in which these begin."""
    separator = next((found for found in ";\t" if found in text.lstrip().partition("\n")[0]), ",")
    reader, found, lines = csv.reader(io.StringIO(text), delimiter=separator, skipinitialspace=True), [], [1]
    try:
        for row in reader:
            if len(row) > 1 or "".join(row).strip():
                found.append(row)
                lines.append(reader.line_num + 1)
            else:
                lines[-1] = reader.line_num + 1
    except csv.Error as error:
        raise InputError(f"line {lines[-1]}: {error}") from None
    if len(found) < 2:
        raise InputError("should have a line of names with units, and lines of numbers")
    header, *rows = found
    return header, rows, lines[1:-1]


def _as_columns(
    header: list[str], rows: list[list[str]], lines: list[int]
) -> tuple[list[str], list[list[str]], list[int]]:
    """Return a table of rows, a quantity with its value each, as columns; others as they are."""
    names = [cell.strip().lower() for cell in header]
    if names[:1] != list(_ROWS[:1]) or tuple(names) not in (_ROWS, _ROWS[:2]):
        return header, rows, lines
    columns = dict[str, list[str]]()
    for row, line in zip(rows, lines, strict=True):
        if len(row) != len(header):
            raise InputError(f"line {line}: has {len(row)} cells, the header {len(header)}")
        name, value, *spread = (cell.strip() for cell in row)
        columns.setdefault(name, []).append(value)
        if any(spread):
            bare, bracket, unit = name.partition("[")
            columns.setdefault(f"{bare.strip()}{_SPREAD} {bracket}{unit}".strip(), []).append(spread[0])
    most = max(map(len, columns.values()))
    cells = [[values[k] if k < len(values) else "" for values in columns.values()] for k in range(most)]
    return [*columns], cells, (lines * most)[:most]


def _readings(header: Sequence[str], scenario: Scenario) -> tuple[dict[str, Reading], list[str], Array]:
    """Return the reading of each column of values, the names of all columns and their factors to SI units.

    The factor of a column that is left out is NaN.
    """
    headings = [_HEADING.fullmatch(text) for text in header]
    if None in headings:
        wrong = short(header[headings.index(None)])
        raise InputError(f"column {wrong}: should be NAME [UNIT], as time [ms], with commas between columns")
    names = [" ".join(found[1].replace("+-", _SPREAD).split()) for found in headings if found]
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise InputError(f"column {twice[0]}: stands there twice")
    readings, factors = dict[str, Reading](), list[float]()
    for name, found in zip(names, headings, strict=True):
        given = found and (found[2] if found[3] is None else found[3])
        of = name.removesuffix(_SPREAD)
        if found and found[3] is not None and _is_not_measured(name):
            factors.append(math.nan)
            continue
        if of not in names:
            raise InputError(f"column {name}: there is no column {of}")
        if of != _TIME and of not in readings:
            whole = _whole if _TIME not in names else _series
            readings[of] = _of_mode(of) if of.partition(":")[0] in _MODES else whole(of, scenario)
        unit = "s" if of == _TIME else readings[of].unit
        factors.append(_factor(name, (given or "").strip(), unit))
    if not readings:
        raise InputError("there is no column of measured values besides time")
    return readings, names, np.array(factors)


def _is_not_measured(name: str) -> bool:
    """Whether a column of an exported history is no measurement: q_0, state, contact_gap_1."""
    of = EXPORTED.get(name) or EXPORTED.get(re.sub(r"_\d+$", "", name))
    return name not in (_TIME, *VARIABLES) and of is not None and of.dimensions != ("time", "station")


def _factor(name: str, given: str, unit: str) -> float:
    """Return the value of a column's unit in SI units; "" and "-" are those of a number without one."""
    if given in ("", "-", "1"):
        if unit == "1":
            return 1.0
        raise InputError(f"column {name}: its unit is missing; write {name} [{unit}]")
    if unit == "Hz" and given.replace(" ", "") == "rad/s":
        return 0.5 / math.pi
    try:
        return Unit(unit).to_si(f"1 {given}")
    except ValueError as error:
        raise InputError(f"column {name} [{given}]: should be {error}") from None


def _series(name: str, scenario: Scenario) -> Reading:
    """Return the reading of a column over time."""
    if name in VARIABLES:
        return Reading(VARIABLES[name][0], lambda history, times: _variable_at(history, name, times))
    sensor, at, place = name.partition("@")
    if sensor not in SENSORS or not at:
        known = [f"{sensor}@PLACE" for sensor in SENSORS]
        words = f"{', '.join(known)}, variables of a history as theta{did_you_mean(name, [*known, *VARIABLES])}"
        raise InputError(f"column {name}: known over time are {words}")
    try:
        x = Unit("m").to_si(place)
    except ValueError:
        x = math.nan
    if not 0.0 <= x <= scenario.beam.length:
        words = f"the place should be from 0 to {scenario.beam.length:g} m, as {sensor}@0.1 m"
        raise InputError(f"column {name}: {words}")
    return Reading(SENSORS[sensor], lambda history, times: sensor_reading(history, sensor, x, times))


def _variable_at(history: History, name: str, times: Array) -> Array:
    values = history.total_energy if name == "energy" else history[name]
    return series_at(history["time"].values, np.asarray(values.values, dtype=float), times)


def _of_mode(name: str) -> Reading:
    """Return the reading of a frequency (Hz) or damping ratio of a mode about the equilibrium."""
    found = _OF_MODE.fullmatch(name)
    if found is None or int(found[2]) > _MOST_MODES:
        raise InputError(f"column {name}: should be {name.partition(':')[0]}:N, N from 1 to {_MOST_MODES}")
    kind, number = found[1], int(found[2])

    def read(run: History | Unrun, times: Array) -> Array:
        modes = _modes_of(run.scenario)
        if number > modes.frequencies.size:
            raise GapError(f"{name}: the scenario has {modes.frequencies.size} modes")
        value = (
            modes.frequencies[number - 1] / (2.0 * math.pi) if kind == "frequency" else modes.damping[number - 1]
        )
        return np.full(times.size, value)

    return Reading(_MODES[kind], read, at_rest=True)


@lru_cache(maxsize=8)  # each column asks
def _modes_of(scenario: Scenario) -> VibrationModes:
    """Return all modes of a scenario about its equilibrium."""
    return frequencies_at_rest(scenario, _MOST_MODES)


def _whole(name: str, scenario: Scenario) -> Reading:
    """Return the reading of a column of quantities of the whole run."""
    try:
        asked = quantity(name, scenario.end_time)
    except UnknownQuantityError:
        words = f"is no quantity of a run{did_you_mean(name, quantity_table().index)}"
        raise InputError(f"column {name}: {words}; a column time makes the others series") from None
    except InputError as error:
        raise InputError(f"column {str(error).removeprefix('--quantity ')}") from None
    return Reading(asked.unit, lambda history, times: np.full(times.size, asked.measure(history)))


def _numbers(names: Sequence[str], rows: Sequence[Sequence[str]], lines: Sequence[int]) -> Array:
    """Return the numbers (rows, columns) of the cells, NaN where one is empty.

    A comma is that of a decimal, beside which a point is none.
    """
    commas = any("," in cell for row in rows for cell in row)
    numbers = np.full((len(rows), len(names)), math.nan)
    for found, row, line in zip(numbers, rows, lines, strict=True):
        if len(row) != len(names):
            comma = "; decimal commas need semicolons between columns" if len(row) == 2 * len(names) else ""
            raise InputError(f"line {line}: has {len(row)} cells, the header {len(names)}{comma}")
        for k, cell in enumerate(row):
            try:
                decimal = cell.replace(".", "'").replace(",", ".") if commas else cell
                found[k] = float(decimal) if cell.strip() else math.nan
            except ValueError:
                found[k] = math.inf
            if math.isinf(found[k]):
                raise InputError(f"line {line}: {names[k]} = {short(cell)}: should be a number, or empty")
    return numbers


def _measured(values: pd.DataFrame, readings: Mapping[str, Reading], end_time: float) -> Measured:
    """Return the data of columns in SI units; raises InputError for numbers that are missing or out of range."""
    of_run = [name for name, reading in readings.items() if not reading.at_rest]
    timed = values[values[of_run].notna().any(axis=1)] if _TIME in values else values[:0]
    if _TIME in values and not timed[_TIME].between(0.0, end_time).all():
        raise InputError(f"time: should be from 0 to end_time {end_time:g} s of the scenario in every line")
    for name in readings:
        if values[name].isna().all():
            raise InputError(f"{name}: the column is empty")
        if name + _SPREAD in values and not (values[name + _SPREAD] > 0.0)[values[name].notna()].all():
            raise InputError(f"{name}{_SPREAD}: should be greater than 0 wherever {name} is given")
    table = values[[*readings]].melt(var_name="column", value_name="measured")
    table.insert(1, "unit", table["column"].map({name: reading.unit for name, reading in readings.items()}))
    table.insert(2, "time", np.tile(values.get(_TIME, np.full(len(values), math.nan)), len(readings)))
    table["deviation"] = values.reindex(columns=[name + _SPREAD for name in readings]).melt()["value"]
    table.loc[[readings[str(name)].at_rest for name in table["column"]], "time"] = math.nan
    table = table.dropna(subset="measured", ignore_index=True)
    known = table["deviation"].notna()
    if known.any() and not known.all():
        without = table["column"][~known].iloc[0]
        raise InputError(f"{without}{_SPREAD}: missing; give standard deviations of all columns, or of none")
    of_the_unit = table.groupby("unit")["unit"].transform("size")
    for name in table["column"][~known & (of_the_unit < min(3, len(table)))].head(1):
        raise InputError(f"column {name}{_SPREAD}: missing; without it at least 3 values of a unit are needed")
    return Measured(table, readings)

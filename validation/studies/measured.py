"""Measured data: a CSV file whose header names quantities with units, and what a run says of each of them.

The first line names the columns, each as NAME [UNIT]; lines that begin with # are comments, an empty cell is a
value that was not measured.  With a column `time` the others are series,

    time [ms], displacement@0.1 m [mm], strain@30 mm [um/m], theta [deg]

without one they are quantities of the whole run, as in :mod:`~oblique_impact.validation.studies.quantities`, and
each line is one repetition of the measurement:

    start:1 [ms], start:2 [ms], impulse [N s], impulse +- [N s], restitution

NAME +- is the standard deviation of the values of NAME.  Series at a place x along the beam, seen from the base:

`displacement@x`  from where the point was at t = 0, across the line of the beam at t = 0
`velocity@x`      in that direction too: both as by a laser that stands on the base
`acceleration@x`  across the axis of the beam there, without gravity: as by a sensor on the beam
`strain@x`        of bending, on the outer fibre on the side of negative y
"""

from __future__ import annotations

import csv
import math
import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import read_text
from oblique_impact.history.axis_motion import SENSORS, sensor_reading
from oblique_impact.history.history import History
from oblique_impact.history.interpolation import series_at
from oblique_impact.scenario.messages import did_you_mean, short
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.units import Unit
from oblique_impact.validation.studies.quantities import VARIABLES, GapError, quantity

Array = NDArray[np.float64]

_TIME, _SPREAD = "time", "+-"
_HEADING = re.compile(r"\s*([^\[\]]+?)\s*(?:\[([^\[\]]*)\])?\s*")


@dataclass(frozen=True)
class Column:
    """Measured values of one quantity, in SI units."""

    name: str
    unit: str
    #: (n,) s of a series; NaN of a quantity of the whole run
    times: Array
    values: Array  # (n,)
    deviations: Array  # (n,) standard deviations; NaN where the file has none
    #: takes a History and times (n,), returns what the run says (n,); raises GapError
    predict: Callable[[History, Array], Array]


def read_measured(path: str | os.PathLike[str], scenario: Scenario) -> list[Column]:
    """Read a file of measured data for a scenario, whose length and duration bound places and times.

    Raises InputError, in one line, for what cannot be read, unknown names, wrong units and missing numbers.
    """
    try:
        lines = read_text(Path(path)).splitlines()
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    kept = [
        (number, line) for number, line in enumerate(lines, start=1) if line.strip() and line.lstrip()[0] != "#"
    ]
    if len(kept) < 2:
        raise InputError(f"{path}: should have a line of names with units, and lines of numbers")
    table = list(csv.reader((line for _, line in kept), skipinitialspace=True))
    try:
        return _columns(table[0], table[1:], [number for number, _ in kept[1:]], scenario)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _columns(header: list[str], rows: list[list[str]], lines: list[int], scenario: Scenario) -> list[Column]:
    names, factors = _names(header, scenario)
    numbers = np.empty((len(rows), len(names)))
    for row, line, found in zip(rows, lines, numbers, strict=True):
        if len(row) != len(names):
            raise InputError(f"line {line}: has {len(row)} cells, the header {len(names)}")
        for k, cell in enumerate(row):
            try:
                found[k] = float(cell) if cell.strip() else math.nan
            except ValueError:
                found[k] = math.inf
            if math.isinf(found[k]):
                raise InputError(f"line {line}: {names[k]} = {short(cell)}: should be a number, or empty")
    by_name = dict(zip(names, (numbers * factors).T, strict=True))
    times, nothing = by_name.pop(_TIME, None), np.full(len(rows), math.nan)
    if times is not None and not np.all((times >= 0.0) & (times <= scenario.end_time)):
        raise InputError(
            f"time: should be from 0 to end_time {scenario.end_time:g} s of the scenario in every line"
        )
    columns = []
    for name in (name for name in by_name if not name.endswith(_SPREAD)):
        unit, predict = _quantity(name, times is not None, scenario)
        there, values = np.isfinite(by_name[name]), by_name[name]
        spread = by_name.get(f"{name} {_SPREAD}", nothing)
        if not there.any():
            raise InputError(f"{name}: the column is empty")
        if f"{name} {_SPREAD}" in by_name and not np.all(spread[there] > 0.0):
            raise InputError(f"{name} {_SPREAD}: should be greater than 0 wherever {name} is given")
        moments = nothing if times is None else times
        columns.append(Column(name, unit, moments[there], values[there], spread[there], predict))
    if not columns:
        raise InputError("there is no column of measured values besides time")
    known = [bool(np.isfinite(column.deviations[0])) for column in columns]
    if any(known) and not all(known):
        without = columns[known.index(False)].name
        raise InputError(f"{without} {_SPREAD}: missing; give standard deviations of all columns, or of none")
    return columns


def _names(header: list[str], scenario: Scenario) -> tuple[list[str], Array]:
    """Return the names of the columns and the factors to SI units."""
    names, factors, series = list[str](), list[float](), False
    for text in header:
        found = _HEADING.fullmatch(text)
        if found is None:
            raise InputError(
                f"column {short(text)}: should be NAME [UNIT], as time [ms], with commas between columns"
            )
        name = " ".join(found[1].split())
        if name in names:
            raise InputError(f"column {name}: stands there twice")
        series |= name == _TIME
        names.append(name)
    for name, text in zip(names, header, strict=True):
        given, of = (_HEADING.fullmatch(text) or [""] * 3)[2], name.removesuffix(_SPREAD).rstrip()
        if of != name and of not in names:
            raise InputError(f"column {name}: there is no column {of}")
        unit = "s" if name == _TIME else _quantity(of, series, scenario)[0]
        if given is None and unit != "1":
            raise InputError(f"column {name}: its unit is missing; write {name} [{unit}]")
        try:
            factors.append(1.0 if given in (None, "", "-") else Unit(unit).to_si(f"1 {given}"))
        except ValueError as error:
            raise InputError(f"column {name} [{given}]: should be {error}") from None
    return names, np.array(factors)


def _quantity(name: str, series: bool, scenario: Scenario) -> tuple[str, Callable[[History, Array], Array]]:
    """Return unit and prediction of a column; raises InputError."""
    if not series:
        try:
            asked = quantity(name, scenario.end_time)
        except InputError as error:
            words = str(error).removeprefix("--quantity ")
            raise InputError(f"column {words}; a column time makes the others series") from None
        return asked.unit, lambda history, times: np.full(times.size, asked.measure(history))
    if name in VARIABLES:
        return VARIABLES[name][0], lambda history, times: _variable_at(history, name, times)
    sensor, at, place = name.partition("@")
    if sensor not in SENSORS or not at:
        known = [*(f"{sensor}@PLACE" for sensor in SENSORS), *VARIABLES]
        raise InputError(f"column {name}: known over time are {', '.join(known)}{did_you_mean(name, known)}")
    try:
        x = Unit("m").to_si(place)
    except ValueError:
        x = math.nan
    if not 0.0 <= x <= scenario.beam.length:
        raise InputError(
            f"column {name}: the place should be from 0 to {scenario.beam.length:g} m, as {sensor}@0.1 m"
        )
    return SENSORS[sensor], lambda history, times: _sensor_at(history, sensor, x, times)


def _sensor_at(history: History, sensor: str, place: float, times: Array) -> Array:
    _require_reached(history, times)
    return sensor_reading(history, sensor, place, times)


def _variable_at(history: History, name: str, times: Array) -> Array:
    _require_reached(history, times)
    values = history.total_energy if name == "energy" else history[name]
    return series_at(history["time"].values, np.asarray(values.values, dtype=float), times)


def _require_reached(history: History, times: Array) -> None:
    """Raise GapError for times beyond the end of a run."""
    end = history["time"].values[-1]
    if times.max() > end and history.outcome is not Outcome.COMPLETED:
        raise GapError(f"ended at {end:.4g} s: {history.outcome.label}")

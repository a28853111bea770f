"""What a run leaves: samples, event log and summary; file in and out. Holds no live object."""

from __future__ import annotations

import csv
import io
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from oblique_impact.contact import State
from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import cannot_write, prepare_folder, write_text, write_whole
from oblique_impact.marching import Event
from oblique_impact.transitions import EventKind

FORMAT = "oblique-impact history 1"
EVENT_COLUMNS = (
    "time",
    "kind",
    "normal_impulse",
    "normal_velocity",
    "tangential_velocity",
    "energy_loss",
    "state",
)
FILES = ("scenario.toml", "history.nc", "events.csv", "summary.json")


@dataclass(frozen=True)
class History:
    """Samples, events and summary of one run.

    Attributes
    ----------
    data : xarray.Dataset
        Labelled samples with `units` and `long_name`; at a jump two samples carry the same time.
    events : list of Event
        The transitions in order of time.
    summary : dict
        Outcome, macro-collisions, energy ledger, costs and versions, as in summary.json.
    scenario_toml : str
        The fully resolved scenario; empty for a system that has none.
    """

    data: xr.Dataset
    events: list[Event]
    summary: dict[str, Any]
    scenario_toml: str = ""

    def __getitem__(self, name: str) -> xr.DataArray:
        """Return one labelled array, e.g. ``history["theta"]``."""
        return self.data[name]

    @property
    def outcome(self) -> Outcome:
        """How the run ended."""
        label = self.summary["outcome"]
        return next(outcome for outcome in Outcome if outcome.label == label)

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Write scenario.toml, history.nc, events.csv and summary.json; each appears whole or not at all.

        Raises InputError if the folder cannot be written.
        """
        target = prepare_folder(folder)
        try:
            write_text(target / "scenario.toml", self.scenario_toml)
            write_whole(target / "history.nc", self._write_netcdf)
            write_text(target / "events.csv", self.events_csv())
            write_text(target / "summary.json", json.dumps(self.summary, indent=2) + "\n")
        except OSError as error:
            raise cannot_write(target, error) from None
        return target

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> History:
        """Read a run folder, or the history.nc inside one; nothing in it is executed.

        Raises InputError with one line if it is not a history of this format.
        """
        file = Path(path)
        file = file / "history.nc" if file.is_dir() else file
        if not _is_file(file):
            raise InputError(f"{file}: no such history")
        try:
            with xr.open_dataset(file, engine="h5netcdf") as opened:
                data = opened.load()
            if data.attrs.get("format") != FORMAT:
                raise InputError(f"{file}: not a history of this version ({FORMAT})")
            events = [_event(row) for row in json.loads(data.attrs.pop("events"))]
            summary = json.loads(data.attrs.pop("summary"))
            scenario = str(data.attrs.pop("scenario"))
        except InputError:
            raise
        except Exception as error:  # damaged files raise whatever the reader's layers raise
            reason = " ".join(str(error).split())[:200] or type(error).__name__
            raise InputError(f"{file}: not a readable history: {reason}") from None
        return cls(data, events, summary, scenario)

    def events_csv(self) -> str:
        """Return the event log as CSV text."""
        buffer = io.StringIO()
        writer = csv.writer(buffer, lineterminator="\n")
        writer.writerow(EVENT_COLUMNS)
        writer.writerows([_cell(value) for value in _row(event)] for event in self.events)
        return buffer.getvalue()

    def _write_netcdf(self, path: Path) -> None:
        rows = [[e.time, e.kind.value, *map(float, e[2:7]), e.state.name.lower()] for e in self.events]
        attributes = {
            **self.data.attrs,
            "format": FORMAT,
            "scenario": self.scenario_toml,
            "events": json.dumps(rows),
            "summary": json.dumps(self.summary),
        }
        encoding = {name: {"zlib": True, "complevel": 1} for name in self.data.data_vars}
        self.data.assign_attrs(attributes).to_netcdf(path, engine="h5netcdf", encoding=encoding)


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name too long for the file system
        return False


def _row(event: Event) -> tuple[Any, ...]:
    return (
        event.time,
        event.kind.value,
        event.normal_impulse,
        event.normal_velocity,
        event.tangential_velocity,
        event.energy_loss,
        event.state.name.lower(),
    )


def _cell(value: Any) -> str:
    return repr(float(value)) if isinstance(value, float) else str(value)


def _event(row: list[Any]) -> Event:
    time, kind, normal, tangential, gap_rate, slip_rate, loss, state = row
    numbers = float(normal), float(tangential), float(gap_rate), float(slip_rate), float(loss)
    return Event(float(time), EventKind(kind), *numbers, State[state.upper()])


def labelled(values: np.ndarray, dimensions: tuple[str, ...], units: str, long_name: str) -> xr.DataArray:
    """Return an array with its dimensions, units and meaning."""
    return xr.DataArray(values, dims=dimensions, attrs={"units": units, "long_name": long_name})

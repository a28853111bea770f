"""What a run leaves: samples, event log and summary; file in and out. Holds no live object."""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import cannot_write, prepare_folder, write_all
from oblique_impact.history.draft import Draft
from oblique_impact.history.foreign import is_history, no_history, not_a_history
from oblique_impact.history.netcdf import DIMENSIONS_ATTRIBUTE, read_netcdf
from oblique_impact.history.netcdf_writer import write_netcdf
from oblique_impact.history.variables import (
    DIMENSIONS,
    check_summary,
    check_times_of_events,
    check_variables,
    read_json,
)
from oblique_impact.marching.loop import Contact, Event
from oblique_impact.scenario.messages import short

if TYPE_CHECKING:
    from xarray.core.resample import DatasetResample

FORMAT = "oblique-impact history 2"
EVENT_COLUMNS = (
    "time",
    "kind",
    "normal_impulse",
    "normal_velocity",
    "tangential_velocity",
    "energy_loss",
    "state",
    "tangential_impulse",
    "peak_force",
    "peak_energy",
)
FILES = ("scenario.toml", "history.nc", "events.csv", "summary.json")


@dataclass(frozen=True)
class History:
    """Samples, events and summary of one run.

    Attributes
    ----------
    data : xarray.Dataset
        Labelled samples with `units` and `long_name`; at a jump the left one stands at the time of the
        event, the right one at the next larger floating-point number.
    events : list of Event
        The transitions in order of time.
    summary : dict
        Outcome, macro-collisions, energy ledger, costs and versions, as in summary.json.
    scenario_toml : str
        The fully resolved scenario; empty for a system that has none.
    contacts : list of Contact
        The closed contacts in order of time: spans, impulses, largest force and stored energy, losses.
    """

    data: xr.Dataset
    events: list[Event]
    summary: dict[str, Any]
    scenario_toml: str = ""
    contacts: list[Contact] = field(default_factory=list)

    def __getitem__(self, name: str) -> xr.DataArray:
        """Return one labelled array, e.g. ``history["theta"]``."""
        return self.data[name]

    def sel(self, **options: Any) -> xr.Dataset:
        """Select samples by label, as :meth:`xarray.Dataset.sel`: ``history.sel(time=0.32, method="nearest")``."""
        return self.data.sel(**options)

    def interp(self, **options: Any) -> xr.Dataset:
        """Interpolate in time or along the beam, as :meth:`xarray.Dataset.interp`: ``interp(time=0.32)``."""
        return self.data.interp(**options)

    def resample(self, **options: Any) -> DatasetResample:
        """Group samples by spans of time, as :meth:`xarray.Dataset.resample`.

        ``history.resample(time="1ms").mean()`` averages over milliseconds.  xarray groups times of its own kind
        alone, so they become durations (timedelta64) from 0 s.
        """
        from pandas import to_timedelta

        durations = to_timedelta(self.data["time"].values, unit="s")
        return self.data.assign_coords(time=durations).resample(**options)

    @property
    def outcome(self) -> Outcome:
        """How the run ended."""
        label = self.summary["outcome"]
        return next(outcome for outcome in Outcome if outcome.label == label)

    def save(self, folder: str | os.PathLike[str], draft: Draft | None = None) -> Path:
        """Write scenario.toml, history.nc, events.csv and summary.json; all of them whole, or none.

        Parameters
        ----------
        folder : path
            Where to.
        draft : Draft, optional
            Begun by `simulate`; one of another run or for another folder is left alone.

        Raises
        ------
        InputError
            If the folder cannot be written.
        """
        target = prepare_folder(folder)
        texts = {
            "scenario.toml": self.scenario_toml,
            "events.csv": self.events_csv(),
            "summary.json": json.dumps(self.summary, indent=2) + "\n",
        }
        write: Callable[[xr.Dataset, Path], None] = write_netcdf
        if draft is not None and draft.is_of(self.data, target):
            write = draft.complete
        writers: dict[Path, Callable[[Path], Any]] = {target / "history.nc": partial(write, self._labelled())}
        for name, text in texts.items():
            writers[target / name] = partial(Path.write_text, data=text, encoding="utf-8")
        try:
            write_all(writers)
        except OSError as error:
            raise cannot_write(target, error) from None
        return target

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> History:
        """Read a run folder, or the history.nc inside one; nothing in it is executed, no other file is read.

        Raises InputError with one line if it is not a history of this format, or is damaged.
        """
        file = Path(path)
        file = file / "history.nc" if _is(file, Path.is_dir) else file
        if not _is(file, Path.is_file):
            raise InputError(no_history(Path(path), FILES))
        try:
            data = read_netcdf(file, DIMENSIONS)
            return _from_data(cls, data)
        except Exception as error:  # damaged files raise whatever the reader's layers raise
            if not is_history(file):
                raise InputError(not_a_history(file)) from None
            reason = " ".join(str(error).split())[:200] or type(error).__name__
            raise InputError(f"{file}: not a readable history: {reason}") from None

    def events_csv(self) -> str:
        """Return the event log as CSV text."""
        buffer = io.StringIO()
        writer = csv.writer(buffer, lineterminator="\n")
        writer.writerow(EVENT_COLUMNS)
        writer.writerows([_cell(value) for value in _row(event)] for event in self.events)
        return buffer.getvalue()

    def _labelled(self) -> xr.Dataset:
        """Return the data with all the rest in attributes."""
        attributes = {
            **self.data.attrs,
            "format": FORMAT,
            "scenario": self.scenario_toml,
            "events": json.dumps([_row(event) for event in self.events]),
            "contacts": json.dumps(self.contacts),
            "summary": json.dumps(self.summary),
        }
        labelled = self.data.copy().assign_attrs(attributes)
        for name, variable in labelled.variables.items():
            # the reader does not follow a file's own lists of dimensions
            if name not in DIMENSIONS:
                variable.attrs[DIMENSIONS_ATTRIBUTE] = " ".join(map(str, variable.dims))
        return labelled


def require_history(value: object, where: str) -> None:
    """Raise InputError, in one line that begins with `where`, if a value is no history."""
    if not isinstance(value, History):
        makers = "simulate(SCENARIO) and History.load(PATH) return one"
        raise InputError(f"{where}: history = {short(value)}: should be a History; {makers}")


def _from_data(cls: type[History], data: xr.Dataset) -> History:
    """Take a file's data apart and hold every part against what a history is; raises InputError."""
    if data.attrs.get("format") != FORMAT:
        raise InputError(f"not of this version ({FORMAT})")
    check_variables(data)
    first, last = float(data["time"][0]), float(data["time"][-1])
    events = [_event(row) for row in read_json(data.attrs.pop("events", ""), "events", list)]
    check_times_of_events([event.time for event in events], first, last)
    summary = read_json(data.attrs.pop("summary", ""), "summary", dict)
    check_summary(summary, first, last)
    scenario = data.attrs.pop("scenario", None)
    if not isinstance(scenario, str):
        raise InputError("attribute scenario: missing, or not a text")
    contacts = [_contact(row) for row in read_json(data.attrs.pop("contacts", ""), "contacts", list)]
    return cls(data, events, summary, scenario, contacts)


def _is(path: Path, what: Callable[[Path], bool]) -> bool:
    try:
        return what(path)
    except (OSError, ValueError):  # a name too long for the file system, or one with a null character
        return False


def _row(event: Event) -> list[Any]:
    """Return an event in the order of `EVENT_COLUMNS`."""
    words = {"kind": event.kind.value, "state": event.state.name.lower()}
    return [words.get(name) or float(getattr(event, name)) for name in EVENT_COLUMNS]


def _cell(value: Any) -> str:
    return repr(float(value)) if isinstance(value, float) else str(value)


def _event(row: list[Any]) -> Event:
    try:
        given = dict(zip(EVENT_COLUMNS, row, strict=True))
        kind, state = EventKind(given.pop("kind")), State[given.pop("state").upper()]
        return Event(kind=kind, state=state, **{name: float(value) for name, value in given.items()})
    except (TypeError, ValueError, KeyError, AttributeError, OverflowError):
        raise InputError(f"attribute events: {short(row)} is not an event") from None


def _contact(row: list[Any]) -> Contact:
    try:
        return Contact._make(map(float, row))
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"attribute contacts: {short(row)} is not a contact") from None

"""What a run leaves: samples, event log and summary; file in and out. Holds no live object."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import cannot_write, prepare_folder, write_all
from oblique_impact.history.events import event_row, events_csv, read_events
from oblique_impact.history.netcdf import is_history, read_netcdf, write_netcdf
from oblique_impact.history.summary import EARLIER_MACRO_GAP, parsed, read_summary
from oblique_impact.history.variables import check_variables
from oblique_impact.installed import reason
from oblique_impact.marching.records import Contact, Event
from oblique_impact.scenario.messages import short
from oblique_impact.scenario.scenario import builtin_names

if TYPE_CHECKING:
    from xarray.core.resample import DatasetResample

FORMAT = "oblique-impact history 2"
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
        As in summary.json, see :class:`~oblique_impact.history.summary.Summary`.
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

        ``history.resample(time="1ms").mean()`` averages over milliseconds.  xarray groups dates and durations
        alone, so times become durations (timedelta64) from 0 s.
        """
        from pandas import to_timedelta

        durations = to_timedelta(self.data["time"].values, unit="s")
        return self.data.assign_coords(time=durations).resample(**options)

    @property
    def outcome(self) -> Outcome:
        """How the run ended."""
        label = self.summary["outcome"]
        return next(outcome for outcome in Outcome if outcome.label == label)

    @property
    def macro_gap(self) -> float:
        """Contacts less than this apart (s) are one macro-collision."""
        return float(self.summary.get("macro_gap", EARLIER_MACRO_GAP))

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Write scenario.toml, history.nc, events.csv and summary.json into `folder`, all of them or none.

        Raises InputError if the folder cannot be written.
        """
        target = prepare_folder(folder)
        texts = {
            "scenario.toml": self.scenario_toml,
            "events.csv": self.events_csv(),
            "summary.json": json.dumps(self.summary, indent=2) + "\n",
        }
        writers: dict[Path, Callable[[Path], Any]] = {
            target / name: partial(Path.write_text, data=text, encoding="utf-8") for name, text in texts.items()
        }
        try:
            write_all({target / "history.nc": partial(write_netcdf, self._with_attributes()), **writers})
        except OSError as error:
            raise cannot_write(target, error) from None
        return target

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> History:
        """Read a run folder, or the history.nc inside one; nothing in it is executed, no other file is read.

        Raises InputError with one line if it is not a history of this format, or is damaged.
        """
        file = Path(path)
        if os.path.isdir(file):
            lacking = [name for name in FILES if not (file / name).exists()]
            file = file / "history.nc"
            if not file.is_file():
                raise InputError(f"{path}: is not the folder of a run: it lacks {', '.join(lacking)}")
        elif not os.path.isfile(file):
            run = f"; run the scenario first: oblique-impact run {path} --out DIR, and give DIR"
            raise InputError(f"{path}: no such history{run if str(path) in builtin_names() else ''}")
        try:
            return _from_data(read_netcdf(file))
        except Exception as error:  # damaged files raise whatever the reader's layers raise
            if not is_history(file):
                raise InputError(_not_a_history(file)) from None
            raise InputError(f"{file}: not a readable history: {reason(error)}") from None

    def events_csv(self) -> str:
        """Return the event log as CSV text."""
        return events_csv(self.events)

    def _with_attributes(self) -> xr.Dataset:
        """Return the data with all the rest in attributes."""
        return self.data.assign_attrs(
            format=FORMAT,
            scenario=self.scenario_toml,
            events=json.dumps([event_row(event) for event in self.events]),
            contacts=json.dumps(self.contacts),
            summary=json.dumps(self.summary),
        )


def require_history(value: object, where: str) -> None:
    """Raise InputError, in one line that begins with `where`, if a value is no history."""
    if not isinstance(value, History):
        makers = "simulate(SCENARIO) and History.load(PATH) return one"
        raise InputError(f"{where}: history = {short(value)}: should be a History; {makers}")


def _from_data(data: xr.Dataset) -> History:
    """Take a file's data apart and hold every part against what a history is; raises InputError."""
    if data.attrs.get("format") != FORMAT:
        raise InputError(f"not of this version ({FORMAT})")
    check_variables(data)
    first, last = float(data["time"][0]), float(data["time"][-1])
    texts = {name: str(data.attrs.pop(name, "")) for name in ("events", "summary", "scenario", "contacts")}
    return History(
        data,
        read_events(texts["events"], first, last),
        read_summary(texts["summary"], first, last),
        texts["scenario"],
        parsed(texts["contacts"], "contacts", list[Contact]),
    )


def _not_a_history(file: Path) -> str:
    """Return the line for a file that is no history of this program."""
    line = f"{file}: is not a history written by oblique-impact (history.nc)"
    beside = file.with_name("history.nc")
    if file != beside and beside.is_file():
        return f"{line}; one lies beside it: {beside}"
    if file.suffix.lower() == ".toml":
        return f"{line}; run a scenario first: oblique-impact run {file} --out DIR, and give DIR"
    return line

"""What a run leaves: samples, event log and summary; file in and out. Holds no live object."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import cannot_write, only_writer, prepare_folder, remove_leftovers, write_all
from oblique_impact.history.at_a_time import Side, dataset_at
from oblique_impact.history.events import EVENT_COLUMNS, event_row, events_csv, read_events
from oblique_impact.history.netcdf import is_history, read_netcdf, write_netcdf
from oblique_impact.history.summary import EARLIER_MACRO_GAP, balance_in_words, parsed, read_summary
from oblique_impact.history.variables import (
    Stored,
    check_variables,
    dataset,
    names_at_once,
    stored,
    with_later,
)
from oblique_impact.marching.records import Contact, Event
from oblique_impact.scenario.messages import short
from oblique_impact.scenario.scenario import Scenario, builtin_names
from oblique_impact.scenario.toml import parse_toml

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure
    from pyvista import PolyData
    from xarray.core.resample import DatasetResample

FORMAT = "oblique-impact history 2"
FILES = ("scenario.toml", "history.nc", "events.csv", "summary.json")


@dataclass(frozen=True, repr=False)
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
    scenario_toml: str = field(default_factory=str)
    contacts: list[Contact] = field(default_factory=list)

    @classmethod
    def of_columns(
        cls,
        columns: Mapping[str, NDArray[Any]],
        events: list[Event],
        summary: dict[str, Any],
        scenario: Scenario | None,
        contacts: list[Contact],
        judge: Callable[[], dict[str, Any]] = dict,
    ) -> History:
        """Return a history of known variables, by name.

        `data`, the scenario's text and what `judge` adds to the summary are made when asked for: xarray takes
        longer to load than the paper's case to run, and a study of impulses has no use for warnings.
        """
        history = cls(cast(Any, None), events, summary, contacts=contacts)
        del history.__dict__["data"], history.__dict__["summary"]
        history.__dict__["_columns"] = columns
        history.__dict__["_summary"] = summary, judge
        if scenario is not None:
            del history.__dict__["scenario_toml"]
            history.__dict__["_scenario"] = scenario
        return history

    def __getitem__(self, name: str) -> xr.DataArray:
        """Return one labelled array, e.g. ``history["theta"]``; raises KeyError."""
        return self._labelled(name)[name]

    def __getattr__(self, name: str) -> xr.DataArray:
        """Return one labelled array, e.g. ``history.lambda_n``."""
        if name == "scenario_toml" and "_scenario" in self.__dict__:
            text: Any = self.__dict__["_scenario"].to_toml()
            return self.__dict__.setdefault(name, text)  # type: ignore[no-any-return]
        if name == "summary" and "_summary" in self.__dict__:
            known, judge = self.__dict__["_summary"]
            self.__dict__.setdefault("summary", {**known, **judge()})
            self.__dict__.pop("_summary", None)
            return self.__dict__["summary"]  # type: ignore[no-any-return]
        if name == "data" and "_columns" in self.__dict__:
            columns, early = self.__dict__["_columns"], self.__dict__.get("_early")
            found: Any = dataset(columns) if early is None else with_later(early, columns)
            self.__dict__.setdefault("data", found)
            for done in ("_columns", "_early"):  # not before: an interrupt may come in between
                self.__dict__.pop(done, None)
            return self.__dict__["data"]  # type: ignore[no-any-return]
        known = self.__dict__.keys() & {"data", "_columns"}  # neither while one is copied or unpickled
        if name.startswith("_") or not known or name not in self:
            raise AttributeError(f"a History has no attribute or variable {name!r}")
        return self[name]

    def __getstate__(self) -> dict[str, Any]:
        """Send and store variables once: the labels that some have already are made again."""
        if "_summary" in self.__dict__:
            self.__getattr__("summary")
        if "_early" in self.__dict__:
            self.__getattr__("data")
        return self.__dict__

    def __dir__(self) -> list[str]:
        """Names for completion, those of the variables among them."""
        return sorted({*super().__dir__(), *self})

    def __contains__(self, name: object) -> bool:
        """Whether there is a variable of this name."""
        return name in self._names()

    def __iter__(self) -> Iterator[str]:
        """Go over the names of the variables, those of the axes among them."""
        return iter(self._names())

    def __len__(self) -> int:
        """Return the number of variables."""
        return len(self._names())

    def __repr__(self) -> str:
        """Say in a few lines what happened."""
        return "\n".join(digest(self))

    def _repr_html_(self) -> str:
        """Say it in a notebook, with the macro-collisions in a table."""
        from pandas import DataFrame

        lines = "<br>".join(escape(line) for line in digest(self)[:4])
        table = DataFrame(self.macro_collisions).to_html(index=False, float_format="{:.6g}".format)
        return f"<div>{lines}{table if self.macro_collisions else ''}</div>"

    def at(self, time: float, side: Side = "right") -> xr.Dataset:
        """Return all variables at a time (s), between samples by cubics.

        At an event that makes velocities jump, `side` chooses what is just before or just after it.  Raises
        InputError for a time outside of the run.
        """
        return dataset_at(self.data, time, side)

    def beam_at(self, time: float, side: Side = "right") -> NDArray[np.float64]:
        """Return the points (stations, 2) in m of the deformed axis in the inertial frame at a time (s).

        Raises InputError for a system that is no beam, or a time outside of the run.
        """
        if "ux" not in self:
            raise InputError("beam_at: this is the history of a system that is no beam")
        now, radius = self.at(time, side), Scenario.from_toml(self.scenario_toml).root.hub_radius
        z = np.exp(1j * now["theta"].values) * (radius + now["station"] + now["ux"] + 1j * now["uy"]).values
        return np.stack([z.real, z.imag], axis=1)

    @property
    def event_table(self) -> pd.DataFrame:
        """The event log as a table, a row an event from 1, with the columns of events.csv (SI units)."""
        from pandas import DataFrame, RangeIndex

        numbers = RangeIndex(1, len(self.events) + 1, name="event")
        return DataFrame([event_row(event) for event in self.events], numbers, list(EVENT_COLUMNS))

    @property
    def time_series(self) -> pd.DataFrame:
        """The variables over time as a table, a row a sample, in SI units.

        Coordinates have the columns q_0, q_1, ... and qd_0, qd_1, ...; variables along the beam are left out.
        """
        from pandas import DataFrame

        columns = {"time": self["time"].values}
        for name, variable in self.data.data_vars.items():
            if variable.dims == ("time",):
                columns[str(name)] = variable.values
            elif variable.dims == ("time", "coordinate"):
                columns |= {f"{name}_{number}": values for number, values in enumerate(variable.values.T)}
        return DataFrame(columns)

    @property
    def contact_table(self) -> pd.DataFrame:
        """The closed contacts as a table, a row a contact from 1 (SI units)."""
        from pandas import DataFrame, RangeIndex

        return DataFrame(
            self.contacts, RangeIndex(1, len(self.contacts) + 1, name="contact"), list(Contact._fields)
        )

    @property
    def macro_collisions(self) -> list[dict[str, Any]]:
        """Contacts that belong together, see :class:`~oblique_impact.history.summary.MacroCollision`."""
        found: list[dict[str, Any]] = self._measured["macro_collisions"]
        return found

    @property
    def balance(self) -> dict[str, float]:
        """The balance of energy (J), see :class:`~oblique_impact.history.summary.Ledger`."""
        found: dict[str, float] = self._measured["energy"]
        return found

    @property
    def end_time(self) -> float:
        """Time (s) at which the run ended."""
        return float(self._measured["end_time"])

    @property
    def steps(self) -> int:
        """Steps that were taken."""
        return int(self._measured["steps"])

    @property
    def total_energy(self) -> xr.DataArray:
        """Kinetic, elastic and gravity energy (J) of each sample; what an elastic stop stores is not in it."""
        total = self["energy_kinetic"] + self["energy_elastic"] + self["energy_gravity"]
        return total.assign_attrs(units="J", long_name="total energy").rename("total_energy")

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
        label = self._measured["outcome"]
        return next(outcome for outcome in Outcome if outcome.label == label)

    @property
    def macro_gap(self) -> float:
        """Contacts less than this apart (s) are one macro-collision."""
        return float(self._measured.get("macro_gap", EARLIER_MACRO_GAP))

    @property
    def _measured(self) -> dict[str, Any]:
        """The summary, or what of it is known without judging."""
        known: dict[str, Any] = self.__dict__["_summary"][0] if "_summary" in self.__dict__ else self.summary
        return known

    def plot(self) -> Figure:
        """Draw the overview of a beam's run: motion, shapes, contact force, gap, energies, losses.

        Raises InputError for a system that is no beam.
        """
        from oblique_impact.renders.overview import overview

        self._require_beam("plot")
        return overview({"run": self})

    def to_pyvista(self, time: float, deformation: float = 1.0) -> PolyData:
        """Return the surface of the beam at a time (s) as a mesh with all results, in SI units.

        `deformation` magnifies the bending, not the results.  Raises InputError for a system that is no beam, or a
        time outside of the run.
        """
        from oblique_impact.renders.meshes import beam_mesh

        self._require_beam("to_pyvista")
        return beam_mesh(self, time, deformation)

    def _require_beam(self, caller: str) -> None:
        if "theta" not in self:
            raise InputError(f"{caller}: this is the history of a system that is no beam")

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
            target / "history.nc": partial(write_netcdf, list(self._stored()), self._attributes()),
            **{
                target / name: partial(Path.write_text, data=text, encoding="utf-8")
                for name, text in texts.items()
            },
        }
        try:
            with ExitStack() as lock:
                # another process that writes here is no reason not to: the last one wins
                with suppress(InputError):
                    lock.enter_context(only_writer(target))
                    remove_leftovers(writers)
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
            raise InputError(f"{file}: not a readable history: {error}") from None

    def events_csv(self) -> str:
        """Return the event log as CSV text."""
        return events_csv(self.events)

    def _names(self) -> list[str]:
        columns = self.__dict__.get("_columns")
        return [str(name) for name in (self.data.variables if columns is None else columns)]

    def _labelled(self, name: object) -> xr.Dataset:
        """Return labelled data that have a variable: those without what takes long until that is asked for."""
        columns: Mapping[str, Any] = self.__dict__.get("_columns", {})
        if not isinstance(name, str) or name not in names_at_once(columns):
            return self.data
        if "_early" not in self.__dict__:
            self.__dict__["_early"] = dataset({known: columns[known] for known in names_at_once(columns)})
        found: xr.Dataset = self.__dict__["_early"]
        return found

    def _stored(self) -> Iterator[Stored]:
        """Yield the variables as they are stored."""
        if "_columns" in self.__dict__ and "_early" not in self.__dict__:
            yield from stored(self.__dict__["_columns"])
        else:
            for name, variable in self.data.variables.items():
                dimensions = tuple(map(str, variable.dims))
                yield Stored(str(name), dimensions, variable.values, dict(variable.attrs))

    def _attributes(self) -> dict[str, Any]:
        """Return all besides the variables, as attributes of a file."""
        own = {} if "_columns" in self.__dict__ else {str(name): value for name, value in self.data.attrs.items()}
        return {
            **own,
            "format": FORMAT,
            "scenario": self.scenario_toml,
            "events": json.dumps([event_row(event) for event in self.events]),
            "contacts": json.dumps(self.contacts),
            "summary": json.dumps(self.summary),
        }


def digest(history: History) -> list[str]:
    """Return what a history holds and what happened, in at most ten lines."""
    s, sizes = history.summary, history.data.sizes
    names = "a beam" if "theta" in history else "a system"
    parts = ", ".join(f"{count} {name}s" for name, count in sizes.items() if name != "time")
    energy = s["energy"]
    lost = {
        name.removeprefix("lost_"): value for name, value in energy.items() if name.startswith("lost_") and value
    }
    lines = [
        f"<History of {names}: {s['outcome']} at {s['end_time']:.6g} s, {s['steps']} steps>",
        f"  samples     {sizes['time']} ({parts}); {len(history)} variables",
        f"  events      {len(history.events)}, {len(history.contacts)} contacts",
        f"  energy      {balance_in_words(energy)}, unaccounted {energy['unaccounted']:.1e}",
    ]
    if lost:
        lines.append(f"  lost (J)    {', '.join(f'{name} {value:.4g}' for name, value in lost.items())}")
    shown = history.macro_collisions[:3]
    for number, m in enumerate(shown, 1):
        span = f"{m['start']:.6f} to {m['end']:.6f} s, {m['contacts']} contacts, {m['normal_impulse']:.6g} N s"
        lines.append(f"  collision {number} {span}")
    if len(history.macro_collisions) > len(shown):
        lines.append(f"  and {len(history.macro_collisions) - len(shown)} more")
    return lines


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
    parse_toml(texts["scenario"], "attribute scenario")
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

"""The result of a run: samples, event log and summary; written to a folder and read back."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, partial
from html import escape
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any
from warnings import warn

import h5py
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from oblique_impact.beam.beam import Beam
from oblique_impact.beam.bent_beam import BentBeam
from oblique_impact.beam.clearance import closest
from oblique_impact.beam.frequencies import clustering_time
from oblique_impact.beam.validity.run_warnings import run_warnings
from oblique_impact.contact.log import Contact, Event
from oblique_impact.contact.state import State
from oblique_impact.errors import FileWarning, InputError, Outcome
from oblique_impact.files import save_all, writing
from oblique_impact.history.digest import digest_line, has_digest
from oblique_impact.history.events import (
    EVENT_COLUMNS,
    event_of,
    event_row,
    events_csv,
    numbers_of,
)
from oblique_impact.history.interpolation import Side, dataset_at
from oblique_impact.history.netcdf import netcdf_bytes, read_netcdf
from oblique_impact.history.older_files import FORMAT_OF_WHOLE_FILES, FORMAT_WITHOUT_CONTACTS, with_contacts
from oblique_impact.history.samples import Column, Samples, rates_along, section_forces
from oblique_impact.history.summary import balance_text, require_summary, summarize
from oblique_impact.history.variables import (
    ADDED_LATER,
    COMPUTED,
    OF_A_BEAM,
    OF_A_FREE_BEAM,
    OF_A_SLOPE,
    OF_A_SYSTEM,
    OF_FEW_COORDINATES,
    RATES_ALONG,
    SECTION_FORCES,
    VARIABLES,
    dataset,
)
from oblique_impact.marching.records import Record
from oblique_impact.scenario.messages import counted, short
from oblique_impact.scenario.scenario import Scenario, builtin_names

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure
    from pyvista import PolyData

FORMAT = "oblique-impact history 4"
FILES = ("scenario.toml", "history.nc", "events.csv", "summary.json")
#: larger numbers belong to no run; their squares overflow where lengths and energies are computed
_LARGEST = np.float64(1e150)
#: headings of a table of macro-collisions
_OF_COLLISIONS = {"start": "start (s)", "end": "end (s)", "peak_force": "largest force (N)"}
_OF_COLLISIONS |= {"normal_impulse": "normal impulse (N s)", "tangential_impulse": "tangential impulse (N s)"}
#: attributes of a file that belong to other parts of a history than its data
_OWN = ("format", "scenario", "events", "contacts", "summary")


@dataclass(repr=False, eq=False)
class History:
    """Samples, events and summary of one run.

    Attributes
    ----------
    data : xarray.Dataset
        Labelled samples with `units` and `long_name`; at a jump the left one stands at the time of the
        event, the right one at the next larger floating-point number.  The rates of `ux` and `uy` are not in it
        where they follow from the coordinates: ``history["uy_dot"]`` computes them, once.
    events : list of Event
        The transitions in order of time.
    summary : dict
        As in summary.json: `outcome`, `message`, `end_time` (s), `macro_gap` (s), `macro_collisions` (see
        :class:`~oblique_impact.history.summary.MacroCollision`), `slope_ends`, `events`, `energy` (see
        :class:`~oblique_impact.history.summary.Ledger`), `steps`, `rejected_steps`, `wall_time` (s, marching
        only), `versions`, `provenance`; of a beam also `clearance`, `without_limit` and `warnings`.
    scenario : Scenario or None
        The fully resolved scenario; None for a small system, which has none.
    contacts : list of Contact
        The closed contacts in order of their starts: spans, impulses, largest force and stored energy, losses.
    """

    data: xr.Dataset
    events: list[Event]
    summary: dict[str, Any]
    scenario: Scenario | None = None
    contacts: list[Contact] = field(default_factory=list)
    #: of a beam: what computes its section forces, or these
    _section_forces: Callable[[], Mapping[str, Column]] | xr.Dataset | None = None
    #: rates along the beam, once they were asked for
    _rates: xr.Dataset | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        """Put the contacts in order: of several, the one that ends first was written down first."""
        self.contacts = sorted(self.contacts, key=lambda contact: contact.start)

    def __getitem__(self, name: str) -> xr.DataArray:
        """Return one labelled array, e.g. ``history["theta"]``; raises KeyError."""
        if name in SECTION_FORCES and name not in self:
            raise KeyError(f'{name}: is computed by a call: history.section_forces()["{name}"]')
        return (self._rates_along() if name in self._computed_rates else self.data)[name]

    def __contains__(self, name: object) -> bool:
        """Whether there is a variable of this name."""
        return name in self.data.variables or name in self._computed_rates

    def __iter__(self) -> Iterator[str]:
        """Go over the names of all variables."""
        return map(str, (*self.data.variables, *self._computed_rates))

    @property
    def _computed_rates(self) -> tuple[str, ...]:
        """Names of the variables that `_rates_along` has."""
        follow = self.scenario is not None and "qdd" in self.data and "station" in self.data
        return tuple(name for name in RATES_ALONG if follow and name not in self.data)

    def _rates_along(self) -> xr.Dataset:
        """Return the rates of the displacements along a beam of few coordinates, computed once."""
        if self._rates is None:
            assert self.scenario is not None
            self._rates = dataset(rates_along(_beam_of(self.scenario), _values(self.data)))
        return self._rates

    def __getstate__(self) -> dict[str, Any]:
        """Section forces are pickled in place of what computes them, which not every beam allows."""
        if self.scenario is not None:
            self.section_forces()
        return self.__dict__

    def __repr__(self) -> str:
        """Describe the run in a few lines, and its warnings and the defaults that it took in one each."""
        return "\n".join(_describe(self))

    def _repr_html_(self) -> str:
        """Describe the run in a notebook, with the macro-collisions in a table and its warnings."""
        from pandas import DataFrame

        lines = "<br>".join(escape(line) for line in _describe(self)[:4])
        found = DataFrame(self.macro_collisions).rename(columns=_OF_COLLISIONS)
        table = found.to_html(index=False, float_format="{:.6g}".format) if self.macro_collisions else ""
        remarks = [f"note: {text}" for text in _notes(self)]
        remarks += [f"warning: {text}" for text in self.summary.get("warnings", ())]
        warned = "".join(f"<li>{escape(text)}</li>" for text in remarks)
        return f"<div>{lines}{table}{f'<ul>{warned}</ul>' if warned else ''}</div>"

    @property
    def scenario_toml(self) -> str:
        """The scenario as TOML; empty for a small system."""
        return self.scenario.to_toml() if self.scenario else ""

    @property
    def outcome(self) -> Outcome:
        """The named outcome of the run."""
        return next(outcome for outcome in Outcome if outcome.label == self.summary["outcome"])

    @property
    def end_time(self) -> float:
        """Time (s) at which the run ended."""
        return float(self.summary["end_time"])

    @property
    def steps(self) -> int:
        """Number of steps."""
        return int(self.summary["steps"])

    @property
    def balance(self) -> dict[str, float]:
        """Energy balance (J), see :class:`~oblique_impact.history.summary.Ledger`."""
        found: dict[str, float] = self.summary["energy"]
        return found

    @property
    def macro_collisions(self) -> list[dict[str, Any]]:
        """Contacts that belong together, see :class:`~oblique_impact.history.summary.MacroCollision`."""
        found: list[dict[str, Any]] = self.summary["macro_collisions"]
        return found

    @property
    def clustering_time(self) -> float:
        """Contacts less than this apart (s) are one macro-collision."""
        return float(self.summary["macro_gap"])

    @property
    def total_energy(self) -> xr.DataArray:
        """Kinetic, elastic, gravity and contact energy (J) of each sample; older files do not have the last."""
        total = self["energy_kinetic"] + self["energy_elastic"] + self["energy_gravity"]
        if "energy_contact" in self:
            total = total + self["energy_contact"]
        return total.assign_attrs(units="J", long_name="total energy").rename("total_energy")

    @property
    def event_table(self) -> pd.DataFrame:
        """The event log as a table, a row an event from 1, with the columns of events.csv (SI units)."""
        from pandas import DataFrame, RangeIndex

        numbers = RangeIndex(1, len(self.events) + 1, name="event")
        return DataFrame([event_row(event) for event in self.events], numbers, list(EVENT_COLUMNS))

    @property
    def contact_table(self) -> pd.DataFrame:
        """The closed contacts as a table, a row a contact from 1 (SI units)."""
        from pandas import DataFrame, RangeIndex

        numbers = RangeIndex(1, len(self.contacts) + 1, name="contact")
        return DataFrame(self.contacts, numbers, list(Contact._fields))

    def to_dataframe(self) -> pd.DataFrame:
        """Return the variables over time as a table, a row a sample, in SI units.

        Coordinates have the columns q_0, q_1, ..., qd_0, ..., contacts contact_gap_1, ...; variables along
        the beam are left out.
        """
        from pandas import DataFrame

        columns = {"time": self["time"].values}
        for name, variable in self.data.data_vars.items():
            if variable.dims == ("time",):
                columns[str(name)] = variable.values
            elif variable.dims == ("time", "coordinate"):
                columns |= {f"{name}_{number}": values for number, values in enumerate(variable.values.T)}
            elif variable.dims == ("time", "contact"):
                columns |= {f"{name}_{number}": values for number, values in enumerate(variable.values.T, start=1)}
        return DataFrame(columns)

    def section_forces(self) -> xr.Dataset:
        """Return bending moment, shear force, axial force and bending stress along the beam, (time, station).

        The first call computes them, in about 0.1 s for 10,000 samples.
        Raises InputError for a system that is no beam.
        """
        if self._section_forces is None:
            raise InputError("section_forces: this is the history of a system that is no beam")
        if not isinstance(self._section_forces, xr.Dataset):
            self._section_forces = dataset(self._section_forces())
        return self._section_forces

    def events_csv(self) -> str:
        """Return the event log as CSV text."""
        return events_csv(self.events)

    def at(self, time: float, side: Side = "right") -> xr.Dataset:
        """Return all variables at a time (s), interpolated between samples by cubics.

        At an event that makes velocities jump, `side` chooses what is just before or just after it.  Raises
        InputError for a time outside of the run.
        """
        return dataset_at(self.data.assign({name: self[name] for name in self._computed_rates}), time, side)

    def beam_at(self, time: float, side: Side = "right") -> NDArray[np.float64]:
        """Return the points (stations, 2) in m of the deformed axis in the inertial frame at a time (s).

        Raises InputError for a system that is no beam, or a time outside of the run.
        """
        if self.scenario is None:
            raise InputError("beam_at: this is the history of a system that is no beam")
        z = BentBeam.of_history(self.scenario, self.at(time, side)).point()
        return np.stack([z.real, z.imag], axis=1)

    def plot(self) -> Figure:
        """Draw the overview of a beam's run: motion, shapes, contact force, gap, energies, losses, envelopes.

        Raises InputError for a system that is no beam.
        """
        from oblique_impact.renders.overview import overview
        from oblique_impact.renders.story import story_of

        return overview(story_of([self]))

    def to_pyvista(self, time: float, deformation: float = 1.0) -> PolyData:
        """Return the surface of the beam at a time (s) as a mesh with all results, in SI units.

        `deformation` magnifies the bending, not the results.  Raises InputError for a system that is no beam, or a
        time outside of the run.
        """
        from oblique_impact.renders.exports import beam_mesh

        return beam_mesh(self, time, deformation)

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Write scenario.toml, history.nc, events.csv and summary.json into `folder`, all of them or none.

        Raises InputError if the folder cannot be written, or another process is writing there.
        """
        with writing(folder):
            save_all(Path(folder), self.files())
        return Path(folder)

    def files(self) -> dict[str, bytes]:
        """Return the contents of the four files by their names, in the order in which they are replaced.

        history.nc, which holds everything, is the first one and summary.json the last, so that a folder in which
        only some were replaced is known by the two.
        """
        whole = self.data if self.scenario is None else self.data.assign(self.section_forces())
        if "qdd" in whole:
            whole = whole.drop_vars(COMPUTED, errors="ignore")
        scenario = self.scenario_toml
        whole = whole.assign_attrs(
            format=FORMAT,
            scenario=scenario,
            events=json.dumps([event_row(event) for event in self.events]),
            contacts=json.dumps(self.contacts),
            summary=json.dumps(self.summary),
        )
        netcdf = netcdf_bytes(whole)
        return {
            "history.nc": netcdf + digest_line(netcdf),
            "scenario.toml": scenario.encode(),
            "events.csv": self.events_csv().encode(),
            "summary.json": _summary_json(self.summary).encode(),
        }

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> History:
        """Read a run folder, or the history.nc inside one.

        Raises InputError with one line if it is not a history of this format, or is damaged.  Warns, with
        :class:`~oblique_impact.errors.FileWarning`, of a file that another program has written, in which damage
        cannot be seen, and of a folder whose summary.json is that of another run.
        """
        folder, file = None, Path(path)
        if file.is_dir():
            lacking = [name for name in FILES if not (file / name).exists()]
            folder, file = file, file / "history.nc"
            if not file.is_file():
                raise InputError(f"{path}: is not the folder of a run: it lacks {', '.join(lacking)}")
        elif not file.is_file():
            run = f"; run the scenario first: oblique-impact run {path} --out DIR, and give DIR"
            raise InputError(f"{path}: no such history{run if str(path) in builtin_names() else ''}")
        try:
            if not (whole := has_digest(file)):
                with h5py.File(file) as opened:  # h5netcdf prints a traceback for a damaged object; h5py raises
                    opened.visititems(lambda name, item: None)
            # without phony_dims a variable that has lost its dimensions prints a warning; it is refused below
            data = read_netcdf(file) if whole else xr.load_dataset(file, engine="h5netcdf", phony_dims="sort")
            found = cls._of_one_dataset(data)
        except Exception as error:  # xarray, h5netcdf and h5py raise errors of many kinds for damaged files
            reason = " ".join(str(error).split())[:200] or type(error).__name__
            raise InputError(f"{file}: not a readable history of oblique-impact: {reason}") from None
        if not whole:
            words = "has no digest, as another program or an earlier version wrote it: damage cannot be seen"
            warn(f"{file}: {words}", FileWarning, stacklevel=2)
        if folder and not _is_summary(folder / "summary.json", found.summary):
            words = "is not of the run in history.nc, nor may the other files be; History.save writes all anew"
            warn(f"{folder / 'summary.json'}: {words}", FileWarning, stacklevel=2)
        return found

    @classmethod
    def _of_one_dataset(cls, data: xr.Dataset) -> History:
        """Return the history of a file's dataset; raises errors of many kinds for parts missing or damaged."""
        if data.attrs.get("format") == FORMAT_WITHOUT_CONTACTS:
            data = with_contacts(data)
        elif data.attrs.get("format") not in (FORMAT, FORMAT_OF_WHOLE_FILES):
            raise InputError(f"its format is not that of this version ({FORMAT})")
        computed = COMPUTED if any(name in data for name in OF_FEW_COORDINATES) else ()
        beam = OF_A_BEAM | RATES_ALONG | SECTION_FORCES if data.attrs["scenario"] else {}
        slope = OF_A_SLOPE if any(name in data for name in OF_A_SLOPE) else {}
        free = OF_A_FREE_BEAM if any(name in data for name in OF_A_FREE_BEAM) else {}
        for name in chain(OF_A_SYSTEM, beam, slope, free):
            if name not in data.variables and name not in (*ADDED_LATER, *computed):
                raise InputError(f"it has no variable {name!r}")
        for key, variable in data.variables.items():
            known, name = VARIABLES.get(str(key)), str(key)
            if not known:
                continue
            kinds = "i" if name == "state" else "fi"
            if variable.dims != known.dimensions or variable.dtype.kind not in kinds:
                raise InputError(f"its variable {name!r} is not numbers over {', '.join(known.dimensions)}")
            if np.any(np.abs(variable.values) > _LARGEST):  # NaN stands where a force is not known
                raise InputError(f"its variable {name!r} has values beyond {_LARGEST:g}")
        for name, what in (("time", "times"), ("station", "stations")):
            places = data[name].values if name in data else np.zeros(1)
            if not places.size or not np.all(np.isfinite(places)) or not np.all(np.diff(places) > 0.0):
                raise InputError(f"its {what} are not finite numbers that ascend")
        for name in ("state", "contact_state"):
            if name in data and not np.isin(data[name].values, list(State)).all():
                raise InputError(f"its variable {name!r} has values that are none")
        attributes = data.attrs
        scenario = Scenario.from_toml(attributes["scenario"]) if attributes["scenario"] else None
        if scenario and scenario.root.is_free and not free:
            raise InputError("it lacks the origin of the frame of a beam that nothing holds")
        if scenario and not np.allclose(data["station"][[0, -1]], [0.0, scenario.beam.length], rtol=1e-9):
            raise InputError("its stations do not go from 0 to the length of its beam")
        summary = json.loads(attributes["summary"])
        require_summary(summary)
        data, others = data.drop_attrs(deep=False), {k: v for k, v in attributes.items() if k not in _OWN}
        if computed and scenario:
            forces: partial[dict[str, Column]] | xr.Dataset | None = partial(_with_computed_forces, scenario, data)
        else:
            forces = data[list(SECTION_FORCES)] if scenario else None
        return cls(
            data.drop_vars(SECTION_FORCES, errors="ignore").assign_attrs(others),
            [event_of(row) for row in json.loads(attributes["events"])],
            summary,
            scenario,
            [Contact(*numbers_of(row)) for row in json.loads(attributes["contacts"])],  # type: ignore[arg-type]
            forces,
        )


def beam_history(
    scenario: Scenario,
    record: Record,
    samples: Samples,
    variables: Mapping[str, Column],
    section_forces: Callable[[], Mapping[str, Column]],
    wall: float,
    beam: Beam | None = None,
) -> History:
    """Return the history of a beam's run: the summary has clearance and warnings too.

    `section_forces` computes these; `wall` is the wall time of the marching (s); `beam` is the model of small
    deflections, None of the exact beam.
    """
    summary = summarize(record, samples, wall, clustering_time(scenario))
    summary["clearance"] = closest(variables, scenario.beam.length)
    forces = cache(section_forces)
    warnings, without_limit = run_warnings(
        scenario, record.contacts, record.ambiguous, variables, summary, forces, beam
    )
    summary |= {"without_limit": without_limit, "warnings": warnings}
    return History(dataset(variables), record.events, summary, scenario, record.contacts, forces)


def _values(data: xr.Dataset) -> dict[str, Column]:
    return {str(name): variable.values for name, variable in data.variables.items()}


def _beam_of(scenario: Scenario) -> Beam:
    """Return the beam of a scenario without user-defined parts."""
    from oblique_impact.beam_problem import beam_of  # which loads all schemes

    return beam_of(scenario)


def _with_computed_forces(scenario: Scenario, data: xr.Dataset) -> dict[str, Column]:
    """Return the section forces of a file's dataset: those that it has, the others from its accelerations."""
    known = _values(data)
    found = section_forces(_beam_of(scenario), known["qdd"], known)
    return found | {name: known[name] for name in SECTION_FORCES if name in known}


def _summary_json(summary: Mapping[str, Any]) -> str:
    return json.dumps(summary, indent=2) + "\n"


def _is_summary(file: Path, summary: Mapping[str, Any]) -> bool:
    """Whether a file, if there is one, is that of a summary."""
    try:
        return file.read_text(encoding="utf-8") == _summary_json(summary)
    except FileNotFoundError:
        return True
    except (OSError, ValueError):
        return False


def _describe(history: History) -> list[str]:
    """Describe a history, its warnings, and its macro-collisions up to the third, a line each."""
    s, sizes = history.summary, history.data.sizes
    kind = "a beam" if history.scenario else "a system"
    parts = ", ".join(counted(count, str(name)) for name, count in sizes.items() if name != "time")
    energy = s["energy"]
    lost = [f"{k.removeprefix('lost_')} {v:.4g}" for k, v in energy.items() if k.startswith("lost_") and v]
    lines = [
        f"<History of {kind}: {s['outcome']} at {s['end_time']:.6g} s, {counted(s['steps'], 'step')}>",
        f"  samples     {sizes['time']} ({parts}); {len(history.data.variables)} variables",
        f"  events      {len(history.events)}, {counted(len(history.contacts), 'contact')}",
        f"  energy      {balance_text(energy)}, unaccounted {energy['unaccounted']:.1e}",
    ]
    if lost:
        lines.append(f"  lost (J)    {', '.join(lost)}")
    shown = history.macro_collisions[:3]
    for number, m in enumerate(shown, 1):
        contacts, impulse = counted(m["contacts"], "contact"), f"{m['normal_impulse']:.6g} N s"
        lines.append(f"  collision {number} {m['start']:.6f} to {m['end']:.6f} s, {contacts}, {impulse}")
    if len(history.macro_collisions) > len(shown):
        lines.append(f"  and {len(history.macro_collisions) - len(shown)} more")
    lines += [f"  note        {text}" for text in _notes(history)]
    return lines + [f"  warning     {text}" for text in s.get("warnings", ())]


def _notes(history: History) -> list[str]:
    """Return lines about defaults that numbers of the run depend on."""
    return history.scenario.taken_defaults if history.scenario else []


def require_history(value: object, where: str) -> None:
    """Raise InputError, in one line that begins with `where`, if a value is not a History."""
    if not isinstance(value, History):
        makers = "simulate(SCENARIO) and History.load(PATH) return one"
        raise InputError(f"{where}: history = {short(value)}: should be a History; {makers}")

"""Time series of the deformed beam for ParaView, PyVista and meshio, tables, and the mesh at a time."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from io import FileIO
from pathlib import Path
from typing import Any, Literal, cast
from xml.etree import ElementTree

import h5py
import meshio
import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkCommonCore import vtkStringArray
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

from oblique_impact.errors import InputError
from oblique_impact.files import cannot_write, suffix_of, writing_file
from oblique_impact.history.history import History, require_history
from oblique_impact.history.sample_times import sides
from oblique_impact.progress import OnProgress, Progress, silent
from oblique_impact.renders.geometry import QUANTITIES, BeamGeometry
from oblique_impact.renders.outlines import few_sides
from oblique_impact.renders.picture_files import made_by, warnings_of
from oblique_impact.renders.scenery import block, pin
from oblique_impact.renders.story import Story, story_of
from oblique_impact.renders.style import Style
from oblique_impact.renders.timeline import TimeMap, time_map
from oblique_impact.scenario.messages import one_of

Integers = NDArray[np.int64]
Format = Literal["pvd", "xdmf", "csv"]
# fields (time, side of a jump, number of the sample) and meshes of a frame, by the names of parts
Frame = tuple[dict[str, Any], dict[str, pv.PolyData]]

FRAMES = 500  # of an export that asks for nothing else, besides those at events; its film has 600
#: formats, and what reads them
READERS = {
    "pvd": "ParaView, PyVista",
    "xdmf": "ParaView, PyVista, meshio",
    "csv": "pandas, spreadsheets",
}
#: units or meanings of the results on the parts, and of the field data of a frame
UNITS = {
    "points": "m",
    **QUANTITIES,
    "displacement": "m, from the initial shape",
    "contact_force": "N, on the beam: normal_force + friction_force",
    "applied_force": "N, on the beam: of [[forces]]",
    "mass": "kg, of a point mass",
    "inertia": "kg m^2, of a point mass about its centre",
    "obstacle": "of a contact: the slope is 0, the others count from 1",
    "normal_force": "N",
    "friction_force": "N",
    "gap": "m",
    "depth": "m, compression of the stop itself",
    "gap_rate": "m/s",
    "slip_rate": "m/s",
    "state": "0 free, 1 slip, 2 stick",
    "time": "s",
    "side": "-1 left of a jump, 1 right of it, 0 none",
    "sample": "number in the history",
}
_TIMES = (
    "The field 'time' is that of the history exactly. At a jump there are two frames: the left one has its time, "
    "the right one the next larger double (one ulp). The field 'side' tells them apart. The frames of XDMF carry "
    "these times, but that before 4 s the right side of a jump stands 8.9e-16 s after the left one."
)
_APART = 4.0 * float(np.finfo(float).eps)  # s: between two frames of XDMF, at least
_FIXED = ("reference", "pin", "slope")  # parts that are the same in all frames


@dataclass(frozen=True)
class Exported:
    """A time series on disk."""

    file: Path  # what a reader opens
    format: Format
    samples: int  # that became frames,
    of: int  # of so many
    span: tuple[float, float]  # first and last time (s)
    factor: float  # by which the bending is magnified; 1 for true shapes


def export(
    history: History,
    out: str | os.PathLike[str],
    *,
    format: Format | None = None,
    every: int | None = None,
    between: tuple[float, float] | None = None,
    deformation: float = 1.0,
    on_progress: OnProgress = silent,
) -> Exported:
    """Write a history as a time series for ParaView: surface, axis, contact point, slope and pin with all results.

    Or, as CSV, the variables over time as a table: a row per sample, units in the first line.

    Parameters
    ----------
    history : History
        Of a beam.
    out : path
        The file; the suffix of the format is appended if it has none.  Files appear whole or not at all.
    format : {"pvd", "xdmf", "csv"}, optional
        Default: as the suffix of `out` says.
    every : int, optional
        Every n-th sample, 1 for all; default: about 500, half of them in contacts as in films, of CSV all.  Those
        at events and jumps are all kept.
    between : tuple of float, optional
        First and last time (s).
    deformation : float
        Factor by which the bending is magnified.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.progress.Progress` before the first and after each frame.

    Returns
    -------
    Exported
        The file and what it holds.

    Raises
    ------
    InputError
        In one line, for everything that is wrong with the options, the history or the place.

    Examples
    --------
    >>> from oblique_impact import Scenario, simulate
    >>> from oblique_impact.renders import export
    >>> history = simulate(Scenario.builtin("paper"))
    >>> export(history, "beam", format="pvd", every=10, between=(0.3, 0.34)).file  # doctest: +SKIP
    """
    require_history(history, "export")
    target, format = _target(Path(out), format)
    story = story_of([history], Style(deformation=deformation))
    samples = chosen_samples(history, 1 if format == "csv" and every is None else every, between, story.time_map)
    frames = _frames(story, samples, on_progress)
    try:
        with writing_file(target), tempfile.TemporaryDirectory(prefix=".export.", dir=target.parent) as name:
            new = Path(name) / target.name
            with np.errstate(over="ignore", invalid="ignore"):  # runs that blew up hold numbers of any size
                if format == "pvd":
                    made = _write_pvd(story, frames, new)
                elif format == "xdmf":
                    made = _write_xdmf(story, frames, new)
                else:
                    made = _write_csv(history, samples, new)
            for path in made:  # what is opened last: so it never lists what is not there
                place = target.parent / path.name
                if place.is_dir():
                    shutil.rmtree(place)
                os.replace(path, place)
    except OSError as error:
        raise cannot_write(target, error) from None
    times = history["time"].values
    first, last = times[samples[[0, -1]]].tolist()
    return Exported(target, format, samples.size, times.size, (first, last), story.factor)


def _target(out: Path, format: str | None) -> tuple[Path, Format]:
    """Return the file to write and its format.

    Raises InputError if the format is unknown or contradicts the suffix, or if something is in the way.
    """
    suffix = suffix_of(out)
    format = format or suffix.removeprefix(".")
    if format not in READERS:
        raise InputError(f"--format {format or 'missing'}: {one_of(format, READERS)}")
    if suffix and suffix != f".{format}":
        raise InputError(f"--out {out}: should end in .{format} for --format {format}, or have no suffix")
    target = out if suffix else Path(f"{out}.{format}")
    # what an earlier export made is replaced, other things are not
    beside = {"pvd": target.with_suffix(""), "xdmf": target.with_suffix(".h5"), "csv": target}[format]
    try:
        others = beside.is_dir() and any(path.suffix != ".vtp" for path in beside.iterdir())
        if (target.exists() or beside.exists()) and (others or not target.is_file()):
            raise InputError(f"--out {target}: {beside} is in the way and not of an export: choose another name")
    except OSError as error:  # a name that is too long
        raise cannot_write(target, error) from None
    return target, cast(Format, format)


# Samples ------------------------------------------------------------------------------------------------------


def chosen_samples(
    history: History,
    every: int | None = None,
    between: tuple[float, float] | None = None,
    course: TimeMap | None = None,
) -> Integers:
    """Return the numbers of the samples that become frames, ascending, of its film's `course`; see `export`.

    Samples whose shape is not finite (the last ones of a run that diverged) are left out.  Raises InputError if no
    sample is left.
    """
    first, last = between or (-np.inf, np.inf)
    if every is not None and every < 1:
        raise InputError(f"--every {every}: should be at least 1")
    if not first < last:
        raise InputError(f"--between {first:g},{last:g}: should be two times in s, the first one earlier")
    time = np.asarray(history["time"].values, dtype=float)
    side = sides(time)
    # both sides of a jump are of one instant: a span that ends at an event keeps both
    instant = np.where(side > 0, np.roll(time, 1), time)
    wanted = (instant >= first) & (instant <= last)
    for name in ("theta", "ux", "uy"):
        wanted &= np.isfinite(history[name].values.reshape(time.size, -1)).all(axis=1)
    left = np.flatnonzero(wanted)
    if not left.size:
        raise InputError(f"history: no sample is left; it covers {time[0]:g} to {time[-1]:g} s")
    chosen = np.isin(time, [event.time for event in history.events]) | (side != 0)
    chosen[-1] = True
    if every is not None:
        chosen[::every] = True
    elif left.size <= FRAMES:
        chosen[left] = True
    else:
        film = (course or time_map(history)).film_at(time[left])
        chosen[left[np.searchsorted(film, np.linspace(film[0], film[-1], FRAMES))]] = True
    return np.flatnonzero(wanted & chosen)


# Meshes -------------------------------------------------------------------------------------------------------


def beam_mesh(history: History, time: float, deformation: float = 1.0) -> pv.PolyData:
    """Return the surface of the beam at a time (s), at a jump just after it, with its results as point arrays.

    Parameters
    ----------
    history : History
        Of a beam.
    time : float
        Physical time (s) within the run.
    deformation : float
        Factor by which the bending is magnified; 1 for the true shape.  The results are never magnified.

    Returns
    -------
    pyvista.PolyData
        Points in m; point arrays as in `renders.geometry.QUANTITIES`, in SI units; field data `time` (s),
        `units` and `made_by`.

    Raises
    ------
    InputError
        For a system that is no beam, a time outside of the run, or a factor that is not positive.
    """
    require_history(history, "to_pyvista")
    geometry = BeamGeometry(history, deformation)
    history.at(time)  # which refuses times outside of the run
    mesh = _surface(geometry, geometry.index(time))
    mesh.set_active_scalars("bending_stress")
    mesh.field_data["time"] = np.array([time])
    mesh.field_data["units"] = ["points = m", *(f"{name} = {unit}" for name, unit in QUANTITIES.items())]
    mesh.field_data["made_by"] = [made_by([history])]
    return mesh


def _surface(geometry: BeamGeometry, k: float) -> pv.PolyData:
    """Return the surface of the beam at sample k with the results `renders.geometry.QUANTITIES`."""
    mesh = pv.PolyData(geometry.tube(k)[0], geometry.solid.faces)
    mesh.point_data.update({name: geometry.result(name, k) for name in QUANTITIES})
    return mesh


def _frames(story: Story, samples: Integers, on_progress: OnProgress) -> Iterator[Frame]:
    """Yield the frames: the beam three times, its pin if it has one, and with contact its point and the slope.

    The beam is there as a swept tube, as its axis, a polyline, and in its initial shape, without results.  The
    tube carries `displacement`, by which Warp By Vector magnifies its way from there.  A deformation factor
    magnifies points; results, displacements among them, are never magnified.  All cells carry the number of their
    part.
    """
    history = story.histories[0]
    shape = history.scenario.beam.section.shape if history.scenario else ""
    geometry = BeamGeometry(history, story.factor, sides=few_sides(shape))
    start = geometry.true.tube(0)[0]
    initial = pv.PolyData(start, faces=geometry.solid.faces)
    # in triangles, as XDMF has no polygon of many corners, and without arrays
    blocks = [block(geometry, obstacle) for obstacle in story.obstacles]
    whole = [pv.merge(blocks).extract_surface(algorithm="dataset_surface")] if blocks else []
    foot = pin(geometry)
    fixed = [
        pv.PolyData(solid.points, faces=solid.faces)
        for solid in (one.triangulate() for one in [*([foot] if foot else []), *whole])
    ]
    times, side = geometry.times, sides(geometry.times)
    for done, k in enumerate(samples):
        on_progress(Progress(done, samples.size))
        surface = _surface(geometry, k)
        line = pv.PolyData(geometry.centreline(k), lines=[geometry.stations.size, *range(geometry.stations.size)])
        results = [name for name in QUANTITIES if not name.endswith("_stress")]
        line.point_data.update({name: geometry.along(name, k) for name in results})
        surface.point_data["displacement"] = geometry.true.tube(k)[0] - start
        parts = {"surface": surface, "centreline": line, "reference": initial}
        if foot:
            parts["pin"] = fixed[0]
        if story.obstacles:  # last, so that the numbers of the others are always the same
            parts |= {"contact_point": _contact_points(geometry, k), "slope": fixed[-1]}
        if geometry.sections.masses:
            parts["masses"] = _masses(geometry, k)
        if geometry.scenario.acting_forces:
            parts["forces"] = _forces(geometry, k)
        for number, mesh in enumerate(parts.values()):
            behind = number > 2 and not foot  # the number of the pin is its own where there is none
            mesh.cell_data["part"] = np.full(mesh.n_cells, number + behind)
        yield {"time": float(times[k]), "side": int(side[k]), "sample": int(k)}, parts
    on_progress(Progress(samples.size, samples.size))


def _masses(geometry: BeamGeometry, k: int) -> pv.PolyData:
    """Return the point masses at a sample as vertices with their masses and inertias."""
    points = geometry.sections.masses
    mesh = pv.PolyData(geometry.on_axis([point.place for point in points], k))
    mesh.point_data["mass"] = np.array([point.mass for point in points])
    mesh.point_data["inertia"] = np.array([point.inertia for point in points])
    return mesh


def _forces(geometry: BeamGeometry, k: int) -> pv.PolyData:
    """Return the forces on the beam at a sample as vertices."""
    places, values = geometry.applied_forces(k)
    mesh = pv.PolyData(places)
    mesh.point_data["applied_force"] = np.insert(values, 2, 0.0, axis=1)
    return mesh


def _contact_points(geometry: BeamGeometry, k: int) -> pv.PolyData:
    """Return the contacts at a sample as vertices with the forces on the beam there."""
    places = np.stack([geometry.value("contact_x", k), geometry.value("contact_y", k)], axis=1)
    vectors = {"contact_force": geometry.pushes(k)}
    scalars = {name: geometry.value(f"contact_{name}", k) for name in ("gap", "slip_rate", "state")}
    scalars["obstacle"] = geometry.values("contact_obstacle")
    if geometry.at_point:  # what only the contact point has
        normal, friction = geometry.contact_forces(k)
        velocity = geometry.value("tip_vx", k), geometry.value("tip_vy", k)
        of_point = {"velocity": velocity, "normal_force": normal, "friction_force": friction}
        vectors |= {name: np.array([values]) for name, values in of_point.items()}
        scalars |= {name: np.atleast_1d(geometry.value(name, k)) for name in ("depth", "gap_rate")}
    mesh = pv.PolyData(np.insert(places, 2, 0.0, axis=1))
    for name, values in (vectors | scalars).items():
        mesh.point_data[name] = np.insert(values, 2, 0.0, axis=1) if name in vectors else values
    return mesh


# Files --------------------------------------------------------------------------------------------------------


def _run_fields(story: Story, parts: Iterable[str]) -> dict[str, str | float]:
    """Return field data that hold for all frames: what made the run, its scenario, events, units and parts."""
    history = story.histories[0]
    return {
        "made_by": made_by([history]),
        "warnings": "\n".join(warnings_of([history])),
        "scenario": history.scenario_toml,
        "events": history.events_csv(),
        "units": "\n".join(f"{name} = {unit}" for name, unit in UNITS.items()),
        "parts": "\n".join(f"{number} = {part}" for number, part in enumerate(parts)),
        "times": _TIMES,
        "deformation_factor": story.factor,
    }


def _write_pvd(story: Story, frames: Iterable[Frame], file: Path) -> list[Path]:
    """Write ParaView's list of files, and the folder of the same name with a .vtp file per part and frame.

    What stands still is written once, with the field data that hold for all frames.
    """
    folder = file.with_suffix("")
    folder.mkdir()
    collection = ElementTree.Element("VTKFile", type="Collection", version="1.0")
    entries = ElementTree.SubElement(collection, "Collection")
    for number, (fields, parts) in enumerate(frames):
        for part, (name, mesh) in enumerate(parts.items()):
            fixed = name in _FIXED
            piece = folder / f"{name}_{0 if fixed else number:06d}.vtp"
            if number == 0 or not fixed:
                _add_fields(mesh, _run_fields(story, parts) if fixed else fields)
                piece.write_bytes(_vtp(mesh))
            entry = {"timestep": repr(fields["time"]), "part": str(part), "name": name}
            ElementTree.SubElement(entries, "DataSet", entry, file=f"{folder.name}/{piece.name}")
    ElementTree.ElementTree(collection).write(file, encoding="utf-8", xml_declaration=True)
    return [folder, file]


def _vtp(mesh: pv.PolyData) -> bytes:
    """Return a mesh as the content of a .vtp file: VTK's writer crashes on a disk that is full."""
    writer = vtkXMLPolyDataWriter()
    writer.SetInputData(mesh)
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()  # bytes as they are, three quarters of their text
    writer.SetCompressorTypeToZLib()
    writer.SetWriteToOutputString(True)
    writer.Write()
    content = writer.GetOutputString()  # bytes, but where they happen to be text
    return content.encode() if isinstance(content, str) else bytes(content)


def _add_fields(mesh: pv.PolyData, fields: Mapping[str, str | float]) -> None:
    for name, value in fields.items():
        if isinstance(value, str):
            array = vtkStringArray()  # PyVista's own take ASCII alone
            array.SetName(name)
            array.InsertNextValue(value)
            mesh.GetFieldData().AddArray(array)
        else:
            mesh.field_data[name] = [value]


_POSITION = {"Name": "position", "AttributeType": "Vector", "Center": "Node"}  # of points, as meshio writes it


class _Numbers(FileIO):
    """A file for HDF5 that keeps its first `error` for `check`: HDF5 itself crashes on a disk that is full."""

    error: OSError | None = None

    def write(self, data: Any) -> int:
        """Write all of some data, or nothing after an error; returns their size."""
        left = memoryview(data).cast("B")
        size = left.nbytes
        try:
            while left and not self.error:
                left = left[super().write(left) :]
        except OSError as error:
            self.error = error
        return size

    def truncate(self, size: int | None = None) -> int:
        """Change the size; returns it."""
        try:
            return super().truncate(size)
        except OSError as error:
            self.error = self.error or error
            return size or 0

    def check(self) -> None:
        """Raise OSError if something could not be written."""
        if self.error:
            raise self.error


class _Writer(meshio.xdmf.TimeSeriesWriter):  # type: ignore[misc]
    """meshio's writer, with compressed numbers, a third of the size; raises OSError where it cannot write."""

    def __enter__(self) -> _Writer:
        self.h5_filename = self.filename.with_suffix(".h5").name
        self._numbers = _Numbers(self.filename.with_suffix(".h5"), "w+")
        # the format of HDF5 1.10, in which each compressed array does without a tree of its chunks, 2 kB
        self.h5_file = h5py.File(self._numbers, "w", libver=("v110", "v110"))
        return self

    def __exit__(self, *raised: object) -> None:
        with self._numbers:
            self.h5_file.close()
        self._numbers.check()
        if not any(raised):
            tree = ElementTree.ElementTree(self.xdmf_file)
            tree.write(self.filename, encoding="utf-8", xml_declaration=True)

    def numpy_to_xml_string(self, data: NDArray[Any]) -> str:
        """Store numbers in the .h5 file and return where they are."""
        name = f"data{self.data_counter}"
        self.data_counter += 1
        packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True, "chunks": data.shape}
        self.h5_file.create_dataset(name, data=data, **(packed if data.size > 100 else {}))
        self._numbers.check()
        return f"{self.h5_filename}:/{name}"


def _write_xdmf(story: Story, frames: Iterable[Frame], file: Path) -> list[Path]:
    """Write a file and numbers beside it, .h5, through meshio, a collection of grids per part.

    meshio's `TimeSeriesReader` takes the last collection of a file and knows no points that move: so the surface
    comes last, and its points are there once more as the point array `position`.
    """
    with _Writer(file) as writer:
        writer.domain.remove(writer.collection)
        collections: dict[str, Any] = {}
        stamp = -np.inf
        for number, (fields, parts) in enumerate(frames):
            # VTK's reader takes as one what is within a time ± 2.2e-16 s, rounded: before 4 s the next double
            stamp = max(fields["time"], stamp + _APART)
            if not collections:
                _add_information(writer.domain, _run_fields(story, parts))
                kept = dict[str, list[Any]]()  # elements of what stands still
                kind = {"GridType": "Collection", "CollectionType": "Temporal"}
                for name in reversed(parts):
                    collections[name] = ElementTree.SubElement(writer.domain, "Grid", kind, Name=name)
                cells = {name: _cells(writer, mesh) for name, mesh in parts.items()}
            for name, mesh in parts.items():
                attributes = {"Name": f"{name}_{number:06d}", "GridType": "Uniform"}
                grid = ElementTree.SubElement(collections[name], "Grid", attributes)
                ElementTree.SubElement(grid, "Time", Value=repr(stamp))
                _add_information(grid, fields)
                grid.extend(cells[name])
                if name in kept:
                    grid.extend(kept[name])
                    continue
                shape = ElementTree.Element("Grid")
                points = np.asarray(mesh.points)
                writer.points(shape, points)
                if name in _FIXED:
                    kept[name] = list(shape)
                if name == "surface":
                    position = ElementTree.SubElement(shape, "Attribute", _POSITION)
                    position.extend(shape[0])  # the same numbers
                writer.point_data(dict(mesh.point_data), shape)
                grid.extend(shape)
    return [file.with_suffix(".h5"), file]


def _cells(writer: Any, mesh: pv.PolyData) -> list[Any]:
    """Return the elements of a part's cells, which all of its frames share, and of their cell array `part`."""
    element = ElementTree.Element("Grid")
    if mesh.n_lines:  # meshio has no polyline
        corners = mesh.lines[1:]
        blocks = [meshio.CellBlock("line", np.stack([corners[:-1], corners[1:]], axis=1))]
    else:
        blocks = pv.to_meshio(mesh).cells
    writer.cells(blocks, element)
    if len(blocks) == 1:
        element[0].set("NodesPerElement", str(blocks[0].data.shape[1]))  # VTK wants it of lines and vertices
    number = mesh.cell_data["part"][0]
    writer.cell_data({"part": [np.full(len(block), number) for block in blocks]}, element)
    return list(element)


def _add_information(parent: Any, fields: Mapping[str, str | float]) -> None:
    for key, value in fields.items():
        ElementTree.SubElement(parent, "Information", Name=key, Value=str(value))


def _write_csv(history: History, samples: Integers, file: Path) -> list[Path]:
    """Write the variables over time as a table: a row per sample, units in the first line."""

    def with_unit(column: str) -> str:
        variable = column if column in history else column.rpartition("_")[0]  # q_0, q_1 ... of q
        return f"{column} ({history[variable].attrs.get('units', '1')})"

    history.to_dataframe().iloc[samples].rename(columns=with_unit).to_csv(file, index=False)
    return [file]

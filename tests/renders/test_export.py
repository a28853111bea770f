"""Exported time series: what the readers of others find, against the history."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import meshio
import numpy as np
import pandas as pd
import pytest
import pyvista as pv
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonExecutionModel import vtkCompositeDataPipeline
from vtkmodules.vtkIOXdmf2 import vtkXdmfReader

from oblique_impact.history.provenance import provenance, provenance_line
from oblique_impact.history.sample_times import ascending
from oblique_impact.renders import export
from oblique_impact.renders.exports import FRAMES, chosen_samples
from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.outlines import few_sides

FORMATS = ("pvd", "xdmf")
PARTS = {"surface", "centreline", "reference", "pin", "contact_point", "slope"}
PAPER = ("paper", "end_time=0.34")
HUB = (*PAPER, "root.kind=hub", "root.inertia=0.1", "root.hub_radius=0.1")
RESULTS = ("moment", "shear", "axial_force")
#: what a unit must be, from the equations
UNITS = {
    "m": ["points", "elastic_displacement", "displacement", "gap", "depth"],
    "m/s": ["velocity", "gap_rate", "slip_rate"],
    "rad": ["section_rotation"],
    "N m": ["moment"],
    "N": ["shear", "axial_force", "contact_force", "normal_force", "friction_force", "applied_force"],
    "kg": ["mass"],
    "kg m^2": ["inertia"],
    "Pa": ["bending_stress", "axial_stress"],
    "s": ["time"],
}


class Frame(NamedTuple):
    """Time (s), points and point arrays by parts, field data."""

    stamp: float
    parts: dict[str, dict[str, np.ndarray]]
    fields: dict[str, Any]


def read(path: Path) -> list[Frame]:
    return {".pvd": read_pvd, ".xdmf": read_xdmf}[path.suffix](path)


def read_pvd(path: Path) -> list[Frame]:
    """Through PyVista."""
    reader, frames = pv.PVDReader(str(path)), []
    for stamp in reader.time_values:
        reader.set_active_time_value(stamp)
        frame = Frame(stamp, {}, {})
        for entry, mesh in zip(reader.active_datasets, reader.read(), strict=True):
            name, data = Path(entry.path).name.rsplit("_", 1)[0], mesh.GetFieldData()
            frame.parts[name] = {"points": np.array(mesh.points)} | {n: np.array(mesh[n]) for n in mesh.point_data}
            for array in (data.GetAbstractArray(k) for k in range(data.GetNumberOfArrays())):
                text = array.IsA("vtkStringArray")
                frame.fields[array.GetName()] = array.GetValue(0) if text else vtk_to_numpy(array)[0].item()
        frames.append(frame)
    return frames


def read_xdmf(path: Path) -> list[Frame]:
    """Through meshio; of the collections of a file its reader takes the last, the others are chosen by hand."""
    domain, frames = ElementTree.parse(path).getroot()[0], {}
    fields = {entry.get("Name"): entry.get("Value") for entry in domain.findall("Information")}
    for name in (collection.get("Name") for collection in domain.findall("Grid")):
        with meshio.xdmf.TimeSeriesReader(path) as reader:
            reader.collection = list(reader.domain.find(f"Grid[@Name='{name}']"))
            for k, grid in enumerate(reader.collection):
                reader.mesh_grid = grid
                points, _ = reader.read_points_cells()
                stamp, arrays, _ = reader.read_data(k)
                frame = frames.setdefault(stamp, Frame(stamp, {}, dict(fields)))
                frame.parts[name] = {"points": points} | arrays
                frame.fields.update({e.get("Name"): float(e.get("Value")) for e in grid.findall("Information")})
    return list(frames.values())


#: a history with samples on both sides of its events
TAPERED = ("tapered", "end_time=0.32", "solver.scheme=generalized-alpha", "contact.normal=spring")


@pytest.fixture(scope="module", params=[(PAPER, "pvd"), (HUB, "xdmf"), (TAPERED, "pvd")])
def exported(run, request, tmp_path_factory):
    """A history, and what the readers find of its export."""
    case, format = request.param
    history = run(*case)
    done = export(history, tmp_path_factory.mktemp("export") / "beam", format=format, every=250)
    frames = read(done.file)
    assert len(frames) == done.samples
    return history, frames


def test_times_are_those_of_samples_unique_and_ascending(exported):
    history, frames = exported
    stamps = np.array([frame.stamp for frame in frames])
    times = np.array([frame.fields["time"] for frame in frames])
    assert np.all(np.diff(stamps) > 0.0)
    np.testing.assert_allclose(stamps, times, rtol=0.0, atol=1e-15)
    assert times.tolist() == [history["time"].values[int(frame.fields["sample"])] for frame in frames]
    for event in history.events:
        (n,) = np.flatnonzero(times == event.time)
        assert times[n + 1] == np.nextafter(event.time, np.inf)
        assert [frame.fields["side"] for frame in frames[n : n + 2]] == [-1, 1]


def test_points_and_results_are_those_of_the_history(exported):
    history, frames = exported
    geometry = BeamGeometry(history, 1.0)
    tangent, normal = geometry.slope_axes
    sides = few_sides(history.scenario.beam.section.shape)
    touching = 0
    for frame in frames:
        at, forces = (data.sel(time=frame.fields["time"]) for data in (history.data, history.section_forces()))
        assert set(frame.parts) == PARTS | ({"masses"} if history.scenario.point_masses else set())
        axis, tube, touch = (frame.parts[name] for name in ("centreline", "surface", "contact_point"))
        turn = np.exp(1j * float(at["theta"]))
        elastic = (at["ux"].values + 1j * at["uy"].values) * turn
        along = turn * (geometry.scenario.root.hub_radius + history["station"].values)
        for found, expected in ((axis["points"], along + elastic), (axis["elastic_displacement"], elastic)):
            np.testing.assert_allclose(found[:, 0] + 1j * found[:, 1], expected, rtol=0.0, atol=1e-12)
        for name in RESULTS:
            np.testing.assert_allclose(axis[name], forces[name].values, rtol=1e-12, atol=1e-12)
        stress = tube["bending_stress"][: history["station"].size * sides].reshape(-1, sides)
        bending = forces["bending_stress"].values
        for side, sign in ((sides // 2, 1.0), (0, -1.0)):  # of negative and of positive y
            np.testing.assert_allclose(stress[:, side], sign * bending, rtol=1e-11, atol=1e-5)
        start = frame.parts["reference"]["points"]
        np.testing.assert_allclose(start + tube["displacement"], tube["points"], rtol=0.0, atol=1e-12)
        np.testing.assert_array_equal(start, frames[0].parts["reference"]["points"])
        np.testing.assert_allclose(touch["points"], [[at["tip_x"], at["tip_y"], 0.0]], rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(touch["velocity"], [[at["tip_vx"], at["tip_vy"], 0.0]], atol=1e-12)
        force = float(at["lambda_n"]) * normal + float(at["lambda_tau"]) * tangent
        np.testing.assert_allclose(touch["contact_force"][0, :2], force, rtol=1e-12, atol=1e-9)
        for name in ("gap", "depth", "gap_rate", "slip_rate", "state"):
            assert touch[name].item() == float(at[name])
        touching += float(at["lambda_n"]) > 1.0
        moving = [part for name, part in frame.parts.items() if name not in ("pin", "slope")]
        assert all(values.dtype == np.float64 for part in moving for values in part.values())
        around = tube["points"][:sides] - axis["points"][0]
        np.testing.assert_allclose(np.abs(around[:, 2]).max(), geometry.radii[0], rtol=1e-12)  # as wide as it is
    assert touching > 0 or not history.contacts


def test_field_data_say_what_it_is(exported):
    history, frames = exported
    fields = frames[-1].fields
    assert fields["made_by"].startswith(provenance_line(provenance()))
    assert fields["scenario"] == history.scenario_toml
    assert fields["events"] == history.events_csv()
    assert fields["warnings"].splitlines() == history.summary["warnings"]
    assert float(fields["deformation_factor"]) == 1.0
    units = {line.split(" = ")[0]: line.split(" = ")[1].split(",")[0] for line in fields["units"].splitlines()}
    for unit, names in UNITS.items():
        assert {units[name] for name in names} == {unit}
    assert {name for part in frames[0].parts.values() for name in part} - {"position"} <= units.keys()


def size_of(file):
    return sum(path.stat().st_size for path in file.parent.rglob("*") if path.is_file())


@pytest.mark.parametrize(("format", "most"), [("pvd", 50e3), ("xdmf", 57e3)])
def test_what_stands_still_is_written_once_and_the_rest_is_small(run, tmp_path, format, most):
    """Bytes for each frame, of which there were 140,000 and 193,000 when all parts were in all frames."""
    history = run(*PAPER)
    first, whole = (
        export(history, tmp_path / str(every) / f"beam.{format}", every=every) for every in (10**9, 100)
    )
    frames = whole.samples - first.samples
    assert (size_of(whole.file) - size_of(first.file)) / frames < most
    if format == "pvd":
        moving = {"surface", "centreline", "contact_point"}
        names = [path.name.rsplit("_", 1)[0] for path in (whole.file.parent / "beam").iterdir()]
        counts = {name: names.count(name) for name in PARTS}
        assert counts == {name: whole.samples if name in moving else 1 for name in PARTS}
        listed = ElementTree.parse(whole.file).getroot()[0]
        assert {entry.get("name") for entry in listed} == PARTS
        assert len(listed) == len(PARTS) * whole.samples


def leaves(data):
    """The meshes of a composite dataset."""
    if not data.IsA("vtkMultiBlockDataSet"):
        return [data]
    return [leaf for k in range(data.GetNumberOfBlocks()) if data.GetBlock(k) for leaf in leaves(data.GetBlock(k))]


@pytest.fixture(scope="module", params=[0.0, 0.8, 1.68, 2.5, 3.68, 7.68, 700.0])
def late(run, request, tmp_path_factory):
    """An XDMF export of a run that begins at some time (s), and the samples that are its frames."""
    history = run(*PAPER)
    times = ascending(history["time"].values + request.param)
    events = [e._replace(time=times[np.searchsorted(history["time"].values, e.time)]) for e in history.events]
    history = replace(history, data=history.data.assign_coords(time=times), events=events)
    done = export(history, tmp_path_factory.mktemp("late") / "beam", format="xdmf", every=1000)
    return history, done.file, chosen_samples(history, 1000)


def test_readers_of_xdmf_have_every_frame_apart_and_in_order(late):
    """VTK's reader and meshio's; what each side of a jump is, the rate of the gap says."""
    history, file, samples = late
    assert np.count_nonzero(np.diff(history["time"].values[samples]) < 1e-12) >= 8  # jumps
    reader = vtkXdmfReader()
    reader.SetFileName(str(file))
    reader.UpdateInformation()
    stamps = list(reader.GetOutputInformation(0).Get(vtkCompositeDataPipeline.TIME_STEPS()))
    assert len(stamps) == samples.size
    np.testing.assert_allclose(stamps, history["time"].values[samples], rtol=0.0, atol=1e-15)
    rates = history["gap_rate"].values[samples]
    for stamp, rate in zip(stamps, rates, strict=True):
        reader.UpdateTimeStep(stamp)
        parts = {int(mesh.GetCellData().GetArray("part").GetValue(0)): mesh for mesh in leaves(reader.GetOutput())}
        assert sorted(parts) == list(range(6))
        assert len(leaves(reader.GetOutput())) == 6
        assert parts[4].GetPointData().GetArray("gap_rate").GetValue(0) == rate
    frames = read_xdmf(file)
    assert [frame.stamp for frame in frames] == stamps
    assert [frame.parts["contact_point"]["gap_rate"].item() for frame in frames] == rates.tolist()


@pytest.mark.skipif(shutil.which("pvpython") is None, reason="there is no ParaView")
@pytest.mark.parametrize("reader", ["XDMFReader", "Xdmf3ReaderS", "PVDReader"])
def test_readers_of_paraview_have_every_frame_apart_and_in_order(run, tmp_path, display, reader):
    history, suffix = run(*PAPER), "pvd" if reader == "PVDReader" else "xdmf"
    file = export(history, tmp_path / f"beam.{suffix}", every=1000).file
    option = "FileNames" if reader == "XDMFReader" else "FileName"
    (tmp_path / "look.py").write_text(PARAVIEW.format(reader=reader, option=option, file=str(file)))
    words, place = ["pvpython", str(tmp_path / "look.py")], {**os.environ, "DISPLAY": display}
    done = subprocess.run(words, capture_output=True, text=True, env=place, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    found = [tuple(map(float, line.split())) for line in done.stdout.splitlines()]
    samples = chosen_samples(history, 1000)
    rates = history["gap_rate"].values[samples]
    assert [(parts, rate) for _, parts, rate in found] == [(6, rate) for rate in rates.tolist()]
    np.testing.assert_allclose([t for t, *_ in found], history["time"].values[samples], rtol=0.0, atol=1e-15)


#: prints of each time: number of meshes, rate of the gap of the contact point
PARAVIEW = """
from paraview.simple import {reader}
from paraview import servermanager

reader = {reader}({option}={file!r})
for time in list(reader.TimestepValues):
    reader.UpdatePipeline(time)
    walk = servermanager.Fetch(reader).NewIterator()
    walk.InitTraversal()
    meshes = []
    while not walk.IsDoneWithTraversal():
        meshes.append(walk.GetCurrentDataObject())
        walk.GoToNextItem()
    rates = [mesh.GetPointData().GetArray("gap_rate") for mesh in meshes]
    print(repr(time), len(meshes), *(repr(rate.GetValue(0)) for rate in rates if rate))
"""


@pytest.mark.parametrize("format", FORMATS)
def test_both_formats_open_in_pyvista_under_any_name(run, tmp_path, format):
    done = export(run(*PAPER), tmp_path / f"a & b < 'c' µ.{format}", every=5000)
    reader = pv.get_reader(str(done.file))
    assert len(reader.time_values) == done.samples
    reader.set_active_time_value(reader.time_values[-1])
    blocks = reader.read()
    order = [int(block["part"][0]) for block in blocks]
    assert order == (list(range(6)) if format == "pvd" else list(range(6))[::-1])  # as the page says
    if format == "xdmf":  # meshio's own way to read: the surface
        with meshio.xdmf.TimeSeriesReader(done.file) as one:
            points, _ = one.read_points_cells()
            _, arrays, _ = one.read_data(0)
        np.testing.assert_array_equal(points, arrays["position"])


@pytest.mark.parametrize("format", FORMATS)
def test_a_factor_magnifies_shapes_and_no_result_and_without_contact_parts_are_less(run, tmp_path, format):
    history = run("spin-up", "end_time=0.02")
    true, drawn = (
        read(export(history, tmp_path / f"beam-{f:g}", format=format, every=100, deformation=f).file)[-1].parts
        for f in (1.0, 50.0)
    )
    assert set(true) == PARTS - {"contact_point", "slope"}
    for name, values in true["surface"].items():
        assert np.array_equal(drawn["surface"][name], values) == (name not in ("points", "position"))


@pytest.mark.parametrize("format", FORMATS)
def test_masses_and_forces_are_parts_of_their_own(run, tmp_path, format):
    """On the axis; a force across the beam along its normal, one fixed in space where it points."""
    masses = "masses=[{place=0.5,mass=0.3,inertia=0.002},{mass=0.1}]"
    forces = "forces=[{place=0.75,force=5},{place=0.25,direction=0.4,table=[[0,1],[0.1,3]]}]"
    history = run("paper", "contact.enabled=false", "end_time=0.1", masses, forces)
    frames = read(export(history, tmp_path / f"run.{format}", format=format, every=500).file)
    for frame in frames:
        at = history.data.sel(time=frame.stamp)
        axis = np.interp([0.5, 1.0, 0.75, 0.25], at["station"], frame.parts["centreline"]["points"][:, 0])
        heavy, pushed = frame.parts["masses"], frame.parts["forces"]
        np.testing.assert_allclose(np.append(heavy["points"][:, 0], pushed["points"][:, 0]), axis, atol=1e-12)
        np.testing.assert_allclose(heavy["mass"], [0.3, 0.1])
        np.testing.assert_allclose(heavy["inertia"], [0.002, 0.0])
        slope = np.interp(0.75, at["station"], np.gradient(at["uy"].values, at["station"].values))
        across = 5.0 * 1j * np.exp(1j * float(at["theta"])) * (1.0 - 0.5 * slope**2 + 1j * slope)
        fixed = (1.0 + 20.0 * frame.stamp) * np.exp(0.4j)
        found = pushed["applied_force"] @ (1.0, 1j, 0.0)
        np.testing.assert_allclose(found, [across, fixed], atol=1e-4)


def test_a_table_of_the_time_series_is_read_back_as_it_was(run, tmp_path):
    history = run("elastic-stop", "end_time=0.33")
    table = pd.read_csv(export(history, tmp_path / "series", format="csv").file)
    assert {"time (s)", "lambda_n (N)", "theta (rad)", "energy_kinetic (J)"} <= set(table)
    names = [label.rpartition(" (")[0] for label in table]
    series = history.to_dataframe()
    pd.testing.assert_frame_equal(table.set_axis(names, axis=1), series, check_dtype=False, rtol=1e-15)
    some = export(history, tmp_path / "some.csv", between=(0.1, 0.2), every=10)
    assert 0.1 <= pd.read_csv(some.file)["time (s)"].iloc[0] < 0.102


# Samples ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("every", [None, 7, 10**9])
def test_every_event_is_kept_under_any_decimation(run, every):
    history = run("sticking")
    samples, times = chosen_samples(history, every), history["time"].values
    for event in history.events:
        assert {event.time, np.nextafter(event.time, np.inf)} <= set(times[samples])
    assert samples[[0, -1]].tolist() == [0, times.size - 1] or every == 10**9
    assert np.all(np.diff(samples) > 0)
    if every is None:
        assert FRAMES <= samples.size < FRAMES + 4 * len(history.events) + 2


def test_a_span_that_ends_at_an_event_keeps_both_sides_and_shapes_are_finite(run):
    history = run(*PAPER)
    times, first = history["time"].values, history.events[0].time
    inside = times[chosen_samples(history, 1, (0.1, first))]
    assert inside[[0, -1]].tolist() == [pytest.approx(0.1, abs=2e-4), np.nextafter(first, np.inf)]
    data = history.data.copy(deep=True)
    data["uy"].values[-1] = np.nan
    data = data.assign_coords(time=ascending(data["time"].values))
    assert chosen_samples(replace(history, data=data), 1)[-1] == data["time"].size - 2


# Command ------------------------------------------------------------------------------------------------------


def test_the_command_says_what_it_wrote_and_replaces_an_earlier_export(folder, tmp_path, cli):
    file = tmp_path / "new" / "beam.pvd"
    words = ("export", folder, "--between", "0,0.32")
    code, out, err = cli(*words, "--out", file, "--every", 400)
    frames = read(file)
    assert (code, err) == (0, "")
    assert out.startswith(f"{len(frames)} of ")
    assert "deformation factor 1" in out
    assert str(file) in out
    assert cli(*words, "--out", file, "--every", 5000)[0] == 0
    assert len(read(file)) < len(frames)
    for name in ("b", "v1.5"):
        assert cli(*words, "--format", "xdmf", "--out", tmp_path / name, "--every", 5000)[0] == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["b.h5", "b.xdmf", "new", "v1.5.h5", "v1.5.xdmf"]


BAD = {
    ("--format", "stl"): "--format stl",
    ("--format", "xdmf"): "should end in .xdmf",
    ("--every", "0"): "--every",
    ("--between", "0.5,0.1"): "--between",
    ("--between", "a,b"): "--between",
    ("--between", "5,6"): "covers 0 to 1 s",
    ("--deformation", "0"): "--deformation",
}


@pytest.mark.parametrize("options", BAD, ids=" ".join)
def test_bad_options_are_one_line_and_write_nothing(folder, tmp_path, refused, options):
    assert BAD[options] in refused("export", folder, "--out", tmp_path / "new" / "beam.pvd", *options)
    assert list(tmp_path.iterdir()) == []


def test_nothing_but_exports_is_replaced(folder, tmp_path, refused):
    (tmp_path / "beam").mkdir()
    (tmp_path / "beam" / "notes.txt").write_text("mine")
    (tmp_path / "beam.h5").write_text("mine")
    (tmp_path / "dir.pvd").mkdir()
    for name in ("beam.pvd", "beam.xdmf", "dir.pvd"):
        assert "--out" in refused("export", folder, "--out", tmp_path / name)
    assert (tmp_path / "beam" / "notes.txt").read_text() == "mine"

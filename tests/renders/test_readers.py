"""What readers make of our files where a user may not expect it: the rows of `docs/reference/files.md`.

ParaView's rows are the output of `benchmarks/paraview_readers.py`.
"""

from __future__ import annotations

import math
from xml.etree import ElementTree

import meshio
import numpy as np
import pandas as pd
import pytest
import pyvista as pv
import xarray as xr
from vtkmodules.vtkCommonExecutionModel import vtkCompositeDataPipeline
from vtkmodules.vtkIOXdmf2 import vtkXdmfReader

from oblique_impact.renders import export
from oblique_impact.renders.exports import chosen_samples

PARTS = ["surface", "centreline", "reference", "pin", "contact_point", "slope"]
FEW = 10**9  # every so many samples: the first, the last, and those at events
LEFT, RIGHT, NEXT = 1, 2, 3  # numbers of frames: the impact, the release


@pytest.fixture(scope="module")
def history(run):
    return run("paper", "end_time=0.32")


@pytest.fixture(scope="module")
def folder(history, tmp_path_factory):
    """A run with its exports."""
    place = history.save(tmp_path_factory.mktemp("readers") / "run")
    for format in ("pvd", "xdmf"):
        export(history, place / f"beam.{format}", format=format, every=FEW)
    return place


class Vtk:
    """VTK's own reader of XDMF, that of ParaView's XDMF Reader."""

    def __init__(self, file):
        self.reader = vtkXdmfReader()
        self.reader.SetFileName(str(file))
        self.reader.UpdateInformation()
        self.times = list(self.reader.GetOutputInformation(0).Get(vtkCompositeDataPipeline.TIME_STEPS()))

    def at(self, time):
        self.reader.UpdateTimeStep(time)
        return pv.wrap(self.reader.GetOutput())


class PyVista:
    """PyVista's reader of either format."""

    def __init__(self, file):
        self.reader = pv.get_reader(str(file))
        self.times = list(self.reader.time_values)

    def at(self, time):
        self.reader.set_active_time_value(time)
        return self.reader.read()


READERS = [(Vtk, "xdmf"), (PyVista, "xdmf"), (PyVista, "pvd")]


def meshes(data):
    """Names and meshes that are there; where times are too close a block is a list of meshes."""
    for name, block in zip(data.keys(), data, strict=True):
        if isinstance(block, pv.MultiBlock):
            yield from ((name, mesh) for _, mesh in meshes(block))
        elif block is not None:
            yield name, block


@pytest.fixture(scope="module")
def frames(history):
    """Numbers of frames by what tells them apart, rate of the gap and state."""
    samples = chosen_samples(history, FEW)
    found = zip(*(history[name].values[samples].tolist() for name in ("gap_rate", "state")), strict=True)
    numbers = {both: k for k, both in enumerate(found)}
    assert len(numbers) == samples.size == 6
    return numbers


@pytest.fixture
def shown(frames):
    """The numbers of the frames that a reader shows at a time."""
    return lambda reader, time: [
        frames[mesh["gap_rate"][0], mesh["state"][0]]
        for _, mesh in meshes(reader.at(time))
        if "gap_rate" in mesh.point_data
    ]


@pytest.mark.parametrize(("kind", "format"), READERS)
def test_each_frame_is_shown_at_its_time_with_all_parts(folder, shown, frames, kind, format):
    reader = kind(folder / f"beam.{format}")
    assert [shown(reader, time) for time in reader.times] == [[k] for k in range(len(frames))]
    found = list(meshes(reader.at(reader.times[0])))
    order = PARTS if format == "pvd" else PARTS[::-1]
    assert [PARTS[int(mesh["part"][0])] for _, mesh in found] == order
    names = [f"Block-{k:02}" for k in range(6)] if format == "pvd" else order
    assert [name for name, _ in found] == names


def test_vtk_shows_the_frame_before_a_time_and_the_ends_beyond_them(folder, shown):
    reader = Vtk(folder / "beam.xdmf")
    times = reader.times
    assert shown(reader, 0.5 * (times[RIGHT] + times[NEXT])) == [RIGHT]
    assert shown(reader, times[LEFT] - 1e-9) == [LEFT - 1]
    assert shown(reader, math.nextafter(times[LEFT], 1.0)) == [LEFT]  # the time of the right side in a history
    assert (shown(reader, -1.0), shown(reader, 9.0)) == ([0], [len(times) - 1])


@pytest.mark.parametrize("format", ["pvd", "xdmf"])
def test_pyvista_has_no_times_but_those_of_frames(folder, shown, format):
    reader = PyVista(folder / f"beam.{format}")
    middle = 0.5 * (reader.times[RIGHT] + reader.times[NEXT])
    for time in (middle, -1.0, 9.0):
        with pytest.raises((KeyError, ValueError), match=str(time)):
            reader.at(time)
    number = np.searchsorted(reader.times, middle, side="right") - 1  # as the page says
    assert shown(reader, reader.times[number]) == [RIGHT]


@pytest.mark.parametrize(("kind", "format"), READERS)
def test_a_part_that_comes_later_is_shown_from_there_on(folder, shown, kind, format):
    tree = ElementTree.parse(folder / f"beam.{format}")
    if format == "pvd":
        entries = tree.find("Collection")
        entries.remove(entries.find("DataSet[@name='contact_point']"))
    else:
        grids = tree.find("Domain/Grid[@Name='contact_point']")
        grids.remove(grids.find("Grid"))
    tree.write(folder / f"late.{format}")
    reader = kind(folder / f"late.{format}")
    assert [shown(reader, time) for time in reader.times] == [[], *([k] for k in range(1, len(reader.times)))]


@pytest.mark.parametrize("kind", [Vtk, PyVista])
def test_frames_of_an_xdmf_one_double_apart_are_shown_over_each_other(folder, shown, kind):
    """Therefore ours are 8.9e-16 s apart."""
    tree = ElementTree.parse(folder / "beam.xdmf")
    for grids in tree.findall("Domain/Grid"):
        left, right = (grids.findall("Grid/Time")[k] for k in (LEFT, RIGHT))
        right.set("Value", repr(math.nextafter(float(left.get("Value")), 1.0)))
    tree.write(folder / "close.xdmf")
    reader = kind(folder / "close.xdmf")
    assert [shown(reader, reader.times[k]) for k in (LEFT, RIGHT)] == [[LEFT, RIGHT]] * 2


def test_meshio_reads_the_surface_by_numbers_of_frames_and_the_axis_as_lines(folder, history, frames):
    file = folder / "beam.xdmf"
    with meshio.xdmf.TimeSeriesReader(file) as reader:
        points, _ = reader.read_points_cells()
        stamps, positions = zip(
            *((stamp, of["position"]) for stamp, of, _ in map(reader.read_data, range(reader.num_steps))),
            strict=True,
        )
        assert reader.num_steps == len(frames)
        np.testing.assert_array_equal(points, positions[0])  # those of the first frame alone
        assert stamps[RIGHT] - stamps[LEFT] == pytest.approx(8.9e-16, abs=1e-17)
        assert np.abs(positions[NEXT] - points).max() > 0.1
        reader.collection = list(reader.domain.find("Grid[@Name='centreline']"))
        reader.mesh_grid = reader.collection[0]
        _, cells = reader.read_points_cells()
    assert [(block.type, len(block)) for block in cells] == [("line", history["station"].size - 1)]


def test_of_a_whole_series_meshio_reads_nothing_and_pyvista_the_first_frame(folder, frames):
    with pytest.raises(SystemExit):
        meshio.read(folder / "beam.xdmf")
    for format in ("pvd", "xdmf"):
        parts = {int(mesh["part"][0]): mesh for _, mesh in meshes(pv.read(folder / f"beam.{format}"))}
        assert frames[parts[4]["gap_rate"][0], parts[4]["state"][0]] == 0


# history.nc and tables ------------------------------------------------------------------------------------------


@pytest.fixture(params=["h5netcdf", "netcdf4"])
def opened(folder, request):
    if request.param == "netcdf4":
        pytest.importorskip("netCDF4")
    with xr.open_dataset(folder / "history.nc", engine=request.param) as data:
        yield data


def test_xarray_selects_either_side_of_a_jump_and_interpolates_straight(opened, history):
    rate, time = opened["gap_rate"], history.events[0].time
    times, right = opened["time"].values, math.nextafter(time, 1.0)
    k = int(np.searchsorted(times, time))
    before, left, after = (float(rate[n]) for n in (k - 1, k, k + 1))
    assert left < -3.0 < -1e-9 < after  # m/s
    assert (float(rate.sel(time=time)), float(rate.sel(time=right))) == (left, after)
    beside = [(time - 1e-9, "ffill", before), (time - 1e-9, "bfill", left), (time + 1e-9, "ffill", after)]
    assert [float(rate.sel(time=t, method=method)) for t, method, _ in beside] == [x for *_, x in beside]
    with pytest.raises(KeyError):
        rate.sel(time=-1.0, method="ffill")
    assert np.isnan(rate.interp(time=[-1.0, 9.0])).all()
    inside = np.linspace(times[k - 1], times[k + 2], 40)
    for method in ("linear", "pchip"):
        found = rate.interp(time=inside, method=method).values
        assert found.min() >= min(before, left) - 1e-9
        assert found.max() <= 1e-9
        np.testing.assert_array_equal(rate.interp(time=[time, right], method=method), [left, after])


def test_a_cubic_through_a_jump_is_off_by_orders_and_ours_stops_there(opened, history):
    rate, time = opened["gap_rate"], history.events[0].time
    inside = np.linspace(time - 2e-4, time + 2e-4, 40)
    assert np.abs(rate.interp(time=inside, method="cubic")).max() > 1e9  # m/s, where it is 4
    found = [float(history.at(t)["gap_rate"]) for t in inside[::13]]
    assert -4.0 < min(found) < max(found) < 1e-9


def test_pandas_reads_every_digit_of_a_table(history, tmp_path):
    """pandas 3 does by itself; of pandas 2 the two times of a jump may be one."""
    file = export(history, tmp_path / "series.csv").file
    exact = {} if int(pd.__version__.split(".")[0]) > 2 else {"float_precision": "round_trip"}
    table = pd.read_csv(file, **exact)
    assert table["time (s)"].tolist() == history["time"].values.tolist()
    assert table["gap_rate (m/s)"].tolist() == history["gap_rate"].values.tolist()

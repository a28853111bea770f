"""Exported time series: the scene against the history, and what the readers of others find against the scene."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from dataclasses import replace

import h5py
import numpy as np
import pytest
import pyvista as pv

from oblique_impact import InputError
from oblique_impact.history.provenance import described, provenance
from oblique_impact.history.sample_times import ascending
from oblique_impact.renders.exports import pvd, vtkhdf, xdmf
from oblique_impact.renders.exports.command import _Job
from oblique_impact.renders.exports.scene import FRAME_QUANTITIES, RESULTS, Scene
from oblique_impact.renders.exports.selection import FRAMES, Selection, sides
from oblique_impact.renders.geometry import BETWEEN, SIDES
from oblique_impact.renders.scenery import pin, slope_wedge
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style
from tests.renders.export_readers import read, read_xdmf_by_vtk

WRITERS = {"pvd": pvd.write, "vtkhdf": vtkhdf.write, "xdmf": xdmf.write}
PARTS = ["surface", "centreline", "reference", "pin", "contact_point", "slope"]


def scene_of(history, selection, factor=1.0):
    return Scene.of(story_of([history], Style(deformation=factor)), selection.frames(history))


@pytest.fixture(scope="module")
def scene(run):
    return scene_of(run("paper", "end_time=0.34"), Selection(500))


@pytest.fixture(scope="module", params=WRITERS)
def exported(scene, request, tmp_path_factory):
    return write(scene, tmp_path_factory.mktemp(request.param) / f"beam.{request.param}")


@pytest.fixture(scope="module")
def frames(exported):
    return read(exported)


@pytest.fixture(params=WRITERS)
def format(request):
    return request.param


def write(scene, target):
    WRITERS[target.suffix[1:]](scene, target, lambda: None)
    return target


# What the readers find ---------------------------------------------------------------------------------------


def test_nothing_is_lost_on_the_way(frames, scene, exported):
    """Times, points, results and cells of all parts to the last bit; 0 where VTKHDF has to fill."""
    assert [frame.stamp for frame in frames] == scene.frames.time.tolist()
    for n, frame in enumerate(frames):
        assert {name: float(frame.fields[name]) for name in FRAME_QUANTITIES} == scene.fields_at(n)
        assert sorted(frame.parts) == sorted(PARTS)
        for part in scene.parts:
            expected, found = part.shape(scene.frames.sample[n]), frame.parts[part.name]
            np.testing.assert_array_equal(found.points, expected.points)
            assert expected.arrays.keys() <= found.arrays.keys() <= RESULTS.keys()
            for name, values in found.arrays.items():
                assert values.dtype == np.float64
                np.testing.assert_array_equal(values, expected.arrays.get(name, np.zeros_like(values)))
                assert name in expected.arrays or exported.suffix == ".vtkhdf"
            if part.kind != "lines":
                assert [
                    value for cell in found.cells[part.kind] for value in (len(cell), *cell)
                ] == part.cells.tolist()
    rings = scene.geometry.places.size
    chain = [[i, i + 1] for i in range(rings - 1)] if exported.suffix == ".xdmf" else [list(range(rings))]
    assert frames[0].parts["centreline"].cells["lines"] == chain


def test_field_data_say_what_it_is(frames, scene):
    history = scene.geometry.history
    for frame in (frames[0], frames[-1]):
        fields = frame.fields
        assert fields["format"] == "oblique-impact export 2"
        assert fields["made_by"].startswith(described(provenance()))
        assert fields["warnings"].splitlines() == history.summary["warnings"]
        assert fields["scenario"] == history.scenario_toml
        assert fields["events"] == history.events_csv()
        assert float(fields["deformation_factor"]) == 1.0
        assert "next larger double" in fields["times"]
        assert fields["parts"].splitlines() == [f"{k} = {name}" for k, name in enumerate(PARTS)]


#: unit by unit what it must be, from the equations: a force per area is a stress, a moment is a force by an arm
UNITS = {
    "m": ["points", "elastic_displacement", "displacement", "gap", "depth"],
    "m/s": ["velocity", "gap_rate", "slip_rate"],
    "rad": ["section_rotation"],
    "N m": ["bending_moment"],
    "N": ["shear_force", "axial_force", "contact_force", "normal_force", "friction_force"],
    "Pa": ["bending_stress", "axial_stress"],
    "s": ["time"],
    "0 free": ["state"],
    "-1 left of a jump": ["side"],
    "number in the history": ["sample"],
}


def test_every_result_says_its_unit(frames):
    units = dict(line.split(" = ", 1) for line in frames[0].fields["units"].splitlines())
    found = {name: unit.partition(",")[0] for name, unit in units.items()}
    assert found == {name: unit for unit, names in UNITS.items() for name in names}
    assert {name for mesh in frames[0].parts.values() for name in mesh.arrays} <= units.keys()
    assert units["state"] == "0 free, 1 slip, 2 stick"


def test_xdmf_through_vtk(scene, tmp_path, capfd):
    """VTK's reader takes times less than 1e-7 s apart for one: it returns both sides of a jump, and no warning."""
    path = write(scene, tmp_path / "beam.xdmf")
    kinds = dict(re.findall(r'Attribute Name="(\w+)" AttributeType="(\w+)" Center="Node"', path.read_text()))
    arrays = {name: values for part in scene.parts for name, values in part.shape(0).arrays.items()}
    assert {n: kinds[n] for n in arrays} == {n: "Vector" if v.ndim > 1 else "Scalar" for n, v in arrays.items()}
    found = read_xdmf_by_vtk(path)
    np.testing.assert_array_equal([stamp for stamp, _ in found], scene.frames.time)
    for stamp, blocks in found:
        near = scene.frames.sample[np.abs(scene.frames.time - stamp) <= 1e-7]
        for mesh, sample in zip(blocks["surface"], near, strict=True):
            surface = scene.geometry.surface(sample)
            np.testing.assert_array_equal(mesh.points, surface.points)
            for name, values in surface.arrays.items():
                np.testing.assert_array_equal(mesh.point_data[name], values)
    assert capfd.readouterr().err == ""


def test_a_single_frame_and_no_contact(run, tmp_path, format):
    """VTK gives no time for a single step of VTKHDF; its points and fields are there."""
    scene = scene_of(run("spin-up"), Selection(between=(0.0, 1e-5)))
    assert ([part.name for part in scene.parts], scene.frames.sample.tolist()) == (PARTS[:4], [0])
    path = write(scene, tmp_path / f"beam.{format}")
    mesh = pv.HDFReader(str(path)).read() if format == "vtkhdf" else read(path)[0].parts["surface"]
    np.testing.assert_array_equal(mesh.points[:1682], scene.geometry.surface(0).points)


def test_an_impact_at_the_start(run, tmp_path, format):
    """The right side of t = 0 carries the smallest number above it; readers tell the two apart."""
    history = run("paper", "end_time=0.34")
    start = history.events[0].time
    first = int(np.flatnonzero(history["time"].values == start)[0])
    data = history.data.isel(time=slice(first, first + 60))
    after = data["time"].values - start
    data = data.assign_coords(time=ascending(np.where(after < 1e-12, 0.0, after)))
    moved = replace(history, data=data, events=[history.events[0]._replace(time=0.0)], contacts=[])
    frames = read(write(scene_of(moved, Selection(30)), tmp_path / f"beam.{format}"))
    assert [frame.stamp for frame in frames[:2]] == [0.0, np.nextafter(0.0, 1.0)]
    assert [frame.fields["side"] for frame in frames[:2]] == [-1, 1]


# The scene against the history -------------------------------------------------------------------------------


SCENES = {
    "paper": ("paper", "end_time=0.34"),
    "tapered": ("tapered", "end_time=0.32"),
    "elastic-stop": ("elastic-stop", "end_time=0.33"),
    "hub": ("paper", "root.kind=hub", "root.inertia=0.1", "root.hub_radius=0.1", "contact.enabled=false"),
    "stopped by the physics": ("paper", "discretization.modes=8", "solver.tolerance=1e-8"),
}


@pytest.fixture(scope="module", params=SCENES)
def any_scene(run, request):
    return scene_of(run(*SCENES[request.param]), Selection(2000))


def shapes(scene):
    """Per frame its sample and its parts by name."""
    for k in scene.frames.sample.tolist():
        yield k, {part.name: part.shape(k) for part in scene.parts}


def test_results_are_those_of_the_history(any_scene):
    geometry = any_scene.geometry
    history, stations = geometry.history, slice(None, None, BETWEEN + 1)
    scale = {
        name: np.abs(history[name].values).max() for name in ("moment", "shear", "axial_force", "bending_stress")
    }
    area = geometry.sections.area(history["station"].values)

    def side(values, number):
        return values[: geometry.places.size * SIDES].reshape(-1, SIDES)[stations, number]

    for k, parts in shapes(any_scene):
        tube, axis = parts["surface"].arrays, parts["centreline"].arrays
        for name, variable in (
            ("bending_moment", "moment"),
            ("shear_force", "shear"),
            ("axial_force", "axial_force"),
        ):
            for values in (axis[name][stations], side(tube[name], 5)):
                expected = history[variable].values[k]
                np.testing.assert_allclose(values, expected, rtol=1e-12, atol=1e-14 * scale[variable])
        stress, tolerance = history["bending_stress"].values[k], 1e-13 * scale["bending_stress"]
        lower, upper = (side(tube["bending_stress"], n) for n in (SIDES // 2, 0))  # sides of negative, positive y
        np.testing.assert_allclose(lower, stress, rtol=1e-11, atol=tolerance)
        np.testing.assert_allclose(upper, -stress, rtol=1e-11, atol=tolerance)
        axial = stress + history["axial_force"].values[k] / area
        np.testing.assert_allclose(side(tube["axial_stress"], SIDES // 2), axial, rtol=1e-11, atol=tolerance)
        theta, ux, uy = (history[name].values[k] for name in ("theta", "ux", "uy"))
        along, across = (
            np.array([np.cos(theta), np.sin(theta), 0.0]),
            np.array([-np.sin(theta), np.cos(theta), 0.0]),
        )
        x = geometry.scenario.root.hub_radius + history["station"].values + ux
        points = np.outer(x, along) + np.outer(uy, across)
        np.testing.assert_allclose(parts["centreline"].points[stations], points, rtol=0.0, atol=1e-12)
        elastic = np.outer(ux, along) + np.outer(uy, across)
        np.testing.assert_allclose(axis["elastic_displacement"][stations], elastic, rtol=0.0, atol=1e-14)


def test_warping_the_initial_shape_by_the_displacement_gives_the_deformed_one(any_scene):
    """In a sum of NumPy and in VTK's filter; the beam has swung, so that this is no elastic displacement."""
    start = any_scene.geometry.surface(0).points
    for _, parts in shapes(any_scene):
        moved = parts["reference"].arrays["displacement"]
        np.testing.assert_array_equal(parts["reference"].points, start)
        np.testing.assert_allclose(start + moved, parts["surface"].points, rtol=0.0, atol=1e-15)
    mesh = pv.PolyData(start)
    mesh["displacement"] = moved
    np.testing.assert_allclose(mesh.warp_by_vector("displacement").points, parts["surface"].points, atol=1e-12)
    assert np.linalg.norm(moved, axis=1).max() > 0.1


def test_the_contact_point_is_a_vertex_with_its_forces(scene):
    """Its place, motion and forces against the history; the power of the force from both sides."""
    history, angle = scene.geometry.history, scene.geometry.scenario.slope.angle
    # out of the slope and up along it
    normal, along = np.array([-np.sin(angle), np.cos(angle), 0.0]), np.array([np.cos(angle), np.sin(angle), 0.0])
    touching = 0
    for k, parts in shapes(scene):
        value = {name: history[name].values[k] for name in history.data.data_vars if history[name].ndim == 1}
        point, got = parts["contact_point"].points, parts["contact_point"].arrays
        np.testing.assert_allclose(point, [[value["tip_x"], value["tip_y"], 0.0]], rtol=0.0, atol=1e-14)
        np.testing.assert_array_equal(got["velocity"], [[value["tip_vx"], value["tip_vy"], 0.0]])
        for name in ("gap", "depth", "gap_rate", "slip_rate", "state"):
            np.testing.assert_array_equal(got[name], [value[name]])
        np.testing.assert_allclose(got["normal_force"], [value["lambda_n"] * normal], rtol=1e-14, atol=1e-12)
        np.testing.assert_allclose(got["friction_force"], [value["lambda_tau"] * along], rtol=1e-14, atol=1e-12)
        np.testing.assert_array_equal(got["contact_force"], got["normal_force"] + got["friction_force"])
        power = value["lambda_n"] * value["gap_rate"] + value["lambda_tau"] * value["slip_rate"]
        assert float(np.sum(got["contact_force"] * got["velocity"])) == pytest.approx(power, rel=1e-9, abs=1e-9)
        touching += value["lambda_n"] > 1.0
    assert touching >= 5


def test_slope_and_pin_stand_still(scene, run):
    story = story_of([run("paper", "end_time=0.34")])
    for name, mesh in (("slope", slope_wedge(scene.geometry, story.slope)), ("pin", pin(scene.geometry))):
        part = next(part for part in scene.parts if part.name == name)
        assert not part.moves
        np.testing.assert_array_equal(part.shape(7).points, mesh.triangulate().points)


def test_a_factor_magnifies_the_shapes_and_no_result(run):
    history = run("paper", "end_time=0.34")
    drawn, true = (scene_of(history, Selection(5000), factor) for factor in (5.0, 1.0))
    assert drawn.fields["deformation_factor"] == 5.0
    for (k, magnified), (_, parts) in zip(shapes(drawn), shapes(true), strict=True):
        np.testing.assert_array_equal(magnified["surface"].points, drawn.geometry.surface(k).points)
        for name in ("reference", "contact_point"):
            for result, values in magnified[name].arrays.items():
                np.testing.assert_array_equal(values, parts[name].arrays[result])


# Selection ---------------------------------------------------------------------------------------------------


def check_events(frames, history):
    """Both sides of every event are there, and told apart."""
    for event in {event.time for event in history.events}:
        (n,) = np.flatnonzero(frames.time == event)
        assert frames.sample[n + 1] == frames.sample[n] + 1
        assert frames.time[n + 1] == np.nextafter(event, np.inf)
        assert frames.side[n : n + 2].tolist() == [-1, 1]


@pytest.mark.parametrize("case", [("paper",), ("sticking",), ("elastic-stop", "end_time=0.4"), ("spin-up",)])
@pytest.mark.parametrize("every", [None, 7, 10**9])
def test_every_event_is_kept_under_any_decimation(run, case, every):
    history = run(*case)
    frames, time = Selection(every).frames(history), history["time"].values
    check_events(frames, history)
    assert np.all(np.diff(frames.time) > 0.0)
    assert frames.sample[[0, -1]].tolist() == [0, time.size - 1]
    if every:
        left = np.flatnonzero(np.isin(time, [event.time for event in history.events])).tolist()
        wanted = {*range(0, time.size, every), *left, *(k + 1 for k in left), time.size - 1}
        assert set(frames.sample.tolist()) == wanted
    else:  # about a thousand, evenly in time
        assert FRAMES <= frames.sample.size <= FRAMES + 2 * len(history.events) + 1
        apart = (frames.time[-1] - frames.time[0]) / (FRAMES - 1)
        assert np.diff(frames.time).max() <= apart + np.diff(time).max() + 1e-12


def test_spans_and_surroundings(run):
    history = run("paper")
    time, events = history["time"].values, np.array([event.time for event in history.events])
    assert FRAMES <= Selection(between=(0.2, 0.4)).frames(history).sample.size < FRAMES + 50
    assert Selection(between=(time[100], time[200])).frames(history).sample.tolist() == list(range(100, 201))
    assert Selection(between=(events[0], events[0] + 1e-4)).frames(history).side[:2].tolist() == [-1, 1]
    near = Selection(around_events=0.02).frames(history)
    assert FRAMES <= near.sample.size < FRAMES + 50
    assert np.sum(np.diff(near.time) > 0.005) == 2  # three collisions, each with frames as its time asks for
    found = Selection(around_events=2e-3).frames(history).sample
    assert found.tolist() == np.flatnonzero(np.abs(time[:, None] - events).min(axis=1) <= 2e-3).tolist()
    assert Selection(around_events=0.0).frames(history).sample.size == 2 * events.size  # both sides are at it


def test_what_has_no_finite_shape_is_left_out(run):
    """As the last sample of a run that diverged; results that are not finite do not matter."""
    data = run("paper").data.isel(time=slice(0, 8)).copy(deep=True)
    data["uy"][7, 3] = data["moment"][6] = np.nan
    scene = scene_of(replace(run("paper"), data=data, contacts=[]), Selection())
    assert scene.frames.sample.tolist() == list(range(7))
    assert np.all(np.isnan(scene.parts[0].shape(6).arrays["bending_moment"]))


def test_both_sides_of_a_jump_are_kept_without_an_event(run):
    """As at the end of a run that the physics stops at an instant."""
    history = run("paper")
    data = history.data.isel(time=[*range(10), 9])
    stopped = replace(history, data=data.assign_coords(time=ascending(data["time"].values)))
    frames = Selection(10**9).frames(stopped)
    assert (frames.sample.tolist(), frames.side.tolist()) == ([0, 9, 10], [0, -1, 1])
    assert sides(ascending(np.array([0.0, 0.0, 0.0, 0.1, 0.1, 0.3]))).tolist() == [-1, 1, 1, -1, 1, 0]


def test_senseless_selections_are_one_line(run):
    for options, word in (
        ({"every": 0}, "--every"),
        ({"between": (0.5, 0.5)}, "--between"),
        ({"between": (0.0, np.inf)}, "--between"),
        ({"around_events": np.nan}, "--around-events"),
        ({"between": (2.0, 3.0)}, "covers 0 to 1 s"),
        ({"between": (0.0, 0.1), "around_events": 0.01}, "--around-events"),
    ):
        with pytest.raises(InputError, match=word) as refused:
            Selection(**options).frames(run("paper"))
        assert "\n" not in str(refused.value)
    with pytest.raises(InputError, match="no events"):
        Selection(around_events=0.1).frames(run("spin-up"))


# Files -------------------------------------------------------------------------------------------------------


def size_of(folder):
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def test_the_size_said_beforehand_is_right_within_a_fifth(run, tmp_path, format):
    """Files hold more than they seem at rest, where much is 0: the trial takes frames from the whole run."""
    history = run("paper", "end_time=0.34")
    job = _Job.of(history, tmp_path / f"beam.{format}", None, Selection(50), 1.0)
    count, total = job.scene.frames.sample.size, history["time"].size
    said = job.forecast(thinned=True)
    assert list(tmp_path.iterdir()) == []
    job.write(lambda progress: None)
    words = said.split(" ")
    assert words[:3] == [f"{count}", "frames,", "about"]
    assert float(words[3]) == pytest.approx(size_of(tmp_path) / 1e6, rel=0.2)
    assert words[4:8] == ["MB", "(--all:", f"{total}", "frames,"]
    assert float(words[8]) == pytest.approx(float(words[3]) * total / count, rel=0.3)


def test_what_holds_for_all_frames_is_written_once(scene, run, tmp_path, format):
    """Topology, slope and pin, the table of events, however many frames there are."""
    path, count = write(scene, tmp_path / f"beam.{format}"), scene.frames.sample.size
    if format == "pvd":
        assert sorted(p.name for p in tmp_path.iterdir()) == ["beam", "beam.pvd"]
        assert len(list((tmp_path / "beam").iterdir())) == 4 * count + 2
        assert b"vtkZLibDataCompressor" in (tmp_path / "beam" / "surface_000000.vtp").read_bytes()
        return
    with h5py.File(tmp_path / ("beam.h5" if format == "xdmf" else path.name)) as file:
        if format == "xdmf":
            assert set(file["pin"]) == {"topology", "part", "000000"}
            assert len(file["surface"]) == 2 + count
            return
        root = file["VTKHDF"]
        assert root["Steps/Values"].dtype == np.float64
        cells, size = root["NumberOfCells"][0], root["NumberOfPoints"][0]
        packed = sum(part.cells.size for part in scene.parts)
        assert root["Connectivity"].size + cells == packed
        assert not np.any(root["Steps/CellOffsets"])
        assert root["Points"].shape == (count * size, 3)
        assert {n: d.attrs["units"].partition(",")[0] for n, d in root["PointData"].items() if n != "state"} == {
            name: unit
            for unit, names in UNITS.items()
            for name in names
            if name in set(root["PointData"]) - {"state"}
        }


def test_xdmf_refers_to_the_file_beside_it(scene, tmp_path):
    """Also after a move."""
    (tmp_path / "first").mkdir()
    write(scene, tmp_path / "first" / "beam.xdmf")
    (tmp_path / "first").rename(tmp_path / "second")
    assert sorted(p.name for p in (tmp_path / "second").iterdir()) == ["beam.h5", "beam.xdmf"]
    assert len(read(tmp_path / "second" / "beam.xdmf")) == scene.frames.sample.size
    assert str(tmp_path) not in (tmp_path / "second" / "beam.xdmf").read_text()


def contents(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_two_exports_are_the_same_and_an_interrupted_one_leaves_what_was_there(scene, tmp_path, format):
    def interrupt():
        nonlocal count
        count += 1
        if count == 5:
            raise KeyboardInterrupt

    found = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        count = 0
        with pytest.raises(KeyboardInterrupt):
            WRITERS[format](scene, tmp_path / name / f"beam.{format}", interrupt)
        assert list((tmp_path / name).iterdir()) == []
        write(scene, tmp_path / name / f"beam.{format}")
        found.append(contents(tmp_path / name))
    assert found[0] == found[1]
    count = 0
    with pytest.raises(KeyboardInterrupt):
        WRITERS[format](scene, tmp_path / "a" / f"beam.{format}", interrupt)
    assert contents(tmp_path / "a") == found[0]


def test_what_a_killed_export_left_is_cleared_by_the_next(scene, tmp_path, format):
    target, beside = tmp_path / f"beam.{format}", {"pvd": "beam.part", "xdmf": "beam.h5.part"}
    (tmp_path / f"{target.name}.part").write_bytes(b"half")
    if format in beside:
        (tmp_path / beside[format]).mkdir()
    write(scene, target)
    assert [path.name for path in tmp_path.iterdir() if path.name.endswith(".part")] == []


def test_files_of_others_are_not_replaced(scene, tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "history.nc").write_bytes(b"precious")
    with pytest.raises(InputError, match=r"history\.nc"):
        write(scene, tmp_path / "run.pvd")
    (tmp_path / "mesh.h5").write_bytes(b"precious")
    with pytest.raises(InputError, match=r"mesh\.h5"):
        write(scene, tmp_path / "mesh.xdmf")
    assert set(contents(tmp_path).values()) == {b"precious"}


@pytest.mark.slow
def test_memory_stays_flat(run, tmp_path, format):
    """Ten times the frames, the same memory: the peak of the whole process, VTK and HDF5 included."""
    source = run("paper", "end_time=0.34").save(tmp_path / "run")
    peaks = []
    for every in ("20", "2"):
        words = [sys.executable, "-m", "oblique_impact", "export", source, "--out", tmp_path / f"beam.{format}"]
        process = subprocess.Popen([*words, "--every", every], stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        assert process.returncode == 0
        peaks.append(usage.ru_maxrss / 1024.0)
    assert peaks[1] < peaks[0] + 20.0  # MB; the frames of the longer one take 300 MB

"""Exported time series, read back by the readers of others and held against the history."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import pyvista as pv

from oblique_impact import InputError
from oblique_impact.history.provenance import described, provenance
from oblique_impact.history.sample_times import ascending, shifted
from renders.exports import pvd, vtkhdf, xdmf
from renders.exports.command import _Job
from renders.exports.scene import FRAME_QUANTITIES, RESULTS, Scene, static_part
from renders.exports.selection import FRAMES, Selection, sides
from renders.geometry import BETWEEN, SIDES, BeamGeometry
from renders.scenery import pin, slope_wedge
from tests.render.export_readers import read, read_xdmf_by_vtk

WRITERS = {"pvd": pvd.write, "vtkhdf": vtkhdf.write, "xdmf": xdmf.write}
EVERY = 500
BEAM = ("surface", "centreline", "reference")


@pytest.fixture(scope="module")
def scene(run):
    history = run("paper")
    return Scene.of(BeamGeometry(history, 1.0), Selection(EVERY).frames(history))


#: reading what the others wrote takes many times as long; what does not depend on the format is quick for one
ONE = pytest.mark.parametrize(
    "format",
    [pytest.param(name, marks=[] if name == "pvd" else [pytest.mark.slow]) for name in WRITERS],
    indirect=True,
)


@pytest.fixture(
    scope="module", params=[pytest.param(n, marks=[pytest.mark.slow] if n == "xdmf" else []) for n in WRITERS]
)
def format(request):
    return request.param


@pytest.fixture(scope="module")
def exported(scene, format, tmp_path_factory):
    return write(scene, tmp_path_factory.mktemp(format) / f"beam.{format}")


@pytest.fixture(scope="module")
def frames(exported):
    return read(exported)


def write(scene, target):
    WRITERS[target.suffix[1:]](scene, target, lambda: None)
    return target


# Times ------------------------------------------------------------------------------------------------------


def test_times_are_exact_and_increase(frames, scene):
    stamps = np.array([frame.stamp for frame in frames])
    time = scene.geometry.history["time"].values[scene.frames.sample]
    assert np.all(np.diff(stamps) > 0.0)
    events = {event.time for event in scene.geometry.history.events}
    at = np.isin(stamps, list(events))
    assert at.sum() == len(events) == 21
    np.testing.assert_array_equal(stamps[np.roll(at, 1)], np.nextafter(stamps[at], np.inf))
    elsewhere = ~np.roll(at, 1)
    np.testing.assert_array_equal(stamps[elsewhere], time[elsewhere])


def test_field_data_tell_time_and_side(frames, scene):
    for frame, k in zip(frames, scene.frames.sample, strict=True):
        assert frame.fields["sample"] == k
        assert float(frame.fields["time"]) == frame.stamp
    side = np.array([frame.fields["side"] for frame in frames])
    events = {event.time for event in scene.geometry.history.events}
    left = np.array([frame.stamp in events for frame in frames])
    np.testing.assert_array_equal(side, np.where(left, -1, np.where(np.roll(left, 1), 1, 0)))


def test_both_sides_of_a_jump_differ(frames, scene):
    """The velocity jumps at the first impact, the points do not."""
    k = next(k for k, frame in enumerate(frames) if frame.fields["side"] == -1)
    before, after = frames[k].parts["surface"], frames[k + 1].parts["surface"]
    np.testing.assert_allclose(before.points, after.points, atol=1e-12)
    assert np.abs(before.arrays["velocity"] - after.arrays["velocity"]).max() > 1.0


# Values -----------------------------------------------------------------------------------------------------


def station_values(mesh, name, geometry, side):
    """Values at the stations on one generator of the tube."""
    values = mesh.arrays[name][: geometry.places.size * SIDES]
    return values.reshape(-1, SIDES, *values.shape[1:])[:: BETWEEN + 1, side]


def check_against_history(frame, k, geometry):
    """Results on the tube and the axis against the variables of the history, to rounding."""
    history = geometry.history
    tube, axis = frame.parts["surface"], frame.parts["centreline"]
    for name, variable in (("bending_moment", "moment"), ("shear_force", "shear"), ("axial_force", "axial_force")):
        expected = history[variable].values[k]
        scale = np.abs(history[variable].values).max()
        np.testing.assert_allclose(axis.arrays[name][:: BETWEEN + 1], expected, rtol=1e-12, atol=1e-14 * scale)
        np.testing.assert_allclose(
            station_values(tube, name, geometry, 5), expected, rtol=1e-12, atol=1e-14 * scale
        )
    stress = history["bending_stress"].values[k]  # at the fibre on the side of negative y
    scale = np.abs(history["bending_stress"].values).max()
    for side, sign in ((SIDES // 2, 1.0), (0, -1.0)):
        found = station_values(tube, "bending_stress", geometry, side)
        np.testing.assert_allclose(found, sign * stress, rtol=1e-11, atol=1e-13 * scale)
    normal = history["axial_force"].values[k] / geometry.sections.area(history["station"].values)
    found = station_values(tube, "axial_stress", geometry, SIDES // 2)
    np.testing.assert_allclose(found, stress + normal, rtol=1e-11, atol=1e-13 * scale)


def axis_of_history(history, k, radius):
    theta, x = history["theta"].values[k], radius + history["station"].values + history["ux"].values[k]
    y = history["uy"].values[k]
    return np.stack([x * np.cos(theta) - y * np.sin(theta), x * np.sin(theta) + y * np.cos(theta), 0 * x], axis=1)


def test_results_are_those_of_the_history(frames, scene):
    for frame, k in zip(frames, scene.frames.sample, strict=True):
        check_against_history(frame, k, scene.geometry)


@pytest.mark.parametrize("name", ["bending_stress", "axial_stress", "bending_moment"])
def test_an_error_of_a_fifth_is_found(frames, scene, name):
    k = int(np.argmax(np.abs(scene.geometry.history["moment"].values[scene.frames.sample]).max(axis=1)))
    frame = frames[k]
    parts = {
        part: replace(
            mesh, arrays=mesh.arrays | {name: 1.2 * mesh.arrays[name]} if name in mesh.arrays else mesh.arrays
        )
        for part, mesh in frame.parts.items()
    }
    check_against_history(frame, scene.frames.sample[k], scene.geometry)
    with pytest.raises(AssertionError):
        check_against_history(replace(frame, parts=parts), scene.frames.sample[k], scene.geometry)


def test_the_centreline_passes_through_the_stations(frames, scene):
    history = scene.geometry.history
    for frame, k in zip(frames, scene.frames.sample, strict=True):
        points = frame.parts["centreline"].points
        expected = axis_of_history(history, k, scene.geometry.scenario.root.hub_radius)
        np.testing.assert_allclose(points[:: BETWEEN + 1], expected, rtol=0.0, atol=1e-12)


def test_nothing_is_lost_on_the_way(frames, scene, format):
    """Points and results of all parts to the last bit; 0 where VTKHDF has to fill."""
    assert {part.name for part in scene.parts} == frames[0].parts.keys()
    for frame, k in zip(frames, scene.frames.sample, strict=True):
        for part in scene.parts:
            expected, found = part.shape(k), frame.parts[part.name]
            np.testing.assert_array_equal(found.points, expected.points)
            assert expected.arrays.keys() <= found.arrays.keys() <= RESULTS.keys()
            for name, values in found.arrays.items():
                assert values.dtype == np.float64
                np.testing.assert_array_equal(values, expected.arrays.get(name, np.zeros_like(values)))
                assert name in expected.arrays or format == "vtkhdf"


def test_no_result_is_nan(run, tmp_path, format):
    """Whatever the beam: free, sticking, on a spring, without contact."""
    for name in ("sticking", "elastic-stop", "spin-up"):
        history = run(name, *(["end_time=0.4"] if name != "spin-up" else []))
        scene = Scene.of(BeamGeometry(history, 1.0), Selection(10**6).frames(history))
        for frame in read(write(scene, tmp_path / f"{name}.{format}")):
            for mesh in frame.parts.values():
                assert np.all(np.isfinite(mesh.points))
                assert all(np.all(np.isfinite(values)) for values in mesh.arrays.values())


def check_displacement(frame, first, atol):
    """Of the initial tube alone, to where the tube is: in a sum of NumPy and in VTK's filter."""
    start, now = frame.parts["reference"], frame.parts["surface"]
    np.testing.assert_array_equal(start.points, first.parts["surface"].points)
    moved = start.arrays["displacement"]
    np.testing.assert_allclose(start.points + moved, now.points, rtol=0.0, atol=atol)
    mesh = pv.PolyData(start.points)
    mesh["displacement"] = moved
    np.testing.assert_allclose(mesh.warp_by_vector("displacement").points, now.points, rtol=0.0, atol=1e-12)


def test_warping_the_initial_shape_by_the_displacement_gives_the_deformed_one(frames):
    for frame in frames:
        check_displacement(frame, frames[0], 1e-15)
    moved = frames[-1].parts["reference"].arrays["displacement"]
    assert np.linalg.norm(moved, axis=1).max() > 0.1  # the beam has swung: this is no elastic displacement


@pytest.mark.parametrize("wrong", ["elastic", "from the last frame", "in mm"])
def test_another_displacement_is_found(frames, wrong):
    frame, last = frames[len(frames) // 2], frames[-1]
    start = frame.parts["reference"]
    moved = {
        "elastic": frame.parts["surface"].arrays["elastic_displacement"],
        "from the last frame": frame.parts["surface"].points - last.parts["surface"].points,
        "in mm": 1e3 * start.arrays["displacement"],
    }[wrong]
    planted = replace(start, arrays={"displacement": moved})
    with pytest.raises(AssertionError):
        check_displacement(replace(frame, parts=frame.parts | {"reference": planted}), frames[0], 1e-15)


def test_the_elastic_displacement_is_that_of_the_history(frames, scene):
    """In the floating frame, whose angle is theta."""
    history = scene.geometry.history
    for frame, k in zip(frames, scene.frames.sample, strict=True):
        theta = history["theta"].values[k]
        x, y, z = frame.parts["centreline"].arrays["elastic_displacement"][:: BETWEEN + 1].T
        c, s = np.cos(theta), np.sin(theta)
        np.testing.assert_allclose(c * x + s * y, history["ux"].values[k], rtol=0.0, atol=1e-15)
        np.testing.assert_allclose(-s * x + c * y, history["uy"].values[k], rtol=0.0, atol=1e-15)
        assert not np.any(z)


def check_contact(frame, k, history, angle):
    """The contact point's place, motion and forces against the history: power of the force from both sides."""
    point = frame.parts["contact_point"]
    value = {name: history[name].values[k] for name in history.data.data_vars if history[name].ndim == 1}
    assert (point.vertices, point.lines, point.polygons) == ([[0]], [], [])
    np.testing.assert_allclose(point.points, [[value["tip_x"], value["tip_y"], 0.0]], rtol=0.0, atol=1e-14)
    got = point.arrays
    np.testing.assert_array_equal(got["velocity"], [[value["tip_vx"], value["tip_vy"], 0.0]])
    for name in ("gap", "gap_rate", "slip_rate", "state"):
        np.testing.assert_array_equal(got[name], [value[name]])
    # out of the slope and up along it
    normal, along = np.array([-np.sin(angle), np.cos(angle), 0.0]), np.array([np.cos(angle), np.sin(angle), 0.0])
    np.testing.assert_allclose(got["normal_force"], [value["lambda_n"] * normal], rtol=1e-14, atol=1e-12)
    np.testing.assert_allclose(got["friction_force"], [value["lambda_tau"] * along], rtol=1e-14, atol=1e-12)
    np.testing.assert_array_equal(got["contact_force"], got["normal_force"] + got["friction_force"])
    power = value["lambda_n"] * value["gap_rate"] + value["lambda_tau"] * value["slip_rate"]
    assert float(np.sum(got["contact_force"] * got["velocity"])) == pytest.approx(power, rel=1e-9, abs=1e-9)


def test_the_contact_point_is_a_vertex_with_its_forces(frames, scene):
    history, angle = scene.geometry.history, scene.geometry.scenario.slope.angle
    touching = 0
    for frame, k in zip(frames, scene.frames.sample, strict=True):
        check_contact(frame, k, history, angle)
        touching += history["lambda_n"].values[k] > 1.0
    assert touching >= 10


@pytest.mark.parametrize("name", ["normal_force", "friction_force", "contact_force", "velocity", "slip_rate"])
def test_a_wrong_sign_at_the_contact_point_is_found(frames, scene, name):
    history, angle = scene.geometry.history, scene.geometry.scenario.slope.angle
    n = int(np.argmax(np.abs(history["lambda_tau"].values[scene.frames.sample])))
    point = frames[n].parts["contact_point"]
    planted = replace(point, arrays=point.arrays | {name: -point.arrays[name]})
    broken = replace(frames[n], parts=frames[n].parts | {"contact_point": planted})
    with pytest.raises(AssertionError):
        check_contact(broken, scene.frames.sample[n], history, angle)


def test_no_two_things_share_a_name(frames):
    parts = set(frames[0].parts)
    arrays = {name for mesh in frames[0].parts.values() for name in mesh.arrays}
    assert not parts & arrays
    assert not (parts | arrays) & set(frames[0].fields)


def test_cells(frames, scene, format):
    rings = scene.geometry.places.size
    chain = [[i, i + 1] for i in range(rings - 1)] if format == "xdmf" else [list(range(rings))]
    for frame in frames:
        assert frame.parts["centreline"].lines == chain
        assert frame.parts["centreline"].polygons == []
        tube = frame.parts["surface"]
        assert tube.lines == []
        flat = [value for cell in tube.polygons for value in (len(cell), *cell)]
        assert flat == scene.geometry.faces.tolist()


@ONE
def test_a_factor_magnifies_the_exported_shapes(run, tmp_path, format):
    history = run("paper")
    geometry, true_shapes = BeamGeometry(history, 5.0), BeamGeometry(history, 1.0)
    scene = Scene.of(geometry, Selection(5000).frames(history))
    for frame, k in zip(read(write(scene, tmp_path / f"a.{format}")), scene.frames.sample, strict=True):
        assert float(frame.fields["deformation_factor"]) == 5.0
        np.testing.assert_array_equal(frame.parts["surface"].points, geometry.surface(k).points)
        start = frame.parts["reference"]  # results are true ones
        true = true_shapes.surface(k).points
        np.testing.assert_allclose(start.points + start.arrays["displacement"], true, rtol=0.0, atol=1e-15)


# Field data -------------------------------------------------------------------------------------------------


def test_field_data_say_what_it_is(frames, scene):
    history = scene.geometry.history
    for frame in (frames[0], frames[len(frames) // 2], frames[-1]):
        fields = frame.fields
        assert fields["format"] == "oblique-impact export 2"
        assert fields["made_by"].startswith(described(provenance()))
        assert fields["scenario"] == history.scenario_toml
        assert fields["events"] == history.events_csv()
        assert float(fields["deformation_factor"]) == 1.0
        assert "next larger double" in fields["times"]
        assert fields["parts"].splitlines() == [f"{k} = {part.name}" for k, part in enumerate(scene.parts)]
        check_units(fields["units"], frame)


#: unit by unit what it must be, from the equations: a force per area is a stress, a moment is a force by an arm
UNITS = {
    "m": ["points", "elastic_displacement", "displacement", "gap"],
    "m/s": ["velocity", "gap_rate", "slip_rate"],
    "rad": ["section_rotation"],
    "N m": ["bending_moment"],
    "N": ["shear_force", "axial_force", "contact_force", "normal_force", "friction_force"],
    "Pa": ["bending_stress", "axial_stress"],
    "s": ["time"],
}


def check_units(text, frame):
    units = dict(line.split(" = ", 1) for line in text.splitlines())
    arrays = {name for mesh in frame.parts.values() for name in mesh.arrays}
    assert arrays <= units.keys()
    assert FRAME_QUANTITIES.keys() <= frame.fields.keys()
    assert units.keys() == {*RESULTS, *FRAME_QUANTITIES, "points"}
    assert {name: unit for unit, names in UNITS.items() for name in names} == {
        name: unit.partition(",")[0] for name, unit in units.items() if name not in ("side", "sample", "state")
    }
    assert units["state"] == "0 free, 1 slip, 2 stick"


def test_a_wrong_unit_is_found(frames):
    good = frames[0].fields["units"]
    for name in (name for names in UNITS.values() for name in names):
        line = next(line for line in good.splitlines() if line.startswith(f"{name} = "))
        with pytest.raises(AssertionError):
            check_units(good.replace(line, f"{name} = mm"), frames[0])


# Formats ----------------------------------------------------------------------------------------------------


def test_vtkhdf_holds_the_topology_once_and_times_in_double_precision(scene, tmp_path):
    path = write(scene, tmp_path / "beam.vtkhdf")
    count = scene.frames.sample.size
    with h5py.File(path) as file:
        root = file["VTKHDF"]
        assert root["Steps/Values"].dtype == np.float64
        np.testing.assert_array_equal(root["Steps/Values"], scene.frames.time)
        cells = root["NumberOfCells"][0]
        packed = sum(part.polygons.size + part.lines.size + part.vertices.size for part in scene.parts)
        assert root["Connectivity"].size + cells == packed
        assert root["Offsets"].size == cells + 1
        assert not np.any(root["Steps/CellOffsets"])
        assert not np.any(root["Steps/ConnectivityIdOffsets"])
        size = root["NumberOfPoints"][0]
        assert root["Points"].shape == (count * size, 3)
        assert root["PointData/bending_stress"].attrs["units"] == "Pa"


def test_pvd_frames_are_compressed_and_lie_beside(scene, tmp_path):
    path = write(scene, tmp_path / "beam.pvd")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["beam", "beam.pvd"]
    files = list((tmp_path / "beam").iterdir())
    assert len(files) == 4 * scene.frames.sample.size + 2  # slope and pin once
    assert b"vtkZLibDataCompressor" in (tmp_path / "beam" / "surface_000000.vtp").read_bytes()
    assert 'file="beam/surface_000000.vtp"' in path.read_text()


def test_xdmf_refers_to_the_file_beside_it(scene, tmp_path, monkeypatch):
    """Also from another folder, where meshio would leave its numbers; and after a move."""
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (tmp_path / "first").mkdir()
    monkeypatch.chdir(elsewhere)
    path = write(scene, tmp_path / "first" / "beam.xdmf")
    assert list(elsewhere.iterdir()) == []
    assert sorted(p.name for p in path.parent.iterdir()) == ["beam.h5", "beam.xdmf"]
    path.parent.rename(tmp_path / "second")
    assert len(read(tmp_path / "second" / "beam.xdmf")) == scene.frames.sample.size
    assert str(tmp_path) not in (tmp_path / "second" / "beam.xdmf").read_text()
    with h5py.File(tmp_path / "second" / "beam.h5") as file:
        assert sum("topology" in name for name in file["surface"]) == 1


def test_xdmf_through_vtk(scene, tmp_path, capfd):
    """VTK's reader takes times less than 1e-7 s apart for one: it returns both sides of a jump, and no warning."""
    found = read_xdmf_by_vtk(write(scene, tmp_path / "beam.xdmf"))
    np.testing.assert_array_equal([stamp for stamp, _ in found], scene.frames.time)
    for (stamp, blocks), k in zip(found, scene.frames.sample, strict=True):
        near = scene.frames.sample[np.abs(scene.frames.time - stamp) <= 1e-7]
        assert k in near
        for name, shape in (("surface", scene.geometry.surface), ("centreline", None)):
            assert len(blocks[name]) == len(near)
            for mesh, sample in zip(blocks[name], near, strict=True):
                points = shape(sample).points if shape else scene.geometry.centreline(sample)
                np.testing.assert_array_equal(mesh.points, points)
        for mesh, sample in zip(blocks["surface"], near, strict=True):
            stress = scene.geometry.surface(sample).arrays["bending_stress"]
            np.testing.assert_array_equal(mesh.point_data["bending_stress"], stress)
    assert capfd.readouterr().err == ""


def test_pyvista_reads_the_shape_and_the_force_at_a_time(exported, scene, format):
    """As a user calls it; of the three, its reader of VTKHDF alone has no times: VTK's steps take their place."""
    n = int(np.argmax(scene.geometry.history["lambda_n"].values[scene.frames.sample]))
    reader = pv.get_reader(str(exported))
    if format == "vtkhdf":
        assert not hasattr(reader, "time_values")
        assert reader.reader.GetNumberOfSteps() == scene.frames.time.size
        reader.reader.SetStep(n)
        mesh = reader.read()
        assert mesh.field_data["time"][0] == scene.frames.time[n]
        blocks = [mesh.extract_cells(mesh["part"] == number) for number in range(len(scene.parts))]
    else:
        np.testing.assert_array_equal(reader.time_values, scene.frames.time)
        reader.set_active_time_value(reader.time_values[n])
        blocks = list(reader.read())
        if format == "xdmf":  # from last to first; at a jump both sides
            blocks = [block[-1] if isinstance(block, pv.MultiBlock) else block for block in reversed(blocks)]
    for number, (block, part) in enumerate(zip(blocks, scene.parts, strict=True)):
        expected = part.shape(int(scene.frames.sample[n]))
        assert set(block["part"]) == {number}
        np.testing.assert_array_equal(block.points, expected.points)
        for name, values in expected.arrays.items():
            np.testing.assert_array_equal(block.point_data[name], values)


def test_slope_and_pin_stand_in_every_frame(frames, scene):
    assert set(frames[0].parts) == {*BEAM, "contact_point", "slope", "pin"}
    for name, mesh in (("slope", slope_wedge(scene.geometry)), ("pin", pin(scene.geometry))):
        expected = mesh.triangulate()
        for frame in frames:
            np.testing.assert_array_equal(frame.parts[name].points, expected.points)
            assert frame.parts[name].polygons == expected.regular_faces.tolist()
            assert not any(np.any(values) for values in frame.parts[name].arrays.values())


def test_what_stands_still_is_written_once(scene, tmp_path):
    write(scene, tmp_path / "beam.pvd")
    assert len(list((tmp_path / "beam").glob("slope_*.vtp"))) == 1
    write(scene, tmp_path / "beam.xdmf")
    with h5py.File(tmp_path / "beam.h5") as file:
        assert set(file["pin"]) == {"topology", "part", "000000"}
        assert len(file["surface"]) == 2 + scene.frames.sample.size


@ONE
def test_a_part_more(scene, tmp_path, format):
    mesh = pv.Disc(c_res=7)
    more = replace(scene, parts=(*scene.parts, static_part("disc", mesh)))
    for frame in read(write(more, tmp_path / f"beam.{format}")):
        np.testing.assert_array_equal(frame.parts["disc"].points, mesh.points)
        assert set(frame.parts) == {*BEAM, "contact_point", "slope", "pin", "disc"}


def test_without_contact_there_is_no_slope(run, tmp_path, format):
    history = run("spin-up")
    scene = Scene.of(BeamGeometry(history, 1.0), Selection(1000).frames(history))
    frames = read(write(scene, tmp_path / f"beam.{format}"))
    assert set(frames[0].parts) == {*BEAM, "pin"}
    check_against_history(frames[1], scene.frames.sample[1], scene.geometry)


@ONE
@pytest.mark.parametrize("name", ["tapered", "elastic-stop"])
def test_other_beams(run, tmp_path, format, name):
    history = run(name, *(["end_time=0.34"] if name == "tapered" else ["end_time=0.4"]))
    # of some eighty events of the tapered beam the first ones are enough
    span = (0.31, 0.3182) if name == "tapered" else None
    scene = Scene.of(BeamGeometry(history, 1.0), Selection(2000, span).frames(history))
    assert scene.frames.sample.size > 8
    frames = read(write(scene, tmp_path / f"beam.{format}"))
    for frame, k in zip(frames, scene.frames.sample, strict=True):
        check_against_history(frame, k, scene.geometry)


@ONE
def test_a_run_that_physics_stopped(run, tmp_path, format):
    history = run("paper", "discretization.modes=8")
    assert history.outcome.exit_code == 1
    scene = Scene.of(BeamGeometry(history, 1.0), Selection(500).frames(history))
    frames = read(write(scene, tmp_path / f"beam.{format}"))
    assert frames[-1].fields["time"] == history["time"].values[-1]


# Selection --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["paper", "bouncing", "sticking", "elastic-stop", "spin-up"])
@pytest.mark.parametrize("every", [1, 7, 1000, 10**9])
def test_every_event_is_kept_under_any_decimation(run, name, every):
    history = run(name, *(["end_time=0.4"] if name == "elastic-stop" else []))
    frames, time = Selection(every).frames(history), history["time"].values
    check_events(frames, history)
    wanted = {k for k in range(time.size) if k % every == 0 or k in at_events(history)} | {time.size - 1}
    assert set(frames.sample.tolist()) == wanted
    assert np.all(np.diff(frames.time) > 0.0)


def at_events(history):
    """Samples at events, and those right of a jump: that after the one of the event's time."""
    left = np.flatnonzero(np.isin(history["time"].values, [event.time for event in history.events]))
    return {*left.tolist(), *(left + 1).tolist()}


def check_events(frames, history):
    for event in {event.time for event in history.events}:
        (n,) = np.flatnonzero(frames.time == event)
        assert frames.sample[n + 1] == frames.sample[n] + 1
        assert frames.time[n + 1] == np.nextafter(event, np.inf)
        assert frames.side[n : n + 2].tolist() == [-1, 1]


@pytest.mark.parametrize("name", ["paper", "bouncing", "elastic-stop"])
def test_about_a_thousand_frames_by_default_evenly_and_at_events(run, name):
    history = run(name, *(["end_time=0.4"] if name == "elastic-stop" else []))
    frames, events = Selection().frames(history), {event.time for event in history.events}
    check_events(frames, history)
    assert FRAMES <= frames.sample.size <= FRAMES + 2 * len(events) + 1
    apart = (frames.time[-1] - frames.time[0]) / (FRAMES - 1)
    assert np.diff(frames.time).max() <= apart + np.diff(history["time"].values).max() + 1e-12
    assert (frames.sample[0], frames.sample[-1]) == (0, history["time"].size - 1)


def test_a_default_export_of_a_span_has_a_thousand_frames_there(run):
    history = run("paper")
    assert FRAMES <= Selection(between=(0.2, 0.4)).frames(history).sample.size < FRAMES + 50
    short = Selection(between=(0.2, 0.21)).frames(history)
    assert short.sample.size == np.sum((history["time"].values >= 0.2) & (history["time"].values <= 0.21))
    near = Selection(around_events=0.02).frames(history)
    assert FRAMES <= near.sample.size < FRAMES + 50
    gaps = np.diff(near.time)
    assert np.sum(gaps > 0.005) == 2  # three collisions, each with as many frames as its time asks for


def test_ten_thousand_events(run):
    """As of a beam that bounces for long: all of them, and a thousand frames between them."""
    times = np.sort(np.random.default_rng(7).uniform(0.0, 10.0, 10_000))
    grid = np.arange(100_001) * 1e-4
    time = np.sort(np.concatenate([grid, times, np.nextafter(times, np.inf)]))
    base = run("paper")
    data = base.data[["theta", "ux", "uy"]].isel(time=np.zeros(time.size, dtype=int)).assign_coords(time=time)
    events = [base.events[0]._replace(time=t) for t in times.tolist()]
    frames = Selection().frames(replace(base, data=data, events=events))
    assert 20_000 + 900 <= frames.sample.size <= 20_000 + FRAMES
    assert np.sum(frames.side == -1) == np.sum(frames.side == 1) == 10_000


def test_what_has_no_finite_shape_is_left_out(run, tmp_path, format):
    """As the last sample of a run that diverged; results that are not finite do not matter."""
    history = run("paper")
    data = history.data.isel(time=slice(0, 8)).copy(deep=True)
    data["uy"][7, 3] = np.nan
    data["moment"][6] = np.nan
    broken = replace(history, data=data)
    scene = Scene.of(BeamGeometry(broken, 1.0), Selection().frames(broken))
    frames = read(write(scene, tmp_path / f"beam.{format}"))
    assert [frame.stamp for frame in frames] == list(data["time"].values[:7])
    assert np.all(np.isnan(frames[6].parts["surface"].arrays["bending_moment"]))


def test_both_sides_of_a_jump_are_kept_without_an_event(run):
    """As at the end of a run that the physics stops at an instant."""
    history = run("paper")
    data = history.data.isel(time=[*range(10), 9])
    stopped = replace(history, data=data.assign_coords(time=ascending(data["time"].values)))
    frames = Selection(10**9).frames(stopped)
    assert frames.sample.tolist() == [0, 9, 10]
    assert frames.side.tolist() == [0, -1, 1]
    assert frames.time[2] == np.nextafter(frames.time[1], np.inf)


def test_a_single_frame(run, tmp_path, format):
    """VTK gives no time for a single step of VTKHDF; its points and fields are there."""
    history = run("paper")
    scene = Scene.of(BeamGeometry(history, 1.0), Selection(between=(0.0, 1e-5)).frames(history))
    assert scene.frames.sample.tolist() == [0]
    path = write(scene, tmp_path / f"beam.{format}")
    mesh = pv.HDFReader(str(path)).read() if format == "vtkhdf" else read(path)[0].parts["surface"]
    np.testing.assert_array_equal(mesh.points[:1682], scene.geometry.surface(0).points)


def test_between_includes_its_ends(run):
    history = run("paper")
    time = history["time"].values
    frames = Selection(between=(time[100], time[200])).frames(history)
    assert frames.sample.tolist() == list(range(100, 201))
    impact = history.events[0].time
    at = Selection(between=(impact, impact + 1e-4)).frames(history)
    assert at.side[:2].tolist() == [-1, 1]


def test_around_events(run):
    history = run("paper")
    time, events = history["time"].values, np.array([event.time for event in history.events])
    frames = Selection(around_events=2e-3).frames(history)
    near = np.abs(time[:, None] - events).min(axis=1) <= 2e-3
    assert frames.sample.tolist() == np.flatnonzero(near).tolist()
    assert 42 < frames.sample.size < time.size
    exactly = Selection(around_events=0.0).frames(history)  # both sides are at the event
    assert exactly.sample.size == 2 * events.size
    decimated = Selection(every=10, around_events=2e-3).frames(history)
    assert set(exactly.sample) <= set(decimated.sample) <= set(frames.sample)


def test_sides_of_jumps_are_told_by_the_times():
    times = ascending(np.array([0.0, 0.0, 0.0, 0.1, 0.1, 0.3]))
    assert sides(times).tolist() == [-1, 1, 1, -1, 1, 0]
    assert sides(np.array([0.1, 0.2])).tolist() == [0, 0]


def test_an_impact_at_the_start(run, tmp_path, format):
    """The right side of t = 0 carries the smallest number above it; readers tell the two apart."""
    from oblique_impact.history.history import History

    history = run("paper")
    first = int(np.flatnonzero(history["time"].values == history.events[0].time)[0])
    data = history.data.isel(time=slice(first, first + 60))
    data = data.assign_coords(time=shifted(data["time"].values, -history.events[0].time))
    events = [history.events[0]._replace(time=0.0)]
    moved = History(data, events, history.summary, history.scenario_toml)
    scene = Scene.of(BeamGeometry(moved, 1.0), Selection(30).frames(moved))
    frames = read(write(scene, tmp_path / f"beam.{format}"))
    assert [frame.stamp for frame in frames[:2]] == [0.0, np.nextafter(0.0, 1.0)]
    assert [frame.fields["side"] for frame in frames[:2]] == [-1, 1]


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"every": 0}, "--every"),
        ({"between": (0.5, 0.5)}, "--between"),
        ({"between": (0.5, 0.1)}, "--between"),
        ({"between": (0.0, np.inf)}, "--between"),
        ({"around_events": -1.0}, "--around-events"),
        ({"around_events": np.nan}, "--around-events"),
    ],
)
def test_senseless_selections_are_refused(options, word):
    with pytest.raises(InputError, match=word):
        Selection(**options)


def test_selections_of_nothing_are_refused(run):
    with pytest.raises(InputError, match="covers 0 to 1 s"):
        Selection(between=(2.0, 3.0)).frames(run("paper"))
    with pytest.raises(InputError, match="no events"):
        Selection(around_events=0.1).frames(run("spin-up"))
    with pytest.raises(InputError, match="--around-events"):
        Selection(between=(0.0, 0.1), around_events=0.01).frames(run("paper"))


# Size -------------------------------------------------------------------------------------------------------


@ONE
@pytest.mark.parametrize("name", ["paper", "elastic-stop"])
def test_the_size_said_beforehand_is_right_within_a_fifth(run, tmp_path, format, name):
    """Files hold more than they seem at rest, where much is 0: the trial takes frames from the whole run."""
    history = run(name, "end_time=0.4")
    for every in (30, 300):
        job = _Job.of(history, tmp_path / f"{every}" / f"beam.{format}", None, Selection(every), 1.0)
        fixed, each = job._trial()
        size = job.write(lambda progress: None).file.parent
        written = sum(path.stat().st_size for path in size.rglob("*") if path.is_file())
        assert fixed + each * job.scene.frames.sample.size == pytest.approx(written, rel=0.2)


def test_the_forecast_names_frames_and_size_and_what_all_would_take(run, tmp_path):
    history = run("paper", "end_time=0.4")
    job = _Job.of(history, tmp_path / "beam.pvd", None, Selection(1000), 1.0)
    fixed, each = job._trial()
    count, total = job.scene.frames.sample.size, history["time"].size
    said = f"{count} frames, about {(fixed + count * each) / 1e6:.3g} MB"
    assert job.forecast(thinned=False) == said
    assert job.forecast(thinned=True) == f"{said} (--all: {total} frames, {(fixed + total * each) / 1e6:.3g} MB)"
    assert list(tmp_path.iterdir()) == []


def test_many_events_do_not_swell_every_frame(run, tmp_path, format):
    """The table of events is written once, however many frames there are."""
    base = run("paper", "end_time=0.4")
    many = replace(base, events=[base.events[0]] * 10_000)
    sizes = []
    for history in (base, many):
        job = _Job.of(history, tmp_path / f"{len(history.events)}.{format}", None, Selection(10**6), 1.0)
        sizes.append(job._trial()[1])
    assert sizes[1] == pytest.approx(sizes[0], rel=0.05)


# Interruption -----------------------------------------------------------------------------------------------


def test_an_exception_leaves_nothing_and_what_was_there(scene, tmp_path, format):
    target = tmp_path / f"beam.{format}"
    count = 0

    def interrupt():
        nonlocal count
        count += 1
        if count == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        WRITERS[format](scene, target, interrupt)
    assert list(tmp_path.iterdir()) == []
    write(scene, target)
    before = {p: p.read_bytes() for p in tmp_path.rglob("*") if p.is_file()}
    count = 0
    with pytest.raises(KeyboardInterrupt):
        WRITERS[format](scene, target, interrupt)
    assert {p: p.read_bytes() for p in tmp_path.rglob("*") if p.is_file()} == before


#: kills itself at the n-th of all the instants at which the state of the disk changes, for n = 1, 2, ...
KILLED = """
import os, shutil, signal, sys
from pathlib import Path
from oblique_impact import History
from renders.exports.command import _write
from renders.exports.scene import Scene
from renders.exports.selection import Selection
from renders.geometry import BeamGeometry

source, folder, format = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3]
history = History.load(source)
geometry = BeamGeometry(history, 1.0)
old = Scene.of(geometry, Selection(between=(0.0, 1e-3)).frames(history))
new = Scene.of(geometry, Selection(between=(0.0, 5e-4)).frames(history))

def export(place, deadline):
    passed = 0
    def pass_instant():
        nonlocal passed
        passed += 1
        if passed == deadline:
            os.kill(os.getpid(), signal.SIGKILL)
    def watched(function):
        def call(*args, **kwargs):
            pass_instant()
            result = function(*args, **kwargs)
            pass_instant()
            return result
        return call
    os.replace, shutil.rmtree, Path.unlink = map(watched, (os.replace, shutil.rmtree, Path.unlink))
    _write(new, place / f"beam.{format}", format, pass_instant)

first = folder / "000"
first.mkdir()
_write(old, first / f"beam.{format}", format, lambda: None)
for deadline in range(1, 200):
    place = folder / f"{deadline:03d}"
    shutil.copytree(first, place)
    child = os.fork()
    if not child:
        export(place, deadline)
        os._exit(0)
    if os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) != -signal.SIGKILL:
        break
"""


@ONE
def test_killed_at_any_instant_the_file_is_absent_or_complete(run, tmp_path, format):
    """One of six frames overwrites one of eleven: the readers find one of the two, or none."""
    source = run("paper").save(tmp_path / "run")
    places = tmp_path / "places"
    places.mkdir()
    subprocess.run([sys.executable, "-c", KILLED, source, places, format], check=True, timeout=120)
    folders = sorted(places.iterdir())
    counts = []
    for folder in folders:
        target = folder / f"beam.{format}"
        if target.exists():
            frames = read(target)
            counts.append(len(frames))
            assert all(np.all(np.isfinite(f.parts["surface"].points)) for f in frames)
            assert all(len(f.parts["surface"].points) > 1000 for f in frames)
        else:
            counts.append(0)
    assert len(folders) > 10
    assert set(counts) <= {0, 6, 11}
    assert counts[0] == 11
    assert counts[-1] == 6
    assert sorted(counts, key=[11, 0, 6].index) == counts
    assert {p.name for p in folders[-1].iterdir()} <= {"beam", "beam.h5", f"beam.{format}"}


def test_what_a_killed_export_left_is_cleared_by_the_next(scene, tmp_path, format):
    (tmp_path / f"beam.{format}.part").write_bytes(b"half")
    (tmp_path / "beam.h5.part").write_bytes(b"half")
    (tmp_path / "beam.part").mkdir()
    (tmp_path / "beam.part" / "surface_000000.vtp").write_bytes(b"half")
    write(scene, tmp_path / f"beam.{format}")
    left = {p.name for p in tmp_path.iterdir() if p.name.endswith(".part")}
    assert (
        left == {"pvd": {"beam.h5.part"}, "xdmf": {"beam.part"}, "vtkhdf": {"beam.h5.part", "beam.part"}}[format]
    )


def test_files_of_others_are_not_replaced(scene, tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "history.nc").write_bytes(b"precious")
    with pytest.raises(InputError, match=r"history\.nc"):
        write(scene, tmp_path / "run.pvd")
    (tmp_path / "mesh.h5").write_bytes(b"precious")
    with pytest.raises(InputError, match=r"mesh\.h5"):
        write(scene, tmp_path / "mesh.xdmf")
    assert (tmp_path / "run" / "history.nc").read_bytes() == (tmp_path / "mesh.h5").read_bytes() == b"precious"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mesh.h5", "run"]


def test_two_exports_are_the_same_to_the_byte(scene, tmp_path, format):
    found = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        write(scene, tmp_path / name / f"beam.{format}")
        files = sorted(p for p in (tmp_path / name).rglob("*") if p.is_file())
        found.append({p.relative_to(tmp_path / name): p.read_bytes() for p in files})
    assert found[0] == found[1]


@pytest.mark.slow
def test_memory_stays_flat(run, tmp_path, format):
    """Ten times the frames, the same memory: the peak of the whole process, VTK and HDF5 included."""
    source = run("paper").save(tmp_path / "run")
    peaks = []
    for every in ("20", "2"):
        arguments = ["export", source, "--out", tmp_path / f"beam.{format}", "--every", every]
        process = subprocess.Popen([sys.executable, "-m", "oblique_impact", *arguments], stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        assert process.returncode == 0
        peaks.append(usage.ru_maxrss / 1024.0)
    assert peaks[1] < peaks[0] + 20.0  # MB; the frames of the longer one take 1000 MB


def test_the_package_is_shipped():
    import tomllib

    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())
    assert "renders.exports" in project["tool"]["setuptools"]["packages"]

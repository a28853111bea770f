"""Exports in the ParaView of the distribution, as its own Python reads, warps and glyphs them."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from oblique_impact.renders import export
from oblique_impact.renders.exports.command import _write
from oblique_impact.renders.exports.scene import Scene
from oblique_impact.renders.exports.selection import Selection
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style

PVPYTHON = shutil.which("pvpython")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not PVPYTHON, reason="no ParaView: pvpython is not there (Debian: python3-paraview)"),
]
SESSION = Path(__file__).with_name("paraview_session.py")
READERS = {"PVDReader": "pvd", "Xdmf3ReaderS": "xdmf", "Xdmf3ReaderT": "xdmf", "XDMFReader": "xdmf"}


@pytest.fixture(scope="module")
def scene(run):
    history = run("paper", "end_time=0.34")
    return Scene.of(story_of([history], Style(deformation=1.0)), Selection(100).frames(history))


@pytest.fixture(scope="module")
def sampled(scene):
    """Frames of a jump's two sides, of the largest force, and the last."""
    force = scene.geometry.history["lambda_n"].values[scene.frames.sample]
    left = int(np.argmin(scene.frames.side))
    return [left, left + 1, int(np.argmax(force)), scene.frames.sample.size - 1]


def paraview(file, reader, frames):
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    command = [PVPYTHON, "--force-offscreen-rendering", SESSION, file, reader, *map(str, frames)]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, env=environment, timeout=300)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), done.stderr


@pytest.mark.parametrize("reader", READERS)
def test_paraview_reads_times_and_values(scene, sampled, tmp_path, reader):
    format = READERS[reader]
    file = tmp_path / f"beam.{format}"
    _write(scene, file, format, lambda: None)
    if reader == "XDMFReader":  # it returns both sides of a jump
        sampled = sampled[2:]
    found, errors = paraview(file, reader, sampled)
    assert errors == ""
    np.testing.assert_array_equal(found["times"], scene.frames.time)
    for meshes, number in zip(found["frames"], sampled, strict=True):
        by_part = {mesh["owners"][0]: mesh for mesh in meshes}
        assert sorted(by_part) == list(range(len(scene.parts)))
        for owner, part in enumerate(scene.parts):
            expected, mesh = part.shape(int(scene.frames.sample[number])), by_part[owner]
            np.testing.assert_array_equal(mesh["points"], expected.points)
            assert set(mesh["arrays"]) - {"position"} == set(expected.arrays)
            for name, array in expected.arrays.items():
                np.testing.assert_array_equal(np.array(mesh["arrays"][name]).reshape(array.shape), array)


@pytest.mark.parametrize("format", ["pvd", "xdmf"])
def test_the_state_beside_an_export_opens_it_in_colour_with_its_arrow(scene, sampled, tmp_path, display, format):
    """As `pvpython NAME.paraview.py` starts it, in another folder; the picture of the largest force."""
    out = tmp_path / "exported"
    out.mkdir()
    exported = export(scene.geometry.history, out / f"beam.{format}", every=100)
    moved = out.rename(tmp_path / "moved")
    state, picture = moved / exported.state.name, tmp_path / "a.png"
    time = float(scene.frames.time[sampled[2]])
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    environment["DISPLAY"] = display
    command = [PVPYTHON, str(state), str(picture), repr(time)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=300)
    assert done.returncode == 0, done.stderr
    assert "Error" not in done.stderr, done.stderr
    pixels = np.asarray(Image.open(picture).convert("RGB")).astype(int)
    red, green, blue = np.moveaxis(pixels, -1, 0)
    assert np.sum(pixels.min(axis=2) < 250) > 0.02 * red.size  # not blank
    assert np.sum((blue > red + 40) & (green < blue)) > 100  # compression
    assert np.sum((red > green + 60) & (red > blue + 60)) > 100  # tension and the arrow
    orange = (abs(red - 214) < 25) & (abs(green - 94) < 30) & (blue < 60)
    assert np.sum(orange) > 20


def test_paraview_reads_what_its_version_can_of_vtkhdf(scene, sampled, tmp_path):
    """All times from 5.12 on; the first frame before, which knows no steps."""
    file = tmp_path / "beam.hdf"
    _write(scene, tmp_path / "beam.vtkhdf", "vtkhdf", lambda: None)
    (tmp_path / "beam.vtkhdf").rename(file)
    found, errors = paraview(file, "VTKHDFReader", sampled)
    if found["times"]:
        np.testing.assert_array_equal(found["times"], scene.frames.time)
    else:
        assert "File version: 2.0 is higher than this reader supports" in errors
    for (mesh,), number in zip(found["frames"], sampled, strict=True):
        sample = int(scene.frames.sample[number if found["times"] else 0])
        expected = [part.shape(sample) for part in scene.parts]
        np.testing.assert_array_equal(mesh["points"], np.concatenate([shape.points for shape in expected]))
        assert mesh["owners"] == list(range(len(scene.parts)))
        for name, array in expected[0].arrays.items():
            got = np.array(mesh["arrays"][name])[: len(expected[0].points)].reshape(array.shape)
            np.testing.assert_array_equal(got, array)

"""Exports in the ParaView of the distribution, as its own Python reads, warps and glyphs them."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from renders.exports.command import _write
from renders.exports.scene import Scene
from renders.exports.selection import Selection
from renders.story import story_of
from renders.style import Style

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


def by_part(meshes):
    """Meshes by the number of their part; XDMFReader has both sides of a jump."""
    found = {}
    for mesh in meshes:
        (owner,) = mesh["owners"]
        found.setdefault(owner, []).append(mesh)
    return found


def check_filters(found, scene, sample):
    """Warp By Vector of the initial shape gives the tube; a force's glyph has its size and direction."""
    points = {part.name: part.shape(sample) for part in scene.parts}
    warped = np.array(found["warped"])[-len(points["surface"].points) :]
    np.testing.assert_allclose(warped, points["surface"].points, rtol=0.0, atol=1e-12)
    for name, ends in found["glyphs"].items():
        expected = 1e-3 * points["contact_point"].arrays[name][0]
        if np.any(expected):
            np.testing.assert_allclose(np.subtract(ends[-1], ends[-7]), expected, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("reader", READERS)
def test_paraview_reads_times_values_and_forces(scene, sampled, tmp_path, reader):
    format = READERS[reader]
    file = tmp_path / f"beam.{format}"
    _write(scene, file, format, lambda: None)
    if reader == "XDMFReader":  # it returns both sides of a jump
        sampled = sampled[2:]
    found, errors = paraview(file, reader, sampled)
    assert errors == ""
    np.testing.assert_array_equal(found["times"], scene.frames.time)
    for frame, number in zip(found["frames"], sampled, strict=True):
        sample = int(scene.frames.sample[number])
        meshes = by_part(frame["meshes"])
        assert sorted(meshes) == list(range(len(scene.parts)))
        for owner, part in enumerate(scene.parts):
            expected = part.shape(sample)
            (mesh,) = meshes[owner][-1:]
            np.testing.assert_array_equal(mesh["points"], expected.points)
            assert set(mesh["arrays"]) - {"position"} == set(expected.arrays)
            for name, values in expected.arrays.items():
                np.testing.assert_array_equal(np.array(mesh["arrays"][name]).reshape(values.shape), values)
        check_filters(frame, scene, sample)


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
    for frame, number in zip(found["frames"], sampled, strict=True):
        sample = int(scene.frames.sample[number if found["times"] else 0])
        (mesh,) = frame["meshes"]
        expected = [part.shape(sample) for part in scene.parts]
        np.testing.assert_array_equal(mesh["points"], np.concatenate([shape.points for shape in expected]))
        assert mesh["owners"] == list(range(len(scene.parts)))
        count = expected[0].points.shape[0]
        for name, values in expected[0].arrays.items():
            got = np.array(mesh["arrays"][name])[:count].reshape(values.shape)
            np.testing.assert_array_equal(got, values)
        check_filters(frame, scene, sample)

"""The interactive window, the mesh at a time, and what is said where neither can be."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from oblique_impact.renders import Style, beam_mesh, show
from oblique_impact.renders.geometry import QUANTITIES, BeamGeometry
from oblique_impact.renders.viewer import Viewer
from tests.refusals import refused_in_one_line


@pytest.fixture(scope="module")
def history(run):
    return run("paper", "end_time=0.35")


@pytest.fixture
def viewer(history):
    viewer = Viewer(history, Style(size=(640, 360), deformation=1.0), off_screen=True)
    yield viewer
    viewer.plotter.close()


@pytest.fixture(scope="module")
def pressed(history):
    """The time (s) of the largest force."""
    return float(history["time"].values[int(np.argmax(np.nan_to_num(history["lambda_n"].values)))])


def said(viewer: Viewer) -> str:
    """The text in the lower left corner: in a notebook there are buttons in the upper one."""
    return viewer._text.GetText(0)


def test_the_mesh_is_the_beam_with_its_results(history, pressed):
    mesh = history.to_pyvista(pressed)
    geometry = BeamGeometry(history, 1.0)
    k = geometry.index(pressed)
    np.testing.assert_array_equal(mesh.points, geometry.tube(k)[0])
    for name in QUANTITIES:
        np.testing.assert_array_equal(mesh[name], geometry.result(name, k))
    # the bending stress at the outer fibre is that of the history (Pa), the axis that of the beam (m)
    ends, stress = np.abs(mesh["bending_stress"]).max(), history.section_forces()["bending_stress"]
    assert ends == pytest.approx(float(np.abs(stress.interp(time=pressed)).max()), rel=1e-2)
    assert mesh.active_scalars_name == "bending_stress"
    assert float(mesh.field_data["time"][0]) == pressed
    assert dict(line.split(" = ") for line in mesh.field_data["units"]) == {"points": "m", **QUANTITIES}
    larger = beam_mesh(history, pressed, deformation=5.0)
    np.testing.assert_array_equal(larger["bending_stress"], mesh["bending_stress"])
    assert np.abs(larger.points - mesh.points).max() > 1e-3


def test_what_cannot_be_shown_is_one_line(history, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    for call, words in (
        (lambda: history.to_pyvista(9.0), "time = 9.0: should be from 0 to 0.35 s"),
        (lambda: history.to_pyvista(0.1, deformation=0.0), "--deformation 0.0: should be a positive number"),
        (lambda: beam_mesh("paper", 0.1), 'to_pyvista: history = "paper": should be a History'),
        (lambda: show("paper"), 'show: history = "paper": should be a History'),
        (lambda: show(history), "show: there is no display here; render draws"),
    ):
        if "display" not in words or sys.platform.startswith("linux"):
            with refused_in_one_line(start=words):
                call()


def test_the_window_shows_the_beam_at_the_time_of_the_slider(viewer, history, pressed):
    """With its force, and the scale of its colours; the largest stress of the run is within the scale."""
    viewer.go_to(pressed)
    geometry = viewer.geometry
    k = geometry.index(pressed)
    force = f"{np.linalg.norm(geometry.contact_force(k)):.4g} N"
    assert said(viewer).strip() == f"t = {pressed:.5f} s  SLIP  contact force {force}"
    beam = viewer.scene.views[0].beams[0]
    np.testing.assert_allclose(beam.mesh.points, geometry.tube(k)[0], rtol=0, atol=1e-6)
    (bar,) = viewer.plotter.scalar_bars.keys()
    assert bar.strip() == "bending stress (MPa), tension positive"
    low, high = beam.actor.mapper.scalar_range
    assert high == -low
    assert 0.5 * high < np.abs(geometry.result("bending_stress", k)).max() / 1e6 <= high
    viewer.go_to(0.1)
    assert said(viewer).strip() == "t = 0.10000 s  FREE"


WINDOW = """
import sys, threading, time
import pyvista as pv
from oblique_impact import History
from oblique_impact.renders import Style, show

old = pv.Plotter.show
def brief(self, **options):
    self.add_timer_event(max_steps=1, duration=1500, callback=lambda step: self.iren.terminate_app())
    old(self, auto_close=False, **options)
    self.screenshot(sys.argv[2])
    self.close()
pv.Plotter.show = brief
show(History.load(sys.argv[1]), Style(size=(640, 360)))
print("closed")
"""


@pytest.mark.slow
def test_a_real_window_opens(history, display, tmp_path):
    history.save(tmp_path / "run")
    words = [sys.executable, "-c", WINDOW, str(tmp_path / "run"), str(tmp_path / "a.png")]
    done = subprocess.run(
        words, env={**os.environ, "DISPLAY": display}, capture_output=True, text=True, timeout=300
    )
    assert (done.returncode, done.stdout) == (0, "closed\n"), done.stderr
    pixels = np.asarray(Image.open(tmp_path / "a.png").convert("RGB"))
    assert np.sum(pixels.min(axis=2) < 200) > 500

"""One drawn slope: the same corners in overview, film, page and export, one radius below the line of contact."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import pyvista as pv
from matplotlib.figure import Figure

from renders import export, overview
from renders.geometry import BeamGeometry
from renders.player import write_player
from renders.player.payload import payload
from renders.scene import Look, View
from renders.slope import DrawnSlope, drawn_slope
from renders.themes import LIGHT
from tests.render.browser import Page, find_browser

CASES = {
    "paper": ("paper", "end_time=0.4"),
    "ledge": ("mid-span",),
    "mid-span without ends": ("mid-span", "slope.extent=[]"),
    "tapered": ("tapered", "end_time=0.34", "contact.point=0.8"),
    "steep": ("sticking", "slope.angle=1.2", "slope.origin=[0.5, 0.0]", "initial.angle=1.5", "end_time=0.1"),
    "never reached": ("paper", "end_time=0.1"),
}
#: modules that take the slope, and the picture each of them makes
PICTURES = {"overview": "overview", "scenery": "film", "player.payload": "page"}


@pytest.fixture(params=CASES)
def history(run, request):
    return run(*CASES[request.param])


def corners(history, factor=None):
    """Corners (4, 2) of the slope as each kind of picture draws it."""
    geometry = BeamGeometry(history, factor)
    axes = Figure().subplots()
    overview._draw_motion(axes, history)
    (patch,) = (p for p in axes.patches if p.get_gid() == "slope")
    view = View([geometry], (320, 200), LIGHT, Look(ghosts=False, trace=False, arrow=False), 1e8)
    solids = [np.asarray(mesh.points) for mesh in view.plotter.meshes if mesh.n_points == 8 and mesh.n_cells == 6]
    view.close()
    with TemporaryDirectory() as folder:
        export(history, f"{folder}/beam.pvd", between=(0.0, 2e-4), deformation=geometry.factor)
        (exported,) = (pv.read(file) for file in Path(folder).rglob("slope*.vtp"))
    return {
        "overview": patch.get_xy()[:4],
        "film": front(solids[0]),
        "page": np.array(payload(history, factor, 20).facts["slope"]["outline"]),
        "export": front(np.asarray(exported.points)),
    }


def front(points):
    """Corners (4, 2) of a prism's front."""
    return points[points[:, 2] == points[:, 2].max()][:, :2]


def same(found, expected):
    """Whether corners are equal, in whatever order a solid has them, to the rounding of float32."""
    apart = np.linalg.norm(found[:, None] - expected, axis=-1)
    return found.shape == expected.shape and apart.min(axis=0).max() < 1e-6 > apart.min(axis=1).max()


def test_all_pictures_draw_the_same_slope(history):
    expected = drawn_slope(BeamGeometry(history)).outline
    for factor in (None, 1.0, 50.0):
        for name, found in corners(history, factor).items():
            assert same(found, expected), (name, factor)


@pytest.mark.parametrize("module", PICTURES)
def test_a_slope_of_its_own_is_noticed(run, monkeypatch, module):
    history = run(*CASES["paper"])

    def shifted(geometry):
        slope = drawn_slope(geometry)
        return DrawnSlope(slope.ends, slope.outline + np.array([0.0, 1e-3]))

    monkeypatch.setattr(f"renders.{module}.drawn_slope", shifted)
    expected = drawn_slope(BeamGeometry(history)).outline
    wrong = {name for name, found in corners(history).items() if not same(found, expected)}
    assert PICTURES[module] in wrong
    assert ("export" in wrong) == (module == "scenery")


def test_the_surface_lies_one_radius_below_the_axis(history):
    geometry = BeamGeometry(history)
    slope, scenario = drawn_slope(geometry), geometry.scenario
    angle = scenario.slope.angle
    tangent, normal = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    places = slope.outline - scenario.slope.origin
    area = scenario.beam.area
    if isinstance(area, tuple):
        area = np.interp(scenario.contact.point, *np.transpose(area))
    np.testing.assert_allclose(places[:2] @ normal, -np.sqrt(area / np.pi), atol=1e-12)
    np.testing.assert_allclose(places[:2] @ tangent, slope.ends, atol=1e-12)
    if scenario.slope.extent:
        assert slope.ends == scenario.slope.extent
    assert np.all(places[2:] @ normal < places[0] @ normal - 0.05 * scenario.beam.length)  # a solid below it


def test_what_passes_below_an_unbounded_slope_is_seen_to_do_so(run):
    """The slope is drawn over every place of the axis that is below it."""
    history = run(*CASES["mid-span without ends"])
    geometry = BeamGeometry(history)
    first, last = drawn_slope(geometry).ends
    angle = geometry.scenario.slope.angle
    places = geometry.stations_of(np.arange(geometry.times.size)) - geometry.scenario.slope.origin
    height = places @ np.array([-np.sin(angle), np.cos(angle)])
    below = (places @ np.array([np.cos(angle), np.sin(angle)]))[height < 0.0]
    assert height.min() < -0.07
    assert first < below.min()
    assert last > below.max()


def test_ends_out_of_reach_are_not_drawn(run):
    """What the beam never reaches would only make it small; of a far obstacle nothing is left."""
    wide = drawn_slope(BeamGeometry(run("paper", "end_time=0.01", "slope.extent=[-100.0, 100.0]")))
    assert np.ptp(wide.ends) < 2.5
    assert drawn_slope(BeamGeometry(run("paper", "end_time=0.01", "slope.extent=[5.0, 6.0]"))) is None


def test_without_contact_there_is_none(run):
    history = run("spin-up", "end_time=0.01")
    assert drawn_slope(BeamGeometry(history)) is None
    assert payload(history, None, 20).facts["slope"]["outline"] is None


RECORD = """(() => {
  const P = CanvasRenderingContext2D.prototype, own = [P.beginPath, P.lineTo, P.arc];
  window.drawn = { paths: [], arcs: [] };
  let path = [];
  P.beginPath = function () {
    path = [];
    if (this.canvas.id === "scene") drawn.paths.push(path);
    own[0].call(this);
  };
  P.lineTo = function (x, y) { path.push([x, y]); own[1].call(this, x, y); };
  P.arc = function (x, y, ...rest) {
    if (this.canvas.id === "scene") drawn.arcs.push([x, y]);
    own[2].call(this, x, y, ...rest);
  };
})()"""


@pytest.mark.skipif(find_browser() is None, reason="no Chromium on the PATH")
@pytest.mark.parametrize("factor", [1.0, 50.0])
def test_the_page_draws_it_untrimmed(run, tmp_path, factor):
    """The first path of the scene is the slope; the pin, the origin, is the last arc."""
    history = run(*CASES["mid-span without ends"])
    outline = drawn_slope(BeamGeometry(history)).outline
    file = write_player(history, tmp_path / "page.html", factor=factor)
    with Page(find_browser()) as page:
        page.size(1600, 1000)
        page.open(file)
        page.evaluate(RECORD)
        page.evaluate("player.seek(0.2)")
        page.settle()
        found = page.evaluate("drawn")
        assert page.errors == []
    path, pin = np.array(found["paths"][0]), np.array(found["arcs"][-1])
    assert path.shape == (4, 2)
    scale = (path[1, 0] - path[0, 0]) / (outline[1, 0] - outline[0, 0])
    assert scale > 100.0
    np.testing.assert_allclose((path - pin) / scale, outline * [1.0, -1.0], atol=1e-4)

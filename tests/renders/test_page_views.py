"""What the reader of the page of a run chooses: the result in colour, and what is seen; the drawn section."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from oblique_impact.renders.geometry import BETWEEN
from oblique_impact.renders.outlines import SIDES
from oblique_impact.renders.story import colour_scale, story_of
from oblique_impact.renders.style import Colour, Style
from tests.renders.page_scripts import NODE, Scripts

pytestmark = pytest.mark.skipif(NODE is None, reason="neither node nor nodejs is on the PATH")

WIDE, HIGH = 800, 500
I_BEAM = (
    *("discretization.method=fem", "discretization.modes=3", "end_time=0.33", "beam.section.shape=i-beam"),
    *("beam.section.width=0.04", "beam.section.height=[[0, 0.08], [1, 0.03]]"),
    *("beam.section.flange_thickness=0.006", "beam.section.web_thickness=0.005"),
)


@pytest.fixture(scope="module")
def i_beam(run):
    """A tapered i-beam, drawn at its true deflection."""
    return story_of([run("paper", *I_BEAM)], Style(deformation=1.0))


@pytest.mark.parametrize("name", get_args(Colour))
def test_every_result_has_its_values_on_both_sides_and_its_scale(i_beam, name):
    """Against the surface that the other pictures draw."""
    scripts, geometry = Scripts(i_beam), i_beam.geometries[0]
    largest = scripts.arrays["frame_axial" if name.startswith("axial") else "frame_moment"]
    frame = int(np.abs(largest).max(axis=1).argmax())
    found, title, limit, ticks = scripts.value(
        f"((k) => {{ setResult({name!r}); const m = newMoment(); momentAt(k, m);"
        f" return [m.sides, result.title, result.limit, result.ticks]; }})({frame})"
    )
    values = geometry.result(name, int(scripts.arrays["frame_sample"][frame]))[:-2].reshape(-1, SIDES)
    rings = slice(None, (BETWEEN + 1) * geometry.stations.size, BETWEEN + 1)
    scale = colour_scale([geometry], name)
    assert (title, limit, ticks) == (scale.title, scale.limit, [list(tick) for tick in scale.ticks])
    assert np.abs(values).max() > 0.1 * limit  # there is something to compare
    for side, around in (("upper", 0), ("lower", SIDES // 2)):
        shown = [found[side][str(j)] for j in range(geometry.stations.size)]
        np.testing.assert_allclose(shown, values[rings, around], atol=1e-3 * limit)


def test_the_colours_are_those_of_the_chosen_result(i_beam):
    scripts = Scripts(i_beam)
    frame = int(np.abs(scripts.arrays["frame_moment"]).max(axis=1).argmax())
    call = "drawTube(context, sceneView(800, 500), magnified(moment, 1), momentAt(moment.place, moment).sides)"
    ends = {}
    for name in ("bending_stress", "bending_moment"):
        fills = scripts.at(frame, f"(() => {{ setResult({name!r}); return note(() => {call}).fills; }})()")
        shades = [fill["tint"]["stops"] for fill in fills if isinstance(fill["tint"], dict)]
        middle = shades[len(shades) // 2]
        ends[name] = (middle[0][1], middle[-1][1])
    assert ends["bending_stress"][0] != ends["bending_stress"][1]  # stretched below, pressed above
    assert ends["bending_moment"][0] == ends["bending_moment"][1]  # one value for a section


def outline_of(scripts, view, frame):
    """What is drawn of the beam: all strokes, and its edges in metres as seen from the axis."""
    noted = scripts.drawn(frame, f"drawTube(context, {view}, magnified(moment, 1), moment.sides)")
    return noted["strokes"], noted["fills"]


def test_the_drawn_height_is_that_of_the_section(i_beam):
    """Of a tapered i-beam: half of its height at every station, its flanges, and a flat end."""
    scripts, geometry = Scripts(i_beam), i_beam.geometries[0]
    strokes, _ = outline_of(scripts, "{ scale: 1e3, x0: 0, y0: 0, thick: 1 }", 3)
    count = geometry.stations.size
    *flanges, edge = (np.array(stroke["points"]) for stroke in strokes)
    assert len(edge) == 2 * count + 1  # two sides, and the first point of one of them twice
    lower, upper = edge[1 : count + 1], edge[:count:-1]
    heights = np.linalg.norm(upper - lower, axis=1) / 1e3
    np.testing.assert_allclose(heights, np.interp(geometry.stations, [0, 1], [0.08, 0.03]), rtol=1e-4)
    inner = np.linalg.norm(flanges[1] - flanges[0], axis=1) / 1e3
    np.testing.assert_allclose(heights - inner, 2 * 0.006, rtol=1e-3)


def test_a_mass_at_the_tip_is_drawn_and_touches_the_slope(run):
    story = story_of([run("tapered", "end_time=0.34")])
    scripts, geometry = Scripts(story), story.geometries[0]
    assert geometry.mass_radius > 1.5 * geometry.radii[-1]
    _, fills = outline_of(scripts, "{ scale: 1e3, x0: 0, y0: 0, thick: 1 }", 3)
    assert fills[-1]["arcs"][0][2] == pytest.approx(1e3 * geometry.mass_radius)
    k = int(scripts.arrays["frame_sample"][3])
    place = scripts.at(3, "touchPlace({ scale: 1e3, x0: 0, y0: 0, thick: 1 }, moment)")
    assert np.array(place) / (1e3, -1e3) == pytest.approx(geometry.contact_place(k)[:2], abs=1e-5)


# What is seen -------------------------------------------------------------------------------------------------


def seen(scripts, *calls):
    """Scale and origin of the picture after some calls, and the scale of the whole."""
    steps = "; ".join(calls)
    return scripts.value(
        f"(() => {{ const whole = sceneView({WIDE}, {HIGH}).whole; {steps};"
        f" return sceneView({WIDE}, {HIGH}); }})()"
    )


def test_zoom_enlarges_and_keeps_what_lies_under_the_pointer(scripts):
    right, down = 120.0, -40.0
    before, after = seen(scripts), seen(scripts, f"zoomBy(3, whole, [{right}, {down}])")
    middle = scripts.value(f"[{WIDE} / 2, sceneHeight({HIGH}) / 2]")
    assert after["scale"] == pytest.approx(3.0 * before["scale"])
    at = np.add(middle, (right, down))
    under = [(at - (view["x0"], view["y0"])) / view["scale"] for view in (before, after)]
    assert under[1] == pytest.approx(under[0])
    back = seen(scripts, f"zoomBy(3, whole, [{right}, {down}])", "zoomBy(1 / 3, whole)")
    assert back == pytest.approx(before)  # the whole is the whole, wherever one zooms out
    assert seen(scripts, "zoomBy(0.5, whole)") == pytest.approx(before)
    assert seen(scripts, "zoomBy(1e9, whole)")["scale"] == pytest.approx(400 * before["scale"])


def test_a_thin_beam_is_no_thicker_than_it_is_where_that_can_be_seen(run):
    scripts = Scripts(story_of([run("paper", "end_time=0.35")]))
    small = "((view) => [view.thick, scene.thick])(sceneView(160, 140))"
    assert scripts.value(small)[0] > 1
    assert scripts.value(f"(() => {{ zoomBy(8, sceneView(160, 140).whole); return {small}; }})()") == [1, 1]


def test_the_arrow_of_a_force_keeps_its_length_under_zoom(scripts):
    force = scripts.arrays["chart_normal"][scripts.arrays["frame_point"]]
    frame = int(force.argmax())

    def length(setup):
        noted = scripts.at(frame, f"(() => {{ {setup}; return note(() => drawScene(moment)); }})()")
        arrow = next(np.array(f["points"]) for f in noted["fills"] if len(f.get("points") or ()) == 7)
        return float(np.linalg.norm(arrow[3] - 0.5 * (arrow[0] + arrow[-1])))

    whole = length("")
    assert length(
        "zoomBy(2, sceneView(800, 500).whole, offsetOf)".replace("offsetOf", "[150, 60]")
    ) == pytest.approx(whole)

"""What the page of a run draws and writes: Node runs its scripts with a canvas that takes notes (`stage.js`)."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from oblique_impact.renders.beam3d import contact_force
from oblique_impact.renders.envelope import drawn
from oblique_impact.renders.geometry import BETWEEN
from oblique_impact.renders.slope import drawn_slope
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import DARK, LIGHT, STATE_COLOURS, Style
from tests.renders.page_arrays import frame_stress
from tests.renders.page_scripts import NODE, PAGE, Scripts
from tests.renders.test_pictures import check_arrow_outline

pytestmark = pytest.mark.skipif(NODE is None, reason="neither node nor nodejs is on the PATH")


def test_numbers_are_written_as_they_are(scripts):
    """Rounding, signs, units of rates: what a reader takes from the page."""
    cases = {
        "rateText(0.1)": "1/10 of real time",
        "rateText(0.002)": "1/500 of real time",
        "rateText(1 / 3)": "1/3 of real time",
        "rateText(1 / 384)": "1/380 of real time",
        "rateText(1)": "real time",
        "rateText(2.5)": "2.5× real time",
        "significant(241.78, 3)": "242",
        "significant(-0.012345, 3)": "−0.0123",
        "significant(3.2e8, 3)": "3.20e8",
        "significant(0, 3)": "0",
        "significant(NaN, 3)": "–",
        "fixed(-0.0004, 3)": "0.000",
        "fixed(-1.2346, 3)": "−1.235",
        "short(2.50)": "2.5",
        "ticks(0, 1, 5)": {"values": pytest.approx([0.0, 0.2, 0.4, 0.6, 0.8, 1.0]), "decimals": 1},
        "ticks(0.3171, 0.3304, 4)": {"values": pytest.approx([0.32, 0.325, 0.33]), "decimals": 3},
    }
    assert scripts.value(f"[{', '.join(cases)}]") == list(cases.values())


def test_a_deflection_of_several_lengths_does_not_end_the_page(run):
    """What is too far away to be drawn is left out, at every frame and in both views."""
    history = run("paper", "end_time=0.33")
    uy = history["uy"] * (4.7 / float(np.abs(history["uy"]).max()))
    scripts = Scripts(story_of([replace(history, data=history.data.assign(uy=uy))], Style(deformation=5.0)))
    assert not np.isfinite(scripts.x).all()
    for frame in range(0, len(scripts.arrays["frame_time"]), 20):
        scripts.drawn(frame, "(drawScene(moment), drawInset(moment))")


def strongest(scripts):
    """Frames of the largest friction down and up the slope."""
    force = scripts.arrays["chart_tangential"][scripts.arrays["frame_point"]]
    return [int(force.argmax()), int(force.argmin())]


@pytest.mark.parametrize("view", ["sceneView(800, 500)", "insetView(moment, 300, 250)"])
def test_the_arrow_points_along_the_force_and_leaves_the_contact_point_free(scripts, story, view):
    geometry = story.geometries[0]
    for frame in strongest(scripts):
        k = int(scripts.arrays["frame_sample"][frame])
        force = contact_force(geometry, k)
        along = force / np.linalg.norm(force) * (1.0, -1.0)  # rows count downward
        noted = scripts.drawn(frame, f"drawForce(context, {view}, moment, 90)")
        place = scripts.at(frame, f"touchPlace({view}, moment)")
        arrow, mark = noted["fills"]
        rgb = ",".join(str(int(STATE_COLOURS[1][n : n + 2], 16)) for n in (1, 3, 5))
        assert arrow["tint"] == f"rgb({rgb})"
        assert mark["arcs"][0][:2] == pytest.approx(place)
        length = 90.0 * np.sqrt(np.linalg.norm(force) / geometry.peak_force)
        check_arrow_outline(np.array(arrow["points"]), along, np.array(place), length)
        with pytest.raises(AssertionError):  # as it would be with the other sign
            check_arrow_outline(np.array(arrow["points"]), -along, np.array(place), length)
        label = f"labelForce(context, drawForce(context, {view}, moment, 90), 800, 500, '')"
        (said,) = scripts.drawn(frame, label)["texts"]
        assert float(said["text"].removesuffix(" N")) == pytest.approx(np.linalg.norm(force), rel=6e-3)


def test_without_contact_there_is_no_arrow(scripts):
    free = int(np.flatnonzero(scripts.arrays["frame_state"] == 0)[50])
    assert scripts.drawn(free, "drawForce(context, sceneView(800, 500), moment, 90)")["fills"] == []


def test_the_contact_point_is_one_radius_above_the_mark(scripts, story):
    """In the view at true scale; the beam of the whole scene is drawn thicker, and so is its distance."""
    geometry, frame = story.geometries[0], strongest(scripts)[0]
    place, axis, scale = scripts.at(
        frame,
        "((view) => [touchPlace(view, moment), [toX(view, moment.x.at(-1)), toY(view, moment.y.at(-1))],"
        " view.scale])(insetView(moment, 300, 250))",
    )
    found = (np.array(place) - axis) / scale
    assert found == pytest.approx(-geometry.touch_radius * geometry.slope_axes[1] * (1.0, -1.0), rel=1e-5)


def test_the_stress_is_drawn_on_its_own_side(scripts):
    """From the lower fibre, whose stress that of the history is, through zero to the upper one."""
    stress = frame_stress(scripts.arrays)
    frame = int(stress.max(axis=1).argmax())
    station = int(stress[frame].argmax())
    colours = scripts.value("[1e99, 0, -1e99].map(resultColour)")
    assert colours == ["rgb(103,0,31)", "rgb(247,245,245)", "rgb(5,48,97)"]  # red where the fibre is stretched
    noted = scripts.drawn(frame, "drawTube(context, sceneView(800, 500), magnified(moment, 1), moment.sides)")
    shades = [fill["tint"] for fill in noted["fills"] if isinstance(fill["tint"], dict)]
    middle = shades[round((station + 0.5) / 32 * (len(shades) - 2))]
    assert middle["ends"][1] > middle["ends"][3]  # begins below, as rows count downward
    value = float(stress[frame, station])
    assert middle["stops"][3] == [0.5, colours[1]]
    red, blue = (list(map(int, re.findall(r"\d+", middle["stops"][n][1]))) for n in (0, 6))
    assert value > 0.5 * scripts.value("result.limit")
    assert red[0] > red[2] + 60
    assert blue[2] > blue[0] + 60


def test_the_colour_bar_has_the_labels_of_the_other_pictures(scripts, story):
    noted = scripts.drawn(0, "drawColourBar(context, 800, 500)")
    scale = story.colours
    assert [t["text"] for t in noted["texts"]] == [scale.title, *(text for _, text in scale.ticks)]
    left, _, width, _ = noted["fills"][0]["rect"]
    places = [(t["x"] - left) / width for t in noted["texts"][1:]]
    assert places == pytest.approx([0.5 * (part + 1.0) for part, _ in scale.ticks])
    stops = noted["fills"][0]["tint"]["stops"]
    assert (stops[0], stops[-1]) == ([0, "#053061"], [1, "#67001f"])


def test_the_scale_bar_is_as_long_as_it_says(scripts):
    for scale in (4000, 700, 90):
        noted = scripts.value(f"note(() => drawScaleBar(context, {{ scale: {scale} }}, 300, 250))")
        number, unit = noted["texts"][0]["text"].split(" ")
        assert float(number) * {"mm": 1e-3, "m": 1.0}[unit] * scale == pytest.approx(noted["fills"][0]["rect"][2])


def test_charts_have_their_ticks_units_and_cursor_where_the_values_are(scripts):
    """A value is read off the vertical axis, a time off the horizontal one."""
    frame = strongest(scripts)[1]
    point, time = scripts.arrays["frame_point"][frame], scripts.arrays["frame_time"][frame]
    names = (("normal", "tangential"), ("kinetic", "elastic", "gravity"))
    values = [[float(scripts.arrays[f"chart_{name}"][point]) for name in part] for part in names]
    values[1].append(sum(values[1]))
    for number, (unit, expected) in enumerate(zip("NJ", values, strict=True)):
        noted = scripts.drawn(frame, f"drawChart(chartSpecs()[{number}], moment, [0, 1])")
        words = [text["text"] for text in noted["texts"]]
        assert words[-1] == unit
        end = words.index("t (s)")
        to_time = axis_of(noted["texts"][:end], "x")
        to_value = axis_of(noted["texts"][end + 1 : -1], "y")
        assert (to_time[0] > 0.0, to_value[0] < 0.0) == (True, True)  # rows count downward
        cursor = [fill["arcs"][0] for fill in noted["fills"] if fill.get("arcs")][-len(expected) :]
        assert np.polyval(to_time, cursor[0][0]) == pytest.approx(time, abs=1e-6)
        assert [np.polyval(to_value, y) for _, y, *_ in cursor] == pytest.approx(expected, rel=1e-5, abs=1e-6)


def axis_of(texts, key):
    """The line through the numbers at the ticks of an axis, over their pixels."""
    numbers, at = [float(text["text"].replace("−", "-")) for text in texts], [text[key] for text in texts]
    line = np.polyfit(at, numbers, 1)
    np.testing.assert_allclose(np.polyval(line, at), numbers, atol=1e-9 * np.ptp(numbers))
    return line


def test_a_deflection_is_shown_in_millimetres(run):
    scripts = Scripts(story_of([run("spin-up", "end_time=0.2")]))
    shown = "[chart.title, chart.unit, Math.max(...chart.series[0].values.map(Math.abs))]"
    title, unit, largest = scripts.value(f"((chart) => {shown})(chartSpecs()[0])")
    assert (title, unit) == ("Deflection", "mm")
    assert largest == pytest.approx(1e3 * float(np.abs(scripts.arrays["chart_deflection"]).max()), rel=1e-6)


def test_a_vibration_is_the_same_band_as_in_a_film(scripts):
    """The page's own reduction of a curve to its pixels against the one of the other pictures."""
    x = np.linspace(0.0, 300.0, 4001)
    y = np.where((x > 100.0) & (x < 200.0), 30.0 * np.sin(2.0 * np.pi * x / 3.7), 0.0) + 0.1 * x + 3.0 * (x > 50.0)
    expected, found = drawn(x, y, 1.0), scripts.value("envelope(...CONTENT.xy, 1)", xy=[x.tolist(), y.tolist()])
    assert len(found["bands"]) == len(expected.bands) == 1
    mine, theirs = expected.bands[0], found["bands"][0]
    for name in ("x", "low", "high"):
        np.testing.assert_allclose(theirs[name], getattr(mine, name), atol=1e-9)
    line = np.concatenate([y[found["lines"][0]["from"] : found["lines"][0]["to"]], theirs["mean"]])
    np.testing.assert_allclose(line, expected.y[: line.size], atol=0.02)  # where the area of a pixel is cut


def test_between_frames_numbers_follow_the_points_of_the_charts(scripts):
    """Which are closer than the frames."""
    arrays, names = scripts.arrays, ("normal", "kinetic", "gap")
    wide = np.flatnonzero(np.diff(arrays["frame_point"]) > 3)[::5]
    assert wide.size > 20
    places = [float(place) for place in np.concatenate([wide + 0.3, wide + 0.8])]
    read = "[m.time, m.normal, m.kinetic, m.gap]"
    found = scripts.value(f"CONTENT.places.map(p => ((m) => {read})(momentAt(p, newMoment())))", places=places)
    times, *values = np.array(found).T
    for name, shown in zip(names, values, strict=True):
        expected = np.interp(times, arrays["chart_time"], arrays[f"chart_{name}"].astype(float))
        np.testing.assert_allclose(shown, expected, rtol=1e-5, atol=1e-6 * np.abs(expected).max())


def test_the_interpolated_beam_keeps_its_length(run):
    """Between the frames of a fast spin the beam turns; it does not cut the corner."""
    scripts = Scripts(story_of([run("spin-up")]))
    reach = [scripts.at(p, "Math.hypot(moment.x.at(-1), moment.y.at(-1))") for p in (80.5, 84.5, 88.5)]
    frames = np.hypot(scripts.x[:, -1], scripts.y[:, -1])
    np.testing.assert_allclose(reach, [0.5 * (frames[k] + frames[k + 1]) for k in (80, 84, 88)], rtol=1e-4)
    turned = np.diff(np.arctan2(scripts.y[80:82, -1], scripts.x[80:82, -1]))
    assert abs(turned[0]) > 0.1  # a chord would be shorter by more than that allows


@pytest.mark.parametrize("factor", [1.0, 50.0])
def test_the_page_draws_the_slope_untrimmed(run, factor):
    """At the place that it has in the other pictures, whatever the deformation factor is."""
    story = story_of([run("mid-span", "slope.extent=[]")], Style(deformation=factor))
    outline, scripts = drawn_slope(story.geometries[0]).outline, Scripts(story)
    found = scripts.drawn(40, "drawWedge(context, { scale: 100, x0: 7, y0: 9, thick: 1 })")["fills"][0]["points"]
    np.testing.assert_allclose((np.array(found) - (7, 9)) / (100, -100), outline, atol=1e-9)


def rgb(state):
    """Colour of a state as the page writes it."""
    return f"rgb({','.join(str(int(STATE_COLOURS[state][n : n + 2], 16)) for n in (1, 3, 5))})"


@pytest.mark.parametrize(
    ("view", "call"), [("sceneView(800, 500)", "Scene"), ("insetView(moment, 800, 500)", "Inset")]
)
def test_the_drawn_beam_is_magnified_in_the_scene_alone(scripts, story, view, call):
    """The middle of the tube against the axis that the other pictures draw."""
    frame, geometry = strongest(scripts)[0], story.geometries[0]
    noted = scripts.drawn(frame, f"draw{call}(moment)")
    (tube,) = (s["points"] for s in noted["strokes"] if len(s["points"]) == 2 * geometry.stations.size + 1)
    lower, upper = np.array(tube[1 : geometry.stations.size + 1]), np.array(tube[: geometry.stations.size : -1])
    at = scripts.at(frame, view)
    found = (0.5 * (lower + upper) - (at["x0"], at["y0"])) / (at["scale"], -at["scale"])
    shown = geometry if call == "Scene" else geometry.true
    expected = shown.centreline(int(scripts.arrays["frame_sample"][frame]))[:: BETWEEN + 1, :2]
    np.testing.assert_allclose(found, expected, atol=1e-5)
    assert geometry.factor > 1.0


def test_the_path_of_the_contact_point_has_the_colours_of_the_states(scripts):
    last = scripts.arrays["frame_time"].size - 1
    noted = scripts.drawn(last, "drawTrace(context, { scale: 1, x0: 0, y0: 0, thick: 1 }, moment, 1e9)")
    states, x = scripts.arrays["frame_state"], scripts.x[:, -1]
    starts = np.concatenate([[0], np.flatnonzero(np.diff(states.astype(int))) + 1])
    assert [stroke["tint"] for stroke in noted["strokes"]] == [rgb(state) for state in states[starts]]
    assert [stroke["points"][0][0] for stroke in noted["strokes"]] == pytest.approx(x[starts].tolist(), abs=1e-6)


@pytest.mark.parametrize("part", [0.3, 0.7])
def test_the_path_of_the_contact_point_ends_where_it_is(scripts, part):
    frame = int(part * scripts.arrays["frame_time"].size)
    noted = scripts.drawn(frame, "drawTrace(context, { scale: 1, x0: 0, y0: 0, thick: 1 }, moment, 1e9)")
    points = np.array([point for stroke in noted["strokes"] for point in stroke["points"]])
    way = np.hypot(*np.diff(points, axis=0).T).sum()
    gone = np.hypot(np.diff(scripts.x[: frame + 1, -1]), np.diff(scripts.y[: frame + 1, -1])).sum()
    assert points[[0, -1]] == pytest.approx(
        np.stack([scripts.x[[0, frame], -1], -scripts.y[[0, frame], -1]], axis=1), abs=1e-6
    )
    assert way == pytest.approx(gone, rel=2e-3)


def test_ghosts_are_earlier_positions_the_older_the_fainter(scripts, story):
    """Before an impact; their contact points are 0.11 of the length apart along the path up to now."""
    frame = int(np.flatnonzero(scripts.arrays["frame_state"])[0]) - 2
    count, past = story.geometries[0].stations.size, slice(0, frame + 1)
    gone = np.append(0.0, np.cumsum(np.hypot(np.diff(scripts.x[past, -1]), np.diff(scripts.y[past, -1]))))
    fine = np.linspace(0.0, gone[-1], 1001)
    path = np.stack(
        [np.interp(fine, gone, scripts.x[past, -1]), np.interp(fine, gone, scripts.y[past, -1])], axis=1
    )
    bent = {}
    for factor in (1, 10):
        call = f"(setScene({factor}), drawGhosts(context, {{ scale: 1, x0: 0, y0: 0, thick: 1 }}, moment))"
        fills = scripts.drawn(frame, call)["fills"]
        edges = [np.array(fill["points"]) * (1.0, -1.0) for fill in fills]
        axes = np.array([0.5 * (edge[1 : count + 1] + edge[:count:-1]) for edge in edges])
        bent[factor] = axes[:, count // 2] - 0.5 * (axes[:, 0] + axes[:, -1])
        away = np.linalg.norm(axes[:, -1:] - path, axis=2)
        way = fine[away.argmin(axis=1)]
        assert away.min(axis=1).max() < 2e-3
        assert np.diff(way) == pytest.approx(np.full(len(way) - 1, 0.11), abs=5e-3)
        assert 0.0 < gone[-1] - way[-1] < 0.2
        strength = [fill["alpha"] for fill in fills]
        assert len(set(strength)) == len(way) > 2
        assert strength == sorted(strength)
    np.testing.assert_allclose(bent[10], 10.0 * bent[1], atol=1e-6)


def test_a_zoomed_scene_has_a_bar_as_long_as_it_says(scripts):
    shown = "[note(() => drawScene(moment)), sceneView(800, 500)]"
    call = f"(() => {{ zoomBy(4, sceneView(800, 500).whole); return {shown}; }})()"
    noted, view = scripts.at(strongest(scripts)[0], call)
    number, unit = next(text["text"] for text in noted["texts"] if text["text"].endswith("m")).split(" ")
    long = float(number) * {"mm": 1e-3, "m": 1.0}[unit] * view["scale"]
    assert any(fill["rect"][2] == pytest.approx(long) for fill in noted["fills"] if "rect" in fill)


@pytest.mark.parametrize(("surface", "close"), [("axis", 1e-5), ("section", 5e-5)])
def test_what_touches_is_marked_where_it_touches(run, surface, close):
    """Along the beam, not at its tip; the page turns the section by the axis between its stations."""
    story = story_of([run("mid-span", "slope.extent=[]", f"contact.surface='{surface}'")])
    scripts, geometry = Scripts(story), story.geometries[0]
    frame = strongest(scripts)[0]
    k = int(scripts.arrays["frame_sample"][frame])
    view = "{ scale: 1e3, x0: 0, y0: 0, thick: 1 }"
    place = scripts.at(frame, f"touchPlace({view}, moment)")
    assert np.array(place) / (1e3, -1e3) == pytest.approx(geometry.contact_place(k)[:2], abs=close)
    (mark,) = scripts.drawn(frame, f"drawContactPoint(context, {view}, moment)")["fills"]
    assert np.array(mark["arcs"][0][:2]) / (1e3, -1e3) == pytest.approx(geometry.contact_point(k), abs=close)
    assert np.linalg.norm(geometry.contact_point(k)) < 0.8 * geometry.scenario.beam.length


def test_a_driven_root_has_a_filled_bolt_and_a_pin_a_hollow_one(scripts, run):
    driven = Scripts(story_of([run("spin-up", "end_time=0.2")]))
    for one, tint in ((scripts, "colour.paper"), (driven, "colour.edge")):
        noted, wanted = one.value(f"[note(() => drawHinge(context, sceneView(800, 500))), {tint}]")
        assert noted["fills"][0]["tint"] == wanted
    assert scripts.value("colour.paper !== colour.edge")


def test_forces_have_the_colours_of_the_states(scripts):
    """The curve while the beam touches and while it does not; the points at the cursor."""
    frame = strongest(scripts)[0]
    noted = scripts.drawn(frame, "drawChart(chartSpecs()[0], moment, [START, END])")
    lines = {stroke["tint"] for stroke in noted["strokes"] if stroke["alpha"] == 0.3}
    assert lines == {rgb(0), rgb(1)}
    points = [fill["tint"] for fill in noted["fills"] if fill.get("arcs")]
    assert points[-2:] == [rgb(1), rgb(1)]


def test_the_past_of_a_chart_is_solid_and_its_events_are_marked(scripts):
    frame = strongest(scripts)[1]
    noted = scripts.drawn(frame, "drawChart(chartSpecs()[1], moment, [0, 1])")
    cursor = [fill["arcs"][0] for fill in noted["fills"] if fill.get("arcs")][-1][0]
    past, future = ([s["within"] for s in noted["strokes"] if s["alpha"] == alpha] for alpha in (1, 0.3))
    assert len(past) == len(future) + 4 == 8  # with the rings of the cursor
    assert [box[0] + box[2] for box in past[:4]] == pytest.approx([cursor] * 4)
    assert [box[0] for box in future] == pytest.approx([cursor] * 4)
    words = [text["text"] for text in noted["texts"]]
    to_time = axis_of(noted["texts"][: words.index("t (s)")], "x")
    marks = [fill for fill in noted["fills"] if len(fill.get("points", ())) == 3]
    events = scripts.facts["events"]
    assert [np.polyval(to_time, mark["points"][0][0]) for mark in marks] == pytest.approx(
        [e["time"] for e in events]
    )
    assert [mark["tint"] for mark in marks] == [rgb(e["state"]) for e in events]


def test_energies_have_the_colours_of_the_other_pictures():
    text = (PAGE / "player.css").read_text(encoding="utf-8")
    light, dark = (dict(re.findall(r"--(\w+): (#\w+);", part)) for part in text.split('[data-theme="dark"]')[:2])
    for colours, theme in ((light, LIGHT), (dark, DARK)):
        assert tuple(colours[name] for name in ("kinetic", "elastic", "gravity")) == theme.energies

"""What is read off charts and figures: each curve under its name, with its unit, and the cursor at its time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from oblique_impact.contact.state import State
from oblique_impact.renders import campbell, overview
from oblique_impact.renders.charts import Chart, Curve, energy_curves, force_curves, round_times
from oblique_impact.renders.sheet import Sheet
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import LIGHT, STATE_COLOURS

KINDS = ("kinetic", "elastic", "gravity")


@pytest.fixture(scope="module")
def story(run):
    return story_of([run("paper")])


def test_each_curve_has_its_name_and_colour(story, run):
    history = story.histories[0]
    normal, tangential = force_curves(story)
    assert [(c.label, c.colour, c.dash) for c in (normal, tangential)] == [
        ("normal", LIGHT.arrow, "-"),
        ("tangential", LIGHT.arrow, "--"),
    ]
    np.testing.assert_array_equal(normal.values, history["lambda_n"])
    np.testing.assert_array_equal(tangential.values, history["lambda_tau"])
    *parts, total = energy_curves(story)
    for curve, kind, colour in zip(parts, KINDS, LIGHT.energies, strict=True):
        assert (curve.label, curve.colour) == (kind, colour)
        np.testing.assert_array_equal(curve.values, history[f"energy_{kind}"])
    assert (total.label, total.colour) == ("total", LIGHT.ink)
    np.testing.assert_allclose(total.values, sum(history[f"energy_{kind}"].values for kind in KINDS), rtol=1e-12)
    two = story_of([history, run("sticking")], names=["a", "b"])
    energies = [f"energy_{kind}" for kind in KINDS]
    for curves, variables in ((force_curves(two), ["lambda_n"]), (energy_curves(two), energies)):
        assert [(c.label, c.colour) for c in curves] == [("a", LIGHT.series[0]), ("b", LIGHT.series[1])]
        for curve, one in zip(curves, two.histories, strict=True):
            np.testing.assert_allclose(curve.values, sum(one[name].values for name in variables), rtol=1e-12)


def charted(story, curves, label, course=None):
    """A chart of curves, 400 x 200 pixels, and its axes."""
    sheet = Sheet((400, 200), story.style)
    chart = Chart(sheet, curves, label, (0, 0, 400, 200), course or story.time_map, story)
    return chart, sheet.figure.axes[0]


def test_a_curve_has_at_the_label_of_a_time_its_value_then(story):
    """In a part of a film; the value of this curve is its time."""
    times = story.geometries[0].times
    _, axes = charted(story, [Curve(times, times, "#000000", "time")], "time (s)", story.time_map.part(0.31, 0.33))
    (line,) = axes.lines
    for place, label in zip(axes.get_xticks(), axes.get_xticklabels(), strict=True):
        assert np.interp(place, *line.get_data()) == pytest.approx(float(label.get_text()), abs=2e-4)


@pytest.mark.parametrize(
    ("factor", "label", "size"), [(1.0, "force (N)", 1.0), (1e3, "force (kN)", 1e3), (1e7, "force (MN)", 1e6)]
)
def test_large_numbers_have_a_prefix_to_their_unit(story, factor, label, size):
    """Forces of a few hundred N, and so many times as large: what the labels say is what the curves show."""
    curves = [replace(curve, values=factor * curve.values) for curve in force_curves(story)]
    _, axes = charted(story, curves, "force (N)")
    assert axes.get_ylabel() == label
    highest = max(float(line.get_ydata().max()) for line in axes.lines)
    assert highest * size == pytest.approx(factor * float(story.histories[0]["lambda_n"].max()), rel=1e-6)


def test_contacts_are_shaded_where_they_are_and_time_is_on_the_axis(story):
    _, axes = charted(story, force_curves(story), "force (N)")
    course, width = story.time_map, axes.get_window_extent().width
    shaded = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in axes.patches]
    ends = [course.film_at(np.array([c.start, c.end])) for c in story.histories[0].contacts]
    np.testing.assert_allclose(shaded, np.array(ends) * width / course.duration, atol=0.1)
    assert axes.get_xlabel() == "time (s), stretched around contacts"
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["normal", "tangential"]


def test_times_of_labels_are_round_and_apart(story):
    for course in (story.time_map, story.time_map.part(0.31, 0.33), story.time_map.part(0.0, 0.2)):
        times, labels = round_times(course, 8)
        assert 4 <= len(times) <= 8
        np.testing.assert_allclose(times, [float(label) for label in labels], atol=1e-12)
        assert np.diff(course.film_at(times)).min() > 0.7 * course.duration / 8


@pytest.fixture
def panels(run, monkeypatch, tmp_path):
    """Axes of the overview of two runs, by title."""
    kept: list[Figure] = []
    monkeypatch.setattr(overview, "save_figure", lambda figure, *_: kept.append(figure))
    overview.overview_figure({"a": run("paper"), "b": run("paper", "contact.friction=frictionless")}, tmp_path)
    return {axes.get_title(loc="left"): axes for axes in kept[0].axes}


def line(axes, label):
    (found,) = (line for line in axes.lines if line.get_label() == label)
    return found.get_data()


def test_the_overview_shows_the_history_in_the_units_that_it_says(panels, run):
    history, other = run("paper"), run("paper", "contact.friction=frictionless")
    time = history["time"].values
    for title, name, xlabel, factors, ylabel in (
        ("First collision: contact force", "lambda_n", "time (ms)", (1e3, 1.0), "normal force (N)"),
        ("Distance from the slope (contact shaded)", "gap", "time (s)", (1.0, 1e3), "gap (mm)"),
    ):
        axes = panels[title]
        assert (axes.get_xlabel(), axes.get_ylabel()) == (xlabel, ylabel)
        for label, run_of in (("a", history), ("b", other)):
            x, y = line(axes, label)
            np.testing.assert_allclose(x, factors[0] * run_of["time"].values)
            np.testing.assert_allclose(y, factors[1] * run_of[name].values)
    shaded = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in axes.patches]
    np.testing.assert_allclose(shaded, [(contact.start, contact.end) for contact in history.contacts], atol=1e-12)
    axes = panels["Energy"]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("time (s)", "energy (J)")
    np.testing.assert_allclose(line(axes, "total, a")[1], sum(history[f"energy_{kind}"].values for kind in KINDS))
    for kind in ("gravity", "elastic"):
        np.testing.assert_array_equal(line(axes, kind)[1], history[f"energy_{kind}"])
    start, end = (1e3 * history.summary["macro_collisions"][0][key] for key in ("start", "end"))
    low, high = panels["First collision: contact force"].get_xlim()
    assert low < start < end < high < end + 2.0
    axes = panels["Shapes in the first collision"]
    assert axes.get_ylabel() == "deflection from the chord (mm)"
    k = int(np.searchsorted(time, history.events[0].time, side="right"))
    assert axes.lines[0].get_color() == STATE_COLOURS[int(history["state"][k])]
    named = {found.get_label(): found.get_color() for found in axes.lines if not found.get_label().startswith("_")}
    assert named == dict(zip(("free", "slip"), STATE_COLOURS, strict=False))
    chord = history["uy"].values[k, -1] * history["station"].values / history["station"].values[-1]
    np.testing.assert_allclose(axes.lines[0].get_ydata(), 1e3 * (history["uy"].values[k] - chord), atol=1e-9)
    axes = panels["The beam up to the first impact"]
    said = [text.get_text() for text in axes.texts if text.get_text().endswith(" s")]
    assert (said[0], said[-1], len(said)) == ("0.000 s", f"{history.events[0].time:.3f} s", 6)
    axes = panels["Where the energy went"]
    assert axes.get_ylabel() == "energy lost (J)"
    lost = [history.summary["energy"][f"lost_{kind.get_text()}"] for kind in axes.get_xticklabels()]
    # but for what rounding leaves
    assert [bar.get_height() for bar in axes.containers[0]] == [v if abs(v) > 1e-8 else 0.0 for v in lost]


def test_the_overview_shows_the_beam_where_it_is_at_the_time_beside_it(panels, run):
    history = run("paper")
    axes = panels["The beam up to the first impact"]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x (m)", "y (m)")
    (path,) = (found for found in axes.lines if found.get_linestyle() == ":")
    np.testing.assert_array_equal(path.get_data(), (history["tip_x"].values, history["tip_y"].values))
    labels = [text for text in axes.texts if text.get_text().endswith(" s")]
    radius = np.sqrt(314.16e-6 / np.pi)
    for label, outline in zip(labels, axes.patches, strict=False):
        near = history.data.interp(time=float(label.get_text().removesuffix(" s")))
        tip = np.array([float(near["tip_x"]), float(near["tip_y"])])
        assert np.linalg.norm(label.xy - tip) < 5e-3  # a millisecond at up to 5 m/s
        distances = np.linalg.norm(outline.get_xy() - label.xy, axis=1)
        assert distances.min() == pytest.approx(radius, rel=0.01)  # the end of the beam is around it


def test_the_overview_shows_how_far_events_are_apart(run):
    """Of two runs with the same events: the second one's are later by 1, 2, 3... microseconds."""
    history = run("paper")
    late = [event._replace(time=event.time + 1e-6 * n) for n, event in enumerate(history.events, start=1)]
    axes = overview.overview({"a": history, "b": replace(history, events=late)}).axes[-1]
    assert axes.get_title(loc="left") == "Event times: |a - b|"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("time of the event (s)", "difference (s)")
    for state, dots in zip((State.FREE, State.SLIP), axes.lines, strict=True):
        mine = np.array([event.state is state for event in history.events])
        assert (dots.get_label(), dots.get_color()) == (f"to {state.name.lower()}", STATE_COLOURS[state])
        np.testing.assert_allclose(dots.get_xdata(), np.array([event.time for event in history.events])[mine])
        np.testing.assert_allclose(dots.get_ydata(), 1e-6 * (np.flatnonzero(mine) + 1), rtol=1e-6)


def test_a_campbell_diagram_names_flapwise_and_chordwise(monkeypatch, tmp_path):
    kept: list[Figure] = []
    monkeypatch.setattr(campbell, "save_figure", lambda figure, *_: kept.append(figure))

    class Spectrum:
        def flapwise(self, spin_rate, count):
            return np.array([10.0 + spin_rate])

        def chordwise(self, spin_rate, count):
            return np.array([20.0 + spin_rate])

    campbell.campbell_diagram(Spectrum(), [0.0, 6.0], 1, tmp_path)
    axes = kept[0].axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("spin rate (rad/s)", "natural frequency (rad/s)")
    for label, start in (("flapwise", 10.0), ("chordwise", 20.0), ("once per revolution", 0.0)):
        x, y = line(axes, label)
        np.testing.assert_allclose(y, start + x)
    marks = [found.get_xdata() for found in axes.lines if np.ptp(found.get_xdata()) == 0.0]
    np.testing.assert_array_equal([mark[0] for mark in marks], [0.0, 6.0])

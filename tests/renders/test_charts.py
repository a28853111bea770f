"""What is read off charts and figures: each curve under its name, with its unit, and times where they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from oblique_impact import InputError, Scenario, natural_frequencies, simulate
from oblique_impact.contact.state import State
from oblique_impact.renders import campbell, overview
from oblique_impact.renders.charts import Chart, Curve, energy_chart, force_curves
from oblique_impact.renders.contact_map import contact_pieces
from oblique_impact.renders.player.content import content_of
from oblique_impact.renders.sheet import Sheet
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import LIGHT, STATE_COLOURS

KINDS = ("kinetic", "elastic", "gravity")


def test_each_curve_has_its_name_and_colour(story, run):
    history, other, theme = story.histories[0], run("sticking"), LIGHT
    two = story_of([history, other], names=["a", "b"])
    kinds = [(kind, colour, history[f"energy_{kind}"]) for kind, colour in zip(KINDS, theme.energies, strict=True)]
    forces = [
        (name, theme.arrow, history[key]) for name, key in (("normal", "lambda_n"), ("tangential", "lambda_tau"))
    ]
    for curves, expected in (
        (force_curves(story), forces),
        (energy_chart(story)[2], [*kinds, ("total", theme.ink, history.total_energy)]),
        (
            force_curves(two),
            [("a", theme.series[0], history["lambda_n"]), ("b", theme.series[1], other["lambda_n"])],
        ),
        (
            energy_chart(two)[2],
            [("a", theme.series[0], history.total_energy), ("b", theme.series[1], other.total_energy)],
        ),
    ):
        for curve, (label, colour, values) in zip(curves, expected, strict=True):
            assert (curve.label, curve.colour) == (label, colour)
            np.testing.assert_allclose(curve.values, values, rtol=1e-12)


def test_the_total_energy_on_elastic_pegs_counts_what_each_of_them_stores():
    pegs = "obstacles=[{kind='point', origin=[0.4,-0.02], stiffness=3e5}, {kind='point', origin=[0.7,-0.036]}]"
    keys = "contact.normal=spring contact.friction=frictionless end_time=0.45"
    history = simulate(Scenario.builtin("two-pegs", [*keys.split(), pegs]))
    curves = {curve.label: curve.values for curve in energy_chart(story_of([history]))[2]}
    assert curves["stop"].max() > 0.1
    np.testing.assert_allclose(curves["total"], history.balance["initial"], rtol=1e-9)


def test_energies_of_a_strip_that_stands_count_from_the_start(run):
    """Its weight alone would be all there is to see; those of runs side by side have one way to count."""
    history = run("shaken", "end_time=0.2")
    title, unit, curves = energy_chart(story_of([history]))
    energy = history.summary["energy"]
    gained = energy["supplied"] - sum(energy[f"lost_{cause}"] for cause in ("impact", "damping"))
    assert (title, unit) == ("energy change", "J")
    assert curves[-1].values[-1] == pytest.approx(gained, rel=1e-9)
    several = energy_chart(story_of([history, run("paper")], names=["a", "b"]))
    assert several[0] == title
    np.testing.assert_array_equal(several[2][0].values, curves[-1].values)


def charted(story, curves, label, course=None):
    """Axes of a chart of curves, 400 x 200 pixels."""
    sheet = Sheet((400, 200), story.style)
    Chart(sheet, curves, label, (0, 0, 400, 200), course or story.time_map, story)
    return sheet.figure.axes[0]


def test_a_curve_has_at_the_label_of_a_time_its_value_then(story):
    """In a part of a film; the value of this curve is its time."""
    times = story.geometries[0].times
    axes = charted(story, [Curve(times, times, "#000000", "time")], "time (s)", story.time_map.part(0.31, 0.33))
    (line,) = axes.lines
    for place, label in zip(axes.get_xticks(), axes.get_xticklabels(), strict=True):
        assert np.interp(place, *line.get_data()) == pytest.approx(float(label.get_text()), abs=2e-4)


@pytest.fixture
def panels(run, monkeypatch, tmp_path):
    """Axes of the overview of two runs, by title."""
    kept: list[Figure] = []
    monkeypatch.setattr(overview, "save_figure", lambda figure, *_: kept.append(figure))
    overview.overview_figure({"a": run("paper"), "b": run("paper", "contact.friction=frictionless")}, tmp_path)
    titles = [axes.get_title(loc="left") for axes in kept[0].axes]
    assert [title[:4] for title in titles] == [f"({letter}) " for letter in "abcdef"]
    return {title[4:]: axes for title, axes in zip(titles, kept[0].axes, strict=True)}


def line(axes, label):
    (found,) = (line for line in axes.lines if line.get_label() == label)
    return found.get_data()


def test_the_overview_shows_the_history_in_the_units_that_it_says(panels, run):
    history, other = run("paper"), run("paper", "contact.friction=frictionless")
    for title, name, xlabel, factors, ylabel in (
        ("First collision: contact force", "lambda_n", "time (ms)", (1e3, 1.0), "normal force (N)"),
        ("Distance from the slope (contact shaded)", "gap", "time (s)", (1.0, 1e3), "gap (mm)"),
    ):
        axes = panels[title]
        assert (axes.get_xlabel(), axes.get_ylabel()) == (xlabel, ylabel)
        for label, one in (("a", history), ("b", other)):
            expected = (factors[0] * one["time"].values, factors[1] * one[name].values)
            np.testing.assert_allclose(line(axes, label), expected)
    shaded = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in axes.patches]
    np.testing.assert_allclose(shaded, [(contact.start, contact.end) for contact in history.contacts], atol=1e-12)
    np.testing.assert_allclose(line(panels["Energy"], "total of a")[1], history.total_energy)
    for kind in KINDS:
        np.testing.assert_array_equal(line(panels["Energy"], f"{kind} of a")[1], history[f"energy_{kind}"])
    axes = panels["Shapes in the first collision"]
    k = int(np.searchsorted(history["time"].values, history.events[0].time, side="right"))
    assert axes.lines[0].get_color() == STATE_COLOURS[int(history["state"][k])]
    chord = history["uy"].values[k, -1] * history["station"].values / history["station"].values[-1]
    np.testing.assert_allclose(axes.lines[0].get_ydata(), 1e3 * (history["uy"].values[k] - chord), atol=1e-9)
    axes = panels["Where the energy went"]
    lost = [history.summary["energy"][f"lost_{kind.get_text()}"] for kind in axes.get_xticklabels()]
    # but for what rounding leaves
    assert [bar.get_height() for bar in axes.containers[0]] == [v if abs(v) > 1e-8 else 0.0 for v in lost]


def test_the_overview_shows_how_far_events_are_apart(run):
    """Of two runs with the same events: the second one's are later by 1, 2, 3... microseconds."""
    history = run("paper")
    late = [event._replace(time=event.time + 1e-6 * n) for n, event in enumerate(history.events, start=1)]
    axes = overview.overview({"a": history, "b": replace(history, events=late)}).axes[-1]
    assert axes.get_title(loc="left") == "(f) Event times: |a − b|"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("time of the event (s)", "difference (s)")
    for state, dots in zip((State.FREE, State.SLIP), axes.lines, strict=True):
        mine = np.array([event.state is state for event in history.events])
        assert (dots.get_label(), dots.get_color()) == (f"to {state.name.lower()}", STATE_COLOURS[state])
        np.testing.assert_allclose(dots.get_ydata(), 1e-6 * (np.flatnonzero(mine) + 1), rtol=1e-6)


def test_the_overview_of_a_run_without_contact_shows_how_it_bends_and_turns(run):
    history = run("spin-up")
    axes = {one.get_title(loc="left"): one for one in overview.overview({"": history}).axes}
    np.testing.assert_allclose(axes["(c) Deflection of the tip"].lines[0].get_ydata(), 1e3 * history["deflection"])
    np.testing.assert_array_equal(axes["(d) Rate of rotation"].lines[0].get_ydata(), history["theta_dot"])


def test_a_campbell_diagram_has_frequencies_and_multiples_of_the_spin_rate(monkeypatch, tmp_path):
    kept: list[Figure] = []
    monkeypatch.setattr(campbell, "save_figure", lambda figure, *_: kept.append(figure))
    scenario = Scenario.builtin("spin-up")
    campbell.campbell_diagram(scenario, [0.0, 4.1, 6.0], 1, tmp_path)
    axes, found = kept[0].axes[0], natural_frequencies(scenario, [0.0, 4.1, 6.0], 1)
    dots = {one.get_label(): one.get_markevery() for one in axes.lines}
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("spin rate (rad/s)", "natural frequency (rad/s)")
    ends = {text.get_text().strip(): text.xy for text in axes.texts}
    assert ends == {"1P": (6.0, 6.0), "2P": (6.0, 12.0)}
    for label, ends in (("flapwise", found.flapwise), ("chordwise", found.chordwise)):
        x, y = line(axes, label)
        np.testing.assert_allclose([x[dots[label]], y[dots[label]]], [[0.0, 4.1, 6.0], ends[:, 0]])
    with pytest.raises(InputError, match=r"speeds: .* above 0"):
        campbell.campbell_diagram(scenario, [0.0], 1, tmp_path)


#: many places on a table, its corner, two pegs that stick for a while
TOUCHING = {
    "slap": ("slap", "end_time=0.385"),
    "edge": ("edge", "end_time=0.39"),
    "pegs": ("two-pegs", "initial.angle=-0.0499", "beam.kelvin_voigt=1e-3", "end_time=0.1"),
}


def closed_at(history, sample):
    """Places, forces and sticking of the contacts that are closed at a sample, along the beam."""
    state, place, force = (history[f"contact_{name}"].values[sample] for name in ("state", "place", "lambda_n"))
    return sorted((place[i], force[i], state[i] == State.STICK) for i in np.flatnonzero(state != State.FREE))


@pytest.mark.parametrize("case", TOUCHING)
def test_pieces_of_contacts_have_place_force_and_state_of_every_sample(run, case):
    touching = run(*TOUCHING[case])
    pieces, times = contact_pieces(touching), touching["time"].values
    events = np.array([event.time for event in touching.events])
    # at an event there are two states, at a jump two samples
    between = np.abs(times[:, None] - events).min(axis=1) > 1e-9
    between &= np.minimum(np.diff(times, prepend=-1.0), np.diff(times, append=np.inf)) > 1e-9
    for k in np.flatnonzero(between & (times > events[0]) & (times < times[-1])):
        there = (pieces.start < times[k]) & (times[k] < pieces.end)
        found = sorted(zip(pieces.place[there], pieces.force[there], pieces.stuck[there], strict=True))
        assert found == closed_at(touching, k)
    for number, contact in enumerate(touching.contacts):
        own = pieces.contact == number
        assert (pieces.start[own][0], pieces.end[own][-1]) == (contact.start, contact.end)
        np.testing.assert_array_equal(pieces.start[own][1:], pieces.end[own][:-1])
        if contact.end > contact.start and not np.any((times >= contact.start) & (times <= contact.end)):
            # it has no sample, but its impulse is known
            impulse = pieces.force[own] * (contact.end - contact.start)
            assert impulse == pytest.approx([contact.normal_impulse])


def test_overview_and_page_have_a_map_of_contacts_where_several_places_can_touch(run):
    for name, mapped in (("paper", False), ("slap", True)):
        history = run(name)
        titles = [axes.get_title(loc="left") for axes in overview.overview({"": history}).axes]
        assert any("where the beam touches" in title for title in titles) == mapped
        page = content_of(story_of([history]))
        assert ("places" in [chart.name for chart in page.charts]) == mapped
    frame = int(np.argmin(np.abs(page.arrays["time"] - 0.3797)))
    k = int(np.flatnonzero(history["time"].values == page.arrays["time"][frame])[0])
    places = [place for place, *_ in closed_at(history, k)]
    assert page.texts["touched_text"][frame] == f"{places[0]:.3f} to {places[-1]:.3f} m"

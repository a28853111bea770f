"""What is read off charts and figures: each curve under its name, with its unit, and times where they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from oblique_impact import InputError, Scenario, natural_frequencies, simulate
from oblique_impact.contact.state import State
from oblique_impact.renders import campbell, panels
from oblique_impact.renders.charts import Chart
from oblique_impact.renders.contact_map import contact_pieces, draw_contact_map
from oblique_impact.renders.overview import overview
from oblique_impact.renders.panels import Curve, Curves, Runs
from oblique_impact.renders.player.content import content_of
from oblique_impact.renders.sheet import Sheet
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import LIGHT, STATE_COLOURS

KINDS = ("kinetic", "elastic", "gravity")


def alone(history):
    """The panels' runs of a single one."""
    return Runs([history], [""])


def test_each_curve_has_its_name_and_colour(run):
    history, other, theme = run("paper"), run("sticking"), LIGHT
    two, both = Runs([history, other], ["a", "b"]), zip("ab", theme.series, (history, other), strict=False)
    both = list(both)
    kinds = [(kind, colour, history[f"energy_{kind}"]) for kind, colour in zip(KINDS, theme.energies, strict=True)]
    pushes = [
        (name, theme.arrow, history[key]) for name, key in (("normal", "lambda_n"), ("tangential", "lambda_tau"))
    ]
    for panel, expected in (
        (panels.forces(alone(history)), pushes),
        (panels.energy(alone(history)), [*kinds, ("total", theme.ink, history.total_energy)]),
        (panels.forces(two), [(name, colour, one["lambda_n"]) for name, colour, one in both]),
        (panels.gap(two), [(name, colour, one["gap"]) for name, colour, one in both]),
        (panels.energy(two), [(name, colour, one.total_energy) for name, colour, one in both]),
    ):
        for curve, (label, colour, values) in zip(panel.curves, expected, strict=True):
            assert (curve.label, curve.colour) == (label, colour)
            np.testing.assert_allclose(curve.values, values, rtol=1e-12)


def test_the_total_energy_on_elastic_pegs_counts_what_each_of_them_stores():
    pegs = "obstacles=[{kind='point', origin=[0.4,-0.02], stiffness=3e5}, {kind='point', origin=[0.7,-0.036]}]"
    keys = "contact.normal=spring contact.friction=frictionless end_time=0.45"
    history = simulate(Scenario.builtin("two-pegs", [*keys.split(), pegs]))
    curves = {curve.label: curve.values for curve in panels.energy(alone(history)).curves}
    assert curves["stop"].max() > 0.1
    np.testing.assert_allclose(curves["total"], history.balance["initial"], rtol=1e-9)


def test_energies_of_a_strip_that_stands_count_from_the_start(run):
    """Its weight alone would be all there is to see; those of runs side by side have one way to count."""
    history = run("shaken", "end_time=0.2")
    panel = panels.energy(alone(history))
    energy = history.summary["energy"]
    gained = energy["supplied"] - sum(energy[f"lost_{cause}"] for cause in ("impact", "damping"))
    assert (panel.title, panel.unit) == ("energy change", "J")
    assert panel.curves[-1].values[-1] == pytest.approx(gained, rel=1e-9)
    several = panels.energy(Runs([history, run("paper")], ["a", "b"]))
    assert several.title == "total energy change"
    np.testing.assert_array_equal(several.curves[0].values, panel.curves[-1].values)


def charted(story, curves, course=None):
    """Axes of a chart of curves of times, 400 x 200 pixels."""
    sheet = Sheet((400, 200), story.style)
    Chart(sheet, Curves("time", "s", curves), (0, 0, 400, 200), course or story.time_map, story)
    return sheet.figure.axes[0]


def test_a_curve_has_at_the_label_of_a_time_its_value_then(story):
    """In a part of a film; the value of this curve is its time."""
    times = story.geometries[0].times
    axes = charted(story, [Curve(times, times, "#000000", "time")], story.time_map.part(0.31, 0.33))
    (line,) = axes.lines
    for place, label in zip(axes.get_xticks(), axes.get_xticklabels(), strict=True):
        assert np.interp(place, *line.get_data()) == pytest.approx(float(label.get_text()), abs=2e-4)


@pytest.fixture(scope="module")
def shown(run):
    """Axes of the overview of two runs, by title."""
    drawn = overview(
        story_of([run("paper"), run("paper", "contact.friction=frictionless")], names=["a", "b"])
    ).axes
    titles = [axes.get_title(loc="left") for axes in drawn]
    assert [title[:4] for title in titles] == [f"({letter}) " for letter in "abcdefghij"]
    return {title[4:]: axes for title, axes in zip(titles, drawn, strict=True)}


def line(axes, label):
    (found,) = (line for line in axes.lines if line.get_label() == label)
    return found.get_data()


def test_the_overview_shows_the_histories_in_the_units_that_it_says(shown, run):
    runs = {"a": run("paper"), "b": run("paper", "contact.friction=frictionless")}
    for title, values, xlabel, factor, ylabel in (
        ("First collision: normal force", lambda one: one["lambda_n"], "time (ms)", 1e3, "normal force (N)"),
        ("Gap (contact shaded)", lambda one: one["gap"], "time (s)", 1.0, "gap (m)"),
        ("Total energy", lambda one: one.total_energy, "time (s)", 1.0, "total energy (J)"),
    ):
        axes = shown[title]
        assert (axes.get_xlabel(), axes.get_ylabel()) == (xlabel, ylabel)
        for label, one in runs.items():
            x, y = line(axes, label)
            inside = np.isin(factor * one["time"].values, x)
            assert np.count_nonzero(inside) == x.size > 100
            np.testing.assert_allclose(y, values(one).values[inside], rtol=1e-12)
    history, axes = runs["a"], shown["Gap (contact shaded)"]
    shaded = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in axes.patches]
    np.testing.assert_allclose(shaded, [(contact.start, contact.end) for contact in history.contacts], atol=1e-12)
    axes = shown["Shapes in the first collision"]
    k = int(np.searchsorted(history["time"].values, history.events[0].time, side="right"))
    assert axes.lines[0].get_color() == STATE_COLOURS[int(history["state"][k])]
    chord = history["uy"].values[k, -1] * history["station"].values / history["station"].values[-1]
    np.testing.assert_allclose(axes.lines[0].get_ydata(), 1e3 * (history["uy"].values[k] - chord), atol=1e-9)
    axes = shown["Where the energy went"]
    lost = [history.summary["energy"][f"lost_{kind.get_text()}"] for kind in axes.get_xticklabels()]
    # but for what rounding leaves
    assert [bar.get_height() for bar in axes.containers[0]] == [v if abs(v) > 1e-8 else 0.0 for v in lost]


def test_the_overview_of_a_run_is_drawn_from_the_panels_of_its_film_and_page(run):
    """Labels of curves, units and values are those of the page, whose time is another."""
    history = run("paper")
    drawn = {axes.get_title(loc="left")[4:]: axes for axes in history.plot().axes}
    charts = {chart.name: chart for chart in content_of(story_of([history])).charts}
    for title, name in (("First collision: contact force", "force"), ("Energy", "energy")):
        axes, chart = drawn[title], charts[name]
        assert axes.get_ylabel().lower() == chart.title.lower()
        assert [one.get_label() for one in axes.lines] == [curve.label for curve in chart.curves]
        for curve, one in zip(chart.curves, axes.lines, strict=True):
            assert set(one.get_ydata()) <= set(curve.values)


@pytest.mark.parametrize("case", ["paper", "slap"])
def test_the_envelope_has_the_least_and_the_largest_value_of_each_station(run, case):
    history = run(case)
    axes = {one.get_ylabel(): one for one in history.plot().axes}
    at_stations = {
        "moment (N m)": (1.0, history.section_forces()["moment"]),
        "shear (N)": (1.0, history.section_forces()["shear"]),
        "bending stress (MPa)": (1e6, history.section_forces()["bending_stress"]),
        "deflection (mm)": (1e-3, history["uy"]),
    }
    for label, (unit, values) in at_stations.items():
        low, high = axes[label].lines
        for one, extreme in ((low, np.min), (high, np.max)):
            np.testing.assert_array_equal(one.get_xdata(), history["station"])
            np.testing.assert_allclose(unit * one.get_ydata(), extreme(values.values, axis=0), rtol=1e-12)


def test_the_envelope_of_a_held_beam_under_a_slow_load_is_that_of_statics():
    """A uniform load w, of the shaken base, that goes slowly from 0 to both of its extremes.

    Moment w (L - x)^2/2, shear w (L - x), deflection w x^2 (6 L^2 - 4 L x + x^2)/(24 EI), of both signs.  What
    begins at rest swings beside them by the ratio of the frequencies, 0.25 to 14 Hz.
    """
    keys = {"root__kind": "driven", "initial__angle": 0.0, "contact__enabled": False, "gravity": 0.0}
    keys |= {"base__acceleration": 9.0, "base__frequency": 0.25, "end_time": 4.0, "discretization__modes": 4}
    history = simulate(Scenario.builtin("paper").adapted(**keys, solver__output_interval=1e-3))
    beam, x = history.scenario.beam, history["station"].values
    load, length = 9.0 * beam.density * beam.area, beam.length
    stiffness = beam.youngs_modulus * beam.second_moment
    for name, exact in (
        ("moment", 0.5 * load * (length - x) ** 2),
        ("shear", load * (length - x)),
        ("uy", load * x**2 * (6.0 * length**2 - 4.0 * length * x + x**2) / (24.0 * stiffness)),
    ):
        low, high = panels.envelope(history, name)
        np.testing.assert_allclose([-low, high], [exact, exact], rtol=0.0, atol=0.025 * exact.max())


def test_the_overview_shows_how_far_events_are_apart(run):
    """Of two runs with the same events: the second one's are later by 1, 2, 3... microseconds."""
    history = run("paper")
    late = [event._replace(time=event.time + 1e-6 * n) for n, event in enumerate(history.events, start=1)]
    axes = overview(story_of([history, replace(history, events=late)], names=["a", "b"])).axes[5]
    assert axes.get_title(loc="left") == "(f) Event times: |a − b|"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("time of the event (s)", "difference (s)")
    for state, dots in zip((State.FREE, State.SLIP), axes.lines, strict=True):
        mine = np.array([event.state is state for event in history.events])
        assert (dots.get_label(), dots.get_color()) == (f"to {state.name.lower()}", STATE_COLOURS[state])
        np.testing.assert_allclose(dots.get_ydata(), 1e-6 * (np.flatnonzero(mine) + 1), rtol=1e-6)


def test_the_overview_of_a_run_without_contact_shows_how_it_bends_and_turns(run):
    history = run("spin-up")
    axes = {one.get_title(loc="left"): one for one in history.plot().axes}
    deflection = axes["(c) Deflection of the tip"]
    assert deflection.get_ylabel() == "deflection of the tip (m)"
    np.testing.assert_array_equal(deflection.lines[0].get_ydata(), history["deflection"])
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
    if touching.scenario.solver.scheme == "time-stepping":  # the sample at the end of a step has its mean force
        since = times[:, None] - events
        between &= ~((since > 0.0) & (since < touching.scenario.solver.contact_step)).any(axis=1)
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


def test_a_map_of_one_contact_point_is_one_row(run):
    history = run("paper")
    assert set(contact_pieces(history).place) == {1.0}
    axes = Figure().subplots()
    draw_contact_map(axes, history)
    drawn = np.concatenate([patch.get_path().vertices for patch in axes.patches])
    assert {round(y, 12) for y in drawn[:, 1]} == {1.0 - 1 / 64, 1.0 + 1 / 64}


def test_overview_and_page_have_a_map_of_contacts_where_several_places_can_touch(run):
    for name, mapped in (("paper", False), ("slap", True)):
        history = run(name)
        titles = [axes.get_title(loc="left") for axes in history.plot().axes]
        assert any("where the beam touches" in title for title in titles) == mapped
        page = content_of(story_of([history]))
        assert ("places" in [chart.name for chart in page.charts]) == mapped
    frame = int(np.argmin(np.abs(page.arrays["time"] - 0.3797)))
    k = int(np.flatnonzero(history["time"].values == page.arrays["time"][frame])[0])
    places = [place for place, *_ in closed_at(history, k)]
    assert page.texts["touched_text"][frame] == f"{places[0]:.3f} to {places[-1]:.3f} m"

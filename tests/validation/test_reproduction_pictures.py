"""What the reproduction's pictures show: curves and marks at their places, units, legends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_rgba

from oblique_impact.contact.state import State
from oblique_impact.renders.style import STATE_COLOURS
from oblique_impact.validation.reproduction import diagrams, pictures
from oblique_impact.validation.reproduction.claims import NOT, PARTLY, REPRODUCED
from oblique_impact.validation.reproduction.diagrams import choices_diagram, robustness_diagram, sticking_diagram
from oblique_impact.validation.reproduction.material import Material
from oblique_impact.validation.reproduction.measures import Trio
from oblique_impact.validation.reproduction.pictures import PLOTS, draw, window

from .test_reproduction import made
from .test_reproduction_report import FIRST, GRID, JUDGED, SECOND, STUDIED, check, ran

BY_NUMBER = {plot.number: plot for plot in PLOTS}
SLIP, STICK = (to_rgba(STATE_COLOURS[state]) for state in (State.SLIP, State.STICK))


@pytest.fixture(autouse=True)
def _figures(monkeypatch):
    """Pictures are figures, whose lines can be read, instead of text."""
    for module in (pictures, diagrams):
        monkeypatch.setattr(module, "to_svg", lambda figure: figure)


def drawn(axes, **wanted):
    """(x, y) of the lines with given properties."""
    found = [line for line in axes.lines if all(getattr(line, f"get_{k}")() == v for k, v in wanted.items())]
    return [[list(np.asarray(values, dtype=float)) for values in line.get_data()] for line in found]


def entries(figure):
    (legend,) = figure.legends
    return {
        text.get_text(): handle for text, handle in zip(legend.get_texts(), legend.legend_handles, strict=True)
    }


def slipping(*slopes):
    return Trio(*(ran(macros=(FIRST, SECOND), slip=lambda t, k=k: k * t) for k in slopes))


def touching(*macros):
    return Trio(*(made(macros=own) for own in macros))


def test_schemes_are_one_above_the_other_and_models_have_their_lines():
    figure = draw(BY_NUMBER["14"], {"fixed-step": slipping(1.0, 2.0, 3.0), "event": slipping(4.0, 5.0, 6.0)})
    assert [axes.get_title(loc="left") for axes in figure.axes] == [
        "(a) fixed-step, as printed",
        "(b) event-located",
    ]
    last = [{line.get_label(): line.get_ydata()[-1] for line in axes.lines} for axes in figure.axes]
    assert last == [
        {"hybrid": 1.0, "frictionless": 2.0, "modified Coulomb": 3.0},
        {"hybrid": 4.0, "frictionless": 5.0, "modified Coulomb": 6.0},
    ]
    for axes in figure.axes:
        assert axes.get_ylabel() == r"$Z_\tau$ (m)"
        for line in axes.lines:
            assert line.get_color() == entries(figure)[line.get_label()].get_color()
    assert (figure.axes[1].get_xlabel(), figure.axes[1].get_xlim()) == ("time (s)", (0.0, 1.0))
    assert figure.get_suptitle() == "Fig. 14  Impact point along O₁X₁"


def test_a_collision_is_drawn_in_milliseconds_with_its_marks_and_the_paper_s_instant():
    figure = draw(BY_NUMBER["15"], {name: slipping(1.0, 0.0, 0.0) for name in ("fixed-step", "event")})
    axes = figure.axes[1]
    assert axes.get_xlabel() == "time (ms)"
    assert axes.get_xlim() == pytest.approx((297.6, 342.4))
    for part in figure.axes:
        assert drawn(part, marker="v") == [[[310.0, 327.0], pytest.approx([310.0, 327.0])]]
        assert drawn(part, marker="o") == [[[320.0, 330.0], pytest.approx([320.0, 330.0])]]
        assert drawn(part, linestyle=":") == [[[325.0, 325.0], [0.0, 1.0]]]
    legend = entries(figure)
    assert list(legend)[3:] == ["slip reverses", "judged stick", "paper"]
    assert [legend[name].get_marker() for name in list(legend)[3:5]] == ["v", "o"]
    assert to_rgba(legend["judged stick"].get_color()) == STICK
    assert legend["paper"].get_linestyle() == ":"


def test_a_figure_without_an_instant_of_the_paper_has_no_marks():
    figure = draw(BY_NUMBER["2a"], {name: slipping(1.0, 0.0, 0.0) for name in ("fixed-step", "event")})
    assert list(entries(figure)) == ["hybrid", "frictionless", "modified Coulomb"]
    assert drawn(figure.axes[0], marker="v") == drawn(figure.axes[0], linestyle=":") == []


def test_the_window_of_a_collision_holds_all_runs_and_what_the_paper_names():
    early, late = [(0.30, 0.32), (0.66, 0.69)], [(0.31, 0.35), (0.65, 0.67)]
    runs = {"fixed-step": touching(early, early, late), "event": touching(early, early, early)}
    assert window(runs, BY_NUMBER["2a"]) == pytest.approx((0.297, 0.353))
    assert window(runs, BY_NUMBER["16"]) == pytest.approx((0.65 - 0.06 * 0.049, 0.699 + 0.06 * 0.049))
    assert window(runs, BY_NUMBER["5a"]) == (0.64, 0.76)
    assert window(runs, BY_NUMBER["5"]) == (0.0, 1.0)


def test_stick_is_drawn_with_its_velocity_its_ratio_and_what_friction_can_hold():
    run = ran(
        checks=[check(0.31), check(0.32, "stick"), check(0.9)],
        slip_rate=lambda t: 1.0 - t,
        state=lambda t: np.select([t < 0.3, t < 0.32, t < 0.34], [0, 1, 2], 0),
        stick_normal=lambda t: np.where(t < 0.31, -1.0, 2.0),
        stick_tangential=lambda t: -20.0 * t,
    )
    figure = sticking_diagram(run, [(0.295, 0.335), (0.8, 0.95)], "A title")
    speed, later, ratio, _ = figure.axes
    assert figure.get_suptitle() == "A title"
    assert speed.get_ylabel() == "slip velocity (m/s)"
    assert ratio.get_ylabel() == r"$|\lambda_\tau|/\lambda_n$ to stick (–)"
    assert (ratio.get_xlabel(), ratio.get_xlim()) == ("time (ms)", pytest.approx((295.0, 335.0)))
    assert drawn(speed, marker="v") == [[[310.0], pytest.approx([0.69])]]
    assert drawn(speed, marker="o") == [[[320.0, 330.0], pytest.approx([0.68, 0.67])]]
    assert drawn(later, marker="v") == [[[900.0], pytest.approx([0.1])]]
    spans = {
        to_rgba(line.get_color()): np.array(line.get_data()) for line in speed.lines if line.get_marker() == "None"
    }
    for colour, start, end in ((SLIP, 300.0, 319.0), (STICK, 320.0, 339.0)):
        time, value = spans[colour][:, np.isfinite(spans[colour][1])]
        assert (time[0], time[-1]) == pytest.approx((start, min(end, 335.0)))
        assert value == pytest.approx(1.0 - 1e-3 * time)
    curve, limit = ratio.lines
    pulls = curve.get_xdata() < 309.5
    assert np.isnan(curve.get_ydata()[pulls]).all()
    assert curve.get_ydata()[~pulls] == pytest.approx(10.0 * 1e-3 * curve.get_xdata()[~pulls])
    assert list(limit.get_ydata()) == [0.3, 0.3]
    assert ratio.patches[0].get_y() + ratio.patches[0].get_height() == pytest.approx(0.3)
    names = ["slip", "stick", "slip reverses", "stick begins", "sticking solution", "below μ = 0.3"]
    legend = entries(figure)
    assert list(legend) == names
    assert [to_rgba(legend[name].get_color()) for name in ("slip", "stick")] == [SLIP, STICK]
    assert [legend[name].get_marker() for name in ("slip reverses", "stick begins")] == ["v", "o"]


def test_choices_are_drawn_at_their_times_and_impulses():
    figure = choices_diagram(STUDIED)
    first, second, impulses = figure.axes
    assert [axes.get_title(loc="left") for axes in figure.axes] == [
        "first macro-collision",
        "second macro-collision",
        "impulses",
    ]
    assert [drawn(axes, linestyle=":")[0][0] for axes in (first, second)] == [[0.325, 0.325], [0.699, 0.699]]
    bold = [label.get_text() for label in first.get_yticklabels() if label.get_fontweight() == "bold"]
    assert bold == ["kind of beam", "integrator"]
    assert len(drawn(first, marker=".")) == 2 * len(STUDIED)
    assert drawn(first, marker=".")[0][0] == [0.31]
    sticks = [line for line in first.lines if line.get_marker() == "|"]
    assert [line.get_xdata()[0] for line in sticks[:2]] == [0.32, 0.33]
    assert all(to_rgba(line.get_color()) == STICK for line in sticks)
    stays = [(bar.get_x(), bar.get_width(), to_rgba(bar.get_facecolor())[:3]) for bar in first.patches[:4]]
    wanted = [(0.30, 0.01, SLIP), (0.31, 0.01, SLIP), (0.32, 2e-4, STICK), (0.3202, 0.0068, SLIP)]
    assert stays == [(pytest.approx(start), pytest.approx(length), c[:3]) for start, length, c in wanted]
    shown = [(m, x[0]) for m in "os" for x, _ in drawn(impulses, marker=m)]
    first_normal, second_normal = (1.5, 1.25, 1.75, 1.125, 1.5), (0.75, 0.75, 0.75, np.nan, 0.75)
    assert [m for m, _ in shown] == [*"ooooo", *"sssss"]
    np.testing.assert_array_equal([value for _, value in shown], [*first_normal, *second_normal])
    filled = [line.get_markerfacecolor() != "white" for line in impulses.lines if line.get_marker() == "o"]
    assert filled == [True, False, True, False, True]
    legend = entries(figure)
    assert [legend[name].get_marker() for name in ("first collision", "second collision")] == ["o", "s"]
    assert legend["open: event-located"].get_markerfacecolor() == "white"


def test_a_collision_outside_of_the_window_is_told_in_a_word():
    early = replace(STUDIED[0], run=ran(macros=(FIRST, replace(SECOND, start=0.50, end=0.52))))
    (text,) = (text.get_text() for text in choices_diagram([early]).axes[1].texts)
    assert text == " ◂ 0.500 s"


def test_robustness_is_counted_in_the_colours_of_the_verdicts():
    figure = robustness_diagram(Material({}, {}, JUDGED, [], GRID, (0.0, [])))
    (axes,) = figure.axes
    assert [label.get_text() for label in axes.get_yticklabels()] == ["one", "two"]
    bars = [(bar.get_x(), bar.get_width(), bar.get_facecolor()) for bar in axes.patches]
    colours = {name: to_rgba(handle.get_facecolor()) for name, handle in entries(figure).items()}
    assert list(colours) == [REPRODUCED, PARTLY, NOT]
    assert [bar for bar in bars if bar[1]] == [
        (0, 6, colours[REPRODUCED]),
        (0, 1, colours[REPRODUCED]),
        (1, 2, colours[PARTLY]),
        (3, 3, colours[NOT]),
    ]
    assert [(text.get_position(), text.get_text()) for text in axes.texts] == [
        ((3.0, 0), "6"),
        ((0.5, 1), "1"),
        ((2.0, 1), "2"),
        ((4.5, 1), "3"),
    ]

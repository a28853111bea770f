"""The reproduction of the paper: cases, figures, and the whole of it, reduced."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from oblique_impact import Scenario
from oblique_impact.renders.style import figure_style
from oblique_impact.validation.paper import measures
from oblique_impact.validation.paper.figures import PLOTS, draw_on, window
from oblique_impact.validation.paper.measures import Models, cases, combinations, paper, run_light, sticks
from oblique_impact.validation.paper.rules import CLAIMS, VERDICTS

from .test_paper_claims import event, made

BY_NUMBER = {plot.number: plot for plot in PLOTS}
FIRST, SECOND = (0.30, 0.34), (0.68, 0.71)

# --- cases


def test_fixed_step_is_as_printed():
    """The steps and Baumgarte's parameters of the paper, Sec. 7; stick judged by the force alone, Sec. 5.3."""
    solver = cases()["paper/fixed-step/hybrid"].solver
    assert (solver.free_step, solver.contact_step, solver.stick) == (1e-4, 1e-6, "force")
    assert solver.baumgarte == (10.0, 1000.0)


def test_combinations_are_all_different():
    assert len({paper(**changes).to_toml() for changes in combinations()}) == len(combinations()) == 48


# --- runs


def test_the_sticking_scenario_sticks_to_the_end_at_rest():
    run = run_light(Scenario.builtin("sticking"))
    assert all(abs(stay.slip_rate) < 1e-9 for stay in sticks(run))
    assert sticks(run)[-1].end == run.end_time


def test_stays_judged_stick_as_printed_move():
    """Without the tip's shortening in the contact rows short sticks occur (theory, Sec. 4), at full speed."""
    scenario = paper("fixed-step", contact__shortening=False, end_time=0.34)
    run = run_light(scenario)
    starts = [stay.start for stay in sticks(run)]
    assert all(min(abs(start - expected) for start in starts) < 1e-4 for expected in (0.3232, 0.3250, 0.3268))
    assert max(abs(stay.slip_rate) for stay in sticks(run)) > 0.2


# --- figures


def both(*slopes, events=()):
    """Runs of both schemes and three models in which the slip (m) grows with time."""
    runs = [made(events, (FIRST, SECOND), slip=lambda t, k=k: k * t) for k in slopes]
    for run in runs:
        run["slip"].attrs["units"] = "m"
    return {"fixed-step": Models(*runs[:3]), "event": Models(*runs[3:])}


def drawn(number, schemes):
    with figure_style():
        figure = Figure(layout="constrained")
        draw_on(figure, BY_NUMBER[number], schemes)
    return figure


def test_a_panel_of_each_scheme_has_the_lines_of_the_models():
    above, below = drawn(14, both(1.0, 2.0, 3.0, 4.0, 5.0, 6.0)).axes
    last = [{line.get_label(): line.get_ydata()[-1] for line in axes.lines} for axes in (above, below)]
    assert last == [
        {"hybrid": 1.0, "frictionless": 2.0, "modified Coulomb": 3.0},
        {"hybrid": 4.0, "frictionless": 5.0, "modified Coulomb": 6.0},
    ]
    assert [axes.get_ylabel() for axes in (above, below)] == [r"place $Z_\tau$ (m)"] * 2
    assert below.get_xlabel() == "time (s)"


def test_a_collision_is_drawn_in_milliseconds_and_mm_with_its_marks_and_the_paper_s_instant():
    states = {0.30: "impact SLIP", 0.31: "reversal SLIP", 0.32: "stick STICK", 0.34: "release FREE"}
    events = [event(time, *words.split()) for time, words in states.items()]
    figure = drawn(15, both(1.0, 0.0, 0.0, 1.0, 0.0, 0.0, events=events))
    assert figure.axes[1].get_xlabel() == "time (ms)"
    for axes in figure.axes:
        marks = {line.get_marker(): line for line in axes.lines}
        assert axes.get_ylabel() == r"place $Z_\tau$ (mm)"
        assert np.ravel(marks["v"].get_data()) == pytest.approx([310.0, 310.0])
        assert np.ravel(marks["o"].get_data()) == pytest.approx([320.0, 320.0])
        (paper_line,) = (line for line in axes.lines if line.get_label() == "paper")
        assert list(paper_line.get_xdata()) == [325.0, 325.0]


def test_the_window_of_a_collision_holds_all_runs_and_what_the_paper_names():
    early, late = (made(macros=m) for m in ([(0.30, 0.32), (0.66, 0.69)], [(0.31, 0.35), (0.65, 0.67)]))
    schemes = {"fixed-step": Models(early, early, late), "event": Models(early, early, early)}
    assert window(BY_NUMBER[15], schemes) == pytest.approx((0.297, 0.353))
    assert window(BY_NUMBER[16], schemes) == pytest.approx((0.65 - 0.06 * 0.049, 0.699 + 0.06 * 0.049))
    assert window(BY_NUMBER[5], schemes) == (0.0, 1.0)


# --- all of it


@pytest.fixture
def reduced(monkeypatch):
    """Coarser samples, one combination."""
    coarse = {key: scenario.replace(solver__output_interval=2e-4) for key, scenario in cases().items()}
    monkeypatch.setattr(measures, "cases", lambda: coarse)
    monkeypatch.setattr(measures, "combinations", lambda: combinations()[:1])


def test_a_reproduction_through_the_command(reduced, tmp_path, cli):
    code, out, _ = cli("reproduce", "--out", tmp_path, "--workers", 1)
    assert code == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        *("combinations.csv", "figures", "report.html", "results.csv", "results.json"),
    ]
    data = json.loads((tmp_path / "results.json").read_text())
    verdicts = {claim["claim"]: claim["verdict"] for claim in data["claims"]}
    assert list(verdicts) == [claim.id for claim in CLAIMS]
    assert all(claim in out for claim in verdicts)
    assert set(verdicts.values()) == set(VERDICTS)
    # theory, Sec. 8: what two clamped modes reproduce, and what no choice does
    assert verdicts["friction-coincides"] == verdicts["friction-drifts-apart"] == "reproduced"
    assert verdicts["stick-at-0.699"] == verdicts["stick-to-the-end"] == "not reproduced"
    (point,) = data["combinations"]
    assert (point["modes"], point["gravity"], point["first-collision"]) == (1, 9.8, "partly")
    counts = [[claim[f"combinations_{v.replace(' ', '_')}"] for v in VERDICTS] for claim in data["claims"]]
    assert {None if None in count else sum(count) for count in counts} == {1, None}
    (first, *_) = data["runs"]["paper/event/hybrid"]["macro_collisions"]
    assert first["normal_impulse"] == pytest.approx(1.8471, 1e-4)
    page = (tmp_path / "report.html").read_text()
    figures = sorted(path.name for path in (tmp_path / "figures").iterdir())
    assert figures == [f"fig{number:02d}.svg" for number in range(2, 17)]
    assert page.count("<svg") == 15
    table = pd.read_csv(tmp_path / "results.csv").set_index("claim")
    assert table["verdict"].to_dict() == verdicts
    assert table["ours_event"].iloc[0] == data["claims"][0]["ours_event"]
    (row,) = pd.read_csv(tmp_path / "combinations.csv").to_dict("records")
    assert (row["modes"], row["second_start"]) == (1, point["second_start"])
    assert row["first-collision"] == "partly"

"""Steady states on a shaken base: what counts as periodic, and sweeps that go on from state to state."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from oblique_impact import InputError, Outcome, Scenario, simulate
from oblique_impact.validation import PeriodicSection, periodic_response, sweep
from oblique_impact.validation.studies.design import make_plan
from oblique_impact.validation.studies.maps import draw_responses
from oblique_impact.validation.studies.periodic import drive_period, steady_state
from oblique_impact.validation.studies.quantities import not_determined
from oblique_impact.validation.studies.study import TABLE, motion_state
from tests.refusals import refused_in_one_line

STRIP = Scenario.builtin("shaken", ["discretization.modes=2", "solver.output_interval=2e-3"])
#: up and down over the frequencies of a jump: two of them have two motions
SWEEP = """
scenario = "shaken"
changes.discretization.modes = 2
quantities = ["period", "impacts_per_period", "max:bending_stress", "supplied", "energy_lost"]
[periodic]
tolerance = 1e-4
[[axes]]
key = "base.frequency"
values = [15.0, 16.0, 17.0]
"""


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("jump")
    return folder, sweep(make_plan(SWEEP), folder, workers=1).frame


def test_a_history_of_a_steady_state_begins_and_ends_in_the_same_state():
    shaken, settings = STRIP.replace(base__frequency=13.0), PeriodicSection(tolerance=1e-8)
    result = periodic_response(shaken, settings=settings)
    history = result.histories["response"]
    assert result.verdicts == {"periodic": len(result.frame)}
    assert result["period"].value == result["impacts_per_period"].value == 1.0
    assert result["max:deflection"].value == float(history["deflection"].max())
    (picture,) = result.pictures
    assert "<svg" in picture.svg
    found, energy = history.summary["periodic"], history.balance
    assert (found["period"], found["measured"], found["impacts_per_period"]) == (1, 1, 1.0)
    assert history.end_time == pytest.approx(1.0 / 13.0)
    for name in ("q", "qd"):
        assert np.ptp(history[name].values[[0, -1]], axis=0).max() < 1e-8 * np.abs(history[name].values).max()
    assert found["samples"] == pytest.approx([float(history["deflection"][-1])], rel=1e-7)
    assert energy["supplied"] == pytest.approx(energy["lost_damping"], rel=1e-6)
    again = steady_state(STRIP.replace(base__frequency=13.0), (history["q"].values[-1], history["qd"].values[-1]))
    assert again.summary["periodic"]["transient"] == 16  # which are looked at, and are steady


def test_a_steady_state_under_damping_by_mode_is_determined():
    """Its contacts, one a period, are one macro-collision; from another start it comes to the same numbers."""
    ruler = STRIP.replace(beam__kelvin_voigt=0.0, beam__modal_damping_ratio=0.01, base__frequency=13.0)
    whole = simulate(ruler.replace(end_time=4.0))
    assert whole.macro_collisions[-1]["contacts"] > 40
    assert not any("not determined" in warning for warning in whole.summary["warnings"])
    assert not_determined(("impulse", "second_impulse", "energy_final", "max:lambda_n"), whole) == {}
    one = steady_state(ruler, settings=PeriodicSection(tolerance=1e-8))
    bent = np.array([1.0, 1.02, 1.02])  # the root is held
    state = bent * one["q"].values[-1], 0.98 * one["qd"].values[-1]
    other = steady_state(ruler, state, settings=PeriodicSection(tolerance=1e-8))
    assert other.summary["periodic"]["transient"] > 32
    for entry in ("normal_impulse", "peak_force", "start"):
        values = [history.macro_collisions[0][entry] for history in (one, other)]
        assert values[0] == pytest.approx(values[1], rel=1e-6), entry


def test_contacts_on_a_shaken_base_are_counted_by_its_periods():
    """Without damping too: 31 contacts in a row, one or two a period, are none that wave packets make."""
    undamped = STRIP.replace(beam__kelvin_voigt=0.0, discretization__modes=6, base__frequency=13.0, end_time=2.6)
    history = simulate(undamped)
    assert max(collision["contacts"] for collision in history.macro_collisions) > 20
    assert not any("magnifies" in warning for warning in history.summary["warnings"])


def test_a_motion_that_has_not_settled_in_time_has_no_period_everywhere(tmp_path):
    settings = PeriodicSection(transient=16)
    result = periodic_response(STRIP.replace(base__frequency=20.0), settings=settings, out=tmp_path)
    assert result.verdicts == {"not periodic": len(result.frame)}
    response = result.histories["response"]
    assert response.summary["periodic"]["period"] is None
    assert len(response.summary["periodic"]["samples"]) == 16
    assert "period,none," in (tmp_path / "results.csv").read_text(encoding="utf-8")
    (row,) = [
        row
        for row in json.loads((tmp_path / "results.json").read_text())["quantities"]
        if row["quantity"] == "period"
    ]
    assert row["value"] is None
    assert any(line.split()[:2] == ["period", "none"] for line in result.lines())
    assert ">none<" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_a_slow_free_vibration_is_skipped():
    """With 1 % of critical damping it takes 150 periods to decay to 1e-4; the limit is found from sixteen."""
    slow = STRIP.adapted(beam__kelvin_voigt=0.0, beam__modal_damping_ratio=0.01, contact__enabled=False)
    settings = PeriodicSection(tolerance=1e-6)
    history = steady_state(slow.replace(base__frequency=17.0), settings=settings)
    exact = steady_state(slow.replace(base__frequency=17.0), history, PeriodicSection(tolerance=1e-9))
    assert history.summary["periodic"]["transient"] <= 48
    assert history["q"].values[-1] == pytest.approx(exact["q"].values[-1], rel=1e-4)


@pytest.mark.parametrize(("frequency", "common"), [(13.0, 13.0), (26.0, 13.0), (19.5, 6.5), (39.0 / 5.0, 2.6)])
def test_base_and_force_of_two_frequencies_have_the_period_of_both(frequency, common):
    shaken = STRIP.replace(base__frequency=13.0, forces=[{"force": 1e-3, "frequency": frequency}])
    assert 1.0 / drive_period(shaken) == pytest.approx(common, rel=1e-12)


def test_a_force_alone_has_a_steady_response():
    """That of a mode without contact: twice the force is twice the swing, in step with it."""
    pushed = STRIP.adapted(base__acceleration=0.0, contact__enabled=False, gravity=0.0)
    one, two = (
        steady_state(
            pushed.replace(forces=[{"force": force, "frequency": 10.0}]), settings=PeriodicSection(tolerance=1e-7)
        )
        for force in (1e-5, 2e-5)
    )
    assert one.summary["periodic"]["period"] == 1
    assert 2.0 * one.summary["periodic"]["largest"] == pytest.approx(two.summary["periodic"]["largest"], rel=1e-4)
    lines = one.summary["periodic"]["spectrum"]
    assert lines[1] == pytest.approx(one.summary["periodic"]["largest"], rel=1e-2)
    assert max(lines[2:]) < 1e-4 * lines[1]


def test_the_jump_is_bracketed(result):
    """On the way up the strip falls off between two of three frequencies; it stays on below, and not above."""
    folder, frame = result
    table = pd.read_csv(folder / "jumps.csv")
    assert set(table["direction"]) == {"up", "down"}
    for row in table.itertuples():
        before, behind = row[3], row[4]
        assert 0.0 < abs(behind - before) < 1e-3 * before
    up = table[table["direction"] == "up"].iloc[0]
    assert 16.0 < up["last before"] < up["first behind"] < 17.0
    assert up["change of range"] < 0.0
    state = motion_state(frame[(frame["direction"] == "up") & (frame["base.frequency"] == 16.0)].iloc[0])
    below = steady_state(STRIP.replace(base__frequency=0.5 * (16.0 + up["last before"])), state)
    assert below.summary["periodic"]["impacts_per_period"] > 0.0


def test_the_way_up_and_the_way_down_part_where_two_motions_exist(result):
    folder, frame = result
    up, down = (frame[frame["direction"] == way].set_index("base.frequency") for way in ("up", "down"))
    assert (up["impacts_per_period"] > 0.0).tolist() == [True, True, False]
    assert (down["impacts_per_period"] > 0.0).sort_index().tolist() == [True, False, False]
    assert up.loc[16.0, "max:bending_stress"] > 3.0 * down.loc[16.0, "max:bending_stress"]
    apart = (up["max:bending_stress"] / down["max:bending_stress"]).drop(16.0)
    assert apart.tolist() == pytest.approx([1.0] * 2, rel=1e-3)
    assert frame["supplied"].tolist() == pytest.approx(frame["energy_lost"].tolist(), rel=2e-3)
    # a row of which the state goes on is what a call finds
    row = down.loc[16.0]
    state = tuple(np.array(part) for part in json.loads(down.loc[17.0, "state"]))
    called = steady_state(make_plan(SWEEP).runs[4].scenario, state, PeriodicSection(tolerance=1e-4))
    assert called.summary["periodic"]["samples"] == json.loads(row["samples"])
    assert "svg" in (folder / "report.html").read_text(encoding="utf-8")


def test_basins_of_a_few_starts(tmp_path):
    """At 16 Hz, where there are two motions, each of which some of nine starts come to."""
    text = SWEEP.replace("tolerance = 1e-4", "tolerance = 1e-4\nstarts = 3")
    sweep(make_plan(text), tmp_path, workers=1)
    table = pd.read_csv(tmp_path / "basins.csv")
    assert len(table) == 9
    assert set(table["way"]) == {"up", "down"}
    assert "Starts at 16 Hz" in (tmp_path / "report.html").read_text(encoding="utf-8")
    with refused_in_one_line("starts"):
        make_plan(text.replace("[periodic]", '[periodic]\ndirections = ["up"]'))


def test_a_sweep_of_steady_states_goes_on_where_it_was_interrupted(result):
    """Runs that are there are kept; those after a run that is repeated still go on from its end."""
    folder, _ = result
    whole = pd.read_parquet(folder / TABLE)
    left = whole[~((whole["direction"] == "up") & (whole["base.frequency"] > 15.5))]
    left.assign(steps=777).to_parquet(folder / TABLE)
    again = sweep(make_plan(SWEEP), folder, workers=1)
    assert again.frame["samples"].tolist() == whole["samples"].tolist()
    assert (again.frame["steps"] == 777).sum() == len(left)


def test_a_gap_is_an_axis_too(tmp_path):
    """From one place of the stop to another; the diagram is over the coordinate that changes."""
    axis = 'key = "base.frequency"\nvalues = [15.0, 16.0, 17.0]'
    places = 'key = "slope.origin"\nrange = [["1 mm", 0.25], [2e-3, 0.25]]\ncount = 3'
    text = SWEEP.replace(axis, places).replace("[periodic]", '[periodic]\nsample = "gap"\ndirections = ["down"]')
    found = sweep(make_plan(text), tmp_path, workers=1)
    figure = Figure()
    draw_responses(figure, make_plan(text), {"": found.frame})
    up, down = figure.axes[0].lines
    assert len(up.get_xdata()) == 0
    assert np.unique(down.get_xdata()) == pytest.approx([1e-3, 1.5e-3, 2e-3])
    samples = [gap for text in found.frame["samples"] for gap in json.loads(text)]
    assert down.get_ydata() == pytest.approx(np.array(samples) * 1e3)  # shown in mm


def test_a_strip_that_is_pressed_past_a_point_is_not_behind_it():
    """From coordinates alone, as of the row before: it comes back to the response that it has from rest."""
    data = STRIP.model_dump(mode="json", exclude_unset=True) | {"slope": {"enabled": False}}
    data["obstacles"] = [{"kind": "point", "origin": [0.002, 0.24], "stiffness": 2e3}]
    data["contact"] = {"where": "anywhere", "normal": "spring", "friction": "frictionless"}
    point, settings = Scenario.from_dict(data), PeriodicSection(tolerance=1e-4)
    found = steady_state(point, settings=settings)
    pressed = int(np.argmin(found["gap"].values))
    assert found["gap"][pressed] < -1e-5
    again = steady_state(point, (found["q"].values[pressed], found["qd"].values[pressed]), settings)
    for extreme in ("least", "largest"):
        there, back = (response.summary["periodic"][extreme] for response in (found, again))
        assert back == pytest.approx(there, rel=1e-3)


BAD = {
    "base.sweep_rate": ("changes.base.sweep_rate = 1.0", "should be constant, or harmonic"),
    "no period in common": ("changes.forces = [{force = 1.0, frequency = 3.14159}]", "no period in common"),
    "sweep of a force": ("changes.forces = [{force = 1.0, sweep_rate = 3.0}]", "forces.1: periodic response"),
    "nothing moves": ("changes.base.acceleration = 0.0", "base"),
    "root.profile": ('changes.root = {profile = "constant-speed", spin_rate = 1.0}', "root.profile"),
    "absolute": ('changes.discretization.method = "absolute"', "discretization.method"),
    "not axes alone": ('table = {keys = ["gravity"], rows = [[1.0]]}', "axes"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_has_no_steady_state_is_refused_in_one_line(case):
    line, words = BAD[case]
    with refused_in_one_line(words):
        make_plan(SWEEP.replace("changes.discretization.modes = 2", line))


@pytest.mark.parametrize(
    "keys", [{"sample": "uy"}, {"directions": ["up", "up"]}, {"transient": 10}, {"tolerance": 0.0}]
)
def test_settings_are_checked(keys):
    with pytest.raises(InputError, match=next(iter(keys))):
        PeriodicSection(**keys)


def test_a_run_that_ends_early_says_so():
    """The clamped strip bends by more than half of its length."""
    result = periodic_response(STRIP.adapted(base__acceleration=2000.0, contact__enabled=False))
    history = result.histories["response"]
    assert history.outcome is Outcome.LARGE_DEFLECTION
    assert set(result.frame["verdict"]) == {"large-deflection"}
    assert "periodic" not in history.summary

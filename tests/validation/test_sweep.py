"""Sweeps: designs and their order, sweep files in one line each, folders that survive, rows whatever happens."""

from __future__ import annotations

import html
import json
import math
import re
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pyarrow as pa
import pytest
from matplotlib.figure import Figure

from oblique_impact import InputError, Scenario, simulate
from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.errors import Outcome
from oblique_impact.marching.records import Event
from oblique_impact.renders.style import SLIP_COLOUR, STICK_COLOUR
from oblique_impact.scenario.toml import flat_keys
from oblique_impact.validation.journal import Journal
from oblique_impact.validation.measuring import (
    ERROR,
    INVALID,
    REGIMES,
    TIMEOUT,
    Done,
    OutOfTimeError,
    _Clock,
    failed,
    measure_run,
    regime,
)
from oblique_impact.validation.quantities import GapError, quantity
from oblique_impact.validation.report.document import render_html
from oblique_impact.validation.sweeps import command, figures
from oblique_impact.validation.sweeps.design import MAX_RUNS
from oblique_impact.validation.sweeps.figures import (
    _COLOURS,
    _cells,
    _curve,
    _direction,
    _edges,
    _mark_stopped,
    _scale,
    sweep_pictures,
)
from oblique_impact.validation.sweeps.keys import kind, known_keys, unit
from oblique_impact.validation.sweeps.plan import Plan, load_plan, make_plan, shipped_names
from oblique_impact.validation.sweeps.report import sweep_document
from oblique_impact.validation.sweeps.store import ROWS, open_store
from oblique_impact.validation.sweeps.table import make_table, read_table, write_table

FLIGHT = """
quantities = ["theta@end", "tip_y@0.01"]
[changes]
end_time = 0.02
contact.enabled = false
"""
ANGLES = FLIGHT + '[[axes]]\nkey = "initial.angle"\nvalues = [0.1, 0.2, 0.3, 0.4]\n'


def done(number: int, **changes) -> Done:
    return Done(failed(number, "completed", "") | changes)


def fake_rows(plan: Plan, **changes):
    """Rows without a simulation: the first quantity counts the runs."""
    for run in range(plan.design.size):
        values = {q.name: float(run + place) for place, q in enumerate(plan.quantities)}
        yield failed(run, "completed", "") | {"values": values, "stopped_at": 1.0, **changes}


# --- keys


def test_every_key_of_a_scenario_is_known_with_its_kind_and_unit():
    data = Scenario.builtin("paper").model_dump()
    del data["parameters"]  # numbers of user-defined parts: any name
    flat = flat_keys(data)
    assert set(known_keys()) == set(flat)
    for key, value in flat.items():
        assert isinstance(value, kind(key)), key
    assert (unit("gravity"), unit("slope.origin"), unit("beam.second_moment")) == ("m/s²", "m", "m⁴")
    assert unit("contact.mu_static") == "1"
    assert unit("contact.enabled") == ""


# --- designs


def swept(text: str) -> np.ndarray:
    """Values of all runs, shape (runs, keys)."""
    design = make_plan(text).design
    return np.array([design.values(run) for run in range(design.size)])


@pytest.mark.parametrize("spacing", ["linear", "log"])
def test_ranges_hold_both_ends_exactly_and_step_evenly(spacing):
    values = swept(f'[[axes]]\nkey = "gravity"\nrange = [0.7, 0.1]\ncount = 7\nspacing = "{spacing}"')[:, 0]
    assert (values[0], values[-1]) == (0.7, 0.1)
    steps = np.diff(np.log(values) if spacing == "log" else values)
    assert steps == pytest.approx(steps[0], rel=1e-12)


SAMPLE = """
[{name}]
samples = {samples}
seed = {seed}
axes = [{{key = "gravity", range = [1.0, 11.0]}}, {{key = "end_time", range = [0.1, 10.0], spacing = "log"}}]
"""


@pytest.mark.parametrize(("name", "samples"), [("latin_hypercube", 50), ("sobol", 64)])
def test_a_sample_has_one_point_in_each_slice_of_each_direction(name, samples):
    def points(seed):
        found = swept(SAMPLE.format(name=name, samples=samples, seed=seed))
        return np.stack([(found[:, 0] - 1.0) / 10.0, 0.5 * (np.log10(found[:, 1]) + 1.0)])

    for column in points(4):
        assert sorted((column * samples).astype(int)) == list(range(samples))
    assert points(4).tolist() == points(4).tolist() != points(5).tolist()


def test_a_sobol_sequence_fills_boxes_too():
    """Each of the 16 boxes of a 4 x 4 grid holds as many points."""
    found = swept(SAMPLE.format(name="sobol", samples=64, seed=1))
    boxes = (4.0 * np.stack([(found[:, 0] - 1.0) / 10.0, 0.5 * (np.log10(found[:, 1]) + 1.0)])).astype(int)
    assert np.bincount(4 * boxes[0] + boxes[1]).tolist() == [4] * 16


def test_blocks_are_combined_with_the_last_one_fastest():
    plan = make_plan(
        """
        [[axes]]
        key = "end_time"
        values = [1, 2]
        [table]
        keys = ["contact.mu_static", "contact.mu_kinetic"]
        rows = [[0.5, 0.4], [0.3, 0.2]]
        [latin_hypercube]
        samples = 3
        seed = 1
        [[latin_hypercube.axes]]
        key = "discretization.modes"
        range = [1, 3]
        """
    )
    rows = [plan.design.values(run) for run in range(plan.design.size)]
    assert plan.design.keys == ("end_time", "contact.mu_static", "contact.mu_kinetic", "discretization.modes")
    assert len(rows) == 12
    assert [row[:3] for row in rows[::3]] == [(1.0, 0.5, 0.4), (1.0, 0.3, 0.2), (2.0, 0.5, 0.4), (2.0, 0.3, 0.2)]
    assert {row[3] for row in rows} == {1, 2, 3}
    assert all(type(row[3]) is int for row in rows)


def test_ranges_over_integers_give_integers_and_keys_can_go_together():
    plan = make_plan('[[axes]]\nkeys = ["discretization.modes"]\nrange = [2, 8]\ncount = 4')
    assert [row[0] for row in plan.design.blocks[0].rows] == [2, 4, 6, 8]
    both = make_plan('[[axes]]\nkeys = ["contact.mu_static", "contact.mu_kinetic"]\nvalues = [0.1, 0.9]')
    assert both.design.values(1) == (0.9, 0.9)
    assert both.impossible == 0


# --- sweep files

AXIS = "[[axes]]\n"


def axis(key, rest="values = [1]", also=""):
    """A sweep over one key, with other lines before it."""
    return f'{also}\n[[axes]]\nkey = "{key}"\n{rest}\n'


def sampled(rest, also=""):
    return f'[latin_hypercube]\nsamples = 3\n{also}\n[[latin_hypercube.axes]]\nkey = "gravity"\n{rest}'


def tabled(keys, rows):
    return f"[table]\nkeys = {keys}\nrows = {rows}"


BAD = {
    "not TOML": ("axes = [", "not valid TOML"),
    "nothing to sweep": ('scenario = "paper"', "[[axes]]"),
    "empty axes": ("axes = []", "axes"),
    "unknown key of the file": (axis("gravity", also='titel = "x"'), "title, description"),
    "unknown key of an axis": (axis("gravity", "valuse = [1]"), "axes.0.valuse"),
    "unknown scenario key": (axis("contact.mu"), "contact.mu_static"),
    "unknown section": (axis("floor.mu"), "SECTION.KEY of beam"),
    "a section is no key": (axis("contact"), "axes.0.key = 'contact'"),
    "unknown key in changes": (axis("gravity", also="[changes.contact]\nmu = 1"), "mu_static"),
    "wrong type": (axis("contact.mu_static", 'values = [0.3, "high"]'), "contact.mu_static = 'high'"),
    "out of bounds": (axis("beam.length", "values = [1.0, -1.0]"), "beam.length = -1.0"),
    "not a number": (axis("contact.mu_static", "values = [nan]"), "contact.mu_static = nan"),
    "infinite range": (axis("gravity", "range = [0.0, inf]\ncount = 3"), "axes.0.range.1 = inf"),
    "empty list": (axis("gravity", "values = []"), "axes.0.values = []: should have at least 1 item"),
    "no values": (axis("gravity", ""), "axes.0"),
    "values and range": (axis("gravity", "values = [1]\nrange = [1, 2]\ncount = 2"), "not both"),
    "values and count": (axis("gravity", "values = [1]\ncount = 2"), "axes.0.count = 2"),
    "no count": (axis("gravity", "range = [1, 2]"), "axes.0.count"),
    "count of one": (axis("gravity", "range = [1, 2]\ncount = 1"), "axes.0.count = 1"),
    "ends alike": (axis("gravity", "range = [2, 2]\ncount = 3"), "should differ"),
    "log of zero": (axis("gravity", 'range = [0, 2]\ncount = 3\nspacing = "log"'), "greater than 0"),
    "unknown spacing": (axis("gravity", 'range = [0, 2]\ncount = 3\nspacing = "cubic"'), "'linear' or 'log'"),
    "range of words": (axis("contact.friction", "range = [0, 2]\ncount = 3"), "use values"),
    "no whole number": (axis("discretization.modes", "range = [1, 4]\ncount = 3"), "modes = 2.5"),
    "key and keys": (axis("gravity", 'keys = ["gravity"]\nvalues = [1]'), "exactly one"),
    "no key": (f"{AXIS}values = [1]", "exactly one"),
    "a key twice": (2 * axis("gravity"), "set twice"),
    "changed and swept": (axis("gravity", also="[changes]\ngravity = 1"), "set twice"),
    "too many runs": (
        "".join(axis(key, "range = [1, 9]\ncount = 100") for key in ("gravity", "end_time", "beam.density")),
        f"at most {MAX_RUNS}",
    ),
    "too long an axis": (axis("gravity", "range = [1, 9]\ncount = 1000000000"), "axes.0.count"),
    "short row": (tabled('["gravity", "end_time"]', "[[1.0, 1.0], [2.0]]"), "table.rows.1"),
    "no rows": (tabled('["gravity"]', "[]"), "table.rows"),
    "unknown key of a table": (tabled('["weight"]', "[[1.0]]"), "table.keys.0"),
    "hypercube without seed": (sampled("range = [1, 2]"), "latin_hypercube.seed: missing"),
    "hypercube without axes": ("[latin_hypercube]\nsamples = 3\nseed = 1\naxes = []", "latin_hypercube.axes"),
    "hypercube with count": (sampled("range = [1, 2]\ncount = 2", "seed = 1"), "latin_hypercube.axes.0.count"),
    "Sobol sequence of 3": (SAMPLE.format(name="sobol", samples=3, seed=1), "power of 2"),
    "unknown scenario": (axis("gravity", also='scenario = "papier"'), "papier"),
    "unknown quantity": (axis("gravity", also='quantities = ["speed"]'), "first_impact"),
    "no quantities": (axis("gravity", also="quantities = []"), "quantities"),
    "time after the end": (axis("end_time", "values = [1, 2]", 'quantities = ["tip_y@3"]'), "tip_y@3"),
    "unknown discretization": (
        axis("discretization.method", 'values = ["modal", "ritz"]'),
        "should be 'absolute', 'fem' or 'modal'",
    ),
    "no run is possible": (axis("contact.mu_static", "values = [0.1, 0.2]"), "contact.mu_static = 0.1"),
    "histories as text": (axis("gravity", also='histories = "yes"'), "histories = 'yes'"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_sweep_file_is_one_line(case):
    text, part = BAD[case]
    with pytest.raises(InputError) as caught:
        make_plan(text)
    assert part in str(caught.value)
    assert "\n" not in str(caught.value)


def test_values_that_do_not_fit_together_are_counted_and_become_rows():
    plan = make_plan(AXIS + 'key = "contact.mu_static"\nvalues = [0.1, 0.3, 0.5]')
    assert plan.impossible == 1
    assert plan.fault.startswith("run 1: contact.mu_static = 0.1")
    row = measure_run(plan.task(0)).row
    assert row["outcome"] == INVALID
    assert "mu_kinetic" in row["message"]


def test_the_tip_moves_with_the_length():
    plan = make_plan(FLIGHT + AXIS + 'key = "beam.length"\nvalues = [0.8, 1.2]')
    row = measure_run(plan.task(0)).row
    assert row["values"]["tip_y@0.01"] == pytest.approx(0.8 * math.sin(math.pi / 4), abs=1e-2)


def test_a_scenario_file_lies_beside_its_sweep_file(tmp_path):
    (tmp_path / "mine.toml").write_text("end_time = 0.125")
    (tmp_path / "sweep.toml").write_text('scenario = "mine.toml"\n' + AXIS + 'key = "gravity"\nvalues = [1]')
    assert load_plan(str(tmp_path / "sweep.toml")).base.end_time == 0.125


def test_unknown_names_list_the_shipped_studies():
    with pytest.raises(InputError, match="friction, regimes, restitution"):
        load_plan("nonsense")
    with pytest.raises(InputError, match="neither a file"):
        load_plan("x" * 5000)


@pytest.mark.parametrize("name", shipped_names())
def test_shipped_studies_are_possible_and_described(name):
    plan = load_plan(name)
    assert plan.impossible == 0
    assert plan.file.title
    assert len(plan.file.description) > 100
    assert 10 <= plan.design.size <= 1000


def test_the_fingerprint_is_that_of_the_rows():
    same = make_plan(ANGLES)
    assert make_plan('title = "other words"\n' + ANGLES).fingerprint == same.fingerprint
    assert make_plan(ANGLES.replace("values = [0.1", "values = [0.15")).fingerprint != same.fingerprint
    assert make_plan(ANGLES.replace("0.02", "0.03")).fingerprint != same.fingerprint
    assert make_plan("histories = true\n" + ANGLES).fingerprint != same.fingerprint
    assert make_plan('scenario = "sticking"\n' + ANGLES).fingerprint != same.fingerprint
    assert make_plan(ANGLES.replace("theta@end", "theta_dot@end")).fingerprint != same.fingerprint


def test_the_resolved_sweep_file_is_the_same_sweep(tmp_path):
    plan = make_plan(ANGLES)
    (tmp_path / "scenario.toml").write_text(plan.base.to_toml())
    (tmp_path / "sweep.toml").write_text(plan.to_toml())
    assert load_plan(str(tmp_path / "sweep.toml")).fingerprint == plan.fingerprint


# --- rows


def test_an_exception_becomes_a_row(monkeypatch):
    plan = make_plan(ANGLES)

    def broken(*_):
        raise FloatingPointError("over\nflow")

    monkeypatch.setattr(sys.modules["oblique_impact.simulation"], "simulate", broken)
    row = measure_run(plan.task(2)).row
    assert (row["outcome"], row["message"]) == (ERROR, "FloatingPointError: over flow")


def test_a_run_that_takes_too_long_is_a_row():
    plan = make_plan(AXIS + 'key = "end_time"\nvalues = [50.0]')
    row = measure_run(plan.task(0, timeout=0.2)).row
    assert row["outcome"] == TIMEOUT
    assert row["message"].startswith("took longer than 0.2 s, until t = ")
    assert row["wall_time"] > 0.2


def test_what_is_compiled_does_not_count(monkeypatch):
    """A run that tells its progress late, but compiled until then."""
    clock = iter([0.0, 100.0, 101.0, 103.0])
    monkeypatch.setattr("oblique_impact.validation.measuring.time.perf_counter", lambda: next(clock))
    limit = _Clock(2.0)
    limit("a kernel")
    limit.check(SimpleNamespace(time=0.0))
    limit.check(SimpleNamespace(time=0.1))
    with pytest.raises(OutOfTimeError, match=r"longer than 2 s, until t = 0\.2 s"):
        limit.check(SimpleNamespace(time=0.2))


def test_what_the_physics_stops_is_a_row_with_its_name():
    plan = make_plan(
        """
        quantities = ["first_impact", "impulse"]
        [changes]
        end_time = 0.4
        [changes.discretization]
        frame = "mean-axis"
        modes = 3
        [[axes]]
        keys = ["contact.mu_static", "contact.mu_kinetic"]
        values = [20.0]
        """
    )
    row = measure_run(plan.task(0)).row
    assert (row["outcome"], row["regime"]) == ("painleve", "painleve")
    assert row["values"]["first_impact"] == pytest.approx(0.31715, abs=1e-4)
    assert math.isnan(row["values"]["impulse"])
    assert "painleve" in row["gaps"]["impulse"]


def test_regimes(run):
    mean_axis = ("discretization.frame=mean-axis", "discretization.modes=3", "end_time=0.4")
    assert regime(run("paper", "end_time=0.3")) == "no contact"
    assert regime(run("paper", *mean_axis)) == "slip"
    assert regime(run("paper", "end_time=0.4")) == "reversal"  # theory, Sec. 8: at 0.3235971 s
    assert regime(run("sticking")) == "stick"
    steep = ("contact.mu_static=20.0", "contact.mu_kinetic=20.0")
    assert regime(run("paper", *mean_axis, *steep)) == "painleve"
    assert set(REGIMES) >= {"no contact", "slip", "reversal", "stick", "painleve", "stopped"}


def test_a_regime_is_that_of_the_first_collision():
    """A stick in the second one does not count."""

    def event(time, state):
        return Event(time, EventKind.IMPACT, 1.0, 0.0, -1.0, 0.1, 0.0, state)

    history = SimpleNamespace(
        outcome=Outcome.COMPLETED,
        macro_collisions=[{"start": 0.3, "end": 0.31}, {"start": 0.6, "end": 0.61}],
        events=[event(0.3, State.SLIP), event(0.6, State.STICK)],
    )
    assert regime(history) == "slip"
    history.events[0] = event(0.3, State.STICK)
    assert regime(history) == "stick"


def test_the_energy_of_a_row_is_the_larger_of_the_first_and_the_last():
    """At rest at 45 degrees above the pin: m g L/2 sin 45 degrees, of which collisions take a part."""
    plan = make_plan('quantities = ["impulse"]\n[[axes]]\nkey = "end_time"\nvalues = [0.4]')
    row = measure_run(plan.task(0)).row
    assert row["energy"] == pytest.approx(2766.7 * 3.14e-4 * 9.8 * 0.5 * math.sin(math.pi / 4), rel=1e-9)


# --- quantities that sweeps brought


TIP_MASS = ("discretization.method=fem", "beam.tip_mass=0.2", "beam.length=0.8")


@pytest.mark.parametrize(
    ("frame", "changes"),
    [("tangent", ()), ("mean-axis", ()), ("tangent", TIP_MASS)],
    ids=["tangent", "mean-axis", "tip mass"],
)
def test_restitution_is_the_balance_of_angular_momentum(run, frame, changes):
    """J (w+ - w-) is the moment of the contact impulses less that of gravity during the collision."""
    model = (f"discretization.frame={frame}", *changes, "contact.friction=frictionless")
    history = run("paper", "end_time=0.4", *model)
    tip_mass, length = (0.2, 0.8) if changes else (0.0, 1.0)
    collision = history.summary["macro_collisions"][0]
    times = history["time"].values
    before = np.flatnonzero(times == collision["start"])[0]
    after = np.flatnonzero(times == collision["end"])[-1]
    lengths = 0.3 * math.sin(math.pi / 10)  # of the foot of the perpendicular from the pin onto the slope
    lever = math.sqrt(length**2 - lengths**2)
    angle = math.pi / 10 - math.asin(lengths / length)
    mass = 3.14e-4 * 2766.7 * length
    inertia = (mass / 3.0 + tip_mass) * length**2
    first_moment = (0.5 * mass + tip_mass) * length
    weight = first_moment * 9.8 * math.cos(angle) * (times[after] - times[before])
    change = (lever * collision["normal_impulse"] - weight) / inertia
    fall = 9.8 * first_moment * (math.sin(math.pi / 4) - math.sin(angle))
    spin = -math.sqrt(2.0 * fall / inertia)  # of the rigid bar that falls
    expected = -(spin + change) / spin
    assert quantity("restitution").measure(history) == pytest.approx(expected, abs=0.01)


def test_restitution_needs_a_pin_and_a_collision(run):
    with pytest.raises(GapError, match="no contact"):
        quantity("restitution").measure(run("paper", "end_time=0.3"))


def test_energy_lost_is_what_the_ledger_lost(run):
    history = run("paper", "end_time=0.4")
    energy = history.summary["energy"]
    lost = quantity("energy_lost").measure(history)
    assert lost == pytest.approx(energy["initial"] - energy["final"], abs=1e-9)


# --- the folder


def test_progress_counts_runs_with_those_that_were_there(tmp_path, monkeypatch):
    plan, told = make_plan(ANGLES), []
    with open_store(tmp_path, plan) as store:
        store.add(done(2))
    monkeypatch.setattr(command, "measure_each", lambda tasks, *_, **__: map(measure_run, tasks))
    result = command.sweep(plan, out=tmp_path, on_progress=told.append)
    assert [(p.done, p.total) for p in told] == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert [p.last for p in told[1:]] == ["run 1", "run 2", "run 4"]
    assert (result.earlier, result.table.num_rows) == (1, 4)


def test_rows_survive(tmp_path):
    plan = make_plan(ANGLES)
    with open_store(tmp_path, plan) as store:
        store.add(done(2, wall_time=0.1))
        store.add(done(0, stopped_at=1.0 / 3.0))
    with open_store(tmp_path, plan) as store:
        assert store.done == {0, 2}
        rows = {row["run"]: row for row in store.journal.rows()}
        assert rows[0]["stopped_at"] == 1.0 / 3.0
        assert math.isnan(rows[2]["stopped_at"])


def test_a_row_that_a_kill_cut_short_is_repeated(tmp_path):
    plan = make_plan(ANGLES)
    with open_store(tmp_path, plan) as store:
        for run in range(2):
            store.add(done(run))
    file = tmp_path / ROWS
    file.write_text(file.read_text()[:-9])
    with open_store(tmp_path, plan) as store:
        assert store.done == {0}
        store.add(done(3))
    with open_store(tmp_path, plan) as store:
        assert store.done == {0, 3}


def test_rows_of_another_study_are_replaced(tmp_path):
    file = tmp_path / "rows"
    Journal(file, "a", 3, ()).add(failed(1, "completed", ""))
    assert Journal(file, "a", 3, ()).missing() == [0, 2]
    assert Journal(file, "b", 3, ()).missing() == [0, 1, 2]


def test_another_sweep_is_not_mixed_in(tmp_path):
    with open_store(tmp_path, make_plan(ANGLES)) as store:
        store.add(done(0))
    with pytest.raises(InputError, match=r"holds another sweep.*choose another folder"):
        open_store(tmp_path, make_plan(ANGLES.replace("0.4]", "0.5]"))).__enter__()
    (tmp_path / "fingerprint.json").write_text("{")
    with pytest.raises(InputError, match="fingerprint damaged"):
        open_store(tmp_path, make_plan(ANGLES)).__enter__()


def test_results_of_something_else_are_left_alone(tmp_path):
    (tmp_path / "results.parquet").write_text("mine")
    with pytest.raises(InputError, match="something else"):
        open_store(tmp_path, make_plan(ANGLES)).__enter__()
    assert (tmp_path / "results.parquet").read_text() == "mine"


@pytest.mark.parametrize("text", ["[{{\n", "{head}3\n", '{head}{{"run": 0}}\n', "{head}\n{row}", "3\n"])
def test_damaged_rows_are_named(tmp_path, text):
    plan = make_plan(ANGLES)
    with open_store(tmp_path, plan) as store:
        store.add(done(0))
    file = tmp_path / ROWS
    head, row = file.read_text().splitlines(keepends=True)
    file.write_text(text.format(head=head, row=row))
    with pytest.raises(InputError, match=rf"{ROWS} is damaged"):
        open_store(tmp_path, plan).__enter__()


def test_leftovers_of_a_kill_are_removed(tmp_path):
    plan = make_plan(ANGLES)
    with open_store(tmp_path, plan) as store:
        store.add(done(0))
    (tmp_path / ".sweep.xyz.part.toml").write_text("[{")
    (tmp_path / ".scratch" / "000001").mkdir(parents=True)
    with open_store(tmp_path, plan) as store:
        assert store.done == {0}
    assert not list(tmp_path.rglob("*.part*"))
    assert not (tmp_path / ".scratch").exists()


def test_histories_are_whole_folders(tmp_path):
    with open_store(tmp_path, make_plan("histories = true\n" + ANGLES)) as store:
        for content in (b"one", b"two"):
            store.add(Done(failed(3, "completed", ""), {"history.nc": content}))
    assert [p.name for p in (tmp_path / "histories").iterdir()] == ["000004"]
    assert (tmp_path / "histories" / "000004" / "history.nc").read_bytes() == b"two"


# --- the table


def test_warnings_of_runs_are_a_column_a_line_and_in_the_report(tmp_path):
    """A rigid stop under an undamped beam: two of three runs touch it."""
    text = """
scenario = "paper"
quantities = ["first_impact"]
changes = {"discretization.frame" = "mean-axis"}
axes = [{key = "end_time", values = [0.1, 0.32, 0.33]}]
"""
    result = command.sweep(make_plan(text), tmp_path, workers=1)
    (warning,) = simulate(result.plan.task(2).scenario()).summary["warnings"]
    assert result.table["warnings"].to_pylist() == ["", warning, warning]
    (line,) = [line for line in command.lines(result) if warning in line]
    assert "2 of 3 runs" in line
    assert warning in html.unescape(result.report.read_text())


def test_one_worker_needs_no_other_process(tmp_path):
    """A script without a guard around its calls, which other processes would import."""
    script = tmp_path / "script.py"
    script.write_text(
        "from validation import AxisSection, SweepFile, sweep\n"
        'axis = AxisSection(key="initial.angle", values=[0.1, 0.2])\n'
        'changes = {"end_time": 0.01, "contact.enabled": False}\n'
        'file = SweepFile(changes=changes, axes=[axis], quantities=["theta@end"])\n'
        f"print(sweep(file, {str(tmp_path / 'out')!r}, workers=1).outcomes)\n"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=300.0, check=False)
    assert (done.returncode, done.stderr.count("Traceback")) == (0, 0), done.stderr
    assert "'completed': 2" in done.stdout


def test_the_table_has_all_runs_in_order_with_units(tmp_path):
    plan = make_plan(ANGLES)
    rows = list(fake_rows(plan))
    write_table(tmp_path / "a.parquet", make_table(plan, reversed(rows)))
    table = read_table(tmp_path / "a.parquet", plan)
    assert table["run"].to_pylist() == [1, 2, 3, 4]
    assert table["initial.angle"].to_pylist() == [0.1, 0.2, 0.3, 0.4]
    assert table["theta@end"].to_pylist() == [0.0, 1.0, 2.0, 3.0]
    assert table.column_names[-1] == "wall_time"
    about = {field.name: field.metadata[b"unit"].decode() for field in table.schema}
    assert about["initial.angle"] == "rad"
    assert about["tip_y@0.01"] == "m"
    head = {key.decode(): value.decode() for key, value in table.schema.metadata.items()}
    assert head["fingerprint"] == plan.fingerprint
    assert json.loads(head["changes"]) == {"end_time": 0.02, "contact.enabled": False}
    with pytest.raises(ValueError, match="1 of 4 runs are missing"):
        make_table(plan, rows[1:])


def test_two_tables_are_the_same_bytes(tmp_path):
    plan = make_plan(ANGLES)
    for name in "ab":
        write_table(tmp_path / name, make_table(plan, fake_rows(plan)))
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_missing_values_are_nulls_and_all_kinds_of_keys_are_columns():
    plan = make_plan(
        """
        quantities = ["impulse"]
        [table]
        keys = ["contact.enabled", "contact.friction", "discretization.elements", "slope.origin", "beam.area"]
        rows = [
            [true, "hybrid", 8, [0.3, 0.0], 3e-4],
            [false, "frictionless", 16, [0.4, 0.0], [[0, 3e-4], [1, 2e-4]]],
        ]
        [changes.discretization]
        method = "fem"
        """
    )
    table = make_table(plan, fake_rows(plan, values={"impulse": math.nan}, gaps={"impulse": "no contact"}))
    assert table["impulse"].null_count == 2
    assert table["gaps"].to_pylist() == ["impulse: no contact"] * 2
    assert table["contact.enabled"].to_pylist() == [True, False]
    assert table["discretization.elements"].type == pa.int64()
    assert json.loads(table["slope.origin"][1].as_py()) == [0.4, 0.0]
    assert [json.loads(text) for text in table["beam.area"].to_pylist()] == [3e-4, [[0.0, 3e-4], [1.0, 2e-4]]]
    assert render_html(sweep_document(plan, table, "command")).count("<svg") == 0


def test_a_damaged_table_is_one_line(tmp_path):
    (tmp_path / "a.parquet").write_bytes(b"PAR1 and nothing")
    with pytest.raises(InputError, match="not a readable table"):
        read_table(tmp_path / "a.parquet", make_plan(ANGLES))


# --- pictures and report


def test_a_cell_of_a_map_is_where_its_values_are():
    """The first direction to the right, the second one upwards; states have the colours of all pictures."""
    plan = make_plan(PICTURES["few values"][0])
    first, second = (
        _direction(dimension, make_table(plan, fake_rows(plan))) for dimension in plan.design.dimensions
    )
    cells = _cells(first, second, 10.0 * first.places + second.places)
    np.testing.assert_allclose(cells, np.add.outer([1.0, 2.0, 3.0], 10.0 * np.linspace(0.1, 0.9, 6)))
    assert {name: _COLOURS[name] for name in ("slip", "stick")} == {"slip": SLIP_COLOUR, "stick": STICK_COLOUR}


def test_a_logarithmic_direction_has_a_logarithmic_axis_and_cells_around_its_values():
    """Values 1, 10, 100: edges half a decade to either side; 1, 2, 3: half a unit."""
    text = AXIS + 'key = "gravity"\nrange = [1, 100]\ncount = 3\nspacing = "log"\n'
    plan = make_plan(text + AXIS + 'key = "end_time"\nvalues = [1, 2, 3]')
    log, linear = (_direction(d, make_table(plan, fake_rows(plan))) for d in plan.design.dimensions)
    np.testing.assert_allclose(_edges(log, linear)[0], 10.0 ** np.array([-0.5, 0.5, 1.5, 2.5]))
    np.testing.assert_allclose(_edges(log, linear)[1], [0.5, 1.5, 2.5, 3.5])
    axes = Figure().subplots()
    _scale(axes, log, "x")
    _scale(axes, linear, "y")
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "linear")


def test_a_curve_has_the_runs_of_its_value(monkeypatch):
    """Runs are counted with the second direction as the fast one, and their quantity is that count."""
    found = []
    monkeypatch.setattr(figures, "to_svg", lambda figure: found.append(figure) or "<svg/>")
    plan = make_plan('quantities = ["impulse"]\n' + PICTURES["few values"][0])
    sweep_pictures(plan, make_table(plan, fake_rows(plan)))
    lines = found[0].axes[0].lines
    assert [line.get_label() for line in lines] == [f"gravity = {g} m/s²" for g in (1, 2, 3)]
    for number, line in enumerate(lines):
        np.testing.assert_allclose(line.get_xdata(), np.linspace(0.1, 0.9, 6))
        np.testing.assert_array_equal(line.get_ydata(), 3.0 * np.arange(6) + number)


def test_curves_are_named_joined_on_grids_only_and_marked_where_a_run_stopped():
    plan = make_plan('quantities = ["impulse"]\n' + PICTURES["few values"][0])
    (picture,) = sweep_pictures(plan, make_table(plan, fake_rows(plan)))
    assert re.findall("<!-- (gravity = .*?) -->", picture.svg) == [f"gravity = {g} m/s²" for g in (1, 2, 3)]
    plan = make_plan(ANGLES)
    rows = [row | {"outcome": "painleve" if row["run"] == 2 else "completed"} for row in fake_rows(plan)]
    table = make_table(plan, rows)
    along = _direction(plan.design.dimensions[0], table)
    axes = Figure().subplots()
    assert _mark_stopped([axes], plan, table, along)
    np.testing.assert_array_equal(axes.lines[0].get_xdata(), [0.3])
    for joined, style in ((True, "-"), (False, "None")):
        _curve(axes, along.places, along.places, 0, None, joined)
        assert axes.lines[-1].get_linestyle() == style


TWO_AXES = AXIS + 'key = "slope.angle"\nrange = [0.1, 0.9]\ncount = 6\n' + AXIS
PICTURES = {
    "one axis": (ANGLES, 1),
    "one axis of words": (AXIS + 'key = "contact.friction"\nvalues = ["hybrid", "frictionless"]', 1),
    "curves": (TWO_AXES + 'key = "contact.friction"\nvalues = ["hybrid", "frictionless"]', 1),
    "few values": (TWO_AXES + 'key = "gravity"\nvalues = [1, 2, 3]', 1),
    "map": (TWO_AXES + 'key = "gravity"\nrange = [1, 100]\ncount = 7\nspacing = "log"', 2),
    "table": ('[table]\nkeys = ["gravity", "slope.angle"]\nrows = [[1, 0.1], [2, 0.2], [3, 0.2], [4, 0.5]]', 2),
    "three axes": (
        TWO_AXES + 'key = "gravity"\nvalues = [1, 2]\n' + AXIS + 'key = "end_time"\nvalues = [1, 2]',
        0,
    ),
    "one run": (AXIS + 'key = "gravity"\nvalues = [1]', 0),
}


@pytest.mark.parametrize("case", PICTURES)
def test_pictures_of_one_and_two_axes(case):
    text, count = PICTURES[case]
    # one quantity: by default there are six, and each is drawn
    plan = make_plan(text if "quantities" in text else 'quantities = ["impulse"]\n' + text)
    rows = [row | {"regime": REGIMES[row["run"] % len(REGIMES)]} for row in fake_rows(plan)]
    rows[-1] |= {"outcome": "painleve", "values": {}, "message": "why & where"}
    table = make_table(plan, rows)
    assert len(sweep_pictures(plan, table)) == count
    page = render_html(sweep_document(plan, table, "command"))
    if case == "map":  # both kinds of pictures
        assert page == render_html(sweep_document(plan, table, "command"))
    assert "why &amp; where" in page
    assert re.findall(r'(?:src|href)="(?!#|data:)([^"]*)"|url\((?!#)([^)]*)\)', page) == []


@pytest.mark.parametrize("missing", [True, False])
def test_a_map_explains_its_hatching_where_a_value_is_missing(missing):
    plan = make_plan('quantities = ["impulse"]\n' + PICTURES["map"][0])
    rows = list(fake_rows(plan))
    if missing:
        rows[3] |= {"values": {}}
    *_, values = sweep_pictures(plan, make_table(plan, rows))
    assert ("<!-- no such value -->" in values.svg) == missing


def test_every_axis_of_a_picture_has_its_unit():
    plan = make_plan(PICTURES["map"][0])
    rows = [row | {"regime": "slip" if row["run"] else "stick"} for row in fake_rows(plan)]
    first, second = sweep_pictures(plan, make_table(plan, rows))
    for picture in (first, second):
        # matplotlib draws letters as shapes and leaves the text in a comment
        assert "<!-- slope.angle (rad) -->" in picture.svg
        assert "<!-- gravity (m/s²) -->" in picture.svg
    for name, its_unit in (("impulse", "N s"), ("first impact", "s"), ("energy final", "J")):
        assert f"<!-- {name} ({its_unit}) -->" in second.svg

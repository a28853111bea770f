"""Two histories compared: known answers, alignment of events, the properties of a difference."""

from __future__ import annotations

import html
import itertools
import json
import math

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from oblique_impact import History, InputError
from oblique_impact.contact.log import Event
from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.history.sample_times import ascending
from oblique_impact.validation import compare
from oblique_impact.validation.comparison import align
from oblique_impact.validation.report import Table, readable

END = 2.0

LOSSES = ("impact", "friction", "damping", "scheme")


def event(time, kind=EventKind.IMPACT, impulse=1.0):
    state = State.FREE if kind is EventKind.RELEASE else State.SLIP
    return Event(time, kind, impulse, 0.0, -1.0, 0.1, 0.0, state)


def labelled(values, dims, units, long_name):
    return xr.DataArray(values, dims=dims, attrs={"units": units, "long_name": long_name})


def made(times, values, events=(), state=None, **others):
    """A history of one variable `v`, linear between the given samples."""
    data = xr.Dataset(
        {
            "v": labelled(np.asarray(values, dtype=float), ("time",), "m", "a variable"),
            "state": labelled(np.zeros(len(times), np.int8) if state is None else state, ("time",), "1", "state"),
            **others,
        },
        coords={"time": labelled(ascending(np.asarray(times, dtype=float)), ("time",), "s", "time")},
    )
    energy = dict.fromkeys(("initial", "final", *(f"lost_{what}" for what in LOSSES)), 0.0)
    summary = {"outcome": "completed", "end_time": times[-1], "steps": 1, "macro_collisions": [], "energy": energy}
    return History(data, list(events), summary)


def step(at, samples=21):
    """A variable that is 0 up to an impact and 1 after it."""
    before, after = np.linspace(0.0, at, samples), np.linspace(at, END, samples)
    state = np.repeat(np.array([0, 1], np.int8), samples)
    return made(np.concatenate([before, after]), np.repeat([0.0, 1.0], samples), [event(at)], state)


def test_a_late_jump_is_large_at_equal_times_and_nothing_on_the_common_clock():
    """Unit jumps at 1.0 and 1.1 s in 2 s, sampled differently: 1 over 0.1 s, a twentieth of the span apart."""
    found = compare(step(1.0), step(1.1, samples=7))
    v = found["v"]
    assert v.scale == 1.0
    assert v.plain_rms == pytest.approx(math.sqrt(0.1 / END), rel=1e-12)
    assert (v.plain_largest, v.plain_at) == (-1.0, np.nextafter(1.0, 2.0))
    assert v.aligned_rms == v.aligned_largest == 0.0
    assert v.verdict == "same"
    assert found.tables["events"]["time_difference"][0] == pytest.approx(0.1)
    assert found.tables["pairs"].loc["right", "state_disagreement"] == 0.0


def test_states_disagree_where_events_are_not_shared():
    """Contact from 1 s on, and from 1.5 s on with an event of another kind: a quarter of the time."""
    late = step(1.5)
    pair = compare(step(1.0), late).tables["pairs"].loc["right"]
    assert pair.shared_events == 0  # further apart than a tenth of the span
    late.events[0] = event(1.5, EventKind.REBOUND)
    found = compare(step(1.0), late)
    pair = found.tables["pairs"].loc["right"]
    assert pair.state_disagreement == pytest.approx(0.25)
    assert "contact states differ in 25 % of the time" in str(found)
    assert (pair.only_left, pair.only_right) == (1, 1)
    assert pair.largest_shift == 0.0


def test_rms_of_linear_courses_is_exact():
    """0 against t over 2 s: the root of 4/3."""
    flat, rising = made([0.0, 0.7, END], [0.0, 0.0, 0.0]), made([0.0, END], [0.0, END])
    v = compare(flat, rising)["v"]
    assert v.plain_rms == pytest.approx(math.sqrt(4.0 / 3.0), rel=1e-15)
    assert (v.plain_largest, v.plain_at, v.verdict) == (2.0, 2.0, "apart")


def test_a_history_is_equal_to_itself(run):
    history = run("paper")
    found = compare(history, history)
    pair = found.tables["pairs"].loc["right"]
    assert pair.shared_events == len(found.tables["events"]) == len(history.events)
    assert pair.largest_shift == pair.state_disagreement == 0.0
    for name, v in found.frame.iterrows():
        assert (v.plain_rms, v.plain_largest, v.aligned_rms, v.aligned_largest) == (0.0,) * 4, name
    assert found.verdicts == {"same": len(found.frame)}
    of_both = found.tables["runs"]
    assert of_both["left"].equals(of_both["right"])
    assert of_both["left"]["impulse"] == history.macro_collisions[0]["normal_impulse"]
    assert pair.not_compared == ""


def test_results_along_the_beam_are_taken_at_the_same_stations():
    """A field that is linear along the beam is the same on any stations; another one differs by its own mean."""

    def field(points, slope):
        stations = np.linspace(0.0, 1.0, points)
        values = np.outer([1.0, 1.0], slope * stations)
        history = made([0.0, END], [0.0, 0.0], u=labelled(values, ("time", "station"), "m", "a field"))
        station = labelled(stations, ("station",), "m", "arc length")
        return History(history.data.assign_coords(station=station), [], history.summary)

    assert abs(compare(field(5, 1.0), field(8, 1.0))["u"].plain_largest) < 1e-15
    u = compare(field(5, 1.0), field(8, 3.0))["u"]
    assert u.plain_largest == 2.0
    # the mean of (2 x)^2 by the trapezoidal rule on the five stations of the first
    common = np.linspace(0.0, 1.0, 5)
    assert u.plain_rms == pytest.approx(math.sqrt(np.trapezoid(4.0 * common**2, common)), rel=1e-12)


def best(left, right, kinds_left, kinds_right, limit):
    """The best alignment by trying all: most pairs, then the least sum of time differences."""
    ways = [(0, 0.0)]
    for size in range(1, min(len(left), len(right)) + 1):
        for i in itertools.combinations(range(len(left)), size):
            for j in itertools.combinations(range(len(right)), size):
                apart = [abs(left[a] - right[b]) for a, b in zip(i, j, strict=True)]
                same = all(kinds_left[a] == kinds_right[b] for a, b in zip(i, j, strict=True))
                if same and max(apart) <= limit:
                    ways.append((-size, sum(apart)))
    return min(ways)


logs = st.lists(st.tuples(st.integers(0, 40), st.sampled_from("abc")), max_size=6).map(sorted)


@settings(max_examples=150, deadline=None)
@given(logs, logs, st.sampled_from([3.0, 10.0, math.inf]))
def test_alignment_is_the_best_there_is(a, b, limit):
    left, right = [float(t) for t, _ in a], [float(t) for t, _ in b]
    kinds = [k for _, k in a], [k for _, k in b]
    places = align(left, right, *kinds, max_shift=limit)
    pairs = [(i, j) for i, j in places if i is not None and j is not None]
    assert [i for i, _ in places if i is not None] == list(range(len(a)))
    assert [j for _, j in places if j is not None] == list(range(len(b)))
    size, apart = best(left, right, *kinds, limit)
    assert len(pairs) == -size
    assert sum(abs(left[i] - right[j]) for i, j in pairs) == pytest.approx(apart, abs=1e-9)


def test_bad_input_is_one_line():
    with pytest.raises(InputError, match="no time in common: 0 to 2 s and 5 to 6 s"):
        compare(step(1.0), made([5.0, 6.0], [0.0, 0.0]))


# --- the command


def test_runs_become_a_page_or_numbers(run, tmp_path, cli):
    """An undamped beam on a rigid stop, which is warned of, and one with a damping that its modes resolve."""
    alike = ("paper", "end_time=0.33", "discretization.modes=4")
    histories = run(*alike), run(*alike, "beam.kelvin_voigt=2e-4")
    folders = [history.save(tmp_path / name) for name, history in zip("ab", histories, strict=True)]
    for suffix in ("html", "json"):
        code, out, err = cli("compare", *folders, "--out", tmp_path / "new" / f"c.{suffix}")
        assert (code, err) == (0, "")
        assert "1 key differs: beam.kelvin_voigt (0.0, 0.0002)\n" in out
        assert f"{folders[0]} and {folders[1]} share " in out
        assert out.endswith(f"report: {tmp_path}/new/c.{suffix}\n")
    found = compare(*histories)
    (warning,) = histories[0].summary["warnings"]
    assert histories[1].summary["warnings"] == []
    data = json.loads((tmp_path / "new" / "c.json").read_text())
    assert data["pairs"][0]["largest_shift"] == found.tables["pairs"]["largest_shift"].iloc[0]
    assert {v["variable"]: v["aligned_rms"] for v in data["variables"]} == dict(found.frame["aligned_rms"])
    assert [one["beam"]["kelvin_voigt"] for one in data["scenarios"].values()] == [0.0, 2e-4]
    assert f"warning ({folders[0]}): {warning}" in data["remarks"]
    page = html.unescape((tmp_path / "new" / "c.html").read_text())
    assert warning in out
    assert readable(warning) in page
    assert f"oblique-impact compare {folders[0]} {folders[1]}" in page


def test_several_runs_are_compared_with_the_first_and_their_keys_stand_first(run):
    runs = {angle: run("paper", "end_time=0.33", f"slope.angle={angle}") for angle in (0.3, 0.31, 0.32)}
    result = compare(*runs.values(), names=["a", "b", "c"])
    alone = compare(runs[0.3], runs[0.32])
    assert result.tables["pairs"].index.tolist() == ["b", "c"]
    assert result.tables["pairs"].loc["c"].tolist() == alone.tables["pairs"].loc["right"].tolist()
    _, differ, measured = (block for block in result.report().overview if isinstance(block, Table))
    assert [[cell.text for cell in row] for row in differ.cells()] == [
        ["inclination of the slope from the horizontal", "slope.angle", "rad", "0.3", "0.31", "0.32"]
    ]
    first = next(row for row in measured.cells() if row[0].text == "first touch-down")
    assert [float(cell.text) for cell in first[2:]] == pytest.approx(
        [history.macro_collisions[0]["start"] for history in runs.values()], abs=5e-6
    )
    with pytest.raises(InputError, match="at least two"):
        compare(runs[0.3])


def test_long_tables_of_a_comparison_are_folded(run):
    history = run("slap", "end_time=0.385")
    sections = {section.title: section for section in compare(history, history).report().sections}
    assert not sections["right: events"].opened
    assert sections["right: events"].count == f"{len(history.events)} rows"


BAD = {
    "not a run": ("nowhere", "nowhere", "c.html", "nowhere"),
    "another kind of file": ("nowhere", "nowhere", "c.pdf", "should end in .html or .json"),
    "one run": ("nowhere", None, "c.html", "RIGHT"),
}


@pytest.mark.parametrize("case", BAD)
def test_refused_input_is_one_line_and_exit_2(tmp_path, refused, case):
    left, right, out, part = BAD[case]
    assert part in refused("compare", *filter(None, (left, right)), "--out", tmp_path / "never" / out)
    assert not (tmp_path / "never").exists()

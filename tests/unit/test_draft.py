"""What is done while a run goes on: the same history, whatever is written ahead or comes between."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from oblique_impact import Draft, History, Scenario, simulate
from oblique_impact.history import ahead, draft
from oblique_impact.history.growing import Columns
from oblique_impact.history.netcdf_writer import NetcdfWriter

NODAL = (
    'discretization={method="fem", elements=8, modes=0, frame="mean-axis"}',
    "solver.scheme=generalized-alpha",
    "solver.free_step=5e-4",
)


@pytest.fixture(autouse=True)
def small(monkeypatch):
    """Everything in small portions."""
    monkeypatch.setattr(ahead, "_PORTION", 200)
    monkeypatch.setattr(draft, "BEGIN", 200_000)
    monkeypatch.setattr(draft, "STEP", 300_000)
    monkeypatch.setattr("oblique_impact.history.netcdf_writer._CHUNK", 5000)


def scenario(*changes):
    return Scenario.builtin("paper", ["end_time=0.4", *changes])


def same(one: History, other: History) -> None:
    xr.testing.assert_identical(one.data.drop_attrs(deep=False), other.data.drop_attrs(deep=False))
    assert one.events == other.events
    assert {**one.summary, "wall_time": 0.0} == {**other.summary, "wall_time": 0.0}


@pytest.mark.parametrize("changes", [(), NODAL], ids=["modes", "nodes"])
def test_a_history_written_on_the_way_is_that_written_at_the_end(tmp_path, changes):
    written = []
    with Draft(tmp_path / "draft") as begun:
        history = simulate(scenario(*changes), lambda status: written.append(begun.begun), begun)
        assert written[-1]
        assert [file.name for file in begun.folder.iterdir()] == [".history.part.nc"]
        history.save(begun.folder, begun)
        assert not begun.begun
    history.save(tmp_path / "whole")
    same(simulate(scenario(*changes)), history)
    same(History.load(tmp_path / "draft"), History.load(tmp_path / "whole"))
    names = [sorted(file.name for file in (tmp_path / name).iterdir()) for name in ("draft", "whole")]
    assert names[0] == names[1]
    # and others read it as well
    with xr.open_dataset(tmp_path / "draft" / "history.nc", engine="h5netcdf") as plain:
        xr.testing.assert_equal(plain.load(), history.data)


@pytest.mark.parametrize("at", [0, 1, 3])
def test_a_draft_that_fails_leaves_the_history_to_the_end(tmp_path, monkeypatch, at):
    append, calls = NetcdfWriter.append, []

    def failing(self, variables):
        calls.append(self)
        if len(calls) > at:
            raise OSError(28, "No space left on device")
        append(self, variables)

    monkeypatch.setattr(NetcdfWriter, "append", failing)
    with Draft(tmp_path) as begun:
        history = simulate(scenario(), draft=begun)
        assert len(calls) == at + 1  # it is not tried again
        assert list(tmp_path.iterdir()) == []
        history.save(tmp_path, begun)
    same(History.load(tmp_path), simulate(scenario()))


def test_a_draft_nobody_completes_is_removed(tmp_path):
    (tmp_path / ".history.part.nc").write_text("of a process that was killed")
    with Draft(tmp_path) as begun:
        assert list(tmp_path.iterdir()) == []
        simulate(scenario(), draft=begun)
        assert list(tmp_path.iterdir()) != []
    assert list(tmp_path.iterdir()) == []


def test_a_history_saved_elsewhere_does_without_the_draft(tmp_path):
    with Draft(tmp_path / "here") as begun:
        history = simulate(scenario(), draft=begun)
        history.save(tmp_path / "there", begun)
        assert begun.begun
    same(History.load(tmp_path / "there"), history)


def test_a_draft_of_another_run_is_not_taken_for_this_one(tmp_path):
    with Draft(tmp_path / "out") as begun:
        first = simulate(scenario(), draft=begun)
        second = simulate(scenario("contact.mu_kinetic=0.1"), draft=begun)
        first.save(tmp_path / "out", begun)
        same(History.load(tmp_path / "out"), first)
        assert begun.begun
        second.save(tmp_path / "out", begun)
        assert not begun.begun
        same(History.load(tmp_path / "out"), second)


@pytest.mark.parametrize("place", ["gather", "put", "advance"])
@pytest.mark.parametrize("nth", [0, 1, 2])
def test_an_interrupt_at_any_instant_loses_and_doubles_nothing(tmp_path, monkeypatch, place, nth):
    """Of Python's own kind, which comes where it likes."""
    where, name = {
        "gather": (ahead.Ahead, "_take"),
        "put": (Columns, "put"),
        "advance": (NetcdfWriter, "append"),
    }[place]
    original, calls = getattr(where, name), []

    def interrupted(*arguments, **options):
        calls.append(place)
        result = original(*arguments, **options)
        if len(calls) == nth + 1:
            raise KeyboardInterrupt
        return result

    whole = simulate(scenario())
    monkeypatch.setattr(where, name, interrupted)
    with Draft(tmp_path) as begun:
        history = simulate(scenario(), draft=begun)
        history.save(tmp_path, begun)
    assert history.summary["outcome"] == "interrupted"
    count = history["time"].size
    assert 0 < count < whole["time"].size
    # the last sample is taken where the interrupt has come, the right-hand one of a jump perhaps
    for label, variable in history.data.data_vars.items():
        expected, found = whole[label].values[: count - 1], variable.values[: count - 1]
        scale = np.nanmax(np.abs(expected), initial=0.0)
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12 * scale, err_msg=str(label))
    same(History.load(tmp_path), history)


def test_columns_grow_and_can_be_put_again():
    columns = Columns()
    rows = np.arange(3000.0).reshape(1000, 3)
    for start in range(0, 1000, 70):
        part = slice(start, start + 70)
        for _ in range(2):
            columns.put(start, {"a": rows[part], "b": rows[part, 0].astype(np.int8)})
        stop = min(start + 70, 1000)
        np.testing.assert_array_equal(columns.view(stop)["a"], rows[:stop])
    taken = columns.take_out(1000)
    assert taken["a"].shape == (1000, 3)
    assert taken["b"].dtype == np.int8
    np.testing.assert_array_equal(taken["a"], rows)
    assert columns.view(1) == {}

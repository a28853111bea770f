"""History files: written whole or not at all, read back equal, damage refused in one line."""

import json
import os

import h5py
import numpy as np
import pytest
import xarray as xr

from oblique_impact import History, InputError, Scenario, simulate
from oblique_impact.history import EVENT_COLUMNS, FILES


@pytest.fixture(scope="module")
def history(run):
    return run("paper", "end_time=0.35")


def test_round_trip(history, tmp_path):
    folder = history.save(tmp_path / "a" / "b")
    for source in (folder, folder / "history.nc"):
        again = History.load(source)
        xr.testing.assert_identical(again.data.drop_attrs(deep=False), history.data.drop_attrs(deep=False))
        assert again.events == history.events
        assert again.summary == json.loads(json.dumps(history.summary))
        assert again.scenario_toml == history.scenario_toml
        assert again.outcome is history.outcome


def test_labels(history):
    assert set(history.data.dims) >= {"time"}
    for name, array in history.data.variables.items():
        assert array.attrs.get("long_name"), name
        assert "units" in array.attrs, name
        assert array.dtype.kind in "fiu", name
    assert history["lambda_n"].attrs["units"] == "N"


def test_a_jump_has_two_samples_at_one_time(history):
    time, rate = history["time"].values, history["gap_rate"].values
    assert np.all(np.diff(time) >= 0.0)
    impact = history.events[0]
    left, right = np.flatnonzero(time == impact.time)
    assert rate[left] == pytest.approx(impact.normal_velocity, rel=1e-12)
    assert abs(rate[right]) < 1e-12


def test_csv_has_a_row_an_event(history):
    lines = history.events_csv().splitlines()
    assert lines[0] == ",".join(EVENT_COLUMNS)
    assert len(lines) == 1 + len(history.events)
    assert [float(line.split(",")[0]) for line in lines[1:]] == [event.time for event in history.events]


def test_a_failed_write_leaves_the_old_files_whole(history, tmp_path, monkeypatch):
    folder = history.save(tmp_path / "run")
    before = {name: (folder / name).read_bytes() for name in FILES}

    def full(*paths):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(InputError, match=r"cannot be written.*No space left"):
        history.save(folder)
    assert {path.name for path in folder.iterdir()} == set(FILES)
    assert {name: (folder / name).read_bytes() for name in FILES} == before


def test_damaged_files_are_refused_in_one_line(history, tmp_path):
    whole = (history.save(tmp_path / "run") / "history.nc").read_bytes()
    for place, content in enumerate((b"", b"not a file of this kind", whole[: len(whole) // 2], whole[:100])):
        file = tmp_path / f"{place}.nc"
        file.write_bytes(content)
        with pytest.raises(InputError) as error:
            History.load(file)
        assert str(file) in str(error.value)
        assert len(str(error.value).splitlines()) == 1
    with pytest.raises(InputError, match="missing"):
        History.load(tmp_path / "missing")


def test_what_is_no_history_is_called_so(history, tmp_path):
    run, words = history.save(tmp_path / "run"), "is not a history written by oblique-impact (history.nc)"
    files = {name: tmp_path / name for name in ("text.nc", "beam.toml", "foreign.h5", "other.h5", "named.h5")}
    files["text.nc"].write_text("not a history")
    files["beam.toml"].write_text("end_time = 1.0\n")
    for name, format in (("foreign.h5", None), ("other.h5", 3), ("named.h5", np.bytes_(b"VTKHDF"))):
        with h5py.File(files[name], "w") as file:
            file["time"] = [0.0]
            if format is not None:
                file.attrs["format"] = format
    for file in [*files.values(), run / "scenario.toml", run / "summary.json"]:
        with pytest.raises(InputError) as error:
            History.load(file)
        message = str(error.value)
        assert message.startswith(f"{file}: {words}")
        assert (f"oblique-impact run {file} --out DIR" in message) == (file.name == "beam.toml")
        assert (f"one lies beside it: {run / 'history.nc'}" in message) == (file.parent == run)
    whole = (run / "history.nc").read_bytes()
    (tmp_path / "cut.nc").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match=r"cut\.nc: not a readable history"):
        History.load(tmp_path / "cut.nc")


def test_a_folder_that_is_no_run_lists_what_it_lacks(history, tmp_path):
    run = history.save(tmp_path / "run")
    (run / "history.nc").unlink()
    with pytest.raises(InputError, match=r"run: is not the folder of a run: it lacks history\.nc$"):
        History.load(run)
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match=f"it lacks {', '.join(FILES)}$"):
        History.load(tmp_path / "empty")
    with pytest.raises(
        InputError, match="paper: no such history; run the scenario first: oblique-impact run paper"
    ):
        History.load("paper")


def test_another_format_is_refused_by_name(history, tmp_path):
    file = tmp_path / "other.nc"
    history.data.assign_attrs(format="oblique-impact history 0").to_netcdf(file, engine="h5netcdf")
    with pytest.raises(InputError, match="oblique-impact history 1"):
        History.load(file)


def test_a_run_repeats_itself_to_the_bit():
    scenario = Scenario.builtin("paper", ["end_time=0.33"])
    first, second = simulate(scenario), simulate(scenario)
    xr.testing.assert_identical(first.data, second.data)
    assert first.events == second.events

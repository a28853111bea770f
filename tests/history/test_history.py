"""Contents of a history and values between its samples; files are written whole and read back equal."""

from __future__ import annotations

import copy
import dataclasses
import json
import os
import pickle

import numpy as np
import pytest
import xarray as xr

from oblique_impact import FileWarning, History, InputError, Scenario, simulate, simulate_system
from oblique_impact.contact.state import State
from oblique_impact.history.interpolation import value_at
from oblique_impact.history.sample_times import ascending, first_sample, jumps, last_sample
from tests.refusals import refused_in_one_line
from tests.systems import Block

#: a first contact after 21 us, and few samples
NEAR = ("initial.angle=0.2214", "initial.angular_velocity=-3.786", "end_time=0.02", "solver.output_interval=1e-3")
FILES = {"scenario.toml", "history.nc", "events.csv", "summary.json"}


@pytest.fixture(scope="module")
def history(run):
    return run("paper", "end_time=0.35")


# Variables ------------------------------------------------------------------------------------------------------

UNITS = {
    "s": "time",
    "m or rad": "q",
    "m/s or rad/s": "qd",
    "m/s^2 or rad/s^2": "qdd",
    "m": "gap depth slip station tip_x tip_y deflection shortening clearance clearance_at ux uy "
    "contact_place contact_x contact_y contact_gap contact_slip",
    "m/s": "gap_rate slip_rate tip_vx tip_vy ux_dot uy_dot contact_slip_rate",
    "rad": "theta",
    "rad/s": "theta_dot",
    "N": "lambda_n lambda_tau contact_lambda_n contact_lambda_tau contact_fx contact_fy",
    "J": "energy_kinetic energy_elastic energy_gravity energy_contact",
    "1": "state contact_state contact_obstacle clearance_obstacle",
}


def test_each_variable_has_its_unit_and_a_name_of_its_own(history):
    expected = {name: unit for unit, names in UNITS.items() for name in names.split()}
    variables = {name: history[name] for name in history}
    assert {name: array.attrs["units"] for name, array in variables.items()} == expected
    assert len({array.attrs["long_name"] for array in variables.values()}) == len(variables)
    forces = history.section_forces()
    units = {"moment": "N m", "shear": "N", "axial_force": "N", "bending_stress": "Pa"}
    assert {name: array.attrs["units"] for name, array in forces.data_vars.items()} == units
    for array in (history["ux"], history["uy"], *forces.data_vars.values()):
        assert array.dims == ("time", "station")
    assert history["q"].dims == history["qd"].dims == ("time", "coordinate")
    flags = history["state"].attrs
    assert dict(zip(flags["flag_meanings"].split(), flags["flag_values"].tolist(), strict=True)) == {
        state.name.lower(): int(state) for state in State
    }


def test_a_jump_has_two_samples_next_to_each_other(history):
    time = history["time"].values
    assert np.all(np.diff(time) > 0.0)
    # every event has both sides, and nothing else stands so close
    left, right = (side(time, [event.time for event in history.events]) for side in (first_sample, last_sample))
    np.testing.assert_array_equal(right, left + 1)
    np.testing.assert_array_equal(np.flatnonzero(jumps(time)), left)


def test_steps_and_rejected_steps_are_told_apart():
    """A scheme of fixed steps takes 200 of 1e-5 s in 2 ms of flight, and rejects none."""
    flight = ["solver.scheme=fixed-step", "solver.free_step=1e-5", "end_time=0.002"]
    summary = simulate(Scenario.builtin("paper", flight)).summary
    assert (summary["steps"], summary["rejected_steps"]) == (200, 0)


# Answers --------------------------------------------------------------------------------------------------------


def test_between_samples(run, history):
    """Cubics through samples 1 ms apart meet those of a finer run in flight."""
    coarse = run("paper", "end_time=0.35", "solver.output_interval=1e-3")
    for time in (0.0505, 0.2004):
        now, then = coarse.at(time), history.at(time)
        assert float(now["theta"]) == pytest.approx(float(then["theta"]), abs=5e-7)  # a line: 2e-6
        assert float(now["gap"]) == pytest.approx(float(then["gap"]), abs=5e-7)
        np.testing.assert_allclose(now["uy"], then["uy"], atol=1e-6)
    assert float(history.at(0.05)["theta"]) == float(history["theta"].sel(time=0.05))
    for outside in (-1e-9, 0.36, float("nan")):
        with pytest.raises(InputError, match="should be from 0 to"):
            history.at(outside)


def test_a_cubic_does_not_reach_across_a_jump():
    """Lines of slope 1, 10 higher after the jump at 1 s: half a second beside it they are still lines."""
    times = ascending(np.array([0.0, 1.0, 1.0, 2.0, 3.0]))
    values = times + 10.0 * (np.arange(5) > 1)
    for rates in (None, np.ones(5)):
        assert float(value_at(times, values, rates, 1.5)) == pytest.approx(11.5, rel=1e-12)
        assert float(value_at(times, values, rates, 0.5)) == pytest.approx(0.5, rel=1e-12)


def test_the_sides_of_a_jump(history):
    """An impact ends the approach: before it the gap closes, after it it does not."""
    impact = history.events[0]
    before, after = (history.at(impact.time, side) for side in ("left", "right"))
    assert float(before["gap_rate"]) == pytest.approx(impact.normal_velocity, rel=1e-12)
    assert abs(float(after["gap_rate"])) < 1e-9
    assert float(after["slip_rate"]) == pytest.approx(impact.tangential_velocity, rel=1e-12)
    assert (int(before["state"]), int(after["state"])) == (0, int(impact.state))


@pytest.mark.parametrize("keys", [(), ("contact.shortening=false",), ("contact.enabled=false",)])
def test_one_contact_point_is_the_first_of_the_contacts(run, keys):
    """Without contact it is there too, always free."""
    history = run("paper", "end_time=0.35", *keys)
    assert history.data.sizes["contact"] == 1
    for name in ("gap", "slip", "slip_rate", "lambda_n", "lambda_tau", "state"):
        np.testing.assert_array_equal(history[f"contact_{name}"].values[:, 0], history[name].values)
    for axis in "xy":
        np.testing.assert_allclose(
            history[f"contact_{axis}"].values[:, 0], history[f"tip_{axis}"].values, atol=1e-14
        )
    tilt, size = history.scenario.slope.angle, history["lambda_n"].values.max()
    across = history["contact_fy"] * np.cos(tilt) - history["contact_fx"] * np.sin(tilt)
    np.testing.assert_allclose(across.values[:, 0], history["lambda_n"].values, atol=1e-14 * size)
    assert (history["contact_place"].values == history.scenario.contact.point).all()
    assert history["contact_obstacle"].values.tolist() == [0]
    assert bool(history.events) == ("contact.enabled=false" not in keys)
    assert {(event.obstacle, event.place) for event in history.events} <= {(0, history.scenario.contact.point)}


def test_tables(history):
    table = history.event_table
    assert list(table.columns[-2:]) == ["obstacle", "place"]
    assert list(table["time"]) == [event.time for event in history.events]
    assert table["time"][3] == history.events[2].time  # counted from 1, as `render --event 3` does
    assert history.contact_table["start"][1] == history.contacts[0].start
    series = history.to_dataframe()
    np.testing.assert_array_equal(series["q_1"], history["q"].values[:, 1])
    assert "ux" not in series
    energy = history.total_energy
    assert energy.attrs["units"] == "J"
    assert float(energy[0]) == pytest.approx(history.summary["energy"]["initial"], rel=1e-14)
    assert float(energy[-1]) == pytest.approx(history.summary["energy"]["final"], rel=1e-14)


def test_it_behaves(history):
    assert ("lambda_n" in history, "nothing" in history) == (True, False)
    assert pickle.loads(pickle.dumps(history))["theta"].equals(history["theta"])
    assert copy.copy(history).summary == history.summary
    assert len(history.plot().axes) == 10
    assert f"{history.macro_collisions[0]['normal_impulse']:.6g} N s" in repr(history)


# Files ----------------------------------------------------------------------------------------------------------


def test_round_trip(history, tmp_path):
    folder = history.save(tmp_path / "a" / "b")
    assert {file.name for file in folder.iterdir()} == FILES
    for source in (folder, folder / "history.nc"):
        again = History.load(source)
        xr.testing.assert_identical(again.data, history.data)
        xr.testing.assert_identical(again.section_forces(), history.section_forces())
        assert again.events == history.events
        assert again.contacts == history.contacts
        assert again.summary == json.loads((folder / "summary.json").read_text()) == history.summary
        assert again.scenario_toml == history.scenario_toml == (folder / "scenario.toml").read_text()
        assert again.outcome is history.outcome
    assert (folder / "events.csv").read_text() == history.events_csv()


def test_a_file_is_one_that_xarray_reads_and_may_hold_more(history, tmp_path):
    """With 32 modes there are as many coordinates as stations; a variable of the user's own keeps its own."""
    keys = ["end_time=0.001", "discretization.frame=mean-axis", "discretization.modes=32"]
    history = simulate(Scenario.builtin("paper", keys))
    assert history.data.sizes["station"] == history.data.sizes["coordinate"] == 33
    own = {"radius": ("station", np.linspace(0.0, 1.0, 33), {"units": "m"})}
    changed = dataclasses.replace(history, data=history.data.assign(own).assign_attrs(note="by hand"))
    folder = changed.save(tmp_path / "run")
    xr.testing.assert_identical(History.load(folder).data, changed.data)
    with xr.open_dataset(folder / "history.nc", engine="h5netcdf") as data:
        assert float(data["theta"].sel(time=0.0005, method="nearest")) == float(history.at(0.0005)["theta"])
        assert data["radius"].attrs["units"] == "m"
        assert data["moment"].dims == data["axial_force"].dims == ("time", "station")


def test_a_system_that_is_no_beam_comes_back_and_has_no_section_forces(tmp_path):
    falling = simulate_system(Block(lambda t, q, qd: (0.0, -9.8)), [0.0, 1.0], [0.0, 0.0], 0.1)
    xr.testing.assert_identical(History.load(falling.save(tmp_path)).data, falling.data)
    with pytest.raises(InputError, match="no beam"):
        falling.section_forces()


def falling_block():
    return simulate_system(Block(lambda t, q, qd: (0.0, -9.8)), [0.0, 0.1], [0.0, 0.0], 0.3)


@pytest.mark.parametrize("kind", ["one contact", "without contact", "two pegs", "a system"])
def test_a_history_of_format_2_is_read_as_one_of_this_version(kind, run, tmp_path):
    """It has no dimension `contact` where there is one contact, and no obstacle and place of its events."""
    cases = {
        "one contact": ("paper", "end_time=0.35"),
        "without contact": ("paper", "end_time=0.01", "contact.enabled=false"),
        "two pegs": ("two-pegs", "end_time=0.39"),
    }
    history = run(*cases[kind]) if kind in cases else falling_block()
    assert history.events or kind == "without contact"
    file = history.save(tmp_path) / "history.nc"
    data = xr.load_dataset(file, engine="h5netcdf").assign_attrs(format="oblique-impact history 2")
    if kind != "two pegs":
        data = data.drop_vars([name for name in data if "contact" in data[name].dims])
        data = data.drop_vars("clearance_obstacle", errors="ignore")
        data.attrs["events"] = json.dumps([row[:10] for row in json.loads(data.attrs["events"])])
    data.to_netcdf(file, engine="h5netcdf")
    with pytest.warns(FileWarning, match="has no digest"):
        found = History.load(file)
    assert found.events == history.events
    assert set(found) == set(history)
    xr.testing.assert_allclose(found.data, history.data, rtol=1e-12, atol=1e-12)
    for name in found:
        assert found[name].attrs["units"] == history[name].attrs["units"]
        assert found[name].attrs["long_name"] == history[name].attrs["long_name"]


def test_an_event_log_of_any_length_comes_back(run, tmp_path):
    """Attributes of HDF5 are short unless they are asked to be long."""
    history = run("paper", *NEAR)
    many = dataclasses.replace(history, events=history.events * 500)
    assert History.load(many.save(tmp_path)).events == many.events


def test_what_cannot_be_written_leaves_the_old_files_alone(history, tmp_path, monkeypatch):
    """A disk that is full while the last of the files is written."""
    for name in FILES:
        (tmp_path / name).write_text("earlier")
    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", lambda *names: (_ for _ in ()).throw(OSError(28, "No space left on device")))
        with pytest.raises(InputError, match="cannot be written: No space left"):
            history.save(tmp_path)
    assert {file.name: file.read_text() for file in tmp_path.iterdir()} == dict.fromkeys(FILES, "earlier")
    history.save(tmp_path)
    assert {file.name for file in tmp_path.iterdir()} == FILES


def damaged_data(data, summary):
    """Data of a history's file with one fault each, by the name of the fault."""

    def with_summary(**changes):
        return data.assign_attrs(summary=json.dumps(summary | changes))

    rows = json.loads(data.attrs["events"])
    rows[1][2] = None
    return {
        "older": data.drop_attrs(deep=False).assign_attrs(format="oblique-impact history 0"),
        "foreign": data.drop_attrs(deep=False),
        "without-force": data.drop_vars("lambda_n"),
        "without-moment": data.drop_vars("moment"),
        "unknown-state": data.assign(state=data["state"] + 7),
        "words": data.assign(theta=data["theta"].astype(str)),
        "backwards": data.isel(time=slice(None, None, -1)),
        "stations-of-another-beam": data.assign_coords(station=2.0 * data["station"].values),
        "null-in-events": data.assign_attrs(events=json.dumps(rows)),
        "no-scenario": data.assign_attrs(scenario="[beam\n"),
        "unbalanced": with_summary(energy={"initial": 1.0}),
        "no-warnings": with_summary(warnings=None),
    }


def test_damaged_files_are_refused_in_one_line(run, tmp_path):
    history = run("paper", *NEAR)
    folder = history.save(tmp_path / "run")
    whole = (folder / "history.nc").read_bytes()
    spoiled = {
        "text.nc": b"not a file of this kind",
        "half.nc": whole[: len(whole) // 2],
    }
    for name, content in spoiled.items():
        (tmp_path / name).write_bytes(content)
    data = xr.load_dataset(folder / "history.nc", engine="h5netcdf")
    changed = damaged_data(data, history.summary)
    for name, spoiled_data in changed.items():
        spoiled_data.to_netcdf(tmp_path / f"{name}.nc", engine="h5netcdf")
    (tmp_path / "empty").mkdir()
    for name in (*spoiled, *(f"{name}.nc" for name in changed), "missing", "empty", "run/scenario.toml"):
        with refused_in_one_line(str(tmp_path / name)):
            History.load(tmp_path / name)
    with pytest.raises(InputError, match="run the scenario first"):
        History.load("sticking")

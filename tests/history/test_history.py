"""History files: written whole or not at all, read back equal, damage refused in one line."""

import copy
import csv
import dataclasses
import json
import os
import pickle
from io import StringIO

import h5py
import numpy as np
import pytest
import xarray as xr
from scipy.integrate import trapezoid

from oblique_impact import History, InputError, Scenario, simulate
from oblique_impact.beam.operators import build_operators
from oblique_impact.beam.residual_flexibility import residual_compliance
from oblique_impact.contact.state import State
from oblique_impact.history import samples
from oblique_impact.history.events import EVENT_COLUMNS
from oblique_impact.history.history import FILES, FORMAT
from oblique_impact.history.sample_times import first_sample, jumps, last_sample
from oblique_impact.history.variables import NEEDED


@pytest.fixture(scope="module")
def history(run):
    return run("paper", "end_time=0.35")


def test_round_trip(history, tmp_path):
    folder = history.save(tmp_path / "a" / "b")
    for source in (folder, folder / "history.nc"):
        again = History.load(source)
        xr.testing.assert_identical(again.data.drop_attrs(deep=False), history.data.drop_attrs(deep=False))
        assert again.events == history.events
        assert again.contacts == history.contacts
        assert again.summary == json.loads(json.dumps(history.summary))
        assert again.scenario_toml == history.scenario_toml
        assert again.outcome is history.outcome


def test_a_file_is_the_same_before_and_after_labels_are_made(tmp_path):
    """A history that comes from a run keeps plain columns until `data` is asked for."""
    history = simulate(Scenario.builtin("paper").replace(end_time=0.1))
    early = History.load(history.save(tmp_path / "early"))
    assert history.data.sizes == early.data.sizes
    late = History.load(history.save(tmp_path / "late"))
    xr.testing.assert_identical(early.data, late.data)
    assert dataclasses.replace(history, contacts=[]).data is history.data


def test_fields_along_the_beam_are_computed_when_one_is_asked_for(monkeypatch):
    """A study of times and impulses has no use for section forces; what is sent to another process has them."""
    calls, compute = [], samples.fields_along
    monkeypatch.setattr(samples, "fields_along", lambda *arguments: calls.append(1) or compute(*arguments))
    short = Scenario.builtin("paper").replace(end_time=0.02)
    history = simulate(short)
    assert history.summary["clearance"] is not None
    assert history["gap"].dims == ("time",)
    assert "moment" in history
    assert not calls
    other = pickle.loads(pickle.dumps(history))
    assert len(calls) == 1
    moment = history["moment"].values
    assert history["shear"].shape == moment.shape == history["ux"].shape
    assert np.abs(moment).max() > 0.1
    assert len(calls) == 1
    np.testing.assert_array_equal(other["moment"].values, moment)


def test_variables_are_the_same_whichever_is_asked_for_first(tmp_path):
    """Some have their labels before section forces are computed: names, values, and what was written on them."""
    whole, early, saved = (simulate(Scenario.builtin("paper", ["end_time=0.02"])) for _ in range(3))
    order = list(whole.data.variables)
    early["gap"].attrs["note"] = whole["gap"].attrs["note"] = "by hand"
    assert list(early) == order
    saved["gap"].attrs["note"] = "by hand"
    assert History.load(saved.save(tmp_path))["gap"].attrs["note"] == "by hand"
    for name in ("gap", "q", "time", "station"):
        assert early[name].identical(whole[name])
    assert pickle.loads(pickle.dumps(early)).data.identical(whole.data)
    assert early.data.identical(whole.data)
    assert list(early.data.variables) == order


def test_steps_and_rejected_steps_are_told_apart():
    """A scheme of fixed steps takes 200 of 1e-5 s in 2 ms of flight, and rejects none."""
    flight = ["solver.scheme=fixed-step", "solver.free_step=1e-5", "end_time=0.002"]
    summary = simulate(Scenario.builtin("paper", flight)).summary
    assert (summary["steps"], summary["rejected_steps"]) == (200, 0)


def test_a_variable_is_an_attribute_from_the_first_word_on():
    """Before anything has asked for labelled data; one that is not there is still none."""
    history = simulate(Scenario.builtin("paper", ["end_time=0.01"]))
    assert float(history.theta[0]) == Scenario().initial.angle
    other = simulate(Scenario.builtin("paper", ["end_time=0.01"]))
    with pytest.raises(AttributeError, match="no attribute or variable 'nothing'"):
        other.nothing  # noqa: B018
    assert float(copy.deepcopy(other).theta[0]) == float(pickle.loads(pickle.dumps(other)).theta[0])


def test_labels(history):
    assert set(history.data.dims) >= {"time"}
    for name, array in history.data.variables.items():
        assert array.attrs.get("long_name"), name
        assert "units" in array.attrs, name
        assert array.dtype.kind in "fiu", name
    # of each variable, written down a second time
    units = {
        "s": "time",
        "m or rad": "q",
        "m/s or rad/s": "qd",
        "m": "gap depth slip station tip_x tip_y deflection shortening clearance clearance_at ux uy",
        "m/s": "gap_rate slip_rate tip_vx tip_vy ux_dot uy_dot",
        "rad": "theta",
        "rad/s": "theta_dot",
        "N": "lambda_n lambda_tau shear axial_force",
        "N m": "moment",
        "Pa": "bending_stress",
        "J": "energy_kinetic energy_elastic energy_gravity",
        "1": "state",
    }
    expected = {name: unit for unit, names in units.items() for name in names.split()}
    assert {str(name): array.attrs["units"] for name, array in history.data.variables.items()} == expected
    names = {str(name): array.attrs["long_name"] for name, array in history.data.variables.items()}
    assert len(set(names.values())) == len(names)
    for name, words in {
        "time": "time",
        "q": "coordinates",
        "qd": "generalized velocities",
        "gap": "normal gap",
        "slip": "tangential position",
        "gap_rate": "gap rate",
        "slip_rate": "slip velocity",
        "lambda_n": "normal contact force",
        "depth": "compression of the stop itself",
        "lambda_tau": "tangential contact force",
        "state": "contact state",
        "energy_kinetic": "kinetic energy",
        "energy_elastic": "elastic energy",
        "energy_gravity": "gravity energy",
        "station": "arc length from the root",
        "theta": "angle of the floating frame",
        "theta_dot": "angular velocity of the floating frame",
        "tip_x": "contact point, inertial x",
        "tip_y": "contact point, inertial y",
        "tip_vx": "contact point velocity, x",
        "tip_vy": "contact point velocity, y",
        "deflection": "transverse deflection of the axis",
        "shortening": "axial displacement of the axis",
        "clearance": "distance of the beam from the slope, negative below",
        "clearance_at": "arc length where the beam is closest",
        "ux": "axial displacement in the floating frame",
        "uy": "transverse displacement in the floating frame",
        "ux_dot": "rate of ux",
        "uy_dot": "rate of uy",
        "moment": "bending moment",
        "shear": "shear force",
        "axial_force": "axial force, tension positive",
        "bending_stress": "bending stress at the outer fibre",
    }.items():
        assert words in names.pop(name), name
    assert not names
    flags = history["state"].attrs
    assert dict(zip(flags["flag_meanings"].split(), flags["flag_values"].tolist(), strict=True)) == {
        state.name.lower(): int(state) for state in State
    }


def test_a_jump_has_two_samples_next_to_each_other(history):
    time, rate = history["time"].values, history["gap_rate"].values
    assert np.all(np.diff(time) > 0.0)
    impact = history.events[0]
    (left,) = np.flatnonzero(time == impact.time)
    assert time[left + 1] == np.nextafter(impact.time, np.inf)
    assert rate[left] == pytest.approx(impact.normal_velocity, rel=1e-12)
    assert abs(rate[left + 1]) < 1e-12
    # every event has both sides, and nothing else stands so close
    left, right = (side(time, [event.time for event in history.events]) for side in (first_sample, last_sample))
    np.testing.assert_array_equal(right, left + 1)
    np.testing.assert_array_equal(np.flatnonzero(jumps(time)), left)


def test_times_of_a_long_run_are_unique():
    history = simulate(Scenario.builtin("bouncing", ["end_time=0.35", "solver.output_interval=1e-5"]))
    time = history["time"].values
    assert time.size > 30_000
    assert np.all(np.diff(time) > 0.0)
    assert np.isin([event.time for event in history.events], time).all()


def test_a_loaded_history_does_what_xarray_does(history, tmp_path):
    loaded = History.load(history.save(tmp_path / "run"))
    time, theta = history["time"].values, history["theta"].values
    for data in (loaded, loaded.data):
        assert float(data.sel(time=0.2, method="nearest")["theta"]) == theta[np.argmin(abs(time - 0.2))]
        middle = 0.5 * (time[100] + time[101])
        assert float(data.interp(time=middle)["theta"]) == pytest.approx(
            0.5 * (theta[100] + theta[101]), rel=1e-14
        )
    binned = loaded.resample(time="10ms").mean()["theta"].values
    inside = (time >= 0.02) & (time < 0.03)
    assert binned[2] == pytest.approx(theta[inside].mean(), rel=1e-12)
    (line,) = loaded["theta"].plot()
    np.testing.assert_array_equal(line.get_ydata(), theta)


def test_a_file_that_xarray_has_written_is_read_as_xarray_reads_it(tmp_path):
    """Words of any length, lists of them, numbers, and variables that are not known."""
    history = simulate(Scenario.builtin("paper", ["end_time=0.01"]))
    data = history.data[[*NEEDED, "moment", "station"]].copy()
    data["own"] = ("time", "station"), data["moment"].values, {"units": "N m", "names": ["a", "bc"], "one": 1.5}
    data["axis"] = ("coordinate",), np.arange(data.sizes["coordinate"]), {"long": "ü" * 70_000}
    texts = {"format": FORMAT, "summary": json.dumps(history.summary), "events": "[]", "contacts": "[]", "odd": 3}
    data.assign_attrs(texts).to_netcdf(tmp_path / "theirs.nc", engine="h5netcdf")
    found = History.load(tmp_path / "theirs.nc").data
    with xr.open_dataset(tmp_path / "theirs.nc", engine="h5netcdf", decode_cf=False) as theirs:
        assert found.attrs == {"format": FORMAT, "odd": 3}
        assert set(found.variables) == set(theirs.variables)
        for name, variable in theirs.variables.items():
            assert (found[name].dims, found[name].dtype) == (variable.dims, variable.dtype), name
            np.testing.assert_array_equal(found[name].values, variable.values, err_msg=name)
            for label, value in variable.attrs.items():
                assert label == "_FillValue" or np.array_equal(found[name].attrs[label], value), (name, label)


def test_dimensions_come_back_as_they_were(tmp_path):
    """With 32 modes there are as many coordinates as stations; a variable of the user's own keeps its own."""
    history = simulate(
        Scenario.builtin("paper", ["end_time=0.001", "discretization.frame=mean-axis", "discretization.modes=32"])
    )
    assert history.data.sizes["station"] == history.data.sizes["coordinate"] == 33
    own = {
        "radius": ("station", np.linspace(0.0, 1.0, 33)),
        "frequency": ("coordinate", np.arange(33.0)),
        "curvature": (("time", "station"), history["uy"].values + 1.0),
        "participation": (("time", "coordinate"), history["q"].values + 1.0),
        "mixed": (("station", "coordinate"), np.arange(33.0 * 33.0).reshape(33, 33)),
    }
    changed = dataclasses.replace(history, data=history.data.assign(own))
    again = History.load(changed.save(tmp_path / "run"))
    xr.testing.assert_identical(again.data.drop_attrs(deep=False), changed.data.drop_attrs(deep=False))
    assert "dimensions" not in changed["radius"].attrs


@pytest.fixture(scope="module")
def elastic(run):
    """Contacts of an elastic stop with damping and friction."""
    keys = ("end_time=0.335", "contact.normal=spring", "contact.damping=0.3", "solver.output_interval=1e-5")
    return run("paper", *keys, "discretization.frame=mean-axis", "discretization.modes=4")


def test_each_contact_of_an_elastic_stop_has_its_impulse_peak_and_energy(elastic):
    """Against samples 10 µs apart, which miss a peak by up to some 1e-4 of it."""
    stiffness, time = 1e6, elastic["time"].values
    left_out = residual_compliance(build_operators(Scenario.from_toml(elastic.scenario_toml)), clamped=False)
    assert left_out > 0.2 / stiffness
    assert len(elastic.contacts) >= 3
    for contact in elastic.contacts:
        k = slice(int(last_sample(time, contact.start)), int(first_sample(time, contact.end)) + 1)
        normal, tangential = (elastic[name].values[k] for name in ("lambda_n", "lambda_tau"))
        for impulse, force in ((contact.normal_impulse, normal), (contact.tangential_impulse, tangential)):
            assert impulse == pytest.approx(trapezoid(force, time[k]), rel=1e-3, abs=1e-4)
        assert contact.peak_force == pytest.approx(normal.max(), rel=5e-4)
        depth = -elastic["gap"].values[k].min()
        # what the modes leave out gives way behind the stop, less by its inclination to the slope: 0.991 and more
        assert contact.peak_energy == pytest.approx(0.5 * depth**2 / (1.0 / stiffness + left_out), rel=3e-3)
        power = -(normal * elastic["gap_rate"].values[k] + tangential * elastic["slip_rate"].values[k])
        assert contact.energy_loss == pytest.approx(trapezoid(power, time[k]), rel=2e-3, abs=1e-5)
        assert contact.energy_loss > 1e-3


def test_contacts_add_up_to_collisions_and_losses(elastic, history):
    for run in (elastic, history):
        collisions, energy = run.summary["macro_collisions"], run.summary["energy"]
        for name in ("normal_impulse", "tangential_impulse"):
            total = sum(getattr(contact, name) for contact in run.contacts)
            assert total == pytest.approx(sum(m[name] for m in collisions), rel=1e-13)
            # an impulse stands in the row of an impact, or of the release that ends a contact
            assert total == pytest.approx(sum(getattr(event, name) for event in run.events), rel=1e-13)
        loss = energy["lost_impact"] + energy["lost_friction"] + energy["lost_damping"]
        assert sum(contact.energy_loss for contact in run.contacts) == pytest.approx(loss, rel=1e-12)
        assert sum(event.energy_loss for event in run.events) == pytest.approx(loss, rel=1e-12)


def test_the_csv_holds_the_contacts(elastic):
    with StringIO(elastic.events_csv()) as text:
        rows = [row for row in csv.DictReader(text) if row["kind"] == "release"]
    assert len(rows) == len(elastic.contacts)
    for row, contact in zip(rows, elastic.contacts, strict=True):
        assert float(row["time"]) == contact.end
        for name in ("normal_impulse", "tangential_impulse", "peak_force", "peak_energy", "energy_loss"):
            assert float(row[name]) == getattr(contact, name), name


def test_csv_has_a_row_an_event(history):
    lines = history.events_csv().splitlines()
    # the first seven are those of the contract of the file formats
    assert lines[0].startswith("time,kind,normal_impulse,normal_velocity,tangential_velocity,energy_loss,state,")
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


@pytest.mark.parametrize(
    "error", [OSError(28, "No space left on device"), KeyboardInterrupt()], ids=["full", "ctrl-c"]
)
@pytest.mark.parametrize("earlier", [FILES, (), ("summary.json",)], ids=["all", "none", "one"])
def test_files_stay_until_all_new_ones_are_complete(history, tmp_path, monkeypatch, error, earlier):
    """The first replacement fails: the earlier files are there, or there is none, as before."""
    for name in earlier:
        (tmp_path / name).write_text(f"earlier {name}")

    def fail(source, target):
        raise error

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises((InputError, KeyboardInterrupt)):
        history.save(tmp_path)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {n: f"earlier {n}" for n in earlier}


def test_a_folder_in_the_place_of_a_file_replaces_nothing(history, tmp_path):
    for name in FILES[:3]:
        (tmp_path / name).write_text("earlier")
    (tmp_path / FILES[3]).mkdir()
    with pytest.raises(InputError, match="cannot be written"):
        history.save(tmp_path)
    assert [(tmp_path / name).read_text() for name in FILES[:3]] == ["earlier"] * 3
    assert {path.name for path in tmp_path.iterdir()} == set(FILES)


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
    with pytest.raises(InputError, match="oblique-impact history 2"):
        History.load(file)


def test_a_run_repeats_itself_to_the_bit():
    scenario = Scenario.builtin("paper", ["end_time=0.33"])
    first, second = simulate(scenario), simulate(scenario)
    xr.testing.assert_identical(first.data, second.data)
    assert first.events == second.events

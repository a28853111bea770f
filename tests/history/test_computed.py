"""What a file holds, and what is computed of it when it is asked for: the same numbers, to the last digit."""

from __future__ import annotations

import h5py
import numpy as np
import pytest
import xarray as xr

from oblique_impact import FileWarning, History, InputError, Scenario, fem_beam, simulate
from oblique_impact.beam.base_motion import ConstantSpeed
from oblique_impact.history.variables import SECTION_FORCES, VARIABLES

#: the design of files names these among others
PROMISED = ("theta", "tip_vx", "deflection", "gap", "lambda_n", "energy_kinetic", "q", "qd", "ux", "uy", "moment")
PROMISED += ("axial_force",)
RATES, FORCES = {"ux_dot", "uy_dot"}, {"shear", "bending_stress"}
SHORT = ("end_time=0.33", "solver.output_interval=1e-3")
#: runs whose coordinates are few, with everything that shear and axial force depend on
FEW = {
    "modes": ("paper", *SHORT),
    "elements": ("paper", "discretization.method=fem", *SHORT),
    "loads": (
        *("paper", "discretization.method=fem", "root.kind=hub", "root.inertia=0.1", "root.hub_radius=0.1"),
        *("beam.kelvin_voigt=1e-5", "base={acceleration=3.0,frequency=4.0}", "masses=[{place=0.5,mass=0.1}]"),
        *("forces=[{place=0.7,force=2.0,frequency=3.0}]", *SHORT, "end_time=0.6"),
    ),
    "pegs": ("two-pegs", "end_time=0.39", "solver.output_interval=1e-3"),
}
#: those whose file has to hold everything: as many coordinates as all nodes have, or none of that kind
WHOLE = {
    "nodes": ("elastic-stop", "discretization.method=fem", "discretization.modes=0", "end_time=1e-3"),
    "exact": ("dropped-bar", "end_time=1e-3"),
}


def contents(file):
    with xr.open_dataset(file, engine="h5netcdf") as data:
        return set(map(str, data.variables))


def same(found, expected):
    """The same numbers, bit by bit, with the same units and meanings."""
    assert set(found) == set(expected)
    for name in expected:
        xr.testing.assert_identical(found[name].variable, expected[name].variable)
        assert np.asarray(found[name].values).tobytes() == np.asarray(expected[name].values).tobytes()


@pytest.mark.parametrize("case", FEW)
def test_what_a_file_lacks_is_computed_as_by_the_run_itself(case, run, tmp_path):
    history = run(*FEW[case])
    assert history.contacts
    file = history.save(tmp_path) / "history.nc"
    assert set(PROMISED) <= contents(file)
    assert not (RATES | FORCES) & contents(file)
    found = History.load(file)
    same(found, history)
    same(found.section_forces(), history.section_forces())
    assert set(found) >= RATES
    with pytest.raises(KeyError, match=r'history.section_forces\(\)\["moment"\]'):
        found["moment"]


@pytest.mark.parametrize("case", WHOLE)
def test_what_does_not_follow_from_a_file_is_in_it(case, run, tmp_path):
    history = run(*WHOLE[case])
    file = history.save(tmp_path) / "history.nc"
    assert {*PROMISED, *RATES, *FORCES} <= contents(file)
    assert "qdd" not in history
    found = History.load(file)
    same(found, history)
    same(found.section_forces(), history.section_forces())


def test_a_file_of_a_run_with_parts_of_its_users_does_not_need_them(tmp_path):
    scenario = Scenario.builtin("paper", ["root.kind=driven", "contact.enabled=false", "end_time=0.01"])
    for parts in ({"base_motion": ConstantSpeed(2.0)}, {"discretization": fem_beam}):
        history = simulate(scenario, **parts)
        file = history.save(tmp_path / next(iter(parts))) / "history.nc"
        assert contents(file) >= RATES | FORCES
        same(History.load(file).section_forces(), history.section_forces())


def test_rates_are_those_of_the_displacements(run):
    """Against differences over 0.1 ms in flight: in error by (w h)^2/6, with 2 kHz in the shortening 1 %."""
    history = run("paper", "end_time=0.3")
    times = history["time"].values
    for name in ("ux", "uy"):
        slopes = np.gradient(history[name].values, times, axis=0, edge_order=2)
        rates = history[f"{name}_dot"].values
        np.testing.assert_allclose(rates, slopes, rtol=0.0, atol=1e-2 * np.abs(rates).max())
        between = history.at(0.5 * (times[1000] + times[1001]))
        np.testing.assert_allclose(
            between[f"{name}_dot"], 0.5 * (rates[1000] + rates[1001]), atol=1e-2 * np.abs(rates).max()
        )


def test_a_file_of_format_3_which_holds_all_is_read_as_it_is(run, tmp_path):
    """What it has is taken, also where it could be computed: here it is doubled."""
    history = run(*FEW["modes"])
    file = history.save(tmp_path) / "history.nc"
    data = xr.load_dataset(file, engine="h5netcdf").drop_vars("qdd")
    along = {name: history[name] for name in RATES} | {name: history.section_forces()[name] for name in FORCES}
    along["shear"] = 2.0 * along["shear"].assign_attrs()
    data = data.assign(along).assign_attrs(format="oblique-impact history 3")
    data.to_netcdf(file, engine="h5netcdf")
    with pytest.warns(FileWarning, match="has no digest"):
        found = History.load(file)
    assert set(found) == set(history) - {"qdd"}
    for name in found:
        np.testing.assert_array_equal(found[name].values, history[name].values)
    for name, values in history.section_forces().items():
        np.testing.assert_array_equal(found.section_forces()[name], (1.0 + (name == "shear")) * values)
    again = History.load(found.save(tmp_path / "again"))
    same(again, found)
    same(again.section_forces(), found.section_forces())
    data.drop_vars("shear").to_netcdf(file, engine="h5netcdf")
    with pytest.raises(InputError, match="no variable 'shear'"):
        History.load(file)


def test_a_file_is_small_and_in_pieces_of_time(run, tmp_path):
    """Less than half of 8 bytes for each number of a history; some instants are read without the others."""
    history = run("paper", "end_time=0.4")
    file = history.save(tmp_path) / "history.nc"
    lengths = history.data.sizes
    values = sum(
        np.prod([lengths[name] for name in VARIABLES[name].dimensions])
        for name in {*history, *SECTION_FORCES} - {"qdd"}
    )
    assert file.stat().st_size < 0.5 * 8.0 * values
    with h5py.File(file) as opened:
        for name in ("ux", "moment", "time"):
            kept = opened[name]
            assert kept.compression == "gzip"
            assert np.prod(kept.chunks) * kept.dtype.itemsize <= 2**19
            assert kept.chunks[1:] == kept.shape[1:]
            assert kept.chunks[0] < kept.shape[0] or name == "time"


def test_a_variable_of_words_is_refused_in_one_line(run, tmp_path):
    history = run(*FEW["modes"])
    history = History(history.data.assign(note=("time", np.full(history["time"].size, "x"))), [], history.summary)
    with pytest.raises(InputError, match="history: variable 'note' is not of numbers"):
        history.save(tmp_path)

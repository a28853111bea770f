"""What stops, beds and contact flexibilities hold: with it the energy balances at every sample of a run."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from oblique_impact import History, Scenario, simulate
from oblique_impact.errors import FileWarning
from oblique_impact.history import history as histories
from oblique_impact.marching.equations import (
    DAMPING_LOSS,
    FRICTION_LOSS,
    STABILIZATION_LOSS,
    STOP_LOSS,
    SUPPLIED,
    of_all_contacts,
)
from oblique_impact.renders import panels
from tests.systems import PowerLaw

ON_A_SPRING = "contact.normal=spring", "end_time=0.335"
PEGS = "obstacles=[{kind='point', origin=[0.4,-0.02]}, {kind='point', origin=[0.7,-0.036]}]"
TWO_PEGS = "contact.normal=spring", PEGS, "contact.axial_flexibility=true", "end_time=0.42"
ON_A_BED = (
    *("contact.where=anywhere", "contact.normal=spring", "slope.enabled=false", "initial.angle=0"),
    *("root.kind=hub", "root.inertia=0.01", "root.torque=-10", "beam.youngs_modulus=7e9", "end_time=0.06"),
    "obstacles=[{kind='side', origin=[0.2, -0.05], extent=[0.0, 0.7907], bedding=1e6}]",
)
EXACT = (
    *("discretization.method=absolute", "discretization.elements=8"),
    *("solver.free_step=2e-4", "solver.contact_step=2e-5", "contact.grid=8"),
)
#: scenario, keys, own laws, and what the balance closes to (J), of some 3 J and of the bed 0.2 J
CASES = {
    "linear": ("paper", ON_A_SPRING, {}, 1e-10),
    "stiff": ("paper", (*ON_A_SPRING, "contact.stiffness=1e30"), {}, 1e-10),
    "damped": ("paper", (*ON_A_SPRING, "contact.damping=0.5", "beam.kelvin_voigt=1e-5"), {}, 1e-10),
    "damped Hertz": ("paper", ON_A_SPRING, {"contact_law": PowerLaw(1e8, damping=0.3)}, 1e-9),
    "axial": ("two-pegs", TWO_PEGS, {}, 1e-9),
    "bed": ("paper", (*ON_A_BED, "contact.grid=8", "discretization.modes=3"), {}, 1e-9),
    "exact beam on a bed": ("paper", (*ON_A_BED, *EXACT), {}, 1e-10),
    "without inertia": ("damped", ("contact.point_inertia=none", "end_time=0.335"), {}, 1e-9),
}


def losses(record, samples) -> np.ndarray:
    """Energy (J) lost less what was supplied up to each sample."""
    kept = samples.quadratures
    found = kept[:, [DAMPING_LOSS, STABILIZATION_LOSS]].sum(axis=1) - kept[:, SUPPLIED]
    found += of_all_contacts(kept, FRICTION_LOSS) + of_all_contacts(kept, STOP_LOSS)
    for event in record.events:
        if event.kind.impulsive:
            found = found + event.energy_loss * (samples.time > event.time)
    return found - samples.stretched  # which friction has not taken yet


@pytest.fixture
def ledgers(monkeypatch):
    """Losses at the samples of the runs that a test makes."""
    found, plain = [], histories.summarize

    def summarize(record, samples, *rest):
        found.append(losses(record, samples))
        return plain(record, samples, *rest)

    monkeypatch.setattr(histories, "summarize", summarize)
    return found


@pytest.mark.parametrize("name", CASES)
def test_the_energy_balances_at_every_sample(name, ledgers):
    scenario, keys, laws, closure = CASES[name]
    history = simulate(Scenario.builtin(scenario, keys), **laws)
    held, total = history["energy_contact"], history.total_energy.values
    assert (held.attrs["units"], "stops" in held.attrs["long_name"]) == ("J", True)
    assert held.values.max() > 2e-3
    assert held.values.min() >= 0.0
    np.testing.assert_allclose(total + ledgers[-1], history.balance["initial"], rtol=0, atol=closure)
    assert held.values[-1] == history.balance["contact"]
    assert total[-1] == pytest.approx(history.balance["final"], rel=1e-14)
    curves = {curve.label: curve.values for curve in panels.energy(panels.Runs([history], [""])).curves}
    np.testing.assert_array_equal(curves["stop"] - curves["stop"][0], held.values - held.values[0])


def test_a_stop_that_is_pressed_in_at_the_start_holds_energy_from_the_first_sample_on(ledgers):
    keys = *ON_A_SPRING, "end_time=0.3178", "contact.residual_flexibility=false"
    first = simulate(Scenario.builtin("paper", keys))
    state = first["q"].values[-1], first["qd"].values[-1]
    history = simulate(first.scenario.replace(end_time=0.01), initial_state=state)
    assert first.balance["contact"] > 0.1
    assert history["energy_contact"].values[0] == pytest.approx(first.balance["contact"], rel=1e-12)
    assert history.balance["initial"] == pytest.approx(first.balance["final"], rel=1e-12)
    np.testing.assert_allclose(history.total_energy.values + ledgers[-1], history.balance["initial"], atol=1e-10)


def test_an_older_file_without_the_variable_loads_and_is_drawn_without_a_part_of_the_stop(tmp_path):
    history = simulate(Scenario.builtin("paper", ["contact.normal=spring", "end_time=0.32"]))
    file = history.save(tmp_path) / "history.nc"
    older = xr.load_dataset(file, engine="h5netcdf").drop_vars("energy_contact")
    older.to_netcdf(tmp_path / "older.nc", engine="h5netcdf")
    with pytest.warns(FileWarning, match="has no digest"):
        loaded = History.load(tmp_path / "older.nc")
    assert "energy_contact" not in loaded
    whole, left = (panels.energy(panels.Runs([each], [""])).curves for each in (history, loaded))
    assert [curve.label for curve in left] == [curve.label for curve in whole if curve.label != "stop"]
    np.testing.assert_allclose(
        whole[-1].values - left[-1].values, history["energy_contact"].values, rtol=0, atol=1e-12
    )

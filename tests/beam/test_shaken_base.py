"""A shaken base against other gravities, and tables over time; the rest are the checks of the group `base`."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from oblique_impact import InputError, Scenario, simulate

MODELS = {
    "modes": "discretization.modes=4",
    "mean-axis": "discretization.modes=4 discretization.frame=mean-axis",
    "elements": "discretization.method=fem discretization.elements=8 discretization.modes=4",
    "nodes": "discretization.method=fem discretization.elements=8 discretization.modes=0",
    "exact": "discretization.method=absolute discretization.elements=4",
    "held": "root.kind=driven root.hub_radius=0.1",
    "hub": "root.kind=hub root.hub_radius=0.1 root.inertia=0.01 root.torque=1",
}
NODES = MODELS["nodes"]


@pytest.fixture(autouse=True)
def nodes_interpreted(request):
    """All nodes on a base are some hundred steps here, which take less than their kernels take to compile."""
    if "[nodes]" in request.node.name:
        request.getfixturevalue("interpreted")


SHORT = ["end_time=0.1", "solver.output_interval=0.01", "contact.enabled=false"]


def run(name: str, keys: list[str]):
    return simulate(Scenario.builtin(name, keys))


@pytest.mark.parametrize("model", MODELS)
def test_a_steady_acceleration_is_a_gravity(model):
    """The base is accelerated in the direction d: gravity acts against d, or all is turned until d is upwards."""
    # coarse steps, the same in both runs
    steps = ["solver.free_step=1e-3"] if model in ("nodes", "exact") else []
    keys, turned, a = [*MODELS[model].split(), *SHORT, *steps], 0.9, 25.0
    shaken = run("paper", [*keys, "gravity=0", f"base.table=[[0,{a}],[1,{a}]]", f"base.direction={turned}"])
    angle = np.pi / 4 + np.pi / 2 - turned
    still = run("paper", [*keys, f"gravity={a}", f"initial.angle={angle!r}"])
    assert_allclose(shaken["theta"] + np.pi / 2 - turned, still["theta"], atol=1e-10)
    assert_allclose(shaken["uy"], still["uy"], atol=1e-10)
    for force in ("moment", "shear", "axial_force"):
        of_shaken, of_still = (h.section_forces()[force].values for h in (shaken, still))
        assert_allclose(of_shaken, of_still, atol=1e-6 * np.nanmax(np.abs(of_still)))
    # the base does the work that gravity does
    supplied, given = shaken.summary["energy"]["supplied"], still.summary["energy"]
    work = given["supplied"] - (given["gravity"] - still["energy_gravity"].values[0])
    # generalized-alpha, which marches all nodes, samples powers to second order of its step
    assert supplied == pytest.approx(work, abs=1e-6 if model == "nodes" else 1e-9)


@pytest.mark.slow  # the checks of the group `base` march a shaken beam by time-stepping too
def test_time_stepping_on_a_base_that_is_accelerated_upwards():
    """A beam that slaps onto a table: less gravity and a base that makes up for it."""
    keys = ["contact.grid=16", "discretization.elements=16", "end_time=0.39", "solver.free_step=5e-6"]
    still, shaken = (run("slap", [*keys, *more]) for more in ([], ["gravity=4", "base.table=[[0,5.8],[1,5.8]]"]))
    assert still.events
    assert_allclose(shaken["theta"], still["theta"], atol=1e-9)
    assert [e.kind for e in shaken.events] == [e.kind for e in still.events]
    assert abs(shaken.summary["energy"]["unaccounted"]) < 1e-8


@pytest.mark.parametrize("model", ["modes", "nodes"])
def test_rows_of_a_table_on_a_line_change_nothing(model):
    """A step ends at each of its kinks, and samples stay where they are due, with chosen and with equal steps."""
    ends, between = [[0, -30], [0.05, 60], [0.1, 10]], [[0, -30], [0.02, 6], [0.05, 60], [0.0613, 48.7], [0.1, 10]]
    keys = [*MODELS[model].split(), *SHORT, *(["solver.free_step=1e-4"] if model == "nodes" else [])]
    one, other = (run("paper", [*keys, f"base.table={rows}"]) for rows in (ends, between))
    assert_allclose(one["time"], other["time"], rtol=1e-12)
    assert_allclose(one["theta"], other["theta"], atol=1e-10 if model == "modes" else 1e-8)


def test_a_harmonic_acceleration_is_that_of_a_fine_table():
    """A sweep with its phase 2 pi (f t + r t^2/2), sampled finely: the error of a table falls like h^2."""
    t = np.linspace(0.0, 0.1, 2001)
    rows = np.stack([t, 30.0 * np.sin(2.0 * np.pi * (20.0 * t + 50.0 * t**2))], axis=1).tolist()
    sweep = ["base.acceleration=30", "base.frequency=20", "base.sweep_rate=100"]
    harmonic, table = (run("paper", [*SHORT, *keys]) for keys in (sweep, [f"base.table={rows}"]))
    assert_allclose(table["theta"], harmonic["theta"], atol=1e-7)
    assert np.ptp((harmonic["theta"] - run("paper", SHORT)["theta"]).values) > 1e-3


SOFT = "contact.stiffness=100 base.frequency=15 base.acceleration=5 solver.tolerance=1e-12"
OTHER_SIDE = "kind=side origin=[-0.002,0.25] angle=-1.5707963267948966 stiffness=100"
SPLIT = {
    # which press on their soft stops where the run is cut, and leave them
    "strip": ("shaken", "base.frequency=14 contact.stiffness=200 solver.tolerance=1e-12"),
    "both sides": (
        "shaken",
        f"{SOFT} contact.where=anywhere contact.grid=1 obstacles.1.{OTHER_SIDE.replace(' ', ' obstacles.1.')}",
    ),
    "nodes": (
        "paper",
        f"{NODES} solver.rho_infinity=1 solver.free_step=1e-3 contact.enabled=false "
        "base.acceleration=20 base.frequency=10",
    ),
}


@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=pytest.mark.slow) if case == "both sides" else case for case in SPLIT]
)
def test_a_run_goes_on_from_the_state_in_which_another_one_ends(case):
    """At a whole number of periods of the base."""
    name, keys = SPLIT[case]
    whole = Scenario.builtin(name, [*keys.split(), "end_time=1", "solver.output_interval=0.01"])
    period = 1.0 / whole.base.frequency
    whole = whole.replace(end_time=(8 if name == "shaken" else 2) * period)
    half = whole.replace(end_time=0.5 * whole.end_time)
    first, together = simulate(half), simulate(whole)
    second = simulate(half, initial_state=(first["q"].values[-1], first["qd"].values[-1]))
    assert case == "nodes" or first["lambda_n"].values[-1] > 0.0
    assert second["q"].values[0].tolist() == pytest.approx(first["q"].values[-1].tolist(), abs=1e-15)
    for name in ("q", "qd"):
        assert_allclose(
            second[name].values[-1], together[name].values[-1], atol=1e-9 * np.abs(together[name]).max()
        )
    for key, sign in (("supplied", 1.0), ("lost_damping", 1.0), ("lost_scheme", 0.0)):
        both = [history.balance[key] for history in (first, second)]
        assert sum(both) == pytest.approx(sign * together.balance[key], abs=1e-12)
    kept = second.summary["provenance"]["user_defined"]["initial_state"]
    assert kept[1] == first["qd"].values[-1].tolist()


def test_an_initial_state_that_does_not_fit_is_refused():
    strip = Scenario.builtin("shaken")
    with pytest.raises(InputError, match=r"initial_state, q: should be real numbers of shape \(7,\)"):
        simulate(strip, initial_state=(np.zeros(6), np.zeros(7)))
    with pytest.raises(InputError, match="initial_state: only with"):
        simulate(strip.adapted(discretization__method="absolute"), initial_state=(np.zeros(7), np.zeros(7)))

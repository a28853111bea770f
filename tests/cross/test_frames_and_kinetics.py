"""Frames and kinetic orders against each other (theory Secs. 2, 3 and 6): exchanged from the scenario alone."""

from __future__ import annotations

import numpy as np
import pytest

SMALL = ("end_time=0.3",)
FRAMES = ("tangent", "mean-axis")


def tip(history, times):
    return np.stack([np.interp(times, history["time"], history[name]) for name in ("tip_x", "tip_y")])


def test_tangent_and_mean_axis_full_agree_as_modes_are_added(run):
    """The same continuous beam in two frames: the tip's path in free flight converges to one curve."""
    times = np.linspace(0.0, 0.3, 31)
    differences = []
    for modes in (1, 2, 4):
        common = (*SMALL, "discretization.kinetics=full", f"discretization.modes={modes}")
        a = run("paper", *common)
        b = run("paper", *common, "discretization.frame=mean-axis")
        differences.append(np.abs(tip(a, times) - tip(b, times)).max())
    assert differences[0] > 3.0 * differences[1] > 6.0 * differences[2]
    assert differences[2] < 1e-6


@pytest.mark.slow
def test_mean_axis_first_order_and_full_agree_on_the_second_macro_collision(run):
    """Theory Sec. 3: about 5e-4 s in the time of the second macro-collision."""
    common = ("discretization.frame=mean-axis", "discretization.modes=6")
    first_order = run("paper", *common)
    full = run("paper", *common, "discretization.kinetics=full")
    starts = [h.summary["macro_collisions"][1]["start"] for h in (first_order, full)]
    assert abs(starts[0] - starts[1]) < 5e-4
    ends = [h.summary["macro_collisions"][0]["end"] for h in (first_order, full)]
    assert abs(ends[0] - ends[1]) < 2e-5


def test_first_order_and_full_differ_at_the_order_of_the_deflection_squared(run):
    """The neglected terms are at least of second order in the relative deflection: halving it shows the order."""
    times = np.linspace(0.0, 0.3, 31)
    differences, deflections = [], []
    for stiffness in (68.952e8, 68.952e9):
        common = (*SMALL, f"beam.youngs_modulus={stiffness}")
        first_order, full = run("paper", *common), run("paper", *common, "discretization.kinetics=full")
        differences.append(np.abs(tip(first_order, times) - tip(full, times)).max())
        deflections.append(np.abs(first_order["deflection"]).max().item())
    assert differences[1] < deflections[1] ** 2
    assert differences[0] / differences[1] > (deflections[0] / deflections[1]) ** 1.8


def test_zeroth_order_leaves_the_foreshortening_out(run):
    history = run("paper", *SMALL, "discretization.kinetics=zeroth-order")
    assert np.all(history["shortening"] == 0.0)
    assert np.all(history["ux"] == 0.0)


@pytest.mark.parametrize("kinetics", ["first-order", "full"])
@pytest.mark.parametrize("frame", ["tangent", "mean-axis"])
@pytest.mark.parametrize("method", ["modal", "fem"])
def test_free_flight_conserves_energy(run, kinetics, frame, method):
    history = run(
        "paper",
        "contact.enabled=false",
        "initial.angular_velocity=-20.0",
        f"discretization.kinetics={kinetics}",
        f"discretization.frame={frame}",
        f"discretization.method={method}",
        "discretization.modes=3",
    )
    total = history["energy_kinetic"] + history["energy_elastic"] + history["energy_gravity"]
    scale = float(history["energy_kinetic"].max())
    assert float(history["energy_elastic"].max()) > 1e-6 * scale  # the beam does bend
    assert float(np.abs(total - total[0]).max()) < 1e-10 * scale


def test_frames_of_a_hub_agree():
    """A torque-driven hub in all modes of one mesh: both frames span the same nodal space, full kinetics.

    What is left is the second-order difference of the two descriptions of one deflection.
    """
    from oblique_impact import Scenario, simulate

    base = Scenario.builtin(
        "paper",
        [
            "root.kind=hub",
            "root.inertia=2.0",
            "root.torque=30.0",
            "contact.enabled=false",
            "gravity=0.0",
            "end_time=0.1",
            "discretization.method=fem",
            "discretization.elements=4",
            "discretization.modes=8",
            "discretization.kinetics=full",
        ],
    )
    times = np.linspace(0.0, 0.1, 11)
    differences = []
    for torque in (30.0, 3.0):
        tips = [tip(simulate(base.replace(root__torque=torque, discretization__frame=f)), times) for f in FRAMES]
        differences.append(np.abs(tips[0] - tips[1]).max())
    assert differences[0] < 1e-5
    assert differences[1] < 0.02 * differences[0]

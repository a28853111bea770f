"""Time integration of the beam converges to the event-located answer."""

from __future__ import annotations

import numpy as np
import pytest

FRICTIONLESS = ("contact.friction=frictionless", "end_time=0.335")


def event_times(history):
    return np.array([e.time for e in history.events])


def test_event_times_do_not_depend_on_the_tolerance(run):
    coarse = run("paper", "end_time=0.335", "solver.tolerance=1e-8")
    fine = run("paper", "end_time=0.335", "solver.tolerance=1e-12")
    assert np.abs(event_times(coarse) - event_times(fine)).max() < 1e-8
    default = run("paper", "end_time=0.335")
    assert np.abs(event_times(default) - event_times(fine)).max() < 1e-10


@pytest.mark.slow
def test_fixed_step_converges_to_the_located_events(run):
    """Contact is noticed a random part of a free step late, so errors stay below a multiple of the step."""
    exact = event_times(run("paper", *FRICTIONLESS))
    for free_step in (1e-5, 1e-6, 1e-7):
        steps = (f"solver.free_step={free_step}", f"solver.contact_step={free_step / 10}")
        history = run("paper", *FRICTIONLESS, "solver.scheme=fixed-step", *steps)
        assert [e.kind.value for e in history.events[:3]] == ["impact", "release", "impact"]
        assert np.abs(event_times(history)[:3] - exact[:3]).max() < 8.0 * free_step


def test_fixed_step_is_of_fourth_order_in_free_flight(run):
    common = ("contact.enabled=false", "end_time=0.1", "initial.angular_velocity=-15.0")
    exact = run("paper", *common, "solver.tolerance=1e-13")
    errors = []
    for step in (1e-4, 5e-5, 2.5e-5):
        history = run("paper", *common, "solver.scheme=fixed-step", f"solver.free_step={step}")
        errors.append(np.abs(history["q"].values[-1] - exact["q"].values[-1]).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all((orders > 3.8) & (orders < 4.3))
    assert errors[-1] < 1e-8


@pytest.mark.parametrize("form", ["squared", "plain"])
def test_both_readings_of_baumgartes_parameters_run(run, form):
    history = run("paper", "solver.scheme=fixed-step", f"solver.baumgarte_form={form}", "end_time=0.335")
    closed = history["state"].values != 0
    deepest = float(history["gap"].values[closed].min())
    assert -4e-4 < deepest < 0.0  # up to one free step of penetration
    # Z'' + 20 Z' + 1e6 Z = 0 turns the penetration around within pi/1000 s; Z'' + 10 Z' + 1000 Z = 0 does not
    last = float(history["gap"].values[closed][20:].max())
    assert (last > 1e-5) == (form == "squared")

"""Steps of time-stepping in flight: as long as their error allows, and never into an obstacle."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.beam_problem import beam_of, beam_problem
from oblique_impact.history.history import History
from oblique_impact.marching.loop import Run

#: four elements in all nodes, and all of their modes, which the event scheme takes
NODES = "discretization.method=fem discretization.elements=4 discretization.modes=0 contact.point_inertia=kept"
MODES = "discretization.method=fem discretization.elements=4 discretization.modes=8 discretization.frame=mean-axis"
#: the beam swings on its pin with a vibration of its first modes, which it has because it starts straight
SWING = "contact.friction=frictionless initial.angle=0.7 initial.angular_velocity=-2 beam.kelvin_voigt=1e-4"
FAR = "slope.origin=[0,-5] end_time=0.25"
ALONE = "slope.enabled=false contact.where=anywhere"
UP = f"{ALONE} contact.grid=4"


def run(model: str, *keys: str, scheme: str = "time-stepping") -> History:
    """Run a hinged beam."""
    words = " ".join([SWING, model, *keys]).split()
    return simulate(Scenario.builtin("paper", [*words, f"solver.scheme={scheme}"]))


@cache
def located(*keys: str) -> History:
    """The same motion by located events."""
    return run(MODES, *keys, "solver.tolerance=1e-12", scheme="event")


def steps_of(scenario: Scenario) -> int:
    """Return the number of steps of a run."""
    return int(Run(beam_problem(beam_of(scenario))).execute().steps)


def apart(found: History, wanted: History, name: str = "theta") -> float:
    """Largest difference of a variable at all samples, which are the same."""
    assert found["time"].values == pytest.approx(wanted["time"].values, abs=1e-12)
    return float(np.abs(found[name].values - wanted[name].values).max())


# --- errors of a flight


def test_a_swing_is_that_of_the_event_scheme_to_second_order_at_every_sample():
    """Between the ends of long steps too, where angles, velocities and accelerations are interpolated."""
    wanted = located(FAR)
    for name, largest in (("theta", 2e-5), ("theta_dot", 5e-3), ("tip_vy", 2e-2)):
        coarse, fine = (
            apart(run(NODES, FAR, f"solver.free_step={step}"), wanted, name) for step in (1e-4, 2.5e-5)
        )
        assert coarse < largest
        assert fine < coarse / 8.0, name


def test_the_energy_of_a_swing_is_kept_to_second_order():
    left = [
        abs(run(NODES, FAR, f"solver.free_step={step}").summary["energy"]["unaccounted"])
        for step in (1e-4, 2.5e-5)
    ]
    assert left[0] < 1e-5  # of some 2 J
    assert left[1] < left[0] / 8.0


def test_the_given_step_is_the_shortest_one_in_flight():
    """A rigid swing takes steps up to 64 times as long; the vibrations of a start with a jerk at first do not."""
    scenario = Scenario.builtin("paper", [*" ".join([SWING, NODES, FAR]).split(), "solver.scheme=time-stepping"])
    for step in (1e-4, 2.5e-5):
        taken = steps_of(scenario.replace(solver__free_step=step))
        assert taken < 0.5 * scenario.end_time / step
        assert taken >= scenario.end_time / (64.0 * step)


def test_a_driven_root_keeps_the_given_step():
    keys = "root.kind=driven root.profile=spin-up root.spin_rate=-3 root.spin_up_time=0.1 end_time=0.05"
    words = " ".join([NODES, "slope.origin=[0,-5] contact.friction=frictionless", keys]).split()
    scenario = Scenario.builtin("paper", [*words, "solver.scheme=time-stepping", "solver.free_step=1e-4"])
    assert steps_of(scenario) == 500


# --- no contact inside of a step is missed


def first_touch(history: History) -> float:
    """Time of the first contact (s), infinite if there is none."""
    return min((contact.start for contact in history.contacts), default=np.inf)


@pytest.mark.parametrize("deeper", [2e-4, -2e-4])
def test_a_tip_grazes_a_ceiling_where_it_turns_or_stays_clear_of_it(deeper):
    """It comes within 0.2 mm at no speed, with steps that would carry it far beyond."""
    rising = "initial.angle=0.2 initial.angular_velocity=3 end_time=0.3"
    free = located("slope.origin=[0,-5]", rising)
    top = float(np.sin(free["theta"].values).max())
    ceiling = f"obstacles=[{{kind='side',origin=[0,{top - deeper}],angle='180deg'}}]"
    steps = "solver.free_step=1e-4", "solver.contact_step=2e-5"
    found, wanted = first_touch(run(NODES, UP, rising, ceiling, *steps)), first_touch(located(UP, rising, ceiling))
    assert np.isfinite(found) == np.isfinite(wanted) == (deeper > 0.0)
    if deeper > 0.0:
        assert found == pytest.approx(wanted, abs=2e-4)


@pytest.mark.parametrize(
    ("scene", "start", "between", "late"),
    [
        # at 30 rad/s a step of 64 times 0.1 ms would sweep 11 degrees; the peg is on the way
        ((ALONE, "obstacles=[{kind='point',origin=[0.6,-0.35],radius=0.002}]"), (0.0, -30.0), (0.01, 0.03), 1e-6),
        # past the end there is no gap: steps are as long as the end is far
        ((UP, "obstacles=[{kind='side',origin=[0,0.2],extent=[0.7,1.5]}]"), (1.2, -20.0), (0.02, 0.06), 2e-6),
    ],
    ids=["peg", "end of a side"],
)
def test_an_obstacle_is_met_within_what_would_have_been_one_long_step(scene, start, between, late):
    angle, speed = start
    keys = f"initial.angle={angle} initial.angular_velocity={speed} end_time={between[1]}"
    steps = "solver.free_step=1e-4", "solver.contact_step=1e-5"
    found, wanted = first_touch(run(NODES, *scene, keys, *steps)), first_touch(located(*scene, keys))
    assert between[0] < wanted < between[1]
    assert found == pytest.approx(wanted, abs=late)


def test_a_base_that_is_shaken_does_not_bring_an_obstacle_inside_of_a_step():
    """A beam almost without weight is at rest, in steps as long as can be, until the base is jerked away."""
    keys = "initial.angle=0 initial.angular_velocity=0 gravity=0.01 end_time=0.12"
    base = "base.table=[[0,0],[0.05,0],[0.052,-200],[0.06,-200],[0.062,0]] base.direction=-1.5707963267948966"
    table = "obstacles=[{kind='side',origin=[0,-0.02]},{kind='side',origin=[0,0.02],angle='180deg'}]"
    steps = "solver.free_step=1e-4", "solver.contact_step=1e-5"
    found, wanted = (
        first_touch(h) for h in (run(NODES, UP, keys, base, table, *steps), located(UP, keys, base, table))
    )
    assert 0.05 < wanted < 0.12
    assert found == pytest.approx(wanted, abs=2e-6)


def test_a_step_that_does_not_resolve_the_first_vibration_is_kept():
    words = " ".join([NODES, FAR, "contact.friction=frictionless"]).split()
    scenario = Scenario.builtin("paper", [*words, "solver.scheme=time-stepping"]).replace(end_time=0.1)
    assert steps_of(scenario.replace(solver__free_step=2e-4)) == 500

"""A straight beam at rest on the slope with friction: its tip slips towards the root as the beam begins to bend.

The rows of the contact are parallel there, and the tip has no acceleration along the slope.  The distance of pin
and tip falls with the fourth power of time, because a bent beam of constant length has a shorter chord.
"""

import math

import pytest

from oblique_impact import Outcome, Scenario, simulate
from oblique_impact.contact.state import State

#: the angle of the beam to the slope, its own angle, friction, frame, method, modes, scheme
STARTS = [
    (-0.2, -0.1, 0.8, "mean-axis", "modal", 2, "event"),
    (-0.7, 1.0, 0.1, "mean-axis", "modal", 8, "event"),
    (0.0, 0.2, 0.05, "mean-axis", "fem", 12, "event"),  # along the slope: no tangential row at all
    (0.0, 0.2, 0.05, "mean-axis", "modal", 3, "event"),
    (-1e-3, 0.0, 0.05, "mean-axis", "fem", 16, "fixed-step"),
    (-1.5, -0.1, 0.06, "mean-axis", "fem", 3, "event"),  # steep: outwards it would be a Painleve configuration
    (0.8, 0.785, 0.1, "tangent", "fem", 3, "event"),  # the pin behind the slope
    (-1e-3, 0.2, 0.1, "mean-axis", "fem", 16, "event"),
]


def resting(angle_to_slope, angle, mu, frame, method, modes, scheme, end_time=0.014, **changes):
    """Return the paper's beam with its tip on the slope."""
    return Scenario.builtin("paper").replace(
        initial__angle=angle,
        slope__angle=angle - angle_to_slope,
        slope__origin=[math.cos(angle), math.sin(angle)],
        contact__mu_static=mu,
        contact__mu_kinetic=mu,
        discretization__frame=frame,
        discretization__method=method,
        discretization__modes=modes,
        solver__scheme=scheme,
        end_time=end_time,
        **({} if scheme == "event" else {"solver__contact_step": 2e-6}),
        **changes,
    )


@pytest.mark.parametrize("start", STARTS)
def test_a_tip_at_rest_slips_towards_the_root_until_the_beam_swings_back(start):
    history = simulate(resting(*start))
    assert history.outcome is Outcome.COMPLETED
    first, then = history.events[:2]
    assert first.time == 0.0
    assert first.state is State.SLIP
    slip = history["slip"].values
    assert 0.0 > slip[-1] - slip[0] > -1e-4
    # the nodal model turns at 0.01275 s (32 and 64 elements, steps of 1e-6 s)
    assert then.kind.value in ("reversal", "stick")
    assert then.time == pytest.approx(0.01275, rel=0.01)


def test_a_tip_at_rest_that_jams_is_named():
    """mu tan(beta) > 1 with the pin behind the slope: friction holds whatever the load, no force is consistent."""
    assert simulate(resting(1.2, 0.0, 0.5, "mean-axis", "modal", 4, "event")).outcome is Outcome.PAINLEVE


def test_a_beam_at_rest_that_nothing_presses_on_the_slope_flies():
    history = simulate(resting(-0.2, 0.3, 0.3, "mean-axis", "modal", 4, "event", end_time=0.01, gravity=0.0))
    assert history.outcome is Outcome.COMPLETED
    assert not history.events


def test_fixed_steps_take_no_rounding_for_a_reversal():
    """A steep beam on a hub: in its first step the tip slips by less than what rounding makes of its speed."""
    start = (-1.5, 0.785398, 0.5, "tangent", "fem", 2, "fixed-step")
    on_hub = {"root__kind": "hub", "root__hub_radius": 0.3, "root__inertia": 0.1}
    origin = {"slope__origin": [1.3 * math.cos(start[1]), 1.3 * math.sin(start[1])]}
    scenario = resting(*start, end_time=2e-3).replace(**on_hub, **origin, solver__contact_step=1e-6)
    history = simulate(scenario)
    assert history.outcome is Outcome.COMPLETED
    assert [e.kind.value for e in history.events] == ["impact"]

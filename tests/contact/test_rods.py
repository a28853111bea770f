"""Impacts and sliding of rigid rods with friction (Painleve, Routh), beyond the checks "small-systems"."""

from __future__ import annotations

from math import atan, cos, pi, radians, sin, sqrt, tan

import numpy as np
import pytest

from oblique_impact import History, Outcome, simulate_system
from oblique_impact.contact.forces import NO_SLIDING_SOLUTION, OK, Forces, sliding_force
from oblique_impact.contact.friction import Branch, Coulomb
from oblique_impact.contact.impacts import routh_impulse
from oblique_impact.contact.state import Instant, Phase, State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.marching.scheme import Scheme
from oblique_impact.validation.reference_values import VALUES
from oblique_impact.validation.small_systems import FreeRod, samples_at

SLOPE = pi / 10
PHI = VALUES["4"]["theta_f"] - SLOPE  # between the bar and the slope at touch

# --- item 6d: the Painleve rod -----------------------------------------------------------------------------


def sliding_rod(angle: float, slip: float = -1.0, spin: float = 0.0) -> Instant:
    """A rod (m = l = 1) under gravity whose end slides on the ground."""
    rod = FreeRod(gravity=9.8)
    return rod.instant(rod.at(angle), rod.moving(angle, (slip, 0.0), spin))


def sliding(instant: Instant, ratio: float) -> Forces:
    """Force of a sliding contact, lambda_tau = ratio lambda_n."""
    return sliding_force(Phase(int(State.SLIP), friction=Branch(ratio, 0.0, -np.inf, np.inf)), instant)


def slide_rod(
    mu: float, angle: float, slip: float, spin: float, height: float = 0.0, scheme: Scheme | None = None
) -> History:
    """Run that rod for half a second."""
    rod = FreeRod(gravity=9.8)
    start = rod.at(angle, height), rod.moving(angle, (slip, 0.0), spin)
    return simulate_system(rod, *start, 0.5, friction=Coulomb(mu, mu), scheme=scheme)


def test_effective_inverse_mass_of_the_painleve_rod():
    angles = np.radians(np.arange(5.0, 90.0, 5.0))
    for mu in (0.0, 0.5, 1.5):
        for angle in angles:
            instant = sliding_rod(angle)
            computed = instant.a_nn + mu * instant.a_nt  # slides towards -x: lambda_tau = +mu lambda_n
            expected = 1.0 + 3.0 * cos(angle) * (cos(angle) - mu * sin(angle))
            assert computed == pytest.approx(expected, abs=1e-14)
    at = sliding_rod(atan(2.0))
    assert at.a_nn + 1.5 * at.a_nt == pytest.approx(VALUES["6d"]["mp_at_atan2"], abs=1e-14)


def test_the_paradox_begins_at_the_critical_friction():
    critical = radians(VALUES["6d"]["theta_crit_deg"])
    inside, outside = (VALUES["6d"]["mu_crit"] * factor for factor in (1.0 + 1e-10, 1.0 - 1e-10))
    assert sliding(sliding_rod(critical), inside).status == NO_SLIDING_SOLUTION
    assert sliding(sliding_rod(critical), outside).status == OK


@pytest.mark.parametrize(("edge", "inwards"), [(0, 1.0), (1, -1.0)])
def test_the_sliding_contact_has_no_solution_in_the_paradox_interval(edge, inwards):
    angle = VALUES["6d"]["interval_rad"][edge]
    assert angle == pytest.approx(radians(VALUES["6d"]["interval_deg"][edge]), abs=1e-12)
    assert sliding(sliding_rod(angle + 1e-11 * inwards), 1.5).status == NO_SLIDING_SOLUTION
    assert sliding(sliding_rod(angle - 1e-11 * inwards), 1.5).normal > 0.0
    # sliding the other way it is an ordinary contact
    assert sliding(sliding_rod(angle + 1e-11 * inwards, slip=1.0), -1.5).normal > 0.0


def test_a_rod_that_lands_in_the_paradox_interval_ends_the_run():
    history = slide_rod(1.5, radians(60.0), -1.0, 0.0, height=0.01)
    assert history.outcome is Outcome.PAINLEVE
    assert [event.kind for event in history.events] == [EventKind.IMPACT]
    assert history.events[0].time == pytest.approx(sqrt(2.0 * 0.01 / 9.8), rel=1e-10)


@pytest.mark.parametrize("spin", [0.3, 1.0, 2.0])
def test_a_rod_slides_into_the_paradox_only_above_a_second_critical_friction(spin):
    """Genot and Brogliato (1999): below mu = 8/(3 sqrt 3) it lifts off first, above it reaches the edge.

    Near the edge, with p the effective inverse mass and b the gap acceleration without force,
    d b/d theta = A b/(theta - edge) and A = 1 at that friction; checked in the last lines.
    """
    second = 8.0 / (3.0 * sqrt(3.0))
    below = slide_rod(1.5, radians(45.0), -20.0, spin)
    assert below.events[1].kind is EventKind.RELEASE
    released, _ = samples_at(below, below.events[1].time)
    assert released[2] < VALUES["6d"]["interval_rad"][0]
    above = slide_rod(1.6, radians(45.0), -20.0, spin)
    edge = atan((3.0 * 1.6 - sqrt(9.0 * 1.6**2 - 16.0)) / 2.0)
    assert above.outcome is Outcome.PAINLEVE
    # the run ends where the effective inverse mass has fallen to 1e-9 of its frictionless value
    assert above["q"].values[-1, 2] == pytest.approx(edge, abs=1e-8)
    for mu, sign in ((1.5, 1.0), (second, 0.0), (1.6, -1.0)):
        x = atan((3.0 * mu - sqrt(9.0 * mu**2 - 16.0)) / 2.0)
        growth = 6.0 * sin(x) * (mu * sin(x) - cos(x)) / (3.0 * (sin(2.0 * x) + mu * cos(2.0 * x)))
        assert np.sign(round(growth - 1.0, 9)) == sign


# --- item 6f: frictional impact of a free rod --------------------------------------------------------------


@pytest.mark.parametrize("degrees", [45.0, 60.0])
def test_the_end_sticks_from_a_threshold_of_friction_on(degrees):
    """Item 6f: once stopped it sticks iff mu >= 3 s c/(1 + 3 s^2); else it slides back."""
    s, c = sin(radians(degrees)), cos(radians(degrees))
    threshold = 3.0 * s * c / (1.0 + 3.0 * s * s)
    rod = FreeRod()
    instant = rod.instant(rod.at(radians(degrees)), rod.moving(radians(degrees), (0.1, -1.0)))
    for mu, sticks in ((threshold * 1.001, True), (threshold * 0.999, False)):
        impulse = routh_impulse(instant, 0.0, mu)
        slip_after = 0.1 + instant.a_nt * impulse.normal + instant.a_tt * impulse.tangential
        assert (abs(slip_after) < 1e-12) == sticks


# --- items 4 and 6i: a rigid pinned bar ---------------------------------------------------------------------


def pinned_instant(phi: float, spin: float, inertia: float = 0.7, length: float = 1.3) -> Instant:
    """A bar at `phi` to the slope it hits: the rows D_n = L cos(phi) and D_tau = -L sin(phi)."""
    normal, tangential = length * cos(phi), -length * sin(phi)
    return Instant(
        gap=0.0,
        slip=0.0,
        gap_rate=normal * spin,
        slip_rate=tangential * spin,
        a_nn=normal**2 / inertia,
        a_nt=normal * tangential / inertia,
        a_tt=tangential**2 / inertia,
        gap_acceleration=-1.0,
        slip_acceleration=0.0,
    )


def test_elastic_impacts_of_pinned_bars():
    """Item 6i's formula, e_kinetic = e (cos - mu |sin|)/(cos + mu |sin|), for other bars.

    Slip and gap rate of a bar vanish together, so slip turns exactly at the end of compression.
    """
    restitution, angles, frictions = 0.5, np.radians([-60.0, -30.0, -10.0, 10.0, 20.0, 40.0, 70.0]), (0.1, 0.3)
    computed, expected = [], []
    for phi in angles:
        for mu in frictions:
            instant = pinned_instant(phi, -2.0)
            impulse = routh_impulse(instant, restitution, mu)
            after = instant.gap_rate + instant.a_nn * impulse.normal + instant.a_nt * impulse.tangential
            computed.append(after / -instant.gap_rate)
            expected.append(restitution * (1.0 - mu * abs(tan(phi))) / (1.0 + mu * abs(tan(phi))))
    np.testing.assert_allclose(computed, expected, rtol=1e-12)


def test_the_pinned_bar_jams_at_high_friction():
    """Item 6d: a bar that slides off the slope is held by it from mu = cot|phi| on."""
    jam = VALUES["6d"]["jam_mu"]
    assert jam == pytest.approx(1.0 / tan(abs(PHI)), rel=1e-11)
    leaving = pinned_instant(PHI, 1.0)
    assert leaving.slip_rate > 0.0
    assert sliding(leaving, -jam * (1.0 + 1e-10)).status == NO_SLIDING_SOLUTION
    assert sliding(leaving, -jam * (1.0 - 1e-10)).normal > 0.0

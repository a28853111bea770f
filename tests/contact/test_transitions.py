"""The transition table: hand-made contact problems with known answers, and small systems run through it."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from oblique_impact import Outcome, simulate_system
from oblique_impact.contact.forces import (
    NO_STICKING_SOLUTION,
    can_stick,
    holding_force,
    sliding_force,
    with_forces,
)
from oblique_impact.contact.friction import Branch, Coulomb
from oblique_impact.contact.impacts import NewtonImpact
from oblique_impact.contact.state import (
    LOWER,
    SWITCHED,
    UPPER,
    Baumgarte,
    Instant,
    Phase,
    State,
    Stick,
    Tolerances,
)
from oblique_impact.contact.transitions import ContactMachine, EventKind, StickCriterion
from oblique_impact.errors import RunEnded
from oblique_impact.marching import loop
from tests.systems import Block

TOLERANCES = Tolerances(gap=1e-12, force=1e-9, velocity=1e-11, time=1.0, energy=1.0)


class Probe:
    """A contact problem with a constant Delassus matrix."""

    def __init__(self, **values):
        rest = {"a_nn": 1.0, "a_nt": 0.0, "a_tt": 1.0, "gap_acceleration": -9.8, "slip_acceleration": 0.0}
        motion = {"gap": 0.0, "slip": 0.0, "gap_rate": 0.0, "slip_rate": 0.0}
        self.instant = Instant(**{**motion, **rest, **values})

    def slip_rate_ahead(self):
        return 0.0

    def after(self, impulse):
        i = self.instant
        return i._replace(
            gap_rate=i.gap_rate + i.a_nn * impulse.normal + i.a_nt * impulse.tangential,
            slip_rate=i.slip_rate + i.a_nt * impulse.normal + i.a_tt * impulse.tangential,
        )


def machine(friction=None, impact=None, criterion=None):
    law = Coulomb(0.3, 0.3) if friction is None else friction
    return ContactMachine(law, impact or NewtonImpact(), TOLERANCES, Baumgarte(20.0, 1e6), criterion)


def slides(phase, direction, mu):
    return (
        phase.state == State.SLIP
        and phase.friction.intercept == -direction * mu
        and (phase.friction.lower, phase.friction.upper)
        == ((0.0, math.inf) if direction > 0 else (-math.inf, 0.0))
    )


OPEN = Phase()
SLIP_UP = Phase(int(State.SLIP), friction=Branch(-0.3, 0.0, 0.0, math.inf), stick=Stick(0.3))
SLIP_DOWN = Phase(int(State.SLIP), friction=Branch(0.3, 0.0, -math.inf, 0.0), stick=Stick(0.3))
STICK = Phase(int(State.STICK), stick=Stick(0.3))


# FREE -> ---------------------------------------------------------------------------------------------------


def test_the_direction_of_slip_is_that_after_the_impact():
    # a_nt P = -1.5 * 3 turns the slip round
    probe = Probe(gap_rate=-3.0, slip_rate=2.0, a_nn=2.0, a_nt=-1.0, a_tt=2.0)
    transition = machine().touch(probe)
    assert slides(transition.phase, 1, 0.3)
    probe = Probe(gap_rate=-3.0, slip_rate=1.0, a_nn=2.0, a_nt=-1.0, a_tt=2.0)
    assert slides(machine().touch(probe).phase, -1, 0.3)


def test_rebound_when_the_force_would_pull():
    probe = Probe(gap_rate=-3.0, slip_rate=1.0, gap_acceleration=5.0)
    transition = machine().touch(probe)
    assert (transition.kind, transition.phase.state) == (EventKind.REBOUND, State.FREE)
    assert transition.impulse.normal == 3.0


def test_bounces_that_accumulate_close_the_contact():
    """The last bounce worth a flight rises to four gap tolerances; below, restitution is given up."""
    lowest = math.sqrt(2.0 * 9.8 * 4.0 * TOLERANCES.gap) / 0.5
    above = machine(impact=NewtonImpact(0.5)).touch(Probe(gap_rate=-1.001 * lowest, slip_rate=1.0))
    assert above.kind is EventKind.REBOUND
    below = machine(impact=NewtonImpact(0.5)).touch(Probe(gap_rate=-0.999 * lowest, slip_rate=1.0))
    assert below.kind is EventKind.IMPACT
    assert below.impulse.normal == pytest.approx(0.999 * lowest, rel=1e-12)
    assert slides(below.phase, 1, 0.3)


@pytest.mark.parametrize("rate", [0.0, -5e-12, 5e-12])
def test_grazing_without_an_impulse(rate):
    closing = machine().touch(Probe(gap_rate=rate, slip_rate=1.0))
    assert closing.kind is EventKind.IMPACT
    assert closing.impulse is None
    assert slides(closing.phase, 1, 0.3)
    opening = machine().touch(Probe(gap_rate=rate, slip_rate=1.0, gap_acceleration=1.0))
    assert (opening.kind, opening.phase.state, opening.impulse) == (None, State.FREE, None)


# contact -> -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("phase", "guard"), [(SLIP_UP, LOWER), (SLIP_DOWN, UPPER)])
@pytest.mark.parametrize(("drive", "direction"), [(0.0, 0), (2.9, 0), (-2.9, 0), (3.0, 1), (-3.0, -1)])
def test_zero_slip_sticks_inside_the_cone_and_reverses_outside(phase, guard, drive, direction):
    """mu N = 2.94: what drives the contact must be beyond it to go on."""
    probe = Probe(slip=0.7, slip_rate=1e-9, slip_acceleration=drive)
    transition = machine().after_guard(phase, guard, probe)
    if direction == 0:
        assert (transition.kind, transition.phase.state) == (EventKind.STICK, State.STICK)
        assert transition.phase.stick[:2] == (0.3, 0.7)
    else:
        assert transition.kind is EventKind.REVERSAL
        assert slides(transition.phase, direction, 0.3)


def test_zero_slip_where_the_sticking_force_pulls_is_a_release():
    """A cone is meaningless at lambda_n <= 0: neither stick nor reversal, the contact opens."""
    for gap_acceleration in (1e-14, 1.0):
        for drive in (0.0, 2.0, -2.0):
            probe = Probe(gap_acceleration=gap_acceleration, slip_acceleration=drive)
            transition = machine().after_guard(SLIP_UP, LOWER, probe)
            assert (transition.kind, transition.phase.state) == (EventKind.RELEASE, State.FREE)


# What has no answer -----------------------------------------------------------------------------------------

PAINLEVE = {"a_nn": 1.0, "a_nt": 4.0, "a_tt": 20.0, "slip_rate": 1.0}  # 1 - 0.3 * 4 < 0


def test_impact_into_a_painleve_configuration_keeps_the_impulse():
    transition = machine().touch(Probe(**PAINLEVE, gap_rate=-2.0))
    assert transition.kind is EventKind.IMPACT
    assert transition.impulse.normal == 2.0
    assert transition.failure is Outcome.PAINLEVE


def one_freedom(normal, tangential, force, gap_bias, slip_bias, **motion):
    """A contact problem of a system with a single coordinate: both rows are parallel."""
    return Probe(
        a_nn=normal**2,
        a_nt=normal * tangential,
        a_tt=tangential**2,
        gap_acceleration=normal * force + gap_bias,
        slip_acceleration=tangential * force + slip_bias,
        **motion,
    )


@pytest.mark.parametrize("slip_bias", [0.7, -0.7])
def test_redundant_constraints_turn_as_the_motion_dictates(slip_bias):
    """One coordinate held by the gap: no friction force can stop the slip acceleration of the biases."""
    probe = one_freedom(2.0, 0.5, -3.0, 0.4, slip_bias)
    assert holding_force(OPEN, probe.instant, 0.0).status == NO_STICKING_SOLUTION
    # q'' = -gap_bias / normal, so the slip accelerates by tangential q'' + slip_bias
    expected = np.sign(-0.4 / 2.0 * 0.5 + slip_bias)
    assert slides(machine().closed(probe.instant), expected, 0.3)


def test_redundant_constraints_at_rest_are_named():
    with pytest.raises(RunEnded) as stop:
        machine().closed(one_freedom(1.0, 0.0, -3.0, 0.0, 0.0).instant)
    assert stop.value.outcome is Outcome.REDUNDANT_CONSTRAINTS


# Stick and slip told apart once per step -----------------------------------------------------------------------

LITERAL = StickCriterion(math.inf)


def test_the_papers_criterion_sticks_at_any_slip_rate():
    table = machine(criterion=LITERAL)
    assert table.closed(Probe(slip_rate=0.5).instant).state == State.STICK
    assert slides(table.closed(Probe(slip_rate=0.5, slip_acceleration=-4.0).instant), 1, 0.3)
    for pull in (0.3 * 9.8, -0.3 * 9.8):  # the edge of the cone: the slip itself asks for no force
        held = table.closed(Probe(slip_rate=0.5, slip_acceleration=0.999 * pull).instant)
        assert held.state == State.STICK
        assert slides(table.closed(Probe(slip_rate=0.5, slip_acceleration=1.001 * pull).instant), 1, 0.3)
    switched = table.after_guard(SLIP_UP, SWITCHED, Probe(slip_rate=0.5))
    assert (switched.kind, switched.phase.state, switched.arrest) == (EventKind.STICK, State.STICK, None)
    left = table.after_guard(STICK, SWITCHED, Probe(slip_rate=-1e-4, slip_acceleration=4.0))
    assert left.kind is EventKind.SLIP
    assert slides(left.phase, -1, 0.3)


def test_slip_sticks_that_friction_can_stop_within_a_step():
    """mu N h = 0.3 * 9.8 * 0.01 s: slip below 0.0294 m/s is stopped, without a change of the gap's rate."""
    criterion = StickCriterion(0.01)
    table = machine(criterion=criterion)
    for slip_rate, sticks in ((0.0293, True), (0.0295, False), (-0.0293, True)):  # the last has turned already
        probe = Probe(slip_rate=slip_rate, a_nt=0.0)
        force = sliding_force(SLIP_UP, probe.instant)
        sliding = with_forces(probe.instant, force.normal, force.tangential, 0.0)
        assert can_stick(SLIP_UP, sliding, criterion.stopping_time) == sticks
        assert slides(table.closed(probe.instant), 1 if slip_rate > 0.0 else -1, 0.3)
    probe = Probe(slip_rate=0.02, a_nt=0.5)
    switched = table.after_guard(SLIP_UP, SWITCHED, probe)
    assert (switched.kind, switched.phase.state) == (EventKind.STICK, State.STICK)
    after = probe.after(switched.arrest)
    assert after.slip_rate == pytest.approx(0.0, abs=1e-16)
    assert after.gap_rate == pytest.approx(0.0, abs=1e-16)
    # 1/2 v^2 times the effective mass a_nn / (a_nn a_tt - a_nt^2)
    assert switched.arrest.energy_loss == pytest.approx(0.5 * 0.02**2 / 0.75, rel=1e-12)


@pytest.mark.parametrize("criterion", [LITERAL, StickCriterion(0.01)])
def test_contact_below_the_slope_is_pushed_out_by_a_scheme_that_does_not_locate(criterion):
    """Baumgarte's spring counts: -1e-5 m times 1e6 1/s^2 outweighs a pull of 5 m/s^2."""
    below = Probe(gap=-1e-5, gap_acceleration=5.0, slip_rate=1.0).instant
    assert slides(machine(criterion=criterion).closed(below), 1, 0.3)
    assert machine().closed(below).state == State.FREE


# Whole runs ---------------------------------------------------------------------------------------------------


def log(history):
    return [(event.kind.value, event.state.name) for event in history.events]


def test_chattering_is_bounded_and_named(monkeypatch):
    """A drive that always pushes against the slip, beyond the cone: no state persists."""
    monkeypatch.setattr(loop, "MAX_EVENTS", 300)  # so that a failure takes no minutes
    block = Block(lambda t, q, qd: (-20.0 if qd[0] >= 0.0 else 20.0, -9.8))
    history = simulate_system(block, [0.0, 0.0], [1.0, 0.0], 1.0, friction=Coulomb(0.5, 0.5))
    assert history.outcome is Outcome.CHATTERING
    # x'' = -20 - 0.5 * 9.8 up to the standstill
    assert history.summary["end_time"] == pytest.approx(1.0 / 24.9, abs=1e-8)
    assert len(history.events) < 200


@pytest.mark.parametrize("dip", [0.3, 1e-2, 1e-3])
def test_a_force_that_dips_below_zero_is_a_short_flight(dip):
    """lambda_n = 1 - dip + cos 2 pi t is negative for a moment around t = 0.5 only."""
    w = 2.0 * math.pi
    block = Block(lambda t, q, qd: (0.0, dip - 1.0 - math.cos(w * t)))
    history = simulate_system(block, [0.0, 0.0], [0.0, 0.0], 1.0, output_interval=0.05)
    release = math.acos(dip - 1.0) / w

    def height(t):
        s = t - release
        falling = math.cos(w * t) - math.cos(w * release) + w * s * math.sin(w * release)
        return 0.5 * (dip - 1.0) * s**2 + falling / w**2

    landing = brentq(height, 0.5 + 1.01 * (0.5 - release), 1.0, xtol=1e-15)
    assert log(history) == [("impact", "SLIP"), ("release", "FREE"), ("impact", "SLIP")]
    times = [event.time for event in history.events]
    assert times[1] == pytest.approx(release, abs=1e-10)
    assert times[2] == pytest.approx(landing, abs=1e-8)
    assert float(history["gap"].min()) > -1e-12

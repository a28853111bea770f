"""Restitution of several contacts, Newton's in Moreau's form, by hand: bars on posts, balls in a row.

0 <= P _|_ v+ + e v- >= 0 with the Delassus matrix W of all closed contacts, v+ = v- + W P.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest

from oblique_impact import MechanicalSystem, Outcome, simulate_system
from oblique_impact.contact.decision import Decision
from oblique_impact.contact.friction import Frictionless
from oblique_impact.contact.impacts import NewtonImpact, RouthImpact
from oblique_impact.contact.pairs import ContactPair
from oblique_impact.contact.state import Tolerances
from oblique_impact.contact.transitions import EventKind
from oblique_impact.errors import InputError
from oblique_impact.marching.event import EventScheme
from oblique_impact.marching.loop import Run
from oblique_impact.marching.problem import Problem
from oblique_impact.marching.records import Record
from oblique_impact.marching.time_stepping import TimeSteppingScheme

GRAVITY = 9.8  # m/s^2
STEP = 2e-4  # s, of time-stepping


class Linear(MechanicalSystem):
    """M q'' = f with several frictionless contacts of the gaps G q."""

    def __init__(self, masses, gaps, force):
        self.masses, self.gaps, self.force = (np.array(part, dtype=float) for part in (masses, gaps, force))
        self.size = len(self.masses)

    def mass_matrix(self, t, q):
        return np.diag(self.masses)

    def forces(self, t, q, qd):
        return self.force

    def contact(self, t, q, qd):
        raise NotImplementedError

    def touch(self, i, t, q, qd, w, c, rows):
        row = self.gaps[i]
        rows[0], rows[1] = row, 0.0
        c.gap, c.gap_rate, c.slip, c.slip_rate = float(row @ q), float(row @ qd), 0.0, 0.0
        c.gap_bias = c.slip_bias = 0.0

    def measure(self, t, q, qd, w, contacts):
        for i in range(len(self.gaps)):
            self.touch(i, t, q, qd, w, contacts.each[i], np.empty((2, self.size)))

    def energy(self, t, q, qd):
        return 0.5 * float(self.masses @ qd**2), 0.0, -float(self.force @ q)

    @property
    def delassus(self):
        return self.gaps / self.masses @ self.gaps.T


class Marched(NamedTuple):
    """A run: its record, and coordinates, velocities and energies at its samples."""

    record: Record
    times: np.ndarray
    q: np.ndarray
    qd: np.ndarray
    energy: np.ndarray

    def impulsive(self, contact: int) -> list:
        kinds = EventKind.IMPACT, EventKind.REBOUND
        return [e for e in self.record.events if e.obstacle == contact and e.kind in kinds]


def march(system, q0, qd0, end, restitution, scheme="event", step=STEP) -> Marched:
    """Run a system whose lengths are metres and whose times are seconds."""
    marching = EventScheme(1e-10)
    if scheme == "time-stepping":
        marching = TimeSteppingScheme(step, step, 1.0, 1e-12)
    laws = Frictionless(), NewtonImpact(restitution), Tolerances.of(1.0, 1.0, 1.0)
    pairs = [ContactPair(obstacle=i) for i in range(len(system.gaps))]
    q0, qd0 = np.array(q0, dtype=float), np.array(qd0, dtype=float)
    decision = Decision(pairs, *laws, stick_criterion=marching.stick_criterion)
    record = Run(Problem(system, q0, qd0, decision, marching, end, end / 100.0, np.ones(2 * q0.size))).execute()
    assert record.outcome is Outcome.COMPLETED
    times = np.concatenate([segment.times for segment in record.segments])
    states = np.concatenate([segment.states for segment in record.segments])
    q, qd = states[:, : q0.size], states[:, q0.size : 2 * q0.size]
    energy = np.array([sum(system.energy(0.0, *at)) for at in zip(q, qd, strict=True)])
    return Marched(record, times, q, qd, energy)


def bar(inertia: float, weight: float = 0.0) -> Linear:
    """A bar of 1 kg with contacts at its ends 1 m from its centre; q = (height, angle)."""
    return Linear([1.0, inertia], [[1.0, 1.0], [1.0, -1.0]], [-weight, 0.0])


SCHEMES = pytest.mark.parametrize("scheme", ["event", "time-stepping"])


def near(scheme: str, size: float, event: float = 1e-9):
    """Tolerance of the event scheme, or of the first order of the step."""
    return event if scheme == "event" else 5.0 * GRAVITY * STEP * size


@SCHEMES
@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("inertia", [0.3, 3.0])
def test_a_bar_that_lands_flat_leaves_as_flat(inertia, restitution, scheme):
    """Both ends at 2 m/s, whatever their coupling: P = m v (1 + e)/2 on each, 1 - e^2 of the energy is lost."""
    found = march(bar(inertia), [0.2, 0.0], [-2.0, 0.0], 0.15, restitution, scheme)
    for contact in (0, 1):
        (impact,) = found.impulsive(contact)
        assert impact.normal_velocity == pytest.approx(-2.0, rel=1e-12)
        assert impact.normal_impulse == pytest.approx(1.0 + restitution, rel=1e-9)
        assert impact.energy_loss == pytest.approx(1.0 - restitution**2, abs=1e-9)
    assert found.qd[-1] == pytest.approx([2.0 * restitution, 0.0], abs=1e-9)


PRESS = 0.1  # N


@SCHEMES
@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("inertia", [0.3, 3.0], ids=["held", "opened"])
def test_an_end_of_a_bar_that_rests_as_the_other_one_is_struck(inertia, restitution, scheme):
    """W = [[1/m + a^2/J, 1/m - a^2/J], ...]: with J < m a^2 the blow on one end drives the other one down.

    Then W P = (1 + e) (v, 0) and v+ = (e v, 0); else P = (1 + e) (v, 0)/W_11 and the resting end leaves with
    (1 + e) v W_12/W_11.  It is pressed by 0.1 N, and the other one comes down without an acceleration.
    """
    system, speed, end = bar(inertia), 1.5, 0.1
    W = system.delassus
    free = -PRESS * W[:, 1]
    system.force = system.masses * np.linalg.solve(system.gaps, free)
    found = march(system, [0.05, 0.05], [-0.5 * speed, -0.5 * speed], end, restitution, scheme)
    (struck,) = found.impulsive(0)
    time = 0.1 / speed
    assert struck.time == pytest.approx(time, abs=near(scheme, 0.3))
    assert struck.normal_velocity == pytest.approx(-speed, rel=1e-9)
    wanted = np.linalg.solve(W, [(1.0 + restitution) * speed, 0.0])
    holds = wanted[1] > 0.0
    assert holds == (inertia < 1.0)
    if not holds:
        wanted = np.array([(1.0 + restitution) * speed / W[0, 0], 0.0])
    assert struck.normal_impulse == pytest.approx(wanted[0], abs=near(scheme, 0.1))
    lost = 0.5 * (1.0 - restitution) * speed * wanted[0]
    assert struck.energy_loss == pytest.approx(lost, abs=near(scheme, 0.2))
    resting = sum(c.normal_impulse for c in found.record.contacts if c.obstacle == 1)
    assert resting == pytest.approx(wanted[1] + PRESS * (end if holds else time), abs=near(scheme, 0.1, 1e-8))
    after = W @ wanted - [speed, 0.0]
    if not holds:  # both fly on, but for a plastic impact, after which the struck end presses
        pressed = PRESS * W[0, 1] / W[0, 0] if restitution == 0.0 else 0.0
        after += (end - time) * (free + pressed * W[0])
    assert system.gaps @ found.qd[-1] == pytest.approx(after, abs=near(scheme, 0.1))


@SCHEMES
@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_three_balls_in_a_row(restitution, scheme):
    """One strikes two that touch: W = [[2, -1], [-1, 2]]/m gives P = (1 + e) (2, 1) m v/3.

    At once, as in Moreau's form, and not one after the other: the last two leave together, with a third of
    (1 + e) v each, and at e = 1 the first one comes back.
    """
    row = Linear([1.0] * 3, [[-1.0, 1.0, 0.0], [0.0, -1.0, 1.0]], [0.0, 1e-3, -1e-3])
    found = march(row, [-0.1, 0.0, 0.0], [1.0, 0.0, 0.0], 0.15, restitution, scheme)
    third = (1.0 + restitution) / 3.0
    assert found.qd[-1] == pytest.approx([1.0 - 2.0 * third, third, third], abs=near(scheme, 0.1, 1e-3))
    struck = next(e for e in found.impulsive(0))
    assert struck.normal_impulse == pytest.approx(2.0 * third, abs=near(scheme, 0.1, 1e-3))


@SCHEMES
def test_the_ends_of_a_bar_bounce_until_both_rest(scheme):
    """With J = m a^2 the ends are two bouncing balls: that from h rests after sqrt(2 h/g) (1 + 2 e/(1 - e))."""
    system, restitution, heights = bar(1.0, GRAVITY), 0.5, np.array([0.3, 0.2])
    rest = np.sqrt(2.0 * heights / GRAVITY) * (1.0 + 2.0 * restitution / (1.0 - restitution))
    q0 = np.linalg.solve(system.gaps, heights)
    found = march(system, q0, [0.0, 0.0], 0.8, restitution, scheme)
    for contact, time in enumerate(rest):
        closed = found.impulsive(contact)
        assert closed[-1].time == pytest.approx(time, abs=near(scheme, 0.5, 1e-5))
        assert len(closed) < 40
    assert found.energy[0] - found.energy[-1] == pytest.approx(GRAVITY * heights.mean(), rel=1e-9)
    assert sum(c.energy_loss for c in found.record.contacts) == pytest.approx(GRAVITY * heights.mean(), rel=1e-9)
    assert min(c.energy_loss for c in found.record.contacts) >= -1e-12
    assert system.gaps @ found.q[-1] == pytest.approx([0.0, 0.0], abs=1e-9)


@SCHEMES
@pytest.mark.parametrize("inertia", [0.1, 3.0])
def test_impacts_that_open_each_other_end(inertia, scheme):
    """A bar rocks from end to end, each of its impacts driving or lifting the other end, until it lies still."""
    system = bar(inertia, GRAVITY)
    found = march(system, [0.1, 0.08], [0.0, 0.0], 1.5, 0.4, scheme)
    assert len(found.record.events) < 400
    assert system.gaps @ found.q[-1] == pytest.approx([0.0, 0.0], abs=1e-8)
    assert found.qd[-1] == pytest.approx([0.0, 0.0], abs=1e-8)
    lost = sum(c.energy_loss for c in found.record.contacts)
    assert lost == pytest.approx(0.1 * GRAVITY, rel=1e-8)
    assert np.diff(found.energy).max() < (1e-9 if scheme == "event" else 1e-3)


def test_an_elastic_bar_keeps_its_energy():
    """At e = 1, where impacts are located; steps lose a little, of the first order, and gain nothing."""
    system = bar(0.4, GRAVITY)
    located = march(system, [0.3, 0.05], [0.0, 0.4], 2.0, 1.0)
    assert len(located.record.events) > 10
    assert located.energy == pytest.approx(located.energy[0], rel=1e-9)
    lost = []
    for step in (4e-4, 2e-4, 1e-4, 5e-5):
        stepped = march(system, [0.3, 0.05], [0.0, 0.4], 0.6, 1.0, "time-stepping", step)
        lost.append(stepped.energy[0] - stepped.energy[-1])
    assert min(lost) >= 0.0
    assert lost[-1] < 0.01 * located.energy[0]


@pytest.mark.parametrize("inertia", [0.02, 0.05])
@pytest.mark.parametrize("restitution", [0.5, 0.9])
def test_ends_that_strike_one_step_after_another_gain_nothing(restitution, inertia):
    """With W_12 near -W_11 the blow on one end drives the other one in, which has just left.

    Newton's law alone would give up to nine times the energy there.
    """
    system = bar(inertia)
    for heights in ([0.1, 0.01], [0.5, 0.6], [0.9, 0.3]):
        for leaving in (0.3, 0.6, 0.9):
            q0 = np.linalg.solve(system.gaps, np.multiply(STEP, heights))
            qd0 = np.linalg.solve(system.gaps, [-1.0, leaving])
            found = march(system, q0, qd0, 20.0 * STEP, restitution, "time-stepping")
            assert found.energy[-1] < found.energy[0]
            lost = sum(c.energy_loss for c in found.record.contacts)
            assert lost == pytest.approx(found.energy[0] - found.energy[-1], rel=1e-9)


def bounces(restitution: float, step: float) -> tuple[np.ndarray, float]:
    """Return heights of a ball of 1 kg after its first bounces, over what they should be, and when it rests."""
    ball = Linear([1.0], [[1.0]], [-GRAVITY])
    found = march(ball, [0.2], [0.0], 1.0, restitution, "time-stepping", step)
    struck = [e.time for e in found.impulsive(0)]
    # energy between two impacts, which is that of the top
    tops = [found.energy[np.searchsorted(found.times, 0.5 * (a + b))] for a, b in pairwise(struck)]
    return np.array(tops[:2]) / (GRAVITY * 0.2 * restitution ** np.array([2.0, 4.0])), struck[-1]


def test_a_ball_bounces_lower_by_the_square_of_the_restitution():
    """To first order of the step: heights, and the end of all bounces after sqrt(2 h/g) (1 + 2 e/(1 - e))."""
    restitution, fall = 0.6, np.sqrt(0.4 / GRAVITY)
    rest = fall * (1.0 + 2.0 * restitution / (1.0 - restitution))
    for step in (1e-3, 1e-4):
        heights, end = bounces(restitution, step)
        assert heights == pytest.approx(np.ones(2), abs=10.0 * step * GRAVITY / (GRAVITY * fall))
        assert end == pytest.approx(rest, abs=40.0 * step)


def test_time_stepping_knows_no_other_law_of_impacts():
    ball, start = Linear([1.0], [[1.0]], [-GRAVITY]), (np.array([0.2]), np.zeros(1))
    scheme = TimeSteppingScheme(STEP, STEP, 1.0, 1e-12)
    with pytest.raises(InputError, match="impact_law: should be a NewtonImpact"):
        simulate_system(ball, *start, 0.1, scheme=scheme, impact_law=RouthImpact(0.3))

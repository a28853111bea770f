"""The hybrid algorithm as a state machine: which contact state follows, and which event that is.

One table for every discretization, scheme and system (paper Secs. 4-6).  Transitions are ordinary
Python; they see the contact problem at an :class:`~oblique_impact.contact.forces.Instant` and answer with
the next phase, an event, and an impulse where there is one.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple, Protocol

from oblique_impact.contact.forces import (
    GUARD_DEFINITE,
    GUARD_NORMAL,
    GUARD_UPPER,
    Impulse,
    Instant,
    Phase,
    State,
    newton_impulse,
    routh_impulse,
)
from oblique_impact.contact.friction import FrictionLaw
from oblique_impact.contact.stops import Stop
from oblique_impact.errors import Outcome, PhysicsStop
from oblique_impact.marching.fixed_step import GUARD_JUDGED
from oblique_impact.marching.scheme import Tolerances


class EventKind(Enum):
    """What happened; the values are those of the column `kind` in events.csv."""

    IMPACT = "impact"
    REBOUND = "rebound"
    RELEASE = "release"
    STICK = "stick"
    SLIP = "slip"
    REVERSAL = "reversal"

    @property
    def impulsive(self) -> bool:
        """Whether velocities jump: what the event's row holds happened at its instant."""
        return self in (EventKind.IMPACT, EventKind.REBOUND)


class Transition(NamedTuple):
    """The next phase, the event to record (None: a kink of the friction law) and the impulse applied.

    `stop` names the reason why no contact state exists after the impulse; the run ends there.
    """

    phase: Phase
    kind: EventKind | None
    impulse: Impulse | None = None
    stop: Outcome | None = None


class ContactProbe(Protocol):
    """The contact problem at the front of a run, and what an impulse would make of it."""

    @property
    def instant(self) -> Instant:
        """The contact problem as it is."""

    def after(self, impulse: Impulse) -> Instant:
        """Return the contact problem with the velocities that `impulse` leaves."""


class ImpactLaw(ABC):
    """What happens to the velocities when the gap closes."""

    restitution: float

    def check(self, end_time: float) -> None:  # noqa: B027  most laws have nothing to check
        """Raise InputError if this is no law; called before a run of a law of one's own."""

    @abstractmethod
    def impulse(self, instant: Instant, restitution: float) -> Impulse:
        """Impulse for the approach velocities at `instant` with the given restitution."""


@dataclass(frozen=True)
class NewtonImpact(ImpactLaw):
    """The paper's impulse-momentum method: frictionless, Newton's restitution."""

    restitution: float = 0.0

    def impulse(self, instant: Instant, restitution: float) -> Impulse:  # noqa: D102
        return newton_impulse(instant, restitution)


@dataclass(frozen=True)
class RouthImpact(ImpactLaw):
    """Frictional impact after Routh with Poisson's restitution; raises PhysicsStop where it jams."""

    friction: float
    restitution: float = 0.0

    def impulse(self, instant: Instant, restitution: float) -> Impulse:  # noqa: D102
        try:
            return routh_impulse(instant, restitution, self.friction)
        except ValueError:
            raise PhysicsStop(Outcome.PAINLEVE) from None


class Baumgarte(NamedTuple):
    """Coefficients of Z'' + damping Z' + stiffness Z = 0 (1/s, 1/s^2)."""

    damping: float
    stiffness: float

    @classmethod
    def from_parameters(cls, chi: float, beta: float, form: str) -> Baumgarte:
        """Read the paper's parameters as 2 chi and beta^2 ("squared") or as they stand ("plain")."""
        return cls(2.0 * chi, beta**2) if form == "squared" else cls(chi, beta)


class ContactMachine:
    """The transition table for one friction law and one impact law.

    Parameters
    ----------
    friction, impact : FrictionLaw, ImpactLaw
        The laws of the contact.
    baumgarte : Baumgarte
        Stabilization of the contact constraints.
    tolerances : Tolerances
        What counts as zero.
    stepwise : bool
        Judge stick and slip as a fixed-step scheme does, without asking for a vanishing slip velocity.
    stop : Stop, optional
        A stop that gives way; then contact begins and ends without an impulse. Default: a rigid one.
    """

    def __init__(
        self,
        friction: FrictionLaw,
        impact: ImpactLaw,
        baumgarte: Baumgarte = Baumgarte(0.0, 0.0),
        tolerances: Tolerances = Tolerances(),
        stepwise: bool = False,
        stop: Stop | None = None,
    ) -> None:
        self.friction, self.impact = friction, impact
        self.tolerances = tolerances
        self._stepwise, self.stop = stepwise, stop
        self._closed_phase = (stop.phase if stop else Phase())._replace(
            static=-1.0 if friction.static is None else friction.static,
            damping=baumgarte.damping,
            stiffness=baumgarte.stiffness,
        )

    def free(self) -> Phase:
        """Return the phase of free flight."""
        return Phase(state=int(State.FREE))

    def start(self, probe: ContactProbe) -> Transition:
        """State at the start of a run, which may touch the slope or already press on it."""
        instant, tolerances = probe.instant, self.tolerances
        if instant.gap > tolerances.gap or instant.gap_rate > tolerances.velocity:
            return Transition(self.free(), None)
        return self.touch(probe)

    def after_guard(self, phase: Phase, guard: int, probe: ContactProbe) -> Transition:
        """State after `guard` of `phase` fell; raises PhysicsStop where none exists."""
        if guard == GUARD_DEFINITE:
            raise PhysicsStop(Outcome.PAINLEVE)
        if phase.state == State.FREE:
            return self.touch(probe)
        if guard == GUARD_NORMAL:
            return Transition(self.free(), EventKind.RELEASE)
        instant = probe.instant
        if phase.state == State.STICK:
            return self._leave_stick(guard, instant)
        if guard == GUARD_JUDGED:
            return Transition(self._stick(instant), EventKind.STICK)
        kink = phase.upper if guard == GUARD_UPPER else phase.lower
        if self.friction.static is None or self._stepwise or kink != 0.0:
            return self._next_branch(phase, guard, instant)
        return self._at_zero_slip(instant)

    def touch(self, probe: ContactProbe) -> Transition:
        """Impact of a closing contact, or a grazing contact that closes without one."""
        if self.stop is not None:
            return Transition(self._on_elastic_stop(probe.instant), EventKind.IMPACT)
        if probe.instant.gap_rate >= -self.tolerances.velocity:
            phase = self.closed(probe.instant)
            return Transition(phase, None if phase.state == State.FREE else EventKind.IMPACT)
        restitution = self.impact.restitution
        impulse = self.impact.impulse(probe.instant, restitution)
        after = probe.after(impulse)
        if restitution > 0.0 and self._bounces_accumulate(after):
            impulse = self.impact.impulse(probe.instant, 0.0)
            after = probe.after(impulse)
        if after.gap_rate > self.tolerances.velocity:
            return Transition(self.free(), EventKind.REBOUND, impulse)
        try:
            phase = self.closed(after)
        except PhysicsStop as stop:
            sliding = self._slide(after.slip_rate, 1 if after.slip_rate >= 0.0 else -1)
            return Transition(sliding, EventKind.IMPACT, impulse, stop.outcome)
        kind = EventKind.REBOUND if phase.state == State.FREE else EventKind.IMPACT
        return Transition(phase, kind, impulse)

    def _bounces_accumulate(self, after: Instant) -> bool:
        """Whether the bounces still to come end before the next one could be told apart.

        With a gap acceleration -a the bounces rise to v^2 / (2 a), e^2 as high each time: a Zeno sequence.
        """
        if after.gap_acceleration >= 0.0:
            return False
        flight = 2.0 * after.gap_rate / -after.gap_acceleration
        height = 0.25 * flight * after.gap_rate
        return height < 4.0 * self.tolerances.gap or flight < self.tolerances.flight

    def closed(self, instant: Instant) -> Phase:
        """State of a contact with zero gap and zero gap rate.

        Raises PhysicsStop (Painleve, redundant constraints) where no state exists.
        """
        if self.stop is not None:
            return self._on_elastic_stop(instant)
        if self._stepwise:
            return self._closed_stepwise(instant)
        static = self.friction.static
        if static is None or abs(instant.slip_rate) > self.tolerances.velocity:
            return self._slide_or_free(instant, 1 if instant.slip_rate >= 0.0 else -1)
        resting = instant._replace(slip_rate=0.0)
        forces = instant.sticking()
        if forces is None:
            return self._slide_or_free(resting, self._turning_direction(resting))
        if abs(forces[1]) <= static * forces[0]:
            return self._stick(instant)
        return self._slide_or_free(resting, -1 if forces[1] > 0.0 else 1)

    def _on_elastic_stop(self, instant: Instant) -> Phase:
        """Stick or slip on an elastic stop, whose normal force the state does not change."""
        assert self.stop is not None
        static, rate = self.friction.static, instant.slip_rate
        moving = abs(rate) > self.tolerances.velocity and not self._stepwise
        if static is None or moving or not instant.a_tt > 0.0:
            return self._slide(rate, 1 if rate >= 0.0 else -1)
        normal = self.stop.force(instant)
        tangential = -(instant.slip_acceleration + instant.a_nt * normal) / instant.a_tt
        if abs(tangential) <= static * normal:
            return self._stick(instant)
        if self._stepwise:
            return self._slide(rate, 1 if rate >= 0.0 else -1)
        return self._slide(0.0, -1 if tangential > 0.0 else 1)

    def _closed_stepwise(self, instant: Instant) -> Phase:
        static, forces = self.friction.static, instant.sticking()
        if static is not None and forces and forces[0] > 0.0 and abs(forces[1]) <= static * forces[0]:
            return self._stick(instant)
        return self._slide_or_free(instant, 1 if instant.slip_rate >= 0.0 else -1)

    def _turning_direction(self, instant: Instant) -> int:
        """Direction of slip where the tangential row adds nothing to the normal one.

        No tangential force can hold such a contact, nor move it: its slip turns as the motion along the
        slope dictates, whatever the friction.
        """
        normal = -instant.gap_acceleration / instant.a_nn
        acceleration = instant.slip_acceleration + instant.a_nt * normal
        if acceleration == 0.0:
            raise PhysicsStop(Outcome.REDUNDANT_CONSTRAINTS)
        return 1 if acceleration > 0.0 else -1

    def _slide_or_free(self, instant: Instant, direction: int) -> Phase:
        phase = self._slide(instant.slip_rate, direction)
        if self.stop is not None:
            return phase
        force = instant.sliding(phase.intercept + phase.slope * instant.slip_rate)
        if force is None:
            raise PhysicsStop(Outcome.PAINLEVE)
        if self._stepwise:  # a contact noticed below the slope is pushed out by its stabilization
            force = max(force, self._stabilized_force(phase, instant))
        return phase if force > 0.0 else self.free()

    def _stabilized_force(self, phase: Phase, instant: Instant) -> float:
        pull = phase.damping * instant.gap_rate + phase.stiffness * instant.gap
        corrected = instant._replace(gap_acceleration=instant.gap_acceleration + pull)
        return corrected.sliding(phase.intercept + phase.slope * instant.slip_rate) or 0.0

    def _slide(self, slip_rate: float, direction: int) -> Phase:
        branch = self.friction.branch(slip_rate, direction)
        return self._closed_phase._replace(
            state=int(State.SLIP),
            intercept=branch.intercept,
            slope=branch.slope,
            lower=branch.lower,
            upper=branch.upper,
        )

    def _stick(self, instant: Instant) -> Phase:
        return self._closed_phase._replace(state=int(State.STICK), slip_reference=instant.slip)

    def _leave_stick(self, guard: int, instant: Instant) -> Transition:
        if self._stepwise:
            direction = 1 if instant.slip_rate >= 0.0 else -1
            return Transition(self._slide(instant.slip_rate, direction), EventKind.SLIP)
        # guard LOWER: lambda_tau reached +static lambda_n, so the contact gives way backwards
        direction = 1 if guard == GUARD_UPPER else -1
        following = self._slide_or_free(instant._replace(slip_rate=0.0), direction)
        return Transition(following, _kind(following, EventKind.SLIP))

    def _next_branch(self, phase: Phase, guard: int, instant: Instant) -> Transition:
        upward = guard == GUARD_UPPER
        # a located kink is where the slip velocity is, up to rounding that could fall on either side of it
        kink = instant.slip_rate if self._stepwise else (phase.upper if upward else phase.lower)
        following = self._slide(kink, 1 if upward else -1)
        reversed_ = _side(phase) * _side(following) < 0
        return Transition(following, EventKind.REVERSAL if reversed_ else None)

    def _at_zero_slip(self, instant: Instant) -> Transition:
        following = self.closed(instant._replace(slip_rate=0.0))
        if following.state == State.STICK:
            return Transition(following, EventKind.STICK)
        return Transition(following, _kind(following, EventKind.REVERSAL))


def _kind(phase: Phase, kind: EventKind) -> EventKind:
    return EventKind.RELEASE if phase.state == State.FREE else kind


def _side(phase: Phase) -> int:
    """Direction of slip on a branch: +1, -1, or 0 for a branch on both sides of zero."""
    return int(phase.lower >= 0.0) - int(phase.upper <= 0.0)

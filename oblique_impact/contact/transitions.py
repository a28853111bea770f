"""The hybrid algorithm as a state machine: which contact state follows, and which event that is.

One table for every discretization, scheme and system (paper Secs. 4-6).  Transitions are ordinary
Python; they see the contact problem at an :class:`~oblique_impact.contact.state.Instant` and answer with
the next phase, an event, and an impulse where there is one.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from math import inf
from typing import NamedTuple, Protocol

from oblique_impact.contact.forces import (
    OK,
    can_slide,
    holding_force,
    inclined,
    sliding_force,
    sliding_inertia,
    slip_velocity,
    sticking_force,
)
from oblique_impact.contact.friction import Branch, FrictionLaw
from oblique_impact.contact.impacts import ImpactLaw, Impulse, impulse_of
from oblique_impact.contact.state import (
    DEFINITE,
    END,
    LOWER,
    NORMAL,
    SWITCHED,
    UPPER,
    Baumgarte,
    Instant,
    Phase,
    Residual,
    State,
    Stick,
    Stop,
    Surface,
    Tolerances,
)
from oblique_impact.contact.stops import ContactLaw
from oblique_impact.errors import Outcome, RunEnded

#: squared sine between the contact rows (in the metric of the inverse mass matrix) below which they count as
#: parallel: a stick force of such rows would be larger than any friction cone, and known to no digit
_PARALLEL = 1e-11
#: a tangential row whose square is below 1e-11 times this part of the normal one's is rounding (1e-24 of 1,024
#: elements that lie along the slope)
_NO_ROW = 1e-9


class EventKind(Enum):
    """Kind of an event; the values are those of the column `kind` in events.csv."""

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


class AtEnd(Enum):
    """Passages of the contact point at an end of the slope; the values are those in summary.json."""

    SLIDES_OFF = "slides off"
    FALLS_PAST = "falls past"
    COMES_BACK = "comes back"


class Transition(NamedTuple):
    """The next phase, the event to record and the impulses that change the velocities.

    Without an event it is a kink of the friction law, or the contact point crosses the line of the slope beyond
    its ends.

    `impulse` is that of an impact.  `stick_projection` is the impulse of friction that ends the slip within a
    step; it is booked with the finite forces.  `failure` names the reason why no contact state exists after the
    impulse; the run ends there.
    """

    phase: Phase
    kind: EventKind | None
    impulse: Impulse | None = None
    stick_projection: Impulse | None = None
    failure: Outcome | None = None
    at_end: AtEnd | None = None


class Earlier(NamedTuple):
    """A contact that was closed where an earlier run has ended, and goes on from there."""

    state: int
    normal_force: float  # N
    tangential_force: float
    began: float  # m, slip at which it began
    residual: Residual  # of the contact point there


class ContactProbe(Protocol):
    """The contact problem at the present state of a run, before and after an impulse."""

    @property
    def instant(self) -> Instant:
        """The contact problem at the present state."""

    @property
    def residual(self) -> Residual:
        """Residual flexibility of the contact point."""

    def after(self, impulse: Impulse) -> Instant:
        """Return the contact problem with the velocities that `impulse` leaves."""

    def slip_rate_ahead(self) -> float:
        """Slip velocity (m/s) a little later, if the contact stays closed; 0 if it is rounding."""


class StickCriterion(NamedTuple):
    """Criterion by which a scheme itself distinguishes stick from slip; see `can_stick`."""

    stopping_time: float  # s; the length of a step, or infinite for the paper's literal criterion
    located: bool = False  # transitions are located, and their guards say what follows

    @property
    def projects(self) -> bool:
        """Whether the slip velocity is set to zero when stick is detected."""
        return self.stopping_time < inf


class ContactMachine:
    """The transition table for one friction law, one impact law and one kind of stop.

    Parameters
    ----------
    friction, impact_law : FrictionLaw, ImpactLaw
        Tangential law, and law of impacts on a rigid stop.
    tolerances : Tolerances
        What counts as zero.
    baumgarte : Baumgarte
        Stabilization of the contact constraints.
    stick_criterion : StickCriterion, optional
        Of a scheme that distinguishes stick from slip itself.  Default: transitions are located, the table does.
    contact_law : ContactLaw, optional
        Law of a compliant stop; then contact begins and ends without an impulse.  Default: a rigid stop.
    extent : tuple of float
        Ends of the slope, [first, last] in m along it; empty without ends.
    rolls : bool
        Whether a point of an obstacle touches the beam, see `Stick`; else a point of the beam a side.
    axial : callable, optional
        Axial flexibility (m/N) behind the friction of a contact that begins at a slip (m), and the sense of its
        tangent, see `Stick`.  The stop is then rigid, or an :class:`~oblique_impact.contact.stops.ElasticStop`
        without damping, the friction is Coulomb's, and impacts have none.
    """

    def __init__(
        self,
        friction: FrictionLaw,
        impact_law: ImpactLaw,
        tolerances: Tolerances,
        baumgarte: Baumgarte = Baumgarte(),
        stick_criterion: StickCriterion | None = None,
        contact_law: ContactLaw | None = None,
        extent: tuple[float, ...] = (),
        rolls: bool = False,
        axial: Callable[[float], tuple[float, float]] | None = None,
    ) -> None:
        self.friction, self.impact_law, self.contact_law = friction, impact_law, contact_law
        self.tolerances, self.axial = tolerances, axial
        #: number of decisions so far that had several solutions, of which an opening contact was taken
        self.ambiguous = 0
        self.stick_criterion = stick_criterion
        #: of a scheme that notices transitions late, at the ends of its steps
        self._late = None if stick_criterion is None or stick_criterion.located else stick_criterion
        self._open = Phase()
        self.extent = extent
        self._first, self._last = (float(end) for end in extent) if extent else (-inf, inf)
        self.closed_phase = Phase(
            stop=contact_law.stop if contact_law else Stop(),
            stick=Stick(-1.0 if friction.static is None else float(friction.static), held=float(not rolls)),
            stabilization=Baumgarte(*map(float, baumgarte)),
            surface=Surface(first=self._first, last=self._last),
        )

    def free(self) -> Phase:
        """Return the phase of free flight above the slope."""
        return self._open

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the slope (m along it), infinite where it has none."""
        return self._first, self._last

    def below(self) -> Phase:
        """Return the phase of flight below the line of the slope, beyond its ends."""
        return self._open._replace(surface=Surface(side=-1.0))

    def is_beyond(self, slip: float) -> bool:
        """Whether a place (m along the slope) is beyond its ends."""
        return slip < self._first or slip > self._last

    def start(self, probe: ContactProbe, earlier: Earlier | None = None) -> Transition:
        """Return the state at the start of a run, which may touch the slope, press on it or go on from another."""
        instant, tolerances = probe.instant, self.tolerances
        if earlier is not None:
            return Transition(self.resumed(earlier, instant), EventKind.IMPACT)
        if instant.gap < -tolerances.gap and self.is_beyond(instant.slip):
            return Transition(self.below(), None)
        return Transition(self.free(), None) if self.is_apart(instant) else self.touch(probe)

    def resumed(self, earlier: Earlier, instant: Instant) -> Phase:
        """Return the state of a contact that goes on from an earlier run, its axial flexibility stretched."""
        opened = self.opened(earlier.began)._replace(residual=Residual(*map(float, earlier.residual)))
        instant = inclined(opened, instant)
        if earlier.state == State.STICK:
            at = instant.slip + opened.stick.compliance * earlier.tangential_force
            return stick_at(opened, instant._replace(slip=at))
        # with axial flexibility friction sees another velocity than that of the slip
        rate = 0.0 if self.axial is not None else instant.slip_rate
        return self.slide(opened, rate, -1 if earlier.tangential_force > 0.0 else 1)

    def is_apart(self, instant: Instant) -> bool:
        """Whether nothing touches at the start of a run; a stop that is pressed in still pushes as it opens."""
        pressed = self.contact_law is not None and instant.gap < -self.tolerances.gap
        return instant.gap > self.tolerances.gap or (instant.gap_rate > self.tolerances.velocity and not pressed)

    def after_guard(self, phase: Phase, guard: int, probe: ContactProbe) -> Transition:
        """Return the transition after `guard` of `phase` fell; raises RunEnded where no state exists."""
        if guard == DEFINITE:
            raise RunEnded(Outcome.PAINLEVE)
        if phase.state == State.FREE:
            if phase.surface.side < 0.0:
                return Transition(self.free(), None, at_end=AtEnd.COMES_BACK)
            return self.touch(probe)
        if guard == NORMAL:
            return Transition(self.free(), EventKind.RELEASE)
        instant = probe.instant
        if guard == END:
            # a fixed step may leave it a little above the line
            following = self.free() if instant.gap > self.tolerances.gap else self.below()
            return Transition(following, EventKind.RELEASE, at_end=AtEnd.SLIDES_OFF)
        if self.axial is not None:
            return self._turn_axially(phase, guard, instant)
        if phase.state == State.STICK:
            return self._leave_stick(phase, guard, instant)
        if guard == SWITCHED:
            return self._project_on_stick(phase, instant)
        kink = phase.friction.upper if guard == UPPER else phase.friction.lower
        if self.friction.static is None or self.stick_criterion or kink != 0.0:
            return self._next_branch(phase, guard, instant)
        return self._at_zero_slip(phase, probe)

    def touch(self, probe: ContactProbe) -> Transition:
        """Return the transition as the gap closes: an impact or a grazing contact; none beyond an end."""
        if self.is_beyond(probe.instant.slip):
            return Transition(self.below(), None, at_end=AtEnd.FALLS_PAST)
        if self.contact_law is not None:
            return Transition(self.pressed(probe), EventKind.IMPACT)
        if self._grazes(probe.instant):
            phase = self.closed(probe.instant, ahead=probe.slip_rate_ahead)
            return Transition(phase, None if phase.state == State.FREE else EventKind.IMPACT)
        restitution = self.impact_law.restitution
        impulse = self._impulse(probe.instant, restitution)
        after = probe.after(impulse)
        if restitution > 0.0 and self._bounces_accumulate(after):
            impulse = self._impulse(probe.instant, 0.0)
            after = probe.after(impulse)
        if after.gap_rate > self.tolerances.velocity:
            return Transition(self.free(), EventKind.REBOUND, impulse)
        try:
            phase = self.closed(after)
        except RunEnded as ended:
            sliding = self.slide(self.closed_phase, after.slip_rate, _direction(after.slip_rate))
            return Transition(sliding, EventKind.IMPACT, impulse, failure=ended.outcome)
        kind = EventKind.REBOUND if phase.state == State.FREE else EventKind.IMPACT
        return Transition(phase, kind, impulse)

    def _grazes(self, instant: Instant) -> bool:
        """Whether a gap closes without speed, or opens again a thousandth of its tolerance below 0 or before.

        A point that moves along the slope at the bottom of its circle has no lever arm that an impulse could use.
        """
        depth = 2e-3 * self.tolerances.gap * instant.gap_acceleration
        return instant.gap_rate >= -self.tolerances.velocity or instant.gap_rate**2 <= depth

    def pressed(self, probe: ContactProbe) -> Phase:
        """Return the state in which a contact on a compliant stop begins."""
        opened = self.opened(probe.instant.slip)._replace(residual=Residual(*map(float, probe.residual)))
        if self.axial is not None:
            return self._pressed_axially(opened, probe.instant)
        return self.closed(inclined(opened, probe.instant), opened)

    def opened(self, slip: float) -> Phase:
        """Return the phase of a contact that begins at a slip (m), with the axial flexibility behind it."""
        if self.axial is None:
            return self.closed_phase
        compliance, sense = self.axial(slip)
        stick = self.closed_phase.stick._replace(compliance=compliance, sense=sense)
        return self.closed_phase._replace(stick=stick)

    def _pressed_axially(self, opened: Phase, instant: Instant) -> Phase:
        """Return the state in which a contact on axial flexibility begins, where both its forces are zero.

        It sticks if the tangential force grows more slowly than the friction cone.
        """
        stuck, direction = stick_at(opened, instant), _direction(instant.slip_rate)
        edge = stuck._replace(friction=Branch(-direction * stuck.stick.static, 0.0, -inf, inf))
        # one that is found pressed in has no tangential force yet, and begins well inside of its cone
        slips = instant.gap >= -self.tolerances.gap and direction * slip_velocity(edge, instant) > 0.0
        return self.slide(stuck, instant.slip_rate, direction) if slips else stuck

    def _turn_axially(self, phase: Phase, guard: int, instant: Instant) -> Transition:
        """Return what follows stick at the edge of the cone, and the end of slip: stick, from where it ends."""
        if phase.state == State.STICK:
            following = self._slide_or_free(phase, instant._replace(slip_rate=0.0), -1 if guard == LOWER else 1)
            return Transition(following, _kind(following, EventKind.SLIP))
        at = instant.slip + phase.stick.compliance * sliding_force(phase, instant).tangential
        return Transition(stick_at(phase, instant._replace(slip=at)), EventKind.STICK)

    def _impulse(self, instant: Instant, restitution: float) -> Impulse:
        """Return the impulse of the impact law in plain numbers: a user-defined one may have others."""
        return Impulse(*map(float, self.impact_law.impulse(instant, restitution)))

    def _bounces_accumulate(self, after: Instant) -> bool:
        """Whether the remaining bounces accumulate at once: a Zeno sequence too short to resolve.

        With a gap acceleration -a the bounces rise by v^2 / (2 a), e^2 as high each time: a Zeno sequence.  One
        that does not rise above the slope, below which a fixed step has found it, is no bounce either.
        """
        if after.gap_acceleration >= 0.0:
            return False
        flight = 2.0 * after.gap_rate / -after.gap_acceleration
        height = 0.25 * flight * after.gap_rate
        lowest = max(4.0 * self.tolerances.gap, -after.gap if self._late else 0.0)
        return height < lowest or flight < self.tolerances.flight

    def closed(
        self, instant: Instant, contact: Phase | None = None, ahead: Callable[[], float] | None = None
    ) -> Phase:
        """Return the state of a contact with zero gap and gap rate, or of one on a compliant stop.

        `contact` is an earlier phase of the same contact; `ahead` is `ContactProbe.slip_rate_ahead` if the instant
        is the present one.  Raises RunEnded (Painleve, redundant constraints) where no state exists.
        """
        contact = contact or self.opened(instant.slip)
        if self.axial is not None:  # a rigid stop: the spring along the beam has no force yet
            stuck = stick_at(contact, instant)
            return stuck if sticking_force(stuck, self._unstabilized(instant)).normal > 0.0 else self.free()
        static, rate = self.friction.static, instant.slip_rate
        if static is None:
            return self._slide_or_free(contact, instant, self._direction_without_stick(instant, ahead))
        if abs(rate) > self.tolerances.velocity:
            # slip that ends within a step is found at its end, unless the force alone decides (the paper)
            if self._late is None or self._late.projects or not self._holds(contact, instant, static):
                return self._slide_or_free(contact, instant, _direction(rate))
            return stick_at(contact, instant)
        resting = instant._replace(slip_rate=0.0)
        force = holding_force(contact, self._unstabilized(resting), 0.0)
        if force.status != OK or self._redundant(resting):
            return self._slide_or_free(contact, resting, self._turning_direction(resting, ahead))
        if abs(force.tangential) <= static * force.normal:
            return stick_at(contact, instant)
        return self._slide_or_free(contact, resting, -1 if force.tangential > 0.0 else 1)

    def _holds(self, contact: Phase, instant: Instant, static: float) -> bool:
        """Whether the force that keeps a contact sticking, whatever its slip velocity, lies in the cone."""
        force = holding_force(contact, self._unstabilized(instant), 0.0)
        return force.status == OK and force.normal > 0.0 and abs(force.tangential) <= static * force.normal

    def _unstabilized(self, instant: Instant) -> Instant:
        """Return an instant at which Baumgarte's stabilization of the normal constraint does nothing."""
        return instant if self.contact_law is not None else instant._replace(gap=0.0, gap_rate=0.0)

    def _redundant(self, instant: Instant) -> bool:
        """Whether the tangential row of a rigid contact adds nothing to the normal one, but for rounding."""
        determinant = instant.a_nn * instant.a_tt - instant.a_nt * instant.a_nt
        least = _PARALLEL * instant.a_nn * (instant.a_tt + _NO_ROW * instant.a_nn)
        return self.contact_law is None and determinant <= least

    def _direction_without_stick(self, instant: Instant, ahead: Callable[[], float] | None) -> int:
        """Direction of slip of a law that always slips; of a contact at rest that in which it begins to move."""
        if abs(instant.slip_rate) > self.tolerances.velocity or not self._redundant(instant):
            return _direction(instant.slip_rate)
        return _direction(self._turning_rate(instant, ahead))

    def _turning_direction(self, instant: Instant, ahead: Callable[[], float] | None) -> int:
        """Direction of slip where the tangential row adds nothing to the normal one.

        No tangential force can hold such a contact, nor move it: its slip turns as the motion along the
        slope dictates, whatever the friction.
        """
        rate = self._turning_rate(instant, ahead)
        if rate == 0.0 and self.contact_law is None and instant.gap_acceleration < 0.0:
            raise RunEnded(Outcome.REDUNDANT_CONSTRAINTS)
        return _direction(rate)

    def _turning_rate(self, instant: Instant, ahead: Callable[[], float] | None) -> float:
        """Slip velocity (m/s) a little later, or slip acceleration (m/s^2) where that is not known; for its sign.

        The rows of a straight beam at rest are parallel, and its tip has no acceleration along the slope but for
        rounding: it slips as the beam shortens by bending, with the third power of time.
        """
        later = ahead() if ahead else 0.0
        if self.contact_law is not None:
            return instant.slip_rate or later
        normal = -instant.gap_acceleration / instant.a_nn
        return later or instant.slip_acceleration + instant.a_nt * normal

    def _slide_or_free(self, contact: Phase, instant: Instant, direction: int) -> Phase:
        phase = self.slide(contact, instant.slip_rate, direction)
        if self.contact_law is not None:
            if not can_slide(phase, instant.slip_rate):
                raise RunEnded(Outcome.PAINLEVE)
            return phase
        force = sliding_force(phase, self._unstabilized(instant))
        if force.status != OK:
            raise RunEnded(Outcome.PAINLEVE)
        if sliding_inertia(phase, instant) < 0.0 < instant.gap_acceleration:
            self.ambiguous += 1
        pushes = force.normal > 0.0
        if self._late:  # a contact noticed below the slope is pushed out by its stabilization
            pushes = pushes or sliding_force(phase, instant).normal > 0.0
        return phase if pushes else self.free()

    def slide(self, contact: Phase, slip_rate: float, direction: int) -> Phase:
        """Return the sliding state of a contact at a slip velocity (m/s), in a direction where that is 0."""
        branch = self.friction.branch(slip_rate, direction)
        return contact._replace(state=int(State.SLIP), friction=Branch(*map(float, branch)))

    def _project_on_stick(self, contact: Phase, instant: Instant) -> Transition:
        """Set the slip velocity to zero by an impulse that leaves the gap rate unchanged."""
        phase = stick_at(contact, instant)
        if self._late is None or not self._late.projects:
            return Transition(phase, EventKind.STICK)
        if self.contact_law is not None:
            stick_projection = impulse_of(instant, 0.0, -instant.slip_rate / instant.a_tt)
        else:
            per_rate = instant.slip_rate / (instant.a_nn * instant.a_tt - instant.a_nt * instant.a_nt)
            stick_projection = impulse_of(instant, instant.a_nt * per_rate, -instant.a_nn * per_rate)
        return Transition(phase, EventKind.STICK, stick_projection=stick_projection)

    def _leave_stick(self, phase: Phase, guard: int, instant: Instant) -> Transition:
        if self._late and self._late.projects:
            # the force that would hold it decides, not a slip velocity that is rounding or stabilization
            direction = -1 if holding_force(phase, instant, 0.0).tangential > 0.0 else 1
            return Transition(self.slide(phase, 0.0, direction), EventKind.SLIP)
        if self._late:
            return Transition(self.slide(phase, instant.slip_rate, _direction(instant.slip_rate)), EventKind.SLIP)
        # guard LOWER: lambda_tau reached +static lambda_n, so the contact slips backwards
        direction = 1 if guard == UPPER else -1
        following = self._slide_or_free(phase, instant._replace(slip_rate=0.0), direction)
        return Transition(following, _kind(following, EventKind.SLIP))

    def _next_branch(self, phase: Phase, guard: int, instant: Instant) -> Transition:
        upward = guard == UPPER
        # a located kink is where the slip velocity is, up to rounding that could fall on either side of it
        kink = instant.slip_rate if self._late else (phase.friction.upper if upward else phase.friction.lower)
        following = self.slide(phase, kink, 1 if upward else -1)
        reversed_ = direction_of(phase) * direction_of(following) < 0
        return Transition(following, EventKind.REVERSAL if reversed_ else None)

    def _at_zero_slip(self, contact: Phase, probe: ContactProbe) -> Transition:
        following = self.closed(probe.instant._replace(slip_rate=0.0), contact, probe.slip_rate_ahead)
        if following.state == State.STICK:
            return Transition(following, EventKind.STICK)
        return Transition(following, _kind(following, EventKind.REVERSAL))


def stick_at(contact: Phase, instant: Instant) -> Phase:
    """Return the sticking state of a contact at its present slip."""
    stick = contact.stick._replace(slip=float(instant.slip))
    return contact._replace(state=int(State.STICK), stick=stick)


def _direction(rate: float) -> int:
    return 1 if rate >= 0.0 else -1


def _kind(phase: Phase, kind: EventKind) -> EventKind:
    return EventKind.RELEASE if phase.state == State.FREE else kind


def direction_of(phase: Phase) -> int:
    """Direction of slip on a branch: +1, -1, or 0 for a branch on both sides of zero."""
    return int(phase.friction.lower >= 0.0) - int(phase.friction.upper <= 0.0)

"""The hybrid algorithm as a state machine: which contact state follows, and which event that is.

One table for every discretization, scheme and system (paper Secs. 4-6).  Transitions are ordinary Python; they see
a :class:`~oblique_impact.contact.state.Candidate` in its state with its problem at an instant, and answer with the
next state, an event, and an impulse where there is one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from math import inf
from typing import NamedTuple, Protocol

from oblique_impact.contact.forces import (
    OK,
    can_slide,
    holding_force,
    sliding_force,
    sliding_inertia,
    slip_velocity,
    sticking_force,
)
from oblique_impact.contact.friction import FrictionLaw
from oblique_impact.contact.impacts import ImpactLaw, Impulse, impulse_of
from oblique_impact.contact.state import (
    AT_AN_INSTANT,
    DEFINITE,
    END,
    LOWER,
    NORMAL,
    SWITCHED,
    UPPER,
    Baumgarte,
    Candidate,
    Residual,
    State,
    Tolerances,
)
from oblique_impact.contact.stops import ContactLaw
from oblique_impact.errors import Outcome, RunEnded
from oblique_impact.kernels.workspace import Array

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


@dataclass
class Transition:
    """What changes at an instant, by contact: states, events in their order, impulses.

    Without an event it is a kink of the friction law, or a contact point crosses the line of a side beyond its
    ends.
    """

    #: candidates with their new states
    states: dict[int, Candidate] = field(default_factory=dict)
    events: list[tuple[int, EventKind]] = field(default_factory=list)
    #: of impacts
    impulses: dict[int, Impulse] = field(default_factory=dict)
    #: impulses of friction that end the slip within a step; they are booked with the finite forces
    stick_projections: dict[int, Impulse] = field(default_factory=dict)
    passages: list[tuple[int, AtEnd]] = field(default_factory=list)
    #: why no contact state exists after the impulses; the run ends there
    failure: Outcome | None = None
    #: tangential forces (N) of contacts that go on from an earlier run
    pulls: dict[int, float] = field(default_factory=dict)

    @classmethod
    def to(
        cls, contact: int, state: Candidate, kind: EventKind | None = None, at_end: AtEnd | None = None
    ) -> Transition:
        """Return the change of one contact to a state, with an event."""
        events = [] if kind is None else [(contact, kind)]
        return cls({contact: state}, events, passages=[] if at_end is None else [(contact, at_end)])


class Earlier(NamedTuple):
    """A contact that was closed where an earlier run has ended, and goes on from there."""

    state: int
    normal_force: float  # N
    tangential_force: float
    began: float  # m, slip at which it began
    residual: Residual  # of the contact point there


class ContactProbe(Protocol):
    """The problem of all contacts at the present state of a run, before and after impulses."""

    def of(self, contact: int) -> Candidate:
        """Return a contact, as if there were no others."""

    def coupled(self, contact: int) -> Candidate:
        """Return a closed contact with the present forces of the others in its accelerations."""

    def residual(self, contact: int) -> Residual:
        """Residual flexibility of a contact point."""

    def after(self, impulses: Mapping[int, Impulse]) -> list[Candidate]:
        """Return all contacts with the velocities that impulses leave."""

    def together(self, contacts: Sequence[int], impulses: Mapping[int, Impulse]) -> tuple[list[Candidate], Array]:
        """Return contacts with the velocities that impulses leave, and their Delassus matrix (m, 2, m, 2)."""

    def slip_rate_ahead(self, contact: int) -> float:
        """Slip velocity (m/s) of a contact a little later, if it stays closed; 0 if it is rounding."""


class StickCriterion(NamedTuple):
    """Criterion by which a scheme itself distinguishes stick from slip; see `can_stick`."""

    stopping_time: float  # s; the length of a step, or infinite for the paper's literal criterion
    located: bool = False  # transitions are located, and their guards say what follows

    @property
    def projects(self) -> bool:
        """Whether the slip velocity is set to zero when stick is detected."""
        return self.stopping_time < inf


class ContactMachine:
    """The transition table of one contact that is alone, for its laws and its kind of stop.

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
        Whether a point of an obstacle touches the beam, see `Candidate`; else a point of the beam a side.
    axial : callable, optional
        Axial flexibility (m/N) behind the friction of a contact that begins at a slip (m), and the sense of its
        tangent.  The stop is then rigid, or an :class:`~oblique_impact.contact.stops.ElasticStop` without damping,
        the friction is Coulomb's, and impacts have none.
    number : int
        Which of the candidates of a run this is.
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
        number: int = 0,
    ) -> None:
        self.friction, self.impact_law, self.contact_law = friction, impact_law, contact_law
        self.tolerances, self.axial, self.number = tolerances, axial, number
        #: number of decisions so far that had several solutions, of which an opening contact was taken
        self.ambiguous = 0
        self.stick_criterion = stick_criterion
        #: of a scheme that notices transitions late, at the ends of its steps
        self._late = None if stick_criterion is None or stick_criterion.located else stick_criterion
        self.extent = extent
        self._first, self._last = (float(end) for end in extent) if extent else (-inf, inf)
        self._free = Candidate(first=self._first, last=self._last)
        correct_rate, correct_place = map(float, baumgarte)
        self._closed = self._free.changed(
            static=-1.0 if friction.static is None else float(friction.static),
            held=float(not rolls),
            correct_rate=correct_rate,
            correct_place=correct_place,
            **(contact_law.stop if contact_law else {}),
        )
        #: of compliant stops, as kernels call it
        self.law = contact_law.kernel if contact_law else None

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the slope (m along it), infinite where it has none."""
        return self._first, self._last

    def free(self, side: float = 1.0) -> Candidate:
        """Return the state of flight above the line of the slope or, on the side -1, below it beyond its ends."""
        return self._free.changed(side=side)

    def is_beyond(self, slip: float) -> bool:
        """Whether a place (m along the slope) is beyond its ends."""
        return slip < self._first or slip > self._last

    def opened(self, c: Candidate) -> Candidate:
        """Return a contact that begins where a candidate is, with the axial flexibility behind it."""
        at = {name: getattr(c, name) for name in AT_AN_INSTANT}
        if self.axial is None:
            return self._closed.changed(**at)
        axial, sense = self.axial(c.slip)
        return self._closed.changed(axial=axial, sense=sense, **at)

    def start(self, probe: ContactProbe, earlier: Earlier | None = None) -> Transition:
        """Return the state at the start of a run, which may touch the slope, press on it or go on from another."""
        c, tolerances = probe.of(self.number), self.tolerances
        if earlier is not None:
            return Transition.to(self.number, self.resumed(earlier, c), EventKind.IMPACT)
        if c.gap < -tolerances.gap and self.is_beyond(c.slip):
            return Transition.to(self.number, self.free(-1.0))
        return Transition.to(self.number, self.free()) if self.is_apart(c) else self.touch(probe)

    def resumed(self, earlier: Earlier, c: Candidate) -> Candidate:
        """Return the state of a contact that goes on from an earlier run, its axial flexibility stretched."""
        opened = self.opened(c.changed(slip=earlier.began)).changed(slip=c.slip)
        c = inclined(_with_residual(opened, earlier.residual))
        if earlier.state == State.STICK:
            return stick_at(c.changed(slip=c.slip + c.axial * earlier.tangential_force))
        # with axial flexibility friction sees another velocity than that of the slip
        rate = 0.0 if self.axial is not None else c.slip_rate
        return self.slide(c, rate, -1 if earlier.tangential_force > 0.0 else 1)

    def is_apart(self, c: Candidate) -> bool:
        """Whether nothing touches at the start of a run; a stop that is pressed in still pushes as it opens."""
        pressed = self.contact_law is not None and c.gap < -self.tolerances.gap
        return c.gap > self.tolerances.gap or (c.gap_rate > self.tolerances.velocity and not pressed)

    def after_guard(self, c: Candidate, guard: int, probe: ContactProbe) -> Transition:
        """Return the transition after `guard` of a contact fell; raises RunEnded where no state exists."""
        if guard == DEFINITE:
            raise RunEnded(Outcome.PAINLEVE)
        if c.state == State.FREE:
            if c.side < 0.0:
                return self._to(self.free(), None, AtEnd.COMES_BACK)
            return self.touch(probe)
        if guard == NORMAL:
            return self._to(self.free(), EventKind.RELEASE)
        if guard == END:
            # a fixed step may leave it a little above the line
            following = self.free(1.0 if c.gap > self.tolerances.gap else -1.0)
            return self._to(following, EventKind.RELEASE, AtEnd.SLIDES_OFF)
        if self.axial is not None:
            return self._turn_axially(c, guard)
        if c.state == State.STICK:
            return self._leave_stick(c, guard)
        if guard == SWITCHED:
            return self._project_on_stick(c)
        kink = c.upper if guard == UPPER else c.lower
        if self.friction.static is None or self.stick_criterion or kink != 0.0:
            return self._next_branch(c, guard)
        return self._at_zero_slip(c, probe)

    def _to(self, state: Candidate, kind: EventKind | None, at_end: AtEnd | None = None) -> Transition:
        return Transition.to(self.number, state, kind, at_end)

    def touch(self, probe: ContactProbe) -> Transition:
        """Return the transition as the gap closes: an impact or a grazing contact; none beyond an end."""
        c = probe.of(self.number)
        if self.is_beyond(c.slip):
            return self._to(self.free(-1.0), None, AtEnd.FALLS_PAST)
        if self.contact_law is not None:
            return self._to(self.pressed(probe), EventKind.IMPACT)
        if self._grazes(c):
            state = self.closed(self.opened(c), probe.slip_rate_ahead)
            return self._to(state, None if state.state == State.FREE else EventKind.IMPACT)
        restitution = self.impact_law.restitution
        impulse = self._impulse(c, restitution)
        after = probe.after({self.number: impulse})[self.number]
        if restitution > 0.0 and self._bounces_accumulate(after):
            impulse = self._impulse(c, 0.0)
            after = probe.after({self.number: impulse})[self.number]
        if after.gap_rate > self.tolerances.velocity:
            found = self._to(self.free(), EventKind.REBOUND)
        else:
            found = self._struck(self.opened(after))
        found.impulses[self.number] = impulse
        return found

    def _struck(self, c: Candidate) -> Transition:
        """Return the state of a contact after an impact that leaves it closed."""
        try:
            state = self.closed(c)
        except RunEnded as ended:
            found = self._to(self.slide(c, c.slip_rate, _direction(c.slip_rate)), EventKind.IMPACT)
            found.failure = ended.outcome
            return found
        return self._to(state, EventKind.REBOUND if state.state == State.FREE else EventKind.IMPACT)

    def _grazes(self, c: Candidate) -> bool:
        """Whether a gap closes without speed, or opens again a thousandth of its tolerance below 0 or before.

        A point that moves along the slope at the bottom of its circle has no lever arm that an impulse could use.
        """
        depth = 2e-3 * self.tolerances.gap * c.gap_acceleration
        return c.gap_rate >= -self.tolerances.velocity or c.gap_rate**2 <= depth

    def pressed(self, probe: ContactProbe) -> Candidate:
        """Return the state in which a contact on a compliant stop begins."""
        c = _with_residual(self.opened(probe.of(self.number)), probe.residual(self.number))
        return self._pressed_axially(c) if self.axial is not None else self.closed(inclined(c))

    def _pressed_axially(self, c: Candidate) -> Candidate:
        """Return the state in which a contact on axial flexibility begins, where both its forces are zero.

        It sticks if the tangential force grows more slowly than the friction cone.
        """
        stuck, direction = stick_at(c), _direction(c.slip_rate)
        edge = stuck.changed(intercept=-direction * stuck.static, slope=0.0)
        # one that is found pressed in has no tangential force yet, and begins well inside of its cone
        slips = c.gap >= -self.tolerances.gap and direction * slip_velocity(edge) > 0.0
        return self.slide(stuck, c.slip_rate, direction) if slips else stuck

    def _turn_axially(self, c: Candidate, guard: int) -> Transition:
        """Return what follows stick at the edge of the cone, and the end of slip: stick, from where it ends."""
        if c.state == State.STICK:
            following = self._slide_or_free(c.changed(slip_rate=0.0), -1 if guard == LOWER else 1)
            return self._to(following, _kind(following, EventKind.SLIP))
        at = c.slip + c.axial * sliding_force(self.law, c).tangential
        return self._to(stick_at(c.changed(slip=at)), EventKind.STICK)

    def _impulse(self, c: Candidate, restitution: float) -> Impulse:
        """Return the impulse of the impact law in plain numbers: a user-defined one may have others."""
        return Impulse(*map(float, self.impact_law.impulse(c, restitution)))

    def _bounces_accumulate(self, after: Candidate) -> bool:
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

    def closed(self, c: Candidate, ahead: Callable[[int], float] | None = None) -> Candidate:
        """Return the state of a contact with zero gap and gap rate, or of one on a compliant stop.

        `ahead` is `ContactProbe.slip_rate_ahead` if the candidate is where the run is.  Raises RunEnded (Painleve,
        redundant constraints) where no state exists.
        """
        if self.axial is not None:  # a rigid stop: the spring along the beam has no force yet
            stuck = stick_at(c)
            held = self._unstabilized(stuck).changed(travel=stuck.slip)
            return stuck if sticking_force(self.law, held).normal > 0.0 else self.free()
        static, rate = self.friction.static, c.slip_rate
        if static is None:
            return self._slide_or_free(c, self._direction_without_stick(c, ahead))
        if abs(rate) > self.tolerances.velocity:
            # slip that ends within a step is found at its end, unless the force alone decides (the paper)
            if self._late is None or self._late.projects or not self._holds(c, static):
                return self._slide_or_free(c, _direction(rate))
            return stick_at(c)
        resting = c.changed(slip_rate=0.0)
        force = holding_force(self.law, self._unstabilized(resting), 0.0)
        if force.status != OK or self._redundant(resting):
            return self._slide_or_free(resting, self._turning_direction(resting, ahead))
        if abs(force.tangential) <= static * (force.normal + c.tilt * force.tangential):
            return stick_at(c)
        return self._slide_or_free(resting, -1 if force.tangential > 0.0 else 1)

    def _holds(self, c: Candidate, static: float) -> bool:
        """Whether the force that keeps a contact sticking, whatever its slip velocity, lies in the cone."""
        force = holding_force(self.law, self._unstabilized(c), 0.0)
        normal = force.normal + c.tilt * force.tangential
        return force.status == OK and normal > 0.0 and abs(force.tangential) <= static * normal

    def _unstabilized(self, c: Candidate) -> Candidate:
        """Return a contact in which Baumgarte's stabilization of the normal constraint does nothing."""
        return c if self.contact_law is not None else c.changed(gap=0.0, gap_rate=0.0)

    def _redundant(self, c: Candidate) -> bool:
        """Whether the tangential row of a rigid contact adds nothing to the normal one, but for rounding."""
        determinant = c.a_nn * c.a_tt - c.a_nt * c.a_nt
        least = _PARALLEL * c.a_nn * (c.a_tt + _NO_ROW * c.a_nn)
        return self.contact_law is None and determinant <= least

    def _direction_without_stick(self, c: Candidate, ahead: Callable[[int], float] | None) -> int:
        """Direction of slip of a law that always slips; of a contact at rest that in which it begins to move."""
        if abs(c.slip_rate) > self.tolerances.velocity or not self._redundant(c):
            return _direction(c.slip_rate)
        return _direction(self._turning_rate(c, ahead))

    def _turning_direction(self, c: Candidate, ahead: Callable[[int], float] | None) -> int:
        """Direction of slip where the tangential row adds nothing to the normal one.

        No tangential force can hold such a contact, nor move it: its slip turns as the motion along the
        slope dictates, whatever the friction.
        """
        rate = self._turning_rate(c, ahead)
        if rate == 0.0 and self.contact_law is None and c.gap_acceleration < 0.0:
            raise RunEnded(Outcome.REDUNDANT_CONSTRAINTS)
        return _direction(rate)

    def _turning_rate(self, c: Candidate, ahead: Callable[[int], float] | None) -> float:
        """Slip velocity (m/s) a little later, or slip acceleration (m/s^2) where that is not known; for its sign.

        The rows of a straight beam at rest are parallel, and its tip has no acceleration along the slope but for
        rounding: it slips as the beam shortens by bending, with the third power of time.
        """
        later = ahead(self.number) if ahead else 0.0
        if self.contact_law is not None:
            return c.slip_rate or later
        normal = -c.gap_acceleration / c.a_nn
        return later or c.slip_acceleration + c.a_nt * normal

    def _slide_or_free(self, c: Candidate, direction: int) -> Candidate:
        sliding = self.slide(c, c.slip_rate, direction)
        if self.contact_law is not None:
            if not can_slide(sliding):
                raise RunEnded(Outcome.PAINLEVE)
            return sliding
        force = sliding_force(self.law, self._unstabilized(sliding))
        if force.status != OK:
            raise RunEnded(Outcome.PAINLEVE)
        if sliding_inertia(sliding) < 0.0 < c.gap_acceleration:
            self.ambiguous += 1
        pushes = force.normal > 0.0
        if self._late:  # a contact noticed below the slope is pushed out by its stabilization
            pushes = pushes or sliding_force(self.law, sliding).normal > 0.0
        return sliding if pushes else self.free()

    def slide(self, c: Candidate, slip_rate: float, direction: int) -> Candidate:
        """Return the sliding state of a contact at a slip velocity (m/s), in a direction where that is 0."""
        intercept, slope, lower, upper = map(float, self.friction.branch(slip_rate, direction))
        return c.changed(state=int(State.SLIP), intercept=intercept, slope=slope, lower=lower, upper=upper)

    def _project_on_stick(self, c: Candidate) -> Transition:
        """Set the slip velocity to zero by an impulse that leaves the gap rate unchanged."""
        found = self._to(stick_at(c), EventKind.STICK)
        if self._late is None or not self._late.projects:
            return found
        if self.contact_law is not None:
            projection = impulse_of(c, 0.0, -c.slip_rate / c.a_tt)
        else:
            per_rate = c.slip_rate / (c.a_nn * c.a_tt - c.a_nt * c.a_nt)
            projection = impulse_of(c, c.a_nt * per_rate, -c.a_nn * per_rate)
        found.stick_projections[self.number] = projection
        return found

    def _leave_stick(self, c: Candidate, guard: int) -> Transition:
        if self._late and self._late.projects:
            # the force that would hold it decides, not a slip velocity that is rounding or stabilization
            direction = -1 if holding_force(self.law, c, 0.0).tangential > 0.0 else 1
            return self._to(self.slide(c, 0.0, direction), EventKind.SLIP)
        if self._late:
            return self._to(self.slide(c, c.slip_rate, _direction(c.slip_rate)), EventKind.SLIP)
        # guard LOWER: lambda_tau reached +static lambda_n, so the contact slips backwards
        following = self._slide_or_free(c.changed(slip_rate=0.0), 1 if guard == UPPER else -1)
        return self._to(following, _kind(following, EventKind.SLIP))

    def _next_branch(self, c: Candidate, guard: int) -> Transition:
        upward = guard == UPPER
        # a located kink is where the slip velocity is, up to rounding that could fall on either side of it
        kink = c.slip_rate if self._late else (c.upper if upward else c.lower)
        following = self.slide(c, kink, 1 if upward else -1)
        reversed_ = direction_of(c) * direction_of(following) < 0
        return self._to(following, EventKind.REVERSAL if reversed_ else None)

    def _at_zero_slip(self, c: Candidate, probe: ContactProbe) -> Transition:
        following = self.closed(c.changed(slip_rate=0.0), probe.slip_rate_ahead)
        if following.state == State.STICK:
            return self._to(following, EventKind.STICK)
        return self._to(following, _kind(following, EventKind.REVERSAL))


def inclined(c: Candidate) -> Candidate:
    """Return a contact as that of a contact point without inertia, whose slip is Z_tau + tilt Z_n."""
    t = c.tilt
    return c.changed(
        slip=c.slip + t * c.gap,
        slip_rate=c.slip_rate + t * c.gap_rate,
        a_nt=c.a_nt + t * c.a_nn,
        a_tt=c.a_tt + t * (2.0 * c.a_nt + t * c.a_nn),
        slip_acceleration=c.slip_acceleration + t * c.gap_acceleration,
    )


def _with_residual(c: Candidate, residual: Residual) -> Candidate:
    compliance, relaxation, tilt = map(float, residual)
    return c.changed(compliance=compliance, relaxation=relaxation, tilt=tilt)


def stick_at(c: Candidate) -> Candidate:
    """Return the sticking state of a contact at its present slip."""
    return c.changed(state=int(State.STICK), kept_slip=float(c.slip))


def _direction(rate: float) -> int:
    return 1 if rate >= 0.0 else -1


def _kind(c: Candidate, kind: EventKind) -> EventKind:
    return EventKind.RELEASE if c.state == State.FREE else kind


def direction_of(c: Candidate) -> int:
    """Direction of slip on a branch: +1, -1, or 0 for a branch on both sides of zero."""
    return int(c.lower >= 0.0) - int(c.upper <= 0.0)

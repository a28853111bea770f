"""The only loop: advance a phase, locate the event, apply the transition, record.

It is the same for every system, discretization and scheme.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.forces import (
    GUARD_DEFINITE,
    Impulse,
    Instant,
    Phase,
    State,
    instant_of,
    measure_guards,
)
from oblique_impact.contact.stops import Stop
from oblique_impact.contact.transitions import ContactMachine, EventKind, Transition
from oblique_impact.errors import Outcome, PhysicsStop
from oblique_impact.kernels.system import (
    ACCELERATION,
    FIRST_GUARD,
    GAP,
    GAP_RATE,
    GUARDS,
    LAMBDA_N,
    MASS,
    NORMAL_RESPONSE,
    NORMAL_ROW,
    SLIP_RATE,
    TANGENT_RESPONSE,
    TANGENT_ROW,
    Array,
    Work,
    new_work,
    supplied_power,
)
from oblique_impact.marching import scheme as base
from oblique_impact.marching.equations import (
    FRICTION_LOSS,
    NORMAL_IMPULSE,
    QUADRATURES,
    STABILIZATION_LOSS,
    STOP_LOSS,
    SUPPLIED,
    TANGENTIAL_IMPULSE,
)
from oblique_impact.marching.sampling import Observation, condense_at, observe, observe_into
from oblique_impact.marching.scheme import Course, Scheme, Scratch, Tolerances, new_scratch

MAX_EVENTS = 100_000
_CLUSTER, _CLUSTER_TIME = 40, 1e-9  # so many transitions within so many seconds are chattering
_NEARLY_SINGULAR = 0.05

_FAILURES = {
    base.FAILED_MASS: Outcome.MASS_MATRIX_INDEFINITE,
    base.FAILED_SLIDING: Outcome.PAINLEVE,
    base.FAILED_STICKING: Outcome.REDUNDANT_CONSTRAINTS,
    base.FAILED_STEP: Outcome.STEP_UNDERFLOW,
    base.FAILED_FINITE: Outcome.DIVERGED,
    base.FAILED_ITERATION: Outcome.NOT_CONVERGED,
}


def smallest_eigenvalue(work: Work) -> float:
    """Smallest eigenvalue of a dense evaluated mass matrix, 0 if it is not finite."""
    mass = work.matrices[MASS]
    return float(np.linalg.eigvalsh(mass)[0]) if np.all(np.isfinite(mass)) else 0.0


@dataclass(frozen=True)
class Problem:
    """Everything the loop needs to march one system."""

    system: Any
    q0: Array
    qd0: Array
    machine: ContactMachine
    scheme: Scheme
    end_time: float
    output_interval: float
    contact: bool = True
    breakpoints: tuple[float, ...] = ()  # times (s) at which the forces are not smooth
    observer: Callable[..., None] = observe_into
    condenser: Callable[..., bool] = condense_at
    supply: Callable[..., float] = supplied_power
    allocate: Callable[[int], Work] = new_work
    inertia: Callable[[Work], float] = smallest_eigenvalue


class Event(NamedTuple):
    """One row of the event log (SI units).

    The row of an impact or a rebound holds what its impulse did.  The row of a release holds what the finite force
    did since the contact began, so that each impulse (N s) and each loss (J) stands in one row.
    """

    time: float
    kind: EventKind
    normal_impulse: float
    tangential_impulse: float
    normal_velocity: float  # gap rate just before
    tangential_velocity: float  # slip rate just after
    energy_loss: float
    state: State  # after
    peak_force: float = 0.0  # N, the largest normal force of the contact that is released
    peak_energy: float = 0.0  # J, the largest that its elastic stop has stored


class Contact(NamedTuple):
    """One closed contact, or a rebound (start = end); impulses of impacts are included (SI units)."""

    start: float
    end: float
    normal_impulse: float
    tangential_impulse: float
    peak_force: float  # N, the largest finite normal force
    peak_energy: float  # J, the largest that an elastic stop has stored
    energy_loss: float  # J, by impact, friction and the stop's damping


@dataclass
class _OpenContact:
    """What is known of a contact that is still closed."""

    start: float
    impulse: Impulse  # that it began with
    quadratures: Array  # at its start
    peak_force: float = 0.0
    depth: float = 0.0  # m

    def closed(self, end: float, quadratures: Array, stop: Stop | None) -> tuple[Contact, Contact]:
        """Return the contact that ends at `end`, and the share of its finite force."""
        gained = quadratures - self.quadratures
        normal, tangential = float(gained[NORMAL_IMPULSE]), float(gained[TANGENTIAL_IMPULSE])
        stored = stop.energy(-self.depth) if stop else 0.0
        loss = float(gained[FRICTION_LOSS] + gained[STOP_LOSS])
        finite = Contact(self.start, end, normal, tangential, self.peak_force, stored, loss)
        whole = finite._replace(
            normal_impulse=normal + self.impulse.normal,
            tangential_impulse=tangential + self.impulse.tangential,
            energy_loss=loss + self.impulse.energy_loss,
        )
        return whole, finite


class Segment(NamedTuple):
    """Samples of one phase."""

    state: int
    times: Array  # (samples,)
    states: Array  # (samples, ny)
    observation: Observation


#: stands in a record for samples that somebody has taken out, so that they do not fill the memory twice
LET_GO = Segment(State.FREE, np.empty(0), np.empty((0, 0)), Observation(np.empty((0, 0)), np.empty((0, 0))))


@dataclass
class Record:
    """Everything a run leaves behind."""

    segments: list[Segment] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    contacts: list[Contact] = field(default_factory=list)
    outcome: Outcome = Outcome.COMPLETED
    steps: int = 0
    rejected: int = 0


class Status(NamedTuple):
    """What a progress display is told."""

    time: float
    end_time: float
    state: State
    events: int


class _Front:
    """The contact problem at the moving front; the machine's probe."""

    def __init__(self, problem: Problem, course: Course, scratch: Scratch) -> None:
        self._problem, self._course, self._work = problem, course, scratch.work
        self._size = problem.q0.size

    @cached_property
    def instant(self) -> Instant:
        d, y = self._size, self._course.y
        return self._at(y[d : 2 * d])

    def velocity_jump(self, impulse: Impulse) -> Array:
        """q'+ - q'- = M^-1 (D_n^T P_n + D_tau^T P_tau); shape (d,)."""
        self._at(self._course.y[self._size : 2 * self._size])
        responses = self._work.vectors
        jump = impulse.normal * responses[NORMAL_RESPONSE] + impulse.tangential * responses[TANGENT_RESPONSE]
        return np.asarray(jump)

    def after(self, impulse: Impulse) -> Instant:
        velocity = self._course.y[self._size : 2 * self._size]
        return self._at(velocity + self.velocity_jump(impulse))

    def _at(self, velocity: Array) -> Instant:
        q = self._course.y[: self._size]
        if not self._problem.condenser(self._problem.system, self._course.t, q, velocity, self._work):
            raise PhysicsStop(Outcome.MASS_MATRIX_INDEFINITE)
        return instant_of(self._work)


class Run:
    """One run of the loop over a problem.

    Parameters
    ----------
    problem : Problem
        What to march.
    on_progress : callable, optional
        Called with a :class:`Status` after every leg.
    """

    def __init__(self, problem: Problem, on_progress: Callable[[Status], None] | None = None) -> None:
        self.problem = problem
        self.record = Record()
        self._report = on_progress or (lambda status: None)
        size = problem.q0.size
        extra = np.full(problem.scheme.extra_state(size), np.nan)
        y = np.concatenate([problem.q0, problem.qd0, np.zeros(QUADRATURES), extra])
        self._scratch = new_scratch(problem.allocate(size), y.size)
        self._course = Course(0.0, y, 1e-3 * problem.output_interval, problem.output_interval)
        self._phase = problem.machine.free()._replace(watched=problem.contact)
        self._open: _OpenContact | None = None
        self._initial_inertia = 0.0
        self._recent: deque[float] = deque(maxlen=_CLUSTER)

    def execute(self) -> Record:
        """March to the end or to the named outcome that stops the physics."""
        record = self.record
        try:
            if self.problem.contact:
                self._begin()
            self._initial_inertia = self._smallest_inertia()
            self._enter()
            stops = [t for t in self.problem.breakpoints if 0.0 < t < self.problem.end_time]
            for stop in [*sorted(stops), self.problem.end_time]:
                self._march_to(stop)
        except PhysicsStop as stopped:
            record.outcome = stopped.outcome
        except KeyboardInterrupt:
            record.outcome = Outcome.INTERRUPTED
        self._sample(self._phase)
        self._close_contact()
        return record

    def _begin(self) -> None:
        """Find the contact state at t = 0, which may be an impact."""
        transition = self.problem.machine.start(self._front())
        if transition.kind is not None:
            self._sample(self._phase)
        self._apply(self._phase, transition)

    def _march_to(self, stop: float) -> None:
        problem, course = self.problem, self._course
        while True:
            progress = problem.scheme.march(problem.system, self._phase, course, stop, self._scratch)
            self._keep(progress)
            self._report(Status(course.t, problem.end_time, State(self._phase.state), len(self.record.events)))
            if progress.reason == base.AT_STOP:
                return
            if progress.reason == base.AT_GUARD:
                self._pass_guard(progress.guard)
            elif progress.reason < 0:
                raise PhysicsStop(self._failure(progress.reason))

    def _failure(self, reason: int) -> Outcome:
        """Name why a march failed: a step that shrinks to nothing is a symptom of a singular problem."""
        if reason in (base.FAILED_STEP, base.FAILED_FINITE):
            if self._smallest_inertia() < _NEARLY_SINGULAR * self._initial_inertia:
                return Outcome.MASS_MATRIX_INDEFINITE
            sliding = self._phase.state == State.SLIP
            if sliding and self._scratch.work.scalars[FIRST_GUARD + GUARD_DEFINITE] < _NEARLY_SINGULAR:
                return Outcome.PAINLEVE
        return _FAILURES[reason]

    def _smallest_inertia(self) -> float:
        """Smallest eigenvalue of the mass matrix at the front, or what the system has in its place."""
        d, y, work = self.problem.q0.size, self._course.y, self._scratch.work
        self.problem.condenser(self.problem.system, self._course.t, y[:d], y[d : 2 * d], work)
        return self.problem.inertia(work)

    def _pass_guard(self, guard: int) -> None:
        leaving = self._phase
        self._sample(leaving)
        transition = self.problem.machine.after_guard(leaving, guard, self._front())
        self._apply(leaving, transition)
        self._watch_for_chattering()
        self._enter()

    def _front(self) -> _Front:
        return _Front(self.problem, self._course, self._scratch)

    def _apply(self, leaving: Phase, transition: Transition) -> None:
        """Apply the impulse, log the event, open or close a contact, take the new phase."""
        front, d = self._front(), self.problem.q0.size
        before = front.instant
        impulse = transition.impulse or Impulse(0.0, 0.0, 0.0)
        if transition.impulse is not None:
            jump = front.velocity_jump(impulse)
            self._course.y[2 * d + SUPPLIED] += self._impulsive_supply(impulse, jump)
            self._course.y[d : 2 * d] += jump
        self._phase = transition.phase
        after = self._front().instant
        finite = self._track_contact(leaving, impulse, transition.kind)
        if transition.kind is not None:
            event = Event(
                self._course.t,
                transition.kind,
                impulse.normal,
                impulse.tangential,
                before.gap_rate,
                after.slip_rate,
                impulse.energy_loss,
                State(self._phase.state),
            )
            self.record.events.append(_with_share(event, finite) if finite else event)
        self._account_for_penetration(leaving, before.gap)
        if transition.stop is not None:
            raise PhysicsStop(transition.stop)

    def _impulsive_supply(self, impulse: Impulse, jump: Array) -> float:
        """Energy (J) that drives and moving boundaries put in during an impact.

        Their power is affine in the acceleration, so its linear part gives the work of the jump; the
        boundaries move with the mean of the velocities before and after.
        """
        d, y, work, problem = self.problem.q0.size, self._course.y, self._scratch.work, self.problem
        q, qd, k = y[:d], y[d : 2 * d], work.scalars
        problem.condenser(problem.system, self._course.t, q, qd, work)
        powers = []
        for acceleration in (jump, np.zeros(d)):
            work.vectors[ACCELERATION] = acceleration
            powers.append(problem.supply(problem.system, self._course.t, q, qd, work))
        rows = work.vectors[NORMAL_ROW], work.vectors[TANGENT_ROW]
        normal, tangential = (float(row @ qd) for row in rows)  # rates without the boundary's own
        boundary = impulse.normal * (normal - k[GAP_RATE]) + impulse.tangential * (tangential - k[SLIP_RATE])
        return float(powers[0] - powers[1] + boundary)

    def _account_for_penetration(self, leaving: Phase, gap: float) -> None:
        """Charge the scheme with the energy of an elastic stop that contact finds or leaves compressed.

        Located contacts begin and end at zero gap; a fixed step notices them late.
        """
        stop = self.problem.machine.stop
        if stop is None or (leaving.state == State.FREE) == (self._phase.state == State.FREE):
            return
        found = -1.0 if leaving.state == State.FREE else 1.0
        self._quadratures()[STABILIZATION_LOSS] += found * stop.energy(gap)

    def _track_contact(self, leaving: Phase, impulse: Impulse, kind: EventKind | None) -> Contact | None:
        """Open or close a contact; returns the share of the finite force of one that is closed."""
        if leaving.state == State.FREE and kind is not None:
            self._open = _OpenContact(self._course.t, impulse, self._quadratures().copy())
        return self._close_contact() if self._phase.state == State.FREE else None

    def _close_contact(self) -> Contact | None:
        if self._open is None:
            return None
        contact, finite = self._open.closed(self._course.t, self._quadratures(), self.problem.machine.stop)
        self.record.contacts.append(contact)
        self._open = None
        return finite

    def _quadratures(self) -> Array:
        return self._course.y[2 * self.problem.q0.size :]

    def _watch_for_chattering(self) -> None:
        t = self._course.t
        if len(self._recent) == _CLUSTER and t - self._recent[0] < _CLUSTER_TIME:
            raise PhysicsStop(Outcome.CHATTERING)
        self._recent.append(t)
        if len(self.record.events) > MAX_EVENTS:
            raise PhysicsStop(Outcome.TOO_MANY_EVENTS)

    def _enter(self) -> None:
        """Begin a phase: sample its right-hand values and arm its guards."""
        self._course.begin_phase()
        self._course.y[2 * self.problem.q0.size + QUADRATURES :] = np.nan  # what a scheme keeps ends with a phase
        self._sample(self._phase)
        scalars = self._scratch.work.scalars  # still those of the sample just taken
        measure_guards(self._phase, scalars)
        self.problem.scheme.begin(
            self._phase,
            self._scratch,
            self.problem.machine.tolerances,
            scalars[FIRST_GUARD : FIRST_GUARD + GUARDS],
        )

    def _sample(self, phase: Phase) -> None:
        self._observe(phase, np.array([self._course.t]), self._course.y[None, :].copy())

    def _keep(self, progress: base.Progress) -> None:
        """Store the samples and costs of a leg."""
        count = progress.samples
        if count:
            times, states = self._scratch.times[:count].copy(), self._scratch.states[:count].copy()
            self._observe(self._phase, times, states)
        self.record.steps += progress.steps
        self.record.rejected += progress.rejected
        if self._open is not None:
            self._open.peak_force = max(self._open.peak_force, progress.peak_force)
            self._open.depth = max(self._open.depth, progress.depth)

    def _observe(self, phase: Phase, times: Array, states: Array) -> None:
        problem = self.problem
        observation = observe(problem.system, phase, times, states, self._scratch.work, problem.observer)
        if self._open is not None and times.size:
            forces, gaps = observation.scalars[:, LAMBDA_N], observation.scalars[:, GAP]
            self._open.peak_force = float(np.nanmax([self._open.peak_force, *forces]))
            self._open.depth = float(np.nanmax([self._open.depth, *-gaps]))
        # a scheme's own entries behind the quadratures are not kept
        kept = states[:, : 2 * problem.q0.size + QUADRATURES].copy()
        self.record.segments.append(Segment(phase.state, times, kept, observation))


def _with_share(event: Event, finite: Contact) -> Event:
    """Add the share of the contact's finite force to the row of the event that ends it."""
    return event._replace(
        normal_impulse=event.normal_impulse + finite.normal_impulse,
        tangential_impulse=event.tangential_impulse + finite.tangential_impulse,
        energy_loss=event.energy_loss + finite.energy_loss,
        peak_force=finite.peak_force,
        peak_energy=finite.peak_energy,
    )


def default_tolerances(length: float, force: float) -> Tolerances:
    """Tolerances for a system of the given size (m) whose contact forces are about `force` (N)."""
    return Tolerances(gap=1e-12 * length, force=1e-10 * force, velocity=1e-11 * length)

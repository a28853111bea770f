"""The only loop: advance a phase, locate the event, apply the transition, record.

It is the same for every system, discretization and scheme.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from copy import copy
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.forces import guards_of
from oblique_impact.contact.impacts import Impulse
from oblique_impact.contact.several import add_stretch, guard_values, inside_cones, slides_stretching
from oblique_impact.contact.state import Instant, Phase, State, Surface
from oblique_impact.contact.transitions import AtEnd, EventKind, Transition
from oblique_impact.errors import Outcome, RunEnded
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching import advance as base
from oblique_impact.marching.advance import Limits, MarchResult, StepState, march
from oblique_impact.marching.buffers import NEXT, arm, new_scratch
from oblique_impact.marching.equations import (
    FRICTION_LOSS,
    NORMAL_IMPULSE,
    OF_A_CONTACT,
    QUADRATURES,
    STABILIZATION_LOSS,
    STOP_LOSS,
    SUPPLIED,
    TANGENTIAL_IMPULSE,
    take_derivative,
)
from oblique_impact.marching.probe import Probe
from oblique_impact.marching.problem import Problem
from oblique_impact.marching.records import Contact, Event, OpenContact, Passage, Record, Segment
from oblique_impact.marching.sampling import Observation, contact_problem, observe
from oblique_impact.marching.scheme import Prepared
from oblique_impact.marching.search import nearby
from oblique_impact.progress import Status

MAX_EVENTS = 100_000
#: so many transitions within so much of the run are chattering
_CLUSTER, _CLUSTER_TIME = 40, 1e-9
#: smallest eigenvalue of the mass matrix, of that at the start: below it a run that fails is taken to be singular
_NEARLY_SINGULAR = 0.05
#: of the beam's length: beyond it a small-deflection model says nothing
LARGEST_DEFLECTION = 0.5
#: a run that would need more steps is stopped.  100 s of the paper's beam take 1e6, 10 s of 128 modes some 1e7,
#: which are hours; for two modes 2e7 are minutes, where another scheme takes seconds
MOST_STEPS = 2e7
#: the pace of so many steps tells how many are to come: seconds of computing with few modes, half a minute with
#: sixteen, and longer than a contact takes
PACE_STEPS = 500_000
_INTERPRETED_STEPS = 200  # of a call: about a tenth of a second of a small system in plain Python
LONG = 60.0  # s to go, from which on a run says so
#: of a singular problem, maybe
_SYMPTOMS = (Outcome.STEP_UNDERFLOW, Outcome.DIVERGED, Outcome.LARGE_DEFLECTION, Outcome.NOT_CONVERGED)

_FAILURES = {
    base.FAILED_MASS: Outcome.MASS_MATRIX_INDEFINITE,
    base.FAILED_SLIDING: Outcome.PAINLEVE,
    base.FAILED_STICKING: Outcome.REDUNDANT_CONSTRAINTS,
    base.FAILED_STEP: Outcome.STEP_UNDERFLOW,
    base.FAILED_FINITE: Outcome.DIVERGED,
    base.FAILED_ITERATION: Outcome.NOT_CONVERGED,
}


class _Mark(NamedTuple):
    """A run where its books agree with its last sample, or with the state that a transition begins with."""

    now: StepState
    y: Array
    phase: Phase
    open: Any  # contacts that are closed there
    counts: list[int]  # of what is recorded


class Run:
    """One run of the loop over a problem.

    Parameters
    ----------
    problem : Problem
        What to march.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.progress.Status` about ten times a second.
    """

    def __init__(self, problem: Problem, on_progress: Callable[[Status], None] | None = None) -> None:
        self.problem = problem
        self.record = Record()
        self._report = on_progress
        size = problem.q0.size
        contacts = len(problem.multi_contact.places) if problem.multi_contact else 0
        integrals = np.zeros(QUADRATURES + OF_A_CONTACT * contacts)
        extra = np.full(problem.scheme.extra_state(size, max(contacts, 1), integrals.size), np.nan)
        self._y = np.concatenate([problem.q0, problem.qd0, integrals, extra])
        self._kept = self._y.size - extra.size  # entries of the state that samples keep, not those of the scheme
        work = problem.system.new_workspace()
        tolerances = problem.machine.tolerances
        self._scratch = new_scratch(work, self._y.size, problem.scales, tolerances, max(contacts, 1))
        own = problem.scheme.buffers(self._y.size, problem.modes, problem.output_interval, problem.end_time)
        self.prepared = Prepared(problem.system, self._scratch, own)
        self._now = StepState(0.0, 1e-3 * problem.output_interval, 0.0, 0, 0)
        self._phase = problem.machine.free()._replace(surface=Surface(enabled=bool(problem.contact)))
        self._before: Phase | None = None
        self._open: OpenContact | None = None
        self._initial_inertia = 0.0
        self._steps_per_call = problem.scheme.steps_per_call(size)
        if not isinstance(problem.system, tuple):
            self._steps_per_call = min(self._steps_per_call, _INTERPRETED_STEPS)
        self._paced = 0, 0.0  # steps taken and time (s) when the pace was last looked at
        self._recent: deque[float] = deque(maxlen=_CLUSTER)

    def execute(self) -> Record:
        """March to the end, to a named outcome, or to an interrupt."""
        self._started = perf_counter()
        record = self.record
        self._set_mark()
        try:
            if self.problem.contact:
                self._begin()
                # what an elastic stop that is pressed in at the start holds is not from the scheme
                self._quadratures()[STABILIZATION_LOSS] = 0.0
            self._initial_inertia = self._inertia()
            before = list(record.segments)
            self._enter(None)
            for segment in before:  # it holds it before the contact is found as well
                segment.stored[:] = record.segments[len(before)].stored[0]
                segment.stretched[:] = record.segments[len(before)].stretched[0]
            ends = [t for t in self.problem.breakpoints if 0.0 < t < self.problem.end_time]
            for end in [*sorted(ends), self.problem.end_time]:
                self._march_to(end)
        except RunEnded as ended:
            record.outcome, record.message = ended.outcome, ended.message
        except KeyboardInterrupt:
            record.outcome = Outcome.INTERRUPTED
        if record.outcome is Outcome.INTERRUPTED:
            self._return_to_mark()  # it may have come between a call and its bookkeeping
        if record.outcome is not Outcome.INTERRUPTED or not record.segments:
            self._sample(self._phase)
        self._close_contact()
        return record

    def _set_mark(self, t: float | None = None, y: Array | None = None) -> None:
        """Mark where the run is, or its last sample at a time (s) with a state vector, to return to it."""
        counts = [len(entries) for entries in self._recorded()]
        now, state = self._now if t is None else self._now._replace(t=t), self._y if y is None else y
        self._mark = _Mark(now, state.copy(), self._phase, self._copy_open(), counts)

    def _return_to_mark(self) -> None:
        """Return to the last mark: what has been recorded since then belongs to no state."""
        mark = self._mark
        self._now, self._y[:], self._phase = mark.now, mark.y, mark.phase
        self._take_open(mark.open)
        for entries, count in zip(self._recorded(), mark.counts, strict=True):
            del entries[count:]

    def _recorded(self) -> tuple[list[Any], ...]:
        """Return the lists of the record."""
        record = self.record
        return record.segments, record.events, record.contacts, record.passages, record.ambiguous

    def _copy_open(self) -> Any:
        """Return a copy of what is known of contacts that are closed."""
        return copy(self._open)

    def _take_open(self, known: Any) -> None:
        """Take what is known of contacts that are closed from :meth:`_copy_open`."""
        self._open = known

    def _begin(self) -> None:
        """Find the contact state at t = 0, which may be an impact."""
        self._pass(self._start)

    def _start(self) -> Outcome | None:
        probe = self._probe()
        transition = self.problem.machine.start(probe, self.problem.earlier.get(0))
        if transition.kind is not None:
            self._sample(self._phase)
        return self._apply(self._phase, transition, probe)

    def _pass(self, change: Callable[[], Outcome | None]) -> None:
        """Pass a transition by a function that decides and applies it, all of it or nothing.

        Where no contact state exists behind it the function returns the outcome that ends the run there.
        """
        self._set_mark()
        before = self._ambiguous
        try:
            failure = change()
        except RunEnded:
            self._return_to_mark()
            raise
        if self._ambiguous > before:
            self.record.ambiguous.append(self._now.t)
        if failure is not None:
            raise RunEnded(failure)

    def _march_to(self, end: float) -> None:
        problem = self.problem
        while True:
            bounds = float(end), float(problem.end_time), float(problem.output_interval)
            limits = Limits(*bounds, self._steps_per_call)
            stepper = problem.scheme.stepper(self.prepared, self._phase, self._before, limits)
            progress = march(stepper, self._now, self._y)
            self._now = progress.state
            self._keep(progress)
            if self._report is not None:
                state = State(self._phase.state)
                self._report(Status(self._now.t, problem.end_time, state, len(self.record.events)))
            if progress.reason == base.AT_STOP:
                return
            if progress.reason == base.AT_GUARD:
                self._pass_guard(progress.guard)
            elif progress.reason < 0:
                raise RunEnded(self._cause(_FAILURES[progress.reason]))
            self._foresee_steps()

    def _cause(self, failure: Outcome) -> Outcome:
        """Name why a march failed: a singular problem shows as a step that shrinks or a motion that grows."""
        if failure in _SYMPTOMS and self._inertia() < _NEARLY_SINGULAR * self._initial_inertia:
            return Outcome.MASS_MATRIX_INDEFINITE
        if failure in (Outcome.STEP_UNDERFLOW, Outcome.DIVERGED):
            sliding = self._phase.state == State.SLIP
            if sliding and self._relative_inertia() < _NEARLY_SINGULAR:
                return Outcome.PAINLEVE
        return failure

    def _foresee_steps(self) -> None:
        """End a run that would need far too many steps if they stay as short as the last ones.

        Steps of a given length are counted before a run, by a rule of the scenario.
        """
        taken, time = self.record.steps + self.record.rejected, self._now.t
        before, since = self._paced
        if taken - before < PACE_STEPS:
            return
        self._paced = taken, time
        pace = (taken - before) / (time - since) if time > since else np.inf  # 1/s
        needed = taken + pace * (self.problem.end_time - time)
        if self.problem.scheme.name == "event" and needed > MOST_STEPS:
            words = f"The run would need about {needed:.2g} steps, more than {MOST_STEPS:.0e}"
            remedy = 'solver.scheme = "generalized-alpha", whose steps the fastest vibration does not shorten'
            raise RunEnded(Outcome.TOO_MANY_STEPS, f"{words}; use {remedy}, or a shorter end_time.")
        seconds = (needed - taken) * (perf_counter() - self._started) / taken
        if before == 0 and seconds > LONG and self._report is not None:
            notice = f"about {seconds / 60.0:.0f} minutes to go, {needed:.2g} steps in all"
            if self.problem.scheme.name == "event":
                notice += '; solver.scheme = "generalized-alpha" takes longer ones'
            status = Status(time, self.problem.end_time, State(self._phase.state), len(self.record.events), notice)
            self._report(status)

    def _inertia(self) -> float:
        """Smallest eigenvalue of the mass matrix now, or what the system has in its place."""
        d, y, work = self.problem.q0.size, self._y, self._scratch.work
        _, e, _ = contact_problem(self.problem.system, self._now.t, y[:d], y[d : 2 * d], work)
        return float(self.problem.system.definiteness(e.rank_one, work))

    def _relative_inertia(self) -> float:
        """Effective inverse normal mass of the sliding contact now, relative to that without friction."""
        d, y = self.problem.q0.size, self._y
        defined, _, c = contact_problem(self.problem.system, self._now.t, y[:d], y[d : 2 * d], self._scratch.work)
        return guards_of(self._phase, c).definite if defined else 1.0

    def _pass_guard(self, guard: int) -> None:
        leaving = self._phase
        self._sample(leaving)
        self._pass(lambda: self._follow(leaving, guard))
        self._watch_for_chattering()
        self._enter(leaving)

    def _follow(self, leaving: Phase, guard: int) -> Outcome | None:
        probe = self._probe()
        return self._apply(leaving, self.problem.machine.after_guard(leaving, guard, probe), probe)

    @property
    def _ambiguous(self) -> int:
        return self.problem.machine.ambiguous

    def _probe(self) -> Probe:
        return Probe(self.problem, self._phase, self._now.t, self._y, self._scratch.work)

    def _apply(self, leaving: Phase, transition: Transition, probe: Probe) -> Outcome | None:
        """Apply the impulse, log the event, open or close a contact, take the new phase; why the run ends here."""
        before, impulse = probe.instant, transition.impulse or Impulse(0.0, 0.0, 0.0)
        if transition.impulse is not None:
            self._jump(impulse, probe)
        if transition.stick_projection is not None:
            self._jump(transition.stick_projection, probe)
            quadratures = self._quadratures()
            quadratures[NORMAL_IMPULSE] += transition.stick_projection.normal
            quadratures[TANGENTIAL_IMPULSE] += transition.stick_projection.tangential
            quadratures[FRICTION_LOSS] += transition.stick_projection.energy_loss
        if transition.at_end is not None:
            self._pass_end(leaving, transition.at_end, before)
        self._phase = transition.phase
        jumps = (
            transition.impulse is not None
            or transition.stick_projection is not None
            or leaving.residual.tilt != self._phase.residual.tilt
        )
        after = self._probe().instant if jumps else before
        finite = self._track_contact(leaving, impulse, transition.kind)
        if transition.kind is not None:
            event = Event(
                self._now.t,
                transition.kind,
                impulse.normal,
                impulse.tangential,
                before.gap_rate,
                after.slip_rate,
                impulse.energy_loss,
                State(self._phase.state),
            )
            self.record.events.append(event.with_share(finite) if finite else event)
        if transition.at_end is None:
            self._account_for_penetration(leaving, before.gap)
        return transition.failure

    def _pass_end(self, leaving: Phase, how: AtEnd, instant: Instant) -> None:
        """Record how an end of the slope is passed; the energy still in an elastic stop is lost."""
        end = min(self.problem.machine.extent, key=lambda place: abs(place - instant.slip))
        self.record.passages.append(Passage(self._now.t, how, instant.slip, end))
        law = self.problem.machine.contact_law
        if how is AtEnd.SLIDES_OFF and law is not None:
            self._quadratures()[STOP_LOSS] += law.energy(instant.gap, instant.slip, leaving.residual.compliance)

    def _jump(self, impulse: Impulse, probe: Probe) -> None:
        """Change the velocities by an impulse."""
        d, jump = self.problem.q0.size, probe.velocity_jump(impulse)
        self._quadratures()[SUPPLIED] += probe.supply(impulse, jump)
        self._y[d : 2 * d] += jump

    def _account_for_penetration(self, leaving: Phase, gap: float) -> None:
        """Charge the scheme with the energy of an elastic stop that contact finds or leaves compressed.

        Located contacts begin and end at zero gap; a fixed step notices them late.
        """
        law = self.problem.machine.contact_law
        if law is None or (leaving.state == State.FREE) == (self._phase.state == State.FREE):
            return
        found = -1.0 if leaving.state == State.FREE else 1.0
        compliance = max(leaving.residual.compliance, self._phase.residual.compliance)
        self._quadratures()[STABILIZATION_LOSS] += found * law.energy(gap, 0.0, compliance)

    def _track_contact(self, leaving: Phase, impulse: Impulse, kind: EventKind | None) -> Contact | None:
        """Open or close a contact; returns the share of the finite force of one that is closed."""
        if leaving.state == State.FREE and kind is not None:
            self._open = OpenContact(
                self._now.t, impulse, self._quadratures().copy(), self._phase.residual.compliance
            )
        return self._close_contact() if self._phase.state == State.FREE else None

    def _close_contact(self) -> Contact | None:
        if self._open is None:
            return None
        contact, finite = self._open.closed(self._now.t, self._quadratures(), self.problem.machine.contact_law)
        self.record.contacts.append(contact)
        self._open = None
        return finite

    def _quadratures(self) -> Array:
        return self._y[2 * self.problem.q0.size :][:QUADRATURES]

    def _watch_for_chattering(self) -> None:
        t = self._now.t
        cluster = _CLUSTER_TIME * self.problem.end_time
        if len(self._recent) == _CLUSTER and t - self._recent[0] < cluster:
            raise RunEnded(Outcome.CHATTERING)
        self._recent.append(t)
        if len(self.record.events) > MAX_EVENTS:
            raise RunEnded(Outcome.TOO_MANY_EVENTS)

    def _enter(self, leaving: Phase | None) -> None:
        """Begin a phase: sample its right-hand values and arm its guards.

        Output samples continue with the next multiple of the interval.
        """
        t, self._before = self._now.t, leaving
        passed = int(np.floor(t / self.problem.output_interval * (1.0 + 1e-14) + 1e-9))
        self._scratch.samples.counts[NEXT] = passed + 1
        self._now = StepState(t, self._now.h, t, 0, 0)
        # what a scheme keeps ends with a phase
        self.problem.scheme.fill_extra_state(self.prepared, self._phase, self._y, self._y[self._kept :])
        contact = self._sample(self._phase)
        self._set_mark()
        guards = guard_values(self._phase, contact)
        turned = slides_stretching(self._phase.arrays, self._phase) and self._stretch(guards)
        arm(self._phase, self._scratch, guards)
        if turned:  # where its force has jumped a contact may hold again at once
            self._pass_guard(turned[0])

    def _stretch(self, guards: Array) -> list[int]:
        """Add to guards where a phase begins as :func:`~oblique_impact.marching.search.take_guards` does.

        Returns those of contacts that would slide against their own direction.
        """
        plain = guards.copy()
        system, phase, t, work = self.problem.system, self._phase, self._now.t, self._scratch.work
        before, after = nearby(t, self._scratch.tolerances)
        dy, spare = np.empty((2, self._y.size))
        take_derivative(system, phase, t, self._y, work, dy)
        for at, sign in ((before, -1.0), (after, 1.0)):
            _, c = take_derivative(system, phase, at, self._y + (at - t) * dy, work, spare)
            add_stretch(phase.arrays, phase, c, sign / (after - before), guards)
        return np.flatnonzero((guards != plain) & (guards < -self._scratch.tolerances.velocity)).tolist()

    def _sample(self, phase: Phase) -> Instant:
        """Store the present state as a sample; returns the contact there.

        The forces of the sample are inside of the friction cone: a scheme that notices transitions late, or
        decides on means, leaves a state, or begins one, with others.
        """
        times, states = np.array([self._now.t]), self._y[None, :]
        found = self._observe(phase, times, states)
        kept, inside = found, phase
        while (changed := inside_cones(inside, kept.instants[0], kept.contacts[0])) is not inside:
            inside = changed
            kept = self._observe(inside, times, states)
        self._store(phase, times, states, kept)
        return Instant(*found.instants[0].tolist())

    def _keep(self, progress: MarchResult) -> None:
        """Store the samples, changes and costs of a call; only those before the deflection grows too large."""
        self.record.steps += progress.steps
        self.record.rejected += progress.rejected
        count = progress.samples
        times, states = self._scratch.samples.times[:count].copy(), self._scratch.samples.states[:count]
        large = self._large_deflection(states)
        if large.any():
            count = int(np.argmax(large))
            self._now, self._y[:] = self._now._replace(t=float(times[count])), states[count]
        if count:
            times, states = times[:count], states[:count]
            self._log_changes(float(times[-1]))
            self._store(self._phase, times, states, self._observe(self._phase, times, states))
            self._set_mark(float(times[-1]), states[-1])
        self._log_changes(self._now.t)
        if not large.any():
            self._take_peaks(progress)
        if large.any() or self._large_deflection(self._y[None]).any():
            raise RunEnded(self._cause(Outcome.LARGE_DEFLECTION))

    def _log_changes(self, until: float) -> None:
        """Log the changes up to a time (s) of a scheme that makes them itself; by default there are none."""

    def _take_peaks(self, progress: MarchResult) -> None:
        """Take the largest force and depth of a call."""
        if self._open is not None:
            self._open.peak_force = max(self._open.peak_force, progress.peak_force)
            self._open.depth = max(self._open.depth, progress.depth)

    def _large_deflection(self, states: Array) -> NDArray[np.bool_]:
        """Whether deflections are beyond the model's range, of state vectors (samples, ny)."""
        deflection = self.problem.relative_deflection
        if deflection is None:
            return np.zeros(states.shape[0], dtype=np.bool_)
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray(deflection(states[:, : self.problem.q0.size]) > LARGEST_DEFLECTION)

    def _observe(self, phase: Phase, times: Array, states: Array) -> Observation:
        return observe(self.problem.system, phase, times, states, self._scratch.work)

    def _store(self, phase: Phase, times: Array, states: Array, observation: Observation) -> None:
        """Store samples of a phase as they have been observed."""
        if self._open is not None and times.size:
            forces, gaps = observation.column("normal_force"), observation.column("gap")
            self._open.peak_force = float(np.fmax.reduce(forces, initial=self._open.peak_force))
            self._open.depth = float(np.fmax.reduce(-gaps, initial=self._open.depth))
        kept = states[:, : self._kept].copy()
        of_stops = self._of_stops(phase, observation, kept)
        self.record.segments.append(Segment(phase.state, times, kept, observation, *of_stops))

    def _of_stops(self, phase: Phase, observation: Observation, states: Array) -> tuple[Array, Array, Array]:
        """Return what a segment holds of stops behind the observation, each (samples,)."""
        compression = self._compression(phase, observation)
        stored, stretched = (of(phase, observation, states) for of in (self._stored, self._stretched))
        return compression, stored, stretched

    def _compression(self, phase: Phase, observation: Observation) -> Array:
        """Compression (m) of the stop itself, 0 of a rigid one and in flight."""
        law, gap = self.problem.machine.contact_law, observation.column("gap")
        if law is None or phase.state == State.FREE:
            return np.zeros_like(gap)
        rate, force = observation.column("gap_rate"), observation.column("normal_force")
        return law.compression(phase.residual, gap, rate, force)

    def _stored(self, phase: Phase, observation: Observation, states: Array) -> Array:
        """Energy (J) that an elastic stop, and the residual flexibility with it, holds at samples."""
        law, gap = self.problem.machine.contact_law, observation.column("gap")
        if law is None or phase.state == State.FREE:
            return np.zeros_like(gap)
        return law.energies(gap, observation.column("slip"), phase.residual.compliance)

    def _stretched(self, phase: Phase, observation: Observation, states: Array) -> Array:
        """Energy (J) that the axial flexibility behind the friction holds at samples."""
        # no number where no force solves the contact (Painleve)
        force = np.nan_to_num(observation.column("tangential_force"))
        flexibility = 0.0 if phase.state == State.FREE else phase.stick.compliance
        return np.asarray(0.5 * flexibility * force**2)

"""The only loop: advance a phase, locate the event, apply the transition, record.

It is the same for every system, discretization and scheme.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.decision import inclined
from oblique_impact.contact.degenerate import ALTERNATING
from oblique_impact.contact.forces import (
    add_stretch,
    guard_values,
    shared_flexibility,
    slides_stretching,
    travelled,
)
from oblique_impact.contact.impacts import Impulse
from oblique_impact.contact.log import Event, Passage
from oblique_impact.contact.state import RESPONSE, Candidate, Contacts, State
from oblique_impact.contact.transitions import AtEnd, Earlier, EventKind, Transition
from oblique_impact.errors import Outcome, RunEnded
from oblique_impact.kernels.jit import is_compiled
from oblique_impact.kernels.workspace import FREE_ACCELERATION, Array
from oblique_impact.marching import advance as base
from oblique_impact.marching.advance import Limits, MarchResult, StepState, march
from oblique_impact.marching.book import Book, OpenContact
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
    TRAVEL,
)
from oblique_impact.marching.probe import Probe
from oblique_impact.marching.problem import Problem
from oblique_impact.marching.records import Record
from oblique_impact.marching.sampling import Observation, observe, solve_problem, take_derivative
from oblique_impact.marching.scheme import Prepared, Task
from oblique_impact.marching.search import nearby
from oblique_impact.marching.segments import inside_cones, segment_of
from oblique_impact.marching.step_log import LoggedChange
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
#: so often an impact with restitution has opened a contact a moment ago before its impacts are said to alternate
_OPENINGS = 3
#: of the tolerance of gaps: a contact that an impact has opened a moment ago is no farther away
_JUST_OPENED = 1e3
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
    contacts: Any
    open: dict[int, OpenContact]  # contacts that are closed there
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
        self.problem, self.decision, self.pairs = problem, problem.decision, problem.decision.pairs
        self.record = Record()
        self._report = on_progress
        size, n = problem.q0.size, len(self.pairs)
        integrals = np.zeros(QUADRATURES + OF_A_CONTACT * n)
        extra = np.full(problem.scheme.extra_state(size, n, integrals.size), np.nan)
        self._y = np.concatenate([problem.q0, problem.qd0, integrals, extra])
        self._kept = self._y.size - extra.size  # entries of the state that samples keep, not those of the scheme
        work = problem.system.new_workspace()
        tolerances = problem.decision.tolerances
        self._scratch = new_scratch(work, self._y.size, problem.scales, tolerances, n)
        times, decision = (problem.output_interval, problem.end_time), problem.decision
        friction, restitution = decision.friction, decision.impact_law.restitution
        task = Task(size, n, self._y.size, *times, friction, restitution, problem.modes, problem.compliance)
        own = problem.scheme.buffers(task._replace(elastic=decision.compliant))
        packed, law = is_compiled(problem.system), problem.decision.law
        free = [
            self.decision.free(i, -1.0 if pair.behind else 1.0).changed(enabled=int(problem.contact))
            for i, pair in enumerate(self.pairs)
        ]
        # located contacts see that of elastic stops across the body; along it, it is in their own records
        bent = problem.compliance
        if bent is not None and not (problem.scheme.decides or (decision.compliant and bent.bends)):
            bent = None
        self.contacts = Contacts.new(free, size, packed, law, bent)
        self._spare = Contacts.new(free, size, packed, law, bent)
        self.prepared = Prepared(problem.system, self.contacts, self._scratch, own)
        self._steps = problem.scheme.step_log(self.prepared)  # None: the transition table decides
        self._now = StepState(0.0, 1e-3 * problem.output_interval, 0.0, 0, 0)
        self._book = Book(self.pairs, self.record.events, self.record.contacts)
        # s, when impacts have opened each contact the last times.  Of plastic ones one is enough; others follow
        # each other by chance, but only a few times
        openings = 1 if restitution == 0.0 else _OPENINGS
        self._left = [deque[float]([-np.inf] * openings, maxlen=openings) for _ in range(n)]
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
            self._enter()
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
            self._sample()
        self._close_open_contacts()
        return record

    def _set_mark(self, t: float | None = None, y: Array | None = None) -> None:
        """Mark where the run is, or its last sample at a time (s) with a state vector, to return to it."""
        counts = [len(entries) for entries in self._recorded()]
        now, state = self._now if t is None else self._now._replace(t=t), self._y if y is None else y
        self._mark = _Mark(now, state.copy(), self.contacts.copied(), self._book.copy_open(), counts)

    def _return_to_mark(self) -> None:
        """Return to the last mark: what has been recorded since then belongs to no state."""
        mark = self._mark
        self._now, self._y[:] = mark.now, mark.y
        self.contacts.restore(mark.contacts)
        self._book.open = mark.open
        for entries, count in zip(self._recorded(), mark.counts, strict=True):
            del entries[count:]

    def _recorded(self) -> tuple[list[Any], ...]:
        """Return the lists of the record."""
        record = self.record
        return record.segments, record.events, record.contacts, record.passages, record.ambiguous

    def _begin(self) -> None:
        """Find the contact state at t = 0, which may be an impact; steps that decide find it themselves."""
        if self._steps is None:
            self._pass(self._start)
            return
        probe, earlier = self._probe(), self.problem.earlier
        if earlier:
            places = {i: probe.of(i) for i in earlier}
            self.problem.scheme.resume(self.prepared, earlier, places, self._accelerated(earlier, probe))
        self._enter_changes(self._steps.changes())

    def _accelerated(self, earlier: Mapping[int, Earlier], probe: Probe) -> Array:
        """Return the accelerations (d,) at the start of a run under the forces of contacts that go on."""
        d, spare, work = self.problem.q0.size, self._spare, self._scratch.work
        for i in range(len(self.pairs)):
            c = probe.of(i)
            closed = self.decision.opened(i, c).changed(state=State.SLIP)
            spare.take(i, closed if i in earlier else c)
        solve_problem(self.problem.system, spare, 0.0, self._y[:d], self._y[d : 2 * d], work, np.zeros(1))
        acceleration: Array = work.vectors[FREE_ACCELERATION].copy()
        for i, of in earlier.items():
            normal = of.normal_force - spare.of(i).tilt * of.tangential_force
            acceleration += spare.rows[RESPONSE, i, :2].T @ np.array([normal, of.tangential_force])
        return acceleration

    def _start(self) -> Outcome | None:
        probe = self._probe()
        change = self.decision.start(probe, self.problem.earlier)
        # those that go on, or are pressed in, have been closed before
        pressed = [
            i for i in change.states if self.decision.compliant and probe.of(i).gap < -self.decision.tolerances.gap
        ]
        if any(i not in self.problem.earlier and i not in pressed for i, _ in change.events):
            self._sample()
        return self._apply(change, probe)

    def _states(self) -> list[Candidate]:
        """Return copies of all candidates."""
        return [self.contacts.of(i) for i in range(len(self.contacts.each))]

    def _take_states(self, states: Mapping[int, Candidate]) -> None:
        """Take new states of some candidates."""
        for i, state in states.items():
            self.contacts.take(i, state.changed(enabled=int(self.problem.contact)))

    def _states_at(self, samples: Array) -> NDArray[np.int8]:
        """Return the states of all contacts, (samples, n), at samples of a phase (samples, ny)."""
        if self._steps is not None:
            return self._steps.states(samples)
        found = np.empty((len(samples), len(self.pairs)), dtype=np.int8)
        found[:] = self.contacts.states()
        return found

    @property
    def _leading(self) -> State:
        """The state reported for all contacts together: slip where several are closed."""
        closed = [state for state in self._states_at(self._y[None])[0].tolist() if state != State.FREE]
        return State(closed[0]) if len(closed) == len(self.contacts.each) == 1 else State(min(len(closed), 1))

    def _pass(self, change: Callable[[], Outcome | None]) -> None:
        """Pass a transition by a function that decides and applies it, all of it or nothing.

        Where no contact state exists behind it the function returns the outcome that ends the run there.
        """
        self._set_mark()
        try:
            failure = change()
        except RunEnded:
            self._return_to_mark()
            raise
        if failure is not None:
            raise RunEnded(failure)

    def _march_to(self, end: float) -> None:
        problem = self.problem
        while True:
            bounds = float(end), float(problem.end_time), float(problem.output_interval)
            limits = Limits(*bounds, self._steps_per_call)
            stepper = problem.scheme.stepper(self.prepared, limits)
            progress = march(stepper, self._now, self._y)
            self._now = progress.state
            self._keep(progress)
            if len(self.record.events) > MAX_EVENTS:
                raise RunEnded(Outcome.TOO_MANY_EVENTS)
            if self._report is not None:
                self._report(Status(self._now.t, problem.end_time, self._leading, len(self.record.events)))
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
            sliding = self._leading == State.SLIP
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
            remedy = f'solver.scheme = "{self._stepping}", whose steps the fastest vibration does not shorten'
            raise RunEnded(Outcome.TOO_MANY_STEPS, f"{words}; use {remedy}, or a shorter end_time.")
        seconds = (needed - taken) * (perf_counter() - self._started) / taken
        if before == 0 and seconds > LONG and self._report is not None:
            notice = f"about {seconds / 60.0:.0f} minutes to go, {needed:.2g} steps in all"
            if self.problem.scheme.name == "event":
                notice += f'; solver.scheme = "{self._stepping}" takes longer ones'
            status = Status(time, self.problem.end_time, self._leading, len(self.record.events), notice)
            self._report(status)

    @property
    def _stepping(self) -> str:
        """Name of the scheme that marches such stops by steps of a given length."""
        rigid = self.problem.contact and not self.decision.compliant
        return "time-stepping" if rigid else "generalized-alpha"

    def _inertia(self) -> float:
        """Smallest eigenvalue of the mass matrix now, or what the system has in its place."""
        d, y, work, rank_one = self.problem.q0.size, self._y, self._scratch.work, np.zeros(1)
        self._spare.restore(self.contacts.copied())
        solve_problem(self.problem.system, self._spare, self._now.t, y[:d], y[d : 2 * d], work, rank_one)
        return float(self.problem.system.definiteness(float(rank_one[0]), work))

    def _relative_inertia(self) -> float:
        """Effective inverse normal mass of the sliding contacts now, relative to that without friction."""
        sliding = [c for c in self._states() if c.state == State.SLIP and not c.compliant]
        return min((c.definite for c in sliding), default=1.0)

    def _pass_guard(self, guard: int) -> None:
        self._sample()
        self._pass(lambda: self._follow(guard))
        self._watch_for_chattering()
        self._enter()

    def _follow(self, guard: int) -> Outcome | None:
        probe, t = self._probe(), self._now.t
        tolerances = self.problem.decision.tolerances
        recent = ALTERNATING * tolerances.time
        lately = [
            i
            for i, left in enumerate(self._left)
            if t - left[0] < recent and abs(probe.of(i).gap) < _JUST_OPENED * tolerances.gap
        ]
        change = self.decision.after_guard(guard, lately, probe)
        self._hand_over(change, probe)
        return self._apply(change, probe)

    def _probe(self) -> Probe:
        return Probe(self.problem, self.contacts, self._spare, self._now.t, self._y, self._scratch.work)

    def _hand_over(self, change: Transition, probe: Probe) -> None:
        """Hand an elastic contact that slides over the end of a side to the corner there, or back.

        A point of the beam at the depth d beyond the end of a side has the corner in the beam, within d of itself
        and deep by d times the cosine of the angle between beam and side.
        """
        hand_over = self.problem.hand_over
        for i in [i for i, how in change.passages if how is AtEnd.SLIDES_OFF and self.decision.compliant]:
            own = probe.of(i)
            for j, pair in enumerate(self.pairs):
                if pair.obstacle != self.pairs[i].obstacle:
                    continue
                if pair.on_side == self.pairs[i].on_side:
                    continue
                if hand_over is not None and hand_over.get(i) != j:
                    continue
                other = probe.of(j)
                apart = self.pairs[i].place(own.slip) - pair.place(other.slip)
                meets = hand_over is not None or not pair.is_beyond(other.slip)
                if other.state == State.FREE and other.gap < 0.0 and abs(apart) < -own.gap and meets:
                    change.states[j] = self.decision.pressed(j, probe)
                    change.events.append((j, EventKind.IMPACT))

    def _apply(self, change: Transition, probe: Probe) -> Outcome | None:
        """Apply impulses, log events, open and close contacts, take the new states; why the run ends here."""
        d, t = self.problem.q0.size, self._now.t
        before = {i: probe.of(i) for i in {*change.states, *change.impulses}}
        impulses = change.impulses | change.stick_projections
        if impulses:
            self._quadratures()[SUPPLIED] += probe.supply(impulses)
            self._y[d : 2 * d] += probe.velocity_jump(impulses)
        for i, projection in change.stick_projections.items():
            self._own(i)[[NORMAL_IMPULSE, TANGENTIAL_IMPULSE, FRICTION_LOSS]] += projection
        for i, how in change.passages:
            self._pass_end(i, how, before[i])
        self._stick_axially(change, before)
        self._take_states(change.states)
        # of elastic contacts compliances and forces at rest depend on which are closed
        after = self._probe() if impulses or self.decision.compliant else probe
        if self.decision.compliant:
            self._account_for_penetrations(change, probe, after)
        struck = dict(change.impulses)
        for i, kind in change.events:
            impulse = struck.pop(i, Impulse(0.0, 0.0, 0.0)) if kind.impulsive else Impulse(0.0, 0.0, 0.0)
            was, now, c = before[i], after.of(i), self.contacts.of(i)
            event = Event(
                t,
                kind,
                impulse.normal,
                impulse.tangential,
                was.gap_rate,
                now.slip_rate,
                impulse.energy_loss,
                State(c.state),
            )
            self._book.visit(i, was.slip)
            self._book.enter(i, event, was.slip, self._own(i).copy(), c.compliance)
            if event.state == State.FREE and change.impulses:
                self._left[i].append(t)
        if change.ambiguous:
            self.record.ambiguous.append(t)
        return change.failure

    def _stick_axially(self, change: Transition, before: Mapping[int, Candidate]) -> None:
        """Begin stick on axial flexibility: contacts hold the material where it is.

        That is their slip or, since rolling is none, their travel, and what all forces stretch the axis up to
        there.
        """
        pulls = [(c, c.tangential_force) for c in self._states() if c.state != State.FREE]
        pulls += [(change.states[i], force) for i, force in change.pulls.items()]
        for i, state in change.states.items():
            if state.axial != 0.0 and state.state == State.STICK:
                was = before[i] if before[i].state != State.FREE else inclined(before[i])
                held = travelled(was.changed(held=state.held, travel=float(self._own(i)[TRAVEL])))
                held += sum(shared_flexibility(state, other) * force for other, force in pulls)
                change.states[i] = state.changed(kept_slip=held)

    def _pass_end(self, contact: int, how: AtEnd, c: Candidate) -> None:
        """Record how an end of a side is passed."""
        pair = self.pairs[contact]
        if pair.on_side or how is AtEnd.SLIDES_OFF:
            end = min(pair.extent, key=lambda place: abs(place - c.slip))
            self.record.passages.append(Passage(self._now.t, how, c.slip, end, pair.obstacle))

    def _account_for_penetrations(self, change: Transition, before: Probe, after: Probe) -> None:
        """Account for the energy of stops that are found or left compressed.

        It is the scheme's where fixed steps notice contacts late, and the stop's that a beam slides off: less what
        it hands over.
        """
        least = self.problem.decision.tolerances.gap
        if not change.passages and all(abs(before.of(i).gap) <= least for i in change.states):
            return  # located, where nothing is pressed in
        lost, criterion = self._held(before) - self._held(after), self.decision.stick_criterion
        if change.passages:
            self._own(change.passages[0][0])[STOP_LOSS] += lost
        elif criterion is None or not criterion.located:
            self._quadratures()[STABILIZATION_LOSS] += lost

    def _held(self, probe: Probe) -> float:
        """Energy (J) that elastic contacts hold."""
        total = 0.0
        for i, pair in enumerate(self.pairs):
            c = probe.of(i)
            if pair.contact_law is not None and c.state != State.FREE:
                compressed = max(0.0, max(0.0, c.depth) - c.compliance * c.rest_force)
                total += float(
                    pair.contact_law.energies(*np.array([[c.gap], [c.slip], [compressed], [c.rest_force]]))[0]
                )
        return total

    def _enter_changes(self, changes: Iterable[LoggedChange]) -> None:
        """Enter the changes of contact states that steps have made."""
        for contact, _, event, slip, own, counted in changes:
            if event.state == State.FREE:
                self._book.count(contact, counted)
            self._book.enter(contact, event, slip, own)

    def _close_open_contacts(self) -> None:
        """Close what is open at the end of a run."""
        slips = self.record.segments[-1].observation.column("slip")[-1]
        for i in list(self._book.open):
            if self._steps is not None:
                self._book.count(i, self._steps.counted(self._y, i))
            else:
                self._book.visit(i, float(slips[i]))
            self._book.close(i, self._now.t, self._own(i))

    def _own(self, contact: int) -> Array:
        """Return the integrals of one contact, (5,), a part of the state vector."""
        return self._y[2 * self.problem.q0.size + QUADRATURES :][OF_A_CONTACT * contact :][:OF_A_CONTACT]

    def _quadratures(self) -> Array:
        return self._y[2 * self.problem.q0.size :][:QUADRATURES]

    def _watch_for_chattering(self) -> None:
        t = self._now.t
        cluster = _CLUSTER_TIME * self.problem.end_time
        if len(self._recent) == _CLUSTER and t - self._recent[0] < cluster:
            raise RunEnded(Outcome.CHATTERING)
        self._recent.append(t)

    def _enter(self) -> None:
        """Begin a phase: sample its right-hand values and arm its guards.

        Output samples continue with the next multiple of the interval.
        """
        t = self._now.t
        passed = int(np.floor(t / self.problem.output_interval * (1.0 + 1e-14) + 1e-9))
        self._scratch.samples.counts[NEXT] = passed + 1
        self._now = StepState(t, self._now.h, t, 0, 0)
        # what a scheme keeps ends with a phase
        self.problem.scheme.fill_extra_state(self.prepared, self._y, self._y[self._kept :])
        guards, present = self._sample()
        self._set_mark()
        turned = slides_stretching(present) and self._stretch(guards)
        arm(present.each, self._scratch, guards)
        if turned:  # where its force has jumped a contact may hold again at once
            self._pass_guard(turned[0])

    def _stretch(self, guards: Array) -> list[int]:
        """Add to guards where a phase begins as :func:`~oblique_impact.marching.search.take_guards` does.

        Returns those of contacts that would slide against their own direction.
        """
        plain = guards.copy()
        system, contacts, t, work = self.problem.system, self.contacts, self._now.t, self._scratch.work
        before, after = nearby(t, self._scratch.tolerances)
        dy, spare = np.empty((2, self._y.size))
        take_derivative(system, contacts, t, self._y, work, dy)
        for at, sign in ((before, -1.0), (after, 1.0)):
            take_derivative(system, contacts, at, self._y + (at - t) * dy, work, spare)
            add_stretch(contacts.in_python(), sign / (after - before), guards)
        return np.flatnonzero((guards != plain) & (guards < -self._scratch.tolerances.velocity)).tolist()

    def _sample(self) -> tuple[Array, Contacts]:
        """Store the present state as a sample; returns the guards and, in plain Python, the contacts there.

        The forces of the sample are inside of the friction cone: a scheme that notices transitions late, or
        decides on means, leaves a state, or begins one, with others.
        """
        times, states = np.array([self._now.t]), self._y[None, :]
        found = self._observe(times, states)
        present = self.contacts.in_python()
        guards = guard_values(present)
        kept, inside = found, present.each
        while (changed := inside_cones(inside, kept)) != inside:
            inside = changed
            self._take_states(dict(enumerate(inside)))
            kept = self._observe(times, states)
        if inside is not present.each:
            self._take_states(dict(enumerate(present.each)))
        self._store(times, states, kept, present.each)
        return guards, present

    def _keep(self, progress: MarchResult) -> None:
        """Store the samples, changes and costs of a call; only those before the deflection grows too large."""
        self.record.steps += progress.steps
        self.record.rejected += progress.rejected
        count = progress.samples
        times, states = self._scratch.samples.times[:count].copy(), self._scratch.samples.states[:count]
        large = self._large_deflection(np.concatenate([states, self._y[None]]))  # the end is the last
        inside = not large[:count].any()
        if not inside:
            count = int(np.argmax(large))
            self._now, self._y[:] = self._now._replace(t=float(times[count])), states[count]
        changes, last = [] if self._steps is None else self._steps.changes(), 0.0
        if count:
            times, states = times[:count], states[:count]
            last = float(times[-1])
            self._enter_changes(change for change in changes if change.step_end <= last)
            self._store(times, states, self._observe(times, states), self._states())
            if progress.reason != base.AT_GUARD:  # where another mark follows at once
                self._set_mark(last, states[-1])
        self._enter_changes(change for change in changes if last < change.step_end <= self._now.t)
        if inside:
            self._take_peaks()
        if large.any():
            raise RunEnded(self._cause(Outcome.LARGE_DEFLECTION))

    def _take_peaks(self) -> None:
        """Take the largest force and depth of each contact in a call."""
        for i, peaks in enumerate(self.contacts.peaks()):
            self._book.press(i, *peaks)

    def _large_deflection(self, states: Array) -> NDArray[np.bool_]:
        """Whether deflections are beyond the model's range, of state vectors (samples, ny)."""
        deflection = self.problem.relative_deflection
        if deflection is None:
            return np.zeros(states.shape[0], dtype=np.bool_)
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray(deflection(states[:, : self.problem.q0.size]) > LARGEST_DEFLECTION)

    def _observe(self, times: Array, states: Array) -> Observation:
        return observe(self.problem.system, self.contacts, times, states, self._scratch.work)

    def _store(self, times: Array, states: Array, found: Observation, present: Sequence[Candidate]) -> None:
        """Store samples of a phase as they have been observed, with the contacts that are `present`."""
        kept, each = states[:, : self._kept].copy(), self._states_at(states)
        segment = segment_of(times, kept, each, found, present, self.pairs)
        if self._steps is None:
            self._book.observe(found)
        else:  # which count forces and places themselves
            segment.stored[:] = self._steps.held(states)
            segment.depth[:] = self._steps.compressed(states)
            segment.step[:] = self._steps.lengths(states)
        self.record.segments.append(segment)

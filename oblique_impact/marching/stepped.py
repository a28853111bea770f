"""A run by time-stepping: one phase from the start to the end, events from the log of its steps."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from oblique_impact.contact.complementarity import BACKWARDS, FORWARDS, OPEN, STUCK
from oblique_impact.contact.flexibility import Flexibility, end_step, take_places
from oblique_impact.contact.impacts import Impulse
from oblique_impact.contact.state import Candidate, State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.errors import Outcome, RunEnded
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching import loop
from oblique_impact.marching.advance import MarchResult
from oblique_impact.marching.equations import (
    FRICTION_LOSS,
    NORMAL_IMPULSE,
    OF_A_CONTACT,
    QUADRATURES,
    TANGENTIAL_IMPULSE,
)
from oblique_impact.marching.loop import Run
from oblique_impact.marching.problem import Problem
from oblique_impact.marching.records import Contact, Event
from oblique_impact.marching.sampling import Observation
from oblique_impact.marching.scheme import Prepared
from oblique_impact.marching.time_stepping import (
    COUNTED,
    HELD,
    IMPACT_NORMAL,
    IMPACT_TANGENTIAL,
    LEAST,
    LOGGED,
    MOST,
    OF_AN_IMPACT,
    OWN_NORMAL,
    PEAK,
    PLASTIC_LOSS,
    TIME,
    StepBuffers,
    TimeSteppingScheme,
)
from oblique_impact.progress import Status

_STATES = {BACKWARDS: State.SLIP, OPEN: State.FREE, FORWARDS: State.SLIP, STUCK: State.STICK}


class SteppedRun(Run):
    """A run over a problem with several contacts by time-stepping.

    A contact that closes is an impact, with the impulses of the steps that close it and the energy that they and
    all later normal impulses take; its release has the rest of the impulses, and of the energy the friction.
    Places without inertia have no impulses of impact, but lose what closing within a step takes.
    """

    def __init__(self, problem: Problem, on_progress: Callable[[Status], None] | None = None) -> None:
        super().__init__(problem, on_progress)
        assert isinstance(problem.scheme, TimeSteppingScheme)
        n, size = len(self.contacts.each), problem.q0.size
        friction, self._massless = self.machines.friction, problem.scheme.massless
        found = self.candidates.flexibility if friction.rubs or self._massless else None
        flexibility = (found or Flexibility.none()).at_rest()
        self._steps = StepBuffers.new(n, size, friction, flexibility)
        self.prepared = Prepared(problem.system, self.contacts, self._scratch, self._steps)
        self._began: dict[int, tuple[int, Array]] = {}  # event with which a contact has closed, and its log
        self._unlogged = deque[Array]()  # changes of the last call
        self._counted = np.zeros((n, COUNTED))  # at the start

    def _begin(self) -> None:
        """Begin in flight, but for contacts that go on from an earlier run: the first step finds others."""
        steps, flexibility, earlier = self._steps, self._steps.flexibility, self.problem.earlier
        own = self._y[2 * self.problem.q0.size + QUADRATURES : self._kept].reshape(-1, OF_A_CONTACT)
        probe = self._probe()
        for i, contact in earlier.items():
            at = probe.of(i)
            slips = BACKWARDS if contact.tangential_force > 0.0 else FORWARDS
            state = STUCK if contact.state == State.STICK else slips
            self._counted[i] = [OF_AN_IMPACT, 0.0, 0.0, 0.0, contact.normal_force, at.slip, at.slip]
            self._log(
                np.array([0.0, i, OPEN, state, at.slip, at.gap_rate, at.slip_rate, *[0.0] * 3, *self._counted[i]])
            )
            steps.states[i] = state
            self.contacts.take(i, self.contacts.of(i).changed(gap=at.gap, slip=at.slip, gap_rate=at.gap_rate))
        if earlier and flexibility.pressed.size:
            take_places(flexibility, float(self._y[0]), self.contacts.in_python())
            for i, contact in earlier.items():
                forces = contact.normal_force, contact.tangential_force
                flexibility.after[i] = float(flexibility.toward[i] @ forces)
            end_step(flexibility, 1.0)  # of any length
            own[:, HELD] = 0.5 * flexibility.pressed * flexibility.displaced

    def _enter(self) -> None:
        super()._enter()
        self._y[-self._counted.size :] = self._counted.ravel()
        self._set_mark()

    def _keep(self, progress: MarchResult) -> None:
        self._unlogged = deque(self._steps.log[: self._steps.logged[0]])
        super()._keep(progress)
        if len(self.record.events) > loop.MAX_EVENTS:
            raise RunEnded(Outcome.TOO_MANY_EVENTS)

    def _log_changes(self, until: float) -> None:
        while self._unlogged and self._unlogged[0][TIME] <= until:
            self._log(self._unlogged.popleft())

    def _copy_open(self) -> Any:
        return self._began.copy()

    def _take_open(self, known: Any) -> None:
        self._began = known

    def _held(self, states: Array) -> Array:
        of_contacts = states[:, 2 * self.problem.q0.size + QUADRATURES :]
        return np.asarray(of_contacts[:, HELD::OF_A_CONTACT].sum(axis=1))

    @property
    def _leading(self) -> State:
        """The state reported for all contacts together."""
        return State.SLIP if np.any(self._steps.states != OPEN) else State.FREE

    def _stored(self, states: Sequence[Candidate], found: Observation, y: Array) -> Array:
        return self._held(y) if self._massless else np.zeros(len(y))

    def _stretched(self, states: Sequence[Candidate], found: Observation, y: Array) -> Array:
        return np.zeros(len(y)) if self._massless else self._held(y)

    def _relative_inertia(self) -> float:
        """Return 1: impulses exist for every coefficient of friction."""
        return 1.0

    def _log(self, row: Array) -> None:
        """Make an event of a change of a contact's state, and a contact where one has opened."""
        time, contact, before, after = float(row[0]), int(row[1]), int(row[2]), int(row[3])
        slip, closing, slipping = (float(value) for value in row[4:7])
        kind = EventKind.REVERSAL
        if before == OPEN:
            kind = EventKind.IMPACT
        elif after == OPEN:
            kind = EventKind.RELEASE
        elif STUCK in (before, after):
            kind = EventKind.STICK if after == STUCK else EventKind.SLIP
        obstacle, place = self.candidates.obstacles[contact], self.candidates.place(contact, slip)
        event = Event(time, kind, 0.0, 0.0, closing, slipping, 0.0, _STATES[after], obstacle=obstacle, place=place)
        if kind is EventKind.IMPACT:
            self._began[contact] = len(self.record.events), row.copy()
        if kind is EventKind.RELEASE:
            event = event.with_share(self._close_stepped(contact, time, row[OWN_NORMAL:LOGGED], row[LOGGED:]))
        self.record.events.append(event)

    def _close_stepped(self, contact: int, time: float, own: Array, counted: Array) -> Contact:
        """Close a contact, `own` its impulses and friction loss (3,); returns the share behind its impact."""
        number, began = self._began.pop(contact)
        normal, tangential, friction = (float(value) for value in own - began[OWN_NORMAL:LOGGED])
        impact = Impulse(*(float(counted[k]) for k in (IMPACT_NORMAL, IMPACT_TANGENTIAL, PLASTIC_LOSS)))
        events = self.record.events
        events[number] = events[number]._replace(
            normal_impulse=impact.normal, tangential_impulse=impact.tangential, energy_loss=impact.energy_loss
        )
        places = sorted(self.candidates.place(contact, float(counted[k])) for k in (LEAST, MOST))
        peak = float(counted[PEAK])
        whole = Contact(
            float(began[0]),
            time,
            normal,
            tangential,
            peak,
            0.0,
            impact.energy_loss + friction,
            obstacle=self.candidates.obstacles[contact],
            first_place=places[0],
            last_place=places[1],
        )
        self.record.contacts.append(whole)
        return Contact(
            whole.start, time, normal - impact.normal, tangential - impact.tangential, peak, 0.0, friction
        )

    def _close_open_contacts(self) -> None:
        for contact in list(self._began):
            own = self._own_quadratures(contact)[[NORMAL_IMPULSE, TANGENTIAL_IMPULSE, FRICTION_LOSS]]
            counted = self._y[-COUNTED * len(self.contacts.each) :].reshape(-1, COUNTED)
            self._close_stepped(contact, self._now.t, own, counted[contact])

    def _store(self, times: Array, states: Array, found: Observation) -> None:
        """Store samples; between two changes of states they are a segment of their own."""
        present = self._states()
        n = len(present)
        each = states[:, -(1 + COUNTED) * n :][:, :n]
        each = np.where(np.isnan(each), OPEN, each).astype(int)
        ends = [0, *(np.flatnonzero(np.any(each[1:] != each[:-1], axis=1)) + 1), len(times)]
        for part in (slice(*pair) for pair in pairwise(ends)):
            for i, state in enumerate(each[part.start]):
                self.contacts.take(i, present[i].changed(state=int(_STATES[int(state)])))
            observed = Observation(*(values[part] for values in found))
            super()._store(times[part], states[part], observed)
        for i, candidate in enumerate(present):
            self.contacts.take(i, candidate)

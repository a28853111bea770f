"""A run with several contacts: the loop of one contact, with the bookkeeping of each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np

from oblique_impact.contact.impacts import Impulse
from oblique_impact.contact.several import coupled_instant, phase_of, row_of, shared_flexibility
from oblique_impact.contact.simultaneous import ALTERNATING, Change, Group
from oblique_impact.contact.state import (
    GAP,
    NORMAL_FORCE,
    SIDE,
    SLIP,
    STATE,
    TANGENTIAL_FORCE,
    ContactArrays,
    Instant,
    Phase,
    Residual,
    State,
)
from oblique_impact.contact.transitions import AtEnd, ContactProbe, EventKind
from oblique_impact.errors import Outcome
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.advance import MarchResult
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
from oblique_impact.marching.loop import Run
from oblique_impact.marching.probe import Probe
from oblique_impact.marching.problem import MultiContact, Problem
from oblique_impact.marching.records import Contact, Event, OpenContact, Passage, Segment
from oblique_impact.marching.sampling import Observation
from oblique_impact.progress import Status

#: of the tolerance of gaps: a contact that an impact has opened a moment ago is no farther away
_JUST_OPENED = 1e3


class _CoupledProbe:
    """A `ContactProbe` whose instant has the forces of other contacts in it."""

    def __init__(self, probe: Probe, instant: Instant) -> None:
        self._probe, self.instant = probe, instant

    @property
    def residual(self) -> Residual:
        return self._probe.residual

    def after(self, impulse: Impulse) -> Instant:
        return self._probe.after(impulse)

    def slip_rate_ahead(self) -> float:
        return self._probe.slip_rate_ahead()


class MultiContactProbe:
    """The contact problems of several contacts where a run is, see `oblique_impact.contact.simultaneous`."""

    def __init__(self, run: MultiContactRun) -> None:
        self._run, self._found = run, dict[int, Probe]()

    def of(self, contact: int) -> Probe:
        """Return the probe of one contact, as if there were no others."""
        if contact not in self._found:
            self._found[contact] = self._run.probe_of(contact)
        return self._found[contact]

    def coupled(self, contact: int) -> ContactProbe:
        """Return the probe of one closed contact with the present forces of the others."""
        return _CoupledProbe(self.of(contact), coupled_instant(self._run.solved, contact))

    def together(self, contacts: Sequence[int], impulses: Mapping[int, Impulse]) -> Group:
        """Return the problem of contacts with the velocities that impulses leave."""
        n, jump = len(contacts), self.velocity_jump(impulses)
        solved = [self.of(i).moved(jump) for i in contacts]
        delassus = np.empty((n, 2, n, 2))
        for a, (_, rows) in enumerate(solved):
            for b, (_, others) in enumerate(solved):
                pairs = (rows.normal, rows.tangential), (others.to_normal, others.to_tangential)
                delassus[a, :, b, :] = np.array(pairs[0]) @ np.array(pairs[1]).T
        instants = [instant for instant, _ in solved]
        laws = [self._run.contacts.machines.machines[i].contact_law for i in contacts]
        pushes = [
            float(law.end_pushes(np.array([c.gap]), np.array([c.slip]))[0]) if law else 0.0
            for law, c in zip(laws, instants, strict=True)
        ]
        for a, c in enumerate(instants if any(pushes) else []):
            gap, slip = delassus[a, :, :, 1] @ pushes
            instants[a] = c._replace(
                gap_acceleration=c.gap_acceleration + float(gap),
                slip_acceleration=c.slip_acceleration + float(slip),
            )
        return Group(instants, delassus)

    def velocity_jump(self, impulses: Mapping[int, Impulse]) -> Array:
        """Return q'+ - q'- by impulses, (d,)."""
        jumps = [self.of(i).velocity_jump(impulse) for i, impulse in impulses.items()]
        return np.sum(jumps, axis=0) if jumps else np.zeros(self._run.problem.q0.size)


class MultiContactRun(Run):
    """A run over a problem with several contacts."""

    def __init__(self, problem: Problem, on_progress: Callable[[Status], None] | None = None) -> None:
        super().__init__(problem, on_progress)
        assert problem.multi_contact is not None
        self.contacts: MultiContact = problem.multi_contact
        self._phase = self.contacts.machines.free()
        self._opened: dict[int, OpenContact] = {}
        self._places: dict[int, tuple[float, float]] = {}  # m, from where to where each open contact has been
        self._left: dict[int, float] = {}  # s, when an impact has opened a contact
        self._ends = np.array([machine.ends for machine in self.contacts.machines.machines]).T
        self._problems = [
            replace(problem, system=problem.system._replace(place=i), machine=machine)
            for i, machine in enumerate(self.contacts.machines.machines)
        ]

    def probe_of(self, contact: int) -> Probe:
        """Return the probe of one contact at the present state."""
        return Probe(
            self._problems[contact], self._state(self._phase, contact), self._now.t, self._y, self._scratch.work
        )

    def _state(self, phase: Phase, contact: int) -> Phase:
        assert phase.arrays is not None
        return phase_of(phase, phase.arrays, contact)

    def _begin(self) -> None:
        self._pass(self._start)

    def _start(self) -> Outcome | None:
        probe = MultiContactProbe(self)
        change = self.contacts.machines.start(self._phase, probe, self.problem.earlier)
        if change.events:
            self._sample(self._phase)
        return self._change(self._phase, change, probe)

    def _follow(self, leaving: Phase, guard: int) -> Outcome | None:
        probe, t = MultiContactProbe(self), self._now.t
        tolerances = self.problem.machine.tolerances
        recent = ALTERNATING * tolerances.time
        lately = [
            i
            for i, left in self._left.items()
            if t - left < recent and abs(probe.of(i).instant.gap) < _JUST_OPENED * tolerances.gap
        ]
        change = self.contacts.machines.after_guard(leaving, guard, lately, probe)
        self._hand_over(change, probe)
        return self._change(leaving, change, probe)

    def _hand_over(self, change: Change, probe: MultiContactProbe) -> None:
        """Hand an elastic contact that slides over the end of a side to the corner there, or back.

        A point of the beam at the depth d beyond the end of a side has the corner in the beam, within d of itself
        and deep by d times the cosine of the angle between beam and side.
        """
        contacts, machines = self.contacts, self.contacts.machines.machines
        for i in [i for i, how in change.passages if how is AtEnd.SLIDES_OFF and contacts.machines.compliant]:
            own = probe.of(i).instant
            for j, machine in enumerate(machines):
                if contacts.obstacles[j] != contacts.obstacles[i] or contacts.on_side[j] == contacts.on_side[i]:
                    continue
                if contacts.hand_over is not None and contacts.hand_over.get(i) != j:
                    continue
                other = probe.of(j).instant
                apart = contacts.place(i, own.slip) - contacts.place(j, other.slip)
                flies = self._state(self._phase, j).state == State.FREE
                meets = contacts.hand_over is not None or not machine.is_beyond(other.slip)
                if flies and other.gap < 0.0 and abs(apart) < -own.gap and meets:
                    change.phases[j] = machine.pressed(probe.of(j))
                    change.events.append((j, EventKind.IMPACT))

    def _change(self, leaving: Phase, change: Change, probe: MultiContactProbe) -> Outcome | None:
        """Apply impulses, log events, open and close contacts, take the new phase; why the run ends here."""
        machines, d, t = self.contacts.machines, self.problem.q0.size, self._now.t
        before = {i: probe.of(i).instant for i in {*change.phases, *change.impulses}}
        impulses = change.impulses | change.stick_projections
        jump = probe.velocity_jump(impulses)
        quadratures = self._quadratures()
        for i, impulse in impulses.items():
            quadratures[SUPPLIED] += probe.of(i).supply(impulse, jump)
        self._y[d : 2 * d] += jump
        for i, projection in change.stick_projections.items():
            self._add_to(i, projection.normal, projection.tangential, projection.energy_loss, 0.0)
        for i, how in change.passages:
            self._pass_end_of(i, leaving, how, before[i])
        self._stick_axially(change)
        self._phase = machines.changed(leaving, change.phases)
        self._account_for_penetrations(leaving, change, before)
        after = MultiContactProbe(self) if impulses else probe
        struck = dict(change.impulses)
        for i, kind in change.events:
            impulse = struck.pop(i, Impulse(0.0, 0.0, 0.0)) if kind.impulsive else Impulse(0.0, 0.0, 0.0)
            was, now = before[i], after.of(i).instant
            state = State(self._state(self._phase, i).state)
            event = Event(
                t,
                kind,
                impulse.normal,
                impulse.tangential,
                was.gap_rate,
                now.slip_rate,
                impulse.energy_loss,
                state,
                obstacle=self.contacts.obstacles[i],
                place=self.contacts.place(i, was.slip),
            )
            self.record.events.append(self._track(i, event, impulse))
            if state == State.FREE and change.impulses:
                self._left[i] = t
        return change.failure

    def _stick_axially(self, change: Change) -> None:
        """Begin stick on axial flexibility: contacts hold the material where it is.

        That is their travel, since rolling is no slip, and what all forces stretch the axis up to there.
        """
        solved = self.solved
        pulls = [
            (row, float(force))
            for row, force in zip(solved.rows, solved.instants[:, TANGENTIAL_FORCE], strict=True)
            if row[STATE] != State.FREE
        ] + [(np.array(row_of(change.phases[i])), force) for i, force in change.pulls.items()]
        for i, state in change.phases.items():
            if state.stick.compliance != 0.0 and state.state == State.STICK:
                held = float(self._y[2 * self.problem.q0.size + QUADRATURES + OF_A_CONTACT * i + TRAVEL])
                held += sum(shared_flexibility(np.array(row_of(state)), row) * force for row, force in pulls)
                change.phases[i] = state._replace(stick=state.stick._replace(slip=held))

    @property
    def _ambiguous(self) -> int:
        return self.contacts.machines.ambiguous

    def _pass_end_of(self, contact: int, leaving: Phase, how: AtEnd, instant: Instant) -> None:
        """Record how an end of a side is passed; the energy still in an elastic stop is lost."""
        machine = self.contacts.machines.machines[contact]
        if how is AtEnd.SLIDES_OFF and machine.contact_law is not None:
            self._add_to(contact, 0.0, 0.0, 0.0, machine.contact_law.energy(instant.gap, instant.slip))
        if self.contacts.on_side[contact] or how is AtEnd.SLIDES_OFF:
            end = min(machine.extent, key=lambda place: abs(place - instant.slip))
            passage = Passage(self._now.t, how, instant.slip, end, self.contacts.obstacles[contact])
            self.record.passages.append(passage)

    def _add_to(self, contact: int, normal: float, tangential: float, friction: float, stop: float) -> None:
        """Add impulses (N s) and losses by friction and stop (J) to the quadratures, of the contact and of all."""
        added, own = np.array([normal, tangential, friction, stop]), QUADRATURES + OF_A_CONTACT * contact
        self._quadratures()[[NORMAL_IMPULSE, TANGENTIAL_IMPULSE, FRICTION_LOSS, STOP_LOSS]] += added
        self._y[2 * self.problem.q0.size + own :][:TRAVEL] += added

    def _account_for_penetrations(self, leaving: Phase, change: Change, before: Mapping[int, Instant]) -> None:
        """Account for the energy of stops that are found or left compressed.

        It is the scheme's where fixed steps notice contacts late, and the stop's where a contact is handed over.
        """
        gone, criterion = [contact for contact, _ in change.passages], self.problem.machine.stick_criterion
        for i, state in change.phases.items():
            law, was = self.contacts.machines.machines[i].contact_law, self._state(leaving, i).state
            if law is not None and i not in gone and (was == State.FREE) != (state.state == State.FREE):
                energy = law.energy(before[i].gap, before[i].slip)
                if gone:
                    self._add_to(gone[0], 0.0, 0.0, 0.0, -energy)  # what it hands over is not lost
                elif criterion is None or not criterion.located:
                    self._quadratures()[STABILIZATION_LOSS] += -energy if was == State.FREE else energy

    @property
    def solved(self) -> ContactArrays:
        """The contacts as the last sample has solved them, which is that at the present state."""
        assert self._phase.arrays is not None
        return self._phase.arrays

    def _track(self, contact: int, event: Event, impulse: Impulse) -> Event:
        """Open or close the contact of an event; one that closes it gets the share of its finite force."""
        free = event.state == State.FREE
        opened = self._opened.get(contact)
        if opened is None and (event.kind is EventKind.REBOUND or not free or event.kind is EventKind.IMPACT):
            opened = OpenContact(self._now.t, impulse, self._own_quadratures(contact))
            self._opened[contact], self._places[contact] = opened, (event.place, event.place)
        elif opened is not None and event.kind.impulsive:
            opened.impulse = Impulse(*(a + b for a, b in zip(opened.impulse, impulse, strict=True)))
        if opened is None or not free or event.kind is EventKind.IMPACT:
            return event
        return event.with_share(self._close(contact, event.place))

    def _close(self, contact: int, place: float) -> Contact:
        """Close a contact at a place (m); returns the share of its finite force."""
        opened, machine = self._opened.pop(contact), self.contacts.machines.machines[contact]
        whole, finite = opened.closed(self._now.t, self._own_quadratures(contact), machine.contact_law)
        first, last = self._places.pop(contact)
        self.record.contacts.append(
            whole._replace(
                obstacle=self.contacts.obstacles[contact],
                first_place=min(first, place),
                last_place=max(last, place),
            )
        )
        return finite

    def _close_contact(self) -> None:
        slips = self.record.segments[-1].observation.contacts[-1, :, SLIP]
        for i in list(self._opened):
            self._close(i, self.contacts.place(i, float(slips[i])))

    def _copy_open(self) -> Any:
        return {i: copy(opened) for i, opened in self._opened.items()}, self._places.copy()

    def _take_open(self, known: Any) -> None:
        self._opened, self._places = known

    def _own_quadratures(self, contact: int) -> Array:
        """Return the quadratures of one contact alone, (7,)."""
        own = self._y[2 * self.problem.q0.size + QUADRATURES :][OF_A_CONTACT * contact :][:TRAVEL]
        found = np.zeros(QUADRATURES)
        found[[NORMAL_IMPULSE, TANGENTIAL_IMPULSE, FRICTION_LOSS, STOP_LOSS]] = own
        return found

    def _compression(self, phase: Phase, observation: Observation) -> Array:
        arrays, gaps = phase.arrays, observation.contacts[:, :, GAP]
        if arrays is None or not phase.stop.compliant:
            return np.zeros(len(gaps))
        closed = arrays.rows[:, STATE] != State.FREE
        return np.asarray(np.max(np.where(closed, np.maximum(-gaps, 0.0), 0.0), axis=1))

    def _stored(self, phase: Phase, observation: Observation, states: Array) -> Array:
        assert phase.arrays is not None
        each, stored = observation.contacts, np.zeros(len(states))
        for i, machine in enumerate(self.contacts.machines.machines):
            if machine.contact_law is not None and phase.arrays.rows[i, STATE] != State.FREE:
                stored += machine.contact_law.energies(each[:, i, GAP], each[:, i, SLIP])
        return stored

    def _stretched(self, phase: Phase, observation: Observation, states: Array) -> Array:
        assert phase.arrays is not None
        rows, forces = phase.arrays.rows, np.nan_to_num(observation.contacts[:, :, TANGENTIAL_FORCE])
        flexibility = np.array([[shared_flexibility(a, b) for b in rows] for a in rows])
        return np.asarray(0.5 * np.einsum("si,ij,sj->s", forces, flexibility, forces))

    def _relative_inertia(self) -> float:
        assert self._phase.arrays is not None
        closed = self._phase.arrays.rows[:, STATE] != State.FREE
        return float(np.min(self._phase.arrays.definite[closed], initial=1.0))

    def _take_peaks(self, progress: MarchResult) -> None:
        largest = self._scratch.guards.largest
        for i, opened in self._opened.items():
            opened.peak_force = max(opened.peak_force, float(largest[0, i]))
            opened.depth = max(opened.depth, float(largest[1, i]))
        largest[:] = 0.0

    def _store(self, phase: Phase, times: Array, states: Array, found: Observation) -> None:
        arrays = phase.arrays
        assert arrays is not None
        each, rows = found.contacts, arrays.rows
        for i, opened in self._opened.items():
            opened.peak_force = float(np.fmax.reduce(each[:, i, NORMAL_FORCE], initial=opened.peak_force))
            opened.depth = float(np.fmax.reduce(-each[:, i, GAP], initial=opened.depth))
            places = [self.contacts.place(i, slip) for slip in (each[:, i, SLIP].min(), each[:, i, SLIP].max())]
            first, last = self._places[i]
            self._places[i] = min(first, *places), max(last, *places)
        found = found._replace(instants=_nearest(rows[:, SIDE], self._ends, each, found.instants))
        states_now = tuple(int(state) for state in rows[:, STATE])
        kept = states[:, : self._kept].copy()
        state = max(states_now) if phase.state != State.FREE else int(State.FREE)
        of_stops = self._of_stops(phase, found, kept)
        self.record.segments.append(Segment(state, times, kept, found, *of_stops, states_now))


def _nearest(sides: Array, ends: Array, each: Array, instants: Array) -> Array:
    """Return instants (samples, 13): kinematics of the contact with the smallest gap, forces of all together."""
    within = (each[:, :, SLIP] >= ends[0]) & (each[:, :, SLIP] <= ends[1])
    gaps = np.where(within, sides * each[:, :, GAP], np.inf)
    nearest = np.argmin(gaps, axis=1)
    found: Array = each[np.arange(len(each)), nearest]
    for column in (NORMAL_FORCE, TANGENTIAL_FORCE):
        found[:, column] = each[:, :, column].sum(axis=1)
    found[:, TANGENTIAL_FORCE + 1 :] = instants[:, TANGENTIAL_FORCE + 1 :]
    return found


def run_of(problem: Problem, on_progress: Callable[[Status], None] | None = None) -> Run:
    """Return the run of a problem, with one contact or several."""
    return (MultiContactRun if problem.multi_contact else Run)(problem, on_progress)

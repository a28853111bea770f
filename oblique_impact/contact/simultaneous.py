"""Transitions of several contacts.

A contact that is alone follows the table of one contact, `oblique_impact.contact.transitions`.  Where others are
closed too, impulses and states follow from all of them together, see `oblique_impact.contact.complementarity`:
impacts are plastic and without friction, then accelerations decide which contacts stay closed and which stick.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from oblique_impact.contact.complementarity import Candidate, contact_forces, plastic_impulses
from oblique_impact.contact.forces import friction_ratio
from oblique_impact.contact.impacts import Impulse
from oblique_impact.contact.several import phase_of, row_of, shared_flexibility
from oblique_impact.contact.state import (
    DEFINITE,
    END,
    GUARDS,
    INTERCEPT,
    LOWER,
    NORMAL,
    STATE,
    SWITCHED,
    TANGENTIAL_FORCE,
    UPPER,
    VELOCITY,
    ContactArrays,
    Instant,
    Phase,
    State,
    Tolerances,
)
from oblique_impact.contact.transitions import (
    AtEnd,
    ContactMachine,
    ContactProbe,
    Earlier,
    EventKind,
    Transition,
    direction_of,
    stick_at,
)
from oblique_impact.errors import Outcome, RunEnded
from oblique_impact.kernels.workspace import Array

#: of the time scale: impacts that alternate between contacts in quicker succession have accumulated, and close
#: all.  Each comes after about a fifth of the time before, so that the rest of them takes less than this
ALTERNATING = 1e-7
#: of the largest rate of an impact, one that is rounding: drift of the constraints
_STILL = 1e-9
#: of the largest, an eigenvalue of the scaled Delassus matrix that is rounding: as the pivots of the constraints
_REDUNDANT = 1e-11


class Group(NamedTuple):
    """The contact problem of some contacts together, without contact forces."""

    instants: list[Instant]
    delassus: Array  # (n, 2, n, 2) accelerations of gap and slip by unit forces, normal or tangential

    def rates(self) -> Array:
        """Gap rates (m/s), (n,)."""
        return np.array([c.gap_rate for c in self.instants])

    def normal(self) -> Array:
        """Delassus matrix (n, n) of the normals."""
        return self.delassus[:, 0, :, 0]


class GroupProbe(Protocol):
    """The contact problems at the present state of a run, before and after impulses."""

    def of(self, contact: int) -> ContactProbe:
        """Return the probe of one contact, as if there were no others."""

    def coupled(self, contact: int) -> ContactProbe:
        """Return the probe of one closed contact with the present forces of the others."""

    def together(self, contacts: Sequence[int], impulses: Mapping[int, Impulse]) -> Group:
        """Return the problem of contacts with the velocities that impulses leave."""


@dataclass
class Change:
    """Changes by a transition: the states of contacts, events in their order, impulses by contact."""

    phases: dict[int, Phase] = field(default_factory=dict)
    events: list[tuple[int, EventKind]] = field(default_factory=list)
    impulses: dict[int, Impulse] = field(default_factory=dict)
    stick_projections: dict[int, Impulse] = field(default_factory=dict)
    passages: list[tuple[int, AtEnd]] = field(default_factory=list)
    failure: Outcome | None = None
    #: tangential forces (N) of contacts that go on from an earlier run
    pulls: dict[int, float] = field(default_factory=dict)

    @classmethod
    def of_one(cls, contact: int, transition: Transition) -> Change:
        """Return the transition of a contact that is alone."""
        change = cls({contact: transition.phase}, failure=transition.failure)
        if transition.kind is not None:
            change.events.append((contact, transition.kind))
        if transition.impulse is not None:
            change.impulses[contact] = transition.impulse
        if transition.stick_projection is not None:
            change.stick_projections[contact] = transition.stick_projection
        if transition.at_end is not None:
            change.passages.append((contact, transition.at_end))
        return change


class ContactMachines:
    """The transition table for several contacts, each with a table of its own for when it is alone.

    Parameters
    ----------
    machines : sequence of ContactMachine
        Of each contact; laws and tolerances are the same, ends and stiffness may differ.
    size : int
        Degrees of freedom of the system.
    """

    def __init__(self, machines: Sequence[ContactMachine], size: int) -> None:
        self.machines, first = machines, machines[0]
        self.tolerances: Tolerances = first.tolerances
        self.friction = first.friction
        self.speed = first.tolerances.velocity / VELOCITY  # m/s, of the motion itself
        self._closed = first.closed_phase
        self._ambiguous = 0
        self._start = ContactArrays.new(np.array([row_of(machine.free()) for machine in machines]), size)

    @property
    def ambiguous(self) -> int:
        """Number of decisions so far that had several solutions, of which one with fewest closed was taken."""
        return self._ambiguous + sum(machine.ambiguous for machine in self.machines)

    @property
    def compliant(self) -> bool:
        """Whether the stops are compliant."""
        return self.machines[0].contact_law is not None

    def free(self) -> Phase:
        """Return the phase of free flight."""
        return self.changed(self._closed._replace(arrays=self._start), {})

    def changed(self, phase: Phase, phases: Mapping[int, Phase]) -> Phase:
        """Return a phase with new states of some of its contacts."""
        assert phase.arrays is not None
        rows = phase.arrays.rows.copy()
        for contact, state in phases.items():
            rows[contact] = row_of(state)
        closed = rows[:, STATE] != State.FREE
        leading = int(State.SLIP if closed.any() else State.FREE)
        return phase._replace(state=leading, arrays=phase.arrays._replace(rows=rows))

    def start(self, phase: Phase, probe: GroupProbe, earlier: Mapping[int, Earlier] = {}) -> Change:
        """Return the states at the start of a run: contacts may touch, press already or go on from `earlier`."""
        touching, below = [], {}
        for i, machine in enumerate(self.machines):
            if i in earlier:
                continue
            instant = probe.of(i).instant
            beyond = machine.is_beyond(instant.slip)
            if instant.gap < -self.tolerances.gap and beyond:
                below[i] = machine.below()
            elif (
                not machine.is_apart(instant)
                and not beyond
                and not (machine.stick_criterion and machine.stick_criterion.located)  # falls in the first step
            ):
                touching.append(i)
        if len(touching) == 1:
            found = Change.of_one(touching[0], self.machines[touching[0]].touch(probe.of(touching[0])))
        elif self.compliant and self.machines[0].axial:
            pressed = {i: self.machines[i].pressed(probe.of(i)) for i in touching}
            found = Change(pressed, [(i, EventKind.IMPACT) for i in touching])
        elif self.compliant:
            found = self._decide(phase, touching, probe, Change())
        else:
            found = self._strike(phase, touching, [], probe) if touching else Change()
        found.phases |= below | {i: self.machines[i].resumed(of, probe.of(i).instant) for i, of in earlier.items()}
        found.events += [(i, EventKind.IMPACT) for i in earlier]
        found.pulls = {i: of.tangential_force for i, of in earlier.items()}
        return found

    def after_guard(self, phase: Phase, guard: int, lately: Sequence[int], probe: GroupProbe) -> Change:
        """Return the transition after a guard of a contact fell; raises RunEnded where no state exists.

        `lately` are contacts that an impact has opened a moment ago, see `ALTERNATING`.
        """
        arrays = phase.arrays
        assert arrays is not None
        (i, which), states = divmod(guard, GUARDS), arrays.rows[:, STATE]
        if guard >= GUARDS * len(states):
            i, which = guard - GUARDS * len(states), SWITCHED
        own, machine = phase_of(phase, arrays, i), self.machines[i]
        others = [int(j) for j in np.flatnonzero(states != State.FREE) if j != i]
        projects = machine.axial and own.state == State.SLIP and which in (LOWER, UPPER)
        if projects or (self.compliant and (machine.stick_criterion or machine.axial)):
            # the scheme itself distinguishes stick from slip: transitions of others come in the next steps; and no
            # force on axial flexibility jumps, so that none of another contact follows
            seen = probe.of(i) if own.state == State.FREE else probe.coupled(i)
            return Change.of_one(i, machine.after_guard(own, which, seen))
        if which == DEFINITE:
            return self._leave_singular(phase, [i, *others], probe)
        falls = own.state == State.FREE and own.surface.side > 0.0
        lands = falls and not machine.is_beyond(probe.of(i).instant.slip)
        if lands and not self.compliant and (others or lately):
            return self._strike(phase, [i], others, probe, lately)
        if not others or not (lands or own.state != State.FREE):
            return Change.of_one(i, machine.after_guard(own, which, probe.of(i)))
        if which == NORMAL and own.state != State.FREE:  # its force is 0: the others' stay as they are
            return Change({i: machine.free()}, [(i, EventKind.RELEASE)])
        if which == END:
            found = Change.of_one(i, machine.after_guard(own, which, probe.of(i)))
            return self._decide(phase, others, probe, found)
        if lands:
            return self._decide(phase, [i, *others], probe, Change())
        slip = own.state == State.SLIP
        kink = own.friction.upper if which == UPPER else own.friction.lower
        if slip and (self.friction.static is None or kink != 0.0):
            return Change.of_one(i, machine.after_guard(own, which, probe.of(i)))
        leaves = {} if slip else {i: 1 if which == UPPER else -1}
        return self._decide(phase, [i, *others], probe, Change(), at_rest=[i] if slip else [], leaves=leaves)

    def _leave_singular(self, phase: Phase, contacts: Sequence[int], probe: GroupProbe) -> Change:
        """Return other states of sliding contacts whose forces grow without bound; raises RunEnded without any."""
        try:
            found = Change() if self.machines[0].axial else self._decide(phase, contacts, probe, Change())
        except RunEnded:
            found = Change()
        if not found.events:
            raise RunEnded(self._reason(phase, contacts, probe))
        return found

    def _reason(self, phase: Phase, contacts: Sequence[int], probe: GroupProbe) -> Outcome:
        """Name why the forces of sliding contacts grow without bound: friction, or redundant constraints."""
        group = probe.together(contacts, {})
        assert phase.arrays is not None
        rubs = np.any(phase.arrays.rows[list(contacts), INTERCEPT] != 0.0)
        return Outcome.PAINLEVE if rubs and not _is_redundant(group.normal()) else Outcome.REDUNDANT_CONSTRAINTS

    def _strike(
        self,
        phase: Phase,
        touching: Sequence[int],
        closed: Sequence[int],
        probe: GroupProbe,
        lately: Sequence[int] = (),
    ) -> Change:
        """Return the plastic impact of touching contacts on a beam that others hold, and what follows it."""
        contacts = [*touching, *closed, *(i for i in lately if i not in touching and i not in closed)]
        group, change = probe.together(contacts, {}), Change()
        rates = group.rates()
        if np.min(rates) < -self.tolerances.velocity:
            if _is_redundant(group.normal()):
                raise RunEnded(Outcome.REDUNDANT_CONSTRAINTS)
            # those whose impacts alternate have accumulated: all are closed, whatever is left of their rates
            alternate = bool(lately)
            sizes = (
                np.linalg.solve(group.normal(), -rates) if alternate else plastic_impulses(group.normal(), rates)
            )
            after = rates + group.normal() @ sizes
            for i, size, mean in zip(contacts, sizes, 0.5 * (rates + after), strict=True):
                if size != 0.0:
                    change.impulses[i] = Impulse(float(size), 0.0, float(-size * mean))
            least = self.tolerances.velocity + _STILL * np.max(np.abs(rates))
            staying = [i for i, rate in zip(contacts, after, strict=True) if rate <= least]
        else:
            staying = contacts
        return self._decide(phase, staying, probe, change, [i for i in contacts if i not in staying])

    def _decide(
        self,
        phase: Phase,
        contacts: Sequence[int],
        probe: GroupProbe,
        change: Change,
        opened: Sequence[int] = (),
        at_rest: Sequence[int] = (),
        leaves: Mapping[int, int] = {},
    ) -> Change:
        """Add the states of contacts with zero gap rate, or on compliant stops, to a change, with their events.

        The contacts `opened` leave by an impact.  Of those `at_rest` the slip has just ended, those that `leaves`
        names have been stuck and begin to slip in the given direction.
        """
        arrays = phase.arrays
        assert arrays is not None
        states: dict[int, Phase] = {i: self.machines[i].free() for i in opened}
        if contacts:
            states |= self._states(phase, contacts, probe.together(contacts, change.impulses), at_rest, leaves)
        for i, state in states.items():
            before = phase_of(phase, arrays, i)
            struck, kind = i in change.impulses and change.impulses[i].normal > 0.0, None
            if before.state == State.FREE and state.state == State.FREE:
                kind = EventKind.REBOUND if struck else None
            elif struck or before.state == State.FREE:
                kind = EventKind.IMPACT
            elif state.state == State.FREE:
                kind = EventKind.RELEASE
            elif state.state != before.state:
                kind = EventKind.STICK if state.state == State.STICK else EventKind.SLIP
            elif state.state == State.SLIP and direction_of(state) * direction_of(before) < 0:
                kind = EventKind.REVERSAL
            if struck and kind is EventKind.IMPACT and state.state == State.FREE:
                change.events += [(i, EventKind.IMPACT), (i, EventKind.RELEASE)]
            elif kind is not None:
                change.events.append((i, kind))
            change.phases[i] = state
        return change

    def _states(
        self,
        phase: Phase,
        contacts: Sequence[int],
        group: Group,
        at_rest: Sequence[int],
        leaves: Mapping[int, int],
    ) -> dict[int, Phase]:
        """Decide by accelerations which contacts stay closed, which stick and which way the others slip."""
        arrays, static = phase.arrays, self.friction.static
        assert arrays is not None
        if self.machines[0].axial:
            group = self._on_axis(arrays, contacts, group)
        slips: dict[int, int] = {}
        several = False
        for i, c in zip(contacts, group.instants, strict=True):
            sticks = arrays.rows[i, STATE] == State.STICK
            still = self.tolerances.velocity + (_STILL * self.speed if sticks else 0.0)
            moving = abs(c.slip_rate) > still and i not in at_rest and i not in leaves
            slips[i] = leaves.get(i, _sign(c.slip_rate) if moving or static is None else 0)
        for _ in range(len(contacts) + 1):
            candidates = [
                self._candidate(i, c, slips[i], arrays.rows[i])
                for i, c in zip(contacts, group.instants, strict=True)
            ]
            free = np.array([[c.gap_acceleration, c.slip_acceleration] for c in group.instants])
            solution = contact_forces(group.delassus, free, candidates)
            several = several or solution.several
            begun = {
                i: _sign(a)
                for i, a, force in zip(contacts, solution.accelerations[:, 1], solution.forces, strict=True)
                if slips[i] == 0 and a != 0.0 and force[0] > 0.0
            }
            slips |= begun
            if not begun:
                break
        self._ambiguous += several
        found, kept = {}, []
        for i, c, force in zip(contacts, group.instants, solution.forces, strict=True):
            own, machine = phase_of(phase, arrays, i), self.machines[i]
            earlier = own if own.state != State.FREE else machine.opened(c.slip)
            if force[0] <= 0.0 and not self.compliant:
                found[i] = machine.free()
                continue
            kept.append(i)
            if slips[i] != 0:
                found[i] = machine.slide(earlier, 0.0 if i in leaves else c.slip_rate, slips[i])
            else:
                found[i] = own if own.state == State.STICK else stick_at(earlier, c)
        self._check(contacts, kept, found, group)
        return found

    def _on_axis(self, arrays: ContactArrays, contacts: Sequence[int], group: Group) -> Group:
        """Return the problem of rigid contacts with axial flexibility, whose slips are displacements at once.

        Without mass the material slides until the forces, which stretch the axis, are within the cones: in the
        place of the accelerations of slip stand the displacements, in units that leave the numbers of one size.
        """
        rows = arrays.rows.copy()
        for i, c in zip(contacts, group.instants, strict=True):
            if rows[i, STATE] == State.FREE:
                rows[i] = row_of(stick_at(self.machines[i].opened(c.slip), c))
        shared = np.array([[shared_flexibility(rows[i], row) for row in rows] for i in contacts])
        unit = group.delassus[0, 0, 0, 0] / shared[0, contacts[0]]
        # one that slides goes on, but for a cone that grows
        held = arrays.instants[:, TANGENTIAL_FORCE] * np.where(rows[:, STATE] == State.SLIP, 1.0 + _STILL, 1.0)
        moved, delassus = -unit * shared @ held, group.delassus.copy()
        delassus[:, 1, :, 0], delassus[:, 1, :, 1] = 0.0, unit * shared[:, contacts]
        instants = [
            c._replace(slip_rate=0.0, slip_acceleration=m) for c, m in zip(group.instants, moved, strict=True)
        ]
        return Group(instants, delassus)

    def _check(
        self, contacts: Sequence[int], kept: Sequence[int], states: Mapping[int, Phase], group: Group
    ) -> None:
        """Raise RunEnded if the constraints of the contacts that stay closed are redundant."""
        rows = [] if self.compliant else [(contacts.index(i), 0) for i in kept]
        rows += [(contacts.index(i), 1) for i in kept if states[i].state == State.STICK]
        if rows and _is_redundant(np.array([[group.delassus[*a, *b] for b in rows] for a in rows])):
            raise RunEnded(Outcome.REDUNDANT_CONSTRAINTS)

    def _candidate(self, i: int, instant: Instant, slip: int, row: Array) -> Candidate:
        """Return a contact with its direction of slip, 0 at rest, for the solution of all together."""
        machine, static = self.machines[i], self.friction.static
        if machine.axial and row[STATE] == State.SLIP:  # it has not stuck yet
            static = abs(float(row[INTERCEPT]))
        push = None if machine.contact_law is None else machine.contact_law.force(instant)
        sliding = machine.slide(machine.closed_phase, instant.slip_rate if slip else 0.0, slip or 1)
        ratio = friction_ratio(sliding, instant.slip_rate) if slip else 0.0
        return Candidate(slip, ratio, static or 0.0, push)


def _sign(value: float) -> int:
    return 1 if value >= 0.0 else -1


def _is_redundant(delassus: Array) -> bool:
    """Whether a symmetric Delassus matrix is singular but for rounding, its rows scaled to each other."""
    scale = np.sqrt(np.maximum(np.diag(delassus), 0.0))
    if np.min(scale) <= 0.0:
        return True
    values = np.linalg.eigvalsh(delassus / np.outer(scale, scale))
    return bool(values[0] <= _REDUNDANT * values[-1])

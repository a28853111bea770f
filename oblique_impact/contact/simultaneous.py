"""Transitions of several contacts.

A contact that is alone follows the table of one contact, `oblique_impact.contact.transitions`.  Where others are
closed too, impulses and states follow from all of them together, see `oblique_impact.contact.complementarity`:
impacts are plastic and without friction, then accelerations decide which contacts stay closed and which stick.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from oblique_impact.contact.complementarity import Closed, contact_forces, plastic_impulses
from oblique_impact.contact.forces import friction_ratio, shared_flexibility
from oblique_impact.contact.impacts import Impulse
from oblique_impact.contact.state import (
    DEFINITE,
    END,
    GUARDS,
    LOWER,
    NORMAL,
    SWITCHED,
    UPPER,
    VELOCITY,
    Candidate,
    State,
    Tolerances,
)
from oblique_impact.contact.transitions import (
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


class ContactMachines:
    """The transition table for several contacts, each with a table of its own for when it is alone.

    Parameters
    ----------
    machines : sequence of ContactMachine
        Of each contact; laws and tolerances are the same, ends and stiffness may differ.
    """

    def __init__(self, machines: Sequence[ContactMachine]) -> None:
        self.machines, first = machines, machines[0]
        self.tolerances: Tolerances = first.tolerances
        self.friction, self.stick_criterion = first.friction, first.stick_criterion
        self.speed = first.tolerances.velocity / VELOCITY  # m/s, of the motion itself
        self._ambiguous = 0

    @property
    def ambiguous(self) -> int:
        """Number of decisions so far that had several solutions, of which one with fewest closed was taken."""
        return self._ambiguous + sum(machine.ambiguous for machine in self.machines)

    @property
    def compliant(self) -> bool:
        """Whether the stops are compliant."""
        return self.machines[0].contact_law is not None

    def start(self, probe: ContactProbe, earlier: Mapping[int, Earlier] = {}) -> Transition:
        """Return the states at the start of a run: contacts may touch, press already or go on from `earlier`."""
        if len(self.machines) == 1:
            found = self.machines[0].start(probe, earlier.get(0))
            found.pulls = {i: of.tangential_force for i, of in earlier.items()}
            return found
        touching, below = [], {}
        for i, machine in enumerate(self.machines):
            if i in earlier:
                continue
            c = probe.of(i)
            beyond = machine.is_beyond(c.slip)
            if c.gap < -self.tolerances.gap and beyond:
                below[i] = machine.free(-1.0)
            elif (
                not machine.is_apart(c)
                and not beyond
                and not (machine.stick_criterion and machine.stick_criterion.located)  # falls in the first step
            ):
                touching.append(i)
        if len(touching) == 1:
            found = self.machines[touching[0]].touch(probe)
        elif self.compliant and self.machines[0].axial:
            pressed = {i: self.machines[i].pressed(probe) for i in touching}
            found = Transition(pressed, [(i, EventKind.IMPACT) for i in touching])
        elif self.compliant:
            found = self._decide(touching, probe, Transition())
        else:
            found = self._strike(touching, [], probe) if touching else Transition()
        found.states |= below | {i: self.machines[i].resumed(of, probe.of(i)) for i, of in earlier.items()}
        found.events += [(i, EventKind.IMPACT) for i in earlier]
        found.pulls = {i: of.tangential_force for i, of in earlier.items()}
        return found

    def after_guard(self, guard: int, lately: Sequence[int], probe: ContactProbe) -> Transition:
        """Return the transition after a guard of a contact fell; raises RunEnded where no state exists.

        `lately` are contacts that an impact has opened a moment ago, see `ALTERNATING`.
        """
        n = len(self.machines)
        i, which = divmod(guard, GUARDS) if guard < GUARDS * n else (guard - GUARDS * n, SWITCHED)
        own, machine = probe.of(i), self.machines[i]
        closed = own.state != State.FREE
        others = [j for j in range(n) if j != i and probe.of(j).state != State.FREE]
        if n == 1:
            return machine.after_guard(own, which, probe)
        projects = machine.axial and own.state == State.SLIP and which in (LOWER, UPPER)
        if projects or (self.compliant and (machine.stick_criterion or machine.axial)):
            # the scheme itself distinguishes stick from slip: transitions of others come in the next steps; and no
            # force on axial flexibility jumps, so that none of another contact follows
            return machine.after_guard(probe.coupled(i) if closed else own, which, probe)
        if which == DEFINITE:
            return self._leave_singular([i, *others], probe)
        lands = not closed and own.side > 0.0 and not machine.is_beyond(own.slip)
        if lands and not self.compliant and (others or lately):
            return self._strike([i], others, probe, lately)
        if not others or not (lands or closed):
            return machine.after_guard(own, which, probe)
        if which == NORMAL and closed:  # its force is 0: the others' stay as they are
            return Transition.to(i, machine.free(), EventKind.RELEASE)
        if which == END:
            return self._decide(others, probe, machine.after_guard(own, which, probe))
        if lands:
            return self._decide([i, *others], probe, Transition())
        slip = own.state == State.SLIP
        kink = own.upper if which == UPPER else own.lower
        if slip and (self.friction.static is None or kink != 0.0):
            return machine.after_guard(own, which, probe)
        leaves = {} if slip else {i: 1 if which == UPPER else -1}
        return self._decide([i, *others], probe, Transition(), at_rest=[i] if slip else [], leaves=leaves)

    def _leave_singular(self, contacts: Sequence[int], probe: ContactProbe) -> Transition:
        """Return other states of sliding contacts whose forces grow without bound; raises RunEnded without any."""
        try:
            found = Transition() if self.machines[0].axial else self._decide(contacts, probe, Transition())
        except RunEnded:
            found = Transition()
        if not found.events:
            raise RunEnded(self._reason(contacts, probe))
        return found

    def _reason(self, contacts: Sequence[int], probe: ContactProbe) -> Outcome:
        """Name why the forces of sliding contacts grow without bound: friction, or redundant constraints."""
        group, delassus = probe.together(contacts, {})
        rubs = any(c.intercept != 0.0 for c in group)
        return (
            Outcome.PAINLEVE if rubs and not _is_redundant(delassus[:, 0, :, 0]) else Outcome.REDUNDANT_CONSTRAINTS
        )

    def _strike(
        self, touching: Sequence[int], closed: Sequence[int], probe: ContactProbe, lately: Sequence[int] = ()
    ) -> Transition:
        """Return the plastic impact of touching contacts on a beam that others hold, and what follows it."""
        contacts = [*touching, *closed, *(i for i in lately if i not in touching and i not in closed)]
        group, delassus = probe.together(contacts, {})
        change, rates, normal = Transition(), np.array([c.gap_rate for c in group]), delassus[:, 0, :, 0]
        if np.min(rates) < -self.tolerances.velocity:
            if _is_redundant(normal):
                raise RunEnded(Outcome.REDUNDANT_CONSTRAINTS)
            # those whose impacts alternate have accumulated: all are closed, whatever is left of their rates
            alternate = bool(lately)
            sizes = np.linalg.solve(normal, -rates) if alternate else plastic_impulses(normal, rates)
            after = rates + normal @ sizes
            for i, size, mean in zip(contacts, sizes, 0.5 * (rates + after), strict=True):
                if size != 0.0:
                    change.impulses[i] = Impulse(float(size), 0.0, float(-size * mean))
            least = self.tolerances.velocity + _STILL * np.max(np.abs(rates))
            staying = [i for i, rate in zip(contacts, after, strict=True) if rate <= least]
        else:
            staying = contacts
        return self._decide(staying, probe, change, [i for i in contacts if i not in staying])

    def _decide(
        self,
        contacts: Sequence[int],
        probe: ContactProbe,
        change: Transition,
        opened: Sequence[int] = (),
        at_rest: Sequence[int] = (),
        leaves: Mapping[int, int] = {},
    ) -> Transition:
        """Add the states of contacts with zero gap rate, or on compliant stops, to a change, with their events.

        The contacts `opened` leave by an impact.  Of those `at_rest` the slip has just ended, those that `leaves`
        names have been stuck and begin to slip in the given direction.
        """
        states = {i: self.machines[i].free() for i in opened}
        if contacts:
            group, delassus = probe.together(contacts, change.impulses)
            states |= self._states(contacts, group, delassus, probe, at_rest, leaves)
        for i, state in states.items():
            before = probe.of(i)
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
            change.states[i] = state
        return change

    def _states(
        self,
        contacts: Sequence[int],
        group: Sequence[Candidate],
        delassus: Array,
        probe: ContactProbe,
        at_rest: Sequence[int],
        leaves: Mapping[int, int],
    ) -> dict[int, Candidate]:
        """Decide by accelerations which contacts stay closed, which stick and which way the others slip."""
        static = self.friction.static
        group = [
            c if c.state != State.FREE else self.machines[i].opened(c).changed(state=0)
            for i, c in zip(contacts, group, strict=True)
        ]
        if self.machines[0].axial:
            group, delassus = self._on_axis(contacts, group, delassus, probe)
        slips: dict[int, int] = {}
        several = False
        for i, c in zip(contacts, group, strict=True):
            still = self.tolerances.velocity + (_STILL * self.speed if c.state == State.STICK else 0.0)
            moving = abs(c.slip_rate) > still and i not in at_rest and i not in leaves
            slips[i] = leaves.get(i, _sign(c.slip_rate) if moving or static is None else 0)
        for _ in range(len(contacts) + 1):
            closed = [self._closed(i, c, slips[i]) for i, c in zip(contacts, group, strict=True)]
            free = np.array([[c.gap_acceleration, c.slip_acceleration] for c in group])
            solution = contact_forces(delassus, free, closed)
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
        for i, c, force in zip(contacts, group, solution.forces, strict=True):
            machine = self.machines[i]
            if force[0] <= 0.0 and not self.compliant:
                found[i] = machine.free()
                continue
            kept.append(i)
            if slips[i] != 0:
                found[i] = machine.slide(c, 0.0 if i in leaves else c.slip_rate, slips[i])
            else:
                found[i] = c if c.state == State.STICK else stick_at(c)
        self._check(contacts, kept, found, delassus)
        return found

    def _on_axis(
        self, contacts: Sequence[int], group: Sequence[Candidate], delassus: Array, probe: ContactProbe
    ) -> tuple[list[Candidate], Array]:
        """Return the problem of rigid contacts with axial flexibility, whose slips are displacements at once.

        Without mass the material slides until the forces, which stretch the axis, are within the cones: in the
        place of the accelerations of slip stand the displacements, in units that leave the numbers of one size.
        """
        every = [probe.coupled(j) for j in range(len(self.machines))]
        closed = [c for c in every if c.state != State.FREE]
        shared = np.array([[shared_flexibility(c, other) for other in group] for c in group])
        unit = delassus[0, 0, 0, 0] / shared[0, 0]
        delassus = delassus.copy()
        delassus[:, 1, :, 0], delassus[:, 1, :, 1] = 0.0, unit * shared
        moved = []
        for c in group:
            # one that slides goes on, but for a cone that grows
            held = sum(
                shared_flexibility(c, other)
                * other.tangential_force
                * (1.0 + _STILL if other.state == State.SLIP else 1.0)
                for other in closed
            )
            moved.append(c.changed(slip_rate=0.0, slip_acceleration=-unit * held))
        return moved, delassus

    def _check(
        self, contacts: Sequence[int], kept: Sequence[int], states: Mapping[int, Candidate], delassus: Array
    ) -> None:
        """Raise RunEnded if the constraints of the contacts that stay closed are redundant."""
        rows = [] if self.compliant else [(contacts.index(i), 0) for i in kept]
        rows += [(contacts.index(i), 1) for i in kept if states[i].state == State.STICK]
        if rows and _is_redundant(np.array([[delassus[*a, *b] for b in rows] for a in rows])):
            raise RunEnded(Outcome.REDUNDANT_CONSTRAINTS)

    def _closed(self, i: int, c: Candidate, slip: int) -> Closed:
        """Return a contact with its direction of slip, 0 at rest, for the solution of all together."""
        machine, static = self.machines[i], self.friction.static
        if machine.axial and c.state == State.SLIP:  # it has not stuck yet
            static = abs(c.intercept)
        push = None if machine.contact_law is None else machine.contact_law.force(c)
        sliding = machine.slide(c, c.slip_rate if slip else 0.0, slip or 1)
        return Closed(slip, friction_ratio(sliding) if slip else 0.0, static or 0.0, push)


def _sign(value: float) -> int:
    return 1 if value >= 0.0 else -1


def _is_redundant(delassus: Array) -> bool:
    """Whether a symmetric Delassus matrix is singular but for rounding, its rows scaled to each other."""
    scale = np.sqrt(np.maximum(np.diag(delassus), 0.0))
    if np.min(scale) <= 0.0:
        return True
    values = np.linalg.eigvalsh(delassus / np.outer(scale, scale))
    return bool(values[0] <= _REDUNDANT * values[-1])

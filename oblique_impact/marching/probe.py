"""The problem of all contacts where a run is, and after impulses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from oblique_impact.contact.elastic import stop_force
from oblique_impact.contact.impacts import Impulse
from oblique_impact.contact.state import DIRECTION, FREE, RESPONSE, SLIDING, Candidate, Contacts
from oblique_impact.errors import Outcome, RunEnded
from oblique_impact.kernels.workspace import FREE_ACCELERATION, SUPPLY, Array, Workspace
from oblique_impact.marching.problem import Problem
from oblique_impact.marching.sampling import solve_problem

#: in time scales: how far ahead the slip of a contact at rest is looked for.  Its velocity there is known to about
#: 1e-16 L/(a t^2) of itself, a the beam's acceleration in bending: at 1e-4 s its sign is right from 1e-6 m/s^2 on
_AHEAD = 1e-4
_ROUNDING = 1e-13  # of the terms of a slip velocity: some hundred units of rounding


class Probe:
    """The problem of all n contacts at the state y of a run, without contact forces.

    Parameters
    ----------
    problem : Problem
        What is marched.
    contacts : Contacts
        Their states; their forces are those of the last solution.
    spare : Contacts
        Of the same number, to be overwritten.
    t, y, work : float, ndarray, Workspace
        Where the run is, and its workspace.
    """

    def __init__(
        self, problem: Problem, contacts: Contacts, spare: Contacts, t: float, y: Array, work: Workspace
    ) -> None:
        size = work.vectors.shape[1]
        self._problem, self._spare, self._t, self._work = problem, spare, t, work
        self._present = [contacts.of(i) for i in range(len(contacts.each))]
        self._q, self._qd = y[:size].copy(), y[size : 2 * size].copy()
        self._struck: tuple[Mapping[int, Impulse], list[Candidate]] | None = None

    @cached_property
    def _solved(self) -> tuple[list[Candidate], Array, Array, Array]:
        """Contacts, their rows and responses (2, n, 2, d), supply and free acceleration (d,)."""
        found = self._solve(self._t, self._q, self._qd)
        vectors, rows = self._work.vectors, self._spare.rows[:, :, :2]
        return found, rows.copy(), vectors[SUPPLY].copy(), vectors[FREE_ACCELERATION].copy()

    def _solve(self, t: float, q: Array, qd: Array) -> list[Candidate]:
        spare = self._spare
        for i, c in enumerate(self._present):
            spare.take(i, c if c.state != FREE else c.changed(state=SLIDING, probed=1))
        if not solve_problem(self._problem.system, spare, t, q, qd, self._work, np.zeros(1)):
            raise RunEnded(Outcome.MASS_MATRIX_INDEFINITE)
        return [spare.of(i).changed(state=c.state, probed=0) for i, c in enumerate(self._present)]

    def of(self, contact: int) -> Candidate:
        """Return a contact, as if there were no others but for what their elastic forces bend the body."""
        return self._solved[0][contact]

    def coupled(self, contact: int) -> Candidate:
        """Return a closed contact with its present forces, those of others in its accelerations."""
        own, delassus = self.of(contact), self.delassus
        forces = np.array([(c.normal_force, c.tangential_force) for c in self._present])
        present = self._present[contact]
        forces[contact] = 0.0
        gap, slip = np.tensordot(delassus[contact], forces, axes=2).tolist()
        return own.changed(
            gap_acceleration=own.gap_acceleration + gap,
            slip_acceleration=own.slip_acceleration + slip,
            normal_force=present.normal_force,
            tangential_force=present.tangential_force,
        )

    @cached_property
    def delassus(self) -> Array:
        """Accelerations of gap and slip of each contact by a unit force along each row, (n, 2, n, 2)."""
        rows = self._solved[1]
        return np.tensordot(rows[DIRECTION], rows[RESPONSE], axes=(2, 2))

    def after(self, impulses: Mapping[int, Impulse]) -> list[Candidate]:
        """Return all contacts with the velocities that impulses leave."""
        jump = self.velocity_jump(impulses)
        if not jump.any():
            return list(self._solved[0])
        if self._struck is None or self._struck[0] != impulses:  # asked for again as states are decided
            self._struck = dict(impulses), self._solve(self._t, self._q, self._qd + jump)
        return list(self._struck[1])

    def together(self, contacts: Sequence[int], impulses: Mapping[int, Impulse]) -> tuple[list[Candidate], Array]:
        """Return contacts with the velocities that impulses leave, and their Delassus matrix (m, 2, m, 2)."""
        after = self.after(impulses)
        chosen = list(contacts)
        return [after[i] for i in chosen], self.delassus[chosen][:, :, chosen]

    def velocity_jump(self, impulses: Mapping[int, Impulse]) -> Array:
        """Return q'+ - q'- = M^-1 D^T P by impulses, (d,)."""
        jump, responses = np.zeros(self._qd.size), self._solved[1][RESPONSE]
        for i, impulse in impulses.items():
            jump += impulse.normal * responses[i, 0] + impulse.tangential * responses[i, 1]
        return jump

    def supply(self, impulses: Mapping[int, Impulse]) -> float:
        """Energy (J) that drives and moving boundaries put in during impacts.

        The power of drives is affine in the acceleration, so its linear part gives the work of the jump; the
        boundaries move with the mean of the velocities before and after.
        """
        found, rows, supply, _ = self._solved
        work = float(supply @ self.velocity_jump(impulses))
        for i, impulse in impulses.items():
            # rates without the boundary's own
            normal, tangential = (float(row @ self._qd) for row in rows[DIRECTION, i])
            work += impulse.normal * (normal - found[i].gap_rate)
            work += impulse.tangential * (tangential - found[i].slip_rate)
        return work

    def slip_rate_ahead(self, contact: int) -> float:
        """Slip velocity (m/s) of a contact a little later, if it stays closed; 0 if it is rounding.

        A step with the acceleration of a frictionless contact, whose gap rate is taken out along its response.
        """
        found, rows, _, acceleration = self._solved
        c, law = found[contact], self._spare.law
        if not (c.compliant or c.a_nn > 0.0):  # a system without accelerations at an instant: its steps decide
            return 0.0
        force = stop_force(law, c, c.depth, c.depth_rate) if c.compliant else -c.gap_acceleration / c.a_nn
        h = _AHEAD * self._problem.decision.tolerances.time
        acceleration = acceleration + force * rows[RESPONSE, contact, 0]
        velocity = self._qd + h * acceleration
        position = self._q + h * (self._qd + 0.5 * h * acceleration)
        try:
            later = self._solve(self._t + h, position, velocity)[contact]
        except RunEnded:
            return 0.0
        normal, tangential = self._spare.rows[DIRECTION, contact, :2]
        closing = 0.0 if c.compliant else -later.a_nt / later.a_nn
        rate = later.slip_rate + closing * later.gap_rate
        terms = (np.abs(tangential) + abs(closing) * np.abs(normal)) @ np.abs(velocity)
        return float(rate) if abs(rate) > _ROUNDING * terms else 0.0

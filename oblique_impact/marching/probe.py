"""The contact problem where a run is, and after an impulse."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from oblique_impact.contact.forces import inclined
from oblique_impact.contact.impacts import Impulse
from oblique_impact.contact.state import Instant, Phase, Residual
from oblique_impact.errors import Outcome, RunEnded
from oblique_impact.kernels.workspace import Array, Evaluation, Workspace
from oblique_impact.marching.problem import Problem
from oblique_impact.marching.sampling import contact_problem

#: in time scales: how far ahead the slip of a contact at rest is looked for.  Its velocity there is known to about
#: 1e-16 L/(a t^2) of itself, a the beam's acceleration in bending: at 1e-4 s its sign is right from 1e-6 m/s^2 on
_AHEAD = 1e-4
_ROUNDING = 1e-13  # of the terms of a slip velocity: some hundred units of rounding


class Responses(NamedTuple):
    """Rows and responses of the contact problem, each (d,)."""

    normal: Array  # rows
    tangential: Array
    to_normal: Array  # accelerations by a unit force
    to_tangential: Array
    supply: Array
    free: Array  # acceleration without contact force


class Probe:
    """The contact problem where a run is, and after an impulse."""

    def __init__(self, problem: Problem, phase: Phase, t: float, y: Array, work: Workspace) -> None:
        self._problem, self._phase, self._t, self._work = problem, phase, t, work
        size = work.vectors.forces.shape[0]
        self._q, self._qd = y[:size].copy(), y[size : 2 * size].copy()

    @property
    def instant(self) -> Instant:  # noqa: D102  all three: see `ContactProbe`
        return inclined(self._phase, self._solved[1])

    @property
    def residual(self) -> Residual:  # noqa: D102
        return self._problem.residual(self._q)

    def velocity_jump(self, impulse: Impulse) -> Array:
        """q'+ - q'- = M^-1 (D_n^T P_n + D_tau^T P_tau); shape (d,)."""
        responses = self._solved[2]
        return impulse.normal * responses.to_normal + impulse.tangential * responses.to_tangential

    def after(self, impulse: Impulse) -> Instant:  # noqa: D102
        return inclined(self._phase, self._solve(self._qd + self.velocity_jump(impulse))[1])

    def moved(self, jump: Array) -> tuple[Instant, Responses]:
        """Return the contact problem with velocities changed by `jump` (d,), and its rows and responses."""
        instant = self._solve(self._qd + jump)[1] if jump.any() else self._solved[1]
        return inclined(self._phase, instant), self._solved[2]

    def slip_rate_ahead(self) -> float:
        """Slip velocity (m/s) a little later, if the contact stays closed; 0 if it is rounding.

        A step with the acceleration of a frictionless contact, whose gap rate is taken out along its response.
        """
        _, c, responses = self._solved
        law, acceleration = self._problem.machine.contact_law, responses.free
        force = -c.gap_acceleration / c.a_nn if law is None else law.force(c)
        h = _AHEAD * self._problem.machine.tolerances.time
        acceleration = acceleration + force * responses.to_normal
        velocity = self._qd + h * acceleration
        position = self._q + h * (self._qd + 0.5 * h * acceleration)
        defined, _, later = contact_problem(self._problem.system, self._t + h, position, velocity, self._work)
        if not defined:
            return 0.0
        v, closing = self._work.vectors, -later.a_nt / later.a_nn if law is None else 0.0
        rate = later.slip_rate + closing * later.gap_rate
        terms = (np.abs(v.tangential_row) + abs(closing) * np.abs(v.normal_row)) @ np.abs(velocity)
        return float(rate) if abs(rate) > _ROUNDING * terms else 0.0

    def supply(self, impulse: Impulse, jump: Array) -> float:
        """Energy (J) that drives and moving boundaries put in during an impact.

        The power of drives is affine in the acceleration, so its linear part gives the work of the jump; the
        boundaries move with the mean of the velocities before and after.
        """
        e, _, responses = self._solved
        # rates without the boundary's own
        normal, tangential = float(responses.normal @ self._qd), float(responses.tangential @ self._qd)
        boundary = impulse.normal * (normal - e.gap_rate) + impulse.tangential * (tangential - e.slip_rate)
        return float(responses.supply @ jump + boundary)

    @cached_property
    def _solved(self) -> tuple[Evaluation, Instant, Responses]:
        e, instant = self._solve(self._qd)
        v = self._work.vectors
        kept = v.normal_row, v.tangential_row, v.normal_response, v.tangential_response, v.supply
        return e, instant, Responses(*(vector.copy() for vector in (*kept, v.free_acceleration)))

    def _solve(self, velocity: Array) -> tuple[Evaluation, Instant]:
        defined, e, c = contact_problem(self._problem.system, self._t, self._q, velocity, self._work)
        if not defined:
            raise RunEnded(Outcome.MASS_MATRIX_INDEFINITE)
        return e, c

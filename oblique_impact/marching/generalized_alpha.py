"""Generalized-alpha: implicit, second order, with selectable dissipation at high frequencies.

The steps are those of :mod:`~oblique_impact.marching.alpha_step`; transitions are located by shortening the step.
Stops are elastic; a contact that sticks is held by the force of a constraint.  What is reported of that force is
the algorithm's own mean, (1 - alpha_f) lambda1 + alpha_f lambda0: the values at the ends of the steps swing about
it by a factor of -rho_infinity per step after every jump.  The mean lags behind by alpha_f h; for the guards that
end stick it is extrapolated to the end of the step, and the instant is interpolated: the force of a step that is
cut short is ill conditioned.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.elastic import stop_force
from oblique_impact.contact.forces import (
    OK,
    friction_ratio,
    guards_of,
    is_free,
    lambda_n,
    nearest,
    take_stretching,
)
from oblique_impact.contact.state import (
    FREE,
    GUARDS,
    LOWER,
    NORMAL,
    STICKING,
    UPPER,
    Candidate,
    Contacts,
)
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.advance import Limits, Position, Step, StepState, keep_sample, refused
from oblique_impact.marching.alpha_balance import finish_step
from oblique_impact.marching.alpha_state import (
    GAP,
    LAG,
    MEAN_RATE,
    MEMORY,
    AlgorithmState,
    Attempt,
    Coefficients,
    Iterations,
    algorithm_state,
    algorithm_state_size,
    backward_euler,
    coefficients,
    start_phase,
)
from oblique_impact.marching.alpha_step import CONTACT_STEP, CUT_STEP, FLIGHT_STEP, StepSolution, take_step
from oblique_impact.marching.buffers import (
    ARMED,
    NO_GUARD,
    SLOPES,
    THRESHOLD,
    VALUES,
    Scratch,
    guard_count,
    raised,
)
from oblique_impact.marching.location import cubic_dip, find_fall
from oblique_impact.marching.scheme import Prepared, Scheme, Task

_LOCATED = 1e-12  # time scales: how closely an event is located
_LANDED = 0.01  # thresholds: how far below zero a guard may be found
#: a call begins with what is known of the convergence forgotten, so its length is part of the result in the last
#: digits: counted, not timed, or two runs would differ
_STEPS_PER_CALL, _WORK_PER_CALL = 2_000, 500_000  # the latter in steps times degrees of freedom
_START, _END = 0, 1
_SMOOTH = 0.5  # part by which rates of a force that is extrapolated may differ from one step to the next
#: first steps of a phase by backward Euler where a damped contact point without inertia is pressed
_MASSLESS_STEPS = 4


class Cut(NamedTuple):
    """A step of length h (s), cut short where a guard falls, or NO_GUARD."""

    solution: StepSolution
    guard: int
    h: float


@inlined
def _of_force(contacts: Contacts, guard: int) -> bool:
    """Whether a guard is a function of the force that holds a sticking contact, not of the motion."""
    return _is_held(contacts.each[guard // GUARDS]) and guard % GUARDS in (LOWER, UPPER)


@inlined
def _is_held(c: Candidate) -> bool:
    """Whether a contact sticks without axial flexibility behind it: by a constraint."""
    return c.state == STICKING and c.axial == 0.0


@inlined
def _measure(c: Candidate, s: Scratch, row: int, i: int) -> None:
    """Guards of contact i, and the rate of that in flight, into a row of the scratch."""
    guards = guards_of(c)
    for g in range(GUARDS):
        s.guards[VALUES + row, GUARDS * i + g] = guards[g]
    s.guards[SLOPES + row, GUARDS * i + NORMAL] = c.side * c.gap_rate


@inlined
def _extrapolated(mean: float, last: float, span: float, lag: float, before: Array, after: Array) -> float:
    """Extrapolate a mean force to the end of the step, if it has changed as fast in the step before.

    Where stick begins the force may jump, and what it does next cannot be told from what it did.
    The time between the two means is `span` (s), the lag of the new one `lag` (s).
    """
    rate, known = (mean - last) / span, before[MEAN_RATE]
    after[MEAN_RATE] = rate
    smooth = abs(rate - known) <= _SMOOTH * max(abs(rate), abs(known))
    return mean + lag * rate if smooth else mean


@jitable
def _report(a: Attempt, h: float) -> None:
    """Keep the forces at the end of a step of length h and those to report, measure the guards."""
    take_stretching(a.contacts.matrix, a.contacts)
    for i in range(len(a.contacts.each)):
        _report_contact(a, a.contacts.each[i], i, h)


@inlined
def _report_contact(a: Attempt, c: Candidate, i: int, h: float) -> None:
    """Keep the forces of contact i and those to report, measure its guards, which see an extrapolated force."""
    s, k, d = a.scratch, 2 * i, a.scratch.work.vectors.shape[1]
    before, after = algorithm_state(a.contacts, a.y, d), algorithm_state(a.contacts, s.y_new, d)
    normal_end, tangential_end = lambda_n(c), c.tangential_force
    after.forces[k], after.forces[k + 1] = normal_end, tangential_end
    after.reported[k], after.reported[k + 1] = normal_end, tangential_end
    if c.state == FREE:
        _measure(c, s, _END, i)
        return
    push = stop_force(a.contacts.law, c, c.depth, c.depth_rate)  # its law to the last digit
    mean, tangential = tangential_end, tangential_end
    if _is_held(c):
        lag, known = a.c.alpha_f * h, before.memory[MEMORY * i : MEMORY * (i + 1)]
        mean += a.c.alpha_f * (before.forces[k + 1] - tangential_end)
        span, found = h - lag + known[LAG], after.memory[MEMORY * i : MEMORY * (i + 1)]
        tangential = _extrapolated(mean, before.reported[k + 1], span, lag, known, found)
    elif c.state != STICKING:
        tangential = friction_ratio(c) * push
    own = c.normal_force
    c.normal_force, c.tangential_force = push, tangential
    _measure(c, s, _END, i)
    c.normal_force, c.tangential_force = own, tangential_end
    after.reported[k], after.reported[k + 1] = push + c.tilt * mean, mean


@jitable
def _raised(s: Scratch, row: int, guard: int) -> float:
    return raised(s.guards[VALUES + row, guard], guard, s.guards)


@jitable
def _retake(a: Attempt, h: float) -> StepSolution:
    """Repeat a step with another length, guards included."""
    solution = take_step(a, h, CUT_STEP)
    if solution.status == OK:
        _report(a, h)
    return solution


class _Shorter(NamedTuple):
    """Shorter steps than the one attempted; a `Trial`."""

    attempt: Attempt

    def guard_at(self, x: float, guard: int) -> float:
        a = self.attempt
        return _raised(a.scratch, _END, guard) if _retake(a, x * a.h).status == 0 else -1.0


@inlined
def _first_force(contacts: Contacts, s: Scratch) -> tuple[int, float]:
    """First guard of a holding force that falls in a whole step, and the part of the step where; or 1."""
    first, part = NO_GUARD, 1.0
    for guard in range(guard_count(s.guards)):
        fa, fb = _raised(s, _START, guard), _raised(s, _END, guard)
        if fb <= 0.0 and _of_force(contacts, guard):
            place = fa / (fa - fb) if fa > 0.0 else 0.0
            if first == NO_GUARD or place < part:
                first, part = guard, place
    return first, part


@jitable
def _first_dip(contacts: Contacts, s: Scratch, h: float) -> tuple[int, float]:
    """Guard of the contact in flight whose gap first dips below zero inside of a step, and where; or NO_GUARD."""
    first, part, g = NO_GUARD, 1.0, s.guards
    for i in range(len(contacts.each)):
        guard = GUARDS * i + NORMAL
        if contacts.each[i].state == FREE and g[ARMED, guard] != 0.0 and g[VALUES + _END, guard] > 0.0:
            ga, gb = g[VALUES + _START, guard], g[VALUES + _END, guard]
            least, place = cubic_dip(ga, gb, h * g[SLOPES + _START, guard], h * g[SLOPES + _END, guard])
            if place >= 0.0 and least < 0.0 and (first == NO_GUARD or place < part):
                first, part = guard, place
    return first, part


@jitable
def _cut(a: Attempt, solution: StepSolution) -> Cut:
    """Cut the step just taken where the first guard falls; the new state is then that of the shorter step.

    Guards of the motion are located by steps of other lengths; those of a force fall on the line through the step.
    """
    contacts, s, h = a.contacts, a.scratch, a.h
    close = _LOCATED * s.tolerances.time
    first, part = _first_force(contacts, s)
    length, taken = h, h
    if first != NO_GUARD:
        length = taken = max(part * h, close)
        solution = _retake(a, length)
    else:
        guard, part = _first_dip(contacts, s, h)
        if guard != NO_GUARD:
            taken = part * h
            solution = _retake(a, taken)
            if s.guards[VALUES + _END, guard] <= 0.0:  # else the gap only comes close
                length = taken
    for guard in range(guard_count(s.guards)):
        # each guard of the motion that is found fallen shortens the step
        if solution.status == 0 and _raised(s, _END, guard) <= 0.0 and not _of_force(contacts, guard):
            fa, fb, low = _raised(s, _START, guard), _raised(s, _END, guard), -_LANDED * s.guards[THRESHOLD, guard]
            narrow = (1e-3 if contacts.each[guard // GUARDS].state == FREE else 1.0) * close / h
            first, length = guard, h * find_fall(_Shorter(a), guard, 0.0, fa, length / h, fb, narrow, low)
            taken = length
            if length <= close:
                break
            solution = _retake(a, length)
    if taken != length and solution.status == 0:
        solution = _retake(a, length)
    return Cut(solution, first, length)


@inlined
def _smallest_gap(contacts: Contacts, kept: AlgorithmState) -> float:
    """Smallest distance (m) of a contact in flight at the end of the last step."""
    least = 1e300
    for i in range(len(contacts.each)):
        c = contacts.each[i]
        if c.state == FREE and c.enabled:
            least = min(least, c.side * kept.memory[MEMORY * i + GAP])
    return least


@inlined
def _keep_largest(contacts: Contacts, forces: Array) -> None:
    """Keep the largest of the normal forces (N) to report, in `forces` (2 n,), and depth (m) of each contact."""
    for i in range(len(contacts.each)):
        c = contacts.each[i]
        if c.state != FREE:
            c.peak_force, c.peak_depth = max(c.peak_force, forces[2 * i]), max(c.peak_depth, -c.gap)


class AlphaStepper(NamedTuple):
    """Steps of generalized-alpha; a `Stepper`."""

    system: Any
    contacts: Contacts
    limits: Limits
    scratch: Scratch
    iterations: Iterations
    regular: Coefficients
    first: Coefficients  # backward Euler, which has no use for initial accelerations
    first_steps: int  # that are taken with them
    far_step: float  # s, in flight
    near_step: float  # s, in contact and close to the slope
    near: float  # m

    def begin(self, start: StepState, y: Array) -> tuple[int, float]:
        """Compute what a phase starts with; in a later call it is there, as the last step has left it."""
        contacts, work, stale = self.contacts, self.scratch.work, self.iterations.stale
        d = work.vectors.shape[1]
        for slot in range(stale.shape[0]):
            stale[slot] = True
        if start.taken > 0:
            return OK, _smallest_gap(contacts, algorithm_state(contacts, y, d))
        status = start_phase(self.system, contacts, start.t, y, work)
        take_stretching(contacts.matrix, contacts)
        for i in range(len(contacts.each)):
            _measure(contacts.each[i], self.scratch, _START, i)
        return status, nearest(contacts)[0]

    def length(self, gap: float, h: float) -> float:
        """Length of the steps here."""
        return self.far_step if is_free(self.contacts) and gap > self.near else self.near_step

    def take(self, now: Position, length: float, end: float, y: Array) -> Step:
        """Take a step, and cut it where the first guard falls."""
        contacts, s, c, free = self.contacts, self.scratch, self.regular, is_free(self.contacts)
        slot = FLIGHT_STEP if free and now.gap > self.near else CONTACT_STEP
        if now.taken < self.first_steps:
            c, slot = self.first, CUT_STEP
            algorithmic = algorithm_state(contacts, y, s.work.vectors.shape[1]).algorithmic
            for i in range(algorithmic.shape[0]):
                algorithmic[i] = 0.0
        attempt = Attempt(self.system, contacts, c, now.t, length, y, s, self.iterations)
        solution, guard = take_step(attempt, length, slot if length == now.h else CUT_STEP), NO_GUARD
        if solution.status != OK:
            return refused(solution.status, 0.0)
        _report(attempt, length)
        if contacts.each[0].enabled:
            solution, guard, length = _cut(attempt, solution)
            if solution.status != OK:
                return refused(solution.status, 0.0)
        if guard != NO_GUARD:
            if length <= _LOCATED * s.tolerances.time:
                # it falls with the very first of the step: what the last step left is where the phase ends
                return Step(OK, False, now.t, 0.0, guard, now.gap)
            end = now.t + length
        finish_step(attempt, length, solution)
        _keep_largest(contacts, algorithm_state(contacts, s.y_new, s.work.vectors.shape[1]).reported)
        return Step(OK, True, end, length, guard, nearest(contacts)[0])

    def arrive(self, step: Step, y: Array) -> Step:
        """Make the guards at the end of a step those at the start of the next."""
        guards = self.scratch.guards
        if step.guard == NO_GUARD:
            for g in range(guard_count(guards)):
                if guards[VALUES + _END, g] > guards[THRESHOLD, g]:
                    guards[ARMED, g] = 1.0
                guards[VALUES + _START, g] = guards[VALUES + _END, g]
                guards[SLOPES + _START, g] = guards[SLOPES + _END, g]
            keep_sample(step.end, y, self.limits, self.scratch.samples)
        return step


@dataclass(frozen=True)
class GeneralizedAlphaScheme(Scheme):
    """Generalized-alpha with one step for flight, one for contact and flight close to the slope, on elastic stops.

    Attributes
    ----------
    free_step, contact_step : float
        s.
    rho_infinity : float
        Spectral radius at infinite frequency, from 0 (annihilates) to 1 (conserves).
    near : float
        Gap (m) below which a flight takes the contact step: short flights between the impacts of one
        collision carry the vibrations that decide when the next begins.
    tolerance : float
        Of the iterations of a step, on the energy of a correction, as a part of the motion's: the root of it.
    """

    free_step: float
    contact_step: float
    rho_infinity: float = 0.8
    near: float = 0.0
    tolerance: float = 1e-12
    name = "generalized-alpha"
    order = 2
    elastic_only = True

    def extra_state(self, size: int, contacts: int, quadratures: int) -> int:
        """Accelerations, contact forces and rates behind the quadratures."""
        return algorithm_state_size(size, contacts, quadratures)

    def steps_per_call(self, size: int) -> int:  # noqa: D102
        return min(_STEPS_PER_CALL, max(1, _WORK_PER_CALL // size))

    def buffers(self, task: Task) -> Iterations:  # noqa: D102
        return Iterations.new()

    def stepper(self, prepared: Prepared, limits: Limits) -> AlphaStepper:
        """Return the steps of a phase, the first of them perhaps those of backward Euler.

        The force on a contact point without inertia whose flexibility is damped begins with a jump and decays
        faster than any step.  Accelerations that start anew there throw vibrations that the step does not resolve:
        their velocity overshoots by omega h (Hilber and Hughes 1978).  Backward Euler has no use for them.
        """
        each = [prepared.contacts.of(i) for i in range(len(prepared.contacts.each))]
        massless = any(c.state != FREE and c.stiffness == inf and c.relaxation > 0.0 for c in each)
        tolerance = self.tolerance * float(np.sqrt(prepared.scratch.tolerances.energy))
        return AlphaStepper(
            prepared.system,
            prepared.contacts,
            limits,
            prepared.scratch,
            prepared.own,
            coefficients(self.rho_infinity, tolerance),
            backward_euler(tolerance),
            _MASSLESS_STEPS if massless else 0,
            float(self.free_step),
            float(self.contact_step),
            float(self.near),
        )

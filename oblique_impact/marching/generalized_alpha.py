"""Generalized-alpha: implicit, second order, with selectable dissipation at high frequencies.

The steps are those of :mod:`~oblique_impact.marching.alpha_step`; transitions are located by shortening the step.
What is reported of a rigid contact, forces and accelerations, are the algorithm's own means,
(1 - alpha_f) lambda1 + alpha_f lambda0: the values at the ends of the steps swing about them by a factor of
-rho_infinity per step after every jump.  The means lag behind by alpha_f h; where a force decides when a contact
state ends, they are extrapolated to the end of the step, and the instant is interpolated: the force of a step that
is cut short is ill conditioned.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.forces import OK, friction_ratio, guards_of, stop_force, with_forces
from oblique_impact.contact.several import (
    contact_at,
    contact_count,
    contact_phase,
    instant_at,
    keep_forces,
    phase_of,
    take_yielding,
    yielding_at,
)
from oblique_impact.contact.state import (
    FREE,
    GUARDS,
    LOWER,
    NORMAL,
    STATE,
    STICKING,
    UPPER,
    ContactArrays,
    Instant,
    Phase,
)
from oblique_impact.kernels.jit import by_reference, inlined, jitable
from oblique_impact.kernels.system import NormalModes
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.advance import Limits, Position, Step, StepState, keep_sample, refused
from oblique_impact.marching.alpha_balance import finish_step
from oblique_impact.marching.alpha_state import (
    GAP,
    LAG,
    MEAN_RATES,
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
from oblique_impact.marching.buffers import NO_GUARD, Scratch, raised
from oblique_impact.marching.location import cubic_dip, find_fall
from oblique_impact.marching.scheme import Prepared, Scheme

_LOCATED = 1e-12  # time scales: how closely an event is located
_LANDED = 0.01  # thresholds: how far below zero a guard may be found
#: a call begins with what is known of the convergence forgotten, so its length is part of the result in the last
#: digits: counted, not timed, or two runs would differ
_STEPS_PER_CALL, _WORK_PER_CALL = 2_000, 500_000  # the latter in steps times degrees of freedom
_START, _END = 0, 1
_SMOOTH = 0.5  # part by which rates of a force that is extrapolated may differ from one step to the next
#: first steps of a phase by backward Euler: one after a jump of the velocities, four where a damped contact point
#: without inertia makes the force decay faster than any step
_EULER_STEPS, _MASSLESS_STEPS = 1, 4


class Cut(NamedTuple):
    """A step of length h (s), cut short where a guard falls, or NO_GUARD."""

    solution: StepSolution
    guard: int
    h: float


@jitable
def _of_force(phase: Phase, guard: int) -> bool:
    """Whether a guard is a function of the force of a constraint, not of the motion."""
    own = contact_phase(phase.arrays, phase, guard // GUARDS)
    if guard % GUARDS == NORMAL:
        return own.state != FREE and not own.stop.compliant
    return own.state == STICKING and own.stick.compliance == 0.0 and guard % GUARDS in (LOWER, UPPER)


@jitable
def _measure(phase: Phase, c: Instant, yielding: float, s: Scratch, row: int, i: int) -> None:
    """Guards of contact i in the state `phase`, and the rate of that in flight, into a row of the scratch."""
    guards = guards_of(phase, c, yielding)
    for g in range(GUARDS):
        s.guards.values[row, GUARDS * i + g] = guards[g]
    s.guards.slopes[row, GUARDS * i + NORMAL] = phase.surface.side * c.gap_rate


@jitable
def _extrapolated(
    mean: float, last: float, span: float, lag: float, before: Array, after: Array, which: int
) -> float:
    """Extrapolate a mean force to the end of the step, if it has changed as fast in the step before.

    Where a rigid contact begins the force is singular, and what it does next cannot be told from what it did.
    The time between the two means is `span` (s), the lag of the new one `lag` (s).
    """
    rate, known = (mean - last) / span, before[MEAN_RATES + which]
    after[MEAN_RATES + which] = rate
    smooth = abs(rate - known) <= _SMOOTH * max(abs(rate), abs(known))
    return mean + lag * rate if smooth else mean


@jitable
def _report(a: Attempt, h: float, solution: StepSolution) -> StepSolution:
    """Keep the forces at the end of a step of length h, measure the guards, return the forces to report."""
    arrays, end = a.phase.arrays, solution.end
    take_yielding(arrays, a.phase)
    for i in range(contact_count(arrays)):
        phase = by_reference(contact_phase(arrays, a.phase, i))
        reported = _report_contact(a, phase, i, h, contact_at(arrays, solution.end, i))
        end = keep_forces(arrays, end, i, reported.normal_force, reported.tangential_force)
    return StepSolution(solution.status, end, solution.rank_one)


@inlined
def _report_contact(a: Attempt, phase: Phase, i: int, h: float, end: Instant) -> Instant:
    """Keep the forces of contact i, measure its guards, return it with the forces to report."""
    arrays, s, lag, k = a.phase.arrays, a.scratch, a.c.alpha_f * h, 2 * i
    d = s.work.vectors.forces.shape[0]
    before, after = algorithm_state(arrays, a.y, d), algorithm_state(arrays, s.y_new, d)
    after.forces[k], after.forces[k + 1] = end.normal_force, end.tangential_force
    if phase.state == FREE:
        _measure(phase, end, 0.0, s, _END, i)
        return end
    mean_n = end.normal_force + a.c.alpha_f * (before.forces[k] - end.normal_force)
    mean_t = end.tangential_force + a.c.alpha_f * (before.forces[k + 1] - end.tangential_force)
    known, found = before.memory[MEMORY * i : MEMORY * (i + 1)], after.memory[MEMORY * i : MEMORY * (i + 1)]
    span, last = h - lag + known[LAG], before.reported[d + k : d + k + 2]
    normal = _extrapolated(mean_n, float(last[0]), span, lag, known, found, 0)
    tangential = _extrapolated(mean_t, float(last[1]), span, lag, known, found, 1)
    push, held = normal, phase.state == STICKING and phase.stick.compliance == 0.0
    if phase.stop.compliant:
        push = stop_force(phase.stop, phase.residual, end.gap, end.gap_rate)  # its law to the last digit
        mean_t = end.tangential_force if not held else mean_t
        mean_n = push + phase.residual.tilt * mean_t
    if phase.state != STICKING:
        tangential = friction_ratio(phase, end.slip_rate) * push
    elif not held:
        tangential = end.tangential_force
    if phase.stop.compliant:
        normal = push + phase.residual.tilt * tangential
    _measure(phase, with_forces(end, normal, tangential, 0.0), yielding_at(arrays, i), s, _END, i)
    return with_forces(end, mean_n, mean_t, end.supplied_power)


@jitable
def _raised(s: Scratch, row: int, guard: int) -> float:
    return raised(s.guards.values[row, guard], guard, s.guards)


@jitable
def _retake(a: Attempt, h: float) -> StepSolution:
    """Repeat a step with another length, guards included."""
    solution = take_step(a, h, CUT_STEP)
    return _report(a, h, solution) if solution.status == OK else solution


class _Shorter(NamedTuple):
    """Shorter steps than the one attempted; a `Trial`."""

    attempt: Attempt

    def guard_at(self, x: float, guard: int) -> float:
        a = self.attempt
        return _raised(a.scratch, _END, guard) if _retake(a, x * a.h).status == 0 else -1.0


@jitable
def _first_force(phase: Phase, s: Scratch) -> tuple[int, float]:
    """First guard of a constraint's force that falls in a whole step, and the part of the step where; or 1."""
    first, part = NO_GUARD, 1.0
    for guard in range(s.guards.armed.shape[0]):
        fa, fb = _raised(s, _START, guard), _raised(s, _END, guard)
        if fb <= 0.0 and _of_force(phase, guard):
            place = fa / (fa - fb) if fa > 0.0 else 0.0
            if first == NO_GUARD or place < part:
                first, part = guard, place
    return first, part


@jitable
def _first_dip(phase: Phase, s: Scratch, h: float) -> tuple[int, float]:
    """Guard of the contact in flight whose gap first dips below zero inside of a step, and where; or NO_GUARD."""
    first, part, g = NO_GUARD, 1.0, s.guards
    for i in range(contact_count(phase.arrays)):
        guard = GUARDS * i + NORMAL
        own = contact_phase(phase.arrays, phase, i)
        if own.state == FREE and g.armed[guard] and g.values[_END, guard] > 0.0:
            ga, gb = g.values[_START, guard], g.values[_END, guard]
            least, place = cubic_dip(ga, gb, h * g.slopes[_START, guard], h * g.slopes[_END, guard])
            if place >= 0.0 and least < 0.0 and (first == NO_GUARD or place < part):
                first, part = guard, place
    return first, part


@jitable
def _cut(a: Attempt, solution: StepSolution) -> Cut:
    """Cut the step just taken where the first guard falls; the new state is then that of the shorter step.

    Guards of the motion are located by steps of other lengths; those of a force fall on the line through the step.
    """
    phase, s, h = a.phase, a.scratch, a.h
    close = _LOCATED * s.tolerances.time
    first, part = _first_force(phase, s)
    length, taken = h, h
    if first != NO_GUARD:
        length = taken = max(part * h, close)
        solution = _retake(a, length)
    else:
        guard, part = _first_dip(phase, s, h)
        if guard != NO_GUARD:
            taken = part * h
            solution = _retake(a, taken)
            if s.guards.values[_END, guard] <= 0.0:  # else the gap only comes close
                length = taken
    for guard in range(s.guards.armed.shape[0]):
        # each guard of the motion that is found fallen shortens the step
        if solution.status == 0 and _raised(s, _END, guard) <= 0.0 and not _of_force(phase, guard):
            fa, fb, low = _raised(s, _START, guard), _raised(s, _END, guard), -_LANDED * s.guards.thresholds[guard]
            own = contact_phase(phase.arrays, phase, guard // GUARDS)
            narrow = (1e-3 if own.state == FREE else 1.0) * close / h
            first, length = guard, h * find_fall(_Shorter(a), guard, 0.0, fa, length / h, fb, narrow, low)
            taken = length
            if length <= close:
                break
            solution = _retake(a, length)
    if taken != length and solution.status == 0:
        solution = _retake(a, length)
    return Cut(solution, first, length)


@inlined
def _is_far(phase: Phase, gap: float, near: float) -> bool:
    """Whether the contact point is in flight and not close to the slope."""
    return phase.state == FREE and (not phase.surface.enabled or phase.surface.side * gap > near)


@jitable
def _smallest_gap(arrays: ContactArrays | None, phase: Phase, kept: AlgorithmState) -> float:
    """Gap (m) at the end of the last step; of several contacts the smallest distance of one in flight."""
    if arrays is None:
        return float(kept.memory[GAP])
    least = 1e300
    for i in range(arrays.rows.shape[0]):
        own = phase_of(phase, arrays, i)
        if own.state == FREE:
            least = min(least, own.surface.side * kept.memory[MEMORY * i + GAP])
    return least


@jitable
def _keep_largest(arrays: ContactArrays | None, largest: Array) -> None:
    """Keep the largest normal force (N) and depth (m) of each of several contacts."""
    if arrays is not None:
        for i in range(arrays.rows.shape[0]):
            if arrays.rows[i, STATE] != FREE:
                c = instant_at(arrays, i)
                largest[0, i], largest[1, i] = max(largest[0, i], c.normal_force), max(largest[1, i], -c.gap)


class AlphaStepper(NamedTuple):
    """Steps of generalized-alpha; a `Stepper`."""

    system: Any
    phase: Phase
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
        phase, work, stale = self.phase, self.scratch.work, self.iterations.stale
        for slot in range(stale.shape[0]):
            stale[slot] = True
        if start.taken > 0:
            return OK, _smallest_gap(
                phase.arrays, phase, algorithm_state(phase.arrays, y, work.vectors.forces.shape[0])
            )
        status, c = start_phase(self.system, phase, start.t, y, work)
        take_yielding(phase.arrays, phase)
        for i in range(contact_count(phase.arrays)):
            own, at = contact_phase(phase.arrays, phase, i), contact_at(phase.arrays, c, i)
            _measure(own, at, yielding_at(phase.arrays, i), self.scratch, _START, i)
        return status, c.gap

    def length(self, gap: float, h: float) -> float:
        """Length of the steps here."""
        return self.far_step if _is_far(self.phase, gap, self.near) else self.near_step

    def take(self, now: Position, length: float, end: float, y: Array) -> Step:
        """Take a step, and cut it where the first guard falls."""
        phase, s, c = self.phase, self.scratch, self.regular
        slot = FLIGHT_STEP if _is_far(phase, now.gap, self.near) else CONTACT_STEP
        if now.taken < self.first_steps:
            c, slot = self.first, CUT_STEP
            algorithmic = algorithm_state(phase.arrays, y, s.work.vectors.forces.shape[0]).algorithmic
            for i in range(algorithmic.shape[0]):
                algorithmic[i] = 0.0
        attempt = Attempt(self.system, phase, c, now.t, length, y, s, self.iterations)
        solution, guard = take_step(attempt, length, slot if length == now.h else CUT_STEP), NO_GUARD
        if solution.status != OK:
            return refused(solution.status, 0.0)
        solution = _report(attempt, length, solution)
        if phase.state != FREE or phase.surface.enabled:
            solution, guard, length = _cut(attempt, solution)
            if solution.status != OK:
                return refused(solution.status, 0.0)
        if guard != NO_GUARD:
            if length <= _LOCATED * s.tolerances.time:
                # it falls with the very first of the step: what the last step left is where the phase ends
                return Step(OK, False, now.t, 0.0, guard, now.gap, 0.0, 0.0)
            end = now.t + length
        finish_step(attempt, length, solution)
        _keep_largest(phase.arrays, s.guards.largest)
        gap = solution.end.gap
        return Step(OK, True, end, length, guard, gap, solution.end.normal_force, -gap)

    def arrive(self, step: Step, y: Array) -> Step:
        """Make the guards at the end of a step those at the start of the next."""
        guards = self.scratch.guards
        if step.guard == NO_GUARD:
            for g in range(guards.armed.shape[0]):
                guards.armed[g] = guards.armed[g] or guards.values[_END, g] > guards.thresholds[g]
                guards.values[_START, g] = guards.values[_END, g]
                guards.slopes[_START, g] = guards.slopes[_END, g]
            keep_sample(step.end, y, self.limits, self.scratch.samples)
        return step


@dataclass(frozen=True)
class GeneralizedAlphaScheme(Scheme):
    """Generalized-alpha with one step for flight, one for contact and flight close to the slope.

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

    def extra_state(self, size: int, contacts: int, quadratures: int) -> int:
        """Accelerations, contact forces and rates behind the quadratures."""
        return algorithm_state_size(size, contacts, quadratures)

    def steps_per_call(self, size: int) -> int:  # noqa: D102
        return min(_STEPS_PER_CALL, max(1, _WORK_PER_CALL // size))

    def buffers(  # noqa: D102
        self, ny: int, modes: NormalModes | None, interval: float, end_time: float
    ) -> Iterations:
        return Iterations.new()

    def stepper(self, prepared: Prepared, phase: Phase, before: Phase | None, limits: Limits) -> AlphaStepper:
        """Return the steps of a phase, the first of them perhaps those of backward Euler.

        Accelerations that start anew throw vibrations that the step does not resolve: their velocity overshoots
        by omega h (Hilber and Hughes 1978), and with every impact of a rigid contact energy would be gained.  The
        first steps of phases that begin or end at one, also of a flight after a rebound, are those of backward
        Euler, which has no use for them.  The force on a contact point without inertia whose flexibility is damped
        begins with a jump and decays faster than any step: some steps more.
        """
        # not a flight that has only passed the line of the slope, beyond an end
        rebound = (
            before is not None
            and before.state == phase.state == FREE
            and before.surface.side == phase.surface.side
            and phase.arrays is None  # elastic
        )
        jumps = _is_rigid(phase) or (before is not None and _is_rigid(before)) or rebound
        first_steps = _EULER_STEPS if jumps else 0
        if phase.stop.massless and phase.residual.relaxation > 0.0:
            first_steps = _MASSLESS_STEPS
        tolerance = self.tolerance * float(np.sqrt(prepared.scratch.tolerances.energy))
        return AlphaStepper(
            prepared.system,
            phase,
            limits,
            prepared.scratch,
            prepared.own,
            coefficients(self.rho_infinity, tolerance),
            backward_euler(tolerance),
            first_steps,
            float(self.free_step),
            float(self.contact_step),
            float(self.near),
        )


def _is_rigid(phase: Phase) -> bool:
    return phase.state != FREE and not phase.stop.compliant

"""Time-stepping for many rigid contacts: mid-point steps, complementarity at their ends, no search for events.

With v = q', the means v_m of the velocities and q_m of the coordinates of a step from 0 to 1 of length h

    M(q_m) (v1 - v0) = h Q(t_m, q_m, v_m) + C^T P,    q1 = q0 + h v_m
    0 <= P_n _|_ C_n v1 + g/h >= 0,    P_tau by Coulomb's law on C_tau v1

over all places, with gaps g and rows C at x0 = q0 + h v0/2 (Moreau 1988; Stewart and Trinkle 1996).  These
staggered coordinates go on by x1 = x0 + h v1, so that the gap that is closed is that of x1: it is zero but for h^2
times its acceleration, and does not drift.

The step that closes a contact is aimed: the one before it is shortened, or itself lengthened, so that x0 is on
the obstacle.  The velocity at its end is then zero at once, not -g/h with whatever gap g the steps happen to find:
that also turns the beam, and decides the direction of friction under the largest impulse of all.  What the aim
leaves of g is closed in a second step.

A contact begins where its gap vanishes on the line from x0, and ends where its force does, between the middle of
its last step and that of the next, in which it would have to pull.  Other changes are in the middle of their step.

With a coefficient of restitution e a contact leaves in that second step, if it came with C_n v0 = -r,

    0 <= P_n _|_ C_n v1 - e r >= 0

Newton's law in Moreau's form (Moreau 1988; Acary and Brogliato, Numerical Methods for Nonsmooth Dynamical Systems,
2008).  Bounces that come down within a step end there.  The impulses of a step give no more energy than those of
the last one took: where contacts that close one after another would, e r is lowered.

Where places have no inertia (Renard 2010; Pozzolini and Salaun, ESAIM M2AN 45, 2011) the gaps g1 at the end of the
step obey 0 <= P_n _|_ g1 >= 0, and the slips between its ends Coulomb's law: of the mid-point rule
g1 = g + h/2 C_n v1, with the same gaps g at x0.  There are no impacts; a place that closes within a step takes P_n
times its gap before, of the first order of the step.

What elastic stops, modes that are left out and the axis yield adds to gaps and slips
(:mod:`oblique_impact.marching.yielding`).  Elastic stops have finite forces, which ask for the gaps at the end of
the step as well.

The coefficient of friction is the static one of the friction law where a contact has stuck in the last step, else
that of the law at the slip velocity before the step, or before an impact: of the first order of the step.  A law
without a stick state has at zero slip the coefficient of its branch there.  That of a regularized law is zero, so
that the contact creeps; where it is not, friction up to it holds a contact, which counts as slipping all the same.

The work of the impulses over a step is P.C (v0 + v1)/2.  What the normal ones take, and all of them in the two
steps that close a contact, is lost in plastic impacts.

With the axial flexibility of the beam in the tangential rows friction sees the velocity of the material with what
the axis yields: a spring in series with Coulomb's slider (Jenkins 1962).  Friction takes -P_tau times that at the
end of the step, the springs hold what they hold, the rest is the scheme's.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.complementarity import (
    BACKWARDS,
    FORWARDS,
    OPEN,
    STUCK,
    ContactProblem,
    solve_contacts,
)
from oblique_impact.contact.forces import MASS_NOT_POSITIVE, OK
from oblique_impact.contact.friction import FrictionLaw, branch_table, coefficient_at
from oblique_impact.contact.state import DIRECTION, RESPONSE, Candidate, Contacts, State
from oblique_impact.contact.transitions import Earlier
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import EFFECTIVE_SLOTS, INCREMENT, RESIDUAL, SUPPLY, Array, add, copy, dot
from oblique_impact.marching.advance import (
    FAILED_ITERATION,
    Limits,
    Position,
    Step,
    StepState,
    keep_sample,
    refused,
)
from oblique_impact.marching.buffers import NO_GUARD, Scratch
from oblique_impact.marching.equations import (
    DAMPING_LOSS,
    FRICTION_LOSS,
    NORMAL_IMPULSE,
    OF_A_CONTACT,
    QUADRATURES,
    STABILIZATION_LOSS,
    STOP_LOSS,
    SUPPLIED,
    TANGENTIAL_IMPULSE,
)
from oblique_impact.marching.flight import (
    EASY,
    ROOM,
    SPEED,
    Flight,
    begin_again,
    error_of,
    follow,
    foresee,
    keep_samples,
    length_of_flight,
    look_around,
    take_change,
)
from oblique_impact.marching.scheme import Prepared, Scheme, Task
from oblique_impact.marching.step_log import (
    AFTER,
    AT_SLIP,
    BEFORE,
    CLOSING_RATE,
    COMPRESSED,
    CONTACT,
    COUNTED,
    HELD,
    IMPACT_NORMAL,
    IMPACT_TANGENTIAL,
    LEAST,
    LOGGED,
    MOST,
    OWN,
    PEAK,
    PLASTIC_LOSS,
    SLIPPING_RATE,
    STEP_END,
    STEPS,
    TIME,
    StepLog,
)
from oblique_impact.marching.yielding import (
    Yielding,
    begin_yielding,
    compress,
    end_yielding,
    look_at_vibration,
    push_body,
    shift_forces,
    yielded,
    yielding_between,
)

STEPS_PER_CALL = 1_000  # the log of a call has room for every contact in each of its steps
_MOST_ITERATIONS = 20
#: a correction that is no smaller than this part of the last one is rounding, if it is no more than so many
#: tolerances (see `alpha_step`)
_STALLED, _ROUNDING = 0.5, 1e6
#: of the first correction of a step: one that is no larger brings no other place to its obstacle that the next
#: step would not find there
_SETTLED = 1e-3
#: tolerances of velocities: a slower slip is rounding
_STILL = 100.0
_SAME = 1e-9  # of an energy, what is rounding
#: of the gap from which on steps are short: places that are farther away than this, and than twice their way in a
#: step, do not reach their obstacles in it
_CLOSE = 1e-3
#: of a step: what is left of it until a contact closes, from which on a shorter step is worth it
_LEAST_PART = 0.25
#: of a step: less is not left until a stop, but taken with the step before
_LEAST_LEFT = 0.5
_LONGEST = 64.0  # steps in flight, in those of `free_step`: longer ones would save nothing
#: steps in which a contact closes: their impulses are those of its impact
OF_AN_IMPACT = 2


class StepBuffers(NamedTuple):
    """Buffers of a run of n contacts and d degrees of freedom, and the contacts from step to step."""

    acceleration: Array  # (d,) (v1 - v0)/h
    gaps: Array  # (n,) at the staggered coordinates; inf of a place that is beyond its side
    closed: NDArray[np.int64]  # (n,) the contacts of the problem, m of them
    states: NDArray[np.int64]  # (n,) of every contact
    log: Array  # (rows, 21) changes of states
    logged: NDArray[np.int64]  # (1,) number of rows
    resumed: Array  # (n, 9) what is counted at the start of a run
    begun: Array  # (d + 3 n + 1,) what it reports there, see `extra_state`; NaN: no contact goes on
    factored: Array  # (3,) s, step of each effective matrix
    latest: Array  # (1,) s, of the last change in the log, behind which none is
    staggered: Array  # (d,) coordinates q0 + h v0/2
    in_problem: NDArray[np.bool_]  # (n,) whether a contact is among the m of the problem
    slipping: Array  # (n,) m/s, slip velocities of these before the step
    impulses: Array  # (2 n,) N s, of these
    carried: Array  # (2 n,) m/s, parts of their rates that no row has: where a driven root carries them
    problem: ContactProblem
    branches: Array  # (k, 3) of the friction law of all contacts
    static: float  # its static coefficient; negative: it has no stick state
    restitution: float
    rebounds: Array  # (n,) m/s, with which contacts that the last step has closed open in this one; or 0
    taken: Array  # (1,) J, what contacts lost in the last step, and those that rebounded then had not given back
    yielding: Yielding  # behind the contacts
    flight: Flight | None  # None: all steps in flight have the same length

    @classmethod
    def new(
        cls,
        n: int,
        size: int,
        friction: FrictionLaw,
        restitution: float,
        yielding: Yielding,
        flight: Flight | None,
    ) -> StepBuffers:
        """Allocate the buffers of n contacts with a friction law and a coefficient of restitution."""
        return cls(
            np.zeros(size),
            np.zeros(n),
            np.zeros(n, dtype=np.int64),
            np.zeros(n, dtype=np.int64),
            np.zeros((STEPS_PER_CALL * n, LOGGED + COUNTED)),
            np.zeros(1, dtype=np.int64),
            np.zeros((n, COUNTED)),
            np.full(size + 3 * n + 1, np.nan),
            np.zeros(EFFECTIVE_SLOTS),
            np.zeros(1),
            np.zeros(size),
            np.zeros(n, dtype=np.bool_),
            np.zeros(n),
            np.zeros(2 * n),
            np.zeros(2 * n),
            ContactProblem.new(n, friction.rubs),
            branch_table(friction),
            float(friction.static) if friction.rubs and friction.static is not None else -1.0,
            float(restitution),
            np.zeros(n),
            np.zeros(1),
            yielding,
            flight,
        )


class SteppingSolution(NamedTuple):
    """The end of the iterations of a step."""

    status: int
    contacts: int  # of the problem
    supplied_power: float  # W


@jitable
def _measure_gaps(stepper: TimeStepper, t: float, x: Array, v0: Array) -> tuple[float, float]:
    """Gaps at the staggered coordinates; returns the smallest (m) and the largest speed (m/s) of any place.

    A place that has come below the line of a side beyond its end meets the side only after it has come back up.
    """
    b, each = stepper.buffers, stepper.contacts.each
    stepper.system.measure(t, x, v0, stepper.scratch.work, stepper.contacts)
    closest, fastest = 1e300, 0.0
    for i in range(b.gaps.shape[0]):
        c = each[i]
        beyond = c.slip < c.first or c.slip > c.last
        if c.side < 0.0 and c.gap > 0.0:
            c.side = 1.0
        elif beyond and c.gap < 0.0:
            c.side = -1.0
        b.gaps[i] = c.gap if c.enabled and c.side > 0.0 and not beyond else np.inf
        closest, fastest = min(closest, b.gaps[i]), max(fastest, abs(c.gap_rate))
    look_around(b.flight, stepper.contacts)
    return closest, fastest


@jitable
def _stagger(stepper: TimeStepper, t: float, h: float, y: Array) -> tuple[float, float]:
    """Take the staggered coordinates of a step from t; the smallest gap (m) there and the largest speed (m/s)."""
    x, d = stepper.buffers.staggered, stepper.buffers.acceleration.shape[0]
    for j in range(d):
        x[j] = y[j] + 0.5 * h * y[d + j]
    return _measure_gaps(stepper, t + 0.5 * h, x, y[d : 2 * d])


@jitable
def _aimed(stepper: TimeStepper, h: float) -> float:
    """Length (s) of a step that would be h, so that what closes in this one or the next does so without a gap.

    It is from a quarter of h to one and a half.  Where nothing is closed it is as short as a touch at its start
    asks for: the run may begin with one.
    """
    b, tolerances, part, least, fastest = stepper.buffers, stepper.scratch.tolerances, 1.0, 0.0, 0.0
    for i in range(b.gaps.shape[0]):
        approach = -stepper.contacts.each[i].gap_rate
        if b.states[i] != OPEN:
            least = _LEAST_PART
        elif approach > _STILL * tolerances.velocity and b.gaps[i] > -0.5 * h * approach - tolerances.gap:
            part, fastest = min(part, b.gaps[i] / (h * approach)), max(fastest, approach)
    if part == 1.0:
        return h
    least = max(least, tolerances.gap / (h * fastest))  # it goes no deeper in that than what is forgiven
    return h * part if part > _LEAST_PART else h * max(1.0 + 2.0 * part, least)


@jitable
def _forgive(gaps: Array, most: float) -> None:
    """Take what is below zero by less than `most` (m) for nothing: it is not worth a speed to make up for it."""
    for i in range(gaps.shape[0]):
        if gaps[i] < 0.0:
            gaps[i] = min(gaps[i] + most, 0.0)


@jitable
def _take_contacts(
    stepper: TimeStepper,
    first: int,
    end: int,
    t: float,
    h: float,
    x: Array,
    v0: Array,
    rank_one: float,
    slot: int,
) -> None:
    """Take the closed contacts `first` to `end` into the problem: rows, responses, velocities by unit impulses."""
    b, each, w, p = stepper.buffers, stepper.contacts.each, stepper.scratch.work, stepper.buffers.problem
    directions, responses = stepper.contacts.rows[DIRECTION], stepper.contacts.rows[RESPONSE]
    sides = 2 if stepper.rubs else 1
    stepper.system.take_state(t, x, v0, w)
    for m in range(first, end):
        i = b.closed[m]
        stepper.system.touch(i, t, x, v0, w, each[i], directions[m])
        b.slipping[i], p.states[m] = each[i].slip_rate, b.states[i]
        b.carried[2 * m] = each[i].gap_rate - dot(directions[m, 0], v0)
        b.carried[2 * m + 1] = each[i].slip_rate - dot(directions[m, 1], v0)
        if b.states[i] == STUCK and b.static >= 0.0:
            p.friction[m] = b.static
        elif stepper.rubs:
            p.friction[m] = coefficient_at(b.branches, _rubbing(stepper, i, h))
        if p.states[m] == OPEN:
            p.states[m] = FORWARDS if not stepper.rubs or each[i].slip_rate >= 0.0 else BACKWARDS
            if stepper.stretches and not stepper.massless:
                p.states[m] = STUCK  # whatever its slip velocity, which the axial flexibility takes up
    stepper.system.solve_rows(rank_one, w, slot, sides, directions[first:end], responses[first:end])
    for m in range(first, end):
        i = b.closed[m]
        for k in range(m + 1):
            j = b.closed[k]
            for a in range(sides):
                for c in range(sides):
                    entry = dot(directions[m, a], responses[k, c])
                    p.delassus[2 * m + a, 2 * k + c] = entry
                    if k != m:
                        p.delassus[2 * k + c, 2 * m + a] = entry
                    if not stepper.yields:
                        continue
                    if k == m and a == 0 and c == 0:
                        look_at_vibration(b.yielding, h, i, entry)
                    yields = yielding_between(b.yielding, h, i, a, j, c)  # symmetric
                    p.delassus[2 * m + a, 2 * k + c] += yields / _span(stepper, a, h)
                    if k != m:
                        p.delassus[2 * k + c, 2 * m + a] += yields / _span(stepper, c, h)


@inlined
def _rubbing(stepper: TimeStepper, i: int, h: float) -> float:
    """Slip velocity (m/s) before the step of a contact in the problem, with what yields without inertia."""
    if not (stepper.yields and stepper.massless):
        return float(stepper.buffers.slipping[i])
    return float(stepper.buffers.slipping[i] + stepper.buffers.yielding.moved[2 * i + 1] / h)


@inlined
def _span(stepper: TimeStepper, a: int, h: float) -> float:
    """Time (s) in which the velocity at the end of a step gives a displacement of gap (a = 0) or slip (1).

    Half of it of a mean velocity: the gap is then that at the end, which finite forces ask for.
    """
    return 0.5 * h if stepper.massless or (a == 0 and stepper.buffers.yielding.elastic) else h


@jitable
def _known_rate(stepper: TimeStepper, i: int, a: int, h: float, force: float) -> float:
    """Return what the problem adds to the rate (m/s) of gap (a = 0) or slip (1) at the end of a step.

    Places that yield have moved as the present impulses push them; `force` (N) is the normal one of contact i.
    """
    b, left = stepper.buffers, 0.0 if a == 1 else stepper.buffers.gaps[i]
    if stepper.yields:
        left += yielded(b.yielding, i, a, force)
    rate = left / _span(stepper, a, h)
    if a == 0 and b.rebounds[i] > 0.0:
        rate = min(rate, -b.rebounds[i])
    return rate + b.slipping[i] if stepper.massless and a == 1 else rate


@jitable
def _solve(stepper: TimeStepper, m: int, h: float, v1: Array) -> bool:
    """Solve for the impulses of the m contacts of the problem; the end v1 of the velocities changes with them."""
    b, rows, p = stepper.buffers, stepper.contacts.rows, stepper.buffers.problem
    directions = 2 if stepper.rubs else 1
    for k in range(m):
        i = b.closed[k]
        for a in range(directions):
            rate = b.carried[2 * k + a] + dot(rows[DIRECTION, k, a], v1)
            for c in range(2 * m):
                rate -= p.delassus[2 * k + a, c] * b.impulses[c]
            p.rates[2 * k + a] = rate + _known_rate(stepper, i, a, h, b.impulses[2 * k] / h)
    if not solve_contacts(p, m, True):
        return False
    for k in range(m):
        for a in range(directions):
            more, response = p.forces[2 * k + a] - b.impulses[2 * k + a], rows[RESPONSE, k, a]
            b.impulses[2 * k + a] = p.forces[2 * k + a]
            for j in range(v1.shape[0]):
                v1[j] += more * response[j]
    push_body(b.yielding, h, b.impulses, b.closed, m)
    return True


@jitable
def _keep_out(
    stepper: TimeStepper, m: int, t: float, h: float, x: Array, y: Array, rank_one: float, slot: int, settled: bool
) -> int:
    """Keep the end of a step out of all obstacles by impulses; the number of contacts in the problem, or -1.

    Once it has `settled` none comes to them any more.
    """
    b, s, d = stepper.buffers, stepper.scratch, x.shape[0]
    v0, v1 = y[d : 2 * d], s.y_new[d : 2 * d]
    if m == 0:
        for i in range(b.states.shape[0]):
            b.in_problem[i] = b.states[i] != OPEN and b.gaps[i] < np.inf
            if b.in_problem[i]:
                b.closed[m] = i
                m += 1
        if m > 0:
            _take_contacts(stepper, 0, m, t, h, x, v0, rank_one, slot)
        push_body(b.yielding, h, b.impulses, b.closed, 0)
    while True:  # at most once for each contact, as the problem only grows
        if m > 0 and not _solve(stepper, m, h, v1):
            return -1
        if settled or m == b.states.shape[0]:
            return m
        stepper.system.measure(t, x, v1, s.work, stepper.contacts)
        before = m
        for i in range(b.states.shape[0]):
            if b.in_problem[i]:
                continue
            if stepper.contacts.each[i].gap_rate + _known_rate(stepper, i, 0, h, 0.0) < -s.tolerances.velocity:
                b.in_problem[i] = True
                b.closed[m] = i
                m += 1
        if m == before:
            return m
        _take_contacts(stepper, before, m, t, h, x, v0, rank_one, slot)


@jitable
def _iterate(stepper: TimeStepper, t: float, h: float, slot: int, clear: bool, y: Array) -> SteppingSolution:
    """Iterate to the end of a step of length h: velocities there into s.y_new, q_m and v_m into s.at.

    The step is `clear` if no place can reach its obstacle within it.
    """
    s, b, rows = stepper.scratch, stepper.buffers, stepper.contacts.rows
    w, x, acceleration = s.work, b.staggered, b.acceleration
    d, middle, m, before, first = x.shape[0], t + 0.5 * h, 0, 0.0, 0.0
    v0, v1, residual, increment = y[d : 2 * d], s.y_new[d : 2 * d], w.vectors[RESIDUAL], w.vectors[INCREMENT]
    foreseen = clear and foresee(b.flight, h, v0, v1)
    if not foreseen:
        copy(v0, v1)
    for iteration in range(_MOST_ITERATIONS):
        for j in range(d):
            acceleration[j] = (v1[j] - v0[j]) / h
            s.at[d + j] = 0.5 * (v0[j] + v1[j])
            s.at[j] = y[j] + 0.5 * h * s.at[d + j]
        e = stepper.system.take_residual(middle, s.at[:d], s.at[d : 2 * d], acceleration, w)
        for k in range(m):
            for a in range(2 if stepper.rubs else 1):
                force = b.impulses[2 * k + a] / h
                for j in range(d):
                    residual[j] += force * rows[DIRECTION, k, a, j]
        if stepper.yields:
            _take_push(stepper, m, h)
            add(stepper.contacts.push, residual)
        if iteration == 0:
            stale = b.factored[slot] != h
            if not stepper.system.factor_effective(middle, s.at[:d], 0.5 * h, 0.25 * h * h, w, slot, stale):
                return SteppingSolution(MASS_NOT_POSITIVE, m, 0.0)
            b.factored[slot] = h
        stepper.system.solve_effective(e.rank_one, w, slot, stepper.contacts, False)
        change = h * np.sqrt(abs(dot(increment, residual)))
        if iteration == 0:
            first = change
            take_change(b.flight, change if foreseen else np.inf)
        for j in range(d):
            v1[j] += h * increment[j]
        if not clear:
            settled = iteration > 0 and change <= _SETTLED * first
            m = _keep_out(stepper, m, middle, h, x, y, e.rank_one, slot, settled)
        if m < 0:
            return SteppingSolution(-FAILED_ITERATION, 0, 0.0)
        # the next correction is smaller than this one as this one is smaller than the one before
        done = change <= stepper.tolerance or change * change <= stepper.tolerance * before
        stalled = change > _STALLED * before and change <= _ROUNDING * stepper.tolerance
        if iteration > 0 and (done or stalled):
            for j in range(d):
                acceleration[j] = (v1[j] - v0[j]) / h
            return SteppingSolution(OK, m, e.supplied_power + dot(w.vectors[SUPPLY], acceleration))
        before = change
    return SteppingSolution(-FAILED_ITERATION, m, 0.0)


@jitable
def _take_push(stepper: TimeStepper, m: int, h: float) -> None:
    """Take the forces by the change of compliances, see `oblique_impact.contact.elastic`, at these impulses."""
    b, each, rows = stepper.buffers, stepper.contacts.each, stepper.contacts.rows[DIRECTION]
    push = stepper.contacts.push
    for j in range(push.shape[0]):
        push[j] = 0.0
    shift_forces(b.yielding, h, b.impulses, b.closed, m, stepper.contacts)
    for k in range(m):
        c = each[b.closed[k]]
        for j in range(push.shape[0] if c.end_force != 0.0 else 0):
            push[j] += c.end_force * rows[k, 1, j]
        for j in range(push.shape[0] if c.shift_force != 0.0 else 0):
            push[j] += c.shift_force * rows[k, rows.shape[1] - 1, j]


@jitable
def _solve_step(stepper: TimeStepper, t: float, h: float, slot: int, clear: bool, y: Array) -> SteppingSolution:
    """Iterate to the end of a step, with as much restitution as gives no energy."""
    b, d, trial = stepper.buffers, stepper.buffers.acceleration.shape[0], 0
    stepper.system.begin_step(t, h, y[:d], stepper.scratch.work)
    while True:
        for k in range(b.impulses.shape[0]):
            b.impulses[k] = 0.0
        for i in range(b.in_problem.shape[0]):
            b.in_problem[i] = False
        found = _iterate(stepper, t, h, slot, clear, y)
        v0, v1 = y[d : 2 * d], stepper.scratch.y_new[d : 2 * d]
        trial += 1
        if found.status != OK or not _gives_too_much(stepper, found.contacts, v0, v1, trial):
            return found


@jitable
def _gives_too_much(stepper: TimeStepper, m: int, v0: Array, v1: Array, trial: int) -> bool:
    """Lower the rebounds of a step whose impulses give more energy than its contacts have lost as they closed."""
    b, rows, given, rebounding = stepper.buffers, stepper.contacts.rows[DIRECTION], -stepper.buffers.taken[0], 0.0
    for k in range(m):
        i = b.closed[k]
        rebounding += 0.5 * b.impulses[2 * k] * b.rebounds[i]
        given += 0.5 * b.impulses[2 * k] * (dot(rows[k, 0], v0) + dot(rows[k, 0], v1))
        if stepper.rubs and not stepper.yields:
            given += 0.5 * b.impulses[2 * k + 1] * (b.slipping[i] + dot(rows[k, 1], v1))
    if rebounding == 0.0 or given <= _SAME * rebounding:
        return False
    for i in range(b.rebounds.shape[0]):
        b.rebounds[i] *= max(1.0 - given / rebounding, 0.0) if trial < _MOST_ITERATIONS else 0.0
    return True


@jitable
def _finish(stepper: TimeStepper, end: float, h: float, m: int, supplied: float, y: Array) -> None:
    """Complete the end of a step in s.y_new: coordinates, quadratures, what is reported."""
    s, b, rows, each = stepper.scratch, stepper.buffers, stepper.contacts.rows, stepper.contacts.each
    y_new, w, d, n, yielding = s.y_new, s.work, b.acceleration.shape[0], b.states.shape[0], b.yielding
    v0, v1 = y[d : 2 * d], y_new[d : 2 * d]
    for j in range(d):
        s.at[d + j] = 0.5 * (v0[j] + v1[j])
        y_new[j] = y[j] + h * s.at[d + j]
        s.at[j] = 0.5 * (y[j] + y_new[j])
    stepper.system.end_step(h, y[:d], s.at[d : 2 * d], y_new[:d])
    before, after = y[2 * d :], y_new[2 * d :]
    tail = QUADRATURES + OF_A_CONTACT * n
    copy(before, after)
    forces, states = tail + d, tail + d + 2 * n + 1
    for k in range(forces, states + n):
        after[k] = 0.0
    counts, after[states - 1] = after[states + n :], h
    after[DAMPING_LOSS] += h * stepper.system.damping_at(end - 0.5 * h, s.at[:d], s.at[d : 2 * d], w)
    after[SUPPLIED] += h * supplied
    push_body(yielding, h, b.impulses, b.closed, m)
    if stepper.yields:  # the push of the last iteration has worked
        push = stepper.contacts.push
        after[STABILIZATION_LOSS] -= 0.5 * h * (dot(push, v0) + dot(push, v1))
    lost, rebounds = 0.0, False
    for k in range(m):
        i, state = b.closed[k], b.problem.states[k]
        normal, tangential = b.impulses[2 * k], b.impulses[2 * k + 1]
        carried = b.carried[2 * k : 2 * k + 2]
        gap_rate = carried[0] + dot(rows[DIRECTION, k, 0], v0)
        slip_rate_after = carried[1] + dot(rows[DIRECTION, k, 1], v1)
        # twice the mean velocities over the step
        closing = gap_rate + carried[0] + dot(rows[DIRECTION, k, 0], v1)
        slipping = b.slipping[i] + slip_rate_after
        after[SUPPLIED] -= normal * carried[0] + tangential * carried[1]
        if stepper.yields:
            closing += 2.0 / h * yielding.moved[2 * i]
            slipping += 2.0 / h * yielding.moved[2 * i + 1]
        friction, plastic = -0.5 * tangential * slipping, -0.5 * normal * closing
        if stepper.massless:
            slip_rate_after = 0.5 * slipping
        elif stepper.yields:  # friction takes what its law says at the end of the step, the scheme the rest
            slip_rate_after += yielding.moved[2 * i + 1] / h
            after[STABILIZATION_LOSS] += friction + tangential * slip_rate_after
            friction = -tangential * slip_rate_after
        if b.static >= 0.0 and state != OPEN and abs(slip_rate_after) < _STILL * s.tolerances.velocity:
            state = (
                STUCK  # at the edge of its cone too: which contacts are there is rounding if they are redundant
            )
        counted = counts[COUNTED * i : COUNTED * (i + 1)]
        if state != b.states[i]:
            force = before[forces + 2 * i]
            t = _time_of_change(stepper, k, m, state, end, h, gap_rate, force, counted[STEPS])
            _log(stepper, i, state, t, end, gap_rate, slip_rate_after, before, counted)
        lost += plastic + friction
        rebounds = rebounds or b.rebounds[i] > 0.0
        closes = b.states[i] == OPEN and state != OPEN
        b.rebounds[i] = b.restitution * max(-gap_rate, 0.0) if closes else 0.0
        after[forces + 2 * i], after[forces + 2 * i + 1] = normal / h, tangential / h
        b.states[i] = state
        own = QUADRATURES + OF_A_CONTACT * i
        if yielding.elastic:
            end_rate = carried[0] + dot(rows[DIRECTION, k, 0], v1)
            _end_on_stop(stepper, i, h, normal, end_rate, plastic, after)
            plastic = 0.0
        if state == OPEN:
            continue
        counted[STEPS] += 1.0
        counted[LEAST], counted[MOST] = min(counted[LEAST], each[i].slip), max(counted[MOST], each[i].slip)
        if not (stepper.massless or yielding.elastic) and counted[STEPS] <= OF_AN_IMPACT:
            counted[IMPACT_NORMAL] += normal
            counted[IMPACT_TANGENTIAL] += tangential
            # of an impact that jams friction alone may give energy: only the sum is a loss
            counted[PLASTIC_LOSS] += plastic + friction
        else:
            after[own + NORMAL_IMPULSE] += normal
            after[own + TANGENTIAL_IMPULSE] += tangential
            after[own + FRICTION_LOSS] += friction
            counted[PLASTIC_LOSS] += plastic
            counted[PEAK] = max(counted[PEAK], normal / h)
    b.taken[0] = lost + (b.taken[0] if rebounds else 0.0)
    for i in range(n):
        if b.states[i] != OPEN and not b.in_problem[i]:  # beyond the end of a side
            counted = counts[COUNTED * i : COUNTED * (i + 1)]
            _log(stepper, i, OPEN, end - 0.5 * h, end, each[i].gap_rate, 0.0, before, counted)
            b.states[i] = OPEN
            after[QUADRATURES + OF_A_CONTACT * i + STOP_LOSS] += yielding.stored[i]  # what it slides off is lost
            yielding.stored[i], yielding.compressed[i] = 0.0, 0.0
        elif yielding.stored[i] != 0.0 and not b.in_problem[i]:  # a damped stop that follows without force
            _end_on_stop(stepper, i, h, 0.0, each[i].gap_rate, 0.0, after)
        if not b.in_problem[i]:
            b.rebounds[i] = 0.0
        after[states + i] = b.states[i]
    if stepper.yields:
        damping, scheme = end_yielding(yielding, h, b.impulses, b.closed, m)
        after[DAMPING_LOSS] += damping
        after[STABILIZATION_LOSS] += scheme
        for i in range(n):
            counts[COUNTED * i + HELD] = yielding.stored[i] + yielding.held[0] / n
            counts[COUNTED * i + COMPRESSED] = yielding.compressed[i]
    if stepper.massless:
        stepper.system.set_massless(s.at[d : 2 * d], v1)
    for j in range(d):
        after[tail + j] = (v1[j] - v0[j]) / h


@jitable
def _end_on_stop(
    stepper: TimeStepper, i: int, h: float, normal: float, gap_rate: float, taken: float, after: Array
) -> None:
    """Take the end of a step on an elastic stop: of the energy `taken` (J) what it holds, and losses."""
    y, own = stepper.buffers.yielding, QUADRATURES + OF_A_CONTACT * i
    before, c = y.compressed[i], stepper.contacts.each[i]
    left = stepper.buffers.gaps[i] + 0.5 * h * gap_rate + y.displaced[2 * i] + y.moved[2 * i]
    gained, lost = compress(y, i, left), 0.0
    if c.damping > 0.0 or c.linear_damping > 0.0:
        lost = normal / h * (y.compressed[i] - before) - gained
    after[own + STOP_LOSS] += lost
    after[STABILIZATION_LOSS] += taken - gained - lost


@jitable
def _time_of_change(
    stepper: TimeStepper,
    k: int,
    m: int,
    state: int,
    end: float,
    h: float,
    gap_rate: float,
    force: float,
    steps: float,
) -> float:
    """Time (s) at which contact k of m in the problem changes to a state, in a step of length h up to `end`.

    The gap rate (m/s) is that before the step, the normal force (N) that of the step before, the number of steps
    that of the contact until then.
    """
    b, p = stepper.buffers, stepper.buffers.problem
    i, start, middle = b.closed[k], end - h, end - 0.5 * h
    if b.states[i] == OPEN:
        if gap_rate > -_STILL * stepper.scratch.tolerances.velocity:
            return start  # it has been there, as at the start of a run
        return float(middle + min(max(b.gaps[i] / -gap_rate, 0.0), 0.5 * h))
    if state != OPEN:
        return middle
    if steps <= 1.0 or force <= 0.0:
        return start
    rate = p.rates[2 * k]
    for column in range(2 * m):
        rate += p.delassus[2 * k, column] * p.forces[column]
    pull = rate / (p.delassus[2 * k, 2 * k] * h)  # N, that would hold it
    return float(middle - h * pull / (force + pull))


@jitable
def _log(
    stepper: TimeStepper,
    i: int,
    state: int,
    t: float,
    end: float,
    gap_rate: float,
    slip_rate: float,
    quadratures: Array,
    counted: Array,
) -> None:
    """Log a change of the state of contact i at t in the step that ends at `end`; count anew if it closes."""
    b, own, slip = stepper.buffers, QUADRATURES + OF_A_CONTACT * i, stepper.contacts.each[i].slip
    row = b.log[b.logged[0]]
    if b.states[i] == OPEN:
        for k in range(COUNTED):
            counted[k] = 0.0
        counted[LEAST] = counted[MOST] = slip
    b.latest[0] = max(b.latest[0], t)
    row[TIME], row[STEP_END] = b.latest[0], end
    row[CONTACT], row[BEFORE], row[AFTER] = i, b.states[i], state
    row[AT_SLIP], row[CLOSING_RATE], row[SLIPPING_RATE] = slip, gap_rate, slip_rate
    copy(quadratures[own : own + OF_A_CONTACT], row[OWN:LOGGED])
    copy(counted, row[LOGGED:])
    b.logged[0] += 1


@jitable
def _fly(stepper: TimeStepper, flight: Flight | None, now: Position, length: float, end: float, y: Array) -> Step:
    """Take a long step in flight, or refuse it for a shorter one; the compiler drops this where there is none."""
    if flight is None:
        return refused(OK, 0.0)
    b, s, d = stepper.buffers, stepper.scratch, stepper.buffers.acceleration.shape[0]
    h = length if length == now.h else end - now.t
    shorter = refused(OK, max(0.5 * length, stepper.far_step))
    room, speed = flight.nearest[ROOM], flight.nearest[SPEED]
    if stepper.yields:
        _stagger(stepper, now.t, h, y)
        begin_yielding(b.yielding, h, b.gaps, stepper.contacts)
    found = _solve_step(stepper, now.t, h, 2, True, y)
    closest, fits = 0.0, found.status == OK and error_of(flight, h) <= 1.0
    v1 = s.y_new[d : 2 * d]
    if fits:
        for j in range(d):
            b.staggered[j] = y[j] + 0.5 * h * (y[d + j] + v1[j])
        closest, _ = _measure_gaps(stepper, end, b.staggered, v1)
        fits = min(room, flight.nearest[ROOM]) - h * max(speed, flight.nearest[SPEED]) > stepper.near
    if not fits:
        flight.nearest[ROOM], flight.nearest[SPEED] = room, speed
        return shorter
    _finish(stepper, end, h, 0, found.supplied_power, y)
    error = follow(flight, stepper.system, h, b.acceleration, v1, s.work)
    own = 2 * d + QUADRATURES + OF_A_CONTACT * b.states.shape[0]
    keep_samples(flight, now.t, h, y, s.y_new, own, stepper.limits, s.samples)
    longer = error < EASY and now.h < _LONGEST * stepper.far_step
    return Step(OK, True, end, 2.0 * now.h if longer else now.h, NO_GUARD, closest)


class TimeStepper(NamedTuple):
    """Steps of the scheme; a `Stepper`."""

    system: Any
    contacts: Contacts
    limits: Limits
    scratch: Scratch
    buffers: StepBuffers
    far_step: float  # s
    near_step: float  # s, where a place is closer than `near` to its obstacle
    near: float  # m
    tolerance: float  # J^1/2
    rubs: bool  # whether there is friction
    massless: bool  # whether places have no inertia
    yields: bool  # whether there is compliance behind the contacts
    stretches: bool  # whether the axis yields along the beam

    def begin(self, start: StepState, y: Array) -> tuple[int, float]:
        """Measure the gaps."""
        d = self.buffers.acceleration.shape[0]
        self.buffers.logged[0] = 0
        if start.done == 0:
            begin_again(self.buffers.flight)
        closest, _ = _measure_gaps(self, start.t, y[:d], y[d : 2 * d])
        return OK, closest

    def length(self, gap: float, h: float) -> float:
        """Length of the steps here."""
        if gap <= self.near:
            return self.near_step
        room = self.scratch.samples.times.shape[0]
        return length_of_flight(self.buffers.flight, h, self.far_step, self.near, self.limits, room)

    def take(self, now: Position, length: float, end: float, y: Array) -> Step:
        """Take a step with all its contacts."""
        if now.h > self.far_step:
            return _fly(self, self.buffers.flight, now, length, end, y)
        b, h = self.buffers, end - now.t  # as the clock counts
        slot, proposed = 2, length
        if length == now.h:
            slot, h = (0 if length == self.far_step else 1), length
        closest, fastest = _stagger(self, now.t, h, y)
        if length == now.h:
            left, wanted = self.limits.t_stop - now.t, h
            if not (self.massless or b.yielding.elastic) and closest < h * fastest:
                wanted = _aimed(self, h)
            if left - wanted < _LEAST_LEFT * h:  # in a shorter step what is left of a gap would be a velocity
                wanted, end = left, self.limits.t_stop
            elif wanted != h:
                end = now.t + wanted
            if wanted != h:
                slot, h = 2, wanted
                closest, fastest = _stagger(self, now.t, h, y)
            if not (self.massless or b.yielding.elastic):
                _forgive(b.gaps, self.scratch.tolerances.gap)
        if self.yields:
            begin_yielding(b.yielding, h, b.gaps, self.contacts)
        clear = closest > _CLOSE * self.near and closest > 2.0 * h * fastest
        for i in range(b.states.shape[0]):
            clear = clear and b.states[i] == OPEN
        found = _solve_step(self, now.t, h, slot, clear, y)
        if found.status != OK:
            return refused(found.status, 0.0)
        if b.static < 0.0:
            for k in range(found.contacts):
                if b.problem.states[k] == STUCK:  # it slips, though by nothing in this step
                    b.problem.states[k] = FORWARDS if b.slipping[b.closed[k]] >= 0.0 else BACKWARDS
        _finish(self, end, h, found.contacts, found.supplied_power, y)
        if clear:
            d, s = b.acceleration.shape[0], self.scratch
            error = follow(b.flight, self.system, h, b.acceleration, s.y_new[d : 2 * d], s.work)
            proposed = 2.0 * length if error < EASY and length == self.far_step else length
        else:
            begin_again(b.flight)
        return Step(OK, True, end, proposed, NO_GUARD, closest)

    def arrive(self, step: Step, y: Array) -> Step:
        """Keep a sample if one is due."""
        keep_sample(step.end, y, self.limits, self.scratch.samples)
        return step


@dataclass(frozen=True)
class TimeSteppingScheme(Scheme):
    """Time-stepping with one step in flight and one where obstacles are near, for rigid contacts.

    Attributes
    ----------
    free_step, contact_step : float
        s.
    near : float
        Gap (m) below which the contact step is taken.
    tolerance : float
        Of the iterations of a step, on the energy of a correction, as a part of the motion's: the root of it.
    massless : bool
        Whether places have no inertia.
    slowest : float
        Frequency (rad/s) of the slowest vibration: steps in flight are longer than `free_step` where they err no
        more than these do in it, see :mod:`oblique_impact.marching.flight`.  The default 0: all have that length.
    """

    free_step: float
    contact_step: float
    near: float
    tolerance: float
    massless: bool = False
    slowest: float = 0.0
    name = "time-stepping"
    order = 1
    decides = True

    def extra_state(self, size: int, contacts: int, quadratures: int) -> int:
        """Of the last step: acceleration, contact forces, length (s), states; and counts, see `COUNTED`."""
        return size + 1 + (3 + COUNTED) * contacts

    def fill_extra_state(self, prepared: Prepared, y: Array, extra: Array) -> None:
        """Begin to count, with the forces of contacts that go on."""
        extra[: prepared.own.begun.size] = prepared.own.begun
        extra[-prepared.own.resumed.size :] = prepared.own.resumed.ravel()

    def buffers(self, task: Task) -> StepBuffers:  # noqa: D102
        body = task.compliance
        if body is not None and not (self.massless or task.elastic or task.friction.rubs):
            body = None  # the axis alone, along which nothing pulls
        behind = Yielding.new(task.contacts, body, task.elastic)
        flight = Flight.new(task.size, self.slowest, self.free_step) if self.slowest > 0.0 else None
        return StepBuffers.new(task.contacts, task.size, task.friction, task.restitution, behind, flight)

    def step_log(self, prepared: Prepared) -> StepLog:  # noqa: D102
        return StepLog(prepared.own.log, prepared.own.logged, prepared.own.states.size)

    def resume(
        self,
        prepared: Prepared,
        earlier: Mapping[int, Earlier],
        places: Mapping[int, Candidate],
        acceleration: Array,
    ) -> None:
        """Begin in flight, but for these contacts: the first step finds others."""
        b, contacts, d = prepared.own, prepared.contacts, acceleration.size
        b.begun[:d], b.begun[d:] = acceleration, 0.0
        for i, contact in earlier.items():
            at = places[i]
            slips = BACKWARDS if contact.tangential_force > 0.0 else FORWARDS
            b.states[i] = STUCK if contact.state == State.STICK else slips
            b.begun[d + 2 * i : d + 2 * i + 2] = contact.normal_force, contact.tangential_force
            b.resumed[i] = [OF_AN_IMPACT, 0.0, 0.0, 0.0, contact.normal_force, at.slip, at.slip, 0.0, 0.0]
            began = [0.0, 0.0, i, OPEN, b.states[i], at.slip, at.gap_rate, at.slip_rate, *[0.0] * OF_A_CONTACT]
            b.log[b.logged[0]] = [*began, *b.resumed[i]]
            b.logged[0] += 1
            contacts.take(i, contacts.of(i).changed(gap=at.gap, slip=at.slip, gap_rate=at.gap_rate))
        b.begun[d + 2 * b.states.size + 1 :] = b.states
        y = b.yielding
        if y.body is not None or y.elastic:
            for i in earlier:
                contacts.take(i, contacts.of(i).changed(shift=places[i].shift))
            found = contacts.in_python()
            begin_yielding(y, 1.0, np.full(len(found.each), np.inf), found)
            closed, forces = np.array(sorted(earlier)), np.zeros(2 * len(earlier))
            for k, i in enumerate(sorted(earlier)):
                forces[2 * k : 2 * k + 2] = earlier[i].normal_force, earlier[i].tangential_force
                y.relaxed[2 * i : 2 * i + 2] = forces[2 * k : 2 * k + 2]  # the body has yielded to them
            push_body(y, 1.0, forces, closed, len(closed))  # a step of any length
            end_yielding(y, 1.0, forces, closed, len(closed))
            for i in earlier:
                if y.elastic:
                    compress(y, i, places[i].gap + y.displaced[2 * i])
            b.resumed[:, HELD] = y.stored + y.held[0] / len(y.stored)
            b.resumed[:, COMPRESSED] = y.compressed

    def steps_per_call(self, size: int) -> int:  # noqa: D102
        return STEPS_PER_CALL

    def stepper(self, prepared: Prepared, limits: Limits) -> TimeStepper:  # noqa: D102
        scratch = prepared.scratch
        return TimeStepper(
            prepared.system,
            prepared.contacts,
            limits,
            scratch,
            prepared.own,
            float(self.free_step),
            float(self.contact_step),
            float(self.near),
            self.tolerance * float(np.sqrt(scratch.tolerances.energy)),
            bool(np.any(prepared.own.branches[:, 1:])),  # see `FrictionLaw.rubs`
            self.massless,
            prepared.own.yielding.body is not None or prepared.own.yielding.elastic,
            prepared.own.yielding.body is not None and prepared.own.yielding.body.table.shape[1] > 0,
        )

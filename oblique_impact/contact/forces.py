"""Contact forces in each contact state.

The force of a rigid contact follows from the constraint on the acceleration level with Baumgarte's
stabilization, Z'' + c Z' + k Z = 0 (Yuan et al. 2016, Secs. 4 and 5; Baumgarte 1972).  With the
Delassus entries A_nn = D_n M^-1 D_n^T, A_nt, A_tt:

    SLIP    lambda_tau = r lambda_n,  r = intercept + slope Z_tau'
            (A_nn + r A_nt) lambda_n = -(Z_n''free + c Z_n' + k Z_n)
    STICK   both constraints at once, a 2 x 2 system

A compliant stop has no normal constraint: its force is a function of the depth d = -Z_n and its rate, and
never pulls.  Friction and stick are the same.

What the coordinates leave out of a body (the modes above the last one) is compliant too: its compliance G is in
series with the stop, k_eff = 1/(1/k + G), and its viscosity relaxes it in the time eta,

    lambda_n = k_eff (d + eta G k_eff d'),     of a rigid stop  lambda_n = (d + eta d')/G

which is exact for a rigid stop and for eta = 0.  A contact point without inertia lies on a rigid stop while the
coordinates go on by Z_n: its slip is Z_tau + t Z_n, t = tan beta (`inclined`), the force conjugate to Z_n is
N = lambda_n - t lambda_tau, and with lambda_tau = r lambda_n the contact's laws read lambda_tau = r N/(1 - r t).

The factor A_nn + r A_nt is the effective inverse normal mass of the sliding contact; where it is not
positive the forward problem has no solution (Painleve), or the contact opens, also where it could hold.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from oblique_impact.contact.state import (
    FREE,
    NO_CONTACT,
    SLIDING,
    STICKING,
    Guards,
    Instant,
    Phase,
    Residual,
    Stick,
    Stop,
)
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.laws import Law
from oblique_impact.kernels.system import System
from oblique_impact.kernels.workspace import Array, Evaluation, Workspace, copy, dot

#: status of a solution of the contact problem
OK, MASS_NOT_POSITIVE, NO_SLIDING_SOLUTION, NO_STICKING_SOLUTION = 0, 1, 2, 3

#: relative determinant of the 2 x 2 system of a sticking contact, which is rounding where it is smaller
SINGULAR = 1e-13
#: relative effective inverse mass at which sliding ends: the force grows as its inverse, and steps up to 0 would
#: shrink without end
NEARLY_PAINLEVE = 1e-9


class Forces(NamedTuple):
    """Contact forces (N), or the reason why there are none."""

    status: int
    normal: float
    tangential: float


@inlined
def spring_force(depth: float, rate: float, stiffness: float, damping: float) -> float:
    """Force (N) of a linear spring with Hunt and Crossley's damping, which may be negative."""
    return stiffness * depth * (1.0 + damping * rate)


@inlined
def share_of(slip: float, first: float, last: float, cell: float) -> tuple[float, float]:
    """Part of a cell (m) of the beam that is over a bedding, and its derivative by the slip (1/m).

    Between `first` and `last` (m along the side) some of the cell is.
    """
    share, fading = 1.0, 0.0
    if cell > 0.0:
        if slip - first < cell:
            share, fading = share - 1.0 + (slip - first) / cell, fading + 1.0 / cell
        if last - slip < cell:
            share, fading = share - 1.0 + (last - slip) / cell, fading - 1.0 / cell
    return (share, fading) if share > 0.0 else (0.0, 0.0)


@inlined
def end_push(stop: Stop, gap: float) -> float:
    """Force (N) along the slide of a bedding under a cell of the beam that lies over an end of it.

    It is what the energy 1/2 k d^2 of springs under the cell changes by as more or fewer of them lie there.
    """
    depth = max(0.0, -gap)
    return -0.5 * stop.stiffness * stop.fading * depth * depth


@inlined
def _law_force(law: Law | None, stop: Stop, depth: float, rate: float) -> float:
    """Force (N) of the law of a stop alone, which may be negative; the compiler drops one of the two branches."""
    if law is None:
        return spring_force(depth, rate, stop.share * stop.stiffness, stop.damping)
    return law(depth, rate)


@jitable
def own_force(stop: Stop, depth: float, rate: float) -> float:
    """Force (N) of the stop alone at its compression (m) and rate (m/s), never negative."""
    return max(0.0, _law_force(stop.law, stop, depth, rate))


@jitable
def stop_force(stop: Stop, residual: Residual, gap: float, gap_rate: float) -> float:
    """Return the normal force (N) of a compliant stop at the depth -gap, never negative."""
    depth, rate = max(0.0, -gap), -gap_rate
    if residual.compliance == 0.0:
        return own_force(stop, depth, rate)
    if stop.massless:
        return max(0.0, (depth + residual.relaxation * rate) / residual.compliance)
    if depth == 0.0:
        return 0.0
    force = _force_in_series(stop.law, stop, residual.compliance, depth, rate)
    return max(0.0, force * (1.0 + residual.relaxation * residual.compliance * force * rate / (depth * depth)))


@jitable
def _force_in_series(law: Law | None, stop: Stop, compliance: float, depth: float, rate: float) -> float:
    """Force (N) of a stop behind a spring of this compliance (m/N), which take the depth (m) together.

    The stop's part of the rate is its part of the depth at rest: the spring follows without inertia.  The compiler
    drops one of the two branches.
    """
    if law is None:
        stiffness = stop.share * stop.stiffness
        stiffness *= 1.0 + stop.damping * rate / (1.0 + stiffness * compliance)
        return depth / (1.0 / stiffness + compliance) if stiffness > 0.0 else 0.0
    if rate != 0.0:
        rate *= 1.0 - compliance * _bracketed_force(stop, compliance, depth, 0.0) / depth
    return _bracketed_force(stop, compliance, depth, rate)


@jitable
def _bracketed_force(stop: Stop, compliance: float, depth: float, rate: float) -> float:
    """Force (N) of a stop of any law at the compression (m) that a spring in series leaves it, at a given rate.

    The regula falsi (Illinois); where a step has not halved the bracket the next one does, so that it ends, at the
    latest with two neighbouring numbers.  Some ten steps are usual.  A law that pushes more than the spring bears
    where it is not yet compressed leaves the spring the whole depth.
    """
    above = own_force(stop, depth, rate)
    low, high, halve = 0.0, min(above, depth / compliance), False
    below = high - own_force(stop, max(0.0, depth - compliance * high), rate)
    if not below > 0.0:
        return high
    while True:
        middle = low + 0.5 * (high - low)
        if not low < middle < high:
            return high
        force = middle if halve else (low * below + high * above) / (above + below)
        if not low < force < high:
            force = middle
        width, error = high - low, own_force(stop, max(0.0, depth - compliance * force), rate) - force
        if abs(error) <= 1e-15 * force:  # of a law that grows with the depth the force is as close
            return force
        if error > 0.0:
            low, above, below = force, error, 0.5 * below
        else:
            high, below, above = force, -error, 0.5 * above
        halve = high - low > 0.5 * width


@jitable
def stop_tangent(stop: Stop, residual: Residual, gap: float, gap_rate: float) -> tuple[float, float]:
    """Slopes of the stop's force over depth (N/m) and rate of depth (N s/m); 0 if it does not push.

    Differences are enough: only the pace of Newton's iterations depends on them.
    """
    force = stop_force(stop, residual, gap, gap_rate)
    if not force > 0.0:
        return 0.0, 0.0
    deeper, faster, over_depth, over_rate = 1e-6 * max(0.0, -gap), 1e-6 * abs(gap_rate), 0.0, 0.0
    if deeper > 0.0:
        over_depth = (stop_force(stop, residual, gap - deeper, gap_rate) - force) / deeper
    if faster > 0.0:
        over_rate = (stop_force(stop, residual, gap, gap_rate - faster) - force) / faster
    return over_depth, over_rate


@inlined
def friction_ratio(phase: Phase, slip_rate: float) -> float:
    """lambda_tau / N of a sliding contact, N = lambda_n - tilt lambda_tau; see `can_slide`."""
    ratio = phase.friction.intercept + phase.friction.slope * slip_rate
    return ratio / (1.0 - ratio * phase.residual.tilt)


@inlined
def can_slide(phase: Phase, slip_rate: float) -> bool:
    """Whether the force of a stop can push a contact point without inertia while it slides."""
    return (
        phase.friction.intercept + phase.friction.slope * slip_rate
    ) * phase.residual.tilt < 1.0 - NEARLY_PAINLEVE


@inlined
def conjugate(phase: Phase, c: Instant) -> float:
    """Force (N) conjugate to the gap, N = lambda_n - tilt lambda_tau."""
    return c.normal_force - phase.residual.tilt * c.tangential_force


@inlined
def inclined(phase: Phase, c: Instant) -> Instant:
    """Return a contact problem of coordinates as that of the contact point, whose slip is Z_tau + tilt Z_n."""
    t = phase.residual.tilt
    return Instant(
        c.gap,
        c.slip + t * c.gap,
        c.gap_rate,
        c.slip_rate + t * c.gap_rate,
        c.a_nn,
        c.a_nt + t * c.a_nn,
        c.a_tt + t * (2.0 * c.a_nt + t * c.a_nn),
        c.gap_acceleration,
        c.slip_acceleration + t * c.gap_acceleration,
        c.normal_force,
        c.tangential_force,
        c.damping_power,
        c.supplied_power,
    )


@inlined
def drift_of(stick: Stick, c: Instant) -> float:
    """Slip (m) of a sticking contact from where it is held."""
    return (c.slip - stick.slip) * stick.held


@inlined
def axial_force(stick: Stick, slip: float) -> float:
    """Tangential force (N) of a contact that sticks on the axial flexibility, at its slip (m)."""
    return (stick.slip - slip) / stick.compliance


@inlined
def friction_rate(phase: Phase, c: Instant) -> float:
    """Rate of the friction (N/s) of a contact that slides on an elastic stop without damping."""
    in_series = 1.0 / phase.stop.stiffness + phase.residual.compliance
    return -phase.friction.intercept * c.gap_rate / in_series


@inlined
def slip_velocity(phase: Phase, c: Instant) -> float:
    """Velocity (m/s) that friction sees while a contact slides, as its force stretches the axis."""
    if phase.stick.compliance == 0.0 or not phase.stop.compliant:  # of a rigid stop see `add_stretch`
        return c.slip_rate
    return c.slip_rate + phase.stick.compliance * friction_rate(phase, c)


@inlined
def sliding_inertia(phase: Phase, c: Instant) -> float:
    """Effective inverse normal mass (1/kg) of a contact that slides on a rigid stop, which may be negative."""
    return c.a_nn + friction_ratio(phase, c.slip_rate) * c.a_nt


@jitable
def sliding_force(phase: Phase, c: Instant) -> Forces:
    """Contact force of a sliding contact, 0 of one that opens; NO_SLIDING_SOLUTION if Painleve.

    Where the effective inverse mass is not positive a gap that grows without force solves the problem, perhaps
    among others.
    """
    ratio = friction_ratio(phase, c.slip_rate)
    if phase.stop.compliant:
        if not can_slide(phase, c.slip_rate):
            return Forces(NO_SLIDING_SOLUTION, 0.0, 0.0)
        push = stop_force(phase.stop, phase.residual, c.gap, c.gap_rate)
        return Forces(OK, push * (1.0 + phase.residual.tilt * ratio), ratio * push)
    effective = sliding_inertia(phase, c)
    if not effective > 0.0:
        return Forces(OK if _stabilized(phase, c) >= 0.0 else NO_SLIDING_SOLUTION, 0.0, 0.0)
    normal = -_stabilized(phase, c) / effective
    return Forces(OK, normal, ratio * normal)


@inlined
def _stabilized(phase: Phase, c: Instant) -> float:
    """Acceleration of the gap (m/s^2) that the force of a rigid stop takes up."""
    return c.gap_acceleration + phase.stabilization.damping * c.gap_rate + phase.stabilization.stiffness * c.gap


@jitable
def sticking_force(phase: Phase, c: Instant) -> Forces:
    """Both forces of a contact that sticks; NO_STICKING_SOLUTION if the constraints are redundant."""
    if phase.stick.compliance != 0.0:
        hold = axial_force(phase.stick, c.slip)
        if not phase.stop.compliant:
            return Forces(OK, -(_stabilized(phase, c) + c.a_nt * hold) / c.a_nn, hold)
        return Forces(OK, stop_force(phase.stop, phase.residual, c.gap, c.gap_rate), hold)
    drift = drift_of(phase.stick, c)
    return holding_force(
        phase, c, phase.stabilization.damping * c.slip_rate + phase.stabilization.stiffness * drift
    )


@jitable
def holding_force(phase: Phase, c: Instant, correction: float) -> Forces:
    """Both forces that keep the gap and give the slip the acceleration -correction (m/s^2)."""
    tangential = c.slip_acceleration + correction
    if phase.stop.compliant:
        if not c.a_tt > 0.0:
            return Forces(NO_STICKING_SOLUTION, 0.0, 0.0)
        push = stop_force(phase.stop, phase.residual, c.gap, c.gap_rate)
        hold = -(tangential + c.a_nt * push) / c.a_tt
        return Forces(OK, push + phase.residual.tilt * hold, hold)
    determinant = c.a_nn * c.a_tt - c.a_nt * c.a_nt
    if not determinant > SINGULAR * c.a_nn * c.a_tt:
        return Forces(NO_STICKING_SOLUTION, 0.0, 0.0)
    normal = _stabilized(phase, c)
    return Forces(
        OK,
        (c.a_nt * tangential - c.a_tt * normal) / determinant,
        (c.a_nt * normal - c.a_nn * tangential) / determinant,
    )


@jitable
def contact_force(phase: Phase, c: Instant) -> Forces:
    """Contact force of a closed contact in its state."""
    return sliding_force(phase, c) if phase.state == SLIDING else sticking_force(phase, c)


@jitable
def can_stick(phase: Phase, c: Instant, stopping_time: float) -> bool:
    """Whether contact sticks, for a scheme that does not locate the end of slip.

    The force that keeps it sticking lies in the friction cone, and the sliding force stops the slip within
    `stopping_time` (s) or has done so.  With an infinite time the slip velocity is not asked for, as the paper
    writes in Sec. 5.3; the force is then that of the stabilized constraint.
    """
    correction = 0.0
    if stopping_time < 1e300:
        if phase.state == SLIDING:
            acceleration = c.slip_acceleration + c.a_nt * c.normal_force + c.a_tt * c.tangential_force
            ahead = c.slip_rate + stopping_time * acceleration
            direction = 1.0 if phase.friction.lower >= 0.0 else -1.0
            if c.slip_rate * direction > 0.0 and ahead * direction > 0.0:
                return False
    else:
        drift = drift_of(phase.stick, c) if phase.state == STICKING else 0.0
        correction = phase.stabilization.damping * c.slip_rate + phase.stabilization.stiffness * drift
    force = holding_force(phase, c, correction)
    inside = abs(force.tangential) <= phase.stick.static * force.normal
    return force.status == OK and force.normal > 0.0 and inside


@inlined
def instant_of(e: Evaluation, w: Workspace) -> Instant:
    """Reduce an evaluated system, whose mass matrix is solved for, to its contact; no force yet."""
    v = w.vectors
    return Instant(
        e.gap,
        e.slip,
        e.gap_rate,
        e.slip_rate,
        dot(v.normal_row, v.normal_response),
        dot(v.normal_row, v.tangential_response),
        dot(v.tangential_row, v.tangential_response),
        dot(v.normal_row, v.free_acceleration) + e.gap_bias,
        dot(v.tangential_row, v.free_acceleration) + e.slip_bias,
        0.0,
        0.0,
        e.damping_power,
        e.supplied_power,
    )


@inlined
def moved(c: Instant, e: Any, normal: float, tangential: float, supplied: float, tilt: float = 0.0) -> Instant:
    """Return a contact problem with the kinematics and damping of `e`, an `Evaluation` or `Instant`.

    Forces are in N, the power supplied by drives in W; Delassus entries and accelerations are those of `c`.  The
    slip is that of a contact point without inertia if there is a `tilt`.
    """
    return Instant(
        e.gap,
        e.slip + tilt * e.gap,
        e.gap_rate,
        e.slip_rate + tilt * e.gap_rate,
        c.a_nn,
        c.a_nt,
        c.a_tt,
        c.gap_acceleration,
        c.slip_acceleration,
        normal,
        tangential,
        e.damping_power,
        supplied,
    )


@inlined
def flying(e: Evaluation) -> Instant:
    """Return the instant of an evaluated system in flight; its contact problem is left out."""
    return moved(NO_CONTACT, e, 0.0, 0.0, e.supplied_power)


@inlined
def with_forces(c: Instant, normal: float, tangential: float, supplied: float) -> Instant:
    """Return an instant with its contact forces (N) and the power supplied by drives (W)."""
    return moved(c, c, normal, tangential, supplied)


@jitable
def accelerate(system: System, phase: Phase, t: float, q: Array, qd: Array, w: Workspace) -> tuple[int, Instant]:
    """Acceleration of `phase` at (t, q, q') into the workspace; returns a status and the contact with its forces.

    The status is OK or the reason why there is no solution; then forces are 0 and the acceleration is void.
    """
    e = system.evaluate(t, q, qd, w)
    v = w.vectors
    free_acceleration, acceleration, supply = v.free_acceleration, v.acceleration, v.supply
    normal_response, tangential_response = v.normal_response, v.tangential_response
    contact = phase.state != FREE
    if not system.solve_mass(e.rank_one, w, contact):
        return MASS_NOT_POSITIVE, flying(e)
    if not contact:
        copy(free_acceleration, acceleration)
        supplied = e.supplied_power + dot(supply, acceleration)
        return OK, moved(NO_CONTACT, e, 0.0, 0.0, supplied)
    c = inclined(phase, instant_of(e, w))
    force = contact_force(phase, c)
    if force.status != OK:
        return force.status, c
    for i in range(q.shape[0]):
        push = normal_response[i] * force.normal + tangential_response[i] * force.tangential
        acceleration[i] = free_acceleration[i] + push
    supplied = e.supplied_power + dot(supply, acceleration)
    return OK, with_forces(c, force.normal, force.tangential, supplied)


@jitable
def guards_of(phase: Phase, c: Instant, yielding: float = 0.0) -> Guards:
    """Guards of the state at an instant with its forces; 1 where a state has none.

    The axial flexibility yields with a velocity (m/s) to the forces of other contacts.
    """
    if phase.state == FREE:
        return Guards(phase.surface.side * c.gap if phase.surface.enabled else 1.0, 1.0, 1.0, 1.0, 1.0)
    end = 1.0
    if phase.surface.last < 1e300:  # about the distance from the nearer end, but smooth
        end = (
            (c.slip - phase.surface.first)
            * (phase.surface.last - c.slip)
            / (phase.surface.last - phase.surface.first)
        )
    normal = -c.gap if phase.stop.compliant else c.normal_force
    if phase.state == SLIDING:
        rate = slip_velocity(phase, c) + yielding
        definite = 1.0  # of a compliant stop it is decided as the slip begins
        if not phase.stop.compliant:
            definite = 1.0 + friction_ratio(phase, c.slip_rate) * c.a_nt / c.a_nn - NEARLY_PAINLEVE
        return Guards(
            normal,
            rate - phase.friction.lower if phase.friction.lower > -1e300 else 1.0,
            phase.friction.upper - rate if phase.friction.upper < 1e300 else 1.0,
            definite,
            end,
        )
    limit = phase.stick.static * c.normal_force  # of the friction cone
    return Guards(normal, limit - c.tangential_force, limit + c.tangential_force, 1.0, end)

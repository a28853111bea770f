"""Contact: states, contact forces of each state, impulses, the Painleve check. No stepping here.

The contact force of a state follows from the constraint on the acceleration level with Baumgarte's
stabilization, Z'' + c Z' + k Z = 0 (Yuan et al. 2016, Secs. 4 and 5; Baumgarte 1972).  With the
Delassus entries A_nn = D_n M^-1 D_n^T, A_nt, A_tt:

    SLIP    lambda_tau = r lambda_n,  r = intercept + slope Z_tau'
            (A_nn + r A_nt) lambda_n = -(Z_n''free + c Z_n' + k Z_n)
    STICK   both constraints at once, a 2 x 2 system

A compliant stop has no normal constraint: its force follows from the depth d = -Z_n and its rate, and never
pulls.  The built-in one is lambda_n = k d (1 + c d') (Hunt and Crossley 1975); a law of one's own is called by
its address.  Friction and stick are the same.

The factor A_nn + r A_nt is the effective inverse normal mass of the sliding contact; where it is not
positive the forward problem has no or several solutions (Painleve).
"""

from __future__ import annotations

from enum import IntEnum
from math import inf
from typing import Any, NamedTuple

import numpy as np

from oblique_impact.kernels.dense import row_dot, solve_mass
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.pointers import call_2
from oblique_impact.kernels.system import (
    A_NN,
    A_NT,
    A_TT,
    ACCELERATION,
    FIRST_GUARD,
    FREE_ACCELERATION,
    GAP,
    GAP_ACCELERATION,
    GAP_BIAS,
    GAP_RATE,
    GUARDS,
    LAMBDA_N,
    LAMBDA_T,
    NORMAL_RESPONSE,
    NORMAL_ROW,
    SLIP,
    SLIP_ACCELERATION,
    SLIP_BIAS,
    SLIP_RATE,
    TANGENT_RESPONSE,
    TANGENT_ROW,
    Array,
    Work,
    evaluate,
)

FREE, SLIDING, STICKING = 0, 1, 2

# What a solution of the contact problem can say about itself
OK, MASS_NOT_POSITIVE, NO_SLIDING_SOLUTION, NO_STICKING_SOLUTION = 0, 1, 2, 3

# Guards of a state: each is positive while the state persists
GUARD_NORMAL, GUARD_LOWER, GUARD_UPPER, GUARD_DEFINITE = 0, 1, 2, 3

_SINGULAR = 1e-13  # relative; below it the 2 x 2 system of a sticking contact has no unique solution
_NEARLY_PAINLEVE = 1e-9  # relative effective inverse mass at which sliding ends


class State(IntEnum):
    """Contact state; the values are those of the variable `state` in a history."""

    FREE = FREE
    SLIP = SLIDING
    STICK = STICKING


class Phase(NamedTuple):
    """A contact state with all its parameters, as the marching source needs it.

    While sliding, lambda_tau = (intercept + slope Z_tau') lambda_n holds for lower < Z_tau' < upper.
    While sticking, |lambda_tau| <= static lambda_n holds and Z_tau is kept at slip_reference.
    """

    state: int = FREE
    intercept: float = 0.0
    slope: float = 0.0  # s/m
    lower: float = -inf  # m/s
    upper: float = inf  # m/s
    static: float = -1.0  # negative: a law without a stick state
    slip_reference: float = 0.0  # m
    damping: float = 0.0  # 1/s, coefficient of Z' in Baumgarte's equation
    stiffness: float = 0.0  # 1/s^2, coefficient of Z
    watched: bool = True  # False: contact is switched off and the gap is not watched
    spring: float = 0.0  # N/m, stiffness of an elastic stop; 0: a rigid one; infinite: a law of one's own
    dashpot: float = 0.0  # s/m, its Hunt-Crossley damping
    law: int = 0  # address of a contact law of one's own, lambda_n(d, d')


@jitable
def condense(system: Any, work: Work) -> bool:
    """Reduce an evaluated system to its contact: free acceleration, M^-1 D^T and Delassus entries."""
    v, k = work.vectors, work.scalars
    if not solve_mass(system, work, True):
        return False
    k[A_NN] = row_dot(v, NORMAL_ROW, NORMAL_RESPONSE)
    k[A_NT] = row_dot(v, NORMAL_ROW, TANGENT_RESPONSE)
    k[A_TT] = row_dot(v, TANGENT_ROW, TANGENT_RESPONSE)
    k[GAP_ACCELERATION] = row_dot(v, NORMAL_ROW, FREE_ACCELERATION) + k[GAP_BIAS]
    k[SLIP_ACCELERATION] = row_dot(v, TANGENT_ROW, FREE_ACCELERATION) + k[SLIP_BIAS]
    return True


@jitable
def stop_force(phase: Phase, gap: float, gap_rate: float) -> float:
    """Return the normal force (N) of a compliant stop at depth -gap, never negative."""
    depth = max(0.0, -gap)
    if phase.law != 0:
        return max(0.0, call_2(phase.law, depth, -gap_rate))
    return max(0.0, phase.spring * depth * (1.0 - phase.dashpot * gap_rate))


@jitable
def stop_tangent(phase: Phase, gap: float, gap_rate: float) -> tuple[float, float]:
    """Slopes of the force of a compliant stop over depth (N/m) and rate of depth (N s/m); 0 if it is open."""
    depth = max(0.0, -gap)
    if phase.law != 0:
        force = call_2(phase.law, depth, -gap_rate)
        if not force > 0.0:
            return 0.0, 0.0
        # differences are enough: only the pace of Newton's iterations depends on them
        deeper, faster = 1e-6 * depth + 1e-12, 1e-6 * abs(gap_rate) + 1e-9
        over_depth = (call_2(phase.law, depth + deeper, -gap_rate) - force) / deeper
        return over_depth, (call_2(phase.law, depth, -gap_rate + faster) - force) / faster
    grip = 1.0 - phase.dashpot * gap_rate
    if not depth * grip > 0.0:
        return 0.0, 0.0
    return phase.spring * grip, phase.spring * depth * phase.dashpot


@jitable
def sliding_force(phase: Phase, k: Array) -> int:
    """Contact force of a sliding contact into the scalars `k`; NO_SLIDING_SOLUTION if Painleve."""
    ratio = phase.intercept + phase.slope * k[SLIP_RATE]
    if phase.spring > 0.0:
        k[LAMBDA_N] = stop_force(phase, k[GAP], k[GAP_RATE])
        k[LAMBDA_T] = ratio * k[LAMBDA_N]
        return OK
    effective = k[A_NN] + ratio * k[A_NT]
    if not effective > 0.0:
        return NO_SLIDING_SOLUTION
    target = k[GAP_ACCELERATION] + phase.damping * k[GAP_RATE] + phase.stiffness * k[GAP]
    k[LAMBDA_N] = -target / effective
    k[LAMBDA_T] = ratio * k[LAMBDA_N]
    return OK


@jitable
def sticking_force(phase: Phase, reference: float, k: Array) -> int:
    """Both forces of a contact that sticks at slip `reference` into the scalars `k`.

    Returns NO_STICKING_SOLUTION if the two constraints are redundant.
    """
    drift = k[SLIP] - reference
    tangential = k[SLIP_ACCELERATION] + phase.damping * k[SLIP_RATE] + phase.stiffness * drift
    if phase.spring > 0.0:
        if not k[A_TT] > 0.0:
            return NO_STICKING_SOLUTION
        k[LAMBDA_N] = stop_force(phase, k[GAP], k[GAP_RATE])
        k[LAMBDA_T] = -(tangential + k[A_NT] * k[LAMBDA_N]) / k[A_TT]
        return OK
    determinant = k[A_NN] * k[A_TT] - k[A_NT] * k[A_NT]
    if not determinant > _SINGULAR * k[A_NN] * k[A_TT]:
        return NO_STICKING_SOLUTION
    normal = k[GAP_ACCELERATION] + phase.damping * k[GAP_RATE] + phase.stiffness * k[GAP]
    k[LAMBDA_N] = (k[A_NT] * tangential - k[A_TT] * normal) / determinant
    k[LAMBDA_T] = (k[A_NT] * normal - k[A_NN] * tangential) / determinant
    return OK


@jitable
def accelerate(system: Any, phase: Phase, t: float, q: Array, qd: Array, work: Work) -> int:
    """Acceleration and contact force of `phase` at (t, q, q') into `work`.

    Returns OK or the reason why there is none.
    """
    evaluate(system, t, q, qd, work)
    v, k = work.vectors, work.scalars
    k[LAMBDA_N] = 0.0
    k[LAMBDA_T] = 0.0
    if phase.state == FREE:
        if not solve_mass(system, work, False):
            return MASS_NOT_POSITIVE
        for i in range(v.shape[1]):
            v[ACCELERATION, i] = v[FREE_ACCELERATION, i]
        return OK
    if not condense(system, work):
        return MASS_NOT_POSITIVE
    sliding = phase.state == SLIDING
    status = sliding_force(phase, k) if sliding else sticking_force(phase, phase.slip_reference, k)
    if status == OK:
        for i in range(v.shape[1]):
            push = v[NORMAL_RESPONSE, i] * k[LAMBDA_N] + v[TANGENT_RESPONSE, i] * k[LAMBDA_T]
            v[ACCELERATION, i] = v[FREE_ACCELERATION, i] + push
    return status


@jitable
def measure_guards(phase: Phase, k: Array) -> None:
    """Guards of the state at an accelerated instant into the scalars `k`; positive while it persists."""
    for i in range(GUARDS):
        k[FIRST_GUARD + i] = 1.0
    if phase.state == FREE:
        if phase.watched:
            k[FIRST_GUARD + GUARD_NORMAL] = k[GAP]
        return
    k[FIRST_GUARD + GUARD_NORMAL] = -k[GAP] if phase.spring > 0.0 else k[LAMBDA_N]
    if phase.state == SLIDING:
        if phase.lower > -np.inf:
            k[FIRST_GUARD + GUARD_LOWER] = k[SLIP_RATE] - phase.lower
        if phase.upper < np.inf:
            k[FIRST_GUARD + GUARD_UPPER] = phase.upper - k[SLIP_RATE]
        ratio = 0.0 if phase.spring > 0.0 else phase.intercept + phase.slope * k[SLIP_RATE]
        k[FIRST_GUARD + GUARD_DEFINITE] = 1.0 + ratio * k[A_NT] / k[A_NN] - _NEARLY_PAINLEVE
    else:
        k[FIRST_GUARD + GUARD_LOWER] = phase.static * k[LAMBDA_N] - k[LAMBDA_T]
        k[FIRST_GUARD + GUARD_UPPER] = phase.static * k[LAMBDA_N] + k[LAMBDA_T]


class Instant(NamedTuple):
    """The contact problem at an instant, without contact force (SI units)."""

    gap: float
    slip: float
    gap_rate: float
    slip_rate: float
    a_nn: float
    a_nt: float
    a_tt: float
    gap_acceleration: float
    slip_acceleration: float

    def sliding(self, ratio: float) -> float | None:
        """Return the normal force when lambda_tau = ratio lambda_n; None in a Painleve configuration."""
        effective = self.a_nn + ratio * self.a_nt
        return -self.gap_acceleration / effective if effective > 0.0 else None

    def sticking(self) -> tuple[float, float] | None:
        """(lambda_n, lambda_tau) of a sticking contact; None if the constraints are redundant."""
        determinant = self.a_nn * self.a_tt - self.a_nt**2
        if not determinant > _SINGULAR * self.a_nn * self.a_tt:
            return None
        normal, tangential = self.gap_acceleration, self.slip_acceleration
        return (
            (self.a_nt * tangential - self.a_tt * normal) / determinant,
            (self.a_nt * normal - self.a_nn * tangential) / determinant,
        )


def instant_of(work: Work) -> Instant:
    """Read the contact problem out of a condensed `work`."""
    k = work.scalars
    rates = (float(k[i]) for i in (GAP, SLIP, GAP_RATE, SLIP_RATE))
    return Instant(*rates, *(float(k[i]) for i in (A_NN, A_NT, A_TT, GAP_ACCELERATION, SLIP_ACCELERATION)))


class Impulse(NamedTuple):
    """Impulse of an impact (N s) and the kinetic energy it takes (J)."""

    normal: float
    tangential: float
    energy_loss: float


def impulse_of(instant: Instant, normal: float, tangential: float) -> Impulse:
    """Complete an impulse by its energy loss, -(P v + 1/2 P A P) with the Delassus matrix A."""
    work_on_system = (
        normal * instant.gap_rate
        + tangential * instant.slip_rate
        + 0.5 * (instant.a_nn * normal**2 + instant.a_tt * tangential**2)
        + instant.a_nt * normal * tangential
    )
    return Impulse(normal, tangential, -work_on_system)


def newton_impulse(instant: Instant, restitution: float) -> Impulse:
    """Frictionless impulse with Newton's restitution: I = -(1 + e) Z_n' / A_nn (paper Eq. 36)."""
    return impulse_of(instant, -(1.0 + restitution) * instant.gap_rate / instant.a_nn, 0.0)


def routh_impulse(instant: Instant, restitution: float, friction: float) -> Impulse:
    """Impulse of a frictional impact by Routh's method with Poisson's restitution.

    The normal impulse P grows; the contact slides with dP_tau = -mu s dP until Z_tau' vanishes, then
    sticks if the cone allows (|A_nt| <= mu A_tt) and slides on or back otherwise.  Compression ends at Z_n' = 0;
    restitution adds e times its impulse (Routh 1905; Wang and Mason, J. Appl. Mech. 59, 1992).

    Raises ValueError where compression never ends (a jam: the sliding contact gains normal speed).
    """
    path = _RouthPath(instant, friction)
    compression = path.advance_to_end_of_compression()
    path.advance(restitution * compression)
    return impulse_of(instant, path.normal, path.tangential)


class _RouthPath:
    """State of a frictional impact as a function of the normal impulse."""

    def __init__(self, instant: Instant, friction: float) -> None:
        self._instant, self._friction = instant, friction
        self.normal = self.tangential = 0.0
        self._gap_rate, self._slip_rate = instant.gap_rate, instant.slip_rate
        self._ratio = self._ratio_at(self._slip_rate)

    def _ratio_at(self, slip_rate: float) -> float:
        """dP_tau / dP of the branch that starts at `slip_rate`."""
        if slip_rate != 0.0:
            return -self._friction * float(np.sign(slip_rate))
        sticking = -self._instant.a_nt / self._instant.a_tt
        return float(np.clip(sticking, -self._friction, self._friction))

    def _rates(self) -> tuple[float, float]:
        i = self._instant
        return i.a_nn + self._ratio * i.a_nt, i.a_nt + self._ratio * i.a_tt

    def _move(self, step: float) -> None:
        gap_growth, slip_growth = self._rates()
        self.normal += step
        self.tangential += self._ratio * step
        self._gap_rate += gap_growth * step
        self._slip_rate += slip_growth * step

    def _to_zero_slip(self) -> float:
        growth = self._rates()[1]
        return -self._slip_rate / growth if self._slip_rate * growth < 0.0 else inf

    def _stop_slipping(self, step: float) -> None:
        self._move(step)
        self._slip_rate = 0.0
        self._ratio = self._ratio_at(0.0)

    def advance(self, step: float) -> None:
        """Let the normal impulse grow by `step`."""
        to_stop = self._to_zero_slip()
        if to_stop < step:
            self._stop_slipping(to_stop)
            step -= to_stop
        self._move(step)

    def advance_to_end_of_compression(self) -> float:
        """Advance until Z_n' = 0; returns the normal impulse of compression."""
        for _ in range(2):
            growth = self._rates()[0]
            to_end = -self._gap_rate / growth if growth > 0.0 else inf
            to_stop = self._to_zero_slip()
            if to_end < inf and abs(to_stop - to_end) <= _SINGULAR * to_end:
                # both at once, as they do in a system of one degree of freedom; rounding must not choose
                self._stop_slipping(to_end)
                return self.normal
            if to_end <= to_stop:
                if to_end == inf:
                    break
                self._move(to_end)
                return self.normal
            self._stop_slipping(to_stop)
        raise ValueError("compression never ends: the impact jams at this friction coefficient")

"""Contact states and the numbers that describe a contact at an instant."""

from __future__ import annotations

from enum import IntEnum
from math import inf
from typing import NamedTuple

import numpy as np

from oblique_impact.kernels.laws import Law, compiled_law
from oblique_impact.kernels.workspace import Array

FREE, SLIDING, STICKING = 0, 1, 2


class State(IntEnum):
    """Contact state; the values are those of the variable `state` in a history."""

    FREE = FREE
    SLIP = SLIDING
    STICK = STICKING


class Phase(NamedTuple):
    """A contact state with all its parameters, as kernels need it.

    While sliding, lambda_tau = (intercept + slope Z_tau') lambda_n holds for lower < Z_tau' < upper.
    While sticking, |lambda_tau| <= static lambda_n holds and Z_tau is kept at slip_reference.
    """

    stop_law: Law  # lambda_n(d, d', stop_parameters) of a stop that gives way
    stop_parameters: Array
    gives_way: bool = False  # False: a rigid stop
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
    side: float = 1.0  # in flight: 1 above the line of the slope, -1 below it, beyond an end
    first: float = -inf  # m along the slope: its ends, where contact ends
    last: float = inf
    massless: bool = False  # a contact point without inertia on a rigid stop, which gives way by its compliance
    # of what the coordinates leave out, see `Residual`
    compliance: float = 0.0
    relaxation: float = 0.0
    tilt: float = 0.0


class Residual(NamedTuple):
    """What the coordinates of a body leave out of its contact point, from the beginning of a contact to its end.

    The modes above the last one give way as well: without inertia they are a spring and a dashpot behind the
    contact point, in series with the stop.  A point without inertia rests on a rigid stop whatever the coordinates
    do, so that its slip is Z_tau + tilt Z_n.
    """

    compliance: float = 0.0  # m/N along the normal
    relaxation: float = 0.0  # s, viscosity over stiffness
    tilt: float = 0.0  # tan beta of a contact point without inertia, beta between normal and its free direction


class Instant(NamedTuple):
    """The contact problem at an instant and what solves it (SI units).

    The accelerations are those without contact force; the forces are 0 until a state has given them.
    """

    gap: float
    slip: float
    gap_rate: float
    slip_rate: float
    a_nn: float = 0.0  # Delassus entries D_n M^-1 D_n^T, D_n M^-1 D_tau^T, D_tau M^-1 D_tau^T
    a_nt: float = 0.0
    a_tt: float = 0.0
    gap_acceleration: float = 0.0
    slip_acceleration: float = 0.0
    normal_force: float = 0.0  # lambda_n
    tangential_force: float = 0.0  # lambda_tau
    damping_power: float = 0.0  # W, of the system's own damping
    supplied_power: float = 0.0  # W, by drives and hub torques


#: the contact problem where there is none
NO_CONTACT = Instant(0.0, 0.0, 0.0, 0.0)


class Guards(NamedTuple):
    """Functions that are positive while a contact state persists; which one falls tells what follows."""

    # the distance from the line of the slope in flight; in contact the normal force, or the depth in a stop that
    # gives way
    normal: float
    lower: float  # slip velocity above its branch of the friction law; friction cone
    upper: float
    definite: float  # effective inverse normal mass of sliding contact, relative
    end: float  # distance (m) of the contact point from the ends of the slope


NORMAL, LOWER, UPPER, DEFINITE, END = range(5)
GUARDS = 5
#: not a guard but a scheme's verdict at the end of a step: sliding contact sticks, or sticking contact slides
JUDGED = 5


class Tolerances(NamedTuple):
    """What counts as zero: a guard must rise above this before its fall through zero is an event."""

    gap: float  # m
    force: float  # N
    velocity: float  # m/s
    time: float  # s, that of the motion itself
    energy: float  # J, that of the motion itself
    flight: float = 0.0  # s, bounces shorter than this are taken as accumulated

    @classmethod
    def of(cls, length: float, time: float, force: float) -> Tolerances:
        """Return the tolerances of a system of the given length (m) and time (s) with forces about `force` (N)."""
        velocity = 1e-11 * length / time
        return cls(1e-12 * length, 1e-10 * force, velocity, time=time, energy=force * length)


def _rigid(depth: float, rate: float) -> float:
    return 0.0


def rigid_phase() -> Phase:
    """Return the phase of free flight above a rigid stop."""
    return Phase(compiled_law(_rigid, 2, 0), np.zeros(1))

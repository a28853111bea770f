"""Contact states and the numbers that describe a contact at an instant."""

from __future__ import annotations

from enum import IntEnum
from math import inf
from typing import NamedTuple

import numpy as np

from oblique_impact.contact.friction import Branch
from oblique_impact.kernels.laws import Law
from oblique_impact.kernels.workspace import Array

FREE, SLIDING, STICKING = 0, 1, 2


class State(IntEnum):
    """Contact state; the values are those of the variable `state` in a history."""

    FREE = FREE
    SLIP = SLIDING
    STICK = STICKING


class Stop(NamedTuple):
    """Normal law of a contact, as kernels read it; by default a rigid stop.

    A compliant stop pushes with a function of the depth d = -Z_n and its rate: of Hunt and Crossley's spring,
    stiffness d (1 + damping d'), or of a user-defined law.
    """

    compliant: bool = False
    massless: bool = False  # a rigid stop under a contact point without inertia, see `MasslessPoint`
    stiffness: float = 0.0  # N/m
    damping: float = 0.0  # s/m
    law: Law | None = None  # lambda_n(d, d') in the place of the spring's
    cell: float = 0.0  # m, of the beam that bears on a bedding, see `Bedding`; 0 of a stop at a point
    share: float = 1.0  # of the stiffness that is there: the part of the cell that is over the bedding
    fading: float = 0.0  # 1/m, derivative of the share by the slip


class Stick(NamedTuple):
    """Sticking: |lambda_tau| <= static lambda_n, and the slip Z_tau is kept at `slip`.

    A point of an obstacle rolls on the beam where it sticks: with its radius, or where it is pressed in, the place
    at which it touches moves without slipping.  There is no slip then to come back to, its rate alone is zero.

    With the axial flexibility of the beam in the tangential row the material is at Z_tau + compliance lambda_tau,
    and it is that which is kept at `slip`; see `oblique_impact.contact.flexibility`.
    """

    static: float = -1.0  # negative: a law without a stick state
    slip: float = 0.0  # m
    held: float = 1.0  # 0.0 of a point that rolls
    compliance: float = 0.0  # m/N, the axial flexibility; 0: the beam does not stretch
    sense: float = 1.0  # of its tangent, 1: away from the root, -1: towards it


class Baumgarte(NamedTuple):
    """Coefficients of Z'' + damping Z' + stiffness Z = 0 (1/s, 1/s^2), Baumgarte's stabilization."""

    damping: float = 0.0
    stiffness: float = 0.0

    @classmethod
    def from_parameters(cls, chi: float, beta: float, form: str) -> Baumgarte:
        """Read the paper's parameters as 2 chi and beta^2 ("squared") or as they stand ("plain")."""
        return cls(2.0 * chi, beta * beta) if form == "squared" else cls(chi, beta)


class Surface(NamedTuple):
    """Extent of the slope, and the side of it on which the contact point is."""

    enabled: bool = True  # False: contact is switched off
    side: float = 1.0  # in flight: 1 above the line of the slope, -1 below it, past an end
    first: float = -inf  # m along the slope: its ends, where contact ends
    last: float = inf


class Residual(NamedTuple):
    """Residual flexibility of the contact point, that of the modes left out; constant during a contact.

    The modes above the last one are compliant too: without inertia they are a spring and a dashpot behind the
    contact point, in series with the stop.  A point without inertia rests on a rigid stop whatever the coordinates
    do, so that its slip is Z_tau + tilt Z_n.
    """

    compliance: float = 0.0  # m/N along the normal
    relaxation: float = 0.0  # s, viscosity over stiffness
    tilt: float = 0.0  # tan beta of a contact point without inertia, beta between normal and its free direction


#: columns of `ContactArrays.rows`
STATE, INTERCEPT, SLOPE, LOWEST, HIGHEST, STATIC, KEPT_SLIP, HELD, COMPLIANCE, SENSE = range(10)
SIDE, FIRST, LAST, STIFFNESS, CELL = range(10, 15)


class ContactArrays(NamedTuple):
    """States of n contacts, and arrays for their problem at an instant in a system of d degrees of freedom."""

    rows: Array  # (n, 15) what `Phase` says of a contact, see `oblique_impact.contact.several.phase_of`
    instants: Array  # (n, 13) the fields of `Instant`, each contact's accelerations without any contact force
    biases: Array  # (n, 2) accelerations of gap and slip without q''
    directions: Array  # (n, 2, d) D_n, D_tau of the closed contacts
    responses: Array  # (n, 2, d) M^-1 D_n^T, M^-1 D_tau^T
    definite: Array  # (n,) effective inverse normal mass, relative, given the contacts before
    matrix: Array  # (2 n, 2 n + 1) equations of the unknown forces with their right side
    unknowns: Array  # (2 n, 2) contact and direction, 0 normal or 1 tangential, of each unknown
    travel: Array  # (n,) m, the integral of the slip velocity: the slip, but for rolling
    yielding: Array  # (n,) m/s, of the material by the forces of other contacts on the axial flexibility

    @classmethod
    def new(cls, rows: Array, size: int) -> ContactArrays:
        """Allocate the arrays of n contacts, `rows` (n, 15), of a system with `size` degrees of freedom."""
        n = len(rows)
        shapes = (n, INSTANT), (n, 2), (n, 2, size), (n, 2, size), (n,), (2 * n, 2 * n + 1), (2 * n, 2), (n,), (n,)
        return cls(rows, *(np.zeros(shape) for shape in shapes))


class Phase(NamedTuple):
    """A contact state with all its parameters, as kernels read it.

    Of several contacts (`arrays`) it holds what they have in common; its state is free if all of them are.
    """

    state: int = FREE
    stop: Stop = Stop()
    friction: Branch = Branch(0.0, 0.0, -inf, inf)  # of the friction law, while sliding
    stick: Stick = Stick()
    stabilization: Baumgarte = Baumgarte()
    surface: Surface = Surface()
    residual: Residual = Residual()
    arrays: ContactArrays | None = None


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


INSTANT = len(Instant._fields)
#: columns of `ContactArrays.instants`
GAP, SLIP, GAP_RATE, SLIP_RATE, A_NN, A_NT, A_TT, GAP_ACCELERATION, SLIP_ACCELERATION = range(9)
NORMAL_FORCE, TANGENTIAL_FORCE = 9, 10
#: the contact problem where there is none
NO_CONTACT = Instant(0.0, 0.0, 0.0, 0.0)


class Guards(NamedTuple):
    """Guards: positive while a contact state persists; the first that falls decides the transition."""

    # the distance from the line of the slope in flight; in contact the normal force, or the depth in a
    # compliant stop
    normal: float
    lower: float  # slip velocity above its branch of the friction law; friction cone
    upper: float
    definite: float  # effective inverse normal mass of sliding contact, relative
    end: float  # distance (m) of the contact point from the ends of the slope


NORMAL, LOWER, UPPER, DEFINITE, END = range(5)
GUARDS = 5
#: not a guard: a scheme found at the end of a step that sliding contact sticks, or sticking contact slides
SWITCHED = 5


VELOCITY = 1e-11  # of the velocity of the motion itself, the tolerance of velocities


class Tolerances(NamedTuple):
    """Zero tolerances: a guard is armed once it exceeds its tolerance, and only then is its fall an event."""

    gap: float  # m
    force: float  # N
    velocity: float  # m/s
    time: float  # s, that of the motion itself
    energy: float  # J, that of the motion itself
    flight: float = 0.0  # s, bounces shorter than this are taken as accumulated

    @classmethod
    def of(cls, length: float, time: float, force: float) -> Tolerances:
        """Return the tolerances of a system of the given length (m) and time (s) with forces about `force` (N)."""
        velocity = VELOCITY * length / time
        return cls(1e-12 * length, 1e-10 * force, velocity, time=time, energy=force * length)

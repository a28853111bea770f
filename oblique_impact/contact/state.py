"""Contact states and the numbers that describe a contact at an instant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from enum import IntEnum
from math import inf
from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.compliance import Compliance
from oblique_impact.kernels.laws import Law
from oblique_impact.kernels.workspace import Array

FREE, SLIDING, STICKING = 0, 1, 2


class State(IntEnum):
    """Contact state; the values are those of the variable `state` in a history."""

    FREE = FREE
    SLIP = SLIDING
    STICK = STICKING


@dataclass
class Candidate:
    """One candidate of contact: its state with all its parameters, and its problem at an instant (SI units).

    Kernels read and write records of these fields, see `Contacts`; in plain Python they are these objects.  The
    accelerations are those without any contact force.
    """

    state: int = FREE
    # --- the stop: a rigid one or, `compliant`, lambda_n as a function of the depth d = -Z_n and its rate, that of
    # Hunt and Crossley's spring, stiffness d (1 + damping d'), or of the law of a run
    compliant: int = 0
    stiffness: float = 0.0  # N/m; infinite of a rigid stop under a place without inertia
    damping: float = 0.0  # s/m
    linear_damping: float = 0.0  # N s/m
    cell: float = 0.0  # m, of the beam that bears on a bedding, see `Bedding`; 0 of a stop at a point
    # --- what the coordinates leave out of the body, in series with the stop, see `Compliance`
    relaxation: float = 0.0  # s, viscosity over stiffness
    # --- friction while it slides, lambda_tau = (intercept + slope v) lambda_n for lower < v < upper (m/s)
    intercept: float = 0.0
    slope: float = 0.0
    lower: float = -inf
    upper: float = inf
    # --- stick, |lambda_tau| <= static lambda_n with the slip kept.  A point of an obstacle rolls on the beam
    # where it sticks: the place at which it touches moves without slipping, and there is no slip to come back to
    static: float = -1.0  # negative: a law without a stick state
    kept_slip: float = 0.0  # m; with axial flexibility the travel that is kept plus what its force stretches
    held: float = 1.0  # 0 of a point that rolls
    axial: float = 0.0  # m/N, axial flexibility behind the friction; 0: the beam does not stretch
    sense: float = 1.0  # of its tangent, 1: away from the root, -1: towards it
    # --- Baumgarte's stabilization Z'' + c Z' + k Z = 0 of the constraints (1/s, 1/s^2)
    correct_rate: float = 0.0
    correct_place: float = 0.0
    # --- the side: whether there is contact at all, on which side of the line of it the point flies, its ends
    enabled: int = 1
    side: float = 1.0  # 1 above the line, -1 below it, past an end
    first: float = -inf  # m along it
    last: float = inf
    # --- the contact at an instant
    #: in flight, but with rows, as if it were closed: for a decision
    probed: int = 0
    gap: float = 0.0  # m
    slip: float = 0.0
    gap_rate: float = 0.0  # m/s
    slip_rate: float = 0.0
    a_nn: float = 0.0  # Delassus entries D_n M^-1 D_n^T, D_n M^-1 D_tau^T, D_tau M^-1 D_tau^T (1/kg)
    a_nt: float = 0.0
    a_tt: float = 0.0
    gap_acceleration: float = 0.0  # m/s^2
    slip_acceleration: float = 0.0
    normal_force: float = 0.0  # N, conjugate to the gap: lambda_n - tilt lambda_tau
    tangential_force: float = 0.0  # lambda_tau
    gap_bias: float = 0.0  # m/s^2, accelerations without q''
    slip_bias: float = 0.0
    # what the compliance behind the contact depends on: on a side the angle (rad) of the body's frame, of an
    # obstacle's point its place (m) along the body; its rate, and the force conjugate to it
    shift: float = 0.0
    shift_rate: float = 0.0
    shift_bias: float = 0.0  # acceleration without q''
    shift_force: float = 0.0
    end_force: float = 0.0  # N, along the slide, of a bedding under a cell over an end of it
    compliance: float = 0.0  # m/N, of the gap by the normal force, without the stop's own
    # the body moves the place along the tangent too, so that the slip is Z_tau + tilt Z_n; the tilt depends on the
    # shift, here with its first two derivatives
    tilt: float = 0.0
    tilt_slope: float = 0.0
    tilt_bend: float = 0.0
    # -gap, less what the elastic forces of the other contacts lift the place, and its rate
    share: float = 1.0  # of a bed, that is under the cell
    depth: float = 0.0  # m
    depth_rate: float = 0.0  # m/s
    rest_force: float = 0.0  # N, that of the stop at rest at this depth
    boundary_power: float = 0.0  # W, of moving boundaries by the two forces above
    definite: float = 1.0  # effective inverse normal mass while it slides, relative, given the contacts before
    travel: float = 0.0  # m, the integral of the slip velocity: the slip, but for rolling
    stretching: float = 0.0  # m/s, of the material by the forces of other contacts on the axial flexibility
    peak_force: float = 0.0  # N, the largest normal force of a call
    peak_depth: float = 0.0  # m
    normal_change: float = 0.0  # of the forces (N) in an iteration, or moves along the responses in a projection
    tangential_change: float = 0.0
    # --- which of the unknown forces are its, -1: none
    normal_unknown: int = -1
    tangential_unknown: int = -1

    def changed(self, **values: Any) -> Candidate:
        """Return a copy with other values."""
        found = object.__new__(Candidate)
        vars(found).update(vars(self), **values)
        return found


CANDIDATE = np.dtype(
    [(f.name, np.int64 if f.type == "int" else np.float64) for f in fields(Candidate)], align=True
)
_NAMES: tuple[str, ...] = CANDIDATE.names or ()
#: what a candidate is at an instant, whatever its state
AT_AN_INSTANT = _NAMES[_NAMES.index("gap") :]
#: what is observed of a contact at a sample
OBSERVED = ("gap", "slip", "gap_rate", "slip_rate", "lambda_n", "lambda_tau")
#: and of its stop: the compression (m), that at rest, and the force (N) at rest
PRESSED = ("compression", "rest_compression", "rest_force")


class Baumgarte(NamedTuple):
    """Coefficients of Z'' + damping Z' + stiffness Z = 0 (1/s, 1/s^2), Baumgarte's stabilization."""

    damping: float = 0.0
    stiffness: float = 0.0

    @classmethod
    def from_parameters(cls, chi: float, beta: float, form: str) -> Baumgarte:
        """Read the paper's parameters as 2 chi and beta^2 ("squared") or as they stand ("plain")."""
        return cls(2.0 * chi, beta * beta) if form == "squared" else cls(chi, beta)


DIRECTION, RESPONSE = 0, 1  # of `Contacts.rows`


class Contacts(NamedTuple):
    """All n candidates of contact of a run, and arrays for their problem, of d degrees of freedom."""

    each: Any  # (n,) records of `Candidate`; in interpreted runs a list of such objects
    #: (2, n, 2, d) rows D_n, D_tau of the closed contacts, and M^-1 D^T; with a compliance (2, n, 3, d), the third
    #: row that of `Candidate.shift`
    rows: Array
    #: (2 n, 2 n + 1) equations of the unknown forces with their right side; None: one contact has a closed form
    matrix: Array | None
    law: Law | None  # lambda_n(d, d') of compliant stops in the place of the spring's
    push: Array  # (d,) generalized force by the change of compliances with the coordinates
    compliance: Compliance | None  # of the body, behind the stops

    @classmethod
    def new(
        cls,
        contacts: Sequence[Candidate],
        size: int,
        packed: bool,
        law: Law | None = None,
        compliance: Compliance | None = None,
    ) -> Contacts:
        """Allocate the arrays of contacts of a system of `size` coordinates, `packed` for compiled kernels."""
        n = len(contacts)
        each: Any = np.zeros(n, CANDIDATE) if packed else [Candidate() for _ in contacts]
        rows = np.zeros((2, n, 2 if compliance is None else 3, size))
        matrix = np.zeros((2 * n, 2 * n + 1)) if n > 1 else None
        found = cls(each, rows, matrix, law, np.zeros(size), compliance)
        for i, contact in enumerate(contacts):
            found.take(i, contact)
        return found

    def take(self, i: int, contact: Candidate) -> None:
        """Take the fields of a contact."""
        self.each[i] = tuple(vars(contact).values()) if isinstance(self.each, np.ndarray) else contact.changed()

    def peaks(self) -> list[tuple[float, float]]:
        """Return the largest normal force (N) and depth (m) of each since they were asked for."""
        each = self.each
        if isinstance(each, np.ndarray):
            found = list(zip(each["peak_force"].tolist(), each["peak_depth"].tolist(), strict=True))
            each["peak_force"] = each["peak_depth"] = 0.0
            return found
        found = [(c.peak_force, c.peak_depth) for c in each]
        for c in each:
            c.peak_force = c.peak_depth = 0.0
        return found

    def in_python(self) -> Contacts:
        """Return copies of the contacts that plain Python reads quickly."""
        return self._replace(each=[self.of(i) for i in range(len(self.each))])

    def copied(self) -> Any:
        """Return a copy of all, for `restore`."""
        each = self.each
        # fields are eight bytes each, and copied as such in one piece
        return each.view(np.int64).copy() if isinstance(each, np.ndarray) else [c.changed() for c in each]

    def restore(self, copied: Any) -> None:
        """Take back all contacts as they were `copied`."""
        each = self.each
        if isinstance(each, np.ndarray):
            each.view(np.int64)[:] = copied
        else:
            each[:] = [c.changed() for c in copied]

    def of(self, i: int) -> Candidate:
        """Return a copy of contact i."""
        record = self.each[i]
        return Candidate(*record.item()) if isinstance(self.each, np.ndarray) else record.changed()

    def states(self) -> list[int]:
        """Return the states of all."""
        return self.each["state"].tolist() if isinstance(self.each, np.ndarray) else [c.state for c in self.each]


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

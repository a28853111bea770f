"""Reading a contact problem at given states: for transitions and for output."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.elastic import bears, compression_of, press
from oblique_impact.contact.forces import add_push, is_free, lambda_n, take_delassus, touch_contacts
from oblique_impact.contact.state import OBSERVED, PRESSED, SLIDING, Candidate, Contacts
from oblique_impact.kernels.jit import by_reference, jitable, kernel
from oblique_impact.kernels.workspace import FREE_ACCELERATION, Array, Workspace, copy
from oblique_impact.marching.equations import OF_A_CONTACT, QUADRATURES, derivative


class Observation(NamedTuple):
    """Accelerations and contacts at samples, each row one sample."""

    qdd: Array  # (samples, d)
    contacts: Array  # (samples, n, 6) what is `OBSERVED` of each contact
    pressed: Array  # (samples, n, 3) what is `PRESSED` of each, 0 of one that is no elastic one or in flight

    def column(self, name: str) -> Array:
        """Return a number of all contacts, shape (samples, n)."""
        if name in PRESSED:
            return self.pressed[:, :, PRESSED.index(name)]
        return self.contacts[:, :, OBSERVED.index(name)]


@jitable
def _largest_ratio(c: Candidate) -> float:
    """Return the largest ratio of the forces of a contact; of a law without stick, that of its branch."""
    if c.static >= 0.0:
        return c.static
    if c.state != SLIDING:  # steps that decide have no branch here
        return np.inf
    if c.slope == 0.0:
        return abs(c.intercept)
    return max(abs(c.intercept + c.slope * c.lower), abs(c.intercept + c.slope * c.upper))


@jitable
def _inside_cone(c: Candidate, normal: float, tangential: float) -> tuple[float, float]:
    """Return forces (N) of a closed contact, means that a scheme reports, inside of the friction cone.

    Where a contact begins or ends they are means of different forces, which no state need have; where a branch
    ends they are as far beyond as the end is located.
    """
    push = normal - c.tilt * tangential
    if not push > 0.0:
        return 0.0, 0.0
    largest = _largest_ratio(c)
    if largest < np.inf:
        ratio = largest if tangential > 0.0 else -largest
        span = 1.0 - ratio * c.tilt
        if span > 0.0 and abs(tangential) * span > largest * push:
            tangential = ratio / span * push
    return push + c.tilt * tangential, tangential


@jitable
def _keep(c: Candidate, normal: float, tangential: float, found: Array, pressed: Array) -> None:
    """Keep what is observed of a contact with the forces (N) to report."""
    found[0], found[1], found[2], found[3] = c.gap, c.slip, c.gap_rate, c.slip_rate
    found[4], found[5] = normal, tangential
    pressed[0], pressed[1], pressed[2] = 0.0, 0.0, 0.0
    if bears(c):
        pressed[0] = compression_of(c, normal - c.tilt * tangential)
        pressed[1], pressed[2] = max(0.0, max(0.0, c.depth) - c.compliance * c.rest_force), c.rest_force


@jitable
def _solve(system: Any, contacts: Contacts, t: float, q: Array, qd: Array, w: Workspace, rank_one: Array) -> bool:
    e = system.evaluate(t, q, qd, w)
    touch_contacts(system, contacts, t, q, qd, w)
    add_push(contacts, w)
    rank_one[0] = e.rank_one
    if not system.solve_mass(e.rank_one, w, contacts, True):
        return False
    take_delassus(contacts, w.vectors[FREE_ACCELERATION])
    return True


@jitable
def _observe(
    system: Any,
    contacts: Contacts,
    times: Array,
    states: Array,
    w: Workspace,
    dy: Array,
    qdd: Array,
    found: Array,
    pressed: Array,
) -> None:
    d, n = qdd.shape[1], found.shape[1]
    tail = 2 * d + QUADRATURES + OF_A_CONTACT * n
    for i in range(times.shape[0]):
        q, qd, y = states[i, :d], states[i, d : 2 * d], states[i]
        reported = y.shape[0] > tail and not np.isnan(y[tail])
        status = 0
        if reported:
            copy(y[tail : tail + d], qdd[i])
        else:
            status = derivative(system, contacts, times[i], y, w, dy)
            for j in range(d):
                qdd[i, j] = dy[d + j] if status == 0 else np.nan
        if (reported or status != 0) and is_free(contacts):
            system.measure(times[i], q, qd, w, contacts)
            press(contacts)
        elif reported or status != 0:
            touch_contacts(system, contacts, times[i], q, qd, w)
        for k in range(n):
            c = contacts.each[k]
            if reported:
                normal, tangential = _inside_cone(c, y[tail + d + 2 * k], y[tail + d + 2 * k + 1])
                c.normal_force, c.tangential_force = normal - c.tilt * tangential, tangential
                _keep(c, normal, tangential, found[i, k], pressed[i, k])
            elif status == 0:
                _keep(c, lambda_n(c), c.tangential_force, found[i, k], pressed[i, k])
            else:
                _keep(c, np.nan, np.nan, found[i, k], pressed[i, k])


#: what is asked of a state; one kernel answers, as nearly all that it calls is the same
_PROBLEM, _RATES, _SAMPLES = 0, 1, 2


@kernel("the contact problem")
def _read(
    system: Any,
    contacts: Contacts,
    question: int,
    times: Array,
    states: Array,
    w: Workspace,
    rates: Array,
    qdd: Array,
    found: Array,
    pressed: Array,
) -> int:
    system, contacts, w, states = (
        by_reference(system),
        by_reference(contacts),
        by_reference(w),
        by_reference(states),
    )
    if question == _SAMPLES:
        _observe(system, contacts, times, states, w, rates, qdd, found, pressed)
        return 0
    y = states[0]
    if question == _RATES:
        return derivative(system, contacts, times[0], y, w, rates)
    d = qdd.shape[1]
    return int(_solve(system, contacts, times[0], y[:d], y[d : 2 * d], w, rates))


def _ask(system: Any, contacts: Contacts, question: int, t: float, y: Array, w: Workspace, rates: Array) -> int:
    nothing = np.empty((0, 0, 0))
    qdd = np.empty((0, w.vectors.shape[1]))
    found: int = _read(system, contacts, question, np.array([t]), y[None], w, rates, qdd, nothing, nothing)
    return found


def solve_problem(
    system: Any, contacts: Contacts, t: float, q: Array, qd: Array, w: Workspace, rank_one: Array
) -> bool:
    """Evaluate and solve for the contacts that are not free, without their forces; False without a definite mass.

    The coefficient of the mass's rank-one part goes into `rank_one` (1,).
    """
    return bool(_ask(system, contacts, _PROBLEM, t, np.concatenate((q, qd)), w, rank_one))


def take_derivative(system: Any, contacts: Contacts, t: float, y: Array, w: Workspace, dy: Array) -> int:
    """Call :func:`~oblique_impact.marching.equations.derivative` from Python."""
    return _ask(system, contacts, _RATES, t, y, w, dy)


def observe(system: Any, contacts: Contacts, times: Array, states: Array, w: Workspace) -> Observation:
    """Observe samples: times (samples,) and state vectors (samples, ny), the contacts in their states.

    A scheme's own accelerations and forces are taken where it keeps them behind the quadratures; at the start of
    a phase there are none (NaN).  Where no contact force exists (the run ends there) the kinematics are kept, the
    rest is NaN.
    """
    count, d, n = times.size, w.vectors.shape[1], len(contacts.each)
    sizes = (count, d), (count, n, len(OBSERVED)), (count, n, len(PRESSED))
    found = Observation(*map(np.empty, sizes))
    _read(system, contacts, _SAMPLES, times, states, w, np.empty(states.shape[1]), *found)
    return found

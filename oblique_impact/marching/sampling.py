"""Reading a contact problem at given states: for transitions and for output."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.forces import flying, instant_of, moved, with_forces
from oblique_impact.contact.several import phase_of, touch_contacts
from oblique_impact.contact.state import (
    INSTANT,
    NO_CONTACT,
    NORMAL_FORCE,
    SLIP_RATE,
    TANGENTIAL_FORCE,
    ContactArrays,
    Instant,
    Phase,
)
from oblique_impact.kernels.jit import by_reference, jitable, kernel
from oblique_impact.kernels.workspace import Array, Evaluation, Workspace, copy
from oblique_impact.marching.equations import OF_A_CONTACT, QUADRATURES, derivative

EVALUATION = len(Evaluation._fields)


class Observation(NamedTuple):
    """Accelerations and contacts at samples, each row one sample."""

    qdd: Array  # (samples, d)
    instants: Array  # (samples, 13), a column for each field of `Instant`
    contacts: Array  # (samples, n, 13) the same of each of several contacts; n = 0 of a single one

    def column(self, name: str) -> Array:
        """Return a field of the instants, shape (samples,)."""
        return self.instants[:, Instant._fields.index(name)]


@kernel("the contact forces")
def _solve_contact(
    system: Any, t: float, q: Array, qd: Array, w: Workspace, evaluation: Array, instant: Array
) -> bool:
    """Evaluate and solve for the contact without its force, into arrays; False without a definite mass."""
    system, w = by_reference(system), by_reference(w)
    e = system.evaluate(t, q, qd, w)
    defined = system.solve_mass(e.rank_one, w, True)
    c = instant_of(e, w) if defined else flying(e)
    for i in range(EVALUATION):
        evaluation[i] = e[i]
    for i in range(INSTANT):
        instant[i] = c[i]
    return bool(defined)


def contact_problem(system: Any, t: float, q: Array, qd: Array, w: Workspace) -> tuple[bool, Evaluation, Instant]:
    """Evaluate and solve for the contact without its force; False without a positive definite mass."""
    e, c = np.empty(EVALUATION), np.empty(INSTANT)
    defined = _solve_contact(system, t, q, qd, w, e, c)
    return defined, Evaluation(*e.tolist()), Instant(*c.tolist())


@jitable
def _keep_contacts(arrays: ContactArrays | None, reported: bool, undefined: bool, contacts: Array) -> None:
    """Keep each of several contacts; the compiler leaves it out of one.

    What a scheme reports are kinematics and forces; `undefined` forces are NaN.
    """
    if arrays is None:
        return
    for i in range(contacts.shape[0]):
        for j in range(contacts.shape[1]):
            force = j in (NORMAL_FORCE, TANGENTIAL_FORCE)
            known = not undefined if force else j <= SLIP_RATE or not reported
            contacts[i, j] = arrays.instants[i, j] if known else np.nan


@jitable
def _inside_cone(phase: Phase, normal: float, tangential: float) -> tuple[float, float]:
    """Return forces (N) of a closed contact, means that a scheme reports, inside of the friction cone.

    Where a contact begins or ends they are means of different forces, which no state need have.
    """
    tilt, static = phase.residual.tilt, phase.stick.static
    push = normal - tilt * tangential
    if not push > 0.0:
        return 0.0, 0.0
    if static >= 0.0:  # else a law without stick
        ratio = static if tangential > 0.0 else -static
        span = 1.0 - ratio * tilt
        if span > 0.0 and abs(tangential) * span > static * push:
            tangential = ratio / span * push
    return push + tilt * tangential, tangential


@jitable
def _touch_undefined(
    arrays: ContactArrays | None, system: Any, phase: Phase, t: float, q: Array, qd: Array, w: Workspace
) -> None:
    """Take the kinematics of several contacts where nothing solves for their forces."""
    if arrays is not None:
        touch_contacts(arrays, system, phase, t, q, qd, w)


@jitable
def _reported(
    arrays: ContactArrays | None,
    system: Any,
    phase: Phase,
    t: float,
    q: Array,
    qd: Array,
    forces: Array,
    w: Workspace,
) -> Instant:
    """Kinematics with the contact forces (2 n,) that a scheme reports."""
    e, tilt = system.approach(t, q, qd, False, w), phase.residual.tilt
    if arrays is None:
        normal, tangential = _inside_cone(phase, float(forces[0]), float(forces[1]))
        return moved(NO_CONTACT, e, normal, tangential, 0.0, tilt)
    touch_contacts(arrays, system, phase, t, q, qd, w)
    for i in range(arrays.rows.shape[0]):
        found = _inside_cone(phase_of(phase, arrays, i), forces[2 * i], forces[2 * i + 1])
        arrays.instants[i, NORMAL_FORCE], arrays.instants[i, TANGENTIAL_FORCE] = found
    return moved(NO_CONTACT, e, 0.0, 0.0, 0.0)


@kernel("the sampling")
def observe_into(
    system: Any,
    phase: Phase,
    times: Array,
    states: Array,
    w: Workspace,
    dy: Array,
    qdd: Array,
    instants: Array,
    contacts: Array,
) -> None:
    """Accelerations, contact forces and kinematics of `phase` at samples.

    A scheme's own accelerations and forces are taken where it keeps them behind the quadratures; at the start of
    a phase there are none (NaN).  Where no contact force exists (the run ends there) the kinematics are kept, the
    rest is NaN.
    """
    system, phase, w = by_reference(system), by_reference(phase), by_reference(w)
    d, n = qdd.shape[1], contacts.shape[1]
    tail = 2 * d + QUADRATURES + OF_A_CONTACT * n
    for i in range(times.shape[0]):
        q, qd, undefined = states[i, :d], states[i, d : 2 * d], False
        reported = states.shape[1] > tail and not np.isnan(states[i, tail])
        if reported:
            forces = states[i, tail + d : tail + d + 2 * max(n, 1)]
            c = _reported(phase.arrays, system, phase, times[i], q, qd, forces, w)
            copy(states[i, tail : tail + d], qdd[i])
        else:
            status, c = derivative(system, phase, times[i], states[i], w, dy)
            undefined = status != 0
            for j in range(d):
                qdd[i, j] = np.nan if undefined else dy[d + j]
            if undefined:
                c = with_forces(c, np.nan, np.nan, np.nan)
                _touch_undefined(phase.arrays, system, phase, times[i], q, qd, w)
        for j in range(INSTANT):
            known = not (reported or undefined) or j < 4 or INSTANT - 4 <= j < INSTANT - 2
            instants[i, j] = c[j] if known else np.nan
        _keep_contacts(phase.arrays, reported, undefined, contacts[i])


def observe(system: Any, phase: Phase, times: Array, states: Array, w: Workspace) -> Observation:
    """Observe samples: times (samples,) and state vectors (samples, ny)."""
    count, d = times.size, w.vectors.forces.shape[0]
    contacts = len(phase.arrays.rows) if phase.arrays else 0
    found = Observation(np.empty((count, d)), np.empty((count, INSTANT)), np.empty((count, contacts, INSTANT)))
    observe_into(system, phase, times, states, w, np.empty(states.shape[1]), *found)
    return found

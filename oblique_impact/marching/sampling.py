"""Reading a contact problem at given states: for transitions and for output."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.forces import Phase, condense
from oblique_impact.kernels.implicit import approach
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.system import (
    A_NN,
    ACCELERATION,
    FIRST_GUARD,
    LAMBDA_N,
    LAMBDA_T,
    Array,
    Work,
    evaluate,
)
from oblique_impact.marching.equations import QUADRATURES, derivative


class Observation(NamedTuple):
    """What is known at samples besides the state vector, each row one sample."""

    qdd: Array  # (samples, d)
    scalars: Array  # (samples, 15) kinematics, Delassus entries, forces: see `oblique_impact.kernels.system`


@jitable
def condense_at(system: Any, t: float, q: Array, qd: Array, work: Work) -> bool:
    """Evaluate and condense the contact problem into `work`; False without a positive definite mass."""
    evaluate(system, t, q, qd, work)
    return condense(system, work)


@jitable
def observe_into(
    system: Any, phase: Phase, times: Array, states: Array, work: Work, dy: Array, qdd: Array, scalars: Array
) -> None:
    """Accelerations, contact forces and kinematics of `phase` at samples.

    Where no contact force exists (the run ends there) the kinematics are kept, the rest is NaN.
    """
    for i in range(times.shape[0]):
        defined = derivative(system, phase, times[i], states[i], work, dy) == 0
        for j in range(qdd.shape[1]):
            qdd[i, j] = work.vectors[ACCELERATION, j] if defined else np.nan
        for j in range(FIRST_GUARD):
            scalars[i, j] = work.scalars[j] if defined or j < A_NN else np.nan


@jitable
def observe_kept_into(
    system: Any, phase: Phase, times: Array, states: Array, work: Work, dy: Array, qdd: Array, scalars: Array
) -> None:
    """Observe with the accelerations and contact forces that generalized-alpha keeps in its state.

    At the start of a phase there are none yet (NaN): they follow from the motion, as in :func:`observe_into`.
    """
    d = qdd.shape[1]
    tail = 2 * d + QUADRATURES
    for i in range(times.shape[0]):
        if np.isnan(states[i, tail]):
            observe_into(
                system, phase, times[i : i + 1], states[i : i + 1], work, dy, qdd[i : i + 1], scalars[i : i + 1]
            )
            continue
        approach(system, times[i], states[i, :d], states[i, d : 2 * d], work)
        work.scalars[LAMBDA_N] = states[i, tail + 3 * d]
        work.scalars[LAMBDA_T] = states[i, tail + 3 * d + 1]
        for j in range(d):
            qdd[i, j] = states[i, tail + j]
        for j in range(FIRST_GUARD):
            delassus = A_NN <= j < LAMBDA_N
            scalars[i, j] = np.nan if delassus else work.scalars[j]


def observe(
    system: Any, phase: Phase, times: Array, states: Array, work: Work, reader: Any = observe_into
) -> Observation:
    """Observe samples with `reader`: `observe_into` itself or its compiled form."""
    count, d = times.size, work.vectors.shape[1]
    found = Observation(np.empty((count, d)), np.empty((count, FIRST_GUARD)))
    reader(system, phase, times, states, work, np.empty(states.shape[1]), found.qdd, found.scalars)
    return found

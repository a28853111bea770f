"""Generalized-alpha: its coefficients, and what it keeps from step to step.

Chung and Hulbert, J. Appl. Mech. 60 (1993), in the form of Arnold and Bruels, Multibody Syst. Dyn. 18 (2007):
equilibrium holds at the end of the step, M q'' = Q + D^T lambda, and the algorithmic acceleration a follows by

    (1 - alpha_m) a1 + alpha_m a0 = (1 - alpha_f) q''1 + alpha_f q''0
    q1 = q0 + h q'0 + h^2 ((1/2 - beta) a0 + beta a1),     q'1 = q'0 + h ((1 - gamma) a0 + gamma a1)
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.forces import OK, accelerate, lambda_n
from oblique_impact.contact.state import Candidate, Contacts
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import ACCELERATION, EFFECTIVE_SLOTS, Array, Workspace, copy
from oblique_impact.marching.buffers import Scratch
from oblique_impact.marching.equations import (
    DAMPING_LOSS,
    OF_A_CONTACT,
    QUADRATURES,
    TRAVEL,
    rates_into,
    take_travel,
)


class Coefficients(NamedTuple):
    """Parameters of the scheme."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float
    tolerance: float  # J^1/2, of the iterations: on the root of the energy of a correction


def coefficients(rho_infinity: float, tolerance: float) -> Coefficients:
    """Optimal parameters for a spectral radius rho_infinity at infinite frequency (Chung and Hulbert 1993)."""
    alpha_m = (2.0 * rho_infinity - 1.0) / (rho_infinity + 1.0)
    alpha_f = rho_infinity / (rho_infinity + 1.0)
    gamma = 0.5 - alpha_m + alpha_f
    beta = 0.25 * (gamma + 0.5) * (gamma + 0.5)
    return Coefficients(alpha_m, alpha_f, beta, gamma, tolerance)


def backward_euler(tolerance: float) -> Coefficients:
    """Return the parameters that make a step one of backward Euler, if the algorithmic acceleration is zero."""
    return Coefficients(0.0, 0.0, 1.0, 1.0, tolerance)


@inlined
def is_backward_euler(c: Coefficients) -> bool:
    """Whether the parameters are those of :func:`backward_euler`."""
    return c.alpha_m == 0.0 and c.alpha_f == 0.0 and c.gamma == 1.0


class StepLength(NamedTuple):
    """A step and the factors from q'' to q' and q at its end."""

    h: float  # s
    velocity: float  # s
    position: float  # s^2


@inlined
def step_length(c: Coefficients, h: float) -> StepLength:
    """Return the factors of a step of length h (s)."""
    ratio = (1.0 - c.alpha_f) / (1.0 - c.alpha_m)
    return StepLength(h, h * c.gamma * ratio, h * h * c.beta * ratio)


class AlgorithmState(NamedTuple):
    """State of the scheme from step to step, of n contacts, kept behind the quadratures of the state vector."""

    acceleration: Array  # (d,) q''
    reported: Array  # (2 n,) contact forces (N) to report
    algorithmic: Array  # (d,) a
    forces: Array  # (2 n,) contact forces (N) at the end of the step
    averaged: Array  # (2 n,) as the algorithm averages them
    rates: Array  # of the quadratures
    memory: Array  # (7 n,) of each contact, see the names below


# lag (s) and rate (N/s) of the mean force that holds one that sticks, slip velocity (m/s), gap (m), gap rate
# (m/s), energy of the contact (J), power (W) by the change of its compliance
LAG, MEAN_RATE, SLIP_RATE, GAP, GAP_RATE, HELD, SHIFTING = 0, 1, 2, 3, 4, 5, 6
MEMORY = 7
UNKNOWN = 1e300  # a rate of which nothing is known yet


def algorithm_state_size(d: int, contacts: int, quadratures: int) -> int:
    """Entries of :class:`AlgorithmState` for d degrees of freedom."""
    return 2 * d + (6 + MEMORY) * contacts + quadratures


@inlined
def quadrature_count(contacts: Contacts) -> int:
    """Return the number of quadratures, those of the run and of each contact."""
    return QUADRATURES + OF_A_CONTACT * len(contacts.each)


@inlined
def algorithm_state(contacts: Contacts, y: Array, d: int) -> AlgorithmState:
    """Return the parts of the state vector that the scheme keeps."""
    n, quadratures = len(contacts.each), quadrature_count(contacts)
    forces = 2 * n
    a = 3 * d + quadratures
    b = a + forces
    e = b + d
    f = e + 2 * forces + quadratures
    return AlgorithmState(
        y[a - d : a],
        y[a:b],
        y[b:e],
        y[e : e + forces],
        y[e + forces : e + 2 * forces],
        y[e + 2 * forces : f],
        y[f : f + MEMORY * n],
    )


@inlined
def begin_travel(contacts: Contacts, y: Array, d: int, h: float) -> None:
    """Take the travel of the contacts at the start of a step of length h, with half of the rate there."""
    take_travel(contacts, y, d)
    rates = algorithm_state(contacts, y, d).rates
    for i in range(len(contacts.each)):
        contacts.each[i].travel += 0.5 * h * rates[QUADRATURES + OF_A_CONTACT * i + TRAVEL]


class Iterations(NamedTuple):
    """Convergence of the iterations of a step, for each effective matrix."""

    contraction: Array  # (3,) ratio of the residuals; negative: not known
    rounded: Array  # (3,) residuals below which they do not fall; 0: not known
    stale: NDArray[np.bool_]  # (3,) whether the effective matrix is to be factored anew

    @classmethod
    def new(cls) -> Iterations:
        """Return the initial values, before any step."""
        return cls(
            np.full(EFFECTIVE_SLOTS, -1.0), np.zeros(EFFECTIVE_SLOTS), np.ones(EFFECTIVE_SLOTS, dtype=np.bool_)
        )


class Attempt(NamedTuple):
    """A step of length h (s) from (t, y) into scratch.y_new, of which shorter ones can be tried."""

    system: Any
    contacts: Contacts
    c: Coefficients
    t: float
    h: float
    y: Array
    scratch: Scratch
    iterations: Iterations


@jitable
def start_phase(system: Any, contacts: Contacts, t: float, y: Array, w: Workspace) -> int:
    """Put accelerations and contact forces at the start of a phase into what y keeps; returns the status."""
    d = w.vectors.shape[1]
    qd, kept = y[d : 2 * d], algorithm_state(contacts, y, d)
    take_travel(contacts, y, d)
    status, damping, supplied = accelerate(system, contacts, t, y[:d], qd, w)
    if status != OK:
        return status
    acceleration = w.vectors[ACCELERATION]
    copy(acceleration, kept.acceleration)
    copy(acceleration, kept.algorithmic)
    for i in range(len(contacts.each)):
        c = contacts.each[i]
        for j in range(2):
            force, k = lambda_n(c) if j == 0 else c.tangential_force, 2 * i + j
            kept.reported[k] = force
            kept.forces[k] = force
            kept.averaged[k] = force
        kept.memory[MEMORY * i + MEAN_RATE] = UNKNOWN
        keep_kinematics(kept, i, 0.0, c)
    rates_into(contacts, damping, supplied, qd, kept.rates)
    kept.rates[DAMPING_LOSS] = 0.0
    return OK


@inlined
def keep_kinematics(kept: AlgorithmState, i: int, lag: float, c: Candidate) -> None:
    """Keep the kinematics of contact i at the end of a step, and the lag (s) of its mean forces."""
    memory = kept.memory[MEMORY * i : MEMORY * (i + 1)]
    memory[LAG], memory[SLIP_RATE] = lag, c.slip_rate
    memory[GAP], memory[GAP_RATE] = c.gap, c.gap_rate
    memory[HELD], memory[SHIFTING] = -0.5 * c.rest_force * c.gap, c.shift_force * c.shift_rate

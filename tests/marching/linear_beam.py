"""A beam on a pin above a table by linear kinematics, without any code of the product."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from tests.history.recomputed import hermite

LENGTH, MASS, BENDING, GRAVITY, DAMPING = 1.0, 2766.7 * 3.14e-4, 68.952e9 * 7.85e-9, 9.8, 1e-5


class Fall(NamedTuple):
    """What has become of the beam."""

    impulse: float  # N s, of the table
    moment: float  # N m s, about the pin
    lost: float  # J
    zone: float  # m from the pin, least place that was touched


def matrices(elements: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return mass, stiffness and load without the deflection at the pin."""
    size, n = LENGTH / elements, 2 * (elements + 1)
    m = MASS * size / 420 * np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
    k = BENDING / size**3 * np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    scale = np.array([1.0, size, 1.0, size])
    mass, stiffness, load = np.zeros((n, n)), np.zeros((n, n)), np.zeros(n)
    for e in range(elements):
        own = slice(2 * e, 2 * e + 4)
        mass[own, own] += m * np.outer(scale, scale)
        stiffness[own, own] += k * np.outer(scale, scale)
        load[own] += MASS * GRAVITY * size * np.array([0.5, size / 12, 0.5, -size / 12])
    return mass[1:, 1:], stiffness[1:, 1:], load[1:]


def mass_of_means(elements: int) -> np.ndarray:
    """Return the mass with velocities that are constant on each element: nodes alone have none (Renard 2010)."""
    size = LENGTH / elements
    means = np.zeros((elements, 2 * (elements + 1)))
    for e in range(elements):
        means[e, 2 * e : 2 * e + 4] = 0.5, size / 12, 0.5, -size / 12
    return MASS * size * means[:, 1:].T @ means[:, 1:]


class _Table:
    """Places of the beam above a table at -`depth` that ends at `edge`, and what they push with."""

    def __init__(self, elements: int, depth: float, edge: float, matrix: np.ndarray) -> None:
        nodes = np.linspace(0.0, LENGTH, elements + 1)[1:]
        self.depth, self.places = depth, np.append(nodes[nodes < edge - 1e-9], edge)
        self.rows = hermite(np.linspace(0.0, LENGTH, elements + 1), self.places, 0)[:, 1:]
        self.solver = cho_factor(matrix)
        self.responses = cho_solve(self.solver, self.rows.T)
        self.delassus = self.rows @ self.responses
        self.active = np.zeros(len(self.places), dtype=bool)

    def solve(self, right: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return x and p with matrix x = right + C^T p and 0 <= p _|_ C x + known >= 0, by active sets."""
        x = cho_solve(self.solver, right)
        short, pushes = self.rows @ x + known, np.zeros(len(self.places))
        active = self.active | (short < 0.0)
        for _ in range(30):
            pushes[:] = 0.0
            if active.any():
                pushes[active] = np.linalg.solve(self.delassus[np.ix_(active, active)], -short[active])
            chosen = np.where(active, pushes > 0.0, short + self.delassus @ pushes < -1e-12)
            if (chosen == active).all():
                break
            active = chosen
        self.active = active
        return x + self.responses @ pushes, pushes


def fall(
    elements: int,
    h: float,
    end_time: float,
    slope: float,
    speed: float,
    depth: float,
    edge: float,
    massless: bool = False,
) -> Fall:
    """March a beam, straight at first with slope and speed (rad/s), above a table at -`depth` that ends at `edge`.

    Mid-point steps.  With the mass of the elements velocities at their ends obey 0 <= P _|_ C v + g/h >= 0, with
    `massless` nodes deflections there obey 0 <= lambda _|_ C w + depth >= 0.
    """
    mass, stiffness, load = matrices(elements)
    damping = DAMPING * stiffness
    if massless:
        mass = mass_of_means(elements)
        table = _Table(elements, depth, edge, 2.0 / h**2 * mass + damping / h + 0.5 * stiffness)
    else:
        table = _Table(elements, depth, edge, mass + 0.5 * h * damping + 0.25 * h * h * stiffness)
    rigid = np.zeros(len(load))
    rigid[0], rigid[1::2], rigid[2::2] = 1.0, LENGTH * np.arange(1, elements + 1) / elements, 1.0
    w, v = slope * rigid, speed * rigid

    def energy() -> float:
        return float(0.5 * v @ mass @ v + 0.5 * w @ stiffness @ w + load @ w)

    before, total = energy(), np.zeros(len(table.places))
    for _ in range(round(end_time / h)):
        if massless:
            right = mass @ (2.0 / h**2 * w + 2.0 / h * v) + damping @ w / h - 0.5 * stiffness @ w - load
            ahead, forces = table.solve(right, np.full(len(total), depth))
            w, v, total = ahead, 2.0 / h * (ahead - w) - v, total + h * forces
        else:
            force = -load - stiffness @ (w + 0.25 * h * v) - 0.5 * damping @ v
            known = (table.rows @ (w + 0.5 * h * v) + depth) / h
            after, impulses = table.solve(mass @ v + h * force, known)
            w, v, total = w + 0.5 * h * (v + after), after, total + impulses
    zone = float(table.places[total > 0.0].min())
    return Fall(float(total.sum()), float(total @ table.places), before - energy(), zone)

"""A beam on a pin above a table by linear kinematics, without any code of the product."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve

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


def shapes_at(x: float, elements: int) -> np.ndarray:
    """Return the shape functions at a place."""
    size, found = LENGTH / elements, np.zeros(2 * (elements + 1))
    e = min(int(x / size + 1e-9), elements - 1)
    z = x / size - e
    found[2 * e : 2 * e + 4] = [
        1 - 3 * z**2 + 2 * z**3,
        size * z * (1 - z) ** 2,
        z**2 * (3 - 2 * z),
        size * z**2 * (z - 1),
    ]
    return found[1:]


def fall(elements: int, h: float, end_time: float, slope: float, speed: float, depth: float, edge: float) -> Fall:
    """March a beam, straight at first with slope and speed (rad/s), above a table at -`depth` that ends at `edge`.

    Mid-point steps; at their ends velocities obey 0 <= P _|_ C v + g/h >= 0, solved by active sets.
    """
    mass, stiffness, load = matrices(elements)
    nodes = np.linspace(0.0, LENGTH, elements + 1)[1:]
    places = np.append(nodes[nodes < edge - 1e-9], edge)
    rows = np.array([shapes_at(x, elements) for x in places])
    rigid = np.zeros(len(load))
    rigid[0], rigid[1::2], rigid[2::2] = 1.0, nodes, 1.0
    w, v = slope * rigid, speed * rigid
    solver = cho_factor(mass + (0.5 * h * DAMPING + 0.25 * h * h) * stiffness)
    responses = cho_solve(solver, rows.T)
    delassus, active = rows @ responses, np.zeros(len(places), dtype=bool)

    def energy() -> float:
        return float(0.5 * v @ mass @ v + 0.5 * w @ stiffness @ w + load @ w)

    before, total = energy(), np.zeros(len(places))
    for _ in range(round(end_time / h)):
        ahead = w + 0.5 * h * v
        force = -load - stiffness @ (w + 0.25 * h * v) - 0.5 * DAMPING * stiffness @ v
        after = cho_solve(solver, mass @ v + h * force)
        rates = rows @ after + (rows @ ahead + depth) / h
        active, impulses = active | (rates < 0.0), np.zeros(len(places))
        for _ in range(30):
            impulses[:] = 0.0
            if active.any():
                impulses[active] = np.linalg.solve(delassus[np.ix_(active, active)], -rates[active])
            chosen = np.where(active, impulses > 0.0, rates + delassus @ impulses < -1e-12)
            if (chosen == active).all():
                break
            active = chosen
        after += responses @ impulses
        w, v, total = w + 0.5 * h * (v + after), after, total + impulses
    zone = float(places[total > 0.0].min())
    return Fall(float(total.sum()), float(total @ places), before - energy(), zone)

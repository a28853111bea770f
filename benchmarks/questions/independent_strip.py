"""A straight beam that bends little, on one-sided springs, in NumPy and SciPy alone.

Nothing of the program is used.  Elements with cubic displacements give the matrices, of which the lowest modes are
kept.  While no contact changes, modes, constant load and one harmonic load are linear equations, whose steps are
matrix exponentials; instants at which a contact opens or closes are sought.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from scipy.linalg import eigh, expm
from scipy.optimize import brentq


@dataclass(frozen=True)
class Spring:
    """A one-sided spring (N/m) at a node that pushes to positive deflections below the level `at` (m).

    With ``side = -1`` it pushes to negative ones, above the level.
    """

    node: int
    stiffness: float
    at: float = 0.0
    side: float = 1.0


@dataclass
class Touch:
    """A contact with a spring: its start, its end (s), its impulse (N s) and its largest force (N)."""

    spring: int
    start: float
    end: float = np.inf
    impulse: float = 0.0
    peak: float = 0.0


@dataclass
class Strip:
    """A uniform beam of equal elements in its lowest modes; its node 0 is clamped, on a pin, or free."""

    length: float
    bending: float  # N m^2
    mass: float  # kg/m
    elements: int = 20
    modes: int = 20
    root: Literal["clamp", "pin", "free"] = "clamp"
    root_spring: float = 0.0  # N m/rad, of a clamp that yields; 0: rigid
    kelvin_voigt: float = 0.0  # s
    masses: Sequence[tuple[int, float]] = ()  # node and kg
    K: np.ndarray = field(init=False)
    M: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        size, h = 2 * self.elements + 2, self.length / self.elements
        T = np.diag([1.0, h, 1.0, h])
        k = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]]) * self.bending / h**3
        m = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
        self.K, self.M = np.zeros((size, size)), np.zeros((size, size))
        for e in range(self.elements):
            at = slice(2 * e, 2 * e + 4)
            self.K[at, at] += T @ k @ T
            self.M[at, at] += T @ m @ T * self.mass * h / 420.0
        self.K[1, 1] += self.root_spring
        for node, mass in self.masses:
            self.M[2 * node, 2 * node] += mass
        first = {"clamp": 1 if self.root_spring > 0.0 else 2, "pin": 1, "free": 0}[self.root]
        self.free = np.arange(first, size)
        squares, vectors = eigh(self.K[np.ix_(self.free, self.free)], self.M[np.ix_(self.free, self.free)])
        self.squares = np.maximum(squares[: self.modes], 0.0)
        self.shapes = np.zeros((size, self.squares.size))
        self.shapes[self.free] = vectors[:, : self.squares.size]

    def row(self, node: int, turn: bool = False) -> np.ndarray:
        """Return deflection, or slope, of a node per mode."""
        return np.asarray(self.shapes[2 * node + turn])

    def moment_row(self, element: int, at: float) -> np.ndarray:
        """Return the moment EI w'' at the part `at` of an element per mode."""
        h = self.length / self.elements
        shape = np.array([12 * at - 6, h * (6 * at - 4), 6 - 12 * at, h * (6 * at - 2)]) / h**2
        return np.asarray(self.bending * shape @ self.shapes[2 * element : 2 * element + 4])

    def amplitudes(self, q: np.ndarray) -> np.ndarray:
        """Return the modal amplitudes of deflections and slopes of all nodes."""
        return np.asarray(self.shapes.T @ self.M @ q)

    def uniform(self) -> np.ndarray:
        """Return modal forces of a unit load per mass, as of weight or of the inertia of a shaken base."""
        ones = np.zeros(self.K.shape[0])
        ones[::2] = 1.0
        return np.asarray(self.shapes.T @ self.M @ ones)

    def march(
        self,
        start: tuple[np.ndarray, np.ndarray],
        springs: Sequence[Spring],
        end: float,
        step: float,
        load: np.ndarray | float = 0.0,
        harmonic: tuple[np.ndarray, float] | None = None,
        after: float = 0.0,
    ) -> tuple[np.ndarray, np.ndarray, list[Touch]]:
        """Return times, modal amplitudes with their rates at each, and the contacts.

        `start` holds amplitudes and rates, `load` modal forces, `harmonic` modal forces that vary like the sine at
        a circular frequency.  Samples before `after` are dropped.
        """
        n = self.squares.size
        load = np.broadcast_to(load, (n,))
        shaken, rate = harmonic if harmonic is not None else (np.zeros(n), 0.0)
        rows = np.array([self.row(spring.node) * spring.side for spring in springs]).reshape(len(springs), n)
        levels = np.array([spring.at * spring.side for spring in springs])
        # of modes, rates, sine, cosine, one
        steps: dict[tuple[bool, ...], tuple[np.ndarray, np.ndarray]] = {}

        def system(closed: tuple[bool, ...]) -> tuple[np.ndarray, np.ndarray]:
            if closed not in steps:
                A = np.zeros((2 * n + 3, 2 * n + 3))
                A[:n, n : 2 * n] = np.eye(n)
                A[n : 2 * n, :n] = -np.diag(self.squares)
                A[n : 2 * n, n : 2 * n] = -self.kelvin_voigt * np.diag(self.squares)
                A[n : 2 * n, 2 * n], A[n : 2 * n, -1] = shaken, load
                A[2 * n, 2 * n + 1], A[2 * n + 1, 2 * n] = rate, -rate
                for spring, row, level, on in zip(springs, rows, levels, closed, strict=True):
                    if on:
                        A[n : 2 * n, :n] -= spring.stiffness * np.outer(row, row)
                        A[n : 2 * n, -1] += spring.stiffness * level * row
                steps[closed] = A, expm(step * A)
            return steps[closed]

        y = np.concatenate([*start, [0.0, 1.0, 1.0]])
        gaps = rows @ y[:n] - levels
        closed = tuple((gaps < 0.0) | ((gaps == 0.0) & (rows @ y[n : 2 * n] < 0.0)))
        touches = {k: Touch(k, 0.0) for k, on in enumerate(closed) if on}
        done: list[Touch] = []
        times, states = [0.0], [y[: 2 * n].copy()]
        t = 0.0
        while t < end:
            left = step
            while left > 0.0:
                A, whole = system(closed)
                later = whole @ y if left == step else expm(left * A) @ y
                new = rows @ later[:n] - levels
                changed = [k for k in range(len(springs)) if (new[k] < 0.0) != closed[k]]
                part = left
                if changed:
                    ends = []
                    for k in changed:

                        def gap(s: float, k: int = k, A: np.ndarray = A, y: np.ndarray = y) -> float:
                            return float(rows[k] @ (expm(s * A) @ y)[:n] - levels[k])

                        # just closed or opened: the gap starts at nothing
                        first = 1e-9 * step
                        crosses = (gap(first) < 0.0) == closed[k]
                        ends.append((brentq(gap, first, left, xtol=1e-16) if crosses else first, k))
                    part, which = min(ends)
                    later = expm(part * A) @ y
                for k, touch in touches.items():
                    forces = [springs[k].stiffness * (levels[k] - rows[k] @ v[:n]) for v in (y, later)]
                    touch.impulse += 0.5 * part * sum(forces)
                    touch.peak = max(touch.peak, *forces)
                y, left = later, left - part
                if changed:
                    now = t + step - left
                    if closed[which]:
                        touches[which].end = now
                        done.append(touches.pop(which))
                    else:
                        touches[which] = Touch(which, now)
                    closed = tuple(on != (k == which) for k, on in enumerate(closed))
            t += step
            if t >= after:
                times.append(t)
                states.append(y[: 2 * n].copy())
        return np.array(times), np.array(states), sorted([*done, *touches.values()], key=lambda one: one.start)

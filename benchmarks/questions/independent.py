"""A beam on a one-sided spring in NumPy and SciPy alone: what the questions compare the program with.

Hermite elements in transverse coordinates, their eigenvectors, and SciPy's Runge-Kutta method between the roots of
the gap.  Nothing of oblique-impact is used.  SI units.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import cos, pi, sin

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import eigh


@dataclass(frozen=True)
class Beam:
    """A uniform beam, by default the paper's, with a hub on its root and a mass at its tip."""

    length: float = 1.0
    mass: float = 2766.7 * 3.14e-4  # kg/m
    stiffness: float = 68.952e9 * 7.85e-9  # N m^2, in bending
    kelvin_voigt: float = 0.0  # s
    hub: float = 0.0  # kg m^2
    tip: float = 0.0  # kg
    clamped: bool = False
    elements: int = 64
    modes: int = 16  # elastic ones; the static flexibility of the others is kept where the beam is touched


@dataclass
class Modes:
    """Eigenvectors of unit modal mass; the first of a beam on a pin is its rotation."""

    beam: Beam
    #: rad/s of each
    frequencies: np.ndarray = field(init=False)
    #: of each: the weight of a constant acceleration, kg^(1/2)
    weights: np.ndarray = field(init=False)
    _vectors: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        beam = self.beam
        h, count = beam.length / beam.elements, 2 * beam.elements + 2
        stiffness = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h]])
        stiffness = np.vstack([stiffness, -stiffness[0], [6 * h, 2 * h * h, -6 * h, 4 * h * h]])
        mass = np.array(
            [
                [156, 22 * h, 54, -13 * h],
                [22 * h, 4 * h * h, 13 * h, -3 * h * h],
                [54, 13 * h, 156, -22 * h],
                [-13 * h, -3 * h * h, -22 * h, 4 * h * h],
            ]
        )
        m, k = np.zeros((count, count)), np.zeros((count, count))
        for e in range(beam.elements):
            part = slice(2 * e, 2 * e + 4)
            k[part, part] += beam.stiffness / h**3 * stiffness
            m[part, part] += beam.mass * h / 420.0 * mass
        m[1, 1] += beam.hub
        m[-2, -2] += beam.tip
        free = slice(2 if beam.clamped else 1, None)
        squares, vectors = eigh(k[free, free], m[free, free])
        self.frequencies = np.sqrt(np.maximum(squares, 0.0))
        if not beam.clamped:
            self.frequencies[0] = 0.0
            vectors[:, 0] *= np.sign(vectors[0, 0])
        self._vectors = np.zeros((count, squares.size))
        self._vectors[free] = vectors
        unit = np.zeros(count)
        unit[::2] = 1.0
        self.weights = self._vectors.T @ m @ unit

    def at(self, x: float) -> np.ndarray:
        """Deflection (kg^(-1/2)) of each mode at a place (m)."""
        h = self.beam.length / self.beam.elements
        e = min(int(x / h), self.beam.elements - 1)
        s = x / h - e
        shape = [1 - 3 * s**2 + 2 * s**3, h * s * (1 - s) ** 2, 3 * s**2 - 2 * s**3, h * s**2 * (s - 1)]
        return np.array(shape) @ self._vectors[2 * e : 2 * e + 4]


@dataclass(frozen=True)
class Found:
    """A motion: when contacts begin (s), impulse of all (N s), and what internal damping has taken (J)."""

    contacts: list[float]
    impulse: float
    lost: float
    #: largest deflection of the place that is touched, from the axis that a rigid beam would have, m
    swing: float


def fall(
    beam: Beam,
    stop: float,
    *,
    place: float | None = None,
    origin: tuple[float, float] = (0.3, 0.0),
    slope: float = pi / 10,
    angle: float = pi / 4,
    end: float = 0.4,
    gravity: float = 9.8,
) -> Found:
    """Let a beam on a pin fall onto a slope with a spring (N/m) under one place, the tip if none is given.

    A spring without end is a rigid stop, on which the flexibility of the modes that are left out rests.  The
    rotation is as large as it is, bending is small: the axis turns with the mean axis, and what that does to
    bending is neglected but for the direction of force and weight.
    """
    modes, n = Modes(beam), beam.modes + 1
    x = beam.length if place is None else place
    shapes, square, damping, spring = _at(modes, n, x, stop)
    scale = shapes[0] / x  # angle (rad) per coordinate
    past = -origin[0] * sin(slope) + origin[1] * cos(slope)

    def gap(t: float, y: np.ndarray) -> float:
        turn = scale * y[0] - slope
        return float(x * sin(turn) + shapes[1:] @ y[1:n] * cos(turn) - past)

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        theta, speeds, force = scale * y[0], y[n : 2 * n], max(0.0, -spring * gap(t, y))
        load = -gravity * cos(theta) * modes.weights[:n]
        if force:
            turn = theta - slope
            row = cos(turn) * shapes
            row[0] = scale * (x * cos(turn) - shapes[1:] @ y[1:n] * sin(turn))
            load = load + force * row
        accelerations = load - damping * speeds - square * y[:n]
        return np.concatenate([speeds, accelerations, [force, damping @ speeds**2]])

    start = np.zeros(2 * n + 2)
    start[0] = angle / scale
    return _march(rates, gap, start, end, np.concatenate([[0.0], shapes[1:]]), 1e-4)


def shake(
    beam: Beam, stop: float, clearance: float, acceleration: float, frequency: float, sweep: float, end: float
) -> Found:
    """Shake a clamped beam (m/s^2, Hz, Hz/s) beside a spring (N/m) at its tip, from rest."""
    modes, n = Modes(beam), beam.modes
    shapes, square, damping, spring = _at(modes, n, beam.length, stop)

    def gap(t: float, y: np.ndarray) -> float:
        return float(clearance + shapes @ y[:n])

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        speeds, force = y[n : 2 * n], max(0.0, -spring * gap(t, y))
        load = (
            acceleration * sin(2.0 * pi * (frequency + 0.5 * sweep * t) * t) * modes.weights[:n] + force * shapes
        )
        accelerations = load - damping * speeds - square * y[:n]
        return np.concatenate([speeds, accelerations, [force, damping @ speeds**2]])

    return _march(rates, gap, np.zeros(2 * n + 2), end, shapes, 1e-3)


def _at(modes: Modes, n: int, x: float, stop: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Return n modes at a place, their squared frequencies, their damping, and stop and other modes in series."""
    shapes, square = modes.at(x), modes.frequencies[:n] ** 2
    rest = float(np.sum((shapes[n:] / modes.frequencies[n:]) ** 2))  # m/N
    damping = modes.beam.kelvin_voigt * square
    return shapes[:n], square, damping, 1.0 / (1.0 / stop + rest)


def _march(
    rates: Callable[..., np.ndarray],
    gap: Callable[..., float],
    start: np.ndarray,
    end: float,
    shapes: np.ndarray,
    longest: float,
) -> Found:
    """Integrate; the last two variables are impulse and loss.

    The stop never pulls: steps err by its kinks as they err by all else, and are as short as that asks for.
    """

    def closes(t: float, y: np.ndarray) -> float:
        return gap(t, y)

    closes.direction = -1.0  # type: ignore[attr-defined]
    options = {"method": "DOP853", "rtol": 1e-9, "atol": 1e-11, "max_step": longest}
    done = solve_ivp(rates, (0.0, end), start, events=closes, **options)
    swing = float(np.abs(shapes @ done.y[: shapes.size]).max())
    return Found([*done.t_events[0]], float(done.y[-2, -1]), float(done.y[-1, -1]), swing)

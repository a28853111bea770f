"""The paper's case with a rigid stop in SciPy alone: the reference for event times, impulses and energies.

    python benchmarks/reference_impact.py                  two clamped modes, without and with friction
    python benchmarks/reference_impact.py --modes 4,6,8    that many mean-axis modes, without friction

Nothing of the suite is used: mode shapes in closed form, integrals by Gauss quadrature, equations of motion in
first-order kinetics written out, DOP853 of SciPy at a tolerance of 1e-13, events by its root finder.
It takes seconds for two modes and minutes for ten.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

LENGTH, AREA, DENSITY, MODULUS, SECOND_MOMENT = 1.0, 3.14e-4, 2766.7, 68.952e9, 7.85e-9  # SI units
GRAVITY, START, SLOPE, ORIGIN, FRICTION = 9.8, np.pi / 4, np.pi / 10, 0.3, 0.3
MASS, BENDING = DENSITY * AREA, MODULUS * SECOND_MOMENT  # kg/m, N m²
TOUCH = 0.3165  # s; shortly before the first contact


def clamped(n: int, x: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the n-th clamped-free eigenfunction (n = 1, 2, ...), its slope and its curvature."""
    b = brentq(lambda b: np.cos(b) + 1.0 / np.cosh(b), (n - 1) * np.pi + 0.3, n * np.pi, xtol=1e-15)
    s = (np.cosh(b) + np.cos(b)) / (np.sinh(b) + np.sin(b))
    ch, sh, c, d = np.cosh(b * x), np.sinh(b * x), np.cos(b * x), np.sin(b * x)
    return ch - c - s * (sh - d), b * (sh + d - s * (ch - c)), b**2 * (ch + c - s * (sh + d))


def hinged(n: int, x: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the n-th elastic hinged-free eigenfunction, its slope and its curvature."""
    b = brentq(lambda b: np.sin(b) - np.cos(b) * np.tanh(b), n * np.pi, n * np.pi + 1.2, xtol=1e-15)
    r = np.sin(b) / np.sinh(b)
    return (
        np.sin(b * x) + r * np.sinh(b * x),
        b * (np.cos(b * x) + r * np.cosh(b * x)),
        b**2 * (-np.sin(b * x) + r * np.sinh(b * x)),
    )


@dataclass(frozen=True)
class Rows:
    """Contact point at an instant: gap and slip, rates, rows of the constraints, accelerations without q''."""

    gap: float
    rates: np.ndarray
    rows: np.ndarray
    bias: np.ndarray


@dataclass
class Beam:
    """The beam in the frame of its shape functions; states y = (theta, B, theta', B', impulse)."""

    modes: int
    mean_axis: bool = False
    friction: float = 0.0
    events: list[tuple[str, float]] = field(default_factory=list)
    impulse: float = 0.0  # of the impacts (N s)
    first: float = 0.0  # impulse of the first impact (N s)

    @cached_property
    def integrals(self) -> dict[str, np.ndarray]:
        """M1, K, C, D, S, P of the shape functions; values and H at the tip."""
        x, w = np.polynomial.legendre.leggauss(400)
        x, w = 0.5 * (x + 1.0), 0.5 * w
        shape = hinged if self.mean_axis else clamped
        f, df, ddf = (np.array(part).T for part in zip(*(shape(n + 1, x) for n in range(self.modes)), strict=True))
        tip = np.array([shape(n + 1, np.ones(1))[0][0] for n in range(self.modes)])
        return {
            "M1": MASS * (f.T * w) @ f,
            "K": BENDING * (ddf.T * w) @ ddf,
            "C": MASS * (df.T * (w * 0.5 * (1.0 - x**2))) @ df,
            "D": MASS * (df.T * (w * (1.0 - x))) @ df,
            "S": MASS * (w * x) @ f * (0.0 if self.mean_axis else 1.0),
            "P": MASS * w @ f,
            "H": (df.T * w) @ df,
            "tip": tip,
        }

    def mass_and_force(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return M and Q of first-order kinetics (paper Eq. 10)."""
        o, n = self.integrals, self.modes
        theta, B, rate, Bd = y[0], y[1 : n + 1], y[n + 1], y[n + 2 : 2 * n + 2]
        G = o["M1"] - o["C"]
        M = np.empty((n + 1, n + 1))
        M[0, 0], M[0, 1:], M[1:, 0], M[1:, 1:] = MASS / 3.0 + B @ G @ B, o["S"], o["S"], o["M1"]
        c, s = np.cos(theta), np.sin(theta)
        lever = 0.5 * MASS * c - 0.5 * c * B @ o["D"] @ B - s * o["P"] @ B
        Q = np.empty(n + 1)
        Q[0] = -2.0 * rate * B @ G @ Bd - GRAVITY * lever
        Q[1:] = -o["K"] @ B + rate**2 * G @ B - GRAVITY * (c * o["P"] - s * o["D"] @ B)
        return M, Q

    def contact(self, y: np.ndarray) -> Rows:
        """Return the tip against the slope (paper Eqs. 22 to 24)."""
        o, n = self.integrals, self.modes
        B, rate, Bd = y[1 : n + 1], y[n + 1], y[n + 2 : 2 * n + 2]
        s, c = np.sin(y[0] - SLOPE), np.cos(y[0] - SLOPE)
        HB, HBd = o["H"] @ B, o["H"] @ Bd
        px, py, vx, vy = 1.0 - 0.5 * B @ HB, o["tip"] @ B, -B @ HBd, o["tip"] @ Bd
        normal = np.concatenate([[px * c - py * s], -s * HB + c * o["tip"]])
        along = np.concatenate([[-px * s - py * c], -c * HB - s * o["tip"]])
        curve, spin = Bd @ HBd, rate**2
        bias = [
            2.0 * rate * (c * vx - s * vy) - spin * (s * px + c * py) - s * curve,
            -2.0 * rate * (s * vx + c * vy) - spin * (c * px - s * py) - c * curve,
        ]
        rows = np.array([normal, along])
        return Rows(px * s + py * c + ORIGIN * np.sin(SLOPE), rows @ y[n + 1 : 2 * n + 2], rows, np.array(bias))

    def force(self, y: np.ndarray, side: float) -> tuple[float, np.ndarray]:
        """Return the normal force (N) that keeps the tip on the slope while it slips, and q''."""
        M, Q = self.mass_and_force(y)
        r = self.contact(y)
        pull = r.rows[0] - self.friction * side * r.rows[1]
        solved = np.linalg.solve(M, np.column_stack([Q, pull]))
        pressure = -(r.bias[0] + r.rows[0] @ solved[:, 0]) / (r.rows[0] @ solved[:, 1])
        return float(pressure), solved[:, 0] + solved[:, 1] * pressure

    def energy(self, y: np.ndarray) -> float:
        """Return kinetic, elastic and gravity energy together (J)."""
        o, n = self.integrals, self.modes
        M, _ = self.mass_and_force(y)
        B, v = y[1 : n + 1], y[n + 1 : 2 * n + 2]
        s, c = np.sin(y[0]), np.cos(y[0])
        height = 0.5 * MASS * s - 0.5 * s * B @ o["D"] @ B + c * o["P"] @ B
        return float(0.5 * v @ M @ v + 0.5 * B @ o["K"] @ B + GRAVITY * height)

    def march(self, end: float) -> np.ndarray:
        """March from rest to `end` (s); fills `events`, `impulse`, `first`; returns the last state."""
        y, t, side = np.zeros(2 * self.modes + 3), 0.0, 0.0
        y[0] = START
        while t < end:
            t, y, fallen = self._phase(t, y, side, min(end, TOUCH) if t < TOUCH else end)
            if fallen == "touch":
                side = self._impact(t, y)
            elif fallen == "release":
                self.events.append(("release", t))
                side = 0.0
            elif fallen == "reversal":
                side = self._reversal(t, y)
        return y

    def _phase(self, t: float, y: np.ndarray, side: float, end: float) -> tuple[float, np.ndarray, str]:
        """March one phase: free if `side` is 0, else in contact; returns time, state and what ended it."""
        n = self.modes

        def rate(_: float, y: np.ndarray) -> np.ndarray:
            if side:
                pressure, qdd = self.force(y, side)
            else:
                pressure, qdd = 0.0, np.linalg.solve(*self.mass_and_force(y))
            return np.concatenate([y[n + 1 : 2 * n + 2], qdd, [pressure]])

        # a free phase that starts below the slope by rounding would never cross it on its way down
        below = min(self.contact(y).gap, 0.0)

        def gap(_: float, y: np.ndarray) -> float:
            return self.contact(y).gap - below

        def pressure(_: float, y: np.ndarray) -> float:
            return self.force(y, side)[0]

        def slip(_: float, y: np.ndarray) -> float:
            return float(self.contact(y).rates[1] * side)

        names = ["release", "reversal"][: 1 + bool(self.friction)] if side else ["touch"]
        functions = [{"touch": gap, "release": pressure, "reversal": slip}[name] for name in names]
        for function in functions:
            function.terminal, function.direction = True, -1.0  # type: ignore[attr-defined]
        fastest = np.sqrt(np.linalg.eigvals(np.linalg.solve(self.integrals["M1"], self.integrals["K"])).real.max())
        step = 0.25 / fastest if t >= TOUCH else np.inf
        found = solve_ivp(rate, (t, end), y, "DOP853", events=functions, rtol=1e-13, atol=1e-14, max_step=step)
        fallen = next((name for name, times in zip(names, found.t_events, strict=True) if times.size), "")
        return float(found.t[-1]), found.y[:, -1], fallen

    def _impact(self, t: float, y: np.ndarray) -> float:
        """Apply the plastic, frictionless impulse to `y`; returns the side to which it slips, 0 if free."""
        n, r = self.modes, self.contact(y)
        M, _ = self.mass_and_force(y)
        jump = np.linalg.solve(M, r.rows[0])
        size = -r.rates[0] / (r.rows[0] @ jump)
        y[n + 1 : 2 * n + 2] += jump * size
        self.impulse += float(size)
        self.first = self.first or float(size)
        side = float(np.sign(self.contact(y).rates[1]))
        closed = self.force(y, side)[0] > 0.0
        self.events.append(("impact" if closed else "rebound", t))
        return side if closed else 0.0

    def _reversal(self, t: float, y: np.ndarray) -> float:
        """Return the side to which the tip slips on; stops the program if it would stick."""
        M, Q = self.mass_and_force(y)
        r = self.contact(y)
        inverse = np.linalg.solve(M, np.column_stack([Q, r.rows.T]))
        normal, along = np.linalg.solve(r.rows @ inverse[:, 1:], -r.bias - r.rows @ inverse[:, 0])
        if abs(along) <= FRICTION * normal:
            raise SystemExit(f"sticks at {t} s: not written here")
        self.events.append(("reversal", t))
        return float(-np.sign(along))


def two_modes(friction: float) -> Beam:
    """Return two clamped modes after the first macro-collision."""
    beam = Beam(2, friction=friction)
    beam.march(0.335)
    return beam


def mean_axis(modes: int, end: float = 0.34) -> tuple[float, float]:
    """Return impulse of the first macro-collision (N s) and energy at `end` (J), rigid frictionless stop."""
    beam = Beam(modes, mean_axis=True)
    y = beam.march(end)
    return beam.impulse + float(y[-1]), beam.energy(y)


def main() -> None:
    """Print the numbers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--modes", help="numbers of mean-axis modes, separated by commas")
    given = parser.parse_args()
    for modes in map(int, given.modes.split(",")) if given.modes else ():
        impulse, energy = mean_axis(modes)
        print(f"{modes} mean-axis modes: impulse {impulse:.9f} N s, energy left {energy:.9f} J", flush=True)
    if not given.modes:
        for friction in (0.0, FRICTION):
            beam = two_modes(friction)
            print(f"two clamped modes, friction {friction}: first impulse {beam.first:.10f} N s")
            print("".join(f"  {kind:8s} {time:.12f} s\n" for kind, time in beam.events), end="")


if __name__ == "__main__":
    main()

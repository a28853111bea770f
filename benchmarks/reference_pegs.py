"""The paper's beam on rigid pegs in SciPy alone: contacts whose places slide along the beam.

    python benchmarks/reference_pegs.py                                  at (0.5, 0), without and with friction
    python benchmarks/reference_pegs.py --pegs 0.4,-0.02,0.7,-0.02       several pegs

The beam is that of `reference_impact.py` on mean-axis modes.  Nothing of the suite is used.  A peg is a point that
meets the axis r(x) where (r - c).r' = 0; gap and slip are taken there, with the rates of the place and of the
tangent.  Which contacts stay closed and how they slip is Coulomb's law as a linear complementarity problem
(Lötstedt 1982), solved by Lemke's method; impacts are plastic and without friction (Moreau).  It takes a minute or
two.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from reference_impact import START, Beam, hinged
from scipy.integrate import solve_ivp

Watch = Callable[[np.ndarray], float]
TIGHT = 1e-7  # s; impacts of different pegs in quicker succession accumulate, and close all


class RayError(Exception):
    """The complementarity problem has no solution (Painleve)."""


def lemke(M: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return z >= 0 with M z + q >= 0 and z.(M z + q) = 0: Lemke's method (Cottle, Pang, Stone 1992, 4.4)."""
    n = q.size
    if n == 0 or (q >= 0.0).all():
        return np.zeros(n)
    table = np.hstack([np.eye(n), -M, -np.ones((n, 1)), q[:, None]])
    basis = list(range(n))
    row, entering = int(np.argmin(q)), 2 * n
    for _ in range(50 * n):
        table[row] /= table[row, entering]
        for other in range(n):
            if other != row:
                table[other] -= table[other, entering] * table[row]
        leaving, basis[row] = basis[row], entering
        if leaving == 2 * n:
            z = np.zeros(n)
            for place, variable in enumerate(basis):
                if variable >= n:
                    z[variable - n] = table[place, -1]
            return z
        entering = leaving + n if leaving < n else leaving - n
        column = table[:, entering]
        positive = column > 1e-12 * np.abs(column).max()
        if not positive.any():
            raise RayError
        ratios = np.where(positive, table[:, -1] / np.where(positive, column, 1.0), np.inf)
        least = ratios.min()
        ties = np.flatnonzero(ratios <= least + 1e-14 * abs(least))
        row = next((int(tie) for tie in ties if basis[tie] == 2 * n), int(ties[0]))
    raise RayError


@dataclass
class Touch:
    """A peg against the beam at an instant: SI units."""

    place: float
    gap: float
    rates: np.ndarray  # of gap and slip
    rows: np.ndarray  # (2, d)
    bias: np.ndarray  # accelerations of gap and slip without q''


@dataclass
class BeamOnPegs(Beam):
    """The beam above pegs; states y = (theta, B, theta', B', impulse of finite forces, loss by friction)."""

    mean_axis: bool = True
    pegs: list[tuple[float, float]] = field(default_factory=lambda: [(0.5, 0.0)])
    log: list[str] = field(default_factory=list)

    def shapes(self, x: float) -> tuple[np.ndarray, ...]:
        """Return the functions with two derivatives at x, and the integral H of their slopes' products up to x."""
        nodes, weights = np.polynomial.legendre.leggauss(40)
        at = np.append(0.5 * x * (nodes + 1.0), x)
        f, df, ddf = (
            np.array(part).T for part in zip(*(hinged(n + 1, at) for n in range(self.modes)), strict=True)
        )
        H = (df[:-1].T * (0.5 * x * weights)) @ df[:-1]
        return f[-1], df[-1], ddf[-1], H

    def axis(self, y: np.ndarray, x: float) -> tuple[np.ndarray, ...]:
        """Return r, r', r'', J, J' and the velocity terms Jdot v of the axis at x, inertial."""
        n = self.modes
        B, rate, Bd = y[1 : n + 1], y[n + 1], y[n + 2 : 2 * n + 2]
        f, df, ddf, H = self.shapes(x)
        s, c = np.sin(y[0]), np.cos(y[0])
        A, E = np.array([[c, -s], [s, c]]), np.array([[-s, -c], [c, -s]])
        u, du, ddu = np.array([x - 0.5 * B @ H @ B, f @ B]), np.zeros(2), np.zeros(2)
        du[:] = 1.0 - 0.5 * (df @ B) ** 2, df @ B
        ddu[:] = -(df @ B) * (ddf @ B), ddf @ B
        local = np.vstack([-(H @ B), f])  # d u / d B
        dlocal = np.vstack([-(df @ B) * df, df])
        J = np.hstack([(E @ u)[:, None], A @ local])
        dJ = np.hstack([(E @ du)[:, None], A @ dlocal])
        ud = local @ Bd
        turning = -(rate**2) * (A @ u) + 2.0 * rate * (E @ ud) + A @ np.array([-(Bd @ H @ Bd), 0.0])
        return A @ u, A @ du, A @ ddu, J, dJ, turning

    def touch(self, y: np.ndarray, peg: tuple[float, float]) -> Touch:
        """Return the contact problem of a peg below the beam."""
        n, center, x = self.modes, np.array(peg), float(np.hypot(*peg))
        v = y[n + 1 : 2 * n + 2]
        for _ in range(30):
            r, dr, ddr, J, dJ, turning = self.axis(y, x)
            change = -((r - center) @ dr) / (dr @ dr + (r - center) @ ddr)
            x += change
            if abs(change) < 1e-15:
                break
        r, dr, ddr, J, dJ, turning = self.axis(y, x)
        length = np.sqrt(dr @ dr)
        t = dr / length
        normal = np.array([-t[1], t[0]])
        away, Jv, dJv = r - center, J @ v, dJ @ v
        moving = -(Jv @ dr + away @ dJv) / (dr @ dr + away @ ddr)
        turn = (normal @ dJv + moving * (normal @ ddr)) / length
        bias = np.array(
            [
                normal @ turning + moving * (normal @ dJv) - turn * (t @ Jv),
                t @ turning + moving * (t @ dJv) + turn * (normal @ Jv),
            ]
        )
        rows = np.vstack([normal @ J, t @ J])
        return Touch(x, float(normal @ away), rows @ v, rows, bias)

    def solve(self, y: np.ndarray, closed: dict[int, int]) -> tuple[np.ndarray, np.ndarray, list[Touch]]:
        """Return forces (contacts, 2) and q'' of closed contacts that slip with the given signs, 0 for stick."""
        M, Q = self.mass_and_force(y)
        touches = [self.touch(y, self.pegs[i]) for i in closed]
        free = np.linalg.solve(M, Q)
        if not closed:
            return np.zeros((0, 2)), free, touches
        directions, equations, right = [], [], []
        for contact, sign in zip(touches, closed.values(), strict=True):
            directions.append(contact.rows[0] - self.friction * sign * contact.rows[1])
            equations.append(contact.rows[0])
            right.append(-contact.bias[0])
            if sign == 0 and self.friction:
                directions.append(contact.rows[1])
                equations.append(contact.rows[1])
                right.append(-contact.bias[1])
        D, G = np.array(directions), np.array(equations)
        sizes = np.linalg.solve(G @ np.linalg.solve(M, D.T), np.array(right) - G @ free)
        qdd = free + np.linalg.solve(M, D.T @ sizes)
        forces, k = np.zeros((len(closed), 2)), 0
        for i, sign in enumerate(closed.values()):
            forces[i] = sizes[k], -self.friction * sign * sizes[k]
            k += 1
            if sign == 0 and self.friction:
                forces[i, 1] = sizes[k]
                k += 1
        return forces, qdd, touches

    def decide(self, y: np.ndarray, candidates: list[int]) -> dict[int, int]:
        """Return which contacts stay closed and the signs of their slip, by complementarity of accelerations."""
        if not candidates:
            return {}
        M, Q = self.mass_and_force(y)
        touches = {i: self.touch(y, self.pegs[i]) for i in candidates}
        free, mu = np.linalg.solve(M, Q), self.friction
        sign = {i: 0 if abs(c.rates[1]) < 1e-9 and mu else int(np.sign(c.rates[1])) for i, c in touches.items()}
        # unknowns: normal forces; for contacts at rest kappa = lambda_t + mu lambda_n, and the backward slip
        rest = [i for i in candidates if sign[i] == 0 and mu]
        n, m = len(candidates), len(rest)
        D = np.array([touches[i].rows[0] - mu * (sign[i] or 1.0) * touches[i].rows[1] for i in candidates])
        D = np.vstack([D, *(touches[i].rows[1] for i in rest)]) if m else D
        G = np.array([*(touches[i].rows[0] for i in candidates), *(touches[i].rows[1] for i in rest)])
        bias = np.array([*(touches[i].bias[0] for i in candidates), *(touches[i].bias[1] for i in rest)])
        W = G @ np.linalg.solve(M, D.T)
        size = n + 2 * m
        A, q = np.zeros((size, size)), np.zeros(size)
        A[: n + m, : n + m], q[: n + m] = W, G @ free + bias
        for k, i in enumerate(rest):
            A[n + k, n + m + k] = 1.0
            A[n + m + k, candidates.index(i)], A[n + m + k, n + k] = 2.0 * mu, -1.0
        z = lemke(A, q)
        acceleration = A @ z + q
        result = {}
        for k, i in enumerate(candidates):
            if z[k] <= 0.0:
                continue
            result[i] = sign[i]
            if i in rest:
                j = rest.index(i)
                forward, backward = acceleration[n + j], z[n + m + j]
                # what is not in the basis is 0 exactly, what is computed from it only to rounding
                result[i] = -1 if backward > 0.0 else 1 if forward > 1e-9 else 0
        return result

    def impact(self, y: np.ndarray, candidates: list[int], close: bool) -> tuple[np.ndarray, float]:
        """Apply plastic, frictionless impulses to y; return them (N s) and the energy lost (J).

        With `close` all candidates are closed, whatever is left of their gap rates.
        """
        n = self.modes
        M, _ = self.mass_and_force(y)
        D = np.array([self.touch(y, self.pegs[i]).rows[0] for i in candidates])
        v = y[n + 1 : 2 * n + 2]
        before = 0.5 * v @ M @ v
        W = D @ np.linalg.solve(M, D.T)
        P = np.linalg.solve(W, -D @ v) if close else lemke(W, D @ v)
        v += np.linalg.solve(M, D.T @ P)
        return P, float(before - 0.5 * v @ M @ v)

    def watched(self, y: np.ndarray, closed: dict[int, int]) -> dict[tuple[str, int], Watch]:
        """Return functions that fall through zero where the phase ends, by kind and peg."""
        found: dict[tuple[str, int], Watch] = {}
        for i, peg in enumerate(self.pegs):
            if i not in closed:
                # a flight that starts below the peg by rounding would never cross it on its way down
                below = min(self.touch(y, peg).gap, 0.0)
                found["touch", i] = lambda y, peg=peg, below=below: self.touch(y, peg).gap - below
        for k, (i, sign) in enumerate(closed.items()):
            peg = self.pegs[i]
            found["release", i] = lambda y, k=k: self.solve(y, closed)[0][k, 0]
            if self.friction and sign:
                found["turn", i] = lambda y, peg=peg, sign=sign: sign * self.touch(y, peg).rates[1]
            elif self.friction:
                found["slip", i] = lambda y, k=k: self.cone(*self.solve(y, closed)[0][k])
        return found

    def cone(self, normal: float, tangential: float) -> float:
        """Return how far a force (N) is inside of the friction cone."""
        return self.friction * normal - abs(tangential)

    def march(self, end: float) -> np.ndarray:
        """March from rest to `end` (s); fills `log`; returns the last state."""
        y, t, closed, last = np.zeros(2 * self.modes + 4), 0.0, dict[int, int](), -1.0
        y[0] = START
        while t < end:
            t, y, fallen = self.fly_or_slide(t, y, closed, end)
            if fallen is None:
                break
            kind, i = fallen
            candidates = sorted({*closed, i} if kind != "release" else {*closed} - {i})
            if kind == "touch":
                close = t - last < TIGHT
                if close:
                    candidates = [j for j, peg in enumerate(self.pegs) if self.touch(y, peg).gap < 1e-9]
                last = t
                P, lost = self.impact(y, candidates, close)
                place = self.touch(y, self.pegs[i]).place
                self.log.append(f"{t:.9f} impact {candidates} at {place:.9f} m, {P} N s, lost {lost:.9f} J")
                candidates = [j for j, p in zip(candidates, P, strict=True) if p > 0.0 or close]
            closed = self.decide(y, candidates)
            self.log.append(f"{t:.9f} {kind} {i}, slip of closed ones {closed}")
        return y

    def fly_or_slide(
        self, t: float, y: np.ndarray, closed: dict[int, int], end: float
    ) -> tuple[float, np.ndarray, tuple[str, int] | None]:
        """March one phase; returns time, state and what ended it."""
        n, watched = self.modes, self.watched(y, closed)

        def rate(_: float, y: np.ndarray) -> np.ndarray:
            forces, qdd, touches = self.solve(y, closed)
            lost = -sum(force[1] * contact.rates[1] for force, contact in zip(forces, touches, strict=True))
            return np.concatenate([y[n + 1 : 2 * n + 2], qdd, [forces[:, 0].sum(), lost]])

        events = [lambda _, y, function=function: function(y) for function in watched.values()]
        for event in events:
            event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
        accuracy = {"rtol": 1e-12, "atol": 1e-13, "max_step": 1e-3}
        found = solve_ivp(rate, (t, end), y, "DOP853", events=events, **accuracy)
        fallen = next((name for name, times in zip(watched, found.t_events, strict=True) if times.size), None)
        return float(found.t[-1]), found.y[:, -1].copy(), fallen


def main() -> None:
    """Print the events."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pegs", default="0.5,0", help="x and y (m) of each")
    parser.add_argument("--friction", default="0,0.3")
    parser.add_argument("--modes", type=int, default=4)
    parser.add_argument("--end", type=float, default=0.45)
    given = parser.parse_args()
    numbers = list(map(float, given.pegs.split(",")))
    for friction in map(float, given.friction.split(",")):
        pegs = list(zip(numbers[::2], numbers[1::2], strict=True))
        beam = BeamOnPegs(given.modes, friction=friction, pegs=pegs)
        y = beam.march(given.end)
        print(f"friction {friction}:", *beam.log, sep="\n  ")
        print(f"  energy {beam.energy(y):.9f} J, lost to friction {y[-1]:.9f} J, angle {y[0]:.9f}")
        print(f"  impulse of finite forces {y[-2]:.9f} N s")


if __name__ == "__main__":
    main()

"""The paper's beam on elastic stops in SciPy alone, with the flexibility that its modes leave out.

    python benchmarks/reference_compliance.py                     a peg at (0.5, 0), as a spring alone
    python benchmarks/reference_compliance.py --residual          the same with the residual flexibility behind it
    python benchmarks/reference_compliance.py --pegs 0.35,0,0.7,0 --residual
    python benchmarks/reference_compliance.py --slope --residual  the tip on the slope

The beam is that of `reference_impact.py` on mean-axis modes.  Nothing of the suite is used.  Contacts i meet the
beam at x_i, where the normal has the part c_i across the frame.  Behind their gaps g stands the compliance

    A_ij = delta_ij / k + c_i c_j R(x_i, x_j),     R = G - Phi K^-1 Phi^T,

with the static flexibility G of the whole beam under loads that its own rotation balances.  Closed contacts carry
A lambda = -g, and those with lambda < 0 are open.  The energy g.A^-1 g / 2 is a function of q; its derivative

    lambda.dg/dq - 1/2 lambda.(dA/dq) lambda

has a part of its own where a place slides or turns: without it a run makes energy.  Friction is Coulomb's, slip
only: a program that would have to stick stops.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from reference_impact import BENDING, ORIGIN, SLOPE, START, Beam
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

NODES, WEIGHTS = np.polynomial.legendre.leggauss(64)


def flexibility(x: float, y: float) -> tuple[float, float]:
    """Return the deflection at x under a unit force at y, and its derivative over x (m/N, 1/N); length 1 m.

    Bending moments (y - s)_+ - y b(s) with b = 1 - 3 s/2 + s^3/2, the moment of inertia forces that balance a unit
    moment about the pin; G is the integral of two of them over E I, in the frame of mean axes.
    """

    def balance(x: float) -> float:  # int_0^x (x - s) b(s) ds
        return x**2 / 2.0 - x**3 / 4.0 + x**5 / 40.0

    small, large = min(x, y), max(x, y)
    both = small**2 * (3.0 * large - small) / 6.0
    slope = x * y - 0.5 * x**2 if x < y else 0.5 * y**2
    value = both - y * balance(x) - x * balance(y) + 33.0 / 140.0 * x * y
    slope += -y * (x - 0.75 * x**2 + x**4 / 8.0) - balance(y) + 33.0 / 140.0 * y
    return value / BENDING, slope / BENDING


@dataclass
class Touch:
    """A contact at an instant: SI units."""

    place: float
    gap: float
    rows: np.ndarray  # (2, d), of gap and slip
    bias: float  # acceleration of slip without q''
    sliding: np.ndarray  # d place / dq
    across: float = 1.0  # part of the normal across the frame
    turning: np.ndarray | float = 0.0  # d across / dq


@dataclass
class Contact:
    """From a touch to the release that follows: SI units."""

    index: int
    start: float
    end: float = np.nan
    impulse: float = 0.0
    peak: float = 0.0


@dataclass
class ElasticBeam(Beam):
    """The beam above pegs or the slope; states y = (theta, B, theta', B', impulses, loss by friction)."""

    mean_axis: bool = True
    pegs: list[tuple[float, float]] = field(default_factory=list)  # none: the tip on the slope
    stiffness: float = 1e6  # N/m
    residual: bool = False
    log: list[tuple[float, str, int]] = field(default_factory=list)  # time, event, contact
    contacts: list[Contact] = field(default_factory=list)

    @property
    def count(self) -> int:
        """Number of contacts."""
        return len(self.pegs) or 1

    @cached_property
    def roots(self) -> np.ndarray:
        """Roots of tan b = tanh b."""
        return np.array(
            [
                brentq(lambda b: np.sin(b) - np.cos(b) * np.tanh(b), n * np.pi, n * np.pi + 1.2, xtol=1e-15)
                for n in range(1, self.modes + 1)
            ]
        )

    def functions(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the eigenfunctions at x with two derivatives, each (places, modes)."""
        b = self.roots
        z = np.multiply.outer(x, b)
        s, c, ratio = np.sin(z), np.cos(z), np.sin(b) / np.sinh(b)
        sh, ch = ratio * np.sinh(z), ratio * np.cosh(z)
        return s + sh, b * (c + ch), b**2 * (sh - s)

    def axis(self, y: np.ndarray, x: float) -> tuple[np.ndarray, ...]:
        """Return r, r', r'', J, J' and the velocity terms J_dot v of the axis at x."""
        n = self.modes
        B, rate, Bd = y[1 : n + 1], y[n + 1], y[n + 2 : 2 * n + 2]
        (f,), (df,), (ddf,) = self.functions(np.array([x]))
        slopes = self.functions(0.5 * x * (NODES + 1.0))[1]
        H = (slopes.T * (0.5 * x * WEIGHTS)) @ slopes
        s, c = np.sin(y[0]), np.cos(y[0])
        A, E = np.array([[c, -s], [s, c]]), np.array([[-s, -c], [c, -s]])
        HB, slope = H @ B, df @ B
        u, du, ddu = np.array([x - 0.5 * B @ HB, f @ B]), np.array([1.0 - 0.5 * slope**2, slope]), np.zeros(2)
        ddu[:] = -slope * (ddf @ B), ddf @ B
        local, dlocal = np.vstack([-HB, f]), np.vstack([-slope * df, df])
        J, dJ = np.column_stack([E @ u, A @ local]), np.column_stack([E @ du, A @ dlocal])
        spin = -(rate**2) * (A @ u) + 2.0 * rate * (E @ (local @ Bd)) + A @ np.array([-(Bd @ H @ Bd), 0.0])
        return A @ u, A @ du, A @ ddu, J, dJ, spin

    def on_peg(self, y: np.ndarray, peg: tuple[float, float]) -> Touch:
        """Return the contact of a point below the beam with the place where (r - c).r' = 0."""
        n, centre, x = self.modes, np.array(peg), float(np.hypot(*peg))
        v, change = y[n + 1 : 2 * n + 2], 1.0
        while abs(change) > 1e-13:
            r, dr, ddr, J, dJ, spin = self.axis(y, x)
            bend = dr @ dr + (r - centre) @ ddr
            change = -((r - centre) @ dr) / bend
            x += change
        length = np.sqrt(dr @ dr)
        t, away = dr / length, r - centre
        normal = np.array([-t[1], t[0]])
        sliding = -(dr @ J + away @ dJ) / bend
        moving = sliding @ v
        turn = (normal @ (dJ @ v) + moving * (normal @ ddr)) / length
        bias = t @ spin + moving * (t @ (dJ @ v)) + turn * (normal @ (J @ v))
        return Touch(x, float(normal @ away), np.vstack([normal @ J, t @ J]), float(bias), sliding)

    def on_slope(self, y: np.ndarray) -> Touch:
        """Return the contact of the tip with the slope."""
        r, _, _, J, _, spin = self.axis(y, 1.0)
        s, c = np.sin(SLOPE), np.cos(SLOPE)
        normal, t = np.array([-s, c]), np.array([c, s])
        first = np.eye(self.modes + 1)[0]
        gap, bias = normal @ (r - np.array([ORIGIN, 0.0])), t @ spin
        across, turning = np.cos(y[0] - SLOPE), -np.sin(y[0] - SLOPE) * first
        return Touch(1.0, float(gap), np.vstack([normal @ J, t @ J]), float(bias), 0.0 * first, across, turning)

    def touches(self, y: np.ndarray) -> list[Touch]:
        """Return all contacts, open or closed."""
        return [self.on_peg(y, peg) for peg in self.pegs] or [self.on_slope(y)]

    def compliance(self, touches: list[Touch]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return A, R and dR(x_i, x_j)/dx_i of the contacts, each (n, n)."""
        n, none = len(touches), np.zeros((len(touches),) * 2)
        if not self.residual:
            return np.eye(n) / self.stiffness, none, none
        x = np.array([touch.place for touch in touches])
        f, df, _ = self.functions(x)
        whole = np.array([[flexibility(a, b) for b in x] for a in x])
        soft = np.linalg.solve(self.integrals["K"], f.T)
        R, dR = whole[..., 0] - f @ soft, whole[..., 1] - df @ soft
        c = np.array([touch.across for touch in touches])
        return np.eye(n) / self.stiffness + np.outer(c, c) * R, R, dR

    def forces(self, touches: list[Touch], closed: list[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the normal forces (N), the gaps that are left behind the compliance (m), and -dV/dq."""
        A, R, dR = self.compliance(touches)
        gaps, sizes = np.array([touch.gap for touch in touches]), np.zeros(len(touches))
        if closed:
            sizes[closed] = np.linalg.solve(A[np.ix_(closed, closed)], -gaps[closed])
        c = np.array([touch.across for touch in touches])
        pull = np.zeros(self.modes + 1)
        for size, touch, slide, turn in zip(sizes, touches, dR @ (c * sizes), R @ (c * sizes), strict=True):
            pull += size * (touch.rows[0] + touch.across * slide * touch.sliding + turn * touch.turning)
        return sizes, gaps + A @ sizes, pull

    def rate(self, y: np.ndarray, closed: list[int], signs: np.ndarray) -> np.ndarray:
        """Return dy/dt with the given closed contacts and signs of their slip."""
        n = self.modes
        M, Q = self.mass_and_force(y)
        v, sizes, lost = y[n + 1 : 2 * n + 2], np.zeros(self.count), 0.0
        if closed:
            touches = self.touches(y)
            sizes, _, pull = self.forces(touches, closed)
            Q = Q + pull
            for size, touch, sign in zip(sizes, touches, signs, strict=True):
                Q -= self.friction * sign * size * touch.rows[1]
                lost += self.friction * sign * size * float(touch.rows[1] @ v)
        return np.concatenate([v, np.linalg.solve(M, Q), sizes, [lost]])

    def slip(self, y: np.ndarray, i: int) -> float:
        """Return the rate of slip of a contact (m/s)."""
        return float(self.touches(y)[i].rows[1] @ y[self.modes + 1 : 2 * self.modes + 2])

    def sign_after(self, y: np.ndarray, closed: list[int], signs: np.ndarray, i: int) -> float:
        """Return the sign of slip after its rate has come to zero; the last one has been the opposite."""
        turned = signs.copy()
        turned[i] *= -1.0
        touch = self.touches(y)[i]
        qdd = self.rate(y, closed, turned)[self.modes + 1 : 2 * self.modes + 2]
        if turned[i] * (touch.rows[1] @ qdd + touch.bias) <= 0.0:
            raise SystemExit("the contact sticks: not written here")
        return float(turned[i])

    def watched(self, closed: list[int], signs: np.ndarray) -> dict[tuple[str, int], Callable[..., float]]:
        """Return functions of (t, y) that fall through zero where a phase ends, by kind and contact."""
        found: dict[tuple[str, int], Callable[..., float]] = {}
        for i in range(self.count):
            if i in closed:
                found["release", i] = lambda _, y, i=i: self.forces(self.touches(y), closed)[0][i]
                if self.friction:
                    found["turn", i] = lambda _, y, i=i: signs[i] * self.slip(y, i)
            else:
                found["touch", i] = lambda _, y, i=i: self.forces(self.touches(y), closed)[1][i]
        for function in found.values():
            function.terminal, function.direction = True, -1.0  # type: ignore[attr-defined]
        return found

    def start(self) -> np.ndarray:
        """Return the state at rest at the first angle."""
        y = np.zeros(2 * self.modes + 3 + self.count)
        y[0] = START
        return y

    def march(self, end: float) -> np.ndarray:
        """March from rest to `end` (s); fills `log` and `contacts`; returns the last state."""
        n, t, closed, signs = self.modes, 0.0, dict[int, Contact](), np.zeros(self.count)
        y = self.start()
        while t < end:
            held = sorted(closed)
            watched = self.watched(held, signs)
            found = solve_ivp(
                lambda _, y: self.rate(y, held, signs),  # noqa: B023
                (t, end),
                y,
                "DOP853",
                events=list(watched.values()),
                dense_output=bool(closed),
                rtol=1e-13,
                atol=1e-14,
                max_step=2e-4 if t else 1e-3,
            )
            for i, contact in closed.items():
                contact.peak = max(contact.peak, self.largest(found.t, found.sol, held, i))
                contact.impulse += found.y[2 * n + 2 + i, -1] - y[2 * n + 2 + i]
            t, y = float(found.t[-1]), found.y[:, -1].copy()
            fallen = next((name for name, times in zip(watched, found.t_events, strict=True) if times.size), None)
            if fallen is None:
                break
            kind, i = fallen
            self.log.append((t, kind, i))
            if kind == "touch":
                closed[i], signs[i] = Contact(i, t), np.sign(self.slip(y, i))
                self.contacts.append(closed[i])
            elif kind == "release":
                closed.pop(i).end = t
            else:
                signs[i] = self.sign_after(y, held, signs, i)
        return y

    def largest(self, times: np.ndarray, states: Callable[..., np.ndarray], closed: list[int], i: int) -> float:
        """Return the largest force of a contact in a phase (N)."""

        def less(time: float) -> float:
            return -float(self.forces(self.touches(states(time)), closed)[0][i])

        sampled = np.linspace(times[0], times[-1], 101)
        k = int(np.argmin([less(time) for time in sampled]))
        bounds = sampled[max(k - 1, 0)], sampled[min(k + 1, 100)]
        return -float(minimize_scalar(less, bounds=bounds, options={"xatol": 1e-11}).fun)

    def total(self, y: np.ndarray) -> float:
        """Return the energy with that of contacts that have begun and not ended, and what friction took (J)."""
        touches = self.touches(y)
        sizes, _, _ = self.forces(touches, sorted(c.index for c in self.contacts if np.isnan(c.end)))
        stored = -0.5 * sizes @ np.array([touch.gap for touch in touches])
        return self.energy(y) + float(stored) + float(y[-1])


def arguments(words: list[str] | None = None) -> argparse.Namespace:
    """Read the command line, or these words of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pegs", default="0.5,0", help="x and y (m) of each")
    parser.add_argument("--slope", action="store_true", help="the tip on the slope in place of pegs")
    parser.add_argument("--stiffness", type=float, default=1e6, help="N/m of each")
    parser.add_argument("--residual", action="store_true", help="with the residual flexibility")
    parser.add_argument("--friction", type=float, default=0.0)
    parser.add_argument("--modes", type=int, default=4)
    parser.add_argument("--end", type=float, default=0.45, help="s")
    return parser.parse_args(words)


def beam_of(given: argparse.Namespace) -> ElasticBeam:
    """Return the beam that the command line asks for."""
    numbers = [] if given.slope else list(map(float, given.pegs.split(",")))
    options = {"friction": given.friction, "stiffness": given.stiffness, "residual": given.residual}
    return ElasticBeam(given.modes, pegs=list(zip(numbers[::2], numbers[1::2], strict=True)), **options)


def main() -> None:
    """Print contacts, turns of the slip and the balance of energy."""
    given = arguments()
    beam = beam_of(given)
    before, y = beam.total(beam.start()), beam.march(given.end)
    for c in beam.contacts:
        times = f"{c.start:.12f} to {c.end:.12f} s"
        print(f"{c.index}: {times}, {c.impulse:.11f} N s, at most {c.peak:.7f} N")
    for time, kind, i in beam.log:
        if kind == "turn":
            print(f"{i}: slip turns at {time:.12f} s")
    print(f"angle {y[0]:.12f} rad, friction took {y[-1]:.12f} J")
    print(f"energy {beam.total(y):.12f} J, made {beam.total(y) - before:.1e} J")


if __name__ == "__main__":
    main()

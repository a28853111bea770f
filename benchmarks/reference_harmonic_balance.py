"""Steady states of a strip with a clearance by harmonic balance, in SciPy alone.

    python benchmarks/reference_harmonic_balance.py            some minutes

For a base of 0.06 m/s^2 and for a force of 2 mN at the tip it prints least and largest deflection where the motion
repeats in each period, the fold of that branch, and where it repeats in none.

A clamped strip, 500 x 20 x 1 mm, with Rayleigh damping of 0.5 % in its first two modes; a spring without mass, 99
times as stiff as the strip at its tip, stands 1 mm from the tip on one side.  Nothing of the suite is used, and
the strip has no modes: but for the spring it is linear, and its response at the tip is the exact one of the
Euler-Bernoulli beam, harmonic by harmonic.  The spring's force is found in time (alternating frequency and time,
Cameron and Griffin 1989), the samples of the tip by Newton's method, branches over the frequency by their arc
length.  A solution is stable if its Floquet multipliers lie inside of the unit circle: of the strip in ten modes,
linear between touch-down and lift-off at the times of the solution.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm, toeplitz
from scipy.optimize import brentq

LENGTH, WIDTH, DEPTH, MODULUS, DENSITY = 0.5, 0.02, 1e-3, 210e9, 7800.0
BENDING, MASS = MODULUS * WIDTH * DEPTH**3 / 12.0, DENSITY * WIDTH * DEPTH  # N m^2, kg/m
SPRING, CLEARANCE, RATIO = 99.0 * 3.0 * BENDING / LENGTH**3, 1e-3, 0.005  # N/m, m, -
MODES = 10  # in time
SAMPLES = 512  # of a period, for a quarter of as many harmonics: deflections to 1e-5 mm
DRIVES = {"base": (0.06, 0.0), "force": (0.0, 2e-3)}  # m/s^2 of the base, N at the tip


def clamped_roots(count: int) -> np.ndarray:
    """Return the roots of cosh z cos z = -1."""
    near = (np.arange(count) + 0.5) * np.pi
    return np.array([brentq(lambda z: np.cos(z) + 1.0 / np.cosh(z), z - 0.7, z + 0.7, xtol=1e-14) for z in near])


ROOTS = clamped_roots(MODES)
RATES = ROOTS**2 * np.sqrt(BENDING / MASS) / LENGTH**2  # rad/s
ALPHA = 2.0 * RATIO * RATES[0] * RATES[1] / (RATES[0] + RATES[1])  # 1/s
BETA = 2.0 * RATIO / (RATES[0] + RATES[1])  # s


def tip(rates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the deflection of the tip at exp(i w t): of a unit force there, or acceleration of the base."""
    w = np.where(rates == 0.0, 1e-3, rates).astype(complex)  # at rest, to 1e-9
    inertia, stiff = w * w - 1j * w * ALPHA, BENDING * (1.0 + 1j * w * BETA)
    z = (MASS * inertia / stiff) ** 0.25 * LENGTH
    # all over cosh z, which overflows
    cosh, sinh = 1.0, np.tanh(z)
    over = np.exp(-z) * 2.0 / (1.0 + np.exp(-2.0 * z))
    below = over + cosh * np.cos(z)
    force = LENGTH**3 / stiff * (cosh * np.sin(z) - sinh * np.cos(z)) / (z**3 * below)
    base = -((cosh + np.cos(z) * over) / below - 1.0) / inertia
    return force, base


AT_TIP = 2.0 * (-1.0) ** np.arange(MODES) / np.sqrt(MASS * LENGTH)
SHARE = (np.sinh(ROOTS) - np.sin(ROOTS)) / (np.cosh(ROOTS) + np.cos(ROOTS)) / ROOTS  # half the mean of a mode
LEFT = LENGTH**3 / (3.0 * BENDING) - np.sum((AT_TIP / RATES) ** 2)  # m/N, static flexibility of the other modes
YIELDING = SPRING / (1.0 + SPRING * LEFT)


def _states(closed: bool) -> np.ndarray:
    """Matrix of x' = A x, x the amplitudes of MODES modes of unit mass and their rates."""
    stiffness = np.diag(RATES**2) + YIELDING * closed * np.outer(AT_TIP, AT_TIP)
    damping = ALPHA * np.eye(MODES) + BETA * np.diag(RATES**2)
    return np.block([[np.zeros((MODES, MODES)), np.eye(MODES)], [-stiffness, -damping]])


STATES = {closed: _states(closed) for closed in (False, True)}


def march(
    frequency: float, acceleration: float, force: float, periods: int, speed: float = 0.0, parts: int = SAMPLES
) -> tuple[np.ndarray, np.ndarray]:
    """From a speed (m/s) of the tip return states at whole periods, and samples of the tip (m) in the last one.

    Between touch-down and lift-off the modes and the drive are linear equations, whose steps are
    matrix exponentials; the times of touch-down and lift-off are sought.
    """
    drive = 2.0 * np.pi * frequency
    load = AT_TIP * force - acceleration * 2.0 * SHARE * np.sqrt(MASS * LENGTH)
    rates = {}
    for closed, matrix in STATES.items():
        whole = np.zeros((2 * MODES + 3, 2 * MODES + 3))
        whole[: 2 * MODES, : 2 * MODES] = matrix
        whole[MODES : 2 * MODES, 2 * MODES] = load
        whole[MODES : 2 * MODES, -1] = AT_TIP * YIELDING * CLEARANCE * closed
        whole[2 * MODES, 2 * MODES + 1], whole[2 * MODES + 1, 2 * MODES] = drive, -drive  # sine, cosine; one
        rates[closed] = whole
    step, row = 1.0 / frequency / parts, np.concatenate([AT_TIP, np.zeros(MODES + 3)])
    steps = {closed: expm(step * whole) for closed, whole in rates.items()}
    y = np.concatenate([np.zeros(2 * MODES), [0.0, 1.0, 1.0]])
    y[MODES] = speed / AT_TIP[0]
    found, tips = [], np.zeros(parts)

    def over(t: float, matrix: np.ndarray, y: np.ndarray) -> float:
        return float(row @ (expm(t * matrix) @ y) - CLEARANCE)

    closed = bool(row @ y > CLEARANCE)
    for _ in range(periods):
        for part in range(parts):
            after = steps[closed] @ y
            left = step
            while (row @ after > CLEARANCE) != closed and left > 1e-12:
                time = brentq(over, 0.0, left, (rates[closed], y), xtol=1e-15)
                y, closed, left = expm(time * rates[closed]) @ y, not closed, left - time
                after = expm(left * rates[closed]) @ y
            y, tips[part] = after, row @ after
        y[2 * MODES :] = 0.0, 1.0, 1.0
        found.append(y[: 2 * MODES].copy())
    return np.array(found), np.roll(tips, 1)


@dataclass
class Orbit:
    """A periodic motion: samples of the tip (m) over a period of the drive at `frequency` (Hz)."""

    frequency: float
    tip: np.ndarray

    @property
    def extremes(self) -> tuple[float, float]:
        """Least and largest deflection (m), between samples by a parabola."""

        def top(y: np.ndarray) -> float:
            k = int(np.argmax(y))
            before, here, after = y[k - 1], y[k], y[(k + 1) % y.size]
            return float(here + (after - before) ** 2 / (8.0 * (2.0 * here - before - after)))

        return -top(-self.tip), top(self.tip)

    @property
    def multiplier(self) -> complex:
        """The largest Floquet multiplier; with a magnitude above 1 the motion is unstable."""
        depth = self.tip - CLEARANCE
        time = 1.0 / self.frequency
        step = time / depth.size
        ends = [
            (k + depth[k] / (depth[k] - depth[(k + 1) % depth.size])) * step
            for k in range(depth.size)
            if depth[k] * depth[(k + 1) % depth.size] < 0.0
        ]
        whole, at, closed = np.eye(2 * MODES), 0.0, depth[0] > 0.0
        for end in [*ends, time]:
            whole, at, closed = expm((end - at) * STATES[closed]) @ whole, end, not closed
        found = np.linalg.eigvals(whole)
        return complex(found[np.argmax(np.abs(found))])


class Balance:
    """Harmonic balance under a drive: `acceleration` of the base (m/s^2), `force` at the tip (N), both sines."""

    def __init__(self, acceleration: float, force: float):
        self.acceleration, self.force = acceleration, force

    def linear(self, frequency: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the tip without spring (samples), and the first column of the circulant of forces."""
        orders = np.arange(SAMPLES // 2 + 1)
        kept = orders <= SAMPLES // 4
        force, base = (np.where(kept, part, 0.0) for part in tip(2.0 * np.pi * frequency * orders))
        lines = np.zeros(orders.size, complex)
        lines[1] = -0.5j * SAMPLES * (base[1] * self.acceleration + force[1] * self.force)
        return np.fft.irfft(lines, SAMPLES), np.fft.irfft(force, SAMPLES)

    def residual(self, frequency: float, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return residual and Jacobian."""
        free, column = self.linear(frequency)
        matrix, depth = toeplitz(column, column[np.r_[0, -1 : -column.size : -1]]), np.maximum(u - CLEARANCE, 0.0)
        return u - free + SPRING * matrix @ depth, np.eye(u.size) + SPRING * matrix * (depth > 0.0)

    def solve(self, frequency: float, u: np.ndarray) -> Orbit:
        """Return the orbit near some samples, by Newton's method."""
        for _ in range(60):
            r, jacobian = self.residual(frequency, u)
            if np.abs(r).max() < 1e-13:
                return Orbit(frequency, u)
            u = u - np.linalg.solve(jacobian, r)
        raise ArithmeticError(f"no orbit at {frequency} Hz")

    def settled(self, frequency: float, speed: float = 0.0, periods: int = 150) -> Orbit:
        """Return the orbit that a motion from some speed of the tip (m/s) comes to."""
        return self.solve(frequency, march(frequency, self.acceleration, self.force, periods, speed)[1])

    def branch(self, start: Orbit, step: float, least: float = 1e-6) -> Iterator[Orbit]:
        """Yield orbits from `start` to higher frequencies, at most `step` (Hz, mm rms of the tip) apart."""
        scale, h = 1e3 / np.sqrt(start.tip.size), 1e-6
        f, u, df, du, size = start.frequency, start.tip, 1.0, np.zeros_like(start.tip), step
        yield start
        while True:
            r, jacobian = self.residual(f, u)
            v = -np.linalg.solve(jacobian, (self.residual(f + h, u)[0] - r) / h)
            tangent = np.array([1.0, *v]) / np.sqrt(1.0 + scale**2 * v @ v)
            turned = 1.0 if tangent[0] * df + scale**2 * tangent[1:] @ du >= 0.0 else -1.0
            df, du = turned * tangent[0], turned * tangent[1:]
            while (found := self._correct(f, u, df, du, size, scale)) is None:
                size *= 0.5
                if size < least:
                    return
            f, u = found
            size = min(1.5 * size, step)
            yield Orbit(f, u)

    def _correct(
        self, f0: float, u0: np.ndarray, df: float, du: np.ndarray, size: float, scale: float
    ) -> tuple[float, np.ndarray] | None:
        """Return frequency and samples so far along a tangent, by Newton's method, whose steps are halved."""
        h = 1e-6
        f, u = f0 + size * df, u0 + size * du
        for _ in range(25):
            r, jacobian = self.residual(f, u)
            c = df * (f - f0) + scale**2 * du @ (u - u0) - size
            if np.abs(r).max() < 1e-12 and abs(c) < 1e-9:
                return f, u
            slope = (self.residual(f + h, u)[0] - r) / h
            a, b = np.linalg.solve(jacobian, np.stack([r, slope], axis=1)).T
            change = (-c + scale**2 * du @ a) / (df - scale**2 * du @ b)
            part, now = 1.0, max(np.abs(r).max(), 1e-3 * abs(c))
            while part > 0.01:
                ft, ut = f + part * change, u - part * (a + b * change)
                ct = df * (ft - f0) + scale**2 * du @ (ut - u0) - size
                if max(np.abs(self.residual(ft, ut)[0]).max(), 1e-3 * abs(ct)) < now:
                    break
                part *= 0.5
            f, u = ft, ut
        return None

    def fold(self, start: Orbit) -> float:
        """Return the frequency (Hz), to 1e-4 of it, at which the branch from `start` turns back.

        Raises ArithmeticError if Newton's method finds no way on before, where one more impact begins to graze.
        """
        before = start
        for orbit in self.branch(start, 0.05):
            if orbit.frequency < before.frequency:
                return before.frequency
            before = orbit
        raise ArithmeticError("the branch does not turn back")


def returns(frequency: float, drive: tuple[float, float], longest: int = 8, periods: int = 600) -> float:
    """Return how far states are from those up to `longest` periods before, at least, over the size of the motion.

    Over the last 64 periods: of a motion that repeats it is 0.
    """
    states = march(frequency, *drive, periods)[0][-64 - longest :, :MODES] @ AT_TIP
    apart = [np.abs(states[p:] - states[:-p]).max() for p in range(1, longest + 1)]
    return float(min(apart) / np.ptp(states))


#: speed of the tip (m/s) from which the strip comes to a motion with impacts, by the frequency (Hz)
TOUCHING = {"base": {3.2: 0.0, 4.2: 0.04, 4.4: -0.04}, "force": {3.2: 0.0, 4.2: 0.04, 4.4: 0.04}}


def response(name: str, frequency: float) -> list[float]:
    """Least and largest deflection (mm) under a drive."""
    return [1e3 * end for end in Balance(*DRIVES[name]).settled(frequency, TOUCHING[name][frequency]).extremes]


def fold(name: str) -> float:
    """Frequency (Hz) at which the branch with impacts turns back, upwards from 4.4 Hz."""
    balance = Balance(*DRIVES[name])
    return balance.fold(balance.settled(4.4, TOUCHING[name][4.4]))


if __name__ == "__main__":
    for name, drive in DRIVES.items():
        for frequency in TOUCHING[name]:
            print(name, f"{frequency:g} Hz: {response(name, frequency)} mm", flush=True)
        print(name, f"the fold is at {fold(name):.6g} Hz", flush=True)
        for frequency in (3.8, 4.0):
            print(
                name, f"{frequency:g} Hz: the nearest return is {returns(frequency, drive):.2g} away", flush=True
            )

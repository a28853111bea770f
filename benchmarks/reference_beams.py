"""Reference values of beams by other means than the suite's: series, closed forms and elements in 30 to 50 digits.

    python benchmarks/reference_beams.py [ID ...]     print the values of these entries (default: all)

An ID is that of an entry of `validation/reference_values.toml`, which says what its numbers are.  Nothing of the
suite is used: mpmath (extra `test`), NumPy and SciPy only.  All together take about two minutes.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import mpmath as mp
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

ENTRIES: dict[str, Callable[[], Any]] = {}
BENDING, MASS, SPEED = 541.27, 0.86874, 3.77  # N m², kg/m, m/s of a beam of 1 m


def entry(name: str, *arguments: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Add a function with these arguments to the entries."""

    def add(function: Callable[..., Any]) -> Callable[..., Any]:
        ENTRIES[name] = lambda: function(*arguments)
        return function

    return add


@entry("1.1", True)
@entry("1.2", False)
def roots(clamped: bool, count: int = 10) -> list[mp.mpf]:
    """Return the roots of cos b cosh b = -1, or of tan b = tanh b."""
    with mp.workdps(40):
        if clamped:
            starts = [(k - 0.5) * mp.pi + (0.3 if k == 1 else 0.0) for k in range(1, count + 1)]
            return [mp.findroot(lambda b: mp.cos(b) + 1 / mp.cosh(b), start) for start in starts]
        starts = [(k + 0.25) * mp.pi for k in range(1, count + 1)]
        return [mp.findroot(lambda b: mp.sin(b) - mp.cos(b) * mp.tanh(b), start) for start in starts]


def hermite(elements: int, fixed: int) -> tuple[mp.matrix, mp.matrix]:
    """Return K and consistent M of a uniform unit beam; `fixed` coordinates of its root are left out."""
    h = mp.mpf(1) / elements
    k = mp.matrix([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2]]) / h**3
    m = mp.matrix([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2]]) * h / 420
    n = 2 * elements + 2
    K, M = mp.zeros(n), mp.zeros(n)
    for e in range(elements):
        for whole, part, signs in ((K, k, (1, -1)), (M, m, (1, -1))):
            for i in range(2):
                for j in range(4):
                    whole[2 * e + i, 2 * e + j] += part[i, j]
                    # the other end is the mirror image: deflections keep their sign, slopes change it
                    a, b = (2, 3)[i], (2, 3, 0, 1)[j]
                    whole[2 * e + a, 2 * e + b] += part[i, j] * signs[i] * signs[j % 2]
    return K[fixed:, fixed:], M[fixed:, fixed:]


@entry("1.4-c4", 4, True)
@entry("1.4-c8", 8, True)
@entry("1.4-c16", 16, True)
@entry("1.4-c32", 32, True)
@entry("1.4-h8", 8, False)
@entry("1.4-h16", 16, False)
def element_errors(elements: int, clamped: bool) -> list[mp.mpf]:
    """Return relative errors of the first three elastic frequencies of Hermite elements, in 40 digits."""
    with mp.workdps(40):
        exact = [b**2 for b in roots(clamped, 3)]
        K, M = hermite(elements, 2 if clamped else 1)
        stiff, mass = (np.array(A.tolist(), dtype=float) for A in (K, M))
        values, vectors = np.linalg.eig(np.linalg.solve(mass, stiff))
        order = np.argsort(values.real)[0 if clamped else 1 :][:3]
        found = []
        for k, wanted in zip(order, exact, strict=True):
            x = mp.matrix(vectors[:, k].real.tolist())
            shifted = K - mp.mpf(values[k].real) * M  # regular in 40 digits, as the shift has but 16
            for _ in range(3):
                x = mp.lu_solve(shifted, M * x)
                x /= mp.norm(x)
            square = (x.T * K * x)[0] / (x.T * M * x)[0]
            found.append(mp.sqrt(square) / wanted - 1)
        return found


def spinning(spin: float, hub: float, clamped: bool, chord: bool, near: list[float]) -> list[mp.mpf]:
    """Return frequencies of a spinning unit beam next to those given, by its power series in 50 digits.

    w'''' - ((spin²/2) ((1 - x²) + 2 hub (1 - x)) w')' - (frequency² + spin² if chord) w = 0.
    """
    with mp.workdps(50):
        s2, d = mp.mpf(spin) ** 2, mp.mpf(hub)
        a = [s2 / 2 * (1 + 2 * d), -s2 * d, -s2 / 2]  # axial force by powers of x

        def end(frequency: mp.mpf, start: int) -> tuple[mp.mpf, mp.mpf]:
            square = frequency**2 + (s2 if chord else 0)
            c = [mp.mpf(0)] * 4
            c[start] = mp.mpf(1)
            for n in range(140):
                pulled = sum(a[k] * (n + 2 - k) * c[n + 2 - k] for k in range(3) if n + 2 - k > 0) * (n + 1)
                c.append((pulled + square * c[n]) / ((n + 4) * (n + 3) * (n + 2) * (n + 1)))
            moment = sum(n * (n - 1) * value for n, value in enumerate(c))
            return moment, sum(n * (n - 1) * (n - 2) * value for n, value in enumerate(c))

        def determinant(frequency: mp.mpf) -> mp.mpf:
            one, two = end(frequency, 2 if clamped else 1), end(frequency, 3)
            return one[0] * two[1] - one[1] * two[0]

        return [mp.findroot(determinant, (value * (1 - 1e-4), value * (1 + 1e-4))) for value in near]


def cantilever(axial: float) -> mp.mpf:
    """Return the tip deflection over q L⁴/(8 EI) of a cantilever under its weight, compressed by axial EI/L³."""
    with mp.workdps(40):

        def series(second: int, third: int, load: int) -> tuple[mp.mpf, mp.mpf, mp.mpf]:
            c = [mp.mpf(0), mp.mpf(0), mp.mpf(second), mp.mpf(third)]
            for n in range(120):  # w'''' + (axial (1 - x) w')' = load
                pushed = axial * (n + 1) * ((n + 2) * c[n + 2] - (n + 1) * c[n + 1])
                c.append(((load if n == 0 else 0) - pushed) / ((n + 4) * (n + 3) * (n + 2) * (n + 1)))
            third_derivative = sum(n * (n - 1) * (n - 2) * v for n, v in enumerate(c))
            return sum(c), sum(n * (n - 1) * v for n, v in enumerate(c)), third_derivative

        ones, loaded = (series(1, 0, 0), series(0, 1, 0)), series(0, 0, 1)
        ends = mp.matrix([[one[k] for one in ones] for k in (1, 2)])
        amounts = mp.lu_solve(ends, mp.matrix([-loaded[1], -loaded[2]]))
        return 8 * (loaded[0] + sum(a * one[0] for a, one in zip(amounts, ones, strict=True)))


@entry("7c")
def heavy_cantilever() -> dict[str, mp.mpf]:
    """Return the amplification by axial load."""
    return {name: cantilever(float(name)) for name in ("1", "4", "-4", "7")}


@entry("7c-inclined")
def inclined_cantilever() -> dict[str, mp.mpf]:
    """Return the same of a beam at 45 degrees up, which its weight compresses, and down."""
    axial = MASS * 9.8 * np.sin(np.pi / 4) / BENDING
    return {"45": cantilever(axial), "-45": cantilever(-axial)}


def clamped_modes(count: int, length: float, mass: float, bending: float) -> dict[str, np.ndarray]:
    """Return M, K, C, S and the tip of clamped-free eigenfunctions, by Gauss quadrature."""
    x, w = np.polynomial.legendre.leggauss(400)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    f, df, tip, b = [], [], [], [float(root) for root in roots(True, count)]
    for root in b:
        s = float((mp.cosh(root) + mp.cos(root)) / (mp.sinh(root) + mp.sin(root)))
        rest = (np.exp(-root) + np.cos(root) - np.sin(root)) / (np.sinh(root) + np.sin(root))  # s - 1

        def grow(x: np.ndarray, root: float = root, rest: float = rest) -> np.ndarray:
            return np.exp(-root * x) - rest * np.sinh(root * x)  # cosh - s sinh

        f.append(grow(x) - np.cos(root * x) + s * np.sin(root * x))
        df.append(root * (-np.exp(-root * x) - rest * np.cosh(root * x) + np.sin(root * x) + s * np.cos(root * x)))
        one = np.ones(1)
        tip.append((grow(one) - np.cos(root) + s * np.sin(root))[0])
    values, slopes = np.array(f).T, np.array(df).T / length
    weight = mass * length * w
    return {
        "M": (values.T * weight) @ values,
        "K": np.diag([bending / length**3 * root**4 for root in b]),
        "C": (slopes.T * (weight * 0.5 * length**2 * (1.0 - x**2))) @ slopes,
        "S": (weight * length * x) @ values,
        "tip": np.array(tip),
    }


def spin_up(modes: int) -> Callable[[np.ndarray], np.ndarray]:
    """Return the tip deflection over time of Simo and Vu-Quoc's spin-up in first-order equations (DOP853)."""
    o = clamped_modes(modes, 10.0, 1.2, 1.4e4)
    inverse = np.linalg.inv(o["M"])
    stiff, soft, push = inverse @ o["K"], inverse @ (o["C"] - o["M"]), inverse @ o["S"]

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        turn = 2.0 * np.pi * t / 15.0
        spin = 0.4 * (t - 7.5 / np.pi * np.sin(turn)) if t < 15.0 else 6.0
        growth = 0.4 * (1.0 - np.cos(turn)) if t < 15.0 else 0.0
        B = y[:modes]
        return np.concatenate([y[modes:], -stiff @ B - spin**2 * soft @ B - push * growth])

    first = solve_ivp(rate, (0, 15), np.zeros(2 * modes), "DOP853", rtol=1e-11, atol=1e-13, dense_output=True)
    last = solve_ivp(rate, (15, 20), first.y[:, -1], "DOP853", rtol=1e-11, atol=1e-13, dense_output=True)
    return lambda t: (
        o["tip"] @ np.where(t <= 15.0, first.sol(np.minimum(t, 15.0)), last.sol(np.maximum(t, 15.0)))[:modes]
    )


def smallest(tip: Callable[[np.ndarray], np.ndarray]) -> tuple[float, float]:
    """Return the smallest deflection (m) before 15 s and its time (s)."""
    times = np.linspace(5.0, 9.0, 4001)
    near = times[int(np.argmin(tip(times)))]
    step = 1e-4
    time = brentq(lambda t: float(np.diff(tip(np.array([t - step, t + step])))[0]), near - 2e-3, near + 2e-3)
    return float(tip(np.array([time]))[0]), float(time)


@entry("3-SVQ-min")
def spin_up_minimum() -> dict[str, float]:
    """Return the minimum of twelve modes and its time."""
    return dict(zip(("w_min", "t"), smallest(spin_up(12)), strict=True))


@entry("3-SVQ-min-modes")
def spin_up_minima() -> dict[int, float]:
    """Return the minimum by number of modes."""
    return {modes: smallest(spin_up(modes))[0] for modes in (1, 2, 3, 4, 6, 8, 12)}


@entry("3-SVQ-amp")
def spin_up_amplitude() -> float:
    """Return the largest deflection after 15 s, twelve modes."""
    return float(np.abs(spin_up(12)(np.linspace(15.0, 20.0, 50_001)[1:])).max())


@entry("3-SVQ-table")
def spin_up_table() -> dict[float, float]:
    """Return deflections at whole seconds, and at 7.5 s."""
    times = np.array([*range(1, 8), 7.5, *range(8, 19), 20], dtype=float)
    return dict(zip(times.tolist(), spin_up(12)(times).tolist(), strict=True))


@entry("5c")
def tip_mass() -> dict[str, mp.mpf]:
    """Return the effective mass of the end of a long mesh over m h."""
    with mp.workdps(30):
        elements = 32
        _, M = hermite(elements, 1)
        unit = mp.zeros(M.rows, 1)
        unit[M.rows - 2] = 1
        return {"tip": elements / mp.lu_solve(M, unit)[M.rows - 2]}


@entry("5e")
def spring_peak() -> dict[str, mp.mpf]:
    """Return the largest value of f(x) = x E_{3/2,2}(-x^(3/2)) and its place."""
    with mp.workdps(30):

        def f(x: mp.mpf) -> mp.mpf:
            z = -(x ** mp.mpf(1.5))
            return x * mp.nsum(lambda k: z**k / mp.gamma(1.5 * k + 2), [0, 80], method="direct")

        place = mp.findroot(lambda x: mp.diff(f, x), 1.6)
        return {"x_peak": place, "f_peak": f(place)}


def bound_modes(squares: np.ndarray, pull: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the eigenvalues w of D + p p^T with D = diag(squares), pull = p², and |(D - w)^-1 p|² of each.

    Each lies between two squares, the last one above all: found is what it has above the lower one, to all digits.
    """
    above, lengths = np.empty_like(squares), np.empty_like(squares)
    for i, room in enumerate(np.append(np.diff(squares), np.sum(pull))):
        far = squares - squares[i]

        def secular(x: float, far: np.ndarray = far) -> float:
            return float(x * (1.0 + np.sum(pull / (far - x))))

        above[i] = brentq(secular, 1e-14 * room, (1.0 - 1e-14) * room, rtol=1e-15)
        lengths[i] = np.sum(pull / (far - above[i]) ** 2)
    return squares + above, lengths


@entry("5f")
def spring_contact(modes: int = 400) -> dict[str, tuple[float, ...]]:
    """Return peak, end, impulse and rotation after of a hinged beam that turns onto a spring.

    In contact it is linear: rigid rotation and elastic modes with the spring, exact in time by eigenvectors.
    These come from the secular equation: where eigenvalues go from 1e5 to 1e15 a dense solver leaves the lowest
    six digits, and the next ones differ from one processor to the other.
    """
    b = (np.arange(1, modes + 1) + 0.25) * np.pi
    b[:10] = [float(root) for root in roots(False, 10)]
    # at the end, squared, of unit mass: sqrt(3) x, sqrt(2/(1 - r²)) (sin bx + r sinh bx) with r = sin b/sinh b
    ratio = np.sin(b) / np.sinh(np.minimum(b, 700.0))
    shape = np.concatenate([[3.0], 8.0 * np.sin(b) ** 2 / (1.0 - ratio**2)])
    squares = np.concatenate([[0.0], BENDING / MASS * b**4])
    found = {}
    for name in ("1e5", "1e6"):
        stiffness = float(name)
        values, lengths = bound_modes(squares, stiffness / MASS * shape)
        frequencies, amount = np.sqrt(values), SPEED / (values * lengths)

        def force(t: float, a: np.ndarray = amount, w: np.ndarray = frequencies, k: float = stiffness) -> float:
            return float(k * (a / w) @ np.sin(w * t))

        times = np.linspace(0.0, 0.01, 10_001)[1:]
        curve = np.array([force(t) for t in times])
        last = int(np.argmax(curve < 0.0))
        top = int(np.argmax(curve[:last]))
        end = brentq(force, times[last - 1], times[last], xtol=1e-14)
        peak = max(map(force, np.linspace(times[top] - 2e-6, times[top] + 2e-6, 401)))
        impulse = float(stiffness * (amount / values) @ (1.0 - np.cos(frequencies * end)))
        found[name] = (peak, end, impulse, SPEED - 3.0 * impulse / MASS)
    return found


def spinning_entries() -> None:
    """Add the spinning beams, next to the frequencies of the table."""
    from oblique_impact.validation.reference_values import VALUES

    for item, planes in VALUES.items():
        if item.startswith("2-"):
            _, root, hub, spin = item.split("-")

            def all_of(
                planes: Any = planes, root: str = root, hub: str = hub, spin: str = spin
            ) -> dict[str, list[Any]]:
                return {
                    plane: [
                        # a hinged beam that spins swings out of the plane as a rigid one, and drifts in it
                        mp.mpf(value)
                        if root == "h" and k == 0
                        else spinning(float(spin[3:]), float(hub[1:]), root == "c", plane == "chord", [value])[0]
                        for k, value in enumerate(values)
                    ]
                    for plane, values in planes.items()
                }

            ENTRIES[item] = all_of


def shown(value: Any) -> Any:
    """Return a value with 15 digits for reading."""
    if isinstance(value, dict):
        return {key: shown(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [shown(item) for item in value]
    return float(value)


def main() -> None:
    """Print what is asked for."""
    spinning_entries()
    for name in sys.argv[1:] or ENTRIES:
        if name not in ENTRIES:
            raise SystemExit(f"{name}: should be one of {', '.join(ENTRIES)}")
        print(name, shown(ENTRIES[name]()), flush=True)


if __name__ == "__main__":
    main()

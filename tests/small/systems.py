"""What the tests in this folder share: schemes, scales, friction laws, motions with friction, orders."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from oblique_impact import History, Outcome
from oblique_impact.contact.friction import Coulomb, FrictionCurve, Frictionless, ModifiedCoulomb
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.marching.event import EventScheme
from oblique_impact.marching.fixed_step import FixedStepScheme
from oblique_impact.marching.generalized_alpha import GeneralizedAlphaScheme
from oblique_impact.marching.time_stepping import TimeSteppingScheme

Array = NDArray[np.float64]

GRAVITY = 9.8  # m/s^2
TOLERANCE = 1e-10  # of the event scheme
#: what the event scheme may be away from a closed form: a few times its tolerance
EVENT_ERROR = 1e-9
#: exact in exact arithmetic: what some thousand steps leave by rounding
ROUNDING = 1e-11
RIGID = ("event", "fixed-step")  # schemes that take rigid stops with all laws
SCHEMES = (*RIGID, "generalized-alpha")  # elastic ones


def scheme_of(name: str, step: float, rho: float = 0.8) -> Any:
    """Return a new scheme whose steps in flight and in contact are `step` (s)."""
    if name == "event":
        return EventScheme(TOLERANCE)
    if name == "fixed-step":
        return FixedStepScheme(step, step)
    if name == "time-stepping":
        return TimeSteppingScheme(step, step, np.inf, 1e-12)
    return GeneralizedAlphaScheme(step, step, rho)


class Ground(NamedTuple):
    """A stop that carries a weight; a scheme that takes elastic ones alone has one that is pressed in by it."""

    contact_law: ElasticStop | None
    gap: float  # m, where it carries the weight


def ground_of(scheme: str, weight: float, stiffness: float = 1e4) -> Ground:
    """Return the ground of a scheme under a weight (N): rigid, or of a stiffness (N/m)."""
    rigid = scheme != "generalized-alpha"
    return Ground(None, 0.0) if rigid else Ground(ElasticStop(stiffness), -weight / stiffness)


# --- scales


class Scale(NamedTuple):
    """Factors of length, time and mass by which a whole problem is scaled."""

    length: float = 1.0
    time: float = 1.0
    mass: float = 1.0

    @property
    def speed(self) -> float:
        return self.length / self.time

    @property
    def acceleration(self) -> float:
        return self.length / self.time**2

    @property
    def stiffness(self) -> float:
        return self.mass / self.time**2

    @property
    def force(self) -> float:
        return self.mass * self.acceleration


UNSCALED = Scale()


# --- friction laws and motions with them


class Law(NamedTuple):
    """A friction law by numbers: coefficients over slip speed (m/s), linear between points; static or None."""

    make: Callable[[Scale], Any]
    points: tuple[tuple[float, float], ...]
    static: float | None = None

    def at(self, speed: float) -> float:
        """Coefficient of friction at a slip speed (m/s)."""
        return float(np.interp(speed, *zip(*self.points, strict=True)))

    @property
    def steepest(self) -> float:
        """Largest slope of the coefficient over the speed (s/m)."""
        speeds, values = zip(*self.points, strict=True)
        return float(np.abs(np.diff(values) / np.diff(speeds)).max()) if len(speeds) > 1 else 0.0

    @property
    def jump(self) -> float:
        """Twice the coefficient at rest: what friction jumps by where slip reverses."""
        return 2.0 * self.points[0][1]


def _curve(points: tuple[tuple[float, float], ...], static: float | None) -> Law:
    def make(scale: Scale) -> FrictionCurve:
        return FrictionCurve(tuple((v * scale.speed, mu) for v, mu in points), static)

    return Law(make, points, static)


def coulomb(mu: float) -> Law:
    return Law(lambda scale: Coulomb(mu, mu), ((0.0, mu),), mu)


FRICTIONLESS = Law(lambda scale: Frictionless(), ((0.0, 0.0),))
MODIFIED = Law(
    lambda scale: ModifiedCoulomb(0.3, 0.1 * scale.speed, 0.5 * scale.speed), ((0.0, 0.0), (0.1, 0.0), (0.5, 0.3))
)
HOLDING_CURVE = _curve(((0.0, 0.4), (1.0, 0.2)), 0.4)
YIELDING_CURVE = _curve(((0.0, 0.25), (2.0, 0.15)), 0.25)


class Passage(NamedTuple):
    """A motion with friction at an instant: time (s), way (m), speed (m/s), and when it turned or stopped (s)."""

    time: float
    way: float
    speed: float
    turns: tuple[float, ...] = ()


def slide(end: float, speed: float, drive: float, normal: float, law: Law) -> Passage:
    """Way and speed at `end` of v' = drive - mu(|v|) sign(v) normal, x(0) = 0, v(0) = speed, by SciPy to 1e-12.

    At v = 0 it rests for good if |drive| <= static normal, and goes on with the direction of `drive` otherwise.
    """
    time, way, turns = 0.0, 0.0, []
    while time < end:
        if speed == 0.0 and law.static is not None and abs(drive) <= law.static * normal:
            break
        side = np.sign(speed or drive)

        def rates(t: float, y: Array, side: float = side) -> tuple[float, float]:
            return y[1], drive - law.at(side * y[1]) * side * normal

        def stops(t: float, y: Array, side: float = side) -> float:
            return side * y[1]

        stops.terminal, stops.direction = True, -1
        part = solve_ivp(rates, (time, end), (way, speed), "DOP853", rtol=1e-13, atol=1e-15, events=stops)
        time, (way, speed) = part.t[-1], part.y[:, -1]
        if part.status == 1:
            speed = 0.0
            turns.append(time)
    return Passage(time, way, speed, tuple(turns))


# --- what is read off a history


def kinds_of(history: History) -> list[str]:
    """Return the kinds of the events in order of time, without the touch of a start in contact."""
    return [event.kind.value for event in history.events if event.time > 0.0]


def times_of(history: History, *kinds: str) -> Array:
    """Times (s) of the events after the start, of all kinds or the named ones."""
    chosen = [e.time for e in history.events if e.time > 0.0 and (not kinds or e.kind.value in kinds)]
    return np.array(chosen, dtype=float)


def just_after(history: History, name: str, time: float) -> Any:
    """Value of a variable on the right side of the jump at `time`."""
    index = int(np.searchsorted(history["time"].values, time, side="right"))
    return history[name].values[index]


def last(history: History, name: str) -> Any:
    """Value of a variable at the end."""
    return history[name].values[-1]


def completed(history: History) -> History:
    """Return the history of a run that has to reach its end."""
    assert history.outcome is Outcome.COMPLETED
    return history


def assert_order(
    steps: Any, errors: Any, band: tuple[float, float], ceilings: Any, rounding: float = ROUNDING
) -> None:
    """Errors stay below their ceilings and fall with a slope inside of the band; exact results have no slope."""
    steps, errors = np.asarray(steps, dtype=float), np.abs(np.asarray(errors, dtype=float))
    assert np.all(errors <= ceilings), f"errors {errors} above {ceilings}"
    if errors.max() <= rounding:
        return
    slope = np.polyfit(np.log(steps), np.log(np.maximum(errors, 1e-300)), 1)[0]
    assert band[0] <= slope <= band[1], f"errors {errors} fall with a slope of {slope:.2f}, not within {band}"

"""Base motions: prescribed rotations of a driven root.

`BaseMotion`               the contract, for user-defined motions too
`ConstantSpeed`, `SpinUp`  the built-in motions
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import astuple, dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from oblique_impact.errors import InputError
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.laws import Law, compiled_law

if TYPE_CHECKING:
    from oblique_impact.scenario.sections import RootSection

#: short windows of the run in which derivatives are checked, their length over its duration, relative tolerance
_WINDOWS, _WINDOW, _ACCURACY = 32, 1e-4, 1e-6


@jitable
def drive_acceleration(law: Law | None, spin_rate: float, spin_up_time: float, t: float) -> float:
    """Angular acceleration (rad/s^2) of a driven root at t (s); the compiler drops one of the two branches."""
    if law is None:
        return spin_up_acceleration(t, spin_rate, spin_up_time)
    return law(t)


@jitable
def spin_up_acceleration(t: float, spin_rate: float, spin_up_time: float) -> float:
    """Angular acceleration (rad/s^2) of a spin-up (Simo and Vu-Quoc 1986); 0 at its end and after it."""
    if t >= spin_up_time:
        return 0.0
    return spin_rate / spin_up_time * (1.0 - math.cos(2.0 * math.pi * t / spin_up_time))


@jitable
def drive_angle(law: Law | None, spin_rate: float, spin_up_time: float, t: float) -> float:
    """Angle (rad) since the start of a driven root at t (s); the compiler drops one of the two branches."""
    if law is None:
        return spin_up_angle(t, spin_rate, spin_up_time)
    return law(t)


@jitable
def spin_up_angle(t: float, spin_rate: float, spin_up_time: float) -> float:
    """Angle (rad) of a spin-up."""
    if t >= spin_up_time:
        return spin_rate * (t - 0.5 * spin_up_time)
    lag = spin_up_time / (2.0 * math.pi)
    turned = 0.5 * t * t + lag * lag * (math.cos(2.0 * math.pi * t / spin_up_time) - 1.0)
    return spin_rate / spin_up_time * turned


class Turn(NamedTuple):
    """Angle since the start (rad), angular velocity (rad/s) and acceleration (rad/s^2) of a driven root."""

    angle: float
    speed: float
    acceleration: float


class BaseMotion(ABC):
    """A prescribed rotation of the root: a dataclass whose fields are numbers, with one function of time.

    ``turn(t, *fields)`` returns angle since the start, speed and acceleration.  It is compiled by numba: numbers,
    ``math`` and ``numpy`` functions of numbers, conditions and loops.

    Examples
    --------
    >>> @dataclass(frozen=True)
    ... class Swing(BaseMotion):
    ...     amplitude: float = 0.1  # rad
    ...     frequency: float = 5.0  # Hz
    ...
    ...     @staticmethod
    ...     def turn(t, amplitude, frequency):
    ...         w = 2.0 * math.pi * frequency
    ...         return (
    ...             amplitude * (1.0 - math.cos(w * t)),
    ...             amplitude * w * math.sin(w * t),
    ...             amplitude * w**2 * math.cos(w * t),
    ...         )
    """

    # added by the dataclass decorator
    __dataclass_fields__: ClassVar[dict[str, Any]]

    @staticmethod
    @abstractmethod
    def turn(t: float, *parameters: float) -> tuple[float, float, float]:
        """Return angle since the start (rad), speed (rad/s) and acceleration (rad/s^2) at t (s)."""

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times (s) at which the acceleration is not smooth; steps end there."""
        return ()

    def at(self, t: float) -> Turn:
        """Return the motion at t (s)."""
        return Turn(*map(float, self.turn(t, *astuple(self))))

    @property
    def drive(self) -> Law | None:
        """The acceleration as kernels call it, None of a spin-up; raises InputError if it cannot be compiled."""
        return compiled_law(type(self).turn, 1, tuple(map(float, astuple(self))), entry=2)

    @property
    def drive_angle(self) -> Law | None:
        """The angle as kernels call it, None of a spin-up; raises InputError if it cannot be compiled."""
        return (
            None if self.drive is None else compiled_law(type(self).turn, 1, tuple(map(float, astuple(self))), 0)
        )

    def check(self, end_time: float) -> None:
        """Raise InputError if this cannot be compiled, or the speed or acceleration is not the derivative."""
        _, name = self.drive, type(self).__name__
        if self.at(0.0).angle != 0.0:
            raise InputError(f"{name}: the angle at t = 0 is {self.at(0.0).angle:g}, should be 0")
        points, weights = np.polynomial.legendre.leggauss(10)
        length = _WINDOW * end_time
        for start in (np.arange(_WINDOWS) + 0.5) / _WINDOWS * (end_time - length):
            if any(start <= t <= start + length for t in self.breakpoints):
                continue
            inside = np.array([self.at(t) for t in start + 0.5 * length * (1.0 + points)])
            if not np.all(np.isfinite(inside)):
                raise InputError(f"{name}: is not finite at t = {start:g}")
            before, after = np.array(self.at(start))[:2], np.array(self.at(start + length))[:2]
            integrals = 0.5 * length * weights @ inside[:, 1:]
            scale = length * np.abs(inside[:, 1:]).max(axis=0) + 1e-8 * (1.0 + np.abs(after))
            wrong = np.abs(after - before - integrals) > _ACCURACY * scale
            if np.any(wrong):
                rate, of = ("speed", "angle") if wrong[0] else ("acceleration", "speed")
                raise InputError(f"{name}: the {rate} is not the derivative of the {of} at t = {start:g}")


@dataclass(frozen=True)
class ConstantSpeed(BaseMotion):
    """A root that turns at a constant rate (rad/s), or is held at 0."""

    spin_rate: float = 0.0

    @staticmethod
    def turn(t: float, spin_rate: float) -> tuple[float, float, float]:  # type: ignore[override]  # noqa: D102
        return spin_rate * t, spin_rate, 0.0

    @property
    def drive(self) -> None:
        """None: kernels have a spin-up, here of 0."""
        return


@dataclass(frozen=True)
class SpinUp(BaseMotion):
    """Speed (w/T) (t - T/(2 pi) sin(2 pi t/T)) up to T (Simo and Vu-Quoc 1986), then w (rad/s)."""

    spin_rate: float
    spin_up_time: float  # s

    @staticmethod
    def turn(  # type: ignore[override]  # noqa: D102
        t: float, spin_rate: float, spin_up_time: float
    ) -> tuple[float, float, float]:
        if t >= spin_up_time:
            return spin_rate * (t - 0.5 * spin_up_time), spin_rate, 0.0
        lag = spin_up_time / (2.0 * math.pi)
        speed = spin_rate / spin_up_time * (t - lag * math.sin(t / lag))
        acceleration = spin_up_acceleration(t, spin_rate, spin_up_time)
        return spin_up_angle(t, spin_rate, spin_up_time), speed, acceleration

    @property
    def drive(self) -> None:
        """None: kernels have it."""
        return

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """End of the spin-up (s)."""
        return (self.spin_up_time,)


def base_motion_of(root: RootSection) -> BaseMotion:
    """Return the built-in motion that the section of a scenario names."""
    if root.profile == "constant-speed":
        return ConstantSpeed(root.spin_rate)
    return SpinUp(root.spin_rate, root.spin_up_time) if root.profile == "spin-up" else ConstantSpeed()

"""Base motions of one's own: how a driven root turns.

The built-in ones (hold, constant speed, spin-up) are part of the compiled frame
(:func:`~oblique_impact.beam.floating_frame.drive`); this is the contract for others.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import astuple
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np

from oblique_impact.errors import InputError
from oblique_impact.kernels.pointers import Pointer

_WINDOWS, _WINDOW = 32, 1e-4  # how many short windows of the run are looked at, and their length in its duration
_ACCURACY = 1e-6


class Turn(NamedTuple):
    """Angle since the start (rad), angular velocity (rad/s) and acceleration (rad/s^2) of a driven root."""

    angle: float
    speed: float
    acceleration: float


class BaseMotion(ABC):
    """How a driven root turns: a dataclass whose fields are numbers, with one function of time.

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

    #: what the dataclass decorator adds
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
        return Turn(*map(float, self.turn(t, *self._numbers)))

    @cached_property
    def pointer(self) -> Pointer:
        """The compiled acceleration of the root; raises InputError if it cannot be compiled."""
        return Pointer(type(self).turn, 1, self._numbers, entry=2)

    def check(self, end_time: float) -> None:
        """Raise InputError if this cannot be compiled, or its parts do not fit together before `end_time` (s)."""
        _ = self.pointer
        if self.at(0.0).angle != 0.0:
            raise InputError(f"{type(self).__name__}: the angle at t = 0 is {self.at(0.0).angle:g}, should be 0")
        points, weights = np.polynomial.legendre.leggauss(10)
        length = _WINDOW * end_time
        for k in range(_WINDOWS):
            start = (k + 0.5) / _WINDOWS * (end_time - length)
            if any(start <= t <= start + length for t in self.breakpoints):
                continue
            inside = np.array([self.at(start + 0.5 * length * (1.0 + x)) for x in points])
            if not np.all(np.isfinite(inside)):
                raise InputError(f"{type(self).__name__}: is not finite at t = {start:g}")
            before, after = np.array(self.at(start)), np.array(self.at(start + length))
            gained = after[:2] - before[:2]
            integrals = 0.5 * length * weights @ inside[:, 1:]
            scale = length * np.abs(inside[:, 1:]).max(axis=0) + 1e-8 * (1.0 + np.abs(after[:2]))
            wrong = np.abs(gained - integrals) > _ACCURACY * scale
            if np.any(wrong):
                name, of = ("speed", "angle") if wrong[0] else ("acceleration", "speed")
                words = f"the {name} is not the derivative of the {of}"
                raise InputError(f"{type(self).__name__}: {words} at t = {start:g}")

    @property
    def _numbers(self) -> tuple[float, ...]:
        return astuple(self)

"""User-defined laws, a base motion and an integrator; pyproject.toml tells oblique-impact their names."""

from __future__ import annotations

import math
from dataclasses import dataclass

from oblique_impact.beam.base_motion import BaseMotion
from oblique_impact.contact.friction import FrictionCurve
from oblique_impact.contact.impacts import ImpactLaw, Impulse, newton_impulse
from oblique_impact.contact.state import Instant
from oblique_impact.contact.stops import ContactLaw
from oblique_impact.marching.explicit import ExplicitScheme


class Stribeck(FrictionCurve):
    """mu(v) = kinetic + (static - kinetic) exp(-v / speed), as straight lines between `knots` points."""

    def __init__(self, static: float = 0.3, kinetic: float = 0.2, speed: float = 0.05, knots: float = 24) -> None:
        # points where the exponential has fallen by equal parts: close together where it is steep
        speeds = [-speed * math.log1p(-k / knots) for k in range(int(knots))]
        points = tuple((v, kinetic + (static - kinetic) * math.exp(-v / speed)) for v in speeds)
        super().__init__(points, static)


@dataclass(frozen=True)
class Hertz(ContactLaw):
    """A sphere on a plane, stiffness d^1.5, with the damping of Hunt and Crossley (1975)."""

    stiffness: float = 1e8  # N/m^1.5
    damping: float = 0.0  # s/m

    @staticmethod
    def normal_force(depth: float, rate: float, stiffness: float, damping: float) -> float:
        """Return the normal force (N)."""
        return stiffness * depth**1.5 * (1.0 + damping * rate)


@dataclass(frozen=True)
class SpeedDependent(ImpactLaw):
    """Newton's restitution that falls with the speed of the impact: e = restitution (speed / v)^exponent."""

    restitution: float = 0.9
    speed: float = 0.1  # m/s; slower impacts have the full restitution
    exponent: float = 0.25

    def impulse(self, instant: Instant, restitution: float) -> Impulse:
        """Return the impulse; `restitution` is 0 where bounces are too small to be told apart."""
        faster = max(1.0, -instant.gap_rate / self.speed)
        return newton_impulse(instant, restitution * faster**-self.exponent)


@dataclass(frozen=True)
class Swing(BaseMotion):
    """A root that swings: angle = amplitude (1 - cos(2 pi frequency t))."""

    amplitude: float = 0.1  # rad
    frequency: float = 5.0  # Hz

    @staticmethod
    def turn(t: float, amplitude: float, frequency: float) -> tuple[float, float, float]:
        """Return angle (rad), speed (rad/s) and acceleration (rad/s^2)."""
        w = 2.0 * math.pi * frequency
        phase = w * t
        return (
            amplitude * (1.0 - math.cos(phase)),
            amplitude * w * math.sin(phase),
            amplitude * w**2 * math.cos(phase),
        )


class Kutta(ExplicitScheme):
    """Kutta's rule of third order (1901)."""

    name, order = "kutta", 3

    def step(self, rates, t, y, h):  # type: ignore[no-untyped-def]
        """Return the state at t + h."""
        k1 = rates(t, y)
        k2 = rates(t + 0.5 * h, y + 0.5 * h * k1)
        k3 = rates(t + h, y - h * k1 + 2.0 * h * k2)
        return y + h / 6.0 * (k1 + 4.0 * k2 + k3)

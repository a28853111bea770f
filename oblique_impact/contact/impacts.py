"""Impacts on a rigid stop: impulses for the approach velocities of an instant."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np

from oblique_impact.contact.complementarity import plastic_impulses
from oblique_impact.contact.forces import SINGULAR
from oblique_impact.contact.state import Candidate
from oblique_impact.errors import Outcome, RunEnded
from oblique_impact.kernels.workspace import Array


class Impulse(NamedTuple):
    """Impulse of an impact (N s) and the kinetic energy it takes (J)."""

    normal: float
    tangential: float
    energy_loss: float


def impulse_of(instant: Candidate, normal: float, tangential: float) -> Impulse:
    """Complete an impulse by its energy loss, -(P v + 1/2 P A P) with the Delassus matrix A."""
    work_on_system = (
        normal * instant.gap_rate
        + tangential * instant.slip_rate
        + 0.5 * (instant.a_nn * normal * normal + instant.a_tt * tangential * tangential)
        + instant.a_nt * normal * tangential
    )
    return Impulse(normal, tangential, -work_on_system)


def newton_impulse(instant: Candidate, restitution: float) -> Impulse:
    """Frictionless impulse with Newton's restitution: I = -(1 + e) Z_n' / A_nn (paper Eq. 36)."""
    return impulse_of(instant, -(1.0 + restitution) * instant.gap_rate / instant.a_nn, 0.0)


def routh_impulse(instant: Candidate, restitution: float, friction: float) -> Impulse:
    """Impulse of a frictional impact by Routh's method with Poisson's restitution.

    The normal impulse P grows; the contact slides with dP_tau = -mu s dP until Z_tau' vanishes, then
    sticks if the cone allows (|A_nt| <= mu A_tt) and slides on or back otherwise.  Compression ends at Z_n' = 0;
    restitution adds e times its impulse (Routh 1905; Wang and Mason, J. Appl. Mech. 59, 1992).

    Raises ValueError where compression never ends (a jam: the sliding contact gains normal speed).
    """
    path = _FrictionalImpact(instant, friction)
    compression = path.advance_to_end_of_compression()
    path.advance(restitution * compression)
    return impulse_of(instant, path.normal, path.tangential)


class ImpactLaw(ABC):
    """Law of impacts: impulses as the gap closes on a rigid stop."""

    restitution: float

    def check(self, end_time: float) -> None:  # noqa: B027  most laws have nothing to check
        """Raise InputError if this is no law; called before a run of a user-defined law."""

    @abstractmethod
    def impulse(self, instant: Candidate, restitution: float) -> Impulse:
        """Impulse for the approach velocities at `instant` with the given restitution."""

    def impulses(self, normal: Array, rates: Array) -> Array:
        """Return the normal impulses (n,), N s, of an impact of n > 1 contacts, some of which are closed already.

        `normal` (n, n) is the Delassus matrix (1/kg) of the normals, `rates` (n,) are the gap rates before (m/s).
        By default raises RunEnded: a law for one contact says nothing of several.
        """
        raise RunEnded(Outcome.IMPACT_OF_SEVERAL)


@dataclass(frozen=True)
class NewtonImpact(ImpactLaw):
    """The paper's impulse-momentum method: frictionless, Newton's restitution."""

    restitution: float = 0.0

    def impulse(self, instant: Candidate, restitution: float) -> Impulse:  # noqa: D102
        return newton_impulse(instant, restitution)

    def impulses(self, normal: Array, rates: Array) -> Array:
        """Return Newton's impulses in Moreau's form: 0 <= P _|_ v + W P + e v >= 0 (Moreau 1988)."""
        return plastic_impulses(normal, (1.0 + self.restitution) * rates)


@dataclass(frozen=True)
class RouthImpact(ImpactLaw):
    """Frictional impact after Routh with Poisson's restitution; raises RunEnded where it jams."""

    friction: float
    restitution: float = 0.0

    def impulse(self, instant: Candidate, restitution: float) -> Impulse:  # noqa: D102
        try:
            return routh_impulse(instant, restitution, self.friction)
        except ValueError:
            raise RunEnded(Outcome.PAINLEVE) from None


class _FrictionalImpact:
    """State of a frictional impact as a function of the normal impulse."""

    def __init__(self, instant: Candidate, friction: float) -> None:
        self._instant, self._friction = instant, friction
        self.normal = self.tangential = 0.0
        self._gap_rate, self._slip_rate = instant.gap_rate, instant.slip_rate
        self._ratio = self._ratio_at(self._slip_rate)

    def _ratio_at(self, slip_rate: float) -> float:
        """dP_tau / dP of the branch that starts at `slip_rate`."""
        if slip_rate != 0.0:
            return -self._friction * float(np.sign(slip_rate))
        sticking = -self._instant.a_nt / self._instant.a_tt
        return float(np.clip(sticking, -self._friction, self._friction))

    def _rates(self) -> tuple[float, float]:
        i = self._instant
        return i.a_nn + self._ratio * i.a_nt, i.a_nt + self._ratio * i.a_tt

    def _move(self, step: float) -> None:
        gap_growth, slip_growth = self._rates()
        self.normal += step
        self.tangential += self._ratio * step
        self._gap_rate += gap_growth * step
        self._slip_rate += slip_growth * step

    def _to_zero_slip(self) -> float:
        growth = self._rates()[1]
        return -self._slip_rate / growth if self._slip_rate * growth < 0.0 else inf

    def _end_slip(self, step: float) -> None:
        self._move(step)
        self._slip_rate = 0.0
        self._ratio = self._ratio_at(0.0)

    def advance(self, step: float) -> None:
        """Increase the normal impulse by `step`."""
        to_zero_slip = self._to_zero_slip()
        if to_zero_slip < step:
            self._end_slip(to_zero_slip)
            step -= to_zero_slip
        self._move(step)

    def advance_to_end_of_compression(self) -> float:
        """Advance until Z_n' = 0; returns the normal impulse of compression."""
        for _ in range(2):
            growth = self._rates()[0]
            to_end = -self._gap_rate / growth if growth > 0.0 else inf
            to_zero_slip = self._to_zero_slip()
            if to_end < inf and abs(to_zero_slip - to_end) <= SINGULAR * to_end:
                # both at once, as they do in a system of one degree of freedom; rounding must not choose
                self._end_slip(to_end)
                return self.normal
            if to_end <= to_zero_slip:
                if to_end == inf:
                    break
                self._move(to_end)
                return self.normal
            self._end_slip(to_zero_slip)
        raise ValueError("compression never ends: the impact jams at this friction coefficient")

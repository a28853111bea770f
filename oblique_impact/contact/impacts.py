"""Impacts on a rigid stop: impulses for the approach velocities of an instant."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import expm1, inf, log, log1p
from typing import NamedTuple

from oblique_impact.contact.complementarity import plastic_impulses
from oblique_impact.contact.forces import SINGULAR
from oblique_impact.contact.friction import Branch, Coulomb, FrictionLaw
from oblique_impact.contact.state import Candidate
from oblique_impact.errors import Outcome, RunEnded
from oblique_impact.kernels.workspace import Array

_HALVINGS = 100  # to rounding
_LARGEST = 700.0  # whose exponential is a number
_SERIES = 1e-3  # of a smaller number the next term of the series is rounding


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


def routh_impulse(instant: Candidate, restitution: float, friction: FrictionLaw | float) -> Impulse:
    """Impulse of a frictional impact by Routh's method with Poisson's restitution.

    The normal impulse P grows; the contact slides with dP_tau = (intercept + slope Z_tau') dP, on the branches of
    the friction law that its slip velocity comes through, until that vanishes, then sticks if the cone allows
    (|A_nt| <= static A_tt) and slides on or back otherwise.  Compression ends at Z_n' = 0; restitution adds e
    times its impulse (Routh 1905; Wang and Mason, J. Appl. Mech. 59, 1992).  A number is a constant coefficient.

    Raises ValueError where compression never ends (a jam: the sliding contact gains normal speed).
    """
    law = friction if isinstance(friction, FrictionLaw) else Coulomb(friction, friction)
    path = _FrictionalImpact(instant, law)
    path.advance(inf)
    path.advance(restitution * path.normal)
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
        """Return Newton's impulses in Moreau's form: 0 <= P _|_ v+ + e v >= 0 with v+ = v + W P (Moreau 1988)."""
        return plastic_impulses(normal, (1.0 + self.restitution) * rates)


@dataclass(frozen=True)
class RouthImpact(ImpactLaw):
    """Frictional impact after Routh with Poisson's restitution; raises RunEnded where it jams.

    Without friction it is Newton's impact.

    Attributes
    ----------
    friction : FrictionLaw or float
        The law at the slip velocities during the impact, or a constant coefficient.
    restitution : float
        Poisson's coefficient.
    """

    friction: FrictionLaw | float
    restitution: float = 0.0

    def check(self, end_time: float) -> None:  # noqa: D102
        if isinstance(self.friction, FrictionLaw):
            self.friction.check(end_time)

    def impulse(self, instant: Candidate, restitution: float) -> Impulse:  # noqa: D102
        try:
            return routh_impulse(instant, restitution, self.friction)
        except ValueError:
            raise RunEnded(Outcome.PAINLEVE) from None


class _FrictionalImpact:
    """State of a frictional impact as a function of the normal impulse P.

    On a branch of the law dv/dP = A_nt + (intercept + slope v) A_tt is linear in the slip velocity v, which
    changes by (exp(k P) - 1)/k of its growth, k = slope A_tt.  It never turns, so that each branch is met once.
    """

    def __init__(self, instant: Candidate, friction: FrictionLaw) -> None:
        self._instant, self._friction = instant, friction
        self.normal = self.tangential = 0.0
        self._gap_rate, self._slip_rate = instant.gap_rate, instant.slip_rate

    def advance(self, most: float) -> None:
        """Increase the normal impulse by `most` or, if that is infinite, until Z_n' = 0."""
        approach = abs(self._gap_rate)
        while most > 0.0:
            self._enter_branch()
            to_edge = self._to_edge()
            to_end = self._to_end_of_compression(to_edge) if most == inf else most
            step = min(to_edge, to_end)
            if step == inf:
                raise ValueError("compression never ends: the impact jams with this friction")
            self._gap_rate, pushed = self._after(step)
            self.normal += step
            self.tangential += pushed
            self._slip_rate += self._growth * step * _mean_growth(self._bend * step)
            most -= step
            # both at once, as they do in a system of one degree of freedom; rounding must not choose
            at_edge = to_edge <= to_end * (1.0 + SINGULAR)
            if at_edge:
                self._slip_rate = self._edge
            if most == inf and (not at_edge or abs(self._gap_rate) <= SINGULAR * approach):
                return

    def _enter_branch(self) -> None:
        """Take the branch on which the slip goes on; it stays where neither side of a kink lets it go on."""
        i, v, static = self._instant, self._slip_rate, self._friction.static
        up, down = (self._friction.branch(v, side) for side in (1, -1))
        rising, falling = (i.a_nt + (side.intercept + side.slope * v) * i.a_tt for side in (up, down))
        sticks = v == 0.0 and static is not None and abs(i.a_nt) <= static * i.a_tt
        if rising > 0.0 and not sticks:
            self._branch, self._growth, self._edge = up, rising, up.upper
        elif falling < 0.0 and not sticks:
            self._branch, self._growth, self._edge = down, falling, down.lower
        else:
            self._branch, self._growth, self._edge = Branch(-i.a_nt / i.a_tt, 0.0, v, v), 0.0, inf
        self._ratio = self._branch.intercept + self._branch.slope * v
        self._bend = self._branch.slope * i.a_tt

    def _to_edge(self) -> float:
        """Return the normal impulse until the slip velocity is at the end of the branch."""
        if abs(self._edge) == inf:
            return inf
        straight = (self._edge - self._slip_rate) / self._growth
        bent = self._bend * straight
        return straight if bent == 0.0 else (log1p(bent) / self._bend if bent > -1.0 else inf)

    def _after(self, step: float) -> tuple[float, float]:
        """Gap rate after the normal impulse has grown by `step`, and the tangential impulse."""
        i, curving = self._instant, self._branch.slope * self._growth * step**2
        pushed = self._ratio * step + curving * _mean_growth_of_mean(self._bend * step)
        return self._gap_rate + i.a_nn * step + i.a_nt * pushed, pushed

    def _to_end_of_compression(self, most: float) -> float:
        """Return the normal impulse until Z_n' = 0, infinite if that is not on the branch, up to `most`."""
        i, k = self._instant, self._bend
        growth = i.a_nn + self._ratio * i.a_nt
        if k == 0.0:
            return -self._gap_rate / growth if growth > 0.0 else inf
        # Z_n' = its value here + held P + share (exp(k P) - 1)/k, which turns once at most
        held, share = i.a_nn - i.a_nt**2 / i.a_tt, i.a_nt / i.a_tt * self._growth
        turns = log(-held / share) / k if held * share < 0.0 else inf
        beyond = 2.0 * (abs(self._gap_rate) + abs(share / k)) / held if held > 0.0 else inf
        for end in sorted((turns, min(beyond, most))):
            if 0.0 < end <= most and end < inf and self._after(end)[0] >= 0.0:
                least = 0.0
                for _ in range(_HALVINGS):
                    middle = 0.5 * (least + end)
                    least, end = (middle, end) if self._after(middle)[0] < 0.0 else (least, middle)
                return end
        return inf


def _mean_growth(x: float) -> float:
    """(exp(x) - 1)/x, the mean of exp between 0 and x."""
    return expm1(min(x, _LARGEST)) / x if x != 0.0 else 1.0


def _mean_growth_of_mean(x: float) -> float:
    """(exp(x) - 1 - x)/x^2."""
    return (_mean_growth(x) - 1.0) / x if abs(x) > _SERIES else 0.5 + x * (1.0 + 0.25 * x * (1.0 + 0.2 * x)) / 6.0

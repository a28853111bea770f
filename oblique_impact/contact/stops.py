"""Stops that give way: the normal force is a function of depth and rate of depth, there are no impacts.

`ElasticStop`  the built-in one, a spring with Hunt and Crossley's damping
`ContactLaw`   the contract for laws of one's own
`stop_of`      the stop of a scenario
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import astuple, dataclass
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Any, ClassVar

from scipy.integrate import quad

from oblique_impact.contact.forces import Instant, Phase, stop_force
from oblique_impact.errors import InputError
from oblique_impact.kernels.pointers import Pointer

if TYPE_CHECKING:
    from oblique_impact.scenario.scenario import Scenario

_DEPTHS = (1e-9, 1e-6, 1e-3)  # m; where a law is tried before a run


class Stop(ABC):
    """A stop that gives way."""

    @property
    @abstractmethod
    def phase(self) -> Phase:
        """The stop's entries in the parameters of a closed contact."""

    @abstractmethod
    def energy(self, gap: float) -> float:
        """Energy (J) stored at a gap (m)."""

    def force(self, instant: Instant) -> float:
        """Return the normal force (N) at an instant."""
        return float(stop_force(self.phase, instant.gap, instant.gap_rate))


@dataclass(frozen=True)
class ElasticStop(Stop):
    """lambda_n = stiffness d (1 + damping d'), d = -Z_n, never negative (Hunt and Crossley 1975).

    Attributes
    ----------
    stiffness : float
        N/m.
    damping : float
        s/m.
    """

    stiffness: float
    damping: float = 0.0

    @property
    def phase(self) -> Phase:
        """The stop's entries in the parameters of a closed contact."""
        return Phase(spring=self.stiffness, dashpot=self.damping)

    def energy(self, gap: float) -> float:
        """Energy (J) stored at a gap (m)."""
        return 0.5 * self.stiffness * max(0.0, -gap) ** 2


class ContactLaw(Stop):
    """A normal contact law of one's own: a dataclass whose fields are numbers, with one function.

    ``normal_force(depth, rate, *fields)`` returns the normal force (N) at a depth >= 0 (m) and its rate (m/s).
    Forces that would pull are cut to zero.  It is compiled by numba: numbers, ``math`` and ``numpy`` functions of
    numbers, conditions and loops.  What the stop stores is the work of the force at rest; the rest is damping.

    Examples
    --------
    >>> @dataclass(frozen=True)
    ... class Hertz(ContactLaw):
    ...     stiffness: float = 1e8  # N/m^1.5
    ...     damping: float = 0.0  # s/m
    ...
    ...     @staticmethod
    ...     def normal_force(depth, rate, stiffness, damping):
    ...         return stiffness * depth**1.5 * (1.0 + damping * rate)
    """

    #: what the dataclass decorator adds
    __dataclass_fields__: ClassVar[dict[str, Any]]

    @staticmethod
    @abstractmethod
    def normal_force(depth: float, rate: float, *parameters: float) -> float:
        """Return the normal force (N)."""

    @cached_property
    def pointer(self) -> Pointer:
        """The compiled law; raises InputError if it cannot be compiled."""
        return Pointer(type(self).normal_force, 2, self._numbers)

    def check(self, end_time: float) -> None:
        """Raise InputError if this cannot be compiled or is no law of a stop; called before a run."""
        phase = self.phase
        for depth in _DEPTHS:
            force = stop_force(phase, -depth, 0.0)
            if not force < 1e300 or self.normal_force(depth, 0.0, *self._numbers) < 0.0:
                words = f"the force at rest at a depth of {depth:g} m is {force:g} N, should be finite, >= 0"
                raise InputError(f"{type(self).__name__}: {words}")

    @property
    def phase(self) -> Phase:
        """The stop's entries in the parameters of a closed contact."""
        return Phase(spring=inf, law=self.pointer.address)

    def energy(self, gap: float) -> float:
        """Energy (J) stored at a gap (m): the work of the force at rest."""
        if gap >= 0.0:
            return 0.0
        stored = quad(
            lambda d: max(0.0, self.normal_force(d, 0.0, *self._numbers)), 0.0, -gap, epsabs=0.0, epsrel=1e-12
        )
        return float(stored[0])

    @property
    def _numbers(self) -> tuple[float, ...]:
        return astuple(self)


def stop_of(scenario: Scenario) -> Stop | None:
    """Return the stop of a scenario that gives way, None for a rigid one."""
    c = scenario.contact
    if c.normal == "spring":
        return ElasticStop(c.stiffness, c.damping)
    own: Stop | None = scenario.part("normal")
    return own

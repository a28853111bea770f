"""Compliant stops: the normal force is a function of depth and rate of depth, there are no impacts.

`ContactLaw`   the contract, for user-defined laws too
`ElasticStop`  the built-in law, a spring with Hunt and Crossley's damping
`Bedding`      such a spring under a cell of the beam, of which a part may lie beyond the end of the bed
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from itertools import pairwise
from math import inf
from typing import Any, ClassVar

import numpy as np

from oblique_impact.contact.elastic import share_of, spring_force, stop_force
from oblique_impact.contact.state import Candidate
from oblique_impact.errors import InputError
from oblique_impact.kernels.laws import Law, compiled_law
from oblique_impact.kernels.workspace import Array

_DEPTHS = (1e-9, 1e-6, 1e-3)  # m; where a user-defined law is checked before a run


class ContactLaw(ABC):
    """A normal contact law: a dataclass whose fields are numbers, with one function.

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

    # added by the dataclass decorator
    __dataclass_fields__: ClassVar[dict[str, Any]]

    @staticmethod
    @abstractmethod
    def normal_force(depth: float, rate: float, *parameters: float) -> float:
        """Return the normal force (N)."""

    def check(self, end_time: float) -> None:
        """Raise InputError if the law cannot be compiled or is attractive; called before a run."""
        for depth in _DEPTHS:
            force = self.force(Candidate(gap=-depth))
            if not force < 1e300 or self.normal_force(depth, 0.0, *self._numbers) < 0.0:
                words = f"the force at rest at a depth of {depth:g} m is {force:g} N, should be finite, >= 0"
                raise InputError(f"{type(self).__name__}: {words}")

    @property
    def stop(self) -> dict[str, Any]:
        """Fields of a `Candidate` that say what the stop is; its stiffness is that at a small depth."""
        depth = _DEPTHS[0]
        force = max(0.0, float(self.normal_force(depth, 0.0, *self._numbers)))
        return {"compliant": 1, "stiffness": force / depth}

    @property
    def kernel(self) -> Law | None:
        """The law as kernels call it, None of the built-in spring; raises InputError if it cannot be compiled."""
        return compiled_law(type(self).normal_force, 2, self._numbers)

    def force(self, c: Candidate) -> float:
        """Return the normal force (N) of the stop alone at gap, slip and gap rate of a candidate."""
        law = self.kernel  # first: what cannot be compiled is not called
        alone = c.changed(compliance=0.0, **self.stop)
        return float(stop_force(law, alone, -c.gap, -c.gap_rate))

    def end_pushes(self, compression: Array, slip: Array) -> Array:
        """Return forces (N) along the slide that are no friction, which only beddings have; each (samples,)."""
        return np.zeros_like(slip)

    def energies(self, gap: Array, slip: Array, compression: Array, force: Array) -> Array:
        """Energies (J) that elastic contacts hold, each argument (samples,).

        At gaps and slips (m), with the compressions (m) of the stop itself and the forces (N) at rest: the work of
        the force at rest, and half of the force times what the body yields, which is the rest of the depth.  Other
        contacts may push the body onto a stop from which its coordinates are away: their sum is positive.
        """
        return np.asarray(self._own_energies(compression) - 0.5 * force * (gap + compression))

    def peak_energy(self, depth: float, force: float, compliance: float) -> float:
        """Largest energy (J) stored in a contact of the given largest depth (m) and force (N) at rest.

        It has a compliance (m/N) behind it.
        """
        at_rest = float(stop_force(self.kernel, Candidate(compliance=compliance, **self.stop), depth, 0.0))
        compressed = np.array([max(0.0, depth - compliance * at_rest)])
        return float(self._own_energies(compressed)[0]) + 0.5 * compliance * at_rest * at_rest

    def _own_energies(self, depths: Array) -> Array:
        """Energies (J) that the stop itself has stored at depths (m), each (samples,)."""
        from scipy.integrate import quad

        # of a long output no warnings are printed
        numbers, accuracy = self._numbers, {"epsabs": 0.0, "epsrel": 1e-12, "full_output": True}

        def force(depth: float) -> float:
            return max(0.0, self.normal_force(depth, 0.0, *numbers))

        ends, place = np.unique(depths, return_inverse=True)
        parts = [quad(force, *part, **accuracy)[0] for part in pairwise([0.0, *ends.tolist()])]
        return np.asarray(np.cumsum(parts)[place])

    @property
    def _numbers(self) -> tuple[float, ...]:
        return tuple(float(getattr(self, name)) for name in self.__dataclass_fields__)


@dataclass(frozen=True)
class ElasticStop(ContactLaw):
    """lambda_n = stiffness d (1 + damping d') + linear_damping d', d = -Z_n, never negative.

    Damping is Hunt and Crossley's (1975), or that of a dashpot beside the spring, or both.

    Attributes
    ----------
    stiffness : float
        N/m; infinite of a rigid stop under places without inertia.
    damping : float
        s/m.
    linear_damping : float
        N s/m.
    """

    stiffness: float
    damping: float = 0.0
    linear_damping: float = 0.0

    @staticmethod
    def normal_force(  # type: ignore[override]
        depth: float, rate: float, stiffness: float, damping: float, linear_damping: float
    ) -> float:
        """Return the normal force (N)."""
        return spring_force(depth, rate, stiffness, damping) + linear_damping * rate

    @property
    def stop(self) -> dict[str, Any]:
        """Fields of a `Candidate` that say what the stop is."""
        names = "stiffness", "damping", "linear_damping"
        return {"compliant": 1} | {name: float(getattr(self, name)) for name in names}

    @property
    def kernel(self) -> None:
        """None: kernels have the spring's force."""
        return

    def over(self, slip: float) -> tuple[float, float]:
        """Return the stiffness (N/m) at a place (m along the side), and its derivative by the place (N/m^2)."""
        return self.stiffness, 0.0

    def energies(self, gap: Array, slip: Array, compression: Array, force: Array) -> Array:
        """Energies (J) of the spring and what is behind it."""
        return -0.5 * gap * force

    def peak_energy(self, depth: float, force: float, compliance: float) -> float:
        """Largest energy (J) stored in a contact."""
        return 0.5 * depth**2 / (1.0 / self.stiffness + compliance)


@dataclass(frozen=True)
class Bedding(ElasticStop):
    """Bed of springs under a cell of the beam, of which only that part bears that is over the bed.

    A cell that slides over an end of the bed takes its force down to zero, and up again when it comes back.  The
    energy 1/2 k d^2 of the springs under it pushes it off the bed as it does.

    Attributes
    ----------
    stiffness : float
        N/m, of the bed under the whole cell.
    first, last : float
        Slip (m) between which some of the cell is over the bed.
    cell : float
        Length of the cell (m).
    """

    first: float = -inf
    last: float = inf
    cell: float = 0.0

    @property
    def stop(self) -> dict[str, Any]:
        """Fields of a `Candidate` that say what the stop is."""
        return super().stop | {"cell": float(self.cell)}

    def over(self, slip: float) -> tuple[float, float]:
        """Return the stiffness (N/m) at a place (m along the side), and its derivative by the place (N/m^2)."""
        share, fading = share_of(slip, self.first, self.last, self.cell)
        return self.stiffness * share, self.stiffness * fading

    def end_pushes(self, compression: Array, slip: Array) -> Array:
        """Return forces (N) along the slide of a cell that lies over an end of the bed, each (samples,)."""
        slopes = np.array([self.over(place)[1] for place in slip.tolist()])
        return np.asarray(-0.5 * slopes * compression**2)

    def peak_energy(self, depth: float, force: float, compliance: float) -> float:
        """Largest energy (J) stored in a contact, on which perhaps a part of the cell alone has borne."""
        return 0.5 * depth * min(self.stiffness * depth, force)


def elastic_stop(
    stiffness: float,
    damping: float,
    extent: tuple[float, ...] = (),
    cell: float = 0.0,
    linear_damping: float = 0.0,
) -> ElasticStop:
    """Return a spring (N/m, s/m, N s/m), or that of a bed between the slips `extent` (m) under a `cell` (m)."""
    if cell and extent:
        first, last = extent
        return Bedding(stiffness, damping, linear_damping, first, last, cell)
    return ElasticStop(stiffness, damping, linear_damping)


#: a rigid stop under places without inertia: only what the coordinates leave out is compliant
NO_INERTIA = ElasticStop(inf)

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

from oblique_impact.contact.forces import share_of, spring_force, stop_force
from oblique_impact.contact.state import Candidate, Residual
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
        """Fields of a `Candidate` that say what the stop is."""
        return {"compliant": 1}

    @property
    def kernel(self) -> Law | None:
        """The law as kernels call it, None of the built-in spring; raises InputError if it cannot be compiled."""
        return compiled_law(type(self).normal_force, 2, self._numbers)

    def force(self, c: Candidate) -> float:
        """Return the normal force (N) of the stop alone at gap, slip and gap rate of a candidate."""
        alone = c.changed(compliance=0.0, **self.stop)
        return float(stop_force(self.kernel, alone, c.gap, c.gap_rate))

    def end_pushes(self, gap: Array, slip: Array) -> Array:
        """Return forces (N) along the slide that are no friction, which only beddings have; each (samples,)."""
        return np.zeros_like(gap)

    def energy(self, gap: float, slip: float, compliance: float = 0.0) -> float:
        """Energy (J) held at gap and slip (m), in a compliance (m/N) in series too: work of the force at rest."""
        return float(self.energies(np.array([gap]), np.array([slip]), compliance)[0])

    def energies(self, gap: Array, slip: Array, compliance: float = 0.0) -> Array:
        """Energies (J), see `energy`, at gaps and slips (m) of closed contact, each (samples,)."""
        found, closed, law = np.zeros(gap.shape), gap < 0.0, self.kernel
        c = Candidate(compliance=compliance, **self.stop)
        forces = [stop_force(law, c, value, 0.0) for value in gap[closed].tolist()]
        depths = np.maximum(-gap[closed] - compliance * np.array(forces), 0.0)
        found[closed] = self._own_energies(depths) + 0.5 * compliance * np.square(forces)
        return found

    def peak_energy(self, depth: float, force: float, compliance: float) -> float:
        """Largest energy (J) stored in a contact of the given largest depth (m) and force (N), see `energy`."""
        return self.energy(-depth, 0.0, compliance)

    def compression(self, residual: Residual, gap: Array, gap_rate: Array, force: Array) -> Array:
        """Compression (m) of the stop itself in closed contact, from gaps (m), their rates (m/s) and forces (N).

        It is -gap less what the residual flexibility takes of it.  The relaxation of that flexibility is neglected
        here.
        """
        return np.maximum(0.0, -gap - residual.compliance * force)

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

    @staticmethod
    def normal_force(depth: float, rate: float, stiffness: float, damping: float) -> float:  # type: ignore[override]
        """Return the normal force (N)."""
        return spring_force(depth, rate, stiffness, damping)

    @property
    def stop(self) -> dict[str, Any]:
        """Fields of a `Candidate` that say what the stop is."""
        return {"compliant": 1, "stiffness": float(self.stiffness), "damping": float(self.damping)}

    @property
    def kernel(self) -> None:
        """None: kernels have the spring's force."""
        return

    def over(self, slip: float) -> tuple[float, float]:
        """Return the stiffness (N/m) at a place (m along the side), and its derivative by the place (N/m^2)."""
        return self.stiffness, 0.0

    def compression(self, residual: Residual, gap: Array, gap_rate: Array, force: Array) -> Array:
        """Compression (m) of the stop itself; without damping its force is stiffness times it."""
        depth, rate = -gap, -gap_rate
        at_rest = 1.0 / (1.0 + self.stiffness * residual.compliance)  # the stop's share of the depth
        pushing = np.maximum(1.0 + self.damping * at_rest * rate, 0.0)
        share = 1.0 / (1.0 + self.stiffness * pushing * residual.compliance)
        # a relaxing flexibility pushes back by its rate as well, see `oblique_impact.contact.forces`
        pushed = share * (depth + residual.relaxation * (1.0 - share) * rate)
        return np.where(gap < 0.0, np.maximum(0.0, pushed), 0.0)

    def energies(self, gap: Array, slip: Array, compliance: float = 0.0) -> Array:
        """Energies (J) of the spring, with a compliance (m/N) in series."""
        return np.where(gap < 0.0, 0.5 * gap**2 / (1.0 / self.stiffness + compliance), 0.0)


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

    def energies(self, gap: Array, slip: Array, compliance: float = 0.0) -> Array:
        """Energies (J) of that part of the springs that the cell lies over."""
        shares = [self.over(place)[0] / self.stiffness for place in slip.tolist()]
        return np.asarray(super().energies(gap, slip, compliance) * np.array(shares))

    def end_pushes(self, gap: Array, slip: Array) -> Array:
        """Return forces (N) along the slide of a cell that lies over an end of the bed, each (samples,)."""
        slopes = np.array([self.over(place)[1] for place in slip.tolist()])
        return np.asarray(-0.5 * slopes * np.minimum(gap, 0.0) ** 2)

    def peak_energy(self, depth: float, force: float, compliance: float) -> float:
        """Largest energy (J) stored in a contact, on which perhaps a part of the cell alone has borne."""
        return 0.5 * depth * min(self.stiffness * depth, force)


def elastic_stop(
    stiffness: float, damping: float, extent: tuple[float, ...] = (), cell: float = 0.0
) -> ElasticStop:
    """Return a spring (N/m, s/m), or that of a bedding between the slips `extent` (m) under a `cell` (m)."""
    if cell and extent:
        first, last = extent
        return Bedding(stiffness, damping, first, last, cell)
    return ElasticStop(stiffness, damping)


@dataclass(frozen=True)
class MasslessPoint(ContactLaw):
    """A rigid stop under a contact point without inertia: only what the coordinates leave out is compliant.

    lambda_n = (d + eta d')/G with the compliance G and the relaxation time eta of the body's `Residual`, and no
    impulses.
    """

    @staticmethod
    def normal_force(depth: float, rate: float) -> float:  # type: ignore[override]
        """Return 0: the stop itself is rigid."""
        return 0.0

    @property
    def stop(self) -> dict[str, Any]:
        """Fields of a `Candidate` that say what the stop is."""
        return {"compliant": 1, "massless": 1}

    @property
    def kernel(self) -> None:
        """None: kernels have its force."""
        return

    def compression(self, residual: Residual, gap: Array, gap_rate: Array, force: Array) -> Array:
        """Return 0: the stop itself is rigid."""
        return np.zeros_like(gap)

    def _own_energies(self, depths: Array) -> Array:
        return np.zeros_like(depths)

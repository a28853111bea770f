"""A system with its laws, scheme and times, ready to be marched."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from oblique_impact.contact.flexibility import Flexibility
from oblique_impact.contact.simultaneous import ContactMachines
from oblique_impact.contact.state import Residual
from oblique_impact.contact.transitions import ContactMachine, Earlier
from oblique_impact.kernels.system import NormalModes
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.scheme import Scheme


def no_residual(q: Array) -> Residual:
    """Return no residual flexibility."""
    return Residual()


class Candidates(NamedTuple):
    """Places of a system that can touch obstacles, n candidates of contact."""

    machines: ContactMachines
    obstacles: tuple[int, ...]  # (n,) of each contact: the slope is 0, the others count from 1
    on_side: tuple[bool, ...]  # whether a point of the beam touches a side; else a fixed point touches the beam
    places: tuple[float, ...]  # m along the beam, of points of the beam
    #: tips and corners that take over from each other where a scheme locates that exactly; None: those that touch
    hand_over: Mapping[int, int] | None = None
    flexibility: Flexibility | None = None  # across a beam in modes, of places without inertia, or along it

    @classmethod
    def of_one(cls, machine: ContactMachine) -> Candidates:
        """Return the one candidate of a system with a contact on a slope."""
        return cls(ContactMachines([machine]), (0,), (True,), (0.0,))

    def place(self, contact: int, slip: float) -> float:
        """Return the place (m along the beam) of a contact at its slip (m)."""
        return self.places[contact] if self.on_side[contact] else -slip


@dataclass(frozen=True)
class Problem:
    """Everything the loop needs to march one system."""

    system: Any  # see `oblique_impact.kernels.system.System`
    q0: Array
    qd0: Array
    candidates: Candidates
    scheme: Scheme
    end_time: float
    output_interval: float
    scales: Array  # (2 d,) sizes of q and q' for absolute tolerances
    contact: bool = True
    breakpoints: tuple[float, ...] = ()  # times (s) at which the forces are not smooth
    residual: Callable[[Array], Residual] = no_residual  # of the contact point at q (d,)
    modes: NormalModes | None = None  # of what is linear in the system
    #: largest deflection along the beam over its length (samples,), of q (samples, d); None: no small deflections
    relative_deflection: Callable[[Array], Array] | None = None
    earlier: Mapping[int, Earlier] = field(default_factory=dict)  # contacts that go on from an earlier run

    @property
    def machine(self) -> ContactMachine:
        """The transition table of the first candidate; tolerances and laws are those of all."""
        return self.candidates.machines.machines[0]

"""A system with its laws, scheme and times, ready to be marched."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from oblique_impact.contact.state import Residual
from oblique_impact.contact.transitions import ContactMachine
from oblique_impact.kernels.system import NormalModes
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.scheme import Scheme


def _no_residual(q: Array) -> Residual:
    return Residual()


@dataclass(frozen=True)
class Problem:
    """Everything the loop needs to march one system."""

    system: Any  # see `oblique_impact.kernels.system.System`
    q0: Array
    qd0: Array
    machine: ContactMachine
    scheme: Scheme
    end_time: float
    output_interval: float
    scales: Array  # (2 d,) sizes of q and q' for absolute tolerances
    contact: bool = True
    breakpoints: tuple[float, ...] = ()  # times (s) at which the forces are not smooth
    residual: Callable[[Array], Residual] = _no_residual  # of the contact point at q (d,)
    modes: NormalModes | None = None  # of what is linear in the system
    #: largest deflection along the beam over its length (samples,), of q (samples, d); None: no small deflections
    relative_deflection: Callable[[Array], Array] | None = None

"""A system with its laws, scheme and times, ready to be marched."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from oblique_impact.contact.compliance import Compliance
from oblique_impact.contact.decision import Decision
from oblique_impact.contact.transitions import Earlier
from oblique_impact.kernels.system import NormalModes
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.scheme import Scheme


@dataclass(frozen=True)
class Problem:
    """Everything the loop needs to march one system."""

    system: Any  # see `oblique_impact.kernels.system.System`
    q0: Array
    qd0: Array
    decision: Decision  # about the candidates of contact
    scheme: Scheme
    end_time: float
    output_interval: float
    scales: Array  # (2 d,) sizes of q and q' for absolute tolerances
    contact: bool = True
    breakpoints: tuple[float, ...] = ()  # times (s) at which the forces are not smooth
    modes: NormalModes | None = None  # of what is linear in the system
    #: largest deflection along the beam over its length (samples,), of q (samples, d); None: no small deflections
    relative_deflection: Callable[[Array], Array] | None = None
    earlier: Mapping[int, Earlier] = field(default_factory=dict)  # contacts that go on from an earlier run
    #: tips and corners that take over from each other where a scheme locates that exactly; None: those that touch
    hand_over: Mapping[int, int] | None = None
    compliance: Compliance | None = None  # of the body, behind the contact rows

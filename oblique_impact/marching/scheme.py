"""The contract between the marching schemes and the loop that drives them.

A scheme knows nothing of transitions, and holds no state of a run: that is in what its steps are given.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.compliance import Compliance
from oblique_impact.contact.friction import FrictionLaw
from oblique_impact.contact.state import Candidate, Contacts
from oblique_impact.contact.transitions import Earlier, StickCriterion
from oblique_impact.kernels.system import NormalModes
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.advance import Limits, Stepper
from oblique_impact.marching.buffers import Scratch
from oblique_impact.marching.step_log import StepLog

#: steps times degrees of freedom of a call: 33,000 steps of two modes are 0.2 s, and 750 of 128 some more
_WORK_PER_CALL = 100_000


class Task(NamedTuple):
    """What a scheme has to march, as far as its buffers depend on it."""

    size: int  # d degrees of freedom
    contacts: int  # n candidates
    entries: int  # of the state vector
    output_interval: float  # s
    end_time: float  # s
    friction: FrictionLaw
    restitution: float  # of impacts
    modes: NormalModes | None = None  # where the linear part of the system is known
    compliance: Compliance | None = None  # of the body, behind the contact rows
    elastic: bool = False  # whether stops are


@dataclass(frozen=True)
class Prepared:
    """A system with the buffers of a march, the same from call to call."""

    system: Any
    contacts: Contacts
    scratch: Scratch
    own: Any  # see `Scheme.buffers`


class Scheme(ABC):
    """A marching scheme; subclasses state their order of convergence in the step.

    A scheme is immutable: the same object marches any number of runs.
    """

    name: str
    order: int
    #: whether its steps decide contact states themselves, see `step_log`
    decides: bool = False
    #: whether it takes elastic stops alone
    elastic_only: bool = False

    @property
    def stick_criterion(self) -> StickCriterion | None:
        """Criterion by which the scheme distinguishes stick from slip; None if the transition table does."""
        return None

    @property
    def shortest_flight(self) -> float:
        """Length (s) of flights between bounces below which bounces are taken as accumulated."""
        return 0.0

    def buffers(self, task: Task) -> Any:
        """Return the buffers of this scheme alone; by default None."""
        return None

    def step_log(self, prepared: Prepared) -> StepLog | None:
        """Return the log of steps that decide contact states themselves; by default None: transitions are guards'.

        Behind what :meth:`extra_state` describes the last entries of the state vector are then states and counts.
        """
        return None

    def resume(  # noqa: B027  most schemes have no such log
        self,
        prepared: Prepared,
        earlier: Mapping[int, Earlier],
        places: Mapping[int, Candidate],
        acceleration: Array,
    ) -> None:
        """Log contacts that go on from an earlier run, where they are now, if there is such a log.

        The `acceleration` (d,) is that with their forces.
        """

    def check(self, end_time: float) -> None:  # noqa: B027  most schemes have nothing to check
        """Raise InputError if this cannot march; called before a run of a user-defined scheme."""

    def extra_state(self, size: int, contacts: int, quadratures: int) -> int:
        """Entries of the state vector behind the quadratures, of a system of `size`; see `fill_extra_state`.

        The first `size` + 2 `contacts` of them, if there are any, are the acceleration and the normal and
        tangential force of each contact to report.
        """
        return 0

    def fill_extra_state(self, prepared: Prepared, y: Array, extra: Array) -> None:
        """Fill these entries as a phase starts at y; by default with NaN: they follow from the first step."""
        extra[:] = np.nan

    def steps_per_call(self, size: int) -> int:
        """Return after how many steps a march returns, so that progress and interrupts are prompt.

        By default about a tenth of a second of computing for a system of `size`.
        """
        return max(1, _WORK_PER_CALL // size)

    @abstractmethod
    def stepper(self, prepared: Prepared, limits: Limits) -> Stepper:
        """Return the steps of a phase, the contacts in their states."""

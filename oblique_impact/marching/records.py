"""Record of a run: samples, events, contacts, passages."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.log import Contact, Event, Passage
from oblique_impact.errors import Outcome
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.sampling import Observation


class Segment(NamedTuple):
    """Samples of one phase."""

    times: Array  # (samples,)
    states: Array  # (samples, ny)
    observation: Observation
    nearest: Array  # (samples, 6) of the contact with the smallest gap, with the forces of all together
    depth: Array  # (samples,) compression of the stop itself (m)
    stored: Array  # (samples,) J, in elastic stops and the flexibility behind the contacts
    stretched: Array  # (samples,) J, in the axial flexibility behind the friction, which is taken to have lost it
    each: NDArray[np.int8]  # (samples, n) state of each contact
    step: Array  # (samples,) s, length of the step that ends there, if steps decide states; 0: none does


@dataclass
class Record:
    """Record of a run."""

    segments: list[Segment] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    contacts: list[Contact] = field(default_factory=list)
    passages: list[Passage] = field(default_factory=list)
    outcome: Outcome = Outcome.COMPLETED
    message: str = ""  # about the outcome, if not the outcome's own sentence
    #: times (s) at which the contact forces were one of several solutions
    ambiguous: list[float] = field(default_factory=list)
    steps: int = 0
    rejected: int = 0

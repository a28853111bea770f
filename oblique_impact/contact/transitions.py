"""What changes at an instant: states, events and impulses; and what the decision about it is told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from math import inf
from typing import NamedTuple, Protocol

from oblique_impact.contact.impacts import Impulse
from oblique_impact.contact.state import Candidate
from oblique_impact.errors import Outcome
from oblique_impact.kernels.workspace import Array


class EventKind(Enum):
    """Kind of an event; the values are those of the column `kind` in events.csv."""

    IMPACT = "impact"
    REBOUND = "rebound"
    RELEASE = "release"
    STICK = "stick"
    SLIP = "slip"
    REVERSAL = "reversal"

    @property
    def impulsive(self) -> bool:
        """Whether velocities jump: what the event's row holds happened at its instant."""
        return self in (EventKind.IMPACT, EventKind.REBOUND)


class AtEnd(Enum):
    """Passages of the contact point at an end of the slope; the values are those in summary.json."""

    SLIDES_OFF = "slides off"
    FALLS_PAST = "falls past"
    COMES_BACK = "comes back"


@dataclass
class Transition:
    """What changes at an instant, by contact: states, events in their order, impulses.

    Without an event it is a kink of the friction law, or a contact point crosses the line of a side beyond its
    ends.
    """

    #: candidates with their new states
    states: dict[int, Candidate] = field(default_factory=dict)
    events: list[tuple[int, EventKind]] = field(default_factory=list)
    #: of impacts
    impulses: dict[int, Impulse] = field(default_factory=dict)
    #: impulses of friction that end the slip within a step; they are booked with the finite forces
    stick_projections: dict[int, Impulse] = field(default_factory=dict)
    passages: list[tuple[int, AtEnd]] = field(default_factory=list)
    #: whether there were other solutions, of which one with the fewest closed contacts was taken
    ambiguous: bool = False
    #: why no contact state exists after the impulses; the run ends there
    failure: Outcome | None = None
    #: tangential forces (N) of contacts that go on from an earlier run
    pulls: dict[int, float] = field(default_factory=dict)

    @classmethod
    def to(
        cls, contact: int, state: Candidate, kind: EventKind | None = None, at_end: AtEnd | None = None
    ) -> Transition:
        """Return the change of one contact to a state, with an event."""
        events = [] if kind is None else [(contact, kind)]
        return cls({contact: state}, events, passages=[] if at_end is None else [(contact, at_end)])


class Earlier(NamedTuple):
    """A contact that was closed where an earlier run has ended, and goes on from there."""

    state: int
    normal_force: float  # N
    tangential_force: float
    began: float  # m, slip at which it began


class ContactProbe(Protocol):
    """The problem of all contacts at the present state of a run, before and after impulses."""

    def of(self, contact: int) -> Candidate:
        """Return a contact, as if there were no others."""

    def coupled(self, contact: int) -> Candidate:
        """Return a closed contact with the present forces of the others in its accelerations."""

    def after(self, impulses: Mapping[int, Impulse]) -> list[Candidate]:
        """Return all contacts with the velocities that impulses leave."""

    def together(self, contacts: Sequence[int], impulses: Mapping[int, Impulse]) -> tuple[list[Candidate], Array]:
        """Return contacts with the velocities that impulses leave, and their Delassus matrix (m, 2, m, 2)."""

    def slip_rate_ahead(self, contact: int) -> float:
        """Slip velocity (m/s) of a contact a little later, if it stays closed; 0 if it is rounding."""


class StickCriterion(NamedTuple):
    """Criterion by which a scheme itself distinguishes stick from slip; see `can_stick`."""

    stopping_time: float  # s; the length of a step, or infinite for the paper's literal criterion
    located: bool = False  # transitions are located, and their guards say what follows

    @property
    def projects(self) -> bool:
        """Whether the slip velocity is set to zero when stick is detected."""
        return self.stopping_time < inf

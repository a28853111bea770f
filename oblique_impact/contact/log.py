"""What a run writes down of its contacts: events, closed contacts, passages of the ends of slopes."""

from __future__ import annotations

from typing import NamedTuple

from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import AtEnd, EventKind


class Event(NamedTuple):
    """One row of the event log (SI units).

    The row of an impact or a rebound holds what its impulse did.  The row of a release holds what the finite force
    did since the contact began, so that each impulse (N s) and each loss (J) stands in one row.
    """

    time: float
    kind: EventKind
    normal_impulse: float
    tangential_impulse: float
    normal_velocity: float  # gap rate just before
    tangential_velocity: float  # slip rate just after
    energy_loss: float
    state: State  # after
    peak_force: float = 0.0  # N, the largest normal force of the contact that is released
    peak_energy: float = 0.0  # J, the largest that its elastic stop has stored
    obstacle: int = 0  # the slope, or from 1 in the order of the scenario
    place: float = 0.0  # m along the beam

    def __repr__(self) -> str:
        """Return kind, time, state and impulse in a line; the fields by name are `_asdict()`."""
        state = self.state.name.lower()
        return f"<{self.kind.value} at {self.time:.9g} s, then {state}; {self.normal_impulse:.5g} N s>"

    def with_share(self, finite: Contact) -> Event:
        """Add the share of the contact's finite force to the row of the event that ends it."""
        return self._replace(
            normal_impulse=self.normal_impulse + finite.normal_impulse,
            tangential_impulse=self.tangential_impulse + finite.tangential_impulse,
            energy_loss=self.energy_loss + finite.energy_loss,
            peak_force=finite.peak_force,
            peak_energy=finite.peak_energy,
        )


class Passage(NamedTuple):
    """The contact point leaves a slope with ends, or comes back up past the line of it."""

    time: float  # s
    how: AtEnd
    place: float  # m along the slope from its origin
    end: float  # m along the slope, of the nearer end
    obstacle: int = 0  # the slope, or from 1 in the order of the scenario


class Contact(NamedTuple):
    """One closed contact, or a rebound (start = end); impulses of impacts are included (SI units)."""

    start: float
    end: float
    normal_impulse: float
    tangential_impulse: float
    peak_force: float  # N, the largest finite normal force
    peak_energy: float  # J, the largest that an elastic stop has stored
    energy_loss: float  # J, by impact, friction and the stop's damping
    compliance: float = 0.0  # m/N along the normal, of what the coordinates leave out, in series with the stop
    obstacle: int = 0  # the slope, or from 1 in the order of the scenario
    first_place: float = 0.0  # m along the beam, the nearest to the root
    last_place: float = 0.0  # m

    def __repr__(self) -> str:
        """Return span, impulse and largest force in a line; the fields by name are `_asdict()`."""
        span = f"{self.start:.9g} to {self.end:.9g} s"
        return f"<contact from {span}: {self.normal_impulse:.5g} N s, at most {self.peak_force:.5g} N>"

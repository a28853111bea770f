"""The rows of events and of contacts: columns, order, units; as JSON in a history's attributes and as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.errors import InputError
from oblique_impact.marching.records import Contact, Event
from oblique_impact.scenario.messages import short

#: columns of an event's row and their units; the first seven are those of the contract of the file formats
EVENT_UNITS = {
    "time": "s",
    "kind": "",
    "normal_impulse": "N s",
    "normal_velocity": "m/s",
    "tangential_velocity": "m/s",
    "energy_loss": "J",
    "state": "",
    "tangential_impulse": "N s",
    "peak_force": "N",
    "peak_energy": "J",
}
EVENT_COLUMNS = tuple(EVENT_UNITS)


def event_row(event: Event) -> list[Any]:
    """Return an event in the order of `EVENT_COLUMNS`; kind and state by their names."""
    words = {"kind": event.kind.value, "state": event.state.name.lower()}
    return [words.get(name) or float(getattr(event, name)) for name in EVENT_COLUMNS]


def event_of(row: list[Any]) -> Event:
    """Return the event of a row; raises InputError for what is none."""
    try:
        given = dict(zip(EVENT_COLUMNS, row, strict=True))
        kind, state = EventKind(given.pop("kind")), State[given.pop("state").upper()]
        return Event(kind=kind, state=state, **{name: float(value) for name, value in given.items()})
    except (TypeError, ValueError, KeyError, AttributeError, OverflowError):
        raise InputError(f"attribute events: {short(row)} is not an event") from None


def contact_of(row: list[Any]) -> Contact:
    """Return the contact of a row in the order of the fields of `Contact`; raises InputError for what is none."""
    try:
        return Contact._make(map(float, row))
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"attribute contacts: {short(row)} is not a contact") from None


def events_csv(events: Sequence[Event]) -> str:
    """Return the event log as CSV text; numbers have all their digits."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(EVENT_COLUMNS)
    writer.writerows(map(event_row, events))
    return buffer.getvalue()


def check_times_of_events(events: Sequence[Event], first: float, last: float) -> None:
    """Raise InputError for events outside of the run (s), or not in order."""
    times = [event.time for event in events]
    inside = all(first <= time <= last for time in times)
    if not inside or any(later < earlier for earlier, later in pairwise(times)):
        raise InputError(f"attribute events: times should be ascending, from {first:g} to {last:g} s")

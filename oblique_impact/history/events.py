"""Events and contacts of a history, and rows of the event log: JSON in the attributes of a history, and CSV."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Sequence
from typing import Any

from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.marching.records import Contact, Event

__all__ = [
    "EVENT_COLUMNS",
    "OF_CONTACTS_IN_EVENTS",
    "Contact",
    "Event",
    "event_of",
    "event_row",
    "events_csv",
    "numbers_of",
]

#: columns of events.csv, in SI units; other programs read the first seven in this order
EVENT_COLUMNS = (
    "time",
    "kind",
    "normal_impulse",
    "normal_velocity",
    "tangential_velocity",
    "energy_loss",
    "state",
    "tangential_impulse",
    "peak_force",
    "peak_energy",
)
#: two more of a run with several contacts
OF_CONTACTS_IN_EVENTS = ("obstacle", "place")


def event_row(event: Event, columns: Sequence[str] = EVENT_COLUMNS) -> list[Any]:
    """Return an event in the order of the columns; kind and state by their names."""
    names = {"kind": event.kind.value, "state": event.state.name.lower()}
    found = [names.get(column) or float(getattr(event, column)) for column in columns]
    return [int(value) if column == "obstacle" else value for column, value in zip(columns, found, strict=True)]


def event_of(row: Sequence[Any]) -> Event:
    """Return the event of a row; raises TypeError, ValueError or KeyError for other rows."""
    columns = EVENT_COLUMNS if len(row) == len(EVENT_COLUMNS) else EVENT_COLUMNS + OF_CONTACTS_IN_EVENTS
    given = dict(zip(columns, row, strict=True))
    kind, state = EventKind(given.pop("kind")), State[given.pop("state").upper()]
    numbers: dict[str, Any] = dict(zip(given, numbers_of(given.values()), strict=True))
    return Event(kind=kind, state=state, **numbers)


def numbers_of(values: Iterable[Any]) -> list[float]:
    """Return values of a file as finite numbers; raises TypeError, ValueError or OverflowError for others."""
    found = list(values)
    if not all(isinstance(value, int | float) and not isinstance(value, bool) for value in found):
        raise TypeError("it has no numbers where they should be")
    if not all(map(math.isfinite, found)):
        raise ValueError("it has no finite numbers where they should be")
    return [float(value) for value in found]


def events_csv(events: Sequence[Event], columns: Sequence[str] = EVENT_COLUMNS) -> str:
    """Return the event log as CSV text; numbers have all their digits."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(event_row(event, columns) for event in events)
    return buffer.getvalue()

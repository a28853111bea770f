"""Events and contacts of a history, and rows of the event log: JSON in the attributes of a history, and CSV."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Sequence
from typing import Any

from oblique_impact.contact.log import Contact, Event
from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind

__all__ = [
    "EVENT_COLUMNS",
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
    "obstacle",
    "place",
)


def event_row(event: Event) -> list[Any]:
    """Return an event in the order of `EVENT_COLUMNS`; kind and state by their names."""
    others = {"kind": event.kind.value, "state": event.state.name.lower(), "obstacle": event.obstacle}
    return [others[name] if name in others else float(getattr(event, name)) for name in EVENT_COLUMNS]


def event_of(row: Sequence[Any]) -> Event:
    """Return the event of a row; raises TypeError, ValueError or KeyError for other rows."""
    given = dict(zip(EVENT_COLUMNS, row, strict=True))
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


def events_csv(events: Sequence[Event]) -> str:
    """Return the event log as CSV text; numbers have all their digits."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(EVENT_COLUMNS)
    writer.writerows(event_row(event) for event in events)
    return buffer.getvalue()

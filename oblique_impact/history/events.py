"""The rows of events: as JSON in a history's attributes and as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.errors import InputError
from oblique_impact.history.summary import parsed
from oblique_impact.marching.records import Event
from oblique_impact.scenario.messages import short

#: columns of an event's row, in SI units; the first seven are those of the contract of the file formats
EVENT_COLUMNS = (
    *("time", "kind", "normal_impulse", "normal_velocity", "tangential_velocity", "energy_loss", "state"),
    *("tangential_impulse", "peak_force", "peak_energy"),
)


def event_row(event: Event) -> list[Any]:
    """Return an event in the order of `EVENT_COLUMNS`; kind and state by their names."""
    words = {"kind": event.kind.value, "state": event.state.name.lower()}
    return [words.get(name) or float(getattr(event, name)) for name in EVENT_COLUMNS]


def read_events(text: str, first: float, last: float) -> list[Event]:
    """Return the events of a run from `first` to `last` (s); raises InputError for a text that holds none."""
    events = [_event_of(row) for row in parsed(text, "events", list[list[Any]])]
    times = [first, *(event.time for event in events), last]
    if not all(earlier <= later for earlier, later in pairwise(times)):
        raise InputError(f"attribute events: times should be ascending, from {first:g} to {last:g} s")
    return events


def _event_of(row: list[Any]) -> Event:
    try:
        given = dict(zip(EVENT_COLUMNS, row, strict=True))
        kind, state = EventKind(given.pop("kind")), State[given.pop("state").upper()]
        return Event(kind=kind, state=state, **{name: float(value) for name, value in given.items()})
    except (TypeError, ValueError, KeyError, AttributeError, OverflowError):
        raise InputError(f"attribute events: {short(row)} is not an event") from None


def events_csv(events: Sequence[Event]) -> str:
    """Return the event log as CSV text; numbers have all their digits."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(EVENT_COLUMNS)
    writer.writerows(map(event_row, events))
    return buffer.getvalue()

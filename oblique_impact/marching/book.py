"""The book of contacts: what each has given and taken from its start to its end, whatever the scheme."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np

from oblique_impact.contact.impacts import Impulse
from oblique_impact.contact.log import Contact, Event
from oblique_impact.contact.pairs import ContactPair
from oblique_impact.contact.state import State
from oblique_impact.contact.stops import ContactLaw
from oblique_impact.contact.transitions import EventKind
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.equations import FRICTION_LOSS, NORMAL_IMPULSE, STOP_LOSS, TANGENTIAL_IMPULSE
from oblique_impact.marching.sampling import Observation
from oblique_impact.marching.step_log import Counted


@dataclass
class OpenContact:
    """A contact that is still closed."""

    start: float
    number: int  # of the event that it began with
    impulse: Impulse  # of its impacts
    own: Array  # (5,) its integrals at its start
    compliance: float = 0.0  # m/N, of the body, in series with a compliant stop
    places: tuple[float, float] = (0.0, 0.0)  # m along the beam, from where to where it has been
    peak_force: float = 0.0
    depth: float = 0.0  # m

    def press(self, force: float, depth: float) -> None:
        """Take a normal force (N) and a depth (m) that may be the largest."""
        self.peak_force, self.depth = max(self.peak_force, force), max(self.depth, depth)

    def visit(self, place: float) -> None:
        """Take a place (m) where the contact has been."""
        self.places = min(self.places[0], place), max(self.places[1], place)

    def closed(self, end: float, own: Array, law: ContactLaw | None) -> tuple[Contact, Contact]:
        """Return the contact that ends at `end`, and the share of its finite force."""
        gained = own - self.own
        normal, tangential = float(gained[NORMAL_IMPULSE]), float(gained[TANGENTIAL_IMPULSE])
        stored = law.peak_energy(self.depth, self.peak_force, self.compliance) if law else 0.0
        loss = float(gained[FRICTION_LOSS] + gained[STOP_LOSS])
        finite = Contact(self.start, end, normal, tangential, self.peak_force, stored, loss, self.compliance)
        whole = finite._replace(
            normal_impulse=normal + self.impulse.normal,
            tangential_impulse=tangential + self.impulse.tangential,
            energy_loss=loss + self.impulse.energy_loss,
            first_place=self.places[0],
            last_place=self.places[1],
        )
        return whole, finite


class Book:
    """The book of a run.

    Parameters
    ----------
    pairs : sequence of ContactPair
        The candidates, which may close.
    events, contacts : list
        Of the record of the run, to be written.
    """

    def __init__(self, pairs: Sequence[ContactPair], events: list[Event], contacts: list[Contact]) -> None:
        self._pairs, self._events, self._contacts = pairs, events, contacts
        self.open: dict[int, OpenContact] = {}

    def copy_open(self) -> dict[int, OpenContact]:
        """Return a copy of what is known of the contacts that are closed."""
        return {i: copy(opened) for i, opened in self.open.items()}

    def enter(self, contact: int, event: Event, slip: float, own: Array, compliance: float = 0.0) -> None:
        """Enter an event, which may open its contact, or close it: then it gets the share of the finite force.

        `slip` (m) and `own` (5,), the integrals of the contact, are those there; `compliance` (m/N) is the body's.
        """
        place = self._pairs[contact].place(slip)
        event = event._replace(obstacle=self._pairs[contact].obstacle, place=place)
        free, opened = event.state == State.FREE, self.open.get(contact)
        impulse = Impulse(event.normal_impulse, event.tangential_impulse, event.energy_loss)
        if opened is None and (event.kind is EventKind.REBOUND or not free or event.kind is EventKind.IMPACT):
            opened = OpenContact(event.time, len(self._events), impulse, own, compliance, (place, place))
            self.open[contact] = opened
        elif opened is not None and event.kind.impulsive:
            opened.impulse = Impulse(*(a + b for a, b in zip(opened.impulse, impulse, strict=True)))
        if opened is not None and free and event.kind is not EventKind.IMPACT:
            event = event.with_share(self.close(contact, event.time, own))
        self._events.append(event)

    def close(self, contact: int, end: float, own: Array) -> Contact:
        """Close a contact at a time (s) with its integrals (5,) there; returns the share of its finite force."""
        opened, pair = self.open.pop(contact), self._pairs[contact]
        whole, finite = opened.closed(end, own, pair.contact_law)
        self._contacts.append(whole._replace(obstacle=self._pairs[contact].obstacle))
        return finite

    def press(self, contact: int, force: float, depth: float) -> None:
        """Take a normal force (N) and a depth (m) of a contact, if it is closed."""
        if contact in self.open:
            self.open[contact].press(force, depth)

    def visit(self, contact: int, slip: float) -> None:
        """Take a slip (m) of a contact, if it is closed."""
        if contact in self.open:
            self.open[contact].visit(self._pairs[contact].place(slip))

    def observe(self, found: Observation) -> None:
        """Take the samples of a phase: forces, depths and places of the contacts that are closed."""
        for i in self.open:
            gap, slip = found.column("gap")[:, i], found.column("slip")[:, i]
            self.press(i, float(np.fmax.reduce(found.column("lambda_n")[:, i])), float(np.fmax.reduce(-gap)))
            self.visit(i, float(slip.min()))
            self.visit(i, float(slip.max()))

    def count(self, contact: int, counted: Counted) -> None:
        """Take what steps have counted of a closed contact: the event that it began with gets their impact."""
        opened, impact = self.open[contact], counted.impact
        opened.impulse = impact
        self._events[opened.number] = self._events[opened.number]._replace(
            normal_impulse=impact.normal, tangential_impulse=impact.tangential, energy_loss=impact.energy_loss
        )
        self.press(contact, counted.peak_force, 0.0)
        for slip in counted.slips:
            self.visit(contact, slip)

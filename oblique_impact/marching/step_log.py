"""What steps that decide contact states themselves tell the loop: changes of states, and counts of contacts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.complementarity import BACKWARDS, FORWARDS, OPEN, STUCK
from oblique_impact.contact.impacts import Impulse
from oblique_impact.contact.log import Event
from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.equations import OF_A_CONTACT

#: what is counted of a contact while it is closed: steps, impulses (N s) of the steps that are its impact, energy
#: (J) lost in plastic impact, largest force (N) after these steps, least and largest slip (m); and the energy (J)
#: that its stop holds, with its part of what the body does, and the compression (m) of the stop
STEPS, IMPACT_NORMAL, IMPACT_TANGENTIAL, PLASTIC_LOSS, PEAK, LEAST, MOST, HELD, COMPRESSED = range(9)
COUNTED = 9
#: columns of the log, before what is counted: time (s) and that at the end of the step, contact, state before and
#: after, slip, gap rate before and slip rate after the step, and the integrals of the contact before the step
TIME, STEP_END, CONTACT, BEFORE, AFTER, AT_SLIP, CLOSING_RATE, SLIPPING_RATE, OWN = range(9)
LOGGED = OWN + OF_A_CONTACT

_STATES = {BACKWARDS: State.SLIP, OPEN: State.FREE, FORWARDS: State.SLIP, STUCK: State.STICK}


class Counted(NamedTuple):
    """What is counted of a contact while it is closed."""

    impact: Impulse  # of the steps that close it, with the energy (J) that they and all later normal impulses take
    peak_force: float  # N, after these steps
    slips: tuple[float, float]  # m, the least and the largest

    @classmethod
    def of(cls, row: Array) -> Counted:
        """Return what a row of counts tells."""
        steps = [float(value) for value in row]
        impact = Impulse(steps[IMPACT_NORMAL], steps[IMPACT_TANGENTIAL], steps[PLASTIC_LOSS])
        return cls(impact, steps[PEAK], (steps[LEAST], steps[MOST]))


class LoggedChange(NamedTuple):
    """A change of a contact's state in a step."""

    contact: int
    step_end: float  # s, from which on samples have the state after it
    event: Event  # without impulses, obstacle and place
    slip: float  # m
    own: Array  # (5,) the integrals of the contact before the step
    counted: Counted  # before the step

    @classmethod
    def of(cls, row: Array) -> LoggedChange:
        """Return the change of a row of the log."""
        before, after = int(row[BEFORE]), int(row[AFTER])
        kind = EventKind.REVERSAL
        if before == OPEN:
            kind = EventKind.IMPACT
        elif after == OPEN:
            kind = EventKind.RELEASE
        elif STUCK in (before, after):
            kind = EventKind.STICK if after == STUCK else EventKind.SLIP
        time, slip, closing, slipping = (float(row[k]) for k in (TIME, AT_SLIP, CLOSING_RATE, SLIPPING_RATE))
        event = Event(time, kind, 0.0, 0.0, closing, slipping, 0.0, _STATES[after])
        own, counted = row[OWN:LOGGED].copy(), Counted.of(row[LOGGED:])
        return cls(int(row[CONTACT]), float(row[STEP_END]), event, slip, own, counted)


class StepLog:
    """The changes of a call, and states and counts of n contacts, which are the last entries of a state vector."""

    def __init__(self, rows: Array, logged: Sequence[int], n: int) -> None:
        self._rows, self._logged, self._n = rows, logged, n

    def changes(self) -> list[LoggedChange]:
        """Return the changes of the last call, in order of time."""
        return [LoggedChange.of(row) for row in self._rows[: self._logged[0]]]

    def states(self, y: Array) -> NDArray[np.int8]:
        """Return the states of all contacts, (samples, n) of state vectors (samples, ny)."""
        codes = y[:, -(1 + COUNTED) * self._n :][:, : self._n]
        found = np.full(codes.shape, int(State.FREE), dtype=np.int8)
        for code, state in _STATES.items():
            found[codes == code] = int(state)
        return found

    def lengths(self, y: Array) -> Array:
        """Return the lengths (s) of the steps that end at state vectors (samples, ny), 0 if none does."""
        return np.nan_to_num(y[:, -(1 + COUNTED) * self._n - 1])

    def held(self, y: Array) -> Array:
        """Return the energy (J) that stops and body hold, (samples,)."""
        return np.asarray(y[:, -COUNTED * self._n :][:, HELD::COUNTED].sum(axis=1))

    def compressed(self, y: Array) -> Array:
        """Return the largest compression (m) of a stop, (samples,)."""
        return np.asarray(y[:, -COUNTED * self._n :][:, COMPRESSED::COUNTED].max(axis=1))

    def counted(self, y: Array, contact: int) -> Counted:
        """Return what a state vector (ny,) has counted of a closed contact."""
        return Counted.of(y[-COUNTED * self._n :].reshape(-1, COUNTED)[contact])

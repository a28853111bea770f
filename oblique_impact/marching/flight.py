"""Long steps of time-stepping in flight, as long as the motion and the nearest obstacle allow.

The mid-point rule errs in a step of length h by h^3/12 times the second derivative of the acceleration.  Three
steps tell that: the mean accelerations of two of them foresee that of the third, and where its iterations begin
with it, their first correction, in the energy norm that they have anyway, is what was not foreseen,

    a - a' = s (s + s') a''/2,    s, s' the times between the middles of the steps

The error of a vibration of the frequency w with the velocity v, sqrt(v.M v) at its largest, grows by (w h)^3/12 v
in a step.  Steps are doubled as long as they err no more in a second than steps of the given length do in the
slowest vibration with a tenth of the energy of the motion, at its fastest so far; and halved where they err more,
down to that length.

No place may come near its obstacle inside a long step: by twice its speed at the start, and by the speeds and
distances at both ends once the step is known.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.state import Contacts
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.workspace import PRODUCT_A, Array, Workspace, copy, dot
from oblique_impact.marching.advance import Limits
from oblique_impact.marching.buffers import NEXT, OutputSamples, new_sample

ROOM, SPEED = 0, 1
LATEST, BEFORE = 0, 1
#: of the error that is allowed: below it a step of twice the length, with four times the error, has half of it
EASY = 0.125
_PART_OF_ENERGY = 0.1
_CLEAR = 2.0  # steps are to stay so many times the way of the fastest place from any obstacle
_PART_OF_SAMPLES = 0.45  # of their buffer, that one step may fill


class Flight(NamedTuple):
    """The last two steps in flight, and where the places are."""

    accelerations: Array  # (2, d) means of the last step and of the one before
    lengths: Array  # (2,) s, of these; 0: it was not in flight
    nearest: Array  # (2,) smallest distance (m) of a place to its obstacle and the largest speed (m/s) there
    change: Array  # (1,) J^1/2, first correction of an acceleration that was foreseen; inf: it was not
    fastest: Array  # (1,) J^1/2, sqrt(v.M v) of the fastest motion so far
    rate: float  # 1/s, error of the longer steps in a second, as a part of that

    @classmethod
    def new(cls, size: int, frequency: float, step: float) -> Flight:
        """Allocate them for `size` degrees of freedom.

        The error is that of this step (s) in a vibration of this frequency (rad/s).
        """
        rate = frequency * (frequency * step) ** 2 / 12.0 * np.sqrt(_PART_OF_ENERGY)
        return cls(np.zeros((2, size)), np.zeros(2), np.zeros(2), np.full(1, np.inf), np.zeros(1), float(rate))


@jitable
def begin_again(flight: Flight | None) -> None:
    """Begin with short steps: the root or a force may move in another way from here on."""
    if flight is None:
        return
    flight.lengths[LATEST] = flight.lengths[BEFORE] = 0.0


@jitable
def look_around(flight: Flight | None, contacts: Contacts) -> None:
    """Take the distance to the nearest obstacle and the largest speed of a place, wherever it is.

    Past an end of a side, or behind it, a place is as far away as its end or its line.
    """
    if flight is None:
        return
    room, speed = 1e300, 0.0
    for i in range(len(contacts.each)):
        c = contacts.each[i]
        if c.enabled:
            beyond = max(c.first - c.slip, c.slip - c.last, 0.0)
            room = min(room, c.gap * c.gap + beyond * beyond)
            speed = max(speed, c.gap_rate * c.gap_rate + c.slip_rate * c.slip_rate)
    flight.nearest[ROOM], flight.nearest[SPEED] = np.sqrt(room), np.sqrt(speed)


@jitable
def foresee(flight: Flight | None, h: float, v0: Array, v1: Array) -> bool:
    """Begin the iterations of a step of length h with the acceleration that the last two steps foresee, if any."""
    if flight is None:
        return False
    lengths, a = flight.lengths, flight.accelerations
    if lengths[BEFORE] == 0.0:
        return False
    further = (h + lengths[LATEST]) / (lengths[LATEST] + lengths[BEFORE])
    for j in range(v0.shape[0]):
        v1[j] = v0[j] + h * (a[LATEST, j] + further * (a[LATEST, j] - a[BEFORE, j]))
    return True


@jitable
def take_change(flight: Flight | None, change: float) -> None:
    """Take the first correction (J^1/2) of an acceleration that was foreseen, or infinity."""
    if flight is None:
        return
    flight.change[0] = change


@jitable
def error_of(flight: Flight, h: float) -> float:
    """Error of a step of length h over what is allowed; infinite if nothing was foreseen."""
    last, span = h + flight.lengths[LATEST], flight.lengths[LATEST] + flight.lengths[BEFORE]
    allowed = flight.rate * flight.fastest[0] * last * (last + span)
    return float(flight.change[0] * h * 8.0 / (12.0 * allowed)) if allowed > 0.0 else np.inf


@jitable
def length_of_flight(
    flight: Flight | None, h: float, least: float, near: float, limits: Limits, room: int
) -> float:
    """Length (s) of the next step in flight, at most h, at which no place comes as near as `near` (m).

    It is at least `least`; one step may keep `room` samples.
    """
    if flight is None or flight.lengths[BEFORE] == 0.0:
        return least
    most = _PART_OF_SAMPLES * room * limits.interval
    while h > least and (h > most or _CLEAR * h * flight.nearest[SPEED] > flight.nearest[ROOM] - near):
        h *= 0.5
    return max(h, least)


@jitable
def follow(flight: Flight | None, system: Any, h: float, acceleration: Array, v: Array, w: Workspace) -> float:
    """Follow a step in flight that ends with velocities v; its error over what is allowed."""
    if flight is None:
        return np.inf
    # but for the part of the mass matrix that bending has
    system.mass_product(0.0, w, v, w.vectors[PRODUCT_A])
    flight.fastest[0] = max(flight.fastest[0], np.sqrt(abs(dot(v, w.vectors[PRODUCT_A]))))
    error = error_of(flight, h)
    copy(flight.accelerations[LATEST], flight.accelerations[BEFORE])
    copy(acceleration, flight.accelerations[LATEST])
    flight.lengths[BEFORE] = flight.lengths[LATEST]
    flight.lengths[LATEST] = h
    return error


@jitable
def keep_samples(
    flight: Flight, t: float, h: float, y: Array, y_new: Array, own: int, limits: Limits, samples: OutputSamples
) -> None:
    """Keep the samples inside of a step of length h from (t, y) to `y_new`, of two steps in flight the latest.

    The acceleration goes on as it has since the step before; velocities and coordinates follow from it and from
    both ends.  It is behind the first `own` entries of a state, and at the end of the step that of the end.
    """
    d, a = flight.accelerations.shape[1], flight.accelerations
    change = 2.0 * h / (flight.lengths[LATEST] + flight.lengths[BEFORE])  # of the acceleration in the step
    for j in range(d):
        y_new[own + j] = a[LATEST, j] + 0.5 * change * (a[LATEST, j] - a[BEFORE, j])
    while samples.counts[NEXT] * limits.interval < (t + h) * (1.0 - 1e-12):
        time = samples.counts[NEXT] * limits.interval
        state, s = samples.states[new_sample(time, samples)], (time - t) / h
        copy(y_new, state)
        for k in range(2 * d, own):
            state[k] = y[k] + s * (y_new[k] - y[k])
        for j in range(d):
            more, v0 = change * (a[LATEST, j] - a[BEFORE, j]), y[d + j]
            state[own + j] = a[LATEST, j] + (s - 0.5) * more
            state[d + j] = v0 + h * s * (a[LATEST, j] + 0.5 * (s - 1.0) * more)
            rounded = (s - 1.0) * (2.0 * s - 1.0) / 12.0 * more
            state[j] = y[j] + h * s * (v0 + h * (0.5 * s * a[LATEST, j] + rounded))

"""The start of a run from a given state of the beam: coordinates, the sides of pegs, contacts that are closed."""

from __future__ import annotations

import cmath
from typing import Any

import numpy as np

from oblique_impact.beam.beam import Beam, ContactPlace
from oblique_impact.beam.section_forces import bent_beam
from oblique_impact.contact.state import FREE
from oblique_impact.contact.transitions import Earlier
from oblique_impact.errors import InputError
from oblique_impact.history.history import History
from oblique_impact.kernels.workspace import Array
from oblique_impact.scenario.polylines import Outline

#: of the beam's length: a beam that is as close to a point as this does not say on which side of it it is
_TOUCHING = 1e-9
_FINE = 4001  # places of the axis from which the nearest to a point is sought
_REFINED = 3
#: over the depth of a point in a solid, that in the line of a side up to which it is pressed into this
_PRESSED = 2.0


def begin_at(
    beam: Beam, initial_state: History | tuple[Array, Array], keeps_sides: bool = False
) -> tuple[Array, Array, dict[int, Earlier]]:
    """Return coordinates and velocities that are marched, and the contacts that an earlier run has left closed.

    The points that the beam can touch get the sides on which it is of them: before its model is built.  Those of a
    beam that `keeps_sides` are the scenario's, unless a history knows them: coordinates alone do not say whether
    it is pressed past a point or behind it.

    Raises
    ------
    InputError
        For a state of the wrong shape, or a history of a beam with other contacts.
    """
    q0, qd0 = beam.state_of(*_pair(initial_state))
    history = initial_state if isinstance(initial_state, History) else None
    found, wanted = history.data.sizes["contact"] if history else len(beam.candidates), len(beam.candidates)
    if found != wanted:
        raise InputError(
            f"initial_state: a history with {found} places of contact, should have {wanted}; give its q and qd"
        )
    beam.candidates = _on_their_sides(beam, beam.split(q0), history, keeps_sides)
    return q0, qd0, {} if history is None else _closed(beam, history)


def _pair(initial_state: History | tuple[Array, Array]) -> tuple[Array, Array]:
    """Return coordinates and velocities of an initial state."""
    if isinstance(initial_state, History):
        return initial_state["q"].values[-1], initial_state["qd"].values[-1]
    return initial_state


def _closed(beam: Beam, history: History) -> dict[int, Earlier]:
    """Return the contacts that are closed at the end of a history, by their numbers."""
    columns = (history[f"contact_{name}"].values for name in ("state", "lambda_n", "lambda_tau", "slip"))
    states, normal, tangential, slips = columns
    found: dict[int, Earlier] = {}
    for i in np.flatnonzero(states[-1] != FREE).tolist():
        before = np.flatnonzero(states[:, i] == FREE)
        began = int(before[-1]) if before.size else 0  # the left sample of its impact
        forces = float(np.nan_to_num(normal[-1, i])), float(np.nan_to_num(tangential[-1, i]))
        found[i] = Earlier(int(states[-1, i]), *forces, float(slips[began, i]))
    return found


def _on_their_sides(beam: Beam, start: Array, history: History | None, keeps_sides: bool) -> list[ContactPlace]:
    """Return the places of contact with the sides of points from the state [theta, B] that a run starts with.

    A history has them in its contact forces, also where the beam is pressed past a point.
    """
    found = list[ContactPlace]()
    axis = _BentAxis(beam, start)
    for i, place in enumerate(beam.candidates):
        if place.on_side:
            outline = beam.scenario.outlines.get(place.obstacle)
            closed = history is not None and history["contact_state"].values[-1, i] != FREE
            found.append(
                place._replace(behind=outline is not None and not closed and axis.is_behind(place, outline))
            )
            continue
        x, y, _, _, side, spare = place.numbers
        at, height = axis.nearest(x, y)
        if not keeps_sides and abs(height) > _TOUCHING * beam.scenario.beam.length:
            side = float(np.sign(height))
        if history is not None:
            side = _side_in(history, i) or side
        depth = beam.scenario.half_depth_at(at)
        found.append(place._replace(numbers=(x, y, place.radius + depth, depth, side, spare)))
    return found


def _side_in(history: History, contact: int) -> float:
    """Return the side of a point on which a beam has touched it, 0 if it never has.

    The force is i s t lambda_n + t lambda_tau with the tangent t, which points away from the root.
    """
    names = ("lambda_n", "lambda_tau", "fx", "fy")
    columns = (np.nan_to_num(history[f"contact_{name}"].values[:, contact]) for name in names)
    normal, tangential, fx, fy = columns
    k = int(np.argmax(normal))
    if not normal[k] > 0.0:
        return 0.0
    ahead = np.exp(1j * float(history["theta"][k]))
    tangents = {side: (fx[k] + 1j * fy[k]) / (tangential[k] + 1j * side * normal[k]) for side in (1.0, -1.0)}
    return max(tangents, key=lambda side: (tangents[side] / ahead).real)


class _BentAxis:
    """The bent axis in a state [theta, B] (n + 1,)."""

    def __init__(self, beam: Beam, q: Array) -> None:
        from scipy.interpolate import CubicSpline  # a quarter of a second, for which other runs do not wait

        x = beam.operators.stations.points
        self._length = float(x[-1])
        self._places = CubicSpline(x, bent_beam(beam, q[None], np.zeros_like(q)[None]).point()[0])

    def is_behind(self, place: ContactPlace, outline: Outline) -> bool:
        """Return whether a point of the beam is behind the line of a side of an outline, not pressed into it.

        One that is in the solid is pressed into the sides that are about as near as its boundary is.
        """
        at, angle, height, _, fibre, _ = place.numbers
        z = complex(self._places(at))
        gap = (z * cmath.exp(-1j * angle)).imag - height - abs(fibre)
        inside = abs(fibre) - float(outline.distance(z))
        return gap < -_TOUCHING * self._length and not -gap <= _PRESSED * inside

    def nearest(self, x: float, y: float) -> tuple[float, float]:
        """Return the place (m along the beam) nearest to a point, and its height (m) to the left of the point."""
        at = np.linspace(0.0, self._length, _FINE)
        near = float(at[np.argmin(np.abs(self._places(at) - (x + 1j * y)))])
        for _ in range(_REFINED):
            tangent, away = complex(self._places(near, 1)), complex(self._places(near)) - (x + 1j * y)
            near -= float((away * tangent.conjugate()).real / abs(tangent) ** 2)
            near = min(max(near, 0.0), self._length)
        tangent = complex(self._places(near, 1))
        away = complex(self._places(near)) - (x + 1j * y)
        return near, float((away * tangent.conjugate()).imag / abs(tangent))


def as_lists(initial_state: History | tuple[Array, Array]) -> list[Any]:
    """Return the coordinates and velocities of an initial state as lists, for the provenance of a run."""
    return [np.asarray(part).tolist() for part in _pair(initial_state)]

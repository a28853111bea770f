"""Places along the beam that touch, over time: bars in the colour of the force, hatched where they stick."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, PowerNorm
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from numpy.typing import NDArray

from oblique_impact.contact.state import State
from oblique_impact.errors import InputError
from oblique_impact.history.history import History
from oblique_impact.renders.story import round_up
from oblique_impact.renders.style import LIGHT, Theme

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

_SHADES = 24  # of the force: bars of one shade are one path
_COLUMNS = 1000  # of the shown time: what is shorter is drawn with what stands beside it
_LEAST, _MOST = 0.004, 1 / 64  # half of the height of a bar, over the length of the beam
_BRIEF = 50
#: over the length: a contact that is as close to the places of another is it, the closer the more samples it has
_NEAR, _SAME = 1e-3, 1e-9
_HATCH = "//////"


class Pieces(NamedTuple):
    """Contacts cut where their force is known, (pieces,) each."""

    contact: Integers  # number of the contact in `History.contacts`
    start: Array  # s
    end: Array  # s
    place: Array  # m along the beam
    force: Array  # N, normal, the mean between start and end
    stuck: NDArray[np.bool_]


def contact_pieces(history: History) -> Pieces:
    """Cut the contacts of a run half way between its samples.

    Contacts begin and end with their events, whatever the samples.  One without a sample inside has its impulse
    over its time as force; that of an impact alone is infinite.
    """
    names = ("time", "contact_state", "contact_place", "contact_lambda_n")
    times, states, places, forces = (history[name].values for name in names)
    rows = list[tuple[int, float, float, float, float, bool]]()
    for number, contact in enumerate(history.contacts):
        start, end = contact.start, contact.end
        inside, i = closed_samples(history, number)
        if not inside.size:
            place = 0.5 * (contact.first_place + contact.last_place)
            force = contact.normal_impulse / (end - start) if end > start else np.inf
            rows.append((number, start, end, place, force, False))
            continue
        edges = [start, *(0.5 * (times[inside[1:]] + times[inside[:-1]])), end]
        samples = places[inside, i], forces[inside, i], states[inside, i] == State.STICK
        rows += zip([number] * inside.size, edges[:-1], edges[1:], *samples, strict=True)
    columns = zip(*rows, strict=True) if rows else [()] * 6
    return Pieces(*(np.array(c, t) for c, t in zip(columns, (int, float, float, float, float, bool), strict=True)))


def closed_samples(history: History, number: int) -> tuple[Integers, int]:
    """Return the samples of a contact, ascending, and the number of its column in the history.

    There is no sample of one that is an impact alone.
    """
    assert history.scenario is not None
    contact = history.contacts[number]
    length, times, places = history.scenario.beam.length, history["time"].values, history["contact_place"].values
    inside = np.arange(*np.searchsorted(times, (contact.start, np.nextafter(contact.end, np.inf))))
    closed = history["contact_state"].values[inside] != State.FREE
    closed &= history["contact_obstacle"].values == contact.obstacle
    # which of those that are closed it is, its places say
    away = np.abs(places[inside] - np.clip(places[inside], contact.first_place, contact.last_place))
    away = np.where(closed, away, np.inf).min(axis=0, initial=np.inf)
    i = int(np.argmin(away / length - _SAME * closed.sum(axis=0)))
    return inside[closed[:, i] & (away[i] <= _NEAR * length)], i


def draw_contact_map(
    axes: Axes,
    history: History,
    theme: Theme = LIGHT,
    between: tuple[float, float] | None = None,
    at: Callable[[Array], Array] | None = None,
) -> ScalarMappable:
    """Draw where along the beam contacts are closed over time; returns the scale of colours of their force (N).

    A place on a side is as high as the part of `contact.grid` around it, so that places side by side are one area;
    the root of the force is proportional to the shade.  What sticks is hatched.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Gets the whole beam as its ordinate (m), and time (ms) if nothing else is said.
    history : History
        One of a beam.
    theme : Theme
        Colours.
    between : tuple of float, optional
        First and last time (s) that are shown; default: the contacts of the run.
    at : callable, optional
        Where on the axes times (s) are, (n,) to (n,); ascending.

    Raises InputError for a history of another kind.
    """
    if history.scenario is None:
        raise InputError("history: it is not one of a beam")
    pieces, length = contact_pieces(history), history.scenario.beam.length
    if between is None:
        ends = [*pieces.start, *pieces.end] or history["time"].values
        room = 0.03 * float(np.ptp(ends)) or 1e-3
        between = float(np.min(ends)) - room, float(np.max(ends)) + room
    at = at or (lambda times: 1e3 * times)
    left, right = at(np.array(between)).tolist()
    shown = (pieces.end >= between[0]) & (pieces.start <= between[1])
    columns: Any = (column[shown] for column in pieces)
    pieces = Pieces(*columns)
    x = at(np.concatenate([pieces.start, pieces.end])).reshape(2, -1)
    # from what can be told from the paper to what a hatch can be told from
    ramp = mpl.colormaps[theme.force_map](np.linspace(0.22, 0.86, _SHADES))
    limit = round_up(_exceeded_briefly(pieces.force, x[1] - x[0]))
    colours: Any = LinearSegmentedColormap.from_list("force", ramp)
    colours.colorbar_extend = "max" if pieces.force.max(initial=0.0) > limit else "neither"
    scale = ScalarMappable(PowerNorm(0.5, 0.0, limit), colours)

    def shades() -> Array:
        return np.asarray(np.rint((_SHADES - 1) * np.clip(scale.norm(pieces.force), 0.0, 1.0)))

    # bars of what lies in one column, then of what has one shade
    pieces, x = _joined(pieces, x, np.floor(_COLUMNS * (x.mean(axis=0) - left) / (right - left)))
    pieces, x = _joined(pieces, x, shades())
    shade = shades()
    parts = history.scenario.contact.grid if history.scenario.sides else 1
    half = length * float(np.clip(0.5 / parts, _LEAST, _MOST))
    bars = [x[0], x[1], pieces.place - half, pieces.place + half]
    for number, colour in enumerate(ramp):
        axes.add_patch(PathPatch(_outline(bars, shade == number), color=colour, linewidth=0.5))
    axes.add_patch(
        PathPatch(_outline(bars, pieces.stuck), fill=False, edgecolor=theme.ink, linewidth=0.0, hatch=_HATCH)
    )
    axes.set(xlim=(left, right), ylim=(0.0, length + 2.0 * half))
    return scale


def _exceeded_briefly(force: Array, widths: Array) -> float:
    """Return the force (N) of all but one part in `_BRIEF` of what is shown: a peak would pale the rest."""
    finite = np.isfinite(force)
    if not finite.any():
        return 0.0
    order = np.argsort(force[finite])
    passed = np.cumsum(widths[finite][order])
    return float(force[finite][order][np.searchsorted(passed, (1.0 - 1.0 / _BRIEF) * passed[-1])])


def _joined(pieces: Pieces, x: Array, key: Array) -> tuple[Pieces, Array]:
    """Return pieces, and their ends (2, pieces) on the axes, in which those in a row with one key are one."""
    if not pieces.start.size:
        return pieces, x
    same = np.stack([pieces.contact, pieces.stuck, key])
    first = np.flatnonzero(np.append(True, np.any(same[:, 1:] != same[:, :-1], axis=0)))
    last = np.append(first[1:], key.size) - 1
    time = np.maximum(pieces.end - pieces.start, np.finfo(float).tiny)

    def mean(values: Array) -> Array:
        return np.asarray(np.add.reduceat(time * values, first) / np.add.reduceat(time, first))

    place, force = mean(pieces.place), mean(pieces.force)
    joined = Pieces(
        pieces.contact[first], pieces.start[first], pieces.end[last], place, force, pieces.stuck[first]
    )
    return joined, np.stack([x[0, first], x[1, last]])


def _outline(bars: list[Array], chosen: NDArray[np.bool_]) -> Path:
    """Return some bars, of left, right, low and high ends (bars,) each, as one path."""
    left, right, low, high = (ends[chosen] for ends in bars)
    corners = np.stack([[left, low], [right, low], [right, high], [left, high], [left, low]]).transpose(2, 0, 1)
    codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY]
    return Path(corners.reshape(-1, 2), np.tile(codes, len(corners)))

"""Outlines: chains of straight sides, open ones or the whole boundary of a solid, which lies on their right.

An outline is made of what the beam can touch anyway: each piece is a side with ends, each vertex that stands out
of the solid a corner.  Where two sides meet in a hollow there is no corner: both go on into the solid there, so
that no place of the beam slips out between them.  Points are complex numbers here, z = x + i y (m).
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import InputError
from oblique_impact.files import read_text
from oblique_impact.scenario.messages import short
from oblique_impact.scenario.obstacles import Side

MAX_POINTS = 1000
#: over the size of an outline: points that are so close are the same, pieces that turn by less are one
_SAME = 1e-12
#: over the length of a way, how far beside a place where it meets an outline it is looked on which side it is
_BESIDE = 1e-9
_MAX_FILE = 1_000_000  # bytes

Pairs = tuple[tuple[float, float], ...]
Places = NDArray[np.complex128]


class Outline:
    """A chain of straight sides, solid on its right; a solid if its last point is its first one.

    Parameters
    ----------
    points : sequence of (x, y)
        m, at least two.
    origin : tuple of float
        m, where the point (0, 0) is.
    angle : float
        rad, by which the points are turned about it.
    """

    def __init__(
        self, points: Sequence[tuple[float, float]], origin: tuple[float, float] = (0.0, 0.0), angle: float = 0.0
    ) -> None:
        own = np.array([complex(x, y) for x, y in points])
        self.is_closed = bool(own[0] == own[-1])
        self.points: Places = complex(*origin) + cmath.exp(1j * angle) * _without_straight(own, self.is_closed)

    @cached_property
    def _pieces(self) -> Places:
        return np.diff(self.points)

    @property
    def turns(self) -> NDArray[np.float64]:
        """Angle (rad) by which it turns at each point, to the left in a hollow; NaN at ends of an open one."""
        before, after = np.roll(self._pieces, 1), self._pieces
        found: NDArray[np.float64] = np.append(np.angle(after / before), np.nan)
        found[-1 if self.is_closed else 0] = found[0] if self.is_closed else np.nan
        return found

    @property
    def parts(self) -> int:
        """How many parts without hollows it has."""
        hollows = int((self.turns[:-1] > 0.0).sum())
        return max(1, hollows) if self.is_closed else 1 + hollows

    def sides(self, obstacle: int, stiffness: float, bedding: float = 0.0) -> list[Side]:
        """Return its sides, each with the corners that are its own: a vertex is one of the next side."""
        stands_out, lengths = ~(self.turns >= 0.0), np.abs(self._pieces)  # or is an end
        last, found = len(lengths) - 1, list[Side]()
        for k, (begin, piece) in enumerate(zip(self.points[:-1], self._pieces, strict=True)):
            has_end = k == last and not self.is_closed
            hollow = ~stands_out[k : k + 2] & (not bedding)
            reach = self._reach(k, -1) if hollow[0] else 0.0, self._reach(k, 1) if hollow[1] else 0.0
            found.append(
                Side(
                    obstacle,
                    (float(begin.real), float(begin.imag)),
                    float(np.angle(piece)),
                    (0.0, float(lengths[k])),
                    stiffness,
                    bedding,
                    (bool(stands_out[k]), has_end),
                    reach,
                )
            )
        return found

    def _reach(self, k: int, way: int) -> float:
        """Return how far (m) side k goes on into the solid from its beginning (way -1) or its end (1).

        That is half of the way to where it would leave the solid, and not farther than the side that it meets is
        long.
        """
        tangent = way * self._pieces[k] / abs(self._pieces[k])
        end = self.points[k + (way > 0)]
        meets = (k + way) % len(self._pieces)
        limit = float(abs(self._pieces[meets]))
        others = np.delete(np.arange(len(self._pieces)), [k, meets])
        across = (self._pieces[others] * tangent.conjugate()).imag
        start = (self.points[others] - end) * tangent.conjugate()
        with np.errstate(divide="ignore", invalid="ignore"):
            share = -start.imag / across
            away = start.real + share * (self._pieces[others] * tangent.conjugate()).real
        hit = (share >= 0.0) & (share <= 1.0) & (away > 0.0)
        return min(limit, 0.5 * float(away[hit].min(initial=math.inf)))

    def distance(self, z: Any) -> NDArray[np.float64]:
        """Return the distances (m) of points from it, negative inside of the solid.

        Beyond the ends of an open outline that from its end.
        """
        places = np.asarray(z, dtype=complex)
        nearest, found, upright = (np.full(places.shape, value) for value in (np.inf, np.inf, 0.0))
        last = len(self._pieces) - 1
        for k, (begin, piece) in enumerate(zip(self.points[:-1], self._pieces, strict=True)):
            length = abs(piece)
            local = (places - begin) * (piece.conjugate() / length)
            beside = np.clip(local.real, 0.0, length)
            away = np.abs(local - beside)
            past = (np.zeros(places.shape, dtype=bool)) if self.is_closed else _past(local.real, length, k, last)
            # of two pieces whose common vertex is nearest the one that sees it more from above says on which side
            height = np.abs(local.imag)
            rounding = _SAME * (length + away)
            closer = (away < nearest - rounding) | ((away <= nearest + rounding) & (height > upright))
            found = np.where(closer, np.where(past | (local.imag >= 0.0), away, -away), found)
            nearest, upright = np.minimum(nearest, away), np.where(closer, height, upright)
        return found

    def crossing(self, first: complex, last: complex) -> float | None:
        """Return the share of the way from one place to another where it first leads into the solid or out of it.

        A way along a side or past a corner does not, nor one that begins or ends on the outline; None: nowhere.
        """
        way = last - first
        pieces, start = self._pieces * way.conjugate(), (self.points[:-1] - first) * way.conjugate()
        with np.errstate(divide="ignore", invalid="ignore"):
            on = -start.imag / pieces.imag
            at = (start.real + on * pieces.real) / abs(way) ** 2
        meets = np.sort(at[(on >= -_BESIDE) & (on <= 1.0 + _BESIDE) & (at >= -_BESIDE) & (at <= 1.0 + _BESIDE)])
        for share in meets.tolist():
            beside = np.array([x for x in (share - _BESIDE, share + _BESIDE) if 0.0 < x < 1.0])
            if np.any(self.distance(first + beside * way) < -_SAME * abs(way)):
                return min(max(float(share), 0.0), 1.0)
        return None


@lru_cache(maxsize=256)
def outline_of(points: Pairs, origin: tuple[float, float], angle: float) -> Outline:
    """Return an outline, made once, see `Outline`."""
    return Outline(points, origin, angle)


def _past(along: NDArray[np.float64], length: float, k: int, last: int) -> NDArray[np.bool_]:
    """Return which places along piece k are past an end of an open outline."""
    return ((along < 0.0) & (k == 0)) | ((along > length) & (k == last))


def _without_straight(points: Places, closed: bool) -> Places:
    """Return points without those at which the outline goes straight on."""
    if closed:
        kept = _bends(points[-2], points[:-1], points[1])
        found = points[:-1][kept]
        return np.append(found, found[:1])
    kept = np.concatenate([[True], _bends(None, points, None), [True]])
    return np.asarray(points[kept])


def _bends(before: complex | None, points: Places, after: complex | None) -> NDArray[np.bool_]:
    """Return at which points there is a bend; without neighbours of the ends of those between them."""
    whole = points if before is None else np.concatenate([[before], points, [points[0]]])
    pieces = np.diff(whole)
    return np.abs(np.angle(pieces[1:] / pieces[:-1])) > _SAME


def check_points(points: Pairs) -> None:
    """Raise ValueError for points that are no outline: too few, repeated, crossing, wound the wrong way round."""
    if not 2 <= len(points) <= MAX_POINTS:
        raise ValueError(f"2 to {MAX_POINTS} points [x, y] in m, not {len(points)}")
    z = np.array([complex(x, y) for x, y in points])
    pieces, size = np.diff(z), float(np.max(np.abs(z - z[0])))
    for k in np.flatnonzero(np.abs(pieces) <= _SAME * size).tolist():
        raise ValueError(f"without a point twice in a row: points {k + 1} and {k + 2} are both {list(points[k])}")
    closed = bool(z[0] == z[-1])
    if closed and len(points) < 4:
        raise ValueError("of at least three different points if it is closed")
    if (pair := _first_crossing(z, closed)) is not None:
        k, j = pair
        raise ValueError(f"an outline that does not cross itself: its pieces {k + 1} and {j + 1} meet")
    area = 0.5 * float(np.sum((z[:-1].conjugate() * z[1:]).imag))
    if closed and area > 0.0:
        raise ValueError("clockwise if it is closed, its solid inside, on its right: reverse its points")


def _first_crossing(z: Places, closed: bool) -> tuple[int, int] | None:
    """Return two pieces that meet elsewhere than where one follows the other; None: there are none."""
    begins, pieces = z[:-1], np.diff(z)
    n = len(pieces)
    for k in range(n):
        j = (k + 1) % n
        turn = pieces[j] / pieces[k] if j or closed else 1.0
        if turn.real < 0.0 and abs(turn.imag) <= _SAME * abs(turn):  # it goes back where it came from
            return min(j, k), max(j, k)
        others = np.arange(k + 2, n - (1 if closed and k == 0 else 0))
        if others.size == 0:
            continue
        of = pieces[others] * pieces[k].conjugate() / abs(pieces[k])
        start = (begins[others] - begins[k]) * pieces[k].conjugate() / abs(pieces[k])
        end, rounding = start + of, _SAME * (np.abs(start) + np.abs(of))
        length = abs(pieces[k])
        straddles = (np.minimum(start.imag, end.imag) <= rounding) & (
            np.maximum(start.imag, end.imag) >= -rounding
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            at = start.real - start.imag * of.real / of.imag
        flat = np.abs(of.imag) <= rounding
        low, high = np.minimum(start.real, end.real), np.maximum(start.real, end.real)
        low, high = np.where(flat, low, at), np.where(flat, high, at)
        hit = straddles & (high >= -rounding) & (low <= length + rounding)
        if hit.any():
            return k, int(others[np.argmax(hit)])
    return None


def read_points(path: Path, what: str) -> list[list[float]]:
    """Read points from a file of comma-separated values x, y (m), with a line of names before them or without.

    Raises InputError in one line that begins with `what`.
    """
    try:
        lines = read_text(path, _MAX_FILE).splitlines()
    except (OSError, ValueError) as error:
        raise InputError(f"{what}: cannot be read: {error}") from None
    found = list[list[float]]()
    for number, line in enumerate(lines, start=1):
        text = line.strip()
        if not text or text.startswith("#"):
            continue
        try:
            x, y = (float(cell) for cell in text.split(","))
        except ValueError:
            if not found and not any(_is_number(cell) for cell in text.split(",")):
                continue  # the names of the columns
            raise InputError(f"{what}: line {number} is {short(text)}, should be two numbers x,y in m") from None
        found.append([x, y])
    return found


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def take_points(data: dict[str, Any], folder: Path, changed: Sequence[str]) -> None:
    """Replace `points` of obstacles that are paths, from `folder`, by those in the files, in data of a scenario.

    Paths of keys that were `changed` begin in the present folder.  Raises InputError as `read_points`.
    """
    items = data.get("obstacles")
    for number, item in enumerate(items if isinstance(items, list) else (), start=1):
        if isinstance(item, dict) and isinstance(item.get("points"), str):
            key, name = f"obstacles.{number}.points", item["points"]
            own = key in changed or "obstacles" in changed
            item["points"] = read_points((Path() if own else folder) / name, f"{key} = {short(name)}")

"""Section forces at instants of a run, from the mean forces of the steps around them.

The mid-point rule turns the sign of a vibration that it does not resolve from step to step, so that strains at
the ends of steps alternate about what they should be; their mean over a step is right to the second order of its
length.  Within a smooth stretch of a run the mean forces belong to the middles of their steps, and between these
they are linear; where forces may jump a stretch ends, and its last and first forces are extrapolated.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

from oblique_impact.fem_beam.exact.elastic_sections import Array

#: steps that are stored: one before an instant, three after it, and one that may be joined
_STORED = 5
#: a step shorter than this part of both of its neighbours does not turn the sign of what they turn: it is taken
#: together with one of them
_SHORT = 0.5


class _Mean(NamedTuple):
    """Mean forces from `start` to `end` (s), all numbers of them in a row."""

    start: float
    end: float
    forces: Array

    @property
    def length(self) -> float:
        return self.end - self.start

    @property
    def middle(self) -> float:
        return 0.5 * (self.start + self.end)

    def joined(self, other: _Mean) -> _Mean:
        """Return the mean over this and the one that follows it."""
        part = other.length / (self.length + other.length)
        return _Mean(self.start, other.end, _between(self.forces, other.forces, part))


class Averages:
    """The mean forces of a smooth stretch of steps, and the instants at which forces are requested.

    Instants are given in ascending order, each between the steps that it lies between.
    """

    def __init__(self) -> None:
        #: forces that were requested, by time (s): of the stretch up to it, and of the one that begins there
        self.before: dict[float, Array] = {}
        self.after: dict[float, Array] = {}
        self._means: list[_Mean] = []
        self._requests: list[tuple[float, dict[float, Array]]] = []

    def request(self, time: float, begins: bool = False) -> None:
        """Keep the forces at an instant (s), where a stretch may begin; there are none if no step is near."""
        self._requests.append((time, self.after if begins else self.before))

    def add(self, start: float, end: float, forces: Array) -> None:
        """Take the mean forces of the next step."""
        new, means = _Mean(start, end, forces), self._means
        if means and means[-1].length < _SHORT * new.length:
            if len(means) == 1:
                new = means.pop().joined(new)
            elif means[-1].length < _SHORT * means[-2].length:
                self._join_last()
        means.append(new)
        # three steps behind an instant are enough, at the beginning of the stretch too
        while self._requests and len(means) > 2 and means[-3].start >= self._requests[0][0]:
            self._answer_request()
        del means[:-_STORED]

    def cut(self) -> None:
        """End the stretch: forces may jump here."""
        if len(self._means) > 1 and self._means[-1].length < _SHORT * self._means[-2].length:
            self._join_last()
        while self._requests:
            self._answer_request()
        self._means.clear()

    def _join_last(self) -> None:
        last = self._means.pop()
        self._means[-1] = self._means[-1].joined(last)

    def _answer_request(self) -> None:
        time, found = self._requests.pop(0)
        if self._means:
            found[time] = self._at(time)

    def _at(self, time: float) -> Array:
        """Return the forces at an instant: between middles of steps, or beyond the last or the first of them."""
        means = self._means
        if len(means) == 1:
            return means[0].forces
        places = [(mean.middle, mean.forces) for mean in means]
        if len(means) > 2 and not places[0][0] <= time <= places[-1][0]:
            # means alternate a little themselves, which a line through two of them would enlarge: where steps meet
            # they do so no more
            meetings = zip(means[1:], pairwise(places), strict=True)
            places = [(mean.start, _on_line(one, other, mean.start)) for mean, (one, other) in meetings]
        after = next((k for k in range(1, len(places)) if places[k][0] > time), len(places) - 1)
        return _on_line(places[after - 1], places[after], time)


def _on_line(one: tuple[float, Array], other: tuple[float, Array], time: float) -> Array:
    """Return the forces at an instant (s) on the line through those at two others."""
    return _between(one[1], other[1], (time - one[0]) / (other[0] - one[0]))


def _between(one: Array, other: Array, part: float) -> Array:
    """Return the forces on the line through two others, `one` at 0 and `other` at 1."""
    return one + part * (other - one)

"""Layout of the parts of a frame; what would be too small to be read is left out.  The bar of length."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

Box = tuple[int, int, int, int]  # left, top, width, height (pixels)

_LEAST_INSET = (150, 150)  # width and height (pixels)
_LEAST_CHART = (385, 110)  # where letters are 13.3 pixels high; with larger ones more
_UNITS = ((0.1, 1.0, "m"), (1e-3, 1e-3, "mm"), (0.0, 1e-6, "µm"))  # from which length on (m), size (m), name


class Layout(NamedTuple):
    """Boxes of a frame: pictures of the beam from left to right, the contact point, charts of force and energy."""

    views: list[Box]
    inset: Box | None
    charts: list[Box]


def lay_out(size: tuple[int, int], head: int, views: int, inset: bool, charts: bool, unit: float = 1.0) -> Layout:
    """Divide a frame (pixels) below its heading between pictures of beams, the contact point and charts.

    In a frame that is wider than high the contact point is beside the beam and the charts are side by side; in
    one that is higher than wide everything is one below the other.  What would be too small for letters of
    13.3 times `unit` pixels is left out.
    """
    width, height = size[0], size[1] - head
    if height > width:
        shares = [0.42, 0.20, 0.19] if charts else [0.68, 0.32, 0.0]
        if not inset:
            shares[:2] = [shares[0] + shares[1], 0.0]
        high, low, chart = (round(share * height) for share in shares)
        boxes = [(0, head + high + low + n * chart, width, chart) for n in range(2 if charts else 0)]
        below = (0, head + high, width, low) if inset else None
        return Layout(_side_by_side((0, head, width, high), views), below, boxes)
    chart = round(0.34 * height) if charts else 0
    if chart < _LEAST_CHART[1] * unit:
        chart = 0
    aside = round(0.29 * width) if inset else 0
    if aside < _LEAST_INSET[0] or height - chart < _LEAST_INSET[1]:
        aside = 0
    # in a frame about as high as wide the legend of the energies needs half of the width
    left = round((0.62 if width > 1.3 * height else 0.5) * width)
    if width - left < _LEAST_CHART[0] * unit:
        left = width
    high, top = height - chart, head + height - chart
    boxes = [(0, top, left, chart), (left, top, width - left, chart)] if chart else []
    beside = (width - aside, head, aside, high) if aside else None
    return Layout(_side_by_side((0, head, width - aside, high), views), beside, [b for b in boxes if b[2]])


def _side_by_side(box: Box, count: int) -> list[Box]:
    left, top, width, height = box
    return [(left + n * (width // count), top, width // count, height) for n in range(count)]


class ScaleBar(NamedTuple):
    """A bar of a length (m), as the picture shows it: from its first end to its last one (2,) (pixels)."""

    length: float
    across: Array

    @property
    def text(self) -> str:
        """The length in words."""
        size, unit = next((size, unit) for least, size, unit in _UNITS if self.length >= 0.999 * least)
        return f"{self.length / size:g} {unit}"


def scale_bar(metre: Array, longest: float) -> ScaleBar:
    """Return the longest bar of 1, 2 or 5 times a power of ten that is not longer than some pixels.

    `metre` (2,) is what the picture makes of a metre along the bar (pixels).
    """
    room = longest / float(np.linalg.norm(metre))
    power = 10.0 ** math.floor(math.log10(room))
    length = float(next(m for m in (5.0, 2.0, 1.0) if m * power <= room * (1.0 + 1e-9)) * power)
    return ScaleBar(length, length * np.asarray(metre))

"""Where the parts of a frame are; what would be too small to be read is left out."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

Box = tuple[int, int, int, int]  # left, top, width, height (pixels)

_INSET = (150, 150)  # least width and height (pixels)
_CHART = (250, 110)


class Layout(NamedTuple):
    """Boxes of a frame: pictures of the beam from left to right, the contact point, charts of force and energy."""

    views: list[Box]
    inset: Box | None
    charts: list[Box]

    def moved(self, down: int) -> Layout:
        """Return the same, so many pixels farther down."""
        views, inset, charts = (
            [(left, top + down, width, height) for left, top, width, height in boxes]
            for boxes in (self.views, [self.inset] if self.inset else [], self.charts)
        )
        return Layout(views, inset[0] if inset else None, charts)


def lay_out(size: tuple[int, int], views: int, inset: bool, charts: bool) -> Layout:
    """Divide a frame of some size (pixels) between so many pictures of beams, the contact point and charts."""
    if size[1] > size[0]:
        return _upright(size, views, inset, charts)
    width, height = size
    top = round((0.66 if height >= 450 else 0.62) * height) if charts else height
    if height - top < _CHART[1]:
        top = height
    aside = round(0.29 * width) if inset else 0
    if aside < _INSET[0] or top < _INSET[1]:
        aside = 0
    beside: Box | None = (width - aside, 0, aside, top) if aside else None
    # in a frame about as high as wide the legend of the energies needs half of the width
    left = round((0.62 if width > 1.3 * height else 0.5) * width)
    boxes: list[Box] = [(0, top, left, height - top), (left, top, width - left, height - top)]
    if width - left < _CHART[0]:
        boxes = [(0, top, width, height - top)]
    return Layout(_side_by_side((0, 0, width - aside, top), views), beside, boxes if top < height else [])


def _upright(size: tuple[int, int], views: int, inset: bool, charts: bool) -> Layout:
    """Of a frame that is higher than wide: one part below the other."""
    width, height = size
    shares = [0.42 if charts else 0.68, 0.20 if charts else 0.32, 0.19, 0.19]
    if not inset:
        shares[0], shares[1] = shares[0] + shares[1], 0.0
    edges = [0]
    for share in shares if charts else shares[:2]:
        edges.append(edges[-1] + round(share * height))
    edges[-1] = height
    rows: list[Box] = [(0, a, width, b - a) for a, b in pairwise(edges)]
    return Layout(_side_by_side(rows[0], views), rows[1] if inset else None, rows[2:])


def _side_by_side(box: Box, count: int) -> list[Box]:
    part = box[2] // count
    return [(box[0] + n * part, box[1], part, box[3]) for n in range(count)]

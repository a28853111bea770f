"""What stands still in a picture, drawn once, with the shadows that move over it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from oblique_impact.renders.beam3d import SUPERSAMPLING
from oblique_impact.renders.shadow import Box, Pixels, Shadow, Surface

#: the part of a pixel that is its colour
COLOUR = np.frombuffer(b"\xff\xff\xff\x00", np.uint32)[0]
Strip = tuple[Box, Pixels]  # pixels of the window, and where they are


class Backdrop:
    """The pixels of a window, with the ghosts that are there by now, and the same in the size of the picture.

    `newest` are the numbers of the latest ghost of each beam.  Of the `surfaces` the first one, the ground, has a
    shadow that stands still.
    """

    def __init__(
        self, newest: list[int | None], pixels: Pixels, surfaces: Sequence[Surface], around: Shadow | None
    ) -> None:
        self.newest, self.pixels = newest, pixels
        self._surfaces, self._around = surfaces, around
        self._seen = [pixels & COLOUR == surface.tones[0] & COLOUR for surface in surfaces]
        if around:
            (_, shaded), *_ = self._shaded([around])
            left, top, right, bottom = _in_window(around.box)
            pixels[top:bottom, left:right] = shaded
        self.picture = reduced(pixels)

    def shaded(self, shadows: Sequence[Shadow | None]) -> list[Strip]:
        """Return the parts of the window with shadows, one for each surface; later ones lie on earlier ones."""
        return self._shaded([self._with_still(shadow) if n == 0 else shadow for n, shadow in enumerate(shadows)])

    def _with_still(self, shadow: Shadow | None) -> Shadow | None:
        """Return a shadow on the ground together with the one that stands still."""
        if shadow is None or self._around is None:
            return shadow
        (left, top, right, bottom), (first, high, _, _) = shadow.box, self._around.box
        still = self._around.levels[top - high : bottom - high, left - first : right - first].astype(np.uint16)
        return Shadow(shadow.box, (255 - (255 - still) * (255 - shadow.levels) // 255).astype(np.uint8))

    def _shaded(self, shadows: Sequence[Shadow | None]) -> list[Strip]:
        strips: list[Strip] = []
        for shadow, surface, seen in zip(shadows, self._surfaces, self._seen, strict=False):
            if shadow is None:
                continue
            left, top, right, bottom = box = _in_window(shadow.box)
            pixels = self.pixels[top:bottom, left:right].copy()
            for strip in strips:
                lay(strip, pixels, box)
            darken(pixels, seen[top:bottom, left:right], shadow, surface)
            strips.append((box, pixels))
        return strips


def darken(pixels: Pixels, seen: NDArray[np.bool_], shadow: Shadow, surface: Surface) -> None:
    """Darken the pixels (rows, columns) of the window that lie in a shadow, where its surface is seen."""
    tones = surface.tones[shadow.levels].repeat(SUPERSAMPLING, axis=1).repeat(SUPERSAMPLING, axis=0)
    np.copyto(pixels, tones, where=seen)


def lay(strip: Strip, pixels: Pixels, box: Box, where: NDArray[np.bool_] | None = None) -> None:
    """Lay a part of the window over another one, that of a box; only `where` something holds, if given."""
    (left, top, right, bottom), part = strip
    first, last = max(left, box[0]), min(right, box[2])
    high, low = max(top, box[1]), min(bottom, box[3])
    if first >= last or high >= low:
        return
    inner = slice(high - box[1], low - box[1]), slice(first - box[0], last - box[0])
    found: Pixels = part[high - top : low - top, first - left : last - left]
    np.copyto(pixels[inner], found, where=True if where is None else where[inner])


def picture_of(pixels: Pixels) -> Image.Image:
    """Return pixels (rows, columns) as a picture; it shares their memory."""
    height, width = pixels.shape
    return Image.frombuffer("RGBX", (width, height), np.ascontiguousarray(pixels), "raw", "RGBX", 0, 1)


def reduced(pixels: Pixels | Image.Image) -> Image.Image:
    """Return a part of the window in the size of the picture."""
    large = pixels if isinstance(pixels, Image.Image) else picture_of(pixels)
    return large.reduce(SUPERSAMPLING).convert("RGB")


def _in_window(box: Box) -> Box:
    left, top, right, bottom = (SUPERSAMPLING * edge for edge in box)
    return left, top, right, bottom

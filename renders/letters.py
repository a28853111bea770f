"""Sizes of letters: they follow the picture, down to what can still be read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

import matplotlib as mpl
from matplotlib import font_manager
from PIL import ImageFont

LEAST = 12  # pixels
_TITLE, _LEAST_TITLE = 20.0, 15


@dataclass(frozen=True)
class Letters:
    """Letters of a picture; `scale` is 1 for one of 1280 x 720, and lengths that go with letters are multiples."""

    scale: float

    def size(self, pixels: float) -> int:
        """Size (pixels) of letters that have so many in a picture of 1280 x 720."""
        return max(_LEAST_TITLE if pixels >= _TITLE else LEAST, round(pixels * self.scale))

    def font(self, pixels: float, bold: bool = False) -> ImageFont.FreeTypeFont:
        """Return the font of letters that have so many pixels in a picture of 1280 x 720."""
        return _font(self.size(pixels), bold)

    def fitting(self, texts: Sequence[str], width: float, pixels: float, bold: bool = False) -> str:
        """Return the first of several texts, ever shorter, that is not wider (pixels); none if none is."""
        return next((text for text in texts if self.font(pixels, bold).getlength(text) <= width), "")


@cache
def _font(size: int, bold: bool) -> ImageFont.FreeTypeFont:
    """Return DejaVu Sans at a size in pixels; it comes with matplotlib."""
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    path = Path(mpl.get_data_path()) / "fonts" / "ttf" / name
    font = ImageFont.truetype(str(path) if path.exists() else font_manager.findfont("DejaVu Sans"), size)
    # most texts of a film are in every frame: the last masks and lengths are kept, as drawing them takes long
    font.getmask2 = lru_cache(maxsize=256)(font.getmask2)  # type: ignore[method-assign,assignment]
    font.getlength = lru_cache(maxsize=256)(font.getlength)  # type: ignore[method-assign,assignment]
    return font

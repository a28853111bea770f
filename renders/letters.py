"""Sizes of letters in points: the same part of a picture at every size, down to what can still be read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

import matplotlib as mpl
from matplotlib import font_manager
from PIL import ImageFont

from oblique_impact.renders.style import TEXT, Style

LEAST = 12  # pixels
_TITLE, _LEAST_TITLE = 15.0, 15  # points, pixels
_PER_POINT = 96.0 / 72.0  # pixels of a picture at scale 1


@dataclass(frozen=True)
class Letters:
    """Letters of a picture; `scale` is 1 for 96 dots per inch, and lengths that go with letters are multiples."""

    scale: float

    @classmethod
    def of(cls, style: Style) -> Letters:
        """Return the letters of a style: its resolution and the size of its text."""
        return cls(style.resolution / 96.0 * style.letters / TEXT)

    def size(self, points: float) -> int:
        """Size (pixels) of letters that have so many points where text has `renders.style.TEXT`."""
        return max(_LEAST_TITLE if points >= _TITLE else LEAST, round(points * _PER_POINT * self.scale))

    def font(self, points: float, bold: bool = False) -> ImageFont.FreeTypeFont:
        """Return the font of letters of such a size."""
        return _font(self.size(points), bold)

    def fitting(self, texts: Sequence[str], width: float, points: float, bold: bool = False) -> str:
        """Return the first of several texts, ever shorter, that is not wider (pixels); none if none is."""
        return next((text for text in texts if self.font(points, bold).getlength(text) <= width), "")

    def wrapped(self, text: str, width: float, points: float) -> list[str]:
        """Return the lines of a text that are not wider (pixels), broken between its words."""
        lines: list[str] = []
        for word in text.split():
            longer = f"{lines[-1]} {word}" if lines else word
            if lines and self.font(points).getlength(longer) <= width:
                lines[-1] = longer
            else:
                lines.append(word)
        return lines


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

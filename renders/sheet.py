"""A matplotlib figure of a size in pixels: the texts, rules and scales around the pictures of a PyVista scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from numpy.typing import NDArray

from oblique_impact.renders.layout import ScaleBar
from oblique_impact.renders.story import ColourScale
from oblique_impact.renders.style import TEXT, Style

#: sizes of text (points) where `Style.letters` is `renders.style.TEXT`
STATE, NAME, HEADING, LINE, SMALL = 15.0, 11.0, 10.5, 10.0, 9.0
_INK = 3.0  # pixels by which letters may reach beyond the box of their text
_LEAST = 12.0  # pixels: smaller text cannot be read


class Sheet:
    """A figure whose places are pixels from its left and top; letters go with the resolution of a style."""

    def __init__(self, size: tuple[int, int], style: Style) -> None:
        self.size, self.style, self.theme = size, style, style.colours
        dpi = style.resolution
        # a little more than the pixels: matplotlib cuts the decimals off
        width, height = ((pixels + 0.1) / dpi for pixels in size)
        self.figure = Figure(figsize=(width, height), dpi=dpi)
        self.figure.set_facecolor(self.theme.background)
        self._canvas: Any = FigureCanvasAgg(self.figure)
        self._moving: list[Any] = []
        #: of texts that may change: what was written last, and its pixels with their place if it was twice
        self._written: dict[Text, tuple[Any, tuple[tuple[slice, slice], NDArray[np.uint8]] | None]] = {}

    def points(self, size: float) -> float:
        """Return the size (points) on this sheet of text that has some size at the letters of `TEXT`."""
        return max(size * self.style.letters / TEXT, _LEAST * 72.0 / self.style.resolution)

    def pixels(self, size: float) -> float:
        """Return the same in pixels."""
        return self.points(size) * self.style.resolution / 72.0

    @property
    def unit(self) -> float:
        """Pixels that are 1 where text of `LINE` is 13.3 pixels high: lengths that go with the letters."""
        return self.pixels(LINE) * 0.075

    @property
    def thin(self) -> float:
        """Width (points) of a thin line."""
        return self.unit * 72.0 / self.style.resolution

    def write(self, left: float, top: float, text: str, size: float, colour: str = "", **how: Any) -> Text:
        """Write a text whose upper left corner, if not told otherwise, is at a place."""
        look: dict[str, Any] = {
            "va": "top",
            "color": colour or self.theme.ink,
            "fontsize": self.points(size),
        } | how
        return self.figure.text(left, self.size[1] - top, text, transform=None, **look)

    def move(self, *artists: Any) -> None:
        """Redraw artists in each frame."""
        for artist in artists:
            artist.set_animated(True)
        self._moving += artists

    def rewrite(self, text: Text) -> None:
        """Write a text in each frame that may change, over pixels of the canvas that do not."""
        text.set_animated(True)
        self._written[text] = None, None

    def width_of(self, text: Text) -> float:
        """Return the width (pixels) of what is written."""
        return float(text.get_window_extent(self._canvas.get_renderer()).width)

    def fit(self, text: Text, choices: Sequence[str], width: float) -> None:
        """Write the first of some texts, ever shorter, that is not wider (pixels), or none."""
        for choice in (*choices, ""):
            text.set_text(choice)
            if self.width_of(text) <= width:
                return

    def add_axes(self, left: float, top: float, width: float, height: float) -> Any:
        """Add axes in a box (pixels)."""
        wide, high = self.size
        return self.figure.add_axes((left / wide, 1.0 - (top + height) / high, width / wide, height / high))

    def rule(self, start: tuple[float, float], end: tuple[float, float], **how: Any) -> Line2D:
        """Draw a line between two places."""
        (x0, y0), (x1, y1) = start, end
        look: dict[str, Any] = {"color": self.theme.line, "linewidth": self.thin} | how
        line = Line2D([x0, x1], [self.size[1] - y0, self.size[1] - y1], transform=None, **look)
        self.figure.add_artist(line)
        return line

    def scale_bar(self, left: float, bottom: float, bar: ScaleBar) -> tuple[Line2D, Text]:
        """Draw a bar with its length above it; returns both."""
        x, y = bar.across
        low = bottom + min(-float(y), 0.0)
        line = self.rule(
            (left, low),
            (left + x, low + y),
            color=self.theme.ink,
            linewidth=2.0 * self.thin,
            marker="|",
            markersize=8.0 * self.thin,
            markeredgewidth=2.0 * self.thin,
        )
        top = min(low, low + 0.5 * y) - 0.5 * self.pixels(SMALL)
        return line, self.write(left + 0.5 * x, top, bar.text, SMALL, va="bottom", ha="center")

    def colour_bar(self, left: float, bottom: float, width: float, scale: ColourScale) -> None:
        """Draw the scale of colours between its title and its labels, which end at `bottom`."""
        thick, high = 12.0 * self.unit, 1.45 * self.pixels(SMALL)
        axes = self.add_axes(left, bottom - high - thick, width, thick)
        mappable = ScalarMappable(Normalize(-1.0, 1.0), self.theme.colour_map)
        bar: Any = self.figure.colorbar(mappable, cax=axes, orientation="horizontal")
        bar.outline.set_visible(False)
        few = width < 14.0 * self.pixels(SMALL)
        places, labels = zip(*(scale.ticks[::2] if few else scale.ticks), strict=True)
        bar.set_ticks(places, labels=labels)
        axes.tick_params(length=0.0, pad=4.0 * self.thin, colors=self.theme.dim, labelsize=self.points(SMALL))
        top = bottom - high - thick - 4.0 * self.unit
        self.write(left + 0.5 * width, top, scale.title, LINE, va="bottom", ha="center")

    def drawn(self) -> NDArray[np.uint8]:
        """Draw everything that does not move; returns the pixels (rows, columns, 4)."""
        self._canvas.draw()
        return self.canvas.copy()

    @property
    def canvas(self) -> NDArray[np.uint8]:
        """The pixels (rows, columns, 4) that are drawn into, and may be written to."""
        return np.asarray(self._canvas.buffer_rgba())

    def draw_moving(self) -> None:
        """Draw what moves over the pixels of the canvas."""
        for artist in self._moving:
            self.figure.draw_artist(artist)
        for text in self._written:
            self._write_again(text)

    def _write_again(self, text: Text) -> None:
        """Draw a text, or copy its pixels if it has not changed, which takes a tenth of the time."""
        now, (before, pixels) = (text.get_text(), text.get_color()), self._written[text]
        if now == before and pixels:
            part, known = pixels
            self.canvas[part] = known
            return
        self.figure.draw_artist(text)
        # pixels are kept from the second time on: a text that always changes does without
        self._written[text] = now, self._around(text) if now == before else None

    def _around(self, text: Text) -> tuple[tuple[slice, slice], NDArray[np.uint8]]:
        """Return the part of the canvas that a text covers, and its pixels."""
        box, high = text.get_window_extent(self._canvas.get_renderer()).padded(_INK), self.size[1]
        rows = slice(max(math.floor(high - box.y1), 0), max(math.ceil(high - box.y0), 0))
        columns = slice(max(math.floor(box.x0), 0), max(math.ceil(box.x1), 0))
        return (rows, columns), self.canvas[rows, columns].copy()

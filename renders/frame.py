"""A frame of a film: views, charts and text put together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import matplotlib as mpl
import numpy as np
from PIL import Image, ImageDraw

from oblique_impact.contact.state import State
from oblique_impact.renders.beam3d import contact_force
from oblique_impact.renders.charts import Chart, energy_curves, force_curves
from oblique_impact.renders.layout import Box, lay_out
from oblique_impact.renders.letters import Letters
from oblique_impact.renders.scene import View
from oblique_impact.renders.story import Story
from oblique_impact.renders.style import Style
from oblique_impact.renders.timeline import Timeline
from oblique_impact.renders.title import short

_TITLE, _NAME, _HEADING, _LINE, _SMALL = 15.0, 11.0, 10.5, 10.0, 9.0  # points, where text has 10
_LOW = 300  # pixels: in a lower view text and colour bar take fewer lines

PlacedChart = tuple[Chart, Box]


class Composer:
    """Draws frames of a story, in its style or in another one.

    Without the timeline of a film there are no charts and no rate.  The positions between the times of `span` (s)
    fit into the picture, by default those of the whole run.  `charts` are those of another
    composer of the film.
    """

    def __init__(
        self,
        story: Story,
        timeline: Timeline | None = None,
        style: Style | None = None,
        span: tuple[float, float] | None = None,
        charts: Sequence[PlacedChart] | None = None,
    ) -> None:
        self.story, self.timeline, self.style = story, timeline, style or story.style
        self.theme, size = self.style.colours, self.style.size
        self.letters = Letters.of(self.style)
        numbers = list(range(len(story.geometries)))
        pictures = [numbers] if story.overlay else [[n] for n in numbers]
        alone, charted = len(pictures) == 1, self.style.charts and bool(timeline)
        self._paper = Image.new("RGB", size, self.theme.background)
        head = self._write_heading() if self.style.title != "" else 0
        plan = lay_out((size[0], size[1] - head), len(pictures), inset=self.style.inset and alone, charts=charted)
        plan = plan.moved(head)
        self._compact = plan.views[0][3] < _LOW
        self._views: list[tuple[View, Box, int]] = []
        for n, (shown, box) in enumerate(zip(pictures, plan.views, strict=True)):
            view = View(story, shown, box[2:], style=self.style, span=span, room=self._room())
            self._views.append((view, box, n))
        if plan.inset:
            left, top, wide, high = plan.inset
            band = round(self._band())
            close = replace(self.style, ghosts=False)
            view = View(story, numbers, (wide, high - band), style=close, close=True)
            self._views.append((view, (left, top + band, wide, high - band), -1))
        self.charts = self._drawn_charts(plan.charts) if charts is None else charts

    def _drawn_charts(self, boxes: Sequence[Box]) -> list[PlacedChart]:
        """Draw the charts of a film."""
        if self.timeline is None:
            return []
        curves = ((force_curves(self.story), "force (N)"), (energy_curves(self.story), "energy (J)"))
        return [
            (Chart(found, label, box[2:], self.timeline, self.story, self.letters), box)
            for (found, label), box in zip(curves, boxes, strict=False)
        ]

    def _room(self) -> tuple[float, float]:
        """Pixels that text takes above a view, and the colour bar below it, whether or not there is a caption."""
        if not self.style.text:
            return 0.0, 0.0
        letters, s = self.letters, self.letters.scale
        lines = 1 if self._compact else (self.timeline is not None) + (self.story.factor != 1.0)
        top = self._top(0) + 1.3 * letters.size(_TITLE) + 1.5 * lines * letters.size(_LINE)
        if self.story.overlay:
            return top, (1.6 * letters.size(_SMALL) + 22.0 * s if self.style.scale_bar else 0.0)
        title = 0.0 if self._compact else 1.2 * letters.size(_LINE) + 4 * s
        return top, title + max(8.0, 12 * s) + 1.3 * letters.size(_SMALL) + 8 * s

    def _top(self, top: int) -> float:
        """Pixels from the top at which text begins in a box."""
        return top + max(8.0, 16.0 * self.letters.scale)

    def _band(self) -> float:
        """Pixels above the view of the contact point, for its text."""
        letters = self.letters
        return self._top(0) + 2.8 * letters.size(_HEADING) + 1.5 * letters.size(_LINE)

    def _write_heading(self) -> int:
        """Write title and beam at the top of the paper, where they stay; returns the height (pixels) they take."""
        letters, width = self.letters, self.style.size[0]
        margin, y = self._margin, max(5.0, 9.0 * letters.scale)
        title = letters.fitting(shortened(self.story.title), width - 2.0 * margin, _NAME, True)
        right = margin + (letters.font(_NAME, True).getlength(title) + letters.size(_NAME) if title else 0.0)
        beam = letters.fitting(self.story.beam, width - right - margin, _NAME)
        if not (title or beam):
            return 0
        pen, base = ImageDraw.Draw(self._paper), y + letters.size(_NAME)
        pen.text((margin, base), title, fill=self.theme.ink, font=letters.font(_NAME, True), anchor="ls")
        pen.text((right, base), beam, fill=self.theme.dim, font=letters.font(_NAME), anchor="ls")
        bottom = round(base + 0.55 * letters.size(_NAME))
        pen.line([(0, bottom), (width, bottom)], fill=self.theme.line, width=max(1, round(letters.scale)))
        return bottom + max(1, round(letters.scale))

    @property
    def _margin(self) -> float:
        """Pixels between the left edge of a view and its text."""
        return max(10.0, 22.0 * self.letters.scale)

    # Frames ---------------------------------------------------------------------------------------------------

    def draw(self, time: float, rate: float | None = None) -> Image.Image:
        """Return the frame at a physical time (s); `rate` is physical over film time."""
        frame = self._paper.copy()
        for view, (left, top, _, _), _ in self._views:
            frame.paste(view.draw(time), (left, top))
        for chart, (left, top, _, _) in self.charts:
            frame.paste(chart.at(time), (left, top))
        pen = ImageDraw.Draw(frame)
        for view, box, number in self._views:
            if number >= 0 and not self.style.text:
                continue
            if number >= 0:
                self._describe(pen, box, number, time, rate)
                free = float(box[0] + box[2])
                if not self.story.overlay and self.style.caption:
                    free = self._colour_bar(frame, box)
                if self.style.caption:
                    self._scale_bar(frame, view, box, free)
            else:
                self._describe_inset(pen, (*box[:2], *view.size), time)
                self._scale_bar(frame, view, box, float(box[0] + box[2]))
        return frame

    def _describe(self, pen: ImageDraw.ImageDraw, box: Box, number: int, time: float, rate: float | None) -> None:
        """Time, state, rate and factor above a view."""
        letters, theme = self.letters, self.theme
        left, y, right = box[0] + self._margin, self._top(box[1]), box[0] + box[2] - 0.5 * self._margin
        bold = letters.font(_TITLE, True)
        pen.text((left, y), f"t = {time:.5f} s", fill=theme.ink, font=bold)
        x = left + bold.getlength("t = 0.00000 s") + max(12.0, 24 * letters.scale)
        if self.story.overlay:
            self._legend(pen, x, y, right)
        else:
            geometry = self.story.geometries[number]
            state = State(int(geometry.history["state"].values[int(geometry.index(time))]))
            pen.text((x, y), state.name, fill=theme.states[state], font=bold)
            if len(self.story.geometries) > 1:
                x += bold.getlength("STICK") + max(8.0, 24 * letters.scale)
                name = letters.fitting(shortened(self.story.labels[number]), right - x, _NAME)
                pen.text((x, y + 3 * letters.scale), name, fill=theme.ink, font=letters.font(_NAME))
        y += 1.5 * letters.size(_TITLE)
        for texts in self._lines(rate):
            line = letters.fitting(texts, right - left, _LINE)
            pen.text((left, y), line, fill=theme.dim, font=letters.font(_LINE))
            y += 1.5 * letters.size(_LINE)

    def _lines(self, rate: float | None) -> list[list[str]]:
        """Rate and factor in words, each in several lengths."""
        found = [] if rate is None else [[rate_words(rate)]]
        if self.story.factor != 1.0 and self.style.caption:
            short = f"deflection drawn ×{self.story.factor:g}"
            found.append([f"{short} about the line from pin to contact point", short, f"×{self.story.factor:g}"])
        if self._compact and len(found) == 2:
            return [[" · ".join((found[0][0], text)) for text in found[1]]]
        return found

    def _legend(self, pen: ImageDraw.ImageDraw, x: float, y: float, right: float) -> None:
        """Names and colours of the beams, shortened where there is no room."""
        s, letters = self.letters.scale, self.letters
        part = (right - x) / len(self.story.labels)
        for n, (name, colour) in enumerate(zip(self.story.labels, self.theme.series, strict=False)):
            at = x + n * part
            pen.rectangle([at, y + 8 * s, at + 18 * s, y + 14 * s], fill=colour)
            text = letters.fitting(shortened(name), part - 32 * s, _NAME)
            pen.text((at + 24 * s, y + 1 * s), text, fill=self.theme.ink, font=letters.font(_NAME))

    def _describe_inset(self, pen: ImageDraw.ImageDraw, box: Box, time: float) -> None:
        """Force and gap above the view of the contact point, in the band that is left for them."""
        letters, theme, geometry = self.letters, self.theme, self.story.geometries[0]
        margin = max(8.0, 14.0 * letters.scale)
        top = box[1] - round(self._band())
        left, y, width = box[0] + margin, self._top(top), box[2] - 1.5 * margin
        edge = [(box[0], top), (box[0], box[1] + box[3])] if box[0] else [(0, top), (box[2], top)]
        pen.line(edge, fill=theme.line, width=max(1, round(letters.scale)))
        titles = ["contact point, true scale", "contact point"]
        if self.story.difference != 1.0:
            factor = f"difference ×{short(self.story.difference)}"
            titles = [f"contact point, {factor}", factor]
        title = letters.fitting(titles, width, _HEADING, True)
        pen.text((left, y), title, fill=theme.ink, font=letters.font(_HEADING, True))
        y += 1.6 * letters.size(_HEADING)
        k = geometry.index(time)
        if self.style.arrow and not self.story.overlay:
            size = float(np.linalg.norm(contact_force(geometry, k)))
            text, colour = (f"{size:.0f} N", theme.arrow) if size > 0.5 else ("no contact force", theme.dim)
            pen.text((left, y), text, fill=colour, font=letters.font(_HEADING))
            y += 1.4 * letters.size(_HEADING)
        if geometry.scenario.contact.enabled:
            gap, drawn = (_in_mm(value) for value in (geometry.gap(k), float(geometry.value("gap", k))))
            # on a compliant stop the coordinates, which are drawn, leave out a part of the beam's own flexibility
            text, longer = f"gap {gap} mm", f"gap {gap} mm, drawn {drawn}"
            text = (drawn != gap and letters.fitting([longer], width, _LINE)) or text
            pen.text((left, y), text, fill=theme.dim, font=letters.font(_LINE))

    def _scale_bar(self, frame: Image.Image, view: View, box: Box, right: float) -> None:
        """Bar of a round length at the lower left of a view, as far as there is room left of some pixel."""
        letters, s = self.letters, self.letters.scale
        small, left, low = letters.size(_SMALL), box[0] + self._margin, box[1] + box[3] - max(8.0, 14.0 * s)
        longest = min(0.22 * box[2], right - left - 2.0 * small)
        if not self.style.scale_bar or longest < 3.0 * small:
            return
        bar = view.scale_bar(longest)
        tick, width = max(3.0, 4.0 * s), max(1, round(2.0 * s))
        drawn = bar_mask((float(bar.across[0]), float(bar.across[1])), tick, width)
        top = low - drawn.height
        frame.paste(self.theme.ink, (round(left - tick), round(top)), drawn)
        font = letters.font(_SMALL)
        at = left + 0.5 * max(float(bar.across[0]), font.getlength(bar.text)), top
        ImageDraw.Draw(frame).text(at, bar.text, fill=self.theme.ink, font=font, anchor="mb")

    def _colour_bar(self, frame: Image.Image, box: Box) -> float:
        """Draw the scale of colours at the bottom of a view; returns the pixel left of which there is room."""
        s, letters, theme, scale = self.letters.scale, self.letters, self.theme, self.story.colours
        width = min(max(260 * s, 14.0 * letters.size(_SMALL)), (0.38 if self._compact else 0.8) * box[2])
        height = max(8.0, 12 * s)
        left = box[0] + (0.55 * box[2] if self._compact else 0.5 * (box[2] - width))
        top = box[1] + box[3] - height - 1.3 * letters.size(_SMALL) - 8 * s
        # a pixel for each colour, as high as the lines from the top of the bar to its end
        bar = colour_strip(round(width), theme.colour_map).resize((round(width), int(top + height) - int(top) + 1))
        frame.paste(bar, (int(left), int(top)))
        pen, small = ImageDraw.Draw(frame), letters.size(_SMALL)
        if self._compact:  # the title beside it
            at_title, anchor, free = (left - 2.0 * small, top + height), "rs", left - box[0] - 3.0 * small
        else:
            at_title, anchor, free = (left + 0.5 * width, top - 4 * s), "mb", float(box[2])
        title = letters.fitting([scale.title, scale.title.split(", ")[0]], free, _LINE)
        pen.text(at_title, title, fill=theme.ink, font=letters.font(_LINE), anchor=anchor)
        widest = max(letters.font(_SMALL).getlength(text) for _, text in scale.ticks)
        for part, text in scale.ticks if 1.2 * widest < 0.25 * width else scale.ticks[::2]:
            at = left + 0.5 * (part + 1.0) * width, top + height + 4 * s
            pen.text(at, text, fill=theme.dim, font=letters.font(_SMALL), anchor="mt")
        taken = at_title[0] - letters.font(_LINE).getlength(title) * (1.0 if self._compact else 0.5)
        return min(taken, left - 0.5 * widest)

    def close(self) -> None:
        """Free the windows."""
        for view, _, _ in self._views:
            view.close()


@cache
def bar_mask(across: tuple[float, float], tick: float, width: int) -> Image.Image:
    """Return where a line with ticks at its ends is; it begins a tick's length from the left (all in pixels)."""
    fine = 4  # drawn so many times as large: smooth edges
    size = round(across[0] + 2.0 * tick), round(abs(across[1]) + 2.0 * tick)
    large = Image.new("L", (fine * size[0], fine * size[1]))
    pen, start = ImageDraw.Draw(large), fine * np.array([tick, tick + max(-across[1], 0.0)])
    end, aside = start + fine * np.array(across), fine * np.array([0.0, 0.9 * tick])
    for a, b in ((start, end), (start - aside, start + aside), (end - aside, end + aside)):
        pen.line([*a.tolist(), *b.tolist()], fill=255, width=fine * width)
    return large.reduce(fine)


@cache
def colour_strip(width: int, name: str) -> Image.Image:
    """Return a colour map from its lowest value to its highest one, as a row of so many pixels."""
    colours = mpl.colormaps[name](np.linspace(0.0, 1.0, width))
    return Image.fromarray((255.0 * colours[None, :, :3]).astype(np.uint8))


def shortened(name: str) -> list[str]:
    """Return a name and ever shorter beginnings of it."""
    return [name, *(f"{name[:n]}…" for n in range(len(name) - 1, 0, -1))]


def rate_words(rate: float) -> str:
    """Rate of a film in words."""
    if abs(rate - 1.0) < 0.02:
        return "real time"
    if rate > 1.0:
        return f"{rate:.3g} times real time"
    slower = 1.0 / rate
    digits = 10.0 ** max(0.0, np.floor(np.log10(slower)) - 1.0)
    return f"1/{round(slower / digits) * digits:.0f} of real time"


def _in_mm(distance: float) -> str:
    """Return a distance (m) in mm, as a number with few digits."""
    text = f"{1e3 * distance:.3f}" if abs(distance) < 0.01 else f"{1e3 * distance:.0f}"
    return text.replace("-0.000", "0.000").replace("-", "−")

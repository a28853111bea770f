"""A frame of a film: views, charts and text put together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import matplotlib as mpl
import numpy as np
from PIL import Image, ImageDraw

from oblique_impact.contact.state import State
from oblique_impact.errors import InputError
from oblique_impact.scenario.messages import one_of
from renders.charts import Chart, all_windows, energy_curves, force_curves
from renders.geometry import BeamGeometry
from renders.layout import Box, lay_out
from renders.letters import Letters
from renders.scene import Look, View, contact_force
from renders.story import Story
from renders.themes import theme_of
from renders.timeline import Timeline

ThemeName = Literal["light", "dark", "auto"]
CameraName = Literal["oblique", "front", "above"]
Layout = Literal["side-by-side", "overlay"]
Colour = Literal[
    "bending_stress", "axial_stress", "bending_moment", "shear_force", "axial_force", "section_rotation"
]

_LAYOUTS, _SHOWN = get_args(Layout), get_args(Colour)
_TITLE, _NAME, _HEADING, _LINE, _SMALL = 20, 15, 14, 13, 12  # pixels of letters in a picture of 1280 x 720
_LOW = 300  # pixels: in a lower view text and colour bar take fewer lines


@dataclass(frozen=True)
class Style:
    """How frames look.

    Attributes
    ----------
    size : tuple of int
        Width and height (pixels), even.
    theme : {"light", "dark", "auto"}
        Colours of paper and ink; "auto", as the reader's system is set, is for pages.
    camera : {"oblique", "front", "above"}
        Where the eye is.
    quantity : str
        The result in colour: "bending_stress", "axial_stress", "bending_moment", "shear_force", "axial_force" or
        "section_rotation".
    deformation : float or None
        Factor; None chooses it.
    charts, inset, ghosts, trace, arrow : bool
        What is shown.
    layout : {"side-by-side", "overlay"}
        Of several histories.
    letters : float or None
        Size of letters, 1 for those of a film of 1280 x 720; None follows the size.
    caption : bool
        Whether the factor is told and the colour bar drawn.
    """

    size: tuple[int, int] = (1280, 720)
    theme: ThemeName = "light"
    camera: CameraName = "oblique"
    quantity: Colour = "bending_stress"
    deformation: float | None = None
    charts: bool = True
    inset: bool = True
    ghosts: bool = True
    trace: bool = True
    arrow: bool = True
    layout: Layout = "side-by-side"
    letters: float | None = None
    caption: bool = True

    def __post_init__(self) -> None:
        if self.quantity not in _SHOWN:
            raise InputError(f"--colour {self.quantity}: {one_of(self.quantity, _SHOWN)}")
        if self.layout not in _LAYOUTS:
            raise InputError(f"--layout {self.layout}: {one_of(self.layout, _LAYOUTS)}")
        if not (320 <= self.size[0] <= 7680 and 120 <= self.size[1] <= 4320):
            raise InputError(f"--size {self.size[0]}x{self.size[1]}: should be from 320x120 to 7680x4320")


class Composer:
    """Draws frames of one to three histories.

    Parameters
    ----------
    story : Story
        The runs, and what their pictures share.
    names : sequence of str
        One for each run.
    style : Style
        How they look.
    timeline : Timeline, optional
        Of a film; without it there are no charts and no rate.
    span : tuple, optional
        Times (s) of the positions that have to fit into the picture; default the whole run.
    """

    def __init__(
        self,
        story: Story,
        names: Sequence[str],
        style: Style,
        timeline: Timeline | None = None,
        span: tuple[float, float] | None = None,
    ) -> None:
        if not 1 <= len(story.geometries) <= 3:
            raise InputError(f"HISTORY: {len(story.geometries)} given: should be one, two or three")
        self.story, self.style, self.theme, self.timeline = story, style, theme_of(style.theme), timeline
        self.names, self._span = names, span
        self.letters = Letters(style.letters or min(style.size[0] / 1280.0, style.size[1] / 720.0))
        self._overlay = style.layout == "overlay" and len(story.geometries) > 1
        self._charts: list[tuple[Chart, Box]] = []
        self._views: list[tuple[View, Box, int]] = []
        self._arrange()
        self._still = Image.new("RGB", style.size, self.theme.background)

    # Layout ---------------------------------------------------------------------------------------------------

    def _arrange(self) -> None:
        style, geometries = self.style, self.story.geometries
        together = self._overlay or len(geometries) == 1
        plan = lay_out(
            style.size,
            1 if together else len(geometries),
            inset=style.inset and together,
            charts=style.charts and self.timeline is not None,
        )
        self._compact = plan.views[0][3] < _LOW
        look = Look(style.quantity, style.camera, style.ghosts, style.trace, style.arrow, self._overlay)
        room = self._room()
        for n, box in enumerate(plan.views):
            shown = geometries if together else geometries[n : n + 1]
            view = View(shown, box[2:], self.theme, look, self.story.colours.limit, span=self._span, room=room)
            self._views.append((view, box, n))
        if plan.inset:
            self._add_inset(plan.inset, look)
        if plan.charts:
            self._add_charts(plan.charts)

    def _room(self) -> tuple[float, float]:
        """Pixels that text takes above a view, and the colour bar below it, whether or not there is a caption."""
        letters, s = self.letters, self.letters.scale
        lines = 1 if self._compact else (self.timeline is not None) + (self.story.factor != 1.0)
        top = self._top(0) + 1.3 * letters.size(_TITLE) + 1.5 * lines * letters.size(_LINE)
        if self._overlay:
            return top, 0.0
        title = 0.0 if self._compact else 1.2 * letters.size(_LINE) + 4 * s
        return top, title + max(8.0, 12 * s) + 1.3 * letters.size(_SMALL) + 8 * s

    def _top(self, top: int) -> float:
        """Pixels from the top at which text begins in a box."""
        return top + max(8.0, 16.0 * self.letters.scale)

    def _add_inset(self, box: Box, look: Look) -> None:
        """Contact point at true scale."""
        true = [BeamGeometry(g.history, 1.0) for g in self.story.geometries]
        close = Look(look.quantity, look.camera, False, look.trace, look.arrow, look.plain)
        lines = 1.3 * self.letters.size(_HEADING) + 1.5 * (self.letters.size(_HEADING) + self.letters.size(_LINE))
        band = round(self._top(0) + lines)
        view = View(true, (box[2], box[3] - band), self.theme, close, self.story.colours.limit, close=6.0)
        self._views.append((view, (box[0], box[1] + band, box[2], box[3] - band), -1))

    def _add_charts(self, boxes: Sequence[Box]) -> None:
        assert self.timeline is not None
        histories = self.story.histories
        windows = all_windows(histories)
        parts = (
            (force_curves(histories, self.names, self.theme), "force (N)"),
            (energy_curves(histories, self.names, self.theme), "energy (J)"),
        )
        for (curves, label), box in zip(parts, boxes, strict=False):
            chart = Chart(curves, label, box[2:], self.timeline, windows, self.theme, self.letters)
            self._charts.append((chart, box))

    # Frames ---------------------------------------------------------------------------------------------------

    def draw(self, time: float, rate: float | None = None) -> Image.Image:
        """Return the frame at a physical time (s); `rate` is physical over film time."""
        frame = self._still.copy()
        for view, (left, top, _, _), _ in self._views:
            frame.paste(view.draw(time), (left, top))
        if self.timeline is not None:
            for chart, (left, top, _, _) in self._charts:
                frame.paste(chart.at(float(self.timeline.course.film_at(time))), (left, top))
        pen = ImageDraw.Draw(frame)
        for view, box, number in self._views:
            if number >= 0:
                self._describe(pen, box, number, time, rate)
            else:
                self._describe_inset(pen, (*box[:2], *view.size), time)
        return frame

    def _describe(self, pen: ImageDraw.ImageDraw, box: Box, number: int, time: float, rate: float | None) -> None:
        """Time, state, rate and factor above a view; the colour bar below."""
        letters, theme = self.letters, self.theme
        margin = max(10.0, 22.0 * letters.scale)
        left, y, right = box[0] + margin, self._top(box[1]), box[0] + box[2] - 0.5 * margin
        bold = letters.font(_TITLE, True)
        pen.text((left, y), f"t = {time:.5f} s", fill=theme.ink, font=bold)
        x = left + bold.getlength("t = 0.00000 s") + max(12.0, 24 * letters.scale)
        if self._overlay:
            self._legend(pen, x, y, right)
        else:
            geometry = self.story.geometries[number]
            state = State(int(geometry.history["state"].values[int(geometry.index(time))]))
            pen.text((x, y), state.name, fill=theme.states[state], font=bold)
            if len(self.story.geometries) > 1:
                x += bold.getlength("STICK") + max(8.0, 24 * letters.scale)
                name = letters.fitting(_shortened(self.names[number]), right - x, _NAME)
                pen.text((x, y + 3 * letters.scale), name, fill=theme.ink, font=letters.font(_NAME))
        y += 1.5 * letters.size(_TITLE)
        for texts in self._lines(rate):
            line = letters.fitting(texts, right - left, _LINE)
            pen.text((left, y), line, fill=theme.dim, font=letters.font(_LINE))
            y += 1.5 * letters.size(_LINE)
        if not self._overlay and self.style.caption:
            self._colour_bar(pen, box)

    def _lines(self, rate: float | None) -> list[list[str]]:
        """Rate and factor in words, each in several lengths."""
        found = [] if rate is None else [[_rate_text(rate)]]
        if self.story.factor != 1.0 and self.style.caption:
            short = f"deflection drawn ×{self.story.factor:g}"
            found.append([f"{short} about the line from pin to contact point", short, f"×{self.story.factor:g}"])
        if self._compact and len(found) == 2:
            return [[" · ".join((found[0][0], text)) for text in found[1]]]
        return found

    def _legend(self, pen: ImageDraw.ImageDraw, x: float, y: float, right: float) -> None:
        """Names and colours of the beams, shortened where there is no room."""
        s, letters = self.letters.scale, self.letters
        part = (right - x) / len(self.names)
        for n, (name, colour) in enumerate(zip(self.names, self.theme.series, strict=False)):
            at = x + n * part
            pen.rectangle([at, y + 8 * s, at + 18 * s, y + 14 * s], fill=colour)
            text = letters.fitting(_shortened(name), part - 32 * s, _NAME)
            pen.text((at + 24 * s, y + 1 * s), text, fill=self.theme.ink, font=letters.font(_NAME))

    def _describe_inset(self, pen: ImageDraw.ImageDraw, box: Box, time: float) -> None:
        """Force and gap above the view of the contact point, in the band that is left for them."""
        letters, theme, geometry = self.letters, self.theme, self.story.geometries[0]
        margin = max(8.0, 14.0 * letters.scale)
        band = self._top(0) + 1.3 * letters.size(_HEADING) + 1.5 * (letters.size(_HEADING) + letters.size(_LINE))
        top = box[1] - round(band)
        left, y, width = box[0] + margin, self._top(top), box[2] - 1.5 * margin
        edge = [(box[0], top), (box[0], box[1] + box[3])] if box[0] else [(0, top), (box[2], top)]
        pen.line(edge, fill=theme.line, width=max(1, round(letters.scale)))
        title = letters.fitting(["contact point, true scale", "contact point"], width, _HEADING, True)
        pen.text((left, y), title, fill=theme.ink, font=letters.font(_HEADING, True))
        y += 1.6 * letters.size(_HEADING)
        k = geometry.index(time)
        if self.style.arrow and not self._overlay:
            size = float(np.linalg.norm(contact_force(geometry, k)))
            text, colour = (f"{size:.0f} N", theme.arrow) if size > 0.5 else ("no contact force", theme.dim)
            pen.text((left, y), text, fill=colour, font=letters.font(_HEADING))
            y += 1.4 * letters.size(_HEADING)
        if geometry.scenario.contact.enabled:
            gap = 1e3 * float(geometry.value("gap", k))
            text = f"{gap:.3f}" if abs(gap) < 10.0 else f"{gap:.0f}"
            text = f"gap {text.replace('-0.000', '0.000').replace('-', '−')} mm"
            pen.text((left, y), text, fill=theme.dim, font=letters.font(_LINE))

    def _colour_bar(self, pen: ImageDraw.ImageDraw, box: Box) -> None:
        s, letters, theme, scale = self.letters.scale, self.letters, self.theme, self.story.colours
        width = min(max(260 * s, 14.0 * letters.size(_SMALL)), (0.38 if self._compact else 0.8) * box[2])
        height = max(8.0, 12 * s)
        left = box[0] + (0.55 * box[2] if self._compact else 0.5 * (box[2] - width))
        top = box[1] + box[3] - height - 1.3 * letters.size(_SMALL) - 8 * s
        colours = mpl.colormaps[theme.colour_map](np.linspace(0.0, 1.0, round(width)))
        for k, colour in enumerate(colours):
            pen.line([(left + k, top), (left + k, top + height)], fill=tuple(int(255 * c) for c in colour[:3]))
        small = letters.size(_SMALL)
        if self._compact:  # the title beside it
            at, anchor, free = (left - 2.0 * small, top + height), "rs", left - box[0] - 3.0 * small
        else:
            at, anchor, free = (left + 0.5 * width, top - 4 * s), "mb", float(box[2])
        title = letters.fitting([scale.title, scale.title.split(", ")[0]], free, _LINE)
        pen.text(at, title, fill=theme.ink, font=letters.font(_LINE), anchor=anchor)
        widest = max(letters.font(_SMALL).getlength(text) for _, text in scale.ticks)
        for part, text in scale.ticks if 1.2 * widest < 0.25 * width else scale.ticks[::2]:
            at = left + 0.5 * (part + 1.0) * width, top + height + 4 * s
            pen.text(at, text, fill=theme.dim, font=letters.font(_SMALL), anchor="mt")

    def close(self) -> None:
        """Free the windows."""
        for view, _, _ in self._views:
            view.close()


def _shortened(name: str) -> list[str]:
    """Return a name and ever shorter beginnings of it."""
    return [name, *(f"{name[:n]}…" for n in range(len(name) - 1, 0, -1))]


def _rate_text(rate: float) -> str:
    """Rate of a film in words."""
    if abs(rate - 1.0) < 0.02:
        return "real time"
    if rate > 1.0:
        return f"{rate:.3g} times real time"
    slower = 1.0 / rate
    digits = 10.0 ** max(0.0, np.floor(np.log10(slower)) - 1.0)
    return f"1/{round(slower / digits) * digits:.0f} of real time"

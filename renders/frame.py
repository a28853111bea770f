"""A frame of a film: views, charts and text put together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Literal, get_args

import matplotlib as mpl
import numpy as np
from matplotlib import font_manager
from PIL import Image, ImageDraw, ImageFont

from oblique_impact.contact import State
from oblique_impact.errors import InputError
from oblique_impact.faults import one_of
from oblique_impact.history import History
from renders.charts import Chart, all_windows, energy_curves, force_curves
from renders.geometry import QUANTITIES, BeamGeometry
from renders.scene import Look, View, colour_limit, contact_force
from renders.themes import theme_of
from renders.timeline import Timeline

Box = tuple[int, int, int, int]  # left, top, width, height (pixels)

ThemeName = Literal["light", "dark", "auto"]
CameraName = Literal["oblique", "front", "above"]
Layout = Literal["side-by-side", "overlay"]
Colour = Literal["bending_stress", "axial_stress", "bending_moment", "shear_force", "axial_force", "slope"]

_LAYOUTS, _SHOWN = get_args(Layout), get_args(Colour)
_UNITS = {"Pa": (1e-6, "MPa")}
_NAMES = {
    "bending_stress": "bending stress",
    "axial_stress": "axial stress",
    "bending_moment": "bending moment",
    "shear_force": "shear force",
    "axial_force": "axial force",
    "slope": "slope",
}


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
        "slope".
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


@cache
def font(size: float, bold: bool = False) -> ImageFont.FreeTypeFont:
    """Return DejaVu Sans at a size in pixels; it comes with matplotlib."""
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    path = Path(mpl.get_data_path()) / "fonts" / "ttf" / name
    file = str(path) if path.exists() else font_manager.findfont("DejaVu Sans")
    return ImageFont.truetype(file, max(6, round(size)))


class Composer:
    """Draws frames of one to three histories.

    Parameters
    ----------
    histories : sequence of History
        Of beams.
    names : sequence of str
        One for each.
    style : Style
        How they look.
    timeline : Timeline, optional
        Of a film; without it there are no charts and no rate.
    span : tuple, optional
        Times (s) of the positions that have to fit into the picture; default the whole run.
    """

    def __init__(
        self,
        histories: Sequence[History],
        names: Sequence[str],
        style: Style,
        timeline: Timeline | None = None,
        span: tuple[float, float] | None = None,
    ) -> None:
        if not 1 <= len(histories) <= 3:
            raise InputError(f"HISTORY: {len(histories)} given: should be one, two or three")
        self.style, self.theme, self.timeline = style, theme_of(style.theme), timeline
        self.names, self._span = names, span
        self.geometries = [BeamGeometry(history, style.deformation) for history in histories]
        factor = min(geometry.factor for geometry in self.geometries)
        self.geometries = [BeamGeometry(history, factor) for history in histories]
        self.scale = style.letters or min(style.size[0] / 1280.0, style.size[1] / 720.0)
        self._overlay = style.layout == "overlay" and len(histories) > 1
        self._limit = 1.0 if self._overlay else colour_limit(self.geometries, style.quantity)
        self._charts: list[tuple[Chart, Box]] = []
        self._views: list[tuple[View, Box, int]] = []
        self._arrange(histories)
        self._still = self._background()

    # Layout ---------------------------------------------------------------------------------------------------

    def _arrange(self, histories: Sequence[History]) -> None:
        width, height = self.style.size
        charts = self.style.charts and self.timeline is not None
        top = round(0.66 * height) if charts else height
        look = Look(
            self.style.quantity,
            self.style.camera,
            self.style.ghosts,
            self.style.trace,
            self.style.arrow,
            self._overlay,
        )
        if self._overlay or len(histories) == 1:
            inset = round(0.29 * width) if self.style.inset else 0
            self._add_view(self.geometries, (0, 0, width - inset, top), look, 0)
            if inset:
                self._add_inset((width - inset, 0, inset, top), look)
        else:
            part = width // len(histories)
            for n, geometry in enumerate(self.geometries):
                self._add_view([geometry], (n * part, 0, part, top), look, n)
        if charts:
            self._add_charts(histories, top)

    def _add_view(self, geometries: Sequence[BeamGeometry], box: Box, look: Look, number: int) -> None:
        view = View(geometries, (box[2], box[3]), self.theme, look, self._limit, span=self._span)
        self._views.append((view, box, number))

    def _add_inset(self, box: Box, look: Look) -> None:
        """Contact point at true scale."""
        true = [BeamGeometry(g.history, 1.0) for g in self.geometries]
        close = Look(look.quantity, look.camera, False, look.trace, look.arrow, look.plain, arrow_length=0.06)
        band = round(84 * self.scale)  # for the text
        view = View(true, (box[2], box[3] - band), self.theme, close, self._limit, close=6.0)
        self._views.append((view, (box[0], box[1] + band, box[2], box[3] - band), -1))

    def _add_charts(self, histories: Sequence[History], top: int) -> None:
        assert self.timeline is not None
        width, height = self.style.size
        left = round(0.62 * width)
        windows = all_windows(histories)
        for curves, label, box in (
            (force_curves(histories, self.names, self.theme), "contact force (N)", (0, top, left, height - top)),
            (
                energy_curves(histories, self.names, self.theme),
                "energy (J)",
                (left, top, width - left, height - top),
            ),
        ):
            size = box[2], box[3]
            self._charts.append((Chart(curves, label, size, self.timeline, windows, self.theme, self.scale), box))

    def _background(self) -> Image.Image:
        return Image.new("RGB", self.style.size, self.theme.background)

    # Frames ---------------------------------------------------------------------------------------------------

    def draw(self, time: float, rate: float | None = None) -> Image.Image:
        """Return the frame at a physical time (s); `rate` is physical over film time."""
        frame = self._still.copy()
        for view, (left, top, _, _), _ in self._views:
            frame.paste(view.draw(time), (left, top))
        if self.timeline is not None:
            for chart, (left, top, _, _) in self._charts:
                frame.paste(chart.at(float(self.timeline.film_time(time))), (left, top))
        pen = ImageDraw.Draw(frame)
        for _, box, number in self._views:
            if number >= 0:
                self._describe(pen, box, number, time, rate)
            else:
                self._describe_inset(pen, box, time)
        return frame

    def _describe(self, pen: ImageDraw.ImageDraw, box: Box, number: int, time: float, rate: float | None) -> None:
        """Time, state, rate and factor above a view; the colour bar below."""
        s, theme, geometry = self.scale, self.theme, self.geometries[number]
        left, y = box[0] + 22 * s, box[1] + 16 * s
        pen.text((left, y), f"t = {time:.5f} s", fill=theme.ink, font=font(20 * s, True))
        x = left + pen.textlength("t = 0.00000 s", font=font(20 * s, True)) + 24 * s
        if self._overlay:
            self._legend(pen, x, y)
        else:
            state = State(int(geometry.history["state"].values[int(geometry.index(time))]))
            pen.text((x, y), state.name, fill=theme.states[state], font=font(20 * s, True))
            if len(self.geometries) > 1:
                x += pen.textlength("STICK", font=font(20 * s, True)) + 24 * s
                pen.text((x, y + 3 * s), self.names[number], fill=theme.ink, font=font(15 * s))
        lines = [_rate_text(rate)] if rate is not None else []
        if geometry.factor != 1.0 and self.style.caption:
            lines.append(f"deflection drawn ×{geometry.factor:g} about the line from pin to contact point")
        for n, line in enumerate(lines):
            pen.text((left, y + (30 + 20 * n) * s), line, fill=theme.dim, font=font(13 * s))
        if not self._overlay and self.style.caption:
            self._colour_bar(pen, box)

    def _legend(self, pen: ImageDraw.ImageDraw, x: float, y: float) -> None:
        s = self.scale
        for name, colour in zip(self.names, self.theme.series, strict=False):
            pen.rectangle([x, y + 8 * s, x + 22 * s, y + 14 * s], fill=colour)
            pen.text((x + 28 * s, y + 1 * s), name, fill=self.theme.ink, font=font(15 * s))
            x += 28 * s + pen.textlength(name, font=font(15 * s)) + 20 * s

    def _describe_inset(self, pen: ImageDraw.ImageDraw, box: Box, time: float) -> None:
        s, theme = self.scale, self.theme
        left, y = box[0] + 14 * s, 16 * s
        pen.line([(box[0], 0), (box[0], box[1] + box[3])], fill=theme.line, width=max(1, round(s)))
        pen.text((left, y), "contact point, true scale", fill=theme.ink, font=font(14 * s, True))
        geometry = self.geometries[0]
        k = geometry.index(time)
        if self.style.arrow and not self._overlay:
            size = float(np.linalg.norm(contact_force(geometry, k)))
            text, colour = (f"{size:.0f} N", theme.arrow) if size > 0.5 else ("no contact force", theme.dim)
            pen.text((left, y + 24 * s), text, fill=colour, font=font(14 * s))
        if geometry.scenario.contact.enabled:
            gap = 1e3 * float(geometry.value("gap", k))
            text = f"{gap:.3f}" if abs(gap) < 10.0 else f"{gap:.0f}"
            text = f"gap {text.replace('-0.000', '0.000').replace('-', '−')} mm"
            pen.text((left, y + 44 * s), text, fill=theme.dim, font=font(13 * s))

    def _colour_bar(self, pen: ImageDraw.ImageDraw, box: Box) -> None:
        s, theme = self.scale, self.theme
        factor, unit = _UNITS.get(QUANTITIES[self.style.quantity], (1.0, QUANTITIES[self.style.quantity]))
        width, height = min(260 * s, 0.5 * box[2]), 12 * s
        left, top = box[0] + 0.5 * (box[2] - width), box[1] + box[3] - 44 * s
        colours = mpl.colormaps[theme.colour_map](np.linspace(0.0, 1.0, round(width)))
        for k, colour in enumerate(colours):
            pen.line([(left + k, top), (left + k, top + height)], fill=tuple(int(255 * c) for c in colour[:3]))
        small = font(12 * s)
        title = f"{_NAMES[self.style.quantity]} ({unit})"
        pen.text((left + 0.5 * width, top - 4 * s), title, fill=theme.ink, font=font(13 * s), anchor="mb")
        for part in (-1.0, -0.5, 0.0, 0.5, 1.0):
            text = f"{part * self._limit * factor:.3g}".replace("-", "−")
            at = left + 0.5 * (part + 1.0) * width, top + height + 4 * s
            pen.text(at, text, fill=theme.dim, font=small, anchor="mt")

    def close(self) -> None:
        """Free the windows."""
        for view, _, _ in self._views:
            view.close()


def _rate_text(rate: float) -> str:
    """Rate of a film in words."""
    if abs(rate - 1.0) < 0.02:
        return "real time"
    if rate > 1.0:
        return f"{rate:.3g} times real time"
    slower = 1.0 / rate
    digits = 10.0 ** max(0.0, np.floor(np.log10(slower)) - 1.0)
    return f"1/{round(slower / digits) * digits:.0f} of real time"

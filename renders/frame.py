"""A frame of a still or a film: the pictures of the scene, the charts and the text around them."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.text import Text
from numpy.typing import NDArray
from PIL import Image

from oblique_impact.contact.state import State
from oblique_impact.renders import panels
from oblique_impact.renders.charts import Chart
from oblique_impact.renders.layout import Box, lay_out
from oblique_impact.renders.scene import Panel, Scene, View
from oblique_impact.renders.sheet import HEADING, LINE, NAME, SMALL, STATE, Sheet
from oblique_impact.renders.story import Story
from oblique_impact.renders.style import figure_style, state_name
from oblique_impact.renders.timeline import Timeline, rate_text


class Composer:
    """Draws frames of a story; without the timeline of a film there are no charts and no rate."""

    def __init__(self, story: Story, timeline: Timeline | None = None) -> None:
        self.story, self.timeline, self.style = story, timeline, story.style
        self._texts: dict[str, Text] = {}  # that move
        self._force, self._tells_side = "", False
        with figure_style(self.style.colours):
            self.sheet = Sheet(self.style.size, self.style)
            self._top = max(8.0, 16.0 * self.sheet.unit)  # pixels above the first line of text of a box
            self._margin = max(10.0, 22.0 * self.sheet.unit)  # pixels between the left edge of a view and its text
            self._arrange()
            self._past = self.sheet.drawn()
            self._future = self._past.copy()
            for chart in self._charts:
                chart.veil(self._future)

    def _arrange(self) -> None:
        """Write and draw everything around the scene, and make the scene in the room that is left."""
        story, style = self.story, self.style
        numbers = list(range(len(story.geometries)))
        pictures = [numbers] if story.overlay else [[n] for n in numbers]
        head = self._write_heading() if style.title != "" else 0
        charted, alone = style.charts and self.timeline is not None, len(pictures) == 1
        plan = lay_out(style.size, head, len(pictures), style.inset and alone, charted, self.sheet.unit)
        boxes = [self._describe(runs[0], box) for runs, box in zip(pictures, plan.views, strict=True)]
        self._panels = [Panel(box, runs) for box, runs in zip(boxes, pictures, strict=True)]
        if plan.inset:
            self._panels.append(Panel(self._describe_inset(plan.inset), numbers, close=True))
        bottom = plan.charts[0][1] if plan.charts else style.size[1]
        self._first = min(panel.box[1] for panel in self._panels)  # row of the scene
        self.scene = Scene(
            story,
            [p._replace(box=(p.box[0], p.box[1] - self._first, *p.box[2:])) for p in self._panels],
            (style.size[0], bottom - self._first),
        )
        for box, view in zip(plan.views, self.scene.views, strict=False):
            if style.text:
                self._add_scale_bar(box, view)
        if plan.inset:
            left, top, width, height = plan.inset
            place = left + 18.0 * self.sheet.unit, top + height - 14.0 * self.sheet.unit
            # it lies over the picture
            self.sheet.move(*self.sheet.scale_bar(*place, self.scene.views[-1].scale_bar(0.22 * width)))
        self._charts = []
        runs = panels.runs_of(story)
        for panel, box in zip((panels.forces(runs), panels.energy(runs)), plan.charts, strict=False):
            assert self.timeline is not None
            self._charts.append(Chart(self.sheet, panel, box, self.timeline.course, story))

    def _write_heading(self) -> int:
        """Write title and beam at the top; returns the height (pixels) that they take."""
        sheet, (width, _) = self.sheet, self.style.size
        base = max(5.0, 9.0 * sheet.unit) + sheet.pixels(NAME)
        title = sheet.write(self._margin, base, "", NAME, weight="bold", va="baseline")
        sheet.fit(title, [self.story.title], width - 2.0 * self._margin)
        left = self._margin
        if title.get_text():
            left += sheet.width_of(title) + sheet.pixels(NAME)
        beam = sheet.write(left, base, "", NAME, self.style.colours.dim, va="baseline")
        sheet.fit(beam, self.story.beam, width - left - self._margin)
        if not (title.get_text() or beam.get_text()):
            return 0
        bottom = round(base + 0.6 * sheet.pixels(NAME))
        sheet.rule((0.0, bottom), (width, bottom))
        return bottom + 1

    def _describe(self, number: int, box: Box) -> Box:
        """Write time, state, rate and factor above a view, draw its colours below it; returns the box between."""
        sheet, story, colours = self.sheet, self.story, self.style.colours
        if not self.style.text:
            return box
        left, y, right = box[0] + self._margin, box[1] + self._top, box[0] + box[2] - 0.5 * self._margin
        time = sheet.write(left, y, "t = 0.00000 s", STATE, weight="bold")
        x = left + sheet.width_of(time) + 24.0 * sheet.unit
        self._keep(f"time {number}", time)
        if story.overlay:
            handles = [Line2D([], [], color=c, linewidth=5.0 * sheet.thin) for c in colours.series]
            sheet.figure.legend(
                handles[: len(story.names)],
                story.names,
                loc="upper left",
                bbox_to_anchor=(x / sheet.size[0], 1.0 - (y - 9.0 * sheet.unit) / sheet.size[1]),
                ncols=len(story.names),
                fontsize=sheet.points(NAME),
                handlelength=1.2,
            )
        else:
            state = sheet.write(x, y, "STICK, just before the reversal", STATE, weight="bold")
            # a still at an event says which side of the jump it shows, where nothing else stands there
            self._tells_side = len(story.names) < 2 and sheet.width_of(state) < right - x
            state.set_text("STICK")
            x += sheet.width_of(state) + 24.0 * sheet.unit
            self._keep(f"state {number}", state)
            if len(story.names) > 1:
                name = sheet.write(x, y + 3.0 * sheet.unit, "", NAME)
                sheet.fit(name, [story.names[number]], right - x)
        y += 1.5 * sheet.pixels(STATE)
        if self.timeline is not None:
            self._keep(f"rate {number}", sheet.write(left, y, "", LINE, colours.dim))
            y += 1.5 * sheet.pixels(LINE)
        if story.magnified:
            sheet.fit(sheet.write(left, y, "", LINE, colours.dim), story.magnified, right - left)
            y += 1.5 * sheet.pixels(LINE)
        above, below = round(y - 0.2 * sheet.pixels(STATE)), 1.6 * sheet.pixels(SMALL) + 22.0 * sheet.unit
        if not story.overlay:
            width = self._colour_bar_width(box)
            low = box[1] + box[3] - 8.0 * sheet.unit
            sheet.colour_bar(box[0] + 0.5 * (box[2] - width), low, width, story.colours)
            below = 1.2 * sheet.pixels(LINE) + 1.45 * sheet.pixels(SMALL) + 24.0 * sheet.unit
        return box[0], above, box[2], box[1] + box[3] - round(below) - above

    def _colour_bar_width(self, box: Box) -> float:
        return min(260.0 * self.sheet.unit, 0.5 * box[2])

    def _add_scale_bar(self, box: Box, view: View) -> None:
        """Draw the scale of length below a view, beside its scale of colours, if there is room."""
        sheet, free = self.sheet, 0.22 * box[2]
        if not self.story.overlay:
            beside = 0.5 * (box[2] - self._colour_bar_width(box)) - self._margin
            free = min(free, beside - 3.0 * sheet.pixels(SMALL))
        if free > 3.0 * sheet.pixels(SMALL):
            low = box[1] + box[3] - 14.0 * sheet.unit
            sheet.scale_bar(box[0] + self._margin, low, view.scale_bar(free))

    def _describe_inset(self, box: Box) -> Box:
        """Write force and gap above the view of the contact point; returns the box below."""
        sheet, story, colours = self.sheet, self.story, self.style.colours
        left, y, width = box[0] + 14.0 * sheet.unit, box[1] + self._top, box[2] - 21.0 * sheet.unit
        end = (box[0], box[1] + box[3]) if box[0] else (box[2], box[1])
        sheet.rule((box[0], box[1]), end)
        geometry = story.geometries[0]
        touches = geometry.scenario.contact.enabled
        title = geometry.outer_point if geometry.at_point else "main contact"
        sheet.fit(sheet.write(left, y, "", HEADING, weight="bold"), [f"{title}, true scale", title], width)
        y += 1.6 * sheet.pixels(HEADING)
        if self.style.arrow and touches and not story.overlay:
            force = sheet.write(left, y, "", HEADING)
            sheet.fit(force, ["contact force 8888 N", "force 8888 N", "8888 N"], width)
            self._force = force.get_text().removesuffix("8888 N")
            self._keep("force", force)
            y += 1.4 * sheet.pixels(HEADING)
        if touches and not story.overlay:
            self._keep("gap", sheet.write(left, y, "", LINE, colours.dim))
        band = round(self._top + 2.8 * sheet.pixels(HEADING) + 1.5 * sheet.pixels(LINE))
        return box[0] + 1, box[1] + band, box[2] - 1, box[3] - band

    def _keep(self, name: str, text: Text) -> None:
        """Redraw a text in each frame."""
        self._texts[name] = text
        self.sheet.rewrite(text)

    # Frames ---------------------------------------------------------------------------------------------------

    def draw(self, time: float, rate: float | None = None) -> NDArray[np.uint8]:
        """Return the frame (rows, columns, 3) at a physical time (s); `rate` is physical over film time."""
        frame = self.sheet.canvas
        frame[...] = self._future
        for chart in self._charts:
            part = chart.past(time)
            frame[part] = self._past[part]
            chart.cursor_to(time)
        picture = self.scene.draw(time)
        for (left, top, width, height), *_ in self._panels:
            rows, columns = slice(top, top + height), slice(left, left + width)
            frame[rows, columns] = picture[top - self._first : top - self._first + height, columns]
        for name, (text, colour) in self._words(time, rate).items():
            if name in self._texts:
                self._texts[name].set(text=text, color=colour)
        self.sheet.draw_moving()
        whole = Image.frombuffer("RGBA", frame.shape[1::-1], frame, "raw", "RGBA", 0, 1)
        return np.asarray(whole.convert("RGB"))

    def _words(self, time: float, rate: float | None) -> dict[str, tuple[str, str]]:
        """Return what is written at a time, with its colours, by the names of texts."""
        theme, words = self.style.colours, {}
        for number, geometry in enumerate(self.story.geometries):
            state = State(int(geometry.history["state"].values[int(geometry.index(time))]))
            words[f"time {number}"] = (f"t = {time:.5f} s", theme.ink)
            side = geometry.beside(geometry.index(time)) if self._tells_side and rate is None else ""
            name = state_name(state, geometry.scenario).upper()
            words[f"state {number}"] = (f"{name}, {side}" if side else name, theme.states[state])
            words[f"rate {number}"] = ("" if rate is None else rate_text(rate), theme.dim)
        geometry = self.story.geometries[0]
        k = geometry.index(time)
        force = geometry.force_text(float(np.linalg.norm(geometry.pushes(k)[geometry.close_contact(k)])))
        words["force"] = (f"{self._force}{force}", theme.arrow) if force else ("no contact force", theme.dim)
        gap, drawn = map(_in_mm, geometry.close_gap(k))
        words["gap"] = (f"gap {gap} mm" + (f", drawn {drawn}" if drawn != gap else ""), theme.dim)
        return words

    def close(self) -> None:
        """Free the window."""
        self.scene.close()

    def __enter__(self) -> Composer:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()


def _in_mm(distance: float) -> str:
    """Return a distance (m) in mm, as a number with few digits."""
    text = f"{1e3 * distance:.3f}" if abs(distance) < 0.01 else f"{1e3 * distance:.0f}"
    return text.replace("-0.000", "0.000").replace("-", "−")

"""The charts of the page: drawn once by matplotlib; what moves over them is a cursor."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from io import StringIO
from typing import Any, TypeVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.cm import ScalarMappable
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from oblique_impact.renders import panels
from oblique_impact.renders.charts import draw_over_film, film_clock, mark_times
from oblique_impact.renders.contact_map import draw_contact_map
from oblique_impact.renders.panels import BAND_WORDS, Curve, Curves
from oblique_impact.renders.story import Story
from oblique_impact.renders.style import LIGHT, Theme, figure_style

Item = TypeVar("Item")

_SIZE = 640, 120  # pixels of a chart, for which vibrations become bands; the page stretches it
_MAP_SIZE = 640, 240
_LISTED = 1000  # events or contacts at most
_MARK = 8.4  # pixels: height of the mark of an event
_TICKS = 7, 5  # at most, along both axes: their labels fit on a phone


@dataclass(frozen=True)
class PageChart:
    """A chart of the page: curves and grid as SVG, labels of its axes with their places in percent."""

    name: str
    title: str
    unit: str  # of curves and vertical axis, with its prefix
    curves: list[Curve]  # their colours are variables of the page's style sheet
    svg: str
    times: list[tuple[float, str]]
    values: list[tuple[float, str]]
    shades: list[str] = field(default_factory=list)  # of the force, from 0 to the limit that the next says
    limit: str = ""
    bands: str = ""  # what they mean, if there are any


def page_charts(story: Story) -> list[PageChart]:
    """Draw the charts of a run: contact force, or deflection where there is no contact, energy, places of contact.

    The last is there where several places of the beam can touch.
    """
    story = replace(story, style=replace(story.style, theme="light"))
    geometry, runs = story.geometries[0], panels.runs_of(story)
    charts = [_chart(story, "force", panels.forces(runs)), _chart(story, "energy", panels.energy(runs))]
    if geometry.zoned and geometry.history.contacts:
        charts.append(_places(story))
    return charts


def variables(theme: Theme) -> dict[str, str]:
    """Return the colours of a theme as the page's style sheet names them."""
    several = {"states": ("free", "slip", "stick"), "energies": ("kinetic", "elastic", "gravity")}
    found = {field.name: getattr(theme, field.name) for field in fields(theme)}
    for variable, names in several.items():
        found |= zip(names, found.pop(variable), strict=True)
    found |= zip(("first", "stop", "third"), found.pop("series")[:3], strict=True)  # of runs; a stop as the second
    return {name.replace("_", "-"): colour for name, colour in found.items() if colour.startswith("#")}


def _chart(story: Story, name: str, panel: Curves) -> PageChart:
    size, prefix = panels.unit_for([curve.values for curve in panel.curves])
    curves = [replace(curve, values=curve.values / size) for curve in panel.curves]

    banded: list[bool] = []

    def draw(axes: Axes) -> None:
        shown = replace(panel, curves=curves)
        banded.append(draw_over_film(axes, shown, story, story.time_map, _SIZE, _TICKS, 1.5))

    chart = _drawn(story, name, panel.title, prefix + panel.unit, curves, draw)
    return replace(chart, bands=BAND_WORDS) if banded[0] else chart


def _places(story: Story) -> PageChart:
    """Draw where the beam touches over film time, in the colour of the force."""
    course, width = story.time_map, _SIZE[0]
    scales: list[ScalarMappable] = []

    def draw(axes: Axes) -> None:
        clock = film_clock(course, width)
        scales.append(draw_contact_map(axes, story.histories[0], LIGHT, (clock.first, clock.last), clock.at))
        mark_times(axes, course, width, _TICKS[0])
        axes.yaxis.set_major_locator(MaxNLocator(_TICKS[1]))

    chart = _drawn(story, "places", "Place of contact", "m", [], draw, _MAP_SIZE)
    scale: Any = scales[0]
    limit, more = scale.norm.vmax, "≥ " if scale.cmap.colorbar_extend == "max" else ""
    shades = [to_hex(scale.to_rgba(force)) for force in np.linspace(0.0, limit, 9)]
    return replace(chart, shades=shades, limit=f"{more}{limit:g} N")


def _drawn(
    story: Story,
    name: str,
    title: str,
    unit: str,
    curves: list[Curve],
    draw: Callable[[Axes], None],
    size: tuple[int, int] = _SIZE,
) -> PageChart:
    """Return a chart of some `size` (pixels) that `draw` draws."""
    course, (width, height) = story.time_map, size
    with figure_style(LIGHT):
        figure = Figure(figsize=(width / 72.0, height / 72.0), dpi=72)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        draw(axes)
        axes.ticklabel_format(axis="y", style="plain", useOffset=False)
        times, values = _labels(axes.xaxis, axes.get_xlim()), _labels(axes.yaxis, axes.get_ylim())
        events = evenly(story.histories[0].events)
        at = course.film_at(np.array([event.time for event in events])) * width / (course.duration or 1.0)
        tints = [LIGHT.states[event.state] for event in events]
        axes.vlines(at, 0.0, _MARK / height, colors=tints, linewidth=2.0, transform=axes.get_xaxis_transform())
        axes.tick_params(length=0.0, labelbottom=False, labelleft=False)
        axes.spines[:].set_visible(False)
        drawing = StringIO()
        nothing: Any = dict.fromkeys(("Date", "Creator", "Format", "Type"))
        figure.savefig(drawing, format="svg", transparent=True, metadata=nothing)
    svg = drawing.getvalue()
    svg = svg[svg.index("<svg") :].replace("<svg ", '<svg preserveAspectRatio="none" ', 1)
    looks: dict[str, str] = {}
    for variable, colour in variables(LIGHT).items():
        looks.setdefault(colour, f"var(--{variable})")
        svg = svg.replace(colour, looks[colour])
    curves = [replace(curve, colour=looks[curve.colour]) for curve in curves]
    return PageChart(name, f"{title.capitalize()} ({unit})", unit, curves, svg, times, values)


def _labels(axis: Axis, ends: tuple[float, float]) -> list[tuple[float, str]]:
    """Return the labels of an axis with their places between its ends in percent."""
    start, end = ends
    ticks = axis.get_ticklocs().tolist()
    texts = axis.get_major_formatter().format_ticks(ticks)
    return [
        (100.0 * (tick - start) / (end - start), text)
        for tick, text in zip(ticks, texts, strict=True)
        if start <= tick <= end
    ]


def evenly(items: Sequence[Item]) -> list[Item]:
    """Return all items, or of very many some, evenly spread."""
    return [items[k] for k in np.linspace(0, len(items) - 1, min(len(items), _LISTED)).astype(int)]

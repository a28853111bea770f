"""What the drawings share: colours, arrows, labels, angles, pin and slope."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, FancyArrowPatch, Polygon
from numpy.typing import NDArray

from oblique_impact import History
from oblique_impact.renders.style import PAGE, figure_style

Array = NDArray[np.float64]

FOLDER = Path(__file__).parent
#: width (inches) of a picture that is as wide as the text
WIDTH = 8.2
INK, GREY, SERIES = PAGE.ink, PAGE.dim, PAGE.series
#: by `State`
FREE, SLIP, STICK = STATES = PAGE.states


def save(figure: Figure, name: str, folder: Path = FOLDER) -> Path:
    """Write a drawing (SVG), the same bytes each time; returns the file."""
    file = folder / f"{name}.svg"
    with figure_style(PAGE):
        figure.savefig(file, metadata={"Date": None, "Creator": None})
    return file


def new_figure(height: float, width: float = WIDTH) -> Figure:
    """Return an empty figure of a size in inches."""
    return Figure(figsize=(width, height), layout="constrained")


def plain(axes: Axes) -> None:
    """Make the axes a drawing in metres: equal scales, no frame."""
    axes.set_aspect("equal")
    axes.set_axis_off()


def line(axes: Axes, start: Any, end: Any, colour: str = GREY, **options: Any) -> None:
    """Draw a straight line between two points."""
    axes.plot(*np.stack([start, end]).T, color=colour, **{"lw": 0.8} | options)


def arrow(
    axes: Axes,
    start: Any,
    end: Any,
    colour: str = INK,
    *,
    both: bool = False,
    width: float = 1.2,
    name: str = "",
    bend: float = 0.0,
) -> None:
    """Draw an arrow between two points, with a head at both ends for a dimension; tests find it by its `name`."""
    style = "<|-|>,head_length=4,head_width=1.8" if both else "-|>,head_length=5,head_width=2.2"
    axes.add_patch(
        FancyArrowPatch(
            tuple(start),
            tuple(end),
            arrowstyle=style,
            connectionstyle=f"arc3,rad={bend}",
            color=colour,
            linewidth=width,
            shrinkA=0.0,
            shrinkB=0.0,
            zorder=5,
            label=name,
        )
    )


def label(axes: Axes, place: Any, text: str, shift: tuple[float, float] = (0.0, 0.0), **options: Any) -> None:
    """Write a text at a point, moved by points of the page."""
    options = {"ha": "center", "va": "center", "fontsize": 10.5, "color": INK} | options
    axes.annotate(text, tuple(place), xytext=shift, textcoords="offset points", **options)


def angle(axes: Axes, corner: Any, radius: float, first: float, last: float, text: str, **options: Any) -> None:
    """Draw an angle (rad) from a direction to another, with its name in the middle of the arc."""
    lower, upper = np.degrees(sorted((first, last)))
    axes.add_patch(Arc(tuple(corner), 2 * radius, 2 * radius, theta1=lower, theta2=upper, color=INK, lw=0.9))
    middle = 0.5 * (first + last)
    place = np.asarray(corner) + radius * np.array([np.cos(middle), np.sin(middle)])
    label(axes, place, text, **{"shift": (9.0, 1.0)} | options)


def draw_pin(axes: Axes, size: float = 0.045) -> None:
    """Draw a pin at the origin, with its support."""
    base = np.array([[0.0, 0.0], [-0.7 * size, -1.3 * size], [0.7 * size, -1.3 * size]])
    axes.add_patch(Polygon(base, closed=True, facecolor=PAGE.slope, edgecolor=PAGE.slope_edge, lw=0.8, zorder=1))
    for place in np.linspace(-size, size, 6):
        line(axes, (place, -1.3 * size), (place - 0.4 * size, -1.75 * size), PAGE.slope_edge)
    line(axes, (-1.1 * size, -1.3 * size), (1.1 * size, -1.3 * size), PAGE.slope_edge, lw=1.0)
    draw_point(axes, (0.0, 0.0))


def draw_point(axes: Axes, place: Any) -> None:
    """Mark a point."""
    axes.plot(*place, "o", ms=5.0, color=INK, zorder=6)


def draw_slope(axes: Axes, origin: Array, tangent: Array, ends: tuple[float, float], depth: float) -> None:
    """Draw the slope between two places along it (m from its origin), with some of the solid below it."""
    normal = np.array([-tangent[1], tangent[0]])
    top = origin + np.outer(ends, tangent)
    corners = [*top, *(top[::-1] - depth * normal)]
    axes.add_patch(Polygon(corners, closed=True, facecolor=PAGE.slope, lw=0.0, zorder=0))
    axes.plot(*top.T, color=PAGE.slope_edge, lw=1.4, zorder=2)


def shade_contacts(axes: Axes, history: History, scale: float = 1.0) -> None:
    """Shade the time (s times `scale`) in which the contact of a run is closed."""
    for contact in history.contacts:
        axes.axvspan(scale * contact.start, scale * contact.end, color=PAGE.line, lw=0.0, zorder=0)


def frame(axes: Axes, origin: Array, turn: float, length: float, names: tuple[str, str]) -> None:
    """Draw the two axes of a frame that is turned by an angle (rad)."""
    for direction, name in zip((turn, turn + np.pi / 2), names, strict=True):
        unit = np.array([np.cos(direction), np.sin(direction)])
        arrow(axes, origin, origin + length * unit, GREY, width=0.9)
        label(axes, origin + length * unit, name, (7.0 * unit[0], 7.0 * unit[1]), color=GREY, fontsize=9.5)

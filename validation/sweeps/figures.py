"""Pictures of sweeps with one or two axes: curves, maps, and the map of what happens in the collision."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, LogNorm, Normalize, to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from oblique_impact.errors import Outcome
from oblique_impact.renders.style import FREE_COLOUR, GREY, SERIES, SLIP_COLOUR, STICK_COLOUR
from oblique_impact.validation.measuring import REGIMES
from oblique_impact.validation.quantities import Quantity
from oblique_impact.validation.report.document import Picture, number, with_unit
from oblique_impact.validation.report.figures import new_figure, to_svg
from oblique_impact.validation.sweeps.design import Dimension
from oblique_impact.validation.sweeps.keys import kind, unit
from oblique_impact.validation.sweeps.plan import Plan

if TYPE_CHECKING:
    import pyarrow as pa

#: width of the printed page: what is drawn is what is read
_PAGE, _ROW, _MAP_ROW = 7.1, 2.7, 3.0
#: so many values of the second axis are drawn as curves, more as a map
_CURVES = 5
#: more cells than this carry no marks
_MARKED_CELLS = 1500
_MARKS = ("o", "s", "^", "D", "v")
_DASHES = ("-", "--", "-.", ":", (0, (1, 3)))
#: longer curves are lines without marks
_MARKED_POINTS = 30
#: more cells than this are an image inside of the picture
_DRAWN_CELLS = 2500
#: a largest value this many times the middle one asks for a logarithmic scale
_SPREAD = 8.0
_COLOURS = dict(zip(REGIMES, (FREE_COLOUR, SLIP_COLOUR, SERIES[3], STICK_COLOUR, SERIES[4], GREY), strict=True))
#: marks in the cells of a map, so that it does not depend on colour
_SIGNS = {"reversal": "D", "stick": "s", "painleve": "x", "stopped": "+"}
_FAILED = "failed"


@dataclass(frozen=True)
class Direction:
    """One direction of a sweep with the values of all runs, as an axis shows them.

    Attributes
    ----------
    dimension : Dimension
        Keys and spacing.
    places : ndarray, shape (runs,)
        Numbers; of words, their position.
    words : tuple of str
        The words at positions 0, 1, ...; empty for numbers.
    """

    dimension: Dimension
    places: np.ndarray
    words: tuple[str, ...]

    @property
    def label(self) -> str:
        """Name and unit for an axis."""
        its_unit = unit(self.dimension.keys[0])
        return with_unit(self.dimension.label, "" if self.words else its_unit)

    @property
    def distinct(self) -> np.ndarray:
        """The different places, ascending."""
        return np.unique(self.places)

    def name(self, place: float) -> str:
        """Return a value as text, with its unit."""
        if self.words:
            return self.words[round(place)]
        return f"{number(float(place), 4)} {unit(self.dimension.keys[0]).removeprefix('1')}".strip()


def sweep_pictures(plan: Plan, table: pa.Table) -> list[Picture]:
    """Return the pictures of a sweep; none if it has more than two directions."""
    directions = [_direction(dimension, table) for dimension in plan.design.dimensions]
    if len(directions) > 2 or plan.design.size < 2:
        return []
    if len(directions) == 1:
        return [_curves(plan, table, directions[0], None)]
    first, second = directions
    few = [d for d in (second, first) if d.words or d.distinct.size <= _CURVES]
    if few and plan.design.grid:
        other = first if few[0] is second else second
        return [_curves(plan, table, other, few[0])]
    pictures = [_maps(plan, table, first, second)]
    regimes = set(table["regime"].to_pylist()) - {""}
    return [_regime_map(plan, table, first, second), *pictures] if len(regimes) > 1 else pictures


def _direction(dimension: Dimension, table: pa.Table) -> Direction:
    column = table[dimension.keys[0]].to_pylist()
    if kind(dimension.keys[0]) in (int, float) and not any(isinstance(value, str) for value in column):
        return Direction(dimension, np.array(column, dtype=float), ())
    words = tuple(dict.fromkeys(str(value) for value in column))
    return Direction(dimension, np.array([words.index(str(v)) for v in column], dtype=float), words)


def _values(table: pa.Table, q: Quantity) -> np.ndarray:
    return np.array(table[q.name].to_pylist(), dtype=float)  # None becomes NaN


# --- curves


def _curves(plan: Plan, table: pa.Table, along: Direction, series: Direction | None) -> Picture:
    """Draw every quantity over one direction, a curve for each value of the other."""
    rows = math.ceil(len(plan.quantities) / 2)
    groups = series.distinct if series else np.array([0.0])
    labelled = series is not None
    with new_figure(_PAGE, _ROW * rows + (0.4 if labelled else 0.0)) as figure:
        panels = _panels(figure, rows, len(plan.quantities))
        for axes, q in zip(panels, plan.quantities, strict=False):
            for index, group in enumerate(groups):
                chosen = series.places == group if series else np.ones(along.places.size, dtype=bool)
                name = f"{series.dimension.label} = {series.name(group)}" if series else None
                _curve(axes, along.places[chosen], _values(table, q)[chosen], index, name, plan.design.grid)
            _name_axes(axes, along, q)
        stopped = _mark_stopped(panels, plan, table, along)
        handles, labels = panels[0].get_legend_handles_labels()
        if stopped:
            handles, labels = [*handles, stopped], [*labels, "run stopped before its end"]
        if handles:
            figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 3))
        svg = to_svg(figure)
    over = along.dimension.label
    return Picture(svg, f"Quantities over {over}.", _alternative(plan, table, f"over {over}"))


def _panels(figure: Figure, rows: int, used: int) -> list[Axes]:
    columns = 2 if used > 1 else 1
    panels = list(figure.subplots(rows, columns, squeeze=False).ravel())
    for axes in panels[used:]:
        axes.axis("off")
    return panels


def _curve(axes: Axes, x: np.ndarray, y: np.ndarray, index: int, name: str | None, joined: bool) -> None:
    """Draw one curve; where curves coincide, those below are larger or have longer dashes."""
    order = np.argsort(x, kind="stable")
    if joined and x.size > _MARKED_POINTS:
        style: dict[str, Any] = {"linestyle": _DASHES[index % len(_DASHES)], "linewidth": 2.2 - 0.2 * index}
    else:
        size = 6.0 - 0.9 * index if x.size <= _MARKED_POINTS else 2.5
        style = {"linestyle": "-" if joined else "", "marker": _MARKS[index % len(_MARKS)], "markersize": size}
    axes.plot(x[order], y[order], label=name, color=SERIES[index % len(SERIES)], **style)


def _name_axes(axes: Axes, along: Direction, q: Quantity) -> None:
    axes.set_title(_words(q.name))
    axes.set_ylabel(with_unit(_words(q.name), q.unit))
    axes.ticklabel_format(axis="y", useOffset=False, scilimits=(-3, 5))
    _scale(axes, along, "x")


def _scale(axes: Axes, direction: Direction, which: str) -> None:
    """Label one axis ("x" or "y"), spread as the sweep is; words get a tick each."""
    axis = getattr(axes, f"{which}axis")
    getattr(axes, f"set_{which}label")(direction.label)
    if direction.words:
        longest = max(len(word) for word in direction.words)
        turned = 25.0 if which == "x" and longest * len(direction.words) > 36 else 0.0
        axis.set_ticks(range(len(direction.words)), [_short(word) for word in direction.words], rotation=turned)
    elif direction.dimension.spacing == "log":
        getattr(axes, f"set_{which}scale")("log")
    elif kind(direction.dimension.keys[0]) is int:
        axis.get_major_locator().set_params(integer=True)


def _mark_stopped(panels: Sequence[Axes], plan: Plan, table: pa.Table, along: Direction) -> Line2D | None:
    """Mark at the foot of each panel where a run did not reach its end; returns the mark for a legend."""
    stopped = np.array(table["outcome"].to_pylist()) != Outcome.COMPLETED.label
    places = np.unique(along.places[stopped])
    if not places.size:
        return None
    mark = Line2D([], [], linestyle="", marker="x", color=GREY)
    for axes in panels[: len(plan.quantities)]:
        axes.plot(places, np.full(places.size, 0.02), "x", color=GREY, transform=axes.get_xaxis_transform())
    return mark


# --- maps


def _maps(plan: Plan, table: pa.Table, first: Direction, second: Direction) -> Picture:
    """Draw every quantity in colour over two directions."""
    rows = math.ceil(len(plan.quantities) / 2)
    missing = False
    with new_figure(_PAGE, _MAP_ROW * rows + 0.3) as figure:
        panels = _panels(figure, rows, len(plan.quantities))
        for axes, q in zip(panels, plan.quantities, strict=False):
            values = _values(table, q)
            missing |= bool(np.any(np.isnan(values)))
            _map(axes, first, second, values, plan.design.grid, with_unit(_words(q.name), q.unit))
            axes.set_title(_words(q.name))
        if missing:
            patch = Patch(facecolor="white", edgecolor=GREY, hatch="////", label="no such value")
            figure.legend(handles=[patch], loc="outside lower center")
        svg = to_svg(figure)
    over = f"{first.dimension.label} and {second.dimension.label}"
    return Picture(svg, f"Quantities over {over}.", _alternative(plan, table, f"over {over}"))


def _map(axes: Axes, first: Direction, second: Direction, values: np.ndarray, grid: bool, label: str) -> None:
    axes.grid(visible=False)
    if grid:
        axes.set_facecolor("white")
        axes.patch.set(hatch="////", edgecolor=GREY)
        mesh: Any = _mesh(axes, first, second, values, cmap="viridis", norm=_norm(values))
    else:
        known = np.isfinite(values)
        axes.plot(first.places[~known], second.places[~known], "x", color=GREY, markersize=4)
        colours = {"c": values[known], "cmap": "viridis", "norm": _norm(values)}
        mesh = axes.scatter(first.places[known], second.places[known], s=16, **colours)
    assert isinstance(axes.figure, Figure)
    if np.any(np.isfinite(values)):
        bar = axes.figure.colorbar(mesh, ax=axes, label=label, pad=0.02)
        if isinstance(mesh.norm, LogNorm):
            bar.ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: number(float(value), 2)))
            bar.ax.yaxis.set_minor_formatter(NullFormatter())
    _scale(axes, first, "x")
    _scale(axes, second, "y")


def _mesh(axes: Axes, first: Direction, second: Direction, values: np.ndarray, **colours: Any) -> Any:
    """Draw cells without seams between them."""
    return axes.pcolormesh(
        *_edges(first, second),
        _cells(first, second, values),
        edgecolors="face",
        linewidth=0.4,
        rasterized=values.size > _DRAWN_CELLS,
        **colours,
    )


def _norm(values: np.ndarray) -> Normalize:
    """Return a logarithmic scale for values that a few large ones dominate."""
    known = values[np.isfinite(values)]
    if known.size and known.min() > 0.0 and known.max() > _SPREAD * np.median(known):
        return LogNorm()
    return Normalize()


def _cells(first: Direction, second: Direction, values: np.ndarray) -> np.ma.MaskedArray[Any, Any]:
    """Return values on the grid, shape (second, first); masked where there are none."""
    grid = np.full((second.distinct.size, first.distinct.size), np.nan)
    grid[np.searchsorted(second.distinct, second.places), np.searchsorted(first.distinct, first.places)] = values
    return np.ma.masked_invalid(grid)


def _edges(first: Direction, second: Direction) -> tuple[np.ndarray, np.ndarray]:
    """Return the edges of the cells around the values of both directions."""
    edges = []
    for direction in (first, second):
        log = direction.dimension.spacing == "log" and not direction.words
        centres = np.log(direction.distinct) if log else direction.distinct
        inner = 0.5 * (centres[1:] + centres[:-1])
        if inner.size:
            outer = 2.0 * centres[0] - inner[0], 2.0 * centres[-1] - inner[-1]
        else:
            outer = centres[0] - 0.5, centres[0] + 0.5
        both = np.array([outer[0], *inner, outer[1]])
        edges.append(np.exp(both) if log else both)
    return edges[0], edges[1]


def _regime_map(plan: Plan, table: pa.Table, first: Direction, second: Direction) -> Picture:
    """Draw what the first macro-collision is over two directions."""
    regimes = [regime or _FAILED for regime in table["regime"].to_pylist()]
    present = [name for name in (*REGIMES, _FAILED) if name in regimes]
    index = np.array([present.index(regime) for regime in regimes], dtype=float)
    grid, marked = plan.design.grid, plan.design.size <= _MARKED_CELLS
    with new_figure(_PAGE, 4.0) as figure:
        axes = figure.add_subplot()
        axes.grid(visible=False)
        if grid:
            palette = ListedColormap([_light(name) for name in present])
            _mesh(axes, first, second, index, cmap=palette, norm=Normalize(-0.5, len(present) - 0.5))
        for number_, name in enumerate(present):
            sign = _SIGNS.get(name, "" if grid else "o")
            if sign and marked:
                at = index == number_
                colour = "white" if grid else _COLOURS.get(name, GREY)
                size = 2.6 if plan.design.size > 200 else 4.0
                axes.plot(first.places[at], second.places[at], sign, markersize=size, color=colour)
        _scale(axes, first, "x")
        _scale(axes, second, "y")
        axes.set_title("First macro-collision")
        handles = [_regime_handle(name, grid, marked) for name in present]
        figure.legend(handles, present, loc="outside lower center", ncols=min(len(handles), 7))
        svg = to_svg(figure)
    counts = ", ".join(f"{regimes.count(name)} {name}" for name in present)
    over = f"{first.dimension.label} and {second.dimension.label}"
    words = f"What the first macro-collision is over {over}. Runs: {counts}."
    return Picture(svg, words, words)


def _light(name: str) -> str:
    """Return the colour of a regime's cells, lighter than that of its curves."""
    if name not in _COLOURS:
        return "white"
    red, green, blue = (0.28 + 0.72 * part for part in to_rgb(_COLOURS[name]))
    return to_hex((red, green, blue))


def _regime_handle(name: str, grid: bool, marked: bool) -> Any:
    """Return the entry of a legend: a cell with its mark on it, or the mark alone."""
    sign = _SIGNS.get(name, "")
    if not grid:
        return Line2D([], [], linestyle="", marker=sign or "o", color=_COLOURS.get(name, GREY))
    cell = Line2D([], [], linestyle="", marker="s", markersize=11, color=_light(name), markeredgecolor=GREY)
    mark = Line2D([], [], linestyle="", marker=sign if marked else "", markersize=4, color="white")
    return (cell, mark) if sign and marked else cell


def _words(name: str) -> str:
    return name.replace("_", " ")


def _short(word: str) -> str:
    return word if len(word) <= 22 else f"{word[:21]}…"


def _alternative(plan: Plan, table: pa.Table, where: str) -> str:
    parts = []
    for q in plan.quantities:
        values = _values(table, q)
        known = values[np.isfinite(values)]
        if known.size:
            parts.append(f"{_words(q.name)} from {number(known.min(), 3)} to {number(known.max(), 3)} {q.unit}")
    return f"{'; '.join(parts)}; {where}."

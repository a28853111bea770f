"""Pictures of sweeps with one or two directions: curves, maps, and the map of what happens in the collision."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, LogNorm, Normalize
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from oblique_impact.errors import Outcome
from oblique_impact.renders.style import FREE_COLOUR, GREY, SERIES, SLIP_COLOUR, STICK_COLOUR
from oblique_impact.validation.report import Picture, number, picture, with_unit
from oblique_impact.validation.studies.design import Dimension, Plan
from oblique_impact.validation.studies.measure import REGIMES
from oblique_impact.validation.studies.quantities import Quantity

#: inches: width of the printed page, what is drawn is what is read; height of a row of curves, and of maps
_PAGE, _ROW, _MAP_ROW = 7.1, 2.7, 3.0
#: so many values of the second direction are drawn as curves, more as a map
_CURVES = 5
_MARKERS = ("o", "s", "^", "D", "v")
#: longer curves are lines without marks; larger maps are images, without marks in their cells
_MARKED_POINTS, _MARKED_CELLS = 30, 1500
#: a largest value this many times the middle one asks for a logarithmic scale
_SPREAD = 8.0
_FAILED = "failed"
_COLOURS = dict(
    zip(
        (*REGIMES, _FAILED),
        (FREE_COLOUR, SLIP_COLOUR, SERIES[3], STICK_COLOUR, SERIES[4], GREY, "white"),
        strict=True,
    )
)
#: marks in the cells of a map, so that it does not depend on colour
_SIGNS = {"reversal": "D", "stick": "s", "painleve": "x", "stopped": "+"}


@dataclass(frozen=True)
class _Direction:
    """One direction: the place of every run on its axis, and the words there, if it has no numbers."""

    dimension: Dimension
    places: np.ndarray
    words: tuple[str, ...]

    @property
    def label(self) -> str:
        return with_unit(self.dimension.label, "" if self.words else self.dimension.unit)

    @property
    def distinct(self) -> np.ndarray:
        return np.unique(self.places)

    def name(self, place: float) -> str:
        """Return a value as text, with its unit."""
        if self.words:
            return self.words[round(place)]
        return f"{number(float(place), 4)} {self.dimension.unit.removeprefix('1')}".strip()


def sweep_pictures(plan: Plan, frame: pd.DataFrame) -> list[Picture]:
    """Return the pictures of a sweep; none if it has more than two directions."""
    directions = [_direction(dimension, frame) for dimension in plan.dimensions]
    if len(directions) > 2 or len(frame) < 2:
        return []
    if len(directions) == 1:
        return [_curves(plan, frame, directions[0], None)]
    first, second = directions
    few = [d for d in (second, first) if d.words or d.distinct.size <= _CURVES]
    if few and plan.grid:
        return [_curves(plan, frame, first if few[0] is second else second, few[0])]
    pictures = [_maps(plan, frame, first, second)]
    return [_regimes(plan, frame, first, second), *pictures] if len(set(frame["regime"]) - {""}) > 1 else pictures


def _direction(dimension: Dimension, frame: pd.DataFrame) -> _Direction:
    column = frame[dimension.keys[0]]
    if pd.api.types.is_numeric_dtype(column) and not pd.api.types.is_bool_dtype(column):
        return _Direction(dimension, column.to_numpy(float), ())
    places, words = pd.factorize(column.map(str))
    return _Direction(dimension, places.astype(float), tuple(words))


def _curves(plan: Plan, frame: pd.DataFrame, along: _Direction, series: _Direction | None) -> Picture:
    """Draw every quantity over one direction, a curve for each value of the other."""
    rows = math.ceil(len(plan.quantities) / 2)
    stopped = frame["outcome"].to_numpy() != Outcome.COMPLETED.label
    caption = f"Quantities over {along.dimension.label}."
    with picture(caption, _PAGE, _ROW * rows + 0.4, _words(plan, frame, caption)) as drawn:
        panels = drawn.figure.subplots(rows, min(len(plan.quantities), 2), squeeze=False).ravel()
        for axes, q in zip(panels, plan.quantities, strict=False):
            values = frame[q.name].to_numpy()
            for index, group in enumerate(series.distinct if series else [0.0]):
                chosen = np.flatnonzero(series.places == group) if series else np.arange(len(values))
                chosen = chosen[np.argsort(along.places[chosen], kind="stable")]
                few = chosen.size <= _MARKED_POINTS
                # where curves coincide, those below are larger or wider
                style: dict[str, Any] = {"color": SERIES[index % len(SERIES)], "lw": 2.2 - 0.2 * index}
                if few or not plan.grid:
                    size = 6.0 - 0.9 * index if few else 2.5
                    style |= {
                        "marker": _MARKERS[index % len(_MARKERS)],
                        "ms": size,
                        "lw": 1.2 if plan.grid else 0.0,
                    }
                label = f"{series.dimension.label} = {series.name(group)}" if series else None
                axes.plot(along.places[chosen], values[chosen], label=label, **style)
            if stopped.any():
                foot: dict[str, Any] = {
                    "transform": axes.get_xaxis_transform(),
                    "label": "run stopped before its end",
                }
                axes.plot(along.places[stopped], np.full(stopped.sum(), 0.02), "x", color=GREY, **foot)
            axes.set(title=_plain(q.name), ylabel=with_unit(_plain(q.name), q.unit))
            axes.ticklabel_format(axis="y", useOffset=False, scilimits=(-3, 5))
            _scale(axes, along, "x")
        for axes in panels[len(plan.quantities) :]:
            axes.axis("off")
        handles, labels = panels[0].get_legend_handles_labels()
        if handles:
            drawn.figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 3))
    return drawn


def _maps(plan: Plan, frame: pd.DataFrame, first: _Direction, second: _Direction) -> Picture:
    """Draw every quantity in colour over two directions."""
    rows = math.ceil(len(plan.quantities) / 2)
    caption = f"Quantities over {first.dimension.label} and {second.dimension.label}."
    with picture(caption, _PAGE, _MAP_ROW * rows + 0.3, _words(plan, frame, caption)) as drawn:
        panels = drawn.figure.subplots(rows, min(len(plan.quantities), 2), squeeze=False).ravel()
        for axes, q in zip(panels, plan.quantities, strict=False):
            values = frame[q.name].to_numpy(float)
            mesh = _cells(axes, plan, first, second, values, {"cmap": "viridis", "norm": _norm(values)})
            if plan.grid:
                axes.patch.set(hatch="////", edgecolor=GREY)
            if np.isfinite(values).any():
                drawn.figure.colorbar(mesh, ax=axes, label=with_unit(_plain(q.name), q.unit), pad=0.02)
            axes.set_title(_plain(q.name))
        for axes in panels[len(plan.quantities) :]:
            axes.axis("off")
        if frame[[q.name for q in plan.quantities]].isna().any(axis=None):
            patch = Patch(facecolor="white", edgecolor=GREY, hatch="////", label="no such value")
            drawn.figure.legend(handles=[patch], loc="outside lower center")
    return drawn


def _regimes(plan: Plan, frame: pd.DataFrame, first: _Direction, second: _Direction) -> Picture:
    """Draw what the first macro-collision is over two directions."""
    regimes = frame["regime"].replace("", _FAILED).tolist()
    present = [name for name in _COLOURS if name in regimes]
    index = np.array([present.index(regime) for regime in regimes], dtype=float)
    colours: dict[str, Any] = {
        "cmap": ListedColormap([_COLOURS[name] for name in present]),
        "norm": Normalize(-0.5, len(present) - 0.5),
        "alpha": 0.72,  # lighter than the curves
    }
    counts = ", ".join(f"{regimes.count(name)} {name}" for name in present)
    over = f"{first.dimension.label} and {second.dimension.label}"
    with picture(f"What the first macro-collision is over {over}. Runs: {counts}.", _PAGE, 4.0) as drawn:
        axes, handles = drawn.figure.add_subplot(), []
        _cells(axes, plan, first, second, index, colours)
        marked = len(frame) <= _MARKED_CELLS
        for place, name in enumerate(present):
            colour, sign = colours["cmap"](place), _SIGNS.get(name, "") if marked else ""
            handle = Line2D([], [], ls="", marker="s", ms=11, color=colour, alpha=0.72, markeredgecolor=GREY)
            handles.append((handle, Line2D([], [], ls="", marker=sign, ms=4, color="white")) if sign else handle)
            if sign:
                at = index == place
                size = 2.6 if len(frame) > 200 else 4.0
                axes.plot(first.places[at], second.places[at], sign, ms=size, color="white")
        axes.set_title("First macro-collision")
        drawn.figure.legend(handles, present, loc="outside lower center", ncols=min(len(handles), 7))
    return drawn


def _cells(
    axes: Axes, plan: Plan, first: _Direction, second: _Direction, values: np.ndarray, colours: dict[str, Any]
) -> Any:
    """Draw values in colour: cells of a grid, or scattered points."""
    axes.grid(visible=False)
    _scale(axes, first, "x")
    _scale(axes, second, "y")
    if not plan.grid:
        missing = ~np.isfinite(values)
        axes.plot(first.places[missing], second.places[missing], "x", color=GREY, ms=4)
        return axes.scatter(first.places[~missing], second.places[~missing], s=16, c=values[~missing], **colours)
    table = pd.DataFrame({"x": first.places, "y": second.places, "value": values}).pivot(
        index="y", columns="x", values="value"
    )
    edges = (_edges(direction) for direction in (first, second))
    image: dict[str, Any] = {"rasterized": values.size > _MARKED_CELLS}
    return axes.pcolormesh(*edges, np.ma.masked_invalid(table.to_numpy()), **image, **colours)


def _edges(direction: _Direction) -> np.ndarray:
    """Return the edges of the cells around the values of a direction."""
    log = direction.dimension.spacing == "log" and not direction.words
    centres = np.log(direction.distinct) if log else direction.distinct
    inner = 0.5 * (centres[1:] + centres[:-1])
    ends = (2.0 * centres[0] - inner[0], 2.0 * centres[-1] - inner[-1]) if inner.size else centres[0] + [-0.5, 0.5]
    edges = np.array([ends[0], *inner, ends[1]])
    return np.exp(edges) if log else edges


def _norm(values: np.ndarray) -> Normalize:
    """Return a logarithmic scale for values that a few large ones dominate."""
    known = values[np.isfinite(values)]
    wide = known.size and known.min() > 0.0 and known.max() > _SPREAD * np.median(known)
    return LogNorm() if wide else Normalize()


def _scale(axes: Axes, direction: _Direction, which: str) -> None:
    """Label one axis ("x" or "y"), spread as the sweep is; words get a tick each."""
    axis = getattr(axes, f"{which}axis")
    getattr(axes, f"set_{which}label")(direction.label)
    if direction.words:
        words = [word if len(word) <= 22 else f"{word[:21]}…" for word in direction.words]
        turned = 25.0 if which == "x" and sum(map(len, words)) > 36 else 0.0
        axis.set_ticks(range(len(words)), words, rotation=turned)
    elif direction.dimension.spacing == "log":
        getattr(axes, f"set_{which}scale")("log")
    elif all(float(place).is_integer() for place in direction.distinct):
        axis.get_major_locator().set_params(integer=True)


def _plain(name: str) -> str:
    return name.replace("_", " ")


def _words(plan: Plan, frame: pd.DataFrame, caption: str) -> str:
    """Return the alternative text of a picture: the ranges of the quantities."""

    def span(q: Quantity) -> str:
        low, high = (number(float(value), 3) for value in (frame[q.name].min(), frame[q.name].max()))
        return f"{_plain(q.name)} from {low} to {high} {q.unit}"

    return f"{caption} {'; '.join(span(q) for q in plan.quantities if frame[q.name].notna().any())}."

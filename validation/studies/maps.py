"""Pictures of sweeps with one or two directions: curves, maps, and the map of what happens in the collision."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, LogNorm, Normalize
from matplotlib.patches import Patch

from oblique_impact.errors import Outcome
from oblique_impact.renders.style import FREE_COLOUR, GREY, SERIES, SLIP_COLOUR, STICK_COLOUR
from oblique_impact.validation.report import Picture, number, picture, with_unit
from oblique_impact.validation.report.figures import Drawn
from oblique_impact.validation.studies.design import Dimension, Plan
from oblique_impact.validation.studies.measure import REGIMES
from oblique_impact.validation.studies.quantities import Quantity

#: so many values of the second direction are drawn as curves, more as a map
_CURVES = 5
_MARKERS = ("o", "s", "^", "D", "v")
#: longer curves are lines without marks; larger maps are images
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


@dataclass(frozen=True)
class _Direction:
    """One direction: the place of every run on its axis, and the words there, if it has no numbers."""

    dimension: Dimension
    places: np.ndarray
    words: tuple[str, ...]

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


@contextmanager
def _panels(plan: Plan, over: str) -> Iterator[tuple[Drawn, list[tuple[Axes, Quantity]]]]:
    """Make a picture with a panel for each quantity."""
    count = len(plan.quantities)
    rows = math.ceil(count / 2)
    with picture(f"Quantities over {over}.", 7.1, 2.8 * rows + 0.4) as drawn:
        panels = drawn.figure.subplots(rows, min(count, 2), squeeze=False).ravel()
        for axes in panels[count:]:
            axes.axis("off")
        yield drawn, list(zip(panels, plan.quantities, strict=False))


def _curves(plan: Plan, frame: pd.DataFrame, along: _Direction, series: _Direction | None) -> Picture:
    """Draw every quantity over one direction, a curve for each value of the other."""
    stopped = frame["outcome"].to_numpy() != Outcome.COMPLETED.label
    with _panels(plan, along.dimension.label) as (drawn, panels):
        for axes, q in panels:
            values = frame[q.name].to_numpy()
            for index, group in enumerate(series.distinct if series else [0.0]):
                chosen = np.flatnonzero(series.places == group) if series else np.arange(len(values))
                chosen = chosen[np.argsort(along.places[chosen], kind="stable")]
                # where curves coincide, those below are larger
                style: dict[str, Any] = {"color": SERIES[index % len(SERIES)], "lw": 1.2 if plan.grid else 0.0}
                if chosen.size <= _MARKED_POINTS or not plan.grid:
                    style |= {"marker": _MARKERS[index % len(_MARKERS)], "ms": 6.0 - 0.9 * index}
                label = f"{series.dimension.label} = {series.name(group)}" if series else None
                axes.plot(along.places[chosen], values[chosen], label=label, **style)
            if stopped.any():
                foot: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "color": GREY}
                label = "run stopped before its end"
                axes.plot(along.places[stopped], np.full(stopped.sum(), 0.02), "x", label=label, **foot)
            axes.set(title=_plain(q), ylabel=with_unit(_plain(q), q.unit))
            axes.ticklabel_format(axis="y", useOffset=False, scilimits=(-3, 5))
            _scale(axes, along, "x")
        handles, labels = panels[0][0].get_legend_handles_labels()
        if handles:
            drawn.figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 3))
    return drawn


def _maps(plan: Plan, frame: pd.DataFrame, first: _Direction, second: _Direction) -> Picture:
    """Draw every quantity in colour over two directions."""
    with _panels(plan, f"{first.dimension.label} and {second.dimension.label}") as (drawn, panels):
        for axes, q in panels:
            values = frame[q.name].to_numpy(float)
            mesh = _cells(axes, plan, first, second, values, {"cmap": "viridis", "norm": _norm(values)})
            if plan.grid:
                axes.patch.set(hatch="////", edgecolor=GREY)
            if np.isfinite(values).any():
                drawn.figure.colorbar(mesh, ax=axes, label=with_unit(_plain(q), q.unit), pad=0.02)
            axes.set_title(_plain(q))
        if frame[[q.name for q in plan.quantities]].isna().any(axis=None):
            patch = Patch(facecolor="white", edgecolor=GREY, hatch="////", label="no such value")
            drawn.figure.legend(handles=[patch], loc="outside lower center")
    return drawn


def _regimes(plan: Plan, frame: pd.DataFrame, first: _Direction, second: _Direction) -> Picture:
    """Draw what the first macro-collision is over two directions."""
    regimes = frame["regime"].replace("", _FAILED).tolist()
    present = [name for name in _COLOURS if name in regimes]
    index = np.array([present.index(regime) for regime in regimes], dtype=float)
    palette = [_COLOURS[name] for name in present]
    colours = {"cmap": ListedColormap(palette), "norm": Normalize(-0.5, len(present) - 0.5)}
    counts = ", ".join(f"{regimes.count(name)} {name}" for name in present)
    over = f"{first.dimension.label} and {second.dimension.label}"
    with picture(f"What the first macro-collision is over {over}. Runs: {counts}.", 7.1, 4.0) as drawn:
        axes = drawn.figure.add_subplot()
        _cells(axes, plan, first, second, index, colours)
        axes.set_title("First macro-collision")
        handles = [
            Patch(facecolor=colour, edgecolor=GREY, label=name)
            for name, colour in zip(present, palette, strict=True)
        ]
        drawn.figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 7))
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
    return axes.pcolormesh(
        *(_edges(direction) for direction in (first, second)),
        np.ma.masked_invalid(table.to_numpy()),
        rasterized=values.size > _MARKED_CELLS,
        **colours,
    )


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
    dimension = direction.dimension
    getattr(axes, f"set_{which}label")(with_unit(dimension.label, "" if direction.words else dimension.unit))
    if direction.words:
        words = [word if len(word) <= 22 else f"{word[:21]}…" for word in direction.words]
        turned = 25.0 if which == "x" and sum(map(len, words)) > 36 else 0.0
        getattr(axes, f"{which}axis").set_ticks(range(len(words)), words, rotation=turned)
    elif dimension.spacing == "log":
        getattr(axes, f"set_{which}scale")("log")
    elif all(float(place).is_integer() for place in direction.distinct):
        getattr(axes, f"{which}axis").get_major_locator().set_params(integer=True)


def _plain(q: Quantity) -> str:
    return q.name.replace("_", " ")

"""Pictures of sweeps: curves, maps, the map of what happens in the collision, steady responses up and down."""

from __future__ import annotations

import json
import math
import re
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from oblique_impact.errors import Outcome
from oblique_impact.renders.panels import unit_for
from oblique_impact.renders.style import FREE_COLOUR, GREY, SERIES, SLIP_COLOUR, STICK_COLOUR
from oblique_impact.validation.report import FULL, Block, Picture, number, picture, shown_unit, with_unit
from oblique_impact.validation.studies.design import AxisSection, Plan
from oblique_impact.validation.studies.periodic import HARMONICS, drive_period
from oblique_impact.validation.studies.quantities import VARIABLES, Quantity
from oblique_impact.validation.studies.study import LARGEST, LEAST, REGIMES, SAMPLES, SECTION, SPECTRUM

#: so many values of the second direction are drawn as curves, more as a map
_CURVES = 5
_MARKERS = ("o", "s", "^", "D", "v")
#: characters of a line of the label of an axis, across and up a panel
_ACROSS, _UP = 52, 34
_SWITCH = {"True": "yes", "False": "no"}
#: values of other directions beside each other in a picture of steady responses
_COLUMNS = 3
#: the ways along the last direction of steady responses
_WAYS: dict[str, dict[str, Any]] = {
    "up": {"marker": "o", "mew": 0.0, "color": "#f0a868"},
    "down": {"marker": "o", "mew": 0.0, "color": SERIES[0]},
}
#: least and largest size (points) of a dot of the way up; those of the way down have half of it
_DOTS = 3.6, 7.0
#: longer curves are lines without marks; larger maps are images
_MARKED_POINTS, _MARKED_CELLS = 30, 1500
#: a largest value this many times the middle one asks for a logarithmic scale
_SPREAD = 8.0
_COLOURS = dict(
    zip(
        (*REGIMES, "failed"),
        (FREE_COLOUR, SLIP_COLOUR, SERIES[3], STICK_COLOUR, SERIES[4], GREY, "white"),
        strict=True,
    )
)


class _Axis:
    """The axis of a direction: the place of every run on it, and the words there, if it has no numbers."""

    def __init__(self, direction: AxisSection, frame: pd.DataFrame) -> None:
        column, self.direction, self.words = frame[direction.names[0]], direction, list[str]()
        moved = _moved(column)
        if moved is not None:
            self.places = moved
        elif pd.api.types.is_numeric_dtype(column) and not pd.api.types.is_bool_dtype(column):
            self.places = column.to_numpy(float)
        else:
            places, words = pd.factorize(column.map(str))
            self.places, self.words = places.astype(float), [_SWITCH.get(word, word) for word in words]

    def name(self, place: float) -> str:
        """Return a value as text, with its unit."""
        if self.words:
            return self.words[round(place)]
        return f"{number(float(place), 4)} {shown_unit(self.direction.unit)}".strip()

    @property
    def edges(self) -> np.ndarray:
        """Edges of the cells around its values, half-way between them as the axis is spread."""
        log = self.direction.spacing == "log" and not self.words
        centres = np.log(np.unique(self.places)) if log else np.unique(self.places)
        inner = 0.5 * (centres[1:] + centres[:-1])
        edges = np.array([2.0 * centres[0] - inner[0], *inner, 2.0 * centres[-1] - inner[-1]])
        return np.exp(edges) if log else edges

    def label(self, axes: Axes, which: str) -> None:
        """Label one axis ("x" or "y"), spread as the sweep is; words get a tick each."""
        axis, unit = getattr(axes, f"{which}axis"), "" if self.words else self.direction.unit
        axis.set_label_text(_wrapped(with_unit(self.direction.words, unit), _ACROSS if which == "x" else _UP))
        if self.words:
            words = [word if len(word) <= 22 else f"{word[:21]}…" for word in self.words]
            turned = 25.0 if which == "x" and sum(map(len, words)) > 36 else 0.0
            axis.set_ticks(range(len(words)), words, rotation=turned)
        elif self.direction.spacing == "log":
            getattr(axes, f"set_{which}scale")("log")
        elif np.array_equal(self.places, np.round(self.places)):
            axis.get_major_locator().set_params(integer=True)


def _moved(column: pd.Series) -> np.ndarray | None:
    """Return the one component that changes of places, which are JSON; None of other values."""
    try:
        values = np.array([json.loads(text) for text in column], dtype=float)
    except (TypeError, ValueError):
        return None
    if values.ndim != 2:
        return None
    (moving,) = np.nonzero(np.ptp(values, axis=0))
    return np.asarray(values[:, moving[0]]) if moving.size == 1 else None


def sweep_pictures(plan: Plan, frame: pd.DataFrame, jumps: pd.DataFrame | None = None) -> list[Block]:
    """Return the pictures of a sweep, with `jumps` of steady responses; none of more than two directions."""
    axes = [_Axis(direction, frame) for direction in plan.directions]
    if plan.file.periodic:
        return list(_responses(plan, frame, axes, pd.DataFrame() if jumps is None else jumps))
    if len(axes) > 2 or len(frame) < 2:
        return []
    if len(axes) == 1:
        return [_curves(plan, frame, axes[0], None)]
    first, second = axes
    if plan.grid:
        for series, along in ((second, first), (first, second)):
            if series.words or np.unique(series.places).size <= _CURVES:
                return [_curves(plan, frame, along, series)]
    regimes = [_regimes(plan, frame, first, second)] if len(set(frame["regime"]) - {""}) > 1 else []
    return [*regimes, _maps(plan, frame, first, second)]


@contextmanager
def _panels(plan: Plan, over: str) -> Iterator[tuple[Picture, list[tuple[Axes, Quantity]]]]:
    """Make a picture with a panel for each quantity."""
    count = len(plan.quantities)
    rows = math.ceil(count / 2)
    with picture(f"Quantities over {over}.", FULL, 3.0 * rows + 0.4) as drawn:
        panels = drawn.figure.subplots(rows, min(count, 2), squeeze=False).ravel()
        for axes in panels[count:]:
            axes.axis("off")
        yield drawn, list(zip(panels, plan.quantities, strict=False))


def _curves(plan: Plan, frame: pd.DataFrame, along: _Axis, series: _Axis | None) -> Picture:
    """Draw every quantity over one direction, a curve for each value of the other."""
    stopped = frame["outcome"].to_numpy() != Outcome.COMPLETED.label
    groups = series.places if series else np.zeros(len(frame))
    with _panels(plan, along.direction.words) as (drawn, panels):
        for axes, q in panels:
            for index, group in enumerate(np.unique(groups)):
                curve = pd.DataFrame({"x": along.places, "y": frame[q.name]})[groups == group].sort_values("x")
                # where curves coincide, those below are larger
                style: dict[str, Any] = {"color": SERIES[index % len(SERIES)], "lw": 1.2 if plan.grid else 0.0}
                if len(curve) <= _MARKED_POINTS or not plan.grid:
                    style |= {"marker": _MARKERS[index % len(_MARKERS)], "ms": 6.0 - 0.9 * index}
                label = f"{series.direction.words} = {series.name(group)}" if series else None
                axes.plot(curve["x"], curve["y"], label=label, **style)
            if stopped.any():
                foot: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "color": GREY}
                label = "run stopped before its end"
                axes.plot(along.places[stopped], np.full(stopped.sum(), 0.02), "x", label=label, **foot)
            axes.set_ylabel(_wrapped(with_unit(q.meaning, q.unit)))
            axes.ticklabel_format(axis="y", useOffset=False, scilimits=(-3, 5))
            _count(axes, frame[q.name])
            along.label(axes, "x")
        handles, labels = panels[0][0].get_legend_handles_labels()
        if handles:
            drawn.figure.legend(handles, labels, loc="outside lower center", ncols=1 if series else 3)
    return drawn


def _maps(plan: Plan, frame: pd.DataFrame, first: _Axis, second: _Axis) -> Picture:
    """Draw every quantity in colour over two directions."""
    missing = Patch(facecolor="white", edgecolor=GREY, hatch="////", label="no such value")
    with _panels(plan, f"{first.direction.words} and {second.direction.words}") as (drawn, panels):
        for axes, q in panels:
            values = frame[q.name].to_numpy(float)
            known = values[np.isfinite(values)]
            # a logarithmic scale for values that a few large ones dominate
            wide = known.size and known.min() > 0.0 and known.max() > _SPREAD * np.median(known)
            mesh = _cells(axes, plan, first, second, values, "viridis", LogNorm() if wide else Normalize())
            if plan.grid:
                axes.patch.set(hatch="////", edgecolor=GREY)
            if known.size:
                bar = drawn.figure.colorbar(mesh, ax=axes, label=_wrapped(with_unit(q.meaning, q.unit)), pad=0.02)
                if not wide:
                    _count(bar.ax, known)
        if frame[[q.name for q in plan.quantities]].isna().any(axis=None):
            drawn.figure.legend(handles=[missing], loc="outside lower center")
    return drawn


def _regimes(plan: Plan, frame: pd.DataFrame, first: _Axis, second: _Axis) -> Picture:
    """Draw what the first macro-collision is over two directions."""
    regimes = frame["regime"].replace("", "failed").tolist()
    present = {name: colour for name, colour in _COLOURS.items() if name in regimes}
    index = np.array([list(present).index(regime) for regime in regimes], dtype=float)
    counts = ", ".join(f"{regimes.count(name)} {_title(name)}" for name in present)
    over = f"{first.direction.words} and {second.direction.words}"
    with picture(f"What the first macro-collision is over {over}. Runs: {counts}.", 7.1, 4.0) as drawn:
        axes = drawn.figure.add_subplot()
        palette, norm = ListedColormap(list(present.values())), Normalize(-0.5, len(present) - 0.5)
        _cells(axes, plan, first, second, index, palette, norm)
        axes.set_title("First macro-collision")
        handles = [Patch(facecolor=colour, edgecolor=GREY, label=_title(name)) for name, colour in present.items()]
        drawn.figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    return drawn


def _cells(
    axes: Axes,
    plan: Plan,
    first: _Axis,
    second: _Axis,
    values: np.ndarray,
    palette: Any,
    norm: Normalize,
) -> Any:
    """Draw values in colour: cells of a grid, or scattered points."""
    axes.grid(visible=False)
    first.label(axes, "x")
    second.label(axes, "y")
    colours: dict[str, Any] = {"cmap": palette, "norm": norm}
    table = pd.DataFrame({"x": first.places, "y": second.places, "value": values})
    if not plan.grid:
        missing, known = table[table["value"].isna()], table.dropna()
        axes.plot(missing["x"], missing["y"], "x", color=GREY, ms=4)
        return axes.scatter(known["x"], known["y"], s=16, c=known["value"], **colours)
    table = table.pivot(index="y", columns="x", values="value")
    cells = np.ma.masked_invalid(table.to_numpy())
    colours |= {"edgecolors": "face", "linewidth": 0.3}  # else screens show gaps
    return axes.pcolormesh(first.edges, second.edges, cells, rasterized=len(values) > _MARKED_CELLS, **colours)


def _title(regime: str) -> str:
    return "Painlevé" if regime == "painleve" else regime


def _count(axes: Axes, values: pd.Series | np.ndarray) -> None:
    """Label whole numbers alone up an axis of values that are all whole."""
    found = np.asarray(values, dtype=float)
    if np.all(found[np.isfinite(found)] % 1.0 == 0.0):
        axes.yaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))


def _wrapped(label: str, width: int = _UP) -> str:
    """Break the label of an axis, not before a unit."""
    whole = re.sub(r"(?<=\d) | (?=\()", "\xa0", label)
    return textwrap.fill(whole, width, break_on_hyphens=False).replace("\xa0", " ")


def _responses(plan: Plan, frame: pd.DataFrame, axes: Sequence[_Axis], jumps: pd.DataFrame) -> Iterator[Picture]:
    """Draw the steady responses over the last direction, a picture for a few values of the other ones."""
    *others, along = axes
    names = [
        ", ".join(f"{axis.direction.words} = {axis.name(axis.places[n])}" for axis in others)
        for n in range(len(frame))
    ]
    groups, over = list(dict.fromkeys(names)), along.direction.words
    for first in range(0, len(groups), _COLUMNS):
        columns = {name: frame[[other == name for other in names]] for name in groups[first : first + _COLUMNS]}
        width, height = FULL if len(columns) > 1 else 0.75 * FULL, 2.0 * (2 + len(plan.quantities)) + 0.4
        lines = " Lines are jumps." if len(jumps) else ""
        with picture(f"Steady response over {over}, on the way up and down.{lines}", width, height) as drawn:
            draw_responses(drawn.figure, plan, columns, jumps)
        yield drawn
    for name in groups[:_COLUMNS]:
        part = frame[[other == name for other in names]]
        shown = _chosen(part)
        if shown:
            words = (
                f"Steady states{f' at {name}' if name else ''}: Poincaré section, at whole periods, and spectrum."
            )
            with picture(words, FULL, 5.2) as drawn:
                _draw_states(drawn.figure, plan, part, shown)
            yield drawn


def basin_pictures(plan: Plan, table: pd.DataFrame) -> list[Picture]:
    """Return the picture of the starts that come to the states of the ways up and down, if there are any."""
    if table.empty or plan.file.periodic is None:
        return []
    sample, last = plan.file.periodic.sample, plan.directions[-1]
    unit = VARIABLES[sample][0]
    factor, prefix = unit_for([table["value"].to_numpy(float)]) if shown_unit(unit) else (1.0, "")
    at = f"{number(table.attrs['at'], 4)} {shown_unit(last.unit)}".strip()
    words = f"Starts at {at}, by the motion that they come to; stars are the two motions at a whole period."
    with picture(words, 0.75 * FULL, 3.8) as drawn:
        axes = drawn.figure.subplots()
        for way, style in _WAYS.items():
            on, (value, rate) = table[table["way"] == way], table.attrs["states"][way]
            label, colour = f"to that of the way {way}", style["color"]
            axes.plot(on["value"] / factor, on["rate"], "s", ms=7.0, mew=0.0, color=colour, label=label)
            axes.plot(value / factor, rate, "*", ms=14.0, color=colour, mec="black", mew=0.8)
        axes.set_xlabel(with_unit(sample.replace("_", " "), prefix + unit))
        axes.set_ylabel(with_unit("rate", f"{unit}/s" if shown_unit(unit) else "1/s"))
        axes.grid(visible=False)
        drawn.figure.legend(loc="outside lower center", ncols=2)
    return [drawn]


def _chosen(frame: pd.DataFrame) -> list[int]:
    """Return the rows of up to three steady states: of one period, of several, of none; of each the widest."""
    found = frame[frame[SAMPLES] != ""]
    swing, period = found[LARGEST] - found[LEAST], found["period"]
    kinds = [period == 1.0, period > 1.0, period == 0.0]
    return [int(swing[kind].idxmax()) for kind in kinds if kind.any()]


def _draw_states(figure: Figure, plan: Plan, frame: pd.DataFrame, rows: Sequence[int]) -> None:
    """Draw Poincaré sections above, spectra below, a column for each of some rows."""
    assert plan.file.periodic is not None
    sample, last = plan.file.periodic.sample, plan.directions[-1]
    unit, axis = VARIABLES[sample][0], _Axis(last, frame)
    places = dict(zip(frame.index, axis.places, strict=True))
    sections = {n: np.array(json.loads(frame.at[n, SECTION]), dtype=float).reshape(-1, 2) for n in rows}
    factor, prefix = unit_for([points[:, 0] for points in sections.values()]) if shown_unit(unit) else (1.0, "")
    panels = figure.subplots(2, len(rows), squeeze=False, sharey="row")
    for n, (above, below) in zip(rows, panels.T, strict=True):
        points, lines = sections[n] / factor, np.array(json.loads(frame.at[n, SPECTRUM])) / factor
        repeats = frame.at[n, "period"] > 0.0
        above.plot(points[:, 0], points[:, 1] * factor, "o", ms=6.0 if repeats else 2.2, mew=0.0, color=SERIES[0])
        period = f"period {len(points) if repeats else 'none'}"
        above.set_title(f"{axis.name(places[n])}, {frame.at[n, 'direction']}: {period}")
        above.set_xlabel(with_unit(sample.replace("_", " "), prefix + unit))
        above.margins(0.15)
        scenario = plan.runs[n].scenario
        assert scenario is not None
        step = HARMONICS / (drive_period(scenario) * (len(lines) - 1))
        frequencies = step * np.arange(1, len(lines))
        if repeats:
            below.vlines(frequencies, 1e-12, lines[1:], color=SERIES[0], lw=1.6)
        else:
            below.plot(frequencies, lines[1:], color=SERIES[0], lw=0.9)
        below.set(yscale="log", xlabel="frequency (Hz)", xlim=(0.0, frequencies[-1]))
    largest = max(axes.dataLim.y1 for axes in panels[1])
    panels[1, 0].set(ylim=(1e-5 * largest, 2.0 * largest), ylabel=with_unit("amplitude", prefix + unit))
    panels[0, 0].set_ylabel(with_unit("rate", f"{unit}/s" if shown_unit(unit) else "1/s"))


def draw_responses(
    figure: Figure, plan: Plan, columns: Mapping[str, pd.DataFrame], jumps: pd.DataFrame | None = None
) -> None:
    """Draw the rows of a sweep of steady responses over its last direction, a column for each title and frame.

    The first panels hold the samples at whole periods, where a motion that does not repeat is a cloud, the next
    ones the least and the largest value over a period, if the frames have them, the others the quantities, by
    their symbols.  The way up is in large pale dots, the way down in small dark ones over them, so that both are
    seen where they agree.  Jumps, a table as of a sweep, are lines.
    """
    assert plan.file.periodic is not None
    sample, last = plan.file.periodic.sample, plan.directions[-1]
    rows = [(SAMPLES, f"{sample} at whole periods", VARIABLES[sample][0])]
    if all(LARGEST in frame for frame in columns.values()):
        rows.append((LARGEST, f"least and largest {sample}", VARIABLES[sample][0]))
    rows += [(q.name, q.name.replace(":", " "), q.unit) for q in plan.quantities]
    apart = 72.0 * figure.get_figwidth() / sum(frame[last.names[0]].nunique() for frame in columns.values())
    dot = float(np.clip(0.5 * apart, *_DOTS))
    heights = {"height_ratios": [1.5, *[1.0] * (len(rows) - 1)]}
    panels = figure.subplots(
        len(rows), len(columns), squeeze=False, sharex=True, sharey="row", gridspec_kw=heights
    )
    for (name, label, unit), beside in zip(rows, panels, strict=True):
        points = {title: _points(frame, last, name) for title, frame in columns.items()}
        values = [part["y"].to_numpy(float) for part in points.values()]
        factor, prefix = unit_for(values) if shown_unit(unit) else (1.0, "")
        for axes, part in zip(beside, points.values(), strict=True):
            for way, style in _WAYS.items():
                on, size = part[part["way"] == way], dot if way == "up" else 0.5 * dot
                axes.plot(on["x"], on["y"] / factor, ls="", ms=size, label=f"on the way {way}", **style)
            axes.grid(visible=False)
        _count(beside[0], np.concatenate(values))
        if name == "period":
            beside[0].yaxis.set_major_formatter(lambda value, _: f"{value:g}" if value else "none")
        beside[0].set_ylabel(_wrapped(with_unit(label.replace("_", " "), prefix + unit), 2 * _UP // 3))
    for (title, frame), column in zip(columns.items(), panels.T, strict=True):
        column[0].set_title(_wrapped(title))
        for _, jump in () if jumps is None else _jumps_of(plan, frame, jumps).iterrows():
            for axes in column:
                place = 0.5 * (jump["last before"] + jump["first behind"])
                axes.axvline(place, color=_WAYS[jump["direction"]]["color"], lw=0.8, ls="--")
        column[-1].xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        _Axis(last, frame).label(column[-1], "x")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, markerscale=1.4)


def _jumps_of(plan: Plan, frame: pd.DataFrame, jumps: pd.DataFrame) -> pd.DataFrame:
    """Return the jumps at the values that the other axes have in a frame."""
    keys = [key for direction in plan.directions[:-1] for key in direction.names]
    here = [all(jump[key] == frame[key].iloc[0] for key in keys) for _, jump in jumps.iterrows()]
    return jumps[here] if len(jumps) else jumps


def _points(frame: pd.DataFrame, along: AxisSection, name: str) -> pd.DataFrame:
    """Return points x, y and the way of one column, several of a row of samples."""
    y = frame[name].map(lambda text: json.loads(text or "[]")) if name == SAMPLES else frame[name]
    y = pd.Series(frame[[LEAST, LARGEST]].to_numpy().tolist()) if name == LARGEST else y
    points = pd.DataFrame({"x": _Axis(along, frame).places, "y": y.tolist(), "way": frame["direction"].tolist()})
    return points.explode("y").astype({"y": float})

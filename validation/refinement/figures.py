"""Pictures of a refinement study: differences over sizes, values over levels, ladders side by side."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, NullFormatter, NullLocator

from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.validation.refinement.study import LadderResult, QuantityResult
from oblique_impact.validation.report.document import Picture, number, with_unit
from oblique_impact.validation.report.figures import new_figure, to_svg

#: width of the printed page: what is drawn is what is read
_PAGE, _ROW = 7.1, 2.9
_MARKS = ("o", "s", "^", "D", "v", "P", "X", "<")
_ZERO = 1e-17


def ladder_picture(result: LadderResult) -> Picture:
    """Relative differences between successive levels, and values relative to the finest, over the levels."""
    with new_figure(_PAGE, _ROW + 0.5) as figure:
        left, right = figure.subplots(1, 2)
        for index, item in enumerate(result.results):
            style = {"color": _colour(index), "marker": _MARKS[index % len(_MARKS)], "markersize": 4.5}
            _differences(left, result, item, style)
            _relative_values(right, result, item, style)
        _reference_slope(left, result)
        left.set_ylabel("relative difference")
        left.set_title("Difference from the level before")
        right.set_ylabel("value / value at the finest level")
        right.set_title("Values")
        for axes in (left, right):
            _level_axis(axes, result)
        handles, labels = right.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
        svg = to_svg(figure)
    words = "; ".join(f"{item.quantity.name}: {item.analysis.words}" for item in result.results)
    return Picture(
        svg,
        f"{result.ladder.name}. Left: differences between successive levels, relative to the finest value; finer "
        "levels are to the right; hollow marks are within the noise. Right: values.",
        f"Refinement of {result.ladder.name}: {words}.",
    )


def comparison_picture(results: Sequence[LadderResult], errors: bool) -> Picture:
    """Quantities of several ladders side by side, over elements or modes.

    With `errors`, differences from the finest level of the first ladder; else values.
    """
    names = [item.quantity.name for item in results[0].results]

    rows = math.ceil(len(names) / 2)
    with new_figure(_PAGE, _ROW * rows + 0.5) as figure:
        panels = figure.subplots(rows, 2, squeeze=False).ravel()
        for axes, name in zip(panels, names, strict=False):
            _compare(axes, results, name, errors)
        for axes in panels[len(names) :]:
            axes.axis("off")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
        svg = to_svg(figure)
    shown = f"differences from the finest level of {results[0].ladder.name}" if errors else "values"
    return Picture(
        svg,
        f"The ladders side by side: {shown}.",
        f"{', '.join(names)} over elements or modes for {', '.join(r.ladder.name for r in results)}.",
    )


def _compare(axes: Axes, results: Sequence[LadderResult], name: str, errors: bool) -> None:
    levels: set[float] = set()
    reference = results[0].quantity(name)
    for index, result in enumerate(results):
        x, y = np.array(result.ladder.levels), np.array(result.quantity(name).values)
        if errors:
            y = relative_errors(result.quantity(name), reference)
        label = result.ladder.name.removeprefix(f"{result.ladder.group}, ")
        line = "--" if result.axis.name == "elements" and not errors else "-"
        axes.plot(
            x, y, line, color=_colour(index), marker=_MARKS[index % len(_MARKS)], markersize=4.5, label=label
        )
        levels.update(result.ladder.levels)
    axes.set_title(name)
    axes.set_ylabel("relative difference" if errors else with_unit(_axis_words(name), reference.quantity.unit))
    axes.set_xscale("log", base=2)
    _ticks(axes, sorted(levels))
    kinds = sorted({r.axis.label for r in results}, reverse=True)
    axes.set_xlabel(" or ".join(kinds))
    spread = [abs(v) for r in results for v in r.quantity(name).values if math.isfinite(v)]
    if errors or (spread and min(spread) > 0.0 and max(spread) / min(spread) > 5.0):
        _decades(axes)
    else:
        axes.ticklabel_format(axis="y", useOffset=False)


def relative_errors(item: QuantityResult, reference: QuantityResult) -> np.ndarray:
    """Relative differences from the finest value of a reference, shape (levels,); NaN for the reference itself."""
    goal = reference.values[-1]
    errors = np.abs(np.array(item.values) / goal - 1.0) if goal else np.full(len(item.values), np.nan)
    return np.where(errors > 0.0, errors, np.nan)


def _axis_words(name: str) -> str:
    return name.replace("_", " ")


def _colour(index: int) -> str:
    return SERIES[index % len(SERIES)]


def _places(result: LadderResult) -> np.ndarray:
    """Levels as the horizontal axis shows them: numbers of elements or modes, or sizes."""
    return np.array(result.ladder.levels if result.axis.rising else result.sizes)


def _differences(axes: Axes, result: LadderResult, item: QuantityResult, style: dict[str, Any]) -> None:
    scale = max(abs(item.values[-1]), item.scale) if math.isfinite(item.values[-1]) else item.scale
    if not scale:
        return
    y = np.abs(np.array(item.analysis.differences)) / scale
    noise = item.analysis.noise / scale
    x = _places(result)
    seen = y > _ZERO
    axes.plot(x[seen], y[seen], "-", **style)
    within = seen & (y <= noise)
    axes.plot(x[within], y[within], "o", markersize=7, markerfacecolor="white", color=style["color"])


def _relative_values(axes: Axes, result: LadderResult, item: QuantityResult, style: dict[str, Any]) -> None:
    finest = item.values[-1]
    if not math.isfinite(finest) or finest == 0.0:
        known = [v for v in item.values if math.isfinite(v) and v != 0.0]
        finest = known[-1] if known else math.nan
    axes.plot(_places(result), np.array(item.values) / finest, "-", label=item.quantity.name, **style)


def _reference_slope(axes: Axes, result: LadderResult) -> None:
    """Grey line of the declared order, or of the first confirmed one, below the differences."""
    declared = [item.declared for item in result.results if item.declared]
    confirmed = [item.analysis.order for item in result.results if math.isfinite(item.analysis.order)]
    tops = [np.max(np.asarray(line.get_ydata()), initial=0.0) for line in axes.lines]
    if not (declared or confirmed) or not max(tops, default=0.0) > 0.0:
        return
    order = declared[0] if declared else confirmed[0]
    h, x = np.array(result.sizes)[1:], _places(result)[1:]
    y = 2.5 * max(tops) * (h / h[0]) ** order
    word = "declared order" if declared else "order"
    axes.plot(x, y, "--", color=GREY, linewidth=1.1)
    axes.annotate(
        f"{word} {order:.3g}",
        (x[0], y[0]),
        xytext=(4, 4),
        textcoords="offset points",
        color=GREY,
        fontsize=8.5,
    )


def _level_axis(axes: Axes, result: LadderResult) -> None:
    axes.set_xscale("log")
    if result.axis.rising:
        axes.set_xlabel(result.axis.heading)
    else:
        axes.set_xlabel(result.axis.size_label)
        axes.invert_xaxis()
    _ticks(axes, list(_places(result)))
    if axes.get_ylabel().startswith("relative"):
        _decades(axes)
    else:
        axes.ticklabel_format(axis="y", useOffset=False)
    axes.margins(x=0.08, y=0.1)


def _ticks(axes: Axes, places: list[float]) -> None:
    axes.set_xticks(places)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: number(float(value), 3)))
    axes.xaxis.set_minor_locator(NullLocator())
    if any(len(number(float(place), 3)) > 4 for place in places):
        axes.tick_params(axis="x", labelrotation=30)


def _decades(axes: Axes) -> None:
    """Scale the vertical axis by decades; one without a positive value, where no level differs, stays as it is."""
    if not any(np.any(np.asarray(line.get_ydata(), dtype=float) > 0.0) for line in axes.lines):
        return
    axes.set_yscale("log")
    axes.yaxis.set_minor_formatter(NullFormatter())

"""The map of the small-deflection model: page, numbers, picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from oblique_impact.beam.small_deflection import NOTICEABLE
from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.validation.report.document import (
    Block,
    Cell,
    Document,
    Paragraph,
    Picture,
    Section,
    Table,
    number,
    number_cells,
    write_csv,
    write_json,
    write_report,
)
from oblique_impact.validation.report.figures import FULL, new_figure, to_svg
from oblique_impact.validation.report.provenance import provenance, provenance_data
from oblique_impact.validation.small_deflection.errors import MODELS, Point, SmallDeflection

TITLES = {
    "held": "Held root, bent by the weight",
    "hub": "Heavy hub, bent by a torque",
    "light hub": "Hub of a twentieth of the beam's inertia",
    "pendulum": "Pinned beam that falls and turns",
    "stop": "Held root, pushed on an elastic stop",
}
#: inches, of the map
SIZE = (12.5, 9.5)
#: a colour for each model, and a line for each spin rate in ascending order
COLOURS = {
    "tangent, zeroth order": SERIES[5],
    "mean axis, zeroth order": SERIES[5],
    "tangent, first order": SERIES[0],
    "tangent, full": SERIES[1],
    "mean axis, first order": SERIES[2],
    "mean axis, full": SERIES[3],
}
_LINES: tuple[Literal["-", "--", "-.", ":"], ...] = ("-", "--", "-.", ":")
_LIMITS = (1e-4, 10.0)
#: a load that bends the beam by less than this more than the one before is not drawn: all models have failed
_MORE = 1.2
_TEXT = (
    "The floating frame bends linearly, and knows the shortening to the second order. Loads grow along the lower "
    "axis; the error is that of the deflection of the tip from the model's axis, its largest difference from "
    "the geometrically exact beam within two elastic periods, over the largest deflection; on a stop that of the "
    "largest force. Spin rates are in units of "
    "sqrt(EI/(ρA L⁴)): the first clamped mode has 3.52.",
    "A curve that ends early has runs that physics stopped: first-order kinetics in the tangent frame lose their "
    "mass. What rises to the left, up to 2 %, is the step of the exact beam at a fast spin.",
)


def write_small_deflection(folder: Path, result: SmallDeflection, command: str) -> Path:
    """Write report.html, results.json and results.csv; returns the page."""
    names = [field.name for field in fields(Point)]
    rows = [asdict(point) for point in result.points]
    write_json(
        folder,
        "results.json",
        {"study": "small-deflection", "command": command, "points": rows, **provenance_data()},
    )
    write_csv(folder, "results.csv", names, [[row[name] for name in names] for row in rows])
    return write_report(folder, _document(result, command))


def _document(result: SmallDeflection, command: str) -> Document:
    with new_figure(FULL, FULL * SIZE[1] / SIZE[0]) as figure:
        draw_map(figure, result.points)
        svg = to_svg(figure)
    words = "Relative error over the largest deflection"
    return Document(
        title="Where the small-deflection model ends",
        lead=_TEXT[0],
        facts=provenance(),
        times=[("command", command), ("wall time", f"{result.seconds:.1f} s")],
        overview=[Picture(svg, words, words), Paragraph(_TEXT[1], note=True)],
        sections=[Section(TITLES[problem], [_table(result, problem)]) for problem in MODELS],
    )


def _table(result: SmallDeflection, problem: str) -> Block:
    columns = (
        "model",
        "spin",
        "nominal deflection",
        "largest deflection / L",
        "relative error",
        "its estimate",
        "outcome",
    )
    rows: list[Sequence[str | Cell]] = [
        [
            Cell(point.model),
            *number_cells(point.spin, point.nominal, number(point.deflection, 3), number(point.error, 2)),
            *number_cells(number(point.estimate, 2)),
            Cell(point.outcome),
        ]
        for point in result.points
        if point.problem == problem
    ]
    return Table(columns, rows)


def draw_map(figure: Figure, points: Sequence[Point]) -> None:
    """Draw errors over deflections, a panel for each problem, a colour for each model, a line for each spin."""
    panels = figure.subplots(2, 3, sharey=True)
    for axes, problem in zip(panels.flat, MODELS, strict=False):
        _draw_panel(axes, [point for point in points if point.problem == problem])
        axes.set_title(TITLES[problem], fontsize=10)
        quantity = "largest force" if problem == "stop" else "deflection"
        axes.set_ylabel(f"relative error of the {quantity}")
    for axes in panels.flat[len(MODELS) :]:
        axes.remove()


def _draw_panel(axes: Axes, points: Sequence[Point]) -> None:
    spins = sorted({point.spin for point in points})
    for model in dict.fromkeys(point.model for point in points):
        for spin, line in zip(spins, _LINES, strict=False):
            mine = [point for point in points if (point.model, point.spin) == (model, spin)]
            mine = _growing(mine)
            deflection, error = (np.array([getattr(p, name) for p in mine]) for name in ("deflection", "error"))
            axes.loglog(deflection, error, line, color=COLOURS[model], linewidth=1.5, marker="o", markersize=2.5)
    axes.axhline(NOTICEABLE, color=GREY, linewidth=0.8)
    axes.annotate(
        "10 %", (0.985, 1.07 * NOTICEABLE), xycoords=("axes fraction", "data"), ha="right", color=GREY, fontsize=9
    )
    axes.set(xlabel="largest deflection / length", ylim=_LIMITS)
    handles: list[Any] = [
        Line2D([], [], color=COLOURS[model], label=model) for model in dict.fromkeys(p.model for p in points)
    ]
    handles += [
        Line2D([], [], color="black", linestyle=line, label=f"spin {spin:g}")
        for spin, line in zip(spins, _LINES, strict=False)
    ]
    axes.legend(handles=handles, fontsize=7.5, loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=2)


def _growing(points: Sequence[Point]) -> list[Point]:
    """Return points in the order of their loads, as long as these bend the beam more and more."""
    found: list[Point] = []
    for point in sorted(points, key=lambda point: point.nominal):
        if found and point.deflection < _MORE * found[-1].deflection:
            break
        found.append(point)
    return found

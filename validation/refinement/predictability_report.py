"""The report of a predictability study: growth along the run, the fan of the shadows, a verdict per collision."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.validation.refinement.growth import (
    LARGE,
    PREDICTABLE,
    SENSITIVE,
    SMALL,
    UNKNOWN,
    UNPREDICTABLE,
    CaseResult,
    Collision,
    Predictability,
)
from oblique_impact.validation.report.document import (
    Block,
    Cell,
    Document,
    Fold,
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

_KINDS = {PREDICTABLE: "pass", SENSITIVE: "partly", UNPREDICTABLE: "fail", UNKNOWN: "dim"}
CSV_COLUMNS = (
    "case",
    "collision",
    "start",
    "impulse",
    "fewest_contacts",
    "most_contacts",
    "growth",
    "lower_bound",
    "verdict",
)
_RULE = (
    "Each shadow starts at an initial angle that differs by no more than d. The growth of a time t is "
    "max |t(θ₀ + d) − t(θ₀)| / (|d| T), with T the time of the first touch-down: about 1 if the motion carries a "
    "difference along, and more if each contact magnifies it.",
    f"A macro-collision is predictable if the growth of its start is at most {SMALL:g}, sensitive up to "
    f"{LARGE:g}, and not predictable from there on or if the physics stops a shadow before it. What is not "
    "predictable is no number of the beam: rounding, a tolerance or another compiler move it as far. Its spread "
    "is given instead.",
    "A shadow that comes to its end time without some event would have it later: what is left of the run is a "
    f"lower bound of the difference. A bound below {LARGE:g} gives no verdict. Shadows that failed, by an error "
    "or a timeout, are left out and named; without any shadow there is no verdict.",
    "This is said of the model as it stands. A coarse one may be predictable and far from its limit: its "
    "refinement shows that.",
)
#: s; differences below are rounding
_LEAST = 1e-17


def write_predictability(folder: Path, result: Predictability, command: str) -> Path:
    """Write report.html, results.json and results.csv; returns the page."""
    write_json(folder, "results.json", _data(result, command))
    write_csv(folder, "results.csv", CSV_COLUMNS, _csv_rows(result))
    return write_report(folder, _document(result, command))


def _data(result: Predictability, command: str) -> dict[str, Any]:
    return {
        "study": result.name,
        "command": command,
        "rule": list(_RULE),
        **provenance_data(),
        "cases": [_case_data(case) for case in result.cases],
        "times": {"wall_time": result.seconds},
    }


def _case_data(case: CaseResult) -> dict[str, Any]:
    return {
        "name": case.case.name,
        "scenario": case.case.scenario.model_dump(mode="json"),
        "perturbations": list(case.perturbations),
        "offsets": case.offsets.tolist(),
        "unit_time": case.unit_time,
        "events": case.events.tolist(),
        "shadows": case.shadows.tolist(),
        "growth": case.growth.tolist(),
        "horizon": case.horizon,
        "failed": [
            {"offset": offset, "outcome": row["outcome"], "message": row["message"]} for offset, row in case.failed
        ],
        "collisions": [vars(collision) for collision in case.collisions],
    }


def _csv_rows(result: Predictability) -> Iterable[list[Any]]:
    for case in result.cases:
        for c in case.collisions:
            yield [case.case.name, c.number, c.start, c.impulse, *c.contacts, c.growth, c.lower_bound, c.verdict]


def _document(result: Predictability, command: str) -> Document:
    count = sum(len(case.rows) + len(case.failed) for case in result.cases)
    return Document(
        "Predictability: shadow runs",
        "Do the times and impulses of an impact mean anything? Shadow runs start at initial angles that differ by "
        "less than anyone can measure; where they part, nothing that follows is a number of the beam.",
        [("runs", str(count)), *provenance()],
        [("command", command), ("wall time", f"{result.seconds:.1f} s")],
        overview=[
            _verdicts(result),
            *([_growth_picture(result)] if any(case.events.size for case in result.cases) else []),
            Fold("How a verdict is found", [Paragraph(text) for text in _RULE]),
        ],
        sections=[_section(case) for case in result.cases],
    )


def _verdicts(result: Predictability) -> Table:
    most = max((len(case.collisions) for case in result.cases), default=0)
    rows: list[list[str | Cell]] = []
    for case in result.cases:
        cells = [Cell(_verdict_words(c), _KINDS[c.verdict]) for c in case.collisions]
        rows.append([case.case.name, *cells, *[Cell("", "dim")] * (most - len(cells))])
    columns = ["", *(f"collision {n}" for n in range(1, most + 1))]
    return Table(columns, rows, "Verdicts, with the growth of the start of each macro-collision")


def _verdict_words(c: Collision) -> str:
    return f"{c.verdict}, {_growth(c, 2)}" if math.isfinite(c.growth) else c.verdict


def _growth(c: Collision, digits: int) -> str:
    return ("≥ " if c.lower_bound else "") + number(c.growth, digits)


def _growth_picture(result: Predictability) -> Picture:
    """Largest growth until each event, a line a case: what is lost once does not come back."""
    with new_figure(FULL, 3.9) as figure:
        axes = figure.subplots()
        for index, case in enumerate(result.cases):
            growth = np.maximum.accumulate(np.where(np.isfinite(case.growth), case.growth, 0.0))
            colour = SERIES[index % len(SERIES)]
            axes.step(case.events, growth, where="post", color=colour, linewidth=1.4, label=case.case.name)
        _thresholds(axes)
        axes.set(xlabel="time of the event (s)", ylabel="largest growth so far", yscale="log")
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
        svg = to_svg(figure)
    words = "; ".join(
        f"{case.case.name}: {', '.join(c.verdict for c in case.collisions) or 'no contact'}"
        for case in result.cases
    )
    return Picture(
        svg,
        "Largest growth of the difference of an event's time, from run to shadow, until then.",
        f"Growth. {words}.",
    )


def _thresholds(axes: Axes) -> None:
    for level, words in ((SMALL, "predictable below"), (LARGE, "not predictable above")):
        axes.axhline(level, color=GREY, linewidth=0.9, linestyle="--")
        axes.annotate(
            words,
            (0.0, level),
            xycoords=("axes fraction", "data"),
            xytext=(4, 3),
            textcoords="offset points",
            fontsize=8.5,
            color=GREY,
        )


def _section(case: CaseResult) -> Section:
    blocks: list[Block] = [Paragraph(case.case.text)] if case.case.text else []
    blocks += [Paragraph(f"{remark[0].upper()}{remark[1:]}.") for remark in case.remarks]
    if not case.collisions:
        return Section(case.case.name, blocks)
    if math.isfinite(case.horizon):
        blocks.append(Paragraph(f"The last event that is predicted is at {case.horizon:.6g} s."))
    blocks += [_fan_picture(case), _collision_table(case)]
    return Section(case.case.name, blocks)


def _fan_picture(case: CaseResult) -> Picture:
    """Differences of the event times, and the events themselves, a row a run."""
    with new_figure(FULL, 4.2) as figure:
        left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.35))
        colours = {d: SERIES[k % len(SERIES)] for k, d in enumerate(sorted(case.perturbations))}
        order = np.argsort(case.offsets)
        for d, times in zip(case.amplitudes, case.shadows, strict=True):
            shift = np.abs(times - case.events)
            left.plot(case.events, np.where(shift > _LEAST, shift, np.nan), "-", color=colours[d], lw=0.8)
        left.set(xlabel="time of the event (s)", ylabel="difference from run to shadow (s)", yscale="log")
        rows = [case.events, *case.shadows[order]]
        shades = ["black", *(colours[d] for d in case.amplitudes[order])]
        for height, (times, shade) in enumerate(zip(rows, shades, strict=True)):
            known = times[np.isfinite(times)]
            right.vlines(known, height - 0.36, height + 0.36, color=shade, linewidth=0.9)
        right.set(xlabel="events (s)", ylabel="runs, by initial angle; black: unperturbed")
        right.set_yticks([])
        for d, colour in colours.items():
            left.plot([], [], color=colour, label=f"initial angle ± {d:g} rad")
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
        svg = to_svg(figure)
    words = ", ".join(f"collision {c.number} {c.verdict}" for c in case.collisions)
    return Picture(
        svg,
        "Left: how far the events of the shadows are from those of the unperturbed run. Right: the fan, every "
        "event of every run.",
        f"Shadows of {case.case.name}: {words}.",
    )


def _collision_table(case: CaseResult) -> Table:
    rows: list[list[str | Cell]] = [
        [
            *number_cells(c.number, number(c.start, 9)),
            *number_cells(*c.spread, digits=2),
            *number_cells(number(c.impulse, 7)),
            *number_cells(*c.impulse_spread, digits=2),
            *number_cells(_contacts(c), _growth(c, 3)),
            Cell(c.verdict, _KINDS[c.verdict]),
        ]
        for c in case.collisions
    ]
    labels = [f"{d:g} rad" for d in case.perturbations]
    columns = [
        "collision",
        "start (s)",
        *(f"by {label} (s)" for label in labels),
        "impulse (N s)",
        *(f"by {label} (N s)" for label in labels),
        "contacts",
        "growth",
        "verdict",
    ]
    caption = (
        "Macro-collisions, and how far the shadows move them; a start that a shadow lacks is later than its end"
    )
    return Table(columns, rows, caption)


def _contacts(c: Collision) -> str:
    fewest, most = c.contacts
    return str(fewest) if fewest == most else f"{fewest} to {most}"

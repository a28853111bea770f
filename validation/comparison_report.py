"""The report of a comparison: a page with a picture, or the numbers as JSON."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

from oblique_impact.errors import InputError
from oblique_impact.files import prepare_folder
from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.validation.comparison import Comparison, VariableDifference, shown
from oblique_impact.validation.event_pairs import EventPair
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
    with_unit,
    write_json,
    write_report,
)
from oblique_impact.validation.report.figures import new_figure, to_svg
from oblique_impact.validation.report.provenance import provenance, provenance_data

#: what the picture shows, if both histories have it: label and unit of the axis
DRAWN = {
    "gap": "gap (m)",
    "theta_dot": "angular velocity (rad/s)",
    "lambda_n": "normal force (N)",
    "slip_rate": "slip velocity (m/s)",
}
SUFFIXES = (".html", ".json")


def check_target(out: Path) -> None:
    """Raise InputError for a file of another kind."""
    if out.suffix not in SUFFIXES:
        raise InputError(f"--out {out}: should end in {' or '.join(SUFFIXES)}")


def save_comparison(found: Comparison, out: Path, command: str) -> Path:
    """Write a page (.html) or the numbers (.json), whole or not at all; `command` repeats it.

    Raises InputError for another suffix, or if the file cannot be written.
    """
    check_target(out)
    folder = prepare_folder(out.parent)
    if out.suffix == ".json":
        return write_json(folder, out.name, comparison_data(found, command))
    return write_report(folder, comparison_document(found, command), out.name)


def comparison_data(found: Comparison, command: str) -> dict[str, Any]:
    """Return everything that was found as plain data in SI units; differences are right minus left."""
    return {
        "command": command,
        "names": found.names,
        "outcomes": found.outcomes,
        "changed_keys": found.changed_keys,
        "warnings": [{"runs": names, "warning": text} for names, text in found.warnings],
        "span": found.span,
        "max_shift": found.max_shift,
        "largest_shift": found.largest_shift,
        "state_disagreement": found.state_disagreement,
        "events": [_event_data(pair) for pair in found.events],
        "variables": [
            {**asdict(v), "plain": v.plain._asdict(), "aligned": v.aligned._asdict()}
            for v in found.variables.values()
        ],
        "measures": [{**m._asdict(), "difference": m.difference} for m in found.measures],
        "skipped": dict(found.skipped),
        **provenance_data(),
    }


def _event_data(pair: EventPair) -> dict[str, Any]:
    return {
        "kind": pair.event.kind.value,
        "state": pair.event.state.name.lower(),
        "left_time": pair.left and pair.left.time,
        "right_time": pair.right and pair.right.time,
        "time_difference": pair.time_difference,
        "impulse_difference": pair.impulse_difference,
    }


def comparison_document(found: Comparison, command: str) -> Document:
    """Return the report as a document."""
    left, right = found.names
    _, *sentences = found.findings()
    sentences += [f"Warning ({names}): {text}" for names, text in found.warnings]
    events = ["", "event", f"{left}: t (s)", f"{right}: t (s)", "difference (s)"]
    events += [f"{name}: impulse (N s)" for name in found.names]
    measures: list[list[str | Cell]] = [
        [m.name, m.unit, *number_cells(m.left, m.right, m.difference, digits=9)] for m in found.measures
    ]
    measured = Table(["", "unit", *found.names, "difference"], measures)
    rows: list[list[str | Cell]] = [
        [*number_cells(n), pair.kind, *number_cells(*pair.cells())] for n, pair in enumerate(found.events, 1)
    ]
    skipped = "; ".join(f"{name}: {why}" for name, why in found.skipped.items())
    return Document(
        f"{left} and {right}",
        f"Two runs side by side, from {found.span[0]:g} to {found.span[1]:g} s. Differences are those of {right} "
        f"from {left}.",
        provenance(),
        [("command", command)],
        [*(Paragraph(sentence) for sentence in sentences), _scenarios(found), _picture(found)],
        [
            Section("Variables", [_variables(found), Paragraph(f"Not compared: {skipped}.", note=True)]),
            Section("Events", [Table(events, rows)]),
            *([Section("Collisions and energies", [measured])] if measures else []),
        ],
    )


def _scenarios(found: Comparison) -> Block:
    rows: list[list[str | Cell]] = [
        [Cell(key, "code"), shown(a), shown(b)] for key, (a, b) in found.changed_keys.items()
    ]
    if not rows:
        return Paragraph("The scenarios are the same.")
    return Table(["key", *found.names], rows, "Keys of the scenarios that differ", wide=(1, 2))


def _variables(found: Comparison) -> Table:
    rows = [[Cell(v.name, "code"), *_scaled(v)] for v in found.variables.values()]
    columns = ["variable", "scale", "rms, same time", "largest", "at (s)", "rms, aligned", "largest", "at (s)"]
    return Table(
        [*columns, "distance of curves"],
        rows,
        "Differences relative to the scale, the range of the values: at the same time; aligned, on a clock in "
        "which shared events coincide; and, for variables that jump, as the distance of the two curves.",
    )


def _scaled(v: VariableDifference) -> list[Cell]:
    unit = v.unit.removeprefix("1")
    cells = [f"{number(v.scale, 4)} {unit}".strip()]
    for deviation in (v.plain, v.aligned):
        cells += [number(v.relative(value), 2) for value in deviation[:2]] + [number(deviation.at)]
    return number_cells(*cells, number(v.hausdorff, 2))


def _picture(found: Comparison) -> Picture:
    """Draw both runs on top of each other."""
    names = [name for name in DRAWN if name in found.variables] or list(found.variables)[:1]
    with new_figure(9.2, 2.2 * len(names) + 0.5) as figure:
        panels = figure.subplots(len(names), 1, sharex=True, squeeze=False).ravel()
        for axes, name in zip(panels, names, strict=True):
            styles = ({"color": SERIES[0], "linewidth": 2.0}, {"color": SERIES[1], "linewidth": 1.0})
            for history, label, style in zip(found.histories, found.names, styles, strict=True):
                values = history[name].values
                axes.plot(history["time"].values, values.reshape(len(values), -1)[:, -1], label=label, **style)
            for pair in found.events:
                if pair.time_difference is None:
                    axes.axvline(pair.event.time, color=GREY, linewidth=0.8, linestyle=":")
            axes.set(ylabel=DRAWN.get(name, with_unit(name, found.variables[name].unit)), xlim=found.span)
        panels[-1].set_xlabel("time (s)")
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        svg = to_svg(figure)
    words = "Both runs over time; dotted lines are events that only one of them has."
    return Picture(svg, words, f"{', '.join(names)} of {' and '.join(found.names)} over time.")

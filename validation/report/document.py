"""What a report consists of, and how it becomes one HTML file that needs nothing besides itself."""

from __future__ import annotations

import csv
import io
import json
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from oblique_impact.files import cannot_write, write_text

#: kinds of cells that are set off by colour and a mark: (kind, mark)
MARKS = {"pass": "✓", "fail": "✗", "partly": "◐"}


@dataclass(frozen=True)
class Cell:
    """Text of a table cell; `kind` is "", "number", "pass", "fail", "partly", "dim" or "code"."""

    text: str
    kind: str = ""

    @property
    def mark(self) -> str:
        """Sign in front of a verdict, so that it does not depend on colour."""
        return MARKS.get(self.kind, "")


def number_cells(*values: str | float | None, digits: int = 6) -> list[Cell]:
    """Return cells that stand under the right end of their heading; texts and integers are shown as they are."""
    texts = [str(v) if isinstance(v, (str, int)) else number(v, digits) for v in values]
    return [Cell(text, "number") for text in texts]


@dataclass(frozen=True)
class Paragraph:
    """A paragraph of plain text; `note` sets it smaller."""

    text: str
    note: bool = False
    block: str = "paragraph"


@dataclass(frozen=True)
class Table:
    """A table; cells are texts or `Cell`."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str | Cell]]
    caption: str = ""
    wide: Sequence[int] = ()  # columns of running text, that may wrap
    filtered: bool = False  # rows end with a verdict that the reader may filter by
    block: str = "table"

    @property
    def verdicts(self) -> bool:
        """Whether some cell is a verdict: such a table never scrolls, so that each of them is seen."""
        return any(cell.mark for row in self.cells() for cell in row)

    def cells(self) -> list[list[Cell]]:
        """Rows of `Cell`."""
        return [[cell if isinstance(cell, Cell) else Cell(cell) for cell in row] for row in self.rows]

    def heading(self, column: int) -> str:
        """Kind of a heading: numbers stand under the right end of theirs."""
        first = self.rows[0][column] if self.rows else ""
        return "number" if isinstance(first, Cell) and first.kind == "number" else ""


@dataclass(frozen=True)
class Picture:
    """A picture as SVG text, with the alternative text for those who cannot see it.

    Two `half` pictures in a row stand side by side.
    """

    svg: str
    caption: str = ""
    alternative: str = ""
    half: bool = False
    block: str = "picture"

    @property
    def markup(self) -> Markup:
        """The picture for the template."""
        return Markup(self.svg)


@dataclass(frozen=True)
class Fold:
    """Blocks under a line that opens them; closed at first."""

    title: str
    blocks: Sequence[Block]
    block: str = "fold"


@dataclass(frozen=True)
class Item:
    """Blocks that belong together; a filter shows or hides them as one."""

    blocks: Sequence[Block]
    block: str = "item"


Block = Paragraph | Table | Picture | Fold | Item


@dataclass(frozen=True)
class Section:
    """A headed part of a report that folds; `verdict` is "", "pass", "fail" or "partly".

    `count` is shown beside the title; `opened` says whether the part is open at first.
    """

    title: str
    blocks: Sequence[Block]
    verdict: str = ""
    count: str = ""
    opened: bool = True

    @property
    def anchor(self) -> str:
        """Name for links inside of the page."""
        return re.sub(r"[^a-z0-9]+", "-", self.title.lower()).strip("-")


@dataclass(frozen=True)
class Document:
    """A report: facts (name, value), `times` (those that differ from run to run), overview, sections.

    With `filtered` the page has a field and a list to filter the rows of filtered tables.
    """

    title: str
    lead: str
    facts: Sequence[tuple[str, str]]
    times: Sequence[tuple[str, str]] = ()
    overview: Sequence[Block] = ()
    sections: Sequence[Section] = field(default_factory=list)
    filtered: bool = False


def render_html(document: Document) -> str:
    """Return the report as one HTML page: styles, script and pictures inside, no address."""
    environment = Environment(
        loader=PackageLoader("validation", "report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    date = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    return environment.get_template("report.html.j2").render(document=document, date=date)


def write_report(folder: Path, document: Document, name: str = "report.html") -> Path:
    """Write the page into an existing folder, whole or not at all; returns the file.

    Raises InputError if it cannot be written.
    """
    return write_file(folder / name, render_html(document))


def write_json(folder: Path, name: str, data: Any) -> Path:
    """Write `data` as JSON, numbers in full precision; NaN and infinity become null."""
    return write_file(
        folder / name, json.dumps(_finite(data), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    )


def write_csv(folder: Path, name: str, columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> Path:
    """Write a table as CSV, numbers in full precision."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([repr(float(v)) if isinstance(v, float) else v for v in row] for row in rows)
    return write_file(folder / name, buffer.getvalue())


def write_file(path: Path, text: str) -> Path:
    """Write a text, whole or not at all; raises InputError if it cannot be written."""
    try:
        write_text(path, text)
    except OSError as error:
        raise cannot_write(path, error) from None
    return path


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def with_unit(name: str, unit: str) -> str:
    """Return the label of an axis or a column; what has no dimension, unit "1", has none."""
    return name if unit in ("", "1") else f"{name} ({unit})"


def number(value: float | None, digits: int = 6) -> str:
    """Return a number for reading: significant digits, a proper minus and powers of ten."""
    if value is None or math.isnan(value):
        return "–"
    text = f"{value:.{digits}g}"
    mantissa, _, exponent = text.partition("e")
    if exponent:
        power = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        text = f"{mantissa} × 10{power}"
    return text.replace("-", "−")

"""One writer of reports: a self-contained page of text, tables and pictures.

A report is sections of text, tables and pictures:

    from oblique_impact.validation.report import Cell, Report, Section, Table, Text, picture

    with picture("Force over time.", width=9.2, height=3.4) as drawn:
        drawn.figure.add_subplot().plot(t, force)
    report = Report(
        "Title", "What this is about.", seconds=1.5,
        facts=[("runs", "12")],
        overview=[Table(["quantity", "value (N)", "verdict"], [["force", 5.25, Cell("agrees", "pass")]]), drawn],
        sections=[Section("Runs", [Text("A paragraph."), Table.of_frame(frame)])],
    )
    page = report.html()

Date, command, versions, machine and provenance are added.  Tables and pictures are numbered; a button saves a
picture as SVG.  Cells of a table are texts, numbers (six digits; `cell` takes others), None, or a `Cell`, whose
kind "pass", "partly" or "fail" gives it colour and mark; `Table.of_frame` takes them from a frame.  A block None,
a table without rows and a section without blocks are left out.  `number` formats a number for reading,
`number_within` to the digits that its uncertainty leaves.
"""

from __future__ import annotations

import io
import math
import os
import platform
import re
import shlex
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import pandas as pd
from jinja2 import Environment, PackageLoader, StrictUndefined
from matplotlib.figure import Figure

from oblique_impact.history.provenance import provenance, provenance_line, versions
from oblique_impact.renders.style import figure_style

#: kinds of cells that are set off by colour and a mark, so that a verdict does not depend on colour
MARKS = {"pass": "✓", "fail": "✗", "partly": "◐"}
#: widths of pictures (inches): legible at half a page's width, and at the whole width
HALF, FULL = 5.6, 9.2
_PIXELS_PER_INCH = 115


def number(value: float | None, digits: int = 6, zeros: bool = False) -> str:
    """Format a number for reading: significant digits, a proper minus and powers of ten; "–" for none.

    Trailing `zeros` are kept where they tell how exactly the number is known.
    """
    if value is None or math.isnan(value):
        return "–"
    mantissa, _, exponent = f"{value:{'#' if zeros else ''}.{digits}g}".partition("e")
    return mantissa.rstrip(".").replace("-", "−") + (f" × 10{_power(exponent)}" if exponent else "")


def _power(exponent: str) -> str:
    return str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def rounded(value: float, uncertainty: float) -> tuple[float, int]:
    """Return a value rounded to the second digit of its uncertainty, and how many digits show it."""
    if not (math.isfinite(value) and math.isfinite(uncertainty)):
        return value, 6
    if not uncertainty or not value:
        return value, 10
    power = math.floor(math.log10(abs(value)))
    digits = min(max(power - math.floor(math.log10(uncertainty)) + 2, 2), 14)
    # 15900 rather than 1.59e4
    return float(f"{value:.{digits}g}"), max(digits, power + 1) if power < 6 else digits


def number_within(value: float, uncertainty: float) -> str:
    """Format a number for reading, to the second digit of its uncertainty; whole numbers without a point."""
    shown, digits = rounded(value, uncertainty)
    return number(shown, digits, zeros=0.0 < uncertainty < math.inf and not shown.is_integer())


def readable(text: str) -> str:
    """Return a text with its numbers as `number` has them: "1 × 10⁻⁵" for "1e-05"."""
    return re.sub(r"(?<![\w.])(\d+(?:\.\d+)?)e([+-]?\d+)\b", lambda n: f"{n[1]} × 10{_power(n[2])}", text)


def capitalized(text: str) -> str:
    """Return a text as a sentence begins."""
    return text[:1].upper() + text[1:]


def listed(words: Sequence[str]) -> str:
    """Return words as a list in a sentence: "a, b and c"."""
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))


def shown_unit(unit: str) -> str:
    """Return a unit for reading: none, "", of what has no dimension, unit "1"."""
    return "" if unit == "1" else unit


def with_unit(name: str, unit: str) -> str:
    """Return the label of an axis or a column."""
    return f"{name} ({unit})" if shown_unit(unit) else name


@dataclass(frozen=True)
class Cell:
    """Text of a table cell; `kind` is "", "number", "pass", "fail", "partly", "dim" or "code"."""

    text: str
    kind: str = ""

    @property
    def mark(self) -> str:
        """Sign in front of a verdict."""
        return MARKS.get(self.kind, "")


#: what may stand in a table
Entry = Cell | str | float | None


def cell(value: Entry, digits: int = 6) -> Cell:
    """Return the cell of a value: numbers in so many digits, whole numbers in all."""
    if isinstance(value, Cell):
        return value
    if isinstance(value, str):
        return Cell(value)
    whole = value is not None and float(value).is_integer() and abs(value) < 1e9
    return Cell(number(value, max(digits, 9) if whole else digits), "number")


class Column(NamedTuple):
    """How a column of a frame is shown."""

    #: "": its name, with spaces
    heading: str = ""
    #: significant digits of its numbers
    digits: int = 6
    #: column with the uncertainties of its numbers, to whose second digit they are shown
    within: str = ""
    #: whether it is running text, which may wrap
    text: bool = False
    #: whether it is names of keys or symbols
    code: bool = False
    #: whether it is shown in a page alone, not in a terminal
    page: bool = False
    #: what stands in place of a value in a row, as "none"; "": the value
    instead: Callable[[Mapping[Any, Any]], str] = lambda row: ""

    def cell(self, name: str, row: Mapping[Any, Any], kinds: Mapping[str, str]) -> Cell:
        """Return the cell of the column of this name in a row."""
        value = row[name]
        if word := self.instead(row):
            return Cell(word, "dim")
        if isinstance(value, str):
            return Cell(
                shown_unit(value) if name == "unit" else value, "code" if self.code else kinds.get(value, "")
            )
        if self.within:
            return Cell(number_within(value, row[self.within]), "number")
        return cell(value, self.digits)


@dataclass(frozen=True)
class Text:
    """A paragraph of plain text; `note` sets it smaller."""

    text: str
    note: bool = False
    block: str = "text"


@dataclass(frozen=True)
class Table:
    """A table; see `Entry` for its cells."""

    columns: Sequence[str]
    rows: Sequence[Sequence[Any]]  # of entries
    caption: str = ""
    wide: Sequence[int] = ()  # columns of running text, that may wrap
    block: str = "table"

    def __bool__(self) -> bool:
        """Whether it has rows."""
        return len(self.rows) > 0

    @classmethod
    def of_frame(
        cls,
        frame: pd.DataFrame,
        caption: str = "",
        columns: Mapping[str, Column] | None = None,
        kinds: Mapping[str, str] = MappingProxyType({}),
        digits: int = 6,
    ) -> Table:
        """Return the table of a frame: `columns` of it that have a value, by default all, in so many `digits`.

        A named index is a column like the others.  ``frame.attrs["units"]`` holds units by column, a column
        "unit" those of each row.  `kinds` are those of cells by their text, as of verdicts.
        """
        data = frame.reset_index() if frame.index.name else frame
        empty = data.columns[(data.isna() | data.eq("")).all()]
        columns = columns or {str(name): Column(digits=digits) for name in data}
        columns = {name: column for name, column in columns.items() if name not in empty}
        units = frame.attrs.get("units", {})
        names = {name: column.heading or name.replace("_", " ") for name, column in columns.items()}
        headings = [with_unit(heading, units.get(name, "1")) for name, heading in names.items()]
        rows = [
            [column.cell(name, row, kinds) for name, column in columns.items()] for row in data.to_dict("records")
        ]
        return cls(headings, rows, caption, [n for n, column in enumerate(columns.values()) if column.text])

    @property
    def verdicts(self) -> bool:
        """Whether some cell is a verdict: such a table never scrolls, so that each of them is seen."""
        return any(cell.mark for row in self.cells() for cell in row)

    def cells(self) -> list[list[Cell]]:
        """Return the rows as cells."""
        return [[cell(entry) for entry in row] for row in self.rows]

    def heading(self, column: int) -> str:
        """Return the kind of a heading: numbers stand under the right end of theirs."""
        return "number" if self.rows and "number" in cell(self.rows[0][column]).kind else ""


@dataclass
class Picture:
    """A picture as SVG text, with the alternative text for those who cannot see it; see `picture`.

    Two `half` pictures in a row stand side by side.  A picture with a `name` has that in place of a number.
    """

    svg: str = field(repr=False)
    caption: str = ""
    alternative: str = ""
    half: bool = False
    name: str = ""
    block: str = "picture"
    figure: Any = None


@contextmanager
def picture(
    caption: str,
    width: float = FULL,
    height: float = 3.4,
    alternative: str = "",
    half: bool = False,
    name: str = "",
) -> Iterator[Picture]:
    """Make a picture: draw on its `figure` in the block; behind the block it is a block of a report.

    It is the same from run to run: no dates, no random identifiers.
    """
    drawn = Picture("", caption, alternative or caption, half, name)
    with figure_style():
        drawn.figure = Figure(figsize=(width, height), layout="constrained")
        yield drawn
        buffer = io.StringIO()
        drawn.figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text, drawn.figure = buffer.getvalue(), None
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    # in a page it is as wide as that, up to a size at which all figures have the same letters
    drawn.svg = text.replace("<svg", f'<svg style="max-width: {round(_PIXELS_PER_INCH * width)}px"', 1)


Block = Text | Table | Picture


@dataclass(frozen=True)
class Section:
    """A headed part of a report that folds; `verdict` is "", "pass", "fail" or "partly".

    `count` is shown beside the title; `opened` says whether the part is open at first.
    """

    title: str
    blocks: Sequence[Block | None]
    verdict: str = ""
    count: str = ""
    opened: bool = True

    def __bool__(self) -> bool:
        """Whether it has blocks."""
        return any(self.blocks)

    @property
    def anchor(self) -> str:
        """Name for links inside of the page."""
        return re.sub(r"[^a-z0-9]+", "-", self.title.lower()).strip("-")


@dataclass(frozen=True)
class Report:
    """A page: head, an overview, and sections."""

    title: str
    #: first paragraph
    lead: str
    #: wall time (s)
    seconds: float | None = None
    #: names and values for the head; provenance, versions and machine are added
    facts: Sequence[tuple[str, str]] = ()
    overview: Sequence[Block | None] = ()
    sections: Sequence[Section] = ()
    #: whether the page has a field that filters the rows of its parts
    filtered: bool = False

    def html(self) -> str:
        """Return the report as one page: styles and pictures inside, no address."""
        date, command = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"), command_line()
        seconds = f"{self.seconds:.1f} s" if self.seconds is not None else ""
        times = [("date", date), ("command", command), ("wall time", seconds)]
        return self._rendered("page", times=times, facts=[*self.facts, *_provenance()])

    def _repr_html_(self) -> str:
        """Show title and overview in a notebook."""
        return self._rendered("head")

    def _rendered(self, template: str, **facts: Any) -> str:
        environment = Environment(
            loader=PackageLoader("oblique_impact.validation", "report"),
            autoescape=True,
            undefined=StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
        )
        environment.filters["readable"] = readable
        return environment.get_template(f"{template}.html.j2").render(document=self, **facts)


# --- what made a report


def command_line() -> str:
    """Return how this process was started, as a shell takes it; "" in an interactive session."""
    program, *words = sys.argv
    if Path(program).stem == "oblique-impact" or Path(program).parts[-2:] == ("oblique_impact", "__main__.py"):
        return shlex.join(["oblique-impact", *words])
    return shlex.join(["python", program, *words]) if program.endswith(".py") else ""


_PACKAGES = ("oblique-impact", "numpy", "scipy", "numba", "scikit-fem", "xarray", "matplotlib")


def _provenance() -> list[tuple[str, str]]:
    """Return lines (name, value) for the head of every report."""
    numbers = ", ".join(f"{name} {number}" for name, number in _versions().items())
    return [("made by", provenance_line(provenance())), ("versions", numbers), ("machine", _machine())]


def provenance_data() -> dict[str, Any]:
    """Return the same for the JSON of every report, with the command."""
    return {
        "command": command_line(),
        "provenance": dict(provenance()),
        "versions": _versions(),
        "machine": _machine(),
    }


def _versions() -> dict[str, str]:
    return {"Python": platform.python_version(), **versions(*_PACKAGES)}


def _machine() -> str:
    """Return processor, number of cores and system; nothing that names the machine itself."""
    return f"{_processor()}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or "unknown processor"
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown processor"

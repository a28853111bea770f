"""What checks, comparisons and studies return: a frame with a verdict for each row, and pictures."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from oblique_impact.files import plain, prepare_folder, save_all, save_text
from oblique_impact.history.history import History
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.report import (
    Block,
    Column,
    Picture,
    Report,
    Section,
    Table,
    Text,
    capitalized,
    provenance_data,
)
from oblique_impact.validation.report.parameters import differing, parameters

#: rows that a terminal, or the head of a page, shows at most
_SHOWN = 40


@dataclass(frozen=True, repr=False)
class Result:
    """What was found, in the same form for every check, comparison and study.

    ``print(result)`` is what the command line shows, a notebook shows the head of the page.
    """

    #: head of the page, and its first paragraph
    title: str
    lead: str
    #: what a row is: "checks", "quantities", ...
    rows: str
    #: a row for each of them, by the name that its index has; ``attrs["units"]`` by column, where the unit is no
    #: column `unit`
    frame: pd.DataFrame
    #: kinds of the verdicts: "pass", "partly", "fail" or "dim"
    kinds: Mapping[str, str]
    #: the columns that are shown
    columns: Mapping[str, Column]
    caption: str = ""
    #: column of the verdicts
    verdict: str = "verdict"
    #: further frames, by name
    tables: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    #: sentences about all rows: what was left out, warnings of the runs
    remarks: Sequence[str] = ()
    #: how a verdict is found, in paragraphs
    rule: Sequence[str] = ()
    #: what was run, by name; None of a user-defined system
    scenarios: Mapping[str, Scenario | None] = field(default_factory=dict)
    #: runs, by name, where they are kept
    histories: Mapping[str, History] = field(default_factory=dict)
    #: further numbers and texts, for results.json
    about: Mapping[str, Any] = field(default_factory=dict)
    #: lines for the head of the page: name and value
    facts: Sequence[tuple[str, str]] = ()
    #: wall time (s)
    seconds: float = 0.0
    #: what is particular to the page: blocks below the rows, and folding parts
    overview: Callable[[Result], Iterable[Block | None]] = lambda _: ()
    sections: Callable[[Result], Iterable[Section]] = lambda _: ()

    def __getitem__(self, name: str) -> Any:
        """Return the row of a name, as ``frame.loc``; raises KeyError."""
        return self.frame.loc[name]

    def __iter__(self) -> Iterator[Any]:
        """Iterate over the rows, as ``frame.itertuples`` gives them."""
        return iter(self.frame.itertuples())

    @property
    def verdicts(self) -> dict[str, int]:
        """Number of rows by verdict, in the order of `kinds`."""
        found = self.frame[self.verdict].value_counts()
        return {verdict: int(found[verdict]) for verdict in self.kinds if verdict in found}

    @property
    def failed(self) -> pd.DataFrame:
        """Rows whose verdict is of the kind "fail"."""
        return self._of_kinds("fail")

    @property
    def summary(self) -> str:
        """How many rows have which verdict."""
        return f"{self.rows}: {', '.join(f'{n} {verdict}' for verdict, n in self.verdicts.items()) or 'none'}"

    @property
    def pictures(self) -> list[Picture]:
        """Pictures of the page, which are drawn now."""
        blocks = [*self.overview(self), *(block for section in self.sections(self) for block in section.blocks)]
        return [block for block in blocks if isinstance(block, Picture)]

    def lines(self) -> list[str]:
        """Return what a terminal shows: how many rows have which verdict, the rows, and what is to be said.

        Of many rows they are those that do not pass.
        """
        shown, more = self._shown()
        table = self._table(shown, page=False)
        rows = [[f"{one.mark} {one.text}".strip() for one in row] for row in table.cells()]
        rows = [[*table.columns], *rows] if rows else []
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        found = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]
        return [
            f"{self.summary} ({self.seconds:.1f} s)" if self.seconds else self.summary,
            *(f"  {line}" for line in [*found, *more, *self.remarks]),
        ]

    def report(self) -> Report:
        """Return the page."""
        shown, more = self._shown()
        several = len(self.scenarios) > 1
        return Report(
            self.title,
            self.lead,
            self.seconds or None,
            facts=[("result", self.summary), *self.facts],
            overview=[
                self._table(shown, page=True),
                *(Text(f"{capitalized(line)}.", note=True) for line in [*more, *self.remarks]),
                differing(self.scenarios) if several else None,
                *self.overview(self),
            ],
            sections=[
                *self.sections(self),
                *parameters(self.scenarios),
                Section("How a verdict is found", [*map(Text, self.rule)]),
            ],
            filtered=len(self.frame) > _SHOWN,
        )

    def data(self) -> dict[str, Any]:
        """Return everything as results.json has it, the same from run to run."""
        tables = {self.rows: self._said(None), **self.tables}
        return {
            "title": self.title,
            **{name.replace(" ", "_"): _with_index(table) for name, table in tables.items()},
            "verdicts": self.verdicts,
            "remarks": self.remarks,
            "rule": self.rule,
            "scenarios": self.scenarios,
            **self.about,
            **provenance_data(),
        }

    def save(self, out: str | os.PathLike[str]) -> Path:
        """Write report.html, results.json and, for each frame, a CSV into a folder; the rows are results.csv.

        A path that ends in .html or .json is that file alone.  Raises InputError if it cannot be written.
        """
        path = Path(out)
        if path.suffix in (".html", ".json"):
            prepare_folder(path.parent)
            return save_text(path, self.report().html() if path.suffix == ".html" else _json(self.data()))
        texts = {"results.json": _json(self.data()), "results.csv": _csv(self._said("none"))}
        texts |= {f"{name.replace(' ', '-')}.csv": _csv(table) for name, table in self.tables.items()}
        save_all(path, texts | {"report.html": self.report().html()})
        return path

    def __repr__(self) -> str:
        """Return what a terminal shows."""
        return "\n".join(self.lines())

    def _repr_html_(self) -> str:
        """Show the head of the page in a notebook."""
        return self.report()._repr_html_()

    def _of_kinds(self, *kinds: str) -> pd.DataFrame:
        return self.frame[self.frame[self.verdict].map(self.kinds).isin(kinds)]

    def _said(self, nothing: str | None) -> pd.DataFrame:
        """Return the frame with `nothing` in place of the values for which a column has another word."""
        frame = self.frame
        for name, column in self.columns.items():
            rows = frame.reset_index() if frame.index.name else frame
            words = [column.instead(row) for row in rows.to_dict("records")]
            if any(words):
                values = [nothing if word else value for word, value in zip(words, frame[name], strict=True)]
                frame = frame.assign(**{name: pd.Series(values, index=frame.index, dtype=object)})
        return frame

    def _shown(self) -> tuple[pd.DataFrame, list[str]]:
        """Return the rows that are shown, and a sentence about the others."""
        if len(self.frame) <= _SHOWN:
            return self.frame, []
        rows = self._of_kinds("fail", "partly", "dim").head(_SHOWN)
        words = f"{len(rows)} of {len(self.frame)} {self.rows}, of those that do not pass; results.csv has all"
        return rows, [words] if len(rows) else []

    def _table(self, rows: pd.DataFrame, page: bool) -> Table:
        """Return the table of some rows; running text is last in a terminal."""
        columns = {name: one for name, one in self.columns.items() if page or not one.page}
        if not page:
            columns = dict(sorted(columns.items(), key=lambda item: item[1].text))
        return Table.of_frame(rows, self.caption, columns, self.kinds)


def _with_index(table: pd.DataFrame) -> pd.DataFrame:
    """Return a frame whose index is a column; without wall times, which differ from run to run."""
    named = table.reset_index() if table.index.name else table
    return named.drop(columns="wall_time", errors="ignore")


def _csv(table: pd.DataFrame) -> str:
    return str(_with_index(table).to_csv(index=False, lineterminator="\n"))


def _json(data: Any) -> str:
    return json.dumps(plain(data), indent=2, ensure_ascii=False, allow_nan=False) + "\n"

"""The page of the questions, from stored numbers."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from math import isclose
from pathlib import Path
from typing import Any

from questions.question import Question, Row

DOCS = Path(__file__).parents[2] / "docs"
PAGE, STORE = DOCS / "which-way.md", DOCS / "which-way.json"
BEGIN, END = "<!-- written by `python -m questions --write` -->\n", "<!-- end of what is written -->\n"

#: a number again: relative and absolute difference from what is stored, which has nine digits
_AGAIN, _NOTHING = 1e-6, 1e-9

#: a case, and of each quantity the two numbers
Rows = Sequence[Mapping[str, Any]]


def plain(rows: Sequence[Row]) -> Rows:
    """Return rows as they are stored."""

    def number(value: float | None) -> float | None:
        return None if value is None else float(f"{value:.9g}")

    return [
        {"case": row.case, "values": {name: [*map(number, two)] for name, two in row.values.items()}}
        for row in rows
    ]


def stored() -> dict[str, Rows]:
    """Return the rows of each question by its name."""
    found: dict[str, Rows] = json.loads(STORE.read_text(encoding="utf-8")) if STORE.is_file() else {}
    return found


def written(numbers: Mapping[str, Rows]) -> str:
    """Return the text of the store, a line for each case."""
    parts = []
    for name, rows in numbers.items():
        lines = ",\n".join(f"  {json.dumps(row, ensure_ascii=False)}" for row in rows)
        parts.append(f" {json.dumps(name, ensure_ascii=False)}: [\n{lines}\n ]")
    return "{\n" + ",\n".join(parts) + "\n}\n"


def _pairs(rows: Rows) -> Iterator[tuple[str, float | None, float | None]]:
    for row in rows:
        for name, (ours, other) in row["values"].items():
            yield f"{row['case']}, {name}", ours, other


def disagreements(question: Question, rows: Rows) -> list[str]:
    """Return a line for each number in which the two computations differ by more than the question allows."""
    return [
        f"{question.name}, {what}: {ours:.6g}, but {question.beside}: {other:.6g}"
        for what, ours, other in _pairs(rows)
        if ours is not None and other is not None
        if not isclose(ours, other, rel_tol=question.within, abs_tol=_NOTHING)
    ]


def differences(question: Question, rows: Rows, before: Rows) -> list[str]:
    """Return a line for each number that is not the stored one."""
    new = {what: two for what, *two in _pairs(rows)}
    old = {what: two for what, *two in _pairs(before)}
    return [
        f"{question.name}, {what}: {new.get(what)}, stored is {old.get(what)}"
        for what in {**old, **new}
        if not (what in new and what in old and all(map(_same, new[what], old[what])))
    ]


def _same(one: float | None, other: float | None) -> bool:
    if one is None or other is None:
        return one is other
    return isclose(one, other, rel_tol=_AGAIN, abs_tol=_NOTHING)


def filled(text: str, rows: Rows) -> str:
    """Return a text with the program's numbers in its fields."""
    return text.format(*({name: ours for name, (ours, _) in row["values"].items()} for row in rows))


def page(questions: Sequence[Question], numbers: Mapping[str, Rows], text: str) -> str:
    """Return the text of the page, with the part between the marks written anew."""
    head, _, rest = text.partition(BEGIN)
    tail = rest.partition(END)[2]
    asked = sorted(questions, key=lambda one: (not one.wrong, -one.cost))
    lines = ["| | question | guess | found | a wrong guess costs |", "| --- | --- | --- | --- | --- |"]
    for number, one in enumerate(asked, 1):
        found, price = filled(one.answer, numbers[one.name]), one.price if one.wrong else "*the guess was right*"
        lines.append(f"| {number} | {one.title} | {one.guess} | {found} | {price} |")
    for number, one in enumerate(asked, 1):
        rows = numbers[one.name]
        lines += ["", f"## {number}. {one.title}", "", *_table(one, rows), ""]
        lines += [filled(one.why, rows), "", f"Beside it: {one.beside}.", "", "```sh", one.command.strip(), "```"]
    return f"{head}{BEGIN}\n{chr(10).join(lines)}\n\n{END}{tail}"


def _table(question: Question, rows: Rows) -> list[str]:
    """Return the lines of the table of a question: beside each quantity that has one, the other computation's."""
    names = list(dict.fromkeys(name for row in rows for name in row["values"]))
    double = [any(row["values"].get(name, [None, None])[1] is not None for row in rows) for name in names]
    headings = [question.cases]
    for name, both in zip(names, double, strict=True):
        headings += [name, "beside it"] if both else [name]
    lines = [f"| {' | '.join(headings)} |", f"|{' --- |' * len(headings)}"]
    for row in rows:
        cells = [row["case"]]
        for name, both in zip(names, double, strict=True):
            two = row["values"].get(name, [None, None])
            cells += [_shown(value) for value in two[: 1 + both]]
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def _shown(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"

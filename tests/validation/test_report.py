"""Reports: escaped, self-contained, the same from run to run."""

from __future__ import annotations

import json
import math
import re

import pandas as pd
import pytest

from oblique_impact import InputError
from oblique_impact.validation.report import (
    Cell,
    Column,
    Report,
    Section,
    Table,
    Text,
    number,
    number_within,
    picture,
    readable,
)
from oblique_impact.validation.result import Result


def document() -> Report:
    with picture("a line") as drawn:
        axes = drawn.figure.add_subplot()
        axes.plot([0.0, 1.0], [2.0, 3.0])
        axes.set_xlabel("t (s)")
    table = Table(["name", "count", "value", "verdict"], [["<b>", 12345678, 1.0 / 3.0, Cell("0.3", "pass")]])
    section = Section("Part one", [Text("words & signs"), table, drawn], "pass")
    return Report("Title", "Lead.", 1.0, facts=[("numpy", "2")], sections=[section])


def test_a_page_needs_nothing_besides_itself_and_has_six_digits():
    page = document().html()
    assert re.findall(r"<(?:script|link|img|iframe) ", page) == []
    # names of XML namespaces are no addresses to load from
    links = re.findall(r'(?:src|href)="(?!#)([^"]*)"|url\((?!#)([^)]*)\)', page)
    assert links == []
    assert "&lt;b&gt;" in page
    assert "words &amp; signs" in page
    assert page.count("<svg") == 1
    assert '<td class="number" data-column="count">12345678</td>' in page
    assert '<td class="number" data-column="value">0.333333</td>' in page
    assert ">✓ 0.3</td>" in page


def test_a_frame_is_a_table_with_units():
    frame = pd.DataFrame({"t": [0.5], "name": ["a"]})
    frame.attrs["units"] = {"t": "s"}
    table = Table.of_frame(frame)
    assert table.columns == ["t (s)", "name"]
    assert [cell.text for cell in table.cells()[0]] == ["0.5", "a"]


def found(count: int = 2) -> Result:
    """Rows whose values have uncertainties; the last one fails."""
    frame = pd.DataFrame({"value": 1.0 / 3.0, "uncertainty": 1e-4, "unit": "m", "verdict": "good"}, range(count))
    frame.loc[count - 1] = [math.nan, math.inf, "m", "bad"]
    columns = {"name": Column(code=True), "note": Column(text=True), "value": Column(within="uncertainty")}
    columns |= {"unit": Column(), "verdict": Column()}
    frame = frame.assign(note="so it is", wall_time=1.0).rename_axis("name")
    kinds = {"good": "pass", "bad": "fail"}
    return Result(
        "Title", "Lead.", "rows", frame, kinds, columns, tables={"more": frame[["value"]]}, remarks=["so"]
    )


def test_a_result_is_lines_a_page_and_files_with_full_numbers(tmp_path):
    result = found()
    assert result.verdicts == {"good": 1, "bad": 1}
    assert result.failed.index.tolist() == [1]
    said = [" ".join(line.split()) for line in result.lines()]
    assert said == [
        "rows: 1 good, 1 bad",
        "name value unit verdict note",
        "0 0.33333 m ✓ good so it is",
        "1 – m ✗ bad so it is",
        "so",
    ]
    result.save(tmp_path / "all")
    names = ["more.csv", "report.html", "results.csv", "results.json"]
    assert sorted(p.name for p in (tmp_path / "all").iterdir()) == names
    data = json.loads((tmp_path / "all" / "results.json").read_text())
    assert data["rows"][1] == {"name": 1, "value": None, "uncertainty": None, "unit": "m"} | {
        "verdict": "bad",
        "note": "so it is",
    }
    assert data["more"][0] == {"name": 0, "value": 1.0 / 3.0}
    assert {"provenance", "versions", "machine"} < data.keys()
    table = pd.read_csv(tmp_path / "all" / "results.csv", index_col="name")
    assert table.loc[0, "value"] == 1.0 / 3.0
    page = (tmp_path / "all" / "report.html").read_text()
    assert ">✗ bad</td>" in page
    assert "<p" in result._repr_html_()
    assert result.save(tmp_path / "new" / "page.html").read_text().startswith("<!DOCTYPE html>")
    with pytest.raises(InputError, match="cannot be written"):
        result.save(tmp_path / "all" / "report.html" / "below")


def test_of_many_rows_those_are_shown_that_do_not_pass():
    lines = found(1000).lines()
    assert lines[0] == "rows: 999 good, 1 bad"
    assert [line.split()[0] for line in lines[1:3]] == ["name", "999"]
    assert "1 of 1000 rows" in lines[3]


@pytest.mark.parametrize(
    ("value", "text"), [(0.5, "0.5"), (-1.25e-9, "−1.25 × 10⁻⁹"), (None, "–"), (math.nan, "–"), (3e20, "3 × 10²⁰")]
)
def test_numbers_for_reading(value, text):
    assert number(value) == text


@pytest.mark.parametrize(
    ("value", "uncertainty", "text"),
    [
        (0.41253927012, 3e-8, "0.412539270"),
        (15912.0, 120.0, "15910"),
        (-1.2346e-7, 1e-9, "−1.235 × 10⁻⁷"),
        (3.0, 3e-13, "3"),
        (0.5, math.nan, "0.5"),
        (math.nan, 1.0, "–"),
    ],
)
def test_numbers_have_the_digits_that_their_uncertainty_leaves(value, uncertainty, text):
    assert number_within(value, uncertainty) == text


def test_numbers_in_sentences_are_readable():
    assert readable("1e-05 s, 2.5e+11 N, 12 m of file1e5.txt") == "1 × 10⁻⁵ s, 2.5 × 10¹¹ N, 12 m of file1e5.txt"

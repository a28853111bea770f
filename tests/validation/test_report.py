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
    Report,
    Section,
    Table,
    Text,
    number,
    number_within,
    picture,
    readable,
)


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


def test_files_appear_with_full_numbers(tmp_path):
    document().write(tmp_path, {"x": 0.1, "y": [math.nan, math.inf]}, pd.DataFrame({"x": [1.0 / 3.0, math.nan]}))
    data = json.loads((tmp_path / "results.json").read_text())
    assert (data["x"], data["y"]) == (0.1, [None, None])
    assert {"provenance", "versions", "machine"} < data.keys()
    lines = (tmp_path / "results.csv").read_text().splitlines()
    assert (float(lines[1]), lines[2]) == (1.0 / 3.0, '""')
    assert sorted(p.name for p in tmp_path.iterdir()) == ["report.html", "results.csv", "results.json"]
    with pytest.raises(InputError, match="cannot be written"):
        document().write(tmp_path / "report.html")


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

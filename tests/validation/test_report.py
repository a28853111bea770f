"""Reports: escaped, self-contained, the same from run to run."""

from __future__ import annotations

import json
import math
import re
from datetime import UTC, date, datetime, timedelta

import pytest

from oblique_impact import InputError
from oblique_impact.validation.report.document import (
    Cell,
    Document,
    Paragraph,
    Picture,
    Section,
    Table,
    number,
    render_html,
    write_csv,
    write_json,
    write_report,
)
from oblique_impact.validation.report.figures import new_figure, to_svg


def test_a_report_says_when_it_was_made():
    (found,) = re.findall(r"<dt>date</dt><dd[^>]*>(\d{4}-\d\d-\d\d) ", render_html(document()))
    assert abs(datetime.now(UTC).date() - date.fromisoformat(found)) <= timedelta(days=1)


def picture() -> Picture:
    with new_figure() as figure:
        axes = figure.add_subplot()
        axes.plot([0.0, 1.0], [2.0, 3.0])
        axes.set_xlabel("t (s)")
        return Picture(to_svg(figure), "a line")


def document() -> Document:
    table = Table(["name", "verdict"], [["<b>", Cell("0.3 against 0.3", "pass")]], "a table")
    section = Section("Part one", [Paragraph("words & signs"), table, picture()], "pass")
    return Document("Title", "Lead.", [("numpy", "2")], [("wall time", "1 s")], sections=[section])


def test_a_page_needs_nothing_besides_itself():
    page = render_html(document())
    assert re.findall(r"<(?:script|link|img|iframe) ", page) == []
    # names of XML namespaces are no addresses to load from
    links = re.findall(r'(?:src|href)="(?!#)([^"]*)"|url\((?!#)([^)]*)\)', page)
    assert links == []
    assert "&lt;b&gt;" in page
    assert "words &amp; signs" in page
    assert page.count("<svg") == 1


def test_half_pictures_are_marked_as_such():
    blocks = [Picture("<svg></svg>", half=half) for half in (True, True, False)]
    page = render_html(Document("Title", "Lead.", [], sections=[Section("Part", blocks)]))
    assert page.count('<figure class="half" role="img"') == 2
    assert page.count("<figure role=") == 1


def test_pages_and_pictures_are_the_same_from_run_to_run():
    assert render_html(document()) == render_html(document())


def test_files_appear_with_full_numbers(tmp_path):
    write_report(tmp_path, document())
    write_json(tmp_path, "a.json", {"x": 0.1, "y": [math.nan, math.inf]})
    write_csv(tmp_path, "a.csv", ["x"], [[1.0 / 3.0], ["text"]])
    assert json.loads((tmp_path / "a.json").read_text()) == {"x": 0.1, "y": [None, None]}
    assert float((tmp_path / "a.csv").read_text().split()[1]) == 1.0 / 3.0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.csv", "a.json", "report.html"]


def test_a_folder_that_is_not_there_is_one_line(tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        write_report(tmp_path / "none", document())


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.5, "0.5"), (-1.25e-9, "−1.25 × 10⁻⁹"), (None, "–"), (math.nan, "–"), (3e20, "3 × 10²⁰")],
)
def test_numbers_for_reading(value, text):
    assert number(value) == text

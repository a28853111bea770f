"""Report pages in a browser: nothing scrolls sideways, verdicts are seen, filter, folding, theme, print."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest

from oblique_impact.validation.report import Cell, Report, Section, Table, Text, picture

COLUMNS = ("id", "quantity", "computed", "reference", "unit", "error", "tolerance", "verdict")


def item(check: str, words: str, *verdicts: str) -> list[Text | Table]:
    rows = [
        [
            Cell(f"{check}.a-rather-long-name-of-a-measurement-{k}", "code"),
            Cell(f"largest distance of two trajectories, {verdict}"),
            *[Cell("−1.23456789 × 10⁻¹²", "number") for _ in range(2)],
            Cell("N m s"),
            *[Cell("1.2 × 10⁻¹²", "number") for _ in range(2)],
            Cell(verdict, verdict),
        ]
        for k, verdict in enumerate(verdicts)
    ]
    return [Text(words), Table(COLUMNS, rows, wide=(1,))]


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    sections = [
        Section("First", item("first.one", "A falling bar.", "pass", "pass"), "pass", "2 measurements", False),
        Section("Second", item("second.two", "A bouncing ball.", "pass", "fail"), "fail", "2", True),
        Section("Numbers", [Table([f"column {k}" for k in range(30)], [["1.234567"] * 30])]),
    ]
    with picture("A line.") as drawn:
        drawn.figure.add_subplot().plot([0.0, 1.0], [0.0, 1.0])
    facts = [("command", "oblique-impact validate --out " + "a" * 300)]
    report = Report("Title", "Lead.", facts=facts, overview=[drawn], sections=sections, filtered=True)
    target = tmp_path_factory.mktemp("report") / "report.html"
    target.write_text(report.html(), encoding="utf-8")
    return target


@pytest.fixture
def report(page, file):
    page.goto(file.as_uri())
    return page


ROWS = """[...document.querySelectorAll('tbody tr')].filter(row => row.checkVisibility())
    .map(row => row.cells[0].textContent)"""
OPEN = "[...document.querySelectorAll('section > details')].map(part => part.open)"
#: verdicts that lie outside of the window
CUT_OFF = """[...document.querySelectorAll('td.pass, td.fail')].filter(cell =>
    cell.getBoundingClientRect().left < 0
    || cell.getBoundingClientRect().right > document.documentElement.clientWidth + 0.5).length"""


@pytest.mark.parametrize("width", [360, 1000, 1920])
def test_no_page_scrolls_sideways_and_every_verdict_is_seen(report, width):
    report.set_viewport_size({"width": width, "height": 800})
    report.evaluate("document.querySelectorAll('details').forEach(part => { part.open = true; })")
    assert report.evaluate("document.documentElement.scrollWidth") <= width
    assert report.evaluate("document.querySelectorAll('td.pass, td.fail').length") == 4
    assert report.evaluate(CUT_OFF) == 0


def test_a_picture_is_saved_as_svg(report):
    with report.expect_download() as download:
        report.get_by_role("button", name="Save as SVG").click()
    assert download.value.suggested_filename == "figure-1.svg"
    drawing = ElementTree.parse(download.value.path()).getroot()
    assert drawing.tag == "{http://www.w3.org/2000/svg}svg"
    assert len(list(drawing.iter("{http://www.w3.org/2000/svg}path"))) > 10


def test_groups_are_folded_but_those_that_fail_and_a_link_opens_one(report, file):
    assert report.evaluate(OPEN) == [False, True, True]
    report.goto("about:blank")
    report.goto(f"{file.as_uri()}#first")
    assert report.evaluate(OPEN)[0]


def test_the_filter_keeps_rows_with_all_words(report):
    report.locator("#filter").fill("FIRST name-of-a-measurement-1")
    assert report.evaluate(ROWS) == ["first.one.a-rather-long-name-of-a-measurement-1"]
    assert not report.get_by_text("A falling bar.").is_visible()
    report.locator("#filter").fill("fail")
    assert report.evaluate(ROWS) == ["second.two.a-rather-long-name-of-a-measurement-1"]
    report.locator("#filter").fill("")
    assert len(report.evaluate(ROWS)) == 5
    assert report.get_by_text("A falling bar.").is_visible()

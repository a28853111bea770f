"""Report pages in a browser: nothing scrolls sideways, verdicts are seen, filter, folding, themes, print."""

from __future__ import annotations

import pytest

from oblique_impact.validation.report import (
    Cell,
    Fold,
    Item,
    Picture,
    Report,
    Section,
    Table,
    Text,
    new_figure,
    to_svg,
)

WIDTHS = (360, 768, 1000, 1001, 1024, 1300, 1420, 1920)
COLUMNS = ("id", "quantity", "computed", "reference", "unit", "error", "tolerance", "verdict")


def item(check: str, words: str, *verdicts: str) -> Item:
    rows = [
        [
            Cell(f"{check}.a-rather-long-name-of-a-measurement-{k}", "code"),
            Cell(f"largest distance of two trajectories, {verdict}"),
            Cell("−1.23456789 × 10⁻¹²", "number"),
            Cell("−1.23456789 × 10⁻¹²", "number"),
            Cell("N m s"),
            Cell("1.2 × 10⁻¹²", "number"),
            Cell("1.2 × 10⁻¹²", "number"),
            Cell(verdict, verdict),
        ]
        for k, verdict in enumerate(verdicts)
    ]
    return Item([Text(words), Table(COLUMNS, rows, wide=(1,), filtered=True), Text("Reference: x", True)])


def picture() -> Picture:
    with new_figure() as figure:
        figure.add_subplot().plot([0.0, 1.0])
        return Picture(to_svg(figure), "a line")


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    sections = [
        Section("First", [item("first.one", "A falling bar.", "pass", "pass")], "pass", "2 measurements", False),
        Section("Second", [item("second.two", "A bouncing ball.", "pass", "fail"), picture()], "fail", "2", True),
        Section("Numbers", [Table([f"column {k}" for k in range(30)], [["1.234567"] * 30])]),
    ]
    command = "oblique-impact validate --out " + "a" * 300
    overview = [Fold("How a verdict is found", [Text("By a rule.")])]
    document = Report("Title", "Lead.", command, overview=overview, sections=sections, filtered=True)
    return document.write(tmp_path_factory.mktemp("report"))


@pytest.fixture
def report(tab, file):
    """The report as it opens, in a window of a usual size."""
    tab.page.set_viewport_size({"width": 1280, "height": 720})
    tab.page.emulate_media(media="null")
    yield tab.open(file)
    tab.check()


#: names of the measurements that are seen
SEEN = """[...document.querySelectorAll('tr[data-verdict]')].filter(row => row.checkVisibility())
    .map(row => row.cells[0].textContent)"""
OPEN = "[...document.querySelectorAll('section > details')].map(part => part.open)"
#: verdicts that lie outside of the window or of a box that cuts them off
CUT_OFF = """[...document.querySelectorAll('td.pass, td.fail, td.partly')].filter(cell => {
    const place = box => box.getBoundingClientRect();
    if (place(cell).left < 0 || place(cell).right > document.documentElement.clientWidth + 0.5) return true;
    for (let outer = cell.parentElement; outer; outer = outer.parentElement)
        if (getComputedStyle(outer).overflowX !== 'visible' && place(cell).right > place(outer).right + 0.5)
            return true;
    return false; }).length"""


@pytest.mark.parametrize("width", WIDTHS)
def test_no_page_scrolls_sideways_and_every_verdict_is_seen(report, file, width):
    report.set_viewport_size({"width": width, "height": 800})
    report.evaluate("document.querySelectorAll('details').forEach(part => { part.open = true; })")
    assert report.evaluate("document.documentElement.scrollWidth") <= width
    assert report.evaluate("document.querySelectorAll('td.pass, td.fail').length") == 4
    assert report.evaluate(CUT_OFF) == 0
    # a wide table of numbers scrolls inside of itself, and the keyboard reaches it
    assert report.evaluate("[...document.querySelectorAll('.scroll')].filter(b => b.tabIndex === 0).length") == 1


def test_groups_are_folded_but_those_that_fail(report):
    assert report.evaluate(OPEN) == [False, True, True]
    report.evaluate("document.getElementById('fold').click()")
    assert report.evaluate(OPEN) == [True] * 3
    report.evaluate("document.getElementById('fold').click()")
    assert report.evaluate(OPEN) == [False] * 3


def test_a_link_opens_the_part_that_it_leads_to(report, file):
    report.goto(f"{file.as_uri()}#first")
    assert report.evaluate(OPEN)[0]


def test_the_filter_keeps_rows_with_all_words_and_opens_their_groups(report):
    report.locator("#filter").fill("FALLING name-of-a-measurement-1")
    assert report.evaluate(SEEN) == ["first.one.a-rather-long-name-of-a-measurement-1"]
    assert report.evaluate("document.getElementById('shown').textContent") == "1 of 4 measurements"
    report.locator("#filter").fill("no such word")
    assert report.evaluate(SEEN) == []
    report.locator("#filter").fill("")
    assert report.evaluate(OPEN) == [False, True, True]
    assert report.evaluate("document.getElementById('shown').textContent") == ""


def test_the_filter_knows_verdicts(report):
    report.locator("#verdict").select_option("fail")
    assert report.evaluate(SEEN) == ["second.two.a-rather-long-name-of-a-measurement-1"]
    report.locator("#filter").fill("falling")
    assert report.evaluate(SEEN) == []
    report.locator("#verdict").select_option("pass")
    assert len(report.evaluate(SEEN)) == 2


def luminance(page, selector: str, colour: str) -> float:
    parts = page.evaluate(f"getComputedStyle(document.querySelector('{selector}')).{colour}")
    red, green, blue = (float(part) / 255.0 for part in parts[parts.index("(") + 1 : -1].split(",")[:3])
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


@pytest.mark.parametrize("system", ["light", "dark"])
def test_the_theme_is_that_of_the_system_until_the_button_is_pressed(page, file, system):
    page.emulate_media(color_scheme=system)
    page.goto(file.as_uri())
    dark = system == "dark"
    for _ in range(2):
        assert (luminance(page, "body", "backgroundColor") < 0.1) == dark
        for part in ("body", "td.pass", "td.fail", "p.note"):
            difference = luminance(page, part, "color") - luminance(page, "body", "backgroundColor")
            assert difference > 0.3 if dark else difference < -0.3, part
        assert ("invert" in page.evaluate("getComputedStyle(document.querySelector('figure svg')).filter")) == dark
        page.evaluate("document.getElementById('theme').click()")
        dark = not dark


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_paper_is_white_shows_everything_and_no_controls(report, theme):
    report.evaluate(f"document.documentElement.dataset.theme = '{theme}'")
    report.locator("#filter").fill("falling")
    report.evaluate("document.querySelectorAll('details').forEach(part => { part.open = false; })")
    report.emulate_media(media="print")
    report.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert luminance(report, "body", "backgroundColor") == pytest.approx(1.0)
    assert luminance(report, "body", "color") < 0.2
    assert report.evaluate("getComputedStyle(document.querySelector('figure svg')).filter") == "none"
    assert len(report.evaluate(SEEN)) == 4
    assert (
        report.evaluate(
            "[...document.querySelectorAll('.controls, button, input')].filter(e => e.checkVisibility())"
        )
        == []
    )
    report.evaluate("dispatchEvent(new Event('afterprint'))")
    assert report.evaluate(OPEN) == [False] * 3


def test_the_keyboard_reaches_controls_and_groups(report):
    report.evaluate("document.getElementById('filter').focus()")
    seen = []
    for _ in range(6):
        report.keyboard.press("Tab")
        seen.append(report.evaluate("document.activeElement.id || document.activeElement.tagName"))
    assert seen[:3] == ["verdict", "fold", "theme"]
    assert "SUMMARY" in seen

"""The page of a run inside of another page."""

from __future__ import annotations

import pytest

HOST = """<!DOCTYPE html><title>host</title><body style="margin: 0">
<iframe src="{url}" style="width: 640px; height: 360px; border: 0"></iframe><div style="height: 3000px"></div>"""


@pytest.fixture
def embedded(page, files, tmp_path):
    """Another page with the paper's run in it: that page, and the frame inside of it."""

    def show():
        (tmp_path / "host.html").write_text(HOST.format(url=f"{files().as_uri()}#embed"), encoding="utf-8")
        page.goto((tmp_path / "host.html").as_uri())
        frame = page.frames[1]
        frame.wait_for_function("() => window.player")
        return page, frame

    return show


def test_embedded_it_shows_beam_and_transport_and_plays_while_it_is_seen(embedded):
    page, frame = embedded()
    frame.wait_for_function("() => player.now().time > 0.02")
    page.evaluate("scrollTo(0, 2000)")
    frame.wait_for_function("() => !player.now().playing", polling=50)  # what is not seen has no refreshes
    page.evaluate("scrollTo(0, 0)")
    frame.wait_for_function("() => player.now().playing")
    shown = (
        "[...document.querySelectorAll('canvas, button, select, a, h1')].filter(e => e.getClientRects().length)"
    )
    assert frame.evaluate(f"{shown}.map(e => e.id).sort()") == ["play", "scene", "speed", "strip", "whole"]
    assert frame.evaluate("[document.body.scrollWidth, document.body.scrollHeight]") == [640, 360]
    assert frame.evaluate("document.getElementById('whole').href").endswith(".html")  # the page without "#embed"
    frame.locator("#play").click()  # the reader's own pause lasts
    page.evaluate("scrollTo(0, 2000)")
    page.wait_for_timeout(200)
    page.evaluate("scrollTo(0, 0)")
    page.wait_for_timeout(200)
    assert not frame.evaluate("player.now().playing")


def test_embedded_it_says_how_much_the_deflection_is_magnified_and_that_the_run_warns(embedded):
    _, frame = embedded()
    note = frame.locator("#deformation")
    assert note.is_visible()
    assert "×5" in note.text_content()
    assert "1 warning" in note.text_content()


def test_embedded_it_stands_still_for_those_who_want_no_motion(embedded):
    embedded()[0].emulate_media(reduced_motion="reduce")
    page, frame = embedded()
    page.wait_for_timeout(300)
    assert not frame.evaluate("player.now().playing")
    frame.locator("#play").click()  # but it can be played
    frame.wait_for_function("() => player.now().time > 0.001")

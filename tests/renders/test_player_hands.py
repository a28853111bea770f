"""The page of a run under a reader's hands: zoom, choices, lists, the order of the keyboard, sizes of targets."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact.renders.player import write_player
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style
from tests.renders.browsing import image, now, seek, settle, text

TARGET = 44.0  # CSS pixels (WCAG 2.2, 2.5.5)


def place(page):
    """Where the contact point touches, in pixels of the scene."""
    return np.array(page.evaluate("player.place('scene')"))


def corner(page, name):
    box = page.locator(name).bounding_box()
    return np.array([box["x"], box["y"]])


# Zoom and pan -------------------------------------------------------------------------------------------------


def test_the_wheel_zooms_about_the_pointer_and_a_double_click_shows_all(player):
    seek(player, 0.3252)
    before, whole = place(player), image(player, "scene")
    player.mouse.move(*(corner(player, "#scene") + before))
    player.mouse.wheel(0, -400)
    settle(player)
    assert player.evaluate("player.zoom.by") > 1.5  # the wheel forward is closer
    assert place(player) == pytest.approx(before, abs=1.0)
    factor = player.evaluate("player.zoom.by")
    assert text(player, "deformation").endswith(f", zoom ×{factor:.3g}")
    player.mouse.wheel(0, 200)
    settle(player)
    assert player.evaluate("player.zoom.by") == pytest.approx(np.sqrt(factor))
    player.mouse.dblclick(*(corner(player, "#scene") + before))
    settle(player)
    assert (player.evaluate("player.zoom.by"), image(player, "scene") == whole) == (1, True)


def test_what_is_dragged_follows_the_hand(player):
    seek(player, 0.3252)
    for _ in range(4):
        player.keyboard.press("+")
    settle(player)
    before = place(player)
    start = np.add(corner(player, "#scene"), (300, 200))
    player.mouse.move(*start)
    player.mouse.down()
    player.mouse.move(*np.add(start, (-60, -35)), steps=4)
    player.mouse.up()
    settle(player)
    assert place(player) - before == pytest.approx([-60, -35], abs=1.0)


def test_keys_and_buttons_zoom_and_move(player):
    seek(player, 0.3252)
    at = place(player)

    def press(key):
        before = place(player)
        player.keyboard.press(key)
        settle(player)
        return player.evaluate("player.zoom.by"), place(player) - before

    assert player.locator("#zoom-out").is_disabled()
    assert press("+") == (pytest.approx(1.5), pytest.approx([0, 0], abs=1.0))  # about the contact point
    assert press("=")[0] == pytest.approx(2.25)
    assert press("-")[0] == pytest.approx(1.5)
    for key, way in (("w", (0, 1)), ("s", (0, -1)), ("a", (1, 0)), ("d", (-1, 0))):
        player.keyboard.press("0")
        for button in ("#zoom-in", "#zoom-in", "#zoom-in"):
            player.locator(button).click()
        for back in "sd" if key in "wa" else "wa":  # not at the end
            player.keyboard.press(back)
        settle(player)
        moved = press(key)[1]
        assert (np.sign(np.rint(moved)) == way).all(), key  # what is seen goes where one looks from
    player.locator("#zoom-all").click()
    settle(player)
    assert place(player) == pytest.approx(at, abs=0.01)
    assert player.locator("#zoom-all").is_disabled()


def test_two_fingers_pinch(browser, files):
    page = browser.new_page(viewport={"width": 390, "height": 844}, has_touch=True)
    page.goto(files().as_uri())
    seek(page, 0.3252)
    touches = page.context.new_cdp_session(page)
    middle = corner(page, "#scene") + place(page)

    def touch(kind, *apart):
        points = [
            {"x": float(middle[0] + s * a), "y": float(middle[1]), "id": n}
            for a in apart
            for n, s in enumerate((-1, 1))
        ]
        touches.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    before = place(page)
    touch("touchStart", 10)
    for apart in (15, 20, 30):
        touch("touchMove", apart)
    touch("touchEnd")
    settle(page)
    assert page.evaluate("player.zoom.by") == pytest.approx(3.0, rel=0.05)
    assert place(page) == pytest.approx(before, abs=2.0)
    page.close()


def test_the_wheel_over_a_chart_zooms_in_time(player):
    seek(player, 0.3252)
    player.locator("#range").select_option("whole")
    at = np.add(corner(player, "#force"), (300, 40))
    player.mouse.click(*at)  # the time under the pointer
    settle(player)
    chosen = now(player)
    player.mouse.wheel(0, -800)
    settle(player)
    assert player.locator("#range").input_value() == "zoomed"
    player.mouse.click(*at)
    settle(player)
    assert now(player) == pytest.approx(chosen, abs=2e-3)
    player.mouse.click(*np.add(at, (60, 0)))
    settle(player)
    near = now(player) - chosen
    player.mouse.dblclick(*at)
    assert player.locator("#range").input_value() == "whole"
    settle(player)
    player.mouse.click(*np.add(at, (60, 0)))
    settle(player)
    assert now(player) - chosen == pytest.approx(np.exp(0.0015 * 800) * near, rel=0.05)


def test_the_mark_of_an_event_is_met_from_a_finger_away(player, run):
    seek(player, 0.3252)
    player.locator("#range").select_option("whole")
    settle(player)
    event = run("paper").events[0]
    box = player.locator("#force").bounding_box()
    left, right = 62, 12  # margins of a chart, of a page with letters of 14 px
    x = box["x"] + left + (box["width"] - left - right) * event.time - 20
    player.mouse.click(x, box["y"] + box["height"] - 24)
    settle(player)
    assert now(player) == np.nextafter(event.time, np.inf)
    player.mouse.click(x, box["y"] + 20)  # above, a press is a time
    settle(player)
    assert now(player) < event.time - 1e-3


# Choices ------------------------------------------------------------------------------------------------------


def test_the_result_in_colour_is_chosen(player, files):
    seek(player, 0.3252)
    names = player.locator("#colour option").all_text_contents()
    assert names == [
        *("bending stress", "axial stress", "bending moment", "shear force", "axial force", "section rotation"),
    ]
    images = set()
    for name in names:
        player.locator("#colour").select_option(name.replace(" ", "_"))
        settle(player)
        images.add(image(player, "scene"))
    assert len(images) == len(names)
    player.goto(f"{files().as_uri()}#t=0.3252&colour=shear_force")
    settle(player)
    assert player.locator("#colour").input_value() == "shear_force"
    assert image(player, "scene") in images


def test_the_page_opens_as_it_was_asked_for(page, run, tmp_path):
    story = story_of([run("paper", "end_time=0.05")], Style(quantity="bending_moment"), ["third try"])
    page.goto(write_player(story, tmp_path / "run.html").as_uri())
    assert page.locator("#colour").input_value() == "bending_moment"
    assert page.title() == "third try: beam, A = 314 mm², I = 7850 mm⁴, length 1 m, 2 modes – oblique impact"
    assert page.locator("h1").text_content() == "third try: beam, A = 314 mm², I = 7850 mm⁴, length 1 m, 2 modes"


# Lists --------------------------------------------------------------------------------------------------------

HEAD = ["start (s)", "end (s)", "state", "normal impulse (N\xa0s)", "peak force (N)", "loss (J)"]


def rows(page):
    found = page.locator("#contacts tr").all()
    return [row.locator("th, td").all_text_contents() for row in found]


def test_the_table_of_contacts_is_that_of_the_history(player, run):
    player.locator("#contacts-tab").click()
    head, *body = rows(player)
    assert head == HEAD
    contacts = run("paper").contacts
    assert len(body) == len(contacts)
    for (start, end, state, *numbers), contact in zip(body, contacts, strict=True):
        assert (float(start), float(end)) == (
            pytest.approx(contact.start, abs=1e-6),
            pytest.approx(contact.end, abs=1e-6),
        )
        assert state == ("slip" if contact.end > contact.start else "rebound")
        expected = (contact.normal_impulse, contact.peak_force, contact.energy_loss)
        for number, value in zip(numbers, expected, strict=True):
            assert float("0" if number == "–" else number) == pytest.approx(value, rel=1e-3)
    player.locator("#contacts button").nth(1).click()
    settle(player)
    assert now(player) == np.nextafter(contacts[1].start, np.inf)
    assert player.locator("#contacts [aria-current]").text_content() == body[1][0]
    player.locator("#charts-tab").click()
    assert player.locator("#force").is_visible()
    assert not player.locator("#contacts").is_visible()


def test_rebounds_and_a_contact_without_end_are_called_so(page, files, run):
    contacts = run("sticking").contacts
    page.goto(files("sticking").as_uri())
    _, *found, last = rows(page)
    assert len(found) + 1 == len(contacts)
    assert (float(last[0]), last[1], last[2]) == (
        pytest.approx(contacts[-1].start, abs=1e-6),
        "open",
        "slip, stick",
    )
    assert float(last[3]) == pytest.approx(contacts[-1].normal_impulse, rel=1e-3)  # up to the end of the run
    assert "open" not in [row[1] for row in found]
    page.goto(files("bouncing").as_uri())
    instants = [row for row in rows(page)[1:] if row[2] == "rebound"]
    assert len(instants) == sum(contact.start == contact.end for contact in run("bouncing").contacts)
    assert {row[4] for row in instants} == {"–"}


def test_a_run_without_contact_has_no_table(page, files):
    page.goto(files("spin-up").as_uri())
    page.locator("#contacts-tab").click()
    assert text(page, "contacts-note") == "There is no contact in this run."
    assert not page.locator("#contacts").is_visible()


# The keyboard, fingers ----------------------------------------------------------------------------------------


def test_the_keyboard_meets_the_transport_first_and_each_list_once(player):
    met = []
    for _ in range(30):
        player.keyboard.press("Tab")
        met.append(
            player.evaluate("document.activeElement.id || document.activeElement.closest('[id]')?.id || ''")
        )
        if met[-1] in met[:-1]:
            break
    assert met[:9] == ["play", "slider", "speed", "loop", "home", "event-back", "back", "forward", "event-forward"]
    rest = ["end", "warn", "theme", "colour", "factor", "zoom-in", "events", "charts-tab", "range"]
    assert met[9:18] == rest


@pytest.mark.parametrize(("width", "height", "roomy"), [(1280, 900, True), (1000, 700, False), (360, 740, False)])
def test_what_the_run_warns_of_is_a_press_away(browser, files, run, width, height, roomy):
    """Open where there is room; opened elsewhere it is read in full, beside the page's pictures or over them."""
    page = browser.new_page(viewport={"width": width, "height": height})
    page.goto(files().as_uri())
    settle(page)
    button, listed = page.locator("#warn"), page.locator("#warnings")
    count = len(run("paper").summary["warnings"])
    assert button.text_content() == f"{count} warning{'s' if count > 1 else ''}"
    assert (listed.is_visible(), button.get_attribute("aria-expanded")) == (roomy, str(roomy).lower())
    if not roomy:
        button.click()
    assert button.get_attribute("aria-expanded") == "true"
    assert listed.locator("li").all_text_contents() == [
        f"Warning: {said}" for said in run("paper").summary["warnings"]
    ]
    assert listed.evaluate("e => e.scrollHeight <= e.clientHeight && e.scrollWidth <= e.clientWidth")
    seen = listed.bounding_box()
    assert seen["x"] >= 0.0
    assert seen["x"] + seen["width"] <= width
    middle = [seen["x"] + seen["width"] / 2, seen["y"] + seen["height"] / 2]
    assert page.evaluate(
        "at => document.getElementById('warnings').contains(document.elementFromPoint(...at))", middle
    )
    page.keyboard.press("Escape")
    assert not listed.is_visible()
    page.emulate_media(media="print")
    settle(page)
    assert listed.is_visible()  # on paper nothing can be pressed
    assert not button.is_visible()
    page.close()


def test_arrows_choose_in_a_list(player, run):
    events = run("paper").events
    player.locator("#events button").first.focus()
    for _ in range(2):
        player.keyboard.press("ArrowDown")
    assert now(player) == 0.0
    player.keyboard.press("Enter")
    settle(player)
    assert now(player) == np.nextafter(events[2].time, np.inf)
    player.keyboard.press("ArrowUp")
    player.keyboard.press("Enter")
    settle(player)
    assert now(player) == np.nextafter(events[1].time, np.inf)
    assert player.locator("#events button[tabindex='0']").count() == 1
    player.locator("#charts-tab").focus()
    player.keyboard.press("ArrowRight")
    assert player.locator("#contacts-tab").get_attribute("aria-selected") == "true"
    assert player.locator("#contacts").is_visible()


@pytest.mark.parametrize(("width", "height", "part"), [(1280, 800, ""), (390, 844, ""), (640, 360, "#embed")])
def test_targets_are_as_large_as_a_finger(browser, files, width, height, part):
    page = browser.new_page(viewport={"width": width, "height": height}, reduced_motion="reduce")
    page.goto(files().as_uri() + part)
    settle(page)
    for tab in ("charts-tab", "contacts-tab"):
        page.evaluate("id => document.getElementById(id).click()", tab)
        small = page.evaluate(
            """least => [...document.querySelectorAll("button, select, input, a")]
              .filter((e) => e.checkVisibility()).map((e) => e.closest("tbody tr") || e.closest("label") || e)
              .filter((e) => Math.min(e.offsetWidth, e.offsetHeight) < least).map((e) => e.id || e.textContent)""",
            TARGET,
        )
        assert small == []
    page.close()

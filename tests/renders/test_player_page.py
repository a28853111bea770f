"""The page of a run in a headless Chromium: what is written and drawn, and how time moves."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from oblique_impact.contact.state import State
from oblique_impact.renders.player import write_player
from oblique_impact.renders.story import story_of
from oblique_impact.scenario.scenario import Scenario
from tests.renders.browsing import drag, image, now, rgb, seek, settle, text
from tests.renders.test_player import content


def test_the_browser_decodes_what_was_embedded(opened, run):
    for name, array in content(run("paper"))[0].items():
        values = f"player.arrays.{name}"
        size, total = opened.evaluate(f"[{values}.length, {values}.reduce((s, v) => s + v, 0)]")
        assert (size, total) == (array.size, pytest.approx(float(array.astype(float).sum()), rel=1e-9))


@pytest.mark.parametrize(("time", "state"), [(0.2, State.FREE), (0.3185, State.SLIP), (0.3252, State.SLIP)])
def test_time_state_and_numbers_are_written(opened, run, time, state):
    seek(opened, time)
    assert text(opened, "time") == f"t = {time:.6f} s"
    assert text(opened, "state") == state.name
    assert opened.evaluate("getComputedStyle(document.getElementById('state')).backgroundColor") == rgb(state)
    assert text(opened, "rate") == ("shown at 1/500 of real time" if state else "shown at 1/10 of real time")
    labels, values = (opened.locator(f"#numbers {tag}").all_text_contents() for tag in ("dt", "dd"))
    found = dict(zip(labels, values, strict=True))
    data = run("paper").data.interp(time=time)
    for label, name, factor, unit in (
        ("gap", "gap", 1e3, "mm"),
        ("tangential velocity", "slip_rate", 1.0, "m/s"),
        ("normal force", "lambda_n", 1.0, "N"),
        ("tangential force", "lambda_tau", 1.0, "N"),
    ):
        number, said = found[label].replace("−", "-").split(" ")
        assert said == unit
        assert float(number) == pytest.approx(factor * float(data[name]), rel=2e-3, abs=2e-3), label
        # four digits of a force, whatever its size
        assert unit != "N" or float(number) == 0.0 or len(re.sub(r"\D", "", number).lstrip("0")) == 4, number
    legend = opened.locator("#force-legend").text_content().replace("−", "-")
    forces = re.fullmatch(r"Contact force \(N\)normal (\S+)tangential (\S+)", legend).groups()
    assert list(map(float, forces)) == pytest.approx(
        [float(data["lambda_n"]), float(data["lambda_tau"])], rel=2e-3
    )
    legend = opened.locator("#energy-legend").text_content()
    energies = dict(re.findall(r"(kinetic|elastic|gravity|total) ([\d.]+)", legend))
    assert legend.startswith("Energy (J)")
    parts = [float(data[f"energy_{kind}"]) for kind in ("kinetic", "elastic", "gravity")]
    assert [float(energies[kind]) for kind in ("kinetic", "elastic", "gravity", "total")] == pytest.approx(
        [*parts, sum(parts)], abs=1e-3
    )
    assert text(opened, "deformation") == "deflection drawn ×5 about the pin–tip chord"
    swatches = opened.locator("#force-legend i").evaluate_all(
        "all => all.map(i => [i.className, getComputedStyle(i).borderTopColor])"
    )
    assert swatches == [["", rgb(state)], ["dashed", rgb(state)]]


def test_the_rate_follows_the_chosen_speed(player):
    seek(player, 0.2)
    for speed, said in (("0.5", "1/20"), ("4", "1/2.5")):
        player.locator("#speed").select_option(speed)
        settle(player)
        assert text(player, "rate") == f"shown at {said} of real time"


def test_events_are_listed_with_time_kind_and_impulse(opened, run):
    shown = opened.locator("#events li").all_text_contents()
    for row, event in zip(shown, run("paper").events, strict=True):
        found = re.fullmatch(r"([\d.]{8})(\d+) (\w+) (?:(\S+) N s)?", row)
        number = shown.index(row) + 1
        assert (float(found[1]), int(found[2])) == (pytest.approx(event.time, abs=1e-6), number)
        assert found[3] == event.kind.value
        assert float(found[4] or 0.0) == pytest.approx(event.normal_impulse, rel=6e-3)
    assert text(opened, "events-note") == "time (s), number, kind, impulse"
    dots = opened.locator("#events i").evaluate_all("dots => dots.map(d => getComputedStyle(d).backgroundColor)")
    assert dots == [rgb(event.state) for event in run("paper").events]
    titles = opened.locator("#events button").evaluate_all("buttons => buttons.map(b => b.title)")
    for title, event in zip(titles, run("paper").events, strict=True):
        found = re.fullmatch(r"t = (\S+) s, then (\w+)", title)
        assert (float(found[1]), found[2]) == (event.time, State(event.state).name)


def test_how_many_events_are_listed_of_how_many(page, run, tmp_path):
    history = run("paper", "end_time=0.35")
    many = [event for event in history.events for _ in range(500)]
    assert len(many) > 1000
    page.goto(write_player(story_of([replace(history, events=many)]), tmp_path / "many.html").as_uri())
    assert text(page, "events-note") == f"1000 of {len(many)}; time (s)"


@pytest.mark.parametrize(("time", "state", "strength"), [(0.2, State.FREE, 0.35), (0.3185, State.SLIP, 1.0)])
def test_the_strip_above_the_buttons_has_the_colours_of_the_states(player, time, state, strength):
    seek(player, time)
    *found, alpha = player.evaluate(
        """() => {
            const canvas = document.getElementById("strip"), wide = canvas.getBoundingClientRect().width - 14;
            const part = player.now().film / player.arrays.frame_film.at(-1), dots = window.devicePixelRatio;
            return [...canvas.getContext("2d").getImageData(dots * (7 + wide * part), 22 * dots, 1, 1).data];
        }"""
    )
    assert found == pytest.approx([int(part) for part in re.findall(r"\d+", rgb(state))], abs=4)
    assert alpha == pytest.approx(255 * strength, abs=2)


def test_times_below_the_strip_stand_where_the_film_shows_them(player, run):
    """The start, the end, and the beginnings of collisions."""
    found = player.evaluate(
        """async () => {
            const seen = [], pen = CanvasRenderingContext2D.prototype, write = pen.fillText;
            pen.fillText = function (text, x, ...rest) {
              if (this.canvas.id === "strip") seen.push([text, x]);
              return write.call(this, text, x, ...rest);
            };
            player.seek(0.3252);
            await new Promise((r) => requestAnimationFrame(() => requestAnimationFrame(r)));
            pen.fillText = write;
            return [seen, document.getElementById("strip").getBoundingClientRect().width];
        }"""
    )
    written, wide = found
    times, film = (player.evaluate(f"Array.from(player.arrays.frame_{name})") for name in ("time", "film"))
    starts = [collision["start"] for collision in run("paper").summary["macro_collisions"]]
    said = {float(text.removesuffix(" s")): x for text, x in written}
    inner = [time for time in starts if round(time, 3) in said]
    assert inner
    assert {0.0, 1.0} | {round(time, 3) for time in inner} == set(said)
    for time in inner:
        at = 7 + (wide - 14) * np.interp(time, times, film) / film[-1]  # half of the slider's thumb is 7
        assert said[round(time, 3)] == pytest.approx(at, abs=1.0)


@pytest.mark.parametrize(("case", "unit", "size"), [("paper", "N", 1.0), ("tapered", "kN", 1e3)])
def test_labels_of_large_forces_are_short_and_say_what_they_are_in(page, files, run, case, unit, size):
    """Levels of the axis of forces, which cover those of the run; a rigid stop under a mass has 331 kN."""
    changes = ("end_time=0.34",) if case == "tapered" else ()
    page.goto(files(case, "light", *changes).as_uri())
    page.locator("#range").select_option("whole")
    written = page.evaluate(
        """async () => {
            const seen = [], pen = CanvasRenderingContext2D.prototype, write = pen.fillText;
            pen.fillText = function (text, ...rest) {
              if (this.canvas.id === "force") seen.push([text, this.textAlign, this.textBaseline]);
              return write.call(this, text, ...rest);
            };
            player.seek(0.33);
            await new Promise((r) => requestAnimationFrame(() => requestAnimationFrame(r)));
            pen.fillText = write;
            return seen;
        }"""
    )
    assert [text for text, *_ in written if text.endswith("N")] == [unit]
    levels = [text.replace("−", "-") for text, align, line in written if (align, line) == ("right", "middle")]
    assert max(map(len, levels)) <= 4
    peak = float(np.nanmax(run(case, *changes)["lambda_n"].values))
    assert 0.5 * peak < size * max(map(float, levels)) <= 1.2 * peak


def test_a_beam_that_is_drawn_thicker_is_said_to_be(page, files, run):
    """The round end of a beam of 10 m, over its radius in the scale by which its tip moves."""
    page.goto(files("spin-up").as_uri())
    tips = []
    for time in (0.5, 14.0):
        seek(page, time)
        tips.append(page.evaluate("((m) => [player.place('scene'), [m.x.at(-1), m.y.at(-1)]])(player.now())"))
    radii = page.evaluate(
        """async () => {
            const seen = [], arc = Path2D.prototype.arc;
            Path2D.prototype.arc = function (...circle) { seen.push(circle[2]); return arc.apply(this, circle); };
            player.seek(14.0);
            await new Promise((r) => requestAnimationFrame(() => requestAnimationFrame(r)));
            Path2D.prototype.arc = arc;
            return seen;
        }"""
    )
    pixels, metres = (np.linalg.norm(np.subtract(tips[1][n], tips[0][n])) for n in (0, 1))
    beam = Scenario.from_toml(run("spin-up").scenario_toml).beam
    radius = (beam.outer_fibre or np.sqrt(beam.area / np.pi)) * pixels / metres
    thick = int(re.search(r", thickness ×(\d+)$", text(page, "deformation"))[1])
    assert thick > 1
    assert metres > 1.0
    assert min(radii) == pytest.approx(thick * radius, rel=1e-3)


def test_what_a_contact_along_the_beam_is_called(page, files):
    page.goto(files("mid-span").as_uri())
    settle(page)
    assert "about the chord from the pin to the contact point" in text(page, "deformation")
    assert text(page, "tip-title") == "Contact point, true scale"


def test_the_chosen_factor_is_the_drawn_one(player):
    for choice in ("10", "2"):
        player.locator("#factor").select_option(choice)
        settle(player)
        assert text(player, "deformation") == f"deflection drawn ×{choice} about the pin–tip chord"


def test_a_run_that_blew_up_is_shown(page, run, files):
    """The paper's model with too many clamped shapes; the page says why it stopped."""
    page.goto(files("paper", "light", "discretization.modes=6").as_uri())
    page.keyboard.press("End")
    assert now(page) == pytest.approx(run("paper", "discretization.modes=6").summary["end_time"], abs=1e-6)
    assert "The run stopped early." in page.locator("header").text_content()


def test_it_plays_and_pauses(player):
    seek(player, 0.1)
    player.keyboard.press("Space")
    assert player.locator("#play").get_attribute("aria-label") == "Pause"
    player.wait_for_function("() => player.now().time > 0.11")
    player.keyboard.press("Space")
    paused = now(player)
    settle(player)
    assert now(player) == paused
    assert paused < 0.317  # in flight a tenth of real time
    player.evaluate("player.goTo(player.now().frames - 1.001); player.play()")
    player.wait_for_function("() => !player.now().playing")
    assert now(player) == 1.0
    player.locator("#play").click()  # from the end it starts again
    settle(player)
    assert now(player) < 0.1


def test_the_keyboard_steps_frames_and_events(player, run):
    events, times = run("paper").events, player.evaluate("Array.from(player.arrays.frame_time)")

    def press(key):
        player.keyboard.press(key)
        settle(player)
        return now(player)

    assert [press("ArrowRight") for _ in range(3)] == times[1:4]
    assert press("ArrowLeft") == times[2]
    for event in events[:4]:
        assert press("Shift+ArrowRight") == np.nextafter(event.time, np.inf)
        assert player.evaluate("player.now().state") == event.state
    current = player.locator("#events [aria-current]").text_content()
    assert current.startswith(f"{events[3].time:.6f}4 {events[3].kind.value}")
    assert press("ArrowLeft") == events[3].time  # the other side of the reversal or the impact
    assert press("Shift+ArrowLeft") == np.nextafter(events[2].time, np.inf)
    assert [press(key) for key in ("End", "Home", "ArrowLeft")] == [times[-1], 0.0, 0.0]


def test_slider_events_and_charts_are_scrubbed_with_the_mouse(player, run):
    drag(player, "#slider", 0.005, 0.4, 0.6)
    assert player.evaluate("player.now().film / player.arrays.frame_film.at(-1)") == pytest.approx(0.6, abs=0.01)
    player.locator("#events button").nth(2).click()
    assert now(player) == np.nextafter(run("paper").events[2].time, np.inf)
    seek(player, 0.3252)  # the charts show the collision alone
    drag(player, "#force", 0.6, 0.4)
    assert 0.317 < now(player) < 0.3304
    player.locator("#range").select_option("whole")
    settle(player)
    for name in ("#force", "#energy"):
        seen = []
        for part in (0.3, 0.5, 0.7):  # time is linear, and its range is the run
            drag(player, name, 0.2, part)
            seen.append(now(player))
        assert seen[2] - seen[1] == pytest.approx(seen[1] - seen[0], rel=5e-3)
        drag(player, name, 0.5, 0.999)
        assert now(player) == 1.0
        drag(player, name, 0.5, 0.001)
        assert now(player) == 0.0


def test_frames_differ_and_are_not_blank(opened):
    images = {}
    for time in (0.0, 0.2, 0.3185, 0.3252, 0.5):
        seek(opened, time)
        for name in ("scene", "inset", "force", "energy"):
            images.setdefault(name, set()).add(image(opened, name))
    assert {name: len(found) for name, found in images.items()} == dict.fromkeys(images, 5)


@pytest.mark.parametrize(("width", "height"), [(1280, 720), (1000, 700), (390, 844), (360, 740)])
def test_it_fits_every_window(browser, files, width, height):
    page = browser.new_page(viewport={"width": width, "height": height}, device_scale_factor=2.0)
    page.goto(files().as_uri())
    seek(page, 0.3252)
    size = page.evaluate("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]")
    assert size[0] <= width
    if width >= 900:  # nothing to scroll
        assert size[1] <= height
    for name in ("scene", "inset", "force", "energy"):
        box = page.locator(f"#{name}").bounding_box()
        assert page.locator(f"#{name}").evaluate("c => c.width") == pytest.approx(2.0 * box["width"], rel=0.01)
        assert (box["width"] > 180, box["height"] > 90) == (True, True)
    clipped = page.evaluate(
        "[...document.querySelectorAll('button, h1, h2, output, .pill, label, dl, dd, dt, .legend span')]"
        ".filter(e => e.getClientRects().length && e.clientWidth && e.scrollWidth > e.clientWidth + 1)"
        ".map(e => e.id || e.textContent)"
    )
    assert clipped == []
    page.close()


def test_the_theme_follows_the_system_or_the_switch(player, files):
    light, dark = "rgb(255, 255, 255)", "rgb(18, 23, 29)"

    def ground():
        settle(player)
        return player.evaluate("getComputedStyle(document.body).backgroundColor")

    before = image(player, "scene")
    assert ground() == light
    player.locator("#theme").click()
    assert ground() == dark
    assert image(player, "scene") != before
    player.locator("#theme").click()
    assert ground() == light
    player.emulate_media(color_scheme="dark")
    for theme, expected in (("auto", dark), ("light", light), ("dark", dark)):
        player.goto(files("paper", theme).as_uri())
        assert ground() == expected


def test_names_for_those_who_do_not_see_it(player):
    seek(player, 0.3252)
    assert player.locator("#slider").get_attribute("aria-valuetext") == "0.325200 s, SLIP"
    assert text(player, "spoken") == ""  # not while it changes
    player.wait_for_function("() => document.getElementById('spoken').textContent")
    assert text(player, "spoken") == "t = 0.325200 s, SLIP, normal force 242 N"
    assert player.locator("#scene").get_attribute("aria-label").endswith("bending stress (MPa), tension positive")
    unnamed = player.evaluate(
        "[...document.querySelectorAll('button, input, select, canvas:not([aria-hidden])')].filter(e =>"
        " !(e.getAttribute('aria-label') || e.closest('label') || e.textContent.trim())).length"
    )
    assert unnamed == 0


def test_a_link_opens_after_an_event(page, files, run):
    page.goto(f"{files().as_uri()}#event=3")
    settle(page)
    assert now(page) == np.nextafter(run("paper").events[2].time, np.inf)


def test_a_link_opens_at_a_time_and_in_a_theme(page, files):
    page.goto(f"{files('sticking').as_uri()}#t=0.62&theme=dark")
    settle(page)
    assert (text(page, "state"), now(page)) == ("STICK", pytest.approx(0.62))
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"

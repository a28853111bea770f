"""The page of a run: its numbers against the history, and its behaviour in a headless Chromium."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from oblique_impact.contact.state import State
from renders.geometry import BETWEEN
from renders.player import write_player
from renders.player.document import FRAMES as STEPS
from renders.player.payload import SERIES, payload, unpacked
from renders.player.selection import MAX_EVENTS
from renders.story import story_of
from renders.style import STATE_COLOURS, Style
from tests.renders import FAMILIES

ROUNDING = 2.0**-24  # of float32, relative


def content(history, steps=STEPS):
    """Arrays as they were before they were packed, and the facts."""
    arrays, facts = payload(story_of([history]), steps)
    return {name: unpacked(entry) for name, entry in arrays.items()}, facts


@pytest.fixture(scope="module", params=FAMILIES)
def shown(run, request):
    """A history, and what its page holds."""
    history = run(*FAMILIES[request.param])
    return history, *content(history)


def test_numbers_are_those_of_the_history(shown):
    """To the rounding of float32; times are exact."""
    history, arrays, facts = shown
    k, geometry = arrays["frame_sample"], story_of([history]).geometries[0]
    np.testing.assert_array_equal(arrays["frame_time"], history["time"].values[k])
    np.testing.assert_array_equal(arrays["frame_state"], history["state"].values[k])
    np.testing.assert_array_equal(arrays["frame_stress"], history["bending_stress"].values[k].astype("f4"))
    np.testing.assert_array_equal(arrays["place"], history["station"].values.astype("f4"))
    np.testing.assert_allclose(arrays["radius"], geometry.radii[:: BETWEEN + 1], rtol=2 * ROUNDING)
    assert facts["factor"] == geometry.factor
    for name, short in SERIES.items():
        values = arrays[f"chart_{short}"]
        np.testing.assert_array_equal(values[arrays["frame_point"]], history[name].values[k].astype("f4"))
        known = set(zip(history["time"].values, history[name].values.astype("f4"), strict=True))
        assert set(zip(arrays["chart_time"], values, strict=True)) <= known
    x = geometry.scenario.root.hub_radius + history["station"].values + history["ux"].values[k]
    y, theta = history["uy"].values[k], history["theta"].values[k, None]
    c, s = np.cos(theta), np.sin(theta)
    np.testing.assert_allclose(arrays["frame_x"], x * c - y * s, rtol=2 * ROUNDING, atol=1e-12)
    np.testing.assert_allclose(arrays["frame_y"], x * s + y * c, rtol=2 * ROUNDING, atol=1e-12)


def test_both_sides_of_every_event_are_frames(shown):
    history, arrays, facts = shown
    times = arrays["frame_time"]
    assert [e["time"] for e in facts["events"]] == [e.time for e in history.events]
    for entry, event in zip(facts["events"], history.events, strict=True):
        first, last = entry["before"], entry["frame"]
        assert (times[first], times[last]) == (event.time, np.nextafter(event.time, np.inf))
        assert np.diff(arrays["frame_sample"][[first, last]]) == 1
        found = (entry["state"], entry["kind"], entry["impulse"], entry["loss"])
        assert found == (event.state, event.kind.value, event.normal_impulse, event.energy_loss)


def test_no_peak_of_a_force_is_lost(shown):
    history, arrays, facts = shown
    for short, name in (("normal", "lambda_n"), ("tangential", "lambda_tau")):
        values = history[name].values.astype("f4")
        assert (arrays[f"chart_{short}"].min(), arrays[f"chart_{short}"].max()) == (values.min(), values.max())
    assert facts["peak_force"] == np.hypot(history["lambda_n"], history["lambda_tau"]).max()
    times = history["time"].values
    for collision in history.summary["macro_collisions"]:
        inside = (times >= collision["start"]) & (times <= collision["end"])
        largest = np.float32(history["lambda_n"].values[inside].max())
        frames = (arrays["frame_time"] >= collision["start"]) & (arrays["frame_time"] <= collision["end"])
        assert arrays["chart_normal"][arrays["frame_point"]][frames].max() == largest


def test_the_number_of_frames(shown):
    history, arrays, _ = shown
    extra = 2 * len(history.events) + len(history.summary["macro_collisions"]) + 4
    assert 0.9 * STEPS <= arrays["frame_time"].size <= STEPS + extra


def test_between_frames_little_is_lost(run):
    """Linear in time between frames, shape and stress stay close to all samples that are no frames."""
    history = run("paper")
    arrays, _ = content(history)
    geometry = story_of([history]).geometries[0]
    index, samples = np.arange(geometry.times.size), arrays["frame_sample"]
    true = geometry.stations_of(index)
    k = np.clip(np.searchsorted(samples, index, side="right") - 1, 0, samples.size - 2)
    t0, t1 = arrays["frame_time"][k], arrays["frame_time"][k + 1]
    u = ((geometry.times - t0) / np.where(t1 > t0, t1 - t0, 1.0))[:, None]

    def between(name):
        values = arrays[name].astype(float)
        return (1 - u) * values[k] + u * values[k + 1]

    for n, name in enumerate(("frame_x", "frame_y")):
        assert np.abs(between(name) - true[..., n]).max() < 5e-4  # m, half a pixel of the drawn beam
    stress = history["bending_stress"].values
    assert np.sqrt(np.mean((between("frame_stress") - stress) ** 2)) < 0.15 * np.sqrt(np.mean(stress**2))


def test_a_spring_keeps_the_total_energy(run):
    """Without friction, damping and dissipation the sum with the energy of the stop is constant."""
    changes = ("contact.normal=spring", "contact.friction=frictionless", "discretization.frame=mean-axis")
    arrays, _ = content(run("paper", *changes))
    total = sum(arrays[f"chart_{part}"].astype(float) for part in ("kinetic", "elastic", "gravity", "stop"))
    assert arrays["chart_stop"].max() > 0.05
    np.testing.assert_allclose(total, total[0], rtol=1e-6)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            ("contact.mu_static=0.4",),
            "2 assumed modes, tangent frame, first-order kinetics; "
            "rigid stop, hybrid friction μ = 0.3; event scheme",
        ),
        (
            ("contact.normal=spring", "contact.friction=frictionless", "discretization.method=fem"),
            "32 finite elements reduced to 2 modes, tangent frame, first-order kinetics; "
            "elastic stop 1e6 N/m, frictionless; event scheme",
        ),
    ],
)
def test_the_page_says_what_was_simulated(run, changes, said):
    assert content(run("paper", "end_time=0.05", *changes), 20)[1]["model"] == said


def test_a_run_that_blew_up_still_makes_a_page(run):
    history = run("paper")
    data = history.data.copy(deep=True)
    for name, value in (("bending_stress", 1e300), ("moment", 1e300), ("lambda_n", np.nan), ("shear", np.inf)):
        data[name].values[-1] = value
    data["bending_stress"].values[-2] = 1e15
    blown = replace(history, data=data, summary=history.summary | {"outcome": "diverged"})
    arrays, facts = content(blown)
    sound = np.abs(history["bending_stress"].values).max()
    assert 0.5 * sound < facts["stress_limit"] < 2.0 * sound
    assert [text[0] for _, text in facts["stress_ticks"]][::4] == ["≤", "≥"]
    assert "not valid here" in facts["outcome"]
    assert np.isinf(arrays["frame_stress"][-1]).any()
    assert np.isnan(arrays["chart_normal"][-1])


def test_of_very_many_events_some_are_listed(run):
    history = run("paper")
    many = [event for event in history.events for _ in range(100)]
    arrays, facts = content(replace(history, events=many), 600)
    assert (len(facts["events"]), facts["all_events"]) == (MAX_EVENTS, len(many))
    assert arrays["frame_time"].size < 700


# The file -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def files(run, tmp_path_factory):
    """Write the page of a run of the paper's case, or of another built-in one."""
    folder = tmp_path_factory.mktemp("player")

    def write(name="paper", theme="light", *changes):
        file = folder / f"{'-'.join((name, theme, *changes))}.html"
        if not file.exists():
            write_player(story_of([run(name, *changes)], Style(theme=theme)), file)
        return file

    return write


def test_the_page_holds_the_payload_and_needs_nothing_besides_itself(run, files):
    text = files().read_text(encoding="utf-8")
    arrays, facts = payload(story_of([run("paper")]), STEPS)
    for name, expected in (("arrays", arrays), ("facts", json.loads(json.dumps(facts)))):
        found = re.search(rf'<script type="application/json" id="{name}">(.*?)</script>', text, re.DOTALL)
        assert json.loads(found[1]) == expected
    assert 0.5e6 < len(text) < 1.5e6
    source = re.sub(r'(id="arrays">).*?(</script>)', r"\1\2", text, flags=re.DOTALL)
    outside = r"https?:|//\w|\bsrc\s*=|@import|url\(|<link|\bfetch\(|XMLHttp|import\("
    assert re.findall(outside, source) == []
    assert "default-src 'none'" in source


def test_words_of_a_history_are_only_words(run, tmp_path):
    history = run("paper", "end_time=0.05")
    made = {"provenance": {"version": '</script><script>alert("x")</script>', "numeric_source": "feed"}}
    theirs = replace(history, summary=history.summary | made)
    text = write_player(story_of([theirs]), tmp_path / "words.html").read_text(encoding="utf-8")
    assert "alert(" in text
    assert "<script>alert" not in text


def test_the_same_history_gives_the_same_file(run, tmp_path):
    story = story_of([run("paper", "end_time=0.05")])
    first, second = (write_player(story, tmp_path / name).read_bytes() for name in ("a.html", "b.html"))
    assert first == second


# In the browser -----------------------------------------------------------------------------------------------


@pytest.fixture
def player(page, files):
    """The paper's run in a browser."""
    page.goto(files().as_uri())
    return page


def seek(page, time):
    """Show a time and wait until it is drawn."""
    page.evaluate("t => player.seek(t)", time)
    settle(page)


def settle(page):
    page.evaluate("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)))")


def rgb(state):
    """Colour of a state as a browser writes it."""
    return f"rgb({', '.join(str(int(STATE_COLOURS[state][k : k + 2], 16)) for k in (1, 3, 5))})"


def now(page):
    return page.evaluate("player.now().time")


def text(page, name):
    return page.locator(f"#{name}").text_content()


def image(page, name):
    return page.evaluate("n => document.getElementById(n).toDataURL()", name)


def test_the_browser_decodes_what_was_embedded(player, run):
    for name, array in content(run("paper"))[0].items():
        values = f"player.arrays.{name}"
        size, total = player.evaluate(f"[{values}.length, {values}.reduce((s, v) => s + v, 0)]")
        assert (size, total) == (array.size, pytest.approx(float(array.astype(float).sum()), rel=1e-9))


@pytest.mark.parametrize(("time", "state"), [(0.2, State.FREE), (0.3185, State.SLIP), (0.3252, State.SLIP)])
def test_time_state_and_numbers_are_written(player, run, time, state):
    seek(player, time)
    assert text(player, "time") == f"t = {time:.6f} s"
    assert text(player, "state") == state.name
    assert player.evaluate("getComputedStyle(document.getElementById('state')).backgroundColor") == rgb(state)
    assert text(player, "rate") == ("shown at 1/500 of real time" if state else "shown at 1/10 of real time")
    labels, values = (player.locator(f"#numbers {tag}").all_text_contents() for tag in ("dt", "dd"))
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
    legend = player.locator("#force-legend").text_content().replace("−", "-")
    forces = re.fullmatch(r"Contact force \(N\)normal (\S+)tangential (\S+)", legend).groups()
    assert list(map(float, forces)) == pytest.approx(
        [float(data["lambda_n"]), float(data["lambda_tau"])], rel=2e-3
    )
    legend = player.locator("#energy-legend").text_content()
    energies = dict(re.findall(r"(kinetic|elastic|gravity|total) ([\d.]+)", legend))
    assert legend.startswith("Energy (J)")
    parts = [float(data[f"energy_{kind}"]) for kind in ("kinetic", "elastic", "gravity")]
    assert [float(energies[kind]) for kind in ("kinetic", "elastic", "gravity", "total")] == pytest.approx(
        [*parts, sum(parts)], abs=1e-3
    )
    assert text(player, "deformation") == "deflection drawn ×5 about the pin–tip chord"


def test_the_rate_follows_the_chosen_speed(player):
    seek(player, 0.2)
    for speed, said in (("0.5", "1/20"), ("4", "1/2.5")):
        player.locator("#speed").select_option(speed)
        settle(player)
        assert text(player, "rate") == f"shown at {said} of real time"


def test_events_are_listed_with_time_kind_and_impulse(player, run):
    shown = player.locator("#events li").all_text_contents()
    for row, event in zip(shown, run("paper").events, strict=True):
        found = re.fullmatch(r"([\d.]{8})(\w+) (?:(\S+) N s)?", row)
        assert (float(found[1]), found[2]) == (pytest.approx(event.time, abs=1e-6), event.kind.value)
        assert float(found[3] or 0.0) == pytest.approx(event.normal_impulse, rel=6e-3)
    assert text(player, "events-note") == "time (s), kind, impulse"
    dots = player.locator("#events i").evaluate_all("dots => dots.map(d => getComputedStyle(d).backgroundColor)")
    assert dots == [rgb(event.state) for event in run("paper").events]


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
    assert current.startswith(f"{events[3].time:.6f}{events[3].kind.value}")
    assert press("ArrowLeft") == events[3].time  # the other side of the reversal or the impact
    assert press("Shift+ArrowLeft") == np.nextafter(events[2].time, np.inf)
    assert [press(key) for key in ("End", "Home", "ArrowLeft")] == [times[-1], 0.0, 0.0]


def drag(page, name, *parts):
    """Press the mouse at a part of the width of an element, drag through the others, and release."""
    box = page.locator(name).bounding_box()
    for n, part in enumerate(parts):
        page.mouse.move(box["x"] + part * box["width"], box["y"] + 0.5 * box["height"])
        if n == 0:
            page.mouse.down()
    page.mouse.up()
    settle(page)


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


def test_frames_differ_and_are_not_blank(player):
    images = {}
    for time in (0.0, 0.2, 0.3185, 0.3252, 0.5):
        seek(player, time)
        for name in ("scene", "inset", "force", "energy"):
            images.setdefault(name, set()).add(image(player, name))
    assert {name: len(found) for name, found in images.items()} == dict.fromkeys(images, 5)


@pytest.mark.parametrize(("width", "height"), [(1280, 720), (1000, 700), (390, 844)])
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
    assert text(player, "spoken").startswith("t = 0.325200 s, SLIP, normal force 242 N")
    unnamed = player.evaluate(
        "[...document.querySelectorAll('button, input, select, canvas:not([aria-hidden])')].filter(e =>"
        " !(e.getAttribute('aria-label') || e.closest('label') || e.textContent.trim())).length"
    )
    assert unnamed == 0


def test_a_link_opens_at_a_time_and_in_a_theme(page, files):
    page.goto(f"{files('sticking').as_uri()}#t=0.62&theme=dark")
    settle(page)
    assert (text(page, "state"), now(page)) == ("STICK", pytest.approx(0.62))
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"


# In another page ----------------------------------------------------------------------------------------------


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
    frame.wait_for_function("() => !player.now().playing")
    page.evaluate("scrollTo(0, 0)")
    frame.wait_for_function("() => player.now().playing")
    shown = "[...document.querySelectorAll('canvas, button, select, a, h1')].filter(e => e.getClientRects().length)"
    assert frame.evaluate(f"{shown}.map(e => e.id).sort()") == ["play", "scene", "speed", "strip", "whole"]
    assert frame.evaluate("[document.body.scrollWidth, document.body.scrollHeight]") == [640, 360]
    assert frame.evaluate("document.getElementById('whole').href").endswith(".html")  # the page without "#embed"
    frame.locator("#play").click()  # the reader's own pause lasts
    page.evaluate("scrollTo(0, 2000)")
    page.wait_for_timeout(200)
    page.evaluate("scrollTo(0, 0)")
    page.wait_for_timeout(200)
    assert not frame.evaluate("player.now().playing")


def test_embedded_it_stands_still_for_those_who_want_no_motion(embedded):
    embedded()[0].emulate_media(reduced_motion="reduce")
    page, frame = embedded()
    page.wait_for_timeout(300)
    assert not frame.evaluate("player.now().playing")
    frame.locator("#play").click()  # but it can be played
    frame.wait_for_function("() => player.now().time > 0.001")

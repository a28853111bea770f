"""The page of a run: its numbers against the history, and its behaviour in a headless Chromium."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from oblique_impact import InputError
from oblique_impact.contact.state import State
from renders.envelope import drawn
from renders.geometry import BETWEEN, BeamGeometry
from renders.player import write_player
from renders.player.payload import SERIES, unpacked
from renders.player.selection import MAX_EVENTS
from renders.scene import contact_force
from renders.story import story_of
from renders.style import STATE_COLOURS
from tests.render.browser import NAMES, Page, find_browser
from tests.render.test_pictures import check_arrow

FAMILIES = {
    "paper": ("paper",),
    "mid-span": ("mid-span",),
    "hub": ("paper", "root.kind=hub", "root.inertia=0.1", "root.hub_radius=0.1", "contact.enabled=false"),
    "tapered": ("tapered", "end_time=0.34"),
}
STEPS = 1800
ROUNDING = 2.0**-24  # of float32, relative
needs_browser = pytest.mark.skipif(find_browser() is None, reason=f"none of {', '.join(NAMES)} is on the PATH")


@pytest.fixture(params=FAMILIES)
def history(run, request):
    name, *overrides = FAMILIES[request.param]
    return run(name, *overrides)


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    return tmp_path_factory.mktemp("player")


def embedded(text, name):
    found = re.search(rf'<script type="application/json" id="{name}">(.*?)</script>', text, re.DOTALL)
    return json.loads(found.group(1))


def decoded(file):
    text = file.read_text(encoding="utf-8")
    return {name: unpacked(entry) for name, entry in embedded(text, "arrays").items()}, embedded(text, "facts")


@pytest.fixture
def page(history, pages):
    return decoded(write_player(history, pages / "numbers.html", steps=STEPS))


def compare_with(history, arrays):
    """Every number of the frames is that of the history, to the rounding of float32; times are exact."""
    k = arrays["frame_sample"]
    np.testing.assert_array_equal(arrays["frame_time"], history["time"].values[k])
    np.testing.assert_array_equal(arrays["frame_state"], history["state"].values[k])
    for name, short in SERIES.items():
        shown = arrays[f"chart_{short}"][arrays["frame_point"]]
        np.testing.assert_array_equal(shown, history[name].values[k].astype("f4"))
    stress = history["bending_stress"].values
    np.testing.assert_array_equal(arrays["frame_stress"], stress[k].astype("f4"))
    radius = BeamGeometry(history).scenario.root.hub_radius
    theta = history["theta"].values[k, None]
    x = radius + history["station"].values + history["ux"].values[k]
    y = history["uy"].values[k]
    for found, expected in (
        (arrays["frame_x"], x * np.cos(theta) - y * np.sin(theta)),
        (arrays["frame_y"], x * np.sin(theta) + y * np.cos(theta)),
    ):
        np.testing.assert_allclose(found, expected, rtol=2 * ROUNDING, atol=1e-12)


def test_numbers_are_those_of_the_history(history, page):
    compare_with(history, page[0])


@pytest.mark.parametrize("name", ["frame_stress", "frame_x", "chart_normal", "frame_time", "chart_kinetic"])
def test_a_wrong_number_is_noticed(run, pages, name):
    """A fifth more of any quantity fails the comparison above."""
    history = run("paper")
    arrays, _ = decoded(write_player(history, pages / "wrong.html"))
    with pytest.raises(AssertionError):
        compare_with(history, arrays | {name: arrays[name] * 1.2})


def test_the_drawn_beam_is_that_of_the_other_pictures(history, page):
    arrays, facts = page
    chosen, true = BeamGeometry(history), BeamGeometry(history, 1.0)
    assert facts["factor"] == chosen.factor
    for n in np.linspace(0, arrays["frame_time"].size - 1, 9).astype(int):
        axis = true.centreline(int(arrays["frame_sample"][n]))[:: BETWEEN + 1]
        np.testing.assert_allclose(arrays["frame_x"][n], axis[:, 0], rtol=2 * ROUNDING, atol=1e-12)
        np.testing.assert_allclose(arrays["frame_y"][n], axis[:, 1], rtol=2 * ROUNDING, atol=1e-12)
    np.testing.assert_allclose(arrays["radius"], true.radii[:: BETWEEN + 1], rtol=2 * ROUNDING)
    np.testing.assert_array_equal(arrays["place"], history["station"].values.astype("f4"))


def test_both_sides_of_every_event_are_frames(history, page):
    arrays, facts = page
    times = arrays["frame_time"]
    assert [e["time"] for e in facts["events"]] == [e.time for e in history.events]
    for shown, event in zip(facts["events"], history.events, strict=True):
        first, last = shown["before"], shown["frame"]
        assert (times[first], times[last]) == (event.time, np.nextafter(event.time, np.inf))
        samples = arrays["frame_sample"][[first, last]]
        assert samples[1] == samples[0] + 1
        assert shown["state"] == event.state
        assert shown["kind"] == event.kind.value
        assert shown["impulse"] == event.normal_impulse


def test_no_peak_of_a_force_is_lost(history, page):
    arrays, facts = page
    for short, name in (("normal", "lambda_n"), ("tangential", "lambda_tau")):
        values = history[name].values.astype("f4")
        assert arrays[f"chart_{short}"].max() == values.max()
        assert arrays[f"chart_{short}"].min() == values.min()
    times = history["time"].values
    for collision in history.summary["macro_collisions"]:
        inside = (times >= collision["start"]) & (times <= collision["end"])
        largest = np.float32(history["lambda_n"].values[inside].max())
        for time, force in (
            (arrays["chart_time"], arrays["chart_normal"]),
            (arrays["frame_time"], arrays["chart_normal"][arrays["frame_point"]]),
        ):
            assert force[(time >= collision["start"]) & (time <= collision["end"])].max() == largest
    assert facts["stress_limit"] >= np.abs(history["bending_stress"].values).max()


def test_charts_are_samples_of_the_history(history, page):
    arrays, _ = page
    times = arrays["chart_time"]
    assert np.all(np.diff(times) >= 0.0)
    for name, short in SERIES.items():
        known = set(zip(history["time"].values, history[name].values.astype("f4"), strict=True))
        assert set(zip(times, arrays[f"chart_{short}"], strict=True)) <= known
    np.testing.assert_array_equal(times[arrays["frame_point"]], arrays["frame_time"])


def test_the_number_of_frames_and_the_size(history, pages):
    extra = 2 * len(history.events) + len(history.summary["macro_collisions"]) + 4
    for steps in (50, STEPS):
        file = write_player(history, pages / "size.html", steps=steps)
        frames = decoded(file)[0]["frame_time"].size
        assert 0.9 * steps <= frames <= steps + extra
    assert 0.5e6 < file.stat().st_size < 1.5e6


def test_between_frames_little_is_lost(run, pages):
    """Linear in time between frames, shape and stress stay close to all samples that are no frames."""
    history = run("paper")
    arrays, _ = decoded(write_player(history, pages / "between.html"))
    geometry = BeamGeometry(history, 1.0)
    true = geometry.stations_of(np.arange(geometry.times.size))
    index = np.arange(geometry.times.size)
    k = np.clip(np.searchsorted(arrays["frame_sample"], index, side="right") - 1, 0, arrays["frame_time"].size - 2)
    t0, t1 = arrays["frame_time"][k], arrays["frame_time"][k + 1]
    u = ((geometry.times - t0) / np.where(t1 > t0, t1 - t0, 1.0))[:, None]
    worst = 0.0
    for n, name in enumerate(("frame_x", "frame_y")):
        values = arrays[name].astype(float)
        worst = max(worst, np.abs((1 - u) * values[k] + u * values[k + 1] - true[..., n]).max())
    assert worst < 5e-4  # m, half a pixel of the drawn beam
    stress, drawn = history["bending_stress"].values, arrays["frame_stress"].astype(float)
    missed = (1 - u) * drawn[k] + u * drawn[k + 1] - stress
    assert np.sqrt(np.mean(missed**2)) < 0.15 * np.sqrt(np.mean(stress**2))


def test_a_spring_keeps_the_total_energy(run, pages):
    """Without friction, damping and dissipation the sum with the energy of the stop is constant."""
    history = run(
        "paper", "contact.normal=spring", "contact.friction=frictionless", "discretization.frame=mean-axis"
    )
    arrays, _ = decoded(write_player(history, pages / "spring.html"))
    total = sum(arrays[f"chart_{part}"].astype(float) for part in ("kinetic", "elastic", "gravity", "stop"))
    assert arrays["chart_stop"].max() > 0.05
    np.testing.assert_allclose(total, total[0], rtol=1e-6)


# The file -----------------------------------------------------------------------------------------------------


def test_the_page_needs_nothing_besides_itself(history, pages):
    text = write_player(history, pages / "alone.html").read_text(encoding="utf-8")
    source = re.sub(r'(id="arrays">).*?(</script>)', r"\1\2", text, flags=re.DOTALL)
    for fault in (
        r"https?:",
        r"//\w",
        r"\bsrc\s*=",
        r"@import",
        r"url\(",
        r"<link",
        r"\bfetch\(",
        "XMLHttp",
        r"import\(",
    ):
        assert not re.search(fault, source), fault
    assert "default-src 'none'" in source


def test_the_same_history_gives_the_same_file(run, pages):
    first, second = (write_player(run("paper"), pages / f"{n}.html").read_bytes() for n in "ab")
    assert first == second


def test_a_title_is_only_a_title(run, pages):
    title = '</script><script>alert("x")</script> & <b>'
    text = write_player(run("paper"), pages / "title.html", title=title).read_text(encoding="utf-8")
    assert "alert(&#34;x&#34;)" in text
    assert "<script>alert" not in text


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"theme": "blue"}, "theme = 'blue'"),
        ({"steps": 1}, "steps = 1"),
        ({"steps": 10**6}, "steps = 1000000"),
        ({"factor": -2.0}, "--deformation -2.0"),
    ],
)
def test_a_bad_argument_is_one_line_and_leaves_no_file(run, tmp_path, arguments, said):
    with pytest.raises(InputError, match=re.escape(said)) as caught:
        write_player(run("paper"), tmp_path / "bad.html", **arguments)
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_a_history_without_a_beam_is_one_line(run, tmp_path):
    history = run("paper")
    for name in ("uy", "lambda_n", "bending_stress"):
        with pytest.raises(InputError, match=name):
            write_player(replace(history, data=history.data.drop_vars(name)), tmp_path / "none.html")
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_cannot_be_written_is_one_line(run, tmp_path):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder").mkdir()
    for place in (tmp_path / "file" / "x.html", tmp_path / "folder"):
        with pytest.raises(InputError, match="cannot be written"):
            write_player(run("paper"), place)
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["file", "folder"]


def test_a_run_that_blew_up_still_makes_a_page(run, pages):
    history = run("paper")
    data = history.data.copy(deep=True)
    for name, value in (("bending_stress", 1e300), ("moment", 1e300), ("lambda_n", np.nan), ("shear", np.inf)):
        data[name].values[-1] = value
    data["bending_stress"].values[-2] = 1e15
    summary = history.summary | {"outcome": "diverged"}
    arrays, facts = decoded(write_player(replace(history, data=data, summary=summary), pages / "blown.html"))
    sound = np.abs(history["bending_stress"].values).max()
    assert 0.5 * sound < facts["stress_limit"] < 2.0 * sound
    assert [text[0] for _, text in facts["stress_ticks"]][::4] == ["≤", "≥"]
    assert "not valid here" in facts["outcome"]
    assert np.isinf(arrays["frame_stress"][-1]).any()
    assert np.isnan(arrays["chart_normal"][-1])


@needs_browser
def test_a_run_that_blew_up_is_shown(run, pages, browser):
    """The paper's model with too many clamped shapes; the page says why it stopped."""
    history = run("paper", "discretization.modes=6")
    browser.size(1280, 720)
    browser.open(write_player(history, pages / "stopped.html"))
    browser.key("End")
    assert time_shown(browser) == pytest.approx(history.summary["end_time"], abs=1e-6)
    assert "The run stopped early." in browser.evaluate("document.querySelector('header').textContent")
    assert browser.errors == []


def test_of_very_many_events_some_are_listed(run, pages):
    history = run("paper")
    many = [event for event in history.events for _ in range(100)]
    arrays, facts = decoded(write_player(replace(history, events=many), pages / "many.html", steps=600))
    assert len(facts["events"]) == MAX_EVENTS
    assert facts["all_events"] == len(many)
    assert arrays["frame_time"].size < 700


# In the browser -----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def browser():
    with Page(find_browser()) as opened:
        yield opened


@pytest.fixture
def shown(run, pages, browser):
    """The paper's run in a browser; nothing may be reported and nothing asked for."""
    file = pages / "shown.html"
    if not file.exists():
        write_player(run("paper"), file)
    browser.errors.clear()
    browser.requests.clear()
    browser.size(1280, 720)
    browser.open(file, "")
    yield browser
    assert browser.errors == []
    assert {r for r in browser.requests if r != "about:blank"} <= {file.resolve().as_uri()}


def time_shown(page):
    return float(re.fullmatch(r"t = ([\d.]+) s", page.evaluate("document.getElementById('time').textContent"))[1])


def canvas(page, name):
    """Pixels (n, 4) of a canvas."""
    values = page.evaluate(
        f"(() => {{ const c = document.getElementById('{name}'), copy = document.createElement('canvas');"
        " copy.width = c.width; copy.height = c.height;"
        " const own = copy.getContext('2d', {willReadFrequently: true}); own.drawImage(c, 0, 0);"
        " const d = own.getImageData(0, 0, c.width, c.height).data; let s = '';"
        " for (let k = 0; k < d.length; k += 8192) s += String.fromCharCode(...d.subarray(k, k + 8192));"
        " return btoa(s); })()"
    )
    return np.frombuffer(base64.b64decode(values), dtype=np.uint8).reshape(-1, 4)


def count_of(pixels, colour):
    wanted = [int(colour[k : k + 2], 16) for k in (1, 3, 5)]
    return int(np.all(pixels[:, :3] == wanted, axis=1).sum())


@needs_browser
def test_the_browser_decodes_what_was_embedded(shown, pages):
    arrays, _ = decoded(pages / "shown.html")
    for name in arrays:
        found = shown.evaluate(f"[player.arrays.{name}.length, player.arrays.{name}.reduce((s, v) => s + v, 0)]")
        assert found[0] == arrays[name].size
        assert found[1] == pytest.approx(float(arrays[name].astype(float).sum()), rel=1e-9)
    k = 300
    stress = shown.evaluate(f"(player.goTo({k}), Array.from(player.now().stress))")
    np.testing.assert_array_equal(stress, arrays["frame_stress"][k].astype(float))


@needs_browser
@pytest.mark.parametrize(("time", "state"), [(0.2, State.FREE), (0.3185, State.SLIP), (0.3252, State.SLIP)])
def test_time_state_and_numbers_are_written(shown, run, time, state):
    shown.evaluate(f"player.seek({time})")
    shown.settle()
    assert time_shown(shown) == pytest.approx(time, abs=1e-6)
    assert shown.evaluate("document.getElementById('state').textContent") == state.name
    colour = STATE_COLOURS[state]
    rgb = ", ".join(str(int(colour[k : k + 2], 16)) for k in (1, 3, 5))
    assert shown.evaluate("getComputedStyle(document.getElementById('state')).backgroundColor") == f"rgb({rgb})"
    rate = shown.evaluate("document.getElementById('rate').textContent")
    assert rate == ("shown at 1/500 of real time" if state else "shown at 1/10 of real time")
    data = run("paper").data
    # of the second, not of the first of two samples at an event
    force = float(np.interp(time, data["time"].values, data["lambda_n"].values))
    numbers = shown.evaluate("document.getElementById('numbers').textContent").replace("−", "-")
    assert float(re.search(r"normal force([-\d.]+) N", numbers)[1]) == pytest.approx(force, rel=2e-3)
    assert "deflection drawn ×5 about the pin–tip chord" in shown.evaluate("document.body.textContent")


@needs_browser
def test_a_state_of_its_own_colour_for_stick(run, pages, browser):
    file = write_player(run("sticking"), pages / "sticking.html")
    browser.size(1280, 720)
    browser.open(file, "#t=0.62")
    assert browser.evaluate("document.getElementById('state').textContent") == "STICK"
    pixels = canvas(browser, "scene")
    assert count_of(pixels, STATE_COLOURS[2]) > 100
    assert browser.errors == []


@needs_browser
def test_it_plays_and_pauses(shown):
    shown.evaluate("player.seek(0.1)")
    shown.key(" ")
    assert shown.evaluate("document.getElementById('play').getAttribute('aria-label')") == "Pause"
    shown.until("player.now().time > 0.11")
    shown.key(" ")
    paused = shown.evaluate("player.now().time")
    shown.settle()
    assert shown.evaluate("player.now().time") == paused
    assert not shown.evaluate("player.now().playing")
    assert paused < 0.317  # in flight a tenth of real time
    shown.evaluate("document.getElementById('play').click()")
    shown.until(f"player.now().time > {paused}")
    shown.evaluate("document.getElementById('play').click()")
    shown.evaluate("player.goTo(1e9); player.play()")  # from the end it starts again
    shown.settle()
    assert shown.evaluate("player.now().time") < 0.1


@needs_browser
def test_at_the_end_it_stops(shown):
    shown.evaluate("player.goTo(player.now().frames - 1.001); player.play()")
    shown.until("!player.now().playing")
    assert shown.evaluate("player.now().time") == 1.0


@needs_browser
def test_the_keyboard_steps_frames_and_events(shown, run, pages):
    events = run("paper").events
    times = decoded(pages / "shown.html")[0]["frame_time"]
    for n in (1, 2, 3):
        shown.key("ArrowRight")
        assert shown.evaluate("player.now().time") == times[n]
    shown.key("ArrowLeft")
    assert shown.evaluate("player.now().time") == times[2]
    for event in events[:4]:
        shown.key("ArrowRight", shift=True)
        assert shown.evaluate("player.now().time") == np.nextafter(event.time, np.inf)
        assert shown.evaluate("player.now().state") == event.state
    current = shown.evaluate("document.querySelector('#events [aria-current]').textContent")
    assert current.startswith(f"{events[3].time:.6f}{events[3].kind.value}")
    shown.key("ArrowLeft")  # the other side of the reversal or the impact
    assert shown.evaluate("player.now().time") == events[3].time
    shown.key("ArrowLeft", shift=True)
    assert shown.evaluate("player.now().time") == np.nextafter(events[2].time, np.inf)
    shown.key("End")
    assert shown.evaluate("player.now().time") == times[-1]
    shown.key("Home")
    assert shown.evaluate("player.now().time") == 0.0
    shown.key("ArrowLeft")
    assert shown.evaluate("player.now().time") == 0.0


def middle_of(page, selector, part=0.5):
    x, y, w, h = page.evaluate(
        f"(() => {{ const b = document.querySelector({json.dumps(selector)}).getBoundingClientRect();"
        " return [b.left, b.top, b.width, b.height]; })()"
    )
    return x + part * w, y + 0.5 * h


@needs_browser
def test_slider_events_and_charts_are_scrubbed_with_the_mouse(shown, run):
    shown.mouse(
        middle_of(shown, "#slider", 0.005), middle_of(shown, "#slider", 0.4), middle_of(shown, "#slider", 0.6)
    )
    film = shown.evaluate("player.now().film / player.arrays.frame_film.at(-1)")
    assert film == pytest.approx(0.6, abs=0.01)
    event = run("paper").events[2]
    shown.evaluate("document.querySelector('#events li').scrollIntoView()")
    shown.mouse(middle_of(shown, "#events li:nth-child(3) button"))
    assert shown.evaluate("player.now().time") == np.nextafter(event.time, np.inf)
    shown.evaluate(
        "(() => { const r = document.getElementById('range'); r.value = 'whole';"
        " r.dispatchEvent(new Event('change')); })()"
    )
    shown.settle()
    for name in ("force", "energy"):
        shown.mouse(middle_of(shown, f"#{name}", 0.3), middle_of(shown, f"#{name}", 0.5))
        width = shown.evaluate(f"document.getElementById('{name}').getBoundingClientRect().width")
        left, right = 62, 12  # px of the axes
        assert shown.evaluate("player.now().time") == pytest.approx(
            (0.5 * width - left) / (width - left - right), abs=2e-3
        )


@needs_browser
def test_in_a_collision_the_charts_come_closer(shown):
    """The cursor of the followed collision lies where its time is in the shown range."""
    shown.evaluate("player.seek(0.3252)")
    shown.settle()
    shown.mouse(middle_of(shown, "#force", 0.6), middle_of(shown, "#force", 0.4))
    assert 0.317 < shown.evaluate("player.now().time") < 0.3304


@needs_browser
def test_frames_differ_and_are_not_blank(shown):
    images = {}
    for time in (0.0, 0.2, 0.3185, 0.3252, 0.5):
        shown.evaluate(f"player.seek({time})")
        shown.settle()
        for name in ("scene", "inset", "force", "energy", "strip"):
            pixels = canvas(shown, name)
            assert (pixels[:, 3] > 0).mean() > 0.02, name
            images.setdefault(name, []).append(pixels.tobytes())
    for name in ("scene", "inset", "force", "energy"):
        assert len(set(images[name])) == 5, name


def contact_place(page, name):
    """Pixels of the point of contact in a view."""
    return np.array(page.evaluate(f"player.place('{name}')"))


@needs_browser
@pytest.mark.parametrize("name", ["scene", "inset"])
@pytest.mark.parametrize("time", [0.322, 0.3256])  # slipping down and up the slope
def test_the_arrow_points_along_the_force_and_leaves_the_contact_point_free(shown, run, name, time):
    history = run("paper")
    k = BeamGeometry(history).index(time)
    along = contact_force(BeamGeometry(history), k) * (1.0, -1.0)  # rows count downward
    shown.evaluate(f"player.seek({time})")
    shown.settle()
    wide, high = shown.evaluate(f"(c => [c.width, c.height])(document.getElementById('{name}'))")
    pixels = canvas(shown, name).reshape(high, wide, 4)[..., :3].astype(int)
    if name == "scene":
        pixels = pixels[:-60]  # the colour bar
    tint = [int(STATE_COLOURS[1][n : n + 2], 16) for n in (1, 3, 5)]
    rows, columns = np.nonzero(np.abs(pixels - tint).max(axis=2) < 10)
    found = np.stack([columns + 0.5, rows + 0.5], axis=1)
    place = contact_place(shown, name)
    near = found[np.linalg.norm(found - place, axis=1) < (60 if name == "scene" else 45)]  # without the number
    check_arrow(near, along / np.linalg.norm(along), place)
    with pytest.raises(AssertionError):  # as it would be with the other sign
        check_arrow(near, -along / np.linalg.norm(along), place)


@needs_browser
def test_a_vibration_is_the_same_band_as_in_a_film(shown):
    """The page's own reduction of a curve to its pixels against the one of the other pictures."""
    x = np.linspace(0.0, 300.0, 4001)
    y = np.where((x > 100.0) & (x < 200.0), 30.0 * np.sin(2.0 * np.pi * x / 3.7), 0.0) + 0.1 * x + 3.0 * (x > 50.0)
    expected = drawn(x, y, 1.0)
    found = shown.evaluate(f"player.envelope({x.tolist()}, {y.tolist()}, 1)")
    assert len(found["bands"]) == len(expected.bands) == 1
    mine, theirs = expected.bands[0], found["bands"][0]
    np.testing.assert_allclose(theirs["x"], mine.x)
    np.testing.assert_allclose(theirs["low"], mine.low, atol=1e-9)
    np.testing.assert_allclose(theirs["high"], mine.high, atol=1e-9)
    line = np.concatenate([y[found["lines"][0]["from"] : found["lines"][0]["to"]], theirs["mean"]])
    np.testing.assert_allclose(line, expected.y[: line.size], atol=0.02)  # where the area of a pixel is cut


@needs_browser
def test_vibrations_of_the_whole_run_leave_the_chart_light(shown):
    """In flight the energies swing many times in a pixel: the band is lighter than a line drawn through them."""
    shown.evaluate(
        "(e => { e.value = 'whole'; e.dispatchEvent(new Event('change')); })(document.getElementById('range'))"
    )
    shown.evaluate("player.goTo(1e9)")
    shown.settle()
    pixels = canvas(shown, "energy").astype(int)
    tinted, cover = np.ptp(pixels[:, :3], axis=1) > 15, pixels[:, 3]
    lines, bands = (tinted & (cover > 200)).sum(), (tinted & (cover > 50) & (cover < 160)).sum()
    assert bands > 2 * lines > 1000


@needs_browser
def test_the_colour_bar_has_the_labels_of_the_other_pictures(shown, run):
    scale = story_of([run("paper")]).colours
    assert shown.evaluate("player.facts.stress_limit") == scale.limit
    assert shown.evaluate("player.facts.stress_ticks") == [list(tick) for tick in scale.ticks]
    written = shown.evaluate(
        "(() => { const out = [], p = CanvasRenderingContext2D.prototype, old = p.fillText;"
        " p.fillText = function (t, ...r) { out.push(t); return old.call(this, t, ...r); };"
        " player.goTo(5); return new Promise(r => requestAnimationFrame(() => requestAnimationFrame(() => {"
        " p.fillText = old; r(out); }))); })()"
    )
    assert {scale.title, *(text for _, text in scale.ticks)} <= set(written)


@needs_browser
def test_the_force_is_drawn_only_in_contact_and_in_its_colour(shown):
    counts = {}
    for time in (0.2, 0.3252):
        shown.evaluate(f"player.seek({time})")
        shown.settle()
        counts[time] = [count_of(canvas(shown, name), STATE_COLOURS[1]) for name in ("scene", "inset")]
    assert counts[0.2] == [0, 0]
    assert min(counts[0.3252]) > 100


@needs_browser
def test_the_stress_is_drawn_on_its_own_side(shown, pages):
    """Where the lower fibre is in tension, red lies below blue; without stress there is neither."""
    arrays, _ = decoded(pages / "shown.html")
    bar = 60  # px of the colour bar at the bottom

    def heights(frame):
        shown.evaluate(f"player.goTo({frame})")
        shown.settle()
        wide, high = shown.evaluate("(c => [c.width, c.height])(document.getElementById('scene'))")
        rgb = canvas(shown, "scene").reshape(high, wide, 4)[:-bar].astype(int)
        red = rgb[..., 0] - rgb[..., 2] > 60
        blue = (rgb[..., 2] - rgb[..., 0] > 40) & (rgb[..., 1] - rgb[..., 0] > 15)  # not that of the trace
        columns = np.flatnonzero(red.any(axis=0) & blue.any(axis=0))
        rows = np.arange(rgb.shape[0])[:, None]
        return [
            (rows * red)[:, columns].sum(axis=0) / red[:, columns].sum(axis=0),
            (rows * blue)[:, columns].sum(axis=0) / blue[:, columns].sum(axis=0),
        ]

    flight = arrays["frame_state"] == State.FREE  # no orange arrow
    extent = np.where(flight[:, None], arrays["frame_stress"], 0.0)
    for frame, sign in ((int(extent.max(axis=1).argmax()), 1), (int(extent.min(axis=1).argmin()), -1)):
        red, blue = heights(frame)
        assert red.size > 20
        assert np.mean(sign * (red - blue) > 0.0) > 0.9  # rows count downward
    red, _ = heights(0)
    assert red.size == 0


@needs_browser
def test_the_interpolated_beam_keeps_its_length(run, pages, browser):
    """Between the frames of a fast spin the beam turns; it does not cut the corner."""
    file = write_player(run("spin-up"), pages / "spin.html", steps=100)
    browser.size(1280, 720)
    browser.open(file)
    reach = browser.evaluate(
        "(() => { const out = []; for (let p = 80; p < 90; p += 0.25) { player.goTo(p);"
        " const m = player.now(); out.push(Math.hypot(m.x.at(-1), m.y.at(-1))); } return out; })()"
    )
    assert np.ptp(reach) < 2e-3 * max(reach)
    turns = browser.evaluate("(player.goTo(80), player.now().x.at(-1)) - (player.goTo(81), player.now().x.at(-1))")
    assert abs(turns) > 0.1  # a chord would be shorter by more than that
    assert browser.errors == []


@needs_browser
@pytest.mark.parametrize(("width", "height"), [(1280, 720), (1920, 1080), (1000, 700), (700, 1000), (390, 844)])
def test_it_fits_every_window(shown, width, height):
    shown.size(width, height, 2.0)
    shown.evaluate("player.seek(0.3252)")
    shown.settle()
    assert shown.evaluate("document.documentElement.scrollWidth") <= width
    if width >= 900:  # nothing to scroll
        assert shown.evaluate("document.documentElement.scrollHeight") <= height
    for name in ("scene", "inset", "force", "energy"):
        dots, wide, high = shown.evaluate(
            f"(c => [c.width / c.getBoundingClientRect().width, c.clientWidth, c.clientHeight])"
            f"(document.getElementById('{name}'))"
        )
        assert dots == pytest.approx(2.0, rel=0.01)
        assert wide > 180
        assert high > 90
    clipped = shown.evaluate(
        "[...document.querySelectorAll('button, h1, h2, output, .pill, label, dl, dd, dt, .legend span')]"
        ".filter(e => e.getClientRects().length && (e.scrollWidth > e.clientWidth + 1 && e.clientWidth))"
        ".map(e => e.id || e.textContent)"
    )
    assert clipped == []


@needs_browser
def test_the_theme_follows_the_system_or_the_switch(shown, run, pages):
    ground = "getComputedStyle(document.body).backgroundColor"
    light, dark = "rgb(255, 255, 255)", "rgb(18, 23, 29)"
    assert shown.evaluate(ground) == light
    before = canvas(shown, "scene").tobytes()
    shown.evaluate("document.getElementById('theme').click()")
    shown.settle()
    assert shown.evaluate(ground) == dark
    assert canvas(shown, "scene").tobytes() != before
    shown.evaluate("document.getElementById('theme').click()")
    assert shown.evaluate(ground) == light
    wish = [{"name": "prefers-color-scheme", "value": "dark"}]
    for theme, expected in (("auto", dark), ("light", light), ("dark", dark)):
        shown.call("Emulation.setEmulatedMedia", features=wish if theme == "auto" else [])
        text = write_player(run("paper"), pages / "theme.html", theme=theme).read_text(encoding="utf-8")
        assert f'data-theme="{theme}"' in text
        shown.open(pages / "theme.html")
        assert shown.evaluate(ground) == expected
    shown.call("Emulation.setEmulatedMedia", features=[])
    shown.requests.clear()


@needs_browser
def test_it_prints_light_and_goes_back(shown):
    shown.evaluate("document.getElementById('theme').click()")
    shown.call("Emulation.setEmulatedMedia", media="print")
    shown.settle()
    assert shown.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert shown.evaluate("getComputedStyle(document.querySelector('footer')).display") == "none"
    shown.call("Emulation.setEmulatedMedia", media="")
    shown.settle()
    assert shown.evaluate("document.documentElement.dataset.theme") == "dark"
    assert re.findall(rb"/Count (\d+)", shown.print()) == [b"1"]  # one sheet
    assert "paper" not in shown.evaluate("document.documentElement.className")


@needs_browser
def test_names_for_those_who_do_not_see_it(shown):
    shown.evaluate("player.seek(0.3252)")
    shown.settle()
    assert shown.evaluate("document.getElementById('slider').getAttribute('aria-valuetext')") == "0.325200 s, SLIP"
    spoken = shown.evaluate("document.getElementById('spoken').textContent")
    assert spoken.startswith("t = 0.325200 s, SLIP, normal force 242 N")
    unnamed = shown.evaluate(
        "[...document.querySelectorAll('button, input, select, canvas:not([aria-hidden])')].filter(e =>"
        " !(e.getAttribute('aria-label') || e.closest('label') || e.textContent.trim())).length"
    )
    assert unnamed == 0

"""The page of a run: its content against the history, and the page in a browser."""

from __future__ import annotations

import json
import re
from io import BytesIO
from itertools import pairwise
from typing import get_args

import numpy as np
import pytest
from PIL import Image

from oblique_impact.contact.state import State
from oblique_impact.renders.outlines import SIDES
from oblique_impact.renders.player import write_player
from oblique_impact.renders.player.content import content_of, fixed, significant
from oblique_impact.renders.story import colour_scale, story_of
from oblique_impact.renders.style import Colour, Style
from oblique_impact.renders.timeline import rate_text
from tests.renders.browsing import now, numbers, seek, settle, show, text


@pytest.fixture(scope="module")
def content(story):
    return content_of(story)


# Content ------------------------------------------------------------------------------------------------------


def test_numbers_are_written_as_they_are():
    rates = [rate_text(rate) for rate in (1 / 384, 1.0, 0.4, 2.5)]
    assert rates == ["1/380 of real time", "real time", "1/2.5 of real time", "2.5 times real time"]
    assert [significant(v, 3) for v in (-0.012345, 999.96, 3.2e8, 0.0, np.nan)] == [
        "−0.0123",
        "1000",
        "3.20e8",
        "0",
        "–",
    ]
    assert [fixed(v, 3) for v in (-0.0004, -1.2346)] == ["0.000", "−1.235"]


def test_frames_are_samples_of_the_history_with_both_sides_of_every_event(content, story):
    history, time = story.histories[0], content.arrays["time"]
    samples = np.flatnonzero(np.isin(history["time"].values, time))
    assert len(samples) == len(time)
    assert np.all(np.diff(time) > 0.0)
    for event in history.events:
        assert {event.time, np.nextafter(event.time, np.inf)} <= set(time)
    assert np.argmax(history["lambda_n"].values) in samples
    np.testing.assert_array_equal(content.arrays["state"], history["state"].values[samples])
    np.testing.assert_allclose(content.arrays["film"], story.time_map.film_at(time))
    rates = np.array(content.facts["rates"]["1"])[content.arrays["rate"]]
    touching = int(np.argmax(content.arrays["state"]))
    assert rates[[0, touching]].tolist() == ["1/10 of real time", "1/500 of real time"]


I_BEAM = (
    *("discretization.method=fem", "discretization.modes=3", "end_time=0.33", "beam.section.shape=i-beam"),
    *("beam.section.width=0.04", "beam.section.height=[[0, 0.08], [1, 0.03]]"),
    *("beam.section.flange_thickness=0.006", "beam.section.web_thickness=0.005"),
)


def test_every_result_has_its_colours_on_both_sides_and_its_scale(run):
    """Of a tapered i-beam, against the surface that the other pictures draw."""
    story = story_of([run("paper", *I_BEAM)], Style(deformation=1.0))
    content, geometry = content_of(story), story.geometries[0]
    k = int(np.argmax(np.abs(geometry.history.section_forces()["axial_force"].values).max(axis=1)))
    frame = int(np.argmin(np.abs(content.arrays["time"] - geometry.times[k])))
    k = geometry.index(content.arrays["time"][frame])
    for name in get_args(Colour):
        scale = colour_scale([geometry], name)
        values = geometry.result(name, k)[:-2].reshape(-1, SIDES)[: geometry.stations.size]
        assert np.abs(values).max() > 0.05 * scale.limit  # there is something to compare
        assert content.scales[name] == scale
        for side, around in (("upper", 0), ("lower", SIDES // 2)):
            shown = scale.limit * (content.arrays[f"{name}_{side}"][frame] / 127.5 - 1.0)
            np.testing.assert_allclose(shown, values[:, around], atol=0.005 * scale.limit)
    np.testing.assert_allclose(2.0 * np.array(content.facts["radius"])[[0, -1]], [0.08, 0.03])


def test_the_arrow_is_the_force_on_the_beam(content, story):
    """Out of the slope, leaned by friction; as long as the root of its size over the peak."""
    geometry = story.geometries[0]
    arrows = content.arrays["arrow"][:, 0]
    frame = int(np.argmax(np.hypot(*arrows.T)))
    force = geometry.contact_force(geometry.index(content.arrays["time"][frame]))[:2]
    size = np.linalg.norm(force)
    assert size == pytest.approx(geometry.peak_force)
    np.testing.assert_allclose(arrows[frame], force / size, rtol=1e-12)
    assert content.texts["force_text"][frame] == f"{size:.0f} N"
    assert not content.arrays["arrow"][content.arrays["state"] == State.FREE].any()


def test_charts_say_their_units_and_what_their_curves_are(content, run):
    assert [chart.title for chart in content.charts] == ["Contact force (N)", "Energy (J)"]
    energy = content_of(story_of([run("elastic-stop", "end_time=0.33")])).charts[1]
    assert [curve.label for curve in energy.curves] == ["kinetic", "elastic", "gravity", "stop", "total"]
    assert np.ptp(energy.curves[-1].values) < 0.02 * energy.curves[-1].values.max()  # the stop loses nothing
    stiff = "contact.normal=spring", "contact.stiffness=1e9", "solver.scheme=generalized-alpha"
    struck = run("tapered", "end_time=0.34", *stiff)
    tapered = content_of(story_of([struck])).charts[0]
    assert tapered.title == "Contact force (kN)"
    largest = tapered.curves[0].values.max()
    assert largest == pytest.approx(1e-3 * struck["lambda_n"].max())
    assert 0.5 * largest < float(tapered.values[-1][1]) < 1.1 * largest
    deflection = content_of(story_of([run("spin-up", "end_time=0.01")])).charts[0]
    assert (deflection.title, [label for _, label in deflection.times][-1]) == (
        "Deflection of the tip (µm)",
        "0.01",
    )


@pytest.mark.parametrize("changes", [("paper", "discretization.modes=6"), ("spin-up", "end_time=0.01")])
def test_a_page_has_no_number_that_is_not_finite(run, changes):
    """Of a run that blew up and of one without contact; JSON has no NaN."""
    content = content_of(story_of([run(*changes)]))
    json.loads(content.packed()[0], parse_constant=pytest.fail)
    for name in ("time", "film", "axis", "place", "offset", "arrow"):
        assert np.isfinite(content.arrays[name].astype("f4")).all(), name
    assert not any("nan" in chart.svg or "inf" in chart.svg for chart in content.charts)


LOADED = (
    "paper",
    "contact.enabled=false",
    "end_time=0.1",
    "masses=[{place=0.4,mass=0.4},{place=0.7,inertia=0.01},{mass=0.1}]",
    "forces=[{place=0.55,force=20,frequency=8},{force=-5,direction=1.5}]",
)


def test_masses_and_forces_on_the_beam_are_drawn_where_they_are(run):
    """Inner masses as discs, that at the tip as part of the beam; arrows as long as the roots of forces."""
    history = run(*LOADED)
    content = content_of(story_of([history]))
    assert [mass["place"] for mass in content.facts["masses"]] == [0.4, 0.7]
    sphere = (0.75 * 0.4 / (np.pi * 2766.7)) ** (1.0 / 3.0)
    assert content.facts["masses"][0]["radius"] == pytest.approx(sphere)
    assert content.facts["loaded"] == [0.55, 1.0]
    time, (pushed, dead) = content.arrays["time"], np.moveaxis(content.arrays["applied"], 1, 0)
    now = 20.0 * np.sin(2.0 * np.pi * 8.0 * time)
    np.testing.assert_allclose(np.linalg.norm(pushed, axis=1), np.sqrt(np.abs(now) / 20.0), atol=1e-9)
    samples, stations = np.searchsorted(history["time"].values, time), history["station"].values
    slopes = np.gradient(history["uy"].values[samples], stations, axis=1)
    turned = history["theta"].values[samples] + [np.interp(0.55, stations, slope) for slope in slopes]
    across = np.stack([-np.sin(turned), np.cos(turned)], axis=1)
    some = np.abs(now) > 1.0
    unit = pushed[some] / np.linalg.norm(pushed[some], axis=1)[:, None]
    np.testing.assert_allclose(unit, np.sign(now[some])[:, None] * across[some], atol=2e-3)
    np.testing.assert_allclose(dead, np.tile(-0.5 * np.array([np.cos(1.5), np.sin(1.5)]), (time.size, 1)))


# In a browser -------------------------------------------------------------------------------------------------


def test_it_shows_the_state_and_the_values_of_a_time(page, files, run):
    history = run("paper")
    show(page, files())
    for time in (0.0, 0.2, 0.3185, 0.3252, 0.5):
        seek(page, time)
        at = history.data.sel(time=now(page), method="nearest")
        assert now(page) == pytest.approx(time, abs=4e-3)
        assert text(page, "time") == f"{now(page):.6f} s"
        assert text(page, "state") == State(int(at["state"])).name
        gap, slip = numbers(page, "#numbers")
        assert gap == pytest.approx(1e3 * float(at["gap"]), abs=6e-4 if gap < 100 else 0.06)
        assert slip == pytest.approx(float(at["slip_rate"]), abs=6e-5)
        forces = [float(at["lambda_n"]), float(at["lambda_tau"])]
        assert numbers(page, "#force-legend") == pytest.approx(forces, rel=1e-3)
        energies = [float(at[f"energy_{name}"]) for name in ("kinetic", "elastic", "gravity")]
        assert numbers(page, "#energy-legend") == pytest.approx([*energies, sum(energies)], abs=6e-4)
        np.testing.assert_allclose(now(page, "axis"), history.beam_at(now(page)), atol=1e-6)


def test_it_plays_at_a_speed_and_pauses(page, files):
    show(page, files())
    before = page.locator("#scene").evaluate("c => c.toDataURL()")
    page.locator("#speed").select_option(label="1/2")
    page.locator("#play").click()
    page.wait_for_function("() => player.now().time > 0.02")
    page.locator("#play").click()
    settle(page)
    paused = now(page)
    settle(page)
    assert now(page) == paused < 0.3  # in flight a twentieth of real time
    assert text(page, "rate") == "shown at 1/20 of real time"
    assert page.locator("#scene").evaluate("c => c.toDataURL()") != before
    page.evaluate("player.goTo(player.run.time.length - 2); player.play()")
    page.wait_for_function("() => !player.now().playing")
    assert now(page) == 1.0


def test_keyboard_lists_and_charts_lead_to_times(page, files, run):
    events = run("paper").events
    show(page, files())
    times, film = (np.array(page.evaluate(f"[...player.run.{name}]")) for name in ("time", "film"))

    def press(key):
        page.keyboard.press(key)
        settle(page)
        return now(page)

    assert [press("ArrowRight"), press("ArrowRight"), press("ArrowLeft")] == [times[1], times[2], times[1]]
    assert [press("Shift+ArrowRight") for _ in range(3)] == [np.nextafter(e.time, np.inf) for e in events[:3]]
    assert page.locator("#events [aria-current=true]").text_content().startswith(f"{events[2].time:.6f}3 ")
    before = np.nextafter(events[1].time, np.inf)
    assert [press(key) for key in ("Shift+ArrowLeft", "End", "Home")] == [before, 1.0, 0.0]
    page.locator("#events button").nth(3).click()
    page.keyboard.press("ArrowDown")
    assert press("Enter") == np.nextafter(events[4].time, np.inf)
    box = page.locator("#force").bounding_box()
    for part in (0.3, 0.5, 0.7):  # as the film: its time is along the chart
        page.mouse.click(box["x"] + part * box["width"], box["y"] + 0.3 * box["height"])
        settle(page)
        assert np.interp(now(page), times, film) == pytest.approx(part * film[-1], abs=0.01 * film[-1])
    page.get_by_text("Contacts", exact=True).click()
    page.locator("#contacts button").nth(1).click()
    settle(page)
    assert now(page) == np.nextafter(run("paper").contacts[1].start, np.inf)


def test_zoom_factor_colour_and_theme_are_chosen(page, files):
    show(page, files())
    for _ in range(2):
        page.keyboard.press("+")
    page.locator("#factor").select_option("10")
    page.locator("#colour").select_option("shear")
    settle(page)
    assert text(page, "deformation") == "deflection drawn ×10 about the line from pin to contact point, zoom ×2.25"
    assert page.locator(".scale:visible").text_content().startswith("shear (N)")
    page.locator("#zoom-all").click()
    assert now(page, "zoom") == 1
    background = "getComputedStyle(document.body).backgroundColor"
    before = page.evaluate(background)
    page.locator("#theme").click()
    assert page.evaluate(background) != before


def test_a_band_lies_on_the_beam_and_places_of_contact_have_a_chart(page, files, run):
    page.set_viewport_size({"width": 1920, "height": 1000})
    show(page, files("slap"))

    def longest_orange() -> int:
        """Pixels of the longest row in the colour of slip: marks and arrows are narrow."""
        with Image.open(BytesIO(page.locator("#scene").screenshot())) as picture:
            pixels = np.asarray(picture.convert("RGB")).astype(int)
        rows = np.abs(pixels - (0xD9, 0x58, 0x0D)).max(axis=2) < 30
        ends = np.flatnonzero(np.diff(np.pad(rows, ((0, 0), (1, 1))).ravel().astype(int)))
        return int((ends[1::2] - ends[::2]).max(initial=0))

    seek(page, 0.375)  # the tip alone
    assert longest_orange() < 15
    seek(page, 0.3773)
    assert longest_orange() > 20
    assert not page.locator("#places").is_visible()
    page.get_by_text("Places", exact=True).click()
    assert page.locator("#places svg path").count() > 20
    assert page.locator("#places").is_visible()
    assert not page.locator("#force").is_visible()
    history = run("slap")
    at = history.data.sel(time=now(page), method="nearest")
    places = at["contact_place"].values[at["contact_state"].values != State.FREE]
    assert numbers(page, "#places-legend")[:2] == pytest.approx([places.min(), places.max()], abs=5e-4)


def test_events_and_contacts_are_listed_with_their_numbers(page, files, run):
    history = run("paper")
    show(page, files())
    rows = page.locator("#events li").all_text_contents()
    for number, (row, event) in enumerate(zip(rows, history.events, strict=True), start=1):
        time, found, kind, impulse = re.fullmatch(r"([\d.]{8})(\d+) (\w+) (?:(\S+) N s)?", row).groups()
        assert (float(time), int(found), kind) == (pytest.approx(event.time, abs=1e-6), number, event.kind.value)
        assert float(impulse or 0.0) == pytest.approx(event.normal_impulse, rel=6e-3)
    for row, contact in zip(page.locator("#contacts tbody tr").all_text_contents(), history.contacts, strict=True):
        start, _, _, impulse, _, loss = row.split()
        assert float(start) == pytest.approx(contact.start, abs=1e-6)
        assert [float(impulse), float(loss)] == pytest.approx(
            [contact.normal_impulse, contact.energy_loss], rel=1e-3
        )


def test_a_run_that_stopped_says_why_and_what_it_warns_of(page, files, run):
    show(page, files("paper", "light", "discretization.modes=6"))
    page.keyboard.press("End")
    settle(page)
    history = run("paper", "discretization.modes=6")
    assert now(page) == pytest.approx(history.summary["end_time"], abs=1e-6)
    header = page.locator("header").text_content()
    assert "The run stopped early." in header
    assert all(warning in header for warning in history.summary["warnings"])


def test_links_open_it_at_a_time_in_a_theme_and_colours(page, files):
    show(page, files("sticking"), "#t=0.62&theme=dark&colour=axial_force")
    assert (text(page, "state"), now(page)) == ("STICK", pytest.approx(0.62, abs=2e-3))
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"
    assert page.locator("#colour").input_value() == "axial_force"


def test_the_page_draws_masses_and_forces(page, files):
    """Each of them changes the picture, by about its own size."""
    show(page, files("paper", "light", *LOADED[1:]))
    pictures = []
    for removed in ("", "masses", "loaded"):
        if removed:
            page.evaluate(f"player.runs[0].facts.{removed} = []")
        seek(page, 0.02)
        seek(page, 0.03)
        pictures.append(np.array(Image.open(BytesIO(page.locator("#scene").screenshot())).convert("RGB")))
    for (before, after), least in zip(pairwise(pictures), (300, 150), strict=True):
        assert least < np.count_nonzero((before != after).any(axis=2)) < 20 * least


def test_two_runs_are_side_by_side_at_one_time_in_pictures_of_one_scale(page, run, tmp_path):
    """The second one goes on for longer than the first, with which the page ends."""
    runs = run("paper", "end_time=0.5"), run("paper", "contact.friction=frictionless")
    file = write_player(story_of(runs, names=["rough", "smooth"]), tmp_path / "a.html")
    show(page, file, "#t=0.327")
    states = page.locator(".scenes .state").all_text_contents()
    assert states == [State(int(one.data["state"].sel(time=now(page), method="nearest"))).name for one in runs]
    for name, variable in (("force", "lambda_n"), ("energy", "energy")):
        shown = numbers(page, f"#{name}-legend")[:2]
        kinds = (
            ["lambda_n"] if variable == "lambda_n" else [f"energy_{k}" for k in ("kinetic", "elastic", "gravity")]
        )
        for value, one in zip(shown, runs, strict=True):
            at = one.data.sel(time=now(page), method="pad")
            assert value == pytest.approx(sum(float(at[kind]) for kind in kinds), rel=1e-3, abs=1e-3)
    page.keyboard.press("End")
    settle(page)
    last = page.evaluate("player.runs.map(({ run }) => run.time.at(-1))")
    assert last == [0.5, pytest.approx(0.5, abs=2e-4)]
    bounds = page.evaluate("player.runs.map(({ facts }) => facts.factors['5'].bounds.join())")
    assert bounds[0] == bounds[1]


def test_what_is_seen_can_be_kept_and_linked(page, files, run):
    show(page, files("paper", "auto"), "#event=3")
    event = run("paper").events[2]
    assert now(page) == np.nextafter(event.time, np.inf)
    assert "just after the impact" in text(page, "rate")
    page.keyboard.press("ArrowLeft")
    settle(page)
    assert (now(page), "just before the impact" in text(page, "rate")) == (event.time, True)
    page.locator("#colour").select_option("shear")
    page.locator("#link").click()
    link = page.url
    page.goto("about:blank")
    page.goto(link)
    page.wait_for_function("() => window.player")
    settle(page)
    assert (now(page), page.locator("#colour").input_value()) == (event.time, "shear")
    for scheme in ("dark", "light"):  # as the reader's system changes
        page.emulate_media(color_scheme=scheme)
        settle(page)
        assert page.evaluate("document.documentElement.dataset.theme") == scheme


def test_embedded_it_plays_while_it_is_seen_and_says_what_it_magnifies(page, files, tmp_path):
    host = tmp_path / "host.html"
    frame = f'<iframe src="{files().as_uri()}#embed" style="width: 640px; height: 360px"></iframe>'
    host.write_text(f"<!DOCTYPE html>{frame}<div style='height: 3000px'></div>", encoding="utf-8")
    page.goto(host.as_uri())
    inner = page.frames[1]
    inner.wait_for_function("() => window.player && player.now().time > 0.02")
    assert "×5" in inner.locator("#deformation").text_content()
    assert "1 warning" in inner.locator("#deformation").text_content()
    assert not inner.locator("#charts").is_visible()
    page.evaluate("scrollTo(0, 2000)")
    inner.wait_for_function("() => !player.now().playing", polling=50)


def test_names_of_runs_are_no_markup(page, run, tmp_path):
    name = "</script><b>a & b</b>"
    file = write_player(story_of([run("paper", "end_time=0.01")], names=[name]), tmp_path / "a.html")
    show(page, file)
    assert page.locator("h1").text_content().startswith(name)

"""The page of a run as a file: its numbers against the history."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from oblique_impact.renders.command import render
from oblique_impact.renders.geometry import BETWEEN
from oblique_impact.renders.player import write_player
from oblique_impact.renders.player.document import FRAMES as STEPS
from oblique_impact.renders.player.packing import packed, rounded, unpacked
from oblique_impact.renders.player.payload import SERIES, payload
from oblique_impact.renders.player.selection import MAX_EVENTS
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style
from tests.renders import FAMILIES
from tests.renders.page_arrays import frame_axes, frame_stress

ROUNDING = 2.0**-24  # of float32, relative
HALF = 0.51 / 32766  # of a 16-bit code, over the largest one


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
    """To the rounding of float32 or of 16 bits; times are exact."""
    history, arrays, facts = shown
    k, geometry = arrays["frame_sample"], story_of([history]).geometries[0]
    np.testing.assert_array_equal(arrays["frame_time"], history["time"].values[k])
    np.testing.assert_array_equal(arrays["frame_state"], history["state"].values[k])
    for name, short in (
        ("moment", "moment"),
        ("shear", "shear"),
        ("axial_force", "axial"),
        ("ux", "ux"),
        ("uy", "uy"),
    ):
        largest = np.abs(history[name].values[k]).max()
        np.testing.assert_allclose(
            arrays[f"frame_{short}"], history[name].values[k], atol=HALF * largest, rtol=1e-6
        )
    stress = history["bending_stress"].values[k]
    np.testing.assert_allclose(frame_stress(arrays), stress, atol=4 * HALF * np.abs(stress).max())
    np.testing.assert_array_equal(arrays["place"], history["station"].values.astype("f4"))
    np.testing.assert_allclose(arrays["radius"], geometry.radii[:: BETWEEN + 1], rtol=2 * ROUNDING)
    state_at = dict(zip(history["time"].values, history["state"].values, strict=True))
    assert arrays["chart_state"].tolist() == [state_at[time] for time in arrays["chart_time"]]
    assert facts["factor"] == geometry.factor
    for name, short in SERIES.items():
        values = arrays[f"chart_{short}"]
        np.testing.assert_array_equal(values[arrays["frame_point"]], history[name].values[k].astype("f4"))
        known = set(zip(history["time"].values, history[name].values.astype("f4"), strict=True))
        assert set(zip(arrays["chart_time"], values, strict=True)) <= known
    x = geometry.scenario.root.hub_radius + history["station"].values + history["ux"].values[k]
    y, theta = history["uy"].values[k], history["theta"].values[k, None]
    c, s = np.cos(theta), np.sin(theta)
    near = 1.5 * HALF * np.abs(y).max() + 2 * ROUNDING * geometry.scenario.beam.length
    for found, expected in zip(frame_axes(arrays, facts), (x * c - y * s, x * s + y * c), strict=True):
        np.testing.assert_allclose(found, expected, atol=near)


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


def test_a_listed_event_has_its_number_in_the_run(run):
    """Of more events than the page lists too: from 1, as `render --event` counts."""
    history = run("paper", "end_time=0.35")
    many = [event for event in history.events for _ in range(500)]
    listed = content(replace(history, events=many), 20)[1]["events"]
    assert len(listed) < len(many)
    assert [one["time"] for one in listed] == [many[one["number"] - 1].time for one in listed]
    assert listed[-1]["number"] == len(many)


def test_what_is_called_the_gap_in_an_elastic_stop_is_its_compression(run):
    """Of few modes the flexibility that they leave out takes most of the variable `gap`."""
    changes = ("contact.normal=spring", "contact.friction=frictionless", "end_time=0.34")
    history = run("paper", *changes)
    arrays, _ = content(history)
    closed, force = arrays["chart_state"] > 0, arrays["chart_normal"].astype(float)
    np.testing.assert_allclose(force[closed], -1e6 * arrays["chart_gap"][closed], rtol=1e-6, atol=1e-4)
    geometry = story_of([history]).geometries[0]
    k = int(np.argmax(history["lambda_n"].values))
    assert float(history["lambda_n"][k]) == pytest.approx(-1e6 * geometry.gap(k), rel=1e-12)
    assert -float(history["gap"][k]) > 2.0 * float(history["depth"][k])
    flying = arrays["chart_state"] == 0
    known = set(history["gap"].values.astype("f4"))
    assert set(arrays["chart_gap"][flying]) <= known


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
    arrays, facts = content(history)
    geometry = story_of([history]).geometries[0]
    index, samples = np.arange(geometry.times.size), arrays["frame_sample"]
    true = geometry.stations_of(index)
    k = np.clip(np.searchsorted(samples, index, side="right") - 1, 0, samples.size - 2)
    t0, t1 = arrays["frame_time"][k], arrays["frame_time"][k + 1]
    u = ((geometry.times - t0) / np.where(t1 > t0, t1 - t0, 1.0))[:, None]

    def between(values):
        return (1 - u) * values[k] + u * values[k + 1]

    for n, values in enumerate(frame_axes(arrays, facts)):
        assert np.abs(between(values) - true[..., n]).max() < 5e-4  # m, half a pixel of the drawn beam
    stress = history["bending_stress"].values
    assert np.sqrt(np.mean((between(frame_stress(arrays)) - stress) ** 2)) < 0.15 * np.sqrt(np.mean(stress**2))


def test_a_spring_keeps_the_total_energy(run):
    """Without friction, damping and dissipation the sum with the energy of the stop is constant."""
    changes = ("contact.normal=spring", "contact.friction=frictionless", "discretization.frame=mean-axis")
    arrays, _ = content(run("paper", *changes))
    total = sum(arrays[f"chart_{part}"].astype(float) for part in ("kinetic", "elastic", "gravity", "stop"))
    assert arrays["chart_stop"].max() > 0.05
    np.testing.assert_allclose(total, total[0], rtol=1e-6)


def test_the_page_says_what_was_simulated(run, tmp_path):
    history = run("paper", "end_time=0.05", "contact.normal=spring", "contact.friction=frictionless")
    facts = content(history, 20)[1]
    assert facts["title"] == "Beam, A = 314 mm², I = 7850 mm⁴, length 1 m, 2 modes"
    assert facts["model"] == (
        "E = 69 GPa, ρ = 2767 kg/m³; on a pin, from 45°, gravity 9.8 m/s²; slope 18°, elastic stop of 10⁶ N/m, "
        "frictionless; 2 modes, tangent frame, first-order kinetics, event scheme"
    )
    page = render(history, tmp_path / "a.html", names=("run 7",)).file.read_text(encoding="utf-8")
    assert "<title>run 7: beam, A = 314 mm²" in page
    assert "<h1>run 7: beam" in page
    titled = render(history, tmp_path / "a.html", style=Style(title="A <b>")).file.read_text(encoding="utf-8")
    assert "<title>A &lt;b&gt;: beam" in titled


def test_a_run_that_blew_up_still_makes_a_page(run):
    history = run("paper")
    data = history.data.copy(deep=True)
    for name, value in (("bending_stress", 1e300), ("moment", 1e300), ("lambda_n", np.nan), ("shear", np.inf)):
        data[name].values[-1] = value
    data["uy"].values[-1] = 1e9
    data["moment"].values[-2] = 1e15
    blown = replace(history, data=data, summary=history.summary | {"outcome": "diverged", "message": "it is so"})
    arrays, facts = content(blown)
    sound = np.abs(history["bending_stress"].values).max()
    stress = facts["results"][0]
    assert stress["name"] == "bending_stress"
    assert 0.5 * sound < stress["limit"] < 2.0 * sound
    assert [text[0] for _, text in stress["ticks"]][::4] == ["≤", "≥"]
    assert facts["outcome"] == "it is so"
    untold = {name: value for name, value in blown.summary.items() if name != "message"}
    assert "not valid here" in content(replace(blown, summary=untold), 20)[1]["outcome"]
    assert np.isinf(arrays["frame_moment"][-1]).all()
    assert np.isinf(arrays["frame_uy"][-1]).all()
    assert np.isfinite(arrays["frame_uy"][:-1]).all()
    assert np.isnan(arrays["chart_normal"][-1])


def test_sixteen_bits_say_what_is_no_number_or_too_large():
    values = np.array([[-2.0, 1.0, 3e4], [np.nan, np.inf, -3e4]])
    entry = rounded(values, 10.0)
    assert (entry["type"], entry["scale"]) == ("i2", pytest.approx(2.0 / 32766))
    np.testing.assert_allclose(unpacked(entry), [[-2.0, 1.0, np.inf], [np.nan, np.inf, -np.inf]], rtol=1e-4)
    assert not unpacked(rounded(np.zeros(3), 1.0)).any()
    assert unpacked(packed(np.array([1e300]), "f4"))[0] == np.inf


def test_of_very_many_events_some_are_listed(run):
    history = run("paper")
    many = [event for event in history.events for _ in range(100)]
    arrays, facts = content(replace(history, events=many), 600)
    assert (len(facts["events"]), facts["all_events"]) == (MAX_EVENTS, len(many))
    assert arrays["frame_time"].size < 700


# The file -----------------------------------------------------------------------------------------------------


def test_the_page_holds_the_payload_and_needs_nothing_besides_itself(run, files):
    text = files().read_text(encoding="utf-8")
    arrays, facts = payload(story_of([run("paper")]), STEPS)
    for name, expected in (("arrays", arrays), ("facts", json.loads(json.dumps(facts)))):
        found = re.search(rf'<script type="application/json" id="{name}">(.*?)</script>', text, re.DOTALL)
        assert json.loads(found[1]) == expected
    assert 0.5e6 < len(text) < 1.0e6
    source = re.sub(r'(id="arrays">).*?(</script>)', r"\1\2", text, flags=re.DOTALL)
    outside = r"https?:|//\w|\bsrc\s*=|@import|url\(|<link|\bfetch\(|XMLHttp|import\("
    assert re.findall(outside, source) == []
    assert "default-src 'none'" in source


def test_words_of_a_history_are_only_words(run, tmp_path):
    history = run("paper", "end_time=0.05")
    made = {"provenance": {"version": '</script><script>alert("x")</script>', "numeric_source": "feed"}}
    theirs = replace(history, summary=history.summary | made)
    title = "</script><script>alert(1)</script>"
    story = story_of([theirs], Style(title=title))
    text = write_player(story, tmp_path / "words.html").read_text(encoding="utf-8")
    assert text.count("alert(") >= 2
    assert "<script>alert" not in text
    (facts,) = re.findall(r'id="facts">(.*?)</script>', text)
    assert json.loads(facts)["title"].startswith(title)


def test_the_same_history_gives_the_same_file(run, tmp_path):
    story = story_of([run("paper", "end_time=0.05")])
    first, second = (write_player(story, tmp_path / name).read_bytes() for name in ("a.html", "b.html"))
    assert first == second

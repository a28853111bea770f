"""What a title says of a run: its name, the beam and its sizes, how many coordinates; the title card of a film."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from PIL import ImageColor

from oblique_impact.contact.state import State
from oblique_impact.renders import render
from oblique_impact.renders.frame import Composer
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import DARK, LIGHT, Style
from oblique_impact.renders.timeline import make_timeline
from oblique_impact.renders.title import beam_words, name_of, parameters
from oblique_impact.renders.title_card import exaggerations, title_card
from oblique_impact.scenario.scenario import Scenario
from tests.renders.decoding import decode
from tests.renders.writing import texts, written

PAPER = "beam, A = 314 mm², I = 7850 mm⁴, length 1 m"
TUBE = ("beam.section.shape=tube", "beam.section.diameter=20 mm", "beam.section.thickness=1.5 mm")
I_BEAM = ("beam.section.shape=i-beam", "beam.section.flange_thickness=2 mm", "beam.section.web_thickness=2 mm")


@pytest.mark.parametrize(
    ("case", "said"),
    [
        (("paper",), f"{PAPER}, E = 69 GPa, ρ = 2767 kg/m³, 2 modes"),
        (
            ("paper", "beam.material=steel", "beam.length=250 mm", *TUBE, "contact.point=250 mm"),
            "steel tube Ø 20 × 1.5 mm, length 250 mm, E = 210 GPa, ρ = 7850 kg/m³, 2 modes",
        ),
        (
            ("paper", "beam.section.shape=rectangle", "beam.section.width=30 mm", "beam.section.height=8 mm"),
            "rectangular bar 30 × 8 mm, length 1 m, E = 69 GPa, ρ = 2767 kg/m³, 2 modes",
        ),
        (
            ("paper", *I_BEAM, "beam.section.width=20 mm", "beam.section.height=40 mm"),
            "I-beam 20 × 40 mm, length 1 m, E = 69 GPa, ρ = 2767 kg/m³, 2 modes",
        ),
        (("tapered",), "tapered beam, length 1 m, E = 69 GPa, ρ = 2767 kg/m³, tip mass 0.05 kg, 40 elements"),
        (("mid-span",), f"{PAPER}, E = 69 GPa, ρ = 2767 kg/m³, 40 elements, 4 modes"),
        (
            ("rigid-limit",),
            "beam, A = 1000 mm², I = 10⁶ mm⁴, length 300 mm, E = 69 GPa, ρ = 2767 kg/m³, 1 mode",
        ),
        (("spin-up",), "beam, A = 400 mm², I = 2 × 10⁵ mm⁴, length 10 m, E = 70 GPa, ρ = 3000 kg/m³, 8 modes"),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else "",
)
def test_a_beam_in_words(case, said):
    full, *shorter = beam_words(Scenario.builtin(case[0], case[1:]))
    assert full == said
    assert [len(text) for text in shorter] == sorted({len(text) for text in shorter}, reverse=True)
    assert all(text.endswith(full.rpartition(", ")[2]) for text in shorter)


def test_parameters_of_a_run():
    assert parameters(Scenario.builtin("paper")) == [
        PAPER,
        "E = 69 GPa, ρ = 2767 kg/m³",
        "on a pin, from 45°, gravity 9.8 m/s²",
        "slope 18°, rigid stop, restitution 0, hybrid friction, μ = 0.3",
        "2 modes, tangent frame, first-order kinetics, event scheme",
    ]
    stop = parameters(Scenario.builtin("elastic-stop"))
    assert stop[3:] == [
        "slope 18°, elastic stop of 10⁶ N/m, frictionless",
        "32 elements, mean-axis frame, first-order kinetics, generalized-alpha scheme",
    ]
    assert parameters(Scenario.builtin("spin-up"))[2:] == [
        "on a driven root, from 0°, gravity 0 m/s²",
        "8 modes, tangent frame, first-order kinetics, event scheme",
    ]


def test_restitution_and_friction_are_those_of_the_contact():
    contact = ["contact.restitution=0.25", "contact.mu_static=0.5", "contact.mu_kinetic=0.4"]
    words = "slope 18°, rigid stop, restitution 0.25, hybrid friction, μ = 0.4"
    assert parameters(Scenario.builtin("paper", contact))[3] == words


def test_the_name_of_a_built_in_scenario():
    assert name_of(Scenario.builtin("damped")) == "damped"
    assert name_of(Scenario.builtin("damped", ["end_time=0.5"])) == ""
    assert name_of(Scenario.builtin("damped", ["title=with glue"])) == "with glue"


def test_a_title_of_the_scenario_is_what_pictures_and_pages_call_the_run(run, tmp_path):
    history = run("paper", "title=a <second> try")
    assert story_of([history], Style(), ["folder"]).title == "a <second> try"
    assert story_of([history], Style(title="mine"), ["folder"]).title == "mine"
    assert history.plot().get_suptitle() == "a <second> try"
    page = render(history, tmp_path / "page.html").file.read_text(encoding="utf-8")
    assert "a &lt;second&gt; try" in page


@pytest.mark.parametrize("size", [(640, 360), (1280, 720)])
def test_a_frame_has_run_and_beam_at_its_top(run, monkeypatch, size):
    history = run("paper")
    for names, title, said in ((["a run"], None, "a run"), ((), None, "paper"), ((), "my title", "my title")):
        story = story_of([history], Style(size=size, title=title), names)
        found = written(monkeypatch, lambda story=story: Composer(story).close())
        assert found[0].text == said
        assert found[1].text in beam_words(story.geometries[0].scenario)
        assert max(item.box[3] for item in found) < 0.1 * size[1]


def test_two_beams_have_their_names_and_the_beam_that_they_share(run, monkeypatch):
    runs = [run("paper"), run("paper", "contact.friction=frictionless")]
    for layout in ("side-by-side", "overlay"):
        composer = []

        def draw(layout=layout, composer=composer):
            composer.append(Composer(story_of(runs, Style(size=(960, 540), layout=layout), ["one", "other"])))
            composer[0].draw(0.3)

        said = texts(monkeypatch, draw)
        composer[0].close()
        assert beam_words(Scenario.builtin("paper"))[0] in said
        assert {"one", "other"} <= set(said)
    several = story_of([runs[0], run("sticking")], names=["one", "other"])
    assert several.beam == []  # another number of modes


def test_name_and_state_beside_each_other_are_those_of_the_run_below(run, monkeypatch):
    """At times when one beam touches and the other one does not."""
    runs = [run("paper"), run("paper", "contact.friction=frictionless")]
    composer = Composer(story_of(runs, Style(size=(960, 540)), ["one", "other"]))
    states = [history.data["state"].interp(time=runs[0]["time"], method="zero").values for history in runs]
    apart = runs[0]["time"].values[np.flatnonzero((states[0] != states[1]) & (states[0] + states[1] > 0.0))]
    for time in apart[[len(apart) // 3, len(apart) // 2]]:
        found = {item.text: item.place for item in written(monkeypatch, lambda time=time: composer.draw(time))}
        names = [State(int(history.at(time)["state"])).name for history in runs]
        assert names[0] != names[1]
        for name, left in ((names[0], True), (names[1], False), ("one", True), ("other", False)):
            assert (found[name][0] < 480) == left, name
    composer.close()


def test_names_over_each_other_have_the_colours_of_their_beams(run, monkeypatch):
    """A beam has the colour of its series; so has what stands before its name."""
    runs = [run("paper"), run("paper", "contact.friction=frictionless"), run("sticking")]
    composer, pictures = (
        Composer(story_of(runs, Style(size=(1280, 720), layout="overlay"), ["a1", "b2", "c3"])),
        [],
    )
    found = written(monkeypatch, lambda: pictures.append(np.asarray(composer.draw(0.3)).astype(int)))
    ((view, _, _),) = (one for one in composer._views if one[2] == 0)
    for n, (name, beam) in enumerate(zip(("a1", "b2", "c3"), view._beams, strict=True)):
        assert beam.geometry.history is runs[n]
        assert beam._moving[0].prop.color.hex_rgb == LIGHT.series[n]
        left, top, _, bottom = next(map(round, item.box) for item in found if item.text == name)
        before = pictures[0][top:bottom, left - (bottom - top) : left]
        seen = [(np.abs(before - ImageColor.getrgb(colour)).max(axis=2) < 8).sum() for colour in LIGHT.series]
        assert np.argmax(seen) == n
        assert seen[n] > 10
    composer.close()


def test_the_card_tells_what_is_exaggerated_and_where_runs_differ(run, monkeypatch):
    runs = [run("paper"), run("paper", "contact.friction=frictionless")]
    story = story_of(runs, Style(size=(1280, 720), title="A title"), ["rough", "smooth"], 0.1, 0.002)
    timeline = make_timeline(story.time_map, card=2.0)
    items = written(monkeypatch, lambda: title_card(story, timeline))
    said = [item.text for item in items]
    for item, below in pairwise(items):
        assert item.box[0] == below.box[0]
        assert 0 < item.box[3] <= below.box[1] < 720
    assert said[:2] == ["A title", "rough and smooth"]
    assert "smooth: slope 18°, rigid stop, restitution 0, frictionless" in said
    assert "rough: slope 18°, rigid stop, restitution 0, hybrid friction, μ = 0.3" in said
    assert f"deflection drawn ×{story.factor:g} about the line from pin to contact point" in said
    assert "time runs at 1/10 of real time in flight, at 1/500 of real time in contact" in said
    true = story_of(runs[:1], Style(deformation=1.0))
    assert exaggerations(true, timeline)[0] == "deflection drawn as it is"
    for size in ((320, 180), (640, 360), (1080, 1080), (720, 1280)):
        small = replace(story, style=Style(size=size, theme="dark"))
        picture = np.asarray(title_card(small, timeline))
        assert picture.shape == (size[1], size[0], 3)
        ground = [int(DARK.background[k : k + 2], 16) for k in (1, 3, 5)]
        assert np.all(picture[:, -4:] == ground)  # nothing is cut off


def test_a_film_begins_with_its_card(run, tmp_path):
    """Frames of the card alike, before the first frame of the run; they count in its length."""
    style = Style(size=(320, 180), charts=False)
    told = []
    film = render(
        run("paper"), tmp_path / "a.mp4", style, frames=4, fps=10, title_card=0.5, on_progress=told.append
    )
    assert (film.timeline.card, film.timeline.duration) == (5, pytest.approx(0.9))
    assert (told[-1].done, told[-1].total) == (9, 9)
    frames = decode(tmp_path / "a.mp4")[1].astype(int)
    assert frames.shape == (9, 180, 320, 3)
    apart = [np.abs(a - b).mean() for a, b in pairwise(frames)]
    assert max(apart[:4]) < 0.5
    assert apart[4] > 2.0

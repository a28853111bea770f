"""What the pictures of a run share: one scale of colours, one magnification, one time map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from oblique_impact.renders import render
from oblique_impact.renders.charts import energy_curves, force_curves
from oblique_impact.renders.difference import magnify_difference
from oblique_impact.renders.frame import Composer
from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.player.content import content_of
from oblique_impact.renders.story import ColourScale, colour_scale, peaks_of, round_up, story_of
from oblique_impact.renders.style import Style
from oblique_impact.renders.timeline import SECONDS
from tests.renders.writing import texts, written

QUANTITIES = ("bending_stress", "axial_stress", "bending_moment", "shear_force", "axial_force", "section_rotation")
TAPERED = ("tapered", "end_time=0.34")


@pytest.fixture(params=[("paper",), TAPERED, ("mid-span",)], ids=lambda names: names[0])
def history(run, request):
    return run(*request.param)


def test_a_magnified_difference_is_told_where_it_is_drawn_and_nowhere_else(run, monkeypatch):
    """Curves of charts are not magnified; a contact point whose beam is moved away is not at true scale."""
    runs = [run("paper"), run("paper", "discretization.method=fem")]
    style = Style((640, 360), layout="overlay")
    names, inset = {}, {}
    for factor in (1.0, 1e6):
        histories = [runs[0], runs[1] if factor == 1.0 else magnify_difference(*runs, factor)]
        story = story_of(histories, style, ["modal", "fem"], difference=factor)
        names[factor] = [curve.label for curve in (*force_curves(story), *energy_curves(story))]
        composer = Composer(story)
        inset[factor] = texts(monkeypatch, lambda composer=composer: composer.draw(0.3))
        composer.close()
    assert names[1e6] == names[1.0]
    assert any("true scale" in text for text in inset[1.0])
    assert not any("true scale" in text for text in inset[1e6])
    assert any("10⁶" in text for text in inset[1e6])


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_the_peaks_are_those_of_the_drawn_surface(history, quantity):
    """At any sample no point of the surface carries more, and one carries as much."""
    geometry = BeamGeometry(history)
    peaks = peaks_of(geometry, quantity)
    for k in np.linspace(0, peaks.size - 1, 25).astype(int):
        drawn = np.nanmax(np.abs(geometry.surface(k).arrays[quantity]))
        assert peaks[k] == pytest.approx(drawn, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_the_scale_covers_all_samples(history, quantity):
    geometry = BeamGeometry(history)
    scale = colour_scale([geometry], quantity)
    largest = peaks_of(geometry, quantity).max()
    assert largest <= scale.limit <= 1.35 * largest
    assert not scale.exceeded


def test_the_stress_of_the_scale_is_that_of_the_bending_moment(history):
    """M e / I with the section at each station: a circle of the local area where no outer fibre is given."""
    beam = BeamGeometry(history).scenario.beam
    x = history["station"].values

    def at(table):
        return np.interp(x, *np.array(table).T) if isinstance(table, list | tuple) else np.full(x.shape, table)

    fibre = beam.outer_fibre or np.sqrt(at(beam.area) / np.pi)
    stress = np.abs(history["moment"].values) * fibre / at(beam.second_moment)
    np.testing.assert_allclose(np.abs(history["bending_stress"].values), stress, rtol=1e-9, atol=1e-3)
    limit = story_of([history]).colours.limit
    assert 0.7 * limit < stress.max() <= limit


def test_still_film_part_of_a_film_strip_and_page_have_one_scale_and_one_factor(run, tmp_path, monkeypatch):
    """Read from what is written into the pictures, and from what the page embeds."""
    history = run("paper")
    page = story_of([history])
    facts = content_of(page, 200).facts
    shown = facts["results"][facts["shown"]]
    ends = [text for _, text in shown["ticks"]]
    factor = f"×{page.factor:g}"
    style = Style(size=(640, 360))
    kinds = {
        "still": lambda: render(history, tmp_path / "a.png", style),
        "other still": lambda: render(history, tmp_path / "a.png", style, times=[0.1]),
        "film": lambda: render(history, tmp_path / "a.gif", style, frames=2),
        "part": lambda: render(history, tmp_path / "a.gif", style, frames=2, between=(0.0, 0.1)),
        "strip": lambda: render(history, tmp_path / "a.png", strip=True, times=[0.1, 0.3]),
    }
    for kind, draw in kinds.items():
        written = texts(monkeypatch, draw, charts=False)
        assert [w for w in written if w in ends][: len(ends)] == ends, kind
        assert any(factor in w for w in written), kind
        assert shown["title"] in written or shown["title"].split(",")[0] in written, kind


def test_a_film_of_the_usual_length_runs_as_the_page_stretched_evenly(run):
    page, film = (story_of([run("paper")], seconds=seconds).time_map for seconds in (None, SECONDS))
    assert film.duration == pytest.approx(SECONDS)
    times = np.linspace(0.0, 1.0, 501)
    np.testing.assert_allclose(film.film_at(times) / SECONDS, page.film_at(times) / page.duration, atol=1e-9)


def test_two_histories_have_one_scale_and_one_factor(run, monkeypatch):
    """The larger stress of both, the smaller magnification of both, written into both halves."""
    soft, hard = run("paper"), run("sticking")
    alone = [story_of([history]) for history in (soft, hard)]
    both = story_of([soft, hard], Style(size=(960, 540)), ["a", "b"])
    assert both.colours.limit == max(s.colours.limit for s in alone)
    assert [g.factor for g in both.geometries] == [min(s.factor for s in alone)] * 2
    composer = Composer(both)
    written = texts(monkeypatch, lambda: composer.draw(0.1), charts=False)
    composer.close()
    ticks = [text for _, text in both.colours.ticks]
    assert [w for w in written if w in ticks] == 2 * ticks
    assert sum(f"×{both.factor:g}" in w for w in written) == 2


def test_a_run_that_blew_up_is_exceeded_and_says_so(run):
    history = run("paper")
    data = history.data.copy(deep=True)
    data["moment"].values[-1] = 1e300
    data["moment"].values[-2] = 1e25
    blown = BeamGeometry(replace(history, data=data, summary=history.summary | {"outcome": "diverged"}))
    scale = colour_scale([blown], "bending_stress")
    sound = colour_scale([BeamGeometry(history)], "bending_stress")
    assert 0.5 * sound.limit < scale.limit <= sound.limit
    assert scale.exceeded
    assert [text[0] for _, text in scale.ticks] == ["≤", "−", "0", *scale.ticks[3][1][0], "≥"]


@pytest.mark.parametrize(
    ("limit", "title", "labels"),
    [
        (1e8, "bending stress (MPa), tension positive", ["−100", "−50", "0", "50", "100"]),
        (2.5e6, "bending stress (MPa), tension positive", ["−2.50", "−1.25", "0", "1.25", "2.50"]),
        (1.5e10, "bending stress (GPa), tension positive", ["−15.0", "−7.5", "0", "7.5", "15.0"]),
        (5e3, "bending stress (kPa), tension positive", ["−5.0", "−2.5", "0", "2.5", "5.0"]),
        (4.0, "bending stress (Pa), tension positive", ["−4", "−2", "0", "2", "4"]),
    ],
)
def test_labels_of_the_scale_are_their_numbers(limit, title, labels):
    scale = ColourScale("bending_stress", limit, False)
    assert (scale.title, [text for _, text in scale.ticks]) == (title, labels)
    assert ColourScale("shear_force", 1.2, False).title == "shear force (N)"


def test_the_ends_of_a_scale_are_round_and_not_below():
    for value in np.geomspace(1e-7, 1e9, 400):
        assert value * (1.0 - 1e-9) <= round_up(value) <= 1.34 * value
    assert [round_up(v) for v in (0.0, 1.0, 86.0, 100.0, 100.1)] == [1.0, 1.0, 100.0, 100.0, 120.0]


def test_the_colour_at_the_end_of_the_bar_is_that_of_the_limit(run, monkeypatch):
    """What a reader takes from bar and beam: the pixel under a label has the colour of that value."""
    import matplotlib as mpl

    story = story_of([run("paper")], Style(inset=False))
    composer, pictures = Composer(story), []
    places = {item.text: item.place for item in written(monkeypatch, lambda: pictures.append(composer.draw(0.1)))}
    composer.close()
    picture: Image.Image = pictures[0]
    for part, text in story.colours.ticks:
        x, y = places[text]
        found = np.array(picture.getpixel((round(x - 2 * part), round(y - 10))))
        wanted = 255 * np.array(mpl.colormaps["RdBu_r"](0.5 * (part + 1.0))[:3])
        np.testing.assert_allclose(found, wanted, atol=12)


def test_the_beams_are_coloured_by_the_scale_that_the_bar_shows(run):
    """In every view, inset and side by side alike."""
    for histories in ([run("paper")], [run("paper"), run("sticking")]):
        story = story_of(histories, Style(size=(960, 540)), ["a", "b"])
        composer = Composer(story)
        views = [view for view, _, _ in composer._views]
        assert len(views) == 2
        for view in views:
            limits = [
                actor.mapper.scalar_range
                for actor in view.plotter.actors.values()
                if actor.mapper.scalar_visibility and actor.mapper.color_mode == "map"
            ]
            assert limits == [(-story.colours.limit, story.colours.limit)]
        composer.close()

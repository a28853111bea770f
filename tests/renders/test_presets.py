"""Presets: what they set, and that what is given holds instead of it."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from oblique_impact import InputError
from oblique_impact.renders import Style, render
from oblique_impact.renders import command as rendering
from oblique_impact.renders.letters import LEAST, Letters
from oblique_impact.renders.presets import BARE, PRESETS
from oblique_impact.renders.style import LIGHT, SLIDE


@pytest.fixture
def asked(monkeypatch):
    """Stories and timelines of films that are asked for, none of which is drawn."""
    found = []
    monkeypatch.setattr(rendering, "write_film", lambda story, timeline, *_: found.append((story, timeline)))
    return found


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_is_what_its_table_says(run, tmp_path, asked, name):
    render(run("paper"), tmp_path / "a.mp4", Style.of(name))
    (story, timeline), preset = asked[0], PRESETS[name]
    for field, value in preset.look.items():
        assert getattr(story.style, field) == value
    assert timeline.fps == preset.film["fps"]
    assert timeline.card == round(preset.film.get("title_card", 0.0) * timeline.fps)
    seconds = preset.film.get("seconds", 20.0)
    assert timeline.times.size / timeline.fps == pytest.approx(seconds, abs=0.1)


def test_a_film_for_a_phone_is_short_and_its_smallest_letters_are_large(run, tmp_path, asked):
    """Eight seconds with the title card; on a screen 65 mm wide the letters are above 1 mm."""
    render(run("paper"), tmp_path / "a.mp4", Style.of("social"))
    story, timeline = asked[0]
    assert timeline.duration == pytest.approx(8.0, abs=0.1)
    assert Letters.of(story.style).size(9.0) / story.style.size[0] * 65.0 > 1.0


def test_a_bare_picture_has_no_letters_and_no_force(run, tmp_path):
    """Letters of any size give the same picture; the force of the contact, 104 N here, is not drawn."""
    files = [
        render(
            run("paper"),
            tmp_path / f"{points}.png",
            Style(**BARE, size=(480, 270), letters=points),
            times=[0.3245],
        )
        for points in (10.0, 20.0)
    ]
    small, large = (np.asarray(Image.open(found.file)) for found in files)
    np.testing.assert_array_equal(small, large)
    arrow = np.array([int(LIGHT.arrow[k : k + 2], 16) for k in (1, 3, 5)])
    assert np.abs(small[..., :3].astype(int) - arrow).max(axis=-1).min() > 30


def test_what_is_given_holds_instead_even_if_it_is_the_default(run, tmp_path, asked, cli):
    folder = run("paper").save(tmp_path / "run")
    typed = ("--size", "1280x720", "--letters", "10", "--fps", "25", "--title-card", "0", "--theme", "dark")
    code, _, err = cli("render", folder, "--out", tmp_path / "a.mp4", "--preset", "talk", *typed)
    assert (code, err) == (0, "")
    story, timeline = asked[0]
    assert (story.style.size, story.style.letters, story.style.theme) == ((1280, 720), 10.0, "dark")
    assert (timeline.fps, timeline.card) == (25, 0)
    style = Style.of("social", size=(1280, 720), letters=10.0)
    render(run("paper"), tmp_path / "a.mp4", style, seconds=20.0, title_card=1.0)
    story, timeline = asked[1]
    assert (story.style.size, story.style.letters, timeline.card) == ((1280, 720), 10.0, 30)
    assert timeline.times.size / timeline.fps > 12.0


def test_a_still_and_a_strip_of_a_preset_take_what_applies_to_them(run, tmp_path):
    """Neither frames per second nor a title card; a strip is as wide as the picture, its rows are not as high."""
    still = render(run("paper"), tmp_path / "a.png", Style.of("paper"), times=[0.1])
    assert still.size == (2126, 1196)
    with Image.open(still.file) as picture:
        assert picture.size == (2126, 1196)
        assert 25.4 * picture.width / picture.info["dpi"][0] == pytest.approx(180.0, abs=0.1)
    strip = render(run("paper"), tmp_path / "b.png", Style.of("talk"), strip=True, times=[0.1])
    assert strip.size == (1920, 480)


@pytest.mark.parametrize("size", [(640, 360), (1280, 720), (1920, 1080), (3840, 2160)])
@pytest.mark.parametrize("points", [10.0, 14.0])
def test_letters_are_the_same_part_of_a_picture_at_every_size(size, points):
    """Where it fills a slide of 7.5 inches, text has its points; in a small picture it stays readable."""
    letters = Letters.of(Style(size=size, letters=points))
    pixels = points / 72.0 / 7.5 * size[1]
    assert letters.size(10.0) == max(LEAST, round(pixels))
    assert Style(size=size).resolution == pytest.approx(size[0] / SLIDE[0])


@pytest.mark.parametrize("size", [(1080, 1080), (720, 1280), (1600, 480)])
def test_a_picture_of_another_shape_covers_a_slide(size):
    """As wide as the slide and higher, or as high and wider."""
    inches = [pixels / Style(size=size).resolution for pixels in size]
    over = [found / wanted for found, wanted in zip(inches, (40.0 / 3.0, 7.5), strict=True)]
    assert min(over) == pytest.approx(1.0)


def test_letters_have_their_points_at_a_resolution():
    style = Style(size=(2000, 1000), dpi=254.0, letters=8.0)
    assert Letters.of(style).size(10.0) == round(8.0 / 72.0 * 254.0)


def test_an_unknown_preset_is_one_line():
    with pytest.raises(InputError, match="--preset cinema: should be one of talk, paper, social"):
        Style.of("cinema")

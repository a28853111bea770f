"""Scale bars: as long as they say under every camera, of a round length, drawn where they are said to be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oblique_impact.renders.frame import Composer, bar_mask
from oblique_impact.renders.scale_bar import ScaleBar, scale_bar
from oblique_impact.renders.scene import View
from oblique_impact.renders.story import story_of
from tests.renders.writing import texts

LENGTHS = {"m": 1.0, "mm": 1e-3, "µm": 1e-6}


@pytest.fixture(scope="module")
def story(run):
    return story_of([run("paper")])


def said(text):
    number, unit = text.split()
    return float(number) * LENGTHS[unit]


@pytest.mark.parametrize("camera", ["oblique", "front", "above"])
@pytest.mark.parametrize("close", [False, True])
def test_a_bar_is_as_long_as_a_level_piece_of_the_beam_that_it_names(story, camera, close):
    """Points of the plane of motion so far apart, projected by VTK's own camera, are as far apart as its ends."""
    view = View(story, [0], (640, 400), style=replace(story.style, camera=camera), close=close)
    view.draw(0.1)
    bar = view.scale_bar(150.0)
    camera_of_vtk = view.plotter.camera.GetCompositeProjectionTransformMatrix(640.0 / 400.0, -1.0, 1.0)
    matrix = np.array([[camera_of_vtk.GetElement(i, j) for j in range(4)] for i in range(4)])
    ends = np.array([[0.2, 0.1, 0.0, 1.0], [0.2 + said(bar.text), 0.1, 0.0, 1.0]]) @ matrix.T
    across = np.diff(ends[:, :2] / ends[:, 3:], axis=0)[0] * (320.0, -200.0)
    view.close()
    np.testing.assert_allclose(bar.across, across, atol=0.05)
    assert 60.0 < np.linalg.norm(bar.across) <= 150.0


def test_lengths_are_round_and_have_their_unit():
    for metre in np.geomspace(1e-2, 1e7, 40):
        bar = scale_bar(np.array([metre, -0.1 * metre]), 120.0)
        assert said(bar.text) == pytest.approx(bar.length, rel=1e-12)
        mantissa = bar.length / 10.0 ** np.floor(np.log10(bar.length) + 1e-9)
        assert round(mantissa, 9) in (1.0, 2.0, 5.0)
        size = np.linalg.norm(bar.across)
        assert 0.4 * 120.0 <= size <= 120.0 * (1.0 + 1e-9)
        assert size == pytest.approx(bar.length * metre * np.hypot(1.0, 0.1))
    names = [(2.0, "2 m"), (0.1, "0.1 m"), (0.05, "50 mm"), (1e-3, "1 mm"), (2e-4, "200 µm")]
    assert [ScaleBar(length, np.zeros(2)).text for length, _ in names] == [text for _, text in names]


def test_what_is_drawn_is_as_long_as_the_bar():
    for across in ((100.0, 0.0), (87.0, 9.0), (60.0, -6.0)):
        mask = np.asarray(bar_mask(across, 4.0, 2)) > 100
        columns = np.flatnonzero(mask.any(axis=0))
        assert columns[-1] - columns[0] == pytest.approx(across[0] + 2.0, abs=1.6)  # with the width of the ticks
        left, right = (np.flatnonzero(mask[:, k]).mean() for k in (columns[0] + 1, columns[-1] - 1))
        assert right - left == pytest.approx(across[1], abs=1.0)


def test_a_frame_has_bars_as_long_as_they_say(story):
    """What a frame has more than one without scale bars: a bar each, and its words, which are shorter."""
    pictures = []
    for shown in (True, False):
        composer = Composer(replace(story, style=replace(story.style, scale_bar=shown)))
        pictures.append(np.asarray(composer.draw(0.1)).astype(int))
        places = [(view.scale_bar(0.22 * box[2]), box) for view, box, _ in composer._views]
        composer.close()
    more = np.abs(pictures[0] - pictures[1]).max(axis=2) > 60
    for bar, (left, top, wide, high) in places:
        part = more[top : top + high, left : left + wide]
        columns = np.flatnonzero(part.any(axis=0))
        assert bar.across[0] > 45.0
        assert columns[-1] - columns[0] == pytest.approx(bar.across[0], abs=4.0)


def test_views_and_inset_have_a_bar_of_their_own(story, monkeypatch):
    composer = Composer(story)
    bars = [view.scale_bar(0.22 * box[2]).text for view, box, _ in composer._views]
    written = texts(monkeypatch, lambda: composer.draw(0.1))
    composer.close()
    assert len(set(bars)) == 2
    assert set(bars) <= set(written)
    without = Composer(replace(story, style=replace(story.style, scale_bar=False)))
    assert not set(bars) & set(texts(monkeypatch, lambda: without.draw(0.1)))
    without.close()

"""Black on white: understood without colour; charts as vector graphics with their text and their origin."""

from __future__ import annotations

import re
import zlib
from itertools import combinations

import matplotlib as mpl
import numpy as np
import pytest
from PIL import ImageColor

from oblique_impact.history.provenance import described, provenance
from oblique_impact.renders import Style, render
from oblique_impact.renders.charts import energy_curves, force_curves
from oblique_impact.renders.frame import Composer
from oblique_impact.renders.overview import overview
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import PRINT


@pytest.fixture(scope="module")
def runs(run):
    return [run("paper", "end_time=0.4"), run("paper", "end_time=0.4", "contact.friction=frictionless")]


def luminance(colour):
    """Relative luminance as ITU-R BT.709 weighs red, green and blue."""
    return float(np.dot([0.2126, 0.7152, 0.0722], np.array(ImageColor.getrgb(colour)) / 255.0))


def test_curves_of_a_chart_are_told_apart_without_colour(runs):
    style = Style(theme="print")
    for story in (story_of(runs[:1], style), story_of(runs, style, names=["a", "b"])):
        for curves in (force_curves(story), energy_curves(story)):
            for one, other in combinations(curves, 2):
                assert one.dash != other.dash, (one.label, other.label)
            assert all(luminance(curve.colour) < 0.6 for curve in curves)


def test_the_panels_of_the_overview_need_no_colour(runs):
    figure = overview({"a": runs[0], "b": runs[1]}, PRINT)
    for axes in figure.axes:
        named = [line for line in axes.lines if not str(line.get_label()).startswith("_")]
        looks = [(line.get_linestyle(), line._dash_pattern, line.get_marker()) for line in named]
        assert len({str(look) for look in looks}) == len(looks), axes.get_title(loc="left")
    bars = [axes for axes in figure.axes if axes.containers]
    for axes in bars:
        shades = [luminance(mpl.colors.to_hex(bars[0].get_facecolor())) for bars in axes.containers]
        assert max(shades) - min(shades) > 0.2


def test_no_colour_but_that_of_the_colour_map(runs):
    for name in ("background", "ink", "dim", "line", "ghost", "slope", "slope_edge", "pin", "trace", "arrow"):
        assert len(set(ImageColor.getrgb(getattr(PRINT, name)))) == 1, name
    assert (PRINT.background, PRINT.ink) == ("#ffffff", "#000000")


def test_the_colour_map_can_be_read_in_grey(runs):
    """Lighter and lighter from the lowest value to the highest: the sign of a stress is seen in a copy in grey."""
    ramp = mpl.colormaps[PRINT.colour_map](np.linspace(0.0, 1.0, 64))[:, :3] @ [0.2126, 0.7152, 0.0722]
    assert np.all(np.diff(ramp) > 0.0)
    assert ramp[-1] - ramp[0] > 0.6


def test_the_bar_shows_the_colours_of_its_theme(runs):
    composer = Composer(story_of(runs[:1], Style(theme="print", inset=False)))
    picture = np.asarray(composer.draw(0.1)).astype(int)
    composer.close()
    high = 255.0 * np.array(mpl.colormaps["cividis"](0.999)[:3])
    assert (np.abs(picture - high).max(axis=2) < 10).sum() > 8


def svg_of(runs, tmp_path, **options):
    file = render(runs, tmp_path / "a.svg", options.pop("style", Style(theme="print")), **options).file
    return file.read_text(encoding="utf-8")


def test_charts_as_svg_have_text_title_and_origin(runs, tmp_path):
    text = svg_of(runs[:1], tmp_path, names=["my run"])
    words = re.findall(r"<text[^>]*>([^<]*)</text>", text)
    assert "my run: beam, A = 314 mm², I = 7850 mm⁴, length 1 m, 2 modes" in words
    assert {"normal force (N)", "energy (J)", "First collision: contact force", "gravity"} <= set(words)
    assert described(provenance()) in text
    assert "a title" in svg_of(runs, tmp_path, style=Style(title="a title"))
    dark = svg_of(runs[:1], tmp_path, style=Style(theme="dark"))
    assert "#12171d" in dark
    assert "#12171d" not in text


def test_charts_as_pdf_have_text_and_origin(runs, tmp_path):
    """Fonts are embedded as TrueType, so that text is text and no outlines (Type 3 would be)."""
    content = render(runs[0], tmp_path / "a.pdf", Style.of("paper")).file.read_bytes()
    assert content.startswith(b"%PDF-")
    assert b"/FontFile2" in content
    assert b"/Type3" not in content
    assert described(provenance()).split()[0].encode() in content
    pages = [zlib.decompress(part) for part in re.findall(rb"stream\r?\n(x.*?)\r?\nendstream", content, re.S)]
    assert any(b"Tj" in page or b"TJ" in page for page in pages)

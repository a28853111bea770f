"""Every kind of picture says in its metadata what made it, and what its run warns of."""

import html
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import imageio_ffmpeg
import pytest
from PIL import Image

from oblique_impact import Scenario
from oblique_impact.history.provenance import described, provenance
from oblique_impact.renders import Style, render
from oblique_impact.renders.campbell import campbell_diagram
from oblique_impact.renders.metadata import made_by
from oblique_impact.renders.overview import overview_figure

MADE = described(provenance())
SMALL = Style(size=(320, 180), deformation=1.0, charts=False, inset=False, ghosts=False, trace=False)


@pytest.fixture(scope="module")
def history(run):
    return run("paper", "end_time=0.05")


@pytest.fixture(scope="module")
def warned(run):
    history = run("paper", "end_time=0.33")
    assert history.summary["warnings"]
    return history


def comment(file: Path) -> str:
    """Read the metadata as a person's tools do: Pillow for pictures, ffmpeg for films."""
    if file.suffix == ".mp4":
        words = [imageio_ffmpeg.get_ffmpeg_exe(), "-i", str(file), "-f", "ffmetadata", "-"]
        lines = subprocess.run(words, capture_output=True, text=True, check=True).stdout.splitlines()
        (found,) = [line.removeprefix("comment=") for line in lines if line.startswith("comment=")]
        return re.sub(r"\\(.)", r"\1", found)
    with Image.open(file) as picture:
        if file.suffix == ".webp":
            return html.unescape(picture.info["xmp"].decode().partition('description="')[2].partition('"')[0])
        if file.suffix == ".gif":
            return picture.info["comment"].decode()
        return picture.info["Comment"]


def subject(file: Path) -> str:
    """Subject of a PDF: a string whose parentheses and backslashes have one before them (ISO 32000-1, 7.3.4.2)."""
    (found,) = re.findall(rb"/Subject \(((?:\\.|[^\\)])*)\)", file.read_bytes(), re.DOTALL)
    text = re.sub(rb"\\(.)", rb"\1", found, flags=re.DOTALL)
    return text.decode("utf-16" if text.startswith(b"\xfe\xff") else "latin-1")


@pytest.mark.parametrize("suffix", ["mp4", "gif", "webp"])
def test_films(history, tmp_path, suffix):
    file = render(history, tmp_path / f"film.{suffix}", SMALL, frames=3).file
    assert comment(file) == MADE
    if suffix != "mp4":
        with Image.open(file) as film:
            assert film.n_frames == 3
            for frame in range(3):  # the frames are still those
                film.seek(frame)
                film.load()


@pytest.mark.parametrize("suffix", ["mp4", "gif", "webp", "png"])
def test_films_and_stills_of_a_run_with_warnings(warned, tmp_path, suffix):
    options = {} if suffix == "png" else {"frames": 2}
    found = comment(render(warned, tmp_path / f"a.{suffix}", replace(SMALL, deformation=5.0), **options).file)
    assert found.startswith(MADE)
    assert "5" in found.removeprefix(MADE).partition("warning")[0]  # a magnified deflection is told
    assert all(warning in found for warning in warned.summary["warnings"])


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_charts_of_a_run_with_warnings(warned, tmp_path, suffix):
    file = overview_figure({"paper": warned}, tmp_path / f"overview.{suffix}")
    found = {"png": comment, "svg": lambda svg: html.unescape(svg.read_text("utf-8")), "pdf": subject}[suffix](
        file
    )
    assert all(warning in found for warning in warned.summary["warnings"])


def test_a_page_lists_the_warnings_where_they_are_seen(warned, history, tmp_path):
    page = html.unescape(render(warned, tmp_path / "page.html").file.read_text())
    assert all(warning in page.partition("<main>")[0] for warning in warned.summary["warnings"])
    assert 'class="warnings"' not in render(history, tmp_path / "none.html").file.read_text()


def test_stills_strips_and_figures(history, tmp_path):
    assert comment(render(history, tmp_path / "still.png", SMALL).file) == MADE
    strip = Style(size=(320, 120), deformation=1.0, charts=False, inset=False, ghosts=False, trace=False)
    assert comment(render(history, tmp_path / "strip.png", strip, strip=True, times=[0.01]).file) == MADE
    assert comment(overview_figure({"paper": history}, tmp_path / "overview.png")) == MADE
    assert comment(campbell_diagram(Scenario.builtin("paper"), [0.0, 1.0], 2, tmp_path / "c.png")) == MADE
    for suffix in ("svg", "jpg"):
        assert overview_figure({"paper": history}, tmp_path / f"overview.{suffix}").stat().st_size > 1000
    assert MADE in (tmp_path / "overview.svg").read_text()


def test_pages(history, tmp_path):
    page = render(history, tmp_path / "page.html").file.read_text()
    assert f'<meta name="generator" content="{MADE}">' in page


def test_another_program_draws_what_one_has_computed(history):
    assert made_by([]) == made_by([history]) == MADE
    theirs = {"version": "0.0.9", "numeric_source": "feed"}
    other = type(history)(history.data, history.events, {**history.summary, "provenance": theirs})
    words = "oblique-impact 0.0.9, numeric source feed"
    assert made_by([other, other]) == f"{words}; drawn by {MADE}"
    assert made_by([history, other]) == f"{MADE}; {words}; drawn by {MADE}"

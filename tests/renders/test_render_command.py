"""`oblique-impact render`: what it writes, what it says, bad input in one line."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from oblique_impact.renders import render
from tests.refusals import refused_in_one_line


def test_a_still_shows_the_largest_force_a_time_or_an_event(run, folder, tmp_path, cli):
    history = run("paper")
    strongest = float(history["time"].values[np.argmax(history["lambda_n"].values)])
    pictures = []
    for options in ((), ("--time", strongest), ("--event", "2"), ("--time", history.events[1].time)):
        code, out, err = cli("render", folder, "--out", tmp_path / "a.png", "--size", "480x320", *options)
        assert (code, err) == (0, "")  # nothing from VTK either
        assert "deformation factor 5" in out
        with Image.open(tmp_path / "a.png") as picture:
            assert picture.size == (480, 320)
            pictures.append(np.asarray(picture))
    assert np.array_equal(pictures[0], pictures[1])
    assert np.array_equal(pictures[2], pictures[3])
    assert not np.array_equal(pictures[0], pictures[2])


def test_a_film_says_how_fast_time_runs(folder, tmp_path, cli):
    code, out, err = cli(
        "render", folder, "--out", tmp_path / "a.mp4", "--size", "482x272", "--frames", "3", "--bare"
    )
    assert (code, err) == (0, "")
    assert "3 frames of 482x272, 0.1 s at 30 per second; time runs at " in out
    fastest, slowest = map(float, re.search(r"runs at (\S+) to (\S+) of real time", out).groups())
    assert fastest > 10.0 * slowest  # the frames stand before, in and after contacts


@pytest.mark.parametrize(
    ("options", "seconds"),
    [(("--seconds", "2"), 2.0), ((), 20.0)],
)
def test_a_film_lasts_as_long_as_it_is_told_to(folder, tmp_path, cli, options, seconds):
    out = tmp_path / "a.gif"
    small = ("--size", "320x120", "--letters", "4", "--bare", "--fps", "2")
    code, _, err = cli("render", folder, "--out", out, *small, *options)
    assert (code, err) == (0, "")
    with Image.open(out) as film:
        assert film.n_frames == 2 * seconds
        lasts = [film.seek(n) or film.info["duration"] for n in range(film.n_frames)]
    assert sum(lasts) == pytest.approx(1e3 * seconds, rel=1e-3)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--out", "a.avi"), "--out a.avi: should end with .png"),
        (("--out", "a.png", "--size", "big"), "--size big: should be WIDTHxHEIGHT"),
        (("--out", "a.png", "--time", "5"), "--time 5: should be from 0 to 1 s"),
        (("--out", "a.png", "--event", "99"), "--event 99: should be from 1 to 21"),
        (("--out", "a.mp4", "--between", "1"), "--between 1: should be two numbers"),
        (("--out", "a.png", "--theme", "x"), "--theme x: should be one of light, dark, print"),
        (("--out", "a.html", "--theme", "print"), "--theme print: of a page should be one of light, dark, auto"),
        (("--out", "a.mp4", "--preset", "x"), "--preset x: should be one of talk, paper"),
        (("--out", "a.mp4", "--seconds", "0"), "--seconds 0: should be from 1 to 3600"),
        (("--out", "a.png", "--colour", "x"), "--colour x: should be one of"),
        (("--out", "a.png", "--size", "10x10"), "--size 10x10: should be from 320x120"),
        (("--out", "a.png", "--deformation", "-1"), "--deformation -1.0: should be a positive number"),
        (("--out", "a.svg", "--title", "a\x07b"), "--title a\\x07b: should be a text without control characters"),
        (("--out", "a.svg", "--name", "a\x1bb"), "--name a\\x1bb: should be a text without control characters"),
        (("--out", "a.gif", "--fps", "51"), "--fps 51: of a GIF should be from 1 to 50"),
        (("--out", "a.mp4", "--speed", "1e-9"), "frames: should have at most 100000"),
        (("--out", "a.mp4", "--speed", "0.1", "--contact-speed", "1"), "should be at most --speed, 0.1"),
        (("--out", "a.mp4", "--size", "481x270"), "--size 481x270: films need even numbers"),
        (("--out", "a.png", "--name", "a", "--name", "b"), "--name: 2 given for 1 histories"),
    ],
)
def test_bad_input_is_one_line(folder, tmp_path, refused, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    assert words in refused("render", folder, *arguments)
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_no_history_is_one_line(tmp_path, refused):
    (tmp_path / "history.nc").write_bytes(b"nonsense")
    line = refused("render", tmp_path, "--out", tmp_path / "a.png")
    assert f"{tmp_path / 'history.nc'}: not a readable history of oblique-impact" in line
    assert "no such history" in refused("render", tmp_path / "none", "--out", tmp_path / "a.png")


def test_pages_of_damaged_histories_are_drawn_or_refused_in_one_line(run, tmp_path):
    history, several = run("paper", "end_time=0.33"), run("two-pegs", "end_time=0.01")
    for name in ("theta", "ux", "uy"):
        lost = replace(history, data=history.data.assign({name: np.nan * history[name]}))
        with refused_in_one_line("no sample has a finite shape"):
            render(lost, tmp_path / "a.html")
    with refused_in_one_line("has 1 contacts, where its scenario has 2"):
        render(replace(several, data=several.data.isel(contact=[0])), tmp_path / "a.html")
    assert list(tmp_path.iterdir()) == []
    collisions = [c | {"start": 1e30, "end": 1e30} for c in history.summary["macro_collisions"]]
    contacts = [c._replace(end=1e30) for c in history.contacts]
    late = replace(history, contacts=contacts, summary=history.summary | {"macro_collisions": collisions})
    assert render(late, tmp_path / "a.html").file.is_file()


def test_runs_whose_folders_have_one_name_are_all_in_the_charts(folder, tmp_path, cli):
    other = tmp_path / "beside" / folder.name
    shutil.copytree(folder, other)
    code, _, err = cli("render", folder, other, "--out", tmp_path / "a.svg")
    assert (code, err) == (0, "")
    # in the legends of force, gap and energy
    assert (tmp_path / "a.svg").read_text(encoding="utf-8").count(f">{folder.name}</text>") == 3 * 2

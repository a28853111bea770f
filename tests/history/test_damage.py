"""History files that are damaged, rewritten or left by a crash: refused in one line, or read with a word."""

from __future__ import annotations

import dataclasses
import os
import random
import re
import signal
import subprocess
import time
import warnings
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr

from oblique_impact import FileWarning, History, Scenario, simulate
from tests.docs.test_commands import DOCS
from tests.refusals import refused_in_one_line

SECTOR, PAGE = 512, 4096
FILES = ["events.csv", "history.nc", "scenario.toml", "summary.json"]


@pytest.fixture(scope="module")
def history():
    """A short fall with few samples, whose file has some 140 sectors."""
    keys = ["end_time=0.01", "solver.output_interval=1e-3", "discretization.modes=1"]
    return simulate(Scenario.builtin("paper", keys))


@pytest.fixture
def file(history, tmp_path):
    return history.save(tmp_path / "run") / "history.nc"


@pytest.fixture
def hdf5(monkeypatch):
    """What is handed to HDF5, which may hang in a damaged file: here nothing is read."""
    given: list[bytes] = []

    def note(path, *arguments, **options):
        given.append(Path(path).read_bytes())
        raise OSError("not read in this test")

    monkeypatch.setattr(h5py, "File", note)
    monkeypatch.setattr(xr, "load_dataset", note)
    return given


def fit_for_hdf5(given: list[bytes], content: bytes) -> bool:
    """Whether nothing but the whole content, up to the line of its digest, was handed over."""
    return all(content.startswith(one) and len(content) - len(one) < 200 for one in given)


def test_a_lost_sector_or_page_is_refused_before_hdf5_sees_it(file, hdf5):
    whole = file.read_bytes()
    places = [(place, size) for size in (SECTOR, PAGE) for place in range(0, len(whole), size)]
    lost = [
        whole[:place] + bytes(len(whole[place : place + size])) + whole[place + size :] for place, size in places
    ]
    lost = [content for content in lost if content != whole]
    assert len(lost) > 100
    for content in lost:
        file.write_bytes(content)
        with refused_in_one_line(start=str(file)):
            History.load(file)
    assert hdf5 == []


def test_a_file_that_was_cut_off_or_has_changed_bits_is_refused_before_hdf5_sees_it(file, hdf5):
    whole, numbers = file.read_bytes(), random.Random(1)
    cuts = [numbers.randrange(len(whole)) for _ in range(50)] + [0, 7, 40, len(whole) - 1]
    changed = [whole[:place] for place in cuts]
    for place in cuts[:-1]:
        changed.append(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
    changed += [whole + b"\n", whole + whole]
    for content in changed:
        file.write_bytes(content)
        with refused_in_one_line(start=str(file)):
            History.load(file)
    assert fit_for_hdf5(hdf5, whole)


def test_the_digest_is_that_of_sha256sum(file):
    """The two lines of the page about files, in a shell."""
    page = (DOCS / "reference" / "files.md").read_text(encoding="utf-8")
    (lines,) = re.findall(r"(?s)```sh\n(.*?sha256sum\n) *```", page)
    shown = subprocess.run(
        ["bash", "-c", lines], cwd=file.parent, capture_output=True, text=True, check=True
    ).stdout.splitlines()
    assert shown[0].rpartition(" ")[2] == shown[1].split()[0]
    assert len(shown[1].split()[0]) == 64


def rewritten_by_xarray(file):
    xr.load_dataset(file, engine="h5netcdf").to_netcdf(file, engine="h5netcdf")


def appended_by_xarray(file):
    xr.Dataset({"mine": ("time", np.arange(3.0))}).to_netcdf(file, mode="a", engine="h5netcdf", group="mine")


def changed_in_place(file):
    with h5py.File(file, "r+") as opened:
        opened["theta"][0] += 0.0


def without_its_digest(file):
    content = file.read_bytes()
    file.write_bytes(content[: content.rindex(b"\nSHA-256")])


@pytest.mark.parametrize("change", [rewritten_by_xarray, appended_by_xarray, changed_in_place, without_its_digest])
def test_a_file_that_another_program_wrote_is_read_with_a_word(change, history, file, cli):
    change(file)
    with pytest.warns(FileWarning, match=r"history.nc: has no digest") as given:
        again = History.load(file.parent)
    assert [warning.filename for warning in given] == [__file__]
    xr.testing.assert_identical(again.data, history.data)
    code, _, err = cli("export", file, "--out", file.parent / "beam.csv")
    assert (code, err.count("\n")) == (0, 1)
    assert err.startswith(f"oblique-impact: warning: {file}: has no digest")


def test_an_own_file_is_read_without_a_word_by_every_reader(history, file, cli):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        xr.testing.assert_identical(History.load(file).data, history.data)
    for engine in (None, "h5netcdf"):  # xarray's own way of opening too
        with xr.open_dataset(file, engine=engine) as data:
            assert float(data["theta"][-1]) == float(history["theta"][-1])
    code, _, err = cli("export", file, "--out", file.parent / "beam.csv")
    assert (code, err) == (0, "")


def test_the_rest_of_another_run_beside_a_history_is_told(history, file):
    other = dataclasses.replace(history, summary=history.summary | {"wall_time": 77.0})
    other.save(file.parent)
    file.write_bytes(history.files()["history.nc"])
    with pytest.warns(FileWarning, match=r"summary.json: is not of the run in history.nc"):
        found = History.load(file.parent)
    assert found.summary == history.summary
    (file.parent / "summary.json").unlink()
    assert History.load(file.parent).summary == history.summary


# Crashes --------------------------------------------------------------------------------------------------------


def names_in(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def belongs_to(history: History, folder: Path) -> list[bool]:
    """Of each file that has its name: whether it is of this history."""
    return [(folder / name).read_bytes() == content for name, content in history.files().items()]


@pytest.fixture(scope="module")
def pair(history):
    """Two histories that differ in one number, with contents made once: to save one is to write them."""
    other = dataclasses.replace(history, summary=history.summary | {"wall_time": 77.0})
    for one in (history, other):
        contents = one.files()
        one.files = lambda contents=contents: contents
    yield history, other
    del history.files


def loaded(folder: Path) -> tuple[History, list[str]]:
    """The history of a folder, and the files that a warning was about."""
    with warnings.catch_warnings(record=True) as given:
        warnings.simplefilter("always")
        found = History.load(folder)
    return found, [Path(str(warning.message).partition(": ")[0]).name for warning in given]


def crash(work) -> int:
    """Do some work in a copy of this process; returns how that has ended."""
    child = os.fork()
    if not child:
        try:
            work()
        finally:
            os._exit(1)
    return os.waitpid(child, 0)[1]


@pytest.mark.parametrize("renamed", range(5))
def test_a_crash_between_the_names_of_files(pair, tmp_path, renamed):
    """Before the first: all old. After it the history is new, and the folder says that the others are not."""
    old, new = pair
    old.save(tmp_path)
    replace, done = os.replace, []

    def until(part, path):
        if len(done) == renamed:
            os._exit(0)
        done.append(replace(part, path))

    def work():
        os.replace = until
        new.save(tmp_path)
        os._exit(0)

    assert crash(work) == 0
    mixed, whole = 0 < renamed < 4, new if renamed else old
    found, told = loaded(tmp_path)
    assert found.summary == whole.summary
    assert told == ["summary.json"] * mixed
    assert all(belongs_to(whole, tmp_path)) is not mixed
    new.save(tmp_path)
    assert (names_in(tmp_path), belongs_to(new, tmp_path)) == (FILES, [True] * 4)


def test_a_kill_at_any_instant_of_saving_leaves_one_of_two_histories(pair, tmp_path):
    pair[0].save(tmp_path)

    def save_again_and_again():
        while True:
            for one in reversed(pair):
                one.save(tmp_path)

    numbers = random.Random(1)
    for _ in range(16):
        child = os.fork()
        if not child:
            try:
                save_again_and_again()
            finally:
                os._exit(1)
        time.sleep(numbers.uniform(0.0, 0.1))
        os.kill(child, signal.SIGKILL)
        assert os.waitpid(child, 0)[1] == signal.SIGKILL
        found, told = loaded(tmp_path)
        whole = next(one for one in pair if one.summary == found.summary)
        assert (tmp_path / "history.nc").read_bytes() == whole.files()["history.nc"]
        assert told or all(belongs_to(whole, tmp_path))
    pair[0].save(tmp_path)
    assert (names_in(tmp_path), belongs_to(pair[0], tmp_path)) == (FILES, [True] * 4)


def test_what_gets_its_name_is_on_the_disk(history, tmp_path, monkeypatch):
    """Each file is synchronized before it is renamed, and the folder after that, before the next file."""
    told, replace, fsync = [], os.replace, os.fsync
    tmp_path = tmp_path / "run"

    def note_sync(descriptor):
        told.append(("sync", os.fstat(descriptor).st_ino))
        fsync(descriptor)

    def note_name(part, path):
        told.append(("name", os.stat(part).st_ino))
        replace(part, path)

    monkeypatch.setattr(os, "fsync", note_sync)
    monkeypatch.setattr(os, "replace", note_name)
    history.save(tmp_path)
    folder = tmp_path.stat().st_ino
    files = [(tmp_path / name).stat().st_ino for name in history.files()]
    assert told[:4] == [("sync", inode) for inode in files]
    assert told[4:] == [step for inode in files for step in (("name", inode), ("sync", folder))]

"""Full disks and places that cannot be written: one line, exit 2, nothing half-made, nothing old destroyed."""

from __future__ import annotations

import contextlib
import os
import resource
import shutil
import signal
import subprocess
import tempfile
from types import SimpleNamespace

import pytest

from oblique_impact import History, Scenario
from oblique_impact.command_line.application import main
from oblique_impact.history.size import expected_size
from oblique_impact.validation.checks.registry import all_checks
from tests.processes import COMMAND, files_in, wait_for

FOUR = ["events.csv", "history.nc", "scenario.toml", "summary.json"]


@pytest.fixture(scope="module")
def history(run, tmp_path_factory):
    return run("paper", "end_time=0.33").save(tmp_path_factory.mktemp("paper"))


def quickest():
    return min(all_checks().values(), key=lambda check: check.seconds).id


def command(name, history, out, study):
    """A short form of every command that writes."""
    short = ("--set", "end_time=0.05")
    return {
        "run": ("run", "paper", *short, "--out", out),
        "validate": ("validate", "--only", quickest(), "--workers", 1, "--out", out),
        "refine": ("refine", "--modes", "1,2,3", *short, "--quantity", "theta@end", "--workers", 1, "--out", out),
        "reproduce": ("reproduce", "--workers", 1, "--out", out),
        "sweep": ("sweep", study, "--workers", 1, "--out", out),
        "modes": ("modes", "paper", "--out", out / "campbell.png"),
        "film": ("render", history, "--out", out / "a.mp4", "--frames", 2, "--size", "640x360"),
        "still": ("render", history, "--out", out / "a.png", "--size", "640x360"),
        "page": ("render", history, "--out", out / "a.html"),
        "pvd": ("export", history, "--out", out / "a.pvd", "--every", 100),
        "xdmf": ("export", history, "--out", out / "a.xdmf", "--every", 100),
    }[name]


NAMES = (
    *("run", "validate", "refine", "reproduce", "sweep", "modes"),
    *("film", "still", "page", "pvd", "xdmf"),
)


@pytest.fixture
def study(tmp_path_factory):
    file = tmp_path_factory.mktemp("study") / "study.toml"
    file.write_text('changes.end_time = 0.05\n[[axes]]\nkey = "initial.angle"\nvalues = [0.7, 0.8]\n')
    return file


def call(capfd, *arguments):
    with pytest.raises(SystemExit) as stopped:
        main([*map(str, arguments)])
    captured = capfd.readouterr()
    return stopped.value.code, captured.out, captured.err


@pytest.mark.parametrize("name", NAMES)
def test_a_file_in_place_of_the_folder(history, tmp_path, capfd, study, name):
    (tmp_path / "file").write_text("in the way")
    code, _, err = call(capfd, *command(name, history, tmp_path / "file" / "x", study))
    assert code == 2
    assert err.count("\n") == 1
    assert "--out" in err
    assert (tmp_path / "file").read_text() == "in the way"


@contextlib.contextmanager
def mounted(folder, options):
    """A small file system of our own; only an administrator makes one, and not in every container."""
    folder.mkdir()
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)], capture_output=True)
    if done.returncode:
        pytest.skip("mounting is not allowed here")
    try:
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.skipif(os.geteuid() != 0, reason="mounting is for administrators")
@pytest.mark.parametrize("name", NAMES)
def test_a_read_only_file_system(history, tmp_path, capfd, study, name):
    with mounted(tmp_path / "disk", "ro,size=1m") as disk:
        for place in (disk, disk / "new"):
            code, _, err = call(capfd, *command(name, history, place, study))
            assert code == 2
            assert err.count("\n") == 1, err
            assert "cannot be written: Read-only file system" in err


@pytest.mark.slow
@pytest.mark.skipif(os.geteuid() != 0, reason="mounting is for administrators")
@pytest.mark.parametrize("name", [name for name in NAMES if name != "reproduce"])
def test_a_full_disk(history, tmp_path, capfd, study, name, monkeypatch):
    """The disk is filled up to its last page."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with mounted(tmp_path / "disk", "size=4m") as disk:
        out = disk / "out"
        out.mkdir()
        with contextlib.suppress(OSError), (disk / "filler").open("wb", buffering=0) as filler:
            while True:
                filler.write(bytes(4096))
        os.truncate(disk / "filler", (disk / "filler").stat().st_size - 4096)
        code, _, err = call(capfd, *command(name, history, out, study))
        assert code == 2, err
        assert err.count("\n") == 1, err
        assert "cannot be written" in err
        assert not [file for file in files_in(out) if ".part" in file or file.endswith(".lock")]


@pytest.mark.parametrize(
    ("bound", "end"),
    [
        (500, 0.1),
        pytest.param(20_000, 0.1, marks=pytest.mark.slow),
        pytest.param(600_000, 0.1, marks=pytest.mark.slow),
    ],
)
def test_a_run_whose_disk_is_full(history, tmp_path, bound, end):
    """HDF5 would crash; a bound on the size of files stands for the disk."""

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (bound, bound))

    done = subprocess.run(
        [*COMMAND, "run", "paper", "--set", f"end_time={end}", "--out", str(tmp_path / "out")],
        capture_output=True,
        text=True,
        preexec_fn=limit,
        env={**os.environ, "TMPDIR": str(tmp_path)},
    )
    assert done.returncode == 2, done.stderr
    assert done.stdout == ""
    assert done.stderr.splitlines()[-1].endswith("cannot be written: File too large")
    assert done.stderr.count("\n") == 1
    assert files_in(tmp_path / "out") == []


@pytest.mark.parametrize(
    ("name", "changes"),
    [("paper", ()), ("many-modes", ()), ("paper", ("discretization.method=fem", "discretization.modes=0"))],
)
def test_the_size_of_a_history_is_known_beforehand(run, tmp_path, name, changes):
    scenario = Scenario.builtin(name, [*changes, "end_time=0.3"])
    folder = run(name, *changes, "end_time=0.3").save(tmp_path)
    assert expected_size(scenario) == pytest.approx((folder / "history.nc").stat().st_size, rel=0.02)


def test_a_run_without_room_for_its_history_does_not_begin(tmp_path, refused, monkeypatch):
    free = expected_size(Scenario.builtin("paper"))
    monkeypatch.setattr(shutil, "disk_usage", lambda path: SimpleNamespace(free=0.9 * free))
    line = refused("run", "paper", "--out", tmp_path)
    assert "--out" in line
    assert "solver.output_interval" in line
    assert files_in(tmp_path) == []


def test_a_large_history_is_told_before_the_run(history, tmp_path, capfd, monkeypatch):
    monkeypatch.setattr("oblique_impact.history.size.LARGE", 1e5)
    code, _, err = call(capfd, "run", "paper", "--set", "end_time=0.1", "--out", tmp_path / "large")
    assert code == 0
    assert err.count("\n") == 1
    assert "solver.output_interval" in err
    assert files_in(tmp_path / "large") == FOUR


def saving(folder, history, replace):
    """A process that saves a history, with another function in place of the one that renames files."""
    child = os.fork()
    if not child:
        os.replace = replace
        history.save(folder)
        os._exit(0)
    return child


def test_what_a_killed_save_leaves_is_removed_by_the_next_one(run, tmp_path):
    data = run("paper", "end_time=0.33")
    os.waitpid(saving(tmp_path, data, lambda *names: os.kill(os.getpid(), signal.SIGKILL)), 0)
    assert len([name for name in files_in(tmp_path) if ".part" in name]) == 4
    data.save(tmp_path)
    assert files_in(tmp_path) == FOUR


def test_a_save_leaves_the_files_of_another_one_that_is_alive(run, tmp_path):
    data = run("paper", "end_time=0.33")
    replace, (reader, writer) = os.replace, os.pipe()

    def wait(*names):
        with contextlib.suppress(OSError):  # at the first of four names
            os.close(writer)
        os.read(reader, 1)  # until the other end is closed
        replace(*names)

    child = saving(tmp_path, data, wait)
    wait_for(lambda: len([name for name in files_in(tmp_path) if ".part" in name]) == 4)
    data.save(tmp_path)
    os.close(writer)
    assert os.waitpid(child, 0)[1] == 0
    assert files_in(tmp_path) == FOUR


LONG = "x" * 300


@pytest.mark.parametrize(
    "words",
    [
        ("run", "paper", "--out", LONG),
        ("modes", "--out", LONG),
        ("export", "HISTORY", "--out", f"{LONG}.pvd"),
        ("render", "HISTORY", "--out", f"{LONG}.svg"),
        ("render", LONG, "--out", "a.svg"),
        ("compare", "HISTORY", "HISTORY", "--out", f"{LONG}.html"),
        ("init", f"{LONG}.toml"),
    ],
    ids=lambda words: words[0],
)
def test_a_name_that_is_too_long_is_one_line(history, tmp_path, refused, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    assert LONG in refused(*(history if word == "HISTORY" else word for word in words))
    assert files_in(tmp_path) == []


def test_standard_output_that_is_closed_or_full(tmp_path):
    """Whoever closes it does not want it: the command does what it does without; what is lost is said."""
    words = [*COMMAND, "scenarios"]
    closed = subprocess.run(words, stderr=subprocess.PIPE, preexec_fn=lambda: os.close(1))
    with open("/dev/full", "w") as device:
        full = subprocess.run(words, stderr=subprocess.PIPE, stdout=device)
    assert (closed.returncode, closed.stderr) == (0, b"")
    assert full.returncode == 2
    assert full.stderr.count(b"\n") == 1
    assert b"standard output" in full.stderr


def test_the_results_of_a_run_are_saved_elsewhere_if_their_place_is_full(history, tmp_path, capfd, monkeypatch):
    save, tried = History.save, []

    def full_at_first(self, folder):
        tried.append(folder)
        if len(tried) == 1:
            (tmp_path / "out" / "history.nc").mkdir()  # cannot be replaced by a file
        return save(self, folder)

    monkeypatch.setattr(History, "save", full_at_first)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    code, _, err = call(capfd, "run", "paper", "--set", "end_time=0.01", "--out", tmp_path / "out")
    assert code == 2
    assert err.count("\n") == 1
    assert f"the results are in {tried[1]}" in err
    assert files_in(tmp_path / "out") == []
    assert History.load(tried[1]).summary["outcome"] == "completed"
    assert files_in(tmp_path)[0].startswith("oblique-impact-")

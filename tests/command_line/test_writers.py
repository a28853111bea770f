"""A place has one writer."""

from __future__ import annotations

import fcntl
import os
import subprocess
import sys

import pytest

from oblique_impact.command_line.application import main
from oblique_impact.errors import InputError
from oblique_impact.files import only_writer, writing
from tests.processes import files_in

HOLD = """
import sys, time
from oblique_impact.files import only_writer
with only_writer(sys.argv[1]):
    print("held", flush=True)
    time.sleep(60)
"""


@pytest.fixture(scope="module")
def history(run, tmp_path_factory):
    return run("paper", "end_time=0.33").save(tmp_path_factory.mktemp("paper"))


def call(capfd, *arguments):
    with pytest.raises(SystemExit) as stopped:
        main([*map(str, arguments)])
    captured = capfd.readouterr()
    return stopped.value.code, captured.out, captured.err


FOLDERS = {
    "run": ("run", "paper", "--set", "end_time=0.01"),
    "validate": ("validate", "--only", "frames"),
    "refine": ("refine", "--modes", "1,2,3", "--set", "end_time=0.01", "--quantity", "energy_final"),
    "reproduce": ("reproduce",),
    "sweep": ("sweep", "friction"),
}


@pytest.mark.parametrize("name", FOLDERS)
def test_a_folder_in_use_is_refused_in_one_line(tmp_path, capfd, name):
    with only_writer(tmp_path):
        code, out, err = call(capfd, *FOLDERS[name], "--out", tmp_path)
        assert files_in(tmp_path) == [".lock"]
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert f"--out {tmp_path}: another process is writing here" in err
    assert files_in(tmp_path) == []


@pytest.mark.parametrize(("command", "name"), [("render", "a.mp4")])
def test_a_file_in_use_is_refused_in_one_line(history, tmp_path, capfd, command, name):
    more = ("--every", "100") if command == "export" else ("--frames", "2", "--size", "320x120", "--bare")
    with only_writer(tmp_path / name):
        code, _, err = call(capfd, command, history, "--out", tmp_path / name, *more)
    assert code == 2
    assert err.count("\n") == 1
    assert "another process is writing here" in err
    assert files_in(tmp_path) == []
    # another file in the same folder is not held up
    with only_writer(tmp_path / f"b{name[1:]}"):
        assert call(capfd, command, history, "--out", tmp_path / name, *more)[0] == 0


def test_the_lock_goes_with_a_killed_process_and_leaves_an_empty_hidden_file_at_most(tmp_path):
    with subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path)], stdout=subprocess.PIPE, text=True
    ) as process:
        # the file is there an instant before the lock is held
        assert process.stdout.readline() == "held\n"
        with pytest.raises(InputError, match="another process is writing here"), writing(tmp_path):
            pass
        process.kill()
        process.wait()
    assert (tmp_path / ".lock").stat().st_size == 0
    with writing(tmp_path):
        pass
    assert files_in(tmp_path) == []


def test_a_lock_that_its_holder_removed_meanwhile_is_no_lock(tmp_path, monkeypatch):
    """One who opened the file before its holder removed it must not share the folder with a third."""
    original, tries = fcntl.flock, []

    def late(handle, operation):
        if operation & fcntl.LOCK_EX:
            if not tries:
                os.unlink(tmp_path / ".lock")  # the holder ends between our opening and locking
            tries.append(handle)
        return original(handle, operation)

    monkeypatch.setattr(fcntl, "flock", late)
    with only_writer(tmp_path):
        assert len(tries) == 2
        with pytest.raises(InputError), only_writer(tmp_path):
            pass


def test_a_lock_that_leads_elsewhere_is_not_followed(tmp_path):
    precious = tmp_path / "precious"
    precious.write_text("mine")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / ".lock").symlink_to(precious)
    with pytest.raises(InputError, match="cannot be written"), writing(tmp_path / "out"):
        pass
    assert precious.read_text() == "mine"

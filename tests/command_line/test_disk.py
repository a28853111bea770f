"""Places that cannot be written, full disks, two writers: one line, exit 2, nothing half-made or destroyed."""

from __future__ import annotations

import os
import resource
import shutil
import subprocess

import pytest

from oblique_impact import InputError, Scenario
from oblique_impact.files import writing
from oblique_impact.history.size import expected_size
from oblique_impact.renders.exports import READERS
from tests.processes import COMMAND, files_in


@pytest.mark.parametrize(
    "words",
    [
        ("run", "paper", "--set", "end_time=0.01", "--out"),
        ("modes", "paper", "--out"),
        ("sweep", "friction", "--out"),
    ],
    ids=lambda words: words[0],
)
def test_a_file_in_place_of_the_folder_is_left_alone(tmp_path, refused, words):
    (tmp_path / "file").write_text("in the way")
    assert "--out" in refused(*words, tmp_path / "file" / "x.svg")
    assert (tmp_path / "file").read_text() == "in the way"


def test_a_run_whose_disk_is_full(run, tmp_path):
    """A bound on the size of files stands for the disk."""
    run("paper")  # the kernels are compiled
    bound = 600_000
    done = subprocess.run(
        [*COMMAND, "run", "paper", "--set", "end_time=0.1", "--out", str(tmp_path / "out")],
        capture_output=True,
        text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (bound, bound)),
    )
    assert done.returncode == 2, done.stderr
    assert done.stderr.splitlines()[-1].endswith("cannot be written: File too large")
    assert files_in(tmp_path / "out") == []


@pytest.fixture(params=["disk", "bound"])
def full(request, tmp_path):
    """A folder whose disk has 4 kB, or in which no file may be larger."""
    folder, bound = tmp_path / "full", 4096
    folder.mkdir()
    if request.param == "bound":
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (bound, limits[1]))
        yield folder
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        return
    mount = ["mount", "-t", "tmpfs", "-o", f"size={bound}", "tmpfs", str(folder)]
    if shutil.which("mount") is None or subprocess.run(mount, capture_output=True).returncode:
        pytest.skip("only root can mount a disk")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


@pytest.fixture(scope="module")
def short(run, tmp_path_factory):
    return run("paper", "end_time=0.33").save(tmp_path_factory.mktemp("runs") / "paper")


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf", "html", "gif", "mp4", "pvd", "xdmf", "csv"])
def test_pictures_and_exports_on_a_full_disk_end_in_one_line_and_leave_nothing(short, full, refused, suffix):
    out = full / f"a.{suffix}"
    words = ("export", short, "--every", "1000") if suffix in READERS else ("render", short)
    if suffix in ("png", "gif", "mp4"):
        words = (*words, "--size", "480x320", *(("--frames", "3") if suffix != "png" else ()))
    line = refused(*words, "--out", out)
    assert f"--out {out}: cannot be written: " in line
    assert list(full.iterdir()) == []


def test_a_report_on_a_full_disk_ends_in_one_line_and_leaves_nothing(short, full, cli):
    code, _, err = cli("compare", short, short, "--out", full / "a.html")
    assert code == 2
    assert err.splitlines()[-1].startswith(f"oblique-impact: --out {full / 'a.html'}: cannot be written: ")
    assert list(full.iterdir()) == []


@pytest.mark.parametrize("changes", [(), ("discretization.method=fem", "discretization.modes=0")])
def test_the_size_of_a_history_is_known_beforehand(run, tmp_path, changes):
    folder = run("paper", *changes, "end_time=0.3").save(tmp_path)
    size = expected_size(Scenario.builtin("paper", [*changes, "end_time=0.3"]))
    assert size == pytest.approx((folder / "history.nc").stat().st_size, rel=0.02)


def test_a_folder_has_one_writer(tmp_path, refused):
    with writing(tmp_path):
        assert "another process is writing here" in refused("run", "paper", "--out", tmp_path)
    assert files_in(tmp_path) == []
    child = os.fork()
    if not child:
        with writing(tmp_path):
            os._exit(0)  # as if it were killed
    os.waitpid(child, 0)
    with writing(tmp_path):
        pass
    with pytest.raises(InputError, match="--out"), writing(tmp_path / ("x" * 300)):
        pass

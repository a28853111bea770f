"""Places that cannot be written, full disks, two writers: one line, exit 2, nothing half-made or destroyed."""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager

import pandas as pd
import pytest

from oblique_impact import InputError, Scenario
from oblique_impact.files import writing, writing_file
from oblique_impact.history.size import expected_size
from oblique_impact.renders.exports import READERS
from tests import STUDIES
from tests.processes import COMMAND, files_in, started
from tests.refusals import refused_in_one_line


@pytest.mark.parametrize(
    "words",
    [
        ("run", "paper", "--set", "end_time=0.01", "--out"),
        ("modes", "paper", "--out"),
        ("sweep", STUDIES / "friction.toml", "--out"),
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


@pytest.mark.parametrize("suffix", ["png", "svg", "html", "gif", "mp4", "pvd", "xdmf", "csv"])
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
    """What stays as it is takes nothing in a file, here contacts before the first: it is less than expected."""
    folder = run("paper", *changes, "end_time=0.3").save(tmp_path)
    size = expected_size(Scenario.builtin("paper", [*changes, "end_time=0.3"]))
    assert 1.0 <= size / (folder / "history.nc").stat().st_size < 1.2


@contextmanager
def another_process(writes: AbstractContextManager[None]) -> Iterator[None]:
    """Another process that is writing somewhere."""
    (begun, tell), (wait, end) = os.pipe(), os.pipe()
    child = os.fork()
    if not child:
        with writes:
            os.write(tell, b"begun")
            os.close(end)
            os.read(wait, 1)
            os._exit(0)  # as if it were killed
    os.read(begun, 5)
    try:
        yield
    finally:
        os.close(end)
        os.waitpid(child, 0)
        for pipe in (begun, tell, wait):
            os.close(pipe)


def test_a_folder_has_one_writer(tmp_path):
    with another_process(writing(tmp_path)):
        with refused_in_one_line("another process is writing here", start=f"--out {tmp_path}"), writing(tmp_path):
            pass
        assert files_in(tmp_path) == [".lock"]
    with writing(tmp_path):  # what a killed process left does not matter
        with writing(tmp_path):  # its own writer may go on
            pass
        assert files_in(tmp_path) == [".lock"]
    assert files_in(tmp_path) == []
    with pytest.raises(InputError, match="--out"), writing(tmp_path / ("x" * 300)):
        pass


#: commands that write a folder, and those that write a file
PLACES = {
    "run": ("run", "paper", "--out", "FOLDER"),
    "sweep": ("sweep", STUDIES / "friction.toml", "--out", "FOLDER"),
    "refine": ("refine", "paper", "--elements", "4,8,16", "--out", "FOLDER"),
    "validate": ("validate", "--only", "statics.own-weight", "--out", "FOLDER"),
    "reproduce": ("reproduce", "--out", "FOLDER"),
    "render": ("render", "RUN", "--out", "picture.png"),
    "export": ("export", "RUN", "--out", "table.csv"),
    "compare": ("compare", "RUN", "RUN", "--out", "numbers.json"),
    "modes": ("modes", "paper", "--out", "campbell.svg"),
    "init": ("init", "new.toml"),
}


@pytest.mark.parametrize("command", PLACES)
def test_a_command_is_refused_before_it_computes_where_another_one_writes(
    short, tmp_path, refused, command, monkeypatch
):
    def computed(*arguments, **options):
        raise AssertionError("it computes")

    for name in ("study.compute_each", "parallel.compute_each"):
        monkeypatch.setattr(f"oblique_impact.validation.studies.{name}", computed)
    monkeypatch.setattr("oblique_impact.simulation.compute_history", computed)
    *words, place = PLACES[command]
    place = tmp_path if place == "FOLDER" else tmp_path / place
    writes = writing(place) if place == tmp_path else writing_file(place)
    with another_process(writes):
        line = refused(*(short if word == "RUN" else word for word in words), place)
    assert f"{place}: another process is writing here; wait for it" in line
    assert place == tmp_path or not place.exists()


def test_two_commands_write_two_files_of_a_folder_at_once(run, tmp_path, cli):
    folder = run("paper", "end_time=0.1").save(tmp_path)
    with another_process(writing_file(tmp_path / "film.mp4")), another_process(writing(tmp_path)):
        code, _, err = cli("export", folder, "--out", tmp_path / "table.csv")
    assert (code, err) == (0, "")


SWEEP = """
scenario = "paper"
quantities = ["theta@end"]
[changes]
end_time = 0.01
[[axes]]
key = "initial.angle"
values = [0.5, 0.6, 0.7]
"""


def test_three_sweeps_into_one_folder_at_once(tmp_path):
    """One at least computes; who is late is refused, or finds everything there."""
    (tmp_path / "sweep.toml").write_text(SWEEP)
    words, out = ("sweep", tmp_path / "sweep.toml", "--workers", "1", "--out"), tmp_path / "out"
    with ExitStack() as running:
        sweeps = [running.enter_context(started(*words, out)) for _ in range(3)]
        said = [process.communicate(timeout=300.0)[1] for process in sweeps]
    codes = [process.returncode for process in sweeps]
    assert set(codes) <= {0, 2}
    assert 0 in codes
    for code, line in zip(codes, said, strict=True):
        assert (line.count("\n") == 1 and "another process is writing here" in line) == (code == 2), said
    assert len(pd.read_parquet(out / "results.parquet")) == 3
    files = ["report.html", "results.csv", "results.json", "results.parquet", "scenario.toml", "sweep.toml"]
    assert files_in(out) == files


def test_a_sweep_whose_disk_is_full(run, tmp_path):
    """One line; what has a name is whole: the table is there, the report has no room any more."""
    run("paper", "end_time=0.01")  # the kernels are compiled
    (tmp_path / "sweep.toml").write_text(SWEEP)
    bound = 30_000
    done = subprocess.run(
        [*COMMAND, "sweep", "sweep.toml", "--workers", "1", "--out", "out"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (bound, bound)),
    )
    assert done.returncode == 2, done.stderr
    assert "cannot be written: " in done.stderr
    assert "Traceback" not in done.stderr
    assert files_in(tmp_path / "out") == ["results.parquet", "scenario.toml", "sweep.toml"]
    assert len(pd.read_parquet(tmp_path / "out" / "results.parquet")) == 3

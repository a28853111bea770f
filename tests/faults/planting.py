"""Plant faults into a copy of the sources and run tests there.

Started as a program with a folder, it copies sources and tests into it, and imports the libraries once, which
takes longer than most tests. Then it reads jobs, one object of JSON a line: a fault (`file`, `right`, `wrong`;
none: the sources as they are), `tests` (their ids), `options` of pytest, and `seconds` after which a loop counts
as endless. For each it forks, and writes what pytest returned and the outcomes of the tests.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
LIBRARIES = (
    *("h5netcdf", "jinja2", "matplotlib.pyplot", "meshio", "pandas", "playwright.sync_api", "pyarrow.parquet"),
    *("pydantic", "pytest", "pyvista", "scipy.interpolate", "scipy.signal", "skfem", "typer", "xarray"),
)
COPIED = (
    *("oblique_impact", "modal", "fem_beam", "validation", "renders", "tests", "docs", "examples", "benchmarks"),
    *("pyproject.toml", "CITATION.cff", "CHANGELOG.md", "requirements.lock"),
)
BUILT = shutil.ignore_patterns("_build", "gallery", "__pycache__")

Answer = tuple[int, dict[str, str]]


class Workshop:
    """The program of this file, started; one for all faults that a process tries."""

    def __init__(self, folder: Path) -> None:
        self.log = folder / "log.txt"
        # what pytest and its plugins tell the processes that they start is not for another pytest
        environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}
        command = [sys.executable, __file__, str(folder / "copy"), str(self.log)]
        self._process = subprocess.Popen(
            command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def run(self, *tests: str, **job: Any) -> Answer:
        """Run tests on the sources with a fault; what pytest returned, and their outcomes by their ids."""
        assert self._process.stdin
        assert self._process.stdout
        print(json.dumps({"tests": tests, **job}), file=self._process.stdin, flush=True)
        code, outcomes = json.loads(self._process.stdout.readline())
        return code, outcomes

    def close(self) -> None:
        """End the process."""
        self._process.communicate()


class Outcomes:
    """A plugin of pytest: a test has failed if it says so itself, not what is around it."""

    def __init__(self) -> None:
        self.found: dict[str, str] = {}

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Note the outcome of a test, or of what is before it."""
        if report.when == "call":
            self.found[report.nodeid] = report.outcome
        elif not report.passed:
            self.found.setdefault(report.nodeid, f"{report.when} {report.outcome}")


@contextmanager
def planted(folder: Path, file: str = "", right: str = "", wrong: str = "") -> Iterator[None]:
    """Have a text replaced in a file of the copy, in the block."""
    if file:
        text = (ROOT / file).read_text(encoding="utf-8")
        assert text.count(right) == 1, (file, right)
        (folder / file).write_text(text.replace(right, wrong), encoding="utf-8")
    yield
    if file:
        shutil.copy2(ROOT / file, folder / file)


def in_a_fork(log: Path, seconds: int, work: Callable[[], Answer]) -> Answer:
    """Return what a function returns in another process; -1 and nothing if that is killed."""
    reader, writer = os.pipe()
    child = os.fork()
    if not child:
        try:
            signal.alarm(seconds)
            with log.open("w") as file:
                os.dup2(file.fileno(), 1)
                os.dup2(file.fileno(), 2)
            os.write(writer, json.dumps(work()).encode())
        finally:
            os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as file:
        answer = file.read()
    os.waitpid(child, 0)
    return json.loads(answer or "[-1, {}]")


def run_tests(folder: Path, tests: list[str], options: list[str]) -> Answer:
    """Run tests of the copy in this process, which has imported nothing of the sources yet."""
    import pytest

    os.chdir(folder)
    sys.path[0] = os.environ["PYTHONPATH"] = str(folder)
    share_kernels(folder)
    outcomes = Outcomes()
    code = pytest.main(["-q", "--tb=short", "-p", "no:cacheprovider", *options, *tests], plugins=[outcomes])
    return int(code), outcomes.found


def share_kernels(folder: Path) -> None:
    """Take kernels that were compiled for the sources, where numba looks by the place of a file, and write none.

    A fault in a kernel is therefore only for tests that run it interpreted, or call its parts.
    """
    from numba.core import caching

    locate = caching._CacheLocator.get_suitable_cache_subpath
    caching._CacheLocator.get_suitable_cache_subpath = classmethod(
        lambda _, file: locate(file.replace(str(folder), str(ROOT)))
    )
    caching.Cache.save_overload = lambda *_: None
    from oblique_impact.kernels import jit

    jit._PACKAGE = ROOT / "oblique_impact"
    jit.cache_folder()
    os.environ["NUMBA_CACHE_DIR"] = str(folder / "kernels")  # of processes that the tests start


def main(folder: Path, log: Path) -> None:
    """Copy the sources, and do jobs until there are no more."""
    folder.mkdir()
    for name in COPIED:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, folder / name, ignore=BUILT)
        else:
            shutil.copy2(ROOT / name, folder / name)
    sys.dont_write_bytecode = True  # two versions of a file in one second would be taken for the same
    for line in sys.stdin:
        job = json.loads(line)
        task = partial(run_tests, folder, job.pop("tests"), job.pop("options", []))
        seconds = job.pop("seconds", 300)
        with planted(folder, **job):
            answer = in_a_fork(log, seconds, task)
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    for library in LIBRARIES:
        import_module(library)
    import numba

    numba.njit(lambda x: x)(0.0)  # the compiler loads half of itself when it is needed
    main(Path(sys.argv[1]), Path(sys.argv[2]))

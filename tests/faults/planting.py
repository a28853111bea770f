"""Plant faults into a copy of the sources and run tests on them there.

Started as a program with a folder, it copies the sources into it and imports the libraries once. Then it reads
jobs from its input, one object of JSON a line: a fault (`file`, `right`, `wrong`; none: the sources as they are),
`tests` (their ids) and `options` of pytest. For each it forks, and writes how it went: what pytest returned, and
the outcome of each test.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
COPIED = ("oblique_impact", "modal", "fem_beam", "validation", "renders", "tests", "pyproject.toml")
#: a fault may make a loop endless
SECONDS = 400


class Workshop:
    """The program below, started; one for all faults that a process tries."""

    def __init__(self, folder: Path) -> None:
        self.log = folder / "log.txt"
        command = [sys.executable, __file__, str(folder / "copy"), str(self.log)]
        environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}
        self._process = subprocess.Popen(
            command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def run(self, *tests: str, **job: Any) -> tuple[int, dict[str, str]]:
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
    """A plugin of pytest: failed are tests that say so themselves; what is around them is an error."""

    def __init__(self) -> None:
        self.found: dict[str, str] = {}

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Note the outcome of a phase of a test."""
        if report.when == "call":
            self.found[report.nodeid] = report.outcome
        elif report.outcome != "passed":
            self.found.setdefault(report.nodeid, "error" if report.failed else report.outcome)


@contextmanager
def planted(folder: Path, file: str = "", right: str = "", wrong: str = "") -> Iterator[None]:
    """Have a text replaced in a file of the copy."""
    if file:
        text = (ROOT / file).read_text(encoding="utf-8")
        assert text.count(right) == 1
        (folder / file).write_text(text.replace(right, wrong), encoding="utf-8")
    yield
    if file:
        shutil.copy2(ROOT / file, folder / file)


def in_a_fork(log: Path, work: Any) -> Any:
    """What a function returns in a process of its own; nothing if that is killed."""
    reader, writer = os.pipe()
    child = os.fork()
    if not child:
        signal.alarm(SECONDS)
        with log.open("w") as file:
            os.dup2(file.fileno(), 1)
            os.dup2(file.fileno(), 2)
        os.write(writer, json.dumps(work()).encode())
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as file:
        answer = file.read()
    os.waitpid(child, 0)
    return json.loads(answer or "[-1, {}]")


def run_tests(folder: Path, tests: list[str], options: list[str], interpreted: bool) -> tuple[int, dict[str, str]]:
    """Run tests of the copy in this process."""
    import pytest

    os.chdir(folder)
    sys.path[0] = os.environ["PYTHONPATH"] = str(folder)
    if interpreted:
        os.environ["NUMBA_DISABLE_JIT"], numba.config.DISABLE_JIT = "1", True
    share_kernels(folder)
    outcomes = Outcomes()
    code = pytest.main(["-q", "-p", "no:cacheprovider", *options, *tests], plugins=[outcomes])
    return int(code), outcomes.found


def share_kernels(folder: Path) -> None:
    """Take the compiled kernels of the sources, and write none: a fault in them is for interpreted kernels."""
    from numba.core import caching

    locate = caching._CacheLocator.get_suitable_cache_subpath
    of_sources = classmethod(lambda cls, file: locate(file.replace(str(folder), str(ROOT))))
    caching._CacheLocator.get_suitable_cache_subpath = of_sources
    caching.Cache.save_overload = lambda *_: None
    from oblique_impact.kernels import jit

    jit._PACKAGE = ROOT / "oblique_impact"
    jit.cache_folder()
    os.environ["NUMBA_CACHE_DIR"] = str(folder / "kernels")  # of processes that the tests start


def main(folder: Path, log: Path) -> None:
    """Copy the sources, and do jobs until there are no more."""
    folder.mkdir(parents=True)
    for name in COPIED:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy2
        copy(ROOT / name, folder / name)
    sys.dont_write_bytecode = True
    for line in sys.stdin:
        job = json.loads(line)
        tests, options, interpreted = job.pop("tests"), job.pop("options", []), job.pop("interpreted", False)
        with planted(folder, **job):
            answer = in_a_fork(log, lambda t=tests, o=options, i=interpreted: run_tests(folder, t, o, i))
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    import numba

    main(Path(sys.argv[1]), Path(sys.argv[2]))

"""What the benchmarks share: processor time, ratios of costs that take turns, tables."""

from __future__ import annotations

import csv
import os
import resource
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from oblique_impact import Scenario
from oblique_impact.beam_problem import beam_of, beam_problem
from oblique_impact.marching.loop import Run


def process_cost(arguments: list[str], **environment: str) -> float:
    """Return the processor seconds of a Python process and of those that it starts."""

    def used() -> float:
        children = resource.getrusage(resource.RUSAGE_CHILDREN)
        return children.ru_utime + children.ru_stime

    before = used()
    command = [sys.executable, *arguments]
    subprocess.run(command, check=True, capture_output=True, env={**os.environ, **environment})
    return used() - before


def printed(script: str, **environment: str) -> float:
    """Return the number that a Python script prints, in a process of its own."""
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env={**os.environ, **environment})
    return float(done.stdout)


def size_on_disk(folder: Path) -> tuple[int, int]:
    """Return the bytes of the files in a folder, and how many they are."""
    sizes = [path.stat().st_size for path in folder.rglob("*") if path.is_file()]
    return sum(sizes), len(sizes)


OLD = "8ecdb343"  # what aims of speed are measured against
PACKAGES = ("fem_beam", "modal", "renders", "validation")  # beside `oblique_impact`, of which they are parts


def old_program() -> dict[str, str]:
    """Return the environment in which Python imports the program as it was at the commit `OLD`.

    It is taken from this repository into a folder beside the built files, once; it needs no more than what is
    installed.
    """
    repository = Path(__file__).parents[1]
    tree = repository / "build" / OLD
    if not tree.is_dir():
        partial = tree.with_name(f"{OLD}.partial")
        shutil.rmtree(partial, ignore_errors=True)
        partial.mkdir(parents=True)
        archive = subprocess.run(["git", "archive", OLD], cwd=repository, check=True, capture_output=True).stdout
        subprocess.run(["tar", "-x"], cwd=partial, input=archive, check=True)
        for package in PACKAGES:
            (partial / package).rename(partial / "oblique_impact" / package)
        partial.rename(tree)
    return {"PYTHONPATH": str(tree), "PYTHONSAFEPATH": "1"}  # not what the working folder holds


def call_cost(call: Callable[[], Any]) -> tuple[float, Any]:
    """Return the processor seconds of a call in this process, and its result."""
    started = time.process_time()
    result = call()
    return time.process_time() - started, result


def march_cost(scenario: Scenario) -> float:
    """Return the processor seconds of marching."""
    return call_cost(Run(beam_problem(beam_of(scenario))).execute)[0]


def median_ratio(turns: int, one: Callable[[], float], other: Callable[[], float]) -> float:
    """Return the median of the ratios of two costs that take turns."""
    return statistics.median(one() / other() for _ in range(turns))


def print_table(title: str, headings: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Print a table whose first column is text."""
    table = Table(title=title)
    for number, heading in enumerate(headings):
        table.add_column(heading, justify="right" if number else "left")
    for row in rows:
        table.add_row(*map(str, row))
    Console(width=110).print(table)


def write_csv(file: Path, headings: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table."""
    with file.open("w", newline="", encoding="utf-8") as opened:
        csv.writer(opened, lineterminator="\n").writerows([headings, *rows])

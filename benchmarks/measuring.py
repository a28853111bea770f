"""What the benchmarks share: processor time, ratios of costs that take turns, tables."""

from __future__ import annotations

import csv
import os
import resource
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

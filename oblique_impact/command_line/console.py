"""Shared parts of commands: arguments and options, results on standard output, notes on standard error."""

from __future__ import annotations

import errno
import json
import math
import os
import sys
from collections.abc import Iterable
from typing import Annotated

import typer
from rich.console import Console

from oblique_impact.machine import cores
from oblique_impact.scenario.messages import counted


def _scenarios(incomplete: str) -> list[str]:
    """Return the built-in cases that begin with `incomplete`, for shell completion."""
    from oblique_impact.scenario.scenario import builtin_names

    return [name for name in builtin_names() if name.startswith(incomplete)]


def _keys(incomplete: str) -> list[str]:
    """Return the keys of a scenario that begin with `incomplete`, for shell completion."""
    from oblique_impact.scenario.schema import key_schemas

    return [f"{name}=" for name in key_schemas() if name.startswith(incomplete)]


ScenarioArgument = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO", help="A built-in name (paper, ...) or a TOML file.", autocompletion=_scenarios
    ),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="SECTION.KEY=VALUE", help="Change a key; repeatable.", autocompletion=_keys),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")]


def print_result(lines: Iterable[str], data: object, as_json: bool) -> None:
    """Print a result: in lines, or as one JSON object and nothing else.

    `data` is that object, or a function that returns it.
    """
    from oblique_impact.files import plain

    if as_json:
        print_text(json.dumps(plain(data() if callable(data) else data), allow_nan=False))
    else:
        for line in lines:
            print_line(line)


def print_line(line: str) -> None:
    """Print a line of a result; on a terminal it is broken between words."""
    console = Console(markup=False, highlight=False)
    if console.file.isatty():
        with console.capture() as broken:
            console.print(line)
        line = broken.get().rstrip("\n")
    print_text(line)


def print_text(text: str, err: bool = False) -> None:
    """Print text unchanged; a closed pipe (`| head`) or terminal is no error."""
    try:
        typer.echo(text, err=err)
    except OSError as error:
        if error.errno not in (errno.EPIPE, errno.EIO):
            raise
        stream = sys.stderr if err else sys.stdout
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())  # nor can what is buffered be written


def print_note(line: str) -> None:
    """Print a warning or an error in one line on standard error."""
    print_text(f"oblique-impact: {line}", err=True)


def minutes(what: str, seconds: float, workers: int | None) -> str:
    """Return the expected minutes of computations that take `seconds` on one core, as text; "" if short.

    They are those of a fast machine with compiled kernels; slow ones take three times as long.
    """
    used = min(workers or cores(), cores())
    least = seconds / used / 60.0
    if least <= 0.5:
        return ""
    return f"{what}: {math.ceil(least)} to {math.ceil(3.0 * least)} minutes on {counted(used, 'core')}"

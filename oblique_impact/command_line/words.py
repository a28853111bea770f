"""What several commands share: arguments, options, lines on standard output and standard error."""

from __future__ import annotations

import errno
import json
import math
import os
import shutil
import sys
import textwrap
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

import typer

from oblique_impact.errors import InputError
from oblique_impact.machine import cores


def _scenarios(incomplete: str) -> list[str]:
    """Return the built-in cases that begin so, for a shell that completes; files it knows itself."""
    from oblique_impact.scenario.scenario import builtin_names

    return [name for name in builtin_names() if name.startswith(incomplete)]


def _keys(incomplete: str) -> list[str]:
    """Return the keys of a scenario that begin so, for a shell that completes."""
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
    """Write a result to standard output: in lines, or as one JSON object and nothing else.

    `data` is that object, or a function that returns it.
    """
    if as_json:
        print_text(json.dumps(plain(data() if callable(data) else data), allow_nan=False))
    else:
        for line in lines:
            print_line(line)


def plain(data: Any) -> Any:
    """Return data as JSON holds it: paths as text, NaN and infinity as null."""
    if isinstance(data, dict):
        return {str(name): plain(value) for name, value in data.items()}
    if isinstance(data, list | tuple):
        return [plain(value) for value in data]
    if isinstance(data, float) and not math.isfinite(data):
        return None
    return str(data) if isinstance(data, Path) else data


def print_line(line: str) -> None:
    """Write a result to standard output; on a terminal it is broken between words, not within them."""
    if sys.stdout.isatty():
        width = shutil.get_terminal_size().columns - 1
        line = textwrap.fill(
            line, max(width, 20), subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
        )
    print_text(line)


def print_text(text: str) -> None:
    """Write text to standard output; raises InputError if it cannot be written, on a full disk for instance.

    A reader that is gone (`| head -1`, a terminal that is closed) changes nothing: the command goes on.
    """
    try:
        typer.echo(text)
    except OSError as error:
        # neither is there a place for what is still buffered
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if error.errno not in (errno.EPIPE, errno.EIO):
            raise InputError(f"standard output: cannot be written: {error.strerror}") from None


def minutes(what: str, seconds: float, workers: int | None) -> str:
    """Return how long many computations take that need so many seconds of one core; nothing if that is short.

    `seconds` are those of a fast machine with compiled kernels; slow ones take three times as long.
    """
    used = min(workers or cores(), cores())
    least = seconds / used / 60.0
    if least <= 0.5:
        return ""
    return f"{what}: {math.ceil(least)} to {math.ceil(3.0 * least)} minutes on {used} core{'s'[: used > 1]}"


def print_note(line: str) -> None:
    """Write a warning or an error to standard error, in one line."""
    with suppress(OSError):  # there is nobody who could be told
        typer.echo(f"oblique-impact: {line}", err=True)

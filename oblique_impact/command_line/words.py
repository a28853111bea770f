"""What several commands share: arguments, options, lines on standard output and standard error."""

from __future__ import annotations

import shutil
import sys
import textwrap
from typing import Annotated

import typer

ScenarioArgument = Annotated[str, typer.Argument(help="A built-in name (paper, ...) or a TOML file.")]
SetOption = Annotated[
    list[str] | None, typer.Option("--set", metavar="SECTION.KEY=VALUE", help="Change a key; repeatable.")
]


def print_line(line: str) -> None:
    """Write a result to standard output; on a terminal it is broken between words, not within them."""
    if sys.stdout.isatty():
        width = shutil.get_terminal_size().columns - 1
        line = textwrap.fill(
            line, max(width, 20), subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
        )
    typer.echo(line)


def print_note(line: str) -> None:
    """Write a warning or an error to standard error, in one line."""
    typer.echo(f"oblique-impact: {line}", err=True)

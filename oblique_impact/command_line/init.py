"""The command `init`: a commented scenario to start from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from oblique_impact.command_line.words import JsonOption, print_result


def init(
    file: Annotated[Path, typer.Argument(metavar="FILE.toml", help="The file to write; never one that is there.")],
    base: Annotated[
        str, typer.Option("--from", metavar="SCENARIO", help="A built-in name or a TOML file to begin with.")
    ] = "paper",
    as_json: JsonOption = False,
) -> None:
    """Write a scenario to start from, each key below its meaning, unit and range."""
    from oblique_impact.scenario.starting import start_scenario

    start_scenario(file, base)
    lines = [f"scenario: {file} (as {base})", f"  next: oblique-impact run {file} --out out/{file.stem}"]
    print_result(lines, {"file": file, "from": base}, as_json)

"""The command `init`: a commented scenario to start from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from oblique_impact.command_line.console import JsonOption, SetOption, print_result


def init(
    file: Annotated[Path, typer.Argument(metavar="FILE.toml", help="The file to write; never one that is there.")],
    base: Annotated[
        str, typer.Option("--from", metavar="SCENARIO", help="A built-in name or a TOML file to begin with.")
    ] = "paper",
    changes: SetOption = None,
    recommended: Annotated[
        bool, typer.Option("--recommended", help="Choose frame, modes and damping for this beam and its stop.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Write a scenario to start from, each key below its meaning, unit and range."""
    from oblique_impact.scenario.scenario import Scenario
    from oblique_impact.scenario.starting import start_scenario

    notes: list[str] = []
    if recommended:
        from oblique_impact.beam.recommended import recommended as choose

        # what is given stays; elements take any beam, until it is known whether modes do
        given = [change.partition("=")[0].strip() for change in changes or []]
        free = [] if "discretization.method" in given else ["discretization.method=fem"]
        chosen, notes = choose(Scenario.load(base, [*free, *(changes or [])]), given)
        start_scenario(file, chosen, notes)
    else:
        start_scenario(file, Scenario.load(base, changes) if changes else base)
    lines = [f"scenario: {file} (as {base})", *(f"  {note}" for note in notes)]
    lines.append(f"  next: oblique-impact run {file} --out out/{file.stem}")
    print_result(lines, {"file": file, "from": base}, as_json)

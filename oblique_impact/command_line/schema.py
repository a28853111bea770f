"""The command `schema`: the JSON Schema of scenario files, for editors."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from oblique_impact.command_line.words import print_line


def schema(
    out: Annotated[Path | None, typer.Option("--out", help="File to write it to.")] = None,
) -> None:
    """Print the JSON Schema of scenario files, with which editors complete and check them."""
    from oblique_impact.scenario.schema import scenario_schema

    found = scenario_schema(out)
    if out is None:
        typer.echo(json.dumps(found, indent=2))
    else:
        print_line(f"schema: {out}")

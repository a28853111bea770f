"""The command `schema`: the JSON Schema of scenario files, for editors."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from oblique_impact.command_line.console import JsonOption, print_line, print_text


def schema(
    out: Annotated[Path | None, typer.Option("--out", help="File to write it to.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Print the JSON Schema of scenario files, with which editors complete and check them."""
    import json

    from oblique_impact.scenario.schema import scenario_schema

    found = scenario_schema(out)
    if out is None or as_json:
        print_text(json.dumps(found, indent=None if as_json else 2))
    else:
        print_line(f"schema: {out}")

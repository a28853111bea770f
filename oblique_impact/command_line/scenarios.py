"""The commands about scenario files: `scenarios`, `init` and `schema`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from oblique_impact.command_line.console import JsonOption, SetOption, print_line, print_result, print_text


def scenarios(as_json: JsonOption = False) -> None:
    """List the built-in scenarios: what happens, how long, how many collisions."""
    from oblique_impact.scenario.starting import builtin_cases

    cases = builtin_cases()
    lines = []
    for case in cases:
        count = len(case.collisions)
        words = f"{count} macro-collision{'s' if count > 1 else ''}" if count else "no collision"
        when = f", at {', '.join(f'{time:g}' for time in case.collisions)} s" if count else ""
        lines += [f"{case.name}: {case.end_time:g} s, {words}{when}", f"    {case.happens}"]
    print_result(lines, {"scenarios": [case._asdict() for case in cases]}, as_json)


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
        from oblique_impact.errors import InputError

        # what is given stays; elements take any beam, until it is known whether modes do
        given = [change.partition("=")[0].strip() for change in changes or []]
        free = [] if "discretization.method" in given else ["discretization.method=fem"]
        try:
            asked = Scenario.load(base, [*free, *(changes or [])])
        except InputError:  # as of a beam that nothing holds: then it is said what is wrong with it as it is
            asked = Scenario.load(base, changes)
        chosen, notes = choose(asked, given)
        start_scenario(file, chosen, notes)
    else:
        start_scenario(file, Scenario.load(base, changes) if changes else base)
    lines = [f"scenario: {file} (as {base})", *(f"  {note}" for note in notes)]
    lines.append(f"  next: oblique-impact run {file} --out out/{file.stem}")
    print_result(lines, {"file": file, "from": base}, as_json)


def schema(
    out: Annotated[Path | None, typer.Option("--out", help="File to write it to.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Print the JSON Schema of scenario files, with which editors complete and check them."""
    from oblique_impact.scenario.schema import scenario_schema

    found = scenario_schema(out)
    if out is None or as_json:
        print_text(json.dumps(found, indent=None if as_json else 2))
    else:
        print_line(f"schema: {out}")

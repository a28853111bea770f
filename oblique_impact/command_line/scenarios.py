"""The command `scenarios`: the built-in cases."""

from __future__ import annotations

from oblique_impact.command_line.console import JsonOption, print_result


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

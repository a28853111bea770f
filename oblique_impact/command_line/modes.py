"""The command `modes`: natural frequencies, and their Campbell diagram."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from oblique_impact.command_line.console import JsonOption, ScenarioArgument, SetOption, print_note, print_result
from oblique_impact.errors import InputError

if TYPE_CHECKING:
    from oblique_impact.beam.frequencies import Frequencies


def modes(
    scenario: ScenarioArgument = "paper",
    speeds: Annotated[str, typer.Option(help="Spin rates in rad/s, separated by commas.")] = "0",
    count: Annotated[int | None, typer.Option(min=1, max=100, help="Frequencies per speed.")] = None,
    as_json: JsonOption = False,
    out: Annotated[
        Path | None, typer.Option("--out", help="Campbell diagram: a picture file or a folder.")
    ] = None,
    changes: SetOption = None,
) -> None:
    """Natural frequencies (rad/s and Hz) of the spinning beam, flapwise and chordwise."""
    from oblique_impact.beam.frequencies import natural_frequencies
    from oblique_impact.command_line.progress_bars import counting_bar
    from oblique_impact.files import writing_file
    from oblique_impact.scenario.scenario import Scenario

    chosen = Scenario.load(scenario, changes)
    rates = _speeds(speeds)
    target = nullcontext() if out is None else writing_file(out if out.suffix else out / "campbell.png")
    with target:
        with counting_bar("frequencies"):
            found = natural_frequencies(chosen, rates, count)
        if out is not None:
            from oblique_impact.renders.campbell import campbell_diagram

            out = campbell_diagram(chosen, rates, found.flapwise.shape[1], out)
    print_result(_lines(found), found.to_dict(), as_json)
    if out is not None:
        print_note(f"Campbell diagram: {out}")


def _speeds(text: str) -> list[float]:
    try:
        rates = [float(part) for part in text.split(",")]
    except ValueError:
        rates = [math.nan]
    if not all(math.isfinite(rate) and abs(rate) <= 1e9 for rate in rates):
        raise InputError(f"--speeds {text}: should be finite numbers in rad/s, separated by commas")
    return rates


def _lines(found: Frequencies) -> Iterator[str]:
    for direction, table in (("flapwise", found.flapwise), ("chordwise", found.chordwise)):
        yield f"{direction} (rad/s, below in Hz)"
        for rate, row in zip(found.speeds, table, strict=True):
            yield f"  at {rate:10.4g} rad/s: " + " ".join(f"{value:14.6f}" for value in row)
            yield f"{'Hz:':>22} " + " ".join(f"{value / (2.0 * math.pi):14.6f}" for value in row)

"""The command `modes`: natural frequencies over the spin rate, or about the equilibrium with closed contacts."""

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
    from oblique_impact.scenario.scenario import Scenario
    from oblique_impact.vibration import VibrationModes


def modes(
    scenario: ScenarioArgument = "paper",
    speeds: Annotated[
        str | None, typer.Option(help="Spin rates in rad/s, separated by commas; default: 0.")
    ] = None,
    closed: Annotated[
        bool, typer.Option("--closed", help="About the equilibrium, with the contacts that are closed there.")
    ] = False,
    friction: Annotated[
        str | None, typer.Option(help="With --closed: closed contacts are free to slip, or stuck; default: free.")
    ] = None,
    count: Annotated[int | None, typer.Option(min=1, max=100, help="Frequencies per speed.")] = None,
    as_json: JsonOption = False,
    out: Annotated[
        Path | None,
        typer.Option("--out", help="Campbell diagram, or mode shapes with --closed: a picture file or a folder."),
    ] = None,
    changes: SetOption = None,
) -> None:
    """Natural frequencies (rad/s and Hz): of the spinning beam, or about its equilibrium with damping ratios."""
    from oblique_impact.beam.frequencies import natural_frequencies
    from oblique_impact.command_line.progress_bars import counting_bar
    from oblique_impact.files import suffix_of, writing_file
    from oblique_impact.scenario.scenario import Scenario

    chosen = Scenario.load(scenario, changes)
    if closed:
        if speeds is not None:
            raise InputError(f"--speeds {speeds}: does not apply together with --closed: a beam at rest")
        _about_rest(chosen, count, friction or "free", as_json, out)
        return
    if friction is not None:
        raise InputError(f"--friction {friction}: only with --closed")
    rates = _speeds(speeds or "0")
    target = nullcontext() if out is None else writing_file(out if suffix_of(out) else out / "campbell.png")
    with target:
        with counting_bar("frequencies"):
            found = natural_frequencies(chosen, rates, count)
        if out is not None:
            from oblique_impact.renders.campbell import campbell_diagram

            out = campbell_diagram(chosen, rates, found.flapwise.shape[1], out)
    print_result(_lines(found), found.to_dict(), as_json)
    if out is not None:
        print_note(f"Campbell diagram: {out}")


def _about_rest(scenario: Scenario, count: int | None, friction: str, as_json: bool, out: Path | None) -> None:
    """Print frequencies and damping ratios about the equilibrium, and draw the shapes."""
    from oblique_impact.files import suffix_of, writing_file
    from oblique_impact.vibration import frequencies_at_rest

    if friction not in ("free", "stuck"):
        raise InputError(f"--friction {friction}: should be free or stuck")
    target = nullcontext() if out is None else writing_file(out if suffix_of(out) else out / "mode-shapes.png")
    with target:
        found = frequencies_at_rest(scenario, count, "stuck" if friction == "stuck" else "free")
        if out is not None:
            from oblique_impact.renders.mode_shapes import draw_mode_shapes

            out = draw_mode_shapes(found, out)
    print_result(_rest_lines(found), found.to_dict(), as_json)
    if out is not None:
        print_note(f"mode shapes: {out}")


def _rest_lines(found: VibrationModes) -> Iterator[str]:
    yield "mode          rad/s             Hz  damping ratio"
    for k, (rate, ratio) in enumerate(zip(found.frequencies, found.damping, strict=True), start=1):
        yield f"{k:4d} {rate:14.6f} {rate / (2.0 * math.pi):14.6f} {ratio:14.6g}"
    names = [
        f"{f'obstacle {obstacle}' if obstacle else 'the slope'} at {place:.6g} m"
        for obstacle, place in found.closed
    ]
    yield f"closed: {', '.join(names) or 'no contact'}"


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

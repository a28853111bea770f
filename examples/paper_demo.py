"""The paper's case on both discretizations, side by side.

    python examples/paper_demo.py [FOLDER]

Assumed modes against Hermite finite elements reduced to as many of their own modes, with the same hybrid
contact algorithm: they share the contact, so their difference is that of the two discretizations,
which falls like h^4. Exact reference: the event times of two clamped modes in the documentation.
"""

from __future__ import annotations

import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table

from oblique_impact import History, Scenario, simulate
from oblique_impact.jit import is_compiled
from oblique_impact.progress import progress_bar
from renders.overview import overview_figure
from validation.comparison import compare_events, largest_difference, markdown_table, table_rows

ELEMENTS = 64


def run_both(console: Console) -> dict[str, History]:
    """Simulate the paper's case by assumed modes and by finite elements."""
    scenarios = {
        "modal": Scenario.builtin("paper"),
        "fem": Scenario.builtin("paper").replace(discretization__method="fem", discretization__elements=ELEMENTS),
    }
    if not is_compiled("march_event"):
        console.print("first run on this machine: compiling the numerical kernels, about 20 s, once")
    histories = {}
    for name, scenario in scenarios.items():
        with progress_bar(console) as show:
            histories[name] = simulate(scenario, show)
        seconds = histories[name].summary["wall_time"]
        console.print(f"{name:>5}: {histories[name].summary['events']} events, {seconds:.2f} s")
    return histories


def show_table(console: Console, pairs: list) -> None:
    """Print the two event logs side by side."""
    table = Table(title=f"Events: assumed modes against {ELEMENTS} finite elements")
    for heading in ("#", "event", "modal t (s)", "fem t (s)", "difference (s)", "modal I (N s)", "fem I (N s)"):
        table.add_column(heading, justify="left" if heading == "event" else "right", no_wrap=True)
    for row in table_rows(pairs):
        table.add_row(*row)
    console.print(table)


def main(folder: str = "out/demo") -> None:
    """Run, compare, draw, and say where everything is."""
    console = Console(width=118) if not sys.stdout.isatty() else Console()
    target = Path(folder)
    histories = run_both(console)
    for name, history in histories.items():
        history.save(target / name)
    pairs = compare_events(histories["modal"], histories["fem"])
    show_table(console, pairs)
    (target / "events.md").write_text(markdown_table(pairs, "modal", "fem"), encoding="utf-8")
    console.print(f"largest difference of an event time: {largest_difference(pairs):.1e} s")
    for name, history in histories.items():
        energy = history.summary["energy"]
        console.print(
            f"{name:>5}: energy unaccounted for {energy['unaccounted']:+.1e} J of {energy['initial']:.4f} J"
        )
    picture = overview_figure(histories, target / "overview.png")
    console.print(
        f"figure: {picture}   events: {target / 'events.md'}   runs: {target / 'modal'}, {target / 'fem'}"
    )


if __name__ == "__main__":
    main(*sys.argv[1:2])

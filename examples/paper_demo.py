"""The paper's case on both discretizations, side by side.

    python examples/paper_demo.py [FOLDER [FRAMES]]

Assumed modes against Hermite finite elements reduced to as many of their own modes, with the same hybrid
contact algorithm: they share the contact, so their difference is that of the two discretizations,
which falls like h^4. Exact reference: the event times of two clamped modes in the documentation.  At the end
there are pictures: a film, a strip of the first collision, and a page to play with in a browser.
"""

from __future__ import annotations

import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table

from oblique_impact import History, InputError, Scenario, simulate
from oblique_impact.command_line.bars import counting_bar, progress_bar
from oblique_impact.progress import Progress
from renders.film import write_film, write_strip
from renders.frame import Style
from renders.overview import overview_figure
from renders.player import write_player
from renders.timeline import make_timeline
from validation.comparison import compare_events, largest_difference
from validation.event_pairs import markdown_table, table_rows

ELEMENTS, FRAMES = 64, 450


def run_both(console: Console) -> dict[str, History]:
    """Simulate the paper's case by assumed modes and by finite elements."""
    scenarios = {
        "modal": Scenario.builtin("paper"),
        "fem": Scenario.builtin("paper").replace(discretization__method="fem", discretization__elements=ELEMENTS),
    }
    histories = {}
    for name, scenario in scenarios.items():
        with progress_bar() as show:
            histories[name] = simulate(scenario, show)
        seconds = histories[name].summary["wall_time"]
        console.print(f"{name:>5}: {histories[name].summary['events']} events, {seconds:.2f} s")
    return histories


def show_table(console: Console, pairs: list) -> None:
    """Print the two event logs side by side."""
    title = f"Events: assumed modes against {ELEMENTS} finite elements"
    table = Table(title=title, box=None, padding=(0, 1, 0, 0), pad_edge=False)
    for heading in ("#", "event", "modal t (s)", "fem t (s)", "difference (s)", "modal I (N s)", "fem I (N s)"):
        # the unit below the name, so that the table fits into 80 columns
        table.add_column(
            heading.replace(" (", "\n("), justify="left" if heading == "event" else "right", no_wrap=True
        )
    for row in table_rows(pairs):
        table.add_row(*row)
    console.print(table)


def draw(console: Console, history: History, target: Path, frames: int) -> None:
    """Draw the film, the strip and the page; say where they are, or what is missing to draw them."""
    timeline = make_timeline(history, frames=frames)
    try:
        with counting_bar("page and strip"):
            page = write_player(history, target / "paper.html")
            strip = write_strip([history], ["paper"], Style(size=(1000, 250)), [], target / "strip.png")
        with counting_bar("film") as show:
            film = write_film(
                [history],
                ["paper"],
                Style(),
                timeline,
                target / "paper.mp4",
                lambda done, total: show(Progress(done, total)),
            )
    except InputError as error:
        console.print(f"no pictures: {error}", soft_wrap=True)
        return
    say(console, film=film, strip=strip, page=page)


def say(console: Console, **files: Path) -> None:
    """Say where files are, each in a line of its own that can be copied."""
    for name, file in files.items():
        console.print(f"{name:>6}: {file}", soft_wrap=True)


def main(folder: str = "out/demo", frames: str = str(FRAMES)) -> None:
    """Run, compare, draw, and say where everything is."""
    console = Console(width=118) if not sys.stdout.isatty() else Console()
    target = Path(folder)
    histories = run_both(console)
    with counting_bar("files"):
        for name, history in histories.items():
            history.save(target / name)
        picture = overview_figure(histories, target / "overview.png")
    pairs = compare_events(histories["modal"], histories["fem"])
    show_table(console, pairs)
    (target / "events.md").write_text(markdown_table(pairs, "modal", "fem"), encoding="utf-8")
    console.print(f"largest difference of an event time: {largest_difference(pairs):.1e} s")
    for name, history in histories.items():
        energy = history.summary["energy"]
        console.print(
            f"{name:>5}: energy unaccounted for {energy['unaccounted']:+.1e} J of {energy['initial']:.4f} J"
        )
    say(console, figure=picture, events=target / "events.md", modal=target / "modal", fem=target / "fem")
    draw(console, histories["modal"], target, int(frames))


if __name__ == "__main__":
    main(*sys.argv[1:3])

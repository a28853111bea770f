"""The paper's case on both discretizations, compared and drawn.

    python examples/paper_demo.py [FOLDER [FRAMES]]

Assumed modes against Hermite finite elements reduced to as many of their own modes, with the same hybrid
contact algorithm: they share the contact, so their difference is that of the two discretizations, which falls
like h^4. Exact reference: the event times of two clamped modes in the documentation.
"""

import sys
from pathlib import Path

from oblique_impact import InputError, Scenario, simulate
from oblique_impact.command_line.progress_bars import counting_bar, progress_bar
from oblique_impact.renders import overview_figure, render
from oblique_impact.validation import compare


def main(folder: str = "out/demo", frames: str = "450") -> None:
    target, paper = Path(folder), Scenario.builtin("paper")
    with progress_bar() as show:
        modal = simulate(paper, show)
    with progress_bar() as show:
        fem = simulate(paper.replace(discretization__method="fem", discretization__elements=64), show)
    found = compare(modal, fem, names=("modal", "fem"))
    print(f"modal against fem: largest difference of an event time {found.about['largest_shift']:.1e} s")
    for name, history in (("modal", modal), ("fem", fem)):
        print(f"{name:>6}: {history.save(target / name)}")
    (target / "compared.txt").write_text(f"{found}\n", encoding="utf-8")
    print(f" table: {target / 'compared.txt'}")
    try:
        print(f"figure: {overview_figure({'modal': modal, 'fem': fem}, target / 'overview.png')}")
        print(f" still: {render(modal, target / 'still.png').file}")
        print(f"  page: {render(modal, target / 'paper.html').file}")
        with counting_bar("film") as show_frames:
            film = render(modal, target / "paper.mp4", frames=int(frames), on_progress=show_frames).file
        print(f"  film: {film}")
    except InputError as error:
        print(f"no pictures: {error}")


if __name__ == "__main__":
    main(*sys.argv[1:3])

"""Films against a bare PyVista loop: medians over turns, in one table.

    python benchmarks/films.py [TURNS] [FRAMES]

The bare loop moves a plain tube with as many points as the beam, renders one view of the size of a frame with the
same anti-aliasing (a window twice as large, averaged) and hands the frames to ffmpeg; it has no
inset, no charts, no text.  A film should cost at most 1.5 times as much.  Both take turns, so that what else runs
on the machine meets both alike.
"""

from __future__ import annotations

import resource
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from PIL import Image
from rich.console import Console
from rich.table import Table

from oblique_impact import Scenario, simulate
from oblique_impact.renders.film import write_film, write_mp4
from oblique_impact.renders.offscreen import prepare
from oblique_impact.renders.scene import SUPERSAMPLING
from oblique_impact.renders.story import Story, story_of
from oblique_impact.renders.timeline import FPS, make_timeline


class Cost(NamedTuple):
    """Seconds of wall and of CPU time, that of the encoder included."""

    wall: float
    cpu: float


def cost_of(call: Callable[[], object]) -> Cost:
    """Time a call."""

    def now() -> Cost:
        used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        return Cost(time.perf_counter(), sum(u.ru_utime + u.ru_stime for u in used))

    before = now()
    call()
    return Cost(*(b - a for a, b in zip(before, now(), strict=True)))


def bare_loop(story: Story, frames: int) -> Iterator[NDArray[np.uint8]]:
    """Yield the frames of a film of a tube that swings and bends."""
    prepare()
    geometry = story.geometries[0]
    points = geometry.tube(0)[0]
    mesh = pv.PolyData(points, geometry.solid.faces)
    mesh.point_data["shown"] = geometry.result(story.style.quantity, 0)
    size = [SUPERSAMPLING * pixels for pixels in story.style.size]
    plotter = cast(Any, pv.Plotter(off_screen=True, window_size=size, lighting="light kit"))
    plotter.render_window.SetMultiSamples(0)
    limit = story.colours.limit
    plotter.add_mesh(mesh, scalars="shown", clim=(-limit, limit), show_scalar_bar=False)
    plotter.camera_position = "xy"
    x, y, z = points.T
    for turn in np.linspace(0.0, 6.0, frames):
        bent = 0.02 * np.sin(np.pi * np.hypot(x, y)) * np.sin(20.0 * turn)
        c, s = np.cos(0.3 * np.sin(turn)), np.sin(0.3 * np.sin(turn))
        mesh.points = np.stack([c * x - s * (y + bent), s * x + c * (y + bent), z], axis=1)
        plotter.render()
        picture = Image.fromarray(np.asarray(plotter.screenshot(return_img=True)))
        yield np.asarray(picture.reduce(SUPERSAMPLING))
    plotter.close()


def main(turns: int = 3, frames: int = 0) -> None:
    """Measure and print; the film has its usual length if no number of frames is given."""
    story = story_of([simulate(Scenario.builtin("paper"))])
    timeline = make_timeline(story.time_map, frames=frames or None)
    frames = timeline.times.size
    costs: dict[str, list[Cost]] = {"bare loop": [], "mp4": [], "gif": []}
    with tempfile.TemporaryDirectory() as folder:

        def bare() -> None:
            write_mp4(Path(folder, "bare.mp4"), bare_loop(story, frames), FPS, "")

        for _ in range(turns):
            costs["bare loop"].append(cost_of(bare))
            for kind in ("mp4", "gif"):
                file = Path(folder, f"film.{kind}")
                costs[kind].append(cost_of(lambda file=file: write_film(story, timeline, file)))
    table = Table(title=f"Films of {frames} frames of {story.style.size[0]}x{story.style.size[1]}, {turns} turns")
    for heading in ("", "wall ms/frame", "min", "max", "CPU ms/frame", "wall over bare", "CPU over bare"):
        table.add_column(heading, justify="right" if heading else "left")
    medians = {name: Cost(*(map(statistics.median, zip(*found, strict=True)))) for name, found in costs.items()}
    bare = medians["bare loop"]
    for name, found in costs.items():
        (wall, cpu), walls = medians[name], [cost.wall for cost in found]
        cells = [f"{1e3 * value / frames:.1f}" for value in (wall, min(walls), max(walls), cpu)]
        table.add_row(name, *cells, f"{wall / bare.wall:.2f}", f"{cpu / bare.cpu:.2f}")
    Console(width=110).print(table)


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:3]))

"""The bare PyVista loop that films are measured against."""

from __future__ import annotations

import resource
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, cast

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from PIL import Image

from oblique_impact import Scenario, simulate
from oblique_impact.renders.film import write_film, write_mp4
from oblique_impact.renders.offscreen import prepare
from oblique_impact.renders.scene import SUPERSAMPLING
from oblique_impact.renders.story import Story, story_of
from oblique_impact.renders.timeline import FPS, make_timeline

FRAMES = 300  # half of a film, whose start counts twice as much then


def film_costs() -> tuple[Callable[[], float], Callable[[], float]]:
    """Return what makes a film of `paper`, and the bare loop: both return processor seconds, the encoder's too."""
    story = story_of([simulate(Scenario.builtin("paper"))])
    timeline = make_timeline(story.time_map, frames=FRAMES)

    def film() -> float:
        with tempfile.TemporaryDirectory() as folder:
            return _cost(lambda: write_film(story, timeline, Path(folder, "film.mp4")))

    def bare() -> float:
        with tempfile.TemporaryDirectory() as folder:
            return _cost(lambda: write_mp4(Path(folder, "bare.mp4"), _bare_loop(story), FPS, ""))

    return film, bare


def _bare_loop(story: Story) -> Iterator[NDArray[np.uint8]]:
    """Yield the frames of a tube with as many points as the beam that swings and bends, without text and charts.

    One view has the size of a frame, with the same anti-aliasing: a window twice as large, averaged.
    """
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
    for turn in np.linspace(0.0, 6.0, FRAMES):
        bent = 0.02 * np.sin(np.pi * np.hypot(x, y)) * np.sin(20.0 * turn)
        c, s = np.cos(0.3 * np.sin(turn)), np.sin(0.3 * np.sin(turn))
        mesh.points = np.stack([c * x - s * (y + bent), s * x + c * (y + bent), z], axis=1)
        plotter.render()
        picture = Image.fromarray(np.asarray(plotter.screenshot(return_img=True)))
        yield np.asarray(picture.reduce(SUPERSAMPLING))
    plotter.close()


def _cost(call: Callable[[], object]) -> float:
    def used() -> float:
        both = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        return sum(one.ru_utime + one.ru_stime for one in both)

    before = used()
    call()
    return used() - before

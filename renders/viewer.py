"""An interactive window on a run: the coloured beam moves, a slider chooses the time, the space bar plays.

Playing follows the course of the films: time is stretched where the beam is in contact.
"""

from __future__ import annotations

import os
import sys
from typing import Any

import numpy as np

from oblique_impact.contact.state import State
from oblique_impact.errors import InputError
from oblique_impact.history.history import History, require_history
from oblique_impact.renders.scene import Panel, Scene
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style
from oblique_impact.renders.timeline import make_timeline

_FPS = 30


class Viewer:
    """A window with the scene of a still at a time; `go_to` moves it, `step` plays a frame."""

    def __init__(self, history: History, style: Style, **window: Any) -> None:
        story, theme = story_of([history], style), style.colours
        self._magnified = next(iter(story.magnified), "")
        self.geometry = story.geometries[0]
        self.times = make_timeline(story.time_map, _FPS).times
        self.playing, self._frame = False, 0
        self.scene = Scene(story, [Panel((0, 0, *style.size), [0])], style.size, **window)
        self.plotter = self.scene.plotter
        self.plotter.add_scalar_bar(
            f"{story.colours.title}\n",  # else the ticks touch it
            mapper=self.scene.views[0].beams[0].actor.mapper,
            color=theme.ink,
            fmt="%.4g",
            position_x=0.5,
            position_y=0.03,
            width=0.45,
            height=0.1,
        )
        self._text = self.plotter.add_text("", position="lower_left", font_size=12, color=theme.ink)
        self._slider = self.plotter.add_slider_widget(
            self.go_to,
            (float(self.times[0]), float(self.times[-1])),
            value=float(self.times[0]),
            title="time (s)",
            color=theme.ink,
            pointa=(0.45, 0.9),
            pointb=(0.95, 0.9),
            fmt="%.4f",
        )
        self.plotter.add_key_event("space", self._toggle)
        self.go_to(float(self.times[0]))

    def go_to(self, time: float) -> None:
        """Show the beam at a time (s), with the contact force that acts on it."""
        self.scene.views[0].move(time)
        k = self.geometry.index(time)
        force = float(np.linalg.norm(self.geometry.contact_force(k)))
        state = State(int(self.geometry.value("state", int(k)))).name
        words = f"t = {time:.5f} s  {state}" + (f"  contact force {force:.4g} N" if force else "")
        self._text.set_text("lower_left", f"{self._magnified}\n{words}")
        self._frame = int(np.searchsorted(self.times, time))

    def step(self, _: int = 0) -> None:
        """Show the next frame of the film, after the last one the first, if the film is playing."""
        if not self.playing:
            return
        self._frame = (self._frame + 1) % self.times.size
        time = float(self.times[self._frame])
        self.go_to(time)
        self._slider.GetRepresentation().SetValue(time)
        self.plotter.render()

    def _toggle(self) -> None:
        self.playing = not self.playing


def show(history: History, style: Style | None = None) -> Any:
    """Open an interactive window on a run: turn and zoom with the mouse, choose the time, play with the space bar.

    Parameters
    ----------
    history : History
        Of a beam.
    style : Style, optional
        Size of the window (pixels), colours, camera, result in colour, deformation factor.

    Returns
    -------
    object
        In a notebook what PyVista displays there, else None, when the window has been closed.

    Raises
    ------
    InputError
        In one line, for what is no history of a beam, or a system without a display.

    Examples
    --------
    >>> from oblique_impact import Scenario, simulate
    >>> from oblique_impact.renders import show
    >>> show(simulate(Scenario.builtin("paper")))  # doctest: +SKIP
    """
    require_history(history, "show")
    notebook = "ipykernel" in sys.modules
    screen = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY") or not sys.platform.startswith("linux")
    if not (notebook or screen):
        raise InputError("show: there is no display here; render draws pictures, films and pages without one")
    viewer = Viewer(history, style or Style(), notebook=notebook)
    if not notebook:
        viewer.plotter.add_timer_event(max_steps=10**9, duration=1000 // _FPS, callback=viewer.step)
    return viewer.plotter.show()

"""An interactive window on a run: the coloured beam moves, a slider chooses the time, the space bar plays.

Playing follows the course of the films: time is stretched where the beam is in contact.
"""

from __future__ import annotations

import importlib.util
import os
import sys
from typing import Any, cast

import numpy as np
import pyvista as pv

from oblique_impact.contact.state import State
from oblique_impact.errors import InputError
from oblique_impact.history.history import History, require_history
from oblique_impact.renders.offscreen import prepare
from oblique_impact.renders.scenery import pin, slope_wedge
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import CameraName, Colour, Style, ThemeName
from oblique_impact.renders.timeline import make_timeline

_FPS = 30
#: length of the arrow of the largest force, over that of the beam
_ARROW = 0.16
#: units of depth by which the arrow, which comes out of the slope, is drawn in front of it
_IN_FRONT = -1e6
_EYES = {"oblique": (0.22, 0.30, 1.0), "front": (0.0, 0.0, 1.0), "above": (0.15, 0.9, 1.0)}


class Viewer:
    """A window with the beam at a time; `go_to` moves it, `step` plays a frame."""

    def __init__(self, history: History, style: Style, **window: Any) -> None:
        story = story_of([history], style)
        self.geometry, self._quantity = story.geometries[0], style.quantity
        self.times = make_timeline(story.time_map, _FPS).times
        self.playing, self._frame = False, 0
        self.plotter = cast(Any, pv.Plotter(window_size=list(style.size), lighting="light kit", **window))
        theme = style.colours
        self.plotter.set_background(theme.background)
        self.mesh = pv.PolyData(self.geometry.surface(0).points, self.geometry.faces)
        self.shown, (self._size, _) = story.colours.title, story.colours.unit
        self.mesh.point_data[self.shown] = np.zeros(self.mesh.n_points)
        limit = story.colours.limit / self._size
        bar = {
            "title": f"{self.shown}\n",  # else the ticks touch it
            "color": theme.ink,
            "n_labels": 5,
            "fmt": "%.4g",
            "title_font_size": 16,
            "label_font_size": 14,
            "unconstrained_font_size": True,
            "position_x": 0.5,
            "position_y": 0.03,
            "width": 0.45,
            "height": 0.1,
        }
        self.mesh_actor = self.plotter.add_mesh(
            self.mesh,
            scalars=self.shown,
            cmap=style.colours.colour_map,
            clim=(-limit, limit),
            scalar_bar_args=bar,
            smooth_shading=False,
        )
        self.plotter.add_mesh(pin(self.geometry), color=theme.pin)
        if story.slope:
            self.plotter.add_mesh(slope_wedge(self.geometry, story.slope), color=theme.slope)
        self.arrow = pv.PolyData()
        self._force = self.plotter.add_mesh(pv.Arrow(), color=theme.arrow)
        self._force.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        self._force.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(0.0, _IN_FRONT)
        self._text = self.plotter.add_text("", position="lower_left", font_size=12, color=theme.ink)
        self._slider = self.plotter.add_slider_widget(
            self.go_to,
            (float(self.times[0]), float(self.times[-1])),
            value=float(self.times[0]),
            title="time (s)",
            color=theme.ink,
            pointa=(0.45, 0.9),
            pointb=(0.95, 0.9),
            title_height=0.02,
            tube_width=0.004,
            slider_width=0.012,
            fmt="%.4f",
        )
        self.plotter.add_key_event("space", self._toggle)
        self.plotter.camera_position = [_EYES[style.camera], (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
        self.plotter.enable_parallel_projection()
        self.go_to(float(self.times[0]))
        self.plotter.reset_camera()

    def go_to(self, time: float) -> None:
        """Show the beam at a time (s), with the contact force that acts on it."""
        geometry = self.geometry
        k = geometry.index(time)
        surface = geometry.surface(k)
        self.mesh.points = surface.points
        self.mesh.point_data[self.shown] = np.nan_to_num(surface.arrays[self._quantity]) / self._size
        force = np.nan_to_num(sum(geometry.contact_forces(k)))
        size = float(np.linalg.norm(force))
        shown = size > 1e-3 * geometry.peak_force
        self._force.visibility = bool(shown)
        if shown:
            length = _ARROW * geometry.scenario.beam.length * float(np.sqrt(size / geometry.peak_force))
            along = np.append(force / size, 0.0)
            start = geometry.contact_place(k) - length * along
            self.arrow = pv.Arrow(start=start, direction=along, scale=length)
            self._force.mapper.dataset = self.arrow
        state = State(int(geometry.value("state", int(k)))).name
        self._text.set_text("lower_left", f"t = {time:.5f} s  {state}" + (f"  {size:.4g} N" if shown else ""))
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


def show(
    history: History,
    *,
    quantity: Colour = "bending_stress",
    deformation: float | None = None,
    camera: CameraName = "oblique",
    theme: ThemeName = "light",
    size: tuple[int, int] = (1280, 720),
    notebook: bool | None = None,
) -> Any:
    """Open an interactive window on a run: turn and zoom with the mouse, choose the time, play with the space bar.

    Parameters
    ----------
    history : History
        Of a beam.
    quantity : str
        The result in colour.
    deformation : float, optional
        Factor by which the bending is magnified; default: as in pictures.
    camera : {"oblique", "front", "above"}
        Where the camera stands at first.
    theme : {"light", "dark"}
        Colours.
    size : tuple of int
        Of the window (pixels); a view in a notebook is as wide as the page.
    notebook : bool, optional
        Whether this is a notebook, where the window is a view in the page (it needs trame); default: found out.

    Returns
    -------
    object
        In a notebook what it displays, else None, when the window has been closed.

    Raises
    ------
    InputError
        In one line, for what is no history of a beam, a word that is not known, a notebook without trame, or a
        system without a display.

    Examples
    --------
    >>> from oblique_impact import Scenario, simulate
    >>> from renders import show
    >>> show(simulate(Scenario.builtin("paper")))  # doctest: +SKIP
    """
    require_history(history, "show")
    style = Style(size=size, theme=theme, camera=camera, quantity=quantity, deformation=deformation)
    inside = _in_notebook() if notebook is None else notebook
    if inside:
        # trame's part of PyVista: trame alone would be a still picture and a warning
        if importlib.util.find_spec("trame_pyvista") is None:
            raise InputError('show: a view in a notebook needs trame: pip install "oblique-impact[notebook]"')
        prepare()
        viewer = Viewer(history, style, notebook=True)
        # only what is drawn here has a slider; the page gives the width
        page = {"width": "100%", "height": f"{size[1]}px", "collapse_menu": True}
        return viewer.plotter.show(jupyter_backend="server", jupyter_kwargs=page, return_viewer=True)
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise InputError("show: there is no display here; render draws pictures, films and pages without one")
    viewer = Viewer(history, style, notebook=False)
    viewer.plotter.add_timer_event(max_steps=10**9, duration=1000 // _FPS, callback=viewer.step)
    viewer.plotter.show(title="oblique-impact")
    return None


def _in_notebook() -> bool:
    """Whether this is a kernel of Jupyter."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return type(shell).__name__ == "ZMQInteractiveShell"

"""The results that the page can colour the beam by: what they are made of, and their scales over the run."""

from __future__ import annotations

from typing import Any, get_args

import numpy as np
from scipy.interpolate import CubicSpline

from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.player.packing import packed, rounded
from oblique_impact.renders.story import ColourScale, Story, colour_scale
from oblique_impact.renders.style import Colour
from oblique_impact.scenario.shapes import at

#: variables of the history along the beam, their names in the page, and the result whose scale bounds them
_ALONG = {
    "moment": ("frame_moment", "bending_moment"),
    "shear": ("frame_shear", "shear_force"),
    "axial_force": ("frame_axial", "axial_force"),
}
#: over the end of a scale: what is larger has the colour of the end, whatever it is
_BEYOND = 4.0
#: over the length: a larger displacement is out of the picture
_OUT = 2.0


def scales(story: Story) -> dict[str, ColourScale]:
    """Return the scales of all results in colour, as in the other pictures of the run."""
    shown = story.style.quantity
    return {
        name: story.colours if name == shown else colour_scale(story.geometries, name) for name in get_args(Colour)
    }


def along_the_beam(
    geometry: BeamGeometry, samples: Any, found: dict[str, ColourScale]
) -> dict[str, dict[str, Any]]:
    """Return the arrays that shapes and results follow from, at `samples` and all stations.

    Displacements in the floating frame (m), moment (N m) and forces (N); section properties (SI units); and the
    matrix that takes the deflections at the stations to their derivatives along the beam, the rotations.
    """
    stations, sections, history = geometry.stations, geometry.sections, geometry.history
    out = _OUT * geometry.scenario.beam.length
    arrays = {f"frame_{name}": rounded(history[name].values[samples], out) for name in ("ux", "uy")}
    for name, (short, result) in _ALONG.items():
        arrays[short] = rounded(history[name].values[samples], _BEYOND * found[result].limit)
    for name, values in (
        ("place", stations),
        ("radius", sections.fibre_distance(stations)),
        ("area", sections.area(stations)),
        ("second_moment", sections.second_moment(stations)),
        ("derivatives", CubicSpline(stations, np.eye(stations.size))(stations, 1)),
    ):
        arrays[name] = packed(np.broadcast_to(values, np.shape(values) or stations.shape), "f4")
    section = geometry.scenario.beam.section
    if section.shape == "i-beam":  # height of the edges of its web
        height = 0.5 * at(section, "height", stations) - at(section, "flange_thickness", stations)
        arrays["web"] = packed(height, "f4")
    return arrays


def result_facts(story: Story, found: dict[str, ColourScale]) -> list[dict[str, Any]]:
    """Return name, title with unit, limit in the SI unit and ticks of every result."""
    shown = story.style.quantity
    return [
        {
            "name": name,
            "title": scale.title,
            "limit": scale.limit,
            "ticks": scale.ticks,
            "shown": name == shown,
        }
        for name, scale in found.items()
    ]

"""The meshes of a frame with their results, and the field data that say what they are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from oblique_impact.renders.geometry import QUANTITIES, BeamGeometry
from oblique_impact.renders.meshes import surface_mesh
from oblique_impact.renders.metadata import made_by, warnings_of
from oblique_impact.renders.scenery import pin, slope_wedge
from oblique_impact.renders.story import Story

Array = NDArray[np.float64]

#: units or meanings of the results on the parts, and of the field data of a frame
UNITS = {
    "points": "m",
    **QUANTITIES,
    "displacement": "m, from the initial shape",
    "contact_force": "N, of the slope on the beam: normal_force + friction_force",
    "normal_force": "N",
    "friction_force": "N",
    "gap": "m",
    "depth": "m, compression of the stop itself",
    "gap_rate": "m/s",
    "slip_rate": "m/s",
    "state": "0 free, 1 slip, 2 stick",
    "time": "s",
    "side": "-1 left of a jump, 1 right of it, 0 none",
    "sample": "number in the history",
}
_TIMES = (
    "The frames carry the times of the history exactly. At a jump there are two frames: the left one carries its "
    "time, the right one the next larger double (one ulp). The field 'side' tells them apart."
)


@dataclass(frozen=True)
class Part:
    """A mesh over time: its cells are the same at all samples, points (m) and point arrays may change."""

    name: str
    mesh: Callable[[int], pv.PolyData]  # at a sample of the history
    moves: bool = True  # False: the mesh is the same at all samples


def parts_of(story: Story) -> list[Part]:
    """Return the parts of a run: the beam three times, its pin, and with contact its point and the slope.

    The beam is there as a swept tube, as its axis, a polyline, and in its initial shape.  The last one alone
    carries `displacement`: its points do not move, and Warp By Vector makes them the true shape.  A deformation
    factor magnifies points; results, displacements among them, are never magnified.
    """
    geometry = story.geometries[0]
    rings = np.arange(geometry.places.size)
    start = geometry.true.tube(0)[0]

    def centreline(k: int) -> pv.PolyData:
        line = pv.PolyData(geometry.centreline(k), lines=np.append(rings.size, rings))
        names = [name for name in QUANTITIES if not name.endswith("_stress")]
        return _with(line, {name: geometry.along(name, k) for name in names})

    def reference(k: int) -> pv.PolyData:
        mesh = pv.PolyData(start, faces=geometry.solid.faces)
        return _with(mesh, {"displacement": geometry.true.tube(k)[0] - start})

    parts = [
        Part("surface", lambda k: surface_mesh(geometry, k)),
        Part("centreline", centreline),
        Part("reference", reference),
    ]
    parts.append(_still("pin", pin(geometry)))
    if story.slope is not None:  # last, so that the numbers of the others are always the same
        parts.append(Part("contact_point", lambda k: _contact_point(geometry, k)))
        parts.append(_still("slope", slope_wedge(geometry, story.slope)))
    return parts


def _still(name: str, mesh: pv.PolyData) -> Part:
    """Return what stands still, in triangles, as XDMF has no polygon of many corners, and without arrays."""
    triangles = mesh.triangulate()
    return Part(name, lambda k: pv.PolyData(triangles.points, faces=triangles.faces), moves=False)


def _contact_point(geometry: BeamGeometry, k: int) -> pv.PolyData:
    """Return the contact point at a sample as a vertex with the forces on the beam there."""
    normal, friction = geometry.contact_forces(k)
    vectors = {
        "velocity": np.array([geometry.value("tip_vx", k), geometry.value("tip_vy", k)]),
        "contact_force": normal + friction,
        "normal_force": normal,
        "friction_force": friction,
    }
    arrays = {name: np.append(vector, 0.0)[None] for name, vector in vectors.items()}
    for name in ("gap", "depth", "gap_rate", "slip_rate", "state"):
        arrays[name] = np.array([float(geometry.value(name, k))])
    return _with(pv.PolyData(np.append(geometry.contact_point(k), 0.0)[None]), arrays)


def _with(mesh: pv.PolyData, arrays: dict[str, Array]) -> pv.PolyData:
    """Add point arrays to a mesh."""
    for name, values in arrays.items():
        mesh.point_data[name] = values
    return mesh


def run_fields(story: Story, parts: list[Part]) -> dict[str, str | float]:
    """Return field data that hold for all frames: what made the run, its scenario, events, units and parts."""
    history = story.histories[0]
    return {
        "made_by": made_by([history]),
        "warnings": "\n".join(warnings_of([history])),
        "scenario": history.scenario_toml,
        "events": history.events_csv(),
        "units": "\n".join(f"{name} = {unit}" for name, unit in UNITS.items()),
        "parts": "\n".join(f"{number} = {part.name}" for number, part in enumerate(parts)),
        "times": _TIMES,
        "deformation_factor": story.factor,
    }

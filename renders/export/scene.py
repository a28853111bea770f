"""What every frame of an export shows: parts with their results, and field data that say what they are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from oblique_impact.history import History
from renders.export.selection import Frames
from renders.geometry import QUANTITIES, BeamGeometry
from renders.scenery import pin, slope_wedge

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

FORMAT = "oblique-impact export 1"
#: per frame, besides the arrays on the parts: name -> unit or meaning
FRAME_QUANTITIES = {
    "time": "s",
    "side": "-1 left of a jump, 1 right of it, 0 none",
    "sample": "number in the history",
    "state": "0 free, 1 slip, 2 stick",
    "normal_force": "N",
    "tangential_force": "N",
}
#: variables of a history that an export reads besides those of BeamGeometry
NEEDED = ("time", "theta_dot", "shear", "axial_force", "state", "lambda_n", "lambda_tau")

_TIMES = (
    "The frames carry the times of the history exactly. At a jump the history has two samples with the same "
    "time: the left one keeps it, the right one carries the next larger double (one ulp). The field 'time' holds "
    "the time of the history for both, 'side' tells them apart."
)


def _no_cells() -> Integers:
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True)
class Shape:
    """Points (np, 3) in m and results (np,) or (np, 3) of a part at one sample."""

    points: Array
    arrays: dict[str, Array]


@dataclass(frozen=True)
class Part:
    """Something drawn: cells that never change, and points and results that may.

    Attributes
    ----------
    name : str
        Lower-case letters.
    shape : callable
        The :class:`Shape` at a sample of the history.
    lines, polygons : integer array
        Cells in VTK's form: how many points, then the points.
    moves : bool
        False if the shape is the same at all samples.
    """

    name: str
    shape: Callable[[int], Shape]
    lines: Integers = field(default_factory=_no_cells)
    polygons: Integers = field(default_factory=_no_cells)
    moves: bool = True


@dataclass(frozen=True)
class Scene:
    """All that a writer needs: the parts, the frames, and the field data."""

    geometry: BeamGeometry
    frames: Frames
    parts: tuple[Part, ...]

    @classmethod
    def of(cls, geometry: BeamGeometry, frames: Frames) -> Scene:
        """Return the scene of a beam: its surface, its centreline, and what stands still."""
        still = {"slope": slope_wedge(geometry), "pin": pin(geometry)}
        parts = [static_part(name, mesh) for name, mesh in still.items() if mesh is not None]
        return cls(geometry, frames, (surface_part(geometry), centreline_part(geometry), *parts))

    @property
    def fields(self) -> dict[str, list[str] | float]:
        """Field data that hold for all frames."""
        history = self.geometry.history
        units = {"points": "m", **QUANTITIES, **FRAME_QUANTITIES}
        return {
            "format": [FORMAT],
            "version": [_version()],
            "scenario": [history.scenario_toml],
            "events": [history.events_csv()],
            "units": [f"{name} = {unit}" for name, unit in units.items()],
            "times": [_TIMES],
            "deformation_factor": self.geometry.factor,
        }

    @cached_property
    def frame_fields(self) -> dict[str, NDArray[Any]]:
        """Field data that change, (frames,) each, as named in `FRAME_QUANTITIES`."""
        history, frames = self.geometry.history, self.frames

        def values(name: str) -> NDArray[Any]:
            return np.asarray(history[name].values)[frames.sample]

        return {
            "time": frames.time,
            "side": frames.side,
            "sample": frames.sample,
            "state": values("state").astype(np.int64),
            "normal_force": values("lambda_n").astype(float),
            "tangential_force": values("lambda_tau").astype(float),
        }

    def fields_at(self, frame: int) -> dict[str, float]:
        """Field data of one frame."""
        return {name: values[frame].item() for name, values in self.frame_fields.items()}


def surface_part(geometry: BeamGeometry) -> Part:
    """Return the swept tube with all results of `BeamGeometry.surface`."""

    def shape(k: int) -> Shape:
        surface = geometry.surface(k)
        return Shape(surface.points, surface.arrays)

    return Part("surface", shape, polygons=geometry.faces)


def centreline_part(geometry: BeamGeometry) -> Part:
    """Return the axis as one polyline with the results of `BeamGeometry.along`."""
    rings = geometry.places.size

    def shape(k: int) -> Shape:
        return Shape(geometry.centreline(k), geometry.along(k))

    return Part("centreline", shape, lines=np.concatenate([[rings], np.arange(rings)]))


def static_part(name: str, mesh: pyvista.PolyData) -> Part:
    """Return a part that stands still: the surface of `mesh` in triangles, without its arrays."""
    mesh = mesh.triangulate()  # XDMF has no name for a polygon of many corners
    shape = Shape(np.asarray(mesh.points, dtype=float), {})
    return Part(name, lambda k: shape, polygons=np.asarray(mesh.faces, dtype=np.int64), moves=False)


def missing_variables(history: History) -> list[str]:
    """Return the names of the variables that an export needs and the history lacks."""
    return [name for name in NEEDED if name not in history.data.variables]


def _version() -> str:
    try:
        return f"oblique-impact {version('oblique-impact')}"
    except PackageNotFoundError:  # run from a folder that is not installed
        return "oblique-impact"

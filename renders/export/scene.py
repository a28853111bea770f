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
from renders.geometry import QUANTITIES, BeamGeometry, Surface

if TYPE_CHECKING:
    import pyvista

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
class Part:
    """Something drawn: cells that never change, and points and results that may.

    Attributes
    ----------
    name : str
        Lower-case letters.
    shape : callable
        Points (np, 3) in m and arrays (np,) or (np, 3) at a sample of the history.
    lines, polygons : integer array
        Cells in VTK's form: how many points, then the points.
    moves : bool
        False if the shape is the same at all samples.
    """

    name: str
    shape: Callable[[int], Surface]
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
        """Return the scene of a beam: its surface and its centreline."""
        return cls(geometry, frames, (surface_part(geometry), centreline_part(geometry)))

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
    return Part("surface", geometry.surface, polygons=geometry.faces)


def centreline_part(geometry: BeamGeometry) -> Part:
    """Return the axis as one polyline with the results of `BeamGeometry.along`."""
    rings = geometry.places.size

    def shape(k: int) -> Surface:
        return Surface(geometry.centreline(k), geometry.along(k))

    return Part("centreline", shape, lines=np.concatenate([[rings], np.arange(rings)]))


def static_part(name: str, mesh: pyvista.PolyData) -> Part:
    """Return a part that stands still: the points and cells of `mesh` without its arrays."""
    shape = Surface(np.asarray(mesh.points, dtype=float), {})
    lines, polygons = (np.asarray(cells, dtype=np.int64) for cells in (mesh.lines, mesh.faces))
    return Part(name, lambda k: shape, lines, polygons, moves=False)


def missing_variables(history: History) -> list[str]:
    """Return the names of the variables that an export needs and the history lacks."""
    return [name for name in NEEDED if name not in history.data.variables]


def _version() -> str:
    try:
        return f"oblique-impact {version('oblique-impact')}"
    except PackageNotFoundError:  # run from a folder that is not installed
        return "oblique-impact"

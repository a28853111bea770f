"""What every frame of an export shows: parts with their results, and field data that say what they are."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from oblique_impact.renders.exports.selection import Frames
from oblique_impact.renders.geometry import QUANTITIES, BeamGeometry
from oblique_impact.renders.metadata import made_by, warnings_of
from oblique_impact.renders.scenery import pin, slope_wedge
from oblique_impact.renders.story import Story

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

FORMAT = "oblique-impact export 2"
#: results on the parts besides `QUANTITIES`: name -> unit or meaning
_MORE = {
    "displacement": "m, from the initial shape",
    "contact_force": "N, of the slope on the beam: normal_force + friction_force",
    "normal_force": "N",
    "friction_force": "N",
    "gap": "m",
    "depth": "m, compression of the stop itself",
    "gap_rate": "m/s",
    "slip_rate": "m/s",
    "state": "0 free, 1 slip, 2 stick",
}
#: all results on the parts: name -> unit or meaning
RESULTS = QUANTITIES | _MORE
#: per frame, besides the results on the parts: name -> unit or meaning
FRAME_QUANTITIES = {
    "time": "s",
    "side": "-1 left of a jump, 1 right of it, 0 none",
    "sample": "number in the history",
}
_TIMES = (
    "The frames carry the times of the history exactly. At a jump there are two frames: the left one carries its "
    "time, the right one the next larger double (one ulp). The field 'side' tells them apart."
)


@dataclass(frozen=True)
class Shape:
    """Points (np, 3) in m and results (np,) or (np, 3) of a part at one sample."""

    points: Array
    arrays: dict[str, Array]


@dataclass(frozen=True)
class Part:
    """Something drawn: cells of one kind that never change, and points and results that may.

    Cells are in VTK's form: how many points, then the points.
    """

    name: str  # lower-case letters and underscores
    shape: Callable[[int], Shape]  # at a sample of the history
    kind: Literal["verts", "lines", "faces"]
    cells: Integers
    moves: bool = True  # False if points and results are the same at all samples

    @property
    def starts(self) -> Integers:
        """Where the cells begin."""
        starts, at = [], 0
        while at < self.cells.size:
            starts.append(at)
            at += int(self.cells[at]) + 1
        return np.array(starts, dtype=np.int64)


@dataclass(frozen=True)
class Scene:
    """All that a writer needs: the parts, the frames, and the field data."""

    geometry: BeamGeometry
    frames: Frames
    parts: tuple[Part, ...]

    @classmethod
    def of(cls, story: Story, frames: Frames) -> Scene:
        """Return the scene of a run: the beam, the pin, and if there is contact its point and the slope."""
        geometry = story.geometries[0]
        parts = [*beam_parts(geometry), static_part("pin", pin(geometry))]
        if story.slope is not None:  # last, so that the numbers of the others are always the same
            parts += [contact_part(geometry), static_part("slope", slope_wedge(geometry, story.slope))]
        return cls(geometry, frames, tuple(parts))

    @property
    def fields(self) -> dict[str, str | float]:
        """Field data that hold for all frames."""
        history = self.geometry.history
        units = {"points": "m", **RESULTS, **FRAME_QUANTITIES}
        return {
            "format": FORMAT,
            "made_by": made_by([history]),
            "warnings": "\n".join(warnings_of([history])),
            "scenario": history.scenario_toml,
            "events": history.events_csv(),
            "units": "\n".join(f"{name} = {unit}" for name, unit in units.items()),
            "parts": "\n".join(f"{number} = {part.name}" for number, part in enumerate(self.parts)),
            "times": _TIMES,
            "deformation_factor": self.geometry.factor,
        }

    @property
    def frame_fields(self) -> dict[str, NDArray[Any]]:
        """Field data that change, (frames,) each, as named in `FRAME_QUANTITIES`."""
        return {"time": self.frames.time, "side": self.frames.side, "sample": self.frames.sample}

    def fields_at(self, frame: int) -> dict[str, float]:
        """Field data of one frame."""
        return {name: values[frame].item() for name, values in self.frame_fields.items()}


def beam_parts(geometry: BeamGeometry) -> Iterator[Part]:
    """Yield the swept tube, the axis as one polyline, and the initial tube.

    The initial tube alone carries `displacement`: its points do not move, and Warp By Vector makes them the true
    shape.  Drawn points are magnified, displacements never are.
    """
    true = geometry.true
    tube = lru_cache(maxsize=1)(true.surface)
    start = cache(lambda: true.surface(0).points)

    def surface(k: int) -> Shape:
        drawn = tube(k) if true is geometry else geometry.surface(k)
        return Shape(drawn.points, drawn.arrays)

    rings = geometry.places.size
    yield Part("surface", surface, "faces", geometry.faces)
    yield Part(
        "centreline",
        lambda k: Shape(geometry.centreline(k), geometry.along(k)),
        "lines",
        np.concatenate([[rings], np.arange(rings)]),
    )
    yield Part(
        "reference",
        lambda k: Shape(start(), {"displacement": tube(k).points - start()}),
        "faces",
        geometry.faces,
    )


def contact_part(geometry: BeamGeometry) -> Part:
    """Return the contact point as a vertex with the forces on the beam there."""
    # histories of earlier versions have no depth
    scalars = [name for name in ("gap", "depth", "gap_rate", "slip_rate", "state") if name in geometry.history]

    def flat(*vectors: Array) -> list[Array]:
        return [np.append(vector, 0.0)[None] for vector in vectors]

    def shape(k: int) -> Shape:
        velocity = np.array([geometry.value("tip_vx", k), geometry.value("tip_vy", k)])
        normal, friction = geometry.contact_forces(k)
        vectors = flat(geometry.contact_point(k), velocity, normal + friction, normal, friction)
        names = ("velocity", "contact_force", "normal_force", "friction_force")
        arrays = dict(zip(names, vectors[1:], strict=True))
        for name in scalars:
            arrays[name] = np.array([geometry.value(name, k)], dtype=float)
        return Shape(vectors[0], arrays)

    return Part("contact_point", shape, "verts", np.array([1, 0]))


def static_part(name: str, mesh: pyvista.PolyData) -> Part:
    """Return a part that stands still: the surface of `mesh` in triangles, without its arrays."""
    mesh = mesh.triangulate()  # XDMF has no name for a polygon of many corners
    shape = Shape(np.asarray(mesh.points, dtype=float), {})
    return Part(name, lambda k: shape, "faces", np.asarray(mesh.faces, dtype=np.int64), moves=False)

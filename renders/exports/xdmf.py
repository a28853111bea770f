"""XDMF through meshio: NAME.xdmf (what there is) beside NAME.h5 (the numbers), one collection a part.

meshio's writer makes the elements.  Three things are done otherwise: its numbers go into the file beside the
.xdmf, compressed, and not into the current folder; every step refers to the one topology and to points of its
own, where meshio has points that never move; and each step is written out at once, so that memory stays flat.

meshio's `TimeSeriesReader` takes the last collection of a file, so the first part of the scene comes last.
The points of a step are there under the name `position`.  VTK's own XDMF reader holds times less than 1e-7 s
apart for the same, and returns both sides of a jump.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import IO, Any
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

import h5py
import numpy as np
from meshio.xdmf import TimeSeriesWriter
from numpy.typing import NDArray

from oblique_impact.errors import InputError
from renders.exports.heavy import COMPRESSION, heavy_file
from renders.exports.scene import FORMAT, Part, Scene
from renders.exports.target import partial, replace_all

Integers = NDArray[np.int64]

_SMALL = 100  # numbers: fewer are not worth to be packed
_CELLS = {3: "triangle", 4: "quad"}


def write(scene: Scene, target: Path, advance: Callable[[], None]) -> None:
    """Write the frames of `scene` to `target` and the .h5 beside it; `advance` is called after each of them.

    Raises InputError if the .h5 exists and is not one of an export, OSError if something cannot be written.
    """
    heavy = target.with_suffix(".h5")
    _refuse_others(heavy)
    with partial(heavy, target) as (heavy_part, target_part):
        with ExitStack() as stack:
            file = stack.enter_context(heavy_file(heavy_part))
            file.root.attrs["format"] = FORMAT
            writers = []
            for number, part in enumerate(scene.parts):
                light = stack.enter_context(tempfile.TemporaryFile("w+", encoding="utf-8", dir=target.parent))
                writers.append(_Collection(number, part, file.root, heavy.name, light))
            for frame, stamp in enumerate(scene.frames.time):
                for writer in writers:
                    sample = int(scene.frames.sample[frame])
                    writer.write_frame(frame, sample, float(stamp), scene.fields_at(frame))
                file.check()
                advance()
            _assemble(target_part, scene, writers)
        replace_all((heavy_part, heavy), (target_part, target))


class _Collection(TimeSeriesWriter):  # type: ignore[misc]
    """The steps of one part: meshio's elements, written to `light` one by one, their numbers to `heavy`."""

    def __init__(self, number: int, part: Part, heavy: h5py.File, reference: str, light: IO[str]) -> None:
        super().__init__(Path(reference))
        self.part, self.light = part, light
        self._heavy, self._reference = heavy, reference
        self._prefix = part.name
        self._label = "topology"
        holder = ElementTree.Element("Grid")
        self.cells(_blocks(part), holder)
        topology = holder[0]
        corners = {"Polyvertex": "1", "Polyline": "2"}.get(topology.get("TopologyType", ""))
        if corners:
            topology.set("NodesPerElement", corners)  # XDMF asks for it, meshio leaves it out
        self._label = "part"
        self.cell_data({"part": [np.full(len(cells), number) for _, cells in _blocks(part)]}, holder)
        self._topology = list(holder)
        self._constant: list[ElementTree.Element] = []

    def numpy_to_xml_string(self, data: NDArray[Any]) -> str:
        """Store `data` under the current label and return the reference to it."""
        path = f"/{self._prefix}/{self._label}"
        packed = {"chunks": data.shape, **COMPRESSION} if data.size > _SMALL else {}
        self._heavy.create_dataset(path, data=data, **packed)
        return f"{self._reference}:{path}"

    def write_frame(self, frame: int, sample: int, stamp: float, fields: dict[str, float]) -> None:
        """Append the step of one frame."""
        grid = ElementTree.Element("Grid", Name=f"{self.part.name}_{frame:06d}", GridType="Uniform")
        ElementTree.SubElement(grid, "Time", Value=repr(stamp))
        for name, value in fields.items():
            ElementTree.SubElement(grid, "Information", Name=name, Value=repr(value))
        if self.part.moves or not frame:
            self._prefix = f"{self.part.name}/{frame:06d}"
            self._constant = self._elements(sample)
        grid.extend([*self._topology, *self._constant])
        self.light.write(ElementTree.tostring(grid, encoding="unicode") + "\n")

    def _elements(self, sample: int) -> list[ElementTree.Element]:
        shape, holder = self.part.shape(sample), ElementTree.Element("Grid")
        self._label = "position"
        self.points(holder, np.ascontiguousarray(shape.points))
        position = ElementTree.SubElement(
            holder, "Attribute", Name="position", AttributeType="Vector", Center="Node"
        )
        position.append(holder[0][0])  # the same numbers
        for name, values in shape.arrays.items():
            self._label = name
            self.point_data({name: np.ascontiguousarray(values)}, holder)
        return list(holder)


def _blocks(part: Part) -> list[tuple[str, Integers]]:
    """Cells as meshio has them: a polyline as lines of two points, polygons in runs of one size."""
    blocks = []
    if part.vertices.size:
        blocks.append(("vertex", np.stack(_cells(part.vertices))))
    if part.lines.size:
        ends = [np.stack([p[:-1], p[1:]], axis=1) for p in _cells(part.lines)]
        blocks.append(("line", np.concatenate(ends)))
    runs: list[list[Integers]] = []
    for points in _cells(part.polygons):
        if not runs or runs[-1][0].size != points.size:
            runs.append([])
        runs[-1].append(points)
    return blocks + [(_CELLS[run[0].size], np.stack(run)) for run in runs]


def _cells(cells: Integers) -> list[Integers]:
    found, at = [], 0
    while at < cells.size:
        end = at + 1 + int(cells[at])
        found.append(cells[at + 1 : end])
        at = end
    return found


def _assemble(path: Path, scene: Scene, writers: list[_Collection]) -> None:
    """Put the collections into one file, the first part last, under the field data."""
    with path.open("w", encoding="utf-8") as out:
        out.write('<?xml version="1.0" encoding="utf-8"?>\n<Xdmf Version="3.0">\n<Domain>\n')
        for name, value in scene.fields.items():
            text = value if isinstance(value, str) else repr(value)
            out.write(f"<Information Name={quoteattr(name)} Value={quoteattr(text)}/>\n")
        for writer in reversed(writers):
            out.write(f'<Grid Name="{writer.part.name}" GridType="Collection" CollectionType="Temporal">\n')
            writer.light.seek(0)
            shutil.copyfileobj(writer.light, out)
            out.write("</Grid>\n")
        out.write("</Domain>\n</Xdmf>\n")


def _refuse_others(heavy: Path) -> None:
    """Raise InputError if the .h5 that is about to be replaced is not one of an export."""
    if not heavy.exists():
        return
    try:
        with h5py.File(heavy, "r") as file:
            ours = str(file.attrs.get("format", "")).startswith(FORMAT.rstrip("0123456789"))
    except OSError:
        ours = False
    if not ours:
        raise InputError(f"--out: {heavy} is in the way and is not of an export: choose another name")

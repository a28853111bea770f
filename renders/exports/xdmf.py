"""XDMF: NAME.xdmf (what there is) beside NAME.h5 (the numbers), one collection a part.

meshio's `TimeSeriesReader` takes the last collection of a file, so the first part of the scene comes last, and it
does not know points that move: those of a step are there once more under the name `position`.  meshio's writer
would leave its numbers in the current folder and write the points once.  VTK's own XDMF reader holds times less
than 1e-7 s apart for the same, and returns both sides of a jump.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape, quoteattr

import h5py
import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import InputError
from oblique_impact.renders.exports.scene import Part, Scene
from oblique_impact.renders.exports.target import COMPRESSION, HDF5_VERSIONS, whole

Integers = NDArray[np.int64]

_SMALL = 100  # numbers: fewer are not worth to be packed


def write(scene: Scene, target: Path, advance: Callable[[], None]) -> None:
    """Write the frames of `scene` to `target` and the .h5 beside it; `advance` is called after each of them.

    Raises InputError if the .h5 exists and is not one of an export, OSError if something cannot be written.
    """
    heavy, frames = target.with_suffix(".h5"), scene.frames
    if heavy.exists() and not target.exists():
        raise InputError(f"--out: {heavy} is in the way and is not of an export: choose another name")
    with whole(heavy, target) as (heavy_part, light_part):
        with h5py.File(heavy_part, "w", libver=HDF5_VERSIONS) as root:
            collections = [_Collection(n, part, root, heavy.name) for n, part in enumerate(scene.parts)]
            for frame, sample in enumerate(frames.sample.tolist()):
                for collection in collections:
                    collection.store(frame, sample)
                advance()
        with light_part.open("w", encoding="utf-8") as light:
            light.write('<?xml version="1.0" encoding="utf-8"?>\n<Xdmf Version="3.0">\n<Domain>\n')
            light.writelines(_information(scene.fields))
            for collection in reversed(collections):
                name = collection.part.name
                light.write(f'<Grid Name="{name}" GridType="Collection" CollectionType="Temporal">\n')
                for frame, stamp in enumerate(frames.time.tolist()):
                    light.write(f'<Grid Name="{name}_{frame:06d}" GridType="Uniform"><Time Value="{stamp!r}"/>\n')
                    light.writelines(_information(scene.fields_at(frame)))
                    light.writelines(collection.elements(frame))
                    light.write("</Grid>\n")
                light.write("</Grid>\n")
            light.write("</Domain>\n</Xdmf>\n")


def _information(fields: dict[str, Any]) -> Iterator[str]:
    for name, value in fields.items():
        yield f"<Information Name={quoteattr(name)} Value={quoteattr(str(value))}/>\n"


class _Collection:
    """The steps of one part: their numbers go to `heavy`, which the elements call `reference`."""

    def __init__(self, number: int, part: Part, heavy: h5py.File, reference: str) -> None:
        self.part, self._heavy, self._reference = part, heavy, reference
        self._items: dict[str, str] = {}  # elements with the path of the first frame
        form, count, cells = _topology(part)
        group = heavy.create_group(part.name)
        topology = self._item(group, "topology", cells)
        owners = self._item(group, "part", np.full(count, number))
        self._constant = (
            f'<Topology {form} NumberOfElements="{count}">{topology}</Topology>\n'
            f'<Attribute Name="part" AttributeType="Scalar" Center="Cell">{owners}</Attribute>\n'
        )

    def _item(self, group: h5py.Group, name: str, values: NDArray[Any]) -> str:
        """Store numbers in a group and return the element that refers to them."""
        packed = {"chunks": values.shape, **COMPRESSION} if values.size > _SMALL else {}
        group.create_dataset(name, data=values, **packed)
        kind, shape = "Int" if values.dtype.kind == "i" else "Float", " ".join(map(str, values.shape))
        return (
            f'<DataItem DataType="{kind}" Dimensions="{shape}" Format="HDF" Precision="8">'
            f"{escape(f'{self._reference}:{group.name}/{name}')}</DataItem>"
        )

    def store(self, frame: int, sample: int) -> None:
        """Store points and results of a frame; those of a part that stands still once."""
        if self.part.moves or not frame:
            shape, group = self.part.shape(sample), self._heavy.create_group(f"{self.part.name}/{frame:06d}")
            for name, values in {"position": shape.points, **shape.arrays}.items():
                item = self._item(group, name, values)
                self._items.setdefault(name, item)

    def elements(self, frame: int) -> Iterator[str]:
        """Yield the elements of a frame."""
        yield self._constant
        for name, first in self._items.items():
            item = first.replace("/000000/", f"/{frame:06d}/") if self.part.moves else first
            if name == "position":
                yield f'<Geometry GeometryType="XYZ">{item}</Geometry>\n'
            kind = "Vector" if ' 3" Format' in item else "Scalar"
            yield f'<Attribute Name="{name}" AttributeType="{kind}" Center="Node">{item}</Attribute>\n'


def _topology(part: Part) -> tuple[str, int, Integers]:
    """Return the kind of the cells, how many they are, and their points: a polyline as lines of two points."""
    if part.kind == "verts":
        return 'TopologyType="Polyvertex" NodesPerElement="1"', part.cells.size // 2, part.cells[1::2, None]
    if part.kind == "lines":
        pairs = np.stack([part.cells[1:-1], part.cells[2:]], axis=1)
        return 'TopologyType="Polyline" NodesPerElement="2"', len(pairs), pairs
    starts, cells = part.starts, part.cells.copy()
    cells[starts] += 1  # XDMF's number of a triangle is 4, that of a quadrilateral 5
    return 'TopologyType="Mixed"', starts.size, cells

"""VTKHDF: one file, topology once, points and results per frame, times in double precision.

It is written through h5py because VTK's own writer stores times in single precision.  All parts are in one
vtkUnstructuredGrid, and the cell array `part` tells them apart: VTK 9.7 reads only the first step of composite
data.  VTK before 9.3 knows neither steps nor vtkPolyData: it reads the first frame of an unstructured grid.
Results that a part does not carry are 0 there.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from oblique_impact.renders.exports.scene import RESULTS, Scene, Shape
from oblique_impact.renders.exports.target import COMPRESSION, HDF5_VERSIONS, whole

Integers = NDArray[np.int64]

_VERSION = (2, 0)  # of VTKHDF: the first one with steps
_STRING = h5py.string_dtype("ascii")  # VTK reads no other; the bytes are UTF-8 all the same
#: types of VTK: a vertex, a polyline, and polygons of so many corners
_VERTEX, _POLYLINE, _POLYGONS = 1, 4, {3: 5, 4: 9}


def write(scene: Scene, target: Path, advance: Callable[[], None]) -> None:
    """Write the frames of `scene` to the file `target`; `advance` is called after each of them.

    Raises OSError if it cannot be written.
    """
    with (
        whole(target) as (part,),
        h5py.File(part, "w", libver=HDF5_VERSIONS) as root,
    ):
        _Writer(root.create_group("VTKHDF"), scene).write(advance)


class _Writer:
    """Fills the group VTKHDF: everything but points and results first, then frame after frame."""

    def __init__(self, root: h5py.Group, scene: Scene) -> None:
        self._root, self._scene = root, scene
        self._frames = scene.frames.sample.size
        self._still = {part.name: part.shape(0) for part in scene.parts if not part.moves}
        shapes = self._shapes(int(scene.frames.sample[0]))
        self._sizes = [shape.points.shape[0] for shape in shapes]
        self._arrays = {name: values.shape[1:] for shape in shapes for name, values in shape.arrays.items()}

    def write(self, advance: Callable[[], None]) -> None:
        root, steps = self._root, self._root.create_group("Steps")
        root.attrs["Version"] = _VERSION
        root.attrs.create("Type", np.bytes_("UnstructuredGrid"))
        self._write_steps(steps)
        self._write_cells(steps)
        self._write_fields(steps)
        points = self._per_frame(root, "Points", (3,), "m")
        results = root.create_group("PointData")
        datasets = {
            name: self._per_frame(results, name, tail, RESULTS[name]) for name, tail in self._arrays.items()
        }
        offsets = steps.create_group("PointDataOffsets")
        size = sum(self._sizes)
        for name in datasets:
            offsets[name] = size * np.arange(self._frames)
        for frame, sample in enumerate(self._scene.frames.sample):
            shapes = self._shapes(int(sample))
            rows = slice(frame * size, (frame + 1) * size)
            points[rows] = np.concatenate([shape.points for shape in shapes])
            for name, dataset in datasets.items():
                dataset[rows] = self._joined(name, shapes)
            advance()

    def _shapes(self, sample: int) -> list[Shape]:
        return [self._still.get(part.name) or part.shape(sample) for part in self._scene.parts]

    def _joined(self, name: str, shapes: list[Shape]) -> NDArray[np.float64]:
        """Values of a result on all parts, 0 on those that do not carry it."""
        return np.concatenate(
            [
                shape.arrays[name] if name in shape.arrays else np.zeros((size, *self._arrays[name]))
                for shape, size in zip(shapes, self._sizes, strict=True)
            ]
        )

    def _per_frame(self, group: h5py.Group, name: str, tail: tuple[int, ...], unit: str) -> h5py.Dataset:
        """Return a dataset with the values of all frames one after the other, a chunk a frame."""
        size = sum(self._sizes)
        shape, chunk = (self._frames * size, *tail), (size, *tail)
        dataset = group.create_dataset(name, shape, "f8", chunks=chunk, **COMPRESSION)
        dataset.attrs["units"] = unit
        return dataset

    def _write_steps(self, steps: h5py.Group) -> None:
        count, size = self._frames, sum(self._sizes)
        nothing = np.zeros(count, dtype=np.int64)
        steps.attrs["NSteps"] = count
        steps["Values"] = self._scene.frames.time
        steps["PointOffsets"] = size * np.arange(count)
        steps["PartOffsets"] = nothing
        steps["NumberOfParts"] = nothing + 1
        steps["CellOffsets"] = steps["ConnectivityIdOffsets"] = nothing
        self._root["NumberOfPoints"] = [size]

    def _write_cells(self, steps: h5py.Group) -> None:
        """Cells of all parts, once; the offsets of every step point to them."""
        first, root = np.cumsum([0, *self._sizes]), self._root
        points, counts, types, owners = [], [], [], []
        for number, part in enumerate(self._scene.parts):
            starts = part.starts
            sizes = part.cells[starts]
            points.append(np.delete(part.cells, starts) + first[number])
            counts.append(sizes)
            owners.append(np.full(sizes.size, number))
            single = {"verts": _VERTEX, "lines": _POLYLINE}.get(part.kind)
            types += [single or _POLYGONS[size] for size in sizes.tolist()]
        root["Connectivity"] = np.concatenate(points).astype(np.int64)
        root["Offsets"] = np.concatenate([[0], np.cumsum(np.concatenate(counts))]).astype(np.int64)
        root["Types"] = np.array(types, dtype=np.uint8)
        root["NumberOfConnectivityIds"] = [root["Connectivity"].size]
        root["NumberOfCells"] = [len(types)]
        root.create_group("CellData")["part"] = np.concatenate(owners)
        steps.create_group("CellDataOffsets")["part"] = np.zeros(self._frames, dtype=np.int64)

    def _write_fields(self, steps: h5py.Group) -> None:
        group = self._root.create_group("FieldData")
        offsets, sizes = steps.create_group("FieldDataOffsets"), steps.create_group("FieldDataSizes")
        for name, value in self._scene.fields.items():
            if isinstance(value, str):
                # bytes, not text: they pass unchanged under the label that VTK expects
                group.create_dataset(name, data=[value.encode()], dtype=_STRING)
            else:
                group[name] = [value]
            offsets[name] = np.zeros(self._frames, dtype=np.int64)
            sizes[name] = np.ones((self._frames, 2), dtype=np.int64)
        for name, values in self._scene.frame_fields.items():
            group[name] = values
            offsets[name] = np.arange(self._frames)
            sizes[name] = np.ones((self._frames, 2), dtype=np.int64)

"""What the readers of others make of an export: one list of frames, whatever the format."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import meshio
import numpy as np
import pyvista as pv
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline
from vtkmodules.vtkIOHDF import vtkHDFReader


@dataclass
class Mesh:
    points: np.ndarray
    arrays: dict[str, np.ndarray]
    cells: dict[str, list[list[int]]]


@dataclass
class Frame:
    stamp: float
    parts: dict[str, Mesh] = field(default_factory=dict)
    fields: dict[str, Any] = field(default_factory=dict)


def read(path: Path) -> list[Frame]:
    return {".pvd": read_pvd, ".vtkhdf": read_vtkhdf, ".xdmf": read_xdmf}[path.suffix](path)


def read_pvd(path: Path) -> list[Frame]:
    reader = pv.PVDReader(str(path))
    frames = []
    for stamp in reader.time_values:
        reader.set_active_time_value(stamp)
        frame = Frame(stamp)
        entries = reader.active_datasets
        for entry, mesh in zip(entries, reader.read(), strict=True):
            name = Path(entry.path).name.rsplit("_", 1)[0]
            frame.parts[name] = _mesh(mesh)
            frame.fields.update(_fields(mesh))
        frames.append(frame)
    return frames


def read_vtkhdf(path: Path) -> list[Frame]:
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    frames = []
    for stamp in _times(reader):
        assert reader.UpdateTimeStep(stamp)
        mesh = pv.wrap(reader.GetOutputDataObject(0))
        frame = Frame(stamp, fields=_fields(mesh))
        for entry in frame.fields["parts"].splitlines():
            number, name = entry.split(" = ")
            frame.parts[name] = _mesh(mesh, int(number))
        frames.append(frame)
    return frames


def read_xdmf(path: Path) -> list[Frame]:
    """Through meshio; of the collections of a file its reader takes the last, the others are chosen by hand."""
    domain = ElementTree.parse(path).getroot()[0]
    fields = {entry.get("Name"): entry.get("Value") for entry in domain.findall("Information")}
    frames: list[Frame] = []
    names = [grid.get("Name") for grid in domain.findall("Grid")]
    for name in names:
        with meshio.xdmf.TimeSeriesReader(path) as reader:
            if name != names[-1]:
                reader.collection = list(reader.domain.find(f"Grid[@Name='{name}']"))
                reader.mesh_grid = reader.collection[0]
            points, cells = reader.read_points_cells()
            count = reader.num_steps
            frames = frames or [Frame(np.nan) for _ in range(count)]
            found = {
                kind: [points for type in types for b in cells if b.type == type for points in b.data.tolist()]
                for kind, types in CELLS.items()
            }
            assert len(frames) == count == len(reader.collection)
            for k, frame in enumerate(frames):
                stamp, arrays, owners = reader.read_data(k)
                assert np.isnan(frame.stamp) or frame.stamp == stamp
                frame.stamp = stamp
                place = arrays.pop("position")
                assert len(np.unique(np.concatenate(owners["part"]))) == 1
                if k == 0:
                    np.testing.assert_array_equal(points, place)
                frame.parts[name] = Mesh(place, arrays, found)
                frame.fields = fields | {
                    entry.get("Name"): float(entry.get("Value"))
                    for entry in reader.collection[k].findall("Information")
                }
    return frames


CELLS = {"verts": ("vertex",), "lines": ("line",), "faces": ("quad", "triangle")}


def read_xdmf_by_vtk(path: Path) -> list[tuple[float, dict[str, list[Any]]]]:
    """Per time the meshes by collection: two right at a jump, whose sides this reader cannot tell apart."""
    reader = pv.XdmfReader(str(path))
    found = []
    for stamp in reader.time_values:
        reader.set_active_time_value(stamp)
        blocks = reader.read()
        meshes = {name: blocks[name] for name in blocks.keys()}  # noqa: SIM118  a MultiBlock is no mapping
        found.append(
            (stamp, {n: list(m) if isinstance(m, pv.MultiBlock) else [m] for n, m in meshes.items()}),
        )
    return found


def _times(reader: Any) -> list[float]:
    reader.UpdateInformation()
    information = reader.GetOutputInformation(0)
    key = Pipeline.TIME_STEPS()
    return [information.Get(key, k) for k in range(information.Length(key))]


def _fields(mesh: Any) -> dict[str, Any]:
    data = mesh.GetFieldData()
    found: dict[str, Any] = {}
    for k in range(data.GetNumberOfArrays()):
        array = data.GetAbstractArray(k)
        if array.IsA("vtkStringArray"):
            assert array.GetNumberOfValues() == 1
            found[array.GetName()] = array.GetValue(0)
        else:
            found[array.GetName()] = vtk_to_numpy(array)[0].item()
    return found


def _mesh(mesh: Any, part: int | None = None) -> Mesh:
    """The mesh, or the cells of one part of it with the points they use, numbered from 0."""
    if part is None:
        arrays = {name: np.array(mesh.point_data[name]) for name in mesh.point_data}
        return Mesh(np.array(mesh.points), arrays, {kind: _unpack(getattr(mesh, kind)) for kind in CELLS})
    chosen = np.flatnonzero(np.array(mesh.cell_data["part"]) == part)
    corners, types = mesh.cell_connectivity, mesh.celltypes
    ends = vtk_to_numpy(mesh.GetCells().GetOffsetsArray())
    used = np.unique(np.concatenate([corners[ends[k] : ends[k + 1]] for k in chosen]))
    first = int(used[0])
    assert used.size == used[-1] - first + 1

    def of(*kinds: pv.CellType) -> list[list[int]]:
        numbers = chosen[np.isin(types[chosen], kinds)]
        return [(corners[ends[k] : ends[k + 1]] - first).tolist() for k in numbers]

    return Mesh(
        np.array(mesh.points)[used],
        {name: np.array(mesh.point_data[name])[used] for name in mesh.point_data},
        {
            "verts": of(pv.CellType.VERTEX),
            "lines": of(pv.CellType.POLY_LINE),
            "faces": of(pv.CellType.TRIANGLE, pv.CellType.QUAD),
        },
    )


def _unpack(cells: np.ndarray) -> list[list[int]]:
    found, at, numbers = [], 0, cells.tolist()
    while at < len(numbers):
        end = at + 1 + numbers[at]
        found.append(numbers[at + 1 : end])
        at = end
    return found

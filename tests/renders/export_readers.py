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


@dataclass
class Mesh:
    points: np.ndarray
    arrays: dict[str, np.ndarray]
    cells: int


@dataclass
class Frame:
    stamp: float
    parts: dict[str, Mesh] = field(default_factory=dict)
    fields: dict[str, Any] = field(default_factory=dict)


def read(path: Path) -> list[Frame]:
    return {".pvd": read_pvd, ".xdmf": read_xdmf}[path.suffix](path)


def read_pvd(path: Path) -> list[Frame]:
    """Through PyVista."""
    reader = pv.PVDReader(str(path))
    frames = []
    for stamp in reader.time_values:
        reader.set_active_time_value(stamp)
        frame = Frame(stamp)
        for entry, mesh in zip(reader.active_datasets, reader.read(), strict=True):
            arrays = {name: np.array(mesh.point_data[name]) for name in mesh.point_data}
            frame.parts[Path(entry.path).name.rsplit("_", 1)[0]] = Mesh(
                np.array(mesh.points), arrays, mesh.n_cells
            )
            frame.fields.update(_fields(mesh))
        frames.append(frame)
    return frames


def _fields(mesh: Any) -> dict[str, Any]:
    data = mesh.GetFieldData()
    arrays = [data.GetAbstractArray(k) for k in range(data.GetNumberOfArrays())]
    return {
        array.GetName(): array.GetValue(0) if array.IsA("vtkStringArray") else vtk_to_numpy(array)[0].item()
        for array in arrays
    }


def read_xdmf(path: Path) -> list[Frame]:
    """Through meshio; of the collections of a file its reader takes the last, the others are chosen by hand."""
    domain = ElementTree.parse(path).getroot()[0]
    fields = {entry.get("Name"): entry.get("Value") for entry in domain.findall("Information")}
    frames: dict[float, Frame] = {}
    for collection in domain.findall("Grid"):
        with meshio.xdmf.TimeSeriesReader(path) as reader:
            reader.collection = list(reader.domain.find(f"Grid[@Name='{collection.get('Name')}']"))
            for k, grid in enumerate(reader.collection):
                reader.mesh_grid = grid
                points, cells = reader.read_points_cells()
                stamp, arrays, _ = reader.read_data(k)
                frame = frames.setdefault(stamp, Frame(stamp, fields=dict(fields)))
                frame.parts[collection.get("Name")] = Mesh(points, arrays, sum(map(len, cells)))
                frame.fields |= {e.get("Name"): float(e.get("Value")) for e in grid.findall("Information")}
    return list(frames.values())

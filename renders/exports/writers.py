"""Writers of PVD, XDMF and CSV; each returns the files or folders that it made, the one to open last."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import chdir
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import meshio
import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkCommonCore import vtkStringArray

from oblique_impact.history.history import History
from oblique_impact.renders.exports.command import sides
from oblique_impact.renders.exports.parts import parts_of, run_fields
from oblique_impact.renders.story import Story

Integers = NDArray[np.int64]
OnFrame = Callable[[int], None]  # called with the number of frames done


def write_pvd(story: Story, samples: Integers, folder: Path, name: str, on_frame: OnFrame) -> list[Path]:
    """Write `name`.pvd, ParaView's list of files, and the folder `name` with a .vtp file per part and frame.

    Slope and pin are written once, and with the pin the field data that hold for all frames.
    """
    parts, frames = parts_of(story), folder / name
    frames.mkdir()
    collection = ElementTree.Element("VTKFile", type="Collection", version="1.0")
    entries = ElementTree.SubElement(collection, "Collection")
    for frame, fields in enumerate(_frame_fields(story.histories[0], samples)):
        for number, part in enumerate(parts):
            file = frames / f"{part.name}_{frame if part.moves else 0:06d}.vtp"
            if part.moves or frame == 0:
                mesh = part.mesh(fields["sample"])
                mesh.cell_data["part"] = np.full(mesh.n_cells, number)
                _add_fields(mesh, fields if part.moves else run_fields(story, parts))
                mesh.save(file, recompute_normals=False)
            place = f"{name}/{file.name}"
            entry = {"timestep": repr(fields["time"]), "part": str(number), "name": part.name, "file": place}
            ElementTree.SubElement(entries, "DataSet", entry)
        on_frame(frame + 1)
    index = folder / f"{name}.pvd"
    ElementTree.ElementTree(collection).write(index, encoding="utf-8", xml_declaration=True)
    return [frames, index]


def _add_fields(mesh: pv.PolyData, fields: Mapping[str, str | float]) -> None:
    for name, value in fields.items():
        if isinstance(value, str):
            array = vtkStringArray()  # PyVista's own take ASCII alone
            array.SetName(name)
            array.InsertNextValue(value)
            mesh.GetFieldData().AddArray(array)
        else:
            mesh.field_data[name] = [value]


class _CompressedWriter(meshio.xdmf.TimeSeriesWriter):  # type: ignore[misc]
    """meshio's writer with compressed numbers: a third of the size."""

    def numpy_to_xml_string(self, data: NDArray[Any]) -> str:
        """Store numbers in the .h5 file and return where they are."""
        name = f"data{self.data_counter}"
        self.data_counter += 1
        packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True, "chunks": data.shape}
        self.h5_file.create_dataset(name, data=data, **(packed if data.size > 100 else {}))
        return f"{self.h5_filename}:/{name}"


def write_xdmf(story: Story, samples: Integers, folder: Path, name: str, on_frame: OnFrame) -> list[Path]:
    """Write `name`.xdmf and `name`.h5 through meshio, a collection of grids per part.

    meshio's `TimeSeriesReader` takes the last collection of a file and knows no points that move: so the surface
    comes last, and its points are there once more as the point array `position`.
    """
    parts = parts_of(story)
    with chdir(folder), _CompressedWriter(f"{name}.xdmf") as writer:  # its .h5 goes to the current folder
        _add_information(writer.domain, run_fields(story, parts))
        writer.domain.remove(writer.collection)
        kind = {"GridType": "Collection", "CollectionType": "Temporal"}
        collections = {
            part.name: ElementTree.SubElement(writer.domain, "Grid", kind, Name=part.name)
            for part in reversed(parts)
        }
        cells = {part.name: _cells(writer, part.mesh(int(samples[0])), n) for n, part in enumerate(parts)}
        for frame, fields in enumerate(_frame_fields(story.histories[0], samples)):
            for part in parts:
                attributes = {"Name": f"{part.name}_{frame:06d}", "GridType": "Uniform"}
                grid = ElementTree.SubElement(collections[part.name], "Grid", attributes)
                ElementTree.SubElement(grid, "Time", Value=repr(fields["time"]))
                _add_information(grid, fields)
                mesh = part.mesh(fields["sample"])
                grid.extend(cells[part.name])
                writer.points(grid, np.asarray(mesh.points))
                position = {"position": np.asarray(mesh.points)} if part is parts[0] else {}
                writer.point_data(dict(mesh.point_data) | position, grid)
            on_frame(frame + 1)
    return [folder / f"{name}.h5", folder / f"{name}.xdmf"]


def _cells(writer: Any, mesh: pv.PolyData, number: int) -> list[Any]:
    """Return the elements of a part's cells, which all of its frames share, and of their cell array `part`."""
    element = ElementTree.Element("Grid")
    if mesh.n_lines:  # meshio has no polyline
        corners = mesh.lines[1:]
        blocks = [meshio.CellBlock("line", np.stack([corners[:-1], corners[1:]], axis=1))]
    else:
        blocks = pv.to_meshio(mesh).cells
    writer.cells(blocks, element)
    if len(blocks) == 1:
        element[0].set("NodesPerElement", str(blocks[0].data.shape[1]))  # VTK wants it of lines and vertices
    writer.cell_data({"part": [np.full(len(block), number) for block in blocks]}, element)
    return list(element)


def _add_information(parent: Any, fields: Mapping[str, str | float]) -> None:
    for key, value in fields.items():
        ElementTree.SubElement(parent, "Information", Name=key, Value=str(value))


def _frame_fields(history: History, samples: Integers) -> list[dict[str, Any]]:
    """Return the field data of each frame: time (s), side of a jump, number of the sample."""
    times = history["time"].values
    side = sides(times)
    return [{"time": float(times[k]), "side": int(side[k]), "sample": int(k)} for k in samples]


def write_csv(story: Story, samples: Integers, folder: Path, name: str, on_frame: OnFrame) -> list[Path]:
    """Write the variables over time as the table `name`.csv: a row per sample, units in the first line."""
    history = story.histories[0]

    def with_unit(column: str) -> str:
        variable = column if column in history else column.rpartition("_")[0]  # q_0, q_1 ... of q
        return f"{column} ({history[variable].attrs.get('units', '1')})"

    file = folder / f"{name}.csv"
    history.time_series.iloc[samples].rename(columns=with_unit).to_csv(file, index=False)
    on_frame(samples.size)
    return [file]

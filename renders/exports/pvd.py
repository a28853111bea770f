"""ParaView's collection: NAME.pvd, and a folder NAME/ beside it with a compressed .vtp per part and frame.

Slope and pin are written once, and with them the field data that hold for all frames.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import pyvista as pv
from vtkmodules.vtkCommonCore import vtkStringArray
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

from oblique_impact.errors import InputError
from oblique_impact.renders.exports.scene import Part, Scene
from oblique_impact.renders.exports.target import whole

_OURS = re.compile(r"[a-z_]+_\d{6,}\.vtp")
_LEVEL = 1  # of zlib: a level higher costs more time than it saves space


def write(scene: Scene, target: Path, advance: Callable[[], None]) -> None:
    """Write the frames of `scene` to the .pvd file `target`; `advance` is called after each of them.

    The folder of a former export of this name is replaced; nothing else is ever removed.  Raises InputError if
    the folder holds other files, OSError if something cannot be written.
    """
    folder = target.with_suffix("")
    _refuse_others(folder)
    with whole(folder, target) as (folder_part, target_part):
        folder_part.mkdir()
        writers = [_PartWriter(number, part, scene.fields, folder_part) for number, part in enumerate(scene.parts)]
        with target_part.open("w", encoding="utf-8") as index:
            index.write('<?xml version="1.0"?>\n<VTKFile type="Collection" version="1.0">\n<Collection>\n')
            for frame, stamp in enumerate(scene.frames.time):
                for number, writer in enumerate(writers):
                    name = writer.write(frame, int(scene.frames.sample[frame]), scene.fields_at(frame))
                    index.write(
                        f'<DataSet timestep="{float(stamp)!r}" part="{number}" name="{writer.part.name}" '
                        f"file={quoteattr(f'{folder.name}/{name}')}/>\n"
                    )
                advance()
            index.write("</Collection>\n</VTKFile>\n")


class _PartWriter:
    """Writes the frames of one part; the mesh is made once and its values are replaced."""

    def __init__(self, number: int, part: Part, fields: dict[str, str | float], folder: Path) -> None:
        self.part = part
        self._number = number
        self._folder = folder
        self._mesh = pv.PolyData()
        # what holds for all frames goes where it is written once
        for name, value in () if part.moves else fields.items():
            self._add_field(name, value)
        self._writer = vtkXMLPolyDataWriter()
        self._writer.SetInputData(self._mesh)
        self._writer.SetDataModeToAppended()
        self._writer.EncodeAppendedDataOff()
        self._writer.SetCompressorTypeToZLib()
        self._writer.SetCompressionLevel(_LEVEL)
        # into memory: VTK would report a full disk on standard error, Python raises
        self._writer.WriteToOutputStringOn()

    def write(self, frame: int, sample: int, fields: dict[str, float]) -> str:
        """Write a frame and return the file's name; a part that stands still is written once."""
        if not self.part.moves and frame:
            return f"{self.part.name}_{0:06d}.vtp"
        shape = self.part.shape(sample)
        mesh = self._mesh
        mesh.points = shape.points
        if not frame:
            setattr(mesh, self.part.kind, self.part.cells)
            mesh.cell_data["part"] = np.full(mesh.n_cells, self._number)
        for name, values in shape.arrays.items():
            mesh.point_data[name] = values
        if self.part.moves:
            for name, value in fields.items():
                self._add_field(name, value)
        name = f"{self.part.name}_{frame:06d}.vtp"
        self._writer.Write()
        text = self._writer.GetOutputString()
        (self._folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())
        return name

    def _add_field(self, name: str, value: str | float) -> None:
        if isinstance(value, str):
            array = vtkStringArray()  # PyVista's take ASCII alone
            array.SetName(name)
            array.InsertNextValue(value)
            self._mesh.GetFieldData().AddArray(array)
        else:
            self._mesh.field_data[name] = [value]


def _refuse_others(folder: Path) -> None:
    """Raise InputError if the folder that is about to be replaced holds anything but frames."""
    if folder.exists() and not folder.is_dir():
        raise InputError(f"--out: {folder} is in the way: the frames go into a folder of this name")
    others = sorted(path.name for path in folder.glob("*") if not _OURS.fullmatch(path.name))
    if others:
        raise InputError(f"--out: the folder {folder} holds other files ({others[0]}): choose another name")

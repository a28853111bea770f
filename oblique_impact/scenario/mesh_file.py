"""Meshes of the beam from files: line elements on an axis, in any format that meshio reads."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any

import numpy as np

from oblique_impact.errors import InputError
from oblique_impact.scenario.messages import short

_STRAIGHT = 1e-9  # of the mesh's length: how far a node may lie from the axis


def read_nodes(path: Path) -> list[float]:
    """Read the places (m) along the axis of the nodes of a mesh, ascending; the first element begins at 0.

    Raises InputError if the file cannot be read, has no line elements, or they are no chain on one axis.
    """
    what = f"discretization.mesh = {short(str(path))}"
    if not path.is_file():
        raise InputError(f"{what}: no such file")
    import meshio

    try:
        with contextlib.redirect_stdout(io.StringIO()):  # meshio prints which formats do not fit
            mesh = meshio.read(path)
    except (Exception, SystemExit) as error:  # of many kinds: meshio ends the process over a wrong format
        raise InputError(f"{what}: cannot be read: {' '.join(str(error).split())[:120]}") from None
    lines = [block.data for block in mesh.cells if block.type == "line"]
    if not lines:
        raise InputError(f"{what}: has no line elements")
    ends = np.asarray(mesh.points, dtype=float)[np.concatenate(lines)]
    axis = int(np.argmax(np.ptp(ends, axis=(0, 1))))
    along, aside = ends[..., axis], np.delete(ends, axis, axis=-1)
    if np.ptp(aside, axis=(0, 1)).max(initial=0.0) > _STRAIGHT * np.ptp(along):
        raise InputError(f"{what}: its line elements should lie on one axis of coordinates")
    along = np.sort(along, axis=1)
    first, last = along[np.argsort(along[:, 0])].T
    if not np.array_equal(first[1:], last[:-1]) or np.any(first == last):
        raise InputError(f"{what}: its line elements should follow each other without gaps and overlaps")
    return [float(x) for x in np.append(first, last[-1]) - first[0]]


def take_mesh(data: dict[str, Any], folder: Path) -> None:
    """Replace `discretization.mesh`, a path from `folder`, by its nodes in the data of a scenario.

    Raises InputError as `read_nodes`, or if the nodes are given as well.
    """
    section = data.get("discretization")
    if not isinstance(section, dict) or not isinstance(section.get("mesh"), str) or not section["mesh"]:
        return
    if section.get("nodes"):
        words = "those of discretization.mesh take their place; leave one of them out"
        raise InputError(f"discretization.nodes: {words}")
    section["nodes"] = read_nodes(folder / section.pop("mesh"))

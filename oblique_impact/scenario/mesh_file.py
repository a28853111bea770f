"""Meshes of the beam from files: line elements on an axis, in any format that meshio reads."""

from __future__ import annotations

import contextlib
import io
import logging
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import InputError
from oblique_impact.files import read_text
from oblique_impact.scenario.messages import counted, short

_ROUNDING = 1e-9  # of the mesh's length: how far a node may lie from the axis, ends of neighbours from each other
_log = logging.getLogger(__name__)

_KIND = re.compile(r"^(\*element\b.*\btype\s*=\s*)(\w+)", re.IGNORECASE | re.MULTILINE)
#: kinds of Abaqus with two nodes (linear: 1, cubic: 3) or three (2)
_BEAM = re.compile(r"(?:B[23]|PIPE[23]|ELBOW3)([123])(?:OS)?H?|FRAME[23]D")


def read_nodes(path: Path) -> list[float]:
    """Read the places (m) along the axis of the nodes of a mesh, ascending from the root, which is at 0.

    The root is the end at the origin of coordinates, or else the one with the lower coordinate; a line of this
    module's log says which.  Mid nodes of elements are nodes as well.  Raises InputError if the file cannot be
    read, has no line elements, or they are no chain on one axis.
    """
    what = f"discretization.mesh = {short(str(path))}"
    if not path.is_file():
        raise InputError(f"{what}: no such file")
    elements = _elements(path, what)
    points = np.concatenate([places.reshape(-1, places.shape[-1]) for places in elements])
    axis = int(np.argmax(np.ptp(points, axis=0)))
    first, last, length = points[:, axis].min(), points[:, axis].max(), np.ptp(points[:, axis])
    if np.ptp(np.delete(points, axis, axis=1), axis=0).max(initial=0.0) > _ROUNDING * length:
        raise InputError(f"{what}: its line elements should lie on one axis of coordinates")
    from_last = abs(last) <= _ROUNDING * length
    root, end = (last, first) if from_last else (first, last)
    places = [np.sort(np.abs(of[..., axis] - root), axis=1) for of in elements]
    pieces = np.concatenate([np.stack([of[:, :-1], of[:, 1:]], axis=2).reshape(-1, 2) for of in places])
    begin, finish = pieces[np.argsort(pieces[:, 0])].T
    rounding = _ROUNDING * length
    if np.any(np.abs(begin[1:] - finish[:-1]) > rounding) or np.any(finish - begin <= rounding):
        raise InputError(f"{what}: its line elements should follow each other without gaps and overlaps")
    name, at_origin = "xyz"[axis], abs(root) <= rounding
    mid_nodes = ", mid nodes taken as nodes," if len(begin) > sum(map(len, elements)) else ""
    _log.log(
        logging.INFO if at_origin else logging.WARNING,
        f"{what}: {counted(len(begin), 'element')}{mid_nodes} along {name}; the root is its end at {name} = "
        f"{0.0 if at_origin else root:g} m, the free end at {name} = {end:g} m",
    )
    return [float(x) for x in np.append(begin, finish[-1])]


def _elements(path: Path, what: str) -> list[NDArray[np.float64]]:
    """Return the places of the nodes of line elements, an array (elements, nodes, coordinates) for each block."""
    import meshio

    said, warned = io.StringIO(), io.StringIO()
    try:  # meshio prints what it does not understand, and ends the process over a file that it cannot read
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(warned):
            mesh = meshio.read(_known_kinds(path), "abaqus") if path.suffix == ".inp" else meshio.read(path)
    except (Exception, SystemExit) as error:  # of many kinds
        reason = said.getvalue() if isinstance(error, SystemExit) else str(error)
        reason = " ".join(reason.split())[:120].rstrip(".") or "meshio takes it for another format"
        kinds = "; of Abaqus beams, pipes and trusses of two or three nodes are read, without nodes of orientation"
        raise InputError(f"{what}: cannot be read: {reason}{kinds if path.suffix == '.inp' else ''}") from None
    if "(type 4)" in warned.getvalue():  # it goes on without them, with a part of the beam
        raise InputError(f"{what}: has polylines, which meshio leaves out; write lines of two nodes")
    points = np.asarray(mesh.points, dtype=float)
    blocks = [np.asarray(block.data) for block in mesh.cells if re.fullmatch(r"line\d*", block.type)]
    if not blocks:
        raise InputError(f"{what}: has no line elements")
    numbers = np.concatenate([block.ravel() for block in blocks])
    if not np.all(np.isin(numbers, np.arange(len(points)))):
        raise InputError(f"{what}: its line elements should be of the {len(points)} nodes that it has")
    return [points[block.astype(np.int64)] for block in blocks]  # XDMF without NumberType has floating-point ones


def _known_kinds(path: Path) -> io.StringIO:
    """Return the text of an Abaqus file, its beams renamed to kinds of as many nodes.

    meshio knows a few kinds, takes B33 for one of three nodes, and no small letters.
    """

    def renamed(found: re.Match[str]) -> str:
        kind = found[2].upper()
        if beam := _BEAM.fullmatch(kind):
            kind = "B32" if beam[1] == "2" else "B31"
        return f"{found[1]}{kind}"

    text = io.StringIO(_KIND.sub(renamed, read_text(path)))
    text.name = str(path)  # files that it includes are sought beside it
    return text


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

"""Draw the pictures of the pages: ``python -m docs.pictures.draw [NAME ...]``, in the folder of the sources.

Drawings are SVG (`docs/_ext/two_themes.py` takes their paper away while the site is built), scenes are PNG.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure
from PIL import Image

from . import contacts, mechanics, scenes, sketch, studies
from .paper import FOLDER, save

#: a drawing for each page, by its name
DRAWINGS: dict[str, Callable[[], Figure]] = {
    "sketch": sketch.sketch,
    "kinematics": mechanics.kinematics,
    "motion": mechanics.motion,
    "frames": mechanics.frames,
    "contact": mechanics.contact,
    "algorithm": contacts.algorithm,
    "elastic-stop": contacts.elastic_stop,
    "residual-flexibility": contacts.residual_flexibility,
    "nodal": contacts.nodal,
    "refinement": studies.refinement,
    "results": studies.results,
    "check": studies.check,
    "cluster": studies.cluster,
    "library": studies.library,
    "own-parts": studies.own_parts,
}
#: pictures in pixels
SCENES: dict[str, Callable[[], Image.Image]] = {
    "film": scenes.film,
    "scenario": scenes.scenario,
    "paraview": scenes.paraview,
    "absolute-difference": scenes.absolute_difference,
}


def draw(name: str, folder: Path = FOLDER) -> Path:
    """Draw a picture into a folder; returns its file."""
    if name in DRAWINGS:
        return save(DRAWINGS[name](), name, folder)
    SCENES[name]().save(folder / f"{name}.png", optimize=True)
    return folder / f"{name}.png"


if __name__ == "__main__":
    for wanted in sys.argv[1:] or [*DRAWINGS, *SCENES]:
        print(draw(wanted), flush=True)

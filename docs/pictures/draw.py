"""Draw the pictures of the pages: ``python -m docs.pictures.draw [NAME ...]``, in the folder of the sources.

Drawings are SVG without paper, in colours that read on light and dark pages; pictures of the beam are PNG,
films GIF.
"""

from __future__ import annotations

import shutil
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure
from PIL import Image

from oblique_impact import SimulationWarning

from . import contacts, mechanics, scenes, sketch, studies
from .paper import FOLDER, save

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
    "slap-map": contacts.contact_map,
    "time-stepping": contacts.time_stepping,
    "refinement": studies.refinement,
    "results": studies.results,
}
SCENES: dict[str, Callable[[], Image.Image]] = {
    "film": scenes.film,
    "scenario": scenes.scenario,
    "paraview": scenes.paraview,
}
#: films, each of which writes its file
FILMS: dict[str, Callable[[Path], None]] = {"slap": scenes.slap}


def draw(name: str, folder: Path = FOLDER) -> Path:
    """Draw a picture into a folder; returns its file."""
    if name in DRAWINGS:
        return save(DRAWINGS[name](), name, folder)
    if name in FILMS:
        file = folder / f"{name}.gif"
        FILMS[name](file)
        return file
    file = folder / f"{name}.png"
    SCENES[name]().save(file, optimize=True)
    return file


if __name__ == "__main__":
    warnings.simplefilter("ignore", SimulationWarning)  # the pages say where a model has its limits
    for wanted in sys.argv[1:] or [*DRAWINGS, *SCENES, *FILMS]:
        if wanted == "paraview" and not all(map(shutil.which, ("pvpython", "xvfb-run"))):
            print("paraview: left as it is; it takes pvpython and xvfb-run (Debian: paraview, xvfb)")
        else:
            print(draw(wanted), flush=True)

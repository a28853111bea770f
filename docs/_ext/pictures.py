"""What the gallery needs besides sphinx-gallery: pictures that are files, and the order of reading."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from sphinx_gallery.scrapers import figure_rst

ORDER = (
    "session",
    "paper_case",
    "film_strip",
    "two_discretizations",
    "rigid_stop_modes",
    "damped_stop",
    "elastic_stop",
    "sticking",
    "friction_slope",
    "campbell",
    "own_laws",
    "own_system",
)


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Move the pictures that a block of an example left beside it into the gallery; returns their markup.

    Off-screen pictures of the beam are files from the start, so that figures are written as well.
    """
    moved = []
    for file in sorted(Path(block_vars["src_file"]).parent.glob("*.png")):
        target = next(block_vars["image_path_iterator"])
        shutil.move(file, target)
        moved.append(target)
    title = Path(block_vars["src_file"]).stem.removeprefix("plot_").replace("_", " ")
    return str(figure_rst(moved, gallery_conf["src_dir"], title))


def place(filename: str) -> int:
    """Return the place of an example in the gallery; new ones stand last."""
    name = Path(filename).stem.removeprefix("plot_")
    return ORDER.index(name) if name in ORDER else len(ORDER)

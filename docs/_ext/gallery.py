"""What the gallery needs besides sphinx-gallery: pictures that are files, and the order of reading."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

ORDER = (
    "session",
    "paper_case",
    "stills",
    "ruler",
    "link",
    "strip_falls",
    "panel",
    "two_discretizations",
    "rigid_stop_modes",
    "damped_stop",
    "elastic_stop",
    "sticking",
    "friction_slope",
    "two_pegs",
    "gap",
    "slap",
    "edge",
    "reed",
    "dropped_bar",
    "shaken",
    "stops",
    "cantilever",
    "campbell",
    "roller",
    "own_laws",
    "own_system",
)


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Move the pictures that a block of an example left beside it into the gallery; returns their markup."""
    folder, name = Path(block_vars["src_file"]).parent, example_name(block_vars["src_file"])
    markup = ""
    for file in sorted([*folder.glob("*.png"), *folder.glob("*.svg"), *folder.glob("*.gif")]):
        target = Path(next(block_vars["image_path_iterator"])).with_suffix(file.suffix)
        shutil.move(file, target)
        place = target.relative_to(gallery_conf["src_dir"]).as_posix()
        markup += f"\n.. image:: /{place}\n   :alt: {name.replace('_', ' ')}\n   :class: sphx-glr-single-img\n\n"
    return markup


def place(filename: str) -> int:
    """Return the place of an example in the gallery; new ones stand last."""
    name = example_name(filename)
    return ORDER.index(name) if name in ORDER else len(ORDER)


def example_name(filename: str) -> str:
    """Return the name of an example, as in `ORDER`."""
    return Path(filename).stem.removeprefix("plot_")

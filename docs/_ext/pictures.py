"""What the gallery needs besides sphinx-gallery: pictures that are files, and the order of reading."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

from two_themes import twin_of

from oblique_impact import renders
from oblique_impact.renders import Rendered, Style
from oblique_impact.renders.command import render

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
    """Move the pictures that a block of an example left beside it into the gallery; returns their markup."""
    folder, title = Path(block_vars["src_file"]).parent, Path(block_vars["src_file"]).stem.removeprefix("plot_")
    markup = ""
    for file in sorted([*folder.glob("*.png"), *folder.glob("*.svg")]):
        if file.stem.endswith("-dark"):
            continue
        target = Path(next(block_vars["image_path_iterator"])).with_suffix(file.suffix)
        shutil.move(file, target)
        if twin_of(file).exists():
            shutil.move(twin_of(file), twin_of(target))
        place = target.relative_to(gallery_conf["src_dir"]).as_posix()
        markup += f"\n.. image:: /{place}\n   :alt: {title.replace('_', ' ')}\n   :class: sphx-glr-single-img\n\n"
    return markup


def draw_both(gallery_conf: dict[str, Any], file: str) -> None:
    """Let `renders.render` draw each PNG once more for the dark theme, beside it; called before each example."""

    def render_both(histories: Any, out: str, style: Style | None = None, **options: Any) -> Rendered:
        result = render(histories, out, style, **options)
        if result.file.suffix == ".png":
            size = result.size if options.get("strip") else Style().size
            render(histories, twin_of(result.file), replace(style or Style(size), theme="dark"), **options)
        return result

    vars(renders)["render"] = render_both


def place(filename: str) -> int:
    """Return the place of an example in the gallery; new ones stand last."""
    name = Path(filename).stem.removeprefix("plot_")
    return ORDER.index(name) if name in ORDER else len(ORDER)

"""Pictures on light and dark paper: each picture of a page has a twin, which the dark theme shows in its place.

A drawing (SVG) is made once, with the colours of the light theme on white; its twin ``NAME-dark.svg`` is written
while the site is built, with the dark theme's colour of the same meaning for each. A picture in pixels brings its
twin ``NAME-dark.png``; one without is a warning, and so an error of the build.
"""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from PIL import Image
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform
from sphinx.util import logging
from sphinx.writers.html5 import HTML5Translator
from sphinx_gallery.utils import scale_image

from oblique_impact.renders.style import DARK, LIGHT, SERIES

#: colours of figures that no theme names: paper, ink, and the lines of a grid; the slope of the overview
_OF_FIGURES = {
    "#ffffff": DARK.background,
    "#000000": DARK.ink,
    "#e6e8eb": DARK.line,
    "#c9ced4": DARK.slope,
    "#3d4650": DARK.slope_edge,
}
_THUMBNAIL = re.compile(r"thumb/(sphx_glr_\w+)_thumb\.png$")


def colours() -> dict[str, str]:
    """Return the dark colour (#rrggbb) of each light one, by what it means."""
    found: dict[str, str] = {}
    for field in fields(LIGHT):
        light, dark = getattr(LIGHT, field.name), getattr(DARK, field.name)
        pairs = [(light, dark)] if isinstance(light, str) else zip(light, dark, strict=True)
        for name, other in pairs:
            found.setdefault(name, other)
    # the colours of lines are those of several histories, whatever else has one of them
    return {**found, **dict(zip(SERIES, DARK.series, strict=True)), **_OF_FIGURES}


def darken(drawing: str) -> str:
    """Return an SVG with the colours of the dark theme; what has no colour is ink."""
    table = colours()
    drawing = re.sub(
        r"#[0-9a-fA-F]{6}\b", lambda match: table.get(match[0].lower(), match[0]), drawing, flags=re.ASCII
    )
    return re.sub(r"<svg ", f'<svg fill="{DARK.ink}" ', drawing, count=1)


def twin_of(picture: Path) -> Path:
    """Return where the dark twin of a picture lies."""
    return picture.with_name(f"{picture.stem}-dark{picture.suffix}")


def make_twin(picture: Path) -> Path | None:
    """Write the twin of a drawing or of a thumbnail; returns the twin, None if there is none."""
    twin = twin_of(picture)
    if picture.suffix == ".svg":
        twin.write_text(darken(picture.read_text(encoding="utf-8")), encoding="utf-8")
    elif thumbnail := _THUMBNAIL.search(picture.as_posix()):
        large = twin_of(picture.parents[1] / f"{thumbnail[1]}_001.png")
        if large.exists():
            scale_image(large, twin, 540, 360)
    return twin if twin.exists() else None


def size_of(picture: Path) -> tuple[int, int]:
    """Return width and height of a picture in pixels of the page."""
    if picture.suffix != ".svg":
        with Image.open(picture) as opened:
            return opened.size
    head = picture.read_text(encoding="utf-8")[:1000]
    width, height = (float(re.search(rf'{side}="([\d.]+)pt"', head)[1]) for side in ("width", "height"))
    return round(width * 4 / 3), round(height * 4 / 3)


class Twins(SphinxTransform):
    """Put the dark twin behind each picture; the theme shows one of the two."""

    default_priority: ClassVar[int] = 350  # before the pictures of a page are collected

    def apply(self, **options: Any) -> None:
        """Go over the pictures of a page."""
        for image in list(self.document.findall(nodes.image)):
            _, path = self.env.relfn2path(image["uri"], self.env.docname)
            twin = make_twin(Path(path)) if Path(path).is_file() else None
            if twin is None:
                logging.getLogger(__name__).warning("%s has no dark twin", image["uri"], location=image)
                continue
            image["size"] = size_of(Path(path))
            dark = image.deepcopy()
            dark["uri"] = str(Path(image["uri"]).with_name(twin.name).as_posix())
            image["classes"].append("only-light")
            dark["classes"].append("only-dark")
            image.parent.insert(image.parent.index(image) + 1, dark)


def visit_image(translator: HTML5Translator, node: nodes.image) -> None:
    """Write a picture with its size, so that the page leaves room for it before it has come."""
    type(translator).visit_image(translator, node)
    if "size" in node:
        width, height = node["size"]
        translator.body[-1] = translator.body[-1].replace("<img ", f'<img width="{width}" height="{height}" ', 1)


def depart_image(translator: HTML5Translator, node: nodes.image) -> None:
    """Do what Sphinx does."""
    type(translator).depart_image(translator, node)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the transform, and how pictures are written."""
    app.add_transform(Twins)
    app.add_node(nodes.image, override=True, html=(visit_image, depart_image))
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

"""Drawings (SVG) of the site on light and dark paper: without paper of their own, in colours that read on both.

The files among the sources are for white paper, as editors and readers of plain files show them; what the site
shows of them is rewritten when it is built.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

_INK, _LINE = "#7d8893", "#8a94a055"
#: what reads on one kind of paper only, and what stands for it
_READABLE = {
    "#1d2733": _INK,
    "#000000": _INK,
    "#3d4650": _INK,
    "#5d6b7a": "#84909c",
    "#6c757d": "#828c95",
    "#dfe4e9": _LINE,
    "#e6e8eb": _LINE,
    "#22577a": "#3f86b3",
    "#1f4fd1": "#4d7dee",
    "#8a4f9e": "#a868bd",
    "#b03a48": "#cf5563",
    "#0f7f86": "#1f969d",
    "#1b8a3c": "#2b9c4d",
}


def readable(drawing: str) -> str:
    """Return an SVG of matplotlib without its white paper, in colours that read on light and on dark paper."""
    drawing = drawing.replace('style="fill: #ffffff"', 'style="fill: none"')  # paper has no edge, marks have one
    drawing = re.sub(r"#[0-9a-fA-F]{6}\b", lambda match: _READABLE.get(match[0].lower(), match[0]), drawing)
    return re.sub(r"<svg ", f'<svg fill="{_INK}" ', drawing, count=1)


def rewrite(app: Sphinx, error: Exception | None) -> None:
    """Rewrite the drawings of the finished site."""
    if error or app.builder.format != "html":
        return
    for file in (Path(app.outdir) / "_images").glob("*.svg"):
        drawing = file.read_text(encoding="utf-8")
        if not drawing.count(f'<svg fill="{_INK}"'):
            file.write_text(readable(drawing), encoding="utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Register what is done with the finished site."""
    app.connect("build-finished", rewrite)
    return {"version": "2", "parallel_read_safe": True, "parallel_write_safe": True}

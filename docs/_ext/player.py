"""The directive ``player``: the interactive page of a built-in case, embedded, written while the site is built.

What is seen first is a small picture of its beginning (``docs/pictures/player.svg``), in the place and the size of
the page, so that nothing jumps when that arrives. In it the beam falls as in the page, until it strikes.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from two_themes import readable

from oblique_impact import History, Scenario, simulate
from oblique_impact.renders import Style, render
from oblique_impact.renders.timeline import time_map

#: folder of the site that the pages are in, and the first picture of all of them
FOLDER, POSTER = "player", Path(__file__).parents[1] / "pictures" / "player.svg"
_FRAME = """<div class="player">
<img src="{folder}/poster.svg" alt="" width="1280" height="720">
<iframe src="{folder}/{case}.html#embed&amp;theme=auto" title="{title}"></iframe>
</div>
"""
_MOTION = """
@media (prefers-reduced-motion: no-preference) {{
  #beam {{ transform-origin: {x}px {y}px; animation: fall {seconds:.3f}s linear both; }}
}}
@keyframes fall {{ {frames} }}
"""
#: stretches of the fall in which it turns evenly
_STRETCHES = 24


class Player(SphinxDirective):
    """The player of a built-in case; its content is the title for those who do not see it."""

    required_arguments = 1
    has_content = True
    option_spec: ClassVar[dict[str, Any]] = {"class": directives.class_option}

    def run(self) -> list[nodes.Node]:
        """Return the frame; the page is written at the end of the build."""
        case, title = self.arguments[0], " ".join(self.content)
        if not title:
            raise self.error("a player needs a title")
        up = "../" * self.env.docname.count("/")
        return [nodes.raw("", _FRAME.format(folder=up + FOLDER, case=case, title=title), format="html")]


def write_pages(app: Sphinx, error: Exception | None) -> None:
    """Write the page of the paper's case and the first pictures into the finished site."""
    if error or app.builder.format != "html":
        return
    folder = Path(app.outdir) / FOLDER
    folder.mkdir(exist_ok=True)
    history = simulate(Scenario.builtin("paper"))
    render(history, folder / "paper.html", Style(theme="auto"))
    poster = falling(POSTER.read_text(encoding="utf-8"), history)
    (folder / "poster.svg").write_text(readable(poster), encoding="utf-8")


def falling(drawing: str, history: History) -> str:
    """Return a drawing (SVG) whose beam, the group `beam` from the pin on, falls at the pace of the page."""
    course, times, angles = time_map(history), history["time"].values, history["theta"].values
    seconds = float(course.film_at(history.contacts[0].start))
    shares = np.linspace(0.0, 1.0, _STRETCHES + 1)
    turned = np.degrees(angles[0] - np.interp(course.time_at(shares * seconds), times, angles))
    frames = " ".join(
        f"{100 * s:.3f}% {{ transform: rotate({a:.4f}deg) }}" for s, a in zip(shares, turned, strict=True)
    )
    x, y = re.search(r'id="beam">.*?d="M ([\d.]+) ([\d.]+)', drawing, flags=re.DOTALL).groups()  # type: ignore[union-attr]
    return drawing.replace("</style>", _MOTION.format(x=x, y=y, seconds=seconds, frames=frames) + "</style>", 1)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive and the page."""
    app.add_directive("player", Player)
    app.connect("build-finished", write_pages)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

"""The directive ``player``: the interactive page of a built-in case, embedded, written while the site is built."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from oblique_impact import Scenario
from oblique_impact.renders import Style, render
from oblique_impact.simulation import compute_history

FOLDER = "player"  # of the site, that the page is in
_FRAME = """<div class="player">
<iframe src="{folder}/{case}.html#embed&amp;theme=auto" title="{title}"></iframe>
</div>
"""


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
    """Write the page of the paper's case into the finished site."""
    if error or app.builder.format != "html":
        return
    history = compute_history(Scenario.builtin("paper"))
    render(history, Path(app.outdir) / FOLDER / "paper.html", Style(theme="auto"))


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive and the page."""
    app.add_directive("player", Player)
    app.connect("build-finished", write_pages)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

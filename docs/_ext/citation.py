"""The directive ``citation``: how to cite this version, from CITATION.cff, in words and as BibTeX."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

FILE = Path(__file__).parents[2] / "CITATION.cff"


def citation() -> tuple[str, str]:
    """Return the citation in words and as an entry of BibTeX."""
    cited = yaml.safe_load(FILE.read_text(encoding="utf-8"))
    authors = " and ".join(author["name"] for author in cited["authors"])
    released = cited["date-released"]
    words = f"{authors}, {cited['title']}, version {cited['version']} ({released:%d %B %Y})".replace("(0", "(")
    fields = {
        "author": f"{{{authors}}}",
        "title": cited["title"],
        "version": cited["version"],
        "year": released.year,
        "note": f"License: {cited['license']}",
    }
    rows = ",\n".join(f"  {name:<7} = {{{value}}}" for name, value in fields.items())
    return words, f"@software{{oblique_impact,\n{rows}\n}}"


class Citation(SphinxDirective):
    """Both forms of the citation."""

    def run(self) -> list[nodes.Node]:
        """Return a paragraph and a block of code."""
        self.env.note_dependency(str(FILE))
        words, entry = citation()
        return [nodes.paragraph(words, words), nodes.literal_block(entry, entry, language="bibtex")]


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("citation", Citation)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

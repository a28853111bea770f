"""The directive ``equation``: a displayed formula that must name the code that computes it."""

from __future__ import annotations

from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


class Equation(SphinxDirective):
    """A displayed formula; `code` names the functions that compute it, `label` numbers it."""

    has_content = True
    option_spec: ClassVar[dict[str, Any]] = dict.fromkeys(("label", "code"), directives.unchanged_required)

    def run(self) -> list[nodes.Node]:
        """Return the formula and the line that links it to its code."""
        for option in ("label", "code"):
            if not self.options.get(option):
                raise self.error(f"an equation needs :{option}:")
        body = "\n".join(self.content)
        links = ", ".join(self._link(name.strip()) for name in self.options["code"].split(","))
        line = nodes.container(classes=["computed-by"])
        line += self.parse_text_to_nodes(f"computed by {links}")
        return [*self.parse_text_to_nodes(f"```{{math}}\n:label: {self.options['label']}\n{body}\n```\n"), line]

    @staticmethod
    def _link(name: str) -> str:
        """Return a reference; a class or a property is marked as in ``class:modal.Eigenfunctions``."""
        kind, _, path = name.rpartition(":")
        return f"{{py:{kind or 'func'}}}`~{path}`"


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("equation", Equation)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

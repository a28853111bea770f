"""The directive ``equation``: a numbered formula that must name the code that computes it.

A public function leads to its documentation, a private one to that of its module.
"""

from __future__ import annotations

from importlib import import_module
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
        links = ", ".join(self._link(name.strip()) for name in self.options["code"].split(","))
        formula = "\n".join(self.content)
        return self.parse_text_to_nodes(
            f"```{{math}}\n:label: {self.options['label']}\n{formula}\n```\n"
            f"```{{rst-class}} computed-by\n```\ncomputed by {links}\n"
        )

    def _link(self, name: str) -> str:
        """Return a reference; a class or a property is marked as in ``class:modal.Eigenfunctions``."""
        kind, _, path = name.rpartition(":")
        module, _, function = path.rpartition(".")
        if not function.startswith("_"):
            return f"{{py:{kind or 'func'}}}`~{path}`"
        if not hasattr(import_module(module), function):
            raise self.error(f"there is no {path}")
        return f"{{py:mod}}`{function}() <{module}>`"


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("equation", Equation)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

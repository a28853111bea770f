"""The directive ``equation``: a displayed formula that must name the code that computes it.

A public function leads to its documentation, a private one, which has none, to its source.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.pycode import ModuleAnalyzer
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
        line = nodes.container(classes=["computed-by"])
        sentence = nodes.paragraph("", "computed by ")
        for number, name in enumerate(name.strip() for name in self.options["code"].split(",")):
            sentence += nodes.Text(", " if number else "")
            private = name.rpartition(".")[2].startswith("_")
            sentence += self._to_source(name) if private else self.parse_inline(self._link(name))[0]
        line += sentence
        return [*self.parse_text_to_nodes(f"```{{math}}\n:label: {self.options['label']}\n{body}\n```\n"), line]

    def _to_source(self, name: str) -> list[nodes.Node]:
        """Return a reference to the source of a private function, which viewcode marks and leads back from."""
        module, _, function = name.rpartition(".")
        analyzer = ModuleAnalyzer.for_module(module)
        analyzer.find_tags()
        if function not in analyzer.tags or not hasattr(import_module(module), function):
            raise self.error(f"there is no {name}")
        shown = vars(self.env).setdefault("_viewcode_modules", {})
        if not shown.get(module):
            shown[module] = (analyzer.code, analyzer.tags, {}, module)
        page = self.env.app.builder.get_relative_uri(self.env.docname, f"_modules/{module.replace('.', '/')}")
        target = [] if shown[module][2].get(function) == self.env.docname else [name]
        shown[module][2][function] = self.env.docname
        link = nodes.reference("", "", refuri=f"{page}#{function}", internal=True, ids=target)
        link += nodes.literal(function, f"{function}()", classes=["xref", "py", "py-func"])
        return [link]

    @staticmethod
    def _link(name: str) -> str:
        """Return a reference; a class or a property is marked as in ``class:modal.Eigenfunctions``."""
        kind, _, path = name.rpartition(":")
        return f"{{py:{kind or 'func'}}}`~{path}`"


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("equation", Equation)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

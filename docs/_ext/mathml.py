"""Formulas as MathML, which every current browser shows by itself: no script and no network.

Brackets grow and accents sit right only with a font that has a table for mathematics. Not every machine has one:
STIX Two Math, which comes with ziamath, is copied into the site.

The directive ``equation`` is a displayed formula that must name the code that computes it.
"""

from __future__ import annotations

import copy
import shutil
from html import escape
from importlib.util import find_spec
from pathlib import Path
from typing import Any, ClassVar
from xml.etree import ElementTree

from docutils import nodes
from docutils.parsers.rst import directives
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective
from sphinx.util.math import get_node_equation_number

_LOG = logging.getLogger(__name__)

_NAMESPACE = "http://www.w3.org/1998/Math/MathML"
ElementTree.register_namespace("", _NAMESPACE)
_PRIMES = ("\u2032", "\u2033")
_DOTS = ("\u02d9", "\u00a8", "\u00af")
_BARS = ("|", "\u2016")
_FUNCTIONS = ("sin", "cos", "tan", "sinh", "cosh", "tanh", "sign")
_BESIDE = {f"{{{_NAMESPACE}}}{name}" for name in ("mi", "mn", "msub", "msup", "mfrac", "mover", "mrow", "msubsup")}

FONT = "STIXTwoMath-Regular.ttf"

#: environments that number themselves or that the converter takes for text
_ENVIRONMENTS = {"aligned": "align*", "align": "align*"}


def _converted(node: nodes.math | nodes.math_block, display: str) -> str:
    """Convert the formula of a node; one that cannot be converted is a warning, which ends the build."""
    try:
        return to_mathml(node.astext(), display)
    except Exception as error:  # the converter has exceptions of many kinds
        _LOG.warning("formula: %s: %s", type(error).__name__, node.astext(), location=node)
        return f"<code>{escape(node.astext())}</code>"


def to_mathml(latex: str, display: str) -> str:
    """Convert a formula; raises ValueError for what the converter lets through unconverted."""
    for name, instead in _ENVIRONMENTS.items():
        for word in ("begin", "end"):
            latex = latex.replace(f"\\{word}{{{name}}}", f"\\{word}{{{instead}}}")
    found = str(convert(latex.replace(r"\mathrm{d}", r"\text{d}"), display=display))  # an upright d of one letter
    if "<mi>&</mi>" in found or "<mtext>\\" in found or "<mi>\\" in found:
        raise ValueError(f"not converted: {latex}")
    root = ElementTree.fromstring(found)
    for element in list(root.iter()):
        _arrange(element)
    return ElementTree.tostring(root, encoding="unicode")


def _arrange(element: ElementTree.Element) -> None:
    """Say for browsers what the converter says for printers: alignment, dots, primes, spaces around functions."""
    if element.tag == _tag("mover") and element[-1].text in _DOTS:
        element.set("accent", "true")
    if element.tag in (_tag("msup"), _tag("msubsup")) and element[0].tag == _tag("mover"):
        _lower(element)
    if element.tag == _tag("mtd") and "columnalign" in element.attrib:
        element.set("class", element.attrib.pop("columnalign"))
    if element.tag in (_tag("msup"), _tag("msubsup")) and element[-1].text in _PRIMES:
        # the sign is raised by itself
        prime = ElementTree.Element(_tag("mo"), {"lspace": "0", "rspace": "0"})
        prime.text = element[-1].text
        inner = list(element)[:-1]
        if element.tag == _tag("msubsup"):
            base = ElementTree.Element(_tag("msub"))
            base.extend(inner)
            inner = [base]
        element.clear()
        element.tag = _tag("mrow")
        element.extend([*inner, prime])
    children = list(element)
    for before, child in zip([None, *children], children, strict=False):
        _space_operator(child, before)
    if any(child.text in _FUNCTIONS for child in children):
        element[:] = [part for n, child in enumerate(children) for part in _spaced(children, n, child)]


def _space_operator(child: ElementTree.Element, before: ElementTree.Element | None) -> None:
    """Take a sign after another operator for a prefix, bars for brackets, and a function name for a name."""
    if child.tag != _tag("mo"):
        return
    if child.text in _FUNCTIONS:
        child.tag = _tag("mi")
    elif child.text in _BARS:
        child.attrib.update(lspace="0", rspace="0", stretchy=child.get("fence", "false"))
    elif child.text == "\u2212" and (before is None or (before.tag == _tag("mo") and before.text not in ")]|")):
        child.set("form", "prefix")


def _lower(element: ElementTree.Element) -> None:
    """Put a superscript at the height that it has without the dots below it: an invisible base without width."""
    dotted, *scripts = list(element)
    holder = ElementTree.Element(_tag("mpadded"), {"width": "0"})
    ElementTree.SubElement(holder, _tag("mphantom")).append(copy.deepcopy(dotted[0]))
    inner = ElementTree.Element(element.tag)
    inner.extend([holder, *scripts])
    element.clear()
    element.tag = _tag("mrow")
    element.extend([dotted, inner])


def _spaced(row: list[ElementTree.Element], place: int, child: ElementTree.Element) -> list[ElementTree.Element]:
    """Return a function name with thin spaces where a letter or a fraction stands beside it."""
    if child.text not in _FUNCTIONS:
        return [child]
    before = place > 0 and row[place - 1].tag in _BESIDE and row[place - 1].text not in _FUNCTIONS
    after = place + 1 < len(row) and row[place + 1].tag in _BESIDE
    thin = [ElementTree.Element(_tag("mspace"), {"width": "0.167em"}) for _ in range(2)]
    return [*thin[:before], child, *thin[1 : 1 + after]]


def _tag(name: str) -> str:
    return f"{{{_NAMESPACE}}}{name}"


def visit_math(self: Any, node: nodes.math) -> None:
    """Write an inline formula."""
    self.body.append(_converted(node, "inline"))
    raise nodes.SkipNode


def visit_displayed(self: Any, node: nodes.math_block) -> None:
    """Write a displayed formula with its number."""
    target = node.get("ids") or []
    anchor = f' id="{escape(target[0])}"' if target else ""
    self.body.append(f'<div class="math"{anchor}>')
    self.body.append(_converted(node, "block"))
    if node.get("number"):
        self.body.append(f'<span class="eqno">({get_node_equation_number(self, node)})')
        self.add_permalink_ref(node, "Link to this equation")
        self.body.append("</span>")
    self.body.append("</div>\n")
    raise nodes.SkipNode


class Equation(SphinxDirective):
    """A displayed formula; `code` names the functions that compute it, `label` numbers it."""

    has_content = True
    option_spec: ClassVar[dict[str, Any]] = {
        "label": directives.unchanged_required,
        "code": directives.unchanged_required,
    }

    def run(self) -> list[nodes.Node]:
        """Return the formula and the line that links it to its code."""
        for option in ("label", "code"):
            if not self.options.get(option):
                raise self.error(f"an equation needs :{option}:")
        body = "\n".join(self.content)
        names = [name.strip() for name in self.options["code"].split(",")]
        links = ", ".join(self._link(name) for name in names)
        formula = f"```{{math}}\n:label: {self.options['label']}\n{body}\n```\n"
        found = self.parse_text_to_nodes(formula)
        line = nodes.container(classes=["computed-by"])
        line += self.parse_text_to_nodes(f"computed by {links}")
        return [*found, line]

    @staticmethod
    def _link(name: str) -> str:
        """Return a reference; a class or a property is marked as in ``class:modal.Eigenfunctions``."""
        kind, _, path = name.rpartition(":")
        return f"{{py:{kind or 'func'}}}`~{path}`"


def copy_font(app: Sphinx, error: Exception | None) -> None:
    """Put the font beside the style sheet that names it."""
    spec = find_spec("ziamath")
    if error is None and app.builder.format == "html" and spec and spec.origin:
        shutil.copy(Path(spec.origin).parent / "fonts" / FONT, Path(app.outdir) / "_static" / FONT)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer and the directive."""
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_displayed, None))
    app.add_directive("equation", Equation)
    app.connect("build-finished", copy_font)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

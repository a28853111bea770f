"""The reference of the scenario's keys, from their models; nothing is typed by hand."""

from __future__ import annotations

import inspect
import json
import re
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from oblique_impact.scenario import comments, scenario, schema, sections
from oblique_impact.scenario.comments import item_models, range_text, schemas_of
from oblique_impact.scenario.schema import key_schemas
from oblique_impact.scenario.units import Unit


def reference() -> str:
    """Return the reference as reStructuredText: a table for each section."""
    tables: dict[str, list[list[str]]] = {}
    keys = dict(key_schemas())
    for name, model in item_models(scenario.Scenario).items():
        keys |= {f"{name}.{inner}": key for inner, key in schemas_of(model).items()}
    for path, key in keys.items():
        section, _, name = path.rpartition(".")
        unit = Unit(key.get("unit", "–")).shown
        default = f"``{json.dumps(key['default'])}``"
        cells = [f"``{name}``", unit, _allowed(key), default, _plain(key["description"])]
        tables.setdefault(section, []).append(cells)
    lines: list[str] = []
    for section, rows in tables.items():
        lines += _headed(
            f"``[[{section}]]``"
            if section in item_models(scenario.Scenario)
            else f"``[{section}]``"
            if section
            else "Without a section",
            _about(section),
        )
        lines += _table(["key", "unit", "allowed", "default", "meaning"], rows, "22 10 24 18 36")
    return "\n".join(lines)


def _about(section: str) -> str:
    """Return what the docstring of a section says."""
    if not section:
        return "These stand first in the file."
    model: Any = scenario.Scenario
    for name in section.split("."):
        items = item_models(model)
        model = items[name] if name in items else model.model_fields[name].annotation
    return _plain(" ".join(model.__doc__.split()))


def _allowed(key: dict[str, Any]) -> str:
    words = re.sub(r'("[^"]*"|true|false)', r"``\1``", range_text(key))
    return words.replace(">=", "≥").replace("<=", "≤")


def _plain(text: str) -> str:
    """Escape what reStructuredText would take for markup; single backticks are code."""
    parts = text.split("`")
    return "".join(f"``{p}``" if n % 2 else re.sub(r"([*|_\\])", r"\\\1", p) for n, p in enumerate(parts))


def _headed(title: str, words: str) -> list[str]:
    return [title, "-" * len(title), "", words, ""]


def _table(head: list[str], rows: list[list[str]], widths: str) -> list[str]:
    lines = [".. list-table::", "   :header-rows: 1", f"   :widths: {widths}", "   :class: keys", ""]
    for first, *others in [head, *rows]:
        lines += [f"   * - {first}", *(f"     - {cell}" for cell in others)]
    return [*lines, ""]


class ScenarioKeys(SphinxDirective):
    """Puts the reference into a page."""

    def run(self) -> list[nodes.Node]:
        """Return the tables."""
        for module in (comments, scenario, schema, sections):
            self.env.note_dependency(inspect.getsourcefile(module) or "")
        return self.parse_text_to_nodes(reference(), allow_section_headings=True)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("scenario-keys", ScenarioKeys)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

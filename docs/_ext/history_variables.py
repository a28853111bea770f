"""The variables of a history with their units, from a history itself: a run of one sample interval."""

from __future__ import annotations

from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from oblique_impact import Scenario, simulate


def table() -> str:
    """Return a Markdown table of all variables."""
    data = simulate(Scenario.builtin("paper", ["end_time=1e-4"])).data
    rows = ["| variable | dimensions | unit | meaning |", "| --- | --- | --- | --- |"]
    for name, variable in data.variables.items():
        unit, meaning, comment = (str(variable.attrs.get(key, "")) for key in ("units", "long_name", "comment"))
        meaning = f"{meaning or '–'}{f' ({comment})' if comment else ''}"
        rows.append(f"| `{name}` | {', '.join(map(str, variable.dims))} | {unit or '–'} | {meaning} |")
    return "\n".join(rows) + "\n"


class HistoryVariables(SphinxDirective):
    """Puts the table into a page in Markdown."""

    def run(self) -> list[nodes.Node]:
        """Return the table."""
        holder = nodes.container()
        self.state.nested_parse(StringList(table().splitlines(), "history"), self.content_offset, holder)
        return holder.children


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("history-variables", HistoryVariables)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

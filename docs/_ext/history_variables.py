"""The variables of a history and the quantities of studies, with their units, as the program itself has them."""

from __future__ import annotations

from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from oblique_impact import Scenario, simulate
from oblique_impact.validation.studies.quantities import named_quantities


def variables() -> str:
    """Return a Markdown table of all variables of a history, that of a run of one sample interval."""
    data = simulate(Scenario.builtin("paper", ["end_time=1e-4"])).data
    rows = ["| variable | dimensions | unit | meaning |", "| --- | --- | --- | --- |"]
    for name, variable in data.variables.items():
        unit, meaning, comment = (str(variable.attrs.get(key, "")) for key in ("units", "long_name", "comment"))
        meaning = f"{meaning or '–'}{f' ({comment})' if comment else ''}"
        rows.append(f"| `{name}` | {', '.join(map(str, variable.dims))} | {unit or '–'} | {meaning} |")
    return "\n".join(rows) + "\n"


def quantities() -> str:
    """Return a Markdown table of the quantities of interest that have a name."""
    rows = ["| quantity | unit | meaning |", "| --- | --- | --- |"]
    rows += [f"| `{found.name}` | {found.unit} | {found.meaning} |" for found in named_quantities()]
    return "\n".join(rows) + "\n"


class HistoryVariables(SphinxDirective):
    """Puts a table into a page in Markdown."""

    table = staticmethod(variables)

    def run(self) -> list[nodes.Node]:
        """Return the table."""
        holder = nodes.container()
        self.state.nested_parse(StringList(self.table().splitlines(), "history"), self.content_offset, holder)
        return holder.children


class Quantities(HistoryVariables):
    """Puts the table of quantities into a page in Markdown."""

    table = staticmethod(quantities)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("history-variables", HistoryVariables)
    app.add_directive("quantities", Quantities)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

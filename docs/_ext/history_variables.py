"""Tables of the variables of a history and of the quantities of studies, as the program itself has them."""

from __future__ import annotations

from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from oblique_impact import Scenario
from oblique_impact.history.variables import COMPUTED, OF_A_FREE_BEAM
from oblique_impact.simulation import compute_history
from oblique_impact.validation.studies.quantities import quantity_table


class HistoryVariables(SphinxDirective):
    """The variables of a history, from a run of one sample interval."""

    def run(self) -> list[nodes.Node]:
        """Return the table."""
        rows = ["| variable | dimensions | unit | meaning |", "| --- | --- | --- | --- |"]
        history = compute_history(Scenario.builtin("paper", ["end_time=1e-4"]))
        variables = {name: history[name] for name in history} | dict(history.section_forces().data_vars)
        for name, variable in variables.items():
            unit, meaning, comment = (
                str(variable.attrs.get(key, "")) for key in ("units", "long_name", "comment")
            )
            meaning = f"{meaning or '–'}{f' ({comment})' if comment else ''}"
            meaning += " – computed when it is asked for" if name in COMPUTED else ""
            rows.append(f"| `{name}` | {', '.join(map(str, variable.dims))} | {unit or '–'} | {meaning} |")
        for name, known in OF_A_FREE_BEAM.items():
            meaning = f"{known.long_name} (of a beam that nothing holds)"
            rows.append(f"| `{name}` | {', '.join(known.dimensions)} | {known.units} | {meaning} |")
        return self.parse_text_to_nodes("\n".join(rows))


class Quantities(SphinxDirective):
    """The quantities of interest."""

    def run(self) -> list[nodes.Node]:
        """Return the table."""
        rows = ["| quantity | unit | meaning |", "| --- | --- | --- |"]
        rows += [f"| `{row.Index}` | {row.unit} | {row.meaning} |" for row in quantity_table().itertuples()]
        return self.parse_text_to_nodes("\n".join(rows))


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directives."""
    app.add_directive("history-variables", HistoryVariables)
    app.add_directive("quantities", Quantities)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

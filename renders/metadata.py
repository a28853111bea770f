"""Metadata of pictures: what made them, and the warnings of their runs."""

from __future__ import annotations

from collections.abc import Iterable

from oblique_impact.history.history import History
from oblique_impact.history.provenance import provenance, provenance_line


def made_by(histories: Iterable[History] = ()) -> str:
    """Return what made the histories, if any are drawn, and what draws them where that is something else."""
    drawing = provenance_line(provenance())
    runs = list(dict.fromkeys(provenance_line(history.summary.get("provenance", {})) for history in histories))
    if runs in ([], [drawing]):
        return drawing
    return "; ".join([*runs, f"drawn by {drawing}"])


def warnings_of(histories: Iterable[History]) -> list[str]:
    """Return the warnings of the runs that are drawn, each once."""
    return list(dict.fromkeys(text for history in histories for text in history.summary.get("warnings", ())))


def comment(histories: Iterable[History] = ()) -> str:
    """Return what made a picture, and the warnings of its runs."""
    runs = list(histories)
    return "; ".join([made_by(runs), *(f"warning: {text}" for text in warnings_of(runs))])

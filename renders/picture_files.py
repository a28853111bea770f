"""Pictures on disk: whole or not at all, with what made them and the warnings of their runs."""

from __future__ import annotations

from collections.abc import Iterable
from io import BytesIO
from pathlib import Path

from matplotlib.figure import Figure

from oblique_impact.files import save_whole
from oblique_impact.history.history import History
from oblique_impact.history.provenance import provenance, provenance_line


class Drawing(Figure):
    """A figure that a notebook shows as one picture: it is no figure of pyplot, which would show it once more."""

    def _repr_png_(self) -> bytes:
        picture = BytesIO()
        self.savefig(picture, format="png")
        return picture.getvalue()


#: of a file of matplotlib, and the key of a comment in its metadata
_COMMENT = {".png": "Comment", ".pdf": "Subject", ".svg": "Description"}


def save_figure(figure: Figure, out: Path, default_name: str, histories: Iterable[History] = ()) -> Path:
    """Save `figure` to the file `out`, or to `default_name` in the folder `out`; returns the file.

    Its metadata say what made it and the `histories` that it shows, with their warnings.  Raises InputError if it
    cannot be written.
    """
    file = out if out.suffix.lower() in _COMMENT else out / default_name
    content, kind = BytesIO(), file.suffix.lower()
    figure.savefig(content, format=kind[1:], metadata={_COMMENT[kind]: comment(histories)})
    return save_whole(file, lambda part: part.write_bytes(content.getbuffer()))


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

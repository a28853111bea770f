"""Pictures on disk: whole or not at all."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from matplotlib.figure import Figure

from oblique_impact.files import cannot_write, write_whole
from oblique_impact.history.history import History
from renders.metadata import figure_metadata, made_by

_SUFFIXES = (".png", ".pdf", ".svg", ".jpg", ".jpeg", ".webp")


def save_figure(figure: Figure, out: Path, default_name: str, histories: Iterable[History] = ()) -> Path:
    """Save `figure` to the file `out`, or to `default_name` in the folder `out`; returns the file.

    Its metadata say what made it and the `histories` that it shows.

    Raises InputError if it cannot be written.
    """
    file = out if out.suffix.lower() in _SUFFIXES else out / default_name
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        metadata = figure_metadata(file, made_by(histories))
        write_whole(file, lambda part: figure.savefig(part, metadata=metadata))
    except OSError as error:
        raise cannot_write(out, error) from None
    return file

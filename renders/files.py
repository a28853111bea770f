"""Pictures on disk: whole or not at all."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from oblique_impact.files import cannot_write, write_whole

_SUFFIXES = (".png", ".pdf", ".svg", ".jpg", ".jpeg", ".webp")


def save_figure(figure: Figure, out: Path, default_name: str) -> Path:
    """Save `figure` to the file `out`, or to `default_name` in the folder `out`; returns the file.

    Raises InputError if it cannot be written.
    """
    file = out if out.suffix.lower() in _SUFFIXES else out / default_name
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, figure.savefig)
    except OSError as error:
        raise cannot_write(out, error) from None
    return file

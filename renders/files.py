"""Pictures on disk: whole or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from matplotlib.figure import Figure

from oblique_impact.errors import InputError

_SUFFIXES = (".png", ".pdf", ".svg", ".jpg", ".jpeg", ".webp")


def save_figure(figure: Figure, out: Path, default_name: str) -> Path:
    """Save `figure` to the file `out`, or to `default_name` in the folder `out`; returns the file.

    Raises InputError if it cannot be written.
    """
    file = out if out.suffix.lower() in _SUFFIXES else out / default_name
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=file.parent) as folder:
            temporary = Path(folder) / file.name
            figure.savefig(temporary)
            os.replace(temporary, file)
    except OSError as error:
        raise InputError(f"--out {out}: cannot be written: {error.strerror or error}") from None
    return file

"""What a path is that was given for a history and is none, in one line."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import h5py
from h5py import h5a, h5t

from oblique_impact.scenario.scenario import builtin_names

_WRITTEN_HERE = b"oblique-impact history"
_LONGEST = 200


def is_history(file: Path) -> bool:
    """Whether a file may be a history of this program, of whatever version and in whatever state."""
    try:
        if not h5py.is_hdf5(file):
            return False
        with h5py.File(file, "r") as opened:
            attribute = h5a.open(opened.id, b"format")
            kind = attribute.get_type()
            if kind.get_class() != h5t.STRING or kind.get_size() > _LONGEST:
                return False
            if kind.is_variable_str():  # a reference, which damage turns into anything: not followed
                return True
            value = opened.attrs["format"]
            return (value.encode() if isinstance(value, str) else bytes(value)).startswith(_WRITTEN_HERE)
    except KeyError:
        return False
    except Exception:  # cut off or damaged, whatever the reader's layers raise
        return True


def not_a_history(file: Path) -> str:
    """Return the line for a file that `is_history` denies."""
    line = f"{file}: is not a history written by oblique-impact (history.nc)"
    beside = file.with_name("history.nc")
    if file != beside and beside.is_file():
        return f"{line}; one lies beside it: {beside}"
    if file.suffix.lower() == ".toml":
        return f"{line}; run a scenario first: oblique-impact run {file} --out DIR, and give DIR"
    return line


def no_history(path: Path, files: Sequence[str]) -> str:
    """Return the line for a path where there is no file, or a folder that is not one of a run with its `files`."""
    if not _is_folder(path):
        run = f"; run the scenario first: oblique-impact run {path} --out DIR, and give DIR"
        return f"{path}: no such history{run if str(path) in builtin_names() else ''}"
    lacking = [name for name in files if not (path / name).exists()]
    return f"{path}: is not the folder of a run: it lacks {', '.join(lacking)}"


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except (OSError, ValueError):  # a name too long for the file system, or one with a null character
        return False

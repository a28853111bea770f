"""Where an export goes, and how it gets there whole: a `.part` beside it, put in place in one step."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from oblique_impact.errors import InputError
from oblique_impact.files import prepare_folder
from oblique_impact.scenario.messages import one_of

#: formats and what their files end in
SUFFIXES = {"vtkhdf": ".vtkhdf", "pvd": ".pvd", "xdmf": ".xdmf"}
#: what reads them, tried with ParaView 5.11.0, VTK 9.3.1 and 9.7.2, PyVista 0.49 and meshio 5.3
READERS = {
    "vtkhdf": "ParaView 5.12 or newer, VTK 9.3 or newer (ParaView 5.11: the first frame alone, if named .hdf)",
    "pvd": "ParaView 5.11 or newer, PyVista",
    "xdmf": 'ParaView 5.11 or newer (choose "Xdmf3 Reader S"), PyVista, meshio',
}


def resolve(out: Path, format: str | None) -> tuple[Path, str]:
    """Return the file to write and its format; a missing suffix is appended, a wrong one refused.

    Parameters
    ----------
    out : Path
        As given by --out.
    format : str or None
        As given by --format; taken from the suffix of `out` if None.

    Raises
    ------
    InputError
        If the format is unknown, contradicts the suffix, or the place cannot be written.
    """
    if format is None:
        format = out.suffix.lower().removeprefix(".")
        if format not in SUFFIXES:
            raise InputError(f"--format: missing, and --out {out} does not tell it; {one_of(format, SUFFIXES)}")
    if format not in SUFFIXES:
        raise InputError(f"--format {format}: {one_of(format, SUFFIXES)}")
    suffix = SUFFIXES[format]
    if not out.name:
        raise InputError(f"--out {out}: is a folder, should be a file")
    if out.suffix and out.suffix.lower() != suffix:
        raise InputError(f"--out {out}: should end in {suffix} for --format {format}, or have no suffix")
    target = out if out.suffix else out.with_name(out.name + suffix)
    prepare_folder(target.parent)
    if target.is_dir():
        raise InputError(f"--out {target}: is a folder, should be a file")
    return target, format


def part_of(target: Path) -> Path:
    """Return the name under which a file or folder is written until it is complete."""
    return target.with_name(target.name + ".part")


@contextmanager
def partial(*targets: Path) -> Iterator[tuple[Path, ...]]:
    """Yield names for unfinished files; what is left there is removed, however the block ends.

    A killed process cannot clean up: what it leaves ends in `.part`, and the next export removes it.
    """
    parts = tuple(part_of(target) for target in targets)
    for part in parts:
        remove(part)
    try:
        yield parts
    finally:
        for part in parts:
            remove(part)


def replace_all(*moves: tuple[Path, Path]) -> None:
    """Put finished files in place, the one that refers to the others last.

    What refers to them goes first, so that at no instant an old one refers to a new one.
    """
    if len(moves) > 1:
        moves[-1][1].unlink(missing_ok=True)
    for part, target in moves:
        if target.is_dir():
            shutil.rmtree(target)
        os.replace(part, target)


def remove(path: Path) -> None:
    """Remove a file, a link or a folder with all it holds, if it is there; links are not followed."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with suppress(OSError):
            path.unlink(missing_ok=True)

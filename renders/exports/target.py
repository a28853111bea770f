"""Where an export goes, and how it gets there whole: a `.part` beside it, put in place in one step."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from oblique_impact.errors import InputError
from oblique_impact.files import prepare_folder
from oblique_impact.scenario.messages import one_of

#: formats and what their files end in
SUFFIXES = {"vtkhdf": ".vtkhdf", "pvd": ".pvd", "xdmf": ".xdmf", "csv": ".csv"}
#: what reads them, tried with ParaView 5.11.0, VTK 9.3.1 and 9.7.2, PyVista 0.49 and meshio 5.3
READERS = {
    "vtkhdf": "ParaView 5.12 or newer, VTK 9.3 or newer (ParaView 5.11: the first frame alone, if named .hdf)",
    "pvd": "ParaView 5.11 or newer, PyVista",
    "xdmf": 'ParaView 5.11 or newer (choose "Xdmf3 Reader S"), PyVista, meshio',
    "csv": "pandas, spreadsheets",
}
#: for datasets of a frame: fast, and shuffled bytes of doubles pack well
COMPRESSION: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
#: thousands of small datasets: the newer layout describes them in a tenth of the space
HDF5_VERSIONS = ("v110", "v110")


def resolve(out: Path, format: str | None) -> tuple[Path, str]:
    """Return the file to write and its format; a missing suffix is appended, a wrong one refused.

    Raises InputError if the format is unknown, contradicts the suffix, or the place cannot be written.
    """
    if format is None:
        format = out.suffix.lower().removeprefix(".")
        if format not in SUFFIXES:
            raise InputError(f"--format: missing, and --out {out} does not tell it; {one_of(format, SUFFIXES)}")
    if format not in SUFFIXES:
        raise InputError(f"--format {format}: {one_of(format, SUFFIXES)}")
    suffix = SUFFIXES[format]
    if out.suffix and out.suffix.lower() != suffix:
        raise InputError(f"--out {out}: should end in {suffix} for --format {format}, or have no suffix")
    target = out if out.suffix else out.parent / f"{out.name}{suffix}"
    if not target.name.isprintable():
        raise InputError(f"--out {target}: the name should have printable characters only")
    prepare_folder(target.parent)
    if not out.name or target.is_dir():
        raise InputError(f"--out {target}: is a folder, should be a file")
    return target, format


@contextmanager
def whole(*targets: Path) -> Iterator[list[Path]]:
    """Yield names for unfinished files or folders, which take the names of the targets when the block ends.

    The last target refers to the others: it goes first and comes last, so that at no instant an old one refers to
    a new one.  What is left ends in `.part` and is removed, however the block ends; what a killed process left, by
    the next export.
    """
    parts = [target.with_name(f"{target.name}.part") for target in targets]
    for part in parts:
        remove(part)
    try:
        yield parts
        if len(targets) > 1:
            targets[-1].unlink(missing_ok=True)
        for part, target in zip(parts, targets, strict=True):
            if target.is_dir():
                shutil.rmtree(target)
            os.replace(part, target)
    finally:
        for part in parts:
            remove(part)


def remove(path: Path) -> None:
    """Remove a file, a link or a folder with all it holds, if it is there; links are not followed."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with suppress(OSError):
            path.unlink(missing_ok=True)

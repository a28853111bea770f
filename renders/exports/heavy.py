"""The HDF5 files of exports; they survive a full disk."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py

from oblique_impact.files import CheckedFile

#: for datasets of a frame: fast, and shuffled bytes of doubles pack well
COMPRESSION: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
_VERSIONS = (
    "v110",
    "v110",
)  # thousands of small datasets: the newer layout describes them in a tenth of the space


class HeavyFile:
    """An HDF5 file being written.

    Attributes
    ----------
    root : h5py.File
        What to write to.
    """

    def __init__(self, root: h5py.File, file: CheckedFile) -> None:
        self.root = root
        self._file = file

    def check(self) -> None:
        """Raise the OSError of the first write that failed, if any."""
        self._file.check()


@contextmanager
def heavy_file(path: Path) -> Iterator[HeavyFile]:
    """Create an HDF5 file; raises OSError if it could not be written."""
    with CheckedFile(path) as file, h5py.File(file, "w", libver=_VERSIONS) as root:
        yield HeavyFile(root, file)

"""HDF5 files that survive a full disk.

HDF5 keeps trying to write what it holds until the process ends, and then crashes.  So it writes through Python:
the first failure is kept here, HDF5 is told that all is well, and the caller gets the error at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


class Guard:
    """A binary file for HDF5 that keeps the first error to itself.

    Attributes
    ----------
    problem : OSError or None
        The first write that failed.
    """

    def __init__(self, raw: Any) -> None:
        self._raw = raw
        self.problem: OSError | None = None

    def check(self) -> None:
        """Raise the OSError of the first write that failed, if any."""
        if self.problem:
            raise self.problem

    def write(self, data: Any) -> int:
        """Write all of `data`, or remember why not."""
        view = memoryview(data).cast("B")
        done = 0
        try:
            while done < len(view) and not self.problem:
                done += self._raw.write(view[done:])
        except OSError as error:
            self.problem = error
        return len(view)

    def truncate(self, size: int) -> int:
        """Set the size, or remember why not."""
        try:
            self._raw.truncate(size)
        except OSError as error:
            self.problem = self.problem or error
        return size

    def seek(self, offset: int, whence: int = 0) -> int:
        """Move."""
        return int(self._raw.seek(offset, whence))

    def tell(self) -> int:
        """Return the place."""
        return int(self._raw.tell())

    def readinto(self, buffer: Any) -> int:
        """Read what there is."""
        return int(self._raw.readinto(buffer))

    def read(self, size: int = -1) -> bytes:
        """Read what there is."""
        return bytes(self._raw.read(size))

    def flush(self) -> None:
        """Nothing is held back."""


@contextmanager
def guarded(path: Path) -> Iterator[Guard]:
    """Create the file `path` for HDF5 to write through; raises OSError if something could not be written."""
    with path.open("w+b", buffering=0) as raw:
        guard = Guard(raw)
        try:
            yield guard
        except (OSError, RuntimeError):
            # HDF5 may stumble over what is missing; the reason is the first failure
            if guard.problem:
                raise guard.problem from None
            raise
        guard.check()

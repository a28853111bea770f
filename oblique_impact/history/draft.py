"""A history that is written while its run goes on: at the end, or at an interrupt, little is left to write."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from oblique_impact.files import prepare_folder, remove, unfinished
from oblique_impact.history.variables import DIMENSIONS

if TYPE_CHECKING:
    import xarray as xr

    from oblique_impact.history.netcdf_writer import NetcdfWriter

#: bytes; from so many on a history is begun: what is less is written in a tenth of a second
BEGIN = 50_000_000
#: bytes that are written together
STEP = 16_000_000


class Draft:
    """A history.nc that is begun in a folder while a run goes on, for the block; `History.save` completes it.

    What goes wrong with it is no error: the history is then written at the end.

    Parameters
    ----------
    folder : path
        Where the history is going to be saved; the caller should be its only writer (`files.writing`).

    Raises
    ------
    InputError
        If the folder cannot be written.

    Examples
    --------
    >>> from oblique_impact import Draft, Scenario, simulate
    >>> with Draft("out") as draft:  # doctest: +SKIP
    ...     simulate(Scenario.builtin("paper"), draft=draft).save("out", draft)
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = prepare_folder(folder)
        self._path = self.folder / ".history.part.nc"
        self._writer: NetcdfWriter | None = None
        self._stack = ExitStack()
        self._given_up = False
        self._bytes = 0
        self._data: xr.Dataset | None = None

    def __enter__(self) -> Draft:
        """Remove what a process that was killed has left."""
        remove(self._path)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Remove the draft, if nobody has completed it."""
        self._discard()

    @property
    def begun(self) -> bool:
        """Whether something is written."""
        return self._writer is not None

    def start(self) -> None:
        """Begin anew, for another run."""
        self._discard()
        self._given_up, self._bytes, self._data = False, 0, None

    def end(self, data: xr.Dataset) -> None:
        """Take note of the data of which this is the draft; the run is over."""
        self._data = data

    def is_of(self, data: xr.Dataset, folder: Path) -> bool:
        """Whether something of these very data is written, in this folder."""
        return self.begun and self._data is data and self.folder == folder

    def advance(self, variables: Mapping[str, NDArray[np.float64]]) -> None:
        """Take variables of a history as far as they have come; they are written once they are large enough."""
        size = sum(values.nbytes for values in variables.values())
        if self._given_up or size < max(BEGIN, self._bytes + STEP):
            return
        try:
            if self._writer is None:
                self._begin()
            assert self._writer is not None
            self._writer.append({name: (DIMENSIONS[name], values) for name, values in variables.items()})
            self._bytes = size
        except Exception:  # of the disk, or of the layers of HDF5
            self._discard()
        except BaseException:
            self._discard()
            raise

    def complete(self, data: xr.Dataset, path: Path) -> None:
        """Write what is missing and move the file to `path`, in the same folder; raises OSError."""
        assert self._writer is not None
        try:
            self._writer.complete(data)
            self._stack.close()
            path.unlink()  # put over a file that is there, all data would be on their way to the disk before
            self._path.rename(path)
        finally:
            self._discard()

    def _begin(self) -> None:
        from oblique_impact.history.netcdf_writer import NetcdfWriter

        self._stack.enter_context(unfinished(self._path))
        self._writer = self._stack.enter_context(NetcdfWriter(self._path, growing="time"))

    def _discard(self) -> None:
        """Leave nothing, now and later."""
        self._given_up, self._writer = True, None
        with suppress(Exception):  # it could not be written, and HDF5 complains again
            self._stack.close()
        remove(self._path)

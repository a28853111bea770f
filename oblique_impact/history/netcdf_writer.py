"""NetCDF-4 files of numbers are written: at once, or row by row while there are more and more of them.

Doubles of a motion do not pack: compression took ten times as long as writing, for files a hundredth smaller.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any

import h5netcdf
import h5py
import numpy as np
import xarray as xr

from oblique_impact.history.hdf5 import guarded

#: newer layouts of HDF5 carry checksums, and take attributes longer than 64 kB
_VERSIONS = ("v110", "v110")
#: values of a variable that grows that are written together: 1 MiB of doubles
_CHUNK = 131_072

Array = np.ndarray[Any, Any]


def write_netcdf(data: xr.Dataset, path: Path) -> None:
    """Write all variables as they are; raises OSError, on a full disk for instance."""
    with NetcdfWriter(path) as writer:
        writer.complete(data)


class NetcdfWriter:
    """A NetCDF-4 file for the block; all that writes raises OSError, on a full disk for instance.

    Parameters
    ----------
    path : Path
        The file, which is replaced.
    growing : str, optional
        The dimension along which variables grow.
    """

    def __init__(self, path: Path, growing: str | None = None) -> None:
        self._path, self._growing = path, growing
        self._written: dict[str, int] = {}
        self._stack = ExitStack()

    def __enter__(self) -> NetcdfWriter:
        """Create the file."""
        with ExitStack() as stack:
            self._guard = stack.enter_context(guarded(self._path))
            self._file = stack.enter_context(h5netcdf.File(self._guard, "w", libver=_VERSIONS))
            if self._growing:
                self._file.dimensions[self._growing] = None
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool | None:
        """Close the file."""
        return self._stack.__exit__(kind, error, trace)

    def append(self, variables: Mapping[str, tuple[tuple[str, ...], Array]]) -> None:
        """Write what is new of growing variables, given as dimensions and all values up to now.

        Pieces that are not whole are left for `complete`.
        """
        for name, (dimensions, values) in variables.items():
            if name not in self._written:
                self._create(name, dimensions, values)
        self._file.resize_dimension(self._growing, len(next(iter(variables.values()))[1]))
        for name, (_, values) in variables.items():
            chunk = self._file[name].chunks[0]
            self._fill(name, values, len(values) // chunk * chunk)
        self._guard.check()

    def complete(self, data: xr.Dataset) -> None:
        """Write all that is not there yet: rows, variables, attributes."""
        if self._growing:
            self._file.resize_dimension(self._growing, data.sizes[self._growing])
        for label, variable in data.variables.items():
            name = str(label)
            if name not in self._written:
                self._create(name, tuple(map(str, variable.dims)), variable.values)
            self._fill(name, variable.values, len(variable))
            self._file[name].attrs.update(_fixed(variable.attrs))
        self._file.attrs.update(_fixed(data.attrs))

    def _create(self, name: str, dimensions: tuple[str, ...], values: Array) -> None:
        for dimension, size in zip(dimensions, values.shape, strict=True):
            if dimension not in self._file.dimensions:
                self._file.dimensions[dimension] = size
        chunks = None
        if self._growing in dimensions:
            columns = values[0].size
            chunks = (max(1, _CHUNK // columns), *values.shape[1:])
        missing = np.nan if values.dtype.kind == "f" else None
        self._file.create_variable(name, dimensions, values.dtype, fillvalue=missing, chunks=chunks)
        self._written[name] = 0

    def _fill(self, name: str, values: Array, stop: int) -> None:
        start = self._written[name]
        if stop > start:
            self._file[name][start:stop] = values[start:stop]
            self._written[name] = stop


def _fixed(attributes: Mapping[Any, Any]) -> dict[Any, Any]:
    """Return attributes with words of fixed length: damage to the others can make HDF5 read for ever.

    They have two letters at least, because the readers of NetCDF take a single one for a byte.
    """
    return {name: _word(value) if isinstance(value, str) else value for name, value in attributes.items()}


def _word(text: str) -> Array:
    content = text.encode("utf-8")
    return np.array(content, dtype=h5py.string_dtype("utf-8", max(2, len(content))))

"""Datasets as NetCDF-4 files: HDF5 with its dimension scales, each variable over time deflated without loss.

Libraries of NetCDF, and xarray, read what is written here (NetCDF-4 File Format, "Creating NetCDF-4 Files with
HDF5").  General writers and readers ask HDF5 for the shape of each variable many times over, which takes as long
as the numbers themselves.
"""

from __future__ import annotations

from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import h5py
import numpy as np
import xarray as xr

from oblique_impact.errors import InputError

#: bytes of a variable above which it is compressed: below, the index of its chunks takes more than that saves
_SMALL: Final = 1 << 14
#: bytes of a chunk, of all values at so many samples as fit: to read some times is to read their chunks
_CHUNK: Final = 1 << 19
#: the bytes of equal weight of all numbers stand together: exponents compress, the last digits do not at any level
_PACKED: Final[dict[str, Any]] = {"shuffle": True, "compression": "gzip", "compression_opts": 1}
#: by which NetCDF knows a dimension without coordinates, with its length behind it
_NO_VARIABLE: Final = "This is a netCDF dimension but not a netCDF variable."


def netcdf_bytes(data: xr.Dataset) -> bytes:
    """Return the content of a NetCDF-4 file with a dataset of numbers and its attributes.

    Raises InputError for a variable of anything but numbers.
    """
    content = BytesIO()  # HDF5 crashes the process if it cannot write to a full disk
    with h5py.File(content, "w") as file:
        file.attrs.update(data.attrs)
        stored: dict[str, h5py.Dataset] = {}
        for name, variable in data.variables.items():
            values = variable.values
            if values.dtype.kind not in "fiu":
                raise InputError(f"history: variable {name!r} is not of numbers: a file cannot keep it")
            stored[str(name)] = file.create_dataset(str(name), data=values, **_layout(values, variable.dims))
            stored[str(name)].attrs.update(variable.attrs)
        scales = dict[str, h5py.Dataset]()
        for number, (name, size) in enumerate(data.sizes.items()):
            scale = stored.get(str(name))
            if scale is None:
                scale = file.create_dataset(str(name), (size,), ">f4")
            scale.make_scale(str(name) if name in stored else f"{_NO_VARIABLE}{size:10d}")
            scale.attrs["_Netcdf4Dimid"] = np.int32(number)
            scales[str(name)] = scale
        for name, dataset in stored.items():
            for axis, dimension in enumerate(map(str, data[name].dims)):
                if dimension != name:
                    dataset.dims[axis].attach_scale(scales[dimension])
    return content.getvalue()


def _layout(values: np.ndarray[Any, Any], dimensions: tuple[Any, ...]) -> dict[str, Any]:
    if values.nbytes <= _SMALL or dimensions[0] != "time":
        return {}
    samples = max(1, _CHUNK * len(values) // values.nbytes)
    return {**_PACKED, "chunks": (min(samples, len(values)), *values.shape[1:])}


def read_netcdf(file: Path) -> xr.Dataset:
    """Return the dataset of a file that :func:`netcdf_bytes`, or an earlier version, has made."""
    found: dict[str, xr.Variable] = {}
    with h5py.File(file) as opened:
        for name, dataset in opened.items():
            attributes = dict(dataset.attrs)
            if str(attributes.get("NAME", b""), "ascii").startswith(_NO_VARIABLE):
                continue
            dimensions = (name,) if dataset.is_scale else tuple(axis[0].name[1:] for axis in dataset.dims)
            # the fast path leaves out a check for which xarray imports dask where it finds it, half a second
            found[name] = xr.Variable(dimensions, dataset[...], _own(attributes), fastpath=True)
        return xr.Dataset(found, attrs=_own(dict(opened.attrs)))


def _own(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Leave out the attributes of HDF5's dimension scales and of NetCDF."""
    scales = ("CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST", "_FillValue")
    return {key: value for key, value in attributes.items() if key not in scales and not key.startswith("_N")}

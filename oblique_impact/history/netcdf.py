"""NetCDF-4 files of numbers: written through h5netcdf, read through xarray.

A file from elsewhere may be damaged, or made to do harm.  What a history never holds is refused by its
description alone, before a value is read: links, groups, other files, objects, user-defined filters, more than
memory should be asked for.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5netcdf
import h5py
import numpy as np
import xarray as xr
from h5py import h5a, h5d, h5l, h5t, h5z

from oblique_impact.errors import InputError
from oblique_impact.files import checked_file

#: bytes; what the variables of a file may hold together
MAX_BYTES = 8_000_000_000
#: bytes; what a file may hold besides the values of its variables
MAX_BESIDES = 256_000_000
#: variables, and attributes of each
MAX_VARIABLES = 1000
#: bytes; what is unpacked at once
MAX_CHUNK = 256_000_000
#: bytes; variables that take more than this may not be packed to less than a part of `MAX_RATIO`
FREE, MAX_RATIO = 100_000_000, 20

#: attribute with the names of the dimensions of a variable
DIMENSIONS_ATTRIBUTE = "dimensions"

_WRITTEN_HERE, _LONGEST = "oblique-impact history", 200
_FILTERS = (h5z.FILTER_DEFLATE, h5z.FILTER_SHUFFLE, h5z.FILTER_FLETCHER32)
#: how NetCDF names the empty variable that stands for a dimension without values
_ONLY_A_DIMENSION = "This is a netCDF dimension but not a netCDF variable."
#: NetCDF's own attributes that refer to the dimensions of a variable and from there to the variable
_SCALES = (b"DIMENSION_LIST", b"REFERENCE_LIST")
#: newer layouts of HDF5 carry checksums, and take attributes longer than 64 kB
_VERSIONS = ("v110", "v110")


def write_netcdf(data: xr.Dataset, path: Path) -> None:
    """Write all variables as they are; raises OSError, on a full disk for instance.

    Doubles of a motion do not pack: compression took ten times as long as writing, for files a hundredth smaller.
    """
    with checked_file(path) as raw, h5netcdf.File(raw, "w", libver=_VERSIONS) as file:
        file.dimensions = dict(data.sizes)
        for name, variable in data.variables.items():
            missing = np.nan if variable.dtype.kind == "f" else None
            stored = file.create_variable(str(name), variable.dims, variable.dtype, fillvalue=missing)
            stored[...] = variable.values
            stored.attrs.update(_fixed(variable.attrs))
        file.attrs.update(_fixed(data.attrs))


def _fixed(attributes: Mapping[Any, Any]) -> dict[Any, Any]:
    """Return attributes with words of fixed length: damage to the others can make HDF5 read for ever.

    They have two letters at least, because the readers of NetCDF take a single one for a byte.
    """
    return {name: _word(value) if isinstance(value, str) else value for name, value in attributes.items()}


def _word(text: str) -> np.ndarray[Any, Any]:
    content = text.encode("utf-8")
    return np.array(content, dtype=h5py.string_dtype("utf-8", max(2, len(content))))


def read_netcdf(path: Path) -> xr.Dataset:
    """Read all variables, and the attributes that are words or numbers.

    Raises
    ------
    InputError
        If the file holds what no history holds; the message lacks the name of the file.
    Exception
        Whatever the layers of the reader raise for a damaged file.
    """
    with h5py.File(path, "r") as file:
        checked = _check_file(file, path.stat().st_size)
    with xr.open_dataset(path, engine="h5netcdf", decode_cf=False) as opened:
        if opened.nbytes > checked:
            raise InputError(f"declares {opened.nbytes:.3g} bytes that are not there")
        data = opened.load()
    data.attrs = _plain(data.attrs)
    for variable in data.variables.values():
        variable.attrs = _plain(variable.attrs)
    return data


def _plain(attributes: Mapping[Any, Any]) -> dict[str, Any]:
    """Return the attributes that are words or numbers; NetCDF's own are not among them."""
    found = {}
    for name, value in attributes.items():
        kind = "U" if isinstance(value, str) else np.asarray(value).dtype.kind
        if kind in "Uiuf" and not name.startswith("_") and name != DIMENSIONS_ATTRIBUTE:
            found[str(name)] = value
    return found


def _check_file(file: h5py.File, size: int) -> int:
    """Refuse a file of `size` bytes by its description, without its values; returns their size (bytes)."""
    if file.id.get_num_objs() > MAX_VARIABLES:
        raise InputError(f"more than {MAX_VARIABLES} variables")
    _check_attributes(file.id, "file")
    total, stored = 0, 0
    for name in file:
        if file.id.links.get_info(name.encode()).type != h5l.TYPE_HARD:
            raise InputError(f"{name}: is a link; a history holds everything itself")
        dataset = file[name]
        if not isinstance(dataset, h5py.Dataset):
            raise InputError(f"{name}: is not a variable")
        stored += dataset.id.get_storage_size()
        _check_attributes(dataset.id, name)
        total += _checked_size(dataset, name)
    if total > MAX_BYTES:
        raise InputError(f"its variables would take {total:.3g} bytes, at most {MAX_BYTES:.3g} are read")
    if total > max(FREE, MAX_RATIO * size):
        raise InputError(f"would unpack from {size:.3g} to {total:.3g} bytes; a history is not packed like that")
    if size - stored > MAX_BESIDES:
        raise InputError(f"holds more than {MAX_BESIDES:.3g} bytes besides its variables")
    for name in file:
        if not any(h5a.exists(file[name].id, attribute) for attribute in (b"DIMENSION_LIST", b"CLASS")):
            raise InputError(f"{name}: should have values along time, coordinate or station")
    return total


def _checked_size(dataset: h5py.Dataset, name: str) -> int:
    """Return the size (bytes) of a variable that may be read; 0 for a dimension that has no values."""
    number = dataset.id.get_type()
    if number.get_class() not in (h5t.INTEGER, h5t.FLOAT) or number.get_size() > 8:
        raise InputError(f"{name}: does not hold numbers")
    if dataset.shape is None or not 1 <= dataset.ndim <= 2:
        raise InputError(f"{name}: should have one or two dimensions")
    properties = dataset.id.get_create_plist()
    if properties.get_layout() == h5d.VIRTUAL or properties.get_external_count():
        raise InputError(f"{name}: lies in another file; a history holds everything itself")
    if any(properties.get_filter(place)[0] not in _FILTERS for place in range(properties.get_nfilters())):
        raise InputError(f"{name}: is packed with a filter that histories do not use")
    if _ONLY_A_DIMENSION in str(dataset.attrs.get("NAME")):
        return 0
    size: int = number.get_size() * math.prod(dataset.shape)
    if size > MAX_BYTES:
        raise InputError(f"{name}: would take {size:.3g} bytes, at most {MAX_BYTES:.3g} are read")
    if not size or not _is_stored(dataset, size):
        raise InputError(f"{name}: declares {size:.3g} bytes that are not there")
    return size


def _is_stored(dataset: h5py.Dataset, size: int) -> bool:
    """Whether a variable is there as declared; HDF5 would fill up what is missing."""
    if dataset.chunks is None:
        return bool(dataset.id.get_storage_size() >= size)
    if dataset.dtype.itemsize * math.prod(dataset.chunks) > MAX_CHUNK:
        return False
    pieces = math.prod(-(-extent // chunk) for extent, chunk in zip(dataset.shape, dataset.chunks, strict=True))
    return bool(dataset.id.get_num_chunks() == pieces)


def _check_attributes(place: Any, name: str) -> None:
    """Refuse attributes (of an object of HDF5's low level) that are too many or too large."""
    count = h5a.get_num_attrs(place)
    if count > MAX_VARIABLES:
        raise InputError(f"{name}: more than {MAX_VARIABLES} attributes")
    for attribute in (h5a.open(place, index=index) for index in range(count)):
        kind = attribute.get_type()
        if kind.get_class() not in (h5t.INTEGER, h5t.FLOAT, h5t.STRING) and attribute.name not in _SCALES:
            raise InputError(f"{name}: attribute {attribute.name.decode('utf-8', 'replace')} is no word or number")
        if math.prod(attribute.shape) * kind.get_size() > MAX_BESIDES:
            raise InputError(f"{name}: an attribute is larger than {MAX_BESIDES:.3g} bytes")


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
            return (value if isinstance(value, str) else value.decode()).startswith(_WRITTEN_HERE)
    except KeyError:
        return False
    except Exception:  # cut off or damaged, whatever the reader's layers raise
        return True

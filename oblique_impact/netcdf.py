"""NetCDF-4 files of numbers in and out.  A file is looked over before anything of it is read.

A file from elsewhere may be damaged, or made to do harm.  What a history never holds is refused by its description
alone: links, groups, other files, objects, filters of one's own, more than memory should be asked for.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import h5netcdf
import h5py
import xarray as xr
from h5py import h5a, h5d, h5l, h5t, h5z

from oblique_impact.errors import InputError
from oblique_impact.hdf5 import guarded

#: bytes; what the variables of a file may hold together
MAX_BYTES = 16_000_000_000
#: bytes; what a file may hold besides the values of its variables
MAX_BESIDES = 256_000_000
#: variables, and attributes of each
MAX_VARIABLES = 1000
#: bytes; what is unpacked at once
MAX_CHUNK = 256_000_000

_FILTERS = (h5z.FILTER_DEFLATE, h5z.FILTER_SHUFFLE, h5z.FILTER_FLETCHER32)
#: the reader would change values by them
_FORBIDDEN = ("scale_factor", "add_offset")


def write_netcdf(path: Path, data: xr.Dataset) -> None:
    """Write all variables as they are; raises OSError, on a full disk for instance.

    Doubles of a motion do not pack: compression took ten times as long as writing, for files a hundredth smaller.
    """
    with guarded(path) as guard, h5netcdf.File(guard, "w") as file:
        data.dump_to_store(xr.backends.H5NetCDFStore(file))


def read_netcdf(path: Path) -> xr.Dataset:
    """Read all variables and attributes.

    Raises
    ------
    InputError
        If the file holds what no history holds; the message lacks the name of the file.
    Exception
        Whatever the layers of the reader raise for a damaged file.
    """
    look_over(path)
    with xr.open_dataset(path, engine="h5netcdf", decode_times=False) as opened:
        return opened.load()


def look_over(path: Path) -> None:
    """Refuse a file by its description; nothing of its values is read."""
    with h5py.File(path, "r") as file:
        links = file.id.links
        if file.id.get_num_objs() > MAX_VARIABLES:
            raise InputError(f"more than {MAX_VARIABLES} variables")
        names = list(file)
        total = stored = 0
        _check_attributes(file.id, "file")
        for name in names:
            if links.get_info(name.encode()).type != h5l.TYPE_HARD:
                raise InputError(f"{name}: is a link; a history holds everything itself")
            dataset = file[name]
            if not isinstance(dataset, h5py.Dataset):
                raise InputError(f"{name}: is not a variable")
            total += _check_variable(dataset, name)
            stored += dataset.id.get_storage_size()
        if total > MAX_BYTES:
            raise InputError(f"its variables would take {total:.3g} bytes, at most {MAX_BYTES:.3g} are read")
        if path.stat().st_size - stored > MAX_BESIDES:
            raise InputError(f"holds more than {MAX_BESIDES:.3g} bytes besides its variables")


def _check_variable(dataset: h5py.Dataset, name: str) -> int:
    """Return the size in memory (bytes) of a variable that may be read."""
    number = dataset.id.get_type()
    if number.get_class() not in (h5t.INTEGER, h5t.FLOAT) or number.get_size() > 8:
        raise InputError(f"{name}: does not hold numbers")
    if dataset.shape is None or not 1 <= dataset.ndim <= 2:
        raise InputError(f"{name}: should have one or two dimensions")
    properties = dataset.id.get_create_plist()
    if properties.get_layout() == h5d.VIRTUAL or properties.get_external_count():
        raise InputError(f"{name}: lies in another file; a history holds everything itself")
    for place in range(properties.get_nfilters()):
        if properties.get_filter(place)[0] not in _FILTERS:
            raise InputError(f"{name}: is packed with a filter that histories do not use")
    _check_attributes(dataset.id, name)
    size = number.get_size() * math.prod(dataset.shape)
    if size > MAX_BYTES:
        raise InputError(f"{name}: would take {size:.3g} bytes, at most {MAX_BYTES:.3g} are read")
    dimension = dataset.attrs.get("CLASS") == b"DIMENSION_SCALE" and dataset.id.get_storage_size() == 0
    if size and not dimension:
        _check_stored(dataset, name, size)
    # NumPy holds what xarray makes of it in eight bytes at most
    return 0 if dimension and name not in ("time", "station") else 8 * math.prod(dataset.shape)


def _check_stored(dataset: h5py.Dataset, name: str, size: int) -> None:
    """Refuse a variable that declares more than is there: the reader would fill it up."""
    if dataset.chunks is None:
        if dataset.id.get_storage_size() < size:
            raise InputError(f"{name}: declares {size:.3g} bytes that are not there")
        return
    if dataset.dtype.itemsize * math.prod(dataset.chunks) > MAX_CHUNK:
        raise InputError(f"{name}: pieces larger than {MAX_CHUNK:.3g} bytes")
    needed = math.prod(-(-extent // chunk) for extent, chunk in zip(dataset.shape, dataset.chunks, strict=True))
    if dataset.id.get_num_chunks() != needed:
        raise InputError(f"{name}: declares {size:.3g} bytes that are not there")


def _check_attributes(place: Any, name: str) -> None:
    if h5a.get_num_attrs(place) > MAX_VARIABLES:
        raise InputError(f"{name}: more than {MAX_VARIABLES} attributes")
    for index in range(h5a.get_num_attrs(place)):
        attribute = h5a.open(place, index=index)
        label = attribute.name.decode("utf-8", "replace")
        if label in _FORBIDDEN:
            raise InputError(f"{name}: attribute {label} is not one of a history")
        if math.prod(attribute.shape) * attribute.get_type().get_size() > MAX_BESIDES:
            raise InputError(f"{name}: attribute {label} is larger than {MAX_BESIDES:.3g} bytes")

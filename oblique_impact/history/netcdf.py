"""NetCDF-4 files of numbers, from anywhere: a file is looked over before anything of it is read.

A file from elsewhere may be damaged, or made to do harm.  What a history never holds is refused by its description
alone: links, groups, other files, objects, filters of one's own, more than memory should be asked for.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import h5py
import xarray as xr
from h5py import h5a, h5d, h5l, h5t, h5z

from oblique_impact.errors import InputError

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

_FILTERS = (h5z.FILTER_DEFLATE, h5z.FILTER_SHUFFLE, h5z.FILTER_FLETCHER32)
#: a variable of NetCDF that stands for the coordinates and has no values
_ONLY_A_DIMENSION = "coordinate"
#: attribute with the names of the dimensions of a variable that a history need not have
DIMENSIONS_ATTRIBUTE = "dimensions"
#: NetCDF's own attributes
_NETCDF = ("CLASS", "NAME")


def read_netcdf(path: Path, dimensions: Mapping[str, tuple[str, ...]]) -> xr.Dataset:
    """Read all variables, and the attributes that are words or numbers.

    Parameters
    ----------
    path : Path
        The file.
    dimensions : mapping
        Names of the dimensions of the variables that are known.  The file's own lists of dimensions are
        references to objects, which damage turns into anything: they are not followed.

    Raises
    ------
    InputError
        If the file holds what no history holds; the message lacks the name of the file.
    Exception
        Whatever the layers of the reader raise for a damaged file.
    """
    with h5py.File(path, "r") as file:
        names = _look_over(file, path.stat().st_size)
        known = {name: dimensions[name] for name in names if name in dimensions}
        sizes: dict[str, int] = {}
        for name, its in known.items():
            if file[name].ndim != len(its):
                raise InputError(f"{name}: should have the dimensions ({', '.join(its)})")
            for dimension, size in zip(its, file[name].shape, strict=True):
                if sizes.setdefault(dimension, size) != size:
                    raise InputError(
                        f"{name}: has {size} values along {dimension}, others have {sizes[dimension]}"
                    )
        variables = {}
        for name in names:
            attributes = _attributes(file[name].id)
            named = attributes.pop(DIMENSIONS_ATTRIBUTE, None)
            its = known.get(name) or _named(name, named, file[name].shape, sizes)
            variables[name] = (its, file[name][()], attributes)
        scales = [name for name in variables if name in sizes]
        return xr.Dataset(
            {name: variable for name, variable in variables.items() if name not in scales},
            {name: variables[name] for name in scales},
            _attributes(file.id),
        )


def _named(name: str, words: Any, shape: tuple[int, ...], sizes: dict[str, int]) -> tuple[str, ...]:
    """Return the dimensions of a variable that is not known, which its attribute names."""
    if not isinstance(words, str):
        raise InputError(f"{name}: lacks the attribute {DIMENSIONS_ATTRIBUTE!r}, the names of its dimensions")
    found = tuple(words.split())
    if shape != tuple(sizes.get(dimension, -1) for dimension in found):
        raise InputError(f"{name}: should have values along {', '.join(sizes)}")
    return found


def _attributes(place: Any) -> dict[str, Any]:
    """Return the attributes of an object that are words or numbers; NetCDF's own are not among them."""
    found: dict[str, Any] = {}
    for attribute in _opened(place):
        label, its = attribute.name.decode("utf-8", "replace"), attribute.get_type()
        known = its.get_class() in (h5t.INTEGER, h5t.FLOAT) or _is_word(its)
        if known and not label.startswith("_") and label not in _NETCDF:
            value = h5py.AttributeManager(_Owner(place))[label]
            found[label] = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
    return found


def _is_word(its: Any) -> bool:
    return bool(its.get_class() == h5t.STRING and not its.is_variable_str())


class _Owner:
    """What h5py's attributes ask of an object."""

    def __init__(self, place: Any) -> None:
        self.id = place


def _opened(place: Any) -> Iterator[Any]:
    if h5a.get_num_attrs(place) > MAX_VARIABLES:
        raise InputError(f"more than {MAX_VARIABLES} attributes")
    for index in range(h5a.get_num_attrs(place)):
        yield h5a.open(place, index=index)


def _look_over(file: h5py.File, size: int) -> list[str]:
    """Refuse a file by its description; nothing of its values is read.  Returns the names of its variables."""
    if file.id.get_num_objs() > MAX_VARIABLES:
        raise InputError(f"more than {MAX_VARIABLES} variables")
    _check_attributes(file.id, "file")
    names, total, stored = [], 0, 0
    for name in file:
        if file.id.links.get_info(name.encode()).type != h5l.TYPE_HARD:
            raise InputError(f"{name}: is a link; a history holds everything itself")
        dataset = file[name]
        if not isinstance(dataset, h5py.Dataset):
            raise InputError(f"{name}: is not a variable")
        stored += dataset.id.get_storage_size()
        if name != _ONLY_A_DIMENSION:
            names.append(name)
            total += _check_variable(dataset, name)
    if total > MAX_BYTES:
        raise InputError(f"its variables would take {total:.3g} bytes, at most {MAX_BYTES:.3g} are read")
    if total > max(FREE, MAX_RATIO * size):
        raise InputError(f"would unpack from {size:.3g} to {total:.3g} bytes; a history is not packed like that")
    if size - stored > MAX_BESIDES:
        raise InputError(f"holds more than {MAX_BESIDES:.3g} bytes besides its variables")
    return names


def _check_variable(dataset: h5py.Dataset, name: str) -> int:
    """Return the size (bytes) of a variable that may be read."""
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
    for attribute in _opened(place):
        if math.prod(attribute.shape) * attribute.get_type().get_size() > MAX_BESIDES:
            raise InputError(f"{name}: an attribute is larger than {MAX_BESIDES:.3g} bytes")

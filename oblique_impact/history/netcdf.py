"""NetCDF-4 files of numbers: written through h5netcdf, read through h5py, which takes a fifth of xarray's time.

A file from elsewhere may be damaged, or made to do harm.  What a history never holds is refused by its
description alone, before a value is read: links, groups, other files, objects, too much memory.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5netcdf
import h5py
import numpy as np
from h5py import h5a, h5d, h5r, h5t

from oblique_impact.errors import InputError
from oblique_impact.files import CheckedFile
from oblique_impact.history.variables import Stored

if TYPE_CHECKING:
    from xarray import Dataset

#: bytes; what the variables of a file may hold together
MAX_BYTES = 8_000_000_000
#: bytes; variables that take more than this may not be packed to less than a part of `MAX_RATIO`
FREE, MAX_RATIO = 100_000_000, 20

#: attributes of NetCDF, and the name of a dimension that has no values
_OWN = ("CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST")
_NO_VARIABLE = b"This is a netCDF dimension but not a netCDF variable"
_ALONG = "should have values along time, coordinate or station"

#: newer layouts of HDF5 carry checksums, and take attributes longer than 64 kB
_VERSIONS = ("v110", "v110")


def write_netcdf(variables: Iterable[Stored], attributes: Mapping[str, Any], path: Path) -> None:
    """Write all variables as they are; raises OSError, on a full disk for instance.

    Doubles of a motion do not pack: compression took ten times as long as writing, for files a hundredth smaller.
    """
    with CheckedFile(path) as raw, h5netcdf.File(raw, "w", libver=_VERSIONS) as file:
        for name, dimensions, values, described in variables:
            for dimension, size in zip(dimensions, values.shape, strict=True):
                if dimension not in file.dimensions:
                    file.dimensions[dimension] = size
            missing = np.nan if values.dtype.kind == "f" else None
            variable = file.create_variable(name, dimensions, values.dtype, fillvalue=missing)
            variable[...] = values
            variable.attrs.update(_fixed(described))
        file.attrs.update(_fixed(attributes))


def _fixed(attributes: Mapping[Any, Any]) -> dict[Any, Any]:
    """Return attributes with words of fixed length: damage to the others can make HDF5 read for ever.

    They have two letters at least, because the readers of NetCDF take a single one for a byte.
    """
    words = {name: value.encode("utf-8") for name, value in attributes.items() if isinstance(value, str)}
    fixed = {k: np.array(word, h5py.string_dtype("utf-8", max(2, len(word)))) for k, word in words.items()}
    return {**attributes, **fixed}


def read_netcdf(path: Path) -> Dataset:
    """Read all variables, and the attributes that are words or numbers.

    Raises
    ------
    InputError
        If the file holds what no history holds; the message lacks the name of the file.
    Exception
        Whatever the layers of the reader raise for a damaged file.
    """
    from xarray import Dataset

    with h5py.File(path, "r") as file:
        found = {name: _checked(file, name) for name in file}
        total = sum(variable.nbytes for variable in found.values())
        if total > min(MAX_BYTES, max(FREE, MAX_RATIO * path.stat().st_size)):
            raise InputError(f"would unpack to {total:.3g} bytes; a history is not packed like that")
        variables = {
            name: (_dimensions(file, name, found), variable[()], _plain(variable.attrs))
            for name, variable in sorted(found.items(), key=lambda item: item[1].is_scale)
            if not bytes(variable.attrs.get("NAME", b"")).startswith(_NO_VARIABLE)
        }
        return Dataset(variables, attrs=_plain(file.attrs))


def _dimensions(file: h5py.File, name: str, found: Mapping[str, h5py.Dataset]) -> list[str]:
    """Return the names of a variable's dimensions; raises InputError if it has another size than they."""
    variable, names = found[name], [name]
    if not variable.is_scale:
        scales = [of_axis[-1] for of_axis in variable.attrs["DIMENSION_LIST"]]
        names = [h5r.get_name(scale, file.id).decode().lstrip("/") for scale in scales]
    if not set(names) <= found.keys():
        raise InputError(f"{name}: {_ALONG}")
    if variable.shape != tuple(found[dimension].shape[0] for dimension in names):
        raise InputError(f"{name}: does not have the size of its dimensions")
    return names


def _plain(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Return the attributes that are words or numbers; NetCDF's own are not among them.

    Raises InputError for one that refers to something else.
    """
    found = {}
    for name in attributes:
        if not name.startswith("_") and name not in _OWN:
            value = attributes[name]
            if isinstance(value, bytes):
                value = value.decode("utf-8", "surrogateescape")
            elif isinstance(value, np.ndarray):
                value = value.tolist() if value.dtype.kind == "O" else value
                value = value[0] if np.shape(value) == (1,) else value
            kind = np.asarray(value).dtype.kind
            if kind == "O" and not isinstance(value, h5py.Empty):
                raise InputError(f"{name}: is neither words nor numbers")
            if kind in "Uiuf":
                found[name] = value
    return found


def _lies_elsewhere(variable: h5py.Dataset) -> bool:
    # no property list stays with the variable: HDF5 crashes at exit if one of a virtual layout is still open
    properties = variable.id.get_create_plist()
    return bool(properties.get_layout() == h5d.VIRTUAL or properties.get_external_count())


def _checked(file: h5py.File, name: str) -> h5py.Dataset:
    """Return a variable whose description says that it may be read."""
    if not isinstance(file.get(name, getlink=True), h5py.HardLink):
        raise InputError(f"{name}: is a link; a history holds everything itself")
    variable = file[name]
    if not isinstance(variable, h5py.Dataset):
        raise InputError(f"{name}: is not a variable")
    if variable.dtype.kind not in "iuf":
        raise InputError(f"{name}: does not hold numbers")
    if variable.shape is None or not 1 <= variable.ndim <= 2:
        raise InputError(f"{name}: should have one or two dimensions")
    if _lies_elsewhere(variable):
        raise InputError(f"{name}: lies in another file; a history holds everything itself")
    if not variable.is_scale and "DIMENSION_LIST" not in variable.attrs:
        raise InputError(f"{name}: {_ALONG}")
    return variable


def is_history(file: Path) -> bool:
    """Whether a file may be a history of this program, of whatever version and in whatever state."""
    if not h5py.is_hdf5(file):
        return False
    try:
        with h5py.File(file, "r") as opened:
            kind = h5a.open(opened.id, b"format").get_type()
            if kind.get_class() != h5t.STRING or kind.is_variable_str():
                # a word of variable length is a reference, which damage turns into anything: not followed
                return bool(kind.get_class() == h5t.STRING)
            value = opened.attrs["format"]
            return (value if isinstance(value, str) else value.decode()).startswith("oblique-impact history")
    except KeyError:
        return False
    except Exception:  # cut off or damaged, whatever the reader's layers raise
        return True

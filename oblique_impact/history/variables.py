"""The variables of a history: names, dimensions, units, meanings; files from elsewhere are held against them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from oblique_impact.contact.state import State
from oblique_impact.errors import InputError

if TYPE_CHECKING:
    from xarray import Dataset

Array = np.ndarray[Any, Any]


class Variable(NamedTuple):
    """What a variable is: its dimensions, unit and meaning."""

    dimensions: tuple[str, ...]
    units: str
    long_name: str


class Stored(NamedTuple):
    """A variable as it is stored."""

    name: str
    dimensions: tuple[str, ...]
    values: Array
    attributes: dict[str, Any]


_EACH, _COORDINATES, _STATIONS = ("time",), ("time", "coordinate"), ("time", "station")
#: variables of every history
NEEDED = {
    "time": Variable(_EACH, "s", "time"),
    "q": Variable(_COORDINATES, "m or rad", "generalized coordinates"),
    "qd": Variable(_COORDINATES, "m/s or rad/s", "generalized velocities"),
    "gap": Variable(_EACH, "m", "normal gap"),
    "slip": Variable(_EACH, "m", "tangential position on the slope"),
    "gap_rate": Variable(_EACH, "m/s", "gap rate"),
    "slip_rate": Variable(_EACH, "m/s", "slip velocity"),
    "lambda_n": Variable(_EACH, "N", "normal contact force"),
    "lambda_tau": Variable(_EACH, "N", "tangential contact force"),
    "state": Variable(_EACH, "1", "contact state"),
    "energy_kinetic": Variable(_EACH, "J", "kinetic energy"),
    "energy_elastic": Variable(_EACH, "J", "elastic energy"),
    "energy_gravity": Variable(_EACH, "J", "gravity energy"),
}
#: variables that only a beam has, if they are there
OF_A_BEAM = {
    "station": Variable(("station",), "m", "arc length from the root"),
    "theta": Variable(_EACH, "rad", "angle of the floating frame"),
    "theta_dot": Variable(_EACH, "rad/s", "angular velocity of the floating frame"),
    "tip_x": Variable(_EACH, "m", "contact point, inertial x"),
    "tip_y": Variable(_EACH, "m", "contact point, inertial y"),
    "tip_vx": Variable(_EACH, "m/s", "contact point velocity, x"),
    "tip_vy": Variable(_EACH, "m/s", "contact point velocity, y"),
    "deflection": Variable(_EACH, "m", "transverse deflection of the axis at the contact point"),
    "shortening": Variable(_EACH, "m", "axial displacement of the axis at the contact point (foreshortening)"),
    "clearance": Variable(_EACH, "m", "smallest distance of the beam from the slope, negative below"),
    "clearance_at": Variable(_EACH, "m", "arc length where the beam is closest to the slope"),
    "ux": Variable(_STATIONS, "m", "axial displacement in the floating frame"),
    "uy": Variable(_STATIONS, "m", "transverse displacement in the floating frame"),
    "ux_dot": Variable(_STATIONS, "m/s", "rate of ux in the floating frame"),
    "uy_dot": Variable(_STATIONS, "m/s", "rate of uy in the floating frame"),
    "moment": Variable(_STATIONS, "N m", "bending moment"),
    "shear": Variable(_STATIONS, "N", "shear force, slope of the bending moment"),
    "axial_force": Variable(_STATIONS, "N", "axial force, tension positive"),
    "bending_stress": Variable(_STATIONS, "Pa", "bending stress at the outer fibre"),
}
#: all variables that are known
VARIABLES = NEEDED | OF_A_BEAM


def stored(columns: Mapping[str, Array]) -> Iterator[Stored]:
    """Yield the variables of a history with their units and meanings; `columns` are known ones, by name."""
    for name, values in columns.items():
        dimensions, units, long_name = VARIABLES[name]
        attributes: dict[str, Any] = {"units": units, "long_name": long_name}
        if name == "state":
            attributes["flag_values"] = np.array([int(s) for s in State], dtype=np.int8)
            attributes["flag_meanings"] = " ".join(s.name.lower() for s in State)
        yield Stored(name, dimensions, values, attributes)


def dataset(columns: Mapping[str, Array]) -> Dataset:
    """Return them as labelled arrays."""
    from xarray import Dataset

    found = Dataset({name: (dimensions, *rest) for name, dimensions, *rest in stored(columns)})
    return found.set_coords([name for name, variable in found.variables.items() if variable.dims == (name,)])


def names_at_once(columns: Mapping[str, Array]) -> list[str]:
    """Return the names of the columns that are there without computing anything."""
    later = getattr(columns, "LATER", ())
    return [name for name in columns if name not in later]


def with_later(data: Dataset, columns: Mapping[str, Array]) -> Dataset:
    """Return all variables, where `data` are those of :func:`names_at_once`."""
    later = {name: tuple(rest) for name, *rest in stored(columns) if name not in data.variables}
    return data.assign(later)


def check_variables(data: Dataset) -> None:
    """Raise InputError, in a few words, for data that are not those of a history."""
    for name in NEEDED:
        if name not in data.variables:
            raise InputError(f"has no variable {name!r}")
    for name, variable in VARIABLES.items():
        if name in data.variables and data[name].dims != variable.dimensions:
            raise InputError(f"{name}: should have the dimensions ({', '.join(variable.dimensions)})")
    for label, array in data.variables.items():
        if not set(array.dims) <= {"time", "coordinate", "station"} or not array.size:
            raise InputError(f"{label}: should have values along time, coordinate or station")
    _check_ascending(data["time"].values, "time")
    if not np.isin(data["state"].values, [int(state) for state in State]).all():
        raise InputError(f"state: should be one of {', '.join(str(int(state)) for state in State)}")
    if "station" in data.dims:
        if "station" not in data.variables or data.sizes["station"] < 2:
            raise InputError("station: at least two places are needed")
        _check_ascending(data["station"].values, "station")


def _check_ascending(values: Array, name: str) -> None:
    if not np.isfinite(values).all() or not (np.diff(values) > 0.0).all():
        raise InputError(f"{name}: should be finite and ascending")

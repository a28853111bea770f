"""Variables of a history: names, dimensions, units, meanings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from oblique_impact.contact.state import State

Array = np.ndarray[Any, Any]


class Variable(NamedTuple):
    """Dimensions, unit, meaning of a variable, and a note on its use."""

    dimensions: tuple[str, ...]
    units: str
    long_name: str
    comment: str = ""


_TIME, _COORDINATES, _STATIONS = ("time",), ("time", "coordinate"), ("time", "station")
_CONTACTS = ("time", "contact")
_POINT = "the point of the axis at contact.point: the beam's tip only where that is beam.length"
_FINITE = (
    "the finite force: its integral over time leaves out the impulses of impacts, which events and contacts hold"
)
_WHOLE = f"with the push along the slide at an end of a bed, which lambda_tau leaves out; {_FINITE}"
#: variables of every history
OF_A_SYSTEM = {
    "time": Variable(_TIME, "s", "time"),
    "q": Variable(_COORDINATES, "m or rad", "generalized coordinates"),
    "qd": Variable(_COORDINATES, "m/s or rad/s", "generalized velocities"),
    "gap": Variable(
        _TIME,
        "m",
        "normal gap",
        "that of the coordinates q: what they leave out of the contact point (contact.residual_flexibility) is "
        "not in it, so that -gap is more than the compression of the stop, depth",
    ),
    "slip": Variable(_TIME, "m", "tangential position on the slope"),
    "gap_rate": Variable(_TIME, "m/s", "gap rate"),
    "slip_rate": Variable(_TIME, "m/s", "slip velocity"),
    "depth": Variable(
        _TIME,
        "m",
        "compression of the stop itself",
        "0 in flight and of a rigid stop; the force of a spring without damping is contact.stiffness times depth",
    ),
    "lambda_n": Variable(_TIME, "N", "normal contact force", _FINITE),
    "lambda_tau": Variable(_TIME, "N", "tangential contact force", _FINITE),
    "state": Variable(_TIME, "1", "contact state"),
    "energy_kinetic": Variable(_TIME, "J", "kinetic energy"),
    "energy_elastic": Variable(_TIME, "J", "elastic energy, that of root.stiffness included"),
    "energy_gravity": Variable(_TIME, "J", "gravity energy"),
    "energy_contact": Variable(
        _TIME,
        "J",
        "energy in stops and contact flexibilities",
        "what elastic stops, beds, residual and axial flexibility hold; of a user-defined law the work of its "
        "force at rest",
    ),
    "contact_gap": Variable(_CONTACTS, "m", "normal gap of a contact"),
    "contact_slip": Variable(
        _CONTACTS,
        "m",
        "tangential position of a contact",
        "of a point of the beam along the side; of an obstacle point minus its place along the beam",
    ),
    "contact_slip_rate": Variable(_CONTACTS, "m/s", "slip velocity of a contact"),
    "contact_lambda_n": Variable(_CONTACTS, "N", "normal force of a contact", _FINITE),
    "contact_lambda_tau": Variable(_CONTACTS, "N", "tangential force of a contact", _FINITE),
    "contact_state": Variable(_CONTACTS, "1", "state of a contact"),
}
#: of these, what older files do not have
ADDED_LATER = {"energy_contact"}
#: variables that only a beam has
OF_A_BEAM = {
    "station": Variable(("station",), "m", "arc length from the root"),
    "theta": Variable(_TIME, "rad", "angle of the floating frame"),
    "theta_dot": Variable(_TIME, "rad/s", "angular velocity of the floating frame"),
    "tip_x": Variable(_TIME, "m", "contact point, inertial x", _POINT),
    "tip_y": Variable(_TIME, "m", "contact point, inertial y", _POINT),
    "tip_vx": Variable(_TIME, "m/s", "contact point velocity, x"),
    "tip_vy": Variable(_TIME, "m/s", "contact point velocity, y"),
    "deflection": Variable(_TIME, "m", "transverse deflection of the axis at the contact point"),
    "shortening": Variable(_TIME, "m", "axial displacement of the axis at the contact point (foreshortening)"),
    "ux": Variable(_STATIONS, "m", "axial displacement in the floating frame"),
    "uy": Variable(_STATIONS, "m", "transverse displacement in the floating frame"),
    "contact_obstacle": Variable(
        ("contact",), "1", "obstacle of a contact", "the slope is 0, the others count from 1"
    ),
    "contact_place": Variable(_CONTACTS, "m", "place of a contact along the beam"),
    "contact_x": Variable(_CONTACTS, "m", "point of contact on the beam, inertial x"),
    "contact_y": Variable(_CONTACTS, "m", "point of contact on the beam, inertial y"),
    "contact_fx": Variable(_CONTACTS, "N", "force of a contact on the beam, inertial x", _WHOLE),
    "contact_fy": Variable(_CONTACTS, "N", "force of a contact on the beam, inertial y", _WHOLE),
}
#: variables that only a beam has from whose coordinates results along it are computed when they are asked for
OF_FEW_COORDINATES = {
    "qdd": Variable(
        _COORDINATES,
        "m/s^2 or rad/s^2",
        "generalized accelerations",
        "NaN where they are not known; of a beam whose coordinates are no more than its stations",
    ),
}
#: variables of a beam that are computed from its coordinates, or those of a file that has them
RATES_ALONG = {
    "ux_dot": Variable(_STATIONS, "m/s", "rate of ux in the floating frame"),
    "uy_dot": Variable(_STATIONS, "m/s", "rate of uy in the floating frame"),
}
#: variables that only a beam has that nothing holds
OF_A_FREE_BEAM = {
    "origin_x": Variable(_TIME, "m", "origin of the floating frame, inertial x"),
    "origin_y": Variable(_TIME, "m", "origin of the floating frame, inertial y"),
    "origin_vx": Variable(_TIME, "m/s", "velocity of this origin, x"),
    "origin_vy": Variable(_TIME, "m/s", "velocity of this origin, y"),
}
#: variables that only a beam over a slope has
OF_A_SLOPE = {
    "clearance": Variable(_TIME, "m", "smallest distance of the beam from slope and obstacles, negative inside"),
    "clearance_at": Variable(_TIME, "m", "arc length where the beam is closest to slope and obstacles"),
    "clearance_obstacle": Variable(_TIME, "1", "obstacle that the beam is closest to"),
}
#: variables of a beam that `History.section_forces` computes
SECTION_FORCES = {
    "moment": Variable(_STATIONS, "N m", "bending moment"),
    "shear": Variable(_STATIONS, "N", "shear force, slope of the bending moment"),
    "axial_force": Variable(_STATIONS, "N", "axial force, tension positive"),
    "bending_stress": Variable(_STATIONS, "Pa", "bending stress at the outer fibre"),
}
#: of these, what a file does not have that has `OF_FEW_COORDINATES`
COMPUTED = ("ux_dot", "uy_dot", "shear", "bending_stress")
VARIABLES = OF_A_SYSTEM | OF_A_BEAM | OF_FEW_COORDINATES | RATES_ALONG
VARIABLES |= OF_A_FREE_BEAM | OF_A_SLOPE | SECTION_FORCES


def dataset(columns: Mapping[str, Array]) -> xr.Dataset:
    """Return arrays by name as a labelled dataset with units and meanings; the names are those of `VARIABLES`."""
    found: dict[str, xr.Variable] = {}
    for name, values in columns.items():
        variable = VARIABLES[name]
        attributes: dict[str, Any] = {"units": variable.units, "long_name": variable.long_name}
        if variable.comment:
            attributes["comment"] = variable.comment
        if name in ("state", "contact_state"):
            attributes["flag_values"] = np.array([int(s) for s in State], dtype=np.int8)
            attributes["flag_meanings"] = " ".join(s.name.lower() for s in State)
        if variable.dimensions == (name,):
            found[name] = xr.Variable(variable.dimensions, pd.Index(values), attributes)
        else:
            # the fast path leaves out a check for which xarray imports dask where it finds it, half a second
            found[name] = xr.Variable(variable.dimensions, values, attributes, fastpath=True)
    return xr.Dataset(found)

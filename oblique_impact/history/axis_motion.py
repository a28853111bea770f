"""Motion of the points of the beam's axis, and what sensors on them read; seen from the base.

The frame is the inertial one, or moves with the base that is shaken.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from oblique_impact.beam.cross_sections import Sections
from oblique_impact.history.interpolation import series_at
from oblique_impact.scenario.scenario import Scenario

if TYPE_CHECKING:
    from oblique_impact.history.history import History

Array = NDArray[np.float64]
Variables = Mapping[str, Any] | xr.Dataset

#: what sensors read at a place along the beam, and its unit
SENSORS = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2", "strain": "1"}


def axis_places(scenario: Scenario, variables: Variables) -> NDArray[np.complex128]:
    """Return the places x + i y (m) of the stations, (..., stations), from variables of a history at any times."""
    return np.exp(1j * np.asarray(variables["theta"]))[..., None] * _from_root(scenario, variables)


def axis_velocities(scenario: Scenario, variables: Variables) -> NDArray[np.complex128]:
    """Return the velocities (m/s) of the stations, (..., stations), from variables of a history at any times."""
    theta, spin = (np.asarray(variables[name])[..., None] for name in ("theta", "theta_dot"))
    rates = np.asarray(variables["ux_dot"]) + 1j * np.asarray(variables["uy_dot"])
    return np.asarray(np.exp(1j * theta) * (rates + 1j * spin * _from_root(scenario, variables)))


def _from_root(scenario: Scenario, variables: Variables) -> NDArray[np.complex128]:
    """Return the places in the floating frame, (..., stations)."""
    station, ux, uy = (np.asarray(variables[name]) for name in ("station", "ux", "uy"))
    return np.asarray(scenario.root.hub_radius + station + ux + 1j * uy)


def sensor_reading(history: History, sensor: str, place: float, times: Array) -> Array:
    """Return what one of `SENSORS` at a place (m) along the beam reads at times (n,) in s.

    Displacement, from the place at t = 0, and velocity are those across the line of the beam at t = 0, as by a
    laser that stands on the base.  The acceleration is that across the axis, without gravity, and the strain that
    of bending on the outer fibre on the side of negative y, as by sensors on the beam.

    Between stations by a spline of degree 5, between samples by cubics, never across a jump.
    """
    from scipy.interpolate import make_interp_spline

    scenario, data = history.scenario, history.data
    assert scenario is not None
    spline = make_interp_spline(data["station"].values, np.eye(data["station"].size), k=5)
    sampled, (here, slope, curvature) = data["time"].values, (spline(place, order) for order in range(3))
    if sensor == "strain":
        # from the moment, which converges where curvatures of shape functions do not; its part by damping is taken
        # off with their rate
        sections = Sections.from_scenario(scenario)
        strain = history.section_forces()["moment"].values @ here / float(sections.bending_stiffness(place))
        strain -= scenario.beam.kelvin_voigt * data["uy_dot"].values @ curvature
        return series_at(sampled, float(sections.fibre_distance(place)) * strain, times)
    # the axis with one station, which is the place
    variables = {name: (data[name].values @ here)[:, None] for name in ("ux", "uy", "ux_dot", "uy_dot")}
    variables |= {"station": place, "theta": data["theta"].values, "theta_dot": data["theta_dot"].values}
    point, velocity = (motion(scenario, variables)[:, 0] for motion in (axis_places, axis_velocities))
    across = np.exp(-1j * scenario.initial.angle)
    if sensor == "displacement":
        return series_at(sampled, (across * (point - point[0])).imag, times, (across * velocity).imag)
    if sensor == "velocity":
        return series_at(sampled, (across * velocity).imag, times)
    x_rate, y_rate = (series_at(sampled, part, times, order=1) for part in (velocity.real, velocity.imag))
    direction = series_at(sampled, data["theta"].values + data["uy"].values @ slope, times)
    return np.asarray(y_rate * np.cos(direction) - x_rate * np.sin(direction))

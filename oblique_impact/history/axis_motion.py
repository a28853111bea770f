"""Motion of the points of the beam's axis, seen from the base.

The frame is the inertial one, or moves with the base that is shaken.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from oblique_impact.scenario.scenario import Scenario

Variables = Mapping[str, Any] | xr.Dataset


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

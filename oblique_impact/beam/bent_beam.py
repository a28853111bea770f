"""Where the points of the bent beam are in samples of a motion, and how fast: at a place along it, at a height e.

A cross-section at x of a beam whose root is at r from the axis of rotation has the direction d, which points along
the beam, in the floating frame at theta.  A point at the height e of this section, to the left of the axis, is at

    z = o + exp(i theta) (r + x + u + i e d),        u = u_x + i u_y

with points and vectors as complex numbers.  The origin o of the frame moves with a beam that nothing holds; else
it is 0.  To second order in the angle phi of the section against the frame
d = 1 - phi^2/2 + i phi; in the exact beam d = exp(i phi).  The inertial frame moves with a base that is shaken.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from oblique_impact.scenario.scenario import Scenario

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: variables of a history of a beam that nothing holds: place and velocity of the frame's origin
OF_A_FREE_BEAM = "origin_x", "origin_y", "origin_vx", "origin_vy"


def direction_of(slope: Array, second_order: float = 1.0) -> Complex:
    """Return the directions of sections with these slopes phi; `second_order` is 0 where phi^2 is left out."""
    return np.asarray(1.0 - 0.5 * second_order * slope**2 + 1j * slope)


class BentBeam(NamedTuple):
    """The bent beam at places along it in samples; each field broadcasts to (samples, places)."""

    theta: Array  # rad, of the floating frame
    arms: Array  # m, r + x
    u: Complex  # m, displacements of the axis in the frame
    spin: Array | float = 0.0  # rad/s, of the frame
    rate: Complex | float = 0.0  # m/s, rates of the displacements in the frame
    direction: Complex | complex = 1.0  # along the beam, of its sections in the frame
    turning: Complex | complex = 0.0  # 1/s, rates of the directions
    origin: Complex | complex = 0.0  # m, of the frame of a beam that nothing holds
    drift: Complex | complex = 0.0  # m/s, its velocity

    @classmethod
    def of_history(cls, scenario: Scenario, variables: Mapping[str, Any] | xr.Dataset) -> BentBeam:
        """Return the axis at the stations (..., stations), from variables of a history at any times.

        Histories do not hold how the sections have turned.
        """
        theta, spin = (np.asarray(variables[name])[..., None] for name in ("theta", "theta_dot"))
        station, ux, uy, ux_rate, uy_rate = (
            np.asarray(variables[name]) for name in ("station", "ux", "uy", "ux_dot", "uy_dot")
        )
        found = cls(theta, scenario.root.hub_radius + station, ux + 1j * uy, spin, ux_rate + 1j * uy_rate)
        if not scenario.root.is_free:
            return found
        x, y, vx, vy = (np.asarray(variables[name])[..., None] for name in OF_A_FREE_BEAM)
        return found._replace(origin=x + 1j * y, drift=vx + 1j * vy)

    def point(self, height: Array | float = 0.0) -> Complex:
        """Return the points x + i y (m) at heights e (m) above the axis in the inertial frame."""
        return np.asarray(self.origin + np.exp(1j * self.theta) * self._in_frame(height))

    def velocity(self, height: Array | float = 0.0) -> Complex:
        """Return the velocities (m/s) of these points."""
        rate = self.rate + 1j * height * self.turning
        turned = np.exp(1j * self.theta) * (rate + 1j * self.spin * self._in_frame(height))
        return np.asarray(self.drift + turned)

    def _in_frame(self, height: Array | float) -> Complex:
        return np.asarray(self.arms + self.u + 1j * height * self.direction)

    def variables(self, station: int, height: float) -> dict[str, Array]:
        """Return the variables of frame, displacements and contact point of a history.

        The contact point is in the section of a station by number, at a height (m) above the axis; the deflection
        is that of the axis.  Here the angle is (samples, 1), all else (samples, stations).
        """
        point, velocity = self.point(height)[:, station], self.velocity(height)[:, station]
        return {
            "theta": self.theta[:, 0],
            "theta_dot": np.asarray(self.spin)[:, 0],
            "tip_x": point.real,
            "tip_y": point.imag,
            "tip_vx": velocity.real,
            "tip_vy": velocity.imag,
            "deflection": self.u[:, station].imag,
            "shortening": self.u[:, station].real,
            "ux": self.u.real,
            "uy": self.u.imag,
            "ux_dot": np.real(self.rate),
            "uy_dot": np.imag(self.rate),
        }

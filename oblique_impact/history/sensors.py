"""What sensors on the beam's axis, or a laser that looks at it, read."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from oblique_impact.beam.bent_beam import OF_A_FREE_BEAM, BentBeam
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.history.history import History
from oblique_impact.history.interpolation import series_at

Array = NDArray[np.float64]

#: what sensors read at a place along the beam, and its unit
SENSORS = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2", "strain": "1"}


def sensor_reading(history: History, sensor: str, place: float, times: Array) -> Array:
    """Return what one of `SENSORS` at a place (m) along the beam reads at times (n,) in s.

    Displacement, from the place at t = 0, and velocity are those across the line of the beam at t = 0, as by a
    laser that stands on the base.  The acceleration is that across the axis, without gravity, and the strain that
    of bending on the outer fibre on the side of negative y, as by sensors on the beam.

    Between stations by a spline of degree 5, between samples by cubics, never across a jump.
    """
    from scipy.interpolate import make_interp_spline  # a fifth of a second, for which runs do not wait

    scenario, data = history.scenario, history
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
    variables |= {name: data[name].values for name in OF_A_FREE_BEAM if name in data}
    bent = BentBeam.of_history(scenario, variables)
    point, velocity = bent.point()[:, 0], bent.velocity()[:, 0]
    # across the line of the undeformed beam, or of one that has come to rest elsewhere
    moved = scenario.initial.state != "undeformed" and scenario.root.kind != "driven"
    across = np.exp(-1j * (float(data["theta"].values[0]) if moved else scenario.initial.angle))
    if sensor == "displacement":
        return series_at(sampled, (across * (point - point[0])).imag, times, (across * velocity).imag)
    if sensor == "velocity":
        return series_at(sampled, (across * velocity).imag, times)
    x_rate, y_rate = (series_at(sampled, part, times, order=1) for part in (velocity.real, velocity.imag))
    direction = series_at(sampled, data["theta"].values + data["uy"].values @ slope, times)
    return np.asarray(y_rate * np.cos(direction) - x_rate * np.sin(direction))

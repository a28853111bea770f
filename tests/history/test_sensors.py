"""What sensors on a beam read, against closed forms and curvatures of shape functions."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.beam_problem import beam_of
from oblique_impact.history.sensors import sensor_reading


def test_sensors_on_a_rigid_pendulum():
    """A stiff rod swings from 0.5 rad: theta'' = -(3 g/2 L) cos theta, and the moment of a falling chimney.

    M(x) = (m g/4 L^2) cos theta x (L - x)^2: the part outside of x weighs more than its inertia holds it.
    """
    rod = Scenario.builtin(
        "paper",
        [
            "contact.enabled=false",
            "beam.youngs_modulus=1e14",
            "initial.angle=0.5",
            "end_time=0.3",
            "discretization.modes=1",
            "beam.outer_fibre=0.01",
            "beam.kelvin_voigt=1e-4",
        ],
    )
    history, times, x = simulate(rod), np.array([0.05, 0.12345, 0.3]), 0.3
    theta, spin = history["theta"].interp(time=times).values, history["theta_dot"].interp(time=times).values
    read = {
        kind: sensor_reading(history, kind, x, times)
        for kind in ("displacement", "velocity", "acceleration", "strain")
    }
    beam = rod.beam
    assert read["displacement"] == pytest.approx(x * np.sin(theta - 0.5), abs=1e-6)
    assert read["velocity"] == pytest.approx(x * spin * np.cos(theta - 0.5), abs=1e-5)
    assert read["acceleration"] == pytest.approx(-1.5 * rod.gravity / beam.length * np.cos(theta) * x, rel=1e-4)
    weight = beam.density * beam.area * beam.length * rod.gravity
    moment = weight / (4.0 * beam.length**2) * np.cos(theta) * x * (beam.length - x) ** 2
    strain = 0.01 * moment / (beam.youngs_modulus * beam.second_moment)
    assert np.abs(read["strain"]) == pytest.approx(np.abs(strain), rel=1e-3)


@pytest.mark.parametrize(
    "damping",
    [{"beam__kelvin_voigt": 4e-3}, {"beam__modal_damping_ratio": 0.15}, {"beam__mass_proportional": 40.0}],
)
def test_strain_is_that_of_the_bent_beam_and_not_of_its_damping(damping):
    """Against curvatures of many shape functions, of a strip whose damping takes a third of the moment."""
    strip = Scenario.builtin("shaken").adapted(
        base__acceleration=0.0,
        initial__angle=0.0,
        contact__enabled=False,
        end_time=0.1,
        solver__output_interval=1e-3,
        discretization__modes=12,
        **damping,
    )
    history = simulate(strip)
    o, where = beam_of(strip).operators, 8
    curvature = history["q"].values[:, 1:] @ o.stations.curvatures[where]
    read = sensor_reading(history, "strain", float(o.stations.points[where]), history["time"].values[10:])
    assert read == pytest.approx(5e-4 * curvature[10:], rel=2e-2, abs=1e-7)
    at_rest = 5e-4 * 7850.0 * 2e-5 * 9.8 * (0.25 - 0.0625) ** 2 / 2.0 / (2.1e11 * strip.beam.second_moment)
    assert abs(read[-1]) == pytest.approx(at_rest, rel=0.2)

"""Beams of varying section, with a tip mass, on graded meshes, against what stands outside the program."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from oblique_impact import Scenario
from oblique_impact.beam.operators import build_operators
from oblique_impact.fem_beam import NodalBeam
from oblique_impact.validation.beams import UNIT
from oblique_impact.validation.reference_values import VALUES

AREA = [[0.0, 1.0], [0.3, 0.5], [1.0, 0.8]]
SECOND_MOMENT = [[0.0, 1.0], [0.6, 0.4], [1.0, 0.3]]


def beam(elements: int, beam_data: dict[str, Any], frame: str = "tangent", **discretization: Any) -> Scenario:
    """A beam of unit data but for `beam_data`, without contact."""
    shapes = {"method": "fem", "frame": frame, "modes": 3, "elements": elements, **discretization}
    return Scenario.from_dict(
        {"beam": {**UNIT, **beam_data}, "contact": {"enabled": False}, "discretization": shapes}
    )


def frequencies(*args: Any, **kwargs: Any) -> np.ndarray:
    return build_operators(beam(*args, **kwargs)).natural_frequencies()


# Frequencies ----------------------------------------------------------------------------------------------------


def shooting(guess: float, beam_data: dict[str, Any], frame: str) -> float:
    """Frequency near `guess`: (EI w'')'' = m omega^2 w integrated from the tip, which carries the tip mass."""
    area, second_moment = np.transpose(beam_data["area"]), np.transpose(beam_data["second_moment"])
    places = np.union1d(area[0], second_moment[0])
    tip_mass = beam_data.get("tip_mass", 0.0)

    def remainder(omega: float) -> float:
        def slope(x: float, y: np.ndarray) -> list[float]:  # y = w, w', M = EI w'', M'
            stiffness, mass = np.interp(x, *second_moment), np.interp(x, *area)
            return [y[1], y[2] / stiffness, y[3], mass * omega**2 * y[0]]

        ends = []
        for start in ([1.0, 0.0, 0.0, -tip_mass * omega**2], [0.0, 1.0, 0.0, 0.0]):
            y = np.array(start)
            for a, b in zip(places[-2::-1], places[:0:-1], strict=True):
                y = solve_ivp(slope, (b, a), y, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
            ends.append(y[[0, 1]] if frame == "tangent" else y[[0, 2]])
        return float(np.linalg.det(ends))

    return float(brentq(remainder, 0.98 * guess, 1.01 * guess, xtol=1e-12))


@pytest.mark.parametrize("frame", ["tangent", "mean-axis"])
@pytest.mark.parametrize("grading", [1.0, 8.0])
def test_frequencies_of_tables_with_a_tip_mass_converge_at_order_four(frame, grading):
    """Kinks of either table at nodes; clamped-free and hinged-free."""
    data = {"area": AREA, "second_moment": SECOND_MOMENT, "tip_mass": 0.2}
    found = [frequencies(n, data, frame, grading=grading) for n in (10, 20, 40)]
    exact = np.array([shooting(guess, data, frame) for guess in found[0]])
    errors = np.array(found) / exact - 1.0
    order = np.log2(errors[:-1] / errors[1:])
    if grading == 1.0:
        assert np.all((order > 3.9) & (order < 4.1)), order
    # dispersion of a uniform mesh, (beta h)^4/1440 with beta^4 = omega^2 m/EI at its largest, m/EI < 3
    largest = np.max(np.diff(NodalBeam.from_scenario(beam(40, data, frame, grading=grading)).nodes))
    assert np.all(errors[2] > -1e-10)
    assert np.all(errors[2] < 3.0 * exact**2 * largest**4 * VALUES["1.3"])


# Motions --------------------------------------------------------------------------------------------------------

"""Beams of varying section, with a tip mass, on graded meshes, against what stands outside the program."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq
from scipy.special import iv, jv, kv, yv

from oblique_impact import Scenario, simulate
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


@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
def test_tip_mass_frequencies(ratio):
    """1 + cos b cosh b + mu b (cos b sinh b - sin b cosh b) = 0 (Laura, Pombo, Susemihl 1974)."""

    def equation(b: float) -> float:
        return 1.0 / np.cosh(b) + np.cos(b) + ratio * b * (np.cos(b) * np.tanh(b) - np.sin(b))

    places = np.linspace(1e-3, 10.0, 2001)
    signs = np.flatnonzero(np.diff(np.sign([equation(b) for b in places])))[:3]
    roots = np.array([brentq(equation, places[k], places[k + 1], xtol=1e-14) for k in signs])
    errors = [frequencies(n, {"tip_mass": ratio}) / roots**2 - 1.0 for n in (16, 32)]
    # the consistent mass alone gives (beta h)^4/1440 times the share of the beam in the kinetic energy, at most 1
    assert np.all((errors[1] > 0.0) & (errors[1] < (roots / 32) ** 4 * VALUES["1.3"]))
    order = np.log2(errors[0][1:] / errors[1][1:])
    assert np.all((order > 3.95) & (order < 4.05))


def truncated_wedge(thickness: float) -> float:
    """Lowest frequency of a clamped wedge of unit width whose thickness falls from 1 to `thickness`.

    (s^3 w'')'' = k^2 s w over the distance s from the edge has the solutions w = C1(z)/z with z = 2 sqrt(k s)
    and C one of J, Y, I, K (Kirchhoff 1879; Mabie and Rogers 1964).  By (1/z d/dz) (C1/z) = -+C2/z^2 and so
    on, the slope goes with C2/z^2, the moment with z^3 C3 and the shear with z^3 C2/z = z^2 C2.
    """
    edge = 1.0 / (1.0 - thickness)  # distance of the clamped end from the edge for a unit length
    tip = edge * thickness

    def rows(k: float) -> np.ndarray:
        # with z = 2 sqrt(k s): d/ds = (2k/z) d/dz, and (1/z d/dz)^n (C1/z) = sign^n C_{1+n}/z^{1+n}
        def column(function: Any, sign: float) -> list[float]:
            z_root, z_tip = 2.0 * np.sqrt(k * edge), 2.0 * np.sqrt(k * tip)
            # s^3 w'' goes with z^6 C3/z^3 and (1/z d/dz) (z^3 C3) = z^2 C2, with a minus for K
            falling = -1.0 if function is kv else 1.0
            return [
                function(1, z_root) / z_root,
                sign * function(2, z_root) / z_root**2,
                function(3, z_tip) * z_tip**3,
                falling * function(2, z_tip) * z_tip**2,
            ]

        return np.transpose([column(jv, -1.0), column(yv, -1.0), column(iv, 1.0), column(kv, -1.0)])

    def equation(k: float) -> float:
        matrix = rows(k)
        return float(np.linalg.det(matrix / np.abs(matrix).max(axis=1, keepdims=True)))

    places = np.linspace(0.5, 12.0, 400)
    values = [equation(k) for k in places]
    first = int(np.flatnonzero(np.diff(np.sign(values)))[0])
    # E I = E I_0 (s/edge)^3 and m = m_0 s/edge make k = omega edge
    return float(brentq(equation, places[first], places[first + 1], xtol=1e-14)) / edge


def test_the_frequency_equation_of_the_wedge_gives_kirchhoffs_value():
    """Full wedge: 5.315 (Kirchhoff 1879; Timoshenko, Vibration Problems in Engineering, 3rd ed. 1955, Sec. 59)."""
    assert truncated_wedge(1e-4) == pytest.approx(5.315, abs=2e-3)


def wedge(rows: int, thickness: float) -> dict[str, Any]:
    x = np.arange(rows + 1) / rows
    depth = 1.0 - (1.0 - thickness) * x
    return {
        "area": [[0.0, 1.0], [1.0, thickness]],
        "second_moment": np.stack([x, depth**3], axis=1).tolist(),
    }


@pytest.mark.parametrize("thickness", [0.5, 0.2])
def test_wedges_of_cubic_stiffness_approach_the_bessel_solution(thickness):
    """A smooth law as a table: the error of linear pieces falls with their square, whatever the mesh."""
    exact = truncated_wedge(thickness)
    rows = np.array([25, 50, 100])
    # 40 elements: more than the first table has pieces, fewer than the others, so kinks lie inside elements
    errors = [frequencies(40, wedge(int(n), thickness))[0] / exact - 1.0 for n in rows]
    assert errors[0] > 0.0  # chords of a convex law are stiffer
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all((order > 1.95) & (order < 2.05)), order
    extrapolated = errors[2] - (errors[1] - errors[2]) / 3.0
    assert abs(extrapolated) < 1e-7


# Motions --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("frame", ["tangent", "mean-axis"])
def test_a_stiff_beam_swings_like_the_compound_pendulum(frame):
    """J theta'' = -g Sm cos(theta) with J and Sm by adaptive quadrature; flexibility disturbs it like 1/E."""
    area, tip_mass, density = [[0.0, 4e-4], [0.4, 6e-4], [1.0, 2e-4]], 0.25, 2766.7

    def mass(x: float) -> float:
        return density * float(np.interp(x, *np.transpose(area)))

    J = quad(lambda x: mass(x) * x**2, 0.0, 1.0, points=[0.4], epsabs=1e-14)[0] + tip_mass
    Sm = quad(lambda x: mass(x) * x, 0.0, 1.0, points=[0.4], epsabs=1e-14)[0] + tip_mass
    rigid = solve_ivp(
        lambda t, y: [y[1], -9.8 * Sm / J * np.cos(y[0])], (0.0, 0.5), [np.pi / 4, 0.0], rtol=1e-12, atol=1e-12
    )
    errors = []
    for modulus in (1e12, 1e13):
        data = {"area": area, "second_moment": 1e-7, "youngs_modulus": modulus, "density": density}
        scenario = beam(6, {**data, "tip_mass": tip_mass, "modal_damping_ratio": 0.5}, frame, modes=1)
        scenario = scenario.replace(end_time=0.5, discretization__kinetics="full")
        o = build_operators(scenario)
        assert pytest.approx(J, rel=1e-12) == o.J
        assert pytest.approx(Sm, rel=1e-12) == o.Sm
        tip = simulate(scenario)
        angle = np.arctan2(tip["tip_y"].values[-1], tip["tip_x"].values[-1])
        errors.append(abs(angle - rigid.y[0, -1]))
    # deflection m g L^3/EI of a static load, 1e-4 and 1e-5 rad
    assert errors[0] < 1e-4
    assert errors[1] == pytest.approx(0.1 * errors[0], rel=0.1)


FALL = {
    "beam": {
        "area": [[0.0, 4e-4], [0.45, 2.5e-4], [1.0, 3e-4]],
        "second_moment": [[0.0, 9e-9], [0.6, 6e-9], [1.0, 5e-9]],
        "tip_mass": 0.1,
    },
    "end_time": 0.6,
}


@pytest.mark.parametrize("kinetics", ["first-order", "full"])
@pytest.mark.parametrize("frame", ["tangent", "mean-axis"])
def test_ledger_of_a_fall_onto_the_slope_closes(kinetics, frame):
    shapes = {"method": "fem", "frame": frame, "kinetics": kinetics, "modes": 3, "elements": 12, "grading": 5.0}
    history = simulate(Scenario.from_dict({**FALL, "discretization": shapes}))
    energy = history.summary["energy"]
    assert history.outcome.label == "completed"
    assert len(history.summary["macro_collisions"]) > 0
    assert energy["lost_impact"] > 0.01
    assert abs(energy["unaccounted"]) <= 1e-8


@pytest.mark.parametrize("kinetics", ["zeroth-order", "first-order", "full"])
def test_free_fall_conserves_energy(kinetics):
    shapes = {"method": "fem", "frame": "mean-axis", "kinetics": kinetics, "modes": 4, "elements": 12}
    history = simulate(Scenario.from_dict({**FALL, "contact": {"enabled": False}, "discretization": shapes}))
    total = sum(history[f"energy_{part}"].values for part in ("kinetic", "elastic", "gravity"))
    assert np.ptp(history["energy_kinetic"].values) > 1.0
    np.testing.assert_allclose(total, total[0], atol=1e-8)

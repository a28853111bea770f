"""Bending moment, shear and axial force along the beam, at rest, falling, spinning and in contact."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from oblique_impact import Scenario, simulate
from oblique_impact.beam.beam import Beam
from oblique_impact.beam.operators import build_operators
from oblique_impact.beam.section_forces import Fields, Motion, PointLoads, fields_along

HELD = {"kind": "driven", "profile": "hold"}
MASS, BENDING, GRAVITY = 0.86874, 541.27, 9.8  # kg/m, N m^2, m/s^2: the beam of items 4b and 7a


def cantilever(angle: float, shapes: dict[str, Any], stiffening: float = 1.0, **beam: Any) -> Beam:
    """The beam of item 7a, clamped at an angle to the horizon."""
    data = {"area": 1.0, "density": MASS, "youngs_modulus": stiffening * BENDING, "second_moment": 1.0, **beam}
    scenario = Scenario.from_dict(
        {
            "gravity": GRAVITY,
            "beam": data,
            "root": HELD,
            "initial": {"angle": angle},
            "contact": {"enabled": False},
            "discretization": shapes,
        }
    )
    return Beam(scenario, build_operators(scenario))


def at_rest(beam: Beam, angle: float) -> tuple[np.ndarray, Fields]:
    """Elastic coordinates of the static beam, (K - g sin D) B = -g cos P, and its section forces."""
    o = beam.operators
    B = np.linalg.solve(o.K - GRAVITY * np.sin(angle) * o.D, -GRAVITY * np.cos(angle) * o.P)
    q = np.append(angle, B)[None]
    rest, zero = np.zeros_like(q), np.zeros(1)
    return q, fields_along(beam, Motion(zero, q, rest, rest))


def curvature_moment(beam: Beam, q: np.ndarray) -> np.ndarray:
    """E I u_y'' (N m) of the shapes at the stations: in smooth motion it is that of equilibrium."""
    stations = beam.operators.stations
    return beam.operators.sections.bending_stiffness(stations.points) * (q[:, 1:] @ stations.curvatures.T)


def differences(sizes: list[dict[str, Any]], angle: float, **beam: Any) -> np.ndarray:
    """Largest distance between the two moments, over the largest moment."""
    found = []
    for shapes in sizes:
        model = cantilever(angle, shapes, **beam)
        q, fields = at_rest(model, angle)
        gap = np.abs(curvature_moment(model, q) - fields.moment)[:, :-1]
        found.append(gap.max() / np.abs(fields.moment).max())
    return np.array(found)


def test_curvature_approaches_the_moment_of_equilibrium():
    """Statics at 30 degrees, stiff: elements at order 2, and modes, like the tail of a sum of 1/k^3, too."""
    elements = differences(
        [{"method": "fem", "modes": 2 * n, "elements": n} for n in (8, 16, 32)], np.pi / 6, stiffening=1e4
    )
    order = np.log2(elements[:-1] / elements[1:])
    assert np.all((order > 1.9) & (order < 2.1)), order
    assert elements[-1] < 2e-4  # q h^2/12 over q/2
    modes = differences([{"method": "modal", "modes": n} for n in (5, 10, 20)], np.pi / 6, stiffening=1e4)
    order = np.log2(modes[:-1] / modes[1:])
    assert np.all(order > 1.8), (order, modes)
    assert modes[-1] < 1e-3


AREA = [[0.0, 4e-4], [0.45, 2.5e-4], [1.0, 3e-4]]


@pytest.mark.parametrize(("area", "tip_mass"), [(3.14e-4, 0.0), (AREA, 0.2)])
def test_tension_of_a_spinning_beam(area, tip_mass):
    """N = Omega^2 (int_x^L m (r + xi) dxi + M_t (r + L)); if uniform m Omega^2 (L^2 - x^2)/2 with r = 0."""
    spin, radius, density = 20.0, 0.1, 2766.7
    scenario = Scenario.from_dict(
        {
            "gravity": 0.0,
            "end_time": 0.01,
            "beam": {"area": area, "tip_mass": tip_mass},
            "root": {"kind": "driven", "profile": "constant-speed", "spin_rate": spin, "hub_radius": radius},
            "contact": {"enabled": False},
            "discretization": {"method": "fem", "elements": 8},
        }
    )
    history = simulate(scenario)
    x = history["station"].values
    table = np.array(area if isinstance(area, list) else [[0.0, area], [1.0, area]])

    def outside(start: float) -> float:
        mass = lambda s: density * np.interp(s, table[:, 0], table[:, 1]) * (radius + s)  # noqa: E731
        kinks = [k for k in table[1:-1, 0] if k > start]
        return quad(mass, start, 1.0, points=kinks or None, epsabs=1e-13)[0] + tip_mass * (radius + 1.0)

    expected = spin**2 * np.array([outside(s) for s in x])
    np.testing.assert_allclose(history["axial_force"].values, np.tile(expected, (101, 1)), rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(history["moment"].values, 0.0, atol=1e-10)
    if not tip_mass:
        closed = 0.5 * density * area * spin**2 * ((radius + 1.0) ** 2 - (radius + x) ** 2)
        np.testing.assert_allclose(expected, closed, rtol=1e-10, atol=1e-12)


def test_first_order_kinetics_leave_a_small_moment_at_the_pin(run):
    """Third powers of the deflection, which they drop: here 1e-3 of the largest moment, mean-axis frame."""
    moment = run("paper", "discretization.frame=mean-axis", "discretization.modes=3")["moment"].values
    assert np.abs(moment[:, 0]).max() < 2e-3 * np.abs(moment).max()
    # the force at the tip acts at its inertial position, which is turned back into the frame: rounding is left
    assert np.abs(moment[:, -1]).max() < 1e-14 * np.abs(moment).max()


def test_a_beam_on_three_supports():
    """Uniform beam of two equal spans l, pinned at its root: reactions 3/8, 10/8 and 3/8 of w l (Timoshenko).

    Its moment is -w l^2/8 over the middle support and 9 w l^2/128 at 3/8 of a span.  A third contact is open.
    """
    scenario = Scenario.from_dict(
        {
            "gravity": GRAVITY,
            "beam": {"area": 1.0, "density": MASS, "youngs_modulus": BENDING, "second_moment": 1.0},
            "initial": {"angle": 0.3},
            "contact": {"enabled": False},
            "discretization": {"method": "fem", "elements": 8, "modes": 4},
        }
    )
    beam = Beam(scenario, build_operators(scenario))
    x, span, nan = beam.operators.stations.points, 0.5, np.nan
    load = MASS * GRAVITY * np.cos(0.3)  # per length, across the beam; its part along it pulls at the pin
    place, force = np.array([[span, 2.0 * span, nan]]), load * span * np.array([[1.25, 0.375, 0.0]])
    c, s = np.cos(0.3), np.sin(0.3)
    q, rest = np.array([[0.3, 0.0, 0.0, 0.0, 0.0]]), np.zeros((1, 5))
    fields = fields_along(
        beam, Motion(np.zeros(1), q, rest, rest, PointLoads(place, c * place, s * place, -s * force, c * force))
    )
    along = np.minimum(x, 2.0 * span - x)  # from the nearer end
    moment = load * (0.375 * span * along - 0.5 * along**2)
    np.testing.assert_allclose(fields.moment[0], moment, atol=1e-12)
    middle, largest = int(np.argmin(np.abs(x - span))), int(np.argmin(np.abs(x - 0.375 * span)))
    assert fields.moment[0, middle] == pytest.approx(-load * span**2 / 8.0, rel=1e-12)
    assert fields.moment[0, largest] == pytest.approx(9.0 * load * span**2 / 128.0, rel=1e-12)
    inboard = x <= span  # just inboard of the middle support the shear is -5/8 w l
    shear = load * np.where(inboard, 0.375 * span - x, 1.625 * span - x)
    np.testing.assert_allclose(fields.shear[0], shear, atol=1e-12)
    np.testing.assert_allclose(fields.axial_force[0], -MASS * GRAVITY * s * (2.0 * span - x), atol=1e-12)


def test_section_forces_are_unknown_where_accelerations_are_and_do_not_depend_on_the_block():
    model, rng = cantilever(0.0, {"method": "fem", "elements": 4, "modes": 3}), np.random.default_rng(5)
    loads = PointLoads(*rng.normal(size=(5, 7, 2)))
    motion = Motion(np.zeros(7), *(rng.normal(size=(7, 4)) for _ in range(3)), loads)
    motion.qdd[4] = np.nan
    whole = fields_along(model, motion, 100)._asdict()
    for name, found in fields_along(model, motion, 3)._asdict().items():
        np.testing.assert_allclose(found, whole[name], rtol=1e-9, atol=1e-9 * np.nanmax(np.abs(whole[name])))
        known = ~np.isnan(found).any(axis=1)
        assert known.tolist() == [k != 4 or name in ("ux", "uy", "ux_dot", "uy_dot") for k in range(7)]

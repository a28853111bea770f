"""Operators of the assumed-modes beam: integrals over eigenfunctions by composite Gauss quadrature."""

from __future__ import annotations

import numpy as np

from modal.eigenfunctions import Array, Eigenfunctions, Family
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.operators import BeamOperators, ShapeTable, SpinningBeam, StationTable, station_points
from oblique_impact.scenario.scenario import Scenario

_SPECTRUM_MODES = 48
_ROUNDING = 1e-17


def build_operators(scenario: Scenario) -> BeamOperators:
    """Discretize the uniform beam of `scenario` with `discretization.modes` eigenfunctions.

    Tangent frame: clamped-free functions; mean-axis frame: hinged-free functions without the rigid
    one.  Every integral is exact to rounding.
    """
    family: Family = "clamped-free" if scenario.discretization.frame == "tangent" else "hinged-free"
    shapes = Eigenfunctions(family, scenario.discretization.modes, scenario.beam.length)
    return _integrate(scenario, shapes)


def quadrature_order(phase: float) -> int:
    """Gauss points per panel that integrate products oscillating by `phase` (rad) to rounding.

    The error of p points on exp(i z x) over -1 to 1 is 2^(2p+1) p!^4 z^(2p) / ((2p+1) (2p)!^3) (Abramowitz, Stegun
    1964, 25.4.30); two points are added for the integrals that end inside a panel.
    """
    order, error = 0, 2.0
    while error > _ROUNDING:
        order += 1
        error *= order * (0.5 * phase) ** 2 / (2.0 * (2 * order + 1) * (2 * order - 1) ** 2)
    return order + 2


def gauss_rule(edges: Array, order: int) -> tuple[Array, Array]:
    """Points and weights of the composite Gauss rule on panels with the given edges."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    half = 0.5 * np.diff(edges)
    middle = 0.5 * (edges[1:] + edges[:-1])
    return (middle[:, None] + half[:, None] * nodes).ravel(), (half[:, None] * weights).ravel()


def _integrate(scenario: Scenario, shapes: Eigenfunctions) -> BeamOperators:
    length, sections = scenario.beam.length, Sections.from_scenario(scenario)
    point = scenario.contact.point
    stations = station_points(length, point)
    wave_number = 2.0 * shapes.roots[-1] / length
    order = quadrature_order(float(wave_number * np.max(np.diff(stations))))
    x, w = gauss_rule(stations, order)
    values, slopes, curvatures = (shapes.derivative(x, k) for k in range(3))
    m, stiffness = sections.mass_per_length(x), sections.bending_stiffness(x)  # uniform, as the scenario checks
    radius = scenario.root.hub_radius

    def gram(weight: Array, rows: Array) -> Array:
        return np.asarray((rows * weight[:, None]).T @ rows)

    return BeamOperators(
        sections=sections,
        M1=gram(m * w, values),
        K=gram(stiffness * w, curvatures),
        C=gram(w * sections.outer_moment(x), slopes),
        D=gram(w * sections.outer_mass(x), slopes),
        S=(m * w * (radius + x)) @ values,
        P=(m * w) @ values,
        J=sections.inertia,
        Sm=sections.static_moment,
        contact_point=point,
        contact_shape=shapes.derivative(np.array([point]), 0)[0],
        contact_shortening=gram(np.where(x < point, w, 0.0), slopes),
        root_slope=shapes.derivative(np.array([0.0]), 1)[0],
        stations=StationTable(
            points=stations,
            values=shapes.derivative(stations, 0),
            slopes=shapes.derivative(stations, 1),
            curvatures=shapes.derivative(stations, 2),
            quadrature=ShapeTable(order, x, w, values, slopes),
            cells=np.searchsorted(x, stations),
        ),
    )


def spectrum(scenario: Scenario) -> SpinningBeam:
    """Operators for the frequencies of the spinning beam, in a basis rich enough to be exact.

    Hinged (`pin`): hinged-free functions, to which the rigid rotation is orthogonal; else clamped-free.
    """
    hinged = scenario.root.kind == "pin"
    family: Family = "hinged-free" if hinged else "clamped-free"
    count = max(_SPECTRUM_MODES, scenario.discretization.modes + 16)
    o = _integrate(scenario, Eigenfunctions(family, count, scenario.beam.length))
    return SpinningBeam(o.K, o.M1, o.C, hinged=hinged)

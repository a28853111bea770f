"""Operators of the assumed-modes beam: integrals over eigenfunctions by composite Gauss quadrature."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace

import numpy as np

from oblique_impact.beam.axis import ShapeFunctions
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.operators import (
    BeamOperators,
    ShapeTable,
    SpinningBeam,
    StationTable,
    gauss_rule,
    merge_points,
    station_points,
)
from oblique_impact.modal.eigenfunctions import Array, Eigenfunctions
from oblique_impact.scenario.scenario import Scenario

_SPECTRUM_MODES = 48
_ROUNDING = 1e-17


def build_operators(scenario: Scenario) -> BeamOperators:
    """Discretize the uniform beam of `scenario` with `discretization.modes` eigenfunctions.

    Tangent frame: clamped-free functions, or those of the beam on the spring of its clamp; mean-axis frame: those
    of the beam on its pin or with its hub, without the rigid one.  Every integral is exact to rounding.  They are
    functions of the beam without its point masses; in the mean-axis frame each takes so much of the rigid rotation
    that it has no angular momentum with them.
    """
    sections, count = Sections.from_scenario(scenario), scenario.discretization.modes
    if scenario.discretization.frame == "tangent":
        shapes = _clamped(sections, count)
    elif sections.hub_inertia == 0.0:
        shapes = Eigenfunctions("hinged-free", count, sections.length)
    else:
        shapes = _with_hub(sections, count)
    found = _integrate(scenario, shapes)
    if scenario.discretization.frame == "tangent" or not sections.masses:
        return found
    return _integrate(scenario, _turned(shapes, found.coupling / found.inertia))


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


def _integrate(scenario: Scenario, shapes: Eigenfunctions) -> BeamOperators:
    length, sections = scenario.beam.length, Sections.from_scenario(scenario)
    point = scenario.contact.point
    stations = station_points(length, point)
    wave_number = 2.0 * shapes.roots[-1] / length
    order = quadrature_order(float(wave_number * np.max(np.diff(stations))))
    x, w = gauss_rule(merge_points(stations, np.union1d(sections.kinks, scenario.inner_forces)), order)
    values, slopes, curvatures = (shapes.derivative(x, k) for k in range(3))
    m, stiffness = sections.mass_per_length(x), sections.bending_stiffness(x)  # uniform, as the scenario checks
    radius = scenario.root.hub_radius
    masses, at_masses = sections.point_masses, shapes.derivative(sections.places, 0)

    def gram(weight: Array, rows: Array) -> Array:
        return np.asarray((rows * weight[:, None]).T @ rows)

    return BeamOperators(
        sections=sections,
        M1=gram(m * w, values) + gram(masses, at_masses),
        K=gram(stiffness * w, curvatures),
        C=gram(w * sections.outer_moment(x), slopes),
        D=gram(w * sections.outer_mass(x), slopes),
        S=(m * w * (radius + x)) @ values + (masses * (radius + sections.places)) @ at_masses,
        P=(m * w) @ values + masses @ at_masses,
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
        along=ShapeFunctions.smooth(shapes.derivative, length, float(shapes.roots[-1]) / length),
    )


def spectrum(scenario: Scenario) -> SpinningBeam:
    """Operators for the frequencies of the spinning beam, in a basis rich enough to be exact."""
    sections, count = Sections.from_scenario(scenario), max(_SPECTRUM_MODES, scenario.discretization.modes + 16)
    if scenario.root.kind == "driven":
        return SpinningBeam.of(_integrate(scenario, _clamped(sections, count)), scenario)
    with_hub, stiffness = _with_hub(sections, count), scenario.root.stiffness
    if stiffness > 0.0:
        # its own eigenfunctions: seen from the root the first one on a soft spring is lost in rounding
        o = _integrate(scenario, replace(with_hub, spring=_over_bending(sections, stiffness)))
        return SpinningBeam.at_rest(o.K + stiffness * np.outer(o.root_slope, o.root_slope), o.elastic_mass)
    seen_from_root = _turned(with_hub, with_hub.derivative(np.zeros(1), 1)[0])
    return SpinningBeam.of(_integrate(scenario, seen_from_root), scenario)


def _over_bending(sections: Sections, stiffness: float) -> float:
    """Return the stiffness of a spring at the root over E I/L."""
    return stiffness * sections.length / float(sections.bending_stiffness(0.0))


def _clamped(sections: Sections, count: int) -> Eigenfunctions:
    """First eigenfunctions of the uniform beam on its clamp, rigid or with a spring."""
    if sections.clamp_stiffness == 0.0:
        return Eigenfunctions("clamped-free", count, sections.length)
    return Eigenfunctions(
        "hub-free", count, sections.length, spring=_over_bending(sections, sections.clamp_stiffness)
    )


def _with_hub(sections: Sections, count: int) -> Eigenfunctions:
    """First elastic eigenfunctions of the uniform beam with its hub."""
    length = sections.length
    hub = sections.hub_inertia / (sections.own_mass * length**2)
    return Eigenfunctions("hub-free", count, length, hub, sections.hub_radius / length)


@dataclass(frozen=True)
class _Turned(Eigenfunctions):
    """Eigenfunctions less a rigid rotation of each about the axis."""

    turns: Array = field(default_factory=lambda: np.zeros(0))  # (count,) 1/m

    def derivative(self, x: Array, order: int) -> Array:
        """Return derivatives at points x (m); shape (points, count), 1/m^order."""
        rigid = (self.length * self.radius + x, np.ones_like(x), np.zeros_like(x))[order]
        return super().derivative(x, order) - rigid[:, None] * self.turns


def _turned(shapes: Eigenfunctions, turns: Array) -> _Turned:
    """Return eigenfunctions less these rotations (count,)."""
    return _Turned(**asdict(shapes), turns=turns)

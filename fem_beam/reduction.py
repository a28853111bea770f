"""From the nodal model to BeamOperators: projection onto the mesh's own eigenmodes."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import cholesky, solve_triangular, svd
from scipy.sparse import csr_array

from fem_beam.nodal import Array, NodalBeam, merge_points
from oblique_impact.beam.operators import BeamOperators, ShapeTable, SpinningBeam, StationTable, station_points
from oblique_impact.scenario.scenario import Scenario

_GAUSS_ORDER = 6  # a linear mass times squares of foreshortening rates is a polynomial of degree 11


def build_operators(scenario: Scenario) -> BeamOperators:
    """Discretize the beam of `scenario` by Hermite elements, reduced to its first modes.

    With `discretization.modes = 0` all modes of the mesh are kept, which is the nodal model in other
    coordinates.
    """
    nodal = NodalBeam.from_scenario(scenario)
    d = scenario.discretization
    root = "clamped" if d.frame == "tangent" else "hinged"
    modes = eigenmodes(nodal, root, d.modes or None)
    return project(nodal, modes)


def eigenmodes(nodal: NodalBeam, root: str, count: int | None) -> Array:
    """Elastic eigenvectors, shape (2 nodes, count), in ascending order of frequency; all if count is None.

    They come from the singular vectors of G L^-T with K = G^T G and M1 = L L^T.  Their modal mass is the
    mass of the beam, so those of a uniform one have int phi^2 dx = length like the eigenfunctions of
    ``modal``; the tip is positive.
    """
    free = nodal.free_dofs(root)
    factor = cholesky(nodal.M1.toarray()[np.ix_(free, free)], lower=True)
    curvature = nodal.curvature_factor().toarray()[:, free]
    scaled = solve_triangular(factor, curvature.T, lower=True)
    left, _, _ = svd(scaled, full_matrices=True, lapack_driver="gesvd")
    shapes = solve_triangular(factor, left, lower=True, trans="T")[:, ::-1]
    if root == "hinged":
        shapes = shapes[:, 1:]  # the rigid rotation has frequency 0
    shapes = shapes[:, :count] * np.sqrt(nodal.sections.mass)
    shapes *= np.where(shapes[-2] < 0.0, -1.0, 1.0)
    modes = np.zeros((nodal.basis.N, shapes.shape[1]))
    modes[free] = shapes
    return modes


def project(nodal: NodalBeam, modes: Array | csr_array) -> BeamOperators:
    """Project the nodal operators onto `modes`, shape (2 nodes, n); sparse modes give sparse operators."""
    scenario, V, sections = nodal.scenario, modes, nodal.sections
    curvature = nodal.curvature_factor() @ V
    at_contact = nodal.evaluate(np.array([scenario.contact.point]))[0]
    root = np.eye(1, nodal.basis.N, 1)

    def both(matrix: csr_array) -> Any:
        return V.T @ (matrix @ V)

    return BeamOperators(
        sections=sections,
        M1=both(nodal.M1),
        K=curvature.T @ curvature,
        C=both(nodal.C),
        D=both(nodal.D),
        S=nodal.S @ V,
        P=nodal.P @ V,
        J=sections.inertia,
        Sm=sections.static_moment,
        contact_point=scenario.contact.point,
        contact_shape=(at_contact.toarray() @ V)[0],
        contact_shortening=both(nodal.contact_shortening),
        root_slope=(root @ V)[0],
        stations=_station_table(nodal, V),
        method="fem",
    )


def _station_table(nodal: NodalBeam, V: Array | csr_array) -> StationTable:
    stations = station_points(nodal.sections.length, nodal.scenario.contact.point)
    edges = merge_points(nodal.edges, stations)
    nodes, weights = np.polynomial.legendre.leggauss(_GAUSS_ORDER)
    half, middle = 0.5 * np.diff(edges), 0.5 * (edges[1:] + edges[:-1])
    x = (middle[:, None] + half[:, None] * nodes).ravel()
    w = (half[:, None] * weights).ravel()
    values, slopes, _ = nodal.evaluate(x)
    at_stations, station_slopes, curvatures = nodal.evaluate(stations)
    return StationTable(
        points=stations,
        values=at_stations @ V,
        slopes=station_slopes @ V,
        curvatures=curvatures @ V,
        quadrature=ShapeTable(_GAUSS_ORDER, x, w, values @ V, slopes @ V),
        cells=np.searchsorted(x, stations),
    )


def spectrum(scenario: Scenario) -> SpinningBeam:
    """Elastic operators of the mesh for the frequencies of the spinning beam, in all its modes."""
    hinged = scenario.root.kind == "pin"
    nodal = NodalBeam.from_scenario(scenario)
    o = project(nodal, eigenmodes(nodal, "hinged" if hinged else "clamped", None))
    return SpinningBeam(o.K, o.M1, o.C, hinged=hinged)

"""From the nodal model to BeamOperators: projection onto the mesh's own eigenmodes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array
from scipy.sparse.linalg import eigsh

from oblique_impact.beam.axis import ShapeFunctions
from oblique_impact.beam.operators import (
    BeamOperators,
    ShapeTable,
    SpinningBeam,
    StationTable,
    eigenvectors,
    gauss_rule,
    station_points,
)
from oblique_impact.fem_beam.nodal import Array, NodalBeam, merge_points
from oblique_impact.scenario.scenario import Scenario

Indices = NDArray[np.int64]

_GAUSS_ORDER = 6  # a linear mass times squares of foreshortening rates is a polynomial of degree 11
_LARGE = 200  # degrees of freedom, from which on a few modes are found without dense matrices


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

    "hinged" ones turn with the hub, if there is one.  Their modal mass, with the hub's, is the mass of the beam:
    those of a uniform one are scaled like the eigenfunctions of ``modal``; the tip is positive.  A few modes of a
    large mesh take a shift-invert Lanczos method, all others the decomposition of dense matrices.
    """
    free = nodal.free_dofs(root)
    rigid = 1 if root == "hinged" else 0  # the rigid rotation has frequency 0
    few = count is not None and free.size > _LARGE and count + rigid <= free.size // 4
    shapes = _lowest(nodal, free, count + rigid) if few and count is not None else _all(nodal, free)
    shapes = shapes[:, rigid:][:, :count] * np.sqrt(nodal.sections.mass)
    shapes *= np.where(shapes[-2] < 0.0, -1.0, 1.0)
    modes = np.zeros((nodal.basis.N, shapes.shape[1]))
    modes[free] = shapes
    return modes


def _all(nodal: NodalBeam, free: Indices) -> Array:
    """Eigenvectors (n, n), ascending, from the square root of the stiffness."""
    mass = nodal.mass_with_hub.toarray()[np.ix_(free, free)]
    return eigenvectors(nodal.curvature_factor().toarray()[:, free], mass)


def _lowest(nodal: NodalBeam, free: Indices, count: int) -> Array:
    """Eigenvectors (n, count) of the lowest frequencies, ascending, by shift-invert Lanczos.

    The shift lies below zero, where K - shift M1 is definite in spite of the rigid rotation.  Eigenvectors err by
    the rounding of the factors, frequencies and operators, which are quadratic in it, by its square.
    """
    sections = nodal.sections
    middle = np.array([0.5 * sections.length])
    shift = -float(sections.bending_stiffness(middle)[0]) / (sections.mass * sections.length**3)
    K, mass = (csc_array(matrix[free][:, free]) for matrix in (nodal.K, nodal.mass_with_hub))
    start = np.ones(free.size)  # not at random: the same beam gives the same modes
    squares, vectors = eigsh(K, count, mass, sigma=shift, which="LM", v0=start, tol=0.0)
    return np.asarray(vectors[:, np.argsort(squares)])


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
        along=ShapeFunctions(lambda x, order: np.asarray(nodal.evaluate(x)[order] @ V), nodal.nodes, degree=3),
    )


def _station_table(nodal: NodalBeam, V: Array | csr_array) -> StationTable:
    stations = station_points(nodal.sections.length, nodal.scenario.contact.point)
    edges = merge_points(nodal.edges, stations)
    x, w = gauss_rule(edges, _GAUSS_ORDER)
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
    """Operators of the mesh for the frequencies of the spinning beam, in all its clamped modes."""
    nodal = NodalBeam.from_scenario(scenario)
    return SpinningBeam.of(project(nodal, eigenmodes(nodal, "clamped", None)), scenario)

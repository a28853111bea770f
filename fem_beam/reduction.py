"""From the nodal model to BeamOperators: projection onto the mesh's own eigenmodes, or all nodes, banded."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array, eye_array, lil_array
from scipy.sparse.linalg import eigsh

from oblique_impact.beam.axis import ShapeFunctions
from oblique_impact.beam.operators import (
    BeamOperators,
    ShapeTable,
    SpinningBeam,
    StationTable,
    eigenvectors,
    gauss_rule,
    merge_points,
    station_points,
)
from oblique_impact.fem_beam.nodal import Array, NodalBeam
from oblique_impact.scenario.scenario import Scenario

Indices = NDArray[np.int64]

_GAUSS_ORDER = 6  # a linear mass times squares of foreshortening rates is a polynomial of degree 11
_MASS_POINTS = 6  # of Gauss's rule: a mass of degree 8 times cubics
_LARGE = 200  # degrees of freedom, from which on a few modes are found without dense matrices


def build_operators(scenario: Scenario) -> BeamOperators:
    """Discretize the beam of `scenario` by Hermite elements, reduced to its first modes.

    With `discretization.modes = 0` all modes of the mesh are kept, which is the nodal model in other
    coordinates.
    """
    nodal = NodalBeam.from_scenario(scenario)
    d = scenario.discretization
    modes = eigenmodes(nodal, _root_of(nodal) if d.frame == "tangent" else "hinged", d.modes or None)
    return project(nodal, modes)


def _root_of(nodal: NodalBeam) -> str:
    """How the root is held: "clamped", or "yielding" by the spring of its clamp."""
    return "yielding" if nodal.sections.clamp_stiffness > 0.0 else "clamped"


def eigenmodes(nodal: NodalBeam, root: str, count: int | None) -> Array:
    """Elastic eigenvectors, shape (2 nodes, count), in ascending order of frequency; all if count is None.

    "hinged" ones turn with the hub, if there is one, "yielding" ones on the spring of the clamp.  The modal mass,
    with the hub's, is the mass of the beam: those of a uniform one are scaled like the eigenfunctions of
    ``modal``; the tip is positive.  A few modes of a large mesh take a shift-invert Lanczos method, all others the
    decomposition of dense matrices.
    """
    free = nodal.free_dofs("clamped" if root == "clamped" else "hinged")
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
    mass = nodal.whole_mass.toarray()[np.ix_(free, free)]
    factor, clamp = nodal.curvature_factor().toarray(), nodal.sections.clamp_stiffness
    if clamp > 0.0:
        factor = np.vstack([factor, np.sqrt(clamp) * np.eye(1, nodal.basis.N, 1)])
    return eigenvectors(factor[:, free], mass)


def _lowest(nodal: NodalBeam, free: Indices, count: int) -> Array:
    """Eigenvectors (n, count) of the lowest frequencies, ascending, by shift-invert Lanczos.

    The shift lies below zero, where K - shift M1 is definite in spite of the rigid rotation.  Eigenvectors err by
    the rounding of the factors, frequencies and operators, which are quadratic in it, by its square.
    """
    sections = nodal.sections
    middle = np.array([0.5 * sections.length])
    shift = -float(sections.bending_stiffness(middle)[0]) / (sections.mass * sections.length**3)
    K, mass = (csc_array(matrix[free][:, free]) for matrix in (nodal.stiffness, nodal.whole_mass))
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
    """Operators of the mesh for the frequencies of the spinning beam, in all its modes seen from the root."""
    nodal = NodalBeam.from_scenario(scenario)
    return SpinningBeam.of(project(nodal, eigenmodes(nodal, _root_of(nodal), None)), scenario)


# --- without reduction


def build_nodal(scenario: Scenario) -> BeamOperators:
    """Discretize the beam of `scenario` by Hermite elements; nothing is reduced.

    The first degree of freedom is the slope of the root, which a hub of radius r moves across by r times it.  Of a
    clamp that yields it is that of the drive alone, and the slope of the root follows as the second one.

    With `contact.point_inertia = "none"` the deflection of the contact point, the beam's end, follows the other
    degrees of freedom statically, without inertia of its own; translations and rotations, so mass, static moment
    and inertia, are kept exactly.  Where the whole beam can touch obstacles, and in time-stepping, no node has
    inertia, see :func:`without_nodal_inertia`.
    """
    nodal, radius, left_out = NodalBeam.from_scenario(scenario), scenario.root.hub_radius, 0.0
    kept, rigid = _total_coordinates(nodal, radius)
    K = csr_array(kept.T @ nodal.K @ kept)
    massless = scenario.contact.point_inertia == "none"
    anywhere = scenario.contact.where == "anywhere" or scenario.solver.scheme == "time-stepping"
    if massless and not anywhere:
        static, left_out = _without_inertia(K, rigid.size - 2)
        others = np.delete(np.arange(rigid.size), rigid.size - 2)
        kept, K, rigid = csr_array(kept @ static), csr_array(static.T @ (K @ static)), rigid[others]
    operators = project(nodal, kept)
    if massless and anywhere:
        operators = without_nodal_inertia(nodal, operators, kept, rigid)
    # integrals with the function x are taken from the elements too: rigid rotations must cancel to the last digit
    static_moment = float(rigid @ operators.P)
    # the hub as a rigid bar, which does not bend in its own frame: M1 x = C x then
    bar = csr_array(([radius * static_moment], ([0], [0])), shape=K.shape)
    return replace(
        operators,
        K=K,
        C=csr_array(operators.C + bar),
        J=float(rigid @ operators.S),
        Sm=static_moment,
        rigid=rigid,
        curvature_factor=csr_array(nodal.curvature_factor() @ kept),
        left_out=left_out,
        largest_element=float(np.max(np.diff(nodal.nodes))),
        along=ShapeFunctions(lambda x, order: (nodal.evaluate(x)[order] @ kept).toarray(), nodal.nodes, degree=3),
    )


def _total_coordinates(nodal: NodalBeam, radius: float) -> tuple[csr_array, Array]:
    """Return the nodal values by the coordinates W, (2 nodes, n), and those of a rigid rotation, (n,)."""
    values = csr_array(eye_array(nodal.basis.N))
    rigid = nodal.rigid_rotation.copy()
    rigid[0::2] += radius
    if nodal.sections.clamp_stiffness > 0.0:
        kept, rigid[0] = values.tolil(), 1.0
        kept[0, 0] = radius
        return csr_array(kept), rigid
    kept = values[:, nodal.free_dofs("hinged")].tolil()
    kept[0, 0] = radius
    return csr_array(kept), rigid[1:]


def without_nodal_inertia(
    nodal: NodalBeam, operators: BeamOperators, kept: csr_array, rigid: Array
) -> BeamOperators:
    """Give the beam velocities that are constant on each element, its mean ones: its nodes have no inertia then.

    The mass sum_e m_e b_e^T b_e, with the mass m_e of an element and its mean b_e = int m Phi/m_e, leaves one more
    motion without inertia than there are nodes, so that all of them can rest on obstacles without impacts (Renard,
    Comput. Methods Appl. Mech. Eng. 199, 2010; Pozzolini and Salaun, ESAIM M2AN 45, 2011).  Mass and static moment
    are kept exactly, the inertia to the square of the elements; forces of spin are those of the elements.
    """
    edges = nodal.nodes
    points, weights = gauss_rule(nodal.edges, _MASS_POINTS)
    cells = np.searchsorted(edges, points) - 1
    masses = nodal.sections.mass_per_length(points) * weights
    shares = csr_array((masses, (cells, np.arange(points.size))), shape=(edges.size - 1, points.size))
    of_elements = shares.sum(axis=1)
    means = csr_array((shares @ (nodal.evaluate(points)[0] @ kept)).multiply(1.0 / of_elements[:, None]))
    mass = csr_array(means.T @ means.multiply(of_elements[:, None]))
    return replace(operators, M1=mass, C=csr_array(operators.C + mass - operators.M1), S=mass @ rigid, means=means)


def _without_inertia(K: csr_array, point: int) -> tuple[csr_array, float]:
    """Return the static response (n, n - 1) to all degrees of freedom but `point`, and 1/K_pp (m/N)."""
    row, others = K[[point]].toarray()[0], np.delete(np.arange(K.shape[0]), point)
    response = lil_array((K.shape[0], K.shape[0] - 1))
    response[others, np.arange(others.size)] = 1.0
    coupled = np.flatnonzero(row[others])
    response[point, coupled] = -row[others][coupled] / row[point]
    return csr_array(response), 1.0 / float(row[point])

"""Results along the beam against their definitions, by quadratures of their own."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial import Polynomial, legendre
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.sparse import csr_array

from oblique_impact import fem_beam
from oblique_impact.beam.beam import Beam
from oblique_impact.beam.operators import build_operators, cumulative
from oblique_impact.beam.section_forces import Motion, displacements_along, fields_along
from oblique_impact.fem_beam.reduction import eigenmodes
from oblique_impact.modal import Eigenfunctions
from tests.beam.test_discretizations import EI, LENGTH, POINT, RADIUS, scenario_of


def motion_of(size, seed=2):
    rng = np.random.default_rng(seed)
    q, qd, qdd = 2e-2 * rng.normal(size=(2, size)), rng.normal(size=(2, size)), 50.0 * rng.normal(size=(2, size))
    q[:, 0], qd[:, 0] = [0.4, -1.0], [-3.0, 5.0]
    return Motion(np.zeros(2), q, qd, qdd, np.array([120.0, 30.0]), np.array([-25.0, 9.0]))


def curvature_moment(beam, q):
    """E I u_y'' (N m) of the shapes at the stations: in smooth motion it is that of equilibrium."""
    stations = beam.operators.stations
    return beam.operators.sections.bending_stiffness(stations.points) * (q[:, 1:] @ stations.curvatures.T)


def beam_of(method, **changes):
    radius = changes.pop("radius", 0.0)
    scenario = scenario_of("tangent", method, radius=radius, modes=3, elements=4, **changes)
    return Beam(scenario, build_operators(scenario))


def field(beam, B, derivative):
    """x -> Phi^(k)(x) B from the source's shape functions at any points (themselves tested above)."""
    if beam.scenario.discretization.method == "modal":
        shapes = Eigenfunctions("clamped-free", 3, LENGTH)
        return lambda x: np.squeeze(shapes.derivative(np.atleast_1d(x), derivative) @ B)
    nodal = fem_beam.NodalBeam.from_scenario(beam.scenario)
    v = eigenmodes(nodal, "clamped", 3) @ B
    return lambda x: np.squeeze(nodal.evaluate(np.atleast_1d(x))[derivative] @ v)


@pytest.mark.parametrize("method", ["modal", "fem"])
def test_fields_along_the_beam(method):
    beam = beam_of(method)
    motion = motion_of(4)
    fields, x = fields_along(beam, motion), beam.operators.stations.points
    bending = curvature_moment(beam, motion.q)
    assert (x[0], x[-1]) == (0.0, LENGTH)
    assert np.count_nonzero(np.abs(x - POINT) < 1e-12) == 1
    for sample in range(2):
        B = motion.q[sample, 1:]
        u, slope, curvature = (field(beam, B, k) for k in range(3))
        breaks = fem_beam.NodalBeam.from_scenario(beam.scenario).nodes if method == "fem" else np.array([LENGTH])
        for station in range(0, x.size, 3):
            at = x[station]
            inside = breaks[(breaks > 0.0) & (breaks < at)]
            assert fields.uy[sample, station] == pytest.approx(u(at), abs=1e-14)
            if not np.any(np.abs(breaks - at) < 1e-9):  # at a node the curvature of the elements jumps
                assert bending[sample, station] == pytest.approx(EI * curvature(at), rel=1e-9, abs=1e-8)
            bent = quad(lambda s: slope(s) ** 2, 0.0, at, points=inside, epsabs=1e-12)[0] if at else 0.0  # noqa: B023
            assert fields.ux[sample, station] == pytest.approx(-0.5 * bent, rel=1e-10, abs=1e-14)


AREAS = [[0.0, 3e-4], [0.4, 5e-4], [LENGTH, 2e-4]]
SECOND_MOMENTS = [[0.0, 9e-9], [0.9, 4e-9], [LENGTH, 6e-9]]
VARIED = {
    "beam__area": AREAS,
    "beam__second_moment": SECOND_MOMENTS,
    "beam__tip_mass": 0.3,
    "beam__mass_proportional": 3.0,
    "beam__outer_fibre": 0.011,
}


NODES, WEIGHTS = legendre.leggauss(12)
#: from values at the nodes to integrals from -1 to each of them
INNER = np.linalg.solve(
    legendre.legvander(NODES, 11).T, [legendre.Legendre.basis(n).integ(lbnd=-1)(NODES) for n in range(12)]
).T


class OuterPart:
    """Forces on the points of a fine quadrature, with integrals of its own for u_x and its rates."""

    def __init__(self, beam, kinks):
        x = beam.operators.stations.points
        edges = (
            fem_beam.NodalBeam.from_scenario(beam.scenario).nodes
            if beam.scenario.discretization.method == "fem"
            else x
        )
        edges = np.union1d(np.union1d(edges, x), kinks)
        edges = edges[np.append(True, np.diff(edges) > 1e-12)]
        self.halves = 0.5 * np.diff(edges)
        self.s = (edges[:-1, None] + self.halves[:, None] * (1.0 + NODES)).ravel()
        self.w = np.outer(self.halves, WEIGHTS).ravel()
        self.points = np.append(self.s, LENGTH)  # with the tip mass
        shapes = [field(beam, row, k) for row in np.eye(3) for k in (0, 1)]
        self.values, self.slopes = (np.stack([f(self.points) for f in shapes[k::2]], axis=1) for k in (0, 1))
        self.outline, self.tangents = (np.stack([f(x) for f in shapes[k::2]], axis=1) for k in (0, 1))
        beam_section = beam.scenario.beam
        area = np.array(AREAS if beam_section.tip_mass else [[0.0, 3.14e-4], [LENGTH, 3.14e-4]])
        masses = 2766.7 * np.interp(self.s, area[:, 0], area[:, 1]) * self.w
        self.mass = np.append(masses, beam_section.tip_mass)
        self.damping = beam_section.mass_proportional

    def integral(self, f):
        """Integrals of f, a polynomial in each panel, from the root to every point and to the tip."""
        panels = f[:-1].reshape(-1, NODES.size)
        whole = np.cumsum(self.halves * (panels @ WEIGHTS))
        inside = self.halves[:, None] * (panels @ INNER.T)
        return np.append((np.append(0.0, whole[:-1])[:, None] + inside).ravel(), whole[-1])

    def forces(self, state, rates, accelerations, radius, kept):
        """Positions X, Y in the frame and forces there, inertia, gravity and outside damping."""
        (theta, *B), (spin, *Bd), (spin_rate, *Bdd) = state, rates, accelerations
        d, dd, ddd = self.slopes @ B, self.slopes @ Bd, self.slopes @ Bdd
        X = radius + self.points - 0.5 * kept * self.integral(d * d)
        Xd, Xdd = -kept * self.integral(d * dd), -kept * self.integral(dd**2 + d * ddd)
        Y, Yd, Ydd = self.values @ B, self.values @ Bd, self.values @ Bdd
        axial = Xdd - spin_rate * Y - 2.0 * spin * Yd - spin**2 * X
        transverse = Ydd + spin_rate * X + 2.0 * spin * Xd - spin**2 * Y + self.damping * Yd
        return X, Y, -self.mass * (axial + 9.8 * np.sin(theta)), -self.mass * (transverse + 9.8 * np.cos(theta))


@pytest.mark.parametrize("source", ["modal", "fem", "varied"])
@pytest.mark.parametrize(("kinetics", "radius"), [("first-order", RADIUS), ("full", 0.0), ("zeroth-order", 0.0)])
def test_section_forces_are_the_reaction_of_the_accelerated_outer_part(source, kinetics, radius):
    """Sums of f = -m (a - g) over the outer part and their moments about the section."""
    method, changes = ("modal", {}) if source == "modal" else ("fem", VARIED if source == "varied" else {})
    beam = beam_of(method, radius=radius, discretization__kinetics=kinetics, **changes)
    motion, x = motion_of(4), beam.operators.stations.points
    fields, part = fields_along(beam, motion), OuterPart(beam, [0.4, 0.9] if source == "varied" else [])
    kept = 0.0 if kinetics == "zeroth-order" else 1.0
    at_contact = int(np.argmin(np.abs(x - POINT)))
    for sample in range(2):
        B = motion.q[sample, 1:]
        X, Y, axial, transverse = part.forces(*(v[sample] for v in motion[1:4]), radius, kept)
        angle = motion.q[sample, 0] - beam.scenario.slope.angle
        normal, tangential = motion.normal_force[sample], motion.tangential_force[sample]
        push_a = normal * np.sin(angle) + tangential * np.cos(angle)
        push_t = normal * np.cos(angle) - tangential * np.sin(angle)
        X_s, Y_s = radius + x + fields.ux[sample], part.outline @ B
        for k, at in enumerate(x):
            outer, touched = part.points >= at, k <= at_contact
            N = axial[outer].sum() + touched * push_a
            T = transverse[outer].sum() + touched * push_t
            moment = (X[outer] - X_s[k]) @ transverse[outer] - (Y[outer] - Y_s[k]) @ axial[outer]
            moment += touched * ((X_s[at_contact] - X_s[k]) * push_t - (Y_s[at_contact] - Y_s[k]) * push_a)
            tangent = part.tangents[k] @ B
            shear = tangent * N - (1.0 - 0.5 * kept * tangent**2) * T
            assert fields.axial_force[sample, k] == pytest.approx(N, rel=1e-8, abs=1e-7)
            assert fields.moment[sample, k] == pytest.approx(moment, rel=1e-8, abs=1e-7)
            assert fields.shear[sample, k] == pytest.approx(shear, rel=1e-8, abs=1e-7)
            modulus = np.sqrt(3.14e-4 / np.pi) / 7.85e-9  # of a circle of that area
            if source == "varied":
                modulus = 0.011 / np.interp(at, *np.transpose(SECOND_MOMENTS))
            assert fields.bending_stress[sample, k] == pytest.approx(moment * modulus, rel=1e-7, abs=1.0)


def test_shear_is_the_slope_of_the_moment():
    """With stations next to each other: the contact point close to an output station."""
    beam = beam_of("modal", point=0.5 * LENGTH + 1e-5 * LENGTH, radius=RADIUS)
    fields, x = fields_along(beam, motion_of(4)), beam.operators.stations.points
    k = int(np.flatnonzero(np.diff(x) < 1e-4)[0])
    rise = (fields.moment[:, k + 1] - fields.moment[:, k]) / (x[k + 1] - x[k])
    assert_allclose(rise, 0.5 * (fields.shear[:, k + 1] + fields.shear[:, k]), rtol=1e-6)


def test_fields_do_not_depend_on_the_block_and_take_sparse_tables():
    beam, rng = beam_of("fem", **VARIED), np.random.default_rng(5)
    motion = Motion(np.zeros(7), *(rng.normal(size=(7, 4)) for _ in range(3)), *rng.normal(size=(2, 7)))
    motion.qdd[4] = np.nan
    whole = fields_along(beam, motion, 100)
    stations = beam.operators.stations
    table = stations.quadrature
    sparse = replace(
        stations,
        values=csr_array(stations.values),
        slopes=csr_array(stations.slopes),
        curvatures=csr_array(stations.curvatures),
        quadrature=replace(table, values=csr_array(table.values), slopes=csr_array(table.slopes)),
    )
    other = beam_of("fem", **VARIED)
    other.operators = replace(beam.operators, stations=sparse)
    for name, expected in whole._asdict().items():
        for result in (fields_along(beam, motion, 3), fields_along(other, motion, 2)):
            assert_allclose(getattr(result, name), expected, rtol=1e-9, atol=1e-9 * np.nanmax(np.abs(expected)))
        unknown = np.isnan(expected)
        assert unknown[4].all() == (name not in ("ux", "uy", "ux_dot", "uy_dot"))
        assert not unknown[[0, 1, 2, 3, 5, 6]].any()


def test_cumulative_integral_is_exact_for_polynomials_of_the_panels():
    table = beam_of("fem").operators.stations.quadrature
    p = Polynomial([0.2, -1.0, 0.5, 3.0, -2.0, 1.0])
    assert_allclose(cumulative(table, p(table.points)), p.integ()(table.points), atol=1e-14)
    both = np.stack([p(table.points), table.points], axis=1)
    assert_allclose(cumulative(table, both)[:, 1], 0.5 * table.points**2, atol=1e-15)


@pytest.mark.parametrize("kinetics", ["zeroth-order", "first-order"])
def test_displacements_alone_are_those_of_the_fields(kinetics):
    beam, rng = beam_of("modal", discretization__kinetics=kinetics), np.random.default_rng(6)
    size = beam.operators.size + 1
    motion = Motion(np.zeros(7), *(rng.normal(size=(7, size)) for _ in range(3)), *rng.normal(size=(2, 7)))
    fields = fields_along(beam, motion)
    found = displacements_along(beam, motion.q, motion.qd)
    for values, expected in zip(found, (fields.ux, fields.uy, fields.ux_dot, fields.uy_dot), strict=True):
        assert_allclose(values, expected, rtol=1e-12, atol=1e-14)
    assert (np.abs(found[0][:, -1]) > 1e-3).all() == (kinetics != "zeroth-order")

"""Both discretizations against their definitions: textbook functions, element polynomials, adaptive quadrature."""

import itertools

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.linalg import eigh
from scipy.optimize import brentq

import fem_beam
import modal
from fem_beam.nodal import banded
from fem_beam.reduction import eigenmodes
from modal import Eigenfunctions
from oblique_impact import InputError, Scenario
from oblique_impact.beam import Beam, Motion, cumulative
from oblique_impact.operators import build_operators

M, EI = 2766.7 * 3.14e-4, 68.952e9 * 7.85e-9
LENGTH, POINT, RADIUS = 1.3, 0.47, 0.15


def scenario_of(frame, method="modal", radius=0.0, point=POINT, modes=3, elements=8, **changes):
    root = {"root__kind": "hub", "root__hub_radius": radius} if radius else {}
    return Scenario().replace(
        beam__length=LENGTH,
        contact__point=point,
        contact__enabled=False,
        discretization__method=method,
        discretization__frame=frame,
        discretization__modes=modes,
        discretization__elements=elements,
        **root,
        **changes,
    )


# Assumed modes --------------------------------------------------------------------------------------------------


def textbook(frame, mode, length):
    """phi and its first two derivatives by the formulas of any textbook, int phi^2 dx = length, phi(L) > 0."""
    low = (mode + 0.5) * np.pi
    if frame == "tangent":
        b = brentq(lambda z: np.cos(z) + 1.0 / np.cosh(z), low - 1.2, low + 1.2, xtol=1e-15)
        s = (np.cosh(b) + np.cos(b)) / (np.sinh(b) + np.sin(b))
        parts = [
            lambda z: np.cosh(z) - np.cos(z) - s * (np.sinh(z) - np.sin(z)),
            lambda z: np.sinh(z) + np.sin(z) - s * (np.cosh(z) - np.cos(z)),
            lambda z: np.cosh(z) + np.cos(z) - s * (np.sinh(z) + np.sin(z)),
        ]
    else:
        low = (mode + 1.25) * np.pi
        b = brentq(lambda z: np.sin(z) - np.cos(z) * np.tanh(z), low - 0.3, low + 0.3, xtol=1e-15)
        s = np.sin(b) / np.sinh(b)
        parts = [
            lambda z: np.sin(z) + s * np.sinh(z),
            lambda z: np.cos(z) + s * np.cosh(z),
            lambda z: -np.sin(z) + s * np.sinh(z),
        ]
    norm = integrate(lambda x: parts[0](b * x) ** 2, 0.0, 1.0)
    scale = np.sign(parts[0](b)) / np.sqrt(norm)
    return [lambda x, f=f, k=k: scale * (b / length) ** k * f(b * x / length) for k, f in enumerate(parts)]


GAUSS = np.polynomial.legendre.leggauss(40)


def integrate(f, a=0.0, b=LENGTH):
    """Integral of a smooth function to rounding."""
    nodes, weights = GAUSS
    return (
        0.5 * (b - a) * sum(w * f(0.5 * (a + b) + 0.5 * (b - a) * z) for z, w in zip(nodes, weights, strict=True))
    )


@pytest.mark.parametrize(("frame", "radius"), [("tangent", 0.0), ("tangent", RADIUS), ("mean-axis", 0.0)])
def test_modal_operators_are_their_definitions(frame, radius):
    o = modal.build_operators(scenario_of(frame, radius=radius))
    shapes = [textbook(frame, i, LENGTH) for i in range(3)]
    for i, (f, df, ddf) in enumerate(shapes):
        assert o.S[i] == pytest.approx(integrate(lambda x: M * (radius + x) * f(x)), abs=1e-11)  # noqa: B023
        assert o.P[i] == pytest.approx(M * integrate(f), abs=1e-11)
        assert o.contact_shape[i] == pytest.approx(f(POINT), abs=1e-12)
        assert o.root_slope[i] == pytest.approx(df(0.0), abs=1e-11)
        for j, (g, dg, ddg) in enumerate(shapes):

            def h(x, p=df, q=dg):  # H_ij(x), the coupling deformation
                return integrate(lambda s: p(s) * q(s), 0.0, x)

            assert o.M1[i, j] == pytest.approx(M * integrate(lambda x, f=f, g=g: f(x) * g(x)), abs=1e-11)
            bending = EI * integrate(lambda x, f=ddf, g=ddg: f(x) * g(x))
            assert o.K[i, j] == pytest.approx(bending, abs=1e-11 * o.K[2, 2])
            assert o.contact_shortening[i, j] == pytest.approx(h(POINT), abs=1e-10)
            if i <= j:
                centrifugal = integrate(lambda x, h=h: M * (radius + x) * h(x))
                assert o.C[i, j] == pytest.approx(centrifugal, abs=1e-10)
                assert o.C[j, i] == pytest.approx(centrifugal, abs=1e-10)
                assert o.D[i, j] == pytest.approx(M * integrate(h), abs=1e-10)
    assert pytest.approx(integrate(lambda x: M * (radius + x) ** 2), rel=1e-13) == o.J
    assert pytest.approx(integrate(lambda x: M * (radius + x)), rel=1e-13) == o.Sm


@pytest.mark.parametrize("family", ["clamped-free", "hinged-free"])
def test_eigenfunctions_keep_their_digits_at_high_orders(family):
    """100 modes: orthonormal, with the exact frequencies; the textbook's cosh - sinh fails from 12 on."""
    frame = "tangent" if family == "clamped-free" else "mean-axis"
    o = modal.build_operators(scenario_of(frame, modes=100))
    shapes = Eigenfunctions(family, 100, LENGTH)
    assert_allclose(o.M1, M * LENGTH * np.eye(100), atol=1e-12)
    exact = EI * shapes.roots**4 / LENGTH**3
    assert_allclose(o.K / np.sqrt(np.outer(exact, exact)), np.eye(100), atol=1e-11)
    assert_allclose(shapes.derivative(np.array([LENGTH]), 0), 2.0 * np.ones((1, 100)), rtol=1e-12)
    scaled = shapes.derivative(np.array([LENGTH]), 2) / shapes.roots**2  # free end
    assert_allclose(scaled, np.zeros((1, 100)), atol=1e-12)
    assert_allclose(shapes.derivative(np.zeros(1), 0), np.zeros((1, 100)), atol=1e-12)


@pytest.mark.parametrize("family", ["clamped-free", "hinged-free"])
def test_eigenfunction_derivatives_are_derivatives(family):
    shapes = Eigenfunctions(family, 4, LENGTH)
    x, h = np.linspace(0.1, 1.2, 7), 1e-4
    for order in (0, 1, 2):
        difference = (shapes.derivative(x + h, order) - shapes.derivative(x - h, order)) / (2.0 * h)
        scale = np.abs(shapes.derivative(x, order + 1)).max()
        assert_allclose(shapes.derivative(x, order + 1), difference, atol=1e-5 * scale)


# Finite elements ------------------------------------------------------------------------------------------------


def hermite(h):
    """Cubic shape functions of an element of length h over z = (x - a)/h: deflection and slope at either end."""
    z = Polynomial([0.0, 1.0])
    return [1 - 3 * z**2 + 2 * z**3, h * (z - 2 * z**2 + z**3), 3 * z**2 - 2 * z**3, h * (z**3 - z**2)]


def over(polynomial, h):
    """Integral over an element of a polynomial in z."""
    return h * polynomial.integ()(1.0)


def assembled(nodes, weight, derivative):
    """Int weight phi_i^(k) phi_j^(k), by exact integration of polynomials element by element."""
    n = 2 * nodes.size
    total = np.zeros((n, n))
    for e, (a, b) in enumerate(itertools.pairwise(nodes)):
        h = b - a
        shapes = [p.deriv(derivative) / h**derivative if derivative else p for p in hermite(h)]
        for i, p in enumerate(shapes):
            for j, q in enumerate(shapes):
                total[2 * e + i, 2 * e + j] += over(weight(Polynomial([a, h])) * p * q, h)
    return total


def loaded(nodes, weight):
    total = np.zeros(2 * nodes.size)
    for e, (a, b) in enumerate(itertools.pairwise(nodes)):
        for i, p in enumerate(hermite(b - a)):
            total[2 * e + i] += over(weight(Polynomial([a, b - a])) * p, b - a)
    return total


def test_element_matrices_of_the_textbook():
    nodal = fem_beam.NodalBeam.from_scenario(scenario_of("tangent", "fem", point=LENGTH, elements=1, modes=1))
    h = LENGTH
    mass = np.array(
        [
            [156, 22 * h, 54, -13 * h],
            [22 * h, 4 * h * h, 13 * h, -3 * h * h],
            [54, 13 * h, 156, -22 * h],
            [-13 * h, -3 * h * h, -22 * h, 4 * h * h],
        ]
    )
    stiffness = np.array(
        [
            [12, 6 * h, -12, 6 * h],
            [6 * h, 4 * h * h, -6 * h, 2 * h * h],
            [-12, -6 * h, 12, -6 * h],
            [6 * h, 2 * h * h, -6 * h, 4 * h * h],
        ]
    )
    assert_allclose(nodal.M1.toarray(), M * h / 420.0 * mass, rtol=1e-12)
    assert_allclose(nodal.K.toarray(), EI / h**3 * stiffness, rtol=1e-12)
    assert_allclose(nodal.P, M * h / 12.0 * np.array([6, h, 6, -h]), rtol=1e-12)


@pytest.mark.parametrize("radius", [0.0, RADIUS])
@pytest.mark.parametrize("point", [POINT, LENGTH])
def test_nodal_operators_are_their_definitions(radius, point):
    nodal = fem_beam.NodalBeam.from_scenario(scenario_of("tangent", "fem", radius=radius, point=point, elements=5))
    nodes, x = nodal.nodes, Polynomial([0.0, 1.0])
    assert nodes.size == 6
    expected = {
        "M1": assembled(nodes, M * (x**0), 0),
        "K": assembled(nodes, EI * (x**0), 2),
        "C": assembled(nodes, M * (radius * (LENGTH - x) + (LENGTH**2 - x**2) / 2), 1),
        "D": assembled(nodes, M * (LENGTH - x), 1),
    }
    for name, matrix in expected.items():
        assert_allclose(getattr(nodal, name).toarray(), matrix, atol=1e-12 * np.abs(matrix).max(), err_msg=name)
    inner = nodes[nodes < point + 1e-9]
    assert inner[-1] == pytest.approx(point, abs=1e-15)
    shortening = np.zeros((12, 12))
    shortening[: 2 * inner.size, : 2 * inner.size] = assembled(inner, x**0, 1)
    assert_allclose(nodal.contact_shortening.toarray(), shortening, atol=1e-12)
    assert_allclose(nodal.S, loaded(nodes, M * (radius + x)), atol=1e-13)
    assert_allclose(nodal.P, loaded(nodes, M * (x**0)), atol=1e-13)
    if radius == 0.0:
        # what makes the mean-axis gauge free of cost: S = M1 xvec, K xvec = 0
        assert_allclose(nodal.M1 @ nodal.rigid_rotation, nodal.S, atol=1e-12)
        assert_allclose(nodal.K @ nodal.rigid_rotation, np.zeros(12), atol=1e-9)


def test_centrifugal_weight_is_the_swapped_double_integral():
    """C = int m (r + x) H(x) dx for a field in the element space: nested adaptive quadrature."""
    nodal = fem_beam.NodalBeam.from_scenario(scenario_of("tangent", "fem", radius=RADIUS, elements=4))
    rng = np.random.default_rng(3)
    v = rng.normal(size=10)
    nodes = nodal.nodes

    def slope(x):
        e = min(np.searchsorted(nodes, x, side="right") - 1, 3)
        width = nodes[e + 1] - nodes[e]
        z = (x - nodes[e]) / width
        return sum(c * p.deriv()(z) / width for c, p in zip(v[2 * e :], hermite(width), strict=False))

    def h(x):
        return quad(lambda s: slope(s) ** 2, 0.0, x, points=nodes[(nodes > 0) & (nodes < x)], epsabs=1e-9)[0]

    centrifugal = quad(lambda x: M * (RADIUS + x) * h(x), 0.0, LENGTH, points=nodes[1:-1], epsrel=1e-8)[0]
    assert v @ (nodal.C @ v) == pytest.approx(centrifugal, rel=1e-8)


@pytest.mark.parametrize(("point", "elements"), [(0.47, 2), (0.47, 7), (0.05, 6), (1.29, 6), (0.65, 8), (1.3, 5)])
def test_a_node_lies_at_the_contact_point(point, elements):
    nodes = fem_beam.NodalBeam.from_scenario(
        scenario_of("tangent", "fem", point=point, elements=elements, modes=2)
    ).nodes
    assert nodes.size == elements + 1
    assert np.all(np.diff(nodes) > 0.0)
    assert (nodes[0], nodes[-1]) == (0.0, LENGTH)
    assert np.abs(nodes - point).min() <= 1e-15


def test_banded_storage_reproduces_the_matrix():
    nodal = fem_beam.NodalBeam.from_scenario(scenario_of("tangent", "fem", elements=6))
    for matrix in (nodal.K, nodal.M1, nodal.C, nodal.D, nodal.contact_shortening):
        dense, storage = matrix.toarray(), banded(matrix)
        assert storage.shape == (4, 14)
        rebuilt = np.zeros_like(dense)
        for k in range(4):
            rebuilt += np.diag(storage[3 - k, k:], k)
            if k:
                rebuilt += np.diag(storage[3 - k, k:], -k)
        assert_allclose(rebuilt, dense, atol=1e-14 * np.abs(dense).max())


def test_nodal_evaluation_interpolates_cubics_exactly():
    nodal = fem_beam.NodalBeam.from_scenario(scenario_of("tangent", "fem", elements=5))
    cubic = Polynomial([0.3, -1.0, 2.0, 0.7])
    v = np.zeros(12)
    v[0::2], v[1::2] = cubic(nodal.nodes), cubic.deriv()(nodal.nodes)
    x = np.append(nodal.nodes, np.linspace(0.0, LENGTH, 17))
    for k, table in enumerate(nodal.evaluate(x)):
        assert_allclose(table @ v, (cubic.deriv(k) if k else cubic)(x), atol=1e-11)
    factor = nodal.curvature_factor().toarray()
    assert_allclose(factor.T @ factor, nodal.K.toarray(), atol=1e-11 * nodal.K.max())


# Reduction ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("frame", "first"), [("tangent", 2), ("mean-axis", 1)])
@pytest.mark.parametrize("modes", [0, 4])
def test_reduction_keeps_the_frequencies_of_the_nodal_eigenproblem(frame, first, modes):
    scenario = scenario_of(frame, "fem", elements=6, modes=modes)
    nodal = fem_beam.NodalBeam.from_scenario(scenario)
    K, M1 = (matrix.toarray()[first:, first:] for matrix in (nodal.K, nodal.M1))
    squares = eigh(K, M1, eigvals_only=True)
    if frame == "mean-axis":
        assert abs(squares[0]) < 1e-9 * squares[-1]  # the rigid rotation, which theta stands for
        squares = squares[1:]
    o = build_operators(scenario)
    count = modes or squares.size
    assert o.size == count
    assert_allclose(o.natural_frequencies(), np.sqrt(squares[:count]), rtol=1e-8)


def test_reduced_operators_are_projections():
    for frame, radius in (("tangent", RADIUS), ("mean-axis", 0.0)):
        scenario = scenario_of(frame, "fem", radius=radius, elements=6, modes=4)
        nodal, o = fem_beam.NodalBeam.from_scenario(scenario), build_operators(scenario)
        V = eigenmodes(nodal, "clamped" if frame == "tangent" else "hinged", 4)
        for name in ("M1", "K", "C", "D", "contact_shortening"):
            projected = V.T @ getattr(nodal, name).toarray() @ V
            assert_allclose(getattr(o, name), projected, atol=1e-11 * np.abs(projected).max(), err_msg=name)
        assert_allclose(o.S, V.T @ nodal.S, atol=1e-12)
        assert_allclose(o.P, V.T @ nodal.P, atol=1e-12)
        node = int(np.argmin(np.abs(nodal.nodes - POINT)))
        assert_allclose(o.contact_shape, V[2 * node], atol=1e-12)
        assert_allclose(o.root_slope, V[1], atol=1e-12)
        assert_allclose(o.M1, M * LENGTH * np.eye(4), atol=1e-12)
        assert V[-2].min() > 0.0
        if frame == "mean-axis":
            assert_allclose(o.S, np.zeros(4), atol=1e-12)  # the gauge of the frame


def test_frequencies_keep_their_digits_on_fine_meshes():
    """256 elements: the discretization error is (beta h)^4/1440, the condition number of K is 1e10."""
    for frame, family in (("tangent", "clamped-free"), ("mean-axis", "hinged-free")):
        o = build_operators(scenario_of(frame, "fem", elements=256, modes=3, point=LENGTH))
        roots = Eigenfunctions(family, 3, LENGTH).roots
        exact = np.sqrt(EI / M) * (roots / LENGTH) ** 2 * (1.0 + (roots / 256) ** 4 / 1440)
        assert_allclose(o.natural_frequencies(), exact, rtol=5e-11)


OPERATORS = ("K", "C", "D", "S", "P", "contact_shape", "contact_shortening", "root_slope")


@pytest.mark.parametrize(("frame", "radius"), [("tangent", RADIUS), ("mean-axis", 0.0)])
def test_elements_approach_the_modes_like_h4(frame, radius):
    exact = build_operators(scenario_of(frame, radius=radius, point=0.65))
    counts = [8, 16, 32]
    errors = {name: [] for name in OPERATORS}
    for elements in counts:
        o = build_operators(scenario_of(frame, "fem", radius=radius, point=0.65, elements=elements))
        for name in OPERATORS:
            reference = getattr(exact, name)
            errors[name].append(np.abs(getattr(o, name) - reference).max() / (np.abs(reference).max() + 1.0))
    for name, values in errors.items():
        if (frame, name) in (("mean-axis", "S"), ("tangent", "root_slope")):  # zero, by the frame's gauge
            assert max(values) < 1e-12
            continue
        slopes = np.log2(np.array(values[:-1]) / values[1:])
        assert slopes[-1] > 3.8, (name, values)
        assert values[-1] < 1e-4, (name, values)
        if name == "K":
            assert slopes[-1] < 4.2, (name, values)


# Results along the beam -----------------------------------------------------------------------------------------


def motion_of(size, seed=2):
    rng = np.random.default_rng(seed)
    q, qd, qdd = 2e-2 * rng.normal(size=(2, size)), rng.normal(size=(2, size)), 50.0 * rng.normal(size=(2, size))
    q[:, 0], qd[:, 0] = [0.4, -1.0], [-3.0, 5.0]
    return Motion(np.zeros(2), q, qd, qdd, np.array([120.0, 30.0]), np.array([-25.0, 9.0]))


def beam_of(method, **changes):
    radius = changes.pop("radius", 0.0)
    scenario = scenario_of("tangent", method, radius=radius, modes=3, elements=4, **changes)
    return Beam(scenario, build_operators(scenario))


def field(beam, B, derivative):
    """x -> Phi^(k)(x) B from the source's shape functions at single points (themselves tested above)."""
    if beam.operators.method == "modal":
        shapes = Eigenfunctions("clamped-free", 3, LENGTH)
        return lambda x: float(shapes.derivative(np.array([x]), derivative)[0] @ B)
    nodal = fem_beam.NodalBeam.from_scenario(beam.scenario)
    v = eigenmodes(nodal, "clamped", 3) @ B
    return lambda x: float((nodal.evaluate(np.array([x]))[derivative] @ v)[0])


@pytest.mark.parametrize("method", ["modal", "fem"])
def test_fields_along_the_beam(method):
    beam = beam_of(method)
    motion = motion_of(4)
    fields, x = beam.fields(motion), beam.operators.stations.points
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
                assert fields.moment[sample, station] == pytest.approx(EI * curvature(at), rel=1e-9, abs=1e-8)
            bent = quad(lambda s: slope(s) ** 2, 0.0, at, points=inside, epsabs=1e-12)[0] if at else 0.0  # noqa: B023
            assert fields.ux[sample, station] == pytest.approx(-0.5 * bent, rel=1e-10, abs=1e-14)


@pytest.mark.parametrize("method", ["modal", "fem"])
@pytest.mark.parametrize(("kinetics", "radius"), [("first-order", RADIUS), ("full", 0.0), ("zeroth-order", 0.0)])
def test_axial_force_is_the_reaction_of_the_accelerated_outer_part(method, kinetics, radius):
    """N(x) = F_a [x <= x_F] - int_x^L m (a_a + g sin theta) dxi, with a double quadrature of its own."""
    beam = beam_of(method, radius=radius, discretization__kinetics=kinetics)
    motion = motion_of(4)
    force = beam.fields(motion).axial_force
    x = beam.operators.stations.points
    kept = 0.0 if kinetics == "zeroth-order" else 1.0
    nodes, weights = np.polynomial.legendre.leggauss(12)
    edges = np.union1d(x, fem_beam.NodalBeam.from_scenario(beam.scenario).nodes if method == "fem" else x)
    edges = edges[np.append(True, np.diff(edges) > 1e-12)]
    shapes = [field(beam, row, k) for row in np.eye(3) for k in (0, 1)]

    def gauss(a, b):
        return 0.5 * (a + b) + 0.5 * (b - a) * nodes, 0.5 * (b - a) * weights

    panels = [gauss(a, b) for a, b in itertools.pairwise(edges)]
    s, w = np.concatenate([p for p, _ in panels]), np.concatenate([v for _, v in panels])
    values = np.array([[f(at) for f in shapes[0::2]] for at in s])
    slopes = np.array([[f(at) for f in shapes[1::2]] for at in s])
    for sample in range(2):
        (theta, *B), (spin, *Bd), (spin_rate, *Bdd) = motion.q[sample], motion.qd[sample], motion.qdd[sample]
        d, dd, ddd = slopes @ B, slopes @ Bd, slopes @ Bdd
        # u_x and u_x'' at every point: integrals from the root, panel by panel with a 12-point inner rule
        inner = [
            np.array([inner_integral(f, s, w, i, panels) for i in range(s.size)]) for f in (d * d, dd**2 + d * ddd)
        ]
        ux, ux_acceleration = -0.5 * kept * inner[0], -kept * inner[1]
        axial = ux_acceleration - spin_rate * (values @ B) - 2.0 * spin * (values @ Bd)
        axial -= spin**2 * (radius + s + ux)
        angle = theta - beam.scenario.slope.angle
        push = motion.normal_force[sample] * np.sin(angle) + motion.tangential_force[sample] * np.cos(angle)
        for station, at in enumerate(x):
            outer = s > at
            reaction = -M * w[outer] @ (axial[outer] + 9.8 * np.sin(theta))
            expected = reaction + (push if at <= POINT + 1e-12 else 0.0)
            assert force[sample, station] == pytest.approx(expected, rel=1e-8, abs=1e-7)


def inner_integral(f, s, w, i, panels):
    """Integral of f, given at the Gauss points, from the root to point i: polynomial through its panel."""
    size = panels[0][0].size
    start = i // size * size
    points, values = s[start : start + size], f[start : start + size]
    centre, half = 0.5 * (points[0] + points[-1]), 0.5 * (points[-1] - points[0])
    whole = Polynomial(np.polynomial.polynomial.polyfit((points - centre) / half, values, size - 1)).integ()
    reach = w[start : start + size].sum() / 2.0
    return w[:start] @ f[:start] + half * (whole((s[i] - centre) / half) - whole(-reach / half))


def test_cumulative_integral_is_exact_for_polynomials_of_the_panels():
    table = beam_of("fem").operators.stations.quadrature
    p = Polynomial([0.2, -1.0, 0.5, 3.0, -2.0, 1.0])
    assert_allclose(cumulative(table, p(table.points)), p.integ()(table.points), atol=1e-14)
    both = np.stack([p(table.points), table.points], axis=1)
    assert_allclose(cumulative(table, both)[:, 1], 0.5 * table.points**2, atol=1e-15)


# The spinning beam and the registry -----------------------------------------------------------------------------


def test_spectra_of_both_discretizations_agree():
    for root in ({}, {"root__kind": "driven", "root__hub_radius": RADIUS}):
        scenario = Scenario().replace(contact__enabled=False, discretization__elements=48, **root)
        analytic, elements = modal.spectrum(scenario), fem_beam.spectrum(scenario)
        for spin in (0.0, 40.0):
            assert_allclose(elements.flapwise(spin, 4), analytic.flapwise(spin, 4), rtol=2e-6, atol=1e-6)
            assert_allclose(elements.chordwise(spin, 4), analytic.chordwise(spin, 4), rtol=2e-6, atol=1e-6)
        hinged = not root
        assert (analytic.flapwise(40.0, 4)[0] == 40.0) == hinged
        assert (analytic.chordwise(40.0, 4)[0] == 0.0) == hinged


def test_unknown_discretization_is_refused_by_name():
    with pytest.raises(InputError, match=r"discretization\.method = 'splines'.*fem.*modal"):
        Scenario().replace(discretization__method="splines")

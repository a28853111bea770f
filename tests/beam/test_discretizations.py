"""Operators of both discretizations: definitions by textbook functions, orders, digits, reduction, cache."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from oblique_impact import Scenario, modal, natural_frequencies
from oblique_impact.beam.operators import build_operators
from oblique_impact.fem_beam import reduction

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


# Reduction ------------------------------------------------------------------------------------------------------


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


# The spinning beam and the registry -----------------------------------------------------------------------------


@pytest.mark.parametrize(("modes", "count"), [(2, 4), (6, 6)])
def test_as_many_frequencies_as_modes_but_four_at_least(modes, count):
    found = natural_frequencies(Scenario.builtin("paper", [f"discretization.modes={modes}"]))
    assert found.flapwise.shape == found.chordwise.shape == (1, count)


@pytest.mark.parametrize("frame", ["tangent", "mean-axis"])
def test_few_modes_of_a_large_mesh_are_those_of_the_whole_decomposition(frame, monkeypatch):
    """Shift-invert Lanczos against the singular vectors: frequencies to 2e-10, shapes to the root of that."""
    scenario = Scenario.builtin("paper").replace(
        discretization__method="fem",
        discretization__frame=frame,
        discretization__elements=128,
        discretization__modes=16,
    )
    quick = reduction.build_operators(scenario)
    monkeypatch.setattr(reduction, "_LARGE", 10**9)
    whole = reduction.build_operators(scenario)
    assert_allclose(quick.natural_frequencies(), whole.natural_frequencies(), rtol=2e-10)
    assert_allclose(quick.contact_shape, whole.contact_shape, atol=2e-8 * np.abs(whole.contact_shape).max())
    again = reduction.build_operators(scenario.replace(end_time=0.5))
    np.testing.assert_array_equal(again.K, whole.K)


@pytest.mark.parametrize(
    "change",
    [
        {"contact__point": 0.6},
        {"root__hub_radius": 0.2, "root__kind": "hub"},
        {"beam__density": 3000.0},
        {"discretization__modes": 3},
    ],
)
def test_operators_are_kept_for_equal_beams_alone(change):
    """Runs that differ in friction or slope share them, read-only; each of these differs in the beam at rest."""
    base = Scenario.builtin("paper").replace(discretization__frame="tangent")
    operators = build_operators(base)
    assert build_operators(base.replace(contact__mu_kinetic=0.1, slope__angle=0.2)) is operators
    with pytest.raises(ValueError, match="read-only"):
        operators.M1[0, 0] = 0.0
    other, kept = base.replace(**change), build_operators(base.replace(**change))
    fresh = modal.build_operators(other)
    for name in ("M1", "S", "P", "contact_shape"):
        np.testing.assert_array_equal(getattr(kept, name), getattr(fresh, name))

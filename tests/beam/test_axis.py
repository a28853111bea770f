"""The axis at any place, and a fixed point that touches it: against shape functions, geometry and differences."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import Scenario
from oblique_impact.beam.axis import AxisShapes, ShapeFunctions, fit_shapes, meet, place_of, place_record
from oblique_impact.beam.floating_frame import take_moving_rows
from oblique_impact.beam.hermite import HermiteShapes
from oblique_impact.contact.sides_and_pegs import heading_of, take_rows
from oblique_impact.contact.state import Candidate
from oblique_impact.fem_beam.nodal import NodalBeam
from oblique_impact.fem_beam.reduction import eigenmodes
from oblique_impact.kernels.workspace import SCRATCH_A, SCRATCH_B, SHORTENING_PRODUCT, VECTORS, Array
from oblique_impact.modal.eigenfunctions import Eigenfunctions

MODES = 6


def _modal() -> AxisShapes:
    shapes = Eigenfunctions("hinged-free", MODES, 1.0)
    return ShapeFunctions.smooth(shapes.derivative, 1.0, float(shapes.roots[-1])).fitted()


def _elements() -> AxisShapes:
    case = Scenario.builtin("tapered", [f"discretization.modes={MODES}", "discretization.elements=9"])
    nodal = NodalBeam.from_scenario(case)
    modes = eigenmodes(nodal, "hinged", MODES)
    return fit_shapes(lambda x: nodal.evaluate(x)[0] @ modes, nodal.nodes, 3)


def _nodes() -> HermiteShapes:
    """Return the nodes of a mesh, of which two elements have as many values as there are modes."""
    return HermiteShapes.on(np.array([0.0, 0.4, 1.0]))


@pytest.fixture(params=[_modal, _elements, _nodes], ids=["modes", "modes of elements", "all nodes"])
def shapes(request: pytest.FixtureRequest) -> AxisShapes | HermiteShapes:
    return request.param()


@pytest.mark.parametrize("x", [0.0, 0.2, 0.5, 0.9, 1.0, 1.1])
def test_axis_of_all_nodes_is_that_of_shape_functions_of_the_mesh(x: float) -> None:
    nodal = NodalBeam.from_scenario(Scenario.builtin("tapered", ["discretization.elements=9"]))
    rng = np.random.default_rng(2)
    B, Bd = 0.01 * rng.standard_normal((2, nodal.basis.N))
    wanted = fit_shapes(lambda x: nodal.evaluate(x)[0].toarray(), nodal.nodes, 3)
    found, kept = HermiteShapes.on(nodal.nodes), np.zeros((2, VECTORS, nodal.basis.N + 1))
    found.bend(B, Bd)
    axes = [shapes.bent_axis(x, B) for shapes in (found, wanted)]
    np.testing.assert_allclose(axes[0], axes[1], rtol=1e-11, atol=1e-14)
    for s, axis, v in zip((found, wanted), axes, kept, strict=True):
        s.take_shapes(axis, B, v)
    motions = [np.hstack(s.motion_at(a, B, Bd)) for s, a in zip((found, wanted), axes, strict=True)]
    np.testing.assert_allclose(motions[0], motions[1], rtol=1e-11, atol=1e-14)
    for row in (SCRATCH_A, SCRATCH_B, SHORTENING_PRODUCT):
        a, b = kept[:, row, 1:]
        np.testing.assert_allclose(a, b, rtol=1e-10, atol=1e-13)


def _bent(rng: np.random.Generator) -> Array:
    """Deflections of some centimetres, higher modes smaller."""
    return 0.03 * rng.standard_normal(MODES) / np.arange(1, MODES + 1) ** 2


def test_axis_of_eigenfunctions_is_theirs() -> None:
    modes = Eigenfunctions("hinged-free", 16, 1.0)
    table = ShapeFunctions.smooth(modes.derivative, 1.0, float(modes.roots[-1])).fitted()
    B, rng = np.zeros(16), np.random.default_rng(1)
    B[:] = 0.01 * rng.standard_normal(16) / np.arange(1, 17) ** 2
    z, w = np.polynomial.legendre.leggauss(80)
    for x in rng.uniform(0.0, 1.0, 20):
        axis = table.bent_axis(x, B)
        found = axis.u_y, axis.slope, axis.curvature
        for k in range(3):
            assert found[k] == pytest.approx(float(modes.derivative(np.array([x]), k)[0] @ B), abs=1e-13 * 100**k)
        slopes = modes.derivative(0.5 * x * (z + 1.0), 1) @ B
        assert axis.u_x == pytest.approx(-0.25 * x * float(w @ slopes**2), abs=1e-13)


@pytest.mark.parametrize("lever", [0.0, 0.012])
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("where", [0.5, 1.3], ids=["on", "past the tip"])
@pytest.mark.parametrize("kept", [1.0, 0.0], ids=["shortened", "not shortened"])
def test_rows_and_accelerations_are_derivatives(
    shapes: AxisShapes | HermiteShapes, where: float, side: float, lever: float, kept: float
) -> None:
    """Rates of gap and slip are differences in time of the gap; their own rates too."""
    rng = np.random.default_rng(3)
    peg = place_record(False, (where, 0.06, 0.005 + lever, lever, side, 0.0), kept)
    position = np.concatenate([[0.15], _bent(rng)])
    velocity = np.concatenate([[1.5], 20.0 * _bent(rng)])
    acceleration = np.concatenate([[3.0], 400.0 * _bent(rng)])
    v, k, rows = np.zeros((VECTORS, MODES + 1)), Candidate(), np.zeros((2, MODES + 1))

    def at(t: float) -> tuple[Array, Array, Array]:
        """Gap and slip, their rates, their accelerations."""
        q, qd = position + t * velocity + 0.5 * t * t * acceleration, velocity + t * acceleration
        shapes.bend(q[1:], qd[1:])
        met = meet(shapes, 0.05, peg, q, qd, heading_of(q[0]), k)
        take_moving_rows(shapes, peg, met, q[1:], v)
        take_rows(met.directions, v, rows)
        np.testing.assert_allclose(rows @ qd, [k.gap_rate, k.slip_rate], rtol=1e-11, atol=1e-13)
        return np.array([k.gap, k.slip]), rows @ qd, rows @ acceleration + [k.gap_bias, k.slip_bias]

    def difference(which: int, h: float = 2e-4) -> Array:
        """Derivative at t = 0, of fourth order in h."""
        values = {n: at(n * h)[which] for n in (-2, -1, 1, 2)}
        return (8.0 * (values[1] - values[-1]) - (values[2] - values[-2])) / (12.0 * h)

    assert at(0.0)[1][0] == pytest.approx(difference(0)[0], rel=1e-9, abs=1e-10)
    np.testing.assert_allclose(at(0.0)[2], difference(1), rtol=1e-7, atol=1e-7)
    assert np.all(np.abs(at(0.0)[1]) > 1e-4)  # which is far from rest


@pytest.mark.parametrize("bent", [1e-3, 0.1, 1.0, 10.0])
@pytest.mark.parametrize("kept", [1.0, 0.0], ids=["shortened", "not shortened"])
def test_the_place_of_a_peg_is_found_however_much_the_beam_is_bent(
    shapes: AxisShapes | HermiteShapes, bent: float, kept: float
) -> None:
    """There (r - c).r' = 0, on the beam or beyond its ends."""
    rng = np.random.default_rng(7)
    for _ in range(300):
        B, (X, Y) = bent * _bent(rng) / 0.02, rng.uniform((-0.5, -0.5), (1.6, 0.5))
        shapes.bend(B, B)
        x, axis = place_of(shapes, 0.05, kept, X, Y, B)
        steep = 1.0 - 0.5 * kept * axis.slope**2
        away = (0.05 + x + kept * axis.u_x - X) * steep + (axis.u_y - Y) * axis.slope
        steepness = abs(steep) + abs(axis.slope) + abs(axis.curvature)
        assert abs(away) < 1e-12 * (1.0 + steepness) ** 2

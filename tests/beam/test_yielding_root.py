"""A root that yields: the spring and dashpot of a clamp at a drive, and between a hub and the ground."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from numpy.testing import assert_allclose
from scipy.integrate import simpson
from scipy.interpolate import CubicHermiteSpline, make_interp_spline
from scipy.linalg import block_diag, eigh
from scipy.optimize import brentq

from oblique_impact import InputError, Scenario, frequencies_at_rest, natural_frequencies, simulate
from oblique_impact.beam.base_motion import BaseMotion
from oblique_impact.beam.beam import Beam
from oblique_impact.beam.floating_frame import DAMPING, ELASTIC_MASS, STIFFNESS
from oblique_impact.beam.frequencies import lowest_elastic_frequency
from oblique_impact.beam.operators import build_operators
from oblique_impact.beam.residual_flexibility import flexibility_along, residual_flexibility
from oblique_impact.beam.validity.limits import clamp_warnings, light_damping
from oblique_impact.contact.compliance import STATIC
from oblique_impact.fem_beam.nodal import NodalBeam
from oblique_impact.fem_beam.reduction import eigenmodes, project
from oblique_impact.modal import clamped_free_roots, hinged_free_roots
from oblique_impact.modal.eigenfunctions import Eigenfunctions, hub_free_roots
from oblique_impact.validation.runs import unit_beam

BENDING = 68.952e9 * 7.85e-9  # N m^2, of the paper's beam of 1 m
CLAMP = "root.kind=driven initial.angular_velocity=0 root.stiffness=400 root.damping=0.3"
HUB = "root.kind=hub root.inertia=0.05 root.stiffness=400 root.damping=0.3"
FREE = "contact.enabled=false"


def paper(*keys):
    return Scenario.builtin("paper", " ".join(keys).split())


def unit(root, method="modal", elements=64, **discretization):
    """The beam of one on a root, in modes or elements."""
    mesh = {"elements": elements} if method == "fem" else {}
    return unit_beam(root, method=method, **mesh, **discretization)


# Frequencies and modes ------------------------------------------------------------------------------------------

STIFFNESSES = [1e-6, 1e-3, 0.3, 1.0, 30.0, 1e3, 1e6, 1e9]


def closed_form(stiffness, count):
    """Roots b of k (1 + cos b cosh b) = b (sin b cosh b - cos b sinh b), by power series where b is small."""

    def value(b):
        # sin b cosh b - cos b sinh b = 2 b^3/3 - 4 b^7/1260 + ...
        part = (
            np.sin(b) - np.cos(b) * np.tanh(b)
            if b > 0.05
            else 2.0 * b**3 / 3.0 * (1.0 - b**4 / 210.0) / np.cosh(b)
        )
        return b * part - stiffness * (np.cos(b) + 1.0 / np.cosh(b))

    edges = np.append(1e-4, clamped_free_roots(count))
    return np.array([brentq(value, *edges[k : k + 2], xtol=1e-16, rtol=1e-15) for k in range(count)])


@pytest.mark.parametrize("stiffness", STIFFNESSES)
def test_frequencies_are_those_of_the_secular_equation_from_soft_to_rigid(stiffness):
    roots = closed_form(stiffness, 6)
    scenario = unit({"kind": "driven", "stiffness": stiffness})
    assert_allclose(hub_free_roots(6, 0.0, spring=stiffness), roots, rtol=1e-13)
    assert_allclose(natural_frequencies(scenario, count=6).chordwise[0], roots**2, rtol=2e-13)
    assert_allclose(lowest_elastic_frequency(scenario), roots[0] ** 2, rtol=1e-9)
    # a hub without inertia on the same spring is the same beam; elements err by (b h)^4/1440
    for root in ("driven", "hub"):
        mesh = unit({"kind": root, "stiffness": stiffness}, "fem")
        found = natural_frequencies(mesh, count=6).chordwise[0]
        assert_allclose(found, roots**2 * (1.0 + (roots / 64) ** 4 / 1440), rtol=2e-8)


def test_the_limits_are_the_hinged_beam_with_a_swing_and_the_clamped_one():
    """At first order: the swing has k/J, other squares of frequencies k phi'(0)^2 more, or phi''(0)^2/k less."""
    soft, stiff = hub_free_roots(5, 0.0, spring=1e-7), hub_free_roots(5, 0.0, spring=1e7)
    hinged, clamped = hinged_free_roots(4), clamped_free_roots(5)
    assert soft[0] ** 4 == pytest.approx(3e-7, rel=1e-7)
    slopes = Eigenfunctions("hinged-free", 4, 1.0).derivative(np.zeros(1), 1)[0]
    assert_allclose(soft[1:] - hinged, 1e-7 * slopes**2 / (4.0 * hinged**3), rtol=2e-5)
    curvatures = Eigenfunctions("clamped-free", 5, 1.0).derivative(np.zeros(1), 2)[0]
    assert_allclose(clamped - stiff, 1e-7 * curvatures**2 / (4.0 * clamped**3), rtol=2e-6)


@pytest.mark.parametrize("stiffness", [1e-9, *STIFFNESSES])
@pytest.mark.parametrize(("inertia", "radius"), [(0.0, 0.0), (0.3, 0.0), (0.3, 0.4)])
def test_eigenfunctions_on_a_spring_are_orthonormal_and_meet_their_ends(stiffness, inertia, radius):
    shapes = Eigenfunctions("hub-free", 30, 1.0, inertia, radius, stiffness)
    nodes, weights = np.polynomial.legendre.leggauss(120)
    inside = [shapes.derivative(0.5 * (1.0 + nodes), order) for order in range(3)]
    root, tip = (np.array([shapes.derivative(np.array([x]), order)[0] for order in range(4)]) for x in (0.0, 1.0))
    turned = np.outer(root[1], root[1])
    mass = 0.5 * (inside[0].T * weights) @ inside[0] + inertia * turned
    bent = 0.5 * (inside[2].T * weights) @ inside[2] + stiffness * turned
    b = shapes.roots
    assert_allclose(mass, np.eye(30), atol=1e-12)
    assert_allclose(bent / np.outer(b, b) ** 2, np.eye(30), atol=1e-12)
    assert_allclose(root[0], radius * root[1], atol=1e-14)
    moment = (stiffness - inertia * b**4) * root[1]
    assert_allclose(root[2] - radius * root[3], moment, rtol=0.0, atol=1e-13 * b.max() ** 3)
    assert_allclose(tip[2:] / b**2, 0.0, atol=1e-11)
    assert np.all(tip[0] > 0.0)


def test_the_small_curvature_on_a_soft_spring_keeps_its_digits():
    """It is that of the moment k phi'(0) (1 - x)^2 (2 + x)/2, which balances the inertia of a rigid rotation."""
    shapes, x = Eigenfunctions("hub-free", 3, 1.0, spring=1e-9), np.linspace(0.0, 1.0, 9)
    expected = 1e-9 * np.sqrt(3.0) * 0.5 * (1.0 - x) ** 2 * (2.0 + x)
    assert_allclose(shapes.derivative(x, 2)[:, 0], expected, rtol=1e-8, atol=1e-22)


@pytest.mark.parametrize("method", ["modal", "fem"])
@pytest.mark.parametrize("stiffness", [1e-4, 5.0, 1e4])
def test_a_spinning_beam_on_a_clamp_that_yields(method, stiffness):
    """Against polynomials with plain integrals; the clamp is on a radius of 0.4, the spin rate 4."""
    radius, spin = 0.4, 4.0
    nodes, weights = np.polynomial.legendre.leggauss(30)
    x, w = 0.5 * (1.0 + nodes), 0.5 * weights
    legendre = [np.polynomial.Legendre.basis(k, domain=[0, 1]).convert(kind=Polynomial) for k in range(13)]
    u, slope, curvature = (np.array([(Polynomial([0, 1]) * p).deriv(k)(x) for p in legendre]) for k in range(3))
    root = np.array([p(0.0) for p in legendre])
    mass, tension = (u * w) @ u.T, radius * (1.0 - x) + 0.5 * (1.0 - x**2)
    stiff = (curvature * w) @ curvature.T + stiffness * np.outer(root, root)
    stiff += spin**2 * ((slope * w * tension) @ slope.T - mass)
    expected = np.sqrt(eigh(stiff, mass, eigvals_only=True)[:4])
    scenario = unit({"kind": "driven", "stiffness": stiffness, "hub_radius": radius}, method)
    found = natural_frequencies(scenario, [spin], 4)
    assert_allclose(found.chordwise[0], expected, rtol=1e-7 if method == "modal" else 1e-5)
    assert_allclose(found.flapwise[0], np.hypot(found.chordwise[0], spin), rtol=1e-15)


@pytest.mark.parametrize("radius", [0.0, 0.3])
def test_a_hub_on_a_spring_has_all_its_modes_at_rest_and_does_not_spin(radius):
    for stiffness in (1e-6, 1.0, 1e6):
        hub = {"kind": "hub", "inertia": 0.02, "hub_radius": radius, "stiffness": stiffness}
        exact = hub_free_roots(5, 0.02, radius, stiffness) ** 2
        found = [natural_frequencies(unit(hub, method), count=5).chordwise[0] for method in ("modal", "fem")]
        assert_allclose(found[0], exact, rtol=1e-13)
        assert_allclose(found[1], exact, rtol=1.2 * exact[-1] ** 2 / 64**4 / 1440)
        assert lowest_elastic_frequency(unit(hub)) == pytest.approx(exact[0], rel=1e-8)
    with pytest.raises(InputError, match=r"^--speeds 0,6: should be 0: a hub on a spring, root\.stiffness"):
        natural_frequencies(unit(hub), [0.0, 6.0])


# Residual flexibility -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["modal", "fem"])
@pytest.mark.parametrize("stiffness", [0.1, 10.0, 1e5])
def test_residual_flexibility_is_that_of_the_modes_that_are_left_out(method, stiffness):
    """Four modes with it are 32 modes with theirs, of deflections and rotations, and between two places."""
    clamp = {"kind": "driven", "stiffness": stiffness}
    few, many = (build_operators(unit(clamp, method, modes=modes)) for modes in (4, 32))
    for place in (0.3, 0.77, 1.0):
        shapes = np.stack(few.along.at(place)[:2])
        higher = np.stack(many.along.at(place)[:2])[:, 4:]
        added = higher @ np.linalg.solve(many.stiffness[4:, 4:], higher.T)
        found = residual_flexibility(few, True, place)
        whole = found + shapes @ np.linalg.solve(few.stiffness, shapes.T)
        assert_allclose(
            found - residual_flexibility(many, True, place), added, rtol=1e-7, atol=1e-13 * whole.max()
        )
        # of a cantilever on its clamp: a unit load turns the root by place/k
        assert whole[0, 0] == pytest.approx(place**3 / 3.0 + place**2 / stiffness, rel=1e-9)
        assert whole[0, 1] == pytest.approx(place**2 / 2.0 + place / stiffness, rel=1e-9)
        along = flexibility_along(few, True)
        assert between(along, place, place) == pytest.approx(found[0, 0], rel=1e-6)


def between(along, x, y):
    """Flexibility (m/N) between two places, x <= y, from the functions of places."""
    values = []
    for place in (x, y):
        panel = min(np.searchsorted(along.edges, place, side="right") - 1, len(along.edges) - 2)
        a, b = along.edges[panel : panel + 2]
        z = (2.0 * place - a - b) / (b - a)
        values.append(np.polynomial.polynomial.polyval(z, along.coefficients[panel]))
    (a0, a1, a2), others = values[0][:STATIC], values[0][STATIC:] * values[1][STATIC:]
    return x * y * a0 - (x + y) * a1 + a2 + along.weights @ others


# Runs -----------------------------------------------------------------------------------------------------------


def root_turn(history, kind="driven"):
    """Angle of the spring (rad) and its rate, sample by sample."""
    slope = build_operators(history.scenario).root_slope
    turn = history["q"].values[:, 1:] @ slope, history["qd"].values[:, 1:] @ slope
    if kind == "hub":
        turn = (
            turn[0] + history["theta"].values - history.scenario.initial.angle,
            turn[1] + history["theta_dot"].values,
        )
    return turn


@pytest.mark.parametrize("method", ["modal", "fem"])
@pytest.mark.parametrize("kinetics", ["first-order", "full"])
def test_a_held_cantilever_falls_on_its_clamp(method, kinetics):
    """The dashpot takes int d phi'^2 dt, the spring is in the elastic energy, nothing is unaccounted for."""
    how = f"discretization.method={method} discretization.kinetics={kinetics} discretization.modes=4"
    history = simulate(paper(CLAMP, FREE, how, "initial.angle=0.2 end_time=0.2 solver.output_interval=1e-4"))
    energy, (phi, rate) = history.summary["energy"], root_turn(history)
    assert abs(energy["unaccounted"]) < 1e-10 * energy["elastic"]
    assert energy["lost_damping"] == pytest.approx(simpson(0.3 * rate**2, x=history["time"].values), rel=1e-6)
    assert energy["lost_damping"] > 0.1 * energy["elastic"]
    assert energy["supplied"] == 0.0
    o = build_operators(history.scenario)
    B = history["q"].values[:, 1:]
    expected = 0.5 * (B * (B @ o.K)).sum(axis=1) + 0.5 * 400.0 * phi**2
    assert_allclose(history["energy_elastic"].values, expected, rtol=0.0, atol=1e-13 * expected.max())


class WholeMesh:
    """A mesh in all of its modes, one more than a scenario takes: a rigid rotation about the root is in them."""

    def build_operators(self, scenario):
        nodal = NodalBeam.from_scenario(scenario)
        return project(nodal, eigenmodes(nodal, "yielding", None))


DAMPINGS = ["", "beam.kelvin_voigt=1e-4", "beam.mass_proportional=20", "beam.modal_damping_ratio=0.02"]


@pytest.mark.parametrize("damping", DAMPINGS)
def test_the_bending_moment_at_the_root_is_that_of_spring_and_dashpot(damping):
    small = "gravity=1e-3 discretization.method=fem discretization.elements=4 end_time=0.05"
    scenario = paper(CLAMP, FREE, damping, small)
    history = simulate(scenario, discretization=WholeMesh())
    slope = WholeMesh().build_operators(scenario).root_slope
    expected = history["q"].values[:, 1:] @ slope * 400.0 + history["qd"].values[:, 1:] @ slope * 0.3
    moment = history.section_forces()["moment"].values[:, 0]
    assert_allclose(moment, expected, rtol=0.0, atol=1e-7 * np.abs(moment).max())


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("frame", ["tangent", "mean-axis"])
def test_the_moments_on_a_hub_balance(frame, damping):
    """J_h phi'' = M - k phi - d phi', and damping by mass and by mode has its share in the hub."""
    keys = f"discretization.frame={frame} discretization.modes=8 gravity=1e-3 initial.angular_velocity=1e-3"
    scenario = paper(HUB, FREE, keys, damping, "end_time=0.02 solver.output_interval=1e-5")
    history = simulate(scenario)
    beam = Beam(scenario, build_operators(scenario))
    slope = np.append(1.0, beam.operators.root_slope)
    phi, rate = root_turn(history, "hub")
    given = -400.0 * phi - 0.3 * rate
    if "modal" in damping:
        given -= 0.05 * slope @ beam.slowed_on_spring(history["qd"].values[:, 0], history["qd"].values[:, 1:].T)
    if "mass" in damping:  # the swing is not damped: beam and hub have no moment together
        slowed = 20.0 * history["qd"].values[:, 1:].T
        given -= 0.05 * (slope[1:] - beam.operators.coupling / beam.operators.inertia) @ slowed
    moment = history.section_forces()["moment"].values[:, 0]
    turning = make_interp_spline(history["time"].values, rate, k=5).derivative()(history["time"].values)
    assert_allclose(
        0.05 * turning - given,
        moment,
        rtol=0.0,
        atol=(2e-5 if frame == "tangent" else 3e-4) * np.abs(moment).max(),
    )


def test_a_stiff_beam_on_a_hub_with_a_spring_is_an_oscillator():
    """(J + J_h) x'' + d x' + k x = 0, to the bending that is left, k L/(E I) = 7e-6."""
    keys = "gravity=0 beam.youngs_modulus=6.8952e15 discretization.modes=1 initial.angle=0.3"
    history = simulate(paper(HUB, FREE, keys, "initial.angular_velocity=2 end_time=0.3"))
    inertia, t = 0.05 + 2766.7 * 3.14e-4 / 3.0, history["time"].values
    decay = 0.5 * 0.3 / inertia
    frequency = np.sqrt(400.0 / inertia - decay**2)
    expected = 0.3 + 2.0 / frequency * np.exp(-decay * t) * np.sin(frequency * t)
    assert_allclose(history["theta"].values, expected, rtol=0.0, atol=1e-5 * 2.0 / frequency)
    energy = history.summary["energy"]
    assert abs(energy["unaccounted"]) < 1e-10 * energy["initial"]


@pytest.mark.parametrize("frame", ["tangent", "mean-axis"])
def test_each_mode_on_the_spring_of_a_hub_has_the_ratio_that_is_given(frame):
    """Also the lowest, whose beam hardly bends; decay rates from the matrices that the kernel reads."""
    keys = f"discretization.frame={frame} discretization.modes=6 root.damping=0 beam.modal_damping_ratio=0.03"
    scenario = paper(HUB, FREE, keys)
    beam = Beam(scenario, build_operators(scenario))
    model, o = beam.model, beam.operators
    mass = np.block(
        [[np.array([[o.inertia]]), o.coupling[None]], [o.coupling[:, None], model.matrices[ELASTIC_MASS]]]
    )
    stiffness, damping = (
        block_diag(0.0, model.matrices[which]) + part
        for which, part in ((STIFFNESS, model.ground.stiffness), (DAMPING, model.ground.damping))
    )
    squares, modes = eigh(stiffness, mass)
    assert_allclose(modes.T @ damping @ modes, np.diag(0.06 * np.sqrt(squares)), atol=1e-9 * np.sqrt(squares[-1]))
    # a hub that is seen from its tangent has clamped modes: those on the spring tend to the exact ones
    length = 0.05 / (2766.7 * 3.14e-4)
    exact = hub_free_roots(2, length, spring=400.0 / BENDING) ** 2 * np.sqrt(BENDING / (2766.7 * 3.14e-4))
    assert_allclose(np.sqrt(squares[:2]), exact, rtol=1e-4)


def test_damping_by_mode_at_a_clamp_is_that_of_the_modes_on_it():
    scenario = paper(CLAMP, FREE, "root.damping=0 beam.modal_damping_ratio=0.03 discretization.modes=5")
    model = Beam(scenario, build_operators(scenario)).model
    squares, modes = eigh(model.matrices[STIFFNESS], model.matrices[ELASTIC_MASS])
    assert_allclose(
        modes.T @ model.matrices[DAMPING] @ modes, np.diag(0.06 * np.sqrt(squares)), atol=1e-9 * squares[-1] ** 0.5
    )
    roots = hub_free_roots(5, 0.0, spring=400.0 / BENDING)
    assert_allclose(np.sqrt(squares), roots**2 * np.sqrt(BENDING / (2766.7 * 3.14e-4)), rtol=1e-12)


def test_a_spin_up_on_a_stiff_clamp_tends_to_that_on_a_rigid_one():
    """At first order in 1/k, and the work of the drive closes the balance."""
    spin_up = (
        "root.kind=driven initial.angular_velocity=0 root.profile=spin-up root.spin_rate=6 root.spin_up_time=0.2"
    )
    keys = f"{FREE} {spin_up} root.hub_radius=0.1 gravity=0 discretization.modes=4 end_time=0.3"
    tips = {}
    for stiffness in (0.0, 1e5, 1e6):
        history = simulate(paper(keys, f"root.stiffness={stiffness}"))
        energy = history.summary["energy"]
        assert abs(energy["unaccounted"]) < 1e-10 * energy["final"]
        assert energy["supplied"] > 0.9 * energy["final"]
        tips[stiffness] = history["uy"].values[:, -1]
    errors = [np.abs(tips[k] - tips[0.0]).max() for k in (1e5, 1e6)]
    assert errors[0] < 0.03 * np.abs(tips[0.0]).max()
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.15)


@dataclass(frozen=True)
class Swing(BaseMotion):
    """A drive of one's own, back and forth."""

    amplitude: float = 0.1
    rate: float = 30.0

    @staticmethod
    def turn(t, amplitude, rate):
        w = amplitude * rate
        return amplitude * (1.0 - math.cos(rate * t)), w * math.sin(rate * t), w * rate * math.cos(rate * t)


def test_a_drive_of_ones_own_works_through_its_clamp():
    """The dashpot takes what the drive supplies; the frame is where the drive is."""
    history = simulate(paper(CLAMP, FREE, "end_time=0.3"), base_motion=Swing())
    assert abs(history.balance["unaccounted"]) < 1e-10 * history.balance["supplied"]
    assert history.balance["lost_damping"] > 0.05 * history.balance["supplied"] > 0.0
    angle = math.pi / 4 + 0.1 * (1.0 - np.cos(30.0 * history["time"].values))
    assert_allclose(history["theta"].values, angle, atol=1e-8)


def test_a_drive_of_ones_own_turns_all_nodes(interpreted):
    """By mid-point steps of 0.1 ms, whose drive errs by their square."""
    nodes = (
        "discretization.method=fem discretization.modes=0 discretization.elements=3 solver.scheme=time-stepping"
    )
    keys = CLAMP, FREE, nodes, "solver.free_step=1e-4 end_time=0.01"
    history = simulate(paper(*keys), base_motion=Swing())
    angle = math.pi / 4 + 0.1 * (1.0 - np.cos(30.0 * history["time"].values))
    assert_allclose(history["theta"].values, angle, atol=1e-7)
    assert abs(history.balance["unaccounted"]) < 1e-7 * history.balance["supplied"]
    assert history.balance["supplied"] > 0.0


def regular(history):
    """Coordinates at multiples of 1 ms: fixed steps take samples beside them."""
    times, rows = np.unique(history["time"].values, return_index=True)
    q, qd = (history[name].values[rows] for name in ("q", "qd"))
    return CubicHermiteSpline(times, q, qd)(1e-3 * np.arange(60))


SCHEMES = {
    "fixed-step": ("solver.free_step=1e-5 solver.contact_step=1e-5", 3e-5),
    "generalized-alpha": ("solver.free_step=2e-5 solver.contact_step=2e-5", 3e-4),
    "time-stepping": ("solver.free_step=2e-5 solver.contact_step=2e-5", 3e-4),
}


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("root", [CLAMP, HUB, f"{HUB} beam.modal_damping_ratio=0.02"])
def test_each_scheme_agrees_with_the_event_scheme(scheme, root):
    """Up to the end of free motion and of a first contact with an elastic stop."""
    stop = "contact.normal=spring contact.stiffness=1e5 contact.friction=frictionless slope.origin=[0.6,-0.01]"
    keys = f"{root} {stop} slope.angle=0 initial.angle=0 gravity=40 end_time=0.06 solver.output_interval=1e-3"
    steps, bound = SCHEMES[scheme]
    event = simulate(paper(keys))
    other = simulate(paper(keys, f"solver.scheme={scheme} {steps}"))
    assert len(event.contacts) >= 1
    found, expected = (regular(history) for history in (other, event))
    assert_allclose(found, expected, rtol=0.0, atol=bound * np.abs(expected).max())
    for history, part in ((event, 1e-10), (other, 1e-4)):
        energy = history.summary["energy"]
        assert abs(energy["unaccounted"]) < part * max(energy["elastic"], energy["lost_damping"])
        assert energy["lost_damping"] > 0.0


@pytest.mark.parametrize("root", [CLAMP, HUB, f"{HUB} discretization.frame=mean-axis"])
def test_few_modes_strike_like_many(root):
    """An elastic stop: contacts of 4 modes with the flexibility that they leave out are those of 16."""
    stop = "contact.normal=spring contact.stiffness=1e5 contact.friction=frictionless slope.origin=[0.6,-0.01]"
    keys = f"{root} {stop} slope.angle=0 initial.angle=0 gravity=40 end_time=0.06 beam.kelvin_voigt=1e-5"
    few, many = (simulate(paper(keys, f"discretization.modes={modes}")) for modes in (4, 16))
    assert len(few.contacts) == len(many.contacts) >= 1
    first = [[history.contacts[0].start, history.contacts[0].end] for history in (few, many)]
    assert_allclose(*first, rtol=0.0, atol=2e-5)
    assert abs(few.summary["energy"]["unaccounted"]) < 1e-9 * few.summary["energy"]["elastic"]


def test_long_steps_of_many_modes_follow_a_hub_on_its_spring():
    """Without a dashpot the normal modes are uncoupled, and the flight is one of exponential steps."""
    keys = f"{FREE} {HUB} root.damping=0 discretization.frame=mean-axis discretization.modes=24 end_time=1"
    fine, quick = (
        simulate(paper(keys, "initial.angle=0.3 solver.output_interval=2e-3", more))
        for more in ("solver.scheme=fixed-step solver.free_step=2e-6", "")
    )
    assert quick.summary["steps"] < 20_000
    assert_allclose(quick["theta"].values, fine["theta"].values, rtol=0.0, atol=1e-5)


# What follows ---------------------------------------------------------------------------------------------------


def test_light_damping_is_that_of_the_beam_without_its_spring():
    """A soft spring makes a slow mode that hardly bends the beam: it says nothing about its damping."""
    rigid = paper("root.kind=driven initial.angular_velocity=0")
    soft = rigid.replace(root__stiffness=1e-3)
    assert lowest_elastic_frequency(soft) < 0.1 * lowest_elastic_frequency(rigid)
    assert light_damping(soft) == light_damping(rigid)


def test_the_modal_method_and_elements_give_the_same_operators():
    clamp = {"kind": "driven", "stiffness": 2.0}
    exact, mesh = (build_operators(unit(clamp, method, modes=4)) for method in ("modal", "fem"))
    assert np.abs(exact.root_slope).min() > 0.1
    for name in ("M1", "K", "C", "D", "S", "P", "root_slope", "stiffness"):
        assert_allclose(getattr(mesh, name), getattr(exact, name), rtol=1e-4, atol=1e-4)
    # K is the bending of the beam alone
    assert_allclose(exact.stiffness - exact.K, 2.0 * np.outer(exact.root_slope, exact.root_slope), atol=1e-12)


@pytest.mark.parametrize("root", [CLAMP, HUB])
def test_a_run_cut_in_two_is_the_run_in_one_piece(root):
    """The spring of a hub is unstrained at the angle of the scenario, wherever a run begins."""
    scenario = paper(root, FREE, "initial.angle=0.3 end_time=0.04")
    whole, first = simulate(scenario), simulate(scenario.replace(end_time=0.02))
    second = simulate(scenario.replace(end_time=0.02), initial_state=first)
    for name in ("q", "qd"):
        size = np.abs(whole[name].values).max()
        assert_allclose(second[name].values[-1], whole[name].values[-1], rtol=0.0, atol=1e-9 * size)
    assert second.balance["initial"] == pytest.approx(first.balance["final"], abs=1e-12)
    assert first.balance["lost_damping"] + second.balance["lost_damping"] == pytest.approx(
        whole.balance["lost_damping"], rel=1e-8
    )


@pytest.mark.parametrize("root", [CLAMP, HUB])
@pytest.mark.parametrize("scheme", ["event", "time-stepping"])
def test_a_beam_on_its_clamp_strikes_pegs(root, scheme):
    """Contact anywhere on elastic pegs: few modes with what they leave out press on them like many."""
    pegs = "obstacles=[{kind='point',origin=[0.6,-0.01]},{kind='point',origin=[0.95,-0.02]}]"
    stops = f"contact.where=anywhere slope.enabled=false {pegs} contact.normal=spring contact.stiffness=1e5"
    keys = f"{root} {stops} contact.friction=frictionless initial.angle=0 gravity=40 end_time=0.05"
    steps = "solver.free_step=1e-5 solver.contact_step=1e-5" if scheme == "time-stepping" else ""
    few, many = (
        simulate(
            paper(keys, f"solver.scheme={scheme} {steps} beam.kelvin_voigt=1e-4 discretization.modes={modes}")
        )
        for modes in (4, 16)
    )
    peak = few["lambda_n"].values.max()
    assert peak > 10.0
    assert many["lambda_n"].values.max() == pytest.approx(peak, rel=0.02)
    for history in (few, many):
        assert abs(history.balance["unaccounted"]) < 1e-3 * history.balance["lost_damping"]


def first_damping(strip):
    """Damping ratio of the first vibration that oscillates."""
    return next(ratio for ratio in frequencies_at_rest(strip, 4).damping if ratio < 0.999)


@pytest.mark.parametrize("method", ["modal", "fem"])
def test_a_run_in_modes_tells_how_much_too_well_a_dashpot_in_the_clamp_damps(method):
    """All nodes have the damping of the strip in closed form (check `directions.clamp-dashpot`)."""
    resting = "base.acceleration=0", "base.frequency=0", "gravity=0", "contact.enabled=false", "root.stiffness=5.6"
    nodes = "discretization.method=fem", "discretization.modes=0"
    for damping, modes, warns in (
        (0.02, 8, False),
        (0.112, 8, True),
        (0.2, 4, True),
        (0.2, 8, True),
        (0.2, 30, True),
    ):
        keys = (*resting, f"root.damping={damping}")
        strip = Scenario.builtin(
            "shaken", [*keys, f"discretization.method={method}", f"discretization.modes={modes}"]
        )
        told, whole = clamp_warnings(strip), Scenario.builtin("shaken", [*keys, *nodes])
        assert bool(told) is warns
        assert clamp_warnings(whole) == []
        if told:
            percent = float(told[0].split("some ")[1].split(" %")[0])
            error = 100.0 * (first_damping(strip) / first_damping(whole) - 1.0)
            assert 0.5 < percent / error < 2.0
    history = simulate(strip.replace(end_time=1e-3))
    assert [line for line in history.summary["warnings"] if line.startswith("root.damping: with 30 modes")]

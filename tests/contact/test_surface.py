"""Contact at the beam's face in place of its axis: kinematics, balances, first touch, discretizations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from oblique_impact import InputError, Scenario, simulate
from oblique_impact.beam.beam import Beam
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.operators import build_operators
from oblique_impact.beam.residual_flexibility import static_flexibility
from oblique_impact.contact.compliance import across as of_rows
from oblique_impact.contact.compliance import locate
from oblique_impact.contact.forces import touched
from oblique_impact.modal import Eigenfunctions

FACE = {"contact__surface": "section", "contact__point": 0.8, "discretization__modes": 3}
ON_THE_FACE = 'contact.surface="section"'
HUB = {"root__kind": "hub", "root__inertia": 0.02, "root__hub_radius": 0.15}
CASES = {
    "zeroth-order": {"discretization__kinetics": "zeroth-order"},
    "first-order": {"discretization__frame": "mean-axis"},
    "full": {"discretization__kinetics": "full"},
    "hub radius": HUB,
    "without its shortening": {"contact__shortening": False},
    "from the other side": {"initial__angle": 3.0, "slope__origin": (0.0, -0.5)},
    "another fibre": {"beam__outer_fibre": 0.03},
}
DEPTH = np.sqrt(3.14e-4 / np.pi)  # m, of the paper's round beam: half of it


def place(scenario, q):
    """Place (2,) of the fibre, in the frame of the slope: r(x_F) and half the depth across the turned section."""
    family = "clamped-free" if scenario.discretization.frame == "tangent" else "hinged-free"
    shapes, point, B = Eigenfunctions(family, 3, 1.0), scenario.contact.point, q[1:]
    nodes, weights = np.polynomial.legendre.leggauss(40)
    phi = float(shapes.derivative(np.array([point]), 1)[0] @ B)
    second = float(scenario.discretization.kinetics != "zeroth-order")
    slopes = shapes.derivative(0.5 * point * (1.0 + nodes), 1) @ B
    shortening = 0.25 * point * (slopes**2 @ weights) * second * scenario.contact.shortening
    half = scenario.beam.outer_fibre or DEPTH
    below = -np.sign(np.cos(scenario.initial.angle - scenario.slope.angle)) * half
    x = scenario.root.hub_radius + point - shortening - below * phi
    y = float(shapes.derivative(np.array([point]), 0)[0] @ B) + below * (1.0 - 0.5 * second * phi**2)
    r = np.exp(1j * q[0]) * (x + 1j * y) - complex(*scenario.slope.origin)
    z = r * np.exp(-1j * scenario.slope.angle)
    return np.array([z.imag, z.real])


def moving(scenario, q, qd):
    """Return the place over the time since it was at q."""
    return lambda t: place(scenario, q + t * qd)


def derivatives(function, h):
    """First and second derivative at 0 by central differences of order 6 (Fornberg 1988)."""
    samples = [function(k * h) for k in range(-3, 4)]
    first = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60.0
    second = np.array([2, -27, 270, -490, 270, -27, 2]) / 180.0
    return (sum(w * s for w, s in zip(weights, samples, strict=True)) for weights in (first / h, second / h**2))


@pytest.mark.parametrize("name", CASES)
def test_gap_slip_rows_rates_and_biases_are_those_of_the_moving_fibre(name):
    scenario = Scenario().replace(**FACE | CASES[name])
    beam = Beam(scenario, build_operators(scenario))
    rng = np.random.default_rng(1)
    for _ in range(3):
        q, qd = 1e-2 * rng.normal(size=beam.size), rng.normal(size=beam.size)
        q[0], qd[0] = rng.uniform(-3.0, 3.0), rng.uniform(-6.0, 6.0)
        work = beam.model.new_workspace()
        e, *rows = touched(beam.model, 0, 0.0, q, qd, work)
        np.testing.assert_allclose([e.gap, e.slip], place(scenario, q), rtol=0.0, atol=1e-13)
        expected = np.array([next(derivatives(moving(scenario, q, unit), 1e-3)) for unit in np.eye(beam.size)]).T
        np.testing.assert_allclose(rows, expected, atol=1e-10)
        rates, accelerations = derivatives(moving(scenario, q, qd), 2e-3)
        np.testing.assert_allclose([e.gap_rate, e.slip_rate], rates, atol=1e-9)
        np.testing.assert_allclose([e.gap_bias, e.slip_bias], accelerations, rtol=1e-6, atol=1e-6)


def test_the_fibre_is_that_of_the_section_at_the_contact_point():
    taper = [[0.0, 0.04], [1.0, 0.01]]
    shaped = {"method": "fem", "frame": "mean-axis", "modes": 3}
    for beam, expected in (
        ({"section": {"shape": "rectangle", "width": 0.02, "height": taper}}, 0.5 * (0.04 - 0.03 * 0.8)),
        ({"outer_fibre": taper}, 0.04 - 0.03 * 0.8),
        ({"area": [[0.0, 4e-4], [1.0, 2e-4]]}, np.sqrt(2.4e-4 / np.pi)),
    ):
        contact = {"point": 0.8, "surface": "section"}
        scenario = Scenario.from_dict({"beam": beam, "contact": contact, "discretization": shaped})
        assert scenario.contact_fibre == pytest.approx(-expected, rel=1e-14)
        assert float(Sections.from_scenario(scenario).fibre_distance(0.8)) == pytest.approx(expected, rel=1e-14)
    assert Scenario().contact_fibre == 0.0


@pytest.mark.parametrize(
    "changes",
    [
        ("contact.friction='hybrid'",),
        ("contact.friction='hybrid'", "root.kind='hub'", "root.inertia=0.02", "root.hub_radius=0.1"),
        (
            "contact.normal='spring'",
            "contact.stiffness=1e5",
            "contact.residual_flexibility=false",  # which would slip where the coordinates do not
            "discretization.frame='mean-axis'",
        ),
        ("solver.scheme='fixed-step'", "solver.free_step=2e-5", "solver.contact_step=2e-6"),
    ],
    ids=" ".join,
)
def test_the_balance_of_energy_closes(run, changes):
    """The work of the contact force is that of its rows: friction turns the sections as well."""
    history = run("paper", ON_THE_FACE, "end_time=0.34", *changes)
    energy = history.summary["energy"]
    assert history.summary["macro_collisions"][0]["normal_impulse"] > 0.5
    # of RK4 the steps in flight leave 2e-9 J, on the axis too
    assert abs(energy["unaccounted"]) < (1e-8 if "fixed-step" in str(changes) else 1e-9)
    # the places that are kept are those of the fibre, and their velocities its derivatives
    slope = Scenario().slope
    z = (history["tip_x"].values + 1j * history["tip_y"].values - complex(*slope.origin)) * np.exp(
        -1j * slope.angle
    )
    np.testing.assert_allclose(z.imag, history["gap"].values, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(z.real, history["slip"].values, rtol=0.0, atol=1e-12)
    v = (history["tip_vx"].values + 1j * history["tip_vy"].values) * np.exp(-1j * slope.angle)
    np.testing.assert_allclose(v.imag, history["gap_rate"].values, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(v.real, history["slip_rate"].values, rtol=0.0, atol=1e-10)
    # the face that the clearance is measured from goes through the contact point
    assert np.all(history["clearance"].values <= history["gap"].values + 1e-12)


def test_a_rigid_beam_touches_when_its_face_does():
    """Pendulum: L sin(b) - c cos(b) = c_n at the first touch, b = theta - alpha; its time by the energy integral.

    A modulus a million times that of the paper's beam leaves 1e-9 rad of bending, and vibrations of some 1e-4 m/s.
    """
    scenario = Scenario().replace(contact__surface="section", beam__youngs_modulus=68.952e15, end_time=0.3146)
    event = simulate(scenario.replace(discretization__modes=1)).events[0]
    slope, start = scenario.slope, scenario.initial.angle
    height = slope.origin[1] * np.cos(slope.angle) - slope.origin[0] * np.sin(slope.angle)
    theta = slope.angle + np.arcsin(height / np.hypot(1.0, DEPTH)) + np.arctan(DEPTH)
    # theta'^2 = 3 (g/L) (sin(theta0) - sin(theta)); theta = theta0 - s^2 takes the root out of the integrand
    speed = lambda s: np.sqrt(3.0 * 9.8 * (np.sin(start) - np.sin(start - s * s)))  # noqa: E731
    time = quad(lambda s: 2.0 * s / speed(s), 0.0, np.sqrt(start - theta), epsabs=1e-13)[0]
    assert event.time == pytest.approx(time, abs=1e-8)
    angle = theta - slope.angle
    approach = speed(np.sqrt(start - theta)) * (np.cos(angle) + DEPTH * np.sin(angle))
    assert event.normal_velocity == pytest.approx(-approach, abs=2e-4)


def test_the_pin_carries_no_moment(run):
    """Equilibrium of the whole beam about its pin: the contact force has the lever of the fibre."""
    history = run(
        "paper", ON_THE_FACE, "discretization.kinetics='full'", "end_time=0.32", "contact.mu_kinetic=0.3"
    )
    closed = history["state"].values != 0
    force = np.abs(history["lambda_tau"].values[closed]).max()
    moment = history.section_forces()["moment"].values[closed]
    assert closed.sum() > 10
    assert force > 50.0
    assert np.abs(moment[:, 0]).max() < 1e-6 * force * DEPTH
    # the force at the fibre bends the beam up to its very end: half the depth times the part along the section
    angle = history["theta"].values[closed] - Scenario().slope.angle
    normal, tangential = (history[name].values[closed] for name in ("lambda_n", "lambda_tau"))
    angle += history["q"].values[closed, 1:] @ Eigenfunctions("clamped-free", 2, 1.0).derivative(np.ones(1), 1)[0]
    along = normal * np.sin(angle) + tangential * np.cos(angle)
    np.testing.assert_allclose(moment[:, -1], DEPTH * along, rtol=0.0, atol=1e-3 * force * DEPTH)


def test_what_the_modes_leave_out_adds_up_to_the_whole_flexibility():
    """Along the contact row, kept and left-out compliance are the same sum whatever the number of modes."""
    found = []
    for modes in (2, 5, 12):
        changes = {
            "contact__normal": "spring",
            "discretization__frame": "mean-axis",
            "discretization__modes": modes,
        }
        scenario = Scenario().replace(**FACE | changes)
        beam = Beam(scenario, build_operators(scenario))
        q = np.zeros(beam.size)
        q[0] = 1.3  # steep: the lever counts
        work = beam.model.new_workspace()
        across = touched(beam.model, 0, 0.0, q, 0.0 * q, work).normal[1:]
        locate(beam.compliance, 0, q[0])
        left_out = of_rows(beam.compliance, 0, 0, 0, 0)
        found.append(left_out + across @ np.linalg.solve(beam.operators.K, across))
    np.testing.assert_allclose(found, found[0], rtol=1e-9)
    # of a clamped beam with force and moment at x = a: a^3/3, a^2/2, a over E I (Roark, table 8.1)
    stiffness, a = 68.952e9 * 7.85e-9, 0.8
    flexibility = static_flexibility(Sections.from_scenario(Scenario()), a, clamped=True)
    np.testing.assert_allclose(flexibility * stiffness, [[a**3 / 3, a**2 / 2], [a**2 / 2, a]], rtol=1e-12)


def test_a_start_with_the_face_below_the_slope_is_refused():
    """The axis is above the line by less than half the depth."""
    angle = Scenario().slope.angle
    place = {"initial__angle": angle, "slope__origin": (0.0, -0.9 * DEPTH / np.cos(angle))}
    Scenario().replace(**place)
    with pytest.raises(InputError, match=r"^initial.angle = .*m below the slope"):
        Scenario().replace(**place, contact__surface="section")

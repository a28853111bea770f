"""What a discretization leaves out of the contact point, and a contact point without inertia."""

import numpy as np
import pytest

from oblique_impact import InputError, Outcome, Scenario, simulate
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.operators import build_operators
from oblique_impact.beam.residual_flexibility import residual_flexibility, static_flexibility
from oblique_impact.beam_problem import beam_of, beam_problem
from oblique_impact.contact.transitions import EventKind

MEAN_AXIS = "discretization.frame=mean-axis"
MASSLESS = (MEAN_AXIS, "contact.point_inertia=none", "beam.kelvin_voigt=1e-5", "solver.output_interval=1e-3")
NODAL = ("discretization.method=fem", "discretization.modes=0", "solver.free_step=1e-5")


def paper(*overrides):
    return Scenario.builtin("paper", overrides)


def sections(*overrides):
    return Sections.from_scenario(paper(*overrides))


@pytest.mark.parametrize("frame", ["tangent", "mean-axis"])
@pytest.mark.parametrize(
    "changes",
    [
        (),
        ("contact.point=0.6",),
        ("beam.tip_mass=0.3",),
        ("masses=[{place=0.4,mass=0.3,inertia=0.01},{mass=0.1,inertia=0.02}]",),
        ("beam.area=[[0, 4e-4], [0.4, 4e-4], [1, 1e-4]]", "beam.second_moment=[[0, 9e-9], [1, 3e-9]]"),
    ],
    ids=["uniform", "inside", "tip mass", "masses", "tapered"],
)
def test_compliance_is_that_of_all_modes_of_a_mesh(frame, changes):
    """Point loads on Hermite elements have exact nodal deflections; where sections vary, to the mesh's order."""
    mesh = ("discretization.method=fem", f"discretization.frame={frame}", "discretization.elements=32", *changes)
    operators = build_operators(paper(*mesh, "discretization.modes=64"))
    shape = operators.contact_shape
    of_modes = shape @ np.linalg.solve(operators.K, shape)
    whole = static_flexibility(operators.sections, operators.contact_point, clamped=frame == "tangent")[0, 0]
    assert of_modes == pytest.approx(whole, rel=1e-6)


@pytest.mark.parametrize(("modes", "stiffness"), [(8, 2.67e7), (16, 1.86e8), (32, 1.39e9), (64, 1.08e10)])
def test_residual_stiffness_of_the_paper(modes, stiffness):
    """What N modes leave out at the tip of the hinged beam is the sum over the higher ones."""
    operators = build_operators(paper(MEAN_AXIS, f"discretization.modes={modes}"))
    found = residual_flexibility(operators, clamped=False)[0, 0]
    assert 1.0 / found == pytest.approx(stiffness, rel=7e-3)
    s = operators.sections
    k = np.arange(modes + 1, 20_000)
    b = (k + 0.25) * np.pi  # roots of tan b = tanh b; phi(L)^2 = 4 for int phi^2 = L
    tail = np.sum(4.0 * s.length**3 / (float(s.bending_stiffness(0.0)) * b**4))
    assert found == pytest.approx(tail, rel=1e-4)


@pytest.mark.parametrize(("viscosity", "damping"), [(0.0, 0.0), (1e-5, 0.0), (0.0, 0.1), (0.0, 0.4)])
def test_the_force_of_a_spring_is_its_stiffness_times_the_variable_depth(viscosity, damping):
    """Whatever the modes leave out of the contact point, and however that or the stop is damped."""
    changes = (
        "contact.normal=spring",
        "contact.friction=frictionless",
        "end_time=0.335",
        "discretization.modes=4",
    )
    damped = (f"beam.kelvin_voigt={viscosity}", f"contact.damping={damping}")
    history = simulate(paper(*changes, MEAN_AXIS, *damped))
    force, depth, rate = (history[name].values for name in ("lambda_n", "depth", "gap_rate"))
    behind, slope = beam_of(history.scenario).compliance, history.scenario.slope.angle
    compliance = behind.flexibility(0, 1.0, 0, 1.0) * np.cos(history["theta"].values - slope) ** 2
    share = 1.0 / (1.0 + 1e6 * compliance)  # the stop's of the depth at rest, and so of its rate
    expected = 1e6 * depth * (1.0 - damping * share * rate)
    np.testing.assert_allclose(force, expected, rtol=1e-12, atol=1e-9 * force.max())
    left = simulate(paper(*changes, "contact.residual_flexibility=false"))
    closed = left["state"].values > 0
    np.testing.assert_array_equal(left["depth"].values[closed], -np.minimum(left["gap"].values[closed], 0.0))
    assert np.max(simulate(paper("end_time=0.32"))["depth"].values) == 0.0  # a rigid stop


def test_an_elastic_stop_on_a_few_modes_is_that_on_many():
    """Sixteen modes: within 4e-6 s of the limit 0.865327(2) s of all modes, without flexibility 8e-4 s."""
    base = (MEAN_AXIS, "contact.normal=spring", "contact.friction=frictionless", "end_time=0.866")
    plain, known = (
        simulate(paper(*base, "discretization.modes=16", f"contact.residual_flexibility={word}", "end_time=0.866"))
        for word in ("false", "true")
    )
    starts = [h.summary["macro_collisions"][1]["start"] for h in (plain, known)]
    assert starts[0] == pytest.approx(0.86456, abs=1e-5)
    assert starts[1] == pytest.approx(0.865327, abs=4e-6)
    assert abs(known.summary["energy"]["unaccounted"]) < 1e-9


@pytest.mark.parametrize("scheme", ["event", "generalized-alpha"])
def test_friction_without_inertia(scheme):
    """The tip rests on the slope: it slips by the beam's axial velocity; energy balances.

    256 nodal elements with plastic impacts: end 0.3284988 s, impulse 1.814381 N s.
    """
    steps = () if scheme == "event" else ("solver.free_step=1e-5", "solver.contact_step=1e-6")
    history = simulate(
        paper(*MASSLESS, f"solver.scheme={scheme}", *steps, "discretization.modes=16", "end_time=0.34")
    )
    energy, (first,) = history.summary["energy"], history.summary["macro_collisions"]
    assert first["end"] == pytest.approx(0.3284988, abs=2e-5)
    assert first["normal_impulse"] == pytest.approx(1.814381, abs=2e-4)
    assert energy["lost_friction"] == pytest.approx(0.0212, abs=1e-3)
    assert abs(energy["unaccounted"]) < (1e-7 if scheme == "event" else 1e-4)
    touches = [event for event in history.events if event.kind is EventKind.IMPACT]
    assert abs(touches[0].tangential_velocity) < 0.01  # a rigid bar's would be -0.35 m/s


def test_nodal_end_without_inertia():
    """Translation and rotation, so mass, static moment and inertia, are kept; 16 elements reach 1.820515 N s."""
    scenario = paper(*MASSLESS, *NODAL, "contact.friction=frictionless", "discretization.elements=16")
    beam, whole = beam_of(scenario), beam_of(paper(*NODAL, MEAN_AXIS, "discretization.elements=16"))
    o, all_nodes = beam.operators, whole.operators
    assert o.size == all_nodes.size - 1
    assert o.rigid @ (o.M1 @ o.rigid) == pytest.approx(all_nodes.J, rel=1e-14)
    assert o.P @ o.rigid == pytest.approx(all_nodes.Sm, rel=1e-14)
    assert np.max(np.abs(o.K @ o.rigid)) < 1e-9 * abs(o.K).max()
    h = o.sections.length / 16
    assert 1.0 / o.left_out == pytest.approx(12.0 * float(o.sections.bending_stiffness(0.0)) / h**3, rel=1e-12)
    history = simulate(scenario.replace(end_time=0.335, solver__contact_step=5e-7, solver__output_interval=1e-3))
    (first,) = history.summary["macro_collisions"]
    assert first["normal_impulse"] == pytest.approx(1.820515, abs=4e-6)  # of second order in the step
    assert history.summary["energy"]["lost_impact"] == 0.0


def test_an_undamped_end_without_inertia_keeps_its_energy():
    """Nothing is lost, nothing jumps: the energy of the fall, 3.01004 J, and more than a dozen contacts."""
    changes = ("beam.kelvin_voigt=0", "solver.rho_infinity=1", "discretization.elements=16", "end_time=0.335")
    history = simulate(paper(*MASSLESS, *NODAL, *changes, "contact.friction=frictionless"))
    energy = history.summary["energy"]
    assert energy["final"] == pytest.approx(3.01004, abs=2e-5)
    assert abs(energy["lost_scheme"]) < 1e-10
    assert abs(energy["unaccounted"]) < 1e-5
    assert history.summary["macro_collisions"][0]["contacts"] > 12


def test_a_friction_that_no_force_can_push_ends_by_name():
    """cos beta + mu s sin beta <= 0, mu > cot |beta| = 10.7 at the first touch: no contact force exists."""
    friction = ("contact.mu_static=12", "contact.mu_kinetic=12")
    history = simulate(paper(*MASSLESS, *friction, "discretization.modes=8", "end_time=0.4"))
    assert history.outcome is Outcome.PAINLEVE


def test_a_discretization_that_leaves_nothing_out_is_refused():
    """All clamped shapes of a mesh bend exactly under a load at a node."""
    whole = ("discretization.method=fem", "discretization.elements=4", "discretization.modes=8")
    whole = (*whole, "discretization.frame=tangent")
    with pytest.raises(InputError, match=r"contact\.point_inertia"):
        beam_problem(beam_of(paper(*MASSLESS, *whole)))


def test_a_force_that_begins_with_a_jump_has_the_peak_of_its_samples():
    """A damped flexibility pushes at once; the slope of the force across the jump means nothing."""
    damped = ("contact.normal=spring", "beam.kelvin_voigt=1e-5", "solver.output_interval=1e-5", "end_time=0.335")
    history = simulate(paper(MEAN_AXIS, "discretization.modes=6", *damped))
    peak = max(m["peak_force"] for m in history.macro_collisions)
    assert peak == pytest.approx(float(history["lambda_n"].max()), rel=1e-3)

"""Generalized-alpha on beams: second order in position, velocity and impulse; energy; agreement of the models."""

import numpy as np
import pytest

from oblique_impact import Scenario, simulate

COMMON = ("contact.normal=spring", "contact.friction=frictionless", "discretization.frame=mean-axis")
MODELS = {
    "nodal": ("discretization.method=fem", "discretization.modes=0", "discretization.elements=2"),
    "modal": ("discretization.modes=4",),
    "tangent": ("discretization.modes=2", "discretization.frame=tangent"),
    "full": ("discretization.modes=3", "discretization.kinetics=full"),
}


def final(model, rho, step, *extra):
    """Position and velocity of the contact point at 0.3215 s, after the first contact, and its impulse."""
    history = simulate(
        Scenario.builtin(
            "paper",
            [
                *COMMON,
                *MODELS[model],
                "solver.scheme=generalized-alpha",
                f"solver.rho_infinity={rho}",
                f"solver.free_step={step}",
                f"solver.contact_step={step}",
                "end_time=0.3201",
                *extra,
            ],
        )
    )
    impulse = sum(c["normal_impulse"] for c in history.summary["macro_collisions"])
    return np.array([float(history["tip_y"][-1]), float(history["tip_vy"][-1]), impulse]), history


def exact(model):
    """The same by the event-located scheme of order 8 in all the model's coordinates."""
    # the event scheme marches the nodal mesh in all its modes
    modes = ("discretization.modes=4",) if model == "nodal" else ()
    history = simulate(
        Scenario.builtin("paper", [*COMMON, *MODELS[model], *modes, "solver.tolerance=1e-11", "end_time=0.3201"])
    )
    impulse = sum(c["normal_impulse"] for c in history.summary["macro_collisions"])
    return np.array([float(history["tip_y"][-1]), float(history["tip_vy"][-1]), impulse])


@pytest.mark.parametrize(
    ("model", "rho"),
    [("nodal", 0.0), ("nodal", 0.8), ("nodal", 1.0), ("modal", 0.8), ("tangent", 0.5), ("full", 0.8)],
)
def test_second_order_in_position_velocity_and_impulse(model, rho):
    reference = exact(model)
    errors = np.array([np.abs(final(model, rho, step)[0] - reference) for step in (8e-6, 4e-6, 2e-6)])
    slopes = np.log2(errors[:-1] / errors[1:])
    assert np.all(slopes > 1.7), (errors, slopes)
    assert np.all(slopes < 2.3), (errors, slopes)
    assert np.all(errors[-1] < [1e-7, 3e-3, 1e-4])


def free_flight(step, *extra):
    history = simulate(
        Scenario.builtin(
            "paper",
            [
                *MODELS["nodal"],
                "discretization.frame=mean-axis",
                "solver.scheme=generalized-alpha",
                "solver.rho_infinity=1.0",
                "contact.enabled=false",
                "end_time=0.3",
                f"solver.free_step={step}",
                *extra,
            ],
        )
    )
    total = sum(history[f"energy_{kind}"] for kind in ("kinetic", "elastic", "gravity")).values
    return np.abs(total - total[0]).max() / np.abs(total).max(), history.summary["energy"]


def test_without_dissipation_free_flight_conserves_energy():
    """rho_inf = 1: the algorithm takes nothing; without gravity only the iterations' tolerance is left."""
    change, energy = free_flight(1e-4, "gravity=0.0", "initial.angular_velocity=-5.0")
    assert change < 1e-10
    assert abs(energy["lost_scheme"]) < 1e-12


def test_gravity_is_sampled_to_second_order():
    """The trapezoidal rule does not integrate sin(theta) exactly: 1e-8 of the energy, with the step squared."""
    changes = [free_flight(step)[0] for step in (2e-4, 1e-4, 5e-5)]
    assert changes[-1] < 2e-9
    assert np.log2(np.array(changes[:-1]) / changes[1:]) == pytest.approx([2.0, 2.0], abs=0.1)
    assert abs(free_flight(1e-4)[1]["lost_scheme"]) < 1e-12


def test_dissipation_is_named_and_rises_as_rho_falls():
    losses = []
    for rho in (1.0, 0.8, 0.0):
        _, history = final("nodal", rho, 8e-6)
        energy = history.summary["energy"]
        losses.append(energy["lost_scheme"])
        assert abs(energy["unaccounted"]) < 2e-6
    assert abs(losses[0]) < 1e-12
    assert losses[0] < losses[1] < losses[2]


def test_nodal_and_many_modes_agree():
    """32 elements, 24 of their own modes and 24 analytic modes on an elastic stop: one collision."""
    results = {}
    for name, overrides in {
        "nodal": ("discretization.method=fem", "discretization.modes=0"),
        "reduced": ("discretization.method=fem", "discretization.modes=24"),
        "modal": ("discretization.modes=24",),
    }.items():
        history = simulate(
            Scenario.builtin(
                "paper",
                [
                    *COMMON,
                    *overrides,
                    "solver.scheme=generalized-alpha",
                    "solver.free_step=5e-6",
                    "solver.contact_step=2e-6",
                    "solver.rho_infinity=0.9",
                    "end_time=0.3325",
                ],
            )
        )
        collision = history.summary["macro_collisions"][0]
        results[name] = collision["normal_impulse"], collision["peak_force"], history.events[1].time
    for name in ("reduced", "modal"):
        assert results[name][0] == pytest.approx(results["nodal"][0], rel=2e-4)
        assert results[name][1] == pytest.approx(results["nodal"][1], rel=2e-3)
        assert results[name][2] == pytest.approx(results["nodal"][2], abs=1e-6)


@pytest.mark.parametrize(("elements", "grading"), [(512, 1.0), (128, 8.0)])
def test_rounding_of_fine_and_graded_meshes_does_not_reach_the_motion(elements, grading):
    """K x is zero, but its rounding grows like 1/h^3: taken from W it would hold the beam like a spring."""
    tips = []
    for overrides in ((64, 1.0), (elements, grading)):
        history = simulate(
            Scenario.builtin(
                "paper",
                [
                    "discretization.method=fem",
                    "discretization.modes=0",
                    "discretization.frame=mean-axis",
                    "solver.scheme=generalized-alpha",
                    "contact.enabled=false",
                    "end_time=0.3",
                    f"discretization.elements={overrides[0]}",
                    f"discretization.grading={overrides[1]}",
                ],
            )
        )
        assert history.outcome.exit_code == 0
        # gravity is sampled to second order: 1e-8 J at this step, on every mesh
        assert abs(history.summary["energy"]["unaccounted"]) < 1.5e-8
        tips.append(float(history["tip_y"][-1]))
    assert tips[1] == pytest.approx(tips[0], abs=2e-9)

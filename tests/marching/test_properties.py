"""Random sane scenarios: no crash, no energy lost to nowhere, never below the slope."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from oblique_impact import InputError, Outcome, Scenario, simulate

TOUCH = 1e-9  # m
STEPPED = 1e-6  # m, the square of a step of 1e-5 s times 1e4 m/s^2, which time-stepping leaves
LEDGER = 1e-8  # J
OUTCOMES = (  # a beam may come to rest where the two contact forces are redundant
    Outcome.COMPLETED,
    Outcome.PAINLEVE,
    Outcome.MASS_MATRIX_INDEFINITE,
    Outcome.REDUNDANT_CONSTRAINTS,
)


def pick(*values):
    return st.sampled_from(values)


@st.composite
def scenarios(draw):
    """Beams of any stiffness that fall or rise onto slopes of any angle, with every law of contact."""
    frame = draw(pick("tangent", "mean-axis"))
    friction = draw(pick(0.0, 0.1, 0.3, 0.8, 1.5))
    normal = draw(pick("rigid", "rigid", "spring"))
    sections = {
        "end_time": draw(st.floats(0.1, 0.5)),
        "gravity": draw(pick(0.0, 9.8, 20.0)),
        "beam": {
            "youngs_modulus": 10.0 ** draw(st.floats(9.5, 11.5)),
            "kelvin_voigt": draw(pick(0.0, 1e-5, 1e-4)),
            "mass_proportional": draw(pick(0.0, 1.0)),
            "modal_damping_ratio": draw(pick(0.0, 0.02)),
        },
        "initial": {"angle": draw(st.floats(-0.5, 1.5)), "angular_velocity": draw(st.floats(-8.0, 4.0))},
        "slope": {
            "origin": [draw(st.floats(-0.2, 0.8)), draw(st.floats(-0.8, 0.2))],
            "angle": draw(st.floats(-0.6, 1.2)),
        },
        "contact": {
            "point": draw(pick(1.0, 0.5, 0.8)),
            "restitution": draw(pick(0.0, 0.3, 0.8)) if normal == "rigid" else 0.0,
            "normal": normal,
            "stiffness": 10.0 ** draw(st.floats(4.0, 6.0)),
            "shortening": draw(st.booleans()),
            "friction": draw(pick("frictionless", "hybrid", "modified-coulomb")),
            "mu_kinetic": friction,
            "mu_static": friction * draw(pick(1.0, 1.3)),
        },
        "discretization": {
            "method": draw(pick("modal", "fem")),
            "frame": frame,
            "kinetics": draw(pick("first-order", "full")),
            "modes": draw(st.integers(1, 4)),
            "elements": 8,
        },
    }
    # keys that have no effect are not given
    contact, law = sections["contact"], sections["contact"]["friction"]
    idle = {"mu_kinetic", "mu_static"} if law == "frictionless" else {"mu_static"} if law != "hybrid" else set()
    idle.add("restitution" if normal == "spring" else "stiffness")
    sections["contact"] = {key: value for key, value in contact.items() if key not in idle}
    if sections["discretization"]["method"] == "modal":
        del sections["discretization"]["elements"]
    try:
        return Scenario.from_dict(sections)
    except InputError:  # starts below the slope
        kept = {"point": contact["point"], "shortening": contact["shortening"]}
        return Scenario.from_dict({**sections, "contact": {**kept, "enabled": False}})


def cone(contact):
    """The largest ratio of forces: only hybrid friction has a static coefficient."""
    largest = {"frictionless": 0.0, "hybrid": contact.mu_static, "modified-coulomb": contact.mu_kinetic}
    return largest[contact.friction]


def assert_sound(history, friction):
    """Nothing is later than the end, and all forces are in their cones, also on both sides of each event."""
    end = history.summary["end_time"]
    assert float(history["time"].values[-1]) == end
    assert all(event.time <= end for event in history.events)
    assert all(contact.start <= contact.end <= end for contact in history.contacts)
    normal, tangential = (history[f"contact_{name}"].values for name in ("lambda_n", "lambda_tau"))
    outside = np.abs(tangential) - friction * (1.0 + 1e-8) * normal
    assert np.nanmax(outside, initial=-1.0) < 1e-6


def check(scenario):
    history = simulate(scenario)
    assert_sound(history, cone(scenario.contact))
    energy = history.summary["energy"]
    assert history.outcome in OUTCOMES
    for name in ("lost_impact", "lost_friction", "lost_damping"):
        assert energy[name] >= -1e-12, name
    if history.outcome is Outcome.COMPLETED:
        assert float(history["time"][-1]) == scenario.end_time
        assert abs(energy["unaccounted"]) < LEDGER
    if scenario.contact.enabled and scenario.contact.normal == "rigid":
        assert float(np.nanmin(history["gap"].values)) > -TOUCH
        assert float(np.nanmin(history["lambda_n"].values)) > -1e-6


@st.composite
def implicit_scenarios(draw):
    """The same scenarios on the full nodal model, by generalized-alpha or, on rigid stops, time-stepping."""
    scenario, elements, grading = draw(scenarios()), draw(st.integers(2, 8)), draw(pick(1.0, 3.0))
    steps = {"solver__contact_step": 1e-5} if scenario.contact.enabled else {}
    scheme = {"solver__scheme": "generalized-alpha", "solver__rho_infinity": draw(st.floats(0.0, 1.0))}
    if scenario.contact.enabled and scenario.contact.normal == "rigid":
        scheme = {"solver__scheme": "time-stepping"}
    return scenario.adapted(
        beam__modal_damping_ratio=0.0,
        beam__tip_mass=draw(pick(0.0, 0.1)),
        discretization__method="fem",
        discretization__frame="mean-axis",
        discretization__kinetics="first-order",
        discretization__modes=0,
        discretization__elements=elements,
        discretization__grading=grading if elements > 2 else 1.0,
        **steps,
        **scheme,
    )


def check_implicit(scenario):
    history = simulate(scenario)
    assert_sound(history, cone(scenario.contact))
    energy = history.summary["energy"]
    assert history.outcome in (*OUTCOMES, Outcome.CHATTERING)
    if history.outcome is Outcome.COMPLETED:
        # works of forces are sampled to second order in the step, which here does not resolve the fastest modes
        scale = abs(energy["initial"]) + float(history["energy_kinetic"].max())
        assert abs(energy["unaccounted"]) < 5e-3 * scale + 1e-6
    if scenario.contact.enabled and scenario.contact.normal == "rigid":
        closed, c = history["state"].values > 0, scenario.contact
        # what a step decides is the gap in the middle of the next one
        gap, ahead = history["gap"].values, 0.5 * scenario.solver.contact_step * history["gap_rate"].values
        assert float(np.nanmin(np.maximum(gap, gap + ahead))) > -STEPPED
        # a step that a rebound begins in ends closed, and on its way
        rebound = c.restitution * scenario.solver.contact_step * float(np.abs(history["gap_rate"].values).max())
        nearest = np.minimum(np.abs(gap), np.abs(gap + ahead))
        assert np.all(nearest[closed] < STEPPED + rebound)


@settings(derandomize=True, max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(scenario=implicit_scenarios())
def test_random_nodal_scenarios(scenario):
    check_implicit(scenario)


@pytest.mark.slow
@settings(derandomize=True, max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(scenario=implicit_scenarios())
def test_many_random_nodal_scenarios(scenario):
    check_implicit(scenario)


@pytest.mark.slow
@settings(derandomize=True, max_examples=600, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(scenario=scenarios())
def test_many_random_scenarios(scenario):
    check(scenario)


@st.composite
def stepped_scenarios(draw, pegs=(1, 2)):
    """Beams that are thrown against a slope or pegs close by, by the schemes that find or take forces late."""
    scheme, where = draw(pick("fixed-step", "generalized-alpha")), draw(pick("point", "point", "pegs"))
    angle, friction = draw(st.floats(-0.3, 0.6)), draw(pick(0.1, 0.3, 0.8, 1.5))
    normal = draw(pick("rigid", "spring")) if where == "point" and scheme == "fixed-step" else "spring"
    contact = {"normal": normal, "friction": "hybrid", "mu_kinetic": friction}
    contact["mu_static"] = friction * draw(pick(1.0, 1.3))
    if normal == "spring":
        contact |= {"stiffness": 10.0 ** draw(st.floats(4.0, 6.5)), "axial_flexibility": draw(st.booleans())}
    kelvin_voigt = draw(pick(0.0, 1e-5, 1e-3))
    if contact.get("axial_flexibility") and kelvin_voigt:
        contact["residual_flexibility"] = False

    def beside(along, across):
        place = along * np.exp(1j * (angle - across))
        return [float(place.real), float(place.imag)]

    sections = {
        "end_time": 0.03,
        "beam": {
            "youngs_modulus": 10.0 ** draw(st.floats(9.3, 11.3)),
            "kelvin_voigt": kelvin_voigt,
        },
        "initial": {"angle": angle, "angular_velocity": draw(st.floats(-8.0, -1.0))},
        "contact": contact,
        "discretization": {"method": "modal", "frame": "mean-axis", "modes": draw(st.integers(1, 4))},
        "solver": {
            "scheme": scheme,
            "contact_step": draw(pick(1e-5, 5e-5)),
            "free_step": 1e-4,
            "output_interval": draw(pick(1e-3, 1e-4)),
        },
    }
    if where == "point":
        near = beside(1.0, draw(st.floats(5e-4, 0.05)))
        sections["slope"] = {"origin": near, "angle": angle + draw(st.floats(-0.6, 0.5))}
    else:
        contact["where"], sections["slope"] = "anywhere", {"enabled": False}
        places = [beside(draw(st.floats(0.3, 0.9)), draw(st.floats(0.01, 0.06))) for _ in range(draw(pick(*pegs)))]
        sections["obstacles"] = [{"kind": "point", "origin": at} for at in places]
    return Scenario.from_dict(sections)


@settings(derandomize=True, max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(scenario=stepped_scenarios(pegs=(2,)))
def test_forces_of_random_scenarios_are_in_their_cones(scenario):
    assert_sound(simulate(scenario), scenario.contact.mu_static)


@pytest.mark.slow
@settings(derandomize=True, max_examples=300, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(scenario=stepped_scenarios())
def test_forces_of_many_random_scenarios_are_in_their_cones(scenario):
    assert_sound(simulate(scenario), scenario.contact.mu_static)


def test_a_place_that_grazes_the_slope_at_the_bottom_of_its_circle_goes_on():
    """It has no lever arm there, so that no impulse could change its speed along the normal."""
    keys = [
        "gravity=0",
        "initial.angle=0",
        "initial.angular_velocity=-5",
        "slope.origin=[0,-0.5]",
        "slope.angle=0",
    ]
    grazing = Scenario.builtin("paper", [*keys, "contact.point=0.5", "end_time=0.5", "discretization.modes=1"])
    history = simulate(grazing)
    assert history.outcome is Outcome.COMPLETED
    assert not history.events
    assert float(history["theta"][-1]) == pytest.approx(-2.5, abs=1e-10)


def test_a_contact_that_jams_in_its_first_impact_keeps_its_energy_balance():
    """No force is consistent there: none is in the balance."""
    keys = [
        "gravity=0",
        "initial.angle=0",
        "initial.angular_velocity=-4",
        "slope.origin=[0,-0.375]",
        "slope.angle=0",
        "contact.mu_kinetic=1.5",
        "contact.mu_static=1.5",
        "contact.shortening=false",
    ]
    jammed = Scenario.builtin("paper", [*keys, "contact.point=0.5", "discretization.modes=1"])
    history = simulate(jammed)
    assert history.outcome is Outcome.PAINLEVE
    assert abs(history.summary["energy"]["unaccounted"]) < LEDGER

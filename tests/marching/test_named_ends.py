"""Runs that end by name: deflections out of range, steps without end, numbers that no beam has, Painleve."""

import numpy as np
import pytest

from oblique_impact import Outcome, Scenario, simulate

# a driven root turns the beam against the slope
PUSHED = (
    "root.kind=driven root.profile=constant-speed root.spin_rate=-4 initial.angle=0 slope.origin=[1,0] "
    "slope.angle=0.3 end_time=0.5"
)
# a soft cantilever, m g L^3/(8 E I) = 0.45 L, that is let go
SAGGING = "root.kind=driven beam.youngs_modulus=3e8 initial.angle=0 end_time=1"
FEM, STEP = "discretization.method=fem", "solver.contact_step=1e-5"
LARGE = {
    "modal, event": PUSHED,
    "modal, fixed-step": f"{PUSHED} solver.scheme=fixed-step {STEP}",
    "fem, generalized-alpha": f"{PUSHED} {FEM} solver.scheme=generalized-alpha {STEP} contact.normal=spring",
    "in flight": f"{SAGGING} contact.enabled=false",
    # a beam on a pin that falls like a rope and strikes the slope
    "nodal": f"beam.youngs_modulus=3e6 end_time=0.8 {FEM} discretization.modes=0 discretization.elements=8 {STEP}",
    # the contact point is near the root, where the deflection stays small
    "beyond the contact point": f"{SAGGING} contact.point=0.25 slope.origin=[0,-5]",
}


# a soft beam is thrown onto two pegs, and its free part wraps around the outer one
ON_PEGS = {
    "end_time": 0.3,
    "beam": {"youngs_modulus": 3e5},
    "initial": {"angle": 0.2, "angular_velocity": -40.0},
    "slope": {"enabled": False},
    "obstacles": [{"kind": "point", "origin": [0.3, 0.03]}, {"kind": "point", "origin": [0.5, 0.02]}],
    "contact": {"where": "anywhere"},
    "discretization": {"method": "modal", "frame": "mean-axis", "modes": 3},
    "solver": {"scheme": "time-stepping", "contact_step": 1e-5, "free_step": 1e-5, "output_interval": 1e-3},
}


def assert_ends_where_it_ends(history):
    """No sample, event or contact is later than the end, and the impulses are those of the momentum until then."""
    end = history.summary["end_time"]
    assert float(history["time"].values[-1]) == end
    assert all(event.time <= end for event in history.events)
    assert [e.time for e in history.events] == sorted(e.time for e in history.events)
    for contact in history.contacts:
        assert contact.start <= contact.end <= end
        assert contact.normal_impulse >= 0.0
        assert contact.energy_loss >= -1e-9


def test_time_stepping_that_ends_early_has_no_changes_behind_its_end():
    """Steps are taken by the thousand; the deflection has grown too large before the last of them."""
    history = simulate(Scenario.from_dict(ON_PEGS))
    assert history.outcome is Outcome.LARGE_DEFLECTION
    assert_ends_where_it_ends(history)
    assert len(history.contacts) > 2
    # the whole run to that end has the same contacts
    whole = simulate(Scenario.from_dict({**ON_PEGS, "end_time": history.summary["end_time"]}))
    assert [e.time for e in history.events] == pytest.approx([e.time for e in whole.events], abs=1e-12)
    for one, other in zip(history.contacts, whole.contacts, strict=True):
        assert one[:6] == pytest.approx(other[:6], rel=1e-6, abs=1e-9)
    assert history.balance["lost_impact"] == pytest.approx(whole.balance["lost_impact"], rel=1e-9)


def test_a_mass_matrix_that_is_indefinite_where_the_run_ends_is_named():
    """The steps of 10 ms of a soft beam go past the point where it is singular, with both pegs in contact."""
    pegs = [
        {"kind": "point", "origin": [x, y], "stiffness": 39.88530350484238} for x, y in ((0.3, 0.03), (0.8, 0.02))
    ]
    sections = {
        "end_time": 0.2,
        "beam": {"youngs_modulus": 25235907.98739405, "kelvin_voigt": 1e-3},
        "initial": {"angle": 0.2, "angular_velocity": -4.51247292189096},
        "slope": {"enabled": False},
        "obstacles": pegs,
        "contact": {"where": "anywhere", "normal": "spring"},
        "discretization": {"method": "modal", "frame": "tangent", "modes": 4},
    }
    steps = {"rho_infinity": 0.5, "contact_step": 1e-2, "free_step": 1e-2, "output_interval": 1e-3}
    solver = {"scheme": "generalized-alpha", "tolerance": 1e-8, **steps}
    history = simulate(Scenario.from_dict({**sections, "solver": solver}))
    assert history.outcome is Outcome.MASS_MATRIX_INDEFINITE
    assert_ends_where_it_ends(history)
    assert history["time"].size > 3
    assert history.contacts[-1].end == pytest.approx(history.summary["end_time"], abs=1e-12)
    # its kinematics are those of the last state though no force is known there
    places = history["contact_place"].values
    assert np.isfinite(places).all()
    assert np.abs(np.diff(places[-2:], axis=0)).max() < 0.1
    history.section_forces()


EXACT = "discretization.method=absolute discretization.elements=4 contact.normal=spring end_time=2e-3"
SCHEMES = {
    "event": "",
    "fixed-step": "solver.scheme=fixed-step",
    "generalized-alpha": "solver.scheme=generalized-alpha contact.normal=spring",
    "time-stepping": "solver.scheme=time-stepping contact.where=anywhere contact.grid=2",
    "time-stepping, one point": "solver.scheme=time-stepping",
    "exact": EXACT,
}


@pytest.mark.parametrize("name", SCHEMES)
def test_steps_and_intervals_longer_than_the_run_are_cut_to_it(name):
    scenario = Scenario.builtin("paper", ["end_time=0.01", *SCHEMES[name].split()])
    scenario = scenario.replace(solver__output_interval=scenario.end_time)
    long = {"solver__output_interval": 10.0}
    if name != "event":
        scenario = scenario.replace(solver__free_step=scenario.end_time, solver__contact_step=scenario.end_time)
        long |= {"solver__free_step": 1e7, "solver__contact_step": 1e8}
    history, other = simulate(scenario.replace(**long)), simulate(scenario)
    assert_ends_where_it_ends(history)
    assert history.outcome is other.outcome
    assert history.summary["end_time"] == scenario.end_time
    assert history["q"].values[-1] == pytest.approx(other["q"].values[-1], rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("name", LARGE)
def test_a_deflection_beyond_half_the_length_ends_the_run(name):
    scenario = Scenario.builtin("paper", LARGE[name].split())
    history = simulate(scenario)
    assert history.outcome is Outcome.LARGE_DEFLECTION
    assert_ends_where_it_ends(history)
    largest = np.abs(history["uy"].values).max(axis=1) / scenario.beam.length
    assert largest[-1] > 0.5
    assert np.all(largest[history["time"].values < history["time"].values[-1]] <= 0.5)
    assert 0.0 < float(history["time"][-1]) < scenario.end_time
    # it is ended at the first such sample, not when it has grown without bound
    assert largest[-1] < 0.6
    assert abs(history.summary["energy"]["unaccounted"]) < 1e-2 * abs(history.summary["energy"]["initial"] + 1.0)


def test_a_run_that_would_need_absurdly_many_steps_says_so():
    scenario = Scenario.builtin("paper", ["beam.second_moment=7850"])  # mm^4 taken for m^4
    history = simulate(scenario)
    assert history.outcome is Outcome.TOO_MANY_STEPS
    assert history.outcome.exit_code == 1
    end, steps = history.summary["end_time"], history.summary["steps"]
    assert 0.0 < end < scenario.end_time
    assert steps < 2e6
    # the number that it names is of the size that its pace foretells
    words = history.summary["message"].split()
    named = float(words[words.index("steps,") - 1])
    assert named > 1e7
    assert 0.02 < named / (steps * scenario.end_time / end) < 50.0


def test_slip_that_becomes_painleve_is_stopped_by_name():
    """A root that is driven bends the beam until friction would pull its tip into the slope.

    The tip slides from the start on, over 20,000 fixed steps; the event scheme locates the end of the slip.
    """
    keys = "root.kind=driven root.profile=spin-up root.spin_rate=-2 root.spin_up_time=0.05 initial.angle=0.3 "
    keys += "slope.angle=-0.2 beam.kelvin_voigt=1e-3 contact.mu_static=1.65 contact.mu_kinetic=1.65 end_time=0.1 "
    keys += f"slope.origin=[{np.cos(0.3)},{np.sin(0.3)}]"
    scenario = Scenario.builtin("paper", keys.split())
    steps = {"solver__scheme": "fixed-step", "solver__contact_step": 2e-6}
    located, stepped = simulate(scenario), simulate(scenario.replace(**steps))
    for history in (located, stepped):
        assert history.outcome is Outcome.PAINLEVE
        assert [e.kind.value for e in history.events] == ["impact"]
    assert stepped.summary["steps"] > 20_000
    assert stepped.summary["end_time"] == pytest.approx(located.summary["end_time"], abs=3e-5)


def test_an_impact_on_a_damped_fine_mesh_is_no_painleve():
    """The force after the impact is singular, and the first step in contact far longer than it takes to decay."""
    keys = f"{FEM} discretization.modes=0 discretization.elements=128 beam.kelvin_voigt=1e-5 end_time=0.318"
    steps = ("solver.contact_step=1e-5", "solver.contact_step=2e-6")
    runs = [simulate(Scenario.builtin("paper", [*keys.split(), step])) for step in steps]
    assert [history.outcome for history in runs] == [Outcome.COMPLETED] * 2
    impulses = [history.summary["macro_collisions"][0]["normal_impulse"] for history in runs]
    assert impulses[0] == pytest.approx(impulses[1], rel=0.05)

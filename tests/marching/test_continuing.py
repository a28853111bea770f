"""Runs that go on from a given state: closed contacts, the stretched axis, and the sides of pegs."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import History, InputError, Scenario, simulate

STICKS = (
    "initial.angle=0.2214 initial.angular_velocity=-3.786 end_time=0.012 solver.output_interval=1e-4 "
    "contact.mu_static=1 contact.mu_kinetic=1 contact.axial_flexibility=true "
)
SPRING = "contact.normal=spring contact.stiffness=1e5 "
STEPS = "solver.contact_step=5e-6 solver.free_step=5e-6 "
ANYWHERE = "contact.where=anywhere contact.grid=2 "
#: scenario, and how far a run in two pieces may be from the whole one, of its velocities
CASES = {
    "elastic": (STICKS + SPRING, 1e-9),
    "rigid": (STICKS, 1e-9),
    "elastic, fixed steps": (STICKS + SPRING + STEPS + "solver.scheme=fixed-step", 1e-9),
    # its first step of a phase is another one
    "elastic, implicit": (STICKS + SPRING + STEPS + "solver.scheme=generalized-alpha", 1e-5),
    "elastic, anywhere": (STICKS + SPRING + ANYWHERE, 1e-9),
    "rigid, steps": (STICKS + STEPS + ANYWHERE + "solver.scheme=time-stepping", 1e-9),
}


@pytest.mark.parametrize("case", CASES)
def test_a_run_cut_in_two_while_a_contact_sticks_or_slips_is_the_run_in_one_piece(case):
    """The friction stretches the beam at the cut; without its history that would be forgotten."""
    keys, error = CASES[case]
    scenario = Scenario.builtin("paper", keys.split())
    whole = simulate(scenario)
    time = whole["time"].values
    states = whole["contact_state"].values.max(axis=1)
    for state in (1, 2):
        cut = float(time[np.flatnonzero(states == state)[3]])  # where a step ends
        first = simulate(scenario.replace(end_time=cut))
        assert abs(float(first["lambda_tau"][-1])) > 1.0
        rest = scenario.replace(end_time=scenario.end_time - cut)
        second, anew = simulate(rest, initial_state=first), simulate(rest, initial_state=_pair(first))
        for name in ("q", "qd"):
            wanted, size = whole[name].values[-1], np.abs(whole[name].values).max()
            assert second[name].values[-1] == pytest.approx(wanted, abs=error * size)
        assert np.abs((anew["qd"] - whole["qd"]).values[-1]).max() > 1e-6
        # what is stretched at the cut is energy that the second run begins with, and no friction
        for key in ("lost_friction", "lost_impact"):
            both = first.balance[key] + second.balance[key]
            assert both == pytest.approx(whole.balance[key], abs=10.0 * error)
        assert abs(second.balance["unaccounted"]) < max(1e-12, 10.0 * abs(whole.balance["unaccounted"]))
        # the same events after the cut, where the contact is closed already
        later = [(e.kind, e.time) for e in whole.events if e.time > cut]
        assert [e.kind for e in second.events] == [whole.events[0].kind, *(kind for kind, _ in later)]
        times = [e.time + cut for e in second.events[1:]]
        assert times == pytest.approx([t for _, t in later], abs=1e-7 if error > 1e-9 else 1e-9)


def _pair(history: History) -> tuple[np.ndarray, np.ndarray]:
    return history["q"].values[-1], history["qd"].values[-1]


PEG = {
    "end_time": 0.12,
    "gravity": 0.0,
    "beam": {"youngs_modulus": 2e9},
    "initial": {"angle": 0.3, "angular_velocity": -5.0},
    "slope": {"enabled": False},
    "obstacles": [{"kind": "point", "origin": [0.6, 0.0], "stiffness": 1e4}],
    "contact": {"where": "anywhere", "normal": "spring"},
    "discretization": {"method": "modal", "frame": "mean-axis", "modes": 3},
    "solver": {"output_interval": 1e-3},
}


@pytest.mark.parametrize("bent", [False, True])
def test_a_peg_that_is_struck_from_the_other_side_gives_the_mirror_image(bent):
    """The side is that of the state: the scenario's own start is above the peg, the run's is below it."""
    scenario = Scenario.from_dict(PEG)
    bends = np.array([0.03, -0.02, 0.01]) if bent else np.zeros(3)
    start = np.array([0.3, *bends]), np.array([-5.0, *(20.0 * bends)])
    above, below = (simulate(scenario, initial_state=(s * start[0], s * start[1])) for s in (1.0, -1.0))
    assert above.contacts
    assert float(above["contact_gap"].values[0, 0]) > 0.05
    for name, sign in (("q", -1.0), ("contact_lambda_n", 1.0), ("contact_gap", 1.0), ("contact_fy", -1.0)):
        size = np.abs(above[name].values).max()
        np.testing.assert_allclose(below[name].values, sign * above[name].values, atol=1e-8 * size)
    if not bent:
        plain = simulate(scenario)
        np.testing.assert_allclose(above["q"].values, plain["q"].values, atol=1e-10)


def test_a_bent_beam_is_on_the_side_of_a_peg_on_which_its_axis_is():
    """The peg is between the axis and the chord, which passes it on the other side."""
    below = {"angle": -0.1, "angular_velocity": 0.0}
    scenario, shape, still = (
        Scenario.from_dict({**PEG, "end_time": 1e-3, "initial": below}),
        np.zeros(4),
        np.zeros(4),
    )
    shape[1] = 0.03
    bent = simulate(scenario, initial_state=(shape, still))
    shape *= np.sign(np.interp(0.6, bent["station"].values, bent["uy"].values[0]))
    shape[0] = -0.01
    found = simulate(scenario, initial_state=(shape, still))
    places = found["station"].values + found["ux"].values[0] + 1j * found["uy"].values[0]
    turned = places * np.exp(-0.01j)
    height = np.interp(0.6, turned.real, turned.imag)
    assert height > 0.01
    assert float(found["contact_gap"].values[0, 0]) == pytest.approx(height, rel=0.1)
    assert not found["contact_lambda_n"].values.any()


def test_a_beam_that_is_pressed_past_a_peg_stays_on_its_side():
    """A peg without radius is on the other side of the axis while it is pressed in."""
    scenario = Scenario.from_dict({**PEG, "end_time": 0.08})
    whole = simulate(scenario)
    pressed = np.flatnonzero(whole["contact_state"].values[:, 0] > 0)
    cut = round(float(whole["time"].values[pressed[len(pressed) // 2]]), 3)
    first = simulate(scenario.replace(end_time=cut))
    assert float(first["contact_gap"].values[-1, 0]) < -1e-4
    second = simulate(scenario.replace(end_time=0.08 - cut), initial_state=first)
    assert second["q"].values[-1] == pytest.approx(whole["q"].values[-1], abs=1e-9)


def test_a_history_of_other_contacts_is_refused():
    scenario = Scenario.from_dict({**PEG, "end_time": 1e-3})
    history = simulate(scenario)
    two = Scenario.from_dict(
        {**PEG, "obstacles": [*PEG["obstacles"], {"kind": "point", "origin": [0.3, -0.2], "stiffness": 1e4}]}
    )
    with pytest.raises(InputError, match=r"initial_state: a history with 1 places of contact, should have 2"):
        simulate(two, initial_state=history)

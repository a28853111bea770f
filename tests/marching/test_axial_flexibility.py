"""Axial flexibility behind the friction of a beam: its law on what a history holds, schemes against each other."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from oblique_impact import History, Scenario, simulate
from oblique_impact.validation.studies.quantities import not_determined
from tests.marching.test_several import run

#: the second one is out of reach: kernels are those of two contacts
ONE_OF_TWO = ({"kind": "point", "origin": [0.5, 0.0]}, {"kind": "point", "origin": [0.5, -5.0]})
FLEXIBLE = ("contact.axial_flexibility=true", "discretization.frame=mean-axis", "discretization.modes=4")
BOTH = ({"kind": "point", "origin": [0.4, -0.02]}, {"kind": "point", "origin": [0.7, -0.035]})
ELASTIC = (*FLEXIBLE, "contact.normal=spring", "end_time=0.0055", "solver.output_interval=2e-6")
#: as fast as after the fall, just above the pegs
ABOVE_ONE, ABOVE_BOTH = (
    {"angle": angle, "angular_velocity": rate} for angle, rate in ((0.01, -4.53), (-0.045, -4.7))
)
STEPS = (*FLEXIBLE, "contact.where=anywhere", "solver.scheme=time-stepping", "end_time=0.3815")
STRETCH = 1.0 / (68.952e9 * 3.14e-4)  # 1/N, of the paper's beam


def defects(history: History) -> tuple[float, float, float]:
    """Largest errors of stick, a displacement (m) of the material, and of slip, a force (N); largest stretch (m).

    The displacement of the material is its travel, by the slip velocity between the samples, and what the forces
    of all contacts stretch the beam; the two ends of a step weigh what is held.
    """
    time, state = history["time"].values, history["contact_state"].values
    force, rate = history["contact_lambda_tau"].values, history["contact_slip_rate"].values
    place, push = history["contact_place"].values, history["contact_lambda_n"].values
    step = np.diff(time)[:, None]
    held, slid = 0.0, float(np.max(np.abs(np.abs(force) - 0.3 * push)[state == 1], initial=0.0))
    for i in range(state.shape[1]):
        shared = np.minimum(place[:-1, i, None], place[:-1]) * STRETCH
        moved, largest = np.sum(shared * np.diff(force, axis=0), axis=1), []
        for mean in (0.5 * (rate[1:, i] + rate[:-1, i]), rate[1:, i]):
            total = mean * step[:, 0] + moved
            # at the end of a stick that is noticed late the force is that of the edge of its cone
            held_fast = (state[:, i] == 2) & (np.abs(force[:, i]) < 0.3 * push[:, i])
            stuck = held_fast[1:] & held_fast[:-1]
            errors = np.where(stuck, total, 0.0)
            sums = [abs(part.sum()) for part in np.split(errors, np.flatnonzero(np.diff(stuck)) + 1)]
            largest.append(max(sums))
        held = max(held, min(largest))
    return held, slid, float(np.max(np.abs(force) * place * STRETCH))


@pytest.fixture(scope="module")
def located() -> History:
    """The beam on one elastic peg by the event scheme."""
    return run(*ELASTIC, obstacles=ONE_OF_TWO, initial=ABOVE_ONE)


@pytest.mark.parametrize(
    ("scheme", "step", "late", "unaccounted"),
    [("event", 1e-6, 1e-9, 1e-11), ("fixed-step", 1e-6, 1e-5, 3e-8), ("generalized-alpha", 2e-6, 1e-7, 1e-8)],
)
def test_a_contact_that_sticks_is_a_spring_of_the_stiffness_of_the_beam(scheme, step, late, unaccounted, located):
    """It sticks at first, slips at the edge of its cone, sticks again: by every scheme at the same times."""
    steps = () if scheme == "event" else (f"solver.contact_step={step}", "solver.free_step=1e-5")
    found = run(*ELASTIC, f"solver.scheme={scheme}", *steps, obstacles=ONE_OF_TWO, initial=ABOVE_ONE)
    held, slid, stretched = defects(found)
    assert held < 2e-5 * stretched
    assert slid < 1e-9
    assert [e.kind.value for e in found.events] == ["impact", "slip", "stick", "slip", "release"]
    assert [e.time for e in found.events] == pytest.approx([e.time for e in located.events], abs=late)
    assert abs(found.summary["energy"]["unaccounted"]) < unaccounted


def test_two_contacts_that_stick_share_the_axis_between_root_and_the_nearer():
    """Slips that hardly last may be others by fixed steps, which find states at the ends of steps."""
    keys, steps = (*ELASTIC, "end_time=0.006"), ("solver.contact_step=1e-6", "solver.free_step=1e-5")
    times = []
    for scheme in ("event", "generalized-alpha", "fixed-step"):
        more = () if scheme == "event" else steps
        found = run(*keys, f"solver.scheme={scheme}", *more, obstacles=BOTH, initial=ABOVE_BOTH)
        held, slid, stretched = defects(found)
        assert (found["contact_state"].values == 2).all(axis=1).any()
        assert held < 2e-5 * stretched
        assert slid < 1e-9
        times.append([e.time for e in found.events])
    assert times[1] == pytest.approx(times[0], abs=1e-7)


def test_the_tip_of_all_nodes_sticks_as_that_of_all_modes():
    keys = (
        "contact.axial_flexibility=true",
        "contact.normal=spring",
        "discretization.method=fem",
        "discretization.frame=mean-axis",
        "discretization.elements=8",
        "end_time=0.322",
    )
    steps = "solver.scheme=generalized-alpha", "solver.free_step=1e-5", "solver.contact_step=1e-6"
    modes = simulate(
        Scenario.builtin("paper", [*keys, "discretization.modes=16", "contact.residual_flexibility=false"])
    )
    nodes = simulate(Scenario.builtin("paper", [*keys, *steps, "discretization.modes=0"]))
    assert [e.kind for e in nodes.events] == [e.kind for e in modes.events]
    assert [e.kind.value for e in modes.events].count("stick") == 4
    assert [e.time for e in nodes.events] == pytest.approx([e.time for e in modes.events], abs=1e-6)
    assert modes.summary["energy"]["unaccounted"] == pytest.approx(0.0, abs=1e-11)


@pytest.mark.parametrize(
    ("pegs", "at", "most", "kinds"),
    [
        (ONE_OF_TWO, 0.3718, 0.05, {"impact": 1, "slip": 1}),
        (BOTH, 0.382, 1e-6, {"impact": 4, "rebound": 1, "slip": 2, "release": 1}),
    ],
    ids=["one", "two"],
)
def test_on_rigid_pegs_the_event_scheme_is_the_limit_of_time_stepping(pegs, at, most, kinds):
    """Impacts leave contacts stuck and unstretched; one that is pressed less and less slips before it opens.

    The force along the beam is compared where it falls, and one as the other grows.
    """
    keys = "end_time=0.37205" if pegs == ONE_OF_TWO else "end_time=0.3821", "solver.output_interval=1e-5"
    located = run(*FLEXIBLE, *keys, obstacles=pegs)
    assert Counter(e.kind.value for e in located.events) == kinds
    assert all(e.tangential_impulse == 0.0 for e in located.events if e.kind.impulsive)
    assert abs(located.summary["energy"]["unaccounted"]) < 1e-12
    forces = []
    flights = *STEPS, *keys, "solver.free_step=1e-5"
    for step in (0.0, 2e-6, 1e-6):
        found = run(*flights, f"solver.contact_step={step}", obstacles=pegs) if step else located
        along = found["contact_lambda_tau"].values[:, 0 if pegs == ONE_OF_TWO else 1]
        # the force of a step, at whose end it is sampled, is that of its middle
        forces.append(np.interp(at + 0.5 * step, found["time"].values, along))
    errors = np.abs(np.array(forces[1:]) / forces[0] - 1.0)
    assert errors[1] < most
    assert errors[0] / errors[1] > 1.9


@pytest.mark.parametrize(("pegs", "touched"), [(ONE_OF_TWO, 1), (BOTH, 2)], ids=["one", "two"])
def test_contacts_stick_in_time_stepping_too(pegs, touched):
    """What two forces stretch between root and the nearer one they share.  The error falls with the step."""
    errors, losses = [], []
    for step in (2e-6, 1e-6):
        keys = f"solver.contact_step={step}", f"solver.output_interval={step}"
        found = run(*STEPS, *keys, obstacles=pegs)
        held, slid, stretched = defects(found)
        assert slid < 1e-9
        assert (found["contact_state"].values[:, :touched] == 2).all(axis=1).any()
        errors.append(held / stretched)
        energy = found.summary["energy"]
        assert abs(energy["unaccounted"]) < 1e-7
        losses.append(abs(energy["lost_scheme"]))
    assert errors[1] < 5e-3
    assert errors[0] / errors[1] > 1.5
    assert losses[0] / losses[1] == pytest.approx(2.0, rel=0.2)


def test_tangential_impulses_have_a_limit_where_the_beam_stretches_and_are_listed_where_not():
    """A straight beam strikes a peg: only its foreshortening yields to friction if it cannot stretch."""
    keys = (*STEPS, "gravity=0", "beam.kelvin_voigt=1e-3", "end_time=0.04")
    start, impulses = {"angle": 0.05, "angular_velocity": -2.0}, []
    for step in (2e-6, 1e-6, 5e-7):
        found = run(
            *keys, f"solver.contact_step={step}", f"solver.free_step={step}", obstacles=ONE_OF_TWO, initial=start
        )
        impulses.append(found.macro_collisions[0]["tangential_impulse"])
        assert "tangential_impulse" not in found.summary["without_limit"]
    first, second = np.diff(impulses)
    assert abs(first) < 1e-3 * abs(impulses[-1])
    assert first / second == pytest.approx(2.0, rel=0.05)
    stiff = run(
        *keys, "contact.axial_flexibility=false", "solver.contact_step=2e-6", obstacles=ONE_OF_TWO, initial=start
    )
    assert stiff.summary["without_limit"][0] == "tangential_impulse"
    (line,) = (words for words in stiff.summary["warnings"] if words.startswith("contact.friction"))
    assert "contact.axial_flexibility = true" in line
    names = ("tangential_impulse", "impulse", "max:lambda_tau")
    assert set(not_determined(names, stiff)) >= {"tangential_impulse", "max:lambda_tau"}

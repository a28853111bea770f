"""Point masses and forces along the beam; more in the checks of the group `loads` and in the identities."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from oblique_impact import Scenario, natural_frequencies, simulate
from oblique_impact.beam.operators import build_operators
from oblique_impact.beam_problem import beam_of
from oblique_impact.fem_beam.nodal import NodalBeam

FREE = "contact.enabled=false solver.output_interval=0.01"
HELD = "root.kind=driven initial.angle=0 gravity=0"
FEM = "discretization.method=fem discretization.elements=8"
MASSES = "masses=[{place=0.37,mass=0.4,inertia=0.01},{mass=0.2,inertia=0.02}]"


def posed(*keys):
    return Scenario.from_toml("", [part for key in keys for part in key.split()])


def run(*keys):
    return simulate(posed(*keys))


# --- forces


@pytest.mark.parametrize("direction", ["across", "1.5707963267948966"])
def test_a_beam_bent_by_a_constant_force_rests_with_the_section_forces_of_statics(direction):
    """F a^2 (3 L - a)/(6 E I) at the tip, moment F (a - x) and shear inboard of a, none outboard of it."""
    force, a, stiffness = 0.03, 0.37, 68.952e9 * 7.85e-9
    load = (
        f"forces=[{{place={a},force={force},direction={direction if direction != 'across' else repr(direction)}}}]"
    )
    scenario = posed(FREE, HELD, FEM, load, "discretization.modes=16 end_time=0.05 solver.tolerance=1e-13")
    o = build_operators(scenario)
    B = np.linalg.solve(o.K, force * o.along.at(a)[0])
    history = simulate(scenario, initial_state=(np.append(0.0, B), np.zeros(B.size + 1)))
    x, tip = history["station"].values, force * a**2 * (3.0 - a) / (6.0 * stiffness)
    assert_allclose(history["uy"].values[:, -1], tip, rtol=1e-10)
    forces = history.section_forces()
    for moment, shear in zip(forces["moment"].values, forces["shear"].values, strict=True):
        assert_allclose(moment, force * np.maximum(a - x, 0.0), atol=1e-9)
        assert_allclose(shear, -force * (x <= a), atol=1e-8)


def test_a_follower_turns_a_stiff_beam_evenly_and_a_fixed_force_like_a_pendulum():
    """On a pin, J theta'' = F L against J theta'' = F L cos(theta - direction - pi/2)."""
    force, end, stiff = 2.0, 1.5, "beam.youngs_modulus=1e14 discretization.frame=mean-axis discretization.modes=1"
    inertia, start = 2766.7 * 3.14e-4 / 3.0, np.pi / 4
    keys = [FREE, stiff, f"gravity=0 end_time={end}"]
    follower = run(*keys, f"forces=[{{force={force}}}]")
    assert follower["theta"].values[-1] - start == pytest.approx(0.5 * force / inertia * end**2, rel=1e-7)
    work = force * (follower["theta"].values[-1] - start)
    assert follower.balance["supplied"] == pytest.approx(work, rel=1e-6)
    fixed = run(*keys, f"forces=[{{force={force},direction=1.2}}]")
    swing = solve_ivp(
        lambda t, y: (y[1], force / inertia * np.sin(1.2 - y[0])), (0.0, end), (start, 0.0), rtol=1e-12, atol=1e-12
    )
    assert fixed["theta"].values[-1] == pytest.approx(swing.y[0, -1], abs=1e-6)


def test_a_force_fixed_in_space_is_a_weight():
    """A base that falls freely takes all weights, and forces give them back."""
    heavy = posed(FREE, "end_time=0.2 discretization.modes=3").replace(masses=[{"place": 0.6, "mass": 0.5}])
    # that of the beam itself by the mid-point rule
    own, parts, down = 2766.7 * 3.14e-4, 99, -np.pi / 2
    places = (np.arange(parts) + 0.5) / parts
    weights = [{"place": x, "force": 9.8 * own / parts, "direction": down} for x in places]
    weights += [{"place": 0.6, "force": 9.8 * 0.5, "direction": down}]
    falling = heavy.replace(base__table=[[0.0, -9.8], [1.0, -9.8]], forces=weights)
    found, expected = simulate(falling), simulate(heavy)
    assert_allclose(found["theta"], expected["theta"], atol=1e-4)
    assert_allclose(found["uy"], expected["uy"], atol=1e-3 * np.abs(expected["uy"].values).max())


def test_rows_of_a_force_on_a_line_change_nothing():
    """A step ends at each of its kinks, and samples stay where they are due."""
    ends, between = [[0, -3], [0.05, 6], [0.1, 1]], [[0, -3], [0.02, 0.6], [0.05, 6], [0.0613, 4.87], [0.1, 1]]
    one, other = (
        run(FREE, f"end_time=0.1 forces=[{{place=0.6,table={rows}}}]".replace(", ", ","))
        for rows in (ends, between)
    )
    assert_allclose(one["time"], other["time"], rtol=1e-12)
    assert_allclose(one["theta"], other["theta"], atol=1e-10)


def test_a_table_of_a_sweep_is_the_sweep():
    t = np.linspace(0.0, 0.1, 2001)
    rows = np.stack([t, 3.0 * np.sin(2.0 * np.pi * (20.0 * t + 50.0 * t**2))], axis=1).tolist()
    whole = posed(FREE, "end_time=0.1")
    sweep = {"place": 0.6, "force": 3.0, "frequency": 20.0, "sweep_rate": 100.0}
    harmonic, table = (simulate(whole.replace(forces=[item])) for item in (sweep, {"place": 0.6, "table": rows}))
    assert_allclose(table["theta"], harmonic["theta"], atol=1e-7)
    assert np.ptp((harmonic["theta"] - simulate(whole)["theta"]).values) > 1e-3


# --- masses


@pytest.mark.parametrize("model", ["", FEM, f"{FEM} discretization.modes=0 solver.free_step=1e-3"])
def test_a_tip_mass_is_a_point_mass_at_the_tip(model):
    old, new = (run(FREE, model, "end_time=0.05", mass) for mass in ("beam.tip_mass=0.2", "masses=[{mass=0.2}]"))
    assert old["q"].values.tobytes() == new["q"].values.tobytes()
    assert old.section_forces()["moment"].values.tobytes() == new.section_forces()["moment"].values.tobytes()


@pytest.mark.parametrize("frame", ["tangent", "mean-axis"])
@pytest.mark.parametrize("kinetics", ["first-order", "full"])
def test_a_beam_on_its_pin_keeps_its_angular_momentum(frame, kinetics):
    """The momentum of theta, which nothing changes; mass that a section turns with is part of it."""
    shapes = f"{FEM} discretization.modes=4 discretization.frame={frame} discretization.kinetics={kinetics}"
    keys = FREE, MASSES, shapes, "gravity=0 end_time=0.3 initial.angular_velocity=2"
    scenario = posed(*keys)
    bent = np.array([0.7, 0.02, -0.01, 0.004, 0.002]), np.array([2.0, 0.3, 0.2, -0.1, 0.05])
    history, model = simulate(scenario, initial_state=bent), beam_of(scenario).model
    work, found = model.new_workspace(), []
    for t, q, qd in zip(*(history[name].values for name in ("time", "q", "qd")), strict=True):
        model.evaluate(t, q, qd, work)
        found.append(float(work.mass[0] @ qd))
    assert_allclose(found, found[0], rtol=1e-9)
    assert np.ptp(history["uy"].values[:, -1]) > 0.01


def test_an_inertia_is_that_of_two_masses_on_an_arm_along_a_stiff_beam():
    """Of a beam too stiff to bend: what counts is the moment of inertia, 2 m d^2 beside the mass in the middle."""
    stiff = f"{FREE} beam.youngs_modulus=1e15 end_time=0.3 solver.output_interval=0.05"
    arm = run(stiff, "masses=[{place=0.5,mass=0.3},{place=0.7,mass=0.3}]")
    whole = run(stiff, "masses=[{place=0.6,mass=0.6,inertia=0.006}]")
    assert_allclose(arm["theta"].values, whole["theta"].values, atol=1e-7)


def test_a_mesh_has_a_node_at_each_mass_and_force():
    scenario = posed(FEM, MASSES, "forces=[{place=0.71,force=1}]")
    nodes = NodalBeam.from_scenario(scenario).nodes
    assert nodes.size == 9
    assert {0.37, 0.71} <= set(nodes.tolist())


@pytest.mark.parametrize("root", ["root.kind=driven", "", "root.kind=hub root.inertia=0.02"])
def test_frequencies_of_modes_with_masses_are_those_of_elements(root):
    """A beam in modes is given the frequencies of elements, which more of its modes come close to from above."""
    modal, fem = (posed(FREE, root, MASSES, f"discretization.method={method}") for method in ("modal", "fem"))
    found, reference = (natural_frequencies(s, [0.0, 3.0], 4).chordwise for s in (modal, fem))
    assert_allclose(found, reference, rtol=1e-5)
    first = 0 if "driven" in root else 1
    above = []
    for modes in (4, 16):
        o = build_operators(modal.replace(discretization__modes=modes, discretization__frame="tangent"))
        mass = o.elastic_mass - (np.outer(o.coupling, o.coupling) / o.inertia if first else 0.0)
        squares = np.linalg.eigvals(np.linalg.solve(mass, o.K))
        above.append(np.sqrt(squares.real.min()) / reference[0, first] - 1.0)
    assert 0.0 < above[1] < 0.5 * above[0] < 0.05


def test_modes_with_masses_in_the_mean_axis_frame_have_no_angular_momentum():
    o = build_operators(posed(FREE, MASSES, "discretization.frame=mean-axis discretization.modes=5"))
    assert_allclose(o.coupling, 0.0, atol=1e-14 * o.inertia)
    assert np.abs(o.S).max() > 1e-3  # without what turns with sections it has


def test_a_run_in_modes_tells_which_frequencies_the_masses_spoil():
    history = run(FREE, MASSES, "discretization.modes=6 end_time=0.01")
    (told,) = [line for line in history.summary["warnings"] if line.startswith("masses: ")]
    assert "of 6 frequencies are less than 1 % too high" in told
    assert not [
        line for line in run(FREE, FEM, MASSES, "end_time=0.01").summary["warnings"] if line.startswith("masses")
    ]
    light = run(FREE, "beam.tip_mass=1e-5 end_time=0.01")
    assert not [line for line in light.summary["warnings"] if line.startswith("beam.tip_mass")]

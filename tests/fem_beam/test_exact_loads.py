"""Point masses and forces on the beam in absolute coordinates: mechanics, balance, and section forces."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oblique_impact import History, Scenario, simulate
from oblique_impact.fem_beam.exact import ElasticSections, ExactBeam
from oblique_impact.fem_beam.exact import simulate as simulate_absolute
from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.scenario.model import PointMass

FREE = ["contact.enabled=false", "initial.angle=0.3"]
COARSE = "discretization.elements=12"
MASSES = "masses=[{place=0.43,mass=0.1,inertia=1e-3},{place=0.7,mass=0.05},{mass=0.02}]"
FORCES = (
    "forces=[{place=0.6,force=-5},{place=0.85,force=4,frequency=30,direction=1.0},{force=2,sweep_rate=500},"
    "{place=0.5,table=[[0,2],[0.03,-4]]}]"
)
#: nodes at none of the places of masses and forces
ELSEWHERE = f"discretization.nodes={[k / 37 for k in range(38)]}"


def absolute(*words: str) -> Scenario:
    return Scenario.builtin("paper", [*FREE, *words, "discretization.method=absolute"])


def slender(*words: str) -> History:
    """A run without shear and rotary inertia, as the floating frame has it."""
    scenario = absolute(*words)
    return simulate_absolute(scenario, sections=ElasticSections.bernoulli_euler(scenario))


@pytest.fixture(scope="module")
def loaded() -> tuple[History, History]:
    """A loaded beam that falls on its pin, in absolute coordinates and in all nodes."""
    words = [COARSE, MASSES, FORCES, "beam.kelvin_voigt=1e-3", "end_time=0.1", "solver.output_interval=1e-2"]
    words += ["discretization.frame=mean-axis"]
    nodal = ["discretization.method=fem", "discretization.modes=0", "solver.free_step=2e-5"]
    return slender(*words), simulate(Scenario.builtin("paper", [*FREE, *words, *nodal]))


def test_motion_and_section_forces_are_those_of_the_nodal_model(loaded):
    now, then = (history.data.merge(history.section_forces()).isel(time=-1) for history in loaded)
    shares = {
        "theta": 1e-6,
        "tip_vy": 2e-5,
        "uy": 5e-4,
        "energy_gravity": 1e-6,
        "energy_kinetic": 2e-6,
        "moment": 1e-3,
        "shear": 5e-4,
        "axial_force": 5e-4,
    }
    for name, share in shares.items():
        scale = float(np.abs(then[name]).max())
        assert float(np.abs(now[name] - then[name]).max()) < share * scale, name


@pytest.mark.parametrize("nodes", [COARSE, ELSEWHERE], ids=["at nodes", "between nodes"])
@pytest.mark.parametrize("root", ["root.kind=pin", "root.kind=driven base.acceleration=20 base.frequency=15"])
def test_the_energy_of_loads_is_accounted_for(nodes, root):
    history = slender(MASSES, FORCES, nodes, *root.split(), "end_time=0.05", "solver.free_step=5e-4")
    energy = history.summary["energy"]
    assert abs(energy["supplied"]) > 1e-2
    scale = max(abs(energy[name]) for name in ("initial", "kinetic", "supplied"))
    assert abs(energy["unaccounted"]) < 1e-12 * scale


def test_places_between_nodes_are_those_of_a_mesh_that_has_them():
    words = MASSES, FORCES, "beam.kelvin_voigt=1e-3", "end_time=0.05", "solver.output_interval=1e-2"
    at, between = (slender(*words, nodes) for nodes in (COARSE, ELSEWHERE))
    for name, share in {"theta": 1e-6, "tip_vy": 1e-4, "uy": 1e-3, "energy_kinetic": 1e-6}.items():
        scale = float(np.abs(at[name]).max())
        assert float(np.abs(at[name] - between[name]).isel(time=-1).max()) < share * scale, name
    # bending has its kinks inside of elements now, which a quadratic does not hold
    now, then = (history.section_forces().isel(time=-1) for history in (between, at))
    for name, share in {"moment": 0.02, "shear": 0.03, "axial_force": 0.02}.items():
        assert float(np.abs(now[name] - then[name]).max()) < share * float(np.abs(then[name]).max()), name


def test_work_of_a_force_fixed_in_space_is_force_times_displacement():
    history = slender(COARSE, "forces=[{force=30,direction=2}]", "gravity=0", "end_time=0.2")
    tip = history["tip_x"].values + 1j * history["tip_y"].values
    work = (30.0 * np.exp(-2j) * (tip - tip[0])).real
    assert history.total_energy.values == pytest.approx(work, rel=1e-11, abs=1e-11 * work.max())
    assert history.summary["energy"]["supplied"] == pytest.approx(work[-1], rel=1e-12)


def test_a_force_across_turns_a_stiff_beam_on_its_pin_as_a_moment():
    """It has the lever L whatever the angle: theta = theta_0 + F L t^2/(2 J), work F L theta."""
    stiff = "beam.youngs_modulus=1e14", "beam.second_moment=1e-8", "gravity=0"
    force, mass = 5.0, 3.14e-4 * 2766.7
    words = f"forces=[{{force={force}}}]", "masses=[{place=0.5,mass=0.2,inertia=0.01}]", "end_time=1"
    history = slender(COARSE, *stiff, *words, "solver.free_step=1e-3")
    inertia = mass / 3.0 + 0.2 * 0.25 + 0.01
    turned = force / (2.0 * inertia)
    assert turned > 2.0 * math.pi  # once around
    # it has bent and stretched by 1e-6, and shakes about that
    assert float(history["theta"][-1]) - 0.3 == pytest.approx(turned, rel=1e-5)
    assert history.summary["energy"]["supplied"] == pytest.approx(force * turned, rel=1e-5)


def test_a_point_mass_moves_as_the_section_that_carries_it():
    """Between nodes too: kinetic energy and momentum of a rigid turn about any point."""
    ends, plain = np.linspace(0.0, 1.0, 5), ElasticSections.uniform(1e7, 1e7, 500.0, 0.0)
    for place in (0.25, 0.3, 0.125, 1.0):
        beam = ExactBeam(ends, plain, [PointMass(place, 0.7, 0.02)])
        v = beam.turning(beam.straight(0.4), 3.0)
        v[0::3] += 2.0 * math.sin(0.4)  # against the turn of the beam, which is along (-sin, cos)
        v[1::3] -= 2.0 * math.cos(0.4)
        energy = 0.5 * 0.7 * (3.0 * place - 2.0) ** 2 + 0.5 * 0.02 * 9.0
        assert float(beam.kinetic_energy(v)) == pytest.approx(energy, rel=1e-13)
        assert beam.weight(9.8).reshape(-1, 3).sum(axis=0) == pytest.approx([0.0, -0.7 * 9.8, 0.0], rel=1e-13)


def test_pictures_have_the_arrows_of_forces_that_turn_with_the_beam():
    """Of a beam at rest whose tip has turned by 129 degrees."""
    words = ["root.kind=driven", "initial.angle=0", "initial.state=equilibrium", "end_time=1e-3"]
    history = simulate(absolute(*words, "forces=[{force=3000},{place=0.5,force=10,direction=1}]"))
    turned = float(history["q"][0, -1])
    assert turned > 2.0
    _, drawn = BeamGeometry(history).applied_forces(0)
    across = 3000.0 * np.array([-math.sin(turned), math.cos(turned)])
    assert drawn[0] == pytest.approx(across, abs=3.0)
    assert drawn[1] == pytest.approx([10.0 * math.cos(1.0), 10.0 * math.sin(1.0)], rel=1e-12)

"""The roots of the exact beam: a clamp that yields, a hub on a spring, a hub with a radius."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import curve_fit

from oblique_impact import History, Scenario, simulate
from oblique_impact.fem_beam.exact import ElasticSections, ExactBeam, Stage, advance
from oblique_impact.fem_beam.exact import simulate as simulate_absolute
from oblique_impact.modal.eigenfunctions import hub_free_roots
from oblique_impact.validation.runs import UNIT

ABSOLUTE = "discretization.method=absolute discretization.elements=8"
FREE = "contact.enabled=false beam.kelvin_voigt=2e-5 gravity=4 initial.angle=0.3 end_time=0.1"
FREE += " solver.free_step=1e-4 solver.output_interval=1e-3"
CLAMP = "root.kind=driven root.stiffness=400 root.damping=0.3"
SPIN_UP = "root.profile=spin-up root.spin_rate=0.5 root.spin_up_time=0.05"
HUB = "root.kind=hub root.inertia=0.05 initial.angular_velocity=1"


def paper(*keys: str) -> Scenario:
    return Scenario.builtin("paper", " ".join(keys).split())


def without_shear(*keys: str) -> History:
    """Run the exact beam with the mechanics of the floating frame: hardly any shear, no rotary inertia."""
    scenario = paper(*keys, ABSOLUTE)
    return simulate_absolute(scenario, sections=ElasticSections.bernoulli_euler(scenario))


ROOTS = {
    "a clamp that yields": f"{CLAMP} {SPIN_UP}",
    "a clamp that yields on a radius": f"{CLAMP} {SPIN_UP} root.hub_radius=0.2",
    "a hub on a spring": f"{HUB} root.stiffness=400 root.damping=0.3",
    "a hub with a radius": f"{HUB} root.hub_radius=0.3 root.torque=2",
    "a hub with a radius on a spring": f"{HUB} root.hub_radius=0.3 root.stiffness=400 root.damping=0.3",
}


@pytest.mark.parametrize("root", ROOTS.values(), ids=ROOTS)
def test_roots_are_those_of_the_floating_frame(root):
    """At small deflections, in motion, energies and the moment at the root; each closes its own ledger."""
    found = without_shear(FREE, root)
    modes = "discretization.method=fem discretization.modes=8 discretization.kinetics=full"
    known = simulate(paper(FREE, root, modes))
    assert abs(found.balance["unaccounted"]) < 1e-10 * found.balance["final"]
    shares = {"theta": 2e-5, "tip_x": 2e-5, "tip_y": 1e-4, "energy_kinetic": 2e-3, "energy_elastic": 5e-3}
    for name, share in shares.items():
        scale = float(np.abs(known[name]).max())
        assert float(np.abs(found[name] - known[name]).max()) < share * scale, name
    for name in ("supplied", "lost_damping"):
        assert found.balance[name] == pytest.approx(known.balance[name], rel=2e-3, abs=1e-12), name
    moments = [history.section_forces()["moment"].values[:, 0] for history in (found, known)]
    assert np.abs(moments[0] - moments[1]).max() < 0.02 * np.abs(moments[1]).max()


@pytest.mark.parametrize("radius", [0.0, 0.4])
def test_the_frequency_of_a_hub_on_a_spring_is_that_of_the_secular_equation(radius):
    """A beam of length, mass and stiffness 1, whose hub starts to turn slowly on a soft spring."""
    scenario = Scenario.from_dict(
        {
            "beam": UNIT,
            "contact": {"enabled": False},
            "root": {"kind": "hub", "inertia": 0.3, "hub_radius": radius, "stiffness": 0.5},
            "initial": {"angle": 0.0, "angular_velocity": 1e-4},
            "discretization": {"method": "absolute", "elements": 6},
            "solver": {"free_step": 0.02, "output_interval": 0.1},
            "gravity": 0.0,
            "end_time": 60.0,
        }
    )
    found = simulate_absolute(scenario, sections=ElasticSections.uniform(1e6, 1e6, 1.0, 1.0))
    assert abs(found.balance["unaccounted"]) < 1e-11 * found.balance["initial"]
    expected = hub_free_roots(1, 0.3, radius, 0.5)[0] ** 2
    swing, _ = curve_fit(
        lambda t, w, a, b: a * np.sin(w * t) + b * np.cos(w * t),
        found["time"].values,
        found["theta"].values,
        p0=(expected * 1.01, 1e-4, 0.0),
    )
    assert swing[0] == pytest.approx(expected, rel=3e-5)


def test_a_stiff_spring_is_a_rigid_clamp():
    """The difference is the spring's flexibility, once it is small."""
    rigid = simulate(paper(FREE, ABSOLUTE, "root.kind=driven", SPIN_UP))
    off = []
    for stiffness in (1e5, 1e6):
        yields = f"root.kind=driven root.stiffness={stiffness}"
        off.append(float(np.abs(simulate(paper(FREE, ABSOLUTE, yields, SPIN_UP))["tip_y"] - rigid["tip_y"]).max()))
    assert off[0] / off[1] == pytest.approx(10.0, rel=0.05)
    assert off[1] < 1e-4


def test_the_moment_at_a_clamp_at_rest_is_that_of_the_weight():
    """And what turns the first section against the prescribed angle, which is that of the frame."""
    held = "root.kind=driven root.stiffness=400 root.damping=10 gravity=9.8 initial.angle=0"
    steps = "end_time=2 solver.free_step=1e-3 solver.output_interval=0.5"
    found = simulate(paper(FREE.replace("2e-5", "1e-2"), ABSOLUTE, held, steps))
    beam = found.scenario.beam
    weight = 9.8 * beam.density * beam.area * beam.length
    moment = float(found.section_forces()["moment"][-1, 0])
    assert moment == pytest.approx(-0.5 * weight * beam.length, rel=2e-3)
    assert 400.0 * float(found["q"][-1, 2]) == pytest.approx(moment, rel=1e-3)
    assert float(found["theta"][-1]) == 0.0


def on_a_hub(elements: int) -> ExactBeam:
    sections = ElasticSections.uniform(1e4, 1e4, 5.0, 1.0)
    return ExactBeam(np.linspace(0.0, 1.0, elements + 1), sections, hub_inertia=0.1, radius=0.5)


@pytest.mark.parametrize("length", [4e-3, 0.05])
def test_a_free_hub_with_a_radius_keeps_angular_momentum_and_energy(length):
    b = on_a_hub(3)
    start = b.straight(0.2)
    bent = b.turning(start, 3.0) + np.tile([0.0, 0.0, 1.0], b.x.size) * np.sin(7.0 * np.repeat(b.x, 3))
    bent[:2] = b.turning(start, bent[2])[:2]
    stage = Stage(start, bent)
    for _ in range(round(0.4 / length)):
        stage = advance(b, stage, length, np.zeros(b.size), held=np.zeros(2), root=(b.radius,)).stage
        turning = b.angular_momentum(stage.q, stage.v)
        assert turning == pytest.approx(b.angular_momentum(start, bent), rel=1e-12)
    assert np.hypot(stage.q[0], stage.q[1]) == pytest.approx(0.5, rel=1e-14)
    energy = b.kinetic_energy(stage.v) + b.elastic_energy(stage.q)
    assert energy == pytest.approx(float(b.kinetic_energy(bent)), rel=1e-11)


def test_newtons_iterations_know_the_radius_and_the_spring():
    """They square their errors in steps that turn the hub by half a radian."""
    b = on_a_hub(2)
    q = b.straight(0.2)
    root = 0.5, 30.0, 0.4, 0.1, 0.1
    step = advance(b, Stage(q, b.turning(q, 10.0)), 0.05, b.weight(9.8), held=np.zeros(2), root=root)
    first, second, third, *_ = step.increments
    assert third < second**2 < first**2, step.increments  # with a matrix of their own


@pytest.mark.parametrize("friction", ["frictionless", "hybrid"])
def test_contacts_by_the_first_node_of_a_hub_with_a_radius_close_the_ledger(friction):
    """On a peg beside the root the beam slides in its first element, whose rows are those of the hub too."""
    peg = 'obstacles=[{kind="point",origin=[0.34,0.0],radius=0.004,stiffness=1e5}]'
    words = f"{ABSOLUTE} root.kind=hub root.hub_radius=0.3 root.inertia=0.01 initial.angle=0.2"
    words += f" contact.where=anywhere contact.normal=spring slope.enabled=false contact.friction={friction} {peg}"
    words += " end_time=0.15 initial.angular_velocity=-3 solver.contact_step=1e-5 solver.output_interval=1e-3"
    found = simulate(paper(words))
    assert found.contacts
    assert abs(found.balance["unaccounted"]) < 1e-11 * found.balance["initial"]
    if friction == "hybrid":
        assert found.balance["lost_friction"] > 1e-5

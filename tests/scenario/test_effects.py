"""Every key acts or is refused: runs that differ in one key alone differ in their numbers, or the key is named."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.scenario import effects, sections
from oblique_impact.scenario.comments import item_models, schemas_of
from oblique_impact.scenario.scenario import builtin_names, builtin_text
from oblique_impact.scenario.schema import key_schemas
from oblique_impact.scenario.toml import apply_change
from oblique_impact.validation.studies.design import load_plan
from oblique_impact.validation.studies.fitting.least_squares import parameters_of
from tests.refusals import refused_in_one_line

# a beam a little above a steep slope, or above pegs and tables, which it touches at once
FALL = "initial.angle=0.472 initial.angular_velocity=-1 end_time=0.006 solver.output_interval=1e-3"
START = f"{FALL} slope.origin=[0.6,0] slope.angle=1"
ROUGH = "contact.mu_static=2 contact.mu_kinetic=1.7"
SMOOTH = "contact.friction=frictionless"
COULOMB = "contact.friction=modified-coulomb"
SPRING = "contact.normal=spring"
STEPS = "solver.free_step=1e-5 solver.contact_step=1e-5"
FEM = "discretization.method=fem discretization.elements=8"
DRIVEN = "root.kind=driven initial.angular_velocity=0"
PEG = "{kind='point',origin=[0.6,0.3002],radius=0.005}"
OUTLINE = "{kind='polyline',points=[[0.4,0.05],[0.8,0.1],[1.2,0.0]]}"
TABLE = "{origin=[0.0,-0.001],angle=0.471,extent=[0.0,0.8]}"
ANYWHERE = f"contact.where=anywhere contact.grid=4 slope.enabled=false contact.friction=frictionless {SPRING}"

#: scenarios by name, as changes of the paper's case
CASES = {
    "free": f"{START} contact.enabled=false",
    "rigid": f"{START} {ROUGH}",
    "smooth": f"{START} {SMOOTH}",
    "coulomb": f"{START} {COULOMB} contact.mu_kinetic=1.7",
    "spring": f"{START} {ROUGH} {SPRING}",
    "smooth spring": f"{START} {SMOOTH} {SPRING}",
    "section": f"{START} {SMOOTH} initial.angle=0.49 contact.surface=section",
    "axial": f"{START} {ROUGH} {SPRING} contact.axial_flexibility=true",
    "zeroth": f"{START} {SMOOTH} discretization.kinetics=zeroth-order",
    "hub": f"{START} {SMOOTH} root.kind=hub root.inertia=0.01",
    "held": f"{START} {SMOOTH} {DRIVEN}",
    "yielding": f"{START} {SMOOTH} {DRIVEN} root.stiffness=300",
    "constant": f"{START} {SMOOTH} {DRIVEN} root.profile=constant-speed root.spin_rate=-1",
    "driven": f"{START} {SMOOTH} {DRIVEN} root.profile=spin-up root.spin_rate=-2 root.spin_up_time=0.004",
    "plucked": f"{START} {SMOOTH} {DRIVEN} initial.state=plucked initial.place=0.5 initial.deflection=1e-4",
    "resting": f"{START} {SMOOTH} initial.angular_velocity=0 initial.state=equilibrium",
    "shaken": f"{START} {SMOOTH} base.acceleration=5 base.frequency=200",
    "fem": f"{START} {SMOOTH} {FEM}",
    "fixed-step": f"{START} {ROUGH} solver.scheme=fixed-step {STEPS}",
    "alpha": f"{START} {ROUGH} {SPRING} solver.scheme=generalized-alpha {STEPS}",
    "nodal": f"{START} {SMOOTH} {SPRING} {FEM} discretization.modes=0 {STEPS}",
    "pegs": f"{FALL} contact.where=anywhere slope.enabled=false {SMOOTH} obstacles=[{PEG}]",
    "anywhere": f"{FALL} {ANYWHERE} obstacles=[{PEG},{TABLE}]",
    "bed": f"{FALL} {ANYWHERE} obstacles=[{{bedding=1e5,{TABLE[1:]}]",
    "outline": f"{FALL} obstacles=[{OUTLINE}] contact.where=anywhere contact.grid=2 slope.enabled=false {SMOOTH}",
    "table": f"{FALL} obstacles=[{TABLE}] contact.where=anywhere contact.grid=2 slope.enabled=false {SMOOTH}",
    "time-stepping": f"{START} contact.where=anywhere contact.grid=4 solver.scheme=time-stepping {STEPS}",
    "loaded": f"{START} {SMOOTH} masses=[{{mass=0.1}}] forces=[{{force=2,frequency=100}},{{table=[[0,1],[1,2]]}}]",
    "exact": f"{START} {SMOOTH} {SPRING} discretization.method=absolute discretization.elements=4 "
    "solver.free_step=1e-4 solver.contact_step=1e-4",
    "flying": "discretization.method=absolute discretization.elements=2 contact.enabled=false root.kind=free "
    "end_time=0.002 solver.free_step=1e-3 initial.velocity=[1,2]",
}

#: a case in which a key acts, and another value of it there
ACTS = {
    "end_time": ("smooth", "0.005"),
    "gravity": ("smooth", "9"),
    "beam.length": ("smooth", "1.001"),
    "beam.area": ("smooth", "3e-4"),
    "beam.second_moment": ("smooth", "8e-9"),
    "beam.density": ("smooth", "2700"),
    "beam.youngs_modulus": ("smooth", "7e10"),
    "beam.material": ("smooth", "steel"),
    "beam.kelvin_voigt": ("smooth", "1e-4"),
    "beam.mass_proportional": ("smooth", "10"),
    "beam.modal_damping_ratio": ("smooth", "0.1"),
    "beam.tip_mass": ("fem", "0.01"),
    "beam.outer_fibre": ("section", "0.009"),
    "beam.section.shape": ("smooth", "circle beam.section.diameter=0.02"),
    "beam.section.diameter": ("smooth", "0.02 beam.section.shape=circle"),
    "beam.section.width": ("smooth", "0.02 beam.section.shape=rectangle beam.section.height=0.02"),
    "beam.section.height": ("smooth", "0.02 beam.section.shape=rectangle beam.section.width=0.02"),
    "beam.section.thickness": ("smooth", "0.002 beam.section.shape=tube beam.section.diameter=0.02"),
    "beam.section.flange_thickness": (
        "smooth",
        "0.002 beam.section.shape=i-beam beam.section.height=0.02 beam.section.width=0.02 "
        "beam.section.web_thickness=0.002",
    ),
    "beam.section.web_thickness": (
        "smooth",
        "0.003 beam.section.shape=i-beam beam.section.height=0.02 beam.section.width=0.02 "
        "beam.section.flange_thickness=0.002",
    ),
    "root.kind": ("free", "driven initial.angular_velocity=0"),
    "root.hub_radius": ("hub", "0.001"),
    "root.inertia": ("hub", "0.02"),
    "root.torque": ("hub", "-5"),
    "root.stiffness": ("yielding", "400"),
    "root.damping": ("yielding", "0.5"),
    "root.profile": ("driven", "constant-speed root.spin_up_time=0"),
    "root.spin_rate": ("driven", "-3"),
    "root.spin_up_time": ("driven", "0.005"),
    "initial.angle": ("smooth", "0.473"),
    "initial.angular_velocity": ("smooth", "-1.1"),
    "initial.position": ("flying", "[0.1,0.3]"),
    "initial.velocity": ("flying", "[1,3]"),
    "initial.state": ("smooth", "equilibrium initial.angular_velocity=0"),
    "initial.place": ("plucked", "0.6"),
    "initial.deflection": ("plucked", "2e-4"),
    "initial.force": ("plucked", "1 initial.deflection=0"),
    "base.acceleration": ("shaken", "6"),
    "base.frequency": ("shaken", "150"),
    "base.sweep_rate": ("shaken", "1000"),
    "base.direction": ("shaken", "0.1"),
    "base.table": ("smooth", "[[0,2],[1,3]]"),
    "slope.enabled": ("anywhere", "true slope.origin=[0.6,0] slope.angle=1"),
    "slope.origin": ("smooth", "[0.6,0.001]"),
    "slope.angle": ("smooth", "1.001"),
    "slope.extent": ("smooth", "[0,0.35]"),
    "contact.enabled": ("free", "true"),
    "contact.where": ("spring", "anywhere contact.grid=1"),
    "contact.grid": ("anywhere", "5"),
    "contact.point": ("smooth", "0.99"),
    "contact.surface": ("section", "axis"),
    "contact.normal": ("smooth", "spring"),
    "contact.stiffness": ("spring", "2e6"),
    "contact.damping": ("spring", "0.1"),
    "contact.linear_damping": ("spring", "20"),
    "contact.impact": ("rigid", "routh"),
    "contact.restitution": ("rigid", "0.5"),
    "contact.point_inertia": ("smooth", "none"),
    "contact.residual_flexibility": ("spring", "false"),
    "contact.shortening": ("smooth", "false"),
    "contact.friction": ("rigid", "frictionless contact.mu_static=0.3 contact.mu_kinetic=0.3"),
    "contact.axial_flexibility": ("spring", "true"),
    "contact.mu_static": ("spring", "1.75"),
    "contact.mu_kinetic": ("coulomb", "1"),
    "contact.regularization": ("coulomb", "[0.01,2]"),
    "masses": ("smooth", "[{mass=0.1}]"),
    "masses.1.place": ("loaded", "0.7"),
    "masses.1.mass": ("loaded", "0.2"),
    "masses.1.inertia": ("loaded", "0.01"),
    "forces": ("smooth", "[{force=1}]"),
    "forces.1.place": ("loaded", "0.7"),
    "forces.1.force": ("loaded", "3"),
    "forces.1.frequency": ("loaded", "110"),
    "forces.1.sweep_rate": ("loaded", "1e4"),
    "forces.1.direction": ("loaded", "0.5"),
    "forces.2.table": ("loaded", "[[0,1],[1,3]]"),
    "obstacles": ("anywhere", f"[{TABLE}]"),
    "obstacles.1.kind": ("pegs", "side obstacles.1.radius=0 obstacles.1.origin=[0.6,0.1] obstacles.1.angle=0.3"),
    "obstacles.1.origin": ("anywhere", "[0.6,0.3003]"),
    "obstacles.2.angle": ("anywhere", "0.4712"),
    "obstacles.2.extent": ("anywhere", "[0,0.7]"),
    "obstacles.1.radius": ("anywhere", "0.0051"),
    "obstacles.1.stiffness": ("anywhere", "2e6"),
    "obstacles.2.bedding": ("anywhere", "1e5"),
    "obstacles.1.points": ("outline", "[[0.4,0.05],[0.8,0.1],[1.2,0.02]]"),
    "discretization.method": ("smooth", "fem"),
    "discretization.frame": ("exact", "mean-axis"),
    "discretization.kinetics": ("smooth", "full"),
    "discretization.modes": ("smooth", "3"),
    "discretization.elements": ("fem", "9"),
    "discretization.nodes": ("smooth", "[0,0.3,0.7,1] discretization.method=fem"),
    "discretization.grading": ("fem", "2"),
    "solver.scheme": ("smooth", "fixed-step"),
    "solver.tolerance": ("smooth", "1e-6"),
    "solver.free_step": ("fixed-step", "2e-5"),
    "solver.contact_step": ("alpha", "5e-6"),
    "solver.rho_infinity": ("alpha", "0.5"),
    "solver.baumgarte": ("rigid", "[20,500]"),
    "solver.baumgarte_form": ("rigid", "plain"),
    "solver.stick": ("fixed-step", "force"),
    "solver.output_interval": ("smooth", "5e-4"),
}
#: keys that no number of a run depends on: of pictures, and a file that is read once
NO_NUMBERS = {"title", "discretization.mesh"}

#: case, key and value without effect; "" where numbers that are recorded tell that the key is given
IDLE = [
    ("rigid", "root.inertia", "0.1"),
    ("hub", "root.spin_rate", "1"),
    ("smooth", "root.stiffness", "1"),
    ("smooth", "root.damping", "1"),
    ("held", "root.damping", "1"),
    ("held", "root.spin_rate", "1"),
    ("constant", "root.spin_up_time", "1"),
    ("driven", "initial.angular_velocity", "1"),
    ("resting", "initial.angular_velocity", "1"),
    ("resting", "initial.place", "0.5"),
    ("smooth", "initial.deflection", "0.1"),
    ("smooth", "initial.force", "1"),
    ("smooth", "base.frequency", "10"),
    ("smooth", "base.sweep_rate", "10"),
    ("smooth", "base.direction", "1"),
    ("free", "slope.extent", "[0,0.35]"),
    ("anywhere", "slope.angle", "1.1"),
    ("free", "contact.friction", "frictionless"),
    ("free", "contact.normal", "spring"),
    ("pegs", "contact.grid", "3"),
    ("smooth", "contact.grid", "3"),
    ("smooth", "contact.stiffness", "1e5"),
    ("smooth", "contact.damping", "0.1"),
    ("smooth", "contact.linear_damping", "20"),
    ("bed", "contact.stiffness", "1e5"),
    ("spring", "contact.restitution", "0.5"),
    ("spring", "contact.point_inertia", "none"),
    ("spring", "contact.impact", "routh"),
    ("smooth", "contact.residual_flexibility", "false"),
    ("nodal", "contact.residual_flexibility", "false"),
    ("exact", "contact.residual_flexibility", "false"),
    ("zeroth", "contact.shortening", "false"),
    ("smooth", "contact.mu_static", "0.4"),
    ("coulomb", "contact.mu_static", "1.8"),
    ("smooth", "contact.mu_kinetic", "0.2"),
    ("rigid", "contact.regularization", "[0.01,0.02]"),
    ("smooth", "masses.1.place", "0.5"),
    ("smooth", "forces.1.place", "0.5"),
    ("smooth", "forces.1.direction", "0.5"),
    ("smooth", "forces.1.frequency", "5"),
    ("smooth", "forces.1.sweep_rate", "5"),
    ("pegs", "obstacles.1.stiffness", "1e5"),
    ("pegs", "obstacles.1.angle", "0.1"),
    ("pegs", "obstacles.1.extent", "[0,1]"),
    ("pegs", "obstacles.1.bedding", "1e5"),
    ("pegs", "obstacles.1.points", "[[0.2,-1],[0.8,-1]]"),
    ("outline", "obstacles.1.extent", "[0,0.1]"),
    ("outline", "obstacles.1.radius", "0.1"),
    ("bed", "obstacles.1.stiffness", "1e5"),
    ("bed", "obstacles.1.radius", "0.1"),
    ("smooth", "discretization.elements", "8"),
    ("smooth", "discretization.grading", "2"),
    ("exact", "discretization.kinetics", "full"),
    ("exact", "discretization.modes", "3"),
    ("fixed-step", "solver.tolerance", "1e-5"),
    ("rigid", "solver.free_step", "1e-5"),
    ("free", "solver.baumgarte", "[20,500]"),
    ("rigid", "solver.rho_infinity", "0.5"),
    ("time-stepping", "solver.baumgarte", "[20,500]"),
    ("exact", "solver.baumgarte_form", "plain"),
    ("smooth spring", "solver.baumgarte", "[20,500]"),
    ("axial", "solver.baumgarte", "[20,500]"),
    ("alpha", "solver.baumgarte", "[20,500]"),
    ("alpha", "solver.stick", "force"),
    ("smooth", "solver.stick", "force"),
]
#: the same, where the history tells more about what is not touched: the clearance of obstacles, also of the
#: corners that a side with a bedding has not, and the contact point's own motion
IDLE_IN_CONTACT = [
    ("smooth", "obstacles", f"[{PEG}]"),
    ("anywhere", "contact.point", "0.9"),
    ("table", "obstacles.1.bedding", "1e5"),
]


def data_of(case: str, change: str = "") -> dict:
    data: dict = {}
    for item in [*CASES[case].split(), *change.split()]:
        apply_change(data, item)
    return data


def numbers(scenario: Scenario) -> dict[str, bytes]:
    """Bytes of all that a run records, from its summary the steps."""
    history = simulate(scenario)
    found = {name: np.asarray(variable.values).tobytes() for name, variable in history.data.variables.items()}
    return found | {"steps": bytes(history.summary["steps"])}


@pytest.fixture(scope="module")
def of_case():
    found: dict[str, dict[str, bytes]] = {}

    def get(case: str) -> dict[str, bytes]:
        if case not in found:
            found[case] = numbers(Scenario.from_dict(data_of(case)))
        return found[case]

    return get


def test_the_tables_know_every_key_and_every_rule():
    keys = set(key_schemas())
    keys |= {f"{name}.N.{key}" for name, model in item_models(Scenario).items() for key in schemas_of(model)}
    known = {key.replace(".1.", ".N.").replace(".2.", ".N.") for key in ACTS}
    assert known | NO_NUMBERS == keys
    assert not known & NO_NUMBERS
    named = {f"{rule.section}.{key}".lstrip(".") for rule in effects.RULES for key in rule.keys.split()}
    named |= {f"{items}.N.{rule.key}" for items, rules in effects.ITEM_RULES.items() for rule in rules}
    assert named <= keys


@pytest.mark.parametrize("key", ACTS)
def test_a_key_that_is_taken_changes_the_numbers(key, of_case):
    case, value = ACTS[key]
    assert numbers(Scenario.from_dict(data_of(case, f"{key}={value}"))) != of_case(case)


@pytest.mark.parametrize(("case", "key", "value"), [*IDLE, *IDLE_IN_CONTACT])
def test_a_key_that_is_refused_would_change_no_number(case, key, value, of_case, monkeypatch):
    data = data_of(case, f"{key}={value}")
    with refused_in_one_line("has no effect: ", start=f"{key} = "):
        Scenario.from_dict(data)
    monkeypatch.setattr(effects, "without_effect", lambda scenario: ())
    if (case, key, value) in IDLE:
        assert numbers(Scenario.from_dict(data)) == of_case(case)


# --- files that hold every key, cases, studies


def resolved(*changes: str) -> str:
    return Scenario.from_toml("", list(changes)).to_toml()


def test_a_resolved_file_of_before_loads_and_a_change_of_it_has_to_act():
    """It gives each obstacle a stiffness of 1e6 N/m, and a grid of 1, whether they act or not."""
    text = resolved("contact.where=anywhere", "slope.enabled=false", f"obstacles=[{PEG}]")
    text = text.replace('"contact.grid" = 16\n', "").replace('"obstacles.1.stiffness" = 1000000.0\n', "")
    old = text.replace("\ngrid = 16\n", "\ngrid = 1\n").replace(
        "\nstiffness = 1000000.0\n", "\nstiffness = 2e6\n", 1
    )
    found = Scenario.from_toml(old)
    assert (found.contact.stiffness, found.obstacles[0].stiffness) == (1e6, 1e6)
    assert not {"contact.stiffness", "contact.grid"} & set(found.given())
    # where they act they have the values of the file
    sprung = Scenario.from_toml(old, [SPRING, "slope.enabled=true", "initial.angle=1"])
    assert (sprung.contact.stiffness, sprung.contact.grid, sprung.obstacles[0].stiffness) == (2e6, 1, 1e6)
    with refused_in_one_line(start="contact.stiffness = 300000.0: has no effect: "):
        Scenario.from_toml(old, ["contact.stiffness=3e5"])


def test_what_follows_another_key_follows_it_from_a_resolved_file_too():
    text = resolved("contact.where=anywhere", SPRING, "contact.stiffness=1e5", "obstacles=[{origin=[0,-1]}]")
    again = Scenario.from_toml(text, ["contact.stiffness=2e5", FEM.split()[0], "discretization.modes=0"])
    assert (again.obstacles[0].stiffness, again.contact.grid) == (2e5, 32)


def test_a_case_gives_no_key_without_effect_and_leaves_out_what_loses_it():
    for name in builtin_names():
        assert Scenario.from_toml(builtin_text(name)) == Scenario.builtin(name)
    free = Scenario.builtin("shaken", ["base.acceleration=0", "contact.enabled=false"])
    assert not {"base.frequency", "contact.stiffness"} & set(free.given())
    with refused_in_one_line(start="base.frequency = 5.0: has no effect: "):
        Scenario.builtin("shaken", ["base.acceleration=0", "base.frequency=5"])


@pytest.mark.parametrize(
    ("changes", "grid"),
    [("", 16), (FEM, 16), (f"{FEM} discretization.modes=0 {SPRING}", 8), ("discretization.method=absolute", 32)],
)
def test_the_grid_follows_the_mesh_and_is_said_at_once(changes, grid):
    free = "" if SPRING in changes or "absolute" not in changes else SPRING
    given = Scenario.from_toml("", [*changes.split(), *free.split(), "contact.where=anywhere"])
    assert given.contact.grid == grid == len(given.beam_points)
    (line,) = given.taken_defaults
    assert line.startswith(f"contact.grid = {grid} is not given: ")
    assert given.replace(contact__grid=1).taken_defaults == []
    assert eval(repr(given), vars(sections) | {"Scenario": Scenario}) == given


def test_a_run_says_which_grid_it_takes(tmp_path, cli):
    keys = ["--set", "contact.where=anywhere", "--set", "end_time=1e-3", "--out", tmp_path / "out"]
    assert "note: contact.grid = 16 is not given" in cli("run", "paper", *keys)[2]
    assert "note:" not in cli("run", "paper", *keys, "--set", "contact.grid=1")[2]


def test_a_history_says_which_grid_it_took():
    keys = ["contact.where=anywhere", "end_time=1e-3"]
    for changes, said in (([], True), (["contact.grid=1"], False)):
        history = simulate(Scenario.builtin("paper", [*keys, *changes]))
        for text in (repr(history), history._repr_html_()):
            assert ("contact.grid = 16 is not given" in text) is said


SWEEP = """
scenario = "paper"
quantities = ["impulse"]
[[axes]]
key = "contact.stiffness"
values = [1e6, 2e6]
"""


def test_studies_over_a_key_without_effect_are_refused_at_once(tmp_path):
    (tmp_path / "sweep.toml").write_text(SWEEP)
    with refused_in_one_line("sweep.toml: contact.stiffness = 1000000.0: has no effect: a rigid stop has none"):
        load_plan(tmp_path / "sweep.toml")
    with refused_in_one_line(
        "has no effect: a rigid stop has none", start="--vary contact.stiffness = 1000000.0: "
    ):
        parameters_of(["contact.stiffness"], [Scenario()])
    mixed = SWEEP + "[[axes]]\nkey = 'contact.normal'\nvalues = ['rigid', 'spring']\n"
    (tmp_path / "sweep.toml").write_text(mixed)
    assert len(load_plan(tmp_path / "sweep.toml").impossible) == 1


def test_obstacles_push_with_the_stiffness_of_contact():
    """Their force over their depth is it, on pegs and on a side."""
    soft = Scenario.from_dict(
        data_of("anywhere", "contact.stiffness=1e5 contact.residual_flexibility=false end_time=0.012")
    )
    history = simulate(soft)
    depth, force = -history["contact_gap"].values, history["contact_lambda_n"].values
    closed = force > 0.0
    assert {int(k) for k in history["contact_obstacle"].values[closed.any(axis=0)]} == {1, 2}
    np.testing.assert_allclose(force[closed], 1e5 * depth[closed], rtol=1e-9)
    own = simulate(soft.replace(obstacles__1__stiffness=3e5))
    push = own["contact_lambda_n"].values[:, own["contact_obstacle"].values == 1]
    into = -own["contact_gap"].values[:, own["contact_obstacle"].values == 1]
    np.testing.assert_allclose(push[push > 0.0], 3e5 * into[push > 0.0], rtol=1e-9)

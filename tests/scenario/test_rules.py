"""Rules between keys: each refuses what it should, in its own words."""

from __future__ import annotations

import re

import pytest

from oblique_impact import InputError, Scenario
from oblique_impact.scenario.rules import RULES
from tests.scenario import test_plugins  # noqa: F401  registers the base motion "test-spin-up"

FEM = "discretization.method=fem"
NODAL = f"{FEM} discretization.modes=0"
MESH = f"{FEM} discretization.nodes=[0,0.5,1]"
DRIVEN = "root.kind=driven"
OWN = f"{DRIVEN} root.profile=test-spin-up"
ON_HUB = 'only with root.kind = "hub" (it is "pin")'
ON_DRIVEN = 'only with root.kind = "driven" (it is "pin")'
OWN_NUMBERS = "the numbers of this profile are in parameters.profile"
UNIFORM = 'the modal method knows uniform beams only; discretization.method = "fem" takes'
NEW_TABLES = "should end at x = beam.length = 2.0, not at 1.0; a new length needs new tables"
NODAL_ROOT = "the full nodal model is for a pin or a hub of radius 0; keep modes"
MEAN_AXIS = 'the mean-axis frame is for a pin or a hub of radius 0; use "tangent" for this root'
MASSLESS = "contact.point_inertia=none"
NO_IMPACTS = 'should be "kept" with contact.restitution or contact.impact: "none" has no impacts'
INSTEAD = "or keep modes: discretization.modes >= 1"
MARCHED = "the full nodal model (discretization.modes = 0) is marched"

RECTANGLE = "beam.section.shape=rectangle beam.section.width=0.02 beam.section.height=0.01"
BY_SHAPE = 'follows from beam.section.shape = "rectangle"; give one of the two'
BY_MATERIAL = 'follows from beam.material = "steel"; give one of the two'
#: a size of another shape for each shape, and one that a shape lacks
WRONG_SIZES = [
    ("width", "circle", "diameter"),
    ("height", "tube", "diameter, thickness"),
    ("diameter", "rectangle", "width, height"),
    ("thickness", "circle", "diameter"),
    ("flange_thickness", "tube", "diameter, thickness"),
    ("web_thickness", "rectangle", "width, height"),
]
LACKING = [
    ("width", "rectangle"),
    ("height", "rectangle"),
    ("diameter", "circle"),
    ("thickness", "tube"),
    ("flange_thickness", "i-beam"),
    ("web_thickness", "i-beam"),
]
WHOLE = {
    "rectangle": {"width": 0.02, "height": 0.01},
    "circle": {"diameter": 0.02},
    "tube": {"diameter": 0.02, "thickness": 0.002},
    "i-beam": {"width": 0.02, "height": 0.04, "flange_thickness": 0.002, "web_thickness": 0.002},
}


def shaped(shape: str, **sizes: object) -> str:
    given = {"shape": shape, **WHOLE[shape], **sizes}
    return " ".join(f"beam.section.{key}={value}" for key, value in given.items() if value is not None)


#: key that is refused, changes of the paper's case, what is allowed
ABSOLUTE = "discretization.method=absolute contact.normal=spring"
EXACT = "the beam in absolute coordinates"
REFUSED = [
    ("root.inertia", "root.inertia=1", ON_HUB),
    ("root.inertia", f"{DRIVEN} root.inertia=1", 'only with root.kind = "hub" (it is "driven")'),
    ("root.torque", "root.torque=2", ON_HUB),
    ("root.spin_rate", "root.spin_rate=1", ON_DRIVEN),
    ("root.spin_rate", "root.kind=hub root.spin_rate=1", 'only with root.kind = "driven" (it is "hub")'),
    ("root.spin_up_time", "root.spin_up_time=1", ON_DRIVEN),
    ("root.profile", "root.profile=constant-speed", ON_DRIVEN),
    ("root.hub_radius", "root.hub_radius=0.1", 'a pin has radius 0; use root.kind = "hub" or "driven"'),
    ("root.spin_up_time", f"{DRIVEN} root.profile=spin-up", "should be greater than 0 for a spin-up"),
    ("root.spin_rate", f"{OWN} root.spin_rate=1", OWN_NUMBERS),
    ("root.spin_up_time", f"{OWN} root.spin_up_time=1", OWN_NUMBERS),
    (
        "initial.angular_velocity",
        f"{DRIVEN} initial.angular_velocity=1",
        "a driven root prescribes its own speed; leave it 0",
    ),
    ("beam.area", f"{RECTANGLE} beam.area=1e-4", BY_SHAPE),
    ("beam.second_moment", f"{RECTANGLE} beam.second_moment=1e-8", BY_SHAPE),
    ("beam.outer_fibre", f"{RECTANGLE} beam.outer_fibre=0.01", BY_SHAPE),
    ("beam.density", "beam.material=steel beam.density=7800.0", BY_MATERIAL),
    ("beam.youngs_modulus", "beam.material=steel beam.youngs_modulus=2e11", BY_MATERIAL),
    *[
        (
            f"beam.section.{size}",
            shaped(shape, **{size: 0.001}),
            f'is no size of beam.section.shape = "{shape}", which takes {sizes}',
        )
        for size, shape, sizes in WRONG_SIZES
    ],
    (
        "beam.section.width",
        "beam.section.width=1",
        'is no size of beam.section.shape = "", which takes none; name a shape',
    ),
    *[
        (
            f"beam.section.{size}",
            shaped(shape, **{size: None}),
            f'should be greater than 0 for beam.section.shape = "{shape}"',
        )
        for size, shape in LACKING
    ],
    (
        "beam.section.shape",
        shaped("tube", thickness=0.011),
        "these sizes are not possible: thickness is more than half of diameter",
    ),
    (
        "beam.section.shape",
        shaped("i-beam", flange_thickness=0.021),
        "these sizes are not possible: flange_thickness is more than half of height",
    ),
    (
        "beam.section.shape",
        shaped("i-beam", web_thickness=0.021),
        "these sizes are not possible: web_thickness is more than width",
    ),
    *[
        (
            f"beam.section.{size}",
            f"{FEM} beam.length=2 {shaped(shape, **{size: f'[[0,{value}],[1,{value}]]'})}",
            NEW_TABLES,
        )
        for shape, sizes in WHOLE.items()
        for size, value in sizes.items()
    ],
    *[
        (f"beam.section.{size}", shaped(shape, **{size: f"[[0,{value}],[1,{value}]]"}), f"{UNIFORM} tables")
        for shape, sizes in WHOLE.items()
        for size, value in sizes.items()
    ],
    ("beam.outer_fibre", f"{FEM} beam.length=2 beam.outer_fibre=[[0,0.01],[1,0.01]]", NEW_TABLES),
    ("beam.area", f"{FEM} beam.length=2 beam.area=[[0,1e-4],[1,2e-4]]", NEW_TABLES),
    ("beam.second_moment", f"{FEM} beam.length=2 beam.second_moment=[[0,1e-8],[1,2e-8]]", NEW_TABLES),
    ("beam.area", "beam.area=[[0,1e-4],[1,2e-4]]", f"{UNIFORM} tables"),
    ("beam.second_moment", "beam.second_moment=[[0,1e-8],[1,2e-8]]", f"{UNIFORM} tables"),
    ("beam.tip_mass", "beam.tip_mass=0.1", f"{UNIFORM} a tip mass"),
    (
        "slope.extent",
        "slope.extent=[1,0]",
        "should be [first, last] in m with first less than last, or [] without ends",
    ),
    (
        "contact.restitution",
        "contact.normal=spring contact.restitution=0.5",
        "only with a rigid stop; a spring has contact.damping",
    ),
    (
        "contact.impact",
        "contact.normal=spring contact.impact=routh",
        'only with contact.normal = "rigid": others have no impacts',
    ),
    ("contact.point", "contact.point=1.5", "should be on the beam, at most beam.length = 1.0"),
    ("contact.point", "contact.point=1e-6", "should be at least 0.001 beam.length = 0.001"),
    ("contact.mu_static", "contact.mu_static=0.2", "should be at least contact.mu_kinetic = 0.3"),
    (
        "contact.regularization",
        "contact.regularization=[0.01,0.01]",
        "should be [v0, v1] in m/s with v0 less than v1",
    ),
    (
        "initial.angle",
        "initial.angle=0.2",
        "the contact point starts 0.0212064 m below the slope; the gap should be at least 0",
    ),
    (
        "contact.point_inertia",
        f"{FEM} {MASSLESS} beam.tip_mass=0.1",
        'should be "kept": beam.tip_mass is the inertia of this contact point',
    ),
    ("contact.point_inertia", f"{MASSLESS} contact.restitution=0.5", NO_IMPACTS),
    ("contact.point_inertia", f"{MASSLESS} contact.impact=routh", NO_IMPACTS),
    (
        "contact.surface",
        f"{MASSLESS} contact.surface=section",
        'should be "axis" with contact.point_inertia = "none": such a point gives way across the axis only',
    ),
    (
        "solver.scheme",
        f"{MASSLESS} solver.scheme=fixed-step",
        'should be "event" or "generalized-alpha" with contact.point_inertia = "none"',
    ),
    (
        "contact.point",
        f"{NODAL} {MASSLESS} contact.point=0.5",
        'should be beam.length in the full nodal model with contact.point_inertia = "none"',
    ),
    ("discretization.modes", f"{NODAL} {DRIVEN}", NODAL_ROOT),
    ("discretization.modes", f"{NODAL} root.kind=hub root.hub_radius=0.1", NODAL_ROOT),
    (
        "solver.scheme",
        f"{NODAL} solver.scheme=event",
        f'{MARCHED} by "generalized-alpha" only; leave this key out, {INSTEAD}',
    ),
    (
        "discretization.frame",
        f"{NODAL} discretization.frame=tangent",
        f'{MARCHED} in the "mean-axis" frame only; leave this key out, {INSTEAD}',
    ),
    (
        "discretization.kinetics",
        f"{NODAL} discretization.kinetics=full",
        f'the full nodal model is "first-order"; {INSTEAD}',
    ),
    (
        "beam.modal_damping_ratio",
        f"{NODAL} beam.modal_damping_ratio=0.1",
        f"the full nodal model has no modes to damp; use beam.kelvin_voigt, {INSTEAD}",
    ),
    (
        "discretization.grading",
        "discretization.grading=2",
        'the modal method has no mesh; use 1.0, or discretization.method = "fem"',
    ),
    ("discretization.frame", f"{DRIVEN} discretization.frame=mean-axis", MEAN_AXIS),
    ("discretization.frame", "root.kind=hub root.hub_radius=0.1 discretization.frame=mean-axis", MEAN_AXIS),
    ("discretization.modes", "discretization.modes=0", "should be 1 to 100 for the modal method"),
    (
        "discretization.elements",
        f"{FEM} discretization.modes=1 discretization.elements=1 contact.point=0.5",
        "should be at least 2 with a contact point inside the span",
    ),
    (
        "discretization.modes",
        f"{FEM} discretization.modes=5 discretization.elements=2",
        "should be at most the 4 modes of the mesh",
    ),
    (
        "discretization.mesh",
        "discretization.mesh=beam.msh",
        "is read with a scenario file or by --set; give discretization.nodes",
    ),
    (
        "discretization.nodes",
        "discretization.nodes=[0,0.5,1]",
        'only with discretization.method = "fem" or "absolute"',
    ),
    (
        "contact.normal",
        "discretization.method=absolute",
        f'{EXACT} meets an elastic stop only: contact.normal = "spring", as stiff as need be',
    ),
    (
        "contact.friction",
        f"{ABSOLUTE} contact.friction=modified-coulomb",
        f'{EXACT} takes "frictionless" or "hybrid"',
    ),
    (
        "contact.shortening",
        f"{ABSOLUTE} contact.shortening=false",
        f"{EXACT} has no contact point without its shortening; leave this key out",
    ),
    *(
        (
            f"beam.{key}",
            f"{ABSOLUTE} beam.{key}=0.1",
            f"{EXACT} has no frame or modes that would move without it; use beam.kelvin_voigt",
        )
        for key in ("mass_proportional", "modal_damping_ratio")
    ),
    (
        "root.hub_radius",
        f"{ABSOLUTE} root.kind=hub root.hub_radius=0.1",
        f"{EXACT} turns with a hub of radius 0; a driven root may have a radius; "
        'discretization.method = "fem" takes it',
    ),
    (
        "solver.scheme",
        f"{ABSOLUTE} solver.scheme=event",
        f'{EXACT} is marched by "energy-consistent" only, which is the default',
    ),
    (
        "solver.scheme",
        "solver.scheme=energy-consistent",
        'only with discretization.method = "absolute"',
    ),
    (
        "discretization.elements",
        f"{MESH} discretization.elements=3",
        "the mesh has 2 elements; leave this key out",
    ),
    (
        "discretization.grading",
        f"{MESH} discretization.grading=2",
        "the mesh is graded as it is; leave this key out",
    ),
    (
        "discretization.nodes",
        f"{MESH} beam.length=2 contact.point=1",
        "should go from 0 to beam.length = 2.0, not to 1.0",
    ),
    ("discretization.nodes", f"{FEM} discretization.nodes=[0,0.5,0.5,1]", "should ascend"),
    (
        "discretization.nodes",
        f"{MESH} contact.point=0.7",
        "none of them is at contact.point = 0.7; the contact needs one there",
    ),
    (
        "solver.output_interval",
        "solver.output_interval=1e-9",
        "gives 1e+09 samples of 333 values; at most 500000000 values fit into a history",
    ),
    ("solver.free_step", "solver.scheme=fixed-step solver.free_step=1e-10", "gives more than 1000000000 steps"),
    (
        "solver.contact_step",
        "solver.scheme=generalized-alpha solver.contact_step=1e-12",
        "gives more than 1000000000 steps",
    ),
]


@pytest.mark.parametrize(
    ("key", "changes", "allowed"), REFUSED, ids=[f"{number}-{row[0]}" for number, row in enumerate(REFUSED)]
)
def test_a_rule_names_the_key_its_value_and_what_is_allowed(key, changes, allowed):
    with pytest.raises(InputError) as error:
        Scenario.from_toml("", changes.split())
    assert re.fullmatch(rf"{re.escape(key)} = [^\n]+: {re.escape(allowed)}", str(error.value)), error.value


FLAT = "slope.angle=0 initial.angle=0"
RAISED = "slope.origin=[0.0,{}]"


@pytest.mark.parametrize(
    ("changes", "taken", "refused"),
    [
        ("contact.point={} discretization.method=fem", "0.0011", "0.0009"),
        # a beam along the x axis, and a slope below it, on it, or above it
        (f"{FLAT} {RAISED}", "-1e-9", "1e-9"),
        (f"{FLAT} {RAISED}", "1e-13", "2e-12"),
        (f"{FEM} discretization.nodes=[0,{{}},1] contact.point=0.7", "0.7000000001", "0.70001"),
    ],
)
def test_places_are_refused_from_their_bounds_on(changes, taken, refused):
    Scenario.from_toml("", changes.format(taken).split())
    with pytest.raises(InputError):
        Scenario.from_toml("", changes.format(refused).split())


def test_every_rule_is_among_them():
    for rule in RULES:
        words = ".*".join(re.escape(part) for part in re.split(r"\{.*?\}", rule.allowed))
        for key in rule.keys.split():
            assert any(key == name and re.fullmatch(words, allowed) for name, _, allowed in REFUSED), (key, words)

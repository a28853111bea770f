"""Keys that exclude each other: each is refused by its name, with its value and what is allowed."""

from __future__ import annotations

import re

import pytest

from oblique_impact import InputError, Scenario

FEM = "discretization.method=fem"
NODAL = f"{FEM} discretization.modes=0"
MESH = f"{FEM} discretization.nodes=[0,0.5,1]"
DRIVEN = "root.kind=driven"
HUB = "root.kind=hub root.hub_radius=0.1"
MASSLESS = "contact.point_inertia=none"
FLEXIBLE = "contact.axial_flexibility=true contact.normal=spring"
ABSOLUTE = "discretization.method=absolute contact.normal=spring"
SHAPED = "beam.section.shape"
ANYWHERE = "contact.where=anywhere"
ALONE = f"{ANYWHERE} slope.enabled=false initial.angle=0"
RECTANGLE = f"{SHAPED}=rectangle beam.section.width=0.02 beam.section.height=0.01"
I_BEAM = f"{SHAPED}=i-beam beam.section.width=0.02 beam.section.height=0.04"

#: key that is refused, changes of the paper's case, words of what is allowed
STEPPED = "solver.scheme=time-stepping"
REFUSED = [
    ("root.inertia", "root.inertia=1", 'only with root.kind = "hub"'),
    ("root.torque", f"{DRIVEN} root.torque=2", 'only with root.kind = "hub"'),
    ("root.stiffness", "root.stiffness=1", 'only with root.kind = "hub" or "driven"'),
    ("root.damping", "root.damping=1", 'only with root.kind = "hub" or "driven"'),
    ("root.damping", f"{DRIVEN} root.damping=1", "a rigid clamp does not turn: only with root.stiffness"),
    ("root.spin_rate", "root.spin_rate=1", 'only with root.kind = "driven"'),
    ("root.spin_up_time", "root.spin_up_time=1", 'only with root.kind = "driven"'),
    ("root.profile", "root.kind=hub root.profile=constant-speed", 'only with root.kind = "driven"'),
    ("root.hub_radius", "root.hub_radius=0.1", "a pin has radius 0"),
    ("root.spin_up_time", f"{DRIVEN} root.profile=spin-up", "greater than 0 for a spin-up"),
    ("initial.angular_velocity", f"{DRIVEN} initial.angular_velocity=1", "prescribes its own speed"),
    ("beam.area", f"{RECTANGLE} beam.area=1e-4", 'follows from beam.section.shape = "rectangle"'),
    ("beam.second_moment", f"{RECTANGLE} beam.second_moment=1e-8", "give one of the two"),
    ("beam.outer_fibre", f"{RECTANGLE} beam.outer_fibre=0.01", "give one of the two"),
    ("beam.density", "beam.material=steel beam.density=7800.0", 'follows from beam.material = "steel"'),
    ("beam.youngs_modulus", "beam.material=steel beam.youngs_modulus=2e11", "give one of the two"),
    ("beam.section.diameter", f"{RECTANGLE} beam.section.diameter=0.1", "which takes width, height"),
    ("beam.section.width", "beam.section.width=1", "which takes none; name a shape"),
    ("beam.section.diameter", f"{SHAPED}=circle", "greater than 0"),
    ("beam.section.web_thickness", f"{I_BEAM} beam.section.flange_thickness=0.002", "greater than 0"),
    (
        SHAPED,
        f"{SHAPED}=tube beam.section.diameter=0.02 beam.section.thickness=0.011",
        "thickness is more than half of diameter",
    ),
    (
        SHAPED,
        f"{I_BEAM} beam.section.flange_thickness=0.002 beam.section.web_thickness=0.021",
        "web_thickness is more than width",
    ),
    ("beam.area", f"{FEM} beam.length=2 beam.area=[[0,1e-4],[1,2e-4]]", "should end at x = beam.length = 2.0"),
    ("beam.outer_fibre", f"{FEM} beam.length=2 beam.outer_fibre=[[0,0.01],[1,0.01]]", "should end at x"),
    ("beam.section.height", f"{FEM} beam.length=2 {RECTANGLE[:-4]}[[0,0.01],[1,0.01]]", "should end at x"),
    ("beam.section.height", f"{RECTANGLE[:-4]}[[0,0.01],[1,0.01]]", "uniform beams only"),
    ("beam.second_moment", "beam.second_moment=[[0,1e-8],[1,2e-8]]", "uniform beams only"),
    ("slope.extent", "slope.extent=[1,0]", "first less than last"),
    ("contact.axial_flexibility", f"{FLEXIBLE} {ABSOLUTE}", "stretches itself"),
    ("contact.friction", f"{FLEXIBLE} contact.friction=modified-coulomb", 'should be "hybrid"'),
    (
        "contact.normal",
        "contact.axial_flexibility=true solver.scheme=fixed-step",
        'a rigid stop takes it with solver.scheme = "event" or "time-stepping"',
    ),
    ("contact.impact", "contact.axial_flexibility=true contact.impact=routh", 'should be "newton"'),
    (
        "contact.axial_flexibility",
        f"{FLEXIBLE} contact.damping=0.1 solver.scheme=generalized-alpha",
        "the end of slip over a damped stop",
    ),
    (
        "contact.axial_flexibility",
        f"{FLEXIBLE} beam.kelvin_voigt=1e-5 solver.scheme=fixed-step",
        "the end of slip over a damped stop",
    ),
    ("solver.stick", f"{FLEXIBLE} solver.scheme=fixed-step solver.stick=force", 'should be "projection"'),
    ("base.frequency", "base.acceleration=2", "greater than 0 with base.acceleration"),
    ("base.acceleration", "base.table=[[0,1],[1,2]] base.acceleration=2", "give one of the two"),
    ("base.table", "base.table=[[0,1],[0,2]]", "strictly ascending times"),
    ("base.table", "base.table=[[0,1]]", "two or more rows"),
    ("contact.restitution", "contact.normal=spring contact.restitution=0.5", "a spring has contact.damping"),
    ("contact.impact", "contact.normal=spring contact.impact=routh", 'only with contact.normal = "rigid"'),
    ("contact.point", "contact.point=1.5", "at most beam.length = 1.0"),
    ("contact.point", "contact.point=1e-6", "at least 0.001 beam.length"),
    ("contact.mu_static", "contact.mu_static=0.2", "at least contact.mu_kinetic = 0.3"),
    ("contact.regularization", "contact.regularization=[0.01,0.01]", "v0 less than v1"),
    ("initial.angle", "initial.angle=0.2", "the contact point starts 0.0212064 m below the slope"),
    ("contact.point_inertia", f"{FEM} {MASSLESS} beam.tip_mass=0.1", "beam.tip_mass is the inertia"),
    ("contact.point_inertia", f"{MASSLESS} masses=[{{mass=0.1}}]", "one of [[masses]] is the inertia of this"),
    (
        "contact.point_inertia",
        f"{NODAL} {MASSLESS} solver.scheme=time-stepping masses=[{{place=0.3,mass=0.1}}]",
        "of a node",
    ),
    ("masses.1.place", "masses=[{place=1.2,mass=0.1}]", "should be on the beam, at most beam.length = 1.0"),
    ("masses.2.place", "masses=[{mass=0.1},{place=0,mass=0.1}]", "should be greater than 0"),
    ("masses.1.mass", "masses=[{mass=-1}]", "greater than or equal to 0"),
    ("masses.1.inertia", "masses=[{inertia=-1}]", "greater than or equal to 0"),
    ("masses.1.weight", "masses=[{weight=1}]", "unknown key"),
    ("masses", "masses=3", "a list of masses; in a file each is a table [[masses]]"),
    ("forces.1.place", "forces=[{place=1.2,force=1}]", "should be on the beam, at most beam.length = 1.0"),
    ("forces.1.frequency", "forces=[{frequency=-2,force=1}]", "greater than or equal to 0"),
    ("forces.1.table", "forces=[{table=[[0,1],[0,2]]}]", "strictly ascending times"),
    ("forces.1.table", "forces=[{table=[[0,1]]}]", "two or more rows"),
    ("forces.1.force", "forces=[{force=1,table=[[0,1],[1,2]]}]", "give one of the two"),
    ("forces.1.sweep_rate", "forces=[{sweep_rate=1,table=[[0,1],[1,2]]}]", "give one of the two"),
    ("forces.1.direction", "forces=[{force=1,direction=45}]", '; for degrees write "45 deg"'),
    ("forces.1.direction", "forces=[{force=1,direction='along'}]", "a number in rad"),
    ("forces.1.direction", "forces=[{force=1,direction=true}]", '"across", or an angle'),
    ("contact.point_inertia", f"{MASSLESS} contact.restitution=0.5", '"none" has no impacts'),
    ("contact.point_inertia", f"{MASSLESS} contact.impact=routh", '"none" has no impacts'),
    ("contact.point", f"{NODAL} {MASSLESS} contact.point=0.5", "should be beam.length"),
    ("solver.scheme", f"{NODAL} solver.scheme=event", 'by "generalized-alpha" or "time-stepping" only'),
    ("discretization.frame", f"{NODAL} discretization.frame=tangent", 'should be "mean-axis"'),
    ("discretization.frame", f"{NODAL} {DRIVEN} discretization.frame=mean-axis", "a pin or a hub of radius 0"),
    ("discretization.kinetics", f"{NODAL} discretization.kinetics=full", 'is "first-order"'),
    ("beam.modal_damping_ratio", f"{NODAL} beam.modal_damping_ratio=0.1", "no modes to damp"),
    ("contact.point_inertia", "discretization.method=absolute contact.point_inertia=none", "have inertia"),
    ("contact.shortening", f"{ABSOLUTE} contact.shortening=false", "leave this key out"),
    ("beam.mass_proportional", f"{ABSOLUTE} beam.mass_proportional=0.1", "use beam.kelvin_voigt"),
    ("beam.modal_damping_ratio", f"{ABSOLUTE} beam.modal_damping_ratio=0.1", "use beam.kelvin_voigt"),
    ("solver.scheme", f"{ABSOLUTE} solver.scheme=event", 'by "time-stepping" only'),
    ("discretization.grading", "discretization.grading=2", "the modal method has no mesh"),
    ("discretization.frame", f"{DRIVEN} discretization.frame=mean-axis", 'use "tangent" for this root'),
    ("discretization.modes", "discretization.modes=0", "should be 1 to 100"),
    (
        "discretization.elements",
        f"{FEM} discretization.modes=1 discretization.elements=1 contact.point=0.5",
        "at least 2 with a contact point inside the span",
    ),
    ("discretization.modes", f"{FEM} discretization.modes=5 discretization.elements=2", "at most the 4 modes"),
    ("discretization.mesh", "discretization.mesh=beam.msh", "is read with a scenario file or by --set"),
    ("discretization.nodes", "discretization.nodes=[0,0.5,1]", 'method = "fem" or "absolute"'),
    ("discretization.elements", f"{MESH} discretization.elements=3", "the mesh has 2 elements"),
    ("discretization.grading", f"{MESH} discretization.grading=2", "leave this key out"),
    (
        "discretization.nodes",
        f"{MESH} beam.length=2 contact.point=1",
        "go from 0 to beam.length = 2.0, not to 1.0",
    ),
    ("discretization.nodes", f"{FEM} discretization.nodes=[0,0.5,0.5,1]", "ascending"),
    ("discretization.nodes", f"{MESH} contact.point=0.7", "none of them is at contact.point = 0.7"),
    ("obstacles", "obstacles=[{kind='point'}]", 'only with contact.where = "anywhere"'),
    ("contact.grid", "contact.grid=2", 'only with contact.where = "anywhere"'),
    ("slope.enabled", "slope.enabled=false", "contact.enabled = false is free motion"),
    ("contact.grid", f"{ANYWHERE} contact.grid=1025", "less than or equal to 1024"),
    ("contact.impact", f"{ANYWHERE} solver.scheme=time-stepping contact.impact=routh", 'should be "newton"'),
    ("contact.point_inertia", f"{MASSLESS} contact.normal=spring", "have a residual flexibility without inertia"),
    ("contact.shortening", f"{ANYWHERE} contact.shortening=false", "should be true"),
    ("discretization.elements", f"{ABSOLUTE} {ANYWHERE} contact.grid=8 discretization.elements=6", "at least 8"),
    (
        "discretization.nodes",
        f"{ABSOLUTE} {ANYWHERE} contact.grid=4 discretization.nodes=[0,0.3,0.5,0.75,1]",
        "0.25 m",
    ),
    ("solver.scheme", "solver.scheme=generalized-alpha", 'should be "event" or "time-stepping" with a rigid stop'),
    ("solver.scheme", f"{NODAL} solver.scheme=generalized-alpha", 'should be "time-stepping" with a rigid stop'),
    ("solver.scheme", f"{NODAL} {ANYWHERE} solver.scheme=generalized-alpha", 'should be "time-stepping"'),
    ("solver.scheme", f"{MASSLESS} {ANYWHERE} solver.scheme=generalized-alpha", 'should be "event" or "time-st'),
    ("solver.scheme", f"{ANYWHERE} solver.scheme=fixed-step", 'should be "event"'),
    (
        "contact.point_inertia",
        f"{STEPPED} {ANYWHERE} {MASSLESS} {FEM} beam.tip_mass=0.1",
        "beam.tip_mass is the inertia",
    ),
    (
        "contact.surface",
        f"{FEM} {ANYWHERE} contact.surface=section beam.outer_fibre=[[0,0.01],[1,0.02]]",
        "a depth that changes along the beam",
    ),
    ("contact.enabled", f"{ANYWHERE} slope.enabled=false", "write contact.enabled = false"),
    ("initial.angle", f"{ANYWHERE} contact.grid=1 initial.angle=0.2", "at 1 m starts 0.0212064 m below the slope"),
    (
        "initial.angle",
        f"{ANYWHERE} initial.angle=0 slope.origin=[0.5,0] slope.angle=0 slope.extent=[0,9]",
        "an end of the slope lies on the beam's axis",
    ),
    ("obstacles.1.radius", f"{ANYWHERE} obstacles=[{{radius=0.1}}]", 'only with kind = "point"'),
    (
        "obstacles.1.angle",
        f"{ANYWHERE} obstacles=[{{kind='point',origin=[0.5,0.1],angle=0.1}}]",
        'only with kind = "side"',
    ),
    ("obstacles.1.extent", f"{ANYWHERE} obstacles=[{{extent=[1,0]}}]", "first less than last"),
    ("obstacles.2.radius", f"{ANYWHERE} obstacles=[{{}},{{radius=-1}}]", "greater than or equal to 0"),
    ("obstacles.1.radus", f"{ANYWHERE} obstacles=[{{radus=1}}]", "did you mean radius?"),
    (
        "obstacles.1.origin",
        f"{ALONE} obstacles=[{{kind='point',origin=[0.5,0.01],radius=0.02}}]",
        "0.01 m from the beam's axis",
    ),
    ("obstacles.1.origin", f"{ALONE} obstacles=[{{kind='point',origin=[0.5,0]}}]", "lies on the beam's axis"),
    (
        "obstacles.1.origin",
        f"{ALONE} obstacles=[{{origin=[0,0.01]}}] contact.grid=1",
        "at 1 m starts 0.01 m below obstacle 1",
    ),
    ("obstacles.1.origin", f"{ALONE} obstacles=[{{extent=[0.5,2]}}]", "an end of obstacle 1 lies on"),
    (
        "obstacles.1.origin",
        f"{ALONE} obstacles=[{{origin=[0,-0.01]}}] contact.grid=4 contact.surface=section beam.outer_fibre=0.02",
        "at 0.25 m starts 0.01 m below obstacle 1",
    ),
    ("solver.output_interval", "solver.output_interval=1e-9", "1e+09 samples of 333 values"),
    ("solver.free_step", "solver.scheme=fixed-step solver.free_step=1e-10", "more than 1000000000 steps"),
    ("solver.contact_step", "solver.scheme=time-stepping solver.contact_step=1e-12", "more than 1000000000"),
]


@pytest.mark.parametrize(("key", "changes", "words"), REFUSED, ids=[f"{n}-{r[0]}" for n, r in enumerate(REFUSED)])
def test_a_key_that_does_not_fit_is_named_with_its_value(key, changes, words):
    with pytest.raises(InputError) as error:
        Scenario.from_toml("", changes.split(), name="")
    assert re.fullmatch(rf"{re.escape(key)} = [^\n]+: [^\n]*{re.escape(words)}[^\n]*", str(error.value)), (
        error.value
    )


FLAT = "slope.angle=0 initial.angle=0"


@pytest.mark.parametrize(
    ("changes", "taken", "refused"),
    [
        (f"contact.point={{}} {FEM}", "0.0011", "0.0009"),
        # a beam along the x axis, and a slope below it, on it, or above it
        (f"{FLAT} slope.origin=[0.0,{{}}]", "-1e-9", "1e-9"),
        (f"{FLAT} slope.origin=[0.0,{{}}]", "1e-13", "2e-12"),
        # a peg of radius 0.1 below the beam, and a corner
        (f"{ALONE} obstacles=[{{{{kind='point',origin=[0.5,{{}}],radius=0.1}}}}]", "-0.1", "-0.0999"),
        (f"{ALONE} obstacles=[{{{{kind='point',origin=[0.5,{{}}]}}}}]", "-2e-12", "-1e-13"),
        (f"{FEM} discretization.nodes=[0,{{}},1] contact.point=0.7", "0.7000000001", "0.70001"),
    ],
)
def test_places_are_refused_from_their_bounds_on(changes, taken, refused):
    Scenario.from_toml("", changes.format(taken).split())
    with pytest.raises(InputError):
        Scenario.from_toml("", changes.format(refused).split())

"""Chains, cables and rods with known answers: energy, contact between segments, damping, eigenvalues, mass."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import cos, log, radians, sin
from typing import Any

import numpy as np

from peers.exudyn_cables import load
from peers.problems import Question

#: a chain of links (m, kg) without friction or damping, straight and at rest at an angle to hanging, let go
LINKS, LENGTH, MASS, GRAVITY = 5, 0.1, 0.1, 9.81
ANGLE, DURATION = radians(30.0), 10.0  # s
ENERGY = LINKS * MASS * GRAVITY * LINKS * LENGTH / 2.0 * (1.0 - cos(ANGLE))  # J, above hanging at rest
INERTIA = MASS * LENGTH**2 / 12.0


def mujoco_chain(integrator: str, step: float) -> float:
    """Return what the energy gains in parts of what it was, as a mean over the last second."""
    import mujoco

    links = "".join(
        f"<body pos='0 0 {-LENGTH if i else 0}'><joint type='hinge' axis='0 1 0'/>"
        f"<inertial pos='0 0 {-LENGTH / 2}' mass='{MASS}' diaginertia='{INERTIA} {INERTIA} {INERTIA}'/>"
        for i in range(LINKS)
    )
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><option timestep='{step}' integrator='{integrator}' gravity='0 0 {-GRAVITY}'>"
        f"<flag energy='enable'/></option><worldbody>{links}{'</body>' * LINKS}</worldbody></mujoco>"
    )
    data, energies = mujoco.MjData(model), []
    data.qpos[0] = ANGLE
    mujoco.mj_forward(model, data)
    for _ in range(round(DURATION / step)):
        energies.append(float(data.energy.sum()))
        mujoco.mj_step(model, data)
    return (float(np.mean(energies[-round(1.0 / step) :])) - energies[0]) / ENERGY


def exudyn_chain(solver: str, step: float) -> float:
    """Return what the energy gains in parts of what it was, as a mean over the last second."""
    exudyn = load()
    from exudyn.utilities import RigidBodyInertia, RotationMatrixZ

    system, along = exudyn.SystemContainer().AddSystem(), np.array([sin(ANGLE), -cos(ANGLE), 0.0])
    inner, links = system.CreateGround(), []
    for i in range(LINKS):
        link = system.CreateRigidBody(
            referencePosition=list(along * LENGTH * (i + 0.5)),
            referenceRotationMatrix=RotationMatrixZ(ANGLE),
            inertia=RigidBodyInertia(mass=MASS, inertiaTensor=np.diag([INERTIA] * 3)),
            gravity=[0.0, -GRAVITY, 0.0],
            nodeType=exudyn.NodeType.RotationRxyz,
        )
        place = list(along * LENGTH * i)
        joined, axis = [inner, link], [0.0, 0.0, 1.0]
        system.CreateRevoluteJoint(itemNumbers=joined, position=place, axis=axis, useGlobalFrame=True)
        links.append(inner := link)
    system.Assemble()
    energies: list[float] = []

    def note(_: Any, time: float) -> bool:
        kinds, energy = exudyn.OutputVariableType, 0.0
        for link in links:
            velocity, spin, place = (
                system.GetObjectOutputBody(link, kind, [0.0] * 3)
                for kind in (kinds.Velocity, kinds.AngularVelocity, kinds.Position)
            )
            energy += 0.5 * (MASS * velocity @ velocity + INERTIA * spin @ spin) + MASS * GRAVITY * place[1]
        energies.append(energy)
        return True

    system.SetPreStepUserFunction(note)
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.timeIntegration.endTime = DURATION
    settings.timeIntegration.numberOfSteps = round(DURATION / step)
    settings.timeIntegration.verboseMode = 0
    system.SolveDynamic(settings, solverType=getattr(exudyn.DynamicSolverType, solver))
    return (float(np.mean(energies[-round(1.0 / step) :])) - energies[0]) / ENERGY


def exudyn_segments(place: float) -> float:
    """Return the force over stiffness and depth where a circle is pressed on a straight cable of four segments.

    The cable is 1 m long, the place in m along it, the radius 0.1 m, the depth 0.1 mm.
    """
    exudyn = load()
    items, system, segments = exudyn.itemInterface, exudyn.SystemContainer().AddSystem(), 4
    stiffness, radius, depth = 1e6, 0.1, 1e-4
    nodes = [system.AddNode(items.NodePoint2DSlope1(referenceCoordinates=[x, 0.0, 1.0, 0.0])) for x in (0.0, 1.0)]
    cable = system.AddObject(
        items.ObjectANCFCable2D(
            length=1.0, massPerLength=1.0, bendingStiffness=1e3, axialStiffness=1e6, nodeNumbers=nodes
        )
    )
    ground = system.AddObject(items.ObjectGround())
    circle = system.AddMarker(items.MarkerBodyRigid(bodyNumber=ground, localPosition=[place, radius - depth, 0.0]))
    shape = system.AddMarker(items.MarkerBodyCable2DShape(bodyNumber=cable, numberOfSegments=segments))
    states = [0.1] * segments + [-2.0] * segments + [0.0] * segments  # gap, undefined state, place of stick
    node = system.AddNode(items.NodeGenericData(initialCoordinates=states, numberOfDataCoordinates=3 * segments))
    contact = system.AddObject(
        items.ObjectContactFrictionCircleCable2D(
            markerNumbers=[circle, shape],
            nodeNumber=node,
            numberOfContactSegments=segments,
            contactStiffness=stiffness,
            circleRadius=radius,
        )
    )
    system.Assemble()
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.timeIntegration.endTime, settings.timeIntegration.numberOfSteps = 1e-9, 1
    settings.timeIntegration.verboseMode = 0
    system.SolveDynamic(settings)
    forces = system.GetObjectOutput(contact, exudyn.OutputVariableType.ForceLocal)
    return -float(forces[1::2].sum()) / (stiffness * depth)


def exudyn_eigenvalues(**options: bool) -> list[float]:
    """Return the eigenvalues (1/s^2) of 1 kg on springs of -4, 9 and 16 N/m along the three axes."""
    exudyn = load()
    items, system = exudyn.itemInterface, exudyn.SystemContainer().AddSystem()
    node = system.AddNode(items.NodePoint())
    system.AddObject(items.MassPoint(mass=1.0, nodeNumber=node))
    ground = system.AddMarker(
        items.MarkerNodeCoordinate(nodeNumber=system.AddNode(items.NodePointGround()), coordinate=0)
    )
    for coordinate, stiffness in enumerate((-4.0, 9.0, 16.0)):
        marker = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        spring = items.CoordinateSpringDamper(markerNumbers=[ground, marker], stiffness=stiffness)
        system.AddObject(spring)
    system.Assemble()
    return [float(value) for value in system.ComputeODE2Eigenvalues(**options)[0]]


def elastica_damping(elements: int, unit: float, **constants: float) -> float:
    """Return the rate (1/s) at which a rod of 1 m stops spinning about its axis, with lengths in a unit (m)."""
    import elastica

    class Simulator(elastica.BaseSystemCollection, elastica.Damping):  # type: ignore[misc]
        pass

    step, steps = 1e-6, 100
    rod = elastica.CosseratRod.straight_rod(
        elements,
        np.zeros(3),
        np.array([1.0, 0.0, 0.0]),
        np.array([0.0, 1.0, 0.0]),
        base_length=1.0 / unit,
        base_radius=0.02 / unit,
        density=1e3 * unit**3,
        youngs_modulus=1e6 * unit,
        shear_modulus=4e5 * unit,
    )
    simulator = Simulator()
    simulator.append(rod)
    simulator.dampen(rod).using(elastica.AnalyticalLinearDamper, time_step=step, **constants)
    simulator.finalize()
    rod.omega_collection[2] = 1.0
    stepper, time = elastica.PositionVerlet(), 0.0
    for _ in range(steps):
        time = stepper.step(simulator, time, step)
    return -log(float(rod.omega_collection[2, elements // 2])) / float(time)


def elastica_cantilever(elements: int) -> float:
    """Return the deflection of a clamped rod's tip under a small force, over that of Euler and Bernoulli.

    The rod is marched with critical damping until it rests; shear adds a thousandth.
    """
    import elastica

    class Simulator(  # type: ignore[misc]
        elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing, elastica.Damping
    ):
        pass

    length, radius, modulus, density, step = 1.0, 0.02, 1e6, 1e3, 1e-4
    moment = np.pi * radius**4 / 4.0
    force = 1e-3 * 3.0 * modulus * moment / length**3
    rod = elastica.CosseratRod.straight_rod(
        elements,
        np.zeros(3),
        np.array([1.0, 0.0, 0.0]),
        np.array([0.0, 1.0, 0.0]),
        base_length=length,
        base_radius=radius,
        density=density,
        youngs_modulus=modulus,
        shear_modulus=0.4 * modulus,
    )
    simulator = Simulator()
    simulator.append(rod)
    simulator.constrain(rod).using(
        elastica.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,)
    )
    simulator.add_forcing_to(rod).using(
        elastica.EndpointForces, np.zeros(3), np.array([0.0, force, 0.0]), ramp_up_time=step
    )
    simulator.dampen(rod).using(elastica.AnalyticalLinearDamper, time_step=step, uniform_damping_constant=2.2)
    simulator.finalize()
    stepper, time = elastica.PositionVerlet(), 0.0
    while time < 12.0:
        time = stepper.step(simulator, time, step)
    return float(rod.position_collection[1, -1]) / 1e-3


def mujoco_cantilever(elements: int) -> float:
    """Return the deflection of a clamped elastic flex's tip under a small force, over Euler and Bernoulli's.

    It is clamped by its first two nodes, and damped until it rests.
    """
    import mujoco

    length, radius, modulus, deflection = 1.0, 0.01, 1e9, 5e-3
    force = deflection * 3.0 * modulus * np.pi * radius**4 / 4.0 / length**3
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><option gravity='0 0 0' integrator='discrete'/><worldbody><body name='root'>"
        f"<flexcomp name='rod' type='grid' dim='1' count='{elements + 1} 1 1' radius='{radius}' mass='0.3'"
        f" spacing='{length / elements} 1 1'><edge equality='true'/><pin id='0 1'/>"
        f"<elasticity young='{modulus}' damping='0.02'/><contact selfcollide='none'/></flexcomp>"
        "</body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    data.xfrc_applied[model.flex_vertbodyid[-1], 2] = force
    mujoco.mj_step(model, data, 4000)
    return float(data.flexvert_xpos[-1, 2]) / deflection


def mujoco_mass() -> float:
    """Return the mass (kg) of a body with an `inertial` of 1 kg and a box with a density."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body><freejoint/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>"
        "<geom type='box' size='0.2 0.2 0.1' density='1000'/></body></worldbody></mujoco>"
    )
    return float(model.body_mass[1])


def pymunk_mass() -> float:
    """Return the mass (kg) of a body of 1 kg with a box with a density."""
    import pymunk

    body, space = pymunk.Body(1.0, 1.0), pymunk.Space()
    shape = pymunk.Poly.create_box(body, (0.4, 0.2))
    shape.density = 1000.0
    space.add(body, shape)
    return float(body.mass)


def box2d_mass(**density: float) -> float:
    """Return the mass (kg) of a body of 1 kg to which a box is added."""
    import Box2D

    world = Box2D.b2World()  # its bodies live as long as it does
    body = world.CreateDynamicBody()
    body.mass = 1.0
    body.CreatePolygonFixture(box=(0.2, 0.1), **density)
    return float(body.mass)


def newton_mass() -> float:
    """Return the mass (kg) of a body of 1 kg to which a box is added."""
    from peers.newton_bodies import Body

    return float(Body(height=0.1, mass=1.0).model.body_mass.numpy()[0])


def _text(form: str, run: Callable[[], Any]) -> str:
    return format(run(), form) if form else str(run())


def _asked(form: str, *asked: tuple[str, str, Callable[[], Any]]) -> list[tuple[str, str, Callable[[], str]]]:
    return [(program, settings, partial(_text, form, run)) for program, settings, run in asked]


def questions() -> list[Question]:
    """Return the questions about structures."""
    chains = [
        ("MuJoCo", f"{integrator}, {1e3 * step:g} ms", partial(mujoco_chain, integrator, step))
        for integrator in ("Euler", "implicitfast", "implicit", "RK4")
        for step in (2e-3, 1e-3)
    ]
    chains += [
        ("Exudyn", f"{solver}, 2 ms", partial(exudyn_chain, solver, 2e-3))
        for solver in ("GeneralizedAlpha", "TrapezoidalIndex2")
    ]
    damping = [
        (
            "PyElastica",
            f"{name}, {elements} elements, {label}",
            partial(elastica_damping, elements, unit, **given(unit)),
        )
        for name, given in (
            ("damping_constant", lambda unit: {"damping_constant": 0.1}),
            ("uniform_damping_constant", lambda unit: {"uniform_damping_constant": 0.1}),
            (
                "translational and rotational",
                lambda unit: {
                    "translational_damping_constant": 0.1,
                    "rotational_damping_constant": 1e-5 / unit**2,
                },
            ),
        )
        for elements, unit, label in ((10, 1.0, "m"), (20, 1.0, "m"), (10, 1e-3, "mm"))
    ]
    clamped = [("PyElastica", f"{n} elements", partial(elastica_cantilever, n)) for n in (5, 10, 20)]
    clamped += [("MuJoCo", f"flex, {n} elements", partial(mujoco_cantilever, n)) for n in (5, 10, 20)]
    places = (0.375, 0.49, 0.4975, 0.499, 0.5)
    masses = [
        ("MuJoCo", "inertial of 1 kg, density 1000", mujoco_mass),
        ("pymunk", "Body(1, 1), density 1000", pymunk_mass),
        ("Box2D", "mass 1, density 1000", partial(box2d_mass, density=1000.0)),
        ("Box2D", "no density at all", box2d_mass),
        ("Newton", "mass 1, default density", newton_mass),
    ]
    return [
        Question("gain of energy of an undamped chain in 10 s", _asked("+.1e", *chains)),
        Question(
            "force on a straight cable, over stiffness and depth; segments meet at 0.5 m",
            _asked(".2f", *(("Exudyn", f"at {x:g} m", partial(exudyn_segments, x)) for x in places)),
        ),
        Question(
            "eigenvalues of 1 kg on springs of -4, 9 and 16 N/m",
            _asked(
                "",
                ("Exudyn", "as it comes", exudyn_eigenvalues),
                ("Exudyn", "useAbsoluteValues=False", partial(exudyn_eigenvalues, useAbsoluteValues=False)),
            ),
        ),
        Question("rate at which one and the same rod stops to spin, 1/s", _asked(".3g", *damping)),
        Question("deflection of a cantilever's tip over that of Euler and Bernoulli", _asked(".4f", *clamped)),
        Question("mass of a body of 1 kg and a box with a density, kg", _asked(".3g", *masses)),
    ]

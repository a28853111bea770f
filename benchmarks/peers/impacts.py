"""A ball of 1 kg that strikes the ground straight: its rebound, in parts of the speed of approach."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import islice
from math import sqrt
from typing import Any

from peers.exudyn_cables import load
from peers.problems import Question

RADIUS = 0.1  # m
SPEED = 2.0  # m/s, of approach unless another is given
GAP = 0.05  # m, at the start
STIFFNESS = 1e6  # N/m, of penalties
HEIGHTS = 10  # runs over which a rebound is averaged: their gaps differ by tenths of the way of a step
Rebound = Callable[[float, float | None, float, float, float], float]


def mujoco_rebound(step: float, damping_ratio: float = 1.0, solimp: str = "0.9 0.95 0.001") -> float:
    """Return the rebound from a soft contact of a time constant of 0.02 s."""
    import mujoco

    soft = f"solref='0.02 {damping_ratio}' solimp='{solimp}'"
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><option timestep='{step}' gravity='0 0 0'/><worldbody><geom type='plane' size='1 1 1' {soft}/>"
        f"<body pos='0 0 {RADIUS + 0.01}'><joint type='slide' axis='0 0 1'/>"
        f"<geom size='{RADIUS}' mass='1' {soft}/></body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    data.qvel[0] = -SPEED
    mujoco.mj_step(model, data, round(0.5 / step))
    return float(data.qvel[0]) / SPEED


def pybullet_rebound(ball: float, ground: float | None, speed: float, gap: float, step: float) -> float:
    """Return the rebound; of no restitution given to the ground its default is taken."""
    import pybullet

    pybullet.connect(pybullet.DIRECT)
    pybullet.setTimeStep(step)
    plane = pybullet.createMultiBody(0.0, pybullet.createCollisionShape(pybullet.GEOM_PLANE))
    shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=RADIUS)
    body = pybullet.createMultiBody(1.0, shape, basePosition=[0.0, 0.0, RADIUS + gap])
    if ground is not None:
        pybullet.changeDynamics(plane, -1, restitution=ground)
    pybullet.changeDynamics(body, -1, restitution=ball, linearDamping=0.0)
    pybullet.resetBaseVelocity(body, [0.0, 0.0, -speed])
    for _ in range(round(2.0 * gap / speed / step) + 20):
        pybullet.stepSimulation()
    after = pybullet.getBaseVelocity(body)[0][2]
    pybullet.disconnect()
    return max(0.0, float(after)) / speed


def pymunk_rebound(ball: float, ground: float | None, speed: float, gap: float, step: float) -> float:
    """Return the rebound; of no restitution given to the ground its default is taken."""
    import pymunk

    space = pymunk.Space()
    line = pymunk.Segment(space.static_body, (-50.0, 0.0), (50.0, 0.0), 0.0)
    body = pymunk.Body(1.0, 1.0)
    body.position, body.velocity = (0.0, RADIUS + gap), (0.0, -speed)
    shape = pymunk.Circle(body, RADIUS)
    shape.elasticity = ball
    if ground is not None:
        line.elasticity = ground
    space.add(line, body, shape)
    for _ in range(round(2.0 * gap / speed / step) + 20):
        space.step(step)
    return max(0.0, float(body.velocity.y)) / speed


def box2d_rebound(ball: float, ground: float | None, speed: float, gap: float, step: float) -> float:
    """Return the rebound; of no restitution given to the ground its default is taken."""
    import Box2D

    world = Box2D.b2World(gravity=(0.0, 0.0))
    given = {} if ground is None else {"restitution": ground}
    world.CreateStaticBody().CreateEdgeFixture(vertices=[(-50.0, 0.0), (50.0, 0.0)], **given)
    body = world.CreateDynamicBody(position=(0.0, RADIUS + gap))
    body.CreateCircleFixture(radius=RADIUS, density=10.0, restitution=ball)
    body.linearVelocity = (0.0, -speed)
    for _ in range(round(2.0 * gap / speed / step) + 20):
        world.Step(step, 10, 10)
    return max(0.0, float(body.linearVelocity.y)) / speed


def newton_rebound(
    ball: float, ground: float | None, speed: float, gap: float, step: float, **options: bool
) -> float:
    """Return the rebound; of no restitution given to the ground zero, its default, is taken."""
    from peers.newton_bodies import Body

    body = Body(restitution=(ball, ground or 0.0), height=RADIUS + gap, sphere=True)
    found = body.velocities("SolverXPBD", step, 0, [0.0, 0.0, -speed], **options)
    return max(0.0, max(float(v[2]) for v in islice(found, round(2.0 * gap / speed / step) + 20))) / speed


def exudyn_rebound(restitution: float, **options: int) -> float:
    """Return the rebound of two spheres, one of them held, on a penalty."""
    exudyn = load()
    from exudyn.utilities import InertiaSphere

    items, system = exudyn.itemInterface, exudyn.SystemContainer().AddSystem()
    ground = system.AddObject(items.ObjectGround())
    body = system.CreateRigidBody(
        referencePosition=[0.0, 0.0, 2.0 * RADIUS + GAP],
        initialVelocity=[0.0, 0.0, -SPEED],
        inertia=InertiaSphere(1.0, RADIUS),
    )
    state = system.AddNode(items.NodeGenericData(initialCoordinates=[0.1, 0, 0, 0], numberOfDataCoordinates=4))
    contact = items.ObjectContactSphereSphere(
        markerNumbers=[system.AddMarker(items.MarkerBodyRigid(bodyNumber=number)) for number in (ground, body)],
        nodeNumber=state,
        spheresRadii=[RADIUS, RADIUS],
        contactStiffness=STIFFNESS,
        restitutionCoefficient=restitution,
        **options,
    )
    system.AddObject(contact)
    _march(exudyn, system, 1e-5)
    speed = system.GetObjectOutputBody(body, exudyn.OutputVariableType.Velocity, [0.0] * 3)[2]
    return float(speed) / SPEED


def exudyn_critical(step: float) -> str:
    """Return the rebound from a coordinate contact with critical damping, and how hard it pulls."""
    exudyn = load()
    items, system, place = exudyn.itemInterface, exudyn.SystemContainer().AddSystem(), [GAP]
    ball = system.AddNode(
        items.Node1D(referenceCoordinates=[0.0], initialCoordinates=place, initialVelocities=[-SPEED])
    )
    system.AddObject(items.Mass1D(mass=1.0, nodeNumber=ball))
    ground = system.AddNode(items.NodePointGround())
    contact = items.ObjectContactCoordinate(
        markerNumbers=[
            system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=0)) for node in (ground, ball)
        ],
        nodeNumber=system.AddNode(items.NodeGenericData(initialCoordinates=place, numberOfDataCoordinates=1)),
        contactStiffness=STIFFNESS,
        contactDamping=2.0 * sqrt(STIFFNESS),
    )
    system.AddObject(contact)
    kinds, forces = exudyn.OutputVariableType, []

    def note(_: Any, time: float) -> bool:
        forces.append(float(system.GetNodeOutput(ball, kinds.Coordinates_tt)))  # of 1 kg
        return True

    system.SetPreStepUserFunction(note)
    _march(exudyn, system, step)
    rebound = float(system.GetNodeOutput(ball, kinds.Coordinates_t)) / SPEED
    return f"{rebound:.3f}, pulls with {-min(forces):.0f} N of {max(forces):.0f}"


def _march(exudyn: Any, system: Any, step: float) -> None:
    system.Assemble()
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.timeIntegration.endTime = 2.0 * GAP / SPEED
    settings.timeIntegration.numberOfSteps = round(2.0 * GAP / SPEED / step)
    settings.timeIntegration.verboseMode = 0
    system.SolveDynamic(settings)


def _number(run: Callable[[], float]) -> str:
    return f"{run():.3f}"


def _rebounds(run: Rebound, ball: float, ground: float | None, speed: float, step: float) -> str:
    gaps = [GAP + (k + 0.5) / HEIGHTS * speed * step for k in range(HEIGHTS)]
    found = [run(ball, ground, speed, gap, step) for gap in gaps]
    mean = f"{sum(found) / HEIGHTS:.3f}"
    return mean if max(found) - min(found) < 5e-3 else f"{mean} ({min(found):.3f} to {max(found):.3f})"


def questions() -> list[Question]:
    """Return the questions about impacts."""
    critical: list[tuple[str, str, Callable[[], str]]] = [
        ("MuJoCo", f"step {1e3 * step:g} ms", partial(_number, partial(mujoco_rebound, step)))
        for step in (2e-3, 1e-4, 1e-5)
    ]
    critical += [
        ("MuJoCo", "dampratio 2, 0.1 ms", partial(_number, partial(mujoco_rebound, 1e-4, 2.0))),
        ("Exudyn", "ContactCoordinate, 10 us", partial(exudyn_critical, 1e-5)),
    ]
    engines: list[tuple[str, Rebound]] = [
        ("PyBullet", pybullet_rebound),
        ("pymunk", pymunk_rebound),
        ("Box2D", box2d_rebound),
    ]
    switched = partial(newton_rebound, enable_restitution=True)
    both, alone = [], []
    for program, run in engines:
        both.append((program, "step 1/240 s", partial(_rebounds, run, 0.8, 0.8, SPEED, 1 / 240)))
        alone.append((program, "step 1/240 s", partial(_rebounds, run, 0.8, None, SPEED, 1 / 240)))
    both.append(("Box2D", "0.9 m/s", partial(_rebounds, box2d_rebound, 0.8, 0.8, 0.9, 1 / 240)))
    one = partial(newton_rebound, 0.8, 0.8, SPEED, GAP, 1e-3)
    both.append(("Newton, XPBD", "as it comes", partial(_number, one)))
    both.append(("Newton, XPBD", "enable_restitution", partial(_number, partial(one, enable_restitution=True))))
    alone.append(
        ("Newton, XPBD", "enable_restitution", partial(_number, partial(switched, 0.8, None, SPEED, GAP, 1e-3)))
    )
    models: list[tuple[str, dict[str, int]]] = [("as it comes", {})]
    models += [(f"impactModel {number}", {"impactModel": number}) for number in (1, 2)]
    return [
        Question("rebound from a critically damped contact", critical),
        Question("rebound, restitution 0.8 given to ball and ground, at 2 m/s", both),
        Question("rebound, restitution 0.8 given to the ball alone", alone),
        Question(
            "rebound, restitutionCoefficient 0.5",
            [
                ("Exudyn", name, partial(_number, partial(exudyn_rebound, 0.5, **options)))
                for name, options in models
            ],
        ),
    ]

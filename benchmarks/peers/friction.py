"""A block that slides, and one that should rest, in engines for rigid bodies.

The block is a mass of 1 kg that does not turn.  Engines are told two friction coefficients, one for it and one for
the ground.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from functools import partial
from itertools import islice, takewhile
from math import atan, cos, hypot, radians, sin
from typing import Any

from peers.problems import Question

GRAVITY = 10.0  # m/s^2
SPEED = 2.0  # m/s, of the block when its deceleration is measured
STEP = 1e-3  # s
SETTLING = 500  # steps
RADIUS = 0.1  # m, of the sphere that stands for the block where it cannot turn
#: slope that no block of the second or third question should slide on: tan = 0.5 and 0.36
STEEP, GENTLE = atan(0.5), radians(20.0)


def _mujoco_block(friction: tuple[float, float], gravity: tuple[float, float, float], options: str) -> Any:
    import mujoco

    slides = "".join(f"<joint type='slide' axis='{axis}'/>" for axis in ("1 0 0", "0 1 0", "0 0 1"))
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><option gravity='{gravity[0]} {gravity[1]} {gravity[2]}' {options}/><worldbody>"
        f"<geom type='plane' size='9 9 1' friction='{friction[1]}'/>"
        f"<body pos='0 0 {RADIUS}'>{slides}<geom size='{RADIUS}' mass='1' friction='{friction[0]}'/></body>"
        "</worldbody></mujoco>"
    )
    return model, mujoco.MjData(model)


def _coefficient(speeds: Iterator[float]) -> float:
    """Return the deceleration over gravity, from the steps that a push of `SPEED` takes to fall to a tenth."""
    steps = sum(1 for _ in takewhile(lambda speed: speed > 0.1 * SPEED, speeds))
    return 0.9 * SPEED / (GRAVITY * STEP * steps)


def mujoco_speeds(block: float, ground: float, options: str = "") -> Iterator[float]:
    """Yield the speed (m/s) step by step."""
    import mujoco

    model, data = _mujoco_block((block, ground), (0.0, 0.0, -GRAVITY), f"timestep='{STEP}' {options}")
    mujoco.mj_step(model, data, SETTLING)
    data.qvel[0] = SPEED
    while True:
        mujoco.mj_step(model, data)
        yield float(data.qvel[0])


def pybullet_speeds(block: float, ground: float, slope: float = 0.0, push: float = SPEED) -> Iterator[float]:
    """Yield the speed (m/s) step by step."""
    import pybullet

    pybullet.connect(pybullet.DIRECT)
    pybullet.setGravity(GRAVITY * sin(slope), 0.0, -GRAVITY * cos(slope))
    pybullet.setTimeStep(STEP)
    plane = pybullet.createMultiBody(0.0, pybullet.createCollisionShape(pybullet.GEOM_PLANE))
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.2, 0.2, 0.01])
    body = pybullet.createMultiBody(1.0, shape, basePosition=[0.0, 0.0, 0.01])
    pybullet.changeDynamics(plane, -1, lateralFriction=ground)
    pybullet.changeDynamics(body, -1, lateralFriction=block, linearDamping=0.0)
    try:
        for _ in range(SETTLING):
            pybullet.stepSimulation()
        pybullet.resetBaseVelocity(body, [push, 0.0, 0.0])
        while True:
            pybullet.stepSimulation()
            yield float(pybullet.getBaseVelocity(body)[0][0])
    finally:
        pybullet.disconnect()


def pymunk_speeds(block: float, ground: float, slope: float = 0.0, push: float = SPEED) -> Iterator[float]:
    """Yield the speed (m/s) step by step."""
    import pymunk

    space = pymunk.Space()
    space.gravity = (GRAVITY * sin(slope), -GRAVITY * cos(slope))
    line = pymunk.Segment(space.static_body, (-50.0, 0.0), (50.0, 0.0), 0.0)
    body = pymunk.Body(1.0, float("inf"))
    body.position = (0.0, RADIUS)
    shape = pymunk.Poly.create_box(body, (4.0 * RADIUS, 2.0 * RADIUS))
    line.friction, shape.friction = ground, block
    space.add(line, body, shape)
    for _ in range(SETTLING):
        space.step(STEP)
    body.velocity = (push, body.velocity.y)
    while True:
        space.step(STEP)
        yield float(body.velocity.x)


def box2d_speeds(block: float, ground: float, slope: float = 0.0, push: float = SPEED) -> Iterator[float]:
    """Yield the speed (m/s) step by step."""
    import Box2D

    world = Box2D.b2World(gravity=(GRAVITY * sin(slope), -GRAVITY * cos(slope)), doSleep=False)
    world.CreateStaticBody(position=(0.0, -1.0)).CreatePolygonFixture(box=(50.0, 1.0), friction=ground)
    body = world.CreateDynamicBody(position=(0.0, RADIUS), fixedRotation=True)
    body.CreatePolygonFixture(box=(2.0 * RADIUS, RADIUS), density=10.0, friction=block)
    for _ in range(SETTLING):
        world.Step(STEP, 10, 10)
    body.linearVelocity = (push, 0.0)
    while True:
        world.Step(STEP, 10, 10)
        yield float(body.linearVelocity.x)


def newton_speeds(
    block: float, ground: float, slope: float = 0.0, push: float = SPEED, iterations: int = 2
) -> Iterator[float]:
    """Yield the speed (m/s) step by step."""
    from peers.newton_bodies import Body

    gravity = (GRAVITY * sin(slope), 0.0, -GRAVITY * cos(slope))
    body = Body(friction=(block, ground), gravity=gravity, height=RADIUS)
    for velocity in body.velocities("SolverXPBD", STEP, SETTLING, [push, 0.0, 0.0], iterations=iterations):
        yield float(velocity[0])


class DrakeBlock:
    """The sphere on two prismatic joints, along the ground and away from it, over a half space."""

    def __init__(
        self,
        block: tuple[float, float],
        ground: tuple[float, float],
        step: float,
        slope: float,
        model: str = "lagged",
    ) -> None:
        from pydrake import geometry, math, systems
        from pydrake.multibody import plant, tree
        from pydrake.systems import analysis, framework  # noqa: F401

        builder = systems.framework.DiagramBuilder()
        options = plant.MultibodyPlantConfig(time_step=step, discrete_contact_approximation=model)
        self.plant, _ = plant.AddMultibodyPlant(options, builder)
        self.plant.mutable_gravity_field().set_gravity_vector([GRAVITY * sin(slope), 0.0, -GRAVITY * cos(slope)])
        inertia = tree.UnitInertia.SolidSphere(RADIUS)
        carriage = self.plant.AddRigidBody("carriage", tree.SpatialInertia(0.0, [0.0] * 3, inertia))
        body = self.plant.AddRigidBody("block", tree.SpatialInertia(1.0, [0.0] * 3, inertia))
        joint, frame = tree.PrismaticJoint, self.plant.world_frame()
        self.along = self.plant.AddJoint(joint("along", frame, carriage.body_frame(), [1, 0, 0]))
        self.away = self.plant.AddJoint(joint("away", carriage.body_frame(), body.body_frame(), [0, 0, 1]))
        for owner, shape, friction in (
            (self.plant.world_body(), geometry.HalfSpace(), ground),
            (body, geometry.Sphere(RADIUS), block),
        ):
            place = math.RigidTransform()
            self.plant.RegisterCollisionGeometry(owner, place, shape, "shape", plant.CoulombFriction(*friction))
        self.plant.Finalize()
        self.simulator = systems.analysis.Simulator(builder.Build())
        self.context = self.plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())

    def speeds(self, push: float) -> Iterator[float]:
        """Yield the speed (m/s) step by step."""
        self.away.set_translation(self.context, RADIUS)
        self.simulator.AdvanceTo(STEP * SETTLING)
        self.along.set_translation_rate(self.context, push)
        while True:
            self.simulator.AdvanceTo(self.context.get_time() + STEP)
            yield float(self.along.get_translation_rate(self.context))

    def speed_from_rest(self, depth: float) -> float:
        """Return the speed (m/s) after a second from rest, pressed in as deep (m) as its weight presses it."""
        self.away.set_translation(self.context, RADIUS - depth)
        self.simulator.AdvanceTo(1.0)
        return float(self.along.get_translation_rate(self.context))

    @property
    def height(self) -> float:
        """Height over the ground, m."""
        return float(self.away.get_translation(self.context)) - RADIUS


def drake_speeds(block: float, ground: float, slope: float = 0.0, push: float = SPEED) -> Iterator[float]:
    """Yield the speed (m/s) step by step."""
    return DrakeBlock((block, block), (ground, ground), STEP, slope).speeds(push)


def _drake_glides(model: str) -> str:
    block = DrakeBlock((0.2, 0.2), (0.2, 0.2), STEP, STEEP, model)
    speed = block.speed_from_rest(0.0)
    return f"{1e3 * block.height:.2f} mm at {speed:.1f} m/s"


def _drake_at_rest(step: float) -> str:
    depth = 1.788854e-5  # m, where its weight settles
    speed = DrakeBlock((0.8, 0.2), (0.8, 0.2), step, STEEP).speed_from_rest(depth)
    return f"{speed:.2g} m/s"


def creep(options: str, friction: float = 0.5, turn: float = 0.0) -> float:
    """Return MuJoCo's mean speed (m/s) between 1 and 3 s, downhill on 20 degrees, turned (rad) out of an axis."""
    import mujoco

    down = GRAVITY * sin(GENTLE)
    gravity = (down * cos(turn), down * sin(turn), -GRAVITY * cos(GENTLE))
    model, data = _mujoco_block((friction, friction), gravity, options)
    mujoco.mj_step(model, data, round(1.0 / model.opt.timestep))
    x, y, begin = float(data.qpos[0]), float(data.qpos[1]), data.time
    mujoco.mj_step(model, data, round(2.0 / model.opt.timestep))
    return hypot(float(data.qpos[0]) - x, float(data.qpos[1]) - y) / (data.time - begin)


def _creep(options: str, turn: float = 0.0) -> str:
    return f"{1e3 * creep(options, turn=turn):.3f} mm/s"


def hop(options: str) -> float:
    """Return how high (m) MuJoCo's block gets over a level ground that it is pushed along."""
    import mujoco

    model, data = _mujoco_block((0.5, 0.5), (0.0, 0.0, -GRAVITY), options)
    mujoco.mj_step(model, data, round(SETTLING * STEP / model.opt.timestep))
    data.qvel[0], highest = SPEED, 0.0
    while data.qvel[0] > 0.1 * SPEED:
        mujoco.mj_step(model, data)
        highest = max(highest, float(data.qpos[2]))
    return highest


def _rest(speeds: Iterator[float]) -> str:
    """Return the mean speed in the second second after settling."""
    second = round(1.0 / STEP)
    with closing(speeds) as found:  # type: ignore[type-var]
        return f"{1e3 * STEP * sum(islice(found, second, 2 * second)):.3f} mm/s"


def _exudyn_rest(friction: dict[str, float]) -> str:
    from peers.exudyn_block import Block

    return f"{1e3 * Block(GRAVITY, GENTLE, **friction).creep():.3f} mm/s"


def _hop(options: str) -> str:
    return f"{1e3 * hop(options):.2f} mm"


def _found(speeds: Callable[[float, float], Iterator[float]], block: float, ground: float) -> str:
    with closing(speeds(block, ground)) as found:  # type: ignore[type-var]
        return f"{_coefficient(found):.3f}"


def _coefficients(title: str, block: float, ground: float) -> Question:
    ask = {
        "MuJoCo": mujoco_speeds,
        "PyBullet": pybullet_speeds,
        "pymunk": pymunk_speeds,
        "Box2D": box2d_speeds,
        "Drake": drake_speeds,
        "Newton, XPBD": newton_speeds,
    }
    settings = f"{block:g} on {ground:g}"
    return Question(
        title, [(program, settings, partial(_found, run, block, ground)) for program, run in ask.items()]
    )


def questions() -> list[Question]:
    """Return the questions about friction."""
    pyramid, cone = "cone='pyramidal'", "cone='elliptic'"
    settings = [("as it comes (pyramidal, 2 ms, Newton)", pyramid, 0.0)]
    settings += [(f"impratio {ratio}", f"{pyramid} impratio='{ratio}'", 0.0) for ratio in (10, 100)]
    settings += [("step 0.5 ms", f"{pyramid} timestep='0.0005'", 0.0)]
    settings += [(f"solver {solver}", f"{pyramid} solver='{solver}'", 0.0) for solver in ("CG", "PGS")]
    settings += [("integrator implicit", f"{pyramid} integrator='implicit'", 0.0)]
    settings += [("downhill at 22.5 deg from the axis", pyramid, radians(22.5))]
    settings += [("downhill at 45 deg from the axis", pyramid, radians(45.0))]
    settings += [("elliptic", cone, 0.0), ("elliptic, at 45 deg", cone, radians(45.0))]
    settings += [("elliptic, impratio 100", f"{cone} impratio='100'", 0.0)]
    hops = [("as it comes", ""), ("step 0.2 ms", "timestep='0.0002'"), ("elliptic", cone)]
    hops += [("elliptic, impratio 100", f"{cone} impratio='100'")]
    rest = [(f"{kind}", step) for kind, step in (("continuous", 0.0), ("steps of 1 ms", 1e-3), ("0.1 ms", 1e-4))]
    resting: list[tuple[str, str, Callable[[], str]]] = [
        (
            program,
            f"{ground:g} for the ground",
            lambda run=run, ground=ground: _rest(run(0.5, ground, GENTLE, 0.0)),
        )
        for program, run, ground in (
            ("PyBullet", pybullet_speeds, 1.0),
            ("pymunk", pymunk_speeds, 1.0),
            ("Box2D", box2d_speeds, 0.5),
            ("Drake", drake_speeds, 0.5),
        )
    ]
    resting += [
        (
            "Newton, XPBD",
            f"{number} iterations",
            lambda number=number: _rest(newton_speeds(0.5, 0.5, GENTLE, 0.0, number)),
        )
        for number in (2, 10, 50)
    ]
    held: list[tuple[str, dict[str, float]]] = [
        ("frictionVelocityPenalty 1e3", {"frictionVelocityPenalty": 1e3}),
        ("frictionStiffness 1e5 too", {"frictionVelocityPenalty": 1e2, "frictionStiffness": 1e5}),
    ]
    resting += [("Exudyn", setting, partial(_exudyn_rest, friction)) for setting, friction in held]
    return [
        _coefficients("friction coefficient at work, two bodies with one each", 0.2, 0.8),
        _coefficients("friction coefficient at work, equal coefficients", 0.5, 0.5),
        Question(
            "0.8 static, 0.2 kinetic, from rest on tan = 0.5: speed after 1 s",
            [("Drake", setting, partial(_drake_at_rest, step)) for setting, step in rest],
        ),
        Question(
            "a push of 2 m/s along a level ground, friction 0.5: height that it leaves the ground by",
            [("MuJoCo", setting, partial(_hop, options)) for setting, options in hops],
        ),
        Question(
            "friction 0.2 on tan = 0.5: height over the ground while it slides",
            [("Drake", model, partial(_drake_glides, model)) for model in ("lagged", "similar", "sap")],
        ),
        Question(
            "friction 0.5 on a slope of 20 deg (tan = 0.36): speed of what should rest",
            [("MuJoCo", setting, partial(_creep, options, turn)) for setting, options, turn in settings],
        ),
        Question("the same slope, steps of 1 ms", resting),
    ]

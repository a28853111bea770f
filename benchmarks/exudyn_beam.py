"""The paper's beam on an elastic stop in Exudyn; `work_precision.py` measures its speed.

    python benchmarks/exudyn_beam.py --scan     convergence scan over elements and steps
    python benchmarks/exudyn_beam.py --limit    recompute the converged impulses
    python benchmarks/exudyn_beam.py --limit 1e5    the same, and the other contacts, for another stiffness (N/m)

Exudyn (optional: pip install exudyn) marches 2D ANCF cable elements (extensible, geometrically exact,
Bernoulli-Euler) for 1 s. The frame is turned so that the slope is horizontal: the stop then acts on one
nodal coordinate and is Exudyn's compiled `ObjectContactCoordinate`, whose force is k times the penetration.
Exudyn gets its fast module, sparse factors, the modified Newton method with loose tolerances, reduced
quadrature, no output, and adaptive steps that land on touch and release. Its solver is called in
segments, so that small steps are spent on contact only; the windows are known beforehand, which favours it.

The quantity is the normal impulse of the first contact. It is the trapezoidal rule over the stop's force
k max(0, -gap), from the tip's coordinates that a sensor keeps in memory; timed runs have no sensor.
"""

from __future__ import annotations

import importlib.util
import itertools
import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

LENGTH, AREA, DENSITY = 1.0, 3.14e-4, 2766.7  # m, m^2, kg/m^3
YOUNG, SECOND_MOMENT = 68.952e9, 7.85e-9  # Pa, m^4
GRAVITY, STIFFNESS = 9.8, 1e6  # m/s^2, N/m
RELEASE_ANGLE, SLOPE_ANGLE, SLOPE_START = np.pi / 4, np.pi / 10, 0.3  # rad, rad, m
END_TIME = 1.0  # s

# Exudyn's own limit (--limit: 24 to 64 elements, steps down to 1e-6 s, agree to 2e-6 of the first contact)
FIRST_CONTACT_IMPULSE, FIRST_COLLISION_IMPULSE = 0.757646, 2.140254  # N s
TOLERANCE = 1e-4  # relative error of the first contact's impulse

# Windows of small steps (s): the first contact is 0.317147-0.320131, the collisions end at 0.32927 and 0.8752
FIRST_CONTACT = ((0.317, 0.3203),)
COLLISIONS = ((0.317, 0.3295), (0.864, 0.880))
WINDOWS = (FIRST_CONTACT, COLLISIONS)


@dataclass(frozen=True)
class Configuration:
    """Mesh, steps and tolerances of Exudyn."""

    elements: int
    step: float  # s, outside of the windows
    contact_step: float  # s, inside
    windows: tuple[tuple[float, float], ...] = ()  # s
    spectral_radius: float = 0.9  # of generalized-alpha; 1: the trapezoidal rule of index 2
    end_time: float = END_TIME
    newton_tolerances: tuple[float, float] = (1e-3, 1e-3)  # relative, absolute (N)
    reduced_quadrature: bool = True
    stiffness: float = STIFFNESS

    def segments(self) -> list[tuple[float, float]]:
        """Return ends of segments and their steps (s)."""
        segments = []
        for begin, end in self.windows:
            if begin >= self.end_time:
                break
            segments += [(begin, self.step), (min(end, self.end_time), self.contact_step)]
        if not segments or segments[-1][0] < self.end_time:
            segments.append((self.end_time, self.step))
        return segments


# Errors of mesh and steps cancel here: finer ones miss the tolerance again. The cheapest of --scan to reach 1 s
LUCKY = Configuration(9, 3e-4, 6e-5, FIRST_CONTACT, spectral_radius=1.0)
# Every refinement of steps and mesh in --scan meets it too
RELIABLE = Configuration(14, 1.5e-4, 1e-5, FIRST_CONTACT)
LIMIT = Configuration(
    48, 4e-6, 1e-6, COLLISIONS, 1.0, 0.331, newton_tolerances=(1e-6, 1e-5), reduced_quadrature=False
)


class Run(NamedTuple):
    """One march: processor seconds and, if recorded, times (s) and the stop's gap (m) at the end of each step."""

    processor: float
    time: np.ndarray
    gap: np.ndarray


class Impulses(NamedTuple):
    """Normal impulses (N s) of the first contact and up to 0.331 s, peak force (N), contact times (s)."""

    first_contact: float
    first_collision: float
    peak_force: float
    switches: np.ndarray


def load_exudyn() -> Any:
    """Import Exudyn's fast module; must come before any other import of exudyn."""
    sys.exudynFast = True  # type: ignore[attr-defined]
    import exudyn

    return exudyn


def build(configuration: Configuration, record: bool) -> tuple[Any, Any, int | None, float]:
    """Assemble the beam in the frame whose first axis is the slope."""
    exu = load_exudyn()
    items = exu.itemInterface
    container = exu.SystemContainer()
    system = container.AddSystem()
    n = configuration.elements
    angle = RELEASE_ANGLE - SLOPE_ANGLE
    axis = [float(np.cos(angle)), float(np.sin(angle))]
    gravity = [-GRAVITY * np.sin(SLOPE_ANGLE), -GRAVITY * np.cos(SLOPE_ANGLE), 0.0]
    nodes = [
        system.AddNode(items.NodePoint2DSlope1(referenceCoordinates=[*(LENGTH * i / n * c for c in axis), *axis]))
        for i in range(n + 1)
    ]
    for pair in itertools.pairwise(nodes):
        cable = system.AddObject(
            items.ObjectANCFCable2D(
                length=LENGTH / n,
                massPerLength=DENSITY * AREA,
                bendingStiffness=YOUNG * SECOND_MOMENT,
                axialStiffness=YOUNG * AREA,
                nodeNumbers=list(pair),
                useReducedOrderIntegration=int(configuration.reduced_quadrature),
            )
        )
        mass = system.AddMarker(items.MarkerBodyMass(bodyNumber=cable))
        system.AddLoad(items.LoadMassProportional(markerNumber=mass, loadVector=gravity))
    ground_node = system.AddNode(items.NodePointGround())
    ground = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground_node, coordinate=0))
    for coordinate in (0, 1):
        pin = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=coordinate))
        system.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[ground, pin]))
    tip = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[-1], coordinate=1))
    touch = -(LENGTH * axis[1] + SLOPE_START * np.sin(SLOPE_ANGLE))
    state = system.AddNode(items.NodeGenericData(initialCoordinates=[-touch], numberOfDataCoordinates=1))
    system.AddObject(
        items.ObjectContactCoordinate(
            markerNumbers=[ground, tip], nodeNumber=state, contactStiffness=configuration.stiffness, offset=touch
        )
    )
    sensor = None
    if record:
        sensor = system.AddSensor(
            items.SensorNode(
                nodeNumber=nodes[-1],
                writeToFile=False,
                storeInternal=True,
                outputVariableType=exu.OutputVariableType.Coordinates,
            )
        )
    system.Assemble()
    return container, system, sensor, touch


def solver_settings(configuration: Configuration, record: bool) -> Any:
    """Return Exudyn's simulation settings, chosen for speed."""
    exu = load_exudyn()
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.solution.sensors.active = record
    settings.solution.sensors.writePeriod = 1e-12  # every step
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    settings.linearSolver.reuseAnalyzedPattern = True
    settings.parallel.numberOfThreads = 1
    integration = settings.timeIntegration
    integration.verboseMode = 0
    integration.newton.useModifiedNewton = True
    # a new Jacobian as soon as the old one is worse than a tenth: fewer iterations a step while the beam turns
    integration.newton.modifiedNewtonContractivity = 0.1
    # the default 1e-10 N lies below the round-off of the axial force, E A = 2e7 N
    integration.newton.relativeTolerance, integration.newton.absoluteTolerance = configuration.newton_tolerances
    if configuration.spectral_radius < 1.0:
        integration.solverType = exu.DynamicSolverType.GeneralizedAlpha
        integration.generalizedAlpha.spectralRadius = configuration.spectral_radius
    else:
        integration.solverType = exu.DynamicSolverType.TrapezoidalIndex2
    # a step in which the contact switches is repeated with the step that ends at the switch
    integration.discontinuous.ignoreMaxIterations = False
    integration.discontinuous.maxIterations = 2
    integration.discontinuous.iterationTolerance = 1.0  # N, the force that a step may miss
    integration.adaptiveStep = True
    integration.adaptiveStepRecoverySteps = 0
    integration.adaptiveStepIncrease = 10.0
    return settings


def march(configuration: Configuration, record: bool = False) -> Run:
    """Set the beam up and let Exudyn march it."""
    container, system, sensor, touch = build(configuration, record)
    settings = solver_settings(configuration, record)
    integration = settings.timeIntegration
    records = []
    started, previous = time.process_time(), 0.0
    for end, step in configuration.segments():
        integration.startTime, integration.endTime = previous, end
        integration.numberOfSteps = max(1, round((end - previous) / step))
        system.SolveDynamic(settings, updateInitialValues=True, storeSolver=False)
        if record:
            records.append(system.GetSensorStoredData(sensor))
        previous = end
    processor = time.process_time() - started
    del container
    history = np.vstack(records) if record else np.empty((0, 3))
    return Run(processor, history[:, 0], history[:, 2] - touch)


def impulses(run: Run, stiffness: float = STIFFNESS, end: float = 0.331) -> Impulses:
    """Integrate the stop's force, whose kinks lie where the gap vanishes."""
    force = stiffness * np.maximum(0.0, -run.gap)
    switched = np.flatnonzero((run.gap[1:] < 0.0) != (run.gap[:-1] < 0.0))
    before, after = run.gap[switched], run.gap[switched + 1]
    switches = run.time[switched] + (run.time[switched + 1] - run.time[switched]) * before / (before - after)
    if switches.size < 2:
        return Impulses(np.nan, np.nan, float(force.max()), switches)
    times = np.concatenate([run.time, switches])
    order = np.argsort(times, kind="stable")
    times, force = times[order], np.concatenate([force, np.zeros(switches.size)])[order]
    running = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(times))])
    begin, release, last = np.interp([switches[0], switches[1], end], times, running)
    return Impulses(float(release - begin), float(last - begin), float(force.max()), switches)


def whole_motion(configuration: Configuration) -> str:
    """Return the processor seconds of the whole motion, or that it fails."""
    try:
        return f"{march(configuration).processor:8.4f}"
    except load_exudyn().SolverError:
        return "   fails"


def scan(radii: Iterable[float] = (0.9, 1.0)) -> None:
    """Print the cheapest configurations up to the first release that meet the tolerance.

    A configuration is reliable if every one of the scan with at least as many elements and
    no larger steps meets the tolerance too.
    """
    elements = (4, 6, 7, 8, 9, 10, 11, 12, 13, 14, 16, 20)
    steps = (1e-3, 5e-4, 3e-4, 2e-4, 1.5e-4, 1.2e-4, 1e-4, 8e-5, 7e-5, 6e-5, 5e-5, 4e-5)
    contact_steps = (1e-4, 6e-5, 5e-5, 4e-5, 3e-5, 2.5e-5, 2e-5, 1.5e-5, 1e-5)
    exu = load_exudyn()
    for radius in radii:
        found: dict[tuple[int, float, float], tuple[float, float]] = {}
        for key in itertools.product(elements, steps, contact_steps):
            if key[2] > key[1]:
                continue
            try:
                run = march(Configuration(*key, FIRST_CONTACT, radius, FIRST_CONTACT[0][1]), record=True)
            except exu.SolverError:
                found[key] = (np.inf, np.inf)
                continue
            found[key] = (run.processor, impulses(run).first_contact / FIRST_CONTACT_IMPULSE - 1.0)
        hits = [key for key, (_, error) in found.items() if abs(error) < TOLERANCE]
        reliable = [
            key
            for key in hits
            if all(
                abs(error) < TOLERANCE
                for (n, h, hc), (_, error) in found.items()
                if n >= key[0] and h <= key[1] and hc <= key[2]
            )
        ]
        for title, keys in (("hits", hits), ("reliable", reliable)):
            print(
                f"spectral radius {radius:g}, {title}: elements, step, contact step, CPU s to 0.3203 s, error, "
                "CPU s to the end with small steps in the first contact, in all collisions"
            )
            for key in sorted(keys, key=lambda key: found[key][0])[:12]:
                numbers = f"{key[0]:3d} {key[1]:8.1e} {key[2]:8.1e} {found[key][0]:8.4f} {found[key][1]:+9.1e}"
                print(" ", numbers, *(whole_motion(Configuration(*key, each, radius)) for each in WINDOWS))


def limit(stiffness: float = STIFFNESS) -> None:
    """Print the impulses of fine meshes and steps; the first collision with other stops ends by 0.345 s."""
    end = 0.331 if stiffness == STIFFNESS else 0.345
    fine = replace(LIMIT, stiffness=stiffness, end_time=end, windows=((0.317, end),))
    for n, step in ((24, 2e-6), (32, 2e-6), (32, 1e-6), (48, 2e-6), (48, 1e-6), (64, 2e-6), (64, 1e-6)):
        found = impulses(march(replace(fine, elements=n, contact_step=step), record=True), stiffness, end)
        print(
            f"{n:3d} elements, {step:.0e} s: first contact {found.first_contact:.7f} N s, "
            f"collision {found.first_collision:.7f} N s, peak {found.peak_force:.2f} N, "
            f"switches {np.array2string(found.switches, precision=6, max_line_width=200)}"
        )


def main(arguments: list[str]) -> None:
    """Measure and print."""
    if importlib.util.find_spec("exudyn") is None:
        print("exudyn is not installed; optional: pip install exudyn")
        return
    if "--scan" in arguments:
        scan()
    elif "--limit" in arguments:
        limit(*map(float, arguments[arguments.index("--limit") + 1 :]))
    else:
        print(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])

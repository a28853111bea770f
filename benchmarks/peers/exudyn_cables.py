"""The beam in Exudyn: ANCF cable elements on penalties, which are springs at nodes or at segments of elements."""

from __future__ import annotations

import itertools
import sys
import time
from math import cos, sin
from typing import Any

import numpy as np

from oblique_impact import Scenario
from peers.problems import Circle, Found, Side, obstacles_of

SEGMENTS = 8  # straight pieces of an element that meet a circle
#: time (s) before which nothing touches, marched with long steps
FLIGHT = {"slope": 0.315, "slap": 0.372, "circles": 0.368}
LONG_STEP = 1e-4  # s


def load() -> Any:
    """Return Exudyn, in its build without checks of ranges."""
    sys.exudynFast = True  # type: ignore[attr-defined]
    import exudyn

    return exudyn


class Cables:
    """The beam in a frame whose first axis is the side: what a node's second coordinate measures is then the gap.

    Attributes
    ----------
    springs : list of (int, float, int)
        Sensor, stiffness (N/m) and number of gaps of each contact.
    """

    def __init__(self, scenario: Scenario, elements: int, bedding: float) -> None:
        self.exudyn = load()
        self.items = self.exudyn.itemInterface
        self.container = self.exudyn.SystemContainer()
        self.system = self.container.AddSystem()
        self.springs: list[tuple[int, float, int]] = []
        obstacles = obstacles_of(scenario)
        tilt = sum(obstacle.angle for obstacle in obstacles if isinstance(obstacle, Side))
        angle, self.length = scenario.initial.angle - tilt, scenario.beam.length / elements
        self.axis = cos(angle), sin(angle)
        self.nodes = [self._add_node(i) for i in range(elements + 1)]
        self.cables = [self._add_cable(scenario, pair, tilt) for pair in itertools.pairwise(self.nodes)]
        self.ground = self._marker("NodeCoordinate", nodeNumber=self._add("Node", "NodePointGround"), coordinate=0)
        for coordinate in (0, 1):
            pin = self._marker("NodeCoordinate", nodeNumber=self.nodes[0], coordinate=coordinate)
            self._add("Object", "ObjectConnectorCoordinate", markerNumbers=[self.ground, pin])
        for obstacle in obstacles:
            if isinstance(obstacle, Circle):
                self._add_circle(obstacle, bedding)
            else:
                self._add_side(obstacle, bedding)
        self.system.Assemble()

    def _add(self, kind: str, name: str, **arguments: Any) -> int:
        number: int = getattr(self.system, f"Add{kind}")(getattr(self.items, name)(**arguments))
        return number

    def _marker(self, kind: str, **arguments: Any) -> int:
        return self._add("Marker", f"Marker{kind}", **arguments)

    def _add_node(self, i: int) -> int:
        place = [self.length * i * component for component in self.axis]
        return self._add("Node", "NodePoint2DSlope1", referenceCoordinates=[*place, *self.axis])

    def _add_cable(self, scenario: Scenario, nodes: tuple[int, int], tilt: float) -> int:
        beam = scenario.beam
        bending, axial = beam.youngs_modulus * beam.second_moment, beam.youngs_modulus * beam.area
        cable = self._add(
            "Object",
            "ObjectANCFCable2D",
            length=self.length,
            massPerLength=beam.density * beam.area,
            bendingStiffness=bending,
            axialStiffness=axial,
            bendingDamping=beam.kelvin_voigt * bending,
            axialDamping=beam.kelvin_voigt * axial,
            nodeNumbers=list(nodes),
        )
        gravity = [-scenario.gravity * sin(tilt), -scenario.gravity * cos(tilt), 0.0]
        mass = self._marker("BodyMass", bodyNumber=cable)
        self._add("Load", "LoadMassProportional", markerNumber=mass, loadVector=gravity)
        return cable

    def _add_spring(self, kind: str, gaps: list[float], stiffness: float, count: int, **arguments: Any) -> None:
        state = self._add("Node", "NodeGenericData", initialCoordinates=gaps, numberOfDataCoordinates=len(gaps))
        self._add("Object", kind, nodeNumber=state, contactStiffness=stiffness, **arguments)
        coordinates = self.exudyn.OutputVariableType.Coordinates
        sensor = self._add(
            "Sensor",
            "SensorNode",
            nodeNumber=state,
            writeToFile=False,
            storeInternal=True,
            outputVariableType=coordinates,
        )
        self.springs.append((sensor, stiffness, count))

    def _add_side(self, side: Side, bedding: float) -> None:
        """Give every node but the pin a spring, with its share of the bedding."""
        line = side.x * side.normal[0] + side.y * side.normal[1]
        for i, node in enumerate(self.nodes[1:], start=1):
            share = self.length if i < len(self.nodes) - 1 else 0.5 * self.length
            offset = line - self.length * i * self.axis[1]
            markers = [self.ground, self._marker("NodeCoordinate", nodeNumber=node, coordinate=1)]
            self._add_spring(
                "ObjectContactCoordinate", [-offset], bedding * share, 1, markerNumbers=markers, offset=offset
            )

    def _add_circle(self, circle: Circle, bedding: float) -> None:
        center = self._marker(
            "BodyRigid", bodyNumber=self._add("Object", "ObjectGround"), localPosition=[circle.x, circle.y, 0.0]
        )
        for cable in self.cables:
            shape = self._marker("BodyCable2DShape", bodyNumber=cable, numberOfSegments=SEGMENTS)
            self._add_spring(
                "ObjectContactFrictionCircleCable2D",
                [0.1] * SEGMENTS + [-2.0] * SEGMENTS + [0.0] * SEGMENTS,  # gap, undefined state, place of stick
                bedding * self.length / SEGMENTS,
                SEGMENTS,
                markerNumbers=[center, shape],
                numberOfContactSegments=SEGMENTS,
                circleRadius=circle.radius,
            )

    def march(self, begin: float, end: float, step: float) -> None:
        """March from one time (s) to the next."""
        settings = self.exudyn.SimulationSettings()
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = 1e-12  # every step
        settings.linearSolver.solverType = self.exudyn.LinearSolverType.EigenSparse
        integration = settings.timeIntegration
        integration.verboseMode = 0
        integration.startTime, integration.endTime = begin, end
        integration.numberOfSteps = round((end - begin) / step)
        # at 1e10 N/m^2 the solver gives up with the modified method, and where steps in which contact switches
        # are repeated
        integration.newton.useModifiedNewton = False
        integration.discontinuous.maxIterations = 1
        # the default 1e-10 N lies below the round-off of the axial force, E A = 2e7 N
        integration.newton.relativeTolerance, integration.newton.absoluteTolerance = 1e-3, 1e-3
        integration.solverType = self.exudyn.DynamicSolverType.GeneralizedAlpha
        integration.generalizedAlpha.spectralRadius = 0.9
        self.system.SolveDynamic(settings, updateInitialValues=True, storeSolver=False)


def march(problem: str, scenario: Scenario, elements: int, step: float, bedding: float) -> Found:
    """March the cables to the end of the scenario, on penalties of a bedding (N/m^2) times their lengths."""
    cables = Cables(scenario, elements, bedding)
    flight = FLIGHT[problem]
    started = time.process_time()
    cables.march(0.0, flight, LONG_STEP)
    cables.march(flight, scenario.end_time, step)
    processor, total, depth = time.process_time() - started, 0.0, 0.0
    for sensor, stiffness, count in cables.springs:
        rows = cables.system.GetSensorStoredData(sensor)
        depths = np.maximum(0.0, -rows[:, 1 : 1 + count])
        total += stiffness * float(np.trapezoid(depths.sum(axis=1), rows[:, 0]))
        depth = max(depth, float(depths.max()))
    return Found(total, depth, processor)

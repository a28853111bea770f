"""A circle in Exudyn that its friction holds on a cable, which is itself held at all nodes."""

from __future__ import annotations

from math import cos, sin
from typing import Any

from peers.exudyn_cables import load

SEGMENTS, RADIUS, PLACE = 4, 0.1, 0.4  # of a cable of 1 m; m; m, inside of a segment
STEP, DURATION = 1e-3, 3.0  # s


class Block:
    """A circle of 1 kg that does not turn, on a slope, with friction 0.5."""

    def __init__(self, gravity: float, slope: float, **friction: float) -> None:
        self.exudyn = load()
        self.items, self.system = self.exudyn.itemInterface, self.exudyn.SystemContainer().AddSystem()
        add, items = self.system, self.items
        self.fixed = self._coordinate(add.AddNode(items.NodePointGround()), 0)
        nodes = [add.AddNode(items.NodePoint2DSlope1(referenceCoordinates=[x, 0.0, 1.0, 0.0])) for x in (0.0, 1.0)]
        cable = add.AddObject(
            items.ObjectANCFCable2D(
                length=1.0, massPerLength=1.0, bendingStiffness=1e3, axialStiffness=1e6, nodeNumbers=nodes
            )
        )
        self.circle = add.AddNode(items.NodeRigidBody2D(referenceCoordinates=[PLACE, RADIUS, 0.0]))
        body = add.AddObject(items.ObjectRigidBody2D(mass=1.0, inertia=1.0, nodeNumber=self.circle))
        for node, coordinate in [(node, k) for node in nodes for k in range(4)] + [(self.circle, 2)]:
            held = [self.fixed, self._coordinate(node, coordinate)]
            add.AddObject(items.ObjectConnectorCoordinate(markerNumbers=held))
        middle = add.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=[0.0] * 3))
        weight = [gravity * sin(slope), -gravity * cos(slope), 0.0]
        add.AddLoad(items.LoadForceVector(markerNumber=middle, loadVector=weight))
        shape = add.AddMarker(items.MarkerBodyCable2DShape(bodyNumber=cable, numberOfSegments=SEGMENTS))
        states = [0.1] * SEGMENTS + [-2.0] * SEGMENTS + [0.0] * SEGMENTS  # gap, undefined state, place of stick
        node = add.AddNode(items.NodeGenericData(initialCoordinates=states, numberOfDataCoordinates=len(states)))
        contact = items.ObjectContactFrictionCircleCable2D(
            markerNumbers=[add.AddMarker(items.MarkerBodyRigid(bodyNumber=body)), shape],
            nodeNumber=node,
            numberOfContactSegments=SEGMENTS,
            contactStiffness=1e5,
            contactDamping=100.0,
            frictionCoefficient=0.5,
            circleRadius=RADIUS,
            **friction,
        )
        add.AddObject(contact)
        add.Assemble()

    def _coordinate(self, node: int, coordinate: int) -> int:
        marker: int = self.system.AddMarker(
            self.items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate)
        )
        return marker

    def creep(self) -> float:
        """Return the mean speed (m/s) after the first second."""
        kinds, places = self.exudyn.OutputVariableType, []

        def note(_: Any, time: float) -> bool:
            places.append(float(self.system.GetNodeOutput(self.circle, kinds.Coordinates)[0]))
            return True

        self.system.SetPreStepUserFunction(note)
        settings = self.exudyn.SimulationSettings()
        settings.solution.file.write = False
        settings.timeIntegration.endTime = DURATION
        settings.timeIntegration.numberOfSteps = round(DURATION / STEP)
        settings.timeIntegration.verboseMode = 0
        settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
        self.system.SolveDynamic(settings)
        second = round(1.0 / STEP)
        return (places[-1] - places[second]) / (STEP * (len(places) - 1 - second))

"""The spin-up of Simo and Vu-Quoc in Exudyn: smallest tip deflection and its time.

    python benchmarks/exudyn_spin_up.py [ELEMENTS [STEP]]     default: 20 elements, 1e-3 s

Exudyn (optional: pip install exudyn) marches 2D ANCF cable elements (extensible, geometrically exact,
Bernoulli-Euler).  Root: position fixed, slope vector turned by theta(t).  The deflection is the tip's distance
from the line through the root at theta(t).
"""

from __future__ import annotations

import itertools
import sys
from typing import Any

import exudyn as exu
import numpy as np

LENGTH, BENDING, AXIAL, MASS = 10.0, 1.4e4, 2.8e7, 1.2  # m, N m², N, kg/m
items = exu.itemInterface
SPIN, RISE, END = 6.0, 15.0, 8.0  # rad/s, s, s (past the minimum)


def angle(t: float) -> float:
    """Return theta(t) (rad)."""
    if t >= RISE:
        return 0.5 * SPIN * RISE + SPIN * (t - RISE)
    return SPIN / RISE * (0.5 * t**2 + (RISE / (2.0 * np.pi)) ** 2 * (np.cos(2.0 * np.pi * t / RISE) - 1.0))


def _cosine(mbs: Any, t: float, item: int, offset: float) -> float:
    return float(np.cos(angle(t)) - 1.0)


def _sine(mbs: Any, t: float, item: int, offset: float) -> float:
    return float(np.sin(angle(t)))


def march(elements: int = 20, step: float = 1e-3) -> tuple[np.ndarray, np.ndarray]:
    """Return times (s) and tip deflections (m)."""
    container = exu.SystemContainer()
    system = container.AddSystem()
    nodes = [
        system.AddNode(items.NodePoint2DSlope1(referenceCoordinates=[LENGTH * i / elements, 0.0, 1.0, 0.0]))
        for i in range(elements + 1)
    ]
    for pair in itertools.pairwise(nodes):
        system.AddObject(
            items.ObjectANCFCable2D(
                length=LENGTH / elements,
                massPerLength=MASS,
                bendingStiffness=BENDING,
                axialStiffness=AXIAL,
                nodeNumbers=list(pair),
                useReducedOrderIntegration=0,
            )
        )
    ground = system.AddMarker(
        items.MarkerNodeCoordinate(nodeNumber=system.AddNode(items.NodePointGround()), coordinate=0)
    )
    for coordinate, function in enumerate((0, 0, _cosine, _sine)):
        root = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=coordinate))
        system.AddObject(
            items.ObjectConnectorCoordinate(markerNumbers=[ground, root], offsetUserFunction=function)
        )
    sensor = system.AddSensor(
        items.SensorNode(
            nodeNumber=nodes[-1], outputVariableType=exu.OutputVariableType.Position, storeInternal=True
        )
    )
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = END
    settings.timeIntegration.numberOfSteps = round(END / step)
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = step
    settings.timeIntegration.verboseMode = 0
    system.SolveDynamic(settings)
    record = system.GetSensorStoredData(sensor)
    turned = np.array([angle(t) for t in record[:, 0]])
    return record[:, 0], record[:, 2] * np.cos(turned) - record[:, 1] * np.sin(turned)


def main(arguments: list[str]) -> None:
    """Print the minimum."""
    elements = int(arguments[0]) if arguments else 20
    step = float(arguments[1]) if arguments[1:] else 1e-3
    times, tip = march(elements, step)
    low = int(np.argmin(tip))
    print(f"{elements} elements, {step:g} s: smallest deflection {tip[low]:.6f} m at {times[low]:.3f} s")


if __name__ == "__main__":
    main(sys.argv[1:])

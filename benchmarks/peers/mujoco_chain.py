"""The beam in MuJoCo: a chain of rigid links, with the bending stiffness and damping of a link at each hinge.

Contacts are as hard as MuJoCo lets them be: a time constant of two steps.  Links are capsules of 1 mm, and
obstacles smaller by as much, so that it is their axes that touch.
"""

from __future__ import annotations

import time
from math import degrees

import numpy as np

from oblique_impact import Scenario
from peers.problems import Circle, Found, obstacles_of

RADIUS = 1e-3  # m
#: impedance over depth (m): nearly 1 from a tenth of a millimetre on
IMPEDANCE = "0.95 0.99 1e-4 0.5 2"


def model_of(scenario: Scenario, links: int, step: float) -> str:
    """Return the model in MuJoCo's XML; gravity points along -z, the beam moves in the plane of x and z."""
    beam, length = scenario.beam, scenario.beam.length / links
    mass = beam.density * beam.area * length
    stiffness = beam.youngs_modulus * beam.second_moment / length
    lines = [
        "<mujoco><compiler angle='degree' inertiafromgeom='false'/>",
        f"<option timestep='{step}' gravity='0 0 {-scenario.gravity}' integrator='implicitfast'/>",
        f"<default><geom condim='1' solref='{2.0 * step} 1' solimp='{IMPEDANCE}'/></default><worldbody>",
    ]
    for obstacle in obstacles_of(scenario):
        other = "contype='2' conaffinity='1'"
        if isinstance(obstacle, Circle):
            size, place = obstacle.radius - RADIUS, f"{obstacle.x} 0 {obstacle.y}"
            lines.append(f"<geom type='sphere' size='{size}' pos='{place}' {other}/>")
        else:
            x, y = obstacle.normal
            place = f"{obstacle.x - RADIUS * x} 0 {obstacle.y - RADIUS * y}"
            lines.append(f"<geom type='plane' size='5 5 1' pos='{place}' zaxis='{x} 0 {y}' {other}/>")
    for i in range(links):
        inertia = f"{mass * length**2 / 12.0} " * 3
        place = f"pos='{length} 0 0'" if i else f"euler='0 {-degrees(scenario.initial.angle)} 0'"
        spring = f"stiffness='{stiffness}' damping='{beam.kelvin_voigt * stiffness}'" if i else ""
        lines += [
            f"<body {place}><inertial pos='{length / 2} 0 0' mass='{mass}' diaginertia='{inertia}'/>",
            f"<joint type='hinge' axis='0 1 0' {spring}/>",
            f"<geom type='capsule' fromto='0 0 0 {length} 0 0' size='{RADIUS}' contype='1' conaffinity='2'/>",
        ]
    return "\n".join([*lines, "</body>" * links, "</worldbody></mujoco>"])


def march(scenario: Scenario, links: int, step: float) -> Found:
    """March the chain from rest to the end of the scenario."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(model_of(scenario, links, step))
    data, force, impulse, depth = mujoco.MjData(model), np.zeros(6), 0.0, 0.0
    started = time.process_time()
    while data.time < scenario.end_time - 0.5 * step:
        mujoco.mj_step(model, data)
        for i in range(data.ncon):
            mujoco.mj_contactForce(model, data, i, force)
            impulse += step * float(force[0])
            depth = max(depth, -float(data.contact[i].dist))
    return Found(impulse, depth, time.process_time() - started)

"""Bars that nothing holds, dropped on a floor: tilted, nearly flat, and upright."""

from __future__ import annotations

import numpy as np

from questions.independent_strip import Spring, Strip
from questions.question import Question, Row, run

_LENGTH, _DIAMETER, _DENSITY, _MODULUS = 0.2, 0.006, 7800.0, 2.1e11
_AREA = np.pi / 4.0 * _DIAMETER**2
_MASS = _DENSITY * _AREA * _LENGTH
_IMPEDANCE = _AREA * np.sqrt(_MODULUS * _DENSITY)  # N s/m, of a wave along the bar

_TILT = """\
oblique-impact run dropped-bar --set initial.angle=-0.95532 --set "initial.position=[0, 0.08166]" \\
    --set "initial.velocity=[0, -0.1]" --set contact.stiffness=1e3 --set contact.grid=1 --set gravity=0 \\
    --set contact.friction=frictionless --set end_time=0.03 --set solver.free_step=2e-5 --out out/tilt"""

_CLATTER = """\
oblique-impact run dropped-bar --set initial.angle=-0.0349066 --set "initial.position=[0, 0.0034909]" \\
    --set "initial.velocity=[0, -0.1]" --set contact.stiffness=1e3 --set contact.grid=1 --set gravity=0 \\
    --set contact.friction=frictionless --set end_time=0.045 --set solver.free_step=2e-5 --out out/clatter"""

_ROUGH = """\
oblique-impact run dropped-bar --set initial.angle=-0.785398 --set "initial.position=[0, 0.0707117]" \\
    --set "initial.velocity=[0, -0.1]" --set contact.stiffness=1e3 --set contact.grid=1 --set gravity=0 \\
    --set contact.mu_static=0.7 --set contact.mu_kinetic=0.7 --set end_time=0.02 --set solver.free_step=2e-5 \\
    --out out/rough"""

_ROD = """\
oblique-impact run dropped-bar --set initial.angle=-1.5707963267948966 --set "initial.position=[0, 0.100001]" \\
    --set contact.grid=1 --set contact.friction=frictionless --set gravity=0 --set beam.kelvin_voigt=0 \\
    --set contact.stiffness=2.97e7 --set discretization.elements=32 --set end_time=4e-4 \\
    --set solver.free_step=2e-7 --set solver.output_interval=1e-6 --set solver.tolerance=1e-10 --out out/rod"""

_DASHPOT = _ROD.replace("2.97e7", "2.97e4 --set contact.linear_damping=2288").replace("out/rod", "out/dashpot")


def _dropped(degrees: float, above: float = 1e-6) -> tuple[str, str]:
    """Return the keys of a bar at a tilt whose lower end is just above the floor."""
    tilt = np.radians(degrees)
    return f"initial.angle={-tilt}", f"initial.position=[0, {0.5 * _LENGTH * np.sin(tilt) + above}]"


def _impulse(tilt: float, friction: float) -> float:
    """Return the impulse over m v that the end of a rigid bar takes from an elastic floor (Routh).

    Flexibilities of the end, times m: across the floor, along it, and between both.  It sticks where that takes
    less friction than there is; else it slides all the time, since it begins to at once.
    """
    across, along = 1.0 + 3.0 * np.cos(tilt) ** 2, 1.0 + 3.0 * np.sin(tilt) ** 2
    between = 3.0 * np.sin(tilt) * np.cos(tilt)
    return float(2.0 / (across - between * min(friction, between / along)))


def tilt() -> list[Row]:
    """Return the impulse and what the centre has left, over the tilt."""
    rows = []
    for degrees in (15.0, 30.0, 45.0, 54.7356, 70.0, 80.0):
        history = run(_TILT, *_dropped(degrees))
        size = history.contacts[0].normal_impulse / (0.1 * _MASS)
        values = {"impulse over m v": (size, _impulse(np.radians(degrees), 0.0))}
        rows.append(Row(f"{degrees:.1f}°", values | {"rebound of the centre over v": (size - 1.0, None)}))
    return rows


def clatter() -> list[Row]:
    """Return how fast each end arrives, on a soft floor, where the bar is rigid, and on a stiff one."""
    rows = []
    stiff = "contact.stiffness=2e7", "initial.velocity=[0, -1]", "end_time=0.0045", "solver.free_step=1e-5"
    for name, sets, speed, others in (
        ("soft, 10³ N/m", (), 0.1, (2.0, 0.5, 1)),
        ("stiff, 2·10⁷ N/m", stiff, 1.0, _second_end()),
    ):
        history = run(_CLATTER, *sets)
        impacts = [event for event in history.events if event.kind.value == "impact"]
        second = next(event for event in impacts if event.place < 0.5 * _LENGTH)
        before = [contact for contact in history.contacts if contact.start < second.time]
        values = {
            "second end over first": (-second.normal_velocity / speed, others[0]),
            "impulse before, over m v": (sum(c.normal_impulse for c in before) / (_MASS * speed), others[1]),
            "contacts before": (float(len(before)), float(others[2])),
        }
        rows.append(Row(name, values))
    return rows


def _second_end(tilt: float = 0.0349066) -> tuple[float, float, int]:
    """Return the same three of an elastic bar on the stiff floor, by bending of small angles."""
    second = np.pi / 64.0 * _DIAMETER**4
    bar = Strip(_LENGTH, _MODULUS * second, _DENSITY * _AREA, 16, 20, root="free", kelvin_voigt=1e-6)
    falls = np.zeros(bar.K.shape[0])
    falls[::2] = -1.0
    _, states, touches = bar.march((np.zeros(20), bar.amplitudes(falls)), [Spring(16, 2e7)], 0.0045, 1e-6)
    fallen, rate = states[:, :20] @ bar.row(0), states[:, 20:] @ bar.row(0)
    arrives = np.argmax(fallen <= -_LENGTH * np.sin(tilt))
    return float(-rate[arrives]), sum(touch.impulse for touch in touches) / _MASS, len(touches)


def rough() -> list[Row]:
    """Return the impulse and what the centre has left, over friction, at 45 degrees."""
    rows = []
    for friction in (0.1, 0.3, 0.5, 0.7):
        history = run(_ROUGH, f"contact.mu_static={friction}", f"contact.mu_kinetic={friction}")
        size = history.contacts[0].normal_impulse / (0.1 * _MASS)
        values = {"impulse over m v": (size, _impulse(np.pi / 4.0, friction))}
        rows.append(Row(f"{friction:g}", values | {"rebound of the centre over v": (size - 1.0, None)}))
    return rows


def rod_on(spring: float, dashpot: float = 0.0, steps: int = 4000) -> float:
    """Return the restitution of a rod that falls upright on a spring and a dashpot, by its waves.

    `spring` is k L/(E A), `dashpot` c over the impedance Z of the rod; times are in those of a wave along the rod,
    which comes back from the free end after two.  Its foot has v = 1 - F/Z - (2/Z) (F of 2, 4, ... before).
    """
    h, push = 2.0 / steps, [dashpot / (1.0 + dashpot)]
    depth, rate, impulse, back = 0.0, 1.0 / (1.0 + dashpot), 0.0, [0.0]
    while True:
        i = len(push)
        back.append(back[i - steps] + push[i - steps] if i >= steps else 0.0)
        now = (1.0 - 2.0 * back[i] - spring * (depth + 0.5 * h * rate)) / (1.0 + 0.5 * h * spring + dashpot)
        depth += 0.5 * h * (rate + now)
        force = spring * depth + dashpot * now
        if force < 0.0:
            return impulse - 1.0
        impulse += 0.5 * h * (push[-1] + force)
        push.append(force)
        rate = now


def rod() -> list[Row]:
    """Return the restitution over the stiffness of the floor."""
    rows = []
    for over in (0.1, 0.5, 1.0, 1.5, 3.0, 10.0):
        changes = f"contact.stiffness={over * _MODULUS * _AREA / _LENGTH}", f"end_time={1e-4 + 2e-4 / over**0.5}"
        found = sum(contact.normal_impulse for contact in run(_ROD, *changes).contacts) / _MASS - 1.0
        left = {"left in vibrations (%)": (100.0 * (1.0 - found**2), None)}
        rows.append(Row(f"{over:g} E A/L", {"restitution": (found, rod_on(over))} | left))
    return rows


def dashpot() -> list[Row]:
    """Return the restitution over the dashpot."""
    rows = []
    for over in (1.0, 2.0, 4.0, 8.0):
        history = run(_DASHPOT, f"contact.linear_damping={over * _IMPEDANCE}", "end_time=3e-4")
        size = sum(contact.normal_impulse for contact in history.contacts) / _MASS
        values = {"impulse over m v": (size, 1.0 + (over - 1.0) / (over + 1.0))}
        rows.append(Row(f"{over:g} Z", values | {"restitution": (size - 1.0, None)}))
    return rows


QUESTIONS = [
    Question(
        name="tilt",
        title="An elastic bar falls, tilted by 55°, on an elastic floor without friction. How high does its "
        "centre rise?",
        guess="with 0.8 of its speed or so; the least is flat or upright",
        answer="not at all, it stops; at 30° it falls on with {1[rebound of the centre over v]:.2f} of its speed",
        wrong=True,
        cost=100,
        price="a rebound that is not there",
        why="Nothing is lost, but the floor pushes at one end: it takes the impulse 2 m v/(1 + 3 cos²) and turns "
        "the bar. Where the cosine squared is 1/3, at 54.7°, this is m v, which stops the centre: all of the "
        "energy is in the rotation. Any flatter, and the centre goes on falling after an elastic impact.",
        command=_TILT,
        cases="tilt",
        beside="a rigid bar, impulse 2 m v/(1 + 3 cos² of the tilt)",
        compute=tilt,
        within=2e-2,
    ),
    Question(
        name="clatter",
        title="A bar falls nearly flat (2°) with 1 m/s. How fast does its second end arrive?",
        guess="1 m/s, a little more perhaps: 1.2 m/s",
        answer="with {0[second end over first]:.2f} m/s, on a stiff floor with {1[second end over first]:.2f} m/s",
        wrong=True,
        cost=90,
        price="a drop test that is four to five times as hard on one end as on the other",
        why="The impulse at the end that comes first, m v/2, leaves the centre with v/2, still downward, and "
        "turns the bar with 3 v/L: the other end comes with v/2 + 3 v/2 = 2 v. On a stiff floor the bar bends, "
        "the first end strikes {1[contacts before]:.0f} times, and the sum of its impulses is smaller. The other "
        "end is faster nevertheless, because the bar vibrates as it comes down.",
        command=_CLATTER,
        cases="floor",
        beside="a rigid bar, 2, and on the stiff floor a bar in modes of small bending (`independent_strip.py`)",
        compute=clatter,
        within=3e-2,  # without shear, the bar is at another phase of its vibration after five contacts
    ),
    Question(
        name="rough",
        title="A bar falls at 45° on a rough elastic floor. Does friction lower the rebound of its centre?",
        guess="yes, by 20 %",
        answer="it makes one: {3[rebound of the centre over v]:+.2f} v with a coefficient of 0.7, "
        "{0[rebound of the centre over v]:+.2f} v with 0.1",
        wrong=True,
        cost=120,
        price="the wrong sign of the centre's velocity",
        why="The lower end wants to slide outward as the bar turns; friction holds it and so holds the bar from "
        "turning away under the push of the floor. The end seems heavier, and takes a larger impulse to turn "
        "back. Above 0.6 it sticks, and friction does no work at all.",
        command=_ROUGH,
        cases="friction coefficient",
        beside="a rigid bar with Routh's impact, 2 m v/(a - min(μ, c/b) c), a = 1 + 3 cos², b = 1 + 3 sin², c = "
        "3 sin cos",
        compute=rough,
        within=1e-2,
    ),
    Question(
        name="rod",
        title="A rod falls upright on its end. Which floor leaves most of the energy in its vibrations?",
        guess="the stiffest; a rigid one leaves a third of it, a restitution of 0.8",
        answer="one of about 1.3 times the stiffness of the rod, and it leaves {3[left in vibrations (%)]:.1f} "
        "%; on a stiffer one the restitution rises again, {5[restitution]:.4f} on 10 E A/L",
        wrong=True,
        cost=30,
        price="an energy that is not lost",
        why="On a rigid floor one wave runs up the rod and back, and when it comes to the foot all of the rod "
        "has its speed again, upward: the restitution is 1. On a soft one the rod is pressed slowly and does not "
        "vibrate. Between them the foot leaves before or after the wave is there, and little is left.",
        command=_ROD,
        cases="floor",
        beside="the waves of the rod, a difference equation in time (`rod_on`)",
        compute=rod,
        within=1e-3,
    ),
    Question(
        name="dashpot",
        title="A rod falls upright on a dashpot that just stops its rebound. What does twice the dashpot do?",
        guess="nothing, the restitution stays 0: more damping is less rebound",
        answer="it makes the rod rebound with {1[restitution]:.2f} of its speed, four times with "
        "{2[restitution]:.2f}",
        wrong=True,
        cost=60,
        price="a damper that is chosen stronger to be safe, and throws back",
        why="A dashpot of the impedance Z = A √(E ρ) of the rod ends it as an endless rod would: the wave of the "
        "impact comes back and leaves the rod at rest. A stronger one is closer to a rigid floor and returns a "
        "part of the wave, (c - Z)/(c + Z). The restitution has its least value at one damping, and no more of "
        "it helps.",
        command=_DASHPOT,
        cases="dashpot",
        beside="reflection of a wave, 1 + (c - Z)/(c + Z)",
        compute=dashpot,
        within=1e-2,
    ),
]

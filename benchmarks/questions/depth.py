"""How deep a beam is."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, pi, sqrt

from questions.independent import Beam, fall
from questions.question import Question, Row, run

_ON_SPRING = """\
oblique-impact run paper --set contact.normal=spring --set contact.stiffness=1e6 --set beam.kelvin_voigt=1e-5 \\
    --set "beam.section={shape='rectangle', width=0.03, height=0.04}" --set discretization.frame=mean-axis \\
    --set discretization.modes=16 --set contact.friction=frictionless --set end_time=0.4 --out out/depth"""
_ON_RIGID = """\
oblique-impact run paper --set contact.point_inertia=none --set beam.kelvin_voigt=1e-5 \\
    --set "beam.section={shape='rectangle', width=0.03, height=0.04}" --set discretization.frame=mean-axis \\
    --set discretization.modes=16 --set contact.friction=frictionless --set end_time=0.4 --out out/depth"""


def _rows(command: str, stop: float, sections: Sequence[tuple[float, float, int]]) -> list[Row]:
    rows = []
    for width, depth, modes in sections:
        history = run(command, f"beam.section.width={width}", f"beam.section.height={depth}")
        mass, stiffness = 2766.7 * width * depth, 68.952e9 * width * depth**3 / 12.0
        other = fall(Beam(mass=mass, stiffness=stiffness, kelvin_voigt=1e-5, modes=modes), stop)
        contacts, lost = history.contacts, history.summary["energy"]["lost_damping"]
        period = 2.0 * pi / (3.926602312**2 * sqrt(stiffness / mass))
        values = {
            # on a rigid stop the other one rests on the flexibility of many undamped modes, and hums
            "contacts": (len(contacts), len(other.contacts) if stop < inf else None),
            "stay over first period": ((contacts[-1].end - contacts[0].start) / period, None),
            "impulse (N s)": (sum(contact.normal_impulse for contact in contacts), other.impulse),
            "loss (J)": (lost, other.lost),
            "loss (% of m g L)": (100.0 * lost / (9.8 * mass), 100.0 * other.lost / (9.8 * mass)),
        }
        rows.append(Row(f"{1e3 * width:g} x {1e3 * depth:g} mm", values))
    return rows


_WIDE = ((0.03, 0.02, 16), (0.03, 0.04, 12), (0.03, 0.08, 8))
_NARROW = ((0.02, 0.02, 16), (0.02, 0.04, 12), (0.02, 0.08, 8))


def on_spring() -> list[Row]:
    """Fall onto 1e6 N/m."""
    return _rows(_ON_SPRING, 1e6, (*_WIDE, *_NARROW))


def on_rigid() -> list[Row]:
    """Fall onto a rigid stop."""
    return _rows(_ON_RIGID, inf, _WIDE)


_BESIDE = "modes of Hermite elements over a one-sided spring, in SciPy (`benchmarks/questions/independent.py`)"

QUESTIONS = [
    Question(
        name="depth-spring",
        title="A beam twice as deep falls onto an elastic stop: is it struck more often, does it lose more?",
        guess="more often, its frequencies are twice as high; it loses more, because it has more energy",
        answer="once instead of {0[contacts]:g} times; {1[loss (J)]:.2f} J instead of {0[loss (J)]:.2f} J, a "
        "quarter of the share",
        wrong=True,
        cost=300,
        price="damping that is counted on and not there: nearly all energy comes back",
        why="Twice the depth is twice the mass and twice the frequencies: to the deep beam the stop is soft, and "
        "its stay, in periods of its first mode, longer. So it is turned like a rigid bar, by one blow that "
        "leaves little vibration, which is all that internal damping can take. It is no law of the loss in "
        "joules: a beam 20 mm wide loses more at 40 mm than at 20 mm, and little at 80 mm.",
        command=_ON_SPRING,
        cases="width x depth",
        beside=_BESIDE,
        compute=on_spring,
        within=5e-3,
    ),
    Question(
        name="depth-rigid",
        title="A beam twice as deep falls onto a rigid stop, with internal damping: more blows, more loss?",
        guess="more often, and it loses more",
        answer="less often, {0[contacts]:g}, {1[contacts]:g}, {2[contacts]:g} times; it does lose more, even of "
        "its energy",
        wrong=True,
        cost=40,
        price="the right answer for a wrong reason: rigid and elastic stop are taken for alike",
        why="Against a rigid stop, without damping, all depths are one problem but for the scale of time: each "
        "puts the same share of its energy into vibration. Kelvin-Voigt damping takes the faster vibrations of "
        "the deep beam in fewer periods, so more is gone before it leaves and fewer blows follow. The same "
        "change of the beam turns the loss up here and down on the elastic stop.",
        command=_ON_RIGID,
        cases="width x depth",
        beside=_BESIDE,
        compute=on_rigid,
        within=5e-3,
    ),
]

"""A fall on another planet."""

from __future__ import annotations

from math import sqrt

from questions.independent import Beam, fall
from questions.question import Question, Row, run

_GRAVITY = """\
oblique-impact run paper --set contact.normal=spring --set contact.stiffness=1e6 --set beam.kelvin_voigt=1e-5 \\
    --set gravity=39.2 --set discretization.frame=mean-axis --set discretization.modes=16 \\
    --set contact.friction=frictionless --set end_time=0.19 --out out/gravity"""


def gravity() -> list[Row]:
    """Fall under a sixteenth of it to sixteen times as much."""
    rows = []
    for factor in (1.0 / 16.0, 1.0, 4.0, 16.0):
        end = 0.32 / sqrt(factor) + 0.03
        history = run(_GRAVITY, f"gravity={9.8 * factor}", f"end_time={end}")
        other = fall(Beam(kelvin_voigt=1e-5), 1e6, gravity=9.8 * factor, end=end)
        values = {
            "contacts": (len(history.contacts), len(other.contacts)),
            "impulse over square root of gravity": tuple(
                impulse / sqrt(9.8 * factor)
                for impulse in (sum(contact.normal_impulse for contact in history.contacts), other.impulse)
            ),
        }
        rows.append(Row(f"{9.8 * factor:.3g} m/s²", values))
    return rows


QUESTIONS = [
    Question(
        name="gravity",
        title="The same fall under four times the gravity: how does the impulse grow?",
        guess="twice, as the speed",
        answer="twice, and 2 % more",
        wrong=False,
        cost=0,
        price="",
        why="An elastic stop and small bending are linear: twice the speed is twice everything, at the same "
        "times after the touch-down. What is more is the weight that the stop carries during the stay, which "
        "grows with gravity itself instead of its square root. Large bending would end it: then speed is a "
        "parameter.",
        command=_GRAVITY,
        cases="gravity",
        beside="the modes of `benchmarks/questions/independent.py`",
        compute=gravity,
        within=2e-2,
    ),
]

"""How stiff the material of a beam is."""

from __future__ import annotations

from math import pi, sqrt

from questions.independent import Beam, fall
from questions.question import Question, Row, run

_MODULUS = """\
oblique-impact run paper --set contact.normal=spring --set contact.stiffness=1e6 --set beam.kelvin_voigt=1e-5 \\
    --set beam.youngs_modulus=275.808e9 --set discretization.frame=mean-axis --set discretization.modes=16 \\
    --set contact.friction=frictionless --set end_time=0.4 --out out/modulus"""


def modulus() -> list[Row]:
    """Fall with a quarter of the paper's modulus, with it, and with four times as much."""
    rows = []
    for name, factor in (("E/4", 0.25), ("E", 1.0), ("4 E", 4.0)):
        history = run(_MODULUS, f"beam.youngs_modulus={factor * 68.952e9}")
        other = fall(Beam(stiffness=factor * 68.952e9 * 7.85e-9, kelvin_voigt=1e-5), 1e6)
        stay = history.contacts[-1].end - history.contacts[0].start
        first = 3.926602312**2 * sqrt(factor * 68.952e9 * 7.85e-9 / (2766.7 * 3.14e-4))  # rad/s
        values = {
            "stay over first period": (stay * first / (2.0 * pi), None),
            "contacts": (len(history.contacts), len(other.contacts)),
            "impulse (N s)": (sum(contact.normal_impulse for contact in history.contacts), other.impulse),
            "loss (J)": (history.summary["energy"]["lost_damping"], other.lost),
        }
        rows.append(Row(name, values))
    return rows


QUESTIONS = [
    Question(
        name="modulus",
        title="A stiffer material, four times the modulus, on the same elastic stop: more contacts, more impulse?",
        guess="more contacts, its vibrations are faster; the impulse grows towards that of a rigid bar",
        answer="{0[contacts]:g}, {1[contacts]:g}, {2[contacts]:g} contacts; {0[impulse (N s)]:.3f}, {1[impulse "
        "(N s)]:.3f}, {2[impulse (N s)]:.3f} N s with E/4, E, 4 E",
        wrong=True,
        cost=150,
        price="twice as many blows expected where there are half as many",
        why="What counts is k L³/(E I): four times the modulus is, but for the scale of time, a stop of a "
        "quarter of the stiffness. All three stay at the stop for about two thirds of their first period; how "
        "often the stay is broken depends on how many modes are slow against the stop, and to a soft beam it is "
        "nearly rigid. The impulse is a sum of blows whose phases decide: both others give less than the one "
        "between.",
        command=_MODULUS,
        cases="modulus",
        beside="the modes of `benchmarks/questions/independent.py`",
        compute=modulus,
        within=1e-2,
    ),
]

"""A hub about the pin."""

from __future__ import annotations

from questions.independent import Beam, fall
from questions.question import Question, Row, run

_HUB = """\
oblique-impact run paper --set contact.normal=spring --set contact.stiffness=1e6 --set beam.kelvin_voigt=1e-5 \\
    --set root.kind=hub --set root.inertia=0.1 --set discretization.frame=mean-axis \\
    --set discretization.modes=16 --set contact.friction=frictionless --set end_time=0.42 --out out/hub"""


def hub() -> list[Row]:
    """Fall with none to a third of the beam's moment of inertia about the pin, 0.29 kg m^2."""
    rows = []
    for inertia in (0.0, 0.001, 0.01, 0.02, 0.05, 0.1):
        history = run(_HUB, f"root.inertia={inertia}")
        other = fall(Beam(kelvin_voigt=1e-5, hub=inertia, modes=12), 1e6, end=0.42)
        values = {
            "contacts": (len(history.contacts), len(other.contacts)),
            "impulse (N s)": (sum(contact.normal_impulse for contact in history.contacts), other.impulse),
        }
        rows.append(Row(f"{inertia:g} kg m²", values))
    return rows


QUESTIONS = [
    Question(
        name="hub",
        title="A hub with some inertia about the pin: what does it do to number of contacts and impulse?",
        guess="fewer contacts, because it holds the root; more impulse, the more of it the more",
        answer="a very light one takes a contact and 9 % of the impulse; a heavy one adds a contact and 10 %",
        wrong=True,
        cost=20,
        price="a light hub left out of a model as harmless: it is worth a tenth of the impulse",
        why="A hub counts in a mode by the square of the slope there at the root: with 0.001 kg m² it is 0.3 % "
        "of the inertia in the fall, 3 % in the first mode and a tenth in the second. So a light one already "
        "shifts the phases in which the blows come, and their sum. A heavy one adds momentum, with the square "
        "root of all inertia, and holds the root nearly clamped, so that the beam turns back later and is struck "
        "more often.",
        command=_HUB,
        cases="inertia of the hub",
        beside="the modes of `benchmarks/questions/independent.py`, with the inertia on its first node",
        compute=hub,
        within=5e-3,
    ),
]

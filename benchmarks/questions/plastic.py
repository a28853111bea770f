"""A plastic impact, e = 0, with a mass at the tip."""

from __future__ import annotations

from math import asin, cos, pi, sin

import numpy as np

from questions.independent import Beam, Modes
from questions.question import Question, Row, run

_PLASTIC = """\
oblique-impact run paper --set beam.tip_mass=0.05 --set discretization.method=fem \\
    --set discretization.elements=128 --set discretization.frame=mean-axis --set discretization.modes=64 \\
    --set contact.friction=frictionless --set end_time=0.33 --out out/plastic"""


def plastic() -> list[Row]:
    """Stop the tip once, with more and more modes, without and with a mass."""
    rows = []
    touch = asin(-0.3 * sin(pi / 10.0))  # rad, between beam and slope
    for modes in (1, 4, 16, 64):
        values: dict[str, tuple[float | None, float | None]] = {}
        for mass in (0.0, 0.05):
            history = run(_PLASTIC, f"beam.tip_mass={mass}", f"discretization.modes={modes}")
            first, beam = history.events[0], Beam(tip=mass, elements=128)
            effective = 1.0 / float(np.sum(Modes(beam).at(1.0)[: modes + 1] ** 2)) / cos(touch) ** 2
            drop = 9.8 * (0.5 * beam.mass + mass) * (sin(pi / 4.0) - sin(touch + pi / 10.0))
            loss = effective * drop / (beam.mass / 3.0 + mass) * cos(touch) ** 2
            name = f"{1e3 * mass:g} g: "
            values[f"{name}mass that is stopped (kg)"] = (
                first.normal_impulse**2 / 2.0 / first.energy_loss,
                effective,
            )
            values[f"{name}loss (J)"] = (first.energy_loss, loss)
        rows.append(Row(f"{modes}", values))
    return rows


QUESTIONS = [
    Question(
        name="plastic",
        title="A plastic impact loses nothing in the limit of many modes; what with a mass of 50 g at the tip?",
        guess="half of the mass times the square of its speed: the beam behind it adds nothing",
        answer="{0[50 g: loss (J)]:.2f}, {1[50 g: loss (J)]:.2f}, {2[50 g: loss (J)]:.2f}, {3[50 g: loss "
        "(J)]:.3f} J with 1, 4, 16, 64 modes: so it is",
        wrong=False,
        cost=0,
        price="",
        why="An impact of an instant stops what the contact point has of inertia, 1/(sum of the squared shapes "
        "there), and every mode takes from it. A bare beam has none in the limit, it falls with 1/N; with a mass "
        "at the tip that mass is left. So a coefficient of restitution has a meaning where a mass sits, and none "
        "where the beam is bare.",
        command=_PLASTIC,
        cases="modes",
        beside="the modal sum, of own elements, and the energy of a rigid fall",
        compute=plastic,
        within=1e-2,
    ),
]

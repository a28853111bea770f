"""Where along the beam it is struck."""

from __future__ import annotations

from questions.independent import Beam, fall
from questions.question import Question, Row, run

_PLACE = """\
oblique-impact run paper --set contact.where=anywhere --set slope.enabled=false --set contact.normal=spring \\
    --set "obstacles=[{kind='point', origin=[0.736, 0.0], stiffness=1e6}]" --set beam.kelvin_voigt=1e-5 \\
    --set discretization.frame=mean-axis --set discretization.modes=16 --set contact.friction=frictionless \\
    --set end_time=0.45 --out out/place"""


def place() -> list[Row]:
    """Fall onto a peg that is soft against the beam, and onto one that is not."""
    rows = []
    for x in (0.52, 0.62, 0.736, 0.76, 0.82, 0.88):
        values: dict[str, tuple[float | None, float | None]] = {}
        for stiffness in (1e5, 1e6):
            peg = f"obstacles=[{{kind='point', origin=[{x}, 0.0], stiffness={stiffness}}}]"
            lost = run(_PLACE, peg).summary["energy"]["lost_damping"]
            other = fall(
                Beam(kelvin_voigt=1e-5, modes=12), stiffness, place=x, origin=(x, 0.0), slope=0.0, end=0.45
            )
            values[f"loss on {stiffness:.0e} N/m (J)".replace("e+0", "e")] = (lost, other.lost)
        rows.append(Row(f"{x:g} L", values))
    return rows


QUESTIONS = [
    Question(
        name="place",
        title="Where along a falling beam must a peg be for the least loss, and for the greatest?",
        guess="least at the node of the first mode, 0.736 L, which is not excited there; greatest at the tip",
        answer="on a soft peg least there, {2[loss on 1e5 N/m (J)]:.2f} J; on a stiff one {2[loss on 1e6 N/m "
        "(J)]:.2f} J, and greatest close by, {3[loss on 1e6 N/m (J)]:.2f} J at 0.76 L",
        wrong=True,
        cost=1000,
        price="a peg put where it costs most",
        why="At its node the first mode takes no part, and what does is the second, which internal damping takes "
        "ten times as fast. On the soft peg the contact lasts one and a half of its periods, which leaves it "
        "nearly at rest; on the stiff one 0.6 of one, which excites it most. Near 0.62 L the blow goes into the "
        "first mode: little is lost, but the beam vibrates instead of rebounding.",
        command=_PLACE,
        cases="peg at, to 0.45 s",
        beside="the modes of `benchmarks/questions/independent.py`, pushed at one place of the axis",
        compute=place,
        within=5e-3,
    ),
]

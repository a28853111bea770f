"""Friction on an elastic slope."""

from __future__ import annotations

from math import cos, pi, sqrt

from reference_compliance import arguments, beam_of

from questions.question import Question, Row, run

_BAR = """\
oblique-impact run rigid-limit --set slope.origin=[0.3,0] --set slope.angle=0.7853981634 --set gravity=0 \\
    --set contact.normal=spring --set contact.stiffness=1e4 --set initial.angle=0.01 \\
    --set initial.angular_velocity=-0.25 --set contact.friction=hybrid --set contact.mu_static=0.9 \\
    --set contact.mu_kinetic=0.9 --set end_time=0.11 --out out/friction"""
_PAPER = """\
oblique-impact run paper --set discretization.frame=mean-axis --set discretization.modes=4 --set end_time=0.345 \\
    --set contact.normal=spring --set contact.stiffness=1e6 --set contact.residual_flexibility=false"""


def friction() -> list[Row]:
    """Run a stiff bar that strikes at 45 degrees, and the paper's beam, which strikes at 5 degrees."""
    rows = []
    inertia, speed, length = 2.7667 * 0.3**3 / 3.0, 0.25, 0.3
    for mu in (0.0, 0.3, 0.6, 0.9):
        history = run(_BAR, f"contact.mu_static={mu}", f"contact.mu_kinetic={mu}")
        lever = mu  # times tan(45 degrees)
        part = sqrt((1.0 + lever) / (1.0 - lever))
        exact = inertia * speed / (length * cos(pi / 4.0)) * (1.0 + part) / (1.0 + lever)
        values = {
            "normal impulse (N s)": (sum(contact.normal_impulse for contact in history.contacts), exact),
            "rebound over approach": (float(history["theta_dot"].values[-1]) / speed, 1.0 / part),
        }
        rows.append(Row(f"bar at 45°, mu = {mu:g}", values))
    for mu in (0.0, 0.3):
        history = run(_PAPER, f"contact.mu_static={mu}", f"contact.mu_kinetic={mu}")
        words = ["--slope", "--friction", str(mu), "--modes", "4", "--end", "0.345"]
        other = beam_of(arguments(words))
        other.march(0.345)
        impulse = sum(contact.normal_impulse for contact in history.contacts)
        found = impulse, float(sum(contact.impulse for contact in other.contacts))
        rows.append(Row(f"paper's beam at 5°, mu = {mu:g}", {"normal impulse (N s)": found}))
    return rows


QUESTIONS = [
    Question(
        name="friction",
        title="Friction on an elastic slope: does it take load off the stop?",
        guess="yes, in proportion: mu times the tangent of the angle between beam and slope",
        answer="at 45° first less, {1[normal impulse (N s)]:.4f} after {0[normal impulse (N s)]:.4f} N s, then "
        "more, {3[normal impulse (N s)]:.4f} N s with mu = 0.9; next to nothing on the paper's slope",
        wrong=True,
        cost=90,
        price="a rough stop is dimensioned for less than half of the impulse that it gets",
        why="While the bar comes in, friction brakes it and the stop needs 1/(1 + mu tan b) of the impulse; "
        "while it goes out, the slip is turned, friction holds it back and the stop must push for longer. The "
        "rebound has sqrt((1 - mu tan b)/(1 + mu tan b)) of the speed, and at mu tan b = 1 the bar jams. The tip "
        "of a beam that bends turns its slip several times in a contact: what friction does in one direction it "
        "takes back in the other.",
        command=_BAR,
        cases="case",
        beside="a rigid bar in closed form; of the paper's beam `benchmarks/reference_compliance.py`, SciPy alone",
        compute=friction,
        within=2e-2,
    ),
]

"""A damped stop of Hunt and Crossley's kind."""

from __future__ import annotations

from math import log

from scipy.optimize import brentq

from questions.question import Question, Row, run

_DAMPING = 0.25  # s/m

_REBOUND = """\
oblique-impact run rigid-limit --set contact.normal=spring --set contact.stiffness=1e5 --set gravity=0 \\
    --set contact.damping=0.25 --set initial.angular_velocity=-64 --set end_time=0.03 --out out/rebound"""


def _leaves(speed: float) -> float:
    """Return the speed (m/s) with which a mass leaves such a stop, from the closed form of its motion.

    From m v dv/dd = -k d (1 + c v) the function v/c - ln(1 + c v)/c^2 is the same at both ends of the contact:
    neither mass nor stiffness is left.
    """
    x = _DAMPING * speed
    wanted = x - log(1.0 + x)
    return float(brentq(lambda y: -y - log(1.0 - y) - wanted, 0.0, 1.0 - 1e-16, xtol=1e-15)) / _DAMPING


def rebound() -> list[Row]:
    """Return the speeds of the tip before and after."""
    rows = []
    for spin in (1.0, 4.0, 16.0, 64.0):  # rad/s
        history = run(_REBOUND, f"initial.angular_velocity={-spin}", f"end_time={0.6 / spin + 0.02}")
        (contact,) = history.contacts
        times, rates = history["time"].values, history["gap_rate"].values
        before, after = -float(rates[times <= contact.start][-1]), float(rates[times >= contact.end][0])
        values = {"strikes with (m/s)": (before, None), "leaves with (m/s)": (after, _leaves(before))}
        rows.append(Row(f"{spin:g} rad/s", values))
    return rows


QUESTIONS = [
    Question(
        name="rebound",
        title="A beam strikes a Hunt-Crossley stop 16 times as fast: how much faster does it leave?",
        guess="nearly 16 times; a coefficient of restitution falls a little with speed",
        answer="{3[leaves with (m/s)]:.2f} m/s after {1[leaves with (m/s)]:.2f} m/s; 4 m/s is the bound",
        wrong=True,
        cost=400,
        price="rebounds several times too high, the next blow too early",
        why="The force k d (1 + c d') never pulls: it ends where the beam leaves with 1/c, here 4 m/s, however "
        "deep it is in the stop. A harder blow goes deeper, and the damper takes all that is more. Neither the "
        "stiffness of the stop nor the mass of the beam is in the answer.",
        command=_REBOUND,
        cases="falls with",
        beside="a mass on such a stop, where v/c - ln(1 + c v)/c² is the same at both ends of the contact",
        compute=rebound,
        within=5e-3,  # the beam bends
    ),
]

"""Which way it goes: numbers of docs/which-way.md that have a closed form or another program beside them.

A beam bends and vibrates where a closed form has a rigid body: tolerances are a few times that difference, and far
less than what the quick answer is off by.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import log

from scipy.optimize import brentq

from oblique_impact.validation.checks.registry import Measurement, checks_of, within
from oblique_impact.validation.runs import run

check = checks_of("directions", "Which way it goes")


@check(
    "The harder a beam strikes a Hunt-Crossley stop, the less it gains: it leaves slower than 1/c.", seconds=1.0
)
def rebound() -> Iterator[Measurement]:
    """Speeds of 1.2 m/s and of 19 m/s, which leave with 1.0 and 3.9 m/s of the bound, 4 m/s."""
    damping, text = 0.25, "v/c - ln(1 + c v)/c^2 is the same at both ends of the contact of a mass"
    keys = ("contact.normal=spring", "contact.stiffness=1e5", f"contact.damping={damping}", "gravity=0")
    for spin in (4.0, 64.0):
        ends = (f"initial.angular_velocity={-spin}", f"end_time={0.6 / spin + 0.02}")
        history = run("rigid-limit", *keys, *ends)
        (contact,) = history.contacts
        times, rates = history["time"].values, history["gap_rate"].values
        x = -damping * float(rates[times <= contact.start][-1])
        exact = brentq(lambda y, x=x: -y - log(1.0 - y) - (x - log(1.0 + x)), 0.0, 1.0 - 1e-15) / damping
        found = float(rates[times >= contact.end][0])
        name = f"{spin:g}"
        yield within(f"speed after a fall with {name} rad/s", found, exact, "m/s", 5e-3, text, name)

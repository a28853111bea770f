"""Which way it goes: numbers of docs/which-way.md that have a closed form or another program beside them.

What is beside them neglects what large bending and turning do: tolerances are a few times that difference, and far
less than what the quick answer is off by.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, log, pi, sqrt

import numpy as np
from scipy.optimize import brentq

from oblique_impact.history.history import History
from oblique_impact.validation.checks.registry import Measurement, checks_of, within
from oblique_impact.validation.reference_values import VALUES, source
from oblique_impact.validation.runs import FRICTIONLESS, MEAN_AXIS, SPRING, run

check = checks_of("directions", "Which way it goes")

_DAMPED = (FRICTIONLESS, MEAN_AXIS, "discretization.modes=16", "beam.kelvin_voigt=1e-5")
_ON_SPRING = (*_DAMPED, SPRING, "contact.stiffness=1e6", "end_time=0.4")


def _impulse(history: History) -> float:
    """Sum of the normal impulses (N s) of all contacts."""
    return float(sum(contact.normal_impulse for contact in history.contacts))


def _struck(history: History, question: str, case: int, name: str) -> Iterator[Measurement]:
    """Yield number of contacts and impulse of a case of a question."""
    wanted, text = VALUES[f"which-way-{question}"], source(f"which-way-{question}")
    contacts, impulse = wanted["contacts"][case], wanted["impulse (N s)"][case]
    yield Measurement(f"contacts, {name}", len(history.contacts), contacts, "1", 0.5, text, f"contacts-{case}")
    yield within(f"impulse, {name}", _impulse(history), impulse, "N s", 3e-3, text, f"impulse-{case}")


@check(
    "The harder a beam strikes a Hunt-Crossley stop, the less it gains: it leaves slower than 1/c.", seconds=1.0
)
def rebound() -> Iterator[Measurement]:
    """Speeds of 1.2 m/s and of 19 m/s, which leave with 1.0 and 3.9 m/s of the bound, 4 m/s."""
    damping, text = 0.25, "v/c - ln(1 + c v)/c^2 is the same at both ends of the contact of a mass"
    keys = (SPRING, "contact.stiffness=1e5", f"contact.damping={damping}", "gravity=0")
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


@check(
    "A deeper beam loses less on an elastic stop and more on a rigid one, and is struck less often.", seconds=1.0
)
def depth() -> Iterator[Measurement]:
    """Depths of 20, 40 and 80 mm, with internal damping."""
    for question, keys in (
        ("depth-spring", _ON_SPRING),
        ("depth-rigid", (*_DAMPED, "contact.point_inertia=none", "end_time=0.4")),
    ):
        wanted, text = VALUES[f"which-way-{question}"], source(f"which-way-{question}")
        for case, height in enumerate((0.02, 0.04, 0.08)):
            section = f"beam.section={{shape='rectangle', width=0.03, height={height}}}"
            history, name = run("paper", *keys, section), f"{question}, {1e3 * height:g} mm"
            lost, tail = history.balance["lost_damping"], f"{question}-{case}"
            yield within(f"loss, {name}", lost, wanted["loss (J)"][case], "J", 5e-3, text, tail)
            if "contacts" in wanted:
                count, known = len(history.contacts), wanted["contacts"][case]
                yield Measurement(f"contacts, {name}", count, known, "1", 0.5, text, f"{tail}-contacts")


@check("The stiffer a beam's material, the fewer contacts; the impulse rises, then falls.", seconds=1.0)
def modulus() -> Iterator[Measurement]:
    """A quarter of the paper's modulus, it, and four times as much."""
    for case, factor in enumerate((0.25, 1.0, 4.0)):
        history = run("paper", *_ON_SPRING, f"beam.youngs_modulus={factor * 68.952e9}")
        yield from _struck(history, "modulus", case, f"{factor:g} E")


@check("A light hub about the pin takes a tenth of the impulse away, a heavy one adds as much.", seconds=1.0)
def hub() -> Iterator[Measurement]:
    """Inertias of 0.3 % and of a third of the beam's own."""
    for case, inertia in ((1, 0.001), (5, 0.1)):
        keys = ("root.kind=hub", f"root.inertia={inertia}", "end_time=0.42")
        history = run("paper", *_ON_SPRING[:-1], *keys)
        yield from _struck(history, "hub", case, f"a hub of {inertia:g} kg m²")


@check("A peg at the node of the first mode: least loss if it is soft, three times as much as elsewhere if not.")
def place() -> Iterator[Measurement]:
    """Pegs of two stiffnesses at 0.62 and 0.736 of the length."""
    wanted, text = VALUES["which-way-place"], source("which-way-place")
    for case, x in ((1, 0.62), (2, 0.736)):
        for stiffness in ("1e5", "1e6"):
            peg = f"obstacles=[{{kind='point', origin=[{x}, 0.0], stiffness={stiffness}}}]"
            keys = ("contact.where=anywhere", "slope.enabled=false", SPRING, peg, "end_time=0.45")
            lost = run("paper", *_DAMPED, *keys).balance["lost_damping"]
            exact, name = wanted[f"loss on {stiffness} N/m (J)"][case], f"{x:g}-{stiffness}"
            yield within(f"loss, {stiffness} N/m at {x:g} L", lost, exact, "J", 3e-3, text, name)


@check("The impulse of a fall grows with the square root of gravity, but for the weight during the stay.")
def gravity() -> Iterator[Measurement]:
    """From a sixteenth of gravity to four times as much."""
    wanted, text = VALUES["which-way-gravity"], source("which-way-gravity")
    for case, factor in ((0, 0.0625), (2, 4.0)):
        end = 0.32 / sqrt(factor) + 0.03
        history = run("paper", *_ON_SPRING[:-1], f"gravity={9.8 * factor}", f"end_time={end}")
        found = _impulse(history) / sqrt(9.8 * factor)
        exact, name = wanted["impulse over square root of gravity"][case], f"{factor:g}"
        quantity, unit = f"impulse over square root of gravity, {name} g", "kg m^0.5"
        yield within(quantity, found, exact, unit, 4e-3, text, name)


@check(
    "Friction on an elastic slope: less normal impulse at first, then more, and ever less rebound.", seconds=1.0
)
def friction() -> Iterator[Measurement]:
    """A stiff bar at 45 degrees; the slip turns where it is deepest."""
    text = "closed form: friction is mu times the normal force, in and out, and the spring gives back what it took"
    inertia, speed, length = 2766.7e-3 * 0.3**3 / 3.0, 0.25, 0.3
    bar = (SPRING, "contact.stiffness=1e4", "slope.origin=[0.3, 0.0]", f"slope.angle={pi / 4.0}", "gravity=0")
    start = ("initial.angle=0.01", f"initial.angular_velocity={-speed}", "end_time=0.11")
    for mu in (0.3, 0.9):
        rough = ("contact.friction=hybrid", f"contact.mu_static={mu}", f"contact.mu_kinetic={mu}")
        history = run("rigid-limit", *bar, *start, *rough)
        part, name = sqrt((1.0 + mu) / (1.0 - mu)), f"mu = {mu:g}"
        exact = inertia * speed / (length * cos(pi / 4.0)) * (1.0 + part) / (1.0 + mu)
        yield within(f"normal impulse, {name}", _impulse(history), exact, "N s", 1.5e-2, text, f"impulse-{mu:g}")
        back = float(history["theta_dot"].values[-1]) / speed
        yield within(f"rebound over approach, {name}", back, 1.0 / part, "1", 1.5e-2, text, f"rebound-{mu:g}")


@check("A plastic impact stops the inertia that modes leave at the tip: with a mass no less than that.")
def plastic() -> Iterator[Measurement]:
    """Of 4 and 16 modes, without a mass and with 50 g."""
    wanted, text = VALUES["which-way-plastic"], source("which-way-plastic")
    keys = (FRICTIONLESS, MEAN_AXIS, "discretization.method=fem", "discretization.elements=128", "end_time=0.33")
    for mass in (0.0, 0.05):
        for case, modes in ((1, 4), (2, 16)):
            first = run("paper", *keys, f"beam.tip_mass={mass}", f"discretization.modes={modes}").events[0]
            exact = wanted[f"{1e3 * mass:g} g: mass that is stopped (kg)"][case]
            found, name = first.normal_impulse**2 / (2.0 * first.energy_loss), f"{1e3 * mass:g}-{modes}"
            yield within(f"{1e3 * mass:g} g, {modes} modes", found, exact, "kg", 1e-4, text, name)


@check("A strip that a sweep finds striking at 16 Hz touches once from rest, at 16.5 Hz never.", seconds=1.0)
def rest() -> Iterator[Measurement]:
    """Contacts in 2 s, when the last one is, and the largest swing."""
    wanted, text = VALUES["which-way-rest"], source("which-way-rest")
    for case, frequency, known in ((1, 16.0, 1), (2, 16.5, 0)):
        history = run("shaken", "gravity=0", f"base.frequency={frequency}", "end_time=2")
        name = f"{frequency:g} Hz"
        yield Measurement(f"contacts, {name}", len(history.contacts), known, "1", 0.5, text, f"contacts-{case}")
        swing, exact = 1e3 * float(np.abs(history["deflection"].values).max()), wanted["largest swing (mm)"][case]
        yield within(f"largest swing, {name}", swing, exact, "mm", 1e-3, text, f"swing-{case}")
        if known:
            found, exact = history.contacts[-1].start, wanted["last contact at (s)"][case]
            yield within(f"last contact, {name}", found, exact, "s", 1e-4, text, f"last-{case}")


@check("A strip beside a stop swings further above its own frequency than at it.", seconds=2.0)
def swing() -> Iterator[Measurement]:
    """Shaken for 4 s at its own frequency, 13.37 Hz, and at 15.5 Hz."""
    wanted, text = VALUES["which-way-swing"], source("which-way-swing")
    for case, frequency in ((0, 13.37), (1, 15.5)):
        keys = (
            "gravity=0",
            f"base.frequency={frequency}",
            "solver.tolerance=1e-8",
            "discretization.modes=4",
            "end_time=4",
        )
        history = run("shaken", *keys)
        found, exact = 1e3 * float(np.abs(history["deflection"].values).max()), wanted["largest swing (mm)"][case]
        yield within(f"largest swing at {frequency:g} Hz", found, exact, "mm", 3e-3, text, f"{frequency:g}")

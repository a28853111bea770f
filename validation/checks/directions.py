"""Which way it goes: numbers of docs/which-way.md that have a closed form or another program beside them.

What is beside them neglects what large bending and turning do: tolerances are a few times that difference, and far
less than what the quick answer is off by.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, log, pi, sin, sqrt
from typing import Literal

import numpy as np
from scipy.optimize import brentq

from oblique_impact.history.history import History
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.checks.registry import Measurement, checks_of, within
from oblique_impact.validation.reference_values import VALUES, source
from oblique_impact.validation.runs import FRICTIONLESS, MEAN_AXIS, SPRING, run
from oblique_impact.vibration import frequencies_at_rest

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
    for case, x in ((2, 0.62), (3, 0.736)):
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


#: a bar that nothing holds, with 0.1 m/s onto a soft floor: it hardly bends and hardly turns while it is there
_BAR = ("contact.stiffness=1e3", "contact.grid=1", "gravity=0", "initial.velocity=[0, -0.1]")
_BAR_MASS = 7800.0 * pi * 0.003**2 * 0.2  # kg


def _tilted(degrees: float) -> tuple[str, str, str]:
    """Return the keys of that bar at a tilt, its lower end just above the floor."""
    tilt = degrees * pi / 180.0
    place = f"initial.position=[0, {0.1 * sin(tilt) + 1e-6}]"
    return f"initial.angle={-tilt}", place, "solver.free_step=2e-5"


@check("An elastic bar that is dropped at 54.7 degrees does not rebound: all is in its rotation.", seconds=1.0)
def tilt() -> Iterator[Measurement]:
    """Impulse over m v; 1 stops the centre."""
    text = "a rigid bar: 2/(1 + 3 cos^2 of the tilt)"
    # it turns during the contact, upright all the more
    for degrees, allowed in ((30.0, 4e-3), (54.7356103172, 1e-2)):
        history = run("dropped-bar", *_BAR, FRICTIONLESS, *_tilted(degrees), "end_time=0.03")
        exact, name = 2.0 / (1.0 + 3.0 * cos(degrees * pi / 180.0) ** 2), f"{degrees:.0f}"
        found = history.contacts[0].normal_impulse / (0.1 * _BAR_MASS)
        yield within(f"impulse over m v at {degrees:.1f} degrees", found, exact, "1", allowed, text, name)


@check("The second end of a bar that falls nearly flat arrives with twice the speed of the first.", seconds=1.0)
def clatter() -> Measurement:
    """The tilt is 2 degrees."""
    history = run("dropped-bar", *_BAR, FRICTIONLESS, *_tilted(2.0), "end_time=0.045")
    second = next(event for event in history.events if event.kind.value == "impact" and event.place < 0.1)
    text = "a rigid bar: v/2 of the centre, and 3 v/L of rotation"
    return within("speed of the second end", -second.normal_velocity, 0.2, "m/s", 3e-3, text)


@check("Friction under a bar at 45 degrees makes its centre rebound.", seconds=1.0)
def rough_floor() -> Iterator[Measurement]:
    """One coefficient with which the end slides, and one with which it sticks."""
    text = "Routh's impact of a rigid bar, elastic: 2/(a - min(mu, c/a) c), a = 5/2, c = 3/2"
    for mu in (0.3, 0.7):
        sticks = f"contact.mu_static={mu}", f"contact.mu_kinetic={mu}"
        history = run("dropped-bar", *_BAR, *sticks, *_tilted(45.0), "end_time=0.02")
        found, exact = history.contacts[0].normal_impulse / (0.1 * _BAR_MASS), 2.0 / (2.5 - 1.5 * min(mu, 0.6))
        yield within(f"impulse over m v, mu = {mu:g}", found, exact, "1", 6e-3, text, f"{mu:g}")


_ROD = (
    *("initial.angle=-1.5707963267948966", "initial.position=[0, 0.100001]", "contact.grid=1", FRICTIONLESS),
    *("gravity=0", "beam.kelvin_voigt=0", "discretization.elements=32", "solver.free_step=2e-7"),
    *("solver.output_interval=1e-6", "solver.tolerance=1e-10", "end_time=3e-4"),
)


@check("A rod that falls upright loses most to its vibrations on a floor of its own stiffness.", seconds=1.0)
def rod() -> Iterator[Measurement]:
    """Restitution on a spring of 1, 3 and 10 E A/L."""
    wanted, text = VALUES["which-way-rod"]["restitution"], source("which-way-rod")
    for case, over, allowed in ((2, 1.0, 1e-5), (4, 3.0, 4e-5), (5, 10.0, 1e-4)):
        history = run("dropped-bar", *_ROD, f"contact.stiffness={over * 2.1e11 * pi * 0.003**2 / 0.2}")
        found = _impulse(history) / _BAR_MASS - 1.0
        yield within(f"restitution on {over:g} E A/L", found, wanted[case], "1", allowed, text, f"{over:g}")


@check("A rod rebounds from a dashpot, the more the stronger it is beyond its own impedance.", seconds=1.0)
def dashpot() -> Iterator[Measurement]:
    """Twice and four times the impedance."""
    text = "reflection of a wave: 1 + (c - Z)/(c + Z)"
    for over in (2.0, 4.0):
        strength = over * pi * 0.003**2 * sqrt(2.1e11 * 7800.0)
        floor = "contact.stiffness=2.97e4", f"contact.linear_damping={strength}"
        found, exact = _impulse(run("dropped-bar", *_ROD, *floor)) / _BAR_MASS, 2.0 * over / (over + 1.0)
        # elements smooth the front of the wave
        yield within(f"impulse over m v, {over:g} Z", found, exact, "1", 1e-2, text, f"{over:g}")


_AT_REST = (
    *("base.acceleration=0", "base.frequency=0", "gravity=0", "initial.angle=0", "beam.kelvin_voigt=0"),
    *("discretization.method=fem", "discretization.modes=0"),
)
#: sqrt(EI/m)/L^2 of the strip of `shaken`, in rad/s
_UNIT = sqrt(0.35 / 0.157) / 0.25**2


def _strip(*keys: str) -> Scenario:
    """Return that strip at rest, straight."""
    return Scenario.builtin("shaken", [*_AT_REST, *keys])


@check("A dashpot in a clamp that yields: ten times the best one damps six times less.", seconds=0.5)
def clamp_dashpot() -> Iterator[Measurement]:
    """A tenth of the best, the best, ten times the best."""
    wanted, text = VALUES["which-way-clamp-dashpot"]["decay (1/s)"], source("which-way-clamp-dashpot")
    for case, damping in ((0, 0.0112), (2, 0.112), (4, 1.12)):
        keys = "contact.enabled=false", "root.stiffness=5.6", f"root.damping={damping}"
        found = frequencies_at_rest(_strip(*keys), 4)
        decay = next(z * w for z, w in zip(found.damping, found.frequencies, strict=True) if z < 0.999)
        name = f"{damping:g}"
        yield within(f"decay, {name} N m s/rad", float(decay), wanted[case], "1/s", 2e-7, text, name)


_SUPPORTED = ("initial.state=equilibrium", "slope.enabled=false", "contact.where=anywhere")


@check("Stick at both faces makes a clamp of the jaws at the end of a strip, whether its axis yields or not.")
def jaws() -> Iterator[Measurement]:
    """Free to slip, stuck, stuck with axial flexibility."""
    wanted, text = VALUES["which-way-jaws"]["first frequency (Hz)"], source("which-way-jaws")
    pegs = ", ".join(f"{{kind='point', origin=[0.2421875, {y}], stiffness=1e6}}" for y in (4.9e-4, -4.9e-4))
    keys = (*_SUPPORTED, "contact.surface=section", "contact.friction=hybrid", f"obstacles=[{pegs}]")
    # what presses turns the section back, to the first order
    cases: tuple[tuple[str, int, Literal["free", "stuck"], str, float], ...] = (
        ("slips", 0, "free", "false", 5e-5),
        ("sticks", 1, "stuck", "false", 3e-6),
        ("sticks, the axis yields", 1, "stuck", "true", 3e-6),
    )
    for name, case, friction, axial, allowed in cases:
        strip = _strip(*keys, f"contact.axial_flexibility={axial}")
        found = float(frequencies_at_rest(strip, 1, friction).frequencies[0]) / (2.0 * pi)
        tail = name.replace(", the", "").replace(" ", "-")
        yield within(f"first frequency, {name}", found, wanted[case], "Hz", allowed, text, tail)


@check("A light mass lowers the second frequency of a cantilever most at its tip, a heavy one at the antinode.")
def mass() -> Iterator[Measurement]:
    """Masses of 2 g and of the strip's own, 39 g."""
    wanted, text = VALUES["which-way-mass"], source("which-way-mass")
    for case, size in ((0, 0.002), (4, 0.039)):
        for name, place in (("at the antinode", 0.118), ("at the tip", 0.25)):
            strip = _strip("contact.enabled=false", f"masses=[{{place={place}, mass={size}}}]")
            found = float(frequencies_at_rest(strip, 2).frequencies[1]) / (2.0 * pi)
            exact, tail = wanted[f"{name} (Hz)"][case], f"{1e3 * size:g}-{name.split()[-1]}"
            yield within(f"second frequency, {size:g} kg {name}", found, exact, "Hz", 1e-6, text, tail)


@check("A peg raises the first frequency of a cantilever most under the node of its second mode, to that one.")
def peg() -> Iterator[Measurement]:
    """At the node, and at the tip, where the peg touches beside a node of the mesh."""
    for place, root, allowed, text in (
        (0.195862, 4.694091132974175, 3e-6, "cosh z cos z = -1, its second root"),
        (0.25 - 1e-6, 3.926602312047919, 5e-5, "tan z = tanh z, its first root: a hinge at the tip"),
    ):
        obstacle = f"obstacles=[{{kind='point', origin=[{place}, -9.9e-4], radius=1e-3, stiffness=1e9}}]"
        found = float(frequencies_at_rest(_strip(*_SUPPORTED, obstacle), 1).frequencies[0])
        exact, name = root**2 * _UNIT, f"{place:.2g}"
        yield within(f"first frequency, peg at {place:.3g} m", found, exact, "rad/s", allowed, text, name)


@check("A mass inside of two thirds of a hanging beam raises its first frequency.")
def hanging() -> Iterator[Measurement]:
    """The mass of the beam, at half of its length and at the tip."""
    own = 2766.7 * 3.14e-4
    for place in (0.5, 1.0):
        keys = "initial.angle=-1.5707963267948966", "contact.enabled=false", "discretization.method=fem", MEAN_AXIS
        hung = (*keys, "discretization.modes=4", f"masses=[{{place={place}, mass={own}}}]")
        found = float(frequencies_at_rest(Scenario.builtin("paper", list(hung)), 1).frequencies[0])
        exact = sqrt(9.8 * (0.5 + place) / (1.0 / 3.0 + place**2))
        text, name = "a rigid pendulum", f"{place:g}"
        yield within(f"first frequency, mass at {name} L", found, exact, "rad/s", 3e-5, text, name)


@check("The moment at a clamp above a table does not know how far the strip bends: sqrt(2 EI w h).", seconds=1.0)
def table() -> Measurement:
    """0.4 m above it, where the strip slopes by 56 degrees."""
    lying = (
        *("root.kind=driven", "initial.angle=0", "initial.state=equilibrium", "beam.length=1.5", "gravity=9.81"),
        *("beam.material=steel", "beam.section={shape='rectangle', height=2e-4, width=0.02}"),
        *("obstacles.1.origin=[0, -0.4]", "discretization.method=absolute", "discretization.elements=20"),
        *("contact.grid=20", "end_time=1e-4"),
    )
    found = abs(float(run("slap", *lying).section_forces()["moment"].values[0, 0]))
    exact = sqrt(2.0 * 2.1e11 * 0.02 * 2e-4**3 / 12.0 * 7850.0 * 0.02 * 2e-4 * 9.81 * 0.4)
    # it lies down between two places of contact
    return within("moment at the clamp", found, exact, "N m", 5e-4, "first integral of the elastica")


_TURNING = (
    *("gravity=0", "initial.angle=0", "initial.angular_velocity=-1", SPRING, FRICTIONLESS, MEAN_AXIS),
    "beam.kelvin_voigt=2e-5",
)
_LEVEL = ("slope.angle=0", "slope.origin=[0, 0]")
_FEM = ("discretization.method=fem", "discretization.modes=16", "discretization.elements=20")


@check(
    "A second stop, near the tip, nearly doubles the largest moment of a beam that turns onto one.", seconds=1.0
)
def second_stop() -> Iterator[Measurement]:
    """A stop at 0.8 of the length, and with one at 0.95."""
    wanted, text = VALUES["which-way-second-stop"]["largest moment (N m)"], source("which-way-second-stop")
    # the second one is beside the stations
    for case, (places, allowed) in enumerate((((0.8,), 3e-3), ((0.8, 0.95), 1e-2))):
        pegs = ", ".join(f"{{kind='point', origin=[{place}, -1e-8]}}" for place in places)
        keys = "contact.where=anywhere", "contact.stiffness=1e5", "slope.enabled=false", f"obstacles=[{pegs}]"
        history = run("paper", *_TURNING, *_FEM, *keys, "solver.output_interval=2e-5", "end_time=0.025")
        found, name = float(np.abs(history.section_forces()["moment"].values).max()), f"{len(places)}"
        yield within(f"largest moment, {name} of the stops", found, wanted[case], "N m", allowed, text, name)


@check("On a stiff stop the centre of percussion hardly spares the pin.", seconds=1.0)
def pin() -> Iterator[Measurement]:
    """The largest force on the pin, with a stop of 1e6 N/m at 2/3 of the length and at the tip."""
    wanted, text = VALUES["which-way-pin"]["largest force on the pin (N)"], source("which-way-pin")
    mesh = "discretization.method=fem", "discretization.modes=24", "discretization.elements=24"
    for case, place, allowed in ((2, 2.0 / 3.0, 5e-4), (5, 1.0, 2e-3)):
        keys = f"contact.point={place}", "contact.stiffness=1e6", "solver.output_interval=1e-5", "end_time=0.02"
        history = run("paper", *_TURNING, *mesh, *_LEVEL, *keys)
        found, name = float(np.abs(history.section_forces()["shear"].values[:, 0]).max()), f"{place:.2g}"
        yield within(f"largest force on the pin, stop at {name} L", found, wanted[case], "N", allowed, text, name)


@check("A stop eight times as stiff has twice the first peak; a beam twice as long has the same.", seconds=1.0)
def stiffer() -> Iterator[Measurement]:
    """Over that of 1e6 N/m and 1 m; the peak itself is `springs.peak-law`."""

    def peak(length: float, stiffness: float) -> float:
        keys = (
            f"beam.length={length}",
            f"contact.stiffness={stiffness}",
            f"initial.angular_velocity={-1.0 / length}",
        )
        history = run("paper", *_TURNING[:-1], *_LEVEL, *keys, "discretization.modes=60", "end_time=1e-3")
        return float(history.contacts[0].peak_force)

    text, one = "the end of an endless beam: Z^(2/3) k^(1/3) v", peak(1.0, 1e6)
    yield within("peak over peak, 8 times the stiffness", peak(1.0, 8e6) / one, 2.0, "1", 3e-6, text, "stiffness")
    yield within("peak over peak, twice the length", peak(2.0, 1e6) / one, 1.0, "1", 4e-6, text, "length")


_PLUCKED = ("base.acceleration=0", "base.frequency=0", "gravity=0", "initial.state=plucked", "initial.place=0.25")


@check(
    "A strip on a clamp that yields is struck twice by a stop that strikes it once on a rigid one.", seconds=1.0
)
def clamp() -> Iterator[Measurement]:
    """Let go at 5 mm from the stop, rigid and on 4 EI/L."""
    wanted, text = VALUES["which-way-clamp"], source("which-way-clamp")
    keys = (*_PLUCKED, "initial.deflection=5e-3", "slope.origin=[0, 0.25]", "slope.extent=[]")
    # modes are those of a rigid clamp and one that turns: they see a yielding one less well
    for case, spring, end, allowed in ((0, 0.0, 0.03, 1e-4), (2, 5.6, 0.042, 5e-3)):
        own = "beam.kelvin_voigt=2e-5", f"root.stiffness={spring}", f"end_time={end}"
        history, name = run("shaken", *keys, *_FEM, *own), f"{spring:g} N m/rad"
        count, known = len(history.contacts), wanted["contacts"][case]
        yield Measurement(f"contacts, clamp of {name}", count, known, "1", 0.5, text, f"contacts-{case}")
        found, exact = 1e3 * _impulse(history), wanted["impulse (mN s)"][case]
        yield within(f"impulse, clamp of {name}", found, exact, "mN s", allowed, text, f"impulse-{case}")


@check(
    "A strip that is let go from over an edge has more moment at its clamp than while it was pulled.", seconds=1.0
)
def edge_pluck() -> Iterator[Measurement]:
    """Pulled, and the largest after it."""
    wanted, text = VALUES["which-way-edge-pluck"]["moment at the root (N mm)"], source("which-way-edge-pluck")
    edge = "slope.enabled=false", "obstacles=[{kind='point', origin=[0.15, -1e-8], stiffness=1e6}]"
    keys = (*_PLUCKED, "initial.angle=0", "initial.force=-0.2", "contact.where=anywhere", *edge)
    history = run("shaken", *keys, *_FEM, "beam.kelvin_voigt=1e-4", "solver.output_interval=5e-5", "end_time=0.04")
    moments = 1e3 * history.section_forces()["moment"].values[:, 0]
    closed = "half of the moment over the edge, F (L - a)/2"
    yield within("moment at the root, pulled", float(moments[0]), wanted[0], "N mm", 5e-3, closed, "pulled")
    yield within("largest after it", float(moments.max()), wanted[1], "N mm", 2e-3, text, "released")


@check(
    "A strip on a stop with a preload has two motions at 19 Hz: calm from rest, large from a pluck.", seconds=2.0
)
def routes() -> Iterator[Measurement]:
    """Swing of the tip after 6 s."""
    wanted, text = VALUES["which-way-routes"]["swing of the tip (mm)"], source("which-way-routes")
    keys = (
        *("base.acceleration=1", "base.frequency=19", "gravity=0", "slope.origin=[-0.001, 0.25]"),
        *("slope.extent=[]", "contact.stiffness=200", "discretization.modes=4", "solver.output_interval=5e-4"),
    )
    plucked = "initial.state=plucked", "initial.place=0.25", "initial.deflection=5e-3"
    for case, (name, start) in enumerate((("rest", ("initial.state=equilibrium",)), ("a pluck", plucked))):
        history = run("shaken", *keys, *start, "end_time=6")
        late = history["time"].values > 6.0 - 4.0 / 19.0
        found = 500.0 * float(np.ptp(history["tip_x"].values[late]))
        # 4 modes, whose steps the other program ends at 1/100 of a period
        yield within(f"swing from {name}", found, wanted[case], "mm", 1e-2, text, f"{case}")


@check(
    "Between two stops a shaken strip goes on striking at 17.5 Hz, where one stop lets it come to rest.",
    seconds=2.0,
)
def two_stops() -> Iterator[Measurement]:
    """Swing of the tip, 5 s after a pluck."""
    wanted, text = VALUES["which-way-two-stops"]["swing of the tip (mm)"], source("which-way-two-stops")
    plucked = "initial.state=plucked", "initial.place=0.25", "initial.force=-1", "solver.output_interval=5e-4"
    anywhere = "base.frequency=17.5", "gravity=0", "contact.where=anywhere", "contact.grid=1", "slope.extent=[]"
    other = "obstacles=[{kind='side', origin=[-0.002, 0.25], angle=-1.5707963267948966}]"
    for case, obstacles in ((2, ()), (3, (other,))):
        history = run("shaken", *anywhere, *plucked, *obstacles, "end_time=5")
        late, name = history["time"].values > 5.0 - 8.0 / 17.5, f"{case - 1}"
        swing = 500.0 * float(np.ptp(history["tip_x"].values[late]))
        yield within(f"swing of the tip, {name} of the stops", swing, wanted[case], "mm", 2e-3, text, name)


@check(
    "Friction does not change the number of contacts that modes make on a rigid stop without damping.", seconds=0.5
)
def refinement_friction() -> Iterator[Measurement]:
    """Of 4 and 8 modes."""
    text = "the equations of motion in SciPy alone, `reference_impact.py` in benchmarks"
    for modes, known in ((4, 2), (8, 9)):
        for friction in ("frictionless", "hybrid"):
            keys = f"discretization.modes={modes}", f"contact.friction={friction}", "end_time=0.345"
            found, name = len(run("many-modes", *keys).contacts), f"{modes} modes, {friction}"
            yield Measurement(f"contacts, {name}", found, known, "1", 0.5, text, f"{modes}-{friction}")

"""The geometrically exact beam in absolute coordinates against closed forms, another program, and the nodal model.

It shares neither the floating frame nor foreshortening with the rest, so that here an error in these would show.
Where models are compared, the beam does not shear and its sections have no rotary inertia, as in the floating
frame; that these matter with the square of the radius of gyration is a check of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

from oblique_impact.fem_beam.exact import ElasticSections, ExactBeam, Stage, advance, equilibrium, simulate
from oblique_impact.fem_beam.exact.elastic_sections import Array
from oblique_impact.history.events import Contact
from oblique_impact.history.history import History
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.checks.registry import ROUNDING, Measurement, checks_of, within
from oblique_impact.validation.reference_values import VALUES, source
from oblique_impact.validation.runs import FEM, FRICTIONLESS, MEAN_AXIS, NEAR, NODAL, SPRING, run, run_exact

check = checks_of("absolute", "Absolute coordinates")

_CLOSED = "closed form"
_SAMPLES = "solver.output_interval=1e-3"
_ABSOLUTE = ("discretization.method=absolute", MEAN_AXIS, _SAMPLES)
_FLYING = (*NODAL, _SAMPLES, "discretization.elements=32", "solver.free_step=2e-5", "solver.rho_infinity=0.9")
_TOUCHING = (SPRING, FRICTIONLESS)
_NODAL = (*_FLYING, *_TOUCHING, "solver.contact_step=2e-6")
#: steps of the exact beam in flight and in contact, with which its own error is about a tenth of the tolerances
_STEPS = ("solver.free_step=2e-4", "solver.contact_step=1e-5")


@lru_cache(maxsize=12)
def _exact(*words: str, slenderness: float = 0.0) -> History:
    """Run the exact beam, without shear and rotary inertia, or with a part `slenderness` of its thickness."""
    contact = () if "contact.enabled=false" in words else _TOUCHING
    scenario = Scenario.builtin("paper", [*_ABSOLUTE, *contact, *words])
    if not slenderness:
        return run_exact(scenario)
    return simulate(scenario, sections=ElasticSections.of(scenario).slender(slenderness))


# --- statics and flight


def _elastica(load: float) -> tuple[float, float, float]:
    """Deflection, shortening and slope of the tip of an inextensible cantilever, end load P L^2/E I = `load`.

    By elliptic integrals of the modulus p, 2 p^2 = 1 + sin(slope) (Bisshopp and Drucker 1945).
    """

    def incomplete(p: float) -> tuple[float, float]:
        return float(np.arcsin(1.0 / (p * np.sqrt(2.0)))), p**2

    root = np.sqrt(load)
    bounds = np.sqrt(0.5) + 1e-12, 1.0 - 1e-12
    p = brentq(lambda p: ellipk(p**2) - ellipkinc(*incomplete(p)) - root, *bounds, xtol=1e-15)
    deflection = 1.0 - 2.0 / root * (ellipe(p**2) - ellipeinc(*incomplete(p)))
    sine = 2.0 * p**2 - 1.0
    return float(deflection), float(1.0 - np.sqrt(2.0 * sine) / root), float(np.arcsin(sine))


def _bent(elements: int, force: float, moment: float) -> Array:
    """Place and rotation of the tip of a slender cantilever of unit length and stiffness, loaded in ten steps."""
    beam = ExactBeam(np.linspace(0.0, 1.0, elements + 1), ElasticSections.uniform(1e8, 1e8, 1.0, 1.0))
    q, load = beam.straight(0.0), np.zeros(beam.size)
    for part in np.arange(1, 11) / 10.0:
        load[-2], load[-1] = part * force, part * moment
        q = equilibrium(beam, q, load, 3)
    return q[-3:]


@check("A cantilever is bent by an end load P = 10 EI/L² to four fifths of its length.", seconds=0.3)
def elastica() -> list[Measurement]:
    """Sixteen elements err by 3e-6 (order 4); the extension of this beam adds 1e-7."""
    text = "elastica by elliptic integrals; Mattiasson, Int. J. Numer. Meth. Engng 17 (1981), pp. 145-153"
    x, y, angle = _bent(16, 10.0, 0.0)
    deflection, shortening, slope = _elastica(10.0)
    return [
        Measurement("deflection of the tip over the length", y, deflection, "1", 1e-5, text, "deflection"),
        Measurement("shortening over the length", 1.0 - x, shortening, "1", 1e-5, text, "shortening"),
        Measurement("slope of the tip", angle, slope, "rad", 1e-5, text, "slope"),
        Measurement("deflection, table", y, 0.81061, "1", 2e-5, text, "table"),
    ]


@check("A cantilever is rolled up into a full circle by an end moment of 2π EI/L.", seconds=0.2)
def roll_up() -> list[Measurement]:
    """The curvature is constant, which the elements hold exactly."""
    x, y, angle = _bent(4, 0.0, 2.0 * np.pi)
    distance = float(np.hypot(x, y))
    text = f"{_CLOSED}: the tip is back at the root; Simo and Vu-Quoc, J. Appl. Mech. 53 (1986), pp. 855-863"
    return [
        Measurement("distance of the tip from the root", distance, 0.0, "m", ROUNDING, text, "distance"),
        within("rotation of the tip", angle, 2.0 * np.pi, "rad", ROUNDING, text, "rotation"),
    ]


@check("A free rod is pushed and turned at its end for 2.5 s and flies, bending, for 10 s.", seconds=1.0)
def flying_rod() -> list[Measurement]:
    """Momentum, angular momentum, centre of mass and energy."""
    text = (
        f"{_CLOSED}: 8 N for 2.5 s on 10 kg; the flying rod of Simo and Vu-Quoc, J. Appl. Mech. 53 (1986), "
        "pp. 855-863, EA = GA = 10⁴, EI = 500, length 10"
    )
    beam = ExactBeam(np.linspace(0.0, 10.0, 11), ElasticSections.uniform(1e4, 1e4, 500.0, 1.0, 10.0))
    q = beam.straight(np.pi - np.arctan2(8.0, 6.0))
    q[0::3] += 6.0
    stage, load, length, kept = Stage(q, np.zeros(beam.size)), np.zeros(beam.size), 0.025, []
    for k in range(round(10.0 / length)):
        load[0], load[2] = (8.0, -80.0) if (k + 0.5) * length < 2.5 else (0.0, 0.0)
        stage = advance(beam, stage, length, load, held=np.zeros(0)).stage
        if (k + 1) * length > 2.5 - 1e-9:
            energy = float(beam.kinetic_energy(stage.v) + beam.elastic_energy(stage.q))
            kept.append((energy, beam.angular_momentum(stage.q, stage.v)))
    (energy, turning), spans = kept[0], np.ptp(kept, axis=0)
    momentum = (beam.M @ stage.v).reshape(-1, 3)[:, :2].sum(axis=0)
    place = (beam.M @ stage.q).reshape(-1, 3)[:, :2].sum(axis=0) / 10.0
    change, turned = spans[0] / energy, spans[1] / turning
    return [
        Measurement("momentum along the push", momentum[0], 20.0, "N s", 7e-12, text, "momentum"),
        Measurement("momentum across it", momentum[1], 0.0, "N s", 7e-12, text, "momentum-across"),
        Measurement("centre of mass after 10 s", place[0], 3.0 + 2.5 + 15.0, "m", 3e-12, text, "place"),
        Measurement("relative change of the energy", change, 0.0, "1", 5e-13, "balance", "energy"),
        Measurement("relative change of the angular momentum", turned, 0.0, "1", 5e-13, "balance", "spin"),
    ]


@check(
    "A beam of 10 m is spun up to 6 rad/s in 15 s (Simo and Vu-Quoc), extension and shear included.", seconds=2.0
)
def spin_up() -> list[Measurement]:
    """Largest deflection, and the extension of the beam that turns at 6 rad/s.

    Steps of 2.5 ms err by 1e-5 m.
    """
    words = ["discretization.method=absolute", "discretization.elements=8", "solver.free_step=0.0025"]
    scenario = Scenario.builtin("spin-up", [*words, "solver.output_interval=0.02"])
    # the published data: EA = 2.8e7, GA = 1e7, EI = 1.4e4, rho A = 1.2, rho I = 6e-4
    history = simulate(scenario, sections=ElasticSections.uniform(2.8e7, 1e7, 1.4e4, 1.2, 6e-4))
    deflection, time = history["deflection"].values, history["time"].values
    low, late = int(np.argmin(deflection)), time > 15.5
    # a uniform bar that stretches by little: E A u'' = -rho A w^2 (x + u)
    wave = 6.0 * np.sqrt(1.2 / 2.8e7)
    extension = float(np.tan(10.0 * wave) / wave - 10.0)
    text = f"{_CLOSED} tan(bL)/b - L, b² = ρω²/E; 5.14e-4 m in Simo and Vu-Quoc, J. Appl. Mech. 53 (1986)"
    exact, geometrically = VALUES["3-SVQ-GE"], source("3-SVQ-GE")
    # the foreshortening of the vibration that is left, 1e-6 m, lies in the mean
    mean = float(history["shortening"].values[late].mean())
    return [
        # around the largest deflection time is flat
        Measurement("largest deflection", deflection[low], exact["w_min"], "m", 4e-5, geometrically, "deflection"),
        Measurement("its time", time[low], exact["t"], "s", 5e-2, geometrically, "time"),
        Measurement("extension at 6 rad/s", mean, extension, "m", 4e-6, text, "extension"),
    ]


@check(
    "A beam falls about its pin: the frame, the deflection and the axial force of the nodal model.", seconds=2.0
)
def falling_beam() -> Iterator[Measurement]:
    """Damped, so that the abrupt start is forgotten; an axial force follows here from an extension."""
    words = ("contact.enabled=false", "end_time=0.2", "initial.angle=0.3", "beam.kelvin_voigt=1e-3")
    steps = ("discretization.elements=8", "solver.free_step=2e-4")
    models = _exact(*words, *steps, slenderness=1.0), run("paper", *_FLYING, *words)
    text = "the nodal model in the floating frame"
    # rotary inertia takes 4e-5 of the speed; at a pin the deflection of the tip is a difference of large terms
    accuracies = (("theta_dot", "rad/s", 2e-4), ("deflection", "m", 5e-3), ("energy_elastic", "J", 1e-2))
    for name, unit, relative in accuracies:
        here, there = (float(model[name][-1]) for model in models)
        yield within(name.replace("_", " "), here, there, unit, relative, text, name)
    turned, known = (float(model["theta"][-1]) - 0.3 for model in models)
    yield within("angle it has turned by", turned, known, "rad", 2e-4, text, "theta")
    for name, unit in (("moment", "N m"), ("axial_force", "N")):
        here, there = (float(model.section_forces()[name][-1, 16]) for model in models)
        # to the second order of the step: 2e-4
        yield within(f"{name.replace('_', ' ')} at L/2", here, there, unit, 1e-3, text, name)


# --- elastic stops


def _collision(history: History) -> tuple[float, float]:
    """Impulse (N s) and largest force (N) of the first macro-collision."""
    first = history.summary["macro_collisions"][0]
    return first["normal_impulse"], first["peak_force"]


def _contacts(history: History) -> list[Contact]:
    """Contacts of a run; two that part for less than 20 us are one, which a mesh may see as either."""
    found: list[Contact] = []
    for contact in history.contacts:
        if found and contact.start - found[-1].end < 2e-5:
            impulse = found[-1].normal_impulse + contact.normal_impulse
            found[-1] = found[-1]._replace(end=contact.end, normal_impulse=impulse)
        else:
            found.append(contact)
    return found


def _against(stiffness: str, words: tuple[str, ...], allowed: tuple[float, float, float]) -> Iterator[Measurement]:
    """Against Exudyn and the nodal model: impulse and peak (relative), times of contacts (s)."""
    item = f"exudyn-{stiffness}"
    values, text = VALUES[item], source(item)
    of_impulse, of_peak, of_times = allowed
    spring = (f"contact.stiffness={stiffness}", f"end_time={values['end']}")
    exact, nodal = _exact(*words, *spring), run("paper", *_NODAL, *spring)
    impulse, peak = _collision(exact)
    impulse_nodal, peak_nodal = _collision(nodal)
    model, quantity = "the nodal model in the floating frame", "impulse, against the nodal model"
    first, lost = _contacts(exact)[0].normal_impulse, exact.summary["energy"]["unaccounted"]
    yield within("impulse", impulse, values["impulse"], "N s", of_impulse, text, "impulse")
    yield within("largest force", peak, values["peak"], "N", of_peak, text, "peak")
    yield within(quantity, impulse, impulse_nodal, "N s", of_impulse, model, "nodal-impulse")
    yield within("largest force, against the nodal model", peak, peak_nodal, "N", of_peak, model, "nodal-peak")
    yield within("impulse of the first contact", first, values["first"], "N s", of_impulse, text, "first-impulse")
    yield Measurement("energy lost", lost, 0.0, "J", 3e-12, "balance", "energy")
    for k, time in enumerate(values["switches"]):
        quantity = f"{('start', 'end')[k % 2]} of contact {k // 2 + 1}"
        for name, history, reference in (("", exact, text), (", nodal model", nodal, text)):
            tail = f"{'nodal-' if name else ''}time-{k}"
            contact = _contacts(history)[k // 2]
            event = contact.end if k % 2 else contact.start
            yield Measurement(quantity + name, event, time, "s", of_times, reference, tail)


@check("The paper's beam on a spring of 10⁵ N/m, from its release to the end of the first collision.", seconds=5.0)
def stop_1e5() -> Iterator[Measurement]:
    """The steps err by 1e-4 of the impulse, 4e-4 of the peak and 3e-6 s."""
    return _against("1e5", (*_STEPS, "discretization.elements=16"), (5e-4, 2e-3, 8e-6))


@check("The paper's beam on a spring of 10⁶ N/m, from its release to the end of the first collision.", seconds=5.0)
def stop_1e6() -> Iterator[Measurement]:
    """The steps err by 2e-4 of the impulse, 1e-3 of the peak and 3e-6 s."""
    return _against("1e6", (*_STEPS, "discretization.elements=32"), (1e-3, 5e-3, 8e-6))


@check(
    "The paper's beam on a spring of 10⁷ N/m, from its release to the end of the first collision.", seconds=10.0
)
def stop_1e7() -> Iterator[Measurement]:
    """Exudyn's own meshes differ by 2e-3 of the impulse here, and in the number of later touches."""
    words = (*_STEPS, "solver.contact_step=5e-6", "discretization.elements=32")
    return _against("1e7", words, (8e-3, 3e-2, 1.5e-5))


@check("The nodal model and 24 of its modes on a spring of 10⁶ N/m: their next contact.", seconds=14.0)
def next_contact() -> Iterator[Measurement]:
    """Start of the second macro-collision, against the geometrically exact beam of another program."""
    steps = ("solver.free_step=1e-5", "solver.contact_step=2e-6", "solver.rho_infinity=0.9")
    models = {"nodal": (*NODAL, *steps), "reduced": (FEM, "discretization.modes=24", MEAN_AXIS)}
    common = (*_TOUCHING, "contact.stiffness=1e6", "discretization.elements=32", "end_time=0.87")
    for model, allowed in (("nodal", 3e-5), ("reduced", 3e-4)):
        start = run("paper", *models[model], *common).summary["macro_collisions"][1]["start"]
        text = source("7a-elastic")
        yield Measurement(f"next contact, {model}", start, VALUES["7a-elastic"], "s", allowed, text, model)


@check("Three stops met at full speed: first contact of the exact beam and of the nodal model.", seconds=2.0)
def first_contact() -> Iterator[Measurement]:
    """From just above the slope: a second of computing in place of the flight."""
    text = "the nodal model in the floating frame"
    # on the stiffest stop 1e-5 s are coarse
    for stiffness, elements, until, allowed in (
        ("1e5", 12, 0.0065, 2e-3),
        ("1e6", 16, 0.0032, 2e-3),
        ("1e7", 32, 0.00135, 5e-3),
    ):
        words = (*NEAR, f"contact.stiffness={stiffness}", f"end_time={until}")
        exact = _exact(*words, f"discretization.elements={elements}", *_STEPS)
        nodal = run("paper", *_NODAL, *words)
        end, known = (history.contacts[-1].end for history in (exact, nodal))
        yield within(f"end, {stiffness} N/m", end, known, "s", 2.0 * allowed, text, f"end-{stiffness}")
        for k, (name, unit) in enumerate((("impulse", "N s"), ("peak", "N"))):
            pair = _collision(exact)[k], _collision(nodal)[k]
            yield within(f"{name}, {stiffness} N/m", *pair, unit, allowed, text, f"{name}-{stiffness}")


@check(
    "Extension, shear and rotary inertia: what they change vanishes with the square of the thickness.", seconds=2.0
)
def slenderness() -> list[Measurement]:
    """First contact with a stop of 10⁶ N/m, the same E I and ρA: thickness 2, 1 and a half of the paper's."""
    words = (*NEAR, "contact.stiffness=1e6", "end_time=0.0032", "discretization.elements=16", *_STEPS)
    limit = _exact(*words).contacts[0].end
    changes = [_exact(*words, slenderness=part).contacts[0].end - limit for part in (2.0, 1.0, 0.5)]
    text = "Timoshenko's beam differs from Bernoulli and Euler's by terms of (r/L)², r² = I/A"
    coarse, fine = np.log2(np.divide(changes[:-1], changes[1:]))
    return [
        Measurement("order, from twice to the paper's thickness", coarse, 2.0, "1", 0.4, text, "coarse"),
        Measurement("order, from the paper's to half of it", fine, 2.0, "1", 0.25, text, "fine"),
        # 20 µs of 3 ms, with the paper's thickness
        Measurement("change of the end of contact", changes[1], 0.0, "s", 3e-5, text, "size"),
    ]


# --- rigid stops

#: of the angle of the paper's beam whose tip touches the slope, rad, and how far the tip starts from it, m
_TOUCHING_ANGLE, _AWAY = 0.22132085, 1e-6
#: a damped beam, so that a few modes have what the impact excites
_DAMPED = (FRICTIONLESS, MEAN_AXIS, "beam.kelvin_voigt=1e-3", "gravity=0", "end_time=0.014")
_RIGID_STEPS = ("solver.scheme=time-stepping", "solver.free_step=1e-5", "solver.contact_step=1e-6")


def _speeds(part: float) -> tuple[str, ...]:
    """Start straight, just above the slope, with a part of the paper's speed."""
    start = f"initial.angle={_TOUCHING_ANGLE + _AWAY * part}", f"initial.angular_velocity={-3.786 * part}"
    return (*_DAMPED, *start, *_RIGID_STEPS)


@check(
    "A damped beam strikes a rigid slope from three heights of fall: full kinetics of the floating frame.",
    seconds=14.0,
)
def heights() -> Iterator[Measurement]:
    """Impulses over the speed, of 16, 4 and once the height: they differ by what bending large adds, of order 2.

    What 24 modes leave out of the impact and what the beam stretches is the same part of all of them.
    """
    text = "the floating frame with full kinetics errs by the square of the deflection over the length"
    apart = []
    for part in (4.0, 2.0, 1.0):
        words = _speeds(part)
        modes = (FEM, "discretization.elements=48", "discretization.modes=24", "discretization.kinetics=full")
        elements = ("discretization.method=absolute", "discretization.elements=24")
        exact = run_exact(Scenario.builtin("paper", [*words, *elements]))
        pair = _collision(exact)[0], _collision(run("paper", *words, *modes))[0]
        apart.append(pair[0] / pair[1] - 1.0)
    order = np.log2((apart[0] - apart[1]) / (apart[1] - apart[2]))
    left = apart[2] - (apart[1] - apart[2]) / 3.0
    yield Measurement("order of the difference in the speed", order, 2.0, "1", 0.1, text, "order")
    yield Measurement("impulse, difference at 16 times the height", apart[0], 0.0, "1", 3e-4, text, "tall")
    yield Measurement("impulse, difference without bending", left, 0.0, "1", 2e-5, text, "straight")


@check("The beam falls flat onto a rigid table, and across the edge of one: the full nodal model.", seconds=9.0)
def tables() -> Iterator[Measurement]:
    """First-order kinetics, without shear and extension, are 0.1 % above and 0.24 % below the exact beam."""
    text = "the full nodal model in the floating frame"
    mesh = "discretization.elements=24", "contact.grid=24"
    steps = ("solver.free_step=2e-5", "solver.contact_step=5e-6", *mesh)
    for case in ("slap", "edge"):
        exact = run(case, *steps, "discretization.method=absolute", MEAN_AXIS)
        first, known = (h.summary["macro_collisions"][0] for h in (exact, run(case, *steps)))
        energy = exact.summary["energy"]
        pair = first["normal_impulse"], known["normal_impulse"]
        yield within(f"impulse, {case}", *pair, "N s", 4e-3, text, f"{case}-impulse")
        starts = first["start"], known["start"]
        yield within(f"touch-down, {case}", *starts, "s", 1e-4, text, f"{case}-start")
        lost = energy["unaccounted"]
        yield Measurement(f"energy unaccounted for, {case}", lost, 0.0, "J", 3e-11, "balance", f"{case}-energy")


# --- friction


@check(
    "A stiff bar loads a spring with friction and is thrown back: the slip turns at the deepest point.",
    seconds=1.0,
)
def friction() -> list[Measurement]:
    """The arm of the contact force is cos φ + μ sin φ on the way in and cos φ - μ sin φ on the way out."""
    words = [
        "contact.normal=spring",
        "contact.stiffness=1e4",
        "contact.mu_kinetic=0.2",
        "contact.mu_static=0.2",
        "gravity=0",
        "discretization.method=absolute",
        "discretization.elements=2",
        "end_time=0.05",
        "contact.friction=hybrid",
        "solver.contact_step=2e-5",
        "solver.output_interval=1e-4",
        "slope.origin=[0.2, 0.0]",
        "slope.angle=0.8",
        "initial.angle=0.8",
        "initial.angular_velocity=-1.0",
    ]
    scenario = Scenario.builtin("rigid-limit", words)
    phi = float(np.arcsin(scenario.slope.offsets[0] / scenario.beam.length))
    history = simulate(scenario.replace(initial__angle=scenario.slope.angle + phi + 0.002))
    c, s = np.cos(phi), 0.2 * abs(np.sin(phi))
    energy, expected = history.summary["energy"], np.sqrt((c - s) / (c + s))
    text = f"{_CLOSED} w'/w = sqrt((cos φ - μ sin φ)/(cos φ + μ sin φ)): the spring gives back what it took"
    share = energy["lost_friction"] / energy["initial"]
    # the bar bends and stretches by some thousandths of its turn
    return [
        within("spin after over spin before", float(history["theta_dot"][-1]), expected, "1", 3e-3, text, "spin"),
        within("part of the energy that friction takes", share, 1.0 - expected**2, "1", 1e-2, text, "loss"),
        Measurement("energy not accounted for", energy["unaccounted"], 0.0, "J", ROUNDING, "balance", "energy"),
    ]


@check("A damped beam on ever stiffer springs: the rigid stop without inertia of the contact point.", seconds=7.0)
def rigid_limit() -> list[Measurement]:
    """Impulse within the first 1.2 ms; the error falls like 1/k from 10⁸ N/m on."""
    damped = (*NEAR, "beam.kelvin_voigt=1e-5", "end_time=0.0012")
    massless = ("contact.point_inertia=none", "discretization.modes=24", MEAN_AXIS, FRICTIONLESS)
    rigid = run("paper", *massless, *damped).contacts[0].normal_impulse
    words = (*damped, "discretization.elements=32", "solver.contact_step=1e-6")
    soft, stiff = (
        _exact(*words, f"contact.stiffness={k}").contacts[0].normal_impulse - rigid for k in ("1e7", "1e8")
    )
    text, order = "24 modes on a rigid stop, the contact point without inertia", -np.log10(stiff / soft)
    return [
        within("impulse on a spring of 10⁸ N/m", rigid + stiff, rigid, "N s", 5e-4, text, "impulse"),
        # the error of the exact beam's own steps and elements is a twentieth of that at 10⁷ N/m
        Measurement("order of the difference in 1/k, 10⁷ to 10⁸ N/m", order, 1.0, "1", 0.5, text, "order"),
    ]

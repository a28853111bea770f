"""A run in words, for titles: its beam, what it meets, and how it was computed."""

from __future__ import annotations

import math

from oblique_impact.scenario.messages import counted
from oblique_impact.scenario.scenario import Scenario, builtin_names
from oblique_impact.scenario.sections import BaseSection, BeamSection, InitialSection
from oblique_impact.scenario.shapes import SHAPES

_SHAPES = {"circle": "round bar", "rectangle": "rectangular bar", "tube": "tube", "i-beam": "I-beam"}
_POWERS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def name_of(scenario: Scenario) -> str:
    """Return the title of a scenario, or the name of the built-in one that it is; empty if it has neither."""
    return scenario.title or next((name for name in builtin_names() if Scenario.builtin(name) == scenario), "")


def beam_words(scenario: Scenario) -> list[str]:
    """Return the beam and how many coordinates it has, in ever shorter texts."""
    beam, count = scenario.beam, _coordinates(scenario)
    length = f"length {short(beam.length)} m" if beam.length >= 1.0 else f"length {short(1e3 * beam.length)} mm"
    full = f"{_section(beam)}, {length}"
    return [f"{full}, {_material(beam)}, {count}", f"{full}, {count}", f"{length}, {count}", count]


def model_words(scenario: Scenario, clamped: bool) -> str:
    """Return material, start, stop, friction and discretization of a run."""
    contact, how = scenario.contact, scenario.discretization
    root = "driven root" if scenario.root.kind == "driven" else scenario.root.kind
    start = "clamped, at" if clamped else "free, from" if scenario.root.is_free else f"on a {root}, from"
    words = [
        _material(scenario.beam),
        f"{start} {math.degrees(scenario.initial.angle):.3g}°, gravity {scenario.gravity:.3g} m/s²",
    ]
    if scenario.initial.state != "undeformed":
        words.append(_rest(scenario.initial))
    if scenario.masses or scenario.acting_forces:
        words.append(_loads(scenario))
    if scenario.base.is_shaken:
        words.append(_shaking(scenario.base))
    if contact.enabled:
        stop = f"{contact.normal} stop"
        if contact.normal == "rigid":
            stop = f"rigid stop, restitution {contact.restitution:g}"
        elif contact.normal == "spring":
            stop = f"elastic stop of {short(contact.stiffness)} N/m"
        friction = "frictionless" if contact.friction == "frictionless" else f"{contact.friction} friction"
        if contact.friction in ("hybrid", "modified-coulomb"):
            friction += f", μ = {contact.mu_kinetic:g}"
        words.append(f"{_obstacles(scenario)}, {stop}, {friction}")
    frame = "" if how.method == "absolute" else f"{how.frame} frame, {how.kinetics} kinetics, "
    return "; ".join([*words, f"{_coordinates(scenario)}, {frame}{scenario.solver.scheme} scheme"])


def _rest(initial: InitialSection) -> str:
    """Return how a beam at rest starts."""
    if initial.state == "equilibrium":
        return "from its equilibrium"
    by = f"{short(1e3 * initial.deflection)} mm" if initial.deflection else f"{short(initial.force)} N"
    return f"plucked by {by} at {short(initial.place)} m"


def _loads(scenario: Scenario) -> str:
    """Return how many point masses and forces there are, with their sum and the largest one."""
    masses, forces = scenario.masses, scenario.acting_forces
    total, largest = sum(item.mass for item in masses), max((item.largest for item in forces), default=0.0)
    several = "mass" if len(masses) == 1 else "masses"
    words = [f"{len(masses)} point {several}, {short(total)} kg"] if masses else []
    words += [f"{counted(len(forces), 'force')} on it, up to {short(largest)} N"] if forces else []
    return ", ".join(words)


def _shaking(base: BaseSection) -> str:
    """Return how the base is shaken."""
    along = f"at {math.degrees(base.direction):.3g}°"
    if base.table:
        return f"base shaken by a table, up to {short(max(map(abs, base.extremes)))} m/s², {along}"
    sweep = f" {base.sweep_rate:+.3g} Hz/s" if base.sweep_rate else ""
    return f"base shaken by {short(abs(base.acceleration))} m/s² with {base.frequency:.3g} Hz{sweep}, {along}"


def _obstacles(scenario: Scenario) -> str:
    """Return the slope, and how many other obstacles there are."""
    slope = [f"slope {math.degrees(scenario.slope.angle):.3g}°"] if scenario.slope.enabled else []
    count = len(scenario.obstacles)
    return ", ".join([*slope, *([counted(count, "obstacle")] if count else [])])


def _section(beam: BeamSection) -> str:
    """Return shape and sizes of the cross-section, with the material if it has a name."""
    shape = beam.section.shape
    sizes = [getattr(beam.section, name) for name in SHAPES[shape].sizes[:2]] if shape else []
    if any(isinstance(value, tuple) for value in (*sizes, beam.area, beam.second_moment)):
        words = f"tapered {_SHAPES.get(shape, 'beam')}"
    elif shape:
        across = "Ø " if SHAPES[shape].sizes[0] == "diameter" else ""
        words = f"{_SHAPES[shape]} {across}{' × '.join(short(1e3 * size) for size in sizes)} mm"
    else:
        area, moment = 1e6 * float(beam.area), 1e12 * float(beam.second_moment)  # type: ignore[arg-type]
        words = f"beam, A = {short(area)} mm², I = {short(moment)} mm⁴"
    return f"{beam.material} {words}".strip()


def _material(beam: BeamSection) -> str:
    """Return the numbers of the material, and a mass at the tip."""
    tip = f", tip mass {short(beam.tip_mass)} kg" if beam.tip_mass else ""
    return f"E = {short(beam.youngs_modulus / 1e9)} GPa, ρ = {beam.density:.4g} kg/m³{tip}"


def _coordinates(scenario: Scenario) -> str:
    """Return how many modes or elements there are."""
    how = scenario.discretization
    modes, elements = counted(how.modes, "mode"), counted(how.elements, "element")
    if how.method == "fem":
        return elements if scenario.is_nodal else f"{elements}, {modes}"
    return {"modal": modes, "absolute": f"{elements}, absolute coordinates"}.get(how.method, how.method)


def short(value: float) -> str:
    """Return a number with up to three digits, with a power of ten where it is large or small."""
    mantissa, power = f"{value:.2e}".split("e")
    if -4 < int(power) < 5:
        return f"{float(f'{value:.3g}'):.10g}"
    times = "" if float(mantissa) == 1.0 else f"{float(mantissa):g} × "
    return f"{times}10{str(int(power)).translate(_POWERS)}"

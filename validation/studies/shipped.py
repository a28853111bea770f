"""The shipped studies: declarative descriptions, run by `oblique-impact refine --study NAME`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from inspect import getdoc

from oblique_impact.errors import InputError
from oblique_impact.marching.event import EventScheme
from oblique_impact.marching.fixed_step import FixedStepScheme
from oblique_impact.marching.generalized_alpha import GeneralizedAlphaScheme
from oblique_impact.marching.time_stepping import TimeSteppingScheme
from oblique_impact.scenario.messages import did_you_mean
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.runs import FEM, FRICTIONLESS, MEAN_AXIS, NODAL, SPRING
from oblique_impact.validation.studies.convergence import TOLERANCE
from oblique_impact.validation.studies.ladders import Ladder, Study

_MASSLESS = "contact.point_inertia=none"
#: Hermite elements: frequencies, and what depends on them smoothly, converge like h^4
_HERMITE = 4.0
#: digits to show, not a requirement: at a fixed model nothing but rounding is in the way
_FINE = 1e-6


def _paper(*changes: str) -> Scenario:
    return Scenario.builtin("paper", list(changes))


def elements() -> Iterator[Ladder]:
    """Finite elements at a fixed number of modes.

    The mesh is reduced to its own first six mean-axis modes, so that the number of coordinates
    stays the same while the modes become exact. Cubic Hermite elements give frequencies of order 4,
    and at a fixed number of modes the motion depends smoothly on them as long as the sequence of
    contacts stays the same.
    """
    names = ("first_impact", "collision_end", "impulse", "peak_force", "energy_after_collision", "second_impact")
    declared, levels = dict.fromkeys(names, _HERMITE), (32.0, 64.0, 128.0, 256.0)
    modes = (FEM, MEAN_AXIS, "discretization.modes=6")
    rigid, soft = _paper(*modes, "end_time=0.75"), _paper(*modes, "end_time=0.9", SPRING, FRICTIONLESS)
    yield Ladder("rigid stop", rigid, "elements", levels, names, declared)
    yield Ladder("elastic stop", soft, "elements", levels, names, declared)


#: the three motions that every scheme is refined on: changes, quantities
_MOTIONS = {
    "flight": (
        ("contact.enabled=false", "end_time=2.0", "beam.youngs_modulus=7e8", "discretization.modes=1", MEAN_AXIS),
        # a hundred times softer than the paper's, so that vibration counts as much as rotation
        ("tip_y@end", "deflection@end"),
    ),
    "elastic stop": (
        ("discretization.modes=4", MEAN_AXIS, FRICTIONLESS, SPRING, "end_time=0.3201"),
        # the largest force is that of a step's end, or of a sample: it comes close to the maximum at no order
        ("first_impact", "impulse", "peak_force", "theta@end", "tip_y@end"),
    ),
    "rigid stop": (
        ("discretization.modes=4", MEAN_AXIS, FRICTIONLESS, "end_time=0.36"),
        ("first_impact", "impulse", "peak_force", "collision_end", "theta@end"),
    ),
}
_ORDERS = {
    "fixed-step": float(FixedStepScheme.order),
    "event": float(EventScheme.order),
    "generalized-alpha": float(GeneralizedAlphaScheme.order),
}
#: by axis and by whether the beam flies, from coarse to fine
_LEVELS: dict[tuple[str, bool], tuple[float, ...]] = {
    ("steps", True): (8e-4, 4e-4, 2e-4, 1e-4),
    ("steps", False): (1.6e-5, 8e-6, 4e-6, 2e-6, 1e-6),
    ("tolerances", True): (1e-7, 1e-8, 1e-9, 1e-10, 1e-11),
    ("tolerances", False): (1e-5, 1e-6, 1e-7, 1e-8, 1e-9),
}


def steps() -> Iterator[Ladder]:
    """Time steps and tolerances of the three schemes.

    Each scheme on the same three motions. In free flight each should show the order it declares: 4
    for the fixed steps of the paper, 8 in the mean step for the event-located scheme, whose tolerance
    is refined in place of a step, 2 for generalized-alpha. On the stops the schemes that locate
    events may keep theirs; the paper's fixed steps notice a contact up to a step late, which is an
    error of first order with a random factor. The rigid stop adds the jumps of velocity, at a fixed
    number of modes.
    """
    for motion, (changes, names) in _MOTIONS.items():
        for scheme, order in _ORDERS.items():
            axis, flying = "tolerances" if scheme == "event" else "steps", motion == "flight"
            # one step for flight and contact, so that the order shows in both
            one_step = ("solver.free_step=1e-6", "solver.contact_step=1e-6") if axis == "steps" else ()
            base = _paper(*changes, *one_step, f"solver.scheme={scheme}")
            # contact noticed at the end of a step, and jumps of velocity, leave no scheme its order by right
            smooth = flying or (motion == "elastic stop" and scheme == "generalized-alpha")
            declared = {name: order for name in names if smooth and name != "peak_force"}
            yield Ladder(f"{motion}, {scheme}", base, axis, _LEVELS[axis, flying], names, declared)


#: by axis, from coarse to fine
_REMEDY_LEVELS = {
    "modes": (8.0, 16.0, 24.0, 32.0),
    "elements": (8.0, 16.0, 32.0, 64.0, 128.0),
    "steps": (8e-5, 4e-5, 2e-5, 1e-5, 5e-6),
}


def remedies() -> Iterator[Ladder]:
    """Modes and elements with the rigid stop, and three remedies.

    With a rigid stop and e = 0 the mass that stops at an impact falls with every mode that is
    added. The force on the continuous beam is a distribution: its impulse has a limit, its peak and
    the number of impacts have none, and what follows, such as the second impact, stays where chance
    puts it (modal non-convergence). Three remedies: a stop of finite stiffness, which is another stop but
    has a limit of every quantity; internal damping (Kelvin-Voigt), which calms what follows a touch-down,
    whose force stays singular; and an integrator that takes the high frequencies away (generalized-alpha
    with spectral radius 0).
    """
    # differences are of 1e-4 and more: a tolerance of 1e-8 is tight enough, and the noise shows it
    event = (MEAN_AXIS, "solver.tolerance=1e-8")
    nodal = (*NODAL, "solver.free_step=2e-5")
    dissipative = (*nodal, "solver.rho_infinity=0.0", "solver.contact_step=2e-5")
    names = ("impulse", "peak_force", "second_impact", "contacts")

    def ladder(name: str, axis: str, changes: Iterable[str]) -> Ladder:
        return Ladder(name, _paper(FRICTIONLESS, "end_time=0.75", *changes), axis, _REMEDY_LEVELS[axis], names)

    yield ladder("rigid, modes", "modes", event)
    yield ladder("rigid, elements", "elements", (*nodal, "solver.rho_infinity=1.0", "solver.contact_step=2e-6"))
    yield ladder("elastic stop", "modes", (*event, SPRING, "end_time=0.9"))
    # a twentieth of critical damping at 10⁴ rad/s
    yield ladder("Kelvin-Voigt", "modes", (*event, "beam.kelvin_voigt=1e-5"))
    # at a fixed contact step of 2e-5 s: h²/2c at 32 elements and 8 h²/c at 128, with c² = EI/m
    yield ladder("dissipation, elements", "elements", dissipative)
    # whether its limit depends on the step
    yield ladder("dissipation, steps", "steps", (*dissipative, "discretization.elements=32"))


#: Kelvin-Voigt damping (s), modes that resolve it (eta omega_N > 0.5), elements that do (h < pi sqrt(eta c))
_DAMPINGS = (
    (1e-4, 12, (8.0, 16.0, 32.0, 64.0)),
    (1e-5, 24, (16.0, 32.0, 64.0, 128.0)),
    (1e-6, 48, (32.0, 64.0, 128.0)),
)


def rigid_stop() -> Iterator[Ladder]:
    """Rigid stop with internal damping: three ways to one limit.

    With Kelvin-Voigt damping that the mesh resolves, plastic impacts on finer and finer meshes, a
    contact point without inertia, and an elastic stop that becomes stiffer and stiffer have the same
    limit. Impacts lose energy like the size of the elements: nothing in the limit. The peak of the force
    has none: it grows with every element.
    """
    names = ("collision_end", "impulse", "second_impact", "lost_impact", "contacts", "peak_force")

    def order(p: float) -> dict[str, float]:
        return dict.fromkeys(("collision_end", "impulse", "second_impact"), p)

    common = (MEAN_AXIS, FRICTIONLESS, "end_time=0.72")
    small_steps = ("solver.scheme=generalized-alpha", "solver.free_step=5e-6", "solver.contact_step=2.5e-7")
    for viscosity, modes, meshes in _DAMPINGS:
        group, damped = f"damping {viscosity:g} s", (*common, f"beam.kelvin_voigt={viscosity}")
        nodal = (*NODAL, *damped, *small_steps)
        # explicit steps of the event scheme are as short as the damping of the highest mode is strong
        modal = (*damped, *(small_steps if modes > 24 else ("solver.tolerance=1e-9",)))
        counts = tuple(float(round(part * modes)) for part in (1 / 2, 2 / 3, 5 / 6, 1))
        stiff = (*modal, SPRING, f"discretization.modes={modes}")
        for case, changes, axis, levels, declared in (
            ("plastic, elements", nodal, "elements", meshes, {"lost_impact": 1.0}),
            ("no inertia, elements", (*nodal, _MASSLESS), "elements", meshes, order(_HERMITE)),
            ("no inertia, modes", (*modal, _MASSLESS), "modes", counts, {}),
            ("stiff spring", stiff, "stiffness", (1e8, 1e9, 1e10, 1e11), order(1.0)),
        ):
            yield Ladder(f"{group}, {case}", _paper(*changes), axis, levels, names, declared)
    coarse = (*NODAL, *common, "beam.kelvin_voigt=1e-5", "discretization.elements=32")
    stepped = _paper(*coarse, "solver.free_step=2e-5", "solver.contact_step=1e-6")
    yield Ladder("damping 1e-05 s, steps", stepped, "steps", (2e-5, 1e-5, 5e-6, 2.5e-6), names, order(2.0))


#: s after the first touch-down; the last contact of the slap and of the edge ends after 9.9 ms
_LATER = 0.012


def _falls(case: str) -> Scenario:
    """Return the case with a place of contact on each node, and steps that are a quarter near an obstacle."""
    return Scenario.builtin(case, ["solver.free_step=1e-5", "solver.contact_step=2.5e-6"])


def _from_near(case: str, share: float) -> Scenario:
    """Return the case from just above the table, straight, and with a `share` of all speeds and places.

    With the weight m g and the inertia m L^2/3 about the pin a straight beam that has fallen from the angle a to b
    has omega^2 = 3 (g/L) (sin a - sin b).  With a share of gravity too, impulses by linear kinematics are that
    share, energies its square.
    """
    full = _falls(case)
    sides = [side.model_dump() for side in full.obstacles]
    (side,) = full.sides
    below = 0.99 * side.origin[1] / min([full.beam.length, *side.extent[1:]])
    speed = math.sqrt(3.0 * full.gravity / full.beam.length * (math.sin(full.initial.angle) - below))
    sides[0]["origin"] = 0.0, share * side.origin[1]
    return full.replace(
        end_time=0.0145,
        gravity=share * full.gravity,
        initial__angle=math.asin(share * below),
        initial__angular_velocity=-share * speed,
        obstacles=sides,
    )


def anywhere() -> Iterator[Ladder]:
    """Beam that lies down on a table: many places at once.

    A damped beam slaps flat onto a table, and across the edge of one that ends inside of its span. Nodes
    with their inertia, whose impacts are plastic, nodes without any, and modes whose residual flexibility
    stands in for it have one limit. In the long fall from its angle the beam vibrates a little; one that
    begins straight, just above the table, does not. With a tenth of all speeds and places, of which linear
    kinematics has a tenth of the impulse and a hundredth of the energy, it tells what of a difference is
    kinematics. With the edge moved to the last node before it the values jump until a node happens to be
    near. Without damping there is no limit but a band.
    """
    of_collision = ("impulse", f"lost_after:{_LATER}", "collision_duration", "zone")
    meshes, steps = (24.0, 48.0, 96.0, 192.0), (8e-5, 4e-5, 2e-5, 1e-5, 5e-6)
    first = dict.fromkeys(("impulse", f"lost_after:{_LATER}"), float(TimeSteppingScheme.order))
    undamped = _falls("slap").replace(beam__kelvin_voigt=0.0)
    for route, inertia in (("plastic", "kept"), ("no inertia", "none")):
        for case in ("slap", "edge"):
            falls, straight, slow = (
                found.replace(contact__point_inertia=inertia)
                for found in (_falls(case), _from_near(case, 1.0), _from_near(case, 0.1))
            )
            yield Ladder(f"{case}, {route}, elements", falls, "elements", meshes, of_collision, scenario=case)
            yield Ladder(f"{case}, {route}, steps", falls, "steps", steps, of_collision, first, case)
            yield Ladder(
                f"straight {case}, {route}", straight, "elements", meshes, of_collision[:2], scenario=case
            )
            yield Ladder(f"slow {case}, {route}", slow, "elements", meshes, of_collision[:2], scenario=case)
        band = undamped.replace(contact__point_inertia=inertia)
        for axis, levels in (("elements", (16.0, *meshes[:3], 128.0)), ("steps", steps)):
            name = f"slap, undamped, {route}, {axis}"
            yield Ladder(name, band, axis, levels, ("impulse", "contacts", "zone"), scenario="slap")
    modes = _falls("slap").replace(contact__point_inertia="none", discretization__frame="mean-axis")
    counts, alone = (12.0, 16.0, 24.0, 32.0), (16.0, 32.0, 64.0, 128.0)
    yield Ladder("slap, no inertia, modes", modes, "modes", counts, of_collision, scenario="slap")
    yield Ladder("edge, plastic, nodes alone", _falls("edge"), "nodes alone", alone, of_collision, scenario="edge")


#: by name: what makes the ladders, with title and text, and the relative uncertainty to reach
STUDIES: dict[str, tuple[Callable[[], Iterator[Ladder]], float]] = {
    "elements": (elements, _FINE),
    "steps": (steps, _FINE),
    "remedies": (remedies, TOLERANCE),
    "rigid-stop": (rigid_stop, 1e-4),
    "anywhere": (anywhere, 5e-3),
}


def predictability_cases() -> dict[str, Scenario]:
    """Return the cases of `--study predictability`: stops from soft to rigid, without and with damping."""
    # a spectral radius of 1: the scheme itself takes nothing out of the vibrations
    nodal = (
        *(*NODAL, FRICTIONLESS, "end_time=1.0", "solver.rho_infinity=1.0", "solver.free_step=1e-5"),
        *("solver.output_interval=1e-2", "discretization.elements=64", "solver.contact_step=2.5e-7"),
    )
    cases = {
        f"spring of {stiffness} N/m": _paper(*nodal, SPRING, f"contact.stiffness={stiffness}")
        for stiffness in ("1e6", "1e7", "1e8", "1e9")
    }
    rigid = _paper(*nodal, _MASSLESS)
    return {**cases, "rigid, undamped": rigid, "rigid, damped": rigid.replace(beam__kelvin_voigt=1e-5)}


def shipped_study(name: str) -> Study:
    """Return a shipped study; raises InputError that lists them."""
    described = {key: getdoc(make) or "" for key, (make, _) in STUDIES.items()}
    if name not in STUDIES:
        known = "; ".join(f"{key} ({text.partition('.')[0].lower()})" for key, text in described.items())
        raise InputError(f"--study {name}: shipped studies are {known}{did_you_mean(name, STUDIES)}")
    make, tolerance = STUDIES[name]
    title, _, text = described[name].partition(".\n\n")
    return Study(name, title, text, tuple(make()), tolerance)

"""Runs of scenarios drawn at random over all features: energy, gaps, cones, sums and the order of events.

A scenario is drawn feature by feature; what Scenario refuses is drawn again.  Beams fall at about 4 rad/s from a
little above their obstacles.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import pytest

from oblique_impact import History, InputError, Outcome, Scenario, simulate
from oblique_impact.beam.beam import contact_places
from oblique_impact.contact.state import State

LENGTH, HALF_DEPTH, SPEED = 1.0, 0.01, 4.0  # m, m, rad/s

MODELS = {
    "modes, tangent": {"modes": 2},
    "modes, mean axis": {"modes": 3, "frame": "mean-axis"},
    "reduced, tangent": {"method": "fem", "elements": 4, "modes": 2},
    "reduced, mean axis": {"method": "fem", "elements": 4, "modes": 3, "frame": "mean-axis"},
    "nodal": {"method": "fem", "elements": 4, "modes": 0},
    "exact": {"method": "absolute", "elements": 4},
}
#: the schemes of each model are drawn in turn
SCHEMES = dict.fromkeys(MODELS, ("event", "fixed-step", "generalized-alpha", "time-stepping"))
SCHEMES |= {"nodal": ("generalized-alpha", "time-stepping"), "exact": ("time-stepping",)}
CASES = [(model, scheme) for model, schemes in SCHEMES.items() for scheme in schemes]
#: changes of sections by feature and choice; the first one is plain
FEATURES: dict[str, dict[str, dict[str, Any]]] = {
    "kinetics": {
        "first": {},
        "full": {"discretization": {"kinetics": "full"}},
        "zeroth": {"discretization": {"kinetics": "zeroth-order"}},
    },
    "root": {
        "pin": {},
        "hub": {"root": {"kind": "hub", "inertia": 0.02, "torque": -1.0}},
        "hub with a radius": {"root": {"kind": "hub", "inertia": 0.02, "hub_radius": 0.05}},
        "held": {"root": {"kind": "driven"}},
        "turned": {"root": {"kind": "driven", "profile": "constant-speed", "spin_rate": -SPEED}},
        "spun up": {
            "root": {"kind": "driven", "profile": "spin-up", "spin_rate": -SPEED, "spin_up_time": 5e-3}
            | {"hub_radius": 0.05}
        },
    },
    "start": {
        "moving": {},
        "equilibrium": {"initial": {"state": "equilibrium"}},
        "plucked by a force": {"initial": {"state": "plucked", "place": 0.8, "force": -5.0}},
        "plucked away": {"initial": {"state": "plucked", "place": 0.9, "deflection": 2e-5}},
    },
    "base": {"still": {}, "shaken": {"base": {"acceleration": 50.0, "frequency": 200.0}}},
    "where": {
        "point": {},
        "point inside": {"contact": {"point": 0.75}},
        "slope with an end": {},
        "slope": {"contact": {"where": "anywhere", "grid": 4}},
        "side": {"contact": {"where": "anywhere", "grid": 4}},
        "peg": {"contact": {"where": "anywhere"}},
        "two pegs": {"contact": {"where": "anywhere"}},
        "peg and side": {"contact": {"where": "anywhere", "grid": 2}},
    },
    "stop": {
        "rigid": {},
        "spring": {"contact": {"normal": "spring", "stiffness": 1e5}},
        "damped spring": {"contact": {"normal": "spring", "stiffness": 1e5, "damping": 0.5}},
        "bed": {"contact": {"normal": "spring"}},
        "linear damping": {"contact": {"normal": "spring", "stiffness": 1e5, "linear_damping": 20.0}},
    },
    "impact": {
        "plastic": {},
        "restitution": {"contact": {"restitution": 0.5}},
        "Routh": {"contact": {"impact": "routh"}},
        "without inertia": {"contact": {"point_inertia": "none"}},
    },
    "residual flexibility": {"kept": {}, "left out": {"contact": {"residual_flexibility": False}}},
    "shortening": {"kept": {}, "left out": {"contact": {"shortening": False}}},
    "friction": {
        "hybrid": {},
        "frictionless": {"contact": {"friction": "frictionless"}},
        "rougher at rest": {"contact": {"mu_static": 1.5, "mu_kinetic": 1.0}},
        "modified": {"contact": {"friction": "modified-coulomb"}},
        "axial flexibility": {"contact": {"axial_flexibility": True, "mu_static": 1.0, "mu_kinetic": 1.0}},
    },
    "surface": {"axis": {}, "section": {"contact": {"surface": "section"}}},
    "damping": {
        "none": {},
        "Kelvin-Voigt": {"beam": {"kelvin_voigt": 1e-5}},
        "mass": {"beam": {"mass_proportional": 5.0}},
        "modal": {"beam": {"modal_damping_ratio": 0.02}},
    },
    "beam": {
        "uniform": {},
        "tapered": {
            "beam": {"area": [[0.0, 4e-4], [1.0, 2e-4]], "second_moment": [[0.0, 1e-8], [1.0, 3e-9]]},
        },
        "tip mass": {"beam": {"tip_mass": 0.05}},
    },
    "masses": {
        "none": {},
        "inside": {"masses": [{"place": 0.43, "mass": 0.1, "inertia": 1e-4}]},
        "two": {"masses": [{"place": 0.21, "mass": 0.3}, {"mass": 0.02, "inertia": 2e-5}]},
    },
    "forces": {
        "none": {},
        "constant": {"forces": [{"place": 0.6, "force": -30.0}]},
        "harmonic": {"forces": [{"place": 0.85, "force": 40.0, "frequency": 300.0, "direction": 1.0}]},
        "sweep and table": {
            "forces": [{"force": 20.0, "sweep_rate": 5e4}, {"place": 0.5, "table": [[0.0, 20.0], [0.003, -40.0]]}]
        },
    },
}
#: features whose choices are all as likely; of others half are plain
LEVEL = {"where", "stop", "friction"}
LOADS = {"masses", "forces"}
#: roots that the exact beam has besides, or that yield
ROOTS_OF_EXACT: dict[str, dict[str, Any]] = {
    "free": {"kind": "free"},
    "clamp that yields": {"kind": "driven", "stiffness": 300.0, "damping": 0.1, "hub_radius": 0.05},
    "hub on a spring": {"kind": "hub", "inertia": 0.02, "hub_radius": 0.05, "stiffness": 300.0, "damping": 0.1},
}
STEP = 2e-5  # s


def pair(z: complex) -> list[float]:
    return [float(z.real), float(z.imag)]


def place_obstacles(given: dict[str, Any], where: str, bed: bool, rng: np.random.Generator) -> None:
    """Put slope or obstacles below the beam, which reaches them in 0.1 to 1 ms."""
    root, contact = given.get("root", {}), given.setdefault("contact", {})
    angle, radius = given["initial"]["angle"], root.get("hub_radius", 0.0)
    beam, above = np.exp(1j * angle), HALF_DEPTH if contact.get("surface") == "section" else 0.0
    slow = {"hold": 0.02, "spin-up": 0.02}.get(
        root.get("profile", "hold") if root.get("kind") == "driven" else "", 1.0
    )

    def below(x: float, deeper: float = 0.0) -> complex:
        """A place so far below the beam at x."""
        gap = slow * SPEED * (radius + x) * rng.uniform(1e-4, 1e-3)
        return (radius + x - 1j * (above + gap + deeper)) * beam

    def peg(x: float) -> dict[str, Any]:
        size = rng.choice([0.0, 0.02])
        return {"kind": "point", "origin": pair(below(x, size)), "radius": float(size)}

    def side(x: float) -> dict[str, Any]:
        tilt, half = rng.uniform(-0.2, 0.2), rng.uniform(0.05, 0.2)
        middle = below(x, half * abs(np.sin(tilt)))
        found = {"origin": pair(middle), "angle": angle + tilt, "extent": [-half, half]}
        return found | ({"bedding": 1e6} if bed else {})

    def outline() -> dict[str, Any]:
        """A solid with a hump, a hollow behind it and a step, turned with the beam."""
        reach, deep = rng.uniform(0.45, 0.7), 0.0 if bed else 0.03  # a bed has no corners
        upper = [(0.0, 0.02), (0.06, 0.0), (0.1, 0.004), (0.2, 0.002), (0.2, deep), (0.6, deep)]
        points = [pair((x - 1j * y) * np.exp(1j * rng.uniform(-0.01, 0.01))) for x, y in upper]
        lower = [[0.65, -0.1], [-0.05, -0.1]]
        closed = [*points, *lower, points[0]] if rng.random() < 0.5 else points
        found = {"kind": "polyline", "points": closed, "origin": pair(below(reach)), "angle": angle}
        return found | ({"bedding": 1e6} if bed else {})

    if where in ("point", "point inside", "slope with an end", "slope"):
        x, tilt = contact.get("point", LENGTH), rng.uniform(0.05, 0.5)
        # its fibre is nearest along the normal of the slope
        origin = below(x) + 1j * above * (beam - np.exp(1j * (angle + tilt)))
        given["slope"] = {"origin": pair(origin), "angle": angle + tilt}
        if where == "slope with an end":
            given["slope"]["extent"] = [-0.5, 1e-4]
        return
    given["slope"] = {"enabled": False}
    if where == "outline":
        contact["grid"] = 4
    obstacles = {
        "side": lambda: [side(0.7)],
        "peg": lambda: [peg(rng.uniform(0.3, 0.95))],
        "two pegs": lambda: [peg(0.4), peg(0.8)],
        "peg and side": lambda: [peg(0.4), side(0.8)],
        "outline": lambda: [outline()],
    }
    given["obstacles"] = obstacles[where]()


def drawn(case: int, rng: np.random.Generator) -> tuple[dict[str, str], dict[str, Any]]:
    """Return the choices of features and the scenario that they make, which may be refused."""
    model, scheme = CASES[case % len(CASES)]
    choices, given = {"model": model, "scheme": scheme}, {"discretization": dict(MODELS[model])}
    (of_loads,) = rng.spawn(1)  # which leaves all else as it is drawn
    for feature, options in FEATURES.items():
        names, dice = list(options), of_loads if feature in LOADS else rng
        plain = feature not in LEVEL and dice.random() < 0.5
        choices[feature] = names[0] if plain else str(dice.choice(names))
        for section, keys in options[choices[feature]].items():
            given[section] = keys if isinstance(keys, list) else given.get(section, {}) | keys
    given["initial"] = given.get("initial", {}) | {"angle": rng.uniform(-0.5, 0.7)}
    of_root = np.random.default_rng([51, case])  # which leaves all else as it is drawn
    if model == "exact" and of_root.random() < 0.6:
        choices["root"] = str(of_root.choice(list(ROOTS_OF_EXACT)))
        given["root"] = dict(ROOTS_OF_EXACT[choices["root"]])
    if "side" in choices["where"] and np.random.default_rng([53, case]).random() < 0.4:
        choices["where"] = "outline"
    if choices["root"] == "free":  # it moves as on a pin
        middle = 0.5 * LENGTH * np.exp(1j * given["initial"]["angle"])
        given["initial"] |= {"position": pair(middle), "velocity": pair(-1j * SPEED * middle)}
    if given.get("root", {}).get("kind") != "driven" and choices["start"] == "moving":
        given["initial"]["angular_velocity"] = -SPEED
    if choices["surface"] == "section":
        given["beam"] = given.get("beam", {}) | {"outer_fibre": HALF_DEPTH}
    decides = scheme == "time-stepping" and (model != "exact" or choices["stop"] == "rigid")
    every_step = 1e-3 * STEP  # also those of time-stepping that are shortened
    given["solver"] = {"scheme": scheme, "output_interval": every_step if decides else STEP}
    if scheme != "event":
        given["solver"] |= {"free_step": STEP, "contact_step": STEP}
    place_obstacles(given, choices["where"], choices["stop"] == "bed", rng)
    return choices, given | {"end_time": 0.004}


def allowed(case: int) -> tuple[dict[str, str], dict[str, Any], int]:
    """Return choices, a scenario of them that is not refused, and how many have been."""
    rng, refused = np.random.default_rng([49, case]), 0
    while True:
        choices, given = drawn(case, rng)
        try:
            Scenario.from_dict(given)
        except InputError:
            refused += 1
        else:
            return choices, given, refused


#: outcomes that say what mechanics or model do not allow
PHYSICAL = {
    Outcome.COMPLETED,
    Outcome.MASS_MATRIX_INDEFINITE,
    Outcome.PAINLEVE,
    Outcome.REDUNDANT_CONSTRAINTS,
    Outcome.IMPACT_OF_SEVERAL,
    Outcome.LARGE_DEFLECTION,
}
#: energy (J) that is unaccounted for: steps of a fixed length sum powers by rules of second order, which leaves
#: (omega h)^2/12 of 3 J, 7e-4 J at the 2,600 rad/s of a third mode
UNACCOUNTED = {"event": 1e-8, "fixed-step": 1e-3, "generalized-alpha": 3e-4, "time-stepping": 3e-5}
UNACCOUNTED["exact"] = 1e-8
#: gaps of rigid stops (m): fixed steps close a contact where one has ended in it; time-stepping leaves h^2 times
#: an acceleration, of some 1e4 m/s^2
PENETRATION = {"event": 1e-9, "fixed-step": SPEED * STEP, "time-stepping": 5e-6}
#: slip (m/s) along with its friction; where it is not located that the slip turns, its change in a step
DRIVEN = {"event": 1e-9, "generalized-alpha": 1e-8}


def method_of(history: History) -> str:
    """Return the scheme, or "exact": on elastic stops the exact beam locates transitions."""
    s = history.scenario
    return "exact" if s.is_absolute and s.contact.normal == "spring" else s.solver.scheme


def gaps_of_places(history: History) -> np.ndarray:
    """Gaps (samples, contacts) in m where a contact is possible: a place beyond the ends of a side has none."""
    s, gaps, along = history.scenario, history["contact_gap"].values.copy(), history["contact_slip"].values
    for i, place in enumerate(contact_places(s)):
        if place.on_side and place.extent:
            beside = (along[:, i] < place.extent[0]) | (along[:, i] > place.extent[1])
            gaps[beside | place.behind, i] = np.inf
    return gaps


def impulse_of_forces(history: History) -> float:
    """Return the sum (N s) of the integrals of all normal forces and of the impulses of impacts."""
    forces, times = history["contact_lambda_n"].values.sum(axis=1), history["time"].values
    if method_of(history) == "time-stepping":  # the force is all impulse of a step over its length
        return float(np.diff(times) @ forces[1:])
    impacts = sum(event.normal_impulse for event in history.events if event.kind.impulsive)
    return float(np.trapezoid(forces, times) + impacts)


def faults(history: History) -> Iterator[str]:
    """Yield what a run has done that it must not."""
    s, c = history.scenario, history.scenario.contact
    scheme, energy = method_of(history), history.balance
    normal, along = history["contact_lambda_n"].values, history["contact_lambda_tau"].values
    slip, largest = history["contact_slip_rate"].values, max(1.0, float(normal.max()))
    turn = float((np.abs(np.diff(slip, axis=0)) * (normal[1:] > 0.0)).max())
    if history.outcome not in PHYSICAL:
        yield f"ended as {history.outcome.label}: {history.summary['message']}"
    if not abs(energy["unaccounted"]) <= UNACCOUNTED["exact" if s.is_absolute else scheme]:
        yield f"{energy['unaccounted']:.2g} J unaccounted for"
    for name in ("impact", "friction", "damping"):
        if not energy[f"lost_{name}"] >= -UNACCOUNTED[scheme]:
            yield f"{-energy[f'lost_{name}']:.2g} J made by {name}"
    gaps = gaps_of_places(history)
    if c.normal == "rigid" and c.point_inertia == "kept" and not -gaps.min() <= PENETRATION[scheme]:
        yield f"{-gaps.min():.2g} m of penetration"
    # what the modes leave out of the beam bends a place away from its stop under the forces at others
    left_out = c.normal == "spring" and c.residual_flexibility and not (s.is_nodal or s.is_absolute)
    bends_away = left_out and gaps.shape[1] > 1
    undamped = c.damping == c.linear_damping == 0.0  # a damper lets go of a stop that is pressed in
    pressed = normal[gaps < -SPEED * STEP]
    if c.normal == "spring" and undamped and not bends_away and not np.all(pressed > 0.0):
        yield f"no force at a depth of {-gaps[normal == 0.0].min():.2g} m"
    if not normal.min() >= 0.0:
        yield f"a tension of {-normal.min():.2g} N"
    mu = {"frictionless": 0.0, "hybrid": c.mu_static, "modified-coulomb": c.mu_kinetic}[c.friction]
    if c.friction == "modified-coulomb" and scheme == "fixed-step":
        # a step that passes the end of a branch ends on the same straight line
        mu *= 1.0 + turn / (c.regularization[1] - c.regularization[0])
    outside = float((np.abs(along) - mu * normal).max())
    if not outside <= 1e-6 * largest:
        yield f"a force {outside:.2g} N outside of its cone"
    # axial flexibility, places without inertia and what the modes leave out slip by more than the coordinates do
    slides = (history["contact_state"].values != State.STICK) & (c.point_inertia == "kept")
    slides &= not (c.axial_flexibility or left_out)
    driven = float((along * slip * slides).max())
    if not driven <= DRIVEN.get(scheme, turn) * largest:
        yield f"friction that drives, {driven:.2g} W"
    # summed here, as the variables and the macro-collisions have them
    if not np.allclose(history["lambda_n"].values, normal.sum(axis=1), rtol=1e-12, atol=0.0):
        yield "lambda_n is not the sum over contacts"
    whole = sum(collision["normal_impulse"] for collision in history.macro_collisions)
    summed = impulse_of_forces(history)
    if not abs(whole - summed) <= (1e-9 if scheme == "time-stepping" else 1e-2) * max(whole, 0.1):
        yield f"macro-collisions of {whole:.4g} N s, forces and impacts of {summed:.4g} N s"
    times = [event.time for event in history.events]
    if times != sorted(times):
        yield "events out of order"


def can_be_unheld(given: dict[str, Any]) -> bool:
    """Whether there may be no equilibrium: the end slides off a slope that ends, or a force lifts the beam."""
    ends = bool(given.get("slope", {}).get("extent"))
    return ends or any(force.get("table") for force in given.get("forces", []))


def check(cases: Iterable[int]) -> None:
    """Run scenarios: none is at fault, and nine in ten touch something."""
    found, touched = [], []
    for case in cases:
        _, given, _ = allowed(case)
        try:
            history = simulate(Scenario.from_dict(given))
        except InputError as error:
            if "equilibrium" not in str(error) or not can_be_unheld(given):
                found.append(f"{error}: {json.dumps(given)}")
            continue
        except Exception as error:
            found.append(f"{type(error).__name__} {error}: {json.dumps(given)}")
            continue
        touched.append(bool(history.contacts))
        found += [f"{fault}: {json.dumps(given)}" for fault in faults(history)]
    assert found == [], "\n".join(found)
    assert touched.count(False) <= 1


@pytest.mark.parametrize("batch", range(4))
def test_forty_random_runs(batch, interpreted):
    check(range(10 * batch, 10 * (batch + 1)))


@pytest.mark.slow
@pytest.mark.parametrize("batch", range(30))
def test_three_hundred_random_runs(batch):
    check(range(40 + 10 * batch, 50 + 10 * batch))


def test_every_choice_is_drawn():
    """Each is in some of the three hundred, and features compose: one in fifteen drawn is allowed."""
    drawings = [allowed(case) for case in range(40, 340)]
    seen = {(feature, choice) for choices, *_ in drawings for feature, choice in choices.items()}
    assert {(feature, choice) for feature, options in FEATURES.items() for choice in options} <= seen
    assert {("where", "outline"), *(("root", choice) for choice in ROOTS_OF_EXACT)} <= seen
    assert sum(refused for *_, refused in drawings) < 14 * len(drawings)

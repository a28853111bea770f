"""The paper's beam on pegs: contacts whose places slide along the beam."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from oblique_impact.beam.cross_sections import Sections
from oblique_impact.contact.state import State
from oblique_impact.history.history import History
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import compute_history as simulate
from oblique_impact.validation.checks.registry import Measurement, checks_of
from oblique_impact.validation.reference_values import VALUES, source
from oblique_impact.validation.runs import FRICTIONLESS, SPRING, run_exact

check = checks_of("pegs", "Contact with a peg")

_BEAM = ("discretization.frame=mean-axis", "discretization.modes=4", "end_time=0.45")
_PEG = (0.5, 0.0)
#: some units of the last digit of the references; an energy adds up the errors of all steps
_TIME, _IMPULSE, _ENERGY = 2e-9, 1e-9, 3e-9
_ON_SPRINGS = _TIME, _TIME, 2.0 * _IMPULSE


def strike(pegs: Sequence[tuple[float, float]], *keys: str) -> History:
    """Let the beam fall onto points, without the slope."""
    given = Scenario.builtin("paper", [*_BEAM, *keys]).model_dump(mode="json", exclude_unset=True)
    given |= {
        "slope": {"enabled": False},
        "contact": {**given.get("contact", {}), "where": "anywhere"},
        "obstacles": [{"kind": "point", "origin": list(peg)} for peg in pegs],
    }
    return simulate(Scenario.from_dict(given))


@check("A beam falls onto a rigid peg, without and with friction.", seconds=1.5)
def rigid() -> Iterator[Measurement]:
    """Times, impulses of impacts and energy."""
    rough = ("contact.mu_static=0.3", "contact.mu_kinetic=0.3")
    for name, keys in (("frictionless", (FRICTIONLESS,)), ("friction", rough)):
        history = strike([_PEG], *keys)
        wanted, text = VALUES[f"peg-{name}"], source(f"peg-{name}")
        for k, (event, time) in enumerate(zip(history.events, wanted["times"], strict=True), start=1):
            yield Measurement(f"{event.kind.value}, {name}", event.time, time, "s", _TIME, text, f"{name}-{k}")
        impacts = [event for event in history.events if event.kind.value == "impact"]
        for k, (event, (impulse, loss)) in enumerate(zip(impacts, wanted["impacts"], strict=True), start=1):
            found, quantity = event.normal_impulse, f"impulse {k}, {name}"
            yield Measurement(quantity, found, impulse, "N s", _IMPULSE, text, f"{name}-P{k}")
            found, quantity = event.energy_loss, f"loss {k}, {name}"
            yield Measurement(quantity, found, loss, "J", _ENERGY, text, f"{name}-loss{k}")
        left = history.balance["final"]
        yield Measurement(f"energy, {name}", left, wanted["energy"], "J", _ENERGY, text, f"{name}-energy")


@check("A beam falls across two rigid pegs: impacts that alternate, until both hold it.", seconds=1.5)
def two() -> Iterator[Measurement]:
    """Times, impulses, losses and energy."""
    history = strike([(0.4, -0.02), (0.7, -0.035)], FRICTIONLESS, "end_time=0.385")
    wanted, text = VALUES["two-pegs"], source("two-pegs")
    for k, (event, time) in enumerate(zip(history.events, wanted["times"], strict=True), start=1):
        quantity = f"{event.kind.value} {k}, peg {event.obstacle}"
        yield Measurement(quantity, event.time, time, "s", _TIME, text, f"t{k}")
    impulses = [event.normal_impulse for event in history.events if event.kind.impulsive]
    for k, (found, impulse) in enumerate(zip(impulses, wanted["impulses"], strict=True), start=1):
        yield Measurement(f"impulse {k}", found, impulse, "N s", 6e-9 if impulse > 0.1 else 2e-11, text, f"P{k}")
    finite = sum(contact.normal_impulse for contact in history.contacts) - sum(impulses)
    energy, tolerance = history.balance, 2.0 * _IMPULSE
    yield Measurement("loss by impacts", energy["lost_impact"], wanted["loss"], "J", _ENERGY, text, "loss")
    yield Measurement("impulse of finite forces", finite, wanted["finite"], "N s", tolerance, text, "finite")
    yield Measurement("energy", energy["final"], wanted["energy"], "J", _ENERGY, text, "energy")
    yield Measurement("unaccounted", energy["unaccounted"], 0.0, "J", 1e-10, "balance of energy", "unaccounted")


@check("A beam falls onto an elastic peg of 10⁶ N/m, without friction, as a spring alone.", seconds=1.0)
def elastic() -> Iterator[Measurement]:
    """Times, impulses and largest forces of the contacts, and the last angle."""
    history = strike([_PEG], FRICTIONLESS, SPRING, "contact.residual_flexibility=false")
    yield from _on_springs("peg-elastic", history)


@check("Elastic pegs and an elastic slope with the flexibility that the modes leave out behind them.", seconds=5.0)
def residual_flexibility() -> Iterator[Measurement]:
    """Contacts, turns of the slip, loss by friction, last angle and the balance of energy."""
    rough = "contact.mu_static=0.3", "contact.mu_kinetic=0.3"
    two = [(0.35, 0.0), (0.7, 0.0)]
    tip = "end_time=0.8725", "solver.tolerance=1e-12"  # each contact adds to the errors of those before it
    for case, history in (
        ("peg-elastic-residual", strike([_PEG], FRICTIONLESS, SPRING)),
        ("peg-elastic-rough", strike([_PEG], SPRING, *rough)),
        ("pegs-elastic-residual", strike(two, FRICTIONLESS, SPRING)),
        ("pegs-elastic-rough", strike(two, SPRING, *rough)),
        ("slope-elastic-residual", simulate(Scenario.builtin("paper", [*_BEAM[:2], *tip, FRICTIONLESS, SPRING]))),
    ):
        wanted, text, balance = VALUES[case], source(case), history.balance
        for found in _on_springs(case, history):
            yield replace(found, quantity=f"{found.quantity}, {case}", name=f"{case}-{found.name}")
        turns = [event.time for event in history.events if event.kind.value == "reversal"]
        for k, (time, exact) in enumerate(zip(turns, wanted.get("turns", []), strict=True), start=1):
            yield Measurement(f"reversal {k}, {case}", time, exact, "s", _TIME, text, f"{case}-reversal-{k}")
        lost, left = balance["lost_friction"], balance["unaccounted"]
        exact = wanted.get("lost", 0.0)
        yield Measurement(f"loss by friction, {case}", lost, exact, "J", _ENERGY, text, f"{case}-lost")
        yield Measurement(f"unaccounted, {case}", left, 0.0, "J", 1e-8, "balance of energy", f"{case}-unaccounted")


def _on_springs(case: str, history: History) -> Iterator[Measurement]:
    """Yield what a run on elastic stops has in common with the reference of this name."""
    wanted, text = VALUES[case], source(case)
    # the dense output of the reference is good to 1e-5 N
    yield from _contacts(history, [row[1:] for row in wanted["contacts"]], (*_ON_SPRINGS, 5e-5), text)
    angle = float(history["theta"].values[-1])
    yield Measurement("last angle", angle, wanted["angle"], "rad", _TIME, text, "angle")


def _contacts(
    history: History, wanted: Sequence[Sequence[float]], allowed: Sequence[float], text: str
) -> Iterator[Measurement]:
    """Yield start (s), end (s), impulse (N s) and, where it is known, largest force (N) of each contact."""
    for k, (contact, known) in enumerate(zip(history.contacts, wanted, strict=True), start=1):
        found = contact.start, contact.end, contact.normal_impulse, contact.peak_force
        names, units = ("start", "end", "impulse", "largest force"), ("s", "s", "N s", "N")
        for name, value, exact, unit, tolerance in zip(names, found, known, units, allowed, strict=False):
            tail = f"{name.replace(' ', '-')}-{k}"
            yield Measurement(f"{name} {k}", value, exact, unit, tolerance, text, tail)


@check("A hub's torque draws the tip over the edge of an elastic table and back.", seconds=1.0)
def handover() -> list[Measurement]:
    """Jump of the force where tip and corner take over from each other, and the balance of energy.

    Both are as deep in the table but for the cosine of the beam's angle to it, here 0.05 rad.
    """
    height, past = 0.05, 6e-5  # m; the tip comes down so far beyond the end of the table
    end = float(np.sqrt(1.0 - height**2)) - past
    keys = (
        "discretization.frame=mean-axis discretization.modes=3 initial.angle=0 end_time=0.06 root.kind=hub "
        "root.inertia=0.01 root.torque=-10 contact.where=anywhere contact.normal=spring contact.stiffness=1e6 "
        "contact.residual_flexibility=false "
        f"contact.friction=frictionless slope.angle=0 slope.origin=[-1,{-height}] slope.extent=[0,{1.0 + end}]"
    )
    history = simulate(Scenario.builtin("paper", keys.split()))
    times, forces = history["time"].values, history["contact_lambda_n"].values.sum(axis=1)
    begun = {event.time: event.place for event in history.events if event.kind.value == "impact"}
    jumps, onto = [], set()
    for event in history.events:
        if event.kind.value == "release" and event.time in begun:
            before, after = forces[np.abs(times - event.time) < 1e-12]
            jumps.append(abs(after / before - 1.0))
            onto.add("table" if begun[event.time] == 1.0 else "corner")
    text = "the same depth, in the directions of beam and table"
    return [
        Measurement("ways over the edge", len(onto), 2, "1", 0, "onto the table and onto its corner", "ways"),
        Measurement("largest jump of the force", max(jumps), 0.0, "1", 1.25e-3, text, "jump"),
        Measurement("unaccounted", history.balance["unaccounted"], 0.0, "J", 1e-10, "balance of energy", "energy"),
    ]


@check("All nodes of a mesh against all its modes, on two elastic pegs with friction.", seconds=2.5)
def all_nodes() -> list[Measurement]:
    """Distance of event times between generalized-alpha and the event scheme, and its order over the step."""
    mesh = ["discretization.method=fem", "discretization.elements=4", "contact.normal=spring"]
    keys = [*mesh, "contact.mu_static=0.3", "contact.mu_kinetic=0.3", "end_time=0.4"]

    def events(*more: str) -> list[tuple[float, tuple[str, int]]]:
        history = strike([_PEG, (0.7, -0.01)], *keys, *more)
        return [(event.time, (event.kind.value, event.obstacle)) for event in history.events]

    # all modes: between nodes they leave out what an element bends by itself, which nodes have not
    wanted, apart = events("discretization.modes=8", "contact.residual_flexibility=false"), []
    for step in ("4e-6", "2e-6"):
        steps = f"solver.free_step={step}", f"solver.contact_step={step}", "solver.scheme=generalized-alpha"
        found = events("discretization.modes=0", *steps)
        same = [kind for _, kind in found] == [kind for _, kind in wanted]
        apart.append(max(abs(a - b) for (a, _), (b, _) in zip(found, wanted, strict=True)) if same else np.inf)
    text = "the same system by another scheme"
    return [
        Measurement("distance of event times, steps of 2e-6 s", apart[1], 0.0, "s", 2e-7, text, "distance"),
        Measurement("its order", float(np.log2(apart[0] / apart[1])), 2.0, "1", 0.1, "the scheme's", "order"),
    ]


@check("Modes against elements reduced to as many modes of their own, on two elastic pegs.", seconds=3.0)
def elements() -> list[Measurement]:
    """Distance of event times, and its order over the elements: that of Hermite elements in frequencies."""
    keys = ["contact.normal=spring", "contact.friction=frictionless", "discretization.modes=6", "end_time=0.42"]

    def times(*more: str) -> np.ndarray:
        history = simulate(Scenario.builtin("two-pegs", [*keys, *more]))
        return np.array([event.time for event in history.events[:8]])

    modal = times()
    apart = [
        float(np.max(np.abs(times("discretization.method=fem", f"discretization.elements={count}") - modal)))
        for count in (32, 64)
    ]
    text = "modes and elements share no shape functions"
    return [
        Measurement("distance of event times, 64 elements", apart[1], 0.0, "s", 2e-8, text, "distance"),
        Measurement("its order", float(np.log2(apart[0] / apart[1])), 4.0, "1", 0.5, "cubic elements", "order"),
    ]


def _reactions(modes: int) -> np.ndarray:
    """Let a damped beam settle on its pin and two pegs; their reactions over the weight of one span, (2,)."""
    radius = 1e-3
    scenario = Scenario.from_dict(
        {
            "end_time": 0.05,
            "beam": {"length": 1.0, "modal_damping_ratio": 0.9},
            "initial": {"angle": 0.0},
            "slope": {"enabled": False},
            "contact": {"where": "anywhere", "friction": "frictionless"},
            "discretization": {"frame": "mean-axis", "modes": modes},
            # the beam that sags does not quite reach a peg under its very end
            "obstacles": [{"kind": "point", "origin": (x, -radius), "radius": radius} for x in (0.5, 1.0 - 1e-9)],
        }
    )
    span = 0.5 * Sections.from_scenario(scenario).mass * scenario.gravity
    return np.asarray(simulate(scenario)["contact_lambda_n"].values[-1] / span)


@check("A beam of two equal spans comes to rest under its weight, on its pin and two rigid pegs.", seconds=0.5)
def at_rest() -> Iterator[Measurement]:
    """Reactions over the weight of a span, and their order in the number of modes."""
    text, names = source("three-supports"), ("middle", "end")
    few, many = _reactions(4), _reactions(12)
    wanted = np.array([VALUES["three-supports"][name] for name in names])
    for name, found, exact, left_out in zip(names, many, wanted, (1e-4, 5e-5), strict=True):
        # the flexibility that twelve modes leave out
        yield Measurement(f"reaction of the {name} support, 12 modes", found, exact, "1", left_out, text, name)
    moment = many @ np.array([0.5, 1.0])
    # arms shrink by the foreshortening, about the square of a slope of 1e-4
    quantity = "moment of both about the pin, over that of the weight"
    yield Measurement(quantity, moment, 1.0, "1", 1e-7, "equilibrium", "moment")
    orders = np.log(np.abs(few - wanted) / np.abs(many - wanted)) / np.log(3.0)
    text = "the flexibility that n modes leave out falls like n⁻³"
    for name, order in zip(names, orders, strict=True):
        yield Measurement(f"order in the modes, {name} support", order, 3.0, "1", 0.2, text, f"order-{name}")


#: pegs of 10⁵ N/m, 1 mm below the horizontal beam, which turns at 0.2 rad/s: it bends by 0.1 % of its length
_LOW = (
    SPRING,
    "contact.where=anywhere",
    FRICTIONLESS,
    "slope.enabled=false",
    "obstacles=[{kind='point', origin=[0.5, -0.001], stiffness=1e5}, "
    "{kind='point', origin=[0.75, -0.0015], stiffness=1e5}]",
    "initial.angle=0",
    "initial.angular_velocity=-0.2",
    "beam.kelvin_voigt=1e-5",
    "discretization.frame=mean-axis",
    "end_time=0.0155",
)


def _low(elements: int, step: float) -> History:
    """Let the exact beam, without shear and rotary inertia, fall onto two low pegs."""
    steps = (f"solver.free_step={step}", f"solver.contact_step={step}", "solver.output_interval=1e-3")
    keys = ("discretization.method=absolute", f"discretization.elements={elements}", *steps)
    return run_exact(Scenario.builtin("paper", [*_LOW, *keys]))


def _order(values: Sequence[float]) -> float:
    """Order of convergence of three values, each from twice as fine a discretization."""
    coarse, middle, fine = values
    return float(np.log2(abs((middle - coarse) / (fine - middle))))


@check("The exact beam against modes on two elastic pegs, where the beam hardly bends.", seconds=10.0)
def exact() -> Iterator[Measurement]:
    """Two contacts that overlap: orders in elements and step, then times and impulses.

    Extension does nothing here; what 24 modes leave out is as large as the differences.
    """
    modes = simulate(Scenario.builtin("paper", [*_LOW, "discretization.modes=24"]))
    of_ends = _order([_low(count, 2e-5).contacts[0].end for count in (4, 8, 16)])
    of_impulses = _order([_low(8, step).contacts[1].normal_impulse for step in (4e-5, 2e-5, 1e-5)])
    fine, text = _low(32, 1e-5), "24 modes in the event scheme, which share nothing with this beam"
    left = fine.balance["unaccounted"]
    yield Measurement("order in elements, of an end", of_ends, 4.0, "1", 0.2, "nodes converge like h⁴", "nodes")
    yield Measurement("order in steps, of an impulse", of_impulses, 2.0, "1", 0.1, "mid-point rule", "steps")
    yield Measurement("unaccounted", left, 0.0, "J", 1e-15, "balance of energy", "unaccounted")
    wanted = [(contact.start, contact.end, contact.normal_impulse) for contact in modes.contacts]
    yield from _contacts(fine, wanted, (3e-8, 1e-6, 2.7e-6), text)


#: a peg of 3e4 N/m at the middle, which the beam strikes as fast as it falls from 45 degrees
_STICKING = (
    SPRING,
    "contact.where=anywhere",
    "slope.enabled=false",
    "obstacles=[{kind='point', origin=[0.5, 0.0], stiffness=3e4}]",
    "initial.angle=0.01",
    "initial.angular_velocity=-4.56",
    "solver.output_interval=1e-3",
    "end_time=0.025",
)


def _stuck(history: History) -> float:
    """Time (s) that the only contact sticks."""
    ends = [event.time for event in history.events[1:]]
    spans = zip(history.events, ends, strict=False)
    return sum(end - event.time for event, end in spans if event.state == State.STICK)


@check("Friction of a beam with axial flexibility on an elastic peg, against the exact beam.", seconds=4.0)
def axial_flexibility() -> list[Measurement]:
    """Impulse of friction and time stuck, with mu = 0.3; without the flexibility -0.126 N s, and it never sticks.

    The flexibility is static: waves along the axis take a fortieth of the 23 ms that the contact lasts.
    """
    keys = "discretization.frame=mean-axis", "discretization.modes=8", "contact.axial_flexibility=true"
    flexible = simulate(Scenario.builtin("paper", [*_STICKING, *keys]))
    keys = "discretization.method=absolute", "discretization.elements=8", "solver.contact_step=2e-5"
    exact = simulate(Scenario.builtin("paper", [*_STICKING, *keys]))
    here, there = flexible.contacts[0], exact.contacts[0]
    text = "the exact beam, which stretches and has inertia along its axis"
    impulses = here.tangential_impulse, there.tangential_impulse
    unaccounted = flexible.balance["unaccounted"]
    return [
        Measurement("impulse of friction", *impulses, "N s", 0.02, text, "impulse"),
        Measurement("time stuck", _stuck(flexible), _stuck(exact), "s", 4e-4, text, "stuck"),
        Measurement("unaccounted", unaccounted, 0.0, "J", 1e-12, "balance of energy", "unaccounted"),
    ]

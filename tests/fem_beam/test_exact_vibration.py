"""Small vibrations of the beam in absolute coordinates about its equilibrium: closed forms, and all nodes."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import brentq

from oblique_impact import Scenario, frequencies_at_rest, simulate
from oblique_impact.fem_beam.exact import ElasticSections
from oblique_impact.fem_beam.exact.exact_vibration import vibration_modes
from oblique_impact.validation import fit
from oblique_impact.vibration import VibrationModes

STIFF, MASS = 68.952e9 * 7.85e-9, 3.14e-4 * 2766.7  # N m^2, kg
CLAMPED = ["root.kind=driven", "initial.angle=0", "initial.state=equilibrium"]
FREE = ["contact.enabled=false"]
PEG = [
    *CLAMPED,
    "contact.normal=spring",
    "contact.where=anywhere",
    "slope.enabled=false",
    "contact.stiffness=3e4",
    "contact.linear_damping=5",
    "beam.kelvin_voigt=1e-5",
    "obstacles=[{kind='point',origin=[0.7,0.005],radius=0.008}]",
]


def absolute(*words: str) -> Scenario:
    return Scenario.builtin("paper", [*words, "discretization.method=absolute"])


def slender(*words: str, count: int = 3, stuck: bool = False) -> VibrationModes:
    """Vibrations of a uniform beam that neither shears nor stretches, without rotary inertia."""
    rigid = ElasticSections.uniform(1e9 * STIFF, 1e9 * STIFF, STIFF, MASS)
    return vibration_modes(absolute(*words), count, stuck, rigid)


def roots(equation: Callable[[float], float], count: int) -> np.ndarray:
    """The first zeros of a function of lambda = (m omega^2/(E I))^(1/4) L."""
    grid = np.linspace(0.05, 12.0, 2000)
    values = [equation(at) for at in grid]
    signs = [k for k in range(grid.size - 1) if values[k] * values[k + 1] < 0.0]
    return np.array([brentq(equation, grid[k], grid[k + 1], xtol=1e-13) for k in signs[:count]])


def tip(at: float, mass: float, inertia: float, spring: float) -> float:
    """Secular equation of a cantilever with mass, inertia and a spring, each over that of the beam, at its tip."""
    c, s, ch, sh = math.cos(at), math.sin(at), math.cosh(at), math.sinh(at)
    mu, turns = mass * at - spring / at**3, inertia * at**3
    whole = 1.0 + c * ch + mu * (c * sh - s * ch) - turns * (ch * s + sh * c) + mu * turns * (1.0 - c * ch)
    return whole / ch


@pytest.mark.parametrize(
    ("words", "numbers"),
    [
        ([], (0.0, 0.0, 0.0)),
        ([f"masses=[{{mass={0.3 * MASS},inertia={0.01 * MASS}}}]"], (0.3, 0.01, 0.0)),
        (
            ["contact.normal=spring", f"contact.stiffness={40 * STIFF}", "slope.angle=0", "gravity=1e-3"],
            (0.0, 0.0, 40.0),
        ),
    ],
    ids=["bare", "mass at the tip", "on a spring"],
)
def test_a_cantilever_has_the_frequencies_of_its_secular_equation(words, numbers):
    """At the fourth order of the elements' size."""
    known = roots(lambda at: tip(at, *numbers), 3) ** 2 * math.sqrt(STIFF / MASS)
    free = [*FREE, "gravity=0"] if numbers[2] == 0.0 else []
    errors = []
    for elements in (8, 16, 32):
        found = slender(*CLAMPED, *free, *words, f"discretization.elements={elements}")
        errors.append(np.abs(found.frequencies / known - 1.0))
        assert np.all(found.damping == 0.0)
    assert np.all(errors[-1] < 2e-5)
    assert np.all(np.log2(np.array(errors[:-1]) / errors[1:]) > 3.7)
    assert len(found.closed) == (numbers[2] > 0.0)


@pytest.mark.parametrize("stuck", [False, True], ids=["free", "stuck"])
def test_a_cantilever_on_a_damped_peg_is_that_of_all_nodes(stuck):
    """Preloaded by some ten millimetres; stuck on it the beam stretches, as the axial flexibility has it."""
    words = [*PEG, "contact.mu_static=1", "discretization.elements=24"]
    nodes = ["discretization.method=fem", "discretization.modes=0", "solver.scheme=time-stepping"]
    nodal = Scenario.builtin("paper", [*words, *nodes, "contact.axial_flexibility=true"])
    then = frequencies_at_rest(nodal, 4, "stuck" if stuck else "free")
    scenario = absolute(*words)
    now = vibration_modes(scenario, 4, stuck, ElasticSections.bernoulli_euler(scenario))
    assert now.frequencies == pytest.approx(then.frequencies, rel=2e-3)
    assert now.damping == pytest.approx(then.damping, rel=5e-3)
    assert now.closed[0][0] == then.closed[0][0] == 1
    assert now.closed[0][1] == pytest.approx(then.closed[0][1], abs=1e-5)
    assert now.shapes == pytest.approx(then.shapes, abs=2e-3)


def test_a_hub_hangs_and_swings_as_that_of_all_nodes():
    words = [*FREE, "initial.state=equilibrium", "initial.angle=-1.2", "root.kind=hub", "root.inertia=0.1"]
    words += ["masses=[{place=0.43,mass=0.5,inertia=0.001}]"]
    nodal = Scenario.builtin("paper", [*words, "discretization.method=fem", "discretization.modes=0"])
    then, now = frequencies_at_rest(nodal, 4), slender(*words, count=4)
    assert now.frequencies == pytest.approx(then.frequencies, rel=1e-4)
    assert now.shapes == pytest.approx(then.shapes, abs=1e-3)


def test_a_force_across_is_a_spring_that_turns_with_the_beam():
    """A run from a slightly bent beam vibrates at the first frequency about the bent equilibrium."""
    words = [*FREE, *CLAMPED, "gravity=0", "forces=[{force=3000}]", "discretization.elements=8"]
    found = frequencies_at_rest(absolute(*words), 2)
    assert found.damping == pytest.approx(0.0, abs=1e-9)
    period = 2.0 * math.pi / found.frequencies[0]
    pluck = ["initial.state=plucked", "initial.place=1", "initial.deflection=1e-4"]
    run = [f"end_time={2.2 * period}", f"solver.output_interval={period / 400}", "solver.free_step=5e-5"]
    history = simulate(absolute(*words, *pluck, *run))
    along = history["q"].values[:, -1] - simulate(absolute(*words, "end_time=1e-4"))["q"].values[0, -1]
    moved = along * np.exp(-2j * np.pi * history["time"].values / period)
    whole = history["time"].values < 2.0 * period * (1.0 - 1e-9)
    first, second = (moved[k * 400 : (k + 1) * 400].mean() for k in range(2))
    assert whole.sum() >= 800
    assert abs(np.angle(second / first)) < 0.02  # rad in a period


def test_a_fit_of_frequencies_gives_stop_and_mass_back(tmp_path):
    loads = "masses=[{place=0.5,mass=0.1}]", "forces=[{place=0.9,force=5,direction=1.5}]"
    scenario = absolute(*PEG, *loads, "discretization.elements=6")
    rates = frequencies_at_rest(scenario, 2).frequencies.tolist()
    lines = [f"frequency:{k} [rad/s], {rate!r}, 0.01" for k, rate in enumerate(rates, start=1)]
    data = tmp_path / "frequencies.csv"
    data.write_text("\n".join(["quantity, value, deviation", *lines]) + "\n")
    guess, keys = scenario.replace(masses=[{"place": 0.5, "mass": 0.08}]), ["masses.1.mass", "contact.stiffness"]
    found = fit(guess, data, vary=keys, starts=1, workers=1)
    assert found["masses.1.mass"].value == pytest.approx(0.1, rel=1e-4)
    assert found["contact.stiffness"].value == pytest.approx(3e4, rel=1e-4)


def test_frequencies_at_rest_say_what_is_closed():
    found = frequencies_at_rest(absolute("contact.normal=spring", "initial.angle=0.4"), 3)
    assert found.closed == ((0, 1.0),)
    assert found.shapes.shape == (3, found.stations.size)
    assert np.all(np.diff(found.frequencies) > 0.0)

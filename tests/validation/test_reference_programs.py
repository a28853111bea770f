"""The table of reference values is what the programs named as its sources compute, without the suite."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from oblique_impact.validation.reference_values import REFERENCES, VALUES

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
#: relative differences that the entries state, and that of numbers with all digits
TOLERANCES = {"3-SVQ-amp": 2e-5, "3-SVQ-min-modes": 2e-6, "3-SVQ-table": 1e-6, "3-SVQ-min": 1e-8}
FAST = ("1.1", "1.2", "1.4-c4", "1.4-h8", "2-c-d1-eta2", "2-h-d0-eta5", "5c", "5e", "7c")


def load(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, BENCHMARKS / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def beams():
    module = load("reference_beams")
    module.spinning_entries()
    return module


def flat(value) -> list[float]:
    if isinstance(value, dict):
        return [number for key in sorted(value, key=str) for number in flat(value[key])]
    if isinstance(value, (list, tuple)):
        return [number for item in value for number in flat(item)]
    return [float(value)]


def named(program: str) -> list[str]:
    """Entries whose source is this program."""
    return [item for item, reference in REFERENCES.items() if f"{program}.py" in reference.source]


def entries() -> list:
    slow = pytest.mark.slow
    return [item if item in FAST else pytest.param(item, marks=slow) for item in named("reference_beams")]


@pytest.mark.parametrize("item", entries())
def test_an_entry_is_what_its_program_computes(beams, item):
    computed, stated = flat(beams.shown(beams.ENTRIES[item]())), flat(VALUES[item])
    np.testing.assert_allclose(computed, stated, rtol=TOLERANCES.get(item, 2e-11), atol=1e-15)


@pytest.mark.parametrize(
    ("name", "friction"), [("frictionless", 0.0), pytest.param("hybrid", 0.3, marks=pytest.mark.slow)]
)
def test_two_modes_of_the_paper_are_what_scipy_computes(name, friction):
    beam = load("reference_impact").two_modes(friction)
    np.testing.assert_allclose([time for _, time in beam.events], VALUES[f"two-modes-{name}"], rtol=0, atol=1e-11)
    assert beam.first == pytest.approx(VALUES["two-modes-impulse"], abs=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("modes", sorted(VALUES["rigid-stop-modes"]))
def test_modes_on_a_rigid_stop_are_what_scipy_computes(modes):
    assert load("reference_impact").mean_axis(modes) == pytest.approx(VALUES["rigid-stop-modes"][modes], abs=1e-7)


@pytest.fixture
def compliance():
    load("reference_impact")  # which it imports
    return load("reference_compliance")


@pytest.mark.parametrize("words", [["--pegs", "0.35,0,0.7,0"], ["--slope"]], ids=" ".join)
def test_forces_of_elastic_contacts_are_the_derivative_of_their_energy(compliance, words):
    beam = compliance.beam_of(compliance.arguments([*words, "--residual"]))
    closed, state = list(range(beam.count)), beam.start()
    state[:3] = (0.3, 0.05, -0.03) if beam.pegs == [] else (-0.001, -0.04, 0.02)

    def energy(q: np.ndarray) -> float:
        touches = beam.touches(np.concatenate([q, state[q.size :]]))
        return -0.5 * beam.forces(touches, closed)[0] @ [touch.gap for touch in touches]

    q, h = state[: beam.modes + 1], 1e-5
    slopes = [(energy(q + step) - energy(q - step)) / (2.0 * h) for step in h * np.eye(q.size)]
    found = beam.forces(beam.touches(state), closed)[2]
    np.testing.assert_allclose(-np.array(slopes), found, rtol=0, atol=1e-7 * np.abs(found).max())


@pytest.mark.parametrize(
    "case",
    [
        item if item == "peg-elastic-residual" else pytest.param(item, marks=pytest.mark.slow)
        for item in named("reference_compliance")
    ],
)
def test_elastic_contacts_are_what_scipy_computes(compliance, case):
    given = compliance.arguments(REFERENCES[case].source.split("reference_compliance.py")[1].split())
    beam, wanted = compliance.beam_of(given), VALUES[case]
    last = beam.march(given.end)
    found = [(c.index, c.start, c.end, c.impulse, c.peak) for c in beam.contacts]
    np.testing.assert_allclose(found, wanted["contacts"], rtol=0, atol=1e-5)
    np.testing.assert_allclose(np.array(found)[:, :4], np.array(wanted["contacts"])[:, :4], rtol=0, atol=1e-10)
    turns = [time for time, kind, _ in beam.log if kind == "turn"]
    np.testing.assert_allclose(turns, wanted.get("turns", []), rtol=0, atol=1e-10)
    assert (last[0], last[-1]) == pytest.approx((wanted["angle"], wanted.get("lost", 0.0)), abs=1e-10)
    assert beam.total(last) == pytest.approx(beam.total(beam.start()), abs=1e-11)


@pytest.mark.parametrize("drive", ["base", "force"])
@pytest.mark.parametrize(
    "frequency", ["3.2", *(pytest.param(value, marks=pytest.mark.slow) for value in ("4.2", "4.4"))]
)
def test_deflections_of_a_strip_with_a_clearance_are_what_harmonic_balance_computes(drive, frequency):
    found = load("reference_harmonic_balance").response(drive, float(frequency))
    assert found == pytest.approx(VALUES[f"clearance-{drive}"]["deflections"][frequency], abs=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("drive", ["base", "force"])
def test_the_fold_of_a_strip_with_a_clearance_is_what_harmonic_balance_computes(drive):
    program = load("reference_harmonic_balance")
    assert program.fold(drive) == pytest.approx(VALUES[f"clearance-{drive}"]["fold"], rel=1e-5)
    assert program.returns(VALUES[f"clearance-{drive}"]["none"], program.DRIVES[drive]) > 0.1


def test_an_orbit_of_harmonic_balance_is_stable_where_the_strip_comes_to_it():
    """And on an orbit without impacts its multipliers are those of the damped first mode."""
    program = load("reference_harmonic_balance")
    free = program.Balance(*program.DRIVES["base"]).settled(4.7, periods=1)
    decay = 0.005 * program.RATES[0] / 4.7
    assert abs(free.multiplier) == pytest.approx(np.exp(-decay), rel=1e-9)
    assert abs(program.Balance(*program.DRIVES["base"]).settled(3.2).multiplier) < 0.95

"""The measured cantilever through a roller: its scenarios against finite elements written here, and its fit."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from oblique_impact import Scenario, frequencies_at_rest
from oblique_impact.validation import fit
from oblique_impact.validation.studies.fitting.least_squares import FitProblem, parameters_of
from oblique_impact.validation.studies.fitting.measured import Campaign, Experiment, read_measured
from tests.docs.test_commands import DOCS, ROOT, command_lines

FOLDER = ROOT / "examples" / "measured" / "roller"
#: V, at the six places of the roller, which is 59.7 mm + 55.6 mm/V (V - 1.2278 V) from the clamp
VOLTAGES = (1.2273, 1.647, 2.0839, 2.5049, 2.9358, 3.3687)
STIFFNESS, MASS = 204e9 * 0.051 * 0.00666**3 / 12.0, 7850.0 * 0.051 * 0.00666
LENGTH, SENSOR, SENSOR_MASS = 0.501, 0.313, 0.046
NODAL = {"method": "fem", "elements": 32, "modes": 0}


def scenario(number):
    return Scenario.load(str(FOLDER / f"{number}.toml"))


def place_of(scenario):
    """Place (m) of the roller from the clamp."""
    return scenario.obstacles[0].origin[0] - scenario.root.hub_radius


def by_elements(place, spring, dashpot=0.0, kelvin_voigt=0.0, clamp=(math.inf, 0.0)):
    """First two frequencies (rad/s) and damping ratios of a clamped beam on a spring, by cubic elements."""
    nodes = np.unique(np.concatenate([np.linspace(0.0, LENGTH, 31), [place, SENSOR]]))
    size = 2 * nodes.size
    M, K = np.zeros((size, size)), np.zeros((size, size))
    for k, h in enumerate(np.diff(nodes)):
        at, by_slope = slice(2 * k, 2 * k + 4), np.array([1.0, h, 1.0, h])
        bent = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
        moved = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
        K[at, at] += STIFFNESS / h**3 * bent * np.outer(by_slope, by_slope)
        M[at, at] += MASS * h / 420.0 * moved * np.outer(by_slope, by_slope)
    C = kelvin_voigt * K
    sensor, roller = (2 * int(np.flatnonzero(nodes == x)[0]) for x in (SENSOR, place))
    M[sensor, sensor] += SENSOR_MASS
    K[roller, roller] += spring
    C[roller, roller] += dashpot
    yields = math.isfinite(clamp[0])
    K[1, 1] += clamp[0] if yields else 0.0
    C[1, 1] += clamp[1]
    free = slice(1 if yields else 2, None)
    M, K, C = (X[free, free] for X in (M, K, C))
    # the lowest modes are the largest of 1/s, which are good to rounding
    inverse = np.block([[-np.linalg.solve(K, C), -np.linalg.solve(K, M)], [np.eye(len(M)), np.zeros_like(M)]])
    values = 1.0 / np.linalg.eigvals(inverse)
    values = values[values.imag > 0.0]
    values = values[np.argsort(np.abs(values))][:2]
    return np.abs(values), -values.real / np.abs(values)


def test_the_scenarios_differ_in_the_place_of_the_roller_alone():
    first = scenario(1)
    for number, voltage in enumerate(VOLTAGES, start=1):
        one = scenario(number)
        assert place_of(one) == pytest.approx(0.0597 + 0.0556 * (voltage - 1.2278), abs=6e-5)
        assert one.replace(obstacles=first.model_dump(mode="json", exclude_unset=True)["obstacles"]) == first


@pytest.mark.parametrize("number", range(1, 7))
def test_frequencies_through_the_roller_are_those_of_finite_elements(number):
    """A support of twice the stiffness of one half; in sixteen modes damping is 3e-4 too small."""
    one = scenario(number)
    found = frequencies_at_rest(one, 2)
    frequencies, damping = by_elements(place_of(one), 2e8, kelvin_voigt=1e-5)
    assert found.closed == ((1, pytest.approx(place_of(one))), (2, pytest.approx(place_of(one))))
    assert found.frequencies == pytest.approx(frequencies, rel=2e-5)
    assert found.damping == pytest.approx(damping, rel=5e-4)


def test_a_clamp_and_a_roller_that_yield_and_damp_are_those_of_finite_elements():
    one = scenario(3).adapted(
        root__stiffness=1e4,
        root__damping=5.0,
        contact__stiffness=2e7,
        contact__linear_damping=3e3,
        discretization=NODAL,
    )
    found = frequencies_at_rest(one, 2)
    frequencies, damping = by_elements(place_of(one), 4e7, 6e3, 1e-5, (1e4, 5.0))
    assert found.frequencies == pytest.approx(frequencies, rel=2e-5)
    assert found.damping == pytest.approx(damping, rel=2e-4)


def test_the_fit_of_the_how_to_says_what_fits_and_which_keys_stand_for_each_other(tmp_path, monkeypatch, cli):
    """The command as it stands there."""
    (words,) = (words for words in command_lines(DOCS / "howto" / "fit.md") if "--data" in words)
    monkeypatch.chdir(ROOT)
    code, _, error = cli(*words[1:], "--workers", 1, "--out", tmp_path / "out")
    assert code == 0, error
    found = json.loads((tmp_path / "out" / "results.json").read_text())
    keys = {row["key"]: row for row in found["keys"]}
    roller = [place_of(scenario(1)) + 0.1 - keys["root.hub_radius"][end] for end in ("high", "value", "low")]
    assert roller == pytest.approx([0.052, 0.059, 0.066], abs=1e-3)
    assert keys["masses.1.mass"]["value"] == pytest.approx(0.0434, rel=0.02)
    assert keys["beam.youngs_modulus"]["value"] == pytest.approx(2.06e11, rel=0.01)
    assert any("beam.youngs_modulus and root.hub_radius (0.97" in line for line in found["remarks"])
    errors = {name: [] for name in ("frequency:1", "frequency:2")}
    for row in found["data"]:
        if row["column"] in errors:
            errors[row["column"]].append(abs(row["fitted"] / row["measured"] - 1.0))
    assert 0.009 < max(errors["frequency:1"]) < 0.0105
    assert 0.009 < max(errors["frequency:2"]) < 0.0110


#: of the page: keys besides the clamp's place and the sensor's mass, first guesses, sums of squares of frequencies
#: and of damping ratios, largest misses of the two frequencies
VARIANTS = [
    ("beam.kelvin_voigt root.stiffness", "root.stiffness=7500", 16.8, 45.7, 0.0086, 0.0108),
    ("beam.kelvin_voigt contact.stiffness", "contact.stiffness=1.8e8", 16.9, 45.9, 0.0096, 0.0102),
    (
        "contact.stiffness contact.linear_damping",
        "beam.kelvin_voigt=0 contact.stiffness=2e7 contact.linear_damping=1.2e4",
        *(30.0, 48.0, 0.019, 0.014),
    ),
]


@pytest.mark.slow
@pytest.mark.parametrize(("keys", "guess", "frequencies", "damping", "first", "second"), VARIANTS)
def test_what_yields_or_damps_besides_explains_what_the_page_says(
    keys, guess, frequencies, damping, first, second
):
    """Sums of squares alone: the profiles of a clamp and a roller that are stiff are open and take long."""
    scenarios = [Scenario.load(str(FOLDER / f"{number}.toml"), guess.split()) for number in range(1, 7)]
    experiments = [
        Experiment(str(n), one, read_measured(FOLDER / f"{n}.csv", one))
        for n, one in enumerate(scenarios, start=1)
    ]
    campaign = Campaign(tuple(experiments))
    parameters = parameters_of(["root.hub_radius", "masses.1.mass", *keys.split()], scenarios)
    problem = FitProblem(campaign, parameters, campaign.first_deviations())
    solution = problem.minimize(np.zeros(len(parameters)))
    table = campaign.table.assign(squares=solution.residuals**2, fitted=problem.predict(solution.u))
    table["miss"] = (table["fitted"] / table["measured"] - 1.0).abs()
    of = table.groupby("column")
    squares, misses = of["squares"].sum(), of["miss"].max()
    assert squares.filter(like="frequency").sum() == pytest.approx(frequencies, rel=0.04)
    assert squares.filter(like="damping").sum() == pytest.approx(damping, rel=0.04)
    assert misses[["frequency:1", "frequency:2"]].tolist() == pytest.approx([first, second], abs=1e-3)


@pytest.mark.slow
def test_without_the_place_next_to_the_clamp_the_model_says_what_was_measured():
    (first, data), *others = [(scenario(n), FOLDER / f"{n}.csv") for n in range(2, 7)]
    keys = ["root.hub_radius", "beam.youngs_modulus", "masses.1.mass", "beam.kelvin_voigt"]
    found = fit(first, data, others=others, vary=keys, starts=1, workers=1)
    assert found.about["sum_of_squares"] == pytest.approx(18.4, abs=0.2)
    assert not any("does not say" in line for line in found.remarks)

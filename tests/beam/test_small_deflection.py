"""The warning about large deflections: threshold and estimate are those of the map against the exact beam."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.beam.small_deflection import NOTICEABLE, deflection_error, deflection_warnings
from oblique_impact.history.samples import warnings_of
from oblique_impact.problem import beam_of
from validation.absolute.deflection_errors import Point, SmallDeflection

STORE = Path(__file__).parents[2] / "docs" / "small-deflection.json"
HUB = ("root.kind=hub", "root.inertia=1")
MEAN, FULL = "discretization.frame=mean-axis", "discretization.kinetics=full"


def shipped() -> SmallDeflection:
    rows = json.loads(STORE.read_text(encoding="utf-8"))
    missing = {"error": math.nan}
    return SmallDeflection(tuple(Point(**(row | (missing if row["error"] is None else {}))) for row in rows), 0.0)


@pytest.mark.parametrize(
    ("problem", "model", "words", "ratio"),
    [
        ("hub", "tangent, first order", HUB, 1.0),
        ("hub", "tangent, full", (*HUB, FULL), 1.0),
        ("pendulum", "mean axis, first order", (MEAN,), 1.0),
        ("pendulum", "mean axis, full", (MEAN, FULL), 1.0),
        # from the root's tangent the tip is 3.7 times as far away
        ("pendulum", "tangent, first order", (), 3.7),
        ("pendulum", "tangent, full", (FULL,), 3.7),
    ],
)
def test_estimates_are_those_of_the_map(problem, model, words, ratio):
    """The law is a square; the points lie within a factor around it, spin by spin."""
    scenario = Scenario.builtin("paper", list(words))
    assert deflection_error(scenario, 0.1) == pytest.approx(
        shipped().coefficient(problem, model) * (0.1 / ratio) ** 2, rel=0.5
    )
    assert deflection_error(scenario, 0.2) == pytest.approx(4.0 * deflection_error(scenario, 0.1))


def test_the_ratio_of_tip_deflections_is_that_of_the_first_hinged_mode():
    b = 3.9266023120479
    share = math.sin(b) / math.sinh(b)
    tip, slope = 2.0 * math.sin(b), b * (1.0 + share)
    assert (slope - tip) / -tip == pytest.approx(3.7, abs=0.05)


def test_the_map_goes_from_a_thousandth_to_half_of_the_length():
    points = shipped().points
    assert min(point.deflection for point in points) < 1e-3
    assert max(point.deflection for point in points) > 0.45
    assert {point.outcome for point in points} == {"completed", "mass-matrix-indefinite"}


def test_a_tenth_is_worth_a_warning_to_either_side_whatever_the_sign():
    """27 (d/L)^2 = 0.1 on a pin in the mean axis."""
    pinned = Scenario.builtin("paper", [MEAN])
    limit = math.sqrt(0.1 / 27.0)
    assert [len(deflection_warnings(pinned, factor * limit)) for factor in (0.99, 1.01)] == [0, 1]
    for sign in (1.0, -1.0):
        (line,) = warnings_of(beam_of(pinned), {"uy": sign * np.array([[0.0, 0.1], [0.0, -0.01]])}, [])
        assert line.startswith("largest deflection 0.1 m, 10 % of the length")


def test_a_hub_without_inertia_holds_no_root():
    pin, free, held = (
        deflection_error(Scenario.builtin("paper", list(root)), 0.1) for root in ((), ("root.kind=hub",), HUB)
    )
    assert free == pin != held


def test_a_run_warns_with_its_estimate_and_a_small_deflection_does_not():
    soft = ["beam.youngs_modulus=1e9", "contact.enabled=false", MEAN, "end_time=0.4"]
    history = simulate(Scenario.builtin("paper", soft))
    largest = float(abs(history["uy"]).max())
    scenario = Scenario.builtin("paper", soft)
    assert (deflection_error(scenario, largest) > NOTICEABLE) == any(
        words.startswith("largest deflection") for words in history.summary["warnings"]
    )
    limit = math.sqrt(NOTICEABLE / 27.0)
    assert deflection_warnings(scenario, 0.99 * limit) == []
    (words,) = deflection_warnings(scenario, 0.1)
    assert words == (
        "largest deflection 0.1 m, 10 % of the length: the small-deflection model is off by about 27 % of it "
        'within two elastic periods; discretization.method = "absolute" is exact'
    )
    assert "by more than itself" in deflection_warnings(scenario, 0.3)[0]

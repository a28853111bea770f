"""The machinery of the checks: verdicts, errors, selection."""

from __future__ import annotations

import math
import subprocess
import sys

import pytest

from oblique_impact.validation.checks.registry import Check, CheckGroup, Measurement, all_checks
from oblique_impact.validation.suite import select


@pytest.mark.parametrize(
    ("computed", "reference", "tolerance", "verdict"),
    [
        (1.0, 1.0, 0.0, "pass"),
        (1.1, 1.0, 0.11, "pass"),
        (1.2, 1.0, 0.1, "fail"),
        (math.nan, 1.0, math.inf, "fail"),
        (math.inf, 1.0, math.inf, "fail"),
        (1.0, math.nan, 1.0, "fail"),
    ],
)
def test_a_verdict_is_error_against_tolerance(computed, reference, tolerance, verdict):
    assert Measurement("x", computed, reference, "m", tolerance, "none").verdict == verdict


def test_an_error_in_a_check_is_a_failure_with_its_name():
    def broken() -> Measurement:
        raise ValueError("no\nsuch thing")

    (found,) = Check("a.b", CheckGroup("a", "A"), "a problem", 0.1, broken).evidence().measurements
    assert found.verdict == "fail"
    assert found.quantity == "did not finish: ValueError: no such thing"


def test_quick_leaves_out_what_takes_long():
    assert {check.id for check in select()} > {check.id for check in select(quick=True)}
    assert max(check.seconds for check in select(quick=True)) <= 2.0


def test_checks_have_one_order_whatever_is_imported_first():
    listed = "from oblique_impact.validation.checks.registry import all_checks; print(*all_checks())"
    other = subprocess.run(
        [sys.executable, "-c", f"import oblique_impact.validation.checks.rods; {listed}"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert other.stdout.split() == [*all_checks()]

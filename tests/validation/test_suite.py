"""The machinery of the checks: verdicts, errors, selection."""

from __future__ import annotations

import math

import pytest

from oblique_impact import InputError
from oblique_impact.validation.checks.registry import (
    Check,
    Group,
    Measurement,
)
from oblique_impact.validation.suite import counts, results_of, select

HOME = Group("a", "A")


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

    (found,) = Check("a.b", HOME, "a problem", 0.1, broken).evidence().measurements
    assert found.verdict == "fail"
    assert found.quantity == "did not finish: ValueError: no such thing"


def test_counts_are_of_checks_measurements_and_failures():
    def check(name, *computed):
        measured = [Measurement("x", value, 0.0, "m", 1.0, "", str(n)) for n, value in enumerate(computed)]
        return Check(f"a.{name}", HOME, "", 0.1, lambda: measured)

    checks = [check("one", 0.0, 2.0, 2.0), check("two", 2.0, 0.0)]
    results = results_of(checks, {check.id: check.evidence() for check in checks})
    assert counts(results) == "2 checks, 5 measurements: 3 fail"
    assert counts(results[:1]) == "1 check, 1 measurement: all pass"


def test_selection_by_group_and_by_check():
    assert {check.group.id for check in select(["statics", "frames"])} == {"statics", "frames"}
    assert [check.id for check in select(["statics.inclined"])] == ["statics.inclined"]
    assert len(select(quick=True)) < len(select())
    with pytest.raises(InputError, match="--only statica: should be a group"):
        select(["statica"])

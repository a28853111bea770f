"""The machinery of the checks: verdicts, errors, selection."""

from __future__ import annotations

import math

import pytest

from oblique_impact import InputError
from oblique_impact.validation.checks.registry import (
    Check,
    Evidence,
    Group,
    Measurement,
    all_checks,
    checks_of,
    within,
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


def test_relative_tolerances_become_absolute_ones():
    assert within("x", 2.1, -2.0, "m", 0.1, "none").tolerance == pytest.approx(0.2)


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


@pytest.mark.parametrize(("seconds", "mark"), [(2.0, "quick"), (2.1, "full")])
def test_a_check_of_more_than_two_seconds_is_not_quick(seconds, mark):
    assert Check("a.b", HOME, "a problem", seconds, list).mark == mark


def test_two_checks_of_one_name_are_refused():
    check = checks_of("frequencies", "again")

    def clamped_free() -> Measurement:
        return Measurement("x", 0.0, 0.0, "1", 0.0, "none")

    all_checks()
    with pytest.raises(ValueError, match=r"frequencies\.clamped-free"):
        check("a problem")(clamped_free)


def test_checks_are_many_and_most_are_quick():
    checks = all_checks().values()
    assert len(checks) >= 60
    assert len({check.group.id for check in checks}) >= 16
    assert sum(check.mark == "quick" for check in checks) >= 45


def test_selection_by_group_and_by_check():
    assert {check.group.id for check in select(["statics", "frames"])} == {"statics", "frames"}
    assert [check.id for check in select(["statics.inclined"])] == ["statics.inclined"]
    assert len(select(quick=True)) < len(select())
    with pytest.raises(InputError, match="--only statica: should be a group"):
        select(["statica"])


def test_evidence_may_be_one_measurement_many_or_with_pictures():
    one = Measurement("x", 0.0, 0.0, "1", 0.0, "none")
    for found in (one, [one], Evidence([one])):
        assert Check("a.b", HOME, "a problem", 0.1, lambda found=found: found).evidence().measurements == [one]

"""The checks of `validate`: verdicts, errors, selection, and that all of the quick ones hold."""

from __future__ import annotations

import ast
import math
import re
from pathlib import Path

import numpy as np
import pytest

from oblique_impact import InputError
from validation.checks.registry import Check, Evidence, Group, Measurement, all_checks, checks_of, within
from validation.curves import hausdorff_distance
from validation.suite import compute, results_of, select

HOME = Group("a", "A")
ROOT = Path(__file__).parents[2]


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


def test_two_checks_of_one_name_are_refused():
    check = checks_of("frequencies", "again")

    def clamped_free() -> Measurement:
        return Measurement("x", 0.0, 0.0, "1", 0.0, "none")

    all_checks()
    with pytest.raises(ValueError, match=r"frequencies\.clamped-free"):
        check("a problem")(clamped_free)


def test_checks_are_many_and_say_what_they_are():
    checks = all_checks()
    assert len(checks) >= 60
    assert len({check.group.id for check in checks.values()}) >= 16
    for check in checks.values():
        assert check.problem.endswith((".", "?"))
        assert check.id.startswith(check.group.id + ".")
        assert check.function.__doc__


def comparisons(node: ast.expr) -> list[ast.expr]:
    """Truth values that an expression, or the argument of a cast, is made of; what another call takes is none."""
    cast = isinstance(node, ast.Call) and ast.unparse(node.func) in ("float", "bool", "int")
    inside: list[ast.AST] = list(node.args) if cast else [node]
    found = []
    while inside:
        part = inside.pop()
        if isinstance(part, ast.Compare | ast.BoolOp | ast.UnaryOp) and not isinstance(
            getattr(part, "op", None), ast.USub
        ):
            found.append(part)
        skipped = (ast.Subscript, ast.IfExp, ast.comprehension, ast.Call)
        if not isinstance(part, skipped):
            inside += ast.iter_child_nodes(part)
        elif isinstance(part, ast.IfExp):
            inside += [part.body, part.orelse]
    return found


@pytest.mark.parametrize("file", sorted((ROOT / "validation" / "checks").glob("*.py")), ids=lambda file: file.stem)
def test_no_check_makes_a_number_of_a_truth_value(file):
    """`float(a < b)` hides how far a is from b: what is measured is a number with a tolerance."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    casts = [
        n for n in ast.walk(tree) if isinstance(n, ast.Call) and ast.unparse(n.func) in ("float", "bool", "int")
    ]
    assert [ast.unparse(cast) for cast in casts for argument in cast.args if comparisons(argument)] == []


def test_a_truth_value_in_a_check_would_be_noticed():
    def found(text: str) -> bool:
        return bool(comparisons(ast.parse(text, mode="eval").body))

    assert found("float(rate < 4.0)")
    assert found("float(a == b)")
    assert found("sum(float(x > 1) for x in y)") is False  # the inner cast is looked at by itself
    assert not found("float(np.abs(values[times > 15.0]).max())")
    assert not found("float(sum(value > 1e-4 for value in values))")


def test_selection_by_group_and_by_check():
    assert {check.group.id for check in select(["statics", "frames"])} == {"statics", "frames"}
    assert [check.id for check in select(["statics.inclined"])] == ["statics.inclined"]
    assert len(select(quick=True)) < len(select())
    with pytest.raises(InputError, match="--only statica: should be a group"):
        select(["statica"])


def test_the_quick_validation_holds():
    """All of it in one test, so that it is computed once."""
    checks = select(quick=True)
    rows = results_of(checks, compute(checks, 1))
    assert [f"{r.id}: {r.computed} against {r.reference}" for r in rows if r.verdict == "fail"] == []
    assert len({row.id for row in rows}) == len(rows) >= 200
    for row in rows:
        assert row.source, row.id
        assert not re.search(r"\b(as above|as below|prototype|independent (program|code))\b", row.source), row.id
        # 1 against 1, exactly, is a truth value
        assert not (row.computed == row.reference == 1.0 and row.tolerance == 0.0), row.id
        assert row.unit, row.id
        assert row.quantity, row.id
        # zero, doubling or a changed sign of what was computed would be noticed
        assert row.reference == 0.0 or row.tolerance < abs(row.reference), row.id


@pytest.mark.slow
def test_the_whole_validation_holds():
    checks = select()
    results = results_of(checks, compute(checks, 2))
    assert [r.id for r in results if r.verdict == "fail"] == []


def test_evidence_may_be_one_measurement_many_or_with_pictures():
    one = Measurement("x", 0.0, 0.0, "1", 0.0, "none")
    for found in (one, [one], Evidence([one])):
        assert Check("a.b", HOME, "a problem", 0.1, lambda found=found: found).evidence().measurements == [one]


def test_hausdorff_distance_of_curves_with_jumps():
    """A step that comes a little later is as far as it is late, though the values differ by one."""
    early = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0]])
    late = early + np.array([[0.0, 0.0], [0.01, 0.0], [0.01, 0.0], [0.0, 0.0]])
    assert hausdorff_distance(early, late) == pytest.approx(0.01, abs=1e-15)
    assert hausdorff_distance(early, early + np.array([0.0, 0.3])) == pytest.approx(0.3)
    spike = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 5.0], [1.0, 0.0], [2.0, 0.0]])
    assert hausdorff_distance(np.array([[0.0, 0.0], [2.0, 0.0]]), spike) == pytest.approx(5.0)

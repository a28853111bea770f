"""Every check of `validate` is a test: `pytest -k statics.own-weight` runs one, `-k rigid-impact` a group."""

from __future__ import annotations

import pickle
import re

import numpy as np
import pytest

from oblique_impact.validation.checks.registry import all_checks
from oblique_impact.validation.suite import rows_of

MARKS = {"quick": (), "full": pytest.mark.slow}


def exchanged(reference: float) -> float:
    """The reference with its first digit and the next different one exchanged."""
    digits, exponent = f"{abs(reference):.16e}".split("e")
    d = digits.replace(".", "")
    k = next(k for k in range(1, len(d)) if d[k] != d[0])
    d = d[k] + d[1:k] + d[0] + d[k + 1 :]
    return float(np.copysign(float(f"{d[0]}.{d[1:]}e{exponent}"), reference))


@pytest.mark.parametrize(
    "check", [pytest.param(check, id=check.id, marks=MARKS[check.mark]) for check in all_checks().values()]
)
def test_check(check):
    evidence = pickle.loads(pickle.dumps(check.evidence()))  # as `validate` takes it from its processes
    frame = rows_of([check], {check.id: evidence}).reset_index()
    rows = [*frame.itertuples()]
    assert [f"{r.id}: {r.computed} against {r.reference}" for r in rows if r.verdict == "fail"] == []
    assert len({row.id for row in rows}) == len(rows) > 0
    assert check.problem.endswith((".", "?"))
    assert check.function.__doc__
    for row in rows:
        assert row.source
        assert row.unit
        assert row.quantity
        assert not re.search(r"\b(as above|as below|prototype|independent (program|code))\b", row.source), row.id
        # 1 against 1, exactly, is a truth value
        assert not (row.computed == row.reference == 1.0 and row.tolerance == 0.0), row.id
        # zero, doubling or a changed sign of what was computed would be noticed
        assert row.reference == 0.0 or row.tolerance < abs(row.reference), row.id
        if row.reference:
            assert abs(row.computed - exchanged(row.reference)) > row.tolerance, row.id

"""Planted faults: the sources with a line made wrong, and the test that has to fail on them.

The faults are data: `physics.toml`, `studies.toml` and `pictures.toml` beside this file. A check of `validate` is
a test as well, `tests/validation/test_checks.py::test_check[ID]`: so they vouch for its groups too. All faults
are planted by `make test-slow`, those of QUICK by `make test`.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from .planting import ROOT, Workshop

TABLES = [Path(__file__).with_name(f"{name}.toml") for name in ("physics", "studies", "pictures")]
FAULTS = [fault for table in TABLES for fault in tomllib.loads(table.read_text(encoding="utf-8"))["fault"]]
NAMES = [fault["name"] for fault in FAULTS]
TESTS = sorted({fault["test"] for fault in FAULTS})
QUICK = ("friction pushes forward", "kPa called MPa", "columns error and tolerance exchanged")


@pytest.fixture(scope="module")
def workshop(tmp_path_factory):
    workshop = Workshop(tmp_path_factory.mktemp("faults"))
    yield workshop
    workshop.close()


def test_every_fault_can_be_planted():
    assert len(set(NAMES)) == len(NAMES)
    assert set(QUICK) <= set(NAMES)
    for fault in FAULTS:
        assert fault.keys() == {"name", "file", "right", "wrong", "test"}, fault["name"]
        assert (ROOT / fault["file"]).read_text(encoding="utf-8").count(fault["right"]) == 1, fault["name"]
        assert fault["right"] != fault["wrong"], fault["name"]


def test_the_tests_that_faults_name_are_there(workshop, request):
    """What this process has not collected itself, such as slow tests, another one does."""
    here = {name for item in request.session.items for name in (item.nodeid, item.nodeid.partition("[")[0])}
    elsewhere = [test for test in TESTS if test not in here]
    code, _ = workshop.run(*elsewhere, options=["--collect-only"]) if elsewhere else (0, {})
    assert code == 0, workshop.log.read_text()[-2000:]


def test_every_group_of_checks_finds_a_fault():
    from validation.checks.registry import all_checks

    found = {match[1] for test in TESTS if (match := re.search(r"test_check\[([\w-]+)\.", test))}
    assert found == {check.group.id for check in all_checks().values()}


@pytest.mark.slow
def test_without_a_fault_the_tests_pass(workshop):
    code, outcomes = workshop.run(*TESTS, seconds=3600)
    assert (code, set(outcomes.values())) == (0, {"passed"}), workshop.log.read_text()[-2000:]


@pytest.mark.parametrize(
    "fault", [pytest.param(f, id=f["name"], marks=() if f["name"] in QUICK else pytest.mark.slow) for f in FAULTS]
)
def test_a_planted_fault_fails_its_test(workshop, fault):
    job = {key: fault[key] for key in ("file", "right", "wrong")}
    code, outcomes = workshop.run(fault["test"], **job)
    assert (code, "failed" in outcomes.values()) == (1, True), workshop.log.read_text()[-2000:]

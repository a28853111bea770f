"""The page of questions is what its stored numbers give, and its two computations agree."""

from __future__ import annotations

from importlib import import_module

import pytest

from oblique_impact.validation.reference_values import VALUES
from tests.docs.test_commands import ROOT

REFERENCES = [key for key in VALUES if key.startswith("which-way-")]


@pytest.fixture
def asked(monkeypatch):
    """The program of the page."""
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    return import_module("questions.__main__")


def test_the_page_is_what_the_stored_numbers_give(asked):
    text = asked.PAGE.read_text(encoding="utf-8")
    assert asked.page(asked.questions(), asked.stored(), text) == text, "python -m questions --write"


def test_every_number_beside_one_of_the_program_agrees_with_it(asked):
    numbers, questions = asked.stored(), asked.questions()
    assert [question.name for question in questions] == [*numbers]
    assert [line for one in questions for line in asked.disagreements(one, numbers[one.name])] == []


def test_a_number_that_changes_is_named(asked):
    (question, *_) = asked.questions()
    (row, *rest) = before = asked.stored()[question.name]
    (name, (ours, other)), *_ = row["values"].items()
    changed = [{**row, "values": {**row["values"], name: [1.01 * ours, other]}}, *rest]
    assert asked.differences(question, before, before) == []
    (line,) = asked.differences(question, changed, before)
    assert name in line


@pytest.mark.parametrize("key", REFERENCES)
def test_references_of_checks_are_the_numbers_beside_those_of_the_program(asked, key):
    rows = asked.stored()[key.removeprefix("which-way-")]
    for name, wanted in VALUES[key].items():
        found = [row["values"][name][1] for row in rows if name in row["values"]]
        assert wanted == pytest.approx(found, rel=1e-5), name


@pytest.mark.slow
def test_the_questions_are_answered_as_before(asked, capsys):
    assert asked.main([]) == 0, capsys.readouterr().out

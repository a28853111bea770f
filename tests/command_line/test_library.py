"""The program as a library: calls are silent, say how far they are, and refuse bad input in one line."""

from __future__ import annotations

import doctest

import pytest

from oblique_impact import Progress, Scenario, natural_frequencies, scenario_schema, simulate
from oblique_impact.beam import frequencies
from oblique_impact.scenario import schema
from oblique_impact.validation import refine, validate
from tests.refusals import refused_in_one_line


def test_examples_of_the_docstrings_hold():
    for module in (frequencies, schema):
        tested = doctest.testmod(module)
        assert (tested.failed, tested.attempted > 0) == (0, True)


def test_calls_are_silent_and_say_how_far_they_are(capfd):
    swing = Scenario.builtin("paper").replace(end_time=0.05, discretization__frame="mean-axis")
    assert simulate(swing).events == []
    assert scenario_schema()["properties"]
    told: list[Progress] = []
    refine(swing, elements=[4, 8, 16], quantities=["theta@end"], workers=1, on_progress=told.append)
    assert [(p.done, p.total) for p in told] == [(n, told[0].total) for n in range(len(told))]
    assert told[-1].done == told[-1].total >= 3
    told.clear()
    chosen = ["statics.own-weight", "statics.amplification"]
    assert {r.verdict for r in validate(only=chosen, workers=1, on_progress=told.append)} == {"pass"}
    assert told[-1].done == told[-1].total
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("speeds", "count", "words"),
    [([float("nan")], None, "--speeds nan"), ([], None, "--speeds"), ([0.0], 0, "--count 0")],
)
def test_bad_arguments_are_one_line(speeds, count, words):
    with refused_in_one_line(words):
        natural_frequencies(Scenario(), speeds, count)

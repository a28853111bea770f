"""What the demo compares; `tests/terminal` starts it."""

from __future__ import annotations

from validation.comparison import compare_events, largest_difference


def test_comparison_shows_events_that_only_one_history_has(run):
    hybrid, frictionless = run("paper"), run("paper", "contact.friction=frictionless")
    pairs = compare_events(hybrid, frictionless)
    lonely = [pair for pair in pairs if pair.time_difference is None]
    assert any(pair.left is not None and pair.left.kind.value == "reversal" for pair in lonely)
    assert largest_difference(pairs) == float("inf")

"""Examples are import-safe and run; the demo leaves its table and its figure."""

from __future__ import annotations

import importlib.util
from pathlib import Path

from oblique_impact import History
from validation.comparison import compare_events, largest_difference

EXAMPLES = Path(__file__).parents[2] / "examples"


def load(name: str):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_paper_demo(tmp_path, capsys):
    load("paper_demo").main(str(tmp_path), "4")
    printed = capsys.readouterr().out
    assert "largest difference of an event time" in printed
    assert (tmp_path / "overview.png").stat().st_size > 50_000
    for name, least in (("paper.mp4", 20_000), ("strip.png", 20_000), ("paper.html", 100_000)):
        assert (tmp_path / name).stat().st_size > least
        assert name in printed.replace("\n", "")
    assert (tmp_path / "events.md").read_text().count("impact") >= 3
    modal, fem = (History.load(tmp_path / name) for name in ("modal", "fem"))
    pairs = compare_events(modal, fem)
    assert largest_difference(pairs[:8]) < 1e-8


def test_comparison_shows_events_that_only_one_history_has(run):
    hybrid, frictionless = run("paper"), run("paper", "contact.friction=frictionless")
    pairs = compare_events(hybrid, frictionless)
    lonely = [pair for pair in pairs if pair.time_difference is None]
    assert any(pair.left is not None and pair.left.kind.value == "reversal" for pair in lonely)
    assert largest_difference(pairs) == float("inf")

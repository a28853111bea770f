"""The time series as a table of numbers: CSV, a row a sample, units in the first line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from oblique_impact.history.history import History
from oblique_impact.renders.exports.scene import Scene
from oblique_impact.renders.exports.target import whole


def write(scene: Scene, target: Path, advance: Callable[[], None]) -> None:
    """Write the chosen samples; `advance` is called for each.  Numbers are read back as they were.

    Raises OSError.
    """
    history = scene.geometry.history
    table = history.time_series.iloc[scene.frames.sample]
    with whole(target) as (part,):
        table.rename(columns=lambda name: f"{name} ({_unit(history, name)})").to_csv(part, index=False)
        for _ in range(len(table)):
            advance()


def _unit(history: History, column: str) -> str:
    """Return the unit of a column of the time series."""
    return str(history[column if column in history else column.rpartition("_")[0]].attrs["units"])

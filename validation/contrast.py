"""What a comparison of two histories says: numbers, tables, text."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from validation.alignment import Deviation
from validation.comparison import EventPair, largest_difference, markdown_table

if TYPE_CHECKING:
    import pandas as pd

#: events without a partner that a text lists at most
LISTED = 10


@dataclass(frozen=True)
class VariableDifference:
    """How far one variable of two histories is apart.

    Attributes
    ----------
    name, unit : str
        Of the variable.
    scale : float
        Range of the values of both histories in the common span; what relative differences refer to.
    plain : Deviation
        At equal times.
    aligned : Deviation
        At corresponding times: each shared event at the mean of its two times, linear in between.
    hausdorff : float or None
        Distance of the two graphs, time relative to the common span, values to the scale; for variables that jump.
    """

    name: str
    unit: str
    scale: float
    plain: Deviation
    aligned: Deviation
    hausdorff: float | None

    def relative(self, value: float) -> float:
        """Return a difference over the scale; 0 where there is none."""
        return value / self.scale if value else 0.0


@dataclass(frozen=True)
class Measure:
    """One number of either history; None where a history does not have it."""

    name: str
    unit: str
    left: float | None
    right: float | None

    @property
    def difference(self) -> float | None:
        """Right minus left."""
        return None if self.left is None or self.right is None else self.right - self.left


@dataclass(frozen=True)
class Comparison:
    """Two histories side by side; differences are right minus left.

    Attributes
    ----------
    names : tuple of str
        What the two are called.
    outcomes : tuple of str
        How they ended.
    span : tuple of float
        Times (s) that both cover; what lies outside is not compared.
    max_shift : float
        Events further apart (s) are not paired.
    events : tuple of EventPair
        In the order of time.
    variables : mapping
        A `VariableDifference` by name of the variable.
    measures : tuple of Measure
        Collisions and energies.
    state_disagreement : float
        Part of the common time, events aligned, in which the contact states differ.
    skipped : mapping
        Why a variable is not compared, by name.
    """

    names: tuple[str, str]
    outcomes: tuple[str, str]
    span: tuple[float, float]
    max_shift: float
    events: tuple[EventPair, ...]
    variables: Mapping[str, VariableDifference]
    measures: tuple[Measure, ...]
    state_disagreement: float
    skipped: Mapping[str, str]

    def __getitem__(self, name: str) -> VariableDifference:
        """Return the difference of one variable, e.g. ``comparison["theta"]``; raises KeyError."""
        return self.variables[name]

    @property
    def shared(self) -> tuple[EventPair, ...]:
        """Events that both have."""
        return tuple(pair for pair in self.events if pair.left and pair.right)

    @property
    def only_left(self) -> tuple[EventPair, ...]:
        """Events that only the left history has."""
        return tuple(pair for pair in self.events if not pair.right)

    @property
    def only_right(self) -> tuple[EventPair, ...]:
        """Events that only the right history has."""
        return tuple(pair for pair in self.events if not pair.left)

    @property
    def largest_shift(self) -> float:
        """Largest time difference (s) of shared events."""
        return largest_difference(list(self.shared))

    def table(self) -> str:
        """Return the differences of the variables as a table in Markdown."""
        lines = [
            "| variable | scale | rms, same time | largest | rms, aligned | largest | Hausdorff |",
            "| --- | --: | --: | --: | --: | --: | --: |",
        ]
        for v in self.variables.values():
            unit = "" if v.unit == "1" else f" {v.unit}"
            found = (v.plain.rms, v.plain.largest, v.aligned.rms, v.aligned.largest)
            cells = [f"{v.relative(value):.1e}" for value in found]
            cells.append("" if v.hausdorff is None else f"{v.hausdorff:.1e}")
            lines.append(f"| {v.name} | {v.scale:.4g}{unit} | {' | '.join(cells)} |")
        return "\n".join(lines) + "\n"

    def events_table(self) -> str:
        """Return the events side by side as a table in Markdown."""
        return markdown_table(list(self.events), *self.names)

    def measures_table(self) -> str:
        """Return collisions and energies side by side as a table in Markdown."""
        left, right = self.names
        lines = [f"| | unit | {left} | {right} | difference |", "| --- | --- | --: | --: | --: |"]
        for m in self.measures:
            values = ["-" if value is None else f"{value:.9g}" for value in (m.left, m.right)]
            difference = "" if m.difference is None else f"{m.difference:+.1e}"
            lines.append(f"| {m.name} | {m.unit} | {' | '.join(values)} | {difference} |")
        return "\n".join(lines) + "\n"

    def to_dataframe(self) -> pd.DataFrame:
        """Return a pandas table with a row per variable, in its unit; the columns say what `table` says."""
        import pandas as pd

        rows = [
            {
                "variable": v.name,
                "unit": v.unit,
                "scale": v.scale,
                **{f"plain_{key}": value for key, value in v.plain._asdict().items()},
                **{f"aligned_{key}": value for key, value in v.aligned._asdict().items()},
                "hausdorff": np.nan if v.hausdorff is None else v.hausdorff,
            }
            for v in self.variables.values()
        ]
        return pd.DataFrame(rows).set_index("variable") if rows else pd.DataFrame()

    def __str__(self) -> str:
        return "\n".join(_story(self))


def _story(c: Comparison) -> list[str]:
    """Sentences and tables about a comparison."""
    left, right = c.names
    lines = [f"{left} and {right}, {c.span[0]:g} to {c.span[1]:g} s"]
    lines.append(
        f"outcome: {c.outcomes[0]}" if len(set(c.outcomes)) == 1 else f"outcomes: {', '.join(c.outcomes)}"
    )
    lines.append(
        f"events: {len(c.shared)} shared, {len(c.only_left)} only in {left}, {len(c.only_right)} only in {right}; "
        f"largest time difference {c.largest_shift:.2g} s"
    )
    alone = (*c.only_left, *c.only_right)
    for pair in alone[:LISTED]:
        event = pair.left or pair.right
        assert event is not None
        where = left if pair.left else right
        lines.append(f"  only in {where}: {event.kind.value} -> {event.state.name.lower()} at {event.time:.6f} s")
    if len(alone) > LISTED:
        lines.append(f"  and {len(alone) - LISTED} more: see events_table()")
    lines.append(f"contact states differ in {100.0 * c.state_disagreement:.2g} % of the time")
    lines += ["", "Differences relative to the scale of each variable:", "", c.table().rstrip()]
    if c.measures:
        lines += ["", c.measures_table().rstrip()]
    return lines

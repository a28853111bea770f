"""A question, what answers it, and the runs of the program that its command shows."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from oblique_impact import History, Scenario, simulate


@dataclass(frozen=True)
class Row:
    """Numbers of one case: of each quantity, with its unit, what the program and what the other computation has.

    ``None`` stands where there is no other computation, or the case has no such number.
    """

    case: str
    values: Mapping[str, tuple[float | None, float | None]]


@dataclass(frozen=True)
class Question:
    """One question of the page, answered by `compute`.

    Texts name no computed number but as fields of ``str.format`` over the rows, such as ``{0[loss (J)]:.3g}``, the
    program's loss of the first row: they cannot drift.
    """

    #: under which its numbers are stored
    name: str
    #: what is asked, in one line
    title: str
    #: what a good engineer answers, written down before the first run
    guess: str
    #: what is found, in one line
    answer: str
    #: whether the guess was wrong
    wrong: bool
    #: by how much (per cent) a user would be off who trusts a wrong guess: the order of the page
    cost: int
    #: what that costs, in a few words
    price: str
    #: the mechanics, three sentences
    why: str
    #: one command that shows it
    command: str
    #: heading of the cases, and what the other computation is
    cases: str
    beside: str
    compute: Callable[[], Sequence[Row]]
    #: largest relative difference of the two computations
    within: float = 1e-3


def scenario_of(command: str, *changes: str) -> Scenario:
    """Return the scenario of a command, with further keys changed."""
    words = shlex.split(command.replace("\\\n", " "))
    sets = [words[k + 1] for k, word in enumerate(words) if word == "--set"]
    return Scenario.load(words[2], [*sets, *changes])


def run(command: str, *changes: str) -> History:
    """Run the scenario of a command, with further keys changed."""
    return simulate(scenario_of(command, *changes))

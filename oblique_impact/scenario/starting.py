"""Scenarios to start from: the built-in cases, and files with every key explained."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Sequence
from itertools import takewhile
from pathlib import Path
from typing import NamedTuple

from oblique_impact.errors import InputError
from oblique_impact.files import save_text, writing_file
from oblique_impact.scenario.comments import commented
from oblique_impact.scenario.scenario import Scenario, builtin_names, builtin_text

#: starts (s) of the macro-collisions of each built-in case, as in `History.macro_collisions`
_COLLISIONS: dict[str, tuple[float, ...]] = {
    "paper": (0.317, 0.676, 0.926),
    "bouncing": (0.317, 0.644, 0.908),
    "cantilever": (0.091,),
    "damped": (0.317, 0.659, 0.853, 0.977),
    "dropped-bar": (0.001,),
    "edge": (0.377,),
    "elastic-stop": (0.317, 0.865),
    "gap": (0.059, 0.201, 0.543, 0.749, 0.942),
    "many-modes": (0.317, 0.700),
    "mid-span": (0.333, 0.608),
    "reed": (0.014,),
    "rigid-limit": (0.174, 0.345, 0.377),
    "shaken": (0.143,),
    "slap": (0.375,),
    "spin-up": (),
    "sticking": (0.551,),
    "tapered": (0.315,),
    "two-pegs": (0.381,),
}
_HOW = """\
# Numbers are in SI units; texts with a unit, such as "12 mm", are allowed too. A key behind a "#" has its
# default value: remove the # to change it."""


class BuiltinCase(NamedTuple):
    """Description of a built-in scenario."""

    name: str
    happens: str  # in a sentence or two
    end_time: float  # s
    collisions: tuple[float, ...]  # s, when the macro-collisions until then begin


def builtin_cases() -> list[BuiltinCase]:
    """Return the built-in scenarios with what happens in each, `paper` first.

    Returns
    -------
    list of BuiltinCase
        Name, what happens, duration (s), when its macro-collisions begin (s).

    Examples
    --------
    >>> builtin_cases()[0].name
    'paper'
    """
    return [
        BuiltinCase(name, _about(name), Scenario.builtin(name).end_time, _COLLISIONS[name])
        for name in builtin_names()
    ]


def start_scenario(
    file: str | os.PathLike[str], base: str | Scenario = "paper", notes: Sequence[str] = ()
) -> Scenario:
    """Write a scenario file to start from, each key below its meaning, unit and range; returns the scenario.

    Keys that `base` does not give stand behind a "#", with their default values.

    Parameters
    ----------
    file : str or path
        The file to write, TOML; it must not be there yet.
    base : str or Scenario
        The built-in case, the scenario file or the scenario that it is to be the same as.
    notes : sequence of str
        Lines for the head of the file, such as those of :func:`~oblique_impact.beam.recommended.recommended`.

    Returns
    -------
    Scenario
        The scenario of the file.

    Raises
    ------
    InputError
        In one line, if the file is there, cannot be written or is no .toml, or if `base` is no scenario.

    Examples
    --------
    >>> from oblique_impact import start_scenario
    >>> start_scenario("mine.toml", "tapered").beam.tip_mass  # doctest: +SKIP
    0.05
    """
    path = Path(file)
    if path.suffix != ".toml":
        raise InputError(f"{path}: should end in .toml")
    _require_new(path)
    scenario = base if isinstance(base, Scenario) else Scenario.load(base)
    heads = [_about(base)] if isinstance(base, str) and base in builtin_names() else []
    about = [textwrap.fill(f"# {line}", 110, subsequent_indent="#   ") for line in (*heads, *notes)]
    body = commented(Scenario, scenario.model_dump(mode="json"), set(scenario.given()))
    with writing_file(path, ""):
        _require_new(path)  # nor made by another process since
        save_text(path, "\n".join([*about, _HOW, "", body]), "")
    return Scenario.load(str(path))


def _require_new(path: Path) -> None:
    """Raise InputError if there is such a file."""
    if path.exists():
        raise InputError(f"{path}: is there already; choose another name, or remove it first")


def _about(name: str) -> str:
    """Return the comment at the head of a built-in case."""
    head = takewhile(lambda line: line.startswith("#"), builtin_text(name).splitlines())
    return " ".join(line.removeprefix("#").strip() for line in head)

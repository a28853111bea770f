"""Checks and their registry; to add a check, write a function in a module of this package, named in `_MODULES`.

    check = checks_of("statics", "Statics")

    @check("A cantilever bends under its own weight.", seconds=0.1)
    def cantilever_tip() -> Measurement:
        return Measurement("tip deflection", computed, reference, "m", tolerance, source)

A check returns one measurement, or it returns or yields several (each with a `name`, the tail of its id), or it
returns `Evidence` with pictures.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module

from oblique_impact.validation.report import Picture

#: a check that takes longer (s) is full, not quick: `--quick` and `make test` leave it out
QUICK_SECONDS = 2.0

#: tolerance, relative to what is compared, of numbers that are exact but for rounding: their errors are 1e-16 to
#: 1e-14 here and differ by a factor of ten or so between processors and libraries
ROUNDING = 1e-13

#: modules in the order of the report
_MODULES = (
    *("lagrange", "spectra", "spinning", "spin_up", "statics", "rigid_limit", "particles", "kinematics"),
    *("springs", "pegs", "beddings", "rigid_impact", "rods", "damped_stop", "balances", "discretizations"),
    *("kinetics", "orders", "absolute", "shaken_base", "steady_state", "loads", "directions"),
)


@dataclass(frozen=True)
class Measurement:
    """A computed number, its reference and the absolute tolerance (in `unit`)."""

    quantity: str
    computed: float
    reference: float
    unit: str
    tolerance: float
    source: str
    name: str = ""

    @property
    def error(self) -> float:
        """Absolute difference."""
        return abs(float(self.computed) - float(self.reference))

    @property
    def verdict(self) -> str:
        """``pass`` or ``fail``; what is not a number fails."""
        return "pass" if math.isfinite(self.error) and self.error <= self.tolerance else "fail"


def within(
    quantity: str, computed: float, reference: float, unit: str, relative: float, source: str, name: str = ""
) -> Measurement:
    """Return a measurement with a relative tolerance."""
    return Measurement(quantity, computed, reference, unit, relative * abs(reference), source, name)


@dataclass(frozen=True)
class Evidence:
    """Measurements with pictures of them."""

    measurements: Sequence[Measurement]
    pictures: Sequence[Picture] = ()


Finding = Measurement | Iterable[Measurement] | Evidence


@dataclass(frozen=True)
class CheckGroup:
    """A named group of checks."""

    id: str
    title: str


@dataclass(frozen=True)
class Check:
    """One problem with its measurements; `seconds` is about what it takes."""

    id: str
    group: CheckGroup
    problem: str
    seconds: float
    function: Callable[[], Finding] = field(repr=False)

    @property
    def mark(self) -> str:
        """``quick`` or ``full``."""
        return "quick" if self.seconds <= QUICK_SECONDS else "full"

    def evidence(self) -> Evidence:
        """Compute the measurements; an exception is a failed check with its name."""
        try:
            found = self.function()
            if isinstance(found, Evidence):
                return found
            return Evidence([found] if isinstance(found, Measurement) else list(found))
        except Exception as error:  # a check reports whatever goes wrong
            text = " ".join(f"{type(error).__name__}: {error}".split())[:160]
            return Evidence([Measurement(f"did not finish: {text}", math.nan, math.nan, "", 0.0, "")])


_CHECKS: dict[str, Check] = {}


def checks_of(group: str, title: str) -> Callable[..., Callable[[Callable[[], Finding]], Callable[[], Finding]]]:
    """Return the decorator that adds checks to a group."""
    home = CheckGroup(group, title)

    def check(problem: str, seconds: float = 0.1) -> Callable[[Callable[[], Finding]], Callable[[], Finding]]:
        def add(function: Callable[[], Finding]) -> Callable[[], Finding]:
            name = f"{group}.{function.__name__.replace('_', '-')}"
            if name in _CHECKS:
                raise ValueError(f"two checks are called {name}")
            _CHECKS[name] = Check(name, home, problem, seconds, function)
            return function

        return add

    return check


@cache
def all_checks() -> dict[str, Check]:
    """Every check by its id, in the order of the report."""
    modules = [import_module(f"oblique_impact.validation.checks.{name}").__name__ for name in _MODULES]
    # some may have been imported before, in another order
    return dict(sorted(_CHECKS.items(), key=lambda item: modules.index(item[1].function.__module__)))

"""Search of the keys with which a scenario says what was measured.

The sum of squares of (run - measured)/sigma is minimized over the logarithms of keys that cannot be negative, and
over the values of others, by the method `least_squares` of lmfit from several starts.  Without standard deviations
in the file, sigma is that of the residuals, one for all columns of a unit.

The matrix J of derivatives consists of differences of runs, whose error is no smooth function of the keys: steps
and events fall elsewhere.  With an error e of a run a quotient over the step h errs by about e/h, and by h^2/6
from curvature: the best step is about the cube root of e, far larger than that of a formula.  The event scheme
takes the cube root of its tolerance, schemes with steps of a given length 1e-2, because a contact that begins in
another step moves their answer by what a step errs.  An undamped beam bends in the key itself at that scale, as
contacts come and go; then the differences over a standard error tell, and the profile.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import qmc

from oblique_impact.errors import InputError
from oblique_impact.history.history import History
from oblique_impact.progress import OnProgress
from oblique_impact.scenario.effects import idle
from oblique_impact.scenario.messages import refused
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.schema import schema_of, unit_of_key
from oblique_impact.scenario.units import Unit
from oblique_impact.validation.studies.design import check_keys, si_value
from oblique_impact.validation.studies.fitting.measured import Array, Campaign, Experiment, Unrun
from oblique_impact.validation.studies.parallel import map_parallel
from oblique_impact.validation.studies.quantities import GapError

#: starts are spread over a factor of 10 to both sides, of keys with a sign over a tenth of their value
_FACTOR, _PART = 10.0, 0.1
#: step of logarithms where no run is differentiated
_AT_REST = 1e-3
#: residual where no run has all that was measured: the search turns back
_NONE = 1e100


@dataclass(frozen=True)
class Parameter:
    """A key that is fitted, or keys that have the same value; its coordinate u is 0 at the start."""

    keys: tuple[str, ...]
    unit: str
    start: float
    #: where further starts are taken
    spread: tuple[float, float]
    #: what the scenario, or the user, allows
    limits: tuple[float, float]
    #: whether u is a logarithm; else it is a part of half the spread
    positive: bool
    #: the number of the experiment, from 0, whose series it shifts in time; a key of all scenarios has none
    shifts: int | None = None

    @property
    def label(self) -> str:
        """Keys as one name."""
        return " = ".join(self.keys)

    @property
    def name(self) -> str:
        """Name of the coordinate in lmfit."""
        return self.keys[0].replace(".", "__").replace(":", "_")

    def value(self, u: float) -> float:
        """Value of the key at a coordinate."""
        if self.positive:
            return self.start * (math.inf if u >= 700.0 else math.exp(u))
        return self.start + 0.5 * (self.spread[1] - self.spread[0]) * u

    def coordinate(self, value: float) -> float:
        """Coordinate of a value."""
        if self.positive:
            return math.log(value / self.start) if value > 0.0 else -math.inf
        return (value - self.start) / (0.5 * (self.spread[1] - self.spread[0]))

    @property
    def bounds(self) -> tuple[float, float]:
        """Coordinates of the limits."""
        low, high = map(self.coordinate, self.limits)
        return low, high


def parameters_of(vary: Sequence[str], scenarios: Sequence[Scenario]) -> tuple[Parameter, ...]:
    """Read what --vary names, each KEY, KEY,KEY with the same value, or KEY=LOW:HIGH; raises InputError.

    A key has the same value in all scenarios in which it acts, and starts from that in the first of them.
    """
    if not vary:
        raise InputError("--vary: missing; name a key to be found, as contact.stiffness")
    parameters = tuple(_parameter(text, scenarios) for text in vary)
    keys = [key for parameter in parameters for key in parameter.keys]
    for key in keys:
        if keys.count(key) > 1:
            raise InputError(f"--vary {key}: is given twice")
    return parameters


def shifts_of(text: str, experiments: Sequence[Experiment]) -> tuple[Parameter, ...]:
    """Read the range LOW:HIGH (s) of --shift, of a time by which each experiment's series are late in its run."""
    ends = text.split(":")
    try:
        low, high = (Unit("s").to_si(end) if end.strip()[-1:].isalpha() else float(end) for end in ends)
    except ValueError:
        low = high = math.nan
    if not low < high:
        raise InputError(f"--shift {text}: should be LOW:HIGH in s, LOW less than HIGH")
    found = list[Parameter]()
    for number, one in enumerate(experiments):
        times = one.measured.table["time"].dropna()
        if times.empty:
            continue
        least, most = -float(times.min()), one.scenario.end_time - float(times.max())
        if low < least or high > most:
            words = f"the run of {one.name} has its series from {least:g} to {most:g} s"
            raise InputError(f"--shift {text}: should be within what a run holds: {words}")
        name = "shift" if len(experiments) == 1 else f"shift:{number + 1}"
        start = 0.0 if low < 0.0 < high else 0.5 * (low + high)
        found.append(Parameter((name,), "s", start, (low, high), (low, high), False, number))
    if not found:
        raise InputError(f"--shift {text}: there is no series")
    return tuple(found)


def acts_in(scenario: Scenario, key: str) -> bool:
    """Return whether a scenario has a key, which acts there."""
    try:
        scenario.value_of(key)
    except (AttributeError, IndexError):
        return False
    return not idle(scenario, key)


def _parameter(text: str, scenarios: Sequence[Scenario]) -> Parameter:
    names, ranged, ends = text.partition("=")
    keys = tuple(name.strip() for name in names.split(","))
    check_keys(keys, "--vary")
    scenario = next((one for one in scenarios if acts_in(one, keys[0])), scenarios[0])
    for name in keys:
        if not any(acts_in(one, name) for one in scenarios) and (words := idle(scenario, name)):
            raise refused(f"--vary {name}", scenario.value_of(name), words)
    key, value = keys[0], scenario.value_of(keys[0])
    if not isinstance(value, float):
        raise refused("--vary", key, "should be a key that is one number, not a whole one")
    schema = schema_of(key) or {}
    numeric = next((one for one in schema.get("anyOf", [schema]) if one.get("type") == "number"), schema)
    low = numeric.get("minimum", numeric.get("exclusiveMinimum", -math.inf))
    high = numeric.get("maximum", numeric.get("exclusiveMaximum", math.inf))
    positive = low >= 0.0
    if ranged:
        if ends.count(":") != 1:
            raise InputError(f"--vary {text}: should be KEY=LOW:HIGH")
        low, high = (_number(key, end) for end in ends.split(":"))
        if not (low < high and (low > 0.0 or not positive)):
            above = ", both above 0" if positive else ""
            raise InputError(f"--vary {text}: should be KEY=LOW:HIGH, LOW less than HIGH{above}")
        spread, middle = (low, high), math.sqrt(low * high) if positive else 0.5 * (low + high)
        value = value if low < value < high else middle
    elif value == 0.0:
        why = "is fitted by its logarithm" if positive else "has no scale"
        raise InputError(f"--vary {key}: is 0 in the scenario and {why}; give a range, as --vary {key}=LOW:HIGH")
    elif positive:
        spread = value / _FACTOR, min(value * _FACTOR, high)
    else:
        spread = value - _PART * abs(value), value + _PART * abs(value)
    return Parameter(keys, unit_of_key(key), value, spread, (low, high), positive)


def _number(key: str, text: str) -> float:
    """Read an end of a range, with or without a unit."""
    try:
        return float(text)
    except ValueError:
        found = si_value(key, text)
    if isinstance(found, float):
        return found
    raise refused("--vary", text, "should be a number")


# --- least squares


@dataclass(frozen=True)
class Solution:
    """Coordinates (p,) of the keys, and the residuals (n,) there."""

    u: Array
    residuals: Array

    @property
    def squares(self) -> float:
        """Sum of squares; infinite where no run has all that was measured."""
        return float(self.residuals @ self.residuals) if _exists(self.residuals) else math.inf


@dataclass(frozen=True)
class FitProblem:
    """Scenarios with keys to be found, and data with their standard deviations (n,)."""

    measured: Campaign
    parameters: tuple[Parameter, ...]
    deviations: Array

    @property
    def step(self) -> float:
        """Half the distance of the two runs of a difference quotient."""
        solvers = [one.scenario.solver for one in self.measured.experiments if one.measured.needs_run]
        steps = [math.cbrt(solver.tolerance) if solver.scheme == "event" else 1e-2 for solver in solvers]
        return max(steps, default=_AT_REST)

    def scenarios(self, u: Array) -> list[Scenario]:
        """Return the scenario of each experiment at coordinates (p,); raises InputError."""
        pairs = [(p, p.value(x)) for p, x in zip(self.parameters, u.tolist(), strict=True) if p.shifts is None]
        values = [(key, value) for p, value in pairs for key in p.keys]
        bases = [one.scenario for one in self.measured.experiments]
        return [
            base.replace(**{key.replace(".", "__"): value for key, value in values if acts_in(base, key)})
            for base in bases
        ]

    def shift(self, number: int, u: Array) -> float:
        """Return the shift (s) of the series of an experiment, from 0, at coordinates (p,)."""
        return sum(p.value(x) for p, x in zip(self.parameters, u.tolist(), strict=True) if p.shifts == number)

    def runs(self, u: Array) -> list[History | Unrun]:
        """Return the runs at u; raises InputError."""
        pairs = zip(self.measured.experiments, self.scenarios(u), strict=True)
        return [one.measured.run(scenario) for one, scenario in pairs]

    def predict(self, u: Array, runs: Sequence[History | Unrun] | None = None) -> Array:
        """Return what the runs at u say of the data (n,); raises InputError and GapError."""
        found = list[Array]()
        for k, (one, run) in enumerate(zip(self.measured.experiments, runs or self.runs(u), strict=True)):
            found.append(one.measured.predict(run, self.shift(k, u)))
        return np.concatenate(found)

    def residuals(self, u: Array) -> Array:
        """Return (run - measured)/sigma at u."""
        try:
            misfit = self.predict(u) - self.measured.table["measured"].to_numpy()
        except (InputError, GapError):
            return np.full(self.deviations.size, _NONE)
        residuals: Array = misfit / self.deviations
        return residuals

    def derivative(self, u: Array, k: int, step: float) -> Array:
        """Return the derivative (n,) of the residuals by coordinate k.

        One-sided where no run on one side has all that was measured, and 0 where none on either has.
        """
        known = list[tuple[float, Array]]()
        for side in (step, -step, 0.0):
            if len(known) < 2 and _exists(found := self.residuals(u + side * np.eye(len(u))[k])):
                known.append((side, found))
        if len(known) < 2:
            return np.zeros(self.deviations.size)
        (a, left), (b, right) = known
        return (right - left) / (b - a)

    def minimizer(self, u: Array, free: Sequence[int], value: float = 0.0) -> Any:
        """Return the `lmfit.Minimizer` over the coordinates `free`, whose parameters have this value at u (p,)."""
        from lmfit import Minimizer, Parameters

        params = Parameters()
        for k, (p, x) in enumerate(zip(self.parameters, u.tolist(), strict=True)):
            low, high = p.bounds
            params.add(p.name, value, k in free, value + low - x, value + high - x)

        def at(some: Mapping[str, Any]) -> Array:
            moved: Array = u + np.array([some[p.name].value - value for p in self.parameters])
            return moved

        def derivatives(some: Mapping[str, Any]) -> Array:
            varied = [k for k, p in enumerate(self.parameters) if some[p.name].vary]
            columns = [self.derivative(at(some), k, self.step) for k in varied]
            return np.stack(columns or [np.zeros(self.deviations.size)], axis=1)  # another variable moves nothing

        return Minimizer(
            lambda some: self.residuals(at(some)),
            params,
            scale_covar=False,
            Dfun=derivatives,
            ftol=1e-5,  # of the sum of squares: less than the noise moves it by
            xtol=1e-9,
            gtol=1e-9,
        )

    def fit(self, u: Array, free: Sequence[int]) -> tuple[Solution, Any]:
        """Minimize the sum of squares over the coordinates `free` from u (p,); return lmfit's result too."""
        with np.errstate(invalid="ignore"):  # a variance of keys that are not identified may come out below 0
            found = self.minimizer(u, free).least_squares()
        moved = np.array([found.params[p.name].value for p in self.parameters])
        return Solution(u + moved, found.residual), found

    def minimize(self, u: Array) -> Solution:
        """Minimize the sum of squares from u (p,)."""
        return self.fit(u, range(u.size))[0]


def _exists(residuals: Array) -> bool:
    """Whether there is a run with all that was measured."""
    return bool(np.abs(residuals).max() < math.sqrt(_NONE))  # whatever they are scaled by


class SearchResult(NamedTuple):
    """What a search found: the problem with its final deviations, and where each start began and ended."""

    problem: FitProblem
    points: list[Array]
    solutions: list[Solution]
    best: int


def find_keys(problem: FitProblem, starts: int, workers: int | None, on_progress: OnProgress) -> SearchResult:
    """Minimize from several starts; raises InputError if none has a run with all that was measured.

    Without deviations in the file the best start goes on until these and its keys agree; the sums of squares of
    the others are those over the same deviations, where they ended with the first ones.
    """
    points = _starting_points(problem.parameters, starts)
    names = [f"start {number}" for number in range(1, starts + 1)]
    found = map_parallel(problem.minimize, points, workers, on_progress, names)
    best = min(range(starts), key=lambda number: found[number].squares)
    solution = found[best]
    if math.isinf(solution.squares):
        try:
            problem.predict(points[0])
        except (InputError, GapError) as reason:
            words = "no start has a run with all that was measured; the first has not"
            raise InputError(f"{words}: {reason}") from None
    if not problem.measured.has_deviations:
        first = problem.deviations
        for _ in range(8):  # the weights of several units settle within a few rounds
            before = problem.deviations
            deviations = problem.measured.deviations_from(solution.residuals * before, len(points[0]))
            problem = replace(problem, deviations=deviations)
            if np.ptp(deviations / before) < 0.01 * np.min(deviations / before):
                break
            solution = problem.minimize(solution.u)
        found = [Solution(one.u, one.residuals * first / problem.deviations) for one in found]
    return SearchResult(problem, points, found, best)


def _starting_points(parameters: Sequence[Parameter], starts: int) -> list[Array]:
    """Return the coordinates (p,) of the starts: 0, and a Latin hypercube over the spread, the same each time."""
    low, high = np.array([[p.coordinate(end) for end in p.spread] for p in parameters]).T
    cube = qmc.LatinHypercube(len(parameters), seed=np.random.default_rng(0)).random(starts - 1)
    return [np.zeros(len(parameters)), *(low + cube * (high - low))]

"""Keys of a scenario found from measured data, by least squares.

The sum of squares of (run - measured)/sigma is minimized over the logarithms of keys that cannot be negative, and
over the values of others, from several starts.  Without standard deviations in the file, sigma is that of the
residuals, one for all columns of a unit.

Intervals (95 %) are those of the linearized problem, from the matrix J of derivatives, with the quantile t of
Student, or of Gauss where the deviations are given: t sqrt(diag (J^T J)^-1) to both sides.  Where these are
wide, or J differs by more than 10 % when its differences reach over a standard error, they are of the profile
likelihood: as far as the key can go while the others are fitted again and the sum of squares grows by no more than
t^2 (Bates and Watts, Nonlinear Regression Analysis, 1988, Sec. 6.1).

J consists of differences of runs, whose error is no smooth function of the keys: steps and events fall elsewhere.
With an error e of a run a quotient over the step h errs by about e/h, and by h^2/6 from curvature: the best step
is about the cube root of e, far larger than that of a formula.  The event scheme takes the cube root of its
tolerance, schemes with steps of a given length 1e-2, because a contact that begins in another step moves their
answer by what a step errs.  An undamped beam bends in the key itself at that scale, as contacts come and go; then
the differences over a standard error tell, and the profile.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import brentq, least_squares
from scipy.stats import chi2, norm, qmc, t

from oblique_impact.errors import InputError
from oblique_impact.files import prepare_folder, write_text
from oblique_impact.history.history import History
from oblique_impact.progress import OnProgress, silent
from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.scenario.messages import refused
from oblique_impact.scenario.scenario import Scenario, require_scenario
from oblique_impact.scenario.schema import label_of, schema_of, unit_of_key
from oblique_impact.simulation import simulate
from oblique_impact.validation.report import (
    Block,
    Cell,
    Picture,
    Report,
    Section,
    Table,
    Text,
    number_within,
    picture,
    shown_unit,
    with_unit,
)
from oblique_impact.validation.report.parameters import parameters
from oblique_impact.validation.studies.design import check_keys, si_value
from oblique_impact.validation.studies.measured import Array, Column, read_measured
from oblique_impact.validation.studies.parallel import map_parallel
from oblique_impact.validation.studies.predictability import (
    LARGE,
    PERTURBATIONS,
    SMALL,
    predictability,
    verdict_of,
)
from oblique_impact.validation.studies.quantities import GapError, decided_at

STARTS, MOST_STARTS = 4, 100
#: starts are spread over a factor of 10 to both sides, of keys with a sign over a tenth of their value
_FACTOR, _PART = 10.0, 0.1
#: of a logarithm: intervals that reach farther are profiled; so far a profile goes; a key whose change by a factor
#: of e moves no more than this part of the noise has no effect
_WIDE, _REACH, _NO_EFFECT = 0.4, math.log(1e3), 0.01
#: of a logarithm: error of an end of a profile; growths over t beyond this are taken for it, without a run too
_CLOSE, _FAR = 1e-3, 10.0
#: chi-squared less probable than this contradicts the model
_IMPROBABLE = 0.01
#: series that the report draws at most
_DRAWN = 8


@dataclass(frozen=True)
class Parameter:
    """What is fitted: a key, or keys that have the same value; its coordinate u is 0 at the start."""

    keys: tuple[str, ...]
    unit: str
    start: float
    #: where further starts are taken
    spread: tuple[float, float]
    #: what the scenario, or the user, allows
    limits: tuple[float, float]
    #: whether u is a logarithm; else it is a part of half the spread
    positive: bool

    @property
    def label(self) -> str:
        """Keys as one name."""
        return " = ".join(self.keys)

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

    def bounds(self) -> tuple[float, float]:
        """Coordinates of the limits."""
        low, high = map(self.coordinate, self.limits)
        return low, high


def parameter(text: str, scenario: Scenario) -> Parameter:
    """Read KEY, KEY,KEY with the same value, or KEY=LOW:HIGH; raises InputError."""
    names, ranged, ends = text.partition("=")
    keys = tuple(name.strip() for name in names.split(","))
    check_keys(keys, "--vary")
    key, value = keys[0], scenario.value_of(keys[0])
    if isinstance(value, bool) or not isinstance(value, float):
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
            raise InputError(
                f"--vary {text}: should be KEY=LOW:HIGH, LOW less than HIGH{', both above 0' * positive}"
            )
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
    """Read an end of a range, with or without a unit; raises InputError."""
    try:
        return float(text)
    except ValueError:
        found = si_value(key, text)
    if isinstance(found, float):
        return found
    raise refused("--vary", text, "should be a number")


@dataclass(frozen=True)
class Problem:
    """A scenario with keys to be found, and data with their standard deviations (n,)."""

    base: Scenario
    parameters: tuple[Parameter, ...]
    columns: tuple[Column, ...]
    deviations: Array

    @property
    def measured(self) -> Array:
        """All measured values (n,)."""
        return np.concatenate([column.values for column in self.columns])

    @property
    def step(self) -> float:
        """Half the distance of the two runs of a difference quotient."""
        solver = self.base.solver
        return math.cbrt(solver.tolerance) if solver.scheme == "event" else 1e-2

    def scenario(self, u: Array) -> Scenario:
        """Return the scenario at coordinates (p,); raises InputError."""
        pairs = zip(self.parameters, u.tolist(), strict=True)
        return self.base.replace(**{key.replace(".", "__"): p.value(x) for p, x in pairs for key in p.keys})

    def predict(self, history: History) -> Array:
        """Return what a run says of the data (n,); raises GapError."""
        return np.concatenate([column.predict(history, column.times) for column in self.columns])

    def residuals(self, u: Array) -> Array:
        """Return (run - measured)/sigma (n,), NaN where there is no such run or it lacks a quantity."""
        try:
            return (self.predict(simulate(self.scenario(u))) - self.measured) / self.deviations
        except (InputError, GapError):
            return np.full(self.deviations.size, math.nan)

    def jacobian(self, u: Array, free: Sequence[int], step: float, here: Array | None = None) -> Array:
        """Return the derivatives (n, free) of the residuals: central, or one-sided from those at u, `here`.

        One-sided too where a run on one side lacks a quantity, and 0 where both do.
        """
        columns = []
        for k in free:
            ends = {} if here is None else {0.0: here}
            for side in (step, -step, 0.0):
                if len(ends) < 2 and side not in ends:
                    found = self.residuals(u + side * np.eye(len(u))[k])
                    if np.isfinite(found).all():
                        ends[side] = found
            (a, left), (b, right) = ends.items() if len(ends) == 2 else ((0.0, u[:1]), (1.0, u[:1]))
            columns.append((right - left) / (b - a) * np.ones(self.deviations.size))
        return np.stack(columns, axis=1)

    def minimize(self, u: Array, free: Sequence[int]) -> Solution:
        """Minimize the sum of squares over the coordinates `free` from u (p,)."""
        free, u = list(free), u.copy()
        bounds = np.array([self.parameters[k].bounds() for k in free]).reshape(-1, 2).T
        u[free] = np.clip(u[free], *bounds)
        known: dict[bytes, Array] = {}  # the residuals where derivatives are asked for next

        def residuals(part: Array) -> Array:
            known.clear()
            u[free] = part
            return known.setdefault(part.tobytes(), self.residuals(u))

        def derivatives(part: Array) -> Array:
            here = known.get(part.tobytes())
            u[free] = part
            return self.jacobian(u, free, self.step, self.residuals(u) if here is None else here)

        first = residuals(u[free])
        if not np.isfinite(first).all():
            return Solution(u, math.inf)
        if not free:
            return Solution(u, float(first @ first))
        # 1e-5 of the sum of squares is less than the noise moves it by
        how: dict[str, Any] = {"ftol": 1e-5, "xtol": 1e-9, "gtol": 1e-9, "max_nfev": 40}
        found = least_squares(residuals, u[free], derivatives, tuple(bounds), **how)
        u[free] = found.x
        return Solution(u, 2.0 * float(found.cost))


class Solution(NamedTuple):
    """Coordinates (p,) and their sum of squares; infinite where there is no run with all quantities."""

    u: Array
    squares: float


@dataclass(frozen=True, repr=False)
class FitResult:
    """Keys that fit measured data.

    Attributes
    ----------
    scenario : Scenario
        The fitted one.
    keys : pandas.DataFrame
        A row for each: `key`, `unit`, `start`, `value`, `low` and `high` of the 95 % interval (infinite or 0 where
        it is open, NaN of a key without effect), `interval`, which is "Jacobian", "profile" or "no effect".
    data : pandas.DataFrame
        A row for each value: `column`, `unit`, `time` (s), `measured`, `deviation`, `fitted`, `residual` (over the
        deviation).
    correlation : pandas.DataFrame
        Of the keys with an effect (of their logarithms, where positive).
    starts : pandas.DataFrame
        A row for each start: where it began, where it ended, and the sum of squares there.
    squares, freedom : float, int
        Sum of squares over the deviations, and degrees of freedom.
    warnings : tuple of str
        What stands against the result, and warnings of the fitted run.
    seconds : float
        Wall time (s).
    """

    scenario: Scenario
    keys: pd.DataFrame
    data: pd.DataFrame
    correlation: pd.DataFrame
    starts: pd.DataFrame
    squares: float
    freedom: int
    warnings: tuple[str, ...]
    seconds: float

    def __repr__(self) -> str:
        """Return a line for each key."""
        return "\n".join(["<FitResult>", *(f"  {line}" for line in lines(self)[: len(self.keys) + 1])])

    def _repr_html_(self) -> str:
        """Show the head of the report in a notebook."""
        return report(self)._repr_html_()

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each key: `keys`."""
        return self.keys

    def value(self, key: str) -> float:
        """Fitted value of a key."""
        return float(self.scenario.value_of(key))

    def interval(self, key: str) -> tuple[float, float]:
        """Its 95 % interval."""
        row = self.keys.set_index("key").loc[key]
        return float(row["low"]), float(row["high"])


def fit(
    scenario: Scenario,
    data: str | os.PathLike[str],
    *,
    vary: Sequence[str],
    starts: int = STARTS,
    out: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    name: str = "scenario",
    on_progress: OnProgress = silent,
) -> FitResult:
    """Find the keys of a scenario with which it says what was measured.

    Parameters
    ----------
    scenario : Scenario
        Holds all that is known, and a first guess of the rest.
    data : path
        A file as of :mod:`~oblique_impact.validation.studies.measured`.
    vary : sequence of str
        Keys "section.key"; "key,key" have the same value, "key=low:high" stays in a range.
    starts : int
        Starts of the search, the first from the scenario.
    out : path, optional
        Folder for report.html, results.json, results.csv with the residuals, and scenario.toml, the fitted one.
    workers : int, optional
        Parallel processes; default: the cores.
    name : str
        What the scenario is called in the report.
    on_progress : callable
        Called after each start, and after each end of a profile.

    Raises
    ------
    InputError
        In one line for a faulty file or key, for too few values, or if no start has all that was measured.
    """
    started, base = time.perf_counter(), require_scenario(scenario, "fit")
    parameters = tuple(parameter(text, base) for text in vary)
    every, count = [key for one in parameters for key in one.keys], len(parameters)
    for key in every:
        if every.count(key) > 1:
            raise InputError(f"--vary {key}: is given twice")
    if not every:
        raise InputError("--vary: missing; name a key to be found, as contact.stiffness")
    if not 1 <= starts <= MOST_STARTS:
        raise InputError(f"--starts {starts}: should be from 1 to {MOST_STARTS}")
    columns = tuple(read_measured(data, base))
    times, deviations = (np.concatenate([getattr(c, name) for c in columns]) for name in ("times", "deviations"))
    known = bool(np.isfinite(deviations[0]))
    if deviations.size < count + (not known):
        raise InputError(
            f"{data}: {deviations.size} values for {count} keys: at least {count + (not known)} are needed"
        )
    if not known:
        deviations = _first_deviations(columns, os.fspath(data))
    if out is not None:
        prepare_folder(out)
    if np.isfinite(times).all():  # of a series the rest of the run is not needed
        base = base.replace(end_time=float(times.max()))
    problem = Problem(base, parameters, columns, deviations)
    points = _points(parameters, starts)
    names = [f"start {number}" for number in range(1, starts + 1)]
    found = map_parallel(_search, [(problem, u) for u in points], workers, on_progress, names)
    best = min(found, key=lambda solution: solution.squares)
    if math.isinf(best.squares):
        try:
            problem.predict(simulate(problem.scenario(points[0])))
        except (InputError, GapError) as reason:
            raise InputError(
                f"no start has a run with all that was measured; the first has not: {reason}"
            ) from None
    # deviations that are found with the keys: the weights of several units settle within a few rounds
    for _ in range(0 if known else 8):
        before = problem.deviations
        problem = replace(problem, deviations=_deviations(problem, best.u))
        best = problem.minimize(best.u, range(count))
        if np.allclose(before, problem.deviations, rtol=0.01):
            break
    begun = pd.DataFrame()
    for k, p in enumerate(parameters):
        begun[f"{p.label} from"] = [p.value(u[k]) for u in points]
        begun[f"{p.label} to"] = [p.value(solution.u[k]) for solution in found]
    begun["sum of squares"] = [solution.squares for solution in found]
    result = _judge(problem, best, known, begun, workers, on_progress)
    result = replace(
        result,
        scenario=result.scenario.replace(end_time=scenario.end_time),
        warnings=(*_elsewhere(result, parameters, found, known), *result.warnings),
        seconds=time.perf_counter() - started,
    )
    if out is not None:
        report(result, name).write(Path(out), _data(result), result.data)
        write_text(Path(out) / "scenario.toml", result.scenario.to_toml())
    return result


def _points(parameters: Sequence[Parameter], starts: int) -> list[Array]:
    """Return the coordinates (p,) of the starts: 0, and a Latin hypercube over the spread, the same each time."""
    ends = np.array([[p.coordinate(end) for end in p.spread] for p in parameters])
    cube = qmc.LatinHypercube(len(parameters), seed=np.random.default_rng(0)).random(starts - 1)
    return [np.zeros(len(parameters)), *(ends[:, 0] + cube * (ends[:, 1] - ends[:, 0]))]


def _search(task: tuple[Problem, Array]) -> Solution:
    problem, u = task
    return problem.minimize(u, range(len(u)))


def _units(columns: Sequence[Column]) -> Array:
    """Return the unit of each value (n,)."""
    return np.concatenate([np.full(column.values.size, column.unit, dtype=object) for column in columns])


def _first_deviations(columns: Sequence[Column], file: str) -> Array:
    """Return standard deviations (n,) to begin with, a value a unit: the scatter about the means of columns."""
    units, values = _units(columns), np.concatenate([column.values for column in columns])
    scatter = np.concatenate([column.values - column.values.mean() for column in columns])
    found = np.empty(values.size)
    for column in columns:
        same = units == column.unit
        if same.sum() < 3 and not same.all():
            raise InputError(
                f"{file}: column {column.name} +-: missing; without it at least 3 values of a unit are needed"
            )
        found[same] = max(float(np.std(scatter[same])), 1e-2 * float(np.abs(values[same]).max())) or 1.0
    return found


def _deviations(problem: Problem, u: Array) -> Array:
    """Return standard deviations (n,), a value a unit, from the residuals at u."""
    units, off = _units(problem.columns), problem.residuals(u) * problem.deviations
    spent, least = len(u) / off.size, 1e-9 * np.abs(problem.measured)
    found = np.empty(off.size)
    for unit in dict.fromkeys(units):
        same = units == unit
        # of data without noise the error of the run is left
        found[same] = max(
            math.sqrt(float(np.mean(off[same] ** 2)) / (1.0 - spent)), float(least[same].max()), 1e-300
        )
    return found


# --- how well the keys are known


class _End(NamedTuple):
    """An end of a profile: a key, the side, and t."""

    problem: Problem
    best: Solution
    key: int
    side: float
    #: how the others go along with the key at first, (p,), and where the linearized problem ends
    direction: Array
    reach: float
    quantile: float


def _profile_end(task: _End) -> float:
    """Return the coordinate where the least sum of squares has grown by t^2; infinite if that is beyond reach."""
    problem, best, key, side, direction, reach, quantile = task
    others = [k for k in range(len(direction)) if direction[k] != 0.0 and k != key]
    limit = problem.parameters[key].bounds()[int(side > 0.0)]
    far = min(_REACH + abs(best.u[key]), side * (limit - best.u[key]))
    at = {0.0: best.u}  # the others where they have been fitted again within the interval

    @cache
    def beyond(distance: float) -> float:
        """Return the root of the growth over t, less 1."""
        near = max(where for where in at if where <= distance)
        found = problem.minimize(at[near] + side * (distance - near) * direction, others)
        growth = math.sqrt(max(found.squares - best.squares, 0.0)) / quantile
        if growth < 1.0:
            at[distance] = found.u
        return min(growth, _FAR) - 1.0

    near, distance = 0.0, min(reach, far)
    while beyond(distance) < 0.0:
        if distance >= far:
            return side * math.inf
        near, distance = distance, min(far, distance * min(4.0, 1.05 / max(beyond(distance) + 1.0, 0.25)))
    return float(best.u[key] + side * brentq(beyond, near, distance, xtol=_CLOSE))


def _judge(
    problem: Problem,
    best: Solution,
    known: bool,
    starts: pd.DataFrame,
    workers: int | None,
    on_progress: OnProgress,
) -> FitResult:
    """Find intervals and correlations at the least sum of squares, and what stands against them."""
    u, free, count = best.u, list[int](), len(best.u)
    J = problem.jacobian(u, range(count), problem.step)
    sizes = np.linalg.norm(J, axis=0)
    for k in range(count):
        moved = u.copy()
        moved[k] = 0.0
        # not of one that went so far down that it has none any more
        if sizes[k] < _NO_EFFECT and np.sum(problem.residuals(moved) ** 2) < best.squares + _NO_EFFECT:
            u = moved
        else:
            free.append(k)
    best = Solution(u, float(np.sum(problem.residuals(u) ** 2)))
    freedom = problem.deviations.size - (len(free) if known else count)
    quantile = float(norm.ppf(0.975) if known else t.ppf(0.975, freedom))
    _, s, Vt = np.linalg.svd(J[:, free], full_matrices=False)
    inverse = Vt.T / np.maximum(s, 1e-12 * s.max(initial=1.0)) ** 2
    covariance = inverse @ Vt
    errors = np.sqrt(np.diag(covariance))
    names = [problem.parameters[k].label for k in free]
    correlation = pd.DataFrame(covariance / np.outer(errors, errors), names, names)
    rough = {}
    for k, error in zip(free, errors.tolist(), strict=True):
        (wider,) = problem.jacobian(u, [k], min(max(error, 2.0 * problem.step), _WIDE)).T
        rough[k] = float(np.linalg.norm(wider - J[:, k]) / sizes[k])
    ends, tasks = {}, []
    for k, error, along in zip(free, errors, covariance / np.diag(covariance), strict=True):
        reach, direction = quantile * float(error), np.zeros(count)
        direction[free] = along
        low, high = problem.parameters[k].bounds()
        if reach > _WIDE or rough[k] > 0.1 or not low < u[k] - reach < u[k] + reach < high:
            tasks += [_End(problem, best, k, side, direction, reach, quantile) for side in (-1.0, 1.0)]
        else:
            ends[k] = u[k] - reach, u[k] + reach
    profiled = map_parallel(
        _profile_end, tasks, workers, on_progress, [problem.parameters[e.key].label for e in tasks]
    )
    for task, low, high in zip(tasks[::2], profiled[::2], profiled[1::2], strict=True):
        ends[task.key] = low, high
    rows, warnings = [], []
    for k, p in enumerate(problem.parameters):
        low, high = (p.value(end) for end in ends.get(k, (math.nan, math.nan)))
        kind = "no effect" if k not in free else "profile" if k in {task.key for task in tasks} else "Jacobian"
        rows += [(key, p.unit, p.start, p.value(u[k]), low, high, kind) for key in p.keys]
        if k not in free:
            warnings.append(f"{p.label}: has no effect on these data; it is left at {p.start:g}")
            continue
        without = [word for word, end in zip(("lower", "upper"), ends[k], strict=True) if math.isinf(end)]
        partner = correlation[p.label].drop(p.label).abs()
        if len(without) == 2:
            with_it = f"; they determine it together with {partner.idxmax()} only" if partner.max() > 0.95 else ""
            warnings.append(f"{p.label}: not identified by these data{with_it}")
        elif without:
            warnings.append(f"{p.label}: these data set it no {without[0]} end")
        elif rough[k] > 0.1:
            words = f"derivatives over a standard error differ by {100.0 * rough[k]:.0f} % from those at the value"
            warnings.append(f"{p.label}: {words}; its interval is a profile")
    if known and freedom and chi2.sf(best.squares, freedom) < _IMPROBABLE:
        words = f"sum of squares {best.squares:.3g} on {freedom} degrees of freedom"
        warnings.append(f"{words}: the model does not say what was measured within the standard deviations")
    failed = int(np.isinf(starts["sum of squares"]).sum())
    if failed:
        warnings.append(f"{failed} of {len(starts)} starts have no run with all that was measured")
    scenario = problem.scenario(u)
    history = simulate(scenario)
    warnings += _unpredictable(problem, history, workers)
    warnings += [f"warning of the run: {warning}" for warning in history.summary.get("warnings", ())]
    columns = problem.columns
    table = pd.DataFrame(
        {
            "column": np.concatenate([np.full(c.values.size, c.name, dtype=object) for c in columns]),
            "unit": _units(columns),
            "time": np.concatenate([c.times for c in columns]),
            "measured": problem.measured,
            "deviation": problem.deviations,
            "fitted": problem.predict(history),
        }
    )
    table["residual"] = (table["measured"] - table["fitted"]) / table["deviation"]
    keys = pd.DataFrame(rows, columns=["key", "unit", "start", "value", "low", "high", "interval"])
    return FitResult(scenario, keys, table, correlation, starts, best.squares, freedom, tuple(warnings), 0.0)


def _elsewhere(
    result: FitResult, parameters: Sequence[Parameter], found: Sequence[Solution], known: bool
) -> list[str]:
    """Name the starts that ended outside of an interval, though their sum of squares is within its rise of 4."""
    least = min(solution.squares for solution in found)
    rise, ends = 4.0 * (1.0 if known else least / result.freedom), result.keys.set_index("key")[["low", "high"]]
    warnings = []
    for number, solution in enumerate(found, start=1):
        outside = []
        for p, u in zip(parameters, solution.u.tolist(), strict=True):
            low, high = ends.loc[p.keys[0]]
            if p.value(u) < low or p.value(u) > high:
                outside.append(p.label)
        if outside and solution.squares < least + rise:
            warnings.append(
                f"start {number} fits as well with another {', '.join(outside)}: see the table of starts"
            )
    return warnings


def _unpredictable(problem: Problem, history: History, workers: int | None) -> list[str]:
    """Name the columns that depend on the initial angle beyond measurement, by the growth of the events before."""
    scenario = history.scenario
    if not history.macro_collisions or scenario is None:
        return []
    (case,) = predictability(scenario, shadows=2, workers=workers).cases
    try:
        turned = scenario.replace(initial__angle=scenario.initial.angle + PERTURBATIONS[-1])
        moved = np.abs(problem.predict(simulate(turned)) - problem.predict(history)) / problem.deviations
    except (InputError, GapError):
        moved = np.full(problem.deviations.size, math.inf)
    found, last = [], 0
    for column in problem.columns:
        first, last = last, last + column.values.size
        series = bool(np.isfinite(column.times[0]))
        until = float(column.times.max()) if series else decided_at(column.name, history)
        before = case.events[case.events["time"] <= until]
        growth = float(before["growth"].max()) if len(before) else 0.0
        if growth > SMALL:
            since = float(before["time"][before["growth"] > (LARGE if growth >= LARGE else SMALL)].min())
            words = f"{verdict_of(growth)}{f' from {since:.6g} s on' if series else ''}"
            shift = f"{PERTURBATIONS[-1]:g} rad of the initial angle move it by {moved[first:last].max():.2g}"
            found.append(f"{column.name}: {words}: a growth of {growth:.3g}; {shift} standard deviations")
    return found


# --- report


def lines(result: FitResult) -> list[str]:
    """Return what a fit found in lines, for a terminal."""
    found = []
    for row in result.keys.itertuples():
        interval = (
            "" if row.interval == "no effect" else f"  95 %: {row.low:.5g} to {row.high:.5g} ({row.interval})"
        )
        found.append(f"{row.key:28} {row.value:.6g} {shown_unit(row.unit)}{interval}")
    found.append(f"sum of squares {result.squares:.4g} on {result.freedom} degrees of freedom")
    return found + list(result.warnings)


def _data(result: FitResult) -> dict[str, Any]:
    kept = ("keys", "data", "starts", "squares", "freedom", "warnings", "scenario")
    return {
        **{name: getattr(result, name) for name in kept},
        "correlation": result.correlation.to_dict(),
        "times": {"wall_time": result.seconds},
    }


def report(result: FitResult, name: str = "scenario") -> Report:
    """Return the report: keys with their intervals, data and fit, residuals, correlations, starts."""
    kinds = {"Jacobian": "pass", "profile": "partly", "no effect": "fail"}
    keys = []
    for row in result.keys.itertuples():
        values = [
            Cell(number_within(v, 0.5 * (row.high - row.low)), "number") for v in (row.value, row.low, row.high)
        ]
        names = [label_of(row.key), Cell(row.key, "code"), shown_unit(row.unit), row.start]
        keys.append([*names, *values, Cell(row.interval, kinds[row.interval])])
    columns = ["parameter", "key", "unit", "start", "value", "from", "to", "interval by"]
    names = list(dict.fromkeys(result.data["column"]))
    series = [n for n in names if result.data.loc[result.data["column"] == n, "time"].notna().all()]
    pictures: list[Block] = [_series_picture(result.data[result.data["column"] == n]) for n in series[:_DRAWN]]
    once = result.data[~result.data["column"].isin(series)]
    if len(once):
        shown = once.head(200)[["column", "unit", "measured", "deviation", "fitted", "residual"]]
        pictures += [_residual_picture(once), Table.of_frame(shown, "Values of the whole run.", digits=4)]
    correlation = result.correlation.rename_axis("key").reset_index()
    return Report(
        "Fit of a scenario to measured data",
        f"Keys of {Path(name).name}, found from {len(result.data)} measured values by least squares.",
        result.seconds,
        facts=[("sum of squares", f"{result.squares:.4g} on {result.freedom} degrees of freedom")],
        overview=[
            Table(
                columns, keys, "Values with their 95 % intervals; an end that is infinite, or 0, is open.", (0,)
            ),
            *(Text(f"{warning}.") for warning in result.warnings),
        ],
        sections=[
            Section("Data and fit", pictures),
            Section(
                "Correlation",
                [
                    Table.of_frame(
                        correlation, "Of logarithms where keys are positive.", 3, columns=_as_they_are(correlation)
                    )
                ],
            ),
            *parameters({Path(name).name: result.scenario}, "The fitted scenario."),
            Section(
                "Starts",
                [
                    Table.of_frame(
                        result.starts, "Of keys, from where to where.", columns=_as_they_are(result.starts)
                    )
                ],
            ),
            Section(
                "How it is found", [Text(" ".join(part.split())) for part in (__doc__ or "").split("\n\n")[1:]]
            ),
        ],
    )


def _as_they_are(frame: pd.DataFrame) -> dict[str, str]:
    """Return the headings of a table whose columns are keys."""
    return {name: name for name in frame}


def _series_picture(data: pd.DataFrame) -> Picture:
    """Draw a series, its fit, and the residuals under them."""
    name, unit = data["column"].iloc[0], data["unit"].iloc[0]
    data = data.sort_values("time")
    with picture(
        f"{name}: measured, and of the fitted run; below the residuals over their deviation.", height=3.8
    ) as drawn:
        above, below = drawn.figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
        above.plot(data["time"], data["measured"], ".", color=GREY, markersize=3, label="measured")
        above.plot(data["time"], data["fitted"], color=SERIES[0], linewidth=1.2, label="fitted")
        below.plot(data["time"], data["residual"], ".", color=GREY, markersize=3)
        above.set(ylabel=with_unit(name, unit))
        below.set(xlabel="time (s)", ylabel="residual")
        above.legend()
    return drawn


def _residual_picture(data: pd.DataFrame) -> Picture:
    """Draw the residuals of quantities of the whole run."""
    with picture("Residuals over their standard deviations; nearly all should lie within 2.", height=2.8) as drawn:
        axes = drawn.figure.subplots()
        axes.axhspan(-2.0, 2.0, color=GREY, alpha=0.15, linewidth=0.0)
        axes.plot(data["column"], data["residual"], "o", color=SERIES[0], markersize=4)
        axes.set(ylabel="residual")
    return drawn

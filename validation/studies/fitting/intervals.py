"""How well the data determine the keys: 95 % intervals, correlations, and what stands against the result.

Intervals are those of the linearized problem, from the matrix J of derivatives, with the quantile t of Student, or
of Gauss where the deviations are given: t sqrt(diag (J^T J)^-1) to both sides.  Where these are wide, or J differs
by more than 10 % when its differences reach over a standard error, they are of the profile likelihood, by the
`conf_interval` of lmfit: as far as the key can go while the others are fitted again and the sum of squares grows
by no more than t^2 (Bates and Watts, Nonlinear Regression Analysis, 1988, Sec. 6.1).
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.stats import chi2, t

from oblique_impact.errors import InputError
from oblique_impact.history.history import History
from oblique_impact.progress import OnProgress
from oblique_impact.simulation import compute_history as simulate
from oblique_impact.validation.studies.fitting.least_squares import FitProblem, Parameter, SearchResult, Solution
from oblique_impact.validation.studies.fitting.measured import Array, Unrun
from oblique_impact.validation.studies.parallel import map_parallel
from oblique_impact.validation.studies.predictability import (
    LARGE,
    SMALL,
    judge,
    perturbed_runs,
    verdict_of,
)
from oblique_impact.validation.studies.quantities import GapError, decided_at
from oblique_impact.validation.studies.study import run_study

#: of a logarithm: intervals that reach farther are profiled; so far a profile goes; a key whose change by a factor
#: of e moves no more than this part of the noise has no effect
_WIDE, _REACH, _NO_EFFECT = 0.4, math.log(1e3), 0.01
#: coordinate of the value in a profile: `conf_interval` goes by standard errors only if these are less than it
_ORIGIN = 10.0
#: relative change of derivatives beyond which an interval is profiled
_NONLINEAR = 0.1
#: a correlation beyond which data determine two keys together only; chi-squared less probable than this
#: contradicts the model; solutions fit as well whose sum of squares is larger by no more
_TOGETHER, _IMPROBABLE, _AS_WELL = 0.95, 0.01, 4.0


class Interval(NamedTuple):
    """Interval of a key, in its coordinate: infinite where it is open, NaN of a key without effect."""

    low: float = math.nan
    high: float = math.nan
    #: "Jacobian", "profile" or "no effect"
    kind: str = "no effect"
    #: relative change of the derivatives when their differences reach over a standard error
    nonlinearity: float = 0.0


class Estimate(NamedTuple):
    """The solution, with keys without effect back at their start, and how well it is known."""

    solution: Solution
    intervals: list[Interval]
    #: of the keys with an effect
    correlation: pd.DataFrame
    degrees_of_freedom: int
    #: as text, by lmfit
    report: str


def find_intervals(problem: FitProblem, best: Solution, workers: int | None, on_progress: OnProgress) -> Estimate:
    """Find intervals and correlations at the least sum of squares; raises InputError if no key has an effect."""
    every, given = range(len(best.u)), problem.measured.has_deviations
    best, found = problem.fit(best.u, every)
    best, free = _effective(problem, best, np.linalg.norm(found.jac, axis=0))
    if not free:
        raise InputError(f"--vary: {', '.join(p.label for p in problem.parameters)}: no effect on these data")
    if len(free) < len(every):
        best, found = problem.fit(best.u, free)
    freedom = best.residuals.size - (len(free) if given else len(every))
    quantile = float(t.ppf(0.975, math.inf if given else freedom))
    # lmfit inverts J^T J, which fails for keys that only a product of theirs determines
    _, s, Vt = np.linalg.svd(found.jac, full_matrices=False)
    covariance = Vt.T / np.maximum(s, 1e-12 * s.max(initial=1.0)) ** 2 @ Vt
    errors, labels = np.sqrt(np.diag(covariance)), [problem.parameters[k].label for k in free]
    correlation = pd.DataFrame(covariance / np.outer(errors, errors), labels, labels)
    intervals, wide = [Interval()] * len(every), dict[int, Array]()
    for k, error, row, along in zip(free, errors.tolist(), covariance, found.jac.T, strict=True):
        wider = problem.derivative(best.u, k, min(max(error, 2.0 * problem.step), _WIDE))
        change, size = np.linalg.norm(wider - along), np.linalg.norm(along)
        nonlinearity = float(change) / max(float(size), _NO_EFFECT)
        reach, (lowest, highest) = quantile * error, problem.parameters[k].bounds
        low, high = best.u[k] - reach, best.u[k] + reach
        if reach > _WIDE or nonlinearity > _NONLINEAR or not lowest < low < high < highest:
            intervals[k] = Interval(kind="profile", nonlinearity=nonlinearity)
            wide[k] = row
        else:
            intervals[k] = Interval(low, high, "Jacobian", nonlinearity)
    profile = partial(_profile, problem, best, free, quantile)
    names = [problem.parameters[k].label for k in wide]
    ends = map_parallel(profile, [*wide.items()], workers, on_progress, names)
    for k, (low, high) in zip(wide, ends, strict=True):
        intervals[k] = intervals[k]._replace(low=low, high=high)
    return Estimate(best, intervals, correlation, freedom, _report(problem, best, found))


def _effective(problem: FitProblem, best: Solution, effects: Array) -> tuple[Solution, list[int]]:
    """Return the solution with keys without effect back at their start, and the numbers of the others."""
    least, free = best.squares, list[int]()
    for k, effect in enumerate(effects):
        if effect < _NO_EFFECT:
            back = np.where(np.arange(effects.size) == k, 0.0, best.u)
            there = Solution(back, problem.residuals(back))
            # not of one that went so far down that it has none any more
            if there.squares < least + _NO_EFFECT:
                best = there
                continue
        free.append(k)
    return best, free


def _profile(
    problem: FitProblem, best: Solution, free: list[int], quantile: float, task: tuple[int, Array]
) -> tuple[float, float]:
    """Return the coordinates where the least sum of squares has grown by t^2, infinite where it does not.

    `free` are the keys with an effect; the task is one of them and its row of their covariance.
    """
    from lmfit import conf_interval
    from lmfit.minimizer import MinimizerResult

    key, row = task
    variance = row[free.index(key)]
    minimizer = problem.minimizer(best.u, free, _ORIGIN)
    params = [minimizer.params[problem.parameters[k].name] for k in free]
    param, far = params[free.index(key)], _REACH + abs(best.u[key])
    param.set(min=max(param.min, _ORIGIN - far), max=min(param.max, _ORIGIN + far))
    param.stderr = min(max(math.sqrt(variance), 0.01 * far), 1.0)  # its steps, of which it makes at most 200
    if len(free) == 1:
        minimizer.params.add("nothing", 0.0)  # it refuses a single variable

    def refit() -> Any:
        """Minimize from where the others go along at first, by a method that can leave bounds."""
        moved = minimizer.params[param.name].value - _ORIGIN
        for one, covariance in zip(params, row, strict=True):
            minimizer.params[one.name].value = _ORIGIN + moved * covariance / variance
        return minimizer.least_squares()

    def growth(moved: Any) -> float:
        """Root of the growth of the sum of squares, over t."""
        return math.sqrt(max(moved.chisqr - best.squares, 0.0)) / quantile

    def probability(_: Any, moved: Any) -> float:
        """Return 0.95 where the root of the growth is t, and less or more where it is."""
        return min(0.95 * growth(moved), 1.0)

    def is_open(end: float) -> bool:
        """Whether the data allow an end of the way to search: it need not be walked in steps."""
        param.set(value=end, vary=False)
        allowed = growth(refit()) < 1.0
        param.set(value=_ORIGIN, vary=True)
        return allowed

    minimizer.leastsq = refit
    nearest = _ORIGIN - param.stderr, _ORIGIN + param.stderr
    if is_open(param.min):
        param.set(min=nearest[0])
    if is_open(param.max):
        param.set(max=nearest[1])
    start = MinimizerResult(params=minimizer.params, chisqr=best.squares)
    with warnings.catch_warnings(), np.errstate(invalid="ignore"):
        warnings.simplefilter("ignore", UserWarning)  # of a bound that is reached: that end is infinite
        ends = conf_interval(minimizer, start, [param.name], [0.95], prob_func=probability, min_rel_change=-1.0)
    (_, low), _, (_, high) = ends[param.name]
    return best.u[key] + low - _ORIGIN, best.u[key] + high - _ORIGIN


def _report(problem: FitProblem, best: Solution, found: Any) -> str:
    """Return lmfit's report of the keys in place of their coordinates."""
    from lmfit import fit_report

    for p, u in zip(problem.parameters, best.u.tolist(), strict=True):
        param, value = found.params[p.name], p.value(u)
        param.set(value=value, min=-math.inf, max=math.inf)
        param.init_value = p.start
        if param.stderr is not None:
            param.stderr *= value if p.positive else p.value(1.0) - p.value(0.0)
    return str(fit_report(found)).replace("__", ".")


# --- what stands against it


def caveats(
    found: SearchResult, estimate: Estimate, runs: Sequence[History | Unrun], workers: int | None
) -> list[str]:
    """Return what stands against a fit, which keys stand for each other, and the warnings of the fitted runs."""
    problem, squares, freedom = found.problem, estimate.solution.squares, estimate.degrees_of_freedom
    sentences = list[str]()
    for number, solution in enumerate(found.solutions, start=1):
        values = zip(problem.parameters, solution.u, estimate.intervals, strict=True)
        outside = [p.label for p, u, interval in values if u < interval.low or u > interval.high]
        if outside and solution.squares < squares + _AS_WELL:
            words = f"fits as well with another {', '.join(outside)}: see the table of starts"
            sentences.append(f"start {number} {words}")
    for p, interval in zip(problem.parameters, estimate.intervals, strict=True):
        remark = _remark(p, interval, estimate.correlation)
        sentences += [f"{p.label}: {remark}"] if remark else []
    if problem.measured.has_deviations and freedom and chi2.sf(squares, freedom) < _IMPROBABLE:
        words = f"sum of squares {squares:.3g} on {freedom} degrees of freedom"
        sentences.append(f"{words}: the model does not say what was measured within the standard deviations")
    failed = sum(math.isinf(solution.squares) for solution in found.solutions)
    if failed:
        sentences.append(f"{failed} of {len(found.solutions)} starts have no run with all that was measured")
    sentences.append(_together(estimate.correlation))
    for number, run in enumerate(runs):
        if isinstance(run, History):
            sentences += _unpredictable(found, estimate, number, run, workers)
            sentences += [f"warning of the run: {warning}" for warning in run.summary.get("warnings", ())]
    return sentences


def _together(correlation: pd.DataFrame) -> str:
    """Return a sentence on which keys stand for each other, by their correlation."""
    names = [str(name) for name in correlation]
    pairs = [
        (float(correlation.iloc[i, j]), names[i], names[j]) for i in range(len(names)) for j in range(i)
    ]  # each once
    if not pairs:
        return "one key alone: no other can stand for it"
    pairs.sort(key=lambda pair: -abs(pair[0]))
    close = [pair for pair in pairs if abs(pair[0]) > _TOGETHER]
    if not close:
        largest, *two = pairs[0]
        return (
            f"no two keys stand for each other: the largest correlation is {largest:.3f}, of {' and '.join(two)}"
        )
    told = (
        f"{one} and {other} ({value:.4f}: {'up' if value > 0 else 'down'} together)" for value, one, other in close
    )
    words = "the data tell what they make together far better than each alone"
    return f"keys that stand for each other, by their correlation: {', '.join(told)}; {words}"


def _remark(parameter: Parameter, interval: Interval, correlation: pd.DataFrame) -> str:
    """Return what is to be said of a key: without effect, not identified, with an open end, or nonlinear."""
    if interval.kind == "no effect":
        return f"has no effect on these data; it is left at {parameter.start:g}"
    without = [name for name, end in (("lower", interval.low), ("upper", interval.high)) if math.isinf(end)]
    if len(without) == 2:
        others = correlation[parameter.label].drop(parameter.label).abs()
        together = others.max() > _TOGETHER
        partner = f"; they determine it together with {others.idxmax()} only" if together else ""
        return f"not identified by these data{partner}"
    if without:
        return f"these data set it no {without[0]} end"
    if interval.nonlinearity > _NONLINEAR:
        differ = f"derivatives over a standard error differ by {100.0 * interval.nonlinearity:.0f} %"
        return f"{differ} from those at the value; its interval is a profile"
    return ""


def _unpredictable(
    found: SearchResult, estimate: Estimate, number: int, history: History, workers: int | None
) -> list[str]:
    """Name the columns that depend on the initial angle beyond measurement, by the growth of the events before."""
    scenario, problem = history.scenario, found.problem
    if not history.macro_collisions or scenario is None:
        return []
    measured = problem.measured.experiments[number].measured
    own = (problem.measured.table["scenario"] == number + 1).to_numpy()
    deviations, shift = problem.deviations[own], problem.shift(number, estimate.solution.u)
    frame = run_study(perturbed_runs(scenario, count=2), workers=workers)
    case, turn = judge(scenario, frame), float(frame["initial.angle"].max()) - scenario.initial.angle
    try:
        turned = simulate(scenario.replace(initial__angle=scenario.initial.angle + turn))
        moved = np.abs(measured.predict(turned, shift) - measured.predict(history, shift)) / deviations
    except (InputError, GapError):
        moved = np.full(deviations.size, math.inf)
    sentences = []
    for name, rows in measured.table.groupby("column", sort=False):
        if measured.readings[str(name)].at_rest:
            continue
        last = float(rows["time"].max())
        until = decided_at(str(name), history) if math.isnan(last) else last
        before = case.events[case.events["time"] <= until]
        growth = float(before["growth"].max()) if len(before) else 0.0
        if growth > SMALL:
            since = float(before["time"][before["growth"] > (LARGE if growth >= LARGE else SMALL)].min())
            from_then = "" if math.isnan(last) else f" from {since:.6g} s on"
            turns = f"{turn:g} rad of the initial angle move it by {moved[rows.index].max():.2g}"
            words = f"{verdict_of(growth)}{from_then}: a growth of {growth:.3g}; {turns} standard deviations"
            sentences.append(f"{name}: {words}")
    return sentences

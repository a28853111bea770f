"""How well the data determine the keys: 95 % intervals, correlations, and what stands against the result.

Intervals are those of the linearized problem, from the matrix J of derivatives, with the quantile t of Student, or
of Gauss where the deviations are given: t sqrt(diag (J^T J)^-1) to both sides.  Where these are wide, or J differs
by more than 10 % when its differences reach over a standard error, they are of the profile likelihood: as far as
the key can go while the others are fitted again and the sum of squares grows by no more than t^2 (Bates and Watts,
Nonlinear Regression Analysis, 1988, Sec. 6.1).
"""

from __future__ import annotations

import math
from functools import cache, partial
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import brentq
from scipy.stats import chi2, norm, t

from oblique_impact.errors import InputError
from oblique_impact.history.history import History
from oblique_impact.progress import OnProgress
from oblique_impact.simulation import compute_history as simulate
from oblique_impact.validation.studies.fitting.measured import Array
from oblique_impact.validation.studies.fitting.search import Parameter, Problem, SearchResult, Solution
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
#: of a logarithm: error of an end of a profile; growths over t beyond this are taken for it, without a run too
_CLOSE, _FAR = 1e-3, 10.0
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


def find_intervals(problem: Problem, best: Solution, workers: int | None, on_progress: OnProgress) -> Estimate:
    """Find intervals and correlations at the least sum of squares."""
    count, given = len(best.u), problem.measured.has_deviations
    J = np.stack([problem.derivative(best.u, k, problem.step) for k in range(count)], axis=1)
    best, free = _effective(problem, best, np.linalg.norm(J, axis=0))
    freedom = best.residuals.size - (len(free) if given else count)
    quantile = float(norm.ppf(0.975) if given else t.ppf(0.975, freedom))
    _, s, Vt = np.linalg.svd(J[:, free], full_matrices=False)
    covariance = Vt.T / np.maximum(s, 1e-12 * s.max(initial=1.0)) ** 2 @ Vt
    errors, found, ends = np.sqrt(np.diag(covariance)), [Interval()] * count, list[tuple[int, float]]()
    for k, error in zip(free, errors.tolist(), strict=True):
        wider = problem.derivative(best.u, k, min(max(error, 2.0 * problem.step), _WIDE))
        nonlinearity = float(np.linalg.norm(wider - J[:, k]) / np.linalg.norm(J[:, k]))
        reach, (lowest, highest) = quantile * error, problem.parameters[k].bounds
        low, high = best.u[k] - reach, best.u[k] + reach
        if reach > _WIDE or nonlinearity > _NONLINEAR or not lowest < low < high < highest:
            found[k] = Interval(kind="profile", nonlinearity=nonlinearity)
            ends += [(k, -1.0), (k, 1.0)]
        else:
            found[k] = Interval(low, high, "Jacobian", nonlinearity)
    profile_end = partial(_profile_end, problem, best, free, covariance, quantile)
    names = [problem.parameters[k].label for k, _ in ends]
    profiled = map_parallel(profile_end, ends, workers, on_progress, names)
    for (k, _), low, high in zip(ends[::2], profiled[::2], profiled[1::2], strict=True):
        found[k] = found[k]._replace(low=low, high=high)
    labels = [problem.parameters[k].label for k in free]
    correlation = pd.DataFrame(covariance / np.outer(errors, errors), labels, labels)
    return Estimate(best, found, correlation, freedom)


def _effective(problem: Problem, best: Solution, effects: Array) -> tuple[Solution, list[int]]:
    """Return the solution with keys without effect back at their start, and the numbers of the others."""
    least, free = best.squares, list[int]()
    for k, effect in enumerate(effects):
        if effect < _NO_EFFECT:
            back = problem.evaluate(np.where(np.arange(effects.size) == k, 0.0, best.u))
            # not of one that went so far down that it has none any more
            if back.squares < least + _NO_EFFECT:
                best = back
                continue
        free.append(k)
    return best, free


def _profile_end(
    problem: Problem, best: Solution, free: list[int], covariance: Array, quantile: float, end: tuple[int, float]
) -> float:
    """Return the coordinate where the least sum of squares has grown by t^2; infinite if that is beyond reach.

    `free` are the keys with an effect, `covariance` is theirs; an end is a key and a side.
    """
    key, side = end
    others, row = [k for k in free if k != key], covariance[free.index(key)]
    variance = row[free.index(key)]
    along = np.zeros(best.u.size)  # how all keys go along with this one at first
    along[free] = row / variance
    limit = problem.parameters[key].bounds[int(side > 0.0)]
    far = min(_REACH + abs(best.u[key]), side * (limit - best.u[key]))
    at = {0.0: best.u}  # the others where they have been fitted again within the interval

    @cache
    def beyond(distance: float) -> float:
        """Return the root of the growth over t, less 1."""
        near = max(where for where in at if where <= distance)
        found = problem.minimize(at[near] + side * (distance - near) * along, others)
        growth = math.sqrt(max(found.squares - best.squares, 0.0)) / quantile
        if growth < 1.0:
            at[distance] = found.u
        return min(growth, _FAR) - 1.0

    near, distance = 0.0, min(quantile * math.sqrt(variance), far)
    while beyond(distance) < 0.0:
        if distance >= far:
            return side * math.inf
        near, distance = distance, min(far, distance * min(4.0, 1.05 / max(beyond(distance) + 1.0, 0.25)))
    return float(best.u[key] + side * brentq(beyond, near, distance, xtol=_CLOSE))


# --- what stands against it


def caveats(found: SearchResult, estimate: Estimate, history: History, workers: int | None) -> list[str]:
    """Return what stands against a fit, and the warnings of the fitted run."""
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
    sentences += _unpredictable(problem, history, workers)
    return sentences + [f"warning of the run: {warning}" for warning in history.summary.get("warnings", ())]


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


def _unpredictable(problem: Problem, history: History, workers: int | None) -> list[str]:
    """Name the columns that depend on the initial angle beyond measurement, by the growth of the events before."""
    scenario = history.scenario
    if not history.macro_collisions or scenario is None:
        return []
    case = judge(scenario, run_study(perturbed_runs(scenario, count=2), workers=workers))
    turn = float(case.frame["initial.angle"].max()) - scenario.initial.angle
    try:
        turned = simulate(scenario.replace(initial__angle=scenario.initial.angle + turn))
        moved = np.abs(problem.measured.predict(turned) - problem.measured.predict(history)) / problem.deviations
    except (InputError, GapError):
        moved = np.full(problem.deviations.size, math.inf)
    sentences = []
    for name, rows in problem.measured.table.groupby("column", sort=False):
        last = float(rows["time"].max())
        until = decided_at(str(name), history) if math.isnan(last) else last
        before = case.events[case.events["time"] <= until]
        growth = float(before["growth"].max()) if len(before) else 0.0
        if growth > SMALL:
            since = float(before["time"][before["growth"] > (LARGE if growth >= LARGE else SMALL)].min())
            from_then = "" if math.isnan(last) else f" from {since:.6g} s on"
            shift = f"{turn:g} rad of the initial angle move it by {moved[rows.index].max():.2g}"
            words = f"{verdict_of(growth)}{from_then}: a growth of {growth:.3g}; {shift} standard deviations"
            sentences.append(f"{name}: {words}")
    return sentences

"""Observed order, Richardson limit, grid convergence index, and the verdict on a sequence of refined values.

The formulas are those of ASME V&V 20-2009, Sec. 2-4 (Celik et al., J. Fluids Eng. 130(7), 2008, 078001) for any
ratios of refinement.  Two things differ, both on the strict side: the sign of the observed order is kept (the
standard takes its absolute value, in which a divergent sequence looks convergent), and an order counts only after
it has been confirmed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import pandas as pd
from scipy.optimize import brentq
from scipy.special import exprel

Numbers = TypeVar("Numbers", float, "pd.Series[float]")

#: safety factor of the grid convergence index of three levels or more
SAFETY = 1.25
#: relative grid convergence index at which a quantity counts as converged, unless the user says otherwise
TOLERANCE = 1e-3
#: two orders that differ by no more than this part agree
AGREEMENT = 0.2
#: orders below this are no convergence that one could use
LOWEST_ORDER = 0.3
#: a difference tells an order if it is so many times the noise
ABOVE_NOISE = 5.0
#: what rounding leaves of a value after many steps
ROUNDING = 1e-13
#: of an order times the logarithm of a ratio, within which orders are looked for; exp(700) is still a number
_REACH = 500.0
#: of the tolerance: differences below it may grow, the last levels agree anyway
NEGLIGIBLE = 0.1

CONVERGED, CONVERGING = "converged", "converging"
#: the differences do not fall; they fall, but the levels do not confirm an order; there is no limit; no value
NOT_CONVERGING, NOT_CONFIRMED = "not converging", "not confirmed"
NOT_DETERMINED, NO_VERDICT = "not determined", "no verdict"
#: verdicts, with the kind of cell that a report gives them
VERDICTS = {
    CONVERGED: "pass",
    CONVERGING: "partly",
    NOT_CONFIRMED: "partly",
    NOT_CONVERGING: "fail",
    NOT_DETERMINED: "fail",
    NO_VERDICT: "dim",
}

#: the rule of the verdicts, in paragraphs, for every report
RULE = (
    "Sizes h fall from level to level; differences are those of successive levels. The observed order p of "
    "three levels solves (r₃₂ᵖ − 1)/(r₂₁ᵖ − 1) · r₂₁ᵖ = d₃₂/d₂₁, the fixed-point equation of ASME V&V 20 for "
    "any ratios r of refinement; it is negative for differences that grow, and does not exist where their "
    f"signs alternate. The Richardson limit is f₁ + d₂₁/(r₂₁ᵖ − 1), the grid convergence index GCI = {SAFETY} "
    "|d₂₁|/(r₂₁ᵖ − 1).",
    f"An order is confirmed if it is at least {LOWEST_ORDER} and the orders of the two finest triplets agree "
    f"within {AGREEMENT:.0%}, or the finest agrees within {AGREEMENT:.0%} with the order declared for this "
    "quantity. Only then is the GCI the uncertainty (with p no higher than declared). Otherwise the "
    f"uncertainty is {SAFETY} times the larger of the last two differences. It is never less than the noise: "
    "the change of the finest value when that run is repeated with a tenth of solver.tolerance (and, for extremes "
    "among samples, four times as many of them), and 10⁻¹³ of "
    f"the value for rounding. Differences below {ABOVE_NOISE:g} times the noise tell no order.",
    "Converged: the uncertainty is at most the tolerance, relative to the value (to the beam's length for "
    "places, to the larger of initial and final energy for energies, where these are larger), and the last "
    f"difference is smaller than the one before, or both are below {NEGLIGIBLE:.0%} of the tolerance or within "
    "the noise. Converging at order p: the order is confirmed, the uncertainty still larger. Not converging: "
    "the last difference is not smaller than the two before it (than the one before, of three levels), or the "
    f"observed order is below {LOWEST_ORDER}. Not confirmed: the differences fall, but the levels do not "
    "confirm an order. The finest level and the two before it must have the quantity; otherwise there is no "
    "verdict, and the gap is named.",
    "Not determined: the quantity has no limit as modes or elements are added, whatever the levels suggest. At "
    "a given number of modes it may still converge in the step, the tolerance, the stiffness or the mesh that "
    "the modes are computed on; such a verdict says in what, and holds for that number of modes alone. Values "
    "are shown to the second digit of their uncertainty.",
)


@dataclass(frozen=True, repr=False)
class Analysis:
    """Differences, orders and verdict of one quantity over all levels, coarse to fine."""

    #: a row for each level: size, value, difference (from the level before), observed_order, richardson_limit and
    #: grid_convergence_index (unit of the value) of it with the two before, above_noise (whether both differences
    #: are well above the noise); NaN where there is none, as where the differences have different signs
    levels: pd.DataFrame
    #: changes up to this mean nothing (unit of the value)
    noise: float
    #: `CONVERGED`, `CONVERGING`, `NOT_CONVERGING`, `NOT_CONFIRMED`, `NOT_DETERMINED` or `NO_VERDICT`
    verdict: str = ""
    #: confirmed order, NaN if there is none
    order: float = math.nan
    #: Richardson limit at that order, NaN if there is none
    limit: float = math.nan
    #: of the finest value, NaN if there is none
    uncertainty: float = math.nan
    #: why, in words
    reason: str = ""

    def undetermined(self, reason: str) -> Analysis:
        """Return the analysis of a quantity that has no limit, whatever its values suggest."""
        return replace(self, verdict=NOT_DETERMINED, order=math.nan, limit=math.nan, reason=reason)

    def __repr__(self) -> str:
        """Return the verdict, and why."""
        return f"<Analysis: {self.verdict}: {self.reason}>"


def observed_order(coarse: float, fine: float, coarse_ratio: float, fine_ratio: float) -> float:
    """Order p at which two successive differences fall.

    Parameters
    ----------
    coarse, fine : float
        Differences d32 and d21 (the finer pair last), any unit.
    coarse_ratio, fine_ratio : float
        Ratios r32 and r21 of the sizes, greater than 1.

    Returns
    -------
    float
        The solution of ``(r32^p - 1)/(r21^p - 1) r21^p = d32/d21``; negative if the values run away; NaN if a
        difference is zero or their signs differ.

    Notes
    -----
    The fixed-point iteration of the standard does not settle where ln r32 > 2 ln r21.  The left-hand side rises
    with p, so its one root is bracketed instead.
    """
    if not (np.isfinite([coarse, fine]).all() and coarse * fine > 0.0):
        return math.nan
    a, b = math.log(coarse_ratio), math.log(fine_ratio)

    def excess(p: float) -> float:
        # r^p - 1 is p ln r times exprel(p ln r), which is smooth through p = 0
        return float(np.log(exprel(p * a) / exprel(p * b) * a / b * fine / coarse)) + p * b

    reach = _REACH / max(a, b)
    if excess(-reach) > 0.0 or excess(reach) < 0.0:  # a difference of another size altogether
        return math.nan
    return float(brentq(excess, -reach, reach, xtol=1e-15, rtol=1e-15))


def richardson_limit(fine: Numbers, difference: Numbers, ratio: Numbers, order: Numbers) -> Numbers:
    """Limit f1 + d21/(r21^p - 1) of the finest value f1 for an order p > 0."""
    limit: Numbers = fine + difference / np.expm1(order * np.log(ratio))
    return limit


def grid_convergence_index(difference: Numbers, ratio: Numbers, order: Numbers) -> Numbers:
    """Grid convergence index 1.25 |d21|/(r21^p - 1), in the unit of the difference, for an order p > 0."""
    index: Numbers = SAFETY * abs(difference) / np.expm1(order * np.log(ratio))
    return index


def analyse(
    sizes: Sequence[float],
    values: Sequence[float],
    *,
    tolerance: float = TOLERANCE,
    scale: float = 0.0,
    noise: float = 0.0,
    declared: float | None = None,
) -> Analysis:
    """Judge the values of one quantity on levels of refinement, coarse to fine.

    Parameters
    ----------
    sizes : sequence of float, shape (levels,)
        Representative sizes h, strictly falling (step, 1/elements, 1/modes).
    values : sequence of float, shape (levels,)
        NaN where a level does not have the quantity.
    tolerance : float
        Uncertainty, relative to the value or to `scale`, at which the quantity counts as converged.
    scale : float
        What a small value is measured by (unit of the value); 0: by itself.
    noise : float
        Changes up to this mean nothing (unit of the value).
    declared : float, optional
        The order the method declares for this quantity.

    Raises
    ------
    ValueError
        If the sizes do not fall or the lengths differ.
    """
    h, f = np.asarray(sizes, dtype=float), np.asarray(values, dtype=float)
    if h.shape != f.shape or h.ndim != 1 or not np.all(h > 0.0) or not np.all(np.diff(h) < 0.0):
        raise ValueError(f"sizes {sizes} should fall, one for each of {len(values)} values")
    floor = max(noise, ROUNDING * float(np.max(np.abs(f[np.isfinite(f)]), initial=0.0)))
    levels = pd.DataFrame({"size": h, "value": f})
    levels["difference"] = d = levels["value"].diff()
    ratio = levels["size"].shift() / levels["size"]
    triplets = zip(d.shift(), d, ratio.shift(), ratio, strict=True)
    levels["observed_order"] = p = pd.Series([observed_order(*triplet) for triplet in triplets])
    p = p.where(p > 0.0)
    levels["richardson_limit"] = richardson_limit(levels["value"], d, ratio, p)
    levels["grid_convergence_index"] = grid_convergence_index(d, ratio, p)
    levels["above_noise"] = np.minimum(d.abs(), d.shift().abs()) > ABOVE_NOISE * floor
    bound = tolerance * max(abs(float(f[-1])), scale) if np.isfinite(f[-1]) else 0.0
    return _verdict(Analysis(levels, floor), bound, declared)


def _verdict(a: Analysis, bound: float, declared: float | None) -> Analysis:
    """Return the analysis with its verdict; `bound` is the tolerated uncertainty."""
    h, d, known = a.levels["size"].tolist(), a.levels["difference"].abs().tolist(), a.levels["value"].notna()
    if not known.iloc[-3:].all() or len(h) < 3:
        missing = "the finest level does not have it"
        reason = "fewer than three successive levels up to the finest have it" if known.iloc[-1] else missing
        return replace(a, verdict=NO_VERDICT, reason=reason)
    if not math.isfinite(a.noise):
        reason = "a tighter tolerance of the scheme loses the quantity altogether"
        return replace(a, verdict=NOT_CONFIRMED, reason=reason)
    before, now = d[-2:]
    level, verdict, reason = _observed(a, declared)
    order, limit, uncertainty = math.nan, math.nan, SAFETY * max(before, now)
    if verdict == CONVERGING:
        order, limit = a.levels.loc[level, ["observed_order", "richardson_limit"]].tolist()
        # below the noise a difference says nothing any more: its place is taken by the noise
        index = grid_convergence_index(max(now, a.noise), h[-2] / h[-1], min(order, declared or order))
        uncertainty = float(index)
    uncertainty = max(uncertainty, a.noise)
    calm = now < before or max(before, now) <= max(NEGLIGIBLE * bound, ABOVE_NOISE * a.noise)
    if uncertainty <= bound and calm:
        reason = reason if verdict == CONVERGING else f"the last levels agree within the tolerance; {reason}"
        verdict = CONVERGED
    return replace(a, verdict=verdict, order=order, limit=limit, uncertainty=uncertainty, reason=reason)


def _observed(a: Analysis, declared: float | None) -> tuple[int, str, str]:
    """Return the finest level above the noise, and what the differences up to it say: a verdict with its reason.

    `CONVERGING` is a confirmed order, that of this level.
    """
    d, orders, above = a.levels["difference"].abs(), a.levels["observed_order"], a.levels["above_noise"]
    level, noise = len(d) - 1, ABOVE_NOISE * a.noise
    at_floor = d.iloc[-1] <= noise
    while level > 1 and d[level] <= noise:
        level -= 1
    ending = ", until the noise is reached" if at_floor else ""
    if level < 2 or not above[level]:
        if at_floor:
            return level, NOT_CONFIRMED, f"the last difference is zero or below {ABOVE_NOISE:g} times the noise"
        return level, NOT_CONVERGING, "differences within the noise are followed by a larger one"
    order = orders[level]
    # NaN where a level lacks the quantity, which compares false
    larger = [d[level] >= d[k] for k in (level - 1, level - 2) if k > 0]
    if math.isnan(order):
        if larger[0]:
            return level, NOT_CONVERGING, "the differences alternate in sign and do not shrink"
        verdict = NOT_CONVERGING if any(larger) else NOT_CONFIRMED
        return level, verdict, "the differences alternate in sign and shrink, so there is no observed order"
    if order < LOWEST_ORDER:
        fall = "the differences grow" if order <= 0.0 else "the differences hardly fall"
        return level, NOT_CONVERGING, f"{fall}: observed order {order:.2f}"
    earlier = orders[level - 1] if level > 2 and above[level - 1] else math.nan
    if abs(order - earlier) <= AGREEMENT * max(order, earlier):
        return level, CONVERGING, f"the last two observed orders agree: {earlier:.2f}, {order:.2f}{ending}"
    if declared and abs(order - declared) <= AGREEMENT * declared:
        return level, CONVERGING, f"observed order {order:.2f}, declared {declared:g}{ending}"
    if any(larger):
        return level, NOT_CONVERGING, "the last difference is not smaller than those before it"
    if math.isfinite(earlier):
        reason = f"the last two observed orders differ: {earlier:.2f}, {order:.2f}{ending}"
        return level, NOT_CONFIRMED, reason
    also = f" and {declared:g} is declared" if declared else ""
    reason = f"there is one observed order, {order:.2f}{also}; another level has to confirm it{ending}"
    return level, NOT_CONFIRMED, reason

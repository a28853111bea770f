"""Claims about when the beam hits the slope and with what forces (paper, Figs. 2 and 3)."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from oblique_impact.contact.state import State
from oblique_impact.validation.report.document import number
from oblique_impact.validation.reproduction.claims import Claims, Finding, graded, milliseconds, moment, verdict
from oblique_impact.validation.reproduction.measures import Trio, existing, force_difference, increasing
from oblique_impact.validation.reproduction.runs import MissingError

CLAIMS = Claims()

FIRST = 0.325  # s, first macro-collision and reversal of slip in the paper


def _differences(trio: Trio, name: str) -> list[float]:
    """Largest difference between any two models in macro-collisions 1 to 3."""
    pairs = [(trio.hybrid, trio.modified)] if name == "lambda_tau" else list(combinations(trio, 2))
    return [max(force_difference(a, b, name, k) for a, b in pairs) for k in (1, 2, 3)]


def _of_three(verdict: str, values: list[float], what: str, scale: float = 1.0, unit: str = "") -> Finding:
    """Return the finding about a number of macro-collisions 1 to 3."""
    numbers = {f"collision_{k}": value for k, value in enumerate(values, start=1)}
    return Finding(verdict, numbers, f"{what} 1, 2, 3: {', '.join(number(scale * v, 3) for v in values)}{unit}")


def _growing(values: list[float]) -> str:
    """Judge whether a number grows with every macro-collision that the runs share."""
    return verdict(increasing(existing(values)), values[1] > values[0])


@CLAIMS.add(
    "first-collision",
    "Sec. 7, Fig. 2",
    "The first macro-collision occurs at t ≈ 0.325 s.",
    "reproduced: 0.325 s lies in the hybrid model's first macro-collision, at most 2 ms from its middle; "
    "partly: it lies in it",
)
def first_collision(trio: Trio) -> Finding:
    macro = trio.hybrid.macro(1)
    start, end, middle = macro.start, macro.end, 0.5 * (macro.start + macro.end)
    inside = start <= FIRST <= end
    text = f"{moment(start)} to {moment(end)}, middle {moment(middle)}"
    numbers = {"start": start, "end": end, "middle": middle}
    return Finding(verdict(inside and abs(middle - FIRST) <= 2e-3, inside), numbers, text)


@CLAIMS.add(
    "friction-coincides",
    "Sec. 7, Fig. 2",
    "The friction of the hybrid and of the modified Coulomb model generally coincide during the first collision.",
    "D₁ = ∫|a − b| dt / ∫(|a| + |b|) dt over the first macro-collision; reproduced: D₁ ≤ 0.1; partly: ≤ 0.3",
)
def friction_coincides(trio: Trio) -> Finding:
    first = _differences(trio, "lambda_tau")[0]
    return Finding(graded(first, 0.1, 0.3), {"difference": first}, f"difference {number(first, 3)}")


@CLAIMS.add(
    "friction-slight-difference",
    "Sec. 7, Fig. 2",
    "Some slight differences still exist between them.",
    "reproduced: D₁ > 10⁻⁶",
)
def friction_differs_slightly(trio: Trio) -> Finding:
    first = _differences(trio, "lambda_tau")[0]
    return Finding(verdict(first > 1e-6), {"difference": first}, f"difference {number(first, 3)}")


@CLAIMS.add(
    "friction-drifts-apart",
    "Sec. 7, Fig. 2",
    "The differences increase gradually in subsequent collisions.",
    "D as above for macro-collisions 1, 2, 3, as far as both runs have them; reproduced: it grows with each; "
    "partly: D₁ < D₂",
)
def friction_drifts_apart(trio: Trio) -> Finding:
    values = _differences(trio, "lambda_tau")
    return _of_three(_growing(values), values, "differences in collisions")


@CLAIMS.add(
    "normal-coincides",
    "Sec. 7, Fig. 3",
    "The normal forces of the three models agree fairly well during the first macro-collision.",
    "largest D₁ of the three pairs; reproduced: ≤ 0.1; partly: ≤ 0.3",
)
def normal_coincides(trio: Trio) -> Finding:
    first = _differences(trio, "lambda_n")[0]
    return Finding(graded(first, 0.1, 0.3), {"difference": first}, f"largest difference {number(first, 3)}")


@CLAIMS.add(
    "normal-separates",
    "Sec. 7, Fig. 3",
    "The curves of the normal force become separated during subsequent collisions.",
    "largest D of the three pairs in macro-collisions 2 and 3, as far as all runs have them; reproduced: each "
    "is at least 0.3 and larger than D₁; partly: one is",
)
def normal_separates(trio: Trio) -> Finding:
    values = _differences(trio, "lambda_n")
    holds = [value >= 0.3 and value > values[0] for value in existing(values)[1:]]
    return _of_three(verdict(bool(holds) and all(holds), any(holds)), values, "differences in collisions")


@CLAIMS.add(
    "impact-times-spread",
    "Sec. 7, Fig. 3",
    "The differences between the times of impact are slight at first and become increasingly obvious.",
    "spread of the three models' first touches in macro-collisions 1, 2, 3, as far as all have them; "
    "reproduced: it grows with each; partly: from the first to the second",
)
def impact_times_spread(trio: Trio) -> Finding:
    starts = [[macro.start for macro in run.macros[:3]] + [float("nan")] * 3 for run in trio]
    spread = [float(np.ptp([run[k] for run in starts])) for k in range(3)]
    return _of_three(_growing(spread), spread, "spread of the first touches", 1e3, " ms")


@CLAIMS.add(
    "no-motion-across",
    "Sec. 4.2",
    "During the collision the displacement, velocity and acceleration of the impact point across the slope "
    "are always zero.",
    "largest |Z_n| in contact; reproduced: ≤ 10⁻⁹ m; partly: ≤ 10⁻⁵ m",
)
def no_motion_across(trio: Trio) -> Finding:
    run = trio.hybrid
    closed = run["state"] != State.FREE
    if not closed.any():
        raise MissingError("no contact")
    gap = float(np.max(np.abs(run["gap"][closed])))
    speed = float(np.max(np.abs(run["gap_rate"][closed])))
    text = f"largest |Z_n| {number(1e3 * gap, 3)} mm, |Z_n'| {number(speed, 3)} m/s"
    return Finding(graded(gap, 1e-9, 1e-5), {"gap": gap, "gap_rate": speed}, text)


@CLAIMS.add(
    "friction-matters",
    "Secs. 7, 8",
    "The influence of the tangential friction force cannot be ignored.",
    "reproduced: friction shifts the first touch of the second macro-collision by at least 1 ms",
)
def friction_matters(trio: Trio) -> Finding:
    shift = trio.hybrid.macro(2).start - trio.frictionless.macro(2).start
    text = f"second touch {milliseconds(abs(shift))} {'earlier' if shift < 0.0 else 'later'} with friction"
    return Finding(verdict(abs(shift) >= 1e-3), {"shift": shift}, text)

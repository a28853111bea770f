"""Claims about energies (paper, Figs. 4 to 7)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from oblique_impact.validation.report.document import number
from oblique_impact.validation.reproduction.claims import Claims, Finding, graded, verdict
from oblique_impact.validation.reproduction.measures import Trio, between, sampled
from oblique_impact.validation.reproduction.runs import MissingError

CLAIMS = Claims()

PARTS = ("kinetic", "gravity", "elastic")


def _moments(trio: Trio) -> dict[str, float]:
    """Return the times (s) of comparison: in flight after the first two collisions, and the end."""
    found = {f"after collision {k}": between(trio, k) for k in (1, 2)}
    times = {name: time for name, time in found.items() if time is not None}
    return {**times, "end": trio.end}


@CLAIMS.add(
    "energy-constant-before",
    "Sec. 7, Fig. 4",
    "During the initial collision-free stage the total mechanical energy remains constant.",
    "largest relative change up to the first touch; reproduced: ≤ 10⁻⁶; partly: ≤ 10⁻³",
)
def constant_before(trio: Trio) -> Finding:
    run = trio.hybrid
    energy = run["energy"][run["time"] <= trio.before_contact]
    drift = float(np.max(np.abs(energy / energy[0] - 1.0)))
    text = f"{number(float(energy[0]))} J, relative drift {number(drift, 2)}"
    return Finding(graded(drift, 1e-6, 1e-3), {"initial": float(energy[0]), "drift": drift}, text)


@CLAIMS.add(
    "considerable-loss",
    "Sec. 7, Fig. 4",
    "The collision can cause considerable loss of energy.",
    "reproduced: the first macro-collision takes at least 10 % of the total mechanical energy",
)
def considerable_loss(trio: Trio) -> Finding:
    time = between(trio, 1)
    if time is None:
        raise MissingError("no flight after the first collision")
    run = trio.hybrid
    loss = float(run["energy"][0]) - run.at("energy", time)
    share = loss / float(run["energy"][0])
    text = f"{number(loss, 4)} J, {number(100.0 * share, 3)} % of the total"
    return Finding(verdict(share >= 0.1), {"loss": loss, "share": share}, text)


def _ordering(trio: Trio, holds: Callable[[float, float, float], bool]) -> Finding:
    """Judge a relation of the total energies of the three models."""
    numbers: dict[str, float] = {}
    held, parts = [], []
    for name, time in _moments(trio).items():
        values = [run.at("energy", time) for run in trio]
        numbers |= {f"{model} {name}": v for model, v in zip(trio._fields, values, strict=True)}
        held.append(holds(*values))
        row = " / ".join(number(value, 5) for value in values)
        parts.append(f"{name} {row} J {'✓' if held[-1] else '✗'}")
    return Finding(verdict(all(held), any(held)), numbers, "; ".join(parts))


@CLAIMS.add(
    "hybrid-loses-most",
    "Sec. 7, Fig. 4",
    "The energy loss calculated using the hybrid model is the largest.",
    "total energy of hybrid / frictionless / modified Coulomb in flight after collisions 1 and 2 and at the "
    "end; reproduced: the hybrid model's is the smallest each time; partly: at least once",
)
def hybrid_loses_most(trio: Trio) -> Finding:
    return _ordering(trio, lambda hybrid, frictionless, modified: hybrid < min(frictionless, modified))


@CLAIMS.add(
    "frictionless-loses-least",
    "Sec. 7, Fig. 4",
    "The energy loss calculated using the nontangential friction model is the smallest.",
    "as above; reproduced: the frictionless model's energy is the largest each time; partly: at least once",
)
def frictionless_loses_least(trio: Trio) -> Finding:
    return _ordering(trio, lambda hybrid, frictionless, modified: frictionless > max(hybrid, modified))


@CLAIMS.add(
    "friction-dissipates",
    "Sec. 7, Fig. 4",
    "Tangential friction can cause some energy loss to the system.",
    "reproduced: the work taken by friction in the hybrid model is positive",
)
def friction_dissipates(trio: Trio) -> Finding:
    work = trio.hybrid.energy["lost_friction"]
    whole = trio.hybrid.energy["initial"] - trio.hybrid.energy["final"]
    text = f"{number(1e3 * work, 4)} mJ, {number(100.0 * work / whole, 3)} % of what is lost in the run"
    return Finding(verdict(work > 0.0), {"friction": work, "lost": whole}, text)


@CLAIMS.add(
    "exchange-before",
    "Sec. 7, Figs. 5–7",
    "During the initial stage kinetic and gravitational energy convert mutually; elastic energy is tiny.",
    "largest elastic energy over the change of gravitational energy; reproduced: ≤ 10⁻³; partly: ≤ 10⁻²",
)
def exchange_before(trio: Trio) -> Finding:
    run = trio.hybrid
    inside = run["time"] <= trio.before_contact
    exchanged = float(np.ptp(run["gravity"][inside]))
    elastic = float(np.max(run["elastic"][inside]))
    ratio = elastic / exchanged
    text = f"{number(exchanged, 4)} J exchanged, elastic at most {number(elastic, 2)} J"
    return Finding(graded(ratio, 1e-3, 1e-2), {"exchanged": exchanged, "elastic": elastic}, text)


@CLAIMS.add(
    "elastic-after",
    "Sec. 7, Figs. 5–7",
    "After the collision the elastic potential energy is no longer zero.",
    "reproduced: its largest value in the first macro-collision is at least 100 times that before",
)
def elastic_after(trio: Trio) -> Finding:
    run = trio.hybrid
    before = float(np.max(run["elastic"][run["time"] <= trio.before_contact]))
    macro = run.macros[0]
    after = float(np.max(run["elastic"][run.inside(macro.start, macro.end)]))
    text = f"largest {number(before, 2)} J before, {number(after, 4)} J in the first collision"
    return Finding(verdict(after >= 100.0 * before), {"before": before, "after": after}, text)


@CLAIMS.add(
    "all-parts-smaller",
    "Sec. 7, Figs. 5–7",
    "After the first macro-collision the kinetic, gravitational and elastic energies of the hybrid model are "
    "all smaller than those of the other two.",
    "from the end of the first macro-collision to the end of the run; reproduced: each is the smallest for at "
    "least 95 % of the time; partly: the mean over time of each is the smallest",
)
def all_parts_smaller(trio: Trio) -> Finding:
    start = max(run.macros[0].end for run in trio)
    numbers: dict[str, float] = {}
    shares, smallest, texts = [], [], []
    for part in PARTS:
        values = sampled(trio, part, start, trio.end)
        share, means = float(np.mean(values[0] < values[1:].min(axis=0))), values.mean(axis=1).tolist()
        shares.append(share)
        smallest.append(means[0] < min(means[1:]))
        numbers[f"{part} share"] = share
        numbers |= {f"{part} mean {model}": mean for model, mean in zip(trio._fields, means, strict=True)}
        words = "smallest" if smallest[-1] else "not"
        texts.append(f"{part} {number(100.0 * share, 3)} % of the time, mean {words}")
    return Finding(verdict(min(shares) >= 0.95, all(smallest)), numbers, "; ".join(texts))

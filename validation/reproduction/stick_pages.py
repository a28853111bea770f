"""The part of the report about stick: why it cannot occur in the paper's example, and where it does."""

from __future__ import annotations

from collections.abc import Mapping

from oblique_impact.validation.report.document import Block, Cell, Picture, Table, Text, number, number_cells
from oblique_impact.validation.reproduction.material import Material
from oblique_impact.validation.reproduction.runs import Run
from oblique_impact.validation.reproduction.sticking import StickCheck

#: what is shown of stick: the run, its title, the caption of its picture
STICKING = {
    "event": (
        *("paper/event/hybrid", "The paper's case, event-located"),
        "Event-located: reversals need a ratio of about 10; no stick.",
    ),
    "fixed-step": (
        *("paper/fixed-step/hybrid", "The paper's case, as printed"),
        "As printed: what is judged stick is short, and the tip moves.",
    ),
    "no-shortening": (
        *("no-shortening/fixed-step/hybrid", "As printed, without the contact point's shortening"),
        "As printed, the contact point's shortening left out.",
    ),
    "sticking": (
        *("sticking/event/hybrid", "Scenario sticking, event-located"),
        "Built-in scenario sticking: steeper and rough, the tip jams and stays.",
    ),
    "rough": (
        *("rough/event/hybrid", "The paper's slope with μ = 12, event-located"),
        "The paper's slope with μ = 12 and three mean-axis modes: stick and slip alternate.",
    ),
}


def sticking_blocks(material: Material, pictures: Mapping[str, str]) -> list[Block]:
    """Return explanation, test, pictures and tables."""
    drawn = [
        Picture(pictures[f"sticking-{name}"], caption, half=name in ("sticking", "rough"))
        for name, (_, _, caption) in STICKING.items()
    ]
    tables = [_check_table(material.runs[key], title) for key, title, _ in STICKING.values()]
    return [*_explanation(material), *drawn, *tables]


def _explanation(material: Material) -> list[Block]:
    located, printed, without = (material.runs[key] for key, _, _ in list(STICKING.values())[:3])
    ratio, outcomes = material.threshold
    finite = [check.ratio for check in located.checks if check.ratio < float("inf")]
    tried = "; ".join(f"μ_s = {number(mu, 5)}: {what}" for mu, what in outcomes)
    speeds = [max((abs(stick.slip_rate) for stick in run.sticks), default=0.0) for run in (printed, without)]
    longest = [max((stick.duration for stick in run.sticks), default=0.0) for run in (printed, without)]
    return [
        Text(
            "The tip sticks at an instant of contact if three things hold: its slip velocity is zero; the forces "
            "that would hold it (the sticking solution of both constraints) push, λn > 0; and they lie in the "
            "friction cone, |λτ|/λn ≤ μ_s."
        ),
        Text(
            "In the paper's example they do not. A beam that does not stretch can move its tip only across the "
            "line from the pin, so a contact that holds the tip acts along that line. With an angle b between "
            f"line and slope that takes |λτ|/λn of about cot|b|, here {number(located.checks[0].cotangent, 3)}; "
            f"where slip reverses, the flexible beam asks for {number(min(finite), 3)} to "
            f"{number(max(finite), 3)}, or for a contact that pulls, against μ = "
            f"{located.scenario.contact.mu_static}. The slope is too nearly parallel to the beam."
        ),
        Text(
            f"Tested: the first reversal of the event-located run asks for {number(ratio, 5)}. With the static "
            f"coefficient just below and just above it (kinetic 0.3), the same instant gives: {tried}."
        ),
        Text(
            "The fixed-step algorithm as printed judges stick by the forces alone (Sec. 5.3); the slip velocity "
            "is not asked for. It finds stick where the slip velocity passes an extreme, where hardly any "
            "tangential force is needed to keep the acceleration zero. The tip does not rest then: it moves at "
            f"up to {number(1e3 * speeds[0], 3)} mm/s as a stay judged stick begins, and at up to "
            f"{number(1e3 * speeds[1], 3)} mm/s if the contact point's shortening is left out; the longest "
            f"stays last {number(1e6 * longest[0], 3)} µs and {number(1e6 * longest[1], 3)} µs."
        ),
    ]


_MOST_CHECKS = 20


def _check_table(run: Run, title: str) -> Table:
    stepwise = run.scenario.solver.scheme == "fixed-step"
    durations = {stick.start: stick.duration for stick in run.sticks}
    rows = [_check_row(check, run, stepwise, durations) for check in run.checks[:_MOST_CHECKS]]
    more = len(run.checks) - len(rows)
    columns = ["t (s)", "what happens", "slip velocity (mm/s)", "λn to stick (N)", "λτ to stick (N)", "|λτ|/λn"]
    columns += ["cot|b|", "μ_s", "lasts (µs)", "why"]
    note = f" ({more} more in results.json)" if more else ""
    terms = "; Baumgarte's terms included, as the scheme judges" if stepwise else ""
    return Table(columns, rows, f"{title}{terms}{note}", wide=(9,))


def _check_row(check: StickCheck, run: Run, stepwise: bool, durations: dict[float, float]) -> list[Cell]:
    normal, tangential = (
        (check.judged_normal, check.judged_tangential) if stepwise else (check.normal, check.tangential)
    )
    ratio = check.judged_ratio if stepwise else check.ratio
    mu = run.scenario.contact.mu_static
    lasts = durations.get(check.time)
    values = (1e3 * check.slip_rate, normal, tangential, ratio, check.cotangent, mu)
    shown = ["pulls" if value == float("inf") else number(value, 4) for value in values]
    lasting = number(None if lasts is None else 1e6 * lasts, 4)
    time, *cells = number_cells(f"{check.time:.6f}", *shown, lasting)
    return [time, Cell(check.kind), *cells, Cell(why(check, ratio, mu))]


def why(check: StickCheck, ratio: float, mu: float) -> str:
    """Say why the tip can or cannot stick at an event."""
    moving = abs(check.slip_rate) > 1e-6
    if check.kind == "stick":
        if moving:
            speed = number(1e3 * abs(check.slip_rate), 3)
            return f"judged stick by the forces, although the tip moves at {speed} mm/s"
        return f"sticks: slip velocity 0 and {number(ratio, 3)} ≤ {number(mu, 3)}"
    if ratio != ratio:
        return "cannot: the two constraints are the same there, no force along the slope holds the tip"
    if ratio == float("inf"):
        return "cannot: a contact that holds the tip would have to pull it"
    if ratio <= mu:
        return "inside the cone, but the scheme turns the slip before it judges"
    return f"cannot: {number(ratio, 3)} > {number(mu, 3)}"

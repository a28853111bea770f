"""Sensitivity of event times and macro-collisions, from runs with perturbed initial angles.

How much a time t of a run depends on the initial angle is its growth

    growth = max |t(theta_0 + d) - t(theta_0)| / (|d| T),   T the time of the first touch-down

over perturbed runs with |d| of a hundred-millionth and a millionth of a radian, which nobody could measure; less
where the beam starts so close to an obstacle that it would touch it, or stand on its other side.  T is at least
the time that separates macro-collisions: a beam that strikes at once has no time of its own.  A macro-collision
whose start has a growth of at most 10 is predictable; from 1000 on it is not: rounding moves it.
This is said of a model as it stands: a coarse one may be predictable and far from its limit, which `refine` shows.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from oblique_impact.beam.frequencies import macro_gap
from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import writing
from oblique_impact.progress import OnProgress, silent
from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.scenario.scenario import Scenario, require_scenario
from oblique_impact.validation.report import (
    Cell,
    Picture,
    Report,
    Section,
    Table,
    Text,
    capitalized,
    cell,
    number,
    number_within,
    picture,
    readable,
)
from oblique_impact.validation.report.parameters import differing, parameters
from oblique_impact.validation.studies.parallel import check_limits
from oblique_impact.validation.studies.study import FAILURES, Run, run_study

Array = NDArray[np.float64]

PREDICTABLE, SENSITIVE, UNPREDICTABLE, UNKNOWN = "predictable", "sensitive", "not predictable", "no verdict"
#: growths that separate the verdicts: what the motion carries along is about 1, rounding is 1e-16 of a time
SMALL, LARGE = 10.0, 1e3
#: quantities that are measured, and how many of each at most
_ASKED = {"start": 20, "collision_impulse": 20, "collision_contacts": 20, "event": 400}
#: rad
PERTURBATIONS = (1e-8, 1e-6)
SHADOWS, MOST_SHADOWS = 4, 1000
_CLOSED = 1e-12  # of the length
_KINDS = {PREDICTABLE: "pass", SENSITIVE: "partly", UNPREDICTABLE: "fail", UNKNOWN: "dim"}
RULE = (
    "Each perturbed run starts at an initial angle that differs by no more than d. The growth of a time t is "
    "max |t(θ₀ + d) − t(θ₀)| / (|d| T), with T the time of the first touch-down, at least that which separates "
    "macro-collisions: about 1 if the motion carries a difference along, and more if each contact magnifies it. d "
    "is less than half of what would close an open gap.",
    f"A macro-collision is predictable if the growth of its start is at most {SMALL:g}, sensitive up to "
    f"{LARGE:g}, and not predictable from there on or if the physics stops a perturbed run before it. What is not "
    "predictable is no number of the beam: rounding, a tolerance or another compiler move it as far. Its spread "
    "is given instead.",
    "A perturbed run that reaches its end time without some event would have it later: what is left of the run is "
    f"a lower bound of the difference. A bound below {LARGE:g} gives no verdict. Perturbed runs that failed, by "
    "an error or a timeout, are left out and named; without any there is no verdict.",
    "This is said of the model as it stands. A coarse one may be predictable and far from its limit: its "
    "refinement shows that.",
)


@dataclass(frozen=True, repr=False)
class CaseResult:
    """Perturbed runs of one scenario."""

    name: str
    scenario: Scenario
    #: a row for each event of the unperturbed run: time (s) and growth, bounds and infinities as in `collisions`
    events: pd.DataFrame
    #: a row for each macro-collision: number from 1, start (s) and impulse (N s) of the unperturbed run, the
    #: fewest and the most contacts among the runs, growth of the start (infinite if the physics stopped a
    #: perturbed run before it, NaN without any), whether that is a lower bound only, as a perturbed run ended
    #: before, verdict, and the largest differences of start and impulse by perturbation
    collisions: pd.DataFrame
    #: T (s)
    unit_time: float
    #: rows of the runs that did not fail, that of the unperturbed one first, with their offsets (rad)
    frame: pd.DataFrame
    #: rows of the perturbed runs that failed and are left out
    failed: pd.DataFrame

    def __repr__(self) -> str:
        """Return what stands against the result, and a line for each macro-collision."""
        found = [f"{self.name}:", *(f"  {remark}" for remark in self.remarks)]
        for c in self.collisions.itertuples():
            growth = "" if math.isnan(c.growth) else f", growth {'at least ' * c.lower_bound}{c.growth:.3g}"
            found.append(f"  collision {c.collision}: starts at {c.start:.9g} s{growth}: {c.verdict}")
        return "\n".join(found)

    @property
    def remarks(self) -> list[str]:
        """Sentences: why there are no collisions, which perturbed runs are left out, warnings of the run."""
        run, remarks = self.frame.iloc[0], []
        if run["outcome"] in FAILURES:
            remarks.append(f"the unperturbed run failed: {run['outcome']}: {run['message']}")
        elif self.collisions.empty:
            words = ": ".join(filter(None, (run["outcome"], run["message"])))
            remarks.append(f"no contact until {run['stopped_at']:.6g} s: {words}")
        remarks += [
            f"perturbed run at {row['offset']:g} rad left out: {row['outcome']}: {row['message']}"
            for row in self.failed.to_dict("records")
        ]
        return remarks + [f"warning: {warning}" for warning in run["warnings"].splitlines()]


@dataclass(frozen=True, repr=False)
class Predictability:
    """A predictability study, and the wall time (s) that it took."""

    name: str
    cases: tuple[CaseResult, ...]
    seconds: float

    def __repr__(self) -> str:
        """Return a line for each macro-collision."""
        return "\n".join(["<Predictability>", *map(repr, self.cases)])

    def _repr_html_(self) -> str:
        """Show the head of the report in a notebook."""
        return report(self)._repr_html_()

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each macro-collision of each case, as in results.csv."""
        return pd.concat([found.collisions.assign(case=found.name) for found in self.cases])


def predictability(
    scenario: Scenario | Mapping[str, Scenario],
    *,
    perturbations: Sequence[float] = PERTURBATIONS,
    shadows: int = SHADOWS,
    out: str | os.PathLike[str] | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    timeout: float | None = None,
    name: str = "scenario",
    on_progress: OnProgress = silent,
) -> Predictability:
    """Judge for each macro-collision whether its numbers are determined, by runs with perturbed initial angles.

    Parameters
    ----------
    scenario : Scenario or mapping of str to Scenario
        What is tried, or several by their names, such as
        `oblique_impact.validation.studies.shipped.predictability_cases()`.
    perturbations : sequence of float
        Largest changes of the initial angle (rad); all are less in proportion where half of the least gap that is
        open at the start is turned away by less.
    shadows : int
        Runs per perturbation d, an even number: evenly from -d to d without 0, but for those that would begin
        below the slope.
    out : path, optional
        Folder for report.html, results.json and results.csv, where an interrupted study goes on.
    scheduler, workers, timeout, on_progress
        As for :func:`~oblique_impact.validation.studies.study.run_study`.
    name : str
        What the scenario is called in the report.

    Raises
    ------
    InputError
        In one line if a perturbation or the number of runs is not possible, or there is no contact.

    Examples
    --------
    >>> from oblique_impact import Scenario
    >>> from oblique_impact.validation import predictability
    >>> soft = Scenario.builtin("elastic-stop").replace(end_time=0.4)
    >>> predictability(soft, shadows=2, workers=1).cases[0].collisions["verdict"][0]
    'predictable'
    """
    if not perturbations or not all(0.0 < d <= 0.1 for d in perturbations):
        given = "".join(f" {d:g}" for d in perturbations)
        raise InputError(f"perturbations{given}: should be angles in rad, above 0 and at most 0.1")
    if not 2 <= shadows <= MOST_SHADOWS or shadows % 2:
        raise InputError(f"shadows {shadows}: should be an even number from 2 to {MOST_SHADOWS}")
    cases = scenario if isinstance(scenario, Mapping) else {name: require_scenario(scenario, "predictability")}
    parts = np.delete(np.arange(-shadows // 2, shadows // 2 + 1), shadows // 2) / (shadows // 2)
    started = time.perf_counter()
    names = tuple(f"{kind}:{n}" for kind, last in _ASKED.items() for n in range(1, last + 1))
    runs = []
    for label, case in cases.items():
        if not case.contact.enabled:
            raise InputError("contact.enabled = false: without contact there is nothing to predict")
        for offset in [0.0, *np.outer(_fitting(case, perturbations), parts).ravel().tolist()]:
            try:
                perturbed = case.replace(initial__angle=case.initial.angle + offset) if offset else case
            except InputError:  # below the slope
                continue
            runs.append(Run({"case": label, "offset": offset}, perturbed, names))
    check_limits(scheduler, workers, timeout)
    with writing(out):
        frame = run_study(
            runs, out, scheduler=scheduler, workers=workers, timeout=timeout, on_progress=on_progress
        )
        found = [judge(label, case, perturbations, frame[frame["case"] == label]) for label, case in cases.items()]
        result = Predictability(name, tuple(found), time.perf_counter() - started)
        if out is not None:
            report(result).write(Path(out), _data(result), result.to_dataframe())
    return result


def _fitting(scenario: Scenario, perturbations: Sequence[float]) -> list[float]:
    """Return the perturbations (rad), all less in proportion where the largest is half of the closing turn."""
    scale = min(1.0, 0.5 * closing_turn(scenario) / max(perturbations))
    return [scale * d for d in perturbations]


def closing_turn(scenario: Scenario) -> float:
    """Return the least angle (rad) by which the straight beam at the start could turn to close an open gap.

    It is gap over lever arm of each place that can touch, infinite if none is open.  A gap of less than 1e-12 of
    the length is closed.
    """
    angle, hub, length = scenario.initial.angle, scenario.root.hub_radius, scenario.beam.length
    reach, turns = hub + length, [math.inf]
    for side in scenario.sides:
        for x in scenario.beam_points:
            gap, along = side.gap_and_place(hub + x, angle, scenario.half_depth)
            if side.is_beside(along) and gap > _CLOSED * length:
                turns.append(gap / (hub + x))
    for point in scenario.obstacle_points:
        arm = math.hypot(point.x, point.y)
        gap = point.distance(hub, reach, angle) - point.radius - scenario.half_depth
        if gap > _CLOSED * length:
            turns.append(gap / max(arm, gap))
    return min(turns)


def judge(name: str, scenario: Scenario, perturbations: Sequence[float], frame: pd.DataFrame) -> CaseResult:
    """Judge a scenario by the frame of its runs, that of offset 0 first; quantities "start:1", "event:1", ..."""
    failing = frame["outcome"].isin(FAILURES) & (frame["offset"] != 0.0)
    failed, frame = frame[failing], frame[~failing]

    def table(kind: str) -> Array:
        """Return the quantities "kind:1", "kind:2", ... of all runs, shape (runs, numbers)."""
        columns = [f"{kind}:{n}" for n in range(1, _ASKED[kind] + 1)]
        return np.asarray(frame.reindex(columns=columns), dtype=float)

    events, starts = (times[:, np.isfinite(times[0])] for times in (table("event"), table("start")))
    count = starts.shape[1]
    impulses, contacts = table("collision_impulse")[:, :count], table("collision_contacts")[:, :count]
    begins = events.size and events[0, 0] > 0.0
    unit = max(float(events[0, 0]), macro_gap(scenario)) if begins else scenario.end_time
    # a perturbed run that came to its end without such a time would have had it later, which is a lower bound; one
    # that the physics stopped will never have it
    ends = frame["stopped_at"].where(frame["outcome"] == Outcome.COMPLETED.label, math.inf).to_numpy()[1:, None]
    shifts, moved = (
        np.where(np.isnan(times[1:]), ends - times[0], np.abs(times[1:] - times[0])) for times in (starts, events)
    )
    offsets = frame["offset"].abs().to_numpy(float)[1:]
    scale = offsets[:, None] * unit
    growth = _largest(shifts / scale)
    bounded = np.isnan(starts[1:]).any(axis=0) & np.isfinite(growth)
    collisions = pd.DataFrame(
        {
            "collision": np.arange(1, count + 1),
            "start": starts[0],
            "impulse": impulses[0],
            "fewest_contacts": pd.DataFrame(contacts).min().to_numpy(),
            "most_contacts": pd.DataFrame(contacts).max().to_numpy(),
            "growth": growth,
            "lower_bound": bounded,
            "verdict": [verdict_of(*pair) for pair in zip(growth, bounded, strict=True)],
        }
    )
    below = 0.0
    for d in sorted(_fitting(scenario, perturbations)):
        group = (offsets > below) & (offsets <= d * (1.0 + 1e-9))
        collisions[f"start_by_{d:g}"] = _largest(shifts[group])
        collisions[f"impulse_by_{d:g}"] = _largest(np.abs(impulses[1:] - impulses[0])[group])
        below = d * (1.0 + 1e-9)
    growths = pd.DataFrame({"time": events[0], "growth": _largest(moved / scale)})
    return CaseResult(name, scenario, growths, collisions, unit, frame, failed)


def _largest(values: Array) -> Array:
    """Return the largest over all perturbed runs, NaN where there are none."""
    return np.asarray(np.max(values, axis=0) if len(values) else np.full(values.shape[1:], math.nan))


def verdict_of(growth: float, lower_bound: bool = False) -> str:
    """Return the verdict on a growth; from a lower bound only that something is not predictable."""
    if growth >= LARGE:
        return UNPREDICTABLE
    if lower_bound or math.isnan(growth):
        return UNKNOWN
    return PREDICTABLE if growth <= SMALL else SENSITIVE


def lines(result: Predictability) -> list[str]:
    """Return what a study found in lines, for a terminal."""
    return [line for case in result.cases for line in repr(case).splitlines()]


# --- report


def _data(result: Predictability) -> dict[str, Any]:
    cases = [
        {
            "name": found.name,
            "scenario": found.scenario,
            "unit_time": found.unit_time,
            "runs": pd.concat([found.frame, found.failed])[["offset", "outcome", "message", "warnings"]],
            "events": found.events,
            "collisions": found.collisions,
        }
        for found in result.cases
    ]
    return {"study": result.name, "rule": RULE, "cases": cases, "times": {"wall_time": result.seconds}}


def report(result: Predictability) -> Report:
    """Return the report."""
    scenarios = {found.name: found.scenario for found in result.cases}
    return Report(
        "Predictability: runs with perturbed initial angles",
        "Sensitivity of times and impulses of the impacts to the initial angle. Perturbed runs start at angles "
        "that differ by less than can be measured; where they part, the scenario does not determine what follows.",
        result.seconds,
        facts=[("runs", str(sum(len(found.frame) + len(found.failed) for found in result.cases)))],
        overview=[_growth_picture(result) if any(len(found.events) for found in result.cases) else None],
        sections=[
            *map(_section, result.cases),
            Section("Cases", [differing(scenarios) if len(scenarios) > 1 else None]),
            *parameters(scenarios),
            Section("How a verdict is found", [*map(Text, RULE)]),
        ],
    )


def _growth_picture(result: Predictability) -> Picture:
    """Draw the largest growth until each event, a line a case."""
    caption = "Largest growth of the difference of an event's time, from unperturbed to perturbed run, until then."
    with picture(caption, height=3.9) as drawn:
        axes = drawn.figure.subplots()
        for index, found in enumerate(result.cases):
            growth = found.events["growth"].replace(math.inf, math.nan).cummax()
            style: dict[str, Any] = {"color": SERIES[index % len(SERIES)], "label": found.name}
            axes.step(found.events["time"], growth, where="post", linewidth=1.4, **style)
        for level, words, up in ((SMALL, "predictable below", -11), (LARGE, "not predictable above", 3)):
            axes.axhline(level, color=GREY, linewidth=0.9, linestyle="--")
            place: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
            axes.annotate(words, (0.0, level), xytext=(4, up), fontsize=8.5, color=GREY, **place)
        axes.set(xlabel="time of the event (s)", ylabel="largest growth until then", yscale="log")
        axes.set_ylim(bottom=min(axes.get_ylim()[0], 0.5 * SMALL))
        drawn.figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return drawn


def _section(found: CaseResult) -> Section:
    """Return the collisions of a case, in the digits that the smallest perturbation leaves."""
    shifts = [str(name) for name in found.collisions if "_by_" in str(name)]
    rows = []
    for c in found.collisions.to_dict("records"):
        own = [Cell(number_within(c[name], c[shifts[k]]), "number") for k, name in enumerate(("start", "impulse"))]
        growth = Cell(("≥ " if c["lower_bound"] else "") + number(c["growth"], 3), "number")
        contacts = [c["fewest_contacts"], c["most_contacts"]]
        moved = [cell(c[name], 2) for name in shifts]
        rows.append([c["collision"], *own, *moved, *contacts, growth, Cell(c["verdict"], _KINDS[c["verdict"]])])
    columns = ["macro-collision", "start (s)", "normal impulse (N s)"]
    for name in shifts:
        what, _, perturbation = name.partition("_by_")
        columns.append(f"shift of {what} by {readable(perturbation)} rad ({'s' if what == 'start' else 'N s'})")
    columns += ["fewest contacts", "most contacts", "growth", "verdict"]
    caption = (
        "Macro-collisions, and how far the perturbed runs move them; where one ends before a start, the rest of "
        "its time is a lower bound. Starts and impulses have the digits that the smallest perturbation leaves."
    )
    remarks = [Text(f"{capitalized(remark)}.", note=True) for remark in found.remarks]
    return Section(found.name, [*remarks, Table(columns, rows, caption)])

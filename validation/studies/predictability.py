"""Sensitivity of event times and macro-collisions, from runs with perturbed initial angles.

How much a time t of a run depends on the initial angle is its growth

    growth = max |t(theta_0 + d) - t(theta_0)| / (|d| T),   T the time of the first touch-down

over perturbed runs with |d| of a hundred-millionth and a millionth of a radian, which nobody could measure.  A
macro-collision whose start has a growth of at most 10 is predictable; from 1000 on it is not: rounding moves it.
This is said of a model as it stands: a coarse one may be predictable and far from its limit, which `refine` shows.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from oblique_impact.errors import InputError, Outcome
from oblique_impact.progress import OnProgress, silent
from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.scenario.scenario import Scenario, require_scenario
from oblique_impact.validation.report import (
    Cell,
    Fold,
    Picture,
    Report,
    Section,
    Table,
    Text,
    cell,
    number,
    picture,
)
from oblique_impact.validation.studies.measure import FAILURES
from oblique_impact.validation.studies.study import Limits, Run, run_study

Array = NDArray[np.float64]

PREDICTABLE, SENSITIVE, UNPREDICTABLE, UNKNOWN = "predictable", "sensitive", "not predictable", "no verdict"
#: growths that separate the verdicts: what the motion carries along is about 1, rounding is 1e-16 of a time
SMALL, LARGE = 10.0, 1e3
#: times that are compared at most
MOST_COLLISIONS, MOST_EVENTS = 20, 400
#: rad
PERTURBATIONS = (1e-8, 1e-6)
SHADOWS, MOST_SHADOWS = 4, 1000
_KINDS = {PREDICTABLE: "pass", SENSITIVE: "partly", UNPREDICTABLE: "fail", UNKNOWN: "dim"}
RULE = (
    "Each perturbed run starts at an initial angle that differs by no more than d. The growth of a time t is "
    "max |t(θ₀ + d) − t(θ₀)| / (|d| T), with T the time of the first touch-down: about 1 if the motion carries a "
    "difference along, and more if each contact magnifies it.",
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


@dataclass(frozen=True)
class Case:
    """A scenario whose predictability is asked for, with a name and words for the report."""

    name: str
    scenario: Scenario
    text: str = ""


@dataclass(frozen=True)
class CaseResult:
    """Perturbed runs of one case.

    Attributes
    ----------
    offsets : ndarray, shape (shadows,)
        Of the initial angle (rad).
    amplitudes : ndarray, shape (shadows,)
        Perturbation (rad) to which each run belongs: the smallest that its offset does not exceed.
    events : ndarray, shape (events,)
        Times of the unperturbed run (s).
    shadows : ndarray, shape (shadows, events)
        The same of the perturbed runs; NaN where one has fewer.
    growth : ndarray, shape (events,)
        Of each event's time, bounds and infinities as in `collisions`.
    collisions : DataFrame
        A row for each macro-collision: number from 1, start (s) and impulse (N s) of the unperturbed run, the
        fewest and the most contacts among the runs, growth of the start (infinite if the physics stopped a
        perturbed run before it, NaN without any), whether that is a lower bound only, as a perturbed run ended
        before, verdict, and the largest differences of start and impulse by perturbation.
    unit_time : float
        T (s).
    frame : DataFrame
        Rows of the runs that did not fail, that of the unperturbed one first, with their offsets.
    failed : tuple of (float, dict)
        Offsets and rows of the perturbed runs that failed and are left out.
    """

    case: Case
    perturbations: tuple[float, ...]
    offsets: Array
    amplitudes: Array
    events: Array
    shadows: Array
    growth: Array
    collisions: pd.DataFrame
    unit_time: float
    frame: pd.DataFrame
    failed: tuple[tuple[float, dict[str, Any]], ...]

    @property
    def horizon(self) -> float:
        """Time (s) of the last event before the first one that is not predictable; infinite if all are."""
        if not self.offsets.size:
            return math.nan
        lost = np.flatnonzero(self.growth >= LARGE)
        if not lost.size:
            return math.inf
        return float(self.events[lost[0] - 1]) if lost[0] else 0.0

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
            f"perturbed run at {offset:g} rad left out: {row['outcome']}: {row['message']}"
            for offset, row in self.failed
        ]
        return remarks + [f"warning: {warning}" for warning in run["warnings"].splitlines()]


@dataclass(frozen=True)
class Predictability:
    """A predictability study; `report` is its page, if one was written."""

    name: str
    cases: tuple[CaseResult, ...]
    seconds: float
    report: Path | None = None


def predictability(
    scenario: Scenario | Sequence[Case],
    *,
    perturbations: Sequence[float] = PERTURBATIONS,
    shadows: int = SHADOWS,
    out: str | os.PathLike[str] | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    timeout: float | None = None,
    name: str = "scenario",
    command: str = "",
    on_progress: OnProgress = silent,
) -> Predictability:
    """Judge for each macro-collision whether its numbers are determined, by runs with perturbed initial angles.

    Parameters
    ----------
    scenario : Scenario or sequence of Case
        What is tried; the shipped cases are `oblique_impact.validation.studies.shipped.predictability_cases()`.
    perturbations : sequence of float
        Largest changes of the initial angle (rad).
    shadows : int
        Runs per perturbation d, evenly from -d to d without 0; from 0 to d where -d lies below the slope.
    out : path, optional
        Folder for report.html, results.json and results.csv, where an interrupted study goes on.
    scheduler, workers, timeout, on_progress
        As for :func:`oblique_impact.validation.studies.refinement.refine`.
    name, command : str
        What the scenario is called, and how to repeat the study, for the report.

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
    if isinstance(scenario, Sequence) and all(isinstance(case, Case) for case in scenario):
        cases = list(scenario)
    else:
        cases = [Case(name, require_scenario(scenario, "predictability"))]
    if not perturbations or not all(0.0 < d <= 0.1 for d in perturbations):
        given = "".join(f" {d:g}" for d in perturbations)
        raise InputError(f"perturbations{given}: should be angles in rad, above 0 and at most 0.1")
    if not 2 <= shadows <= MOST_SHADOWS:
        raise InputError(f"shadows {shadows}: should be from 2 to {MOST_SHADOWS}")
    limits = Limits(workers, scheduler, timeout)
    started = time.perf_counter()
    most = {"start": MOST_COLLISIONS, "collision_impulse": MOST_COLLISIONS, "collision_contacts": MOST_COLLISIONS}
    names = tuple(
        f"{kind}:{n}" for kind, last in {**most, "event": MOST_EVENTS}.items() for n in range(1, last + 1)
    )
    runs = []
    for case in cases:
        for offset in (0.0, *_offsets(case.scenario, perturbations, shadows)):
            angle = case.scenario.initial.angle + float(offset)
            perturbed = case.scenario.replace(initial__angle=angle) if offset else case.scenario
            runs.append(Run({"case": case.name, "offset": float(offset)}, perturbed, names))
    frame = run_study(runs, out, limits=limits, on_progress=on_progress)
    found = tuple(judge(case, tuple(perturbations), frame[frame["case"] == case.name]) for case in cases)
    result = Predictability(name, found, time.perf_counter() - started)
    if out is None:
        return result
    table = pd.concat([part.collisions.assign(case=part.case.name) for part in found])
    return replace(result, report=report(result, command).write(Path(out), _data(result, command), table))


def judge(case: Case, perturbations: tuple[float, ...], frame: pd.DataFrame) -> CaseResult:
    """Judge a case by the frame of its runs, that of offset 0 first; quantities "start:1", "event:1", ..."""
    failing = frame["outcome"].isin(FAILURES)
    failed = tuple((row["offset"], row) for row in frame.iloc[1:][failing.iloc[1:]].to_dict("records"))
    shadows = frame.iloc[1:][~failing.iloc[1:]]
    frame = pd.concat([frame.iloc[:1], shadows])
    offsets = shadows["offset"].to_numpy(float)
    amplitudes = np.array([min(d for d in perturbations if abs(offset) <= d * (1.0 + 1e-9)) for offset in offsets])
    events, starts = _known(frame, "event"), _known(frame, "start")
    unit = float(events[0, 0]) if events.size and events[0, 0] > 0.0 else case.scenario.end_time
    # a perturbed run that came to its end without such a time would have had it later, which is a lower bound; one
    # that the physics stopped will never have it
    ends = np.where(shadows["outcome"] == Outcome.COMPLETED.label, shadows["stopped_at"], math.inf)[:, None]
    shifts, moved = (
        np.where(np.isnan(times[1:]), ends - times[0], np.abs(times[1:] - times[0])) for times in (starts, events)
    )
    scale = np.abs(offsets)[:, None] * unit
    growth, of_events = _largest(shifts / scale), _largest(moved / scale)
    bounded = np.isnan(starts[1:]).any(axis=0) & np.isfinite(growth)
    count = starts.shape[1]
    impulses, contacts = (_table(frame, f"collision_{kind}", count) for kind in ("impulse", "contacts"))
    known = np.where(np.isfinite(contacts), contacts, np.nan)
    collisions = pd.DataFrame(
        {
            "collision": np.arange(1, count + 1),
            "start": starts[0],
            "impulse": impulses[0],
            "fewest_contacts": pd.DataFrame(known).min().to_numpy(),
            "most_contacts": pd.DataFrame(known).max().to_numpy(),
            "growth": growth,
            "lower_bound": bounded,
            "verdict": [verdict_of(*pair) for pair in zip(growth, bounded, strict=True)],
        }
    )
    for d in perturbations:
        group = amplitudes == d
        collisions[f"start_by_{d:g}"] = _largest(shifts[group])
        collisions[f"impulse_by_{d:g}"] = _largest(np.abs(impulses[1:] - impulses[0])[group])
    return CaseResult(
        case=case,
        perturbations=perturbations,
        offsets=offsets,
        amplitudes=amplitudes,
        events=events[0],
        shadows=events[1:],
        growth=of_events,
        collisions=collisions,
        unit_time=unit,
        frame=frame,
        failed=failed,
    )


def verdict_of(growth: float, lower_bound: bool = False) -> str:
    """Return the verdict on a growth; from a lower bound only that something is not predictable."""
    if growth >= LARGE:
        return UNPREDICTABLE
    if lower_bound or math.isnan(growth):
        return UNKNOWN
    return PREDICTABLE if growth <= SMALL else SENSITIVE


def lines(result: Predictability) -> list[str]:
    """Return what a study found in lines, for a terminal."""
    found = []
    for case in result.cases:
        found += [f"{case.case.name}:", *(f"  {remark}" for remark in case.remarks)]
        for c in case.collisions.itertuples():
            growth = "" if math.isnan(c.growth) else f", growth {'at least ' * c.lower_bound}{c.growth:.3g}"
            found.append(f"  collision {c.collision}: starts at {c.start:.9g} s{growth}: {c.verdict}")
    return found


def _offsets(scenario: Scenario, perturbations: Sequence[float], shadows: int) -> Array:
    """Return the offsets of the perturbed runs (rad), on one side only where the other lies below the slope."""
    if not scenario.contact.enabled:
        raise InputError("contact.enabled = false: without contact there is nothing to predict")
    below, above = shadows // 2, shadows - shadows // 2
    both = np.concatenate([np.arange(-below, 0) / below, np.arange(1, above + 1) / above])
    one = np.arange(1, shadows + 1) / shadows

    def possible(offset: float) -> bool:
        try:
            scenario.replace(initial__angle=scenario.initial.angle + offset)
        except InputError:
            return False
        return True

    return np.concatenate(
        [d * (one if not possible(-d) else -one if not possible(d) else both) for d in perturbations]
    )


def _table(frame: pd.DataFrame, kind: str, most: int) -> Array:
    """Return the quantities "kind:1" to "kind:most", shape (runs, most)."""
    columns = [f"{kind}:{n}" for n in range(1, most + 1)]
    return np.asarray(frame.reindex(columns=columns), dtype=float)


def _known(frame: pd.DataFrame, kind: str) -> Array:
    """Return the times of a kind that the first run has, shape (runs, times)."""
    times = _table(frame, kind, MOST_EVENTS if kind == "event" else MOST_COLLISIONS)
    return times[:, np.isfinite(times[0])]


def _largest(values: Array) -> Array:
    """Return the largest over all perturbed runs, NaN where there are none."""
    return np.asarray(np.max(values, axis=0) if len(values) else np.full(values.shape[1:], math.nan))


# --- report


def _data(result: Predictability, command: str) -> dict[str, Any]:
    return {
        "study": result.name,
        "command": command,
        "rule": list(RULE),
        "cases": [
            {
                "name": case.case.name,
                "scenario": case.case.scenario.model_dump(mode="json"),
                "perturbations": list(case.perturbations),
                "offsets": case.offsets.tolist(),
                "unit_time": case.unit_time,
                "events": case.events.tolist(),
                "shadows": case.shadows.tolist(),
                "growth": case.growth.tolist(),
                "horizon": case.horizon,
                "failed": [
                    {"offset": offset, "outcome": row["outcome"], "message": row["message"]}
                    for offset, row in case.failed
                ],
                "collisions": case.collisions.to_dict("records"),
            }
            for case in result.cases
        ],
        "times": {"wall_time": result.seconds},
    }


def report(result: Predictability, command: str) -> Report:
    """Return the report; `command` repeats the study."""
    most = max((len(case.collisions) for case in result.cases), default=0)
    rows = []
    for case in result.cases:
        cells = [
            Cell(f"{c.verdict}, {_growth(c, 2)}".rstrip(", –"), _KINDS[c.verdict])
            for c in case.collisions.itertuples()
        ]
        rows.append([case.case.name, *cells, *[Cell("", "dim")] * (most - len(cells))])
    columns = ["", *(f"collision {n}" for n in range(1, most + 1))]
    return Report(
        "Predictability: runs with perturbed initial angles",
        "Do the times and impulses of an impact mean anything? Perturbed runs start at initial angles that differ "
        "by less than anyone can measure; where they part, nothing that follows is a number of the beam.",
        command,
        result.seconds,
        facts=[("runs", str(sum(1 + len(case.offsets) + len(case.failed) for case in result.cases)))],
        overview=[
            Table(columns, rows, "Verdicts, with the growth of the start of each macro-collision"),
            *([_growth_picture(result)] if any(case.events.size for case in result.cases) else []),
            Fold("How a verdict is found", [Text(text) for text in RULE]),
        ],
        sections=[_section(case) for case in result.cases],
    )


def _growth(c: Any, digits: int) -> str:
    return ("≥ " if c.lower_bound else "") + number(c.growth, digits)


def _growth_picture(result: Predictability) -> Picture:
    """Draw the largest growth until each event, a line a case."""
    caption = "Largest growth of the difference of an event's time, from unperturbed to perturbed run, until then."
    with picture(caption, height=3.9) as drawn:
        axes = drawn.figure.subplots()
        for index, case in enumerate(result.cases):
            growth = np.maximum.accumulate(np.where(np.isfinite(case.growth), case.growth, 0.0))
            colour = SERIES[index % len(SERIES)]
            axes.step(case.events, growth, where="post", color=colour, linewidth=1.4, label=case.case.name)
        for level, words in ((SMALL, "predictable below"), (LARGE, "not predictable above")):
            axes.axhline(level, color=GREY, linewidth=0.9, linestyle="--")
            place: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
            axes.annotate(words, (0.0, level), xytext=(4, 3), fontsize=8.5, color=GREY, **place)
        axes.set(xlabel="time of the event (s)", ylabel="largest growth so far", yscale="log")
        drawn.figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return drawn


def _section(case: CaseResult) -> Section:
    blocks: list[Any] = [Text(case.case.text)] if case.case.text else []
    blocks += [Text(f"{remark[0].upper()}{remark[1:]}.") for remark in case.remarks]
    if len(case.collisions):
        if math.isfinite(case.horizon):
            blocks.append(Text(f"The last event that is predicted is at {case.horizon:.6g} s."))
        blocks += [_events_picture(case), _collision_table(case)]
    return Section(case.case.name, blocks)


def _events_picture(case: CaseResult) -> Picture:
    """Draw the differences of the event times, and the events themselves, a row a run."""
    caption = (
        "Left: differences of the event times of the perturbed runs from those of the unperturbed one. Right: "
        "every event of every run."
    )
    with picture(caption, height=4.2) as drawn:
        left, right = drawn.figure.subplots(1, 2, width_ratios=(1.0, 1.35))
        colours = {d: SERIES[k % len(SERIES)] for k, d in enumerate(sorted(case.perturbations))}
        for d, times in zip(case.amplitudes, case.shadows, strict=True):
            shift = np.abs(times - case.events)
            left.plot(case.events, np.where(shift > 0.0, shift, np.nan), "-", color=colours[d], lw=0.8)
        for d, colour in colours.items():
            left.plot([], [], color=colour, label=f"initial angle ± {d:g} rad")
        left.set(xlabel="time of the event (s)", ylabel="difference from the unperturbed run (s)", yscale="log")
        order = np.argsort(case.offsets)
        shades = ["black", *(colours[d] for d in case.amplitudes[order])]
        for height, (times, shade) in enumerate(zip([case.events, *case.shadows[order]], shades, strict=True)):
            right.vlines(times[np.isfinite(times)], height - 0.36, height + 0.36, color=shade, linewidth=0.9)
        right.set(xlabel="events (s)", ylabel="runs, by initial angle; black: unperturbed", yticks=[])
        drawn.figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return drawn


def _collision_table(case: CaseResult) -> Table:
    by = [f"{d:g}" for d in case.perturbations]
    rows = []
    for c in case.collisions.to_dict("records"):
        contacts = dict.fromkeys(f"{c[name]:g}" for name in ("fewest_contacts", "most_contacts"))
        shifts, changes = ([cell(c[f"{name}_by_{d}"], 2) for d in by] for name in ("start", "impulse"))
        growth = ("≥ " if c["lower_bound"] else "") + number(c["growth"], 3)
        texts = [Cell(text, "number") for text in (" to ".join(contacts), growth)]
        verdict = Cell(c["verdict"], _KINDS[c["verdict"]])
        numbers = [c["collision"], cell(c["start"], 9), *shifts, cell(c["impulse"], 7), *changes]
        rows.append([*numbers, *texts, verdict])
    starts, impulses = ([f"by {d} rad ({unit})" for d in by] for unit in ("s", "N s"))
    columns = ["collision", "start (s)", *starts, "impulse (N s)", *impulses]
    caption = (
        "Macro-collisions, and how far the perturbed runs move them; where one ends before a start, the rest of "
        "its time is a lower bound"
    )
    return Table([*columns, "contacts", "growth", "verdict"], rows, caption)

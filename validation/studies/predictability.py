"""Sensitivity to the initial angle: a sweep over it, and the growth of what it moves, see `RULE`.

Perturbed runs start at angles that differ by up to a hundred-millionth and a millionth of a radian, which nobody
could measure; by less where the beam starts so close to an obstacle that it would touch it, or pass to its other
side.
"""

from __future__ import annotations

import cmath
import math
import os
import time
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from oblique_impact.beam.frequencies import clustering_time
from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import writing
from oblique_impact.progress import OnProgress, silent
from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.scenario.scenario import Scenario, require_scenario
from oblique_impact.validation.report import Column, Picture, picture
from oblique_impact.validation.result import Result
from oblique_impact.validation.runs import Array
from oblique_impact.validation.studies.parallel import check_limits
from oblique_impact.validation.studies.study import FAILURES, StudyRun, run_study

PREDICTABLE, SENSITIVE, UNPREDICTABLE, UNKNOWN = "predictable", "sensitive", "not predictable", "no verdict"
#: growths that separate the verdicts: what the motion carries along is about 1, rounding is 1e-16 of a time
SMALL, LARGE = 10.0, 1e3
#: quantities that are measured, and how many of each at most
_ASKED = {"start": 20, "collision_impulse": 20, "collision_contacts": 20, "event": 400}
#: rad
PERTURBATIONS = (1e-8, 1e-6)
_CLOSED = 1e-12  # of the length
_KINDS = {PREDICTABLE: "pass", SENSITIVE: "partly", UNPREDICTABLE: "fail", UNKNOWN: "dim"}
#: the smallest perturbation leaves starts and impulses their digits
_COLUMNS = {
    "collision": Column(),
    "start": Column("start (s)", within="start_spread"),
    "impulse": Column("normal impulse (N s)", within="impulse_spread"),
    "start_spread": Column("spread of starts (s)", digits=2, page=True),
    "impulse_spread": Column("spread of impulses (N s)", digits=2, page=True),
    "fewest_contacts": Column(),
    "most_contacts": Column(),
    "growth": Column(digits=3),
    "lower_bound": Column("at least", page=True),
    "verdict": Column(),
}
RULE = (
    "The growth of a time t is max |t(θ₀ + d) − t(θ₀)| / (|d| T) over runs with perturbed initial angles, T the "
    "time of the first touch-down, at least the clustering time of contacts: about 1 if the motion carries a "
    "difference along, more if each contact magnifies it. d is less than half of what would close an open gap.",
    f"A macro-collision is predictable up to a growth of {SMALL:g} of its start, sensitive up to {LARGE:g}, and "
    "not predictable from there on or if the physics stops a perturbed run before it: rounding, a tolerance or "
    "another compiler move it as far, and its spread is given instead. A perturbed run that reaches its end time "
    f"before it gives a lower bound, which below {LARGE:g} is no verdict; one that failed, by an error or a "
    "timeout, is left out and named.",
    "This is said of the model as it stands. A coarse one may be predictable and far from its limit: its "
    "refinement shows that.",
)


class Growths(NamedTuple):
    """What a sweep over the initial angle says of a scenario's events and macro-collisions."""

    #: a row for each macro-collision of the unperturbed run, by its number from 1: start (s), impulse (N s), the
    #: fewest and the most contacts among the runs, growth of the start (infinite if the physics stopped a
    #: perturbed run before it, NaN without any), whether that is a lower bound only, as a perturbed run ended
    #: before, verdict, and the largest differences of start and impulse by the smallest perturbation
    collisions: pd.DataFrame
    #: a row for each event: time (s) and growth, bounds and infinities as in `collisions`
    events: pd.DataFrame
    #: T (s)
    unit_time: float


def predictability(
    scenario: Scenario,
    *,
    perturbations: Sequence[float] = PERTURBATIONS,
    out: str | os.PathLike[str] | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    timeout: float | None = None,
    name: str = "scenario",
    on_progress: OnProgress = silent,
) -> Result:
    """Judge for each macro-collision whether its numbers are determined, by runs with perturbed initial angles.

    Parameters
    ----------
    scenario : Scenario
        What is tried.
    perturbations : sequence of float
        Largest changes of the initial angle (rad), of four runs each; see `perturbed_runs`.
    out : path, optional
        Folder for report.html, results.json and results.csv, where an interrupted study goes on.
    scheduler, workers, timeout, on_progress
        As for :func:`~oblique_impact.validation.studies.study.run_study`.
    name : str
        What the scenario is called in the report.

    Returns
    -------
    Result
        A row for each macro-collision, by its number, and the tables `events` and `runs`; see `Growths`.

    Raises
    ------
    InputError
        In one line if a perturbation is not possible, or there is no contact.

    Examples
    --------
    >>> from oblique_impact import Scenario
    >>> from oblique_impact.validation import predictability
    >>> soft = Scenario.builtin("elastic-stop").replace(end_time=0.4)
    >>> predictability(soft, perturbations=[1e-6], workers=1)[1].verdict
    'predictable'
    """
    runs, started = perturbed_runs(scenario, perturbations), time.perf_counter()
    check_limits(scheduler, workers, timeout)
    with writing(out):
        frame = run_study(
            runs, out, scheduler=scheduler, workers=workers, timeout=timeout, on_progress=on_progress
        )
        result = _result(scenario, frame, name, time.perf_counter() - started)
        if out is not None:
            result.save(out)
    return result


def perturbed_runs(
    scenario: Scenario, perturbations: Sequence[float] = PERTURBATIONS, count: int = 4
) -> list[StudyRun]:
    """Return the runs of a sweep over the initial angle: that of the scenario, then the perturbed ones.

    Parameters
    ----------
    scenario : Scenario
        What is perturbed.
    perturbations : sequence of float
        Largest changes of the initial angle (rad); all are less in proportion where half of the least gap that is
        open at the start is turned away by less.
    count : int
        Runs per perturbation d, an even number: evenly from -d to d without 0, but for those that would begin
        below the slope.
    """
    require_scenario(scenario, "predictability")
    if not perturbations or not all(0.0 < d <= 0.1 for d in perturbations):
        given = "".join(f" {d:g}" for d in perturbations)
        raise InputError(f"perturbations{given}: should be angles in rad, above 0 and at most 0.1")
    if not scenario.contact.enabled:
        raise InputError("contact.enabled = false: without contact there is nothing to predict")
    names = tuple(f"{kind}:{n}" for kind, last in _ASKED.items() for n in range(1, last + 1))
    parts = np.delete(np.linspace(-1.0, 1.0, count + 1), count // 2)
    scale, runs = min(1.0, 0.5 * closing_turn(scenario) / max(perturbations)), list[StudyRun]()
    for offset in [0.0, *(scale * np.outer(perturbations, parts)).ravel().tolist()]:
        angle = scenario.initial.angle + offset
        try:
            perturbed = scenario.replace(initial__angle=angle) if offset else scenario
        except InputError:  # below the slope
            continue
        runs.append(StudyRun({"initial.angle": angle}, perturbed, names))
    return runs


def closing_turn(scenario: Scenario) -> float:
    """Return the least angle (rad) by which the straight beam at the start could turn to close an open gap.

    It is gap over lever arm of each place that can touch, infinite if none is open.  A gap of less than 1e-12 of
    the length is closed.
    """
    angle, hub, length = scenario.initial.angle, scenario.root.hub_radius, scenario.beam.length
    reach, turns, axis = hub + length, [math.inf], scenario.root_axis
    pivot = complex(*scenario.initial.position)  # the middle of a free beam, the axis of another's root
    for side in scenario.sides:
        for x in scenario.beam_points:
            gap, along = side.gap_and_place(hub + x, angle, scenario.half_depth, axis)
            if side.is_beside(along) and gap > _CLOSED * length:
                turns.append(gap / max(abs(axis + (hub + x) * cmath.exp(1j * angle) - pivot), gap))
    for point in scenario.obstacle_points:
        arm = abs(complex(point.x, point.y) - pivot)
        gap = point.distance(hub, reach, angle, axis) - point.radius - scenario.half_depth
        if gap > _CLOSED * length:
            turns.append(gap / max(arm, gap))
    return min(turns)


def judge(scenario: Scenario, frame: pd.DataFrame) -> Growths:
    """Judge a scenario by the frame of a sweep over its initial angle, which was asked for event:1 and start:1.

    More such quantities, "collision_impulse:1" and "collision_contacts:1" are taken as far as they are there.
    """
    turned, failed = frame["initial.angle"] != scenario.initial.angle, frame["outcome"].isin(FAILURES)
    rows = pd.concat([frame[~turned], frame[turned & ~failed]])
    offsets = (rows["initial.angle"] - scenario.initial.angle).abs().to_numpy(float)[1:]

    def table(kind: str) -> Array:
        """Return the quantities "kind:1", "kind:2", ... of all runs, shape (runs, numbers)."""
        columns = [f"{kind}:{n}" for n in range(1, _ASKED[kind] + 1)]
        return np.asarray(rows.reindex(columns=columns), dtype=float)

    events, starts = (times[:, np.isfinite(times[0])] for times in (table("event"), table("start")))
    count = starts.shape[1]
    impulses, contacts = table("collision_impulse")[:, :count], table("collision_contacts")[:, :count]
    begins = events.size and events[0, 0] > 0.0
    unit = max(float(events[0, 0]), clustering_time(scenario)) if begins else scenario.end_time
    # a perturbed run that came to its end without such a time would have had it later, which is a lower bound; one
    # that the physics stopped will never have it
    completed = rows["outcome"] == Outcome.COMPLETED.label
    ends = rows["stopped_at"].where(completed, math.inf).to_numpy()[1:, None]
    shifts, moved = (
        np.where(np.isnan(times[1:]), ends - times[0], np.abs(times[1:] - times[0])) for times in (starts, events)
    )
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
    near = offsets <= 2.0 * np.min(offsets, initial=math.inf) * (1.0 + 1e-6)
    collisions["start_spread"] = _largest(shifts[near])
    collisions["impulse_spread"] = _largest(np.abs(impulses[1:] - impulses[0])[near])
    growths = pd.DataFrame({"time": events[0], "growth": _largest(moved / scale)})
    return Growths(collisions.set_index("collision"), growths, unit)


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


# --- result


def _result(scenario: Scenario, frame: pd.DataFrame, name: str, seconds: float) -> Result:
    found = judge(scenario, frame)
    return Result(
        "Predictability: runs with perturbed initial angles",
        "Sensitivity of times and impulses of the impacts to the initial angle. Perturbed runs start at angles "
        "that differ by less than can be measured; where they part, the scenario does not determine what follows.",
        "collisions",
        found.collisions,
        _KINDS,
        _COLUMNS,
        "Macro-collisions, and how far perturbed runs move them; where one ends before a start, the rest of its "
        "time is a lower bound. Starts and impulses have the digits that the smallest perturbation leaves.",
        tables={"events": found.events, "runs": frame[["initial.angle", "outcome", "message", "warnings"]]},
        remarks=remarks_of(scenario, frame),
        rule=RULE,
        scenarios={name: scenario},
        about={"unit_time": found.unit_time},
        facts=[("runs", str(len(frame)))],
        seconds=seconds,
        overview=lambda _: [_growth_picture(found.events)] if len(found.events) else [],
    )


def remarks_of(scenario: Scenario, frame: pd.DataFrame) -> list[str]:
    """Return sentences: why there are no collisions, which perturbed runs are left out, warnings of the run."""
    angle, remarks = scenario.initial.angle, list[str]()
    turned = frame["initial.angle"] != angle
    (run,) = frame[~turned].to_dict("records")
    if run["outcome"] in FAILURES:
        remarks.append(f"the unperturbed run failed: {run['outcome']}: {run['message']}")
    elif math.isnan(run["start:1"]):
        words = ": ".join(filter(None, (run["outcome"], run["message"])))
        remarks.append(f"no contact until {run['stopped_at']:.6g} s: {words}")
    remarks += [
        f"perturbed run at {row['initial.angle'] - angle:.3g} rad left out: {row['outcome']}: {row['message']}"
        for row in frame[turned & frame["outcome"].isin(FAILURES)].to_dict("records")
    ]
    return remarks + [f"warning: {warning}" for warning in run["warnings"].splitlines()]


def _growth_picture(events: pd.DataFrame) -> Picture:
    """Draw the largest growth until each event."""
    caption = "Largest growth of the difference of an event's time, from unperturbed to perturbed run, until then."
    with picture(caption, height=3.9) as drawn:
        axes = drawn.figure.subplots()
        growth = events["growth"].replace(math.inf, math.nan).cummax()
        axes.step(events["time"], growth, where="post", linewidth=1.4, color=SERIES[0])
        for level, words, up in ((SMALL, "predictable below", -11), (LARGE, "not predictable above", 3)):
            axes.axhline(level, color=GREY, linewidth=0.9, linestyle="--")
            place: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
            axes.annotate(words, (0.0, level), xytext=(4, up), fontsize=8.5, color=GREY, **place)
        axes.set(xlabel="time of the event (s)", ylabel="largest growth until then", yscale="log")
        axes.set_ylim(bottom=min(axes.get_ylim()[0], 0.5 * SMALL))
    return drawn

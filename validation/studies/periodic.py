"""Steady response of a beam to a harmonic base or force: period, impacts per period, stroboscopic samples.

The state of the beam at a whole period of what drives it is a map of the state one period before.  A run is
marched from period to period until these stroboscopic samples repeat; what is measured is the history of the
periods after them.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial
from typing import Annotated, Literal

import numpy as np
import pandas as pd
from pydantic import Field

from oblique_impact.beam.bent_beam import BentBeam
from oblique_impact.contact.state import State
from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import writing
from oblique_impact.history.history import History
from oblique_impact.history.interpolation import RATES
from oblique_impact.progress import Status
from oblique_impact.renders import panels
from oblique_impact.renders.style import SERIES
from oblique_impact.scenario.messages import one_of, refused
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.section import InputSection
from oblique_impact.scenario.sections import BaseSection, ForceSection
from oblique_impact.simulation import compute_history as simulate
from oblique_impact.validation.report import Column, Picture, picture
from oblique_impact.validation.result import Result
from oblique_impact.validation.studies.quantities import VARIABLES, GapError, Quantity, quantity

#: largest whole number in the ratio of two frequencies that have a period in common
_RATIO = 64
#: samples of a period from which the size of the motion is judged while it settles
_PER_PERIOD = 32
#: periods that are measured of a motion that does not repeat
_MEASURED = 32
#: whole periods of a motion that does not repeat that are kept for its section, and multiples of the drive's
#: frequency in a spectrum, from so many samples of a period
_SECTION, HARMONICS, _PER_LINE = 512, 10, 128
#: how far changes may be from those of a linear map, of which the limit is taken
_LINEAR = 0.02
#: a range over a period that changes by this part of the larger one within a bracket jumps
JUMP = 0.1
#: a period longer than one is taken if each shorter one misses by so many times the tolerance.  So a free
#: vibration that repeats by chance does not pass for it, if it decays by more than 1/100 within it
_CLEARLY = 100.0

#: numbers of a response, besides least and largest value of what is sampled
_NUMBERS = ("period", "transient", "impacts_per_period", "peak:bending_stress", "supplied", "energy_lost")
_COLUMNS = {
    "quantity": Column("symbol", code=True),
    "meaning": Column("quantity", text=True, page=True),
    "value": Column(instead=lambda row: "none" if (row["quantity"], row["value"]) == ("period", 0.0) else ""),
    "unit": Column(),
    "verdict": Column(),
}

MotionState = History | tuple[np.ndarray, np.ndarray]


class PeriodicSection(InputSection):
    """How a steady state is sought, and continued along the last axis of a sweep; periods are those of the drive.

    `directions` of the sweep: "up" begins with the first value of that axis and takes each next one from the state
    in which the one before has ended, "down" begins with the last.  `longest` is the longest period that is
    sought, `transient` how many periods the motion has to settle.  A motion repeats if at whole periods no point
    of the beam is farther from where it was, and no velocity, than `tolerance` of the largest ones.  The default
    lies far above the error of the event scheme, about 1e-8 a period; and where a motion settles by 6 % a period,
    as with 1 % of critical damping, 1.6e-4 of it is still to come then, less than the width of a line in a
    diagram.  `sample` is the variable over time that is kept at whole periods.  Where the ways up and
    down differ most, `starts` times `starts` states around their two are followed, to see to which each comes.
    """

    directions: Annotated[tuple[Literal["up", "down"], ...], Field(strict=False, min_length=1, max_length=2)] = (
        "up",
        "down",
    )
    longest: Annotated[int, Field(ge=1, le=64)] = 8
    transient: Annotated[int, Field(ge=1, le=100_000)] = 400
    tolerance: Annotated[float, Field(gt=0.0, lt=1.0)] = 1e-5
    sample: str = "deflection"
    starts: Annotated[int, Field(ge=0, le=40)] = 0

    def conflicts(self) -> Iterator[tuple[str, str]]:
        """Yield a direction that is given twice, and a sample that is no variable over time."""
        if len(set(self.directions)) < len(self.directions):
            yield "directions", "each once"
        if self.sample not in VARIABLES or self.sample == "energy":
            yield "sample", one_of(self.sample, [name for name in VARIABLES if name != "energy"])
        if self.starts and len(self.directions) < 2:
            yield "starts", "needs both directions, between whose states the starts lie"
        if self.transient < 2 * self.longest:
            yield "transient", f"should be at least {2 * self.longest}, twice the longest period, to see it repeat"


def drive_period(scenario: Scenario) -> float:
    """Return the period (s) of what drives a beam: of its base, its harmonic forces, or what they have in common.

    Raises InputError, in one line, for a scenario without such a period, or that no steady state is sought of.
    """
    base, root = scenario.base, scenario.root
    drives: dict[str, BaseSection | ForceSection] = {"base": base} if base.is_shaken else {}
    drives |= {f"forces.{number}": force for number, force in enumerate(scenario.forces, start=1) if force.acts}
    for name, drive in drives.items():
        if drive.table or drive.sweep_rate != 0.0:
            words = "should be constant, or harmonic with one frequency"
            raise InputError(f"{name}: periodic response: {words}, without {name}.sweep_rate and {name}.table")
    driven = {f"{name}.frequency": drive.frequency for name, drive in drives.items() if drive.frequency > 0.0}
    if not driven:
        words = "needs base.acceleration and base.frequency, or a harmonic force of [[forces]]"
        raise InputError(f"periodic response: {words}")
    if root.kind == "driven" and (root.profile != "hold" or root.spin_rate != 0.0):
        raise refused("root.profile", root.profile, 'periodic response needs a driven root that is held, "hold"')
    if scenario.is_absolute:
        words = 'periodic response needs "modal" or "fem", which start from a given state'
        raise refused("discretization.method", scenario.discretization.method, words)
    (first, lowest), *others = driven.items()
    common = Fraction(1)  # of the first frequency
    for name, frequency in others:
        ratio = Fraction(frequency / lowest).limit_denominator(_RATIO)
        if ratio == 0 or abs(float(ratio) * lowest / frequency - 1.0) > 1e-9:
            words = f"{first} = {lowest:g} and {name} = {frequency:g} have no period in common"
            raise InputError(f"periodic response: {words}: no ratio of whole numbers up to {_RATIO}")
        common = Fraction(
            math.gcd(common.numerator * ratio.denominator, ratio.numerator * common.denominator),
            common.denominator * ratio.denominator,
        )
    return 1.0 / (lowest * float(common))


def periodic_response(
    scenario: Scenario,
    initial_state: MotionState | None = None,
    settings: PeriodicSection = PeriodicSection(),
    *,
    out: str | os.PathLike[str] | None = None,
    on_progress: Callable[[Status], None] | None = None,
) -> Result:
    """Find the steady response of a beam to a harmonic base or force.

    Parameters
    ----------
    scenario, initial_state, settings, on_progress
        As for `steady_state`.
    out : path, optional
        Folder for report.html, results.json and results.csv; without it nothing is written.

    Returns
    -------
    Result
        A row for each number of the response; the table `samples` at whole periods, and the history of one period,
        ``histories["response"]``.

    Raises
    ------
    InputError
        In one line, as `steady_state`, or for a folder that cannot be written.
    """
    started, period = time.perf_counter(), drive_period(scenario)
    with writing(out):
        history = steady_state(scenario, initial_state, settings, on_progress)
        found = history.summary.get("periodic", {})
        verdict = "periodic" if found.get("period") else "not periodic"
        verdict = verdict if found else history.outcome.label
        rows = [
            {
                "quantity": q.name,
                "value": _value(q, history),
                "unit": q.unit,
                "verdict": verdict,
                "meaning": q.meaning,
            }
            for q in map(quantity, (*_NUMBERS, f"min:{settings.sample}", f"max:{settings.sample}"))
        ]
        samples = pd.DataFrame({settings.sample: found.get("samples", [])}).rename_axis("period")
        samples.attrs["units"] = {settings.sample: VARIABLES[settings.sample][0]}
        result = Result(
            "Steady response",
            f"At {1.0 / period:g} Hz, after {found.get('transient', 0)} periods.",
            "quantities",
            pd.DataFrame(rows).set_index("quantity"),
            {"periodic": "pass", "not periodic": "partly"} | {outcome.label: "fail" for outcome in Outcome},
            _COLUMNS,
            "The response.",
            tables={"samples": samples},
            remarks=[f"warning: {text}" for text in history.summary.get("warnings", ())],
            scenarios={"scenario": scenario},
            histories={"response": history},
            about={"settings": settings},
            seconds=time.perf_counter() - started,
            overview=lambda _: [_picture(history, settings.sample, period)],
        )
        if out is not None:
            result.save(out)
    return result


def _value(q: Quantity, history: History) -> float:
    try:
        return q.measure(history)
    except GapError:
        return math.nan


def _picture(history: History, name: str, period: float) -> Picture:
    """Draw a variable over the measured periods, with its values at whole periods."""
    runs = panels.Runs([history], ["response"])
    curves, clock = panels.variable(runs, name, name.replace("_", " ")), panels.clock(0.0, history.end_time)
    with picture(f"{VARIABLES[name][1].capitalize()}; dots are whole periods of the base.") as drawn:
        axes = drawn.figure.subplots()
        panels.draw_curves(axes, curves, clock)
        whole = np.arange(0.0, history.end_time + 0.5 * period, period)
        axes.plot(
            clock.at(whole),
            np.interp(clock.at(whole), *axes.lines[0].get_data()),
            "o",
            color=SERIES[1],
            clip_on=False,
        )
    return drawn


def steady_state(
    scenario: Scenario,
    initial_state: MotionState | None = None,
    settings: PeriodicSection = PeriodicSection(),
    on_progress: Callable[[Status], None] | None = None,
) -> History:
    """Let a beam under a harmonic base or force settle, and return the history of one period of its response.

    Parameters
    ----------
    scenario : Scenario
        With a harmonic base or force; its `end_time` does not matter.
    initial_state : History or pair of ndarray, optional
        As for :func:`~oblique_impact.simulation.simulate`, at the phase of t = 0: the last state of another
        response continues it.
    settings : PeriodicSection
        What counts as periodic.
    on_progress : callable, optional
        As for :func:`~oblique_impact.simulation.simulate`.

    Returns
    -------
    History
        The steady state from t = 0 over a whole number of periods of the drive: one period of the response, or 32
        of a response that does not repeat.  ``summary["periodic"]`` holds `period` (of the response, None: none up
        to `longest`), `transient` (periods before), `measured` (periods of the history), `drive_period` (s),
        `impacts_per_period` (contacts that begin, per period of the drive), and of the variable `sample`, in SI
        units, `least` and `largest`, `samples` at the last `measured` whole periods, `section` (value and rate at
        whole periods), `spectrum` (mean, and amplitudes at multiples of 1/(`measured` periods)).  It is missing
        where a run has ended early, which `outcome` names.

    Raises
    ------
    InputError
        In one line, for a scenario whose drive has no period, or as :func:`~oblique_impact.simulation.simulate`.
    """
    period, count = drive_period(scenario), 2 * settings.longest
    located = scenario.solver.scheme == "event"
    settling = scenario.replace(end_time=count * period, solver__output_interval=period / _PER_PERIOD)
    # whole periods, which steps of a given length would miss
    ends = () if located else tuple(number * period for number in range(1, count))
    # a held beam does not swing round to the other side of a point: where it is there, it is pressed past it
    march = partial(simulate, on_progress=on_progress, keeps_sides=scenario.root.kind == "driven")
    section, found, last = list[tuple[float, float]](), 0, initial_state
    while not found and len(section) < settings.transient:
        try:
            history = march(settling, initial_state=initial_state, stops=ends)
        except InputError:
            if initial_state is last:
                raise
            initial_state = last  # the limit that was found lies inside of a stop
            continue
        if history.outcome is not Outcome.COMPLETED:
            return history
        motion, whole = _motion(history), _whole_periods(history, period)
        section += _section(history, settings.sample, whole)
        allowed = settings.tolerance * np.abs(motion - motion.mean(axis=0)).max(axis=(0, 2))
        found = _period(motion[whole], allowed)
        last = history
        initial_state = (None if found else _limit(history, whole, settings.longest)) or history
    measured = found or _MEASURED
    response = scenario.replace(end_time=measured * period)
    history = march(response, initial_state=initial_state)
    if history.outcome is Outcome.COMPLETED:
        begun = sum(contact.start > 0.0 for contact in history.contacts)
        passed = section[-measured:] if found else section[len(section) // 2 :]
        values = history[settings.sample].values
        history.summary["periodic"] = {
            "period": found or None,
            "transient": len(section),
            "measured": measured,
            "drive_period": period,
            "least": float(values.min()),
            "largest": float(values.max()),
            "impacts_per_period": begun / measured,
            "samples": [value for value, _ in section[-measured:]],
            "section": [list(point) for point in passed[-_SECTION:]],
            "spectrum": _spectrum(history, settings.sample, found, measured, period),
        }
    return history


def bracket_jump(
    scenarios: Callable[[float], Scenario],
    ends: tuple[float, float],
    initial_state: MotionState,
    settings: PeriodicSection = PeriodicSection(),
    within: float = 1e-3,
) -> tuple[float, float, float] | None:
    """Bracket the value of a key at which a steady response jumps, by bisection.

    Parameters
    ----------
    scenarios : callable
        Takes a value, returns the scenario with it.
    ends : tuple of float
        Value before the jump, and behind it.
    initial_state : History or pair of ndarray
        The state in which the response before the jump has ended; each value in between goes on from the last one
        that is still on its side.
    settings : PeriodicSection
        What counts as periodic, and the variable from whose range over a period the side is told.
    within : float
        Width of the bracket, relative to the value.

    Returns
    -------
    tuple of float, or None
        Last value before the jump, first one behind it, and the change of the range (SI units); None if the range
        changes by less than a tenth of itself across the bracket: it is then no jump.

    Raises
    ------
    InputError
        In one line, as `steady_state`.
    """

    def swing(value: float) -> tuple[History, float]:
        history = steady_state(scenarios(value), state, settings)
        return history, float(np.ptp(history[settings.sample].values))

    (before, behind), state = ends, initial_state
    (state, here), (_, there) = swing(before), swing(behind)
    while abs(behind - before) > within * max(abs(before), abs(behind)):
        middle = 0.5 * (before + behind)
        history, found = swing(middle)
        if abs(found - here) < abs(found - there):
            before, state, here = middle, history, found
        else:
            behind, there = middle, found
    jumps = abs(there - here) > JUMP * max(here, there)
    return (before, behind, there - here) if jumps else None


def _section(history: History, name: str, whole: np.ndarray) -> list[tuple[float, float]]:
    """Return a variable and its rate at whole periods; the rate is NaN of one whose rate is not sampled."""
    values, rates = history[name].values[whole], np.full(whole.size, math.nan)
    if name == "deflection":  # at the contact point, a station more often than not
        assert history.scenario is not None
        (at,) = np.nonzero(np.isclose(history["station"].values, history.scenario.contact.point))
        rates = history["uy_dot"].values[whole, at[0]] if at.size else rates
    elif name in RATES:
        rates = history[RATES[name]].values[whole]
    return list(zip(values.tolist(), rates.tolist(), strict=True))


def _spectrum(history: History, name: str, found: int, measured: int, period: float) -> list[float]:
    """Return the mean of a variable, and its amplitudes at the multiples of the drive's frequency over `measured`.

    Those of a motion that does not repeat (`found` = 0) are seen through a Hann window.
    """
    count = measured * _PER_LINE
    at = np.arange(count) * (measured * period / count)
    values = np.interp(at, history["time"].values, history[name].values)
    window = np.ones(count) if found else np.hanning(count + 1)[:-1]
    lines = np.abs(np.fft.rfft(values * window)) / window.sum()
    lines[1:] *= 2.0
    found_lines: list[float] = lines[: measured * HARMONICS + 1].tolist()
    return found_lines


def _limit(history: History, whole: np.ndarray, longest: int) -> tuple[np.ndarray, np.ndarray] | None:
    """Return the state to which those at whole periods tend, by the linear map that leads from each to the next.

    So a vibration that dies away slowly is skipped (Aitken's method, for vectors).  None where the map does not
    describe the last states or does not shrink what is left, as behind a bifurcation, or where a stop is closed.
    """
    q, qd = history["q"].values, history["qd"].values
    if (history["state"].values[whole] != State.FREE).any():
        return None
    start = np.concatenate([[0], whole])
    parts = [values[start] / (np.ptp(values[start], axis=0).max() or 1.0) for values in (q, qd)]
    states = np.concatenate(parts, axis=1)
    for stride in range(1, longest + 1):
        changes = np.diff(states[::-1][::stride][::-1], axis=0)
        rank = min((len(changes) - 1) // 2, changes.shape[1])
        if rank < 1:
            return None
        directions = np.linalg.svd(changes, full_matrices=False)[2][:rank].T
        steps = changes @ directions
        matrix = np.linalg.lstsq(steps[:-1], steps[1:], rcond=1e-8)[0]
        apart = np.abs(steps[:-1] @ matrix - changes[1:] @ directions)
        left = np.abs(changes[1:] - steps[1:] @ directions.T)
        wrong = max(apart[-rank:].max(), left[-rank:].max())
        if wrong > _LINEAR * np.abs(changes[-rank:]).max():
            continue
        if np.abs(np.linalg.eigvals(matrix)).max() >= 1.0:
            return None
        rest = directions @ np.linalg.solve(np.eye(rank) - matrix.T, steps[-1] @ matrix)
        return tuple(
            values[-1] + share * (np.ptp(values[start], axis=0).max() or 1.0)
            for values, share in zip((q, qd), np.split(rest, [q.shape[1]]), strict=True)
        )
    return None


def _motion(history: History) -> np.ndarray:
    """Return places x + i y (m) and velocities (m/s) of the stations, (samples, 2, stations)."""
    assert history.scenario is not None
    names = "theta", "theta_dot", "station", "ux", "uy", "ux_dot", "uy_dot"
    bent = BentBeam.of_history(history.scenario, {name: history[name].values for name in names})
    return np.stack([bent.point(), bent.velocity()], axis=1)


def _whole_periods(history: History, period: float) -> np.ndarray:
    """Return the last samples at whole periods, from 1 to the end."""
    times = history["time"].values
    ends = (np.arange(1, round(times[-1] / period) + 1) + 1e-9) * period
    return np.searchsorted(times, ends, side="right") - 1


def _period(motions: np.ndarray, allowed: np.ndarray) -> int:
    """Return after how many samples (samples, 2, stations) a motion repeats; 0 if it does not, or not clearly.

    The last samples are compared with as many before; `allowed` are the differences (2,) of places and velocities.
    """
    missed = math.inf
    for p in range(1, len(motions) // 2 + 1):
        apart = np.abs(motions[-p:] - motions[-2 * p : -p]).max(axis=(0, 2))
        if np.all(apart <= allowed):
            return p if missed >= _CLEARLY else 0
        missed = min(missed, float(np.max(apart / allowed)))
    return 0

"""What the page knows of a run: arrays as base64, and a few facts in words and numbers."""

from __future__ import annotations

import base64
import math
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import to_hex
from numpy.typing import NDArray

from oblique_impact.contact.state import State
from oblique_impact.errors import InputError, Outcome
from oblique_impact.history.history import History
from oblique_impact.history.sample_times import first_sample, last_sample
from oblique_impact.problem import stop_of
from oblique_impact.scenario.scenario import Scenario
from renders.geometry import BeamGeometry
from renders.player.selection import chart_points, frames, listed_events
from renders.slope import drawn_slope
from renders.story import Story, story_of
from renders.style import STATE_COLOURS
from renders.themes import LIGHT
from renders.timeline import TimeMap

Array = NDArray[np.float64]

_STOPS = 33  # of the colour map

#: variables of the history that the page carries at the points of its charts, and their names there
SERIES = {
    "lambda_n": "normal",
    "lambda_tau": "tangential",
    "energy_kinetic": "kinetic",
    "energy_elastic": "elastic",
    "energy_gravity": "gravity",
    "deflection": "deflection",
    "gap": "gap",
    "slip_rate": "slip_rate",
}
_NEEDED = ("time", "station", "state", "bending_stress", *SERIES)


@dataclass(frozen=True)
class Payload:
    """The two things that the page embeds.

    Attributes
    ----------
    arrays : dict
        Per name its `type` (f4, f8, i4, u1), `shape` and little-endian `data` as base64.
    facts : dict
        Everything that is not an array.
    """

    arrays: dict[str, dict[str, Any]]
    facts: dict[str, Any]


def payload(history: History, factor: float | None, steps: int) -> Payload:
    """Collect what the page of `history` shows.

    Raises InputError with one line if the history is not one of a beam, or has no finite sample.
    """
    missing = [name for name in _NEEDED if name not in history.data.variables]
    if missing:
        raise InputError(
            f"history: has no variable {missing[0]!r}: it is not one of a beam, or of another version"
        )
    story, true = story_of([history], factor=factor), BeamGeometry(history, 1.0)
    samples = frames(history, story.time_map, steps)
    values = _series(history, true.scenario)
    points = chart_points(list(values.values()), samples, history["state"].values)
    arrays = _frame_arrays(true, samples, story.time_map)
    arrays |= {f"chart_{name}": _packed(series[points], "f4") for name, series in values.items()}
    arrays["frame_point"] = _packed(np.searchsorted(points, samples), "i4")
    arrays["chart_time"] = _packed(true.times[points], "f8")
    arrays["chart_state"] = _packed(history["state"].values[points], "u1")
    return Payload(arrays, _facts(story, true, samples))


def unpacked(entry: dict[str, Any]) -> NDArray[Any]:
    """Return an array of `Payload.arrays` as it was."""
    raw = base64.b64decode(entry["data"])
    return np.frombuffer(raw, dtype=f"<{entry['type']}").reshape(entry["shape"])


def _packed(values: NDArray[Any], kind: str) -> dict[str, Any]:
    """Pack an array; what float32 cannot hold becomes infinite, which the page does not draw."""
    with np.errstate(over="ignore"):
        data = np.ascontiguousarray(values, dtype=f"<{kind}")
    return {"type": kind, "shape": list(data.shape), "data": base64.b64encode(data.tobytes()).decode("ascii")}


def _series(history: History, scenario: Scenario) -> dict[str, Array]:
    """Return the series of the page by name, at all samples; a spring's energy where the stop is elastic."""
    values = {short: np.asarray(history[name].values, dtype=float) for name, short in SERIES.items()}
    stop = stop_of(scenario)
    if stop is not None and scenario.contact.enabled:
        closed = history["state"].values != State.FREE
        gaps = np.where(closed, values["gap"], 0.0)
        values["stop"] = np.array([stop.energy(gap) for gap in gaps])
    return values


def _frame_arrays(true: BeamGeometry, samples: NDArray[np.int64], course: TimeMap) -> dict[str, dict[str, Any]]:
    """Arrays of the frames: times, axis (n, stations) and stress at the lower fibre (n, stations)."""
    times, history = true.times[samples], true.history
    axis = true.stations_of(samples)
    return {
        "frame_sample": _packed(samples, "i4"),
        "frame_time": _packed(times, "f8"),
        "frame_film": _packed(course.film_at(times), "f8"),
        "frame_rate": _packed(course.rate_at(times), "f8"),
        "frame_state": _packed(history["state"].values[samples], "u1"),
        "frame_x": _packed(axis[..., 0], "f4"),
        "frame_y": _packed(axis[..., 1], "f4"),
        "frame_stress": _packed(history["bending_stress"].values[samples], "f4"),
        "radius": _packed(np.asarray(true.sections.fibre_distance(true.stations)), "f4"),
        "place": _packed(true.stations, "f4"),
    }


def _facts(story: Story, true: BeamGeometry, samples: NDArray[np.int64]) -> dict[str, Any]:
    history, scenario, scale = true.history, true.scenario, story.colours
    touch = int(np.argmin(np.abs(true.stations - scenario.contact.point)))
    ramp, slope = mpl.colormaps[LIGHT.colour_map], drawn_slope(true)
    return {
        "factor": story.factor,
        "touch": touch,
        "length": scenario.beam.length,
        "hub_radius": scenario.root.hub_radius,
        "root": scenario.root.kind,
        "contact": scenario.contact.enabled,
        "slope": {
            "origin": list(scenario.slope.origin),
            "angle": scenario.slope.angle,
            "outline": slope.outline.tolist() if slope else None,
        },
        "stress_limit": scale.limit,
        "stress_title": scale.title,
        "stress_ticks": scale.ticks,
        "peak_force": _peak_force(history),
        "events": _events(history, true.times[samples]),
        "collisions": [[m["start"], m["end"]] for m in history.summary["macro_collisions"]],
        "all_events": len(history.events),
        "states": [state.name for state in State],
        "state_colours": list(STATE_COLOURS),
        "stress_colours": [to_hex(ramp(k / (_STOPS - 1))) for k in range(_STOPS)],
        "outcome": "" if history.outcome is Outcome.COMPLETED else history.outcome.sentence,
        "model": _model(scenario),
    }


def _events(history: History, frame_times: Array) -> list[dict[str, Any]]:
    """Return the listed events; `frame` is the one just after, `before` the one just before."""
    rows = []
    for event in listed_events(history):
        after = int(last_sample(frame_times, event.time))
        rows.append(
            {
                "time": event.time,
                "kind": event.kind.value,
                "impulse": _finite(event.normal_impulse),
                "loss": _finite(event.energy_loss),
                "state": int(event.state),
                "before": int(first_sample(frame_times, event.time)),
                "frame": max(after, 0),
            }
        )
    return rows


def _model(scenario: Scenario) -> str:
    """Say in one line what was simulated."""
    d, c = scenario.discretization, scenario.contact
    if d.method == "modal":
        shapes = f"{d.modes} assumed modes"
    elif d.modes:
        shapes = f"{d.elements} finite elements reduced to {d.modes} modes"
    else:
        shapes = f"{d.elements} finite elements"
    if not c.enabled:
        touch = "no contact"
    else:
        stops = {"rigid": "rigid stop", "spring": f"elastic stop {c.stiffness:.3g} N/m".replace("e+0", "e")}
        stop = stops.get(c.normal, f"{c.normal} stop")
        words = {"frictionless": "frictionless"} | {
            law: f"{law} friction μ = {c.mu_kinetic:g}" for law in ("hybrid", "modified-coulomb")
        }
        friction = words.get(c.friction, f"{c.friction} friction")
        touch = f"{stop}, {friction}"
    return f"{shapes}, {d.frame} frame, {d.kinetics} kinetics; {touch}; {scenario.solver.scheme} scheme"


def _peak_force(history: History) -> float:
    """Largest resultant (N) of the contact force; 0 if there is none."""
    return _largest(np.hypot(history["lambda_n"].values, history["lambda_tau"].values))


def _largest(values: NDArray[Any]) -> float:
    """Largest finite magnitude that float32 can hold."""
    magnitude = np.abs(values)
    return float(np.max(magnitude[magnitude < np.finfo(np.float32).max], initial=0.0))


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None

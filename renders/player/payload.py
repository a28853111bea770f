"""What the page knows of a run: arrays as base64, and a few facts in words and numbers."""

from __future__ import annotations

import base64
import math
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.colors import to_hex
from numpy.typing import NDArray

from oblique_impact.contact.state import State
from oblique_impact.errors import Outcome
from oblique_impact.history.history import History
from oblique_impact.history.sample_times import first_sample, last_sample
from oblique_impact.problem import stop_of
from oblique_impact.scenario.scenario import Scenario
from renders.player.selection import chart_points, frames, listed_events
from renders.story import Story
from renders.style import COLOUR_MAP, STATE_COLOURS

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


class Payload(NamedTuple):
    """What the page embeds.

    Attributes
    ----------
    arrays : dict
        Per name its `type` (f4, f8, i4, u1), `shape` and little-endian `data` as base64.
    facts : dict
        Everything that is not an array.
    """

    arrays: dict[str, dict[str, Any]]
    facts: dict[str, Any]


def payload(story: Story, steps: int) -> Payload:
    """Collect what the page of the first run of `story` shows, with about `steps` frames."""
    geometry = story.geometries[0].true
    history, course = geometry.history, story.time_map
    samples, states = frames(history, course, steps), history["state"].values
    values = _series(history, geometry.scenario)
    points = chart_points(list(values.values()), samples, states)
    times, axis = geometry.times[samples], geometry.stations_of(samples)
    arrays = {
        "frame_sample": _packed(samples, "i4"),
        "frame_time": _packed(times, "f8"),
        "frame_film": _packed(course.film_at(times), "f8"),
        "frame_rate": _packed(course.rate_at(times), "f8"),
        "frame_state": _packed(states[samples], "u1"),
        "frame_x": _packed(axis[..., 0], "f4"),
        "frame_y": _packed(axis[..., 1], "f4"),
        "frame_stress": _packed(history["bending_stress"].values[samples], "f4"),
        "frame_point": _packed(np.searchsorted(points, samples), "i4"),
        "radius": _packed(geometry.sections.fibre_distance(geometry.stations), "f4"),
        "place": _packed(geometry.stations, "f4"),
        "chart_time": _packed(geometry.times[points], "f8"),
        "chart_state": _packed(states[points], "u1"),
    }
    arrays |= {f"chart_{name}": _packed(series[points], "f4") for name, series in values.items()}
    return Payload(arrays, _facts(story, times))


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
        values["stop"] = np.zeros(history["time"].size)
        for contact in history.contacts:
            span = slice(
                int(last_sample(history["time"].values, contact.start)),
                int(first_sample(history["time"].values, contact.end)) + 1,
            )
            values["stop"][span] = [stop.energy(gap, contact.compliance) for gap in values["gap"][span]]
    return values


def _facts(story: Story, frame_times: Array) -> dict[str, Any]:
    geometry, scale, slope = story.geometries[0], story.colours, story.slope
    history, scenario, ramp = geometry.history, geometry.scenario, mpl.colormaps[COLOUR_MAP]
    return {
        "factor": story.factor,
        "touch": int(np.argmin(np.abs(geometry.stations - scenario.contact.point))),
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
        "peak_force": geometry.peak_force,
        "events": _events(history, frame_times),
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
    return [
        {
            "time": event.time,
            "kind": event.kind.value,
            "impulse": _finite(event.normal_impulse),
            "loss": _finite(event.energy_loss),
            "state": int(event.state),
            "before": int(first_sample(frame_times, event.time)),
            "frame": max(int(last_sample(frame_times, event.time)), 0),
        }
        for event in listed_events(history)
    ]


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
        elastic = f"elastic stop {c.stiffness:.3g} N/m".replace("e+0", "e")
        stop = {"rigid": "rigid stop", "spring": elastic}.get(c.normal, f"{c.normal} stop")
        coulomb = f" μ = {c.mu_kinetic:g}" if c.friction in ("hybrid", "modified-coulomb") else ""
        friction = "frictionless" if c.friction == "frictionless" else f"{c.friction} friction{coulomb}"
        touch = f"{stop}, {friction}"
    return f"{shapes}, {d.frame} frame, {d.kinetics} kinetics; {touch}; {scenario.solver.scheme} scheme"


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None

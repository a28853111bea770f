"""What the page knows of a run: its arrays, and a few facts in words and numbers."""

from __future__ import annotations

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
from oblique_impact.renders.geometry import BeamGeometry, contact_gap
from oblique_impact.renders.metadata import warnings_of
from oblique_impact.renders.player.packing import packed
from oblique_impact.renders.player.results import along_the_beam, result_facts, scales
from oblique_impact.renders.player.selection import chart_points, evenly, frames, listed_events
from oblique_impact.renders.story import Story
from oblique_impact.renders.style import COLOUR_MAP, STATE_COLOURS
from oblique_impact.renders.title import parameters
from oblique_impact.scenario.scenario import Scenario

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
        Per name an array as `packed` or `rounded` returns it.
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
    times, found = geometry.times[samples], scales(story)
    arrays = {
        "frame_sample": packed(samples, "i4"),
        "frame_time": packed(times, "f8"),
        "frame_film": packed(course.film_at(times), "f8"),
        "frame_rate": packed(course.rate_at(times), "f8"),
        "frame_state": packed(states[samples], "u1"),
        "frame_theta": packed(history["theta"].values[samples], "f8"),
        "frame_point": packed(np.searchsorted(points, samples), "i4"),
        "chart_time": packed(geometry.times[points], "f8"),
        "chart_state": packed(states[points], "u1"),
    }
    arrays |= along_the_beam(geometry, samples, found)
    arrays |= {f"chart_{name}": packed(series[points], "f4") for name, series in values.items()}
    facts = _facts(story, times) | {"results": result_facts(story, found)}
    return Payload(arrays, facts)


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
    values["gap"] = contact_gap(history)
    return values


def _facts(story: Story, frame_times: Array) -> dict[str, Any]:
    geometry, slope, ramp = story.geometries[0], story.slope, mpl.colormaps[COLOUR_MAP]
    history, scenario = geometry.history, geometry.scenario
    return {
        "title": story.heading,
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
        "touch_radius": geometry.touch_radius,
        "fibre": scenario.contact_fibre,
        "mass_radius": geometry.mass_radius,
        "flat_end": geometry.flat_end,
        "peak_force": geometry.peak_force,
        "events": _events(history, frame_times),
        "contacts": _contacts(geometry, frame_times),
        "collisions": [[m["start"], m["end"]] for m in history.summary["macro_collisions"]],
        "all_events": len(history.events),
        "states": [state.name for state in State],
        "state_colours": list(STATE_COLOURS),
        "colours": [to_hex(ramp(k / (_STOPS - 1))) for k in range(_STOPS)],
        "outcome": _why_it_stopped(history),
        "warnings": warnings_of([history]),
        "model": "; ".join(parameters(scenario)[1:]),
    }


def _why_it_stopped(history: History) -> str:
    """Return what ended a run before its end time, with its numbers where they are known; nothing of others."""
    if history.outcome is Outcome.COMPLETED:
        return ""
    return str(history.summary.get("message") or history.outcome.sentence)


def _events(history: History, frame_times: Array) -> list[dict[str, Any]]:
    """Return the listed events, with their numbers in the run; `frame` is just after, `before` just before."""
    return [
        {
            "number": number,
            "time": event.time,
            "kind": event.kind.value,
            "impulse": _finite(event.normal_impulse),
            "loss": _finite(event.energy_loss),
            "state": int(event.state),
            "before": int(first_sample(frame_times, event.time)),
            "frame": max(int(last_sample(frame_times, event.time)), 0),
        }
        for number, event in listed_events(history)
    ]


def _contacts(geometry: BeamGeometry, frame_times: Array) -> list[dict[str, Any]]:
    """Return the contacts that the page lists, with the frame after their start; one that lasts has no end."""
    history, last = geometry.history, float(geometry.times[-1])
    lasting = history["state"].values[-1] != State.FREE
    return [
        {
            "start": contact.start,
            "end": None if lasting and contact.end >= last else contact.end,
            "states": _states_between(geometry, contact.start, contact.end),
            "impulse": _finite(contact.normal_impulse),
            "peak_force": _finite(contact.peak_force),
            "loss": _finite(contact.energy_loss),
            "frame": max(int(last_sample(frame_times, contact.start)), 0),
        }
        for contact in evenly(history.contacts)
    ]


def _states_between(geometry: BeamGeometry, start: float, end: float) -> list[int]:
    """Return the states of a contact, each once, as they first came; none of a rebound."""
    part = slice(int(last_sample(geometry.times, start)), int(first_sample(geometry.times, end)) + 1)
    states = geometry.history["state"].values[part]
    return [int(state) for state in dict.fromkeys(states.tolist()) if state != State.FREE]


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None

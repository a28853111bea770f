"""What the page shows of a run: all that is computed, as arrays over frames, texts, and facts for its script."""

from __future__ import annotations

import base64
import json
import math
import zlib
from dataclasses import dataclass
from typing import Any, get_args

import matplotlib as mpl
import numpy as np
from matplotlib.colors import to_hex
from numpy.typing import NDArray

from oblique_impact.contact.state import State
from oblique_impact.history.sample_times import first_sample, last_sample
from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.player.curves import LEVELS, Chart, Series, charts_of, curve_arrays
from oblique_impact.renders.player.numbers import fixed, significant
from oblique_impact.renders.player.selection import chart_points, evenly, frames
from oblique_impact.renders.scale_bar import ScaleBar
from oblique_impact.renders.story import ColourScale, Story, colour_scale
from oblique_impact.renders.style import COLOUR_MAP, DARK, LIGHT, Colour
from oblique_impact.renders.timeline import rate_text

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

FACTORS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)  # by which a reader can magnify the deflection
SPEEDS = {"1/10": 0.1, "1/4": 0.25, "1/2": 0.5, "1": 1.0, "2": 2.0, "4": 4.0}  # of the film
ARROW = 0.16  # over the length: the arrow of the largest force
PIN = 0.035  # over the length: size of the drawn pin
_GHOST = 0.11  # over the length: path of the contact point between two earlier positions
_TRACE = 3.0  # over the length: path of the contact point that is seen
_REACH = 1.2  # over that of the beam: what lies farther away has no place in the picture
_OUT = 2.0  # over the length: larger displacements are drawn out of the picture all the same
_FADE, _MARGIN = 1.2, 0.12  # s of film, part of a collision: how charts come closer to it, and its room there


@dataclass(frozen=True)
class Content:
    """The page's content: `facts` as JSON, `arrays` and `texts` over frames by name."""

    facts: dict[str, Any]
    arrays: dict[str, NDArray[Any]]
    texts: dict[str, list[str]]

    def packed(self) -> tuple[str, str]:
        """Return facts as JSON and, deflated as base64, arrays and texts: the facts say kind, place and length."""
        data, places = b"", {}
        for name, values in self.arrays.items():
            kind = {"f": "f4", "u": "u1", "i": f"i{values.dtype.itemsize}"}[values.dtype.kind]
            kind = "f8" if name.endswith("time") or name == "film" else kind
            data += b"\0" * (-len(data) % 8)
            places[name] = (kind, len(data), values.size)
            data += np.ascontiguousarray(values, dtype=f"<{kind}").tobytes()
        for name, lines in self.texts.items():
            text = "\n".join(lines).encode()
            places[name] = ("text", len(data), len(text))
            data += text
        facts = json.dumps(self.facts | {"arrays": places}, allow_nan=False, separators=(",", ":"))
        return facts, base64.b64encode(zlib.compress(data, 6)).decode("ascii")


def content_of(story: Story) -> Content:
    """Compute what the page of the first run of `story` shows."""
    geometry, course = story.geometries[0].true, story.time_map
    history, times = geometry.history, geometry.times
    samples, states = frames(history, course), history["state"].values.astype(int)
    film, charts = course.film_at(times[samples]), charts_of(geometry)
    points = chart_points([one.values for chart in charts for one in chart.series], samples)
    scales = {name: colour_scale(story.geometries, name) for name in get_args(Colour)}
    axes = geometry.stations_at(samples)
    touch = geometry.touch
    path = _path_of(axes[:, touch])
    rates = np.array([float(f"{rate:.3g}") for rate in course.rate_at(times[samples])])
    different, rate = np.unique(rates, return_inverse=True)
    displacement, scale = _displacements(geometry, samples)
    arrays: dict[str, NDArray[Any]] = {
        "time": times[samples],
        "film": film,
        "state": states[samples].astype("u1"),
        "theta_time": history["theta"].values[samples],
        **displacement,
        "window": _windows(story, times[samples], film),
        "contact": axes[:, touch],
        "offset": np.array([geometry.contact_place(k)[:2] for k in samples]) - axes[:, touch],
        "arrow": _arrows(geometry, samples),
        "trace": np.searchsorted(path, path - _TRACE * geometry.scenario.beam.length).astype("i4"),
        "rate": rate.astype("i4"),
        **_colours(geometry, samples, scales),
        "chart_time": times[points],
        "chart_state": states[points].astype("u1"),
    }
    levels = {}
    for series in (one for chart in charts for one in chart.series):
        shown = Series(series.name, series.values[points], series.colour)
        more, levels[series.name] = curve_arrays(shown, times[points], states[points].astype("u1"))
        arrays |= {f"{series.name}_value": shown.values, f"{series.name}_now": series.values[samples], **more}
    facts = _outline_facts(story, touch) | {
        "displacement_scale": scale,
        "factors": [
            _factor_facts(story, axes, arrays["arrow"], touch, f) for f in sorted({*FACTORS, story.factor})
        ],
        "rates": {name: [rate_text(r * speed) for r in different] for name, speed in SPEEDS.items()},
        "ghosts": _ghosts(path, _GHOST * geometry.scenario.beam.length),
        "charts": [chart.facts() for chart in charts],
        "levels": levels,
        "level_widths": LEVELS,
        "results": {name: {"title": s.title, "ticks": s.ticks} for name, s in scales.items()},
        "shown": story.style.quantity,
        "events": _event_facts(story, times[samples]),
        "contacts": _contact_facts(geometry, times[samples]),
        "collisions": [m["start"] for m in history.summary["macro_collisions"]],
        "inset": _inset_facts(geometry, axes[:, touch]),
    }
    return Content(facts, arrays, _texts(geometry, samples, charts))


# Arrays over frames -------------------------------------------------------------------------------------------


def _path_of(places: Array) -> Array:
    """Return the length (m) of the path through some places (frames, 2) up to each of them."""
    steps = np.nan_to_num(np.linalg.norm(np.diff(places, axis=0), axis=1), posinf=0.0)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _ghosts(path: Array, distance: float) -> list[tuple[int, int]]:
    """Return frames at equal distances along a path, each with the first frame that shows it, a little later."""
    at = np.arange(0.0, path[-1], distance)
    shown = np.searchsorted(path, at + 0.25 * distance)
    return list(zip(np.searchsorted(path, at).tolist(), shown.tolist(), strict=True))


def _displacements(geometry: BeamGeometry, samples: Integers) -> tuple[dict[str, NDArray[Any]], float]:
    """Return `ux` and `uy` (frames, stations), floating frame, as 16-bit multiples of a length (m), and this."""
    both = np.nan_to_num(np.array([geometry.history[name].values[samples] for name in ("ux", "uy")]))
    most = _OUT * geometry.scenario.beam.length
    both = np.clip(both, -most, most)
    scale = float(np.abs(both).max()) / 32767 or 1.0
    codes = np.rint(both / scale).astype("i2")
    return {"ux": codes[0], "uy": codes[1]}, scale


def _windows(story: Story, times: Array, film: Array) -> Array:
    """Return the span of time (s) that charts show at each frame as they follow the film, (frames, 2).

    It is the whole run, and closer and closer the collision that the film slows down for.
    """
    start, end = float(times[0]), float(times[-1])
    whole, window = end - start, np.tile([start, end], (times.size, 1))
    for collision in story.histories[0].summary["macro_collisions"]:
        first, last = collision["start"], collision["end"]
        margin = _MARGIN * (last - first) + 0.002 * whole
        first, last = max(start, first - margin), min(end, last + margin)
        if last - first > 0.7 * whole:
            continue
        begin, stop = story.time_map.film_at(np.array([first, last]))
        part = np.minimum(_smooth((film - begin) / _FADE + 1.0), 1.0 - _smooth((film - stop) / _FADE))
        width = whole ** (1.0 - part) * (last - first) ** part  # an even zoom: its logarithm is linear
        share = (whole - width) / (whole - (last - first))
        close = np.stack([start + (first - start) * share, end + (last - end) * share], axis=1)
        window[part > 0.0] = close[part > 0.0]
    return window


def _smooth(part: Array) -> Array:
    """Return 0 below 0, 1 above 1, smooth between."""
    part = np.clip(part, 0.0, 1.0)
    return np.asarray(part * part * (3.0 - 2.0 * part))


def _arrows(geometry: BeamGeometry, samples: Integers) -> Array:
    """Return the direction of the contact force (frames, 2), as long as the root of its size over the peak."""
    touching = geometry.history["state"].values[samples] != State.FREE
    normal, tangential = (
        np.nan_to_num(geometry.history[name].values[samples]) * touching for name in ("lambda_n", "lambda_tau")
    )
    tangent, out = geometry.slope_axes
    force = normal[:, None] * out + tangential[:, None] * tangent
    size = np.hypot(*force.T)[:, None]
    with np.errstate(over="ignore", invalid="ignore"):
        arrow = force / np.sqrt(np.maximum(size, 1e-300) * (geometry.peak_force or 1.0))
    return np.asarray(np.nan_to_num(arrow, posinf=0.0, neginf=0.0))


def _colours(geometry: BeamGeometry, samples: Integers, scales: dict[str, ColourScale]) -> dict[str, NDArray[Any]]:
    """Return the colours of all results at the lower and the upper fibre (frames, stations), 0 to 255."""
    found = {}
    with np.errstate(over="ignore", invalid="ignore"):
        for name, scale in scales.items():
            for side, values in zip(("lower", "upper"), geometry.at_fibres(name, samples), strict=True):
                part = np.clip(np.nan_to_num(values / scale.limit), -1.0, 1.0)
                found[f"{name}_{side}"] = np.rint(127.5 * (1.0 + part)).astype("u1")
    return found


def _texts(geometry: BeamGeometry, samples: Integers, charts: list[Chart]) -> dict[str, list[str]]:
    """Return what is written at each frame: time, numbers beside the contact point, values in the legends."""
    history, times = geometry.history, geometry.times
    decimals = min(12, max(5, 6 - math.ceil(math.log10(float(times[-1] - times[0]) or 1.0) - 1e-9)))
    energies = [one.values for chart in charts for one in chart.series if chart.name == "energy"]
    largest = max(float(np.abs(v[np.isfinite(v)]).max(initial=0.0)) for v in energies)
    places = min(6, max(0, 3 - math.floor(math.log10(largest or 1.0))))
    force = np.hypot(history["lambda_n"].values, history["lambda_tau"].values)

    def each(values: Any, form: Any) -> list[str]:
        return [form(float(values[k])) for k in samples]

    def millimetres(metres: float) -> str:
        return f"{fixed(1e3 * metres, 3 if abs(metres) < 0.1 else 1)} mm"

    found = {
        "time_text": each(times, lambda v: f"{fixed(v, decimals)} s"),
        "force_text": each(force, lambda v: f"{significant(v, 3)} N"),
    }
    for chart in charts:
        form = (lambda v: fixed(v, places)) if chart.name == "energy" else (lambda v: significant(v, 4))
        found |= {f"{one.name}_text": each(one.values, form) for one in chart.series}
    if geometry.scenario.contact.enabled:
        found["gap"] = [millimetres(geometry.gap(k)) for k in samples]
        found["tangential velocity"] = each(history["slip_rate"].values, lambda v: f"{fixed(v, 4)} m/s")
        for label, name in (("normal force", "lambda_n"), ("tangential force", "lambda_tau")):
            found[label] = each(history[name].values, lambda v: f"{significant(v, 4)} N")
    else:
        found["deflection"] = each(history["deflection"].values, millimetres)
    return found


# Facts --------------------------------------------------------------------------------------------------------


def _outline_facts(story: Story, touch: int) -> dict[str, Any]:
    """Return what is drawn of beam, root and slope, and the colours."""
    geometry, ramp = story.geometries[0], mpl.colormaps[COLOUR_MAP]
    scenario, stations = geometry.scenario, geometry.stations
    return {
        "touch": touch,
        "stations": stations.tolist(),
        "radius": np.broadcast_to(geometry.sections.fibre_distance(stations), stations.shape).tolist(),
        "length": scenario.beam.length,
        "hub_radius": scenario.root.hub_radius,
        "pinned": scenario.root.kind == "pin",
        "pin": PIN * scenario.beam.length,
        "arrow": ARROW * scenario.beam.length,
        "slope": story.slope.outline.tolist() if story.slope else None,
        "normal": geometry.slope_axes[1].tolist(),
        "touch_radius": geometry.touch_radius,
        "on_axis": scenario.contact_fibre == 0.0,
        "mass_radius": geometry.mass_radius,
        "flat_end": geometry.flat_end,
        "states": [state.name for state in State],
        "state_colours": {"light": LIGHT.states, "dark": DARK.states},
        "ramp": [to_hex(ramp(k / 255.0)) for k in range(256)],
        "bars": [
            (length, ScaleBar(length, np.zeros(2)).text)
            for length in (m * 10.0**p for p in range(-7, 4) for m in (1.0, 2.0, 5.0))
        ],
    }


def _factor_facts(story: Story, axes: Array, arrows: Array, touch: int, factor: float) -> dict[str, Any]:
    """Return a deformation factor, what the page says of it, and the `bounds` of what has to be seen (m)."""
    geometry = story.geometries[0]
    length, hub = geometry.scenario.beam.length, geometry.scenario.root.hub_radius
    chord = axes[:, :1] + (geometry.stations / geometry.stations[touch])[:, None] * (
        axes[:, touch, None] - axes[:, :1]
    )
    drawn = (chord + factor * (axes - chord)).reshape(-1, 2)
    size = 2.0 * np.maximum(geometry.sections.fibre_distance(geometry.stations), geometry.mass_radius)
    margin = np.tile(np.broadcast_to(size, geometry.stations.shape), len(axes))[:, None]
    tails = axes[:, touch] - 1.2 * ARROW * length * arrows
    places = np.concatenate([drawn - margin, drawn + margin, tails, story.slope.outline if story.slope else tails])
    places = places[np.all(np.abs(places) < _REACH * (length + hub), axis=1)]
    pin = PIN * length
    low = np.min([*places, (-2.0 * pin, -2.6 * pin), (-hub, -hub)], axis=0)
    high = np.max([*places, (2.0 * pin, pin), (hub, hub)], axis=0)
    about = "pin–tip chord" if touch == geometry.stations.size - 1 else "chord from the pin to the contact point"
    note = f"deflection drawn ×{factor:g} about the {about}"
    return {
        "factor": factor,
        "label": "true" if factor == 1.0 else f"×{factor:g}",
        "note": "deflection drawn true to scale" if factor == 1.0 else note,
        "bounds": [float(low[0]), float(high[0]), float(low[1]), float(high[1])],  # left, right, low, high
    }


def _inset_facts(geometry: BeamGeometry, contact: Array) -> dict[str, Any]:
    """Return what the view of the contact point shows: `span` (m) and `home`, where the beam touches the slope.

    That is the middle of where it does; where it comes closest if it never does; None without contact.
    """
    scenario = geometry.scenario
    span = max(11.0 * geometry.touch_radius, 0.05 * scenario.beam.length)
    if not scenario.contact.enabled:
        return {"span": span, "home": None}
    lift, (tangent, normal) = abs(scenario.contact_fibre), geometry.slope_axes
    origin = np.array(scenario.slope.origin)
    along, height = ((np.nan_to_num(contact) - origin) @ geometry.slope_axes.T).T
    touching = height - lift <= 1e-3 * scenario.beam.length
    chosen = along[touching] if touching.any() else along[[np.argmin(np.abs(height - lift))]]
    middle = 0.5 * (chosen.min() + chosen.max())
    return {"span": span, "home": (origin + middle * tangent + lift * normal).tolist()}


def _event_facts(story: Story, times: Array) -> list[dict[str, Any]]:
    """Return the listed events; `frame` is the one just after it."""
    return [
        {
            "number": number,
            "time": event.time,
            "text": fixed(event.time, 6),
            "kind": event.kind.value,
            "impulse": f"{significant(event.normal_impulse, 3)} N s" if event.normal_impulse else "",
            "state": int(event.state),
            "frame": max(int(last_sample(times, event.time)), 0),
        }
        for number, event in evenly(list(enumerate(story.histories[0].events, start=1)))
    ]


def _contact_facts(geometry: BeamGeometry, times: Array) -> list[dict[str, Any]]:
    """Return the listed contacts as cells of a table; `frame` is the one just after the start."""
    history, states, last = geometry.history, geometry.history["state"].values, float(geometry.times[-1])
    found = []
    for contact in evenly(history.contacts):
        part = slice(
            int(last_sample(geometry.times, contact.start)), int(first_sample(geometry.times, contact.end)) + 1
        )
        names = [
            State(state).name.lower() for state in dict.fromkeys(states[part].tolist()) if state != State.FREE
        ]
        lasts = states[-1] != State.FREE and contact.end >= last
        found.append(
            {
                "frame": max(int(last_sample(times, contact.start)), 0),
                "cells": [
                    fixed(contact.start, 6),
                    "open" if lasts else fixed(contact.end, 6),
                    ", ".join(names) or "rebound",
                    significant(contact.normal_impulse, 4),
                    significant(contact.peak_force, 4) if names else "–",  # a rebound is an impulse alone
                    significant(contact.energy_loss, 4),
                ],
            }
        )
    return found

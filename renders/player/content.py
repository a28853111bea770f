"""Contents of the page of a run: arrays and texts over frames, facts for its script, and its parts."""

from __future__ import annotations

import base64
import json
import math
import zlib
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import to_hex
from numpy.typing import NDArray

from oblique_impact.contact.state import State
from oblique_impact.history.history import History
from oblique_impact.history.sample_times import first_sample, last_sample
from oblique_impact.renders.contact_map import closed_samples
from oblique_impact.renders.geometry import Array, BeamGeometry
from oblique_impact.renders.layout import ScaleBar
from oblique_impact.renders.player.page_charts import PageChart, evenly, page_charts
from oblique_impact.renders.story import ColourScale, Story
from oblique_impact.renders.style import COLOUR_MAP, state_name
from oblique_impact.renders.surroundings import DrawnObstacle, drawn_obstacles
from oblique_impact.renders.timeline import TimeMap, rate_text

Integers = NDArray[np.int64]

FACTORS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)  # by which a reader can magnify the deflection
SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0)  # of the film
ARROW = 0.16  # over the length: the arrow of the largest force
PIN = 0.035  # over the length: size of the drawn pin
_GHOST = 0.11  # over the length: path of the contact point between two earlier positions
_TRACE = 3.0  # over the length: path of the contact point that is seen
_REACH = 1.2  # over that of the beam: what lies farther away has no place in the picture
_OUT = 3.0  # over that of the beam: what lies farther away is drawn there, out of the picture
_FRAMES = 2000  # about, besides those that are always there
_APART = 0.13  # part of the film: times below the slider are as far apart, to have room on a phone


@dataclass(frozen=True)
class Content:
    """The page's content.

    `facts` are what the script needs besides `arrays` and `texts` over frames, by name; the rest is written into
    the page as it is: charts, scales of colours by result, spans of one state of contact and times over the film
    (in percent), events and contacts.
    """

    facts: dict[str, Any]
    arrays: dict[str, NDArray[Any]]
    texts: dict[str, list[str]]
    charts: list[PageChart]
    scales: dict[str, ColourScale]
    strip: list[tuple[str, float, float]]
    times: list[tuple[float, str]]
    events: list[dict[str, Any]]
    contacts: list[dict[str, Any]]

    def packed(self) -> tuple[str, str]:
        """Return facts as JSON and, deflated as base64, arrays and texts: the facts say kind, place and length."""
        data, places = b"", {}
        for name, values in self.arrays.items():
            kind = {"f": "f4", "u": "u1", "i": "i4"}[values.dtype.kind]
            kind = "f8" if name in ("time", "film") else kind
            data += b"\0" * (-len(data) % 8)
            places[name] = (kind, len(data), values.size)
            data += np.ascontiguousarray(values, dtype=f"<{kind}").tobytes()
        for name, lines in self.texts.items():
            text = "\n".join(lines).encode()
            places[name] = ("text", len(data), len(text))
            data += text
        facts = json.dumps(self.facts | {"arrays": places}, allow_nan=False, separators=(",", ":"))
        return facts, base64.b64encode(zlib.compress(data, 6)).decode("ascii")


def content_of(story: Story, number: int = 0) -> Content:
    """Compute what the page shows of a run of `story`, by its number from 0; charts, of all, for the first one."""
    geometry, course = story.geometries[number].true, story.time_map
    obstacles = drawn_obstacles(geometry)
    history, scenario, times = geometry.history, geometry.scenario, geometry.times
    samples, length, touch = _frames(history, course), scenario.beam.length, geometry.touch
    state, charts = history["state"].values.astype("u1")[samples], page_charts(story) if number == 0 else []
    film = course.film_at(times[samples])
    out = _OUT * scenario.reach
    axes = np.clip(np.nan_to_num(geometry.stations_at(samples)), -out, out)
    steps = np.linalg.norm(np.diff(axes[:, touch], axis=0), axis=1)
    path = np.concatenate([[0.0], np.cumsum(steps)])  # of the contact point
    ghosts = np.arange(0.0, path[-1], _GHOST * length)
    rates, rate = np.unique([float(f"{rate:.3g}") for rate in course.rate_at(times[samples])], return_inverse=True)
    arrow, zones = _arrows(geometry, samples), _zones(geometry, samples)
    axis_places, faces = _places(geometry, samples)
    loaded, applied = _applied(geometry, samples)
    # of the arrows
    tails = np.concatenate(
        [(at - 1.2 * ARROW * length * a).reshape(-1, 2) for at, a in ((faces, arrow), (loaded, applied))]
    )
    arrays: dict[str, NDArray[Any]] = {
        "time": times[samples],
        "film": film,
        "state": state,
        "axis": axes,
        "place": axis_places,
        "offset": faces - axis_places,
        "arrow": arrow,
        "applied": applied,
        "zone": zones[:, :, :2],
        "close": np.array([geometry.close_contact(k) for k in samples]),
        "trace": np.searchsorted(path, path - _TRACE * length),
        "rate": rate,
        **_colours(geometry, samples, story.scales),
    }
    ramp, stations = mpl.colormaps[COLOUR_MAP], geometry.stations
    facts = {
        "touch": touch,
        "stations": stations.tolist(),
        "radius": geometry.radii.tolist(),
        "hub_radius": scenario.root.hub_radius,
        "pinned": scenario.root.kind == "pin",
        "free": scenario.root.is_free,
        # angle of a beam whose root is clamped
        "clamped": float(geometry.values("theta")[0]) if geometry.clamped else None,
        "pin": PIN * length,
        "longest_arrow": ARROW * length,
        "obstacles": [
            {"outline": o.outline.tolist(), "surface": o.surface.tolist(), "normal": o.normal.tolist()}
            for o in obstacles
        ],
        "contacts": arrow.shape[1],
        "zone_sides": np.sign(zones[:, :, 2].sum(axis=0)).tolist(),
        "touch_radius": geometry.touch_radius,
        "on_axis": scenario.contact_fibre == 0.0,
        "mass_radius": geometry.mass_radius,
        "masses": [{"place": m.place, "radius": geometry.disc(m.place)} for m in geometry.inner_masses],
        "loaded": [force.place for force in scenario.acting_forces],
        "flat_end": geometry.flat_end,
        "states": [one.name for one in State],
        "told": [state_name(one, scenario).upper() for one in State],
        "ramp": [to_hex(ramp(k / 255.0)) for k in range(256)],
        "bars": [
            (size, ScaleBar(size, np.zeros(2)).text)
            for size in (m * 10.0**p for p in range(-7, 4) for m in (1.0, 2.0, 5.0))
        ],
        "factors": {
            f"{f:g}": _factor(geometry, obstacles, axes, tails, f) for f in sorted({*FACTORS, story.factor})
        },
        "rates": {f"{speed:g}": [rate_text(r * speed) for r in rates] for speed in SPEEDS},
        # earlier positions, each with the first frame that shows it, a little later
        "ghosts": np.searchsorted(path, [ghosts, ghosts + 0.25 * _GHOST * length]).T.tolist(),
        "inset": _inset(geometry),
    }
    changes = np.flatnonzero(np.diff(state, prepend=255, append=255))
    at = 100.0 * np.append(film, film[-1]) / (film[-1] or 1.0)
    strip = [(State(int(state[a])).name, at[a], at[b] - at[a]) for a, b in pairwise(changes.tolist())]
    texts = _texts(geometry, samples, charts) | {"touched_text": _touched(zones)}
    return Content(
        facts,
        arrays,
        texts,
        charts,
        story.scales,
        strip,
        _marks(story),
        _events(story, times[samples]),
        _contacts(geometry, times[samples]),
    )


def _frames(history: History, course: TimeMap) -> Integers:
    """Choose the samples that become frames, ascending: even in film time, and what has to be seen.

    That is both sides of every listed event, the largest force of every collision and the largest stress.
    """
    times, force = history["time"].values, np.nan_to_num(history["lambda_n"].values)
    events = np.array([event.time for event in evenly(history.events)])
    found = [np.searchsorted(course.film_at(times), np.linspace(0.0, course.duration, _FRAMES))]
    found += [first_sample(times, events), last_sample(times, events)]
    stress = history.section_forces()["bending_stress"].values
    found.append(np.nan_to_num(np.abs(stress)).max(axis=1).argmax(keepdims=True))
    for collision in history.summary["macro_collisions"]:
        start, stop = np.searchsorted(times[:-1], [collision["start"], collision["end"]])
        found.append(start + force[start : max(start, stop) + 1].argmax(keepdims=True))
    # another run may go on when the course, which is that of the first one, has ended
    return np.unique(np.clip(np.concatenate(found), 0, int(last_sample(times, course.times[-1]))))


def _arrows(geometry: BeamGeometry, samples: Integers) -> Array:
    """Return the directions of the contact forces (frames, contacts, 2).

    They are as long as the roots of their sizes over the peak.
    """
    touching = geometry.history["state"].values[samples] != State.FREE
    force = np.array([geometry.pushes(k) for k in samples]) * touching[:, None, None]
    size = np.linalg.norm(force, axis=2)[:, :, None]
    with np.errstate(over="ignore", invalid="ignore"):
        arrow = force / np.sqrt(np.maximum(size, 1e-300) * (geometry.peak_force or 1.0))
    return np.asarray(np.nan_to_num(arrow, posinf=0.0, neginf=0.0))


def _applied(geometry: BeamGeometry, samples: Integers) -> tuple[Array, Array]:
    """Return where forces on the beam act and their directions, each (frames, forces, 2).

    They are as long as the roots of their sizes over the peak.
    """
    if not geometry.scenario.acting_forces:
        return np.zeros((samples.size, 0, 2)), np.zeros((samples.size, 0, 2))
    places, forces = (np.array(part) for part in zip(*map(geometry.applied_forces, samples), strict=True))
    size = np.linalg.norm(forces, axis=2)[:, :, None]
    return places[:, :, :2], forces / np.sqrt(np.maximum(size, 1e-300) * geometry.peak_applied)


def _zones(geometry: BeamGeometry, samples: Integers) -> Array:
    """Return the zones of contact (frames, obstacles, 3): first and last place (m) and side, or zeros."""
    obstacles = geometry.zoned
    found = np.zeros((samples.size, len(obstacles), 3))
    for n, k in enumerate(samples):
        for zone in geometry.zones(k):
            found[n, obstacles.index(zone.obstacle)] = zone.first, zone.last, zone.side
    return np.nan_to_num(found)


def _places(geometry: BeamGeometry, samples: Integers) -> tuple[Array, Array]:
    """Return where the contacts are on the axis and on the beam's face, each (frames, contacts, 2)."""
    faces = np.array([geometry.contact_places(k) for k in samples])
    frames = zip(geometry.stations_at(samples), geometry.value("contact_place", samples), strict=True)
    on_axis = [[np.interp(places, geometry.stations, along) for along in axis.T] for axis, places in frames]
    return np.swapaxes(on_axis, 1, 2), faces


def _colours(geometry: BeamGeometry, samples: Integers, scales: dict[str, ColourScale]) -> dict[str, NDArray[Any]]:
    """Return the colours of all results at the lower and the upper fibre (frames, stations), 0 to 255."""
    found = {}
    with np.errstate(over="ignore", invalid="ignore"):
        for name, scale in scales.items():
            for side, values in zip(("lower", "upper"), geometry.at_fibres(name, samples), strict=True):
                part = np.clip(np.nan_to_num(values / scale.limit), -1.0, 1.0)
                found[f"{name}_{side}"] = np.rint(127.5 * (1.0 + part)).astype("u1")
    return found


def _texts(geometry: BeamGeometry, samples: Integers, charts: list[PageChart]) -> dict[str, list[str]]:
    """Return what is written at each frame: time, numbers beside the contact point, values in the legends."""
    times = geometry.times

    def each(values: Any, form: Any) -> list[str]:
        return [form(float(value)) for value in np.asarray(values)[samples]]

    def millimetres(metres: float) -> str:
        return f"{fixed(1e3 * metres, 3 if abs(metres) < 0.1 else 1)} mm"

    decimals = min(12, max(5, 6 - math.ceil(math.log10(float(times[-1] - times[0]) or 1.0) - 1e-9)))
    normal, tangential = geometry.values("lambda_n"), geometry.values("lambda_tau")
    largest_push = np.hypot(geometry.values("contact_fx"), geometry.values("contact_fy")).max(axis=1)
    found = {
        "side_text": [geometry.beside(k) for k in samples],
        "time_text": each(times, lambda v: f"{fixed(v, decimals)} s"),
        "force_text": each(largest_push, lambda v: f"{significant(v, 3)} N"),
    }
    for chart in charts:
        if not chart.curves:
            continue
        largest = max(float(np.abs(c.values[np.isfinite(c.values)]).max(initial=0.0)) for c in chart.curves)
        places = min(6, max(0, 3 - math.floor(math.log10(largest or 1.0))))
        # energies have the same decimals: they add up
        form = partial(fixed, decimals=places) if chart.name == "energy" else partial(significant, digits=4)
        for curve in chart.curves:  # of each run the last sample at or before the frame
            at = np.searchsorted(curve.time, times[samples], side="right") - 1
            found[f"{chart.name}-{curve.label}_text"] = [form(value) for value in curve.values[at].tolist()]
    if geometry.scenario.contact.enabled:
        found["gap"] = each(geometry.close_values("gap"), millimetres)
        found["tangential velocity"] = each(geometry.close_values("slip_rate"), lambda v: f"{fixed(v, 4)} m/s")
        # of a single run the chart of the forces tells them
        told = {curve.label for chart in charts for curve in chart.curves}
        several = geometry.history.data.sizes["contact"] > 1
        for name, values in (("normal", normal), ("tangential", tangential)):
            if f"{name}{', of all contacts' if several else ''}" not in told:
                found[f"{name} force{' of all' if several else ''}"] = each(
                    values, lambda v: f"{significant(v, 4)} N"
                )
    return found


def _touched(zones: Array) -> list[str]:
    """Return in words where the beam touches, for zones of contact (frames, obstacles, 3)."""
    found = []
    for frame in zones:
        parts = [
            f"{first:.3f}" if first == last else f"{first:.3f} to {last:.3f}"
            for first, last, side in frame
            if side
        ]
        found.append(f"{' and '.join(parts)} m" if parts else "none")
    return found


def _factor(
    geometry: BeamGeometry, obstacles: list[DrawnObstacle], axes: Array, tails: Array, factor: float
) -> dict[str, Any]:
    """Return a deformation factor, what the page says of it, and left, right, low and high (m) of what is seen."""
    length, hub = geometry.scenario.beam.length, geometry.scenario.root.hub_radius
    drawn = geometry.magnify(axes, factor)
    room = 2.0 * np.maximum(geometry.radii, geometry.mass_radius)[:, None]
    places = np.concatenate([*(drawn - room), *(drawn + room), tails, *(o.outline for o in obstacles)])
    places = np.ascontiguousarray(places.T)  # (2, places): reduced many times as fast as its transpose
    places = places[:, np.all(np.abs(places) < _REACH * geometry.scenario.reach, axis=0)]
    pin = PIN * length
    root = np.array([(-2.0 * pin, 2.0 * pin, -hub, hub), (-2.6 * pin, pin, -hub, hub)])
    seen = places if geometry.scenario.root.is_free else np.hstack([places, root])
    (left, low), (right, high) = (ends(seen, axis=1) for ends in (np.min, np.max))
    return {
        "factor": factor,
        "label": "true" if factor == 1.0 else f"×{factor:g}",
        "note": geometry.deflection_words(factor),
        "bounds": [float(left), float(right), float(low), float(high)],
    }


def _inset(geometry: BeamGeometry) -> dict[str, Any]:
    """Return what the view of the contact point shows: `span` (m) and `home`, its place at the largest force.

    Without any force that is where it comes closest to the slope, without contact None.
    """
    force, gap = np.nan_to_num(geometry.values("lambda_n")), np.abs(np.nan_to_num(geometry.values("gap")))
    k = int(force.argmax() if force.any() else gap.argmin())
    enabled = geometry.scenario.contact.enabled
    return {
        "span": max(11.0 * geometry.touch_radius, 0.05 * geometry.scenario.beam.length),
        "home": _places(geometry, np.array([k]))[0][0, geometry.close_contact(k)].tolist() if enabled else None,
    }


def _marks(story: Story) -> list[tuple[float, str]]:
    """Return times below the slider, with their places: start and end, and beginnings of collisions in between."""
    course, (start, end) = story.time_map, story.time_map.times[[0, -1]].tolist()
    found = [(0.0, f"{start:.0f} s"), (100.0, f"{end:.3f} s")]
    for collision in story.histories[0].summary["macro_collisions"]:
        at = 100.0 * float(course.film_at(collision["start"])) / (course.duration or 1.0)
        if all(abs(at - taken) >= 100.0 * _APART for taken, _ in found):
            found.append((at, f"{collision['start']:.3f} s"))
    return found


def _events(story: Story, times: Array) -> list[dict[str, Any]]:
    """Return the listed events; `frame` is the one just after it."""
    return [
        {
            "number": number,
            "time": fixed(event.time, 6),
            "exact": event.time,
            "kind": event.kind.value,
            "impulse": f"{significant(event.normal_impulse, 3)} N s" if event.normal_impulse else "",
            "state": State(event.state).name,
            "told": state_name(event.state, story.histories[0].scenario),
            "frame": max(int(last_sample(times, event.time)), 0),
        }
        for number, event in evenly(list(enumerate(story.histories[0].events, start=1)))
    ]


def _contacts(geometry: BeamGeometry, times: Array) -> list[dict[str, Any]]:
    """Return the listed contacts as cells of a table; `frame` is the one just after the start."""
    history, last, found = geometry.history, float(geometry.times[-1]), []
    for number, contact in evenly(list(enumerate(history.contacts))):
        inside, column = closed_samples(history, number)
        states = history["contact_state"].values[:, column]
        passed = dict.fromkeys(states[inside].tolist())
        names = [state_name(state, history.scenario) for state in passed if state != State.FREE]
        lasts = states[-1] != State.FREE and contact.end >= last
        cells = [
            fixed(contact.start, 6),
            "open" if lasts else fixed(contact.end, 6),
            ", ".join(names) or "rebound",
            significant(contact.normal_impulse, 4),
            significant(contact.peak_force, 4) if names else "–",  # a rebound is an impulse alone
            significant(contact.energy_loss, 4),
        ]
        found.append({"frame": max(int(last_sample(times, contact.start)), 0), "cells": cells})
    return found


def fixed(value: float, decimals: int) -> str:
    """Return a number with fixed decimals and a proper minus, none before zero; a dash if it is not finite."""
    if not math.isfinite(value):
        return "–"
    text = f"{value:.{decimals}f}"
    return text.lstrip("-") if float(text) == 0.0 else text.replace("-", "−")


def significant(value: float, digits: int) -> str:
    """Return a number with significant digits, without exponent between 1e-4 and 1e6."""
    if not math.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    mantissa, power = f"{value:.{digits - 1}e}".split("e")
    if not -4 <= int(power) <= 5:
        return f"{mantissa}e{int(power)}".replace("-", "−")
    return fixed(value, max(0, digits - 1 - int(power)))

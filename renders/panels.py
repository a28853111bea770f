"""The panels of runs, each drawn by one function, in axes of films, pages, the overview and reports.

Curves over time (forces, gap, energy, any variable) are `Curves`, which `draw_curves` draws over a `Clock`: of
physical time, or of a film.  The others are motion, shapes, places, envelope, losses and differences of events.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from oblique_impact.contact.state import State
from oblique_impact.history.history import History
from oblique_impact.history.sample_times import last_sample
from oblique_impact.history.variables import SECTION_FORCES
from oblique_impact.renders.bands import drawn
from oblique_impact.renders.contact_map import draw_contact_map
from oblique_impact.renders.geometry import Array, contact_gap
from oblique_impact.renders.story import Story
from oblique_impact.renders.style import LIGHT, Theme, state_name

Dash = Literal["-", "--", ":"]

#: what an envelope is drawn of, and the variables along the beam that these are
ENVELOPES = {"moment": "moment", "shear": "shear", "bending stress": "bending_stress", "deflection": "uy"}
_DASHES: tuple[Dash, ...] = ("-", "--", ":")  # of several runs
BAND, _EDGE = 0.13, 0.45  # strength of a band and of its edges over that of its line
BAND_WORDS = "fast swing: least to largest, mean"
_MARKERS = ("o", "s", "^")  # free, slip, stick
_APART = 0.045  # over the extent of the motion: labels that are closer would cover each other
_LOSSES = ("impact", "friction", "damping", "scheme")
_BRIEF = 0.1  # s: a span that is shorter is shown in ms
#: from which value on, size, name
_PREFIXES = (
    *((1e10, 1e9, "G"), (1e7, 1e6, "M"), (1e4, 1e3, "k"), (0.1, 1.0, "")),
    *((1e-4, 1e-3, "m"), (1e-99, 1e-6, "µ")),
)


class Runs(NamedTuple):
    """Histories that are drawn together, what they are called, and the colours."""

    histories: Sequence[History]
    names: Sequence[str]
    theme: Theme = LIGHT

    def look(self, number: int) -> tuple[str, Dash]:
        """Return colour and dash of a run."""
        return self.theme.series[number % len(self.theme.series)], _DASHES[number % len(_DASHES)]


def runs_of(story: Story) -> Runs:
    """Return the runs of a story."""
    return Runs(story.histories, story.names or ("",), story.style.colours)


# Curves over time ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Curve:
    """A curve: times (s) and values, (samples,)."""

    time: Array
    values: Array
    colour: str
    label: str
    dash: Dash = "-"


@dataclass(frozen=True)
class Curves:
    """Curves over time of one unit."""

    title: str
    unit: str
    curves: Sequence[Curve]


class Clock(NamedTuple):
    """Where times are on axes: the first and last one (s), from times (n,) to places (n,), and the label."""

    first: float
    last: float
    at: Callable[[Array], Array]
    label: str


def clock(first: float, last: float) -> Clock:
    """Return the clock of physical time from one time (s) to another: in s, or in ms where that is short."""
    size, unit = (1e3, "ms") if last - first < _BRIEF else (1.0, "s")
    return Clock(first, last, lambda times: size * times, f"time ({unit})")


def contact_forces(runs: Runs) -> Curves:
    """Return the normal force of each run, the sum of its contacts; of a single run the tangential force too."""
    normal = [np.nan_to_num(history["lambda_n"].values) for history in runs.histories]
    if len(normal) > 1:
        return _each_run(runs, "normal force", "N", normal)
    (history,), colour = runs.histories, runs.theme.arrow
    of_all = ", of all contacts" if history.data.sizes["contact"] > 1 else ""
    time = history["time"].values
    tangential = np.nan_to_num(history["lambda_tau"].values)
    curves = [
        Curve(time, normal[0], colour, f"normal{of_all}"),
        Curve(time, tangential, colour, f"tangential{of_all}", "--"),
    ]
    return Curves("contact force", "N", curves)


def forces(runs: Runs) -> Curves:
    """Return the contact forces, or without any the deflections."""
    if any(np.nan_to_num(history["lambda_n"].values).any() for history in runs.histories):
        return contact_forces(runs)
    return variable(runs, "deflection", "deflection of the tip")


def gap(runs: Runs) -> Curves:
    """Return the gap of the contact point of each run, on a compliant stop its compression, negative."""
    return _each_run(runs, "gap", "m", [contact_gap(history) for history in runs.histories])


def energy(runs: Runs) -> Curves:
    """Return kinetic, elastic, gravity, stop and total energy of a run, or the totals of several.

    Where gravity's energy, counted from the root, keeps farther from zero in the first run than it moves, they are
    changes since the start: the weight of a strip that stands or hangs would hide them.
    """
    theme, kinds = runs.theme, ("kinetic", "elastic", "gravity")
    parts = [
        [*(history[f"energy_{kind}"].values for kind in kinds), _contact_energy(history)]
        for history in runs.histories
    ]
    title, gravity = "energy", parts[0][2]
    if np.ptp(gravity) < np.abs(gravity).min():
        title, parts = "energy change", [[values - values[0] for values in part] for part in parts]
    totals = [np.sum(part, axis=0) for part in parts]
    if len(totals) > 1:
        return _each_run(runs, f"total {title}", "J", totals)
    rows = zip(parts[0], (*theme.energies, theme.series[1]), (*kinds, "stop"), strict=True)
    time = runs.histories[0]["time"].values
    curves = [Curve(time, values, colour, label) for values, colour, label in rows]
    shown = curves if parts[0][3].any() else curves[:3]
    return Curves(title, "J", [*shown, Curve(time, totals[0], theme.ink, "total")])


def _contact_energy(history: History) -> Array:
    """Return what stops and contact flexibilities hold (J), (samples,); 0 where an older file does not say."""
    known = "energy_contact" in history
    return np.asarray(history["energy_contact"].values if known else np.zeros(history["time"].size))


def variable(runs: Runs, name: str, title: str) -> Curves:
    """Return a variable of each run, along the beam at its last station."""
    values = [history[name].values.reshape(history["time"].size, -1)[:, -1] for history in runs.histories]
    return _each_run(runs, title, str(runs.histories[0][name].attrs.get("units", "1")), values)


def _each_run(runs: Runs, title: str, unit: str, values: Sequence[Array]) -> Curves:
    """Return a curve for each run; that of a single one has no label."""
    labels = runs.names if len(values) > 1 else ("",)
    curves = []
    for number, (history, found, label) in enumerate(zip(runs.histories, values, labels, strict=True)):
        colour, dash = runs.look(number)
        curves.append(Curve(history["time"].values, np.asarray(found), colour, label, dash))
    return Curves(title, unit, curves)


def draw_curves(
    axes: Axes,
    panel: Curves,
    clock: Clock,
    spans: Array | Sequence[Any] = (),
    shade: str = LIGHT.line,
    pixels: tuple[float, float] | None = None,
    width: float = 1.4,
    unit: tuple[float, str] | None = None,
) -> bool:
    """Draw curves over the times of a clock, with `spans` of time (spans, 2) in the colour `shade` behind them.

    Returns whether there are bands, which `BAND_WORDS` name in a legend.

    Values are in the `unit` of this size and prefix, without one in that in which they read well.  On axes of some
    size in `pixels` what swings faster than they can show is drawn as a band.  Lines have some `width` (points).
    """
    left, right = clock.at(np.array([clock.first, clock.last])).tolist()
    axes.set_xlim(left, right)
    for span in spans:
        if span[1] >= clock.first and span[0] <= clock.last:
            axes.axvspan(*clock.at(np.asarray(span)), color=shade, alpha=0.6, linewidth=0)
    shown = [(c, (c.time >= clock.first) & (c.time <= clock.last)) for c in panel.curves]
    size, prefix = unit or unit_for([curve.values[inside] for curve, inside in shown])
    has_bands = False
    for curve, inside in shown:
        if not inside.any():
            continue
        x, y = clock.at(curve.time[inside]), curve.values[inside] / size
        if pixels:
            pixel = (right - left) / pixels[0]
            line = drawn((x - left) / pixel, y, float(np.ptp(y)) / pixels[1])
            x, y = left + pixel * line.x, line.y
            has_bands = has_bands or bool(line.bands)
            for band in line.bands:
                edges = left + pixel * band.x
                axes.fill_between(edges, band.low, band.high, color=curve.colour, alpha=BAND, linewidth=0.0)
                # outlined, so that bands over each other can be told apart
                for bound in (band.low, band.high):
                    axes.plot(edges, bound, color=curve.colour, alpha=_EDGE, linewidth=0.5 * width)
        axes.plot(x, y, linestyle=curve.dash, color=curve.colour, linewidth=width, label=curve.label or None)
    axes.set(xlabel=clock.label, ylabel=f"{panel.title} ({prefix}{panel.unit})")
    return has_bands


def unit_for(values: Sequence[Array] | Sequence[list[float]]) -> tuple[float, str]:
    """Return the unit in which values, in SI units, read well: its size and its prefix, from µ to G."""
    sizes = np.abs(np.concatenate(values))
    largest = float(sizes[np.isfinite(sizes)].max(initial=0.0))
    return next(((unit, name) for least, unit, name in _PREFIXES if largest >= least), (1.0, ""))


# Along the beam -----------------------------------------------------------------------------------------------


def envelope(history: History, name: str) -> tuple[Array, Array]:
    """Return the least and the largest value over the run of a variable along the beam, (stations,) each.

    Of a run that blew up it is that of the finite values.  Raises KeyError for a variable that there is not.
    """
    data = history.section_forces() if name in SECTION_FORCES else history
    values = np.asarray(data[name].values, dtype=float)
    finite = np.isfinite(values)
    return np.where(finite, values, np.inf).min(axis=0), np.where(finite, values, -np.inf).max(axis=0)


def draw_envelope(axes: Axes, runs: Runs, what: str) -> None:
    """Draw the least and the largest value in the runs of one of `ENVELOPES`, along the beam."""
    name = ENVELOPES[what]
    found = [envelope(history, name) for history in runs.histories]
    unit, prefix = unit_for([values for both in found for values in both])
    for number, (history, both) in enumerate(zip(runs.histories, found, strict=True)):
        station, (colour, dash) = history["station"].values, runs.look(number)
        low, high = (values / unit for values in both)
        axes.fill_between(station, low, high, color=colour, alpha=BAND, linewidth=0.0)
        for values, label in ((low, runs.names[number]), (high, None)):
            axes.plot(station, values, linestyle=dash, color=colour, linewidth=1.2, label=label)
    data = runs.histories[0].section_forces() if name in SECTION_FORCES else runs.histories[0]
    axes.set(xlabel="place along the beam (m)", ylabel=f"{what} ({prefix}{data[name].attrs['units']})")
    axes.set_title(f"{what.capitalize()}: least and largest")
    axes.set_xlim(0.0, max(float(history["station"][-1]) for history in runs.histories))


def draw_shapes(axes: Axes, story: Story) -> None:
    """Draw the deflection of the first run from the chord, in its first collision, or in the run."""
    history, theme = story.histories[0], story.style.colours
    collision, times = next(iter(history.macro_collisions), None), history["time"].values
    start, end = (collision["start"], collision["end"]) if collision else (0.0, times[-1])
    station, deflection = history["station"].values, 1e3 * history["uy"].values
    for t in np.linspace(start, end, 9):
        sample = int(last_sample(times, t))
        chord = deflection[sample, -1] * station / station[-1]
        state = int(history["state"][sample])
        axes.plot(station, deflection[sample] - chord, linewidth=1.2, color=theme.states[state])
    for state in sorted(set(history["state"].values.tolist())):
        axes.plot([], [], label=state_name(state, history.scenario), color=theme.states[state])
    title = "Shapes in the first collision" if collision else "Shapes"
    axes.set(xlabel="place along the beam (m)", ylabel="deflection from the chord (mm)", title=title)
    axes.set_xlim(0.0, station[-1])
    axes.legend()


def draw_places(axes: Axes, runs: Runs, clock: Clock) -> None:
    """Draw where the first run touches over time, with the scale of colours of its force."""
    scale = draw_contact_map(axes, runs.histories[0], runs.theme, (clock.first, clock.last), clock.at)
    bar = axes.figure.colorbar(scale, ax=axes, label="normal force (N)", ticks=MaxNLocator(5), pad=0.01)
    bar.outline.set_visible(False)
    axes.set(xlabel=clock.label, ylabel="place along the beam (m)")


# The run ------------------------------------------------------------------------------------------------------


def draw_motion(axes: Axes, story: Story) -> None:
    """Draw positions of the first run up to its first collision, or to its end, in the plane of motion."""
    geometry, theme = story.geometries[0].true, story.style.colours
    history, times = geometry.history, geometry.times
    collision = next(iter(history.macro_collisions), None)
    end = collision["start"] if collision else times[-1]
    # equal steps of the tip's way rather than of time: the beam starts slowly
    steps = np.diff([history[name].values[: int(np.searchsorted(times, end)) + 1] for name in ("tip_x", "tip_y")])
    way = np.append(0.0, np.nancumsum(np.hypot(*steps)))
    samples = np.searchsorted(way, np.linspace(0.0, way[-1], 6))
    edge = 1.2 if story.thickness > 1.0 else 0.0  # so that a thin beam can be seen
    for sample in samples:
        strength = 1.0 if sample == samples[-1] else 0.35
        axes.fill(*geometry.outline(sample).T, color=theme.states[0], alpha=strength, linewidth=edge)
    for obstacle in story.obstacles:
        axes.fill(*obstacle.outline.T, color=theme.slope, gid="slope")
        axes.plot(*obstacle.surface.T, color=theme.slope_edge, linewidth=1.6)
    axes.plot(history["tip_x"], history["tip_y"], color=theme.dim, linewidth=0.7, linestyle=":")
    axes.plot(0.0, 0.0, "o", color=theme.ink, markersize=7, zorder=5)
    labelled = np.full(2, np.inf)
    for sample in samples[::-1]:
        tip, last = geometry.stations_at(sample)[-1], sample == samples[-1]
        if np.hypot(*(tip - labelled)) > _APART * max(axes.dataLim.size):
            # that of the last position lies ahead of it
            offset = 7.0, (4.0 if steps[1].sum() > 0.0 else -16.0) if last else 3.0
            label = axes.annotate(f"{times[sample]:.3f} s", tip, xytext=offset, textcoords="offset points")
            label.set(fontsize=7.5, color=theme.dim)
            labelled = tip
    axes.annotate(geometry.inner_point, (0.0, 0.0), xytext=(-6, -14), textcoords="offset points", fontsize=8)
    axes.margins(x=0.12, y=0.14)
    # of an upright beam the panel is not narrower than its labels
    middle, half = np.mean(axes.get_xlim()), 0.3 * np.ptp(axes.get_ylim())
    axes.set_xlim(min(middle - half, axes.get_xlim()[0]), max(middle + half, axes.get_xlim()[1]))
    title = "The beam up to the first impact" if history.contacts else "The beam on its way"
    axes.set(xlabel="x (m)", ylabel="y (m)", title=title, aspect="equal")


def draw_losses(axes: Axes, runs: Runs) -> None:
    """Draw what took energy from the runs, as bars."""
    width, rows = 0.8 / len(runs.histories), []
    for balance in (history.balance for history in runs.histories):
        # what rounding leaves is nothing: it would be all there is to see of a run that loses none
        noise = 1e-9 * max(abs(balance["initial"]), abs(balance["kinetic"]) + abs(balance["elastic"]))
        rows.append([lost if abs(lost) > noise else 0.0 for lost in (balance[f"lost_{kind}"] for kind in _LOSSES)])
    unit, prefix = unit_for(rows)
    for number, (name, lost) in enumerate(zip(runs.names, rows, strict=True)):
        places = np.arange(len(_LOSSES)) + (number - 0.5 * (len(rows) - 1)) * width
        heights = np.array(lost) / unit
        bars = axes.bar(places, heights, width=0.92 * width, color=runs.look(number)[0], label=name)
        turned = 90.0 if len(rows) > 2 else 0.0  # else they would cover each other
        labels = [f"{height:.3g}" for height in heights]
        axes.bar_label(bars, labels=labels, fontsize=7, padding=2, rotation=turned)
    axes.set(ylabel=f"energy lost ({prefix}J)", title="Where the energy went")
    axes.set_xticks(range(len(_LOSSES)), _LOSSES)
    axes.margins(y=0.15)
    if not np.any(rows):
        axes.set_ylim(0.0, 1.0)
    if len(rows) > 1:
        axes.legend()


def draw_differences(axes: Axes, runs: Runs) -> None:
    """Draw how far the events of two runs are apart, on a logarithmic scale that ends at rounding."""
    left, right = runs.histories
    times = np.array([event.time for event in left.events])
    differences = np.abs(times - np.array([event.time for event in right.events]))
    for state in State:
        mine = np.array([event.state == state for event in left.events])
        if mine.any():
            look = {
                "color": runs.theme.states[state],
                "markersize": 5,
                "label": f"to {state_name(state, left.scenario)}",
            }
            axes.semilogy(times[mine], np.maximum(differences[mine], 1e-15), _MARKERS[state], **look)
    title = f"Event times: |{' − '.join(runs.names)}|"
    axes.set(xlabel="time of the event (s)", ylabel="difference (s)", title=title)
    axes.set_xlim(0.0, float(left["time"][-1]))
    axes.legend(loc="upper left")


def first_collision(runs: Runs) -> tuple[float, float] | None:
    """Return from when to when the first collision of some runs is shown (s)."""
    spans = [history.macro_collisions[0] for history in runs.histories if history.macro_collisions]
    if not spans:
        return None
    start, end = min(span["start"] for span in spans), max(span["end"] for span in spans)
    margin = 0.08 * (end - start) + 1e-5
    return start - margin, end + margin

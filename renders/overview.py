"""A run at a glance: the beam on its way, the contact force, the energy, two histories compared."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from oblique_impact.contact.state import State
from oblique_impact.history.history import History
from oblique_impact.history.sample_times import last_sample
from oblique_impact.renders.charts import energy_chart, unit_for
from oblique_impact.renders.contact_map import draw_contact_map
from oblique_impact.renders.files import Drawing, save_figure
from oblique_impact.renders.geometry import contact_gap
from oblique_impact.renders.story import Story, story_of
from oblique_impact.renders.style import LIGHT, Style, Theme, figure_style
from oblique_impact.renders.timeline import contact_spans

#: texts of vector graphics as text, not as outlines
_AS_TEXT: dict[Any, Any] = {"svg.fonttype": "none", "pdf.fonttype": 42}
_MARKERS = ("o", "s", "^")  # free, slip, stick
_DASHES = ("-", (0, (4, 2)), (0, (1, 1.5)), (0, (6, 2, 1, 2)))
_APART = 0.045  # over the extent of the motion: labels that are closer would cover each other
_LOSSES = ("impact", "friction", "damping", "scheme")


def overview_figure(histories: dict[str, History], out: Path, theme: Theme = LIGHT, title: str = "") -> Path:
    """Draw one or several histories as :func:`overview` does; returns the file.

    In SVG and PDF what is written stays text.
    """
    with figure_style(theme), mpl.rc_context(_AS_TEXT):
        return save_figure(overview(histories, theme, title), out, "overview.png", histories.values())


def overview(histories: dict[str, History], theme: Theme = LIGHT, title: str = "") -> Figure:
    """Draw one or several histories of the same case, named by their keys, in the colours of a theme.

    Without a `title` the figure has that of the first scenario.
    With two histories that share their events, the last panel shows how far apart these are.  Where several places
    of the beam can touch, one more panel, below, shows those of the first history over time.
    """
    first = next(iter(histories.values()))
    story = story_of([first], Style(deformation=1.0))
    title = title or story.geometries[0].scenario.title
    collision = next(iter(first.summary["macro_collisions"]), None)
    kinds = [[(event.kind, event.state) for event in history.events] for history in histories.values()]
    with figure_style(theme):
        mapped = "contact_place" in first and bool(first.contacts)
        figure = Drawing(figsize=(9.2, 11.6 if mapped else 9.0), layout="constrained")
        if title:
            figure.suptitle(title, x=0.01, ha="left", fontsize=12, fontweight="bold")
        heights = (1.25, 1.0, 1.0, 1.0) if mapped else (1.25, 1.0, 1.0)
        grid = figure.add_gridspec(len(heights), 2, height_ratios=heights)
        axes = np.array([[figure.add_subplot(grid[row, column]) for column in range(2)] for row in range(3)])
        _draw_motion(axes[0, 0], story, theme, collision["start"] if collision else float(first["time"][-1]))
        _draw_shapes(axes[0, 1], first, theme, collision)
        if any(history.contacts for history in histories.values()):
            _draw_force(axes[1, 0], histories, theme)
            _draw_gap(axes[1, 1], histories, theme)
        else:
            _draw_free(
                axes[1, 0], histories, theme, ("deflection", 1e3, "Deflection of the tip", "deflection (mm)")
            )
            _draw_free(axes[1, 1], histories, theme, ("theta_dot", 1.0, "Rate of rotation", "rate (rad/s)"))
        _draw_energy(axes[2, 0], histories, theme)
        if len(histories) == 2 and kinds[0] and kinds[0] == kinds[1]:
            _draw_differences(axes[2, 1], histories, theme)
        else:
            _draw_losses(axes[2, 1], histories, theme)
        panels = [*axes.flat]
        if mapped:
            panels.append(figure.add_subplot(grid[3, :]))
            _draw_places(panels[-1], first, theme)
        for letter, panel in zip("abcdefg", panels, strict=False):
            panel.set_title(f"({letter}) {panel.get_title(loc='left')}")
        return figure


def _curves(histories: dict[str, History], theme: Theme) -> Iterator[tuple[History, dict[str, Any]]]:
    """Yield histories with the style of their lines."""
    for (name, history), colour, dash in zip(histories.items(), theme.series, _DASHES, strict=False):
        yield history, {"color": colour, "linestyle": dash, "label": name}


def _draw_motion(axes: Axes, story: Story, theme: Theme, end: float) -> None:
    geometry = story.geometries[0]
    history, times = geometry.history, geometry.times
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


def _draw_shapes(axes: Axes, history: History, theme: Theme, collision: dict[str, Any] | None) -> None:
    """Draw the deflection from the pin-tip chord during the first collision, or the run."""
    times = history["time"].values
    start, end = (collision["start"], collision["end"]) if collision else (0.0, times[-1])
    station, deflection = history["station"].values, 1e3 * history["uy"].values
    for t in np.linspace(start, end, 9):
        sample = int(last_sample(times, t))
        chord = deflection[sample, -1] * station / station[-1]
        state = int(history["state"][sample])
        axes.plot(station, deflection[sample] - chord, linewidth=1.2, color=theme.states[state])
    for state in sorted(set(history["state"].values.tolist())):
        axes.plot([], [], label=State(state).name.lower(), color=theme.states[state])
    title = "Shapes in the first collision" if collision else "Shapes"
    axes.set(
        xlabel="arc length (m)", ylabel="deflection from the chord (mm)", title=title, xlim=(0.0, station[-1])
    )
    axes.legend()


def _draw_force(axes: Axes, histories: dict[str, History], theme: Theme) -> None:
    for history, style in _curves(histories, theme):
        axes.plot(1e3 * history["time"].values, history["lambda_n"], **style)
    collision = _first_collision(histories.values())
    what = "First collision: contact force" if collision else "Contact force"
    axes.set(xlabel="time (ms)", ylabel="normal force (N)", title=what)
    if collision:
        axes.set_xlim(1e3 * collision[0], 1e3 * collision[1])
        shown = [history["lambda_n"].sel(time=slice(*collision)).values for history in histories.values()]
        axes.set_ylim(top=1.06 * np.nanmax(np.concatenate(shown)))
    axes.set_ylim(bottom=0.0)
    if any(histories):  # a single run may have no name
        axes.legend()


def _first_collision(histories: Iterable[History]) -> tuple[float, float] | None:
    """Return from when to when the first collision of some histories is shown (s)."""
    spans = [h.summary["macro_collisions"][0] for h in histories if h.summary["macro_collisions"]]
    if not spans:
        return None
    start, end = min(span["start"] for span in spans), max(span["end"] for span in spans)
    margin = 0.08 * (end - start) + 1e-5
    return start - margin, end + margin


def _draw_places(axes: Axes, history: History, theme: Theme) -> None:
    scale = draw_contact_map(axes, history, theme, _first_collision([history]))
    bar = axes.figure.colorbar(scale, ax=axes, label="normal force (N)", ticks=MaxNLocator(5), pad=0.01)
    bar.outline.set_visible(False)
    title = "First collision: where the beam touches (hatched: it sticks)"
    axes.set(xlabel="time (ms)", ylabel="place along the beam (m)", title=title)


def _draw_gap(axes: Axes, histories: dict[str, History], theme: Theme) -> None:
    first = next(iter(histories.values()))
    for history, style in _curves(histories, theme):
        axes.plot(history["time"], 1e3 * contact_gap(history), **style)
    for start, end in contact_spans(first):
        axes.axvspan(start, end, color=theme.states[1], alpha=0.25, linewidth=0)
    what = "obstacles" if "contact_place" in first else "the slope"
    title = f"Distance from {what} (contact shaded)"
    axes.set(xlabel="time (s)", ylabel="gap (mm)", title=title, xlim=(0.0, float(first["time"][-1])))


def _draw_free(axes: Axes, histories: dict[str, History], theme: Theme, what: tuple[str, float, str, str]) -> None:
    """Draw a variable of runs without contact, times a factor, with a title and a label."""
    variable, factor, title, label = what
    for history, style in _curves(histories, theme):
        axes.plot(history["time"], factor * history[variable], **style)
    axes.set(xlabel="time (s)", ylabel=label, title=title)
    if len(histories) > 1:
        axes.legend()


def _draw_energy(axes: Axes, histories: dict[str, History], theme: Theme) -> None:
    first, *others = histories.values()
    whose = f" of {next(iter(histories))}" if others else ""
    title, _, (*parts, total) = energy_chart(story_of([first]))
    totals = energy_chart(story_of([first, *others], names=list(histories)))[2] if others else [total]
    unit, prefix = unit_for([curve.values for curve in (*parts, *totals)])
    for curve, (_, style) in zip(totals, _curves(histories, theme), strict=False):
        label = f"total of {style['label']}" if whose else "total"
        axes.plot(curve.time, curve.values / unit, linewidth=1.8, **style | {"label": label})
    for part, colour in zip(parts, (*theme.energies, theme.series[1]), strict=False):
        axes.plot(part.time, part.values / unit, color=colour, linewidth=0.8, label=f"{part.label}{whose}")
    axes.set(xlabel="time (s)", ylabel=f"{title} ({prefix}J)", title=title.capitalize())
    axes.set_xlim(0.0, float(first["time"][-1]))
    if axes.dataLim.ymin >= 0.0:
        axes.set_ylim(bottom=0.0)
    columns = 3 if others else len(parts) + 1
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=columns, fontsize=7.5, columnspacing=1.2)


def _draw_differences(axes: Axes, histories: dict[str, History], theme: Theme) -> None:
    """Draw differences of event times on a logarithmic scale; what is below rounding is drawn there."""
    left, right = histories.values()
    times = np.array([event.time for event in left.events])
    differences = np.abs(times - np.array([event.time for event in right.events]))
    for state in State:
        mine = np.array([event.state == state for event in left.events])
        if mine.any():
            look = {"color": theme.states[state], "markersize": 5, "label": f"to {state.name.lower()}"}
            axes.semilogy(times[mine], np.maximum(differences[mine], 1e-15), _MARKERS[state], **look)
    title = f"Event times: |{' − '.join(histories)}|"
    axes.set(xlabel="time of the event (s)", ylabel="difference (s)", title=title)
    axes.set_xlim(0.0, float(left["time"][-1]))
    axes.legend(loc="upper left")


def _draw_losses(axes: Axes, histories: dict[str, History], theme: Theme) -> None:
    width, rows = 0.8 / len(histories), []
    for energy in (history.summary["energy"] for history in histories.values()):
        # what rounding leaves is nothing: it would be all there is to see of a run that loses none
        noise = 1e-9 * max(abs(energy["initial"]), abs(energy["kinetic"]) + abs(energy["elastic"]))
        rows.append([lost if abs(lost) > noise else 0.0 for lost in (energy[f"lost_{kind}"] for kind in _LOSSES)])
    unit, prefix = unit_for(rows)
    for number, ((_, style), lost) in enumerate(zip(_curves(histories, theme), rows, strict=False)):
        places = np.arange(len(_LOSSES)) + (number - 0.5 * (len(histories) - 1)) * width
        heights = np.array(lost) / unit
        bars = axes.bar(places, heights, width=0.92 * width, color=style["color"], label=style["label"])
        turned = 90.0 if len(rows) > 2 else 0.0  # else they would cover each other
        labels = [f"{height:.3g}" for height in heights]
        axes.bar_label(bars, labels=labels, fontsize=7, padding=2, rotation=turned)
    axes.set(ylabel=f"energy lost ({prefix}J)", title="Where the energy went")
    axes.set_xticks(range(len(_LOSSES)), _LOSSES)
    axes.margins(y=0.15)
    if not np.any(rows):
        axes.set_ylim(0.0, 1.0)
    if any(histories):
        axes.legend()

"""Diagrams besides the paper's figures: open choices, robustness of the verdicts, stick and why not."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from oblique_impact.contact.state import State
from oblique_impact.renders.style import GREY, SERIES, STATE_COLOURS
from oblique_impact.validation.report.figures import new_figure, to_svg
from oblique_impact.validation.reproduction.claims import PARTLY, VERDICTS
from oblique_impact.validation.reproduction.material import Material
from oblique_impact.validation.reproduction.motions import REVERSAL, STICK
from oblique_impact.validation.reproduction.pictures import HALF, PAPER_LINE, REVERSAL_MARK, STICK_MARK, WHOLE
from oblique_impact.validation.reproduction.runs import Run
from oblique_impact.validation.reproduction.unsaid import Studied

#: colours of the three verdicts, as in the report
VERDICT_COLOURS = ("#1b7a3c", "#d8a24a", "#b3261e")

_WINDOWS = ((1, 0.3125, 0.3345), (2, 0.58, 0.715))  # s, macro-collisions one and two of nearly all variants
_BAR = 0.34


def choices_diagram(studied: Sequence[Studied]) -> str:
    """Draw the times in contact of every variant in both macro-collisions, and the impulses."""
    lines, headings = _lines(studied)
    height = lines[-1][0] + 1.2
    with new_figure(WHOLE, 0.175 * height + 0.9) as figure:
        axes = figure.subplots(1, 3, sharey=True, gridspec_kw={"width_ratios": (1.0, 1.25, 0.7)})
        for part, (number, start, end) in zip(axes, _WINDOWS, strict=False):
            part.set(xlim=(start, end), xlabel="time (s)")
            part.set_title(f"{('first', 'second')[number - 1]} macro-collision", fontsize=8.5)
            part.tick_params(axis="x", labelsize=8)
            part.axvline(REVERSAL if number == 1 else STICK, **PAPER_LINE)
            for place, item in lines:
                _draw_spans(part, place, item, number)
        for place, item in lines:
            _draw_impulses(axes[2], place, item)
        axes[2].set(xlabel="impulse (N s)", xlim=(0.0, 2.1))
        axes[2].set_title("impulses", fontsize=8.5)
        _label_lines(axes[0], lines, headings, height)
        for part in axes:
            part.tick_params(axis="y", length=0)
            part.grid(visible=False, axis="y")
        figure.legend(handles=_choice_legend(), loc="outside lower center", ncols=4, fontsize=8, columnspacing=1.4)
        return to_svg(figure)


def _lines(studied: Sequence[Studied]) -> tuple[list[tuple[float, Studied]], list[tuple[float, str]]]:
    """Heights of the lines, in the order of the study, and of the headings of the choices."""
    lines: list[tuple[float, Studied]] = []
    headings: list[tuple[float, str]] = []
    place, seen = 0.0, ("", "")
    for item in studied:
        choice, label, _ = item.variant
        if choice != seen[0]:
            place += 1.25
            headings.append((place, choice))
        if (choice, label) != seen:
            place += 1.0
        seen = (choice, label)
        offset = 0.0 if choice == "integrator" else (-0.2 if item.scheme == "fixed-step" else 0.2)
        lines.append((place + offset, item))
    return lines, headings


def _draw_spans(axes: Axes, place: float, item: Studied, number: int) -> None:
    if len(item.run.macros) < number:
        return
    macro = item.run.macro(number)
    left = axes.get_xlim()[0]
    if macro.end < left:
        # outside of the window: say where
        shift = 0.0 if item.scheme == "fixed-step" else 0.05
        axes.text(left + shift, place, f" ◂ {macro.start:.3f} s", fontsize=8, va="center", color=GREY)
        return
    fill = 1.0 if item.scheme != "event" or item.variant.choice == "integrator" else 0.55
    axes.plot([macro.start, macro.end], [place, place], color=GREY, linewidth=0.6, zorder=1)
    for start, end, state, _ in item.run.stays_in(macro):
        if end == start:
            axes.plot([start], [place], "|", color=STATE_COLOURS[State.SLIP], markersize=4, zorder=2)
        elif state == State.SLIP:
            colour = STATE_COLOURS[State.SLIP]
            axes.barh(place, end - start, _BAR, start, color=colour, alpha=fill, linewidth=0, zorder=2)
        else:
            # a stay of microseconds would not be seen: its length is drawn, its beginning marked
            axes.barh(place, end - start, _BAR, start, color=STATE_COLOURS[State.STICK], linewidth=0, zorder=3)
            axes.plot([start], [place], "|", color=STATE_COLOURS[State.STICK], markersize=4, zorder=3)
    for time in item.run.reversals_in(macro):
        axes.plot([time], [place], ".", color="black", markersize=2.6, zorder=4)


def _draw_impulses(axes: Axes, place: float, item: Studied) -> None:
    filled = item.scheme != "event" or item.variant.choice == "integrator"
    for row, marker in zip(item.collisions, "os", strict=True):
        face = SERIES[0] if filled else "white"
        axes.plot(
            [row.normal_impulse], [place], marker, color=SERIES[0], markerfacecolor=face, markersize=3.6, zorder=3
        )


def _label_lines(
    axes: Axes, lines: list[tuple[float, Studied]], headings: list[tuple[float, str]], height: float
) -> None:
    places: dict[str, list[float]] = {}
    texts: dict[str, str] = {}
    for place, item in lines:
        key = f"{item.variant.choice}/{item.variant.label}"
        places.setdefault(key, []).append(place)
        texts[key] = item.label
    ticks = [(float(np.mean(places[key])), text) for key, text in texts.items()] + headings
    axes.set_yticks([tick for tick, _ in ticks], [text for _, text in ticks], fontsize=8)
    for label in axes.get_yticklabels()[len(texts) :]:
        label.set_fontweight("bold")
    axes.set_ylim(height, 0.4)


def _choice_legend() -> list[Any]:
    slip, stick = STATE_COLOURS[State.SLIP], STATE_COLOURS[State.STICK]
    impulse: dict[str, Any] = {"linestyle": "none", "color": SERIES[0], "markersize": 4}
    return [
        Patch(color=slip, label="slip, fixed-step (upper)"),
        Patch(color=slip, alpha=0.55, label="slip, event-located (lower)"),
        Line2D([], [], linestyle="none", marker="|", color=stick, markersize=7, label="judged as stick"),
        Line2D([], [], linestyle="none", marker=".", color="black", label="slip reverses"),
        Line2D([], [], marker="o", label="first collision", **impulse),
        Line2D([], [], marker="s", label="second collision", **impulse),
        Line2D([], [], marker="o", markerfacecolor="white", label="open: event-located", **impulse),
        Line2D([], [], **PAPER_LINE, label="paper: 0.325 s, 0.699 s"),
    ]


def robustness_diagram(material: Material) -> str:
    """How many combinations of open choices give which verdict, claim by claim."""
    claims = [judged.claim for judged in material.judged if material.counts(judged.claim.id)]
    with new_figure(WHOLE, 0.23 * len(claims) + 1.0) as figure:
        axes = figure.subplots()
        for place, claim in enumerate(claims):
            left = 0
            for (verdict, count), colour in zip(material.counts(claim.id).items(), VERDICT_COLOURS, strict=True):
                axes.barh(place, count, 0.72, left, color=colour, linewidth=0)
                if count:
                    ink = "black" if verdict == PARTLY else "white"
                    axes.text(
                        left + 0.5 * count, place, str(count), ha="center", va="center", fontsize=8, color=ink
                    )
                left += count
        axes.set_yticks(range(len(claims)), [claim.id for claim in claims], fontsize=8)
        axes.set(
            xlim=(0, len(material.grid)), ylim=(len(claims) - 0.4, -0.6), xlabel="combinations of open choices"
        )
        axes.grid(visible=False)
        axes.tick_params(axis="y", length=0)
        handles = [Patch(color=c, label=v) for v, c in zip(VERDICTS, VERDICT_COLOURS, strict=True)]
        figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=8)
        return to_svg(figure)


def sticking_diagram(run: Run, windows: Sequence[tuple[float, float]], title: str) -> str:
    """Draw slip velocity and the ratio that sticking would need, in some windows of time (s)."""
    half = len(windows) == 1
    with new_figure(HALF if half else WHOLE, 4.3) as figure:
        axes = figure.subplots(2, len(windows), sharex="col", sharey="row", squeeze=False)
        for column, (start, end) in zip(axes.T, windows, strict=True):
            _draw_speed(column[0], run, start, end)
            _draw_ratio(column[1], run, start, end)
            column[1].set_xlabel("time (ms)")
            column[1].set_xlim(1e3 * start, 1e3 * end)
            column[1].xaxis.set_major_locator(MaxNLocator(5))
        axes[0, 0].set_ylabel("slip velocity (m/s)")
        axes[1, 0].set_ylabel("$|\\lambda_\\tau|/\\lambda_n$ to stick (–)")
        _sticking_head(figure, run, title)
        return to_svg(figure)


def _draw_speed(axes: Axes, run: Run, start: float, end: float) -> None:
    inside = run.inside(start, end)
    times, speed, states = 1e3 * run["time"][inside], run["slip_rate"][inside], run["state"][inside]
    axes.plot(times, speed, color=GREY, linewidth=0.7)
    for state in (State.SLIP, State.STICK):
        shown = np.where(states == state, speed, np.nan)
        axes.plot(times, shown, color=STATE_COLOURS[state], linewidth=1.5)
    axes.axhline(0.0, color="black", linewidth=0.6)
    for mark, events in (
        (REVERSAL_MARK, [check.time for check in run.checks if check.kind == "reversal"]),
        (STICK_MARK, [stick.start for stick in run.sticks]),
    ):
        marked = [time for time in events if start <= time <= end]
        if marked:
            axes.plot(1e3 * np.array(marked), [run.at("slip_rate", time) for time in marked], **mark)


def _draw_ratio(axes: Axes, run: Run, start: float, end: float) -> None:
    inside = run.inside(start, end)
    normal, tangential = run["stick_normal"][inside], run["stick_tangential"][inside]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(normal > 0.0, np.abs(tangential) / normal, np.nan)
    axes.semilogy(1e3 * run["time"][inside], ratio, color=SERIES[0], linewidth=1.2)
    mu = run.scenario.contact.mu_static
    axes.axhspan(1e-3, mu, color=STATE_COLOURS[State.STICK], alpha=0.15, linewidth=0)
    axes.axhline(mu, color=STATE_COLOURS[State.STICK], linewidth=0.9)
    axes.set_ylim(1e-2, 1e3)


def _sticking_head(figure: Figure, run: Run, title: str) -> None:
    figure.suptitle(title, fontsize=9, fontweight="bold", x=0.01, ha="left")
    handles = [
        Line2D([], [], color=STATE_COLOURS[State.SLIP], linewidth=1.5, label="slip"),
        Line2D([], [], color=STATE_COLOURS[State.STICK], linewidth=1.5, label="stick"),
        Line2D([], [], **REVERSAL_MARK),
        Line2D([], [], **{**STICK_MARK, "label": "stick begins"}),
        Line2D([], [], color=SERIES[0], linewidth=1.2, label="sticking solution"),
        Patch(color=STATE_COLOURS[State.STICK], alpha=0.15, label=f"below μ = {run.scenario.contact.mu_static:g}"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=8, columnspacing=1.2)

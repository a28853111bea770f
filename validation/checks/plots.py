"""Pictures of the checks; every axis has its unit, every colour one meaning."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from oblique_impact.beam.operators import SpinningBeam
from oblique_impact.history.history import History
from oblique_impact.renders import panels
from oblique_impact.renders.style import SERIES
from oblique_impact.validation.report import HALF, Picture, picture
from oblique_impact.validation.runs import Array

_PUBLISHED: dict[str, Any] = {"linestyle": "none", "marker": "o", "color": "black", "markersize": 4}


@contextmanager
def _drawing(caption: str, height: float, panels: int = 1) -> Iterator[tuple[Picture, Any]]:
    """Make a picture and its axes (several panels: an array of them) to draw on in the block."""
    with picture(caption, HALF, height) as result:
        yield result, result.figure.subplots(1, panels, sharex=True)


def campbell_figure(beams: Mapping[str, SpinningBeam], points: Sequence[tuple[Any, Any]]) -> Picture:
    """Branches of both roots over the spin rate, with the reference points on them."""
    caption = "Campbell diagram: computed branches (lines) and published points (symbols)."
    with _drawing(caption, 4.2, panels=2) as (result, panels):
        eta = np.linspace(0.0, 6.0, 61)
        directions = (("flap", SERIES[0], "o", "-"), ("chord", SERIES[1], "s", "--"))
        for axes, (root, beam), title in zip(panels, beams.items(), ("clamped", "hinged"), strict=True):
            for direction, colour, marker, dash in directions:
                mark = {"color": colour, "marker": marker, "markersize": 4, "markerfacecolor": "none"}
                branch = np.array([(beam.flapwise if direction == "flap" else beam.chordwise)(x, 4) for x in eta])
                axes.semilogy(eta, np.where(branch > 1e-3, branch, np.nan), color=colour, linestyle=dash)
                for (held, radius, speed), values in points:
                    if held == root and radius == 0.0:
                        kept = [value for value in values[direction] if value > 0.0]
                        axes.plot([speed] * len(kept), kept, linestyle="none", **mark)
                axes.plot([], [], label=f"{direction}wise", linestyle=dash, **mark)
            axes.set(xlabel="spin rate / sqrt(EI/(m L⁴))", title=f"{title} root")
        panels[0].set_ylabel("frequency / sqrt(EI/(m L⁴))")
        panels[1].legend(loc="lower right")
    return result


def spin_up_figure(zeroth: History, first: History, full: History, table: Mapping[float, float]) -> Picture:
    """Tip deflections of the three kinetic orders with the tabulated points."""
    caption = "Spin-up to 6 rad/s in 15 s, three modes: zeroth-order kinetics leave the picture."
    runs = panels.Runs((first, full, zeroth), ("first order", "full", "zeroth order"))
    with _drawing(caption, 3.6) as (result, axes):
        deflection = panels.variable(runs, "deflection", "tip deflection")
        panels.draw_curves(axes, deflection, panels.clock(0.0, 20.0), unit=(1.0, ""))
        axes.plot(list(table), list(table.values()), label="reference (first order)", **_PUBLISHED)
        axes.set(ylim=(-1.0, 0.4))
        axes.legend(loc="upper right", ncols=2)
    return result


def published_impact_figure(runs: Mapping[str, History], times: Array, exact: Array) -> Picture:
    """Tip displacement of VPCS SDNL32 with the published points."""
    names = [f"computed, {name}" for name in runs]
    with _drawing("VPCS SDNL32: impact on a spring of 18 000 N/m, 1 % modal damping.", 3.2) as (result, axes):
        displacement = panels.variable(panels.Runs([*runs.values()], names), "tip_y", "tip displacement")
        panels.draw_curves(axes, displacement, panels.clock(0.0, 0.013), unit=(1e-3, "m"))
        axes.plot(1e3 * times, 1e3 * exact, label="published", **_PUBLISHED)
        axes.legend()
    return result


def impulse_law_figure(meshes: Mapping[str, tuple[Array, Array]], exact: tuple[Array, Array]) -> Picture:
    """Impulse on a held tip against the exact series."""
    caption = "Impulse of a rigid stop that holds the tip: meshes approach the exact law."
    curves = [
        panels.Curve(*course, colour, name) for (name, course), colour in zip(meshes.items(), SERIES, strict=False)
    ]
    curves.append(panels.Curve(*exact, "black", "exact series", "--"))
    with _drawing(caption, 3.4) as (result, axes):
        clock = panels.clock(0.0, float(exact[0][-1]))
        panels.draw_curves(axes, panels.Curves("impulse", "N s", curves), clock, width=1.1)
        axes.set(xlabel="time after the touch (ms)", ylim=(0.0, None))
        axes.legend(loc="lower right")
    return result


def tolerance_figure(rows: Sequence[tuple[str, Array]]) -> Picture:
    """Error over tolerance of every measurement, a line for each group."""
    caption = (
        "Every measurement: its error over its tolerance; right of the line it fails. "
        "Ratios below 10⁻⁶ stand there."
    )
    with _drawing(caption, 0.32 * len(rows) + 0.9) as (result, axes):
        for place, (_, ratios) in enumerate(rows):
            shown = np.clip(np.nan_to_num(ratios, nan=1e3), 1e-6, 1e3)
            bad = ~(ratios <= 1.0)
            axes.semilogx(shown[~bad], np.full((~bad).sum(), place), "|", color=SERIES[0], markersize=11)
            axes.semilogx(shown[bad], np.full(bad.sum(), place), "X", color=SERIES[4], markersize=7)
        axes.axvline(1.0, color="black", linewidth=1.0)
        axes.set(xlim=(5e-7, 2e3), ylim=(len(rows) - 0.4, -0.6), xlabel="error / tolerance")
        axes.set_yticks(range(len(rows)), [name for name, _ in rows])
        axes.grid(visible=False, axis="y")
    return result

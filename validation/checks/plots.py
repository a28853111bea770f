"""Pictures of the checks; every axis has its unit, every colour one meaning."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from oblique_impact.beam.operators import SpinningBeam
from oblique_impact.history.history import History
from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.validation.report.document import Picture
from oblique_impact.validation.report.figures import HALF, new_figure, to_svg
from oblique_impact.validation.runs import column

Array = NDArray[np.float64]
_MARKERS = "osD^vPX*"


def _slope_guide(axes: Any, x: Array, y: float, order: float, text: str) -> None:
    """Draw a dashed line of a slope through the last point."""
    axes.loglog(x, y * (x / x[-1]) ** order, color=GREY, linewidth=0.9, linestyle="--", zorder=1)
    middle = len(x) // 2
    at = x[middle], y * (x[middle] / x[-1]) ** order
    axes.annotate(text, at, xytext=(-4, -3), textcoords="offset points", color=GREY, ha="right", va="top")


def frequency_errors_figure(meshes: Array, errors: Mapping[str, Array], roots: Mapping[str, Array]) -> Picture:
    """Relative frequency errors (meshes, modes) against b h, on one line (b h)⁴/1440."""
    with new_figure(HALF, 3.6) as figure:
        axes = figure.subplots()
        for colour, (name, table) in zip(SERIES, errors.items(), strict=False):
            for k in range(table.shape[1]):
                label = f"{name}-free" if k == 0 else None
                axes.loglog(
                    roots[name][k] / meshes, table[:, k], _MARKERS[k], color=colour, label=label, markersize=5
                )
        x = np.array([0.05, 3.0])
        axes.loglog(x, x**4 / 1440.0, color=GREY, linewidth=1.0, label="(b h)⁴/1440")
        axes.set(
            xlabel="b h (–): root times element length over the beam's", ylabel="relative frequency error (–)"
        )
        axes.legend()
        svg = to_svg(figure)
    return Picture(
        svg, "Frequency errors of Hermite elements, modes 1 to 3 (circle, square, diamond), 4 to 32 elements."
    )


def campbell_figure(beams: Mapping[str, SpinningBeam], points: Sequence[tuple[Any, Any]]) -> Picture:
    """Branches of both roots over the spin rate, with the reference points on them."""
    with new_figure(HALF, 4.2) as figure:
        panels = figure.subplots(1, 2, sharex=True)
        eta = np.linspace(0.0, 6.0, 61)
        for axes, (root, beam), title in zip(panels, beams.items(), ("clamped", "hinged"), strict=True):
            for direction, colour, marker in (("flap", SERIES[0], "o"), ("chord", SERIES[1], "s")):
                branch = np.array([(beam.flapwise if direction == "flap" else beam.chordwise)(x, 4) for x in eta])
                axes.semilogy(
                    eta,
                    np.where(branch > 1e-3, branch, np.nan),
                    color=colour,
                    linestyle="-" if direction == "flap" else "--",
                )
                for (held, radius, speed), values in points:
                    if held == root and radius == 0.0:
                        kept = [v for v in values[direction] if v > 0.0]
                        axes.plot(
                            [speed] * len(kept), kept, marker, color=colour, markersize=4, markerfacecolor="none"
                        )
                axes.plot(
                    [],
                    [],
                    color=colour,
                    marker=marker,
                    markerfacecolor="none",
                    label=f"{direction}wise",
                    linestyle="-" if direction == "flap" else "--",
                    markersize=4,
                )
            axes.set(xlabel="spin rate / sqrt(EI/(m L⁴)) (–)", title=f"{title} root")
        panels[0].set_ylabel("frequency / sqrt(EI/(m L⁴)) (–)")
        panels[1].legend(loc="lower right")
        svg = to_svg(figure)
    return Picture(svg, "Campbell diagram: computed branches (lines) and published points (symbols).")


def spin_up_figure(zeroth: History, first: History, full: History, table: Mapping[float, float]) -> Picture:
    """Tip deflections of the three kinetic orders with the tabulated points."""
    with new_figure(HALF, 3.6) as figure:
        axes = figure.subplots()
        for history, name, colour, dash in (
            (zeroth, "zeroth order", SERIES[4], ":"),
            (first, "first order", SERIES[0], "-"),
            (full, "full", SERIES[1], "--"),
        ):
            axes.plot(column(history, "time"), column(history, "deflection"), dash, color=colour, label=name)
        axes.plot(
            list(table), list(table.values()), "o", color="black", markersize=3.5, label="reference (first order)"
        )
        axes.set(xlabel="time (s)", ylabel="tip deflection (m)", ylim=(-1.0, 0.4), xlim=(0.0, 20.0))
        axes.legend(loc="upper right", ncols=2)
        svg = to_svg(figure)
    return Picture(svg, "Spin-up to 6 rad/s in 15 s, three modes: zeroth-order kinetics leave the picture.")


def published_impact_figure(curves: Mapping[str, tuple[Array, Array]], times: Array, exact: Array) -> Picture:
    """Tip displacement of VPCS SDNL32 with the published points."""
    with new_figure(HALF, 3.2) as figure:
        axes = figure.subplots()
        for (name, (t, y)), colour, dash in zip(curves.items(), SERIES, ("-", "--"), strict=False):
            axes.plot(1e3 * t, 1e3 * y, dash, color=colour, label=f"computed, {name}")
        axes.plot(1e3 * times, 1e3 * exact, "o", color="black", markersize=4, label="published")
        axes.set(xlabel="time (ms)", ylabel="tip displacement (mm)", xlim=(0.0, 13.0))
        axes.legend()
        svg = to_svg(figure)
    return Picture(svg, "VPCS SDNL32: impact on a spring of 18 000 N/m, 1 % modal damping.")


def impulse_law_figure(curves: Mapping[str, tuple[Array, Array]], exact: tuple[Array, Array]) -> Picture:
    """Impulse on a held tip against the exact series."""
    with new_figure(HALF, 3.4) as figure:
        axes = figure.subplots()
        for (name, (t, y)), colour in zip(curves.items(), SERIES, strict=False):
            axes.plot(1e3 * t, y, color=colour, linewidth=1.0, label=name)
        axes.plot(1e3 * exact[0], exact[1], color="black", linewidth=1.2, linestyle="--", label="exact series")
        axes.set(xlabel="time after the touch (ms)", ylabel="impulse (N s)", xlim=(0.0, 2.05), ylim=(0.0, None))
        axes.legend(loc="lower right")
        svg = to_svg(figure)
    return Picture(svg, "Impulse of a rigid stop that holds the tip: meshes approach the exact law.")


def energy_figure(history: History) -> Picture:
    """Energies of the paper's case over time."""
    with new_figure(HALF, 3.2) as figure:
        axes = figure.subplots()
        time = column(history, "time")
        axes.plot(time, history.total_energy.values, color="black", label="total")
        for kind, colour in zip(("kinetic", "gravity", "elastic"), SERIES, strict=False):
            axes.plot(time, column(history, f"energy_{kind}"), color=colour, label=kind, linewidth=1.1)
        axes.set(xlabel="time (s)", ylabel="energy (J)", xlim=(0.0, float(time[-1])))
        axes.legend(ncols=4, loc="lower left", bbox_to_anchor=(-0.01, 1.0))
        svg = to_svg(figure)
    return Picture(svg, "Energies of the paper's case (hybrid, two modes): the total falls only in contacts.")


def mesh_convergence_figure(meshes: Array, errors: Array) -> Picture:
    """Largest event-time difference over the number of elements."""
    with new_figure(HALF, 3.2) as figure:
        axes = figure.subplots()
        axes.loglog(meshes, errors, "o-", color=SERIES[0], label="largest difference of a contact time")
        _slope_guide(axes, np.asarray(meshes, dtype=float), 0.3 * float(errors[-1]), -4.0, "order 4")
        axes.set(
            xlabel="elements (–)",
            ylabel="time difference (s)",
            xticks=meshes,
            xticklabels=[str(n) for n in meshes],
        )
        axes.minorticks_off()
        axes.legend()
        svg = to_svg(figure)
    return Picture(svg, "Finite elements against six assumed modes: contact times of the first macro-collision.")


def orders_figure(curves: Mapping[str, tuple[Array, Array, float]]) -> Picture:
    """Errors over steps with the declared slopes."""
    with new_figure(HALF, 4.0) as figure:
        axes = figure.subplots()
        colours = (*SERIES, "black")
        for (name, (steps, errors, order)), colour, marker in zip(curves.items(), colours, _MARKERS, strict=False):
            axes.loglog(steps, errors, marker, color=colour, label=f"{name} (order {order:g})", markersize=5)
            axes.loglog(
                steps, errors[-1] * (steps / steps[-1]) ** order, color=colour, linewidth=0.9, linestyle="--"
            )
        axes.set(xlabel="step (s)", ylabel="error (rad, rad/s, m)")
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
        svg = to_svg(figure)
    return Picture(
        svg, "Errors of each scheme (symbols) and lines of the declared order through the last of them."
    )


def tolerance_figure(rows: Sequence[tuple[str, Array]]) -> Picture:
    """Error over tolerance of every measurement, a line for each group."""
    with new_figure(HALF, 0.32 * len(rows) + 0.9) as figure:
        axes = figure.subplots()
        for place, (_, ratios) in enumerate(rows):
            shown = np.clip(np.nan_to_num(ratios, nan=1e3), 1e-6, 1e3)
            bad = ~(ratios <= 1.0)
            axes.semilogx(shown[~bad], np.full((~bad).sum(), place), "|", color=SERIES[0], markersize=11)
            axes.semilogx(shown[bad], np.full(bad.sum(), place), "X", color=SERIES[4], markersize=7)
        axes.axvline(1.0, color="black", linewidth=1.0)
        axes.set(
            xlim=(5e-7, 2e3),
            ylim=(len(rows) - 0.4, -0.6),
            xlabel="error / tolerance (–)",
            yticks=range(len(rows)),
            yticklabels=[name for name, _ in rows],
        )
        axes.grid(visible=False, axis="y")
        svg = to_svg(figure)
    return Picture(
        svg,
        "Every measurement: its error over its tolerance; right of the line it fails. "
        "Ratios below 10⁻⁶ stand there.",
    )

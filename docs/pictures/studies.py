"""Pictures of studies and of the library: refinement, the paper's numbers, checks, sweeps, parts, charts."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from oblique_impact.contact.friction import Coulomb, ModifiedCoulomb
from oblique_impact.contact.state import State
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.renders.style import GREY, LIGHT, SERIES, STATE_COLOURS, figure_style
from oblique_impact.validation import refine, sweep, validate

from .mechanics import paper
from .paper import FOLDER, label, new_figure, shade_contacts

HOWTO = FOLDER.parent / "howto"


def blocks(page: str, language: str) -> list[str]:
    """Return the code blocks of a how-to."""
    text = (HOWTO / page).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def refinement() -> Figure:
    """A quantity over the size of the elements, with its limit, and the differences with their order."""
    case = Scenario.builtin("paper", ["discretization.method=fem", "end_time=0.34"])
    study = refine(case, elements=[4, 8, 16, 32], quantities=["first_impact", "impulse"], workers=1)
    with figure_style():
        figure = new_figure(2.9)
        left, right = figure.subplots(1, 2)
        levels = np.array([4.0, 8.0, 16.0, 32.0])
        found = study.quantity("impulse")
        analysis, values = found.analysis, np.array(found.values)
        left.loglog(
            1.0 / levels, np.abs(values - analysis.limit), "o-", color=SERIES[0], label=r"$|f_i - f_\infty|$"
        )
        left.loglog(
            1.0 / levels[-1],
            analysis.uncertainty,
            "_",
            ms=16,
            mew=2.0,
            color=SERIES[1],
            label="uncertainty $u$ of $f_1$",
        )
        left.set(xlabel="size $h$ (1)", ylabel="impulse (N s)")
        left.set_xticks(1.0 / levels, [f"1/{n:.0f}" for n in levels])
        left.minorticks_off()
        left.legend(loc="upper left")
        for number, name in enumerate(("first_impact", "impulse")):
            numbers = np.array(study.quantity(name).values)
            changes = np.abs(np.diff(numbers)) / np.abs(numbers[-1])
            right.loglog(1.0 / levels[1:], changes, "o-", color=SERIES[number], label=name.replace("_", " "))
            order = study.quantity(name).analysis.order
            label(right, (1.0 / levels[-1], changes[-1]), f"p = {order:.2f}", (26.0, 0.0), fontsize=8.5)
        right.set(xlabel="size $h$ of the finer level (1)", ylabel="relative change (1)")
        right.set_xticks(1.0 / levels[1:], [f"1/{n:.0f}" for n in levels[1:]])
        right.minorticks_off()
        right.legend(loc="upper left")
    return figure


def results() -> Figure:
    """The normal force through the first macro-collision, and the events of the table."""
    with figure_style():
        figure = new_figure(4.5)
        every = figure.subplots(2, 1, sharex=True)
        for axes, friction in zip(every, ("frictionless", "hybrid"), strict=True):
            history = paper(f"contact.friction={friction}")
            time = 1e3 * history["time"].values
            shade_contacts(axes, history, 1e3)
            axes.plot(time, history["lambda_n"].values, color=SERIES[0])
            if friction == "hybrid":
                axes.plot(time, history["lambda_tau"].values, color=STATE_COLOURS[State.SLIP], ls=(0, (3, 1.5)))
                label(axes, (325.65, 290.0), r"$\lambda_n$", (0.0, 9.0), color=SERIES[0])
                label(axes, (325.65, -85.0), r"$\lambda_\tau$", (0.0, 12.0), color=STATE_COLOURS[State.SLIP])
            for event in history.events:
                axes.axvline(1e3 * event.time, color=GREY, lw=0.8, ls=":")
                axes.annotate(
                    f"{event.kind.value} {1e3 * event.time:.4f}",
                    (1e3 * event.time, 612.0),
                    rotation=90,
                    fontsize=7,
                    ha="right",
                    va="top",
                    xytext=(-1.5, 0.0),
                    textcoords="offset points",
                    color=LIGHT.dim,
                )
            axes.set(ylabel="force (N)", ylim=(-125.0, 620.0), xlim=(316.5, 331.0))
            axes.set_title(friction, loc="right")
        every[1].set(xlabel="time (ms)")
    return figure


def check() -> Figure:
    """Errors of a group of checks over what each may be."""
    found = validate(only=["frequencies", "rods"], quick=True, workers=1)
    with figure_style():
        figure = new_figure(2.7)
        axes = figure.subplots()
        groups = sorted({result.group for result in found})
        for group, colour in zip(groups, SERIES, strict=False):
            rows = [n for n, result in enumerate(found) if result.group == group]
            parts = [max(found[n].error / found[n].tolerance, 1e-8) for n in rows]
            axes.semilogy(rows, parts, "o", ms=4.0, color=colour, label=group)
        axes.axhline(1.0, color="#b03a48", lw=1.2)
        label(axes, (len(found) - 1, 1.0), "allowed", (0.0, 7.0), ha="right", color="#b03a48", fontsize=8.5)
        axes.set(xlabel="measurement", ylabel="error over tolerance (1)", ylim=(1e-8, 30.0), xlim=(-1, len(found)))
        axes.legend(loc="lower right", title="group", ncols=2)
    return figure


def cluster() -> Figure:
    """What the sweep of the page finds."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "friction.toml"
        file.write_text(blocks("cluster.md", "toml")[0], encoding="utf-8")
        table = sweep(file, Path(folder) / "out", workers=1).frame
    with figure_style():
        figure = new_figure(2.8)
        left, right = figure.subplots(1, 2, sharex=True)
        for (slope, rows), colour in zip(table.groupby("slope.angle"), SERIES, strict=False):
            style: dict[str, Any] = {"color": colour, "ms": 3.0, "label": f"{np.degrees(slope):.0f}°"}
            left.plot(rows["contact.mu_kinetic"], rows["energy_lost"], "o-", lw=1.0, **style)
            right.plot(rows["contact.mu_kinetic"], rows["lost_friction"], "o-", lw=1.0, **style)
        left.set(xlabel="coefficient of friction (1)", ylabel="energy lost (J)")
        right.set(xlabel="coefficient of friction (1)", ylabel="of it to friction (J)")
        right.legend(title="slope")
    return figure


def own_parts() -> Figure:
    """The laws of the page beside built-in ones."""
    names: dict[str, Any] = {}
    for block in blocks("own-parts.md", "python")[:2]:
        exec(block, names)
    laws = {
        "Coulomb": Coulomb(0.3, 0.3),
        "modified Coulomb": ModifiedCoulomb(0.3),
        "viscous Coulomb, 5 s/m": names["ViscousCoulomb"](viscous=5.0),
    }
    base = Scenario.builtin("paper", ["contact.normal=spring", "end_time=0.3206", "solver.output_interval=1e-6"])
    stops = {
        "spring, 1e6 N/m": ElasticStop(1e6, 0.3),
        "Hertz, 1e8 N/m$^{1.5}$": names["Hertz"](damping=0.3),
    }
    with figure_style():
        figure = new_figure(2.9)
        left, right = figure.subplots(1, 2)
        speeds = np.concatenate([-np.geomspace(0.03, 1e-6, 300), np.geomspace(1e-6, 0.03, 300)])
        for (name, law), colour, dash in zip(laws.items(), SERIES, ("-", (0, (4, 2)), "-"), strict=False):
            ratio = []
            for v in speeds:
                branch = law.branch(float(v), int(np.sign(v)))
                ratio.append(branch.intercept + branch.slope * v)
            left.plot(speeds, ratio, color=colour, ls=dash, label=name)
        left.set(
            xlabel=r"slip rate $\dot{Z}_\tau$ (m/s)", ylabel=r"$\lambda_\tau / \lambda_n$ (1)", ylim=(-0.5, 0.85)
        )
        left.legend(loc="upper right")
        for (name, stop), colour in zip(stops.items(), SERIES, strict=False):
            history = simulate(base, contact_law=stop)
            normal = history["lambda_n"].values
            pressed = normal > 1e-6
            right.plot(-1e3 * history["gap"].values[pressed], normal[pressed], color=colour, label=name)
        right.set(xlabel="depth (mm)", ylabel=r"$\lambda_n$ (N)", ylim=(0.0, None))
        right.legend(loc="upper left")
    return figure


def library() -> Figure:
    """The chart that the page draws."""
    base = Scenario.builtin("paper", ["end_time=0.34"])
    names: dict[str, Any] = {
        "history": simulate(base),
        "fem": simulate(base.replace(discretization__method="fem")),
        "Figure": lambda **options: new_figure(
            2.8, **{k: v for k, v in options.items() if k not in ("figsize", "layout")}
        ),
    }
    (block,) = [block for block in blocks("library.md", "python") if "figure_style" in block]
    with tempfile.TemporaryDirectory() as folder:
        exec(block.replace('"out/force.svg"', repr(f"{folder}/force.svg")), names)
    return names["figure"]

"""Pictures of studies: refinement, and the numbers of the paper's case."""

from __future__ import annotations

import re

import numpy as np
from matplotlib.figure import Figure

from oblique_impact import Scenario
from oblique_impact.renders.style import PAGE, figure_style
from oblique_impact.validation import refine

from .mechanics import paper
from .paper import FOLDER, GREY, SERIES, SLIP, label, new_figure, shade_contacts

HOWTO = FOLDER.parent / "howto"


def blocks(page: str, language: str) -> list[str]:
    """Return the code blocks of a how-to."""
    text = (HOWTO / page).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def refinement() -> Figure:
    """A quantity over the size of the elements, with its limit, and the differences with their order."""
    case = Scenario.builtin("paper", ["discretization.method=fem", "end_time=0.34"])
    study = refine(case, elements=[4, 8, 16, 32], quantities=["first_impact", "impulse"], workers=1)
    with figure_style(PAGE):
        figure = new_figure(2.9)
        left, right = figure.subplots(1, 2)
        levels = np.array([4.0, 8.0, 16.0, 32.0])
        analysis, every = study["impulse"], study.tables["levels"]["value"]
        values = every["impulse"].to_numpy()
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
            numbers = every[name].to_numpy()
            changes = np.abs(np.diff(numbers)) / np.abs(numbers[-1])
            right.loglog(1.0 / levels[1:], changes, "o-", color=SERIES[number], label=name.replace("_", " "))
            order = study[name].order
            label(right, (1.0 / levels[-1], changes[-1]), f"p = {order:.2f}", (26.0, 0.0), fontsize=8.5)
        right.set(xlabel="size $h$ of the finer level (1)", ylabel="relative change (1)")
        right.set_xticks(1.0 / levels[1:], [f"1/{n:.0f}" for n in levels[1:]])
        right.minorticks_off()
        right.legend(loc="upper left")
    return figure


def results() -> Figure:
    """The normal force through the first macro-collision, and the events of the table."""
    with figure_style(PAGE):
        figure = new_figure(4.5)
        every = figure.subplots(2, 1, sharex=True)
        for axes, friction in zip(every, ("frictionless", "hybrid"), strict=True):
            history = paper(f"contact.friction={friction}")
            time = 1e3 * history["time"].values
            shade_contacts(axes, history, 1e3)
            axes.plot(time, history["lambda_n"].values, color=SERIES[0])
            if friction == "hybrid":
                axes.plot(time, history["lambda_tau"].values, color=SLIP, ls=(0, (3, 1.5)))
                label(axes, (325.65, 290.0), r"$\lambda_n$", (0.0, 9.0), color=SERIES[0])
                label(axes, (325.65, -85.0), r"$\lambda_\tau$", (0.0, 12.0), color=SLIP)
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
                    color=GREY,
                )
            axes.set(ylabel="force (N)", ylim=(-125.0, 620.0), xlim=(316.5, 331.0))
            axes.set_title(friction, loc="right")
        every[1].set(xlabel="time (ms)")
    return figure

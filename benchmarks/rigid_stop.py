"""Ensembles on stiff, rigid and damped stops, convergence and losses: the pictures of docs/convergence.md.

python benchmarks/rigid_stop.py      simulates what docs/rigid-stop.json lacks (half an hour), then draws
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oblique_impact import Outcome, Scenario, simulate
from oblique_impact.renders.style import PAGE, figure_style
from oblique_impact.validation.studies.predictability import perturbed_runs
from oblique_impact.validation.studies.study import run_study

DOCS = Path(__file__).parents[1] / "docs"
STORE = DOCS / "rigid-stop.json"

BASE = ("discretization.frame=mean-axis", "contact.friction=frictionless", "solver.output_interval=1e-2")
NODAL = (
    *BASE,
    "discretization.method=fem",
    "discretization.modes=0",
    "solver.free_step=1e-5",
    "solver.rho_infinity=1.0",
)
MASSLESS, SPRING, DAMPED = "contact.point_inertia=none", "contact.normal=spring", "beam.kelvin_voigt=1e-5"
PERTURBATIONS = (1e-6, 1e-3)  # rad
LIMIT = 0.659474  # s; start of the second macro-collision of the damped beam

#: elements, contact step (s) and what else is changed
ENSEMBLES = {
    "spring\n1e6 N/m": (32, 1e-6, (SPRING, "contact.stiffness=1e6", "end_time=0.9")),
    "spring\n1e7 N/m": (32, 1e-6, (SPRING, "contact.stiffness=1e7")),
    "spring\n1e8 N/m": (64, 2.5e-7, (SPRING, "contact.stiffness=1e8")),
    "spring\n1e9 N/m": (64, 2.5e-7, (SPRING, "contact.stiffness=1e9")),
    "rigid\n16 elements": (16, 1e-6, (MASSLESS,)),
    "rigid\n32 elements": (32, 5e-7, (MASSLESS,)),
    "rigid\n64 elements": (64, 2.5e-7, (MASSLESS,)),
    "rigid\ndamped": (32, 1e-6, (MASSLESS, DAMPED)),
}
#: Kelvin-Voigt damping (s), elements that resolve it, contact step (s)
LOSSES = (
    (1e-3, 16, 2e-6),
    (3e-4, 24, 2e-6),
    (1e-4, 32, 1e-6),
    (3e-5, 48, 1e-6),
    (1e-5, 64, 5e-7),
    (3e-6, 96, 5e-7),
    (1e-6, 128, 3e-7),
    (3e-7, 160, 2e-7),
    (1e-7, 224, 5e-8),
)
ALPHA = ("discretization.method=fem", "discretization.modes=0", "solver.free_step=5e-6")
#: methods that converge to the same limit: name -> level -> changes
WAYS: dict[str, dict[float, tuple[str, ...]]] = {
    "no inertia, modes": {n: (MASSLESS, f"discretization.modes={n}") for n in (8, 12, 16, 20, 24)},
    "plastic, modes": {n: (f"discretization.modes={n}",) for n in (8, 12, 16, 24, 32)},
    "plastic, elements": {
        n: (*ALPHA, f"discretization.elements={n}", f"solver.contact_step={3.2e-5 / n}") for n in (8, 16, 32, 64)
    },
    "spring, stiffness (1e8 N/m)": {
        k: (SPRING, f"contact.stiffness={k * 1e8}", "discretization.modes=24") for k in (1, 10, 100, 1000)
    },
}


def main() -> None:
    """Simulate what is missing, and draw."""
    data = json.loads(STORE.read_text()) if STORE.exists() else {}
    for name, (elements, step, changes) in ENSEMBLES.items():
        if name not in data:
            words = (*NODAL, f"discretization.elements={elements}", f"solver.contact_step={step}", "end_time=0.73")
            keep(data, name, ensemble(Scenario.builtin("paper", [*words, *changes])))
    for viscosity, elements, step in LOSSES:
        name = f"loss {viscosity:g}"
        if name not in data:
            words = (*NODAL, MASSLESS, f"discretization.elements={elements}", f"solver.contact_step={step}")
            damped = (f"beam.kelvin_voigt={viscosity}", "end_time=0.335", "solver.output_interval=1e-3")
            history = simulate(Scenario.builtin("paper", [*words, *damped]))
            assert history.outcome is Outcome.COMPLETED, history.outcome
            energy = history.summary["energy"]
            keep(data, name, energy["initial"] - energy["final"])
    for way, levels in WAYS.items():
        for level, changes in levels.items():
            if (name := f"{way}: {level:g}") not in data:
                words = (*BASE, DAMPED, "end_time=0.73", *changes)
                collisions = simulate(Scenario.builtin("paper", list(words))).summary["macro_collisions"]
                keep(data, name, collisions[1]["start"])
    draw_ensembles(data)
    draw_limit(data)


def keep(data: dict[str, Any], name: str, value: Any) -> None:
    """Keep a number as soon as it is there."""
    data[name] = value
    STORE.write_text(json.dumps(data, indent=1, sort_keys=True) + "\n")
    print(name.replace("\n", ", "), flush=True)


def ensemble(scenario: Scenario) -> list[list[float]]:
    """Return offsets of the angle (rad), starts of the second collision (s), impulses (N s), contacts."""
    frame = run_study(perturbed_runs(scenario, PERTURBATIONS, count=6))
    offsets = frame["initial.angle"] - scenario.initial.angle
    names = ("start:2", "collision_impulse:1", "collision_contacts:1")
    return [offsets.tolist(), *(frame[name].tolist() for name in names)]


def draw_ensembles(data: dict[str, Any]) -> None:
    """Draw the starts of the second collision of every run."""
    with figure_style(PAGE):
        figure = Figure(figsize=(9.2, 3.9), layout="constrained")
        axes = figure.subplots()
        for place, name in enumerate(ENSEMBLES):
            offsets, starts = np.array(data[name][0]), np.array(data[name][1])
            # side by side in the order of their angles
            spread = np.argsort(np.argsort(offsets)) / (len(offsets) - 1) - 0.5
            for low, high, colour, label in (
                (2e-6, 1.0, PAGE.series[1], "within 1e-3 rad"),
                (-1.0, 2e-6, PAGE.series[0], "within 1e-6 rad"),
            ):
                chosen = (np.abs(offsets) > low) & (np.abs(offsets) <= high)
                axes.plot(
                    place + 0.7 * spread[chosen],
                    starts[chosen],
                    "o",
                    color=colour,
                    markersize=5,
                    label=label if place == 0 else None,
                )
        axes.set_xticks(range(len(ENSEMBLES)), list(ENSEMBLES))
        axes.set(ylabel="second macro-collision starts (s)", ylim=(0.65, 0.73))
        axes.annotate(
            "all at 0.865 s",
            (0.0, 0.728),
            ha="center",
            va="top",
            color=PAGE.dim,
            fontsize=9,
            arrowprops=None,
            annotation_clip=False,
        )
        axes.legend(loc="upper right", title="initial angle")
        figure.savefig(DOCS / "rigid-stop-ensembles.svg", metadata={"Date": None})


def draw_limit(data: dict[str, Any]) -> None:
    """Draw the errors of the methods, and the energy lost in a collision over the damping."""
    with figure_style(PAGE):
        figure = Figure(figsize=(9.2, 3.9), layout="constrained")
        left, right = figure.subplots(1, 2)
        for index, (way, levels) in enumerate(WAYS.items()):
            errors = [abs(data[f"{way}: {level:g}"] - LIMIT) for level in levels]
            left.loglog(list(levels), errors, "o-", color=PAGE.series[index], markersize=4.5, label=way)
        left.set(
            xlabel="modes, elements, or stiffness in 1e8 N/m", ylabel="error of the second collision's start (s)"
        )
        left.legend(fontsize=8.5)
        lost = [data[f"loss {viscosity:g}"] for viscosity, _, _ in LOSSES]
        right.semilogx([viscosity for viscosity, _, _ in LOSSES], lost, "o-", color=PAGE.series[0])
        right.set(
            xlabel="Kelvin-Voigt damping (s)", ylabel="energy lost in the first collision (J)", ylim=(0.0, None)
        )
        _damping_ratio(right)
        figure.savefig(DOCS / "rigid-stop-limit.svg", metadata={"Date": None})


def _damping_ratio(axes: Axes) -> None:
    """Second scale: damping ratio of the first elastic mode, eta omega_1/2 with omega_1 = 384.9 rad/s."""
    half = 384.854 / 2.0
    upper = axes.secondary_xaxis(
        "top", functions=(lambda eta: 100.0 * half * eta, lambda part: part / half / 100.0)
    )
    upper.set_xlabel("of critical damping, first mode (%)")


if __name__ == "__main__":
    main()

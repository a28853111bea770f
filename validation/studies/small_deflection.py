"""Range of validity of small deflections: the floating frame against the exact beam, over flexibility and spin.

Beams in units of L = rho A = E I = 1 (unit of time T = sqrt(rho A L^4/E I)), loaded more and more, so that the
largest deflection goes from some thousandths of the length to about a half of it:

`held`       the root turns at the rate eta, and the weight bends the beam
`hub`        a hub, thirty times as heavy to turn as the beam, spins at the rate eta, and a torque bends the beam
`light hub`  the same with a hub of a twentieth of the beam's inertia
`pendulum`   a pinned beam starts horizontally with the rate eta and falls
`stop`       the root turns at a constant rate and pushes the beam's end on an elastic stop

What is compared is the deflection of the tip, from the tangent of the root or from the mean axis, as the model's
frame is: the error is the largest difference from the exact beam within two periods of the first elastic mode,
over the largest deflection.  On the stop it is that of the largest force.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from oblique_impact.beam.frequencies import lowest_elastic_frequency
from oblique_impact.beam.small_deflection import NOTICEABLE
from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import writing
from oblique_impact.progress import OnProgress, silent
from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.report import Report, Section, Table, Text, picture
from oblique_impact.validation.report.parameters import differing, parameters
from oblique_impact.validation.studies.parallel import check_limits
from oblique_impact.validation.studies.study import Run, run_study

#: nominal deflections over the length, and spin rates in units of 1/T
DEFLECTIONS = (0.003, 0.01, 0.03, 0.1, 0.2, 0.4)
SPINS = (0.0, 4.0)
#: E A L^2/E I of 1e8: neither extension nor shear nor rotary inertia shows
BEAM = {"length": 1.0, "area": 1.0, "density": 1.0, "youngs_modulus": 1e8, "second_moment": 1e-8}
_EXACT_ELEMENTS, _EXACT_STEPS = 10, 1000
#: samples of a run; of a model on the stop, whose largest force is looked for among them
_SAMPLES, _SAMPLES_OF_FORCE = 200, 4000
#: turn (rad) in an elastic period up to which so many steps are enough: sections turn by an angle, places along a
#: chord, which differ like the square of the turn in a step
_SLOW = 4.0
#: errors that are those of the model: smaller ones may be of the exact beam's step, larger ones of another motion
_CLEAR = (0.01, 0.5)
#: inertia of the beam about its root, rho A L^3
_BEAM = 1.0 / 3.0
_STOP = 50.0  # E I/L^3: the beam's end follows its stop for about as long as the beam vibrates


def _models(frame: str, modes: int, *orders: str) -> dict[str, dict[str, Any]]:
    """Return models by name, each as changes of a scenario."""
    return {
        f"{frame.replace('-', ' ')}, {order.replace('-', ' ')}": {
            "discretization__kinetics": order,
            "discretization__frame": frame,
            "discretization__modes": modes,
        }
        for order in orders
    }


_ALL = ("zeroth-order", "first-order", "full")
#: problem -> model -> changes
MODELS: dict[str, dict[str, dict[str, Any]]] = {
    "held": _models("tangent", 6, *_ALL),
    "hub": _models("tangent", 6, *_ALL),
    "light hub": _models("tangent", 6, *_ALL),
    "pendulum": _models("mean-axis", 6, *_ALL) | _models("tangent", 4, *_ALL[1:]),
    "stop": _models("tangent", 6, *_ALL[1:]),
}


@dataclass(frozen=True)
class Case:
    """A loaded beam."""

    #: "pin", "hub" or "driven"
    root: str
    #: "gravity", "torque" (of a hub) or "stop" (of a driven root)
    load: str
    #: deflection over the length that sets the load
    nominal: float = 0.1
    #: initial angular velocity, of a driven root for good (1/T)
    spin: float = 0.0
    #: inertia of the hub over that of the beam
    hub: float = 0.0
    #: of the beam at the start, from the horizontal (rad)
    angle: float = 0.0
    #: of the stop (E I/L^3)
    stiffness: float = _STOP

    @property
    def period(self) -> float:
        """Period of the first elastic mode of the beam on its root (T)."""
        root = {"kind": self.root} | ({"inertia": self.hub * _BEAM} if self.root == "hub" else {})
        beam = Scenario.from_dict({"beam": BEAM, "root": root, "contact": {"enabled": False}})
        return 2.0 * math.pi / lowest_elastic_frequency(beam)

    @property
    def scenario(self) -> Scenario:
        """The case, to be marched by any model.

        The load follows from small deflections: under a sudden angular acceleration a the tip of a clamped beam
        comes to twice 11 rho A a L^5/(120 E I), under gravity g to twice rho A g L^4/(8 E I); that of a beam that
        falls about a pin to about rho A g L^4/(160 E I) from its mean axis.  Over a stop a root that turns by an
        angle bends the beam by about as much.
        """
        end, inertia = 2.0 * self.period, self.hub * _BEAM
        scenario: dict[str, Any] = {
            "end_time": end,
            "gravity": 0.0,
            "beam": BEAM,
            "root": {"kind": self.root},
            "initial": {"angle": self.angle, "angular_velocity": 0.0 if self.root == "driven" else self.spin},
            "slope": {"origin": [0.5, 0.0], "angle": 0.0},
            "contact": {"enabled": False},
            "solver": {"output_interval": end / _SAMPLES, "tolerance": 1e-8},
        }
        if self.load == "gravity":
            free = 0.0 if self.root == "driven" else 1.0 / (1.0 + self.hub)
            scenario["gravity"] = self.nominal / (0.25 * (1.0 - free) + free / 160.0)
        if self.root == "hub":
            acceleration = self.nominal * 120.0 / 22.0 if self.load == "torque" else 0.0
            scenario["root"] |= {"inertia": inertia, "torque": acceleration * (inertia + _BEAM)}
        if self.root == "driven":
            rate = -self.nominal / end if self.load == "stop" else self.spin
            scenario["root"] |= {"profile": "constant-speed" if rate else "hold", "spin_rate": rate}
        if self.load == "stop":
            scenario["contact"] = {"normal": "spring", "stiffness": self.stiffness, "friction": "frictionless"}
            scenario["initial"]["angle"] = min(0.001, 0.1 * self.nominal)  # it meets the stop soon
            scenario["solver"]["output_interval"] = end / _SAMPLES_OF_FORCE
        return Scenario.from_dict(scenario)

    def exact(self, frame: str) -> Scenario:
        """Return the case for the exact beam, seen from a frame."""
        base, root = self.scenario, self.scenario.root
        turn = (abs(self.spin) + abs(root.torque) / (root.inertia + _BEAM) * base.end_time) * base.end_time
        step = base.end_time / (_EXACT_STEPS * min(math.ceil(max(1.0, turn / _SLOW)), 4))
        near = {"solver__contact_step": step} if base.contact.enabled else {}
        return base.replace(
            discretization__method="absolute",
            discretization__elements=_EXACT_ELEMENTS,
            discretization__frame=frame,
            solver__free_step=step,
            solver__output_interval=max(step, base.solver.output_interval),  # a shorter one would cut its steps
            **near,
        )


#: problem -> its root and load
PROBLEMS = {
    "held": Case("driven", "gravity"),
    "hub": Case("hub", "torque", hub=30.0),
    "light hub": Case("hub", "torque", hub=0.05),
    "pendulum": Case("pin", "gravity"),
    "stop": Case("driven", "stop"),
}


@dataclass(frozen=True, repr=False)
class SmallDeflection:
    """The map.

    Attributes
    ----------
    points : DataFrame
        A row for each model of each case: problem, model, nominal (deflection over length that sets the load),
        spin (1/T), deflection (the largest of the exact beam over its length, from the model's axis), relative
        error (NaN where the model has none), estimate (what the run says of itself) and outcome.
    seconds : float
        Wall time (s).
    """

    points: pd.DataFrame
    seconds: float

    def __repr__(self) -> str:
        """Return a line for each model of each problem."""
        return "\n".join(["<SmallDeflection>", *lines(self)])

    def _repr_html_(self) -> str:
        """Show the head of the report in a notebook."""
        return report(self)._repr_html_()

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each model of each case: `points`."""
        return self.points


def _runs(problem: str, nominal: float, spin: float) -> list[Run]:
    """Return the runs of a case: all models, and behind them the exact beam in their frames."""
    case = replace(PROBLEMS[problem], nominal=nominal, spin=spin)
    times = np.linspace(0.0, case.scenario.end_time, _SAMPLES + 1).tolist()
    compared = ["max:lambda_n"] if case.load == "stop" else [f"deflection@{time!r}" for time in times]
    names = (*compared, "max:deflection", "min:deflection", "model_error")
    scenarios = {model: case.scenario.replace(**changes) for model, changes in MODELS[problem].items()}
    frames = dict.fromkeys(changes["discretization__frame"] for changes in MODELS[problem].values())
    scenarios |= {f"exact, {frame}": case.exact(frame) for frame in frames}
    return [
        Run({"problem": problem, "nominal": nominal, "spin": spin, "model": model}, scenario, names)
        for model, scenario in scenarios.items()
    ]


def points_of(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the points of the map from the runs: a row for each model of each case."""
    points = []
    for (problem, nominal, spin), runs in frame.groupby(["problem", "nominal", "spin"], sort=False):
        runs = runs.set_index("model")
        compared = [
            name for name in runs if name.startswith(("deflection@", "max:lambda_n")) and runs[name].notna().any()
        ]
        for model, changes in MODELS[problem].items():
            run, reference = runs.loc[model], runs.loc[f"exact, {changes['discretization__frame']}"]
            error = (run[compared] - reference[compared]).abs().max() / reference[compared].abs().max()
            outcomes = [one["outcome"] for one in (reference, run) if one["outcome"] != Outcome.COMPLETED.label]
            points.append(
                {
                    "problem": problem,
                    "model": model,
                    "nominal": nominal,
                    "spin": spin,
                    "deflection": max(reference["max:deflection"], -reference["min:deflection"]),
                    "error": math.nan if outcomes else float(error),
                    "estimate": run["model_error"],
                    "outcome": (outcomes or [Outcome.COMPLETED.label])[0],
                }
            )
    return pd.DataFrame(points)


def small_deflection(
    *,
    deflections: Sequence[float] = DEFLECTIONS,
    spins: Sequence[float] = SPINS,
    out: str | os.PathLike[str] | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    timeout: float | None = None,
    on_progress: OnProgress = silent,
) -> SmallDeflection:
    """Compare the floating frame with the exact beam, over flexibility and spin rate.

    Parameters
    ----------
    deflections : sequence of float
        Nominal deflections over the length, from above 0 to 1.
    spins : sequence of float
        Spin rates in units of sqrt(E I/(rho A L^4)), from 0 to 20.
    out : path, optional
        Folder for report.html, results.json and results.csv, where an interrupted study goes on.
    scheduler, workers, timeout, on_progress
        As for :func:`~oblique_impact.validation.studies.study.run_study`.

    Raises
    ------
    InputError
        In one line for numbers that are out of range or a folder that cannot be written.
    """
    for name, values, low, high in (("deflections", deflections, 0.0, 1.0), ("spins", spins, -1.0, 20.0)):
        if not values or not all(low < value <= high for value in values):
            shown = ",".join(f"{value:g}" for value in values)
            raise InputError(f"{name} {shown}: should be from {max(low, 0.0):g} to {high:g}")
    runs = [
        run
        for problem in MODELS
        for nominal in deflections
        # the stop is met at rest: a spin is none of its loads
        for spin in (spins if problem != "stop" else spins[:1])
        for run in _runs(problem, nominal, spin)
    ]
    started = time.perf_counter()
    check_limits(scheduler, workers, timeout)
    with writing(out):
        frame = run_study(
            runs, out, scheduler=scheduler, workers=workers, timeout=timeout, on_progress=on_progress
        )
        points = points_of(frame)
        result = SmallDeflection(points, time.perf_counter() - started)
        if out is not None:
            data = {"study": "small-deflection", "points": points}
            report(result).write(Path(out), data, points)
    return result


def lines(result: SmallDeflection) -> list[str]:
    """Return what the study found in lines, for a terminal."""
    found = []
    for (problem, model), points in result.points.groupby(["problem", "model"], sort=False):
        clear = points[points["error"].between(*_CLEAR)]
        coefficient = (clear["error"] / clear["deflection"] ** 2).median()
        worst = points["error"][points["nominal"] == points["nominal"].min()].max()
        words = f"error {coefficient:.2g} (w/L)^2, at least {worst:.1e} at the fastest spin"
        found.append(f"{problem + ',':10} {model:26} {words}")
    return found


# --- report

TITLES = {
    "held": "Held root, bent by the weight",
    "hub": "Heavy hub, bent by a torque",
    "light hub": "Hub of 1/20 of the beam's inertia",
    "pendulum": "Pinned beam that falls and turns",
    "stop": "Held root, pushed on an elastic stop",
}
_NOTE = (
    "A curve that ends early has runs that physics stopped: first-order kinetics in the tangent frame lose their "
    "mass. What rises to the left, up to 2 %, is the step of the exact beam at a fast spin."
)
_COLUMNS = {
    "model": "model",
    "nominal": "nominal deflection / length",
    "spin": "spin rate",
    "deflection": "largest deflection / length",
    "error": "relative error",
    "estimate": "estimate of the run",
    "outcome": "outcome",
}
#: inches, of the map
SIZE = (12.5, 9.5)
#: a colour for each model, and a line for each spin rate in ascending order
COLOURS = {
    "tangent, zeroth order": SERIES[5],
    "mean axis, zeroth order": SERIES[5],
    "tangent, first order": SERIES[0],
    "tangent, full": SERIES[1],
    "mean axis, first order": SERIES[2],
    "mean axis, full": SERIES[3],
}
_LINES: tuple[Any, ...] = ("-", "--", "-.", ":")
_LIMITS = (1e-4, 10.0)
#: a load that bends the beam by less than this more than the one before is not drawn: all models have failed
_MORE = 1.2


def report(result: SmallDeflection) -> Report:
    """Return the report."""
    least = result.points.groupby("problem", sort=False)[["nominal", "spin"]].min()
    cases = {
        TITLES[row.Index]: replace(PROBLEMS[row.Index], nominal=row.nominal, spin=row.spin).scenario
        for row in least.itertuples()
    }
    with picture("Relative error over the largest deflection", 9.2, 9.2 * SIZE[1] / SIZE[0]) as drawn:
        draw_map(drawn.figure, result.points)
    return Report(
        "Where the small-deflection model ends",
        "The floating frame bends linearly, and knows the shortening to the second order. Loads grow along the "
        "lower axis: nominal is the deflection over the length that sets a load, deflection the largest one of "
        "the exact beam. The error is that of the deflection of the tip from the model's axis, its largest "
        "difference from the geometrically exact beam within two elastic periods, over the largest deflection; "
        "on a stop it is that of the largest force; the estimate is what a run says of its own error. Spin rates "
        "are in units of sqrt(EI/(ρA L⁴)); the first clamped mode has 3.52.",
        result.seconds,
        overview=[drawn, Text(_NOTE, note=True)],
        sections=[
            *(
                Section(
                    TITLES[problem], [Table.of_frame(frame, f"{TITLES[problem]}.", digits=3, columns=_COLUMNS)]
                )
                for problem, frame in result.points.groupby("problem", sort=False)
            ),
            Section("Cases", [differing(cases)]),
            *parameters(cases, "Of the smallest load without spin."),
        ],
    )


def draw_map(figure: Figure, points: pd.DataFrame) -> None:
    """Draw errors over deflections, a panel for each problem, a colour for each model, a line for each spin."""
    panels = figure.subplots(2, 3, sharey=True)
    for axes, problem in zip(panels.flat, MODELS, strict=False):
        _draw_panel(axes, points[points["problem"] == problem])
        axes.set_title(TITLES[problem], fontsize=10)
        quantity = "largest force" if problem == "stop" else "deflection"
        axes.set_ylabel(f"relative error of the {quantity}")
    for axes in panels.flat[len(MODELS) :]:
        axes.remove()


def _draw_panel(axes: Axes, points: pd.DataFrame) -> None:
    models, lines_of = points["model"].unique(), dict(zip(sorted(points["spin"].unique()), _LINES, strict=False))
    for (model, spin), curve in points.groupby(["model", "spin"], sort=False):
        curve = curve.sort_values("nominal")
        growing = (curve["deflection"] > _MORE * curve["deflection"].shift(1, fill_value=0.0)).cummin()
        curve, style = curve[growing], {"linewidth": 1.5, "marker": "o", "markersize": 2.5}
        axes.loglog(curve["deflection"], curve["error"], lines_of[spin], color=COLOURS[model], **style)
    axes.axhline(NOTICEABLE, color=GREY, linewidth=0.8)
    place: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "ha": "right", "color": GREY, "fontsize": 9}
    axes.annotate("10 %", (0.985, 1.07 * NOTICEABLE), **place)
    axes.set(xlabel="largest deflection / length", ylim=_LIMITS)
    handles = [Line2D([], [], color=COLOURS[model], label=model) for model in models]
    handles += [Line2D([], [], color="black", ls=line, label=f"spin {spin:g}") for spin, line in lines_of.items()]
    axes.legend(handles=handles, fontsize=7.5, loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=2)

"""Where the small-deflection model ends: the floating frame against the exact beam, over flexibility and spin.

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
from scipy.optimize import brentq

from oblique_impact.beam.small_deflection import (
    NOTICEABLE,
    Motion,
    contact_force_error,
    deflection_error,
    largest_motion,
)
from oblique_impact.errors import InputError, Outcome
from oblique_impact.fem_beam.exact.history import simulate as simulate_exactly
from oblique_impact.fem_beam.exact.sections import ElasticSections
from oblique_impact.files import prepare_folder
from oblique_impact.history.history import History
from oblique_impact.problem import beam_of
from oblique_impact.progress import OnProgress, silent
from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import simulate
from oblique_impact.validation.beams import UNIT
from oblique_impact.validation.report import Report, Section, Table, Text, picture
from oblique_impact.validation.studies.parallel import check_limits, map_parallel

#: nominal deflections over the length, and spin rates in units of 1/T
DEFLECTIONS = (0.003, 0.01, 0.03, 0.1, 0.2, 0.4)
SPINS = (0.0, 4.0)
#: E A L^2/E I: an extension that nothing shows
_SLENDER = 1e8
_EXACT_ELEMENTS, _EXACT_STEPS, _SAMPLES = 10, 1000, 200
#: turn (rad) in an elastic period up to which so many steps are enough: sections turn by an angle, places along a
#: chord, which differ like the square of the turn in a step
_SLOW = 4.0
#: errors that are those of the model: smaller ones may be of the exact beam's step, larger ones of another motion
_CLEAR = (0.01, 0.5)
#: inertia of the beam about its root, rho A L^3
_BEAM = 1.0 / 3.0
_STOP = 50.0  # E I/L^3: the beam's end follows its stop for about as long as the beam vibrates
_KINETICS, _FRAME, _MODES = "discretization__kinetics", "discretization__frame", "discretization__modes"
_ORDERS = {"zeroth": "zeroth-order", "first": "first-order", "full": "full"}


def _models(frame: str, modes: int, *orders: str) -> dict[str, dict[str, Any]]:
    """Return models by name, each as changes of a scenario."""
    words = {name: name if name == "full" else f"{name} order" for name in orders}
    return {
        f"{frame.replace('-', ' ')}, {words[name]}": {_KINETICS: _ORDERS[name], _FRAME: frame, _MODES: modes}
        for name in orders
    }


#: problem -> model -> changes
MODELS: dict[str, dict[str, dict[str, Any]]] = {
    "held": _models("tangent", 6, "zeroth", "first", "full"),
    "hub": _models("tangent", 6, "zeroth", "first", "full"),
    "light hub": _models("tangent", 6, "zeroth", "first", "full"),
    "pendulum": _models("mean-axis", 6, "zeroth", "first", "full") | _models("tangent", 4, "first", "full"),
    "stop": _models("tangent", 6, "first", "full"),
}


@dataclass(frozen=True)
class Case:
    """A loaded beam.

    Attributes
    ----------
    root : str
        "pin", "hub" or "driven".
    load : str
        "gravity", "torque" (of a hub) or "stop" (of a driven root).
    nominal : float
        Deflection over the length that sets the load.
    spin : float
        Initial angular velocity, of a driven root for good (1/T).
    hub : float
        Inertia of the hub over that of the beam.
    angle : float
        Of the beam at the start, from the horizontal (rad).
    stiffness : float
        Of the stop (E I/L^3).
    """

    root: str
    load: str
    nominal: float
    spin: float = 0.0
    hub: float = 0.0
    angle: float = 0.0
    stiffness: float = _STOP

    @property
    def period(self) -> float:
        """Period of the first elastic mode of the beam on its root (T)."""

        def hinged_with_hub(b: float) -> float:
            inertia = self.hub * _BEAM * b**3
            free = math.sin(b) * math.cosh(b) - math.cos(b) * math.sinh(b)
            return free + inertia * (1.0 + math.cos(b) * math.cosh(b))

        clamped, hinged = 1.875104068711961, 3.926602312047919
        b = clamped if self.root == "driven" else brentq(hinged_with_hub, clamped, hinged + 1e-9)
        return 2.0 * math.pi / b**2

    @property
    def scenario(self) -> Scenario:
        """The case, to be marched by any model.

        The load follows from small deflections: under a sudden angular acceleration a the tip of a clamped beam
        comes to twice 11 rho A a L^5/(120 E I), under gravity g to twice rho A g L^4/(8 E I); that of a beam that
        falls about a pin to about rho A g L^4/(160 E I) from its mean axis.  Over a stop a root that turns by an
        angle bends the beam by about as much.
        """
        end, inertia = 2.0 * self.period, self.hub * _BEAM
        root: dict[str, Any] = {"kind": self.root}
        contact: dict[str, Any] = {"enabled": False}
        gravity, angle = 0.0, self.angle
        if self.load == "gravity":
            free = 0.0 if self.root == "driven" else 1.0 / (1.0 + self.hub)
            gravity = self.nominal / (0.25 * (1.0 - free) + free / 160.0)
        if self.root == "hub":
            acceleration = self.nominal * 120.0 / 22.0 if self.load == "torque" else 0.0
            root |= {"inertia": inertia, "torque": acceleration * (inertia + _BEAM)}
        if self.root == "driven":
            rate = -self.nominal / end if self.load == "stop" else self.spin
            root |= {"profile": "constant-speed" if rate else "hold", "spin_rate": rate}
        if self.load == "stop":
            contact = {"normal": "spring", "stiffness": self.stiffness, "friction": "frictionless"}
            angle = min(0.001, 0.1 * self.nominal)  # it meets the stop soon
        return Scenario.from_dict(
            {
                "end_time": end,
                "gravity": gravity,
                "beam": UNIT,
                "root": root,
                "initial": {"angle": angle, "angular_velocity": 0.0 if self.root == "driven" else self.spin},
                "slope": {"origin": [0.5, 0.0], "angle": 0.0},
                "contact": contact,
                "solver": {"output_interval": end / _SAMPLES, "tolerance": 1e-8},
            }
        )


def case_of(problem: str, nominal: float, spin: float) -> Case:
    """Return a case of the map."""
    fixed: dict[str, dict[str, Any]] = {
        "held": {"root": "driven", "load": "gravity"},
        "hub": {"root": "hub", "load": "torque", "hub": 30.0},
        "light hub": {"root": "hub", "load": "torque", "hub": 0.05},
        "pendulum": {"root": "pin", "load": "gravity"},
        "stop": {"root": "driven", "load": "stop"},
    }
    return Case(nominal=nominal, spin=spin, **fixed[problem])


@dataclass(frozen=True)
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
    report : Path or None
        The page, if one was written.
    """

    points: pd.DataFrame
    seconds: float
    report: Path | None = None

    def of(self, problem: str, model: str) -> pd.DataFrame:
        """Return the points of one model."""
        return self.points[(self.points["problem"] == problem) & (self.points["model"] == model)]

    def coefficient(self, problem: str, model: str) -> float:
        """Return the median of the error over the square of the deflection over the length, where it is clear."""
        points = self.of(problem, model)
        points = points[points["error"].between(*_CLEAR)]
        return float((points["error"] / points["deflection"] ** 2).median())


def exact(case: Case, frame: str) -> History:
    """March the exact beam of a case: slender, without rotary inertia."""
    base, root = case.scenario, case.scenario.root
    turn = (abs(case.spin) + abs(root.torque) / (root.inertia + _BEAM) * base.end_time) * base.end_time
    step = base.end_time / (_EXACT_STEPS * min(math.ceil(max(1.0, turn / _SLOW)), 4))
    scenario = base.replace(
        discretization__method="absolute",
        discretization__elements=_EXACT_ELEMENTS,
        discretization__frame=frame,
        solver__free_step=step,
        solver__contact_step=step,
    )
    sections = ElasticSections.uniform(_SLENDER, 0.4 * _SLENDER, 1.0, 1.0)
    return simulate_exactly(scenario, sections=sections)


def error_of(case: Case, reference: History, history: History) -> float:
    """Return the error of a model's run: of the tip's deflection, or on a stop of the largest force."""
    if case.load == "stop":
        exactly, force = (max(contact.peak_force for contact in run.contacts) for run in (reference, history))
        return float(abs(force / exactly - 1.0))
    times, tip = reference["time"].values, reference["uy"].values[:, -1]
    found = np.interp(times, history["time"].values, history["uy"].values[:, -1])
    return float(np.abs(found - tip).max() / np.abs(tip).max())


def motion_of(history: History) -> Motion:
    """Return the largest motion that a run's own estimate is made of."""
    beam = beam_of(Scenario.from_toml(history.scenario_toml))
    return largest_motion(beam, {name: history[name].values for name in ("uy", "theta_dot", "q", "qd")})


def estimate_of(history: History) -> float:
    """Return what a run says of its own error: of its deflection, or with a contact of the largest force."""
    scenario, motion = Scenario.from_toml(history.scenario_toml), motion_of(history)
    if scenario.contact.enabled:
        return contact_force_error(scenario, motion.deflection)
    return deflection_error(scenario, motion)


def points_of(case: tuple[str, float, float]) -> list[dict[str, Any]]:
    """March the exact beam and all models of one problem; in whatever process this is."""
    problem, nominal, spin = case
    loaded = case_of(*case)
    references: dict[str, History] = {}
    found = []
    for model, changes in MODELS[problem].items():
        frame = changes[_FRAME]
        if frame not in references:
            references[frame] = exact(loaded, frame)
        reference = references[frame]
        if reference.outcome is not Outcome.COMPLETED:
            raise InputError(f"{problem}, deflection {nominal:g}, spin {spin:g}: {reference.outcome.sentence}")
        history = simulate(loaded.scenario.replace(**changes))
        completed = history.outcome is Outcome.COMPLETED
        found.append(
            {
                "problem": problem,
                "model": model,
                "nominal": nominal,
                "spin": spin,
                "deflection": float(np.abs(reference["uy"].values[:, -1]).max()),
                "error": error_of(loaded, reference, history) if completed else math.nan,
                "estimate": estimate_of(history),
                "outcome": history.outcome.label,
            }
        )
    return found


def small_deflection(
    *,
    deflections: Sequence[float] = DEFLECTIONS,
    spins: Sequence[float] = SPINS,
    out: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    command: str = "",
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
        Folder for report.html, results.json and results.csv; without it nothing is written.
    workers, command, on_progress
        As for :func:`oblique_impact.validation.studies.refinement.refine`.

    Raises
    ------
    InputError
        In one line for numbers that are out of range or a folder that cannot be written.
    """
    check_limits(None, workers, None)
    for name, values, low, high in (("deflections", deflections, 0.0, 1.0), ("spins", spins, -1.0, 20.0)):
        if not values or not all(low < value <= high for value in values):
            shown = ",".join(f"{value:g}" for value in values)
            raise InputError(f"{name} {shown}: should be from {max(low, 0.0):g} to {high:g}")
    # the stop is met at rest: a spin is none of its loads
    cases = [
        (problem, nominal, spin)
        for problem in MODELS
        for nominal in deflections
        for spin in (spins if problem != "stop" else spins[:1])
    ]
    names = [f"{problem}, deflection {nominal:g}, spin {spin:g}" for problem, nominal, spin in cases]
    folder = None if out is None else prepare_folder(out)
    started = time.perf_counter()
    found = map_parallel(points_of, cases, workers, on_progress, names)
    points = pd.DataFrame([point for rows in found for point in rows])
    result = SmallDeflection(points, time.perf_counter() - started)
    if folder is None:
        return result
    data = {"study": "small-deflection", "command": command, "points": points.to_dict("records")}
    return replace(result, report=report(result, command).write(folder, data, points))


def lines(result: SmallDeflection) -> list[str]:
    """Return what the study found in lines, for a terminal."""
    found = []
    for problem, models in MODELS.items():
        found.append(f"{problem}:")
        for model in models:
            points = result.of(problem, model)
            worst = points["error"][points["nominal"] == points["nominal"].min()].max()
            coefficient = result.coefficient(problem, model)
            words = f"error {coefficient:.2g} (w/L)^2, at least {worst:.1e} at the fastest spin"
            found.append(f"  {model:26} {words}")
    return found


# --- report

TITLES = {
    "held": "Held root, bent by the weight",
    "hub": "Heavy hub, bent by a torque",
    "light hub": "Hub of a twentieth of the beam's inertia",
    "pendulum": "Pinned beam that falls and turns",
    "stop": "Held root, pushed on an elastic stop",
}
_NOTE = (
    "A curve that ends early has runs that physics stopped: first-order kinetics in the tangent frame lose their "
    "mass. What rises to the left, up to 2 %, is the step of the exact beam at a fast spin."
)
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


def report(result: SmallDeflection, command: str) -> Report:
    """Return the report; `command` repeats the study."""
    with picture("Relative error over the largest deflection", 9.2, 9.2 * SIZE[1] / SIZE[0]) as drawn:
        draw_map(drawn.figure, result.points)
    columns = {
        "model": "model",
        "spin": "spin",
        "nominal": "nominal deflection",
        "deflection": "largest deflection / L",
        "error": "relative error",
        "estimate": "its estimate",
        "outcome": "outcome",
    }
    return Report(
        "Where the small-deflection model ends",
        "The floating frame bends linearly, and knows the shortening to the second order. Loads grow along the "
        "lower axis; the error is that of the deflection of the tip from the model's axis, its largest difference "
        "from the geometrically exact beam within two elastic periods, over the largest deflection; on a stop it "
        "is that of the largest force. Spin rates are in units of sqrt(EI/(ρA L⁴)); the first clamped mode has "
        "3.52.",
        command,
        result.seconds,
        overview=[drawn, Text(_NOTE, note=True)],
        sections=[
            Section(TITLES[problem], [Table.of_frame(frame, digits=3, columns=columns)])
            for problem, frame in result.points.groupby("problem", sort=False)
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

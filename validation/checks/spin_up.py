"""The spin-up of Simo and Vu-Quoc (J. Appl. Mech. 53, 1986, 855-863) through the equations that are marched."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.interpolate import CubicSpline

from oblique_impact.history.history import History
from oblique_impact.validation.checks.plots import spin_up_figure
from oblique_impact.validation.checks.registry import Evidence, Measurement, checks_of, within
from oblique_impact.validation.reference_values import VALUES, source
from oblique_impact.validation.runs import Array, column, run

check = checks_of("spin-up", "Spin-up: zeroth order fails, first order and full agree")

_MODELS = {"modal": ("modal", 12, 32), "fem": ("fem", 12, 16), "fem-32": ("fem", 12, 32), "nodes": ("fem", 0, 32)}
#: of deflections at given times and of the smallest (m), of the time of that, where the curve is flat (s): the
#: references are of the same 12 modes in another program at 1e-11, so that ten decimals of the table are held and
#: the others are not; elements err with h⁴, the implicit steps of all nodes with the square of their length
_ALLOWED = {
    "modal": (1e-10, 3e-11, 5e-7),
    "fem": (1e-6, 4e-7, 5e-6),
    "fem-32": (2e-7, 3e-8, 1e-6),
    "nodes": (1e-6, 4e-7, 5e-6),
}
_IMPLICIT = ("solver.scheme=generalized-alpha", "solver.rho_infinity=1", "solver.free_step=5e-4")


def _spin_up(method: str, modes: int, elements: int = 32, kinetics: str = "first-order") -> History:
    keys = (f"method={method}", f"modes={modes}", f"elements={elements}", f"kinetics={kinetics}")
    return run("spin-up", *(f"discretization.{key}" for key in keys), *(() if modes else _IMPLICIT))


def _deflection(history: History) -> CubicSpline:
    """Tip deflection between samples 0.01 s apart (a cubic misses it by less than 1e-8 m)."""
    time, first = np.unique(column(history, "time"), return_index=True)
    return CubicSpline(time, column(history, "deflection")[first])


def _extrema(curve: CubicSpline) -> tuple[Array, Array]:
    times = curve.derivative().roots(extrapolate=False)
    return times, curve(times)


@check("A beam of 10 m is spun up to 6 rad/s in 15 s: tip deflection at twenty times.", seconds=1.5)
def table() -> Iterator[Measurement]:
    """The worst of the table for each discretization."""
    times, exact = np.array(list(VALUES["3-SVQ-table"])), np.array(list(VALUES["3-SVQ-table"].values()))
    for name, model in _MODELS.items():
        computed = _deflection(_spin_up(*model))(times)
        k = int(np.argmax(np.abs(computed - exact)))
        quantity = f"tip deflection at {times[k]:g} s, {name}"
        allowed = _ALLOWED[name][0]
        yield Measurement(quantity, computed[k], exact[k], "m", allowed, source("3-SVQ-table"), name)


@check("The same spin-up: largest deflection, its time, and the vibration that is left.", seconds=1.5)
def extremes() -> Iterator[Measurement]:
    """Minimum and amplitude for t > 15 s."""
    for name, model in _MODELS.items():
        times, values = _extrema(_deflection(_spin_up(*model)))
        low, (_, of_value, of_time) = int(np.argmin(values)), _ALLOWED[name]
        value, text = VALUES["3-SVQ-min"]["w_min"], source("3-SVQ-min")
        yield Measurement(f"smallest deflection, {name}", values[low], value, "m", of_value, text, f"{name}-min")
        time = VALUES["3-SVQ-min"]["t"]
        yield Measurement(f"its time, {name}", times[low], time, "s", of_time, text, f"{name}-time")
        amplitude, quantity = float(np.abs(values[times > 15.0]).max()), f"amplitude after 15 s, {name}"
        exact, text = VALUES["3-SVQ-amp"], source("3-SVQ-amp")
        yield within(quantity, amplitude, exact, "m", 1e-4, text, f"{name}-amplitude")


@check("The same spin-up of a geometrically exact beam.", seconds=1.0)
def exact_beam() -> list[Measurement]:
    """First-order equations neglect terms of relative size (w/L)² = 3e-3: here a thousandth."""
    times, values = _extrema(_deflection(_spin_up("modal", 12)))
    low, exact, text = int(np.argmin(values)), VALUES["3-SVQ-GE"], source("3-SVQ-GE")
    return [
        within("smallest deflection", values[low], exact["w_min"], "m", 1.2e-3, text, "deflection"),
        within("its time", times[low], exact["t"], "s", 3e-3, text, "time"),
    ]


@check("The same spin-up with few modes: smallest deflection by number of modes.", seconds=1.5)
def by_modes() -> Iterator[Measurement]:
    """Truncation converges from 1 to 12 modes as tabulated."""
    text = source("3-SVQ-min-modes")
    for modes, exact in VALUES["3-SVQ-min-modes"].items():
        low, name = _extrema(_deflection(_spin_up("modal", modes)))[1].min(), f"{modes}-modes"
        yield Measurement(f"smallest deflection, {modes} modes", low, exact, "m", 0.51e-6, text, name)


@check("Zeroth-order kinetics leave the foreshortening out and fail; first order and full agree.", seconds=1.0)
def zeroth_order_fails() -> Evidence:
    """Growth rate of the zeroth-order deflection at full speed, and the distance of first order from full."""
    zeroth, first, full = (_spin_up("modal", 3, 32, order) for order in ("zeroth-order", "first-order", "full"))
    # at full speed from the start, a small deflection grows while it stays small
    at_speed = ("root.profile=constant-speed", "gravity=1e-6", "end_time=3", "discretization.modes=3")
    growing = run("spin-up", *at_speed, "discretization.kinetics=zeroth-order")
    time, tip = column(growing, "time"), column(growing, "deflection")
    late = time > 2.0
    rate = float(np.polyfit(time[late], np.log(np.abs(tip[late])), 1)[0])
    w1, spin = VALUES["3-SVQ-w1"], 6.0
    times = np.linspace(0.0, 20.0, 401)
    curves = [_deflection(history)(times) for history in (first, full)]
    distance = float(np.abs(curves[0] - curves[1]).max())
    text = (
        "sqrt(Omega² - omega_1²): without C the beam softens and is unstable beyond its first "
        "frequency (Kane, Ryan and Banerjee 1987)"
    )
    quantity, exact = "growth rate of the zeroth-order deflection at full speed", np.sqrt(spin**2 - w1**2)
    found = [within(quantity, rate, exact, "1/s", 5e-5, text, "growth")]
    # cubic terms: the deflection times (w/L)² = 3e-3
    quantity, allowed = "largest distance of first order from full kinetics", 0.575 * 3.3e-3
    text = "neglected terms are of relative size (w/L)²"
    found.append(Measurement(quantity, distance, 0.0, "m", allowed, text, "first-against-full"))
    return Evidence(found, [spin_up_figure(zeroth, first, full, VALUES["3-SVQ-table"])])

"""The charts of the page: their series at chosen samples, axes, and bands in place of fast vibrations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from oblique_impact.contact.state import State
from oblique_impact.history.history import History
from oblique_impact.history.sample_times import first_sample, last_sample
from oblique_impact.problem import contact_law_of
from oblique_impact.renders.envelope import drawn
from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.player.numbers import fixed

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

ENERGIES = ("kinetic", "elastic", "gravity", "stop")
WIDTH, HEIGHT = 640, 120  # pixels of a chart, for which vibrations become bands
LEVELS = (
    1.0,
    0.25,
)  # parts of the run that a chart of that width shows; closer than the last one there are no bands
_PREFIXES = ((1e10, 1e9, "G"), (1e7, 1e6, "M"), (1e4, 1e3, "k"))  # from which value on, size, name


@dataclass(frozen=True)
class Series:
    """A curve of a chart."""

    name: str
    values: Array  # (samples,)
    colour: str = ""  # a colour of the page; none: that of the contact state
    dashed: bool = False


@dataclass(frozen=True)
class Chart:
    """A chart over time."""

    name: str
    title: str
    unit: str
    series: list[Series]

    def facts(self) -> dict[str, Any]:
        """Return what the page needs besides the values: range and ticks of the vertical axis, looks of series."""
        values = np.concatenate([one.values[np.isfinite(one.values)] for one in self.series])
        low, high = min(values.min(initial=0.0), 0.0), max(values.max(initial=0.0), 0.0)
        high = high if high > low else low + 1.0
        low, high = low - 0.05 * (high - low) * (low < 0.0), high + 0.06 * (high - low)
        largest = max(-low, high)
        size, prefix = next(((size, name) for least, size, name in _PREFIXES if largest >= least), (1.0, ""))
        ticks = MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]).tick_values(low / size, high / size)
        ticks = ticks[(ticks >= low / size) & (ticks <= high / size)]
        step = float(np.diff(ticks).min()) if ticks.size > 1 else 1.0
        places = next((d for d in range(12) if abs(step - round(step, d)) < 1e-6 * step), 12)
        return {
            "name": self.name,
            "title": f"{self.title} ({self.unit})",
            "unit": prefix + self.unit,
            "range": [low, high],
            "ticks": [(size * tick, fixed(tick, places)) for tick in ticks.tolist()],
            "series": [{"name": s.name, "colour": s.colour, "dashed": s.dashed} for s in self.series],
        }


def charts_of(geometry: BeamGeometry) -> list[Chart]:
    """Return the charts of a run: contact force, of a run without contact the deflection, and energies."""
    history = geometry.history
    if geometry.scenario.contact.enabled and geometry.peak_force > 0.0:
        forces = [
            Series("normal", _values(history, "lambda_n")),
            Series("tangential", _values(history, "lambda_tau"), dashed=True),
        ]
        first = Chart("force", "Contact force", "N", forces)
    else:
        first = Chart(
            "force", "Deflection", "mm", [Series("of the tip", 1e3 * _values(history, "deflection"), "elastic")]
        )
    parts = {name: _values(history, f"energy_{name}") for name in ENERGIES[:3]}
    parts["stop"] = _stop_energy(geometry)
    energies = [Series(name, values, name) for name, values in parts.items() if values.any()]
    total = Series("total", np.sum(list(parts.values()), axis=0), "total")
    return [first, Chart("energy", "Energy", "J", [*energies, total])]


def _values(history: History, name: str) -> Array:
    return np.asarray(history[name].values, dtype=float)


def _stop_energy(geometry: BeamGeometry) -> Array:
    """Return the energy (J) of an elastic stop, (samples,); 0 of a rigid one."""
    history, times = geometry.history, geometry.times
    energy, stop = np.zeros(times.size), contact_law_of(geometry.scenario)
    if stop is None or not geometry.scenario.contact.enabled:
        return energy
    for contact in history.contacts:
        span = slice(int(last_sample(times, contact.start)), int(first_sample(times, contact.end)) + 1)
        energy[span] = [stop.energy(value, contact.compliance) for value in history["gap"].values[span]]
    return energy


def curve_arrays(series: Series, times: Array, states: NDArray[Any]) -> tuple[dict[str, Array], list[Any]]:
    """Return a series as the page draws it, with bands where it swings faster than pixels show.

    Parameters
    ----------
    series : Series
        With values at the points of the charts, (points,).
    times, states : ndarray (points,)
        Their times (s) and contact states.

    Returns
    -------
    arrays : dict
        Per level with bands, `LEVELS`, times, values and states of the line, and times and both ends of the bands.
    levels : list
        Per level the first points of its bands and the states that they have most; None of a level without bands.
    """
    arrays: dict[str, Array] = {}
    levels: list[Any] = []
    values, span = series.values, float(np.ptp(times)) or 1.0
    extent = float(np.ptp(values)) if np.isfinite(values).all() else 0.0
    for n, part in enumerate(LEVELS):
        scale = WIDTH / (part * span)
        shown = drawn((times - times[0]) * scale, values, extent / HEIGHT) if extent > 0.0 else None
        if shown is None or not shown.bands:
            levels.append(None)
            continue
        at = times[0] + shown.x / scale
        edges = [np.clip(times[0] + band.x / scale, times[0], times[-1]) for band in shown.bands]
        prefix = f"{series.name}_{n}"
        arrays |= {
            f"{prefix}_time": at,
            f"{prefix}_value": shown.y,
            f"{prefix}_state": states[np.maximum(last_sample(times, at), 0)],
            f"{prefix}_edge": np.concatenate(edges),
            f"{prefix}_low": np.concatenate([band.low for band in shown.bands]),
            f"{prefix}_high": np.concatenate([band.high for band in shown.bands]),
        }
        first = np.cumsum([0, *(edge.size for edge in edges)])
        inside = [states[(times >= edge[0]) & (times <= edge[-1])] for edge in edges]
        most = [int(np.bincount(found).argmax()) if found.size else int(State.FREE) for found in inside]
        levels.append({"starts": first.tolist(), "states": most})
    return arrays, levels

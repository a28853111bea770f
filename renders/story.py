"""Shared by all pictures of a run: style, shapes, slope, scale of colours, course of the film."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import get_args

import numpy as np

from oblique_impact.errors import InputError, Outcome
from oblique_impact.history.history import History
from oblique_impact.renders.geometry import QUANTITIES, BeamGeometry
from oblique_impact.renders.style import Colour, Style
from oblique_impact.renders.surroundings import DrawnObstacle, Ground, drawn_obstacles, ground_of, looked_at
from oblique_impact.renders.timeline import TimeMap, time_map
from oblique_impact.renders.title import beam_words, name_of

_ROUND = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
_THIN = 0.008  # over what is seen of the motion: a beam that is thinner is drawn thicker
_PREFIXES = ((1e10, 1e9, "GPa"), (1e5, 1e6, "MPa"), (1e2, 1e3, "kPa"))  # from which limit on, size, name


@dataclass(frozen=True)
class ColourScale:
    """Scale of a quantity in colour, from -limit to limit."""

    quantity: str  # one of `renders.geometry.QUANTITIES`
    limit: float  # in the quantity's SI unit
    exceeded: bool  # whether the run goes beyond it; the labels say so

    @property
    def title(self) -> str:
        """Name and unit, and what the sign means."""
        sign = ", tension positive" if self.quantity.endswith("_stress") else ""
        return f"{self.quantity.replace('_', ' ')} ({self.unit[1]}){sign}"

    @property
    def ticks(self) -> list[tuple[float, str]]:
        """Places on the scale, as parts of the limit, and their labels."""
        value = self.limit / self.unit[0]
        places = next((d for d in range(9) if abs(0.5 * value - round(0.5 * value, d)) < 1e-9 * value), 9)
        ends = {-1.0: "≤ ", 1.0: "≥ "} if self.exceeded else {}
        form = f".{places}f" if 1e-6 < value < 1e6 else "g"
        parts = (-1.0, -0.5, 0.0, 0.5, 1.0)
        return [(p, ends.get(p, "") + (f"{p * value:{form}}" if p else "0").replace("-", "−")) for p in parts]

    @property
    def unit(self) -> tuple[float, str]:
        """Size and name of the unit in which the ends of the scale read well."""
        unit = QUANTITIES[self.quantity]
        fitting = [(size, name) for least, size, name in _PREFIXES if unit == "Pa" and self.limit >= least]
        return fitting[0] if fitting else (1.0, unit)


@dataclass(frozen=True)
class Story:
    """One to three runs as every picture shows them.

    Attributes
    ----------
    geometries : tuple of BeamGeometry
        All with the same deformation factor, the smallest that one of them would have alone.
    style : Style
        What is shown, and how.
    names : tuple of str
        What the runs are called, where there are several.
    time_map : TimeMap
        Film time over physical time, from the contacts of the first run.
    """

    geometries: tuple[BeamGeometry, ...]
    style: Style
    names: tuple[str, ...]
    time_map: TimeMap

    @property
    def histories(self) -> tuple[History, ...]:
        """The runs."""
        return tuple(geometry.history for geometry in self.geometries)

    @property
    def factor(self) -> float:
        """Deformation factor."""
        return self.geometries[0].factor

    @property
    def title(self) -> str:
        """As the style or the scenario says, or the run's name; none of several, which have their names each."""
        if self.style.title is not None:
            return self.style.title
        if len(self.geometries) > 1:
            return ""
        scenario = self.geometries[0].scenario
        return scenario.title or "".join(self.names) or name_of(scenario)

    @property
    def beam(self) -> list[str]:
        """The beam of all runs in ever shorter words; none where they differ."""
        words = [beam_words(geometry.scenario) for geometry in self.geometries]
        return words[0] if all(word == words[0] for word in words) else []

    @property
    def heading(self) -> str:
        """Title and beam in one line."""
        words = next(iter(self.beam[1:2]), "")
        return ": ".join(filter(None, [self.title, words])) if self.title else words[:1].upper() + words[1:]

    @property
    def overlay(self) -> bool:
        """Whether several beams are drawn over each other, in one colour each."""
        return self.style.layout == "overlay" and len(self.geometries) > 1

    @cached_property
    def colours(self) -> ColourScale:
        """One scale for all runs."""
        return colour_scale(self.geometries, self.style.quantity)

    @cached_property
    def scales(self) -> dict[str, ColourScale]:
        """The scales of all results, for a page, on which each can be chosen."""
        return {name: colour_scale(self.geometries, name) for name in get_args(Colour)}

    @cached_property
    def obstacles(self) -> list[DrawnObstacle]:
        """Outlines of slope and obstacles of the first run."""
        return drawn_obstacles(self.geometries[0])

    @cached_property
    def thickness(self) -> float:
        """How many times as thick as they are beams are drawn in stills and films, so that they can be seen."""
        places = np.concatenate([looked_at(geometry) for geometry in self.geometries])
        reach = max(1.2 * g.scenario.reach for g in self.geometries)
        seen = np.clip(np.nan_to_num(places), -reach, reach)
        if not self.geometries[0].scenario.root.is_free:
            seen = np.append(seen, [(0.0, 0.0)], axis=0)
        radius = min(float(geometry.radii.max()) for geometry in self.geometries)
        return max(1.0, math.ceil(0.5 * _THIN * float(np.ptp(seen, axis=0).max()) / radius))

    @cached_property
    def drawn(self) -> tuple[BeamGeometry, ...]:
        """The beams as stills and films show them, with their thickness."""
        if self.thickness == 1.0:
            return self.geometries
        return tuple(BeamGeometry(g.history, g.factor, self.thickness) for g in self.geometries)

    @property
    def magnified(self) -> list[str]:
        """Notes on magnified deflections and thickness, the longest wording first; empty if true to scale."""
        thicker = f"thickness ×{self.thickness:g}" if self.thickness > 1.0 else ""
        if self.factor == 1.0:
            return [thicker] if thicker else []
        brief = f"deflection drawn ×{self.factor:g}"
        choices = (self.geometries[0].deflection_words(self.factor), brief, f"×{self.factor:g}")
        return [f"{choice}, {thicker}" if thicker else choice for choice in choices]

    @cached_property
    def ground(self) -> Ground | None:
        """The ground under all runs, if there is one."""
        return ground_of(self.drawn, drawn_obstacles(self.drawn[0]))


def story_of(
    histories: Sequence[History],
    style: Style | None = None,
    names: Sequence[str] = (),
    speed: float | None = None,
    contact_speed: float | None = None,
    seconds: float | None = None,
) -> Story:
    """Make what the pictures of one to three runs of beams share; speeds and length as `time_map` takes them.

    Raises InputError for a history without a beam, too many of them, or a factor that is not positive and finite.
    """
    if not 1 <= len(histories) <= 3:
        raise InputError(f"HISTORY: {len(histories)} given: should be one, two or three")
    style = style or Style()
    geometries = [BeamGeometry(history, style.deformation) for history in histories]
    common = min(geometry.factor for geometry in geometries)
    same = tuple(g if g.factor == common else BeamGeometry(g.history, common) for g in geometries)
    return Story(same, style, tuple(names), time_map(histories[0], speed, contact_speed, seconds))


def colour_scale(geometries: Sequence[BeamGeometry], quantity: str) -> ColourScale:
    """Return the scale that covers a quantity over all samples and stations, at both outer fibres.

    Of a run that stopped early it covers 99 of 100 samples, as the last ones may be of any size.
    """
    largest = covered = 0.0
    for geometry in geometries:
        with np.errstate(over="ignore", invalid="ignore"):
            sizes = [np.abs(values).max(axis=1) for values in geometry.at_fibres(quantity)]
            peaks = np.maximum(*sizes)
        sound = peaks[peaks < np.finfo(np.float32).max]  # what is larger cannot be drawn
        if sound.size:
            completed = geometry.history.outcome is Outcome.COMPLETED
            covered = max(covered, float(np.quantile(sound, 1.0 if completed else 0.99, method="lower")))
            largest = max(largest, float(sound.max()))
    limit = round_up(covered)
    return ColourScale(quantity, limit, largest > limit)


def round_up(value: float) -> float:
    """Return the next larger round number, for the ends of a scale; 1 for zero."""
    if not value > 0.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return float(next(m for m in _ROUND if m * power >= value * (1.0 - 1e-12)) * power)

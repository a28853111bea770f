"""Colours of pictures and films, light and dark; each colour has one meaning."""

from __future__ import annotations

from dataclasses import dataclass

from oblique_impact.errors import InputError
from oblique_impact.scenario.messages import one_of
from renders.style import FREE_COLOUR, SERIES, SLIP_COLOUR, STICK_COLOUR


@dataclass(frozen=True)
class Theme:
    """Colours as #rrggbb."""

    name: str
    background: str
    ink: str  # text
    dim: str  # secondary text, axes
    line: str  # grid and frames
    ghost: str
    slope: str
    slope_edge: str
    pin: str
    trace: str
    arrow: str
    states: tuple[str, str, str]  # free, slip, stick
    series: tuple[str, ...]  # several histories
    energies: tuple[str, str, str]  # kinetic, elastic, gravity
    colour_map: str  # diverging, for stress


LIGHT = Theme(
    name="light",
    background="#ffffff",
    ink="#1d2733",
    dim="#5d6b7a",
    line="#dfe4e9",
    ghost="#8a94a0",
    slope="#c3c9cf",
    slope_edge="#7d8a97",
    pin="#98a1ab",
    trace="#4a6fdc",
    arrow="#d9580d",
    states=(FREE_COLOUR, SLIP_COLOUR, STICK_COLOUR),
    series=SERIES,
    energies=("#8a4f9e", "#0f7f86", "#8d969f"),
    colour_map="RdBu_r",
)
DARK = Theme(
    name="dark",
    background="#12171d",
    ink="#e8edf2",
    dim="#9aa7b4",
    line="#2b343e",
    ghost="#5d6a77",
    slope="#4a545f",
    slope_edge="#7d8a97",
    pin="#6d7883",
    trace="#7f9cf5",
    arrow="#ff8a3d",
    states=("#7f9cf5", "#ff8a3d", "#5fd38a"),
    series=("#6fb1d6", "#ff9d4d", "#9ccc65", "#c792ea", "#ff6b7a", "#aab4bf"),
    energies=("#c08fd2", "#4fc0c5", "#87929d"),
    colour_map="RdBu_r",
)
THEMES = {theme.name: theme for theme in (LIGHT, DARK)}


def theme_of(name: str) -> Theme:
    """Return a theme by name; raises InputError for an unknown one."""
    if name not in THEMES:
        raise InputError(f"--theme {name}: {one_of(name, THEMES)}")
    return THEMES[name]

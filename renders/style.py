"""Appearance of pictures: themes of colours, matplotlib's settings, and the style of a picture."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args

import matplotlib as mpl
import matplotlib.style

from oblique_impact.contact.state import State
from oblique_impact.errors import InputError
from oblique_impact.scenario.messages import one_of, plain_text
from oblique_impact.scenario.scenario import Scenario

FREE_COLOUR, SLIP_COLOUR, STICK_COLOUR = "#1f4fd1", "#d9580d", "#1b8a3c"
STATE_COLOURS = (FREE_COLOUR, SLIP_COLOUR, STICK_COLOUR)
SERIES = ("#22577a", "#e07a1f", "#5b8e3b", "#8a4f9e", "#b03a48", "#6c757d")
GREY = "#6c757d"
COLOUR_MAP = "RdBu_r"  # diverging, for results in colour
SLIDE = (40.0 / 3.0, 7.5)  # inches: width and height of a slide in presentations
TEXT = 10.0  # points: size of text on a slide

ThemeName = Literal["light", "dark", "print", "auto"]
CameraName = Literal["oblique", "front", "above"]
Layout = Literal["side-by-side", "overlay"]
Colour = Literal["bending_stress", "axial_stress", "moment", "shear", "axial_force", "section_rotation"]


_SHEET = Path(__file__).with_name("figures.mplstyle")


def state_name(state: int, scenario: Scenario | None) -> str:
    """Return a state of contact as pictures name it: without friction what touches neither slips nor sticks."""
    if state == State.SLIP and scenario is not None and not scenario.rubs:
        return "contact"
    return State(state).name.lower()


@dataclass(frozen=True)
class Theme:
    """Colours of pictures and films, as #rrggbb."""

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
    ground: str
    colour_map: str = COLOUR_MAP  # a name that Matplotlib knows
    force_map: str = "YlOrRd"  # the same, of the sizes of forces, from the lightest
    outline: str = ""  # of a beam in flat colours; without one it is shaded


LIGHT = Theme(
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
    states=STATE_COLOURS,
    series=SERIES,
    energies=("#8a4f9e", "#0f7f86", "#8d969f"),
    ground="#eef4ff",
)
DARK = Theme(
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
    ground="#27303a",
)
#: of drawings without paper, on pages that are light or dark: a contrast of 3.3 to 5.6 to white and to #131416
PAGE = replace(
    LIGHT,
    background="none",
    ink="#74808c",
    dim="#7d8996",
    line="#80808033",
    slope="#8a94a03d",
    states=("#4f7be0", "#d9580d", "#2b9a4c"),
    series=("#3b82c4", "#df6a1a", "#4c9a3f", "#a86bc0", "#d9515f", "#7d8996"),
)
#: greys in place of hues; the colour map grows lighter from its lowest value to its highest one
PRINT = replace(
    LIGHT,
    ink="#000000",
    dim="#404040",
    slope="#e6e9f3",
    slope_edge="#404040",
    trace="#404040",
    arrow="#000000",
    states=("#8c8c8c", "#000000", "#595959"),
    series=("#000000", "#808080", "#b8b8b8"),
    energies=("#595959", "#8c8c8c", "#bfbfbf"),
    colour_map="cividis",
    force_map="Greys",
    outline="#000000",
)
THEMES = {"light": LIGHT, "dark": DARK, "print": PRINT}
#: fields of a `Style` for a purpose
PRESETS: dict[str, dict[str, Any]] = {
    "talk": {"size": (1920, 1080), "letters": 12.0},  # a slide in full HD, read from the last row
    # two columns of a journal, 180 mm wide at 300 pixels per inch, in letters of 8 points
    "paper": {"size": (2126, 1196), "dpi": 300.0, "letters": 8.0, "theme": "print"},
}
#: fields of a `Style` that shows nothing but beam, slope and pin
BARE: dict[str, Any] = {
    "title": "",
    **dict.fromkeys(("charts", "inset", "ghosts", "trace", "arrow", "ground", "text"), False),
}


@contextmanager
def figure_style(theme: Theme | None = None) -> Iterator[None]:
    """Apply the style inside a block, with the colours of a theme; leaves matplotlib's settings as they were."""
    colours: dict[str, Any] = {}
    if theme:
        colours |= dict.fromkeys(("figure.facecolor", "axes.facecolor", "savefig.facecolor"), theme.background)
        ink = ("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color")
        colours |= dict.fromkeys(ink, theme.ink) | {"grid.color": theme.line}
    with mpl.style.context([_SHEET, colours]):
        yield


def require_plain(option: str, text: str) -> None:
    """Raise InputError for a text with control characters, which would make an SVG that cannot be read."""
    try:
        plain_text(text)
    except ValueError as error:
        raise InputError(f"{option} {text}: should be {error}") from None


@dataclass(frozen=True)
class Style:
    """Contents and appearance of a picture.

    Attributes
    ----------
    size : tuple of int
        Width and height (pixels), even.
    theme : {"light", "dark", "print", "auto"}
        Colours of paper and ink; "print" has few greys; "auto" is the reader's system's on pages, else light.
    camera : {"oblique", "front", "above"}
        Where the eye is.
    quantity : str
        The result in colour: "bending_stress", "axial_stress", "moment", "shear", "axial_force" or
        "section_rotation".
    deformation : float or None
        Factor; None chooses it.
    charts, inset, ghosts, trace, arrow, ground : bool
        What is shown; the ground with the shadows of the beam, which fall on the slope too.
    layout : {"side-by-side", "overlay"}
        Of several histories.
    title : str or None
        At the top of a still or a film; None: the name of the run, empty: no line there.
    letters : float
        Size of text (points) where the picture is shown at its resolution; titles and labels follow it.
    dpi : float or None
        Resolution (pixels per inch), by which a picture of some size (pixels) has its size on paper; None: that at
        which it covers a slide of 13.33 x 7.5 inches.
    text : bool
        Whether time, state and rate are written above the beam, and scales of colours and of length below it.

    Raises InputError for a name that is unknown or a size out of range.
    """

    size: tuple[int, int] = (1280, 720)
    theme: ThemeName = "auto"
    camera: CameraName = "oblique"
    quantity: Colour = "bending_stress"
    deformation: float | None = None
    charts: bool = True
    inset: bool = True
    ghosts: bool = True
    trace: bool = True
    arrow: bool = True
    ground: bool = True
    layout: Layout = "side-by-side"
    letters: float = TEXT
    dpi: float | None = None
    text: bool = True
    title: str | None = None

    def __post_init__(self) -> None:
        for option, name, names in (
            ("--theme", self.theme, ThemeName),
            ("--camera", self.camera, CameraName),
            ("--colour", self.quantity, Colour),
            ("--layout", self.layout, Layout),
        ):
            if name not in get_args(names):
                raise InputError(f"{option} {name}: {one_of(name, get_args(names))}")
        require_plain("--title", self.title or "")
        if not (320 <= self.size[0] <= 7680 and 120 <= self.size[1] <= 4320):
            raise InputError(f"--size {self.size[0]}x{self.size[1]}: should be from 320x120 to 7680x4320")
        if not 4.0 <= self.letters <= 60.0:
            raise InputError(f"--letters {self.letters:g}: should be from 4 to 60")
        if self.dpi is not None and not 20.0 <= self.dpi <= 2400.0:
            raise InputError(f"--dpi {self.dpi:g}: should be from 20 to 2400")

    @classmethod
    def of(cls, preset: str, **changes: Any) -> Style:
        """Return the style of one of `PRESETS` with some changes; raises InputError for one that there is not."""
        if preset not in PRESETS:
            raise InputError(f"--preset {preset}: {one_of(preset, PRESETS)}")
        return cls(**(PRESETS[preset] | changes))

    @property
    def resolution(self) -> float:
        """Pixels per inch."""
        return self.dpi or min(pixels / inches for pixels, inches in zip(self.size, SLIDE, strict=True))

    @property
    def colours(self) -> Theme:
        """Colours of a picture."""
        return THEMES.get(self.theme, LIGHT)

"""Kinds of pictures, by the suffix of their file, and the options that are for some of them only."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from oblique_impact.errors import InputError

STILL, STRIP, FILM, PAGE, CHARTS = "a still", "a strip", "a film", "a page", "charts"
FILMS = (".mp4", ".gif")
VECTORS = (".svg", ".pdf")
SUFFIXES = (".png", *VECTORS, *FILMS, ".html")
_PICTURES = (STILL, STRIP, FILM)
#: arguments of `renders.render` that are refused with any other kind
_APPLIES: dict[str, tuple[str, ...]] = {
    "times": (STILL, STRIP),
    "event": (STILL,),
    "strip": (STRIP,),
    **dict.fromkeys(("fps", "speed", "contact_speed", "between", "frames", "seconds"), (FILM,)),
    "magnify_difference": _PICTURES,
}


def kind_of(out: Path, strip: bool) -> str:
    """Return what a file will be, by its suffix; raises InputError for an unknown one."""
    suffix = out.suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(f"--out {out}: should end with {', '.join(SUFFIXES)}")
    if suffix == ".png":
        return STRIP if strip else STILL
    return CHARTS if suffix in VECTORS else PAGE if suffix == ".html" else FILM


def check_options(out: Path, kind: str, options: dict[str, Any]) -> None:
    """Raise InputError for the first argument that is given and does not apply to a kind of picture."""
    for name, value in options.items():
        if value not in (None, False, [], ()) and kind not in _APPLIES[name]:
            option = "--time" if name == "times" else "--" + name.replace("_", "-")
            raise InputError(f"{option}: is for {' or '.join(_APPLIES[name])}, and {out} would be {kind}")

"""Which options of `render` apply to which kind of picture; the others are refused."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from oblique_impact.errors import InputError

STILL, STRIP, FILM, PAGE, CHARTS = "a still", "a strip", "a film", "a page", "charts"
FILMS = (".mp4", ".gif", ".webp")
VECTORS = (".svg", ".pdf")
SUFFIXES = (".png", *VECTORS, *FILMS, ".html")

_PICTURES = (STILL, STRIP, FILM)
#: an option that is given with any other kind is refused
APPLIES: dict[str, tuple[str, ...]] = {
    "--time": (STILL, STRIP),
    "--event": (STILL,),
    "--strip": (STRIP,),
    **dict.fromkeys(
        ("--fps", "--speed", "--contact-speed", "--between", "--frames", "--seconds", "--title-card"), (FILM,)
    ),
    **dict.fromkeys(("--size", "--camera", "--layout", "--bare", "--letters", "--dpi"), _PICTURES),
    **dict.fromkeys(("--deformation", "--colour"), (*_PICTURES, PAGE)),
    **dict.fromkeys(("--theme", "--name"), (*_PICTURES, PAGE, CHARTS)),
    "--title": (STILL, FILM, PAGE, CHARTS),
    "--preset": (*_PICTURES, CHARTS),
    "--magnify-difference": _PICTURES,
}


def kind_of(out: Path, strip: bool) -> str:
    """Return what a file will be, by its suffix; raises InputError for an unknown one."""
    suffix = out.suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(f"--out {out}: should end with {', '.join(SUFFIXES)}")
    if suffix == ".png":
        return STRIP if strip else STILL
    return CHARTS if suffix in VECTORS else PAGE if suffix == ".html" else FILM


def check_options(out: Path, kind: str, given: Iterable[str]) -> None:
    """Raise InputError for the first of some options that does not apply to a kind of picture."""
    for option in given:
        if kind not in APPLIES[option]:
            *some, last = APPLIES[option]
            fitting = f"{', '.join(some)} or {last}" if some else last
            raise InputError(f"{option}: is for {fitting}, and {out} {'are' if kind == CHARTS else 'is'} {kind}")

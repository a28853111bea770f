"""Which options of `render` apply to which kind of picture; the others are refused."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from oblique_impact.errors import InputError

STILL, STRIP, FILM, PAGE = "a still", "a strip", "a film", "a page"
FILMS = (".mp4", ".gif", ".webp")
SUFFIXES = (".png", *FILMS, ".html")

_PICTURES, _ALL = (STILL, STRIP, FILM), (STILL, STRIP, FILM, PAGE)
#: an option that is given with any other kind is refused
APPLIES: dict[str, tuple[str, ...]] = {
    "--time": (STILL, STRIP),
    "--event": (STILL,),
    "--strip": (STRIP,),
    **dict.fromkeys(("--fps", "--speed", "--contact-speed", "--between", "--frames"), (FILM,)),
    **dict.fromkeys(("--size", "--camera", "--layout", "--bare"), _PICTURES),
    **dict.fromkeys(("--deformation", "--theme", "--colour", "--name"), _ALL),
    "--magnify-difference": _PICTURES,
}


def kind_of(out: Path, strip: bool) -> str:
    """Return what a file will be, by its suffix; raises InputError for an unknown one."""
    suffix = out.suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(f"--out {out}: should end with {', '.join(SUFFIXES)}")
    if suffix == ".png":
        return STRIP if strip else STILL
    return PAGE if suffix == ".html" else FILM


def check_options(out: Path, kind: str, given: Iterable[str]) -> None:
    """Raise InputError for the first of some options that does not apply to a kind of picture."""
    for option in given:
        if kind not in APPLIES[option]:
            *some, last = APPLIES[option]
            fitting = f"{', '.join(some)} or {last}" if some else last
            raise InputError(f"{option}: is for {fitting}, and {out} is {kind}")

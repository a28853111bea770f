"""Looks and settings of pictures for a purpose, as data; what a call or a command gives itself holds instead."""

from __future__ import annotations

from typing import Any, NamedTuple


class Preset(NamedTuple):
    """What a preset sets: fields of `renders.style.Style`, and arguments of `renders.render` for films."""

    look: dict[str, Any]
    film: dict[str, Any]


PRESETS = {
    # a slide in full HD, read from the last row
    "talk": Preset({"size": (1920, 1080), "letters": 12.0}, {"fps": 30, "title_card": 3.0}),
    # two columns of a journal, 180 mm wide at 300 pixels per inch, in letters of 8 points
    "paper": Preset({"size": (2126, 1196), "dpi": 300.0, "letters": 8.0, "theme": "print"}, {"fps": 30}),
    # a square on a phone: eight seconds with the title card, that begin anew by themselves
    "social": Preset({"size": (1080, 1080), "letters": 20.0}, {"fps": 30, "seconds": 6.5, "title_card": 1.5}),
}

#: fields of a style that shows nothing but beam, slope and pin
BARE: dict[str, Any] = {
    "title": "",
    **dict.fromkeys(
        ("charts", "inset", "ghosts", "trace", "arrow", "ground", "scale_bar", "caption", "text"), False
    ),
}

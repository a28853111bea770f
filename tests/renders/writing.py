"""What pictures write: the texts of Pillow and of matplotlib, with their sizes and places."""

from __future__ import annotations

from typing import Any, NamedTuple

from matplotlib.text import Text
from PIL import ImageDraw


class Written(NamedTuple):
    """A text with its size and its box (pixels), in which picture, and how large that is."""

    text: str
    size: float
    box: tuple[float, float, float, float]
    place: tuple[float, float]  # as Pillow was told
    picture: Any
    room: tuple[int, int]


def written(monkeypatch, draw) -> list[Written]:
    """Everything that a call writes: in frames, and in the charts of matplotlib."""
    found, pillow, matplotlib = [], ImageDraw.ImageDraw.text, Text.draw

    def write(pen, place, text, *args, **options):
        if text:
            box = pen.textbbox(place, text, font=options["font"], anchor=options.get("anchor"))
            found.append(Written(text, options["font"].size, box, place, "frame", pen.im.size))
        return pillow(pen, place, text, *args, **options)

    def draw_text(artist, renderer, *args, **options):
        if artist.get_visible() and artist.get_text():
            box, size = artist.get_window_extent(renderer), artist.get_fontsize() * artist.get_figure().dpi / 72.0
            place = (box.x0, renderer.height - box.y1, box.x1, renderer.height - box.y0)
            room = (renderer.width, renderer.height)
            found.append(Written(artist.get_text(), size, place, place[:2], renderer, room))
        return matplotlib(artist, renderer, *args, **options)

    with monkeypatch.context() as patch:
        patch.setattr(ImageDraw.ImageDraw, "text", write)
        patch.setattr(Text, "draw", draw_text)
        draw()
    return found


def texts(monkeypatch, draw, charts=True) -> list[str]:
    """The texts alone, with or without those of the charts."""
    return [item.text for item in written(monkeypatch, draw) if charts or item.picture == "frame"]

"""The title card of a film: what is seen, with which parameters, and how much is exaggerated."""

from __future__ import annotations

from PIL import Image, ImageDraw

from oblique_impact.renders.frame import rate_words, shortened
from oblique_impact.renders.letters import Letters
from oblique_impact.renders.story import Story
from oblique_impact.renders.timeline import Timeline
from oblique_impact.renders.title import parameters, short

_TITLE, _NAMES, _LINE = 30.0, 16.0, 13.5  # points, where text has 10


def title_card(story: Story, timeline: Timeline) -> Image.Image:
    """Return the picture of a film that comes before its frames."""
    theme, letters, (width, height) = story.style.colours, Letters.of(story.style), story.style.size
    picture = Image.new("RGB", (width, height), theme.background)
    pen, margin = ImageDraw.Draw(picture), 0.09 * width
    room = width - 2.0 * margin
    rows = [(text, _TITLE, True, theme.ink, 1.9) for text in ([story.title] if story.title else [])]
    if len(story.geometries) > 1:
        rows.append((" and ".join(story.names), _NAMES if rows else _TITLE, True, theme.ink, 1.9))
    body, notes = (
        [(text, _LINE, False, colour, 1.65) for line in lines for text in letters.wrapped(line, room, _LINE)]
        for lines, colour in ((lines_of(story), theme.ink), (exaggerations(story, timeline), theme.dim))
    )
    rows += body
    gap = 1.2 * letters.size(_LINE)
    total = sum(step * letters.size(size) for _, size, _, _, step in rows + notes) + gap
    y = 0.5 * (height - total)
    pen.line(
        [(0.6 * margin, y), (0.6 * margin, y + total)], fill=theme.arrow, width=max(2, round(4 * letters.scale))
    )
    for n, (text, size, bold, colour, step) in enumerate(rows + notes):
        y += gap if n == len(rows) else 0.0
        fitting = letters.fitting(shortened(text), room, size, bold)
        pen.text((margin, y), fitting, fill=colour, font=letters.font(size, bold))
        y += step * letters.size(size)
    return picture


def lines_of(story: Story) -> list[str]:
    """Return the parameters that all runs share, and the others with the names of the runs."""
    found = [parameters(geometry.scenario) for geometry in story.geometries]
    shared = [line for line in found[0] if all(line in lines for lines in found)]
    if len(found) == 1:
        return shared
    others = [[line for line in lines if line not in shared] for lines in found]
    return shared + [f"{name}: {line}" for name, lines in zip(story.names, others, strict=True) for line in lines]


def exaggerations(story: Story, timeline: Timeline) -> list[str]:
    """Return in words what is not as it is: deflections and time."""
    factor = f"deflection drawn ×{story.factor:g} about the line from pin to contact point"
    fast, slow = (rate_words(float(rate)) for rate in (timeline.rates.max(), timeline.rates.min()))
    time = f"time runs at {fast}" if fast == slow else f"time runs at {fast} in flight, at {slow} in contact"
    found = [factor if story.factor != 1.0 else "deflection drawn as it is"]
    if story.difference != 1.0:
        first, second = story.names
        found.append(f"difference of {second} from {first} drawn ×{short(story.difference)}")
    return [*found, time]

"""What tests do in the page of a run."""

from __future__ import annotations

from oblique_impact.renders.style import STATE_COLOURS


def seek(page, time):
    """Show a time and wait until it is drawn."""
    page.evaluate("t => player.seek(t)", time)
    settle(page)


def settle(page):
    page.evaluate("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)))")


def rgb(state):
    """Colour of a state as a browser writes it."""
    return f"rgb({', '.join(str(int(STATE_COLOURS[state][k : k + 2], 16)) for k in (1, 3, 5))})"


def now(page):
    return page.evaluate("player.now().time")


def text(page, name):
    return page.locator(f"#{name}").text_content()


def image(page, name):
    return page.evaluate("n => document.getElementById(n).toDataURL()", name)


def drag(page, name, *parts):
    """Press the mouse at a part of the width of an element, drag through the others, and release."""
    box = page.locator(name).bounding_box()
    for n, part in enumerate(parts):
        page.mouse.move(box["x"] + part * box["width"], box["y"] + 0.5 * box["height"])
        if n == 0:
            page.mouse.down()
    page.mouse.up()
    settle(page)

"""What tests do in the page of a run."""

from __future__ import annotations


def show(page, file, fragment=""):
    """Open a page in a browser and wait until it shows the run."""
    page.goto("about:blank")
    page.goto(f"{file.as_uri()}{fragment}")
    page.wait_for_function("() => window.player")
    settle(page)


def seek(page, time):
    """Show the frame nearest to a time and wait until it is drawn."""
    page.evaluate("t => player.seek(t)", time)
    settle(page)


def settle(page):
    page.evaluate("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)))")


def now(page, what="time"):
    return page.evaluate(f"player.now().{what}")


def text(page, name):
    return page.locator(f"#{name}").text_content()


def numbers(page, selector):
    """Numbers in a text of the page, which has proper minus signs."""
    words = page.locator(selector).inner_text().replace("−", "-").split()
    found = []
    for word in words:
        try:
            found.append(float(word))
        except ValueError:
            continue
    return found

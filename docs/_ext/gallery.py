"""The gallery: every example is run as a reader would run it, and shown with its text, picture and output.

An example is a file of examples/ whose name begins with ``plot_``: its docstring has a title, an empty line and a
text in Markdown, and its ``main(folder)`` draws pictures, returns their files and prints what it found.
"""

from __future__ import annotations

import ast
import importlib.util
import io
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from sphinx.util import logging

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
FOLDER = "gallery"
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class Example:
    """One example and what its run left."""

    name: str
    title: str
    text: str
    source: str
    pictures: list[Path]
    printed: str


def example_files() -> list[Path]:
    """Return the examples of the gallery."""
    return sorted(EXAMPLES.glob("plot_*.py"))


def run_example(file: Path, folder: Path) -> Example:
    """Run one example; its pictures go into `folder`."""
    source = file.read_text(encoding="utf-8")
    title, _, text = (ast.get_docstring(ast.parse(source)) or "").partition("\n")
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    printed = io.StringIO()
    with redirect_stdout(printed):
        pictures = [Path(p) for p in module.main(str(folder))]
    return Example(file.stem, title.rstrip("."), text.strip(), source, pictures, printed.getvalue().strip())


def page(example: Example) -> str:
    """Return the page of one example."""
    figures = "\n".join(f"```{{image}} {p.name}\n:alt: {example.title}\n```\n" for p in example.pictures)
    printed = f"It prints\n\n```text\n{example.printed}\n```\n" if example.printed else ""
    command = f"```sh\npython examples/{example.name}.py\n```"
    return (
        f"# {example.title}\n\n{example.text}\n\n{figures}\n{printed}\n## Code\n\n{command}\n\n"
        f"```python\n{example.source.rstrip()}\n```\n"
    )


def index(examples: list[Example]) -> str:
    """Return the page with all examples."""
    cards = "\n".join(
        f":::{{container}} card\n[![{e.title}]({e.pictures[0].name})]({e.name}.md)\n\n"
        f"[{e.title}]({e.name}.md)\n:::\n"
        for e in examples
    )
    names = "\n".join(e.name for e in examples)
    return (
        "# Gallery\n\nEvery picture here is drawn by a short program of `examples/` while this documentation is "
        "built.\n\n::::{container} cards\n"
        f"{cards}::::\n\n```{{toctree}}\n:hidden:\n\n{names}\n```\n"
    )


def write_gallery(app: Sphinx) -> None:
    """Run the examples and write their pages into the sources."""
    folder = Path(app.srcdir) / FOLDER
    folder.mkdir(exist_ok=True)
    examples = []
    for file in example_files():
        _LOG.info("running %s", file.name)
        examples.append(run_example(file, folder))
    pages = {f"{e.name}.md": page(e) for e in examples} | {"index.md": index(examples)}
    for name, text in pages.items():
        target = folder / name
        if not target.exists() or target.read_text(encoding="utf-8") != text:
            target.write_text(text, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Run the examples before the sources are read."""
    app.connect("builder-inited", write_gallery)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

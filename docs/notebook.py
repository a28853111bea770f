"""Write the tutorial's notebook, examples/session.ipynb, from its program: ``python -m docs.notebook``."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from sphinx_gallery.gen_gallery import DEFAULT_GALLERY_CONF
from sphinx_gallery.notebook import jupyter_notebook
from sphinx_gallery.py_source_parser import split_code_and_text_blocks

EXAMPLES = Path(__file__).parents[1] / "examples"
PROGRAM, NOTEBOOK = EXAMPLES / "plot_session.py", EXAMPLES / "session.ipynb"


def notebook() -> dict[str, Any]:
    """Return the notebook of the program: cells of text and code, without outputs."""
    _, blocks = split_code_and_text_blocks(str(PROGRAM))
    options = {**DEFAULT_GALLERY_CONF, "first_notebook_cell": None, "last_notebook_cell": None}
    found: dict[str, Any] = jupyter_notebook(blocks, options, str(EXAMPLES))
    # the machine that writes it is none of the reader's business
    found["metadata"] = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    for number, cell in enumerate(found["cells"]):
        # nbformat 4.5 wants an id for each cell; a page of the site is a file of the sources here
        cell["id"] = f"cell-{number}"
        cell["source"] = [
            re.sub(r":doc:`/([\w/-]+)`", r"[docs/\1.md](../docs/\1.md)", text) for text in cell["source"]
        ]
    return {**found, "nbformat": 4, "nbformat_minor": 5}


if __name__ == "__main__":
    NOTEBOOK.write_text(json.dumps(notebook(), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    print(NOTEBOOK)

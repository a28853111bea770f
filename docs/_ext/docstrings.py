"""Docstrings of this project as reStructuredText: indented formulas are literal, bars are bars."""

from __future__ import annotations

import re
from typing import Any

from sphinx.application import Sphinx


def prepare(app: Sphinx, what: str, name: str, value: object, options: object, lines: list[str]) -> None:
    """Mark indented paragraphs as literal blocks and escape bars elsewhere; before numpydoc reads the sections."""
    found: list[str] = []
    base, literal = 0, False
    for number, line in enumerate(lines):
        indent = len(line) - len(line.lstrip())
        after_blank = number > 0 and not lines[number - 1].strip()
        if line.strip():
            if literal and indent <= base:
                literal = False
            elif not literal and after_blank and indent > base:
                found += ["::", ""]
                literal = True
            base = base if literal else indent
        found.append(line if literal else _escape(line))
    lines[:] = found


def _escape(line: str) -> str:
    """Escape bars outside of ``literals``."""
    parts = re.split(r"(``[^`]*``|`[^`]*`)", line)
    return "".join(part if part.startswith("`") else part.replace("|", r"\|") for part in parts)


def skip_fields(app: Sphinx, what: str, name: str, value: object, skip: bool, options: object) -> bool | None:
    """Leave out the fields of named tuples: their class tells what they are."""
    return True if str(getattr(value, "__doc__", "")).startswith("Alias for field number") else None


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect both to autodoc."""
    app.connect("autodoc-process-docstring", prepare, priority=100)
    app.connect("autodoc-skip-member", skip_fields)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

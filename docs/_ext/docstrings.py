"""Docstrings of this project as reStructuredText: formulas are literal, bars are bars; what the API leaves out."""

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


def skip_members(app: Sphinx, what: str, name: str, value: object, skip: bool, options: object) -> bool | None:
    """Leave out the fields of named tuples, which their class tells of, and constants of modules."""
    field = str(getattr(value, "__doc__", "")).startswith("Alias for field number")
    return True if field or (what == "module" and is_constant(name)) else None


def is_constant(name: str) -> bool:
    """Whether a name is that of a constant of a module, which is no part of the API."""
    return re.fullmatch(r"[A-Z][A-Z0-9_]*", name) is not None


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect both to autodoc."""
    app.connect("autodoc-process-docstring", prepare, priority=100)
    app.connect("autodoc-skip-member", skip_members)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

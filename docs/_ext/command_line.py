"""The reference of the command line, from the typer application itself."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from oblique_impact.command_line.application import application

PROGRAM = "oblique-impact"


def commands() -> dict[str, Any]:
    """Return the commands by name, in the order of ``--help``."""
    return dict(application().commands)


def reference() -> str:
    """Return the reference as reStructuredText."""
    lines: list[str] = []
    for name, command in commands().items():
        lines += [name, "-" * len(name), "", f".. program:: {PROGRAM} {name}", ""]
        lines += [".. code-block:: sh", "", f"   {_usage(name, command)}", "", _plain(command.help or ""), ""]
        for parameter in command.params:
            lines += [] if getattr(parameter, "hidden", False) else _parameter(parameter)
    return "\n".join(lines) + "\n"


def _usage(name: str, command: Any) -> str:
    words = [_shown(p) for p in command.params if not _is_option(p)]
    needed = [f"{p.opts[0]} {_value(p)}" for p in command.params if _is_option(p) and p.required]
    return " ".join([PROGRAM, name, *words, *needed, "[OPTIONS]"])


def _shown(parameter: Any) -> str:
    word = parameter.metavar or parameter.name.upper()
    return word if parameter.required else f"[{word}]"


def _is_option(parameter: Any) -> bool:
    return parameter.opts[0].startswith("-")


def _value(parameter: Any) -> str:
    return parameter.metavar or ("" if _is_flag(parameter) else parameter.bare_type().split()[0].upper())


def _is_flag(parameter: Any) -> bool:
    return bool(getattr(parameter, "is_flag", False))


def _parameter(parameter: Any) -> list[str]:
    words = ", ".join(f"{option} {_value(parameter)}".strip() for option in parameter.opts)
    head = words if _is_option(parameter) else (parameter.metavar or parameter.name.upper())
    return [f".. option:: {head}", "", f"   {' '.join([_plain(parameter.help or ''), *_facts(parameter)])}", ""]


def _facts(parameter: Any) -> list[str]:
    """Return what is known of a parameter besides its help: needed or not, default, bounds."""
    facts = []
    if parameter.required:
        facts.append("Required.")
    elif (
        parameter.default is not None and not getattr(parameter, "is_flag", False) and str(parameter.default) != ""
    ):
        facts.append(f"Default: ``{parameter.default}``.")
    least, most = getattr(parameter, "min", None), getattr(parameter, "max", None)
    if least is not None or most is not None:
        facts.append(f"From {least if least is not None else '…'} to {most if most is not None else '…'}.")
    return facts


def _plain(text: str) -> str:
    return re.sub(r"([*|_`\\])", r"\\\1", " ".join(text.split()))


class CommandLine(SphinxDirective):
    """Puts the reference into a page."""

    def run(self) -> list[nodes.Node]:
        """Return the commands and their options."""
        return self.parse_text_to_nodes(reference(), allow_section_headings=True)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("command-line", CommandLine)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

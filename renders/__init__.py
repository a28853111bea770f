"""Pictures of results, from histories.

`render`            a still, a strip, a film or an interactive page: a `Rendered`; `Style` says how it looks
`export`            a time series for ParaView, PVD, VTKHDF or XDMF: an `Exported`
`campbell_diagram`  frequencies of the spinning beam
`overview_figure`   a run at a glance, one or several histories side by side

What a call needs is imported when its name is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__all__ = ["Exported", "Rendered", "Style", "campbell_diagram", "export", "overview_figure", "render"]

if TYPE_CHECKING:
    from renders.campbell import campbell_diagram
    from renders.command import Rendered, render
    from renders.exports.command import Exported, export
    from renders.overview import overview_figure
    from renders.style import Style

#: public names and their modules, imported on first use
_HOME = {
    "Exported": "exports.command",
    "Rendered": "command",
    "Style": "style",
    "campbell_diagram": "campbell",
    "export": "exports.command",
    "overview_figure": "overview",
    "render": "command",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})

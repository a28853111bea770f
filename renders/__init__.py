"""Pictures of results, from histories.

`render`            a still, a strip, a film or an interactive page: a `Rendered`; `Style` says how it looks
`export`            a time series for ParaView, PVD, VTKHDF or XDMF: an `Exported`
`campbell_diagram`  frequencies of the spinning beam
`overview_figure`   a run at a glance, one or several histories side by side

What a call needs is imported when its name is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from oblique_impact.public import on_first_use

__all__ = ["Exported", "Rendered", "Style", "campbell_diagram", "export", "overview_figure", "render"]

if TYPE_CHECKING:
    from renders.campbell import campbell_diagram
    from renders.command import Rendered, render
    from renders.exports.command import Exported, export
    from renders.overview import overview_figure
    from renders.style import Style

__getattr__, __dir__ = on_first_use(
    __name__,
    {
        "campbell": "campbell_diagram",
        "command": "Rendered render",
        "exports.command": "Exported export",
        "overview": "overview_figure",
        "style": "Style",
    },
)

"""Pictures of results, from histories.

`render`            a still, a strip, a film or an interactive page: a `Rendered`; `Style` says how it looks
`export`            a time series for ParaView, PVD, VTKHDF or XDMF: an `Exported`
`campbell_diagram`  frequencies of the spinning beam
`overview_figure`   a run at a glance, one or several histories side by side

What a call needs is imported when its name is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from oblique_impact.lazy import lazy_names

__all__ = ["Exported", "Rendered", "Style", "campbell_diagram", "export", "overview_figure", "render"]

if TYPE_CHECKING:
    from renders.campbell import campbell_diagram
    from renders.command import Rendered, render
    from renders.export.command import Exported, export
    from renders.frame import Style
    from renders.overview import overview_figure

lazy_names(
    __name__,
    {
        "Exported": "export.command",
        "Rendered": "command",
        "Style": "frame",
        "campbell_diagram": "campbell",
        "export": "export.command",
        "overview_figure": "overview",
        "render": "command",
    },
)

"""Pictures of results, from histories.

`render`            a still, a strip, a film or an interactive page: a `Rendered`; `Style` says how it looks
`show`              an interactive window on a run, in a notebook a view in the page
`beam_mesh`         the beam at a time as a mesh of PyVista
`export`            a time series for ParaView, PVD or XDMF, or a table: an `Exported`
`campbell_diagram`  frequencies of the spinning beam
`overview_figure`   a run at a glance, one or several histories side by side

What a call needs is imported when its name is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from oblique_impact.public import on_first_use

__all__ = [
    "Exported",
    "Rendered",
    "Style",
    "beam_mesh",
    "campbell_diagram",
    "export",
    "overview_figure",
    "render",
    "show",
]

if TYPE_CHECKING:
    from oblique_impact.renders.campbell import campbell_diagram
    from oblique_impact.renders.command import Rendered, render
    from oblique_impact.renders.exports.command import Exported, export
    from oblique_impact.renders.meshes import beam_mesh
    from oblique_impact.renders.overview import overview_figure
    from oblique_impact.renders.style import Style
    from oblique_impact.renders.viewer import show

__getattr__, __dir__ = on_first_use(
    __name__,
    {
        "campbell": "campbell_diagram",
        "command": "Rendered render",
        "exports.command": "Exported export",
        "meshes": "beam_mesh",
        "overview": "overview_figure",
        "style": "Style",
        "viewer": "show",
    },
)

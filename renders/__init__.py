"""Pictures of results, from histories.

`render`            a still, a film or an interactive page: a `Rendered`; `Style` says how it looks
`show`              an interactive window on a run, in a notebook a view in the page
`beam_mesh`         the beam at a time as a mesh of PyVista
`export`            a time series for ParaView, PVD or XDMF, or a table: an `Exported`
`draw_contact_map`  where the beam touches over time, into axes of matplotlib
`envelope`          least and largest value of a result along the beam, over the run
`campbell_diagram`  frequencies of the spinning beam
`draw_mode_shapes`  shapes of vibration about an equilibrium
`overview_figure`   a run at a glance, one or several histories side by side
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from oblique_impact.renders.campbell import campbell_diagram as campbell_diagram
    from oblique_impact.renders.contact_map import draw_contact_map as draw_contact_map
    from oblique_impact.renders.exports import Exported as Exported
    from oblique_impact.renders.exports import beam_mesh as beam_mesh
    from oblique_impact.renders.exports import export as export
    from oblique_impact.renders.mode_shapes import draw_mode_shapes as draw_mode_shapes
    from oblique_impact.renders.overview import overview_figure as overview_figure
    from oblique_impact.renders.panels import envelope as envelope
    from oblique_impact.renders.rendering import Rendered as Rendered
    from oblique_impact.renders.rendering import render as render
    from oblique_impact.renders.style import Style as Style
    from oblique_impact.renders.viewer import show as show

# PyVista takes a second to load: a command that draws nothing does not wait for it
_MODULES = {
    "Exported": "exports",
    "Rendered": "rendering",
    "Style": "style",
    "beam_mesh": "exports",
    "campbell_diagram": "campbell",
    "draw_contact_map": "contact_map",
    "draw_mode_shapes": "mode_shapes",
    "envelope": "panels",
    "export": "exports",
    "overview_figure": "overview",
    "render": "rendering",
    "show": "viewer",
}
__all__ = [*_MODULES]


def __getattr__(name: str) -> Any:
    """Import what is asked for when it is first used (PEP 562)."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return __all__

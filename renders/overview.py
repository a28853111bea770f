"""A run at a glance, or up to three of one case: the panels of `panels.py` on one sheet."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oblique_impact.history.history import History
from oblique_impact.renders import panels
from oblique_impact.renders.picture_files import Drawing, save_figure
from oblique_impact.renders.story import Story, story_of
from oblique_impact.renders.style import Style, figure_style
from oblique_impact.renders.timeline import contact_spans

#: texts of vector graphics as text, not as outlines
_AS_TEXT: dict[Any, Any] = {"svg.fonttype": "none", "pdf.fonttype": 42}


def overview_figure(histories: Mapping[str, History], out: Path, style: Style | None = None) -> Path:
    """Draw the overview of one to three histories of the same case, named by their keys; returns the file.

    It is overview.png in a folder `out`.  Theme and title are those of the style.  Raises InputError for more
    histories, one that is not of a beam, or a file that cannot be written.
    """
    return save_overview(story_of(list(histories.values()), style, list(histories)), out)


def save_overview(story: Story, out: Path) -> Path:
    """Save the overview of a story; returns the file.  In SVG and PDF what is written stays text."""
    with figure_style(story.style.colours), mpl.rc_context(_AS_TEXT):
        return save_figure(overview(story), out, "overview.png", story.histories)


def overview(story: Story) -> Figure:
    """Draw the panels of the runs of a story.

    They are the beam on its way, its shapes, contact force and gap (without contact deflection and rate of
    rotation), energy, what took it, and the least and largest moment, shear, stress and deflection along the beam.
    Of two runs that share their events, how far apart these are takes the place of what took energy.  Where
    several places of the beam can touch, one more panel, below, shows those of the first run over time.
    """
    runs = panels.runs_of(story)
    first, theme = runs.histories[0], runs.theme
    touching = any(history.contacts for history in runs.histories)
    mapped = bool(story.geometries[0].zoned and first.contacts)
    kinds = [[(event.kind, event.state) for event in history.events] for history in runs.histories]
    whole = panels.clock(0.0, max(float(history["time"][-1]) for history in runs.histories))
    collision = panels.first_collision(runs)
    near = panels.clock(*collision) if collision else whole
    spans = contact_spans(first)
    with figure_style(theme):
        heights = [1.25, 1.0, 1.0, 0.75, 0.75, *([1.0] if mapped else [])]
        figure = Drawing(figsize=(9.2, 2.75 * sum(heights)), layout="constrained")
        if story.heading:
            figure.suptitle(story.heading, x=0.01, ha="left", fontsize=12, fontweight="bold")
        grid = figure.add_gridspec(len(heights), 2, height_ratios=heights)
        axes = [figure.add_subplot(grid[row, column]) for row in range(5) for column in range(2)]

        def over_time(place: Axes, panel: panels.Curves, clock: panels.Clock, title: str = "") -> None:
            panels.draw_curves(place, panel, clock, spans, theme.line)
            place.set_title(title or panel.title.capitalize())
            if len(panel.curves) > 1:
                place.legend(fontsize=7.5)

        panels.draw_motion(axes[0], story)
        panels.draw_shapes(axes[1], story)
        pushing = panels.forces(runs)
        over_time(axes[2], pushing, near, f"First collision: {pushing.title}" if collision else "")
        if touching:
            over_time(axes[3], panels.gap(runs), whole, "Gap (contact shaded)")
        else:
            over_time(axes[3], panels.variable(runs, "theta_dot", "rate of rotation"), whole)
        over_time(axes[4], panels.energy(runs), whole)
        if len(kinds) == 2 and kinds[0] and kinds[0] == kinds[1]:
            panels.draw_differences(axes[5], runs)
        else:
            panels.draw_losses(axes[5], runs)
        for place, what in zip(axes[6:], panels.ENVELOPES, strict=True):
            panels.draw_envelope(place, runs, what)
        if mapped:
            axes.append(figure.add_subplot(grid[5, :]))
            panels.draw_places(axes[-1], runs, near)
            axes[-1].set_title("First collision: where the beam touches (hatched: it sticks)")
        for letter, place in zip("abcdefghijk", axes, strict=False):
            place.set_title(f"({letter}) {place.get_title(loc='left')}")
        return figure

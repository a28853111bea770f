"""Points of pictures and pages are those of the history, whatever its root, tip and contact point."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.player.content import content_of
from oblique_impact.renders.story import story_of

FEM = ("discretization.method=fem", "discretization.elements=8")
CASES = {
    "driven, hub, tip mass": (
        *(
            "paper",
            "root.kind=driven",
            "root.profile=constant-speed",
            "root.spin_rate=-2.0",
            "root.hub_radius=0.1",
        ),
        *("beam.tip_mass=0.1", "end_time=0.35", *FEM),
    ),
    "hub, contact inside, on the face": (
        *("paper", "root.kind=hub", "root.inertia=0.05", "root.hub_radius=0.2", "contact.point=0.75"),
        *("contact.surface=section", "end_time=0.5", *FEM),
    ),
    "massless point on a spring": (
        *("paper", "contact.normal=spring", "contact.point_inertia=none", "discretization.frame=mean-axis"),
        "end_time=0.33",
    ),
    "spin-up": ("spin-up", "end_time=0.05"),
}


@pytest.fixture(params=CASES, ids=list(CASES))
def history(run, request):
    return run(*CASES[request.param])


def test_points_are_those_of_the_history(history):
    geometry = BeamGeometry(history, 1.0)
    content = content_of(story_of([history]))
    frames = content.arrays["time"]
    for time in frames[:: max(1, frames.size // 12)]:
        axis, k = history.beam_at(time, "right"), int(np.flatnonzero(history["time"].values == time)[0])
        if k + 1 < geometry.times.size and geometry.times[k + 1] == np.nextafter(time, np.inf):
            axis = history.beam_at(time, "left")
        tip = np.array([history["tip_x"].values[k], history["tip_y"].values[k]])
        np.testing.assert_allclose(geometry.centreline(k)[:, :2], axis, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(geometry.contact_point(k), tip, rtol=0.0, atol=1e-12)
        for n in np.flatnonzero(frames == time):
            np.testing.assert_allclose(content.arrays["axis"][n], axis, rtol=0.0, atol=1e-12)
            place = content.arrays["contact"][n] + content.arrays["offset"][n]
            np.testing.assert_allclose(place, geometry.contact_place(k)[:2], rtol=0.0, atol=1e-12)


def test_the_face_touches_the_drawn_slope_in_contact(history):
    """The lowest point of the drawn beam is on the drawn surface, with contact on the axis or on the face."""
    story = story_of([history])
    if story.slope is None:
        assert not story.geometries[0].scenario.contact.enabled
        return
    geometry = story.geometries[0].true
    _, normal = geometry.slope_axes
    surface = story.slope.outline[0] @ normal
    closed = np.flatnonzero(history["state"].values != 0)
    assert closed.size > 0
    for k in closed[:: max(1, closed.size // 10)]:
        place = geometry.contact_place(k)[:2]
        assert place @ normal == pytest.approx(surface + float(history["gap"].values[k]), abs=1e-9)
        if (
            geometry.scenario.contact.point == geometry.scenario.beam.length
        ):  # the round end is drawn by flat faces
            lowest = (geometry.outline(k) @ normal).min()
            assert lowest == pytest.approx(place @ normal, abs=0.1 * geometry.touch_radius)

"""What the arrays of the page of a run hold, as NumPy sees it."""

from __future__ import annotations

import numpy as np


def frame_axes(arrays, facts):
    """Inertial positions x and y (frames, stations) of the axis, from the displacements in the floating frame."""
    x, y = facts["hub_radius"] + arrays["place"] + arrays["frame_ux"], arrays["frame_uy"]
    c, s = np.cos(arrays["frame_theta"])[:, None], np.sin(arrays["frame_theta"])[:, None]
    return x * c - y * s, x * s + y * c


def frame_stress(arrays):
    """Bending stress (frames, stations) of the lower fibre (Pa)."""
    return arrays["frame_moment"].astype(float) * arrays["radius"] / arrays["second_moment"]

"""Meshes of the beam."""

from __future__ import annotations

import numpy as np
from skfem import MeshLine


def beam_mesh(length: float, elements: int, contact_point: float) -> MeshLine:
    """Mesh of `elements` elements on [0, length] (m) with a node at the contact point.

    Uniform if the contact point is a node of the uniform mesh; else uniform on either side of it, with the
    elements shared out in proportion.  Needs two elements for a contact point inside the span.
    """
    inner = contact_point / length * elements
    left = int(np.clip(round(inner), 1, elements)) if contact_point < length else elements
    if contact_point < length:
        left = min(left, elements - 1)
    before = contact_point * np.arange(left) / left
    after = contact_point + (length - contact_point) * np.arange(elements - left + 1) / max(elements - left, 1)
    nodes = np.append(before, after)
    nodes[-1] = length
    return MeshLine(nodes)

"""Normal modes of a beam's linear part: small motions about any angle, without spin, gravity and contact."""

from __future__ import annotations

import numpy as np
from scipy.linalg import block_diag, eigh

from oblique_impact.beam.floating_frame import (
    COUPLING,
    DAMPING,
    DRIVEN,
    ELASTIC_MASS,
    STIFFNESS,
    BeamModel,
)
from oblique_impact.kernels.system import NormalModes

_UNCOUPLED = 1e-9  # of the damping of two modes, by what it couples them


def normal_modes(model: BeamModel) -> NormalModes | None:
    """Return the modes of M q'' + D q' + K q = 0 with the mass matrix at rest, of a driven root those of the rest.

    None if damping couples them.
    """
    elastic, driven = model.matrices[ELASTIC_MASS], model.root == DRIVEN
    coupling = np.zeros_like(model.vectors[COUPLING]) if driven else model.vectors[COUPLING]
    inertia = 1.0 if driven else model.inertia
    mass = np.block([[np.array([[inertia]]), coupling[None]], [coupling[:, None], elastic]])
    stiffness, damping = (block_diag(0.0, model.matrices[which]) for which in (STIFFNESS, DAMPING))
    squares, shapes = eigh(stiffness, mass)
    damped = shapes.T @ damping @ shapes
    own = np.diag(damped).copy()
    if np.any(np.abs(damped - np.diag(own)) > _UNCOUPLED * np.max(np.abs(own))):
        return None
    return NormalModes(shapes, shapes.T @ mass, np.maximum(squares, 0.0), own)

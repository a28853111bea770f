"""Normal modes of a beam's linear part: small motions about any angle, without spin, gravity and contact."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh

from oblique_impact.beam.floating_frame import (
    COUPLING,
    DAMPING,
    DRIVEN,
    ELASTIC_MASS,
    STIFFNESS,
    BeamModel,
)
from oblique_impact.kernels.system import NormalModes

_UNCOUPLED = 1e-9  # coupling of two modes by damping, over the largest damping, that is rounding


def normal_modes(model: BeamModel) -> NormalModes | None:
    """Return the modes of M q'' + D q' + K q = 0 with the mass matrix at rest, of a driven root those of the rest.

    None if damping couples them.
    """
    size, driven = 1 + model.vectors.shape[1], model.numbers.root == DRIVEN
    mass, stiffness, damping = np.zeros((3, size, size))
    mass[0, 0] = 1.0 if driven else model.numbers.inertia
    mass[0, 1:] = mass[1:, 0] = 0.0 if driven else model.vectors[COUPLING]
    for matrix, which in ((mass, ELASTIC_MASS), (stiffness, STIFFNESS), (damping, DAMPING)):
        matrix[1:, 1:] = model.matrices[which]
    if model.ground.stiffness.size:
        stiffness += model.ground.stiffness
        damping += model.ground.damping
    squares, shapes = eigh(stiffness, mass)
    if not stiffness[0].any():  # a swing is the first mode; what rounding bends in it would be a force of its own
        squares[0], shapes[:, 0] = 0.0, np.eye(size)[0] / np.sqrt(mass[0, 0])
    damped = shapes.T @ damping @ shapes
    own = np.diag(damped).copy()
    if np.any(np.abs(damped - np.diag(own)) > _UNCOUPLED * np.max(np.abs(own))):
        return None
    return NormalModes(shapes, np.linalg.inv(shapes), np.maximum(squares, 0.0), own)

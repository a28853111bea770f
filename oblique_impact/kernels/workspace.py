"""Arrays and numbers that systems fill and that contact states and schemes read."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import InputError
from oblique_impact.kernels.jit import inlined, vectorized

Array = NDArray[np.float64]


def own_numbers(values: Any, shape: tuple[int, ...], name: str) -> Array:
    """Return a contiguous copy of an array from user code: kernels read arrays of float64 without strides only.

    Raises InputError, naming the array, for another shape and for anything but real numbers.
    """
    found = np.asarray(values)
    if found.shape != shape or found.dtype.kind not in "biuf":
        wanted = f"should be real numbers of shape {shape}"
        raise InputError(f"{name}: {wanted}, is {found.dtype} of shape {found.shape}")
    return np.array(found, dtype=np.float64, order="C")


def record_of(kind: np.dtype[Any], values: Mapping[str, float]) -> Any:
    """Return a record of named numbers, as kernels read it."""
    found = np.zeros(1, kind).view(np.recarray)
    for name, value in values.items():
        found[name] = value
    return found[0]


#: effective matrices of an implicit scheme: of its two regular steps and of a cut one
EFFECTIVE_SLOTS = 3

# rows of `Workspace.vectors`, each (d,)
FORCES = 0  # Q
FREE_ACCELERATION = 1  # M^-1 Q
ACCELERATION = 2  # q''
SUPPLY = 3  # derivative of the supplied power over q''
RESIDUAL = 4  # Q + D^T lambda - M q'' of an implicit step
INCREMENT = 5  # of q'' in an implicit step
PRODUCT_A = 6  # products with the mass matrix
PRODUCT_B = 7
SCRATCH_A = 8  # for what the system's methods need in between
SCRATCH_B = 9
SCRATCH_C = 10
RANK_ONE = 11  # three rows: S^-1 of a system's rank-one vector, for each effective matrix
# of the beam in its floating frame, behind the entry of theta: its matrices times B
SPIN_PRODUCT = 14
GRAVITY_PRODUCT = 15
STIFFNESS_PRODUCT = 16
SHORTENING_PRODUCT = 17  # H B of a place of contact
DAMPING_PRODUCT = 18  # times B'
# rows of the place of a point of a body, along and across it, and of the derivatives along its axis
ALONG, ACROSS, ALONG_TURNED, ACROSS_TURNED = 19, 20, 21, 22
VECTORS = 23

# matrices of a dense system: mass, its factor and, from there on, the factors of effective matrices
MASS, FACTOR, EFFECTIVE = 0, 1, 2


class Workspace(NamedTuple):
    """Arrays of one system with d degrees of freedom, allocated once per run."""

    matrices: (
        Array  # (5, d, d); of banded systems (4, n + 3, 4): columns to solve in, factors of effective matrices
    )
    vectors: Array  # (23, d)

    @property
    def mass(self) -> Array:
        """Mass matrix (d, d) of a dense system, in plain Python."""
        return np.asarray(self.matrices[MASS])

    @property
    def forces(self) -> Array:
        """Generalized forces Q (d,), in plain Python."""
        return np.asarray(self.vectors[FORCES])


def new_workspace(size: int) -> Workspace:
    """Allocate the arrays of a dense system with `size` degrees of freedom."""
    return Workspace(np.zeros((EFFECTIVE + EFFECTIVE_SLOTS, size, size)), np.zeros((VECTORS, size)))


class Evaluation(NamedTuple):
    """Numbers of an evaluated system, besides its arrays."""

    damping_power: float  # W
    supplied_power: float  # W, at q'' = 0; the rest is supply . q''
    rank_one: float  # coefficient of a rank-one part of the mass matrix that is not in `Workspace.matrices`


@inlined
def dot(a: Array, b: Array) -> float:
    """Scalar product of two vectors (d,)."""
    total = 0.0
    for i in range(a.shape[0]):
        total += a[i] * b[i]
    return total


@inlined
def add(source: Array, target: Array) -> None:
    """Add one vector to another."""
    for i in range(source.shape[0]):
        target[i] += source[i]


def _assign(source: Array, target: Array) -> None:
    target[:] = source


@vectorized(_assign)
def copy(source: Array, target: Array) -> None:
    """Copy one vector (an assignment of slices compiles to far more code)."""
    for i in range(source.shape[0]):
        target[i] = source[i]

"""Arrays and numbers that systems fill and that contact states and schemes read."""

from __future__ import annotations

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


POLYNOMIAL = 12  # coefficients of the polynomials that shape functions are along the beam, at most
#: effective matrices of an implicit scheme: of its two regular steps and of a cut one
EFFECTIVE_SLOTS = 3


class Vectors(NamedTuple):
    """Vectors of a workspace, each (d,) unless it says otherwise."""

    forces: Array  # Q
    normal_row: Array  # D_n
    tangential_row: Array  # D_tau
    free_acceleration: Array  # M^-1 Q
    normal_response: Array  # M^-1 D_n^T, or S^-1 D_n^T in an implicit step
    tangential_response: Array
    acceleration: Array  # q''
    supply: Array  # derivative of the supplied power over q''
    residual: Array  # Q + D^T lambda - M q'' of an implicit step
    increment: Array  # of q'' in an implicit step
    product_a: Array  # products with the mass matrix
    product_b: Array
    scratch_a: Array  # for what the system's methods need in between
    scratch_b: Array
    scratch_c: Array
    rank_one: Array  # (3, d) S^-1 of a system's rank-one vector, for each effective matrix
    # of the beam in its floating frame, behind the entry of theta: its matrices times B
    spin_product: Array
    gravity_product: Array
    stiffness_product: Array
    shortening_product: Array
    damping_product: Array  # times B'
    polynomial: Array  # (12,) of the deflection around a place of the axis

    @classmethod
    def new(cls, size: int) -> Vectors:
        """Allocate the vectors of a system with `size` degrees of freedom."""
        shapes = {"rank_one": (EFFECTIVE_SLOTS, size), "polynomial": POLYNOMIAL}
        return cls(**{name: np.zeros(shapes.get(name, size)) for name in cls._fields})


class Workspace(NamedTuple):
    """Arrays of one system with d degrees of freedom, allocated once per run."""

    mass: Array  # (d, d)
    factor: Array  # (d, d) of the mass matrix; banded systems solve in (n + 3, 4)
    effective: Array  # (3, d, d) factors of an implicit scheme's effective matrices; banded (3, n + 3, 4)
    vectors: Vectors


def new_workspace(size: int) -> Workspace:
    """Allocate the arrays of a dense system with `size` degrees of freedom."""
    square = (size, size)
    return Workspace(np.zeros(square), np.zeros(square), np.zeros((EFFECTIVE_SLOTS, *square)), Vectors.new(size))


class Evaluation(NamedTuple):
    """Numbers of an evaluated system, besides its arrays (SI units)."""

    gap: float
    slip: float
    gap_rate: float
    slip_rate: float
    gap_bias: float  # z_n
    slip_bias: float  # z_tau
    damping_power: float  # W
    supplied_power: float  # W, at q'' = 0; the rest is supply . q''
    rank_one: float  # coefficient of a rank-one part of the mass matrix that is not in `Workspace.mass`


@inlined
def dot(a: Array, b: Array) -> float:
    """Scalar product of two vectors (d,)."""
    total = 0.0
    for i in range(a.shape[0]):
        total += a[i] * b[i]
    return total


def _assign(source: Array, target: Array) -> None:
    target[:] = source


@vectorized(_assign)
def copy(source: Array, target: Array) -> None:
    """Copy one vector (an assignment of slices compiles to far more code)."""
    for i in range(source.shape[0]):
        target[i] = source[i]

"""User-defined functions of numbers that kernels call by a pointer, without being compiled anew for each."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numba
from numba import types
from numba.core.errors import NumbaError

from oblique_impact.errors import InputError
from oblique_impact.kernels.jit import reason_of

#: a user-defined function of one or two numbers in kernels: one of numba's first-class functions
Law = Callable[..., float]


@lru_cache(maxsize=256)
def compiled_law(
    function: Callable[..., Any], arguments: int, parameters: tuple[float, ...], entry: int | None = None
) -> Law:
    """Return a function of one or two numbers that kernels can call, with the parameters of a user-defined one.

    It is compiled by itself, in a fraction of a second: kernels know its signature only.

    Parameters
    ----------
    function : callable
        ``function(*arguments, *parameters)`` in the part of Python that numba compiles.
    arguments : int
        1 or 2.
    parameters : tuple of float
        Values of the others.
    entry : int, optional
        Which entry of the returned tuple is wanted, if it returns one.

    Raises
    ------
    InputError
        With one line if numba cannot compile it.
    """
    inner = numba.njit(error_model="numpy")(function)

    def of_one(a: float) -> Any:
        return inner(a, *parameters)

    def of_two(a: float, b: float) -> Any:
        return inner(a, b, *parameters)

    def entry_of_one(a: float) -> Any:
        return inner(a, *parameters)[entry]

    law = entry_of_one if entry is not None else of_one if arguments == 1 else of_two
    if numba.config.DISABLE_JIT:
        return law
    signature = types.float64(*[types.float64] * arguments)
    try:
        compiled: Law = numba.cfunc(signature, error_model="numpy")(law)
    except NumbaError as error:
        raise InputError(f"{function.__qualname__}: cannot be compiled: {reason_of(error)}") from None
    return compiled

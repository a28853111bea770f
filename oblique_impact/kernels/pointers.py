"""Functions of one's own inside compiled kernels: called by their address, so that no kernel is compiled anew.

A law or a motion is a plain Python function of numbers.  numba compiles it by itself, in a fraction of a
second and once for all its parameters; the kernels, which take twenty, know one address: there lie that of the
machine code and the parameters.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core.errors import NumbaError
from numba.extending import intrinsic, overload
from numba.np.unsafe.ndarray import to_fixed_tuple

from oblique_impact.errors import InputError

_ADDRESS = types.int64
_NUMBER = types.float64
_WORD = 8  # bytes
_DATA = types.CPointer(_NUMBER)  # type: ignore[no-untyped-call]


class Pointer:
    """A compiled function of numbers with its parameters, which live as long as this object.

    Parameters
    ----------
    function : callable
        ``function(*arguments, *parameters)`` in the part of Python that numba compiles.
    arguments : int
        How many arguments the kernel gives, 1 or 2.
    parameters : sequence of float
        Given behind them.
    entry : int, optional
        Which entry of the returned tuple is wanted, if it is one.

    Raises
    ------
    InputError
        With one line if numba cannot compile it.
    """

    def __init__(
        self,
        function: Callable[..., Any],
        arguments: int,
        parameters: Sequence[float] = (),
        entry: int | None = None,
    ) -> None:
        try:
            self._compiled = _compile(function, arguments, len(parameters), entry)
        except NumbaError as error:
            raise InputError(f"{function.__qualname__}: cannot be compiled: {_reason(error)}") from None
        # the machine code's address and the parameters in one block, so that kernels are handed one number
        self._block = np.array([0.0, *parameters, 0.0])  # never without: numba makes no tuple of nothing
        self._block[:1].view(np.int64)[0] = self._compiled.address
        self.address = int(self._block.ctypes.data)


@cache
def _compile(function: Callable[..., Any], arguments: int, count: int, entry: int | None) -> Any:
    inner = numba.njit(error_model="numpy")(function)
    whole = entry is None
    place = entry or 0
    length = count + 1

    @numba.njit(error_model="numpy")
    def chosen(found):  # type: ignore[no-untyped-def]
        return found if whole else found[place]

    @numba.njit
    def unpack(data):  # type: ignore[no-untyped-def]
        every = numba.carray(data, (length,))  # type: ignore[attr-defined]
        return to_fixed_tuple(every, length)[:-1]  # type: ignore[call-arg]

    if arguments == 1:

        def call(a, data):  # type: ignore[no-untyped-def]
            numbers = unpack(data)
            return chosen(inner(a, *numbers))

        return numba.cfunc(_NUMBER(_NUMBER, _DATA), error_model="numpy")(call)

    def call_with_two(a, b, data):  # type: ignore[no-untyped-def]
        numbers = unpack(data)
        return chosen(inner(a, b, *numbers))

    return numba.cfunc(_NUMBER(_NUMBER, _NUMBER, _DATA), error_model="numpy")(call_with_two)


def _reason(error: NumbaError) -> str:
    """Return what the compiler objects to, without its colours and the names of its passes."""
    text = re.sub(r"\x1b\[[0-9;]*m|Failed in nopython mode pipeline \(step: [^)]*\)", "", str(error))
    return " ".join(text.strip().partition("\n\n")[0].split())[:200]


def call_1(address: int, a: float) -> float:
    """Call the function of one number at the address of a :class:`Pointer`."""
    return _call(address, a)


def call_2(address: int, a: float, b: float) -> float:
    """Call the function of two numbers at the address of a :class:`Pointer`."""
    return _call(address, a, b)


def _call(address: int, *numbers: float) -> float:
    code = ctypes.c_int64.from_address(address).value
    kind = ctypes.CFUNCTYPE(ctypes.c_double, *[ctypes.c_double] * len(numbers), ctypes.c_void_p)
    return float(kind(code)(*numbers, address + _WORD))


def _machine_code(arguments: int) -> tuple[Any, Any]:
    """Signature of such a call inside a kernel and what generates it."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        double = ir.DoubleType()
        kind = ir.FunctionType(double, [*[double] * arguments, double.as_pointer()])
        address, *numbers = values
        function = builder.load(builder.inttoptr(address, kind.as_pointer().as_pointer()))
        data = builder.add(address, address.type(_WORD))
        return builder.call(function, [*numbers, builder.inttoptr(data, double.as_pointer())])

    return _NUMBER(_ADDRESS, *[_NUMBER] * arguments), generate


@intrinsic
def _call_1(typing_context: Any, address: Any, a: Any) -> Any:
    return _machine_code(1)


@intrinsic
def _call_2(typing_context: Any, address: Any, a: Any, b: Any) -> Any:
    return _machine_code(2)


@overload(call_1, strict=False)
def _compiled_call_1(address: Any, a: Any) -> Any:
    return lambda address, a: _call_1(address, a)  # type: ignore[call-arg]


@overload(call_2, strict=False)
def _compiled_call_2(address: Any, a: Any, b: Any) -> Any:
    return lambda address, a, b: _call_2(address, a, b)  # type: ignore[call-arg]

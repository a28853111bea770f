"""User-defined functions of numbers that kernels call by an address, without being compiled anew for them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numba
from numba import types
from numba.core import cgutils
from numba.core.errors import NumbaError
from numba.experimental.function_type import FunctionModel
from numba.extending import NativeValue, overload, register_jitable, register_model, typeof_impl, unbox
from numba.np.unsafe.ndarray import to_fixed_tuple

from oblique_impact.errors import InputError
from oblique_impact.kernels.jit import cached_on_disk, drop_cache, reason_of, say_not_cached, seal_cache

#: a user-defined function in kernels takes one or two numbers and an array of parameters
Law = Callable[..., float]

_NUMBER = types.float64
_PARAMETERS = types.Array(types.float64, 1, "C")


def compiled_law(function: Callable[..., Any], arguments: int, parameters: int, entry: int | None = None) -> Law:
    """Return a function of numbers that kernels can call: ``law(*arguments, array of parameters)``.

    It is compiled by itself, in a fraction of a second and once for all values of its parameters: kernels know its
    signature only.

    Parameters
    ----------
    function : callable
        ``function(*arguments, *parameters)`` in the part of Python that numba compiles.
    arguments : int
        1 or 2.
    parameters : int
        How many parameters (float) it takes.
    entry : int, optional
        Which entry of the returned tuple is wanted, if it returns one.

    Raises
    ------
    InputError
        With one line if numba cannot compile it.
    """
    try:
        return _compiled_law(function, arguments, parameters, entry)
    except NumbaError as error:
        raise InputError(f"{function.__qualname__}: cannot be compiled: {reason_of(error)}") from None


@cache
def _compiled_law(function: Callable[..., Any], arguments: int, count: int, entry: int | None) -> Law:
    register_jitable(error_model="numpy")(function)

    def of_one(a: float, numbers: Any) -> Any:
        return function(a, *_entries(numbers, count))

    def of_two(a: float, b: float, numbers: Any) -> Any:
        return function(a, b, *_entries(numbers, count))

    def entry_of_one(a: float, numbers: Any) -> Any:
        return function(a, *_entries(numbers, count))[entry]

    law = entry_of_one if entry is not None else of_one if arguments == 1 else of_two
    if numba.config.DISABLE_JIT:
        return law
    signature = _NUMBER(*[_NUMBER] * arguments, _PARAMETERS)
    # the name of the folder follows the text of the built-in laws, not that of others
    built_in = (function.__module__ or "").partition(".")[0] == __name__.partition(".")[0]
    with cached_on_disk() as cached:
        if cached and built_in:
            try:
                compiled = numba.cfunc(signature, cache=True, error_model="numpy")(law)
                if not compiled.cache_hits:
                    seal_cache()
                return _CompiledLaw(compiled, signature)
            except OSError as error:
                say_not_cached(error)
            except Exception as error:  # whatever reading a damaged file raises
                drop_cache(error)
        return _CompiledLaw(numba.cfunc(signature, error_model="numpy")(law), signature)


class _CompiledLaw:
    """A law with its machine code, which lives as long as this does."""

    def __init__(self, compiled: Any, signature: Any) -> None:
        self._compiled, self.signature = compiled, signature
        self.address: int = compiled.address

    def __call__(self, *arguments: Any) -> float:
        """Run it in Python."""
        return float(self._compiled(*arguments))


class _LawType(types.FunctionType):
    """The compiler's type of a law: a first-class function of numba, but for how it comes out of an argument.

    numba asks Python for the address, in two calls that take longer than what most kernels do between two events.
    """


register_model(_LawType)(FunctionModel)


@typeof_impl.register(_CompiledLaw)
def _type_of_law(law: _CompiledLaw, context: Any) -> _LawType:
    return _LawType(law.signature)


@unbox(_LawType)
def _take_out_law(kind: _LawType, law: Any, c: Any) -> NativeValue:
    found = cgutils.create_struct_proxy(kind)(c.context, c.builder)
    address = c.pyapi.object_getattr_string(law, "address")
    with c.builder.if_then(cgutils.is_null(c.builder, address), likely=False):  # it is no law
        c.builder.ret(c.pyapi.get_null_object())
    found.c_addr = c.pyapi.long_as_voidptr(address)
    c.pyapi.decref(address)
    found.py_addr = c.builder.bitcast(law, c.context.get_value_type(types.voidptr))
    found.jit_addr = c.context.get_constant_null(types.voidptr)
    return NativeValue(found._getvalue())


def _entries(numbers: Any, count: int) -> tuple[float, ...]:
    """Return the first `count` entries of an array, which has more, as a tuple."""
    return tuple(numbers[:count])


@overload(_entries, prefer_literal=True)
def _compiled_entries(numbers, count):  # type: ignore[no-untyped-def]  # compared with those of what it returns
    if not isinstance(count, types.IntegerLiteral):
        return None
    length = count.literal_value + 1  # numba makes no tuple of nothing
    return lambda numbers, count: to_fixed_tuple(numbers, length)[:-1]

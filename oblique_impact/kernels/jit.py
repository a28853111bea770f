"""Compiling with numba: numeric source is written once and runs compiled or interpreted.

`jitable`            marks a function that kernels call
`vectorized`         gives a loop another form for interpreted source
`by_reference`       hands a named tuple on by its address
`kernel`             makes an entry point: compiled for packed systems, interpreted for user-defined ones in Python
`compiled_protocol`  lets kernels call the methods of packed systems (named tuples)

numba caches compiled kernels on disk: in ``__pycache__``, or in the folder ``NUMBA_CACHE_DIR``.  The cache is
optional: where it is full, damaged or cannot be written, kernels are compiled again.  With ``NUMBA_DISABLE_JIT=1``
the same source runs interpreted.

One module, `inner`, rests on names of numba that are not public, because no public way does the same: without it
the first run takes three times as long.  Where a release of numba lacks these names the plain way takes over by
itself, with the same results.
"""

from __future__ import annotations

import hashlib
import inspect
import logging
import re
from collections.abc import Callable, Sequence
from functools import cache, cached_property, update_wrapper
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba import types
from numba.core import event
from numba.core.errors import NumbaError
from numba.extending import overload, overload_method, register_jitable

from oblique_impact.kernels.compiling import announce
from oblique_impact.kernels.reference import Reference, by_reference

__all__ = ["by_reference", "compiled_protocol", "inlined", "jitable", "kernel", "vectorized"]

F = TypeVar("F", bound=Callable[..., Any])
C = TypeVar("C", bound=type)

# Divisions by zero give infinities, as in NumPy, and the step control sees them.
_OPTIONS: dict[str, Any] = {
    "error_model": "numpy",
    "fastmath": {"reassoc", "contract"},
    "no_cfunc_wrapper": True,  # nothing in C calls kernels
}
#: of what only kernels call, which needs no entry from Python either
_INNER_OPTIONS: dict[str, Any] = {**_OPTIONS, "no_cpython_wrapper": True}

try:
    from oblique_impact.kernels.inner import OPTIONS, KernelCompiler

    numba.njit(**_OPTIONS | OPTIONS)(lambda: None)
except Exception as missing:  # whatever a later numba makes of names that it does not know
    logging.getLogger(__name__).info("oblique-impact: numba is used in its plain way: %s", missing)
else:
    _INNER_OPTIONS |= OPTIONS
    _OPTIONS |= {"pipeline_class": KernelCompiler}

_PACKAGE = Path(__file__).parents[1]
_NUMERIC_SOURCE = (
    "kernels",
    "contact",
    "marching",
    "beam/axis.py",
    "beam/base_motion.py",
    "beam/floating_frame.py",
    "beam/hermite.py",
    "beam/nodal_frame.py",
    "beam/point_forces.py",
    "beam/shaking.py",
    "beam/time_course.py",
    "fem_beam/exact",
)


def jitable(function: F) -> F:
    """Mark `function` as numeric source: interpreted from Python, compiled from a kernel."""
    decorated: F = register_jitable(forceinline=False, **_INNER_OPTIONS)(function)
    return decorated


def inlined(function: F) -> F:
    """Mark a `jitable` function that only names things, or is called in one place: calls of it cost nothing."""
    decorated: F = register_jitable(forceinline=True, **_INNER_OPTIONS)(function)
    return decorated


def vectorized(plain: F) -> Callable[[F], F]:
    """Run the function `plain` in interpreted source in place of a loop, which is slow there."""

    def mark(loop: F) -> F:
        overload(plain, jit_options={"forceinline": True, **_INNER_OPTIONS}, strict=False)(lambda *_: loop)
        return plain

    return mark


def compiled_protocol(cls: C) -> C:
    """Make the methods that the class `cls` declares callable from kernels on packed systems (named tuples).

    What is compiled is the function of that name in the system's own class; its arguments have the same order.
    """
    for name, method in vars(cls).items():
        if inspect.isfunction(method) and not name.startswith("_"):
            _compile_method(name, inspect.signature(method))
    return cls


def _compile_method(name: str, signature: inspect.Signature) -> None:
    def implementation(*arguments: Any) -> Any:
        return getattr(arguments[0].instance_class, name, None)

    implementation.__signature__ = signature  # type: ignore[attr-defined]
    for kind in (types.BaseNamedTuple, Reference):
        overload_method(kind, name, jit_options=_INNER_OPTIONS, strict=False)(implementation)


class _Compilations(event.Listener):
    """Announces kernels when numba compiles them, but not what they call and what others compile."""

    def __init__(self) -> None:
        self.names: dict[Any, Kernel] = {}

    def on_start(self, event: Any) -> None:
        found = self.names.get(event.data["dispatcher"])
        if found is not None:
            announce(_described(found.name, event.data["args"]))

    def on_end(self, event: Any) -> None:
        pass


_compilations = _Compilations()
event.register("numba:compile", _compilations)


class Kernel:
    """An entry point of the compiled source; its first argument is the mechanical system, or has one.

    Packed systems (named tuples) run compiled, cached on disk; a system in plain Python runs interpreted.

    Parameters
    ----------
    function : callable
        The numeric source.
    name : str
        What a person is told while it is compiled, see :mod:`oblique_impact.kernels.compiling`.
    """

    def __init__(self, function: Callable[..., Any], name: str) -> None:
        update_wrapper(self, function)
        self._function, self.name = function, name

    def __call__(self, system: Any, *arguments: Any) -> Any:
        """Run it."""
        if not is_compiled(system):
            return self._function(system, *arguments)
        try:
            return self._compiled(system, *arguments)
        except NumbaError:
            raise
        except Exception as error:
            # kernels raise nothing: it is the cache, which could not be read, or not be written afterwards
            return self._run_without_cache(error, system, *arguments)

    def _run_without_cache(self, error: Exception, *arguments: Any) -> Any:
        if isinstance(error, OSError) and self._compiled.signatures:
            _notice(f"compiled kernels cannot be kept ({error.strerror or error}): every run compiles them again")
        else:
            folder = self._compiled.stats.cache_path
            _notice(f"the cache of compiled kernels is damaged ({type(error).__name__}): {folder} is filled anew")
            _forget_cached(Path(folder))
            self._compiled = self._new_dispatcher()
        try:
            return self._compiled(*arguments)
        except OSError:
            self._compiled = numba.njit(**_OPTIONS)(self._function)
            return self._compiled(*arguments)

    @cached_property
    def _compiled(self) -> Any:
        return self._new_dispatcher()

    def _new_dispatcher(self) -> Any:
        try:
            compiled = numba.njit(cache=True, **_OPTIONS)(self._function)
            _forget_stale(Path(compiled.stats.cache_path))
        except (RuntimeError, OSError) as error:  # there is no folder that can be written
            _notice(f"compiled kernels cannot be kept ({error}): every run compiles them again")
            compiled = numba.njit(**_OPTIONS)(self._function)
        _compilations.names[compiled] = self
        return compiled


def is_compiled(system: Any) -> bool:
    """Whether kernels run compiled for a system: a packed one, unless numba is switched off."""
    return isinstance(system, tuple) and not numba.config.DISABLE_JIT


def _described(name: str, arguments: Sequence[Any]) -> str:
    """Return the name of a kernel with what the classes of its arguments, or their systems, say that they are."""
    tuples = [kind for kind in arguments if isinstance(kind, types.BaseNamedTuple)]
    systems = [dict(zip(kind.fields, kind.types, strict=True)).get("system", kind) for kind in tuples]
    found = ", ".join(
        filter(None, (getattr(getattr(kind, "instance_class", None), "described", "") for kind in systems))
    )
    return f"{name} for {found}" if found else name


def kernel(name: str) -> Callable[[Callable[..., Any]], Kernel]:
    """Make a function a `Kernel` of this name."""
    return lambda function: Kernel(function, name)


def reason_of(error: NumbaError) -> str:
    """Return what the compiler objects to, without its colours and the names of its passes."""
    text = re.sub(r"\x1b\[[0-9;]*m|Failed in nopython mode pipeline \(step: [^)]*\)", "", str(error))
    return " ".join(text.strip().partition("\n\n")[0].split())[:200]


@cache
def _source_digest() -> str:
    digest = hashlib.sha256()
    for name in _NUMERIC_SOURCE:
        source = _PACKAGE / name
        if not source.exists():  # of a checkout, where packages that are built on this one lie beside it
            source = _PACKAGE.parent / name
        for file in sorted(source.rglob("*.py")) if source.is_dir() else [source]:
            digest.update(f"{name}/{file.name}".encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()


@cache
def _forget_stale(folder: Path) -> None:
    """Forget kernels of another source: numba watches the file of the entry point only, not what that calls."""
    folder.mkdir(parents=True, exist_ok=True)
    stamp = folder / "numeric-source.sha256"
    if not stamp.exists() or stamp.read_text(encoding="ascii", errors="replace") != _source_digest():
        _forget_cached(folder)
        stamp.write_text(_source_digest(), encoding="ascii")


def _forget_cached(folder: Path) -> None:
    """Remove numba's indices of a folder; raises OSError where that is not allowed."""
    for index in folder.glob("*.nbi"):
        index.unlink(missing_ok=True)


@cache
def _notice(line: str) -> None:
    # without a handler, logging writes it to standard error
    logging.getLogger(__name__).warning("oblique-impact: %s; NUMBA_CACHE_DIR names another folder", line)

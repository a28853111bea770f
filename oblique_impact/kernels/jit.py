"""What is compiled, and how: numeric source is written once and runs compiled or interpreted.

`jitable`            marks a function that kernels call
`Kernel`             an entry point: compiled for packed systems, plain Python for a small user-defined system
`compiled_protocol`  lets kernels call the methods of packed systems (named tuples)

Compiled kernels are cached on disk in a folder named after a digest of the numeric source, so an edited source
never meets a stale binary (numba itself only watches the file of the entry point).  The cache is optional: where
it is full, damaged or cannot be written, kernels are compiled again.  With ``NUMBA_DISABLE_JIT=1`` the same source
runs interpreted.
"""

from __future__ import annotations

import hashlib
import inspect
import logging
import os
import platform
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache, cached_property, update_wrapper
from pathlib import Path
from typing import Any, TypeVar

import numba
import platformdirs
from numba import types
from numba.core import event
from numba.core.errors import NumbaError
from numba.extending import overload_method, register_jitable

from oblique_impact.kernels.compiling import announce, preparing
from oblique_impact.kernels.inner import InnerCompiler
from oblique_impact.kernels.reference import Reference

F = TypeVar("F", bound=Callable[..., Any])
C = TypeVar("C", bound=type)

# The source allocates nothing, so it runs without numba's reference counts: three times faster on small
# systems. Divisions by zero give infinities, as in NumPy, and the step control sees them.
_OPTIONS: dict[str, Any] = {"error_model": "numpy", "_nrt": False, "fastmath": {"reassoc", "contract"}}

# of what only kernels call
_INNER_OPTIONS = {**_OPTIONS, "pipeline_class": InnerCompiler}

_PACKAGE = Path(__file__).parents[1]
_NUMERIC_SOURCE = (
    "kernels",
    "contact",
    "marching",
    "beam/base_motion.py",
    "beam/floating_frame.py",
    "beam/nodal_frame.py",
)


class _Compilations(event.Listener):
    """Announces kernels when numba compiles them; what they call and what others compile is not told."""

    def __init__(self) -> None:
        self.names: dict[Any, str] = {}

    def on_start(self, event: Any) -> None:
        name = self.names.get(event.data["dispatcher"])
        if name is not None:
            announce(name)

    def on_end(self, event: Any) -> None:
        pass


_compilations = _Compilations()
event.register("numba:compile", _compilations)


def jitable(function: F) -> F:
    """Mark `function` as numeric source: interpreted from Python, compiled from a kernel."""
    decorated: F = register_jitable(**_INNER_OPTIONS)(function)
    return decorated


def inlined(function: F) -> F:
    """Mark a `jitable` function that does little but name things: calls of it cost nothing."""
    decorated: F = register_jitable(forceinline=True, **_INNER_OPTIONS)(function)
    return decorated


def compiled_protocol(cls: C) -> C:
    """Let kernels call the methods that the class `cls` declares on packed systems (named tuples).

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


class Kernel:
    """An entry point of the compiled source; its first argument is the mechanical system.

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
        self._function, self._name = function, name
        self._entries: dict[tuple[type, ...], Callable[..., Any]] = {}

    def __call__(self, system: Any, *arguments: Any) -> Any:
        """Run it."""
        if not isinstance(system, tuple) or numba.config.DISABLE_JIT:
            return self._function(system, *arguments)
        classes = (type(system), *map(type, arguments))
        entry = self._entries.get(classes) or self._prepare(classes, system, *arguments)
        return entry(system, *arguments)

    def _prepare(self, classes: tuple[type, ...], *arguments: Any) -> Callable[..., Any]:
        """Compile or load the machine code for arguments of these classes.

        It is kept, because numba takes 0.2 ms to find the types of the arguments.  They are the same at each call;
        what unpacks them still refuses objects of other types.
        """
        _compilations.names[self._compiled] = _described(self._name, classes)
        with preparing():
            kinds = tuple(map(numba.typeof, arguments))
            self._compile(kinds)
        self._entries[classes] = self._compiled.overloads[kinds].entry_point
        return self._entries[classes]

    def _compile(self, kinds: tuple[Any, ...]) -> None:
        """Load or compile it for arguments of these types, whatever becomes of the cache on disk."""
        compiled = self._compiled
        try:
            compiled.compile(kinds)
            if kinds in compiled.stats.cache_misses:
                seal_cache()
        except Exception as error:
            # numba loads an overload, or compiles, keeps and saves it, in this order
            if kinds in compiled.overloads:
                say_not_cached(error)
            elif kinds in compiled.stats.cache_misses:  # it was the compiler
                raise
            else:
                drop_cache(error)
                del self._compiled
                self._compile(kinds)

    @cached_property
    def _compiled(self) -> Any:
        with cached_on_disk() as cached:
            return numba.njit(cache=cached, **_OPTIONS)(self._function)


def _described(name: str, classes: Sequence[type]) -> str:
    """Return the name of a kernel with what the classes of its arguments say that they are."""
    kinds = [kind for argument in classes if (kind := getattr(argument, "described", ""))]
    return f"{name} for {', '.join(kinds)}" if kinds else name


def kernel(name: str) -> Callable[[Callable[..., Any]], Kernel]:
    """Make a function a :class:`Kernel` of this name."""
    return lambda function: Kernel(function, name)


def reason_of(error: NumbaError) -> str:
    """Return what the compiler objects to, without its colours and the names of its passes."""
    text = re.sub(r"\x1b\[[0-9;]*m|Failed in nopython mode pipeline \(step: [^)]*\)", "", str(error))
    return " ".join(text.strip().partition("\n\n")[0].split())[:200]


@contextmanager
def cached_on_disk() -> Iterator[bool]:
    """Let numba cache what it compiles in the block in our folder; yields whether there is one."""
    folder = cache_folder()
    config: Any = numba.config
    previous = config.CACHE_DIR
    config.CACHE_DIR = str(folder or "")
    try:
        yield folder is not None
    finally:
        config.CACHE_DIR = previous


#: folders of caches that can neither be read nor removed
_given_up: set[Path] = set()


@cache
def cache_folder() -> Path | None:
    """Folder of the compiled kernels for this source, numba and Python; None if it cannot be used."""
    digest = hashlib.sha256()
    for name in _NUMERIC_SOURCE:
        source = _PACKAGE / name
        for file in sorted(source.rglob("*.py")) if source.is_dir() else [source]:
            digest.update(file.relative_to(_PACKAGE).as_posix().encode())
            digest.update(file.read_bytes())
    digest.update(f"{numba.__version__} {platform.python_version()}".encode())
    base = Path(os.environ.get("NUMBA_CACHE_DIR") or platformdirs.user_cache_dir("oblique-impact"))
    folder = base / digest.hexdigest()[:16]
    if folder in _given_up:
        return None
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
        _remove_damaged(folder)
    except OSError as error:
        say_not_cached(error)
        return None
    return folder


def _checksums(folder: Path) -> Iterator[tuple[Path, Path, str]]:
    """Yield each file that numba keeps in a cache, where its checksum lies, and what that should be."""
    for file in folder.rglob("*.nb[ic]"):
        with suppress(FileNotFoundError):  # another process has removed it
            checksum = hashlib.blake2b(file.read_bytes()).hexdigest()
            yield file, file.with_name(f"{file.name}.sum"), checksum


def _remove_damaged(folder: Path) -> None:
    """Remove what has not the checksum that it was kept with.

    numba has none: machine code with changed bytes is run, and ends the process if it does not give wrong numbers.
    """
    for file, kept, checksum in _checksums(folder):
        if not kept.exists() or kept.read_bytes() != checksum.encode():
            file.unlink(missing_ok=True)


def seal_cache() -> None:
    """Keep checksums of all that is cached; raises OSError, on a full disk for instance."""
    folder = cache_folder()
    for _, kept, checksum in _checksums(folder) if folder else ():
        kept.write_text(checksum, encoding="ascii")


def drop_cache(error: Exception) -> None:
    """Remove the cache, which cannot be read because of `error`: it is filled anew, or not used if it stays."""
    folder = cache_folder()
    cache_folder.cache_clear()
    if folder is not None:
        shutil.rmtree(folder, ignore_errors=True)
        if folder.exists():
            _given_up.add(folder)
        _notice(f"the kernel cache is damaged ({type(error).__name__}): {folder} is made anew")


def say_not_cached(error: Exception) -> None:
    """Say, once, that compiled kernels cannot be kept because of `error`."""
    why = getattr(error, "strerror", None) or error
    where = "set NUMBA_CACHE_DIR to a folder that can be written"
    _notice(f"compiled kernels cannot be kept ({why}): every run compiles them again; {where}")


@cache
def _notice(line: str) -> None:
    # without a handler, logging writes it to standard error
    logging.getLogger(__name__).warning("oblique-impact: %s", line)

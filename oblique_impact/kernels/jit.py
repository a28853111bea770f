"""One way to compile: numeric source is written once and runs interpreted or compiled.

Functions marked :func:`jitable` are ordinary Python functions.  Called from a kernel made by
:func:`kernel` they are compiled with it; called from Python they are interpreted.  That is how a
user's own small system runs through exactly the source that marches the beam.

Compiled kernels are cached on disk in a folder named after a fingerprint of the numeric source, so
an edited source can never meet a stale binary (numba itself only watches the file of the entry point).
"""

from __future__ import annotations

import hashlib
import os
import platform
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import platformdirs
from numba.core import event
from numba.extending import register_jitable

from oblique_impact.kernels.compiling import announce

F = TypeVar("F", bound=Callable[..., Any])

# The source allocates nothing, so it runs without numba's reference counts: three times faster on small
# systems. Divisions by zero give infinities, as in NumPy, and the step control sees them.
_OPTIONS: dict[str, Any] = {"error_model": "numpy", "_nrt": False, "fastmath": {"reassoc", "contract"}}

_PACKAGE = Path(__file__).parents[1]
_NUMERIC_SOURCE = ("kernels", "contact", "marching", "beam/floating_frame.py", "beam/nodal_frame.py")


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
event.register("numba:compile", _compilations)  # type: ignore[no-untyped-call]


def jitable(function: F) -> F:
    """Mark `function` as numeric source: interpreted from Python, compiled from a kernel."""
    decorated: F = register_jitable(**_OPTIONS)(function)
    return decorated


@cache
def cache_folder() -> Path | None:
    """Folder of the compiled kernels for this source, numba and Python; None if nothing is writable."""
    digest = hashlib.sha256()
    for name in _NUMERIC_SOURCE:
        source = _PACKAGE / name
        for file in sorted(source.rglob("*.py")) if source.is_dir() else [source]:
            digest.update(file.relative_to(_PACKAGE).as_posix().encode())
            digest.update(file.read_bytes())
    digest.update(f"{numba.__version__} {platform.python_version()}".encode())
    base = Path(os.environ.get("NUMBA_CACHE_DIR") or platformdirs.user_cache_dir("oblique-impact"))
    folder = base / digest.hexdigest()[:16]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError:
        return None
    return folder


def kernel(function: F, name: str) -> F:
    """Compile `function` on its first call and cache the machine code on disk.

    `name` is what a person is told meanwhile, see :mod:`oblique_impact.kernels.compiling`.
    """
    folder = cache_folder()
    config: Any = numba.config
    previous = config.CACHE_DIR
    config.CACHE_DIR = str(folder or "")
    try:
        compiled = numba.njit(cache=folder is not None, **_OPTIONS)(function)
    finally:
        config.CACHE_DIR = previous
    _compilations.names[compiled] = name
    return cast(F, compiled)

"""Rendering without a display: say what is missing before VTK is asked, which would crash."""

from __future__ import annotations

import ctypes
import os
import sys
from functools import cache

from oblique_impact.errors import InputError

_WINDOW = "VTK_DEFAULT_OPENGL_WINDOW"
_MISSING = (
    "rendering needs libEGL or libOSMesa: install the Debian package libegl1 with libgl1-mesa-dri, or libosmesa6"
)


@cache
def prepare() -> None:
    """Choose VTK's window class; call it before anything is rendered.

    Without a display VTK draws through EGL or OSMesa.  With neither it ends the process by a segmentation
    fault, so both are tried here first.

    Raises
    ------
    InputError
        Naming the Debian package, if nothing can be drawn.
    """
    if not sys.platform.startswith("linux") or os.environ.get("DISPLAY") or os.environ.get(_WINDOW):
        return
    if _egl_works():
        os.environ[_WINDOW] = "vtkEGLRenderWindow"  # without it VTK asks for an X server first, and complains
    elif _loads("libOSMesa.so.8") or _loads("libOSMesa.so.6") or _loads("libOSMesa.so"):
        os.environ[_WINDOW] = "vtkOSOpenGLRenderWindow"
    else:
        raise InputError(_MISSING)


def _loads(name: str) -> ctypes.CDLL | None:
    try:
        return ctypes.CDLL(name)
    except OSError:
        return None


def _egl_works() -> bool:
    """Whether there is an EGL library with a driver behind it."""
    library = _loads("libEGL.so.1")
    if library is None:
        return False
    library.eglGetProcAddress.restype = ctypes.c_void_p
    library.eglGetProcAddress.argtypes = [ctypes.c_char_p]
    address = library.eglGetProcAddress(b"eglQueryDevicesEXT")
    if not address:
        return False
    query = ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_int, ctypes.c_void_p, ctypes.POINTER(ctypes.c_int))(address)
    count = ctypes.c_int(0)
    return bool(query(0, None, ctypes.byref(count))) and count.value > 0

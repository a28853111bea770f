"""Rendering without a display: say what is missing before VTK is asked, which would crash."""

from __future__ import annotations

import ctypes
import os
import sys
from functools import cache

import pyvista as pv

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
    if _loads("libEGL.so.1") and _egl_devices() > 0:
        os.environ[_WINDOW] = "vtkEGLRenderWindow"  # without it VTK asks for an X server first, and complains
    elif any(_loads(name) for name in ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")):
        os.environ[_WINDOW] = "vtkOSOpenGLRenderWindow"
    else:
        raise InputError(_MISSING)


def _loads(name: str) -> bool:
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True


def _egl_devices() -> int:
    """Return how many devices there are: none if the library has no driver behind it."""
    from vtkmodules.vtkRenderingOpenGL2 import vtkEGLRenderWindow  # which there is on Linux alone

    with pv.vtk_verbosity("off"):  # the one line is said here
        return int(vtkEGLRenderWindow().GetNumberOfDevices())

"""Public names of a package that are imported on first use, so that the command line starts quickly."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from importlib import import_module
from types import ModuleType
from typing import Any


def lazy_names(package: str, home: Mapping[str, str]) -> None:
    """Let `package` offer public names that live in its modules.

    Parameters
    ----------
    package : str
        The ``__name__`` of the package.
    home : mapping
        For each public name, the module of the package in which it is defined.

    Notes
    -----
    A name may be that of a submodule, as in ``validation.sweep``: Python binds an imported submodule to its
    package, and a property of the package's class is the one thing that this cannot overwrite.  Names of such a
    submodule are imported by ``from validation.sweep.plan import ...``; ``import validation.sweep.plan as plan``
    goes through the attribute, which is the function.
    """

    class Package(ModuleType):
        """The package with its public names as properties."""

        def __dir__(self) -> list[str]:
            return sorted({*super().__dir__(), *home})

    for name, module in home.items():
        setattr(Package, name, _public(package, name, module))
    sys.modules[package].__class__ = Package


def _public(package: str, name: str, module: str) -> property:
    def load(self: ModuleType) -> Any:
        return getattr(import_module(f"{package}.{module}"), name)

    def bind(self: ModuleType, value: Any) -> None:
        if not isinstance(value, ModuleType):
            raise AttributeError(f"{package}.{name} cannot be replaced; replace it in {package}.{module}")

    return property(load, bind, doc=f"See :mod:`{package}.{module}`.")

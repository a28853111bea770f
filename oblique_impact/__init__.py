"""A flexible beam strikes a rigid slope: floating frame, hybrid contact, marching schemes.

`Scenario`          what to simulate (`Scenario.builtin`, `Scenario.load`)
`simulate`          run it: returns a `History`
`History`           labelled samples, event log, summary; `save` and `load`
`simulate_system`   run a small system of one's own through the same contact states
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import TYPE_CHECKING, Any

__all__ = ["History", "InputError", "MechanicalSystem", "Outcome", "Scenario", "simulate", "simulate_system"]

if TYPE_CHECKING:
    from oblique_impact.errors import InputError, Outcome
    from oblique_impact.history import History
    from oblique_impact.scenario import Scenario
    from oblique_impact.simulate import simulate, simulate_system
    from oblique_impact.system import MechanicalSystem

_HOME = {
    "History": "history",
    "InputError": "errors",
    "MechanicalSystem": "system",
    "Outcome": "errors",
    "Scenario": "scenario",
    "simulate_system": "simulate",
}


def __getattr__(name: str) -> Any:
    """Import the public names on first use, so that `oblique-impact --help` stays quick."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


class _Package(ModuleType):
    """The package itself: `simulate` names its function, not the module of that name.

    Python binds an imported submodule to its package; a property is the one thing it cannot overwrite.
    """

    @property
    def simulate(self) -> Any:
        """The function :func:`oblique_impact.simulate.simulate`."""
        from oblique_impact.simulate import simulate

        return simulate

    @simulate.setter
    def simulate(self, module: ModuleType) -> None:
        """Ignore the binding of the submodule."""


sys.modules[__name__].__class__ = _Package

"""Starts programs without importing everything each time: this process has done so, and forks for each of them.

`python -m tests.terminal.warm` reads orders from its standard input, an object of JSON in each line, and answers
with the number of the process and, later, with its exit code.
"""

from __future__ import annotations

import atexit
import gc
import importlib
import json
import os
import runpy
import sys
import tempfile
import threading
from typing import Any

from oblique_impact import History, Scenario, simulate

#: what the commands import by themselves, late
MODULES = """
    oblique_impact.command_line.application oblique_impact.simulation
    oblique_impact.command_line.bars oblique_impact.beam.frequencies validation.suite validation.refinement.command
    validation.reproduction.command validation.sweeps.command validation.sweeps.report renders.command
    renders.campbell renders.player renders.overview renders.exports.command renders.exports.writers
    rich.table validation.sweeps.table renders.scene renders.film
    renders.commands validation.commands validation.comparison fem_beam.reduction pyvista.plotting
    matplotlib.pyplot matplotlib.backends.backend_svg
"""


def main() -> None:
    """Fork for each order."""
    for module in MODULES.split():
        importlib.import_module(module)
    with tempfile.TemporaryDirectory() as folder:  # the kernels are loaded, and what reads and writes
        simulate(Scenario.builtin("paper", ["end_time=1e-3"])).save(folder)
        History.load(folder).data["q"][0].load()
    gc.freeze()  # what is shared stays shared: no program looks through it for garbage
    for line in sys.stdin:
        order = json.loads(line)
        child = os.fork()
        if child == 0:
            _become(order)
            return
        print(child, flush=True)
        _, status = os.waitpid(child, 0)
        print(os.waitstatus_to_exitcode(status), flush=True)


def _draw_every_state() -> None:
    """Draw a bar whenever it changes, not ten times a second: what is seen does not depend on the machine."""
    from oblique_impact.command_line.bars import Bar

    change = Bar.set_fields

    def set_fields(bar: Bar, **fields: Any) -> None:
        change(bar, **fields)
        bar.refresh()

    Bar.set_fields = set_fields  # type: ignore[method-assign]


def _become(order: dict[str, Any]) -> None:
    """Be the program of an order in its terminal, as if a shell had started it there."""
    os.setsid()
    terminal = os.open(order["terminal"], os.O_RDWR)  # the first one of a session becomes its own
    out = os.open(order["stdout"], os.O_WRONLY) if order["stdout"] else terminal
    for number, source in enumerate((terminal, out, terminal)):
        os.dup2(source, number)
    sys.stdin = open(0, closefd=False)  # noqa: SIM115
    sys.stdout = open(1, "w", buffering=1 if os.isatty(1) else -1, closefd=False, encoding="utf-8")  # noqa: SIM115
    sys.stderr = open(2, "w", buffering=1, closefd=False, encoding="utf-8")  # noqa: SIM115
    os.environ.clear()
    os.environ.update(order["environment"])
    os.chdir(order["folder"])
    if order["every_state"]:
        _draw_every_state()
    if order["prepare"]:
        module, _, function = order["prepare"].partition(":")
        getattr(importlib.import_module(module), function)()
    program, *arguments = order["words"]
    sys.argv = [program, *arguments]
    code = None
    try:
        if program.endswith(".py"):
            runpy.run_path(program, run_name="__main__")
        else:
            runpy.run_module(program.replace("-", "_"), run_name="__main__", alter_sys=True)
    except SystemExit as stopped:
        if not isinstance(stopped.code, int | None):
            raise
        code = stopped.code
    _end(code or 0)


def _end(code: int) -> None:
    """End as Python does, but leave it to the system to clear away what was imported: that takes a second."""
    threading._shutdown()  # type: ignore[attr-defined]
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    os._exit(code)


if __name__ == "__main__":
    main()

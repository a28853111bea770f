"""Command line interface: all commands, exit codes, errors in one line."""

from __future__ import annotations

import logging
import os
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.metadata import version
from typing import Annotated, Any

import typer

from oblique_impact.command_line.console import print_note
from oblique_impact.command_line.modes import modes
from oblique_impact.command_line.pictures import export, render
from oblique_impact.command_line.run import run
from oblique_impact.command_line.scenarios import init, scenarios, schema
from oblique_impact.command_line.studies import compare, fit, refine, reproduce, sweep, validate
from oblique_impact.errors import FileWarning, InputError, Interrupted, Outcome

#: shells ask for completions by this variable (typer derives it from the name of the program)
_COMPLETE = "_OBLIQUE_IMPACT_COMPLETE"
#: whose log is printed: how a mesh was read
_TALKING = logging.getLogger("oblique_impact.scenario.mesh_file")
#: in the order of the help page
COMMANDS: dict[str, Callable[..., None]] = {
    command.__name__: command
    for command in (
        scenarios,
        init,
        run,
        render,
        modes,
        refine,
        compare,
        sweep,
        fit,
        export,
        validate,
        reproduce,
        schema,
    )
}


class _Notes(logging.Handler):
    """Prints what is logged as a note."""

    def emit(self, record: logging.LogRecord) -> None:
        print_note(record.getMessage())


def application() -> Any:
    """Return the command of the whole program; each of its commands takes --version."""
    about = "A flexible beam on a pin, a hub or a driven root strikes slopes, tables, corners and pegs."
    app = typer.Typer(name="oblique-impact", help=about, rich_markup_mode=None, pretty_exceptions_enable=False)
    app.callback()(_program)
    for name, command in COMMANDS.items():
        # typer would cut off a short help of its own making
        short = (command.__doc__ or "").partition("\n\n")[0]
        app.command(name, short_help=" ".join(short.split()))(command)
    group: Any = typer.main.get_command(app)
    shown = next(parameter for parameter in group.params if "--version" in parameter.opts)
    for inner in group.commands.values():
        inner.params.append(shown)
    return group


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"oblique-impact {version('oblique-impact')}")
        raise typer.Exit


def _program(
    version: Annotated[
        bool,
        typer.Option(
            "--version",
            help="Show the version and exit.",
            callback=_print_version,
            is_eager=True,
            expose_value=False,
        ),
    ] = False,
) -> None:
    pass


def main(arguments: list[str] | None = None) -> None:
    """Entry point: exit 0 done, 1 stopped by the physics, 2 bad input, 130 interrupted."""
    given = sys.argv[1:] if arguments is None else arguments
    if _COMPLETE in os.environ:  # the shell asks for completions
        application().main(prog_name="oblique-impact", complete_var=_COMPLETE)
    notes = _Notes()
    _TALKING.addHandler(notes)
    _TALKING.setLevel(logging.INFO)
    try:
        code = _call(given or ["--help"])
    except KeyboardInterrupt as interrupt:
        details = () if isinstance(interrupt, Interrupted) else interrupt.args
        print_note(": ".join(["interrupted", *map(str, details)]))
        code = Outcome.INTERRUPTED.exit_code
    finally:
        _TALKING.removeHandler(notes)
        _TALKING.setLevel(logging.NOTSET)
    sys.exit(code)


@contextmanager
def _file_warnings_in_one_line() -> Iterator[None]:
    """Show what stands against a file that is read as this program shows warnings, not as Python does."""
    with warnings.catch_warnings():
        show_others = warnings.showwarning

        def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
            if issubclass(category, FileWarning):
                print_note(f"warning: {message}")
            else:
                show_others(message, category, *place, **more)

        warnings.simplefilter("always", FileWarning)
        warnings.showwarning = show
        yield


def _call(arguments: list[str]) -> int:
    """Run a command and return its exit code; bad input is one line."""
    command = application()
    try:
        # typer's own main would swallow interrupts
        with _file_warnings_in_one_line(), command.make_context("oblique-impact", arguments) as context:
            command.invoke(context)
    except typer.Exit as end:
        return end.exit_code
    except InputError as error:
        print_note(str(error))
    except MemoryError as error:
        needed = " ".join(str(error).split()) or "a smaller model or fewer samples are needed"
        print_note(f"not enough memory: {needed}")
    except OSError as error:  # a name that is too long, for instance, wherever that is noticed
        print_note(": ".join(str(part) for part in (error.filename, error.strerror or error) if part))
    except Exception as error:
        # typer's usage errors have no public base class; they all know how to say what is wrong
        if not hasattr(error, "format_message"):
            raise
        print_note(" ".join(error.format_message().split()))
    else:
        return 0
    return 2

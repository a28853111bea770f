"""The application: all commands, their exit codes, errors in one line."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any, get_args

import typer

from oblique_impact.command_line.init import init
from oblique_impact.command_line.modes import modes
from oblique_impact.command_line.run import run
from oblique_impact.command_line.scenarios import scenarios
from oblique_impact.command_line.schema import schema
from oblique_impact.command_line.words import print_note, print_text
from oblique_impact.errors import InputError, Interrupted, Outcome
from oblique_impact.renders.commands import export, render
from oblique_impact.validation.commands import compare, refine, reproduce, sweep, validate

#: what every command line of this program is made with
OPTIONS: dict[str, Any] = {"rich_markup_mode": None, "pretty_exceptions_enable": False}
#: what help calls a value of a type
VALUES = {int: "INTEGER", float: "NUMBER", Path: "PATH", str: "TEXT", bool: ""}
#: shells ask for completions by this variable (typer derives it from the name of the program)
_COMPLETE = "_OBLIQUE_IMPACT_COMPLETE"
#: in the order of the help page
COMMANDS: dict[str, Callable[..., None]] = {
    command.__name__: command
    for command in (
        *(scenarios, init, run, render, modes, refine, compare, sweep, export),
        *(validate, reproduce, schema),
    )
}


def application(wanted: str | None = None) -> typer.Typer:
    """Return the application; if there is a command called `wanted`, it is the only one in it."""
    about = "A flexible beam swings on a pin, strikes a rigid slope, slips, sticks and bounces."
    app = typer.Typer(name="oblique-impact", help=about, **OPTIONS)
    app.callback()(_program)
    for name in [wanted] if wanted in COMMANDS else COMMANDS:
        # a short help that is given is not cut off
        short = (COMMANDS[name].__doc__ or "").partition("\n\n")[0]
        app.command(name, short_help=" ".join(short.split()))(COMMANDS[name])
    return app


def _print_version(wanted: bool) -> None:
    if wanted:
        print_text(f"oblique-impact {version('oblique-impact')}")
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


def _command(wanted: str | None = None) -> Any:
    """Return the application for the command line: each command takes --version, no help shows a Python type."""
    command: Any = typer.main.get_command(application(wanted))
    shown = next(parameter for parameter in command.params if "--version" in parameter.opts)
    for inner in command.commands.values():
        for parameter in inner.params:
            parameter.metavar = parameter.metavar or value_name(parameter) or None
            if parameter.param_type_name == "argument":
                parameter.display_type_rich = lambda ctx: None
        inner.params.append(shown)
    return command


def value_name(parameter: Any) -> str:
    """Return what help calls the value of a parameter of a command, such as NUMBER; nothing for a flag."""
    annotation = parameter.type_descriptor.annotation
    while not isinstance(annotation, type) or get_args(annotation):
        annotation = next(part for part in get_args(annotation) if part is not type(None))
    return VALUES.get(annotation, "TEXT")


def main(arguments: list[str] | None = None) -> None:
    """Entry point: exit 0 done, 1 stopped by the physics, 2 bad input, 130 interrupted."""
    given = sys.argv[1:] if arguments is None else arguments
    if _COMPLETE in os.environ:  # the shell asks what may stand here
        _command().main(prog_name="oblique-impact", complete_var=_COMPLETE)
    try:
        code = _call(given or ["--help"])
    except KeyboardInterrupt as stop:
        words = () if isinstance(stop, Interrupted) else stop.args
        print_note(": ".join(["interrupted", *map(str, words)]))
        code = Outcome.INTERRUPTED.exit_code
    sys.exit(code)


def _call(arguments: list[str]) -> int:
    """Run a command and return its exit code; what is wrong with the input is said in one line."""
    try:
        # not through typer's own main: it swallows interrupts
        command = _command(arguments[0])
        with command.make_context("oblique-impact", arguments) as context:
            command.invoke(context)
        sys.stdout.flush()
    except typer.Exit as stop:
        return stop.exit_code
    except BrokenPipeError:
        # the reader of the output is gone: nothing more can be written there, not even at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return 1
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

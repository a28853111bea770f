"""Arguments and options that several commands have."""

from __future__ import annotations

from typing import Annotated

import typer

ScenarioArgument = Annotated[str, typer.Argument(help="A built-in name (paper, ...) or a TOML file.")]
SetOption = Annotated[
    list[str] | None, typer.Option("--set", metavar="SECTION.KEY=VALUE", help="Change a key; repeatable.")
]

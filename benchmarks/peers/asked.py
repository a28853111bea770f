"""Small problems with known answers, asked of other programs.

    PYTHONPATH=benchmarks python -m peers.asked            all; a few minutes, most of it compiling
    PYTHONPATH=benchmarks python -m peers.asked friction   of one module: friction, impacts, structures

Programs are in the extra `bench`, at the versions that gave the numbers of docs/comparison.md; one that is not
there is said to be missing.  No problem needs oblique-impact.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib import import_module, metadata

from measuring import print_table

from peers.problems import Question

MODULES = ("friction", "impacts", "structures")
PACKAGES = {
    "Newton": "newton",
    "PyElastica": "pyelastica",
    "Drake": "drake",
    "Box2D": "box2d",
}  # where names differ


def _version(program: str) -> str:
    return metadata.version(program.split(",")[0].lower())


def rows(question: Question) -> Iterator[list[str]]:
    """Yield what each program finds."""
    for program, settings, run in question.runs:
        try:
            yield [program, _version(program), settings, run()]
        except ImportError:  # of which a missing distribution is one
            yield [program, "", settings, "not installed"]


def main(modules: list[str]) -> None:
    """Ask and print."""
    for module in modules or MODULES:
        for question in import_module(f"peers.{module}").questions():
            print_table(question.title, ("program", "version", "settings", "found"), rows(question))


if __name__ == "__main__":
    main(sys.argv[1:])

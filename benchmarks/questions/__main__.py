"""Answers the questions of docs/which-way.md again.

    PYTHONPATH=benchmarks python -m questions             all; fails where a number is not the stored one
    PYTHONPATH=benchmarks python -m questions depth hub   of some modules
    PYTHONPATH=benchmarks python -m questions --write     keeps the numbers, of some modules or all

The numbers are in docs/which-way.json, as computed; `--write` makes the page of them, too.
"""

from __future__ import annotations

import sys
import time
from importlib import import_module

from questions.page import PAGE, STORE, differences, disagreements, page, plain, stored, written
from questions.question import Question

#: modules with a list `QUESTIONS` each
MODULES = (
    *("damper", "depth", "modulus", "hub", "place", "gravity", "friction", "plastic", "shaken"),
    *("bars", "strips", "rest", "blows", "preload"),
)


def questions(modules: tuple[str, ...] = MODULES) -> list[Question]:
    """Return the questions of some modules."""
    return [one for module in modules for one in import_module(f"questions.{module}").QUESTIONS]


def main(words: list[str]) -> int:
    """Answer, compare or write; returns the exit code."""
    write, modules = "--write" in words, tuple(word for word in words if word != "--write") or MODULES
    numbers, faults = stored(), []
    for question in questions(modules):
        started = time.perf_counter()
        rows = plain(question.compute())
        print(f"{time.perf_counter() - started:5.1f} s  {question.title}", flush=True)
        faults += disagreements(question, rows)
        if write:
            numbers[question.name] = rows
        else:
            faults += differences(question, rows, numbers.get(question.name, []))
    if write:
        names = [question.name for question in questions()]
        STORE.write_text(written({name: numbers[name] for name in names}), encoding="utf-8")
        PAGE.write_text(page(questions(), stored(), PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    print(*faults, sep="\n")
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

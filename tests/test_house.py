"""Imports run one way: from the command line down to the kernels, and no modules import each other in a circle."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from oblique_impact.kernels.jit import _NUMERIC_SOURCE

ROOT = Path(__file__).parents[1]
#: folders beside the core that are its sub-packages when installed
BESIDE = ("modal", "fem_beam", "renders", "validation")
#: rooms from the bottom to the top: a module imports, when it is loaded, from the floors below its own only
FLOORS = (
    {"errors", "interrupts", "public"},
    {"files", "installed", "machine", "progress", "kernels"},
    {"scenario"},
    {"contact"},
    {"beam"},
    {"marching"},
    {"history", "problem"},
    {"modal", "fem_beam", "simulation"},
    {"renders"},
    {"validation"},
    {"command_line"},
)


def modules() -> dict[str, Path]:
    """Every module by its installed name."""
    found = {}
    for folder in ("oblique_impact", *BESIDE):
        for file in sorted((ROOT / folder).rglob("*.py")):
            parts = file.relative_to(ROOT).with_suffix("").parts
            parts = parts if folder == "oblique_impact" else ("oblique_impact", *parts)
            found[".".join(parts).removesuffix(".__init__")] = file
    return found


def loaded(file: Path) -> Iterator[str]:
    """Names that a module imports when it is loaded: not in functions, not for type checkers."""
    todo = list(ast.parse(file.read_text(encoding="utf-8")).body)
    while todo:
        node = todo.pop()
        if isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif not (
            isinstance(node, ast.FunctionDef)
            or (isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test))
        ):
            todo += ast.iter_child_nodes(node)


def test_imports_run_downwards():
    floor = {room: number for number, rooms in enumerate(FLOORS) for room in rooms}
    wrong = []
    for module, file in modules().items():
        room = module.split(".")[1] if "." in module else ""
        if room in floor and not module.endswith((".command", ".commands")):
            for name in loaded(file):
                package, _, rest = name.partition(".")
                other = rest.partition(".")[0]
                if package == "oblique_impact" and other in floor and other != room:
                    wrong += [f"{module} imports {name}"] * (floor[other] >= floor[room])
    assert wrong == []


def test_no_circle_of_modules():
    known = modules()
    left = {}
    for module, file in known.items():
        names = {name if name in known else name.rpartition(".")[0] for name in loaded(file)}
        left[module] = names & known.keys() - {module, "oblique_impact"}
    while free := {module for module, targets in left.items() if not targets & left.keys()}:
        left = {module: targets for module, targets in left.items() if module not in free}
    assert sorted(left) == []


def test_the_numeric_source_has_no_whole_powers():
    """numba compiles x**2 once a process, with the options of whoever comes first: other bits elsewhere."""
    powers = [
        f"{file}:{node.lineno}"
        for name in _NUMERIC_SOURCE
        for file in [ROOT / "oblique_impact" / name, *(ROOT / "oblique_impact" / name).rglob("*.py")]
        if file.is_file()
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and isinstance(node.right, ast.Constant)
        if isinstance(node.right.value, int)
    ]
    assert powers == []

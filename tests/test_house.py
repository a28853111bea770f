"""Imports run one way, from the command line down to the kernels, in no circle; names mean one thing each."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
#: folders beside the core that are its sub-packages when installed
BESIDE = ("modal", "fem_beam", "renders", "validation")
#: from the bottom to the top: a module imports, but in functions, only from lower layers and from its own package
LAYERS = (
    {"errors"},
    {"files", "installed", "machine", "kernels"},
    {"scenario"},
    {"contact"},
    {"beam", "progress"},
    {"marching"},
    {"history", "beam_problem"},
    {"modal", "fem_beam", "simulation"},
    {"renders", "api"},
    {"validation"},
    {"command_line"},
)
#: names of files that occur twice and are still to be told apart
TWICE = {"several.py"}


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
    """Names that a module imports when it is loaded, or for type checkers: not in functions."""
    todo = list(ast.parse(file.read_text(encoding="utf-8")).body)
    while todo:
        node = todo.pop()
        if isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif not isinstance(node, ast.FunctionDef):
            todo += ast.iter_child_nodes(node)


def imported(file: Path) -> Iterator[str]:
    """Names that a module imports anywhere in it."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def test_imports_run_downwards():
    layer = {package: number for number, packages in enumerate(LAYERS) for package in packages}
    wrong = []
    for module, file in modules().items():
        own = module.split(".")[1] if "." in module else ""
        if own in layer:
            for name in loaded(file):
                package, _, rest = name.partition(".")
                other = rest.partition(".")[0]
                if package == "oblique_impact" and other in layer and other != own:
                    wrong += [f"{module} imports {name}"] * (layer[other] >= layer[own])
    assert wrong == []


def test_validation_marches_by_public_calls_alone():
    wrong = []
    for module, file in modules().items():
        if module.startswith("oblique_impact.validation"):
            wrong += [f"{module} imports {name}" for name in imported(file) if ".marching." in f"{name}."]
    assert wrong == []


def test_pictures_need_a_history_file_alone():
    """What makes histories is not imported by what draws them, nowhere in it."""
    makers = {"marching", "beam_problem", "simulation", "continuing", "modal", "fem_beam", "validation"}
    wrong = []
    for module, file in modules().items():
        if module.startswith("oblique_impact.renders"):
            wrong += [f"{module} imports {name}" for name in imported(file) if makers & set(name.split(".")[1:2])]
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


def test_each_name_of_a_class_or_file_is_given_once():
    names = []
    for file in modules().values():
        if file.name != "__init__.py":
            names.append(file.name)
        tree = ast.parse(file.read_text(encoding="utf-8"))
        names += [node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
    assert {name for name, times in Counter(names).items() if times > 1} - TWICE == set()

"""The plan of the house: which room may import which; imports inside of functions count."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from importlib.metadata import distribution
from pathlib import Path

import pytest

from oblique_impact.kernels.jit import _NUMERIC_SOURCE

ROOT = Path(__file__).parents[1]
CORE = "oblique_impact"
#: rooms of the core from the bottom to the top: each imports from the floors below its own only
FLOORS = (
    {"errors", "interrupts", "public"},
    {"files", "installed", "machine", "progress", "kernels"},
    {"scenario"},
    {"contact"},
    {"beam"},
    {"marching"},
    {"history", "problem"},
    {"simulation"},
    {"command_line"},
)
#: what stands in front of them: the table of contents, and the program's door
DOORS = {"", "__main__"}
#: packages beside the core, and what they import from
BESIDE = {
    "modal": {CORE},
    "fem_beam": {CORE},
    "renders": {CORE},
    "validation": {CORE, "renders", "modal", "fem_beam"},
}


def imports_of(root: Path, *packages: str) -> Iterator[tuple[str, str]]:
    """Yield (module, imported module or name), wherever in a module an import stands."""
    for package in packages:
        for file in sorted((root / package).rglob("*.py")):
            module = ".".join(file.relative_to(root).with_suffix("").parts).removesuffix(".__init__")
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Import):
                    yield from ((module, alias.name) for alias in node.names)
                elif isinstance(node, ast.ImportFrom):
                    assert node.level == 0, f"{module}: imports are absolute"
                    yield from ((module, f"{node.module}.{alias.name}") for alias in node.names)


def room_of(name: str) -> str:
    return name.split(".")[1] if "." in name else ""


def upward(root: Path) -> list[str]:
    """Imports of the core that do not run downwards, and those that leave it."""
    floor = {room: number for number, rooms in enumerate(FLOORS) for room in rooms}
    found = []
    for module, name in imports_of(root, CORE):
        ours, package = room_of(module), name.split(".")[0]
        if package in BESIDE:
            found.append(f"{module} imports {name}")
        elif package == CORE and ours not in DOORS:
            theirs = room_of(name)
            if theirs != ours and not floor.get(theirs, len(FLOORS)) < floor[ours]:
                found.append(f"{module} imports {name}")
    return found


def circles(root: Path) -> list[str]:
    """Circles between the modules of the core; an import for type checkers alone makes none."""
    edges: dict[str, set[str]] = {}
    for file in sorted((root / CORE).rglob("*.py")):
        module = ".".join(file.relative_to(root).with_suffix("").parts).removesuffix(".__init__")
        edges[module] = set()
    for module in edges:
        path = root.joinpath(*module.split("."))
        source = (path / "__init__.py" if path.is_dir() else path.with_suffix(".py")).read_text(encoding="utf-8")
        for node in _run(ast.parse(source)):
            names = [f"{node.module}.{a.name}" for a in node.names] if isinstance(node, ast.ImportFrom) else []
            for name in names:
                target = name if name in edges else name.rpartition(".")[0]
                if target in edges and target not in (module, CORE):
                    edges[module].add(target)
    left = dict(edges)
    while free := {module for module, targets in left.items() if not targets & left.keys()}:
        left = {module: targets for module, targets in left.items() if module not in free}
    return sorted(left)


def _run(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes that are run: not those under ``if TYPE_CHECKING``."""
    for node in ast.iter_child_nodes(tree):
        if not (isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"):
            yield node
            yield from _run(node)


def test_every_room_has_a_floor_and_the_core_has_nine_at_most():
    rooms = {
        path.stem for path in (ROOT / CORE).iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()
    }
    assert rooms - {"__init__", "__main__"} == set().union(*FLOORS)
    assert len(FLOORS) <= 9


def test_no_import_of_the_core_runs_upwards_or_leaves_it():
    assert upward(ROOT) == []


def test_no_circle_of_modules():
    assert circles(ROOT) == []


@pytest.mark.parametrize("package", BESIDE)
def test_packages_beside_the_core_import_in_one_direction(package):
    allowed = {*BESIDE[package], package}
    for module, name in imports_of(ROOT, package):
        if name.split(".")[0] in {*BESIDE, CORE}:
            assert name.split(".")[0] in allowed, f"{module} imports {name}"


@pytest.mark.parametrize(
    ("file", "line"),
    [
        ("scenario/toml.py", "from oblique_impact.beam.operators import build_operators"),
        ("kernels/dense.py", "def f():\n    from oblique_impact.scenario import toml"),
        ("errors.py", "import oblique_impact.files"),
        ("command_line/modes.py", "def f():\n    import renders.campbell"),
        ("history/summary.py", "from validation import compare"),
    ],
)
def test_a_planted_import_is_found(tmp_path, file, line):
    (tmp_path / CORE / file).parent.mkdir(parents=True)
    (tmp_path / CORE / file).write_text(f"{line}\n", encoding="utf-8")
    assert len(upward(tmp_path)) == 1


def test_a_planted_circle_is_found(tmp_path):
    (tmp_path / CORE).mkdir()
    for name, other in (("a", "b"), ("b", "a")):
        line = f"def f():\n    from {CORE} import {other}\n"
        (tmp_path / CORE / f"{name}.py").write_text(line, encoding="utf-8")
    assert circles(tmp_path) == [f"{CORE}.a", f"{CORE}.b"]


def test_the_numeric_source_has_no_whole_powers():
    """numba compiles x**2 once a process, with the options of whoever comes first: other bits elsewhere."""
    powers = [
        f"{file}:{node.lineno}"
        for name in _NUMERIC_SOURCE
        for file in [ROOT / CORE / name, *(ROOT / CORE / name).rglob("*.py")]
        if file.is_file()
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and isinstance(node.right, ast.Constant)
        if isinstance(node.right.value, int)
    ]
    assert powers == []


def test_the_commands_of_other_packages_are_installed():
    points = distribution("oblique-impact").entry_points.select(group="oblique_impact.commands")
    assert sorted(points.names) == ["compare", "export", "refine", "render", "reproduce", "sweep", "validate"]

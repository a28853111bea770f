"""Pictures need a history file alone: what marches, or makes a problem of a scenario, is not loaded for them."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

from oblique_impact import renders

#: parts of the program that make histories
MAKERS = ("marching", "problem", "simulation", "continuing", "modal", "fem_beam", "validation")
SCRIPT = """
import json, sys
from oblique_impact.history.history import History
history = History.load(sys.argv[1])
before = set(sys.modules)
from oblique_impact import renders
for name in renders.__all__:
    getattr(renders, name)
for suffix in ("png", "svg", "gif", "html"):
    renders.render(history, f"{sys.argv[2]}/a.{suffix}", renders.Style(size=(320, 240)), frames=2)
renders.export(history, f"{sys.argv[2]}/a.xdmf", every=1000)
history.plot()
print(json.dumps(sorted(set(sys.modules) - before)))
"""


@pytest.mark.slow  # the quick one reads the imports
def test_drawing_a_saved_history_loads_nothing_that_makes_one(folder, tmp_path):
    command = [sys.executable, "-c", SCRIPT, str(folder), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    loaded = json.loads(done.stdout.splitlines()[-1])
    assert "oblique_impact.renders.overview" in loaded
    assert [name for name in loaded if name.removeprefix("oblique_impact.").split(".")[0] in MAKERS] == []


def imported(file: Path) -> set[str]:
    """Names of modules that a source file imports, wherever it does."""
    nodes = list(ast.walk(ast.parse(file.read_text(encoding="utf-8"))))
    names = {node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)}
    return names | {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}


@pytest.mark.parametrize("maker", MAKERS)
def test_no_source_of_renders_imports_what_makes_histories(maker):
    sources = sorted(Path(renders.__file__).parent.rglob("*.py"))
    assert len(sources) > 20
    for file in sources:
        assert not [name for name in imported(file) if name.startswith(f"oblique_impact.{maker}")], file

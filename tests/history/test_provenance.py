"""Provenance of results: the same digest for the same numeric source, another one for another."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

from oblique_impact import History
from oblique_impact.history.provenance import NUMERIC_PACKAGES, provenance, provenance_line, source_digest

TOP = Path(__file__).parents[2]
FOLDERS = ("oblique_impact", "modal", "fem_beam")
DIGEST = "from oblique_impact.history.provenance import NUMERIC_PACKAGES, source_digest, provenance; \
print(source_digest(NUMERIC_PACKAGES), provenance().get('commit'))"


def digest_in(folder):
    """The digest, and the commit, that a process finds which imports the packages from a folder."""
    words = [sys.executable, "-S", "-c", f"import sys; sys.path[:0] = {[str(folder), *sys.path]}; {DIGEST}"]
    return subprocess.run(words, capture_output=True, text=True, check=True, cwd=folder).stdout.split()


def test_another_numeric_source_has_another_digest(tmp_path):
    """As in a wheel, where the packages lie inside of each other; a copy is no checkout."""
    for folder in FOLDERS:
        inside = tmp_path / "oblique_impact" / ("" if folder == "oblique_impact" else folder)
        shutil.copytree(TOP / folder, inside, ignore=shutil.ignore_patterns("__pycache__"))
    assert digest_in(tmp_path) == [source_digest(NUMERIC_PACKAGES), "None"]
    found = {source_digest(NUMERIC_PACKAGES)}
    for changed in ("marching/loop.py", "modal/assembly.py", "fem_beam/element.py"):
        with (tmp_path / "oblique_impact" / changed).open("a") as file:
            file.write("# another physics\n")
        found.add(digest_in(tmp_path)[0])
    assert len(found) == 4


def test_every_result_says_what_made_it(run, tmp_path):
    made = History.load(run("paper", "end_time=0.01").save(tmp_path)).summary["provenance"]
    assert made == provenance()
    assert made["numeric_source"] == source_digest(NUMERIC_PACKAGES)
    for value in made.values():
        assert value in provenance_line(made)

"""What made a result: the same for the same source, another for another one, in every file that a person keeps."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from oblique_impact import History
from oblique_impact.history.provenance import (
    NUMERIC_PACKAGES,
    described,
    provenance,
    source_digest,
)
from oblique_impact.validation.sweeps.plan import load_plan

TOP = Path(__file__).parents[2]


def in_a_copy(folder, code):
    """Print something in a process that imports the packages from a folder."""
    words = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(folder)!r}); {code}"]
    return subprocess.run(words, capture_output=True, text=True, check=True, cwd=folder).stdout.strip()


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    folder = tmp_path_factory.mktemp("copy")
    for package in (*NUMERIC_PACKAGES, "oblique_impact.validation"):
        shutil.copytree(TOP / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


def test_a_sweep_of_another_physics_is_another_sweep(copy):
    """The digest of what was changed is another one, and only that, and the sweep in any case."""
    code = (
        "from oblique_impact.history.provenance import NUMERIC_PACKAGES, provenance, source_digest; "
        "from validation.sweeps.plan import load_plan; "
        "print(source_digest(NUMERIC_PACKAGES), source_digest(('oblique_impact.validation',)), "
        "load_plan('friction').fingerprint, provenance().get('commit'))"
    )
    digests = [
        source_digest(NUMERIC_PACKAGES),
        source_digest(("oblique_impact.validation",)),
        load_plan("friction").fingerprint,
    ]
    assert in_a_copy(copy, code).split() == [*digests, "None"]  # a copy is no checkout
    changes = {
        "oblique_impact/marching/loop.py": [True, False, True],
        "modal/assembly.py": [True, False, True],
        "fem_beam/element.py": [True, False, True],
        "validation/quantities.py": [False, True, True],
    }
    for place, changed in changes.items():
        file = copy / place
        before = file.read_text()
        file.write_text(before + "\n# another physics, or another measure\n")
        theirs = in_a_copy(copy, code).split()[:3]
        file.write_text(before)
        assert [mine != their for mine, their in zip(digests, theirs, strict=True)] == changed, place


def test_every_result_says_what_made_it(run, tmp_path):
    history = run("paper", "end_time=0.01")
    made = History.load(history.save(tmp_path)).summary["provenance"]
    assert made == provenance()
    assert made["numeric_source"] == source_digest(NUMERIC_PACKAGES)
    assert made["version"] in described(made)
    assert made["numeric_source"] in described(made)


def test_a_line_names_commit_and_parts():
    parts = {"friction": "Own()"}
    made = {"version": "1.2", "commit": "abc-dirty", "numeric_source": "0123", "user_defined": parts}
    assert described(made) == "oblique-impact 1.2, commit abc-dirty, numeric source 0123, friction = Own()"

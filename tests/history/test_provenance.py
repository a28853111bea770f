"""What made a result: the same for the same source, another for another one, in every file that a person keeps."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from oblique_impact import History, Scenario
from oblique_impact.contact.friction import FrictionCurve
from oblique_impact.history.provenance import (
    NUMERIC_PACKAGES,
    described,
    named_in,
    part_digest,
    part_digests,
    part_keys,
    provenance,
    source_digest,
)
from oblique_impact.scenario.user_defined import register
from oblique_impact.validation.studies.design import load_plan, make_plan

TOP = Path(__file__).parents[2]
SWEEP = """
scenario = "paper"
[[axes]]
key = "contact.friction"
values = [{values}]
"""


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


def law(doubled):
    """Return one of two friction laws of the same name."""
    if doubled:

        class Own(FrictionCurve):
            def __init__(self, mu=0.3):
                super().__init__(((0.0, 2.0 * mu), (1.0, 2.0 * mu)), None)

    else:

        class Own(FrictionCurve):
            def __init__(self, mu=0.3):
                super().__init__(((0.0, mu), (1.0, mu)), None)

    Own.__module__ = "__main__"  # as typed at a prompt or in a notebook: there is no file to tell them apart
    return Own


def test_user_defined_parts_have_a_digest_of_their_own():
    assert part_digest(law(False)) == part_digest(law(False))
    assert part_digest(law(False)) != part_digest(law(True))
    assert set(part_keys()) == {
        "root.profile",
        "contact.normal",
        "contact.impact",
        "contact.friction",
        "discretization.method",
        "solver.scheme",
    }
    assert part_digests(named_in(Scenario.builtin("paper"))) == {}
    assert "user_defined" not in provenance(named_in(Scenario.builtin("tapered")))
    plans = []
    for doubled in (False, True):
        own = law(doubled)
        register("friction_laws", "provenance-test")(own)
        digests = part_digests([("contact.friction", "provenance-test"), ("contact.friction", "hybrid")])
        assert digests == {"contact.friction: provenance-test": part_digest(own)}
        for other in ("provenance-test", "frictionless"):
            plans.append(make_plan(SWEEP.format(values=f'"hybrid", "{other}"')).fingerprint)
    assert plans[0] != plans[2]
    assert plans[1] == plans[3]  # no run names the law


def test_every_result_says_what_made_it(run, tmp_path):
    history = run("paper", "end_time=0.01")
    made = History.load(history.save(tmp_path)).summary["provenance"]
    assert made == provenance(named_in(Scenario.builtin("paper")))
    assert made["numeric_source"] == source_digest(NUMERIC_PACKAGES)
    assert made["version"] in described(made)
    assert made["numeric_source"] in described(made)


def test_a_line_names_commit_and_parts():
    made = {"version": "1.2", "commit": "abc-dirty", "numeric_source": "0123", "user_defined": {"a.b: c": "4567"}}
    assert described(made) == "oblique-impact 1.2, commit abc-dirty, numeric source 0123, a.b: c (4567)"

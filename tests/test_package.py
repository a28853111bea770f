"""What the distribution says of itself; `make package` builds, installs and uses it."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.version import Version

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LOCKED = dict(
    re.findall(r"^([\w.-]+)==(\S+)", (ROOT / "requirements.lock").read_text(encoding="utf-8"), re.MULTILINE)
)
LOCKED = {name.lower().replace("_", "-"): version for name, version in LOCKED.items()}
#: of other programs, which only the benchmarks take and no lock holds
UNLOCKED = {Requirement(need).name for need in PROJECT["optional-dependencies"]["bench"]}
NEEDS = [
    *PROJECT["dependencies"],
    *(need for extra in PROJECT["optional-dependencies"].values() for need in extra),
]


@pytest.mark.parametrize("need", sorted(set(NEEDS)))
def test_what_the_project_and_its_extras_need_is_locked_at_a_version_that_will_do(need):
    """So what the tests run with is what an extra installs."""
    wanted = Requirement(need)
    if wanted.name == PROJECT["name"]:
        assert wanted.extras <= PROJECT["optional-dependencies"].keys()
    elif wanted.name not in UNLOCKED:
        assert wanted.specifier.contains(LOCKED[wanted.name.lower().replace("_", "-")])


def test_ci_installs_the_lower_bounds():
    """What `.ci/bounds` uses the program with are the least versions that will do."""
    least = {}
    for need in (*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["test"]):
        (bound,) = (limit for limit in Requirement(need).specifier if limit.operator == ">=")
        least[Requirement(need).name] = Version(bound.version)
    pins = [Requirement(line) for line in (ROOT / "requirements.bounds").read_text(encoding="utf-8").splitlines()]
    installed = {pin.name: Version(next(iter(pin.specifier)).version) for pin in pins}
    assert installed == least


def test_the_citation_is_of_this_version():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert cited["version"] == PROJECT["version"]
    assert cited["license"] == PROJECT["license"]
    assert cited["authors"] == PROJECT["authors"]
    assert set(cited["keywords"]) == set(PROJECT["keywords"])
    (paper,) = cited["references"]
    assert [author["family-names"] for author in paper["authors"]] == ["Yuan", "Li", "Zhang", "Hong"]


def test_the_changelog_tells_of_this_version_and_when_it_came():
    """The version stands in pyproject.toml; the newest released section is it, on the day of the citation."""
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    first, *released = re.findall(r"^## \[(.+)$", text, re.MULTILINE)
    assert first == "Unreleased]"
    versions = [re.fullmatch(r"(\d+)\.(\d+)\.(\d+)\] - (\d{4}-\d{2}-\d{2})", heading) for heading in released]
    assert all(versions)
    numbers = [tuple(map(int, found.groups()[:3])) for found in versions]
    dates = [found[4] for found in versions]
    assert (numbers, dates) == (sorted(numbers, reverse=True), sorted(dates, reverse=True))
    assert ".".join(map(str, numbers[0])) == PROJECT["version"]
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert str(cited["date-released"]) == dates[0]


def test_every_module_and_file_of_the_packages_is_named():
    tool = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    beside = tool["package-dir"].values()
    folders = {
        ".".join(file.parent.relative_to(ROOT).parts)
        for package in ("oblique_impact", *beside)
        for file in (ROOT / package).rglob("*.py")
    }
    names = {f if f.startswith("oblique_impact") else f"oblique_impact.{f}" for f in folders}
    assert names == set(tool["packages"])

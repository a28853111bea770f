"""The command `reproduce`: its files, and that two runs are the same."""

from __future__ import annotations

import csv
import html
import json
import re
import xml.etree.ElementTree as ET

import pytest

from oblique_impact.validation.reproduction import command
from oblique_impact.validation.reproduction.cases import combinations, main_cases, sticking_cases, variant_cases
from oblique_impact.validation.reproduction.unsaid import ALL_CLAIMS

FILES = ["claims.csv", "figures", "figures.csv", "report.html", "results.json", "sensitivity.csv"]


def without_times(page):
    return re.sub(r'<dd class="time">.*?</dd>', "", page)


def check(folder):
    assert sorted(path.name for path in folder.iterdir()) == FILES
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "<script src" not in page
    assert re.findall(r'(?:src|href)="(?!#)([^"]*)"|url\((?!#)([^)]*)\)', page) == []
    data = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    assert [claim["id"] for claim in data["claims"]] == [claim.id for claim in ALL_CLAIMS]
    assert {claim["verdict"] for claim in data["claims"]} <= {"reproduced", "partly", "not reproduced"}
    assert all(claim["paper"] and claim["ours"] and "number" in claim for claim in data["claims"])
    same = sum(not claim["discriminates"] for claim in data["claims"])
    assert f"{same} of them, marked =, do not discriminate" in page
    assert page.count(">=\u00a0") == same
    assert all(claim.rule in html.unescape(page) for claim in ALL_CLAIMS)
    with (folder / "claims.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["verdict"] for row in rows] == [claim["verdict"] for claim in data["claims"]]
    assert all(claim.statement in page.replace("&#39;", "'") for claim in ALL_CLAIMS)
    drawn = list((folder / "figures").iterdir())
    assert page.count("<svg") == len(drawn)
    for path in drawn:
        ET.fromstring(path.read_text(encoding="utf-8"))
    with (folder / "sensitivity.csv").open(encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == len(data["sensitivity"])
    return data


@pytest.mark.slow
def test_report_of_a_few_cases(tmp_path, monkeypatch, cli):
    """The whole report, with fewer choices and coarser samples."""
    coarse = [
        type(case)(case.key, case.scenario.replace(solver__output_interval=2e-4), case.sticking)
        for case in (*main_cases(), *sticking_cases())
    ]
    few = [item for item in variant_cases() if item[0].choice in ("Baumgarte's form", "integrator")]
    monkeypatch.setattr(command, "main_cases", lambda: coarse)
    monkeypatch.setattr(command, "sticking_cases", list)
    monkeypatch.setattr(command, "combinations", lambda: combinations()[:1])
    monkeypatch.setattr(command, "variant_cases", lambda: [i for i in few if "1 µs always" not in i[0].label])
    code, out, _ = cli("reproduce", "--out", tmp_path, "--workers", 1)
    assert code == 0
    data = check(tmp_path)
    assert len(data["combinations"]) == 1
    assert f"{len(data['claims'])} claims: " in out
    assert {row["figure"] for row in data["figures"]} >= {str(n) for n in range(2, 17)}
    threshold = data["stick_threshold"]
    assert [tried["happened"].split()[0] for tried in threshold["tried"]] == ["reversal", "stick"]


@pytest.mark.slow
def test_two_runs_are_the_same_except_for_times(tmp_path, cli):
    one, two = tmp_path / "one", tmp_path / "two"
    assert cli("reproduce", "--out", one)[0] == 0
    assert cli("reproduce", "--out", two, "--workers", 1)[0] == 0
    data = check(one)
    for path in sorted(one.rglob("*.*")):
        other = two / path.relative_to(one)
        if path.name == "report.html":
            assert without_times(path.read_text(encoding="utf-8")) == without_times(
                other.read_text(encoding="utf-8")
            )
        elif path.is_file():
            assert path.read_bytes() == other.read_bytes(), path.name
    verdicts = {claim["id"]: claim["verdict"] for claim in data["claims"]}
    # theory, Sec. 8: what two clamped modes reproduce, and what no choice does
    assert verdicts["friction-coincides"] == verdicts["friction-drifts-apart"] == "reproduced"
    assert verdicts["stick-at-0.699"] == "not reproduced"
    assert data["stick_threshold"]["ratio"] > 10.0

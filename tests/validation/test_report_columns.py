"""What stands under each heading of a report, on the page and in the tables for machines."""

from __future__ import annotations

import csv
import html
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from oblique_impact import Scenario
from oblique_impact.validation import suite
from oblique_impact.validation.checks.registry import Check, Group, Measurement
from oblique_impact.validation.comparison import compare
from oblique_impact.validation.comparison_report import comparison_data, comparison_document
from oblique_impact.validation.measuring import failed
from oblique_impact.validation.refinement.growth import Case, Predictability
from oblique_impact.validation.refinement.growth import judge as judge_shadows
from oblique_impact.validation.refinement.ladders import Ladder, Study
from oblique_impact.validation.refinement.predictability_report import write_predictability
from oblique_impact.validation.refinement.report import CSV_COLUMNS, csv_rows, study_data, study_document
from oblique_impact.validation.refinement.study import StudyResult, judge, plan_ladder
from oblique_impact.validation.report.document import render_html
from oblique_impact.validation.reproduction.claims import NOT, PARTLY, REPRODUCED, Claim, Finding, Judged
from oblique_impact.validation.reproduction.material import Material
from oblique_impact.validation.reproduction.tables import CLAIM_COLUMNS, claim_rows
from oblique_impact.validation.sweeps.plan import make_plan
from oblique_impact.validation.sweeps.report import sweep_document
from oblique_impact.validation.sweeps.table import make_table

from .test_comparison import event, made
from .test_predictability import row


def tables(page):
    """Tables of a page by their caption or first heading: the headings, and then the rows."""
    found = {}
    for text in re.findall(r"<table.*?</table>", page, re.DOTALL):
        rows = [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row) for row in re.findall(r"<tr.*?</tr>", text)]
        caption = re.search(r"<caption>(.*?)</caption>", text)
        found[caption[1].partition(";")[0].partition(":")[0] if caption else rows[0][0]] = [
            [html.unescape(cell) for cell in row] for row in rows
        ]
    return found


def test_validate(monkeypatch, tmp_path):
    """Two measurements of one check, of which the second fails by four tolerances."""
    measured = [
        Measurement("a length", 1.5, 1.25, "m", 0.5, "one source", "x"),
        Measurement("a count", 3.0, 7.0, "1", 1.0, "another source", "y"),
    ]
    check = Check("a.one", Group("a", "Group A"), "A problem.", 0.1, lambda: measured)
    monkeypatch.setattr(suite, "all_checks", lambda: {check.id: check})
    suite.validate(tmp_path, workers=1)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert tables(page) == {
        "Groups": [
            ["group", "--only", "checks", "measurements", "passed", "largest error/tolerance", "verdict"],
            ["Group A", "a", "1", "2", "1", "4", "✗ fail"],
        ],
        "id": [
            ["id", "quantity", "computed", "reference", "unit", "error", "tolerance", "verdict"],
            ["a.one.x", "a length", "1.5", "1.25", "m", "0.25", "0.5", "✓ pass"],
            ["a.one.y", "a count", "3", "7", "–", "4", "1", "✗ fail"],
        ],
    }
    assert "1 check, 2 measurements: 1 fail" in page
    assert json.loads((tmp_path / "results.json").read_text())["checks"][0] == {
        "id": "a.one.x",
        "group": "a",
        "problem": "A problem.",
        "quantity": "a length",
        "computed": 1.5,
        "reference": 1.25,
        "unit": "m",
        "error": 0.25,
        "tolerance": 0.5,
        "verdict": "pass",
        "source": "one source",
    }


LEVELS = (8.0, 16.0, 32.0, 64.0)


@pytest.fixture
def study():
    """Values 2 + 64/elements² of an impulse: order 2, the limit 2, the last difference -3/64."""
    plan = plan_ladder(Ladder("a ladder", "paper", (), "elements", LEVELS), quantities=["impulse"])
    rows = [
        failed(number, "completed", "")
        | {"values": {"impulse": 2.0 + 64.0 / level**2}, "stopped_at": 0.25, "energy": 3.0}
        | {"steps": 100 + number, "events": 7}
        for number, level in enumerate((*LEVELS, LEVELS[-1]))
    ]
    return StudyResult(Study("a study", "Title", "", ()), 1e-3, (judge(plan, rows, 1e-3),), 1.0)


def test_refine(study):
    text = render_html(study_document(study, "command"))
    # matplotlib draws letters as shapes and leaves the text in a comment
    for label in ("relative difference", "value / value at the finest level", "elements"):
        assert f"<!-- {label} -->" in text
    assert "uncertainty 0.02 N s, noise 3 × 10⁻¹³ N s, GCI of the last two levels alone 0.14 N s" in text
    page = tables(text)
    assert page["Verdicts"] == [
        ["ladder", "quantity", "finest value", "unit", "limit", "uncertainty", "verdict", "because"],
        [
            *("a ladder", "impulse", "2.016", "N s", "2", "0.02", "◐ converging in the mesh at order 2.00"),
            "the last two observed orders agree: 2.00, 2.00",
        ],
    ]
    assert page["Runs"][0] == ["elements", "h", "outcome", "ended at (s)", "steps", "events", ""]
    assert page["Runs"][-1] == ["64", "0.01562", "completed", "0.25", "103", "7", ""]
    heads, first, *_, last = page["impulse"]
    assert heads == [
        *("elements", "value (N s)", "difference (N s)", "observed order"),
        *("Richardson limit (N s)", "GCI (N s)"),
    ]
    assert first == ["8", "3", "–", "–", "–", "–"]
    assert last == ["64", "2.016", "−0.0469", "2", "2", "0.02"]  # 1.25 × (3/64)/(2² − 1)


@pytest.mark.parametrize(
    ("values", "tolerance", "verdict"),
    [
        ((3.0, 2.25, 2.0625), 0.1, "✓ converged in the mesh at order 2.00"),
        ((3.0, 2.25, 2.0625), 1e-3, "◐ converging in the mesh at order 2.00"),
        ((3.0, 4.0, 6.0), 1e-3, "✗ not converging"),
        ((3.0, 4.0, float("nan")), 1e-3, "no verdict"),
    ],
)
def test_refine_marks_its_verdicts(values, tolerance, verdict):
    """Differences of 3/4 and 3/16: order 2, of which the uncertainty is 1.25 (3/16)/3 = 0.08."""
    ladder = Ladder("a ladder", "paper", (), "elements", LEVELS[:3], declared={"impulse": 2.0})
    plan = plan_ladder(ladder, quantities=["impulse"])
    rows = [
        failed(number, "completed", "") | {"values": {"impulse": value}, "energy": 3.0}
        for number, value in enumerate((*values, values[-1]))
    ]
    found = StudyResult(Study("a study", "Title", "", ()), tolerance, (judge(plan, rows, tolerance),), 1.0)
    assert tables(render_html(study_document(found, "command")))["Verdicts"][1][6] == verdict


def test_refine_dims_what_lies_within_the_noise():
    """The tighter run changes the value by 0.25: differences of 0.75 and 0.1875 are below five times that."""
    plan = plan_ladder(Ladder("a ladder", "paper", (), "elements", LEVELS), quantities=["impulse"])
    values = (6.0, 3.0, 2.25, 2.0625)
    for change, kind in ((0.25, "dim"), (0.0, "number")):
        rows = [
            failed(number, "completed", "") | {"values": {"impulse": value}, "energy": 3.0}
            for number, value in enumerate((*values, values[-1] + change))
        ]
        result = StudyResult(Study("a study", "Title", "", ()), 1e-3, (judge(plan, rows, 1e-3),), 1.0)
        *_, last = study_document(result, "command").sections[0].blocks[-1].rows
        assert {cell.kind for cell in last[3:]} == {kind}


def test_refine_for_machines(study):
    last = dict(zip(CSV_COLUMNS, list(csv_rows(study))[-1], strict=True))
    assert last == {
        "ladder": "a ladder",
        "axis": "elements",
        "level": 64.0,
        "size": 1.0 / 64.0,
        "outcome": "completed",
        "quantity": "impulse",
        "unit": "N s",
        "value": 2.015625,
        "gap": "",
        "difference": -3.0 / 64.0,
        "observed_order": pytest.approx(2.0),
        "richardson_limit": pytest.approx(2.0),
        "grid_convergence_index": pytest.approx(1.25 / 64.0),
        "above_noise": "yes",
        "verdict": "converging in the mesh at order 2.00",
    }
    found = study_data(study, "command")["ladders"][0]["quantities"][0]
    assert (found["name"], found["unit"], found["values"][-1]) == ("impulse", "N s", 2.015625)
    assert found["differences"][-1] == -3.0 / 64.0
    for name, value in (
        ("observed_orders", 2.0),
        ("richardson_limits", 2.0),
        ("grid_convergence_indices", 1.25 / 64.0),
    ):
        assert found[name][-1] == pytest.approx(value), name
    assert found["two_level_index"] == pytest.approx(3.0 * 3.0 / 64.0)  # of order 1
    assert (found["order"], found["limit"]) == (pytest.approx(2.0), pytest.approx(2.0))
    assert found["uncertainty"] == pytest.approx(1.25 / 64.0)


@pytest.fixture
def comparison():
    """A jump by 2 m that comes 0.1 s later with half as much impulse again, in 2 s."""
    histories = []
    for at, impulse, energy in ((1.0, 2.0, 5.0), (1.1, 3.0, 4.0)):
        collision = {"start": at, "end": at, "contacts": 1, "normal_impulse": impulse}
        collision |= {"tangential_impulse": -impulse, "peak_force": 10.0 * impulse}
        history = made([0.0, at, at, 2.0], [0.0, 0.0, 2.0, 2.0], [event(at, impulse=impulse)])
        summary = history.summary | {"macro_collisions": [collision], "energy": {"final": energy}}
        histories.append(replace(history, summary=summary))
    return compare(*histories, names=("first", "second"))


def test_compare(comparison):
    page = render_html(comparison_document(comparison, "command"))
    events, measures = map(tables, page.split("Collisions and energies</h2>"))
    assert events["Differences relative to the scale, the range of the values"] == [
        [
            *("variable", "scale", "rms, same time", "largest", "at (s)", "rms, aligned", "largest", "at (s)"),
            "distance of curves",
        ],
        ["v", "2 m", "0.22", "−1", "1", "0", "0", "0", "0.05"],
    ]
    assert events[""] == [
        [
            *("", "event", "first: t (s)", "second: t (s)", "difference (s)"),
            *("first: impulse (N s)", "second: impulse (N s)"),
        ],
        ["1", "impact -> slip", "1.000000000", "1.100000000", "+1.0e-01", "2.00000000", "3.00000000"],
    ]
    assert measures[""][0] == ["", "unit", "first", "second", "difference"]
    assert measures[""][1:] == [
        ["collision 1: start", "s", "1", "1.1", "0.1"],
        ["collision 1: end", "s", "1", "1.1", "0.1"],
        ["collision 1: contacts", "1", "1", "1", "0"],
        ["collision 1: normal impulse", "N s", "2", "3", "1"],
        ["collision 1: tangential impulse", "N s", "−2", "−3", "−1"],
        ["collision 1: peak force", "N", "20", "30", "10"],
        ["energy: final", "J", "5", "4", "−1"],
        *(
            [f"energy: {name}", "J", "–", "–", "–"]
            for name in ("lost impact", "lost friction", "lost damping", "lost scheme")
        ),
    ]


def test_compare_for_machines(comparison):
    data = comparison_data(comparison, "command")
    assert data["events"] == [
        {
            "kind": "impact",
            "state": "slip",
            "left_time": 1.0,
            "right_time": 1.1,
            "time_difference": pytest.approx(0.1),
            "impulse_difference": 1.0,
        }
    ]
    peak = next(m for m in data["measures"] if m["name"] == "collision 1: peak force")
    assert peak == {
        "name": "collision 1: peak force",
        "unit": "N",
        "left": 20.0,
        "right": 30.0,
        "difference": 10.0,
    }
    assert f"contact states differ in {100.0 * comparison.state_disagreement:.2g} %" in str(comparison)


@pytest.fixture
def sweep():
    """Three runs over the angle, of which the last one is stopped by the physics."""
    plan = make_plan(
        'quantities = ["impulse"]\n[changes]\nend_time = 0.25\n'
        '[[axes]]\nkey = "initial.angle"\nvalues = [0.3, 0.1, 0.2]\n'
    )
    rows = [
        failed(number, "completed", "")
        | {"values": {"impulse": value}, "regime": "slip", "stopped_at": 0.25, "wall_time": wall}
        for number, (value, wall) in enumerate(((2.0, 1.0), (7.0, 2.0), (float("nan"), 6.0)))
    ]
    rows[-1] |= {"outcome": "painleve", "regime": "painleve", "message": "no solution", "stopped_at": 0.125}
    return plan, make_table(plan, rows)


def test_sweep(sweep):
    page = render_html(sweep_document(*sweep, "command"))
    found = tables(page)
    assert found["How the runs ended."] == [
        ["outcome", "first macro-collision", "runs"],
        ["completed", "slip", "2"],
        ["painleve", "painleve", "1"],
    ]
    assert found["What changes from run to run."] == [
        ["direction", "unit", "values", "from", "to"],
        ["initial.angle", "rad", "3", "0.1", "0.3"],
    ]
    assert found["What each run is asked for"] == [
        ["quantity", "meaning", "unit", "least", "largest", "missing"],
        ["impulse", "normal impulse of the first macro-collision", "N s", "2", "7", "1"],
    ]
    assert found["run"] == [["run", "outcome", "at (s)", "why"], ["2", "painleve", "0.125", "no solution"]]
    assert "<dd>end_time = 0.25</dd>" in page
    assert "9.0 s" in page
    assert "3.000 s in the mean, 6.000 s at most" in page


def test_sweep_for_machines(sweep):
    _, table = sweep
    units = {field.name: field.metadata[b"unit"].decode() for field in table.schema}
    assert {name: unit for name, unit in units.items() if unit not in ("", "1")} == {
        "initial.angle": "rad",
        "impulse": "N s",
        "stopped_at": "s",
        "wall_time": "s",
    }
    assert table["stopped_at"].to_pylist() == [0.25, 0.25, 0.125]
    assert table["impulse"].to_pylist() == [2.0, 7.0, None]


def test_reproduce():
    claim = Claim("an-id", "Sec. 1", "What the paper says.", "The rule.", lambda runs: None)
    findings = {"fixed-step": Finding(NOT, {}, "0.2"), "event": Finding(REPRODUCED, {}, "0.1")}
    (row,) = claim_rows(Material({}, {}, [Judged(claim, findings)], [], [], (0.0, [])))
    found = dict(zip(CLAIM_COLUMNS, row, strict=True))
    assert {name: found[name] for name in ("id", "place", "paper", "rule", "verdict")} == {
        "id": "an-id",
        "place": "Sec. 1",
        "paper": "What the paper says.",
        "rule": "The rule.",
        "verdict": PARTLY,
    }
    assert (found["verdict_fixed_step"], found["ours_fixed_step"]) == (NOT, "0.2")
    assert (found["verdict_event"], found["ours_event"]) == (REPRODUCED, "0.1")


@pytest.fixture
def shadowed():
    """A run with three macro-collisions and three shadows, of which the last one lacks the third collision."""
    rows = [
        row(0, (0.5, 1.0, 2.0), (1.0, 2.0, 4.0), (3.0, 5.0, 7.0)),
        row(1, (0.5, 1.0 - 2e-8, 2.0 + 1e-6), (1.5, 2.0, 4.0), (3.0, 6.0, 7.0)),
        row(2, (0.5, 1.0, 2.0), (1.0, 2.25, 4.0), (3.0, 4.0, 7.0)),
        row(3, (0.5, 1.0 + 3e-7), (1.0, 2.0), (3.0, 5.0)),
    ]
    case = Case("given", Scenario.builtin("paper"), "What it is.")
    found = judge_shadows(case, (1e-8, 1e-6), np.array([-1e-8, 1e-8, 1e-6]), rows)
    return Predictability("given", (found,), 9.0)


def test_predictability(shadowed, tmp_path):
    """A growth is the shift over that of the angle times the first touch, at 0.5 s."""
    page = write_predictability(tmp_path, shadowed, "command").read_text()
    found = tables(page)
    assert found["Verdicts, with the growth of the start of each macro-collision"] == [
        ["", "collision 1", "collision 2", "collision 3"],
        ["given", "✓ predictable, 0", "✓ predictable, 4", "✗ not predictable, ≥ 2 × 10⁶"],
    ]
    small, large = "by 1e-08 rad", "by 1e-06 rad"
    assert found["Macro-collisions, and how far the shadows move them"] == [
        [
            *("collision", "start (s)", f"{small} (s)", f"{large} (s)"),
            *("impulse (N s)", f"{small} (N s)", f"{large} (N s)", "contacts", "growth", "verdict"),
        ],
        ["1", "0.5", "0", "0", "1", "0.5", "0", "3", "0", "✓ predictable"],
        ["2", "1", "2 × 10⁻⁸", "3 × 10⁻⁷", "2", "0.25", "0", "4 to 6", "4", "✓ predictable"],
        ["3", "2", "1 × 10⁻⁶", "1", "4", "0", "–", "7", "≥ 2 × 10⁶", "✗ not predictable"],
    ]
    assert "What it is." in page
    assert "The last event that is predicted is at 1 s." in page
    assert "given: predictable, predictable, not predictable." in page
    assert "9.0 s" in page


def test_predictability_for_machines(shadowed, tmp_path):
    write_predictability(tmp_path, shadowed, "command")
    with (tmp_path / "results.csv").open() as file:
        rows = list(csv.DictReader(file))
    names = ("case", "collision", "start", "impulse", "fewest_contacts", "most_contacts", "lower_bound", "verdict")
    assert [[row[name] for name in names] for row in rows] == [
        ["given", "1", "0.5", "1.0", "3", "3", "False", "predictable"],
        ["given", "2", "1.0", "2.0", "4", "6", "False", "predictable"],
        ["given", "3", "2.0", "4.0", "7", "7", "True", "not predictable"],
    ]
    assert [float(row["growth"]) for row in rows] == pytest.approx([0.0, 4.0, 2e6])
    data = json.loads((tmp_path / "results.json").read_text())
    (case,) = data["cases"]
    assert (data["study"], data["command"], data["times"]) == ("given", "command", {"wall_time": 9.0})
    assert case["scenario"] == Scenario.builtin("paper").model_dump(mode="json")
    assert {
        name: case[name] for name in ("name", "perturbations", "offsets", "unit_time", "events", "horizon")
    } == {
        "name": "given",
        "perturbations": [1e-8, 1e-6],
        "offsets": [-1e-8, 1e-8, 1e-6],
        "unit_time": 0.5,
        "events": [0.5, 1.0, 2.0],
        "horizon": 1.0,
    }
    assert case["shadows"] == [[0.5, 1.0 - 2e-8, 2.0 + 1e-6], [0.5, 1.0, 2.0], [0.5, 1.0 + 3e-7, None]]
    assert case["growth"] == pytest.approx([0.0, 4.0, 2e6])
    last = case["collisions"][-1]
    assert last.pop("spread") == pytest.approx([1e-6, 1.0])
    assert last == {
        "number": 3,
        "start": 2.0,
        "impulse": 4.0,
        "contacts": [7, 7],
        "impulse_spread": [0.0, None],
        "growth": pytest.approx(2e6),
        "lower_bound": True,
        "verdict": "not predictable",
    }

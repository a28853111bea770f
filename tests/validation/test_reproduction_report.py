"""What a reader of the reproduction's page and files sees: each number in its column, counted, with its unit."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from oblique_impact import History, Scenario
from oblique_impact.history.summary import MacroCollision
from oblique_impact.progress import Progress
from oblique_impact.validation.report.document import Picture, Table, Text
from oblique_impact.validation.reproduction import command, unsaid
from oblique_impact.validation.reproduction.cases import SCHEMES as SCHEME_NAMES
from oblique_impact.validation.reproduction.cases import (
    Case,
    Combination,
    Variant,
    combinations,
    main_cases,
    paper,
    sticking_cases,
    threshold_cases,
    variant_cases,
)
from oblique_impact.validation.reproduction.claims import NOT, PARTLY, REPRODUCED, Claim, Claims, Finding, Judged
from oblique_impact.validation.reproduction.command import (
    Reproduction,
    collect,
    draw_all,
    lines,
    reproduce,
    write_all,
)
from oblique_impact.validation.reproduction.material import Material
from oblique_impact.validation.reproduction.measures import Trio
from oblique_impact.validation.reproduction.pages import document
from oblique_impact.validation.reproduction.pictures import PLOTS
from oblique_impact.validation.reproduction.runs import Run, run_case
from oblique_impact.validation.reproduction.stick_pages import STICKING, why
from oblique_impact.validation.reproduction.sticking import StickCheck
from oblique_impact.validation.reproduction.tables import CLAIM_COLUMNS, claim_rows, results
from oblique_impact.validation.reproduction.unsaid import Robustness, Studied, judge_combination

from .test_reproduction import event, made

NAN, INF = float("nan"), float("inf")
PAPER = Scenario.builtin("paper")
FIRST = MacroCollision(0.30, 0.34, 3, 1.5, -0.25, 110.0)
SECOND = MacroCollision(0.68, 0.71, 4, 0.75, 0.125, 55.0)
LEDGER = {
    "initial": 3.0,
    "final": 2.0,
    "kinetic": 9.0,
    "lost_impact": 0.5,
    "lost_friction": 0.25,
    "lost_scheme": -0.125,
    "unaccounted": 1e-12,
}
EVENTS = [
    event(0.30, "impact", "SLIP"),
    event(0.31, "reversal", "SLIP"),
    event(0.32, "stick", "STICK", -0.04),
    event(0.3202, "slip", "SLIP"),
    event(0.327, "reversal", "SLIP"),
    event(0.33, "stick", "STICK", 0.02),
    event(0.3303, "slip", "SLIP"),
    event(0.34, "release", "FREE"),
    event(0.68, "impact", "SLIP"),
    event(0.69, "reversal", "SLIP"),
    event(0.70, "reversal", "SLIP"),
    event(0.71, "release", "FREE"),
]


def ran(key="made", macros=(FIRST, SECOND), events=EVENTS, checks=(), scenario=PAPER, ledger=LEDGER, **arrays):
    """A run made by hand, with all that its history tells."""
    summary = {"outcome": "completed", "energy": ledger, "macro_collisions": [vars(macro) for macro in macros]}
    return Run(key, History(made(**arrays).history.data, list(events), summary, scenario), list(checks))


def check(time, kind="reversal", slip_rate=0.0, judged=False):
    """Sticking solution whose numbers differ from column to column; it pulls, if asked, as the scheme judges."""
    return StickCheck(time, kind, slip_rate, 2.0, -21.0, -8.0 if judged else 4.0, 48.0, 10.7)


LOCATED = [check(0.31), check(0.327)._replace(tangential=40.0), check(0.5)._replace(normal=-1.0)]
#: more than the page shows: the first of a stay of 200 µs
PRINTED = [check(0.32, "stick", -0.04), *(check(0.4 + k / 1000.0, judged=True) for k in range(22))]
RUNS = {
    "paper/event/hybrid": ran("paper/event/hybrid", checks=LOCATED),
    "paper/fixed-step/hybrid": ran("paper/fixed-step/hybrid", checks=PRINTED, scenario=paper("fixed-step")),
    "no-shortening/fixed-step/hybrid": ran(
        "no-shortening/fixed-step/hybrid",
        events=[event(0.3, "stick", "STICK", 0.5), event(0.3007, "slip", "SLIP"), event(0.34, "release", "FREE")],
        scenario=paper("fixed-step", contact__shortening=False),
    ),
    "sticking/event/hybrid": ran(scenario=Scenario.builtin("sticking"), checks=[check(0.3, "stick")]),
    "rough/event/hybrid": ran(),
}
SCHEMES = ("fixed-step", "event")
MODELS = ("hybrid", "frictionless", "modified-coulomb")


def numbered(n):
    """A run all of whose tabled numbers are its own."""
    macro = MacroCollision(0.3 + n / 100.0, 0.34 + n / 100.0, 2 + n, 1.5 + n, 0.25 + n, 100.0 + n)
    return ran(macros=(macro, replace(SECOND, contacts=90 + n)), ledger={**LEDGER, "final": 2.0 + n})


TRIOS = {scheme: Trio(*(numbered(3 * k + m) for m in range(3))) for k, scheme in enumerate(SCHEMES)}
FINDINGS = {
    "one": (Finding(REPRODUCED, {"x": 1.0}, "f1"), Finding(REPRODUCED, {"x": 2.0}, "e1")),
    "two": (Finding(NOT, {"y": 3.0}, "f2"), Finding(PARTLY, {"y": 4.0}, "e2")),
    "three": (Finding(NOT, {}, "f3"), Finding(NOT, {}, "e3")),
}
JUDGED = [
    Judged(
        Claim(name, f"Fig. {name}", f"Statement {name}.", f"Rule {name}.", None),
        dict(zip(SCHEMES, found, strict=True)),
    )
    for name, found in FINDINGS.items()
]
SECONDS = (  # first touch and last release of the second macro-collision; start and length of the longest stick
    (NAN, NAN, NAN, 0.0),
    (0.60, 0.698, NAN, 0.0),
    (0.68, 0.70, 0.69, 2e-4),
    (0.6985, 0.71, 0.7001, 1.5e-4),
    (0.705, 0.72, 0.71, 9e-5),
    (0.60, 0.65, 0.61, 5e-5),
)
GRID = [
    Robustness(
        Combination("event", 1 + k, 9.81, k % 2 == 0, "plain"), {"one": REPRODUCED, "two": verdict}, ("x",), second
    )
    for k, (verdict, second) in enumerate(zip([REPRODUCED, PARTLY, PARTLY, NOT, NOT, NOT], SECONDS, strict=True))
]


def studied(choice, label, assumed, scheme, impulse, second=0.68):
    macros = [replace(FIRST, normal_impulse=impulse), *([replace(SECOND, start=second)] if second else [])]
    return Studied(Variant(choice, label, assumed), scheme, ran(macros=macros))


STUDIED = [
    studied("kind of beam", "a", True, "fixed-step", 1.5),
    studied("kind of beam", "a", True, "event", 1.25),
    studied("kind of beam", "b", False, "fixed-step", 1.75, 0.69),
    studied("kind of beam", "b", False, "event", 1.125, None),
    studied("integrator", "c", True, "fixed-step", 1.5),
]
THRESHOLD = (10.5, [(10.487, "reversal at 0.31 s"), (10.513, "stick at 0.31 s")])
MATERIAL = Material(TRIOS, RUNS, JUDGED, STUDIED, GRID, THRESHOLD)
NAMES = [*(plot.name for plot in PLOTS), "choices", "robustness", *(f"sticking-{name}" for name in STICKING)]
PICTURES = {name: f"<svg>{name}</svg>" for name in NAMES}


@pytest.fixture(scope="module")
def parts():
    """Blocks of each section of the page."""
    page = document(MATERIAL, PICTURES, [("wall time", "1 s")])
    return {"overview": page.overview, **{section.title: section.blocks for section in page.sections}}


def texts(blocks):
    return [block.text for block in blocks if isinstance(block, Text)]


def tables(blocks):
    """Captions of tables, and under them the headings and the rows."""
    return {
        block.caption: [
            list(block.columns),
            *([cell.text.replace("\u00a0", " ") for cell in row] for row in block.cells()),
        ]
        for block in blocks
        if isinstance(block, Table)
    }


# --- the page ---------------------------------------------------------------------------------------------


def test_the_overview_counts_verdicts(parts):
    counted, same, missed, _ = texts(parts["overview"])
    assert counted == "3 claims: 1 reproduced, 1 partly, 1 not reproduced."
    assert same.startswith("1 of them, marked =, do not discriminate: they are reproduced by all 6 combinations")
    assert missed == "Not reproduced: Statement three."


def test_claims_stand_with_what_each_scheme_found(parts):
    (table,) = (block for block in parts["Claims"])
    ((_, *rows),) = tables([table]).values()
    heads = ["", "the paper says", "fixed-step, as printed", "event-located", "rule", "verdict", "all choices"]
    assert table.columns == heads
    assert rows == [
        ["1", "Statement one. (Fig. one)", "✓ f1", "✓ e1", "Rule one.", "reproduced", "= 6 / 0 / 0"],
        ["2", "Statement two. (Fig. two)", "✗ f2", "◐ e2", "Rule two.", "partly", "1 / 2 / 3"],
        ["3", "Statement three. (Fig. three)", "✗ f3", "✗ e3", "Rule three.", "not reproduced", "–"],
    ]
    assert [row[5].mark for row in table.cells()] == ["✓", "◐", "✗"]


def test_every_figure_has_its_picture_and_caption(parts):
    shown = [block for block in parts["Figures 2 to 16"] if isinstance(block, Picture)]
    assert [picture.svg for picture in shown] == [PICTURES[plot.name] for plot in PLOTS]
    for plot, picture in zip(PLOTS, shown, strict=True):
        assert picture.caption.startswith(f"Fig. {plot.number}. {plot.title} ({plot.unit}).")
        assert picture.alternative.startswith(f"{plot.title} of the three models")
        assert ("Impulses" in picture.caption) == (plot.variable in ("lambda_n", "lambda_tau"))
        assert ("table of runs" in picture.caption) == (plot.variable == "lambda_n")
        assert ("floating axes OXY" in picture.caption) == (plot.number == "10")
        assert ("foreshortening" in picture.caption) == (plot.number == "10f")
        assert ("along the slope, measured from O₁" in picture.caption) == (plot.variable == "slip")


def test_a_choice_is_told_in_numbers_and_in_a_table(parts):
    blocks = parts["What the paper leaves unsaid"]
    assert blocks[1].svg == PICTURES["choices"]
    assert texts(blocks)[1:] == [
        "Kind of beam. fixed-step: impulse of the first collision 1.5 to 1.75 N s, second collision from 0.6800 s "
        "to 0.6900 s; event: impulse of the first collision 1.125 to 1.25 N s, second collision from 0.6800 s to "
        "0.6800 s.",
        "Integrator. ",
    ]
    each = ["from (s)", "to (s)", "impulse (N s)", "reversal (s)", "stick (µs)"]
    first, none = ["0.3270", "500"], ["–", "–", "–", "–", "0"]
    found = tables(blocks)
    assert found.pop("Integrator; hybrid model; 1, 2: macro-collisions")[1][:2] == ["c *", "fixed-step"]
    assert found == {
        "Kind of beam; hybrid model; 1, 2: macro-collisions": [
            ["value", "scheme", *(f"{k}: {name}" for k in (1, 2) for name in each)],
            ["a *", "fixed-step", "0.3000", "0.3400", "1.5", *first, "0.6800", "0.7100", "0.75", "0.6900", "0"],
            ["a *", "event", "0.3000", "0.3400", "1.25", *first, "0.6800", "0.7100", "0.75", "0.6900", "0"],
            ["b", "fixed-step", "0.3000", "0.3400", "1.75", *first, "0.6900", "0.7100", "0.75", "0.6900", "0"],
            ["b", "event", "0.3000", "0.3400", "1.125", *first, *none],
        ]
    }


def test_combinations_are_counted_and_the_nearest_is_named(parts):
    text, picture = parts["All open choices at once"]
    assert picture.svg == PICTURES["robustness"]
    assert text.text.startswith("6 combinations: ")
    assert text.text.endswith(
        "In 2 of them the second macro-collision is under way at 0.699 s (nearest: event, 3 modes, g = 9.81, "
        "with shortening, Baumgarte plain, 0.6800 s to 0.7000 s); stays judged as stick of 0.1 ms or more occur "
        "in it in 2 of the combinations, the latest from 0.7001 s."
    )


def robust(*seconds):
    grid = [replaced._replace(second=second) for replaced, second in zip(GRID, seconds, strict=False)]
    page = document(replace(MATERIAL, grid=grid), PICTURES, [])
    return texts(page.sections[3].blocks)[0]


def test_the_nearest_combination_on_either_side():
    """The second begins 6 ms late, the third ends 5 ms early; the first has no second collision."""
    text = robust(SECONDS[0], (0.705, 0.72, NAN, 0.0), (0.6, 0.694, NAN, 0.0))
    assert "In 0 of them" in text
    assert "(nearest: event, 3 modes" in text
    assert text.endswith("occur in it in 0 of the combinations.")


def test_runs_stand_in_the_table_with_their_model_and_scheme(parts):
    collisions, ledger = tables(parts["The runs"]).values()
    heads = ["run", "no.", "from (s)", "to (s)", "contacts", "normal (N s)", "friction (N s)", "peak (N)"]
    assert collisions[0] == heads
    names = [f"{model}, {scheme}" for scheme in SCHEMES for model in MODELS]
    for n, name in enumerate(names):
        first, second = collisions[1 + 2 * n], collisions[2 + 2 * n]
        assert first == [
            *(name, "1", f"0.3{n}0000", f"0.3{4 + n}0000", str(2 + n)),
            *(f"{1.5 + n:g}", f"{0.25 + n:g}", f"{100 + n}"),
        ]
        assert second == [name, "2", "0.680000", "0.710000", str(90 + n), "0.75", "0.125", "55"]
    heads = ["run", "initial", "final", "lost impact", "lost friction", "lost scheme", "unaccounted"]
    rows = [[name, "3", f"{2 + n}", "0.5", "0.25", "−0.125", "1 × 10⁻¹²"] for n, name in enumerate(names)]
    assert ledger == [heads, *rows]


def test_what_is_assumed_is_what_is_simulated():
    """What the page says of steps, Baumgarte's parameters, modes and gravity, from the paper's scenario."""
    facts = dict(document(MATERIAL, PICTURES, []).facts)
    ours = paper("fixed-step")
    v, low = ours.solver, ours.contact.regularization
    steps = f"RK4, {1e3 * v.free_step:g} ms in flight and {1e6 * v.contact_step:g} µs in contact"
    judged = f"Baumgarte {v.baumgarte[0]:g} and {v.baumgarte[1]:g}, stick judged at each step"
    assert facts["as printed"] == f"{steps}, {judged}"
    assert (ours.discretization.modes, ours.contact.point, ours.beam.length) == (2, 1.0, 1.0)
    assert facts["assumed (*)"] == (
        f"two clamped modes, x_F = L, g = {ours.gravity} m/s², Z'' + 2χZ' + β²Z = 0, "
        f"v₀, v₁ = {low[0]:g}, {low[1]:g} m/s"
    )
    assert (v.baumgarte_form, v.stick) == ("squared", "force")


# --- stick ------------------------------------------------------------------------------------------------


def test_why_the_tip_cannot_stick_is_told_in_numbers(parts):
    _, jam, tried, judged = texts(parts["Stick: where it can and cannot occur"])
    assert "of about cot|b|, here 10.7; where slip reverses, the flexible beam asks for 10.5 to 20, or" in jam
    assert "against μ = 0.3." in jam
    assert "the first reversal of the event-located run asks for 10.5." in tried
    assert tried.endswith("gives: μ_s = 10.487: reversal at 0.31 s; μ_s = 10.513: stick at 0.31 s.")
    assert "up to 40 mm/s as a stay judged stick begins, and at up to 500 mm/s if the contact point's" in judged
    assert judged.endswith("the longest stays last 300 µs and 700 µs.")


def test_sticking_solutions_of_both_schemes(parts):
    found = tables(parts["Stick: where it can and cannot occur"])
    heads = ["t (s)", "what happens", "slip velocity (mm/s)", "λn to stick (N)", "λτ to stick (N)", "|λτ|/λn"]
    heads += ["cot|b|", "μ_s", "lasts (µs)", "why"]
    assert found["The paper's case, event-located"] == [
        heads,
        ["0.310000", "reversal", "0", "2", "−21", "10.5", "10.7", "0.3", "–", "cannot: 10.5 > 0.3"],
        ["0.327000", "reversal", "0", "2", "40", "20", "10.7", "0.3", "–", "cannot: 20 > 0.3"],
        ["0.500000", "reversal", "0", "−1", "−21", "pulls", "10.7", "0.3", "–", why(LOCATED[2], INF, 0.3)],
    ]
    terms = "Baumgarte's terms included, as the scheme judges"
    printed = found[f"The paper's case, as printed; {terms} (3 more in results.json)"]
    assert len(printed) == 1 + 20
    assert printed[1] == [
        *("0.320000", "stick", "−40", "4", "48", "12", "10.7", "0.3", "200"),
        "judged stick by the forces, although the tip moves at 40 mm/s",
    ]
    assert printed[2][:8] == ["0.400000", "reversal", "0", "−8", "48", "pulls", "10.7", "0.3"]
    assert f"As printed, without the contact point's shortening; {terms}" in found
    stuck = found["Scenario sticking, event-located"][1]
    assert stuck[5:] == ["10.5", "10.7", "2", "–", "sticks: slip velocity 0 and 10.5 ≤ 2"]


def test_reasons_have_the_numbers_that_they_compare():
    assert why(check(0.3), 0.2, 0.3).startswith("inside the cone")
    assert why(check(0.3, "stick", 1e-5), 0.2, 0.3).endswith("moves at 0.01 mm/s")
    assert why(check(0.3, "stick", 1e-7), 0.2, 0.3) == "sticks: slip velocity 0 and 0.2 ≤ 0.3"


def test_a_picture_of_stick_has_its_caption(parts):
    shown = [block for block in parts["Stick: where it can and cannot occur"] if isinstance(block, Picture)]
    words = {
        "event": "Event-located: ",
        "fixed-step": "As printed: ",
        "no-shortening": "shortening left out",
        "sticking": "scenario sticking",
        "rough": "μ = 12",
    }
    assert [picture.svg for picture in shown] == [PICTURES[f"sticking-{name}"] for name in words]
    assert all(word in picture.caption for word, picture in zip(words.values(), shown, strict=True))


# --- tables for machines ----------------------------------------------------------------------------------


COLLISION = (
    *("start", "end", "contacts", "normal_impulse", "tangential_impulse", "peak_force", "reversals", "reversal"),
    *("sticks", "stick_time", "longest_stick_start", "energy_left"),
)


def test_a_line_of_the_study_by_its_names():
    """The reversal nearest to 0.325 s, and the first of the second macro-collision; the energy of the flights."""
    run = ran(scenario=PAPER.replace(contact__friction="modified-coulomb"), energy=lambda t: 3.0 - 2.0 * t)
    row = Studied(Variant("a choice", "a value", True), "event", run).flat()
    names = ["choice", "variant", "assumed", "scheme", "model", "outcome"]
    assert list(row) == [*names, *(f"{k}_{name}" for k in ("first", "second") for name in COLLISION)]
    values = list(row.values())
    assert values[:6] == ["a choice", "a value", True, "event", "modified-coulomb", "completed"]
    first = [0.30, 0.34, 3, 1.5, -0.25, 110.0, 2, 0.327, 2, 5e-4, 0.33, 1.98]
    second = [0.68, 0.71, 4, 0.75, 0.125, 55.0, 2, 0.69, 0, 0.0, NAN, 1.29]
    assert values[6:] == pytest.approx([*first, *second], nan_ok=True)


def test_results_hold_what_the_page_shows():
    data = results(MATERIAL, [{"figure": "2"}])
    assert data["figures"] == [{"figure": "2"}]
    assert data["claims"][1] == {
        "id": "two",
        "place": "Fig. two",
        "paper": "Statement two.",
        "rule": "Rule two.",
        "verdict": "partly",
        "schemes": {
            "fixed-step": {"verdict": "not reproduced", "ours": "f2", "numbers": {"y": 3.0}},
            "event": {"verdict": "partly", "ours": "e2", "numbers": {"y": 4.0}},
        },
        "combinations": {"reproduced": 1, "partly": 2, "not reproduced": 3},
        "discriminates": True,
        "ours": "fixed-step: f2; event: e2",
        "number": {"fixed-step": {"y": 3.0}, "event": {"y": 4.0}},
    }
    assert [claim["discriminates"] for claim in data["claims"]] == [False, True, True]
    assert data["claims"][2]["combinations"] is None
    assert data["combinations"][2] == {
        "scheme": "event",
        "modes": 3,
        "gravity": 9.81,
        "shortening": True,
        "baumgarte_form": "plain",
        "outcomes": ["x"],
        "second_start": 0.68,
        "second_end": 0.70,
        "longest_stick_start": 0.69,
        "longest_stick": 2e-4,
        "verdicts": {"one": REPRODUCED, "two": PARTLY},
    }
    assert data["sensitivity"] == [item.flat() for item in STUDIED]
    assert data["stick_threshold"] == {
        "ratio": 10.5,
        "tried": [
            {"mu_static": 10.487, "happened": "reversal at 0.31 s"},
            {"mu_static": 10.513, "happened": "stick at 0.31 s"},
        ],
    }


def test_results_hold_every_run_and_every_sticking_solution():
    data = results(MATERIAL, [])
    assert data["runs"].keys() == RUNS.keys()
    run = data["runs"]["paper/fixed-step/hybrid"]
    assert run["outcome"] == "completed"
    assert run["energy"] == LEDGER
    assert run["macro_collisions"] == [vars(FIRST), vars(SECOND)]
    keys = ("start", "end", "slip_rate", "duration")
    found = [[stick[key] for key in keys] for stick in run["sticks"]]
    assert found == [pytest.approx([0.32, 0.3202, -0.04, 2e-4]), pytest.approx([0.33, 0.3303, 0.02, 3e-4])]
    assert Scenario.model_validate(run["scenario"]) == paper("fixed-step")
    assert {key: len(checks) for key, checks in data["stick"].items()} == {
        "paper/event/hybrid": 3,
        "paper/fixed-step/hybrid": 23,
        "sticking/event/hybrid": 1,
    }
    solution = data["stick"]["paper/fixed-step/hybrid"][0]
    assert solution == {**LOCATED[0]._asdict(), "time": 0.32, "kind": "stick", "slip_rate": -0.04} | {
        "ratio": 10.5,
        "judged_ratio": 12.0,
    }


def test_columns_of_the_claims():
    one, two, three = (dict(zip(CLAIM_COLUMNS, row, strict=True)) for row in claim_rows(MATERIAL))
    counts = ("combinations_reproduced", "combinations_partly", "combinations_not_reproduced", "discriminates")
    assert [two[name] for name in counts] == [1, 2, 3, True]
    assert [one[name] for name in counts] == [6, 0, 0, False]
    assert [three[name] for name in counts] == ["", "", "", True]


# --- the command ------------------------------------------------------------------------------------------


def test_files_have_the_columns_of_what_they_hold(tmp_path, monkeypatch):
    rows = [{"figure": "2", "mean": 0.5}, {"figure": "3", "mean": 0.25}]
    monkeypatch.setattr(command, "PLOTS", rows)
    monkeypatch.setattr(command, "summary", lambda plot, trios: [plot] if trios is TRIOS else [])
    (tmp_path / "figures").mkdir()
    write_all(tmp_path, MATERIAL, PICTURES, [("wall time", "1 s")])
    data = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    tables = {}
    for name in ("claims", "sensitivity", "figures"):
        with (tmp_path / f"{name}.csv").open(encoding="utf-8") as file:
            tables[name] = list(csv.DictReader(file))
    assert tables["figures"] == [{"figure": "2", "mean": "0.5"}, {"figure": "3", "mean": "0.25"}]
    assert data["figures"] == rows
    assert [row["first_normal_impulse"] for row in tables["sensitivity"]] == [
        "1.5",
        "1.25",
        "1.75",
        "1.125",
        "1.5",
    ]
    assert [row["second_start"] for row in tables["sensitivity"]] == ["0.68", "0.68", "0.69", "", "0.68"]
    assert [row["verdict"] for row in tables["claims"]] == [REPRODUCED, PARTLY, NOT]
    drawn = {path.stem: path.read_text(encoding="utf-8") for path in (tmp_path / "figures").iterdir()}
    assert drawn == PICTURES


def test_lines_for_a_terminal(tmp_path):
    assert lines(Reproduction(MATERIAL, 1.0, tmp_path)) == [
        "  reproduced      one",
        "  partly          two",
        "  not reproduced  three",
        "3 claims: 1 reproduced, 1 partly, 1 not reproduced; 1 of them reproduced by all combinations of what the "
        f"paper leaves open; report: {tmp_path}",
    ]


def test_the_report_names_its_call(tmp_path, monkeypatch):
    written = []
    monkeypatch.setattr(command, "collect", lambda workers, on_progress: MATERIAL)
    monkeypatch.setattr(command, "draw_all", lambda material: PICTURES)
    monkeypatch.setattr(command, "write_all", lambda *given: written.append(given))
    found = reproduce(tmp_path / "out", workers=3, command="typed")
    assert found.report == tmp_path / "out" / "report.html"
    ((_, material, pictures, times),) = written
    assert (material, pictures) == (MATERIAL, PICTURES)
    names, values = zip(*times, strict=True)
    assert names == ("command", "simulations", "figures")
    assert values[0] == "typed"
    assert all(float(value.removesuffix(" s")) < 60.0 for value in values[1:])


def test_every_picture_is_drawn_of_its_runs(monkeypatch):
    monkeypatch.setattr(command, "draw", lambda plot, trios: (plot, trios))
    monkeypatch.setattr(command, "choices_diagram", lambda studied: studied)
    monkeypatch.setattr(command, "robustness_diagram", lambda material: material)
    monkeypatch.setattr(command, "sticking_diagram", lambda *given: given)
    drawn = draw_all(MATERIAL)
    assert list(drawn) == NAMES
    assert all(drawn[plot.name] == (plot, TRIOS) for plot in PLOTS)
    assert drawn["choices"] is STUDIED
    assert drawn["robustness"] is MATERIAL
    shown = {name: drawn[f"sticking-{name}"] for name in STICKING}
    assert {name: len(windows) for name, (_, windows, _) in shown.items()} == {
        "event": 2,
        "fixed-step": 2,
        "no-shortening": 2,
        "sticking": 1,
        "rough": 1,
    }
    assert [run for run, _, _ in shown.values()] == list(RUNS.values())
    titles = [title for _, _, title in shown.values()]
    words = ["case, event-located", "as printed", "shortening", "sticking", "μ = 12"]
    assert all(word in title for word, title in zip(words, titles, strict=True))
    # the first 30 ms of each macro-collision, and 220 ms of the tip that stays
    for run, windows, _ in shown.values():
        for macro, (start, end) in zip(run.macros, windows, strict=False):
            assert start < macro.start < end
            assert end - start == pytest.approx(0.22 if len(windows) == 1 and end > 0.4 else 0.0314)


def trio_keys(trio):
    return Finding(REPRODUCED, {}, " ".join(run.key for run in trio))


def test_each_claim_is_judged_on_the_runs_that_it_names(monkeypatch):
    """Simulations that are named and not run: what is collected, of which runs, told in which order."""
    claims = Claims()
    for case in ("paper", "sticking", "rough"):
        claims.add(case, "Sec. 1", "A statement.", "A rule.", case)(trio_keys)
    reversals = {1.0: 0.3, 0.999: 0.31, 1.001: 0.32}

    def simulated(case):
        factor = case.scenario.contact.mu_static / 10.5 if case.key.startswith("threshold") else 1.0
        near = reversals[round(factor, 4)]
        kind = "stick" if near == 0.32 else "reversal"
        return ran(case.key, checks=[check(0.1, "stick"), check(near, kind), check(0.6)])

    point = GRID[0]
    told = []
    monkeypatch.setattr(command, "ALL_CLAIMS", claims)
    monkeypatch.setattr(command, "run_case", simulated)
    monkeypatch.setattr(command, "judge_combination", lambda combination: point._replace(combination=combination))
    monkeypatch.setattr(command, "combinations", lambda: combinations()[:2])
    monkeypatch.setattr(command, "variant_cases", lambda: list(variant_cases())[:3])
    material = collect(1, told.append)
    keys = ["paper/{0}/hybrid paper/{0}/frictionless paper/{0}/modified-coulomb"]
    keys += [
        f"{case}/{{0}}/hybrid {case}/{{0}}/hybrid {case}/{{0}}/modified-coulomb" for case in ("sticking", "rough")
    ]
    for judged, text in zip(material.judged, keys, strict=True):
        assert {scheme: found.text for scheme, found in judged.findings.items()} == {
            scheme: text.format(scheme) for scheme in SCHEMES
        }
    assert [run.key for trio in material.trios.values() for run in trio] == [case.key for case in main_cases()]
    assert material.runs.keys() == {case.key for case in (*main_cases(), *sticking_cases())}
    assert [(item.variant, item.scheme, item.run.key) for item in material.studied] == [
        (variant, scheme, case.key) for variant, scheme, case in list(variant_cases())[:3]
    ]
    assert [found.combination for found in material.grid] == combinations()[:2]
    assert material.threshold == (
        10.5,
        [
            (pytest.approx(10.4895), "reversal at 0.310000 s"),
            (pytest.approx(10.5105), "stick at 0.320000 s"),
        ],
    )
    assert told[0] == Progress(0, len(told) - 1)
    assert [progress.last for progress in told[-2:]] == [found.label for found in combinations()[:2]]


def test_a_combination_is_judged_by_its_three_models(monkeypatch):
    claims = [Claim(case, "", "", "", trio_keys, case) for case in ("paper", "rough")]
    seen = []

    def simulated(case):
        seen.append(case.scenario)
        hybrid = case.scenario.contact.friction == "hybrid"
        return ran(case.key, (FIRST, replace(SECOND, start=0.3, end=0.34)) if hybrid else (FIRST,))

    monkeypatch.setattr(unsaid, "ALL_CLAIMS", claims)
    monkeypatch.setattr(unsaid, "run_case", simulated)
    combination = Combination("fixed-step", 3, 9.81, False, "plain")
    found = judge_combination(combination)
    assert [scenario.contact.friction for scenario in seen] == ["hybrid", "frictionless", "modified-coulomb"]
    assert {(s.discretization.modes, s.gravity, s.contact.shortening) for s in seen} == {(3, 9.81, False)}
    assert {(s.solver.scheme, s.solver.baumgarte_form) for s in seen} == {("fixed-step", "plain")}
    assert found.verdicts == {"paper": REPRODUCED}
    assert found.outcomes == ("completed",) * 3
    assert found.second == pytest.approx((0.3, 0.34, 0.33, 3e-4))
    label = "fixed-step, 3 modes, g = 9.81, without shortening, Baumgarte plain"
    assert combination.label == label


# --- what is simulated ------------------------------------------------------------------------------------


def test_a_case_is_named_after_what_it_simulates():
    for case in main_cases():
        group, scheme, model = case.key.split("/")
        ours = case.scenario
        assert (group, scheme, model) == ("paper", ours.solver.scheme, ours.contact.friction)
        assert case.sticking == (model == "hybrid")
        assert ours.replace(contact__friction="hybrid", solver=PAPER.solver) == PAPER
    for case in sticking_cases():
        group, scheme, model = case.key.split("/")
        contact = case.scenario.contact
        assert (scheme, model) == (case.scenario.solver.scheme, contact.friction)
        assert contact.mu_static == contact.mu_kinetic == 12.0 or group != "rough"
        assert contact.shortening == (group != "no-shortening")
        assert (case.scenario.slope == PAPER.slope) == (group != "sticking")


def flat(values, prefix=""):
    """Values of a scenario by their dotted keys."""
    found = {}
    for key, value in values.items():
        found |= flat(value, f"{prefix}{key}.") if isinstance(value, dict) else {f"{prefix}{key}": value}
    return found


VARIED = {
    **{f"{n} clamped": f"modes={n}" for n in (1, 3, 4)},
    "2 clamped": "",
    "2 clamped, tangent frame": "",
    "2 hinged, mean-axis frame": "frame=mean-axis",
    **{f"{n} hinged, mean-axis frame": f"frame=mean-axis modes={n}" for n in (3, 4, 8)},
    "x_F = 1.0 m": "",
    **{f"x_F = {x} m": f"point={x}" for x in (0.95, 0.9, 0.8)},
    "9.8 m/s²": "",
    **{f"{g} m/s²": f"gravity={g}" for g in (9.80665, 9.81, 10.0)},
    "Z'' + 2χZ' + β²Z = 0": "",
    "Z'' + χZ' + βZ = 0": "baumgarte_form=plain",
    "v₀ = 0.001, v₁ = 0.01 m/s": "friction=modified-coulomb",
    "v₀ = 0, v₁ = 0.01 m/s": "friction=modified-coulomb regularization=(0.0, 0.01)",
    "v₀ = 1e-05, v₁ = 0.0001 m/s": "friction=modified-coulomb regularization=(1e-05, 0.0001)",
    "v₀ = 0.01, v₁ = 0.1 m/s": "friction=modified-coulomb regularization=(0.01, 0.1)",
    "by the force that would hold the contact (Sec. 5.3)": "",
    "and by the slip, which must end within the step": "stick=arrest",
    "in gap and slip": "",
    "left out of both": "shortening=False",
    "RK4, 0.1 ms and 1 µs": "",
    "RK4, 10 µs and 1 µs": "free_step=1e-05",
    "RK4, 1 µs always": "free_step=1e-06",
    "generalized-α, ρ∞ = 0.8": "scheme=generalized-alpha",
    "order 8, event-located": "scheme=event",
}


@pytest.mark.parametrize("scheme", ["fixed-step", "event"])
def test_a_variant_changes_what_its_label_says(scheme):
    printed = flat(PAPER.replace(solver__scheme=scheme, solver__stick="force").model_dump())
    for variant, name, case in variant_cases():
        if name != scheme and (variant.choice != "integrator" or scheme == "event"):
            continue
        values = flat(case.scenario.model_dump())
        changes = {key.split(".")[-1]: value for key, value in values.items() if value != printed[key]}
        if variant.choice == "integrator" and scheme == "event":
            changes |= {"scheme": "event"}
        found = " ".join(f"{key}={value}" for key, value in sorted(changes.items()))
        assert found == VARIED[variant.label], variant
        assert values["solver.scheme"] == name


def test_labels_name_schemes_and_models():
    assert SCHEME_NAMES == {"fixed-step": "fixed-step, as printed", "event": "event-located"}
    assert [(c.key, c.scenario.contact.mu_static) for c in threshold_cases(10.0)] == [
        ("threshold/0.999", pytest.approx(9.99)),
        ("threshold/1.001", pytest.approx(10.01)),
    ]
    for case in threshold_cases(10.0):
        assert (case.sticking, case.scenario.contact.mu_kinetic) == (True, 0.3)


# --- a run ------------------------------------------------------------------------------------------------


def test_a_run_keeps_what_its_history_tells():
    """Up to 0.3 s the beam is nearly rigid: its energies are those of a bar that swings on its end."""
    run = run_case(Case("x", paper("event", end_time=0.3)))
    b, g, theta = PAPER.beam, PAPER.gravity, run["theta"]
    mass = b.density * b.area * b.length
    kinetic, gravity = mass * b.length**2 * run["theta_dot"] ** 2 / 6.0, 0.5 * mass * g * b.length * np.sin(theta)
    for name, rigid in (("kinetic", kinetic), ("gravity", gravity), ("elastic", 0.0)):
        np.testing.assert_allclose(run[name], rigid, atol=0.07, err_msg=name)  # of 3 J
    np.testing.assert_allclose(run["energy"], run["kinetic"] + run["gravity"] + run["elastic"], rtol=1e-12)
    assert (run.key, run.end_time, run.checks) == ("x", 0.3, [])
    assert "stick_normal" not in run.history.data
    assert run.at("theta", 0.3) == theta[-1]

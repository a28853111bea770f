"""The report of the reproduction: claims, figures, open choices, stick and why not; and the tables beside it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from oblique_impact.validation.paper.claims import Reproduction
from oblique_impact.validation.paper.figures import PLOTS, draw
from oblique_impact.validation.paper.measures import MODELS, SCHEMES, STICK, Models
from oblique_impact.validation.paper.rules import NOT, PARTLY, REPRODUCED, VERDICTS
from oblique_impact.validation.report import MARKS, Block, Cell, Report, Section, Table, Text, number, write_file

KINDS = {REPRODUCED: "pass", PARTLY: "partly", NOT: "fail"}
_LEDGER = ["initial", "final", "lost_impact", "lost_friction", "lost_scheme", "unaccounted"]
_UNITS = {"start": "s", "end": "s", "normal_impulse": "N s", "tangential_impulse": "N s", "peak_force": "N"}


def write_report(result: Reproduction, folder: Path) -> Path:
    """Write report.html, results.json, claims.csv, combinations.csv and the figures; returns the page.

    Raises InputError if a file cannot be written.
    """
    runs = result.runs
    schemes = {scheme: Models(*(runs[f"paper/{scheme}/{model}"] for model in MODELS)) for scheme in SCHEMES}
    pictures = {plot.name: draw(plot, schemes) for plot in PLOTS}
    for name, picture in pictures.items():
        write_file(folder / "figures" / f"{name}.svg", picture.svg)
    verdicts = pd.DataFrame(list(result.combinations["verdicts"]))
    combined = result.combinations.drop(columns=["outcomes", "verdicts"]).join(verdicts)
    for name, frame in (("claims", result.claims), ("combinations", combined)):
        write_file(folder / f"{name}.csv", frame.to_csv(index=False, lineterminator="\n"))
    page = Report(
        "The paper's figures and claims, from our runs",
        _LEAD,
        result.seconds,
        facts=_ASSUMED,
        overview=_overview(result),
        sections=[
            Section("Claims", [_claims(result.claims)]),
            Section("Figures 2 to 16", [Text(_ABOUT_FIGURES), *pictures.values()]),
            Section("What the paper leaves open", _choices(result.combinations)),
            Section("Stick: where it can and cannot occur", [Text(text) for text in _STICK]),
            Section("The runs", _runs(result)),
            Section("Limits of this reproduction", [Text(text) for text in _LIMITS]),
        ],
    )
    return page.write(folder, results(result))


def results(result: Reproduction) -> dict[str, Any]:
    """Return everything as plain data in SI units."""
    runs = {
        key: {
            "outcome": run.outcome.label,
            "macro_collisions": run.macro_collisions,
            "energy": run.balance,
            "scenario": run.scenario,
        }
        for key, run in result.runs.items()
    }
    return {"claims": result.claims, "combinations": result.combinations, "runs": runs}


def _overview(result: Reproduction) -> list[Block]:
    counts = ", ".join(f"{count} {verdict}" for verdict, count in result.verdicts.items())
    missed = " ".join(result.claims["paper"][result.claims["verdict"] == NOT]) or "none."
    return [
        Text(
            f"{len(result.claims)} claims: {counts}. {result.undiscriminating} of them, marked =, do not "
            f"discriminate: all {len(result.combinations)} combinations of open choices reproduce them."
        ),
        Text(f"Not reproduced: {missed}"),
        Text(_RULES),
    ]


def _claims(claims: pd.DataFrame) -> Table:
    rows = []
    for place, claim in enumerate(claims.to_dict("records"), start=1):
        found = [(claim[f"verdict_{name}"], claim[f"ours_{name}"]) for name in ("fixed_step", "event")]
        counts = [claim[f"combinations_{verdict.replace(' ', '_')}"] for verdict in VERDICTS]
        counted = "–" if counts[0] is None else "\u00a0/\u00a0".join(map(str, counts))
        rows.append(
            [
                place,
                f"{claim['paper']} ({claim['place']})",
                *(f"{MARKS[KINDS[verdict]]} {text}" for verdict, text in found),
                Cell(claim["rule"], "dim"),
                Cell(claim["verdict"], KINDS[claim["verdict"]]),
                Cell(counted if claim["discriminates"] else f"=\u00a0{counted}", "number"),
            ]
        )
    columns = ["", "the paper says", *SCHEMES.values(), "rule", "verdict", "all choices"]
    caption = "The sign says what each scheme finds; = marks claims that do not discriminate"
    return Table(columns, rows, caption, wide=(1, 2, 3, 4))


def _choices(grid: pd.DataFrame) -> list[Block]:
    """Return what becomes of the second macro-collision in all combinations of open choices."""
    off = np.maximum(grid["second_start"] - STICK, STICK - grid["second_end"]).clip(lower=0.0)
    nearest, long = grid.loc[off.idxmin()], grid[grid["longest_stick"] >= 1e-4]
    chosen = ", ".join(f"{name.replace('_', ' ')} {nearest[name]}" for name in grid.columns[:5])
    text = (
        f"All {len(grid)} combinations of number of modes, g, shortening of the contact point, Baumgarte's form "
        f"(fixed-step only) and scheme, three models each: in {(off == 0.0).sum()} of them the second "
        f"macro-collision is under way at 0.699 s (nearest: {chosen}; {nearest['second_start']:.4f} s to "
        f"{nearest['second_end']:.4f} s). Stays judged as stick of 0.1 ms or more occur in it in {len(long)} of "
        f"them, the latest from {number(long['longest_stick_start'].max(), 4)} s."
    )
    counts = [list(verdicts.values()).count(REPRODUCED) for verdicts in grid["verdicts"]]
    shown = grid.drop(columns=["outcomes", "verdicts"]).assign(claims_reproduced=counts)
    shown["shortening"] = shown["shortening"].map({True: "in gap and slip", False: "left out"})
    times = ("second_start", "second_end", "longest_stick_start", "longest_stick")
    shown.attrs["units"] = dict.fromkeys(times, "s") | {"gravity": "m/s²"}
    headings = {name: name.replace("_", " ") for name in shown}
    caption = "Combinations: the second macro-collision, the longest stick in it, claims reproduced"
    return [Text(text), Table.of_frame(shown, caption, digits=4, columns=headings)]


def _runs(result: Reproduction) -> list[Block]:
    runs = {key.removeprefix("paper/"): run for key, run in result.runs.items() if key.startswith("paper/")}
    macros = pd.DataFrame(
        {"run": key, "number": number, **macro}
        for key, run in runs.items()
        for number, macro in enumerate(run.macro_collisions, start=1)
    )
    macros.attrs["units"] = _UNITS
    ledgers = pd.DataFrame([run.balance for run in runs.values()])[_LEDGER]
    ledgers.insert(0, "run", list(runs))
    about = "lost_scheme is the work of Baumgarte's terms, negative where they push a tip out of the slope"
    return [
        Table.of_frame(macros, "Macro-collisions: contacts less than 0.03 s apart, impacts included"),
        Table.of_frame(ledgers, f"Energy ledger (J); {about}"),
    ]


_LEAD = (
    "W. Yuan, L. Li, D. G. Zhang, J. Z. Hong: New method for oblique impact dynamics research of a flexible beam "
    "with large overall motion considering impact friction force. Acta Mechanica Sinica 32(4), 2016. Only the "
    "paper's text was available, not its curves: what it says is compared with what we compute."
)
_ASSUMED = [
    ("as printed", "RK4, 0.1 ms in flight and 1 µs in contact, Baumgarte 10 and 1000, stick judged at each step"),
    ("event-located", "the same equations, order 8, adaptive, every transition located in time"),
    ("assumed", "two clamped modes, x_F = L, g = 9.8 m/s², Z'' + 2χZ' + β²Z = 0, v₀, v₁ = 0.001, 0.01 m/s"),
]
_RULES = (
    "Each claim is judged by its rule, once on the fixed-step runs (the algorithm as printed) and once on the "
    "event-located ones (the same equations, solved accurately). Reproduced means by both, not reproduced by "
    "neither, partly everything between. The last column of the claims counts how often each is reproduced / "
    "partly / not reproduced over all combinations of what the paper leaves open."
)
_ABOUT_FIGURES = (
    "The same scales for both schemes (except friction); a thick line for the hybrid model, so that the others "
    "show on top of it. What vibrates faster than a picture can show is drawn as the range of its values with "
    "their mean in it. Figures with a letter are additions: enlargements (a) and floating axes (f)."
)
_STICK = (
    "The tip sticks at an instant if its slip velocity is 0, and the forces that would hold it (the solution of "
    "both constraints) push, λn > 0, and lie in the friction cone, |λτ|/λn ≤ μ_s.",
    "In the paper's example they do not. A beam that does not stretch can move its tip only across the line from "
    "the pin, so a contact that holds the tip acts along that line. With an angle b between line and slope that "
    "takes |λτ|/λn of about cot|b|, the friction coefficient at which a rigid bar jams: 10.7 here, against "
    "μ = 0.3. The slope is too nearly parallel to the beam.",
    "The algorithm as printed judges stick by the forces alone (Sec. 5.3). It finds stick where the slip velocity "
    "passes an extreme, where hardly any tangential force keeps the acceleration zero; the tip does not rest "
    "then.",
)
_LIMITS = (
    "The fixed-step algorithm notices a contact up to one free step late, 0.4 mm below the slope; its Baumgarte "
    "terms then push the tip out and do work on the beam. From the second macro-collision on, the results of the "
    "printed step sizes are shaped by that: compare the two schemes, and the column lost_scheme.",
    "With a rigid stop nothing after the first macro-collision converges as modes are added: agreement or "
    "disagreement at 0.699 s depends on the number of modes, which the paper does not give. A statement about the "
    "second macro-collision is one about a discretized beam.",
    "No run can decide whether the hybrid model is more consistent with real movement, or whether its motion "
    "switch is: that takes a measurement.",
)

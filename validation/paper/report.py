"""The report: claims, figures, open choices, stick and why not; and the tables beside it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd

from oblique_impact.validation.paper.cases import SCHEMES, Combination, cases
from oblique_impact.validation.paper.claims import NOT, PARTLY, REPRODUCED, VERDICTS, Judged, instant
from oblique_impact.validation.paper.figures import PLOTS, draw
from oblique_impact.validation.paper.measures import STICK, sticks
from oblique_impact.validation.paper.reproduction import Reproduction
from oblique_impact.validation.report import (
    MARKS,
    Block,
    Cell,
    Report,
    Section,
    Table,
    Text,
    number,
    write_csv,
    write_file,
)

KINDS = {REPRODUCED: "pass", PARTLY: "partly", NOT: "fail"}
#: runs whose reversals and sticks are shown, and how many of each at most; results.json has all
_STICK_RUNS = {
    "paper/event/hybrid": "paper, event-located",
    "paper/fixed-step/hybrid": "paper, as printed",
    "no-shortening/fixed-step/hybrid": "as printed, without shortening",
    "sticking/event/hybrid": "built-in scenario sticking",
    "rough/event/hybrid": "paper's slope with μ = 12, three mean-axis modes",
}
_MOST_CHECKS = 8
_LEDGER = ("initial", "final", "lost_impact", "lost_friction", "lost_scheme", "unaccounted")


def write_report(result: Reproduction, folder: Path, command: str = "") -> Path:
    """Write report.html, results.json, claims.csv, sensitivity.csv and the figures; returns the page.

    Raises InputError if a file cannot be written.
    """
    schemes = result.models("paper")
    pictures = {plot.name: draw(plot, schemes) for plot in PLOTS}
    for name, picture in pictures.items():
        (folder / "figures").mkdir(exist_ok=True)
        write_file(folder / "figures" / f"{name}.svg", picture.svg)
    claims = [_claim_row(judged) for judged in result.claims]
    for name, rows in (("claims", claims), ("sensitivity", result.variants)):
        write_csv(folder / f"{name}.csv", list(rows[0]), [list(row.values()) for row in rows])
    page = Report(
        "The paper's figures and claims, from our runs",
        "W. Yuan, L. Li, D. G. Zhang, J. Z. Hong: New method for oblique impact dynamics research of a flexible "
        "beam with large overall motion considering impact friction force. Acta Mechanica Sinica 32(4), 2016. "
        "Only the paper's text was available, not its curves: what it says is compared with what we compute.",
        command,
        result.seconds,
        facts=[
            (
                "as printed",
                "RK4, 0.1 ms in flight and 1 µs in contact, Baumgarte 10 and 1000, stick judged at each step",
            ),
            ("event-located", "the same equations, order 8, adaptive, every transition located in time"),
            (
                "assumed (*)",
                "two clamped modes, x_F = L, g = 9.8 m/s², Z'' + 2χZ' + β²Z = 0, v₀, v₁ = 0.001, 0.01 m/s",
            ),
        ],
        overview=_overview(result),
        sections=[
            Section("Claims", [_claims(result)]),
            Section("Figures 2 to 16", [Text(_ABOUT_FIGURES), *pictures.values()]),
            Section("What the paper leaves open", [_choices(result), Text(_robustness(result))]),
            Section("Stick: where it can and cannot occur", _sticking(result)),
            Section("The runs", _runs(result)),
            Section("Limits of this reproduction", [Text(text) for text in _LIMITS]),
        ],
    )
    return page.write(folder, results(result))


def results(result: Reproduction) -> dict[str, Any]:
    """Return everything as plain data in SI units."""
    ratio, tried = result.threshold
    scenarios = cases()
    return {
        "claims": [_claim_data(judged) for judged in result.claims],
        "sensitivity": result.variants,
        "combinations": result.combinations,
        "stick": {
            key: [{**check._asdict(), "ratio": check.ratio} for check in checks]
            for key, checks in result.stick.items()
        },
        "stick_threshold": {
            "ratio": ratio,
            "tried": [{"mu_static": mu, "happened": what} for mu, what in tried],
        },
        "runs": {
            key: {
                "outcome": run.outcome.label,
                "macro_collisions": run.macro_collisions,
                "energy": run.balance,
                "sticks": [
                    {"start": stay.start, "end": stay.end, "slip_rate": stay.slip_rate, "duration": stay.duration}
                    for stay in sticks(run)
                ],
                "scenario": scenarios[key].model_dump(mode="json"),
            }
            for key, run in result.runs.items()
        },
    }


def _claim_data(judged: Judged) -> dict[str, Any]:
    claim = judged.claim
    schemes = {
        scheme: {"verdict": finding.verdict, "ours": finding.text, "numbers": finding.numbers}
        for scheme, finding in judged.findings.items()
    }
    return {
        "id": claim.id,
        "place": claim.place,
        "paper": claim.statement,
        "rule": claim.rule,
        "verdict": judged.verdict,
        "schemes": schemes,
        "combinations": judged.combinations,
        "discriminates": judged.discriminates,
    }


def _claim_row(judged: Judged) -> dict[str, Any]:
    data = _claim_data(judged)
    row = {name: data[name] for name in ("id", "place", "paper", "rule", "verdict")}
    for scheme, finding in data["schemes"].items():
        own = scheme.replace("-", "_")
        row |= {f"verdict_{own}": finding["verdict"], f"ours_{own}": finding["ours"]}
    counts = judged.combinations or {}
    row |= {f"combinations_{verdict.replace(' ', '_')}": counts.get(verdict, "") for verdict in VERDICTS}
    return {**row, "discriminates": judged.discriminates}


def _overview(result: Reproduction) -> list[Block]:
    counts = ", ".join(f"{count} {verdict}" for verdict, count in result.verdicts.items())
    missed = " ".join(judged.claim.statement for judged in result.claims if judged.verdict == NOT) or "none."
    return [
        Text(f"{len(result.claims)} claims: {counts}."),
        Text(
            f"{result.undiscriminating} of them, marked =, do not discriminate: they are reproduced by all "
            f"{len(result.combinations)} combinations of what the paper leaves open."
        ),
        Text(f"Not reproduced: {missed}"),
        Text(
            "Each claim is judged by a rule on numbers, once on the fixed-step runs (the algorithm as printed) "
            "and once on the event-located ones (the same equations, solved accurately). Reproduced means by "
            "both, not reproduced by neither, partly everything between. The last column of the claims counts "
            "how often each is reproduced / partly / not reproduced over all combinations of what the paper "
            "leaves open."
        ),
    ]


def _claims(result: Reproduction) -> Table:
    rows = []
    for place, judged in enumerate(result.claims, start=1):
        claim, counts = judged.claim, judged.combinations or {}
        ours = [f"{MARKS[KINDS[judged.findings[s].verdict]]} {judged.findings[s].text}" for s in SCHEMES]
        counted = "\u00a0/\u00a0".join(map(str, counts.values())) or "–"
        rows.append(
            [
                place,
                f"{claim.statement} ({claim.place})",
                *ours,
                Cell(claim.rule, "dim"),
                Cell(judged.verdict, KINDS[judged.verdict]),
                Cell(counted if judged.discriminates else f"=\u00a0{counted}", "number"),
            ]
        )
    columns = ["", "the paper says", *SCHEMES.values(), "rule", "verdict", "all choices"]
    caption = (
        "What the paper says, what we get (the sign says what each scheme finds), and by which rule it is judged; "
        "= marks claims that do not discriminate"
    )
    return Table(columns, rows, caption, wide=(1, 2, 3, 4))


def _choices(result: Reproduction) -> Table:
    rows = []
    for row in result.variants:
        cells = [row["choice"], f"{row['variant']} *" if row["assumed"] else row["variant"], row["scheme"]]
        for which in ("first", "second"):
            times = [row[f"{which}_{name}"] for name in ("start", "end", "reversal")]
            start, end, reversal = (Cell(instant(time).removesuffix(" s"), "number") for time in times)
            impulse, stuck = row[f"{which}_normal_impulse"], 1e6 * row[f"{which}_stick_time"]
            cells += [start, end, Cell(number(impulse, 4), "number"), reversal, Cell(number(stuck, 3), "number")]
        rows.append(cells)
    each = ("from (s)", "to (s)", "impulse (N s)", "reversal (s)", "stick (µs)")
    columns = ["choice", "value", "scheme", *(f"{n}: {name}" for n in (1, 2) for name in each)]
    caption = "One choice changed at a time; 1, 2: macro-collisions; * marks what is assumed elsewhere"
    return Table(columns, rows, caption)


def _robustness(result: Reproduction) -> str:
    grid = result.combinations
    contain = [row for row in grid if row["second_start"] <= STICK <= row["second_end"]]
    # a combination without a second collision (NaN) is none of them
    second = [row for row in grid if row["second_start"] == row["second_start"]]
    nearest = min(second, key=lambda row: max(row["second_start"] - STICK, STICK - row["second_end"], 0.0))
    long = [row["longest_stick_start"] for row in grid if row["longest_stick"] >= 1e-4]
    latest = f", the latest from {instant(max(long))}" if long else ""
    label = Combination(*(nearest[name] for name in Combination.__dataclass_fields__))
    return (
        f"All {len(grid)} combinations of 1 to 4 clamped modes, g = 9.8 and 9.81 m/s², with and without the contact "
        "point's shortening, both forms of Baumgarte's equation (fixed-step only), both schemes; three models each: "
        f"in {len(contain)} of them the second macro-collision is under way at 0.699 s (nearest: {label}, "
        f"{instant(nearest['second_start'])} to {instant(nearest['second_end'])}); stays judged as stick of 0.1 ms "
        f"or more occur in it in {len(long)} of the combinations{latest}."
    )


def _sticking(result: Reproduction) -> list[Block]:
    located = result.stick["paper/event/hybrid"]
    finite = [check.ratio for check in located if check.ratio < float("inf")]
    scenarios = cases()
    tried = "; ".join(f"μ_s = {number(mu, 5)}: {what}" for mu, what in result.threshold[1])
    printed, without = (sticks(result.runs[key]) for key in list(_STICK_RUNS)[1:3])
    speeds, lengths = (
        [max((abs(getattr(stay, name)) for stay in stays), default=0.0) for stays in (printed, without)]
        for name in ("slip_rate", "duration")
    )
    explanation = (
        "The tip sticks at an instant of contact if three things hold: its slip velocity is zero; the forces "
        "that would hold it (the sticking solution of both constraints) push, λn > 0; and they lie in the "
        "friction cone, |λτ|/λn ≤ μ_s.",
        "In the paper's example they do not. A beam that does not stretch can move its tip only across the "
        "line from the pin, so a contact that holds the tip acts along that line. With an angle b between "
        f"line and slope that takes |λτ|/λn of about cot|b|, here {number(located[0].cotangent, 3)}; where slip "
        f"reverses, the flexible beam asks for {number(min(finite), 3)} to {number(max(finite), 3)}, or for a contact "
        "that pulls, against μ = 0.3. The slope is too nearly parallel to the beam.",
        f"Tested: the first reversal of the event-located run asks for {number(result.threshold[0], 5)}. With the "
        "static coefficient just below and just above it (kinetic 0.3), the same instant gives: "
        f"{tried}.",
        "The fixed-step algorithm as printed judges stick by the forces alone (Sec. 5.3); the slip velocity "
        "is not asked for. It finds stick where the slip velocity passes an extreme, where hardly any "
        "tangential force is needed to keep the acceleration zero. The tip does not rest then: it moves at "
        f"up to {number(1e3 * speeds[0], 3)} mm/s as a stay judged stick begins, and at up to "
        f"{number(1e3 * speeds[1], 3)} mm/s if the contact point's shortening is left out; the longest "
        f"stays last {number(1e6 * lengths[0], 3)} µs and {number(1e6 * lengths[1], 3)} µs.",
    )
    rows = []
    for key, name in _STICK_RUNS.items():
        for check in result.stick[key][:_MOST_CHECKS]:
            forces = check.normal, check.tangential, check.ratio, check.cotangent, scenarios[key].contact.mu_static
            shown = ["pulls" if force == float("inf") else number(force, 4) for force in forces]
            speed = number(1e3 * check.slip_rate, 4)
            texts = [Cell(text, "number") for text in (f"{check.time:.6f}", speed, *shown)]
            rows.append([name, check.kind, *texts])
    columns = ["run", "what happens", "t (s)", "slip velocity (mm/s)", "λn to stick (N)", "λτ to stick (N)"]
    caption = f"Reversals and beginnings of stick, at most {_MOST_CHECKS} of each run (all: results.json)"
    table = Table([*columns, "|λτ|/λn", "cot|b|", "μ_s"], rows, caption)
    return [*map(Text, explanation), table]


def _runs(result: Reproduction) -> list[Block]:
    runs = {key.removeprefix("paper/"): run for key, run in result.runs.items() if key.startswith("paper/")}
    macros = pd.DataFrame(
        {"run": key, "no.": n, **macro}
        for key, run in runs.items()
        for n, macro in enumerate(run.macro_collisions, 1)
    )
    macros.columns = macros.columns.str.replace("_", " ")
    macros.attrs["units"] = {
        "start": "s",
        "end": "s",
        "normal impulse": "N s",
        "tangential impulse": "N s",
        "peak force": "N",
    }
    ledgers = pd.DataFrame(
        {"run": key, **{name: run.balance[name] for name in _LEDGER}} for key, run in runs.items()
    )
    ledgers.columns = ledgers.columns.str.replace("_", " ")
    return [
        Table.of_frame(
            macros, "Macro-collisions: contacts less than 0.03 s apart; impulses include those of the impacts"
        ),
        Table.of_frame(
            ledgers,
            "Energy ledger (J); lost scheme is the work of Baumgarte's terms, negative where they push a tip "
            "out that was noticed below the slope",
        ),
    ]


_ABOUT_FIGURES = (
    "The same scales for both schemes (except friction); a thick line for the hybrid model, so that the others show on "
    "top of it. What vibrates faster than a picture can show is drawn as the range of its values with their mean in "
    "it. Figures with a letter are additions: enlargements (a) and floating axes (f)."
)
_LIMITS = (
    "The fixed-step algorithm notices a contact up to one free step late, 0.4 mm below the slope; its Baumgarte terms "
    "then push the tip out and do work on the beam. From the second macro-collision on, the results of the printed "
    "step sizes are shaped by that: compare the integrators, and the column lost scheme.",
    "With a rigid stop nothing after the first macro-collision converges as modes are added: agreement or disagreement "
    "at 0.699 s depends on the number of modes, which the paper does not give. A statement about the second "
    "macro-collision is one about a discretized beam.",
    "No run can decide whether the hybrid model is more consistent with real movement, or whether its motion switch "
    "is: that takes a measurement.",
)

"""The report's data as JSON and CSV."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from validation.report.provenance import provenance_data
from validation.reproduction.cases import SCHEMES
from validation.reproduction.material import Material
from validation.reproduction.runs import Run
from validation.reproduction.unsaid import Studied

CLAIM_COLUMNS = (
    "id",
    "place",
    "paper",
    "rule",
    "verdict",
    *(f"{name}_{scheme.replace('-', '_')}" for scheme in SCHEMES for name in ("verdict", "ours")),
    "combinations_reproduced",
    "combinations_partly",
    "combinations_not_reproduced",
)


def results(material: Material, figures: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Everything the report shows, as plain data in SI units."""
    ratio, outcomes = material.threshold
    return {
        "claims": [_claim(row) for row in _claims(material)],
        "sensitivity": sensitivity_rows(material.studied),
        "combinations": [_combination(point) for point in material.grid],
        "stick": {
            key: [_check(check) for check in run.checks] for key, run in material.runs.items() if run.checks
        },
        "stick_threshold": {
            "ratio": ratio,
            "tried": [{"mu_static": mu, "happened": what} for mu, what in outcomes],
        },
        "figures": list(figures),
        "runs": {key: _run(run) for key, run in material.runs.items()},
        **provenance_data(),
    }


def claim_rows(material: Material) -> list[list[Any]]:
    """Lines of claims.csv."""
    rows = []
    for row in _claims(material):
        found = [row["schemes"][scheme] for scheme in SCHEMES]
        texts = [value for finding in found for value in (finding["verdict"], finding["ours"])]
        counts = row["combinations"] or {}
        rows.append(
            [
                *(row[key] for key in ("id", "place", "paper", "rule", "verdict")),
                *texts,
                *(counts.get(verdict, "") for verdict in ("reproduced", "partly", "not reproduced")),
            ]
        )
    return rows


def sensitivity_rows(studied: Sequence[Studied]) -> list[dict[str, Any]]:
    """Lines of sensitivity.csv."""
    return [item.row.flat() for item in studied]


def _claims(material: Material) -> list[dict[str, Any]]:
    rows = []
    for judged in material.judged:
        claim = judged.claim
        schemes = {
            scheme: {"verdict": finding.verdict, "ours": finding.text, "numbers": finding.numbers}
            for scheme, finding in judged.findings.items()
        }
        rows.append(
            {
                "id": claim.id,
                "place": claim.place,
                "paper": claim.statement,
                "rule": claim.rule,
                "verdict": judged.verdict,
                "schemes": schemes,
                "combinations": _counts(claim.id, material),
            }
        )
    return rows


def _claim(row: dict[str, Any]) -> dict[str, Any]:
    """Put the texts and numbers of both schemes beside the claim, as most readers of the file want them."""
    found = row["schemes"]
    ours = "; ".join(f"{scheme}: {finding['ours']}" for scheme, finding in found.items())
    return {**row, "ours": ours, "number": {scheme: finding["numbers"] for scheme, finding in found.items()}}


def _counts(claim: str, material: Material) -> dict[str, int] | None:
    if claim not in material.grid[0].verdicts:
        return None
    counts = {"reproduced": 0, "partly": 0, "not reproduced": 0}
    for point in material.grid:
        counts[point.verdicts[claim]] += 1
    return counts


def _combination(point: Any) -> dict[str, Any]:
    c = point.combination
    start, end, stick, duration = point.second
    return {
        "scheme": c.scheme,
        "modes": c.modes,
        "gravity": c.gravity,
        "shortening": c.shortening,
        "baumgarte_form": c.baumgarte_form,
        "outcomes": list(point.outcomes),
        "second_start": start,
        "second_end": end,
        "longest_stick_start": stick,
        "longest_stick": duration,
        "verdicts": point.verdicts,
    }


def _check(check: Any) -> dict[str, Any]:
    return {**check._asdict(), "ratio": check.ratio, "judged_ratio": check.judged_ratio}


def _run(run: Run) -> dict[str, Any]:
    return {
        "outcome": run.outcome,
        "macro_collisions": [macro._asdict() for macro in run.macros],
        "energy": run.energy,
        "sticks": [{**stick._asdict(), "duration": stick.duration} for stick in run.sticks],
        "scenario": run.scenario.model_dump(mode="json"),
    }

"""The report's data as JSON and CSV."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from oblique_impact.validation.report.provenance import provenance_data
from oblique_impact.validation.reproduction.cases import SCHEMES
from oblique_impact.validation.reproduction.claims import VERDICTS
from oblique_impact.validation.reproduction.material import Material
from oblique_impact.validation.reproduction.runs import Run
from oblique_impact.validation.reproduction.unsaid import Robustness

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
    "discriminates",
)


def results(material: Material, figures: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Everything the report shows, as plain data in SI units."""
    ratio, outcomes = material.threshold
    return {
        "claims": _claims(material),
        "sensitivity": [item.flat() for item in material.studied],
        "combinations": [_combination(point) for point in material.grid],
        "stick": {
            key: [{**c._asdict(), "ratio": c.ratio, "judged_ratio": c.judged_ratio} for c in run.checks]
            for key, run in material.runs.items()
            if run.checks
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
        head = (row[key] for key in ("id", "place", "paper", "rule", "verdict"))
        rows.append([*head, *texts, *(counts.get(verdict, "") for verdict in VERDICTS), row["discriminates"]])
    return rows


def _claims(material: Material) -> list[dict[str, Any]]:
    return [
        {
            "id": judged.claim.id,
            "place": judged.claim.place,
            "paper": judged.claim.statement,
            "rule": judged.claim.rule,
            "verdict": judged.verdict,
            "schemes": {
                scheme: {"verdict": finding.verdict, "ours": finding.text, "numbers": finding.numbers}
                for scheme, finding in judged.findings.items()
            },
            "combinations": material.counts(judged.claim.id) or None,
            "discriminates": material.discriminates(judged.claim.id),
            "ours": "; ".join(f"{scheme}: {finding.text}" for scheme, finding in judged.findings.items()),
            "number": {scheme: finding.numbers for scheme, finding in judged.findings.items()},
        }
        for judged in material.judged
    ]


def _combination(point: Robustness) -> dict[str, Any]:
    start, end, stick, duration = point.second
    return {
        **asdict(point.combination),
        "outcomes": list(point.outcomes),
        "second_start": start,
        "second_end": end,
        "longest_stick_start": stick,
        "longest_stick": duration,
        "verdicts": point.verdicts,
    }


def _run(run: Run) -> dict[str, Any]:
    return {
        "outcome": run.history.outcome.label,
        "macro_collisions": run.history.macro_collisions,
        "energy": run.energy,
        "sticks": [
            {"start": s.start, "end": s.end, "slip_rate": s.slip_rate, "duration": s.duration} for s in run.sticks
        ],
        "scenario": run.scenario.model_dump(mode="json"),
    }

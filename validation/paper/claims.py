"""The paper's claims, each judged by its rule.

`claims.toml` is the table of them: where the paper says what, and the rule in words; the function of `rules` with
the name of the claim applies it.  Each claim is judged twice: on fixed-step runs (the algorithm as printed) and on
event-located ones (the same equations, solved).
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import pandas as pd

from oblique_impact.history.history import History
from oblique_impact.validation.paper import rules
from oblique_impact.validation.paper.cases import MODELS, SCHEMES
from oblique_impact.validation.paper.measures import MissingError, Models
from oblique_impact.validation.paper.rules import NOT, PARTLY, REPRODUCED, VERDICTS, Finding
from oblique_impact.validation.paper.sticking import StickCheck, Threshold


@dataclass(frozen=True)
class Claim:
    """One claim: its place in the paper and sentence, the rule in words, the group of ``cases`` to judge it on."""

    id: str
    place: str
    paper: str
    rule: str
    case: str = "paper"

    def judge(self, models: Models) -> Finding:
        """Apply the rule; not reproduced where the runs lack what the claim is about."""
        try:
            found: Finding = getattr(rules, re.sub(r"[-.]", "_", self.id))(models)
        except MissingError as missing:
            return Finding(NOT, {}, str(missing))
        return found


@dataclass(frozen=True)
class Judged:
    """A claim, what each scheme found, and how many combinations of open choices give which verdict.

    There are no combinations for claims about other cases than the paper's.
    """

    claim: Claim
    findings: Mapping[str, Finding]
    combinations: Mapping[str, int] | None = None

    @property
    def verdict(self) -> str:
        """The verdict that both schemes share, else partly."""
        verdicts = {finding.verdict for finding in self.findings.values()}
        return verdicts.pop() if len(verdicts) == 1 else PARTLY

    @property
    def discriminates(self) -> bool:
        """Whether some combination of open choices does not reproduce the claim: else it tells nothing of them."""
        return self.combinations is None or self.combinations[REPRODUCED] < sum(self.combinations.values())


@dataclass(frozen=True)
class Reproduction:
    """The paper's claims with their verdicts, and the runs behind them.

    Attributes
    ----------
    claims : sequence of Judged
        The paper's claims, each with what either scheme found and a verdict.
    runs : dict
        Histories by group/scheme/model, without what varies along the beam.
    combinations : DataFrame
        What each combination of open choices does to the second macro-collision and to the verdicts (SI units).
    stick : dict
        Why the tips of the hybrid models could not stick, or did, by the key of the run.
    threshold : Threshold
        The friction coefficient from which on the first reversal is a stick.
    seconds : float
        Wall time (s) of the simulations.
    report : Path or None
        The page, if one was written.
    """

    claims: Sequence[Judged]
    runs: dict[str, History]
    combinations: pd.DataFrame
    stick: dict[str, list[StickCheck]]
    threshold: Threshold
    seconds: float
    report: Path | None = None

    @property
    def verdicts(self) -> dict[str, int]:
        """How many claims have which verdict: "reproduced", "partly", "not reproduced"."""
        return count_verdicts(judged.verdict for judged in self.claims)

    @property
    def undiscriminating(self) -> int:
        """Number of claims that every combination of open choices reproduces."""
        return sum(not judged.discriminates for judged in self.claims)


_TABLE = tomllib.loads(files("oblique_impact.validation").joinpath("paper/claims.toml").read_text("utf-8"))
#: the claims in the order of the paper's figures
CLAIMS = [Claim(id, **row) for id, row in _TABLE.items()]


def judge_claims(runs: dict[str, History], combined: Sequence[dict[str, Any]]) -> list[Judged]:
    """Judge each claim on the runs of its case, by scheme, and count its verdicts over the combinations."""
    judged = []
    for claim in CLAIMS:
        findings = {}
        for scheme in SCHEMES:
            keys = [f"{claim.case}/{scheme}/{model}" for model in MODELS]
            # where friction is the point there is no frictionless run
            findings[scheme] = claim.judge(Models(*(runs.get(key, runs[keys[0]]) for key in keys)))
        counts = count_verdicts(row["verdicts"][claim.id] for row in combined) if claim.case == "paper" else None
        judged.append(Judged(claim, findings, counts))
    return judged


def count_verdicts(verdicts: Iterable[str]) -> dict[str, int]:
    """Return how often each verdict is among some."""
    found = list(verdicts)
    return {verdict: found.count(verdict) for verdict in VERDICTS}

"""The paper's claims, each judged by its rule.

`claims.toml` is the table of them: where the paper says what, and the rule in words; the function of `rules` with
the name of the claim applies it.  Each claim is judged twice: on fixed-step runs (the algorithm as printed) and on
event-located ones (the same equations, solved).
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import pandas as pd

from oblique_impact.history.history import History
from oblique_impact.validation.paper import rules
from oblique_impact.validation.paper.measures import MODELS, SCHEMES, MissingError, Models
from oblique_impact.validation.paper.rules import NOT, PARTLY, REPRODUCED, VERDICTS, Finding


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
            return NOT, str(missing)
        return found


_TABLE = tomllib.loads(files("oblique_impact.validation").joinpath("paper/claims.toml").read_text("utf-8"))
#: the claims in the order of the paper's figures
CLAIMS = [Claim(id, **row) for id, row in _TABLE.items()]


@dataclass(frozen=True)
class Reproduction:
    """The paper's claims with their verdicts, and the runs behind them.

    Attributes
    ----------
    claims : DataFrame
        A row for each claim: `id`, `place`, `paper` and `rule` in words; `verdict`, "reproduced" if by both
        schemes, "not reproduced" if by neither, else "partly"; for each scheme `verdict_...` and `ours_...`, what
        it found; how many combinations of open choices give which verdict, `combinations_...`, None for claims on
        other cases than the paper's; `discriminates`, whether some of them does not reproduce it.
    runs : dict
        Histories by group/scheme/model, without what varies along the beam.
    combinations : DataFrame
        What each combination of open choices does to the second macro-collision and to the verdicts (SI units).
    seconds : float
        Wall time (s) of the simulations.
    """

    claims: pd.DataFrame
    runs: dict[str, History]
    combinations: pd.DataFrame
    seconds: float

    @property
    def verdicts(self) -> dict[str, int]:
        """How many claims have which verdict: "reproduced", "partly", "not reproduced"."""
        found = self.claims["verdict"].tolist()
        return {verdict: found.count(verdict) for verdict in VERDICTS}

    @property
    def undiscriminating(self) -> int:
        """Number of claims that every combination of open choices reproduces."""
        return int((~self.claims["discriminates"].astype(bool)).sum())


def judge_claims(runs: Mapping[str, History], combined: Sequence[Mapping[str, str]]) -> pd.DataFrame:
    """Judge each claim on the runs of its case; `combined` has the verdicts of each combination, by claim."""
    rows = []
    for claim in CLAIMS:
        row: dict[str, Any] = {name: getattr(claim, name) for name in ("id", "place", "paper", "rule")}
        row["verdict"] = PARTLY
        for scheme in SCHEMES:
            keys = [f"{claim.case}/{scheme}/{model}" for model in MODELS]
            # where friction is the point there is no frictionless run
            found = claim.judge(Models(*(runs.get(key, runs[keys[0]]) for key in keys)))
            suffix = scheme.replace("-", "_")
            row[f"verdict_{suffix}"], row[f"ours_{suffix}"] = found
        verdicts = {row[f"verdict_{scheme.replace('-', '_')}"] for scheme in SCHEMES}
        if len(verdicts) == 1:
            row["verdict"] = verdicts.pop()
        own = claim.case == "paper"
        judged = [one[claim.id] for one in combined] if own else []
        for verdict in VERDICTS:
            row[f"combinations_{verdict.replace(' ', '_')}"] = judged.count(verdict) if own else None
        row["discriminates"] = not own or judged.count(REPRODUCED) < len(judged)
        rows.append(row)
    return pd.DataFrame(rows, dtype=object)

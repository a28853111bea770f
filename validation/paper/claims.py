"""The paper's claims, each judged by its rule.

`claims.toml` is the table of them: where the paper says what, and the rule in words; the function of `rules` with
the name of the claim applies it.  Each claim is judged twice: on fixed-step runs (the algorithm as printed) and on
event-located ones (the same equations, solved).
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files

from oblique_impact.validation.paper import rules
from oblique_impact.validation.paper.measures import MissingError, Models
from oblique_impact.validation.paper.rules import NOT, PARTLY, REPRODUCED, Finding


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


_TABLE = tomllib.loads(files("oblique_impact.validation").joinpath("paper/claims.toml").read_text("utf-8"))
#: the claims in the order of the paper's figures
CLAIMS = [Claim(id, **row) for id, row in _TABLE.items()]

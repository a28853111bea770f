"""Everything the report is made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from oblique_impact.validation.reproduction.claims import REPRODUCED, VERDICTS, Judged
from oblique_impact.validation.reproduction.measures import Trio
from oblique_impact.validation.reproduction.runs import Run
from oblique_impact.validation.reproduction.unsaid import Robustness, Studied


@dataclass(frozen=True)
class Material:
    """Everything the report is made of."""

    trios: dict[str, Trio]  # the paper's case, by scheme
    runs: dict[str, Run]  # all named runs
    judged: Sequence[Judged]
    studied: Sequence[Studied]
    grid: Sequence[Robustness]
    threshold: tuple[float, Sequence[tuple[float, str]]]  # ratio, (coefficient, what happened)

    @property
    def verdicts(self) -> dict[str, int]:
        """How many claims have which verdict."""
        return {verdict: sum(judged.verdict == verdict for judged in self.judged) for verdict in VERDICTS}

    def counts(self, claim: str) -> dict[str, int]:
        """Return how many combinations of open choices give which verdict; {} for claims not judged on them."""
        if not self.grid or claim not in self.grid[0].verdicts:
            return {}
        return {verdict: sum(point.verdicts[claim] == verdict for point in self.grid) for verdict in VERDICTS}

    def discriminates(self, claim: str) -> bool:
        """Whether some combination of open choices does not reproduce a claim: else it tells nothing of them."""
        return self.counts(claim).get(REPRODUCED) != len(self.grid)

    @property
    def undiscriminating(self) -> int:
        """Number of claims that every combination of open choices reproduces."""
        return sum(not self.discriminates(judged.claim.id) for judged in self.judged)

"""The sweep docs/studies/stops.toml: the 800 steady responses behind a picture of the gallery.

    python benchmarks/stops.py        136 s on two cores: 230 s of processor time

Numbers are kept in docs/stops.csv; examples/plot_stops.py draws them.
"""

from __future__ import annotations

import json
from pathlib import Path

from oblique_impact.validation import sweep

DOCS = Path(__file__).parents[1] / "docs"
STORE = DOCS / "stops.csv"
DIGITS = 4


def main() -> None:
    """Run, and keep the numbers; what an interrupted run has computed lies in out/stops."""
    result = sweep(DOCS / "studies" / "stops.toml", "out/stops")
    names = [quantity.name for quantity in result.plan.quantities]
    kept = result.frame[["slope.enabled", "base.frequency", "direction", *names, "samples"]].copy()
    kept["samples"] = [rounded(text) for text in kept["samples"]]
    kept.to_csv(STORE, index=False, float_format=f"%.{DIGITS + 1}g", lineterminator="\n")
    print(result.verdicts)


def rounded(text: str) -> str:
    """Return numbers in JSON with fewer digits."""
    return json.dumps([float(f"{value:.{DIGITS}g}") for value in json.loads(text)])


if __name__ == "__main__":
    main()

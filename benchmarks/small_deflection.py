"""Where the small-deflection model ends: numbers and picture of docs/theory/absolute.md and the README.

    python benchmarks/small_deflection.py      computed if docs/small-deflection.json lacks, then drawn

The same numbers with a report: oblique-impact refine --study small-deflection (some minutes).
"""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from matplotlib.figure import Figure

from renders.style import figure_style
from validation.absolute.deflection_errors import Point
from validation.absolute.small_deflection import small_deflection
from validation.absolute.small_deflection_report import draw_map

DOCS = Path(__file__).parents[1] / "docs"
STORE = DOCS / "small-deflection.json"


def main() -> None:
    """Compute what is missing, and draw."""
    if not STORE.exists():
        result = small_deflection(on_progress=lambda progress: print(progress.done, progress.last, flush=True))
        rows = [asdict(point) for point in result.points]
        # NaN is no JSON: a model without a result has none here
        rows = [row | {"error": row["error"] if row["outcome"] == "completed" else None} for row in rows]
        STORE.write_text(json.dumps(rows, indent=1) + "\n")
    rows = json.loads(STORE.read_text())
    points = [Point(**(row | {"error": float("nan") if row["error"] is None else row["error"]})) for row in rows]
    with figure_style():
        figure = Figure(figsize=(9.2, 5.2), layout="constrained")
        draw_map(figure, points)
        figure.savefig(DOCS / "small-deflection.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()

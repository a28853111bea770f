"""Size of a history's file, estimated before the run."""

from __future__ import annotations

from math import prod

from oblique_impact.beam.beam import contact_places
from oblique_impact.history.variables import VARIABLES
from oblique_impact.scenario.consistency import coordinates
from oblique_impact.scenario.scenario import Scenario

#: bytes of a file above which the command line prints its size before the run
LARGE = 1e9
#: memory that a run takes at its end over the size of its file, which is made in memory: 2.2 for 1e5 samples
MEMORY = 2.2
_STATIONS = 33


def expected_size(scenario: Scenario) -> float:
    """Return the estimated size (bytes) of the file of a history, without the samples at events."""
    lengths = {"time": 1, "coordinate": coordinates(scenario.discretization), "station": _STATIONS}
    lengths["contact"] = len(contact_places(scenario))
    # a variable without time is negligible
    values = sum(prod(lengths[d] for d in v.dimensions) for v in VARIABLES.values() if "time" in v.dimensions)
    return 8.0 * values * (scenario.end_time / scenario.solver.output_interval + 1.0)

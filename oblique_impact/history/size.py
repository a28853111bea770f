"""Size of a history's file, estimated before the run."""

from __future__ import annotations

from math import prod

from oblique_impact.beam.beam import contact_places
from oblique_impact.history.variables import COMPUTED, OF_A_FREE_BEAM, OF_FEW_COORDINATES, VARIABLES
from oblique_impact.scenario.consistency import coordinates
from oblique_impact.scenario.scenario import Scenario

#: bytes of a file above which the command line prints its size before the run
LARGE = 1e9
#: memory that a run takes at its end over the size of its file, which is made in memory: 6 for 1e5 samples
MEMORY = 6.0
_STATIONS = 33
#: what deflated numbers take: their last digits, most of them, are as good as random
_DEFLATED = 0.8


def expected_size(scenario: Scenario) -> float:
    """Return the estimated size (bytes) of the file of a history, without the samples at events."""
    lengths = {"time": 1, "coordinate": coordinates(scenario.discretization), "station": _STATIONS}
    lengths["contact"] = len(contact_places(scenario))
    few = lengths["coordinate"] <= _STATIONS and not scenario.is_absolute
    left_out = {*(COMPUTED if few else OF_FEW_COORDINATES), *(() if scenario.root.is_free else OF_A_FREE_BEAM)}
    # a variable without time is negligible
    kept = [v for name, v in VARIABLES.items() if name not in left_out and "time" in v.dimensions]
    values = sum(prod(lengths[d] for d in v.dimensions) for v in kept)
    return _DEFLATED * 8.0 * values * (scenario.end_time / scenario.solver.output_interval + 1.0)

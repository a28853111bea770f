"""The sticking solution along a contact: whether the tip could have stuck, and by how much it missed.

At an instant of contact the two constraints Z_n'' = 0 and Z_tau'' = 0 together have one solution
(lambda_n, lambda_tau).  The tip can stick only where its slip velocity is zero, that solution pushes
(lambda_n > 0) and lies in the friction cone, |lambda_tau| <= mu_s lambda_n.

Why the ratio is about 10 in the paper's example: the beam does not stretch, so to first order in its
deflection its tip moves across the line from the pin only, and a contact that holds it has to act along
that line.  With an angle b between line and slope such a force has the ratio |lambda_tau|/lambda_n = cot|b|:
in contact b = -0.093 and cot|b| = 10.7, the friction coefficient at which a rigid bar would jam.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.beam.beam import Beam
from oblique_impact.beam.operators import build_operators
from oblique_impact.contact.forces import OK, holding_force
from oblique_impact.contact.state import Instant, Phase, State
from oblique_impact.contact.transitions import Baumgarte, EventKind
from oblique_impact.history.history import History
from oblique_impact.history.sample_times import last_sample
from oblique_impact.marching.sampling import contact_problem
from oblique_impact.scenario.scenario import Scenario

Array = NDArray[np.float64]

_ASKED = (EventKind.REVERSAL, EventKind.STICK)


class StickCheck(NamedTuple):
    """The sticking solution at an event (SI units)."""

    time: float
    kind: str  # what happened: reversal or stick
    slip_rate: float
    normal: float  # lambda_n (N) of the sticking solution; NaN where there is none
    tangential: float  # lambda_tau (N)
    judged_normal: float  # ... with Baumgarte's terms, as a fixed-step scheme judges
    judged_tangential: float
    cotangent: float  # cot|b|, b the angle between the slope and the line from the pin to the contact point

    @property
    def ratio(self) -> float:
        """|lambda_tau| / lambda_n; infinite where the solution would pull, NaN where there is none."""
        return friction_ratio(self.normal, self.tangential)

    @property
    def judged_ratio(self) -> float:
        """The ratio with Baumgarte's terms."""
        return friction_ratio(self.judged_normal, self.judged_tangential)


def friction_ratio(normal: float, tangential: float) -> float:
    """|lambda_tau| / lambda_n; infinite where the normal force would pull, NaN where there is no solution."""
    if np.isnan(normal):
        return float("nan")
    return abs(tangential) / normal if normal > 0.0 else float("inf")


class _Reader:
    """Contact problems at the samples of a history."""

    def __init__(self, scenario: Scenario, history: History) -> None:
        self._model = Beam(scenario, build_operators(scenario)).model
        self._work = self._model.new_workspace()
        self._time, self._q, self._qd = (history[name].values for name in ("time", "q", "qd"))
        v = scenario.solver
        self._baumgarte = Baumgarte.from_parameters(*v.baumgarte, v.baumgarte_form)

    def instant(self, sample: int) -> Instant:
        """Contact problem at a sample."""
        q, qd = np.ascontiguousarray(self._q[sample]), np.ascontiguousarray(self._qd[sample])
        instant: Instant = contact_problem(self._model, float(self._time[sample]), q, qd, self._work)[2]
        return instant

    def judged(self, instant: Instant) -> Instant:
        """Return the problem with Baumgarte's terms, as for a stick that begins here."""
        c, k = self._baumgarte
        return instant._replace(
            gap_acceleration=instant.gap_acceleration + c * instant.gap_rate + k * instant.gap,
            slip_acceleration=instant.slip_acceleration + c * instant.slip_rate,
        )


def _forces(instant: Instant) -> tuple[float, float]:
    """Return the forces (N) that keep a rigid contact sticking, without stabilization; NaN if there are none."""
    force = holding_force(Phase(), instant, 0.0)
    return force[1:] if force.status == OK else (float("nan"), float("nan"))


def at_events(scenario: Scenario, history: History) -> list[StickCheck]:
    """Sticking solution wherever the direction of slip turned or stick began."""
    reader, times = _Reader(scenario, history), history["time"].values
    checks = []
    for event in history.events:
        if event.kind not in _ASKED:
            continue
        sample = int(last_sample(times, event.time))
        instant = reader.instant(sample)
        chord = np.arctan2(float(history["tip_y"][sample]), float(history["tip_x"][sample]))
        angle = chord - scenario.slope.angle
        forces = (*_forces(instant), *_forces(reader.judged(instant)))
        cotangent = 1.0 / np.tan(abs(angle)) if angle else float("inf")
        checks.append(StickCheck(event.time, event.kind.value, instant.slip_rate, *forces, float(cotangent)))
    return checks


def along_contact(scenario: Scenario, history: History) -> dict[str, Array]:
    """Return the forces (N) of the sticking solution, Baumgarte's terms included; NaN without contact.

    While the contact sticks these are its own forces.
    """
    reader, states = _Reader(scenario, history), history["state"].values
    normal, tangential = np.full((2, states.size), np.nan)
    for sample in np.flatnonzero(states == State.SLIP):
        normal[sample], tangential[sample] = _forces(reader.judged(reader.instant(int(sample))))
    stuck = states == State.STICK
    normal[stuck] = history["lambda_n"].values[stuck]
    tangential[stuck] = history["lambda_tau"].values[stuck]
    return {"stick_normal": normal, "stick_tangential": tangential}

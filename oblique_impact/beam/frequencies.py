"""Natural frequencies of the beam that spins at a constant rate."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import InputError
from oblique_impact.scenario.scenario import Scenario, require_scenario
from oblique_impact.scenario.user_defined import discretization

Array = NDArray[np.float64]

#: frequencies per speed, and the fastest spin (rad/s)
MOST, FASTEST = 100, 1e9


@dataclass(frozen=True)
class Frequencies:
    """Natural frequencies (rad/s) over the spin rate, ascending in each row.

    Attributes
    ----------
    speeds : ndarray, shape (speeds,)
        Spin rates (rad/s).
    flapwise, chordwise : ndarray, shape (speeds, count)
        Out of the plane of rotation, and in it (rad/s).  A hinged beam's rigid rotation is among them: at the spin
        rate itself flapwise, at 0 chordwise.
    """

    speeds: Array
    flapwise: Array
    chordwise: Array

    def to_dict(self) -> dict[str, list[float] | list[list[float]]]:
        """Return plain lists, as ``oblique-impact modes --json`` prints them."""
        return {
            "speeds": self.speeds.tolist(),
            "flapwise": self.flapwise.tolist(),
            "chordwise": self.chordwise.tolist(),
        }


def natural_frequencies(
    scenario: Scenario, speeds: Sequence[float] = (0.0,), count: int | None = None
) -> Frequencies:
    """Return the natural frequencies of the beam of a scenario, flapwise and chordwise.

    Parameters
    ----------
    scenario : Scenario
        Its root decides: a pin gives the hinged beam, a hub or a driven root the clamped one at its radius.
    speeds : sequence of float
        Spin rates (rad/s).
    count : int, optional
        Frequencies per speed, 1 to 100; default: the scenario's number of modes, at least four.  A beam with fewer
        shape functions has fewer.

    Returns
    -------
    Frequencies
        A row per speed, ascending (rad/s).

    Raises
    ------
    InputError
        For speeds that are not finite numbers, a count out of range, or what is no scenario.

    Examples
    --------
    >>> from oblique_impact import Scenario, natural_frequencies
    >>> found = natural_frequencies(Scenario.builtin("spin-up"), speeds=[0.0, 6.0], count=3)
    >>> found.flapwise.shape
    (2, 3)
    """
    require_scenario(scenario, "natural_frequencies")
    rates = [float(speed) for speed in speeds]
    if not rates or not all(math.isfinite(rate) and abs(rate) <= FASTEST for rate in rates):
        shown = ",".join(f"{rate:g}" for rate in rates) or "()"
        raise InputError(f"--speeds {shown}: should be finite numbers in rad/s, at most {FASTEST:g}")
    wanted = max(4, scenario.discretization.modes) if count is None else count
    if not 1 <= wanted <= MOST:
        raise InputError(f"--count {wanted}: should be from 1 to {MOST}")
    beam = discretization(scenario.discretization.method).spectrum(scenario)
    return Frequencies(
        np.array(rates),
        np.array([beam.flapwise(rate, wanted) for rate in rates]),
        np.array([beam.chordwise(rate, wanted) for rate in rates]),
    )

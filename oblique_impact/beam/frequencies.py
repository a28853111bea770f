"""Natural frequencies of the beam that spins at a constant rate."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.linalg import eigvals

from oblique_impact.beam.cross_sections import Sections, check_numbers
from oblique_impact.beam.operators import discretization
from oblique_impact.errors import InputError
from oblique_impact.scenario.scenario import Scenario, require_scenario

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

#: frequencies per speed, and the fastest spin (rad/s)
MAX_COUNT, MAX_SPEED = 100, 1e9
#: contacts less than this many elastic periods apart, or less than this part of sqrt(length/gravity), belong to
#: one macro-collision
ELASTIC_PERIODS, PENDULUM_PART = 2.0, 0.1
#: shape functions, and points of the quadrature between two rows of a table, of the lowest elastic frequency
_SHAPES, _POINTS = 10, 14
#: elements of a beam in modes with point masses, at least, and per frequency: errors of 1e-6 and less
_ELEMENTS, _PER_MODE = 64, 12


@dataclass(frozen=True, repr=False)
class Frequencies:
    """Natural frequencies (rad/s) over the spin rate, ascending in each row.

    Attributes
    ----------
    speeds : ndarray, shape (speeds,)
        Spin rates (rad/s).
    flapwise, chordwise : ndarray, shape (speeds, count)
        Out of the plane of rotation, and in it (rad/s).  The rigid rotation of a beam that is free to turn, on a
        pin or with its hub, is among them: at the spin rate itself flapwise, at 0 chordwise.
    """

    speeds: Array
    flapwise: Array
    chordwise: Array

    def to_dataframe(self) -> pd.DataFrame:
        """Return the frequencies (rad/s) as a table, a row for each spin rate (rad/s)."""
        from pandas import DataFrame, Index

        tables = {"flapwise": self.flapwise, "chordwise": self.chordwise}
        columns = {f"{name} {n}": row for name, table in tables.items() for n, row in enumerate(table.T, start=1)}
        return DataFrame(columns, Index(self.speeds, name="spin rate"))

    def __repr__(self) -> str:
        """Return the table."""
        return f"<Frequencies (rad/s)>\n{self.to_dataframe().to_string(float_format='{:.6g}'.format)}"

    def _repr_html_(self) -> str:
        """Show the table in a notebook."""
        return f"frequencies (rad/s){self.to_dataframe().to_html(float_format='{:.6g}'.format)}"

    def to_dict(self) -> dict[str, list[float] | list[list[float]]]:
        """Return plain lists, as ``oblique-impact modes --json`` prints them: in rad/s, and with ``_hz`` in Hz."""
        in_hertz = {f"{name}_hz": vars(self)[name] / (2.0 * math.pi) for name in ("flapwise", "chordwise")}
        return {name: values.tolist() for name, values in {**vars(self), **in_hertz}.items()}


def natural_frequencies(
    scenario: Scenario, speeds: Sequence[float] = (0.0,), count: int | None = None
) -> Frequencies:
    """Return the natural frequencies of the beam of a scenario, flapwise and chordwise.

    Parameters
    ----------
    scenario : Scenario
        Its root decides: a pin gives the hinged beam, a driven root the clamped one at its radius, or one on the
        spring of its clamp, a hub the beam with its hub of that inertia and radius, which is free to turn.  The
        joint is the same in both directions: flapwise a pin is a ball joint, and a hub tilts with its inertia,
        like an arm along the beam, so that one without inertia is a pin and a very heavy one is held.  A hub on an
        axle that it cannot tilt vibrates flapwise like a driven root, and inertias of point masses are arms along
        the beam too.  A hub on a spring to the ground does not spin.
    speeds : sequence of float
        Spin rates (rad/s).
    count : int, optional
        Frequencies per speed, 1 to 100; default: the scenario's number of modes, at least four.  A beam with fewer
        shape functions has fewer.

    Returns
    -------
    Frequencies
        A row per speed.

    Raises
    ------
    InputError
        For speeds that are not finite numbers, or not 0 of a hub on a spring; a count out of range; no scenario.

    Examples
    --------
    >>> from oblique_impact import Scenario, natural_frequencies
    >>> found = natural_frequencies(Scenario.builtin("spin-up"), speeds=[0.0, 6.0], count=3)
    >>> found.flapwise.shape
    (2, 3)
    """
    require_scenario(scenario, "natural_frequencies")
    check_numbers(Sections.from_scenario(scenario))
    rates = [float(speed) for speed in speeds]
    if not rates or not all(abs(rate) <= MAX_SPEED for rate in rates):
        shown = ",".join(f"{rate:g}" for rate in rates) or "()"
        raise InputError(f"--speeds {shown}: should be finite numbers in rad/s, at most {MAX_SPEED:g}")
    if scenario.root.kind == "hub" and scenario.root.stiffness > 0.0 and any(rates):
        shown = ",".join(f"{rate:g}" for rate in rates)
        raise InputError(f"--speeds {shown}: should be 0: a hub on a spring, root.stiffness, does not spin")
    wanted = max(4, scenario.discretization.modes) if count is None else count
    if not 1 <= wanted <= MAX_COUNT:
        raise InputError(f"--count {wanted}: should be from 1 to {MAX_COUNT}")
    posed = _of_masses(scenario, wanted) if scenario.point_masses else scenario
    beam = discretization(posed.discretization.method).spectrum(posed)
    return Frequencies(
        np.array(rates),
        np.array([beam.flapwise(rate, wanted) for rate in rates]),
        np.array([beam.chordwise(rate, wanted) for rate in rates]),
    )


def _of_masses(s: Scenario, count: int) -> Scenario:
    """Return a scenario with point masses in elements: eigenfunctions of the uniform beam do not know them."""
    if s.discretization.method != "modal":
        return s
    elements = max(_ELEMENTS, _PER_MODE * count)
    return s.adapted(discretization__method="fem", discretization__elements=elements)


@lru_cache(maxsize=8)  # a run asks three times
def lowest_elastic_frequency(scenario: Scenario) -> float:
    """Return the lowest angular frequency (rad/s) of the elastic beam at rest, free of contact.

    On a pin, with its hub, clamped or free, as in :func:`natural_frequencies`, on the spring of hub or clamp.  By
    Rayleigh and Ritz with ten polynomials, whatever the discretization: to 1e-9 for a uniform beam, to about a
    hundredth for sections that change abruptly.  0 if mass or stiffness is out of the range of floating-point
    numbers.
    """
    sections = Sections.from_scenario(scenario)
    length = sections.length
    nodes, weights = legendre.leggauss(_POINTS)
    edges = np.concatenate([[0.0], sections.kinks, [length]]) / length
    half = 0.5 * np.diff(edges)[:, None]
    x = (edges[:-1, None] + half * (1.0 + nodes)).ravel()
    w = (half * weights).ravel()
    masses, stiffnesses = sections.mass_per_length(x * length), sections.bending_stiffness(x * length)
    mass, stiffness = float(masses.max()), float(stiffnesses.max())  # scales, that extremes do not overflow
    if not (0.0 < mass < math.inf and 0.0 < stiffness < math.inf):
        return 0.0
    # points of the quadrature and point masses, their distances from the axis, all over length and scales
    points = np.append(w * (masses / mass), sections.point_masses / (mass * length))
    at_points = np.append(x, sections.places / length)
    arms = sections.hub_radius / length + at_points
    # functions of x / length that vanish at the root with their slopes
    shapes = np.zeros((_SHAPES + 2, _SHAPES))
    for k in range(_SHAPES):
        shapes[: k + 3, k] = legendre.legmul(legendre.legpow([0.5, 0.5], 2), np.eye(_SHAPES)[k, : k + 1])
    values = legendre.legval(2.0 * at_points - 1.0, shapes)
    curvatures = 4.0 * legendre.legval(2.0 * x - 1.0, legendre.legder(shapes, 2))
    # what turns with sections: the hub with the root, then point masses
    inertias = np.append(sections.hub_inertia, sections.point_inertias)
    inertias[inertias > 0.0] /= mass * length**3
    slopes = np.zeros((_SHAPES, inertias.size))
    slopes[:, 1:] = 2.0 * legendre.legval(2.0 * sections.places / length - 1.0, legendre.legder(shapes))
    spring = scenario.root.stiffness * length / stiffness
    if spring > 0.0:  # the root turns against it: a hub about its axis, a section at a drive about the root
        turned = arms if scenario.root.kind == "hub" else at_points
        values = np.concatenate([turned[None], values])
        curvatures = np.concatenate([np.zeros((1, x.size)), curvatures])
        slopes = np.concatenate([np.ones((1, inertias.size)), slopes])
    elif scenario.root.is_free:
        # each takes so much of the rigid motion that it has neither momentum nor angular momentum
        rigid, turning = np.stack([np.ones(at_points.size), at_points]), np.array([[0.0], [1.0]])
        moments = (values * points) @ rigid.T + np.outer(slopes @ inertias, turning)
        gram = (rigid * points) @ rigid.T + inertias.sum() * turning @ turning.T
        shares = -np.linalg.solve(gram, moments.T).T
        values, slopes = values + shares @ rigid, slopes + shares @ turning
    elif scenario.root.kind != "driven":
        # each takes so much of the rigid rotation that it has no angular momentum
        turns = -((values * points) @ arms + slopes @ inertias) / (points @ arms**2 + inertias.sum())
        values, slopes = values + np.outer(turns, arms), slopes + turns[:, None]
    M = (values * points) @ values.T + (slopes * inertias) @ slopes.T
    K = (curvatures * w * (stiffnesses / stiffness)) @ curvatures.T + spring * np.outer(slopes[:, 0], slopes[:, 0])
    # of the flexibility the largest eigenvalue is good to rounding, however soft the spring is
    square = 1.0 / np.max(eigvals(M, K).real) if spring > 0.0 else np.min(eigvals(K, M).real)
    return float(np.sqrt(max(square, 0.0)) * np.sqrt(stiffness / mass) / length**2)


def clustering_time(scenario: Scenario) -> float:
    """Return the clustering time of contacts (s): those that follow each other faster are one macro-collision.

    It is the longer of two periods of the lowest elastic mode, in which the beam strikes again because it
    vibrates, and a tenth of sqrt(length/gravity), in which one too stiff to vibrate bounces until it rests.  Both
    are times of the beam itself: a similar beam of another size has as many macro-collisions.
    """
    frequency = lowest_elastic_frequency(scenario)
    period = 2.0 * math.pi / frequency if frequency > 0.0 else math.inf
    pendulum = math.sqrt(scenario.beam.length / scenario.gravity) if scenario.gravity > 0.0 else 0.0
    return max(ELASTIC_PERIODS * period, PENDULUM_PART * pendulum)

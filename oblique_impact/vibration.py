"""Small vibrations about the equilibrium of a scenario, with the contacts that are closed there.

About coordinates at rest the marched model is M x'' + C x' + K x = 0 with the tangent stiffness K of elasticity,
weight, forces fixed in space and elastic contacts, which are their springs in series with what the coordinates
leave out of the beam.  That a force across the beam turns with it is left out: K would not be symmetric.
Rigid contacts are supports, R x = 0 with the rows R of their gaps; so are contacts that are stuck with those of
their slips, but on the axial flexibility, which is a spring.  With x = Z y, R Z = 0, the eigenvalues s of

    (s^2 Z^T M Z + s Z^T C Z + Z^T K Z) y = 0

have the natural frequency |s| and the damping ratio -Re s/|s| (Meirovitch, Fundamentals of Vibrations, 2001).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from scipy.linalg import eig, eigh, null_space

from oblique_impact.beam.cross_sections import Sections, check_numbers
from oblique_impact.beam.frequencies import MAX_COUNT
from oblique_impact.beam_problem import beam_of
from oblique_impact.contact.state import DIRECTION
from oblique_impact.errors import InputError
from oblique_impact.kernels.workspace import Array
from oblique_impact.resting import Balance, Rest, rest
from oblique_impact.scenario.messages import refused
from oblique_impact.scenario.scenario import Scenario, require_scenario

if TYPE_CHECKING:
    import pandas as pd

Friction = Literal["free", "stuck"]

#: velocities (m/s or rad/s) for differences of what is linear, and of the laws of stops
_LINEAR, _OF_STOPS = 1.0, 1e-6
#: coupling of two modes by damping, over the largest damping, that is rounding
_COUPLED = 1e-9
#: of the largest flexibility along the beam, or of what contacts hold: less than this is rounding
_ALIKE = 1e-9
#: of the largest flexibility: a motion below it has no mass
_MASSLESS = 1e-24


@dataclass(frozen=True, repr=False)
class VibrationModes:
    """Natural vibrations about an equilibrium, of n modes, ascending.

    Attributes
    ----------
    frequencies : ndarray, shape (n,)
        Natural frequencies (rad/s), without damping where modes are not coupled by it.
    damping : ndarray, shape (n,)
        Damping ratios.  One that does not oscillate and is coupled to others has its rate as frequency, and 1.
    closed : tuple of (int, float)
        Contacts that are closed: the obstacle (the slope is 0) and the place (m along the beam).
    stations : ndarray, shape (stations,)
        Places along the beam (m).
    shapes : ndarray, shape (n, stations)
        Deflections across the beam there, the largest of each is 1; of damped modes at the phase of the largest.
    """

    frequencies: Array
    damping: Array
    closed: tuple[tuple[int, float], ...]
    stations: Array
    shapes: Array

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each mode."""
        from pandas import DataFrame, RangeIndex

        columns = {"frequency": self.frequencies, "damping": self.damping}
        return DataFrame(columns, RangeIndex(1, self.frequencies.size + 1, name="mode"))

    def __repr__(self) -> str:
        """Return the table."""
        return f"<VibrationModes (rad/s, ratio)>\n{self.to_dataframe().to_string(float_format='{:.6g}'.format)}"

    def _repr_html_(self) -> str:
        """Show the table in a notebook."""
        return f"frequencies (rad/s){self.to_dataframe().to_html(float_format='{:.6g}'.format)}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain lists, as ``oblique-impact modes --closed --json`` prints them, in rad/s."""
        return {
            "frequencies": self.frequencies.tolist(),
            "damping": self.damping.tolist(),
            "closed": [{"obstacle": obstacle, "place": place} for obstacle, place in self.closed],
        }


def frequencies_at_rest(
    scenario: Scenario, count: int | None = None, friction: Friction = "free"
) -> VibrationModes:
    """Return natural frequencies and damping ratios of a scenario about its equilibrium, contacts closed there.

    Parameters
    ----------
    scenario : Scenario
        Its equilibrium is found from `initial.angle`, whatever `initial.state` says.  Modes are those of its
        model: take enough of them, or all nodes of a mesh.
    count : int, optional
        Modes, 1 to 100; default: the scenario's number of modes, at least four.  Models may have fewer.
    friction : {"free", "stuck"}
        Whether closed contacts slip without friction, or are held along their obstacles.

    Returns
    -------
    VibrationModes
        Frequencies (rad/s), damping ratios, closed contacts and shapes.

    Raises
    ------
    InputError
        If there is no equilibrium, a root turns, nothing can stick, or a count is out of range.

    Examples
    --------
    >>> from oblique_impact import Scenario, frequencies_at_rest
    >>> found = frequencies_at_rest(Scenario.builtin("elastic-stop"), count=2)  # doctest: +SKIP
    """
    require_scenario(scenario, "frequencies_at_rest")
    wanted = max(4, scenario.discretization.modes) if count is None else count
    if not 1 <= wanted <= MAX_COUNT:
        raise InputError(f"--count {wanted}: should be from 1 to {MAX_COUNT}")
    contact = scenario.contact
    if friction not in ("free", "stuck"):
        raise refused("friction", friction, 'should be "free" or "stuck"')
    if friction == "stuck" and contact.friction != "hybrid":
        raise refused("contact.friction", contact.friction, 'should be "hybrid": no other contact sticks')
    check_numbers(Sections.from_scenario(scenario))
    if scenario.is_absolute:
        from oblique_impact.fem_beam.exact.exact_vibration import vibration_modes  # which is built on this package

        return vibration_modes(scenario, wanted, friction == "stuck")
    beam = beam_of(scenario.adapted(initial__state="equilibrium"))
    balance = Balance(beam)
    at = rest(balance, beam.initial_state()[0])
    M, C, K = _matrices(balance, at)
    rows = balance.contacts.rows[DIRECTION, :, 0][at.rigid]
    if friction == "stuck":
        held, K = _stuck(balance, at, K)
        rows = np.concatenate([rows, held])
    free = balance.free
    base = null_space(rows[:, free], rcond=_ALIKE) if len(rows) else np.eye(beam.size)[free, free]
    M, C, K = (base.T @ X[free, free] @ base for X in (M, C, K))
    frequencies, damping, vectors = eigenvalues_of(M, C, K, wanted)
    whole = np.zeros((vectors.shape[1], beam.size))
    whole[:, free] = (base @ vectors).T
    parts, stations = beam.split(whole), beam.operators.stations
    arms = beam.operators.sections.hub_radius + stations.points
    shapes = np.outer(parts[:, 0], arms) + np.asarray(stations.values @ parts[:, 1:].T).T
    largest = shapes[np.arange(len(shapes)), np.argmax(np.abs(shapes), axis=1)]
    pairs = balance.decision.pairs
    closed = tuple((pairs[i].obstacle, float(pairs[i].place(at.slips[i]))) for i in at.closed)
    return VibrationModes(frequencies, damping, closed, stations.points, shapes / largest[:, None])


def _matrices(balance: Balance, at: Rest) -> tuple[Array, Array, Array]:
    """Return mass, damping and stiffness (d, d) about a beam at rest; the balance is left there."""
    size, closed = at.q.size, at.elastic
    damping = np.zeros((size, size))
    for j in range(balance.free.start, size):
        unit = np.eye(1, size, j)[0]
        before, after = (balance.at(at.q, side * _LINEAR * unit, closed) for side in (-1.0, 1.0))
        damping[:, j] = -(after.load - before.load) / (2.0 * _LINEAR)
        if closed.any():
            before, after = (balance.at(at.q, side * _OF_STOPS * unit, closed) for side in (-1.0, 1.0))
            pushes = (after.pressing - before.pressing) @ after.rows[:, 0]
            damping[:, j] -= pushes / (2.0 * _OF_STOPS)
    balance.at(at.q, np.zeros(size), closed)
    return balance.mass_matrix(), 0.5 * (damping + damping.T), at.stiffness


def _stuck(balance: Balance, at: Rest, stiffness: Array) -> tuple[Array, Array]:
    """Return rows (m, d) that closed contacts hold along obstacles, and the stiffness (d, d) with springs."""
    rows, pairs = balance.contacts.rows[DIRECTION, :, 1][at.closed], balance.decision.pairs
    behind = [pairs[i].axial for i in at.closed]
    if not at.closed or behind[0] is None:
        return rows, stiffness
    axial, senses = np.array([of(float(at.slips[i])) for of, i in zip(behind, at.closed, strict=True) if of]).T
    shared = np.outer(senses, senses) * np.minimum.outer(axial, axial)
    flexibilities, together = np.linalg.eigh(shared)
    yields = flexibilities > _ALIKE * flexibilities[-1]
    springs, held = together[:, yields].T @ rows, together[:, ~yields].T @ rows
    # two contacts at one place stretch the axis together, but as a pair they hold the section: its rotation, if
    # they are on both faces, nothing if they are on its axis
    sizes, size = np.linalg.norm(held, axis=1), np.linalg.norm(rows)
    return held[sizes > _ALIKE * size], stiffness + (springs.T / flexibilities[yields]) @ springs


def eigenvalues_of(M: Array, C: Array, K: Array, count: int) -> tuple[Array, Array, Array]:
    """Return frequencies (rad/s), damping ratios (n,) and vectors (d, n) of at most `count` modes, ascending.

    Of flexibilities, and of the inverse of the eigenvalues, the lowest modes are those that are good to rounding.
    """
    scale = 1.0 / np.sqrt(np.diag(K))
    flexibilities, vectors = eigh(M * np.outer(scale, scale), K * np.outer(scale, scale))
    kept = flexibilities > _MASSLESS * flexibilities[-1]
    flexibilities, vectors = flexibilities[kept][::-1], (scale[:, None] * vectors)[:, kept][:, ::-1]
    own, shapes = 1.0 / np.sqrt(flexibilities), vectors / np.sqrt(flexibilities)
    damped = shapes.T @ C @ shapes
    apart = damped - np.diag(np.diag(damped))
    if np.all(np.abs(apart) <= _COUPLED * np.max(np.abs(damped), initial=0.0)):
        return own[:count], 0.5 * (np.diag(damped) / own)[:count], shapes[:, :count]
    # of (own z, z'), see above
    inverse = np.block([[-damped / np.outer(own, own), -np.diag(1.0 / own)], [np.diag(1.0 / own), 0.0 * damped]])
    values, states = eig(inverse)
    values = 1.0 / values[np.abs(values) > 0.0]
    chosen = [k for k in np.argsort(np.abs(values), kind="stable") if values[k].imag >= 0.0][:count]
    sizes = np.abs(values[chosen])
    moved = states[own.size :, chosen]
    turned = moved * np.exp(-0.5j * np.angle(np.sum(moved**2, axis=0)))  # the phase of the largest real part
    return sizes, -values[chosen].real / sizes, shapes @ turned.real

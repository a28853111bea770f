"""Small vibrations of the exact beam about its equilibrium, in rotations and strains (see `exact_rest`).

A follower force makes the stiffness K not symmetric; then the eigenvalues s of s^2 M + s C + K are the inverses of
those of

    [ -K^-1 C   -K^-1 M ]
    [    1         0    ]

of which those without mass are 0.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import eig, null_space

from oblique_impact.beam.operators import station_points
from oblique_impact.fem_beam.exact.elastic_sections import ElasticSections
from oblique_impact.fem_beam.exact.exact_history import stations_of
from oblique_impact.fem_beam.exact.exact_rest import ExactBalance, find_rest
from oblique_impact.fem_beam.exact.exact_system import beam_of
from oblique_impact.fem_beam.exact.step_forces import NODE
from oblique_impact.kernels.workspace import Array
from oblique_impact.resting import Rest
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.vibration import VibrationModes, eigenvalues_of

#: of the largest stiffness: differences from its transpose that are rounding; of the largest inverse of an
#: eigenvalue: those of motions without mass
_SYMMETRIC, _MASSLESS = 1e-10, 1e-10


def vibration_modes(
    scenario: Scenario, count: int, stuck: bool, sections: ElasticSections | None = None
) -> VibrationModes:
    """Return the lowest modes of a scenario about its equilibrium; closed contacts are free to slip, or `stuck`.

    `sections` replace those of the scenario.  Raises InputError if there is no equilibrium.
    """
    beam = beam_of(scenario, sections)
    balance, at = find_rest(scenario.adapted(initial__state="equilibrium"), beam)
    nodes, J = balance.beam.nodes(at.q), balance.beam.jacobian(at.q)
    _, slips, of_contacts = balance.contacts_at(nodes)
    rows = of_contacts[at.rigid, 0] @ J
    if stuck:
        rows = np.concatenate([rows, of_contacts[at.closed, 1] @ J])
    base = null_space(rows) if len(rows) else np.eye(balance.beam.size)
    M, C, K = (
        base.T @ X @ base for X in (J.T @ (beam.M @ J), _damping(balance, at, of_contacts[:, 0] @ J), at.stiffness)
    )
    if np.max(np.abs(K - K.T)) <= _SYMMETRIC * np.max(np.abs(K)):
        frequencies, damping, vectors = eigenvalues_of(M, C, K, count)
    else:
        frequencies, damping, vectors = _with_followers(M, C, K, count)
    stations = stations_of(beam, station_points(scenario.beam.length, scenario.contact.point))
    moved = (J @ base @ vectors).T
    turned = np.exp(-1j * (stations.values @ nodes[2::NODE]))
    shapes = (turned * ((moved[:, 0::NODE] + 1j * moved[:, 1::NODE]) @ stations.values.T)).imag
    largest = shapes[np.arange(len(shapes)), np.argmax(np.abs(shapes), axis=1)]
    pairs = balance.decision.pairs
    closed = tuple((pairs[i].obstacle, float(pairs[i].place(slips[i]))) for i in at.closed)
    return VibrationModes(frequencies, damping, closed, stations.x, shapes / largest[:, None])


def _damping(balance: ExactBalance, at: Rest, rows: Array) -> Array:
    """Return the damping matrix (d, d) of the beam, its root and its closed stops with the rows (n, d) of gaps."""
    s = balance.beam.scenario
    found: Array = s.beam.kelvin_voigt * balance.beam.elastic
    if not balance.beam.held:
        found[0, 0] += s.root.damping
    factors = np.where(at.elastic, s.contact.damping * at.forces + s.contact.linear_damping, 0.0)
    return np.asarray(found + (rows.T * factors) @ rows)


def _with_followers(M: Array, C: Array, K: Array, count: int) -> tuple[Array, Array, Array]:
    """Return frequencies (rad/s), damping ratios (n,) and vectors (d, n) of at most `count` modes, ascending."""
    size = len(K)
    softness = np.linalg.solve(K, np.hstack([C, M]))
    values, states = eig(np.block([[-softness[:, :size], -softness[:, size:]], [np.eye(size), np.zeros_like(K)]]))
    kept = np.abs(values) > _MASSLESS * np.max(np.abs(values))
    values, states = 1.0 / values[kept], states[:size, kept]
    chosen = [k for k in np.argsort(np.abs(values), kind="stable") if values[k].imag >= 0.0][:count]
    sizes, moved = np.abs(values[chosen]), states[:, chosen]
    turned = moved * np.exp(-0.5j * np.angle(np.sum(moved**2, axis=0)))  # the phase of the largest real part
    return sizes, -values[chosen].real / sizes, turned.real

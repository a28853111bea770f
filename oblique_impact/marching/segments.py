"""Samples of a phase: what stops and flexibilities hold there, and the contact that is nearest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.forces import shared_flexibility
from oblique_impact.contact.pairs import ContactPair
from oblique_impact.contact.state import OBSERVED, Candidate, State
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.records import Segment
from oblique_impact.marching.sampling import Observation

_OUTSIDE = 1e-9  # of the friction cone: a located end of stick is at its edge but for less


def segment_of(
    times: Array,
    states: Array,
    each: NDArray[np.int8],
    found: Observation,
    present: Sequence[Candidate],
    pairs: Sequence[ContactPair],
) -> Segment:
    """Return samples with what contacts hold that are `present` all along.

    Parameters
    ----------
    times, states : ndarray, shapes (samples,) and (samples, ny)
        Samples.
    each : ndarray, shape (samples, n)
        The states of all contacts.
    found : Observation
        What is observed there.
    present, pairs : sequences of n
        Parameters and laws of the contacts.
    """
    depth, stored = np.zeros((2, len(times)))
    for i, (c, pair) in enumerate(zip(present, pairs, strict=True)):
        law = pair.contact_law
        if law is None or c.state == State.FREE:
            continue
        depth = np.maximum(depth, found.column("compression")[:, i])
        names = "gap", "slip", "rest_compression", "rest_force"
        stored += law.energies(*(found.column(name)[:, i] for name in names))
    nearest = found.contacts[:, 0]
    if len(pairs) > 1:
        sides, ends = np.array([c.side for c in present]), np.array([pair.ends for pair in pairs]).T
        nearest = _nearest(sides, ends, found.contacts)
    no_steps = np.zeros(len(times))
    return Segment(times, states, found, nearest, depth, stored, _stretched(present, found), each, no_steps)


def _stretched(present: Sequence[Candidate], found: Observation) -> Array:
    """Energy (J) that the axial flexibility behind the friction holds at samples."""
    if not any(c.axial for c in present):
        return np.zeros(len(found.contacts))
    # no number where no force solves the contacts (Painleve)
    forces = np.nan_to_num(found.column("lambda_tau"))
    flexibility = np.array([[shared_flexibility(a, b) for b in present] for a in present])
    return np.asarray(0.5 * np.einsum("si,ij,sj->s", forces, flexibility, forces))


def _nearest(sides: Array, ends: Array, each: Array) -> Array:
    """Return what is observed (samples, 6) of the contact with the smallest gap, with the forces of all."""
    slips = each[:, :, OBSERVED.index("slip")]
    within = (slips >= ends[0]) & (slips <= ends[1])
    gaps = np.where(within, sides * each[:, :, OBSERVED.index("gap")], np.inf)
    found: Array = each[np.arange(len(each)), np.argmin(gaps, axis=1)]
    for name in ("lambda_n", "lambda_tau"):
        found[:, OBSERVED.index(name)] = each[:, :, OBSERVED.index(name)].sum(axis=1)
    return found


def inside_cones(states: list[Candidate], found: Observation) -> list[Candidate]:
    """Return the states of contacts, or others whose forces are inside of the friction cones.

    A contact that sticks beyond its cone is at its edge, one that pulls is without force.
    """
    normal, tangential = found.column("lambda_n")[0].tolist(), found.column("lambda_tau")[0].tolist()
    changed = [_inside_cone(*contact) for contact in zip(states, normal, tangential, strict=True)]
    return states if all(a is b for a, b in zip(changed, states, strict=True)) else changed


def _inside_cone(c: Candidate, normal: float, tangential: float) -> Candidate:
    """Return a contact, or another state of it if its forces (N) are outside of the friction cone."""
    if c.state == State.STICK and abs(tangential) > c.static * max(normal, 0.0) * (1.0 + _OUTSIDE):
        edge = c.static if tangential > 0.0 else -c.static
        return c.changed(state=int(State.SLIP), intercept=edge, slope=0.0, lower=-np.inf, upper=np.inf)
    pulls = c.state == State.SLIP and not c.compliant and normal < 0.0
    return c.changed(state=int(State.FREE)) if pulls else c

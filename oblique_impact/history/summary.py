"""The summary of a run, as in summary.json: outcome, macro-collisions, energy balance, costs, versions.

The energy balance accounts for losses by impacts, friction, damping and the scheme:

    initial + supplied - lost_impact - lost_friction - lost_damping - lost_scheme - final = unaccounted

Work is supplied by driven roots, torques on a hub and a shaken base, to which all velocities and energies are
relative.  Losses are integrated along with the motion (friction, damping, stabilization) or summed over the
impacts; energies are evaluated from the states.  `unaccounted` is therefore an independent check of both.
"""

from __future__ import annotations

import math
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from oblique_impact.contact.log import Contact, Event
from oblique_impact.errors import Outcome
from oblique_impact.history.events import numbers_of
from oblique_impact.history.provenance import provenance, provenance_line, versions
from oblique_impact.history.samples import Samples
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.equations import (
    DAMPING_LOSS,
    FRICTION_LOSS,
    STABILIZATION_LOSS,
    STOP_LOSS,
    SUPPLIED,
    of_all_contacts,
)
from oblique_impact.marching.records import Record

#: causes of energy loss: the entries `lost_impact`, `lost_friction`, ... of a ledger
LOSSES = ("impact", "friction", "damping", "scheme")
_REPORTED_PACKAGES = ("oblique-impact", "numpy", "scipy", "numba", "scikit-fem", "xarray")


@dataclass(frozen=True)
class Ledger:
    """Energy balance of a run (J); `kinetic`, `elastic`, `gravity`, `contact` are the parts of `final`."""

    initial: float
    final: float
    kinetic: float
    elastic: float
    gravity: float
    contact: float
    supplied: float
    lost_impact: float
    lost_friction: float
    lost_damping: float
    lost_scheme: float
    unaccounted: float


def balance(
    initial: float,
    parts: tuple[float, float, float, float],
    quadratures: Array,
    events: list[Event],
    stretched: float = 0.0,
) -> Ledger:
    """Return the energy balance of a run.

    Parameters
    ----------
    initial : float
        Energy at the start (J).
    parts : tuple
        Kinetic, elastic, gravity and contact energy at the end (J).
    quadratures : ndarray, shape (3 + 5 n,)
        The integrals carried along with the motion, of the run and of each of n contacts, at the end.
    events : list of Event
        The event log.
    stretched : float
        Part of the contact energy (J) that the axial flexibility behind the friction has gained; while it holds
        it, the quadratures count it as taken by friction.
    """
    kinetic, elastic, gravity, contact = parts
    supplied, scheme = float(quadratures[SUPPLIED]), float(quadratures[STABILIZATION_LOSS])
    friction = float(of_all_contacts(quadratures, FRICTION_LOSS)) - stretched
    damping = float(quadratures[DAMPING_LOSS] + of_all_contacts(quadratures, STOP_LOSS))
    impact = sum(event.energy_loss for event in events if event.kind.impulsive)
    final = sum(parts)
    return Ledger(
        initial=initial,
        final=final,
        kinetic=kinetic,
        elastic=elastic,
        gravity=gravity,
        contact=contact,
        supplied=supplied,
        lost_impact=impact,
        lost_friction=friction,
        lost_damping=damping,
        lost_scheme=scheme,
        unaccounted=initial + supplied - impact - friction - damping - scheme - final,
    )


def balance_text(energy: Mapping[str, float]) -> str:
    """Return the energy balance as text, "3.01 - 1.52 lost = 1.49 J"; terms of 0 are left out."""
    supplied, lost = energy["supplied"], sum(energy[f"lost_{name}"] for name in LOSSES)
    rounding = 1e-7 * max(abs(energy["initial"]), abs(energy["final"]))
    parts = f"{energy['initial']:.6g}"
    if abs(supplied) > rounding:
        parts += f" {'+' if supplied > 0.0 else '-'} {abs(supplied):.6g} supplied"
    if abs(lost) > rounding:
        parts += f" {'-' if lost > 0.0 else '+'} {abs(lost):.6g} lost"
    return f"{parts} = {energy['final']:.6g} J"


@dataclass(frozen=True)
class MacroCollision:
    """A macro-collision: contacts less than the clustering time apart (SI units)."""

    start: float
    end: float
    contacts: int
    normal_impulse: float
    tangential_impulse: float
    peak_force: float


def macro_collisions(contacts: Sequence[Contact], clustering_time: float) -> list[MacroCollision]:
    """Group contacts in order of time that are less than `clustering_time` (s) apart.

    Impulses add up, the peak is the largest finite force.
    """
    groups: list[list[Contact]] = []
    ends = -math.inf  # the last group: several contacts overlap
    for contact in sorted(contacts, key=lambda contact: contact.start):
        if contact.start - ends < clustering_time:
            groups[-1].append(contact)
            ends = max(ends, contact.end)
        else:
            groups.append([contact])
            ends = contact.end
    return [
        MacroCollision(
            start=group[0].start,
            end=max(c.end for c in group),
            contacts=len(group),
            normal_impulse=sum(c.normal_impulse for c in group),
            tangential_impulse=sum(c.tangential_impulse for c in group),
            peak_force=max(c.peak_force for c in group),
        )
        for group in groups
    ]


def require_summary(summary: Any) -> None:
    """Raise an error of any kind if a summary read from a file lacks what its readers need."""
    if summary["outcome"] not in [outcome.label for outcome in Outcome]:
        raise ValueError(f"its outcome {summary['outcome']!r} is none of this version")
    collisions = [asdict(MacroCollision(**entry)) for entry in summary["macro_collisions"]]
    numbers_of([summary["end_time"], summary["macro_gap"], summary["steps"]])
    for entry in (asdict(Ledger(**summary["energy"])), *collisions):
        numbers_of(entry.values())
    texts = [summary["message"], *summary.get("warnings", []), *summary.get("without_limit", [])]
    lists = [summary["macro_collisions"], summary.get("warnings", []), summary.get("without_limit", [])]
    if not all(isinstance(text, str) for text in texts) or not all(isinstance(entry, list) for entry in lists):
        raise TypeError("its summary has no texts or lists where they should be")
    provenance_line(summary.get("provenance", {}))


def summarize(record: Record, samples: Samples, wall: float, clustering_time: float) -> dict[str, Any]:
    """Return the summary of a run, without the entries of beams: `clearance`, `without_limit` and `warnings`.

    `wall` is the wall time of the marching (s); contacts less than `clustering_time` (s) apart are one
    macro-collision.
    """
    energies = samples.kinetic, samples.elastic, samples.gravity, samples.stored
    kinetic, elastic, gravity, stored = (float(values[-1]) for values in energies)
    stretched = samples.stretched
    initial = sum(float(values[0]) for values in (*energies, stretched))
    parts = kinetic, elastic, gravity, stored + float(stretched[-1])
    gained = float(stretched[-1] - stretched[0])
    return {
        "outcome": record.outcome.label,
        "message": record.message or record.outcome.sentence,
        "end_time": float(samples.time[-1]),
        "macro_gap": clustering_time,
        "macro_collisions": [asdict(m) for m in macro_collisions(record.contacts, clustering_time)],
        "slope_ends": [p._asdict() | {"how": p.how.value} for p in record.passages],
        "events": len(record.events),
        "energy": asdict(balance(initial, parts, samples.quadratures[-1], record.events, gained)),
        "steps": record.steps,
        "rejected_steps": record.rejected,
        "wall_time": wall,
        "versions": {"python": platform.python_version(), **versions(*_REPORTED_PACKAGES)},
        "provenance": provenance(),
    }

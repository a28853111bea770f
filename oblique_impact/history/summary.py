"""The summary of a run, as in summary.json: outcome, macro-collisions, energy balance, costs, versions.

The energy balance accounts for losses by impacts, friction, damping and the scheme:

    initial + supplied - lost_impact - lost_friction - lost_damping - lost_scheme - final = unaccounted

Work is supplied by driven roots, torques on a hub and a shaken base, to which all velocities and energies are
relative.  Losses are integrated along with the motion (friction, damping, stabilization) or summed over the
impacts; energies are evaluated from the states.  `unaccounted` is therefore an independent check of both.
"""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from oblique_impact.errors import Outcome
from oblique_impact.history.events import numbers_of
from oblique_impact.history.provenance import provenance, provenance_line, versions
from oblique_impact.history.samples import Samples
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.equations import DAMPING_LOSS, FRICTION_LOSS, STABILIZATION_LOSS, STOP_LOSS, SUPPLIED
from oblique_impact.marching.records import Contact, Event, Record

#: causes of energy loss: the entries `lost_impact`, `lost_friction`, ... of a ledger
LOSSES = ("impact", "friction", "damping", "scheme")
#: energy lost to a scheme gives a warning above this part of all losses, and above this part of the largest
#: kinetic energy of the run: less than that changes speeds by less than 0.05 %, also where nothing else is lost
NOTICEABLE_SHARE, NEGLIGIBLE_ENERGY = 0.03, 1e-3
#: above this part of the largest kinetic energy the motion is said to be another one, not the losses alone: it
#: changes speeds by 0.5 %
LARGE_SHARE = 1e-2
#: of the parts of the energy: what is lost or unaccounted for below this is rounding
ROUNDING = 1e-9
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
    quadratures : ndarray, shape (7,)
        The integrals carried along with the motion, at the end.
    events : list of Event
        The event log.
    stretched : float
        Part of the contact energy (J) that the axial flexibility behind the friction has gained; while it holds
        it, the quadratures count it as taken by friction.
    """
    kinetic, elastic, gravity, contact = parts
    supplied, friction, scheme = (float(quadratures[k]) for k in (SUPPLIED, FRICTION_LOSS, STABILIZATION_LOSS))
    friction -= stretched
    damping = float(quadratures[DAMPING_LOSS] + quadratures[STOP_LOSS])
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


def energy_warnings(
    energy: Mapping[str, float], largest_kinetic: float, largest_parts: float, scheme: str
) -> list[str]:
    """Return warnings about energy lost to the integration scheme, and about unaccounted energy.

    `energy` is a :class:`Ledger` as a dictionary, `largest_kinetic` the largest kinetic energy of the run (J),
    `largest_parts` its largest sum of absolute kinetic, elastic and gravity energies (J), `scheme` the name of the
    scheme.
    """
    losses = sum(abs(energy[f"lost_{name}"]) for name in LOSSES)
    rounding = ROUNDING * largest_parts  # in the total these may cancel, their rounding does not
    small = max(NOTICEABLE_SHARE * losses, NEGLIGIBLE_ENERGY * largest_kinetic, rounding)
    lost, unaccounted = energy["lost_scheme"], energy["unaccounted"]
    steps = "take shorter steps (solver.free_step, solver.contact_step)"
    if scheme == "event":
        steps = "take a smaller solver.tolerance"
    found = []
    if abs(lost) > small:
        did, share = "took" if lost > 0.0 else "added", 100.0 * abs(lost) / losses
        remedy = steps
        if scheme == "generalized-alpha":
            remedy += ", solver.rho_infinity nearer to 1, or the damping that the beam has (beam.kelvin_voigt)"
        if scheme == "fixed-step":
            remedy += ', or solver.scheme = "event"'
        of_energy = abs(lost) / (largest_kinetic or largest_parts)
        shares = f"{share:.2g} % of what is lost in all, {100.0 * of_energy:.2g} % of the largest kinetic energy"
        what = "the motion after the contacts is" if of_energy > LARGE_SHARE else "the losses are"
        found.append(
            f"solver.scheme: the integration {did} {abs(lost):.3g} J, {shares}: "
            f"{what} not that of the beam; {remedy}"
        )
    if abs(unaccounted) > small:
        found.append(f"solver.scheme: {unaccounted:.3g} J of the energy balance are unaccounted for; {steps}")
    return found


def ambiguity_warnings(times: Sequence[float]) -> list[str]:
    """Return a warning of the times (s) at which contact forces were one of several solutions, if any."""
    if not times:
        return []
    at = (
        f"at {times[0]:.6g} s"
        if len(times) == 1
        else f"{len(times)} times from {times[0]:.6g} to {times[-1]:.6g} s"
    )
    return [
        f"contact.mu_kinetic: contact forces were not unique {at} (Painleve): of several solutions that with the "
        "fewest closed contacts was taken; with less friction there is one"
    ]


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
    for contact in sorted(contacts, key=lambda contact: contact.start):  # several contacts overlap
        if groups and contact.start - max(c.end for c in groups[-1]) < clustering_time:
            groups[-1].append(contact)
        else:
            groups.append([contact])
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

"""Where the energy went: impact, friction, damping, scheme, and what does not add up.

    initial + supplied - lost_impact - lost_friction - lost_damping - lost_scheme - final = unaccounted

Losses are integrated along with the motion (friction, damping, stabilization) or summed over the
impacts; energies are evaluated from the states.  `unaccounted` is therefore a check on both.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.equations import (
    DAMPING_LOSS,
    FRICTION_LOSS,
    STABILIZATION_LOSS,
    STOP_LOSS,
    SUPPLIED,
)
from oblique_impact.marching.loop import Contact, Event

MACRO_GAP = 0.03  # s; contacts closer than this belong to one macro-collision


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

    def as_dict(self) -> dict[str, float]:
        """Return the entries by name."""
        return asdict(self)


def balance(
    initial: float, parts: tuple[float, float, float, float], quadratures: Array, events: list[Event]
) -> Ledger:
    """Close the balance of a run.

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
    """
    final = sum(parts)
    supplied = float(quadratures[SUPPLIED])
    impact = sum(event.energy_loss for event in events if event.kind.impulsive)
    friction = float(quadratures[FRICTION_LOSS])
    damping = float(quadratures[DAMPING_LOSS] + quadratures[STOP_LOSS])
    scheme = float(quadratures[STABILIZATION_LOSS])
    return Ledger(
        initial=initial,
        final=final,
        kinetic=parts[0],
        elastic=parts[1],
        gravity=parts[2],
        contact=parts[3],
        supplied=supplied,
        lost_impact=impact,
        lost_friction=friction,
        lost_damping=damping,
        lost_scheme=scheme,
        unaccounted=initial + supplied - impact - friction - damping - scheme - final,
    )


@dataclass(frozen=True)
class MacroCollision:
    """Contacts less than `MACRO_GAP` apart (SI units)."""

    start: float
    end: float
    contacts: int
    normal_impulse: float
    tangential_impulse: float
    peak_force: float


def macro_collisions(contacts: list[Contact]) -> list[MacroCollision]:
    """Group contacts in order of time; impulses add up, the peak is the largest finite force."""
    groups: list[list[Contact]] = []
    for contact in contacts:
        if groups and contact.start - groups[-1][-1].end < MACRO_GAP:
            groups[-1].append(contact)
        else:
            groups.append([contact])
    return [
        MacroCollision(
            start=group[0].start,
            end=group[-1].end,
            contacts=len(group),
            normal_impulse=sum(c.normal_impulse for c in group),
            tangential_impulse=sum(c.tangential_impulse for c in group),
            peak_force=max(c.peak_force for c in group),
        )
        for group in groups
    ]

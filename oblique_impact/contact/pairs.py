"""Contact pairs: a place of the beam or of a body, and the obstacle that it can touch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

from oblique_impact.contact.stops import ContactLaw


@dataclass(frozen=True)
class ContactPair:
    """One candidate of contact: what touches what, on which stop.

    Attributes
    ----------
    contact_law : ContactLaw, optional
        Law of a compliant stop; then contact begins and ends without an impulse.  Default: a rigid stop.
    extent : tuple of float
        Ends of the obstacle, [first, last] slip in m; empty without ends.
    obstacle : int
        The slope is 0, the others count from 1.
    on_side : bool
        Whether a point of the beam touches a side; else a point of an obstacle touches the beam, and rolls on it
        where it sticks.
    at : float
        Place (m along the beam) of a point of the beam.
    axial : callable, optional
        Axial flexibility (m/N) behind the friction of a contact that begins at a slip (m), and the sense of its
        tangent.  The stop is then rigid, or an :class:`~oblique_impact.contact.stops.ElasticStop` without damping,
        the friction is Coulomb's, and impacts have none.
    behind : bool
        Whether a point of the beam starts behind the line of a side of a solid, but not in this: it meets the side
        only after it has come before it.
    """

    contact_law: ContactLaw | None = None
    extent: tuple[float, ...] = ()
    obstacle: int = 0
    on_side: bool = True
    at: float = 0.0
    axial: Callable[[float], tuple[float, float]] | None = None
    behind: bool = False

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the slip (m), infinite where there are none."""
        return (float(self.extent[0]), float(self.extent[1])) if self.extent else (-inf, inf)

    def is_beyond(self, slip: float) -> bool:
        """Whether a slip (m) is beyond the ends."""
        first, last = self.ends
        return slip < first or slip > last

    def place(self, slip: float) -> float:
        """Return the place (m along the beam) of the contact at its slip (m)."""
        return self.at if self.on_side else -slip

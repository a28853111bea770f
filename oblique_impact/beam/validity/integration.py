"""Warnings about the integration: energy that the scheme took, contact forces that were not unique."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

#: energy lost to a scheme gives a warning above this part of all losses, and above this part of the largest
#: kinetic energy of the run: less than that changes speeds by less than 0.05 %, also where nothing else is lost
NOTICEABLE_SHARE, NEGLIGIBLE_ENERGY = 0.03, 1e-3
#: above this part of the largest kinetic energy the motion is said to be another one, not the losses alone: it
#: changes speeds by 0.5 %
LARGE_SHARE = 1e-2
#: of the parts of the energy: what is lost or unaccounted for below this is rounding
ROUNDING = 1e-9


def energy_warnings(
    energy: Mapping[str, float], largest_kinetic: float, largest_parts: float, scheme: str
) -> list[str]:
    """Return warnings about energy lost to the integration scheme, and about unaccounted energy.

    `energy` is a :class:`~oblique_impact.history.summary.Ledger` as a dictionary, `largest_kinetic` the largest
    kinetic energy of the run (J), `largest_parts` its largest sum of absolute kinetic, elastic and gravity
    energies (J), `scheme` the name of the scheme.
    """
    losses = sum(abs(value) for name, value in energy.items() if name.startswith("lost_"))
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

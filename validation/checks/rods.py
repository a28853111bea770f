"""Elastic rods that strike a rigid wall: force, impulse and return are known in closed form.

A rod's contact is of index 1: with an end without inertia the semi-discrete problem has one solution, without any
damping, and converges.  c = sqrt(E/rho), impedance Z = A sqrt(E rho); while its end is held at the speed v the
wall pushes with Z v, until the wave is back after 2 L/c.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from oblique_impact import GeneralizedAlphaScheme, History, Scheme, simulate_system
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.validation.checks.registry import Measurement, checks_of, within
from oblique_impact.validation.reference_values import VALUES, source
from oblique_impact.validation.small_systems import ElasticRod

check = checks_of("rods", "Elastic rods on a rigid wall")

BAR = VALUES["rod-bouncing-bar"]


def bouncing_bar(elements: int, gravity: float = 10.0) -> ElasticRod:
    """The bar of Doyen, Ern and Piperno: L = 10, E A = 900, rho A = 1 (SI)."""
    rod = ElasticRod(elements, 10.0, 900.0, 1.0)
    rod.gravity = gravity
    return rod


def strike(rod: ElasticRod, speed: float, end_time: float, scheme: Scheme | None = None) -> History:
    """Run the undeformed rod that touches the wall at t = 0 with a speed (m/s).

    By default trapezoidal steps of a fifth of the time that a wave takes through an element.
    """
    step = 0.2 * rod.length / rod.size / rod.wave_speed
    return simulate_system(
        rod,
        rod.at(0.0),
        np.full(rod.size, -speed),
        end_time,
        contact_law=ElasticStop(rod.end_stiffness),
        scheme=scheme or GeneralizedAlphaScheme(step, step, 1.0),
        output_interval=end_time / 100.0,
    )


@check("A bar falls on a wall: force, impulse and release of the first contact, over the elements.", seconds=1.5)
def first_contact() -> Iterator[Measurement]:
    """20, 40 elements; the impulse converges with order 1, so twice the finer less the coarser is much better."""
    text, impulses = source("rod-bouncing-bar"), []
    for elements in (20, 40):
        history = strike(bouncing_bar(elements), 10.0, 0.8)
        (contact,) = history.contacts
        impulses.append(contact.normal_impulse)
        middle = float(history.at(BAR["tau"] / 2.0)["lambda_n"])
        force = f"force in the middle of the contact, {elements} elements"
        yield within(force, middle, BAR["middle"], "N", 1e-3, text, f"middle-{elements}")
    extrapolated = 2.0 * impulses[1] - impulses[0]
    order = float(np.log2((impulses[0] - BAR["impulse"]) / (impulses[1] - BAR["impulse"])))
    yield within("impulse, 40 elements", impulses[1], BAR["impulse"], "N s", 1e-2, text, "impulse")
    yield within("impulse, extrapolated", extrapolated, BAR["impulse"], "N s", 1e-3, text, "extrapolated")
    yield Measurement("order of the impulse", order, 1.0, "1", 0.25, "linear elements with an end without mass")
    yield within("end of the contact, 40 elements", contact.end, BAR["tau"], "s", 4e-2, text, "end")


@check("The bar falls on the wall a second time, and is back where it started.", seconds=15.0)
def return_time() -> list[Measurement]:
    """80 elements: second touch, second impulse, no energy lost and no third contact within a period."""
    rod, text = bouncing_bar(80), source("rod-bouncing-bar")
    history = strike(rod, 10.0, BAR["period"] - 1.0)
    first, second = history.contacts
    energy = history.summary["energy"]
    return [
        Measurement("second touch after the first", second.start, BAR["second"] - 1.0, "s", 6e-3, text, "second"),
        within("second impulse", second.normal_impulse, BAR["impulse"], "N s", 1e-2, text, "second-impulse"),
        within("energy kept", energy["final"], energy["initial"], "J", 7e-13, "no part of it is lost", "energy"),
        Measurement("contacts", len(history.contacts), 2, "1", 0.0, text, "contacts"),
        within("largest force", first.peak_force, BAR["peak"], "N", 0.06, text, "peak"),
    ]

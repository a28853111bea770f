"""A hub with inertia, from none (a pin) to a held root: modes, frames, frequencies, collisions."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from numpy.testing import assert_allclose
from scipy.linalg import eigh

from oblique_impact import Scenario, natural_frequencies, simulate
from oblique_impact.validation.runs import unit_beam


def hub(inertia, radius=0.0):
    return {"kind": "hub", "inertia": inertia, "hub_radius": radius}


# Frequencies: those at rest are the check `frequencies.with-hub` ------------------------------------------------


def ritz(inertia, radius, tip_mass, spin, count):
    """Chordwise and flapwise frequencies of the unit beam with its hub, by polynomials and plain integrals.

    u = (r + x) s + x^2 (...): the hub turns by s.  An arm along the beam of the inertia J_h has, out of the plane,
    the centrifugal potential Omega^2 J_h s^2/2; in the plane the hub has none.
    """
    n, nodes, weights = 12, *np.polynomial.legendre.leggauss(30)
    x, w = 0.5 * (1.0 + nodes), 0.5 * weights
    basis = [Polynomial([radius, 1.0])] + [
        Polynomial([0, 0, 1]) * np.polynomial.Legendre.basis(k, domain=[0, 1]).convert(kind=Polynomial)
        for k in range(n)
    ]
    u, slope, curvature, tip = (
        np.array([p.deriv(k)(at) for p in basis]) for k, at in ((0, x), (1, x), (2, x), (0, 1.0))
    )
    root = np.eye(n + 1)[0]
    mass = (u * w) @ u.T + tip_mass * np.outer(tip, tip)
    tension = radius * (1.0 - x) + 0.5 * (1.0 - x**2) + tip_mass * (1.0 + radius)
    # the hub's arm shortens too: the root moves in by r s^2/2 with all that hangs on it
    arm = radius * (radius + 0.5 + tip_mass * (1.0 + radius))
    centrifugal = (slope * w * tension) @ slope.T + arm * np.outer(root, root)
    bending, own = (curvature * w) @ curvature.T, inertia * np.outer(root, root)
    squares = (
        eigh(bending + spin**2 * (centrifugal - mass), mass + own, eigvals_only=True),
        eigh(bending + spin**2 * (centrifugal + own), mass + own, eigvals_only=True),
    )
    return [np.sqrt(np.maximum(found[:count], 0.0)) for found in squares]


@pytest.mark.parametrize("method", ["modal", "fem"])
@pytest.mark.parametrize(("inertia", "radius"), [(0.0, 0.0), (0.05, 0.0), (0.05, 0.4), (2.0, 1.0)])
def test_a_spinning_beam_with_its_hub(method, inertia, radius):
    scenario = unit_beam(hub(inertia, radius), method=method, elements=32)
    masses = [0.0] if method == "modal" else [0.0, 0.5]
    for tip_mass in masses:
        found = natural_frequencies(scenario.replace(beam__tip_mass=tip_mass), [4.0], 4)
        chordwise, flapwise = ritz(inertia, radius, tip_mass, 4.0, 4)
        rtol = 1e-7 if method == "modal" else 2e-5  # beta^4 h^4/1440 of the third elastic mode
        assert_allclose(found.chordwise[0], chordwise, rtol=rtol, atol=1e-5)
        assert_allclose(found.flapwise[0], flapwise, rtol=rtol)
        assert (found.chordwise[0, 0], found.flapwise[0, 0]) == (0.0, 4.0)


# Collisions -----------------------------------------------------------------------------------------------------

ELASTIC = (
    "gravity=0",
    "contact.normal=spring",
    "contact.stiffness=1e6",
    "contact.friction=frictionless",
    "initial.angle=0.225",
    "initial.angular_velocity=-3.8",
    "solver.output_interval=1e-3",
    "end_time=0.0185",
)
NODAL = ("method=fem", "modes=0", "elements=64", "frame=mean-axis")


def strike(*changes, modes=16, frame="mean-axis"):
    return simulate(
        Scenario.builtin(
            "paper", [*ELASTIC, f"discretization.modes={modes}", f"discretization.frame={frame}", *changes]
        )
    )


def with_hub(inertia):
    return ("root.kind=hub", f"root.inertia={inertia}")


@pytest.mark.parametrize("inertia", [1e-4, 0.02, 1e3])
def test_contacts_converge_to_those_of_the_nodal_model(inertia):
    """Starts and ends of the first contacts on a spring of 1e6 N/m: 8 modes to 1e-5 s, 16 to 5e-7 s."""
    nodal = strike(
        *with_hub(inertia),
        *(f"discretization.{key}" for key in NODAL),
        "solver.scheme=generalized-alpha",
        "solver.free_step=2e-6",
        "solver.contact_step=1e-6",
    )
    expected = [(c.start, c.end) for c in nodal.contacts if c.end < 0.0185]
    assert len(expected) >= 2
    for modes, bound in ((8, 1e-5), (16, 5e-7)):
        found = strike(*with_hub(inertia), modes=modes)
        times = [(c.start, c.end) for c in found.contacts][: len(expected)]
        assert_allclose(times, expected, rtol=0.0, atol=bound)
        assert abs(found.summary["energy"]["unaccounted"]) < 1e-9 * found.summary["energy"]["initial"]


def test_a_hub_without_inertia_is_a_pin():
    """Also where a macro-collision ends, which the lowest elastic frequency decides, and under friction."""
    pin, free = (
        simulate(Scenario.builtin("paper", ["end_time=0.34", "discretization.frame=mean-axis", *root]))
        for root in ((), ("root.kind=hub",))
    )
    assert len(pin.contacts) > 1
    assert pin.contacts == free.contacts
    assert pin.summary["macro_collisions"] == free.summary["macro_collisions"]
    np.testing.assert_array_equal(pin["q"].values, free["q"].values)

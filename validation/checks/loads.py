"""Point masses and forces on a clamped beam: transfer functions and frequencies against closed forms, balances."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.optimize import brentq

from oblique_impact.beam.frequencies import natural_frequencies
from oblique_impact.simulation import compute_history as simulate
from oblique_impact.validation.checks.registry import Measurement, checks_of, within
from oblique_impact.validation.runs import Array, run, unit_beam

check = checks_of("loads", "Masses and forces")

Entries = Sequence[Mapping[str, Any]]

_DAMPING = 2.0  # 1/s, mass-proportional: vibrations decay by half of it
_SETTLED = 23.0  # they have decayed by 1e-10
_PER_PERIOD = 40  # samples
#: all modes of a mesh: fewer would leave 4/(3 pi^4 n^3) of the deflection under a force
_MESH: dict[str, Any] = {"method": "fem", "elements": 20, "modes": 40}
_AMPLITUDE = 1e-3
_TEXT = "exact: transfer matrices of the Euler-Bernoulli beam, with a complex mass for the damping"


def _along(z: complex, x: float) -> Array:
    """Matrix (4, 4) from deflection, slope, moment and shear (of unit stiffness) to those x (m) further on.

    With v'''' = z^4 v; moment v'' and shear v''' (Pestel and Leckie, Matrix Methods in Elastomechanics, 1963).
    """
    cosine, hyperbolic = np.array([np.cos(z * x), np.sin(z * x)]), np.array([np.cosh(z * x), np.sinh(z * x)])
    even, odd = 0.5 * (hyperbolic + cosine), 0.5 * (hyperbolic - cosine)
    first = [even[0], even[1] / z, odd[0] / z**2, odd[1] / z**3]
    rows = [first, [z**4 * first[3], *first[:3]], [z**4 * first[2], z**4 * first[3], *first[:2]]]
    return np.array([*rows, [z**4 * first[1], z**4 * first[2], z**4 * first[3], first[0]]])


def _transfer(w: complex, masses: Entries, force: float, base: float) -> tuple[Array, Array]:
    """Matrix (4, 4) and load (4,) from the root of a clamped unit beam to its end, at exp(i Omega t).

    `w` is the square of the frequency Omega (1/s^2), with damping Omega^2 - i Omega alpha.  A unit force acts at
    `force` (m), none at NaN; a base that is accelerated by `base` (m/s^2) loads mass and point masses with -base.
    A point mass M with the inertia J takes the shear down by M w v, the moment by J w v'.
    """
    matrix, load, at, z = np.eye(4, dtype=complex), np.zeros(4, dtype=complex), 0.0, w**0.25
    points = [(float(m["place"]), m.get("mass", 0.0), m.get("inertia", 0.0), 0.0) for m in masses]
    points += [] if math.isnan(force) else [(force, 0.0, 0.0, 1.0)]
    # on a base v'''' = w v - base, whose particular solution is v = base/w
    steady = np.array([base / w, 0.0, 0.0, 0.0])
    for place, mass, inertia, unit in sorted([*points, (1.0, 0.0, 0.0, 0.0)]):
        step = _along(z, place - at)
        matrix, load, at = step @ matrix, step @ (load - steady) + steady, place
        jump = np.eye(4, dtype=complex)
        jump[3, 0], jump[2, 1] = w * mass, -w * inertia
        matrix, load = jump @ matrix, jump @ load + np.array([0.0, 0.0, 0.0, unit - mass * base])
    return matrix, load


def tip_response(
    Omega: float, masses: Entries = (), force: float = math.nan, base: float = 0.0, damping: float = _DAMPING
) -> complex:
    """Deflection of the end of a clamped unit beam at exp(i Omega t), of a unit force or of a base, exactly."""
    matrix, load = _transfer(Omega * Omega - 1j * Omega * damping, masses, force, base)
    of_root = np.linalg.solve(matrix[2:, 2:], -load[2:])  # moment and shear there
    return complex(matrix[0, 2:] @ of_root + load[0])


def secular(Omega: float, masses: Entries) -> float:
    """Return what vanishes at the frequencies (rad/s) of a clamped unit beam with point masses."""
    matrix, _ = _transfer(complex(Omega * Omega), masses, math.nan, 0.0)
    return float(np.linalg.det(matrix[2:, 2:]).real)


def frequencies(masses: Entries, count: int) -> Array:
    """First frequencies (rad/s) of a clamped unit beam with point masses, by its secular equation."""
    grid = np.linspace(0.05, 8.0, 4000) ** 2
    values = [secular(Omega, masses) for Omega in grid]
    ends = [k for k in range(grid.size - 1) if values[k] * values[k + 1] < 0.0][:count]
    return np.array([brentq(secular, grid[k], grid[k + 1], args=(masses,), xtol=1e-13) for k in ends])


def _steady_tip(Omega: float, changes: Mapping[str, Any], steps: int = 0, **shapes: Any) -> complex:
    """Deflection of the tip in steady state over the amplitude of what shakes it, from a start at rest.

    By so many implicit steps from sample to sample, if their number is given.
    """
    period = 2.0 * math.pi / Omega
    implicit = {"solver__scheme": "generalized-alpha", "solver__rho_infinity": 1.0}
    scenario = unit_beam({"kind": "driven"}, **shapes).replace(
        **(implicit | {"solver__free_step": period / _PER_PERIOD / steps} if steps else {}),
        gravity=0.0,
        end_time=math.ceil(_SETTLED / period) * period,
        beam__mass_proportional=_DAMPING,
        initial__angle=0.0,
        solver__output_interval=period / _PER_PERIOD,
        **changes,
    )
    history = simulate(scenario)
    last = slice(-_PER_PERIOD - 1, -1)
    time, tip = history["time"].values[last], history["uy"].values[last, -1]
    # of a whole period, in which sines and cosines are orthogonal
    return complex(2.0 / _PER_PERIOD * np.sum(tip * np.exp(-1j * Omega * time)) * 1j / _AMPLITUDE)


def _against(found: complex, exact: complex, label: str, name: str, allowed: float) -> Iterator[Measurement]:
    """Compare amplitude and phase."""
    yield within(f"amplitude {label}", abs(found), abs(exact), "m/N", allowed, _TEXT, name)
    phases = float(np.angle(found)), float(np.angle(exact))
    yield Measurement(f"phase {label}", *phases, "rad", allowed, _TEXT, f"phase-{name}")


#: at the tip, and inside of the span with its direction fixed in space: in the linear limit the same
_FORCES: dict[str, tuple[float, str | float]] = {
    "tip": (1.0, "across"),
    "inside": (0.37, "across"),
    "fixed": (0.37, math.pi / 2.0),
}
_HEAVY: Entries = ({"place": 0.37, "mass": 0.5, "inertia": 0.02}, {"place": 1.0, "mass": 0.3, "inertia": 0.01})


def _shaken(Omega: float, place: float, direction: str | float) -> dict[str, Any]:
    """Return the keys of a harmonic force."""
    frequency = Omega / (2.0 * math.pi)
    return {"forces": [{"place": place, "force": _AMPLITUDE, "frequency": frequency, "direction": direction}]}


@check(
    "A clamped, damped beam under a harmonic force at its tip or inside of its span, in steady state.", seconds=8.0
)
def transfer_function() -> Iterator[Measurement]:
    """Amplitude and phase of the tip by reduced elements and event-located steps, with masses on it too."""
    for name, (place, direction) in _FORCES.items():
        for Omega, masses in ((3.4, ()), (6.0, ()), (1.9, _HEAVY)):
            if masses and name == "fixed":
                continue
            changes = _shaken(Omega, place, direction) | ({"masses": list(masses)} if masses else {})
            found = _steady_tip(Omega, changes, **_MESH)
            label = f"of the tip at {Omega:g} rad/s, force {name}{', with masses' if masses else ''}"
            yield from _against(found, tip_response(Omega, masses, place), label, f"{name}-{Omega:g}", 1e-6)


@check("A clamped, damped beam with a mass at its tip on a shaken base, in steady state.", seconds=1.5)
def base_with_masses() -> Iterator[Measurement]:
    """Amplitude and phase of the tip by reduced elements and event-located steps."""
    base = {"base__acceleration": _AMPLITUDE, "base__frequency": 1.9 / (2.0 * math.pi)}
    for name, masses in (("tip-mass", _HEAVY[1:]), ("masses", _HEAVY)):
        changes = base | {"masses": list(masses)}
        found = _steady_tip(1.9, changes, **_MESH)
        exact = tip_response(1.9, masses, base=1.0)
        yield from _against(found, exact, f"of the tip at 1.9 rad/s, {name}", name, 1e-6)


@check("The same force on all nodes of a mesh by implicit steps, and on modes of the uniform beam.", seconds=0.8)
def orders() -> Iterator[Measurement]:
    """All nodes by the mid-point rule, extrapolated; n modes leave the static deflection of all further ones."""
    exact = tip_response(3.4, force=0.37)
    changes = _shaken(3.4, 0.37, "across")
    coarse, fine = (_steady_tip(3.4, changes, steps, method="fem", modes=0, elements=32) for steps in (4, 8))
    order = math.log2(abs(coarse - exact) / abs(fine - exact))
    label = "of the tip at 3.4 rad/s, 32 elements in all nodes"
    yield from _against((4.0 * fine - coarse) / 3.0, exact, f"{label}, extrapolated", "nodes", 1e-6)
    text = "implicit mid-point rule"
    yield Measurement(f"order over the step, {label}", order, 2.0, "1", 0.01, text, "nodes-order")
    # far below the first frequency of 3.5 rad/s, where the force is all but static
    slow, text = 0.02, "4/b^4 summed over cos b cosh b = -1, b = (k - 1/2) pi beyond the fourth"
    for count in (4, 8):
        left = 4.0 * float(np.sum(((np.arange(count + 1, 10_000) - 0.5) * math.pi) ** -4.0))
        found = abs(_steady_tip(slow, _shaken(slow, 1.0, "across"), method="modal", modes=count))
        gap = abs(tip_response(slow, force=1.0)) - found
        yield within(
            f"what {count} modes leave under a force at the tip", gap, left, "m/N", 1e-2, text, f"{count}"
        )


@check("Frequencies of a clamped beam with a mass and its inertia at the tip.")
def tip_mass() -> Iterator[Measurement]:
    """The first three, by elements, by all nodes of a mesh, and of a beam in modes."""
    mass, inertia = 0.3, 0.01

    def equation(b: float) -> float:
        c, s, ch, sh = math.cos(b), math.sin(b), math.cosh(b), math.sinh(b)
        of_mass, of_inertia = mass * b * (c * sh - s * ch), inertia * b**3 * (ch * s + sh * c)
        return 1.0 + c * ch + of_mass - of_inertia + mass * inertia * b**4 * (1.0 - c * ch)

    text = "secular equation, Blevins, Formulas for Natural Frequency and Mode Shape, 1979, Table 8-8"
    grid = np.linspace(0.1, 9.0, 2000)
    ends = [k for k in range(grid.size - 1) if equation(grid[k]) * equation(grid[k + 1]) < 0.0][:3]
    exact = [brentq(equation, grid[k], grid[k + 1], xtol=1e-14) ** 2 for k in ends]
    masses = [{"mass": mass, "inertia": inertia}]
    for method, shapes in (("fem", {"elements": 64, "modes": 4}), ("modal", {"modes": 4})):
        beam = unit_beam({"kind": "driven"}, method=method, **shapes).replace(masses=masses)
        for n, (found, reference) in enumerate(
            zip(natural_frequencies(beam).chordwise[0], exact, strict=False), start=1
        ):
            yield within(f"frequency {n}, {method}", found, reference, "rad/s", 2e-7, text, f"{method}-{n}")


@check("Elements with masses inside of the span converge with the fourth power of their size.")
def order_of_elements() -> Iterator[Measurement]:
    """Of the first three frequencies of a beam with two masses that have inertias, at no even part of it."""
    exact, errors = frequencies(_HEAVY, 3), []
    for elements in (27, 54):  # 10 and 17 on the two sides of 0.37 m, and twice as many
        beam = unit_beam({"kind": "driven"}, method="fem", elements=elements, modes=4)
        found = natural_frequencies(beam.replace(masses=list(_HEAVY)), count=3).chordwise[0]
        errors.append(np.abs(found / exact - 1.0))
    for n in range(3):
        order = float(np.log2(errors[0][n] / errors[1][n]))
        yield Measurement(f"order of frequency {n + 1}", order, 4.0, "1", 0.2, _TEXT, f"order-{n + 1}")
        yield Measurement(
            f"error of frequency {n + 1}, 54 elements", errors[1][n], 0.0, "1", 5e-6, _TEXT, f"{n + 1}"
        )


#: one force of each kind, and masses, on the paper's beam in flight
_LOADED = (
    "contact.enabled=false",
    "end_time=0.3",
    "masses=[{place=0.6,mass=0.3,inertia=0.01},{mass=0.1,inertia=0.02}]",
    "forces=[{place=0.6,force=3,frequency=5,sweep_rate=20},{force=2,direction=0.3},"
    "{place=0.3,table=[[0,0],[0.05,8],[0.1,0]]}]",
)
_STEPS = ("solver.rho_infinity=1", "solver.free_step=1e-4")
_RUNS: dict[str, tuple[tuple[str, ...], float]] = {
    "modes": ((), 1e-10),
    "mean axis, full kinetics": (("discretization.frame=mean-axis", "discretization.kinetics=full"), 1e-10),
    "elements": (("discretization.method=fem", "discretization.modes=4"), 1e-10),
    "a held root": (("root.kind=driven", "discretization.method=fem"), 1e-10),
    "a hub": (("root.kind=hub", "root.inertia=0.02", "root.hub_radius=0.1"), 1e-10),
    "fixed steps": (("solver.scheme=fixed-step",), 1e-7),
    "time-stepping, all nodes": (("discretization.method=fem", "discretization.modes=0", *_STEPS[1:]), 1e-7),
}


@check(
    "The energy ledger closes with masses and each kind of force, in every discretization and scheme.", seconds=2.0
)
def ledger() -> Iterator[Measurement]:
    """Energy that no entry explains, of some 3 J; of all nodes by the mid-point rule it falls with the step."""
    text = "conservation of energy: initial + supplied - lost = final"
    for name, (keys, tolerance) in _RUNS.items():
        scheme = ("solver.scheme=time-stepping",) if name.startswith("time-stepping") else ()
        energy = run("paper", *_LOADED, *keys, *scheme).summary["energy"]
        tail = name.replace(", ", "-").replace(" ", "-")
        yield Measurement(f"unaccounted energy, {name}", energy["unaccounted"], 0.0, "J", tolerance, text, tail)
    nodes = ("discretization.method=fem", "discretization.modes=0", "solver.rho_infinity=1")
    coarse, fine = (
        abs(run("paper", *_LOADED, *nodes, f"solver.free_step={step}").summary["energy"]["unaccounted"])
        for step in (2e-4, 1e-4)
    )
    order = math.log2(coarse / fine)
    yield Measurement("order of the ledger, generalized-alpha, all nodes", order, 2.0, "1", 0.1, text, "order")

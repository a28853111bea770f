"""Frequencies of spinning beams, out of the plane of rotation and in it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from itertools import product

import numpy as np
from scipy.linalg import eigh

from oblique_impact.beam.beam import Beam, FullBeam
from oblique_impact.beam.operators import SpinningBeam, build_operators, discretization
from oblique_impact.validation.checks.plots import campbell_figure
from oblique_impact.validation.checks.registry import Evidence, Measurement, checks_of
from oblique_impact.validation.reference_values import VALUES, source
from oblique_impact.validation.runs import EPS, unit_beam

check = checks_of("spinning", "Spinning beams")

_ITEMS = [item for item in VALUES if item.startswith("2-")]
_ELEMENTS = 64
#: relative: 48 eigenfunctions at a spin of 6, where the tension couples those of a clamped beam (what is left out
#: enters with its square), and those of a hinged one hardly; (b h)⁴/1440 of the fourth mode of 64 elements
_ACCURACY = {"modal": {"c": 1e-8, "h": 0.0}, "fem": {"c": 1e-6, "h": 1e-6}}
_UNIT = "sqrt(EI/(m L⁴))"
_NAMES = {"modal": "48 assumed modes", "fem": f"{_ELEMENTS} elements"}


@cache
def _beam(root: str, radius: float, method: str) -> SpinningBeam:
    held = {"kind": "pin"} if root == "h" else {"kind": "driven", "hub_radius": radius}
    mesh = {"elements": _ELEMENTS} if method == "fem" else {}
    found = discretization(method).spectrum(unit_beam(held, method=method, **mesh))
    assert isinstance(found, SpinningBeam)
    return found


def _row(item: str) -> tuple[str, float, float]:
    """Root, hub radius and spin rate of a reference row."""
    _, root, radius, eta = item.split("-")
    return root, float(radius[1:]), float(eta[3:])


def _worst(item: str, method: str, direction: str) -> Measurement:
    root, radius, eta = _row(item)
    beam = _beam(root, radius, method)
    exact = np.array(VALUES[item][direction])
    computed = (beam.flapwise if direction == "flap" else beam.chordwise)(eta, exact.size)
    # the tension at the root is eta² (1 + 2 radius)/2
    growth = ((eta / 6.0) ** 2 * (1.0 + 2.0 * radius)) ** 2 if method == "modal" else 1.0
    # references have 12 digits
    allowed = _ACCURACY[method][root] * growth * exact + 1e-11 * np.maximum(exact, 1.0)
    k = int(np.argmax(np.abs(computed - exact) / allowed))
    held = {"c": "clamped", "h": "hinged"}[root]
    quantity = f"{direction}wise frequency {k + 1}, {held}, hub {radius:g} L, spin {eta:g}, {_NAMES[method]}"
    name = f"{method}-{direction}-{item[2:]}"
    return Measurement(quantity, computed[k], exact[k], _UNIT, allowed[k], source(item), name)


@check("Flapwise frequencies of beams spinning at up to six times sqrt(EI/(m L⁴)).", seconds=0.5)
def flapwise() -> Evidence:
    """The worst of up to four frequencies for each row and method, and a Campbell diagram."""
    found = [_worst(item, method, "flap") for item in _ITEMS for method in _NAMES]
    beams = {root: _beam(root, 0.0, "modal") for root in ("c", "h")}
    return Evidence(found, [campbell_figure(beams, [(_row(item), VALUES[item]) for item in _ITEMS])])


@check(
    "Chordwise frequencies of the same beams: the centrifugal stiffness less the spin's softening.", seconds=0.5
)
def chordwise() -> list[Measurement]:
    """The worst of up to four frequencies for each row and method."""
    return [_worst(item, method, "chord") for item in _ITEMS for method in _NAMES]


#: relative accuracy of three frequencies by eight modes: clamped shapes converge slowly for a pin, hinged ones
#: fast; in full kinetics, whose forces are cubic, the step of the differences errs
_FREE_ACCURACY = {
    ("tangent", "first-order"): (1.5e-7, 1.5e-5, 3e-5),
    ("tangent", "full"): (1.5e-7, 1.5e-5, 3e-5),
    ("mean-axis", "first-order"): (8e-10, 8e-9, 4e-8),
    ("mean-axis", "full"): (1e-7, 1e-7, 1e-7),
}


@check(
    "A pinned beam that spins freely, by the forces that are marched: their slope at a steady spin.", seconds=0.5
)
def free_spin() -> Iterator[Measurement]:
    """Zero eigenvalue and hinged chordwise frequencies in both frames; C - M1 has the rigid rotation as a mode."""
    exact, text = VALUES["2-h-d0-eta5"]["chord"][1:], source("2-h-d0-eta5")
    rotation = "exact: a rigid rotation x has C x = M1 x and K x = 0"
    for frame, kinetics in product(("tangent", "mean-axis"), ("first-order", "full")):
        squares, rounding = _free_squares(frame, kinetics)
        label, where = f"{frame}-{kinetics}", f"{frame} frame, {kinetics}"
        quantity, name = f"square of the lowest frequency, {where}", f"rigid-{label}"
        yield Measurement(quantity, squares[0], 0.0, "EI/(m L⁴)", rounding, rotation, name)
        for k, accuracy in enumerate(_FREE_ACCURACY[frame, kinetics]):
            frequency, allowed = float(np.sqrt(squares[k + 1])), accuracy * exact[k]
            quantity, name = f"frequency {k + 1} in the plane, {where}", f"elastic-{label}-{k + 1}"
            yield Measurement(quantity, frequency, exact[k], _UNIT, allowed, text, name)


def _free_squares(frame: str, kinetics: str, eta: float = 5.0, modes: int = 8) -> tuple[np.ndarray, float]:
    """Squares of the frequencies about a steady spin, from differences of the forces, and their rounding."""
    scenario = unit_beam(method="modal", frame=frame, kinetics=kinetics, modes=modes).replace(gravity=0.0)
    step = 1e-4
    model, size = Beam(scenario, build_operators(scenario)).model, modes + 1
    qd, work, slopes = np.zeros(size), model.new_workspace(), np.zeros((size, size))
    qd[0] = eta
    for k in range(size):
        for sign in (1.0, -1.0):
            q = np.zeros(size)
            q[k] = sign * step
            model.evaluate(0.0, q, qd, work)
            slopes[:, k] += sign * work.forces / (2.0 * step)
    model.evaluate(0.0, np.zeros(size), qd, work)
    # the spin couples to the elastic coordinates by Coriolis forces at second order only
    squares = np.linalg.eigvals(np.linalg.solve(work.mass, -0.5 * (slopes + slopes.T)))
    ordered = np.sort(squares.real)
    return ordered, float(EPS * ordered[-1])


@check("A beam in all its nodes that is turned at a constant rate, by the forces that are marched.", seconds=0.5)
def driven_nodes() -> Iterator[Measurement]:
    """The worst of the chordwise frequencies of the clamped rows, of 64 elements."""
    for item in _ITEMS:
        root, radius, eta = _row(item)
        if root == "c":
            exact = np.array(VALUES[item]["chord"])
            computed = np.sqrt(_driven_squares(radius, eta)[: exact.size])
            allowed = _ACCURACY["fem"]["c"] * exact + 1e-9
            k = int(np.argmax(np.abs(computed - exact) / allowed))
            quantity = (
                f"chordwise frequency {k + 1}, hub {radius:g} L, spin {eta:g}, {_ELEMENTS} elements in all nodes"
            )
            yield Measurement(
                quantity, computed[k], exact[k], _UNIT, allowed[k], source(item), f"nodes-{item[2:]}"
            )


def _driven_squares(radius: float, eta: float) -> np.ndarray:
    """Squares of the frequencies about a steady spin of a driven root, ascending; by differences of the forces."""
    root = {"kind": "driven", "hub_radius": radius, "profile": "constant-speed", "spin_rate": eta}
    scenario = unit_beam(root, method="fem", modes=0, elements=_ELEMENTS).replace(gravity=0.0)
    beam = FullBeam(scenario, discretization("fem").build_nodal(scenario))
    size, step, work = beam.size, 1e-4, beam.model.new_workspace()
    slopes, mass = np.zeros((size, size)), np.zeros((size, size))
    spin = eta * beam.operators.rigid
    for k, unit in enumerate(np.eye(size)):
        for sign in (1.0, -1.0):
            beam.model.evaluate(0.0, sign * step * unit, spin, work)
            slopes[:, k] += sign * work.forces / (2.0 * step)
        beam.model.mass_product(0.0, work, unit, mass[:, k])
    # 1/omega^2 loses least of the lowest frequencies to rounding; the first coordinate is prescribed
    stiffness = -0.5 * (slopes + slopes.T)[1:, 1:]
    return np.asarray(1.0 / eigh(mass[1:, 1:], stiffness, eigvals_only=True)[::-1])

"""Frequencies of uniform beams and the errors of finite elements."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq

from oblique_impact import fem_beam, modal
from oblique_impact.beam.frequencies import natural_frequencies
from oblique_impact.modal import clamped_free_roots, hinged_free_roots
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.checks.registry import ROUNDING, Measurement, checks_of, within
from oblique_impact.validation.reference_values import VALUES, source
from oblique_impact.validation.runs import EPS, unit_beam
from oblique_impact.vibration import frequencies_at_rest

check = checks_of("frequencies", "Beam frequencies and their h⁴ constants")

_ROOTS = {"clamped": np.array(VALUES["1.1"]), "hinged": np.array(VALUES["1.2"])}
_FRAMES = {"clamped": "tangent", "hinged": "mean-axis"}
_MODES = 60


def _roots(name: str, roots: np.ndarray, item: str) -> list[Measurement]:
    exact, text = VALUES[item], source(item)
    # two units in the last place of a simple root, and as much for another processor
    accuracy = 8.0 * EPS
    return [
        within(f"root {k} of the {name} beam", roots[k - 1], exact[k - 1], "1", accuracy, text, f"root-{k}")
        for k in (1, 2, 5, 10)
    ]


@check("A clamped-free uniform beam: the roots of cos b cosh b = -1.")
def clamped_free() -> list[Measurement]:
    """Roots of the frequency equation."""
    return _roots("clamped-free", clamped_free_roots(10), "1.1")


@check("A hinged-free uniform beam: the roots of tan b = tanh b.")
def hinged_free() -> list[Measurement]:
    """Roots of the frequency equation."""
    return _roots("hinged-free", hinged_free_roots(10), "1.2")


@check("Sixty eigenfunctions are orthogonal: M1 = m L 1 and K = (E I/L³) diag b⁴.", seconds=0.3)
def orthogonality() -> Iterator[Measurement]:
    """Largest entry of the normalized matrices off the unit matrix, for L = 2.5, m = 3, E I = 7."""
    length, density, modulus = 2.5, 3.0, 7.0
    text = "orthogonality of eigenfunctions scaled to int phi^2 = L (Rayleigh)"
    for family, frame in _FRAMES.items():
        scenario = unit_beam(frame=frame, modes=_MODES)
        changes = {"beam__length": length, "beam__density": density, "beam__youngs_modulus": modulus}
        o = modal.build_operators(scenario.replace(**changes))
        roots = (clamped_free_roots if family == "clamped" else hinged_free_roots)(_MODES)
        mass, stiffness = o.M1 / (density * length), o.K * length**3 / modulus / np.outer(roots, roots) ** 2
        for name, matrix in (("mass", mass), ("stiffness", stiffness)):
            off = float(np.abs(matrix - np.eye(_MODES)).max())
            quantity = f"{name}, {family}-free: largest deviation"
            yield Measurement(quantity, off, 0.0, "1", 2.0 * ROUNDING, text, f"{name}-{family}")


def _with_hub(inertia: float, radius: float, count: int) -> np.ndarray:
    """Roots b of the unit beam with its hub: zeros of the determinant of its four boundary conditions."""

    def determinant(b: float) -> float:
        c, s, ch, sh = np.cos(b), np.sin(b), np.cosh(b), np.sinh(b)
        slope, third = np.array([0.0, 1.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0, 1.0])
        rows = [
            np.array([1.0, 0.0, 1.0, 0.0]) - radius * b * slope,  # w = r w_x
            np.array([-1.0, 0.0, 1.0, 0.0]) - radius * b * third + inertia * b**3 * slope,  # moment of the hub
            np.array([-c, -s, ch, sh]) / ch,
            np.array([s, -c, sh, ch]) / ch,
        ]
        return float(np.linalg.det(rows))

    places = np.arange(0.1, 1.3 * np.pi * (count + 1), 0.1)
    signs = np.sign([determinant(b) for b in places])
    found = [
        brentq(determinant, places[k], places[k + 1], xtol=1e-14, rtol=1e-14)
        for k in np.flatnonzero(signs[1:] != signs[:-1])
    ]
    return np.array(found[:count])


@check(
    "A beam that is free to turn with its hub, whose inertia goes from none, a pin, to a held root's.", seconds=0.5
)
def with_hub() -> Iterator[Measurement]:
    """The worst of three elastic frequencies for each hub; inertias in m L³, radii in L."""
    text = "zeros of the determinant of the four boundary conditions, by bisection"
    for inertia, radius in ((0.0, 0.0), (1e-4, 0.0), (0.02, 0.0), (1.0, 0.0), (1e3, 0.0), (0.02, 0.3), (1.0, 2.0)):
        roots = _with_hub(inertia, radius, 3)
        root = {"kind": "hub", "inertia": inertia, "hub_radius": radius}
        # the determinant gives some 14 digits; elements err by about (b h)⁴/1440
        bounds = {"modal": np.full(3, 2e-13), "fem": 1.5 * VALUES["1.3"] * (roots / 32) ** 4}
        for method, bound in bounds.items():
            scenario = unit_beam(root, method=method, elements=32)
            computed, exact = natural_frequencies(scenario, count=4).chordwise[0, 1:], roots**2
            k = int(np.argmax(np.abs(computed / exact - 1.0) / bound))
            quantity = f"frequency {k + 1}, hub of {inertia:g} m L³ at {radius:g} L, {method}"
            name, allowed = f"{method}-{inertia:g}-{radius:g}", float(bound[k])
            yield within(quantity, computed[k], exact[k], "sqrt(EI/(m L⁴))", allowed, text, name)


def _on_spring(stiffness: float, count: int) -> np.ndarray:
    """Roots b of the unit beam on a spring at its root, each between a hinged and a clamped one.

    On a soft spring the first two terms of the lowest, b^4 = 3 k (1 - 33 k/140), for which no digits cancel.
    """

    def value(b: float) -> float:
        s, c, th, sech = np.sin(b), np.cos(b), np.tanh(b), 1.0 / np.cosh(b)
        return float(b * (s - c * th) - stiffness * (c + sech))

    clamped, hinged = clamped_free_roots(count), np.append(1e-3, hinged_free_roots(count - 1))
    found = np.array([brentq(value, a, b, xtol=1e-15, rtol=1e-15) for a, b in zip(hinged, clamped, strict=True)])
    if stiffness < 1e-4:
        found[0] = (3.0 * stiffness * (1.0 - 33.0 / 140.0 * stiffness)) ** 0.25
    return found


@check("A beam on the spring of its clamp, which goes from none, a pin, to a rigid clamp's.", seconds=0.5)
def on_a_spring() -> Iterator[Measurement]:
    """The worst of four frequencies for each spring, in E I/L; without one the first is the swing."""
    text = "k (1 + cos b cosh b) = b (sin b cosh b - cos b sinh b), by bisection"
    for stiffness in (1e-6, 1e-2, 1.0, 1e2, 1e4, 1e8):
        roots = _on_spring(stiffness, 4)
        root = {"kind": "driven", "stiffness": stiffness}
        # of the difference sin b cosh b - cos b sinh b at the lowest root of 1e-2 some 13 digits are left
        of_elements = 1e-12 + 1.5 * VALUES["1.3"] * (roots / 32) ** 4
        of_nodes = of_elements + 1e-9 + 5.0 * EPS * 12.0 * 32**3 / stiffness  # entries 12 E I/h³ are rounded
        for method, bound in (("modal", np.full(4, 1e-12)), ("fem", of_elements), ("nodes", of_nodes)):
            if method == "nodes":
                computed = _of_nodes(unit_beam(root, method="fem", modes=0, elements=32))
            else:
                scenario = unit_beam(root, method=method, elements=32)
                computed = natural_frequencies(scenario, count=4).chordwise[0]
            k = int(np.argmax(np.abs(computed / roots**2 - 1.0) / bound))
            quantity, name = (
                f"frequency {k + 1}, spring of {stiffness:g} E I/L, {method}",
                f"{method}-{stiffness:g}",
            )
            yield within(quantity, computed[k], roots[k] ** 2, "sqrt(EI/(m L⁴))", float(bound[k]), text, name)


@check("A clamped beam that rests on a spring or a rigid stop at its tip: `modes --closed`.", seconds=3.0)
def at_rest() -> Iterator[Measurement]:
    """The worst of three frequencies for each stop, in E I/L³, pressed in by a millionth of the length."""
    text = "b³ (1 + cos b cosh b) = k (cos b sinh b - sin b cosh b), rigid tan b = tanh b, by bisection"
    clamped, propped = clamped_free_roots(4), hinged_free_roots(3)
    for stiffness in (1.0, 1e2, 1e4, np.inf):

        def value(b: float, k: float = stiffness) -> float:
            s, c, th, sech = np.sin(b), np.cos(b), np.tanh(b), 1.0 / np.cosh(b)
            return float(b**3 * (sech + c) - k * (c * th - s))

        roots = propped
        if stiffness < np.inf:
            roots = np.array([brentq(value, *ends, xtol=1e-14) for ends in zip(clamped, propped, strict=False)])
        stop = {} if stiffness == np.inf else {"contact__normal": "spring", "contact__stiffness": stiffness}
        of_elements = 1e-9 + 1.5 * VALUES["1.3"] * (roots / 32) ** 4
        base = unit_beam({"kind": "driven"}, method="fem", modes=0, elements=32)
        scenario = base.adapted(
            (),
            gravity=0.0,
            initial__angle=0.0,
            initial__state="equilibrium",
            contact__enabled=True,
            contact__friction="frictionless",
            slope__origin=[1.0, 1e-6],
            slope__angle=0.0,
            **stop,
        )
        computed = frequencies_at_rest(scenario, 3).frequencies
        k = int(np.argmax(np.abs(computed / roots**2 - 1.0) / of_elements))
        name = "rigid" if stiffness == np.inf else f"{stiffness:g}"
        quantity = f"frequency {k + 1}, stop {name}, all nodes of 32 elements"
        yield within(quantity, computed[k], roots[k] ** 2, "sqrt(EI/(m L⁴))", float(of_elements[k]), text, name)


def _of_nodes(scenario: Scenario) -> np.ndarray:
    """Return frequencies of the matrices of a full nodal model on a clamp that yields, its drive held."""
    o = fem_beam.build_nodal(scenario)
    mass, stiffness = (matrix.toarray()[1:, 1:] for matrix in (o.M1, o.stiffness))
    return np.asarray(1.0 / np.sqrt(eigh(mass, stiffness, eigvals_only=True)[:-5:-1]))


def _errors(root: str, elements: int) -> np.ndarray:
    scenario = unit_beam(method="fem", frame=_FRAMES[root], modes=3, elements=elements)
    return np.asarray(fem_beam.build_operators(scenario).natural_frequencies() / _ROOTS[root][:3] ** 2 - 1.0)


@check(
    "Hermite elements against the same elements in 40-digit arithmetic: errors of three frequencies.", seconds=0.3
)
def element_errors() -> Iterator[Measurement]:
    """Relative frequency errors of uniform meshes."""
    for key, root in (("c4", 0), ("c8", 0), ("c16", 0), ("c32", 0), ("h8", 1), ("h16", 1)):
        kind = ("clamped", "hinged")[root]
        computed, exact = _errors(kind, int(key[1:])), np.array(VALUES[f"1.4-{key}"])
        k = int(np.argmax(np.abs(computed - exact)))
        quantity = f"relative frequency error, {kind}, {key[1:]} elements, mode {k + 1}"
        # the error is a small difference: what rounding leaves is a part of the frequency itself
        yield Measurement(quantity, computed[k], exact[k], "1", ROUNDING, source(f"1.4-{key}"), key)


@check("The banded matrices of the full nodal model have the same frequency errors.", seconds=0.3)
def nodal_matrices() -> Iterator[Measurement]:
    """Pinned beam of 8 and 16 elements: K and M1 as the implicit scheme has them."""
    for elements in (8, 16):
        scenario = unit_beam(method="fem", frame="mean-axis", modes=0, elements=elements)
        o = fem_beam.build_nodal(scenario)
        # the largest eigenvalues of a dense problem lose least to rounding: those of the inverse, 1/(1 + w²)
        inverse = eigh(o.M1.toarray(), (o.K + o.M1).toarray(), eigvals_only=True)[::-1]
        computed = np.sqrt(1.0 / inverse[1:4] - 1.0) / _ROOTS["hinged"][:3] ** 2 - 1.0
        item = f"1.4-h{elements}"
        exact = np.array(VALUES[item])
        k = int(np.argmax(np.abs(computed - exact)))
        quantity = f"relative frequency error, {elements} elements, mode {k + 1}"
        # rounding, as much again of the entries of K, which are 10⁵ times the square of the frequency
        allowed = 5.0 * ROUNDING
        yield Measurement(quantity, computed[k], exact[k], "1", allowed, source(item), f"{elements}")


@check("Frequency errors of Hermite elements fall with h⁴, with the constant (b h)⁴/1440.", seconds=0.3)
def order_four() -> Iterator[Measurement]:
    """Observed orders and constants of three modes of both beams."""
    for root in _FRAMES:
        coarse, fine = _errors(root, 16), _errors(root, 32)
        orders = np.log2(coarse / fine)
        worst = int(np.argmax(np.abs(orders - 4.0)))
        quantity = f"observed order between 16 and 32 elements, {root}, mode {worst + 1}"
        text = "interpolation of cubics: order 4 (Strang and Fix 1973)"
        yield Measurement(quantity, orders[worst], 4.0, "1", 0.1, text, f"order-{root}")
        for k in range(3):
            b = _ROOTS[root][k] / 32
            constant, name = float(fine[k] / b**4), f"constant-{root}-{k + 1}"
            quantity = f"error/(b h)⁴ at 32 elements, {root}, mode {k + 1}"
            # the next term is a tenth of (b h)^2
            yield within(quantity, constant, VALUES["1.3"], "1", 0.2 * b**2, source("1.3"), name)

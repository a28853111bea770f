"""Beams that bend under their own weight, and the falling chimney."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from oblique_impact.beam.beam import Beam
from oblique_impact.beam.operators import BeamOperators, build_operators
from oblique_impact.beam.section_forces import Fields, Motion, fields_along
from oblique_impact.beam_problem import beam_of
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import compute_history as simulate
from oblique_impact.validation.checks.registry import Measurement, checks_of, within
from oblique_impact.validation.reference_values import VALUES, source
from oblique_impact.validation.runs import Array

check = checks_of("statics", "Statics")


MASS, BENDING, GRAVITY = 0.86874, 541.27, 9.8
_MODAL, _FEM = {"method": "modal", "modes": 40}, {"method": "fem", "modes": 32, "elements": 16}
_NODES = {"method": "fem", "modes": 0, "elements": 16}
_SOURCES = {"modal": _MODAL, "fem": _FEM, "nodes": _NODES}
#: relative, of deflections: what forty modes leave out of their sum; elements are exact at nodes, where references
#: have 12 digits
_ACCURACY = {"modal": 4e-9, "fem": 1.5e-11, "nodes": 1.5e-11}


def _cantilever(angle: float, shapes: dict[str, Any], bending: float = BENDING, **changes: Any) -> Scenario:
    return Scenario.from_dict(
        {
            "gravity": GRAVITY,
            "beam": {
                "area": 1.0,
                "density": MASS,
                "youngs_modulus": bending,
                "second_moment": 1.0,
                **changes.pop("beam", {}),
            },
            "root": {"kind": "driven", "profile": "hold"},
            "initial": {"angle": angle},
            "contact": {"enabled": False},
            "discretization": shapes,
            **changes,
        }
    )


def _at_rest(scenario: Scenario) -> tuple[float, Fields]:
    """Tip deflection and section forces of the static beam, (K - g sin D) B = -g cos P."""
    beam, angle = beam_of(scenario), scenario.initial.angle
    o, held = beam.operators, 1 if scenario.is_nodal else 0  # the root's slope, the first of all nodes
    stiffness = np.asarray((o.K - GRAVITY * np.sin(angle) * o.D) @ np.eye(o.size))[held:, held:]
    B = np.append(np.zeros(held), np.linalg.solve(stiffness, -GRAVITY * np.cos(angle) * o.P[held:]))
    q, zero = np.append(angle, B)[None], np.zeros(1)
    rest = np.zeros_like(q)
    return float(o.stations.values[-1] @ B), fields_along(beam, Motion(zero, q, rest, rest))


@check("A horizontal cantilever bends under its own weight.", seconds=0.2)
def own_weight() -> Iterator[Measurement]:
    """Tip deflection and root moment."""
    text = source("7a")
    for name, shapes in _SOURCES.items():
        tip, fields = _at_rest(_cantilever(0.0, shapes))
        accuracy, moment, exact = _ACCURACY[name], -fields.moment[0, 0], VALUES["7a"]["M0"]
        yield within(f"tip deflection, {name}", -tip, VALUES["7a"]["tip"], "m", accuracy, text, f"tip-{name}")
        # arms shrink by the foreshortening, less than (3/2)(tip slope)² = 1e-5
        yield within(f"root moment, {name}", moment, exact, "N m", 1e-5, text, f"moment-{name}")


@check("Axial weight of the order of the buckling load amplifies the deflection.", seconds=0.2)
def amplification() -> Iterator[Measurement]:
    """Compression 1 and 4 EI/L², tension 4 EI/L²."""
    for axial in ("1", "4", "-4"):
        angle = np.copysign(np.pi / 4, float(axial))
        bending = MASS * GRAVITY * np.sin(np.pi / 4) / abs(float(axial))
        tip, _ = _at_rest(_cantilever(angle, _FEM, bending))
        ratio = -tip * 8.0 * bending / (MASS * GRAVITY * np.cos(angle))
        # order 4 with the geometric stiffness: (1/16)⁴/720
        quantity = f"deflection over the linear one at q L³/EI = {axial}"
        yield within(quantity, ratio, VALUES["7c"][axial], "1", 1e-6, source("7c"), f"a{axial}")


@check("A heavy damped cantilever settles at its static deflection, through the equations that are marched.", 0.5)
def settling() -> Iterator[Measurement]:
    """Held root at 45 degrees up; the weight's geometric stiffness amplifies 1.147 times (q L³/EI = 1)."""
    bending = MASS * GRAVITY * np.sin(np.pi / 4)
    modal, steps = {"modal_damping_ratio": 0.9}, {"scheme": "time-stepping", "free_step": 1e-2}
    cases: tuple[tuple[str, str, dict[str, Any], dict[str, Any], dict[str, Any]], ...] = (
        ("modal", "6 modes", {"method": "modal", "modes": 6}, modal, {}),
        ("fem", "16 elements", {"method": "fem", "modes": 6, "elements": 16}, modal, {}),
        ("nodes", "16 elements in all nodes", _NODES, {"kelvin_voigt": 0.15}, steps),
    )
    for name, text, shapes, damping, solver in cases:
        scenario = _cantilever(
            np.pi / 4,
            shapes,
            bending,
            beam=damping,
            end_time=12.0,
            solver={"output_interval": 0.5, **solver},
        )
        tip = float(simulate(scenario)["deflection"][-1])
        ratio = -tip * 8.0 * bending / (MASS * GRAVITY * np.cos(np.pi / 4))
        quantity = f"final deflection over the linear one, {text}"
        # six modes leave out 3e-6 of the deflection
        yield within(quantity, ratio, VALUES["7c"]["1"], "1", 2e-5, source("7c"), name)


def _falling(**shapes: Any) -> Scenario:
    """The beam of item 4b at the start of its fall, with a station at L/3."""
    return Scenario.from_dict(
        {
            "gravity": GRAVITY,
            "beam": {"area": 1.0, "density": MASS, "youngs_modulus": BENDING, "second_moment": 1.0},
            "contact": {"enabled": False, "point": 1.0 / 3.0},
            "discretization": shapes,
        }
    )


def _tip(o: BeamOperators, B: Array) -> tuple[float, float]:
    """Offset (m) and slope of the tip against the tangent at the root."""
    table, root = o.stations.quadrature, float(o.root_slope @ B)
    slope = np.polynomial.Polynomial.fit(table.points[-6:], table.slopes[-6:] @ B, 5)(1.0)
    return float(o.stations.values[-1] @ B) - root, float(slope) - root


#: accuracies of offset and slope in the tangent and the mean-axis frame: sixty hinged modes leave out up to
#: 2/(3 pi b³) of 1/80 and 1/48, b = 60 pi, clamped ones less; elements are exact at their nodes, and the
#: references have 9 digits
_CHIMNEYS: dict[str, tuple[dict[str, Any], tuple[float, float], tuple[float, float]]] = {
    "6 elements": ({"method": "fem", "modes": 12, "elements": 6}, (4e-9, 1e-8), (4e-9, 1e-8)),
    "12 elements": ({"method": "fem", "modes": 24, "elements": 12}, (4e-9, 1e-8), (4e-9, 1e-8)),
    "60 modes": ({"method": "modal", "modes": 60}, (1e-8, 7e-7), (3e-6, 2e-6)),
}


@check("A pinned beam that falls bends like a chimney: largest moment at a third, m g L cos/27.", seconds=0.2)
def falling_chimney() -> Iterator[Measurement]:
    """Moment by equilibrium, offset and slope of the tip; both frames."""
    angle, text = np.pi / 4, source("4b")
    for k, frame in enumerate(("tangent", "mean-axis")):
        for name, (shapes, *accuracies) in _CHIMNEYS.items():
            offset_accuracy, slope_accuracy = accuracies[k]
            scenario = _falling(frame=frame, **shapes)
            beam = Beam(scenario, build_operators(scenario))
            o, rigid = beam.operators, -1.5 * GRAVITY * np.cos(angle)
            B = np.linalg.solve(o.K, -GRAVITY * np.cos(angle) * o.P - o.S * rigid)
            offset, slope = _tip(o, B)
            stiff = np.append(angle, 1e-6 * B)[None]  # the moment of the undeformed shape
            zero, qdd = np.zeros(1), np.append(rigid, np.zeros_like(B))[None]
            fields = fields_along(beam, Motion(zero, stiff, np.zeros_like(stiff), qdd))
            third = int(np.argmin(np.abs(o.stations.points - 1.0 / 3.0)))
            where, tail = f"{name}, {frame} frame", f"{name.replace(' ', '-')}-{frame}"
            exact, moment = VALUES["4b"], fields.moment[0, third]
            yield Measurement(
                f"moment at L/3, {where}", moment, exact["Mmax"], "N m", 5e-9, text, f"moment-{tail}"
            )
            yield within(f"tip offset, {where}", offset, exact["tip"], "m", offset_accuracy, text, f"tip-{tail}")
            yield within(f"tip slope, {where}", slope, exact["slope"], "1", slope_accuracy, text, f"slope-{tail}")

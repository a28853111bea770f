"""Assumed modes against finite elements: events, motion, forces."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from oblique_impact.validation.checks.registry import Measurement, checks_of, within
from oblique_impact.validation.comparison import compare, largest_difference, pair_events
from oblique_impact.validation.runs import (
    FRICTIONLESS,
    MEAN_AXIS,
    NEAR,
    NEAR_FINE,
    SPRING,
    contact_times,
    run,
)

check = checks_of("discretizations", "Assumed modes against finite elements")

_SIX = ("discretization.frame=mean-axis", "discretization.modes=6", "end_time=0.335")
_ELEMENTS = ("discretization.method=fem", "discretization.elements=64")
_TEXT = "two discretizations of one beam with the same spectral content: order 4 (theory Sec. 6)"


@check("Two modes and three macro-collisions: the same events from modes and from 64 elements.", seconds=1.5)
def events() -> list[Measurement]:
    """Aligned event logs: number of unpaired events, and the largest distance in the first macro-collision."""
    modal, fem = run("paper"), run("paper", *_ELEMENTS)
    pairs = pair_events(modal.events, fem.events)
    unpaired = pairs["time_difference"].isna().sum()
    end = modal.summary["macro_collisions"][0]["end"]
    first = largest_difference(pairs[pairs["left_time"] <= end])
    growth = f"{_TEXT}; each collision multiplies a difference by about 30"
    return [
        Measurement("events without a partner in 1 s", float(unpaired), 0.0, "1", 0.0, _TEXT, "unpaired"),
        # (b_2 h)⁴/1440 = 2e-8 of a period of 2 ms
        Measurement("largest distance, first macro-collision", first, 0.0, "s", 1e-9, _TEXT, "first"),
        Measurement("largest distance in 1 s", largest_difference(pairs), 0.0, "s", 5e-6, growth, "all"),
    ]


@check(
    "Six modes: event times from 32, 64, 128 and 256 elements approach those of the modes at order 4.", seconds=8.0
)
def event_order() -> Iterator[Measurement]:
    """Ratios of the largest differences of successive meshes."""
    reference, meshes = contact_times(run("paper", *_SIX)), (32, 64, 128, 256)
    errors = []
    for elements in meshes:
        history = run("paper", *_SIX, "discretization.method=fem", f"discretization.elements={elements}")
        errors.append(float(np.abs(contact_times(history) - reference).max()))
    for k, (coarse, fine) in enumerate(pairwise(meshes)):
        order, quantity = float(np.log2(errors[k] / errors[k + 1])), f"observed order, {coarse} to {fine} elements"
        yield Measurement(quantity, order, 4.0, "1", 0.1, _TEXT, f"order-{coarse}")
    yield Measurement("largest difference at 128 elements", errors[2], 0.0, "s", 3e-8, _TEXT, "at-128")


@check("A macro-collision on a clock in which its events fall on each other: motion and forces.", seconds=1.5)
def trajectories() -> Iterator[Measurement]:
    """Largest difference of the tip, of theta and of the contact force, two modes, 64 elements."""
    found = compare(run("paper", *NEAR_FINE), run("paper", *NEAR_FINE, *_ELEMENTS))
    allowed = {"tip_x": 1.5e-9, "tip_y": 1.5e-9, "theta": 1.5e-8, "lambda_n": 1e-4, "lambda_tau": 3e-5}
    for name, tolerance in allowed.items():
        largest, unit = abs(found[name].aligned_largest), found[name].unit
        tail = name.replace("_", "-")
        yield Measurement(f"largest difference of {name}", largest, 0.0, unit, tolerance, _TEXT, tail)


@check(
    "Nodal model, reduced to 24 of its modes, and 24 analytic modes on an elastic stop: one collision.",
    seconds=2.0,
)
def nodal_and_modes() -> Iterator[Measurement]:
    """Impulse, peak and first release by the implicit scheme."""
    common = (
        *(SPRING, FRICTIONLESS, MEAN_AXIS),
        "solver.scheme=generalized-alpha",
        "solver.free_step=5e-6",
        "solver.contact_step=2e-6",
        "solver.rho_infinity=0.9",
        "end_time=0.0155",
        *NEAR,
    )
    models = {
        "nodal": ("discretization.method=fem", "discretization.modes=0"),
        "reduced": ("discretization.method=fem", "discretization.modes=24"),
        "modal": ("discretization.modes=24",),
    }
    runs = {name: run("paper", *common, *keys) for name, keys in models.items()}
    text = "the full mesh; 24 modes leave out a compliance of order 1/N³"
    # modes of the same mesh are closer to it than analytic ones
    for name, of_impulse, of_peak, of_release in (("reduced", 8e-6, 3e-5, 4.5e-8), ("modal", 1.5e-5, 2e-3, 9e-8)):
        pair = runs[name], runs["nodal"]
        collisions = [history.summary["macro_collisions"][0] for history in pair]
        impulse, exact_impulse = (collision["normal_impulse"] for collision in collisions)
        peak, exact_peak = (collision["peak_force"] for collision in collisions)
        release, exact_release = (history.events[1].time for history in pair)
        yield within(f"impulse, {name}", impulse, exact_impulse, "N s", of_impulse, text, f"impulse-{name}")
        yield within(f"peak force, {name}", peak, exact_peak, "N", of_peak, text, f"peak-{name}")
        yield Measurement(
            f"first release, {name}", release, exact_release, "s", of_release, text, f"release-{name}"
        )
